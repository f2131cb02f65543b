// The library's estimators (deepgbuffer.h: Equations 1 to 5 of the paper) on the CPU, for what the GPU path does not offer: more
// than two layers, other tap patterns, rays that check whether a tap is visible. Full resolution, no MIP levels, no filter.
#pragma once

#include "deepgbuffer.h"
#include "reference.hpp"

#include <vector>

enum class Pattern {
    spiral,     // the library's, of `turns`
    hammersley, // radius by rank, angle by the radical inverse of base 2
    r2,         // both by the R2 sequence (Roberts 2018)
    random      // both by an independent random number: the baseline of all
};

struct EstimateOptions {
    dgb_params params = dgb_preset(DGB_PRESET_QUALITY);
    dgb_senders senders = DGB_SENDERS_BOTH; // STRONGEST: of a tap's layers, the brightest
    dgb_normaliser normaliser = DGB_NORMALISER_BOUNDED;
    Pattern pattern = Pattern::spiral;
    int turns = 0;     // of the spiral; 0: the library's table
    bool rays = false; // a tap counts only where a ray to it meets nothing
    int frame = 0;     // turns every pixel's pattern, as frames that are averaged do
    int stride = 1;    // shade every so many pixels only, in x and in y; the others are left 0
};

struct Shading {
    std::vector<float> visibility; // one a pixel
    std::vector<float> irradiance; // RGB and confidence a pixel, W/m2
};

// Layers as trace_layers gives them, and what each sends (radiance, one vec3 a pixel and layer).
Shading estimate(const ReferenceScene& scene, const ReferenceView& view,
                 const std::vector<std::vector<Surface>>& layers, const std::vector<std::vector<glm::vec3>>& radiance,
                 const EstimateOptions& options);

// What every surface of the layers sends: ReferenceScene::outgoing.
std::vector<std::vector<glm::vec3>> radiance_of(const ReferenceScene& scene,
                                                const std::vector<std::vector<Surface>>& layers);
