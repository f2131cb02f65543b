/* Every function of the mathematics takes any bits: it returns, and what it returns is finite and within the range that the
   header's table of guarantees gives. (With sanitizers: and nothing on the way is undefined.) */

#include "deepgbuffer.h"
#include "mathematics.h"
#include "numbers.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdio.h>
#include <string.h>

#ifdef __FAST_MATH__
#define FAST_MATH 1 /* subnormal numbers are read as 0, and what an operation makes of NaN is anything */
#else
#define FAST_MATH 0
#endif

/* >> any bits */

static bool is_nan(uint32_t word) { return (word & 0x7fffffffu) > 0x7f800000u; }

static bool is_within(const mathematics_function* f, uint32_t word) {
    const double x = (double)from_bits(word);
    if (f->result == MATHEMATICS_WORDS) return true;
    if (f->result == MATHEMATICS_COUNTS) return (double)(int32_t)word >= f->low && (double)(int32_t)word <= f->high;
    if ((word & 0x7f800000u) == 0x7f800000u) return false;
    return x >= f->low && x <= f->high;
}

static void show(const mathematics_function* f, const uint32_t* in, const uint32_t* out) {
    int i;
    for (i = 0; i < f->inputs; ++i) print_error("in %d: %08x\n", i, (unsigned)in[i]);
    for (i = 0; i < f->outputs; ++i) print_error("out %d: %08x\n", i, (unsigned)out[i]);
    fail_msg("%s is out of its range", f->name);
}

static void check(const mathematics_function* f, uint64_t seed) {
    uint32_t in[MATHEMATICS_MOST_INPUTS], out[MATHEMATICS_MOST_OUTPUTS];
    int call, i;
    for (call = 0; call < 50000; ++call) {
        mathematics_inputs(&seed, in, f->inputs);
        if (strcmp(f->name, "dgb_arc_sine") == 0 && is_nan(in[0]))
            continue; /* NaN stays NaN: its rows' callers see to it */
        f->call(in, out);
        for (i = 0; i < f->outputs; ++i)
            if (!is_within(f, out[i])) show(f, in, out);
    }
}

static void test_every_function(void** state) {
    int i;
    (void)state;
    for (i = 0; i < mathematics_count; ++i) check(&mathematics[i], (uint64_t)i);
}

/* >> the columns of the table */

enum { ZERO, NOT_A_NUMBER, INFINITE, MINUS_INFINITE, SUBNORMAL, COLUMNS };

#define ANY 1e300   /* that row says nothing there */
#define STAYS 2e300 /* what went in */

/* What the first outputs are when the first three inputs (of those that there are) are 0, NaN, infinite... and the others
   ordinary. */
typedef struct row {
    const char* name;
    double out[COLUMNS];
} row;

static const row rows[] = {{"dgb_oct16_encode", {127, 127, 127, 127, 127}}, /* both bytes: +Z */
                           {"dgb_storable", {0, 0, 64512, 0, STAYS}},
                           {"dgb_r11g11b10f_pack", {0, 0, ANY, 0, 0}},
                           {"dgb_half_from_float", {0, 0, 0x7bff, 0x7bff, 0}},
                           {"dgb_dithered", {0, STAYS, STAYS, STAYS, 0}},
                           {"dgb_mip_level", {0, 0, DGB_MAX_LEVELS - 1, 0, 0}},
                           {"dgb_depth_code", {0, STAYS, ANY, STAYS, 0}},
                           {"dgb_linear_z", {0, 0, 0, 0, ANY}},
                           {"dgb_position", {ANY, STAYS, ANY, ANY, ANY}},
                           {"dgb_keep_test", {0, 0, 0, 0, 0}},
                           {"dgb_ao_term", {0, 0, 0, 0, 0}},
                           {"dgb_ambient_visibility", {1, 1, 0, 1, 1}},
                           {"dgb_gather_term", {0, 0, 0, 0, 0}},
                           {"dgb_boost", {0.25, 0.25, 0.25, 0.25, 0.25}}, /* unsaturated */
                           {"dgb_bilateral_weight", {ANY, 0, 0, 0, ANY}},
                           {"dgb_slice_along", {ANY, 1, 1, 1, ANY}}, /* +X */
                           {"dgb_slice", {1, 1, 1, 1, 1}},           /* facing */
                           {"dgb_bent_cosine", {0, 0, 1, 1, 0}},
                           {"dgb_ggx_alpha", {0, 0, 1, 0, 0}},
                           {"dgb_ggx_density", {ANY, 0, 0, 0, ANY}}};

static const mathematics_function* function_of(const char* name) {
    int i;
    for (i = 0; i < mathematics_count; ++i)
        if (strcmp(mathematics[i].name, name) == 0) return &mathematics[i];
    return NULL;
}

static double number_of(const mathematics_function* f, uint32_t word) {
    const bool whole = f->result == MATHEMATICS_COUNTS || strcmp(f->name, "dgb_r11g11b10f_pack") == 0;
    return whole ? (double)word : (double)from_bits(word);
}

static void check_column(const row* r, int column) {
    static const uint32_t specials[COLUMNS] = {0u, 0x7fc00000u, 0x7f800000u, 0xff800000u, 0x00000001u};
    static const uint32_t quarter = 0x3e800000u;
    const mathematics_function* f = function_of(r->name);
    uint32_t in[MATHEMATICS_MOST_INPUTS], out[MATHEMATICS_MOST_OUTPUTS];
    int i;
    for (i = 0; i < MATHEMATICS_MOST_INPUTS; ++i) in[i] = quarter;
    for (i = 0; i < 3 && i < f->inputs; ++i) in[i] = specials[column];
    if (strcmp(r->name, "dgb_depth_code") == 0) in[1] = quarter; /* codes */
    if (strcmp(r->name, "dgb_mip_level") == 0) in[1] = 0u;
    if (strcmp(r->name, "dgb_ambient_visibility") == 0) in[1] = quarter; /* taps */
    if (strcmp(r->name, "dgb_boost") == 0) in[3] = 0x40000000u;
    f->call(in, out);
    if (r->out[column] == STAYS) {
        if (FAST_MATH && column == SUBNORMAL && out[0] == 0u) return;
        if (out[0] != specials[column] && !(is_nan(out[0]) && is_nan(specials[column])))
            fail_msg("%s, column %d: %08x", r->name, column, (unsigned)out[0]);
    } else if (number_of(f, out[0]) != r->out[column]) {
        fail_msg("%s, column %d: %.9g", r->name, column, number_of(f, out[0]));
    }
}

static void test_special_values(void** state) {
    size_t i;
    int column;
    (void)state;
    for (i = 0; i < sizeof rows / sizeof rows[0]; ++i)
        for (column = 0; column < COLUMNS; ++column)
            if (rows[i].out[column] != ANY) check_column(&rows[i], column);
}

/* Those that take integers: out of range. */
static void test_integers_out_of_range(void** state) {
    static const int zero[2] = {0, 0}, p[2] = {3, 5};
    static const int least = -2147483647 - 1, most = 2147483647;
    float tap[3], jitter[2] = {0.0f, 0.0f}, projection[16] = {1.0f}, widened[16];
    int a[2], b[2];
    (void)state;
    assert_int_equal(dgb_spiral_turns(0), 0);
    assert_int_equal(dgb_spiral_turns(least), 0);
    dgb_spiral_tap(-1, 5, tap);
    assert_true(tap[0] == 1.0f && tap[1] == 0.0f && tap[2] == 0.0f);
    assert_int_equal(dgb_mip_levels(-5, -5), 1);
    assert_int_equal(dgb_mip_levels(least, most), 1);
    assert_int_equal(dgb_mip_level(1024.0f, least, 0, 5), 5);
    assert_int_equal(dgb_mip_level(1024.0f, most, 0, 5), 0);
    dgb_mip_source(p, -7, a);
    assert_true(a[0] == p[0] && a[1] == p[1]);
    dgb_mip_source(p, most, a);
    dgb_mip_source(p, DGB_MAX_LEVELS - 1, b);
    assert_true(a[0] == b[0] && a[1] == b[1]);
    dgb_mip_source(zero, least, a);
    assert_true(a[0] == 0 && a[1] == 0);
    dgb_widen_projection(projection, 0, 0, least, jitter, widened);
    assert_true(widened[0] == 0.0f);
    assert_int_equal(dgb_camera_from_matrix(projection, 0, most, DGB_CLIP_ZERO_TO_ONE, false, NULL), DGB_INVALID);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_function),
        cmocka_unit_test(test_special_values),
        cmocka_unit_test(test_integers_out_of_range),
    };
    return cmocka_run_group_tests_name("total", tests, NULL, NULL);
}
