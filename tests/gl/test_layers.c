/* The layers themselves: minimum separation, and that every way of building them gives the same as peeling. */
#include "gl_fixture.h"
#include "numbers.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { WIDTH = 200, HEIGHT = 120, GUARD = 16 };

static fixture f;

typedef struct built { /* everything one build wrote */
    dgb_camera camera;
    float* back; /* camera z, 0 where there is none; null where nobody asked */
    int width, height, layers, divisor;
    float* z[DGB_MAX_LAYERS];          /* camera z, 0 where empty */
    float* targets[DGB_MAX_LAYERS][4]; /* albedo, normal, radiance, velocity */
} built;

static const struct {
    dgb_slot slot;
    GLenum format;
    int channels;
} target_slots[4] = {
    {DGB_ALBEDO, GL_RGBA, 4}, {DGB_NORMAL, GL_RGBA, 4}, {DGB_RADIANCE, GL_RGB, 3}, {DGB_VELOCITY, GL_RG, 2}};

static built read_layers(const dgb_context* c) {
    built b;
    const float codes = c->desc.depth_format == DGB_FORMAT_D16   ? 65535.0f
                        : c->desc.depth_format == DGB_FORMAT_D24 ? 16777215.0f
                                                                 : 0.0f;
    int layer, target, i;
    memset(&b, 0, sizeof b);
    b.camera = c->camera;
    b.width = c->plan.width;
    b.height = c->plan.height;
    b.layers = c->plan.layers;
    b.divisor = c->desc.divisor;
    if (dgb_get_texture(c, DGB_BACK).id)
        b.back = fixture_read(dgb_get_texture(c, DGB_BACK), 0, 0, b.width, b.height, 0, GL_DEPTH_COMPONENT, 1);
    for (i = 0; b.back && i < b.width * b.height; ++i)
        b.back[i] = dgb_linear_z(dgb_depth_code(b.back[i], codes), &c->camera);
    for (layer = 0; layer < b.layers; ++layer) {
        b.z[layer] =
            fixture_read(dgb_get_texture(c, DGB_DEPTH), 0, layer, b.width, b.height, b.layers, GL_DEPTH_COMPONENT, 1);
        for (i = 0; i < b.width * b.height; ++i)
            b.z[layer][i] = dgb_linear_z(dgb_depth_code(b.z[layer][i], codes), &c->camera);
        for (target = 0; target < 4; ++target)
            b.targets[layer][target] =
                fixture_read(dgb_get_texture(c, target_slots[target].slot), 0, layer, b.width, b.height, b.layers,
                             target_slots[target].format, target_slots[target].channels);
    }
    return b;
}

static void free_layers(built* b) {
    int layer, target;
    free(b->back);
    for (layer = 0; layer < b->layers; ++layer) {
        free(b->z[layer]);
        for (target = 0; target < 4; ++target) free(b->targets[layer][target]);
    }
}

/* Texels that differ in anything. */
static int count_differences(const built* a, const built* b) {
    int layer, target, i, count = 0;
    for (layer = 0; layer < a->layers; ++layer)
        for (i = 0; i < a->width * a->height; ++i) {
            bool same = same_bits(&a->z[layer][i], &b->z[layer][i], sizeof(float));
            for (target = 0; target < 4; ++target) {
                const size_t channels = (size_t)target_slots[target].channels;
                same = same && memcmp(a->targets[layer][target] + (size_t)i * channels,
                                      b->targets[layer][target] + (size_t)i * channels, channels * sizeof(float)) == 0;
            }
            count += !same;
        }
    return count;
}

/* Texel of the layer before `layer` that lies in front of the middle of texel i. */
static int front_texel(const built* b, int layer, int i) {
    const int x = i % b->width, y = i / b->width;
    if (layer > 1) return i;
    return (y * b->divisor + b->divisor / 2) * b->width + x * b->divisor + b->divisor / 2;
}

/* Layer-j texels that are not more than the separation behind layer j-1, and layer-j texels in all. */
static void count_violations(const built* b, float separation, int* violations, int* filled) {
    int layer, i;
    *violations = *filled = 0;
    for (layer = 1; layer < b->layers; ++layer)
        for (i = 0; i < b->width * b->height; ++i) {
            if (b->z[layer][i] == 0.0f) continue;
            ++*filled;
            *violations += !dgb_keep_test(b->z[layer][i], b->z[layer - 1][front_texel(b, layer, i)], separation);
        }
}

typedef struct setup {
    dgb_oracle oracle;
    dgb_emission emission;
    int layers;
    dgb_format depth_format;
    bool moving;        /* camera and box move from frame to frame */
    float speed;        /* of the camera */
    bool still_objects; /* moving: the camera alone */
    bool knows_next;    /* the next view is told, not guessed */
    int divisor;
    float separation;
    bool back; /* faces are drawn */
    fixture_view view;
} setup;

static setup default_setup(dgb_oracle oracle, dgb_emission emission) {
    setup s;
    memset(&s, 0, sizeof s);
    s.oracle = oracle;
    s.emission = emission;
    s.layers = 2;
    s.speed = 1.0f;
    s.separation = 0.5f;
    s.view = fixture_default_view();
    return s;
}

static dgb_desc desc_of(const setup* s) {
    dgb_desc d = fixture_desc(&f, &s->view, WIDTH, HEIGHT, GUARD);
    d.layers = s->layers;
    d.divisor = s->divisor;
    d.oracle = s->oracle;
    d.emission = s->emission;
    d.depth_format = s->depth_format;
    if (s->back) d.thickness = DGB_THICKNESS_BACK_FACES, d.effects = DGB_EFFECT_REFLECT; /* which reads them */
    return d;
}

static bool is_offered(setup s) {
    const dgb_desc d = desc_of(&s);
    return fixture_offers(&f, &d);
}

static fixture_view camera_at(const setup* s, int frame) {
    fixture_view v = s->view;
    if (s->moving) {
        v.eye[0] += 0.045f * s->speed * (float)frame;
        v.yaw += 0.006f * s->speed * (float)frame;
    }
    return v;
}

static dgb_view view_at(const setup* s, int frame) {
    const fixture_view now = camera_at(s, frame), next = camera_at(s, frame + 1);
    dgb_view view = fixture_dgb_view(&now, WIDTH, HEIGHT);
    int i;
    for (i = 0; i < 4; ++i) f.offsets[i] = s->moving && !s->still_objects ? 0.1f * (float)(frame + i - 2) : 0.0f;
    view.has_next = s->knows_next;
    if (s->knows_next) memcpy(view.next_view, fixture_dgb_view(&next, WIDTH, HEIGHT).view, sizeof view.next_view);
    return view;
}

/* The layers after `frames` frames. */
static built build_frames(const setup* s, int frames) {
    dgb_context c;
    dgb_desc d = desc_of(s);
    dgb_params q = dgb_preset(DGB_PRESET_BALANCED);
    fixture_draw_user user;
    built b;
    int frame;
    memset(&user, 0, sizeof user);
    user.f = &f;
    q.separation = s->separation;
    assert_int_equal(dgb_init(&c, &d), DGB_OK);
    user.program = fixture_program(&c);
    assert_true(user.program != 0);
    for (frame = 0; frame < frames; ++frame) {
        dgb_view view = view_at(s, frame);
        assert_int_equal(dgb_build(&c, &view, &q, fixture_draw, &user), DGB_OK);
    }
    b = read_layers(&c);
    glDeleteProgram(user.program);
    dgb_shutdown(&c);
    return b;
}

static void check_against_peel(setup s, int frames) {
    setup peel = s;
    built a = build_frames(&s, frames), b;
    int violations, filled;
    peel.oracle = DGB_ORACLE_PEEL;
    peel.emission = DGB_EMISSION_AUTO;
    b = build_frames(&peel, frames);
    count_violations(&b, s.separation, &violations, &filled);
    if (s.layers > 1) /* or the comparison means nothing */
        assert_true(filled > WIDTH * HEIGHT / 10 / (s.divisor > 1 ? s.divisor * s.divisor : 1));
    assert_int_equal(violations, 0);
    assert_int_equal(count_differences(&a, &b), 0);
    free_layers(&a);
    free_layers(&b);
}

static void still_equals_peel(dgb_oracle oracle, dgb_emission emission) {
    static const float separations[] = {0.5f, 0.0f, 0.05f};
    size_t i;
    for (i = 0; i < 3; ++i) {
        setup s = default_setup(oracle, emission);
        s.separation = separations[i];
        check_against_peel(s, 2);
        check_against_peel(s, 3);
    }
}

static void test_previous_separate(void** state) {
    (void)state;
    still_equals_peel(DGB_ORACLE_PREVIOUS, DGB_EMISSION_SEPARATE);
}
static void test_previous_vertex(void** state) {
    (void)state;
    still_equals_peel(DGB_ORACLE_PREVIOUS, DGB_EMISSION_VERTEX);
}
static void test_reproject_separate(void** state) {
    (void)state;
    still_equals_peel(DGB_ORACLE_REPROJECT, DGB_EMISSION_SEPARATE);
}
static void test_reproject_vertex(void** state) {
    (void)state;
    still_equals_peel(DGB_ORACLE_REPROJECT, DGB_EMISSION_VERTEX);
}

/* Emissions that build the same bits as peeling. */
static const dgb_emission exact[] = {DGB_EMISSION_SEPARATE, DGB_EMISSION_VERTEX, DGB_EMISSION_IMAGE};
enum { EXACT = sizeof exact / sizeof exact[0] };

static void each_still_equals_peel(dgb_oracle oracle) {
    int i;
    for (i = 0; i < EXACT; ++i)
        if (is_offered(default_setup(oracle, exact[i]))) still_equals_peel(oracle, exact[i]);
}

static void test_warp(void** state) {
    int i;
    (void)state;
    each_still_equals_peel(DGB_ORACLE_WARP);
    for (i = 0; i < EXACT; ++i) { /* reversed, depth is so dense that no inverse of it is exact */
        setup s = default_setup(DGB_ORACLE_WARP, exact[i]);
        s.view.reversed = true, s.view.clip = DGB_CLIP_ZERO_TO_ONE, s.view.far_plane = 0.0f;
        s.separation = 0.0f;
        if (is_offered(s)) check_against_peel(s, 3);
    }
}

static void test_image(void** state) {
    (void)state;
    still_equals_peel(DGB_ORACLE_PREVIOUS, DGB_EMISSION_IMAGE);
    still_equals_peel(DGB_ORACLE_REPROJECT, DGB_EMISSION_IMAGE);
}

static void test_predict(void** state) {
    (void)state;
    each_still_equals_peel(DGB_ORACLE_PREDICT);
}

static void test_delay(void** state) {
    (void)state;
    each_still_equals_peel(DGB_ORACLE_DELAY);
}

/* Moving: with the true next pose PREDICT is exact, and DELAY shows the frame before, exactly. */
static void moving_equals_peel(dgb_oracle oracle, dgb_emission emission, int late) {
    setup s = default_setup(oracle, emission), peel;
    built a, b;
    s.moving = true;
    s.knows_next = true;
    peel = s;
    peel.oracle = DGB_ORACLE_PEEL, peel.emission = DGB_EMISSION_AUTO;
    a = build_frames(&s, 5);
    b = build_frames(&peel, 5 - late);
    assert_int_equal(count_differences(&a, &b), 0);
    free_layers(&a);
    free_layers(&b);
}

static void test_moving_predict(void** state) {
    (void)state;
    moving_equals_peel(DGB_ORACLE_PREDICT, DGB_EMISSION_VERTEX, 0);
    moving_equals_peel(DGB_ORACLE_PREDICT, DGB_EMISSION_IMAGE, 0);
}

static void test_moving_delay(void** state) {
    (void)state;
    moving_equals_peel(DGB_ORACLE_DELAY, DGB_EMISSION_SEPARATE, 1);
    if (is_offered(default_setup(DGB_ORACLE_DELAY, DGB_EMISSION_VERTEX)))
        moving_equals_peel(DGB_ORACLE_DELAY, DGB_EMISSION_VERTEX, 1);
}

/* Geometry shaders and viewport indices bring clipping, which moves the last bits of depth: coverage may differ in 1e-4
   of the texels, depth by 1e-4. */
static void check_nearly_peel(setup s, int frames) {
    setup peel = s;
    built a, b;
    int layer, i, coverage = 0, depth = 0;
    peel.oracle = DGB_ORACLE_PEEL, peel.emission = DGB_EMISSION_AUTO;
    a = build_frames(&s, frames);
    b = build_frames(&peel, frames);
    for (layer = 0; layer < a.layers; ++layer)
        for (i = 0; i < a.width * a.height; ++i) {
            const float za = a.z[layer][i], zb = b.z[layer][i];
            if ((za == 0.0f) != (zb == 0.0f) || fabsf(za - zb) > 0.25f)
                ++coverage; /* another surface, or none */
            else if (fabsf(za - zb) > 1e-4f * fabsf(zb))
                ++depth;
        }
    if (coverage + depth)
        printf("# %s, %s, %d layers, 1/%d: %d texels of another coverage, %d of another depth\n",
               dgb_emission_name(s.emission), dgb_oracle_name(s.oracle), s.layers, s.divisor, coverage, depth);
    assert_true(coverage <= a.layers * a.width * a.height / 10000);
    assert_int_equal(depth, 0);
    free_layers(&a);
    free_layers(&b);
}

/* A guess from a steady camera is close to the truth. */
static void test_extrapolation(void** state) {
    setup s = default_setup(DGB_ORACLE_PREDICT, DGB_EMISSION_AUTO), peel;
    built a, b;
    int i, wrong = 0;
    (void)state;
    s.moving = true;
    peel = s;
    peel.oracle = DGB_ORACLE_PEEL, peel.emission = DGB_EMISSION_AUTO;
    a = build_frames(&s, 6);
    b = build_frames(&peel, 6);
    for (i = 0; i < a.width * a.height; ++i) wrong += fabsf(a.z[1][i] - b.z[1][i]) > 1e-3f;
    printf("# layer-1 texels that differ from peeling: predict %d of %d\n", wrong, a.width * a.height);
    assert_true(wrong < a.width * a.height / 200);
    free_layers(&a);
    free_layers(&b);
}

static void test_divisor(void** state) {
    static const dgb_emission emissions[] = {DGB_EMISSION_SEPARATE, DGB_EMISSION_VERTEX, DGB_EMISSION_GEOMETRY,
                                             DGB_EMISSION_INSTANCED_GEOMETRY};
    static const dgb_oracle oracles[] = {DGB_ORACLE_PREVIOUS, DGB_ORACLE_REPROJECT, DGB_ORACLE_DELAY, DGB_ORACLE_WARP};
    int e, o, divisor, layers;
    (void)state;
    for (divisor = 2; divisor <= 4; divisor *= 2)
        for (layers = 2; layers <= 3; ++layers)
            for (e = 0; e < 4; ++e)
                for (o = 0; o < 4; ++o) {
                    setup s = default_setup(oracles[o], emissions[e]);
                    s.divisor = divisor;
                    s.layers = layers;
                    if (emissions[e] == DGB_EMISSION_SEPARATE)
                        check_against_peel(s, 4);
                    else
                        check_nearly_peel(s, 4);
                }
}

static void test_geometry(void** state) {
    static const dgb_emission emissions[] = {DGB_EMISSION_GEOMETRY, DGB_EMISSION_INSTANCED_GEOMETRY};
    static const dgb_oracle oracles[] = {DGB_ORACLE_PREVIOUS, DGB_ORACLE_REPROJECT, DGB_ORACLE_PREDICT,
                                         DGB_ORACLE_DELAY, DGB_ORACLE_WARP};
    int e, o;
    (void)state;
    for (e = 0; e < 2; ++e)
        for (o = 0; o < 5; ++o) {
            const setup s = default_setup(oracles[o], emissions[e]);
            if (is_offered(s)) check_nearly_peel(s, 3);
        }
}

static void test_conventions(void** state) {
    static const dgb_format formats[] = {DGB_FORMAT_D16, DGB_FORMAT_D24, DGB_FORMAT_D32F};
    static const dgb_oracle oracles[] = {DGB_ORACLE_REPROJECT, DGB_ORACLE_WARP};
    const bool single = f.gl.backend.caps.emission[DGB_EMISSION_VERTEX];
    int kind, format, i;
    (void)state;
    for (i = 0; i < 5 * 3 * 2; ++i) {
        setup s = default_setup(oracles[i % 2], single ? DGB_EMISSION_VERTEX : DGB_EMISSION_SEPARATE);
        kind = i / 6, format = i / 2 % 3;
        s.depth_format = formats[format];
        if (kind == 1) s.view.reversed = true, s.view.clip = DGB_CLIP_ZERO_TO_ONE;
        if (kind == 2) s.view.reversed = true, s.view.clip = DGB_CLIP_ZERO_TO_ONE, s.view.far_plane = 0.0f;
        if (kind == 3) s.view.fov = 0.0f;
        if (kind == 4) s.view.jitter[0] = 0.3f, s.view.jitter[1] = -0.4f;
        if (kind == 2 && formats[format] == DGB_FORMAT_D16) continue; /* 8 m behind 0.1: D16 resolves no 0.5 m there */
        if (is_offered(s)) check_against_peel(s, 3);
    }
}

static void test_k_layers(void** state) {
    static const dgb_oracle oracles[] = {DGB_ORACLE_REPROJECT, DGB_ORACLE_PREVIOUS, DGB_ORACLE_PREDICT,
                                         DGB_ORACLE_DELAY, DGB_ORACLE_WARP};
    int layers, o, e;
    (void)state;
    for (layers = 1; layers <= 8; layers += layers < 4 ? 1 : 4)
        for (o = 0; o < 5; ++o)
            for (e = 0; e < EXACT; ++e) {
                setup s = default_setup(oracles[o], exact[e]);
                s.layers = layers;
                s.separation = 0.2f;
                if (is_offered(s)) check_against_peel(s, layers + 1);
            }
}

/* >> back faces, against layers peeled by no separation, which hold every surface there is: the nearest behind the
   first whose normal faces away */

static void point_at(const built* b, int i, float z, float point[3]) {
    const int column = i % b->width, row = i / b->width, divisor = b->divisor;
    dgb_position(((float)column + 0.5f) * (float)divisor, ((float)row + 0.5f) * (float)divisor, z, &b->camera, point);
}

/* The first of such layers at a texel that shows its back; 0: none. */
static int back_layer(const built* b, int i) {
    int layer;
    for (layer = 1; layer < b->layers && b->z[layer][i] != 0.0f; ++layer) {
        float point[3], n[3], view[3] = {0.0f, 0.0f, -1.0f};
        const float* bytes = b->targets[layer][1] + 4 * i;
        point_at(b, i, b->z[layer][i], point);
        dgb_oct16_decode((uint16_t)((int)(bytes[0] * 255.0f + 0.5f) | (int)(bytes[1] * 255.0f + 0.5f) << 8), n);
        if (b->camera.footprint[1] != 0.0f) memcpy(view, point, sizeof view);
        if (n[0] * view[0] + n[1] * view[1] + n[2] * view[2] > 0.0f) return layer;
    }
    return 0;
}

/* A bottom of a box lies in the floor, which comes first and shows its front: there the back may be nearer than any
   that the layers show, and as far as the floor, whose height is 0. */
static bool is_on_floor(const built* b, int i, const fixture_view* v) {
    float point[3];
    point_at(b, i, b->back[i], point);
    return fabsf(point[1] + v->eye[1]) < 1e-3f;
}

/* tolerance: relative, of depth; 0: the same bits. Texels whose last layer is full may have a back face beyond it. */
static void check_back_faces(setup s, int frames, int late, float tolerance) {
    setup peel = s;
    const fixture_view v = s.view;
    built a, b;
    int i, found = 0, floors = 0, none = 0, wrong = 0, unknown = 0;
    s.back = true;
    peel.oracle = DGB_ORACLE_PEEL, peel.emission = DGB_EMISSION_AUTO;
    peel.layers = DGB_MAX_LAYERS;
    peel.separation = 0.0f;
    a = build_frames(&s, frames);
    b = build_frames(&peel, frames - late);
    a.divisor = b.divisor = s.divisor > 1 ? s.divisor : 1;
    for (i = 0; i < a.width * a.height; ++i) {
        const int layer = back_layer(&b, i);
        const float z = layer ? b.z[layer][i] : 0.0f;
        if (!layer && b.z[DGB_MAX_LAYERS - 1][i] != 0.0f)
            ++unknown;
        else if (fabsf(a.back[i] - z) <= tolerance * fabsf(z))
            ++*(layer ? &found : &none);
        else if (a.back[i] != 0.0f && (!layer || a.back[i] > z) && is_on_floor(&a, i, &v))
            ++floors;
        else
            ++wrong;
    }
    if (wrong) printf("# %d right, %d none, %d floors, %d wrong, %d unknown\n", found, none, floors, wrong, unknown);
    assert_int_equal(wrong, 0);
    assert_true(found > WIDTH * HEIGHT / 10 / (a.divisor * a.divisor) && unknown < found / 10);
    free_layers(&a);
    free_layers(&b);
}

static void test_back_faces(void** state) {
    static const dgb_emission emissions[] = {DGB_EMISSION_SEPARATE, DGB_EMISSION_VERTEX, DGB_EMISSION_IMAGE,
                                             DGB_EMISSION_GEOMETRY, DGB_EMISSION_INSTANCED_GEOMETRY};
    int e;
    setup s;
    (void)state;
    for (e = 0; e < 5; ++e) { /* geometry shaders move the last bits */
        s = default_setup(DGB_ORACLE_REPROJECT, emissions[e]);
        if (is_offered(s)) check_back_faces(s, 2, 0, e < 3 ? 0.0f : 1e-4f);
    }
    s = default_setup(DGB_ORACLE_PEEL, DGB_EMISSION_AUTO);
    s.layers = 1;
    check_back_faces(s, 1, 0, 0.0f);
    s.view.eye[2] = -18.0f, s.view.yaw = 3.14159265f; /* from behind the wall, whose back is the first layer */
    check_back_faces(s, 1, 0, 0.0f);
    s = default_setup(DGB_ORACLE_REPROJECT, DGB_EMISSION_SEPARATE);
    s.divisor = 2;
    if (is_offered(s)) check_back_faces(s, 2, 0, 0.0f);
    s = default_setup(DGB_ORACLE_WARP, DGB_EMISSION_VERTEX);
    s.view.reversed = true, s.view.clip = DGB_CLIP_ZERO_TO_ONE;
    s.depth_format = DGB_FORMAT_D24;
    if (is_offered(s)) check_back_faces(s, 2, 0, 0.0f);
    s = default_setup(DGB_ORACLE_REPROJECT, DGB_EMISSION_VERTEX);
    s.view.fov = 0.0f;
    if (is_offered(s)) check_back_faces(s, 2, 0, 0.0f);
    s = default_setup(DGB_ORACLE_DELAY, DGB_EMISSION_IMAGE); /* of the pose that is drawn */
    s.moving = true;
    if (is_offered(s)) check_back_faces(s, 4, 1, 0.0f);
    s = default_setup(DGB_ORACLE_PREDICT, DGB_EMISSION_VERTEX);
    s.moving = true;
    if (is_offered(s)) check_back_faces(s, 3, 0, 0.0f);
}

/* What the shading reads of them: at every pixel the texel that it lies in, unless that is not behind the pixel's own
   surface. */
static void check_packed_back(int divisor) {
    setup s = default_setup(DGB_ORACLE_REPROJECT, DGB_EMISSION_SEPARATE);
    dgb_params q = dgb_preset(DGB_PRESET_BALANCED);
    fixture_draw_user user = {0};
    dgb_context c;
    dgb_desc d;
    dgb_view view = view_at(&s, 0);
    built b;
    float* z;
    int x, y, kept = 0, wrong = 0;
    s.back = true;
    s.divisor = divisor;
    if (!is_offered(s)) return;
    d = desc_of(&s);
    user.f = &f;
    assert_int_equal(dgb_init(&c, &d), DGB_OK);
    user.program = fixture_program(&c);
    assert_int_equal(dgb_build(&c, &view, &q, fixture_draw, &user), DGB_OK);
    assert_int_equal(dgb_shade(&c, &q), DGB_OK);
    b = read_layers(&c);
    z = fixture_image(&c, DGB_Z, 0, 4);
    for (y = 0; y < b.height; ++y)
        for (x = 0; x < b.width; ++x) {
            const int i = y * b.width + x;
            const float back = b.back[y / divisor * b.width + x / divisor];
            const bool keep = dgb_keep_test(back, b.z[0][i], 0.0f);
            const float expected = keep ? back : DGB_EMPTY_Z;
            kept += keep;
            wrong += fabsf(z[4 * i + 2] - expected) > 1e-6f * fabsf(expected); /* z by the shader's arithmetic */
        }
    assert_true(kept > WIDTH * HEIGHT / 10);
    assert_int_equal(wrong, 0);
    free(z);
    free_layers(&b);
    glDeleteProgram(user.program);
    dgb_shutdown(&c);
}

static void test_packed_back(void** state) {
    (void)state;
    check_packed_back(1);
    check_packed_back(2);
}

/* With motion an oracle errs, but REPROJECT less than PREVIOUS; layer 0 is never touched. */
static void test_motion(void** state) {
    static const dgb_oracle oracles[] = {DGB_ORACLE_PEEL, DGB_ORACLE_REPROJECT, DGB_ORACLE_PREVIOUS};
    built b[3];
    int wrong[3] = {0, 0, 0}, o, i, target;
    (void)state;
    for (o = 0; o < 3; ++o) {
        setup s = default_setup(oracles[o], DGB_EMISSION_SEPARATE); /* of exact ones the one that every device has */
        s.moving = true;
        b[o] = build_frames(&s, 6);
    }
    for (o = 1; o < 3; ++o) {
        const size_t image = (size_t)b[0].width * (size_t)b[0].height;
        assert_memory_equal(b[o].z[0], b[0].z[0], image * sizeof(float));
        for (target = 0; target < 4; ++target)
            assert_memory_equal(b[o].targets[0][target], b[0].targets[0][target],
                                image * (size_t)target_slots[target].channels * sizeof(float));
        for (i = 0; i < (int)image; ++i) wrong[o] += fabsf(b[o].z[1][i] - b[0].z[1][i]) > 1e-3f;
    }
    printf("# layer-1 texels that differ from peeling: reproject %d, previous %d of %d\n", wrong[1], wrong[2],
           b[0].width * b[0].height);
    assert_true(wrong[2] > 100);
    assert_true(3 * wrong[1] < wrong[2]);
    for (o = 0; o < 3; ++o) free_layers(&b[o]);
}

/* Layer-1 texels that differ from peeling after six frames. */
static int count_wrong(setup s, dgb_oracle oracle) {
    setup peel = s;
    built a, b;
    int i, wrong = 0;
    s.oracle = oracle;
    peel.oracle = DGB_ORACLE_PEEL, peel.emission = DGB_EMISSION_AUTO;
    a = build_frames(&s, 6);
    b = build_frames(&peel, 6);
    for (i = 0; i < a.width * a.height; ++i) wrong += fabsf(a.z[1][i] - b.z[1][i]) > 1e-3f;
    assert_memory_equal(a.z[0], b.z[0], (size_t)(a.width * a.height) * sizeof(float));
    free_layers(&a);
    free_layers(&b);
    return wrong;
}

/* While only the camera moves, WARP errs along silhouettes, which last frame's texels know to half a texel, and at the
   border. Measured: a seventh of PREVIOUS's error and three quarters of REPROJECT's; in a parallel projection, where
   the border takes the larger part, 0.39 and 0.71; with the camera four times as fast, 0.08 and 0.43. */
static void test_warp_moving_camera(void** state) {
    int kind;
    (void)state;
    for (kind = 0; kind < 6; ++kind) {
        setup s = default_setup(DGB_ORACLE_WARP, kind == 4 ? DGB_EMISSION_IMAGE : DGB_EMISSION_SEPARATE);
        int warp, reproject, previous;
        s.moving = s.still_objects = true;
        if (kind == 1) s.view.reversed = true, s.view.clip = DGB_CLIP_ZERO_TO_ONE, s.view.far_plane = 0.0f;
        if (kind == 2) s.view.fov = 0.0f;
        if (kind == 3) s.depth_format = DGB_FORMAT_D24;
        if (kind == 5) s.speed = 4.0f; /* what comes in front comes from far off */
        if (!is_offered(s)) continue;
        warp = count_wrong(s, DGB_ORACLE_WARP);
        reproject = count_wrong(s, DGB_ORACLE_REPROJECT);
        previous = count_wrong(s, DGB_ORACLE_PREVIOUS);
        printf("# layer-1 texels that differ from peeling: warp %d, reproject %d, previous %d\n", warp, reproject,
               previous);
        assert_true(previous > 1000);
        assert_true(warp < reproject);
        assert_true((kind == 2 ? 2 : kind == 5 ? 10 : 5) * warp < previous);
    }
}

/* What a steady frame submits: draw callbacks, and how often it shades each vertex. */
static void test_submissions(void** state) {
    enum { K = 3 };
    static const struct {
        dgb_oracle oracle;
        dgb_emission emission;
        int callbacks, shadings;
    } cases[] = {{DGB_ORACLE_PEEL, DGB_EMISSION_SEPARATE, K, K},
                 {DGB_ORACLE_REPROJECT, DGB_EMISSION_SEPARATE, K, K},
                 {DGB_ORACLE_REPROJECT, DGB_EMISSION_VERTEX, 1, K},
                 {DGB_ORACLE_REPROJECT, DGB_EMISSION_GEOMETRY, 1, 1},
                 {DGB_ORACLE_REPROJECT, DGB_EMISSION_INSTANCED_GEOMETRY, 1, 1},
                 {DGB_ORACLE_REPROJECT, DGB_EMISSION_IMAGE, 1, 1},
                 {DGB_ORACLE_WARP, DGB_EMISSION_VERTEX, 1, K},
                 {DGB_ORACLE_WARP, DGB_EMISSION_IMAGE, 1, 1},
                 {DGB_ORACLE_DELAY, DGB_EMISSION_GEOMETRY, 2, 2}, /* once a pose */
                 {DGB_ORACLE_PREDICT, DGB_EMISSION_INSTANCED_GEOMETRY, 2, 2},
                 {DGB_ORACLE_DELAY, DGB_EMISSION_IMAGE, 2, 2},
                 {DGB_ORACLE_PREDICT, DGB_EMISSION_IMAGE, 2, 2}};
    size_t i;
    (void)state;
    if (!epoxy_has_gl_extension("GL_ARB_pipeline_statistics_query")) skip();
    for (i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        setup s = default_setup(cases[i].oracle, cases[i].emission);
        built b;
        s.layers = K;
        if (!is_offered(s)) continue;
        f.draws = 0, f.vertices_shaded = 0, f.counts_vertices = true;
        b = build_frames(&s, 2); /* the first frame peels */
        free_layers(&b);
        f.counts_vertices = false;
        {
            const bool predicts = s.oracle == DGB_ORACLE_PREDICT || s.oracle == DGB_ORACLE_DELAY;
            const int first_callbacks = K + (predicts ? K - 1 : 0), vertices = f.static_count + f.moving_count;
            /* peeling through an instanced geometry shader or a vertex-shader layer still shades once a callback */
            assert_int_equal(f.draws, first_callbacks + cases[i].callbacks);
            assert_int_equal(f.vertices_shaded, (long long)vertices * (first_callbacks + cases[i].shadings));
        }
    }
}

static void test_empty_scene(void** state) {
    dgb_context c;
    setup s = default_setup(DGB_ORACLE_REPROJECT, DGB_EMISSION_AUTO);
    dgb_desc d = desc_of(&s);
    dgb_params q = dgb_preset(DGB_PRESET_BALANCED);
    dgb_view view = view_at(&s, 0);
    fixture_draw_user user;
    built b;
    int layer, i;
    (void)state;
    memset(&user, 0, sizeof user);
    user.f = &f;
    user.nothing = true;
    assert_int_equal(dgb_init(&c, &d), DGB_OK);
    assert_int_equal(dgb_build(&c, &view, &q, fixture_draw, &user), DGB_OK);
    assert_int_equal(dgb_build(&c, &view, &q, fixture_draw, &user), DGB_OK);
    b = read_layers(&c);
    assert_int_equal(b.layers, 2);
    for (layer = 0; layer < 2; ++layer)
        for (i = 0; b.z[layer] && i < b.width * b.height; ++i) {
            assert_true(b.z[layer][i] == 0.0f);
            assert_true(b.targets[layer][0][i * 4] == 0.0f && b.targets[layer][2][i * 3] == 0.0f);
        }
    free_layers(&b);
    dgb_shutdown(&c);
}

/* >> farther away than the depth format tells the separation */

/* Two walls across the view, in place of the fixture's scene; eye: where the camera is, looking down -Z. */
static void put_walls(const float eye[3], float distance, float apart) {
    static const float corners[6][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, -1}, {1, 1}, {-1, 1}};
    float vertices[12][9]; /* position, normal, colour */
    int i;
    memset(vertices, 0, sizeof vertices);
    for (i = 0; i < 12; ++i) {
        const float d = i < 6 ? distance : distance + apart;
        vertices[i][0] = eye[0] + 3.0f * d * corners[i % 6][0];
        vertices[i][1] = eye[1] + 3.0f * d * corners[i % 6][1];
        vertices[i][2] = eye[2] - d;
        vertices[i][5] = 1.0f;
    }
    glBindBuffer(GL_ARRAY_BUFFER, f.vertices);
    glBufferData(GL_ARRAY_BUFFER, sizeof vertices, vertices, GL_STATIC_DRAW);
    glBindBuffer(GL_ARRAY_BUFFER, 0);
    f.static_count = 12;
    f.moving_count = 0;
}

/* Second-layer texels, of which none may be nearer than the separation, let alone in front. */
static int count_behind(const setup* s) {
    built b = build_frames(s, 3);
    int violations, filled, i;
    count_violations(&b, s->separation, &violations, &filled);
    assert_int_equal(violations, 0);
    for (i = 0; i < b.width * b.height; ++i) {
        assert_true(b.z[0][i] < 0.0f);
        assert_true(b.z[1][i] == 0.0f || b.z[1][i] < b.z[0][i]);
    }
    free_layers(&b);
    return filled;
}

/* Walls two separations apart: at half the limit, where depths are a quarter of a separation or less apart, told by
   every pixel, though rasterisers' depths are off by steps; beyond, wherever depths differ. Leaves the fixture's own
   scene behind. */
static void test_separation_limit(void** state) {
    static const dgb_format formats[] = {DGB_FORMAT_D16, DGB_FORMAT_D24, DGB_FORMAT_D32F};
    static const float ratios[] = {0.1f, 0.5f, 0.98f, 1.3f, 4.0f, 100.0f};
    static const dgb_oracle oracles[] = {DGB_ORACLE_PEEL, DGB_ORACLE_REPROJECT, DGB_ORACLE_PREVIOUS};
    int i;
    (void)state;
    for (i = 0; i < 3 * 2 * 6; ++i) {
        setup s = default_setup(oracles[i % 3], i % 3 == 1 ? DGB_EMISSION_VERTEX : DGB_EMISSION_AUTO);
        dgb_camera camera;
        dgb_view view;
        float limit, ratio = ratios[i / 6];
        int behind;
        s.depth_format = formats[i % 3];
        s.view.eye[0] = s.view.eye[1] = s.view.eye[2] = s.view.yaw = 0.0f;
        s.view.near_plane = 0.1f;
        s.view.reversed = i / 3 % 2 != 0;
        s.view.far_plane = s.view.reversed ? 0.0f : 1e9f;
        s.view.clip = s.view.reversed ? DGB_CLIP_ZERO_TO_ONE : DGB_CLIP_NEGATIVE_ONE_TO_ONE;
        if (!is_offered(s)) continue;
        view = fixture_dgb_view(&s.view, WIDTH, HEIGHT);
        assert_int_equal(dgb_camera_from_matrix(view.projection, WIDTH, HEIGHT, s.view.clip, s.view.reversed, &camera),
                         DGB_OK);
        limit = dgb_separation_limit(s.separation, s.depth_format, &camera);
        assert_true(limit > 10.0f && limit < 1e8f);
        put_walls(s.view.eye, ratio * limit, 2.0f * s.separation);
        behind = count_behind(&s);
        if (ratio <= 0.5f) assert_int_equal(behind, (WIDTH + 2 * GUARD) * (HEIGHT + 2 * GUARD));
    }
    fixture_close(&f);
    assert_int_equal(fixture_open(&f, 4, 5, false, NULL), 0);
}

FIXTURE_CONTEXT(f, 4, 5, false)

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_previous_separate),
        cmocka_unit_test(test_previous_vertex),
        cmocka_unit_test(test_reproject_separate),
        cmocka_unit_test(test_reproject_vertex),
        cmocka_unit_test(test_warp),
        cmocka_unit_test(test_image),
        cmocka_unit_test(test_predict),
        cmocka_unit_test(test_delay),
        cmocka_unit_test(test_moving_predict),
        cmocka_unit_test(test_moving_delay),
        cmocka_unit_test(test_extrapolation),
        cmocka_unit_test(test_geometry),
        cmocka_unit_test(test_divisor),
        cmocka_unit_test(test_conventions),
        cmocka_unit_test(test_k_layers),
        cmocka_unit_test(test_back_faces),
        cmocka_unit_test(test_packed_back),
        cmocka_unit_test(test_motion),
        cmocka_unit_test(test_warp_moving_camera),
        cmocka_unit_test(test_submissions),
        cmocka_unit_test(test_empty_scene),
        cmocka_unit_test(test_no_messages),
        cmocka_unit_test(test_separation_limit),
        cmocka_unit_test(test_no_messages),
    };
    return cmocka_run_group_tests(tests, open_context, close_context);
}
