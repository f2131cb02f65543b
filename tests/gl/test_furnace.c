/* Many bounces: light is neither made nor lost. Furnaces, whose answer is known beforehand, and a room left to
   itself. */
#include "gl_images.h"
#include "tally.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { WIDTH = 64, HEIGHT = 48 };

#define PI 3.14159265358979323846
#define LIGHT (DGB_EFFECT_RADIOSITY | DGB_EFFECT_BOUNCES)

static fixture f;

/* >> two plates that face each other, two metres apart

   Whatever a surface sees sends the same, at a cosine of 3/4 or more (the radius is 2.6 m), so that what it receives is
   pi times what everything sends. In two layers the nearer plate is the first and the farther the second; in one the
   two are interleaved at random. */

static void put_plates(stage* u, int layers) {
    static const float towards[3] = {0.0f, 0.0f, 1.0f}, away[3] = {0.0f, 0.0f, -1.0f};
    uint32_t seed = 1u;
    int x, y;
    for (y = 0; y < HEIGHT; ++y)
        for (x = 0; x < WIDTH; ++x) {
            const bool near_one = layers > 1 || (seed >> 16 & 1u);
            seed = seed * 1664525u + 1013904223u;
            images_put(&u->m, 0, x, y, near_one ? 5.0 : 7.0, near_one ? away : towards);
            if (layers > 1) images_put(&u->m, 1, x, y, 7.0, towards);
        }
}

static stage open_furnace(int layers, uint32_t effects, const float emission[3], const float albedo[3]) {
    stage u;
    dgb_desc d;
    int i;
    stage_init(&u, WIDTH, HEIGHT, 0);
    for (i = 0; i < 2; ++i)
        u.view.projection[5 * i] *= 2.0f; /* not so wide that a plate sees past the other's border */
    u.params.radius = 2.6f;
    u.params.samples = layers > 1 ? 64 : 160; /* so that even a corner sees the other plate in every frame */
    u.params.filter_taps = 9;
    put_plates(&u, layers);
    images_fill(&u.m, IMAGE_RADIANCE, emission);
    images_fill(&u.m, IMAGE_ALBEDO, albedo);
    d = images_desc(&f, &u.m, 0, layers, effects);
    assert_int_equal(dgb_init(&u.c, &d), DGB_OK);
    return u;
}

static void run(stage* u) { assert_int_equal(stage_shade(u), DGB_OK); }

/* One code of R11G11B10F at x, for a device may truncate. */
static double code_at(double x, int channel) {
    int exponent;
    (void)frexp(x, &exponent);
    return ldexp(1.0, exponent - 1 - (channel == 2 ? 5 : 6));
}

/* What every pixel sends, which must be the same: least and most of each channel, of both layers. */
static void sent_by_all(const stage* u, double least[3], double most[3]) {
    int l, i, k;
    for (k = 0; k < 3; ++k) least[k] = 1e30, most[k] = 0.0;
    for (l = 0; l < u->c.plan.layers; ++l) {
        float* b = fixture_image(&u->c, l ? DGB_B1 : DGB_B0, 0, 3);
        for (i = 0; i < 3 * WIDTH * HEIGHT; ++i) {
            least[i % 3] = fmin(least[i % 3], (double)b[i]);
            most[i % 3] = fmax(most[i % 3], (double)b[i]);
        }
        free(b);
    }
}

/* Irradiance of both layers is pi times what all send: to an ulp of a half, one more for each pass that stored it
   again. */
static void check_irradiance(const stage* u, dgb_slot first, dgb_slot second, const double least[3],
                             const double most[3], double ulps) {
    int l, i, k;
    for (l = 0; l < u->c.plan.layers; ++l) {
        float* e;
        if (l && !dgb_get_texture(&u->c, second).id) continue;
        e = fixture_image(&u->c, l ? second : first, 0, 4);
        for (i = 0; i < WIDTH * HEIGHT; ++i) {
            assert_true(e[4 * i + 3] > 0.0f); /* everyone sees something */
            for (k = 0; k < 3; ++k) {
                const double low = fmin(PI * least[k], 64512.0), high = fmin(PI * most[k], 64512.0);
                const double value = (double)e[4 * i + k], slack = ulps * tally_half_ulp(value);
                assert_true(value >= low - slack && value <= high + slack);
            }
        }
        free(e);
    }
}

static void check_one_bounce(int layers, uint32_t effects) {
    static const float emission[3] = {1.0f, 3.7f, 0.02f}, black[3] = {0.0f, 0.0f, 0.0f};
    stage u = open_furnace(layers, effects, emission, black);
    double least[3], most[3];
    int frame, k;
    for (frame = 0; frame < 2; ++frame) {
        run(&u);
        sent_by_all(&u, least, most);
        for (k = 0; k < 3; ++k) {
            assert_true(least[k] == most[k]); /* black surfaces send on nothing */
            assert_true(fabs(least[k] - (double)emission[k]) <= code_at((double)emission[k], k));
        }
        check_irradiance(&u, DGB_IRRADIANCE_RAW, DGB_IRRADIANCE1_RAW, least, most, 1.0);
        check_irradiance(&u, DGB_IRRADIANCE, DGB_IRRADIANCE1, least, most, effects & DGB_EFFECT_TEMPORAL ? 4.0 : 3.0);
    }
    stage_close(&u);
}

static void test_all_send_the_same(void** state) {
    int layers;
    (void)state;
    for (layers = 1; layers <= 2; ++layers) {
        if (layers == 1) check_one_bounce(layers, DGB_EFFECT_RADIOSITY);
        check_one_bounce(layers, LIGHT);
        check_one_bounce(layers, LIGHT | DGB_EFFECT_TEMPORAL);
    }
}

/* After many bounces: emission / (1 - rho delta), from below. Rounding to the nearest code may lift it by half a code a
   bounce, that is by half a code / (1 - gain); truncation holds it back where another bounce is worth less than a code:
   there B > emission + gain (1 - 4 ulps of a half) B - code. An average that is truncated stops 1 / (1 - 0.85) ulps
   short of its aim: 7 more. The gain is rho delta. */
static void check_many(int layers, uint32_t effects, float rho, float damping, int frames) {
    static const float emission[3] = {1.0f, 3.7f, 0.02f};
    const float albedo[3] = {rho, rho, rho};
    const double gain = (double)rho * (double)damping, lost = effects & DGB_EFFECT_TEMPORAL ? 11.0 : 4.0;
    stage u = open_furnace(layers, effects, emission, albedo);
    double least[3], most[3], last[2][3] = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
    int frame, k;
    u.params.bounce_damping = damping;
    for (frame = 0; frame < frames; ++frame) {
        run(&u);
        sent_by_all(&u, least, most);
        check_irradiance(&u, DGB_IRRADIANCE_RAW, DGB_IRRADIANCE1_RAW, least, most, 1.0);
        for (k = 0; k < 3; ++k) {
            /* emission + gain * what was sent the bounce before, to four roundings of a half and one code */
            const double low = (double)emission[k] + gain * last[0][k], high = (double)emission[k] + gain * last[1][k];
            const bool averaged = (effects & DGB_EFFECT_TEMPORAL) != 0; /* then it lags behind */
            assert_true(most[k] <= high * (1.0 + 1.0 / 256.0) + code_at(high, k));
            if (!averaged) assert_true(least[k] >= low * (1.0 - 1.0 / 256.0) - code_at(low, k));
            last[0][k] = least[k], last[1][k] = most[k];
        }
    }
    for (k = 0; k < 3 && gain < 1.0; ++k) {
        const double bound = (double)emission[k] / (1.0 - gain), code = code_at(bound, k);
        printf("# rho %g, damping %g: %g to %g, of %g\n", (double)rho, (double)damping, least[k], most[k], bound);
        assert_true(most[k] <= bound + 0.5 * code / (1.0 - gain));
        assert_true(least[k] >= ((double)emission[k] - code) / (1.0 - gain * (1.0 - lost / 1024.0)));
    }
    stage_close(&u);
}

static void test_radiosity_of_many_bounces(void** state) {
    (void)state;
    check_many(2, LIGHT, 0.0f, 1.0f, 4);
    check_many(2, LIGHT, 0.5f, 1.0f, 24);
    check_many(2, LIGHT, 0.9f, 1.0f, 100);
    check_many(2, LIGHT, 0.9f, 0.5f, 30);
    check_many(2, LIGHT, 1.0f, 0.7f, 50);
    check_many(1, LIGHT, 0.5f, 1.0f, 24);
    check_many(1, LIGHT, 0.9f, 1.0f, 100);
    check_many(2, LIGHT | DGB_EFFECT_TEMPORAL, 0.5f, 1.0f, 60);
    check_many(1, LIGHT | DGB_EFFECT_TEMPORAL, 0.8f, 0.9f, 100);
}

/* Surfaces that lose nothing: no answer, and no overflow either. */
static void test_white_furnace_stays_finite(void** state) {
    static const float white[3] = {1.0f, 1.0f, 1.0f}, brighter[3] = {60000.0f, 1e30f, INFINITY};
    static const float emission[3] = {1000.0f, 3000.0f, 20000.0f};
    int kind, frame, i;
    (void)state;
    for (kind = 0; kind < 2; ++kind) {
        stage u = open_furnace(2, LIGHT | (kind ? DGB_EFFECT_TEMPORAL : 0u), emission, kind ? brighter : white);
        double least[3], most[3];
        float* e;
        for (frame = 0; frame < 60; ++frame) run(&u);
        sent_by_all(&u, least, most);
        e = fixture_image(&u.c, DGB_IRRADIANCE, 0, 4);
        for (i = 0; i < 4 * WIDTH * HEIGHT; ++i) {
            assert_true(e[i] >= 0.0f && e[i] <= DGB_MAX_RADIANCE);
            if (i % 4 < 3) assert_true(e[i] >= 63000.0f); /* as bright as can be stored, but for roundings on the way */
        }
        for (i = 0; i < 3; ++i) {
            assert_true(most[i] <= (double)DGB_MAX_RADIANCE);
            /* what can be stored of the irradiance limits what white surfaces send on */
            if (!kind) assert_true(most[i] <= ((double)emission[i] + 64512.0 / PI) * (1.0 + 1.0 / 64.0));
        }
        free(e);
        stage_close(&u);
    }
}

/* Frame 1 sends emission + albedo * factor * emission, factor = lerp(unsaturated, saturated, (max - min) / max). */
static void check_boost(float unsaturated, float saturated, const float albedo[3], double factor) {
    static const float emission[3] = {2.0f, 2.0f, 2.0f};
    stage u = open_furnace(2, LIGHT, emission, albedo);
    double least[3], most[3];
    int k;
    u.params.boost_unsaturated = unsaturated, u.params.boost_saturated = saturated;
    run(&u);
    run(&u);
    sent_by_all(&u, least, most);
    for (k = 0; k < 3; ++k) {
        const double sum = 2.0 * (1.0 + (double)albedo[k] * factor);
        assert_true(least[k] >= sum * (1.0 - 1.0 / 1024.0) - 0.5 * code_at(sum, k));
        assert_true(most[k] <= sum * (1.0 + 1.0 / 1024.0) + 0.5 * code_at(sum, k));
        if (factor == 0.0) assert_true(least[k] == 2.0 && most[k] == 2.0); /* nothing at all */
    }
    stage_close(&u);
}

static void test_boost(void** state) {
    static const float grey[3] = {0.6f, 0.6f, 0.6f}, rust[3] = {0.8f, 0.4f, 0.2f}, red[3] = {0.7f, 0.0f, 0.0f};
    static const float black[3] = {0.0f, 0.0f, 0.0f};
    (void)state;
    check_boost(1.0f, 1.0f, rust, 1.0);
    check_boost(0.0f, 1.0f, grey, 0.0);
    check_boost(0.0f, 1.0f, rust, 0.75);
    check_boost(0.25f, 2.0f, rust, 0.25 + 0.75 * 1.75);
    check_boost(0.5f, 3.0f, red, 3.0);
    check_boost(0.5f, 3.0f, grey, 0.5);
    check_boost(0.5f, 3.0f, black, 0.0);
}

/* >> a room, left to itself */

typedef struct room {
    dgb_context c;
    dgb_params params;
    GLuint program;
} room;

static room open_room(float damping, float history_weight) {
    const fixture_view v = fixture_default_view();
    dgb_desc d = fixture_desc(&f, &v, 100, 60, 8);
    room r;
    memset(&r, 0, sizeof r);
    d.effects = LIGHT | DGB_EFFECT_TEMPORAL;
    assert_int_equal(dgb_init(&r.c, &d), DGB_OK);
    r.program = fixture_program(&r.c);
    assert_true(r.program != 0);
    r.params = dgb_preset(DGB_PRESET_BALANCED);
    r.params.bounce_damping = damping;
    r.params.history_weight = history_weight;
    return r;
}

static void close_room(room* r) {
    glDeleteProgram(r->program);
    dgb_shutdown(&r->c);
}

static void run_room(room* r) {
    const fixture_view v = fixture_default_view();
    const dgb_view view = fixture_dgb_view(&v, 100, 60);
    fixture_draw_user user;
    memset(&user, 0, sizeof user);
    user.f = &f;
    user.program = r->program;
    assert_int_equal(dgb_build(&r->c, &view, &r->params, fixture_draw, &user), DGB_OK);
    assert_int_equal(dgb_shade(&r->c, &r->params), DGB_OK);
}

/* Largest of each channel in a layer of the G-buffer. */
static void largest_in(const room* r, dgb_slot slot, double largest[3]) {
    const int w = r->c.plan.width, h = r->c.plan.height;
    int l, i;
    for (i = 0; i < 3; ++i) largest[i] = 0.0;
    for (l = 0; l < 2; ++l) {
        float* texels = fixture_read(dgb_get_texture(&r->c, slot), 0, l, w, h, 2, GL_RGB, 3);
        for (i = 0; i < 3 * w * h; ++i) largest[i % 3] = fmax(largest[i % 3], (double)texels[i]);
        free(texels);
    }
}

/* No gather gives more than pi times the brightest sender, so no bounce more than rho_max times the bounce before. */
static void check_room_bound(const room* r) {
    static const dgb_slot slots[] = {DGB_IRRADIANCE_RAW, DGB_IRRADIANCE_MEAN, DGB_IRRADIANCE, DGB_IRRADIANCE1};
    double direct[3], albedo[3];
    size_t s;
    int i;
    largest_in(r, DGB_RADIANCE, direct);
    largest_in(r, DGB_ALBEDO, albedo);
    for (s = 0; s < sizeof slots / sizeof slots[0]; ++s) {
        float* e = fixture_image(&r->c, slots[s], 0, 4);
        double most = 0.0;
        fixture_blank_unshaded(&r->c, e, 4);
        for (i = 0; i < 4 * r->c.plan.width * r->c.plan.height; ++i) {
            const double rho = i % 4 < 3 ? albedo[i % 4] * (double)r->params.bounce_damping : 0.0;
            const double bound = i % 4 < 3 ? direct[i % 4] * PI / (1.0 - rho) * (1.0 + 1.0 / 1024.0) : 1.0;
            assert_true(e[i] >= 0.0f && (double)e[i] <= bound);
            most = fmax(most, (double)e[i] / bound);
        }
        free(e);
        if (s == 0) printf("# damping %g: %.3f of the bound\n", (double)r->params.bounce_damping, most);
    }
}

/* With the same taps in every frame each bounce adds something or nothing, never less; all that is stored in codes, of
   which there are not many: it ends, and then no bit changes. */
static void test_room_becomes_stationary(void** state) {
    static const float dampings[] = {1.0f, 0.5f};
    int i, frame;
    (void)state;
    for (i = 0; i < 2; ++i) {
        room r = open_room(dampings[i], 0.0f);
        float *before, *after, *first;
        const size_t size = (size_t)(4 * r.c.plan.width * r.c.plan.height) * sizeof(float);
        run_room(&r);
        first = fixture_image(&r.c, DGB_IRRADIANCE, 0, 4);
        for (frame = 1; frame < 99; ++frame) run_room(&r);
        before = fixture_image(&r.c, DGB_IRRADIANCE, 0, 4);
        run_room(&r);
        after = fixture_image(&r.c, DGB_IRRADIANCE, 0, 4);
        assert_memory_equal(before, after, size);
        assert_memory_not_equal(first, after, size); /* and it is not just that nothing bounces */
        check_room_bound(&r);
        free(first), free(before), free(after);
        close_room(&r);
    }
}

/* Of what is shown: dgb_fallback of the composite snippet, without a probe. */
static double mean_of(const room* r, dgb_slot slot) {
    const int w = r->c.plan.width, h = r->c.plan.height, g = r->c.desc.guard_band;
    float* e = fixture_image(&r->c, slot, 0, 4);
    double sum = 0.0;
    int x, y, k;
    for (y = g; y < h - g; ++y)
        for (x = g; x < w - g; ++x)
            for (k = 0; k < 3; ++k)
                sum += (double)e[4 * (y * w + x) + k] * fmin(2.0 * (double)e[4 * (y * w + x) + 3], 1.0);
    free(e);
    return sum / (3.0 * (w - 2 * g) * (h - 2 * g));
}

static void test_room_settles(void** state) {
    room r = open_room(1.0f, 0.85f);
    double last = 0.0, worst = 0.0;
    int frame;
    (void)state;
    for (frame = 0; frame <= 100; ++frame) {
        run_room(&r);
        if (frame >= 60) {
            const double now = mean_of(&r, DGB_IRRADIANCE);
            if (frame > 60) worst = fmax(worst, fabs(now - last) / now);
            last = now;
        }
    }
    printf("# mean irradiance changes by %.5f a frame at most\n", worst);
    assert_true(worst < 0.01 && worst > 0.0);
    check_room_bound(&r);
    close_room(&r);
}

/* >> long runs */

static void flood(const room* r, float value) { /* history of so much light everywhere */
    static const dgb_slot slots[] = {DGB_IRRADIANCE_MEAN, DGB_IRRADIANCE1_MEAN, DGB_LAST_IRRADIANCE,
                                     DGB_LAST_IRRADIANCE1};
    const GLfloat light[4] = {value, value, value, 1.0f};
    size_t s;
    for (s = 0; s < sizeof slots / sizeof slots[0]; ++s)
        glClearTexImage(dgbgl_texture_name(dgb_get_texture(&r->c, slots[s])), 0, GL_RGBA, GL_FLOAT, light);
}

/* Mean over so many frames. */
static double mean_of_frames(room* r, int frames) {
    double sum = 0.0;
    int frame;
    for (frame = 0; frame < frames; ++frame) {
        run_room(r);
        sum += mean_of(r, DGB_IRRADIANCE) / frames;
    }
    return sum;
}

/* 300 frames; with DGB_FULL=1 (make test-full) 2000. From frame 100 on the mean of 100 frames, or 270, stays within 0.1 %, no object,
   no texture's or buffer's byte and nothing in the process's heap is added, and however much light there was in the beginning, it is
   the same within 1 %. */
static void test_long_run(void** state) {
    static const float floods[] = {0.0f, 100.0f};
    const int windows = getenv("DGB_FULL") ? 6 : 1, frames = windows > 1 ? 270 : 100;
    double means[2], worst = 0.0;
    int i, n;
    (void)state;
    for (i = 0; i < 2; ++i) {
        room r = open_room(1.0f, 0.85f);
        double first;
        size_t bytes, heap;
        int objects;
        run_room(&r), run_room(&r);
        flood(&r, floods[i]);
        for (n = 2; n < 100; ++n) run_room(&r);
        objects = fixture_count_objects(), bytes = fixture_count_bytes(), heap = fixture_count_heap();
        first = mean_of_frames(&r, frames);
        for (n = 0; n < windows; ++n) {
            means[i] = mean_of_frames(&r, frames);
            worst = fmax(worst, fabs(means[i] / first - 1.0));
        }
        assert_int_equal(fixture_count_objects(), objects);
        assert_int_equal(fixture_count_bytes(), bytes);
        /* less than half of the least that malloc hands out, 32 bytes, a frame */
        assert_true(fixture_count_heap() < heap + 16 * (size_t)(frames * (windows + 1)));
        assert_true(objects > 20 && bytes > 100 * 60 * 40); /* they are counted */
        check_room_bound(&r);
        close_room(&r);
    }
    printf("# the mean over frames is off by %.5f at most, from another start by %.5f\n", worst,
           means[1] / means[0] - 1.0);
    assert_true(worst <= 0.001);
    assert_true(fabs(means[1] / means[0] - 1.0) <= 0.01);
}

FIXTURE_CONTEXT(f, 4, 5, false)

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_all_send_the_same),
        cmocka_unit_test(test_radiosity_of_many_bounces),
        cmocka_unit_test(test_white_furnace_stays_finite),
        cmocka_unit_test(test_boost),
        cmocka_unit_test(test_room_becomes_stationary),
        cmocka_unit_test(test_room_settles),
        cmocka_unit_test(test_long_run),
        cmocka_unit_test(test_no_messages),
    };
    return cmocka_run_group_tests(tests, open_context, close_context);
}
