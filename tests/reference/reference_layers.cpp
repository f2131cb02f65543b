// Rays through pixels, and the layers that they meet.
#include "reference.hpp"

#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <thread>

using glm::dmat4;
using glm::dvec2;
using glm::dvec3;
using glm::dvec4;
using glm::vec3;

void for_each(size_t count, const std::function<void(size_t i)>& work) {
    constexpr size_t kShare = 64; // of the work, taken at once
    std::atomic<size_t> next{0};
    const auto take_shares = [&] {
        for (size_t first = next.fetch_add(kShare); first < count; first = next.fetch_add(kShare)) {
            for (size_t i = first; i < std::min(first + kShare, count); ++i) { work(i); }
        }
    };
    std::vector<std::thread> helpers;
    for (unsigned i = 1; i < std::thread::hardware_concurrency(); ++i) { helpers.emplace_back(take_shares); }
    take_shares();
    for (std::thread& helper : helpers) { helper.join(); }
}

// Pixel (guard, guard) is the lower left of the image, and jitter moves what is drawn to the right and up.
PixelRays::PixelRays(const ReferenceView& view) : view_(view.view), columns_(view.columns()) {
    const bool standard = view.clip == ClipRange::standard;
    const double near_depth = standard ? -1.0 : 1.0, far_depth = standard ? 1.0 : 0.0;
    const dvec2 size(view.width, view.height), origin = dvec2(view.guard) + dvec2(view.jitter);
    const dvec2 corner = -2.0 * origin / size - 1.0;
    dmat4 clip_from_pixel = glm::translate(dmat4(1.0), dvec3(corner, near_depth));
    clip_from_pixel = glm::scale(clip_from_pixel, dvec3(2.0 / size, far_depth - near_depth));
    from_pixel_ = glm::inverse(dmat4(view.projection) * view_) * clip_from_pixel;
}

// The far point may be at infinity, where w is 0.
Ray PixelRays::through(dvec2 pixel) const {
    const dvec4 a = from_pixel_ * dvec4(pixel, 0.0, 1.0), b = from_pixel_ * dvec4(pixel, 1.0, 1.0);
    const dvec3 from = dvec3(a) / a.w, path = dvec3(b) * a.w - dvec3(a) * b.w;
    Ray ray;
    ray.origin = from;
    ray.direction = glm::normalize(path);
    const double length = glm::length(path) / std::abs(a.w * b.w);
    if (std::isfinite(length)) { ray.farthest = float(length); }
    return ray;
}

Ray PixelRays::through(size_t pixel) const {
    const size_t column = pixel % size_t(columns_), row = pixel / size_t(columns_);
    return through(dvec2(column, row) + 0.5);
}

double PixelRays::depth_along(const Ray& ray) const { return -(view_ * dvec4(ray.direction, 0.0)).z; }

float PixelRays::z_of(vec3 position) const { return float((view_ * dvec4(position, 1.0)).z); }

namespace {

// The ray goes on where the next layer may begin: strictly behind this one.
void step_behind(const Surface& surface, double separation, double depth_along, Ray* ray) {
    const auto next = float(surface.distance + separation / depth_along);
    ray->nearest = std::nextafter(std::max(next, surface.distance), std::numeric_limits<float>::infinity());
}

} // namespace

std::vector<std::vector<Surface>> trace_layers(const ReferenceScene& scene, const ReferenceView& view, int layers,
                                               float separation) {
    const PixelRays rays(view);
    std::vector<std::vector<Surface>> result(size_t(layers), std::vector<Surface>(view.pixels()));
    for_each(view.pixels(), [&](size_t i) {
        Ray ray = rays.through(i);
        for (std::vector<Surface>& layer : result) {
            Surface surface = scene.closest(ray, Faces::front);
            if (!surface.found()) { break; }
            surface.z = rays.z_of(surface.position);
            step_behind(surface, separation, rays.depth_along(ray), &ray);
            layer[i] = surface;
        }
    });
    return result;
}
