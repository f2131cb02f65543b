/* Ambient occlusion for an engine that has a depth buffer and nothing else: no normals, no second layer.
       ao_from_depth FILE.ppm    renders without a window, writes the ambient visibility as a grey picture
   What stands between `>> deepgbuffer` and `<< deepgbuffer` is all that the engine adds. */
#include "headless.h"

#include <epoxy/gl.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* >> deepgbuffer */
#define DEEPGBUFFER_IMPLEMENTATION
#include "deepgbuffer.h"
#include "deepgbuffer_gl.h"

static dgbgl_backend gl;
static dgb_context dgb;

static bool create_ao(int width, int height) {
    const dgbgl_desc gl_desc = {.get_proc = headless_get_proc};
    dgb_desc desc = {.width = width, .height = height, .layers = 1, .backend = &gl.backend};
    desc.source = DGB_SOURCE_ENGINE; /* and normals derived from depth: the default */
    desc.effects = DGB_EFFECT_AO;
    return dgbgl_init(&gl, &gl_desc) == DGB_OK && dgb_init(&dgb, &desc) == DGB_OK;
}

/* The name of a GL_TEXTURE_2D that holds ambient visibility, 1 = open. The library owns it. */
static GLuint shade_ao(GLuint depth_texture, const dgb_view* view) {
    const dgb_params params = dgb_preset(DGB_PRESET_BALANCED);
    const dgb_layers layers = {.depth = {dgbgl_texture(depth_texture)}};
    dgb_set_layers(&dgb, view, &layers);
    dgb_shade(&dgb, &params);
    return dgbgl_texture_name(dgb_get_texture(&dgb, DGB_AO));
}

static void destroy_ao(void) {
    dgb_shutdown(&dgb);
    dgbgl_shutdown(&gl);
}
/* << deepgbuffer */

enum { WIDTH = 960, HEIGHT = 540 };

/* Low corner and high corner of each, metres; y is up. */
static const float boxes[][6] = {
    {-9, -0.2f, -12, 9, 0, 6},             /* floor */
    {-9, 0, -4.2f, 9, 5, -4},              /* wall */
    {-4, 0, -3, -2.8f, 1.2f, -1.8f},       /* crate */
    {-3.6f, 1.2f, -2.8f, -3, 1.8f, -2.2f}, /* crate on it */
    {-1.6f, 0, -3.9f, -1.2f, 3.6f, -3.5f}, /* columns */
    {0, 0, -3.9f, 0.4f, 3.6f, -3.5f},
    {1.6f, 0, -3.9f, 2, 3.6f, -3.5f},
    {-2, 3.6f, -4, 2.4f, 4, -3.3f},          /* beam on them */
    {-1.5f, 0, -1, 0.5f, 0.15f, 0.6f},       /* step */
    {-1.2f, 0.15f, -0.7f, 0.2f, 0.3f, 0.3f}, /* step on it */
    {-0.8f, 0.3f, -0.4f, -0.2f, 1.1f, 0},    /* post on that */
    {2.6f, 0, -1.6f, 4, 0.5f, -1.2f},        /* bench */
    {2.8f, 0.5f, -1.5f, 3, 0.6f, -1.3f},     /* book on it */
};
enum { BOXES = sizeof boxes / sizeof *boxes };

/* 3 m up, 7 m back, looking 18 degrees down; 50 degrees high; 0.1 to 100 m. */
static const dgb_view camera = {
    .view = {1, 0, 0, 0, 0, 0.951f, 0.309f, 0, 0, -0.309f, 0.951f, 0, 0, -0.69f, -7.58f, 1},
    .projection = {2.1445f * HEIGHT / WIDTH, 0, 0, 0, 0, 2.1445f, 0, 0, 0, 0, -1.002f, -1, 0, 0, -0.2002f, 0}};

static const char* const vertex_text =
    "#version 330 core\n"
    "uniform mat4 view, projection;\n"
    "uniform vec3 boxes[64];\n"
    "void main() {\n"
    "    int face = gl_VertexID / 6, corner = gl_VertexID % 6, box = 2 * gl_InstanceID;\n"
    "    vec3 p = vec3(corner % 2, (corner + 1) / 3 % 2, face % 2);\n"
    "    p = face / 2 == 0 ? p : face / 2 == 1 ? p.yzx : p.zxy;\n"
    "    gl_Position = projection * view * vec4(mix(boxes[box], boxes[box + 1], p), 1);\n"
    "}\n";
static const char* const fragment_text = "#version 330 core\nvoid main() {}\n";

static void fail(const char* sentence) {
    fprintf(stderr, "ao_from_depth: %s\n", sentence);
    exit(2);
}

static void add_shader(GLuint program, GLenum stage, const char* text) {
    const GLuint shader = glCreateShader(stage);
    glShaderSource(shader, 1, &text, NULL);
    glCompileShader(shader);
    glAttachShader(program, shader);
}

static GLuint create_depth_texture(void) {
    GLuint texture;
    glGenTextures(1, &texture);
    glBindTexture(GL_TEXTURE_2D, texture);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT32F, WIDTH, HEIGHT, 0, GL_DEPTH_COMPONENT, GL_FLOAT, NULL);
    return texture;
}

static void draw_depth(GLuint depth_texture) {
    const GLuint program = glCreateProgram();
    GLuint framebuffer, vertex_array;
    add_shader(program, GL_VERTEX_SHADER, vertex_text);
    add_shader(program, GL_FRAGMENT_SHADER, fragment_text);
    glLinkProgram(program);
    glUseProgram(program);
    glUniformMatrix4fv(glGetUniformLocation(program, "view"), 1, GL_FALSE, camera.view);
    glUniformMatrix4fv(glGetUniformLocation(program, "projection"), 1, GL_FALSE, camera.projection);
    glUniform3fv(glGetUniformLocation(program, "boxes"), 2 * BOXES, boxes[0]);

    glGenFramebuffers(1, &framebuffer);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depth_texture, 0);
    glDrawBuffer(GL_NONE);
    glReadBuffer(GL_NONE);
    glGenVertexArrays(1, &vertex_array);
    glBindVertexArray(vertex_array);
    glViewport(0, 0, WIDTH, HEIGHT);
    glEnable(GL_DEPTH_TEST);
    glClear(GL_DEPTH_BUFFER_BIT);
    glDrawArraysInstanced(GL_TRIANGLES, 0, 36, BOXES);
}

/* Rows of a texture start at the bottom, those of a picture at the top. */
static void save(const char* path, unsigned char visibility[HEIGHT][WIDTH]) {
    FILE* file = fopen(path, "wb");
    if (!file) fail("the picture cannot be written");
    fprintf(file, "P6 %d %d 255\n", WIDTH, HEIGHT);
    for (int y = HEIGHT; y--;)
        for (int x = 0; x < WIDTH; ++x)
            for (int channel = 0; channel < 3; ++channel) fputc(visibility[y][x], file);
    if (ferror(file) || fclose(file)) fail("the picture cannot be written");
}

static void print_statistics(unsigned char visibility[HEIGHT][WIDTH]) {
    int lowest = 255;
    double sum = 0;
    for (int y = 0; y < HEIGHT; ++y)
        for (int x = 0; x < WIDTH; ++x) {
            lowest = visibility[y][x] < lowest ? visibility[y][x] : lowest;
            sum += visibility[y][x];
        }
    printf("visibility: min %.3f mean %.3f\n", lowest / 255.0, sum / (255.0 * WIDTH * HEIGHT));
}

int main(int argc, char** argv) {
    static unsigned char visibility[HEIGHT][WIDTH];
    headless context = {0};
    char error[256];
    if (argc != 2) fail("give the FILE.ppm to write");
    if (!headless_create(&context, 3, 3, false, false, error, sizeof error)) fail(error);
    if (!create_ao(WIDTH, HEIGHT)) fail("this OpenGL will not do");

    const GLuint depth_texture = create_depth_texture();
    draw_depth(depth_texture);
    glBindTexture(GL_TEXTURE_2D, shade_ao(depth_texture, &camera));
    glGetTexImage(GL_TEXTURE_2D, 0, GL_RED, GL_UNSIGNED_BYTE, visibility);
    if (glGetError()) fail("OpenGL reports an error");
    save(argv[1], visibility);
    print_statistics(visibility);

    destroy_ao();
    headless_destroy(&context);
    return 0;
}
