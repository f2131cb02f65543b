#include "gl_state.h"
#include "numbers.h"

#include <epoxy/gl.h>

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum {
    MAX_NAMES = 2048,
    MAX_VALUES = 1024, /* of one query */
    MAX_INDEX = 96,
    UNITS = 32, /* texture units; the library uses 16 */
    ATTRIBUTES = 16,
    TARGETS = 11 /* of textures */
};

/* >> queries: what asks for one value or several, of an object, an index or a unit */

typedef bool (*query)(GLenum name, GLuint index, double values[MAX_VALUES]);

/* Values are written behind each other; what is not written stays as it was. */
static void widen(const GLint* from, double* to, int count) {
    while (count--) to[count] = from[count];
}

static bool ask_plain(GLenum name, GLuint index, double* values) {
    (void)index;
    glGetDoublev(name, values);
    return true;
}

static bool ask_enabled(GLenum name, GLuint index, double* values) {
    (void)index;
    values[0] = glIsEnabled(name);
    return true;
}

static bool ask_enabled_index(GLenum name, GLuint index, double* values) {
    values[0] = glIsEnabledi(name, index);
    return true;
}

static bool ask_integer_index(GLenum name, GLuint index, double* values) {
    GLint v[16] = {0};
    glGetIntegeri_v(name, index, v);
    widen(v, values, 4);
    return true;
}

static bool ask_long_index(GLenum name, GLuint index, double* values) {
    GLint64 v[16] = {0};
    glGetInteger64i_v(name, index, v);
    values[0] = (double)v[0];
    return true;
}

static bool ask_double_index(GLenum name, GLuint index, double* values) {
    glGetDoublei_v(name, index, values);
    return true;
}

static bool ask_attribute(GLenum name, GLuint index, double* values) {
    glGetVertexAttribdv(index, name, values);
    return true;
}

static const GLenum attachments[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT0 + 1, GL_COLOR_ATTACHMENT0 + 7,
                                     GL_DEPTH_ATTACHMENT, GL_STENCIL_ATTACHMENT};
enum { ATTACHMENTS = (int)(sizeof attachments / sizeof attachments[0]) };

static bool ask_attachment(GLenum target, GLenum name, GLuint index, double* values) {
    GLint v[16] = {0};
    if (index >= ATTACHMENTS) return false;
    glGetFramebufferAttachmentParameteriv(target, attachments[index], name, v);
    values[0] = v[0];
    return true;
}

static bool ask_drawn_attachment(GLenum name, GLuint index, double* values) {
    return ask_attachment(GL_DRAW_FRAMEBUFFER, name, index, values);
}

static bool ask_read_attachment(GLenum name, GLuint index, double* values) {
    return ask_attachment(GL_READ_FRAMEBUFFER, name, index, values);
}

static const GLenum buffer_targets[] = {
    GL_ARRAY_BUFFER,         GL_UNIFORM_BUFFER,        GL_PIXEL_PACK_BUFFER,     GL_PIXEL_UNPACK_BUFFER,
    GL_COPY_READ_BUFFER,     GL_COPY_WRITE_BUFFER,     GL_TEXTURE_BUFFER,        GL_TRANSFORM_FEEDBACK_BUFFER,
    GL_DRAW_INDIRECT_BUFFER, GL_SHADER_STORAGE_BUFFER, GL_ATOMIC_COUNTER_BUFFER, GL_DISPATCH_INDIRECT_BUFFER,
    GL_QUERY_BUFFER};
enum { BUFFER_TARGETS = (int)(sizeof buffer_targets / sizeof buffer_targets[0]) };

static bool ask_buffer(GLenum name, GLuint index, double* values) {
    GLint64 v = 0;
    if (index >= BUFFER_TARGETS) return false;
    glGetBufferParameteri64v(buffer_targets[index], name, &v);
    values[0] = (double)v;
    return true;
}

static const GLenum texture_targets[TARGETS] = {GL_TEXTURE_2D,
                                                GL_TEXTURE_2D_ARRAY,
                                                GL_TEXTURE_1D,
                                                GL_TEXTURE_1D_ARRAY,
                                                GL_TEXTURE_3D,
                                                GL_TEXTURE_CUBE_MAP,
                                                GL_TEXTURE_CUBE_MAP_ARRAY,
                                                GL_TEXTURE_RECTANGLE,
                                                GL_TEXTURE_BUFFER,
                                                GL_TEXTURE_2D_MULTISAMPLE,
                                                GL_TEXTURE_2D_MULTISAMPLE_ARRAY};

/* Of what is bound in the active unit, whatever that is. */
static bool ask_texture(GLenum name, GLuint index, double* values) {
    GLfloat v[16] = {0};
    int i;
    if (index > 1) return false;
    glGetTexParameterfv(texture_targets[index], name, v);
    for (i = 0; i < 4; ++i) values[i] = (double)v[i];
    return true;
}

static bool ask_query(GLenum name, GLuint index, double* values) {
    GLint v = 0;
    if (index > 0) return false;
    glGetQueryiv(name, GL_CURRENT_QUERY, &v);
    values[0] = v;
    return true;
}

static bool ask_unit(GLenum name, GLuint index, double* values) {
    GLint active;
    if (index >= UNITS) return false;
    glGetIntegerv(GL_ACTIVE_TEXTURE, &active);
    glActiveTexture(GL_TEXTURE0 + index);
    glGetDoublev(name, values);
    glActiveTexture((GLenum)active);
    return true;
}

static struct kind {
    const char* what;
    query ask;
    int max_index; /* 1: no index */
    GLenum names[MAX_NAMES];
    int indices[MAX_NAMES]; /* that give no error */
    int count;
} kinds[] = {{"value", ask_plain, 1, {0}, {0}, 0},
             {"capability", ask_enabled, 1, {0}, {0}, 0},
             {"indexed capability", ask_enabled_index, MAX_INDEX, {0}, {0}, 0},
             {"indexed integer", ask_integer_index, MAX_INDEX, {0}, {0}, 0},
             {"indexed long", ask_long_index, MAX_INDEX, {0}, {0}, 0},
             {"indexed double", ask_double_index, MAX_INDEX, {0}, {0}, 0},
             {"vertex attribute", ask_attribute, ATTRIBUTES, {0}, {0}, 0},
             {"attachment drawn to", ask_drawn_attachment, ATTACHMENTS, {0}, {0}, 0},
             {"attachment read", ask_read_attachment, ATTACHMENTS, {0}, {0}, 0},
             {"buffer", ask_buffer, BUFFER_TARGETS, {0}, {0}, 0},
             {"texture parameter", ask_texture, 2, {0}, {0}, 0},
             {"running query", ask_query, 1, {0}, {0}, 0},
             {"texture unit", ask_unit, UNITS, {0}, {0}, 0}};
enum { KINDS = (int)(sizeof kinds / sizeof kinds[0]), CAPABILITY = 1, UNIT = KINDS - 1 };

/* >> discovery */

/* The clock, free memory: no state. And values whose query crashes the driver (Mesa 22.3). */
static bool is_left_out(GLenum name) {
    return name == GL_TIMESTAMP || (name >= 0x87fb && name <= 0x87fd) || (name >= 0x9047 && name <= 0x904b) ||
           (name >= 0x9597 && name <= 0x959a);
}

static bool is_known(const struct kind* k, GLenum name, GLuint index) {
    static double values[MAX_VALUES];
    return k->ask(name, index, values) && glGetError() == GL_NO_ERROR;
}

static void discover_kind(struct kind* k) {
    GLenum name;
    int indices;
    k->count = 0;
    for (name = 0; name <= 0xffff; ++name) {
        if (is_left_out(name)) continue;
        for (indices = 0; indices < k->max_index && is_known(k, name, (GLuint)indices); ++indices) {}
        if (!indices) continue;
        assert_true(k->count < MAX_NAMES);
        k->names[k->count] = name;
        k->indices[k->count++] = indices;
    }
}

static struct objects { /* an engine's own */
    GLuint framebuffers[2], textures[TARGETS][2], samplers[2], buffers[2], vertex_arrays[2], renderbuffer, pipeline,
        feedback, program;
} own;

/* Values that another texture unit changes: those of what is bound there. */
static void discover_units(void) {
    static double here[MAX_VALUES], there[MAX_VALUES];
    struct kind *plain = &kinds[0], *unit = &kinds[UNIT];
    int i, t;
    for (t = 0; t < TARGETS; ++t) {
        glActiveTexture(GL_TEXTURE1);
        glBindTexture(texture_targets[t], own.textures[t][0]);
    }
    glBindSampler(1, own.samplers[0]);
    unit->count = 0;
    for (i = 0; i < plain->count; ++i) {
        if (plain->names[i] == GL_ACTIVE_TEXTURE) continue;
        ask_unit(plain->names[i], 0, here);
        ask_unit(plain->names[i], 1, there);
        if (here[0] >= there[0] && here[0] <= there[0]) continue;
        unit->names[unit->count] = plain->names[i];
        unit->indices[unit->count++] = UNITS;
    }
    for (t = 0; t < TARGETS; ++t) glBindTexture(texture_targets[t], 0);
    glBindSampler(1, 0);
    glActiveTexture(GL_TEXTURE0);
    assert_int_equal(unit->count, TARGETS + 1); /* each target's binding, and the sampler's */
}

static void discover(void) {
    const GLboolean debug = glIsEnabled(GL_DEBUG_OUTPUT);
    int i;
    /* messages about enums that there are not are no news */
    glDisable(GL_DEBUG_OUTPUT);
    glBindFramebuffer(GL_FRAMEBUFFER, own.framebuffers[0]);
    glBindTexture(GL_TEXTURE_2D, own.textures[0][0]);
    glBindTexture(GL_TEXTURE_2D_ARRAY, own.textures[1][0]);
    glBindVertexArray(own.vertex_arrays[0]);
    for (i = 0; i < BUFFER_TARGETS; ++i) glBindBuffer(buffer_targets[i], own.buffers[0]);
    for (i = 0; i < UNIT; ++i) discover_kind(&kinds[i]);
    for (i = 0; i < BUFFER_TARGETS; ++i) glBindBuffer(buffer_targets[i], 0);
    glBindVertexArray(0);
    glBindTexture(GL_TEXTURE_2D, 0);
    glBindTexture(GL_TEXTURE_2D_ARRAY, 0);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    discover_units();
    while (glGetError() != GL_NO_ERROR) {} /* of what another framebuffer had */
    if (debug) glEnable(GL_DEBUG_OUTPUT);
}

/* >> snapshots */

typedef struct entry {
    int kind;
    GLenum name;
    GLuint index;
    int first, count; /* of values */
} entry;

struct gl_state {
    entry* entries;
    double* values;
    int entry_count, value_count, entry_capacity, value_capacity;
};

static void* grow(void* data, int* capacity, int needed, size_t size) {
    if (needed <= *capacity) return data;
    *capacity = 2 * needed;
    data = realloc(data, (size_t)*capacity * size);
    assert_non_null(data);
    return data;
}

/* A value that no query gives: what is left of it was not written. */
static const double unwritten = -7.25e101;

static void add(gl_state* s, int kind, GLenum name, GLuint index) {
    static double values[MAX_VALUES];
    entry* e;
    int i, count = 0;
    for (i = 0; i < MAX_VALUES; ++i) values[i] = unwritten;
    (void)kinds[kind].ask(name, index, values);
    while (count < MAX_VALUES && (values[count] > unwritten || values[count] < unwritten)) ++count;
    s->entries = (entry*)grow(s->entries, &s->entry_capacity, s->entry_count + 1, sizeof(entry));
    s->values = (double*)grow(s->values, &s->value_capacity, s->value_count + count, sizeof(double));
    e = &s->entries[s->entry_count++];
    e->kind = kind, e->name = name, e->index = index;
    e->first = s->value_count, e->count = count;
    for (i = 0; i < count; ++i) s->values[s->value_count++] = values[i];
}

gl_state* gl_state_take(void) {
    const GLboolean debug = glIsEnabled(GL_DEBUG_OUTPUT);
    gl_state* s = (gl_state*)calloc(1, sizeof *s);
    int kind, i, index;
    assert_int_equal(glGetError(), GL_NO_ERROR);
    /* what is bound may lack what something else had: a framebuffer 0, a texture of another kind */
    glDisable(GL_DEBUG_OUTPUT);
    for (kind = 0; kind < KINDS; ++kind)
        for (i = 0; i < kinds[kind].count; ++i)
            for (index = 0; index < kinds[kind].indices[i]; ++index) {
                if (kinds[kind].ask == ask_enabled && kinds[kind].names[i] == GL_DEBUG_OUTPUT) continue;
                if (kinds[kind].ask == ask_plain && kinds[kind].names[i] == GL_DEBUG_OUTPUT) continue;
                add(s, kind, kinds[kind].names[i], (GLuint)index);
            }
    while (glGetError() != GL_NO_ERROR) {}
    if (debug) glEnable(GL_DEBUG_OUTPUT);
    return s;
}

void gl_state_free(gl_state* s) {
    if (!s) return;
    free(s->entries);
    free(s->values);
    free(s);
}

int gl_state_count(const gl_state* s) { return s->value_count; }

static bool same(const gl_state* a, const gl_state* b, int i) {
    const entry *x = &a->entries[i], *y = &b->entries[i];
    return x->count == y->count &&
           same_bits(a->values + x->first, b->values + y->first, (size_t)x->count * sizeof(double));
}

/* The first value that differs, in words. */
static void describe(const gl_state* a, const gl_state* b, int i, char* text, size_t size) {
    const entry *x = &a->entries[i], *y = &b->entries[i];
    const double *v = a->values + x->first, *w = b->values + y->first;
    int k = 0;
    while (k + 1 < x->count && k + 1 < y->count && same_bits(v + k, w + k, sizeof *v)) ++k;
    snprintf(text, size, "%s 0x%04x[%u].%d: %.9g became %.9g", kinds[x->kind].what, x->name, x->index, k,
             x->count ? v[k] : 0.0, y->count ? w[k] : 0.0);
}

int gl_state_compare(const gl_state* a, const gl_state* b, char* text, size_t size) {
    int i, count = 0;
    text[0] = 0;
    assert_int_equal(a->entry_count, b->entry_count);
    for (i = 0; i < a->entry_count; ++i)
        if (!same(a, b, i) && !count++) describe(a, b, i, text, size);
    return count;
}

/* >> disorder */

static uint32_t random_state;

static unsigned below(unsigned n) { return (lcg(&random_state) >> 8) % n; }

static GLboolean coin(void) { return below(2) ? GL_TRUE : GL_FALSE; }

static float part(void) { return (float)below(101) * 0.01f; }

/* Every capability there is, but for those that only talk. */
static void scramble_capabilities(void) {
    int i;
    for (i = 0; i < kinds[CAPABILITY].count; ++i) {
        const GLenum name = kinds[CAPABILITY].names[i];
        if (name == GL_DEBUG_OUTPUT || name == GL_DEBUG_OUTPUT_SYNCHRONOUS) continue;
        if (coin())
            glEnable(name);
        else
            glDisable(name);
    }
    (void)glGetError(); /* what only a compatibility context can set */
}

static void scramble_indexed(void) {
    GLuint i;
    for (i = 0; i < 16; ++i) {
        glViewportIndexedf(i, (float)below(9), 2.5f, (float)below(40), (float)below(40));
        glDepthRangeIndexed(i, 0.01 * below(100), 0.01 * below(100));
        glScissorIndexed(i, 1, 1, 3, (GLsizei)below(4));
        (coin() ? glEnablei : glDisablei)(GL_SCISSOR_TEST, i);
    }
    for (i = 0; i < 8; ++i) {
        (coin() ? glEnablei : glDisablei)(GL_BLEND, i);
        glColorMaski(i, coin(), coin(), coin(), coin());
        glBlendFuncSeparatei(i, GL_ONE, coin() ? GL_ONE : GL_DST_COLOR, GL_ZERO, GL_SRC_ALPHA);
        glBlendEquationSeparatei(i, coin() ? GL_FUNC_REVERSE_SUBTRACT : GL_MAX, GL_MIN);
    }
}

static void scramble_tests(void) {
    static const GLenum functions[] = {GL_NEVER, GL_NOTEQUAL, GL_GEQUAL, GL_ALWAYS};
    glDepthMask(coin());
    glDepthFunc(functions[below(4)]);
    glStencilFuncSeparate(GL_FRONT, functions[below(4)], 1, 0xff);
    glStencilFuncSeparate(GL_BACK, functions[below(4)], 2, 0x0f);
    glStencilOpSeparate(GL_FRONT_AND_BACK, GL_INVERT, GL_INCR_WRAP, GL_REPLACE);
    glStencilMaskSeparate(GL_FRONT, below(256));
    glStencilMaskSeparate(GL_BACK, below(256));
    glSampleMaski(0, below(2));
    glSampleCoverage(part(), coin());
    glMinSampleShading(part());
    glLogicOp(coin() ? GL_INVERT : GL_NOR);
    glBlendColor(part(), part(), part(), part());
}

static void scramble_raster(void) {
    static const GLenum modes[] = {GL_LINE, GL_POINT, GL_FILL};
    glPolygonMode(GL_FRONT_AND_BACK, modes[below(3)]);
    glPolygonOffset(50.0f * part(), 50.0f);
    glCullFace(coin() ? GL_FRONT_AND_BACK : GL_FRONT);
    glFrontFace(coin() ? GL_CW : GL_CCW);
    glProvokingVertex(coin() ? GL_FIRST_VERTEX_CONVENTION : GL_LAST_VERTEX_CONVENTION);
    glPrimitiveRestartIndex(below(4));
    glPointSize(1.0f + 5.0f * part());
    glPointParameterf(GL_POINT_FADE_THRESHOLD_SIZE, 1.0f + part());
    glPointParameteri(GL_POINT_SPRITE_COORD_ORIGIN, coin() ? GL_LOWER_LEFT : GL_UPPER_LEFT);
    glPatchParameteri(GL_PATCH_VERTICES, 1 + (GLint)below(4));
    glHint(GL_FRAGMENT_SHADER_DERIVATIVE_HINT, coin() ? GL_NICEST : GL_FASTEST);
    glHint(GL_POLYGON_SMOOTH_HINT, coin() ? GL_NICEST : GL_FASTEST);
    glClampColor(GL_CLAMP_READ_COLOR, coin() ? GL_TRUE : GL_FALSE);
    glClipControl(coin() ? GL_UPPER_LEFT : GL_LOWER_LEFT, coin() ? GL_ZERO_TO_ONE : GL_NEGATIVE_ONE_TO_ONE);
    glClearDepth((double)part());
    glClearColor(part(), part(), part(), part());
    glClearStencil((GLint)below(9));
}

static void scramble_pixels(void) {
    static const GLenum counts[] = {
        GL_UNPACK_ROW_LENGTH, GL_UNPACK_SKIP_ROWS, GL_UNPACK_SKIP_PIXELS, GL_UNPACK_IMAGE_HEIGHT, GL_UNPACK_SKIP_IMAGES,
        GL_PACK_ROW_LENGTH,   GL_PACK_SKIP_ROWS,   GL_PACK_SKIP_PIXELS,   GL_PACK_IMAGE_HEIGHT,   GL_PACK_SKIP_IMAGES};
    size_t i;
    for (i = 0; i < sizeof counts / sizeof counts[0]; ++i) glPixelStorei(counts[i], (GLint)below(9));
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1 << below(4));
    glPixelStorei(GL_PACK_ALIGNMENT, 1 << below(4));
    glPixelStorei(GL_UNPACK_SWAP_BYTES, coin());
    glPixelStorei(GL_UNPACK_LSB_FIRST, coin());
    glPixelStorei(GL_PACK_SWAP_BYTES, coin());
}

static void scramble_buffers(void) {
    GLuint i;
    for (i = 0; i < BUFFER_TARGETS; ++i) glBindBuffer(buffer_targets[i], own.buffers[below(2)]);
    for (i = 0; i < 32; ++i)
        glBindBufferRange(GL_UNIFORM_BUFFER, i, own.buffers[below(2)], 256 * (GLintptr)below(4), 512);
    for (i = 0; i < 4; ++i) glBindBufferBase(GL_SHADER_STORAGE_BUFFER, i, own.buffers[below(2)]);
    glBindBuffer(GL_UNIFORM_BUFFER, own.buffers[below(2)]);
}

static void scramble_units(void) {
    GLuint unit;
    int t;
    for (unit = 0; unit < UNITS; ++unit) {
        glActiveTexture(GL_TEXTURE0 + unit);
        for (t = 0; t < TARGETS; ++t) glBindTexture(texture_targets[t], own.textures[t][below(2)]);
        glBindSampler(unit, own.samplers[below(2)]);
    }
    for (unit = 0; unit < 8; ++unit)
        glBindImageTexture(unit, own.textures[below(2)][below(2)], (GLint)below(2), coin(), (GLint)below(2),
                           GL_READ_ONLY, GL_RGBA8);
    glActiveTexture(GL_TEXTURE0 + below(UNITS));
}

static void scramble_objects(void) {
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, own.framebuffers[below(2)]);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, own.framebuffers[below(2)]);
    glBindRenderbuffer(GL_RENDERBUFFER, own.renderbuffer);
    glUseProgram(coin() ? own.program : 0);
    glBindProgramPipeline(own.pipeline);
    glBindTransformFeedback(GL_TRANSFORM_FEEDBACK, own.feedback);
    glBindVertexArray(coin() ? own.vertex_arrays[below(2)] : 0);
    glVertexAttrib4f(1 + below(3), part(), part(), part(), part());
}

void gl_state_scramble(unsigned seed) {
    random_state = seed;
    scramble_capabilities();
    scramble_indexed();
    scramble_tests();
    scramble_raster();
    scramble_pixels();
    scramble_objects();
    scramble_buffers();
    scramble_units();
}

void gl_state_calm_reading(void) {
    glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
    glPixelStorei(GL_PACK_ROW_LENGTH, 0);
    glPixelStorei(GL_PACK_SKIP_ROWS, 0);
    glPixelStorei(GL_PACK_SKIP_PIXELS, 0);
    glPixelStorei(GL_PACK_IMAGE_HEIGHT, 0);
    glPixelStorei(GL_PACK_SKIP_IMAGES, 0);
    glPixelStorei(GL_PACK_SWAP_BYTES, GL_FALSE);
}

/* >> objects */

static void make_texture(int t, int i) {
    const GLenum target = texture_targets[t];
    glBindTexture(target, own.textures[t][i]);
    if (t == 0) glTexStorage2D(target, 2, GL_RGBA8, 8, 8);
    if (t == 1) glTexStorage3D(target, 2, GL_RGBA8, 8, 8, 2);
    if (t < 2) glTexParameteri(target, GL_TEXTURE_BASE_LEVEL, i);
    glBindTexture(target, 0);
}

static GLuint make_program(void) {
    static const char* const texts[2] = {"#version 330 core\nvoid main() { gl_Position = vec4(0.0); }\n",
                                         "#version 330 core\nout vec4 c; void main() { c = vec4(1.0); }\n"};
    static const GLenum stages[2] = {GL_VERTEX_SHADER, GL_FRAGMENT_SHADER};
    const GLuint program = glCreateProgram();
    int i;
    for (i = 0; i < 2; ++i) {
        const GLuint shader = glCreateShader(stages[i]);
        glShaderSource(shader, 1, &texts[i], NULL);
        glCompileShader(shader);
        glAttachShader(program, shader);
        glDeleteShader(shader);
    }
    glLinkProgram(program);
    return program;
}

void gl_state_open(void) {
    int i, t;
    glGenFramebuffers(2, own.framebuffers);
    glGenSamplers(2, own.samplers);
    glGenBuffers(2, own.buffers);
    glGenVertexArrays(2, own.vertex_arrays);
    glGenRenderbuffers(1, &own.renderbuffer);
    glGenProgramPipelines(1, &own.pipeline);
    glGenTransformFeedbacks(1, &own.feedback);
    own.program = make_program();
    for (t = 0; t < TARGETS; ++t) {
        glGenTextures(2, own.textures[t]);
        for (i = 0; i < 2; ++i) make_texture(t, i);
    }
    for (i = 0; i < 2; ++i) {
        glSamplerParameteri(own.samplers[i], GL_TEXTURE_MIN_FILTER, GL_LINEAR);
        glSamplerParameteri(own.samplers[i], GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
        glBindBuffer(GL_COPY_WRITE_BUFFER, own.buffers[i]);
        glBufferData(GL_COPY_WRITE_BUFFER, 4096, NULL, GL_STATIC_DRAW);
        glBindVertexArray(own.vertex_arrays[i]);
        glEnableVertexAttribArray((GLuint)i);
        glVertexAttribDivisor((GLuint)i, 3);
        glBindFramebuffer(GL_FRAMEBUFFER, own.framebuffers[i]);
        glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, own.textures[0][i], i);
    }
    glBindVertexArray(0);
    glBindBuffer(GL_COPY_WRITE_BUFFER, 0);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    discover();
}

void gl_state_close(void) {
    glDeleteFramebuffers(2, own.framebuffers);
    glDeleteTextures(2 * TARGETS, own.textures[0]);
    glDeleteSamplers(2, own.samplers);
    glDeleteBuffers(2, own.buffers);
    glDeleteVertexArrays(2, own.vertex_arrays);
    glDeleteRenderbuffers(1, &own.renderbuffer);
    glDeleteProgramPipelines(1, &own.pipeline);
    glDeleteTransformFeedbacks(1, &own.feedback);
    glDeleteProgram(own.program);
    memset(&own, 0, sizeof own);
}
