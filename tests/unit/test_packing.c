/* Packing: Oct16 normals, R11G11B10F and half floats, the clamp before every store. */

#include "deepgbuffer.h"
#include "numbers.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#define PI_L 3.14159265358979323846264338327950288L
#define CODE_Z (127 | 127 << 8)

#ifdef __FAST_MATH__
#define FAST_MATH 1 /* reciprocal square roots, and denormals read as 0 */
#else
#define FAST_MATH 0
#endif

/* >> bits and random numbers */

static bool is_finite_bits(uint32_t u) { return (u & 0x7f800000u) != 0x7f800000u; }

static bool is_nan_bits(uint32_t u) { return (u & 0x7fffffffu) > 0x7f800000u; }

static bool is_denormal_bits(uint32_t u) { return (u & 0x7f800000u) == 0 && (u & 0x7fffffu) != 0; }

static float random_signed(uint64_t* state) { return (float)((double)random_bits(state) / 2147483648.0 - 1.0); }

/* >> Oct16 */

static long double degrees_between(const float a[3], const float b[3]) {
    const long double x = (long double)a[1] * b[2] - (long double)a[2] * b[1];
    const long double y = (long double)a[2] * b[0] - (long double)a[0] * b[2];
    const long double z = (long double)a[0] * b[1] - (long double)a[1] * b[0];
    const long double d = (long double)a[0] * b[0] + (long double)a[1] * b[1] + (long double)a[2] * b[2];
    return atan2l(sqrtl(x * x + y * y + z * z), d) * 180.0L / PI_L;
}

static long double round_trip_degrees(const float n[3]) {
    float decoded[3];
    dgb_oct16_decode(dgb_oct16_encode(n), decoded);
    return degrees_between(n, decoded);
}

/* 0.957 degrees is the supremum in exact arithmetic. */
static long double check_round_trip(const float n[3]) {
    const long double error = round_trip_degrees(n);
    if (error > 0.957L + 1e-5L)
        fail_msg("(%.9g, %.9g, %.9g) is off by %.6Lf degrees", (double)n[0], (double)n[1], (double)n[2], error);
    return error;
}

static void test_oct16_decode_every_code(void** state) {
    const long double bound = FAST_MATH ? 6e-7L : 2.4e-7L;
    int code;
    (void)state;
    for (code = 0; code < 65536; ++code) {
        const int low = code & 255, high = code >> 8;
        const int same = (low == 255 ? 254 : low) | (high == 255 ? 254 : high) << 8;
        float n[3], m[3];
        long double length;
        dgb_oct16_decode((uint16_t)code, n);
        dgb_oct16_decode((uint16_t)same, m);
        length = sqrtl((long double)n[0] * n[0] + (long double)n[1] * n[1] + (long double)n[2] * n[2]);
        if (fabsl(length - 1.0L) > bound) fail_msg("code %04x: length %.10Lf", (unsigned)code, length);
        if (!same_bits(n, m, sizeof n)) fail_msg("code %04x differs from %04x", (unsigned)code, (unsigned)same);
    }
}

/* The map covers its border twice, so codes there may come back as their twins; no other code may. */
static void test_oct16_codes_are_stable(void** state) {
    int code, changed = 0;
    (void)state;
    for (code = 0; code < 65536; ++code) {
        const int x = code & 255, y = code >> 8;
        const bool border = x == 0 || x == 254 || y == 0 || y == 254;
        float n[3], m[3];
        int again;
        if (x == 255 || y == 255) continue;
        dgb_oct16_decode((uint16_t)code, n);
        again = dgb_oct16_encode(n);
        dgb_oct16_decode((uint16_t)again, m);
        if (again != code && !border) fail_msg("code %04x came back as %04x", (unsigned)code, (unsigned)again);
        changed += again != code;
        if (fabsf(n[0] - m[0]) > 1e-6f || fabsf(n[1] - m[1]) > 1e-6f || fabsf(n[2] - m[2]) > 1e-6f)
            fail_msg("code %04x changed its direction to %04x", (unsigned)code, (unsigned)again);
    }
    assert_int_equal(changed, 507); /* of the 1016 border codes: half, less the corners */
}

static void test_oct16_axes_are_exact(void** state) {
    static const float scales[] = {1.0f, 1e-18f, 3e-7f, 0.3f, 7.0f, 1e18f};
    int axis, side, component;
    size_t i;
    (void)state;
    for (axis = 0; axis < 3; ++axis)
        for (side = -1; side <= 1; side += 2)
            for (i = 0; i < sizeof scales / sizeof scales[0]; ++i) {
                float n[3] = {0.0f, 0.0f, 0.0f}, d[3];
                n[axis] = (float)side * scales[i];
                dgb_oct16_decode(dgb_oct16_encode(n), d);
                for (component = 0; component < 3; ++component) {
                    const float expected = component == axis ? (float)side : 0.0f;
                    if (fabsf(d[component] - expected) > (FAST_MATH ? 2e-7f : 0.0f))
                        fail_msg("axis %d, side %d, scale %g: component %d is %.9g", axis, side, (double)scales[i],
                                 component, (double)d[component]);
                }
            }
}

static void test_oct16_edges_and_octants(void** state) {
    int x, y, z;
    (void)state;
    for (x = -1; x <= 1; ++x)
        for (y = -1; y <= 1; ++y)
            for (z = -1; z <= 1; ++z) {
                const float n[3] = {(float)x, (float)y, (float)z};
                if (x || y || z) check_round_trip(n);
            }
}

/* Where the octahedron is stretched most: the middles of its faces, seen from above (1/3) and folded over
   (2/3). */
static long double search_worst_cells(void) {
    long double worst = 0.0L;
    int cell, i, j;
    for (cell = 0; cell < 8; ++cell) {
        const float centre = cell & 4 ? 2.0f / 3.0f : 1.0f / 3.0f;
        for (i = -100; i <= 100; ++i)
            for (j = -100; j <= 100; ++j) {
                const float x = (cell & 1 ? -1.0f : 1.0f) * (centre + (float)i / 6000.0f);
                const float y = (cell & 2 ? -1.0f : 1.0f) * (centre + (float)j / 6000.0f);
                const float z = 1.0f - fabsf(x) - fabsf(y);
                const float n[3] = {z < 0.0f ? copysignf(1.0f - fabsf(y), x) : x,
                                    z < 0.0f ? copysignf(1.0f - fabsf(x), y) : y, z};
                const long double error = check_round_trip(n);
                worst = error > worst ? error : worst;
            }
    }
    return worst;
}

static void test_oct16_error(void** state) {
    uint64_t seed = 1;
    long double sum = 0.0L;
    const int count = 400000;
    int i;
    (void)state;
    assert_true(search_worst_cells() > 0.93L); /* the search looks where the errors are */
    for (i = 0; i < count; ++i) {
        float n[3];
        do {
            n[0] = random_signed(&seed), n[1] = random_signed(&seed), n[2] = random_signed(&seed);
        } while (n[0] * n[0] + n[1] * n[1] + n[2] * n[2] > 1.0f || n[0] * n[0] + n[1] * n[1] + n[2] * n[2] < 1e-4f);
        sum += check_round_trip(n);
    }
    if (fabsl(sum / count - 0.3369L) > 0.002L) fail_msg("mean error %.5Lf degrees", sum / count);
}

/* Independent of the decoder: each byte is the octahedral coordinate times 127, rounded to nearest. */
static void test_oct16_rounds_to_nearest(void** state) {
    uint64_t seed = 2;
    int i, axis;
    (void)state;
    for (i = 0; i < 200000; ++i) {
        const float n[3] = {random_signed(&seed), random_signed(&seed), random_signed(&seed)};
        const long double s = fabsl((long double)n[0]) + fabsl((long double)n[1]) + fabsl((long double)n[2]);
        const long double p[2] = {n[0] / s, n[1] / s};
        const int code = dgb_oct16_encode(n);
        const int q[2] = {(code & 255) - 127, (code >> 8) - 127};
        for (axis = 0; axis < 2; ++axis) {
            const long double folded = (1.0L - fabsl(p[1 - axis])) * (p[axis] < 0.0L ? -1.0L : 1.0L);
            const long double exact = 127.0L * (n[2] < 0.0f ? folded : p[axis]);
            if (fabsl(exact - q[axis]) > 0.5L + 1e-4L)
                fail_msg("(%.9g, %.9g, %.9g): %d for %.6Lf", (double)n[0], (double)n[1], (double)n[2], q[axis], exact);
        }
    }
}

static bool encodable(const float n[3]) {
    long double s = 0.0L;
    int i;
    for (i = 0; i < 3; ++i) {
        if (!is_finite_bits(bits_of(n[i]))) return false;
        s += fabsl((long double)n[i]);
    }
    return s > 1e-30L && s < 1e30L;
}

static void test_oct16_is_total(void** state) {
    static const uint32_t special[] = {0u,
                                       0x80000000u /* -0 */,
                                       0x3f800000u /* 1 */,
                                       0xbf800000u,
                                       0x7f800000u /* infinity */,
                                       0xff800000u,
                                       0x7fc00000u /* NaN */,
                                       0xffc00001u,
                                       0x00000001u /* denormal */,
                                       0x807fffffu,
                                       0x7f7fffffu /* FLT_MAX */,
                                       0xff7fffffu,
                                       0x0b000000u,
                                       0x71000000u};
    const size_t count = sizeof special / sizeof special[0];
    size_t i, j, k;
    uint64_t seed = 3;
    int r;
    (void)state;
    for (i = 0; i < count; ++i)
        for (j = 0; j < count; ++j)
            for (k = 0; k < count; ++k) {
                const float n[3] = {from_bits(special[i]), from_bits(special[j]), from_bits(special[k])};
                const int code = dgb_oct16_encode(n);
                if (encodable(n))
                    check_round_trip(n);
                else if (code != CODE_Z)
                    fail_msg("%08x %08x %08x: %04x", special[i], special[j], special[k], (unsigned)code);
            }
    for (r = 0; r < 200000; ++r) {
        const uint32_t u[3] = {random_bits(&seed), random_bits(&seed), random_bits(&seed)};
        const float n[3] = {from_bits(u[0]), from_bits(u[1]), from_bits(u[2])};
        const int code = dgb_oct16_encode(n);
        if ((code & 255) > 254 || code >> 8 > 254 || (!encodable(n) && code != CODE_Z))
            fail_msg("%08x %08x %08x: %04x", u[0], u[1], u[2], (unsigned)code);
    }
}

static void test_oct16_signed_zeros(void** state) {
    int mask;
    (void)state;
    for (mask = 0; mask < 16; ++mask) {
        const float z0 = mask & 1 ? -0.0f : 0.0f, z1 = mask & 2 ? -0.0f : 0.0f, one = mask & 4 ? -1.0f : 1.0f;
        const float along_z[3] = {z0, z1, one}, in_plane[3] = {one, z0, z1};
        const float expected_z[3] = {0.0f, 0.0f, one}, expected_x[3] = {one, 0.0f, 0.0f};
        float n[3];
        const float* input = mask & 8 ? in_plane : along_z;
        const float* expected = mask & 8 ? expected_x : expected_z;
        dgb_oct16_decode(dgb_oct16_encode(input), n);
        if (degrees_between(n, expected) > 1e-5L)
            fail_msg("zeros %d: (%g, %g, %g)", mask, (double)n[0], (double)n[1], (double)n[2]);
    }
}

/* On the fold both signs mean one direction, but only one of them is the code, on every device: that of +0.
   */
static void test_oct16_folds_zeros_to_the_positive_side(void** state) {
    int mask;
    (void)state;
    for (mask = 0; mask < 4; ++mask) {
        const float zero = mask & 1 ? -0.0f : 0.0f, side = mask & 2 ? -1.0f : 1.0f;
        const float down[3] = {zero, zero, -1.0f}, x0[3] = {zero, side, -1.0f}, y0[3] = {side, zero, -1.0f};
        const int end = side < 0.0f ? 0 : 254, middle = 127 + 64; /* (1/2, 1) */
        assert_int_equal(dgb_oct16_encode(down), 254 | 254 << 8);
        assert_int_equal(dgb_oct16_encode(x0), middle | end << 8);
        assert_int_equal(dgb_oct16_encode(y0), end | middle << 8);
    }
}

static void test_oct16_scale_does_not_matter(void** state) {
    uint64_t seed = 4;
    int i, exponent;
    (void)state;
    for (i = 0; i < 2000; ++i) {
        const float n[3] = {random_signed(&seed), random_signed(&seed), random_signed(&seed)};
        for (exponent = -60; exponent <= 60; exponent += 7) { /* 1e-18 to 1e18 */
            const float m[3] = {ldexpf(n[0], exponent), ldexpf(n[1], exponent), ldexpf(n[2], exponent)};
            if (dgb_oct16_encode(m) != dgb_oct16_encode(n))
                fail_msg("(%.9g, %.9g, %.9g) times 2^%d", (double)n[0], (double)n[1], (double)n[2], exponent);
        }
    }
}

static void test_both_normals_in_one_texel(void** state) {
    const float x[3] = {1.0f, 0.0f, 0.0f}, minus_y[3] = {0.0f, -1.0f, 0.0f};
    uint64_t seed = 5;
    int i;
    (void)state;
    /* r, g, b, a from the lowest byte: x of layer 0, y of layer 0, x of layer 1, y of layer 1 */
    assert_int_equal(dgb_pack_normals(x, minus_y), 254u | 127u << 8 | 127u << 16 | 0u << 24);
    for (i = 0; i < 20000; ++i) {
        const float a[3] = {random_signed(&seed), random_signed(&seed), random_signed(&seed)};
        const float b[3] = {random_signed(&seed), random_signed(&seed), random_signed(&seed)};
        const uint32_t packed = dgb_pack_normals(a, b);
        float n[3], m[3], expected_n[3], expected_m[3];
        if (packed != (dgb_oct16_encode(a) | (uint32_t)dgb_oct16_encode(b) << 16)) fail_msg("packed %08x", packed);
        dgb_unpack_normals(packed, n, m);
        dgb_oct16_decode(dgb_oct16_encode(a), expected_n);
        dgb_oct16_decode(dgb_oct16_encode(b), expected_m);
        if (!same_bits(n, expected_n, sizeof n) || !same_bits(m, expected_m, sizeof m))
            fail_msg("unpacked %08x", packed);
    }
}

/* >> small floats: one description of R11, B10 and the positive half floats */

typedef struct small_float {
    const char* name;
    int mantissa;
    uint32_t last; /* the largest code that is stored */
    float (*unpack)(uint32_t code);
    uint32_t (*pack)(float x);
} small_float;

static float unpack_channel(uint32_t code, int channel) {
    static const int shift[3] = {0, 11, 22};
    float rgb[3];
    dgb_r11g11b10f_unpack(code << shift[channel], rgb);
    return rgb[channel];
}

static uint32_t pack_channel(float x, int channel) {
    float rgb[3] = {0.0f, 0.0f, 0.0f};
    uint32_t packed;
    rgb[channel] = x;
    packed = dgb_r11g11b10f_pack(rgb);
    if (channel == 0 && packed >> 11) fail_msg("r leaks: %08x", packed);
    if (channel == 1 && (packed & 2047u || packed >> 22)) fail_msg("g leaks: %08x", packed);
    if (channel == 2 && packed & 0x3fffffu) fail_msg("b leaks: %08x", packed);
    return channel == 0 ? packed : channel == 1 ? packed >> 11 : packed >> 22;
}

static float unpack_r(uint32_t code) { return unpack_channel(code, 0); }
static float unpack_g(uint32_t code) { return unpack_channel(code, 1); }
static float unpack_b(uint32_t code) { return unpack_channel(code, 2); }
static float unpack_half(uint32_t code) { return dgb_half_to_float((uint16_t)code); }
static uint32_t pack_r(float x) { return pack_channel(x, 0); }
static uint32_t pack_g(float x) { return pack_channel(x, 1); }
static uint32_t pack_b(float x) { return pack_channel(x, 2); }
static uint32_t pack_half(float x) { return dgb_half_from_float(x); }

/* 64512 is 0x7be, 0x7be and 0x3df; 65504 is 0x7bff */
static const small_float formats[] = {{"r", 6, 0x7be, unpack_r, pack_r},
                                      {"g", 6, 0x7be, unpack_g, pack_g},
                                      {"b", 5, 0x3df, unpack_b, pack_b},
                                      {"half", 10, 0x7bff, unpack_half, pack_half}};
enum { FORMAT_COUNT = 4 };

/* The value of a finite code, by definition. */
static double code_value(uint32_t code, int mantissa) {
    const int exponent = (int)(code >> mantissa), fraction = (int)(code & ((1u << mantissa) - 1u));
    return exponent ? ldexp((1 << mantissa) + fraction, exponent - 15 - mantissa) : ldexp(fraction, -14 - mantissa);
}

static void check_code(const small_float* f, uint32_t code) {
    const uint32_t infinity = 31u << f->mantissa;
    const uint32_t u = bits_of(f->unpack(code));
    if (code < infinity && (double)from_bits(u) != code_value(code, f->mantissa))
        fail_msg("%s: code %04x is %.9g", f->name, code, (double)from_bits(u));
    if (code == infinity && u != 0x7f800000u) fail_msg("%s: infinity is %08x", f->name, u);
    if (code > infinity && !is_nan_bits(u)) fail_msg("%s: NaN %04x is %08x", f->name, code, u);
}

static void test_every_code_unpacks(void** state) {
    int i;
    uint32_t code;
    (void)state;
    for (i = 0; i < FORMAT_COUNT; ++i)
        for (code = 0; code < 32u << formats[i].mantissa; ++code) check_code(&formats[i], code);
}

static void test_negative_halves_unpack(void** state) {
    uint32_t code;
    (void)state;
    for (code = 0; code < 0x8000u; ++code) {
        const uint32_t plus = bits_of(dgb_half_to_float((uint16_t)code));
        const uint32_t minus = bits_of(dgb_half_to_float((uint16_t)(code | 0x8000u)));
        if (is_nan_bits(plus) ? !is_nan_bits(minus) : minus != (plus | 0x80000000u))
            fail_msg("code %04x: %08x and %08x", code, plus, minus);
    }
}

static void test_every_code_packs_back(void** state) {
    int i;
    uint32_t code;
    (void)state;
    for (i = 0; i < FORMAT_COUNT; ++i)
        for (code = 0; code <= formats[i].last; ++code) {
            const uint32_t again = formats[i].pack(formats[i].unpack(code));
            if (again != code) fail_msg("%s: code %04x came back as %04x", formats[i].name, code, again);
        }
    for (code = 0; code <= 0x7bffu; ++code) {
        const uint32_t again = dgb_half_from_float(dgb_half_to_float((uint16_t)(code | 0x8000u)));
        if (again != (code | 0x8000u)) fail_msg("half: code %04x came back as %04x", code | 0x8000u, again);
    }
}

/* Half way between two codes the even one wins; one float to either side decides otherwise. */
static void test_midpoints_round_to_even(void** state) {
    int i;
    uint32_t code;
    (void)state;
    for (i = 0; i < FORMAT_COUNT; ++i)
        for (code = 0; code < formats[i].last; ++code) {
            const small_float* f = &formats[i];
            const float middle = (float)(0.5 * (code_value(code, f->mantissa) + code_value(code + 1, f->mantissa)));
            const uint32_t u = bits_of(middle);
            const uint32_t at = f->pack(middle), below = f->pack(from_bits(u - 1)), above = f->pack(from_bits(u + 1));
            if (at != code + (code & 1u)) fail_msg("%s: %.9g packs to %04x", f->name, (double)middle, at);
            if (below != code) fail_msg("%s: below %.9g packs to %04x", f->name, (double)middle, below);
            if (above != code + 1) fail_msg("%s: above %.9g packs to %04x", f->name, (double)middle, above);
        }
}

/* Half a step: relative to the value where it is normal, of the smallest step where it is not. */
static void check_pack_error(const small_float* f, float x) {
    const double largest = code_value(f->last, f->mantissa);
    const double wanted = (double)x < largest ? (double)x : largest;
    const double error = fabs(code_value(f->pack(x), f->mantissa) - wanted);
    const double smallest_normal = ldexp(1.0, -14);
    const double bound = ldexp(wanted > smallest_normal ? wanted : smallest_normal, -f->mantissa - 1);
    if (error > bound) fail_msg("%s: %.9g is off by %.3g of %.3g", f->name, (double)x, error, bound);
}

static void test_pack_is_monotone_and_close(void** state) {
    int i;
    (void)state;
    for (i = 0; i < FORMAT_COUNT; ++i) {
        uint32_t u, last = 0;
        for (u = 0; u <= 0x7f800000u; u += 1499u) {
            const uint32_t code = formats[i].pack(from_bits(u));
            if (code < last || code > formats[i].last) fail_msg("%s: %08x packs to %04x", formats[i].name, u, code);
            check_pack_error(&formats[i], from_bits(u));
            last = code;
        }
        assert_int_equal(formats[i].pack(from_bits(0x7f800000u)), formats[i].last);
    }
}

static void test_packs_of_what_cannot_be_stored(void** state) {
    static const uint32_t zero[] = {0x7fc00000u, 0xffc00000u, 0x7f800001u, 0xff800001u, 0xff800000u,
                                    0x80000000u, 0xbf800000u, 0x80000001u, 0x00000001u, 0x007fffffu};
    static const float huge[] = {64512.0f, 64513.0f, 65024.0f, 65504.0f, 65520.0f, 1e6f, FLT_MAX};
    size_t i;
    int channel;
    (void)state;
    for (channel = 0; channel < 3; ++channel) {
        for (i = 0; i < sizeof zero / sizeof zero[0]; ++i)
            if (formats[channel].pack(from_bits(zero[i])) != 0) fail_msg("%08x does not pack to 0", zero[i]);
        for (i = 0; i < sizeof huge / sizeof huge[0]; ++i)
            if (formats[channel].pack(huge[i]) != formats[channel].last)
                fail_msg("%s: %g packs to %04x", formats[channel].name, (double)huge[i],
                         formats[channel].pack(huge[i]));
    }
}

static void test_half_of_what_cannot_be_stored(void** state) {
    static const float huge[] = {65504.0f, 65505.0f, 65519.0f, 65520.0f, 65536.0f, 1e6f, FLT_MAX};
    size_t i;
    (void)state;
    for (i = 0; i < sizeof huge / sizeof huge[0]; ++i) {
        if (dgb_half_from_float(huge[i]) != 0x7bff) fail_msg("%g", (double)huge[i]);
        if (dgb_half_from_float(-huge[i]) != 0xfbff) fail_msg("%g", (double)-huge[i]);
    }
    assert_int_equal(dgb_half_from_float(from_bits(0x7f800000u)), 0x7bff);
    assert_int_equal(dgb_half_from_float(from_bits(0xff800000u)), 0xfbff);
    assert_int_equal(dgb_half_from_float(from_bits(0x7fc00000u)), 0);
    assert_int_equal(dgb_half_from_float(from_bits(0xffc00001u)), 0);
    assert_int_equal(dgb_half_from_float(from_bits(0x7f800001u)), 0);
    assert_int_equal(dgb_half_from_float(-0.0f), 0x8000);
    assert_int_equal(dgb_half_from_float(-1.0f), 0xbc00);
    assert_int_equal(dgb_half_from_float(from_bits(0x80000001u)), 0x8000);
}

static void test_channels_do_not_mix(void** state) {
    uint64_t seed = 6;
    int i;
    (void)state;
    for (i = 0; i < 100000; ++i) {
        const float rgb[3] = {from_bits(random_bits(&seed)), from_bits(random_bits(&seed)),
                              from_bits(random_bits(&seed))};
        const uint32_t packed = dgb_r11g11b10f_pack(rgb);
        const uint32_t expected = pack_r(rgb[0]) | pack_g(rgb[1]) << 11 | pack_b(rgb[2]) << 22;
        float again[3];
        if (packed != expected)
            fail_msg("(%.9g, %.9g, %.9g): %08x", (double)rgb[0], (double)rgb[1], (double)rgb[2], packed);
        dgb_r11g11b10f_unpack(packed, again);
        if (dgb_r11g11b10f_pack(again) != packed) fail_msg("%08x does not come back", packed);
    }
}

/* >> what the shaders store */

static uint32_t storable_bits(uint32_t u) {
    if (is_nan_bits(u) || u >> 31) return 0u;
    return u < bits_of(64512.0f) ? u : bits_of(64512.0f); /* positive floats sort as their bits do */
}

static void check_storable(uint32_t u) {
    const uint32_t result = bits_of(dgb_storable(from_bits(u)));
    if (FAST_MATH && is_denormal_bits(u) && result == 0u) return;
    if (result != storable_bits(u)) fail_msg("%08x is stored as %08x", u, result);
}

static void test_storable(void** state) {
    static const uint32_t special[] = {0u,          0x80000000u, 1u,          0x80000001u, 0x7f800000u, 0xff800000u,
                                       0x7f800001u, 0x7fc00000u, 0xffc00000u, 0x7fffffffu, 0xffffffffu, 0x7f7fffffu,
                                       0xff7fffffu, 0x477bffffu, 0x477c0000u, 0x477c0001u, 0x3f800000u, 0xbf800000u};
    uint64_t seed = 7;
    size_t i;
    int r;
    (void)state;
    for (i = 0; i < sizeof special / sizeof special[0]; ++i) check_storable(special[i]);
    for (r = 0; r < 1000000; ++r) check_storable(random_bits(&seed));
}

/* >> averages as they are stored */

static float half_of(uint32_t code) { return dgb_half_to_float((uint16_t)code); }

/* Two floats beside a half, as far as roundings take an average of equal numbers, are it. */
static void test_halves_stay_when_dithered(void** state) {
    static const float us[] = {0.0f, 0.25f, 0.5f, 0.75f, 0x0.ffffffp0f};
    uint32_t code;
    size_t i;
    int off;
    (void)state;
    for (code = 0; code <= 0x7bff; ++code)
        for (i = 0; i < sizeof us / sizeof us[0]; ++i)
            for (off = code ? -2 : 0; off <= 2; ++off) {
                const float half = half_of(code), x = from_bits(bits_of(half) + (uint32_t)off);
                if (dgb_dithered(x, us[i]) != half || dgb_dithered(-x, us[i]) != -half)
                    fail_msg("%.9g of %g becomes %.9g", (double)x, (double)us[i], (double)dgb_dithered(x, us[i]));
            }
}

/* Beyond 0..1 u counts as 0 or 1, and NaN as 0. */
static void test_dithered_by_any_number(void** state) {
    static const float x = 0.3f; /* 0.8 of the way from a half to the next */
    (void)state;
    assert_true(dgb_dithered(x, 0.0f) < x && dgb_dithered(x, 1.0f) > x);
    assert_true(dgb_dithered(x, -1.0f) == dgb_dithered(x, 0.0f));
    assert_true(dgb_dithered(x, from_bits(0x7fc00000u)) == dgb_dithered(x, 0.0f));
    assert_true(dgb_dithered(x, 1.0f) == dgb_dithered(x, 0x0.ffffffp0f));
    assert_true(dgb_dithered(x, 1e30f) == dgb_dithered(x, 0x0.ffffffp0f));
}

static void test_what_is_not_finite_is_not_dithered(void** state) {
    static const uint32_t special[] = {0x7f800000u, 0xff800000u, 0x7fc00000u, 0xffc00001u, 0x7f800001u, 0x7fffffffu};
    size_t i;
    (void)state;
    for (i = 0; i < sizeof special / sizeof special[0]; ++i)
        assert_int_equal(bits_of(dgb_dithered(from_bits(special[i]), 0.75f)), special[i]);
}

/* Over all that u may come to: within the two floats on either side that stay and one rounded away, of 8192 from half to half. */
static void test_dithered_on_average(void** state) {
    enum { US = 8188 };
    uint64_t seed = 8;
    int r, k;
    (void)state;
    for (r = 0; r < 2000; ++r) {
        const uint32_t code = random_bits(&seed) % (r % 4 ? 0x7bffu : 0x400u); /* one in four where halves are sparse */
        const double low = (double)half_of(code), step = (double)half_of(code + 1) - low;
        const float x = (float)(low + step * (random_bits(&seed) / 4294967296.0)) * (r % 2 ? -1.0f : 1.0f);
        double sum = 0.0;
        for (k = 0; k < US; ++k) {
            const double y = (double)dgb_dithered(x, ((float)k + 0.5f) / US), size = fabs(y);
            if (size != low && size != low + step) fail_msg("%.9g becomes %.9g", (double)x, y);
            sum += y;
        }
        if (fabs(sum / US - (double)x) > 3.0 / 8192.0 * step) fail_msg("%.9g is %.9g on average", (double)x, sum / US);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_oct16_decode_every_code),
        cmocka_unit_test(test_oct16_codes_are_stable),
        cmocka_unit_test(test_oct16_axes_are_exact),
        cmocka_unit_test(test_oct16_edges_and_octants),
        cmocka_unit_test(test_oct16_error),
        cmocka_unit_test(test_oct16_rounds_to_nearest),
        cmocka_unit_test(test_oct16_is_total),
        cmocka_unit_test(test_oct16_signed_zeros),
        cmocka_unit_test(test_oct16_folds_zeros_to_the_positive_side),
        cmocka_unit_test(test_oct16_scale_does_not_matter),
        cmocka_unit_test(test_both_normals_in_one_texel),
        cmocka_unit_test(test_every_code_unpacks),
        cmocka_unit_test(test_negative_halves_unpack),
        cmocka_unit_test(test_every_code_packs_back),
        cmocka_unit_test(test_midpoints_round_to_even),
        cmocka_unit_test(test_pack_is_monotone_and_close),
        cmocka_unit_test(test_packs_of_what_cannot_be_stored),
        cmocka_unit_test(test_half_of_what_cannot_be_stored),
        cmocka_unit_test(test_channels_do_not_mix),
        cmocka_unit_test(test_storable),
        cmocka_unit_test(test_halves_stay_when_dithered),
        cmocka_unit_test(test_dithered_by_any_number),
        cmocka_unit_test(test_what_is_not_finite_is_not_dithered),
        cmocka_unit_test(test_dithered_on_average),
    };
    return cmocka_run_group_tests_name("packing", tests, NULL, NULL);
}
