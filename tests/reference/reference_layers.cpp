// Rays through pixels, the layers that they meet, and the points that they show.
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

Ray PixelRays::through(size_t pixel) const { return through(centre(pixel)); }

dvec2 PixelRays::centre(size_t pixel) const {
    const size_t column = pixel % size_t(columns_), row = pixel / size_t(columns_);
    return dvec2(column, row) + 0.5;
}

double PixelRays::depth_along(const Ray& ray) const { return -(view_ * dvec4(ray.direction, 0.0)).z; }

float PixelRays::z_of(vec3 position) const { return float((view_ * dvec4(position, 1.0)).z); }

namespace {

constexpr float kLiftOfDistance = 1e-4f; // a position of a buffer: depth of 24 bits or more, within a pixel's rounding
constexpr float kLiftOfPosition =
    1e-5f; // a position of a triangle: 2^-22, and the slope of normals against the triangle

// The ray goes on where the next layer may begin: strictly behind this one.
void step_behind(const Surface& surface, double separation, double depth_along, Ray* ray) {
    const auto next = float(surface.distance + separation / depth_along);
    ray->nearest = std::nextafter(std::max(next, surface.distance), std::numeric_limits<float>::infinity());
}

} // namespace

void peel(const ReferenceScene& scene, const PixelRays& rays, Ray ray, int layers, float separation,
          const std::function<void(int layer, const Surface& surface)>& visit) {
    for (int layer = 0; layer < layers; ++layer) {
        Surface surface = scene.closest(ray, Faces::front);
        if (!surface.found()) { return; }
        surface.z = rays.z_of(surface.position);
        step_behind(surface, separation, rays.depth_along(ray), &ray);
        visit(layer, surface);
    }
}

std::vector<std::vector<Surface>> trace_layers(const ReferenceScene& scene, const ReferenceView& view, int layers,
                                               float separation) {
    const PixelRays rays(view);
    std::vector<std::vector<Surface>> result(size_t(layers), std::vector<Surface>(view.pixels()));
    for_each(view.pixels(), [&](size_t i) {
        peel(scene, rays, rays.through(i), layers, separation,
             [&](int layer, const Surface& surface) { result[size_t(layer)][i] = surface; });
    });
    return result;
}

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
