#include "metrics.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace {

constexpr size_t kWindow = 11;    // pixels
constexpr double kSigma = 1.5;    // pixels
constexpr double kTrimmed = 1e-3; // of the pixels: fireflies say nothing of the rest

bool counts(const std::vector<bool>& mask, size_t pixel) { return mask.empty() || mask[pixel]; }

double mean(const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / double(std::max<size_t>(values.size(), 1));
}

double percentile(std::vector<double> values, double share) {
    if (values.empty()) { return 0.0; }
    const auto at = values.begin() + std::ptrdiff_t(share * double(values.size() - 1));
    std::nth_element(values.begin(), at, values.end());
    return *at;
}

// Of what is left without the largest.
double trimmed_mean(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    values.resize(values.size() - size_t(kTrimmed * double(values.size())));
    return mean(values);
}

using Kernel = std::array<double, kWindow * kWindow>;

Kernel make_kernel() {
    Kernel kernel{};
    double sum = 0.0;
    for (size_t i = 0; i < kernel.size(); ++i) {
        const auto column = int(i % kWindow), row = int(i / kWindow), middle = int(kWindow / 2);
        const double x = column - middle, y = row - middle;
        kernel[i] = std::exp(-(x * x + y * y) / (2.0 * kSigma * kSigma));
        sum += kernel[i];
    }
    for (double& weight : kernel) { weight /= sum; }
    return kernel;
}

struct Moments {
    double a = 0.0, b = 0.0, aa = 0.0, bb = 0.0, ab = 0.0;
};

double similarity_of(const Moments& m, double range) {
    const double c1 = 0.01 * range * 0.01 * range, c2 = 0.03 * range * 0.03 * range;
    const double variance_a = m.aa - m.a * m.a, variance_b = m.bb - m.b * m.b, covariance = m.ab - m.a * m.b;
    return (2.0 * m.a * m.b + c1) * (2.0 * covariance + c2) /
           ((m.a * m.a + m.b * m.b + c1) * (variance_a + variance_b + c2));
}

} // namespace

Metrics measure_error(const std::vector<float>& value, const std::vector<float>& truth, size_t channels,
                      const std::vector<bool>& mask) {
    double squares = 0.0, signed_sum = 0.0, true_sum = 0.0, true_squares = 0.0, products = 0.0, value_squares = 0.0;
    std::vector<double> absolute, squared, true_square;
    for (size_t pixel = 0; pixel < truth.size() / channels; ++pixel) {
        if (!counts(mask, pixel)) { continue; }
        double a = 0.0, s = 0.0, t2 = 0.0;
        for (size_t i = pixel * channels; i < (pixel + 1) * channels; ++i) {
            const auto v = double(value[i]), t = double(truth[i]);
            a += std::abs(v - t);
            s += (v - t) * (v - t);
            t2 += t * t;
            signed_sum += v - t;
            true_sum += t;
            products += v * t;
            value_squares += v * v;
        }
        squares += s;
        true_squares += t2;
        absolute.push_back(a / double(channels));
        squared.push_back(s);
        true_square.push_back(t2);
    }
    Metrics m;
    m.pixels = int64_t(absolute.size());
    if (absolute.empty()) { return m; }
    const double values = double(absolute.size() * channels), floor = 0.01 * true_squares / double(absolute.size());
    for (size_t i = 0; i < squared.size(); ++i) {
        squared[i] = squared[i] > 0.0 ? squared[i] / (true_square[i] + floor) : 0.0;
    }
    m.rmse = std::sqrt(squares / values);
    m.mae = mean(absolute);
    m.bias = signed_sum / values;
    m.mean = true_sum / values;
    m.p95 = percentile(std::move(absolute), 0.95);
    m.relative = trimmed_mean(std::move(squared));
    m.gain = value_squares > 0.0 ? products / value_squares : 1.0;
    return m;
}

double best_power(const std::vector<float>& value, const std::vector<float>& truth, const std::vector<bool>& mask) {
    const auto error = [&](double exponent) {
        double sum = 0.0;
        for (size_t i = 0; i < value.size(); ++i) {
            if (!counts(mask, i)) { continue; }
            const double e = std::pow(double(value[i]), exponent) - double(truth[i]);
            sum += e * e;
        }
        return sum;
    };
    double low = std::log(0.25), high = std::log(4.0);
    for (int i = 0; i < 40; ++i) { // a third of the range less each time: to 1e-6
        const double a = low + (high - low) / 3.0, b = high - (high - low) / 3.0;
        error(std::exp(a)) < error(std::exp(b)) ? high = b : low = a;
    }
    return std::exp(0.5 * (low + high));
}

double unbiased_squared_error(const std::vector<float>& value, const std::vector<float>& truth_1,
                              const std::vector<float>& truth_2, size_t channels, const std::vector<bool>& mask) {
    double sum = 0.0;
    int64_t count = 0;
    for (size_t i = 0; i < value.size(); ++i) {
        if (!counts(mask, i / channels)) { continue; }
        sum += (double(value[i]) - double(truth_1[i])) * (double(value[i]) - double(truth_2[i]));
        ++count;
    }
    return sum / double(std::max<int64_t>(count, 1));
}

double structural_similarity(const std::vector<float>& value, const std::vector<float>& truth, size_t width,
                             size_t height, double range, const std::vector<bool>& mask) {
    static const Kernel kernel = make_kernel();
    double sum = 0.0;
    int64_t windows = 0;
    for (size_t y = 0; y + kWindow <= height; ++y) {
        for (size_t x = 0; x + kWindow <= width; ++x) {
            Moments m;
            bool whole = true;
            for (size_t i = 0; i < kernel.size(); ++i) {
                const size_t pixel = (y + i / kWindow) * width + x + i % kWindow;
                const double w = kernel[i];
                const auto a = double(value[pixel]), b = double(truth[pixel]);
                whole = whole && counts(mask, pixel);
                m.a += w * a;
                m.b += w * b;
                m.aa += w * a * a;
                m.bb += w * b * b;
                m.ab += w * a * b;
            }
            if (!whole) { continue; }
            sum += similarity_of(m, range);
            ++windows;
        }
    }
    return windows > 0 ? sum / double(windows) : 1.0;
}

std::vector<bool> near_silhouettes(const std::vector<float>& z, size_t width, size_t height, int radius, double step) {
    std::vector<bool> near(z.size(), false);
    const auto w = int(width), h = int(height);
    const auto is_edge = [&](size_t a, size_t b) {
        const double x = -double(z[a]), y = -double(z[b]), nearer = std::min(x, y);
        return std::abs(x - y) > step * std::max(nearer, 1e-9); // next to nothing, always
    };
    for (int y = 0; y < h; ++y) {
        for (int x = 0; x < w; ++x) {
            const size_t here = size_t(y) * width + size_t(x);
            const bool edge = (x + 1 < w && is_edge(here, here + 1)) || (y + 1 < h && is_edge(here, here + width));
            if (!edge) { continue; }
            for (int v = std::max(y - radius, 0); v <= std::min(y + radius, h - 1); ++v) {
                for (int u = std::max(x - radius, 0); u <= std::min(x + radius, w - 1); ++u) {
                    near[size_t(v) * width + size_t(u)] = true;
                }
            }
        }
    }
    return near;
}

std::vector<bool> near_border(size_t width, size_t height, size_t width_of_border) {
    std::vector<bool> near(width * height, false);
    for (size_t i = 0; i < near.size(); ++i) {
        const size_t x = i % width, y = i / width;
        near[i] = std::min({x, y, width - 1 - x, height - 1 - y}) < width_of_border;
    }
    return near;
}
