/* The mathematics of the visibility bitmask: numbers to sample with, slices of the hemisphere, their shares, and sectors. */

#include "deepgbuffer.h"
#include "numbers.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
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

static void random_direction(uint64_t* seed, float v[3]) {
    const double z = 2.0 * random_unit(seed) - 1.0, turn = 2.0 * pi * random_unit(seed), r = sqrt(1.0 - z * z);
    v[0] = (float)(r * cos(turn));
    v[1] = (float)(r * sin(turn));
    v[2] = (float)z;
}

static double dot(const float a[3], const float b[3]) {
    return (double)a[0] * (double)b[0] + (double)a[1] * (double)b[1] + (double)a[2] * (double)b[2];
}

/* >> numbers to sample with */

/* Every index once, each beside the one before, and the same in every square. */
static void test_hilbert_curve(void** state) {
    static int where[4096][2];
    int x, y, i;
    (void)state;
    for (i = 0; i < 4096; ++i) where[i][0] = -1;
    for (y = 0; y < 64; ++y)
        for (x = 0; x < 64; ++x) {
            const int index = dgb_hilbert_index(x, y);
            assert_true(index >= 0 && index < 4096);
            assert_int_equal(where[index][0], -1);
            where[index][0] = x;
            where[index][1] = y;
            assert_int_equal(dgb_hilbert_index(x + 64, y + 640), index);
            assert_int_equal(dgb_hilbert_index(x - 64, y - 128), index);
        }
    for (i = 1; i < 4096; ++i)
        assert_int_equal(abs(where[i][0] - where[i - 1][0]) + abs(where[i][1] - where[i - 1][1]), 1);
}

/* The same in wider integers: steps of the sequences are 1/p, 1/p^2, 1/q^3, 1/q^4 with p^3 = p + 1, q^5 = q + 1. */
static void test_quad_is_exact(void** state) {
    const double p = 1.3247179572447460, q = 1.1673039782614187;
    const double steps[4] = {1.0 / p, 1.0 / (p * p), 1.0 / (q * q * q), 1.0 / (q * q * q * q)};
    uint64_t seed = 11u;
    int i, k;
    (void)state;
    for (i = 0; i < 100000; ++i) {
        const int x = (int)random_bits(&seed), y = (int)random_bits(&seed);
        const int frame = (int)(random_bits(&seed) >> (i % 32));
        const uint64_t place = (uint64_t)dgb_hilbert_index(x, y) + 288u * (uint64_t)(uint32_t)frame + 1u;
        float u[5] = {0.0f, 0.0f, 0.0f, 0.0f, 7.0f};
        dgb_pixel_quad(x, y, frame, u);
        assert_true(u[4] == 7.0f); /* four are written */
        for (k = 0; k < 4; ++k) {
            const uint32_t step = (uint32_t)floor(steps[k] * 4294967296.0 + 0.5);
            const uint32_t turn = (uint32_t)(place % 4294967296u * step % 4294967296u);
            assert_true((double)u[k] == ((double)(turn >> 9) + 0.5) / 8388608.0);
        }
    }
}

/* Wrap-around L2 discrepancy (Hickernell 1998) of points in some of their coordinates (bits of `which`), squared, as a share of
   what independent random points have on average. It does not change when all are moved alike. */
static double discrepancy(float u[][4], int count, unsigned which) {
    double sum = 0.0, even = 1.0, alone = 1.0;
    int i, j, k;
    for (k = 0; k < 4; ++k)
        if (which >> k & 1u) even *= 4.0 / 3.0, alone *= 1.5;
    for (i = 0; i < count; ++i)
        for (j = 0; j < count; ++j) {
            double product = 1.0;
            for (k = 0; k < 4; ++k) {
                const double apart = fabs((double)u[i][k] - (double)u[j][k]);
                if (which >> k & 1u) product *= 1.5 - apart * (1.0 - apart);
            }
            sum += product;
        }
    return (sum / count / count - even) * count / (alone - even);
}

/* Frames of one pixel, each with the opposite half plane (half a turn on in all four). Random points have 1; ours are so far below
   it in each number alone, and in the pair of the slice's angle and its steps, a fifth more than was measured at the worst. */
static void test_frames_share_out(void** state) {
    static const struct {
        int frames;
        double alone, together;
    } rows[] = {{4, 0.65, 0.27}, {8, 0.26, 0.24}, {16, 0.11, 0.12}, {64, 0.1, 0.08}};
    size_t row;
    (void)state;
    for (row = 0; row < sizeof rows / sizeof rows[0]; ++row) {
        const int frames = rows[row].frames;
        float u[128][4];
        int i, k;
        for (i = 0; i < frames; ++i) {
            dgb_pixel_quad(37, 11, i, u[2 * i]);
            for (k = 0; k < 4; ++k) u[2 * i + 1][k] = (float)fmod((double)u[2 * i][k] + 0.5, 1.0);
        }
        for (k = 0; k < 4; ++k) assert_true(discrepancy(u, 2 * frames, 1u << k) < rows[row].alone);
        assert_true(discrepancy(u, 2 * frames, 3u) < rows[row].together);
    }
}

/* Pixels of a square of 6 x 6, where a filter looks, over so many frames: the mean over squares all over the image. Bounds as
   above. */
static void test_neighbours_share_out(void** state) {
    static const struct {
        int frames;
        double alone, together;
    } rows[] = {{1, 0.5, 0.5}, {4, 0.33, 0.26}, {8, 0.27, 0.18}};
    size_t row;
    (void)state;
    for (row = 0; row < sizeof rows / sizeof rows[0]; ++row) {
        enum { SQUARES = 50, MOST = 36 * 8 };
        double alone[4] = {0.0}, together = 0.0;
        uint64_t seed = 2u;
        int square, i, k, frame;
        for (square = 0; square < SQUARES; ++square) {
            const int x = (int)(random_bits(&seed) % 1000u), y = (int)(random_bits(&seed) % 1000u);
            float u[MOST][4];
            for (frame = 0; frame < rows[row].frames; ++frame)
                for (i = 0; i < 36; ++i) dgb_pixel_quad(x + i % 6, y + i / 6, frame, u[36 * frame + i]);
            for (k = 0; k < 4; ++k) alone[k] += discrepancy(u, 36 * rows[row].frames, 1u << k) / SQUARES;
            together += discrepancy(u, 36 * rows[row].frames, 3u) / SQUARES;
        }
        for (k = 0; k < 4; ++k) assert_true(alone[k] < rows[row].alone);
        assert_true(together < rows[row].together);
    }
}

/* >> slices and sectors */

static void test_arc_sine(void** state) {
    int i;
    (void)state;
    for (i = -100000; i <= 100000; ++i) {
        const float x = (float)i / 100000.0f;
        const double a = fabs((double)x), published = 1.5707288 + a * (-0.2121144 + a * (0.0742610 - a * 0.0187293));
        const double b = 0.5 * pi - sqrt(1.0 - a) * published;
        assert_true(fabs((double)dgb_arc_sine(x) - asin((double)x)) <=
                    6.8e-5);                                               /* Abramowitz and Stegun: 5e-5 + floats */
        assert_true(fabs(fabs((double)dgb_arc_sine(x)) - fabs(b)) < 3e-7); /* a few ulps of pi / 2 */
    }
    assert_true(dgb_arc_sine(0.0f) >= 0.0f && dgb_arc_sine(0.0f) <= 6.8e-5f);
    assert_true(dgb_arc_sine(2.0f) == dgb_arc_sine(1.0f) && dgb_arc_sine(-1e30f) == dgb_arc_sine(-1.0f));
}

/* Share of the slice between the eye and angle t, by the midpoint rule: error below 1e-6 with 4000 intervals. */
static double integrated_share(double g, double t) {
    const double horizon = g + 0.5 * pi;
    const int steps = 4000;
    double part = 0.0, whole = 0.0;
    int i;
    if (t >= horizon) return 1.0;
    for (i = 0; i < steps; ++i) {
        const double a = ((double)i + 0.5) / steps * t, b = ((double)i + 0.5) / steps * horizon;
        part += cos(a - g) * sin(a) * t;
        whole += cos(b - g) * sin(b) * horizon;
    }
    return part / whole;
}

/* g from 5 degrees above -90 on: below, the slice holds less than 3e-4 of the light, and the polynomial was not fitted. */
static void test_share(void** state) {
    static const float v[3] = {0.0f, 0.0f, 1.0f}, along[3] = {1.0f, 0.0f, 0.0f};
    int i, k;
    (void)state;
    for (i = -85; i <= 89; ++i) {
        const double g = i * pi / 180.0;
        const float n[3] = {(float)sin(g), 0.0f, (float)cos(g)};
        float slice[4], last = 0.0f;
        dgb_slice(n, v, along, slice);
        assert_true(fabs((double)slice[2] - g) < 1e-4); /* the arc sine's error */
        for (k = 0; k <= 60; ++k) {
            const double t = k * pi / 60.0;
            const float q[2] = {(float)(3.0 * cos(t)), (float)(3.0 * sin(t))};
            const float share = dgb_slice_share(slice, q), mirrored[2] = {q[0], -q[1]};
            assert_true(fabs((double)share - integrated_share(g, t)) <
                        4.4e-3); /* the polynomial's: it was fitted to be */
            assert_true(mirrored[1] >= 0.0f || dgb_slice_share(slice, mirrored) == 1.0f);
            assert_true(share >= last - 1e-3f); /* grows from the eye on */
            last = share;
        }
        assert_true(last == 1.0f);
    }
}

/* Of a surface that faces the eye: the square of the sine. */
static void test_share_of_a_facing_surface(void** state) {
    static const float n[3] = {0.0f, 0.0f, 1.0f}, along[3] = {0.6f, 0.8f, 0.0f};
    float slice[4];
    int i;
    (void)state;
    dgb_slice(n, n, along, slice);
    /* within a few roundings: -ffast-math may divide by multiplying */
    assert_true(fabsf(slice[0] - 1.0f) < 1e-6f && fabsf(slice[1]) < 1e-6f && fabsf(slice[3] - 1.0f) < 1e-6f);
    for (i = 0; i <= 90; ++i) {
        const double t = i * pi / 180.0;
        const float q[2] = {(float)cos(t), (float)sin(t)};
        assert_true(i == 90 || fabs((double)dgb_slice_share(slice, q) - sin(t) * sin(t)) < 1e-6);
    }
}

/* Where only a millionth of the direction is across the line of sight there is no slice of its own; three floats are written. */
static void test_slice_along_the_line_of_sight(void** state) {
    const float v[3] = {0.0f, 0.0f, 1.0f}, none[3] = {0.0f, 0.0f, 0.0f}, away[3] = {0.0f, 0.0f, -1.0f};
    const float up[3] = {0.0f, 1e-6f, 1.0f}, more[3] = {0.0f, 1.1e-6f, 1.0f};
    float along[4] = {0.0f, 0.0f, 0.0f, 7.0f};
    (void)state;
    dgb_slice_along(v, v, away, along);
    assert_true(along[0] == 1.0f && along[1] == 0.0f && along[2] == 0.0f && along[3] == 7.0f);
    dgb_slice_along(up, v, none, along);
    assert_true(along[0] == 1.0f && along[1] == 0.0f && along[2] == 0.0f);
    dgb_slice_along(more, v, none, along);
    assert_true(along[0] == 0.0f && fabsf(along[1] - 1.0f) < 1e-6f && along[2] == 0.0f && along[3] == 7.0f);
}

/* A direction of the cosine-weighted hemisphere picks the slice that it lies in, and the share is the distribution function of
   such directions in their slice: so shares of directions, each in its own slice, are evenly distributed. */
static void test_slices_of_directions(void** state) {
    uint64_t seed = 3u;
    int surface, i, b;
    (void)state;
    for (surface = 0; surface < 12; ++surface) {
        enum { DIRECTIONS = 40000, BINS = 8 };
        int bins[BINS] = {0};
        float n[3], v[3];
        do random_direction(&seed, n), random_direction(&seed, v);
        while (dot(n, v) < 0.05);
        for (i = 0; i < DIRECTIONS; ++i) {
            float s[3], along[3], slice[4], q[2], w[3];
            int k;
            random_direction(&seed, s);
            dgb_slice_along(n, v, s, along);
            dgb_slice(n, v, along, slice);
            for (k = 0; k < 3; ++k) w[k] = n[k] + s[k];
            q[0] = (float)dot(w, v);
            q[1] = (float)dot(w, along);
            assert_true(fabs(dot(along, along) - 1.0) < 1e-5 && q[1] >= 0.0f);
            assert_true(fabs(dot(along, v)) * (double)q[1] <
                        1e-6); /* some ulps of n + s, whose part across v is q[1] */
            b = (int)(dgb_slice_share(slice, q) * BINS);
            ++bins[b < BINS ? b : BINS - 1];
        }
        /* five standard deviations of a binomial count; seeds are fixed, so this passes or fails for good */
        for (b = 0; b < BINS; ++b)
            assert_true(fabs(bins[b] - (double)DIRECTIONS / BINS) < 5.0 * sqrt((double)DIRECTIONS / BINS));
    }
}

/* The share at the angle that is found for a share is that share, for all slices but those that hold next to nothing. */
static void test_angle_of_a_share(void** state) {
    int i, k;
    (void)state;
    for (i = -85; i <= 90; ++i) {
        const double g = i * pi / 180.0;
        const float n[3] = {(float)sin(g), 0.0f, (float)cos(g)}, v[3] = {0.0f, 0.0f, 1.0f},
                    along[3] = {1.0f, 0.0f, 0.0f};
        float slice[4];
        dgb_slice(n, v, along, slice);
        for (k = 0; k <= 32; ++k) {
            const double t = (double)dgb_slice_angle(slice, (float)k / 32.0f);
            /* beside the arc sine's error, as in test_share */
            assert_true(fabs(integrated_share(g, t) - k / 32.0) < 1e-3 + 2e-4 * (double)slice[3]);
        }
        /* the slice's own horizon: beside the eye an ulp of its sine, which -ffast-math may cost, is 3e-4 of an angle */
        assert_true(fabs((double)dgb_slice_angle(slice, 1.0f) - (double)slice[2] - 0.5 * pi) < 1e-6);
    }
}

/* Sums of directions against the midpoint rule, and those of sectors within what four of them, bent by a 2/8 of a slice, differ. */
static void test_sums_of_directions(void** state) {
    int i, k;
    (void)state;
    for (i = -80; i <= 90; i += 5) {
        enum { STEPS = 4000 };
        const double g = i * pi / 180.0, horizon = g + 0.5 * pi;
        const float n[3] = {(float)sin(g), 0.0f, (float)cos(g)}, v[3] = {0.0f, 0.0f, 1.0f},
                    along[3] = {1.0f, 0.0f, 0.0f};
        double weight = 0.0, sum[2] = {0.0, 0.0}, at[9][2] = {{0.0}}, whole;
        float slice[4], out[3];
        int sector = 0;
        dgb_slice(n, v, along, slice);
        whole = 1.0 / (double)slice[3];
        for (k = 0; k < STEPS; ++k) {
            const double t = (k + 0.5) / STEPS * horizon, w = 2.0 * cos(t - g) * sin(t) * horizon / STEPS / whole;
            weight += w, sum[0] += w * cos(t), sum[1] += w * sin(t);
            while (sector < 8 && weight >= (sector + 1) / 8.0) ++sector, at[sector][0] = sum[0], at[sector][1] = sum[1];
            if (k % 500 != 499) continue;
            dgb_slice_sum(slice, (float)((k + 1.0) / STEPS * horizon), out);
            assert_true(fabs((double)out[0] - sum[0]) < 1e-3 && fabs((double)out[1] - sum[1]) < 1e-3);
        }
        out[2] = 7.0f;
        dgb_sectors_mean(slice, 0u, out);
        assert_true(out[0] == 0.0f && out[1] == 0.0f && out[2] == 7.0f); /* two are written */
        dgb_sectors_mean(slice, 0xffffffffu, out);
        assert_true(out[2] == 7.0f);
        assert_true(fabs((double)out[0] - sum[0]) < 1e-3 && fabs((double)out[1] - sum[1]) < 1e-3);
        for (k = 0; k < 7; ++k) { /* whole groups are exact */
            dgb_sectors_mean(slice, 0xfu << (4 * k), out);
            assert_true(fabs((double)out[0] - at[k + 1][0] + at[k][0]) < 2e-3);
            assert_true(fabs((double)out[1] - at[k + 1][1] + at[k][1]) < 2e-3);
        }
    }
}

/* The cone of a mean's length: of a hemisphere, of closed cones, and where there is none. */
static void test_bent_cosine(void** state) {
    const float none[4] = {0.0f, 0.0f, 0.0f, 0.0f}, odd[4] = {NAN, 0.0f, 0.0f, 1.0f},
                narrow[4] = {0.0f, 0.3f, 0.0f, 0.3f}, more[5] = {0.0f, 0.0f, 0.3f, 0.4f, NAN}; /* four are read */
    int i;
    (void)state;
    for (i = 0; i <= 100; ++i) {
        const double c = i / 100.0, length = 2.0 / 3.0 * (1.0 + c + c * c) / (1.0 + c);
        const float bent[4] = {0.0f, (float)(-0.6 * length * 0.4), (float)(0.8 * length * 0.4), 0.4f};
        /* near 0 the cosine is the root of what lengths differ by */
        assert_true(fabs((double)dgb_bent_cosine(bent) - c) < (i < 10 ? 1e-3 : 1e-5));
    }
    assert_true(dgb_bent_cosine(none) == 1.0f && dgb_bent_cosine(odd) == 0.0f && dgb_bent_cosine(narrow) > 0.99999f);
    assert_true(dgb_bent_cosine(more) < 0.9f);
}

static void test_sector_count(void** state) {
    uint64_t seed = 1u;
    int i, k;
    (void)state;
    for (i = 0; i < 100000; ++i) {
        const uint32_t sectors = i < 32 ? 1u << i : i == 32 ? 0u : i == 33 ? 0xffffffffu : random_bits(&seed);
        int count = 0;
        for (k = 0; k < 32; ++k) count += (int)(sectors >> k & 1u);
        assert_int_equal(dgb_sector_count(sectors), count);
    }
}

static void test_sectors(void** state) {
    int from, to, k;
    (void)state;
    for (from = 0; from <= 32; ++from)
        for (to = 0; to <= 32; ++to) {
            const uint32_t sectors = dgb_sectors((float)from / 32.0f, (float)to / 32.0f, 0.5f);
            for (k = 0; k < 32; ++k) assert_int_equal(sectors >> k & 1u, k >= from && k < to);
        }
    assert_true(dgb_sectors(0.0f, 1.0f, 0.0f) == 0xffffffffu && dgb_sectors(0.0f, 1.0f, 0.99f) == 0xffffffffu);
    assert_true(dgb_sectors(0.01f, 0.02f, 0.1f) == 0u && dgb_sectors(0.01f, 0.02f, 0.5f) == 1u);
}

/* The mean over the rounding of the sectors in a union of intervals is its measure, overlaps, touching ends and all. */
static void test_rounding_has_no_bias(void** state) {
    uint64_t seed = 5u;
    int trial, i, k;
    (void)state;
    for (trial = 0; trial < 200; ++trial) {
        enum { INTERVALS = 4, ROUNDINGS = 4096 };
        float ends[INTERVALS][2];
        double measure = 0.0, mean = 0.0;
        int fine[4096] = {0};
        for (i = 0; i < INTERVALS; ++i) {
            const int a = (int)(random_bits(&seed) % 4097u), b = (int)(random_bits(&seed) % 4097u);
            const int low = a < b ? a : b, high = a < b ? b : a;
            ends[i][0] = (float)low / 4096.0f;
            ends[i][1] = (float)high / 4096.0f;
            for (k = low; k < high; ++k) fine[k] = 1;
        }
        for (k = 0; k < 4096; ++k) measure += fine[k] / 4096.0;
        for (k = 0; k < ROUNDINGS; ++k) {
            const float u = ((float)k + 0.5f) / (float)ROUNDINGS;
            uint32_t seen = 0u;
            for (i = 0; i < INTERVALS; ++i) seen |= dgb_sectors(ends[i][0], ends[i][1], u);
            mean += dgb_sector_count(seen) / (32.0 * ROUNDINGS);
        }
        assert_true(fabs(mean - measure) < 1e-6); /* sums of doubles: the ends are multiples of the step of u */
    }
}

static void test_anything_goes(void** state) {
    uint64_t seed = 7u;
    int i, k;
    (void)state;
    for (i = 0; i < 200000; ++i) {
        float n[3], v[3], s[3], along[3], slice[4], q[2], share;
        for (k = 0; k < 3; ++k) n[k] = odd_float(&seed), v[k] = odd_float(&seed), s[k] = odd_float(&seed);
        for (k = 0; k < 2; ++k) q[k] = odd_float(&seed);
        dgb_slice_along(n, v, s, along);
        for (k = 0; k < 3; ++k) assert_true(along[k] >= -1.001f && along[k] <= 1.001f);
        dgb_slice(n, v, along, slice);
        for (k = 0; k < 4; ++k) assert_true(slice[k] >= -2.0f && slice[k] <= 1.1e5f);
        share = dgb_slice_share(slice, q);
        assert_true(share >= 0.0f && share <= 1.0f);
        (void)dgb_sectors(odd_float(&seed), odd_float(&seed), odd_float(&seed)); /* sanitizers look on */
    }
    assert_true(dgb_sectors(from_bits(0x7fc00000u), 1.0f, 0.5f) == 0xffffffffu);
    assert_true(dgb_sectors(0.0f, from_bits(0x7fc00000u), 0.5f) == 0u);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_hilbert_curve),
        cmocka_unit_test(test_quad_is_exact),
        cmocka_unit_test(test_frames_share_out),
        cmocka_unit_test(test_neighbours_share_out),
        cmocka_unit_test(test_arc_sine),
        cmocka_unit_test(test_share),
        cmocka_unit_test(test_share_of_a_facing_surface),
        cmocka_unit_test(test_slice_along_the_line_of_sight),
        cmocka_unit_test(test_slices_of_directions),
        cmocka_unit_test(test_angle_of_a_share),
        cmocka_unit_test(test_sums_of_directions),
        cmocka_unit_test(test_bent_cosine),
        cmocka_unit_test(test_sector_count),
        cmocka_unit_test(test_sectors),
        cmocka_unit_test(test_rounding_has_no_bias),
        cmocka_unit_test(test_anything_goes),
    };
    return cmocka_run_group_tests_name("bitmask", tests, NULL, NULL);
}
