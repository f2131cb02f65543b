/* OpenGL ES 3.0: both layers, by drawing the scene twice (there are no layered framebuffers), and ambient occlusion of both.
   build  make build/release/integrations/gles3
   run    build/release/integrations/gles3 FILE.ppm [LAYERS]     writes the ambient visibility as a grey picture
   copy   what stands between `>> deepgbuffer` and `<< deepgbuffer`, 60 lines; the context needs EXT_color_buffer_float */
#include "engine.h"

#include <stdlib.h>

/* >> deepgbuffer */
#define DEEPGBUFFER_IMPLEMENTATION
#include "deepgbuffer.h"
#include "deepgbuffer_gl.h"

static dgbgl_backend gl;
static dgb_context dgb;

/* The library's text, which starts with #version 300 es and the precisions, goes before these. */
static const char* const box_vertex =
    "uniform mat4 view, projection, previous_view, previous_projection; uniform vec3 boxes[32]; out vec3 v_normal;\n"
    "void main() {\n"
    "    int face = gl_VertexID / 6, at = gl_VertexID % 6, corner = face % 2 == 1 ? at : 5 - at, box = 2 * "
    "dgb_instance();\n"
    "    vec3 p = vec3(corner % 2, (corner + 1) / 3 % 2, face % 2), n = vec3(0, 0, 2 * (face % 2) - 1);\n"
    "    if (face / 2 == 1) p = p.yzx, n = n.yzx; else if (face / 2 == 2) p = p.zxy, n = n.zxy;\n"
    "    vec4 world = vec4(mix(boxes[box], boxes[box + 1], p), 1);\n"
    "    v_normal = mat3(view) * n;\n"
    "    dgb_vertex(projection * view * world, previous_projection * previous_view * world);\n"
    "}\n";
static const char* const box_fragment = "in vec3 v_normal;\n"
                                        "void main() {\n"
                                        "    if (!dgb_keep()) discard;\n"
                                        "    dgb_store(vec4(1), v_normal, vec2(0), vec3(0));\n"
                                        "}\n";

static GLuint create_layers(int layers) { /* returns the program of the boxes, 0 when it fails */
    static char vertex_head[1 << 16], fragment_head[1 << 16];
    const dgbgl_desc gl_desc = {.get_proc = engine_get_proc, .message = engine_on_message};
    dgb_desc desc = {.width = ENGINE_WIDTH, .height = ENGINE_HEIGHT, .effects = DGB_EFFECT_AO};
    GLuint program;
    desc.layers = layers, desc.targets = DGB_TARGET_NORMAL, desc.backend = &gl.backend;
    if (dgbgl_init(&gl, &gl_desc) != DGB_OK || dgb_init(&dgb, &desc) != DGB_OK) return 0;
    dgbgl_shader_prefix(&dgb, DGBGL_VERTEX, NULL, 0, vertex_head, sizeof vertex_head);
    dgbgl_shader_prefix(&dgb, DGBGL_FRAGMENT, NULL, 0, fragment_head, sizeof fragment_head);
    program = engine_program(vertex_head, box_vertex, fragment_head, box_fragment, NULL);
    dgbgl_attach_program(&dgb, program);
    return program;
}

static void draw_scene(void* user, const dgb_draw* draw) { /* once a layer */
    const char* const names[] = {"view", "projection", "previous_view", "previous_projection"};
    const float* values[] = {draw->view, draw->projection, draw->previous_view, draw->previous_projection};
    const GLuint program = *(const GLuint*)user;
    int i;
    glUseProgram(program);
    for (i = 0; i < 4; ++i) glUniformMatrix4fv(glGetUniformLocation(program, names[i]), 1, GL_FALSE, values[i]);
    glUniform3fv(glGetUniformLocation(program, "boxes"), 2 * ENGINE_BOXES, engine_boxes[0]);
    glEnable(GL_CULL_FACE); /* inside a wall there is nothing to see */
    glDrawArraysInstanced(GL_TRIANGLES, 0, 36, ENGINE_BOXES * draw->instances);
}

static GLuint draw_frame(GLuint program, const dgb_view* view) {
    const dgb_params params = dgb_preset(DGB_PRESET_BALANCED);
    dgb_build(&dgb, view, &params, draw_scene, &program);
    dgb_shade(&dgb, &params);
    return dgbgl_texture_name(dgb_get_texture(&dgb, DGB_AO));
}

static void destroy_layers(void) {
    dgb_shutdown(&dgb);
    dgbgl_shutdown(&gl);
}
/* << deepgbuffer */

static const dgb_view camera = {.view = ENGINE_VIEW, .projection = ENGINE_PROJECTION};

int main(int argc, char** argv) {
    GLuint program;
    if (argc != 2 && argc != 3) engine_fail("give the FILE.ppm to write, and LAYERS if not 2");
    engine_start(true);
    program = create_layers(argc == 3 ? atoi(argv[2]) : 2);
    if (!program) engine_fail("this OpenGL ES will not do, or there are no such layers");
    engine_show(draw_frame(program, &camera));
    engine_save(argv[1]);
    destroy_layers();
    engine_stop();
    return 0;
}
