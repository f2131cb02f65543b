#include "engine.h"

#include "headless.h"

#include <stdio.h>
#include <stdlib.h>

const float engine_boxes[ENGINE_BOXES][6] = {
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

static const char* const box_vertex =
    "uniform mat4 view, projection;\n"
    "uniform vec3 boxes[32];\n"
    "void main() {\n"
    "    int face = gl_VertexID / 6, corner = gl_VertexID % 6, box = 2 * gl_InstanceID;\n"
    "    vec3 p = vec3(corner % 2, (corner + 1) / 3 % 2, face % 2);\n"
    "    p = face / 2 == 0 ? p : face / 2 == 1 ? p.yzx : p.zxy;\n"
    "    gl_Position = projection * view * vec4(mix(boxes[box], boxes[box + 1], p), 1);\n"
    "}\n";
static const char* const box_fragment = "void main() {}\n";
static const char* const screen_vertex = /* a triangle over the whole screen */
    "void main() { gl_Position = vec4(gl_VertexID % 2 * 4 - 1, gl_VertexID / 2 * 4 - 1, 0, 1); }\n";
static const char* const screen_fragment =
    "uniform sampler2D image; out vec4 color;\n"
    "void main() { color = vec4(texelFetch(image, ivec2(gl_FragCoord.xy), 0).rrr, 1.0); }\n";

static headless context;

void engine_fail(const char* sentence) {
    fprintf(stderr, "%s\n", sentence);
    exit(2);
}

void engine_on_message(void* user, const char* sentence) {
    (void)user;
    engine_fail(sentence);
}

static GLuint make_texture(GLint internal_format, GLenum format, GLenum type) {
    GLuint texture;
    glGenTextures(1, &texture);
    glBindTexture(GL_TEXTURE_2D, texture);
    glTexImage2D(GL_TEXTURE_2D, 0, internal_format, ENGINE_WIDTH, ENGINE_HEIGHT, 0, format, type, NULL);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    return texture;
}

/* A new framebuffer, bound. */
static GLuint make_framebuffer(GLenum attachment, GLuint texture) {
    GLuint framebuffer;
    glGenFramebuffers(1, &framebuffer);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glFramebufferTexture2D(GL_FRAMEBUFFER, attachment, GL_TEXTURE_2D, texture, 0);
    return framebuffer;
}

void engine_start(bool es) {
    char error[256];
    if (!headless_create(&context, 3, es ? 0 : 3, es, false, error, sizeof error)) engine_fail(error);
    make_framebuffer(GL_COLOR_ATTACHMENT0, make_texture(GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE));
    glViewport(0, 0, ENGINE_WIDTH, ENGINE_HEIGHT);
}

void engine_stop(void) { headless_destroy(&context); }

void* engine_get_proc(const char* name) { return headless_get_proc(name); }

static void add_shader(GLuint program, GLenum stage, const char* head, const char* text) {
    const char* pieces[2] = {head, text};
    const GLuint shader = glCreateShader(stage);
    if (!head) pieces[0] = epoxy_is_desktop_gl() ? "#version 330 core\n" : "#version 300 es\nprecision highp float;\n";
    glShaderSource(shader, 2, pieces, NULL);
    glCompileShader(shader);
    glAttachShader(program, shader);
    glDeleteShader(shader); /* with the program */
}

GLuint engine_program(const char* vertex_head, const char* vertex, const char* fragment_head, const char* fragment,
                      const char* geometry) {
    const GLuint program = glCreateProgram();
    GLint linked;
    add_shader(program, GL_VERTEX_SHADER, vertex_head, vertex);
    add_shader(program, GL_FRAGMENT_SHADER, fragment_head, fragment);
    if (geometry && *geometry) add_shader(program, GL_GEOMETRY_SHADER, "", geometry);
    glLinkProgram(program);
    glGetProgramiv(program, GL_LINK_STATUS, &linked);
    if (!linked) engine_fail("a program of the engine does not link");
    return program;
}

/* Core profiles draw nothing without a vertex array, even where vertices are made from their numbers. */
static void bind_no_vertices(void) {
    static GLuint vertex_array;
    if (!vertex_array) glGenVertexArrays(1, &vertex_array);
    glBindVertexArray(vertex_array);
}

GLuint engine_draw_depth(void) {
    static const float view[16] = ENGINE_VIEW, projection[16] = ENGINE_PROJECTION;
    const GLuint program = engine_program(NULL, box_vertex, NULL, box_fragment, NULL);
    const GLuint texture = make_texture(GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GL_FLOAT);
    GLint picture;
    GLuint framebuffer;
    glGetIntegerv(GL_FRAMEBUFFER_BINDING, &picture);
    framebuffer = make_framebuffer(GL_DEPTH_ATTACHMENT, texture);
    glUseProgram(program);
    glUniformMatrix4fv(glGetUniformLocation(program, "view"), 1, GL_FALSE, view);
    glUniformMatrix4fv(glGetUniformLocation(program, "projection"), 1, GL_FALSE, projection);
    glUniform3fv(glGetUniformLocation(program, "boxes"), 2 * ENGINE_BOXES, engine_boxes[0]);
    bind_no_vertices();
    glEnable(GL_DEPTH_TEST);
    glClear(GL_DEPTH_BUFFER_BIT);
    glDrawArraysInstanced(GL_TRIANGLES, 0, 36, ENGINE_BOXES);
    glDisable(GL_DEPTH_TEST);
    glBindFramebuffer(GL_FRAMEBUFFER, (GLuint)picture);
    glDeleteFramebuffers(1, &framebuffer);
    glDeleteProgram(program);
    return texture;
}

void engine_show(GLuint texture) {
    const GLuint program = engine_program(NULL, screen_vertex, NULL, screen_fragment, NULL);
    glUseProgram(program);
    glActiveTexture(GL_TEXTURE0);
    glBindTexture(GL_TEXTURE_2D, texture);
    bind_no_vertices();
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glDeleteProgram(program);
}

/* Rows of a framebuffer start at the bottom, those of a picture at the top. */
void engine_save(const char* path) {
    static unsigned char row[ENGINE_WIDTH][4]; /* RGBA: the one format that every dialect reads */
    FILE* file = fopen(path, "wb");
    int lowest = 255, x, y, channel;
    double sum = 0;
    if (glGetError()) engine_fail("OpenGL reports an error");
    if (!file) engine_fail("the picture cannot be written");
    fprintf(file, "P6 %d %d 255\n", ENGINE_WIDTH, ENGINE_HEIGHT);
    for (y = ENGINE_HEIGHT; y--;) {
        glReadPixels(0, y, ENGINE_WIDTH, 1, GL_RGBA, GL_UNSIGNED_BYTE, row);
        for (x = 0; x < ENGINE_WIDTH; ++x)
            for (channel = 0; channel < 3; ++channel) {
                fputc(row[x][channel], file);
                lowest = row[x][channel] < lowest ? row[x][channel] : lowest;
                sum += row[x][channel];
            }
    }
    if (ferror(file) || fclose(file)) engine_fail("the picture cannot be written");
    printf("picture: min %.3f mean %.3f\n", lowest / 255.0, sum / (3 * 255.0 * ENGINE_WIDTH * ENGINE_HEIGHT));
}
