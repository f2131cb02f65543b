// Animation: where nodes and joints are at a time.
#include "scene.hpp"

#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace {

using glm::mat4;
using glm::quat;
using glm::vec3;
using glm::vec4;

// Times of the animation at which the bounds are taken. Between two of them things hardly leave the bounds.
constexpr int kBoundsSamples = 32;

quat to_quat(vec4 v) { return {v.w, v.x, v.y, v.z}; }
vec4 to_vec4(quat q) { return {q.x, q.y, q.z, q.w}; }

// The shorter way round. slerp itself wants unit quaternions.
vec4 interpolate_linear(vec4 a, vec4 b, float t, AnimatedPart part) {
    if (part != AnimatedPart::rotation) { return glm::mix(a, b, t); }
    return to_vec4(glm::slerp(glm::normalize(to_quat(a)), glm::normalize(to_quat(b)), t));
}

// Hermite's spline from one key's three values to the next one's.
vec4 interpolate_cubic(const vec4* a, const vec4* b, float t, float seconds) {
    const float t2 = t * t, t3 = t2 * t;
    return (2.0f * t3 - 3.0f * t2 + 1.0f) * a[1] + (t3 - 2.0f * t2 + t) * seconds * a[2] +
           (3.0f * t2 - 2.0f * t3) * b[1] + (t3 - t2) * seconds * b[0];
}

// Before the first key its value, after the last one that.
vec4 sample(const Sampler& sampler, AnimatedPart part, float time) {
    const size_t stride = sampler.interpolation == Interpolation::cubic ? 3 : 1, middle = stride / 2;
    const auto after = std::upper_bound(sampler.times.begin(), sampler.times.end(), time);
    const auto next = size_t(after - sampler.times.begin());
    if (next == 0) { return sampler.values[middle]; }
    const vec4* a = &sampler.values[(next - 1) * stride];
    if (after == sampler.times.end() || sampler.interpolation == Interpolation::step) { return a[middle]; }

    const float start = sampler.times[next - 1], seconds = *after - start, t = (time - start) / seconds;
    const vec4* b = a + stride;
    return stride == 3 ? interpolate_cubic(a, b, t, seconds) : interpolate_linear(a[0], b[0], t, part);
}

void animate(const Animation& animation, float time, std::vector<Transform>* transforms) {
    for (const Channel& channel : animation.channels) {
        Transform& transform = (*transforms)[size_t(channel.node)];
        const vec4 value = sample(animation.samplers[size_t(channel.sampler)], channel.part, time);
        switch (channel.part) {
        case AnimatedPart::translation: transform.translation = vec3(value); break;
        case AnimatedPart::rotation: transform.rotation = glm::normalize(to_quat(value)); break;
        case AnimatedPart::scale: transform.scale = vec3(value); break;
        }
    }
}

float time_in_loop(double seconds, double duration) {
    if (duration <= 0.0) { return 0.0f; }
    const double time = std::fmod(seconds, duration);
    return float(time < 0.0 ? time + duration : time);
}

mat4 skin_matrix(const mat4* joints, const Vertex& vertex) {
    mat4 sum(0.0f);
    for (int i = 0; i < 4; ++i) { sum += vertex.weights[i] * joints[vertex.joints[i]]; }
    return sum;
}

// A position that is not a number counts as everywhere: min and max would leave it out.
void grow_bounds(Scene* scene, const Vertex& vertex, const mat4& world) {
    const vec3 position(world * vec4(vertex.position, 1.0f));
    if (glm::any(glm::isnan(position))) {
        scene->bounds_max = vec3(std::numeric_limits<float>::infinity());
        scene->bounds_min = -scene->bounds_max;
    }
    scene->bounds_min = glm::min(scene->bounds_min, position);
    scene->bounds_max = glm::max(scene->bounds_max, position);
}

void grow_bounds(Scene* scene) {
    const Pose now = current_pose(*scene);
    const std::vector<int> first_joints = first_joints_of(*scene);
    for (const Node& node : scene->nodes) {
        const mat4* joints = node.skin < 0 ? nullptr : &now.joints[size_t(first_joints[size_t(node.skin)])];
        for (int mesh : node.meshes) {
            for (const Vertex& vertex : scene->meshes[size_t(mesh)].vertices) {
                grow_bounds(scene, vertex, joints != nullptr ? skin_matrix(joints, vertex) : node.world);
            }
        }
    }
}

} // namespace

mat4 to_matrix(const Transform& transform) {
    return glm::scale(glm::translate(mat4(1.0f), transform.translation) * glm::mat4_cast(transform.rotation),
                      transform.scale);
}

void pose(Scene* scene, double seconds) {
    if (scene->animations.empty()) { return; }
    std::vector<Transform> transforms;
    for (const Node& node : scene->nodes) { transforms.push_back(node.rest.value_or(Transform())); }
    animate(scene->animations[0], time_in_loop(seconds, scene->animations[0].duration), &transforms);
    for (size_t i = 0; i < transforms.size(); ++i) {
        Node& node = scene->nodes[i];
        if (node.rest) { node.local = to_matrix(transforms[i]); }
    }
    update_world_matrices(scene);
}

Pose current_pose(const Scene& scene) {
    Pose now;
    for (const Node& node : scene.nodes) { now.nodes.push_back(node.world); }
    for (const Skin& skin : scene.skins) {
        for (size_t i = 0; i < skin.nodes.size(); ++i) {
            now.joints.push_back(scene.nodes[size_t(skin.nodes[i])].world * skin.inverse_bind[i]);
        }
    }
    return now;
}

std::vector<int> first_joints_of(const Scene& scene) {
    std::vector<int> first(1, 0);
    for (const Skin& skin : scene.skins) { first.push_back(first.back() + int(skin.nodes.size())); }
    return first;
}

void update_bounds(Scene* scene) {
    const bool moves = !scene->animations.empty();
    const int samples = moves ? kBoundsSamples : 1;
    scene->bounds_min = vec3(std::numeric_limits<float>::infinity());
    scene->bounds_max = -scene->bounds_min;
    for (int i = samples; i-- > 0;) { // the first time last: it stays
        if (moves) { pose(scene, double(scene->animations[0].duration) * i / samples); }
        grow_bounds(scene);
    }
}
