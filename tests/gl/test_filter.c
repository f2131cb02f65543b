/* Reconstruction of both layers: what it must keep, what it must not mix. The light that it finds is made up texel by
   texel. */
#include "gl_images.h"
#include "reference.h"
#include "tally.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static fixture f;

/* >> the light that the next reconstruction shall find */

static struct {
    const dgb_context* c; /* null: nothing to replace */
    const float *ao, *light[2];
} planted;

static dgb_result planting_pass_begin(void* user, const dgb_pass* pass) {
    if (pass->id == DGB_PASS_RECONSTRUCT && planted.c) {
        fixture_put_image(planted.c, DGB_AO_RAW, 1, planted.ao);
        fixture_put_image(planted.c, DGB_IRRADIANCE_RAW, 4, planted.light[0]);
        fixture_put_image(planted.c, DGB_IRRADIANCE1_RAW, 4, planted.light[1]);
        planted.c = NULL;
    }
    return f.gl.backend.pass_begin(user, pass);
}

/* >> a bench: surfaces and light in, filtered light out */

typedef struct bench {
    images m;
    int guard;
    double zoom; /* 2: half as wide a view, about */
    dgb_params params;
    float *ao, *light[2];                           /* in */
    float *ao_out, *half[2], *out[2], *z, *normals; /* out */
    reference r;
    int rect[4];
} bench;

static bench open_bench(int width, int height, int guard) {
    bench b;
    int l;
    memset(&b, 0, sizeof b);
    b.m = images_open(width, height);
    b.guard = guard;
    b.zoom = 1.0;
    b.params = dgb_preset(DGB_PRESET_BALANCED);
    b.ao = (float*)calloc((size_t)width * (size_t)height, sizeof(float));
    for (l = 0; l < 2; ++l) b.light[l] = (float*)calloc((size_t)width * (size_t)height, 4 * sizeof(float));
    return b;
}

static void free_results(bench* b) {
    int l;
    free(b->ao_out), free(b->z), free(b->normals);
    for (l = 0; l < 2; ++l) free(b->half[l]), free(b->out[l]), b->half[l] = b->out[l] = NULL;
    reference_close(&b->r);
    b->ao_out = b->z = b->normals = NULL;
}

static void close_bench(bench* b) {
    free_results(b);
    free(b->ao), free(b->light[0]), free(b->light[1]);
    images_close(&b->m);
}

static void read_results(bench* b, const dgb_context* c) {
    static const float* const nothing[2] = {NULL, NULL};
    free_results(b);
    b->ao_out = fixture_image(c, DGB_AO, 0, 1);
    b->half[0] = fixture_read_half(dgb_get_texture(c, DGB_HALF), b->m.width, b->m.height, NULL);
    b->half[1] = fixture_read_half(dgb_get_texture(c, DGB_HALF1), b->m.width, b->m.height, NULL);
    b->out[0] = fixture_image(c, DGB_IRRADIANCE, 0, 4);
    b->out[1] = fixture_image(c, DGB_IRRADIANCE1, 0, 4);
    b->z = fixture_z(c, 0);
    b->normals = fixture_image(c, DGB_NORMALS, 0, 4);
    reference_open(&b->r, c, b->z, b->normals, nothing);
}

static void filter(bench* b) {
    dgb_backend hooked = f.gl.backend;
    dgb_desc d;
    dgb_view view = images_view(&b->m, b->guard);
    const dgb_layers layers = images_upload(&b->m);
    dgb_context c;
    int i;
    hooked.pass_begin = planting_pass_begin;
    d = images_desc(&f, &b->m, b->guard, 2, DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY | DGB_EFFECT_BOUNCES);
    d.backend = &hooked;
    for (i = 0; i < 2; ++i) view.projection[5 * i] *= (float)b->zoom;
    assert_int_equal(dgb_init(&c, &d), DGB_OK);
    assert_int_equal(dgb_set_layers(&c, &view, &layers), DGB_OK);
    planted.c = &c;
    planted.ao = b->ao;
    for (i = 0; i < 2; ++i) planted.light[i] = b->light[i];
    assert_int_equal(dgb_shade(&c, &b->params), DGB_OK);
    assert_null(planted.c);
    fixture_shaded_rect(&c, &b->params, b->rect);
    read_results(b, &c);
    dgb_shutdown(&c);
}

/* The texel of layer `layer` lies on the plane through (0, 0, -distance) with the normal n. */
static void put_plane(bench* b, int layer, const double n[3], double distance) {
    const dgb_view view = images_view(&b->m, b->guard);
    const float normal[3] = {(float)n[0], (float)n[1], (float)n[2]};
    const double w = b->m.width, h = b->m.height, inner_w = w - 2 * b->guard, inner_h = h - 2 * b->guard;
    int x, y;
    for (y = 0; y < b->m.height; ++y)
        for (x = 0; x < b->m.width; ++x) {
            const double ray_x = (2.0 * (x + 0.5) - w) / inner_w / ((double)view.projection[0] * b->zoom);
            const double ray_y = (2.0 * (y + 0.5) - h) / inner_h / ((double)view.projection[5] * b->zoom);
            const double d = -n[2] * distance / (n[0] * ray_x + n[1] * ray_y - n[2]);   /* ray (x, y, -1) */
            images_put(&b->m, layer, x, y, d > 0.11 && d < 1e4 ? d : INFINITY, normal); /* else the sky */
        }
}

static void plant(bench* b, int layer, int x, int y, float r, float g, float blue, float a) {
    float* texel = b->light[layer] + 4 * (y * b->m.width + x);
    texel[0] = r, texel[1] = g, texel[2] = blue, texel[3] = a;
}

static float half_of(double x) { return dgb_half_to_float(dgb_half_from_float((float)x)); }

/* >> against the reference */

static void compare(const bench* b, int layer, int axis) {
    tally t = tally_of(layer ? "layer 1" : "layer 0");
    const float *from = axis ? b->half[layer] : b->light[layer], *to = axis ? b->out[layer] : b->half[layer];
    int x, y, i;
    for (y = b->rect[1]; y <= b->rect[3]; ++y)
        for (x = b->rect[0]; x <= b->rect[2]; ++x) {
            const reference_filtered e = reference_reconstruct(&b->r, &b->params, axis, layer, b->rect, from, 4, x, y);
            for (i = 0; i < 4; ++i)
                tally_half(&t, (double)to[4 * (y * b->m.width + x) + i], e.value[i] - e.error[i],
                           e.value[i] + e.error[i]);
        }
    tally_report(&t);
    /* what the library rounds itself is off by 1/4 of an ulp on average; truncated it were by 1/2 */
    if (axis == 0 && t.pixels > 1000) assert_true(t.sum <= 0.3 * t.pixels);
}

/* Two walls and a slope behind them, with holes, and light from an integer hash. */
static void put_motley(bench* b) {
    static const double slope[3] = {0.6, 0.3, 0.74};
    static const float left[3] = {0.3f, 0.0f, 0.95f}, right[3] = {-0.4f, 0.1f, 0.9f};
    int x, y, l;
    put_plane(b, 1, slope, 9.0);
    for (y = 0; y < b->m.height; ++y)
        for (x = 0; x < b->m.width; ++x) {
            const int hash = dgb_pixel_hash(x, y, 5), at = y * b->m.width + x;
            const bool near_one = 2 * x < b->m.width;
            images_put(&b->m, 0, x, y, (near_one ? 4.0 : 5.0) + 0.0005 * hash, near_one ? left : right);
            if (hash % 7 == 0) *images_at(&b->m, IMAGE_DEPTH, 1, x, y) = 0.0f;
            if (hash % 31 == 0)
                *images_at(&b->m, IMAGE_DEPTH, 0, x, y) = *images_at(&b->m, IMAGE_DEPTH, 1, x, y) = 0.0f;
            b->ao[at] = (float)dgb_pixel_hash(x, y, 6) / 255.0f;
            for (l = 0; l < 2; ++l)
                plant(b, l, x, y, half_of(exp(dgb_pixel_hash(x, y, 7 + l) / 25.0)),
                      half_of(dgb_pixel_hash(x, y, 9 + l)), half_of(0.01 * dgb_pixel_hash(x, y, 11 + l)),
                      half_of(dgb_pixel_hash(x, y, 13 + l) / 255.0));
        }
}

static void test_reference(void** state) {
    static const int sizes[][3] = {{61, 43, 7}, {1, 1, 0}, {1, 7, 0}, {7, 1, 0}, {33, 17, 0}, {16, 25, 2}};
    size_t size;
    int taps, step, l, axis;
    (void)state;
    for (size = 0; size < sizeof sizes / sizeof sizes[0]; ++size) {
        bench b = open_bench(sizes[size][0], sizes[size][1], sizes[size][2]);
        put_motley(&b);
        for (taps = 9; taps <= 13; taps += 2)
            for (step = 1; step <= 3; ++step) {
                b.params.filter_taps = taps, b.params.filter_step = step;
                filter(&b);
                for (l = 0; l < 2; ++l)
                    for (axis = 0; axis < 2; ++axis) compare(&b, l, axis);
            }
        close_bench(&b);
    }
}

/* Without normals, without planes, without either: empty texels and what lies outside still count for nothing. */
static void test_reference_without_edges(void** state) {
    int kind, l, axis;
    (void)state;
    for (kind = 0; kind < 4; ++kind) {
        bench b = open_bench(61, 43, 7);
        put_motley(&b);
        b.params.normal_sharpness = kind & 1 ? 0.5f : 0.0f;
        b.params.plane_sharpness = kind & 2 ? 0.25f : 0.0f;
        filter(&b);
        for (l = 0; l < 2; ++l)
            for (axis = 0; axis < 2; ++axis) compare(&b, l, axis);
        close_bench(&b);
    }
}

/* >> halos */

/* A bright wall beside a dark one behind it: how much of the light crosses the edge, of both layers. */
static double halo(double gap, int taps, int step, int axis) {
    static const double n[3] = {0.0, 0.0, 1.0};
    bench b = open_bench(65, 65, 0);
    double most = 0.0;
    int x, y, l;
    b.zoom = 4.0;
    b.params.filter_taps = taps, b.params.filter_step = step;
    b.params.separation = 0.1f;
    put_plane(&b, 0, n, 5.0);
    put_plane(&b, 1, n, 8.0);
    for (y = 0; y < 65; ++y)
        for (x = 0; x < 65; ++x) {
            const float normal[3] = {0.0f, 0.0f, 1.0f};
            const bool bright = (axis ? y : x) < 32;
            if (!bright) images_put(&b.m, 0, x, y, 5.0 + gap, normal), images_put(&b.m, 1, x, y, 8.0 + gap, normal);
            b.ao[y * 65 + x] = bright ? 1.0f : 0.0f;
            for (l = 0; l < 2; ++l) plant(&b, l, x, y, bright ? 1024.0f : 0.0f, 0.0f, 0.0f, bright ? 1.0f : 0.0f);
        }
    filter(&b);
    for (y = 0; y < 65; ++y)
        for (x = 0; x < 65; ++x) {
            if ((axis ? y : x) < 32) continue;
            most = fmax(most, (double)b.ao_out[y * 65 + x]);
            for (l = 0; l < 2; ++l) {
                most = fmax(most, (double)b.out[l][4 * (y * 65 + x)] / 1024.0);
                most = fmax(most, (double)b.out[l][4 * (y * 65 + x) + 3]);
            }
        }
    close_bench(&b);
    return most;
}

/* A neighbour i pixels away and `gap` metres behind weighs max(0, 1 - 2 gap / sqrt(gap^2 + (i p)^2))^2, p metres a
   pixel: it weighs nothing as long as i p < sqrt(3) gap. Here p is 3.8 cm and less, and 18 pixels are no more than 0.7
   m: nothing crosses a gap of half a metre, for which the paper's separation stands. */
static void test_no_halo(void** state) {
    int taps, step, axis;
    (void)state;
    for (taps = 9; taps <= 13; taps += 2)
        for (step = 1; step <= 3; ++step)
            for (axis = 0; axis < 2; ++axis) {
                const double far_one = halo(3.0, taps, step, axis), near_one = halo(0.5, taps, step, axis);
                printf("# %d taps, step %d: %g across 3 m, %g across 0.5 m\n", taps, step, far_one, near_one);
                assert_true(far_one == 0.0 && near_one <= 0.0);
            }
}

/* A corner: walls at a right angle, of which the normals differ altogether. */
static void test_no_halo_around_corners(void** state) {
    static const double left[3] = {0.70710678, 0.0, 0.70710678}, right[3] = {-0.70710678, 0.0, 0.70710678};
    bench b = open_bench(65, 33, 0);
    int x, y, l;
    (void)state;
    for (l = 0; l < 2; ++l) {
        put_plane(&b, l, right, 5.0 + 3.0 * l);
        for (y = 0; y < 33; ++y)
            for (x = 0; x < 65; ++x) plant(&b, l, x, y, x < 32 ? 1024.0f : 0.0f, 0.0f, 0.0f, 0.0f);
    }
    {
        bench other = open_bench(65, 33, 0);
        for (l = 0; l < 2; ++l) {
            put_plane(&other, l, left, 5.0 + 3.0 * l);
            for (y = 0; y < 33; ++y)
                for (x = 0; x < 32; ++x) {
                    *images_at(&b.m, IMAGE_DEPTH, l, x, y) = *images_at(&other.m, IMAGE_DEPTH, l, x, y);
                    memcpy(images_at(&b.m, IMAGE_NORMAL, l, x, y), images_at(&other.m, IMAGE_NORMAL, l, x, y),
                           3 * sizeof(float));
                }
        }
        close_bench(&other);
    }
    filter(&b);
    for (y = 0; y < 33; ++y)
        for (x = 32; x < 65; ++x)
            for (l = 0; l < 2; ++l) assert_true(b.out[l][4 * (y * 65 + x)] == 0.0f);
    close_bench(&b);
}

/* >> planes */

/* On a plane a neighbour to the left weighs what one to the right weighs: both lie in the same line through the centre.
   So a constant stays, and away from the border a ramp does: to an ulp of a half a pass, and what the roundings of
   depth (2^-23 of the distance, over the distance of neighbours) make the weights differ by, that is 1/1000 of the
   ramp's rise over the filter's reach. */
static void check_plane(int k) {
    const double tilt = 0.055 * k, turn = 2.4 * k;
    const double n[3] = {sin(tilt) * cos(turn), sin(tilt) * sin(turn), cos(tilt)};
    const int w = 51 + k % 3, h = 37 + k % 2, taps = 9 + 2 * (k % 3), step = 1 + k % 3, reach = taps / 2 * step;
    bench b = open_bench(w, h, 0);
    int x, y, l;
    b.params.filter_taps = taps, b.params.filter_step = step;
    put_plane(&b, 0, n, 4.0);
    put_plane(&b, 1, n, 7.0);
    for (y = 0; y < h; ++y)
        for (x = 0; x < w; ++x) {
            b.ao[y * w + x] = 51.0f / 255.0f;
            for (l = 0; l < 2; ++l) plant(&b, l, x, y, 4.0f, (float)(100 + x), (float)(100 + y), 0.25f);
        }
    filter(&b);
    for (y = 0; y < h; ++y)
        for (x = 0; x < w; ++x)
            for (l = 0; l < 2; ++l) {
                const float* e = b.out[l] + 4 * (y * w + x);
                if (b.z[2 * (y * w + x) + l] == 0.0f) continue;
                assert_true(e[0] == 4.0f && e[3] == 0.25f); /* powers of two: their sums round as the weights' do */
                if (l == 0) assert_true(fabsf(b.ao_out[y * w + x] - b.ao[y * w + x]) < 1e-6f);
                if (tilt > 0.75) continue; /* some neighbours are sky */
                if (x >= reach && x < w - reach)
                    assert_true(fabs((double)e[1] - (100.0 + x)) <= 2.0 * tally_half_ulp(100.0 + x) + 0.001 * reach);
                if (y >= reach && y < h - reach)
                    assert_true(fabs((double)e[2] - (100.0 + y)) <= 2.0 * tally_half_ulp(100.0 + y) + 0.001 * reach);
            }
    close_bench(&b);
}

static void test_planes(void** state) {
    int k;
    (void)state;
    for (k = 0; k < 27; ++k) check_plane(k);
}

/* >> the border of the shaded rectangle */

/* What lies outside of it, NaN, infinite or huge, is not there. */
static void check_outside(float poison, float fraction, int taps, int step) {
    bench clean = open_bench(53, 39, 8), sick = open_bench(53, 39, 8);
    int x, y, l;
    clean.params.guard_fraction = sick.params.guard_fraction = fraction;
    clean.params.filter_taps = sick.params.filter_taps = taps;
    clean.params.filter_step = sick.params.filter_step = step;
    put_motley(&clean), put_motley(&sick);
    filter(&clean);
    for (y = 0; y < 39; ++y)
        for (x = 0; x < 53; ++x) {
            if (x >= clean.rect[0] && y >= clean.rect[1] && x <= clean.rect[2] && y <= clean.rect[3]) continue;
            sick.ao[y * 53 + x] = 1.0f;
            for (l = 0; l < 2; ++l) plant(&sick, l, x, y, poison, poison, poison, poison);
        }
    filter(&sick);
    for (y = clean.rect[1]; y <= clean.rect[3]; ++y)
        for (l = 0; l < 2; ++l) {
            const int from = 4 * (y * 53 + clean.rect[0]);
            const size_t row = (size_t)(4 * (clean.rect[2] - clean.rect[0] + 1)) * sizeof(float);
            assert_memory_equal(clean.out[l] + from, sick.out[l] + from, row);
        }
    close_bench(&clean), close_bench(&sick);
}

static void test_outside(void** state) {
    (void)state;
    check_outside(NAN, 0.0f, 9, 3);
    check_outside(INFINITY, 0.5f, 11, 1);
    check_outside(65504.0f, 0.5f, 13, 2);
    check_outside(-1.0f, 0.0f, 25, 8);
}

FIXTURE_CONTEXT(f, 4, 5, false)

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_reference),   cmocka_unit_test(test_reference_without_edges),
        cmocka_unit_test(test_no_halo),     cmocka_unit_test(test_no_halo_around_corners),
        cmocka_unit_test(test_planes),      cmocka_unit_test(test_outside),
        cmocka_unit_test(test_no_messages),
    };
    return cmocka_run_group_tests(tests, open_context, close_context);
}
