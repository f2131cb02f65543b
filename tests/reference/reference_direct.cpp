// Light that comes straight from lights and the sky, as the examples have it.
#include "reference.hpp"

#include <glm/gtc/constants.hpp>

#include <algorithm>
#include <cmath>

namespace {

using glm::vec3;

constexpr float kNearest = 0.01f; // metres: nearer to a light, it gets no brighter

// What KHR_lights_punctual recommends: the inverse square in a window that closes at the range, and a cone.
float attenuation(const PunctualLight& light, vec3 to_light, float square) {
    const float share = light.range > 0.0f ? square / (light.range * light.range) : 0.0f;
    const float window = std::clamp(1.0f - share * share, 0.0f, 1.0f);
    if (light.kind != LightKind::spot) { return window / square; }
    const float inner = std::cos(light.inner_cone), outer = std::cos(light.outer_cone);
    const float cone =
        std::clamp((dot(direction_to(light), to_light) - outer) / std::max(0.001f, inner - outer), 0.0f, 1.0f);
    return window * cone * cone / square;
}

} // namespace

vec3 ReferenceScene::irradiance_from(const PunctualLight& light, const Surface& surface) const {
    const bool directional = light.kind == LightKind::directional;
    const vec3 path = vec3(light.world[3]) - surface.position;
    const float square = std::max(dot(path, path), kNearest * kNearest);
    const vec3 to_light = directional ? direction_to(light) : path / std::sqrt(square);
    const float cosine = dot(surface.normal, to_light);
    const float reach = directional ? 1.0f : attenuation(light, to_light, square);
    if (cosine <= 0.0f || reach <= 0.0f) { return vec3(0.0f); }
    Ray shadow = leaving(surface, to_light);
    if (!directional) { shadow.farthest = std::sqrt(square) - kNearest; }
    return occluded(shadow) ? vec3(0.0f) : light.intensity * (reach * cosine);
}

vec3 ReferenceScene::irradiance_of_lights(const Surface& surface) const {
    vec3 sum(0.0f);
    for (const PunctualLight& light : lights_) { sum += irradiance_from(light, surface); }
    return sum;
}

vec3 ReferenceScene::outgoing(const Surface& surface) const {
    if (!surface.front) { return vec3(0.0f); }
    if (!surface.lit) { return surface.emission; }
    return surface.emission + surface.albedo / glm::pi<float>() * irradiance_of_lights(surface);
}

vec3 ReferenceScene::sky(vec3 direction) const {
    return direction.y < 0.0f ? sky_.ground : sky_.horizon + (sky_.zenith - sky_.horizon) * direction.y;
}
