/* Whatever there is in the engine's textures, in the library's own, and in the parameters as far as they are accepted:
   every result is finite and in range at once, and after a cut it is as if nothing had been, bit for bit. */
#include "gl_images.h"
#include "numbers.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { WIDTH = 40, HEIGHT = 28, GUARD = 0, COUNT = WIDTH * HEIGHT };

#define OTHERS                                                                                              \
    (DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY | DGB_EFFECT_BOUNCES | DGB_EFFECT_TEMPORAL | DGB_EFFECT_REFLECT | \
     DGB_EFFECT_GLOSSY)

static fixture f;

/* >> numbers of every kind */

static uint32_t random_state;

static float random_unit(void) { return (float)(lcg_bits(&random_state) >> 8) / 16777216.0f; }

/* NaN, infinite, largest, 1e6, subnormal, negative ones; or any bits. */
static float injected(void) {
    static const uint32_t special[] = {0x7fc00000u, 0xffc00001u, 0x7f800000u, 0xff800000u, 0x7f7fffffu, 0xff7fffffu,
                                       0x49742400u, 0xc9742400u, 0x00000001u, 0x807fffffu, 0x80000000u, 0xbf800000u};
    const uint32_t kind = lcg_bits(&random_state) >> 8;
    return from_bits(kind & 1u ? special[(kind >> 1) % (sizeof special / sizeof special[0])]
                               : lcg_bits(&random_state) ^ lcg_bits(&random_state) << 16);
}

/* >> two engines that show the same, one of them with what is injected */

typedef struct how {
    const char* name;
    uint32_t effects;
    dgb_estimator estimator;
    dgb_tracer tracer;
    dgb_thickness thickness;
    dgb_normals normals;
    int layers;
} how;

static const how hows[] = {
    {"paper", OTHERS, DGB_ESTIMATOR_PAPER, DGB_TRACER_LINEAR, DGB_THICKNESS_LAYERS, DGB_NORMALS_FLOAT, 2},
    {"paper, one bounce", OTHERS & ~(uint32_t)DGB_EFFECT_BOUNCES, DGB_ESTIMATOR_PAPER, DGB_TRACER_LINEAR,
     DGB_THICKNESS_LAYERS, DGB_NORMALS_FLOAT, 2},
    {"paper, normals from depth, 1 layer", OTHERS, DGB_ESTIMATOR_PAPER, DGB_TRACER_HIERARCHICAL, DGB_THICKNESS_CONSTANT,
     DGB_NORMALS_FROM_DEPTH, 1},
    {"bitmask", OTHERS | DGB_EFFECT_BENT, DGB_ESTIMATOR_BITMASK, DGB_TRACER_HIERARCHICAL, DGB_THICKNESS_BACK_FACES,
     DGB_NORMALS_FLOAT, 2},
    {"bitmask, 1 layer", OTHERS | DGB_EFFECT_BENT, DGB_ESTIMATOR_BITMASK, DGB_TRACER_LINEAR, DGB_THICKNESS_CONSTANT,
     DGB_NORMALS_FLOAT, 1}};

typedef struct engine {
    const how* h;
    dgb_context c;
    images m;
    dgb_params params;
} engine;

static dgb_params ordinary_params(void) {
    dgb_params q = dgb_preset(DGB_PRESET_QUALITY);
    q.guard_fraction = 1.0f;
    q.slices = 2;
    q.history_clamp = 2.0f;
    q.sample_clamp = 4.0f;
    q.reflect_stride = 1;
    q.reflect_thickness = 2.0f;
    q.reflect_border = 0.0f;
    return q;
}

static void open_engine(engine* e, const how* h) {
    dgb_desc d;
    memset(e, 0, sizeof *e);
    e->h = h;
    e->m = images_open(WIDTH, HEIGHT);
    e->params = ordinary_params();
    d = images_desc(&f, &e->m, GUARD, h->layers, h->effects);
    d.estimator = h->estimator;
    d.tracer = h->tracer;
    d.thickness = h->thickness;
    d.normals = h->normals;
    d.log = NULL; /* parameters that are refused are no surprise */
    assert_int_equal(dgb_init(&e->c, &d), DGB_OK);
}

static void close_engine(engine* e) {
    dgb_shutdown(&e->c);
    images_close(&e->m);
}

/* Steps that face all ways, lit and rough in all ways: the surfaces always the same, their light for a seed. */
static void put_scene(engine* e, uint32_t seed) {
    int layer, x, y, k;
    random_state = seed;
    for (layer = 0; layer < 2; ++layer)
        for (y = 0; y < HEIGHT; ++y)
            for (x = 0; x < WIDTH; ++x) {
                const float normal[3] = {0.4f * (float)(x / 3 % 3 - 1), 0.4f * (float)(y / 3 % 3 - 1), 0.8f};
                images_put(&e->m, layer, x, y, 2.0 + 0.05 * x + 0.3 * (y / 4 % 3) + 2.0 * layer, normal);
                for (k = 0; k < 3; ++k) {
                    images_at(&e->m, IMAGE_RADIANCE, layer, x, y)[k] = 3.0f * random_unit();
                    images_at(&e->m, IMAGE_ALBEDO, layer, x, y)[k] = 0.8f * random_unit();
                }
                e->m.roughness[y * WIDTH + x] = random_unit();
                e->m.back[y * WIDTH + x] = *images_at(&e->m, IMAGE_DEPTH, 0, x, y) * 0.95f;
            }
}

/* One texel in `rarity` of every input of every kind. */
static void inject_inputs(engine* e, uint32_t rarity) {
    int kind, layer, i;
    for (kind = 0; kind < IMAGE_KINDS; ++kind)
        for (layer = 0; layer < 2; ++layer)
            for (i = 0; i < (kind == IMAGE_DEPTH ? 1 : 3) * COUNT; ++i)
                if (lcg_bits(&random_state) >> 8 < 16777216u / rarity) e->m.texels[kind][layer][i] = injected();
    for (i = 0; i < COUNT; ++i) {
        if (lcg_bits(&random_state) >> 8 < 16777216u / rarity) e->m.roughness[i] = injected();
        if (lcg_bits(&random_state) >> 8 < 16777216u / rarity) e->m.back[i] = injected();
    }
}

static dgb_result show(engine* e, bool cut) {
    dgb_view view = images_view(&e->m, GUARD);
    const dgb_layers layers = images_upload(&e->m);
    view.cut = cut;
    assert_int_equal(dgb_set_layers(&e->c, &view, &layers), DGB_OK);
    return dgb_shade(&e->c, &e->params);
}

/* >> what comes out */

static const struct {
    dgb_slot slot;
    float low, high[4]; /* of a channel */
} results[] = {{DGB_AO, 0.0f, {1.0f, 1.0f, 1.0f, 1.0f}},
               {DGB_BENT, -1.001f, {1.001f, 1.001f, 1.001f, 1.0f}}, /* half floats round */
               {DGB_IRRADIANCE, 0.0f, {DGB_MAX_RADIANCE, DGB_MAX_RADIANCE, DGB_MAX_RADIANCE, 1.0f}},
               {DGB_IRRADIANCE1, 0.0f, {DGB_MAX_RADIANCE, DGB_MAX_RADIANCE, DGB_MAX_RADIANCE, 1.0f}},
               {DGB_REFLECTION, 0.0f, {DGB_MAX_RADIANCE, DGB_MAX_RADIANCE, DGB_MAX_RADIANCE, 1.0f}},
               {DGB_REFLECTION_HIT, -1.001f, {2.0f, DGB_MAX_RADIANCE, 1.001f, 1.001f}}};
enum { RESULTS = (int)(sizeof results / sizeof results[0]) };

static float* read_result(const engine* e, dgb_slot slot) { return fixture_image(&e->c, slot, 0, 4); }

static void check_results(const engine* e, const char* when) {
    int r, i;
    for (r = 0; r < RESULTS; ++r) {
        float* image = read_result(e, results[r].slot);
        for (i = 0; image && i < 4 * COUNT; ++i)
            if (!(image[i] >= results[r].low && image[i] <= results[r].high[i % 4])) /* so NaN is not */
                fail_msg("%s, %s: %s holds %g at %d", e->h->name, when, dgb_slot_name(results[r].slot),
                         (double)image[i], i);
        free(image);
    }
}

static bool is_float_format(dgb_format format) {
    return format >= DGB_FORMAT_R11G11B10F && format <= DGB_FORMAT_RGBA32F;
}

/* The library's own textures that hold floats, all levels. Not the table of rotations, which is written once. */
typedef void (*texture_visitor)(const engine* e, const dgb_texture_desc* d, int level, int width, int height);

static bool is_depth_kept; /* or nothing would be taken for the surface that it was, and no history used */

static void for_every_texture(const engine* e, texture_visitor visit) {
    int t, level;
    for (t = 0; t < e->c.plan.texture_count; ++t) {
        const dgb_texture_desc* d = &e->c.plan.textures[t];
        if (!is_float_format(d->format) || d->layers || d->slot == DGB_ROTATIONS) continue;
        for (level = 0; level < d->levels; ++level) visit(e, d, level, d->width >> level, d->height >> level);
    }
}

static void check_texture(const engine* e, const dgb_texture_desc* d, int level, int width, int height) {
    float* image = fixture_read(dgb_get_texture(&e->c, d->slot), level, 0, width, height, 0, GL_RGBA, 4);
    int i;
    for (i = 0; i < 4 * width * height; ++i)
        if (!is_finite(image[i]))
            fail_msg("%s: level %d of %s holds %g at %d", e->h->name, level, dgb_slot_name(d->slot), (double)image[i],
                     i);
    free(image);
}

static void inject_texture(const engine* e, const dgb_texture_desc* d, int level, int width, int height) {
    float* image = (float*)malloc(4 * sizeof(float) * (size_t)(width * height));
    int i;
    if (is_depth_kept && (d->slot == DGB_Z || d->slot == DGB_LAST_Z)) {
        free(image);
        return;
    }
    for (i = 0; i < 4 * width * height; ++i) image[i] = injected();
    glBindTexture(GL_TEXTURE_2D, dgbgl_texture_name(dgb_get_texture(&e->c, d->slot)));
    glTexSubImage2D(GL_TEXTURE_2D, level, 0, 0, width, height, GL_RGBA, GL_FLOAT, image);
    glBindTexture(GL_TEXTURE_2D, 0);
    free(image);
}

static void check_same(const engine* a, const engine* b) {
    int r;
    for (r = 0; r < RESULTS; ++r) {
        float *x = read_result(a, results[r].slot), *y = read_result(b, results[r].slot);
        if (x && memcmp(x, y, 4 * sizeof(float) * COUNT)) /* NOLINT: to the last bit */
            fail_msg("%s: %s is not what it would have been", a->h->name, dgb_slot_name(results[r].slot));
        free(x), free(y);
    }
}

/* Something occludes, sends and mirrors, or all this would prove nothing. */
static void check_scene(const engine* e) {
    static const struct {
        dgb_slot slot;
        int channel;
    } needed[] = {{DGB_IRRADIANCE, 3}, {DGB_REFLECTION, 3}};
    size_t k;
    int i, count;
    for (k = 0; k < sizeof needed / sizeof needed[0]; ++k) {
        float* image = read_result(e, needed[k].slot);
        for (i = count = 0; i < COUNT; ++i) count += image[4 * i + needed[k].channel] > 0.01f;
        if (count < COUNT / 32) fail_msg("%s: %s has %d texels", e->h->name, dgb_slot_name(needed[k].slot), count);
        free(image);
    }
}

/* >> tests */

/* The two show the same scene in every frame but `bad` ones; a cut frees the one of what it saw. */
static void cut_and_compare(engine* clean, engine* sick, uint32_t seed) {
    put_scene(clean, seed), put_scene(sick, seed);
    assert_int_equal(show(clean, true), DGB_OK);
    assert_int_equal(show(sick, true), DGB_OK);
    check_same(clean, sick);
}

static void test_inputs(void** state) {
    size_t i;
    uint32_t frame;
    (void)state;
    for (i = 0; i < sizeof hows / sizeof hows[0]; ++i) {
        static engine clean, sick;
        open_engine(&clean, &hows[i]), open_engine(&sick, &hows[i]);
        for (frame = 0; frame < 6; ++frame) {
            put_scene(&clean, frame), put_scene(&sick, frame);
            if (frame % 2) inject_inputs(&sick, 1u << 2 * (frame / 2u)); /* all, a quarter, a sixteenth */
            assert_int_equal(show(&clean, false), DGB_OK);
            assert_int_equal(show(&sick, false), DGB_OK);
            check_results(&sick, frame % 2 ? "with injected inputs" : "a frame later");
            for_every_texture(&sick, check_texture);
        }
        cut_and_compare(&clean, &sick, 77u);
        close_engine(&clean), close_engine(&sick);
    }
}

/* Two frames, because history has two textures that take turns. */
static void test_own_textures(void** state) {
    size_t i;
    uint32_t frame;
    (void)state;
    for (i = 0; i < sizeof hows / sizeof hows[0]; ++i) {
        static engine clean, sick;
        open_engine(&clean, &hows[i]), open_engine(&sick, &hows[i]);
        for (frame = 0; frame < 6; ++frame) {
            put_scene(&clean, frame), put_scene(&sick, frame);
            is_depth_kept = frame < 3;
            if (frame % 3 == 1) for_every_texture(&sick, inject_texture);
            assert_int_equal(show(&clean, false), DGB_OK);
            assert_int_equal(show(&sick, false), DGB_OK);
            check_results(&sick, "with injected history");
            if (hows[i].layers > 1) check_scene(&clean);
            if (frame % 3 == 2) for_every_texture(&sick, check_texture);
        }
        for_every_texture(&sick, inject_texture);
        cut_and_compare(&clean, &sick, 78u);
        close_engine(&clean), close_engine(&sick);
    }
}

/* >> last frame's depth, which WARP asks where the camera moves */

enum { ROOM_WIDTH = 64, ROOM_HEIGHT = 48, ROOM = ROOM_WIDTH * ROOM_HEIGHT, ROOM_LAYERS = 3 };

typedef struct room {
    dgb_context c;
    GLuint program;
} room;

static fixture_view room_view(void) {
    fixture_view v = fixture_default_view();
    v.reversed = true;
    v.clip = DGB_CLIP_ZERO_TO_ONE;
    return v;
}

static void open_room(room* r) {
    const fixture_view v = room_view();
    dgb_desc d = fixture_desc(&f, &v, ROOM_WIDTH, ROOM_HEIGHT, 0);
    memset(r, 0, sizeof *r);
    d.layers = ROOM_LAYERS;
    d.depth_format = DGB_FORMAT_D32F;
    d.oracle = DGB_ORACLE_WARP;
    d.effects = DGB_EFFECT_AO;
    assert_int_equal(dgb_init(&r->c, &d), DGB_OK);
    r->program = fixture_program(&r->c);
    assert_true(r->program != 0);
}

static void close_room(room* r) {
    glDeleteProgram(r->program);
    dgb_shutdown(&r->c);
}

/* The camera turns and walks; far_plane 0: infinite. */
static void build_room(room* r, int frame, float far_plane, bool cut) {
    const dgb_params q = dgb_preset(DGB_PRESET_QUALITY);
    fixture_view v = room_view();
    fixture_draw_user user;
    dgb_view view;
    v.far_plane = far_plane;
    v.eye[0] += 0.05f * (float)frame, v.yaw += 0.01f * (float)frame;
    view = fixture_dgb_view(&v, ROOM_WIDTH, ROOM_HEIGHT);
    view.cut = cut;
    memset(&user, 0, sizeof user);
    user.f = &f, user.program = r->program;
    assert_int_equal(dgb_build(&r->c, &view, &q, fixture_draw, &user), DGB_OK);
}

static float* read_depth(const room* r, dgb_slot slot, int layer, int layers) {
    return fixture_read(dgb_get_texture(&r->c, slot), 0, layer, ROOM_WIDTH, ROOM_HEIGHT, layers, GL_DEPTH_COMPONENT, 1);
}

/* A depth texture holds nothing but depths; what WARP is given in its place holds anything. */
static GLuint anything;
static dgb_texture last_depth;
static void (*bind)(void* user, dgb_slot slot, dgb_texture texture, int level);

static void bind_anything(void* user, dgb_slot slot, dgb_texture texture, int level) {
    bind(user, slot, texture, level);
    if (anything && texture.id == last_depth.id) glBindTexture(GL_TEXTURE_2D_ARRAY, anything);
}

static GLuint texture_of_anything(void) {
    static float depths[ROOM_LAYERS * ROOM];
    GLuint name;
    int i;
    for (i = 0; i < ROOM_LAYERS * ROOM; ++i) depths[i] = i % 4 ? injected() : random_unit();
    glGenTextures(1, &name);
    glBindTexture(GL_TEXTURE_2D_ARRAY, name);
    glTexImage3D(GL_TEXTURE_2D_ARRAY, 0, GL_R32F, ROOM_WIDTH, ROOM_HEIGHT, ROOM_LAYERS, 0, GL_RED, GL_FLOAT, depths);
    glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAX_LEVEL, 0);
    glBindTexture(GL_TEXTURE_2D_ARRAY, 0);
    return name;
}

static void check_depth(const room* r, dgb_slot slot, int layers) {
    int layer, i;
    for (layer = 0; layer < layers; ++layer) {
        float* depth = read_depth(r, slot, layer, layers);
        for (i = 0; i < ROOM; ++i)
            if (!(depth[i] >= 0.0f && depth[i] <= 1.0f))
                fail_msg("layer %d of %s holds %g at %d", layer, dgb_slot_name(slot), (double)depth[i], i);
        free(depth);
    }
}

static int count_different(const room* a, const room* b, int layer) {
    float *x = read_depth(a, DGB_DEPTH, layer, ROOM_LAYERS), *y = read_depth(b, DGB_DEPTH, layer, ROOM_LAYERS);
    int i, count = 0;
    for (i = 0; i < ROOM; ++i) count += x[i] != y[i];
    free(x), free(y);
    return count;
}

/* Layers hold depth, whatever WARP made of what it was given. The first asks nobody, and a cut peels. */
static void test_warp(void** state) {
    static const float far_planes[] = {0.0f, 60.0f};
    int i, frame, layer;
    (void)state;
    for (i = 0; i < 2; ++i) {
        room clean, sick;
        open_room(&clean), open_room(&sick);
        random_state = (uint32_t)i;
        bind = sick.c.backend.texture_bind;
        sick.c.backend.texture_bind = bind_anything;
        last_depth = dgb_get_texture(&sick.c, DGB_DEPTH);
        for (frame = 0; frame < 8; ++frame) {
            const bool peels = frame == 0 || frame == 7;
            build_room(&clean, frame, far_planes[i], peels);
            anything = peels ? 0 : texture_of_anything();
            build_room(&sick, frame, far_planes[i], peels);
            glDeleteTextures(1, &anything);
            if (!peels) check_depth(&sick, DGB_ORACLE, ROOM_LAYERS - 1);
            check_depth(&sick, DGB_DEPTH, ROOM_LAYERS);
            for (layer = 0; layer < ROOM_LAYERS; ++layer) {
                const int different = count_different(&clean, &sick, layer);
                if (layer == 0 || peels) assert_int_equal(different, 0);
                if (layer == 1 && !peels) assert_true(different > ROOM / 8); /* it was asked */
            }
        }
        close_room(&clean), close_room(&sick);
    }
}

/* >> parameters */

/* Lengths and factors anywhere in what is accepted, several at a time. */
static void inject_params(dgb_params* q) {
    static const float values[] = {0.0f, 1e-45f, 1e-30f, 1e-15f, 1e-6f, 0.999f, 1.0f, 25.0f, 1e6f, 1e14f, 1e30f, 3e38f};
    float* fields[] = {
        &q->separation,       &q->ao_radius,         &q->ao_bias,           &q->ao_epsilon,        &q->ao_intensity,
        &q->radius,           &q->thickness,         &q->bounce_damping,    &q->boost_unsaturated, &q->boost_saturated,
        &q->history_weight,   &q->history_tolerance, &q->history_floor,     &q->history_clamp,     &q->sample_clamp,
        &q->normal_sharpness, &q->plane_sharpness,   &q->reflect_thickness, &q->reflect_distance,  &q->reflect_border,
        &q->glossy_radius};
    const size_t count = sizeof fields / sizeof fields[0];
    int n;
    for (n = 0; n < 2; ++n)
        *fields[(lcg_bits(&random_state) >> 8) % count] =
            values[(lcg_bits(&random_state) >> 8) % (sizeof values / sizeof values[0])];
}

static void test_params(void** state) {
    size_t i;
    uint32_t frame;
    int accepted = 0;
    (void)state;
    for (i = 0; i < sizeof hows / sizeof hows[0]; ++i) {
        static engine e;
        open_engine(&e, &hows[i]);
        for (frame = 0; frame < 40; ++frame) {
            dgb_result result;
            put_scene(&e, frame);
            random_state = frame * 7919u + 1u;
            e.params = ordinary_params();
            inject_params(&e.params);
            result = show(&e, false);
            assert_true(result == DGB_OK || result == DGB_INVALID);
            if (result != DGB_OK) continue;
            ++accepted;
            check_results(&e, "with injected parameters");
        }
        close_engine(&e);
    }
    printf("# parameters: %d frames accepted\n", accepted);
    assert_true(accepted >= 80); /* of 200 */
}

FIXTURE_CONTEXT(f, 4, 5, false)

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_inputs), cmocka_unit_test(test_own_textures), cmocka_unit_test(test_warp),
        cmocka_unit_test(test_params), cmocka_unit_test(test_no_messages),
    };
    return cmocka_run_group_tests_name("injection", tests, open_context, close_context);
}
