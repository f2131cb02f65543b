// A window into a scene: one layer beside two, everything that can be chosen, and what it costs.
//     viewer [SCENE]      everything else: viewer --help
// Every failure to start is one sentence on the standard error output and exit code 2.
#define DEEPGBUFFER_IMPLEMENTATION
#include "deepgbuffer.h"
#include "deepgbuffer_gl.h"

#include "image.hpp"
#include "program.hpp"
#include "render_scene.hpp"
#include "scene_bake.hpp"
#include "scene_renderer.hpp"
#include "viewer_camera.hpp"
#include "viewer_options.hpp"
#include "viewer_panel.hpp"
#include "viewer_views.hpp"
#include "viewer_window.hpp"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace {

namespace fs = std::filesystem;
using glm::vec3;

constexpr double kResizeRest = 0.2; // seconds without a new size, after which the textures get it

// ---- Scene ----------------------------------------------------------------------------------------------

// A scene on the GPU, and its lights.
struct Stage {
    Scene scene;
    GpuScene gpu;
    SceneLights lights;
    double posed = -1.0; // seconds; of `pose`
    std::shared_ptr<const GpuPose> pose;

    explicit Stage(const Options& options)
        : scene(load_scene(options.scene)), gpu(scene), lights(scene, gpu, choose_lights(options, scene)) {}

    float diagonal() const { return glm::length(scene.bounds_max - scene.bounds_min); }
    std::shared_ptr<const GpuPose> pose_at(double seconds);
};

std::shared_ptr<const GpuPose> Stage::pose_at(double seconds) {
    if (scene.animations.empty()) { return gpu.first_pose(); }
    if (seconds != posed) {
        ::pose(&scene, seconds);
        pose = std::make_shared<GpuPose>(current_pose(scene));
        posed = seconds;
    }
    return pose;
}

Sun sun_of(const PunctualLight& light) {
    const vec3 to_sun = direction_to(light);
    Sun sun;
    sun.azimuth = glm::degrees(std::atan2(to_sun.x, to_sun.z));
    sun.elevation = glm::degrees(std::asin(std::clamp(to_sun.y, -1.0f, 1.0f)));
    sun.strength = light.intensity.x;
    sun.on = sun.strength > 0.0f;
    return sun;
}

PunctualLight light_of(const Sun& sun) {
    const float azimuth = glm::radians(sun.azimuth), elevation = glm::radians(sun.elevation);
    const vec3 to_sun(std::cos(elevation) * std::sin(azimuth), std::sin(elevation),
                      std::cos(elevation) * std::cos(azimuth));
    return sun_light(to_sun, sun.on ? sun.strength : 0.0f);
}

// ---- Viewer ---------------------------------------------------------------------------------------------

class Viewer {
public:
    explicit Viewer(const ViewerOptions& options);
    void run();

private:
    struct Half {
        std::unique_ptr<SceneRenderer> renderer;
        PassTimes times{false}; // of one frame
    };

    void start(const ViewerOptions& options);
    void show_demo(const Demo& demo);
    void open_scene(const Options& asked, bool keep_camera);
    void try_scene(const std::string& path, bool keep_camera);
    void set_lengths();
    void make_renderer(size_t side);
    RendererDesc renderer_desc(const dgb_desc& layers, PassTimes* times) const;
    void light_up();
    void relight();

    void handle(const Events& events);
    void press(int key);
    void toggle_recording();
    void toggle_replay(); // throws when the path is wrong
    void move_camera(const Steering& steering, float seconds);
    glm::ivec2 picture_size() const;
    float picture_width() const { return window_.gui_size().x - side_width(); } // in the window's coordinates
    float side_width() const { return panel_.visible ? panel_width(window_.gui_size().x) : 0.0f; }
    void follow_size();
    double frame_seconds();

    SceneFrame next_frame();
    bool needs_future() const;
    void draw(const SceneFrame& frame);
    void draw_half(size_t side, const SceneFrame& frame);
    void paint_half(size_t side);
    void draw_gui();
    void obey(const PanelRequests& requests);
    void take_screenshot();
    bool is_script() const { return options_.frames > 0; } // then time goes by the frame, not by the clock
    bool is_last_frame() const { return is_script() && frame_ + 1 >= options_.frames; }
    int split_column() const { return int(std::lround(panel_.shown_split() * float(size_.x))); }
    // Without a renderer, the library has refused what a new scene should be shown with.
    bool is_drawn(size_t side) const {
        return halves_[side].renderer && (side == 0 ? panel_.split > 0.0f : panel_.split < 1.0f);
    }

    ViewerOptions options_;
    Window window_; // before everything that lives in its context
    std::unique_ptr<Stage> stage_;
    Sky sky_;
    Probe probe_{};
    std::array<Half, 2> halves_; // left, right
    Panel panel_;
    RenderCamera camera_, first_camera_;
    CameraPath path_; // recorded or replayed
    double path_time_ = 0.0;
    double time_ = 0.0;                      // of the animation, seconds
    double last_time_ = 0.0, resized_ = 0.0; // by the clock, seconds
    glm::ivec2 size_{0};                     // of the picture, which is left of the panel, pixels
    bool wants_screenshot_ = false;
    int frame_ = 0;
};

std::string path_file(const ViewerOptions& options) { return options.path.empty() ? "viewer_path.txt" : options.path; }

Viewer::Viewer(const ViewerOptions& options)
    : options_(options), window_(options.right.width, options.right.height, "deepgbuffer") {
    panel_.visible = options.panel;
    panel_.labels = options.labels;
    size_ = picture_size();
    start(options);
    for (const PanelSide& side : panel_.sides) { // a wrong start ends the program, a wrong change later does not
        if (!side.desc_error.empty()) { throw std::runtime_error(side.desc_error); }
    }
    if (!options.path.empty() && fs::exists(options.path)) { toggle_replay(); }
    last_time_ = glfwGetTime();
}

// ---- Scene and renderers --------------------------------------------------------------------------------

// All but the window. Throws when the scene cannot be had.
void Viewer::start(const ViewerOptions& options) {
    const Options* const sides[] = {&options.left, &options.right};
    for (size_t i = 0; i < 2; ++i) {
        panel_.sides[i].config = {layers_desc(*sides[i]), sides[i]->params, options.view};
    }
    panel_.split = options.split;
    panel_.alone = Alone::none;
    panel_.sky = options.right.sky;
    panel_.exposure = options.right.exposure;
    panel_.replaying = false;
    time_ = options.right.time;
    options_.left = options.left;
    options_.right = options.right;
    options_.given = options.given;
    open_scene(options.right, false);
}

void Viewer::show_demo(const Demo& demo) {
    CLI::App app;
    try {
        start(parse_viewer_options(&app, [&](CLI::App* words) { words->parse(std::string(demo.words)); }));
    } catch (const std::exception& error) { panel_.message = error.what(); }
}

// Throws when the scene cannot be had, and leaves everything as it was.
void Viewer::open_scene(const Options& asked, bool keep_camera) {
    auto stage = std::make_unique<Stage>(asked);
    Options framed = asked;
    framed.width = size_.x;
    framed.height = size_.y;
    first_camera_ = choose_camera(framed, stage->scene);
    for (size_t i = 0; i < halves_.size(); ++i) { // before the scene that they draw
        halves_[i].renderer.reset();
        panel_.sides[i].plan = nullptr;
    }
    stage_ = std::move(stage);
    options_.right.scene = asked.scene;
    options_.right.camera = asked.camera;
    panel_.has_animation = !stage_->scene.animations.empty();
    if (!keep_camera) {
        camera_ = first_camera_;
        panel_.speed = 0.1f * stage_->diagonal();
        panel_.sun = sun_of(asked.sun.value_or(kDefaultSun));
        panel_.sun.on = panel_.sun.on && (asked.sun || stage_->scene.lights.empty());
        set_lengths();
    }
    light_up();
    for (size_t i = 0; i < halves_.size(); ++i) { make_renderer(i); }
}

void Viewer::try_scene(const std::string& path, bool keep_camera) {
    Options asked = options_.right;
    asked.scene = path;
    if (!keep_camera) { asked.camera.reset(); }
    try {
        open_scene(asked, keep_camera);
        panel_.message = "read " + (path.empty() ? "the atrium" : "\"" + path + "\"");
    } catch (const std::exception& error) { panel_.message = error.what(); }
}

void Viewer::set_lengths() {
    for (size_t i = 0; i < 2; ++i) {
        dgb_params& params = panel_.sides[i].config.params;
        const dgb_params& asked = (i == 0 ? options_.left : options_.right).params;
        params.separation = asked.separation;
        params.ao_radius = asked.ao_radius;
        params.radius = asked.radius;
        viewer_options::scale_lengths(options_, stage_->diagonal(), &params);
    }
}

RendererDesc Viewer::renderer_desc(const dgb_desc& layers, PassTimes* times) const {
    RendererDesc desc;
    desc.get_proc = Window::get_proc;
    desc.layers = layers;
    desc.scene = &stage_->gpu;
    desc.lights = &stage_->lights;
    desc.sky = sky_;
    desc.probe = probe_;
    desc.roughness = options_.right.roughness;
    desc.times = times;
    return desc;
}

// When the library refuses, its sentence goes to the panel, and what was there is drawn on.
void Viewer::make_renderer(size_t side) {
    PanelSide& shown = panel_.sides[side];
    Half& half = halves_[side];
    dgb_desc& layers = shown.config.layers;
    layers.width = size_.x;
    layers.height = size_.y;
    try {
        half.renderer = std::make_unique<SceneRenderer>(renderer_desc(layers, &half.times));
        shown.plan = &half.renderer->plan();
        shown.history = {};
        shown.desc_error.clear();
    } catch (const std::exception& error) { shown.desc_error = error.what(); }
}

// The light from where no surface is known.
void Viewer::light_up() {
    const Options& options = options_.right;
    sky_ = options.probe == ProbeKind::sky ? gradient_sky(options.sky) : uniform_sky(options.sky);
    probe_ = probe_of(sky_);
    if (options.probe == ProbeKind::cube) {
        PassTimes unread(false);
        const std::shared_ptr<const GpuPose> pose = stage_->pose_at(time_);
        stage_->lights.update(*pose);
        probe_ = bake_probe(renderer_desc({}, &unread), pose, camera_.eye, camera_.near_plane, camera_.far_plane);
    }
    for (Half& half : halves_) {
        if (half.renderer) { half.renderer->set_surroundings(sky_, probe_); }
    }
}

void Viewer::relight() {
    options_.right.sun = light_of(panel_.sun);
    try {
        stage_->lights = SceneLights(stage_->scene, stage_->gpu, choose_lights(options_.right, stage_->scene));
        light_up();
    } catch (const std::exception& error) { panel_.message = error.what(); }
}

// ---- Input ----------------------------------------------------------------------------------------------

void Viewer::handle(const Events& events) {
    try {
        for (const int key : events.keys) { press(key); }
    } catch (const std::exception& error) { panel_.message = error.what(); }
    if (!events.dropped.empty()) { try_scene(events.dropped.front(), false); }
    panel_.speed *= std::exp2(0.25f * float(events.wheel));
}

void Viewer::press(int key) {
    switch (key) {
    case GLFW_KEY_F1: panel_.visible = !panel_.visible; break;
    case GLFW_KEY_F2: panel_.labels = !panel_.labels; break;
    case GLFW_KEY_F5: try_scene(options_.right.scene, true); break;
    case GLFW_KEY_F9: toggle_recording(); break;
    case GLFW_KEY_F10: toggle_replay(); break;
    case GLFW_KEY_F12: wants_screenshot_ = true; break;
    case GLFW_KEY_TAB: panel_.alone = Alone((int(panel_.alone) + 1) % 3); break;
    case GLFW_KEY_HOME: camera_ = first_camera_; break;
    case GLFW_KEY_SPACE: panel_.playing = !panel_.playing; break;
    default: break;
    }
}

void Viewer::toggle_recording() {
    panel_.recording = !panel_.recording;
    panel_.replaying = false;
    if (panel_.recording) {
        path_.clear();
        path_time_ = 0.0;
        return;
    }
    const std::string file = path_file(options_);
    const bool written = write_text(file, to_text(path_));
    panel_.message = (written ? "the camera's path is in \"" : "cannot write \"") + file + "\"";
}

void Viewer::toggle_replay() {
    if (panel_.recording) { toggle_recording(); }
    if (!std::exchange(panel_.replaying, false)) {
        path_ = read_path(path_file(options_));
        path_time_ = 0.0;
        panel_.replaying = true;
    }
}

void Viewer::move_camera(const Steering& steering, float seconds) {
    if (panel_.replaying) {
        place(&camera_, at(path_, path_time_));
        path_time_ += double(seconds);
    } else {
        look(&camera_, steering.look_yaw, steering.look_pitch);
        circle(&camera_, steering.orbit_yaw, steering.orbit_pitch);
        if (steering.fly != vec3(0.0f)) { fly(&camera_, panel_.speed * seconds * steering.fly); }
        if (frame_ > 0) { camera_ = orbit(camera_, options_.right.orbit); }
    }
    if (panel_.recording) {
        path_.push_back(key_of(camera_, path_time_));
        path_time_ += double(seconds);
    }
    keep_scene_in_planes(stage_->scene, &camera_);
}

// Pixels of the framebuffer; 0 while the window is minimised.
glm::ivec2 Viewer::picture_size() const {
    const glm::ivec2 size = window_.framebuffer_size();
    const float share = picture_width() / std::max(window_.gui_size().x, 1.0f);
    return size == glm::ivec2(0) ? size : glm::ivec2(std::max(int(std::lround(share * float(size.x))), 1), size.y);
}

// While the user pulls at the window's border, the pictures are stretched: new textures for each step cost too much.
void Viewer::follow_size() {
    const glm::ivec2 size = picture_size();
    const double now = glfwGetTime();
    if (size == glm::ivec2(0)) { return; }
    if (size != size_) {
        size_ = size;
        resized_ = now;
    }
    if (!is_script() && now - resized_ < kResizeRest) { return; }
    for (size_t i = 0; i < halves_.size(); ++i) {
        dgb_desc& layers = panel_.sides[i].config.layers;
        layers.width = size_.x;
        layers.height = size_.y;
        try {
            if (halves_[i].renderer) { halves_[i].renderer->resize(size_.x, size_.y); }
        } catch (const std::exception& error) { panel_.sides[i].desc_error = error.what(); }
    }
}

// Since the last frame. After a pause, a tenth of a second at most.
double Viewer::frame_seconds() {
    const double now = glfwGetTime(), elapsed = now - std::exchange(last_time_, now);
    return is_script() ? 1.0 / options_.right.fps : std::min(elapsed, 0.1);
}

// ---- A frame --------------------------------------------------------------------------------------------

// PREDICT and DELAY draw the next pose already.
bool Viewer::needs_future() const {
    return std::any_of(halves_.begin(), halves_.end(), [](const Half& half) {
        const dgb_oracle oracle = half.renderer ? half.renderer->plan().oracle : DGB_ORACLE_DEFAULT;
        return oracle == DGB_ORACLE_PREDICT || oracle == DGB_ORACLE_DELAY;
    });
}

SceneFrame Viewer::next_frame() {
    SceneFrame frame;
    frame.view = view_matrix(camera_);
    frame.projection = projection_matrix(camera_, float(size_.x) / float(size_.y), options_.right.clip);
    frame.pose = stage_->pose_at(time_);
    if (needs_future() && panel_.playing) { frame.next_pose = stage_->pose_at(time_ + 1.0 / options_.right.fps); }
    return frame;
}

void Viewer::draw_half(size_t side, const SceneFrame& frame) {
    Half& half = halves_[side];
    PanelSide& shown = panel_.sides[side];
    half.times = PassTimes(panel_.wait);
    try {
        half.renderer->build(frame, shown.config.params);
        half.times.begin();
        if (stage_->lights.update(half.renderer->drawn_pose())) { half.times.end("shadow"); }
        half.renderer->shade(shown.config.params);
        shown.frame_error.clear();
    } catch (const std::exception& error) { // the picture of the frame before stays
        shown.frame_error = error.what();
    }
    shown.history.add(half.times);
}

void Viewer::paint_half(size_t side) {
    const int column = split_column();
    const Area window = {0, 0, size_.x, size_.y};
    const Area visible = side == 0 ? Area{0, 0, column, size_.y} : Area{column, 0, size_.x - column, size_.y};
    PanelSide& shown = panel_.sides[side];
    shown.shows_view = paint_view(*halves_[side].renderer, shown.config.view, window, visible, panel_.exposure,
                                  0.5f * stage_->diagonal());
}

void Viewer::draw(const SceneFrame& frame) {
    for (size_t i = 0; i < halves_.size(); ++i) {
        if (is_drawn(i)) { draw_half(i, frame); }
    }
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glClearColor(0.0f, 0.0f, 0.0f, 1.0f);
    glClear(GL_COLOR_BUFFER_BIT);
    for (size_t i = 0; i < halves_.size(); ++i) {
        if (is_drawn(i)) { paint_half(i); }
    }
}

void Viewer::draw_gui() {
    Window::begin_gui();
    const float width = picture_width(), height = window_.gui_size().y;
    if (panel_.labels) { draw_labels(panel_, width, height); }
    draw_errors(panel_, width, height);
    if (panel_.visible) { obey(draw_panel(&panel_, width, side_width(), height)); }
    Window::end_gui();
}

// Takes effect in the next frame.
void Viewer::obey(const PanelRequests& requests) {
    if (requests.desc_changed) {
        for (size_t i = 0; i < halves_.size(); ++i) { make_renderer(i); }
    }
    if (requests.sky_changed) {
        options_.right.sky = panel_.sky;
        light_up();
    }
    if (requests.light_changed) { relight(); }
    if (requests.demo != nullptr) { show_demo(*requests.demo); }
}

std::string next_screenshot() {
    for (int number = 1;; ++number) {
        char file[40];
        std::snprintf(file, sizeof file, "viewer_%03d.png", number);
        if (!fs::exists(file)) { return file; }
    }
}

// The window's pixels, of which OpenGL has the bottom row first.
void write_window(const std::string& file, glm::ivec2 size) {
    const auto row = size_t(size.x) * 3;
    std::vector<uint8_t> pixels(row * size_t(size.y)), top_down;
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glReadBuffer(GL_BACK);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, size.x, size.y, GL_RGB, GL_UNSIGNED_BYTE, pixels.data());
    if (viewer_options::ends_with(file, ".pfm")) {
        std::vector<float> floats(pixels.size());
        std::transform(pixels.begin(), pixels.end(), floats.begin(), [](uint8_t byte) { return float(byte) / 255.0f; });
        require_written(write_pfm(file, size.x, size.y, 3, floats.data()), file);
        return;
    }
    for (auto y = size_t(size.y); y-- > 0;) {
        top_down.insert(top_down.end(), &pixels[y * row], &pixels[y * row] + row);
    }
    require_written(write_png(file, size.x, size.y, top_down), file);
}

void Viewer::take_screenshot() {
    if (is_last_frame() && !options_.screenshot.empty()) {
        write_window(options_.screenshot, window_.framebuffer_size());
    }
    if (!std::exchange(wants_screenshot_, false)) { return; }
    const std::string file = next_screenshot();
    try {
        write_window(file, window_.framebuffer_size());
        panel_.message = "the window is in \"" + file + "\"";
    } catch (const std::exception& error) { panel_.message = error.what(); }
}

void Viewer::run() {
    while (!window_.is_closed()) {
        handle(window_.poll());
        follow_size();
        const double seconds = frame_seconds();
        move_camera(window_.steer(float(seconds), picture_width(), &panel_.split), float(seconds));
        draw(next_frame());
        draw_gui();
        take_screenshot();
        check_gl();
        window_.show();
        if (is_last_frame()) { break; }
        if (panel_.playing) { time_ += seconds; }
        ++frame_;
    }
}

void run(CLI::App* app, int argc, char** argv) {
    const ViewerOptions options = parse_viewer_options(app, [=](CLI::App* words) { words->parse(argc, argv); });
    if (!options.screenshot.empty()) { check_file(options.screenshot); }
    Viewer(options).run();
}

} // namespace

int main(int argc, char** argv) {
    return run_program("viewer", "Shows a scene with one layer beside two, and everything that can be chosen.",
                       [=](CLI::App* app) { run(app, argc, argv); });
}
