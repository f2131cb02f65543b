// The camera of a picture: where it stands, and the matrices it gives.
#pragma once

#include "scene.hpp"

#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <cmath>

enum class ClipRange { standard, reversed, reversed_infinite };

struct RenderCamera {
    glm::vec3 eye{0.0f};
    glm::vec3 target{0.0f, 0.0f, -1.0f}; // what it turns around
    glm::vec3 up{0.0f, 1.0f, 0.0f};
    float vertical_fov = 1.0f; // radians, unused if orthographic
    float height = 0.0f;       // of what an orthographic camera sees, metres; 0: perspective
    float near_plane = 0.05f;
    float far_plane = 100.0f;
};

// An up direction for a camera that was told only where to look.
inline glm::vec3 upright(glm::vec3 forward) {
    const bool vertical = std::abs(glm::normalize(forward).y) > 0.999f;
    return vertical ? glm::vec3(0.0f, 0.0f, -1.0f) : glm::vec3(0.0f, 1.0f, 0.0f);
}

// From the front right and a little above, far enough away to see all of the scene's bounding sphere.
inline RenderCamera framing_camera(const Scene& scene, float aspect) {
    const glm::vec3 center = 0.5f * (scene.bounds_min + scene.bounds_max);
    const float radius = 0.5f * glm::length(scene.bounds_max - scene.bounds_min);
    RenderCamera camera;
    camera.vertical_fov = glm::radians(45.0f);
    const float tangent = std::tan(0.5f * camera.vertical_fov) * std::min(aspect, 1.0f);
    const float distance = std::max(radius, 1e-3f) / std::sin(std::atan(tangent));
    camera.target = center;
    camera.eye = center + distance * glm::normalize(glm::vec3(0.6f, 0.4f, 1.0f));
    return camera;
}

// A camera of the file names no target. Takes the point on its axis nearest to the middle of the scene, if
// that is ahead.
inline RenderCamera camera_of_file(const Camera& source, const Scene& scene) {
    const glm::vec3 forward = -glm::normalize(glm::vec3(source.world[2]));
    const glm::vec3 center = 0.5f * (scene.bounds_min + scene.bounds_max);
    RenderCamera camera;
    camera.eye = glm::vec3(source.world[3]);
    camera.target = camera.eye + forward * std::max(glm::dot(center - camera.eye, forward), 1.0f);
    camera.up = glm::normalize(glm::vec3(source.world[1]));
    camera.vertical_fov = source.vertical_fov;
    camera.height = source.orthographic ? 2.0f * source.half_height : 0.0f;
    return camera;
}

// Planes that hold the scene from wherever an orbit takes the eye.
inline void set_planes(const Scene& scene, RenderCamera* camera) {
    const glm::vec3 center = 0.5f * (scene.bounds_min + scene.bounds_max);
    const float radius = 0.5f * glm::length(scene.bounds_max - scene.bounds_min);
    const float reach = glm::distance(camera->eye, camera->target) + glm::distance(camera->target, center) + radius;
    camera->near_plane = std::min(0.05f, 1e-3f * reach);
    camera->far_plane = 1.01f * reach;
}

// Counter-clockwise as seen from above.
inline RenderCamera orbit(RenderCamera camera, float degrees) {
    const glm::mat3 turn(glm::rotate(glm::mat4(1.0f), glm::radians(degrees), glm::vec3(0.0f, 1.0f, 0.0f)));
    camera.eye = camera.target + turn * (camera.eye - camera.target);
    camera.up = turn * camera.up;
    return camera;
}

inline glm::mat4 view_matrix(const RenderCamera& camera) { return glm::lookAt(camera.eye, camera.target, camera.up); }

// Reversing swaps the planes. With the far one at infinity, the third row becomes 0, 0, 0, near.
inline glm::mat4 projection_matrix(const RenderCamera& camera, float aspect, ClipRange clip) {
    const float near_plane = camera.near_plane, far_plane = camera.far_plane;
    if (camera.height > 0.0f) {
        const float top = 0.5f * camera.height, right = top * aspect;
        return clip == ClipRange::standard ? glm::orthoRH_NO(-right, right, -top, top, near_plane, far_plane)
                                           : glm::orthoRH_ZO(-right, right, -top, top, far_plane, near_plane);
    }
    if (clip == ClipRange::standard) {
        return glm::perspectiveRH_NO(camera.vertical_fov, aspect, near_plane, far_plane);
    }
    glm::mat4 projection = glm::perspectiveRH_ZO(camera.vertical_fov, aspect, far_plane, near_plane);
    if (clip == ClipRange::reversed_infinite) {
        projection[2][2] = 0.0f;
        projection[3][2] = near_plane;
    }
    return projection;
}
