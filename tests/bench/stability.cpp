// How steady the shading is from frame to frame, with one layer and with two, by weight of history; and how fast light that
// bounces on settles.
//     stability [--quick] [SCENE[@ex,ey,ez,tx,ty,tz,fov]]...      always: the atrium
//
// Each pixel is compared with the place in the last frame where its surface was then, and only where that place shows the
// surface, by the library's own rule. The scene stands still: what changes under a moving camera is the estimator's doing.
// Under a moving sun light does change. All contenders shade the same layers, built as an engine would (REPROJECT), with a
// guard band. Irradiance is weighted by confidence and relative to the frame's mean; occlusion is ambient visibility. Without
// history (weight 0) every frame takes the same taps, which hides their noise as long as the camera rests.
#include "engine_layers.hpp"

#include <cmath>
#include <cstdint>
#include <numeric>
#include <optional>

namespace {

using Pixels = std::vector<float>;

constexpr int kImageWidth = 320, kImageHeight = 180, kGuard = 20; // pixels
constexpr int kBufferWidth = kImageWidth + 2 * kGuard, kBufferHeight = kImageHeight + 2 * kGuard;
constexpr Motion kSideStep{0.045f, 0.34f, true};
constexpr float kSunDegrees = 0.5f; // that the sun moves in a frame
constexpr std::array<float, 4> kWeights = {0.0f, 0.5f, 0.85f, 0.95f};
constexpr int kStillFrames = 32;

double mean(const Pixels& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / double(std::max<size_t>(values.size(), 1));
}

// ---- Stage ----------------------------------------------------------------------------------------------

enum class Moving { camera, sun, nothing };

constexpr const char* name_of(Moving moving) { return moving == Moving::sun ? "sun" : "camera"; }

// What shading knows of a frame, over the whole buffer.
struct Geometry {
    glm::mat4 view;
    dgb_camera camera;
    Pixels z[2], normals, velocity;
};

// A scene with its light, and the layers of any frame.
class Stage {
public:
    Stage(const View& view, const GpuScene& scene, glm::vec3 sun, Moving moving)
        : view_(view), scene_(scene), sun_(sun), moving_(moving) {
        show(0);
    }

    void show(int frame);

    const EngineLayers& layers() const { return *layers_; }
    Geometry geometry() const;
    dgb_view dgb_view_now() const { return to_dgb_view(view_matrix_, projection()); }

private:
    glm::mat4 projection() const { return projection_matrix(view_.camera, kAspect, ClipRange::standard); }
    glm::mat4 buffer_projection() const;
    void light_from(glm::vec3 sun);
    void make_renderer();

    const View& view_;
    const GpuScene& scene_;
    glm::vec3 sun_; // at the first frame
    Moving moving_;
    glm::mat4 view_matrix_{1.0f};
    PassTimes times_{false};
    std::optional<SceneLights> lights_;
    std::unique_ptr<SceneRenderer> renderer_;
    std::unique_ptr<EngineLayers> layers_;
};

// The renderer's whole image is what is buffer, guard band included, to the contenders.
glm::mat4 Stage::buffer_projection() const {
    const glm::mat4 image = projection();
    const float no_jitter[2] = {0.0f, 0.0f};
    float widened[16];
    dgb_widen_projection(glm::value_ptr(image), kImageWidth, kImageHeight, kGuard, no_jitter, widened);
    return glm::make_mat4(widened);
}

void Stage::light_from(glm::vec3 sun) {
    lights_.emplace(view_.scene, scene_, std::vector<PunctualLight>{sun_light(sun, 4.0f)});
    lights_->update(*scene_.first_pose());
}

void Stage::make_renderer() {
    RendererDesc desc;
    desc.get_proc = headless_get_proc;
    desc.layers.width = kBufferWidth;
    desc.layers.height = kBufferHeight;
    desc.scene = &scene_;
    desc.lights = &*lights_; // where they stay
    desc.times = &times_;
    renderer_ = std::make_unique<SceneRenderer>(desc);
}

void Stage::show(int frame) {
    const float turned = moving_ == Moving::sun ? kSunDegrees * float(frame) : 0.0f;
    const glm::mat3 turn(glm::rotate(glm::mat4(1.0f), glm::radians(turned), glm::vec3(0.0f, 1.0f, 0.0f)));
    if (!lights_ || turned != 0.0f) { light_from(turn * sun_); }
    if (!renderer_) { make_renderer(); }
    view_matrix_ = view_matrix(moving_ == Moving::camera ? moved(view_.camera, kSideStep, frame) : view_.camera);
    renderer_->render(view_matrix_, buffer_projection(), dgb_preset(DGB_PRESET_BALANCED));
    if (!layers_) { layers_ = std::make_unique<EngineLayers>(*renderer_); }
    layers_->take(*renderer_);
}

Geometry Stage::geometry() const {
    Geometry g;
    const glm::mat4 projection = buffer_projection();
    g.view = view_matrix_;
    dgb_camera_from_matrix(glm::value_ptr(projection), kBufferWidth, kBufferHeight, DGB_CLIP_NEGATIVE_ONE_TO_ONE, false,
                           &g.camera);
    for (int layer = 0; layer < 2; ++layer) { g.z[layer] = renderer_->read_z(layer); }
    g.normals = renderer_->read_normals(0);
    g.velocity = renderer_->read_texture(DGB_VELOCITY, 0, GL_RG);
    return g;
}

// ---- Reprojection ---------------------------------------------------------------------------------------

// Where a pixel's surface was a frame ago; the shaders' rule (19_history.glsl) for a scene that stands still.
struct Past {
    glm::vec2 pixel; // of the buffer
    glm::vec3 point, normal;
    float tolerance; // metres
};

glm::vec2 project(glm::vec3 point, const dgb_camera& camera) {
    const float *a = camera.position_z, *b = camera.position_1;
    return {(point.x - a[2] * point.z - b[2]) / (a[0] * point.z + b[0]),
            (point.y - a[3] * point.z - b[3]) / (a[1] * point.z + b[1])};
}

Past past_of(const Geometry& now, const Geometry& last, const glm::mat4& to_last, size_t pixel,
             const dgb_params& params) {
    const size_t x_at = pixel % kBufferWidth, y_at = pixel / kBufferWidth;
    const glm::vec2 at(float(x_at) + 0.5f, float(y_at) + 0.5f);
    glm::vec3 x;
    dgb_position(at.x, at.y, now.z[0][pixel], &now.camera, glm::value_ptr(x));
    Past past{};
    past.point = glm::vec3(to_last * glm::vec4(x, 1.0f));
    past.normal = glm::mat3(to_last) * glm::make_vec3(&now.normals[3 * pixel]);
    past.pixel = at - glm::make_vec2(&now.velocity[2 * pixel]);
    const float own = glm::distance(past.pixel, project(past.point, last.camera));
    past.tolerance = std::max(params.history_tolerance * std::abs(past.point.z), params.history_floor) +
                     own / dgb_pixels_per_metre(past.point.z, &last.camera);
    return past;
}

// Whether a layer of a texel of last frame shows it.
bool shows(const Geometry& last, int layer, glm::ivec2 texel, const Past& past) {
    const float z = last.z[layer][size_t(texel.y) * kBufferWidth + size_t(texel.x)];
    if (z == 0.0f) { return false; }
    const dgb_camera& camera = last.camera;
    const glm::vec2 at = glm::vec2(texel) + 0.5f;
    const glm::vec3 ray_z(at * glm::make_vec2(camera.position_z) + glm::make_vec2(camera.position_z + 2), 1.0f);
    const glm::vec3 ray_1(at * glm::make_vec2(camera.position_1) + glm::make_vec2(camera.position_1 + 2), 0.0f);
    const float on_ray = glm::dot(past.normal, past.point - ray_1) / glm::dot(past.normal, ray_z);
    const float to_plane = std::abs(z - on_ray), to_own = std::abs(z - past.point.z);
    return (to_plane < to_own ? to_plane : to_own) <= past.tolerance;
}

bool in_image(glm::ivec2 texel) {
    return texel.x >= kGuard && texel.y >= kGuard && texel.x < kGuard + kImageWidth && texel.y < kGuard + kImageHeight;
}

// Of a pixel: what of last frame's image to compare it with.
struct Source {
    int pixel;        // of the image
    int texels[4];    // likewise
    float weights[4]; // add up to 1
};

struct Warp {
    std::vector<Source> sources; // of the pixels that can be compared
    int64_t inside = 0;          // pixels whose surface was within the image
    int64_t disoccluded = 0;     // of these: not in last frame's first layer
    int64_t filled = 0;          // of these: in the second
};

int image_index(glm::ivec2 texel) { return (texel.y - kGuard) * kImageWidth + texel.x - kGuard; }

// Bilinear, of the texels that show the surface; less than half of the weights is not a place to compare with.
bool find_source(const Geometry& last, const Past& past, Source* source) {
    const glm::vec2 low = glm::floor(past.pixel - 0.5f), part = past.pixel - 0.5f - low;
    float total = 0.0f;
    for (int i = 0; i < 4; ++i) {
        const glm::ivec2 corner(i & 1, i >> 1), texel = glm::ivec2(low) + corner;
        const bool counts = in_image(texel) && shows(last, 0, texel, past);
        source->texels[i] = counts ? image_index(texel) : 0;
        source->weights[i] =
            counts ? (corner.x != 0 ? part.x : 1.0f - part.x) * (corner.y != 0 ? part.y : 1.0f - part.y) : 0.0f;
        total += source->weights[i];
    }
    for (float& weight : source->weights) { weight /= std::max(total, 0.5f); }
    return total >= 0.5f;
}

Warp make_warp(const Geometry& now, const Geometry& last, const dgb_params& params) {
    const glm::mat4 to_last(glm::dmat4(last.view) * glm::inverse(glm::dmat4(now.view)));
    Warp warp;
    for (int i = 0; i < kImageWidth * kImageHeight; ++i) {
        const glm::ivec2 texel(kGuard + i % kImageWidth, kGuard + i / kImageWidth);
        const size_t pixel = size_t(texel.y) * kBufferWidth + size_t(texel.x);
        if (now.z[0][pixel] == 0.0f) { continue; }
        const Past past = past_of(now, last, to_last, pixel, params);
        const glm::ivec2 nearest(glm::floor(past.pixel));
        if (!in_image(nearest)) { continue; }
        const bool shown = shows(last, 0, nearest, past);
        ++warp.inside;
        warp.disoccluded += !shown;
        warp.filled += !shown && shows(last, 1, nearest, past);
        Source source{i, {}, {}};
        if (find_source(last, past, &source)) { warp.sources.push_back(source); }
    }
    return warp;
}

float sampled(const Pixels& image, const Source& source, size_t channels, size_t channel) {
    float value = 0.0f;
    for (int i = 0; i < 4; ++i) { value += source.weights[i] * image[size_t(source.texels[i]) * channels + channel]; }
    return value;
}

// Absolute differences, the mean of the channels, from last frame to this.
Pixels differences(const Pixels& now, const Pixels& last, const Warp& warp, size_t channels) {
    Pixels result;
    result.reserve(warp.sources.size());
    for (const Source& source : warp.sources) {
        float sum = 0.0f;
        for (size_t c = 0; c < channels; ++c) {
            sum += std::abs(now[size_t(source.pixel) * channels + c] - sampled(last, source, channels, c));
        }
        result.push_back(sum / float(channels));
    }
    return result;
}

// ---- Contenders -----------------------------------------------------------------------------------------

double percentile_99(Pixels values) {
    if (values.empty()) { return 0.0; }
    const auto at = values.begin() + std::ptrdiff_t(values.size() * 99 / 100);
    std::nth_element(values.begin(), at, values.end());
    return double(*at);
}

struct Steadiness {                               // means over the frames; of differences between neighbouring ones
    double irradiance = 0.0, irradiance_99 = 0.0; // shares of the frame's mean
    double visibility = 0.0, visibility_99 = 0.0;
    double mean_irradiance = 0.0; // W/m2
    int frames = 0;

    void add(const Pixels& light, double mean_light, const Pixels& open) {
        const double old = double(frames) / double(frames + 1), fresh = 1.0 - old;
        irradiance = old * irradiance + fresh * mean(light) / mean_light;
        irradiance_99 = old * irradiance_99 + fresh * percentile_99(light) / mean_light;
        mean_irradiance = old * mean_irradiance + fresh * mean_light;
        visibility = old * visibility + fresh * mean(open);
        visibility_99 = old * visibility_99 + fresh * percentile_99(open);
        ++frames;
    }
};

// The separation and the radii of the preset suit rooms: smaller scenes get smaller ones.
dgb_params params_for(const View& view) {
    const float size = glm::length(view.scene.bounds_max - view.scene.bounds_min);
    dgb_params params = dgb_preset(DGB_PRESET_BALANCED);
    params.separation = std::min(params.separation, 0.05f * size);
    params.ao_radius = std::min(params.ao_radius, 0.1f * size);
    params.radius = std::min(params.radius, 0.5f * size);
    return params;
}

class Contender {
public:
    Contender(int layers, bool bounces, float weight, dgb_params params)
        : layers_(layers), bounces_(bounces), params_(params), library_(describe(layers, bounces)) {
        params_.history_weight = weight;
    }

    int layers() const { return layers_; }
    bool bounces() const { return bounces_; }
    float weight() const { return params_.history_weight; }
    const Steadiness& steadiness() const { return steadiness_; }
    double mean_irradiance() const { return mean(irradiance_); }

    void shade(const Stage& stage) {
        library_.set_layers(stage.dgb_view_now(), stage.layers().handles(layers_));
        library_.shade(params_);
        last_irradiance_ = std::move(irradiance_);
        last_visibility_ = std::move(visibility_);
        irradiance_ = weigh(library_.read(DGB_IRRADIANCE, GL_RGBA));
        visibility_ = library_.read(DGB_AO, GL_RED);
    }

    void compare(const Warp& warp) {
        steadiness_.add(differences(irradiance_, last_irradiance_, warp, 3), mean(irradiance_),
                        differences(visibility_, last_visibility_, warp, 1));
    }

private:
    static dgb_desc describe(int layers, bool bounces) {
        const uint32_t effects = DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY | DGB_EFFECT_TEMPORAL;
        dgb_desc desc = EngineLayers::describe(kImageWidth, kImageHeight, layers,
                                               effects | (bounces ? uint32_t(DGB_EFFECT_BOUNCES) : 0u));
        desc.guard_band = kGuard;
        return desc;
    }

    int layers_;
    bool bounces_;
    dgb_params params_;
    Library library_;
    Pixels irradiance_, last_irradiance_, visibility_, last_visibility_; // RGB times confidence
    Steadiness steadiness_;
};

using Contenders = std::vector<std::unique_ptr<Contender>>;

// The direction by which the camera sees most bounced light, with one layer: what is compared must not be close to nothing,
// wherever a camera stands.
glm::vec3 find_sun(const View& view, const GpuScene& scene) {
    glm::vec3 best(0.0f, 1.0f, 0.0f);
    double most = -1.0;
    Contender contender(1, false, 0.0f, params_for(view));
    for (const float height : {0.6f, 1.0f, 2.0f}) {
        for (int i = 0; i < 8; ++i) {
            const float angle = glm::pi<float>() * (float(i) + 0.5f) / 4.0f;
            const glm::vec3 sun(std::cos(angle), height, std::sin(angle));
            contender.shade(Stage(view, scene, sun, Moving::nothing));
            if (contender.mean_irradiance() > most) {
                most = contender.mean_irradiance();
                best = sun;
            }
        }
    }
    return best;
}

// ---- Steadiness -----------------------------------------------------------------------------------------

struct Result {
    std::string scene;
    Moving moving = Moving::nothing;
    int frames = 0;
    Contenders contenders;
    int64_t inside = 0, disoccluded = 0, filled = 0, compared = 0;
};

Contenders all_contenders(const dgb_params& params) {
    Contenders contenders;
    for (const bool bounces : {false, true}) {
        for (const float weight : kWeights) {
            for (const int layers : {1, 2}) {
                contenders.push_back(std::make_unique<Contender>(layers, bounces, weight, params));
            }
        }
    }
    return contenders;
}

// warm_up: frames until history and bounces have settled.
Result measure(const View& view, const GpuScene& scene, glm::vec3 sun, Moving moving, int warm_up, int frames) {
    const dgb_params params = params_for(view);
    Result result;
    result.scene = view.name;
    result.moving = moving;
    result.frames = frames;
    result.contenders = all_contenders(params);
    Stage stage(view, scene, sun, moving);
    Geometry last;
    for (int frame = 0; frame < warm_up + frames; ++frame) {
        stage.show(frame);
        for (const auto& contender : result.contenders) { contender->shade(stage); }
        Geometry now = stage.geometry();
        if (frame >= warm_up) {
            const Warp warp = make_warp(now, last, params);
            for (const auto& contender : result.contenders) { contender->compare(warp); }
            result.inside += warp.inside;
            result.disoccluded += warp.disoccluded;
            result.filled += warp.filled;
            result.compared += int64_t(warp.sources.size());
        }
        last = std::move(now);
    }
    return result;
}

const Contender& find(const Result& result, int layers, bool bounces, float weight) {
    return **std::find_if(result.contenders.begin(), result.contenders.end(), [&](const auto& c) {
        return c->layers() == layers && c->bounces() == bounces && c->weight() == weight;
    });
}

double percent(int64_t part, int64_t whole) { return 100.0 * double(part) / double(std::max<int64_t>(whole, 1)); }

double percent(double share) { return 100.0 * share; }

void print_pair(double one, double two, int digits = 3) {
    std::printf(" | %8.*f %8.*f %6.2f", digits, one, digits, two, one > 0.0 ? two / one : 1.0);
}

void print_rows(const Result& result, bool bounces) {
    std::printf("    %-17s | %24s | %24s | %24s | %24s | %24s\n", bounces ? "bounces" : "one bounce",
                "irradiance, % of mean", "its 99th percentile", "visibility, % of 1", "its 99th percentile",
                "mean irradiance, W/m2");
    std::printf("    %-17s", "weight of history");
    for (int i = 0; i < 5; ++i) { std::printf(" | %8s %8s %6s", "1 layer", "2 layers", "2 / 1"); }
    std::printf("\n");
    for (const float weight : kWeights) {
        const Steadiness& one = find(result, 1, bounces, weight).steadiness();
        const Steadiness& two = find(result, 2, bounces, weight).steadiness();
        std::printf("    %-17.2f", double(weight));
        print_pair(percent(one.irradiance), percent(two.irradiance));
        print_pair(percent(one.irradiance_99), percent(two.irradiance_99));
        print_pair(percent(one.visibility), percent(two.visibility));
        print_pair(percent(one.visibility_99), percent(two.visibility_99));
        print_pair(one.mean_irradiance, two.mean_irradiance, 5);
        std::printf("\n");
    }
}

// Relative to its own mean, and in W/m2: two layers show light that one does not, so there is more that can change.
void print_verdicts(const Result& result) {
    std::printf("    two layers / one: change of irradiance relative to the mean (in W/m2)\n");
    for (const bool bounces : {false, true}) {
        std::printf("      %-12s", bounces ? "bounces" : "one bounce");
        for (const float weight : kWeights) {
            const Steadiness& one = find(result, 1, bounces, weight).steadiness();
            const Steadiness& two = find(result, 2, bounces, weight).steadiness();
            const double ratio = two.irradiance / one.irradiance;
            std::printf("   weight %.2f: %.2f (%.2f), %s", double(weight), ratio,
                        ratio * two.mean_irradiance / one.mean_irradiance,
                        ratio < 0.98   ? "steadier"
                        : ratio > 1.02 ? "less steady"
                                       : "the same");
        }
        std::printf("\n");
    }
}

void print_steadiness(const Result& result) {
    std::printf(
        "\n%s, %dx%d with %d pixels of guard band, %d frames, moving: %s; compared: %.1f %% of what was in the image\n",
        result.scene.c_str(), kImageWidth, kImageHeight, kGuard, result.frames, name_of(result.moving),
        percent(result.compared, result.inside));
    for (const bool bounces : {false, true}) { print_rows(result, bounces); }
    print_verdicts(result);
    if (result.moving == Moving::camera) {
        std::printf("    not in last frame's first layer: %.3f %% of the pixels; of these in its second: %.1f %%\n",
                    percent(result.disoccluded, result.inside), percent(result.filled, result.disoccluded));
    }
    std::fflush(stdout);
}

void write_steadiness(std::FILE* csv, const Result& result) {
    for (const auto& contender : result.contenders) {
        const Steadiness& s = contender->steadiness();
        std::fprintf(csv, "%s,%s,%d,%d,%.2f,%d,%.6f,%.6f,%.6f,%.6f,%.6f,%.5f,%.3f\n", result.scene.c_str(),
                     name_of(result.moving), int(contender->bounces()), contender->layers(),
                     double(contender->weight()), result.frames, s.irradiance, s.irradiance_99, s.visibility,
                     s.visibility_99, s.mean_irradiance, percent(result.disoccluded, result.inside),
                     percent(result.filled, result.disoccluded));
    }
    std::fflush(csv);
}

// ---- Convergence ----------------------------------------------------------------------------------------

// Nothing moves: the image's mean irradiance by frame.
void run_still(const View& view, const GpuScene& scene, glm::vec3 sun, std::FILE* csv) {
    const Stage stage(view, scene, sun, Moving::nothing);
    Contenders contenders;
    for (const float weight : {0.0f, 0.85f}) {
        for (const int layers : {1, 2}) {
            contenders.push_back(std::make_unique<Contender>(layers, true, weight, params_for(view)));
        }
    }
    std::vector<std::vector<double>> means(contenders.size());
    for (int frame = 1; frame <= kStillFrames; ++frame) {
        for (size_t i = 0; i < contenders.size(); ++i) {
            contenders[i]->shade(stage);
            means[i].push_back(contenders[i]->mean_irradiance());
            std::fprintf(csv, "%s,%d,%.2f,%d,%.6f\n", view.name.c_str(), contenders[i]->layers(),
                         double(contenders[i]->weight()), frame, means[i].back());
        }
    }
    std::printf("\n%s, nothing moves: mean irradiance by frame, %% of that of frame %d (W/m2)\n", view.name.c_str(),
                kStillFrames);
    for (size_t i = 0; i < contenders.size(); ++i) {
        std::printf("    %d layer%s, weight %.2f (%.4f):", contenders[i]->layers(),
                    contenders[i]->layers() > 1 ? "s" : " ", double(contenders[i]->weight()), means[i].back());
        for (const size_t frame : {1, 2, 3, 4, 6, 8, 12, 16, 24}) {
            std::printf("  %zu: %.1f", frame, 100.0 * means[i][frame - 1] / means[i].back());
        }
        std::printf("\n");
    }
    std::fflush(stdout);
}

// ---- Program --------------------------------------------------------------------------------------------

// One panel a scene and motion: difference over weight of history.
void write_plot_script(const std::vector<std::string>& scenes) {
    const File script = result_file("stability.gnuplot");
    std::FILE* out = script.get();
    std::fprintf(out, "set terminal svg size 960, %zu background rgb 'white'\nset output 'build/bench/stability.svg'\n",
                 360 * scenes.size());
    std::fprintf(
        out,
        "set datafile separator ','\nset datafile missing NaN\nset multiplot layout %zu, 2\nset key top right\n"
        "set grid\nset yrange [0:*]\nset xlabel 'weight of history'\n"
        "set ylabel 'change of irradiance a frame, %% of mean'\n",
        scenes.size());
    for (const std::string& scene : scenes) {
        for (const char* moving : {"camera", "sun"}) {
            std::fprintf(out, "set title '%s, moving: %s' noenhanced\nplot ", scene.c_str(), moving);
            const char* separator = "";
            for (const int bounces : {0, 1}) {
                for (const int layers : {1, 2}) {
                    std::fprintf(
                        out,
                        "%s'build/bench/stability.csv' using (strcol(1) eq '%s' && strcol(2) eq '%s' && $3 == %d && "
                        "$4 == %d ? $5 : NaN):(100 * $7) with linespoints title '%d layer%s, %s'",
                        separator, scene.c_str(), moving, bounces, layers, layers, layers > 1 ? "s" : "",
                        bounces != 0 ? "bounces" : "one bounce");
                    separator = ", ";
                }
            }
            std::fprintf(out, "\n");
        }
    }
}

void plot(const std::vector<std::string>& scenes) {
    write_plot_script(scenes);
    if (std::system("command -v gnuplot >/dev/null && gnuplot build/bench/stability.gnuplot") == 0) { // NOLINT
        std::printf("\nbuild/bench/stability.csv, build/bench/stability.svg, build/bench/bounces.csv\n");
    } else {
        std::printf("\nbuild/bench/stability.csv, build/bench/bounces.csv; for the plot: apt-get install gnuplot-nox; "
                    "gnuplot build/bench/stability.gnuplot\n");
    }
}

void run(const Options& options) {
    const int warm_up = options.quick ? 6 : 24, frames = options.quick ? 10 : 60;
    std::vector<std::string> arguments = options.scenes, names;
    arguments.insert(arguments.begin(), std::string());
    {
        const File csv = result_file("stability.csv"), bounces_csv = result_file("bounces.csv");
        std::fprintf(csv.get(), "scene,moving,bounces,layers,history_weight,frames,irradiance,irradiance_99,visibility,"
                                "visibility_99,mean_irradiance,disoccluded,filled\n");
        std::fprintf(bounces_csv.get(), "scene,layers,history_weight,frame,mean_irradiance\n");
        for (const std::string& argument : arguments) {
            View view = load_view(argument);
            tell_from(names, &view.name);
            const GpuScene scene(view.scene);
            const glm::vec3 sun = find_sun(view, scene);
            for (const Moving moving : {Moving::camera, Moving::sun}) {
                const Result result = measure(view, scene, sun, moving, warm_up, frames);
                print_steadiness(result);
                write_steadiness(csv.get(), result);
            }
            run_still(view, scene, sun, bounces_csv.get());
            names.push_back(view.name);
        }
    }
    plot(names);
}

} // namespace

int main(int argc, char** argv) { return run_benchmark("stability", argc, argv, run); }
