// What a command line stands for: a scene, its camera and its lights. All throw std::runtime_error with one sentence.
#pragma once

#include "render_camera.hpp"
#include "render_options.hpp"
#include "scene.hpp"

#include <stdexcept>
#include <string>
#include <vector>

inline const PunctualLight kDefaultSun = sun_light(glm::vec3(0.6f, 0.6f, 0.3f), 6.0f);

inline Scene load_scene(const std::string& path) {
    Scene scene;
    std::string error;
    if (path.empty() || path == "atrium") { return make_atrium(); }
    if (path == "gallery") { return make_gallery(); }
    if (!load_gltf(path, &scene, &error)) { throw std::runtime_error(error); }
    return scene;
}

inline RenderCamera choose_camera(const Options& options, const Scene& scene) {
    RenderCamera camera = options.camera           ? *options.camera
                          : !scene.cameras.empty() ? camera_of_file(scene.cameras[0], scene)
                                                   : framing_camera(scene, options.aspect());
    if (options.ortho_height > 0.0f) { camera.height = options.ortho_height; }
    if (camera.height > 0.0f && options.clip == ClipRange::reversed_infinite) {
        throw std::runtime_error("--clip reversed-infinite needs a perspective camera");
    }
    set_planes(scene, &camera);
    return camera;
}

// Those of the file, or else a sun, and what the command line adds.
inline std::vector<PunctualLight> choose_lights(const Options& options, const Scene& scene) {
    std::vector<PunctualLight> lights = scene.lights;
    if (options.sun || lights.empty()) { lights.push_back(options.sun.value_or(kDefaultSun)); }
    lights.insert(lights.end(), options.points.begin(), options.points.end());
    return lights;
}
