// How far a picture is from the truth. Pictures are lists of values, several channels a pixel, bottom row first; only pixels of
// the mask count (an empty one: all do).
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

struct Metrics {
    int64_t pixels = 0;
    double rmse = 0.0;     // root of the mean squared error, of all channels
    double mae = 0.0;      // mean absolute error
    double bias = 0.0;     // mean signed error: value minus truth
    double p95 = 0.0;      // 95th percentile of the absolute error, mean of the channels of a pixel
    double relative = 0.0; // mean of e^2 / (truth^2 + 1 % of the mean truth^2), without the largest 0.1 % of the pixels
    double mean = 0.0;     // of the truth
    double gain = 1.0;     // the factor on the picture that makes its RMSE least: 1 is a calibrated estimator
};

// value, truth: `channels` values a pixel. Both must have the same size, and the mask, if there is one, one entry a pixel.
Metrics measure_error(const std::vector<float>& value, const std::vector<float>& truth, size_t channels,
                      const std::vector<bool>& mask = {});

// The exponent on a picture of values 0 to 1, between 1/4 and 4, that makes its RMSE least: 1 is a calibrated estimator.
double best_power(const std::vector<float>& value, const std::vector<float>& truth, const std::vector<bool>& mask = {});

// An unbiased estimate of the mean squared error where the truth is known by two independent estimates with noise of their own:
// E[(t - r1)(t - r2)], in which the noise of neither is left. May come out below 0.
double unbiased_squared_error(const std::vector<float>& value, const std::vector<float>& truth_1,
                              const std::vector<float>& truth_2, size_t channels, const std::vector<bool>& mask = {});

// Structural similarity (Wang, Bovik, Sheikh, Simoncelli 2004) of one channel: the mean of the index over windows of 11 x 11
// pixels with a Gaussian of 1.5 pixels, K1 = 0.01, K2 = 0.03, for values of 0 to `range`. Windows are those that lie wholly
// within the picture and in which every pixel is of the mask. 1: the same; 1 as well where there is no such window.
double structural_similarity(const std::vector<float>& value, const std::vector<float>& truth, size_t width,
                             size_t height, double range, const std::vector<bool>& mask = {});

// Pixels within `radius` pixels of an edge of depth: where neighbours' z differ by more than `step` of their distance.
std::vector<bool> near_silhouettes(const std::vector<float>& z, size_t width, size_t height, int radius, double step);
// Pixels within `width_of_border` pixels of the picture's border.
std::vector<bool> near_border(size_t width, size_t height, size_t width_of_border);
