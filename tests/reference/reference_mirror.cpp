// What mirrors show.
#include "reference.hpp"

#include <algorithm>
#include <cmath>

using glm::vec3;

namespace {

constexpr float kLiftOfDistance = 1e-4f; // a position of a buffer: depth of 24 bits or more, within a pixel's rounding
constexpr float kLiftOfPosition =
    1e-5f; // a position of a triangle: 2^-22, and the slope of normals against the triangle

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

std::vector<SurfacePoint> surface_points(const ReferenceView& view, const std::vector<float>& z,
                                         const std::vector<float>& normals) {
    const PixelRays rays(view);
    const glm::mat3 to_world = glm::transpose(glm::mat3(view.view));
    const vec3 eye(glm::inverse(glm::dmat4(view.view))[3]);
    std::vector<SurfacePoint> points(view.pixels());
    for (size_t i = 0; i < size_t(view.width) * size_t(view.height); ++i) {
        if (z[i] == 0.0f) { continue; }
        const size_t x = i % size_t(view.width) + size_t(view.guard), y = i / size_t(view.width) + size_t(view.guard);
        const size_t pixel = y * size_t(view.columns()) + x;
        const Ray ray = rays.through(pixel);
        const double from_near = (double(rays.z_of(ray.origin)) - double(z[i])) / rays.depth_along(ray);
        SurfacePoint& point = points[pixel];
        point.position = glm::dvec3(ray.origin) + from_near * glm::dvec3(ray.direction);
        point.normal = to_world * vec3(normals[3 * i], normals[3 * i + 1], normals[3 * i + 2]);
        point.lift = kLiftOfDistance * glm::distance(point.position, eye);
    }
    return points;
}

std::vector<SurfacePoint> surface_points(const std::vector<Surface>& layer) {
    std::vector<SurfacePoint> points;
    for (const Surface& surface : layer) {
        const vec3 size = glm::abs(surface.position);
        const float lift = kLiftOfPosition * std::max({size.x, size.y, size.z, 1.0f});
        points.push_back({surface.position, surface.normal, surface.found() ? lift : 0.0f});
    }
    return points;
}

std::vector<MirrorHit> trace_mirror(const ReferenceScene& scene, const ReferenceView& view,
                                    const std::vector<SurfacePoint>& points, Faces faces) {
    const PixelRays rays(view);
    std::vector<MirrorHit> hits(points.size());
    for_each(points.size(),
             [&](size_t i) { hits[i] = trace(scene, rays, points[i], rays.through(i).direction, faces); });
    return hits;
}
