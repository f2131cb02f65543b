/* The std140 blocks of the shaders and the C structs that are uploaded into them: the driver says where each
   member lies. */
#include "gl_fixture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

static fixture f;

typedef struct member { /* of a block: GLSL name, offset, and distance between elements of an array (0: none) */
    const char* name;
    size_t offset, stride;
} member;

#define CAMERA(prefix, type, field)                                    \
    {prefix ".linearise", offsetof(type, field.linearise), 0},         \
        {prefix ".position_z", offsetof(type, field.position_z), 0},   \
        {prefix ".position_1", offsetof(type, field.position_1), 0}, { \
        prefix ".footprint", offsetof(type, field.footprint), 0        \
    }
#define VALUE(name, type, field) \
    { name, offsetof(type, field), 0 }
#define ARRAY(name, type, field) \
    { name "[0]", offsetof(type, field), sizeof(float[4]) }

static const member draw_members[] = {CAMERA("dgb_draw_camera", dgb_draw_uniforms, camera),
                                      CAMERA("dgb_draw_previous", dgb_draw_uniforms, previous),
                                      VALUE("dgb_draw_distance", dgb_draw_uniforms, distance),
                                      VALUE("dgb_draw_previous_distance", dgb_draw_uniforms, previous_distance),
                                      VALUE("dgb_draw_size", dgb_draw_uniforms, size),
                                      VALUE("dgb_draw_layer", dgb_draw_uniforms, layer),
                                      VALUE("dgb_draw_flags", dgb_draw_uniforms, flags)};

static const member resolve_members[] = {VALUE("dgb_resolve_layer", dgb_resolve_uniforms, layer)};

#define PAST(prefix, type)                                                                 \
    CAMERA(prefix ".last", type, past.last), ARRAY(prefix ".to_last", type, past.to_last), \
        VALUE(prefix ".tolerance", type, past.tolerance), VALUE(prefix ".rect", type, past.rect)

static const member pack_members[] = {CAMERA("dgb_pack_camera", dgb_pack_uniforms, camera),
                                      ARRAY("dgb_pack_rotation", dgb_pack_uniforms, rotation),
                                      VALUE("dgb_pack_separation", dgb_pack_uniforms, separation),
                                      VALUE("dgb_pack_size", dgb_pack_uniforms, size),
                                      VALUE("dgb_pack_bounce", dgb_pack_uniforms, bounce),
                                      PAST("dgb_pack_past", dgb_pack_uniforms)};

static const member tiles_members[] = {CAMERA("dgb_tiles_camera", dgb_tiles_uniforms, camera),
                                       VALUE("dgb_tiles_radius", dgb_tiles_uniforms, radius)};

static const member ao_members[] = {
    CAMERA("dgb_ao_camera", dgb_ao_uniforms, camera), VALUE("dgb_ao_size", dgb_ao_uniforms, size),
    VALUE("dgb_ao_level", dgb_ao_uniforms, level),    VALUE("dgb_ao_radius", dgb_ao_uniforms, radius),
    VALUE("dgb_ao_scale", dgb_ao_uniforms, scale),    ARRAY("dgb_ao_taps", dgb_ao_uniforms, taps)};

static const member gather_members[] = {
    CAMERA("dgb_gather_camera", dgb_gather_uniforms, camera), VALUE("dgb_gather_size", dgb_gather_uniforms, size),
    VALUE("dgb_gather_level", dgb_gather_uniforms, level),    VALUE("dgb_gather_radius", dgb_gather_uniforms, radius),
    VALUE("dgb_gather_first", dgb_gather_uniforms, first),    ARRAY("dgb_gather_taps", dgb_gather_uniforms, taps)};

static const member bitmask_members[] = {CAMERA("dgb_bitmask_camera", dgb_bitmask_uniforms, camera),
                                         VALUE("dgb_bitmask_size", dgb_bitmask_uniforms, size),
                                         VALUE("dgb_bitmask_level", dgb_bitmask_uniforms, level),
                                         VALUE("dgb_bitmask_radius", dgb_bitmask_uniforms, radius),
                                         VALUE("dgb_bitmask_scale", dgb_bitmask_uniforms, scale),
                                         ARRAY("dgb_bitmask_world", dgb_bitmask_uniforms, world)};

static const member temporal_members[] = {CAMERA("dgb_temporal_camera", dgb_temporal_uniforms, camera),
                                          VALUE("dgb_temporal_weight", dgb_temporal_uniforms, weight),
                                          VALUE("dgb_temporal_present", dgb_temporal_uniforms, rect),
                                          PAST("dgb_temporal_past", dgb_temporal_uniforms)};

static const member reconstruct_members[] = {CAMERA("dgb_reconstruct_camera", dgb_reconstruct_uniforms, camera),
                                             VALUE("dgb_reconstruct_rect", dgb_reconstruct_uniforms, rect),
                                             VALUE("dgb_reconstruct_axis", dgb_reconstruct_uniforms, axis),
                                             VALUE("dgb_reconstruct_sharpness", dgb_reconstruct_uniforms, sharpness),
                                             ARRAY("dgb_reconstruct_weights", dgb_reconstruct_uniforms, weights)};

static const member reflect_members[] = {
    CAMERA("dgb_reflect_camera", dgb_reflect_uniforms, camera), VALUE("dgb_reflect_size", dgb_reflect_uniforms, size),
    VALUE("dgb_reflect_rect", dgb_reflect_uniforms, rect),      VALUE("dgb_reflect_ray", dgb_reflect_uniforms, ray),
    VALUE("dgb_reflect_fade", dgb_reflect_uniforms, fade),      VALUE("dgb_reflect_skip", dgb_reflect_uniforms, skip)};

static const member glossy_members[] = {CAMERA("dgb_glossy_camera", dgb_glossy_uniforms, camera),
                                        VALUE("dgb_glossy_rect", dgb_glossy_uniforms, rect),
                                        VALUE("dgb_glossy_size", dgb_glossy_uniforms, size),
                                        VALUE("dgb_glossy_reach", dgb_glossy_uniforms, reach),
                                        VALUE("dgb_glossy_sharpness", dgb_glossy_uniforms, sharpness),
                                        PAST("dgb_glossy_past", dgb_glossy_uniforms),
                                        ARRAY("dgb_glossy_taps", dgb_glossy_uniforms, taps)};

static const member warp_members[] = {
    CAMERA("dgb_warp_camera", dgb_warp_uniforms, camera), CAMERA("dgb_warp_last", dgb_warp_uniforms, last),
    ARRAY("dgb_warp_to_last", dgb_warp_uniforms, to_last), VALUE("dgb_warp_layer", dgb_warp_uniforms, layer),
    VALUE("dgb_warp_depth", dgb_warp_uniforms, depth)};

typedef struct block {
    const char* name;
    size_t size;
    const member* members;
    int count;
} block;

#define BLOCK(pass)                                                           \
    {                                                                         \
        "dgb_" #pass "_block", sizeof(dgb_##pass##_uniforms), pass##_members, \
            (int)(sizeof pass##_members / sizeof(member))                     \
    }

static const block draw_block = BLOCK(draw);

static const block* block_of(const dgb_program_desc* program) {
    static const block blocks[] = {BLOCK(pack),    BLOCK(ao),       BLOCK(gather), BLOCK(reconstruct),
                                   BLOCK(resolve), BLOCK(temporal), BLOCK(tiles),  BLOCK(reflect),
                                   BLOCK(glossy),  BLOCK(warp),     BLOCK(bitmask)};
    int i;
    for (i = 0; i < program->define_count; ++i)
        if (strcmp(program->defines[i].name, "DGB_BITMASK_LIGHT") == 0) return &blocks[10];
    /* the first steps of TILES have none */
    if (program->pass == DGB_PASS_TILES && program->defines[0].value < 2) return NULL;
    switch (program->pass) {
    case DGB_PASS_WARP: return &blocks[9];
    case DGB_PASS_RESOLVE: return &blocks[4];
    case DGB_PASS_PACK: return &blocks[0];
    case DGB_PASS_TILES: return &blocks[6];
    case DGB_PASS_AO: return &blocks[1];
    case DGB_PASS_GATHER: return &blocks[2];
    case DGB_PASS_TEMPORAL: return &blocks[5];
    case DGB_PASS_RECONSTRUCT: return &blocks[3];
    case DGB_PASS_REFLECT: return &blocks[7];
    case DGB_PASS_GLOSSY: return &blocks[8];
    default: return NULL; /* the MIP and RANGE passes have no block */
    }
}

static GLint uniform_property(GLuint program, GLuint index, GLenum property) {
    GLint value = -1;
    glGetActiveUniformsiv(program, 1, &index, property, &value);
    return value;
}

static GLint block_property(GLuint program, GLuint index, GLenum property) {
    GLint value = -1;
    glGetActiveUniformBlockiv(program, index, property, &value);
    return value;
}

static void check_block(GLuint program, const block* expected) {
    const GLuint index = glGetUniformBlockIndex(program, expected->name);
    int i;
    assert_true(index != GL_INVALID_INDEX);
    assert_int_equal(block_property(program, index, GL_UNIFORM_BLOCK_DATA_SIZE), (GLint)expected->size);
    /* a member that the table lacks would show here */
    assert_int_equal(block_property(program, index, GL_UNIFORM_BLOCK_ACTIVE_UNIFORMS), expected->count);
    for (i = 0; i < expected->count; ++i) {
        const member* m = &expected->members[i];
        GLuint uniform = GL_INVALID_INDEX;
        glGetUniformIndices(program, 1, &m->name, &uniform);
        if (uniform == GL_INVALID_INDEX) print_error("no %s\n", m->name);
        assert_true(uniform != GL_INVALID_INDEX);
        assert_int_equal(uniform_property(program, uniform, GL_UNIFORM_BLOCK_INDEX), (GLint)index);
        assert_int_equal(uniform_property(program, uniform, GL_UNIFORM_OFFSET), (GLint)m->offset);
        assert_int_equal(uniform_property(program, uniform, GL_UNIFORM_ARRAY_STRIDE), (GLint)m->stride);
    }
}

static dgb_desc desc_of(int layers) {
    const fixture_view v = fixture_default_view();
    dgb_desc d = fixture_desc(&f, &v, 64, 48, 0);
    d.layers = layers;
    d.effects = DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY;
    return d;
}

/* Checks every program of a context; seen counts them by pass. */
static void check_programs(const dgb_desc* d, int seen[DGB_PASS_COUNT]) {
    dgb_context c;
    int i;
    assert_int_equal(dgb_init(&c, d), DGB_OK);
    for (i = 0; i < c.plan.program_count; ++i) {
        const block* expected = block_of(&c.plan.programs[i]);
        const GLuint program = (GLuint)c.programs[i].id;
        GLint blocks = -1;
        glGetProgramiv(program, GL_ACTIVE_UNIFORM_BLOCKS, &blocks);
        assert_int_equal(blocks, expected ? 1 : 0);
        if (expected) check_block(program, expected);
        ++seen[c.plan.programs[i].pass];
    }
    dgb_shutdown(&c);
}

static void test_passes(void** state) {
    int layers, normals, effects, pass, seen[DGB_PASS_COUNT] = {0};
    (void)state;
    for (layers = 1; layers <= 2; ++layers)
        for (effects = 1; effects <= 63; ++effects) {
            dgb_desc d = desc_of(layers);
            d.effects = (uint32_t)effects;
            if ((effects & 6) == DGB_EFFECT_BOUNCES || (effects & 43) == DGB_EFFECT_TEMPORAL ||
                (effects & 48) == DGB_EFFECT_GLOSSY)
                continue; /* nothing to bounce, to average, to mirror */
            d.senders = effects == 3 ? DGB_SENDERS_STRONGEST : DGB_SENDERS_BOTH;
            d.tracer = effects & DGB_EFFECT_AO ? DGB_TRACER_HIERARCHICAL : DGB_TRACER_LINEAR;
            check_programs(&d, seen);
            d.estimator = DGB_ESTIMATOR_BITMASK;
            if (effects & (DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY)) check_programs(&d, seen);
            d.estimator = DGB_ESTIMATOR_PAPER;
            d.source = DGB_SOURCE_ENGINE;
            for (normals = 0; normals < DGB_NORMALS_COUNT; ++normals) {
                d.normals = (dgb_normals)normals;
                check_programs(&d, seen);
            }
        }
    for (pass = DGB_PASS_PACK; pass < DGB_PASS_COUNT; ++pass) assert_true(seen[pass] > 0);
}

static void test_material(void** state) {
    static const dgb_emission emissions[] = {DGB_EMISSION_SEPARATE, DGB_EMISSION_GEOMETRY, DGB_EMISSION_VERTEX};
    int layers, i;
    (void)state;
    for (layers = 1; layers <= 2; ++layers)
        for (i = 0; i < 3; ++i) {
            dgb_desc d = desc_of(layers);
            dgb_context c;
            GLuint program;
            d.emission = emissions[i];
            if (!fixture_offers(&f, &d)) continue;
            assert_int_equal(dgb_init(&c, &d), DGB_OK);
            program = fixture_program(&c);
            assert_true(program != 0);
            check_block(program, &draw_block);
            glDeleteProgram(program);
            dgb_shutdown(&c);
        }
}

FIXTURE_CONTEXT(f, 4, 5, false)

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_passes),
        cmocka_unit_test(test_material),
        cmocka_unit_test(test_no_messages),
    };
    return cmocka_run_group_tests(tests, open_context, close_context);
}
