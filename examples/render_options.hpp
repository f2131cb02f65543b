// The command line of render, most of which the viewer shares: options, their defaults, and what makes them wrong.
#pragma once

#include "render_camera.hpp"
#include "scene_lights.hpp"

#include "deepgbuffer.h"

#include <CLI/CLI.hpp>
#include <glm/glm.hpp>

#include <cerrno>
#include <cstdlib>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

// A picture that --dump can write, and what it takes to have it.
struct DumpKind {
    const char* name;
    int layers;
    uint32_t effects; // DGB_EFFECT_*
};

inline const DumpKind kDumpKinds[] = {
    {"z0", 1, 0},
    {"z1", 2, 0},
    {"normal0", 1, 0},
    {"normal1", 2, 0},
    {"albedo0", 1, 0},
    {"albedo1", 2, 0},
    {"radiance0", 1, 0},
    {"radiance1", 2, 0},
    {"ao", 1, DGB_EFFECT_AO},
    {"ao_raw", 1, DGB_EFFECT_AO},
    {"bent", 1, DGB_EFFECT_BENT},
    {"irradiance0", 1, DGB_EFFECT_RADIOSITY},
    {"irradiance0_raw", 1, DGB_EFFECT_RADIOSITY},
    {"irradiance1", 2, DGB_EFFECT_RADIOSITY},
    {"irradiance1_raw", 2, DGB_EFFECT_RADIOSITY},
    {"confidence0", 1, DGB_EFFECT_RADIOSITY},
    {"confidence1", 2, DGB_EFFECT_RADIOSITY},
    {"history0", 1, DGB_EFFECT_RADIOSITY},
    {"history1", 2, DGB_EFFECT_RADIOSITY},
    {"reflection", 1, DGB_EFFECT_REFLECT},
    {"reflection_raw", 1, DGB_EFFECT_GLOSSY},
    {"reflect_confidence", 1, DGB_EFFECT_REFLECT},
    {"reflect_layer", 1, DGB_EFFECT_REFLECT},
    {"reflect_length", 1, DGB_EFFECT_REFLECT},
    {"final", 1, 0},
};

struct Dump {
    std::string name, file;
};

enum class ProbeKind { constant, sky, cube };
inline const char* const kProbeNames[] = {"constant", "sky", "cube"};

struct Options {
    std::string scene; // empty: the atrium
    std::string out;   // empty: no PNG files
    std::string json;  // empty: none
    std::vector<Dump> dumps;
    bool plan = false;
    bool profile = false;

    int width = 1280, height = 720, guard = 64, layers = 2; // pixels
    int divisor = 1;                                        // of the resolution of layers behind the first
    dgb_oracle oracle = DGB_ORACLE_REPROJECT;
    dgb_emission emission = DGB_EMISSION_AUTO;
    dgb_tracer tracer = DGB_TRACER_LINEAR;
    dgb_estimator estimator = DGB_ESTIMATOR_PAPER;
    dgb_thickness thickness = DGB_THICKNESS_LAYERS;
    uint32_t effects = DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY | DGB_EFFECT_BOUNCES | DGB_EFFECT_TEMPORAL;
    dgb_params params = dgb_preset(DGB_PRESET_BALANCED);

    std::optional<RenderCamera> camera; // none: the file's, or one that frames the scene
    float ortho_height = 0.0f;          // metres; 0: as the camera says
    ClipRange clip = ClipRange::standard;
    std::optional<PunctualLight> sun;  // none: the scene's default
    std::vector<PunctualLight> points; // what is added to the lights of the file
    glm::vec3 sky{0.15f, 0.2f, 0.25f};
    ProbeKind probe = ProbeKind::constant;
    std::optional<float> roughness; // of every surface; none: as the materials say
    float exposure = 0.0f;          // powers of two
    int frames = 8;
    std::optional<int> bounces;        // none: one more each frame
    std::vector<int> compared_bounces; // empty: no such picture
    float orbit = 0.0f;                // degrees a frame
    double time = 0.0;                 // of the first frame, s
    double fps = 30.0;                 // frames a second of animation

    // What a dump shows: with DELAY, the frame before the last one, if there is one.
    int frame_drawn() const { return oracle == DGB_ORACLE_DELAY && layers > 1 && frames > 1 ? frames - 2 : frames - 1; }
    float aspect() const { return float(width) / float(height); }
    // The last frames hand on light, as many as it takes to show the bounces asked for. The first eight of them keep no
    // history, which would hold back the new bounce; what a later one adds is too little to matter.
    dgb_params params_of(int frame) const {
        dgb_params result = params;
        const int handed_on = bounces ? frame - (frames - *bounces) : frame;
        if (handed_on <= 0) { result.bounce_damping = 0.0f; }
        if (bounces && handed_on > 0 && handed_on <= 8) { result.history_weight = 0.0f; }
        return result;
    }
};

// What the library is asked for; backend and log are still missing.
inline dgb_desc layers_desc(const Options& options) {
    dgb_desc desc{};
    desc.width = options.width;
    desc.height = options.height;
    desc.guard_band = options.guard;
    desc.layers = options.layers;
    desc.divisor = options.divisor;
    desc.effects = options.effects;
    desc.oracle = options.oracle;
    desc.emission = options.emission;
    desc.tracer = options.tracer;
    desc.estimator = options.estimator;
    desc.thickness = options.thickness;
    desc.reversed = options.clip != ClipRange::standard;
    desc.clip = desc.reversed ? DGB_CLIP_ZERO_TO_ONE : DGB_CLIP_NEGATIVE_ONE_TO_ONE;
    return desc;
}

namespace render_options {

using Words = std::vector<std::string>;

inline std::string joined(const Words& words) {
    std::string text;
    for (size_t i = 0; i < words.size(); ++i) {
        text += (i == 0 ? "" : i + 1 == words.size() ? " or " : ", ") + words[i];
    }
    return text;
}

// "a,,b" has three parts, one of them empty.
inline Words split(const std::string& text, char separator) {
    Words parts(1);
    for (char c : text) {
        if (c == separator) {
            parts.emplace_back();
        } else {
            parts.back() += c;
        }
    }
    return parts;
}

inline std::optional<float> to_number(const std::string& text) {
    char* end = nullptr;
    const float value = std::strtof(text.c_str(), &end);
    if (text.empty() || *end != '\0' || !std::isfinite(value)) { return std::nullopt; }
    return value;
}

inline std::vector<float> to_numbers(const std::string& text) {
    std::vector<float> numbers;
    for (const std::string& part : split(text, ',')) {
        const std::optional<float> number = to_number(part);
        if (!number) { return {}; }
        numbers.push_back(*number);
    }
    return numbers;
}

inline void require(bool condition, const char* option, const std::string& what) {
    if (!condition) { throw CLI::ValidationError(option, what); }
}

// ---- Options that take one word or number ---------------------------------------------------------------

template <typename T>
struct Choice {
    const char* word;
    T value;
};

// The value of each word; `set` receives the one that was chosen.
template <typename T, typename Set>
void add_choice(CLI::App* app, const char* name, std::vector<Choice<T>> choices, Set set, const char* help) {
    Words words;
    for (const Choice<T>& choice : choices) { words.emplace_back(choice.word); }
    const auto parse = [=](const std::string& word) {
        for (const Choice<T>& choice : choices) {
            if (word == choice.word) { return set(choice.value); }
        }
        require(false, name, "must be " + joined(words));
    };
    app->add_option_function<std::string>(name, parse, help);
}

// Finite numbers only: NaN is in no range.
inline CLI::Validator between(double low, double high, const std::string& what) {
    return {[=](std::string& text) {
                const double value = to_number(text).value_or(std::numeric_limits<float>::quiet_NaN());
                return value >= low && value <= high ? std::string() : "must be " + what;
            },
            ""};
}

inline CLI::Validator positive() { return between(1e-6, 1e9, "a number above 0"); }

// ---- Options that take a list ---------------------------------------------------------------------------

inline void parse_size(const std::string& text, Options* options) {
    const Words parts = split(text, 'x');
    const auto side = [&](size_t i) {
        const bool digits = parts[i].find_first_not_of("0123456789") == std::string::npos;
        return digits && parts[i].size() < 6 ? std::atoi(parts[i].c_str()) : 0;
    };
    options->width = parts.size() == 2 ? side(0) : 0;
    options->height = parts.size() == 2 ? side(1) : 0;
    const auto fits = [](int pixels) { return pixels >= 1 && pixels <= DGB_MAX_SIZE; };
    require(fits(options->width) && fits(options->height), "--size",
            "must be WxH, each 1 to " + std::to_string(DGB_MAX_SIZE) + " pixels, like 1280x720");
}

inline void parse_effects(const std::string& text, Options* options) {
    options->effects = 0;
    if (text == "none") { return; }
    for (const std::string& word : split(text, ',')) {
        require(word == "ao" || word == "gi" || word == "reflect" || word == "glossy" || word == "bent", "--effects",
                "must be none or a comma list of ao, bent, gi, reflect and glossy");
        options->effects |= word == "ao"        ? DGB_EFFECT_AO
                            : word == "bent"    ? DGB_EFFECT_AO | DGB_EFFECT_BENT
                            : word == "gi"      ? DGB_EFFECT_RADIOSITY | DGB_EFFECT_BOUNCES
                            : word == "reflect" ? DGB_EFFECT_REFLECT
                                                : DGB_EFFECT_REFLECT | DGB_EFFECT_GLOSSY;
    }
    const bool averaged = (options->effects & (DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY | DGB_EFFECT_GLOSSY)) != 0;
    options->effects |= averaged ? DGB_EFFECT_TEMPORAL : 0;
}

inline void parse_camera(const std::string& text, Options* options) {
    const std::vector<float> n = to_numbers(text);
    require(n.size() == 7, "--camera", "must be seven numbers: ex,ey,ez,tx,ty,tz,fov");
    RenderCamera camera;
    camera.eye = {n[0], n[1], n[2]};
    camera.target = {n[3], n[4], n[5]};
    require(glm::distance(camera.eye, camera.target) > 0.0f, "--camera", "needs a target away from the eye");
    require(n[6] > 0.0f && n[6] < 180.0f, "--camera", "needs a field of view above 0 and below 180 degrees");
    camera.up = upright(camera.target - camera.eye);
    camera.vertical_fov = glm::radians(n[6]);
    options->camera = camera;
}

inline void parse_sun(const std::string& text, Options* options) {
    options->sun = PunctualLight{};
    if (text == "none") { return; }
    const std::vector<float> n = to_numbers(text);
    require(n.size() == 4, "--sun", "must be none or four numbers: dx,dy,dz,strength");
    const glm::vec3 to_sun(n[0], n[1], n[2]);
    require(glm::length(to_sun) > 0.0f, "--sun", "needs a direction that is not 0,0,0");
    require(n[3] >= 0.0f, "--sun", "needs a strength of 0 or more");
    options->sun = sun_light(to_sun, n[3]);
}

inline void parse_point(const std::string& text, Options* options) {
    const std::vector<float> n = to_numbers(text);
    require(n.size() == 4, "--point", "must be four numbers: x,y,z,intensity");
    require(n[3] >= 0.0f, "--point", "needs an intensity of 0 or more");
    options->points.push_back(point_light({n[0], n[1], n[2]}, n[3]));
}

inline void parse_sky(const std::string& text, Options* options) {
    const std::vector<float> n = to_numbers(text);
    require(n.size() == 3 && n[0] >= 0.0f && n[1] >= 0.0f && n[2] >= 0.0f, "--sky",
            "must be three numbers of 0 or more: r,g,b");
    options->sky = {n[0], n[1], n[2]};
}

inline glm::vec2 parse_boost(const std::string& text) {
    const std::vector<float> n = to_numbers(text);
    require(n.size() == 2 && n[0] >= 0.0f && n[1] >= 0.0f, "--boost",
            "must be two numbers of 0 or more: unsaturated,saturated");
    return {n[0], n[1]};
}

inline std::vector<int> parse_bounces(const std::string& text) {
    std::vector<int> bounces;
    for (const float n : to_numbers(text)) {
        bounces.push_back(n >= 1.0f && n <= 1000.0f && n == std::floor(n) ? int(n) : 0);
    }
    const bool valid = std::find(bounces.begin(), bounces.end(), 0) == bounces.end();
    require(valid && !bounces.empty() && bounces.size() <= 4, "--compare-bounces",
            "must be one to four whole numbers from 1 to 1000: n,n,...");
    return bounces;
}

inline void parse_dump(const std::string& text, Options* options) {
    const size_t equals = text.find('=');
    const std::string name = text.substr(0, equals);
    const std::string file = equals == std::string::npos ? "" : text.substr(equals + 1);
    Words names;
    for (const DumpKind& kind : kDumpKinds) { names.emplace_back(kind.name); }
    const bool known = std::find(names.begin(), names.end(), name) != names.end();
    require(known && !file.empty(), "--dump", "must be NAME=FILE.pfm with NAME " + joined(names));
    options->dumps.push_back({name, file});
}

// ---- All options ----------------------------------------------------------------------------------------

// Presets are read first, so that every other option overrides them wherever it stands.
struct Overrides {
    dgb_preset_id preset = DGB_PRESET_BALANCED;
    std::optional<int> samples;
    std::optional<float> separation;
    float radius = 7.4f;    // m
    float ao_radius = 1.0f; // m
    int ao_samples = 16;
    std::optional<int> slices;
    std::optional<float> thickness; // m
    std::optional<float> alpha, delta;
    std::optional<glm::vec2> boost; // of grey, of saturated colour
    std::optional<int> reflect_steps;
    std::optional<float> reflect_distance, reflect_thickness; // m
};

inline void apply(const Overrides& overrides, Options* options) {
    dgb_params& params = options->params;
    params = dgb_preset(overrides.preset);
    params.samples = overrides.samples.value_or(params.samples);
    params.separation = overrides.separation.value_or(params.separation);
    params.radius = overrides.radius;
    params.ao_radius = overrides.ao_radius;
    params.ao_samples = overrides.ao_samples;
    params.slices = overrides.slices.value_or(params.slices);
    params.thickness = overrides.thickness.value_or(params.thickness);
    params.history_weight = overrides.alpha.value_or(params.history_weight);
    params.bounce_damping = overrides.delta.value_or(params.bounce_damping);
    params.reflect_steps = overrides.reflect_steps.value_or(params.reflect_steps);
    params.reflect_distance = overrides.reflect_distance.value_or(params.reflect_distance);
    params.reflect_thickness = overrides.reflect_thickness.value_or(params.reflect_thickness);
    if (overrides.boost) {
        params.boost_unsaturated = overrides.boost->x;
        params.boost_saturated = overrides.boost->y;
    }
}

inline void add_scene(CLI::App* app, Options* o) {
    app->add_option(
        "SCENE", o->scene,
        "glTF 2.0 file, .gltf or .glb; or one of the procedural scenes: atrium (the default), gallery (mirrors)");
}

inline void add_outputs(CLI::App* app, Options* o) {
    app->add_option("--out", o->out,
                    "directory for PNG pictures, made if it is not there: final, direct, indirect, ambient_visibility, "
                    "layer0, layer1 (albedo), one_vs_two, indirect_one_vs_two (layers). With ao also "
                    "visibility_one_vs_two. With gi "
                    "also confidence (and its histogram), fallback (the probe's light, the gathered light, both "
                    "blended by confidence, their "
                    "average) and second_alone (both layers, the first only, the second only). With ao and gi also "
                    "disocclusion (what last frame did not have in its first layer, or in neither)");
    app->add_option_function<Words>(
           "--dump",
           [=](const Words& dumps) {
               for (const std::string& dump : dumps) { parse_dump(dump, o); }
           },
           "NAME=FILE.pfm: write one picture as 32-bit floats; may be repeated")
        ->allow_extra_args(false);
    app->add_option("--json", o->json, "file for what was rendered, and how long it took");
    app->add_flag("--plan", o->plan, "print passes, textures and bytes, and render nothing")->disable_flag_override();
    app->add_flag("--profile", o->profile, "wait for the GPU after each pass, so that its CPU time is all its time")
        ->disable_flag_override();
    app->add_option("--frames", o->frames, "frames to render; files show the last (default 8)")
        ->check(between(1, 1e6, "1 to 1000000"));
    app->add_option("--bounces", o->bounces,
                    "bounces of light that the last frame shows, at most one a frame (default: one more each frame)")
        ->check(between(1, 1e6, "1 to 1000000"));
    app->add_option_function<std::string>(
        "--compare-bounces", [=](const std::string& list) { o->compared_bounces = parse_bounces(list); },
        "N,N,...: --out gets bounces.png, too: the last frame after so many bounces each, side by side");
}

inline void add_layers(CLI::App* app, Options* o, Overrides* overrides) {
    const auto text = [=](void (*parse)(const std::string&, Options*)) {
        return [=](const std::string& value) { parse(value, o); };
    };
    app->add_option_function<std::string>("--size", text(parse_size), "WxH pixels (default 1280x720)");
    app->add_option("--guard", o->guard, "guard band on every side, pixels (default 64)")
        ->check(between(0, DGB_MAX_SIZE, "0 to " + std::to_string(DGB_MAX_SIZE) + " pixels"));
    app->add_option("--layers", o->layers, "depth layers (default 2)")->check(between(1, DGB_MAX_LAYERS, "1 to 8"));
    app->add_option("--separation", overrides->separation, "minimum separation of the layers, m (default 0.5)")
        ->check(between(0, 1e9, "a number of 0 or more"));
    add_choice<dgb_oracle>(
        app, "--oracle",
        {{"peel", DGB_ORACLE_PEEL},
         {"previous", DGB_ORACLE_PREVIOUS},
         {"reproject", DGB_ORACLE_REPROJECT},
         {"warp", DGB_ORACLE_WARP},
         {"predict", DGB_ORACLE_PREDICT},
         {"delay", DGB_ORACLE_DELAY}},
        [=](dgb_oracle oracle) { o->oracle = oracle; },
        "what tells a layer where the one in front is: peel, previous, reproject (default), warp, predict, or delay, "
        "which shows the frame before");
    add_choice<dgb_emission>(
        app, "--emit",
        {{"auto", DGB_EMISSION_AUTO},
         {"separate", DGB_EMISSION_SEPARATE},
         {"geometry", DGB_EMISSION_GEOMETRY},
         {"vertex", DGB_EMISSION_VERTEX},
         {"instanced-geometry", DGB_EMISSION_INSTANCED_GEOMETRY},
         {"image", DGB_EMISSION_IMAGE},
         {"multicast", DGB_EMISSION_MULTICAST}},
        [=](dgb_emission emission) { o->emission = emission; },
        "how triangles reach all layers: auto (default), separate, geometry, vertex, instanced-geometry, image, "
        "multicast");
    add_choice<int>(
        app, "--divisor", {{"1", 1}, {"2", 2}, {"4", 4}}, [=](int divisor) { o->divisor = divisor; },
        "of the resolution of layers behind the first: 1 (default), 2 or 4");
}

inline void add_shading(CLI::App* app, Options* o, Overrides* overrides) {
    app->add_option_function<std::string>(
        "--effects", [=](const std::string& list) { parse_effects(list, o); },
        "none, or a comma list of ao, bent (where it opens to; with --estimator bitmask), gi, reflect (mirrors) and "
        "glossy (reflections by roughness) (default ao,gi)");
    add_choice<dgb_preset_id>(
        app, "--preset",
        {{"performance", DGB_PRESET_PERFORMANCE}, {"balanced", DGB_PRESET_BALANCED}, {"quality", DGB_PRESET_QUALITY}},
        [=](dgb_preset_id preset) { overrides->preset = preset; }, "performance, balanced (default), quality");
    app->add_option("--samples", overrides->samples, "taps of bounced light (default: the preset's)")
        ->check(between(1, DGB_MAX_TAPS, "1 to 256"));
    app->add_option("--radius", overrides->radius, "reach of bounced light, m (default 7.4)")->check(positive());
    app->add_option("--ao-samples", overrides->ao_samples, "taps of ambient occlusion (default 16)")
        ->check(between(1, DGB_MAX_TAPS, "1 to 256"));
    app->add_option("--ao-radius", overrides->ao_radius, "reach of ambient occlusion, m (default 1)")
        ->check(positive());
    add_choice<dgb_estimator>(
        app, "--estimator", {{"paper", DGB_ESTIMATOR_PAPER}, {"bitmask", DGB_ESTIMATOR_BITMASK}},
        [=](dgb_estimator estimator) { o->estimator = estimator; },
        "of ambient occlusion and bounced light: paper (default), bitmask (what surfaces cover of the hemisphere)");
    app->add_option("--slices", overrides->slices, "planes that share the taps of the bitmask (default 1)")
        ->check(between(1, DGB_MAX_SLICES, "1 to 8"));
    app->add_option("--thickness", overrides->thickness,
                    "how far behind its surface an object hides from the bitmask, m (default 0.5)")
        ->check(positive());
    app->add_option("--delta", overrides->delta, "share of light that each bounce hands on (default 1)")
        ->check(between(0, 1, "0 to 1"));
    app->add_option_function<std::string>(
        "--boost", [=](const std::string& pair) { overrides->boost = parse_boost(pair); },
        "u,s: factors of bounced light for grey and for saturated surfaces (default 1,1)");
    add_choice<dgb_thickness>(
        app, "--thickness-from",
        {{"constant", DGB_THICKNESS_CONSTANT}, {"layers", DGB_THICKNESS_LAYERS}, {"back", DGB_THICKNESS_BACK_FACES}},
        [=](dgb_thickness thickness) { o->thickness = thickness; },
        "what ends surfaces that are thinner than --thickness and --reflect-thickness: constant (nothing), layers "
        "(default: the second layer), back (that and back faces, drawn once more)");
    app->add_option("--reflect-steps", overrides->reflect_steps, "most steps of a mirrored ray (default 256)")
        ->check(between(1, 4096, "1 to 4096"));
    app->add_option("--reflect-distance", overrides->reflect_distance, "longest mirrored ray, m (default 30)")
        ->check(positive());
    app->add_option("--reflect-thickness", overrides->reflect_thickness,
                    "how far behind its surface an object stops a mirrored ray, m (default 0.5)")
        ->check(positive());
    add_choice<dgb_tracer>(
        app, "--tracer", {{"linear", DGB_TRACER_LINEAR}, {"hierarchical", DGB_TRACER_HIERARCHICAL}},
        [=](dgb_tracer tracer) { o->tracer = tracer; },
        "how mirrored rays are marched: linear (default), hierarchical; the picture is the same");
    app->add_option("--roughness", o->roughness, "of every surface, 0 to 1 (default: as the materials say)")
        ->check(between(0, 1, "0 to 1"));
    app->add_option("--alpha", overrides->alpha, "weight of the frames before, 0 to 0.999 (default 0.85)")
        ->check(between(0, 0.999, "0 to 0.999"));
}

inline void add_picture(CLI::App* app, Options* o) {
    const auto text = [=](void (*parse)(const std::string&, Options*)) {
        return [=](const std::string& value) { parse(value, o); };
    };
    app->add_option_function<std::string>("--camera", text(parse_camera),
                                          "ex,ey,ez,tx,ty,tz,fov: eye, target, vertical field of view in degrees "
                                          "(default: the file's first camera, else the whole scene)");
    app->add_option("--ortho", o->ortho_height, "orthographic, this many metres high")->check(positive());
    app->add_option_function<std::string>("--sun", text(parse_sun),
                                          "dx,dy,dz,strength towards the sun, W/m2; or none "
                                          "(default 0.6,0.6,0.3,6, or none where the file has lights)");
    app->add_option_function<Words>(
           "--point",
           [=](const Words& points) {
               for (const std::string& point : points) { parse_point(point, o); }
           },
           "x,y,z,intensity: a white point light, W/sr; may be repeated. It adds to the lights of the file, whose "
           "candela are taken for W/sr and lux for W/m2; " +
               std::to_string(kMaxLights) + " lights at most")
        ->allow_extra_args(false);
    app->add_option_function<std::string>("--sky", text(parse_sky),
                                          "r,g,b: radiance from everywhere (default 0.15,0.2,0.25)");
    add_choice<ProbeKind>(
        app, "--probe",
        {{kProbeNames[0], ProbeKind::constant}, {kProbeNames[1], ProbeKind::sky}, {kProbeNames[2], ProbeKind::cube}},
        [=](ProbeKind probe) { o->probe = probe; },
        "what comes from where no surface is known: constant (default), --sky from everywhere; sky, which is also seen "
        "there: --sky times 1.5 at the horizon, 0.75 at the zenith, 0.3 below; cube, the scene around the eye of "
        "the first frame, in direct light and two bounces of it, with --sky where it is open");
    app->add_option("--exposure", o->exposure, "powers of two, PNG only (default 0)")
        ->check(between(-30, 30, "-30 to 30"));
    app->add_option("--orbit", o->orbit, "degrees that the camera turns around its target a frame (default 0)")
        ->check(between(-360, 360, "-360 to 360 degrees"));
    app->add_option("--time", o->time, "what an animation shows in the first frame, s (default 0)")
        ->check(between(0, 1e6, "a number from 0 to 1000000"));
    app->add_option("--fps", o->fps, "frames a second of animation (default 30)")->check(positive());
    add_choice<ClipRange>(
        app, "--clip",
        {{"standard", ClipRange::standard},
         {"reversed", ClipRange::reversed},
         {"reversed-infinite", ClipRange::reversed_infinite}},
        [=](ClipRange clip) { o->clip = clip; }, "depth convention: standard (default), reversed, reversed-infinite");
}

inline void check_together(const Options& options) {
    require(options.bounces.value_or(1) <= options.frames, "--bounces",
            "needs as many --frames: light bounces once a frame");
    require(!(options.effects & DGB_EFFECT_BENT) || options.estimator == DGB_ESTIMATOR_BITMASK, "--effects",
            "bent needs --estimator bitmask");
    const bool gathers = (options.effects & DGB_EFFECT_RADIOSITY) != 0;
    require(options.compared_bounces.empty() || (gathers && !options.out.empty()), "--compare-bounces",
            "needs --out and --effects gi");
    for (const Dump& dump : options.dumps) {
        const DumpKind& kind = *std::find_if(std::begin(kDumpKinds), std::end(kDumpKinds),
                                             [&](const DumpKind& k) { return dump.name == k.name; });
        require(options.layers >= kind.layers, "--dump", dump.name + " needs --layers 2");
        require((options.effects & kind.effects) == kind.effects, "--dump",
                dump.name + " needs --effects " +
                    (kind.effects == DGB_EFFECT_AO          ? "ao"
                     : kind.effects == DGB_EFFECT_BENT      ? "bent"
                     : kind.effects == DGB_EFFECT_RADIOSITY ? "gi"
                     : kind.effects == DGB_EFFECT_GLOSSY    ? "glossy"
                                                            : "reflect"));
    }
}

} // namespace render_options

// Throws CLI::ParseError: CLI::Success to show the help, anything else is the user's mistake in one sentence.
inline Options parse_options(CLI::App* app, int argc, char** argv) {
    using namespace render_options;
    Options options;
    Overrides overrides;
    app->set_help_flag("--help", "print this help");
    add_scene(app, &options);
    add_outputs(app, &options);
    add_layers(app, &options, &overrides);
    add_shading(app, &options, &overrides);
    add_picture(app, &options);
    app->parse(argc, argv);
    apply(overrides, &options);
    check_together(options);
    return options;
}
