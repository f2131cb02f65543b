#include "scene_probe.hpp"

namespace {

using glm::vec3;

// Of each polynomial: its square over the sphere has the mean 1 / this.
constexpr double kSquareNorm[9] = {1.0, 3.0, 3.0, 3.0, 15.0, 15.0, 1.25, 15.0, 3.75};

// What a cosine lobe leaves of orders 0, 1 and 2, over pi.
constexpr double kLobe[9] = {1.0, 2.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0, 0.25, 0.25, 0.25, 0.25, 0.25};

std::array<double, 9> polynomials(glm::dvec3 d) {
    return {1.0, d.y, d.z, d.x, d.x * d.y, d.y * d.z, 3.0 * d.y * d.y - 1.0, d.x * d.z, d.z * d.z - d.x * d.x};
}

} // namespace

Sky uniform_sky(vec3 radiance) { return {radiance, radiance, radiance}; }

// Of a gradient, what faces the zenith gets pi (horizon / 3 + zenith 2 / 3).
Sky gradient_sky(vec3 radiance) { return {0.75f * radiance, 1.5f * radiance, 0.3f * radiance}; }

// The integrals over the gradient's polynomials in y, solved.
Probe probe_of(const Sky& sky) {
    const vec3 rise = sky.zenith - sky.horizon;
    Probe probe{};
    probe[0] = 0.5f * (sky.ground + sky.horizon + 0.5f * rise);
    probe[1] = 0.5f * (sky.horizon - sky.ground) + rise / 3.0f;
    probe[6] = 5.0f / 128.0f * rise;
    return probe;
}

void ProbeSum::add(vec3 direction, vec3 radiance, float solid_angle) {
    const std::array<double, 9> values = polynomials(direction);
    for (size_t i = 0; i < sums_.size(); ++i) { sums_[i] += values[i] * double(solid_angle) * glm::dvec3(radiance); }
    solid_angle_ += double(solid_angle);
}

Probe ProbeSum::probe() const {
    Probe probe{};
    for (size_t i = 0; i < sums_.size(); ++i) { probe[i] = vec3(kLobe[i] * kSquareNorm[i] / solid_angle_ * sums_[i]); }
    return probe;
}
