/* The whole of it in an engine that speaks OpenGL by itself: vertex and uniform buffers, two materials (one with holes), a sun.
   Both layers in one pass over the scene, ambient occlusion and bounced light, and the picture made of them.
   build  make build/release/integrations/raw_gl
   run    build/release/integrations/raw_gl FILE.ppm [LAYERS]     renders without a window; LAYERS is 2 if not given
   copy   what stands between `>> deepgbuffer` and `<< deepgbuffer`, in five places: 60 lines and the include */
#include "engine.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* >> deepgbuffer */
#define DEEPGBUFFER_IMPLEMENTATION
#include "deepgbuffer.h"
#include "deepgbuffer_gl.h"

static dgbgl_backend gl;
static dgb_context dgb;
enum { GUARD_BAND = 32 }; /* pixels around the image: what stands there gives light, too */
/* << deepgbuffer */

static const dgb_view camera = {.view = ENGINE_VIEW, .projection = ENGINE_PROJECTION};

/* >> the engine: a mesh, objects in a uniform buffer, a camera in another */

enum { CAMERA_BINDING = 0, OBJECT_BINDING = 1, SOLID = 0, FENCE = 1, MATERIALS = 2 };

typedef struct camera_block { /* std140 */
    float view[16], projection[16], previous_view[16], previous_projection[16];
} camera_block;

typedef struct object_block { /* std140 */
    float low[4], size[4];    /* world space, metres */
    float albedo[4];
} object_block;

typedef struct engine {
    GLuint vertex_array, camera, objects; /* buffers */
    GLint stride;                         /* bytes from object to object */
    GLuint materials[MATERIALS], composite;
} engine;

#define BLOCKS                                                                                              \
    "layout(std140) uniform camera_block { mat4 view, projection, previous_view, previous_projection; };\n" \
    "layout(std140) uniform object_block { vec4 low, size, albedo; };\n"

static const char* const material_vertex =
    BLOCKS "in vec3 position, normal; out vec3 v_normal, v_world;\n"
           "void main() {\n"
           "    vec4 world = vec4(low.xyz + size.xyz * position, 1);\n"
           "    v_normal = mat3(view) * normal, v_world = world.xyz;\n"
           /* >> deepgbuffer */
           "    dgb_vertex(projection * view * world, previous_projection * previous_view * world);\n"
           /* << deepgbuffer */
           "}\n";

/* Two materials of one text: the fence is cut out by an alpha test, which comes first. */
#define MATERIAL(alpha_test)                                                                                       \
    BLOCKS "in vec3 v_normal, v_world;\n"                                                                          \
           "void main() {\n" alpha_test "    vec3 sun = mat3(view) * normalize(vec3(8, 5, 3));\n"                  \
           "    vec3 lit = 3.0 / 3.14159 * albedo.rgb * max(dot(normalize(v_normal), sun), 0.0);\n" KEEP_AND_STORE \
           "}\n"
/* >> deepgbuffer */
#define KEEP_AND_STORE                \
    "    if (!dgb_keep()) discard;\n" \
    "    dgb_store(vec4(albedo.rgb, 1), v_normal, vec2(0), lit);\n"
/* << deepgbuffer */
static const char* const material_fragment[MATERIALS] = {
    MATERIAL(""), MATERIAL("    if (fract(6.0 * v_world.x) < 0.5 && fract(6.0 * v_world.y) < 0.5) discard;\n")};

static const char* const composite_vertex =
    "void main() { gl_Position = vec4(gl_VertexID % 2 * 4 - 1, gl_VertexID / 2 * 4 - 1, 0, 1); }\n";
static const char* const composite_fragment =
    "uniform sampler2DArray albedo, radiance; uniform sampler2D ao, irradiance; uniform int guard_band; out vec4 "
    "color;\n"
    "void main() {\n"
    "    ivec3 p = ivec3(ivec2(gl_FragCoord) + guard_band, 0);\n" /* 0: the front layer */
    "    vec4 surface = texelFetch(albedo, p, 0);\n"
    "    vec3 probe = vec3(0.4, 0.5, 0.7);\n"
    /* >> deepgbuffer */
    "    vec3 light = dgb_fallback(probe, texelFetch(ao, p.xy, 0).r, texelFetch(irradiance, p.xy, 0));\n"
    /* << deepgbuffer */
    "    vec3 sum = texelFetch(radiance, p, 0).rgb + surface.rgb / 3.14159 * light;\n"
    "    color = vec4(pow(1.0 - exp(-1.5 * mix(probe, sum, surface.a)), vec3(1.0 / 2.2)), 1);\n"
    "}\n";

static void attribute(GLuint program, const char* name, size_t offset) {
    const GLuint location = (GLuint)glGetAttribLocation(program, name);
    glEnableVertexAttribArray(location);
    glVertexAttribPointer(location, 3, GL_FLOAT, GL_FALSE, 6 * sizeof(float), (const void*)offset);
}

/* A unit cube: position and normal, 36 vertices. */
static void create_cube(engine* e) {
    float vertices[36][2][3] = {{{0}}};
    GLuint buffer;
    int i;
    for (i = 0; i < 36; ++i) {
        const int side = i / 6 % 2, axis = i / 12, corner = side ? i % 6 : 5 - i % 6; /* counterclockwise */
        vertices[i][0][axis] = (float)side;
        vertices[i][0][(axis + 1) % 3] = (float)(corner % 2);
        vertices[i][0][(axis + 2) % 3] = (float)((corner + 1) / 3 % 2);
        vertices[i][1][axis] = side ? 1.0f : -1.0f;
    }
    glGenVertexArrays(1, &e->vertex_array);
    glBindVertexArray(e->vertex_array);
    glGenBuffers(1, &buffer);
    glBindBuffer(GL_ARRAY_BUFFER, buffer);
    glBufferData(GL_ARRAY_BUFFER, sizeof vertices, vertices, GL_STATIC_DRAW);
}

static bool is_fence(int box) { return box == 10; }

static void create_objects(engine* e) {
    object_block block = {{0}, {0}, {0.8f, 0.8f, 0.8f, 1}};
    int i, axis;
    glGetIntegerv(GL_UNIFORM_BUFFER_OFFSET_ALIGNMENT, &e->stride);
    e->stride *= ((int)sizeof block + e->stride - 1) / e->stride;
    glGenBuffers(1, &e->objects);
    glBindBuffer(GL_UNIFORM_BUFFER, e->objects);
    glBufferData(GL_UNIFORM_BUFFER, e->stride * ENGINE_BOXES, NULL, GL_STATIC_DRAW);
    for (i = 0; i < ENGINE_BOXES; ++i) {
        for (axis = 0; axis < 3; ++axis) {
            block.low[axis] = engine_boxes[i][axis];
            block.size[axis] = engine_boxes[i][3 + axis] - engine_boxes[i][axis];
            block.albedo[axis] = i > 1 && i % 3 != axis ? 0.15f : 0.8f; /* a white room of coloured things */
        }
        glBufferSubData(GL_UNIFORM_BUFFER, e->stride * i, sizeof block, &block);
    }
    glGenBuffers(1, &e->camera);
}

static void bind_blocks(GLuint program) {
    glUniformBlockBinding(program, glGetUniformBlockIndex(program, "camera_block"), CAMERA_BINDING);
    glUniformBlockBinding(program, glGetUniformBlockIndex(program, "object_block"), OBJECT_BINDING);
}

static void draw_objects(const engine* e, const camera_block* block, int instances) {
    int i;
    glBindBuffer(GL_UNIFORM_BUFFER, e->camera);
    glBufferData(GL_UNIFORM_BUFFER, sizeof *block, block, GL_STREAM_DRAW);
    glBindBufferBase(GL_UNIFORM_BUFFER, CAMERA_BINDING, e->camera);
    glBindVertexArray(e->vertex_array);
    glEnable(GL_CULL_FACE);
    for (i = 0; i < ENGINE_BOXES; ++i) {
        glUseProgram(e->materials[is_fence(i) ? FENCE : SOLID]);
        glBindBufferRange(GL_UNIFORM_BUFFER, OBJECT_BINDING, e->objects, e->stride * i, sizeof(object_block));
        glDrawArraysInstanced(GL_TRIANGLES, 0, 36, instances);
    }
}

static void bind(GLuint program, int unit, GLenum target, const char* name, GLuint texture) {
    glActiveTexture((GLenum)(GL_TEXTURE0 + unit));
    glBindTexture(target, texture);
    glUniform1i(glGetUniformLocation(program, name), unit);
}

static void composite(const engine* e, GLuint albedo, GLuint radiance, GLuint ao, GLuint irradiance) {
    glUseProgram(e->composite);
    bind(e->composite, 0, GL_TEXTURE_2D_ARRAY, "albedo", albedo);
    bind(e->composite, 1, GL_TEXTURE_2D_ARRAY, "radiance", radiance);
    bind(e->composite, 2, GL_TEXTURE_2D, "ao", ao);
    bind(e->composite, 3, GL_TEXTURE_2D, "irradiance", irradiance);
    glUniform1i(glGetUniformLocation(e->composite, "guard_band"), GUARD_BAND);
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

/* >> deepgbuffer */
static void create_layers(int layers) {
    const dgbgl_desc gl_desc = {.get_proc = engine_get_proc, .message = engine_on_message};
    dgb_desc desc = {.width = ENGINE_WIDTH, .height = ENGINE_HEIGHT, .guard_band = GUARD_BAND, .layers = layers};
    desc.effects = DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY;
    desc.backend = &gl.backend;
    if (dgbgl_init(&gl, &gl_desc) != DGB_OK || dgb_init(&dgb, &desc) != DGB_OK)
        engine_fail("this OpenGL will not do, or there are no such layers");
}

static GLuint create_material(const char* vertex, const char* fragment) {
    static const dgbgl_varying varyings[] = {{NULL, "vec3", "v_normal"}, {NULL, "vec3", "v_world"}};
    static char heads[2][1 << 16], geometry[1 << 16];
    GLuint program;
    dgbgl_shader_prefix(&dgb, DGBGL_VERTEX, varyings, 2, heads[0], sizeof heads[0]);
    dgbgl_shader_prefix(&dgb, DGBGL_FRAGMENT, varyings, 2, heads[1], sizeof heads[1]);
    dgbgl_geometry_shader(&dgb, varyings, 2, geometry, sizeof geometry); /* empty where none is needed */
    program = engine_program(heads[0], vertex, heads[1], fragment, geometry);
    dgbgl_attach_program(&dgb, program);
    return program;
}

static GLuint create_composite(const char* vertex, const char* fragment) {
    static const char version[] = "#version 330 core\n";
    char head[4096];
    memcpy(head, version, sizeof version);
    dgbgl_composite_snippet(head + sizeof version - 1, sizeof head - sizeof version + 1);
    return engine_program(NULL, vertex, head, fragment, NULL);
}

static void draw_scene(void* user, const dgb_draw* draw) {
    camera_block block;
    memcpy(block.view, draw->view, sizeof block.view);
    memcpy(block.projection, draw->projection, sizeof block.projection);
    memcpy(block.previous_view, draw->previous_view, sizeof block.previous_view);
    memcpy(block.previous_projection, draw->previous_projection, sizeof block.previous_projection);
    draw_objects((const engine*)user, &block, draw->instances);
}

static GLuint texture(dgb_slot slot) { return dgbgl_texture_name(dgb_get_texture(&dgb, slot)); }

static void draw_frame(engine* e) {
    const dgb_params params = dgb_preset(DGB_PRESET_QUALITY);
    dgb_build(&dgb, &camera, &params, draw_scene, e); /* both layers, one pass over the scene */
    dgb_shade(&dgb, &params);                         /* occlusion and bounced light */
    composite(e, texture(DGB_ALBEDO), texture(DGB_RADIANCE), texture(DGB_AO), texture(DGB_IRRADIANCE));
}

static void destroy_layers(void) {
    dgb_shutdown(&dgb);
    dgbgl_shutdown(&gl);
}
/* << deepgbuffer */

static void create_programs(engine* e) {
    int i;
    for (i = 0; i < MATERIALS; ++i) {
        e->materials[i] = create_material(material_vertex, material_fragment[i]);
        bind_blocks(e->materials[i]);
        attribute(e->materials[i], "position", 0);
        attribute(e->materials[i], "normal", 3 * sizeof(float));
    }
    e->composite = create_composite(composite_vertex, composite_fragment);
}

int main(int argc, char** argv) {
    engine e = {0};
    if (argc != 2 && argc != 3) engine_fail("give the FILE.ppm to write, and LAYERS if not 2");
    engine_start(false);
    create_cube(&e);
    create_objects(&e);
    create_layers(argc == 3 ? atoi(argv[2]) : 2);
    create_programs(&e);
    draw_frame(&e);
    engine_save(argv[1]);
    destroy_layers();
    engine_stop();
    return 0;
}
