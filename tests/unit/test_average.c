/* Averages over very many frames: one pixel of the temporal filter (shaders_embedded/55_temporal.glsl), in the
   shader's floats and stored as it stores. What it converges to, from wherever it starts, and that it stays there. */

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

#ifdef __OPTIMIZE__
enum { LONG_RUN = 1000000 }; /* frames */
#else
enum { LONG_RUN = 200000 }; /* with sanitizers */
#endif

/* >> the filter of one pixel */

typedef enum store { DITHERED, NEAREST, TRUNCATED } store;

/* One channel of irradiance and its confidence, or, with confidence 1 in every frame, a visibility; and the frames in
   it. */
typedef struct average {
    float light, confidence, frames;
} average;

typedef struct sample {
    float light, confidence;
} sample;

static float stored(store s, float x, float u) {
    uint16_t half;
    if (s == DITHERED) return dgb_dithered(x, u);
    half = dgb_half_from_float(x);
    if (s == TRUNCATED && dgb_half_to_float(half) > x) --half;
    return dgb_half_to_float(half);
}

static float mixed(float x, float y, float share) { return x * (1.0f - share) + y * share; }

static float wrapped(float x) { return x < 1.0f ? x : x - 1.0f; }

/* most: of the weight of history. */
static void add_frame(average* a, sample present, float most, store s, int frame) {
    const float frames = dgb_storable(a->frames), share = fminf(frames / (frames + 1.0f), most);
    const float known = fminf(dgb_storable(a->confidence), 1.0f);
    const float weighed = mixed(present.light * present.confidence, dgb_storable(a->light) * known, share);
    const float confidence = mixed(present.confidence, known, share);
    float u[2];
    dgb_pixel_pair(7, 5, frame, u);
    a->light = stored(s, dgb_storable(confidence > 0.0f ? weighed / confidence : 0.0f), u[0]);
    a->confidence = stored(s, confidence, wrapped(u[1] + 0.5f));
    a->frames = fminf(frames + 1.0f, 1000.0f);
}

/* >> what the frames find */

typedef enum input {
    CONSTANT, /* the mean, with confidence 1: so is a visibility */
    FAINT,    /* with the confidence of one tap in 14 */
    NOISY,    /* up to as far from the mean as it is from the nearer of 0 and 64512 */
    RARE      /* the same; two frames in three find nothing, the others one to four taps in 14 */
} input;

static float random_share(uint32_t* seed) { return (float)lcg_unit(seed); }

static sample sample_of(input kind, float mean, uint32_t* seed) {
    sample s = {mean, kind == FAINT ? 1.0f / 14.0f : 1.0f};
    if (kind < NOISY) return s;
    s.light += fminf(mean, DGB_MAX_RADIANCE - mean) * (2.0f * random_share(seed) - 1.0f);
    if (kind == RARE) s.confidence = random_share(seed) < 2.0f / 3.0f ? 0.0f : ceilf(4.0f * random_share(seed)) / 14.0f;
    return s;
}

/* >> long runs */

typedef struct window {     /* of frames */
    double found, averaged; /* mean light, weighed by the confidence: of the samples, of the averages */
    double least, most;     /* of the averages */
} window;

typedef struct run {
    average a;
    input kind;
    float mean, most;
    store how;
    int frame;
    uint32_t seed;
} run;

static window run_frames(run* r, int frames) {
    window w = {0.0, 0.0, DBL_MAX, 0.0};
    double samples = 0.0, averages = 0.0;
    int i;
    for (i = 0; i < frames; ++i) {
        const sample s = sample_of(r->kind, r->mean, &r->seed);
        add_frame(&r->a, s, r->most, r->how, r->frame++);
        w.found += (double)s.light * (double)s.confidence;
        w.averaged += (double)r->a.light * (double)r->a.confidence;
        samples += (double)s.confidence;
        averages += (double)r->a.confidence;
        w.least = fmin(w.least, (double)r->a.light);
        w.most = fmax(w.most, (double)r->a.light);
    }
    w.found /= samples;
    w.averaged /= averages;
    return w;
}

static run run_of(input kind, float mean, float most, store how) {
    const run r = {{0.0f, 0.0f, 0.0f}, kind, mean, most, how, 0, 1u};
    return r;
}

/* Frames after which nothing is left of the farthest start, 64512 to 1e-4: 27 times as many as the average holds take
   it to a thousandth of the mean; three more where its confidence was 14 times the samples'; as many again for the
   last halves, between which roundings hold it up. */
static int settling(float most) { return 100 + (int)(60.0f / (1.0f - most)); }

static const float weights[] = {0.5f, 0.85f, 0.95f, 0.98f, 0.999f};
static const float means[] = {1e-4f, 0.01f, 0.7f, 300.0f, 6e4f};

enum { WEIGHTS = sizeof weights / sizeof weights[0], MEANS = sizeof means / sizeof means[0] };

static void for_each(void (*check)(input kind, float mean, float most), input first, input last) {
    int kind, w, m;
    for (kind = (int)first; kind <= (int)last; ++kind)
        for (w = 0; w < WEIGHTS; ++w)
            for (m = 0; m < MEANS; ++m) check((input)kind, means[m], weights[w]);
}

/* Once settled it is one of the two halves around the mean, in every frame. */
static void check_halves_around(const run* r, const window* w) {
    const double mean = (double)r->mean;
    int exponent;
    double step, low;
    (void)frexp(mean, &exponent);
    step = ldexp(1.0, exponent - 11);
    low = floor(mean / step) * step;
    if (w->least < low || w->most > low + step)
        fail_msg("input %d, weight %g: %.9g to %.9g about %.9g", (int)r->kind, (double)r->most, w->least, w->most,
                 mean);
}

/* On average half a step off at most: 5e-4 of the mean. */
static void check_stays(input kind, float mean, float most) {
    run r = run_of(kind, mean, most, DITHERED);
    window w;
    (void)run_frames(&r, settling(most));
    w = run_frames(&r, LONG_RUN - r.frame);
    check_halves_around(&r, &w);
    assert_true(fabs(w.averaged / (double)mean - 1.0) <= 5e-4);
}

static void test_constant_light_stays(void** state) {
    (void)state;
    for_each(check_stays, CONSTANT, FAINT);
}

/* Dithering is off by some 0.4 of a step a frame, a step 1e-3 of the mean at most. At a weight of 0.999 that adds up
   to 6e-4 in the mean of half a million frames, and to 3e-4 in that of four pixels; what was there before the frames
   is a tenth of it. */
static void check_drift(input kind, float mean, float most) {
    const int pixels = most > 0.99f ? 4 : 1;
    double off[2] = {0.0, 0.0};
    int pixel, i;
    for (pixel = 0; pixel < pixels; ++pixel) {
        run r = run_of(kind, mean, most, DITHERED);
        r.seed += (uint32_t)pixel;
        (void)run_frames(&r, settling(most));
        for (i = 0; i < 2; ++i) {
            const window w = run_frames(&r, (LONG_RUN - r.frame) / (2 - i));
            off[i] += (w.averaged / w.found - 1.0) / pixels;
        }
    }
    if (fabs(off[0]) > 1e-3 || fabs(off[1]) > 1e-3)
        fail_msg("input %d, weight %g, mean %g: off by %.5f, later by %.5f", (int)kind, (double)most, (double)mean,
                 off[0], off[1]);
}

static void test_noisy_light_does_not_drift(void** state) {
    (void)state;
    for_each(check_drift, NOISY, RARE);
}

static const average starts[] = {{0.0f, 0.0f, 0.0f},        {0.0f, 1.0f, 1000.0f},    {64512.0f, 1.0f, 1000.0f},
                                 {0.0f, 0.0f, 1000.0f}, /* nobody found any for long */
                                 {INFINITY, 1.0f, 1000.0f}, {NAN, 1.0f, 1000.0f},     {0.7f, NAN, 1000.0f},
                                 {NAN, NAN, NAN},           {-1.0f, -1.0f, INFINITY}, {0.7f, INFINITY, -1.0f}};

/* With noise within 1 %: dithering leaves 2e-3 in the mean of 30 thousand frames at 0.999, and so do the frames
   before them. */
static void check_starts(input kind, float mean, float most) {
    size_t i;
    for (i = 0; i < sizeof starts / sizeof starts[0]; ++i) {
        run r = run_of(kind, mean, most, DITHERED);
        window w;
        r.a = starts[i];
        (void)run_frames(&r, settling(most));
        w = run_frames(&r, kind < NOISY ? 100 : settling(most) / 2);
        if (kind < NOISY) check_halves_around(&r, &w);
        if (fabs(w.averaged / w.found - 1.0) > 0.01)
            fail_msg("start %d, input %d, weight %g: %.9g in place of %.9g", (int)i, (int)kind, (double)most,
                     w.averaged, w.found);
    }
}

static void test_any_start_settles(void** state) {
    (void)state;
    for_each(check_starts, CONSTANT, RARE);
}

/* Light that no frame finds any more is gone some time, confidence and all. */
static void test_what_is_gone_fades(void** state) {
    int w, frame;
    (void)state;
    for (w = 0; w < WEIGHTS; ++w) {
        const sample nothing = {0.0f, 0.0f};
        average a = {300.0f, 1.0f, 1000.0f};
        for (frame = 0; frame < settling(weights[w]); ++frame) {
            const float before = a.confidence;
            add_frame(&a, nothing, weights[w], DITHERED, frame);
            assert_true(a.confidence <= before);
        }
        assert_true(a.light == 0.0f && a.confidence == 0.0f);
    }
}

/* What dithering is for: without, an average of 50 frames stops where a fiftieth of what is missing rounds to
   nothing. */
static void test_without_dithering_it_sticks(void** state) {
    int how, w;
    (void)state;
    for (how = NEAREST; how <= TRUNCATED; ++how)
        for (w = 3; w < WEIGHTS; ++w) {
            run r = run_of(CONSTANT, 0.7f, weights[w], (store)how);
            r.a = starts[1];
            (void)run_frames(&r, settling(weights[w]));
            assert_true(r.a.light < 0.99f * r.mean);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_constant_light_stays),        cmocka_unit_test(test_noisy_light_does_not_drift),
        cmocka_unit_test(test_any_start_settles),           cmocka_unit_test(test_what_is_gone_fades),
        cmocka_unit_test(test_without_dithering_it_sticks),
    };
    return cmocka_run_group_tests_name("average", tests, NULL, NULL);
}
