// What mirrors show.
#include "reference.hpp"

using glm::vec3;

namespace {

MirrorHit trace(const ReferenceScene& scene, const PixelRays& rays, const SurfacePoint& point, vec3 seen_along,
                Faces faces) {
    MirrorHit hit;
    hit.direction = glm::reflect(seen_along, point.normal);
    if (point.normal == vec3(0.0f) || dot(hit.direction, point.normal) <= 0.0f) { return hit; }
    const Ray ray{point.position + point.lift * point.normal, hit.direction};
    hit.surface = scene.closest(ray, faces);
    hit.state = hit.surface.found() ? MirrorState::hit : MirrorState::miss;
    if (hit.surface.found()) { hit.surface.z = rays.z_of(hit.surface.position); }
    hit.radiance = hit.surface.found() ? scene.outgoing(hit.surface) : scene.sky(hit.direction);
    return hit;
}

} // namespace

std::vector<MirrorHit> trace_mirror(const ReferenceScene& scene, const ReferenceView& view,
                                    const std::vector<SurfacePoint>& points, Faces faces) {
    const PixelRays rays(view);
    std::vector<MirrorHit> hits(points.size());
    for_each(points.size(),
             [&](size_t i) { hits[i] = trace(scene, rays, points[i], rays.through(i).direction, faces); });
    return hits;
}
