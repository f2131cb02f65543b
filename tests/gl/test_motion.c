/* Surfaces that move, come into view and leave it: what the temporal filter keeps of them. Layers made up texel by
   texel, so that every count of frames is known beforehand. */
#include "gl_images.h"
#include "numbers.h"
#include "tally.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { WIDTH = 64, HEIGHT = 40, BLOCKER = 16 };

#define ALL (DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY | DGB_EFFECT_BOUNCES | DGB_EFFECT_TEMPORAL)

static fixture f;

static const float towards_eye[3] = {0.0f, 0.0f, 1.0f};
static const double wall = 6.0, blocker = 3.0; /* metres away */

/* >> what a context makes of one frame */

static stage open_stage(int width, int height, int guard, int layers, uint32_t effects) {
    stage s;
    dgb_desc d;
    stage_init(&s, width, height, guard);
    d = images_desc(&f, &s.m, guard, layers, effects);
    assert_int_equal(dgb_init(&s.c, &d), DGB_OK);
    return s;
}

static void shade(stage* s) { assert_int_equal(stage_shade(s), DGB_OK); }

static float* read_image(const stage* s, dgb_slot slot) { return fixture_image(&s->c, slot, 0, 4); }

static void write_image(const stage* s, dgb_slot slot, const float* texels) {
    fixture_put_image(&s->c, slot, 4, texels);
}

static bool is_blocker(int x, int left) { return x >= left && x < left + BLOCKER; }

/* A blocker before a wall; it stands at `left` and came from `left - moved`. */
static void put_blocker(stage* s, int left, float moved) {
    int x, y;
    for (y = 0; y < s->m.height; ++y)
        for (x = 0; x < s->m.width; ++x) {
            const bool front = is_blocker(x, left);
            images_put(&s->m, 0, x, y, front ? blocker : wall, towards_eye);
            images_put(&s->m, 1, x, y, wall, towards_eye);
            if (!front) *images_at(&s->m, IMAGE_DEPTH, 1, x, y) = 0.0f; /* the wall is in front there */
            if (front) *images_at(&s->m, IMAGE_VELOCITY, 0, x, y) = moved;
        }
}

/* >> what comes into view */

/* The blocker goes on by 8 pixels every frame. The wall that it uncovers restarts, or, where the second layer has kept
   it, goes on; everything else was in view and goes on in either case. */
static void check_uncovered(int layers) {
    stage s = open_stage(WIDTH, HEIGHT, 0, layers, ALL);
    int frame, x, y, uncovered = 0;
    for (frame = 0; frame < 5; ++frame) {
        const int left = 8 * frame;
        float* frames;
        put_blocker(&s, left, frame ? 8.0f : 0.0f);
        shade(&s);
        frames = read_image(&s, DGB_FRAMES);
        for (y = 0; y < HEIGHT; ++y)
            for (x = 0; x < WIDTH; ++x) {
                const float* texel = frames + 4 * (y * WIDTH + x);
                const bool before = frame > 0 && is_blocker(x, left - 8), now = is_blocker(x, left);
                /* frames that one layer has seen what it shows here without a break */
                const int seen = now || x >= left ? frame + 1 : frame - x / 8;
                uncovered += before && !now;
                assert_true(texel[1] == (float)seen); /* visibility is the first layer's alone */
                assert_true(texel[2] == (float)(layers > 1 ? frame + 1 : seen));
                if (layers > 1) assert_true(texel[3] == (now ? (float)(frame + 1) : 0.0f));
            }
        free(frames);
    }
    assert_true(uncovered == 4 * 8 * HEIGHT);
    stage_close(&s);
}

static void test_uncovered(void** state) {
    (void)state;
    check_uncovered(1);
    check_uncovered(2);
}

/* What the wall had while it stood behind is what it has when it comes to light: the second layer's average, weighed as
   n to 1. It is no other light: the blocker's own is a thousand times as strong. */
static void test_second_layer_hands_on(void** state) {
    static const float of_blocker[4] = {1000.0f, 2000.0f, 3000.0f, 1.0f}, of_wall[4] = {1.0f, 2.0f, 0.5f, 0.75f};
    stage s = open_stage(WIDTH, HEIGHT, 0, 2, ALL);
    float *image, *raw, *mean;
    int x, y, k, count = 0;
    (void)state;
    put_blocker(&s, 16, 0.0f);
    shade(&s);
    shade(&s);
    image = read_image(&s, DGB_IRRADIANCE_MEAN);
    for (x = 0; x < 4 * WIDTH * HEIGHT; ++x) image[x] = (is_blocker(x / 4 % WIDTH, 16) ? of_blocker : of_wall)[x % 4];
    write_image(&s, DGB_IRRADIANCE_MEAN, image);
    for (x = 0; x < 4 * WIDTH * HEIGHT; ++x) image[x] = of_wall[x % 4];
    write_image(&s, DGB_IRRADIANCE1_MEAN, image);
    free(image);
    put_blocker(&s, 24, 8.0f);
    shade(&s);
    raw = read_image(&s, DGB_IRRADIANCE_RAW), mean = read_image(&s, DGB_IRRADIANCE_MEAN);
    for (y = 0; y < HEIGHT; ++y)
        for (x = 0; x < WIDTH; ++x)
            for (k = 0; k < 4; ++k) {
                const int at = 4 * (y * WIDTH + x) + k;
                const float* old = is_blocker(x, 24) ? of_blocker : of_wall;
                /* two frames and one; irradiance counts as much as its confidence */
                const double a = 2.0 * (k < 3 ? (double)old[3] : 1.0), b = k < 3 ? (double)raw[at - k + 3] : 1.0;
                const double expected = (a * (double)old[k] + b * (double)raw[at]) / (k < 3 ? a + b : 3.0);
                assert_true(fabs((double)mean[at] - expected) <= 2.0 * tally_half_ulp(expected));
                count += x >= 16 && x < 24;
            }
    assert_int_equal(count, 4 * 8 * HEIGHT);
    free(raw), free(mean);
    stage_close(&s);
}

/* >> no ghosts */

/* Blocker and wall pan by parts of pixels, so that every history is a mix of four texels, of which those along the edge
   show the other surface. No light is gathered (nothing sends), so an average is all history: at most what that surface
   had. */
static void check_no_ghost(float pan, bool blocker_is_bright) {
    stage s = open_stage(WIDTH, HEIGHT, 0, 1, DGB_EFFECT_RADIOSITY | DGB_EFFECT_TEMPORAL);
    float *image, *mean;
    int x, y, i, edge = 0;
    double on_wall = 0.0, on_blocker = 1e30;
    put_blocker(&s, 16, 0.0f);
    shade(&s);
    image = read_image(&s, DGB_IRRADIANCE_MEAN);
    for (i = 0; i < 4 * WIDTH * HEIGHT; ++i)
        image[i] = i % 4 == 3 ? 1.0f : is_blocker(i / 4 % WIDTH, 16) == blocker_is_bright ? 1000.0f : 1.0f;
    write_image(&s, DGB_IRRADIANCE_MEAN, image);
    free(image);
    put_blocker(&s, 16, 0.0f);
    for (i = 0; i < WIDTH * HEIGHT; ++i)
        s.m.texels[IMAGE_VELOCITY][0][3 * i] = pan, s.m.texels[IMAGE_VELOCITY][0][3 * i + 1] = 0.25f;
    shade(&s);
    mean = read_image(&s, DGB_IRRADIANCE_MEAN);
    for (y = 2; y < HEIGHT - 2; ++y)
        for (x = 2; x < WIDTH - 2; ++x) {
            const double e = (double)mean[4 * (y * WIDTH + x)];
            edge += is_blocker(x, 16) != is_blocker(x + (pan > 0.0f ? -1 : 1), 16);
            if (is_blocker(x, 16) != blocker_is_bright) on_wall = e > on_wall ? e : on_wall;
            if (is_blocker(x, 16) == blocker_is_bright && e > 0.0) on_blocker = e < on_blocker ? e : on_blocker;
        }
    printf("# pan %g: 1 becomes %g at most, 1000 becomes %g at least\n", (double)pan, on_wall, on_blocker);
    assert_true(edge >= 2 * (HEIGHT - 4));
    /* a frame whose taps find nothing has no confidence, so that it says nothing */
    assert_true(on_wall <= 1.0 + 1.0 / 1024.0 && on_wall > 0.9);
    assert_true(on_blocker >= 1000.0 * (1.0 - 1.0 / 1024.0));
    free(mean);
    stage_close(&s);
}

static void test_no_ghost(void** state) {
    static const float pans[] = {0.5f, -0.5f, 0.3f, -0.9f, 0.97f};
    size_t i;
    (void)state;
    for (i = 0; i < sizeof pans / sizeof pans[0]; ++i) {
        check_no_ghost(pans[i], true);
        check_no_ghost(pans[i], false);
    }
}

/* >> the border of what was shaded */

static void put_wall(stage* s, float vx, float vy) {
    int x, y;
    for (y = 0; y < s->m.height; ++y)
        for (x = 0; x < s->m.width; ++x) {
            images_put(&s->m, 0, x, y, wall, towards_eye);
            images_at(&s->m, IMAGE_VELOCITY, 0, x, y)[0] = vx;
            images_at(&s->m, IMAGE_VELOCITY, 0, x, y)[1] = vy;
        }
}

/* The camera pans along a wall: what comes in at the border has never been shaded. */
static void check_pan(int guard, float fraction, float vx, float vy) {
    stage s = open_stage(WIDTH, HEIGHT, guard, 1, ALL);
    const int inset = guard - (int)floorf((float)guard * fraction + 0.5f), low = inset;
    const float high[2] = {(float)(WIDTH - inset), (float)(HEIGHT - inset)};
    /* pixels that a metre across covers at the wall */
    const float scale = 0.5f * (float)(HEIGHT - 2 * guard) * s.view.projection[5] / (float)wall;
    float* frames;
    int x, y, fresh = 0;
    s.params.guard_fraction = fraction;
    put_wall(&s, 0.0f, 0.0f);
    shade(&s);
    s.view.view[12] += vx / scale, s.view.view[13] += vy / scale; /* the world moves as the velocity says */
    put_wall(&s, vx, vy);
    shade(&s);
    frames = read_image(&s, DGB_FRAMES);
    for (y = low; y < HEIGHT - low; ++y)
        for (x = low; x < WIDTH - low; ++x) {
            const float then[2] = {(float)x + 0.5f - vx, (float)y + 0.5f - vy};
            const bool known = then[0] >= (float)low && then[1] >= (float)low && then[0] < high[0] && then[1] < high[1];
            assert_true(fabsf(frames[4 * (y * WIDTH + x) + 2] - (known ? 2.0f : 1.0f)) < 0.002f);
            fresh += !known;
        }
    assert_true(fresh > 0);
    free(frames);
    stage_close(&s);
}

static void test_border(void** state) {
    (void)state;
    check_pan(0, 0.0f, 5.25f, 0.0f);
    check_pan(0, 0.0f, -5.25f, 0.75f);
    check_pan(6, 0.5f, 3.5f, -2.25f);
    check_pan(6, 1.0f, -0.6f, 9.0f);
    check_pan(6, 0.0f, 0.0f, -7.9f);
}

/* What was behind the eye last frame has no place there, though its velocity says it was in the image. */
static void test_behind_the_last_eye(void** state) {
    static const float light[3] = {1.0f, 1.0f, 1.0f}, white[3] = {1.0f, 1.0f, 1.0f};
    stage s = open_stage(WIDTH, HEIGHT, 0, 1, ALL);
    float *frames, *b, *lit;
    int frame, i;
    (void)state;
    for (frame = 0; frame < 2; ++frame) {
        put_wall(&s, 0.0f, 0.0f);
        images_fill(&s.m, IMAGE_RADIANCE, light), images_fill(&s.m, IMAGE_ALBEDO, white);
        if (frame) s.view.view[14] -= 10.0f; /* ten metres back */
        shade(&s);
        if (frame) continue;
        lit = read_image(&s, DGB_IRRADIANCE);
        for (i = 0; i < 4 * WIDTH * HEIGHT; ++i) lit[i] = 1.0f; /* light that would be sent on */
        write_image(&s, DGB_IRRADIANCE, lit);
        free(lit);
    }
    frames = read_image(&s, DGB_FRAMES);
    b = fixture_image(&s.c, DGB_B0, 0, 3);
    for (i = 0; i < WIDTH * HEIGHT; ++i) {
        assert_true(frames[4 * i + 1] == 1.0f && frames[4 * i + 2] == 1.0f);
        assert_true(b[3 * i] == 1.0f);
    }
    free(frames), free(b);
    stage_close(&s);
}

/* >> what an engine may hand over */

/* NaN, infinite or absurd velocities: no history there, and nothing else changes. Albedo and radiance that are no
   numbers are black. */
static void check_odd_input(image_kind kind, float odd) {
    stage clean = open_stage(WIDTH, HEIGHT, 0, 2, ALL), sick = open_stage(WIDTH, HEIGHT, 0, 2, ALL);
    static const float grey[3] = {0.5f, 0.5f, 0.5f}, light[3] = {1.0f, 2.0f, 3.0f};
    float *a, *b, *frames;
    int frame, x, y, k;
    for (frame = 0; frame < 4; ++frame) {
        put_blocker(&clean, 16, 0.0f), put_blocker(&sick, 16, 0.0f);
        images_fill(&clean.m, IMAGE_ALBEDO, grey), images_fill(&sick.m, IMAGE_ALBEDO, grey);
        images_fill(&clean.m, IMAGE_RADIANCE, light), images_fill(&sick.m, IMAGE_RADIANCE, light);
        for (y = 10; y < 14; ++y)
            for (x = 20; x < 24 && frame == 2; ++x)
                for (k = 0; k < 3; ++k) {
                    images_at(&sick.m, kind, 0, x, y)[k] = odd;
                    if (kind != IMAGE_VELOCITY) images_at(&clean.m, kind, 0, x, y)[k] = 0.0f;
                }
        shade(&clean), shade(&sick);
        a = read_image(&clean, DGB_IRRADIANCE_MEAN), b = read_image(&sick, DGB_IRRADIANCE_MEAN);
        frames = read_image(&sick, DGB_FRAMES);
        for (y = 0; y < HEIGHT; ++y)
            for (x = 0; x < WIDTH; ++x) {
                const bool here = kind == IMAGE_VELOCITY && frame >= 2 && x >= 20 && x < 24 && y >= 10 && y < 14;
                const int at = 4 * (y * WIDTH + x);
                for (k = 0; k < 4; ++k) assert_true(b[at + k] >= 0.0f && b[at + k] <= DGB_MAX_RADIANCE);
                assert_true(frames[at + 2] == (float)(here ? frame - 1 : frame + 1));
                /* with the velocity the light goes that the surface sends on: its neighbours may differ from then on */
                if (kind != IMAGE_VELOCITY) assert_memory_equal(a + at, b + at, 4 * sizeof(float));
            }
        free(a), free(b), free(frames);
        a = fixture_image(&clean.c, DGB_B0, 0, 3);
        b = fixture_image(&sick.c, DGB_B0, 0, 3);
        if (kind != IMAGE_VELOCITY) assert_memory_equal(a, b, 3 * WIDTH * HEIGHT * sizeof(float));
        free(a), free(b);
    }
    stage_close(&clean), stage_close(&sick);
}

static void test_odd_input(void** state) {
    static const float odd[] = {NAN, INFINITY, -INFINITY, 3e38f, -3e38f};
    size_t i;
    (void)state;
    for (i = 0; i < sizeof odd / sizeof odd[0]; ++i) check_odd_input(IMAGE_VELOCITY, odd[i]);
    check_odd_input(IMAGE_ALBEDO, NAN);
    check_odd_input(IMAGE_ALBEDO, -1.0f);
    check_odd_input(IMAGE_RADIANCE, NAN);
    check_odd_input(IMAGE_RADIANCE, -INFINITY);
}

static uint32_t random_state = 1u;

static void check_in_range(const stage* s, dgb_slot slot, float high, float high_alpha) {
    float* image = read_image(s, slot);
    int i;
    for (i = 0; i < 4 * s->m.width * s->m.height; ++i)
        assert_true(image[i] >= 0.0f && image[i] <= (i % 4 == 3 ? high_alpha : high)); /* and no NaN */
    free(image);
}

/* Whatever an engine's textures hold, frame after frame: no NaN, nothing infinite, nothing out of range. Depth alone is
   reasonable in every other frame, or there would hardly be a surface. */
static void test_any_input(void** state) {
    int layers, frame, kind, l, i;
    (void)state;
    for (layers = 1; layers <= 2; ++layers) {
        stage s = open_stage(WIDTH, HEIGHT, 0, layers, ALL);
        for (frame = 0; frame < 8; ++frame) {
            put_blocker(&s, 16, 0.0f);
            for (kind = frame % 2 ? IMAGE_DEPTH : IMAGE_NORMAL; kind < IMAGE_KINDS; ++kind)
                for (l = 0; l < 2; ++l)
                    for (i = 0; i < (kind == IMAGE_DEPTH ? 1 : 3) * WIDTH * HEIGHT; ++i)
                        if (lcg_bits(&random_state) & 0x10000u) s.m.texels[kind][l][i] = lcg_pattern(&random_state);
            s.params = dgb_preset((dgb_preset_id)(frame % DGB_PRESET_COUNT));
            shade(&s);
            check_in_range(&s, DGB_IRRADIANCE_MEAN, DGB_MAX_RADIANCE, 1.0f);
            check_in_range(&s, DGB_IRRADIANCE, DGB_MAX_RADIANCE, 1.0f);
            check_in_range(&s, DGB_FRAMES, 64.0f, 64.0f);
            check_in_range(&s, DGB_AO, 1.0f, 1.0f);
            if (layers == 1) continue;
            check_in_range(&s, DGB_IRRADIANCE1_MEAN, DGB_MAX_RADIANCE, 1.0f);
            check_in_range(&s, DGB_IRRADIANCE1, DGB_MAX_RADIANCE, 1.0f);
        }
        stage_close(&s);
    }
}

FIXTURE_CONTEXT(f, 4, 5, false)

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_uncovered),
        cmocka_unit_test(test_second_layer_hands_on),
        cmocka_unit_test(test_no_ghost),
        cmocka_unit_test(test_border),
        cmocka_unit_test(test_behind_the_last_eye),
        cmocka_unit_test(test_odd_input),
        cmocka_unit_test(test_any_input),
        cmocka_unit_test(test_no_messages),
    };
    return cmocka_run_group_tests(tests, open_context, close_context);
}
