// What each pass costs with one layer and with two, and what a straightforward port of the paper costs.
//     shading [--quick] [SCENE[@ex,ey,ez,tx,ty,tz,fov[,sx,sy,sz]]]...      without a scene: the atrium
//
// Absolute times mean little on a software rasteriser on a busy machine, so the contenders take turns frame by frame and
// every figure is a median: of times, or of ratios within a turn. The clock is the process's own where the renderer is
// software, else the wall's. All contenders shade the same layers, drawn once. GL timer queries are not used: a tiler may
// time only part of the work.
#include "engine_layers.hpp"

#include <cmath>
#include <numeric>
#include <random>

namespace {

constexpr int kWarmUp = 3;

struct Taps {
    int ao, gather;
};

using Samples = std::map<std::string, std::vector<double>>; // milliseconds by pass

constexpr const char* kChain[] = {"pack", "mip", "tiles", "ao", "gather", "temporal", "reconstruct"};

// Frame by frame, of the passes that there are.
template <typename Passes>
std::vector<double> sum(const Samples& samples, const Passes& passes) {
    std::vector<double> total;
    for (const std::string pass : passes) {
        const auto found = samples.find(pass);
        if (found == samples.end()) { continue; }
        total.resize(found->second.size());
        for (size_t i = 0; i < total.size(); ++i) { total[i] += found->second[i]; }
    }
    return total;
}

std::vector<double> sum(const Samples& samples, std::initializer_list<const char*> passes) {
    return sum(samples, std::vector<const char*>(passes));
}

GlObject make_target(GLenum format, int width, int height) {
    GlObject texture = make_texture();
    glBindTexture(GL_TEXTURE_2D, texture.name());
    glTexStorage2D(GL_TEXTURE_2D, 1, format, width, height);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    return texture;
}

GlObject make_target_framebuffer(const GlObject& texture) {
    GlObject framebuffer = make_framebuffer();
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture.name(), 0);
    return framebuffer;
}

// ---- Contenders -----------------------------------------------------------------------------------------

struct Picture {
    glm::mat4 view, projection;
    const EngineLayers* layers;
};

class Contender {
public:
    Contender() = default;
    Contender(const Contender&) = delete;
    Contender& operator=(const Contender&) = delete;
    virtual ~Contender() = default;

    virtual void run() = 0; // one frame
    virtual std::vector<float> irradiance() const = 0;

    const Samples& samples() const { return clock_.milliseconds(); }
    void forget() { clock_.forget(); }

protected:
    PassClock clock_;
};

// The library.
class Chain : public Contender {
public:
    Chain(const Picture& picture, dgb_desc desc, const dgb_params& params)
        : view_(to_dgb_view(picture.view, picture.projection)), layers_(picture.layers->handles(desc.layers)),
          params_(params), library_(desc, &clock_) {}

    void run() override {
        library_.set_layers(view_, layers_);
        library_.shade(params_);
    }
    std::vector<float> irradiance() const override { return library_.read(DGB_IRRADIANCE, GL_RGBA); }

private:
    dgb_view view_;
    dgb_layers layers_;
    dgb_params params_;
    Library library_;
};

// A full-screen pass that copies an RGBA16F texel: a unit of cost.
class CopyPass : public Contender {
public:
    CopyPass()
        : program_(make_fullscreen_program("copy",
                                           "uniform sampler2D source; out vec4 color;\n"
                                           "void main() { color = texelFetch(source, ivec2(gl_FragCoord.xy), 0); }\n")),
          vertices_(make_vertex_array()), source_(make_target(GL_RGBA16F, kWidth, kHeight)),
          target_(make_target(GL_RGBA16F, kWidth, kHeight)), framebuffer_(make_target_framebuffer(target_)) {}

    void run() override {
        clock_.begin();
        glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.name());
        glViewport(0, 0, kWidth, kHeight);
        glDisable(GL_DEPTH_TEST);
        glUseProgram(program_.name());
        glBindVertexArray(vertices_.name());
        bind_texture(program_.name(), "source", 0, GL_TEXTURE_2D, source_.name());
        glDrawArrays(GL_TRIANGLES, 0, 3);
        clock_.end("copy");
    }
    std::vector<float> irradiance() const override { return {}; }

private:
    GlObject program_, vertices_, source_, target_, framebuffer_;
};

// ---- Baseline -------------------------------------------------------------------------------------------

// What one would write with the paper on the desk and nothing else: each equation as it stands, on a common G-buffer: depth as
// the device has it, normals and radiance in half floats, positions from depth by the inverse projection. No sorting, no MIP
// levels, no packing, no tables; but counts and sharpnesses are constants, so that a compiler may unroll the loops and fold
// what does not depend on the pixel. The gather: Equations 4 and 5 over two layers, taps on the spiral of section 3.4.
const char* const kBaselineGather = R"(
uniform sampler2D u_depth0, u_depth1;
uniform sampler2D u_normal0, u_normal1;
uniform sampler2D u_radiance0, u_radiance1;
uniform mat4 u_camera_from_clip;
uniform vec3 u_size;              // pixels
uniform float u_radius;           // metres
uniform float u_pixels_per_metre; // at a distance of one

layout(location = 0) out vec4 out_irradiance; // a: share of the taps that found light

vec3 position(vec2 pixel, float depth) {
    vec4 p = u_camera_from_clip * vec4(vec3(pixel / u_size.xy, depth) * 2.0 - 1.0, 1.0);
    return p.xyz / p.w;
}

float random_angle(vec2 pixel) { return 6.2831853 * fract(sin(dot(pixel, vec2(12.9898, 78.233))) * 43758.5453); }

struct Sum {
    vec3 light;
    float count;
};

void add_sample(inout Sum sum, vec3 x, vec3 n_x, vec2 pixel, float depth, vec3 n_y, vec3 radiance) {
    vec3 v = position(pixel, depth) - x;
    vec3 w = normalize(v);
    if (depth < 1.0 && dot(v, v) < u_radius * u_radius && dot(w, n_x) > 0.0 && dot(w, n_y) < 0.0) {
        sum.light += radiance * dot(w, n_x);
        sum.count += 1.0;
    }
}

void main() {
    ivec2 here = ivec2(gl_FragCoord.xy);
    float depth = texelFetch(u_depth0, here, 0).r;
    out_irradiance = vec4(0.0);
    if (depth == 1.0) return;
    vec3 x = position(gl_FragCoord.xy, depth);
    vec3 n = texelFetch(u_normal0, here, 0).xyz;
    float reach = u_radius * u_pixels_per_metre / -x.z;
    float start = random_angle(gl_FragCoord.xy);
    Sum sum = Sum(vec3(0.0), 0.0);
    float useful = 0.0;
    for (int i = 0; i < TAPS; ++i) {
        float part = (float(i) + 0.5) / float(TAPS);
        float angle = part * 6.2831853 * float(TURNS) + start;
        ivec2 tap = ivec2(floor(gl_FragCoord.xy + part * reach * vec2(cos(angle), sin(angle))));
        if (tap == here || any(lessThan(tap, ivec2(0))) || any(greaterThanEqual(tap, ivec2(u_size.xy)))) continue;
        vec2 centre = vec2(tap) + 0.5;
        float before = sum.count;
        add_sample(sum, x, n, centre, texelFetch(u_depth0, tap, 0).r, texelFetch(u_normal0, tap, 0).xyz,
                   texelFetch(u_radiance0, tap, 0).rgb);
        add_sample(sum, x, n, centre, texelFetch(u_depth1, tap, 0).r, texelFetch(u_normal1, tap, 0).xyz,
                   texelFetch(u_radiance1, tap, 0).rgb);
        useful += sum.count > before ? 1.0 : 0.0;
    }
    out_irradiance = vec4(sum.light * (6.2831853 / max(sum.count, 1.0)), useful / float(TAPS));
}
)";

// The reconstruction that section 3.1 asks for, separable: a Gaussian times the weight of the normals times that of the planes.
// dgb_bilateral_weight in deepgbuffer.h states the two. A texel beyond the border is the border's, the sky weighs nothing.
const char* const kBaselineBlur = R"(
uniform sampler2D u_depth0;
uniform sampler2D u_normal0;
uniform sampler2D u_irradiance;
uniform mat4 u_camera_from_clip;
uniform vec3 u_size; // pixels
uniform vec3 u_axis;

layout(location = 0) out vec4 out_irradiance;

vec3 position(vec2 pixel, float depth) {
    vec4 p = u_camera_from_clip * vec4(vec3(pixel / u_size.xy, depth) * 2.0 - 1.0, 1.0);
    return p.xyz / p.w;
}

float bilateral_weight(vec3 dq, vec3 n_x, vec3 n_y) {
    float normal = max(1.0 - NORMAL_SHARPNESS * (1.0 - dot(n_x, n_y)), 0.0);
    float away = length(dq);
    float off = max(abs(dot(dq, n_x)), abs(dot(dq, n_y)));
    float plane = away > 1e-6 ? max(1.0 - PLANE_SHARPNESS * off / away, 0.0) : 1.0;
    return normal * plane * plane;
}

void main() {
    ivec2 here = ivec2(gl_FragCoord.xy);
    float depth = texelFetch(u_depth0, here, 0).r;
    out_irradiance = vec4(0.0);
    if (depth == 1.0) return;
    vec3 x = position(gl_FragCoord.xy, depth);
    vec3 n = texelFetch(u_normal0, here, 0).xyz;
    vec4 sum = vec4(0.0);
    float total = 0.0;
    for (int i = -SIDE; i <= SIDE; ++i) {
        ivec2 tap = clamp(here + i * ivec2(u_axis.xy), ivec2(0), ivec2(u_size.xy) - 1);
        float tap_depth = texelFetch(u_depth0, tap, 0).r;
        vec3 dq = position(vec2(tap) + 0.5, tap_depth) - x;
        float weight = exp(-float(i * i) * (2.0 / float(SIDE * SIDE)));
        weight *= bilateral_weight(dq, n, texelFetch(u_normal0, tap, 0).xyz);
        if (tap_depth == 1.0) weight = 0.0;
        sum += weight * texelFetch(u_irradiance, tap, 0);
        total += weight;
    }
    out_irradiance = sum / total;
}
)";

class Baseline : public Contender {
public:
    Baseline(const Picture& picture, const dgb_params& params);

    void run() override;
    std::vector<float> irradiance() const override;

private:
    struct Step {
        const GlObject &program, &source, &framebuffer;
        glm::vec3 axis;
    };

    void bind_layers(GLuint program) const;
    void gather() const;
    void blur(const Step& step) const;

    Picture picture_;
    float radius_;
    std::vector<GlObject> normals_, radiances_; // one a layer
    GlObject gather_, blur_, vertices_;
    GlObject targets_[2], framebuffers_[2];
};

// A layer's texture as half floats.
GlObject make_half_floats(const EngineLayers& layers, const std::vector<float>& rgb) {
    GlObject texture = make_target(GL_RGBA16F, layers.width(), layers.height());
    glBindTexture(GL_TEXTURE_2D, texture.name());
    glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, layers.width(), layers.height(), GL_RGB, GL_FLOAT, rgb.data());
    return texture;
}

std::vector<float> pixels_of(const EngineLayers& layers, dgb_slot slot, int layer, GLenum format, size_t channels) {
    std::vector<float> pixels(channels * size_t(layers.width()) * size_t(layers.height()));
    glBindTexture(GL_TEXTURE_2D, layers.texture(slot, layer));
    glGetTexImage(GL_TEXTURE_2D, 0, format, GL_FLOAT, pixels.data());
    return pixels;
}

std::vector<float> decoded_normals(const EngineLayers& layers, int layer) {
    const std::vector<float> bytes = pixels_of(layers, DGB_NORMAL, layer, GL_RG, 2);
    std::vector<float> normals(bytes.size() / 2 * 3);
    for (size_t i = 0; i < bytes.size() / 2; ++i) {
        const long low = std::lround(bytes[2 * i] * 255.0f), high = std::lround(bytes[2 * i + 1] * 255.0f);
        dgb_oct16_decode(uint16_t(low | high << 8), &normals[3 * i]);
    }
    return normals;
}

Baseline::Baseline(const Picture& picture, const dgb_params& params)
    : picture_(picture), radius_(params.radius), vertices_(make_vertex_array()) {
    const EngineLayers& layers = *picture.layers;
    for (int i = 0; i < EngineLayers::kLayers; ++i) {
        normals_.push_back(make_half_floats(layers, decoded_normals(layers, i)));
        radiances_.push_back(make_half_floats(layers, pixels_of(layers, DGB_RADIANCE, i, GL_RGB, 3)));
    }
    const auto define = [](const char* name, auto value) {
        return std::string("#define ") + name + " " + std::to_string(value) + "\n";
    };
    gather_ = make_fullscreen_program("baseline gather", define("TAPS", params.samples) +
                                                             define("TURNS", dgb_spiral_turns(params.samples)) +
                                                             kBaselineGather);
    blur_ = make_fullscreen_program(
        "baseline blur", define("SIDE", params.filter_taps / 2) + define("NORMAL_SHARPNESS", params.normal_sharpness) +
                             define("PLANE_SHARPNESS", params.plane_sharpness) + kBaselineBlur);
    for (int i = 0; i < 2; ++i) {
        targets_[i] = make_target(GL_RGBA16F, layers.width(), layers.height());
        framebuffers_[i] = make_target_framebuffer(targets_[i]);
    }
}

void Baseline::bind_layers(GLuint program) const {
    const EngineLayers& layers = *picture_.layers;
    bind_texture(program, "u_depth0", 0, GL_TEXTURE_2D, layers.texture(DGB_DEPTH, 0));
    bind_texture(program, "u_normal0", 1, GL_TEXTURE_2D, normals_[0].name());
    set_uniform(program, "u_camera_from_clip", glm::inverse(picture_.projection));
    set_uniform(program, "u_size", glm::vec3(float(layers.width()), float(layers.height()), 0.0f));
}

void Baseline::gather() const {
    const EngineLayers& layers = *picture_.layers;
    const GLuint program = gather_.name();
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffers_[0].name());
    glUseProgram(program);
    bind_layers(program);
    bind_texture(program, "u_depth1", 2, GL_TEXTURE_2D, layers.texture(DGB_DEPTH, 1));
    bind_texture(program, "u_normal1", 3, GL_TEXTURE_2D, normals_[1].name());
    bind_texture(program, "u_radiance0", 4, GL_TEXTURE_2D, radiances_[0].name());
    bind_texture(program, "u_radiance1", 5, GL_TEXTURE_2D, radiances_[1].name());
    set_uniform(program, "u_radius", radius_);
    set_uniform(program, "u_pixels_per_metre", 0.5f * float(layers.height()) * picture_.projection[1][1]);
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

void Baseline::blur(const Step& step) const {
    const GLuint program = step.program.name();
    glBindFramebuffer(GL_FRAMEBUFFER, step.framebuffer.name());
    glUseProgram(program);
    bind_layers(program);
    bind_texture(program, "u_irradiance", 2, GL_TEXTURE_2D, step.source.name());
    set_uniform(program, "u_axis", step.axis);
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

void Baseline::run() {
    glViewport(0, 0, picture_.layers->width(), picture_.layers->height());
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_BLEND);
    glBindVertexArray(vertices_.name());
    clock_.begin();
    gather();
    clock_.end("gather");
    clock_.begin();
    blur({blur_, targets_[0], framebuffers_[1], glm::vec3(1.0f, 0.0f, 0.0f)});
    blur({blur_, targets_[1], framebuffers_[0], glm::vec3(0.0f, 1.0f, 0.0f)});
    clock_.end("reconstruct");
}

std::vector<float> Baseline::irradiance() const {
    std::vector<float> rgba(4 * size_t(picture_.layers->width()) * size_t(picture_.layers->height()));
    glBindTexture(GL_TEXTURE_2D, targets_[0].name());
    glGetTexImage(GL_TEXTURE_2D, 0, GL_RGBA, GL_FLOAT, rgba.data());
    return rgba;
}

// ---- Measuring ------------------------------------------------------------------------------------------

enum ContenderId { kOne, kTwo, kTwoEverywhere, kOneDeep, kTwoDeep, kLight, kBaseline, kCopy, kContenderCount };

constexpr const char* kNames[kContenderCount] = {"one layer",
                                                 "two layers",
                                                 "two layers, no tiles",
                                                 "one layer, bounces",
                                                 "two layers, bounces",
                                                 "two layers, no occlusion",
                                                 "baseline",
                                                 "copy"};

struct Measured {
    std::array<Samples, kContenderCount> samples;
    double second_layer = 0.0;     // share of the pixels that have one
    double baseline_picture = 0.0; // its mean irradiance over that of the library with the same equation and taps
};

std::unique_ptr<SceneRenderer> make_renderer(int layers, const GpuScene& scene, const SceneLights& lights,
                                             PassTimes* times) {
    RendererDesc desc;
    desc.get_proc = headless_get_proc;
    desc.layers.width = kWidth;
    desc.layers.height = kHeight;
    desc.layers.layers = layers;
    desc.scene = &scene;
    desc.lights = &lights;
    desc.times = times;
    return std::make_unique<SceneRenderer>(desc);
}

std::vector<std::unique_ptr<Contender>> make_contenders(const Picture& picture, const dgb_params& params) {
    const uint32_t plain = DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY;
    const uint32_t all = plain | DGB_EFFECT_BOUNCES | DGB_EFFECT_TEMPORAL;
    dgb_params everywhere = params;
    everywhere.adaptive = false;
    const auto chain = [&](int layers, uint32_t effects, const dgb_params& own) {
        return std::make_unique<Chain>(picture, EngineLayers::describe(kWidth, kHeight, layers, effects), own);
    };
    std::vector<std::unique_ptr<Contender>> contenders;
    contenders.push_back(chain(1, plain, params));
    contenders.push_back(chain(2, plain, params));
    contenders.push_back(chain(2, plain, everywhere));
    contenders.push_back(chain(1, all, params));
    contenders.push_back(chain(2, all, params));
    contenders.push_back(chain(2, DGB_EFFECT_RADIOSITY, params)); // what the baseline does
    contenders.push_back(std::make_unique<Baseline>(picture, params));
    contenders.push_back(std::make_unique<CopyPass>());
    return contenders;
}

// Of irradiance alone, without confidence.
double sum_of_light(const std::vector<float>& rgba) {
    double total = 0.0;
    for (size_t i = 0; i < rgba.size(); ++i) { total += i % 4 == 3 ? 0.0 : rgba[i]; }
    return total;
}

// Whether the baseline computes what it should: the library by the same equation, with full-resolution taps. Not filtered,
// because the library's filter weighs by confidence and the baseline's does not.
double baseline_over_library(const Picture& picture, dgb_params params, const Contender& baseline) {
    dgb_desc desc = EngineLayers::describe(kWidth, kHeight, 2, DGB_EFFECT_RADIOSITY);
    desc.normaliser = DGB_NORMALISER_PAPER;
    params.min_level = 0;
    params.filter_taps = 1;
    Chain same(picture, desc, params);
    same.run();
    return sum_of_light(baseline.irradiance()) / sum_of_light(same.irradiance());
}

double share_filled(const std::vector<float>& z) {
    return double(std::count_if(z.begin(), z.end(), [](float value) { return value != 0.0f; })) / double(z.size());
}

// The layers pass, in turns with the rest.
void time_layers(SceneRenderer* renderer, const Picture& picture, const dgb_params& params, PassClock* clock) {
    SceneFrame frame;
    frame.view = picture.view;
    frame.projection = picture.projection;
    clock->begin();
    renderer->build(frame, params);
    clock->end("layers");
}

Measured measure(const View& view, const GpuScene& scene, const SceneLights& lights, Taps taps, int frames) {
    dgb_params params = dgb_preset(DGB_PRESET_BALANCED);
    params.ao_samples = taps.ao;
    params.samples = taps.gather;
    PassTimes unused(false);
    std::unique_ptr<SceneRenderer> renderers[2];
    const glm::mat4 projection = projection_matrix(view.camera, kAspect, ClipRange::standard);
    for (int i = 0; i < 2; ++i) {
        renderers[i] = make_renderer(i + 1, scene, lights, &unused);
        renderers[i]->render(view_matrix(view.camera), projection, params);
    }
    const EngineLayers layers(*renderers[1]);
    const Picture picture{view_matrix(view.camera), projection, &layers};
    Measured measured;
    measured.second_layer = share_filled(renderers[1]->read_z(1));

    PassClock layer_clocks[2];
    const auto contenders = make_contenders(picture, params);
    std::vector<size_t> turns(contenders.size());
    std::iota(turns.begin(), turns.end(), size_t{0});
    std::mt19937 random(1); // the same each time
    for (int frame = 0; frame < kWarmUp + frames; ++frame) {
        if (frame == kWarmUp) {
            for (const auto& contender : contenders) { contender->forget(); }
            for (PassClock& clock : layer_clocks) { clock.forget(); }
        }
        std::shuffle(turns.begin(), turns.end(),
                     random); // each follows each: what it left in the caches helps the next
        for (const size_t turn : turns) { contenders[turn]->run(); }
        for (int i = 0; i < 2; ++i) { time_layers(renderers[i].get(), picture, params, &layer_clocks[i]); }
    }
    for (size_t i = 0; i < contenders.size(); ++i) {
        measured.samples[i] = contenders[i]->samples();
        if (i <= kTwoDeep) {
            const PassClock& clock = layer_clocks[i == kOne || i == kOneDeep ? 0 : 1];
            measured.samples[i]["layers"] = clock.milliseconds().at("layers");
        }
    }
    measured.baseline_picture = baseline_over_library(picture, params, *contenders[kBaseline]);
    return measured;
}

// ---- Results --------------------------------------------------------------------------------------------

// "total" is the whole chain, the layers left out.
std::vector<double> times(const Measured& measured, ContenderId contender, const std::string& pass) {
    const Samples& samples = measured.samples[contender];
    if (pass == "total") { return sum(samples, kChain); }
    const auto found = samples.find(pass);
    return found != samples.end() ? found->second : std::vector<double>();
}

double ratio(const Measured& measured, ContenderId over, ContenderId under, const std::string& pass) {
    return median_ratio(times(measured, over, pass), times(measured, under, pass));
}

void print_number(double value, bool is_there, int digits) {
    is_there ? std::printf(" %11.*f", digits, value) : std::printf(" %11s", "-");
}

void print_row(const Measured& m, const char* pass) {
    std::printf("    %-12s", pass);
    const auto there = [&](ContenderId contender) { return !times(m, contender, pass).empty(); };
    const auto print_pair = [&](ContenderId one, ContenderId two) {
        for (ContenderId id : {one, two}) { print_number(median(times(m, id, pass)), there(id), 2); }
        print_number(there(one) ? ratio(m, two, one, pass) : 0.0, there(one) && there(two), 2);
    };
    print_pair(kOne, kTwo);
    const bool differs = there(kTwoEverywhere) && there(kTwo) && std::strcmp(pass, "layers") != 0;
    print_number(differs ? ratio(m, kTwo, kTwoEverywhere, pass) : 0.0, differs, 2);
    std::printf(" |");
    print_pair(kOneDeep, kTwoDeep);
    std::printf(" |");
    print_number(median(times(m, kBaseline, pass)), there(kBaseline), 2);
    print_number(there(kTwo) ? median_ratio(times(m, kTwo, pass), m.samples[kCopy].at("copy")) : 0.0, there(kTwo), 1);
    std::printf("\n");
}

void print_table(const View& view, Taps taps, const Measured& m) {
    std::printf(
        "\n%s, %dx%d, AO N = %d, radiosity N = %d with normal test; %.1f %% of the pixels have a second layer\n",
        view.name.c_str(), kWidth, kHeight, taps.ao, taps.gather, 100.0 * m.second_layer);
    std::printf("    %-12s %35s %11s | %35s |\n", "", "occlusion and one bounce, ms", "",
                "bounces and temporal filter, ms");
    std::printf("    %-12s %11s %11s %11s %11s | %11s %11s %11s | %11s %11s\n", "pass", "1 layer", "2 layers", "2 / 1",
                "/ no tiles", "1 layer", "2 layers", "2 / 1", "baseline", "2 x copy");
    for (const char* pass : {"layers", "pack", "mip", "tiles", "ao", "gather", "temporal", "reconstruct", "total"}) {
        print_row(m, pass);
    }
}

void print_goal(const char* what, double value, double goal) {
    std::printf("    %-62s %5.2f  (goal %.2f, %s)\n", what, value, goal, value <= goal ? "hit" : "missed");
}

void print_goals(const Measured& m, bool is_preset) {
    const Samples &two = m.samples[kTwo], &baseline = m.samples[kBaseline];
    std::vector<const char*> frame(std::begin(kChain), std::end(kChain));
    frame.push_back("layers");
    const Samples& light = m.samples[kLight];
    const auto over_baseline = [&](const Samples& ours, std::initializer_list<const char*> passes) {
        return median_ratio(sum(ours, passes), sum(baseline, {"gather", "reconstruct"}));
    };
    print_goal("occlusion, two layers / one", ratio(m, kTwo, kOne, "ao"), 1.12);
    print_goal("gather, two layers / one", ratio(m, kTwo, kOne, "gather"), 1.40);
    print_goal("whole chain with deep propagation, two layers / one", ratio(m, kTwoDeep, kOneDeep, "total"), 1.70);
    print_goal("pack + mip / frame (layers to reconstruct)", median_ratio(sum(two, {"pack", "mip"}), sum(two, frame)),
               0.15);
    print_goal("reconstruct / (ao + gather)", median_ratio(two.at("reconstruct"), sum(two, {"ao", "gather"})), 0.80);
    const double of_light = over_baseline(light, {"gather", "reconstruct"});
    if (is_preset) { print_goal("gather + reconstruct / baseline's", of_light, 0.50); }
    std::printf(
        "      gather alone %.2f, reconstruct alone %.2f; with pack, mip and tiles, which the baseline needs not, "
        "%.2f; gather + reconstruct with occlusion filtered along %.2f\n",
        median_ratio(light.at("gather"), baseline.at("gather")),
        median_ratio(light.at("reconstruct"), baseline.at("reconstruct")),
        over_baseline(light, {"pack", "mip", "tiles", "gather", "reconstruct"}),
        over_baseline(two, {"gather", "reconstruct"}));
    std::printf(
        "      the baseline's mean irradiance is %.2f of the library's with full-resolution taps and Equation 4\n",
        m.baseline_picture);
}

double percent_saved(const Measured& m, const char* pass) {
    return 100.0 * (1.0 - ratio(m, kTwo, kTwoEverywhere, pass));
}

void print_second_layer(const Measured& m) {
    std::printf(
        "    second layer where there is one in %.1f %% of the pixels: gather x %.2f, with deep propagation x %.2f; "
        "published for Sponza, of all radiosity, by preset: 2.0+0.7, 3.4+0.5, 6.3+0.9 ms, x 1.35, 1.15, 1.14 (the "
        "paper's, another machine: GTX 980, 1080p)\n",
        100.0 * m.second_layer, ratio(m, kTwo, kOne, "gather"), ratio(m, kTwoDeep, kOneDeep, "gather"));
    std::printf("    adaptive tiles save of two layers: occlusion %.0f %%, gather %.0f %%, whole chain %.0f %%\n",
                percent_saved(m, "ao"), percent_saved(m, "gather"), percent_saved(m, "total"));
}

void write_csv(std::FILE* csv, const View& view, Taps taps, const Measured& m) {
    for (int id = 0; id < kContenderCount; ++id) {
        const auto contender = ContenderId(id);
        const ContenderId one = contender == kTwoDeep || contender == kOneDeep ? kOneDeep : kOne;
        std::vector<std::string> passes{"total"};
        for (const auto& pass : m.samples[contender]) { passes.push_back(pass.first); }
        for (const std::string& pass : passes) {
            const std::vector<double> ms = times(m, contender, pass), base = times(m, one, pass);
            if (ms.empty()) { continue; }
            std::fprintf(csv, "%s,%d,%d,%.5f,\"%s\",%s,%.4f,", view.name.c_str(), taps.ao, taps.gather, m.second_layer,
                         kNames[id], pass.c_str(), median(ms));
            base.empty() ? std::fprintf(csv, "\n") : std::fprintf(csv, "%.4f\n", median_ratio(ms, base));
        }
    }
    std::fflush(csv);
}

void run(const std::string& argument, bool quick, std::FILE* csv) {
    const View view = load_view(argument);
    const GpuScene scene(view.scene);
    SceneLights lights(view.scene, scene, {sun_light(view.to_sun, 4.0f)});
    lights.update(*scene.first_pose());
    const int preset_taps = dgb_preset(DGB_PRESET_BALANCED).samples;
    for (const Taps taps : {Taps{16, preset_taps}, Taps{32, 30}}) {
        const Measured measured = measure(view, scene, lights, taps, quick ? 12 : 32);
        print_table(view, taps, measured);
        print_goals(measured, taps.gather == preset_taps);
        print_second_layer(measured);
        write_csv(csv, view, taps, measured);
        std::fflush(stdout);
        if (quick) { return; }
    }
}

void run(const Options& options) {
    const File csv = result_file("shading.csv");
    std::fprintf(csv.get(), "scene,ao_taps,taps,second_layer_share,contender,pass,ms,over_one_layer\n");
    std::printf("by %s time\n", is_software_rasteriser() ? "process" : "wall");
    if (options.scenes.empty()) { run(std::string(), options.quick, csv.get()); }
    for (const std::string& scene : options.scenes) { run(scene, options.quick, csv.get()); }
}

} // namespace

int main(int argc, char** argv) { return run_benchmark("shading", argc, argv, run); }
