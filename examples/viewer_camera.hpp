// The viewer's camera: how it flies and turns, and the path that it took, as a text file.
#pragma once

#include "render_camera.hpp"

#include <glm/glm.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

// ---- Motion ---------------------------------------------------------------------------------------------

constexpr float kSteepest = 1.55f; // radians from the horizon: straight up has no right-hand side

// Yaw counter-clockwise as seen from above, pitch upwards, radians. The result has the length of `offset`, and never points
// straight up or down.
inline glm::vec3 turned(glm::vec3 offset, float yaw, float pitch) {
    const float length = glm::length(offset);
    const float elevation = std::asin(std::clamp(offset.y / length, -1.0f, 1.0f));
    const float up = std::clamp(elevation + pitch, -kSteepest, kSteepest);
    const float around = std::atan2(offset.x, offset.z) + yaw;
    return length * glm::vec3(std::cos(up) * std::sin(around), std::sin(up), std::cos(up) * std::cos(around));
}

// The head turns.
inline void look(RenderCamera* camera, float yaw, float pitch) {
    if (yaw == 0.0f && pitch == 0.0f) { return; } // leaves a rolled camera as it is
    camera->target = camera->eye + turned(camera->target - camera->eye, yaw, pitch);
    camera->up = upright(camera->target - camera->eye);
}

// The eye goes around the target.
inline void circle(RenderCamera* camera, float yaw, float pitch) {
    if (yaw == 0.0f && pitch == 0.0f) { return; }
    camera->eye = camera->target + turned(camera->eye - camera->target, yaw, pitch);
    camera->up = upright(camera->target - camera->eye);
}

// Metres to the right, up (of the world) and ahead.
inline void fly(RenderCamera* camera, glm::vec3 metres) {
    const glm::vec3 forward = glm::normalize(camera->target - camera->eye);
    const glm::vec3 right = glm::normalize(glm::cross(forward, camera->up));
    const glm::vec3 step = metres.x * right + metres.y * glm::vec3(0.0f, 1.0f, 0.0f) + metres.z * forward;
    camera->eye += step;
    camera->target += step;
}

// Widens the planes only when the scene leaves them, and then by a lot: a projection that keeps changing costs history.
inline void keep_scene_in_planes(const Scene& scene, RenderCamera* camera) {
    const float far_plane = camera->far_plane, near_plane = camera->near_plane;
    set_planes(scene, camera);
    const bool fits = camera->far_plane <= far_plane;
    camera->far_plane = fits ? far_plane : 2.0f * camera->far_plane;
    camera->near_plane = near_plane;
}

// ---- Path -----------------------------------------------------------------------------------------------

// One line a key: seconds, eye, target, vertical field of view in degrees. Lines with # in front say nothing.
struct CameraKey {
    double seconds = 0.0;
    glm::vec3 eye{0.0f}, target{0.0f};
    float fov = 60.0f; // degrees
};

using CameraPath = std::vector<CameraKey>; // by time

inline CameraKey key_of(const RenderCamera& camera, double seconds) {
    return {seconds, camera.eye, camera.target, glm::degrees(camera.vertical_fov)};
}

// Straight from key to key. Before the first and after the last it stands still.
inline CameraKey at(const CameraPath& path, double seconds) {
    const auto after = std::find_if(path.begin(), path.end(), [&](const CameraKey& k) { return k.seconds > seconds; });
    if (after == path.begin()) { return path.front(); }
    if (after == path.end()) { return path.back(); }
    const CameraKey &a = *(after - 1), &b = *after;
    const auto share = float((seconds - a.seconds) / (b.seconds - a.seconds));
    return {seconds, glm::mix(a.eye, b.eye, share), glm::mix(a.target, b.target, share), glm::mix(a.fov, b.fov, share)};
}

inline void place(RenderCamera* camera, const CameraKey& key) {
    camera->eye = key.eye;
    camera->target = key.target;
    camera->up = upright(key.target - key.eye);
    camera->vertical_fov = glm::radians(key.fov);
}

inline std::string to_text(const CameraPath& path) {
    std::string text = "# seconds  eye x y z  target x y z  vertical field of view, degrees\n";
    for (const CameraKey& key : path) {
        char line[256];
        std::snprintf(line, sizeof line, "%.9g  %.9g %.9g %.9g  %.9g %.9g %.9g  %.9g\n", key.seconds, double(key.eye.x),
                      double(key.eye.y), double(key.eye.z), double(key.target.x), double(key.target.y),
                      double(key.target.z), double(key.fov));
        text += line;
    }
    return text;
}

inline bool read_key(const std::string& line, CameraKey* key) {
    std::istringstream text(line);
    glm::vec3 &e = key->eye, &t = key->target;
    std::string more;
    const bool read = bool(text >> key->seconds >> e.x >> e.y >> e.z >> t.x >> t.y >> t.z >> key->fov);
    return read && !(text >> more) && e != t && key->fov > 0.0f && key->fov < 180.0f;
}

// Throws std::runtime_error with one sentence.
inline CameraPath read_path(const std::string& file) {
    std::ifstream text(file);
    if (!text) { throw std::runtime_error("cannot read \"" + file + "\""); }
    CameraPath path;
    std::string line;
    for (int number = 1; std::getline(text, line); ++number) {
        CameraKey key;
        if (line.find_first_not_of(" \t\r") == std::string::npos || line[0] == '#') { continue; }
        const bool follows = read_key(line, &key) && (path.empty() || key.seconds > path.back().seconds);
        if (!follows) {
            throw std::runtime_error("\"" + file + "\", line " + std::to_string(number) +
                                     ": must be eight numbers, seconds that grow, eye, target and field of view");
        }
        path.push_back(key);
    }
    if (path.empty()) { throw std::runtime_error("\"" + file + "\" holds no camera"); }
    return path;
}
