#include "gl_faults.h"
#include "numbers.h"

#include <epoxy/gl.h> /* for its values and types: nothing of it is called */

#include <string.h>

static struct faults {
    dgbgl_get_proc_fn get_proc;
    dgbgl_functions gl;
    int count, fail_at, poisoned;
    const char* failed;
    bool lookup, poison;
    void (*watch)(void);
    GLenum error; /* that the failure left */
} f;

void gl_faults_start(dgbgl_get_proc_fn gl, int fail_at) {
    const struct faults before = f;
    memset(&f, 0, sizeof f);
    f.get_proc = gl;
    f.fail_at = fail_at;
    f.failed = "";
    f.poison = before.poison;
    f.watch = before.watch;
}

int gl_faults_count(void) { return f.count; }

const char* gl_faults_failed(void) { return f.failed; }

bool gl_faults_was_lookup(void) { return f.lookup; }

void gl_faults_watch(void (*draw)(void)) { f.watch = draw; }

void gl_faults_poison(bool on) { f.poison = on; }

int gl_faults_poisoned(void) { return f.poisoned; }

static bool fails(const char* function) {
    if (++f.count != f.fail_at) return false;
    f.failed = function;
    return true;
}

static bool out_of_memory(const char* function) {
    if (!fails(function)) return false;
    f.error = GL_OUT_OF_MEMORY;
    return true;
}

static GLenum fault_GetError(void) {
    const GLenum error = f.error;
    f.error = GL_NO_ERROR;
    return error ? error : f.gl.GetError();
}

/* >> names: a driver that has none left gives 0 */

#define FAULT_GEN(function)                                    \
    static void fault_##function(GLsizei count, GLuint* out) { \
        if (fails("gl" #function))                             \
            memset(out, 0, sizeof(GLuint) * (size_t)count);    \
        else                                                   \
            f.gl.function(count, out);                         \
    }
FAULT_GEN(GenTextures)
FAULT_GEN(GenSamplers)
FAULT_GEN(GenFramebuffers)
FAULT_GEN(GenVertexArrays)
FAULT_GEN(GenBuffers)
FAULT_GEN(GenQueries)

static GLuint fault_CreateShader(GLenum stage) { return fails("glCreateShader") ? 0 : f.gl.CreateShader(stage); }

static GLuint fault_CreateProgram(void) { return fails("glCreateProgram") ? 0 : f.gl.CreateProgram(); }

/* >> storage */

void gl_faults_fill(dgbgl_get_proc_fn gl, GLenum target, GLsizei levels, GLenum internal, gl_filling filling) {
    const bool depth =
        internal == GL_DEPTH_COMPONENT16 || internal == GL_DEPTH_COMPONENT24 || internal == GL_DEPTH_COMPONENT32F;
    const bool integer = internal == GL_R32UI || internal == GL_RG32UI || internal == GL_RGBA32UI;
    const bool unorm = internal == GL_R8 || internal == GL_RG8 || internal == GL_RGBA8;
    const GLfloat x = depth || unorm ? filling.share : filling.number, floats[4] = {x, x, x, x};
    const GLuint u = filling.integer, integers[4] = {u, u, u, u};
    void (*get_integer)(GLenum name, GLint * value);
    void (*clear)(GLuint texture, GLint level, GLenum format, GLenum type, const void* data);
    void *get_address = gl("glGetIntegerv"), *clear_address = gl("glClearTexImage");
    GLint texture = 0, level;
    memcpy(&get_integer, &get_address, sizeof get_integer);
    memcpy(&clear, &clear_address, sizeof clear);
    get_integer(target == GL_TEXTURE_2D ? GL_TEXTURE_BINDING_2D : GL_TEXTURE_BINDING_2D_ARRAY, &texture);
    for (level = 0; level < levels; ++level)
        clear((GLuint)texture, level,
              depth     ? GL_DEPTH_COMPONENT
              : integer ? GL_RGBA_INTEGER
                        : GL_RGBA,
              integer ? GL_UNSIGNED_INT : GL_FLOAT, integer ? (const void*)integers : (const void*)floats);
}

/* 0.37: neither of the values that textures are cleared to. */
static void poison(GLenum target, GLsizei levels, GLenum internal) {
    const gl_filling filling = {from_bits(0x7fc00000u), 0.37f, 0xdeadbeefu};
    gl_faults_fill(f.get_proc, target, levels, internal, filling);
    ++f.poisoned;
}

static void fault_TexStorage2D(GLenum target, GLsizei levels, GLenum internal, GLsizei width, GLsizei height) {
    if (out_of_memory("glTexStorage2D")) return;
    f.gl.TexStorage2D(target, levels, internal, width, height);
    if (f.poison) poison(target, levels, internal);
}

static void fault_TexStorage3D(GLenum target, GLsizei levels, GLenum internal, GLsizei width, GLsizei height,
                               GLsizei layers) {
    if (out_of_memory("glTexStorage3D")) return;
    f.gl.TexStorage3D(target, levels, internal, width, height, layers);
    if (f.poison) poison(target, levels, internal);
}

static void fault_TexImage2D(GLenum target, GLint level, GLint internal, GLsizei width, GLsizei height, GLint border,
                             GLenum format, GLenum type, const void* pixels) {
    if (!out_of_memory("glTexImage2D"))
        f.gl.TexImage2D(target, level, internal, width, height, border, format, type, pixels);
}

static void fault_TexImage3D(GLenum target, GLint level, GLint internal, GLsizei width, GLsizei height, GLsizei layers,
                             GLint border, GLenum format, GLenum type, const void* pixels) {
    if (!out_of_memory("glTexImage3D"))
        f.gl.TexImage3D(target, level, internal, width, height, layers, border, format, type, pixels);
}

static void fault_TexSubImage2D(GLenum target, GLint level, GLint x, GLint y, GLsizei width, GLsizei height,
                                GLenum format, GLenum type, const void* pixels) {
    if (!out_of_memory("glTexSubImage2D")) f.gl.TexSubImage2D(target, level, x, y, width, height, format, type, pixels);
}

static void fault_BufferData(GLenum target, GLsizeiptr size, const void* data, GLenum usage) {
    if (!out_of_memory("glBufferData")) f.gl.BufferData(target, size, data, usage);
}

/* >> what the driver thinks of shaders and framebuffers */

static void fault_GetShaderiv(GLuint shader, GLenum name, GLint* value) {
    if (name == GL_COMPILE_STATUS && fails("glGetShaderiv"))
        *value = GL_FALSE;
    else
        f.gl.GetShaderiv(shader, name, value);
}

static void fault_GetProgramiv(GLuint program, GLenum name, GLint* value) {
    if (name == GL_LINK_STATUS && fails("glGetProgramiv"))
        *value = GL_FALSE;
    else
        f.gl.GetProgramiv(program, name, value);
}

static GLenum fault_CheckFramebufferStatus(GLenum target) {
    return fails("glCheckFramebufferStatus") ? GL_FRAMEBUFFER_UNSUPPORTED : f.gl.CheckFramebufferStatus(target);
}

/* >> draws */

static void fault_DrawArrays(GLenum mode, GLint first, GLsizei count) {
    if (f.watch) f.watch();
    f.gl.DrawArrays(mode, first, count);
}

/* >> get_proc */

#define FAULT_FUNCTIONS(X)    \
    X(GetError)               \
    X(GenTextures)            \
    X(GenSamplers)            \
    X(GenFramebuffers)        \
    X(GenVertexArrays)        \
    X(GenBuffers)             \
    X(GenQueries)             \
    X(CreateShader)           \
    X(CreateProgram)          \
    X(TexStorage2D)           \
    X(TexStorage3D)           \
    X(TexImage2D)             \
    X(TexImage3D)             \
    X(TexSubImage2D)          \
    X(BufferData)             \
    X(GetShaderiv)            \
    X(GetProgramiv)           \
    X(CheckFramebufferStatus) \
    X(DrawArrays)

/* The one that stands in, or the GL's own. */
static void* stand_in(const char* name, void* own) {
    static dgbgl_functions faults;
    void* address = own;
#define FAULT_SET(function) faults.function = fault_##function;
    FAULT_FUNCTIONS(FAULT_SET)
#undef FAULT_SET
#define FAULT_FIND(function) \
    if (strcmp(name, "gl" #function) == 0) memcpy(&address, &faults.function, sizeof address);
    FAULT_FUNCTIONS(FAULT_FIND)
#undef FAULT_FIND
    return address;
}

void* gl_faults_get_proc(const char* name) {
    void* own = f.get_proc(name);
    if (!own) return NULL;
#define FAULT_KEEP(result, function, arguments) \
    if (strcmp(name, "gl" #function) == 0) memcpy(&f.gl.function, &own, sizeof own);
    DGBGL_FUNCTIONS(FAULT_KEEP)
    DGBGL_OPTIONAL_FUNCTIONS(FAULT_KEEP)
#undef FAULT_KEEP
    if (!fails(name)) return stand_in(name, own);
    f.lookup = true;
    return NULL;
}
