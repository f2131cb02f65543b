#include "setting.hpp"

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <random>

namespace {

constexpr float kRoom = 15.0f; // metres: the size of a scene from which on lengths are taken as they are
constexpr const char* kPresets[] = {"performance", "balanced", "quality"};

template <typename... Values>
std::string text(const char* format, Values... values) {
    char buffer[256];
    std::snprintf(buffer, sizeof buffer, format, values...);
    return buffer;
}

int* taps_of(Setting* s) { return s->effect == Effect::occlusion ? &s->params.ao_samples : &s->params.samples; }

// One value of one parameter.
struct Change {
    const char* name;
    double value;
    void (*apply)(Setting* setting, double value);
    bool (*concerns)(Effect effect);
};

bool all(Effect) { return true; }
bool gathers(Effect effect) { return effect != Effect::mirror; }
bool is_light(Effect effect) { return effect == Effect::light; }
bool is_mirror(Effect effect) { return effect == Effect::mirror; }

template <void (*apply)(Setting*, double), bool (*concerns)(Effect)>
void add(std::vector<Change>* changes, const char* name, std::initializer_list<double> values) {
    for (const double value : values) { changes->push_back({name, value, apply, concerns}); }
}

void set_layers(Setting* s, double v) { s->layers = int(v); }
void set_divisor(Setting* s, double v) { s->divisor = int(v); }
void set_oracle(Setting* s, double v) { s->oracle = dgb_oracle(int(v)); }
void set_separation(Setting* s, double v) { s->params.separation = float(v); }
void set_taps(Setting* s, double v) { *taps_of(s) = int(v); }
void set_radius(Setting* s, double v) {
    float* radius = s->effect == Effect::occlusion ? &s->params.ao_radius : &s->params.radius;
    *radius *= float(v);
}
void set_min_level(Setting* s, double v) {
    (s->effect == Effect::occlusion ? s->params.ao_min_level : s->params.min_level) = int(v);
}
void set_filter_taps(Setting* s, double v) { s->params.filter_taps = int(v); }
void set_filter_step(Setting* s, double v) { s->params.filter_step = int(v); }
void set_normal_test(Setting* s, double v) { s->params.normal_test = v > 0.0; }
void set_senders(Setting* s, double v) { s->senders = dgb_senders(int(v)); }
void set_normaliser(Setting* s, double v) { s->normaliser = dgb_normaliser(int(v)); }
void set_coverage(Setting* s, double v) { s->coverage = float(v); }
void set_estimator(Setting* s, double v) {
    s->estimator = dgb_estimator(int(v));
    if (s->estimator == DGB_ESTIMATOR_BITMASK) { s->coverage = 1.0f; } // its confidence is the share itself
}
void set_stride(Setting* s, double v) { s->params.reflect_stride = int(v); }
void set_thickness(Setting* s, double v) { s->params.reflect_thickness = float(v); }
void set_tracer(Setting* s, double v) { s->tracer = dgb_tracer(int(v)); }

// Everything there is to vary. radius: a factor.
std::vector<Change> all_changes() {
    std::vector<Change> changes;
    add<set_layers, all>(&changes, "layers", {1, 2});
    add<set_separation, all>(&changes, "separation", {0.0, 0.05, 0.1, 0.25, 0.5, 1.0, 2.0});
    add<set_oracle, all>(
        &changes, "oracle",
        {DGB_ORACLE_PEEL, DGB_ORACLE_PREVIOUS, DGB_ORACLE_REPROJECT, DGB_ORACLE_PREDICT, DGB_ORACLE_WARP});
    add<set_divisor, all>(&changes, "divisor", {1, 2, 4});
    add<set_taps, gathers>(&changes, "taps", {4, 8, 14, 20, 30, 60, 98});
    add<set_radius, gathers>(&changes, "radius", {0.5, 0.71, 1.41, 2.0});
    add<set_min_level, gathers>(&changes, "min_level", {0, 1, 2, 3, 4});
    add<set_filter_taps, gathers>(&changes, "filter_taps", {1, 5, 9, 13, 21});
    add<set_filter_step, gathers>(&changes, "filter_step", {1, 2, 3});
    add<set_normal_test, is_light>(&changes, "normal_test", {0, 1});
    add<set_senders, is_light>(&changes, "senders", {DGB_SENDERS_BOTH, DGB_SENDERS_STRONGEST});
    add<set_normaliser, is_light>(&changes, "normaliser", {DGB_NORMALISER_BOUNDED, DGB_NORMALISER_PAPER});
    add<set_estimator, gathers>(&changes, "estimator", {DGB_ESTIMATOR_PAPER, DGB_ESTIMATOR_BITMASK});
    add<set_coverage, is_light>(&changes, "coverage", {1, 1.5, 2, 3, 4});
    add<set_stride, is_mirror>(&changes, "stride", {1, 2, 4, 8, 16});
    add<set_thickness, is_mirror>(&changes, "thickness", {0.05, 0.1, 0.25, 0.5, 1.0, 2.0});
    add<set_tracer, is_mirror>(&changes, "tracer", {DGB_TRACER_LINEAR, DGB_TRACER_HIERARCHICAL});
    return changes;
}

void add_unless_there(std::vector<Setting>* settings, Setting setting) {
    const std::string key = key_of(setting);
    const bool there = std::any_of(settings->begin(), settings->end(),
                                   [&](const Setting& s) { return s.effect == setting.effect && key_of(s) == key; });
    if (!there) { settings->push_back(std::move(setting)); }
}

std::string value_text(const Change& change) {
    const std::string name = change.name;
    const auto i = int(change.value);
    if (name == "oracle") { return dgb_oracle_name(dgb_oracle(i)); }
    if (name == "senders") { return i == DGB_SENDERS_BOTH ? "both" : "strongest"; }
    if (name == "normaliser") { return i == DGB_NORMALISER_BOUNDED ? "bounded" : "paper"; }
    if (name == "estimator") { return i == DGB_ESTIMATOR_PAPER ? "paper" : "bitmask"; }
    if (name == "tracer") { return i == DGB_TRACER_LINEAR ? "linear" : "hierarchical"; }
    return text("%g", change.value);
}

Setting changed(Setting setting, const Change& change) {
    change.apply(&setting, change.value);
    setting.varied = change.name + ("=" + value_text(change));
    return setting;
}

// One value of every parameter that concerns the effect.
Setting random_setting(Effect effect, const std::vector<Change>& changes, std::mt19937* random) {
    Setting setting = preset_setting(effect, DGB_PRESET_BALANCED);
    setting.around = "random";
    for (size_t first = 0, last = 0; first < changes.size(); first = last) {
        while (last < changes.size() && changes[last].name == changes[first].name) { ++last; }
        const size_t pick = first + (*random)() % (last - first);
        if (changes[first].concerns(effect)) { changes[pick].apply(&setting, changes[pick].value); }
    }
    setting.varied = "all";
    return setting;
}

} // namespace

const char* name_of(Effect effect) {
    return effect == Effect::occlusion ? "ao" : effect == Effect::light ? "irradiance" : "reflection";
}

uint32_t bits_of(Effect effect) {
    return effect == Effect::occlusion ? DGB_EFFECT_AO
           : effect == Effect::light   ? DGB_EFFECT_RADIOSITY
                                       : DGB_EFFECT_REFLECT;
}

std::string key_of(const Setting& s) {
    const dgb_params& q = s.params;
    const bool second = s.layers > 1; // what only the second layer depends on
    const std::string layers = text("k%d d%g o%d v%d", s.layers, second ? double(q.separation) : 0.0,
                                    second ? int(s.oracle) : 0, second ? s.divisor : 1);
    const std::string ends =
        text(" w%g e%d", double(s.effect == Effect::mirror ? q.reflect_thickness : q.thickness), int(s.thickness));
    const std::string filter =
        text(" f%d s%d", q.filter_taps, q.filter_taps > 1 ? q.filter_step : 1) +
        (s.estimator == DGB_ESTIMATOR_BITMASK ? " bitmask l" + std::to_string(q.slices) + ends : "");
    if (s.effect == Effect::occlusion) {
        return layers + text(" n%d r%g m%d", q.ao_samples, double(q.ao_radius), q.ao_min_level) + filter;
    }
    if (s.effect == Effect::light) {
        return layers +
               text(" n%d r%g m%d t%d e%d z%d c%g", q.samples, double(q.radius), q.min_level, int(q.normal_test),
                    second ? int(s.senders) : 0, int(s.normaliser), double(s.coverage)) +
               filter;
    }
    return layers + text(" p%d c%d", q.reflect_stride, int(s.tracer)) + ends;
}

Setting preset_setting(Effect effect, dgb_preset_id preset) {
    Setting setting;
    setting.effect = effect;
    setting.around = kPresets[preset];
    setting.params = dgb_preset(preset);
    setting.params.guard_fraction = 0.0f;
    setting.params.reflect_steps = 1024; // as many as the image is long: no ray ends for want of them
    setting.params.reflect_border = 0.0f;
    return setting;
}

std::vector<Setting> all_settings(int random_count, uint32_t seed) {
    std::vector<Setting> settings;
    const std::vector<Change> changes = all_changes();
    for (const Effect effect : kEffects) {
        // BALANCED first: what others share with it is called by its name
        for (const dgb_preset_id preset : {DGB_PRESET_BALANCED, DGB_PRESET_PERFORMANCE, DGB_PRESET_QUALITY}) {
            add_unless_there(&settings, preset_setting(effect, preset));
        }
        for (const dgb_preset_id preset : {DGB_PRESET_BALANCED, DGB_PRESET_QUALITY, DGB_PRESET_PERFORMANCE}) {
            for (const Change& change : changes) {
                if (!change.concerns(effect)) { continue; }
                add_unless_there(&settings, changed(preset_setting(effect, preset), change));
            }
        }
    }
    // BALANCED with one layer, so that what the second is worth is told from the best of either
    for (const Effect effect : kEffects) {
        for (const Change& change : changes) {
            Setting setting = changed(preset_setting(effect, DGB_PRESET_BALANCED), change);
            set_layers(&setting, 1);
            setting.around = "one layer";
            if (change.concerns(effect)) { add_unless_there(&settings, std::move(setting)); }
        }
    }
    std::mt19937 random(seed);
    for (int i = 0; i < random_count; ++i) {
        const Effect effect = kEffects[size_t(i) % std::size(kEffects)];
        add_unless_there(&settings, random_setting(effect, changes, &random));
    }
    return settings;
}

std::vector<Setting> few_settings() {
    std::vector<Setting> settings;
    for (const Effect effect : kEffects) {
        const Setting base = preset_setting(effect, DGB_PRESET_BALANCED);
        add_unless_there(&settings, base);
        for (const Change& change : all_changes()) {
            const std::string name = change.name;
            const bool telling =
                name == "layers" || (name == "taps" && (change.value == 4 || change.value == 60)) ||
                (name == "separation" && change.value == 0.0) || (name == "filter_taps" && change.value == 1) ||
                (name == "divisor" && change.value == 2) || (name == "oracle" && change.value == DGB_ORACLE_PEEL) ||
                name == "normal_test" || name == "senders" ||
                (name == "stride" && (change.value == 1 || change.value == 8)) || name == "tracer";
            if (telling && change.concerns(effect)) { add_unless_there(&settings, changed(base, change)); }
        }
    }
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
        add_unless_there(&settings, preset_setting(effect, DGB_PRESET_BALANCED));
        for (const int taps : {4, 8, 14, 30, 64}) {
            for (const int filter_taps : {1, 5, 11}) {
                for (const int min_level : {0, 2}) {
                    for (const bool normal_test : {true, false}) {
                        Setting setting = preset_setting(effect, DGB_PRESET_BALANCED);
                        set_taps(&setting, taps);
                        set_min_level(&setting, min_level);
                        setting.params.filter_taps = filter_taps;
                        setting.params.normal_test = normal_test;
                        add(setting);
                    }
                }
            }
        }
    }
    add_unless_there(&settings, preset_setting(Effect::mirror, DGB_PRESET_BALANCED));
    for (const int stride : {1, 2, 3, 4, 6, 8, 12, 16}) {
        Setting setting = preset_setting(Effect::mirror, DGB_PRESET_BALANCED);
        setting.params.reflect_stride = stride;
        add(setting);
    }
    return settings;
}

std::vector<Setting> thickness_settings() {
    constexpr const char* kNames[] = {"layers", "constant", "back faces"};
    std::vector<Setting> settings;
    for (const Effect effect : kEffects) {
        add_unless_there(&settings, preset_setting(effect, DGB_PRESET_BALANCED));
        for (int choice = 0; choice < DGB_THICKNESS_COUNT; ++choice) {
            for (const double most : {0.1, 0.25, 0.5, 1.0, 2.0, 4.0}) {
                Setting setting = preset_setting(effect, DGB_PRESET_BALANCED);
                setting.around = "thickness";
                setting.varied = text("%s at most %g", kNames[choice], most);
                setting.thickness = dgb_thickness(choice);
                setting.params.thickness = setting.params.reflect_thickness = float(most);
                setting.params.slices = 4;
                setting.params.reflect_stride = 1;
                set_taps(&setting, 64);
                set_estimator(&setting, DGB_ESTIMATOR_BITMASK);
                add_unless_there(&settings, std::move(setting));
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
    const int maps = light ? 1 + int(q.normal_test) + s.layers : 1;           // z, normals, radiance of each layer
    const int filtered = q.filter_taps > 1 ? 2 * (q.filter_taps - 1) * 3 : 0; // z, normals, the picture
    return double(maps * (light ? q.samples : q.ao_samples) + filtered);
}
