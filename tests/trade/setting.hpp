// What the trade of speed for accuracy varies: one effect with all that it depends on.
#pragma once

#include "deepgbuffer.h"

#include <string>
#include <vector>

enum class Effect { occlusion, light, mirror };
constexpr Effect kEffects[] = {Effect::occlusion, Effect::light, Effect::mirror};

const char* name_of(Effect effect);
uint32_t bits_of(Effect effect); // DGB_EFFECT_*

struct Setting {
    Effect effect = Effect::occlusion;
    std::string around; // the preset that it is a variation of, or "random"
    std::string varied; // what is not as in the preset: "layers=1"; "" for the preset itself
    int layers = 2, divisor = 1;
    dgb_oracle oracle = DGB_ORACLE_REPROJECT;
    dgb_senders senders = DGB_SENDERS_BOTH;
    dgb_normaliser normaliser = DGB_NORMALISER_BOUNDED;
    dgb_estimator estimator = DGB_ESTIMATOR_PAPER;
    dgb_tracer tracer = DGB_TRACER_LINEAR;
    dgb_thickness thickness = DGB_THICKNESS_LAYERS;
    float coverage = 2.0f; // share of the hemisphere, by confidence, that irradiance counts for in a composite
    dgb_params params{};   // lengths are shares of the scene's: see scaled()
};

// All numbers that define it, one word without commas: settings with the same key give the same picture.
std::string key_of(const Setting& setting);

// A preset's, with two layers.
Setting preset_setting(Effect effect, dgb_preset_id preset);

// The presets and, around each, one parameter at a time; then `random_count` drawn at random from all of them, of the seed.
std::vector<Setting> all_settings(int random_count, uint32_t seed);
// 24 of the most telling.
std::vector<Setting> few_settings();

// Every combination of what dgb_preset_for chooses: taps, MIP level, filter, normal test; step and tracer of mirrors.
std::vector<Setting> budget_settings();

// What ends a surface, for every length that would end it at the latest: of the bitmask, with taps and slices that leave little
// noise, and of mirrors with a step a pixel.
std::vector<Setting> thickness_settings();

// The separation and the radii of the presets suit rooms: scenes smaller than that get smaller ones. size: metres.
dgb_params scaled(dgb_params params, float size);

// Texels that the effect's passes fetch for a pixel of the image, where every pixel has a second layer: of the G-buffer and of
// pictures, one for each texture that is read. Without what the packing costs, which is the same for all.
double texels_of(const Setting& setting);
