/* Taps: the table of turns, the spiral, its rotations, the pixel hash, MIP levels and what they were copied
   from. */

#include "deepgbuffer.h"
#include "numbers.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <limits.h>
#include <math.h>
#include <string.h>

#define PI_L 3.14159265358979323846264338327950288L
#define FLOAT_ULP 1.1920929e-7L /* at 1 */

/* >> turns

   The measure that the table minimises: over all closed boxes with edges at taps, in the unit square of
   (kappa, theta / 2 pi), the largest of (share of the taps inside) - (area). With n taps, kappa in steps of
   1/n and theta in steps of 1/(2n), times 2 n n, that is the integer 2 n count - steps_kappa steps_theta. */

enum { MAX_N = DGB_MAX_TAPS };

/* Angle of tap i in steps of 1/(2n) turns; the circle has 2n of them. */
static int angle_of_tap(int i, int n, int turns) { return (2 * i + 1) * turns % (2 * n); }

static void insert_sorted(int* sorted, int count, int value) {
    int i = count;
    for (; i > 0 && sorted[i - 1] > value; --i) sorted[i] = sorted[i - 1];
    sorted[i] = value;
}

/* The fullest box around `count` consecutive taps. Which ones does not matter: a shift in kappa only turns
   them. An arc from sorted[a] to sorted[b] holds b - a + 1 taps; one that passes angle 0 has b < a and holds
   `count` more. */
static int fullest_arc(const int* sorted, int count, int n) {
    const int steps_kappa = count - 1;
    int lowest_start = INT_MAX, highest_end = INT_MIN, fullest = 0, i;
    for (i = 0; i < count; ++i) {
        const int value = 2 * n * i - steps_kappa * sorted[i];
        const int passing = 2 * n * (count + 1) - steps_kappa * 2 * n + highest_end - value;
        if (value < lowest_start) lowest_start = value;
        if (value - lowest_start + 2 * n > fullest) fullest = value - lowest_start + 2 * n;
        if (i > 0 && passing > fullest) fullest = passing;
        if (value > highest_end) highest_end = value;
    }
    return fullest;
}

/* Discrepancy times 2 n n; gives up, with some larger number, once it is above `limit`. */
static int discrepancy(int n, int turns, int limit) {
    int sorted[MAX_N], worst = 0, count;
    for (count = 1; count <= n && worst <= limit; ++count) {
        int fullest;
        insert_sorted(sorted, count - 1, angle_of_tap(count - 1, n, turns));
        fullest = fullest_arc(sorted, count, n);
        if (fullest > worst) worst = fullest;
    }
    return worst;
}

/* The smallest minimiser from 2 on; there is no choice for n <= 2. */
static int best_turns(int n) {
    int best = 1, best_value = INT_MAX, turns;
    for (turns = n <= 2 ? 1 : 2; turns <= n; ++turns) {
        const int value = discrepancy(n, turns, best_value);
        if (value >= best_value) continue;
        best = turns;
        best_value = value;
    }
    return best;
}

/* The measure again, straight from its definition. */
static int discrepancy_by_definition(int n, int turns) {
    int worst = 0, first, last, from, to, i;
    for (first = 0; first < n; ++first)
        for (last = first; last < n; ++last)
            for (from = first; from <= last; ++from)
                for (to = first; to <= last; ++to) {
                    const int start = angle_of_tap(from, n, turns);
                    const int width = (angle_of_tap(to, n, turns) - start + 2 * n) % (2 * n);
                    int count = 0;
                    for (i = first; i <= last; ++i)
                        count += (angle_of_tap(i, n, turns) - start + 2 * n) % (2 * n) <= width;
                    if (2 * n * count - (last - first) * width > worst) worst = 2 * n * count - (last - first) * width;
                }
    return worst;
}

static void test_measure_is_the_definition(void** state) {
    int n, turns;
    (void)state;
    for (n = 1; n <= 16; ++n)
        for (turns = 1; turns <= n; ++turns) {
            const int fast = discrepancy(n, turns, INT_MAX), slow = discrepancy_by_definition(n, turns);
            if (fast != slow) fail_msg("n %d, turns %d: %d, by definition %d", n, turns, fast, slow);
        }
}

static void test_turns_minimise_the_discrepancy(void** state) {
    int n;
    (void)state;
    for (n = 1; n <= DGB_MAX_TAPS; ++n) {
        const int best = best_turns(n);
        if (dgb_spiral_turns(n) != best) fail_msg("n %d: %d turns, best are %d", n, dgb_spiral_turns(n), best);
    }
}

/* Listing 3 of the paper, as printed; 29 for 99 is what its Figure 7 was made with. */
static void test_turns_as_published(void** state) {
    static const int listing[] = {1,  1,  2,  3,  2,  5,  2,  3,  2,  3,  3,  5,  5,  3,  4,  7,  5,  5,  7,  9,
                                  8,  5,  5,  7,  7,  7,  8,  5,  8,  11, 12, 7,  10, 13, 8,  11, 8,  7,  14, 11,
                                  11, 13, 12, 13, 19, 17, 13, 11, 18, 19, 11, 11, 14, 17, 21, 15, 16, 17, 18, 13,
                                  17, 11, 17, 19, 18, 25, 18, 19, 19, 29, 21, 19, 27, 31, 29, 21, 18, 17, 29, 31,
                                  31, 23, 18, 25, 26, 25, 23, 19, 34, 19, 27, 21, 25, 39, 29, 17, 21, 27};
    int n;
    (void)state;
    assert_int_equal(sizeof listing / sizeof listing[0], 98);
    for (n = 1; n <= 98; ++n)
        if (dgb_spiral_turns(n) != listing[n - 1]) fail_msg("n %d: %d turns", n, dgb_spiral_turns(n));
    assert_int_equal(dgb_spiral_turns(99), 29);
}

static void test_turns_outside_the_table(void** state) {
    static const int none[] = {0, -1, -98, INT_MIN};
    static const int large[] = {257, 258, 300, 377, 610, 1000, 1024, 65536, 1000003, INT_MAX};
    const long double golden = (3.0L - sqrtl(5.0L)) / 2.0L;
    size_t i;
    (void)state;
    for (i = 0; i < sizeof none / sizeof none[0]; ++i) assert_int_equal(dgb_spiral_turns(none[i]), 0);
    for (i = 0; i < sizeof large / sizeof large[0]; ++i)
        if (dgb_spiral_turns(large[i]) != (int)floorl((long double)large[i] * golden + 0.5L))
            fail_msg("n %d: %d turns", large[i], dgb_spiral_turns(large[i]));
}

/* >> taps */

static void check_tap(int i, int n) {
    const long double kappa = ((long double)i + 0.5L) / n;
    const long double theta = 2.0L * PI_L * fmodl(kappa * dgb_spiral_turns(n), 1.0L);
    float tap[3];
    dgb_spiral_tap(i, n, tap);
    if (fabsl(tap[0] - cosl(theta)) > FLOAT_ULP || fabsl(tap[1] - sinl(theta)) > FLOAT_ULP)
        fail_msg("tap %d of %d points along (%.9g, %.9g)", i, n, (double)tap[0], (double)tap[1]);
    if (fabsl((long double)tap[0] * tap[0] + (long double)tap[1] * tap[1] - 1.0L) > 2.0L * FLOAT_ULP)
        fail_msg("tap %d of %d: no unit vector", i, n);
    if (fabsl(tap[2] - kappa) > 0.51L * FLOAT_ULP * kappa) fail_msg("tap %d of %d: kappa %.9g", i, n, (double)tap[2]);
}

static void test_taps(void** state) {
    int n, i;
    (void)state;
    for (n = 1; n <= DGB_MAX_TAPS; ++n) {
        float last = 0.0f;
        for (i = 0; i < n; ++i) {
            float tap[3];
            check_tap(i, n);
            dgb_spiral_tap(i, n, tap);
            if (!(tap[2] > last && tap[2] < 1.0f)) fail_msg("tap %d of %d: kappa %.9g", i, n, (double)tap[2]);
            last = tap[2];
        }
    }
}

static void test_taps_of_long_spirals(void** state) {
    static const int large[] = {257, 1000, 65536, 16777217, INT_MAX};
    size_t k;
    (void)state;
    for (k = 0; k < sizeof large / sizeof large[0]; ++k) {
        check_tap(0, large[k]);
        check_tap(large[k] / 3, large[k]);
        check_tap(large[k] - 1, large[k]);
    }
}

static void test_taps_out_of_range(void** state) {
    static const int pairs[][2] = {{-1, 9},
                                   {9, 9},
                                   {10, 9},
                                   {0, 0},
                                   {0, -1},
                                   {-1, -1},
                                   {INT_MIN, 9},
                                   {INT_MAX, 9},
                                   {INT_MIN, INT_MIN},
                                   {5, INT_MIN},
                                   {INT_MAX, INT_MAX}};
    size_t k;
    (void)state;
    for (k = 0; k < sizeof pairs / sizeof pairs[0]; ++k) {
        float tap[3] = {9.0f, 9.0f, 9.0f};
        dgb_spiral_tap(pairs[k][0], pairs[k][1], tap);
        if (tap[0] != 1.0f || tap[1] != 0.0f || tap[2] != 0.0f) fail_msg("tap %d of %d", pairs[k][0], pairs[k][1]);
    }
}

/* >> rotations */

static void test_rotations(void** state) {
    float all[DGB_ROTATION_COUNT][2];
    int i, j;
    (void)state;
    for (i = 0; i < DGB_ROTATION_COUNT; ++i) {
        const long double phi = 2.0L * PI_L * i / DGB_ROTATION_COUNT;
        dgb_rotation(i, all[i]);
        if (fabsl(all[i][0] - cosl(phi)) > FLOAT_ULP || fabsl(all[i][1] - sinl(phi)) > FLOAT_ULP)
            fail_msg("rotation %d is (%.9g, %.9g)", i, (double)all[i][0], (double)all[i][1]);
        for (j = 0; j < i; ++j)
            if (all[i][0] == all[j][0] && all[i][1] == all[j][1]) fail_msg("rotations %d and %d are one", i, j);
    }
}

static void test_rotations_repeat(void** state) {
    static const int indices[] = {-1, 256, 257, -256, 511, 1 << 20, INT_MAX, INT_MIN};
    size_t k;
    (void)state;
    for (k = 0; k < sizeof indices / sizeof indices[0]; ++k) {
        float a[2], b[2];
        dgb_rotation(indices[k], a);
        dgb_rotation((indices[k] % 256 + 256) % 256, b);
        if (!same_bits(a, b, sizeof a)) fail_msg("rotation %d", indices[k]);
    }
}

/* >> pixel hash */

/* The same in 64 bits: what GLSL's uint arithmetic does, and no other. */
static int hash_oracle(int x, int y, int frame) {
    const uint64_t mask = 0xffffffffu;
    uint64_t h = ((uint64_t)(int64_t)x * 0x8da6b343u & mask) ^ ((uint64_t)(int64_t)y * 0xd8163841u & mask);
    h = ((h ^ (h >> 16)) * 0x7feb352du) & mask;
    h = ((h ^ (h >> 15)) * 0x846ca68bu) & mask;
    return (int)(((h >> 24) + (uint64_t)(int64_t)frame * 159u) & 255u);
}

static void test_hash_is_exact_and_total(void** state) {
    static const int values[] = {0, 1, -1, 2, 255, 256, 16383, 16384, 65535, 1 << 30, INT_MAX, INT_MIN, INT_MIN + 1};
    const size_t count = sizeof values / sizeof values[0];
    size_t i, j, k;
    (void)state;
    for (i = 0; i < count; ++i)
        for (j = 0; j < count; ++j)
            for (k = 0; k < count; ++k) {
                const int h = dgb_pixel_hash(values[i], values[j], values[k]);
                if (h != hash_oracle(values[i], values[j], values[k]) || h < 0 || h > 255)
                    fail_msg("hash of %d, %d, %d is %d", values[i], values[j], values[k], h);
            }
}

/* 255 degrees of freedom: mean 255, standard deviation 23. The limits are 5 deviations for one tile. */
static void check_tile(int x0, int y0, int frame) {
    int seen[DGB_ROTATION_COUNT] = {0}, x, y, i;
    double chi2 = 0.0;
    for (y = 0; y < 64; ++y)
        for (x = 0; x < 64; ++x) ++seen[dgb_pixel_hash(x0 + x, y0 + y, frame)];
    for (i = 0; i < DGB_ROTATION_COUNT; ++i) {
        if (!seen[i]) fail_msg("tile %d, %d, frame %d never takes rotation %d", x0, y0, frame, i);
        chi2 += (seen[i] - 16.0) * (seen[i] - 16.0) / 16.0;
    }
    if (chi2 < 142.0 || chi2 > 368.0) fail_msg("tile %d, %d, frame %d: chi-square %.1f", x0, y0, frame, chi2);
}

static void test_hash_uses_all_rotations(void** state) {
    int x, y;
    (void)state;
    for (y = 0; y < 8; ++y)
        for (x = 0; x < 8; ++x) check_tile(64 * x, 64 * y, 0);
    check_tile(16384 - 64, 16384 - 64, 0);
    check_tile(640, 384, 1);
    check_tile(640, 384, 12345);
}

/* Correlation of every pixel with its neighbour at (dx, dy), of all 256 by 256. */
static double hash_correlation(int dx, int dy) {
    double sum = 0.0, sum2 = 0.0, product = 0.0, mean, variance;
    int x, y;
    for (y = 0; y < 256; ++y)
        for (x = 0; x < 256; ++x) {
            const double a = dgb_pixel_hash(x, y, 0), b = dgb_pixel_hash(x + dx, y + dy, 0);
            sum += a, sum2 += a * a, product += a * b;
        }
    mean = sum / 65536.0;
    variance = sum2 / 65536.0 - mean * mean;
    return (product / 65536.0 - mean * mean) / variance;
}

static void test_hash_has_no_rows_or_columns(void** state) {
    int dx, dy;
    (void)state;
    for (dy = 0; dy <= 4; ++dy)
        for (dx = dy ? -4 : 1; dx <= 4; ++dx) {
            const double r = hash_correlation(dx, dy);
            if (fabs(r) > 0.05) fail_msg("correlation %.4f at %d, %d", r, dx, dy);
        }
}

/* Any n frames in a row share out the circle: no gap is wider than three times the even share, and 256 frames take every
   rotation once. */
static void test_frames_share_the_circle(void** state) {
    int n, first;
    (void)state;
    for (n = 2; n <= DGB_ROTATION_COUNT; ++n)
        for (first = 0; first < 3; ++first) {
            bool taken[DGB_ROTATION_COUNT] = {false};
            int i, gap = 0, widest = 0, start;
            for (i = 0; i < n; ++i) taken[dgb_pixel_hash(17, 4, first + i)] = true;
            for (start = 0; !taken[start]; ++start) {}
            for (i = 1; i <= DGB_ROTATION_COUNT; ++i) {
                ++gap;
                if (!taken[(start + i) % DGB_ROTATION_COUNT]) continue;
                widest = gap > widest ? gap : widest;
                gap = 0;
            }
            if (widest * n > 3 * DGB_ROTATION_COUNT) fail_msg("%d frames leave a gap of %d", n, widest);
        }
}

/* >> MIP level */

static int clamp(int x, int low, int high) { return x < low ? low : x > high ? high : x; }

static void check_level(float h, int log2_floor) {
    static const int limits[][2] = {{0, 5}, {0, 0}, {2, 5}, {3, 3}, {1, 4}};
    int log2_q;
    size_t i;
    for (log2_q = 3; log2_q <= 4; ++log2_q)
        for (i = 0; i < sizeof limits / sizeof limits[0]; ++i) {
            const int level = dgb_mip_level(h, log2_q, limits[i][0], limits[i][1]);
            if (level != clamp(log2_floor - log2_q, limits[i][0], limits[i][1]))
                fail_msg("h %.9g, q 2^%d, limits %d, %d: level %d", (double)h, log2_q, limits[i][0], limits[i][1],
                         level);
        }
}

static void test_level_around_powers_of_two(void** state) {
    int exponent;
    (void)state;
    for (exponent = -126; exponent <= 127; ++exponent) {
        const float h = ldexpf(1.0f, exponent);
        check_level(h, exponent);
        check_level(from_bits(bits_of(h) + 1), exponent);
        check_level(from_bits(bits_of(h) - 1), exponent - 1);
    }
}

static void test_level_of_anything(void** state) {
    static const uint32_t low[] = {0u,          0x80000000u, 1u,          0x007fffffu, 0x80000001u, 0x7fc00000u,
                                   0xffc00000u, 0x7f800001u, 0xff800001u, 0xff800000u, 0xff7fffffu, 0xc4000000u};
    static const uint32_t high[] = {0x7f800000u, 0x7f7fffffu, 0x60000000u};
    size_t i;
    (void)state;
    for (i = 0; i < sizeof low / sizeof low[0]; ++i) check_level(from_bits(low[i]), -1000);
    for (i = 0; i < sizeof high / sizeof high[0]; ++i) check_level(from_bits(high[i]), 1000);
}

/* >> MIP chain */

/* The rule of one step: texel p copies 2p + (p.y & 1, p.x & 1) of the level before. */
static void copied_from(const int p[2], int source[2]) {
    const int x = p[0], y = p[1];
    source[0] = 2 * x + (y & 1);
    source[1] = 2 * y + (x & 1);
}

static void check_chain(int width, int height) {
    const int levels = dgb_mip_levels(width, height);
    int level, x, y;
    if (levels < 1 || levels > DGB_MAX_LEVELS) fail_msg("%d x %d: %d levels", width, height, levels);
    if (levels < DGB_MAX_LEVELS && width >> levels && height >> levels)
        fail_msg("%d x %d: more than %d levels could be", width, height, levels);
    for (level = 1; level < levels; ++level)
        for (y = 0; y < height >> level; ++y)
            for (x = 0; x < width >> level; ++x) {
                const int p[2] = {x, y};
                int source[2];
                copied_from(p, source);
                if (source[0] >= width >> (level - 1) || source[1] >= height >> (level - 1))
                    fail_msg("%d x %d: level %d texel %d, %d copies from outside", width, height, level, x, y);
            }
    if (!(width >> (levels - 1)) || !(height >> (levels - 1))) fail_msg("%d x %d: an empty level", width, height);
}

static void test_chains_need_no_clamping(void** state) {
    int width, height;
    (void)state;
    for (width = 1; width <= 257; ++width)
        for (height = 1; height <= 17; ++height) {
            check_chain(width, height);
            check_chain(height, width); /* NOLINT: turned on its side */
        }
    assert_int_equal(dgb_mip_levels(16384, 16384), DGB_MAX_LEVELS);
    assert_int_equal(dgb_mip_levels(16384, 1), 1);
    assert_int_equal(dgb_mip_levels(1, 1), 1);
    assert_int_equal(dgb_mip_levels(32, 32), 6);
    assert_int_equal(dgb_mip_levels(31, 4096), 5);
}

static void check_sources(int width, int height) {
    const int levels = dgb_mip_levels(width, height);
    int level, x, y, m;
    for (level = 0; level < levels; ++level)
        for (y = 0; y < height >> level; ++y)
            for (x = 0; x < width >> level; ++x) {
                const int p[2] = {x, y};
                int expected[2] = {x, y}, source[2];
                for (m = level; m > 0; --m) {
                    const int q[2] = {expected[0], expected[1]};
                    copied_from(q, expected);
                }
                dgb_mip_source(p, level, source);
                if (source[0] != expected[0] || source[1] != expected[1])
                    fail_msg("level %d texel %d, %d comes from %d, %d, not %d, %d", level, x, y, expected[0],
                             expected[1], source[0], source[1]);
                if (source[0] < 0 || source[0] >= width || source[1] < 0 || source[1] >= height)
                    fail_msg("%d x %d: level %d texel %d, %d comes from outside", width, height, level, x, y);
            }
}

static void test_sources_iterate_the_copy_rule(void** state) {
    int width, height;
    (void)state;
    for (width = 1; width <= 67; ++width)
        for (height = 1; height <= 35; ++height) check_sources(width, height);
    check_sources(301, 199);
}

static void test_sources_of_the_largest_buffer(void** state) {
    const int last[2] = {(16384 >> 5) - 1, (16384 >> 5) - 1};
    int source[2];
    (void)state;
    dgb_mip_source(last, 5, source);
    assert_int_equal(source[0], 16383);
    assert_int_equal(source[1], 16383);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_measure_is_the_definition),
        cmocka_unit_test(test_turns_minimise_the_discrepancy),
        cmocka_unit_test(test_turns_as_published),
        cmocka_unit_test(test_turns_outside_the_table),
        cmocka_unit_test(test_taps),
        cmocka_unit_test(test_taps_of_long_spirals),
        cmocka_unit_test(test_taps_out_of_range),
        cmocka_unit_test(test_rotations),
        cmocka_unit_test(test_rotations_repeat),
        cmocka_unit_test(test_hash_is_exact_and_total),
        cmocka_unit_test(test_hash_uses_all_rotations),
        cmocka_unit_test(test_hash_has_no_rows_or_columns),
        cmocka_unit_test(test_frames_share_the_circle),
        cmocka_unit_test(test_level_around_powers_of_two),
        cmocka_unit_test(test_level_of_anything),
        cmocka_unit_test(test_chains_need_no_clamping),
        cmocka_unit_test(test_sources_iterate_the_copy_rule),
        cmocka_unit_test(test_sources_of_the_largest_buffer),
    };
    return cmocka_run_group_tests_name("taps", tests, NULL, NULL);
}
