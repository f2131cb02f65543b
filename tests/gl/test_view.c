/* dgbgl_draw_view: each view shows what the texture holds, in the rectangle and nowhere else; the state stays. */
#include "gl_fixture.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static fixture f;

enum { WIDTH = 96, HEIGHT = 64, GUARD = 16, FRAME_WIDTH = WIDTH + GUARD * 2, FRAME_HEIGHT = HEIGHT + GUARD * 2 };

static dgb_context context;
static GLuint program, target, framebuffer;
static char message[256];

/* >> a frame to look at */

static void keep_message(void* user, const char* text) { snprintf((char*)user, sizeof message, "%s", text); }

static void make_target(void) {
    glGenTextures(1, &target);
    glBindTexture(GL_TEXTURE_2D, target);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, FRAME_WIDTH, FRAME_HEIGHT, 0, GL_RGBA, GL_UNSIGNED_BYTE, NULL);
    glGenFramebuffers(1, &framebuffer);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, target, 0);
}

/* Three frames of a walking camera, with all effects. */
static int open_frame(bool es) {
    dgbgl_desc gd;
    dgb_desc d;
    dgb_params q = dgb_preset(DGB_PRESET_BALANCED);
    fixture_view v = fixture_default_view();
    fixture_draw_user user;
    int frame;
    memset(&gd, 0, sizeof gd);
    gd.message = keep_message;
    gd.message_user = message;
    if (fixture_open(&f, es ? 3 : 4, es ? 0 : 5, es, &gd)) return 1;
    memset(&d, 0, sizeof d);
    d.width = WIDTH, d.height = HEIGHT, d.guard_band = GUARD;
    d.effects = DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY | DGB_EFFECT_TEMPORAL | DGB_EFFECT_REFLECT;
    d.emission = DGB_EMISSION_SEPARATE; /* which ES has too: test_es compares bits */
    d.backend = &f.gl.backend;
    d.log = fixture_log;
    if (dgb_init(&context, &d) != DGB_OK) return 1;
    memset(&user, 0, sizeof user);
    user.f = &f;
    user.program = program = fixture_program(&context);
    for (frame = 0; frame < 3; ++frame) {
        dgb_view view;
        v.eye[0] += 0.05f;
        view = fixture_dgb_view(&v, WIDTH, HEIGHT);
        if (dgb_build(&context, &view, &q, fixture_draw, &user) || dgb_shade(&context, &q)) return 1;
    }
    make_target();
    return 0;
}

static int open_desktop(void** state) {
    (void)state;
    return open_frame(false);
}

static int close_frame(void** state) {
    (void)state;
    glDeleteFramebuffers(1, &framebuffer);
    glDeleteTextures(1, &target);
    glDeleteProgram(program);
    dgb_shutdown(&context);
    fixture_close(&f);
    return 0;
}

static dgbgl_view_desc view_of(dgbgl_view view, int layer) {
    dgbgl_view_desc v;
    memset(&v, 0, sizeof v);
    v.view = view;
    v.layer = layer;
    return v;
}

static unsigned char seen[FRAME_HEIGHT][FRAME_WIDTH][4];

static void clear(void) {
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glDisable(GL_SCISSOR_TEST);
    glClearColor(1.0f, 0.0f, 1.0f, 0.0f); /* which no view shows */
    glClear(GL_COLOR_BUFFER_BIT);
}

static void look(const dgbgl_view_desc* v) {
    clear();
    message[0] = 0;
    assert_int_equal(dgbgl_draw_view(&context, v), DGB_OK);
    glReadPixels(0, 0, FRAME_WIDTH, FRAME_HEIGHT, GL_RGBA, GL_UNSIGNED_BYTE, seen);
    assert_string_equal(message, "");
}

/* >> what each should show, from the texture itself */

static float* texels(dgb_slot slot, int layer, GLenum format, int channels) {
    return fixture_read(dgb_get_texture(&context, slot), 0, layer, FRAME_WIDTH, FRAME_HEIGHT,
                        slot <= DGB_ORACLE ? 2 : 0, format, channels);
}

static float srgb(float x) { return x < 0.0031308f ? 12.92f * x : 1.055f * powf(x, 1.0f / 2.4f) - 0.055f; }

static float filmic(float x) { return srgb(x * (2.51f * x + 0.03f) / (x * (2.43f * x + 0.59f) + 0.14f)); }

static float nearness(float depth, float range) { return exp2f(3.0f * dgb_linear_z(depth, &context.camera) / range); }

/* The view at a texel whose value and depth are given, for those that one value tells. */
static void expected(dgbgl_view view, const float* value, float depth, float rgb[3]) {
    const bool empty = view <= DGBGL_VIEW_VALIDITY && depth == 1.0f;
    const float pi = 3.14159265f, black[3] = {0, 0, 0}, blue[3] = {0.05f, 0.08f, 0.3f}, layer0[3] = {0.1f, 0.3f, 0.9f},
                layer1[3] = {1.0f, 0.5f, 0.0f};
    float n[3];
    int c;
    memcpy(rgb, black, sizeof black);
    if (view == DGBGL_VIEW_DEPTH && empty) memcpy(rgb, blue, sizeof blue);
    if (view == DGBGL_VIEW_REFLECTION_LAYER && value[0] > 0.0f)
        memcpy(rgb, value[0] < 1.5f ? layer0 : layer1, sizeof layer0);
    if (view == DGBGL_VIEW_NORMAL)
        dgb_oct16_decode((uint16_t)((int)(255.0f * value[0] + 0.5f) | (int)(255.0f * value[1] + 0.5f) << 8), n);
    for (c = 0; c < 3 && !empty; ++c) {
        if (view == DGBGL_VIEW_DEPTH) rgb[c] = nearness(depth, 20.0f);
        if (view == DGBGL_VIEW_NORMAL) rgb[c] = 0.5f + 0.5f * n[c];
        if (view == DGBGL_VIEW_ALBEDO) rgb[c] = srgb(value[c]);
        if (view == DGBGL_VIEW_RADIANCE) rgb[c] = filmic(value[c]);
        if (view == DGBGL_VIEW_VELOCITY) rgb[c] = c < 2 ? fminf(fmaxf(0.5f + value[c] / 32.0f, 0.0f), 1.0f) : 0.5f;
        if (view == DGBGL_VIEW_AO) rgb[c] = value[0];
        if (view == DGBGL_VIEW_IRRADIANCE) rgb[c] = filmic(value[c] / pi);
        if (view == DGBGL_VIEW_CONFIDENCE) rgb[c] = value[3];
        if (view == DGBGL_VIEW_REFLECTION) rgb[c] = filmic(value[c] * value[3]);
    }
}

/* Within a code and a half: half a code of rounding, and pow and exp2 of another make. */
static void check_color(const unsigned char* got, const float rgb[3], int x, int y) {
    int c;
    for (c = 0; c < 3; ++c)
        if (!(fabsf((float)got[c] - 255.0f * rgb[c]) <= 1.5f))
            fail_msg("pixel %d %d channel %d: %d, not %g", x, y, c, got[c], (double)(255.0f * rgb[c]));
}

static void check_view(dgbgl_view view, int layer, dgb_slot slot, GLenum format) {
    const dgbgl_view_desc v = view_of(view, layer);
    float *values = texels(slot, layer, format, 4), *depth = texels(DGB_DEPTH, layer, GL_DEPTH_COMPONENT, 1), rgb[3];
    int x, y, lively = 0;
    look(&v);
    for (y = 0; y < HEIGHT; ++y)
        for (x = 0; x < WIDTH; ++x) {
            const int at = (y + GUARD) * FRAME_WIDTH + x + GUARD;
            expected(view, &values[4 * at], depth[at], rgb);
            check_color(seen[y][x], rgb, x, y);
            lively += memcmp(seen[y][x], seen[0][0], 4) != 0;
        }
    assert_true(lively > WIDTH * HEIGHT / 100); /* not one colour */
    free(values);
    free(depth);
}

static void test_layers(void** state) {
    int layer;
    (void)state;
    for (layer = 0; layer < 2; ++layer) {
        check_view(DGBGL_VIEW_NORMAL, layer, DGB_NORMAL, GL_RGBA);
        check_view(DGBGL_VIEW_ALBEDO, layer, DGB_ALBEDO, GL_RGBA);
        check_view(DGBGL_VIEW_RADIANCE, layer, DGB_RADIANCE, GL_RGBA);
        check_view(DGBGL_VIEW_VELOCITY, layer, DGB_VELOCITY, GL_RGBA);
        check_view(DGBGL_VIEW_DEPTH, layer, DGB_ALBEDO, GL_RGBA);
    }
}

static void test_results(void** state) {
    (void)state;
    check_view(DGBGL_VIEW_AO, 0, DGB_AO, GL_RGBA);
    check_view(DGBGL_VIEW_IRRADIANCE, 0, DGB_IRRADIANCE, GL_RGBA);
    check_view(DGBGL_VIEW_CONFIDENCE, 0, DGB_IRRADIANCE, GL_RGBA);
    check_view(DGBGL_VIEW_REFLECTION, 0, DGB_REFLECTION, GL_RGBA);
    check_view(DGBGL_VIEW_REFLECTION_LAYER, 0, DGB_REFLECTION_HIT, GL_RGBA);
}

/* A deeper layer of half the resolution fills the rectangle: texel p shows in pixels 2p and 2p + 1. */
static void test_divisor(void** state) {
    const dgbgl_view_desc v = view_of(DGBGL_VIEW_ALBEDO, 1);
    const dgb_params q = dgb_preset(DGB_PRESET_BALANCED);
    const fixture_view eye = fixture_default_view();
    const dgb_view view = fixture_dgb_view(&eye, WIDTH, HEIGHT);
    const dgb_context whole = context;
    fixture_draw_user user;
    dgb_desc d = context.desc;
    float *albedo, *depth, rgb[3];
    int x, y, surfaces = 0;
    (void)state;
    memset(&user, 0, sizeof user);
    d.divisor = 2;
    d.effects = 0;
    d.backend = &f.gl.backend;
    assert_int_equal(dgb_init(&context, &d), DGB_OK);
    user.f = &f;
    user.program = fixture_program(&context);
    assert_int_equal(dgb_build(&context, &view, &q, fixture_draw, &user), DGB_OK);
    albedo = texels(DGB_ALBEDO, 1, GL_RGBA, 4);
    depth = texels(DGB_DEPTH, 1, GL_DEPTH_COMPONENT, 1);
    look(&v);
    for (y = 0; y < HEIGHT; ++y)
        for (x = 0; x < WIDTH; ++x) {
            const int at = (y + GUARD) / 2 * FRAME_WIDTH + (x + GUARD) / 2;
            expected(DGBGL_VIEW_ALBEDO, &albedo[4 * at], depth[at], rgb);
            check_color(seen[y][x], rgb, x, y);
            surfaces += depth[at] < 1.0f;
        }
    assert_true(surfaces > WIDTH * HEIGHT / 10);
    free(albedo);
    free(depth);
    glDeleteProgram(user.program);
    dgb_shutdown(&context);
    context = whole;
}

/* Cyan where the packed second layer has a surface, red where the layer had one that was emptied, neither where it had none. */
static void test_validity(void** state) {
    const dgbgl_view_desc v = view_of(DGBGL_VIEW_VALIDITY, 1);
    float *depth = texels(DGB_DEPTH, 1, GL_DEPTH_COMPONENT, 1), *z = texels(DGB_Z, 0, GL_RGBA, 4);
    int x, y, counts[3] = {0};
    (void)state;
    look(&v);
    for (y = 0; y < HEIGHT; ++y)
        for (x = 0; x < WIDTH; ++x) {
            const int at = (y + GUARD) * FRAME_WIDTH + x + GUARD;
            const unsigned char* c = seen[y][x];
            const int kind = depth[at] == 1.0f ? 0 : z[4 * at + 1] > DGB_EMPTY_Z ? 1 : 2;
            ++counts[kind];
            /* half of the range is added to two channels, or 0.6 to one, over a grey of 0.1 to 0.4 */
            assert_true(kind == 0   ? c[0] == c[1] && c[1] == c[2]
                        : kind == 1 ? c[1] == c[2] && c[1] >= c[0] + 126
                                    : c[1] == c[2] && c[0] >= c[1] + 151);
        }
    printf("# layer 1: %d empty, %d kept, %d too near\n", counts[0], counts[1], counts[2]);
    assert_true(counts[0] > 0 && counts[1] > 100 && counts[2] > 0);
    free(depth);
    free(z);
}

/* Black without history, redder the fewer frames were averaged: red falls or rises never against the number. */
static void test_history(void** state) {
    const dgbgl_view_desc v = view_of(DGBGL_VIEW_HISTORY, 0);
    float* frames = texels(DGB_FRAMES, 0, GL_RGBA, 4);
    int x, y, i, most = 0, greens[8] = {0};
    (void)state;
    look(&v);
    for (y = 0; y < HEIGHT; ++y)
        for (x = 0; x < WIDTH; ++x) {
            const float* value = &frames[4 * ((y + GUARD) * FRAME_WIDTH + x + GUARD)];
            const int count = (int)(fmaxf(value[1], value[2]) + 0.5f);
            assert_in_range(count, 0, 7);
            if (count == 0) assert_true(seen[y][x][0] == 0 && seen[y][x][1] == 0 && seen[y][x][2] == 0);
            if (count && greens[count]) assert_true(abs(greens[count] - seen[y][x][1]) <= 1);
            greens[count] = count ? seen[y][x][1] : 0;
            most = count > most ? count : most;
        }
    assert_true(most >= 2);
    for (i = 2; i <= most; ++i) assert_true(!greens[i] || !greens[i - 1] || greens[i] > greens[i - 1]);
    free(frames);
}

/* A picture of the engine's own, and the factor of light: the target itself, drawn again at twice the exposure. */
static void test_light(void** state) {
    static float light[HEIGHT][WIDTH][4];
    dgbgl_view_desc v = view_of(DGBGL_VIEW_LIGHT, 0);
    float rgb[3];
    int x, y, c;
    (void)state;
    for (y = 0; y < HEIGHT; ++y)
        for (x = 0; x < WIDTH; ++x)
            for (c = 0; c < 3; ++c) light[y][x][c] = 0.01f * (float)(x + 1) * (float)(c + 1);
    glGenTextures(1, &v.texture);
    glBindTexture(GL_TEXTURE_2D, v.texture);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, WIDTH, HEIGHT, 0, GL_RGBA, GL_FLOAT, light);
    v.exposure = 2.0f;
    look(&v);
    for (y = 0; y < HEIGHT; ++y)
        for (x = 0; x < WIDTH; ++x) {
            for (c = 0; c < 3; ++c) rgb[c] = fminf(filmic(2.0f * light[y][x][c]), 1.0f);
            check_color(seen[y][x], rgb, x, y);
        }
    glDeleteTextures(1, &v.texture);
}

/* >> where, and what stays */

static bool untouched(int x, int y) {
    static const unsigned char cleared[4] = {255, 0, 255, 0};
    return memcmp(seen[y][x], cleared, 4) == 0;
}

/* Half as wide and a quarter as high, elsewhere, and cut by the scissor: pixel p shows what its centre lies on, pixel 2p + 1 and
   4p + 2 of the whole. */
static void test_rectangle(void** state) {
    static unsigned char whole[FRAME_HEIGHT][FRAME_WIDTH][4];
    dgbgl_view_desc v = view_of(DGBGL_VIEW_NORMAL, 0);
    int x, y;
    (void)state;
    look(&v);
    memcpy(whole, seen, sizeof whole);
    clear();
    v.x = 10, v.y = 20, v.width = WIDTH / 2, v.height = HEIGHT / 4;
    glEnable(GL_SCISSOR_TEST);
    glScissor(0, 0, 30, FRAME_HEIGHT);
    assert_int_equal(dgbgl_draw_view(&context, &v), DGB_OK);
    assert_true(glIsEnabled(GL_SCISSOR_TEST));
    glDisable(GL_SCISSOR_TEST);
    glReadPixels(0, 0, FRAME_WIDTH, FRAME_HEIGHT, GL_RGBA, GL_UNSIGNED_BYTE, seen);
    for (y = 0; y < FRAME_HEIGHT; ++y)
        for (x = 0; x < FRAME_WIDTH; ++x)
            if (x < v.x || x >= 30 || y < v.y || y >= v.y + v.height)
                assert_true(untouched(x, y));
            else
                assert_memory_equal(seen[y][x], whole[4 * (y - v.y) + 2][2 * (x - v.x) + 1], 4);
}

static void test_state_stays(void** state) {
    const dgbgl_view_desc v = view_of(DGBGL_VIEW_REFLECTION_LAYER, 0);
    GLint viewport[4], bound, unit, vertices, buffer;
    int i;
    (void)state;
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glUseProgram(program);
    glViewport(3, 4, 5, 6);
    glEnable(GL_BLEND);
    glEnable(GL_CULL_FACE);
    glCullFace(GL_FRONT_AND_BACK); /* would let nothing through */
    glColorMask(GL_FALSE, GL_TRUE, GL_FALSE, GL_TRUE);
    glBindVertexArray(f.vertex_array);
    glActiveTexture(GL_TEXTURE2);
    glBindTexture(GL_TEXTURE_2D, target);
    assert_int_equal(dgbgl_draw_view(&context, &v), DGB_OK);
    glGetIntegerv(GL_VIEWPORT, viewport);
    for (i = 0; i < 4; ++i) assert_int_equal(viewport[i], 3 + i);
    glGetIntegerv(GL_CURRENT_PROGRAM, &bound);
    assert_int_equal(bound, program);
    glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &buffer);
    assert_int_equal(buffer, framebuffer);
    glGetIntegerv(GL_ACTIVE_TEXTURE, &unit);
    assert_int_equal(unit, GL_TEXTURE2);
    glGetIntegerv(GL_TEXTURE_BINDING_2D, &bound);
    assert_int_equal(bound, target);
    glGetIntegerv(GL_VERTEX_ARRAY_BINDING, &vertices);
    assert_int_equal(vertices, f.vertex_array);
    assert_true(glIsEnabled(GL_BLEND) && glIsEnabled(GL_CULL_FACE));
    glDisable(GL_BLEND);
    glDisable(GL_CULL_FACE);
    glCullFace(GL_BACK);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glBindTexture(GL_TEXTURE_2D, 0);
    glActiveTexture(GL_TEXTURE0);
}

/* >> what there is not */

static void check_refused(dgbgl_view_desc v, const char* why) {
    clear();
    message[0] = 0;
    assert_int_equal(dgbgl_draw_view(&context, &v), DGB_INVALID);
    if (!strstr(message, why)) fail_msg("\"%s\", not \"%s\"", message, why);
    glReadPixels(0, 0, 1, 1, GL_RGBA, GL_UNSIGNED_BYTE, seen);
    assert_true(untouched(0, 0));
}

static void test_refusals(void** state) {
    dgbgl_view_desc v = view_of(DGBGL_VIEW_DEPTH, 2);
    dgb_context dead;
    (void)state;
    check_refused(v, "no such layer");
    v.layer = -1;
    check_refused(v, "no such layer");
    check_refused(view_of(DGBGL_VIEW_COUNT, 0), "no such view");
    check_refused(view_of(DGBGL_VIEW_LIGHT, 0), "needs a texture");
    v = view_of(DGBGL_VIEW_AO, 0);
    v.width = -1;
    check_refused(v, "width and height");
    v = view_of(DGBGL_VIEW_AO, 0);
    v.exposure = NAN;
    check_refused(v, "exposure");
    memset(&dead, 0, sizeof dead);
    assert_int_equal(dgbgl_draw_view(&dead, &v), DGB_INVALID);
    assert_int_equal(dgbgl_draw_view(NULL, &v), DGB_INVALID);
    assert_int_equal(dgbgl_draw_view(&context, NULL), DGB_INVALID);
    assert_string_equal(dgbgl_view_name(DGBGL_VIEW_REFLECTION_LAYER), "reflection_layer");
    assert_string_equal(dgbgl_view_legend(DGBGL_VIEW_COUNT), "?");
}

/* A context of one effect has no other's texture. */
static void test_effect_is_off(void** state) {
    const dgbgl_view_desc v = view_of(DGBGL_VIEW_IRRADIANCE, 0);
    dgb_desc d;
    dgb_context c;
    (void)state;
    memset(&d, 0, sizeof d);
    d.width = d.height = 16;
    d.effects = DGB_EFFECT_AO;
    d.backend = &f.gl.backend;
    assert_int_equal(dgb_init(&c, &d), DGB_OK);
    assert_int_equal(dgbgl_draw_view(&c, &v), DGB_INVALID);
    assert_non_null(strstr(message, "does not make this texture"));
    dgb_shutdown(&c);
    assert_int_equal(dgbgl_draw_view(&c, &v), DGB_INVALID);
}

static void test_no_messages(void** state) {
    (void)state;
    assert_int_equal(f.messages, 0);
    assert_int_equal(glGetError(), GL_NO_ERROR);
}

/* >> OpenGL ES 3.0 draws the same */

static void test_es(void** state) {
    static unsigned char desktop[DGBGL_VIEW_LIGHT][FRAME_HEIGHT][FRAME_WIDTH][4];
    int view, es;
    for (es = 0; es < 2; ++es) {
        if (es) {
            close_frame(state);
            assert_int_equal(open_frame(true), 0);
        }
        for (view = 0; view < DGBGL_VIEW_LIGHT; ++view) {
            const dgbgl_view_desc v = view_of((dgbgl_view)view, view <= DGBGL_VIEW_VALIDITY);
            look(&v);
            if (es)
                assert_memory_equal(desktop[view], seen, sizeof seen);
            else
                memcpy(desktop[view], seen, sizeof seen);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_layers),      cmocka_unit_test(test_results),
        cmocka_unit_test(test_divisor),     cmocka_unit_test(test_validity),
        cmocka_unit_test(test_history),     cmocka_unit_test(test_light),
        cmocka_unit_test(test_rectangle),   cmocka_unit_test(test_state_stays),
        cmocka_unit_test(test_refusals),    cmocka_unit_test(test_effect_is_off),
        cmocka_unit_test(test_no_messages), cmocka_unit_test(test_es), /* the last: it opens another context */
    };
    return cmocka_run_group_tests(tests, open_desktop, close_frame);
}
