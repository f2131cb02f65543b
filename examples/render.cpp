// Renders a scene without a window and writes pictures of what a second layer does to it.
//     render [SCENE] --out DIR      everything else: render --help
// Every failure is one sentence on the standard error output and exit code 2; then no file has been written.
#define DEEPGBUFFER_IMPLEMENTATION
#include "deepgbuffer.h"
#include "deepgbuffer_gl.h"

#include "headless.h"
#include "image.hpp"
#include "program.hpp"
#include "render_camera.hpp"
#include "render_options.hpp"
#include "render_pictures.hpp"
#include "render_report.hpp"
#include "render_scene.hpp"
#include "scene.hpp"
#include "scene_bake.hpp"
#include "scene_renderer.hpp"

#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <stdexcept>
#include <system_error>

namespace {

namespace fs = std::filesystem;
using namespace render_pictures;
using glm::vec3;
using Picture = SceneRenderer::Picture;

// ---- OpenGL context -------------------------------------------------------------------------------------

struct Context {
    headless handle{};

    Context() = default;
    Context(const Context&) = delete;
    Context& operator=(const Context&) = delete;
    ~Context() { headless_destroy(&handle); }
};

// Debug contexts are slower, so only an environment variable asks for one.
bool wants_debug_context() { return std::getenv("RENDER_GL_DEBUG") != nullptr; }

void print_gl_message(GLenum, GLenum, GLuint, GLenum severity, GLsizei, const GLchar* message, const void*) {
    if (severity != GL_DEBUG_SEVERITY_NOTIFICATION) { std::fprintf(stderr, "OpenGL: %s\n", message); }
}

void open_context(Context* context) {
    char error[256] = "";
    const bool debug = wants_debug_context();
    const bool opened = headless_create(&context->handle, 4, 5, false, debug, error, sizeof error) ||
                        headless_create(&context->handle, 3, 3, false, debug, error, sizeof error);
    if (!opened) { throw std::runtime_error(std::string("no OpenGL 3.3 context: ") + error); }
    if (debug && (epoxy_gl_version() >= 43 || epoxy_has_gl_extension("GL_KHR_debug"))) {
        glEnable(GL_DEBUG_OUTPUT);
        glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
        glDebugMessageCallback(print_gl_message, nullptr);
    }
}

// ---- Input ----------------------------------------------------------------------------------------------

dgb_plan make_plan(const dgb_desc& desc) {
    dgb_desc checked = desc;
    checked.log = [](void* user, dgb_result, dgb_log_item, const char* sentence) {
        *static_cast<std::string*>(user) = sentence;
    };
    std::string complaint;
    checked.log_user = &complaint;
    dgb_plan plan{};
    if (dgb_make_plan(&checked, &plan) != DGB_OK) { throw std::runtime_error(complaint); }
    return plan;
}

// ---- Output ---------------------------------------------------------------------------------------------

void check_outputs(const Options& options) {
    std::error_code error;
    for (const Dump& dump : options.dumps) { check_file(dump.file); }
    if (!options.json.empty()) { check_file(options.json); }
    if (!options.out.empty() && fs::exists(options.out, error) && !fs::is_directory(options.out, error)) {
        throw std::runtime_error("\"" + options.out + "\" is not a directory");
    }
}

void make_directory(const std::string& path) {
    std::error_code error;
    fs::create_directories(path, error);
    require_written(!error, path);
}

// ---- One layer against two ------------------------------------------------------------------------------

bool ao_differs(float a, float b) { return std::abs(a - b) > 0.05f; }

// By more than a tenth of the larger one. Below 1e-4 W/m2 there is nothing to see.
bool irradiance_differs(float a, float b) {
    const float larger = std::max(a, b);
    return larger >= 1e-4f && std::abs(a - b) > 0.1f * larger;
}

// Share of the pixels with a surface where `differs` says so of pixel i, percent.
double share(const Floats& z, const std::function<bool(size_t)>& differs) {
    size_t surfaces = 0, changed = 0;
    for (size_t i = 0; i < z.size(); ++i) {
        if (z[i] == 0.0f) { continue; }
        ++surfaces;
        if (differs(i)) { ++changed; }
    }
    return surfaces == 0 ? 0.0 : 100.0 * double(changed) / double(surfaces);
}

// Empty without effects.
std::string difference(const SceneRenderer& one, const SceneRenderer& two, uint32_t effects) {
    const Floats z = two.read_z(0);
    std::string text;
    if ((effects & DGB_EFFECT_AO) != 0) {
        const Floats a = one.read_texture(DGB_AO, 0, GL_RED), b = two.read_texture(DGB_AO, 0, GL_RED);
        const double percent = share(z, [&](size_t i) { return ao_differs(a[i], b[i]); });
        text += render_report::print(" ao changes by more than 0.05 in %.2f %% of the pixels", percent);
    }
    if ((effects & DGB_EFFECT_RADIOSITY) != 0) {
        const Floats a = one.read_texture(DGB_IRRADIANCE, 0, GL_RGB), b = two.read_texture(DGB_IRRADIANCE, 0, GL_RGB);
        const double percent =
            share(z, [&](size_t i) { return irradiance_differs(luminance(&a[3 * i]), luminance(&b[3 * i])); });
        text += text.empty() ? "" : ",";
        text += render_report::print(" irradiance by more than 10 %% in %.2f %%", percent);
    }
    return text.empty() ? "" : "one layer against two:" + text + "\n";
}

// ---- A run ----------------------------------------------------------------------------------------------

void show_progress(int frame, int frames) {
    if (isatty(STDERR_FILENO) == 0) { return; }
    std::fprintf(stderr, "\rframe %d of %d%s", frame, frames, frame == frames ? "\n" : "");
}

class Run {
public:
    explicit Run(const Options& options);

    void render_frames();
    void write_files();

private:
    RendererDesc renderer_desc(const dgb_desc& layers, PassTimes* times) const;
    std::shared_ptr<const GpuPose> pose_at(int frame);
    Probe bake();
    SceneFrame frame_at(int frame, bool with_next);
    void render_frame(SceneRenderer* renderer, int number, const SceneFrame& frame, PassTimes* times);
    bool has(uint32_t effects) const { return (options_.effects & effects) == effects; }
    const SceneRenderer& with_one() const { return options_.layers > 1 ? *other_ : *renderer_; }
    const SceneRenderer& with_two() const { return options_.layers > 1 ? *renderer_ : *other_; }
    SceneRenderer& with_two() { return options_.layers > 1 ? *renderer_ : *other_; }
    Rgb tone_mapped(const Floats& linear) const;
    Rgb visibility(const SceneRenderer& renderer) const;
    void write_grid(const char* name, const std::vector<LabelledPicture>& pictures, int columns) const;
    void write_picture(const char* name, const Rgb& rgb) const;
    void write_pictures(const Rgb& final_rgb);
    void write_pair(const char* name, const Rgb& one, const Rgb& two) const;
    void write_fallback();
    dgb_params many_taps(dgb_params params) const;
    void write_second_alone();
    void write_bounces();
    void bounce(SceneRenderer* renderer, int bounces);
    void append_brightened(std::vector<LabelledPicture>* pictures, const std::vector<LabelledFloats>& lights) const;
    RunReport report(const Rgb& final_rgb) const;

    Options options_;
    Scene scene_;
    RenderCamera camera_;
    Context context_; // before everything that lives in it
    PassTimes times_, unread_times_;
    std::optional<GpuScene> gpu_scene_;
    std::optional<SceneLights> lights_;
    Sky sky_;
    Probe probe_{};
    // The second one has one layer where the first has more, and two where the first has one.
    std::optional<SceneRenderer> renderer_, other_;
};

dgb_desc other_desc(dgb_desc desc) {
    desc.layers = desc.layers == 1 ? 2 : 1;
    desc.oracle = DGB_ORACLE_PEEL;
    desc.emission = DGB_EMISSION_AUTO;
    return desc;
}

Run::Run(const Options& options)
    : options_(options), scene_(load_scene(options.scene)), camera_(choose_camera(options, scene_)),
      times_(options.profile), unread_times_(false) {
    open_context(&context_);
    gpu_scene_.emplace(scene_);
    lights_.emplace(scene_, *gpu_scene_, choose_lights(options, scene_));
    sky_ = options.probe == ProbeKind::sky ? gradient_sky(options.sky) : uniform_sky(options.sky);
    probe_ = options.probe == ProbeKind::cube ? bake() : probe_of(sky_);
    renderer_.emplace(renderer_desc(layers_desc(options), &times_));
    other_.emplace(renderer_desc(other_desc(layers_desc(options)), &unread_times_));
}

RendererDesc Run::renderer_desc(const dgb_desc& layers, PassTimes* times) const {
    RendererDesc desc;
    desc.get_proc = headless_get_proc;
    desc.layers = layers;
    desc.scene = &*gpu_scene_;
    desc.lights = &*lights_;
    desc.sky = sky_;
    desc.probe = probe_;
    desc.roughness = options_.roughness;
    desc.times = times;
    return desc;
}

std::shared_ptr<const GpuPose> Run::pose_at(int frame) {
    if (scene_.animations.empty()) { return gpu_scene_->first_pose(); }
    pose(&scene_, options_.time + frame / options_.fps);
    return std::make_shared<GpuPose>(current_pose(scene_));
}

// At the eye, where the pictures are taken from: the middle of the scene may lie in a wall.
Probe Run::bake() {
    const std::shared_ptr<const GpuPose> pose = pose_at(0);
    lights_->update(*pose);
    return bake_probe(renderer_desc({}, &unread_times_), pose, camera_.eye, camera_.near_plane, camera_.far_plane);
}

// The future is known: the orbit and the animation just go on.
SceneFrame Run::frame_at(int frame, bool with_next) {
    const auto camera_at = [&](int i) { return orbit(camera_, float(i) * options_.orbit); };
    SceneFrame result;
    result.view = view_matrix(camera_at(frame));
    result.projection = projection_matrix(camera_at(frame), options_.aspect(), options_.clip);
    result.pose = pose_at(frame);
    if (with_next) {
        result.next_view = view_matrix(camera_at(frame + 1));
        result.next_pose = pose_at(frame + 1);
    }
    return result;
}

void Run::render_frame(SceneRenderer* renderer, int number, const SceneFrame& frame, PassTimes* times) {
    const dgb_params params = options_.params_of(number);
    renderer->build(frame, params);
    times->begin();
    if (lights_->update(renderer->drawn_pose())) { times->end("shadow"); }
    renderer->shade(params);
}

void Run::render_frames() {
    for (int frame = 0; frame < options_.frames; ++frame) {
        show_progress(frame + 1, options_.frames);
        render_frame(&*renderer_, frame, frame_at(frame, options_.oracle == DGB_ORACLE_PREDICT), &times_);
    }
    // peeled, which is exact; every frame again, for the light of the frames before
    for (int frame = 0; frame < options_.frames; ++frame) {
        const int shown = std::min(frame, options_.frame_drawn());
        render_frame(&*other_, frame, frame_at(shown, false), &unread_times_);
    }
    check_gl();
}

Rgb Run::tone_mapped(const Floats& linear) const {
    const float scale = std::exp2(options_.exposure);
    return to_rgb(linear, options_.width, options_.height, [=](float x) { return srgb(filmic(scale * x)); });
}

Rgb Run::visibility(const SceneRenderer& renderer) const {
    const Floats open(size_t(options_.width) * size_t(options_.height), 1.0f);
    return to_rgb(has(DGB_EFFECT_AO) ? dump_pixels(renderer, "ao") : open, options_.width, options_.height,
                  [](float x) { return x; });
}

void Run::write_grid(const char* name, const std::vector<LabelledPicture>& pictures, int columns) const {
    const std::string path = (fs::path(options_.out) / (std::string(name) + ".png")).string();
    const int width = options_.width, height = options_.height, rows = int(pictures.size()) / columns;
    const Rgb grid = picture_grid(pictures, columns, width, height);
    require_written(write_png(path, columns * width, rows * height, grid), path);
}

void Run::write_picture(const char* name, const Rgb& rgb) const {
    const std::string path = (fs::path(options_.out) / (std::string(name) + ".png")).string();
    require_written(write_png(path, options_.width, options_.height, rgb), path);
}

void Run::write_pictures(const Rgb& final_rgb) {
    const int width = options_.width, height = options_.height;
    const auto albedo = [&](const SceneRenderer& renderer, int layer) {
        return to_rgb(layer_colors(renderer, DGB_ALBEDO, layer), width, height, srgb);
    };
    write_picture("final", final_rgb);
    write_picture("direct", tone_mapped(renderer_->read_picture(Picture::direct)));
    write_picture("ambient_visibility", visibility(*renderer_));
    write_picture("indirect", tone_mapped(renderer_->read_picture(Picture::indirect)));
    write_picture("layer0", albedo(*renderer_, 0));
    write_picture("layer1", albedo(with_two(), 1));
    write_pair("one_vs_two", tone_mapped(with_one().read_picture(Picture::final)),
               tone_mapped(with_two().read_picture(Picture::final)));
    write_pair("indirect_one_vs_two", tone_mapped(with_one().read_picture(Picture::indirect)),
               tone_mapped(with_two().read_picture(Picture::indirect)));
    if (has(DGB_EFFECT_AO)) { write_pair("visibility_one_vs_two", visibility(with_one()), visibility(with_two())); }

    if (!has(DGB_EFFECT_RADIOSITY)) { return; }
    write_picture("confidence", confidence_view(*renderer_, width, height));
    write_fallback();
    if (has(DGB_EFFECT_AO)) {
        // the first frame has none before it, from which anything could be missing
        const Rgb plain = tone_mapped(with_two().read_picture(Picture::final));
        write_picture("disocclusion",
                      options_.frames > 1 ? disocclusion_view(with_two(), plain, width, height) : greyed(plain));
    }
    if (!options_.compared_bounces.empty()) { write_bounces(); }
    write_second_alone();
}

void Run::write_pair(const char* name, const Rgb& one, const Rgb& two) const {
    write_grid(name, {{one, "one layer"}, {two, "two layers"}}, 2);
}

// Paper, Figure 9: what confidence makes of the probe's light and of the gathered light, and what it is better than.
void Run::write_fallback() {
    const auto indirect = [&](std::optional<float> confidence) {
        renderer_->composite(confidence);
        return tone_mapped(renderer_->read_picture(Picture::indirect));
    };
    write_grid("fallback",
               {{indirect(0.0f), "probe alone"},
                {indirect(1.0f), "gathered light alone"},
                {indirect(std::nullopt), "blended by confidence"},
                {indirect(0.5f), "average"}},
               4);
    renderer_->composite();
}

// For a frame that no history helps: the taps of all frames.
dgb_params Run::many_taps(dgb_params params) const {
    params.samples = std::min(params.samples * options_.frames, DGB_MAX_TAPS);
    params.ao_samples = std::min(params.ao_samples * options_.frames, DGB_MAX_TAPS);
    return params;
}

// Last of all, for it shades the layers again.
void Run::write_second_alone() {
    dgb_params alone = many_taps(options_.params_of(options_.frames - 1));
    alone.second_alone = true;
    alone.history_weight = 0.0f;

    std::vector<LabelledPicture> pictures;
    std::vector<LabelledFloats> lights;
    const auto add = [&](const SceneRenderer& renderer, const std::string& layers) {
        if (has(DGB_EFFECT_AO)) { pictures.push_back({visibility(renderer), "ambient visibility, " + layers}); }
        lights.push_back({radiosity(renderer), layers});
    };
    add(with_two(), "both layers");
    add(with_one(), "first layer only");
    with_two().shade_again(alone);
    add(with_two(), "second layer only");
    append_brightened(&pictures, lights);
    write_grid("second_alone", pictures, 3);
}

// Paper, Figure 4, and below it what the bounces add.
void Run::write_bounces() {
    std::vector<LabelledPicture> pictures;
    std::vector<LabelledFloats> lights;
    for (const int bounces : options_.compared_bounces) {
        SceneRenderer renderer(renderer_desc(layers_desc(options_), &unread_times_)); // without a past
        bounce(&renderer, bounces);
        const std::string label = std::to_string(bounces) + (bounces == 1 ? " bounce" : " bounces");
        pictures.push_back({tone_mapped(renderer.read_picture(Picture::final)), label});
        lights.push_back({radiosity(renderer), label});
    }
    append_brightened(&pictures, lights);
    write_grid("bounces", pictures, int(lights.size()));
}

// The last frame so many times, so that light bounces as often.
void Run::bounce(SceneRenderer* renderer, int bounces) {
    Options still = options_;
    still.frames = bounces;
    still.bounces = bounces;
    const SceneFrame frame = frame_at(options_.frame_drawn(), false);
    lights_->update(*frame.pose);
    for (int i = 0; i < bounces; ++i) {
        show_progress(i + 1, bounces);
        const dgb_params params = still.params_of(i);
        const bool last = i + 1 == bounces, remembers = i > 0 && params.history_weight > 0.0f;
        renderer->build(frame, params);
        renderer->shade(last && !remembers ? many_taps(params) : params);
    }
}

// All by the factor that the brightest one bears.
void Run::append_brightened(std::vector<LabelledPicture>* pictures, const std::vector<LabelledFloats>& lights) const {
    float scale = 1024.0f;
    for (const LabelledFloats& light : lights) { scale = std::min(scale, brightening(light.pixels)); }
    for (const LabelledFloats& light : lights) {
        Floats pixels = light.pixels;
        for (float& value : pixels) { value *= scale; }
        pictures->push_back(
            {tone_mapped(pixels), render_report::print("radiosity x %.0f, ", double(scale)) + light.label});
    }
}

RunReport Run::report(const Rgb& final_rgb) const {
    RunReport report;
    report.gl_renderer = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
    report.desc = layers_desc(options_);
    report.plan = renderer_->plan();
    report.build = renderer_->draw_counts();
    report.vertices_shaded = renderer_->vertices_shaded();
    report.passes = times_.passes();
    report.probe_kind = kProbeNames[int(options_.probe)];
    report.probe = probe_;
    report.lights = lights_->lights();
    report.map_size = lights_->map_size();
    report.map_count = lights_->map_count();
    report.bounces = has(DGB_EFFECT_RADIOSITY) ? options_.bounces.value_or(options_.frames) : 0;
    report.params = options_.params;
    if (has(DGB_EFFECT_RADIOSITY)) { report.mean_confidence = mean_confidence(*renderer_); }
    report.hash = fnv1a64(final_rgb.data(), final_rgb.size());
    return report;
}

// The pictures come last: some of them take more work with the renderers.
void Run::write_files() {
    const Rgb final_rgb = tone_mapped(renderer_->read_picture(Picture::final));
    const std::string summary = difference(with_one(), with_two(), options_.effects);
    if (!options_.out.empty()) { make_directory(options_.out); }
    for (const Dump& dump : options_.dumps) {
        const Floats pixels = dump_pixels(*renderer_, dump.name);
        const size_t count = size_t(options_.width) * size_t(options_.height);
        require_written(
            write_pfm(dump.file, options_.width, options_.height, int(pixels.size() / count), pixels.data()),
            dump.file);
    }
    if (!options_.json.empty()) {
        require_written(write_text(options_.json, report_to_json(report(final_rgb))), options_.json);
    }
    if (!options_.out.empty()) { write_pictures(final_rgb); }
    check_gl();
    std::printf("%s", summary.c_str());
}

void run(const Options& options) {
    const dgb_plan plan = make_plan(layers_desc(options));
    if (options.plan) {
        std::printf("%s", plan_to_text(plan).c_str());
        return;
    }
    check_outputs(options);
    Run work(options);
    work.render_frames();
    work.write_files();
}

} // namespace

int main(int argc, char** argv) {
    return run_program("render", "Renders a scene headless, and shows what a second layer does to occlusion and light.",
                       [=](CLI::App* app) { run(parse_options(app, argc, argv)); });
}
