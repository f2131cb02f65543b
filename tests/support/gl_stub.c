#include "gl_stub.h"

#include "deepgbuffer.h"
#include "deepgbuffer_gl.h"

#include <epoxy/gl.h> /* for its values: nothing of it is called */

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* >> objects and state */

enum {
    NAMES = 512, /* of one kind; a name is given once */
    UNITS = 48,
    IMAGE_UNITS = 8,
    BINDINGS = 36,
    TOGGLES = 26,
    VIEWPORTS = 16,
    DRAW_BUFFERS = 8,
    ATTACHMENTS = DRAW_BUFFERS + 1, /* depth is the last */
    MAX_RESOURCES = 24,             /* samplers and images of one program */
    MAX_TEXTURE_SIZE = 16384,
    MAX_ARRAY_LAYERS = 2048
};

enum kind { TEXTURE, SAMPLER, FRAMEBUFFER, VERTEX_ARRAY, BUFFER, SHADER, PROGRAM, QUERY, KIND_COUNT };

static const char* const kind_names[KIND_COUNT] = {"texture", "sampler", "framebuffer", "vertex array",
                                                   "buffer",  "shader",  "program",     "query"};

typedef struct texture {
    GLenum target, format;
    int width, height, layers, levels, base, max;
    bool immutable, unflushed; /* drawn to since the last barrier */
} texture;

typedef struct attachment {
    GLuint texture;
    int level, layer; /* -1: all */
} attachment;

typedef struct framebuffer {
    attachment attachments[ATTACHMENTS];
    int draw_count;
    GLenum draw[DRAW_BUFFERS], read;
} framebuffer;

typedef struct shader {
    GLenum stage;
    bool compiled, dead; /* dead: to go with the last program */
    char *source, *text; /* text: preprocessed */
} shader;

typedef struct resource { /* a sampler or an image of a program */
    char name[48];
    GLenum target;
    bool is_image, is_integer;
    int unit;
} resource;

typedef struct program {
    GLuint shaders[3];
    int shader_count;
    bool linked, dead;
    resource resources[MAX_RESOURCES];
    int resource_count;
    char block[48]; /* "" for none */
    GLuint binding;
} program;

/* What a caller can set. */
static struct state {
    GLuint draw_framebuffer, read_framebuffer, program, vertex_array, uniform_buffer, unpack_buffer, query_buffer;
    struct {
        GLuint buffer, pad;
        int64_t start, size;
    } bindings[BINDINGS];
    GLuint active, textures_2d[UNITS], textures_array[UNITS], samplers[UNITS];
    GLint images[IMAGE_UNITS][6];
    float viewports[VIEWPORTS][4];
    double depth_ranges[VIEWPORTS][2];
    GLboolean scissor[VIEWPORTS], blend[DRAW_BUFFERS], color_mask[DRAW_BUFFERS][4], depth_mask;
    GLboolean toggles[TOGGLES];
    GLint depth_func, polygon_mode, clip_origin, clip_depth, unpack[7];
} now;

static struct context {
    gl_stub_desc desc;
    GLenum error;
    int calls, gets, lose_at, refusals, debug_groups;
    char refusal[256];
    unsigned char life[KIND_COUNT][NAMES]; /* NAMED, MADE or DEAD */
    GLuint last[KIND_COUNT];
    texture textures[NAMES];
    framebuffer framebuffers[NAMES];
    shader shaders[NAMES];
    program programs[NAMES];
    size_t buffers[NAMES]; /* bytes */
    bool counted[NAMES];   /* query has a result */
    uint64_t clock;
} c;

enum { NAMED = 1, MADE, DEAD };

/* >> refusals */

#if defined(__GNUC__)
__attribute__((format(printf, 2, 3)))
#endif
static void
refuse(GLenum error, const char* format, ...) {
    va_list arguments;
    if (!c.error) c.error = error;
    if (c.refusals++) return;
    va_start(arguments, format);
    vsnprintf(c.refusal, sizeof c.refusal, format, arguments);
    va_end(arguments);
}

static bool has_extension(const char* name) {
    const size_t length = strlen(name);
    const char* at = c.desc.extensions;
    for (; at && *at; at += strcspn(at, " "), at += strspn(at, " "))
        if (strcspn(at, " ") == length && strncmp(at, name, length) == 0) return true;
    return false;
}

/* Functions that not every context offers: since which version, 0 for never, or by which extension. */
static const struct offer {
    const char* name;
    int since, since_es;
    const char* extension;
} offers[] = {{"glIsEnabledi", 330, 320, NULL},
              {"glEnablei", 330, 320, NULL},
              {"glDisablei", 330, 320, NULL},
              {"glGetBooleani_v", 330, 310, NULL},
              {"glColorMaski", 330, 320, NULL},
              {"glPolygonMode", 330, 0, NULL},
              {"glDepthRangef", 410, 300, "GL_ARB_ES2_compatibility"},
              {"glDepthRange", 330, 0, NULL},
              {"glGetFloati_v", 410, 0, "GL_ARB_viewport_array"},
              {"glGetDoublei_v", 410, 0, "GL_ARB_viewport_array"},
              {"glViewportIndexedf", 410, 0, "GL_ARB_viewport_array"},
              {"glDepthRangeIndexed", 410, 0, "GL_ARB_viewport_array"},
              {"glClipControl", 450, 0, "GL_ARB_clip_control"},
              {"glTextureBarrier", 450, 0, "GL_ARB_texture_barrier"},
              {"glMemoryBarrier", 420, 310, "GL_ARB_shader_image_load_store"},
              {"glBindImageTexture", 420, 310, "GL_ARB_shader_image_load_store"},
              {"glFramebufferTexture", 330, 320, NULL},
              {"glTexStorage2D", 420, 300, "GL_ARB_texture_storage"},
              {"glTexStorage3D", 420, 300, "GL_ARB_texture_storage"},
              {"glObjectLabel", 430, 320, "GL_KHR_debug"},
              {"glPushDebugGroup", 430, 320, "GL_KHR_debug"},
              {"glPopDebugGroup", 430, 320, "GL_KHR_debug"},
              {"glQueryCounter", 330, 0, NULL},
              {"glGetQueryObjectiv", 330, 0, NULL},
              {"glGetQueryObjectui64v", 330, 0, NULL}};

static bool since(int desktop, int es) {
    const int version = c.desc.es ? es : desktop;
    return version && c.desc.version >= version;
}

static bool is_offered(const char* function) {
    size_t i;
    for (i = 0; i < sizeof offers / sizeof offers[0]; ++i)
        if (strcmp(offers[i].name, function) == 0)
            return since(offers[i].since, offers[i].since_es) ||
                   (!c.desc.es && offers[i].extension && has_extension(offers[i].extension));
    return true;
}

/* Every function begins with it. A lost context refuses all, and does nothing. */
static bool enter(const char* function) {
    c.gets += strncmp(function, "glGet", 5) == 0 || strncmp(function, "glIs", 4) == 0;
    if (++c.calls >= c.lose_at && c.lose_at) {
        c.error = GL_CONTEXT_LOST;
        return false;
    }
    if (is_offered(function)) return true;
    refuse(GL_INVALID_OPERATION, "%s: not offered by this context", function);
    return false;
}

#define ENTER(function) \
    if (!enter("gl" #function)) return
#define ENTER_OR(function, value) \
    if (!enter("gl" #function)) return value

/* >> names */

static bool is_name(enum kind kind, GLuint name) {
    return name && name < NAMES && (c.life[kind][name] == NAMED || c.life[kind][name] == MADE);
}

/* Whether it may be bound: 0, or a living name, which is an object from now on. */
static bool make(enum kind kind, GLuint name, const char* function) {
    if (!name) return true;
    if (!is_name(kind, name)) {
        refuse(GL_INVALID_OPERATION, "%s: %u is the name of no %s", function, name, kind_names[kind]);
        return false;
    }
    c.life[kind][name] = MADE;
    return true;
}

static GLuint new_name(enum kind kind, int life) {
    if (c.last[kind] + 1 >= NAMES) {
        refuse(GL_OUT_OF_MEMORY, "no names left for a %s", kind_names[kind]);
        return 0;
    }
    c.life[kind][++c.last[kind]] = (unsigned char)life;
    return c.last[kind];
}

static void new_names(enum kind kind, int count, GLuint* names) {
    int i;
    for (i = 0; i < count; ++i) names[i] = new_name(kind, NAMED);
}

static void clear_binding(GLuint* binding, GLuint name) {
    if (*binding == name) *binding = 0;
}

static void unbind_texture(GLuint name) {
    GLuint bound[2];
    int i, k;
    for (i = 0; i < UNITS; ++i) {
        clear_binding(&now.textures_2d[i], name);
        clear_binding(&now.textures_array[i], name);
    }
    for (i = 0; i < IMAGE_UNITS; ++i)
        if (now.images[i][0] == (GLint)name) now.images[i][0] = 0;
    bound[0] = now.draw_framebuffer, bound[1] = now.read_framebuffer;
    for (i = 0; i < 2; ++i)
        for (k = 0; bound[i] && k < ATTACHMENTS; ++k)
            clear_binding(&c.framebuffers[bound[i]].attachments[k].texture, name);
}

static void unbind(enum kind kind, GLuint name) {
    int i;
    if (kind == TEXTURE) unbind_texture(name);
    for (i = 0; kind == SAMPLER && i < UNITS; ++i) clear_binding(&now.samplers[i], name);
    if (kind == FRAMEBUFFER) {
        clear_binding(&now.draw_framebuffer, name);
        clear_binding(&now.read_framebuffer, name);
    }
    if (kind == VERTEX_ARRAY) clear_binding(&now.vertex_array, name);
    if (kind != BUFFER) return;
    clear_binding(&now.uniform_buffer, name);
    clear_binding(&now.unpack_buffer, name);
    clear_binding(&now.query_buffer, name);
    for (i = 0; i < BINDINGS; ++i)
        if (now.bindings[i].buffer == name) memset(&now.bindings[i], 0, sizeof now.bindings[i]);
}

/* As GL: 0 and what is no name are ignored, but the library has no reason to hand out a name that is dead. */
static void delete_names(enum kind kind, int count, const GLuint* names) {
    int i;
    for (i = 0; i < count; ++i) {
        if (!names[i]) continue;
        if (!is_name(kind, names[i])) {
            refuse(GL_NO_ERROR, "%s %u is deleted, but is none", kind_names[kind], names[i]);
            continue;
        }
        unbind(kind, names[i]);
        c.life[kind][names[i]] = DEAD;
    }
}

int gl_stub_alive(void) {
    int kind, name, count = 0;
    for (kind = 0; kind < KIND_COUNT; ++kind)
        for (name = 1; name < NAMES; ++name) count += is_name((enum kind)kind, (GLuint)name);
    return count;
}

/* >> strings, values, errors */

static const GLubyte* stub_GetString(GLenum name) {
    static char version[64];
    ENTER_OR(GetString, NULL);
    snprintf(version, sizeof version, "%s%d.%d stub", c.desc.es ? "OpenGL ES " : "", c.desc.version / 100,
             c.desc.version / 10 % 10);
    if (name == GL_VERSION) return (const GLubyte*)version;
    if (name == GL_RENDERER) return (const GLubyte*)(c.desc.renderer ? c.desc.renderer : "stub");
    refuse(GL_INVALID_ENUM, "glGetString: 0x%04x", name);
    return NULL;
}

static const GLubyte* stub_GetStringi(GLenum name, GLuint index) {
    static char word[64];
    const char* at = c.desc.extensions ? c.desc.extensions : "";
    ENTER_OR(GetStringi, NULL);
    if (name != GL_EXTENSIONS) refuse(GL_INVALID_ENUM, "glGetStringi: 0x%04x", name);
    for (; index && *at; --index, at += strcspn(at, " "), at += strspn(at, " ")) {}
    snprintf(word, sizeof word, "%.*s", (int)strcspn(at, " "), at);
    return (const GLubyte*)word;
}

static int extension_count(void) {
    const char* at = c.desc.extensions;
    int count = 0;
    for (; at && *at; at += strcspn(at, " "), at += strspn(at, " ")) ++count;
    return count;
}

static GLenum stub_GetError(void) {
    const GLenum error = c.error;
    ENTER_OR(GetError, c.error);
    c.error = GL_NO_ERROR;
    return error;
}

static const GLenum unpack_names[7] = {GL_UNPACK_ROW_LENGTH, GL_UNPACK_SKIP_ROWS,    GL_UNPACK_SKIP_PIXELS,
                                       GL_UNPACK_ALIGNMENT,  GL_UNPACK_IMAGE_HEIGHT, GL_UNPACK_SKIP_IMAGES,
                                       GL_UNPACK_SWAP_BYTES};

static GLint* unpack_of(GLenum name) {
    int i;
    for (i = 0; i < (c.desc.es ? 6 : 7); ++i)
        if (unpack_names[i] == name) return &now.unpack[i];
    return NULL;
}

static bool get_limit(GLenum name, GLint* value) {
    switch (name) {
    case GL_MAJOR_VERSION: *value = c.desc.version / 100; return true;
    case GL_MINOR_VERSION: *value = c.desc.version / 10 % 10; return true;
    case GL_NUM_EXTENSIONS: *value = extension_count(); return true;
    case GL_MAX_TEXTURE_SIZE: *value = MAX_TEXTURE_SIZE; return true;
    case GL_MAX_ARRAY_TEXTURE_LAYERS: *value = MAX_ARRAY_LAYERS; return true;
    case GL_MAX_COMBINED_TEXTURE_IMAGE_UNITS: *value = UNITS; return true;
    case GL_MAX_UNIFORM_BUFFER_BINDINGS: *value = BINDINGS; return true;
    case GL_MAX_GEOMETRY_OUTPUT_VERTICES: *value = 256; return since(330, 320);
    default: return false;
    }
}

static bool has_query_buffers(void) { return since(440, 0) || has_extension("GL_ARB_query_buffer_object"); }

static bool get_binding(GLenum name, GLint* value) {
    const GLuint unit = now.active;
    switch (name) {
    case GL_DRAW_FRAMEBUFFER_BINDING: *value = (GLint)now.draw_framebuffer; return true;
    case GL_READ_FRAMEBUFFER_BINDING: *value = (GLint)now.read_framebuffer; return true;
    case GL_CURRENT_PROGRAM: *value = (GLint)now.program; return true;
    case GL_VERTEX_ARRAY_BINDING: *value = (GLint)now.vertex_array; return true;
    case GL_UNIFORM_BUFFER_BINDING: *value = (GLint)now.uniform_buffer; return true;
    case GL_PIXEL_UNPACK_BUFFER_BINDING: *value = (GLint)now.unpack_buffer; return true;
    case GL_QUERY_BUFFER_BINDING: *value = (GLint)now.query_buffer; return has_query_buffers();
    case GL_ACTIVE_TEXTURE: *value = (GLint)(GL_TEXTURE0 + unit); return true;
    case GL_TEXTURE_BINDING_2D: *value = (GLint)now.textures_2d[unit]; return true;
    case GL_TEXTURE_BINDING_2D_ARRAY: *value = (GLint)now.textures_array[unit]; return true;
    case GL_SAMPLER_BINDING: *value = (GLint)now.samplers[unit]; return true;
    default: return false;
    }
}

static bool get_raster(GLenum name, GLint* value) {
    int i;
    switch (name) {
    case GL_DEPTH_WRITEMASK: *value = now.depth_mask; return true;
    case GL_DEPTH_FUNC: *value = now.depth_func; return true;
    case GL_COLOR_WRITEMASK:
        for (i = 0; i < 4; ++i) value[i] = now.color_mask[0][i];
        return true;
    case GL_POLYGON_MODE: value[0] = value[1] = now.polygon_mode; return !c.desc.es;
    case GL_CLIP_ORIGIN: *value = now.clip_origin; return is_offered("glClipControl");
    case GL_CLIP_DEPTH_MODE: *value = now.clip_depth; return is_offered("glClipControl");
    default: return false;
    }
}

static void stub_GetIntegerv(GLenum name, GLint* value) {
    ENTER(GetIntegerv);
    if (get_limit(name, value) || get_binding(name, value) || get_raster(name, value)) return;
    if (unpack_of(name))
        *value = *unpack_of(name);
    else
        refuse(GL_INVALID_ENUM, "glGetIntegerv: 0x%04x", name);
}

static void stub_GetFloatv(GLenum name, GLfloat* value) {
    ENTER(GetFloatv);
    if (name == GL_VIEWPORT) {
        memcpy(value, now.viewports[0], sizeof now.viewports[0]);
    } else if (name == GL_DEPTH_RANGE) {
        value[0] = (float)now.depth_ranges[0][0];
        value[1] = (float)now.depth_ranges[0][1];
    } else {
        refuse(GL_INVALID_ENUM, "glGetFloatv: 0x%04x", name);
    }
}

static void stub_GetInteger64v(GLenum name, GLint64* value) {
    ENTER(GetInteger64v);
    if (name == GL_TIMESTAMP && !c.desc.es)
        *value = (GLint64)(c.clock += 1000);
    else
        refuse(GL_INVALID_ENUM, "glGetInteger64v: 0x%04x", name);
}

static void stub_GetInteger64i_v(GLenum name, GLuint index, GLint64* value) {
    ENTER(GetInteger64i_v);
    if (index >= BINDINGS)
        refuse(GL_INVALID_VALUE, "glGetInteger64i_v: binding %u", index);
    else if (name == GL_UNIFORM_BUFFER_START)
        *value = now.bindings[index].start;
    else if (name == GL_UNIFORM_BUFFER_SIZE)
        *value = now.bindings[index].size;
    else
        refuse(GL_INVALID_ENUM, "glGetInteger64i_v: 0x%04x", name);
}

static const GLenum image_properties[6] = {GL_IMAGE_BINDING_NAME,  GL_IMAGE_BINDING_LEVEL,  GL_IMAGE_BINDING_LAYERED,
                                           GL_IMAGE_BINDING_LAYER, GL_IMAGE_BINDING_ACCESS, GL_IMAGE_BINDING_FORMAT};

static void stub_GetIntegeri_v(GLenum name, GLuint index, GLint* value) {
    int i;
    ENTER(GetIntegeri_v);
    if (name == GL_UNIFORM_BUFFER_BINDING && index < BINDINGS) {
        *value = (GLint)now.bindings[index].buffer;
        return;
    }
    for (i = 0; i < 6; ++i)
        if (name == image_properties[i] && index < IMAGE_UNITS && is_offered("glBindImageTexture")) {
            *value = now.images[index][i];
            return;
        }
    refuse(GL_INVALID_ENUM, "glGetIntegeri_v: 0x%04x, %u", name, index);
}

static void stub_Finish(void) { ENTER(Finish); }

/* >> rasterisation */

/* Capabilities, since when. Blend and scissor have an index. */
static const struct toggle {
    GLenum name;
    int since, since_es;
} toggles[] = {{GL_DEPTH_TEST, 330, 300},
               {GL_STENCIL_TEST, 330, 300},
               {GL_CULL_FACE, 330, 300},
               {GL_DITHER, 330, 300},
               {GL_POLYGON_OFFSET_FILL, 330, 300},
               {GL_SAMPLE_ALPHA_TO_COVERAGE, 330, 300},
               {GL_SAMPLE_COVERAGE, 330, 300},
               {GL_RASTERIZER_DISCARD, 330, 300},
               {GL_PRIMITIVE_RESTART_FIXED_INDEX, 430, 300},
               {GL_SAMPLE_MASK, 330, 310},
               {GL_COLOR_LOGIC_OP, 330, 0},
               {GL_MULTISAMPLE, 330, 0},
               {GL_DEPTH_CLAMP, 330, 0},
               {GL_PRIMITIVE_RESTART, 330, 0},
               {GL_FRAMEBUFFER_SRGB, 330, 0},
               {GL_CLIP_DISTANCE0, 330, 0},
               {GL_CLIP_DISTANCE1, 330, 0},
               {GL_CLIP_DISTANCE2, 330, 0},
               {GL_CLIP_DISTANCE3, 330, 0},
               {GL_CLIP_DISTANCE4, 330, 0},
               {GL_CLIP_DISTANCE5, 330, 0},
               {GL_CLIP_DISTANCE6, 330, 0},
               {GL_CLIP_DISTANCE7, 330, 0},
               {GL_POLYGON_SMOOTH, 330, 0},
               {GL_POLYGON_OFFSET_POINT, 330, 0},
               {GL_POLYGON_OFFSET_LINE, 330, 0}};

/* Null, and refused, when there is none. */
static GLboolean* toggle_of(GLenum name, const char* function) {
    int i;
    if (name == GL_BLEND) return &now.blend[0];
    if (name == GL_SCISSOR_TEST) return &now.scissor[0];
    for (i = 0; i < TOGGLES; ++i)
        if (toggles[i].name == name && since(toggles[i].since, toggles[i].since_es)) return &now.toggles[i];
    refuse(GL_INVALID_ENUM, "%s: 0x%04x", function, name);
    return NULL;
}

static GLboolean* indexed_toggle(GLenum name, GLuint index, const char* function) {
    if (name == GL_BLEND && index < DRAW_BUFFERS) return &now.blend[index];
    if (name == GL_SCISSOR_TEST && index < VIEWPORTS && is_offered("glViewportIndexedf")) return &now.scissor[index];
    refuse(GL_INVALID_ENUM, "%s: 0x%04x, %u", function, name, index);
    return NULL;
}

static void set_toggle(GLenum name, GLboolean on, const char* function) {
    GLboolean* first = toggle_of(name, function);
    if (first == &now.blend[0])
        memset(now.blend, on, sizeof now.blend);
    else if (first == &now.scissor[0])
        memset(now.scissor, on, sizeof now.scissor);
    else if (first)
        *first = on;
}

static void stub_Enable(GLenum name) {
    ENTER(Enable);
    set_toggle(name, GL_TRUE, "glEnable");
}

static void stub_Disable(GLenum name) {
    ENTER(Disable);
    set_toggle(name, GL_FALSE, "glDisable");
}

static GLboolean stub_IsEnabled(GLenum name) {
    const GLboolean* toggle;
    ENTER_OR(IsEnabled, GL_FALSE);
    toggle = toggle_of(name, "glIsEnabled");
    return toggle ? *toggle : GL_FALSE;
}

static void stub_Enablei(GLenum name, GLuint index) {
    GLboolean* toggle;
    ENTER(Enablei);
    toggle = indexed_toggle(name, index, "glEnablei");
    if (toggle) *toggle = GL_TRUE;
}

static void stub_Disablei(GLenum name, GLuint index) {
    GLboolean* toggle;
    ENTER(Disablei);
    toggle = indexed_toggle(name, index, "glDisablei");
    if (toggle) *toggle = GL_FALSE;
}

static GLboolean stub_IsEnabledi(GLenum name, GLuint index) {
    const GLboolean* toggle;
    ENTER_OR(IsEnabledi, GL_FALSE);
    toggle = indexed_toggle(name, index, "glIsEnabledi");
    return toggle ? *toggle : GL_FALSE;
}

static void stub_GetBooleani_v(GLenum name, GLuint index, GLboolean* value) {
    ENTER(GetBooleani_v);
    if (name == GL_COLOR_WRITEMASK && index < DRAW_BUFFERS)
        memcpy(value, now.color_mask[index], 4);
    else
        refuse(GL_INVALID_ENUM, "glGetBooleani_v: 0x%04x, %u", name, index);
}

static void stub_ColorMaski(GLuint index, GLboolean r, GLboolean g, GLboolean b, GLboolean a) {
    const GLboolean mask[4] = {r, g, b, a};
    ENTER(ColorMaski);
    if (index < DRAW_BUFFERS)
        memcpy(now.color_mask[index], mask, 4);
    else
        refuse(GL_INVALID_VALUE, "glColorMaski: %u", index);
}

static void stub_ColorMask(GLboolean r, GLboolean g, GLboolean b, GLboolean a) {
    const GLboolean mask[4] = {r, g, b, a};
    int i;
    ENTER(ColorMask);
    for (i = 0; i < DRAW_BUFFERS; ++i) memcpy(now.color_mask[i], mask, 4);
}

static void stub_DepthMask(GLboolean on) {
    ENTER(DepthMask);
    now.depth_mask = on;
}

static void stub_DepthFunc(GLenum function) {
    ENTER(DepthFunc);
    if (function >= GL_NEVER && function <= GL_ALWAYS)
        now.depth_func = (GLint)function;
    else
        refuse(GL_INVALID_ENUM, "glDepthFunc: 0x%04x", function);
}

static void stub_PolygonMode(GLenum face, GLenum mode) {
    ENTER(PolygonMode);
    if (face == GL_FRONT_AND_BACK && mode >= GL_POINT && mode <= GL_FILL)
        now.polygon_mode = (GLint)mode;
    else
        refuse(GL_INVALID_ENUM, "glPolygonMode: 0x%04x, 0x%04x", face, mode);
}

static void set_viewport(GLuint index, float x, float y, float width, float height, const char* function) {
    const float viewport[4] = {x, y, width, height};
    if (index >= VIEWPORTS || !(width >= 0.0f) || !(height >= 0.0f))
        refuse(GL_INVALID_VALUE, "%s: %u, %g x %g", function, index, (double)width, (double)height);
    else
        memcpy(now.viewports[index], viewport, sizeof viewport);
}

static void stub_Viewport(GLint x, GLint y, GLsizei width, GLsizei height) {
    GLuint i;
    ENTER(Viewport);
    for (i = 0; i < VIEWPORTS; ++i) set_viewport(i, (float)x, (float)y, (float)width, (float)height, "glViewport");
}

static void stub_ViewportIndexedf(GLuint index, float x, float y, float width, float height) {
    ENTER(ViewportIndexedf);
    set_viewport(index, x, y, width, height, "glViewportIndexedf");
}

static void set_depth_ranges(double near_value, double far_value) {
    int i;
    for (i = 0; i < VIEWPORTS; ++i) now.depth_ranges[i][0] = near_value, now.depth_ranges[i][1] = far_value;
}

static void stub_DepthRange(double near_value, double far_value) {
    ENTER(DepthRange);
    set_depth_ranges(near_value, far_value);
}

static void stub_DepthRangef(float near_value, float far_value) {
    ENTER(DepthRangef);
    set_depth_ranges((double)near_value, (double)far_value);
}

static void stub_DepthRangeIndexed(GLuint index, double near_value, double far_value) {
    ENTER(DepthRangeIndexed);
    if (index < VIEWPORTS)
        now.depth_ranges[index][0] = near_value, now.depth_ranges[index][1] = far_value;
    else
        refuse(GL_INVALID_VALUE, "glDepthRangeIndexed: %u", index);
}

static void stub_GetFloati_v(GLenum name, GLuint index, float* value) {
    ENTER(GetFloati_v);
    if (name == GL_VIEWPORT && index < VIEWPORTS)
        memcpy(value, now.viewports[index], sizeof now.viewports[index]);
    else
        refuse(GL_INVALID_ENUM, "glGetFloati_v: 0x%04x, %u", name, index);
}

static void stub_GetDoublei_v(GLenum name, GLuint index, double* value) {
    ENTER(GetDoublei_v);
    if (name == GL_DEPTH_RANGE && index < VIEWPORTS)
        memcpy(value, now.depth_ranges[index], sizeof now.depth_ranges[index]);
    else
        refuse(GL_INVALID_ENUM, "glGetDoublei_v: 0x%04x, %u", name, index);
}

static void stub_ClipControl(GLenum origin, GLenum depth) {
    ENTER(ClipControl);
    if ((origin != GL_LOWER_LEFT && origin != GL_UPPER_LEFT) ||
        (depth != GL_NEGATIVE_ONE_TO_ONE && depth != GL_ZERO_TO_ONE))
        refuse(GL_INVALID_ENUM, "glClipControl: 0x%04x, 0x%04x", origin, depth);
    now.clip_origin = (GLint)origin;
    now.clip_depth = (GLint)depth;
}

static void stub_PixelStorei(GLenum name, GLint value) {
    ENTER(PixelStorei);
    if (unpack_of(name) && value >= 0)
        *unpack_of(name) = value;
    else
        refuse(GL_INVALID_ENUM, "glPixelStorei: 0x%04x, %d", name, value);
}

/* >> textures, samplers */

static const struct format {
    GLenum internal, format, type;
    bool depth, integer;
} formats[] = {{GL_R8, GL_RED, GL_UNSIGNED_BYTE, false, false},
               {GL_RG8, GL_RG, GL_UNSIGNED_BYTE, false, false},
               {GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE, false, false},
               {GL_R11F_G11F_B10F, GL_RGB, GL_FLOAT, false, false},
               {GL_RG16F, GL_RG, GL_FLOAT, false, false},
               {GL_RGBA16F, GL_RGBA, GL_FLOAT, false, false},
               {GL_R32F, GL_RED, GL_FLOAT, false, false},
               {GL_RG32F, GL_RG, GL_FLOAT, false, false},
               {GL_RGBA32F, GL_RGBA, GL_FLOAT, false, false},
               {GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, false, true},
               {GL_RG32UI, GL_RG_INTEGER, GL_UNSIGNED_INT, false, true},
               {GL_RGBA32UI, GL_RGBA_INTEGER, GL_UNSIGNED_INT, false, true},
               {GL_DEPTH_COMPONENT16, GL_DEPTH_COMPONENT, GL_UNSIGNED_INT, true, false},
               {GL_DEPTH_COMPONENT24, GL_DEPTH_COMPONENT, GL_UNSIGNED_INT, true, false},
               {GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GL_FLOAT, true, false}};

static const struct format* format_of(GLenum internal) {
    size_t i;
    for (i = 0; i < sizeof formats / sizeof formats[0]; ++i)
        if (formats[i].internal == internal) return &formats[i];
    return NULL;
}

static GLuint* bound_texture(GLenum target, const char* function) {
    if (target == GL_TEXTURE_2D) return &now.textures_2d[now.active];
    if (target == GL_TEXTURE_2D_ARRAY) return &now.textures_array[now.active];
    refuse(GL_INVALID_ENUM, "%s: target 0x%04x", function, target);
    return NULL;
}

/* The texture bound to a target, to be changed. Null, and refused, for the default texture, which is nobody's. */
static texture* current_texture(GLenum target, const char* function) {
    const GLuint* name = bound_texture(target, function);
    if (!name) return NULL;
    if (!*name) refuse(GL_INVALID_OPERATION, "%s: texture 0", function);
    return *name ? &c.textures[*name] : NULL;
}

static void stub_GenTextures(GLsizei count, GLuint* names) {
    ENTER(GenTextures);
    new_names(TEXTURE, count, names);
}

static void stub_DeleteTextures(GLsizei count, const GLuint* names) {
    ENTER(DeleteTextures);
    delete_names(TEXTURE, count, names);
}

static void stub_ActiveTexture(GLenum unit) {
    ENTER(ActiveTexture);
    if (unit - GL_TEXTURE0 < UNITS)
        now.active = unit - GL_TEXTURE0;
    else
        refuse(GL_INVALID_ENUM, "glActiveTexture: unit %u", unit - GL_TEXTURE0);
}

static void stub_BindTexture(GLenum target, GLuint name) {
    GLuint* bound;
    ENTER(BindTexture);
    bound = bound_texture(target, "glBindTexture");
    if (!bound || !make(TEXTURE, name, "glBindTexture")) return;
    *bound = name;
    if (!name) return;
    if (!c.textures[name].target) c.textures[name].target = target, c.textures[name].max = 1000;
    if (c.textures[name].target != target) refuse(GL_INVALID_OPERATION, "glBindTexture: another target before");
}

static void stub_TexParameteri(GLenum target, GLenum name, GLint value) {
    texture* t;
    ENTER(TexParameteri);
    t = current_texture(target, "glTexParameteri");
    if (!t) return;
    switch (name) {
    case GL_TEXTURE_BASE_LEVEL: t->base = value; break;
    case GL_TEXTURE_MAX_LEVEL: t->max = value; break;
    case GL_TEXTURE_MIN_FILTER:
    case GL_TEXTURE_MAG_FILTER:
    case GL_TEXTURE_WRAP_S:
    case GL_TEXTURE_WRAP_T: break;
    default: refuse(GL_INVALID_ENUM, "glTexParameteri: 0x%04x", name);
    }
}

static bool size_ok(int width, int height, int layers, const char* function) {
    const bool ok = width > 0 && height > 0 && layers > 0 && width <= MAX_TEXTURE_SIZE && height <= MAX_TEXTURE_SIZE &&
                    layers <= MAX_ARRAY_LAYERS;
    if (!ok) refuse(GL_INVALID_VALUE, "%s: %d x %d x %d", function, width, height, layers);
    return ok;
}

static void store(GLenum target, int levels, GLenum internal, int width, int height, int layers, const char* function) {
    texture* t = current_texture(target, function);
    if (!t || !size_ok(width, height, layers, function)) return;
    if (t->immutable) refuse(GL_INVALID_OPERATION, "%s: it has storage", function);
    if (!format_of(internal)) refuse(GL_INVALID_ENUM, "%s: format 0x%04x", function, internal);
    if (levels < 1 || (width | height) >> (levels - 1) == 0)
        refuse(GL_INVALID_OPERATION, "%s: %d levels of %d x %d", function, levels, width, height);
    t->format = internal;
    t->width = width, t->height = height, t->layers = layers, t->levels = levels;
    t->immutable = true;
}

static void stub_TexStorage2D(GLenum target, GLsizei levels, GLenum internal, GLsizei width, GLsizei height) {
    ENTER(TexStorage2D);
    store(target, levels, internal, width, height, 1, "glTexStorage2D");
}

static void stub_TexStorage3D(GLenum target, GLsizei levels, GLenum internal, GLsizei width, GLsizei height,
                              GLsizei layers) {
    ENTER(TexStorage3D);
    store(target, levels, internal, width, height, layers, "glTexStorage3D");
}

/* One level. Each is half as large as the one before, rounded down. */
static void store_level(GLenum target, int level, GLenum internal, int width, int height, int layers, GLenum format,
                        GLenum type, const char* function) {
    texture* t = current_texture(target, function);
    const struct format* f = format_of(internal);
    if (!t || !size_ok(width, height, layers, function)) return;
    if (t->immutable) refuse(GL_INVALID_OPERATION, "%s: its storage is immutable", function);
    if (!f || f->format != format || f->type != type)
        refuse(GL_INVALID_OPERATION, "%s: 0x%04x from 0x%04x, 0x%04x", function, internal, format, type);
    if (level == 0) {
        t->width = width, t->height = height, t->layers = layers, t->format = internal;
        t->levels = 1;
    } else if (level == t->levels && width == t->width >> level && height == t->height >> level &&
               layers == t->layers && internal == t->format) {
        ++t->levels;
    } else if (level <= t->levels) { /* beyond a gap there is nothing to compare with */
        refuse(GL_INVALID_OPERATION, "%s: level %d is not of the chain", function, level);
    }
}

static void stub_TexImage2D(GLenum target, GLint level, GLint internal, GLsizei width, GLsizei height, GLint border,
                            GLenum format, GLenum type, const void* pixels) {
    (void)pixels;
    ENTER(TexImage2D);
    if (border || now.unpack_buffer) refuse(GL_INVALID_VALUE, "glTexImage2D: a border or an unpack buffer");
    store_level(target, level, (GLenum)internal, width, height, 1, format, type, "glTexImage2D");
}

static void stub_TexImage3D(GLenum target, GLint level, GLint internal, GLsizei width, GLsizei height, GLsizei layers,
                            GLint border, GLenum format, GLenum type, const void* pixels) {
    (void)pixels;
    ENTER(TexImage3D);
    if (border || now.unpack_buffer) refuse(GL_INVALID_VALUE, "glTexImage3D: a border or an unpack buffer");
    store_level(target, level, (GLenum)internal, width, height, layers, format, type, "glTexImage3D");
}

static void stub_TexSubImage2D(GLenum target, GLint level, GLint x, GLint y, GLsizei width, GLsizei height,
                               GLenum format, GLenum type, const void* pixels) {
    const texture* t;
    const struct format* f;
    ENTER(TexSubImage2D);
    t = current_texture(target, "glTexSubImage2D");
    f = t ? format_of(t->format) : NULL;
    if (!f || level >= t->levels || x < 0 || y < 0 || x + width > t->width >> level || y + height > t->height >> level)
        refuse(GL_INVALID_VALUE, "glTexSubImage2D: outside of the texture");
    else if (f->format != format || f->type != type || !pixels || now.unpack_buffer)
        refuse(GL_INVALID_OPERATION, "glTexSubImage2D: 0x%04x, 0x%04x", format, type);
}

static void stub_GenSamplers(GLsizei count, GLuint* names) {
    ENTER(GenSamplers);
    new_names(SAMPLER, count, names);
}

static void stub_DeleteSamplers(GLsizei count, const GLuint* names) {
    ENTER(DeleteSamplers);
    delete_names(SAMPLER, count, names);
}

static void stub_BindSampler(GLuint unit, GLuint name) {
    ENTER(BindSampler);
    if (unit >= UNITS)
        refuse(GL_INVALID_VALUE, "glBindSampler: unit %u", unit);
    else if (make(SAMPLER, name, "glBindSampler"))
        now.samplers[unit] = name;
}

static void stub_SamplerParameteri(GLuint name, GLenum parameter, GLint value) {
    (void)value;
    ENTER(SamplerParameteri);
    if (!is_name(SAMPLER, name)) refuse(GL_INVALID_OPERATION, "glSamplerParameteri: no sampler %u", name);
    if (parameter != GL_TEXTURE_MIN_FILTER && parameter != GL_TEXTURE_MAG_FILTER && parameter != GL_TEXTURE_WRAP_S &&
        parameter != GL_TEXTURE_WRAP_T && parameter != GL_TEXTURE_COMPARE_MODE)
        refuse(GL_INVALID_ENUM, "glSamplerParameteri: 0x%04x", parameter);
}

static void stub_BindImageTexture(GLuint unit, GLuint name, GLint level, GLboolean layered, GLint layer, GLenum access,
                                  GLenum format) {
    const GLint image[6] = {(GLint)name, level, layered, layer, (GLint)access, (GLint)format};
    ENTER(BindImageTexture);
    if (unit >= IMAGE_UNITS || level < 0 || layer < 0)
        refuse(GL_INVALID_VALUE, "glBindImageTexture: unit %u, level %d, layer %d", unit, level, layer);
    else if (name && !is_name(TEXTURE, name))
        refuse(GL_INVALID_VALUE, "glBindImageTexture: no texture %u", name);
    else
        memcpy(now.images[unit], image, sizeof image);
}

/* >> barriers */

static void stub_TextureBarrier(void) {
    int i;
    ENTER(TextureBarrier);
    for (i = 0; i < NAMES; ++i) c.textures[i].unflushed = false;
}

static void stub_MemoryBarrier(GLbitfield bits) {
    (void)bits;
    ENTER(MemoryBarrier);
}

/* >> framebuffers */

static void stub_GenFramebuffers(GLsizei count, GLuint* names) {
    ENTER(GenFramebuffers);
    new_names(FRAMEBUFFER, count, names);
}

static void stub_DeleteFramebuffers(GLsizei count, const GLuint* names) {
    ENTER(DeleteFramebuffers);
    delete_names(FRAMEBUFFER, count, names);
}

static void stub_BindFramebuffer(GLenum target, GLuint name) {
    ENTER(BindFramebuffer);
    if (target != GL_FRAMEBUFFER && target != GL_DRAW_FRAMEBUFFER && target != GL_READ_FRAMEBUFFER)
        refuse(GL_INVALID_ENUM, "glBindFramebuffer: 0x%04x", target);
    if (!make(FRAMEBUFFER, name, "glBindFramebuffer")) return;
    if (target != GL_READ_FRAMEBUFFER) now.draw_framebuffer = name;
    if (target != GL_DRAW_FRAMEBUFFER) now.read_framebuffer = name;
}

/* The default framebuffer is the caller's. */
static framebuffer* current_framebuffer(const char* function) {
    if (!now.draw_framebuffer) refuse(GL_INVALID_OPERATION, "%s: the default framebuffer", function);
    return now.draw_framebuffer ? &c.framebuffers[now.draw_framebuffer] : NULL;
}

static void attach(GLenum where, GLuint name, GLenum target, int level, int layer, const char* function) {
    framebuffer* f = current_framebuffer(function);
    const int i = where == GL_DEPTH_ATTACHMENT ? DRAW_BUFFERS : (int)(where - GL_COLOR_ATTACHMENT0);
    const texture* t = is_name(TEXTURE, name) ? &c.textures[name] : NULL;
    if (!f) return;
    if (i < 0 || i >= ATTACHMENTS) {
        refuse(GL_INVALID_ENUM, "%s: attachment 0x%04x", function, where);
    } else if (!t || t->target != target || level < 0 || level >= t->levels || layer >= t->layers) {
        refuse(GL_INVALID_OPERATION, "%s: texture %u, level %d, layer %d", function, name, level, layer);
    } else {
        f->attachments[i].texture = name;
        f->attachments[i].level = level, f->attachments[i].layer = layer;
    }
}

static void stub_FramebufferTexture2D(GLenum target, GLenum where, GLenum texture_target, GLuint name, GLint level) {
    ENTER(FramebufferTexture2D);
    if (target != GL_FRAMEBUFFER || texture_target != GL_TEXTURE_2D)
        refuse(GL_INVALID_ENUM, "glFramebufferTexture2D: 0x%04x, 0x%04x", target, texture_target);
    attach(where, name, GL_TEXTURE_2D, level, 0, "glFramebufferTexture2D");
}

static void stub_FramebufferTextureLayer(GLenum target, GLenum where, GLuint name, GLint level, GLint layer) {
    ENTER(FramebufferTextureLayer);
    if (target != GL_FRAMEBUFFER || layer < 0)
        refuse(GL_INVALID_ENUM, "glFramebufferTextureLayer: 0x%04x, %d", target, layer);
    attach(where, name, GL_TEXTURE_2D_ARRAY, level, layer, "glFramebufferTextureLayer");
}

static void stub_FramebufferTexture(GLenum target, GLenum where, GLuint name, GLint level) {
    ENTER(FramebufferTexture);
    if (target != GL_FRAMEBUFFER) refuse(GL_INVALID_ENUM, "glFramebufferTexture: 0x%04x", target);
    attach(where, name, GL_TEXTURE_2D_ARRAY, level, -1, "glFramebufferTexture");
}

static bool attachment_complete(const attachment* a, bool depth, bool layered) {
    const texture* t = &c.textures[a->texture];
    return is_name(TEXTURE, a->texture) && t->levels > a->level && t->layers > a->layer && format_of(t->format) &&
           format_of(t->format)->depth == depth && (a->layer < 0) == layered;
}

static bool is_complete(const framebuffer* f) {
    int i, count = 0;
    bool layered = false;
    for (i = 0; i < ATTACHMENTS; ++i) {
        const attachment* a = &f->attachments[i];
        if (!a->texture) continue;
        if (!count++) layered = a->layer < 0;
        if (!attachment_complete(a, i == DRAW_BUFFERS, layered)) return false;
    }
    return count > 0;
}

static GLenum stub_CheckFramebufferStatus(GLenum target) {
    ENTER_OR(CheckFramebufferStatus, 0);
    if (target != GL_FRAMEBUFFER) refuse(GL_INVALID_ENUM, "glCheckFramebufferStatus: 0x%04x", target);
    if (!now.draw_framebuffer) return GL_FRAMEBUFFER_COMPLETE;
    return is_complete(&c.framebuffers[now.draw_framebuffer]) ? GL_FRAMEBUFFER_COMPLETE
                                                              : GL_FRAMEBUFFER_INCOMPLETE_ATTACHMENT;
}

static void stub_DrawBuffers(GLsizei count, const GLenum* buffers) {
    framebuffer* f;
    int i;
    ENTER(DrawBuffers);
    f = current_framebuffer("glDrawBuffers");
    if (!f) return;
    f->draw_count = count;
    for (i = 0; i < count; ++i) {
        if (buffers[i] != GL_COLOR_ATTACHMENT0 + (GLenum)i) refuse(GL_INVALID_ENUM, "glDrawBuffers: out of order");
        f->draw[i] = buffers[i];
    }
}

static void stub_ReadBuffer(GLenum buffer) {
    framebuffer* f;
    ENTER(ReadBuffer);
    f = current_framebuffer("glReadBuffer");
    if (!f) return;
    if (buffer != GL_NONE && buffer != GL_COLOR_ATTACHMENT0) refuse(GL_INVALID_ENUM, "glReadBuffer: 0x%04x", buffer);
    f->read = buffer;
}

/* The framebuffer drawn to, or null, and refused. */
static const framebuffer* target_framebuffer(const char* function) {
    const framebuffer* f = current_framebuffer(function);
    if (!f || is_complete(f)) return f;
    refuse(GL_INVALID_FRAMEBUFFER_OPERATION, "%s: the framebuffer is incomplete", function);
    return NULL;
}

static void mark_drawn(const framebuffer* f) {
    int i;
    for (i = 0; i < ATTACHMENTS; ++i)
        if (f->attachments[i].texture) c.textures[f->attachments[i].texture].unflushed = true;
}

static void clear(GLenum buffer, GLint index, bool integer, const char* function) {
    const framebuffer* f = target_framebuffer(function);
    const attachment* a;
    if (!f) return;
    if (buffer != GL_COLOR && buffer != GL_DEPTH) refuse(GL_INVALID_ENUM, "%s: 0x%04x", function, buffer);
    a = &f->attachments[buffer == GL_DEPTH ? DRAW_BUFFERS : index];
    if (index < 0 || (buffer == GL_COLOR && index >= f->draw_count) || !a->texture)
        refuse(GL_INVALID_VALUE, "%s: buffer %d", function, index);
    else if (format_of(c.textures[a->texture].format)->integer != integer)
        refuse(GL_INVALID_OPERATION, "%s: integers and floats", function);
    mark_drawn(f);
}

static void stub_ClearBufferfv(GLenum buffer, GLint index, const GLfloat* value) {
    (void)value;
    ENTER(ClearBufferfv);
    clear(buffer, index, false, "glClearBufferfv");
}

static void stub_ClearBufferuiv(GLenum buffer, GLint index, const GLuint* value) {
    (void)value;
    ENTER(ClearBufferuiv);
    clear(buffer, index, true, "glClearBufferuiv");
}

/* >> buffers, vertex arrays */

static void stub_GenVertexArrays(GLsizei count, GLuint* names) {
    ENTER(GenVertexArrays);
    new_names(VERTEX_ARRAY, count, names);
}

static void stub_DeleteVertexArrays(GLsizei count, const GLuint* names) {
    ENTER(DeleteVertexArrays);
    delete_names(VERTEX_ARRAY, count, names);
}

static void stub_BindVertexArray(GLuint name) {
    ENTER(BindVertexArray);
    if (make(VERTEX_ARRAY, name, "glBindVertexArray")) now.vertex_array = name;
}

static void stub_GenBuffers(GLsizei count, GLuint* names) {
    ENTER(GenBuffers);
    new_names(BUFFER, count, names);
}

static void stub_DeleteBuffers(GLsizei count, const GLuint* names) {
    ENTER(DeleteBuffers);
    delete_names(BUFFER, count, names);
}

static void stub_BindBuffer(GLenum target, GLuint name) {
    ENTER(BindBuffer);
    if (!make(BUFFER, name, "glBindBuffer")) return;
    if (target == GL_UNIFORM_BUFFER)
        now.uniform_buffer = name;
    else if (target == GL_PIXEL_UNPACK_BUFFER)
        now.unpack_buffer = name;
    else if (target == GL_QUERY_BUFFER && has_query_buffers())
        now.query_buffer = name;
    else
        refuse(GL_INVALID_ENUM, "glBindBuffer: 0x%04x", target);
}

static void bind_range(GLenum target, GLuint index, GLuint name, int64_t start, int64_t size, const char* function) {
    if (!make(BUFFER, name, function)) return;
    if (target != GL_UNIFORM_BUFFER || index >= BINDINGS || start < 0 || size < 0) {
        refuse(GL_INVALID_VALUE, "%s: 0x%04x, %u", function, target, index);
        return;
    }
    now.uniform_buffer = name;
    now.bindings[index].buffer = name;
    now.bindings[index].start = start;
    now.bindings[index].size = size;
}

static void stub_BindBufferBase(GLenum target, GLuint index, GLuint name) {
    ENTER(BindBufferBase);
    bind_range(target, index, name, 0, 0, "glBindBufferBase");
}

static void stub_BindBufferRange(GLenum target, GLuint index, GLuint name, GLintptr start, GLsizeiptr size) {
    ENTER(BindBufferRange);
    if (name && size <= 0) refuse(GL_INVALID_VALUE, "glBindBufferRange: %ld bytes", (long)size);
    bind_range(target, index, name, start, size, "glBindBufferRange");
}

static void stub_BufferData(GLenum target, GLsizeiptr size, const void* data, GLenum usage) {
    ENTER(BufferData);
    if (target != GL_UNIFORM_BUFFER || usage != GL_STREAM_DRAW || size <= 0 || !data)
        refuse(GL_INVALID_ENUM, "glBufferData: 0x%04x, %ld bytes, 0x%04x", target, (long)size, usage);
    else if (!now.uniform_buffer)
        refuse(GL_INVALID_OPERATION, "glBufferData: buffer 0");
    else
        c.buffers[now.uniform_buffer] = (size_t)size;
}

/* >> preprocessor: what of a shader is compiled. It knows whole numbers, defined names, ! == < > && || and brackets */

enum { MAX_DEFINES = 96 };

typedef struct preprocessor {
    struct {
        char name[48];
        int value;
    } defines[MAX_DEFINES];
    int count;
    const char* at; /* in an expression */
} preprocessor;

static bool is_word(char ch) {
    return (ch >= 'a' && ch <= 'z') || (ch >= 'A' && ch <= 'Z') || (ch >= '0' && ch <= '9') || ch == '_';
}

static size_t word_length(const char* s) {
    size_t n = 0;
    while (is_word(s[n])) ++n;
    return n;
}

static const char* skip_blanks(const char* s) { return s + strspn(s, " \t\r\n"); }

static int find_define(const preprocessor* p, const char* name, size_t length) {
    int i;
    for (i = 0; i < p->count; ++i)
        if (strlen(p->defines[i].name) == length && strncmp(p->defines[i].name, name, length) == 0) return i;
    return -1;
}

static int evaluate(preprocessor* p, int least_binding);

static int evaluate_operand(preprocessor* p) {
    int value = 0;
    size_t length;
    p->at = skip_blanks(p->at);
    if (*p->at == '!') return ++p->at, !evaluate_operand(p);
    if (*p->at == '(') {
        ++p->at;
        value = evaluate(p, 0);
        p->at = skip_blanks(p->at) + 1;
        return value;
    }
    length = word_length(p->at);
    if (*p->at >= '0' && *p->at <= '9')
        value = atoi(p->at);
    else if (find_define(p, p->at, length) >= 0)
        value = p->defines[find_define(p, p->at, length)].value;
    p->at += length;
    return value;
}

/* Precedence climbing over the operators, loosest first. */
static int evaluate(preprocessor* p, int least_binding) {
    static const char* const operators[] = {"||", "&&", "==", "<", ">"};
    static const int bindings[] = {1, 2, 3, 4, 4};
    int left = evaluate_operand(p), i, right;
    for (;;) {
        p->at = skip_blanks(p->at);
        for (i = 0; i < 5 && strncmp(p->at, operators[i], strlen(operators[i])) != 0; ++i) {}
        if (i == 5 || bindings[i] <= least_binding) return left;
        p->at += strlen(operators[i]);
        right = evaluate(p, bindings[i]);
        left = i == 0   ? left || right
               : i == 1 ? left && right
               : i == 2 ? left == right
               : i == 3 ? left < right
                        : left > right;
    }
}

static void define(preprocessor* p, const char* s) {
    const size_t length = word_length(s);
    if (p->count == MAX_DEFINES || length >= sizeof p->defines[0].name) {
        refuse(GL_INVALID_OPERATION, "too many defines");
        return;
    }
    snprintf(p->defines[p->count].name, sizeof p->defines[0].name, "%.*s", (int)length, s);
    p->defines[p->count++].value = atoi(s + length);
}

/* 0: not yet, 1: this part counts, 2: it is over. One entry for each open #if. */
typedef struct conditions {
    int part[16], depth;
} conditions;

static bool is_counted(const conditions* k, int depth) {
    int i;
    for (i = 0; i < depth; ++i)
        if (k->part[i] != 1) return false;
    return true;
}

static bool starts(const char** s, const char* word) {
    const size_t length = strlen(word);
    if (strncmp(*s, word, length) != 0 || is_word((*s)[length])) return false;
    *s = skip_blanks(*s + length);
    return true;
}

static void direct(preprocessor* p, conditions* k, const char* s) {
    int* top = &k->part[k->depth ? k->depth - 1 : 0];
    if (starts(&s, "if")) {
        p->at = s;
        k->part[k->depth++] = evaluate(p, 0) ? 1 : 0;
    } else if (starts(&s, "ifdef")) {
        k->part[k->depth++] = find_define(p, s, word_length(s)) >= 0;
    } else if (starts(&s, "elif")) {
        p->at = s;
        *top = *top ? 2 : evaluate(p, 0) ? 1 : 0;
    } else if (starts(&s, "else")) {
        *top = *top ? 2 : 1;
    } else if (starts(&s, "endif")) {
        --k->depth;
    } else if (is_counted(k, k->depth) && starts(&s, "define")) {
        define(p, s);
    }
}

static size_t before_comment(const char* line, size_t length) {
    const char* slash = line;
    while ((slash = (const char*)memchr(slash, '/', length - (size_t)(slash - line))) != NULL) {
        if (slash[1] == '/') return (size_t)(slash - line);
        ++slash;
    }
    return length;
}

/* The lines that count, without comments; the caller frees. */
static char* preprocess(const char* source) {
    static preprocessor p;
    conditions k;
    char *text = (char*)malloc(strlen(source) + 1), *end = text;
    memset(&p, 0, sizeof p);
    memset(&k, 0, sizeof k);
    while (*source) {
        const size_t length = strcspn(source, "\n");
        const size_t kept = before_comment(source, length);
        if (*source == '#') {
            direct(&p, &k, source + 1);
        } else if (is_counted(&k, k.depth)) {
            memcpy(end, source, kept);
            end += kept;
            *end++ = '\n';
        }
        source += length + (source[length] == '\n');
    }
    *end = 0;
    return text;
}

/* >> shaders, programs */

static GLuint stub_CreateShader(GLenum stage) {
    GLuint name;
    ENTER_OR(CreateShader, 0);
    if (stage != GL_VERTEX_SHADER && stage != GL_FRAGMENT_SHADER && (stage != GL_GEOMETRY_SHADER || !since(330, 320)))
        refuse(GL_INVALID_ENUM, "glCreateShader: 0x%04x", stage);
    name = new_name(SHADER, MADE);
    c.shaders[name].stage = stage;
    return name;
}

static void free_shader(GLuint name) {
    free(c.shaders[name].source);
    free(c.shaders[name].text);
    memset(&c.shaders[name], 0, sizeof c.shaders[name]);
    c.life[SHADER][name] = DEAD;
}

static bool is_attached(GLuint name) {
    GLuint p;
    int i;
    for (p = 1; p <= c.last[PROGRAM]; ++p)
        for (i = 0; is_name(PROGRAM, p) && i < c.programs[p].shader_count; ++i)
            if (c.programs[p].shaders[i] == name) return true;
    return false;
}

static void stub_DeleteShader(GLuint name) {
    ENTER(DeleteShader);
    if (!name) return;
    if (!is_name(SHADER, name) || c.shaders[name].dead)
        refuse(GL_INVALID_VALUE, "glDeleteShader: %u", name);
    else if (is_attached(name))
        c.shaders[name].dead = true;
    else
        free_shader(name);
}

static shader* shader_of(GLuint name, const char* function) {
    if (is_name(SHADER, name)) return &c.shaders[name];
    refuse(GL_INVALID_VALUE, "%s: no shader %u", function, name);
    return NULL;
}

static void stub_ShaderSource(GLuint name, GLsizei count, const GLchar* const* strings, const GLint* lengths) {
    shader* s;
    size_t size = 1;
    int i;
    ENTER(ShaderSource);
    s = shader_of(name, "glShaderSource");
    if (!s || lengths) return;
    for (i = 0; i < count; ++i) size += strlen(strings[i]);
    free(s->source);
    s->source = (char*)calloc(size, 1);
    for (i = 0, size = 0; i < count; size += strlen(strings[i]), ++i)
        memcpy(s->source + size, strings[i], strlen(strings[i]));
}

/* "#version 330 core": no newer than the context. */
static bool version_ok(const char* source) {
    const int version = strncmp(source, "#version ", 9) == 0 ? atoi(source + 9) : 0;
    const bool es = version && strncmp(source + 12, " es\n", 4) == 0;
    return version >= (c.desc.es ? 300 : 330) && version <= c.desc.version && es == c.desc.es;
}

static void stub_CompileShader(GLuint name) {
    shader* s;
    ENTER(CompileShader);
    s = shader_of(name, "glCompileShader");
    if (!s) return;
    s->compiled = s->source && version_ok(s->source);
    if (!s->compiled)
        refuse(GL_NO_ERROR, "glCompileShader: no source, or of another version");
    else
        free(s->text), s->text = preprocess(s->source);
}

static void stub_GetShaderiv(GLuint name, GLenum parameter, GLint* value) {
    const shader* s;
    ENTER(GetShaderiv);
    s = shader_of(name, "glGetShaderiv");
    if (parameter != GL_COMPILE_STATUS) refuse(GL_INVALID_ENUM, "glGetShaderiv: 0x%04x", parameter);
    if (s) *value = s->compiled;
}

static void write_log(GLsizei capacity, GLsizei* length, GLchar* log) {
    if (capacity > 0) snprintf(log, (size_t)capacity, "the stub's log");
    if (length) *length = (GLsizei)strlen(log);
}

static void stub_GetShaderInfoLog(GLuint name, GLsizei capacity, GLsizei* length, GLchar* log) {
    ENTER(GetShaderInfoLog);
    if (shader_of(name, "glGetShaderInfoLog")) write_log(capacity, length, log);
}

static GLuint stub_CreateProgram(void) {
    ENTER_OR(CreateProgram, 0);
    return new_name(PROGRAM, MADE);
}

static program* program_of(GLuint name, const char* function) {
    if (is_name(PROGRAM, name)) return &c.programs[name];
    refuse(GL_INVALID_VALUE, "%s: no program %u", function, name);
    return NULL;
}

static void free_program(GLuint name) {
    program* p = &c.programs[name];
    GLuint shaders[3];
    int i, count = p->shader_count;
    memcpy(shaders, p->shaders, sizeof shaders);
    memset(p, 0, sizeof *p);
    c.life[PROGRAM][name] = DEAD;
    for (i = 0; i < count; ++i)
        if (c.shaders[shaders[i]].dead && !is_attached(shaders[i])) free_shader(shaders[i]);
}

static void stub_DeleteProgram(GLuint name) {
    program* p;
    ENTER(DeleteProgram);
    p = name ? program_of(name, "glDeleteProgram") : NULL;
    if (!p) return;
    if (now.program == name)
        p->dead = true;
    else
        free_program(name);
}

static void stub_AttachShader(GLuint name, GLuint shader_name) {
    program* p;
    ENTER(AttachShader);
    p = program_of(name, "glAttachShader");
    if (!p || !shader_of(shader_name, "glAttachShader")) return;
    if (p->shader_count == 3)
        refuse(GL_INVALID_OPERATION, "glAttachShader: a fourth shader");
    else
        p->shaders[p->shader_count++] = shader_name;
}

static int count_word(const char* text, const char* word) {
    const size_t length = strlen(word);
    const char* at = text;
    int count = 0;
    while ((at = strstr(at, word)) != NULL) {
        count += (at == text || !is_word(at[-1])) && !is_word(at[length]);
        at += length;
    }
    return count;
}

/* "sampler2D dgb_z;" after "uniform": noted when something uses it. */
static void note_resource(program* p, const char* declaration, const char* text) {
    static const struct {
        const char* type;
        GLenum target;
        bool is_image, is_integer;
    } types[] = {
        {"sampler2D", GL_TEXTURE_2D, false, false},         {"sampler2DArray", GL_TEXTURE_2D_ARRAY, false, false},
        {"usampler2D", GL_TEXTURE_2D, false, true},         {"usampler2DArray", GL_TEXTURE_2D_ARRAY, false, true},
        {"image2DArray", GL_TEXTURE_2D_ARRAY, true, false}, {"uimage2DArray", GL_TEXTURE_2D_ARRAY, true, true}};
    resource* r = &p->resources[p->resource_count];
    size_t i;
    for (i = 0; i < sizeof types / sizeof types[0]; ++i) {
        const char* at = declaration;
        if (!starts(&at, types[i].type)) continue;
        if (p->resource_count == MAX_RESOURCES) {
            refuse(GL_INVALID_OPERATION, "glLinkProgram: too many samplers");
            return;
        }
        snprintf(r->name, sizeof r->name, "%.*s", (int)word_length(at), at);
        r->target = types[i].target, r->is_image = types[i].is_image, r->is_integer = types[i].is_integer;
        r->unit = 0;
        p->resource_count += count_word(text, r->name) > 1;
        return;
    }
}

static void note_uniforms(program* p, const char* text) {
    const char* at = text;
    while ((at = strstr(at, "uniform ")) != NULL) {
        const char* name = skip_blanks(at + 8);
        const size_t length = word_length(name);
        if (*skip_blanks(name + length) == '{')
            snprintf(p->block, sizeof p->block, "%.*s", (int)length, name);
        else
            note_resource(p, name, text);
        at = name;
    }
}

static void stub_LinkProgram(GLuint name) {
    program* p;
    int i;
    ENTER(LinkProgram);
    p = program_of(name, "glLinkProgram");
    if (!p) return;
    p->linked = p->shader_count >= 2;
    p->resource_count = 0;
    for (i = 0; i < p->shader_count; ++i) {
        const shader* s = &c.shaders[p->shaders[i]];
        p->linked = p->linked && s->compiled;
        if (s->compiled) note_uniforms(p, s->text);
    }
    if (!p->linked) refuse(GL_NO_ERROR, "glLinkProgram: a shader is missing or not compiled");
}

static void stub_GetProgramiv(GLuint name, GLenum parameter, GLint* value) {
    const program* p;
    ENTER(GetProgramiv);
    p = program_of(name, "glGetProgramiv");
    if (parameter != GL_LINK_STATUS) refuse(GL_INVALID_ENUM, "glGetProgramiv: 0x%04x", parameter);
    if (p) *value = p->linked;
}

static void stub_GetProgramInfoLog(GLuint name, GLsizei capacity, GLsizei* length, GLchar* log) {
    ENTER(GetProgramInfoLog);
    if (program_of(name, "glGetProgramInfoLog")) write_log(capacity, length, log);
}

static void stub_UseProgram(GLuint name) {
    const GLuint before = now.program;
    const program* p;
    ENTER(UseProgram);
    p = name ? program_of(name, "glUseProgram") : NULL;
    if (name && !p) return;
    if (p && !p->linked) refuse(GL_INVALID_OPERATION, "glUseProgram: %u is not linked", name);
    now.program = name;
    if (before && before != name && c.programs[before].dead) free_program(before);
}

static GLboolean stub_IsProgram(GLuint name) {
    ENTER_OR(IsProgram, GL_FALSE);
    return is_name(PROGRAM, name);
}

static GLint stub_GetUniformLocation(GLuint name, const GLchar* uniform) {
    const program* p;
    int i;
    ENTER_OR(GetUniformLocation, -1);
    p = program_of(name, "glGetUniformLocation");
    for (i = 0; p && i < p->resource_count; ++i)
        if (strcmp(p->resources[i].name, uniform) == 0) return i;
    return -1;
}

static void stub_Uniform1i(GLint location, GLint value) {
    program* p = &c.programs[now.program];
    ENTER(Uniform1i);
    if (!now.program || location < 0 || location >= p->resource_count)
        refuse(GL_INVALID_OPERATION, "glUniform1i: location %d", location);
    else if (value < 0 || value >= (p->resources[location].is_image ? IMAGE_UNITS : UNITS))
        refuse(GL_INVALID_VALUE, "glUniform1i: unit %d", value);
    else
        p->resources[location].unit = value;
}

static GLuint stub_GetUniformBlockIndex(GLuint name, const GLchar* block) {
    const program* p;
    ENTER_OR(GetUniformBlockIndex, GL_INVALID_INDEX);
    p = program_of(name, "glGetUniformBlockIndex");
    return p && p->block[0] && strcmp(p->block, block) == 0 ? 0 : GL_INVALID_INDEX;
}

static void stub_UniformBlockBinding(GLuint name, GLuint block, GLuint binding) {
    program* p;
    ENTER(UniformBlockBinding);
    p = program_of(name, "glUniformBlockBinding");
    if (p && (block != 0 || binding >= BINDINGS)) refuse(GL_INVALID_VALUE, "glUniformBlockBinding: %u", binding);
    if (p) p->binding = binding;
}

/* >> drawing */

/* Sampling what is drawn to is undefined, but for texels that the draw does not write, once a barrier has let earlier writes
   through: peeling samples the layer in front of the one it draws, and at the first layer none. Where no barrier is offered,
   none is asked for. */
static bool is_feedback(const framebuffer* f, GLuint name) {
    const texture* t = &c.textures[name];
    int i;
    for (i = 0; i < ATTACHMENTS; ++i) {
        const attachment* a = &f->attachments[i];
        const bool flushed = a->layer == 0 || !t->unflushed || !is_offered("glTextureBarrier");
        const bool apart = t->target == GL_TEXTURE_2D_ARRAY && a->layer >= 0 && flushed;
        if (a->texture == name && a->level >= t->base && a->level <= t->max && !apart) return true;
    }
    return false;
}

static void check_sampler(const framebuffer* f, const resource* r) {
    const GLuint name = r->target == GL_TEXTURE_2D ? now.textures_2d[r->unit] : now.textures_array[r->unit];
    const texture* t = &c.textures[name];
    /* the oracle's may be empty, which GL defines: where one layer is drawn, nothing looks at it */
    if (!name && strcmp(r->name, "dgb_oracle") == 0) return;
    if (!name || !t->levels)
        refuse(GL_NO_ERROR, "draw: %s samples unit %d, which has no texture", r->name, r->unit);
    else if (format_of(t->format)->integer != r->is_integer)
        refuse(GL_NO_ERROR, "draw: %s in unit %d: integers and floats", r->name, r->unit);
    else if (t->base >= t->levels)
        refuse(GL_NO_ERROR, "draw: %s in unit %d starts at level %d of %d", r->name, r->unit, t->base, t->levels);
    else if (is_feedback(f, name))
        refuse(GL_NO_ERROR, "draw: %s in unit %d is drawn to as well", r->name, r->unit);
}

/* Of the library's images: a caller's, which are write-only here, may stay where a shader stores nothing. What is stored in an
   empty unit goes nowhere. */
static void check_image(const resource* r) {
    const GLint* image = now.images[r->unit];
    const struct format* f = format_of((GLenum)image[5]);
    if (image[4] != GL_READ_WRITE || !image[0]) return;
    if (!is_name(TEXTURE, (GLuint)image[0]))
        refuse(GL_NO_ERROR, "draw: %s in image unit %d holds a dead texture", r->name, r->unit);
    else if (!f || c.textures[image[0]].format != f->internal || f->integer != r->is_integer)
        refuse(GL_NO_ERROR, "draw: %s in image unit %d has format 0x%04x", r->name, r->unit, image[5]);
}

static void stub_DrawArrays(GLenum mode, GLint first, GLsizei count) {
    const framebuffer* f;
    const program* p = &c.programs[now.program];
    int i;
    ENTER(DrawArrays);
    f = target_framebuffer("glDrawArrays");
    if (mode != GL_TRIANGLES || first < 0 || count < 0) refuse(GL_INVALID_ENUM, "glDrawArrays: 0x%04x", mode);
    if (!now.program || (!now.vertex_array && !c.desc.es)) refuse(GL_INVALID_OPERATION, "glDrawArrays: nothing bound");
    if (!f || !now.program) return;
    for (i = 0; i < p->resource_count; ++i) {
        if (p->resources[i].is_image)
            check_image(&p->resources[i]);
        else
            check_sampler(f, &p->resources[i]);
    }
    if (p->block[0] && (!now.bindings[p->binding].buffer || !c.buffers[now.bindings[p->binding].buffer]))
        refuse(GL_NO_ERROR, "glDrawArrays: %s has no buffer", p->block);
    mark_drawn(f);
}

/* >> queries, debugging */

static void stub_GenQueries(GLsizei count, GLuint* names) {
    ENTER(GenQueries);
    new_names(QUERY, count, names);
}

static void stub_DeleteQueries(GLsizei count, const GLuint* names) {
    ENTER(DeleteQueries);
    delete_names(QUERY, count, names);
}

static void stub_QueryCounter(GLuint name, GLenum target) {
    ENTER(QueryCounter);
    if (target != GL_TIMESTAMP || !make(QUERY, name, "glQueryCounter"))
        refuse(GL_INVALID_ENUM, "glQueryCounter: 0x%04x", target);
    else
        c.counted[name] = true;
}

static bool query_ok(GLuint name, const char* function) {
    const bool ok = is_name(QUERY, name) && c.counted[name] && !now.query_buffer;
    if (!ok) refuse(GL_INVALID_OPERATION, "%s: query %u has not begun, or goes into a buffer", function, name);
    return ok;
}

static void stub_GetQueryObjectiv(GLuint name, GLenum parameter, GLint* value) {
    ENTER(GetQueryObjectiv);
    if (parameter != GL_QUERY_RESULT_AVAILABLE) refuse(GL_INVALID_ENUM, "glGetQueryObjectiv: 0x%04x", parameter);
    if (query_ok(name, "glGetQueryObjectiv")) *value = GL_TRUE;
}

static void stub_GetQueryObjectui64v(GLuint name, GLenum parameter, GLuint64* value) {
    ENTER(GetQueryObjectui64v);
    if (parameter != GL_QUERY_RESULT) refuse(GL_INVALID_ENUM, "glGetQueryObjectui64v: 0x%04x", parameter);
    if (query_ok(name, "glGetQueryObjectui64v")) *value = c.clock += 1000;
}

static void stub_ObjectLabel(GLenum kind, GLuint name, GLsizei length, const GLchar* label) {
    static const GLenum kinds[KIND_COUNT] = {GL_TEXTURE, GL_SAMPLER, GL_FRAMEBUFFER, GL_VERTEX_ARRAY,
                                             GL_BUFFER,  GL_SHADER,  GL_PROGRAM,     GL_QUERY};
    int i;
    ENTER(ObjectLabel);
    for (i = 0; i < KIND_COUNT && kinds[i] != kind; ++i) {}
    if (i == KIND_COUNT || length >= 0 || !label)
        refuse(GL_INVALID_ENUM, "glObjectLabel: 0x%04x", kind);
    else if (!is_name((enum kind)i, name) || c.life[i][name] != MADE)
        refuse(GL_INVALID_VALUE, "glObjectLabel: no %s %u", kind_names[i], name);
}

static void stub_PushDebugGroup(GLenum source, GLuint id, GLsizei length, const GLchar* text) {
    (void)id, (void)length;
    ENTER(PushDebugGroup);
    if (source != GL_DEBUG_SOURCE_APPLICATION || !text) refuse(GL_INVALID_ENUM, "glPushDebugGroup: 0x%04x", source);
    if (++c.debug_groups > 63) refuse(GL_STACK_OVERFLOW, "glPushDebugGroup: too many");
}

static void stub_PopDebugGroup(void) {
    ENTER(PopDebugGroup);
    if (--c.debug_groups < 0) refuse(GL_STACK_UNDERFLOW, "glPopDebugGroup: none is open");
}

/* >> the table, start, stop */

/* Initialised by name, so that the compiler compares each signature with the header's. */
static const dgbgl_functions functions = {
#define STUB_MEMBER(result, name, arguments) stub_##name,
    DGBGL_FUNCTIONS(STUB_MEMBER) DGBGL_OPTIONAL_FUNCTIONS(STUB_MEMBER)
#undef STUB_MEMBER
};

void* gl_stub_get_proc(const char* name) {
    void* address = NULL;
#define STUB_FIND(result, function, arguments) \
    if (strcmp(name, "gl" #function) == 0) memcpy(&address, &functions.function, sizeof address);
    DGBGL_FUNCTIONS(STUB_FIND)
    DGBGL_OPTIONAL_FUNCTIONS(STUB_FIND)
#undef STUB_FIND
    return address;
}

void gl_stub_start(const gl_stub_desc* desc) {
    int i;
    gl_stub_stop();
    c.desc = *desc;
    for (i = 0; i < TOGGLES; ++i) now.toggles[i] = toggles[i].name == GL_DITHER || toggles[i].name == GL_MULTISAMPLE;
    for (i = 0; i < VIEWPORTS; ++i) now.depth_ranges[i][1] = 1.0;
    memset(now.color_mask, GL_TRUE, sizeof now.color_mask);
    now.depth_mask = GL_TRUE;
    now.depth_func = GL_LESS;
    now.polygon_mode = GL_FILL;
    now.clip_origin = GL_LOWER_LEFT;
    now.clip_depth = GL_NEGATIVE_ONE_TO_ONE;
    *unpack_of(GL_UNPACK_ALIGNMENT) = 4;
}

void gl_stub_stop(void) {
    GLuint i;
    for (i = 1; i < NAMES; ++i) {
        free(c.shaders[i].source);
        free(c.shaders[i].text);
    }
    memset(&c, 0, sizeof c);
    memset(&now, 0, sizeof now);
}

int gl_stub_calls(void) { return c.calls; }

int gl_stub_gets(void) { return c.gets; }

void gl_stub_lose_at(int call) { c.lose_at = call; }

int gl_stub_refusals(void) { return c.refusals; }

const char* gl_stub_refusal(void) { return c.refusal; }

const void* gl_stub_state(size_t* size) {
    *size = sizeof now;
    return &now;
}

static GLuint own(enum kind kind) { return new_name(kind, MADE); }

static GLuint own_texture(GLenum target) {
    const GLuint name = own(TEXTURE);
    texture* t = &c.textures[name];
    t->target = target, t->format = GL_RGBA8;
    t->width = t->height = 4, t->layers = t->levels = 1, t->max = 1000;
    return name;
}

static void scramble_raster(void) {
    const bool indexed = is_offered("glViewportIndexedf"), buffers = is_offered("glColorMaski");
    int i, k;
    for (i = 0; i < VIEWPORTS; ++i) {
        const int odd = indexed ? i : 0; /* without indices, all are one */
        for (k = 0; k < 4; ++k) now.viewports[i][k] = (float)(1 + odd + 3 * k);
        now.depth_ranges[i][0] = 0.75 - odd / 64.0, now.depth_ranges[i][1] = 0.25;
        now.scissor[i] = odd % 2 == 0;
    }
    for (i = 0; i < DRAW_BUFFERS; ++i) {
        now.blend[i] = (buffers ? i : 0) % 2 == 0;
        for (k = 0; k < 4; ++k) now.color_mask[i][k] = ((buffers ? i : 0) + k) % 3 == 0;
    }
    for (i = 0; i < TOGGLES; ++i)
        if (since(toggles[i].since, toggles[i].since_es)) now.toggles[i] = !now.toggles[i];
    now.depth_mask = GL_FALSE;
    now.depth_func = GL_NOTEQUAL;
    if (!c.desc.es) now.polygon_mode = GL_LINE;
    if (is_offered("glClipControl")) now.clip_origin = GL_UPPER_LEFT, now.clip_depth = GL_ZERO_TO_ONE;
    for (i = 0; i < (c.desc.es ? 6 : 7); ++i) now.unpack[i] = unpack_names[i] == GL_UNPACK_ALIGNMENT ? 8 : 2 + i;
}

void gl_stub_scramble(void) {
    int i;
    scramble_raster();
    now.draw_framebuffer = own(FRAMEBUFFER);
    now.read_framebuffer = own(FRAMEBUFFER);
    now.program = own(PROGRAM);
    c.programs[now.program].linked = true;
    now.vertex_array = own(VERTEX_ARRAY);
    now.uniform_buffer = own(BUFFER);
    now.unpack_buffer = own(BUFFER);
    if (has_query_buffers()) now.query_buffer = own(BUFFER);
    for (i = 0; i < BINDINGS; ++i) {
        now.bindings[i].buffer = own(BUFFER);
        now.bindings[i].start = 256 * (i % 3);
        now.bindings[i].size = i % 4 ? 512 : 0;
        if (i % 4 == 0) now.bindings[i].start = 0; /* bound whole */
    }
    for (i = 0; i < UNITS; ++i) {
        now.textures_2d[i] = own_texture(GL_TEXTURE_2D);
        now.textures_array[i] = own_texture(GL_TEXTURE_2D_ARRAY);
        now.samplers[i] = own(SAMPLER);
    }
    for (i = 0; i < IMAGE_UNITS && is_offered("glBindImageTexture"); ++i) {
        const GLint image[6] = {(GLint)now.textures_2d[i], i % 2, i % 2, i % 3, GL_WRITE_ONLY, GL_RG32F};
        memcpy(now.images[i], image, sizeof image);
    }
    now.active = 3;
}
