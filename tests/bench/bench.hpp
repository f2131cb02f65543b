// What the benchmarks share: views of scenes, a camera that moves, a context that draws, medians, and the main function.
#pragma once

#include "headless.h"
#include "render_camera.hpp"
#include "scene_gpu.hpp"

#include "deepgbuffer.h"
#include "deepgbuffer_gl.h"

#include <glm/gtc/type_ptr.hpp>

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

// ---- Views ----------------------------------------------------------------------------------------------

struct View {
    std::string name;
    Scene scene;
    RenderCamera camera;
};

inline RenderCamera parse_camera(const std::string& text, RenderCamera camera) {
    glm::vec3 &e = camera.eye, &t = camera.target;
    float degrees = 0.0f;
    const int count =
        std::sscanf(text.c_str(), "%f,%f,%f,%f,%f,%f,%f", &e.x, &e.y, &e.z, &t.x, &t.y, &t.z, &degrees); // NOLINT
    if (count != 7) { throw std::runtime_error("a camera is ex,ey,ez,tx,ty,tz,fov: " + text); }
    camera.up = upright(t - e);
    camera.vertical_fov = glm::radians(degrees);
    return camera;
}

// The scene of an argument "file@camera", or the atrium for an empty one.
inline View load_view(const std::string& argument) {
    View view;
    const size_t at = argument.find('@');
    view.name = argument.empty() ? "atrium" : argument.substr(0, at);
    view.name = view.name.substr(view.name.find_last_of('/') + 1);
    std::string error;
    if (argument.empty()) {
        view.scene = make_atrium();
    } else if (!load_gltf(argument.substr(0, at), &view.scene, &error)) {
        throw std::runtime_error(error);
    }
    view.camera = view.scene.cameras.empty() ? framing_camera(view.scene, kAspect)
                                             : camera_of_file(view.scene.cameras[0], view.scene);
    if (at != std::string::npos) { view.camera = parse_camera(argument.substr(at + 1), view.camera); }
    set_planes(view.scene, &view.camera);
    return view;
}

struct Motion {
    float metres;  // that the eye moves in a frame
    float degrees; // that it turns in a frame, root mean square
};

// The eye walks around a circle while its gaze swings to and fro, each in 48 frames: steps of one length in every
// direction, that never go on quite as before, and that do not leave the scene.
inline RenderCamera moved(RenderCamera camera, Motion motion, int frame) {
    constexpr float kFrames = 48.0f, kTurn = 2.0f * glm::pi<float>() / kFrames; // radians of the circle a frame
    const float t = kTurn * float(frame);
    const glm::vec3 forward = camera.target - camera.eye;
    const glm::vec3 ahead = glm::normalize(forward), right = glm::normalize(glm::cross(forward, camera.up));
    const float radius = motion.metres / kTurn;
    const float swing = glm::radians(motion.degrees) * glm::root_two<float>() / kTurn;
    const glm::mat3 turn(glm::rotate(glm::mat4(1.0f), swing * std::sin(t), camera.up));
    camera.eye += radius * (right * (1.0f - std::cos(t)) + ahead * std::sin(t));
    camera.target = camera.eye + turn * forward;
    return camera;
}

inline dgb_view to_dgb_view(const RenderCamera& camera) {
    dgb_view view{};
    const glm::mat4 matrix = view_matrix(camera), projection = projection_matrix(camera, kAspect, ClipRange::standard);
    std::copy_n(glm::value_ptr(matrix), 16, view.view);
    std::copy_n(glm::value_ptr(projection), 16, view.projection);
    return view;
}

// ---- Library --------------------------------------------------------------------------------------------

// A backend and a context. Neither may move: the context points to the backend, both point to `complaint`.
class Library {
public:
    explicit Library(dgb_desc desc) {
        dgbgl_desc gl_desc{};
        gl_desc.get_proc = headless_get_proc;
        gl_desc.no_timers = true; // a timer query may make a tiler flush
        gl_desc.message = [](void* user, const char* text) { static_cast<std::string*>(user)->append(text); };
        gl_desc.message_user = &complaint_;
        check(dgbgl_init(&gl_, &gl_desc));
        desc.backend = &gl_.backend;
        desc.log = [](void* user, dgb_result, dgb_log_item, const char* sentence) {
            static_cast<std::string*>(user)->append(sentence);
        };
        desc.log_user = &complaint_;
        check(dgb_init(&context_, &desc));
    }
    Library(const Library&) = delete;
    Library& operator=(const Library&) = delete;
    ~Library() {
        dgb_shutdown(&context_);
        dgbgl_shutdown(&gl_);
    }

    const dgb_context* context() const { return &context_; }
    GLuint texture(dgb_slot slot) const { return dgbgl_texture_name(dgb_get_texture(&context_, slot)); }

    void build(const dgb_view& view, const dgb_params& params, dgb_draw_fn draw, void* user) {
        check(dgb_build(&context_, &view, &params, draw, user));
    }
    void shade(const dgb_params& params) { check(dgb_shade(&context_, &params)); }

private:
    void check(dgb_result result) const {
        if (result != DGB_OK) { throw std::runtime_error(std::string(dgb_result_name(result)) + ": " + complaint_); }
    }

    std::string complaint_;
    dgbgl_backend gl_{};
    dgb_context context_{};
};

// Calls a function that writes text as snprintf does: once for the length, once for the text.
template <typename Write> std::string text_of(Write write) {
    std::string text(write(nullptr, size_t{0}), '\0');
    write(text.data(), text.size() + 1);
    return text;
}

// A material program for the layers of a context.
inline GlObject make_material_program(const dgb_context* context, const std::vector<dgbgl_varying>& varyings,
                                      const std::string& vertex, const std::string& fragment) {
    const int count = int(varyings.size());
    const auto prefix = [&](dgbgl_stage stage) {
        return text_of([&](char* text, size_t size) {
            return dgbgl_shader_prefix(context, stage, varyings.data(), count, text, size);
        });
    };
    const std::string geometry = text_of(
        [&](char* text, size_t size) { return dgbgl_geometry_shader(context, varyings.data(), count, text, size); });
    GlObject program =
        make_program("material", prefix(DGBGL_VERTEX) + vertex, geometry, prefix(DGBGL_FRAGMENT) + fragment);
    if (dgbgl_attach_program(context, program.name()) != DGB_OK) {
        throw std::runtime_error("the material program lacks the library's text");
    }
    return program;
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
