/* The engine's rendering interface on OpenGL, as a device backend of any engine might be. It knows nothing of deepgbuffer. */
#include "rhi.h"

#include "engine.h"

#include <stdio.h>

static const struct {
    GLint internal;
    GLenum format, type;
} formats[] = {
    {GL_R8, GL_RED, GL_UNSIGNED_BYTE},
    {GL_RG8, GL_RG, GL_UNSIGNED_BYTE},
    {GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE},
    {GL_R11F_G11F_B10F, GL_RGB, GL_FLOAT},
    {GL_RG16F, GL_RG, GL_FLOAT},
    {GL_RGBA16F, GL_RGBA, GL_FLOAT},
    {GL_R32F, GL_RED, GL_FLOAT},
    {GL_RG32F, GL_RG, GL_FLOAT},
    {GL_RGBA32F, GL_RGBA, GL_FLOAT},
    {GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT},
    {GL_RG32UI, GL_RG_INTEGER, GL_UNSIGNED_INT},
    {GL_RGBA32UI, GL_RGBA_INTEGER, GL_UNSIGNED_INT},
    {GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GL_FLOAT},
};

enum { MAX_BINDINGS = 16, MAX_NAME = 32, LAST_LEVEL = 1000 /* OpenGL's own default */ };

static GLuint constants, vertex_array, framebuffer; /* of the device */
static GLint picture;                               /* the framebuffer outside of passes */
static char bindings[MAX_BINDINGS][MAX_NAME];       /* of the pass: name of what is bound to texture unit i */
static int binding_count;

void rhi_start(void) {
    engine_start(false);
    glGetIntegerv(GL_FRAMEBUFFER_BINDING, &picture);
    glGenBuffers(1, &constants);
    glGenVertexArrays(1, &vertex_array);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
}

void rhi_stop(void) {
    glDeleteBuffers(1, &constants);
    glDeleteVertexArrays(1, &vertex_array);
    engine_stop();
}

int rhi_max_texture_size(void) {
    GLint size;
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &size);
    return size;
}

rhi_texture rhi_create_texture(const rhi_texture_desc* desc) {
    GLuint texture;
    int level;
    glGenTextures(1, &texture);
    glBindTexture(GL_TEXTURE_2D, texture);
    for (level = 0; level < desc->levels; ++level)
        glTexImage2D(GL_TEXTURE_2D, level, formats[desc->format].internal, desc->width >> level, desc->height >> level,
                     0, formats[desc->format].format, formats[desc->format].type, level ? NULL : desc->pixels);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST); /* levels are fetched by number, never chosen */
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    if (!glGetError()) return texture;
    glDeleteTextures(1, &texture);
    return 0;
}

void rhi_destroy_texture(rhi_texture texture) { glDeleteTextures(1, &texture); }

rhi_pipeline rhi_create_pipeline(const char* label, const char* vertex_text, const char* fragment_text) {
    const GLuint program = engine_program("", vertex_text, "", fragment_text, NULL);
    GLint blocks;
    if (epoxy_has_gl_extension("GL_KHR_debug")) glObjectLabel(GL_PROGRAM, program, -1, label);
    glGetProgramiv(program, GL_ACTIVE_UNIFORM_BLOCKS, &blocks);
    if (blocks) glUniformBlockBinding(program, 0, 0);
    return program;
}

void rhi_destroy_pipeline(rhi_pipeline pipeline) { glDeleteProgram(pipeline); }

void rhi_begin_pass(const rhi_render_pass* pass) {
    GLenum buffers[4];
    int i;
    glGenFramebuffers(1, &framebuffer);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    for (i = 0; i < pass->color_count; ++i) {
        buffers[i] = (GLenum)(GL_COLOR_ATTACHMENT0 + i);
        glFramebufferTexture2D(GL_FRAMEBUFFER, buffers[i], GL_TEXTURE_2D, pass->colors[i].texture,
                               pass->colors[i].level);
    }
    glDrawBuffers(pass->color_count, buffers);
    glViewport(pass->x, pass->y, pass->width, pass->height);
    binding_count = 0;
}

static void view_levels(int first, int last) {
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_BASE_LEVEL, first);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, last);
}

void rhi_bind_texture(const char* name, rhi_texture texture, int level) {
    glActiveTexture((GLenum)(GL_TEXTURE0 + binding_count));
    glBindTexture(GL_TEXTURE_2D, texture);
    if (level >= 0) view_levels(level, level);
    snprintf(bindings[binding_count++], MAX_NAME, "%s", name);
}

void rhi_set_constants(const void* data, size_t size) {
    glBindBuffer(GL_UNIFORM_BUFFER, constants);
    glBufferData(GL_UNIFORM_BUFFER, (GLsizeiptr)size, data, GL_STREAM_DRAW);
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, constants);
}

void rhi_draw(rhi_pipeline pipeline, int vertices) {
    int i;
    glUseProgram(pipeline);
    for (i = 0; i < binding_count; ++i) glUniform1i(glGetUniformLocation(pipeline, bindings[i]), i);
    glBindVertexArray(vertex_array);
    glDrawArrays(GL_TRIANGLES, 0, vertices);
}

void rhi_end_pass(void) {
    while (binding_count--) {
        glActiveTexture((GLenum)(GL_TEXTURE0 + binding_count));
        view_levels(0, LAST_LEVEL);
    }
    glBindFramebuffer(GL_FRAMEBUFFER, (GLuint)picture);
    glDeleteFramebuffers(1, &framebuffer);
}

rhi_texture rhi_draw_scene_depth(void) {
    glViewport(0, 0, ENGINE_WIDTH, ENGINE_HEIGHT);
    return engine_draw_depth();
}

void rhi_save_picture(rhi_texture texture, const char* path) {
    glViewport(0, 0, ENGINE_WIDTH, ENGINE_HEIGHT);
    engine_show(texture);
    engine_save(path);
}
