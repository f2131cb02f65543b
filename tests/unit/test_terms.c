/* Terms: keep test, occlusion, gathered light, boost, reconstruction weight, presets. */

#include "deepgbuffer.h"
#include "numbers.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <float.h>
#include <math.h>
#include <string.h>

#define PI_F 3.14159265358979323846f
#define PI_L 3.14159265358979323846264338327950288L

static float not_a_number(void) { return from_bits(0x7fc00000u); }

static float infinity(void) { return from_bits(0x7f800000u); }

static float random_in(uint64_t* state, float low, float high) {
    return low + (high - low) * (float)((double)random_bits(state) / 4294967296.0);
}

static void random_vector(uint64_t* seed, float length, float v[3]) {
    int i;
    for (i = 0; i < 3; ++i) v[i] = random_in(seed, -length, length);
}

static void random_unit(uint64_t* seed, float n[3]) {
    float d2;
    int i;
    do {
        random_vector(seed, 1.0f, n);
        d2 = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
    } while (d2 < 0.01f || d2 > 1.0f);
    for (i = 0; i < 3; ++i) n[i] /= sqrtf(d2);
}

static long double dot(const float a[3], const float b[3]) {
    return (long double)a[0] * b[0] + (long double)a[1] * b[1] + (long double)a[2] * b[2];
}

static long double max0(long double x) { return x > 0.0L ? x : 0.0L; }

/* Anything a shader could be handed: the odd values, and random bits. */
static float odd_float(uint64_t* seed) {
    static const uint32_t odd[] = {0u,          0x80000000u, 1u,          0x80000001u, 0x7f800000u,
                                   0xff800000u, 0x7fc00000u, 0xffc00001u, 0x7f7fffffu, 0xff7fffffu,
                                   0x3f800000u, 0xbf800000u, 0x00800000u, 0x71000000u};
    const uint32_t pick = random_bits(seed) % 20u;
    return from_bits(pick < sizeof odd / sizeof odd[0] ? odd[pick] : random_bits(seed));
}

static void odd_vector(uint64_t* seed, float v[3]) {
    int i;
    for (i = 0; i < 3; ++i) v[i] = odd_float(seed);
}

/* >> keep test */

static void test_keep_test_is_strict(void** state) {
    (void)state;
    assert_true(dgb_keep_test(-3.0f, -2.0f, 0.5f));
    assert_false(dgb_keep_test(-2.5f, -2.0f, 0.5f)); /* exactly the separation behind */
    assert_true(dgb_keep_test(from_bits(bits_of(-2.5f) + 1), -2.0f, 0.5f));
    assert_false(dgb_keep_test(from_bits(bits_of(-2.5f) - 1), -2.0f, 0.5f));
    assert_false(dgb_keep_test(-1.0f, -2.0f, 0.5f)); /* in front */
    assert_false(dgb_keep_test(-2.0f, -2.0f, 0.5f));
    assert_true(dgb_keep_test(3.0f, 4.0f, 0.5f)); /* orthographic: z of either sign */
    assert_false(dgb_keep_test(4.0f, 3.0f, 0.5f));
    assert_true(dgb_keep_test(-0.25f, 0.5f, 0.5f));
}

static void test_keep_test_without_separation(void** state) {
    uint64_t seed = 21;
    int i;
    (void)state;
    for (i = 0; i < 10000; ++i) {
        const float z = -expf(random_in(&seed, -10.0f, 30.0f)), farther = from_bits(bits_of(z) + 1);
        if (dgb_keep_test(z, z, 0.0f)) fail_msg("coplanar at %.9g is kept", (double)z);
        if (!dgb_keep_test(farther, z, 0.0f)) fail_msg("one step behind %.9g is not kept", (double)z);
        if (dgb_keep_test(z, farther, 0.0f)) fail_msg("one step in front of %.9g is kept", (double)farther);
    }
}

/* A separation too small to be seen at that distance is none: the next float is still kept, the same one
   never. */
static void test_keep_test_below_resolution(void** state) {
    int exponent;
    (void)state;
    for (exponent = 20; exponent <= 50; ++exponent) {
        const float z = -ldexpf(1.37f, exponent);
        const float farther = from_bits(bits_of(z) + 1), separation = (z - farther) * 0.25f;
        if (dgb_keep_test(z, z, separation)) fail_msg("coplanar at %.9g is kept", (double)z);
        if (!dgb_keep_test(farther, z, separation)) fail_msg("one step behind %.9g is not kept", (double)z);
    }
}

static void test_keep_test_never_keeps_what_is_nearer(void** state) {
    uint64_t seed = 22;
    int i;
    (void)state;
    for (i = 0; i < 200000; ++i) {
        const float z = -expf(random_in(&seed, -5.0f, 20.0f)), front = -expf(random_in(&seed, -5.0f, 20.0f));
        const float separation = expf(random_in(&seed, -20.0f, 5.0f));
        if (dgb_keep_test(z, front, separation) != (-z > -front + separation) ||
            (dgb_keep_test(z, front, separation) && z >= front))
            fail_msg("z %.9g, front %.9g, separation %.9g", (double)z, (double)front, (double)separation);
    }
}

static void test_keep_test_of_empty_and_nan(void** state) {
    const float values[] = {0.0f, -1.0f, -1e30f, 1.0f, infinity(), -infinity(), not_a_number()};
    size_t i, j;
    (void)state;
    for (i = 0; i < 7; ++i) {
        assert_false(dgb_keep_test(values[i], 0.0f, 0.0f)); /* nothing in front: nothing behind */
        assert_false(dgb_keep_test(values[i], -0.0f, 0.0f));
        for (j = 0; j < 7; ++j) {
            assert_false(dgb_keep_test(not_a_number(), values[i], values[j]));
            assert_false(dgb_keep_test(values[i], not_a_number(), values[j]));
            assert_false(dgb_keep_test(values[i], values[j], not_a_number()));
        }
        assert_false(dgb_keep_test(values[i], -1.0f, infinity()));
    }
}

/* >> ambient occlusion */

static long double ao_oracle(const float v[3], const float n[3], float inv_r2, float beta, float epsilon) {
    const long double d2 = dot(v, v);
    return max0(1.0L - d2 * inv_r2) * max0((dot(v, n) - beta) / sqrtl(d2 + epsilon));
}

static void test_ao_term(void** state) {
    uint64_t seed = 23;
    int i;
    (void)state;
    for (i = 0; i < 200000; ++i) {
        const float r = expf(random_in(&seed, -6.0f, 6.0f)), inv_r2 = 1.0f / (r * r);
        const float beta = random_in(&seed, 0.0f, 0.1f) * r, epsilon = random_in(&seed, 1e-4f, 0.01f) * r * r;
        float v[3], n[3], term;
        long double expected;
        random_vector(&seed, r, v);
        random_unit(&seed, n);
        term = dgb_ao_term(v, n, inv_r2, beta, epsilon);
        expected = ao_oracle(v, n, inv_r2, beta, epsilon);
        /* both factors are differences of numbers up to 4: their rounding is absolute */
        if (!is_finite(term) || fabsl(term - expected) > 2e-6L)
            fail_msg("v (%g, %g, %g), r %g: %.9g, not %.9Lg", (double)v[0], (double)v[1], (double)v[2], (double)r,
                     (double)term, expected);
    }
}

/* Scene, radius, bias and epsilon times a power of two: not a bit may change, so no absolute length hides
   inside. */
static void test_ao_term_has_no_scale(void** state) {
    uint64_t seed = 24;
    int i, k, exponent;
    (void)state;
    for (i = 0; i < 2000; ++i) {
        float v[3], n[3], first;
        const float beta = random_in(&seed, 0.0f, 0.05f);
        random_vector(&seed, 1.0f, v);
        random_unit(&seed, n);
        first = dgb_ao_term(v, n, 1.0f, beta, 0.001f);
        for (exponent = -20; exponent <= 20; exponent += 5) {
            float w[3], term;
            for (k = 0; k < 3; ++k) w[k] = ldexpf(v[k], exponent);
            term = dgb_ao_term(w, n, ldexpf(1.0f, -2 * exponent), ldexpf(beta, exponent), ldexpf(0.001f, 2 * exponent));
            if (bits_of(term) != bits_of(first))
                fail_msg("v (%g, %g, %g) times 2^%d: %.9g, not %.9g", (double)v[0], (double)v[1], (double)v[2],
                         exponent, (double)term, (double)first);
        }
    }
}

static void test_ao_term_ends_at_the_radius(void** state) {
    static const float n[3] = {0.0f, 0.0f, 1.0f};
    float last = 2.0f;
    int i;
    (void)state;
    for (i = 10; i < 300; ++i) {
        const float d = (float)i / 100.0f;
        const float v[3] = {0.0f, 0.0f, d}, term = dgb_ao_term(v, n, 1.0f, 0.0f, 0.0f);
        if (term > last || term < 0.0f || (d < 1.0f) != (term > 0.0f)) fail_msg("d %g: %g", (double)d, (double)term);
        last = term;
    }
}

static void test_ao_term_of_the_point_itself(void** state) {
    static const float zero[3] = {0.0f, 0.0f, 0.0f}, n[3] = {0.0f, 0.0f, 1.0f};
    (void)state;
    assert_true(dgb_ao_term(zero, n, 1.0f, 0.02f, 0.001f) == 0.0f);
    assert_true(dgb_ao_term(zero, n, 1.0f, 0.0f, 0.001f) == 0.0f);
    assert_true(bits_of(dgb_ao_term(zero, n, 1.0f, 0.0f, 0.0f)) == 0u);
    assert_true(bits_of(dgb_ao_term(zero, n, 1.0f, 0.02f, 0.0f)) == 0u);
}

static void test_ao_term_is_total(void** state) {
    static const float far_away[3] = {1e30f, 1e30f, 1e30f}, n[3] = {0.0f, 0.0f, 1.0f};
    uint64_t seed = 25;
    int i;
    (void)state;
    assert_true(bits_of(dgb_ao_term(far_away, n, 1.0f, 0.02f, 0.001f)) << 1 == 0u);
    for (i = 0; i < 300000; ++i) {
        float v[3], m[3], term;
        const float inv_r2 = odd_float(&seed), beta = odd_float(&seed), epsilon = odd_float(&seed);
        odd_vector(&seed, v);
        odd_vector(&seed, m);
        term = dgb_ao_term(v, m, inv_r2, beta, epsilon);
        if (!is_finite(term) || term < 0.0f)
            fail_msg("v %08x %08x %08x, n %08x %08x %08x, %08x %08x %08x: %g", bits_of(v[0]), bits_of(v[1]),
                     bits_of(v[2]), bits_of(m[0]), bits_of(m[1]), bits_of(m[2]), bits_of(inv_r2), bits_of(beta),
                     bits_of(epsilon), (double)term);
    }
}

/* NaN and infinity in v or n give no occlusion at all, not just some finite number. */
static void test_ao_term_of_nan(void** state) {
    const float odd[] = {not_a_number(), infinity(), -infinity()};
    int axis, i;
    (void)state;
    for (axis = 0; axis < 3; ++axis)
        for (i = 0; i < 3; ++i) {
            float v[3] = {0.1f, 0.2f, 0.3f}, n[3] = {0.0f, 0.0f, 1.0f};
            v[axis] = odd[i];
            if (bits_of(dgb_ao_term(v, n, 1.0f, 0.02f, 0.001f)) << 1) fail_msg("v[%d] = %g", axis, (double)odd[i]);
            v[axis] = 0.1f;
            n[axis] = i ? 1.0f : not_a_number();
            if (!i && bits_of(dgb_ao_term(v, n, 1.0f, 0.02f, 0.001f)) << 1) fail_msg("n[%d] is NaN", axis);
        }
}

/* A flat plane shaded with its own Oct16 normal, the worst there is: with the preset's bias not a tap may
   darken it. */
static void check_flat_plane(const float normal[3], uint64_t* seed) {
    float stored[3], v[3], d;
    int i;
    dgb_oct16_decode(dgb_oct16_encode(normal), stored);
    random_vector(seed, 1.0f, v);
    d = (float)dot(v, normal);
    for (i = 0; i < 3; ++i) v[i] -= d * normal[i];
    if (dgb_ao_term(v, stored, 1.0f, 0.02f, 0.001f) != 0.0f)
        fail_msg("plane (%.9g, %.9g, %.9g) occludes itself", (double)normal[0], (double)normal[1], (double)normal[2]);
}

static void test_flat_planes_are_open(void** state) {
    uint64_t seed = 26;
    int i, j;
    (void)state;
    for (i = 0; i < 200000; ++i) {
        float n[3];
        random_unit(&seed, n);
        check_flat_plane(n, &seed);
    }
    for (i = -100; i <= 100; ++i) /* around the middle of a face, where the code is coarsest */
        for (j = -100; j <= 100; ++j) {
            const float x = 1.0f / 3.0f + (float)i / 6000.0f, y = 1.0f / 3.0f + (float)j / 6000.0f, z = 1.0f - x - y;
            const float length = sqrtf(x * x + y * y + z * z), n[3] = {x / length, y / length, z / length};
            check_flat_plane(n, &seed);
        }
}

static void test_ambient_visibility(void** state) {
    uint64_t seed = 27;
    int i;
    (void)state;
    assert_true(dgb_ambient_visibility(0.0f, 16) == 1.0f);
    assert_true(dgb_ambient_visibility(-1.0f, 16) == 1.0f);
    assert_true(dgb_ambient_visibility(5.0f, 0) == 1.0f);
    assert_true(dgb_ambient_visibility(5.0f, -3) == 1.0f);
    assert_true(dgb_ambient_visibility(16.0f, 16) == 0.0f);
    assert_true(dgb_ambient_visibility(FLT_MAX, 1) == 0.0f);
    assert_true(bits_of(dgb_ambient_visibility(infinity(), 16)) << 1 == 0u);
    assert_true(bits_of(dgb_ambient_visibility(not_a_number(), 16)) == bits_of(1.0f));
    for (i = 0; i < 100000; ++i) {
        const int count = 1 + (int)(random_bits(&seed) % 256u);
        const float sum = random_in(&seed, 0.0f, 0.5f) * (float)count, v = dgb_ambient_visibility(sum, count);
        const long double expected = max0(1.0L - sqrtl(PI_L / count * sum));
        if (fabsl(v - expected) > 4e-7L)
            fail_msg("sum %.9g of %d: %.9g, not %.9Lg", (double)sum, count, (double)v, expected);
    }
}

/* >> gathered light */

static void test_gather_term(void** state) {
    uint64_t seed = 28;
    int i, lit = 0;
    (void)state;
    for (i = 0; i < 200000; ++i) {
        const float r = expf(random_in(&seed, -6.0f, 6.0f)), r2 = r * r;
        const bool test = random_bits(&seed) & 1u;
        float v[3], n_x[3], n_y[3], term;
        long double d2, cosine, away;
        bool sends;
        random_vector(&seed, r, v);
        random_unit(&seed, n_x);
        random_unit(&seed, n_y);
        d2 = dot(v, v);
        cosine = dot(v, n_x) / sqrtl(d2);
        away = dot(v, n_y) / sqrtl(d2);
        if (fabsl(d2 / r2 - 1.0L) < 1e-5L || fabsl(cosine - DGB_MIN_COSINE) < 1e-5L || fabsl(away) < 1e-5L)
            continue; /* on an edge */
        term = dgb_gather_term(v, n_x, n_y, r2, test);
        sends = d2 < r2 && cosine > DGB_MIN_COSINE && (!test || away < 0.0L);
        lit += sends;
        if (!is_finite(term) || fabsl(term - (sends ? cosine : 0.0L)) > 1e-6L)
            fail_msg("v (%g, %g, %g), r %g, test %d: %.9g, cosine %.9Lg", (double)v[0], (double)v[1], (double)v[2],
                     (double)r, test, (double)term, cosine);
    }
    assert_in_range(lit, 10000, 190000);
}

static void test_gather_term_edges(void** state) {
    static const float zero[3] = {0.0f, 0.0f, 0.0f}, up[3] = {0.0f, 0.0f, 1.0f}, down[3] = {0.0f, 0.0f, -1.0f};
    static const float side[3] = {1.0f, 0.0f, 0.0f};
    (void)state;
    assert_true(bits_of(dgb_gather_term(zero, up, down, 1.0f, false)) == 0u); /* the point itself sends nothing */
    assert_true(bits_of(dgb_gather_term(zero, up, down, 1.0f, true)) == 0u);
    assert_true(fabsf(dgb_gather_term(up, up, down, 1.0f, true) - 1.0f) < 3e-7f); /* at the radius: inside */
    assert_true(dgb_gather_term(up, up, down, 0.999f, true) == 0.0f);
    assert_true(dgb_gather_term(down, up, down, 9.0f, false) == 0.0f); /* behind the receiver */
    assert_true(dgb_gather_term(side, up, down, 9.0f, false) == 0.0f); /* in its plane */
    assert_true(dgb_gather_term(up, up, up, 9.0f, true) == 0.0f);      /* the sender faces away */
    assert_true(dgb_gather_term(up, up, side, 9.0f, true) == 0.0f);    /* edge on */
    assert_true(fabsf(dgb_gather_term(up, up, up, 9.0f, false) - 1.0f) < 3e-7f);
}

static void test_gather_term_is_total(void** state) {
    uint64_t seed = 29;
    int i, axis;
    (void)state;
    for (i = 0; i < 300000; ++i) {
        float v[3], n_x[3], n_y[3], term;
        const float r2 = odd_float(&seed);
        odd_vector(&seed, v);
        odd_vector(&seed, n_x);
        odd_vector(&seed, n_y);
        term = dgb_gather_term(v, n_x, n_y, r2, i & 1);
        if (!is_finite(term) || term < 0.0f)
            fail_msg("v %08x %08x %08x, n_x %08x %08x %08x: %g", bits_of(v[0]), bits_of(v[1]), bits_of(v[2]),
                     bits_of(n_x[0]), bits_of(n_x[1]), bits_of(n_x[2]), (double)term);
    }
    for (axis = 0; axis < 3; ++axis) {
        float v[3] = {0.1f, 0.2f, 0.3f}, n_x[3] = {0.0f, 0.0f, 1.0f};
        static const float n_y[3] = {0.0f, 0.0f, -1.0f};
        v[axis] = not_a_number();
        if (bits_of(dgb_gather_term(v, n_x, n_y, 1.0f, false)) != 0u) fail_msg("v[%d] is NaN", axis);
        v[axis] = 0.1f;
        n_x[axis] = not_a_number();
        if (bits_of(dgb_gather_term(v, n_x, n_y, 1.0f, false)) != 0u) fail_msg("n_x[%d] is NaN", axis);
    }
}

/* In a furnace, where every sender has radiance B, a surface receives at most pi B; exactly that as soon as
   the taps see as much as they should. Otherwise bounces would multiply. */
static void test_furnace(void** state) {
    uint64_t seed = 30;
    int i, k, bright = 0;
    (void)state;
    for (i = 0; i < 50000; ++i) {
        const int count = 1 + (int)(random_bits(&seed) % 64u);
        const float b = expf(random_in(&seed, -5.0f, 9.0f)), least = random_in(&seed, 0.0f, 0.8f);
        float sum_cos = 0.0f, sum = 0.0f, e;
        for (k = 0; k < count; ++k) {
            const float cosine = random_in(&seed, least, 1.0f);
            sum_cos += cosine;
            sum += b * cosine;
        }
        e = sum * dgb_gather_scale(sum_cos, count, 1.0f);
        if (!is_finite(e) || e > PI_F * b * 1.00001f) fail_msg("%d senders of %g give %g", count, (double)b, (double)e);
        if (sum_cos >= 0.5f * (float)count) {
            ++bright;
            if (fabsf(e - PI_F * b) > PI_F * b * 1e-5f)
                fail_msg("%d senders of %g give %g", count, (double)b, (double)e);
        } else if (fabsf(e - 2.0f * PI_F * sum / (float)count) > e * 1e-5f) {
            fail_msg("%d senders of %g give %g, less than Equation 4", count, (double)b, (double)e);
        }
    }
    assert_in_range(bright, 1000, 49000);
}

static void test_gather_scale(void** state) {
    int count;
    (void)state;
    assert_true(dgb_gather_scale(5.0f, 0, 1.0f) == 0.0f);
    assert_true(dgb_gather_scale(5.0f, -1, 1.0f) == 0.0f);
    for (count = 1; count <= 512; ++count) {
        const float literal = 2.0f * PI_F / (float)count;
        if (fabsf(dgb_gather_scale(0.9f * (float)count, count, 0.0f) - literal) > literal * 1e-6f)
            fail_msg("%d senders: Equation 4 gives %g", count,
                     (double)dgb_gather_scale(0.9f * (float)count, count, 0.0f));
        if (fabsf(dgb_gather_scale(0.0f, count, 1.0f) - literal) > literal * 1e-6f) fail_msg("%d dark senders", count);
    }
}

/* >> boost */

static void test_boost(void** state) {
    static const float grey[3] = {0.5f, 0.5f, 0.5f}, black[3] = {0.0f, 0.0f, 0.0f}, red[3] = {0.8f, 0.0f, 0.0f};
    static const float brick[3] = {0.8f, 0.4f, 0.2f}, negative[3] = {-1.0f, -2.0f, -3.0f};
    int i;
    (void)state;
    assert_true(dgb_boost(grey, 0.25f, 1.0f) == 0.25f);
    assert_true(dgb_boost(black, 0.25f, 1.0f) == 0.25f);
    assert_true(dgb_boost(negative, 0.25f, 1.0f) == 0.25f);
    assert_true(fabsf(dgb_boost(red, 0.25f, 2.0f) - 2.0f) < 1e-6f);
    assert_true(fabsf(dgb_boost(brick, 0.0f, 1.0f) - 0.75f) < 1e-6f); /* Equation 7 */
    assert_true(fabsf(dgb_boost(brick, 0.5f, 1.0f) - 0.875f) < 1e-6f);
    for (i = 0; i < 3; ++i) { /* NaN is left out */
        float odd[3] = {0.8f, 0.2f, 0.8f};
        odd[i] = not_a_number();
        assert_true(fabsf(dgb_boost(odd, 0.0f, 1.0f) - (i == 1 ? 0.0f : 0.75f)) < 1e-6f);
    }
    assert_true(dgb_boost(brick, 1.0f, 1.0f) == 1.0f);
    assert_true(dgb_boost(grey, 1.0f, 1.0f) == 1.0f);
}

static void test_boost_is_total(void** state) {
    uint64_t seed = 31;
    int i;
    (void)state;
    for (i = 0; i < 200000; ++i) {
        float albedo[3], b;
        odd_vector(&seed, albedo);
        b = dgb_boost(albedo, 0.25f, 1.5f);
        if (!is_finite(b) || b < 0.25f || b > 1.50001f)
            fail_msg("albedo %08x %08x %08x: %g", bits_of(albedo[0]), bits_of(albedo[1]), bits_of(albedo[2]),
                     (double)b);
    }
}

/* >> reconstruction */

static void test_weight_of_the_texel_itself(void** state) {
    static const float zero[3] = {0.0f, 0.0f, 0.0f};
    int code;
    (void)state;
    for (code = 0; code < 65536; code += 7) {
        float n[3], weight;
        dgb_oct16_decode((uint16_t)code, n);
        weight = dgb_bilateral_weight(n, n, zero, 4.0f, 8.0f);
        if (!is_finite(weight) || fabsf(weight - 1.0f) > 1e-5f)
            fail_msg("code %04x: %.9g", (unsigned)code, (double)weight);
    }
}

static void test_weight_against_the_formula(void** state) {
    uint64_t seed = 32;
    int i;
    (void)state;
    for (i = 0; i < 200000; ++i) {
        const float s_n = random_in(&seed, 0.0f, 8.0f), s_p = random_in(&seed, 0.0f, 8.0f);
        float n[3], m[3], dq[3], weight, swapped;
        long double normal, off, plane;
        random_unit(&seed, n);
        random_unit(&seed, m);
        random_vector(&seed, 2.0f, dq);
        weight = dgb_bilateral_weight(n, m, dq, s_n, s_p);
        swapped = dgb_bilateral_weight(m, n, dq, s_n, s_p);
        off = fmaxl(fabsl(dot(dq, n)), fabsl(dot(dq, m)));
        normal = max0(1.0L - s_n * (1.0L - dot(n, m)));
        plane = max0(1.0L - s_p * off / sqrtl(dot(dq, dq)));
        if (!is_finite(weight) || fabsl(weight - normal * plane * plane) > 1e-5L || weight < 0.0f || weight > 1.00001f)
            fail_msg("weight %.9g, not %.9Lg", (double)weight, normal * plane * plane);
        if (fabsf(weight - swapped) > 1e-6f)
            fail_msg("weight %.9g one way, %.9g the other", (double)weight, (double)swapped);
    }
}

/* Along a plane, however tilted, all weigh 1; across a step in depth, or at right angles, nothing does. */
static void test_weight_of_planes_and_steps(void** state) {
    static const float up[3] = {0.0f, 1.0f, 0.0f}, toward[3] = {0.0f, 0.0f, 1.0f}, step[3] = {0.01f, 0.0f, -1.0f};
    static const float along[3] = {0.01f, 0.02f, 0.0f};
    uint64_t seed = 33;
    int i, k;
    (void)state;
    for (i = 0; i < 20000; ++i) {
        float n[3], dq[3], d, weight;
        random_unit(&seed, n);
        random_vector(&seed, 1.0f, dq);
        d = (float)dot(dq, n);
        for (k = 0; k < 3; ++k) dq[k] -= d * n[k];
        weight = dgb_bilateral_weight(n, n, dq, 4.0f, 8.0f);
        if (!is_finite(weight) || (dot(dq, dq) > 1e-3L && fabsf(weight - 1.0f) > 1e-4f))
            fail_msg("plane (%g, %g, %g): %.9g", (double)n[0], (double)n[1], (double)n[2], (double)weight);
    }
    assert_true(dgb_bilateral_weight(toward, toward, step, 4.0f, 8.0f) == 0.0f);
    assert_true(dgb_bilateral_weight(toward, up, along, 4.0f, 0.0f) == 0.0f);
    assert_true(dgb_bilateral_weight(toward, up, along, 0.0f, 0.0f) == 1.0f); /* both sharpnesses off */
    assert_true(dgb_bilateral_weight(toward, toward, step, 0.0f, 0.0f) == 1.0f);
}

static void test_weight_is_total(void** state) {
    uint64_t seed = 34;
    int i;
    (void)state;
    for (i = 0; i < 200000; ++i) {
        float n[3], m[3], dq[3], weight;
        const float s_n = odd_float(&seed), s_p = odd_float(&seed);
        odd_vector(&seed, n);
        odd_vector(&seed, m);
        odd_vector(&seed, dq);
        weight = dgb_bilateral_weight(n, m, dq, s_n, s_p);
        if (!is_finite(weight) || weight < 0.0f)
            fail_msg("n %08x %08x %08x, dq %08x %08x %08x: %g", bits_of(n[0]), bits_of(n[1]), bits_of(n[2]),
                     bits_of(dq[0]), bits_of(dq[1]), bits_of(dq[2]), (double)weight);
    }
}

/* >> presets */

static void check_preset(dgb_preset_id id, int samples, int taps, bool normal_test, int min_level, float guard) {
    const dgb_params p = dgb_preset(id);
    assert_int_equal(p.samples, samples);
    assert_int_equal(p.filter_taps, taps);
    assert_int_equal(p.normal_test, normal_test);
    assert_int_equal(p.min_level, min_level);
    assert_true(p.guard_fraction == guard);
    /* the same in all three */
    assert_true(p.separation == 0.5f && p.strict_separation);
    assert_true(p.radius == 7.4f && p.ao_radius == 1.0f);
    assert_in_range(p.ao_samples, 1, DGB_MAX_TAPS);
    assert_true(p.ao_bias >= 0.017f && p.ao_bias < 0.05f); /* at least what Oct16 normals need */
    assert_true(p.ao_epsilon == 0.001f && p.ao_intensity == 1.0f);
    assert_in_range(p.ao_min_level, 0, DGB_MAX_LEVELS - 1);
    assert_in_range(p.filter_step, 1, 8);
    assert_int_equal(p.filter_taps % 2, 1);
    assert_true(p.normal_sharpness >= 0.0f && is_finite(p.normal_sharpness));
    assert_true(p.plane_sharpness >= 0.0f && is_finite(p.plane_sharpness));
}

/* Table 2 of the paper, and the estimator that measures best beside it. */
static void test_presets(void** state) {
    (void)state;
    check_preset(DGB_PRESET_PERFORMANCE, 13, 9, false, 3, 0.1f);
    check_preset(DGB_PRESET_BALANCED, 14, 11, true, 2, 0.5f);
    check_preset(DGB_PRESET_QUALITY, 30, 13, true, 0, 0.8f);
    check_preset(DGB_PRESET_COUNT, 14, 11, true, 2, 0.5f);
    assert_int_equal(dgb_preset_estimator(DGB_PRESET_PERFORMANCE), DGB_ESTIMATOR_PAPER);
    assert_int_equal(dgb_preset_estimator(DGB_PRESET_BALANCED), DGB_ESTIMATOR_PAPER);
    assert_int_equal(dgb_preset_estimator(DGB_PRESET_QUALITY), DGB_ESTIMATOR_BITMASK);
    assert_int_equal(dgb_preset_estimator(DGB_PRESET_COUNT), DGB_ESTIMATOR_PAPER);
    assert_int_equal(dgb_preset_estimator((dgb_preset_id)-1), DGB_ESTIMATOR_PAPER);
}

/* Work of a pixel, in taps: what a budget buys. */
static int work_of(const dgb_params* p) { return p->ao_samples + p->samples + 4 * p->filter_taps; }

static bool same_params(dgb_params a, dgb_params b) { return same_bits(&a, &b, sizeof a); }

static void test_presets_for_a_budget(void** state) {
    static const uint32_t all = DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY | DGB_EFFECT_REFLECT;
    const dgb_params least = dgb_preset_for(0.0f, all), most = dgb_preset_for(INFINITY, all);
    int step;
    (void)state;
    assert_true(same_params(dgb_preset_for(1.0f, 0), dgb_preset(DGB_PRESET_BALANCED))); /* nothing to choose for */
    assert_true(same_params(dgb_preset_for(NAN, all), least));
    assert_true(same_params(dgb_preset_for(-1.0f, all), least));
    assert_true(work_of(&least) < work_of(&most) && least.reflect_stride > most.reflect_stride);
    for (step = 0; step < 80; ++step) {
        const float budget = 0.05f * (float)step;
        const dgb_params p = dgb_preset_for(budget, all), light = dgb_preset_for(budget, DGB_EFFECT_RADIOSITY);
        assert_in_range(p.ao_samples, 1, DGB_MAX_TAPS);
        assert_in_range(p.samples, 1, DGB_MAX_TAPS);
        assert_in_range(p.min_level, 0, DGB_MAX_LEVELS - 1);
        assert_in_range(p.ao_min_level, 0, DGB_MAX_LEVELS - 1);
        assert_in_range(p.filter_taps, 1, 2 * DGB_MAX_FILTER_RADIUS + 1);
        assert_int_equal(p.filter_taps % 2, 1);
        assert_in_range(p.reflect_stride, 1, 64);
        assert_int_equal(p.filter_taps, light.filter_taps); /* the light's, with both */
        assert_int_equal(light.ao_samples, dgb_preset(DGB_PRESET_BALANCED).ao_samples);
        assert_true(p.reflect_stride <= least.reflect_stride && p.reflect_stride >= most.reflect_stride);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_keep_test_is_strict),
        cmocka_unit_test(test_keep_test_without_separation),
        cmocka_unit_test(test_keep_test_below_resolution),
        cmocka_unit_test(test_keep_test_never_keeps_what_is_nearer),
        cmocka_unit_test(test_keep_test_of_empty_and_nan),
        cmocka_unit_test(test_ao_term),
        cmocka_unit_test(test_ao_term_has_no_scale),
        cmocka_unit_test(test_ao_term_ends_at_the_radius),
        cmocka_unit_test(test_ao_term_of_the_point_itself),
        cmocka_unit_test(test_ao_term_is_total),
        cmocka_unit_test(test_ao_term_of_nan),
        cmocka_unit_test(test_flat_planes_are_open),
        cmocka_unit_test(test_ambient_visibility),
        cmocka_unit_test(test_gather_term),
        cmocka_unit_test(test_gather_term_edges),
        cmocka_unit_test(test_gather_term_is_total),
        cmocka_unit_test(test_furnace),
        cmocka_unit_test(test_gather_scale),
        cmocka_unit_test(test_boost),
        cmocka_unit_test(test_boost_is_total),
        cmocka_unit_test(test_weight_of_the_texel_itself),
        cmocka_unit_test(test_weight_against_the_formula),
        cmocka_unit_test(test_weight_of_planes_and_steps),
        cmocka_unit_test(test_weight_is_total),
        cmocka_unit_test(test_presets),
        cmocka_unit_test(test_presets_for_a_budget),
    };
    return cmocka_run_group_tests_name("terms", tests, NULL, NULL);
}
