// Light and shade from all around, by Monte-Carlo integration.
#include "reference.hpp"
#include "reference_random.hpp"

#include <glm/gtc/constants.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace {

using glm::dvec2;
using glm::dvec3;
using glm::dvec4;
using glm::vec3;

constexpr int kBatches = 16;           // an even number, for two halves
constexpr int kCertainBounces = 3;     // of an endless path; from then on it may end
constexpr float kMostSurvival = 0.95f; // or it would never end between white walls

// The mean of sample(at, random) over the unit square. A batch puts one sample into each of side x side equal squares, and
// batches are independent, so that they tell the error.
template <typename T, typename Sample>
Estimate<T> estimate(uint64_t seed, size_t point, int samples, Sample sample) {
    const int side = std::max(1, int(std::ceil(std::sqrt(double(samples) / kBatches))));
    std::array<T, kBatches> means;
    Estimate<T> result;
    for (size_t batch = 0; batch < kBatches; ++batch) {
        Random random(seed, point, batch);
        T sum(0.0);
        for (int i = 0; i < side * side; ++i) {
            const double x = random.uniform(), y = random.uniform();
            sum += sample((dvec2(i % side, i / side) + dvec2(x, y)) / double(side), &random);
        }
        means[batch] = sum / double(side * side);
        result.mean += means[batch] / double(kBatches);
        result.halves[batch % 2] += means[batch] / (0.5 * kBatches);
    }
    T square(0.0);
    for (const T& mean : means) { square += (mean - result.mean) * (mean - result.mean); }
    result.error = glm::sqrt(square / double(kBatches * (kBatches - 1)));
    return result;
}

// In proportion to the cosine with the normal, from a point of the unit square.
vec3 cosine_direction(vec3 normal, dvec2 at) {
    const vec3 other = std::abs(normal.x) < 0.5f ? vec3(1.0f, 0.0f, 0.0f) : vec3(0.0f, 1.0f, 0.0f);
    const vec3 x = glm::normalize(cross(other, normal)), y = cross(normal, x);
    const double radius = std::sqrt(at.x), angle = glm::two_pi<double>() * at.y;
    const auto s = float(radius * std::cos(angle)), t = float(radius * std::sin(angle));
    return glm::normalize(s * x + t * y + float(std::sqrt(1.0 - at.x)) * normal);
}

Ray ray_from(const SurfacePoint& point, vec3 direction, float radius) {
    return {point.position + point.lift * point.normal, direction, 0.0f, radius};
}

bool is_there(const SurfacePoint& point) { return point.normal != vec3(0.0f); }

// The radiance that arrives along a ray that has met a surface; may draw further bounces.
vec3 arriving(const ReferenceScene& scene, Surface surface, const IrradianceOptions& options, Random* random) {
    vec3 light(0.0f), share(1.0f);
    for (int bounce = 1;; ++bounce) {
        light += share * scene.outgoing(surface);
        if (bounce == options.bounces || !surface.front || !surface.lit) { return light; }
        share *= surface.albedo;
        if (options.bounces == kEndless && bounce > kCertainBounces) {
            const float survival = std::min(kMostSurvival, std::max({share.x, share.y, share.z}));
            if (float(random->uniform()) >= survival) { return light; }
            share /= survival;
        }
        const double x = random->uniform(), y = random->uniform();
        Ray ray = leaving(surface, cosine_direction(surface.normal, {x, y}));
        ray.farthest = options.radius;
        surface = scene.closest(ray, Faces::both);
        if (!surface.found()) { return light + (options.sky ? share * scene.sky(ray.direction) : vec3(0.0f)); }
    }
}

// Of the point at offset v, to one with a normal. Paper, Equation 2.
double obscurance(dvec3 v, dvec3 normal, const ObscuranceOptions& options) {
    const double square = dot(v, v), radius = options.radius;
    const double fade = std::max(1.0 - square / (radius * radius), 0.0);
    return fade * std::max((dot(v, normal) - double(options.beta)) / std::sqrt(square + double(options.epsilon)), 0.0);
}

double pixels_per_metre(const ReferenceView& view, double z) {
    const glm::mat4& p = view.projection;
    return 0.5 * view.height * double(p[1][1]) / (double(p[2][3]) * z + double(p[3][3]));
}

} // namespace

std::vector<Estimate<dvec2>> trace_occlusion(const ReferenceScene& scene, const std::vector<SurfacePoint>& points,
                                             float radius, int samples, uint64_t seed) {
    std::vector<Estimate<dvec2>> result(points.size());
    for_each(points.size(), [&](size_t i) {
        if (!is_there(points[i])) { return; }
        result[i] = estimate<dvec2>(seed, i, samples, [&](dvec2 at, Random*) {
            const Ray ray = ray_from(points[i], cosine_direction(points[i].normal, at), radius);
            const double share = double(scene.distance(ray, Faces::both)) / double(radius);
            return std::isinf(share) || std::isnan(share) ? dvec2(1.0) : dvec2(0.0, share * share);
        });
    });
    return result;
}

std::vector<Estimate<double>> trace_obscurance(const ReferenceScene& scene, const ReferenceView& view,
                                               const std::vector<SurfacePoint>& points,
                                               const ObscuranceOptions& options, int samples, uint64_t seed) {
    const PixelRays rays(view);
    std::vector<Estimate<double>> result(points.size());
    for_each(points.size(), [&](size_t i) {
        if (!is_there(points[i])) { return; }
        const dvec3 x(points[i].position), normal(points[i].normal);
        const double reach = double(options.radius) * pixels_per_metre(view, rays.z_of(points[i].position)); // pixels
        result[i] = estimate<double>(seed, i, samples, [&](dvec2 at, Random*) {
            const double angle = glm::two_pi<double>() * at.y;
            const dvec2 tap = rays.centre(i) + reach * at.x * dvec2(std::cos(angle), std::sin(angle));
            double most = 0.0;
            peel(scene, rays, rays.through(tap), options.layers, options.separation, [&](int, const Surface& surface) {
                most = std::max(most, obscurance(dvec3(surface.position) - x, normal, options));
            });
            return glm::pi<double>() * most;
        });
    });
    return result;
}

std::vector<Estimate<dvec4>> trace_irradiance(const ReferenceScene& scene, const std::vector<SurfacePoint>& points,
                                              const IrradianceOptions& options, int samples, uint64_t seed) {
    std::vector<Estimate<dvec4>> result(points.size());
    for_each(points.size(), [&](size_t i) {
        if (!is_there(points[i])) { return; }
        result[i] = estimate<dvec4>(seed, i, samples, [&](dvec2 at, Random* random) {
            const Ray ray = ray_from(points[i], cosine_direction(points[i].normal, at), options.radius);
            const Surface surface = scene.closest(ray, Faces::both);
            if (!surface.found()) {
                return options.sky ? glm::pi<double>() * dvec4(scene.sky(ray.direction), 0.0) : dvec4(0.0);
            }
            return dvec4(glm::pi<double>() * dvec3(arriving(scene, surface, options, random)), 1.0);
        });
    });
    return result;
}
