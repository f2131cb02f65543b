#include "estimate.hpp"

#include <glm/gtc/constants.hpp>
#include <glm/gtc/type_ptr.hpp>

#include <algorithm>
#include <cmath>

namespace {

using glm::vec2;
using glm::vec3;

using Layers = std::vector<std::vector<Surface>>;
using Radiance = std::vector<std::vector<vec3>>;

constexpr float kNearestTap = 0.75f; // pixels: nearer ones would land on the shaded pixel itself

struct Tap {
    vec2 direction{0.0f};
    float radius = 0.0f; // share of the reach
};

// The digits of i in base 2, mirrored at the point: 0..1.
float radical_inverse(uint32_t i) {
    float inverse = 0.0f, digit = 0.5f;
    for (; i != 0; i >>= 1u, digit *= 0.5f) { inverse += (i & 1u) != 0 ? digit : 0.0f; }
    return inverse;
}

uint32_t hash(uint32_t x) {
    x = (x ^ (x >> 16u)) * 0x7feb352du;
    x = (x ^ (x >> 15u)) * 0x846ca68bu;
    return x ^ (x >> 16u);
}

float to_unit(uint32_t x) { return float(x >> 8u) / 16777216.0f; }

vec2 direction_of(float turns) {
    return {std::cos(turns * glm::two_pi<float>()), std::sin(turns * glm::two_pi<float>())};
}

// Radius and angle in 0..1 of tap i of n. All spread evenly in both, as the spiral does (area density 1 / radius).
vec2 polar(const EstimateOptions& o, int i, int n, uint32_t seed) {
    const float rank = (float(i) + 0.5f) / float(n);
    switch (o.pattern) {
    case Pattern::hammersley: return {rank, radical_inverse(uint32_t(i))};
    case Pattern::r2: return glm::fract(vec2(0.5f) + float(i + 1) * vec2(0.7548776662f, 0.5698402910f));
    case Pattern::random: {
        const uint32_t a = hash(seed + 2u * uint32_t(i)), b = hash(a + 0x9e3779b9u);
        return {to_unit(a), to_unit(b)};
    }
    case Pattern::spiral: break;
    }
    const int turns = o.turns > 0 ? o.turns : dgb_spiral_turns(n);
    return {rank, glm::fract(rank * float(turns))};
}

Tap tap_of(const EstimateOptions& o, int i, int n, vec2 rotation, uint32_t seed) {
    const vec2 p = polar(o, i, n, seed), d = direction_of(p.y);
    return {vec2(d.x * rotation.x - d.y * rotation.y, d.x * rotation.y + d.y * rotation.x), p.x};
}

class Estimator {
public:
    Estimator(const ReferenceScene& scene, const ReferenceView& view, const Layers& layers, const Radiance& radiance,
              const EstimateOptions& options)
        : scene_(scene), layers_(layers), radiance_(radiance), o_(options), width_(view.columns()),
          height_(view.rows()), diagonal_(std::hypot(float(width_), float(height_))) {
        const glm::mat4 projection = view.projection;
        dgb_camera_from_matrix(glm::value_ptr(projection), width_, height_, DGB_CLIP_NEGATIVE_ONE_TO_ONE, false,
                               &camera_);
    }

    float visibility(int x, int y) const;
    glm::vec4 irradiance(int x, int y) const; // RGB and confidence

private:
    const Surface& at(size_t layer, int x, int y) const {
        return layers_[layer][size_t(y) * size_t(width_) + size_t(x)];
    }
    float reach(const Surface& surface, float radius) const {
        return std::min(dgb_pixels_per_metre(surface.z, &camera_) * radius, diagonal_);
    }
    vec2 rotation(int x, int y) const {
        vec2 r;
        dgb_rotation(dgb_pixel_hash(x, y, o_.frame), glm::value_ptr(r));
        return r;
    }
    // The pixel of tap i; false where it is the shaded one.
    bool place(int i, int n, int x, int y, float reach, glm::ivec2* pixel, bool* inside) const;
    bool is_visible(const Surface& from, const Surface& to) const;

    const ReferenceScene& scene_;
    const Layers& layers_;
    const Radiance& radiance_;
    const EstimateOptions& o_;
    int width_, height_;
    float diagonal_; // pixels
    dgb_camera camera_{};
};

bool Estimator::place(int i, int n, int x, int y, float reach, glm::ivec2* pixel, bool* inside) const {
    const uint32_t seed = hash(uint32_t(y * width_ + x) * 2654435761u + uint32_t(o_.frame));
    const Tap tap = tap_of(o_, i, n, rotation(x, y), seed);
    const vec2 at = vec2(x, y) + 0.5f + std::max(reach * tap.radius, kNearestTap) * tap.direction;
    const vec2 size(width_, height_);
    *inside = at.x >= 0.0f && at.y >= 0.0f && at.x < size.x && at.y < size.y;
    *pixel = glm::ivec2(glm::clamp(at, vec2(0.0f), size - 1.0f));
    return *pixel != glm::ivec2(x, y);
}

// Whether a surface lies in the way, but for the two themselves.
bool Estimator::is_visible(const Surface& from, const Surface& to) const {
    const vec3 way = to.position - from.position;
    const float length = glm::length(way);
    if (!(length > 0.0f)) { return false; }
    Ray ray = leaving(from, way / length);
    ray.farthest = length * (1.0f - 1e-3f);
    return !scene_.occluded(ray);
}

float Estimator::visibility(int x, int y) const {
    const dgb_params& q = o_.params;
    const Surface& here = at(0, x, y);
    const int n = q.ao_samples;
    const float r = q.ao_radius, inverse = 1.0f / (r * r), pixels = reach(here, r);
    float sum = 0.0f;
    for (int i = 0; i < n; ++i) {
        glm::ivec2 pixel;
        bool inside = false;
        if (!place(i, n, x, y, pixels, &pixel, &inside)) { continue; }
        float most = 0.0f;
        for (size_t layer = 0; layer < layers_.size(); ++layer) {
            const Surface& there = at(layer, pixel.x, pixel.y);
            if (!there.found()) { break; }
            const vec3 v = there.position - here.position;
            const float term = dgb_ao_term(glm::value_ptr(v), glm::value_ptr(here.normal), inverse, q.ao_bias * r,
                                           std::max(q.ao_epsilon, 1e-12f) * r * r);
            if (term > most && (!o_.rays || is_visible(here, there))) { most = term; }
        }
        sum += most;
    }
    return dgb_ambient_visibility(sum, n);
}

glm::vec4 Estimator::irradiance(int x, int y) const {
    const dgb_params& q = o_.params;
    const Surface& here = at(0, x, y);
    const int n = q.samples;
    const float pixels = reach(here, q.radius);
    vec3 light(0.0f);
    float cosines = 0.0f;
    int senders = 0, useful = 0;
    for (int i = 0; i < n; ++i) {
        glm::ivec2 pixel;
        bool inside = false;
        if (!place(i, n, x, y, pixels, &pixel, &inside) || !inside) { continue; }
        vec3 brightest(0.0f);
        float best = 0.0f;
        int found = 0;
        for (size_t layer = 0; layer < layers_.size(); ++layer) {
            const Surface& there = at(layer, pixel.x, pixel.y);
            if (!there.found()) { break; }
            const vec3 v = there.position - here.position;
            const float cosine = dgb_gather_term(glm::value_ptr(v), glm::value_ptr(here.normal),
                                                 glm::value_ptr(there.normal), q.radius * q.radius, q.normal_test);
            if (!(cosine > 0.0f) || (o_.rays && !is_visible(here, there))) { continue; }
            const vec3 sent = radiance_[layer][size_t(pixel.y) * size_t(width_) + size_t(pixel.x)] * cosine;
            ++found;
            if (o_.senders == DGB_SENDERS_STRONGEST) {
                const bool brighter = found == 1 || sent.x + sent.y + sent.z > brightest.x + brightest.y + brightest.z;
                if (brighter) {
                    brightest = sent;
                    best = cosine;
                }
            } else {
                light += sent;
                cosines += cosine;
                ++senders;
            }
        }
        useful += found > 0 ? 1 : 0;
        if (o_.senders == DGB_SENDERS_STRONGEST && found > 0) {
            light += brightest;
            cosines += best;
            ++senders;
        }
    }
    const float scale = dgb_gather_scale(cosines, senders, o_.normaliser == DGB_NORMALISER_PAPER ? 0.0f : 1.0f);
    return {light * scale, float(useful) / float(n)};
}

} // namespace

Shading estimate(const ReferenceScene& scene, const ReferenceView& view, const Layers& layers, const Radiance& radiance,
                 const EstimateOptions& options) {
    const Estimator estimator(scene, view, layers, radiance, options);
    Shading result;
    result.visibility.assign(view.pixels(), 0.0f);
    result.irradiance.assign(4 * view.pixels(), 0.0f);
    for_each(size_t(view.rows()), [&](size_t row) {
        const int y = int(row);
        if (y % options.stride != 0) { return; }
        for (int x = 0; x < view.columns(); x += options.stride) {
            const size_t pixel = size_t(y) * size_t(view.columns()) + size_t(x);
            result.visibility[pixel] = layers[0][pixel].found() ? estimator.visibility(x, y) : 1.0f;
            const glm::vec4 light = layers[0][pixel].found() ? estimator.irradiance(x, y) : glm::vec4(0.0f);
            std::copy_n(glm::value_ptr(light), 4, &result.irradiance[4 * pixel]);
        }
    });
    return result;
}

Radiance radiance_of(const ReferenceScene& scene, const Layers& layers) {
    Radiance radiance;
    for (const std::vector<Surface>& layer : layers) {
        std::vector<vec3>& sent = radiance.emplace_back(layer.size(), vec3(0.0f));
        for_each(layer.size(), [&](size_t i) {
            if (layer[i].found()) { sent[i] = scene.outgoing(layer[i]); }
        });
    }
    return radiance;
}
