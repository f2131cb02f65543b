/* The library as a guest in an engine's context, on a real GL: whatever the engine left behind, the picture is the
   same, and everything that can be queried is as it was. What textures held before they were written is seen nowhere.
   And where one call fails, the library says so and goes on. */
#include "gl_faults.h"
#include "gl_fixture.h"
#include "gl_session.h"
#include "gl_state.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define PAPER_EFFECTS                                                                                       \
    (DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY | DGB_EFFECT_BOUNCES | DGB_EFFECT_TEMPORAL | DGB_EFFECT_REFLECT | \
     DGB_EFFECT_GLOSSY)

enum { WIDTH = 64, HEIGHT = 48, GUARD = 8, FRAMES = 4 };

/* With DGB_FULL=1 (make test-full) the loops are long. */
static bool is_full(void) { return getenv("DGB_FULL") != NULL; }

static fixture f;

static dgb_desc desc_of(dgb_oracle oracle, dgb_emission emission) {
    const fixture_view v = fixture_default_view();
    dgb_desc d = fixture_desc(&f, &v, WIDTH, HEIGHT, GUARD);
    d.effects = PAPER_EFFECTS;
    d.oracle = oracle;
    d.emission = emission;
    d.tracer = DGB_TRACER_HIERARCHICAL;
    return d;
}

static dgb_view view_at(int frame) {
    fixture_view v = fixture_default_view();
    v.eye[0] += 0.05f * (float)frame;
    v.yaw += 0.01f * (float)frame;
    return fixture_dgb_view(&v, WIDTH, HEIGHT);
}

/* The guard band is shaded, too. */
static dgb_params params(void) {
    dgb_params q = dgb_preset(DGB_PRESET_BALANCED);
    q.guard_fraction = 1.0f;
    return q;
}

/* >> results: every texture that a frame leaves for the engine, or for the next frame */

static const struct result {
    dgb_slot slot;
    GLenum format;
    int channels;
    bool layered;
} results[] = {{DGB_DEPTH, GL_DEPTH_COMPONENT, 1, true}, {DGB_ALBEDO, GL_RGBA, 4, true},
               {DGB_NORMAL, GL_RGBA, 4, true},           {DGB_RADIANCE, GL_RGB, 3, true},
               {DGB_VELOCITY, GL_RG, 2, true},           {DGB_AO, GL_RED, 1, false},
               {DGB_IRRADIANCE, GL_RGBA, 4, false},      {DGB_IRRADIANCE1, GL_RGBA, 4, false},
               {DGB_REFLECTION, GL_RGBA, 4, false},      {DGB_BENT, GL_RGBA, 4, false}};
enum { RESULTS = (int)(sizeof results / sizeof results[0]) };

typedef struct picture {
    int width, height;
    float* data[RESULTS];
    size_t sizes[RESULTS];
} picture;

static picture take_picture(const dgb_context* c) {
    picture p;
    int i;
    p.width = c->plan.width, p.height = c->plan.height;
    for (i = 0; i < RESULTS; ++i) {
        const int layers = results[i].layered ? c->plan.layers : 0;
        const dgb_texture texture = dgb_get_texture(c, results[i].slot);
        p.data[i] = NULL;
        p.sizes[i] = sizeof(float) * (size_t)(c->plan.width * c->plan.height * results[i].channels) *
                     (size_t)(layers ? layers : 1);
        if (texture.id)
            p.data[i] = fixture_read(texture, 0, 0, c->plan.width, c->plan.height, layers, results[i].format,
                                     results[i].channels);
    }
    return p;
}

static void free_picture(picture* p) {
    int i;
    for (i = 0; i < RESULTS; ++i) free(p->data[i]);
}

/* Layers are whole; results of shading are undefined outside of the image, but for a share of the guard band. */
static void expect_same_picture(const picture* a, const picture* b, const char* what) {
    int i, y;
    for (i = 0; i < RESULTS; ++i) {
        const size_t pixel = sizeof(float) * (size_t)results[i].channels, row = pixel * (size_t)a->width;
        assert_int_equal(a->data[i] != NULL, b->data[i] != NULL);
        if (!a->data[i] || !b->data[i]) continue;
        if (results[i].layered && memcmp(a->data[i], b->data[i], a->sizes[i]) != 0)
            fail_msg("%s: %s differs", what, dgb_slot_name(results[i].slot));
        for (y = GUARD; !results[i].layered && y < a->height - GUARD; ++y)
            if (memcmp((char*)a->data[i] + (size_t)y * row + GUARD * pixel,
                       (char*)b->data[i] + (size_t)y * row + GUARD * pixel, row - 2 * GUARD * pixel) != 0)
                fail_msg("%s: %s differs", what, dgb_slot_name(results[i].slot));
    }
}

/* >> disorder */

typedef struct disorder {
    fixture_draw_user user; /* first: it is what fixture_draw takes */
    unsigned seed;          /* 0: none */
    bool wild; /* after each draw, too; what the library does not touch then stays as the callback left it */
} disorder;

static void disturb(disorder* k) {
    if (k->seed) gl_state_scramble(k->seed += 7919u);
}

/* An engine sets what it draws with, where the library neither sets nor restores it, and puts it back. */
static void draw_in_disorder(void* user, const dgb_draw* draw) {
    disorder* k = (disorder*)user;
    GLint provoking, front, cull;
    glGetIntegerv(GL_PROVOKING_VERTEX, &provoking);
    glGetIntegerv(GL_FRONT_FACE, &front);
    glGetIntegerv(GL_CULL_FACE_MODE, &cull);
    glProvokingVertex(GL_LAST_VERTEX_CONVENTION);
    glFrontFace(GL_CCW);
    fixture_draw(&k->user, draw);
    glProvokingVertex((GLenum)provoking);
    glFrontFace((GLenum)front);
    glCullFace((GLenum)cull);
    if (k->wild) disturb(k);
}

static gl_state* before;

static void expect_same_state(const char* call) {
    char text[256];
    gl_state* after = gl_state_take();
    const int count = gl_state_compare(before, after, text, sizeof text);
    gl_state_free(after);
    if (count) fail_msg("%s changed %d values; %s", call, count, text);
}

static void disturb_and_look(disorder* k) {
    gl_state_free(before);
    disturb(k);
    before = gl_state_take();
}

static void check_view(const dgb_context* c, disorder* k) {
    dgbgl_view_desc v;
    memset(&v, 0, sizeof v);
    v.view = DGBGL_VIEW_AO;
    disturb_and_look(k);
    assert_int_equal(dgbgl_draw_view(c, &v), DGB_OK);
    expect_same_state("dgbgl_draw_view");
}

static void run(const dgb_desc* d, unsigned seed, bool wild, picture pictures[FRAMES]) {
    const dgb_params q = params();
    disorder k;
    dgb_context c;
    int frame;
    memset(&k, 0, sizeof k);
    k.seed = seed;
    k.wild = wild;
    k.user.f = &f;
    disturb_and_look(&k);
    assert_int_equal(dgb_init(&c, d), DGB_OK);
    expect_same_state("dgb_init");
    k.user.program = fixture_program(&c);
    assert_true(k.user.program != 0);
    expect_same_state("dgbgl_attach_program");
    for (frame = 0; frame < FRAMES; ++frame) {
        const dgb_view view = view_at(frame);
        disturb_and_look(&k);
        assert_int_equal(dgb_build(&c, &view, &q, draw_in_disorder, &k), DGB_OK);
        if (!wild) expect_same_state("dgb_build");
        disturb_and_look(&k);
        assert_int_equal(dgb_shade(&c, &q), DGB_OK);
        expect_same_state("dgb_shade");
        if (seed) check_view(&c, &k); /* else no framebuffer is bound */
        if (seed) gl_state_calm_reading();
        pictures[frame] = take_picture(&c);
    }
    disturb_and_look(&k);
    assert_int_equal(dgb_resize(&c, WIDTH + 5, HEIGHT), DGB_OK);
    expect_same_state("dgb_resize");
    disturb_and_look(&k);
    dgb_shutdown(&c);
    expect_same_state("dgb_shutdown");
    glUseProgram(0);
    glDeleteProgram(k.user.program);
    gl_state_free(before);
    before = NULL;
}

static void check_disorder(dgb_oracle oracle, dgb_emission emission, unsigned seed) {
    const dgb_desc d = desc_of(oracle, emission);
    picture calm[FRAMES], wild[FRAMES];
    char what[64];
    int frame, kind;
    fixture_close(&f); /* a context of its own: the disorder ends with it */
    assert_int_equal(fixture_open(&f, 4, 5, false, NULL), 0);
    gl_state_open();
    run(&d, 0, false, calm);
    for (kind = 0; kind < 2; ++kind) {
        run(&d, seed, kind == 1, wild);
        for (frame = 0; frame < FRAMES; ++frame) {
            snprintf(what, sizeof what, "%s, %s, frame %d", dgb_oracle_name(oracle), dgb_emission_name(emission),
                     frame);
            expect_same_picture(&calm[frame], &wild[frame], what);
            free_picture(&wild[frame]);
        }
    }
    for (frame = 0; frame < FRAMES; ++frame) free_picture(&calm[frame]);
    gl_state_close();
}

static void test_disorder(void** state) {
    const unsigned seeds = is_full() ? 60 : 3;
    unsigned seed;
    (void)state;
    for (seed = 1; seed <= seeds; ++seed) {
        check_disorder(DGB_ORACLE_REPROJECT, DGB_EMISSION_IMAGE, 4 * seed);
        check_disorder(DGB_ORACLE_PREDICT, DGB_EMISSION_VERTEX, 4 * seed + 1);
        check_disorder(DGB_ORACLE_WARP, DGB_EMISSION_GEOMETRY, 4 * seed + 2);
        check_disorder(DGB_ORACLE_PEEL, DGB_EMISSION_SEPARATE, 4 * seed + 3);
    }
}

/* Enough is found, and enough of it is put into disorder. */
static void test_disorder_is_wide(void** state) {
    gl_state *a, *b;
    char text[256];
    (void)state;
    fixture_close(&f);
    assert_int_equal(fixture_open(&f, 4, 5, false, NULL), 0);
    gl_state_open();
    a = gl_state_take();
    gl_state_scramble(5u);
    b = gl_state_take();
    printf("# %d values, %d of them in disorder\n", gl_state_count(b), gl_state_compare(a, b, text, sizeof text));
    assert_true(gl_state_count(b) > 2000);
    assert_true(gl_state_compare(a, b, text, sizeof text) > 900);
    gl_state_free(a);
    a = gl_state_take();
    assert_int_equal(gl_state_compare(a, b, text, sizeof text), 0); /* looking changes nothing */
    gl_state_free(a);
    gl_state_free(b);
    gl_state_close();
}

/* >> sessions: a life of the library between faults and the GL */

static disorder session_user; /* none */
static picture session_picture;

static unsigned int session_program(void* user, const dgb_context* c) {
    (void)user;
    return session_user.user.program = fixture_program(c);
}

static void session_end_of_program(void* user, unsigned int program) {
    (void)user;
    glDeleteProgram(program);
}

static void session_look(void* user, const char* call) {
    (void)user;
    expect_same_state(call);
}

static void session_end_of_frames(void* user, const dgb_context* c) {
    (void)user;
    session_picture = take_picture(c);
}

/* In a context of its own; its picture is to be freed. Nothing is left behind. */
static gl_session run_session(const dgb_desc* d, int fail_at) {
    gl_session s;
    int objects;
    memset(&s, 0, sizeof s);
    s.gl.get_proc = gl_faults_get_proc;
    s.desc = *d;
    s.make_program = session_program;
    s.delete_program = session_end_of_program;
    s.draw = draw_in_disorder;
    s.after = session_look;
    s.end_of_frames = session_end_of_frames;
    s.user = &session_user;
    session_user.user.f = &f;
    gl_state_free(before);
    before = gl_state_take();
    objects = fixture_count_objects();
    gl_faults_start(fixture_get_proc, fail_at);
    gl_session_run(&s);
    if (fixture_count_objects() != objects)
        fail_msg("%s fails: %d objects are left", gl_faults_failed(), fixture_count_objects() - objects);
    assert_int_equal(glGetError(), GL_NO_ERROR);
    return s;
}

static void open_for_sessions(void) {
    fixture_close(&f);
    assert_int_equal(fixture_open(&f, 4, 5, false, NULL), 0);
    gl_state_open();
    glPixelStorei(GL_PACK_ALIGNMENT, 1); /* as reading pictures leaves it */
}

static void close_after_sessions(void) {
    gl_state_free(before);
    before = NULL;
    gl_state_close();
}

/* After a failure before the first frame, or of a new size, the picture is what it is without. */
static bool is_before_frames(const gl_session* s) {
    return strcmp(s->failed, "dgb_build") != 0 && strcmp(s->failed, "dgb_shade") != 0;
}

static void check_fault(const dgb_desc* d, int n, const picture* whole) {
    const gl_session s = run_session(d, n);
    const char* fault = gl_faults_failed();
    assert_true(fault[0] != 0);
    /* an entry point that this context does not need, timers that are then off */
    if (!s.failures && !gl_faults_was_lookup() && strcmp(fault, "glGenQueries") != 0)
        fail_msg("%s fails (%d), and nobody says so", fault, n);
    if (is_before_frames(&s)) expect_same_picture(whole, &session_picture, fault);
    free_picture(&session_picture);
}

static void test_faults(void** state) {
    enum { SAMPLES = 20 };
    const dgb_desc d = desc_of(DGB_ORACLE_PREDICT, DGB_EMISSION_AUTO);
    picture whole;
    int k, n, count;
    (void)state;
    open_for_sessions();
    assert_int_equal(run_session(&d, 0).failures, 0);
    count = gl_faults_count();
    whole = session_picture;
    printf("# %d calls may fail\n", count);
    assert_true(count > 200);
    for (k = 0; k < SAMPLES && !is_full(); ++k) check_fault(&d, 1 + (2 * k + 1) * count / (2 * SAMPLES), &whole);
    for (n = 1; n <= count && is_full(); ++n) check_fault(&d, n, &whole);
    free_picture(&whole);
    close_after_sessions();
    f.messages = 0; /* the driver speaks of faults, too */
}

/* >> textures that hold NaN before they are written */

/* Surfaces in every layer that a picture is compared of, and sky, or the comparison means nothing. */
static void expect_scene(const picture* p) {
    const size_t count = p->sizes[0] / sizeof(float);
    size_t k, empty = 0;
    for (k = 0; k < count; ++k) empty += p->data[0][k] >= 1.0f;
    assert_true(empty > count / 50 && empty < count - count / 10);
}

/* >> what a pass samples, asked of the driver, which knows what of a shader is left */

static int watched; /* samplers */

static bool is_drawn_to(GLuint texture, GLint low, GLint high) {
    static const GLenum attachments[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT0 + 1, GL_COLOR_ATTACHMENT0 + 2,
                                         GL_COLOR_ATTACHMENT0 + 3, GL_DEPTH_ATTACHMENT};
    int i;
    for (i = 0; i < 5; ++i) {
        GLint type, name, level;
        glGetFramebufferAttachmentParameteriv(GL_DRAW_FRAMEBUFFER, attachments[i],
                                              GL_FRAMEBUFFER_ATTACHMENT_OBJECT_TYPE, &type);
        if (type != GL_TEXTURE) continue;
        glGetFramebufferAttachmentParameteriv(GL_DRAW_FRAMEBUFFER, attachments[i],
                                              GL_FRAMEBUFFER_ATTACHMENT_OBJECT_NAME, &name);
        glGetFramebufferAttachmentParameteriv(GL_DRAW_FRAMEBUFFER, attachments[i],
                                              GL_FRAMEBUFFER_ATTACHMENT_TEXTURE_LEVEL, &level);
        if ((GLuint)name == texture && level >= low && level <= high) return true;
    }
    return false;
}

/* A texture of its kind is there, whose levels are not drawn to. Full-screen passes only: peeling is the engine's
   draw. */
static void watch_sampler(GLint program, const char* name, GLenum type) {
    const bool array = type == GL_SAMPLER_2D_ARRAY || type == GL_UNSIGNED_INT_SAMPLER_2D_ARRAY;
    const bool integer = type == GL_UNSIGNED_INT_SAMPLER_2D || type == GL_UNSIGNED_INT_SAMPLER_2D_ARRAY;
    const GLenum target = array ? GL_TEXTURE_2D_ARRAY : GL_TEXTURE_2D;
    GLint unit, active, texture, red, depth, low, high;
    glGetUniformiv((GLuint)program, glGetUniformLocation((GLuint)program, name), &unit);
    glGetIntegerv(GL_ACTIVE_TEXTURE, &active);
    glActiveTexture((GLenum)(GL_TEXTURE0 + unit));
    glGetIntegerv(array ? GL_TEXTURE_BINDING_2D_ARRAY : GL_TEXTURE_BINDING_2D, &texture);
    if (!texture) fail_msg("%s: no texture in unit %d", name, unit);
    glGetTexParameteriv(target, GL_TEXTURE_BASE_LEVEL, &low);
    glGetTexParameteriv(target, GL_TEXTURE_MAX_LEVEL, &high);
    glGetTexLevelParameteriv(target, low, GL_TEXTURE_RED_TYPE, &red);
    glGetTexLevelParameteriv(target, low, GL_TEXTURE_DEPTH_TYPE, &depth);
    glActiveTexture((GLenum)active);
    if (red == GL_NONE && depth == GL_NONE) fail_msg("%s: no level %d in unit %d", name, low, unit);
    if ((red == GL_UNSIGNED_INT) != integer) fail_msg("%s: integers and floats in unit %d", name, unit);
    if (is_drawn_to((GLuint)texture, low, high)) fail_msg("%s, in unit %d, is drawn to", name, unit);
    ++watched;
}

static void watch_draw(void) {
    GLint program, count, size;
    GLuint i;
    glGetIntegerv(GL_CURRENT_PROGRAM, &program);
    glGetProgramiv((GLuint)program, GL_ACTIVE_UNIFORMS, &count);
    for (i = 0; i < (GLuint)count; ++i) {
        char name[64];
        GLenum type;
        glGetActiveUniform((GLuint)program, i, (GLsizei)sizeof name, NULL, &size, &type, name);
        if (type == GL_SAMPLER_2D || type == GL_SAMPLER_2D_ARRAY || type == GL_UNSIGNED_INT_SAMPLER_2D ||
            type == GL_UNSIGNED_INT_SAMPLER_2D_ARRAY)
            watch_sampler(program, name, type);
    }
}

static void check_poison(const dgb_desc* d) {
    picture clean;
    char what[96];
    int poisoned;
    snprintf(what, sizeof what, "%s, %s, effects %u, estimator %d, %d layers, NaN", dgb_oracle_name(d->oracle),
             dgb_emission_name(d->emission), (unsigned)d->effects, (int)d->estimator, d->layers);
    watched = 0;
    gl_faults_watch(watch_draw);
    assert_int_equal(run_session(d, 0).failures, 0);
    gl_faults_watch(NULL);
    assert_true(watched > 20);
    clean = session_picture;
    expect_scene(&clean);
    gl_faults_poison(true);
    assert_int_equal(run_session(d, 0).failures, 0);
    poisoned = gl_faults_poisoned();
    gl_faults_poison(false);
    assert_true(poisoned > 4);
    expect_same_picture(&clean, &session_picture, what);
    free_picture(&clean);
    free_picture(&session_picture);
}

static void test_nothing_is_read_before_it_is_written(void** state) {
    static const uint32_t effects[] = {PAPER_EFFECTS,
                                       DGB_EFFECT_AO,
                                       DGB_EFFECT_RADIOSITY,
                                       DGB_EFFECT_AO | DGB_EFFECT_TEMPORAL,
                                       DGB_EFFECT_RADIOSITY | DGB_EFFECT_BOUNCES,
                                       DGB_EFFECT_REFLECT,
                                       DGB_EFFECT_REFLECT | DGB_EFFECT_GLOSSY | DGB_EFFECT_TEMPORAL};
    int oracle, emission;
    size_t i;
    (void)state;
    open_for_sessions();
    for (oracle = DGB_ORACLE_PEEL; oracle < DGB_ORACLE_COUNT; ++oracle)
        for (emission = DGB_EMISSION_SEPARATE; emission < DGB_EMISSION_COUNT; ++emission) {
            dgb_desc d = desc_of((dgb_oracle)oracle, (dgb_emission)emission);
            if (!f.gl.backend.caps.emission[emission]) continue;
            if (oracle == DGB_ORACLE_PEEL && emission != DGB_EMISSION_SEPARATE) continue;
            if (!is_full() && (oracle + emission) % 3) continue;
            d.layers = 3;
            check_poison(&d);
        }
    for (i = 0; i < 2 * sizeof effects / sizeof effects[0]; ++i) {
        dgb_desc d = desc_of(DGB_ORACLE_DEFAULT, DGB_EMISSION_AUTO);
        d.effects = effects[i / 2];
        d.tracer = i % 2 ? DGB_TRACER_HIERARCHICAL : DGB_TRACER_LINEAR;
        d.estimator = i % 2 ? DGB_ESTIMATOR_BITMASK : DGB_ESTIMATOR_PAPER;
        if (d.estimator == DGB_ESTIMATOR_BITMASK && (d.effects & DGB_EFFECT_AO)) {
            d.effects |= DGB_EFFECT_BENT;
            d.thickness = DGB_THICKNESS_BACK_FACES;
        }
        check_poison(&d);
        d.layers = 1;
        if (is_full()) check_poison(&d);
    }
    close_after_sessions();
}

FIXTURE_CONTEXT(f, 4, 5, false)

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_disorder_is_wide),
        cmocka_unit_test(test_disorder),
        cmocka_unit_test(test_no_messages),
        cmocka_unit_test(test_faults),
        cmocka_unit_test(test_nothing_is_read_before_it_is_written),
        cmocka_unit_test(test_no_messages),
    };
    return cmocka_run_group_tests(tests, open_context, close_context);
}
