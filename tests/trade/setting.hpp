// What the trade of speed for accuracy varies: one effect with all that it depends on.
#pragma once

#include "baselines.hpp"

#include "deepgbuffer.h"

#include <string>
#include <vector>

enum class Effect { occlusion, light, mirror };
constexpr Effect kEffects[] = {Effect::occlusion, Effect::light, Effect::mirror};

const char* name_of(Effect effect);

// How the frame that is looked at comes about. Settings are compared with those of the same condition.
struct Condition {
    int frames = 1;     // shaded, it included; more than one: with the temporal filter
    bool moving = true; // the camera, on its way to the view that is looked at

    bool operator==(Condition other) const { return frames == other.frames && moving == other.moving; }
};

struct Setting {
    Effect effect = Effect::occlusion;
    Condition condition;
    std::string around;                 // the preset that it is a variation of, or "random"
    std::string varied;                 // what is not as in the preset: "layers=1"; "" for the preset itself
    dgb_desc desc{};                    // what a context is made with, but for its size and effects
    Baseline baseline = Baseline::none; // in place of the library's occlusion
    float coverage = 2.0f; // share of the hemisphere, by confidence, that irradiance counts for in a composite
    dgb_params params{};   // lengths are shares of the scene's: see scaled()

    Setting() {
        desc.layers = 2;
        desc.divisor = 1;
        desc.oracle = DGB_ORACLE_REPROJECT;
    }
};

uint32_t effects_of(const Setting& setting); // DGB_EFFECT_*

// All numbers that define it but for the condition, one word without commas: settings with the same key and condition give the
// same picture.
std::string key_of(const Setting& setting);

// A preset's, with two layers.
Setting preset_setting(Effect effect, dgb_preset_id preset, Condition condition = {});

// The presets and, around each, one parameter at a time; some over several frames; then `random_count` drawn at random from all
// parameters, of the seed.
std::vector<Setting> all_settings(int random_count, uint32_t seed);
// A few of the most telling.
std::vector<Setting> few_settings();

// Every combination of what dgb_preset_for chooses: taps, MIP level, filter, normal test; step and tracer of mirrors.
std::vector<Setting> budget_settings();

// What ends a surface (dgb_thickness), for each length that ends it at the latest: of the bitmask, with taps and slices that leave
// little noise, and of mirrors with a step a pixel.
std::vector<Setting> thickness_settings();

// The estimators of occlusion and of light that there are, the library's and others', each at the taps and filters that it could
// be given, after one frame and, unless it is to be quick, after 4, 16 and 64: `around` names the estimator.
std::vector<Setting> estimator_settings(bool quick);

// The separation and the radii of the presets suit rooms: scenes smaller than that get smaller ones. size: metres.
dgb_params scaled(dgb_params params, float size);

// Texels that the effect's passes fetch for a pixel of the image, where every pixel has a second layer: of the G-buffer and of
// pictures, one for each texture that is read. Without what the packing costs, which is the same for all.
double texels_of(const Setting& setting);
