/* Frames through the record backend: which passes run, in what order, with what bound; life and death of all
   objects. */

#include "record_backend.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <string.h>

#define BOTH (DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY)

static const char* const effect_names[] = {"none", "ao", "radiosity", "ao+radiosity"};

/* To the last bit: what == says of floats and padding is not the question. */
static bool same_bits(const void* a, const void* b, size_t size) { return memcmp(a, b, size) == 0; }

static float from_bits(uint32_t u) {
    float x;
    memcpy(&x, &u, sizeof x);
    return x;
}

/* >> fixture: a backend, a context, what was logged and what the draw callback was told */

enum { MAX_DRAWS = 16 };

typedef struct fixture {
    record_backend r;
    dgb_desc desc;
    dgb_context context;
    dgb_view view;
    dgb_params params;
    int log_count;
    dgb_result log_result;
    dgb_log_item log_item;
    int draw_count;
    dgb_draw draws[MAX_DRAWS];
} fixture;

static void on_log(void* user, dgb_result result, dgb_log_item item, const char* sentence) {
    fixture* f = (fixture*)user;
    f->log_result = result;
    f->log_item = item;
    ++f->log_count;
    if (!sentence || !sentence[0]) fail_msg("%s has no sentence", dgb_log_item_name(item));
}

static void on_draw(void* user, const dgb_draw* draw) {
    fixture* f = (fixture*)user;
    if (!f->r.in_pass) fail_msg("draw callback of layer %d outside of a pass", draw->first_layer);
    if (f->draw_count == MAX_DRAWS) fail_msg("more than %d draws", MAX_DRAWS);
    f->draws[f->draw_count++] = *draw;
    record_printf(&f->r.trace, " draw scene: layers %d+%d, instances %d, oracle %s, emission %s\n", draw->first_layer,
                  draw->layer_count, draw->instances, dgb_oracle_name(draw->oracle), dgb_emission_name(draw->emission));
}

/* A standard perspective projection, 90 degrees, 0.1 m to 100 m, at the origin. */
static void default_view(dgb_view* view) {
    memset(view, 0, sizeof *view);
    view->view[0] = view->view[5] = view->view[10] = view->view[15] = 1.0f;
    view->projection[0] = 0.75f;
    view->projection[5] = 1.0f;
    view->projection[10] = -100.1f / 99.9f;
    view->projection[11] = -1.0f;
    view->projection[14] = -20.0f / 99.9f;
}

static void start(fixture* f) {
    memset(f, 0, sizeof *f);
    record_start(&f->r);
    f->desc.width = 64;
    f->desc.height = 48;
    f->desc.guard_band = 8;
    f->desc.layers = 2;
    f->desc.backend = &f->r.backend;
    f->desc.log = on_log;
    f->desc.log_user = f;
    f->params = dgb_preset(DGB_PRESET_BALANCED);
    default_view(&f->view);
}

static void init(fixture* f) {
    if (dgb_init(&f->context, &f->desc) != DGB_OK) fail_msg("dgb_init: %s", dgb_log_item_name(f->log_item));
}

/* Whatever happened, nothing may be left. */
static void stop(fixture* f) {
    dgb_shutdown(&f->context);
    if (record_alive(&f->r)) fail_msg("%d objects are left", record_alive(&f->r));
    assert_int_equal(f->r.begins, f->r.ends);
    record_stop(&f->r);
}

static void build(fixture* f) {
    if (dgb_build(&f->context, &f->view, &f->params, on_draw, f) != DGB_OK)
        fail_msg("dgb_build: %s", dgb_log_item_name(f->log_item));
}

static void shade(fixture* f) {
    if (dgb_shade(&f->context, &f->params) != DGB_OK) fail_msg("dgb_shade: %s", dgb_log_item_name(f->log_item));
}

static dgb_layers engine_layers(fixture* f) {
    const int width = f->desc.width + 2 * f->desc.guard_band, height = f->desc.height + 2 * f->desc.guard_band;
    dgb_layers layers;
    int i;
    memset(&layers, 0, sizeof layers);
    for (i = 0; i < 2; ++i) {
        layers.depth[i] = record_engine_texture(&f->r, i ? DGB_ENGINE_DEPTH1 : DGB_ENGINE_DEPTH0, width, height);
        layers.normal[i] = record_engine_texture(&f->r, i ? DGB_ENGINE_NORMAL1 : DGB_ENGINE_NORMAL0, width, height);
        layers.radiance[i] =
            record_engine_texture(&f->r, i ? DGB_ENGINE_RADIANCE1 : DGB_ENGINE_RADIANCE0, width, height);
    }
    return layers;
}

static void set_layers(fixture* f, const dgb_layers* layers) {
    if (dgb_set_layers(&f->context, &f->view, layers) != DGB_OK)
        fail_msg("dgb_set_layers: %s", dgb_log_item_name(f->log_item));
}

/* Takes the trace so far and begins a new one. */
static void take_trace(fixture* f, record_text* text) {
    record_printf(text, "%s", f->r.trace.data);
    record_clear(&f->r);
    f->draw_count = 0;
}

/* >> golden traces */

typedef struct construction {
    dgb_oracle oracle;
    dgb_emission emission;
} construction;

static const construction constructions[] = {
    {DGB_ORACLE_PEEL, DGB_EMISSION_SEPARATE},      {DGB_ORACLE_PREVIOUS, DGB_EMISSION_SEPARATE},
    {DGB_ORACLE_PREVIOUS, DGB_EMISSION_GEOMETRY},  {DGB_ORACLE_PREVIOUS, DGB_EMISSION_VERTEX},
    {DGB_ORACLE_REPROJECT, DGB_EMISSION_SEPARATE}, {DGB_ORACLE_REPROJECT, DGB_EMISSION_GEOMETRY},
    {DGB_ORACLE_REPROJECT, DGB_EMISSION_VERTEX}};
enum { CONSTRUCTION_COUNT = 7 };

static void configure(fixture* f, construction c, int layers, uint32_t effects) {
    start(f);
    f->desc.oracle = c.oracle;
    f->desc.emission = c.emission;
    f->desc.layers = layers;
    f->desc.effects = effects;
}

/* Builds of the first and second frame; with `shading`, what dgb_shade did in both goes there. */
static void trace_two_frames(construction c, int layers, uint32_t effects, record_text* text, record_text* shading) {
    fixture f;
    int frame;
    configure(&f, c, layers, effects);
    init(&f);
    record_clear(&f.r);
    for (frame = 0; frame < 2; ++frame) {
        record_printf(text, "-- frame %d\n", frame);
        build(&f);
        take_trace(&f, text);
        shade(&f);
        if (shading)
            record_text_clear(shading), take_trace(&f, shading);
        else
            record_clear(&f.r);
    }
    stop(&f);
}

static void print_builds(record_text* text, construction c, int layers) {
    record_printf(text, "== build, layers %d, oracle %s, emission %s\n", layers, dgb_oracle_name(c.oracle),
                  dgb_emission_name(c.emission));
    trace_two_frames(c, layers, 0, text, NULL);
    record_printf(text, "\n");
}

static void print_shading(record_text* text, int layers, uint32_t effects) {
    record_text build_text = {0}, shading = {0};
    trace_two_frames(constructions[6], layers, effects, &build_text, &shading);
    record_printf(text, "== shade, layers %d, effects %s\n%s\n", layers, effect_names[effects], shading.data);
    record_text_free(&build_text);
    record_text_free(&shading);
}

static void print_life(record_text* text, int layers, uint32_t effects, dgb_source source) {
    fixture f;
    start(&f);
    f.desc.layers = layers;
    f.desc.effects = effects;
    f.desc.source = source;
    record_printf(text, "== init, resize to 32x32 and shutdown, layers %d, effects %s%s\n", layers,
                  effect_names[effects], source == DGB_SOURCE_ENGINE ? ", the engine's own" : "");
    init(&f);
    take_trace(&f, text);
    record_printf(text, "-- resize\n");
    assert_int_equal(dgb_resize(&f.context, 32, 32), DGB_OK);
    take_trace(&f, text);
    record_printf(text, "-- shutdown\n");
    dgb_shutdown(&f.context);
    take_trace(&f, text);
    record_printf(text, "\n");
    stop(&f);
}

static void print_engine(record_text* text, int layers, dgb_normals normals) {
    dgb_layers own;
    fixture f;
    start(&f);
    f.desc.source = DGB_SOURCE_ENGINE;
    f.desc.layers = layers;
    f.desc.normals = normals;
    f.desc.effects = BOTH;
    init(&f);
    own = engine_layers(&f);
    record_clear(&f.r);
    set_layers(&f, &own);
    shade(&f);
    record_printf(text, "== engine's own, layers %d, normals %d\n", layers, (int)normals);
    take_trace(&f, text);
    record_printf(text, "\n");
    dgb_shutdown(&f.context);
    stop(&f);
}

static void test_golden_traces(void** state) {
    record_text text = {0};
    uint32_t effects;
    int i;
    (void)state;
    for (i = 0; i < CONSTRUCTION_COUNT; ++i) print_builds(&text, constructions[i], 2);
    print_builds(&text, constructions[0], 1);
    print_builds(&text, constructions[0], 3);
    for (i = 4; i < CONSTRUCTION_COUNT; ++i) print_builds(&text, constructions[i], 3);
    for (effects = 0; effects < 4; ++effects) {
        print_shading(&text, 1, effects);
        print_shading(&text, 2, effects);
    }
    print_shading(&text, 3, BOTH);
    print_engine(&text, 1, DGB_NORMALS_FROM_DEPTH);
    print_engine(&text, 2, DGB_NORMALS_FLOAT);
    print_life(&text, 2, BOTH, DGB_SOURCE_BUILD);
    print_life(&text, 1, DGB_EFFECT_AO, DGB_SOURCE_ENGINE);
    record_check_golden("trace.golden", &text);
    record_text_free(&text);
}

/* So the golden file need not hold every combination: builds know nothing of effects, shading nothing of
   builds. */
static void test_building_and_shading_are_apart(void** state) {
    uint32_t effects;
    int i, layers;
    (void)state;
    for (effects = 0; effects < 4; ++effects)
        for (layers = 1; layers <= 4; ++layers) {
            record_text first_shading = {0};
            for (i = 0; i < CONSTRUCTION_COUNT; ++i) {
                record_text plain = {0}, built = {0}, shading = {0};
                trace_two_frames(constructions[i], layers, 0, &plain, NULL);
                trace_two_frames(constructions[i], layers, effects, &built, &shading);
                if (strcmp(plain.data, built.data) != 0)
                    fail_msg("effects %s change construction %d", effect_names[effects], i);
                if (!i) record_printf(&first_shading, "%s", shading.data);
                if (strcmp(first_shading.data, shading.data) != 0)
                    fail_msg("construction %d changes effects %s", i, effect_names[effects]);
                record_text_free(&plain);
                record_text_free(&built);
                record_text_free(&shading);
            }
            record_text_free(&first_shading);
        }
}

/* >> what the draw callback is told */

static void check_draw(const fixture* f, int i, int first, int count, int instances, dgb_oracle oracle) {
    const dgb_draw* d = &f->draws[i];
    if (i >= f->draw_count) fail_msg("only %d draws", f->draw_count);
    if (d->first_layer != first || d->layer_count != count || d->instances != instances || d->oracle != oracle ||
        d->width != 80 || d->height != 64)
        fail_msg("draw %d: layers %d+%d, instances %d, oracle %s, %dx%d", i, d->first_layer, d->layer_count,
                 d->instances, dgb_oracle_name(d->oracle), d->width, d->height);
}

static void check_frames(construction c, int layers) {
    const bool single = c.emission != DGB_EMISSION_SEPARATE;
    fixture f;
    int frame, i;
    configure(&f, c, layers, 0);
    init(&f);
    for (frame = 0; frame < 3; ++frame) {
        const bool once = single && frame > 0;
        f.draw_count = 0;
        build(&f);
        assert_int_equal(f.draw_count, once ? 1 : layers);
        for (i = 0; i < f.draw_count; ++i)
            check_draw(&f, i, i, once ? layers : 1, once && c.emission == DGB_EMISSION_VERTEX ? layers : 1,
                       frame ? c.oracle : DGB_ORACLE_PEEL);
    }
    stop(&f);
}

static void test_draw_is_told_the_layers(void** state) {
    int i, layers;
    (void)state;
    for (i = 0; i < CONSTRUCTION_COUNT; ++i)
        for (layers = 2; layers <= 4; ++layers) check_frames(constructions[i], layers);
}

static void test_draw_is_told_the_matrices(void** state) {
    static const float no_jitter[2] = {0.0f, 0.0f};
    float first[16], second[16], first_view[16];
    fixture f;
    (void)state;
    start(&f);
    init(&f);
    dgb_widen_projection(f.view.projection, 64, 48, 8, no_jitter, first);
    memcpy(first_view, f.view.view, sizeof first_view);
    build(&f);
    assert_memory_equal(f.draws[0].projection, first, sizeof first);
    assert_memory_equal(f.draws[0].previous_projection, first, sizeof first); /* nothing before: the same */
    assert_memory_equal(f.draws[0].previous_view, first_view, sizeof first_view);
    f.view.view[12] = 3.0f;
    f.view.jitter[0] = 0.25f;
    f.draw_count = 0;
    build(&f);
    dgb_widen_projection(f.view.projection, 64, 48, 8, f.view.jitter, second);
    assert_memory_equal(f.draws[0].view, f.view.view, sizeof first_view);
    assert_memory_equal(f.draws[0].projection, second, sizeof second);
    assert_memory_equal(f.draws[0].previous_projection, first, sizeof first);
    assert_memory_equal(f.draws[0].previous_view, first_view, sizeof first_view);
    stop(&f);
}

static dgb_oracle oracle_of_next_build(fixture* f) {
    f->draw_count = 0;
    build(f);
    return f->draws[0].oracle;
}

static void test_cut_and_resize_peel_again(void** state) {
    float widened[16];
    fixture f;
    (void)state;
    start(&f);
    init(&f);
    assert_int_equal(oracle_of_next_build(&f), DGB_ORACLE_PEEL);
    assert_int_equal(oracle_of_next_build(&f), DGB_ORACLE_REPROJECT);
    f.view.cut = true;
    assert_int_equal(oracle_of_next_build(&f), DGB_ORACLE_PEEL);
    assert_memory_equal(f.draws[0].previous_view, f.view.view, sizeof f.view.view);
    f.view.cut = false;
    assert_int_equal(oracle_of_next_build(&f), DGB_ORACLE_REPROJECT);
    assert_int_equal(dgb_resize(&f.context, 32, 32), DGB_OK);
    assert_int_equal(oracle_of_next_build(&f), DGB_ORACLE_PEEL);
    assert_int_equal(f.draws[0].width, 48);
    assert_int_equal(f.draws[0].height, 48);
    dgb_widen_projection(f.view.projection, 32, 32, 8, f.view.jitter, widened);
    assert_memory_equal(f.draws[0].projection, widened, sizeof widened);
    assert_int_equal(oracle_of_next_build(&f), DGB_ORACLE_REPROJECT);
    stop(&f);
}

static void test_depth_and_oracle_change_places(void** state) {
    dgb_texture depth, oracle;
    fixture f;
    (void)state;
    start(&f);
    init(&f);
    depth = dgb_get_texture(&f.context, DGB_DEPTH);
    oracle = dgb_get_texture(&f.context, DGB_ORACLE);
    assert_true(depth.id && oracle.id && depth.id != oracle.id);
    build(&f);
    assert_true(dgb_get_texture(&f.context, DGB_DEPTH).id == oracle.id);
    assert_true(dgb_get_texture(&f.context, DGB_ORACLE).id == depth.id);
    build(&f);
    assert_true(dgb_get_texture(&f.context, DGB_DEPTH).id == depth.id);
    assert_true(dgb_get_texture(&f.context, DGB_ORACLE).id == oracle.id);
    stop(&f);
    configure(&f, constructions[0], 2, 0); /* peeling has no second one */
    init(&f);
    depth = dgb_get_texture(&f.context, DGB_DEPTH);
    build(&f);
    assert_true(dgb_get_texture(&f.context, DGB_DEPTH).id == depth.id);
    assert_true(dgb_get_texture(&f.context, DGB_ORACLE).id == 0);
    stop(&f);
}

/* >> uniforms */

static void test_layer_uniforms(void** state) {
    const dgb_draw_uniforms* u;
    dgb_camera camera, first;
    fixture f;
    (void)state;
    start(&f);
    f.desc.depth_format = DGB_FORMAT_D24;
    init(&f);
    build(&f);
    first = f.context.camera;
    record_clear(&f.r);
    f.view.jitter[1] = -0.5f;
    f.params.separation = 0.75f;
    f.draw_count = 0;
    build(&f);
    u = &record_uniforms_of(&f.r, DGB_PASS_LAYERS, 0)->u.draw;
    assert_int_equal(dgb_camera_from_matrix(f.draws[0].projection, 80, 64, f.desc.clip, false, &camera), DGB_OK);
    assert_memory_equal(&u->camera, &camera, sizeof camera);
    assert_memory_equal(&u->previous, &first, sizeof first);
    assert_true(u->size[0] == 80.0f && u->size[1] == 64.0f && u->size[2] == 0.75f && u->size[3] == 16777215.0f);
    assert_int_equal(u->layer[0], 0);
    assert_int_equal(u->layer[1], 2);
    assert_int_equal(u->layer[2], DGB_ORACLE_REPROJECT);
    assert_int_equal(u->layer[3], 2);
    stop(&f);
}

/* distance = d0 clip.z + d1 clip.w + d2, for a point 7 m away */
static void check_distance(bool orthographic) {
    const dgb_draw_uniforms* u;
    const float z = -7.0f;
    float clip_z, clip_w, distance;
    fixture f;
    start(&f);
    if (orthographic) {
        f.view.projection[10] = -0.02f;
        f.view.projection[11] = 0.0f;
        f.view.projection[14] = -1.0f;
        f.view.projection[15] = 1.0f;
    }
    init(&f);
    build(&f);
    u = &record_uniforms_of(&f.r, DGB_PASS_LAYERS, 0)->u.draw;
    clip_z = f.view.projection[10] * z + f.view.projection[14];
    clip_w = f.view.projection[11] * z + f.view.projection[15];
    distance = u->distance[0] * clip_z + u->distance[1] * clip_w + u->distance[2];
    if (fabsf(distance - 7.0f) > 1e-5f) fail_msg("7 m became %g", (double)distance);
    distance = u->previous_distance[0] * clip_z + u->previous_distance[1] * clip_w + u->previous_distance[2];
    if (fabsf(distance - 7.0f) > 1e-5f) fail_msg("7 m before became %g", (double)distance);
    stop(&f);
}

static void test_distance_uniforms(void** state) {
    (void)state;
    check_distance(false);
    check_distance(true);
}

static void test_pack_uniforms(void** state) {
    const dgb_pack_uniforms* u;
    fixture f;
    int strict, world;
    (void)state;
    for (strict = 0; strict < 2; ++strict)
        for (world = 0; world < 2; ++world) {
            start(&f);
            f.desc.effects = DGB_EFFECT_AO;
            f.desc.world_normals = world;
            f.params.strict_separation = strict;
            f.params.separation = 0.25f;
            f.view.view[1] = 0.5f; /* column 0, row 1 */
            init(&f);
            build(&f);
            shade(&f);
            u = &record_uniforms_of(&f.r, DGB_PASS_PACK, 0)->u.pack;
            assert_true(u->separation[0] == (strict ? 0.25f : -1.0f));
            assert_true(u->rotation[0][0] == 1.0f && u->rotation[1][1] == 1.0f && u->rotation[2][2] == 1.0f);
            assert_true(u->rotation[0][1] == (world ? 0.5f : 0.0f));
            assert_int_equal(u->size[0], 80);
            assert_int_equal(u->size[1], 64);
            stop(&f);
        }
}

static void test_ao_uniforms(void** state) {
    const dgb_ao_uniforms* u;
    float tap[3];
    fixture f;
    (void)state;
    start(&f);
    f.desc.effects = DGB_EFFECT_AO;
    f.params.ao_radius = 2.0f;
    f.params.ao_samples = 37;
    f.params.ao_min_level = 1;
    f.params.ao_intensity = 1.5f;
    init(&f);
    build(&f);
    shade(&f);
    u = &record_uniforms_of(&f.r, DGB_PASS_AO, 0)->u.ao;
    assert_memory_equal(&u->camera, &f.context.camera, sizeof u->camera);
    assert_true(u->size[0] == 80 && u->size[1] == 64 && u->size[2] == 37);
    assert_true(u->level[0] == DGB_AO_LOG2_Q && u->level[1] == 1 && u->level[2] == 5);
    assert_true(u->radius[0] == 2.0f && u->radius[1] == 0.25f);
    assert_true(fabsf(u->radius[2] - 0.04f) < 1e-7f && fabsf(u->radius[3] - 0.004f) < 1e-8f);
    assert_true(fabsf(u->scale[0] - 3.14159265f / 37.0f) < 1e-7f && u->scale[1] == 1.5f);
    assert_true(fabsf(u->scale[2] - sqrtf(80.0f * 80.0f + 64.0f * 64.0f)) < 1e-4f);
    dgb_spiral_tap(36, 37, tap);
    assert_memory_equal(u->taps[36], tap, sizeof tap);
    assert_true(u->taps[37][0] == 0.0f && u->taps[37][2] == 0.0f);
    stop(&f);
}

static void test_gather_uniforms(void** state) {
    const dgb_gather_uniforms* u;
    float tap[3];
    fixture f;
    int literal;
    (void)state;
    for (literal = 0; literal < 2; ++literal) {
        start(&f);
        f.desc.effects = DGB_EFFECT_RADIOSITY;
        f.desc.normaliser = literal ? DGB_NORMALISER_PAPER : DGB_NORMALISER_BOUNDED;
        f.desc.height = 1; /* with its guard band 17 pixels, 5 levels */
        f.params.radius = 3.0f;
        f.params.samples = 256;
        f.params.min_level = 5;
        init(&f);
        build(&f);
        shade(&f);
        u = &record_uniforms_of(&f.r, DGB_PASS_GATHER, 0)->u.gather;
        assert_true(u->size[0] == 80 && u->size[1] == 17 && u->size[2] == 256);
        assert_true(u->level[0] == DGB_GATHER_LOG2_Q && u->level[1] == 4 && u->level[2] == 4);
        assert_true(u->radius[0] == 3.0f && u->radius[1] == 9.0f && u->radius[2] == (literal ? 0.0f : 1.0f));
        assert_true(fabsf(u->radius[3] - sqrtf(80.0f * 80.0f + 17.0f * 17.0f)) < 1e-4f);
        dgb_spiral_tap(255, 256, tap);
        assert_memory_equal(u->taps[255], tap, sizeof tap);
        stop(&f);
    }
}

static void test_reconstruction_uniforms(void** state) {
    fixture f;
    int axis, i;
    (void)state;
    start(&f);
    f.desc.effects = BOTH;
    f.params.filter_taps = 25;
    f.params.filter_step = 3;
    init(&f);
    build(&f);
    shade(&f);
    for (axis = 0; axis < 2; ++axis) {
        const dgb_reconstruct_uniforms* u = &record_uniforms_of(&f.r, DGB_PASS_RECONSTRUCT, axis)->u.reconstruct;
        assert_true(u->axis[axis] == 3 && u->axis[1 - axis] == 0 && u->axis[2] == 12);
        assert_true(u->sharpness[0] == f.params.normal_sharpness && u->sharpness[1] == f.params.plane_sharpness);
        assert_true(u->weights[0][0] == 1.0f);
        for (i = 1; i <= 12; ++i) assert_true(u->weights[i][0] > 0.0f && u->weights[i][0] < u->weights[i - 1][0]);
        assert_true(fabsf(u->weights[12][0] - expf(-2.0f)) < 1e-6f); /* two standard deviations out */
    }
    stop(&f);
}

static void check_shaded_rect(int guard, float fraction, int inset) {
    const dgb_reconstruct_uniforms* u;
    fixture f;
    start(&f);
    f.desc.effects = DGB_EFFECT_AO;
    f.desc.guard_band = guard;
    f.params.guard_fraction = fraction;
    init(&f);
    build(&f);
    shade(&f);
    u = &record_uniforms_of(&f.r, DGB_PASS_RECONSTRUCT, 0)->u.reconstruct;
    if (u->rect[0] != inset || u->rect[1] != inset || u->rect[2] != 64 + 2 * guard - inset - 1 ||
        u->rect[3] != 48 + 2 * guard - inset - 1)
        fail_msg("guard %d, fraction %g: %d %d %d %d", guard, (double)fraction, u->rect[0], u->rect[1], u->rect[2],
                 u->rect[3]);
    /* the last pass to begin was the second axis of the same rectangle */
    if (f.r.pass.x != inset || f.r.pass.y != inset || f.r.pass.width != 64 + 2 * (guard - inset) ||
        f.r.pass.height != 48 + 2 * (guard - inset))
        fail_msg("guard %d, fraction %g: viewport %d %d %d %d", guard, (double)fraction, f.r.pass.x, f.r.pass.y,
                 f.r.pass.width, f.r.pass.height);
    stop(&f);
}

static void test_shaded_rectangle(void** state) {
    (void)state;
    check_shaded_rect(64, 0.0f, 64);
    check_shaded_rect(64, 0.1f, 58);
    check_shaded_rect(64, 0.5f, 32);
    check_shaded_rect(64, 0.8f, 13);
    check_shaded_rect(64, 1.0f, 0);
    check_shaded_rect(0, 0.5f, 0);
    check_shaded_rect(1, 0.49f, 1);
    check_shaded_rect(1, 0.5f, 0);
}

static void test_normal_test_picks_the_program(void** state) {
    fixture f;
    (void)state;
    start(&f);
    f.desc.effects = DGB_EFFECT_RADIOSITY;
    init(&f);
    build(&f);
    record_clear(&f.r);
    f.params.normal_test = true;
    shade(&f);
    assert_non_null(strstr(f.r.trace.data, "draw gather{DGB_LAYERS=2,DGB_NORMAL_TEST=1,"));
    record_clear(&f.r);
    f.params.normal_test = false;
    shade(&f);
    assert_non_null(strstr(f.r.trace.data, "draw gather{DGB_LAYERS=2,DGB_NORMAL_TEST=0,"));
    stop(&f);
}

static void test_clip_and_direction_reach_the_backend(void** state) {
    fixture f;
    (void)state;
    start(&f);
    f.desc.clip = DGB_CLIP_ZERO_TO_ONE;
    f.desc.reversed = true;
    f.view.projection[10] = 0.0f; /* infinite */
    f.view.projection[14] = 0.1f;
    init(&f);
    build(&f);
    assert_true(f.r.pass.reversed && f.r.pass.clip == DGB_CLIP_ZERO_TO_ONE);
    assert_true(f.r.pass.clear && f.r.pass.clear_depth == 0.0f);
    stop(&f);
}

static void test_rotations_are_uploaded(void** state) {
    fixture f;
    int i, found = 0;
    (void)state;
    start(&f);
    f.desc.effects = DGB_EFFECT_AO;
    init(&f);
    for (i = 0; i < f.r.object_count; ++i)
        if (!f.r.objects[i].is_program && f.r.objects[i].texture.slot == DGB_ROTATIONS) {
            ++found;
            assert_true(f.r.objects[i].first_pixels[0] == 1.0f && f.r.objects[i].first_pixels[1] == 0.0f);
        }
    assert_int_equal(found, 1);
    stop(&f);
}

/* >> failures */

static void check_nothing_changed(fixture* f, const dgb_context* before) {
    if (!same_bits(&f->context, before, sizeof *before)) fail_msg("the context changed at create %d", f->r.fail_at);
}

/* How a failing create shows: the backend's own error, or DGB_DEVICE when it claims success and gives
   nothing. */
static const dgb_result failures[] = {DGB_OUT_OF_MEMORY, DGB_DEVICE, DGB_UNSUPPORTED, DGB_OK};

static void check_failed_init(dgb_source source, dgb_result failure, int creates) {
    int n;
    for (n = 1; n <= creates; ++n) {
        dgb_context before;
        fixture f;
        dgb_result result;
        start(&f);
        f.desc.effects = BOTH;
        f.desc.source = source;
        memset(&f.context, 0, sizeof f.context);
        memcpy(&before, &f.context, sizeof before);
        f.r.fail_at = n;
        f.r.fail_with = failure;
        result = dgb_init(&f.context, &f.desc);
        if (result != (failure == DGB_OK ? DGB_DEVICE : failure)) fail_msg("create %d: %s", n, dgb_result_name(result));
        if (record_alive(&f.r)) fail_msg("create %d fails and leaves %d objects", n, record_alive(&f.r));
        check_nothing_changed(&f, &before);
        assert_int_equal(f.r.creates, n); /* it gives up at once */
        assert_int_equal(f.log_count, 1);
        assert_int_equal(f.log_result, result);
        assert_true(f.log_item == DGB_LOG_TEXTURE || f.log_item == DGB_LOG_PROGRAM);
        f.r.fail_at = 0;
        init(&f); /* and the next try may succeed */
        stop(&f);
    }
}

static int creates_of_init(dgb_source source) {
    fixture f;
    int creates;
    start(&f);
    f.desc.effects = BOTH;
    f.desc.source = source;
    init(&f);
    creates = f.r.creates;
    assert_int_equal(creates, f.context.plan.texture_count + f.context.plan.program_count);
    assert_int_equal(creates, record_alive(&f.r));
    stop(&f);
    return creates;
}

static void test_failed_init_leaves_nothing(void** state) {
    size_t i;
    (void)state;
    for (i = 0; i < sizeof failures / sizeof failures[0]; ++i) {
        check_failed_init(DGB_SOURCE_BUILD, failures[i], creates_of_init(DGB_SOURCE_BUILD));
        check_failed_init(DGB_SOURCE_ENGINE, failures[i], creates_of_init(DGB_SOURCE_ENGINE));
    }
}

static void check_failed_resize(dgb_result failure, int n) {
    dgb_context before;
    fixture f;
    dgb_result result;
    int alive;
    start(&f);
    f.desc.effects = BOTH;
    init(&f);
    build(&f);
    alive = record_alive(&f.r);
    memcpy(&before, &f.context, sizeof before);
    f.r.creates = 0;
    f.r.fail_at = n;
    f.r.fail_with = failure;
    result = dgb_resize(&f.context, 100, 90);
    if (result != (failure == DGB_OK ? DGB_DEVICE : failure)) fail_msg("create %d: %s", n, dgb_result_name(result));
    if (record_alive(&f.r) != alive) fail_msg("create %d: %d objects, not %d", n, record_alive(&f.r), alive);
    check_nothing_changed(&f, &before);
    assert_int_equal(f.log_item, DGB_LOG_TEXTURE);
    f.r.fail_at = 0;
    shade(&f); /* the old frame is still good */
    assert_int_equal(oracle_of_next_build(&f), DGB_ORACLE_REPROJECT);
    stop(&f);
}

static void test_failed_resize_keeps_the_old(void** state) {
    dgb_plan plan;
    fixture f;
    size_t i;
    int n;
    (void)state;
    start(&f);
    f.desc.effects = BOTH;
    assert_int_equal(dgb_make_plan(&f.desc, &plan), DGB_OK);
    stop(&f);
    for (i = 0; i < sizeof failures / sizeof failures[0]; ++i)
        for (n = 1; n <= plan.texture_count; ++n) check_failed_resize(failures[i], n);
}

static void test_refused_resize_keeps_the_old(void** state) {
    static const int sizes[][2] = {{0, 48}, {64, -1}, {16385, 48}, {16384, 48}};
    dgb_context before;
    fixture f;
    size_t i;
    (void)state;
    start(&f);
    init(&f);
    build(&f);
    memcpy(&before, &f.context, sizeof before);
    for (i = 0; i < 4; ++i) {
        assert_int_equal(dgb_resize(&f.context, sizes[i][0], sizes[i][1]), DGB_INVALID);
        check_nothing_changed(&f, &before);
        assert_int_equal(f.log_item, i < 3 ? DGB_LOG_SIZE : DGB_LOG_GUARD_BAND);
    }
    assert_int_equal(f.log_count, 4);
    stop(&f);
}

static void test_resize_knows_the_device(void** state) {
    fixture f;
    (void)state;
    start(&f);
    f.r.backend.caps.max_size = 128;
    init(&f);
    assert_int_equal(dgb_resize(&f.context, 113, 48), DGB_INVALID);
    assert_int_equal(f.log_item, DGB_LOG_GUARD_BAND);
    assert_int_equal(dgb_resize(&f.context, 112, 112), DGB_OK);
    assert_int_equal(dgb_resize(&f.context, 64, 48), DGB_OK); /* and back again */
    assert_int_equal(f.context.plan.width, 80);
    stop(&f);
}

static void test_resize_to_the_same_does_nothing(void** state) {
    dgb_context before;
    fixture f;
    (void)state;
    start(&f);
    init(&f);
    build(&f);
    memcpy(&before, &f.context, sizeof before);
    record_clear(&f.r);
    assert_int_equal(dgb_resize(&f.context, 64, 48), DGB_OK);
    check_nothing_changed(&f, &before);
    assert_string_equal(f.r.trace.data, "");
    stop(&f);
}

/* Every desc that dgb_init takes can be resized: what was resolved at init must not be refused later. */
static void test_whatever_was_initialised_resizes(void** state) {
    int layers, oracle, emission, source;
    (void)state;
    for (source = 0; source < 2; ++source)
        for (layers = 0; layers <= 3; ++layers)
            for (oracle = 0; oracle < DGB_ORACLE_COUNT; ++oracle)
                for (emission = 0; emission < DGB_EMISSION_COUNT; ++emission) {
                    fixture f;
                    start(&f);
                    f.desc.source = (dgb_source)source;
                    f.desc.layers = layers;
                    f.desc.oracle = (dgb_oracle)oracle;
                    f.desc.emission = (dgb_emission)emission;
                    f.desc.effects = BOTH;
                    if (dgb_init(&f.context, &f.desc) == DGB_OK && dgb_resize(&f.context, 32, 32) != DGB_OK)
                        fail_msg("source %d, layers %d, oracle %d, emission %d: %s", source, layers, oracle, emission,
                                 dgb_log_item_name(f.log_item));
                    stop(&f);
                }
}

static void test_resize_discards_the_layers(void** state) {
    fixture f;
    (void)state;
    start(&f);
    f.desc.effects = DGB_EFFECT_AO;
    init(&f);
    build(&f);
    assert_int_equal(dgb_resize(&f.context, 32, 32), DGB_OK);
    assert_int_equal(dgb_shade(&f.context, &f.params), DGB_INVALID);
    assert_int_equal(f.log_item, DGB_LOG_NO_LAYERS);
    build(&f);
    shade(&f);
    stop(&f);
}

/* >> refusals of backend, view and params */

static void check_init_refused(fixture* f, dgb_result result, dgb_log_item item) {
    dgb_context before;
    memset(&f->context, 0x5a, sizeof f->context);
    memcpy(&before, &f->context, sizeof before);
    f->log_count = 0;
    if (dgb_init(&f->context, &f->desc) != result || f->log_count != 1 || f->log_item != item ||
        f->log_result != result)
        fail_msg("expected %s, logged %s", dgb_log_item_name(item), dgb_log_item_name(f->log_item));
    check_nothing_changed(f, &before);
    assert_int_equal(f->r.creates, 0);
}

static void test_backend_is_checked(void** state) {
    fixture f;
    int callback;
    (void)state;
    for (callback = 0; callback < RECORD_CALLBACKS; ++callback) {
        start(&f);
        record_drop_callback(&f.r, callback);
        check_init_refused(&f, DGB_INVALID, DGB_LOG_BACKEND_CALLBACK);
        record_stop(&f.r);
    }
    start(&f);
    f.r.backend.version = DGB_VERSION + 1;
    check_init_refused(&f, DGB_INVALID, DGB_LOG_BACKEND_VERSION);
    f.r.backend.version = 0;
    check_init_refused(&f, DGB_INVALID, DGB_LOG_BACKEND_VERSION);
    f.r.backend.version = DGB_VERSION;
    f.desc.backend = NULL;
    check_init_refused(&f, DGB_INVALID, DGB_LOG_NULL_ARGUMENT);
    f.desc.backend = &f.r.backend;
    f.desc.width = 0;
    check_init_refused(&f, DGB_INVALID, DGB_LOG_SIZE);
    f.desc.width = 64;
    f.desc.emission = DGB_EMISSION_VERTEX;
    f.r.backend.caps.emission[DGB_EMISSION_VERTEX] = false;
    check_init_refused(&f, DGB_UNSUPPORTED, DGB_LOG_EMISSION);
    record_stop(&f.r);
}

static void test_optional_callbacks(void** state) {
    fixture f;
    (void)state;
    start(&f);
    f.r.backend.begin = NULL;
    f.r.backend.end = NULL;
    f.r.backend.marker = NULL;
    f.r.begins = 1; /* for the recorder's checks */
    f.desc.effects = BOTH;
    init(&f);
    build(&f);
    shade(&f);
    assert_int_equal(dgb_resize(&f.context, 32, 32), DGB_OK);
    f.r.ends = 1;
    f.r.begins = 2;
    dgb_shutdown(&f.context);
    assert_int_equal(record_alive(&f.r), 0);
    record_stop(&f.r);
}

/* The caller's structs may go as soon as dgb_init returns. */
static void test_desc_and_backend_are_copied(void** state) {
    dgb_backend backend;
    dgb_desc desc;
    fixture f;
    (void)state;
    start(&f);
    backend = f.r.backend;
    desc = f.desc;
    desc.backend = &backend;
    desc.effects = BOTH;
    assert_int_equal(dgb_init(&f.context, &desc), DGB_OK);
    memset(&backend, 0xff, sizeof backend);
    memset(&desc, 0xff, sizeof desc);
    build(&f);
    shade(&f);
    assert_int_equal(dgb_resize(&f.context, 32, 32), DGB_OK);
    stop(&f);
}

static void check_build_refused(fixture* f, dgb_log_item item, const char* why) {
    dgb_context before;
    memcpy(&before, &f->context, sizeof before);
    f->log_count = 0;
    f->draw_count = 0;
    record_clear(&f->r);
    if (dgb_build(&f->context, &f->view, &f->params, on_draw, f) != DGB_INVALID || f->log_count != 1 ||
        f->log_item != item)
        fail_msg("%s: %d logged, %s, not %s", why, f->log_count, dgb_log_item_name(f->log_item),
                 dgb_log_item_name(item));
    check_nothing_changed(f, &before);
    if (f->draw_count || f->r.trace.size) fail_msg("%s: something ran", why);
}

static void test_view_is_checked(void** state) {
    static const uint32_t odd[] = {0x7fc00000u, 0x7f800000u, 0xff800000u};
    fixture f;
    int i, k;
    (void)state;
    start(&f);
    init(&f);
    build(&f);
    for (k = 0; k < 3; ++k) {
        for (i = 0; i < 16; ++i) {
            f.view.view[i] = from_bits(odd[k]);
            check_build_refused(&f, DGB_LOG_MATRIX, "view");
            default_view(&f.view);
            f.view.projection[i] = from_bits(odd[k]);
            check_build_refused(&f, DGB_LOG_MATRIX, "projection");
            default_view(&f.view);
        }
        for (i = 0; i < 2; ++i) {
            f.view.jitter[i] = from_bits(odd[k]);
            check_build_refused(&f, DGB_LOG_MATRIX, "jitter");
            default_view(&f.view);
        }
    }
    f.view.projection[0] = 0.0f;
    check_build_refused(&f, DGB_LOG_PROJECTION, "singular");
    default_view(&f.view);
    f.view.projection[2] = 0.1f;
    check_build_refused(&f, DGB_LOG_PROJECTION, "oblique");
    default_view(&f.view);
    f.view.projection[11] = 1.0f;
    check_build_refused(&f, DGB_LOG_PROJECTION, "along +Z");
    default_view(&f.view);
    f.view.projection[14] = 0.2f;
    check_build_refused(&f, DGB_LOG_DIRECTION, "reversed");
    default_view(&f.view);
    f.view.projection[0] = 1e-40f;
    check_build_refused(&f, DGB_LOG_PROJECTION, "a scale whose inverse is infinite");
    stop(&f);
}

typedef void (*set_field)(dgb_params* p, float value);

static void set_separation(dgb_params* p, float x) { p->separation = x; }
static void set_guard_fraction(dgb_params* p, float x) { p->guard_fraction = x; }
static void set_ao_radius(dgb_params* p, float x) { p->ao_radius = x; }
static void set_ao_samples(dgb_params* p, float x) { p->ao_samples = (int)x; }
static void set_ao_bias(dgb_params* p, float x) { p->ao_bias = x; }
static void set_ao_epsilon(dgb_params* p, float x) { p->ao_epsilon = x; }
static void set_ao_intensity(dgb_params* p, float x) { p->ao_intensity = x; }
static void set_ao_min_level(dgb_params* p, float x) { p->ao_min_level = (int)x; }
static void set_radius(dgb_params* p, float x) { p->radius = x; }
static void set_samples(dgb_params* p, float x) { p->samples = (int)x; }
static void set_min_level(dgb_params* p, float x) { p->min_level = (int)x; }
static void set_filter_taps(dgb_params* p, float x) { p->filter_taps = (int)x; }
static void set_filter_step(dgb_params* p, float x) { p->filter_step = (int)x; }
static void set_normal_sharpness(dgb_params* p, float x) { p->normal_sharpness = x; }
static void set_plane_sharpness(dgb_params* p, float x) { p->plane_sharpness = x; }

static const struct {
    const char* name;
    set_field set;
    dgb_log_item item;
    bool is_float;
    float good[4], bad[4];
} fields[] = {
    {"separation", set_separation, DGB_LOG_SEPARATION, true, {0, 0.5f, 1e6f, 1}, {-0.001f, -1, -1e30f, -1}},
    {"guard_fraction",
     set_guard_fraction,
     DGB_LOG_GUARD_FRACTION,
     true,
     {0, 0.1f, 1, 0.5f},
     {-0.001f, 1.001f, 100, -1}},
    {"ao_radius", set_ao_radius, DGB_LOG_AO_PARAMS, true, {1e-6f, 1, 1e6f, 7}, {0, -1, -1e-6f, -1e30f}},
    {"ao_samples", set_ao_samples, DGB_LOG_AO_PARAMS, false, {1, 256, 16, 99}, {0, 257, -1, 1e6f}},
    {"ao_bias", set_ao_bias, DGB_LOG_AO_PARAMS, true, {0, 0.02f, 1, 10}, {-0.001f, -1, -1e30f, -1}},
    {"ao_epsilon", set_ao_epsilon, DGB_LOG_AO_PARAMS, true, {0, 0.001f, 1, 10}, {-0.001f, -1, -1e30f, -1}},
    {"ao_intensity", set_ao_intensity, DGB_LOG_AO_PARAMS, true, {0, 1, 2, 10}, {-0.001f, -1, -1e30f, -1}},
    {"ao_min_level", set_ao_min_level, DGB_LOG_MIP_PARAMS, false, {0, 5, 1, 2}, {-1, 6, 100, -100}},
    {"radius", set_radius, DGB_LOG_GATHER_PARAMS, true, {1e-6f, 7.4f, 1e6f, 1}, {0, -1, -1e-6f, -1e30f}},
    {"samples", set_samples, DGB_LOG_GATHER_PARAMS, false, {1, 256, 14, 30}, {0, 257, -1, 1e6f}},
    {"min_level", set_min_level, DGB_LOG_MIP_PARAMS, false, {0, 5, 1, 2}, {-1, 6, 100, -100}},
    {"filter_taps", set_filter_taps, DGB_LOG_FILTER_PARAMS, false, {1, 25, 9, 11}, {0, 2, 27, -1}},
    {"filter_step", set_filter_step, DGB_LOG_FILTER_PARAMS, false, {1, 8, 2, 3}, {0, 9, -1, 1e6f}},
    {"normal_sharpness", set_normal_sharpness, DGB_LOG_FILTER_PARAMS, true, {0, 1, 4, 100}, {-0.001f, -1, -1e30f, -1}},
    {"plane_sharpness", set_plane_sharpness, DGB_LOG_FILTER_PARAMS, true, {0, 1, 8, 100}, {-0.001f, -1, -1e30f, -1}},
};

static void check_shade_refused(fixture* f, dgb_log_item item, const char* why) {
    dgb_context before;
    memcpy(&before, &f->context, sizeof before);
    f->log_count = 0;
    record_clear(&f->r);
    if (dgb_shade(&f->context, &f->params) != DGB_INVALID || f->log_count != 1 || f->log_item != item)
        fail_msg("%s: %d logged, %s, not %s", why, f->log_count, dgb_log_item_name(f->log_item),
                 dgb_log_item_name(item));
    check_nothing_changed(f, &before);
    if (f->r.trace.size) fail_msg("%s: something ran", why);
}

static void check_field(fixture* f, size_t field) {
    static const uint32_t odd[] = {0x7fc00000u, 0x7f800000u, 0xff800000u};
    const dgb_params good = dgb_preset(DGB_PRESET_BALANCED);
    int i;
    for (i = 0; i < 4; ++i) {
        fields[field].set(&f->params, fields[field].bad[i]);
        check_build_refused(f, fields[field].item, fields[field].name);
        check_shade_refused(f, fields[field].item, fields[field].name);
        fields[field].set(&f->params, fields[field].good[i]);
        record_clear(&f->r);
        f->draw_count = 0;
        if (dgb_build(&f->context, &f->view, &f->params, on_draw, f) != DGB_OK ||
            dgb_shade(&f->context, &f->params) != DGB_OK)
            fail_msg("%s = %g is refused", fields[field].name, (double)fields[field].good[i]);
    }
    for (i = 0; fields[field].is_float && i < 3; ++i) {
        fields[field].set(&f->params, from_bits(odd[i]));
        check_build_refused(f, fields[field].item, fields[field].name);
        check_shade_refused(f, fields[field].item, fields[field].name);
    }
    f->params = good;
}

static void test_params_are_checked(void** state) {
    fixture f;
    size_t i;
    int id;
    (void)state;
    start(&f);
    f.desc.effects = BOTH;
    init(&f);
    build(&f);
    for (i = 0; i < sizeof fields / sizeof fields[0]; ++i) check_field(&f, i);
    for (id = 0; id < DGB_PRESET_COUNT; ++id) {
        f.params = dgb_preset((dgb_preset_id)id);
        record_clear(&f.r);
        f.draw_count = 0;
        build(&f);
        shade(&f);
    }
    stop(&f);
}

static bool all_finite(const float x[4]) {
    uint32_t u[4];
    memcpy(u, x, sizeof u);
    return (u[0] & 0x7f800000u) != 0x7f800000u && (u[1] & 0x7f800000u) != 0x7f800000u &&
           (u[2] & 0x7f800000u) != 0x7f800000u && (u[3] & 0x7f800000u) != 0x7f800000u;
}

static void check_finite_uniforms(float ao_radius, float radius) {
    fixture f;
    start(&f);
    f.desc.effects = BOTH;
    f.params.ao_radius = ao_radius;
    f.params.radius = radius;
    f.params.ao_epsilon = 0.0f;
    init(&f);
    if (dgb_build(&f.context, &f.view, &f.params, on_draw, &f) == DGB_OK) {
        shade(&f);
        if (!all_finite(record_uniforms_of(&f.r, DGB_PASS_AO, 0)->u.ao.radius) ||
            !all_finite(record_uniforms_of(&f.r, DGB_PASS_GATHER, 0)->u.gather.radius))
            fail_msg("ao_radius %g, radius %g: a uniform is not finite", (double)ao_radius, (double)radius);
    } else if (ao_radius <= DGB_MAX_RADIUS && radius <= DGB_MAX_RADIUS) {
        fail_msg("ao_radius %g, radius %g: refused", (double)ao_radius, (double)radius);
    }
    stop(&f);
}

/* However large or small a radius that is taken may be, the uniforms made from it are finite. */
static void test_uniforms_are_finite(void** state) {
    static const float radii[] = {1e-15f, 1e-10f, 1e10f, 1e15f, 1e19f, 1e25f, 3e38f};
    size_t i;
    (void)state;
    for (i = 0; i < sizeof radii / sizeof radii[0]; ++i) {
        check_finite_uniforms(radii[i], 1.0f);
        check_finite_uniforms(1.0f, radii[i]);
    }
}

static void test_null_arguments(void** state) {
    dgb_layers layers;
    fixture f;
    (void)state;
    memset(&layers, 0, sizeof layers);
    start(&f);
    init(&f);
    assert_int_equal(dgb_init(NULL, &f.desc), DGB_INVALID);
    assert_int_equal(f.log_item, DGB_LOG_NULL_ARGUMENT);
    assert_int_equal(dgb_init(&f.context, NULL), DGB_INVALID);
    f.log_count = 0;
    assert_int_equal(dgb_build(&f.context, NULL, &f.params, on_draw, &f), DGB_INVALID);
    assert_int_equal(dgb_build(&f.context, &f.view, NULL, on_draw, &f), DGB_INVALID);
    assert_int_equal(dgb_build(&f.context, &f.view, &f.params, NULL, &f), DGB_INVALID);
    assert_int_equal(dgb_set_layers(&f.context, NULL, &layers), DGB_INVALID);
    assert_int_equal(dgb_set_layers(&f.context, &f.view, NULL), DGB_INVALID);
    assert_int_equal(dgb_shade(&f.context, NULL), DGB_INVALID);
    assert_int_equal(f.log_count, 6);
    assert_int_equal(f.log_item, DGB_LOG_NULL_ARGUMENT);
    assert_int_equal(f.draw_count, 0);
    stop(&f);
}

static void check_dead(dgb_context* context, fixture* f) {
    dgb_layers layers;
    memset(&layers, 0, sizeof layers);
    assert_int_equal(dgb_build(context, &f->view, &f->params, on_draw, f), DGB_INVALID);
    assert_int_equal(dgb_set_layers(context, &f->view, &layers), DGB_INVALID);
    assert_int_equal(dgb_shade(context, &f->params), DGB_INVALID);
    assert_int_equal(dgb_resize(context, 10, 10), DGB_INVALID);
    assert_true(dgb_get_texture(context, DGB_DEPTH).id == 0);
    dgb_shutdown(context);
}

static void test_contexts_that_are_not_alive(void** state) {
    fixture f;
    (void)state;
    start(&f);
    check_dead(NULL, &f);
    check_dead(&f.context, &f); /* zeroed */
    init(&f);
    build(&f);
    dgb_shutdown(&f.context);
    record_clear(&f.r);
    check_dead(&f.context, &f);
    assert_string_equal(f.r.trace.data, "");
    stop(&f);
}

static void test_shading_before_building(void** state) {
    fixture f;
    (void)state;
    start(&f);
    f.desc.effects = BOTH;
    init(&f);
    check_shade_refused(&f, DGB_LOG_NO_LAYERS, "nothing built");
    build(&f);
    shade(&f);
    stop(&f);
}

static void test_wrong_source(void** state) {
    dgb_layers layers;
    fixture f;
    (void)state;
    start(&f);
    init(&f);
    layers = engine_layers(&f);
    assert_int_equal(dgb_set_layers(&f.context, &f.view, &layers), DGB_INVALID);
    assert_int_equal(f.log_item, DGB_LOG_WRONG_SOURCE);
    stop(&f);
    start(&f);
    f.desc.source = DGB_SOURCE_ENGINE;
    init(&f);
    check_build_refused(&f, DGB_LOG_WRONG_SOURCE, "built with layers of the engine's own");
    stop(&f);
}

/* >> the engine's own layers */

static void start_engine(fixture* f, int layers, uint32_t effects, dgb_normals normals) {
    start(f);
    f->desc.source = DGB_SOURCE_ENGINE;
    f->desc.layers = layers;
    f->desc.effects = effects;
    f->desc.normals = normals;
    init(f);
}

static void check_input(fixture* f, const dgb_layers* layers, bool good, const char* what) {
    dgb_context before;
    dgb_result result;
    memcpy(&before, &f->context, sizeof before);
    result = dgb_set_layers(&f->context, &f->view, layers);
    if (result != (good ? DGB_OK : DGB_INVALID)) fail_msg("%s: %s", what, dgb_result_name(result));
    if (good) return;
    assert_int_equal(f->log_item, DGB_LOG_INPUT);
    check_nothing_changed(f, &before);
}

/* Of depth, normal and radiance of both layers (bits 0 to 5), one at a time is missing. */
static void check_inputs(int layers, uint32_t effects, dgb_normals normals, unsigned needed) {
    dgb_layers all;
    fixture f;
    unsigned missing;
    start_engine(&f, layers, effects, normals);
    all = engine_layers(&f);
    for (missing = 0; missing < 6; ++missing) {
        dgb_layers given = all;
        dgb_texture* texture[6];
        texture[0] = &given.depth[0], texture[1] = &given.normal[0], texture[2] = &given.radiance[0];
        texture[3] = &given.depth[1], texture[4] = &given.normal[1], texture[5] = &given.radiance[1];
        texture[missing]->id = 0;
        check_input(&f, &given, !(needed >> missing & 1u), dgb_slot_name((dgb_slot)(DGB_ENGINE_DEPTH0 + (int)missing)));
    }
    stop(&f);
}

static void test_inputs_that_are_needed(void** state) {
    (void)state;
    check_inputs(1, 0, DGB_NORMALS_FROM_DEPTH, 0);
    check_inputs(1, DGB_EFFECT_AO, DGB_NORMALS_FROM_DEPTH, 1);
    check_inputs(1, DGB_EFFECT_AO, DGB_NORMALS_FLOAT, 1 | 2);
    check_inputs(1, DGB_EFFECT_RADIOSITY, DGB_NORMALS_FROM_DEPTH, 1 | 4);
    check_inputs(2, DGB_EFFECT_AO, DGB_NORMALS_OCT16, 1 | 2 | 8 | 16);
    check_inputs(2, BOTH, DGB_NORMALS_UNORM, 63);
}

static void check_engine_textures_live(const fixture* f, const dgb_layers* layers) {
    int i;
    for (i = 0; i < 2; ++i)
        if (!record_is_alive(&f->r, layers->depth[i]) || !record_is_alive(&f->r, layers->normal[i]) ||
            !record_is_alive(&f->r, layers->radiance[i]))
            fail_msg("a texture of the engine's layer %d is gone", i);
}

/* They are the engine's: neither shutdown nor resize may destroy them. */
static void test_engine_textures_outlive_the_context(void** state) {
    dgb_layers layers;
    fixture f;
    (void)state;
    start_engine(&f, 2, BOTH, DGB_NORMALS_FLOAT);
    layers = engine_layers(&f);
    set_layers(&f, &layers);
    shade(&f);
    assert_int_equal(dgb_resize(&f.context, 32, 32), DGB_OK);
    check_engine_textures_live(&f, &layers);
    assert_int_equal(dgb_shade(&f.context, &f.params), DGB_INVALID);
    layers = engine_layers(&f);
    set_layers(&f, &layers);
    shade(&f);
    dgb_shutdown(&f.context);
    check_engine_textures_live(&f, &layers);
    stop(&f);
}

/* Layers may change from frame to frame, and one layer need not name the second. */
static void test_engine_textures_may_change(void** state) {
    dgb_layers layers, others;
    fixture f;
    (void)state;
    start_engine(&f, 1, DGB_EFFECT_AO, DGB_NORMALS_FROM_DEPTH);
    layers = engine_layers(&f);
    others = engine_layers(&f);
    memset(&layers.depth[1], 0, sizeof layers.depth[1]);
    set_layers(&f, &layers);
    shade(&f);
    set_layers(&f, &others);
    shade(&f);
    stop(&f);
}

/* >> two contexts */

static void test_two_contexts(void** state) {
    fixture a, b;
    (void)state;
    start(&a);
    start(&b);
    a.desc.effects = b.desc.effects = BOTH;
    b.desc.layers = 3;
    init(&a);
    init(&b);
    build(&a);
    build(&b);
    shade(&a);
    shade(&b);
    assert_int_equal(dgb_resize(&a.context, 32, 32), DGB_OK);
    assert_int_equal(oracle_of_next_build(&b), DGB_ORACLE_REPROJECT);
    assert_int_equal(oracle_of_next_build(&a), DGB_ORACLE_PEEL);
    stop(&a);
    build(&b);
    shade(&b);
    stop(&b);
}

static void test_get_texture(void** state) {
    fixture f;
    int slot, i, given = 0;
    (void)state;
    start(&f);
    f.desc.effects = BOTH;
    init(&f);
    for (slot = 0; slot < DGB_SLOT_COUNT; ++slot) {
        const dgb_texture texture = dgb_get_texture(&f.context, (dgb_slot)slot);
        bool planned = false;
        for (i = 0; i < f.context.plan.texture_count; ++i) planned |= f.context.plan.textures[i].slot == (dgb_slot)slot;
        if (planned != (texture.id != 0)) fail_msg("%s", dgb_slot_name((dgb_slot)slot));
        given += planned;
    }
    assert_int_equal(given, f.context.plan.texture_count);
    assert_true(dgb_get_texture(&f.context, DGB_SLOT_COUNT).id == 0);
    assert_true(dgb_get_texture(&f.context, (dgb_slot)-1).id == 0);
    stop(&f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_golden_traces),
        cmocka_unit_test(test_building_and_shading_are_apart),
        cmocka_unit_test(test_draw_is_told_the_layers),
        cmocka_unit_test(test_draw_is_told_the_matrices),
        cmocka_unit_test(test_cut_and_resize_peel_again),
        cmocka_unit_test(test_depth_and_oracle_change_places),
        cmocka_unit_test(test_layer_uniforms),
        cmocka_unit_test(test_distance_uniforms),
        cmocka_unit_test(test_pack_uniforms),
        cmocka_unit_test(test_ao_uniforms),
        cmocka_unit_test(test_gather_uniforms),
        cmocka_unit_test(test_reconstruction_uniforms),
        cmocka_unit_test(test_shaded_rectangle),
        cmocka_unit_test(test_normal_test_picks_the_program),
        cmocka_unit_test(test_clip_and_direction_reach_the_backend),
        cmocka_unit_test(test_rotations_are_uploaded),
        cmocka_unit_test(test_failed_init_leaves_nothing),
        cmocka_unit_test(test_failed_resize_keeps_the_old),
        cmocka_unit_test(test_refused_resize_keeps_the_old),
        cmocka_unit_test(test_resize_knows_the_device),
        cmocka_unit_test(test_resize_to_the_same_does_nothing),
        cmocka_unit_test(test_whatever_was_initialised_resizes),
        cmocka_unit_test(test_resize_discards_the_layers),
        cmocka_unit_test(test_backend_is_checked),
        cmocka_unit_test(test_optional_callbacks),
        cmocka_unit_test(test_desc_and_backend_are_copied),
        cmocka_unit_test(test_view_is_checked),
        cmocka_unit_test(test_params_are_checked),
        cmocka_unit_test(test_uniforms_are_finite),
        cmocka_unit_test(test_null_arguments),
        cmocka_unit_test(test_contexts_that_are_not_alive),
        cmocka_unit_test(test_shading_before_building),
        cmocka_unit_test(test_wrong_source),
        cmocka_unit_test(test_inputs_that_are_needed),
        cmocka_unit_test(test_engine_textures_outlive_the_context),
        cmocka_unit_test(test_engine_textures_may_change),
        cmocka_unit_test(test_two_contexts),
        cmocka_unit_test(test_get_texture),
    };
    return cmocka_run_group_tests_name("trace", tests, NULL, NULL);
}
