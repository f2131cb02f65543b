/* Camera: linear depth, position, footprint and widened projections, against long double arithmetic.

   The oracle takes the float matrix as it is: what rounding the matrix itself does to a view is the engine's
   business. */

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

#define PI_L 3.14159265358979323846264338327950288L
#define U 5.9604644775390625e-8L /* 2^-24: relative error of one float operation */

static double random_in(uint64_t* state, double low, double high) {
    return low + (high - low) * ((double)(random_long(state) >> 11) / 9007199254740992.0);
}

/* >> projections of every kind */

typedef struct lens {
    bool orthographic, reversed, infinite;
    dgb_clip clip;
    double near, far;        /* m */
    double slope, aspect;    /* half height at distance 1, or half height (m) if orthographic; width / height */
    double shift_x, shift_y; /* off-centre, in half widths and heights */
    int width, height, guard;
    float jitter[2];
} lens;

static const char* lens_name(const lens* e) {
    static char name[200];
    snprintf(name, sizeof name, "%s %s %s, clip %s, near %g, far %g, slope %g, aspect %g, shift %g %g, %dx%d+%d",
             e->orthographic ? "orthographic" : "perspective", e->reversed ? "reversed" : "standard",
             e->infinite ? "infinite" : "finite", e->clip == DGB_CLIP_ZERO_TO_ONE ? "[0,1]" : "[-1,1]", e->near, e->far,
             e->slope, e->aspect, e->shift_x, e->shift_y, e->width, e->height, e->guard);
    return name;
}

/* Rows 2 and 3 from what ndc z must be at the two planes. */
static void fill_depth_rows(const lens* e, float p[16]) {
    const double low = e->clip == DGB_CLIP_ZERO_TO_ONE ? 0.0 : -1.0;
    const double at_near = e->reversed ? 1.0 : low, at_far = e->reversed ? low : 1.0;
    if (e->orthographic) {
        p[10] = (float)((at_near - at_far) / (e->far - e->near));
        p[14] = (float)(at_near + (at_near - at_far) * e->near / (e->far - e->near));
        p[15] = 1.0f;
    } else if (e->infinite) {
        p[10] = (float)-at_far;
        p[14] = (float)((at_near - at_far) * e->near);
        p[11] = -1.0f;
    } else {
        p[10] = (float)-((at_far * e->far - at_near * e->near) / (e->far - e->near));
        p[14] = (float)((at_near - at_far) * e->near * e->far / (e->far - e->near));
        p[11] = -1.0f;
    }
}

static void fill_projection(const lens* e, float p[16]) {
    memset(p, 0, 16 * sizeof(float));
    p[0] = (float)(1.0 / (e->slope * e->aspect));
    p[5] = (float)(1.0 / e->slope);
    p[e->orthographic ? 12 : 8] = (float)e->shift_x;
    p[e->orthographic ? 13 : 9] = (float)e->shift_y;
    fill_depth_rows(e, p);
}

static const double slopes[] = {8.7266e-4 /* 0.1 degrees */, 0.0087, 0.2, 0.5774, 1.0, 5.671, 114.59 /* 179 degrees */};
static const double aspects[] = {1e-3, 0.5, 1.0, 16.0 / 9.0, 1e3};

static const lens base = {false, false, false,       DGB_CLIP_NEGATIVE_ONE_TO_ONE, 0.1, 100.0, 1.0, 1.0, 0.0, 0.0, 640,
                          360,   0,     {0.0f, 0.0f}};

/* The n-th of all combinations; false after the last. */
static bool nth_lens(int n, lens* e) {
    static const double planes[][2] = {{0.1, 100.0}, {0.01, 1e5}, {1.0, 2.0}, {50.0, 1e9}};
    static const double shifts[][2] = {{0.0, 0.0}, {0.31, -0.17}, {-2.5, 4.0}};
    static const int sizes[][3] = {{1280, 720, 64}, {1, 1, 0}, {16000, 9, 192}, {333, 777, 0}};
    *e = base;
    e->orthographic = n & 1, e->reversed = n >> 1 & 1, e->infinite = n >> 2 & 1, e->clip = (dgb_clip)(n >> 3 & 1);
    n >>= 4;
    e->slope = slopes[n % 7], n /= 7;
    e->aspect = aspects[n % 5], n /= 5;
    e->near = planes[n % 4][0], e->far = planes[n % 4][1];
    e->width = sizes[n % 4][0], e->height = sizes[n % 4][1], e->guard = sizes[n % 4][2], n /= 4;
    e->shift_x = shifts[n % 3][0], e->shift_y = shifts[n % 3][1];
    e->jitter[0] = n % 3 ? 0.37f : 0.0f, e->jitter[1] = n % 3 ? -0.45f : 0.0f;
    return n < 3;
}

static bool exists(const lens* e) { return !(e->orthographic && e->infinite); }

/* The lens as the library sees it: widened, jittered, made into a camera. */
static void make_camera(const lens* e, float p[16], dgb_camera* camera) {
    float image[16];
    dgb_result result;
    fill_projection(e, image);
    dgb_widen_projection(image, e->width, e->height, e->guard, e->jitter, p);
    result = dgb_camera_from_matrix(p, e->width + 2 * e->guard, e->height + 2 * e->guard, e->clip, e->reversed, camera);
    if (result != DGB_OK) fail_msg("refused: %s", lens_name(e));
}

/* >> oracle */

static long double clear_depth(const lens* e) { return e->reversed ? 0.0L : 1.0L; }

static long double exact_depth(const lens* e, const float p[16], long double z) {
    const long double ndc = ((long double)p[10] * z + p[14]) / ((long double)p[11] * z + p[15]);
    return e->clip == DGB_CLIP_ZERO_TO_ONE ? ndc : 0.5L * ndc + 0.5L;
}

static long double exact_z(const lens* e, const float p[16], long double depth) {
    const long double ndc = e->clip == DGB_CLIP_ZERO_TO_ONE ? depth : 2.0L * depth - 1.0L;
    return ((long double)p[14] - ndc * p[15]) / (ndc * p[11] - (long double)p[10]);
}

/* What float arithmetic may add. Perspective: rounding of depth - clear (half a float step of a number >= 1/2
   where the subtraction is not exact), of two coefficients and four operations, none of which cancels.
   Orthographic: the same, but relative to the two terms of the numerator, which may cancel. */
static long double linear_z_bound(const lens* e, const float p[16], long double depth, long double z) {
    const long double a = e->clip == DGB_CLIP_ZERO_TO_ONE ? 1.0L : 2.0L;
    const long double c = a * clear_depth(e) - (e->clip == DGB_CLIP_ZERO_TO_ONE ? 0.0L : 1.0L);
    if (!e->orthographic) return 10.0L * U * fabsl(z);
    return 6.0L * U * (fabsl(p[14] - c) + fabsl(a * (depth - clear_depth(e)))) / fabsl((long double)p[10]);
}

/* >> linear depth */

static void fail_z(const lens* e, float depth, float z, long double expected, long double bound) {
    fail_msg("%s: depth %.9g gives z %.9g, not %.9Lg within %.3Lg", lens_name(e), (double)depth, (double)z, expected,
             bound);
}

/* Both ways to be right: the inverse of that very depth, and the z that went in, give or take one step of the
   depth. */
static void check_linear_z(const lens* e, const float p[16], const dgb_camera* camera, long double z) {
    const float depth = (float)exact_depth(e, p, z);
    const float back = dgb_linear_z(depth, camera);
    long double exact, bound, step;
    float next;
    if (depth < 0.0f || depth > 1.0f) return; /* the float matrix has its planes elsewhere, by a rounding */
    if (depth == (float)clear_depth(e)) {
        if (back != 0.0f) fail_z(e, depth, back, 0.0L, 0.0L);
        return;
    }
    exact = exact_z(e, p, depth);
    bound = linear_z_bound(e, p, depth, exact);
    if (!is_finite(back) || fabsl(back - exact) > bound) fail_z(e, depth, back, exact, bound);
    next = from_bits(bits_of(depth) + (e->reversed ? -1u : 1u));
    if (next == (float)clear_depth(e) || depth < 1e-30f) return; /* the step may lead to infinity */
    step = fabsl(exact_z(e, p, next) - exact);
    if (fabsl(back - z) > step + bound) fail_z(e, depth, back, z, step + bound);
}

static void test_linear_z(void** state) {
    uint64_t seed = 11;
    lens e;
    int n, i;
    (void)state;
    for (n = 0; nth_lens(n, &e); ++n) {
        dgb_camera camera;
        float p[16];
        if (!exists(&e)) continue;
        make_camera(&e, p, &camera);
        for (i = 0; i < 40; ++i) {
            const double far = e.infinite ? e.near * 1e6 : e.far;
            check_linear_z(&e, p, &camera, -(long double)(e.near * pow(far / e.near, random_in(&seed, 0.001, 0.999))));
        }
    }
}

/* A parallel projection has no eye: its near plane may lie behind. */
static void test_linear_z_behind_a_parallel_eye(void** state) {
    lens e = base;
    float p[16];
    dgb_camera camera;
    (void)state;
    e.orthographic = true;
    e.near = -5.0, e.far = 10.0;
    make_camera(&e, p, &camera);
    assert_true(fabsf(dgb_linear_z(0.2f, &camera) - 2.0f) < 1e-5f); /* a fifth of the way from 5 to -10 */
}

static void test_linear_z_of_the_far_plane(void** state) {
    lens e;
    int n;
    (void)state;
    for (n = 0; nth_lens(n, &e); ++n) {
        dgb_camera camera;
        float p[16], z;
        if (!exists(&e)) continue;
        make_camera(&e, p, &camera);
        z = dgb_linear_z(e.reversed ? 0.0f : 1.0f, &camera);
        if (z != 0.0f) fail_msg("%s: the empty depth gives %g", lens_name(&e), (double)z);
        z = dgb_linear_z(from_bits(0x7fc00000u), &camera);
        if (!is_finite(z) || z != 0.0f) fail_msg("%s: NaN gives %g", lens_name(&e), (double)z);
        z = dgb_linear_z(from_bits(0x7f800000u), &camera);
        if (!is_finite(z) || (!e.orthographic && z > 0.0f)) fail_msg("%s: infinity: %g", lens_name(&e), (double)z);
        z = dgb_linear_z(from_bits(0xff800000u), &camera);
        if (!is_finite(z) || (!e.orthographic && z > 0.0f)) fail_msg("%s: -infinity: %g", lens_name(&e), (double)z);
    }
}

/* The near plane is no special place, and one step before the far plane there is still a surface. */
static void test_linear_z_at_the_ends(void** state) {
    lens e = base;
    int n;
    (void)state;
    for (n = 0; n < 8; ++n) {
        dgb_camera camera;
        float p[16], near_z, far_z;
        e.orthographic = n & 1, e.reversed = n >> 1 & 1, e.clip = (dgb_clip)(n >> 2 & 1);
        make_camera(&e, p, &camera);
        near_z = dgb_linear_z(e.reversed ? 1.0f : 0.0f, &camera);
        far_z = dgb_linear_z(e.reversed ? 1e-7f : from_bits(bits_of(1.0f) - 1), &camera);
        if (fabsf(near_z + 0.1f) > 1e-5f) fail_msg("%s: near plane at %.9g", lens_name(&e), (double)near_z);
        if (fabsf(far_z + 100.0f) > 0.02f) fail_msg("%s: far plane at %.9g", lens_name(&e), (double)far_z);
    }
}

/* What lies beyond 1e15 m is sky, not a number that squares to infinity. */
static void test_linear_z_beyond_all_distance(void** state) {
    lens e = base;
    dgb_camera camera;
    float p[16];
    (void)state;
    e.reversed = e.infinite = true;
    e.clip = DGB_CLIP_ZERO_TO_ONE;
    e.near = 1.0;
    make_camera(&e, p, &camera);
    assert_true(dgb_linear_z(1e-14f, &camera) < -0.9e14f);
    assert_true(dgb_linear_z(0.9e-15f, &camera) == 0.0f);
    assert_true(dgb_linear_z(1e-37f, &camera) == 0.0f);
    assert_true(dgb_linear_z(-1e-3f, &camera) == 0.0f); /* behind the eye */
}

static void check_monotone(const lens* e, const dgb_camera* camera, float start) {
    const float sign = e->reversed ? -1.0f : 1.0f; /* of d depth / d distance */
    float last = 0.0f;
    int i;
    for (i = 0; i < 100; ++i) {
        const float depth = from_bits(bits_of(start) + (uint32_t)i);
        const float z = dgb_linear_z(depth, camera);
        if (depth >= 1.0f) return;
        if (i && (z - last) * sign > 0.0f)
            fail_msg("%s: z grows from %.9g to %.9g at depth %.9g", lens_name(e), (double)last, (double)z,
                     (double)depth);
        last = z;
    }
}

static void test_linear_z_is_monotone(void** state) {
    uint64_t seed = 12;
    lens e;
    int n, i;
    (void)state;
    for (n = 0; nth_lens(n, &e); n += 3) {
        dgb_camera camera;
        float p[16];
        if (!exists(&e)) continue;
        make_camera(&e, p, &camera);
        for (i = 0; i < 4; ++i) check_monotone(&e, &camera, (float)random_in(&seed, 1e-6, 1.0));
    }
}

/* >> depth codes */

#ifdef __FAST_MATH__
#define CODE_SLACK 1 /* division by a reciprocal may be off by one of the 24-bit codes */
#else
#define CODE_SLACK 0
#endif

/* What a fixed-point buffer returns is what comes out again, so equal codes are equal numbers. */
static void check_code_is_fixed(long code, long codes) {
    const float stored = (float)((double)code / (double)codes), again = dgb_depth_code(stored, (float)codes);
    if (CODE_SLACK == 0 && bits_of(again) != bits_of(stored))
        fail_msg("code %ld of %ld, %.9g, became %.9g", code, codes, (double)stored, (double)again);
    if (labs(lround((double)again * (double)codes) - code) > CODE_SLACK)
        fail_msg("code %ld of %ld is another", code, codes);
}

static void test_depth_codes_are_fixed(void** state) {
    long code;
    (void)state;
    for (code = 0; code <= 65535; ++code) check_code_is_fixed(code, 65535);
    for (code = 0; code <= 16777215; code += 11) check_code_is_fixed(code, 16777215);
    for (code = 16777215 - 1000; code <= 16777215; ++code) check_code_is_fixed(code, 16777215);
}

static void test_depth_code_rounds(void** state) {
    static const long codes[] = {65535, 16777215};
    uint64_t seed = 17;
    int i, k;
    (void)state;
    for (k = 0; k < 2; ++k)
        for (i = 0; i < 100000; ++i) {
            const float depth = (float)random_in(&seed, 0.0, 1.0), code = dgb_depth_code(depth, (float)codes[k]);
            const long double exact = (long double)code * codes[k], wanted = (long double)depth * codes[k];
            /* a code, and no farther than half a one; 2 U: the rounding of the product and of the quotient */
            if (!is_finite(code) || fabsl(exact - roundl(exact)) > 1.01L * U * codes[k] ||
                fabsl(exact - wanted) > 0.5L + 2.0L * U * codes[k] + CODE_SLACK)
                fail_msg("depth %.9g in %ld codes is %.9g", (double)depth, codes[k], (double)code);
        }
}

static void test_depth_code_leaves_the_rest(void** state) {
    static const uint32_t outside[] = {
        0xb5000000u /* just below 0 */, 0x3f800001u, 0xbf800000u, 0x40000000u, 0x7f800000u, 0xff800000u};
    static const float no_codes[] = {0.0f, -1.0f};
    size_t i, k;
    (void)state;
    for (i = 0; i < sizeof outside / sizeof outside[0]; ++i)
        if (outside[i] != 0x3f800001u && bits_of(dgb_depth_code(from_bits(outside[i]), 65535.0f)) != outside[i])
            fail_msg("%08x changed", outside[i]);
    for (k = 0; k < 2; ++k)
        for (i = 0; i < sizeof outside / sizeof outside[0]; ++i)
            if (bits_of(dgb_depth_code(from_bits(outside[i]), no_codes[k])) != outside[i])
                fail_msg("%08x changed", outside[i]);
    assert_false(is_finite(dgb_depth_code(from_bits(0x7fc00000u), 65535.0f)));
    assert_true(dgb_depth_code(0.3f, 0.0f) == 0.3f);
    assert_true(dgb_depth_code(0.0f, 65535.0f) == 0.0f);
    assert_true(dgb_depth_code(1.0f, 65535.0f) == 1.0f);
    assert_true(dgb_depth_code(1.0f, 16777215.0f) == 1.0f);
}

/* >> how far away a separation can be told */

static const struct {
    dgb_format format;
    long codes; /* 0: floats */
} depth_formats[] = {{DGB_FORMAT_D16, 65535}, {DGB_FORMAT_D24, 16777215}, {DGB_FORMAT_D32F, 0}, {DGB_FORMAT_NONE, 0}};

static long double float_step(long double x) { return (long double)from_bits(bits_of((float)x) + 1u) - (float)x; }

/* Metres from one depth, or one float z, to the next. */
static long double exact_step(const lens* e, const float p[16], long double distance, long codes) {
    const long double w = (long double)p[15] - p[11] * distance, depth = exact_depth(e, p, -distance);
    const long double slope = fabsl(((long double)p[10] * p[15] - (long double)p[14] * p[11]) / (w * w)) /
                              (e->clip == DGB_CLIP_ZERO_TO_ONE ? 1.0L : 2.0L);
    return fmaxl((codes ? 1.0L / codes : float_step(depth)) / slope, float_step(distance));
}

/* What a depth buffer holds of it. */
static long double stored_depth(const lens* e, const float p[16], long double distance, long codes) {
    const long double depth = exact_depth(e, p, -distance);
    return codes ? roundl(depth * codes) : (long double)(float)depth;
}

static void check_limit(const lens* e, const float p[16], const dgb_camera* camera, int k, float separation,
                        uint64_t* seed) {
    const long codes = depth_formats[k].codes;
    const double limit = (double)dgb_separation_limit(separation, depth_formats[k].format, camera);
    const double far = e->infinite ? 1e15 : e->far, end = limit < far ? limit : far;
    int i;
    for (i = 0; i < 8;
         ++i) { /* within: two surfaces that far apart have two depths; 1 %: neither float nor code ties */
        const double distance = random_in(seed, e->near, end - 1.01 * (double)separation);
        if (!(distance > e->near) || distance + 1.01 * (double)separation > end) continue;
        if (stored_depth(e, p, distance, codes) ==
            stored_depth(e, p, distance + 1.01L * (long double)separation, codes))
            fail_msg("%s: %g m behind %.9g, within %.9g, are one depth", lens_name(e), (double)separation, distance,
                     limit);
    }
    /* and the step past it is the first that is longer; 1e-3: to 0.1 % */
    if (limit > e->near && limit * 1.001 < far &&
        exact_step(e, p, limit * 1.0009765625L, codes) < (long double)separation * (1.0L - 1e-3L))
        fail_msg("%s: %g m can be told beyond %.9g m, too", lens_name(e), (double)separation, limit);
}

static void test_separation_limit(void** state) {
    static const float separations[] = {1e-3f, 0.05f, 0.5f, 20.0f};
    uint64_t seed = 19;
    lens e;
    int n, k;
    size_t i;
    (void)state;
    for (n = 0; nth_lens(n, &e); ++n) {
        dgb_camera camera;
        float p[16];
        if (!exists(&e) || n % 5) continue;
        make_camera(&e, p, &camera);
        for (k = 0; k < 4; ++k)
            for (i = 0; i < 4; ++i) check_limit(&e, p, &camera, k, separations[i], &seed);
    }
}

/* Distances known by hand: near 0.1 m, no far plane. A code of a depth 1 - 0.1/z is z^2 / (0.1 codes) long. */
static void test_separation_limit_by_hand(void** state) {
    const float nan = from_bits(0x7fc00000u);
    dgb_camera camera;
    float p[16];
    lens e = base;
    (void)state;
    e.infinite = true;
    e.clip = DGB_CLIP_ZERO_TO_ONE;
    make_camera(&e, p, &camera);
    assert_true(fabs((double)dgb_separation_limit(0.5f, DGB_FORMAT_D16, &camera) / sqrt(0.05 * 65535.0) - 1.0) < 1e-3);
    assert_true(fabs((double)dgb_separation_limit(0.5f, DGB_FORMAT_D24, &camera) / sqrt(0.05 * 16777215.0) - 1.0) <
                1e-3);
    e.reversed = true;
    make_camera(&e, p, &camera);
    /* about 2^-23 of the distance: a float of either */
    assert_true(dgb_separation_limit(0.5f, DGB_FORMAT_D32F, &camera) > 0.25f * 8388608.0f);
    assert_true(dgb_separation_limit(0.5f, DGB_FORMAT_D32F, &camera) <= 8388608.0f);
    assert_true(dgb_separation_limit(INFINITY, DGB_FORMAT_D16, &camera) == DGB_MAX_DISTANCE);
    assert_true(dgb_separation_limit(0.0f, DGB_FORMAT_D32F, &camera) == 0.0f);
    assert_true(dgb_separation_limit(-1.0f, DGB_FORMAT_D32F, &camera) == 0.0f);
    assert_true(dgb_separation_limit(nan, DGB_FORMAT_D32F, &camera) == 0.0f);

    /* the 65535 steps of an orthographic depth are as long as each other: what is longer is told everywhere */
    e = base;
    e.orthographic = true;
    make_camera(&e, p, &camera);
    assert_true(dgb_separation_limit((float)((e.far - e.near) / 65534.5), DGB_FORMAT_D16, &camera) >= (float)e.far);
    assert_true(dgb_separation_limit((float)((e.far - e.near) / 65535.5), DGB_FORMAT_D16, &camera) == 0.0f);
}

/* >> position */

/* The camera-space coordinate that lands on `pixel` at z, and the sizes of the terms it is the sum of. */
static long double unproject(const float p[16], int axis, int size, long double pixel, long double z,
                             long double* terms) {
    const long double ndc = 2.0L * pixel / size - 1.0L, w = (long double)p[11] * z + p[15], scale = p[axis * 5];
    *terms = ((2.0L * fabsl(pixel) / size + 1.0L) * fabsl(w) + fabsl((long double)p[8 + axis] * z) +
              fabsl((long double)p[12 + axis])) /
             fabsl(scale);
    return (ndc * w - (long double)p[8 + axis] * z - p[12 + axis]) / scale;
}

static void check_position(const lens* e, const float p[16], const dgb_camera* camera, const long double ndc[2],
                           long double z) {
    const int size[2] = {e->width + 2 * e->guard, e->height + 2 * e->guard};
    const float z_float = (float)z;
    float pixel[2], point[3];
    int axis;
    for (axis = 0; axis < 2; ++axis) pixel[axis] = (float)((0.5L * ndc[axis] + 0.5L) * size[axis]);
    dgb_position(pixel[0], pixel[1], z_float, camera, point);
    if (bits_of(point[2]) != bits_of(z_float)) fail_msg("%s: z changed", lens_name(e));
    for (axis = 0; axis < 2; ++axis) {
        long double terms, ignored;
        const long double same = unproject(p, axis, size[axis], pixel[axis], z_float, &terms);
        const long double true_point =
            unproject(p, axis, size[axis], (0.5L * ndc[axis] + 0.5L) * size[axis], z, &ignored);
        /* rounding of four coefficients and six operations */
        const long double bound = 6.0L * U * terms;
        if (!is_finite(point[axis]) || fabsl(point[axis] - same) > bound)
            fail_msg("%s: axis %d at pixel %.9g, z %.9g is %.9g, not %.9Lg within %.3Lg", lens_name(e), axis,
                     (double)pixel[axis], (double)z_float, (double)point[axis], same, bound);
        /* and of the pixel and of z on the way in: each moves the point by at most U of the same terms */
        if (fabsl(point[axis] - true_point) > bound + 4.0L * U * terms)
            fail_msg("%s: axis %d at z %.9g went round to %.9g from %.9Lg", lens_name(e), axis, (double)z_float,
                     (double)point[axis], true_point);
    }
}

static void test_position(void** state) {
    uint64_t seed = 13;
    lens e;
    int n, i;
    (void)state;
    for (n = 0; nth_lens(n, &e); ++n) {
        dgb_camera camera;
        float p[16];
        if (!exists(&e)) continue;
        make_camera(&e, p, &camera);
        for (i = 0; i < 30; ++i) {
            const long double ndc[2] = {random_in(&seed, -1.0, 1.0), random_in(&seed, -1.0, 1.0)};
            const double far = e.infinite ? e.near * 1e6 : e.far;
            check_position(&e, p, &camera, ndc, -(long double)(e.near * pow(far / e.near, random_in(&seed, 0.0, 1.0))));
        }
    }
}

/* Point -> pixel and depth -> point: what the shaders do, end to end. */
static void test_project_and_reconstruct(void** state) {
    uint64_t seed = 14;
    lens e;
    int n, i;
    (void)state;
    for (n = 0; nth_lens(n, &e); ++n) {
        dgb_camera camera;
        float p[16];
        if (!exists(&e)) continue;
        make_camera(&e, p, &camera);
        for (i = 0; i < 10; ++i) {
            const int width = e.width + 2 * e.guard;
            const double far = e.infinite ? e.near * 1e3 : e.far;
            const long double z = -(long double)(e.near * pow(far / e.near, random_in(&seed, 0.01, 0.5)));
            const long double pixel = random_in(&seed, 0.0, width);
            const float depth = (float)exact_depth(&e, p, z);
            const float back = dgb_linear_z(depth, &camera);
            float point[3];
            long double terms, x;
            if (back == 0.0f) continue; /* the depth rounded to the far plane */
            x = unproject(p, 0, width, pixel, z, &terms);
            dgb_position((float)pixel, 0.5f, back, &camera, point);
            if (fabsl(point[0] - x) > terms * (10.0L * U + 1.01L * fabsl((back - z) / z)))
                fail_msg("%s: x %.9Lg at z %.9Lg came back as %.9g at %.9g", lens_name(&e), x, z, (double)point[0],
                         (double)back);
        }
    }
}

/* >> footprint */

static void test_pixels_per_metre(void** state) {
    uint64_t seed = 15;
    lens e;
    int n, i;
    (void)state;
    for (n = 0; nth_lens(n, &e); ++n) {
        dgb_camera camera;
        float p[16];
        if (!exists(&e)) continue;
        make_camera(&e, p, &camera);
        for (i = 0; i < 5; ++i) {
            const float z = (float)-random_in(&seed, e.near, e.far), pixels = dgb_pixels_per_metre(z, &camera);
            const long double w = (long double)p[11] * z + p[15];
            const long double expected = 0.5L * (e.height + 2 * e.guard) * p[5] / w; /* pixels between y and y + 1 */
            if (!is_finite(pixels) || fabsl(pixels - expected) > 4.0L * U * expected)
                fail_msg("%s: %.9g pixels a metre at %.9g, not %.9Lg", lens_name(&e), (double)pixels, (double)z,
                         expected);
        }
    }
}

static void test_pixels_per_metre_not_in_front(void** state) {
    static const uint32_t behind[] = {0u, 0x80000000u, 0x3f800000u, 0x7f800000u, 0xff800000u, 0x7fc00000u};
    dgb_camera camera;
    float p[16];
    lens e = base;
    size_t i;
    (void)state;
    make_camera(&e, p, &camera);
    for (i = 0; i < sizeof behind / sizeof behind[0]; ++i) {
        const float pixels = dgb_pixels_per_metre(from_bits(behind[i]), &camera);
        if (bits_of(pixels) != 0u) fail_msg("z %08x: %g pixels a metre", behind[i], (double)pixels);
    }
    e.orthographic = true;
    make_camera(&e, p, &camera);
    assert_true(fabsf(dgb_pixels_per_metre(3.0f, &camera) - 180.0f) < 1e-4f); /* an orthographic eye is nowhere */
}

/* >> widening */

static void test_widening_against_the_formula(void** state) {
    lens e;
    int n, i;
    (void)state;
    for (n = 0; nth_lens(n, &e); ++n) {
        float p[16], widened[16];
        if (!exists(&e)) continue;
        fill_projection(&e, p);
        dgb_widen_projection(p, e.width, e.height, e.guard, e.jitter, widened);
        for (i = 0; i < 16; ++i) {
            const int row = i % 4, size = row == 0 ? e.width : e.height;
            const long double total = size + 2.0L * e.guard;
            const long double scaled = (long double)p[i] * size / total;
            const long double jitter = row < 2 ? 2.0L * e.jitter[row] / total * p[i - row + 3] : 0.0L;
            const long double exact = row < 2 ? scaled + jitter : p[i];
            if (fabsl(widened[i] - exact) > 1.01L * U * fabsl(exact) + 1e-15L * (fabsl(scaled) + fabsl(jitter)))
                fail_msg("%s: element %d is %.9g, not %.9Lg", lens_name(&e), i, (double)widened[i], exact);
            if (row > 1 && bits_of(widened[i]) != bits_of(p[i])) fail_msg("%s: element %d", lens_name(&e), i);
        }
    }
}

static long double pixel_of(const float p[16], int axis, int size, long double x, long double z) {
    const long double clip = p[axis * 5] * x + (long double)p[8 + axis] * z + p[12 + axis];
    return (0.5L * clip / ((long double)p[11] * z + p[15]) + 0.5L) * size;
}

/* What widening is for: a pixel of the image lies `guard` pixels farther in, plus the jitter. */
static void test_widening_moves_pixels(void** state) {
    uint64_t seed = 16;
    lens e;
    int n, axis;
    (void)state;
    for (n = 0; nth_lens(n, &e); ++n) {
        float p[16], widened[16];
        if (!exists(&e)) continue;
        fill_projection(&e, p);
        dgb_widen_projection(p, e.width, e.height, e.guard, e.jitter, widened);
        for (axis = 0; axis < 2; ++axis) {
            const int size = axis ? e.height : e.width;
            const long double z = -random_in(&seed, e.near, e.far), pixel = random_in(&seed, 0.0, size);
            const long double w = (long double)p[11] * z + p[15];
            const long double x =
                ((2.0L * pixel / size - 1.0L) * w - (long double)p[8 + axis] * z - p[12 + axis]) / p[axis * 5];
            const long double wide = pixel_of(widened, axis, size + 2 * e.guard, x, z);
            const long double moved = pixel + e.guard + e.jitter[axis];
            if (fabsl(wide - moved) > 40.0L * U * (size + 2 * e.guard))
                fail_msg("%s: pixel %.6Lf moved to %.6Lf, not %.6Lf", lens_name(&e), pixel, wide, moved);
        }
    }
}

static void test_widening_by_nothing_changes_nothing(void** state) {
    static const float none[2] = {0.0f, 0.0f};
    lens e = base;
    float p[16], widened[16];
    (void)state;
    e.shift_x = 0.3;
    fill_projection(&e, p);
    dgb_widen_projection(p, 640, 360, 0, none, widened);
    assert_memory_equal(p, widened, sizeof p);
    dgb_widen_projection(p, 640, 360, 64, none, widened);
    dgb_widen_projection(p, 640, 360, 64, none, p); /* in place */
    assert_memory_equal(p, widened, sizeof p);
}

/* The jitter is in pixels, be there two of them or one. */
static void test_widening_of_two_pixels(void** state) {
    const float half[2] = {0.5f, 0.5f}, quarter[2] = {0.25f, 0.25f};
    float p[16], of_two[16], of_one[16];
    (void)state;
    fill_projection(&base, p);
    dgb_widen_projection(p, 2, 2, 0, half, of_two);
    dgb_widen_projection(p, 1, 1, 0, quarter, of_one);
    assert_memory_equal(of_two, of_one, sizeof of_two);
}

/* >> refusals */

static void check_refused(const float p[16], int width, int height, const lens* e, const char* why) {
    dgb_camera camera, before;
    memset(&camera, 0x5a, sizeof camera);
    memcpy(&before, &camera, sizeof camera);
    if (dgb_camera_from_matrix(p, width, height, e->clip, e->reversed, &camera) != DGB_INVALID)
        fail_msg("%s: accepted with %s", lens_name(e), why);
    if (!same_bits(&camera, &before, sizeof camera)) fail_msg("%s: %s changed the camera", lens_name(e), why);
}

static void check_refused_element(const lens* e, int element, float value, const char* why) {
    float p[16];
    fill_projection(e, p);
    p[element] = value;
    check_refused(p, e->width, e->height, e, why);
}

static void check_refusals(const lens* e) {
    static const uint32_t not_finite[] = {0x7fc00000u, 0x7f800000u, 0xff800000u, 0xffc00001u};
    static const int skew[] = {1, 4}, oblique[] = {2, 6}, tilted[] = {3, 7};
    const float sign = e->reversed ? 1.0f : -1.0f;
    size_t i;
    int element;
    for (element = 0; element < 16; ++element)
        for (i = 0; i < 4; ++i) check_refused_element(e, element, from_bits(not_finite[i]), "a value not finite");
    for (i = 0; i < 2; ++i) {
        check_refused_element(e, skew[i], 0.01f, "skew");
        check_refused_element(e, oblique[i], -0.01f, "an oblique near plane");
        check_refused_element(e, tilted[i], 0.01f, "a tilted image plane");
    }
    check_refused_element(e, 0, 0.0f, "no width");
    check_refused_element(e, 5, 0.0f, "no height");
    check_refused_element(e, e->orthographic ? 10 : 14, 0.0f, "no depth");
    check_refused_element(e, e->orthographic ? 10 : 14, -sign, "depth that runs the other way");
    check_refused_element(e, 15, e->orthographic ? 0.0f : 1.0f, "a singular or mixed row 3");
    check_refused_element(e, 15, -1.0f, "negative w");
    check_refused_element(e, 11, 1.0f, "a look along +Z");
    check_refused_element(e, 11, e->orthographic ? -1.0f : 0.0f, "a mixed or singular row 3");
    check_refused_element(e, e->orthographic ? 10 : 11, e->orthographic ? sign * 1e-42f : -1e-42f,
                          "what distances are divided by, so small that they overflow");
}

static void test_refusals(void** state) {
    int n;
    (void)state;
    for (n = 0; n < 16; ++n) {
        lens e = base, other;
        float p[17];
        dgb_camera camera;
        e.orthographic = n & 1, e.reversed = n >> 1 & 1, e.infinite = n >> 2 & 1, e.clip = (dgb_clip)(n >> 3 & 1);
        if (!exists(&e)) continue;
        check_refusals(&e);
        fill_projection(&e, p);
        p[16] = from_bits(0x7fc00000u); /* sixteen are read */
        assert_int_equal(dgb_camera_from_matrix(p, 640, 360, e.clip, e.reversed, &camera), DGB_OK);
        other = e;
        other.reversed = !e.reversed;
        check_refused(p, 640, 360, &other, "the direction of the other");
        check_refused(p, 0, 360, &e, "width 0");
        check_refused(p, 640, 0, &e, "height 0");
        check_refused(p, -640, 360, &e, "negative width");
        check_refused(p, 640, -360, &e, "negative height");
    }
}

/* Finite matrices whose inverse overflows are singular for all that floats can say. */
static void test_refuses_what_cannot_be_inverted(void** state) {
    lens e = base;
    (void)state;
    check_refused_element(&e, 0, 1e-40f, "a scale whose inverse is infinite");
    check_refused_element(&e, 5, 1e-42f, "a scale whose inverse is infinite");
}

/* A projection may carry any positive factor: clip space does not care, so neither may the camera. */
static void test_scaled_matrices(void** state) {
    static const float factors[] = {0.25f, 3.0f, 1000.0f};
    size_t i;
    int n, k;
    (void)state;
    for (n = 0; n < 8; ++n)
        for (i = 0; i < sizeof factors / sizeof factors[0]; ++i) {
            dgb_camera camera, scaled;
            lens e = base;
            float p[16], a[3], b[3], z;
            e.orthographic = n & 1, e.reversed = n >> 1 & 1, e.clip = (dgb_clip)(n >> 2 & 1);
            e.shift_x = 0.2;
            make_camera(&e, p, &camera);
            for (k = 0; k < 16; ++k) p[k] *= factors[i];
            assert_int_equal(dgb_camera_from_matrix(p, 640, 360, e.clip, e.reversed, &scaled), DGB_OK);
            z = dgb_linear_z(0.5f, &camera);
            dgb_position(100.0f, 200.0f, z, &camera, a);
            dgb_position(100.0f, 200.0f, dgb_linear_z(0.5f, &scaled), &scaled, b);
            if (fabsf(a[0] - b[0]) > 1e-4f * fabsf(a[0]) || fabsf(a[2] - b[2]) > 1e-5f * fabsf(a[2]))
                fail_msg("%s times %g: x %.9g and %.9g, z %.9g and %.9g", lens_name(&e), (double)factors[i],
                         (double)a[0], (double)b[0], (double)a[2], (double)b[2]);
            if (fabsf(dgb_pixels_per_metre(z, &camera) / dgb_pixels_per_metre(z, &scaled) - 1.0f) > 1e-5f)
                fail_msg("%s times %g: footprint", lens_name(&e), (double)factors[i]);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_linear_z),
        cmocka_unit_test(test_linear_z_behind_a_parallel_eye),
        cmocka_unit_test(test_linear_z_of_the_far_plane),
        cmocka_unit_test(test_linear_z_at_the_ends),
        cmocka_unit_test(test_linear_z_beyond_all_distance),
        cmocka_unit_test(test_linear_z_is_monotone),
        cmocka_unit_test(test_depth_codes_are_fixed),
        cmocka_unit_test(test_depth_code_rounds),
        cmocka_unit_test(test_depth_code_leaves_the_rest),
        cmocka_unit_test(test_separation_limit),
        cmocka_unit_test(test_separation_limit_by_hand),
        cmocka_unit_test(test_position),
        cmocka_unit_test(test_project_and_reconstruct),
        cmocka_unit_test(test_pixels_per_metre),
        cmocka_unit_test(test_pixels_per_metre_not_in_front),
        cmocka_unit_test(test_widening_against_the_formula),
        cmocka_unit_test(test_widening_moves_pixels),
        cmocka_unit_test(test_widening_by_nothing_changes_nothing),
        cmocka_unit_test(test_widening_of_two_pixels),
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_refuses_what_cannot_be_inverted),
        cmocka_unit_test(test_scaled_matrices),
    };
    return cmocka_run_group_tests_name("camera", tests, NULL, NULL);
}
