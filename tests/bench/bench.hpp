// What the benchmarks share: views of scenes, a camera that moves, a context that draws, medians, and the main function.
#pragma once

#include "headless.h"
#include "render_camera.hpp"
#include "scene_gpu.hpp"

#include <malloc.h>
#include <sys/stat.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

constexpr int kWidth = 640, kHeight = 360;
constexpr float kAspect = float(kWidth) / float(kHeight);

// ---- Numbers --------------------------------------------------------------------------------------------

inline double median(std::vector<double> values) {
    if (values.empty()) { return 0.0; }
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}

// Of neighbours in time: what disturbs one disturbs the other as well.
inline double median_ratio(const std::vector<double>& over, const std::vector<double>& under) {
    std::vector<double> ratios;
    for (size_t i = 0; i < over.size(); ++i) { ratios.push_back(over[i] / under[i]); }
    return median(ratios);
}

// RGB from irradiance and confidence, as a composite weighs it: what few taps found counts for little.
inline std::vector<float> weigh(const std::vector<float>& rgba) {
    std::vector<float> rgb;
    for (size_t i = 0; i < rgba.size(); i += 4) {
        for (size_t c = i; c < i + 3; ++c) { rgb.push_back(rgba[c] * rgba[i + 3]); }
    }
    return rgb;
}

// ---- Views ----------------------------------------------------------------------------------------------

// High enough to reach the floor of a court. Irradiance is compared relative to its mean, which must not be close to nothing.
constexpr float kSunDirection[3] = {0.25f, 0.9f, 0.3f};

struct View {
    std::string name;
    Scene scene;
    RenderCamera camera;
    glm::vec3 to_sun{kSunDirection[0], kSunDirection[1], kSunDirection[2]};
};

// ex,ey,ez,tx,ty,tz,fov and, for light through a window, the direction to the sun: ,sx,sy,sz.
inline void parse_camera(const std::string& text, View* view) {
    glm::vec3 e, t, s;
    float degrees = 0.0f;
    const int count = std::sscanf(text.c_str(), "%f,%f,%f,%f,%f,%f,%f,%f,%f,%f", &e.x, &e.y, &e.z, &t.x, // NOLINT
                                  &t.y, &t.z, &degrees, &s.x, &s.y, &s.z);
    if (count != 7 && count != 10) {
        throw std::runtime_error("a camera is ex,ey,ez,tx,ty,tz,fov[,sx,sy,sz]: " + text);
    }
    view->camera.eye = e;
    view->camera.target = t;
    view->camera.up = upright(t - e);
    view->camera.vertical_fov = glm::radians(degrees);
    if (count == 10) { view->to_sun = s; }
}

// The scene of an argument "file@camera", with or without a sun; without a file, the atrium.
inline View load_view(const std::string& argument) {
    View view;
    const size_t at = argument.find('@');
    view.name = at == 0 || argument.empty() ? "atrium" : argument.substr(0, at);
    view.name = view.name.substr(view.name.find_last_of('/') + 1);
    std::string error;
    if (argument.empty() || at == 0) {
        view.scene = make_atrium();
    } else if (!load_gltf(argument.substr(0, at), &view.scene, &error)) {
        throw std::runtime_error(error);
    }
    view.camera = view.scene.cameras.empty() ? framing_camera(view.scene, kAspect)
                                             : camera_of_file(view.scene.cameras[0], view.scene);
    if (at != std::string::npos) { parse_camera(argument.substr(at + 1), &view); }
    set_planes(view.scene, &view.camera);
    return view;
}

// Gives the second view of a scene another name than the first.
inline void tell_from(const std::vector<std::string>& names, std::string* name) {
    const std::string file = *name;
    for (int i = 2; std::count(names.begin(), names.end(), *name) > 0; ++i) { *name = file + " " + std::to_string(i); }
}

struct Motion {
    float metres;  // that the eye moves in a frame, root mean square
    float degrees; // that it turns in a frame, likewise
    bool sideways; // instead of ahead: the worst case, where what is near moves most against what is far
};

// The eye walks to and fro and its gaze swings, at rates that do not go together: every mixture of the two occurs, no step
// goes on quite as the one before, and the eye stays near where it began.
inline RenderCamera moved(RenderCamera camera, Motion motion, int frame) {
    constexpr float kTurn = 2.0f * glm::pi<float>(), kWalk = kTurn / 24.0f, kSwing = kTurn / 34.0f; // radians a frame
    const glm::vec3 forward = camera.target - camera.eye;
    const glm::vec3 ahead = glm::normalize(forward), right = glm::normalize(glm::cross(forward, camera.up));
    const float walked = glm::root_two<float>() * motion.metres / kWalk * std::sin(kWalk * float(frame));
    const float swung =
        glm::root_two<float>() * glm::radians(motion.degrees) / kSwing * std::sin(kSwing * float(frame));
    camera.eye += walked * (motion.sideways ? right : ahead);
    camera.target = camera.eye + glm::mat3(glm::rotate(glm::mat4(1.0f), swung, camera.up)) * forward;
    return camera;
}

// ---- Program --------------------------------------------------------------------------------------------

struct Options {
    bool quick = false;              // fewer frames and rows: less than a minute without scenes
    std::vector<std::string> scenes; // "file@camera"
};

inline Options parse_options(int argc, char** argv) {
    Options options;
    for (int i = 1; i < argc; ++i) {
        if (std::strcmp(argv[i], "--quick") == 0) {
            options.quick = true;
        } else {
            options.scenes.emplace_back(argv[i]);
        }
    }
    return options;
}

struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, CloseFile>;

// A file of results, build/bench/NAME.
inline File result_file(const std::string& name) {
    mkdir("build", 0777);
    mkdir("build/bench", 0777);
    File file(std::fopen(("build/bench/" + name).c_str(), "w"));
    if (!file) { throw std::runtime_error("cannot write build/bench/" + name); }
    return file;
}

// There time on the GPU is time on the processor.
inline bool is_software_rasteriser() {
    return std::strstr(reinterpret_cast<const char*>(glGetString(GL_RENDERER)), "llvmpipe") != nullptr;
}

// A software rasteriser allocates its scene memory each frame: keep it in the process, as a long-running engine would.
inline void steady_memory() {
    mallopt(M_MMAP_THRESHOLD, 32 << 20);
    mallopt(M_TRIM_THRESHOLD, 0x7fffffff);
    mallopt(M_TOP_PAD, 64 << 20);
}

// The main function of a benchmark.
inline int run_benchmark(const char* name, int argc, char** argv, void (*run)(const Options&)) {
    steady_memory();
    headless window{};
    char error[256] = "";
    if (!headless_create(&window, 4, 5, false, false, error, sizeof error)) {
        std::fprintf(stderr, "%s: %s\n", name, error);
        return 1;
    }
    std::printf("%s\n", reinterpret_cast<const char*>(glGetString(GL_RENDERER)));
    int status = 0;
    try {
        run(parse_options(argc, argv));
    } catch (const std::exception& failure) {
        std::fprintf(stderr, "%s: %s\n", name, failure.what());
        status = 1;
    }
    headless_destroy(&window);
    return status;
}
