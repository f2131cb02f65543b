/* The lobe of a rough surface: width, sampled microfacets, density, and the numbers that they are sampled with. */

#include "deepgbuffer.h"
#include "numbers.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

static double random_unit(uint64_t* state) { return ((double)random_bits(state) + 0.5) / 4294967296.0; }

/* Anything a shader could be handed: the odd values, and random bits. */
static float odd_float(uint64_t* seed) {
    static const uint32_t odd[] = {0u,          0x80000000u, 1u,          0x80000001u, 0x7f800000u,
                                   0xff800000u, 0x7fc00000u, 0xffc00001u, 0x7f7fffffu, 0xff7fffffu,
                                   0x3f800000u, 0xbf800000u, 0x00800000u, 0x71000000u};
    const uint32_t pick = random_bits(seed) % 20u;
    return from_bits(pick < sizeof odd / sizeof odd[0] ? odd[pick] : random_bits(seed));
}

static double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void cross(const double a[3], const double b[3], double c[3]) {
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

static void normalise(double v[3]) {
    const double length = sqrt(dot(v, v));
    int i;
    for (i = 0; i < 3; ++i) v[i] /= length;
}

static void random_direction(uint64_t* seed, double v[3]) {
    const double z = 2.0 * random_unit(seed) - 1.0, turn = 2.0 * pi * random_unit(seed);
    v[0] = sqrt(1.0 - z * z) * cos(turn);
    v[1] = sqrt(1.0 - z * z) * sin(turn);
    v[2] = z;
}

static void to_float(const double v[3], float f[3]) {
    int i;
    for (i = 0; i < 3; ++i) f[i] = (float)v[i];
}

static void to_double(const float f[3], double v[3]) {
    int i;
    for (i = 0; i < 3; ++i) v[i] = (double)f[i];
}

/* >> width */

static void test_alpha(void** state) {
    int code;
    (void)state;
    assert_true(dgb_ggx_alpha(0.0f) == 0.0f && dgb_ggx_alpha(-0.5f) == 0.0f);
    assert_true(dgb_ggx_alpha(DGB_MIN_ROUGHNESS) == DGB_MIN_ROUGHNESS * DGB_MIN_ROUGHNESS);
    assert_true(dgb_ggx_alpha(from_bits(bits_of(DGB_MIN_ROUGHNESS) - 1u)) == 0.0f);
    assert_true(dgb_ggx_alpha(1.0f) == 1.0f && dgb_ggx_alpha(1.0001f) == 1.0f);
    assert_true(dgb_ggx_alpha(from_bits(0x7f800000u)) == 1.0f && dgb_ggx_alpha(from_bits(0xff800000u)) == 0.0f);
    assert_true(dgb_ggx_alpha(from_bits(0x7fc00000u)) == 0.0f && dgb_ggx_alpha(from_bits(0xffc00000u)) == 0.0f);
    for (code = 1; code <= 255; ++code) { /* no code but 0 is a mirror */
        const float r = (float)code / 255.0f;
        assert_true(dgb_ggx_alpha(r) == r * r && r * r > 0.0f);
    }
}

/* >> numbers to sample with */

static void test_pair_is_exact(void** state) {
    uint64_t seed = 1u;
    int i;
    (void)state;
    for (i = 0; i < 100000; ++i) {
        const int x = (int)(random_bits(&seed) & 0x7fffffffu), y = (int)(random_bits(&seed) & 0x7fffffffu);
        const int frame = (int)(random_bits(&seed) & 0xfffffu); /* so that a double holds 2^32 times as much */
        float first[2], pair[2];
        int k;
        dgb_pixel_pair(x, y, 0, first);
        dgb_pixel_pair(x, y, frame, pair);
        /* the step is 2^32 / p, 2^32 / p^2, where p^3 = p + 1; the lowest 9 bits are not kept */
        for (k = 0; k < 2; ++k) {
            const double step = k ? 0.56984029099805327 : 0.75487766624669276;
            const double steps = floor(step * 4294967296.0 + 0.5) / 4294967296.0 * (double)frame;
            const double expected = (double)first[k] + steps - floor(steps), off = (double)pair[k] - expected;
            assert_true(pair[k] > 0.0f && pair[k] < 1.0f);
            assert_true(pair[k] * 8388608.0f - floorf(pair[k] * 8388608.0f) == 0.5f); /* the middle of its step */
            assert_true(fabs(off - floor(off + 0.5)) <= 1.01 / 8388608.0);
        }
    }
}

/* Any other hash as good would pass the rest of these tests, but not be that of the shaders. Steps of 2^-23. */
static void test_pair_is_the_same_ever(void** state) {
    static const struct {
        int x, y, frame;
        float steps[2];
    } known[] = {{0, 0, 0, {0.5f, 0.5f}},
                 {1, 0, 0, {5797685.5f, 2006167.5f}},
                 {37, 1021, 5, {2706601.5f, 6122518.5f}},
                 {-3, 16383, -2, {8190532.5f, 8319944.5f}}};
    size_t i;
    (void)state;
    for (i = 0; i < sizeof known / sizeof known[0]; ++i) {
        float pair[2];
        dgb_pixel_pair(known[i].x, known[i].y, known[i].frame, pair);
        assert_true(pair[0] * 8388608.0f == known[i].steps[0] && pair[1] * 8388608.0f == known[i].steps[1]);
    }
}

/* Chi-square of counts that should all be the same, in standard deviations from its mean, nearly normal for so many
   bins. */
static double uniformity(const int* counts, int bins, int total) {
    const double expected = (double)total / bins;
    double chi2 = 0.0;
    int i;
    for (i = 0; i < bins; ++i) chi2 += ((double)counts[i] - expected) * ((double)counts[i] - expected) / expected;
    return (chi2 - (bins - 1)) / sqrt(2.0 * (bins - 1));
}

/* Pixels of one frame are as random points of the square; six sigma is one in a billion. */
static void test_pairs_of_pixels(void** state) {
    enum { BINS = 16, SIDE = 512 };
    static int counts[BINS * BINS], neighbours[BINS * BINS];
    float last[2] = {0.0f, 0.0f};
    int x, y;
    (void)state;
    for (y = 0; y < SIDE; ++y)
        for (x = 0; x < SIDE; ++x) {
            float u[2];
            dgb_pixel_pair(x, y, 0, u);
            ++counts[(int)(u[0] * BINS) + BINS * (int)(u[1] * BINS)];
            ++neighbours[(int)(u[0] * BINS) + BINS * (int)(last[0] * BINS)];
            memcpy(last, u, sizeof last);
        }
    printf("# %g, %g sigma\n", uniformity(counts, BINS * BINS, SIDE * SIDE),
           uniformity(neighbours, BINS * BINS, SIDE * SIDE));
    assert_true(fabs(uniformity(counts, BINS * BINS, SIDE * SIDE)) < 6.0);
    assert_true(fabs(uniformity(neighbours, BINS * BINS, SIDE * SIDE)) < 6.0);
}

/* Frames of one pixel share out the square: of 256, every 8 x 8 cell has 4 on average, and none has fewer than 1 or
   more than 8, which of random points 93 % of the cells alone would keep to. */
static void test_pairs_of_frames(void** state) {
    int pixel, frame, i;
    (void)state;
    for (pixel = 0; pixel < 100; ++pixel) {
        int counts[64] = {0};
        for (frame = 0; frame < 256; ++frame) {
            float u[2];
            dgb_pixel_pair(pixel, 7 * pixel, frame, u);
            ++counts[(int)(u[0] * 8.0f) + 8 * (int)(u[1] * 8.0f)];
        }
        for (i = 0; i < 64; ++i) assert_true(counts[i] >= 1 && counts[i] <= 8);
    }
}

/* >> the formulas, in double precision */

static double reference_density(const double v[3], const double n[3], const double l[3], double alpha) {
    const double a2 = alpha * alpha;
    double h[3], nv, nh, d, g1, s[3];
    int i;
    for (i = 0; i < 3; ++i) h[i] = v[i] + l[i];
    normalise(h);
    cross(n, h, s);
    nv = dot(n, v), nh = dot(n, h);
    if (nh <= 0.0) return 0.0;
    d = a2 / (pi * pow(nh * nh * a2 + dot(s, s), 2.0)); /* = a2 / (pi (nh^2 (a2 - 1) + 1)^2) */
    g1 = 2.0 * nv / (nv + sqrt(a2 + (1.0 - a2) * nv * nv));
    return d * g1 / (4.0 * nv);
}

static void test_density(void** state) {
    static const double alphas[] = {1.0, 0.5, 0.1, 0.01, 0.001};
    uint64_t seed = 3u;
    double worst = 0.0;
    int i, k;
    (void)state;
    for (i = 0; i < 100000; ++i) {
        const double alpha = (double)(float)alphas[i % 5];
        float fv[3], fn[3], fl[3];
        double v[3], n[3], l[3], h[3], expected, got, tilt = alpha * 3.0 * random_unit(&seed);
        random_direction(&seed, n);
        random_direction(&seed, v);
        random_direction(&seed, h);
        for (k = 0; k < 3; ++k) h[k] = n[k] + tilt * h[k]; /* where the lobe is */
        normalise(h);
        if (dot(n, v) < 0.01 || dot(v, h) < 0.01) continue;
        for (k = 0; k < 3; ++k) l[k] = 2.0 * dot(v, h) * h[k] - v[k];
        to_float(v, fv), to_float(n, fn), to_float(l, fl);
        to_double(fv, v), to_double(fn, n), to_double(fl, l);
        expected = reference_density(v, n, l, alpha);
        got = (double)dgb_ggx_density(fv, fn, fl, (float)alpha);
        if (expected == 0.0) { /* no microfacet is turned that far */
            assert_true(got == 0.0);
            continue;
        }
        /* h turns by about 2^-24 / v.h with the last bits of its parts: a share of alpha, which the fourth power of the
           density's tail quadruples */
        worst = fmax(worst, fabs(got / expected - 1.0) / (4e-7 / (alpha * dot(v, h)) + 2e-6));
    }
    printf("# at most %.2f of the bound\n", worst);
    assert_true(worst <= 1.0);
}

/* Over all microfacets h: density(l) dl, with dl = 4 v.h dh. tan = alpha sqrt(1 - s^2) / s covers the hemisphere with s
   in 0..1: D cos dh = 2 s ds dphi / 2 pi. */
static void test_density_integrates_to_one(void** state) {
    static const double alphas[] = {1.0, 0.36, 0.09, 0.01};
    static const double angles[] = {0.0, 30.0, 60.0, 80.0, 88.0};
    enum { STEPS = 400 };
    size_t a, b;
    (void)state;
    for (a = 0; a < 4; ++a)
        for (b = 0; b < 5; ++b) {
            const float n[3] = {0.0f, 0.0f, 1.0f}, alpha = (float)alphas[a];
            const double v[3] = {sin(angles[b] * pi / 180.0), 0.0, cos(angles[b] * pi / 180.0)};
            double sum = 0.0;
            int i, j, k;
            for (i = 0; i < STEPS; ++i)
                for (j = 0; j < STEPS; ++j) {
                    const double s = (i + 0.5) / STEPS, turn = 2.0 * pi * (j + 0.5) / STEPS;
                    const double tangent = alphas[a] * sqrt(1.0 - s * s) / s, z = 1.0 / sqrt(1.0 + tangent * tangent);
                    const double h[3] = {z * tangent * cos(turn), z * tangent * sin(turn), z};
                    const double d =
                        alphas[a] * alphas[a] / (pi * pow(z * z * alphas[a] * alphas[a] + 1.0 - z * z, 2.0));
                    double l[3];
                    float fv[3], fl[3];
                    if (dot(v, h) <= 0.0) continue;
                    for (k = 0; k < 3; ++k) l[k] = 2.0 * dot(v, h) * h[k] - v[k];
                    to_float(v, fv), to_float(l, fl);
                    sum += (double)dgb_ggx_density(fv, n, fl, alpha) * 4.0 * dot(v, h) * s / (z * d);
                }
            sum *= 2.0 / (STEPS * (double)STEPS);
            if (fabs(sum - 1.0) > 1e-3) fail_msg("alpha %g, %g deg: %g", alphas[a], angles[b], sum);
        }
}

static void test_density_is_total(void** state) {
    const float v[3] = {0.6f, 0.0f, 0.8f}, n[3] = {0.0f, 0.0f, 1.0f}, back[3] = {-0.6f, 0.0f, -0.8f};
    uint64_t seed = 5u;
    int i, k;
    (void)state;
    assert_true(dgb_ggx_density(v, n, back, 0.5f) == 0.0f);
    assert_true(dgb_ggx_density(v, n, n, 0.0f) == 0.0f && dgb_ggx_density(v, n, n, -1.0f) == 0.0f);
    assert_true(dgb_ggx_density(v, n, n, from_bits(0x7fc00000u)) == 0.0f);
    for (i = 0; i < 200000; ++i) {
        float in[10], density;
        for (k = 0; k < 10; ++k) in[k] = odd_float(&seed);
        density = dgb_ggx_density(in, in + 3, in + 6, in[9]);
        assert_true(is_finite(density) && density >= 0.0f);
    }
}

/* >> sampled microfacets */

enum { RADIAL = 12, AROUND = 24, BINS = RADIAL * AROUND, SAMPLES = 200000, FINE = 24 };

/* Share of the distribution of visible normals in each bin of (s, phi), with s and phi as above:
   D(h) G1 max(v.h, 0) / n.v dh = G1 / n.v max(v.h, 0) / cos * 2 s ds dphi / 2 pi. */
static void expected_shares(double alpha, double nv, double share[BINS]) {
    const double a2 = alpha * alpha, g1 = 2.0 * nv / (nv + sqrt(a2 + (1.0 - a2) * nv * nv)), side = sqrt(1.0 - nv * nv);
    int i, j;
    for (i = 0; i < BINS; ++i) share[i] = 0.0;
    for (i = 0; i < RADIAL * FINE; ++i)
        for (j = 0; j < AROUND * FINE; ++j) {
            const double s = (i + 0.5) / (RADIAL * FINE), turn = 2.0 * pi * (j + 0.5) / (AROUND * FINE);
            const double tangent = alpha * sqrt(1.0 - s * s) / s, seen = side * tangent * cos(turn) + nv;
            if (seen > 0.0)
                share[i / FINE * AROUND + j / FINE] +=
                    g1 / nv * seen * 2.0 * s / (RADIAL * FINE * (double)(AROUND * FINE));
        }
}

static int bin_of(const double h[3], const double n[3], const double x[3], const double y[3], double alpha) {
    const double p = dot(h, x), q = dot(h, y), z = dot(h, n),
                 s = alpha * z / sqrt(alpha * alpha * z * z + p * p + q * q);
    const double angle = atan2(q, p), turn = angle / (2.0 * pi) + (angle < 0.0 ? 1.0 : 0.0);
    const int radial = (int)(s * RADIAL), around = (int)(turn * AROUND);
    return (radial < RADIAL ? radial : RADIAL - 1) * AROUND + (around < AROUND ? around : AROUND - 1);
}

/* In standard deviations of a chi-square: bins of fewer than ten samples count together. */
static double distribution(double alpha, double angle, uint64_t* seed) {
    static int counts[BINS];
    double n[3], x[3], y[3], v[3], share[BINS], chi2 = 0.0, rest = 0.0, sum = 0.0;
    float fn[3], fv[3];
    int i, k, bins = 0, rest_count = 0;
    memset(counts, 0, sizeof counts);
    random_direction(seed, n);
    random_direction(seed, y);
    cross(n, y, x), normalise(x);
    cross(n, x, y);
    for (k = 0; k < 3; ++k) v[k] = cos(angle) * n[k] + sin(angle) * x[k];
    to_float(n, fn), to_float(v, fv);
    for (i = 0; i < SAMPLES; ++i) {
        const float u[2] = {(float)random_unit(seed), (float)random_unit(seed)};
        float fh[3];
        double h[3];
        dgb_ggx_normal(fv, fn, (float)alpha, u, fh);
        to_double(fh, h);
        ++counts[bin_of(h, n, x, y, alpha)];
    }
    expected_shares(alpha, cos(angle), share);
    for (i = 0; i < BINS; ++i) {
        const double expected = share[i] * SAMPLES;
        sum += share[i];
        if (expected < 10.0) {
            rest += expected, rest_count += counts[i];
            continue;
        }
        ++bins;
        chi2 += (counts[i] - expected) * (counts[i] - expected) / expected;
    }
    assert_true(fabs(sum - 1.0) < 2e-3); /* of the midpoint rule */
    if (rest > 10.0) chi2 += (rest_count - rest) * (rest_count - rest) / rest, ++bins;
    return (chi2 - (bins - 1)) / sqrt(2.0 * (bins - 1));
}

/* Five sigma of a right sampler is less than one in 10^5 of the 25 cases; the seed is fixed. */
static void test_distribution(void** state) {
    static const double alphas[] = {1.0, 0.36, 0.09, 0.01, 0.0001};
    static const double angles[] = {0.0, 35.0, 60.0, 78.0, 86.0};
    uint64_t seed = 11u;
    size_t a, b;
    (void)state;
    for (a = 0; a < 5; ++a)
        for (b = 0; b < 5; ++b) {
            const double sigmas = distribution((double)(float)alphas[a], angles[b] * pi / 180.0, &seed);
            if (!(sigmas < 5.0)) print_error("alpha %g, %g deg: %g sigma\n", alphas[a], angles[b], sigmas);
            assert_true(sigmas < 5.0);
        }
}

static void test_normals_face_the_viewer(void** state) {
    uint64_t seed = 13u;
    int i, k, behind = 0;
    (void)state;
    for (i = 0; i < 300000; ++i) {
        const float u[2] = {(float)random_unit(&seed), (float)random_unit(&seed)};
        const float alpha = dgb_ggx_alpha((float)random_unit(&seed));
        double v[3], n[3];
        float fv[3], fn[3], h[3], length = 0.0f, seen = 0.0f, up = 0.0f, facing = 0.0f;
        random_direction(&seed, v);
        if (i % 3 == 0) dgb_oct16_decode((uint16_t)random_bits(&seed), fn);
        random_direction(&seed, n);
        if (i % 3) to_float(n, fn);
        if (i % 7 == 0) /* grazing */
            for (k = 0; k < 3; ++k) v[k] -= (dot(v, n) - 1e-4) * n[k];
        normalise(v);
        to_float(v, fv);
        dgb_ggx_normal(fv, fn, alpha, u, h);
        for (k = 0; k < 3; ++k)
            length += h[k] * h[k], seen += fv[k] * h[k], up += fn[k] * h[k], facing += fv[k] * fn[k];
        assert_true(fabsf(length - 1.0f) < 2e-6f);
        if (alpha > 0.0f) assert_true(seen >= 0.0f);
        if (alpha == 0.0f) assert_memory_equal(h, fn, sizeof h);
        if (facing > 0.0f) assert_true(up >= -1e-6f); /* of the surface's side */
        behind += facing < 0.0f;
    }
    assert_true(behind > 10000);
}

static void test_normals_of_anything(void** state) {
    static const float mirror[] = {0.0f, -1.0f};
    const float v[3] = {0.6f, 0.0f, 0.8f}, n[3] = {0.0f, 0.6f, 0.8f}, away[3] = {0.0f, -0.6f, -0.8f},
                u[2] = {0.3f, 0.7f};
    uint64_t seed = 17u;
    float h[3];
    int i, k;
    (void)state;
    for (i = 0; i < 2; ++i) {
        dgb_ggx_normal(v, n, mirror[i], u, h);
        assert_memory_equal(h, n, sizeof h);
    }
    dgb_ggx_normal(v, n, from_bits(0x7fc00000u), u, h);
    assert_memory_equal(h, n, sizeof h);
    dgb_ggx_normal(away, n, 0.5f, u, h); /* seen from behind: back to the viewer */
    assert_memory_equal(h, away, sizeof h);
    for (i = 0; i < 4; ++i) { /* no place in the square: likewise */
        const float odd = i / 2 ? INFINITY : from_bits(0x7fc00000u),
                    nowhere[2] = {i % 2 ? 0.3f : odd, i % 2 ? odd : 0.7f};
        dgb_ggx_normal(v, n, 0.5f, nowhere, h);
        assert_memory_equal(h, v, sizeof h);
    }
    for (i = 0; i < 200000; ++i) {
        float in[9];
        for (k = 0; k < 9; ++k) in[k] = odd_float(&seed);
        if (i % 2) memcpy(in, v, sizeof v); /* not all at once */
        if (i % 3) memcpy(in + 3, n, sizeof n);
        dgb_ggx_normal(in, in + 3, in[6], in + 7, h);
        assert_true(is_finite(h[0]) && is_finite(h[1]) && is_finite(h[2]));
    }
}

/* The frame about a normal has no pole where the normal points down, and three floats are written. */
static void test_normals_up_and_down(void** state) {
    const float up[3] = {0.0f, 0.0f, 1.0f}, down[3] = {0.0f, 0.0f, -1.0f}, u[2] = {0.3f, 0.7f};
    const float wild[3] = {INFINITY, 0.0f, 1.0f}, x[3] = {1.0f, 0.0f, 0.0f}, y[3] = {0.0f, 1.0f, 0.0f};
    const float far_up[3] = {0.0f, 0.0f, 1e15f};
    float h[4] = {0.0f, 0.0f, 0.0f, 7.0f}, g[3];
    (void)state;
    dgb_ggx_normal(up, up, 0.5f, u, h);
    dgb_ggx_normal(down, down, 0.5f, u, g);
    assert_true(h[2] > 0.1f && h[2] < 0.99f);        /* neither is the mirror's */
    assert_true(fabs((double)(h[2] + g[2])) < 1e-6); /* a few roundings */
    assert_true(h[3] == 7.0f);
    dgb_ggx_normal(wild, wild, 0.5f, u, h);
    assert_memory_equal(h, up, sizeof up);
    assert_true(dgb_ggx_density(x, up, y, 0.5f) == 0.0f);             /* halfway lies in the surface: nobody sees it */
    assert_true(dgb_ggx_density(far_up, up, far_up, 1e-10f) == 0.0f); /* more than a float holds */
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_alpha),
        cmocka_unit_test(test_pair_is_exact),
        cmocka_unit_test(test_pair_is_the_same_ever),
        cmocka_unit_test(test_pairs_of_pixels),
        cmocka_unit_test(test_pairs_of_frames),
        cmocka_unit_test(test_density),
        cmocka_unit_test(test_density_integrates_to_one),
        cmocka_unit_test(test_density_is_total),
        cmocka_unit_test(test_distribution),
        cmocka_unit_test(test_normals_face_the_viewer),
        cmocka_unit_test(test_normals_of_anything),
        cmocka_unit_test(test_normals_up_and_down),
    };
    return cmocka_run_group_tests_name("ggx", tests, NULL, NULL);
}
