/* Tiles: skipping the second layer where it cannot matter changes no bit of any result, and skips something. */
#include "gl_fixture.h"
#include "numbers.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static fixture f;

enum { ALL_EFFECTS = DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY | DGB_EFFECT_BOUNCES | DGB_EFFECT_TEMPORAL };

typedef struct setup {
    int width, height, guard, divisor;
    uint32_t effects;
    dgb_senders senders;
    fixture_view view;
    dgb_params params;
} setup;

static setup default_setup(void) {
    setup s;
    memset(&s, 0, sizeof s);
    s.width = 333;
    s.height = 187;
    s.guard = 16;
    s.effects = ALL_EFFECTS;
    s.view = fixture_default_view();
    s.params = dgb_preset(DGB_PRESET_BALANCED);
    return s;
}

static dgb_desc desc_of(const setup* s) {
    dgb_desc d = fixture_desc(&f, &s->view, s->width, s->height, s->guard);
    d.divisor = s->divisor;
    d.effects = s->effects;
    d.senders = s->senders;
    return d;
}

static bool is_offered(const setup* s) {
    const dgb_desc d = desc_of(s);
    return fixture_offers(&f, &d);
}

static dgb_context open(const setup* s) {
    const dgb_desc d = desc_of(s);
    dgb_context c;
    assert_int_equal(dgb_init(&c, &d), DGB_OK);
    return c;
}

/* Three frames of a moving camera. */
static void run(dgb_context* c, const setup* s, bool adaptive) {
    fixture_view v = s->view;
    dgb_params q = s->params;
    fixture_draw_user user;
    int frame;
    memset(&user, 0, sizeof user);
    user.f = &f;
    user.program = fixture_program(c);
    q.adaptive = adaptive;
    for (frame = 0; frame < 3; ++frame) {
        dgb_view view;
        v.eye[0] += 0.05f;
        view = fixture_dgb_view(&v, s->width, s->height);
        assert_int_equal(dgb_build(c, &view, &q, fixture_draw, &user), DGB_OK);
        assert_int_equal(dgb_shade(c, &q), DGB_OK);
    }
    glDeleteProgram(user.program);
}

static float* read_tiles(const dgb_context* c, int* count) {
    const int width = (c->plan.width + DGB_TILE_SIZE - 1) / DGB_TILE_SIZE,
              height = (c->plan.height + DGB_TILE_SIZE - 1) / DGB_TILE_SIZE;
    *count = width * height;
    return fixture_read(dgb_get_texture(c, DGB_TILES), 0, 0, width, height, 0, GL_RGBA, 4);
}

/* Pixels of the shaded rectangle in which two contexts' images differ. */
static int differing(const dgb_context* a, const dgb_context* b, const dgb_params* q, dgb_slot slot, int channels) {
    float *x = fixture_image(a, slot, 0, channels), *y = fixture_image(b, slot, 0, channels);
    int rect[4], i, j, count = 0;
    fixture_shaded_rect(a, q, rect);
    for (j = rect[1]; x && j <= rect[3]; ++j)
        for (i = rect[0]; i <= rect[2]; ++i) {
            const size_t at = (size_t)(j * a->plan.width + i) * (size_t)channels;
            count += memcmp(x + at, y + at, (size_t)channels * sizeof(float)) != 0;
        }
    free(x);
    free(y);
    return count;
}

/* Adds to skipped the share of tiles that need no second layer: for occlusion, for light, to receive. */
static void compare(const char* name, const setup* s, double skipped[3]) {
    dgb_context adaptive = open(s), whole = open(s);
    float* tiles;
    int count, i, k, wrong;
    run(&adaptive, s, true);
    run(&whole, s, false);
    wrong = differing(&adaptive, &whole, &s->params, DGB_AO_RAW, 1) +
            differing(&adaptive, &whole, &s->params, DGB_IRRADIANCE_RAW, 4) +
            differing(&adaptive, &whole, &s->params, DGB_IRRADIANCE1_RAW, 4) +
            differing(&adaptive, &whole, &s->params, DGB_AO, 1) +
            differing(&adaptive, &whole, &s->params, DGB_IRRADIANCE, 4) +
            differing(&adaptive, &whole, &s->params, DGB_IRRADIANCE1, 4);
    if (wrong) print_error("%s: %d pixels differ\n", name, wrong);
    assert_int_equal(wrong, 0);
    tiles = read_tiles(&adaptive, &count);
    for (k = 0; k < 3; ++k) {
        int zeros = 0;
        for (i = 0; i < count; ++i) zeros += tiles[4 * i + k] == 0.0f;
        skipped[k] += (double)zeros / count;
    }
    free(tiles);
    dgb_shutdown(&adaptive);
    dgb_shutdown(&whole);
}

static void test_radii(void** state) {
    static const float radii[] = {0.02f, 0.2f, 0.7f, 2.0f, 50.0f};
    double skipped[3] = {0.0, 0.0, 0.0};
    size_t i;
    (void)state;
    for (i = 0; i < sizeof radii / sizeof radii[0]; ++i) {
        setup s = default_setup();
        char name[64];
        s.params.ao_radius = radii[i];
        s.params.radius = radii[sizeof radii / sizeof radii[0] - 1 - i];
        snprintf(name, sizeof name, "radii %g and %g", (double)s.params.ao_radius, (double)s.params.radius);
        compare(name, &s, skipped);
    }
    /* the room has a second layer almost everywhere, but the small radii reach it almost nowhere */
    assert_true(skipped[0] > 1.0 && skipped[0] < 4.9);
    assert_true(skipped[1] > 1.0 && skipped[1] < 4.9);
    assert_true(skipped[2] < 4.9);
}

static void test_setups(void** state) {
    double skipped[3] = {0.0, 0.0, 0.0};
    setup s = default_setup();
    (void)state;
    s.params.min_level = s.params.ao_min_level = 5;
    s.params.radius = 1.0f;
    compare("coarse taps", &s, skipped);
    s = default_setup();
    s.divisor = 2;
    if (is_offered(&s)) compare("half resolution", &s, skipped);
    s = default_setup();
    s.senders = DGB_SENDERS_STRONGEST;
    s.params.normal_test = false;
    compare("strongest sender", &s, skipped);
    s = default_setup();
    s.view.fov = 0.0f;
    compare("orthographic", &s, skipped);
    s = default_setup();
    s.view.reversed = true;
    s.view.clip = DGB_CLIP_ZERO_TO_ONE;
    s.view.far_plane = 0.0f;
    if (is_offered(&s)) compare("reversed", &s, skipped);
    s = default_setup();
    s.width = s.height = 17;
    s.guard = 0;
    compare("tiny", &s, skipped);
    s = default_setup();
    s.effects = DGB_EFFECT_AO;
    compare("occlusion alone", &s, skipped);
    s = default_setup();
    s.effects = DGB_EFFECT_RADIOSITY;
    compare("one bounce", &s, skipped);
}

/* Where there is no second layer at all, no tile wants one. */
static void test_nothing_behind(void** state) {
    double skipped[3] = {0.0, 0.0, 0.0};
    setup s = default_setup();
    (void)state;
    s.params.separation = 1e4f;
    compare("nothing behind", &s, skipped);
    assert_true(skipped[0] == 1.0 && skipped[1] == 1.0 && skipped[2] == 1.0);
}

/* >> scattered second-layer texels, each of which alone may matter */

static GLuint upload(GLint internal, GLenum format, const setup* s, const float* texels) {
    GLuint name;
    glGenTextures(1, &name);
    glBindTexture(GL_TEXTURE_2D, name);
    glTexImage2D(GL_TEXTURE_2D, 0, internal, s->width, s->height, 0, format, GL_FLOAT, texels);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glBindTexture(GL_TEXTURE_2D, 0);
    return name;
}

static uint32_t random_state = 1u;

static float random_unit(void) { return (float)lcg_unit(&random_state); }

/* Window depth of camera z. */
static float depth_of(const dgb_view* view, float z) {
    const float* p = view->projection;
    return 0.5f * (p[10] * z + p[14]) / (p[11] * z + p[15]) + 0.5f;
}

/* A wall 10 m away whose normals point anywhere, and few texels up to half a metre behind it: whether one is within
   reach of a pixel hangs on its depth and its place, by a little. */
static void scatter(const setup* s, const dgb_view* view, GLuint names[5], dgb_layers* layers) {
    const int count = s->width * s->height;
    float* depth[2] = {(float*)malloc((size_t)count * sizeof(float)), (float*)malloc((size_t)count * sizeof(float))};
    float *normals = (float*)malloc((size_t)count * 3 * sizeof(float)),
          *light = (float*)malloc((size_t)count * 3 * sizeof(float));
    int i, k;
    for (i = 0; i < count; ++i) {
        depth[0][i] = depth_of(view, -10.0f);
        depth[1][i] = random_unit() < 0.00005f ? depth_of(view, -10.05f - 0.5f * random_unit()) : 1.0f;
        for (k = 0; k < 3; ++k) {
            normals[3 * i + k] = 2.0f * random_unit() - 1.0f;
            light[3 * i + k] = random_unit();
        }
    }
    names[0] = upload(GL_R32F, GL_RED, s, depth[0]);
    names[1] = upload(GL_R32F, GL_RED, s, depth[1]);
    names[2] = upload(GL_RGB16F, GL_RGB, s, normals);
    names[3] = upload(GL_RGB16F, GL_RGB, s, light);
    names[4] = 0;
    memset(layers, 0, sizeof *layers);
    for (k = 0; k < 2; ++k) {
        layers->depth[k] = dgbgl_texture(names[k]);
        layers->normal[k] = dgbgl_texture(names[2]);
        layers->radiance[k] = dgbgl_texture(names[3]);
        free(depth[k]);
    }
    free(normals);
    free(light);
}

static void test_scattered(void** state) {
    static const float radii[] = {0.7f, 3.0f}; /* the second by regions */
    int i;
    (void)state;
    for (i = 0; i < 2; ++i) {
        setup s = default_setup();
        dgb_context c[2];
        dgb_layers layers;
        dgb_view view;
        GLuint names[5];
        int k;
        s.width = 999; /* so that a texel is mostly alone within reach */
        s.height = 601;
        s.guard = 0;
        s.params.separation = 0.02f;
        s.effects = DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY;
        s.params.ao_radius = s.params.radius = radii[i];
        s.params.samples = 128;
        s.params.min_level = 0;
        s.params.normal_test = false;
        view = fixture_dgb_view(&s.view, s.width, s.height);
        scatter(&s, &view, names, &layers);
        for (k = 0; k < 2; ++k) {
            dgb_desc d = fixture_desc(&f, &s.view, s.width, s.height, 0);
            d.effects = s.effects;
            d.source = DGB_SOURCE_ENGINE;
            d.normals = DGB_NORMALS_FLOAT;
            assert_int_equal(dgb_init(&c[k], &d), DGB_OK);
            s.params.adaptive = k == 0;
            assert_int_equal(dgb_set_layers(&c[k], &view, &layers), DGB_OK);
            assert_int_equal(dgb_shade(&c[k], &s.params), DGB_OK);
        }
        assert_int_equal(differing(&c[0], &c[1], &s.params, DGB_AO_RAW, 1), 0);
        assert_int_equal(differing(&c[0], &c[1], &s.params, DGB_IRRADIANCE_RAW, 4), 0);
        for (k = 0; k < 2; ++k) dgb_shutdown(&c[k]);
        glDeleteTextures(5, names);
    }
}

FIXTURE_CONTEXT(f, 4, 5, false)

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_radii),     cmocka_unit_test(test_setups),      cmocka_unit_test(test_nothing_behind),
        cmocka_unit_test(test_scattered), cmocka_unit_test(test_no_messages),
    };
    return cmocka_run_group_tests(tests, open_context, close_context);
}
