/* Frames through the record backend: which passes run, in what order, with what bound; life and death of all
   objects. */

#include "numbers.h"
#include "record_backend.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

#define BOTH (DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY)

#define ALL_EFFECTS (BOTH | DGB_EFFECT_BOUNCES | DGB_EFFECT_TEMPORAL | DGB_EFFECT_REFLECT | DGB_EFFECT_GLOSSY)

static bool makes_sense(uint32_t effects) {
    if ((effects & DGB_EFFECT_BOUNCES) && !(effects & DGB_EFFECT_RADIOSITY)) return false;
    if ((effects & DGB_EFFECT_GLOSSY) && !(effects & DGB_EFFECT_REFLECT)) return false;
    return (effects & (BOTH | DGB_EFFECT_GLOSSY)) || !(effects & DGB_EFFECT_TEMPORAL);
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
    dgb_pass passes[MAX_DRAWS]; /* that each draw was in */
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
    const dgb_texture oracle = record_bound(&f->r, DGB_ORACLE);
    if (!f->r.in_pass) fail_msg("draw callback of layer %d outside of a pass", draw->first_layer);
    if (f->draw_count == MAX_DRAWS) fail_msg("more than %d draws", MAX_DRAWS);
    /* peeling compares with what this frame has drawn, every other oracle with what it has not */
    if (oracle.id && !draw->back_faces &&
        (oracle.id == f->r.pass.depth.texture.id) != (draw->oracle == DGB_ORACLE_PEEL))
        fail_msg("oracle %s reads %s and writes %s", dgb_oracle_name(draw->oracle), record_texture_name(&f->r, oracle),
                 record_texture_name(&f->r, f->r.pass.depth.texture));
    f->passes[f->draw_count] = f->r.pass;
    f->draws[f->draw_count++] = *draw;
    record_printf(&f->r.trace, " draw scene: layers %d+%d, instances %d, oracle %s, emission %s", draw->first_layer,
                  draw->layer_count, draw->instances, dgb_oracle_name(draw->oracle), dgb_emission_name(draw->emission));
    if (draw->pose) record_printf(&f->r.trace, ", pose %d", draw->pose);
    if (draw->depth_only) record_printf(&f->r.trace, ", depth only");
    if (draw->back_faces) record_printf(&f->r.trace, ", back faces");
    record_printf(&f->r.trace, "\n");
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
        layers.albedo[i] = record_engine_texture(&f->r, i ? DGB_ENGINE_ALBEDO1 : DGB_ENGINE_ALBEDO0, width, height);
        layers.velocity[i] =
            record_engine_texture(&f->r, i ? DGB_ENGINE_VELOCITY1 : DGB_ENGINE_VELOCITY0, width, height);
    }
    layers.back = record_engine_texture(&f->r, DGB_ENGINE_BACK, width, height);
    layers.roughness = record_engine_texture(&f->r, DGB_ENGINE_ROUGHNESS, width, height);
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
    {DGB_ORACLE_PEEL, DGB_EMISSION_SEPARATE},
    {DGB_ORACLE_PREVIOUS, DGB_EMISSION_SEPARATE},
    {DGB_ORACLE_PREVIOUS, DGB_EMISSION_GEOMETRY},
    {DGB_ORACLE_PREVIOUS, DGB_EMISSION_VERTEX},
    {DGB_ORACLE_REPROJECT, DGB_EMISSION_SEPARATE},
    {DGB_ORACLE_REPROJECT, DGB_EMISSION_GEOMETRY},
    {DGB_ORACLE_REPROJECT, DGB_EMISSION_VERTEX},
    /* the golden file holds these too, but for one emission of PREDICT and DELAY that goes like GEOMETRY */
    {DGB_ORACLE_REPROJECT, DGB_EMISSION_IMAGE},
    {DGB_ORACLE_PREDICT, DGB_EMISSION_SEPARATE},
    {DGB_ORACLE_PREDICT, DGB_EMISSION_VERTEX},
    {DGB_ORACLE_PREDICT, DGB_EMISSION_IMAGE},
    {DGB_ORACLE_DELAY, DGB_EMISSION_SEPARATE},
    {DGB_ORACLE_DELAY, DGB_EMISSION_VERTEX},
    {DGB_ORACLE_DELAY, DGB_EMISSION_IMAGE},
    {DGB_ORACLE_PREDICT, DGB_EMISSION_INSTANCED_GEOMETRY},
    {DGB_ORACLE_DELAY, DGB_EMISSION_MULTICAST},
    {DGB_ORACLE_WARP, DGB_EMISSION_VERTEX},
    {DGB_ORACLE_WARP, DGB_EMISSION_IMAGE}};
enum { OLD_CONSTRUCTIONS = 7, GOLDEN_CONSTRUCTIONS = 14, PREDICTING_END = 16, CONSTRUCTION_COUNT = 18 };

static void configure(fixture* f, construction c, int layers, uint32_t effects) {
    start(f);
    f->desc.oracle = c.oracle;
    f->desc.emission = c.emission;
    f->desc.layers = layers;
    f->desc.effects = effects;
}

/* Builds of the first frames; with `shading`, what dgb_shade did in the last goes there. */
static void trace_frames(int frames, int divisor, construction c, int layers, uint32_t effects, record_text* text,
                         record_text* shading) {
    fixture f;
    int frame;
    configure(&f, c, layers, effects);
    f.desc.divisor = divisor;
    init(&f);
    record_clear(&f.r);
    for (frame = 0; frame < frames; ++frame) {
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

static void trace_two_frames(construction c, int layers, uint32_t effects, record_text* text, record_text* shading) {
    trace_frames(2, 1, c, layers, effects, text, shading);
}

static void print_builds(record_text* text, construction c, int layers) {
    record_printf(text, "== build, layers %d, oracle %s, emission %s\n", layers, dgb_oracle_name(c.oracle),
                  dgb_emission_name(c.emission));
    trace_two_frames(c, layers, 0, text, NULL);
    record_printf(text, "\n");
}

/* Three frames: with two the textures that change places are back where they were. */
static void print_three_builds(record_text* text, construction c, int layers, int divisor) {
    record_printf(text, "== three builds, layers %d, oracle %s, emission %s, divisor %d\n", layers,
                  dgb_oracle_name(c.oracle), dgb_emission_name(c.emission), divisor);
    trace_frames(3, divisor, c, layers, 0, text, NULL);
    record_printf(text, "\n");
}

static void print_shading(record_text* text, int layers, uint32_t effects) {
    record_text build_text = {0}, shading = {0};
    trace_two_frames(constructions[6], layers, effects, &build_text, &shading);
    record_printf(text, "== shade, layers %d, effects %s\n%s\n", layers, record_effect_names(effects), shading.data);
    record_text_free(&build_text);
    record_text_free(&shading);
}

static void print_hierarchical_shading(record_text* text) {
    fixture f;
    configure(&f, constructions[6], 2, DGB_EFFECT_REFLECT);
    f.desc.tracer = DGB_TRACER_HIERARCHICAL;
    init(&f);
    build(&f);
    record_clear(&f.r);
    shade(&f);
    record_printf(text, "== shade, hierarchical tracer\n");
    take_trace(&f, text);
    record_printf(text, "\n");
    stop(&f);
}

/* Two frames, whole. Back faces are drawn behind the layers of the same pose and before the next. */
static void print_back(record_text* text, construction c, int layers, int divisor) {
    fixture f;
    int frame;
    configure(&f, c, layers, DGB_EFFECT_REFLECT);
    f.desc.thickness = DGB_THICKNESS_BACK_FACES;
    f.desc.divisor = divisor;
    init(&f);
    record_clear(&f.r);
    record_printf(text, "== back faces, layers %d, oracle %s, emission %s, divisor %d\n", layers,
                  dgb_oracle_name(c.oracle), dgb_emission_name(c.emission), divisor);
    for (frame = 0; frame < 2; ++frame) {
        record_printf(text, "-- frame %d\n", frame);
        build(&f);
        shade(&f);
        take_trace(&f, text);
    }
    record_printf(text, "\n");
    stop(&f);
}

/* Three frames, whole: with two the textures that change places are back where they were. */
static void print_history(record_text* text, int layers, uint32_t effects) {
    fixture f;
    int frame;
    configure(&f, constructions[6], layers, effects);
    record_printf(text, "== history, layers %d, effects %s\n", layers, record_effect_names(effects));
    init(&f);
    for (frame = 0; frame < 3; ++frame) {
        build(&f);
        record_clear(&f.r);
        f.draw_count = 0;
        record_printf(text, "-- frame %d\n", frame);
        shade(&f);
        take_trace(&f, text);
    }
    record_printf(text, "\n");
    stop(&f);
}

static void print_life(record_text* text, int layers, uint32_t effects, dgb_source source) {
    fixture f;
    start(&f);
    f.desc.layers = layers;
    f.desc.effects = effects;
    f.desc.source = source;
    record_printf(text, "== init, resize to 32x32 and shutdown, layers %d, effects %s%s\n", layers,
                  record_effect_names(effects), source == DGB_SOURCE_ENGINE ? ", the engine's own" : "");
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
    for (i = 0; i < OLD_CONSTRUCTIONS; ++i) print_builds(&text, constructions[i], 2);
    print_builds(&text, constructions[0], 1);
    print_builds(&text, constructions[0], 3);
    for (i = 4; i < OLD_CONSTRUCTIONS; ++i) print_builds(&text, constructions[i], 3);
    for (effects = 0; effects < 4; ++effects) {
        print_shading(&text, 1, effects);
        print_shading(&text, 2, effects);
    }
    print_shading(&text, 3, BOTH);
    print_engine(&text, 1, DGB_NORMALS_FROM_DEPTH);
    print_engine(&text, 2, DGB_NORMALS_FLOAT);
    print_life(&text, 2, BOTH, DGB_SOURCE_BUILD);
    print_life(&text, 1, DGB_EFFECT_AO, DGB_SOURCE_ENGINE);
    for (i = OLD_CONSTRUCTIONS; i < GOLDEN_CONSTRUCTIONS; ++i) {
        print_three_builds(&text, constructions[i], 2, 1);
        print_three_builds(&text, constructions[i], 3, 1);
    }
    print_three_builds(&text, constructions[4], 3, 2);  /* separate */
    print_three_builds(&text, constructions[6], 3, 4);  /* vertex */
    print_three_builds(&text, constructions[12], 3, 2); /* delay, vertex */
    print_three_builds(&text, constructions[8], 3, 4);  /* predict, separate */
    print_shading(&text, 1, DGB_EFFECT_AO | DGB_EFFECT_TEMPORAL);
    print_shading(&text, 2, DGB_EFFECT_RADIOSITY | DGB_EFFECT_BOUNCES);
    print_history(&text, 2, ALL_EFFECTS & ~(DGB_EFFECT_REFLECT | DGB_EFFECT_GLOSSY));
    print_shading(&text, 1, DGB_EFFECT_REFLECT);
    print_history(&text, 1, DGB_EFFECT_REFLECT | DGB_EFFECT_GLOSSY | DGB_EFFECT_TEMPORAL);
    print_shading(&text, 2, ALL_EFFECTS);
    print_hierarchical_shading(&text);
    print_back(&text, constructions[0], 1, 1);
    print_back(&text, constructions[6], 2, 2);
    print_back(&text, constructions[13], 2, 1); /* delay, image */
    record_check_golden("trace.golden", &text);
    record_text_free(&text);
}

/* So the golden file need not hold every combination: builds know nothing of effects, shading nothing of
   builds. */
static void test_building_and_shading_are_apart(void** state) {
    uint32_t effects;
    int i, layers;
    (void)state;
    for (effects = 0; effects <= ALL_EFFECTS; ++effects)
        for (layers = 1; layers <= 4 && makes_sense(effects); ++layers) {
            record_text first_shading = {0};
            for (i = 0; i < CONSTRUCTION_COUNT; ++i) {
                record_text plain = {0}, built = {0}, shading = {0};
                trace_two_frames(constructions[i], layers, 0, &plain, NULL);
                trace_two_frames(constructions[i], layers, effects, &built, &shading);
                if (strcmp(plain.data, built.data) != 0)
                    fail_msg("effects %s change construction %d", record_effect_names(effects), i);
                if (!i) record_printf(&first_shading, "%s", shading.data);
                if (strcmp(first_shading.data, shading.data) != 0)
                    fail_msg("construction %d changes effects %s", i, record_effect_names(effects));
                record_text_free(&plain);
                record_text_free(&built);
                record_text_free(&shading);
            }
            record_text_free(&first_shading);
        }
}

/* >> what the draw callback is told */

/* A second account of dgb_build, as plain as can be: from the views of all frames, which draws there are and what each is
   told. */

enum { MAX_EXPECTED = 16 };

typedef struct expected_draw {
    dgb_pass_id pass;
    int first, count, instances, pose_offset;
    dgb_oracle oracle;
    dgb_pose pose, previous;
    dgb_camera camera, oracle_camera;
    bool guessed; /* the view is an extrapolation: compared within a tolerance */
} expected_draw;

typedef struct model {
    fixture* f;
    dgb_oracle oracle;
    dgb_emission emission;
    int layers;
    bool running;
    dgb_pose drawn, submitted;             /* last */
    dgb_camera oracle_camera, last_camera; /* the second: as the first was before this frame */
    int count;
    expected_draw draws[MAX_EXPECTED];
} model;

static dgb_pose pose_of(const fixture* f) {
    dgb_pose pose;
    memcpy(pose.view, f->view.view, sizeof pose.view);
    dgb_widen_projection(f->view.projection, f->context.desc.width, f->context.desc.height, 8, f->view.jitter,
                         pose.projection);
    return pose;
}

static dgb_camera camera_of(const fixture* f, const dgb_pose* pose) {
    dgb_camera camera;
    memset(&camera, 0, sizeof camera);
    if (dgb_camera_from_matrix(pose->projection, f->context.desc.width + 16, f->context.desc.height + 16, f->desc.clip,
                               f->desc.reversed, &camera) != DGB_OK)
        fail_msg("no camera");
    return camera;
}

/* inverse of a 4 x 4 matrix by elimination with pivots; column-major */
static void invert_in_double(const double m[16], double inverse[16]) {
    double a[4][8];
    int row, column, k;
    for (row = 0; row < 4; ++row)
        for (column = 0; column < 8; ++column) a[row][column] = column < 4 ? m[column * 4 + row] : column - 4 == row;
    for (k = 0; k < 4; ++k) {
        int pivot = k;
        for (row = k; row < 4; ++row)
            if (fabs(a[row][k]) > fabs(a[pivot][k])) pivot = row;
        for (column = 0; column < 8; ++column) {
            const double t = a[k][column];
            a[k][column] = a[pivot][column];
            a[pivot][column] = t;
        }
        for (row = 0; row < 4; ++row) {
            const double factor = row == k ? 0.0 : a[row][k] / a[k][k];
            for (column = 0; column < 8; ++column) a[row][column] -= factor * a[k][column];
        }
    }
    for (row = 0; row < 4; ++row)
        for (column = 0; column < 4; ++column) inverse[column * 4 + row] = a[row][column + 4] / a[row][row];
}

/* c = a b, and the sum of magnitudes that every entry was made of */
static void multiply_in_double(const double a[16], const double b[16], double c[16], double size[16]) {
    int row, column, k;
    for (column = 0; column < 4; ++column)
        for (row = 0; row < 4; ++row) {
            c[column * 4 + row] = size[column * 4 + row] = 0.0;
            for (k = 0; k < 4; ++k) {
                c[column * 4 + row] += a[k * 4 + row] * b[column * 4 + k];
                size[column * 4 + row] += fabs(a[k * 4 + row] * b[column * 4 + k]);
            }
        }
}

static void check_extrapolation(const float before[16], const float now[16], const float next[16]) {
    double b[16], n[16], inverse[16], step[16], expected[16], size[16];
    int i;
    for (i = 0; i < 16; ++i) b[i] = (double)before[i], n[i] = (double)now[i];
    invert_in_double(b, inverse);
    multiply_in_double(n, inverse, step, size);
    multiply_in_double(step, n, expected, size);
    for (i = 0; i < 16; ++i)
        if (!(fabs((double)next[i] - expected[i]) <= 6e-8 * fabs(expected[i]) + 1e-10 * size[i]))
            fail_msg("entry %d of the next view: %.9g, not %.9g", i, (double)next[i], expected[i]);
}

static void expect_submission(model* m, dgb_pass_id pass, int layers, expected_draw d) {
    const bool alone = d.oracle == DGB_ORACLE_PEEL || m->emission == DGB_EMISSION_SEPARATE;
    int layer;
    d.pass = pass;
    d.oracle_camera = d.oracle == DGB_ORACLE_PEEL || d.oracle == DGB_ORACLE_WARP ? d.camera : m->oracle_camera;
    for (layer = 0; layer < (alone ? layers : 1); ++layer) {
        d.first = layer;
        d.count = alone ? 1 : layers;
        d.instances = !alone && m->emission == DGB_EMISSION_VERTEX ? layers : 1;
        m->draws[m->count++] = d;
    }
}

static void expect_frame(model* m) {
    const fixture* f = m->f;
    const bool fresh = !m->running || f->view.cut;
    const dgb_pose submitted = pose_of(f);
    expected_draw main_draw, prediction;
    m->count = 0;
    m->last_camera = m->oracle_camera;
    memset(&main_draw, 0, sizeof main_draw);
    main_draw.oracle = fresh ? DGB_ORACLE_PEEL : m->oracle;
    main_draw.pose = submitted;
    if (m->oracle == DGB_ORACLE_DELAY && !fresh) main_draw.pose = m->submitted, main_draw.pose_offset = -1;
    main_draw.previous = fresh ? main_draw.pose : m->drawn;
    main_draw.camera = camera_of(f, &main_draw.pose);
    expect_submission(m, DGB_PASS_LAYERS, m->layers, main_draw);
    prediction = main_draw;
    prediction.previous = main_draw.pose;
    prediction.pose = submitted;
    prediction.pose_offset = 0;
    prediction.camera = camera_of(f, &submitted);
    if (m->oracle == DGB_ORACLE_PREDICT) {
        prediction.pose_offset = 1;
        if (f->view.has_next) memcpy(prediction.pose.view, f->view.next_view, sizeof f->view.next_view);
        prediction.guessed = !f->view.has_next && !fresh;
    }
    if (m->layers > 1 && (m->oracle == DGB_ORACLE_PREDICT || m->oracle == DGB_ORACLE_DELAY))
        expect_submission(m, DGB_PASS_PREDICT, m->layers - 1, prediction);
    else
        prediction = main_draw;
    m->oracle_camera = prediction.camera;
}

static void model_advances(model* m) {
    m->drawn = m->draws[0].pose;
    m->submitted = pose_of(m->f);
    m->running = true;
}

static void check_draw(const model* m, int i) {
    const expected_draw* e = &m->draws[i];
    const dgb_draw* d = &m->f->draws[i];
    const dgb_desc* desc = &m->f->context.desc;
    if (d->first_layer != e->first || d->layer_count != e->count || d->instances != e->instances ||
        d->oracle != e->oracle || d->emission != m->emission || d->pose != e->pose_offset ||
        d->depth_only != (e->pass == DGB_PASS_PREDICT) || m->f->passes[i].id != e->pass ||
        d->width != desc->width + 16 || d->height != desc->height + 16)
        fail_msg("draw %d: %s, layers %d+%d, instances %d, oracle %s, pose %d, %s, %dx%d", i,
                 dgb_pass_name(m->f->passes[i].id), d->first_layer, d->layer_count, d->instances,
                 dgb_oracle_name(d->oracle), d->pose, d->depth_only ? "depth only" : "all", d->width, d->height);
    if (e->guessed)
        check_extrapolation(m->drawn.view, m->f->view.view, d->view);
    else
        assert_memory_equal(d->view, e->pose.view, sizeof d->view);
    assert_memory_equal(d->projection, e->pose.projection, sizeof d->projection);
    assert_memory_equal(d->previous_view, e->previous.view, sizeof d->view);
    assert_memory_equal(d->previous_projection, e->previous.projection, sizeof d->projection);
}

/* Distance of a point at camera z, through a projection and its row in the uniforms. */
static float distance_of(const float projection[16], const float row[4], float z) {
    const float clip_z = projection[10] * z + projection[14], clip_w = projection[11] * z + projection[15];
    return row[0] * clip_z + row[1] * clip_w + row[2];
}

static void check_draw_uniforms(const model* m, int i, int in_pass) {
    const expected_draw* e = &m->draws[i];
    const dgb_draw_uniforms* u = &record_uniforms_of(&m->f->r, e->pass, in_pass)->u.draw;
    const dgb_desc* desc = &m->f->context.desc;
    assert_memory_equal(&u->camera, &e->camera, sizeof u->camera);
    assert_memory_equal(&u->previous, &e->oracle_camera, sizeof u->previous);
    assert_true(fabsf(distance_of(e->pose.projection, u->distance, -5.0f) - 5.0f) < 2e-5f);
    assert_true(fabsf(distance_of(e->previous.projection, u->previous_distance, -5.0f) - 5.0f) < 2e-5f);
    assert_true(u->size[0] == (float)(desc->width + 16) && u->size[1] == (float)(desc->height + 16));
    assert_true(u->size[2] == m->f->params.separation && u->size[3] == 0.0f);
    assert_true(u->layer[0] == e->first && u->layer[1] == e->count);
    assert_true(u->layer[2] == (int32_t)e->oracle && u->layer[3] == e->instances);
    assert_true(u->flags[0] == desc->divisor && u->flags[1] == desc->reversed && !u->flags[2] && !u->flags[3]);
}

/* Image emission: the keys of each deeper layer become its depth, but where that was peeled. */
static void check_resolves(const model* m) {
    int i, layer, expected = 0, found = 0;
    for (i = 0; i < m->f->draw_count; ++i) {
        const bool resolves = m->emission == DGB_EMISSION_IMAGE && m->draws[i].count > 1;
        assert_int_equal(m->f->passes[i].key.id != 0, resolves);
        for (layer = 1; resolves && layer < m->draws[i].count; ++layer, ++expected)
            assert_int_equal(record_uniforms_of(&m->f->r, DGB_PASS_RESOLVE, expected)->u.resolve[0], layer - 1);
    }
    for (i = 0; i < m->f->r.uniform_count; ++i) found += m->f->r.uniforms[i].pass == DGB_PASS_RESOLVE;
    assert_int_equal(found, expected);
}

/* WARP: each layer that another is compared with, from the camera of the frame before to this frame's. */
static void check_warps(const model* m) {
    const expected_draw* e = &m->draws[0];
    const int expected = e->oracle == DGB_ORACLE_WARP ? m->layers - 1 : 0;
    int i, found = 0;
    for (i = 0; i < m->f->r.uniform_count; ++i) found += m->f->r.uniforms[i].pass == DGB_PASS_WARP;
    assert_int_equal(found, expected);
    for (i = 0; i < expected; ++i) {
        const dgb_warp_uniforms* u = &record_uniforms_of(&m->f->r, DGB_PASS_WARP, i)->u.warp;
        const dgb_desc* desc = &m->f->context.desc;
        const int divisor = i > 0 ? desc->divisor : 1;
        assert_memory_equal(&u->camera, &e->camera, sizeof u->camera);
        assert_memory_equal(&u->last, &m->last_camera, sizeof u->last);
        assert_true(u->layer[0] == i && u->layer[1] == divisor);
        /* the last texel whose centre lies within the buffer */
        assert_true(((float)u->layer[2] + 0.5f) * (float)divisor < (float)(desc->width + 16));
        assert_true(((float)u->layer[2] + 1.5f) * (float)divisor >= (float)(desc->width + 16));
        assert_true(((float)u->layer[3] + 0.5f) * (float)divisor < (float)(desc->height + 16));
        assert_true(((float)u->layer[3] + 1.5f) * (float)divisor >= (float)(desc->height + 16));
    }
}

static void run_and_check(model* m) {
    fixture* f = m->f;
    int i, in_pass = 0;
    record_clear(&f->r);
    f->draw_count = 0;
    expect_frame(m);
    build(f);
    if (f->draw_count != m->count) fail_msg("%d draws, not %d", f->draw_count, m->count);
    for (i = 0; i < m->count; ++i) {
        in_pass = i && m->draws[i].pass == m->draws[i - 1].pass ? in_pass + 1 : 0;
        check_draw(m, i);
        check_draw_uniforms(m, i, in_pass);
    }
    check_warps(m);
    check_resolves(m);
    assert_memory_equal(&f->context.camera, &m->draws[0].camera, sizeof f->context.camera);
    model_advances(m);
}

static uint32_t random_state;

static double random_between(double low, double high) { return low + (high - low) * lcg_unit(&random_state); }

/* A random rotation, scaled along its own axes by 1 / spread to spread, and moved. */
static void random_view(double spread, double reach, float view[16]) {
    double q[4], length = 0.0;
    int row, column;
    for (row = 0; row < 4; ++row) q[row] = random_between(-1.0, 1.0), length += q[row] * q[row];
    length = sqrt(length) + 1e-9;
    for (row = 0; row < 4; ++row) q[row] /= length;
    memset(view, 0, sizeof(float) * 16);
    for (column = 0; column < 3; ++column) {
        const double scale = pow(spread, random_between(-1.0, 1.0));
        double axis[3] = {0.0, 0.0, 0.0}, uv[3], uuv[3];
        axis[column] = scale;
        uv[0] = q[1] * axis[2] - q[2] * axis[1], uv[1] = q[2] * axis[0] - q[0] * axis[2];
        uv[2] = q[0] * axis[1] - q[1] * axis[0];
        uuv[0] = q[1] * uv[2] - q[2] * uv[1], uuv[1] = q[2] * uv[0] - q[0] * uv[2],
        uuv[2] = q[0] * uv[1] - q[1] * uv[0];
        for (row = 0; row < 3; ++row) view[column * 4 + row] = (float)(axis[row] + 2.0 * (q[3] * uv[row] + uuv[row]));
    }
    for (row = 0; row < 3; ++row) view[12 + row] = (float)random_between(-reach, reach);
    view[15] = 1.0f;
}

/* Near, far, field of view and jitter are others in every frame; every third is orthographic. */
static void random_frame(dgb_view* view, bool reversed) {
    const double near_plane = random_between(0.05, 1.0), far_plane = random_between(40.0, 400.0);
    const double a = reversed ? far_plane : near_plane, b = reversed ? near_plane : far_plane;
    memset(view, 0, sizeof *view);
    random_view(1.0, 10.0, view->view);
    view->projection[0] = (float)random_between(0.4, 1.5);
    view->projection[5] = (float)random_between(0.4, 1.5);
    view->projection[8] = (float)random_between(-0.2, 0.2);
    if (random_between(0.0, 3.0) < 1.0) {
        view->projection[10] = (float)(2.0 / (a - b));
        view->projection[14] = (float)((a + b) / (a - b));
        view->projection[15] = 1.0f;
        view->projection[8] = 0.0f;
    } else {
        view->projection[10] = (float)((a + b) / (a - b));
        view->projection[14] = (float)(2.0 * a * b / (a - b));
        view->projection[11] = -1.0f;
    }
    view->jitter[0] = (float)random_between(-0.5, 0.5);
    view->jitter[1] = (float)random_between(-0.5, 0.5);
}

/* First frame, steady frames, cuts (two in a row), a resize, known and unknown next views. */
static void check_frames(construction c, int layers, bool reversed, int divisor) {
    static const char script[] = "..n.cc.n..c..r.n.cr..";
    fixture f;
    model m;
    int i;
    configure(&f, c, layers, 0);
    f.desc.reversed = reversed;
    f.desc.divisor = divisor;
    f.params.separation = 0.25f;
    init(&f);
    memset(&m, 0, sizeof m);
    m.f = &f;
    m.oracle = layers > 1 || c.oracle != DGB_ORACLE_DEFAULT ? c.oracle : DGB_ORACLE_PEEL;
    m.emission = layers > 1 ? c.emission : DGB_EMISSION_SEPARATE;
    m.layers = layers;
    for (i = 0; script[i]; ++i) {
        random_frame(&f.view, reversed);
        f.view.cut = script[i] == 'c';
        f.view.has_next = script[i] == 'n';
        random_view(1.0, 10.0, f.view.next_view);
        if (script[i] == 'r') {
            assert_int_equal(dgb_resize(&f.context, f.context.desc.width + 3, f.context.desc.height + 1), DGB_OK);
            m.running = false;
        }
        run_and_check(&m);
    }
    stop(&f);
}

static void test_every_submission(void** state) {
    static const int counts[] = {1, 2, 3, 8};
    int oracle, emission, i, reversed;
    (void)state;
    random_state = 3u;
    for (oracle = DGB_ORACLE_PEEL; oracle < DGB_ORACLE_COUNT; ++oracle)
        for (emission = DGB_EMISSION_SEPARATE; emission < DGB_EMISSION_COUNT; ++emission)
            for (i = 0; i < 4; ++i)
                for (reversed = 0; reversed < 2; ++reversed) {
                    construction c;
                    const bool divides = emission != DGB_EMISSION_IMAGE && emission != DGB_EMISSION_MULTICAST;
                    if (oracle == DGB_ORACLE_PEEL && emission != DGB_EMISSION_SEPARATE) continue;
                    c.oracle = (dgb_oracle)oracle;
                    c.emission = (dgb_emission)emission;
                    check_frames(c, counts[i], reversed != 0, reversed && divides ? 4 : 1);
                }
}

/* >> the next view */

static void start_predicting(fixture* f) {
    start(f);
    f->desc.oracle = DGB_ORACLE_PREDICT;
    f->desc.emission = DGB_EMISSION_SEPARATE;
    init(f);
}

/* View of the prediction's draw after a frame with this view. */
static const float* predicted_view(fixture* f) {
    f->draw_count = 0;
    build(f);
    assert_int_equal(f->draw_count, 3);
    assert_true(f->draws[2].depth_only && f->draws[2].pose == 1);
    record_clear(&f->r);
    return f->draws[2].view;
}

static void test_extrapolated_view(void** state) {
    static const double spreads[] = {1.0, 1.0, 2.0, 30.0}, reaches[] = {3.0, 1000.0, 20.0, 5.0};
    float before[16], now[16];
    fixture f;
    int i, kind;
    (void)state;
    start_predicting(&f);
    random_state = 11u;
    for (kind = 0; kind < 4; ++kind)
        for (i = 0; i < 500; ++i) {
            random_view(spreads[kind], reaches[kind], before);
            random_view(spreads[kind], reaches[kind], now);
            memcpy(f.view.view, before, sizeof before);
            f.view.cut = true;
            assert_memory_equal(predicted_view(&f), before, sizeof before); /* nothing to go on from: it stays */
            memcpy(f.view.view, now, sizeof now);
            f.view.cut = false;
            check_extrapolation(before, now, predicted_view(&f));
        }
    /* a camera that stands still is foretold to the last bit, whatever its matrix */
    for (i = 0; i < 200; ++i) {
        int entry;
        const float* next;
        random_view(1.0, 50.0, now);
        memcpy(f.view.view, now, sizeof now);
        (void)predicted_view(&f);
        next = predicted_view(&f);
        for (entry = 0; entry < 16; ++entry)
            if (next[entry] != now[entry])
                fail_msg("standing still, entry %d went from %.9g to %.9g", entry, (double)now[entry],
                         (double)next[entry]);
    }
    stop(&f);
}

/* Then there is no motion to go on with: the next view is this one. Nor is there when the guess has no end. */
static void test_extrapolation_from_a_singular_view(void** state) {
    float now[16];
    fixture f;
    int i, kind;
    (void)state;
    start_predicting(&f);
    random_state = 5u;
    for (kind = 0; kind < 4; ++kind) {
        random_view(1.0, 5.0, f.view.view);
        for (i = 0; i < 3; ++i) {
            if (kind == 0) f.view.view[4 + i] = 0.0f;                              /* a column is zero */
            if (kind == 1) f.view.view[4 * i] = f.view.view[4 * i + 1] = 0.0f;     /* two rows are */
            if (kind == 2) memset(f.view.view, 0, sizeof f.view.view);             /* all is */
            if (kind == 3) f.view.view[i] *= 1e-35f, f.view.view[4 + i] *= 1e-35f; /* not singular, but nearly */
        }
        f.view.cut = true;
        build(&f);
        f.view.cut = false;
        random_view(1.0, 5.0, now);
        if (kind == 3)
            for (i = 0; i < 12; ++i) now[i] *= 1e25f;
        memcpy(f.view.view, now, sizeof now);
        if (!same_bits(predicted_view(&f), now, sizeof now)) fail_msg("singular view %d moved the next", kind);
    }
    stop(&f);
}

static void test_next_view_is_used(void** state) {
    fixture f;
    (void)state;
    start_predicting(&f);
    random_state = 9u;
    f.view.has_next = true;
    random_view(1.0, 5.0, f.view.next_view);
    assert_memory_equal(predicted_view(&f), f.view.next_view, sizeof f.view.next_view); /* on the first frame, too */
    random_view(1.0, 5.0, f.view.view);
    random_view(1.0, 5.0, f.view.next_view);
    assert_memory_equal(predicted_view(&f), f.view.next_view, sizeof f.view.next_view);
    f.view.next_view[3] = from_bits(0x7fc00000u);
    f.draw_count = 0;
    assert_int_equal(dgb_build(&f.context, &f.view, &f.params, on_draw, &f), DGB_INVALID);
    assert_int_equal(f.log_item, DGB_LOG_MATRIX);
    assert_int_equal(f.draw_count, 0);
    stop(&f);
}

/* >> DELAY */

/* The number of the frame whose view is drawn: the views are told apart by their translation. */
static int frame_drawn(fixture* f, int submitted) {
    default_view(&f->view);
    f->view.view[12] = (float)submitted;
    f->draw_count = 0;
    build(f);
    record_clear(&f->r);
    return (int)f->draws[0].view[12];
}

static void test_delay_lags_by_one(void** state) {
    int layers;
    (void)state;
    for (layers = 1; layers <= 3; ++layers) {
        fixture f;
        configure(&f, constructions[11], layers, 0);
        init(&f);
        assert_int_equal(frame_drawn(&f, 0), 0); /* there is none before it */
        assert_int_equal(frame_drawn(&f, 1), 0);
        assert_int_equal(frame_drawn(&f, 2), 1);
        assert_int_equal(frame_drawn(&f, 3), 2);
        assert_true(f.draws[0].pose == -1 && f.draws[0].previous_view[12] == 1.0f);
        f.draw_count = 0;
        default_view(&f.view);
        f.view.view[12] = 4.0f;
        f.view.cut = true;
        build(&f); /* at once: what was before the cut is never shown */
        assert_true(f.draws[0].view[12] == 4.0f && f.draws[0].pose == 0 && f.draws[0].oracle == DGB_ORACLE_PEEL);
        assert_true(f.draws[0].previous_view[12] == 4.0f);
        assert_int_equal(frame_drawn(&f, 5), 4);
        assert_int_equal(frame_drawn(&f, 6), 5);
        assert_int_equal(dgb_resize(&f.context, 32, 32), DGB_OK);
        assert_int_equal(frame_drawn(&f, 7), 7);
        assert_int_equal(frame_drawn(&f, 8), 7);
        assert_int_equal(frame_drawn(&f, 9), 8);
        if (layers > 1) { /* the prediction is not late */
            const dgb_draw* last = &f.draws[f.draw_count - 1];
            assert_true(last->depth_only && last->pose == 0 && last->view[12] == 9.0f);
            assert_true(last->previous_view[12] == 8.0f);
        }
        stop(&f);
    }
}

/* The shading sees the camera of the layers, not the one submitted. */
static void test_delay_shades_what_it_drew(void** state) {
    dgb_view first;
    dgb_pose pose;
    dgb_camera camera;
    fixture f;
    const dgb_pack_uniforms* u;
    (void)state;
    configure(&f, constructions[12], 2, BOTH);
    f.desc.world_normals = true;
    init(&f);
    random_state = 21u;
    random_frame(&f.view, false);
    build(&f);
    random_frame(&f.view, false);
    first = f.view;
    build(&f);
    random_frame(&f.view, false);
    f.draw_count = 0;
    build(&f);
    record_clear(&f.r);
    shade(&f);
    u = &record_uniforms_of(&f.r, DGB_PASS_PACK, 0)->u.pack;
    f.view = first;
    pose = pose_of(&f);
    camera = camera_of(&f, &pose);
    assert_memory_equal(&u->camera, &camera, sizeof camera);
    assert_memory_equal(&record_uniforms_of(&f.r, DGB_PASS_AO, 0)->u.ao.camera, &camera, sizeof camera);
    assert_memory_equal(&record_uniforms_of(&f.r, DGB_PASS_GATHER, 0)->u.gather.camera, &camera, sizeof camera);
    assert_true(u->rotation[1][2] == first.view[6] && u->rotation[2][0] == first.view[8]);
    assert_memory_equal(f.draws[0].view, first.view, sizeof first.view);
    stop(&f);
}

/* A frame that is refused leaves no trace in those after it. */
static void test_refused_frame_is_no_frame(void** state) {
    size_t i;
    (void)state;
    for (i = 0; i < CONSTRUCTION_COUNT; ++i) {
        dgb_view good;
        fixture f;
        model m;
        int frame;
        configure(&f, constructions[i], 3, 0);
        init(&f);
        memset(&m, 0, sizeof m);
        m.f = &f;
        m.oracle = constructions[i].oracle;
        m.emission = constructions[i].emission;
        m.layers = 3;
        random_state = 33u;
        for (frame = 0; frame < 5; ++frame) {
            random_frame(&f.view, false);
            good = f.view;
            f.view.projection[5] = frame % 2 ? 0.0f : from_bits(0x7f800000u);
            f.view.cut = true;
            assert_int_equal(dgb_build(&f.context, &f.view, &f.params, on_draw, &f), DGB_INVALID);
            f.view = good;
            run_and_check(&m);
        }
        stop(&f);
    }
}

/* >> matrices, cuts and textures */

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

/* With a prediction, depth stays where it is, and what was predicted for the frame becomes its oracle. */
static void test_prediction_and_oracle_change_places(void** state) {
    int i;
    (void)state;
    for (i = 8; i < PREDICTING_END; ++i) {
        fixture f;
        dgb_texture depth, oracle, predicted;
        int frame, draw;
        configure(&f, constructions[i], 3, 0);
        init(&f);
        depth = dgb_get_texture(&f.context, DGB_DEPTH);
        oracle = dgb_get_texture(&f.context, DGB_ORACLE);
        predicted = dgb_get_texture(&f.context, DGB_PREDICTED);
        assert_true(depth.id && oracle.id && predicted.id && oracle.id != predicted.id);
        for (frame = 0; frame < 4; ++frame) {
            const dgb_texture was = predicted;
            f.draw_count = 0;
            f.view.cut = frame == 2;
            build(&f);
            predicted = oracle, oracle = was;
            assert_true(dgb_get_texture(&f.context, DGB_DEPTH).id == depth.id);
            assert_true(dgb_get_texture(&f.context, DGB_ORACLE).id == oracle.id);
            assert_true(dgb_get_texture(&f.context, DGB_PREDICTED).id == predicted.id);
            for (draw = 0; draw < f.draw_count; ++draw)
                assert_true(f.passes[draw].depth.texture.id == (f.draws[draw].depth_only ? predicted : depth).id);
        }
        stop(&f);
    }
}

/* What a pass writes: one layer, all layers, or (images) the first and by itself the others; a prediction has no colour. */
static void test_targets_of_each_pass(void** state) {
    int i, layers, frame;
    (void)state;
    for (i = 0; i < CONSTRUCTION_COUNT; ++i)
        for (layers = 2; layers <= 4; ++layers) {
            fixture f;
            int draw, color;
            configure(&f, constructions[i], layers, 0);
            f.desc.targets = DGB_TARGET_NORMAL | DGB_TARGET_VELOCITY;
            init(&f);
            for (frame = 0; frame < 3; ++frame) {
                f.draw_count = 0;
                build(&f);
                for (draw = 0; draw < f.draw_count; ++draw) {
                    const dgb_pass* pass = &f.passes[draw];
                    const dgb_draw* d = &f.draws[draw];
                    const bool image = d->emission == DGB_EMISSION_IMAGE && d->layer_count > 1;
                    const int layer = d->layer_count > 1 && !image ? -1 : d->first_layer;
                    assert_int_equal(pass->color_count, d->depth_only ? 0 : 2);
                    for (color = 0; color < pass->color_count; ++color) {
                        const dgb_slot slot = color ? DGB_VELOCITY : DGB_NORMAL;
                        assert_true(pass->colors[color].texture.id == dgb_get_texture(&f.context, slot).id);
                        assert_true(pass->colors[color].layer == layer && pass->colors[color].level == 0);
                    }
                    assert_true(pass->depth.layer == layer && pass->clear && pass->clear_depth == 1.0f);
                    assert_true(pass->emission == d->emission);
                    assert_true(pass->key.id == (image ? dgb_get_texture(&f.context, DGB_KEY).id : 0));
                    assert_int_equal(pass->key_layers, image ? d->layer_count - 1 : 0);
                }
            }
            stop(&f);
        }
}

/* Deeper layers fill 1 / divisor of their images, to the fraction of a pixel; the first layer fills all of its own. */
static void test_divided_viewports(void** state) {
    static const dgb_emission emissions[] = {DGB_EMISSION_SEPARATE, DGB_EMISSION_VERTEX, DGB_EMISSION_GEOMETRY,
                                             DGB_EMISSION_INSTANCED_GEOMETRY};
    int oracle, i, divisor, frame, draw;
    (void)state;
    for (oracle = DGB_ORACLE_PREVIOUS; oracle < DGB_ORACLE_COUNT; ++oracle)
        for (i = 0; i < 4; ++i)
            for (divisor = 1; divisor <= 4; divisor *= 2) {
                fixture f;
                construction c;
                c.oracle = (dgb_oracle)oracle;
                c.emission = emissions[i];
                configure(&f, c, 3, 0);
                f.desc.width = 63; /* 79 with the guard band */
                f.desc.divisor = divisor;
                init(&f);
                for (frame = 0; frame < 3; ++frame) {
                    f.draw_count = 0;
                    record_clear(&f.r);
                    build(&f);
                    for (draw = 0; draw < f.draw_count; ++draw) {
                        const dgb_pass* pass = &f.passes[draw];
                        const float deep = divisor == 4 ? 0.25f : divisor == 2 ? 0.5f : 1.0f;
                        const float scale = pass->depth.layer > 0 ? deep : 1.0f;
                        assert_true(pass->x == 0 && pass->y == 0);
                        assert_true(pass->width == 79.0f * scale && pass->height == 64.0f * scale);
                        assert_true(pass->deep_width == 79.0f * deep);
                        assert_true(pass->deep_height == 64.0f * deep);
                    }
                }
                stop(&f);
            }
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

/* A peel behind layer 0, by no separation, of the pose and with the camera of the layers, into a texture of its own. */
static void test_back_faces(void** state) {
    size_t i;
    (void)state;
    for (i = 0; i < CONSTRUCTION_COUNT; ++i) {
        const dgb_draw_uniforms *first, *back;
        const dgb_draw *layers, *draw;
        fixture f;
        int frame, k;
        configure(&f, constructions[i], 3, DGB_EFFECT_REFLECT);
        f.desc.thickness = DGB_THICKNESS_BACK_FACES;
        f.params.separation = 0.25f;
        init(&f);
        for (frame = 0; frame < 3; ++frame) {
            record_clear(&f.r);
            f.draw_count = 0;
            f.view.view[12] = (float)frame;
            build(&f);
            for (k = 0; k < f.draw_count && !f.draws[k].back_faces; ++k) continue;
            assert_true(k > 0 && k < f.draw_count);
            layers = &f.draws[0], draw = &f.draws[k];
            assert_true(draw->depth_only && draw->first_layer == 1 && draw->layer_count == 1 && draw->instances == 1);
            assert_true(draw->oracle == DGB_ORACLE_PEEL && draw->pose == layers->pose);
            assert_memory_equal(draw->view, layers->view, sizeof draw->view);
            assert_memory_equal(draw->projection, layers->projection, sizeof draw->projection);
            assert_int_equal(f.passes[k].id, DGB_PASS_BACK);
            assert_true(f.passes[k].depth.texture.id == dgb_get_texture(&f.context, DGB_BACK).id);
            assert_true(f.passes[k].depth.layer == 0 && f.passes[k].color_count == 0 && !f.passes[k].key.id);
            first = &record_uniforms_of(&f.r, DGB_PASS_LAYERS, 0)->u.draw;
            back = &record_uniforms_of(&f.r, DGB_PASS_BACK, 0)->u.draw;
            assert_memory_equal(&back->camera, &first->camera, sizeof back->camera);
            assert_memory_equal(&back->previous, &back->camera, sizeof back->camera);
            assert_true(first->size[2] == 0.25f && back->size[2] == 0.0f && back->layer[0] == 1);
            for (++k; k < f.draw_count; ++k) assert_false(f.draws[k].back_faces);
            shade(&f);
        }
        stop(&f);
    }
}

static void test_bitmask_uniforms(void** state) {
    const dgb_bitmask_uniforms *ao, *light;
    const dgb_tiles_uniforms* tiles;
    fixture f;
    int i;
    (void)state;
    start(&f);
    f.desc.effects = DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY;
    for (i = 0; i < 9; ++i) f.view.view[4 * (i % 3) + i / 3] = (float)(i + 1); /* no two alike */
    f.desc.estimator = DGB_ESTIMATOR_BITMASK;
    f.params.ao_radius = 2.0f;
    f.params.ao_samples = 37; /* two slices, four sides: 9 steps each */
    f.params.ao_min_level = 1;
    f.params.ao_intensity = 1.5f;
    f.params.radius = 3.0f;
    f.params.samples = 3; /* fewer than sides: one step each */
    f.params.min_level = 2;
    f.params.slices = 2;
    f.params.thickness = 0.125f;
    init(&f);
    build(&f);
    shade(&f);
    ao = &record_uniforms_of(&f.r, DGB_PASS_AO, 0)->u.bitmask;
    light = &record_uniforms_of(&f.r, DGB_PASS_GATHER, 0)->u.bitmask;
    tiles = &record_uniforms_of(&f.r, DGB_PASS_TILES, 0)->u.tiles;
    assert_memory_equal(&ao->camera, &f.context.camera, sizeof ao->camera);
    assert_memory_equal(&light->camera, &f.context.camera, sizeof light->camera);
    assert_true(ao->size[0] == 80 && ao->size[1] == 64 && ao->size[2] == 9 && light->size[2] == 1);
    assert_true(ao->level[0] == DGB_AO_LOG2_Q && ao->level[1] == 1 && ao->level[2] == 5);
    assert_true(light->level[0] == DGB_GATHER_LOG2_Q && light->level[1] == 2 && light->level[2] == 5);
    assert_true(ao->radius[0] == 2.0f && ao->radius[1] == 4.0f && ao->radius[2] == 0.125f);
    assert_true(light->radius[0] == 3.0f && light->radius[1] == 9.0f && light->radius[2] == 0.125f);
    assert_true(fabsf(ao->radius[3] - sqrtf(80.0f * 80.0f + 64.0f * 64.0f)) < 1e-4f);
    assert_true(ao->scale[0] == 2.0f && ao->scale[1] == 0.5f && ao->scale[2] == 1.5f && ao->scale[3] == 1.0f);
    for (i = 0; i < 9; ++i) assert_true(ao->world[i / 3][i % 3] == f.view.view[4 * (i % 3) + i / 3]); /* turned back */
    /* what is behind a surface may reach farther into the radius than the surface itself */
    assert_true(tiles->radius[0] == 2.125f && tiles->radius[1] == 3.125f);
    stop(&f);
}

/* As many steps at once as a cell of the coarsest ranges holds, and a cell that so many pixels fit into. */
static void test_skip_uniforms(void** state) {
    static const int sides[][2] = {{1, 1}, {7, 5}, {64, 48}, {600, 3}};
    size_t i;
    int stride;
    (void)state;
    for (i = 0; i < sizeof sides / sizeof sides[0]; ++i) {
        fixture f;
        configure(&f, constructions[6], 2, DGB_EFFECT_REFLECT);
        f.desc.tracer = DGB_TRACER_HIERARCHICAL;
        f.desc.width = sides[i][0], f.desc.height = sides[i][1], f.desc.guard_band = 0;
        init(&f);
        build(&f);
        for (stride = 1; stride <= 64; ++stride) {
            const int32_t* skip;
            int coarsest = 4, k;
            f.params.reflect_stride = stride;
            for (k = 1; k < DGB_MAX_LEVELS && 2 * coarsest <= (sides[i][0] > sides[i][1] ? sides[i][0] : sides[i][1]);
                 ++k)
                coarsest *= 2;
            record_clear(&f.r);
            shade(&f);
            skip = record_uniforms_of(&f.r, DGB_PASS_REFLECT, 0)->u.reflect.skip;
            assert_in_range(skip[1], 0, 6);
            assert_true(1 << skip[1] >= stride && 1 << skip[1] < 2 * stride);
            assert_true(ldexp(1.0, skip[0] + skip[1]) == coarsest);
        }
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
    if (f.r.pass.x != inset || f.r.pass.y != inset || f.r.pass.width != (float)(64 + 2 * (guard - inset)) ||
        f.r.pass.height != (float)(48 + 2 * (guard - inset)))
        fail_msg("guard %d, fraction %g: viewport %d %d %g %g", guard, (double)fraction, f.r.pass.x, f.r.pass.y,
                 (double)f.r.pass.width, (double)f.r.pass.height);
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

/* >> last frame in the uniforms */

static const dgb_reprojection* past_of(const fixture* f, dgb_pass_id pass) {
    const record_uniforms* u = record_uniforms_of(&f->r, pass, 0);
    return pass == DGB_PASS_PACK ? &u->u.pack.past : &u->u.temporal.past;
}

/* Builds and shades; all of the uniforms before are forgotten. */
static void run_frame(fixture* f) {
    record_clear(&f->r);
    f->draw_count = 0;
    build(f);
    shade(f);
}

static bool is_identity(const dgb_reprojection* r) {
    int row, column;
    for (row = 0; row < 3; ++row)
        for (column = 0; column < 4; ++column)
            if (r->to_last[row][column] != (row == column ? 1.0f : 0.0f)) return false;
    return true;
}

/* Whether pack and temporal may look at last frame. */
static void check_usable(const fixture* f, bool pack, bool temporal, const char* what) {
    const float a = past_of(f, DGB_PASS_PACK)->tolerance[2], b = past_of(f, DGB_PASS_TEMPORAL)->tolerance[2];
    if (a != (pack ? 1.0f : 0.0f)) fail_msg("%s: pack may%s look at last frame", what, pack ? " not" : "");
    if (b != (temporal ? 1.0f : 0.0f)) fail_msg("%s: temporal may%s look at last frame", what, temporal ? " not" : "");
}

static void start_history(fixture* f) {
    start(f);
    f->desc.effects = ALL_EFFECTS;
}

static void test_history_is_usable(void** state) {
    fixture f;
    (void)state;
    start_history(&f);
    init(&f);
    run_frame(&f);
    check_usable(&f, false, false, "first frame");
    assert_true(is_identity(past_of(&f, DGB_PASS_PACK)));
    run_frame(&f);
    check_usable(&f, true, true, "second frame");
    f.view.cut = true;
    run_frame(&f);
    check_usable(&f, false, false, "cut");
    f.view.cut = false;
    run_frame(&f);
    check_usable(&f, true, true, "after the cut");
    build(&f);
    run_frame(&f);
    check_usable(&f, false, false, "two builds");
    run_frame(&f);
    check_usable(&f, true, true, "after two builds");
    f.params.radius *= 2.0f;
    run_frame(&f);
    check_usable(&f, true, false, "another radius"); /* what fell on a surface is still there to bounce */
    run_frame(&f);
    check_usable(&f, true, true, "after another radius");
    f.view.cut = true;
    build(&f);
    f.view.cut = false;
    record_clear(&f.r);
    shade(&f);
    check_usable(&f, false, false, "cut, and shaded later");
    assert_int_equal(dgb_resize(&f.context, 32, 24), DGB_OK);
    run_frame(&f);
    check_usable(&f, false, false, "resize");
    assert_int_equal(dgb_resize(&f.context, 32, 24), DGB_OK);
    run_frame(&f);
    check_usable(&f, true, true, "no resize");
    stop(&f);
}

/* A refused call is no frame. */
static void test_refused_calls_leave_history(void** state) {
    fixture f;
    uint32_t frame;
    (void)state;
    start_history(&f);
    init(&f);
    run_frame(&f);
    frame = f.context.frame;
    f.params.history_weight = 1.0f;
    assert_int_equal(dgb_shade(&f.context, &f.params), DGB_INVALID);
    assert_int_equal(dgb_build(&f.context, &f.view, &f.params, on_draw, &f), DGB_INVALID);
    f.params.history_weight = 0.85f;
    assert_int_equal(f.context.frame, frame);
    run_frame(&f);
    check_usable(&f, true, true, "after refusals");
    assert_int_equal(f.context.frame, frame + 1);
    stop(&f);
}

/* Tolerances, last frame's camera and rectangle, and whether anything moved. */
static void test_reprojection_uniforms(void** state) {
    static const dgb_pass_id passes[] = {DGB_PASS_PACK, DGB_PASS_TEMPORAL};
    fixture f;
    dgb_camera camera;
    int i, again;
    (void)state;
    start_history(&f);
    f.params.history_tolerance = 0.25f, f.params.history_floor = 0.125f;
    f.params.guard_fraction = 0.5f;
    init(&f);
    run_frame(&f);
    for (again = 0; again < 2; ++again) {
        camera = f.context.camera;
        f.params.guard_fraction = again ? 0.5f : 1.0f; /* this frame's; last frame's was the other */
        f.view.jitter[0] = again ? 0.25f : -0.25f;
        f.view.projection[0] = again ? 0.75f : 0.8f;
        run_frame(&f);
        for (i = 0; i < 2; ++i) {
            const dgb_reprojection* r = past_of(&f, passes[i]);
            const int inset = again ? 0 : 4;
            assert_true(is_identity(r)); /* the view is the same, to the last bit */
            assert_memory_equal(&r->last, &camera, sizeof camera);
            assert_memory_not_equal(&r->last, &f.context.camera, sizeof camera);
            assert_true(r->tolerance[0] == 0.25f && r->tolerance[1] == 0.125f && r->tolerance[3] == 1.0f);
            assert_true(r->rect[0] == inset && r->rect[1] == inset && r->rect[2] == 79 - inset &&
                        r->rect[3] == 63 - inset);
        }
    }
    random_state = 5u;
    random_view(1.0, 10.0, f.view.view);
    run_frame(&f);
    assert_false(is_identity(past_of(&f, DGB_PASS_TEMPORAL)));
    record_clear(&f.r);
    shade(&f); /* once more: nothing has moved since */
    for (i = 0; i < 2; ++i) {
        const dgb_reprojection* r = past_of(&f, passes[i]);
        assert_true(r->tolerance[2] == 1.0f && r->tolerance[3] == 0.0f && is_identity(r));
        assert_memory_equal(&r->last, &f.context.camera, sizeof camera);
    }
    run_frame(&f);
    assert_true(past_of(&f, DGB_PASS_TEMPORAL)->tolerance[3] == 1.0f);
    stop(&f);
}

/* to_last = last now^-1 in double; each entry is rounded once. A view 1000 m from the origin loses nothing. */
static void check_to_last(const float now[16], const float last[16], const dgb_reprojection* r) {
    double a[16], b[16], inverse[16], product[16], size[16];
    int i, row, column;
    for (i = 0; i < 16; ++i) a[i] = (double)now[i], b[i] = (double)last[i];
    invert_in_double(a, inverse);
    multiply_in_double(b, inverse, product, size);
    for (row = 0; row < 3; ++row)
        for (column = 0; column < 4; ++column) {
            const double expected = product[column * 4 + row], is = (double)r->to_last[row][column];
            if (!(fabs(is - expected) <= 6e-8 * fabs(expected) + 1e-13 * size[column * 4 + row]))
                fail_msg("entry %d, %d: %.9g, not %.9g", row, column, is, expected);
        }
}

static void test_reprojection_matrix(void** state) {
    int frame, delayed;
    (void)state;
    random_state = 11u;
    for (delayed = 0; delayed < 2; ++delayed) {
        fixture f;
        float views[3][16]; /* submitted: two frames ago, one, now */
        start_history(&f);
        f.desc.oracle = delayed ? DGB_ORACLE_DELAY : DGB_ORACLE_REPROJECT;
        init(&f);
        memcpy(views[1], f.view.view, sizeof views[1]);
        for (frame = 0; frame < 200; ++frame) {
            random_view(frame % 3 ? 1.0 : 1.5, frame % 5 ? 10.0 : 1000.0, f.view.view);
            memcpy(views[0], views[1], sizeof views[0]);
            memcpy(views[1], frame ? views[2] : f.view.view, sizeof views[1]);
            memcpy(views[2], f.view.view, sizeof views[2]);
            run_frame(&f);
            if (frame < 2) continue; /* DELAY shows the first frame twice */
            check_to_last(views[delayed ? 1 : 2], views[delayed ? 0 : 1], past_of(&f, DGB_PASS_PACK));
            check_to_last(views[delayed ? 1 : 2], views[delayed ? 0 : 1], past_of(&f, DGB_PASS_TEMPORAL));
        }
        stop(&f);
    }
}

/* The engine's own layers are of the view that comes with them. */
static void test_reprojection_of_given_layers(void** state) {
    float last[16];
    dgb_layers layers;
    dgb_camera camera;
    fixture f;
    int frame;
    (void)state;
    start_history(&f);
    f.desc.source = DGB_SOURCE_ENGINE;
    init(&f);
    layers = engine_layers(&f);
    random_state = 13u;
    for (frame = 0; frame < 20; ++frame) {
        memcpy(last, f.view.view, sizeof last);
        memcpy(&camera, &f.context.camera, sizeof camera);
        random_view(1.0, 10.0, f.view.view);
        f.view.jitter[0] = 0.01f * (float)frame;
        record_clear(&f.r);
        set_layers(&f, &layers);
        shade(&f);
        if (frame == 0) continue;
        check_to_last(f.view.view, last, past_of(&f, DGB_PASS_PACK));
        check_to_last(f.view.view, last, past_of(&f, DGB_PASS_TEMPORAL));
        assert_memory_equal(&past_of(&f, DGB_PASS_TEMPORAL)->last, &camera, sizeof camera);
        assert_memory_not_equal(&f.context.camera, &camera, sizeof camera);
    }
    stop(&f);
}

/* A view that flattens the world has no way back: no NaN comes of it. */
static void test_reprojection_from_a_singular_view(void** state) {
    static const float scales[] = {1.0f, 0.0f, 1e-38f, 1e20f, 1e-20f}; /* between the last two lies 1e40 */
    fixture f;
    int frame, row, column;
    (void)state;
    start_history(&f);
    init(&f);
    for (frame = 0; frame < 5; ++frame) {
        f.view.view[0] = scales[frame];
        run_frame(&f);
        for (row = 0; row < 3; ++row)
            for (column = 0; column < 4; ++column) {
                const float x = past_of(&f, DGB_PASS_TEMPORAL)->to_last[row][column];
                if (!isfinite(x)) fail_msg("frame %d: %g", frame, (double)x);
            }
    }
    stop(&f);
}

static void test_bounce_and_history_uniforms(void** state) {
    const dgb_pack_uniforms* u;
    fixture f;
    (void)state;
    start_history(&f);
    f.params.bounce_damping = 0.5f, f.params.boost_unsaturated = 0.25f, f.params.boost_saturated = 2.0f;
    f.params.history_weight = 0.75f;
    init(&f);
    run_frame(&f);
    u = &record_uniforms_of(&f.r, DGB_PASS_PACK, 0)->u.pack;
    assert_true(u->bounce[0] == 0.5f && u->bounce[1] == 0.25f && u->bounce[2] == 2.0f);
    assert_true(record_uniforms_of(&f.r, DGB_PASS_TEMPORAL, 0)->u.temporal.weight[0] == 0.75f);
    assert_memory_equal(&record_uniforms_of(&f.r, DGB_PASS_TEMPORAL, 0)->u.temporal.camera, &f.context.camera,
                        sizeof f.context.camera);
    stop(&f);
}

/* Every frame turns the taps elsewhere where frames are averaged; else always the same way. */
static void test_frames_turn_the_taps(void** state) {
    int kind, frame;
    (void)state;
    for (kind = 0; kind < 3; ++kind) {
        fixture f;
        start_history(&f);
        if (kind == 1) f.desc.effects = BOTH | DGB_EFFECT_BOUNCES;
        if (kind == 2) f.params.history_weight = 0.0f;
        init(&f);
        for (frame = 0; frame < 4; ++frame) {
            run_frame(&f);
            assert_int_equal(record_uniforms_of(&f.r, DGB_PASS_AO, 0)->u.ao.size[3], kind ? 0 : frame);
            assert_int_equal(record_uniforms_of(&f.r, DGB_PASS_GATHER, 0)->u.gather.size[3], kind ? 0 : frame);
        }
        f.context.frame = 0xfffffeu; /* the number that the shaders get stays exact */
        run_frame(&f);
        run_frame(&f);
        run_frame(&f);
        assert_int_equal(record_uniforms_of(&f.r, DGB_PASS_AO, 0)->u.ao.size[3], 0);
        stop(&f);
    }
}

/* Z and last z, averages and last averages change places in dgb_shade, and in nothing else. */
static void test_history_changes_places(void** state) {
    static const dgb_slot turns[][2] = {{DGB_Z, DGB_LAST_Z},
                                        {DGB_FRAMES, DGB_LAST_FRAMES},
                                        {DGB_IRRADIANCE_MEAN, DGB_LAST_IRRADIANCE},
                                        {DGB_IRRADIANCE1_MEAN, DGB_LAST_IRRADIANCE1}};
    fixture f;
    int i, frame;
    (void)state;
    start_history(&f);
    init(&f);
    for (frame = 0; frame < 3; ++frame) {
        dgb_texture before[4][2];
        for (i = 0; i < 8; ++i) before[i / 2][i % 2] = dgb_get_texture(&f.context, turns[i / 2][i % 2]);
        f.draw_count = 0;
        build(&f);
        for (i = 0; i < 8; ++i)
            assert_int_equal(dgb_get_texture(&f.context, turns[i / 2][i % 2]).id, before[i / 2][i % 2].id);
        shade(&f);
        for (i = 0; i < 8; ++i)
            assert_int_equal(dgb_get_texture(&f.context, turns[i / 2][i % 2]).id, before[i / 2][1 - i % 2].id);
        record_clear(&f.r);
    }
    stop(&f);
}

/* Another preset every frame: nothing is created or destroyed, and each call begins and ends once. */
static void test_presets_create_nothing(void** state) {
    fixture f;
    int frame, creates, alive, begins;
    (void)state;
    start_history(&f);
    init(&f);
    creates = f.r.creates, alive = record_alive(&f.r), begins = f.r.begins;
    for (frame = 0; frame < 12; ++frame) {
        f.params = dgb_preset((dgb_preset_id)(frame % DGB_PRESET_COUNT));
        run_frame(&f);
        check_usable(&f, frame > 0, frame > 0, "preset");
    }
    assert_int_equal(f.r.creates, creates);
    assert_int_equal(record_alive(&f.r), alive);
    assert_int_equal(f.r.begins, begins + 24);
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

/* The device fails in pass n, 0: at the end, while it builds or shades the second frame. */
static void start_failing(fixture* f, int n, dgb_result failure) {
    start(f);
    f->desc.effects = ALL_EFFECTS;
    f->desc.oracle = DGB_ORACLE_PREDICT;
    init(f);
    build(f);
    shade(f);
    record_clear(&f->r);
    f->r.passes = 0;
    f->r.fail_pass_at = n;
    f->r.fail_with = failure;
    if (!n) f->r.end_with = failure;
}

/* It says so once, and runs nothing after the pass that failed. */
static void check_failed(fixture* f, int n, dgb_result failure, dgb_result result) {
    if (result != failure) fail_msg("pass %d: %s", n, dgb_result_name(result));
    if (n) assert_int_equal(f->r.passes, n);
    assert_int_equal(f->log_count, 1);
    assert_int_equal(f->log_result, failure);
    assert_int_equal(f->log_item, DGB_LOG_PASS);
    assert_int_equal(f->r.begins, f->r.ends);
    f->r.fail_pass_at = 0;
    f->r.end_with = DGB_OK;
    f->log_count = 0;
    record_clear(&f->r);
}

/* True when there was no pass n to fail. */
static bool check_failed_build(int n, dgb_result failure) {
    fixture f;
    dgb_result result;
    start_failing(&f, n, failure);
    result = dgb_build(&f.context, &f.view, &f.params, on_draw, &f);
    if (n > f.r.passes) return assert_int_equal(result, DGB_OK), stop(&f), true;
    check_failed(&f, n, failure, result);
    assert_int_equal(dgb_shade(&f.context, &f.params), DGB_INVALID);
    assert_int_equal(f.log_item, DGB_LOG_NO_LAYERS);
    assert_int_equal(oracle_of_next_build(&f), DGB_ORACLE_PEEL); /* afresh */
    assert_false(f.context.has_history);
    shade(&f);
    stop(&f);
    return false;
}

static bool check_failed_shade(int n, dgb_result failure) {
    fixture f;
    dgb_result result;
    start_failing(&f, n, failure);
    f.r.fail_pass_at = 0;
    f.r.end_with = DGB_OK;
    build(&f);
    assert_true(f.context.has_history);
    f.r.passes = 0;
    f.r.fail_pass_at = n;
    if (!n) f.r.end_with = failure;
    result = dgb_shade(&f.context, &f.params);
    if (n > f.r.passes) return assert_int_equal(result, DGB_OK), stop(&f), true;
    check_failed(&f, n, failure, result);
    assert_false(f.context.has_history);
    shade(&f); /* the layers are there still */
    assert_true(f.context.has_history);
    assert_int_equal(oracle_of_next_build(&f), DGB_ORACLE_PREDICT);
    stop(&f);
    return false;
}

static void test_failed_passes(void** state) {
    static const dgb_result results[] = {DGB_OUT_OF_MEMORY, DGB_DEVICE};
    size_t i;
    int n;
    (void)state;
    for (i = 0; i < 2; ++i) {
        for (n = 0; !check_failed_build(n, results[i]); ++n) {}
        assert_int_equal(n, 3); /* the end; the layers, the prediction; and no third */
        for (n = 0; !check_failed_shade(n, results[i]); ++n) {}
        assert_true(n > 10);
    }
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
    int layers, oracle, emission, source_divisor, good = 0;
    (void)state;
    for (source_divisor = 0; source_divisor < 8; ++source_divisor)
        for (layers = 0; layers <= 3; ++layers)
            for (oracle = 0; oracle < DGB_ORACLE_COUNT; ++oracle)
                for (emission = 0; emission < DGB_EMISSION_COUNT; ++emission) {
                    static const int divisors[] = {0, 1, 2, 4};
                    const int source = source_divisor & 1;
                    fixture f;
                    start(&f);
                    f.desc.divisor = divisors[source_divisor >> 1];
                    f.desc.source = (dgb_source)source;
                    f.desc.layers = layers;
                    f.desc.oracle = (dgb_oracle)oracle;
                    f.desc.emission = (dgb_emission)emission;
                    f.desc.effects = BOTH;
                    if (dgb_init(&f.context, &f.desc) == DGB_OK) {
                        ++good;
                        if (dgb_resize(&f.context, 32, 32) != DGB_OK)
                            fail_msg("source %d, layers %d, oracle %d, emission %d, divisor %d: %s", source, layers,
                                     oracle, emission, f.desc.divisor, dgb_log_item_name(f.log_item));
                        if (f.context.desc.divisor < 1) fail_msg("divisor %d", f.context.desc.divisor);
                    }
                    stop(&f);
                }
    assert_true(good > 300);
}

/* Programs stay through a resize, so no size may ask for others: not even one that has no MIP chain and no coarser range. */
static void test_programs_do_not_depend_on_the_size(void** state) {
    static const int sizes[][2] = {{71, 1}, {2, 2}, {64, 48}};
    fixture f;
    size_t i;
    (void)state;
    start(&f);
    f.desc.guard_band = 0;
    f.desc.effects = ALL_EFFECTS;
    f.desc.tracer = DGB_TRACER_HIERARCHICAL;
    init(&f);
    for (i = 0; i < sizeof sizes / sizeof sizes[0]; ++i) {
        dgb_plan before;
        memcpy(&before, &f.context.plan, sizeof before);
        assert_int_equal(dgb_resize(&f.context, sizes[i][0], sizes[i][1]), DGB_OK);
        assert_int_equal(f.context.plan.program_count, before.program_count);
        assert_true(same_bits(f.context.plan.programs, before.programs, sizeof before.programs));
        f.draw_count = 0;
        build(&f);
        shade(&f); /* the backend checks that each pass draws with a program of its own */
        record_clear(&f.r);
    }
    stop(&f);
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
    f.view.has_next = true;
    for (k = 0; k < 3; ++k)
        for (i = 0; i < 16; ++i) {
            memcpy(f.view.next_view, f.view.view, sizeof f.view.next_view);
            f.view.next_view[i] = from_bits(odd[k]);
            check_build_refused(&f, DGB_LOG_MATRIX, "next view");
        }
    f.view.has_next = false; /* then nobody reads it */
    build(&f);
    default_view(&f.view);
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
static void set_slices(dgb_params* p, float x) { p->slices = (int)x; }
static void set_thickness(dgb_params* p, float x) { p->thickness = x; }
static void set_bounce_damping(dgb_params* p, float x) { p->bounce_damping = x; }
static void set_boost_unsaturated(dgb_params* p, float x) { p->boost_unsaturated = x; }
static void set_boost_saturated(dgb_params* p, float x) { p->boost_saturated = x; }
static void set_history_weight(dgb_params* p, float x) { p->history_weight = x; }
static void set_history_tolerance(dgb_params* p, float x) { p->history_tolerance = x; }
static void set_history_floor(dgb_params* p, float x) { p->history_floor = x; }
static void set_history_clamp(dgb_params* p, float x) { p->history_clamp = x; }
static void set_sample_clamp(dgb_params* p, float x) { p->sample_clamp = x; }
static void set_filter_taps(dgb_params* p, float x) { p->filter_taps = (int)x; }
static void set_filter_step(dgb_params* p, float x) { p->filter_step = (int)x; }
static void set_normal_sharpness(dgb_params* p, float x) { p->normal_sharpness = x; }
static void set_plane_sharpness(dgb_params* p, float x) { p->plane_sharpness = x; }
static void set_reflect_distance(dgb_params* p, float x) { p->reflect_distance = x; }
static void set_reflect_thickness(dgb_params* p, float x) { p->reflect_thickness = x; }
static void set_reflect_steps(dgb_params* p, float x) { p->reflect_steps = (int)x; }
static void set_reflect_stride(dgb_params* p, float x) { p->reflect_stride = (int)x; }
static void set_reflect_border(dgb_params* p, float x) { p->reflect_border = x; }
static void set_glossy_taps(dgb_params* p, float x) { p->glossy_taps = (int)x; }
static void set_glossy_radius(dgb_params* p, float x) { p->glossy_radius = x; }

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
    {"slices", set_slices, DGB_LOG_BITMASK_PARAMS, false, {1, 8, 2, 5}, {0, 9, -1, 1e6f}},
    {"thickness", set_thickness, DGB_LOG_BITMASK_PARAMS, true, {0, 0.25f, 1, 1e6f}, {-0.001f, -1, -1e30f, 1e30f}},
    {"bounce_damping",
     set_bounce_damping,
     DGB_LOG_BOUNCE_PARAMS,
     true,
     {0, 0.5f, 1, 1e-6f},
     {-0.001f, 1.001f, 1e30f, -1}},
    {"boost_unsaturated",
     set_boost_unsaturated,
     DGB_LOG_BOUNCE_PARAMS,
     true,
     {0, 1, 3, 100},
     {-0.001f, -1, -1e30f, -1}},
    {"boost_saturated", set_boost_saturated, DGB_LOG_BOUNCE_PARAMS, true, {0, 1, 3, 100}, {-0.001f, -1, -1e30f, -1}},
    {"history_weight",
     set_history_weight,
     DGB_LOG_HISTORY_PARAMS,
     true,
     {0, 0.85f, 0.999f, 0.5f},
     {-0.001f, 0.9991f, 1, 1e30f}},
    {"history_tolerance",
     set_history_tolerance,
     DGB_LOG_HISTORY_PARAMS,
     true,
     {0, 0.005f, 1, 100},
     {-0.001f, -1, -1e30f, -1}},
    {"history_floor", set_history_floor, DGB_LOG_HISTORY_PARAMS, true, {0, 0.01f, 1, 1e6f}, {-0.001f, -1, -1e30f, -1}},
    {"history_clamp", set_history_clamp, DGB_LOG_HISTORY_PARAMS, true, {0, 1, 3, 1e30f}, {-0.001f, -1, -1e30f, -1}},
    {"sample_clamp", set_sample_clamp, DGB_LOG_HISTORY_PARAMS, true, {0, 0.5f, 8, 1e30f}, {-0.001f, -1, -1e30f, -1}},
    {"filter_taps", set_filter_taps, DGB_LOG_FILTER_PARAMS, false, {1, 25, 9, 11}, {0, 2, 27, -1}},
    {"filter_step", set_filter_step, DGB_LOG_FILTER_PARAMS, false, {1, 8, 2, 3}, {0, 9, -1, 1e6f}},
    {"normal_sharpness", set_normal_sharpness, DGB_LOG_FILTER_PARAMS, true, {0, 1, 4, 100}, {-0.001f, -1, -1e30f, -1}},
    {"plane_sharpness", set_plane_sharpness, DGB_LOG_FILTER_PARAMS, true, {0, 1, 8, 100}, {-0.001f, -1, -1e30f, -1}},
    {"reflect_distance",
     set_reflect_distance,
     DGB_LOG_REFLECT_PARAMS,
     true,
     {1e-15f, 1e14f, 30, 1},
     {0, -1, 1e-16f, 1e15f}},
    {"reflect_thickness",
     set_reflect_thickness,
     DGB_LOG_REFLECT_PARAMS,
     true,
     {1e-15f, 1e14f, 0.5f, 1},
     {0, -1, 1e-16f, 1e15f}},
    {"reflect_steps", set_reflect_steps, DGB_LOG_REFLECT_PARAMS, false, {1, 4096, 256, 2}, {0, 4097, -1, 1e6f}},
    {"reflect_stride", set_reflect_stride, DGB_LOG_REFLECT_PARAMS, false, {1, 64, 2, 3}, {0, 65, -1, 1e6f}},
    {"reflect_border",
     set_reflect_border,
     DGB_LOG_REFLECT_PARAMS,
     true,
     {0, 32, 1e6f, 0.5f},
     {-0.001f, -1, -1e30f, -1}},
    {"glossy_taps", set_glossy_taps, DGB_LOG_GLOSSY_PARAMS, false, {0, 32, 8, 1}, {-1, 33, -100, 1e6f}},
    {"glossy_radius", set_glossy_radius, DGB_LOG_GLOSSY_PARAMS, true, {0, 16, 1e6f, 0.5f}, {-0.001f, -1, -1e30f, -1}},
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
    f.desc.effects = ALL_EFFECTS;
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

static void configure_engine(fixture* f, int layers, uint32_t effects, dgb_normals normals) {
    start(f);
    f->desc.source = DGB_SOURCE_ENGINE;
    f->desc.layers = layers;
    f->desc.effects = effects;
    f->desc.normals = normals;
}

static void start_engine(fixture* f, int layers, uint32_t effects, dgb_normals normals) {
    configure_engine(f, layers, effects, normals);
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

/* Of depth, normal, radiance, albedo and velocity of both layers (bits 0 to 9), roughness (10) and back faces (11), one at a time
   is missing. */
static void check_inputs_for(dgb_thickness thickness, int layers, uint32_t effects, dgb_normals normals,
                             unsigned needed) {
    dgb_layers all;
    fixture f;
    unsigned missing;
    configure_engine(&f, layers, effects, normals);
    f.desc.thickness = thickness;
    init(&f);
    all = engine_layers(&f);
    for (missing = 0; missing < 12; ++missing) {
        dgb_layers given = all;
        dgb_texture* const kinds[5] = {given.depth, given.normal, given.radiance, given.albedo, given.velocity};
        char what[64];
        if (missing < 10) kinds[missing % 5][missing / 5].id = 0;
        if (missing == 10) given.roughness.id = 0;
        if (missing == 11) given.back.id = 0;
        snprintf(what, sizeof what, "effects %s, %d layers, without input %u", record_effect_names(effects), layers,
                 missing);
        check_input(&f, &given, !(needed >> missing & 1u), what);
    }
    stop(&f);
}

static void check_inputs(int layers, uint32_t effects, dgb_normals normals, unsigned needed) {
    check_inputs_for(DGB_THICKNESS_LAYERS, layers, effects, normals, needed);
}

static void test_inputs_that_are_needed(void** state) {
    enum { Z = 1, N = 2, B = 4, ALBEDO = 8, VELOCITY = 16, SECOND = 32, ROUGHNESS = 1024, BACK = 2048 };
    const uint32_t ao = DGB_EFFECT_AO, light = DGB_EFFECT_RADIOSITY, bounces = DGB_EFFECT_BOUNCES,
                   temporal = DGB_EFFECT_TEMPORAL;
    (void)state;
    check_inputs(1, 0, DGB_NORMALS_FROM_DEPTH, 0);
    check_inputs(1, ao, DGB_NORMALS_FROM_DEPTH, Z);
    check_inputs(1, ao, DGB_NORMALS_FLOAT, Z | N);
    check_inputs(1, light, DGB_NORMALS_FROM_DEPTH, Z | B);
    check_inputs(2, ao, DGB_NORMALS_OCT16, (Z | N) * (1 + SECOND));
    check_inputs(2, BOTH, DGB_NORMALS_UNORM, (Z | N | B) * (1 + SECOND));
    check_inputs(1, light | bounces, DGB_NORMALS_FROM_DEPTH, Z | B | ALBEDO | VELOCITY);
    check_inputs(2, light | bounces, DGB_NORMALS_FROM_DEPTH, (Z | B | ALBEDO | VELOCITY) * (1 + SECOND));
    check_inputs(1, ao | temporal, DGB_NORMALS_FROM_DEPTH, Z | VELOCITY);
    check_inputs(2, ao | temporal, DGB_NORMALS_FROM_DEPTH, Z * (1 + SECOND) | VELOCITY); /* the first layer's alone */
    check_inputs(2, BOTH | temporal, DGB_NORMALS_FLOAT, (Z | N | B) * (1 + SECOND) | VELOCITY);
    check_inputs(1, DGB_EFFECT_REFLECT, DGB_NORMALS_FROM_DEPTH, Z | B);
    check_inputs(2, DGB_EFFECT_REFLECT | ao, DGB_NORMALS_FLOAT, (Z | N | B) * (1 + SECOND));
    check_inputs(1, DGB_EFFECT_REFLECT | light, DGB_NORMALS_FROM_DEPTH, Z | B | ALBEDO);
    check_inputs(2, DGB_EFFECT_REFLECT | light, DGB_NORMALS_FROM_DEPTH, (Z | B | ALBEDO) * (1 + SECOND));
    check_inputs(1, DGB_EFFECT_REFLECT | DGB_EFFECT_GLOSSY, DGB_NORMALS_FROM_DEPTH, Z | B | ROUGHNESS);
    check_inputs(2, DGB_EFFECT_REFLECT | DGB_EFFECT_GLOSSY | temporal, DGB_NORMALS_FROM_DEPTH,
                 (Z | B) * (1 + SECOND) | VELOCITY | ROUGHNESS);
    check_inputs(2, ALL_EFFECTS & ~DGB_EFFECT_GLOSSY, DGB_NORMALS_FLOAT, 1023);
    check_inputs(2, ALL_EFFECTS, DGB_NORMALS_FLOAT, 2047);
    check_inputs_for(DGB_THICKNESS_BACK_FACES, 1, DGB_EFFECT_REFLECT, DGB_NORMALS_FROM_DEPTH, Z | B | BACK);
    check_inputs_for(DGB_THICKNESS_BACK_FACES, 1, ao, DGB_NORMALS_FROM_DEPTH, Z); /* the paper's knows no thickness */
    check_inputs_for(DGB_THICKNESS_BACK_FACES, 2, ALL_EFFECTS, DGB_NORMALS_FLOAT, 4095);
}

/* Layers of the engine's own are never built afresh: a cut and a resize drop the history all the same. */
static void test_history_of_engine_layers(void** state) {
    static const char script[] = "1.c.r.2."; /* 1, 2: layers set so often; c: cut; r: resize */
    static const bool usable[] = {false, true, false, true, false, true, false, true};
    fixture f;
    int i;
    (void)state;
    start_engine(&f, 2, ALL_EFFECTS, DGB_NORMALS_FLOAT);
    for (i = 0; script[i]; ++i) {
        dgb_layers layers;
        if (script[i] == 'r') {
            assert_int_equal(dgb_resize(&f.context, 40, 30), DGB_OK);
            f.desc.width = 40, f.desc.height = 30;
        }
        f.view.cut = script[i] == 'c';
        layers = engine_layers(&f);
        record_clear(&f.r);
        if (script[i] == '2') set_layers(&f, &layers);
        set_layers(&f, &layers);
        shade(&f);
        check_usable(&f, usable[i], usable[i], &script[i]);
    }
    stop(&f);
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
        cmocka_unit_test(test_every_submission),
        cmocka_unit_test(test_extrapolated_view),
        cmocka_unit_test(test_extrapolation_from_a_singular_view),
        cmocka_unit_test(test_next_view_is_used),
        cmocka_unit_test(test_delay_lags_by_one),
        cmocka_unit_test(test_delay_shades_what_it_drew),
        cmocka_unit_test(test_refused_frame_is_no_frame),
        cmocka_unit_test(test_prediction_and_oracle_change_places),
        cmocka_unit_test(test_targets_of_each_pass),
        cmocka_unit_test(test_divided_viewports),
        cmocka_unit_test(test_draw_is_told_the_matrices),
        cmocka_unit_test(test_cut_and_resize_peel_again),
        cmocka_unit_test(test_depth_and_oracle_change_places),
        cmocka_unit_test(test_layer_uniforms),
        cmocka_unit_test(test_distance_uniforms),
        cmocka_unit_test(test_pack_uniforms),
        cmocka_unit_test(test_ao_uniforms),
        cmocka_unit_test(test_gather_uniforms),
        cmocka_unit_test(test_back_faces),
        cmocka_unit_test(test_bitmask_uniforms),
        cmocka_unit_test(test_skip_uniforms),
        cmocka_unit_test(test_reconstruction_uniforms),
        cmocka_unit_test(test_shaded_rectangle),
        cmocka_unit_test(test_normal_test_picks_the_program),
        cmocka_unit_test(test_clip_and_direction_reach_the_backend),
        cmocka_unit_test(test_rotations_are_uploaded),
        cmocka_unit_test(test_history_is_usable),
        cmocka_unit_test(test_refused_calls_leave_history),
        cmocka_unit_test(test_reprojection_uniforms),
        cmocka_unit_test(test_reprojection_matrix),
        cmocka_unit_test(test_reprojection_of_given_layers),
        cmocka_unit_test(test_reprojection_from_a_singular_view),
        cmocka_unit_test(test_bounce_and_history_uniforms),
        cmocka_unit_test(test_frames_turn_the_taps),
        cmocka_unit_test(test_history_changes_places),
        cmocka_unit_test(test_presets_create_nothing),
        cmocka_unit_test(test_failed_init_leaves_nothing),
        cmocka_unit_test(test_failed_resize_keeps_the_old),
        cmocka_unit_test(test_failed_passes),
        cmocka_unit_test(test_refused_resize_keeps_the_old),
        cmocka_unit_test(test_resize_knows_the_device),
        cmocka_unit_test(test_resize_to_the_same_does_nothing),
        cmocka_unit_test(test_whatever_was_initialised_resizes),
        cmocka_unit_test(test_programs_do_not_depend_on_the_size),
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
        cmocka_unit_test(test_history_of_engine_layers),
        cmocka_unit_test(test_engine_textures_outlive_the_context),
        cmocka_unit_test(test_engine_textures_may_change),
        cmocka_unit_test(test_two_contexts),
        cmocka_unit_test(test_get_texture),
    };
    return cmocka_run_group_tests_name("trace", tests, NULL, NULL);
}
