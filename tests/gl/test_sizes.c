/* Windows that are dragged about: every frame has another size, down to one pixel and up to what one texture can be. */
#include "gl_fixture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { GUARD = 5, FRAMES = 3 }; /* a guard band wider than the smallest images */

static fixture f;

/* Points, lines, the longest strip that a texture can be; the last is compared with a context that was made for it. */
static const int sizes[][2] = {{1, 1}, {1, 37}, {2, 2},    {41, 1}, {DGB_MAX_SIZE - 2 * GUARD, 4},
                               {3, 3}, {4, 2},  {127, 63}, {1, 2},  {61, 45}};
enum { SIZES = sizeof sizes / sizeof sizes[0] };

static const struct {
    dgb_slot slot;
    GLenum format;
    int channels;
} results[] = {{DGB_AO, GL_RED, 1}, {DGB_IRRADIANCE, GL_RGBA, 4}, {DGB_REFLECTION, GL_RGBA, 4}, {DGB_BENT, GL_RGBA, 4}};
enum { RESULTS = sizeof results / sizeof results[0] };

typedef struct engine {
    dgb_context context;
    fixture_draw_user user;
} engine;

static engine start(dgb_estimator estimator, const int size[2]) {
    const fixture_view v = fixture_default_view();
    dgb_desc d = fixture_desc(&f, &v, size[0], size[1], GUARD);
    engine e;
    memset(&e, 0, sizeof e);
    d.estimator = estimator;
    d.tracer = DGB_TRACER_HIERARCHICAL;
    d.effects = DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY | DGB_EFFECT_BOUNCES | DGB_EFFECT_TEMPORAL | DGB_EFFECT_REFLECT |
                DGB_EFFECT_GLOSSY;
    if (estimator == DGB_ESTIMATOR_BITMASK) d.effects |= DGB_EFFECT_BENT;
    assert_int_equal(dgb_init(&e.context, &d), DGB_OK);
    e.user.f = &f;
    e.user.program = fixture_program(&e.context);
    assert_true(e.user.program != 0);
    return e;
}

static void stop(engine* e) {
    glDeleteProgram(e->user.program);
    dgb_shutdown(&e->context);
}

static void run_frame(engine* e) {
    const fixture_view v = fixture_default_view();
    const dgb_view view = fixture_dgb_view(&v, e->context.desc.width, e->context.desc.height);
    dgb_params q = dgb_preset(DGB_PRESET_BALANCED);
    q.history_weight = 0.85f;
    assert_int_equal(dgb_build(&e->context, &view, &q, fixture_draw, &e->user), DGB_OK);
    assert_int_equal(dgb_shade(&e->context, &q), DGB_OK);
}

/* A result in the image, without the guard band. Caller frees. */
static float* read_result(const engine* e, int result, size_t* count) {
    const dgb_plan* plan = &e->context.plan;
    const dgb_texture texture = dgb_get_texture(&e->context, results[result].slot);
    const size_t row = (size_t)e->context.desc.width * (size_t)results[result].channels;
    float* all;
    int y;
    *count = texture.id ? row * (size_t)e->context.desc.height : 0;
    if (!texture.id) return NULL;
    all = fixture_read(texture, 0, 0, plan->width, plan->height, 0, results[result].format, results[result].channels);
    for (y = 0; y < e->context.desc.height; ++y)
        memmove(all + (size_t)y * row, all + ((y + GUARD) * plan->width + GUARD) * results[result].channels,
                row * sizeof *all);
    return all;
}

static void expect_finite(const engine* e) {
    size_t count, k;
    int i;
    for (i = 0; i < RESULTS; ++i) {
        float* all = read_result(e, i, &count);
        for (k = 0; k < count; ++k)
            if (!(all[k] - all[k] == 0.0f))
                fail_msg("%dx%d: %s is not finite", e->context.desc.width, e->context.desc.height,
                         dgb_slot_name(results[i].slot));
        free(all);
    }
}

static void expect_equal(const engine* a, const engine* b, int frame) {
    size_t count, other, k, varied;
    int i;
    for (i = 0; i < RESULTS; ++i) {
        float *x = read_result(a, i, &count), *y = read_result(b, i, &other);
        assert_int_equal(count, other);
        for (k = varied = 0; k < count; ++k) varied += x[k] != x[0];
        assert_true(count == 0 || varied > count / 8); /* there is a picture to compare */
        if (count && memcmp(x, y, count * sizeof *x) != 0)
            fail_msg("frame %d after the resize: %s differs", frame, dgb_slot_name(results[i].slot));
        free(x);
        free(y);
    }
}

/* Every size twice: the second time as many GL objects are left as the first, which differ between sizes by their
   levels. */
static void check_sizes(dgb_estimator estimator) {
    engine resized = start(estimator, sizes[SIZES - 1]), fresh;
    int objects[SIZES], round, i, frame;
    run_frame(&resized);
    for (round = 0; round < 2; ++round)
        for (i = 0; i < SIZES; ++i) {
            assert_int_equal(dgb_resize(&resized.context, sizes[i][0], sizes[i][1]), DGB_OK);
            run_frame(&resized);
            expect_finite(&resized);
            assert_int_equal(f.messages, 0);
            if (round == 0) objects[i] = fixture_count_objects();
            assert_int_equal(fixture_count_objects(), objects[i]);
        }

    /* the taps of a frame go on through a resize: the fresh context takes those of the same frames */
    fresh = start(estimator, sizes[SIZES - 1]);
    fresh.context.frame = resized.context.frame - 1;
    for (frame = 0; frame < FRAMES; ++frame) {
        if (frame > 0) run_frame(&resized);
        run_frame(&fresh);
        expect_equal(&resized, &fresh, frame);
    }
    stop(&fresh);
    stop(&resized);
}

static void test_sizes(void** state) {
    (void)state;
    check_sizes(DGB_ESTIMATOR_PAPER);
}

static void test_sizes_bitmask(void** state) {
    (void)state;
    check_sizes(DGB_ESTIMATOR_BITMASK);
}

FIXTURE_CONTEXT(f, 4, 5, false)

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sizes),
        cmocka_unit_test(test_sizes_bitmask),
        cmocka_unit_test(test_no_messages),
    };
    return cmocka_run_group_tests(tests, open_context, close_context);
}
