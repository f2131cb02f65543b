#include "setting.hpp"

#include <algorithm>
#include <cstdio>
#include <functional>
#include <iterator>
#include <random>
#include <stdexcept>
#include <type_traits>
#include <utility>

namespace {

constexpr float kRoom = 15.0f; // metres: the size of a scene from which on lengths are taken as they are
constexpr dgb_oracle kOracles[] = {DGB_ORACLE_PEEL,    DGB_ORACLE_PREVIOUS, DGB_ORACLE_REPROJECT,
                                   DGB_ORACLE_PREDICT, DGB_ORACLE_DELAY,    DGB_ORACLE_WARP};
constexpr const char* kPresets[] = {"performance", "balanced", "quality"};

template <typename... Values>
std::string text(const char* format, Values... values) {
    char buffer[256];
    std::snprintf(buffer, sizeof buffer, format, values...);
    return buffer;
}

// ---- Parameters -----------------------------------------------------------------------------------------

// Something to vary.
struct Parameter {
    const char* name;
    const char* mark; // in keys
    std::vector<double> values;
    std::function<double(const Setting&)> get;
    std::function<void(Setting*, double)> set;
    bool (*matters)(const Setting& setting); // to the picture
    const char* (*word)(int value);          // null: values are numbers

    std::string text_of(double value) const { return word != nullptr ? word(int(value)) : text("%g", value); }
};

template <typename T>
T& at(Setting& setting, T dgb_params::*member) {
    return setting.params.*member;
}
template <typename T>
T& at(Setting& setting, T dgb_desc::*member) {
    return setting.desc.*member;
}
template <typename T>
T& at(Setting& setting, T Setting::*member) {
    return setting.*member;
}

template <typename Member>
Parameter parameter(const char* name, const char* mark, std::vector<double> values, Member member,
                    bool (*matters)(const Setting&), const char* (*word)(int) = nullptr) {
    const auto get = [member](Setting s) { return double(at(s, member)); };
    const auto set = [member](Setting* s, double value) {
        auto& variable = at(*s, member);
        variable = std::decay_t<decltype(variable)>(value);
    };
    return {name, mark, std::move(values), get, set, matters, word};
}

// Of which the values are factors.
Parameter as_factor(Parameter parameter) {
    parameter.set = [get = parameter.get, set = parameter.set](Setting* s, double value) { set(s, value * get(*s)); };
    return parameter;
}

bool always(const Setting&) { return true; }
bool is_occlusion(const Setting& s) { return s.effect == Effect::occlusion; }
bool is_light(const Setting& s) { return s.effect == Effect::light; }
bool is_mirror(const Setting& s) { return s.effect == Effect::mirror; }
bool gathers(const Setting& s) { return !is_mirror(s); }
bool has_second(const Setting& s) { return s.desc.layers > 1; }
bool has_filter(const Setting& s) { return gathers(s) && s.params.filter_taps > 1; }
bool is_averaged(const Setting& s) { return gathers(s) && s.condition.frames > 1; }
bool is_averaged_light(const Setting& s) { return is_light(s) && is_averaged(s); }
bool is_bitmask(const Setting& s) { return gathers(s) && s.desc.estimator == DGB_ESTIMATOR_BITMASK; }
bool has_thickness(const Setting& s) { return is_mirror(s) || is_bitmask(s); }
bool is_papers_light(const Setting& s) { return is_light(s) && s.desc.estimator == DGB_ESTIMATOR_PAPER; }
bool has_papers_occlusion(const Setting& s) { return is_occlusion(s) && s.desc.estimator == DGB_ESTIMATOR_PAPER; }
bool has_papers_senders(const Setting& s) { return is_papers_light(s) && has_second(s); }

const char* oracle_word(int v) { return dgb_oracle_name(dgb_oracle(v)); }
const char* senders_word(int v) { return v == DGB_SENDERS_BOTH ? "both" : "strongest"; }
const char* normaliser_word(int v) { return v == DGB_NORMALISER_BOUNDED ? "bounded" : "paper"; }
const char* estimator_word(int v) { return v == DGB_ESTIMATOR_PAPER ? "paper" : "bitmask"; }
const char* baseline_word(int v) { return name_of(Baseline(v)); }
const char* thickness_word(int v) {
    return v == DGB_THICKNESS_LAYERS ? "layers" : v == DGB_THICKNESS_CONSTANT ? "constant" : "back";
}
const char* tracer_word(int v) { return v == DGB_TRACER_LINEAR ? "linear" : "hierarchical"; }

// The bitmask's confidence is the share of the hemisphere itself.
void set_estimator(Setting* s, double value) {
    s->desc.estimator = dgb_estimator(int(value));
    if (s->desc.estimator == DGB_ESTIMATOR_BITMASK) { s->coverage = 1.0f; }
}

// Everything there is to vary, one line each; one with the same name as another is of another effect.
std::vector<Parameter> make_parameters() {
    using Q = dgb_params;
    using D = dgb_desc;
    const std::vector<double> taps = {4, 8, 14, 20, 30, 60, 98}, radii = {0.5, 0.71, 1.41, 2.0};
    std::vector<Parameter> all = {
        parameter("layers", "k", {1, 2}, &D::layers, always),
        parameter("separation", "d", {0.0, 0.05, 0.1, 0.25, 0.5, 1.0, 2.0}, &Q::separation, has_second),
        parameter("oracle", "o", {std::begin(kOracles), std::end(kOracles)}, &D::oracle, has_second, oracle_word),
        parameter("divisor", "v", {1, 2, 4}, &D::divisor, has_second),
        parameter("taps", "n", taps, &Q::ao_samples, is_occlusion),
        parameter("taps", "n", taps, &Q::samples, is_light),
        as_factor(parameter("radius", "r", radii, &Q::ao_radius, is_occlusion)),
        as_factor(parameter("radius", "r", radii, &Q::radius, is_light)),
        parameter("min_level", "m", {0, 1, 2, 3, 4}, &Q::ao_min_level, is_occlusion),
        parameter("min_level", "m", {0, 1, 2, 3, 4}, &Q::min_level, is_light),
        parameter("filter_taps", "f", {1, 5, 9, 13, 21}, &Q::filter_taps, gathers),
        parameter("filter_step", "s", {1, 2, 3}, &Q::filter_step, has_filter),
        parameter("normal_test", "t", {0, 1}, &Q::normal_test, is_light),
        parameter("senders", "e", {DGB_SENDERS_BOTH, DGB_SENDERS_STRONGEST}, &D::senders, has_papers_senders,
                  senders_word),
        parameter("normaliser", "z", {DGB_NORMALISER_BOUNDED, DGB_NORMALISER_PAPER}, &D::normaliser, is_papers_light,
                  normaliser_word),
        parameter("estimator", "b", {DGB_ESTIMATOR_PAPER, DGB_ESTIMATOR_BITMASK}, &D::estimator, gathers,
                  estimator_word),
        // of one layer: for the lists below
        parameter("baseline", "a", {double(Baseline::none)}, &Setting::baseline, has_papers_occlusion, baseline_word),
        parameter("slices", "i", {1, 2, 4}, &Q::slices, is_bitmask),
        parameter("thickness", "h", {0.1, 0.25, 0.5, 1.0, 2.0}, &Q::thickness, is_bitmask),
        parameter("coverage", "c", {1, 1.5, 2, 3, 4}, &Setting::coverage, is_light),
        parameter("weight", "w", {0, 0.85, 0.95}, &Q::history_weight, is_averaged),
        parameter("history_clamp", "g", {0}, &Q::history_clamp, is_averaged),     // for the lists below
        parameter("sample_clamp", "u", {0}, &Q::sample_clamp, is_averaged_light), // likewise
        parameter("stride", "p", {1, 2, 4, 8, 16}, &Q::reflect_stride, is_mirror),
        parameter("thickness", "h", {0.05, 0.1, 0.25, 0.5, 1.0, 2.0}, &Q::reflect_thickness, is_mirror),
        parameter("thickness_from", "x", {DGB_THICKNESS_LAYERS, DGB_THICKNESS_CONSTANT, DGB_THICKNESS_BACK_FACES},
                  &D::thickness, has_thickness, thickness_word),
        parameter("tracer", "l", {DGB_TRACER_LINEAR, DGB_TRACER_HIERARCHICAL}, &D::tracer, is_mirror, tracer_word),
    };
    for (Parameter& p : all) {
        if (p.word == estimator_word) { p.set = set_estimator; }
    }
    return all;
}

const std::vector<Parameter>& parameters() {
    static const std::vector<Parameter> all = make_parameters();
    return all;
}

// A value of the parameter of that name.
struct Choice {
    const char* name;
    double value;
};

// What does not matter to the setting leaves it as it is.
Setting vary(Setting setting, const std::vector<Choice>& choices) {
    for (const Choice& choice : choices) {
        bool known = false;
        for (const Parameter& p : parameters()) {
            if (std::string(choice.name) != p.name) { continue; }
            known = true;
            if (!p.matters(setting)) { continue; }
            p.set(&setting, choice.value);
            setting.varied += (setting.varied.empty() ? "" : " ") + (p.name + ("=" + p.text_of(choice.value)));
        }
        if (!known) { throw std::logic_error(std::string("no such parameter: ") + choice.name); }
    }
    return setting;
}

// One value of every parameter but the radius, which is what is asked for, not how it is answered. All are drawn, so that what
// matters little does not change what comes after.
Setting random_setting(Effect effect, std::mt19937* random) {
    Setting setting = preset_setting(effect, DGB_PRESET_BALANCED);
    setting.around = "random";
    setting.varied = "all";
    for (const Parameter& p : parameters()) {
        if (p.values.size() == 1) { continue; } // for the lists below
        const double value = p.values[(*random)() % p.values.size()];
        if (std::string(p.name) != "radius") { p.set(&setting, value); }
    }
    return setting;
}

// ---- Lists ----------------------------------------------------------------------------------------------

void add_unless_there(std::vector<Setting>* settings, Setting setting) {
    const std::string key = key_of(setting);
    const bool there = std::any_of(settings->begin(), settings->end(), [&](const Setting& s) {
        return s.effect == setting.effect && s.condition == setting.condition && key_of(s) == key;
    });
    if (!there) { settings->push_back(std::move(setting)); }
}

// One parameter at a time.
void add_around(std::vector<Setting>* settings, const Setting& base) {
    for (const Parameter& p : parameters()) {
        if (!p.matters(base)) { continue; }
        for (const double value : p.values) { add_unless_there(settings, vary(base, {{p.name, value}})); }
    }
}

// What is told apart over frames: BALANCED but for these.
const std::vector<Choice> kOverFrames[] = {{},
                                           {{"weight", 0.95}},
                                           {{"layers", 1}},
                                           {{"filter_taps", 1}},
                                           {{"filter_taps", 5}},
                                           {{"layers", 1}, {"baseline", double(Baseline::sao)}},
                                           {{"layers", 1}, {"baseline", double(Baseline::gtao)}},
                                           {{"layers", 1}, {"estimator", DGB_ESTIMATOR_BITMASK}},
                                           {{"estimator", DGB_ESTIMATOR_BITMASK}},
                                           {{"estimator", DGB_ESTIMATOR_BITMASK}, {"weight", 0.95}},
                                           {{"weight", 0.95}, {"history_clamp", 1.0}},
                                           {{"weight", 0.95}, {"history_clamp", 3.0}},
                                           {{"weight", 0.95}, {"sample_clamp", 2.0}},
                                           {{"weight", 0.95}, {"sample_clamp", 10.0}}};

void add_over_frames(std::vector<Setting>* settings, Effect effect) {
    for (const bool moving : {false, true}) {
        for (const int frames : {1, 4, 16, 64}) {
            const Setting base = preset_setting(effect, DGB_PRESET_BALANCED, {frames, moving});
            for (const std::vector<Choice>& choices : kOverFrames) { add_unless_there(settings, vary(base, choices)); }
        }
    }
}

// Without history every frame is a first one: what tells them apart is the steps from one to the next.
const std::vector<Choice> kWithoutHistory[] = {
    {{"weight", 0.0}}, {{"weight", 0.0}, {"layers", 1}}, {{"weight", 0.0}, {"estimator", DGB_ESTIMATOR_BITMASK}}};

void add_without_history(std::vector<Setting>* settings, Effect effect) {
    const Setting base = preset_setting(effect, DGB_PRESET_BALANCED, {4, true});
    for (const std::vector<Choice>& choices : kWithoutHistory) { add_unless_there(settings, vary(base, choices)); }
}

void add_oracles(std::vector<Setting>* settings, Effect effect) {
    const Setting base = preset_setting(effect, DGB_PRESET_BALANCED, {16, true});
    add_unless_there(settings, base);
    for (const dgb_oracle oracle : kOracles) { add_unless_there(settings, vary(base, {{"oracle", double(oracle)}})); }
}

} // namespace

const char* name_of(Effect effect) {
    return effect == Effect::occlusion ? "ao" : effect == Effect::light ? "irradiance" : "reflection";
}

uint32_t effects_of(const Setting& setting) {
    const uint32_t bits[] = {DGB_EFFECT_AO, DGB_EFFECT_RADIOSITY, DGB_EFFECT_REFLECT};
    return bits[int(setting.effect)] | (is_averaged(setting) ? uint32_t(DGB_EFFECT_TEMPORAL) : 0u);
}

std::string key_of(const Setting& setting) {
    std::string key;
    for (const Parameter& p : parameters()) {
        if (p.matters(setting)) { key += (key.empty() ? "" : " ") + (p.mark + text("%g", p.get(setting))); }
    }
    return key;
}

Setting preset_setting(Effect effect, dgb_preset_id preset, Condition condition) {
    Setting setting;
    setting.effect = effect;
    setting.condition = condition;
    setting.around = kPresets[preset];
    setting.params = dgb_preset(preset);
    setting.params.guard_fraction = 0.0f;
    setting.params.reflect_steps = 1024; // as many as the image is long: no ray ends for want of them
    setting.params.reflect_border = 0.0f;
    return setting;
}

std::vector<Setting> all_settings(int random_count, uint32_t seed) {
    std::vector<Setting> settings;
    for (const Effect effect : kEffects) {
        // BALANCED first: what others share with it is called by its name
        for (const dgb_preset_id preset : {DGB_PRESET_BALANCED, DGB_PRESET_PERFORMANCE, DGB_PRESET_QUALITY}) {
            add_unless_there(&settings, preset_setting(effect, preset));
        }
        for (const dgb_preset_id preset : {DGB_PRESET_BALANCED, DGB_PRESET_QUALITY, DGB_PRESET_PERFORMANCE}) {
            add_around(&settings, preset_setting(effect, preset));
        }
        // so that what the second layer is worth is told from the best of either
        Setting one = preset_setting(effect, DGB_PRESET_BALANCED);
        one.desc.layers = 1;
        one.around = "one layer";
        add_around(&settings, one);
    }
    for (const Baseline baseline : {Baseline::sao, Baseline::gtao}) { // with what they could be given at another cost
        Setting one = preset_setting(Effect::occlusion, DGB_PRESET_BALANCED);
        one.desc.layers = 1;
        one.baseline = baseline;
        one.around = name_of(baseline);
        add_around(&settings, one);
    }
    for (const Effect effect : {Effect::occlusion, Effect::light}) {
        add_over_frames(&settings, effect);
        add_without_history(&settings, effect);
        add_oracles(&settings, effect);
    }
    std::mt19937 random(seed);
    for (int i = 0; i < random_count; ++i) {
        add_unless_there(&settings, random_setting(kEffects[size_t(i) % std::size(kEffects)], &random));
    }
    return settings;
}

std::vector<Setting> few_settings() {
    static const Choice telling[] = {{"layers", 1},
                                     {"taps", 4},
                                     {"taps", 60},
                                     {"separation", 0.0},
                                     {"filter_taps", 1},
                                     {"divisor", 2},
                                     {"oracle", DGB_ORACLE_PEEL},
                                     {"normal_test", 0},
                                     {"senders", DGB_SENDERS_STRONGEST},
                                     {"stride", 1},
                                     {"stride", 8},
                                     {"tracer", DGB_TRACER_HIERARCHICAL}};
    std::vector<Setting> settings;
    for (const Effect effect : kEffects) {
        const Setting base = preset_setting(effect, DGB_PRESET_BALANCED);
        add_unless_there(&settings, base);
        for (const Choice& choice : telling) { add_unless_there(&settings, vary(base, {choice})); }
        for (const Baseline baseline : {Baseline::sao, Baseline::gtao}) {
            add_unless_there(&settings, vary(base, {{"layers", 1}, {"baseline", double(baseline)}}));
        }
    }
    for (const Condition condition : {Condition{4, false}, Condition{4, true}}) {
        const Setting base = preset_setting(Effect::occlusion, DGB_PRESET_BALANCED, condition);
        for (const std::vector<Choice>& choices : {std::vector<Choice>{}, {{"weight", 0.0}}, {{"layers", 1}}}) {
            add_unless_there(&settings, vary(base, choices));
        }
    }
    add_oracles(&settings, Effect::light);
    return settings;
}

std::vector<Setting> budget_settings() {
    std::vector<Setting> settings;
    const auto add = [&](Setting setting) {
        setting.around = "budget";
        setting.varied = "all";
        add_unless_there(&settings, std::move(setting));
    };
    for (const Effect effect : {Effect::occlusion, Effect::light}) {
        const Setting base = preset_setting(effect, DGB_PRESET_BALANCED);
        add_unless_there(&settings, base);
        for (const double taps : {4, 8, 14, 30, 64}) {
            for (const double filter_taps : {1, 5, 11}) {
                for (const double min_level : {0, 2}) {
                    Setting setting =
                        vary(base, {{"taps", taps}, {"filter_taps", filter_taps}, {"min_level", min_level}});
                    add(setting);
                    setting.params.normal_test = false;
                    add(setting);
                }
            }
        }
    }
    const Setting mirror = preset_setting(Effect::mirror, DGB_PRESET_BALANCED);
    add_unless_there(&settings, mirror);
    for (const double stride : {1, 2, 3, 4, 6, 8, 12, 16}) { add(vary(mirror, {{"stride", stride}})); }
    return settings;
}

std::vector<Setting> thickness_settings() {
    std::vector<Setting> settings;
    for (const Effect effect : kEffects) {
        const Setting balanced = preset_setting(effect, DGB_PRESET_BALANCED);
        add_unless_there(&settings, balanced);
        Setting base =
            vary(balanced, {{"estimator", DGB_ESTIMATOR_BITMASK}, {"taps", 60}, {"slices", 4}, {"stride", 1}});
        base.around = "thickness";
        base.varied.clear();
        for (int from = 0; from < DGB_THICKNESS_COUNT; ++from) {
            for (const double most : {0.1, 0.25, 0.5, 1.0, 2.0, 4.0}) {
                add_unless_there(&settings, vary(base, {{"thickness_from", double(from)}, {"thickness", most}}));
            }
        }
    }
    return settings;
}

// Who takes part. What does not concern light leaves it as it is, so that it is there once.
struct Entrant {
    const char* name;
    std::vector<Choice> choices;
};
const Entrant kEntrants[] = {{"paper 2 layers", {}},
                             {"paper 1 layer", {{"layers", 1}}},
                             {"bitmask 2 layers", {{"estimator", DGB_ESTIMATOR_BITMASK}}},
                             {"bitmask 1 layer", {{"layers", 1}, {"estimator", DGB_ESTIMATOR_BITMASK}}},
                             {"sao", {{"layers", 1}, {"baseline", double(Baseline::sao)}}},
                             {"gtao", {{"layers", 1}, {"baseline", double(Baseline::gtao)}}}};

// The preset's taps first: the others tell what a contest of equal cost comes to.
void add_entrant(std::vector<Setting>* settings, const Entrant& entrant, const Setting& preset) {
    Setting base = vary(preset, entrant.choices);
    base.around = entrant.name;
    base.varied.clear();
    add_unless_there(settings, base);
    for (const double taps : {8.0, 16.0, 30.0}) {
        add_unless_there(settings, vary(base, {{"taps", taps}, {"filter_taps", 5.0}}));
    }
}

std::vector<Setting> estimator_settings(bool quick) {
    std::vector<Setting> settings;
    for (const Effect effect : {Effect::occlusion, Effect::light}) {
        for (const bool moving : {true, false}) {
            for (const int frames : {1, 4, 16, 64}) {
                if (frames == 1 ? !moving : quick) { continue; } // one frame is the same for both cameras
                Setting preset = preset_setting(effect, DGB_PRESET_BALANCED, {frames, moving});
                preset.params.history_weight = 0.95f; // what many frames are for
                for (const Entrant& entrant : kEntrants) { add_entrant(&settings, entrant, preset); }
            }
        }
    }
    return settings;
}

dgb_params scaled(dgb_params params, float size) {
    const float share = std::min(size / kRoom, 1.0f);
    for (float* length :
         {&params.separation, &params.ao_radius, &params.radius, &params.reflect_thickness, &params.thickness}) {
        *length *= share;
    }
    return params;
}

double texels_of(const Setting& s) {
    const dgb_params& q = s.params;
    if (s.effect == Effect::mirror) { // at most: a step is one texel, of both layers
        return double(q.reflect_steps) / double(q.reflect_stride);
    }
    const bool light = s.effect == Effect::light;
    const int maps = light ? 1 + int(q.normal_test) + s.desc.layers : 1;      // z, normals, radiance of each layer
    const int filtered = q.filter_taps > 1 ? 2 * (q.filter_taps - 1) * 3 : 0; // z, normals, the picture
    return double(maps * (light ? q.samples : q.ao_samples) + filtered);
}
