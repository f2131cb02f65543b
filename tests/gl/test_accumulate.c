/* Long averages: that they settle at the mean of what the frames find, from wherever they start, and what limits
   them. */
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

enum { WIDTH = 48, HEIGHT = 32, PIXELS = WIDTH * HEIGHT };

#define ALL (DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY | DGB_EFFECT_BOUNCES | DGB_EFFECT_TEMPORAL)

static fixture f;

/* >> scene: a wall with raised squares that glow, before another wall */

static stage open_stage(uint32_t effects, float velocity) {
    static const float n[3] = {0.0f, 0.0f, 1.0f};
    stage s;
    dgb_desc d;
    int x, y, layer;
    stage_init(&s, WIDTH, HEIGHT, 0);
    s.params = dgb_preset(DGB_PRESET_BALANCED);
    s.params.ao_min_level = s.params.min_level = 0;
    s.params.normal_test = false; /* or squares that all face the eye would send nothing to each other */
    for (y = 0; y < HEIGHT; ++y)
        for (x = 0; x < WIDTH; ++x)
            for (layer = 0; layer < 2; ++layer) {
                const bool raised = ((x / 6 + y / 6) & 1) != 0;
                images_put(&s.m, layer, x, y, layer ? 5.0 : raised ? 3.6 : 4.0, n);
                images_at(&s.m, IMAGE_RADIANCE, layer, x, y)[0] = layer ? 0.25f : raised ? 8.0f : 1.0f;
                images_at(&s.m, IMAGE_RADIANCE, layer, x, y)[1] = 1.0f;
                images_at(&s.m, IMAGE_VELOCITY, layer, x, y)[0] = velocity;
            }
    d = images_desc(&f, &s.m, 0, 2, effects);
    d.estimator = DGB_ESTIMATOR_BITMASK;
    assert_int_equal(dgb_init(&s.c, &d), DGB_OK);
    return s;
}

static void shade(stage* s) { assert_int_equal(stage_shade(s), DGB_OK); }

/* The same value in every texel, as the last frame's. */
static void plant(const stage* s, dgb_slot slot, const float texel[4]) {
    static float texels[PIXELS][4];
    int i;
    for (i = 0; i < PIXELS; ++i) memcpy(texels[i], texel, sizeof texels[i]);
    fixture_put_image(&s->c, slot, 4, texels[0]);
}

/* >> what a long average comes to */

typedef struct settled {
    double open[PIXELS], light[PIXELS];         /* the averages; light as it arrives: times its confidence */
    double raw_open[PIXELS], raw_light[PIXELS]; /* means of what the second half of the frames found */
} settled;

static void settle(settled* out, int frames, const float start[4], const float light[4]) {
    const int averaged = frames / 2; /* the last */
    stage s = open_stage(DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY | DGB_EFFECT_TEMPORAL, 0.0f);
    float *open, *mean;
    int frame, i;
    memset(out, 0, sizeof *out);
    s.params.history_weight = 0.98f;
    shade(&s);
    if (start) plant(&s, DGB_FRAMES, start), plant(&s, DGB_IRRADIANCE_MEAN, light);
    for (frame = 0; frame < frames; ++frame) {
        shade(&s);
        if (frame < frames - averaged) continue;
        open = fixture_image(&s.c, DGB_AO_RAW, 0, 1);
        mean = fixture_image(&s.c, DGB_IRRADIANCE_RAW, 0, 4);
        for (i = 0; i < PIXELS; ++i) {
            out->raw_open[i] += (double)open[i] / averaged;
            out->raw_light[i] += (double)mean[4 * i] * (double)mean[4 * i + 3] / averaged;
        }
        free(open), free(mean);
    }
    open = fixture_image(&s.c, DGB_FRAMES, 0, 4);
    mean = fixture_image(&s.c, DGB_IRRADIANCE_MEAN, 0, 4);
    for (i = 0; i < PIXELS; ++i) {
        out->open[i] = (double)open[4 * i];
        out->light[i] = (double)mean[4 * i] * (double)mean[4 * i + 3];
    }
    free(open), free(mean);
    stage_close(&s);
}

static double mean_of(const double* values) {
    double sum = 0.0;
    int i;
    for (i = 0; i < PIXELS; ++i) sum += values[i];
    return sum / PIXELS;
}

/* Root of the mean square difference, as a share of the mean. */
static double apart(const double* a, const double* b) {
    double sum = 0.0;
    int i;
    for (i = 0; i < PIXELS; ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
    return sqrt(sum / PIXELS) / mean_of(b);
}

/* 0.98^400 is 3e-4: of the start, three times as bright as the picture at most, 1e-3 remains. The image's mean, of 1536
   pixels with an average of 100 frames each, is known to 2e-3; what a store rounds away, were it always the same, would
   be 1.2 %. */
static void test_any_start_settles(void** state) {
    static const float dark[4] = {0.0f, 1000.0f, 1000.0f, 0.0f}, none[4] = {0.0f, 0.0f, 0.0f, 0.0f};
    static const float open[4] = {1.0f, 1000.0f, 1000.0f, 0.0f}, bright[4] = {20.0f, 20.0f, 0.0f, 1.0f};
    static settled fresh, low, high;
    double off;
    (void)state;
    settle(&fresh, 400, NULL, NULL);
    settle(&low, 400, dark, none);
    settle(&high, 400, open, bright);
    off = mean_of(fresh.open) / mean_of(fresh.raw_open) - 1.0;
    print_message("visibility %.4f, off %+.4f; %.4f and %.4f from other starts\n", mean_of(fresh.open), off,
                  apart(low.open, fresh.open), apart(high.open, fresh.open));
    assert_true(fabs(off) < 0.003);
    assert_true(apart(low.open, fresh.open) < 0.01 && apart(high.open, fresh.open) < 0.01);
    off = mean_of(fresh.light) / mean_of(fresh.raw_light) - 1.0;
    print_message("irradiance %.4f, off %+.4f; %.4f and %.4f from other starts\n", mean_of(fresh.light), off,
                  apart(low.light, fresh.light), apart(high.light, fresh.light));
    assert_true(fabs(off) < 0.005);
    assert_true(apart(low.light, fresh.light) < 0.01 && apart(high.light, fresh.light) < 0.01);
}

/* Where no frame has found any light for long, the first that does shows it, though with little confidence. */
static void test_light_that_comes_late(void** state) {
    static const float frames[4] = {1.0f, 1000.0f, 1000.0f, 1000.0f}, none[4] = {0.0f, 0.0f, 0.0f, 0.0f};
    stage s = open_stage(DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY | DGB_EFFECT_TEMPORAL, 0.0f);
    float *raw, *mean;
    int i, k, lit = 0;
    (void)state;
    s.params.history_weight = 0.999f;
    shade(&s);
    plant(&s, DGB_FRAMES, frames), plant(&s, DGB_IRRADIANCE_MEAN, none);
    shade(&s);
    raw = fixture_image(&s.c, DGB_IRRADIANCE_RAW, 0, 4);
    mean = fixture_image(&s.c, DGB_IRRADIANCE_MEAN, 0, 4);
    for (i = 0; i < PIXELS; ++i) {
        if (raw[4 * i + 3] < 0.01f) continue; /* so little that of a thousandth halves do not tell more than a tenth */
        ++lit;
        assert_true(fabsf(mean[4 * i + 3] / raw[4 * i + 3] - 0.001f) < 1e-4f);
        for (k = 0; k < 3; ++k) /* stored twice */
            assert_true(fabs((double)mean[4 * i + k] - (double)raw[4 * i + k]) <=
                        2.0 * tally_half_ulp((double)raw[4 * i + k]));
    }
    assert_true(lit > PIXELS / 4);
    free(raw), free(mean);
    stage_close(&s);
}

/* Frames are counted to 1000, which is more than the greatest weight takes. */
static void test_most_frames(void** state) {
    static const float near_end[4] = {1.0f, 998.0f, 998.0f, 998.0f};
    stage s = open_stage(ALL, 0.0f);
    int frame, i, k;
    (void)state;
    shade(&s);
    plant(&s, DGB_FRAMES, near_end);
    for (frame = 0; frame < 4; ++frame) {
        const float expected = frame < 2 ? 999.0f + (float)frame : 1000.0f;
        float* frames;
        shade(&s);
        frames = fixture_image(&s.c, DGB_FRAMES, 0, 4);
        for (i = 0; i < PIXELS; ++i)
            for (k = 1; k < 4; ++k) assert_true(frames[4 * i + k] == expected);
        free(frames);
    }
    stage_close(&s);
}

/* >> limits */

static const float planted[4] = {3.0f, 0.5f, 0.0f, 0.75f}, planted_frames[4] = {0.3f, 9.0f, 9.0f, 9.0f};

/* One value of one pixel: last frame's average of nine frames, this frame's sample, and the 3 x 3 samples. */
typedef struct limited {
    double value[4], past[4]; /* irradiance times confidence, confidence; or the visibility four times */
} limited;

static void sample_at(const float* raw, int channels, int i, double sample[4]) {
    int k;
    for (k = 0; k < 4; ++k)
        sample[k] = channels == 1 ? (double)raw[i] : (double)raw[4 * i + k] * (k < 3 ? (double)raw[4 * i + 3] : 1.0);
}

static double brightest(const double rgb[4]) { return fmax(rgb[0], fmax(rgb[1], rgb[2])); }

static int clamp(int x, int high) { return x < 0 ? 0 : x > high ? high : x; }

/* As dgb_params says it, in double precision. */
static limited limit(const stage* s, const float* raw, int channels, int x, int y, double moved) {
    double sum[4] = {0.0}, squares[4] = {0.0}, others[4], most;
    limited l;
    int i, k;
    sample_at(raw, channels, y * WIDTH + x, l.value);
    for (i = 0; i < 9; ++i) {
        double sample[4];
        sample_at(raw, channels, clamp(y + i / 3 - 1, HEIGHT - 1) * WIDTH + clamp(x + i % 3 - 1, WIDTH - 1), sample);
        for (k = 0; k < 4; ++k) sum[k] += sample[k], squares[k] += sample[k] * sample[k];
    }
    for (k = 0; k < 4; ++k) {
        const double mean = sum[k] / 9.0, deviation = sqrt(fmax(squares[k] / 9.0 - mean * mean, 0.0));
        const double side = (double)s->params.history_clamp * deviation / fmin(fmax(moved, 1e-3), 1.0);
        const double past = channels == 1 ? 0.3 : (double)planted[k] * (k < 3 ? (double)planted[3] : 1.0);
        const bool bounded = s->params.history_clamp > 0.0f && moved > 0.0;
        l.past[k] = bounded ? fmin(fmax(past, mean - side), mean + side) : past;
        others[k] = (sum[k] - l.value[k]) / 8.0;
    }
    most = fmax(brightest(others), brightest(l.past)) * (double)s->params.sample_clamp;
    if (s->params.sample_clamp > 0.0f && channels == 4 && brightest(l.value) > most)
        for (i = 0, most /= brightest(l.value); i < 3; ++i) l.value[i] *= most;
    return l;
}

/* Wherever history is known, which near the squares' borders it is not once they move. Stored as halves, with sums of
   nine and differences of squares behind them: 1e-3 where a deviation is much less than its mean. */
static void compare_limited(const stage* s, dgb_slot raw_slot, dgb_slot mean_slot, int counter, double moved) {
    const int channels = raw_slot == DGB_AO_RAW ? 1 : 4;
    float *raw = fixture_image(&s->c, raw_slot, 0, channels), *mean = fixture_image(&s->c, mean_slot, 0, 4),
          *frames = fixture_image(&s->c, DGB_FRAMES, 0, 4);
    int x, y, k, compared = 0;
    for (y = 0; y < HEIGHT; ++y)
        for (x = 0; x < WIDTH; ++x) {
            const int i = y * WIDTH + x;
            const limited l = limit(s, raw, channels, x, y, moved);
            const double weight = fmin(0.9, (double)s->params.history_weight);
            double confidence;
            if (frames[4 * i + counter] != 10.0f) continue;
            confidence = l.value[3] + (l.past[3] - l.value[3]) * weight;
            for (k = 0; k < channels; ++k) {
                double expected = l.value[k] + (l.past[k] - l.value[k]) * weight;
                if (channels == 4 && k < 3) expected /= confidence;
                if (fabs((double)mean[4 * i + k] - expected) > 1.1 * tally_half_ulp(expected) + 1e-3 * expected)
                    fail_msg("%s at %d, %d, channel %d: %g in place of %g", dgb_slot_name(mean_slot), x, y, k,
                             (double)mean[4 * i + k], expected);
            }
            ++compared;
        }
    assert_true(compared > PIXELS / 2);
    free(raw), free(mean), free(frames);
}

static void test_limits(void** state) {
    static const float moves[] = {0.0f, 0.25f, 1.0f, 2.0f};
    static const float limits[][2] = {{0.0f, 0.0f}, {1.0f, 0.0f}, {2.5f, 0.0f}, {0.0f, 0.5f}, {1.5f, 1.5f}};
    size_t move, i;
    (void)state;
    for (move = 0; move < sizeof moves / sizeof moves[0]; ++move)
        for (i = 0; i < sizeof limits / sizeof limits[0]; ++i) {
            stage s = open_stage(ALL, moves[move]);
            shade(&s);
            plant(&s, DGB_FRAMES, planted_frames);
            plant(&s, DGB_IRRADIANCE_MEAN, planted);
            plant(&s, DGB_IRRADIANCE1_MEAN, planted);
            s.params.history_clamp = limits[i][0];
            s.params.sample_clamp = limits[i][1];
            shade(&s);
            compare_limited(&s, DGB_AO_RAW, DGB_FRAMES, 1, (double)moves[move]);
            compare_limited(&s, DGB_IRRADIANCE_RAW, DGB_IRRADIANCE_MEAN, 2, (double)moves[move]);
            compare_limited(&s, DGB_IRRADIANCE1_RAW, DGB_IRRADIANCE1_MEAN, 3, (double)moves[move]);
            stage_close(&s);
        }
}

/* Without limits the other program does not run: the same to the last bit as with limits that nothing reaches. */
static void test_wide_limits_change_nothing(void** state) {
    stage a = open_stage(ALL, 1.0f), b = open_stage(ALL, 1.0f);
    const dgb_slot slots[] = {DGB_FRAMES, DGB_IRRADIANCE_MEAN, DGB_IRRADIANCE1_MEAN};
    int frame, slot;
    (void)state;
    b.params.sample_clamp = 1e30f;
    for (frame = 0; frame < 3; ++frame) shade(&a), shade(&b);
    for (slot = 0; slot < 3; ++slot) {
        float *x = fixture_image(&a.c, slots[slot], 0, 4), *y = fixture_image(&b.c, slots[slot], 0, 4);
        assert_memory_equal(x, y, sizeof *x * 4 * PIXELS);
        free(x), free(y);
    }
    stage_close(&a);
    stage_close(&b);
}

FIXTURE_CONTEXT(f, 4, 5, false)

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_any_start_settles),
        cmocka_unit_test(test_light_that_comes_late),
        cmocka_unit_test(test_most_frames),
        cmocka_unit_test(test_limits),
        cmocka_unit_test(test_wide_limits_change_nothing),
        cmocka_unit_test(test_no_messages),
    };
    return cmocka_run_group_tests_name("accumulate", tests, open_context, close_context);
}
