// The measures of error against closed forms.
#include "metrics.hpp"

#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstdio>
#include <random>

extern "C" {
#include <cmocka.h>
}

namespace {

using Pixels = std::vector<float>;

constexpr double kRounding = 1e-6; // of floats that are added up in double precision

void assert_near(double value, double expected, double bound) {
    if (!(std::abs(value - expected) <= bound)) {
        std::printf("# %.9g, expected %.9g\n", value, expected);
        fail();
    }
}

// Errors of +1 and -3 on truths of 2 and 4, two channels a pixel; a third pixel is not of the mask.
void test_errors_by_hand(void**) {
    const Pixels truth = {2.0f, 4.0f, 2.0f, 4.0f, 100.0f, 100.0f};
    const Pixels value = {3.0f, 1.0f, 2.0f, 4.0f, 0.0f, 0.0f};
    const Metrics m = measure_error(value, truth, 2, {true, true, false});
    assert_int_equal(m.pixels, 2);
    assert_near(m.rmse, std::sqrt(10.0 / 4.0), kRounding);
    assert_near(m.mae, 1.0, kRounding);
    assert_near(m.bias, -0.5, kRounding);
    assert_near(m.mean, 3.0, kRounding);
    assert_near(m.relative, 0.5 * 10.0 / (20.0 + 0.01 * 20.0), kRounding);
    assert_near(m.gain, (6.0 + 4.0 + 4.0 + 16.0) / (9.0 + 1.0 + 4.0 + 16.0), kRounding);
}

void test_percentile(void**) {
    Pixels value(1001);
    for (size_t i = 0; i < value.size(); ++i) { value[i] = float((i * 37) % 1001); }
    const Metrics m = measure_error(value, Pixels(value.size(), 0.0f), 1);
    assert_near(m.p95, 950.0, kRounding);
    assert_near(m.bias, 500.0, kRounding);
}

// One pixel of a thousand is left out of the relative error, the worst; one of 999 is not.
void test_fireflies(void**) {
    Pixels truth(1000, 1.0f), value(1000, 1.1f);
    value[500] = 1000.0f;
    assert_near(measure_error(value, truth, 1).relative, 0.01 / 1.01, kRounding);
    truth.pop_back();
    value.pop_back();
    assert_true(measure_error(value, truth, 1).relative > 900.0);
}

void test_gain(void**) {
    Pixels truth, value;
    for (int i = 1; i < 100; ++i) {
        truth.push_back(float(i));
        value.push_back(float(i) * 0.8f);
    }
    assert_near(measure_error(value, truth, 1).gain, 1.25, 1e-5);
}

void test_power(void**) {
    Pixels truth, value;
    for (int i = 0; i <= 100; ++i) {
        truth.push_back(float(i) / 100.0f);
        value.push_back(std::pow(float(i) / 100.0f, 1.25f));
    }
    assert_near(best_power(value, truth), 0.8, 1e-5);
    assert_near(best_power(truth, truth), 1.0, 1e-5);
    truth.push_back(1.0f);
    value.push_back(0.0f);
    std::vector<bool> mask(truth.size(), true);
    mask.back() = false; // which nothing mends
    assert_near(best_power(value, truth, mask), 0.8, 1e-5);
}

void test_nothing_to_measure(void**) {
    const Metrics m = measure_error({1.0f}, {2.0f}, 1, {false});
    assert_int_equal(m.pixels, 0);
    assert_near(m.rmse, 0.0, 0.0);
}

// Of a truth known with noise only, the plain squared error holds the noise as well, this one does not.
void test_unbiased_error(void**) {
    std::mt19937 random(1);
    std::normal_distribution<float> noise(0.0f, 0.5f);
    const size_t count = 200000;
    Pixels value(count, 1.2f), first(count), second(count);
    for (size_t i = 0; i < count; ++i) {
        first[i] = 1.0f + noise(random);
        second[i] = 1.0f + noise(random);
    }
    // the product's standard deviation is about 0.29, of the mean of so many 6.5e-4
    assert_near(unbiased_squared_error(value, first, second, 1), 0.04, 4.0 * 6.5e-4);
    assert_true(std::pow(measure_error(value, first, 1).rmse, 2.0) > 0.25);
}

// Two channels a pixel, of which the second pixel is not of the mask.
void test_unbiased_error_by_hand(void**) {
    const Pixels value = {3.0f, 1.0f, 9.0f, 9.0f}, first = {2.0f, 2.0f, 0.0f, 0.0f}, second = {1.0f, 4.0f, 0.0f, 0.0f};
    assert_near(unbiased_squared_error(value, first, second, 2, {true, false}), 0.5 * (1.0 * 2.0 + 1.0 * 3.0),
                kRounding);
}

Pixels waves(size_t width, size_t height, float mean, float amplitude) {
    Pixels pixels(width * height);
    for (size_t i = 0; i < pixels.size(); ++i) {
        const size_t x = i % width, y = i / width;
        pixels[i] = mean + amplitude * std::sin(1.3f * float(x)) * std::sin(0.9f * float(y));
    }
    return pixels;
}

void test_similarity_of_the_same(void**) {
    const Pixels picture = waves(32, 24, 0.5f, 0.3f);
    assert_near(structural_similarity(picture, picture, 32, 24, 1.0), 1.0, 1e-12);
}

// Constant pictures have neither variance nor covariance: what is left is the term of the means.
void test_similarity_of_constants(void**) {
    const Pixels a(16 * 16, 0.5f), b(16 * 16, 0.8f);
    const double c1 = 1e-4;
    assert_near(structural_similarity(a, b, 16, 16, 1.0), (2.0 * 0.4 + c1) / (0.25 + 0.64 + c1), kRounding);
}

// Turned upside down around the mean, every covariance changes its sign.
void test_similarity_of_opposites(void**) {
    const Pixels a = waves(32, 32, 0.5f, 0.4f), b = waves(32, 32, 0.5f, -0.4f);
    const double value = structural_similarity(a, b, 32, 32, 1.0);
    assert_true(value < -0.8 && value >= -1.0);
}

// Of one window, as large as the picture, in which one pixel differs, by hand: 11 x 11, a Gaussian of 1.5 pixels.
void test_similarity_of_one_window(void**) {
    const double a = 0.5, step = 0.4, c1 = 1e-4, c2 = 9e-4;
    for (const int at : {0, 60, 63}) { // a corner, the middle, beside it
        Pixels first(121, float(a)), second(121, float(a));
        second[size_t(at)] += float(step);
        double sum = 0.0;
        const auto gaussian = [](int i) {
            const double x = i % 11 - 5, y = i / 11 - 5; // NOLINT
            return std::exp(-(x * x + y * y) / 4.5);
        };
        for (int i = 0; i < 121; ++i) { sum += gaussian(i); }
        const double w = gaussian(at) / sum, mean = a + w * step, variance = w * (1.0 - w) * step * step;
        const double expected = (2.0 * a * mean + c1) / (a * a + mean * mean + c1) * c2 / (variance + c2);
        assert_near(structural_similarity(first, second, 11, 11, 1.0), expected, kRounding);
    }
}

void test_similarity_needs_whole_windows(void**) {
    const Pixels a(16 * 16, 0.5f), b(16 * 16, 0.8f);
    assert_near(structural_similarity(a, b, 16, 16, 1.0, std::vector<bool>(16 * 16, false)), 1.0, 0.0);
    assert_near(structural_similarity({1.0f}, {0.0f}, 1, 1, 1.0), 1.0, 0.0);
}

void test_silhouettes(void**) {
    Pixels z(20 * 10, -5.0f);
    for (size_t i = 0; i < z.size(); ++i) { z[i] = i % 20 < 8 ? -5.0f : -9.0f; }
    const std::vector<bool> near = near_silhouettes(z, 20, 10, 2, 0.1);
    for (size_t i = 0; i < z.size(); ++i) { assert_int_equal(near[i], i % 20 >= 5 && i % 20 <= 9); }
}

// Both ways, and by a share of the nearer distance: a step of 1.05 m is an edge 10 m away, one of 0.95 m is none. Nothing is far
// from everything.
void test_silhouettes_are_relative(void**) {
    const auto edge = [](float above) {
        const Pixels z = {-10.0f, -10.0f, above, above};
        const std::vector<bool> near = near_silhouettes(z, 2, 2, 0, 0.1), turned = near_silhouettes(z, 1, 4, 0, 0.1);
        assert_int_equal(near[0], near[1]);
        assert_int_equal(near[0], turned[1]);
        assert_false(near[2] || near[3] || turned[0] || turned[2]);
        return bool(near[0]);
    };
    assert_true(edge(-11.05f));
    assert_false(edge(-10.95f));
    assert_true(edge(-9.05f));
    assert_true(edge(0.0f));
}

void test_border(void**) {
    const std::vector<bool> near = near_border(9, 7, 2);
    for (size_t i = 0; i < near.size(); ++i) {
        assert_int_equal(near[i], i % 9 < 2 || i % 9 > 6 || i / 9 < 2 || i / 9 > 4);
    }
}

} // namespace

int main() {
    const CMUnitTest tests[] = {cmocka_unit_test(test_errors_by_hand),
                                cmocka_unit_test(test_percentile),
                                cmocka_unit_test(test_fireflies),
                                cmocka_unit_test(test_gain),
                                cmocka_unit_test(test_power),
                                cmocka_unit_test(test_nothing_to_measure),
                                cmocka_unit_test(test_unbiased_error),
                                cmocka_unit_test(test_unbiased_error_by_hand),
                                cmocka_unit_test(test_similarity_of_the_same),
                                cmocka_unit_test(test_similarity_of_constants),
                                cmocka_unit_test(test_similarity_of_opposites),
                                cmocka_unit_test(test_similarity_of_one_window),
                                cmocka_unit_test(test_similarity_needs_whole_windows),
                                cmocka_unit_test(test_silhouettes),
                                cmocka_unit_test(test_silhouettes_are_relative),
                                cmocka_unit_test(test_border)};
    return cmocka_run_group_tests_name("metrics", tests, nullptr, nullptr);
}
