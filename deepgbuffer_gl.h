/* deepgbuffer_gl.h - OpenGL backend of deepgbuffer.h - v0.1.0 - MIT or public domain

   Do this:
       #include "deepgbuffer.h"
       #include "deepgbuffer_gl.h"
   In the one file where DEEPGBUFFER_IMPLEMENTATION is defined, both headers are implemented.
   Nothing to link and no GL header needed: every entry point comes through the get_proc you give (glfwGetProcAddress
   and eglGetProcAddress both fit).

   NEEDS     OpenGL 3.3 core or later, or OpenGL ES 3.0 or later with EXT_color_buffer_float (peeling only there).
   DOES NOT  create contexts, own your shaders, change your state behind your back, or compile anything after dgb_init
             (dgbgl_draw_view excepted).

   START (with a context current)
       static dgbgl_backend gl;                             keep it as long as the dgb_context
       dgbgl_desc gd = {0};
       gd.get_proc = my_get_proc;
       dgbgl_init(&gl, &gd);
       dgb_desc d = {0};
       d.width = 1280; d.height = 720; d.effects = DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY;
       d.backend = &gl.backend;
       dgb_init(&dgb, &d);

   YOUR MATERIAL SHADERS
       Each starts with the text of dgbgl_shader_prefix, which holds the #version line; yours follows without one.
           uniform mat4 view, projection, model, previous_view, previous_projection, previous_model;      vertex shader
           in vec3 position, normal;  in vec2 uv;  out vec3 v_normal;  out vec2 v_uv;
           void main() {
               v_normal = mat3(view * model) * normal;
               v_uv = uv;
               dgb_vertex(projection * view * model * vec4(position, 1.0),                   last; writes gl_Position
                          previous_projection * previous_view * previous_model * vec4(position, 1.0));
           }
           uniform sampler2D base_color;  in vec3 v_normal;  in vec2 v_uv;                              fragment shader
           void main() {
               vec4 base = texture(base_color, v_uv);
               if (base.a < 0.5) discard;                  your alpha test comes first
               if (!dgb_keep()) discard;                   then the library's
               dgb_store(vec4(base.rgb, 1.0), v_normal, vec2(roughness, metallic), emission);
           }
       dgb_instance() replaces gl_InstanceID. Skinned vertices are skinned twice: now, and with last frame's bones.
       The geometry shader is dgbgl_geometry_shader's: link it when its text is not empty. It passes your varyings on
       under another name, so list them for both functions:
           const dgbgl_varying varyings[] = {{NULL, "vec3", "v_normal"}, {NULL, "vec2", "v_uv"}};
       After linking, once: dgbgl_attach_program.
       Your draw callback multiplies its instance count, and the divisors of its instanced attributes, by
       draw->instances, and draws objects in the pose that draw->pose names. IMAGE emission calls your fragment shader's
       main from one of its own; do not call main yourself.

   STATE
       Each dgb_* call that touches GL saves first, and restores last, all state it changes: draw and read framebuffer,
       viewports, depth ranges, scissor tests, blend enables and colour masks of every buffer, depth, stencil, cull,
       polygon mode, offset and smoothing, primitive restart, sRGB, logic op, dither, multisample coverage, clip
       distances and clip control, program (even one deleted while in use), vertex array, uniform buffer and the one
       indexed binding used, active texture, textures and samplers of the units used, image units 0 to 4, pixel
       unpacking, query buffer.
       desc.keep_state = true skips all of it, and every glGet: then set your own.
       Left alone, so yours to set in your draw callback: front face, provoking vertex, cull face, and what concerns
       only lines, points and patches.
       Not restorable, so not allowed around a call: active transform feedback, conditional rendering. Queries of yours
       that are active count what the library draws.

   ERRORS OF GL
       What was pending before a call, or is when your draw callback returns, is yours: the library tells desc.message
       of it and does not count it against itself. What the driver refused in a call, out of memory or lost with its
       context, makes dgb_build and dgb_shade fail (DGB_OUT_OF_MEMORY, DGB_DEVICE). With keep_state no frame asks for
       errors: do so yourself. After a lost context shut everything down and start anew: the library waits for nothing
       and calls nothing that is null.

   UNITS AND BINDINGS
       Full-screen passes use texture units 0 to 13 and the oracle's, and one uniform buffer binding. During your draw
       callback the oracle sits in texture unit desc.oracle_unit (default 15) and the draw block in uniform binding
       desc.uniform_binding (default 23); with IMAGE emission the layers are bound to image units 0 to 4 as well.

   TO LOOK AT IT
       dgbgl_view_desc v = {0};
       v.view = DGBGL_VIEW_VALIDITY, v.layer = 1;
       dgbgl_draw_view(&dgb, &v);                           any layer or result, into the framebuffer that is bound
       Passes are debug groups, objects have labels: a frame debugger shows what is what.

   THREADS   those of the GL context.
*/

#ifndef DEEPGBUFFER_GL_H
#define DEEPGBUFFER_GL_H

#include "deepgbuffer.h"

#ifdef __cplusplus
extern "C" {
#endif

#define DGBGL_VERSION_MAJOR 0
#define DGBGL_VERSION_MINOR 1
#define DGBGL_VERSION_PATCH 0
#define DGBGL_VERSION_STRING "0.1.0"
#define DGBGL_VERSION (DGBGL_VERSION_MAJOR * 10000 + DGBGL_VERSION_MINOR * 100 + DGBGL_VERSION_PATCH)
#if DGBGL_VERSION != DGB_VERSION
#error "deepgbuffer.h and deepgbuffer_gl.h are of different versions: take both from one release"
#endif

#define DGBGL_MAX_FRAMEBUFFERS 48
#define DGBGL_MAX_UNITS 14
#define DGBGL_MAX_IMAGES 5
#define DGBGL_MAX_VIEWPORTS 16
#define DGBGL_MAX_DRAW_BUFFERS 8
#define DGBGL_TOGGLE_COUNT 26
#define DGBGL_UNPACK_COUNT 7

typedef void* (*dgbgl_get_proc_fn)(const char* name);

/* Compiler and linker messages with the pass they belong to; what the driver lacks; GL errors that the engine left. */
typedef void (*dgbgl_message_fn)(void* user, const char* text);

typedef struct dgbgl_desc {     /* 0 means default */
    dgbgl_get_proc_fn get_proc; /* required */
    int oracle_unit;            /* default 15 */
    int uniform_binding;        /* default 23 */
    bool keep_state;            /* do not save and restore the engine's state */
    bool no_timers;             /* do not measure passes */
    bool no_single_pass;        /* pretend that neither geometry nor vertex emission works */
    dgbgl_message_fn message;   /* may be null */
    void* message_user;
} dgbgl_desc;

typedef enum dgbgl_stage { DGBGL_VERTEX = 0, DGBGL_GEOMETRY, DGBGL_FRAGMENT } dgbgl_stage;

typedef struct dgbgl_varying { /* one of the engine's own varyings */
    const char* qualifier;     /* null, "flat" (required for integers), "smooth", "noperspective", "centroid" */
    const char* type;          /* "vec2": any float, int or uint scalar or vector, any float matrix */
    const char* name;          /* "v_uv" or "v_weights[4]" (an array through a geometry shader needs OpenGL 4.3); must
                                  not start with dgb_ or gl_ */
} dgbgl_varying;

/* Entry points. X(return type, name, arguments): required first, then those that may be missing. */
#define DGBGL_FUNCTIONS(X)                                                                                     \
    X(const unsigned char*, GetString, (unsigned int))                                                         \
    X(const unsigned char*, GetStringi, (unsigned int, unsigned int))                                          \
    X(unsigned int, GetError, (void))                                                                          \
    X(void, GetIntegerv, (unsigned int, int*))                                                                 \
    X(void, GetInteger64i_v, (unsigned int, unsigned int, int64_t*))                                           \
    X(void, GetIntegeri_v, (unsigned int, unsigned int, int*))                                                 \
    X(void, Finish, (void))                                                                                    \
    X(void, GetFloatv, (unsigned int, float*))                                                                 \
    X(void, Enable, (unsigned int))                                                                            \
    X(void, Disable, (unsigned int))                                                                           \
    X(unsigned char, IsEnabled, (unsigned int))                                                                \
    X(void, Viewport, (int, int, int, int))                                                                    \
    X(void, ColorMask, (unsigned char, unsigned char, unsigned char, unsigned char))                           \
    X(void, DepthMask, (unsigned char))                                                                        \
    X(void, DepthFunc, (unsigned int))                                                                         \
    X(void, PixelStorei, (unsigned int, int))                                                                  \
    X(void, GenTextures, (int, unsigned int*))                                                                 \
    X(void, DeleteTextures, (int, const unsigned int*))                                                        \
    X(void, BindTexture, (unsigned int, unsigned int))                                                         \
    X(void, ActiveTexture, (unsigned int))                                                                     \
    X(void, TexParameteri, (unsigned int, unsigned int, int))                                                  \
    X(void, TexImage2D, (unsigned int, int, int, int, int, int, unsigned int, unsigned int, const void*))      \
    X(void, TexImage3D, (unsigned int, int, int, int, int, int, int, unsigned int, unsigned int, const void*)) \
    X(void, TexSubImage2D, (unsigned int, int, int, int, int, int, unsigned int, unsigned int, const void*))   \
    X(void, GenSamplers, (int, unsigned int*))                                                                 \
    X(void, DeleteSamplers, (int, const unsigned int*))                                                        \
    X(void, BindSampler, (unsigned int, unsigned int))                                                         \
    X(void, SamplerParameteri, (unsigned int, unsigned int, int))                                              \
    X(void, GenFramebuffers, (int, unsigned int*))                                                             \
    X(void, DeleteFramebuffers, (int, const unsigned int*))                                                    \
    X(void, BindFramebuffer, (unsigned int, unsigned int))                                                     \
    X(void, FramebufferTexture2D, (unsigned int, unsigned int, unsigned int, unsigned int, int))               \
    X(void, FramebufferTextureLayer, (unsigned int, unsigned int, unsigned int, int, int))                     \
    X(unsigned int, CheckFramebufferStatus, (unsigned int))                                                    \
    X(void, DrawBuffers, (int, const unsigned int*))                                                           \
    X(void, ReadBuffer, (unsigned int))                                                                        \
    X(void, ClearBufferfv, (unsigned int, int, const float*))                                                  \
    X(void, GenVertexArrays, (int, unsigned int*))                                                             \
    X(void, DeleteVertexArrays, (int, const unsigned int*))                                                    \
    X(void, BindVertexArray, (unsigned int))                                                                   \
    X(void, DrawArrays, (unsigned int, int, int))                                                              \
    X(void, GenBuffers, (int, unsigned int*))                                                                  \
    X(void, DeleteBuffers, (int, const unsigned int*))                                                         \
    X(void, BindBuffer, (unsigned int, unsigned int))                                                          \
    X(void, BindBufferBase, (unsigned int, unsigned int, unsigned int))                                        \
    X(void, BindBufferRange, (unsigned int, unsigned int, unsigned int, ptrdiff_t, ptrdiff_t))                 \
    X(void, BufferData, (unsigned int, ptrdiff_t, const void*, unsigned int))                                  \
    X(unsigned int, CreateShader, (unsigned int))                                                              \
    X(void, DeleteShader, (unsigned int))                                                                      \
    X(void, ShaderSource, (unsigned int, int, const char* const*, const int*))                                 \
    X(void, CompileShader, (unsigned int))                                                                     \
    X(void, GetShaderiv, (unsigned int, unsigned int, int*))                                                   \
    X(void, GetShaderInfoLog, (unsigned int, int, int*, char*))                                                \
    X(unsigned int, CreateProgram, (void))                                                                     \
    X(void, DeleteProgram, (unsigned int))                                                                     \
    X(void, AttachShader, (unsigned int, unsigned int))                                                        \
    X(void, LinkProgram, (unsigned int))                                                                       \
    X(void, GetProgramiv, (unsigned int, unsigned int, int*))                                                  \
    X(void, GetProgramInfoLog, (unsigned int, int, int*, char*))                                               \
    X(void, UseProgram, (unsigned int))                                                                        \
    X(unsigned char, IsProgram, (unsigned int))                                                                \
    X(int, GetUniformLocation, (unsigned int, const char*))                                                    \
    X(void, Uniform1i, (int, int))                                                                             \
    X(unsigned int, GetUniformBlockIndex, (unsigned int, const char*))                                         \
    X(void, UniformBlockBinding, (unsigned int, unsigned int, unsigned int))                                   \
    X(void, ClearBufferuiv, (unsigned int, int, const unsigned int*))                                          \
    X(void, GenQueries, (int, unsigned int*))                                                                  \
    X(void, DeleteQueries, (int, const unsigned int*))                                                         \
    X(void, GetInteger64v, (unsigned int, int64_t*))

#define DGBGL_OPTIONAL_FUNCTIONS(X)                                                                              \
    X(unsigned char, IsEnabledi, (unsigned int, unsigned int))                                                   \
    X(void, Enablei, (unsigned int, unsigned int))                                                               \
    X(void, Disablei, (unsigned int, unsigned int))                                                              \
    X(void, GetBooleani_v, (unsigned int, unsigned int, unsigned char*))                                         \
    X(void, ColorMaski, (unsigned int, unsigned char, unsigned char, unsigned char, unsigned char))              \
    X(void, PolygonMode, (unsigned int, unsigned int))                                                           \
    X(void, DepthRangef, (float, float))                                                                         \
    X(void, DepthRange, (double, double))                                                                        \
    X(void, GetFloati_v, (unsigned int, unsigned int, float*))                                                   \
    X(void, GetDoublei_v, (unsigned int, unsigned int, double*))                                                 \
    X(void, ViewportIndexedf, (unsigned int, float, float, float, float))                                        \
    X(void, DepthRangeIndexed, (unsigned int, double, double))                                                   \
    X(void, ClipControl, (unsigned int, unsigned int))                                                           \
    X(void, TextureBarrier, (void))                                                                              \
    X(void, MemoryBarrier, (unsigned int))                                                                       \
    X(void, BindImageTexture, (unsigned int, unsigned int, int, unsigned char, int, unsigned int, unsigned int)) \
    X(void, FramebufferTexture, (unsigned int, unsigned int, unsigned int, int))                                 \
    X(void, TexStorage2D, (unsigned int, int, unsigned int, int, int))                                           \
    X(void, TexStorage3D, (unsigned int, int, unsigned int, int, int, int))                                      \
    X(void, ObjectLabel, (unsigned int, unsigned int, int, const char*))                                         \
    X(void, PushDebugGroup, (unsigned int, unsigned int, int, const char*))                                      \
    X(void, PopDebugGroup, (void))                                                                               \
    X(void, QueryCounter, (unsigned int, unsigned int))                                                          \
    X(void, GetQueryObjectiv, (unsigned int, unsigned int, int*))                                                \
    X(void, GetQueryObjectui64v, (unsigned int, unsigned int, uint64_t*))

#if defined(_WIN32) && !defined(_WIN64)
#define DGBGL_CALL __stdcall
#else
#define DGBGL_CALL
#endif

typedef struct dgbgl_functions {
#define DGBGL_MEMBER(result, name, arguments) result(DGBGL_CALL* name) arguments;
    DGBGL_FUNCTIONS(DGBGL_MEMBER)
    DGBGL_OPTIONAL_FUNCTIONS(DGBGL_MEMBER)
#undef DGBGL_MEMBER
} dgbgl_functions;

typedef struct dgbgl_state { /* the engine's, while a dgb_* call runs */
    int draw_framebuffer, read_framebuffer;
    float viewports[DGBGL_MAX_VIEWPORTS][4];
    double depth_ranges[DGBGL_MAX_VIEWPORTS][2];
    unsigned char scissor[DGBGL_MAX_VIEWPORTS];
    unsigned char blend[DGBGL_MAX_DRAW_BUFFERS], color_mask[DGBGL_MAX_DRAW_BUFFERS][4];
    unsigned char toggles[DGBGL_TOGGLE_COUNT];
    int depth_mask, depth_func, polygon_mode[2], clip_origin, clip_depth;
    int program, vertex_array, uniform_buffer, uniform_binding;
    int64_t uniform_start, uniform_size;
    int active_texture, textures_2d[DGBGL_MAX_UNITS + 1], textures_array[DGBGL_MAX_UNITS + 1];
    int samplers[DGBGL_MAX_UNITS + 1];
    int query_buffer, unpack_buffer, unpack[DGBGL_UNPACK_COUNT];
    int images[DGBGL_MAX_IMAGES][6]; /* name, level, layered, layer, access, format */
} dgbgl_state;

typedef struct dgbgl_backend { /* yours to place; its members are the library's, but for the three that say "read" */
    dgb_backend backend;       /* read: hand its address to dgb_desc.backend */
    int version;               /* read: 330 for OpenGL 3.3 */
    bool es;                   /* read: OpenGL ES */
    dgbgl_functions gl;
    dgbgl_desc desc;
    bool indexed_viewports, indexed_buffers, images, query_buffers;
    bool interlock; /* image emission is ordered by the extension, not by a rasteriser known to be in order */
    const char* layer_extension; /* that lets a vertex shader write gl_Layer, or null */
    unsigned int vertex_array, uniform_buffer, sampler;
    unsigned int view_program; /* 0 until dgbgl_draw_view needs it */
    struct {
        unsigned int name;
        int count;
        dgb_target targets[DGB_MAX_TARGETS + 1];
    } framebuffers[DGBGL_MAX_FRAMEBUFFERS];
    int next_framebuffer;
    dgb_pass pass;                        /* that is running */
    dgb_result drawing;                   /* what GL said of the library's own calls since begin */
    dgb_texture narrowed[DGB_MAX_INPUTS]; /* textures whose level range it restricted */
    int narrowed_count;
    struct {
        unsigned int queries[2][2]; /* two frames: begin, end */
        bool pending[2];
        bool running;
        int frame;
        double milliseconds; /* < 0: none yet */
    } timers[DGB_PASS_COUNT];
    dgbgl_state state;
} dgbgl_backend;

/* Loads GL through desc->get_proc and reads the capabilities of the current context. DGB_INVALID without get_proc or
   with a unit or binding that the context does not have, DGB_UNSUPPORTED when the context is too old, DGB_DEVICE when
   an entry point is missing or an object cannot be made; *gl is then zero. */
DGB_API dgb_result dgbgl_init(dgbgl_backend* gl, const dgbgl_desc* desc);
/* Destroys what dgbgl_init and the passes created. Call it after dgb_shutdown. Null and zero are ignored. */
DGB_API void dgbgl_shutdown(dgbgl_backend* gl);

/* Handle of an engine's own GL_TEXTURE_2D. 0 gives no texture. */
DGB_API dgb_texture dgbgl_texture(unsigned int name);
/* GL name of a handle. Layer textures are GL_TEXTURE_2D_ARRAY, all others GL_TEXTURE_2D. */
DGB_API unsigned int dgbgl_texture_name(dgb_texture texture);

/* Text that starts a material shader: #version, extensions, defines, and the library's snippets of the stage. Writes at
   most `capacity` bytes with the final 0, returns the length of the whole text (as snprintf does); 0 for a null or dead
   context, and, with a message, for a varying that is not as dgbgl_varying says.
   `varyings` lists the engine's own varyings from vertex to fragment shader; it may be null when count is 0. */
DGB_API size_t dgbgl_shader_prefix(const dgb_context* context, dgbgl_stage stage, const dgbgl_varying* varyings,
                                   int count, char* text, size_t capacity);
/* The whole geometry shader for the context's emission; the length is 0 when the emission needs none. */
DGB_API size_t dgbgl_geometry_shader(const dgb_context* context, const dgbgl_varying* varyings, int count, char* text,
                                     size_t capacity);
/* Connects a program that contains the snippets to the draw block and to the oracle, once after linking. DGB_INVALID
   for what is no program or not linked. */
DGB_API dgb_result dgbgl_attach_program(const dgb_context* context, unsigned int program);

typedef struct dgbgl_calibration { /* an engine's own scene, to time emissions with */
    const dgb_view* view;
    const dgb_params* params;
    bool (*prepare)(void* user, const dgb_context* context); /* makes the programs for a context; false: leave it out */
    void (*release)(void* user);                             /* destroys them again; may be null */
    dgb_draw_fn draw;
    void* user;
    int frames; /* timed for each emission; 0: 8 */
} dgbgl_calibration;

/* Builds the layers of the engine's own scene with each emission that the device offers, times them between two
   glFinish, and writes the fastest into desc->emission. When that is SEPARATE and desc->oracle is default, desc->oracle
   becomes PEEL, which costs the same and is exact. For start-up: takes some ten frames an emission. milliseconds (may
   be null): the least time of each emission, < 0 where it could not be used; the best of all under DGB_EMISSION_AUTO.
   DGB_INVALID for null arguments, DGB_UNSUPPORTED without a clock (OpenGL ES) or when no emission could be prepared;
   *desc is then untouched. */
DGB_API dgb_result dgbgl_calibrate(dgbgl_backend* gl, const dgbgl_calibration* calibration, dgb_desc* desc,
                                   double milliseconds[DGB_EMISSION_COUNT]);

/* GLSL of dgb_fallback(probe, visibility, irradiance) and dgb_mirror(environment, reflection), which mix what the
   library found with a probe's light and an environment map's by its confidence, and, for DGB_BENT, of
   dgb_bent_direction(bent, normal), dgb_bent_cosine(bent) and dgb_probe_visible(radiance, texels, bent, normal), the
   light of a prefiltered cube map from where a point is open: put it into the shader that composites, after #version.
   As snprintf. */
DGB_API size_t dgbgl_composite_snippet(char* text, size_t capacity);

/* What dgbgl_draw_view can show. X(name, word, slot, legend); those up to VALIDITY are of one layer. */
#define DGBGL_VIEWS(X)                                                                                            \
    X(DEPTH, "depth", DGB_DEPTH, "near is white, far is black, nothing is blue")                                  \
    X(NORMAL, "normal", DGB_NORMAL, "camera space: x red, y green, z blue; grey is 0")                            \
    X(ALBEDO, "albedo", DGB_ALBEDO, "what a surface reflects")                                                    \
    X(RADIANCE, "radiance", DGB_RADIANCE, "what a surface sends: its emission and direct light")                  \
    X(VELOCITY, "velocity", DGB_VELOCITY, "motion since the last frame: right is red, up is green, grey is none") \
    X(VALIDITY, "validity", DGB_DEPTH, "cyan: the layer has a surface; red: had one, too near to the first")      \
    X(AO, "ao", DGB_AO, "ambient visibility: 1 is open")                                                          \
    X(IRRADIANCE, "irradiance", DGB_IRRADIANCE, "bounced light as white paper would show it")                     \
    X(CONFIDENCE, "confidence", DGB_IRRADIANCE, "how far light is known: black not at all")                       \
    X(HISTORY, "history", DGB_FRAMES, "frames averaged: black none, red few, white as many as count")             \
    X(REFLECTION, "reflection", DGB_REFLECTION, "what a mirror or lobe shows, by its confidence")                 \
    X(REFLECTION_LAYER, "reflection_layer", DGB_REFLECTION_HIT,                                                   \
      "where the ray ended: blue layer 0, orange layer 1, black none")                                            \
    X(LIGHT, "light", DGB_SLOT_NONE, "linear light of a texture of your own")

typedef enum dgbgl_view {
#define DGBGL_VIEW_ENUM(name, word, slot, legend) DGBGL_VIEW_##name,
    DGBGL_VIEWS(DGBGL_VIEW_ENUM)
#undef DGBGL_VIEW_ENUM
        DGBGL_VIEW_COUNT
} dgbgl_view;

typedef struct dgbgl_view_desc { /* 0 means default */
    dgbgl_view view;
    int layer;               /* of DEPTH to VALIDITY */
    int x, y, width, height; /* rectangle of the framebuffer, pixels; default size: the image's */
    float exposure;          /* factor of light; default 1 */
    float depth_range;       /* distance at which DEPTH has fallen to an eighth, m; default 20 */
    unsigned int texture;    /* LIGHT: a GL_TEXTURE_2D of the image's size */
} dgbgl_view_desc;

/* To look at what a context holds: draws it, without its guard band, into the framebuffer that is bound, in sRGB
   values, within the scissor if that test is on. All other state is kept. The first call compiles a program. A texture
   that changes places with last frame's (dgb_get_texture) is that of the last dgb_build and dgb_shade.
   DGB_INVALID, a message, and nothing drawn where the context has no such layer or texture, or for wrong arguments;
   DGB_OUT_OF_MEMORY or DGB_DEVICE where the driver refuses. */
DGB_API dgb_result dgbgl_draw_view(const dgb_context* context, const dgbgl_view_desc* view);
DGB_API const char* dgbgl_view_name(dgbgl_view view);   /* "reflection_layer"; "?" out of range, here and below */
DGB_API const char* dgbgl_view_legend(dgbgl_view view); /* what its colours mean */

/* Text of a full-screen pass, for inspection and offline compilers. program: of a plan, null: 0. version: as
   dgbgl_backend.version. As snprintf. */
DGB_API size_t dgbgl_pass_source(const dgb_program_desc* program, dgbgl_stage stage, int version, bool es, char* text,
                                 size_t capacity);

/* Time of a pass two frames ago on the GPU's clock, all of its steps. false, *milliseconds untouched: no timers here,
   no result yet, or null or a pass out of range. Never waits. */
DGB_API bool dgbgl_pass_time(const dgbgl_backend* gl, dgb_pass_id pass, double* milliseconds);

#ifdef __cplusplus
}
#endif

#endif /* DEEPGBUFFER_GL_H */

#if defined(DEEPGBUFFER_IMPLEMENTATION) && !defined(DEEPGBUFFER_GL_IMPLEMENTED)
#define DEEPGBUFFER_GL_IMPLEMENTED

#include <string.h>

#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* >> shader text: edited in shaders_embedded/, copied here by `make embed` */

/* >> embedded GLSL: written by shaders_embedded/embed.c from shaders_embedded/; run "make embed" */
/* clang-format off */

static const char* const dgbgli_glsl_common[] = { /* 00_common.glsl */
    "#line 1\n"
    "// Mathematics shared by every pass. Each function is the twin of the C function of the same name in deepgbuffer.h, which\n"
    "// documents it. NaN is removed by selects (a comparison with NaN is false), never by min, max or clamp, whose treatment of\n"
    "// NaN differs between implementations.\n"
    "\n"
    "const float DGB_PI           = 3.14159265358979;\n"
    "const float DGB_MAX_RADIANCE = 64512.0;\n"
    "const float DGB_MAX_DISTANCE = 1e15;\n"
    "const float DGB_EMPTY_Z      = -1e15; // packed z of no surface: so far away that it reaches nothing\n"
    "const float DGB_MIN_COSINE   = 0.017;\n"
    "const float DGB_MIN_ROUGHNESS = 1.0 / 512.0;\n"
    "const int   DGB_LOG2_TILE    = 4; // tiles are 16 x 16 pixels\n"
    "\n"
    "struct dgb_camera {\n"
    "    vec4 linearise;\n"
    "    vec4 position_z;\n"
    "    vec4 position_1;\n"
    "    vec4 footprint;\n"
    "};\n"
    "\n"
    "// Oct16: two bytes as the unorm8 channels of a texture hold them.\n"
    "vec2 dgb_sign(vec2 v) { return vec2(v.x < 0.0 ? -1.0 : 1.0, v.y < 0.0 ? -1.0 : 1.0); }\n"
    "\n"
    "// A direction on the unfolded octahedron, -1..1, and back.\n"
    "vec2 dgb_octahedral(vec3 n) {\n"
    "    float s     = abs(n.x) + abs(n.y) + abs(n.z);\n"
    "    bool  valid = s > 1e-30 && s < 1e30;\n"
    "    vec2  p     = valid ? n.xy / s : vec2(0.0);\n"
    "    return valid && n.z < 0.0 ? (1.0 - abs(p.yx)) * dgb_sign(p) : p;\n"
    "}\n"
    "\n"
    "// The direction that they mean, of any length: enough where only a sign is asked for.\n"
    "vec3 dgb_unfolded(vec2 p) {\n"
    "    float z = 1.0 - abs(p.x) - abs(p.y);\n"
    "    uvec2 fold = floatBitsToUint(vec2(max(-z, 0.0))) | (floatBitsToUint(p) & 0x80000000u); // with the signs of p\n"
    "    return vec3(p - uintBitsToFloat(fold), z); // what lies below the equator is folded back\n"
    "}\n"
    "\n"
    "vec3 dgb_from_octahedral(vec2 p) { return normalize(dgb_unfolded(p)); }\n"
    "\n"
    "vec2 dgb_oct16_encode(vec3 n) { return (floor(dgb_octahedral(n) * 127.0 + 0.5) + 127.0) / 255.0; }\n"
    "\n"
    "vec3 dgb_oct16_direction(vec2 bytes) { return dgb_unfolded(min(bytes * (255.0 / 127.0) - 1.0, 1.0)); }\n"
    "\n"
    "vec3 dgb_oct16_decode(vec2 bytes) { return normalize(dgb_oct16_direction(bytes)); }\n"
    "\n"
    "float dgb_storable(float x) { return x > 0.0 ? (x < DGB_MAX_RADIANCE ? x : DGB_MAX_RADIANCE) : 0.0; }\n"
    "\n"
    "vec3 dgb_storable(vec3 v) { return vec3(dgb_storable(v.x), dgb_storable(v.y), dgb_storable(v.z)); }\n"
    "\n"
    "// The same for parts of directions and shares: what is beyond -1..1, or NaN, becomes 0.\n"
    "vec4 dgb_storable_unit(vec4 v) { return mix(vec4(0.0), v, lessThanEqual(abs(v), vec4(1.0))); }\n"
    "\n"
    "// The nearest value >= 0 that a small float of so many mantissa bits holds. Implementations round or truncate what they store;\n"
    "// truncated bounce after bounce, light loses a tenth, and its blue a fifth.\n"
    "float dgb_nearest(float x, int bits) {\n"
    "    int   shift = 23 - bits;\n"
    "    float least = exp2(float(-14 - bits)); // step of the subnormal values, below 2^-14\n"
    "    uint  code  = (floatBitsToUint(x) + (1u << (shift - 1))) >> shift << shift;\n"
    "    return x < 6.103515625e-5 ? floor(x / least + 0.5) * least : uintBitsToFloat(code);\n"
    "}\n"
    "\n"
    "vec3 dgb_nearest(vec3 v) { return vec3(dgb_nearest(v.x, 6), dgb_nearest(v.y, 6), dgb_nearest(v.z, 5)); }\n"
    "\n"
    "vec4 dgb_dithered(vec4 x, vec4 u) {\n"
    "    uvec4 below  = 2u + uvec4(u * 8188.0);\n"
    "    vec4  coarse = uintBitsToFloat((floatBitsToUint(x) + below) & 0xffffe000u);\n"
    "    vec4  fine   = floor(x * 16777216.0 + vec4(below) / 8192.0) / 16777216.0;\n"
    "    return mix(fine, coarse, greaterThanEqual(abs(x), vec4(6.103515625e-5)));\n"
    "}\n"
    "\n"
    "int dgb_pixel_hash(ivec2 pixel, int frame) {\n"
    "    uint h = uint(pixel.x) * 0x8da6b343u ^ uint(pixel.y) * 0xd8163841u;\n"
    "    h      = (h ^ (h >> 16)) * 0x7feb352du;\n"
    "    h      = (h ^ (h >> 15)) * 0x846ca68bu;\n"
    "    return int(((h >> 24) + uint(frame) * 159u) & 255u);\n"
    "}\n"
    "\n"
    "vec2 dgb_pixel_pair(ivec2 pixel, int frame) {\n"
    "    uint h = uint(pixel.x) * 0x8da6b343u ^ uint(pixel.y) * 0xd8163841u;\n"
    "    h      = (h ^ (h >> 16)) * 0x7feb352du;\n"
    "    h      = (h ^ (h >> 15)) * 0x846ca68bu;\n"
    "    uint g = (h ^ (h >> 16)) * 0x2c1b3c6du;\n"
    "    g      = (g ^ (g >> 15)) * 0x297a2d39u;\n"
    "    uvec2 turns = uvec2(h, g) + uint(frame) * uvec2(3242174889u, 2447445414u);\n"
    "    return (vec2(turns >> 9u) + 0.5) / 8388608.0;\n"
    "}\n"
    "\n",
    "int dgb_hilbert_index(ivec2 pixel) {\n"
    "    uvec2 p     = uvec2(pixel);\n"
    "    uint  index = 0u;\n"
    "    for (int bit = 5; bit >= 0; --bit) {\n"
    "        uvec2 quarter = (p >> uint(bit)) & 1u; // right, upper\n"
    "        index         = index << 2u | ((3u * quarter.x) ^ quarter.y);\n"
    "        p             = quarter.y == 0u ? p.yx ^ (0u - quarter.x) : p;\n"
    "    }\n"
    "    return int(index);\n"
    "}\n"
    "\n"
    "vec4 dgb_pixel_quad(ivec2 pixel, int frame) {\n"
    "    uint place = uint(dgb_hilbert_index(pixel)) + uint(frame) * 288u + 1u;\n"
    "    return (vec4((place * uvec4(3242174889u, 2447445414u, 2700274806u, 2313257605u)) >> 9u) + 0.5) / 8388608.0;\n"
    "}\n"
    "\n"
    "int dgb_mip_level(float h, int log2_q, int min_level, int max_level) {\n"
    "    // in brackets: what is the same for all taps\n"
    "    return h > 0.0 ? clamp((floatBitsToInt(h) >> 23) - (127 + log2_q), min_level, max_level) : min_level;\n"
    "}\n"
    "\n"
    "// All bits set where a coordinate is odd.\n"
    "ivec2 dgb_odd(ivec2 p) {\n"
    "#if __VERSION__ >= 400\n"
    "    return bitfieldExtract(p, 0, 1); // with its sign: one instruction\n"
    "#else // 330 and 300 es have none\n"
    "    return -(p & 1);\n"
    "#endif\n"
    "}\n"
    "\n"
    "ivec2 dgb_mip_source(ivec2 p, int level) {\n"
    "    ivec2 odd_texel = dgb_odd(p);\n"
    "    return (p << level) | (odd_texel.yx & (0xaaaa >> (16 - level))) | (odd_texel & (0x5555 >> (16 - level)));\n"
    "}\n"
    "\n"
    "float dgb_depth_code(float depth, float codes) {\n"
    "    float scaled = depth * codes;\n"
    "    if (!(codes > 0.0) || !(scaled >= 0.0 && scaled <= codes)) return depth;\n"
    "    return (scaled < 8388608.0 ? floor(scaled + 0.5) : scaled) / codes;\n"
    "}\n"
    "\n"
    "float dgb_linear_z(float depth, dgb_camera camera) {\n"
    "    float t           = depth - camera.footprint.w;\n"
    "    float z           = (camera.linearise.x + camera.linearise.y * t) / (camera.linearise.z + camera.linearise.w * t);\n"
    "    bool  perspective = camera.linearise.w != 0.0; // footprint.y says the same, but is one uniform more to read\n"
    "    return abs(z) <= DGB_MAX_DISTANCE && t != 0.0 && (!perspective || z < 0.0) ? z : 0.0;\n"
    "}\n"
    "\n"
    "vec3 dgb_position(vec2 pixel, float z, dgb_camera camera) {\n"
    "    vec4 a = camera.position_z, b = camera.position_1;\n"
    "    return vec3((pixel * a.xy + a.zw) * z + (pixel * b.xy + b.zw), z);\n"
    "}\n"
    "\n"
    "// A point that offsets are from.\n"
    "struct dgb_origin {\n"
    "    vec2  pixel; // where it is seen\n"
    "    float z;\n"
    "    vec2  side; // metres between pixels at its depth\n"
    "};\n"
    "\n"
    "dgb_origin dgb_origin_at(vec2 pixel, float z, dgb_camera camera) {\n"
    "    return dgb_origin(pixel, z, camera.position_z.xy * z + camera.position_1.xy);\n"
    "}\n"
    "\n"
    "// To what a pixel shows at depth z: the difference of two dgb_position, but cheaper where many share an origin, and exact where\n"
    "// that cancels: to the origin itself it is 0.\n"
    "vec3 dgb_offset(vec2 pixel, float z, dgb_origin o, dgb_camera camera) {\n"
    "    vec2  ray = pixel * camera.position_z.xy + camera.position_z.zw;\n"
    "    float dz  = z - o.z;\n"
    "    return vec3(ray * dz + (pixel - o.pixel) * o.side, dz);\n"
    "}\n"
    "\n"
    "// Pixel position of a camera-space point.\n"
    "vec2 dgb_project(vec3 point, dgb_camera camera) {\n"
    "    vec4 a = camera.position_z, b = camera.position_1;\n"
    "    return (point.xy - a.zw * point.z - b.zw) / (a.xy * point.z + b.xy);\n"
    "}\n"
    "\n"
    "// Unit vector from the eye to a point.\n"
    "vec3 dgb_view(vec3 point, dgb_camera camera) { return camera.footprint.y != 0.0 ? normalize(point) : vec3(0.0, 0.0, -1.0); }\n"
    "\n"
    "#ifdef DGB_DIVISOR\n"
    "// Where in the image the texel of a layer lies that a pixel shows: deeper layers may have a lower resolution.\n"
    "vec2 dgb_centre(int layer, ivec2 pixel) {\n"
    "    int divisor = layer > 0 ? DGB_DIVISOR : 1;\n"
    "    return (vec2(pixel / divisor) + 0.5) * float(divisor);\n"
    "}\n"
    "#endif\n"
    "\n"
    "float dgb_pixels_per_metre(float z, dgb_camera camera) {\n"
    "    float w = camera.footprint.y * z + camera.footprint.z;\n"
    "    return w > 0.0 ? camera.footprint.x / w : 0.0;\n"
    "}\n"
    "\n"
    "// Pixels that a radius (m) covers at depth z, `most` of them at most.\n"
    "float dgb_reach(float z, float radius, float most, dgb_camera camera) {\n"
    "    return min(dgb_pixels_per_metre(z, camera) * radius, most);\n"
    "}\n"
    "\n"
    "bool dgb_keep_test(float z, float z_front, float separation) { return z_front != 0.0 && -z > -z_front + separation; }\n",
    "\n"
    "// The square, so that the larger of two layers is known before a root is taken. For finite v and epsilon > 0, which the\n"
    "// passes guarantee; dgb_ao_term below takes anything.\n"
    "float dgb_ao_term_squared(vec3 v, vec3 n, float inv_r2, float beta, float epsilon) {\n"
    "    float d2 = dot(v, v);\n"
    "    float a  = max(1.0 - d2 * inv_r2, 0.0) * max(dot(vec4(v, 1.0), vec4(n, -beta)), 0.0);\n"
    "    return a * a / (d2 + epsilon);\n"
    "}\n"
    "\n"
    "float dgb_ao_term(vec3 v, vec3 n, float inv_r2, float beta, float epsilon) {\n"
    "    float squared = dgb_ao_term_squared(v, n, inv_r2, beta, epsilon);\n"
    "    return squared > 0.0 && squared <= 1.0 ? sqrt(squared) : 0.0;\n"
    "}\n"
    "\n"
    "float dgb_ambient_visibility(float sum, float pi_over_count) {\n"
    "    return sum > 0.0 ? max(1.0 - sqrt(pi_over_count * sum), 0.0) : 1.0;\n"
    "}\n"
    "\n"
    "float dgb_gather_term(vec3 v, vec3 n_x, float r2) {\n"
    "    float d2     = dot(v, v);\n"
    "    float cosine = dot(v, n_x) * inversesqrt(d2);\n"
    "    return d2 <= r2 && cosine > DGB_MIN_COSINE ? cosine : 0.0;\n"
    "}\n"
    "\n"
    "float dgb_gather_scale(float sum_cos, float count, float k) {\n"
    "    return count > 0.0 ? DGB_PI / max(sum_cos * k, 0.5 * count) : 0.0;\n"
    "}\n"
    "\n"
    "float dgb_boost(vec3 albedo, float unsaturated, float saturated) {\n"
    "    const float largest = 3.4028234e38;\n"
    "    float       high = 0.0, low = largest;\n"
    "    for (int i = 0; i < 3; ++i) { // NaN changes neither\n"
    "        high = albedo[i] > high ? albedo[i] : high;\n"
    "        low  = albedo[i] < low ? albedo[i] : low;\n"
    "    }\n"
    "    low = max(low, 0.0);\n"
    "    return unsaturated + (saturated - unsaturated) * (high > low && high <= largest ? (high - low) / high : 0.0);\n"
    "}\n"
    "\n"
    "// Irradiance and its confidence are averaged with the confidence as weight: a pixel whose taps found nothing says nothing.\n"
    "vec4 dgb_weigh(vec4 irradiance) { return vec4(irradiance.rgb * irradiance.a, irradiance.a); }\n"
    "\n"
    "vec4 dgb_unweigh(vec4 weighed) { return vec4(weighed.a > 0.0 ? weighed.rgb / weighed.a : vec3(0.0), weighed.a); }\n"
    "\n"
    "float dgb_bilateral_weight(vec3 n, vec3 n2, vec3 dq, float normal_sharpness, float plane_sharpness) {\n"
    "    float normal = max(1.0 - normal_sharpness * (1.0 - dot(n, n2)), 0.0);\n"
    "    float d2     = dot(dq, dq);\n"
    "    float off    = max(abs(dot(dq, n)), abs(dot(dq, n2)));\n"
    "    float plane  = d2 > 0.0 ? max(1.0 - plane_sharpness * off * inversesqrt(d2), 0.0) : 1.0;\n"
    "    return normal * plane * plane;\n"
    "}\n"
    "\n"
    "float dgb_ggx_alpha(float roughness) { return roughness >= DGB_MIN_ROUGHNESS ? (roughness < 1.0 ? roughness * roughness : 1.0) : 0.0; }\n"
    "\n"
    "vec3 dgb_ggx_normal(vec3 v, vec3 n, float alpha, vec2 u) {\n"
    "    float along     = dot(v, n);\n"
    "    vec3  stretched = normalize(alpha * (v - along * n) + max(along, 0.0) * n);\n"
    "    // the cap of the unit sphere that the stretched viewer sees, uniformly: about n, from the pole down to its horizon\n"
    "    float height = 1.0 - u.y * (1.0 + dot(stretched, n)), radius = sqrt(max(1.0 - height * height, 0.0)), turn = 2.0 * DGB_PI * u.x;\n"
    "    float side   = n.z < 0.0 ? -1.0 : 1.0, a = -1.0 / (side + n.z), b = n.x * n.y * a;\n"
    "    vec3  s      = vec3(1.0 + side * n.x * n.x * a, side * b, -side * n.x), t = vec3(b, side + n.y * n.y * a, -n.y);\n"
    "    vec3  m      = stretched + radius * (cos(turn) * s + sin(turn) * t) + height * n; // halfway\n"
    "    float up     = dot(m, n);\n"
    "    vec3  h      = normalize(alpha * (m - up * n) + up * n);\n"
    "    return alpha > 0.0 ? (dot(v, h) >= 0.0 ? h : v) : n;\n"
    "}\n"
    "\n"
    "float dgb_ggx_density(vec3 v, vec3 n, vec3 l, float alpha) {\n"
    "    vec3  h       = v + l, off = cross(n, h);\n"
    "    float h2      = dot(h, h), up = dot(h, n), a2 = alpha * alpha, k = a2 * up * up + dot(off, off);\n"
    "    float along   = max(dot(v, n), 0.0);\n"
    "    float masking = 2.0 * (along + sqrt(a2 + (1.0 - a2) * along * along)); // 4 n.v / G1\n"
    "    float density = a2 * h2 * h2 / (DGB_PI * k * k * masking);\n"
    "    if (!(alpha > 0.0)) return 0.0; // a test of its own: of two, compilers make one of the lesser, and NaN is not less\n"
    "    return up > 0.0 ? density : 0.0;\n"
    "}\n",
    0
};

static const char* const dgbgli_glsl_fullscreen[] = { /* 05_fullscreen.glsl */
    "#line 50001\n"
    "// Vertex shader of every full-screen pass: one triangle that covers the viewport, without a vertex buffer.\n"
    "\n"
    "void main() {\n"
    "    vec2 corner = vec2(float((gl_VertexID & 1) << 2), float((gl_VertexID & 2) << 1)); // (0,0) (4,0) (0,4)\n"
    "    gl_Position = vec4(corner - 1.0, 0.0, 1.0);\n"
    "}\n",
    0
};

static const char* const dgbgli_glsl_warp[] = { /* 08_warp.glsl */
    "#line 80001\n"
    "// Warp: last frame's depth as this frame's camera sees it, for a world that stands still. One run a layer. A guess of the depth at\n"
    "// a pixel says which texel of last frame to look at, and what is there is the next guess (a fixed point). It starts twice: from\n"
    "// the depth that the pixel had, and from the nearest depth around it, which finds what comes in front.\n"
    "\n"
    "layout(std140) uniform dgb_warp_block {\n"
    "    dgb_camera dgb_warp_camera;\n"
    "    dgb_camera dgb_warp_last;\n"
    "    vec4       dgb_warp_to_last[3]; // rows: from this frame's camera space to last frame's\n"
    "    ivec4      dgb_warp_layer;      // layer, pixels a texel along one side, last column and row of texels\n"
    "    vec4       dgb_warp_depth;      // depth codes\n"
    "};\n"
    "\n"
    "uniform sampler2DArray dgb_oracle; // last frame's depth\n"
    "\n"
    "const int   DGB_WARP_LOOKS = 3;     // texels looked at from each start\n"
    "const float DGB_WARP_INSIDE = 0.505; // texels from a texel's centre that are still it: half, and rounding\n"
    "\n"
    "// The pixel's ray in last frame's camera space: z of this frame's camera times `along`, plus `from`.\n"
    "struct dgb_ray {\n"
    "    vec3 along, from;\n"
    "};\n"
    "\n"
    "struct dgb_find {\n"
    "    float z;     // camera space, m\n"
    "    float depth; // of the texel looked at\n"
    "    float off;   // texels from its centre to where the point was, the larger of x and y\n"
    "};\n"
    "\n"
    "vec3 dgb_to_last(vec3 v, float w) {\n"
    "    vec4 point = vec4(v, w);\n"
    "    return vec3(dot(dgb_warp_to_last[0], point), dot(dgb_warp_to_last[1], point), dot(dgb_warp_to_last[2], point));\n"
    "}\n"
    "\n"
    "float dgb_last_depth(ivec2 texel) {\n"
    "    return texelFetch(dgb_oracle, ivec3(clamp(texel, ivec2(0), dgb_warp_layer.zw), dgb_warp_layer.x), 0).r;\n"
    "}\n"
    "\n"
    "// Sky lies on the far plane, or where there is none at the greatest distance.\n"
    "float dgb_last_z(float depth) {\n"
    "    float z   = dgb_linear_z(dgb_depth_code(depth, dgb_warp_depth.x), dgb_warp_last);\n"
    "    float far = dgb_warp_last.linearise.x / dgb_warp_last.linearise.z;\n"
    "    return z != 0.0 ? z : abs(far) <= DGB_MAX_DISTANCE ? far : DGB_EMPTY_Z;\n"
    "}\n"
    "\n"
    "// Where the point at z was, in texels of last frame; beyond the buffer, on its border.\n"
    "vec2 dgb_last_texel(dgb_ray ray, float z) {\n"
    "    vec2 texel = dgb_project(ray.along * z + ray.from, dgb_warp_last) / float(dgb_warp_layer.y);\n"
    "    return clamp(texel, vec2(0.0), vec2(dgb_warp_layer.zw) + 1.0);\n"
    "}\n"
    "\n"
    "dgb_find dgb_look(dgb_ray ray, float z_last) {\n"
    "    dgb_find find;\n"
    "    vec2     at;\n"
    "    float    z = (z_last - ray.from.z) / ray.along.z; // exactly z_last when the camera stands still\n"
    "    for (int i = 0; i < DGB_WARP_LOOKS; ++i) {\n"
    "        at         = floor(dgb_last_texel(ray, z));\n"
    "        find.depth = dgb_last_depth(ivec2(at));\n"
    "        z          = (dgb_last_z(find.depth) - ray.from.z) / ray.along.z;\n"
    "    }\n"
    "    vec2 off = abs(dgb_last_texel(ray, z) - (min(at, vec2(dgb_warp_layer.zw)) + 0.5));\n"
    "    find.z   = z;\n"
    "    find.off = max(off.x, off.y);\n"
    "    return find;\n"
    "}\n"
    "\n"
    "// Nearest depth among the pixel and eight around it, as far off as things come nearer in a frame. Reversed depth is compared\n"
    "// with its sign changed.\n"
    "float dgb_nearest_around(ivec2 texel) {\n"
    "    float empty = dgb_warp_last.footprint.w, order = empty > 0.0 ? 1.0 : -1.0, nearest = order * empty;\n"
    "    for (int y = -16; y <= 16; y += 16)\n"
    "        for (int x = -16; x <= 16; x += 16) nearest = min(nearest, order * dgb_last_depth(texel + ivec2(x, y)));\n"
    "    return dgb_last_z(order * nearest);\n"
    "}\n"
    "\n"
    "// The inverse of dgb_linear_z.\n"
    "float dgb_depth_of(float z, dgb_camera camera) {\n"
    "    vec4 l = camera.linearise;\n"
    "    return (l.x - l.z * z) / (l.w * z - l.y) + camera.footprint.w;\n"
    "}\n"
    "\n"
    "void main() {\n"
    "    ivec2    texel = ivec2(gl_FragCoord.xy);\n"
    "    vec2     pixel = gl_FragCoord.xy * float(dgb_warp_layer.y);\n"
    "    vec3     one   = dgb_position(pixel, 1.0, dgb_warp_camera), zero = dgb_position(pixel, 0.0, dgb_warp_camera);\n"
    "    dgb_ray  ray   = dgb_ray(dgb_to_last(one - zero, 0.0), dgb_to_last(zero, 1.0));\n"
    "    float    own   = dgb_last_depth(texel);\n"
    "    dgb_find a     = dgb_look(ray, dgb_last_z(own)), b = dgb_look(ray, dgb_nearest_around(texel));\n",
    "    bool     a_in  = a.off <= DGB_WARP_INSIDE, b_in = b.off <= DGB_WARP_INSIDE;\n"
    "    // the nearer of two surfaces that are there, else what is least far off\n"
    "    if (b_in ? !a_in || b.z > a.z : !a_in && b.off < a.off) a = b;\n"
    "    float same   = dgb_linear_z(dgb_depth_code(a.depth, dgb_warp_depth.x), dgb_warp_camera);\n"
    "    float depth  = a.z == same ? a.depth : dgb_depth_of(a.z, dgb_warp_camera);\n"
    "    gl_FragDepth = same == 0.0 ? dgb_warp_camera.footprint.w : depth >= 0.0 && depth <= 1.0 ? depth : own;\n"
    "}\n",
    0
};

static const char* const dgbgli_glsl_layers[] = { /* 10_layers.glsl */
    "#line 100001\n"
    "// Start of every material shader that draws into the layers: what the keep test needs to know about the frame.\n"
    "\n"
    "const int DGB_ORACLE_REPROJECT = 3;\n"
    "\n"
    "layout(std140) uniform dgb_draw_block {\n"
    "    dgb_camera dgb_draw_camera;\n"
    "    dgb_camera dgb_draw_previous;          // of the frame that the oracle holds\n"
    "    vec4       dgb_draw_distance;          // distance = dot(this.xyz, vec3(clip.z, clip.w, 1))\n"
    "    vec4       dgb_draw_previous_distance;\n"
    "    vec4       dgb_draw_size;              // buffer width, height (pixels), separation (m), depth codes (0: float depth)\n"
    "    ivec4      dgb_draw_layer;             // first layer, layer count, oracle, instance multiplier\n"
    "    ivec4      dgb_draw_flags;             // divisor of deeper layers' resolution, 1 for reversed depth\n"
    "};\n",
    0
};

static const char* const dgbgli_glsl_layers_vertex[] = { /* 11_layers_vertex.glsl */
    "#line 110001\n"
    "// Vertex part. Call dgb_vertex once, last; use dgb_instance() instead of gl_InstanceID.\n"
    "\n"
    "out vec4      dgb_v_current;  // clip x, y in pixels times w; clip w; distance in metres\n"
    "out vec4      dgb_v_previous; // the same point's, one frame ago\n"
    "#if !(DGB_EMISSION_SEPARATE || DGB_EMISSION_IMAGE)\n"
    "flat out int  dgb_v_layer;\n"
    "#endif\n"
    "\n"
    "int dgb_instance() { return gl_InstanceID / dgb_draw_layer.w; }\n"
    "\n"
    "// clip: gl_Position of this frame; previous_clip: where the same point of the same object was last frame.\n"
    "void dgb_vertex(vec4 clip, vec4 previous_clip) {\n"
    "    vec2 scale     = 0.5 * dgb_draw_size.xy;\n"
    "    gl_Position    = clip;\n"
    "    dgb_v_current  = vec4(clip.xy * scale, clip.w, dot(dgb_draw_distance.xyz, vec3(clip.zw, 1.0)));\n"
    "    dgb_v_previous = vec4(previous_clip.xy * scale, previous_clip.w,\n"
    "                          dot(dgb_draw_previous_distance.xyz, vec3(previous_clip.zw, 1.0)));\n"
    "#if !(DGB_EMISSION_SEPARATE || DGB_EMISSION_IMAGE)\n"
    "    dgb_v_layer = dgb_draw_layer.x;\n"
    "#endif\n"
    "#if DGB_EMISSION_VERTEX\n"
    "    dgb_v_layer += gl_InstanceID % dgb_draw_layer.w;\n"
    "    gl_Layer = dgb_v_layer; // ignored while layers are drawn one at a time\n"
    "#if DGB_DIVISOR > 1\n"
    "    gl_ViewportIndex = dgb_draw_layer.y > 1 && dgb_v_layer > 0 ? 1 : 0;\n"
    "#endif\n"
    "#endif\n"
    "}\n",
    0
};

static const char* const dgbgli_glsl_layers_fragment[] = { /* 12_layers_fragment.glsl */
    "#line 120001\n"
    "// Fragment part. Discard on alpha first, then `if (!dgb_keep()) discard;`, then dgb_store.\n"
    "\n"
    "in vec4 dgb_v_current;\n"
    "in vec4 dgb_v_previous;\n"
    "#if DGB_EMISSION_MULTICAST\n"
    "#define dgb_v_layer (dgb_draw_layer.y > 1 ? gl_Layer : dgb_draw_layer.x)\n"
    "#elif DGB_EMISSION_SEPARATE || DGB_EMISSION_IMAGE\n"
    "#define dgb_v_layer dgb_draw_layer.x // no varying: small triangles pay for each\n"
    "#else\n"
    "flat in int dgb_v_layer;\n"
    "#endif\n"
    "\n"
    "#if DGB_KEEP_TEST\n"
    "uniform sampler2DArray dgb_oracle;\n"
    "#endif\n"
    "\n"
    "#ifdef DGB_ALBEDO_LOCATION\n"
    "layout(location = DGB_ALBEDO_LOCATION) out vec4 dgb_out_albedo;\n"
    "#endif\n"
    "#ifdef DGB_NORMAL_LOCATION\n"
    "layout(location = DGB_NORMAL_LOCATION) out vec4 dgb_out_normal;\n"
    "#endif\n"
    "#ifdef DGB_RADIANCE_LOCATION\n"
    "layout(location = DGB_RADIANCE_LOCATION) out vec4 dgb_out_radiance;\n"
    "#endif\n"
    "#ifdef DGB_VELOCITY_LOCATION\n"
    "layout(location = DGB_VELOCITY_LOCATION) out vec4 dgb_out_velocity;\n"
    "#endif\n"
    "\n"
    "// Pixels that this point moved since the last frame.\n"
    "vec2 dgb_velocity() {\n"
    "    return dgb_v_current.xy / dgb_v_current.z - dgb_v_previous.xy / dgb_v_previous.z;\n"
    "}\n"
    "\n"
    "// Some software rasterisers gather every uniform for every lane, so the keep test reads few: what is known when the program is\n"
    "// made is a constant, the size is the texture's.\n"
    "float dgb_oracle_z(float depth, dgb_camera camera) {\n"
    "    camera.footprint.w = float(1 - DGB_REVERSED); // the empty depth\n"
    "    return dgb_linear_z(dgb_depth_code(depth, float(DGB_DEPTH_CODES)), camera);\n"
    "}\n"
    "\n"
    "// Whether this fragment belongs to a layer behind the first: it lies behind the layer before it, in the oracle, by more than\n"
    "// the separation (paper, Listing 2). Both depths go through the same function, and REPROJECT adds differences that are exactly 0\n"
    "// when nothing moves: then every oracle gives what peeling gives, bit for bit.\n"
    "bool dgb_kept_in(int layer) {\n"
    "#if DGB_KEEP_TEST\n"
    "    vec2  pixel = gl_FragCoord.xy * float(DGB_DIVISOR); // of the first layer\n"
    "    float z     = dgb_oracle_z(gl_FragCoord.z, dgb_draw_camera);\n"
    "    if (dgb_draw_layer.z == DGB_ORACLE_REPROJECT) {\n"
    "        vec2 then = pixel - dgb_velocity(), size = vec2(textureSize(dgb_oracle, 0).xy);\n"
    "        // behind the previous eye or off its buffer: judged at its own pixel, as PREVIOUS does\n"
    "        if (dgb_v_previous.z > 0.0 && then.x >= 0.0 && then.y >= 0.0 && then.x < size.x && then.y < size.y) {\n"
    "            pixel = then;\n"
    "            z -= dgb_v_previous.w - dgb_v_current.w;\n"
    "        }\n"
    "    }\n"
    "    ivec2 texel = ivec2(pixel) / (layer > 1 ? DGB_DIVISOR : 1);\n"
    "    float front = dgb_oracle_z(texelFetch(dgb_oracle, ivec3(texel, layer - 1), 0).r, dgb_draw_previous);\n"
    "    return dgb_keep_test(z, front, dgb_draw_size.z);\n"
    "#else\n"
    "    return true;\n"
    "#endif\n"
    "}\n"
    "\n"
    "// What is in the targets of a material that never calls dgb_store.\n"
    "void dgb_store_nothing() {\n"
    "#ifdef DGB_ALBEDO_LOCATION\n"
    "    dgb_out_albedo = vec4(0.0);\n"
    "#endif\n"
    "#ifdef DGB_NORMAL_LOCATION\n"
    "    dgb_out_normal = vec4(0.0);\n"
    "#endif\n"
    "#ifdef DGB_RADIANCE_LOCATION\n"
    "    dgb_out_radiance = vec4(0.0);\n"
    "#endif\n"
    "#ifdef DGB_VELOCITY_LOCATION\n"
    "    dgb_out_velocity = vec4(0.0);\n"
    "#endif\n"
    "}\n"
    "\n"
    "// Whether to go on with this fragment. The first layer keeps all; what the second would say is remembered, for image emission.\n"
    "bool dgb_kept_second = false;\n"
    "\n"
    "bool dgb_keep() {\n"
    "    dgb_store_nothing();\n"
    "    dgb_kept_second = dgb_kept_in(max(dgb_v_layer, 1));\n"
    "    return dgb_v_layer == 0 || dgb_kept_second;\n"
    "}\n"
    "\n"
    "float dgb_storable_velocity(float v) { return abs(v) <= DGB_MAX_RADIANCE ? v : 0.0; }\n"
    "\n"
    "// albedo.rgb: linear; albedo.a and material: the engine's own, 0..1, but with glossy reflections material.x is the roughness.\n"
    "// normal: camera space, any length. radiance: outgoing, W/(m2 sr): emission, and direct light if the material shader computes it.\n"
    "void dgb_store(vec4 albedo, vec3 normal, vec2 material, vec3 radiance) {\n"
    "#ifdef DGB_ALBEDO_LOCATION\n"
    "    dgb_out_albedo = albedo;\n"
    "#endif\n"
    "#ifdef DGB_NORMAL_LOCATION\n"
    "    dgb_out_normal = vec4(dgb_oct16_encode(normal), material);\n"
    "#endif\n"
    "#ifdef DGB_RADIANCE_LOCATION\n",
    "    dgb_out_radiance = vec4(dgb_storable(radiance), 1.0);\n"
    "#endif\n"
    "#ifdef DGB_VELOCITY_LOCATION\n"
    "    vec2 velocity    = dgb_velocity();\n"
    "    dgb_out_velocity = vec4(dgb_storable_velocity(velocity.x), dgb_storable_velocity(velocity.y), 0.0, 0.0);\n"
    "#endif\n"
    "}\n"
    "\n"
    "#if DGB_EMISSION_IMAGE\n"
    "// Image emission: the pipeline rasterises the first layer only; a fragment that a deeper layer would keep competes for it here,\n"
    "// nearest depth bits first. Only after the engine's own main, so that what it discards stores nothing.\n"
    "layout(r32ui) coherent uniform uimage2DArray dgb_image_key;\n"
    "#ifdef DGB_ALBEDO_LOCATION\n"
    "layout(rgba8) writeonly uniform image2DArray dgb_image_albedo;\n"
    "#endif\n"
    "#ifdef DGB_NORMAL_LOCATION\n"
    "layout(rgba8) writeonly uniform image2DArray dgb_image_normal;\n"
    "#endif\n"
    "#ifdef DGB_RADIANCE_LOCATION\n"
    "layout(r11f_g11f_b10f) writeonly uniform image2DArray dgb_image_radiance;\n"
    "#endif\n"
    "#ifdef DGB_VELOCITY_LOCATION\n"
    "layout(rg16f) writeonly uniform image2DArray dgb_image_velocity;\n"
    "#endif\n"
    "#if DGB_INTERLOCK\n"
    "layout(pixel_interlock_ordered) in;\n"
    "#endif\n"
    "\n"
    "void dgb_compete(int layer) {\n"
    "    ivec3 texel = ivec3(ivec2(gl_FragCoord.xy), layer);\n"
    "    uint  key = floatBitsToUint(dgb_depth_code(gl_FragCoord.z, float(DGB_DEPTH_CODES))); // positive floats sort as integers\n"
    "    uint  nearest = imageLoad(dgb_image_key, texel - ivec3(0, 0, 1)).x;\n"
    "    if (DGB_REVERSED != 0 ? key <= nearest : key >= nearest) return;\n"
    "    imageStore(dgb_image_key, texel - ivec3(0, 0, 1), uvec4(key));\n"
    "#ifdef DGB_ALBEDO_LOCATION\n"
    "    imageStore(dgb_image_albedo, texel, dgb_out_albedo);\n"
    "#endif\n"
    "#ifdef DGB_NORMAL_LOCATION\n"
    "    imageStore(dgb_image_normal, texel, dgb_out_normal);\n"
    "#endif\n"
    "#ifdef DGB_RADIANCE_LOCATION\n"
    "    imageStore(dgb_image_radiance, texel, dgb_out_radiance);\n"
    "#endif\n"
    "#ifdef DGB_VELOCITY_LOCATION\n"
    "    imageStore(dgb_image_velocity, texel, dgb_out_velocity);\n"
    "#endif\n"
    "}\n"
    "\n"
    "void dgb_engine_main();\n"
    "\n"
    "void main() {\n"
    "    dgb_engine_main();\n"
    "#if DGB_INTERLOCK\n"
    "    beginInvocationInterlockARB();\n"
    "#endif\n"
    "    if (dgb_draw_layer.y > 1 && dgb_kept_second) dgb_compete(1);\n"
    "#if DGB_LAYERS > 2 // else a software rasteriser runs the loop's body once, for nothing\n"
    "    int layer = 2;\n"
    "    do {\n"
    "        if (layer < dgb_draw_layer.y && dgb_kept_in(layer)) dgb_compete(layer);\n"
    "    } while (++layer < DGB_LAYERS);\n"
    "#endif\n"
    "#if DGB_INTERLOCK\n"
    "    endInvocationInterlockARB();\n"
    "#endif\n"
    "}\n"
    "#define main dgb_engine_main\n"
    "#endif\n",
    0
};

static const char* const dgbgli_glsl_resolve[] = { /* 15_resolve.glsl */
    "#line 150001\n"
    "// Resolve, after image emission: the depth bits of a deeper layer become its depth.\n"
    "\n"
    "layout(std140) uniform dgb_resolve_block {\n"
    "    ivec4 dgb_resolve_layer; // x: image of the key\n"
    "};\n"
    "\n"
    "uniform usampler2DArray dgb_key;\n"
    "\n"
    "void main() {\n"
    "    gl_FragDepth = uintBitsToFloat(texelFetch(dgb_key, ivec3(ivec2(gl_FragCoord.xy), dgb_resolve_layer.x), 0).x);\n"
    "}\n",
    0
};

static const char* const dgbgli_glsl_source[] = { /* 18_source.glsl */
    "#line 180001\n"
    "// What the layers hold at a pixel, shared by pack, temporal, reflect and glossy; `layer` is constant wherever these are called.\n"
    "\n"
    "#if DGB_ENGINE_LAYERS\n"
    "uniform sampler2D dgb_engine_depth0;\n"
    "uniform sampler2D dgb_engine_depth1;\n"
    "uniform sampler2D dgb_engine_normal0;\n"
    "uniform sampler2D dgb_engine_normal1;\n"
    "uniform sampler2D dgb_engine_radiance0;\n"
    "uniform sampler2D dgb_engine_radiance1;\n"
    "uniform sampler2D dgb_engine_albedo0;\n"
    "uniform sampler2D dgb_engine_albedo1;\n"
    "uniform sampler2D dgb_engine_velocity0;\n"
    "uniform sampler2D dgb_engine_velocity1;\n"
    "uniform sampler2D dgb_engine_back;\n"
    "uniform sampler2D dgb_engine_roughness;\n"
    "\n"
    "float dgb_depth_at(int layer, ivec2 p) { return layer == 0 ? texelFetch(dgb_engine_depth0, p, 0).r : texelFetch(dgb_engine_depth1, p, 0).r; }\n"
    "vec3  dgb_normal_at(int layer, ivec2 p) { return layer == 0 ? texelFetch(dgb_engine_normal0, p, 0).rgb : texelFetch(dgb_engine_normal1, p, 0).rgb; }\n"
    "vec3  dgb_radiance_at(int layer, ivec2 p) { return layer == 0 ? texelFetch(dgb_engine_radiance0, p, 0).rgb : texelFetch(dgb_engine_radiance1, p, 0).rgb; }\n"
    "vec3  dgb_albedo_at(int layer, ivec2 p) { return layer == 0 ? texelFetch(dgb_engine_albedo0, p, 0).rgb : texelFetch(dgb_engine_albedo1, p, 0).rgb; }\n"
    "vec3  dgb_velocity_at(int layer, ivec2 p) { return layer == 0 ? texelFetch(dgb_engine_velocity0, p, 0).rgb : texelFetch(dgb_engine_velocity1, p, 0).rgb; }\n"
    "float dgb_back_at(ivec2 p) { return texelFetch(dgb_engine_back, p, 0).r; }\n"
    "float dgb_roughness_at(ivec2 p) { return texelFetch(dgb_engine_roughness, p, 0).r; }\n"
    "#else\n"
    "uniform sampler2DArray dgb_depth;\n"
    "uniform sampler2DArray dgb_normal;\n"
    "uniform sampler2DArray dgb_radiance;\n"
    "uniform sampler2DArray dgb_albedo;\n"
    "uniform sampler2DArray dgb_velocity;\n"
    "uniform sampler2D dgb_back;\n"
    "\n"
    "// Deeper layers may have a lower resolution: they fill a part of their images.\n"
    "ivec3 dgb_texel(int layer, ivec2 p) { return ivec3(p / (layer > 0 ? DGB_DIVISOR : 1), layer); }\n"
    "\n"
    "float dgb_depth_at(int layer, ivec2 p) { return texelFetch(dgb_depth, dgb_texel(layer, p), 0).r; }\n"
    "vec3  dgb_normal_at(int layer, ivec2 p) { return texelFetch(dgb_normal, dgb_texel(layer, p), 0).rgb; }\n"
    "vec3  dgb_radiance_at(int layer, ivec2 p) { return texelFetch(dgb_radiance, dgb_texel(layer, p), 0).rgb; }\n"
    "vec3  dgb_albedo_at(int layer, ivec2 p) { return texelFetch(dgb_albedo, dgb_texel(layer, p), 0).rgb; }\n"
    "vec3  dgb_velocity_at(int layer, ivec2 p) { return texelFetch(dgb_velocity, dgb_texel(layer, p), 0).rgb; }\n"
    "float dgb_back_at(ivec2 p) { return texelFetch(dgb_back, dgb_texel(1, p).xy, 0).r; }\n"
    "float dgb_roughness_at(ivec2 p) { return texelFetch(dgb_normal, ivec3(p, 0), 0).b; }\n"
    "#endif\n",
    0
};

static const char* const dgbgli_glsl_history[] = { /* 19_history.glsl */
    "#line 190001\n"
    "// Where a surface was last frame, and which texels of last frame show it (paper, section 3.3). Shared by pack,\n"
    "// temporal and glossy.\n"
    "\n"
    "const float DGB_LEAST_SHARE = 0.05; // of the bilinear weights: with less there is no history\n"
    "\n"
    "// What makes an average of a sum whose weights add up to `share`: 0 where there is no history.\n"
    "float dgb_whole(float share) { return share > DGB_LEAST_SHARE ? 1.0 / share : 0.0; }\n"
    "\n"
    "struct dgb_reprojection {\n"
    "    dgb_camera last;\n"
    "    vec4       to_last[3]; // rows: from this frame's camera space to last frame's\n"
    "    vec4       tolerance;  // share of the distance, least (m), 1 if last frame is of use, 0 if nothing has moved since\n"
    "    ivec4      rect;       // shaded last frame: x0, y0, x1, y1, the last two inclusive\n"
    "};\n"
    "\n"
    "uniform sampler2D dgb_last_z;\n"
    "#if DGB_LAST_LIGHT\n"
    "uniform sampler2D dgb_last_irradiance;\n"
    "#endif\n"
    "#if DGB_DEEP\n"
    "uniform sampler2D dgb_last_irradiance1;\n"
    "#endif\n"
    "\n"
    "// A point last frame.\n"
    "struct dgb_past {\n"
    "    vec2  pixel;\n"
    "    vec3  point;     // camera space\n"
    "    vec3  normal;\n"
    "    float tolerance; // how far from it a texel may be and still show it, m; -1: there is no such frame or no such place\n"
    "};\n"
    "\n"
    "// velocity: pixels since last frame, and metres of z by which the object itself moved, where the engine says so. Where it does\n"
    "// not, nobody knows how far an object came nearer: as far, it is assumed, as it moved across.\n"
    "dgb_past dgb_past_of(vec2 pixel, vec3 x, vec3 n, vec3 velocity, dgb_reprojection r) {\n"
    "    dgb_past past;\n"
    "    vec4     a   = r.to_last[0], b = r.to_last[1], c = r.to_last[2];\n"
    "    past.point   = vec3(dot(a, vec4(x, 1.0)), dot(b, vec4(x, 1.0)), dot(c, vec4(x, 1.0)));\n"
    "    past.normal  = vec3(dot(a.xyz, n), dot(b.xyz, n), dot(c.xyz, n));\n"
    "    past.pixel   = pixel - velocity.xy * r.tolerance.w;\n"
    "    float scale  = dgb_pixels_per_metre(past.point.z, r.last);\n"
    "    vec2  own    = past.pixel - dgb_project(past.point, r.last); // what the camera did not do\n"
    "    float least  = max(r.tolerance.x * abs(past.point.z), r.tolerance.y) + length(own) / scale;\n"
    "    vec2  low    = vec2(r.rect.xy), high = vec2(r.rect.zw) + 1.0;\n"
    "    bool  usable = r.tolerance.z > 0.0 && scale > 0.0 && all(greaterThanEqual(past.pixel, low)) && all(lessThan(past.pixel, high));\n"
    "    past.point.z -= velocity.z * r.tolerance.w;\n"
    "    past.tolerance = usable ? least : -1.0;\n"
    "    past.pixel     = usable ? past.pixel : low + 0.5;\n"
    "    return past;\n"
    "}\n"
    "\n"
    "// z where the ray through a pixel position meets the point's plane.\n"
    "float dgb_plane_z(vec2 at, dgb_past past, dgb_camera last) {\n"
    "    vec3 ray_z = vec3(at * last.position_z.xy + last.position_z.zw, 1.0);\n"
    "    vec3 ray_1 = vec3(at * last.position_1.xy + last.position_1.zw, 0.0);\n"
    "    return dot(past.normal, past.point - ray_1) / dot(past.normal, ray_z);\n"
    "}\n"
    "\n"
    "// How far a layer of a texel of last frame is from the point's plane there, or from its own z: whichever is less.\n"
    "float dgb_past_error(float z, vec2 at, dgb_past past, dgb_camera last) {\n"
    "    float to_own = abs(z - past.point.z), to_plane = abs(z - dgb_plane_z(at, past, last));\n"
    "    return to_plane < to_own ? to_plane : to_own;\n"
    "}\n"
    "\n"
    "// Whether a texel shows the surface: 0 in the first layer, 1 in the second, -1 in neither.\n"
    "int dgb_past_layer(ivec2 texel, dgb_past past, dgb_reprojection r) {\n"
    "    vec2  zs    = texelFetch(dgb_last_z, texel, 0).xy;\n"
    "    float first = dgb_past_error(zs.x, vec2(texel) + 0.5, past, r.last);\n"
    "#if DGB_DEEP\n"
    "    float second = dgb_past_error(zs.y, dgb_centre(1, texel), past, r.last);\n"
    "    if (second < first) return second <= past.tolerance ? 1 : -1;\n"
    "#endif\n"
    "    return first <= past.tolerance ? 0 : -1;\n"
    "}\n"
    "\n"
    "#if DGB_LAST_LIGHT\n"
    "// What last frame holds for that layer of a texel. Nothing that is not finite gets through: history heals.\n"
    "vec4 dgb_last_irradiance_at(ivec2 texel, int layer) {\n"
    "    vec4 e = texelFetch(dgb_last_irradiance, texel, 0);\n"
    "#if DGB_DEEP\n"
    "    vec4 e1 = texelFetch(dgb_last_irradiance1, texel, 0);\n"
    "    e       = layer == 1 ? e1 : e;\n"
    "#endif\n",
    "    return vec4(dgb_storable(e.rgb), e.a > 0.0 ? (e.a < 1.0 ? e.a : 1.0) : 0.0);\n"
    "}\n"
    "#endif\n"
    "\n"
    "// An average with last frame's, as it is stored. weight: of history; without it x is no average, and stays.\n"
    "vec4 dgb_averaged(vec4 x, float weight, ivec2 pixel, int frame) {\n"
    "    vec2 pair = dgb_pixel_pair(pixel, frame);\n"
    "    return weight > 0.0 ? dgb_dithered(x, fract(vec4(pair, pair + 0.5))) : x;\n"
    "}\n",
    0
};

static const char* const dgbgli_glsl_pack[] = { /* 20_pack.glsl */
    "#line 200001\n"
    "// Pack: camera z, normals and radiance of up to two layers into the shading input (paper, Table 1). With bounces, what fell on\n"
    "// a surface last frame is part of what it sends (Equation 6).\n"
    "\n"
    "layout(std140) uniform dgb_pack_block {\n"
    "    dgb_camera dgb_pack_camera;\n"
    "    vec4       dgb_pack_rotation[3]; // world to camera, columns\n"
    "    vec4       dgb_pack_separation;  // separation in m (-1: keep what the oracle let through), depth codes\n"
    "    ivec4      dgb_pack_size;        // buffer width, height\n"
    "    vec4       dgb_pack_bounce;      // damping, boost of grey, boost of saturated colour, taps\n"
    "    dgb_reprojection dgb_pack_past;\n"
    "};\n"
    "\n"
    "float dgb_z_of(float depth) { return dgb_linear_z(dgb_depth_code(depth, dgb_pack_separation.y), dgb_pack_camera); }\n"
    "\n"
    "float dgb_z_at(int layer, ivec2 p) { return dgb_z_of(dgb_depth_at(layer, p)); }\n"
    "\n"
    "layout(location = 0) out vec4 dgb_out_z;\n"
    "layout(location = 1) out vec4 dgb_out_normals;\n"
    "#if DGB_PACK_RADIANCE\n"
    "layout(location = 2) out vec4 dgb_out_b0;\n"
    "#if DGB_LAYERS > 1\n"
    "layout(location = 3) out vec4 dgb_out_b1;\n"
    "#endif\n"
    "#endif\n"
    "\n"
    "// The Oct16 bytes of a layer's normal, from whatever the engine has.\n"
    "#if DGB_NORMALS_FORMAT == 0\n"
    "// From depth. Along each axis the tangent comes from the side on which the surface goes on: the one whose two texels\n"
    "// extrapolate best to this one. Window depth is linear in the image over a plane, so a plane extrapolates exactly.\n"
    "bool dgb_inside(ivec2 p) { return p.x >= 0 && p.y >= 0 && p.x < dgb_pack_size.x && p.y < dgb_pack_size.y; }\n"
    "\n"
    "vec3 dgb_point(int layer, ivec2 p) { return dgb_position(vec2(p) + 0.5, dgb_z_at(layer, p), dgb_pack_camera); }\n"
    "\n"
    "// How badly the texels at p + step and p + 2 step foretell the depth at p; 2: there is no surface to ask.\n"
    "float dgb_kink(int layer, ivec2 p, ivec2 step, float depth) {\n"
    "    if (!dgb_inside(p + step) || dgb_z_at(layer, p + step) == 0.0) return 2.0;\n"
    "    float near = dgb_depth_at(layer, p + step);\n"
    "    if (!dgb_inside(p + 2 * step) || dgb_z_at(layer, p + 2 * step) == 0.0) return abs(near - depth);\n"
    "    return abs(2.0 * near - dgb_depth_at(layer, p + 2 * step) - depth);\n"
    "}\n"
    "\n"
    "vec3 dgb_tangent(int layer, ivec2 p, ivec2 step, vec3 here) {\n"
    "    float depth = dgb_depth_at(layer, p);\n"
    "    float after = dgb_kink(layer, p, step, depth), before = dgb_kink(layer, p, -step, depth);\n"
    "    if (after < 2.0 && after <= before) return dgb_point(layer, p + step) - here;\n"
    "    return before < 2.0 ? here - dgb_point(layer, p - step) : vec3(0.0);\n"
    "}\n"
    "\n"
    "vec2 dgb_normal_bytes(int layer, ivec2 p, float z) {\n"
    "    vec3 here = dgb_point(layer, p);\n"
    "    vec3 x    = dgb_tangent(layer, p, ivec2(1, 0), here);\n"
    "    vec3 y    = dgb_tangent(layer, p, ivec2(0, 1), here);\n"
    "    return dgb_oct16_encode(cross(x / z, y / z)); // free of units; zero without neighbours: +Z, towards the eye\n"
    "}\n"
    "#elif DGB_NORMALS_FORMAT == 1\n"
    "vec2 dgb_normal_bytes(int layer, ivec2 p, float z) { return dgb_normal_at(layer, p).rg; }\n"
    "#else\n"
    "vec2 dgb_normal_bytes(int layer, ivec2 p, float z) {\n"
    "#if DGB_NORMALS_FORMAT == 2\n"
    "    vec3 n = dgb_normal_at(layer, p) * 2.0 - 1.0;\n"
    "#else\n"
    "    vec3 n = dgb_normal_at(layer, p);\n"
    "#endif\n"
    "    return dgb_oct16_encode(dgb_pack_rotation[0].xyz * n.x + dgb_pack_rotation[1].xyz * n.y + dgb_pack_rotation[2].xyz * n.z);\n"
    "}\n"
    "#endif\n"
    "\n"
    "#if DGB_LAST_LIGHT\n"
    "// Light that fell on the surface last frame and that it sends on: albedo/pi * damping * boost * E.\n"
    "vec3 dgb_bounced(int layer, ivec2 p, float z, vec2 normal) {\n"
    "    vec2     pixel  = dgb_centre(layer, p);\n"
    "    vec3     x      = dgb_position(pixel, z, dgb_pack_camera);\n"
    "    dgb_past past   = dgb_past_of(pixel, x, dgb_oct16_decode(normal), dgb_velocity_at(layer, p), dgb_pack_past);\n"
    "    ivec2    texel  = ivec2(past.pixel);\n"
    "    int      shown  = dgb_past_layer(texel, past, dgb_pack_past);\n"
    "    vec3     albedo = dgb_storable(dgb_albedo_at(layer, p));\n"
    "    float    factor = dgb_pack_bounce.x * dgb_boost(albedo, dgb_pack_bounce.y, dgb_pack_bounce.z) / DGB_PI;\n"
    "    vec4     e      = dgb_last_irradiance_at(texel, shown);\n",
    "    float    found  = min(e.a * dgb_pack_bounce.w, 1.0); // below one tap a frame: light that has gone must not bounce on\n"
    "    return shown < 0 ? vec3(0.0) : factor * found * albedo * e.rgb;\n"
    "}\n"
    "#endif\n"
    "\n"
    "vec3 dgb_packed_radiance(int layer, ivec2 p, float z, vec2 normal) {\n"
    "    vec3 radiance = dgb_storable(dgb_radiance_at(layer, p));\n"
    "#if DGB_LAST_LIGHT\n"
    "    radiance = dgb_storable(radiance + dgb_bounced(layer, p, z, normal));\n"
    "#endif\n"
    "    return z != 0.0 ? dgb_nearest(radiance) : vec3(0.0);\n"
    "}\n"
    "\n"
    "float dgb_packed_z(float z) { return z != 0.0 ? z : DGB_EMPTY_Z; }\n"
    "\n"
    "vec2 dgb_packed_normal(int layer, ivec2 p, float z) { return z != 0.0 ? dgb_normal_bytes(layer, p, z) : vec2(0.0); }\n"
    "\n"
    "void main() {\n"
    "    ivec2 p         = ivec2(gl_FragCoord.xy);\n"
    "    float z0        = dgb_z_at(0, p);\n"
    "    dgb_out_z       = vec4(dgb_packed_z(z0), 0.0, 0.0, 0.0);\n"
    "    dgb_out_normals = vec4(dgb_packed_normal(0, p, z0), 0.0, 0.0);\n"
    "#if DGB_BACK\n"
    "    float back = dgb_z_of(dgb_back_at(p)); // behind another pixel's layer 0, with a divisor: never before this one's\n"
    "    dgb_out_z.z = dgb_packed_z(dgb_keep_test(back, z0, 0.0) ? back : 0.0);\n"
    "#endif\n"
    "#if DGB_PACK_RADIANCE\n"
    "    dgb_out_b0 = vec4(dgb_packed_radiance(0, p, z0, dgb_out_normals.xy), 1.0);\n"
    "#endif\n"
    "#if DGB_LAYERS > 1\n"
    "    float z1 = dgb_z_at(1, p);\n"
    "    // strict separation, against the true layer 0: a wrong guess of the oracle becomes a hole\n"
    "    if (dgb_pack_separation.x >= 0.0 && !dgb_keep_test(z1, z0, dgb_pack_separation.x)) z1 = 0.0;\n"
    "    dgb_out_z.y        = dgb_packed_z(z1);\n"
    "    dgb_out_normals.zw = dgb_packed_normal(1, p, z1);\n"
    "#if DGB_PACK_RADIANCE\n"
    "    dgb_out_b1 = vec4(dgb_packed_radiance(1, p, z1, dgb_out_normals.zw), 1.0);\n"
    "#endif\n"
    "#endif\n"
    "}\n",
    0
};

static const char* const dgbgli_glsl_mip[] = { /* 30_mip.glsl */
    "#line 300001\n"
    "// Mip: texel p copies texel 2p + (p.y & 1, p.x & 1) of the level before. Copying, not averaging: an average of two depths or\n"
    "// of two encoded normals is neither. dgb_mip_levels stops where the copy would leave the texture.\n"
    "\n"
    "uniform sampler2D dgb_z;\n"
    "layout(location = 0) out vec4 dgb_out_z;\n"
    "#if DGB_PACK_RADIANCE\n"
    "uniform sampler2D dgb_normals;\n"
    "uniform sampler2D dgb_b0;\n"
    "layout(location = 1) out vec4 dgb_out_normals;\n"
    "layout(location = 2) out vec4 dgb_out_b0;\n"
    "#if DGB_LAYERS > 1\n"
    "uniform sampler2D dgb_b1;\n"
    "layout(location = 3) out vec4 dgb_out_b1;\n"
    "#endif\n"
    "#endif\n"
    "\n"
    "void main() {\n"
    "    ivec2 p   = ivec2(gl_FragCoord.xy);\n"
    "    ivec2 q   = 2 * p + (p.yx & 1);\n"
    "    dgb_out_z = texelFetch(dgb_z, q, 0);\n"
    "#if DGB_PACK_RADIANCE\n"
    "    dgb_out_normals = texelFetch(dgb_normals, q, 0);\n"
    "    dgb_out_b0      = texelFetch(dgb_b0, q, 0);\n"
    "#if DGB_LAYERS > 1\n"
    "    dgb_out_b1 = texelFetch(dgb_b1, q, 0);\n"
    "#endif\n"
    "#endif\n"
    "}\n",
    0
};

static const char* const dgbgli_glsl_depths[] = { /* 32_depths.glsl */
    "#line 320001\n"
    "// Ranges of depth: largest and smallest z of layer 0, then of layer 1. A texel without a surface adds nothing to them.\n"
    "\n"
    "const vec4 DGB_NO_DEPTHS = vec4(-1e30, 1e30, -1e30, 1e30);\n"
    "\n"
    "vec4 dgb_join(vec4 a, vec4 b) { return vec4(max(a.x, b.x), min(a.y, b.y), max(a.z, b.z), min(a.w, b.w)); }\n"
    "\n"
    "// Of one texel.\n"
    "vec4 dgb_depths_of(vec2 z) {\n"
    "    vec4 depths = DGB_NO_DEPTHS;\n"
    "    if (z.x > DGB_EMPTY_Z) depths.xy = z.xx;\n"
    "    if (z.y > DGB_EMPTY_Z) depths.zw = z.yy;\n"
    "    return depths;\n"
    "}\n",
    0
};

static const char* const dgbgli_glsl_tiles[] = { /* 33_tiles.glsl */
    "#line 330001\n"
    "// Tiles: where the second layer can matter at all. Three steps: the depth range of each tile, of each region of 8 x 8 tiles, and\n"
    "// for each tile whether a second-layer surface lies within reach of its pixels. What it rejects, no tap would have found: the\n"
    "// results are the same, bit for bit, only the work is less.\n"
    "\n"
    "const int DGB_LOG2_REGION = 7; // 8 x 8 tiles\n"
    "\n"
    "#if DGB_TILES_STEP < 2\n"
    "layout(location = 0) out vec4 dgb_out_depths;\n"
    "#endif\n"
    "\n"
    "#if DGB_TILES_STEP == 0\n"
    "uniform sampler2D dgb_z;\n"
    "\n"
    "void main() {\n"
    "    ivec2 tile = ivec2(gl_FragCoord.xy), last = textureSize(dgb_z, 0) - 1;\n"
    "    vec4  depths = DGB_NO_DEPTHS;\n"
    "    for (int y = 0; y < 1 << DGB_LOG2_TILE; ++y)\n"
    "        for (int x = 0; x < 1 << DGB_LOG2_TILE; ++x)\n"
    "            depths = dgb_join(depths, dgb_depths_of(texelFetch(dgb_z, min((tile << DGB_LOG2_TILE) + ivec2(x, y), last), 0).xy));\n"
    "    dgb_out_depths = depths;\n"
    "}\n"
    "#elif DGB_TILES_STEP == 1\n"
    "uniform sampler2D dgb_tile_depths;\n"
    "\n"
    "void main() {\n"
    "    ivec2 region = ivec2(gl_FragCoord.xy), last = textureSize(dgb_tile_depths, 0) - 1;\n"
    "    vec4  depths = DGB_NO_DEPTHS;\n"
    "    for (int y = 0; y < 8; ++y)\n"
    "        for (int x = 0; x < 8; ++x)\n"
    "            depths = dgb_join(depths, texelFetch(dgb_tile_depths, min(region * 8 + ivec2(x, y), last), 0));\n"
    "    dgb_out_depths = depths;\n"
    "}\n"
    "#else\n"
    "layout(std140) uniform dgb_tiles_block {\n"
    "    dgb_camera dgb_tiles_camera;\n"
    "    vec4       dgb_tiles_radius; // of occlusion and of light (m), largest reach, 2^least level (pixels)\n"
    "};\n"
    "\n"
    "uniform sampler2D dgb_tile_depths;\n"
    "uniform sampler2D dgb_region_depths;\n"
    "\n"
    "layout(location = 0) out vec4 dgb_out_tiles; // the second layer matters to occlusion, to light, and is there\n"
    "\n"
    "const float DGB_FEW_TILES = 64.0; // pixels of reach up to which tiles are looked at one by one, beyond by regions\n"
    "\n"
    "bool dgb_within(vec4 theirs, vec4 ours, float radius) { return theirs.w <= ours.x + radius && theirs.z >= ours.y - radius; }\n"
    "\n"
    "// Whether any second-layer surface lies within the radius, in depth and in the image, of any first-layer surface of the tile.\n"
    "bool dgb_second_matters(ivec2 tile, vec4 ours, float radius) {\n"
    "    float reach = dgb_reach(ours.x, radius, dgb_tiles_radius.z, dgb_tiles_camera);\n"
    "    float range = radius * 1.001; // rounding must not decide\n"
    "    // a tap at MIP level m lies up to 2 * 2^m pixels off; it is 8 * 2^m away, or m is the least level\n"
    "    float pixels = reach * 1.25 + 2.0 * dgb_tiles_radius.w + 1.0;\n"
    "    bool  few    = pixels <= DGB_FEW_TILES;\n"
    "    int   shift  = few ? DGB_LOG2_TILE : DGB_LOG2_REGION;\n"
    "    ivec2 last   = few ? textureSize(dgb_tile_depths, 0) - 1 : textureSize(dgb_region_depths, 0) - 1;\n"
    "    ivec2 corner = tile << DGB_LOG2_TILE;\n"
    "    ivec2 low    = max((corner - int(ceil(pixels))) >> shift, ivec2(0));\n"
    "    ivec2 high   = min((corner + (1 << DGB_LOG2_TILE) + int(ceil(pixels))) >> shift, last);\n"
    "    bool  found  = false;\n"
    "    for (int y = ours.x > DGB_EMPTY_Z ? low.y : high.y + 1; y <= high.y; ++y)\n"
    "        for (int x = low.x; x <= high.x; ++x) {\n"
    "            vec4 theirs = few ? texelFetch(dgb_tile_depths, ivec2(x, y), 0) : texelFetch(dgb_region_depths, ivec2(x, y), 0);\n"
    "            found       = found || dgb_within(theirs, ours, range);\n"
    "        }\n"
    "    return found;\n"
    "}\n"
    "\n"
    "void main() {\n"
    "    ivec2 tile    = ivec2(gl_FragCoord.xy);\n"
    "    vec4  ours    = texelFetch(dgb_tile_depths, tile, 0);\n"
    "    bool  ao      = dgb_second_matters(tile, ours, dgb_tiles_radius.x);\n"
    "    bool  light   = dgb_second_matters(tile, ours, dgb_tiles_radius.y);\n"
    "    dgb_out_tiles = vec4(ao, light, ours.z > DGB_EMPTY_Z, 1.0);\n"
    "}\n"
    "#endif\n",
    0
};

static const char* const dgbgli_glsl_taps[] = { /* 35_taps.glsl */
    "#line 350001\n"
    "// Taps, shared by ao, gather and bitmask; those of the first two lie on a spiral (paper, section 3.4). Angles come from tables, so\n"
    "// that every implementation lands on the same texels.\n"
    "\n"
    "uniform sampler2D dgb_rotations;\n"
    "\n"
    "struct dgb_tap {\n"
    "    ivec2 texel; // what to fetch\n"
    "    int   level; // from this MIP level\n"
    "    ivec2 pixel; // the level-0 pixel it was copied from: where the surface really is\n"
    "    bool  inside; // whether it lies in the buffer; else the border stands in for what is not known\n"
    "};\n"
    "\n"
    "vec2 dgb_rotation(ivec2 pixel, int frame) { return texelFetch(dgb_rotations, ivec2(dgb_pixel_hash(pixel, frame), 0), 0).rg; }\n"
    "\n"
    "struct dgb_spiral { // what the taps of one pixel have in common; compilers for GPUs do not find it in a loop\n"
    "    vec2  centre, rotation;\n"
    "    float reach; // pixels\n"
    "    ivec2 size;  // of the buffer\n"
    "    vec2  last;  // the last position in it: the float before its size\n"
    "};\n"
    "\n"
    "// size: of the buffer, (unused), frame.\n"
    "dgb_spiral dgb_spiral_at(vec2 centre, float reach, ivec4 size) {\n"
    "    return dgb_spiral(centre, dgb_rotation(ivec2(centre), size.w), reach, size.xy, vec2(size.xy) * 0.99999994);\n"
    "}\n"
    "\n"
    "// The tap at a position in the buffer, h pixels from the centre; levels: log2 q, min, max.\n"
    "dgb_tap dgb_tap_of(vec2 at, float h, ivec2 size, ivec4 levels) {\n"
    "    dgb_tap tap;\n"
    "    tap.level  = dgb_mip_level(h, levels.x, levels.y, levels.z);\n"
    "    tap.texel  = min(ivec2(at), size - (1 << tap.level)) >> tap.level; // a level's last texels stand for all that is left\n"
    "    tap.pixel  = dgb_mip_source(tap.texel, tap.level);\n"
    "    tap.inside = true;\n"
    "    return tap;\n"
    "}\n"
    "\n"
    "// table: cos, sin, kappa of the tap.\n"
    "dgb_tap dgb_tap_at(vec4 table, dgb_spiral s, ivec4 levels) {\n"
    "    float h         = max(s.reach * table.z, 0.75); // nearer taps would land on the shaded pixel itself\n"
    "    vec2  direction = vec2(table.x * s.rotation.x - table.y * s.rotation.y, table.x * s.rotation.y + table.y * s.rotation.x);\n"
    "    vec2  at        = s.centre + h * direction, within = clamp(at, vec2(0.0), s.last);\n"
    "    bool  inside    = at == within; // asked first, so that `at` takes no registers in the meantime\n"
    "    dgb_tap tap     = dgb_tap_of(within, h, s.size, levels);\n"
    "    tap.inside      = inside;\n"
    "    return tap;\n"
    "}\n"
    "\n"
    "// How far it is to the border of the buffer; direction: unit.\n"
    "float dgb_room(vec2 at, vec2 direction, vec2 size) {\n"
    "    vec2 room = mix(at, size - at, greaterThan(direction, vec2(0.0))) / max(abs(direction), 1e-6);\n"
    "    return min(room.x, room.y);\n"
    "}\n"
    "\n"
    "#if DGB_LAYERS > 1\n"
    "uniform sampler2D dgb_tiles;\n"
    "\n"
    "// Whether the second layer matters to occlusion, to light, and is there, in the pixel's tile; all: as if it did everywhere.\n"
    "bvec3 dgb_tile_at(ivec2 pixel, bool all) {\n"
    "    return greaterThan(texelFetch(dgb_tiles, pixel >> DGB_LOG2_TILE, 0).rgb + vec3(all), vec3(0.0));\n"
    "}\n"
    "#endif\n",
    0
};

static const char* const dgbgli_glsl_thickness[] = { /* 36_thickness.glsl */
    "#line 360001\n"
    "// How far behind itself a surface hides what is there, shared by the bitmask and the reflections: no farther than `most`, m. What\n"
    "// is known to lie behind the first layer ends it sooner; but behind a thin object may stand the next, too near for the second\n"
    "// layer, so that a back face ends no surface before a part of the way. zs: as DGB_Z holds them.\n"
    "const float DGB_LEAST_THICKNESS = 0.25; // of the most; without it occlusion errs more in every scene measured\n"
    "\n"
    "vec2 dgb_thickness_of(vec4 zs, float most) {\n"
    "    vec2 thickness = vec2(most);\n"
    "#if DGB_LAYERS > 1 && DGB_THICKNESS != 1\n"
    "    thickness.x = min(thickness.x, zs.x - zs.y);\n"
    "#endif\n"
    "#if DGB_THICKNESS == 2\n"
    "    thickness.x = min(thickness.x, max(zs.x - zs.z, DGB_LEAST_THICKNESS * most));\n"
    "#endif\n"
    "    return thickness;\n"
    "}\n",
    0
};

static const char* const dgbgli_glsl_sectors[] = { /* 37_sectors.glsl */
    "#line 370001\n"
    "// The mathematics of the visibility bitmask (Therrien et al. 2023). A slice is a half plane bounded by the line of sight. Each\n"
    "// function is the twin of the C function of the same name in deepgbuffer.h, which documents it.\n"
    "\n"
    "float dgb_arc_sine(float x) {\n"
    "    float a = min(abs(x), 1.0);\n"
    "    float b = 1.57079633 - sqrt(1.0 - a) * (1.5707288 + a * (-0.2121144 + a * (0.0742610 - 0.0187293 * a)));\n"
    "    return x < 0.0 ? -b : b;\n"
    "}\n"
    "\n"
    "vec3 dgb_slice_along(vec3 n, vec3 v, vec3 s) {\n"
    "    vec3  w  = n + s;\n"
    "    vec3  d  = w - dot(w, v) * v;\n"
    "    float d2 = dot(d, d);\n"
    "    return d2 > 1e-12 ? d * inversesqrt(d2) : vec3(1.0, 0.0, 0.0);\n"
    "}\n"
    "\n"
    "// cos g, sin g, g, 1 / (cos g + (g + pi/2) sin g)\n"
    "vec4 dgb_slice(vec3 n, vec3 v, vec3 along) {\n"
    "    vec2  p  = vec2(max(dot(n, v), 0.0), dot(n, along));\n"
    "    float p2 = dot(p, p);\n"
    "    p        = p2 > 1e-12 ? p * inversesqrt(p2) : vec2(1.0, 0.0);\n"
    "    float g  = dgb_arc_sine(p.y);\n"
    "    return vec4(p, g, 1.0 / max(p.x + (g + 0.5 * DGB_PI) * p.y, 1e-5));\n"
    "}\n"
    "\n"
    "// sin^2 cos g + (angle - sin cos) sin g of an angle from the eye; g: cos g, sin g, 2 cos g; x: the angle's versine, 1 - cosine.\n"
    "float dgb_slice_part(vec3 g, float x) {\n"
    "    float segment = sqrt(x) * (1.8772000 + x * (-0.3058190 + x * (0.0586256 - 0.0473906 * x))); // angle - sin cos, by x\n"
    "    return x * (g.z - g.x * x + g.y * segment);\n"
    "}\n"
    "\n"
    "// dgb_slice_share in three steps: what is the same for all directions, cos g and sin g over the part up to the horizon and the\n"
    "// horizon's versine; that of a direction {towards the eye, along}, which lies in the slice; the share, of so many sectors.\n"
    "vec4 dgb_slice_scale(vec4 slice, float sectors) {\n"
    "    vec3  g       = vec3(slice.xy, 2.0 * slice.x);\n"
    "    float horizon = 1.0 + slice.y;\n"
    "    return vec4(g * (sectors / max(dgb_slice_part(g, horizon), 1e-5)), horizon);\n"
    "}\n"
    "\n"
    "float dgb_versine(vec2 q) { return 1.0 - q.x * inversesqrt(dot(q, q)); }\n"
    "\n"
    "// rounded, a versine may be below 0\n"
    "float dgb_share(vec4 scale, float versine) { return dgb_slice_part(scale.xyz, min(abs(versine), scale.w)); }\n"
    "\n"
    "float dgb_slice_share(vec4 slice, vec2 q) {\n"
    "    float versine = q.y >= 0.0 ? 1.0 - q.x * inversesqrt(dot(q, q) + 1e-30) : 2.0;\n"
    "    return clamp(dgb_share(dgb_slice_scale(slice, 1.0), versine), 0.0, 1.0);\n"
    "}\n"
    "\n"
    "// from, to: in sectors, 0..32\n"
    "uint dgb_sectors_between(float from, float to, float u) {\n"
    "    uint low = uint(from + u), high = min(uint(to + u), 32u);\n"
    "    return low < high ? 0xffffffffu >> ((low - high) & 31u) << low : 0u;\n"
    "}\n"
    "\n"
    "uint dgb_sectors(float from, float to, float u) { return dgb_sectors_between(32.0 * from, 32.0 * to, u); }\n"
    "\n"
    "int dgb_sector_count(uint sectors) {\n"
    "#if __VERSION__ >= 400\n"
    "    return bitCount(sectors);\n"
    "#else // 330 and 300 es have none\n"
    "    uint pairs = sectors - ((sectors >> 1) & 0x55555555u);\n"
    "    uint fours = (pairs & 0x33333333u) + ((pairs >> 2) & 0x33333333u);\n"
    "    return int((((fours + (fours >> 4)) & 0x0f0f0f0fu) * 0x01010101u) >> 24);\n"
    "#endif\n"
    "}\n"
    "\n"
    "float dgb_slice_angle(vec4 slice, float share) {\n"
    "    float horizon = slice.z + 0.5 * DGB_PI;\n"
    "    float t       = horizon * (2.0 / DGB_PI) * dgb_arc_sine(sqrt(share));\n"
    "    for (int i = 0; i < 3; ++i) { // Newton's; at the ends, where the share does not grow, t stays\n"
    "        float s = sin(t), c = cos(t);\n"
    "        float off = (s * s * slice.x + (t - s * c) * slice.y) * slice.w - share, slope = 2.0 * s * (c * slice.x + s * slice.y) * slice.w;\n"
    "        t = clamp(t - off / max(slope, 1e-3), 0.0, horizon);\n"
    "    }\n"
    "    return share < 1.0 ? t : horizon;\n"
    "}\n"
    "\n"
    "vec2 dgb_slice_sum(vec4 slice, float angle) {\n"
    "    float s = sin(angle), c = cos(angle), s3 = s * s * s, c3 = c * c * c;\n"
    "    return vec2(slice.x * (1.0 - c3) + slice.y * s3, slice.x * s3 + slice.y * (2.0 - 3.0 * c + c3)) * (2.0 / 3.0 * slice.w);\n"
    "}\n"
    "\n"
    "// Four sectors at a time, which lie so near together that any of them has their mean direction.\n"
    "vec2 dgb_sectors_mean(vec4 slice, uint sectors) {\n"
    "    vec2 sum = vec2(0.0), before = vec2(0.0);\n"
    "    for (int i = 1; i <= 8; ++i) {\n",
    "        vec2 up_to = dgb_slice_sum(slice, dgb_slice_angle(slice, 0.125 * float(i)));\n"
    "        sum += (up_to - before) * (0.25 * float(dgb_sector_count(sectors & 15u)));\n"
    "        before = up_to;\n"
    "        sectors >>= 4u;\n"
    "    }\n"
    "    return sum;\n"
    "}\n",
    0
};

static const char* const dgbgli_glsl_ao[] = { /* 40_ao.glsl */
    "#line 400001\n"
    "// Ambient occlusion: Equations 1 and 2 of the paper over one or two layers. For a tap beyond the buffer the border stands in:\n"
    "// leaving it out, as the gather does, nearly doubles the error near the border (tests/bench/guard_band).\n"
    "\n"
    "layout(std140) uniform dgb_ao_block {\n"
    "    dgb_camera dgb_ao_camera;\n"
    "    ivec4      dgb_ao_size;   // buffer width, height, taps, frame\n"
    "    ivec4      dgb_ao_level;  // log2 q, min level, max level, 1: the second layer matters everywhere\n"
    "    vec4       dgb_ao_radius; // r (m), 1/r^2, beta (m), epsilon (m^2)\n"
    "    vec4       dgb_ao_scale;  // pi / taps, intensity, largest reach (pixels), 0 to leave out first-layer occluders\n"
    "    vec4       dgb_ao_taps[DGB_MAX_TAPS];\n"
    "};\n"
    "\n"
    "uniform sampler2D dgb_z;\n"
    "uniform sampler2D dgb_normals;\n"
    "\n"
    "layout(location = 0) out vec4 dgb_out_ao;\n"
    "\n"
    "const float DGB_AO_FADE_START = 1.5; // reach in pixels below which there is nothing to sample\n"
    "const float DGB_AO_FADE_END   = 3.0; // and from which on the result counts in full\n"
    "\n"
    "// Square of the occlusion by the surface at depth z that a pixel shows.\n"
    "float dgb_occlusion_squared(vec2 pixel, float z, dgb_origin x, vec3 n) {\n"
    "    vec3 v = dgb_offset(pixel, z, x, dgb_ao_camera);\n"
    "    return dgb_ao_term_squared(v, n, dgb_ao_radius.y, dgb_ao_radius.z, dgb_ao_radius.w);\n"
    "}\n"
    "\n"
    "struct dgb_shaded {\n"
    "    ivec2      pixel;\n"
    "    dgb_origin x;\n"
    "    vec3       n;\n"
    "    dgb_spiral spiral;\n"
    "};\n"
    "\n"
    "// Occlusion that tap i finds. second: look at the second layer, which costs no fetch; the same in a whole tile, so that a\n"
    "// processor that branches skips it. A loop without it, as the gather has, costs those that do not more than it saves.\n"
    "float dgb_tap_occlusion(int i, dgb_shaded s, bool second) {\n"
    "    dgb_tap tap = dgb_tap_at(dgb_ao_taps[i], s.spiral, dgb_ao_level);\n"
    "    vec2    zs  = texelFetch(dgb_z, tap.texel, tap.level).xy;\n"
    "    float   a2  = dgb_occlusion_squared(vec2(tap.pixel) + 0.5, zs.x, s.x, s.n) * dgb_ao_scale.w;\n"
    "#if DGB_LAYERS > 1\n"
    "    if (second) {\n"
    "        float b2 = dgb_occlusion_squared(dgb_centre(1, tap.pixel), zs.y, s.x, s.n);\n"
    "        a2       = tap.pixel != s.pixel ? max(a2, b2) : a2; // what lies behind the shaded point itself does not count\n"
    "    }\n"
    "#endif\n"
    "    return sqrt(a2);\n"
    "}\n"
    "\n"
    "void main() {\n"
    "    dgb_shaded s;\n"
    "    s.pixel     = ivec2(gl_FragCoord.xy);\n"
    "    float z     = texelFetch(dgb_z, s.pixel, 0).x;\n"
    "    float reach = dgb_reach(z, dgb_ao_radius.x, dgb_ao_scale.z, dgb_ao_camera);\n"
    "    s.x         = dgb_origin_at(gl_FragCoord.xy, z, dgb_ao_camera);\n"
    "    s.n         = dgb_oct16_decode(texelFetch(dgb_normals, s.pixel, 0).xy);\n"
    "    s.spiral    = dgb_spiral_at(gl_FragCoord.xy, reach, dgb_ao_size);\n"
    "    int   taps  = z > DGB_EMPTY_Z && reach > DGB_AO_FADE_START ? dgb_ao_size.z : 0;\n"
    "    float sum   = 0.0;\n"
    "#if DGB_LAYERS > 1\n"
    "    bool second = dgb_tile_at(s.pixel, dgb_ao_level.w != 0).x;\n"
    "#else\n"
    "    bool second = false;\n"
    "#endif\n"
    "    for (int i = 0; i < taps; ++i) sum += dgb_tap_occlusion(i, s, second);\n"
    "    float visibility = dgb_ambient_visibility(sum, dgb_ao_scale.x);\n"
    "    visibility       = dgb_ao_scale.y == 1.0 ? visibility : pow(visibility, dgb_ao_scale.y);\n"
    "    float full       = clamp((reach - DGB_AO_FADE_START) / (DGB_AO_FADE_END - DGB_AO_FADE_START), 0.0, 1.0);\n"
    "    dgb_out_ao       = vec4(taps > 0 ? mix(1.0, visibility, full) : 1.0);\n"
    "}\n",
    0
};

static const char* const dgbgli_glsl_bitmask[] = { /* 45_bitmask.glsl */
    "#line 450001\n"
    "// Visibility bitmask: ambient visibility, or irradiance, by the share of the cosine-weighted hemisphere that each surface\n"
    "// covers (Therrien et al. 2023), here of two layers. Slices are marched from near to far: each of a slice's 32 sectors is a\n"
    "// ray of the hemisphere, stopped by the first step that finds something in its way. Where normals are read, a surface stands\n"
    "// for the whole step around it, along its plane: else light would leak between steps that are longer than surfaces are\n"
    "// thick. What lies beyond the buffer is not known, and counts as open.\n"
    "\n"
    "layout(std140) uniform dgb_bitmask_block {\n"
    "    dgb_camera dgb_bitmask_camera;\n"
    "    ivec4      dgb_bitmask_size;   // buffer width, height, steps of a slice, frame\n"
    "    ivec4      dgb_bitmask_level;  // log2 q, min level, max level, 1: the second layer matters everywhere\n"
    "    vec4       dgb_bitmask_radius; // r (m), r^2, thickness (m), largest reach (pixels)\n"
    "    vec4       dgb_bitmask_scale;  // slices, 1 / slices, exponent of visibility, 0 to leave out the first layer\n"
    "    vec4       dgb_bitmask_world[3]; // camera to world, columns\n"
    "};\n"
    "\n"
    "uniform sampler2D dgb_z;\n"
    "uniform sampler2D dgb_normals;\n"
    "#if DGB_BITMASK_LIGHT\n"
    "uniform sampler2D dgb_b0;\n"
    "#if DGB_LAYERS > 1\n"
    "uniform sampler2D dgb_b1;\n"
    "#endif\n"
    "layout(location = 0) out vec4 dgb_out_irradiance;\n"
    "#if DGB_DEEP\n"
    "layout(location = 1) out vec4 dgb_out_irradiance1;\n"
    "#endif\n"
    "#else\n"
    "layout(location = 0) out vec4 dgb_out_ao;\n"
    "#if DGB_BENT\n"
    "layout(location = 1) out vec4 dgb_out_bent;\n"
    "#endif\n"
    "#endif\n"
    "\n"
    "struct dgb_receiver {\n"
    "    vec2  centre;  // of its pixel\n"
    "    float z;\n"
    "    vec3  n;\n"
    "    vec2  side;    // metres between pixels at depth z\n"
    "    float spread;  // at depth z + s they are 1 + spread s times as far apart\n"
    "    vec3  sight;   // the pixel's line of sight, towards the eye by the metre of depth\n"
    "    float stretch; // its length\n"
    "    vec2  within;  // depths that are within the radius, as dgb_ends_beside takes them\n"
    "    float pitch;   // pixels between steps\n"
    "    vec4  noise;   // angle of the slice, of the steps, height of the slice, of the sectors; 0..1\n"
    "};\n"
    "\n"
    "struct dgb_march { // along one slice\n"
    "    vec4  slice, scale; // scale: of its sectors\n"
    "    vec3  d;            // across the line of sight, unit\n"
    "    mat2  plane;        // {towards the eye, along d} of pixels at depth z: oblique, it keeps heights above the receiver's plane\n"
    "    vec2  direction;    // in the image\n"
    "    float room;         // pixels to the border\n"
    "    float half_step;    // half a step, m along d; a metre along d, at depth z:\n"
    "    vec2  aside;        //     in the image, m\n"
    "    float towards;      //     towards the eye, m\n"
    "    uint  seen;         // sectors that are covered\n"
    "    vec3  light;        // sum over sectors: of what they see, or, for DGB_BENT, of the directions of those that are covered\n"
    "};\n"
    "\n"
    "// The line of sight of another pixel. Its point at depth z + s lies in the slice at q.xy + s q.zw, {towards the eye, along d}.\n"
    "struct dgb_sight {\n"
    "    vec2 offset; // of the pixel, m at depth z\n"
    "    vec4 q;\n"
    "};\n"
    "\n"
    "struct dgb_surface {\n"
    "    float s, thickness; // depth from z on, m\n"
    "    vec3  n;            // of any length; 0 where it is not read\n"
    "};\n"
    "\n"
    "dgb_receiver dgb_receiver_at(int layer, ivec2 pixel, float z, vec2 normal) {\n"
    "    vec4         a = dgb_bitmask_camera.position_z, b = dgb_bitmask_camera.position_1;\n"
    "    float        reach = dgb_reach(z, dgb_bitmask_radius.x, dgb_bitmask_radius.w, dgb_bitmask_camera);\n"
    "    dgb_receiver r;\n"
    "    r.centre  = dgb_centre(layer, pixel);\n"
    "    r.z       = z;\n"
    "    r.n       = dgb_oct16_decode(normal);\n"
    "    r.side    = a.xy * z + b.xy;\n"
    "    r.spread  = a.x / r.side.x;\n"
    "    r.sight   = vec3(r.centre * a.xy + a.zw, 1.0);\n"
    "    r.stretch = length(r.sight);\n"
    "    r.within  = vec2(-1.0, 1.0) / max(1.0 / dgb_bitmask_radius.x + r.spread * vec2(-1.0, 1.0), 1e-6);\n"
    "    r.pitch   = reach / float(dgb_bitmask_size.z);\n"
    "    r.noise   = dgb_pixel_quad(pixel, dgb_bitmask_size.w);\n"
    "    return r;\n"
    "}\n"
    "\n"
    "vec3 dgb_towards_eye(dgb_receiver r) { return r.sight / r.stretch; } // unit\n"
    "\n",
    "// Slice i: a direction of the cosine-weighted hemisphere picks it, so all slices weigh alike. shift: i of all, 0..1\n"
    "dgb_march dgb_march_at(dgb_receiver r, float shift) {\n"
    "    vec4  noise    = fract(r.noise + shift);\n"
    "    vec2  rotation = texelFetch(dgb_rotations, ivec2(noise.x * 256.0, 0), 0).xy;\n"
    "    float height   = 1.0 - 2.0 * noise.z;\n"
    "    vec3  v        = dgb_towards_eye(r);\n"
    "    vec3  d        = dgb_slice_along(r.n, v, vec3(rotation * sqrt(1.0 - height * height), height));\n"
    "    vec3  across   = cross(d, v);\n"
    "    vec2  normal   = vec2(max(dot(r.n, v), 0.0), dot(r.n, d)); // in the slice\n"
    "    vec2  oblique  = normal * (dot(r.n, across) / max(dot(normal, normal), 1e-4));\n"
    "    vec2  towards  = r.side * (v.xy + oblique.x * across.xy), along = r.side * (d.xy + oblique.y * across.xy);\n"
    "    vec2  aside    = d.xy - r.sight.xy * d.z, pixels = aside / r.side; // a metre along d\n"
    "    float metre    = inversesqrt(max(dot(pixels, pixels), 1e-30)); // by the pixel\n"
    "    dgb_march m;\n"
    "    m.slice     = dgb_slice(r.n, v, d);\n"
    "    m.scale     = dgb_slice_scale(m.slice, 32.0);\n"
    "    m.d         = d;\n"
    "    m.plane     = mat2(towards.x, along.x, towards.y, along.y);\n"
    "    m.direction = pixels * metre;\n"
    "    m.room      = dgb_room(r.centre, m.direction, vec2(dgb_bitmask_size.xy));\n"
    "    m.half_step = 0.5 * r.pitch * metre;\n"
    "    m.aside     = aside;\n"
    "    m.towards   = -r.stretch * d.z;\n"
    "    m.seen      = 0u;\n"
    "    m.light     = vec3(0.0);\n"
    "    return m;\n"
    "}\n"
    "\n"
    "// pixels: from the receiver's\n"
    "dgb_sight dgb_sight_of(vec2 pixels, dgb_receiver r, dgb_march m) {\n"
    "    vec2 q = m.plane * pixels;\n"
    "    return dgb_sight(r.side * pixels, vec4(q, r.spread * q + vec2(r.stretch, 0.0)));\n"
    "}\n"
    "\n"
    "#if DGB_NORMAL_TEST\n"
    "float dgb_facing(dgb_receiver r, dgb_sight l, dgb_surface y) { return dot(y.n, r.sight) + r.spread * dot(y.n.xy, l.offset); }\n"
    "\n"
    "// Cotangents of where the sight so many metres on along d enters a surface, if its plane goes on that far, and leaves it.\n"
    "// plane: its depth at l, and by the metre. Depths are s / (1 + spread s): in these, planes are linear, and so are cotangents.\n"
    "vec2 dgb_ends_beside(dgb_receiver r, dgb_march m, dgb_sight l, vec2 plane, float thickness, float on) {\n"
    "    float front     = clamp(plane.x + on * plane.y, r.within.x, r.within.y);\n"
    "    float behind    = thickness * (1.0 - r.spread * front);\n"
    "    float back      = (front - behind) / (1.0 - r.spread * behind);\n"
    "    vec2  q         = l.q.xy + on * vec2(m.towards, 1.0);\n"
    "    vec2  cotangent = q.y > 0.0 ? vec2(q.x, r.stretch) * (1.0 / q.y) : vec2(-1e9, 0.0); // beyond x: below every horizon\n"
    "    return cotangent.x + cotangent.y * vec2(front, back);\n"
    "}\n"
    "\n"
    "// Versines of where a surface begins and ends, with what it stands for: half a step on, and back, but not to x itself, where\n"
    "// errors of the plane would hide everything. What is seen from behind lies as far away as can be. k: steps from x\n"
    "vec2 dgb_ends(dgb_receiver r, dgb_march m, dgb_sight l, dgb_surface y, float k) {\n"
    "    float facing = dgb_facing(r, l, y), inverse = 1.0 / (1.0 + r.spread * y.s);\n"
    "    vec2  plane  = facing > 0.0 ? inverse * vec2(y.s, -dot(y.n.xy, m.aside) / facing) : vec2(r.within.x, 0.0);\n"
    "    vec2  a      = dgb_ends_beside(r, m, l, plane, y.thickness, -m.half_step * min(k, 1.0));\n"
    "    vec2  b      = dgb_ends_beside(r, m, l, plane, y.thickness, m.half_step);\n"
    "    return vec2(dgb_versine(vec2(max(a.x, b.x), 1.0)), dgb_versine(vec2(min(a.y, b.y), 1.0)));\n"
    "}\n"
    "#endif\n"
    "\n"
    "// Whether a sight may tell of the slice: it is not the receiver's own, and does not pass x on the other side, though where\n"
    "// normals are read what it stands for may reach into the slice all the same.\n"
    "bool dgb_known(dgb_sight l) {\n"
    "#if DGB_NORMAL_TEST\n"
    "    return l.q.y != 0.0;\n"
    "#else\n"
    "    return l.q.y > 0.0;\n"
    "#endif\n"
    "}\n"
    "\n"
    "// Sectors that a surface covers with what is behind it, if either end is within the radius. k: steps from x; u: of the sectors\n"
    "uint dgb_covered(dgb_receiver r, dgb_march m, dgb_sight l, dgb_surface y, float k, float u) {\n",
    "    vec2 front = l.q.xy + y.s * l.q.zw, back = front - y.thickness * l.q.zw;\n"
    "#if DGB_NORMAL_TEST\n"
    "    vec2 ends = dgb_ends(r, m, l, y, k);\n"
    "#else\n"
    "    vec2 ends = vec2(dgb_versine(front), dgb_versine(back));\n"
    "#endif\n"
    "    uint covered = dgb_sectors_between(dgb_share(m.scale, ends.x), dgb_share(m.scale, ends.y), u);\n"
    "    return min(dot(front, front), dot(back, back)) <= dgb_bitmask_radius.y ? covered : 0u;\n"
    "}\n"
    "\n"
    "// Takes what a surface covers of what is still open; radiance: what it sends, if it faces the receiver.\n"
    "void dgb_stop(inout dgb_march m, uint covered, dgb_receiver r, dgb_sight l, dgb_surface y, vec3 radiance) {\n"
    "    uint seen = m.seen | covered, stopped = seen ^ m.seen;\n"
    "    m.seen = seen;\n"
    "#if DGB_NORMAL_TEST\n"
    "    if (!(dgb_facing(r, l, y) * y.s + dot(y.n.xy, l.offset) < 0.0)) stopped = 0u;\n"
    "#endif\n"
    "#if DGB_BITMASK_LIGHT\n"
    "    m.light += radiance * float(dgb_sector_count(stopped));\n"
    "#endif\n"
    "}\n"
    "\n"
    "// The step k, counted from x. second: look at the second layer\n"
    "void dgb_step(dgb_receiver r, inout dgb_march m, float k, float u, bool second) {\n"
    "    float       h   = max(k * r.pitch, 0.75); // nearer taps would land on the shaded pixel itself\n"
    "    dgb_tap     tap = dgb_tap_of(r.centre + h * m.direction, h, dgb_bitmask_size.xy, dgb_bitmask_level);\n"
    "    vec4        zs = texelFetch(dgb_z, tap.texel, tap.level);\n"
    "    vec2        thickness = dgb_thickness_of(zs, dgb_bitmask_radius.z);\n"
    "    vec3        b0 = vec3(0.0), b1 = vec3(0.0);\n"
    "    dgb_sight   l  = dgb_sight_of(vec2(tap.pixel) + 0.5 - r.centre, r, m);\n"
    "    dgb_surface y  = dgb_surface(zs.x - r.z, thickness.x, vec3(0.0));\n"
    "    bool        known = dgb_known(l);\n"
    "#if DGB_NORMAL_TEST\n"
    "    vec4 normals = texelFetch(dgb_normals, tap.texel, tap.level);\n"
    "    y.n          = dgb_oct16_direction(normals.xy);\n"
    "#endif\n"
    "#if DGB_BITMASK_LIGHT\n"
    "    b0 = texelFetch(dgb_b0, tap.texel, tap.level).rgb;\n"
    "#endif\n"
    "    uint covered = dgb_covered(r, m, l, y, k, u);\n"
    "    dgb_stop(m, dgb_bitmask_scale.w > 0.0 && known ? covered : 0u, r, l, y, b0);\n"
    "#if DGB_LAYERS > 1\n"
    "    if (second) {\n"
    "#if DGB_DIVISOR > 1\n"
    "        l     = dgb_sight_of(dgb_centre(1, tap.pixel) - r.centre, r, m);\n"
    "        known = dgb_known(l);\n"
    "#endif\n"
    "        y = dgb_surface(zs.y - r.z, thickness.y, vec3(0.0));\n"
    "#if DGB_NORMAL_TEST\n"
    "        y.n = dgb_oct16_direction(normals.zw);\n"
    "#endif\n"
    "#if DGB_BITMASK_LIGHT\n"
    "        b1 = texelFetch(dgb_b1, tap.texel, tap.level).rgb;\n"
    "#endif\n"
    "        covered = dgb_covered(r, m, l, y, k, u);\n"
    "        dgb_stop(m, known ? covered : 0u, r, l, y, b1);\n"
    "    }\n"
    "#endif\n"
    "}\n"
    "\n"
    "// Means over all slices. rgb: irradiance over pi, or covered directions; a: share of the cosine-weighted hemisphere that is covered.\n"
    "vec4 dgb_look(dgb_receiver r, bool there, bool second) {\n"
    "    float steps = float(dgb_bitmask_size.z), pair = 0.5 * dgb_bitmask_scale.y;\n"
    "    vec4  sum   = vec4(0.0);\n"
    "    for (int i = 0; i < (there ? 2 * int(dgb_bitmask_scale.x) : 0); ++i) {\n"
    "        float     shift  = float(i) * pair;\n"
    "        dgb_march m      = dgb_march_at(r, shift);\n"
    "        vec2      jitter = fract(r.noise.yw + shift);\n"
    "        float     last   = min(steps, m.room / r.pitch);\n"
    "        for (float k = jitter.x; k < last; k += 1.0) dgb_step(r, m, k, jitter.y, second);\n"
    "#if DGB_BENT\n"
    "        vec2 covered = 32.0 * dgb_sectors_mean(m.slice, m.seen);\n"
    "        m.light      = covered.x * dgb_towards_eye(r) + covered.y * m.d;\n"
    "#endif\n"
    "        sum += vec4(m.light, float(dgb_sector_count(m.seen)));\n"
    "    }\n"
    "    return sum * (pair / 32.0);\n"
    "}\n"
    "\n"
    "#if DGB_BITMASK_LIGHT\n"
    "// Irradiance of what is covered as if it covered all, and how much it covers: their product is what arrives.\n"
    "vec4 dgb_irradiance(vec4 look) { return vec4(look.a > 0.0 ? dgb_storable(DGB_PI * look.rgb / look.a) : vec3(0.0), look.a); }\n"
    "#endif\n"
    "\n"
    "#if DGB_BENT\n"
    "// Mean of the open directions in world space, weighted by the cosine, and their share. What is covered is taken from the whole,\n"
    "// 2/3 of the normal: where nothing is, there is no noise.\n"
    "vec4 dgb_bent(dgb_receiver r, vec4 look) {\n"
    "    vec3 bent = 2.0 / 3.0 * r.n - look.rgb;\n",
    "    vec3 world = bent.x * dgb_bitmask_world[0].xyz + bent.y * dgb_bitmask_world[1].xyz + bent.z * dgb_bitmask_world[2].xyz;\n"
    "    return dgb_storable_unit(vec4(world, 1.0 - look.a)); // too near to the eye, there is no direction to it\n"
    "}\n"
    "#endif\n"
    "\n"
    "void main() {\n"
    "    ivec2        pixel   = ivec2(gl_FragCoord.xy);\n"
    "    vec2         z       = texelFetch(dgb_z, pixel, 0).xy;\n"
    "    vec4         normals = texelFetch(dgb_normals, pixel, 0);\n"
    "    bvec3        tile    = bvec3(false);\n"
    "#if DGB_LAYERS > 1\n"
    "    tile = dgb_tile_at(pixel, dgb_bitmask_level.w != 0);\n"
    "#endif\n"
    "    dgb_receiver r = dgb_receiver_at(0, pixel, z.x, normals.xy);\n"
    "#if DGB_BITMASK_LIGHT\n"
    "    dgb_out_irradiance = dgb_irradiance(dgb_look(r, z.x > DGB_EMPTY_Z, tile.y));\n"
    "#if DGB_DEEP\n"
    "    r                   = dgb_receiver_at(1, pixel, z.y, normals.zw);\n"
    "    dgb_out_irradiance1 = dgb_irradiance(dgb_look(r, z.x > DGB_EMPTY_Z && z.y > DGB_EMPTY_Z && tile.z, true));\n"
    "#endif\n"
    "#else\n"
    "    vec4  look       = dgb_look(r, z.x > DGB_EMPTY_Z, tile.x);\n"
    "    float visibility = 1.0 - look.a;\n"
    "    dgb_out_ao       = vec4(dgb_bitmask_scale.z == 1.0 ? visibility : pow(visibility, dgb_bitmask_scale.z));\n"
    "#if DGB_BENT\n"
    "    dgb_out_bent = z.x > DGB_EMPTY_Z ? dgb_bent(r, look) : vec4(0.0, 0.0, 0.0, 1.0);\n"
    "#endif\n"
    "#endif\n"
    "}\n",
    0
};

static const char* const dgbgli_glsl_gather[] = { /* 50_gather.glsl */
    "#line 500001\n"
    "// Radiosity: Equations 4 and 5 of the paper over one or two layers of senders. A tap beyond the buffer finds none: with the\n"
    "// border in its place, what stands there would send again and again. Deep: the second layer receives as well, from the same taps\n"
    "// (section 3.3).\n"
    "\n"
    "layout(std140) uniform dgb_gather_block {\n"
    "    dgb_camera dgb_gather_camera;\n"
    "    ivec4      dgb_gather_size;   // buffer width, height, taps, frame\n"
    "    ivec4      dgb_gather_level;  // log2 q, min level, max level, 1: the second layer matters everywhere\n"
    "    vec4       dgb_gather_radius; // r (m), r^2, normaliser k, largest reach (pixels)\n"
    "    vec4       dgb_gather_first;  // x: 0 to leave out first-layer senders\n"
    "    vec4       dgb_gather_taps[DGB_MAX_TAPS];\n"
    "};\n"
    "\n"
    "uniform sampler2D dgb_z;\n"
    "uniform sampler2D dgb_normals;\n"
    "uniform sampler2D dgb_b0;\n"
    "#if DGB_LAYERS > 1\n"
    "uniform sampler2D dgb_b1;\n"
    "#endif\n"
    "\n"
    "layout(location = 0) out vec4 dgb_out_irradiance;\n"
    "#if DGB_DEEP\n"
    "layout(location = 1) out vec4 dgb_out_irradiance1;\n"
    "#endif\n"
    "\n"
    "struct dgb_receiver {\n"
    "    dgb_origin x;\n"
    "    vec3       n;\n"
    "    vec3       light;\n"
    "    float      cosines;\n"
    "    int        senders, useful_taps;\n"
    "};\n"
    "\n"
    "// A surface that a tap finds.\n"
    "struct dgb_sender {\n"
    "    vec2  pixel;\n"
    "    float z;\n"
    "    vec3  n, radiance; // n: of any length\n"
    "    bool  counts;\n"
    "};\n"
    "\n"
    "// Cosine of what a sender sends; 0 when it is too far (as an empty texel is), behind, or faces away.\n"
    "float dgb_received(dgb_sender s, dgb_receiver r) {\n"
    "    vec3  v      = dgb_offset(s.pixel, s.z, r.x, dgb_gather_camera);\n"
    "    float cosine = dgb_gather_term(v, r.n, dgb_gather_radius.y);\n"
    "    bool  counts = s.counts;\n"
    "#if DGB_NORMAL_TEST\n"
    "    counts = counts && dot(v, s.n) < 0.0;\n"
    "#endif\n"
    "    return counts ? cosine : 0.0;\n"
    "}\n"
    "\n"
    "void dgb_add(inout dgb_receiver r, float cosine, vec3 light) {\n"
    "    r.light += light;\n"
    "    r.cosines += cosine;\n"
    "    r.senders += int(cosine > 0.0);\n"
    "}\n"
    "\n"
    "#if DGB_LAYERS > 1\n"
    "void dgb_receive(inout dgb_receiver r, dgb_sender s0, dgb_sender s1) {\n"
    "    float c0 = dgb_received(s0, r), c1 = dgb_received(s1, r);\n"
    "    vec3  l0 = s0.radiance * c0, l1 = s1.radiance * c1;\n"
    "    r.useful_taps += int(c0 > 0.0 || c1 > 0.0);\n"
    "#if DGB_STRONGEST_SENDER\n"
    "    bool first = c1 == 0.0 || (c0 > 0.0 && dot(l0, vec3(1.0)) >= dot(l1, vec3(1.0)));\n"
    "    dgb_add(r, first ? c0 : c1, first ? l0 : l1);\n"
    "#else\n"
    "    dgb_add(r, c0, l0);\n"
    "    dgb_add(r, c1, l1);\n"
    "#endif\n"
    "}\n"
    "#endif\n"
    "\n"
    "void dgb_receive(inout dgb_receiver r, dgb_sender s) {\n"
    "    float cosine = dgb_received(s, r);\n"
    "    r.useful_taps += int(cosine > 0.0);\n"
    "    dgb_add(r, cosine, s.radiance * cosine);\n"
    "}\n"
    "\n"
    "dgb_receiver dgb_receiver_at(vec2 pixel, float z, vec2 normal) {\n"
    "    dgb_receiver r;\n"
    "    r.x       = dgb_origin_at(pixel, z, dgb_gather_camera);\n"
    "    r.n       = dgb_oct16_decode(normal);\n"
    "    r.light   = vec3(0.0);\n"
    "    r.cosines = 0.0;\n"
    "    r.senders = r.useful_taps = 0;\n"
    "    return r;\n"
    "}\n"
    "\n"
    "dgb_sender dgb_sender_at(vec2 pixel, float z, vec2 normal, vec3 radiance, bool counts) {\n"
    "    dgb_sender s;\n"
    "    s.pixel = pixel;\n"
    "    s.z     = z;\n"
    "#if DGB_NORMAL_TEST\n"
    "    s.n = dgb_oct16_direction(normal);\n"
    "#endif\n"
    "    s.radiance = radiance;\n"
    "    s.counts   = counts;\n"
    "    return s;\n"
    "}\n"
    "\n"
    "float dgb_gather_reach(float z) { return dgb_reach(z, dgb_gather_radius.x, dgb_gather_radius.w, dgb_gather_camera); }\n"
    "\n"
    "// taps: that lie within the receiver's own reach.\n"
    "vec4 dgb_irradiance(dgb_receiver r, float taps) {\n"
    "    vec3 irradiance = r.light * dgb_gather_scale(r.cosines, float(r.senders), dgb_gather_radius.z);\n"
    "    return vec4(dgb_storable(irradiance), taps > 0.0 ? min(float(r.useful_taps) / taps, 1.0) : 0.0);\n"
    "}\n"
    "\n"
    "struct dgb_shaded {\n"
    "    ivec2      pixel;\n"
    "    dgb_spiral spiral;\n"
    "};\n"
    "\n"
    "// What tap i finds, for the first layer's receiver and, if `deep`, the second's. second: look at second-layer senders. Both are\n"
    "// constant wherever this is called.\n"
    "void dgb_gather_tap(int i, dgb_shaded s, bool second, bool deep, inout dgb_receiver r0, inout dgb_receiver r1) {\n"
    "    dgb_tap tap    = dgb_tap_at(dgb_gather_taps[i], s.spiral, dgb_gather_level);\n",
    "    // the shaded surface sends itself nothing anyway, but those behind one another at the pixel might\n"
    "    bool    counts = tap.inside && (!second || tap.pixel != s.pixel);\n"
    "    vec2    zs     = texelFetch(dgb_z, tap.texel, tap.level).xy;\n"
    "    vec3    b0     = texelFetch(dgb_b0, tap.texel, tap.level).rgb;\n"
    "#if DGB_NORMAL_TEST\n"
    "    vec4 ns = texelFetch(dgb_normals, tap.texel, tap.level);\n"
    "#else\n"
    "    vec4 ns = vec4(0.0);\n"
    "#endif\n"
    "    dgb_sender s0 = dgb_sender_at(vec2(tap.pixel) + 0.5, zs.x, ns.xy, b0, counts && dgb_gather_first.x != 0.0);\n"
    "#if DGB_LAYERS > 1\n"
    "    if (second) {\n"
    "        vec3       b1 = texelFetch(dgb_b1, tap.texel, tap.level).rgb;\n"
    "        dgb_sender s1 = dgb_sender_at(dgb_centre(1, tap.pixel), zs.y, ns.zw, b1, counts);\n"
    "        dgb_receive(r0, s0, s1);\n"
    "        if (deep) dgb_receive(r1, s0, s1);\n"
    "        return;\n"
    "    }\n"
    "#endif\n"
    "    dgb_receive(r0, s0);\n"
    "}\n"
    "\n"
    "void main() {\n"
    "    dgb_shaded s;\n"
    "    s.pixel              = ivec2(gl_FragCoord.xy);\n"
    "    vec2         z       = texelFetch(dgb_z, s.pixel, 0).xy;\n"
    "    vec4         normals = texelFetch(dgb_normals, s.pixel, 0);\n"
    "    dgb_receiver r0      = dgb_receiver_at(gl_FragCoord.xy, z.x, normals.xy), r1 = r0;\n"
    "    float        reach   = dgb_gather_reach(z.x);\n"
    "    s.spiral             = dgb_spiral_at(gl_FragCoord.xy, reach, dgb_gather_size);\n"
    "    int taps             = z.x > DGB_EMPTY_Z && reach > 0.0 ? dgb_gather_size.z : 0;\n"
    "#if DGB_LAYERS > 1\n"
    "    // loops, not branches: every processor skips a loop that it does not run\n"
    "    bvec3 tile = dgb_tile_at(s.pixel, dgb_gather_level.w != 0);\n"
    "    bool  deep = false;\n"
    "#if DGB_DEEP\n"
    "    deep = tile.z;\n"
    "    if (deep) r1 = dgb_receiver_at(dgb_centre(1, s.pixel), z.y, normals.zw);\n"
    "    for (int i = 0; i < (deep ? taps : 0); ++i) dgb_gather_tap(i, s, true, true, r0, r1);\n"
    "#endif\n"
    "    for (int i = 0; i < (!deep && tile.y ? taps : 0); ++i) dgb_gather_tap(i, s, true, false, r0, r1);\n"
    "    for (int i = 0; i < (!deep && !tile.y ? taps : 0); ++i) dgb_gather_tap(i, s, false, false, r0, r1);\n"
    "#else\n"
    "    for (int i = 0; i < taps; ++i) dgb_gather_tap(i, s, false, false, r0, r1);\n"
    "#endif\n"
    "    dgb_out_irradiance = dgb_irradiance(r0, float(taps));\n"
    "#if DGB_DEEP\n"
    "    // taps go out evenly; those beyond the second layer's reach, which is shorter, could not have found anything for it\n"
    "    float within        = float(taps) * dgb_gather_reach(z.y) / reach;\n"
    "    dgb_out_irradiance1 = taps > 0 && z.y > DGB_EMPTY_Z ? dgb_irradiance(r1, max(within, 1.0)) : vec4(0.0);\n"
    "#endif\n"
    "}\n",
    0
};

static const char* const dgbgli_glsl_temporal[] = { /* 55_temporal.glsl */
    "#line 550001\n"
    "// Temporal filter: an exponentially weighted average along the motion of each surface, over ambient visibility, irradiance and\n"
    "// confidence (paper, section 3.3). History may come from either layer, wherever the surface was last frame. The first frames\n"
    "// weigh alike, so that a surface that has just come into view settles as fast as it can. With DGB_LIMITED, what stands out from\n"
    "// the 3 x 3 pixels of this frame is limited: history where the surface moves, and single samples.\n"
    "\n"
    "const float DGB_MOST_FRAMES = 1000.0; // counted: a half holds them exactly, and the greatest weight needs 999\n"
    "\n"
    "layout(std140) uniform dgb_temporal_block {\n"
    "    dgb_camera       dgb_temporal_camera;\n"
    "    vec4             dgb_temporal_weight; // of history; standard deviations, and times the mean, that are let through; frame\n"
    "    ivec4            dgb_temporal_present; // shaded rectangle: x0, y0, x1, y1, the last two inclusive\n"
    "    dgb_reprojection dgb_temporal_past;\n"
    "};\n"
    "\n"
    "uniform sampler2D dgb_z;\n"
    "uniform sampler2D dgb_normals;\n"
    "uniform sampler2D dgb_last_frames;\n"
    "#if DGB_FILTER_AO\n"
    "uniform sampler2D dgb_ao_raw;\n"
    "#endif\n"
    "#if DGB_BENT\n"
    "uniform sampler2D dgb_bent_raw;\n"
    "uniform sampler2D dgb_last_bent;\n"
    "#endif\n"
    "#if DGB_LAST_LIGHT\n"
    "uniform sampler2D dgb_irradiance_raw;\n"
    "#endif\n"
    "#if DGB_DEEP\n"
    "uniform sampler2D dgb_irradiance1_raw;\n"
    "#endif\n"
    "\n"
    "layout(location = 0) out vec4 dgb_out_frames; // ambient visibility and the frames averaged: of it, of layer 0, of layer 1\n"
    "#if DGB_LAST_LIGHT\n"
    "layout(location = 1) out vec4 dgb_out_irradiance;\n"
    "#endif\n"
    "#if DGB_DEEP\n"
    "layout(location = 2) out vec4 dgb_out_irradiance1;\n"
    "#endif\n"
    "#if DGB_BENT && DGB_DEEP\n"
    "layout(location = 3) out vec4 dgb_out_bent;\n"
    "#elif DGB_BENT && DGB_LAST_LIGHT\n"
    "layout(location = 2) out vec4 dgb_out_bent;\n"
    "#elif DGB_BENT\n"
    "layout(location = 1) out vec4 dgb_out_bent;\n"
    "#endif\n"
    "\n"
    "// Averages over the texels that the surface was at; share: of the bilinear weights that these have, 0 where there is no history.\n"
    "struct dgb_history {\n"
    "    float moved; // pixels since last frame\n"
    "    vec4  irradiance;\n"
    "    float frames, share;\n"
    "    float visibility, visibility_frames, visibility_share;\n"
    "    vec4  bent; // with the visibility's frames and share\n"
    "};\n"
    "\n"
    "// Layers hand on irradiance to each other, but visibility exists for the first alone.\n"
    "void dgb_add_history(inout dgb_history h, ivec2 texel, int shown, float weight) {\n"
    "    vec4 frames = texelFetch(dgb_last_frames, texel, 0);\n"
    "    if (shown < 0 || !(weight > 0.0)) return;\n"
    "    h.share += weight;\n"
    "    h.frames += weight * dgb_storable(shown == 1 ? frames.w : frames.z);\n"
    "#if DGB_LAST_LIGHT\n"
    "    h.irradiance += weight * dgb_weigh(dgb_last_irradiance_at(texel, shown));\n"
    "#endif\n"
    "    if (shown == 1) return;\n"
    "    h.visibility_share += weight;\n"
    "    h.visibility += weight * (frames.x < 1.0 ? dgb_storable(frames.x) : 1.0);\n"
    "    h.visibility_frames += weight * dgb_storable(frames.y);\n"
    "#if DGB_BENT\n"
    "    h.bent += weight * dgb_storable_unit(texelFetch(dgb_last_bent, texel, 0));\n"
    "#endif\n"
    "}\n"
    "\n"
    "dgb_history dgb_history_of(int layer, ivec2 pixel, float z, vec2 normal) {\n"
    "    vec2        at   = dgb_centre(layer, pixel);\n"
    "    vec3        x    = dgb_position(at, z, dgb_temporal_camera);\n"
    "    dgb_past    past = dgb_past_of(at, x, dgb_oct16_decode(normal), dgb_velocity_at(layer, pixel), dgb_temporal_past);\n"
    "    vec2        low  = floor(past.pixel - 0.5), part = past.pixel - 0.5 - low;\n"
    "    dgb_history h;\n"
    "    h.moved      = length(at - past.pixel);\n"
    "    h.irradiance = h.bent = vec4(0.0);\n"
    "    h.frames = h.share = h.visibility = h.visibility_frames = h.visibility_share = 0.0;\n"
    "    for (int i = past.tolerance < 0.0 || !(z > DGB_EMPTY_Z) ? 4 : 0; i < 4; ++i) {\n"
    "        ivec2 corner = ivec2(i & 1, i >> 1), texel = ivec2(low) + corner;\n"
    "        vec2  weight = mix(1.0 - part, part, vec2(corner));\n"
    "        texel        = clamp(texel, dgb_temporal_past.rect.xy, dgb_temporal_past.rect.zw);\n"
    "        dgb_add_history(h, texel, dgb_past_layer(texel, past, dgb_temporal_past), weight.x * weight.y);\n"
    "    }\n",
    "    float whole = dgb_whole(h.share), whole_visibility = dgb_whole(h.visibility_share);\n"
    "    h.share *= whole;\n"
    "    h.irradiance *= whole;\n"
    "    h.frames *= whole;\n"
    "    h.visibility_share *= whole_visibility;\n"
    "    h.visibility *= whole_visibility;\n"
    "    h.visibility_frames *= whole_visibility;\n"
    "    h.bent *= whole_visibility;\n"
    "    return h;\n"
    "}\n"
    "\n"
    "// Weight of an average of so many frames against one frame more.\n"
    "float dgb_history_weight(float frames) { return min(frames / (frames + 1.0), dgb_temporal_weight.x); }\n"
    "\n"
    "float dgb_one_more(float frames) { return min(frames + 1.0, DGB_MOST_FRAMES); }\n"
    "\n"
    "#if DGB_LIMITED\n"
    "// What this frame found, of layer 0, of layer 1, or, for -1, of the visibility.\n"
    "vec4 dgb_sample_at(int of, ivec2 p) {\n"
    "#if DGB_DEEP\n"
    "    if (of == 1) return dgb_weigh(texelFetch(dgb_irradiance1_raw, p, 0));\n"
    "#endif\n"
    "#if DGB_FILTER_AO\n"
    "    if (of == -1) return vec4(texelFetch(dgb_ao_raw, p, 0).x);\n"
    "#endif\n"
    "#if DGB_LAST_LIGHT\n"
    "    if (of == 0) return dgb_weigh(texelFetch(dgb_irradiance_raw, p, 0));\n"
    "#endif\n"
    "    return vec4(0.0);\n"
    "}\n"
    "\n"
    "float dgb_brightest(vec4 light) { return max(light.r, max(light.g, light.b)); }\n"
    "\n"
    "// Limits a sample and the history, both weighed, by the mean and the standard deviation of the 3 x 3 samples. A surface that moves\n"
    "// a pixel a frame or more has the narrowest box, one that stands still has none: there the box would only add the noise of a frame.\n"
    "void dgb_limit(int of, ivec2 pixel, float moved, bool known, inout vec4 present, inout vec4 history) {\n"
    "    vec4 sum = vec4(0.0), squares = vec4(0.0);\n"
    "    for (int i = 0; i < 9; ++i) {\n"
    "        ivec2 p = clamp(pixel + ivec2(i % 3, i / 3) - 1, dgb_temporal_present.xy, dgb_temporal_present.zw);\n"
    "        vec4  s = dgb_sample_at(of, p);\n"
    "        sum += s;\n"
    "        squares += s * s;\n"
    "    }\n"
    "    vec4  mean = sum / 9.0, others = max(sum - present, 0.0) / 8.0;\n"
    "    vec4  side = sqrt(max(squares / 9.0 - mean * mean, 0.0)) * (dgb_temporal_weight.y / clamp(moved, 1e-3, 1.0));\n"
    "    if (dgb_temporal_weight.y > 0.0 && moved > 0.0) history = clamp(history, mean - side, mean + side);\n"
    "    float own = dgb_brightest(present), most = dgb_temporal_weight.z * max(dgb_brightest(others), known ? dgb_brightest(history) : 0.0);\n"
    "    if (dgb_temporal_weight.z > 0.0 && of >= 0 && own > most) present.rgb *= most / own;\n"
    "}\n"
    "#endif\n"
    "\n"
    "vec4 dgb_filtered(int layer, ivec2 pixel, vec4 raw, dgb_history h) {\n"
    "    vec4 present = dgb_weigh(raw);\n"
    "#if DGB_LIMITED\n"
    "    dgb_limit(layer, pixel, h.moved, h.share > 0.0, present, h.irradiance);\n"
    "#endif\n"
    "    float weight = dgb_history_weight(h.frames);\n"
    "    vec4  mean   = dgb_unweigh(mix(present, h.irradiance, weight));\n"
    "    return dgb_averaged(vec4(dgb_storable(mean.rgb), mean.a), weight, pixel, int(dgb_temporal_weight.w));\n"
    "}\n"
    "\n"
    "void main() {\n"
    "    ivec2 pixel    = ivec2(gl_FragCoord.xy);\n"
    "    vec2  z        = texelFetch(dgb_z, pixel, 0).xy;\n"
    "    vec4  normals  = texelFetch(dgb_normals, pixel, 0);\n"
    "    dgb_out_frames = vec4(1.0, 0.0, 0.0, 0.0);\n"
    "\n"
    "    dgb_history h = dgb_history_of(0, pixel, z.x, normals.xy);\n"
    "#if DGB_LAST_LIGHT\n"
    "    vec4 raw           = texelFetch(dgb_irradiance_raw, pixel, 0);\n"
    "    vec4 filtered      = dgb_filtered(0, pixel, raw, h);\n"
    "    dgb_out_irradiance = z.x > DGB_EMPTY_Z ? filtered : raw;\n"
    "#endif\n"
    "#if DGB_FILTER_AO\n"
    "    vec4 open = vec4(texelFetch(dgb_ao_raw, pixel, 0).x), before = vec4(h.visibility);\n"
    "#if DGB_LIMITED\n"
    "    dgb_limit(-1, pixel, h.moved, h.visibility_share > 0.0, open, before);\n"
    "#endif\n"
    "    float weight = dgb_history_weight(h.visibility_frames);\n"
    "    open         = dgb_averaged(mix(open, before, weight), weight, pixel, int(dgb_temporal_weight.w));\n"
    "    if (z.x > DGB_EMPTY_Z) dgb_out_frames.xy = vec2(open.x, dgb_one_more(h.visibility_frames));\n"
    "#endif\n"
    "#if DGB_BENT\n"
    "    vec4 bent    = texelFetch(dgb_bent_raw, pixel, 0);\n"
    "    vec4 average = mix(bent, h.bent, weight);\n"
    "    dgb_out_bent = z.x > DGB_EMPTY_Z ? dgb_averaged(average, weight, pixel, int(dgb_temporal_weight.w)) : bent;\n"
    "#endif\n"
    "    if (z.x > DGB_EMPTY_Z) dgb_out_frames.z = dgb_one_more(h.frames);\n"
    "\n"
    "#if DGB_DEEP\n",
    "    dgb_history h1      = dgb_history_of(1, pixel, z.y, normals.zw);\n"
    "    vec4        raw1    = texelFetch(dgb_irradiance1_raw, pixel, 0);\n"
    "    vec4        deep    = dgb_filtered(1, pixel, raw1, h1);\n"
    "    dgb_out_irradiance1 = z.y > DGB_EMPTY_Z ? deep : raw1;\n"
    "    if (z.y > DGB_EMPTY_Z) dgb_out_frames.w = dgb_one_more(h1.frames);\n"
    "#endif\n"
    "}\n",
    0
};

static const char* const dgbgli_glsl_reconstruct[] = { /* 60_reconstruct.glsl */
    "#line 600001\n"
    "// Reconstruction: separable bilateral filter with normal and plane weights over ambient visibility, irradiance and\n"
    "// confidence together, for the second layer along its own surfaces; run along x, then along y. What the first run finds it\n"
    "// leaves in one texel beside the surface that it is for, so that the second run fetches once a tap.\n"
    "\n"
    "layout(std140) uniform dgb_reconstruct_block {\n"
    "    dgb_camera dgb_reconstruct_camera;\n"
    "    ivec4      dgb_reconstruct_rect;      // shaded rectangle: x0, y0, x1, y1 inclusive\n"
    "    ivec4      dgb_reconstruct_axis;      // step in x, in y, taps on one side\n"
    "    vec4       dgb_reconstruct_sharpness; // normal, plane\n"
    "    vec4       dgb_reconstruct_weights[DGB_MAX_FILTER_RADIUS + 1];\n"
    "};\n"
    "\n"
    "struct dgb_lit { // a surface and what is known of its light\n"
    "    float z;\n"
    "    vec2  normal; // Oct16\n"
    "    float ao;\n"
    "    vec4  irradiance; // a: confidence\n"
    "    vec4  bent;\n"
    "};\n"
    "\n"
    "// Two numbers from 0 to 64512 in 32 bits, each as exact as a half float: no sign, 6 bits of exponent, 10 of mantissa. Less than\n"
    "// 2^-46 becomes 0, NaN too. Neither function meets a subnormal number, which implementations may flush.\n"
    "uint dgb_pack(vec2 v) {\n"
    "    uvec2 codes = (floatBitsToUint(v * 8.271806125530277e-25) + 0x1000u) >> 13; // 2^-80\n"
    "    codes       = min(codes, 0xffffu);\n"
    "    if (!(v.x >= 1.4210854715202004e-14)) codes.x = 0u; // 2^-46\n"
    "    if (!(v.y >= 1.4210854715202004e-14)) codes.y = 0u;\n"
    "    return codes.x | codes.y << 16;\n"
    "}\n"
    "\n"
    "vec2 dgb_unpack(uint codes) {\n"
    "    return uintBitsToFloat(uvec2(codes << 13, codes >> 3) & 0x1fffe000u) * 1.2089258196146292e24; // 2^80\n"
    "}\n"
    "\n"
    "// In: what the passes before have left, then what the first run has.\n"
    "#if DGB_AXIS == 0\n"
    "uniform sampler2D dgb_z;\n"
    "uniform sampler2D dgb_normals;\n"
    "#if DGB_FILTER_AO\n"
    "uniform sampler2D dgb_ao_raw;\n"
    "#endif\n"
    "#if DGB_BENT\n"
    "uniform sampler2D dgb_bent_raw;\n"
    "#endif\n"
    "#if DGB_FILTER_IRRADIANCE\n"
    "uniform sampler2D dgb_irradiance_raw;\n"
    "#endif\n"
    "#if DGB_DEEP\n"
    "uniform sampler2D dgb_irradiance1_raw;\n"
    "#endif\n"
    "\n"
    "dgb_lit dgb_lit_at(int layer, ivec2 p) {\n"
    "    vec2    z       = texelFetch(dgb_z, p, 0).xy;\n"
    "    vec4    normals = texelFetch(dgb_normals, p, 0);\n"
    "    dgb_lit s       = dgb_lit(z.x, normals.xy, 1.0, vec4(0.0), vec4(0.0));\n"
    "#if DGB_FILTER_AO\n"
    "    s.ao = texelFetch(dgb_ao_raw, p, 0).x;\n"
    "#endif\n"
    "#if DGB_BENT\n"
    "    s.bent = texelFetch(dgb_bent_raw, p, 0);\n"
    "#endif\n"
    "#if DGB_FILTER_IRRADIANCE\n"
    "    s.irradiance = texelFetch(dgb_irradiance_raw, p, 0);\n"
    "#endif\n"
    "#if DGB_DEEP\n"
    "    if (layer == 1) s = dgb_lit(z.y, normals.zw, 1.0, texelFetch(dgb_irradiance1_raw, p, 0), vec4(0.0));\n"
    "#endif\n"
    "    return s;\n"
    "}\n"
    "#else\n"
    "uniform usampler2D dgb_half;\n"
    "#if DGB_DEEP\n"
    "uniform usampler2D dgb_half1;\n"
    "#endif\n"
    "#if DGB_BENT\n"
    "uniform sampler2D dgb_half_bent;\n"
    "#endif\n"
    "\n"
    "dgb_lit dgb_lit_at(int layer, ivec2 p) {\n"
    "    uvec4 t = texelFetch(dgb_half, p, 0);\n"
    "#if DGB_DEEP\n"
    "    if (layer == 1) t = texelFetch(dgb_half1, p, 0);\n"
    "#endif\n"
    "    vec2 normal = vec2(t.y & 255u, (t.y >> 8) & 255u) * (1.0 / 255.0);\n"
    "    vec4 bent   = vec4(0.0);\n"
    "#if DGB_BENT\n"
    "    bent = texelFetch(dgb_half_bent, p, 0);\n"
    "#endif\n"
    "    return dgb_lit(uintBitsToFloat(t.x), normal, float(t.y >> 16) * (1.0 / 65535.0), vec4(dgb_unpack(t.z), dgb_unpack(t.w)), bent);\n"
    "}\n"
    "#endif\n"
    "\n"
    "// Out: z | Oct16 and, above it, ambient visibility | irradiance and confidence; then the results.\n"
    "#if DGB_AXIS == 0\n"
    "layout(location = 0) out uvec4 dgb_out_half;\n"
    "#if DGB_DEEP\n"
    "layout(location = 1) out uvec4 dgb_out_half1;\n"
    "#endif\n"
    "#if DGB_BENT && DGB_DEEP\n"
    "layout(location = 2) out vec4 dgb_out_half_bent;\n"
    "#elif DGB_BENT\n"
    "layout(location = 1) out vec4 dgb_out_half_bent;\n"
    "#endif\n"
    "\n"
    "uvec4 dgb_texel(dgb_lit s) {\n"
    "    uvec3 bytes = uvec3(vec3(s.normal * 255.0, s.ao * 65535.0) + 0.5);\n"
    "    return uvec4(floatBitsToUint(s.z), bytes.x | bytes.y << 8 | bytes.z << 16, dgb_pack(s.irradiance.xy), dgb_pack(s.irradiance.zw));\n"
    "}\n"
    "#else\n"
    "#if DGB_FILTER_AO\n"
    "layout(location = 0) out vec4 dgb_out_ao;\n"
    "#endif\n"
    "#if DGB_FILTER_IRRADIANCE\n"
    "layout(location = DGB_FILTER_AO) out vec4 dgb_out_irradiance;\n"
    "#endif\n"
    "#if DGB_DEEP && DGB_FILTER_AO\n",
    "layout(location = 2) out vec4 dgb_out_irradiance1;\n"
    "#elif DGB_DEEP\n"
    "layout(location = 1) out vec4 dgb_out_irradiance1;\n"
    "#endif\n"
    "#if DGB_BENT && DGB_DEEP\n"
    "layout(location = 3) out vec4 dgb_out_bent;\n"
    "#elif DGB_BENT && DGB_FILTER_IRRADIANCE\n"
    "layout(location = 2) out vec4 dgb_out_bent;\n"
    "#elif DGB_BENT\n"
    "layout(location = 1) out vec4 dgb_out_bent;\n"
    "#endif\n"
    "#endif\n"
    "\n"
    "struct dgb_sums {\n"
    "    float weight, ao;\n"
    "    vec4  irradiance, bent;\n"
    "};\n"
    "\n"
    "void dgb_add(inout dgb_sums sums, float weight, dgb_lit s) {\n"
    "    sums.weight += weight;\n"
    "    sums.ao += weight * s.ao;\n"
    "    sums.bent += weight * s.bent;\n"
    "    sums.irradiance += vec4(s.irradiance.rgb * (weight * s.irradiance.a), weight * s.irradiance.a); // dgb_weigh\n"
    "}\n"
    "\n"
    "struct dgb_filter { // of one surface\n"
    "    int        layer;\n"
    "    ivec2      pixel;\n"
    "    dgb_origin x;\n"
    "    vec3       n;\n"
    "};\n"
    "\n"
    "// The tap at a place along the axis. nearest: the place nearest to it in the shaded rectangle; weight: by distance in the image.\n"
    "void dgb_add_tap(inout dgb_sums sums, dgb_filter f, int at, int nearest, float weight) {\n"
    "    ivec2   p  = DGB_AXIS == 0 ? ivec2(nearest, f.pixel.y) : ivec2(f.pixel.x, nearest);\n"
    "    dgb_lit t  = dgb_lit_at(f.layer, p);\n"
    "    vec3    dq = dgb_offset(dgb_centre(f.layer, p), t.z, f.x, dgb_reconstruct_camera);\n"
    "    // a factor for what must not count: a select between a read and none becomes a branch\n"
    "    weight *= at == nearest && t.z > DGB_EMPTY_Z ? 1.0 : 0.0;\n"
    "    weight *= dgb_bilateral_weight(f.n, dgb_oct16_decode(t.normal), dq, dgb_reconstruct_sharpness.x, dgb_reconstruct_sharpness.y);\n"
    "    dgb_add(sums, weight, t);\n"
    "}\n"
    "\n"
    "dgb_lit dgb_filtered(int layer, ivec2 pixel) {\n"
    "    dgb_lit    s    = dgb_lit_at(layer, pixel);\n"
    "    dgb_origin x    = dgb_origin_at(dgb_centre(layer, pixel), s.z, dgb_reconstruct_camera);\n"
    "    dgb_filter f    = dgb_filter(layer, pixel, x, dgb_oct16_decode(s.normal));\n"
    "    int        side = s.z > DGB_EMPTY_Z ? dgb_reconstruct_axis.z : 0, here = pixel[DGB_AXIS];\n"
    "    dgb_sums   sums = dgb_sums(0.0, 0.0, vec4(0.0), vec4(0.0));\n"
    "    dgb_add(sums, dgb_reconstruct_weights[0].x, s);\n"
    "    for (int i = 1; i <= side; ++i) { // on both sides at once: i is the same for all pixels, and so is what it reads\n"
    "        int   before = here - i * dgb_reconstruct_axis[DGB_AXIS], after = here + i * dgb_reconstruct_axis[DGB_AXIS];\n"
    "        float weight = dgb_reconstruct_weights[i].x;\n"
    "        dgb_add_tap(sums, f, before, max(before, dgb_reconstruct_rect[DGB_AXIS]), weight);\n"
    "        dgb_add_tap(sums, f, after, min(after, dgb_reconstruct_rect[DGB_AXIS + 2]), weight);\n"
    "    }\n"
    "    vec4 irradiance = dgb_unweigh(sums.irradiance / sums.weight);\n"
    "    s.ao            = sums.ao / sums.weight;\n"
    "    s.bent          = sums.bent / sums.weight;\n"
    "    s.irradiance    = vec4(dgb_storable(irradiance.rgb), irradiance.a);\n"
    "    return s;\n"
    "}\n"
    "\n"
    "void main() {\n"
    "    ivec2   pixel = ivec2(gl_FragCoord.xy);\n"
    "    dgb_lit s     = dgb_filtered(0, pixel);\n"
    "#if DGB_AXIS == 0\n"
    "    dgb_out_half = dgb_texel(s);\n"
    "#if DGB_DEEP\n"
    "    dgb_out_half1 = dgb_texel(dgb_filtered(1, pixel));\n"
    "#endif\n"
    "#if DGB_BENT\n"
    "    dgb_out_half_bent = s.bent;\n"
    "#endif\n"
    "#else\n"
    "#if DGB_FILTER_AO\n"
    "    dgb_out_ao = vec4(s.ao);\n"
    "#endif\n"
    "#if DGB_BENT\n"
    "    dgb_out_bent = s.bent;\n"
    "#endif\n"
    "#if DGB_FILTER_IRRADIANCE\n"
    "    dgb_out_irradiance = s.irradiance;\n"
    "#endif\n"
    "#if DGB_DEEP\n"
    "    dgb_out_irradiance1 = dgb_filtered(1, pixel).irradiance;\n"
    "#endif\n"
    "#endif\n"
    "}\n",
    0
};

static const char* const dgbgli_glsl_range[] = { /* 63_range.glsl */
    "#line 630001\n"
    "// Range: the depth ranges by which the hierarchical tracer skips what a ray cannot meet. There is a cell of level m for every\n"
    "// 4 * 2^m pixels along a side, but it holds the range of twice as many, those of its neighbours to the right and above with its\n"
    "// own: a stretch of a ray that is shorter than a cell lies wholly within what one cell holds, whatever borders it crosses.\n"
    "\n"
    "layout(location = 0) out vec4 dgb_out_ranges; // largest and smallest z of layer 0, of layer 1\n"
    "\n"
    "#if DGB_RANGE_STEP == 0\n"
    "uniform sampler2D dgb_z;\n"
    "\n"
    "const int DGB_CHILDREN = 4, DGB_NEXT = 1; // along a side of a cell; from one to the next\n"
    "\n"
    "vec4 dgb_child(ivec2 p) { return dgb_depths_of(texelFetch(dgb_z, min(p, textureSize(dgb_z, 0) - 1), 0).xy); }\n"
    "#else\n"
    "uniform sampler2D dgb_ranges; // the level before\n"
    "\n"
    "const int DGB_CHILDREN = 2, DGB_NEXT = 2; // every other one: they overlap\n"
    "\n"
    "vec4 dgb_child(ivec2 p) { return texelFetch(dgb_ranges, min(p, textureSize(dgb_ranges, 0) - 1), 0); }\n"
    "#endif\n"
    "\n"
    "void main() {\n"
    "    ivec2 corner = DGB_CHILDREN * ivec2(gl_FragCoord.xy);\n"
    "    vec4  range  = DGB_NO_DEPTHS;\n"
    "    for (int y = 0; y < 2 * DGB_CHILDREN; y += DGB_NEXT)\n"
    "        for (int x = 0; x < 2 * DGB_CHILDREN; x += DGB_NEXT) range = dgb_join(range, dgb_child(corner + ivec2(x, y)));\n"
    "    dgb_out_ranges = range;\n"
    "}\n",
    0
};

static const char* const dgbgli_glsl_reflect[] = { /* 65_reflect.glsl */
    "#line 650001\n"
    "// Reflections: the reflected ray marched through the image, perspective-correct, against both layers. A hit is a ray that\n"
    "// comes to lie behind a surface by no more than its thickness; everything else is a miss, which the engine fills from its\n"
    "// environment map.\n"
    "\n"
    "layout(std140) uniform dgb_reflect_block {\n"
    "    dgb_camera dgb_reflect_camera;\n"
    "    ivec4      dgb_reflect_size; // buffer width, height, most steps, frame\n"
    "    ivec4      dgb_reflect_rect; // where there is irradiance: x0, y0, x1, y1 inclusive\n"
    "    vec4       dgb_reflect_ray;  // longest (m), thickness of a surface (m), pixels a step, z of the near plane (m)\n"
    "    vec4       dgb_reflect_fade; // width of the border where confidence fades (pixels)\n"
    "    ivec4      dgb_reflect_skip; // log2 of the most steps skipped at once, of the least power of two >= pixels a step\n"
    "};\n"
    "\n"
    "uniform sampler2D dgb_z;\n"
    "uniform sampler2D dgb_normals;\n"
    "uniform sampler2D dgb_b0;\n"
    "#if DGB_LAYERS > 1\n"
    "uniform sampler2D dgb_b1;\n"
    "#endif\n"
    "#if DGB_HIERARCHICAL\n"
    "uniform sampler2D dgb_ranges;\n"
    "#endif\n"
    "#if DGB_INDIRECT\n"
    "uniform sampler2D dgb_irradiance;\n"
    "#if DGB_LAYERS > 1\n"
    "uniform sampler2D dgb_irradiance1;\n"
    "#endif\n"
    "#endif\n"
    "\n"
    "layout(location = 0) out vec4 dgb_out_reflection; // radiance, confidence\n"
    "layout(location = 1) out vec4 dgb_out_hit;        // layer + 1, 0 for none; length of the ray (m); glossy: its direction\n"
    "\n"
    "// A ray in the image: pixel, z / w and 1 / w are linear along it.\n"
    "struct dgb_ray {\n"
    "    vec3  x, n, direction;\n"
    "    vec2  pixel, pixels;  // first, and from first to last\n"
    "    vec2  depth, depths;  // z / w and 1 / w likewise\n"
    "    float step;           // share of the way that a step goes\n"
    "    int   steps;          // 0: there is nothing to march\n"
    "};\n"
    "\n"
    "float dgb_clip_w(float z, dgb_camera camera) { return camera.footprint.y * z + camera.footprint.z; }\n"
    "\n"
    "vec2 dgb_ray_pixel(dgb_ray ray, float s) { return ray.pixel + s * ray.pixels; }\n"
    "\n"
    "float dgb_ray_z(dgb_ray ray, float s) {\n"
    "    vec2 d = ray.depth + s * ray.depths;\n"
    "    return d.x / d.y;\n"
    "}\n"
    "\n"
    "// Share of the way from a to b at which a coordinate leaves low..high; 1 if it does not.\n"
    "float dgb_leaves(float a, float b, float low, float high) {\n"
    "    float bound = b > a ? high : low;\n"
    "    return b != a ? min(max((bound - a) / (b - a), 0.0), 1.0) : 1.0;\n"
    "}\n"
    "\n"
    "dgb_ray dgb_ray_of(vec3 from, vec3 n, vec3 direction) {\n"
    "    dgb_camera camera = dgb_reflect_camera;\n"
    "    vec2       high   = vec2(dgb_reflect_size.xy);\n"
    "    float      reach  = dgb_reflect_ray.x;\n"
    "    // towards the eye a ray ends at the near plane\n"
    "    if (direction.z > 0.0) reach = min(reach, (dgb_reflect_ray.w - from.z) / direction.z);\n"
    "    vec3    to = from + max(reach, 0.0) * direction;\n"
    "    float   k0 = 1.0 / dgb_clip_w(from.z, camera), k1 = 1.0 / dgb_clip_w(to.z, camera);\n"
    "    dgb_ray ray;\n"
    "    ray.x         = from;\n"
    "    ray.n         = n;\n"
    "    ray.direction = direction;\n"
    "    ray.pixel  = dgb_project(from, camera);\n"
    "    ray.pixels = dgb_project(to, camera) - ray.pixel;\n"
    "    ray.depth  = vec2(from.z * k0, k0);\n"
    "    ray.depths = vec2(to.z * k1, k1) - ray.depth;\n"
    "    // and everywhere at the border of the buffer\n"
    "    float inside = min(dgb_leaves(ray.pixel.x, ray.pixel.x + ray.pixels.x, 0.0, high.x),\n"
    "                       dgb_leaves(ray.pixel.y, ray.pixel.y + ray.pixels.y, 0.0, high.y));\n"
    "    ray.pixels *= inside;\n"
    "    ray.depths *= inside;\n"
    "    float pixels = max(abs(ray.pixels.x), abs(ray.pixels.y));\n"
    "    // a ray in the plane of its surface, within the error of an Oct16 normal, or behind it is none, and NaN is no ray either\n"
    "    bool  valid  = from.z > DGB_EMPTY_Z && reach > 0.0 && pixels < 1e6 && dot(direction, n) > DGB_MIN_COSINE;\n"
    "    ray.step     = valid && pixels > 0.0 ? dgb_reflect_ray.z / pixels : 1.0;\n"
    "    // the first step is a part of one, so that it takes one more to reach the end\n"
    "    ray.steps    = valid ? min(int(ceil(1.0 / ray.step)) + 1, dgb_reflect_size.z) : 0;\n"
    "    return ray;\n"
    "}\n"
    "\n"
    "// Whether the ray, at z now and at z_before one step ago, lies behind a surface within its thickness.\n",
    "bool dgb_is_behind(float z, float z_before, float surface, float thickness) {\n"
    "    return surface > DGB_EMPTY_Z && z <= surface && max(z, z_before) >= surface - thickness;\n"
    "}\n"
    "\n"
    "// Whether the ray's own surface could not reach there: else a flat mirror sees itself in stripes. The shaded pixel itself never\n"
    "// is above, on either layer.\n"
    "bool dgb_is_above(vec2 pixel, float z, dgb_ray ray) {\n"
    "    vec3 v = dgb_position(pixel, z, dgb_reflect_camera) - ray.x;\n"
    "    return dot(v, ray.n) > DGB_MIN_COSINE * length(v);\n"
    "}\n"
    "\n"
    "// Where step i ends. Before the first lies the beginning.\n"
    "float dgb_step_end(dgb_ray ray, float jitter, int i) { return clamp((float(i) + jitter) * ray.step, 0.0, 1.0); }\n"
    "\n"
    "const int DGB_REFLECT_HALVINGS = 4; // of a step, once something is hit\n"
    "\n"
    "int dgb_lookups = 0; // texels that the march has read; only benchmarks look at it\n"
    "\n"
    "struct dgb_hit {\n"
    "    int   layer; // -1: none\n"
    "    float s;     // share of the way\n"
    "    ivec2 texel;\n"
    "    float depth; // behind the surface when the ray came there, as a share of the thickness; 0: it came from before it\n"
    "};\n"
    "\n"
    "dgb_hit dgb_hit_at(dgb_ray ray, float s, float z_before) {\n"
    "    float   z = dgb_ray_z(ray, s), nearest = max(z, z_before);\n"
    "    dgb_hit hit;\n"
    "    hit.s     = s;\n"
    "    hit.texel = clamp(ivec2(dgb_ray_pixel(ray, s)), ivec2(0), dgb_reflect_size.xy - 1);\n"
    "    vec4 zs        = texelFetch(dgb_z, hit.texel, 0);\n"
    "    vec2 thickness = dgb_thickness_of(zs, dgb_reflect_ray.y);\n"
    "    ++dgb_lookups;\n"
    "    bool first = dgb_is_behind(z, z_before, zs.x, thickness.x) && dgb_is_above(dgb_centre(0, hit.texel), zs.x, ray), second = false;\n"
    "#if DGB_LAYERS > 1\n"
    "    second = dgb_is_behind(z, z_before, zs.y, thickness.y) && dgb_is_above(dgb_centre(1, hit.texel), zs.y, ray);\n"
    "#endif\n"
    "    hit.layer = first ? 0 : second ? 1 : -1;\n"
    "    hit.depth = max(first ? (zs.x - nearest) / thickness.x : (zs.y - nearest) / thickness.y, 0.0);\n"
    "    return hit;\n"
    "}\n"
    "\n"
    "// Halves the step from `before`, so that a hit of a long step lies where the ray first meets the surface. What is left of the\n"
    "// step must meet it too: past an edge, a ray may come to lie far behind a surface that it never was before.\n"
    "dgb_hit dgb_refined(dgb_hit hit, dgb_ray ray, float before) {\n"
    "    for (int i = 0; i < DGB_REFLECT_HALVINGS; ++i) {\n"
    "        dgb_hit middle = dgb_hit_at(ray, 0.5 * (before + hit.s), dgb_ray_z(ray, before));\n"
    "        if (middle.layer >= 0) hit = middle; // on whichever layer\n"
    "        else before = middle.s;\n"
    "    }\n"
    "    return dgb_hit_at(ray, hit.s, dgb_ray_z(ray, before));\n"
    "}\n"
    "\n"
    "#if DGB_HIERARCHICAL\n"
    "const int   DGB_LOG2_RUN   = 2;              // of 4 steps, which are tested one by one when they cannot be skipped together\n"
    "const int   DGB_LOG2_CELL  = 2;              // of the 4 pixels of a cell of the finest ranges\n"
    "const float DGB_Z_ROUNDING = 1.0 / 262144.0; // relative: some 30 times that of the quotient in dgb_ray_z\n"
    "\n"
    "// Whether a step could hit a surface of a range, its z being low to high. Not if all of them lie behind it, nor if it begins\n"
    "// farther behind all of them than they are thick. NaN says nothing.\n"
    "bool dgb_may_hit(vec2 range, float low, float high) { return !(low > range.x || high < range.y - dgb_reflect_ray.y); }\n"
    "\n"
    "// Whether steps `first` to `last`, which together are shorter than a cell, hit nothing; z: where they begin and end. In between,\n"
    "// pixels are monotonic in every rounding, z all but monotonic.\n"
    "bool dgb_is_clear(dgb_ray ray, float jitter, int first, int last, vec2 z, int log2_cell) {\n"
    "    vec2  a = dgb_ray_pixel(ray, dgb_step_end(ray, jitter, first)), b = dgb_ray_pixel(ray, dgb_step_end(ray, jitter, last));\n"
    "    ivec2 corner = clamp(ivec2(min(a, b)), ivec2(0), dgb_reflect_size.xy - 1);\n"
    "    vec4  range  = texelFetch(dgb_ranges, corner >> log2_cell, log2_cell - DGB_LOG2_CELL);\n"
    "    float low = min(z.x, z.y), high = max(z.x, z.y);\n"
    "    low -= DGB_Z_ROUNDING * abs(low);\n"
    "    high += DGB_Z_ROUNDING * abs(high);\n"
    "    ++dgb_lookups;\n"
    "    bool hits = dgb_may_hit(range.xy, low, high);\n"
    "#if DGB_LAYERS > 1\n",
    "    hits = hits || dgb_may_hit(range.zw, low, high);\n"
    "#endif\n"
    "    return !hits;\n"
    "}\n"
    "\n"
    "// Skips steps from i on as long as the ranges tell that they hit nothing: twice as many after a success, half as many after a\n"
    "// failure. z: where step i begins.\n"
    "void dgb_skip(dgb_ray ray, float jitter, inout int i, inout float z) {\n"
    "    int log2_steps = min(DGB_LOG2_RUN, dgb_reflect_skip.x); // long steps: no cell is as long as a run\n"
    "    while (log2_steps >= DGB_LOG2_RUN && i < ray.steps) {\n"
    "        int   last  = min(i + (1 << log2_steps), ray.steps) - 1;\n"
    "        float z_end = dgb_ray_z(ray, dgb_step_end(ray, jitter, last));\n"
    "        bool  clear = dgb_is_clear(ray, jitter, i, last, vec2(z, z_end), log2_steps + dgb_reflect_skip.y);\n"
    "        i = clear ? last + 1 : i;\n"
    "        z = clear ? z_end : z;\n"
    "        log2_steps = clear ? min(log2_steps + 1, dgb_reflect_skip.x) : log2_steps - 1;\n"
    "    }\n"
    "}\n"
    "#endif\n"
    "\n"
    "// The first step from i on that hits; i moves behind it. The hierarchical tracer takes the same steps as the linear one, and\n"
    "// leaves out what cannot hit.\n"
    "dgb_hit dgb_next_hit(dgb_ray ray, float jitter, inout int i) {\n"
    "    float   z = dgb_ray_z(ray, dgb_step_end(ray, jitter, i - 1));\n"
    "    int     end = ray.steps;\n"
    "    dgb_hit hit;\n"
    "    hit.layer = -1;\n"
    "    hit.s     = hit.depth = 0.0;\n"
    "    hit.texel = ivec2(0);\n"
    "#if DGB_HIERARCHICAL\n"
    "    while (hit.layer < 0 && i < ray.steps) {\n"
    "        dgb_skip(ray, jitter, i, z);\n"
    "        end = min(i + (1 << DGB_LOG2_RUN), ray.steps);\n"
    "#endif\n"
    "        for (; hit.layer < 0 && i < end; ++i) {\n"
    "            float s = dgb_step_end(ray, jitter, i);\n"
    "            hit     = dgb_hit_at(ray, s, z);\n"
    "            z       = dgb_ray_z(ray, s);\n"
    "        }\n"
    "#if DGB_HIERARCHICAL\n"
    "    }\n"
    "#endif\n"
    "    return hit;\n"
    "}\n"
    "\n"
    "// The first hit that stands.\n"
    "dgb_hit dgb_march(dgb_ray ray, float jitter) {\n"
    "    int     i   = 0;\n"
    "    dgb_hit hit = dgb_next_hit(ray, jitter, i);\n"
    "    while (hit.layer >= 0) {\n"
    "        hit = dgb_refined(hit, ray, dgb_step_end(ray, jitter, i - 2));\n"
    "        if (hit.layer >= 0) break;\n"
    "        hit = dgb_next_hit(ray, jitter, i);\n"
    "    }\n"
    "    return hit;\n"
    "}\n"
    "\n"
    "// How far a hit can be trusted: less near the border of the buffer, deep behind a surface, and where that faces away.\n"
    "float dgb_trust(dgb_hit hit, dgb_ray ray, vec3 hit_normal) {\n"
    "    vec2  centre = vec2(hit.texel) + 0.5, margin = min(centre, vec2(dgb_reflect_size.xy) - centre);\n"
    "    float border = clamp(min(margin.x, margin.y) / max(dgb_reflect_fade.x, 0.5), 0.0, 1.0);\n"
    "    float inside = clamp(2.0 - 2.0 * hit.depth, 0.0, 1.0);\n"
    "    float facing = clamp(-4.0 * dot(ray.direction, hit_normal), 0.0, 1.0);\n"
    "    return border * inside * facing;\n"
    "}\n"
    "\n"
    "#if DGB_INDIRECT\n"
    "// Irradiance of a layer as far as it is known: by its confidence, and none where nothing was shaded.\n"
    "vec3 dgb_known(ivec2 texel, bool second) {\n"
    "    vec4 e = texelFetch(dgb_irradiance, texel, 0);\n"
    "#if DGB_LAYERS > 1\n"
    "    if (second) e = texelFetch(dgb_irradiance1, texel, 0);\n"
    "#endif\n"
    "    bool shaded = all(greaterThanEqual(texel, dgb_reflect_rect.xy)) && all(lessThanEqual(texel, dgb_reflect_rect.zw));\n"
    "    return shaded ? e.rgb * e.a : vec3(0.0);\n"
    "}\n"
    "\n"
    "// What a Lambert surface makes of the light that this frame has gathered: albedo/pi * E.\n"
    "vec3 dgb_indirect(ivec2 texel, bool second) {\n"
    "    vec3 albedo = dgb_albedo_at(0, texel);\n"
    "#if DGB_LAYERS > 1\n"
    "    if (second) albedo = dgb_albedo_at(1, texel);\n"
    "#endif\n"
    "    return dgb_storable(albedo) / DGB_PI * dgb_known(texel, second);\n"
    "}\n"
    "#endif\n"
    "\n"
    "void main() {\n"
    "    ivec2 pixel  = ivec2(gl_FragCoord.xy);\n"
    "    float z      = texelFetch(dgb_z, pixel, 0).x;\n"
    "    vec3  x      = dgb_position(gl_FragCoord.xy, z, dgb_reflect_camera);\n"
    "    vec3  n      = dgb_oct16_decode(texelFetch(dgb_normals, pixel, 0).xy);\n"
    "    vec3  view   = dgb_view(x, dgb_reflect_camera), facet = n;\n"
    "    int   frame  = 0; // nothing averages the frames of a mirror: always the same\n"
    "#if DGB_GLOSSY\n"
    "    float alpha = dgb_ggx_alpha(dgb_roughness_at(pixel));\n"
    "    frame       = alpha > 0.0 ? dgb_reflect_size.w : 0;\n",
    "    facet       = dgb_ggx_normal(-view, n, alpha, dgb_pixel_pair(pixel, frame));\n"
    "#endif\n"
    "    float jitter = (float(dgb_pixel_hash(pixel, frame)) + 0.5) / 256.0;\n"
    "    dgb_ray ray  = dgb_ray_of(x, n, reflect(view, facet));\n"
    "    dgb_hit hit  = dgb_march(ray, jitter);\n"
    "\n"
    "    vec4 normals = texelFetch(dgb_normals, hit.texel, 0);\n"
    "    vec3 light   = texelFetch(dgb_b0, hit.texel, 0).rgb;\n"
    "    vec2 zs      = texelFetch(dgb_z, hit.texel, 0).xy;\n"
    "    bool second  = false;\n"
    "#if DGB_LAYERS > 1\n"
    "    second = hit.layer == 1;\n"
    "    light  = second ? texelFetch(dgb_b1, hit.texel, 0).rgb : light;\n"
    "#endif\n"
    "#if DGB_INDIRECT\n"
    "    light += dgb_indirect(hit.texel, second);\n"
    "#endif\n"
    "    float trust    = hit.layer < 0 ? 0.0 : dgb_trust(hit, ray, dgb_oct16_decode(second ? normals.zw : normals.xy));\n"
    "    vec3  there    = dgb_position(dgb_centre(int(second), hit.texel), second ? zs.y : zs.x, dgb_reflect_camera);\n"
    "    dgb_out_reflection = trust > 0.0 ? vec4(dgb_storable(light), trust) : vec4(0.0);\n"
    "    dgb_out_hit        = trust > 0.0 ? vec4(hit.layer + 1, min(length(there - x), DGB_MAX_RADIANCE), 0.0, 0.0) : vec4(0.0);\n"
    "#ifdef DGB_COUNT_LOOKUPS\n"
    "    dgb_out_hit.y = float(dgb_lookups);\n"
    "#endif\n"
    "#if DGB_GLOSSY\n"
    "    dgb_out_hit.zw = dgb_octahedral(ray.direction);\n"
    "#endif\n"
    "}\n",
    0
};

static const char* const dgbgli_glsl_glossy[] = { /* 68_glossy.glsl */
    "#line 680001\n"
    "// Glossy reflections: the radiance of a lobe, from the one ray that each pixel of it sends, those of neighbours on the same\n"
    "// surface, and those of frames before. A neighbour's ray counts as much as this pixel's lobe would rather have sent it:\n"
    "// density here over density there (ratio estimator; Stachowiak 2015). Misses count as confidence 0, not as black.\n"
    "\n"
    "layout(std140) uniform dgb_glossy_block {\n"
    "    dgb_camera       dgb_glossy_camera;\n"
    "    ivec4            dgb_glossy_rect;    // where there are reflections: x0, y0, x1, y1 inclusive\n"
    "    ivec4            dgb_glossy_size;    // taps, frame\n"
    "    vec4             dgb_glossy_reach;   // largest radius (pixels), longest ray (m), weight of history\n"
    "    vec4             dgb_glossy_sharpness; // normal, plane\n"
    "    dgb_reprojection dgb_glossy_past;\n"
    "    vec4             dgb_glossy_taps[DGB_MAX_GLOSSY_TAPS];\n"
    "};\n"
    "\n"
    "uniform sampler2D dgb_z;\n"
    "uniform sampler2D dgb_normals;\n"
    "uniform sampler2D dgb_reflection_raw;\n"
    "uniform sampler2D dgb_reflection_hit;\n"
    "#if DGB_HISTORY\n"
    "uniform sampler2D dgb_last_reflection;\n"
    "uniform sampler2D dgb_last_reflection_frames;\n"
    "#endif\n"
    "\n"
    "layout(location = 0) out vec4 dgb_out_reflection; // radiance, confidence\n"
    "#if DGB_HISTORY\n"
    "layout(location = 1) out vec4 dgb_out_frames; // averaged, in steps of 1 / 255\n"
    "#endif\n"
    "\n"
    "// The lobe of a pixel.\n"
    "struct dgb_lobe {\n"
    "    vec3  x, n, v; // v: towards the eye\n"
    "    float alpha;   // 0: a mirror\n"
    "};\n"
    "\n"
    "dgb_lobe dgb_lobe_at(ivec2 pixel) {\n"
    "    dgb_lobe lobe;\n"
    "    lobe.x     = dgb_position(vec2(pixel) + 0.5, texelFetch(dgb_z, pixel, 0).x, dgb_glossy_camera);\n"
    "    lobe.n     = dgb_oct16_decode(texelFetch(dgb_normals, pixel, 0).xy);\n"
    "    lobe.v     = -dgb_view(lobe.x, dgb_glossy_camera);\n"
    "    lobe.alpha = dgb_ggx_alpha(dgb_roughness_at(pixel));\n"
    "    return lobe;\n"
    "}\n"
    "\n"
    "// The way of a ray, m: misses went all of it.\n"
    "float dgb_way(vec4 hit) { return hit.x > 0.0 ? hit.y : dgb_glossy_reach.y; }\n"
    "\n"
    "// A mirrored point a way off appears as far behind the surface. A microfacet turned by alpha shifts it by twice that angle.\n"
    "vec3 dgb_image_of(dgb_lobe lobe, float way) { return lobe.x - way * lobe.v; }\n"
    "\n"
    "float dgb_blur(dgb_lobe lobe, float way) {\n"
    "    return 2.0 * lobe.alpha * way * dgb_pixels_per_metre(dgb_image_of(lobe, way).z, dgb_glossy_camera);\n"
    "}\n"
    "\n"
    "const float DGB_MOST_FRAMES = 64.0; // counted\n"
    "const float DGB_MOST_WEIGHT = 4.0; // of a neighbour's ray: where lobes differ, one ray must not stand for all\n"
    "\n"
    "// Weight of a neighbour's ray; zero light if it is not to be seen from here. A miss has a direction, a hit a point, which from\n"
    "// here lies in another direction and takes up another angle.\n"
    "float dgb_reuse(dgb_lobe own, dgb_lobe other, vec4 hit, inout vec4 light) {\n"
    "    vec3  sent   = dgb_from_octahedral(hit.zw);\n"
    "    vec3  to     = hit.x > 0.0 ? other.x + hit.y * sent - own.x : sent;\n"
    "    float d2     = max(dot(to, to), 1e-30);\n"
    "    vec3  l      = to * inversesqrt(d2);\n"
    "    float here   = dgb_ggx_density(own.v, own.n, l, own.alpha) * (hit.x > 0.0 ? hit.y * hit.y / d2 : 1.0);\n"
    "    float there  = dgb_ggx_density(other.v, other.n, sent, other.alpha); // 0 of a mirror: no ray of a lobe\n"
    "    float same   = dgb_bilateral_weight(own.n, other.n, other.x - own.x, dgb_glossy_sharpness.x, dgb_glossy_sharpness.y);\n"
    "    bool  usable = there > 0.0 && other.x.z > DGB_EMPTY_Z;\n"
    "    light        = dot(l, own.n) > DGB_MIN_COSINE ? light : vec4(0.0); // below the horizon this pixel's rays miss as well\n"
    "    return usable ? same * min(here / there, DGB_MOST_WEIGHT) : 0.0;\n"
    "}\n"
    "\n"
    "struct dgb_mean {\n"
    "    vec4  weighed; // radiance times confidence, confidence\n"
    "    float way;     // m\n"
    "};\n"
    "\n"
    "// Of this pixel's ray and those of its neighbours within the radius. A mirror has its own ray alone.\n"
    "dgb_mean dgb_mean_at(ivec2 pixel, dgb_lobe own) {\n"
    "    vec4     hit    = texelFetch(dgb_reflection_hit, pixel, 0);\n"
    "    float    radius = min(dgb_blur(own, dgb_way(hit)), dgb_glossy_reach.x), total = 1.0;\n"
    "    float    angle  = 2.0 * DGB_PI / 256.0 * float(dgb_pixel_hash(pixel, dgb_glossy_size.y));\n",
    "    vec2     turn   = vec2(cos(angle), sin(angle));\n"
    "    dgb_mean mean;\n"
    "    mean.weighed = dgb_weigh(texelFetch(dgb_reflection_raw, pixel, 0));\n"
    "    mean.way     = dgb_way(hit);\n"
    "    for (int i = radius >= 0.5 ? 0 : dgb_glossy_size.x; i < dgb_glossy_size.x; ++i) {\n"
    "        vec4  tap  = dgb_glossy_taps[i];\n"
    "        vec2  at   = vec2(tap.x * turn.x - tap.y * turn.y, tap.x * turn.y + tap.y * turn.x);\n"
    "        ivec2 p    = ivec2(floor(vec2(pixel) + 0.5 + radius * tap.z * at));\n"
    "        bool  good = p != pixel && all(greaterThanEqual(p, dgb_glossy_rect.xy)) && all(lessThanEqual(p, dgb_glossy_rect.zw));\n"
    "        p          = good ? p : pixel;\n"
    "        hit        = texelFetch(dgb_reflection_hit, p, 0);\n"
    "        vec4  light  = dgb_weigh(texelFetch(dgb_reflection_raw, p, 0));\n"
    "        float weight = dgb_reuse(own, dgb_lobe_at(p), hit, light) * float(good);\n"
    "        mean.weighed += weight * light;\n"
    "        mean.way += weight * dgb_way(hit);\n"
    "        total += weight;\n"
    "    }\n"
    "    mean.weighed /= total;\n"
    "    mean.way /= total;\n"
    "    return mean;\n"
    "}\n"
    "\n"
    "#if DGB_HISTORY\n"
    "struct dgb_history {\n"
    "    vec4  weighed;\n"
    "    float frames;\n"
    "};\n"
    "\n"
    "vec4 dgb_last_reflection_at(ivec2 texel) {\n"
    "    vec4 e = texelFetch(dgb_last_reflection, texel, 0);\n"
    "    return vec4(dgb_storable(e.rgb), e.a > 0.0 ? (e.a < 1.0 ? e.a : 1.0) : 0.0);\n"
    "}\n"
    "\n"
    "dgb_history dgb_history_at(dgb_past past) {\n"
    "    vec2        low = floor(past.pixel - 0.5), part = past.pixel - 0.5 - low;\n"
    "    float       share = 0.0;\n"
    "    dgb_history h;\n"
    "    h.weighed = vec4(0.0);\n"
    "    h.frames  = 0.0;\n"
    "    for (int i = past.tolerance < 0.0 ? 4 : 0; i < 4; ++i) {\n"
    "        ivec2 corner = ivec2(i & 1, i >> 1);\n"
    "        ivec2 texel  = clamp(ivec2(low) + corner, dgb_glossy_past.rect.xy, dgb_glossy_past.rect.zw);\n"
    "        vec2  w      = mix(1.0 - part, part, vec2(corner));\n"
    "        float weight = dgb_past_layer(texel, past, dgb_glossy_past) == 0 ? w.x * w.y : 0.0;\n"
    "        share += weight;\n"
    "        h.weighed += weight * dgb_weigh(dgb_last_reflection_at(texel));\n"
    "        h.frames += weight * 255.0 * texelFetch(dgb_last_reflection_frames, texel, 0).x;\n"
    "    }\n"
    "    float whole = dgb_whole(share);\n"
    "    h.weighed *= whole;\n"
    "    h.frames *= whole;\n"
    "    return h;\n"
    "}\n"
    "\n"
    "// Pixels by which the mirrored image has slid over its surface since last frame: it moves with what is behind the surface.\n"
    "float dgb_slide(dgb_lobe lobe, float way, dgb_past past) {\n"
    "    vec4 a = dgb_glossy_past.to_last[0], b = dgb_glossy_past.to_last[1], c = dgb_glossy_past.to_last[2];\n"
    "    vec4 x = vec4(lobe.x, 1.0), image = vec4(dgb_image_of(lobe, way), 1.0);\n"
    "    vec2 surface = dgb_project(vec3(dot(a, x), dot(b, x), dot(c, x)), dgb_glossy_past.last);\n"
    "    vec2 behind  = dgb_project(vec3(dot(a, image), dot(b, image), dot(c, image)), dgb_glossy_past.last);\n"
    "    return length(behind - surface);\n"
    "}\n"
    "\n"
    "// History that has slid farther than the lobe blurs is of other things: frames count less the farther. A mirror has none.\n"
    "dgb_history dgb_usable_history(ivec2 pixel, dgb_lobe lobe, float way) {\n"
    "    vec2        at   = vec2(pixel) + 0.5;\n"
    "    dgb_past    past = dgb_past_of(at, lobe.x, lobe.n, dgb_velocity_at(0, pixel), dgb_glossy_past);\n"
    "    dgb_history h    = dgb_history_at(past);\n"
    "    float       kept = dgb_blur(lobe, way) - dgb_slide(lobe, way, past);\n"
    "    h.frames *= kept > 0.0 ? min(kept, 1.0) : 0.0;\n"
    "    return h;\n"
    "}\n"
    "#endif\n"
    "\n"
    "void main() {\n"
    "    ivec2    pixel = ivec2(gl_FragCoord.xy);\n"
    "    vec4     raw   = texelFetch(dgb_reflection_raw, pixel, 0);\n"
    "    dgb_lobe own   = dgb_lobe_at(pixel);\n"
    "    bool     rough = own.alpha > 0.0 && own.x.z > DGB_EMPTY_Z;\n"
    "    dgb_mean mean  = dgb_mean_at(pixel, own);\n"
    "#if DGB_HISTORY\n"
    "    dgb_history h  = dgb_usable_history(pixel, own, mean.way);\n"
    "    float weight   = min(h.frames / (h.frames + 1.0), dgb_glossy_reach.z);\n"
    "    mean.weighed   = mix(mean.weighed, h.weighed, weight);\n"
    "    dgb_out_frames = vec4(rough ? min(h.frames + 1.0, DGB_MOST_FRAMES) / 255.0 : 0.0);\n"
    "#endif\n"
    "    vec4 filtered = dgb_unweigh(mean.weighed);\n"
    "    filtered.rgb  = dgb_storable(filtered.rgb);\n"
    "#if DGB_HISTORY\n",
    "    filtered = dgb_averaged(filtered, weight, pixel, dgb_glossy_size.y);\n"
    "#endif\n"
    "    dgb_out_reflection = rough ? filtered : raw;\n"
    "}\n",
    0
};

static const char* const dgbgli_glsl_composite[] = { /* 70_composite.glsl */
    "#line 700001\n"
    "// Composite: the lines that an engine needs. A Lambert surface sends emission + direct + albedo / pi * dgb_fallback(...), a\n"
    "// mirror its reflectance times dgb_mirror(...), a rough surface its environment BRDF (split sum) times dgb_mirror(...).\n"
    "\n"
    "// Share of the hemisphere that the irradiance comes from. Around a flat surface half of the taps look at its own plane and\n"
    "// behind it: half a confidence is all that there is to find. Against ray-traced light, twice the confidence is nearer to the\n"
    "// truth than once in every scene of the sweep (`make trade`).\n"
    "float dgb_covered(float confidence) { return min(2.0 * confidence, 1.0); }\n"
    "\n"
    "// Irradiance, W/m2. probe: what comes from where nothing is known: a light probe's irradiance for the normal, or a constant.\n"
    "// visibility: of DGB_AO; 1 without. irradiance: of DGB_IRRADIANCE; vec4(0) without.\n"
    "vec3 dgb_fallback(vec3 probe, float visibility, vec4 irradiance) {\n"
    "    return mix(visibility * probe, irradiance.rgb, dgb_covered(irradiance.a));\n"
    "}\n"
    "\n"
    "// Direction, world space, in which a point is open; bent: of DGB_BENT, normal: of the surface, for where nothing is open.\n"
    "vec3 dgb_bent_direction(vec4 bent, vec3 normal) {\n"
    "    float d2 = dot(bent.xyz, bent.xyz);\n"
    "    return d2 > 1e-6 ? bent.xyz * inversesqrt(d2) : normal;\n"
    "}\n"
    "\n"
    "// Cosine of the half angle of the cone that is as open. Twin of the C function of the same name.\n"
    "float dgb_bent_cosine(vec4 bent) {\n"
    "    float k      = max(1.5 * length(bent.xyz) / max(bent.a, 1e-6) - 1.0, 0.0);\n"
    "    float cosine = 0.5 * (k + sqrt(k * k + 4.0 * k));\n"
    "    return bent.a > 0.0 && cosine < 1.0 ? cosine : 1.0;\n"
    "}\n"
    "\n"
    "// Irradiance, W/m2, of the open directions, from a cube map of radiance whose MIP level m is blurred over a cone of 2^m texels\n"
    "// of its level 0, `texels` along a face's side. Never more than pi times its brightest texel times the open share.\n"
    "vec3 dgb_probe_visible(samplerCube radiance, float texels, vec4 bent, vec3 normal) {\n"
    "    float cosine = dgb_bent_cosine(bent), across = sqrt(max(1.0 - cosine * cosine, 0.0)) * texels;\n"
    "    return 3.14159265 * bent.a * textureLod(radiance, dgb_bent_direction(bent, normal), log2(max(across, 1.0))).rgb;\n"
    "}\n"
    "\n"
    "// Radiance, W/(m2 sr). environment: of your environment map in the mirrored direction, prefiltered for the roughness if glossy.\n"
    "// reflection: of DGB_REFLECTION.\n"
    "vec3 dgb_mirror(vec3 environment, vec4 reflection) { return mix(environment, reflection.rgb, reflection.a); }\n",
    0
};

static const char* const dgbgli_glsl_view[] = { /* 75_view.glsl */
    "#line 750001\n"
    "// What dgbgl_draw_view shows: a texture of the library's as colours, scaled to a rectangle of any framebuffer.\n"
    "layout(std140) uniform dgb_view_block {\n"
    "    dgb_camera dgb_view_camera;\n"
    "    vec4       dgb_view_rectangle; // lower left corner; pixels of the image a pixel of the rectangle: x, y\n"
    "    vec4       dgb_view_scale;     // factor of light; m where depth has fallen to an eighth; weight of history\n"
    "    ivec4      dgb_view_choice;    // view, layer, its divisor, guard band of its texture\n"
    "    ivec4      dgb_view_has;       // x: packed z\n"
    "};\n"
    "\n"
    "uniform sampler2DArray dgb_view_depth;\n"
    "uniform sampler2DArray dgb_view_layer;\n"
    "uniform sampler2D      dgb_view_image;\n"
    "uniform sampler2D      dgb_view_z;\n"
    "\n"
    "out vec4 dgb_view_color;\n"
    "\n"
    "vec3 dgb_srgb(vec3 x) {\n"
    "    vec3 low = 12.92 * x, high = 1.055 * pow(max(x, 0.0), vec3(1.0 / 2.4)) - 0.055;\n"
    "    return vec3(x.r < 0.0031308 ? low.r : high.r, x.g < 0.0031308 ? low.g : high.g, x.b < 0.0031308 ? low.b : high.b);\n"
    "}\n"
    "\n"
    "// Narkowicz's fit of the ACES filmic curve: 1 becomes 0.8, highlights roll off towards 1.\n"
    "vec3 dgb_filmic(vec3 light) {\n"
    "    vec3 x = min(dgb_view_scale.x * light, 1e4);\n"
    "    return dgb_srgb(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14));\n"
    "}\n"
    "\n"
    "// 1 at the eye, an eighth at dgb_view_scale.y.\n"
    "float dgb_nearness(float depth) { return exp2(3.0 * dgb_linear_z(depth, dgb_view_camera) / dgb_view_scale.y); }\n"
    "\n"
    "vec3 dgb_velocity_color(vec2 velocity) { return vec3(clamp(0.5 + velocity / 32.0, 0.0, 1.0), 0.5); }\n"
    "\n"
    "// Over the first layer, dimmed: what this one keeps, and what was too near to the first to be kept.\n"
    "vec3 dgb_validity_color(ivec2 pixel, bool empty) {\n"
    "    float first = texelFetch(dgb_view_depth, ivec3(pixel, 0), 0).r;\n"
    "    vec3  dim   = first == dgb_view_camera.footprint.w ? vec3(0.0) : vec3(0.1 + 0.3 * dgb_nearness(first));\n"
    "    bool  kept  = true;\n"
    "    if (dgb_view_has.x != 0 && dgb_view_choice.y < 2)\n"
    "        kept = texelFetch(dgb_view_z, pixel, 0)[dgb_view_choice.y] > DGB_EMPTY_Z;\n"
    "    return empty ? dim : dim + (kept ? vec3(0.0, 0.5, 0.5) : vec3(0.6, 0.0, 0.0));\n"
    "}\n"
    "\n"
    "vec3 dgb_layer_color(ivec2 pixel) {\n"
    "    ivec3 texel = ivec3(pixel / dgb_view_choice.z, dgb_view_choice.y);\n"
    "    float depth = texelFetch(dgb_view_depth, texel, 0).r;\n"
    "    vec4  value = texelFetch(dgb_view_layer, texel, 0);\n"
    "    bool  empty = depth == dgb_view_camera.footprint.w;\n"
    "    int   view  = dgb_view_choice.x;\n"
    "    if (view == DGB_VIEW_VALIDITY) return dgb_validity_color(pixel, empty);\n"
    "    if (view == DGB_VIEW_DEPTH) return empty ? vec3(0.05, 0.08, 0.3) : vec3(dgb_nearness(depth));\n"
    "    if (empty) return vec3(0.0);\n"
    "    if (view == DGB_VIEW_NORMAL) return 0.5 + 0.5 * dgb_oct16_decode(value.rg);\n"
    "    if (view == DGB_VIEW_ALBEDO) return dgb_srgb(value.rgb);\n"
    "    if (view == DGB_VIEW_RADIANCE) return dgb_filmic(value.rgb);\n"
    "    return dgb_velocity_color(value.rg);\n"
    "}\n"
    "\n"
    "vec3 dgb_history_color(vec4 value) {\n"
    "    float frames = max(value.g, value.b); // averaged of visibility, of light\n"
    "    float share  = min(frames / (frames + 1.0), dgb_view_scale.z) / max(dgb_view_scale.z, 1e-3);\n"
    "    return frames == 0.0 ? vec3(0.0) : mix(vec3(0.8, 0.1, 0.0), vec3(1.0), share * share);\n"
    "}\n"
    "\n"
    "vec3 dgb_image_color(ivec2 pixel) {\n"
    "    vec4 value = texelFetch(dgb_view_image, pixel, 0);\n"
    "    int  view  = dgb_view_choice.x;\n"
    "    if (view == DGB_VIEW_AO) return value.rrr;\n"
    "    if (view == DGB_VIEW_IRRADIANCE) return dgb_filmic(value.rgb / DGB_PI);\n"
    "    if (view == DGB_VIEW_CONFIDENCE) return value.aaa;\n"
    "    if (view == DGB_VIEW_HISTORY) return dgb_history_color(value);\n"
    "    if (view == DGB_VIEW_REFLECTION) return dgb_filmic(value.rgb * value.a);\n"
    "    if (view == DGB_VIEW_REFLECTION_LAYER)\n"
    "        return value.r == 0.0 ? vec3(0.0) : value.r < 1.5 ? vec3(0.1, 0.3, 0.9) : vec3(1.0, 0.5, 0.0);\n"
    "    return dgb_filmic(value.rgb);\n"
    "}\n"
    "\n"
    "void main() {\n"
    "    ivec2 pixel    = ivec2((gl_FragCoord.xy - dgb_view_rectangle.xy) * dgb_view_rectangle.zw) + dgb_view_choice.w;\n"
    "    bool  of_layer = dgb_view_choice.x <= DGB_VIEW_VALIDITY;\n",
    "    dgb_view_color = vec4(of_layer ? dgb_layer_color(pixel) : dgb_image_color(pixel), 1.0);\n"
    "}\n",
    0
};

/* clang-format on */
/* << embedded GLSL */

/* >> GL values */

enum {
    DGBGLI_ALL_BARRIER_BITS = -1,
    DGBGLI_FALSE = 0,
    DGBGLI_NONE = 0,
    DGBGLI_TRUE = 1,
    DGBGLI_TRIANGLES = 0x0004,
    DGBGLI_LESS = 0x0201,
    DGBGLI_GREATER = 0x0204,
    DGBGLI_ALWAYS = 0x0207,
    DGBGLI_FRONT_AND_BACK = 0x0408,
    DGBGLI_INVALID_ENUM = 0x0500,
    DGBGLI_OUT_OF_MEMORY = 0x0505,
    DGBGLI_CONTEXT_LOST = 0x0507,
    DGBGLI_POLYGON_MODE = 0x0B40,
    DGBGLI_POLYGON_SMOOTH = 0x0B41,
    DGBGLI_CULL_FACE = 0x0B44,
    DGBGLI_DEPTH_RANGE = 0x0B70,
    DGBGLI_DEPTH_TEST = 0x0B71,
    DGBGLI_DEPTH_WRITEMASK = 0x0B72,
    DGBGLI_DEPTH_FUNC = 0x0B74,
    DGBGLI_STENCIL_TEST = 0x0B90,
    DGBGLI_VIEWPORT = 0x0BA2,
    DGBGLI_DITHER = 0x0BD0,
    DGBGLI_BLEND = 0x0BE2,
    DGBGLI_COLOR_LOGIC_OP = 0x0BF2,
    DGBGLI_SCISSOR_TEST = 0x0C11,
    DGBGLI_COLOR_WRITEMASK = 0x0C23,
    DGBGLI_UNPACK_SWAP_BYTES = 0x0CF0,
    DGBGLI_UNPACK_ROW_LENGTH = 0x0CF2,
    DGBGLI_UNPACK_SKIP_ROWS = 0x0CF3,
    DGBGLI_UNPACK_SKIP_PIXELS = 0x0CF4,
    DGBGLI_UNPACK_ALIGNMENT = 0x0CF5,
    DGBGLI_MAX_TEXTURE_SIZE = 0x0D33,
    DGBGLI_TEXTURE_2D = 0x0DE1,
    DGBGLI_UNSIGNED_BYTE = 0x1401,
    DGBGLI_UNSIGNED_INT = 0x1405,
    DGBGLI_FLOAT = 0x1406,
    DGBGLI_TEXTURE = 0x1702,
    DGBGLI_COLOR = 0x1800,
    DGBGLI_DEPTH = 0x1801,
    DGBGLI_DEPTH_COMPONENT = 0x1902,
    DGBGLI_RED = 0x1903,
    DGBGLI_RGB = 0x1907,
    DGBGLI_RGBA = 0x1908,
    DGBGLI_FILL = 0x1B02,
    DGBGLI_RENDERER = 0x1F01,
    DGBGLI_VERSION = 0x1F02,
    DGBGLI_EXTENSIONS = 0x1F03,
    DGBGLI_NEAREST = 0x2600,
    DGBGLI_TEXTURE_MAG_FILTER = 0x2800,
    DGBGLI_TEXTURE_MIN_FILTER = 0x2801,
    DGBGLI_TEXTURE_WRAP_S = 0x2802,
    DGBGLI_TEXTURE_WRAP_T = 0x2803,
    DGBGLI_POLYGON_OFFSET_POINT = 0x2A01,
    DGBGLI_POLYGON_OFFSET_LINE = 0x2A02,
    DGBGLI_CLIP_DISTANCE0 = 0x3000,
    DGBGLI_POLYGON_OFFSET_FILL = 0x8037,
    DGBGLI_RGBA8 = 0x8058,
    DGBGLI_TEXTURE_BINDING_2D = 0x8069,
    DGBGLI_UNPACK_SKIP_IMAGES = 0x806D,
    DGBGLI_UNPACK_IMAGE_HEIGHT = 0x806E,
    DGBGLI_VERTEX_ARRAY = 0x8074,
    DGBGLI_MULTISAMPLE = 0x809D,
    DGBGLI_SAMPLE_ALPHA_TO_COVERAGE = 0x809E,
    DGBGLI_SAMPLE_COVERAGE = 0x80A0,
    DGBGLI_CLAMP_TO_EDGE = 0x812F,
    DGBGLI_TEXTURE_BASE_LEVEL = 0x813C,
    DGBGLI_TEXTURE_MAX_LEVEL = 0x813D,
    DGBGLI_DEPTH_COMPONENT16 = 0x81A5,
    DGBGLI_DEPTH_COMPONENT24 = 0x81A6,
    DGBGLI_MAJOR_VERSION = 0x821B,
    DGBGLI_MINOR_VERSION = 0x821C,
    DGBGLI_NUM_EXTENSIONS = 0x821D,
    DGBGLI_RG = 0x8227,
    DGBGLI_RG_INTEGER = 0x8228,
    DGBGLI_R8 = 0x8229,
    DGBGLI_RG8 = 0x822B,
    DGBGLI_R32F = 0x822E,
    DGBGLI_RG16F = 0x822F,
    DGBGLI_RG32F = 0x8230,
    DGBGLI_R32UI = 0x8236,
    DGBGLI_RG32UI = 0x823C,
    DGBGLI_DEBUG_SOURCE_APPLICATION = 0x824A,
    DGBGLI_BUFFER = 0x82E0,
    DGBGLI_PROGRAM = 0x82E2,
    DGBGLI_SAMPLER = 0x82E6,
    DGBGLI_TEXTURE0 = 0x84C0,
    DGBGLI_ACTIVE_TEXTURE = 0x84E0,
    DGBGLI_VERTEX_ARRAY_BINDING = 0x85B5,
    DGBGLI_DEPTH_CLAMP = 0x864F,
    DGBGLI_RGBA32F = 0x8814,
    DGBGLI_RGBA16F = 0x881A,
    DGBGLI_TEXTURE_COMPARE_MODE = 0x884C,
    DGBGLI_QUERY_RESULT = 0x8866,
    DGBGLI_QUERY_RESULT_AVAILABLE = 0x8867,
    DGBGLI_READ_WRITE = 0x88BA,
    DGBGLI_STREAM_DRAW = 0x88E0,
    DGBGLI_PIXEL_UNPACK_BUFFER = 0x88EC,
    DGBGLI_PIXEL_UNPACK_BUFFER_BINDING = 0x88EF,
    DGBGLI_MAX_ARRAY_TEXTURE_LAYERS = 0x88FF,
    DGBGLI_SAMPLER_BINDING = 0x8919,
    DGBGLI_UNIFORM_BUFFER = 0x8A11,
    DGBGLI_UNIFORM_BUFFER_BINDING = 0x8A28,
    DGBGLI_UNIFORM_BUFFER_START = 0x8A29,
    DGBGLI_UNIFORM_BUFFER_SIZE = 0x8A2A,
    DGBGLI_MAX_UNIFORM_BUFFER_BINDINGS = 0x8A2F,
    DGBGLI_FRAGMENT_SHADER = 0x8B30,
    DGBGLI_VERTEX_SHADER = 0x8B31,
    DGBGLI_MAX_COMBINED_TEXTURE_IMAGE_UNITS = 0x8B4D,
    DGBGLI_COMPILE_STATUS = 0x8B81,
    DGBGLI_LINK_STATUS = 0x8B82,
    DGBGLI_CURRENT_PROGRAM = 0x8B8D,
    DGBGLI_TEXTURE_2D_ARRAY = 0x8C1A,
    DGBGLI_TEXTURE_BINDING_2D_ARRAY = 0x8C1D,
    DGBGLI_R11F_G11F_B10F = 0x8C3A,
    DGBGLI_RASTERIZER_DISCARD = 0x8C89,
    DGBGLI_LOWER_LEFT = 0x8CA1,
    DGBGLI_DRAW_FRAMEBUFFER_BINDING = 0x8CA6,
    DGBGLI_READ_FRAMEBUFFER = 0x8CA8,
    DGBGLI_DRAW_FRAMEBUFFER = 0x8CA9,
    DGBGLI_READ_FRAMEBUFFER_BINDING = 0x8CAA,
    DGBGLI_DEPTH_COMPONENT32F = 0x8CAC,
    DGBGLI_FRAMEBUFFER_COMPLETE = 0x8CD5,
    DGBGLI_COLOR_ATTACHMENT0 = 0x8CE0,
    DGBGLI_DEPTH_ATTACHMENT = 0x8D00,
    DGBGLI_FRAMEBUFFER = 0x8D40,
    DGBGLI_PRIMITIVE_RESTART_FIXED_INDEX = 0x8D69,
    DGBGLI_RGBA32UI = 0x8D70,
    DGBGLI_RED_INTEGER = 0x8D94,
    DGBGLI_RGBA_INTEGER = 0x8D99,
    DGBGLI_FRAMEBUFFER_SRGB = 0x8DB9,
    DGBGLI_MAX_GEOMETRY_OUTPUT_VERTICES = 0x8DE0,
    DGBGLI_TIMESTAMP = 0x8E28,
    DGBGLI_SAMPLE_MASK = 0x8E51,
    DGBGLI_IMAGE_BINDING_NAME = 0x8F3A,
    DGBGLI_IMAGE_BINDING_LEVEL = 0x8F3B,
    DGBGLI_IMAGE_BINDING_LAYERED = 0x8F3C,
    DGBGLI_IMAGE_BINDING_LAYER = 0x8F3D,
    DGBGLI_IMAGE_BINDING_ACCESS = 0x8F3E,
    DGBGLI_PRIMITIVE_RESTART = 0x8F9D,
    DGBGLI_IMAGE_BINDING_FORMAT = 0x906E,
    DGBGLI_QUERY_BUFFER = 0x9192,
    DGBGLI_QUERY_BUFFER_BINDING = 0x9193,
    DGBGLI_CLIP_ORIGIN = 0x935C,
    DGBGLI_CLIP_DEPTH_MODE = 0x935D,
    DGBGLI_NEGATIVE_ONE_TO_ONE = 0x935E,
    DGBGLI_ZERO_TO_ONE = 0x935F
};

/* One row a format: internal format, format and type of an upload. */
static const struct {
    unsigned int internal, format, type;
} dgbgli_formats[DGB_FORMAT_COUNT] = {{0, 0, 0},
                                      {DGBGLI_R8, DGBGLI_RED, DGBGLI_UNSIGNED_BYTE},
                                      {DGBGLI_RG8, DGBGLI_RG, DGBGLI_UNSIGNED_BYTE},
                                      {DGBGLI_RGBA8, DGBGLI_RGBA, DGBGLI_UNSIGNED_BYTE},
                                      {DGBGLI_R11F_G11F_B10F, DGBGLI_RGB, DGBGLI_FLOAT},
                                      {DGBGLI_RG16F, DGBGLI_RG, DGBGLI_FLOAT},
                                      {DGBGLI_RGBA16F, DGBGLI_RGBA, DGBGLI_FLOAT},
                                      {DGBGLI_R32F, DGBGLI_RED, DGBGLI_FLOAT},
                                      {DGBGLI_RG32F, DGBGLI_RG, DGBGLI_FLOAT},
                                      {DGBGLI_RGBA32F, DGBGLI_RGBA, DGBGLI_FLOAT},
                                      {DGBGLI_R32UI, DGBGLI_RED_INTEGER, DGBGLI_UNSIGNED_INT},
                                      {DGBGLI_RG32UI, DGBGLI_RG_INTEGER, DGBGLI_UNSIGNED_INT},
                                      {DGBGLI_RGBA32UI, DGBGLI_RGBA_INTEGER, DGBGLI_UNSIGNED_INT},
                                      {DGBGLI_DEPTH_COMPONENT16, DGBGLI_DEPTH_COMPONENT, DGBGLI_UNSIGNED_INT},
                                      {DGBGLI_DEPTH_COMPONENT24, DGBGLI_DEPTH_COMPONENT, DGBGLI_UNSIGNED_INT},
                                      {DGBGLI_DEPTH_COMPONENT32F, DGBGLI_DEPTH_COMPONENT, DGBGLI_FLOAT}};

/* >> text: a bounded string that counts what it would have held */

typedef struct dgbgli_text {
    char* out;
    size_t capacity, length;
} dgbgli_text;

static dgbgli_text dgbgli_text_on(char* out, size_t capacity) {
    dgbgli_text t;
    t.out = out;
    t.capacity = out ? capacity : 0;
    t.length = 0;
    if (t.capacity) out[0] = 0;
    return t;
}

static void dgbgli_put_part(dgbgli_text* t, const char* s, size_t n) {
    const size_t room = t->capacity > t->length + 1 ? t->capacity - t->length - 1 : 0;
    const size_t used = n < room ? n : room;
    if (used) memcpy(t->out + t->length, s, used);
    if (t->capacity && (used || room)) t->out[t->length + used] = 0;
    t->length += n;
}

static void dgbgli_put(dgbgli_text* t, const char* s) { dgbgli_put_part(t, s, strlen(s)); }

static void dgbgli_put_int(dgbgli_text* t, int value) {
    char digits[12];
    int at = 11;
    unsigned rest = value < 0 ? 0u - (unsigned)value : (unsigned)value;
    digits[at] = 0;
    do digits[--at] = (char)('0' + rest % 10u);
    while ((rest /= 10u) != 0u);
    if (value < 0) digits[--at] = '-';
    dgbgli_put(t, digits + at);
}

static void dgbgli_put_define(dgbgli_text* t, const char* name, int value) {
    dgbgli_put(t, "#define ");
    dgbgli_put(t, name);
    dgbgli_put(t, " ");
    dgbgli_put_int(t, value);
    dgbgli_put(t, "\n");
}

static void dgbgli_put_chunks(dgbgli_text* t, const char* const* chunks) {
    while (*chunks) dgbgli_put(t, *chunks++);
}

static void dgbgli_put_version(dgbgli_text* t, int version, bool es) {
    dgbgli_put(t, "#version ");
    dgbgli_put_int(t, es ? 300 : version >= 450 ? 450 : version >= 430 ? 430 : version >= 410 ? 410 : 330);
    dgbgli_put(t, es ? " es\n" : " core\n");
}

static void dgbgli_put_precision(dgbgli_text* t, bool es) {
    if (es)
        dgbgli_put(t,
                   "precision highp float;\nprecision highp int;\nprecision highp sampler2D;\n"
                   "precision highp sampler2DArray;\nprecision highp usampler2D;\nprecision highp usampler2DArray;\n");
}

static void dgbgli_message(const dgbgl_backend* gl, const char* what, const char* detail) {
    char buffer[2560];
    dgbgli_text t = dgbgli_text_on(buffer, sizeof buffer);
    if (!gl->desc.message) return;
    dgbgli_put(&t, what);
    dgbgli_put(&t, ": ");
    dgbgli_put(&t, detail);
    gl->desc.message(gl->desc.message_user, buffer);
}

/* >> errors */

static const char* dgbgli_error_name(unsigned int error) {
    static const char* const names[] = {"GL_INVALID_ENUM",
                                        "GL_INVALID_VALUE",
                                        "GL_INVALID_OPERATION",
                                        "GL_STACK_OVERFLOW",
                                        "GL_STACK_UNDERFLOW",
                                        "GL_OUT_OF_MEMORY",
                                        "GL_INVALID_FRAMEBUFFER_OPERATION",
                                        "GL_CONTEXT_LOST"};
    const unsigned int i = error - DGBGLI_INVALID_ENUM;
    return i < sizeof names / sizeof names[0] ? names[i] : "an unknown GL error";
}

/* Errors that were pending are the engine's: they must not be blamed on what follows. Bounded: what a driver reports
   for ever is no error of one call, and a lost context may do so. */
static void dgbgli_drain_errors(const dgbgl_backend* b, const char* where) {
    unsigned int error = 0;
    int i;
    for (i = 0; i < 16 && error != DGBGLI_CONTEXT_LOST && (error = b->gl.GetError()) != 0; ++i)
        dgbgli_message(b, where, dgbgli_error_name(error));
}

/* What the library's own calls came to since the last look. */
static dgb_result dgbgli_check(const dgbgl_backend* b) {
    const unsigned int error = b->gl.GetError();
    return !error ? DGB_OK : error == DGBGLI_OUT_OF_MEMORY ? DGB_OUT_OF_MEMORY : DGB_DEVICE;
}

static void dgbgli_note_errors(dgbgl_backend* b) {
    if (b->drawing == DGB_OK) b->drawing = dgbgli_check(b);
}

/* Where the driver gave no name: its error, and if it has none, that it gave none. */
static dgb_result dgbgli_no_object(const dgbgl_backend* b) {
    const dgb_result result = dgbgli_check(b);
    return result == DGB_OK ? DGB_DEVICE : result;
}

#define DGBGLI_PENDING "pending before the call"

/* >> state: what a pass may change is saved at begin and put back at end */

/* Capabilities that every pass wants off (the depth test apart). Those that the dialect lacks are left out. Blend and
   scissor are kept for each buffer and viewport. */
static const struct {
    unsigned int name;
    int since;    /* desktop version */
    int since_es; /* 0: not in ES */
} dgbgli_toggles[DGBGL_TOGGLE_COUNT] = {{DGBGLI_DEPTH_TEST, 330, 300},
                                        {DGBGLI_STENCIL_TEST, 330, 300},
                                        {DGBGLI_CULL_FACE, 330, 300},
                                        {DGBGLI_DITHER, 330, 300},
                                        {DGBGLI_POLYGON_OFFSET_FILL, 330, 300},
                                        {DGBGLI_SAMPLE_ALPHA_TO_COVERAGE, 330, 300},
                                        {DGBGLI_SAMPLE_COVERAGE, 330, 300},
                                        {DGBGLI_RASTERIZER_DISCARD, 330, 300},
                                        {DGBGLI_PRIMITIVE_RESTART_FIXED_INDEX, 430, 300},
                                        {DGBGLI_SAMPLE_MASK, 330, 310},
                                        {DGBGLI_COLOR_LOGIC_OP, 330, 0},
                                        {DGBGLI_MULTISAMPLE, 330, 0},
                                        {DGBGLI_DEPTH_CLAMP, 330, 0},
                                        {DGBGLI_PRIMITIVE_RESTART, 330, 0},
                                        {DGBGLI_FRAMEBUFFER_SRGB, 330, 0},
                                        {DGBGLI_CLIP_DISTANCE0, 330, 0},
                                        {DGBGLI_CLIP_DISTANCE0 + 1, 330, 0},
                                        {DGBGLI_CLIP_DISTANCE0 + 2, 330, 0},
                                        {DGBGLI_CLIP_DISTANCE0 + 3, 330, 0},
                                        {DGBGLI_CLIP_DISTANCE0 + 4, 330, 0},
                                        {DGBGLI_CLIP_DISTANCE0 + 5, 330, 0},
                                        {DGBGLI_CLIP_DISTANCE0 + 6, 330, 0},
                                        {DGBGLI_CLIP_DISTANCE0 + 7, 330, 0},
                                        {DGBGLI_POLYGON_SMOOTH, 330, 0},
                                        {DGBGLI_POLYGON_OFFSET_POINT, 330, 0}, /* these two move the last bits of */
                                        {DGBGLI_POLYGON_OFFSET_LINE, 330, 0}}; /* filled triangles in llvmpipe */

static bool dgbgli_has_toggle(const dgbgl_backend* b, int i) {
    const int since = b->es ? dgbgli_toggles[i].since_es : dgbgli_toggles[i].since;
    return since != 0 && b->version >= since;
}

/* How GL reads pixels. OpenGL ES swaps no bytes. */
static const unsigned int dgbgli_unpack[DGBGL_UNPACK_COUNT] = {
    DGBGLI_UNPACK_ROW_LENGTH,   DGBGLI_UNPACK_SKIP_ROWS,   DGBGLI_UNPACK_SKIP_PIXELS, DGBGLI_UNPACK_ALIGNMENT,
    DGBGLI_UNPACK_IMAGE_HEIGHT, DGBGLI_UNPACK_SKIP_IMAGES, DGBGLI_UNPACK_SWAP_BYTES};

static int dgbgli_unpack_count(const dgbgl_backend* b) { return b->es ? DGBGL_UNPACK_COUNT - 1 : DGBGL_UNPACK_COUNT; }

static int dgbgli_get(const dgbgl_backend* b, unsigned int name) {
    int value[4] = {0, 0, 0, 0};
    b->gl.GetIntegerv(name, value);
    return value[0];
}

static void dgbgli_enable(const dgbgl_backend* b, unsigned int name, bool on) {
    if (on)
        b->gl.Enable(name);
    else
        b->gl.Disable(name);
}

static int dgbgli_viewport_count(const dgbgl_backend* b) { return b->indexed_viewports ? DGBGL_MAX_VIEWPORTS : 1; }

static int dgbgli_buffer_count(const dgbgl_backend* b) { return b->indexed_buffers ? DGBGL_MAX_DRAW_BUFFERS : 1; }

/* Units that are saved: those of the full-screen passes, then the oracle's. */
static int dgbgli_saved_unit(const dgbgl_backend* b, int i) { return i < DGBGL_MAX_UNITS ? i : b->desc.oracle_unit; }

static void dgbgli_save_raster(dgbgl_backend* b, dgbgl_state* s) {
    int i;
    for (i = 0; i < dgbgli_viewport_count(b); ++i) {
        if (b->indexed_viewports) {
            b->gl.GetFloati_v(DGBGLI_VIEWPORT, (unsigned)i, s->viewports[i]);
            b->gl.GetDoublei_v(DGBGLI_DEPTH_RANGE, (unsigned)i, s->depth_ranges[i]);
            s->scissor[i] = b->gl.IsEnabledi(DGBGLI_SCISSOR_TEST, (unsigned)i);
        } else {
            float range[2];
            b->gl.GetFloatv(DGBGLI_VIEWPORT, s->viewports[0]);
            b->gl.GetFloatv(DGBGLI_DEPTH_RANGE, range);
            s->depth_ranges[0][0] = (double)range[0];
            s->depth_ranges[0][1] = (double)range[1];
            s->scissor[0] = b->gl.IsEnabled(DGBGLI_SCISSOR_TEST);
        }
    }
    for (i = 0; i < dgbgli_buffer_count(b); ++i) {
        if (b->indexed_buffers) {
            s->blend[i] = b->gl.IsEnabledi(DGBGLI_BLEND, (unsigned)i);
            b->gl.GetBooleani_v(DGBGLI_COLOR_WRITEMASK, (unsigned)i, s->color_mask[i]);
        } else {
            int mask[4], channel;
            b->gl.GetIntegerv(DGBGLI_COLOR_WRITEMASK, mask);
            for (channel = 0; channel < 4; ++channel) s->color_mask[0][channel] = (unsigned char)mask[channel];
            s->blend[0] = b->gl.IsEnabled(DGBGLI_BLEND);
        }
    }
    for (i = 0; i < DGBGL_TOGGLE_COUNT; ++i)
        if (dgbgli_has_toggle(b, i)) s->toggles[i] = b->gl.IsEnabled(dgbgli_toggles[i].name);
    s->depth_mask = dgbgli_get(b, DGBGLI_DEPTH_WRITEMASK);
    s->depth_func = dgbgli_get(b, DGBGLI_DEPTH_FUNC);
    if (b->gl.PolygonMode) b->gl.GetIntegerv(DGBGLI_POLYGON_MODE, s->polygon_mode);
    if (b->gl.ClipControl) {
        s->clip_origin = dgbgli_get(b, DGBGLI_CLIP_ORIGIN);
        s->clip_depth = dgbgli_get(b, DGBGLI_CLIP_DEPTH_MODE);
    }
}

/* Properties of an image binding, in the order of dgbgl_state.images. */
static const unsigned int dgbgli_image_properties[6] = {DGBGLI_IMAGE_BINDING_NAME,    DGBGLI_IMAGE_BINDING_LEVEL,
                                                        DGBGLI_IMAGE_BINDING_LAYERED, DGBGLI_IMAGE_BINDING_LAYER,
                                                        DGBGLI_IMAGE_BINDING_ACCESS,  DGBGLI_IMAGE_BINDING_FORMAT};

static void dgbgli_save_images(const dgbgl_backend* b, dgbgl_state* s) {
    int unit, i;
    for (unit = 0; b->images && unit < DGBGL_MAX_IMAGES; ++unit)
        for (i = 0; i < 6; ++i) b->gl.GetIntegeri_v(dgbgli_image_properties[i], (unsigned)unit, &s->images[unit][i]);
}

static void dgbgli_restore_images(const dgbgl_backend* b, const dgbgl_state* s) {
    int unit;
    for (unit = 0; b->images && unit < DGBGL_MAX_IMAGES; ++unit) {
        const int* image = s->images[unit];
        b->gl.BindImageTexture((unsigned)unit, (unsigned)image[0], image[1], (unsigned char)image[2], image[3],
                               (unsigned)image[4], (unsigned)image[5]);
    }
}

static void dgbgli_save_bindings(dgbgl_backend* b, dgbgl_state* s) {
    const unsigned int binding = (unsigned)b->desc.uniform_binding;
    int i;
    s->draw_framebuffer = dgbgli_get(b, DGBGLI_DRAW_FRAMEBUFFER_BINDING);
    s->read_framebuffer = dgbgli_get(b, DGBGLI_READ_FRAMEBUFFER_BINDING);
    s->program = dgbgli_get(b, DGBGLI_CURRENT_PROGRAM);
    s->vertex_array = dgbgli_get(b, DGBGLI_VERTEX_ARRAY_BINDING);
    s->uniform_buffer = dgbgli_get(b, DGBGLI_UNIFORM_BUFFER_BINDING);
    b->gl.GetIntegeri_v(DGBGLI_UNIFORM_BUFFER_BINDING, binding, &s->uniform_binding);
    b->gl.GetInteger64i_v(DGBGLI_UNIFORM_BUFFER_START, binding, &s->uniform_start);
    b->gl.GetInteger64i_v(DGBGLI_UNIFORM_BUFFER_SIZE, binding, &s->uniform_size);
    s->active_texture = dgbgli_get(b, DGBGLI_ACTIVE_TEXTURE);
    for (i = 0; i <= DGBGL_MAX_UNITS; ++i) {
        b->gl.ActiveTexture((unsigned)(DGBGLI_TEXTURE0 + dgbgli_saved_unit(b, i)));
        s->textures_2d[i] = dgbgli_get(b, DGBGLI_TEXTURE_BINDING_2D);
        s->textures_array[i] = dgbgli_get(b, DGBGLI_TEXTURE_BINDING_2D_ARRAY);
        s->samplers[i] = dgbgli_get(b, DGBGLI_SAMPLER_BINDING);
    }
    dgbgli_save_images(b, s);
    if (b->query_buffers) s->query_buffer = dgbgli_get(b, DGBGLI_QUERY_BUFFER_BINDING);
    s->unpack_buffer = dgbgli_get(b, DGBGLI_PIXEL_UNPACK_BUFFER_BINDING);
    for (i = 0; i < dgbgli_unpack_count(b); ++i) s->unpack[i] = dgbgli_get(b, dgbgli_unpack[i]);
}

static void dgbgli_depth_range(const dgbgl_backend* b, double near_value, double far_value) {
    if (b->gl.DepthRangef)
        b->gl.DepthRangef((float)near_value, (float)far_value);
    else
        b->gl.DepthRange(near_value, far_value);
}

/* The state every pass starts from. */
static void dgbgli_set_defaults(const dgbgl_backend* b) {
    int i;
    for (i = 0; i < DGBGL_TOGGLE_COUNT; ++i)
        if (dgbgli_has_toggle(b, i)) b->gl.Disable(dgbgli_toggles[i].name);
    b->gl.Disable(DGBGLI_BLEND);
    b->gl.Disable(DGBGLI_SCISSOR_TEST);
    b->gl.ColorMask(DGBGLI_TRUE, DGBGLI_TRUE, DGBGLI_TRUE, DGBGLI_TRUE);
    b->gl.DepthMask(DGBGLI_TRUE);
    dgbgli_depth_range(b, 0.0, 1.0);
    if (b->gl.PolygonMode) b->gl.PolygonMode(DGBGLI_FRONT_AND_BACK, DGBGLI_FILL);
    if (b->query_buffers) b->gl.BindBuffer(DGBGLI_QUERY_BUFFER, 0); /* else the timers are read into it */
    b->gl.BindBuffer(DGBGLI_PIXEL_UNPACK_BUFFER, 0);
    for (i = 0; i < dgbgli_unpack_count(b); ++i)
        b->gl.PixelStorei(dgbgli_unpack[i], dgbgli_unpack[i] == DGBGLI_UNPACK_ALIGNMENT ? 1 : 0);
}

static void dgbgli_restore_raster(const dgbgl_backend* b, const dgbgl_state* s) {
    int i;
    for (i = 0; i < dgbgli_viewport_count(b); ++i) {
        const float* v = s->viewports[i];
        if (b->indexed_viewports) {
            b->gl.ViewportIndexedf((unsigned)i, v[0], v[1], v[2], v[3]);
            b->gl.DepthRangeIndexed((unsigned)i, s->depth_ranges[i][0], s->depth_ranges[i][1]);
            (s->scissor[i] ? b->gl.Enablei : b->gl.Disablei)(DGBGLI_SCISSOR_TEST, (unsigned)i);
        } else {
            b->gl.Viewport((int)v[0], (int)v[1], (int)v[2], (int)v[3]);
            dgbgli_depth_range(b, s->depth_ranges[0][0], s->depth_ranges[0][1]);
            dgbgli_enable(b, DGBGLI_SCISSOR_TEST, s->scissor[0] != 0);
        }
    }
    for (i = 0; i < dgbgli_buffer_count(b); ++i) {
        const unsigned char* m = s->color_mask[i];
        if (b->indexed_buffers) {
            (s->blend[i] ? b->gl.Enablei : b->gl.Disablei)(DGBGLI_BLEND, (unsigned)i);
            b->gl.ColorMaski((unsigned)i, m[0], m[1], m[2], m[3]);
        } else {
            dgbgli_enable(b, DGBGLI_BLEND, s->blend[0] != 0);
            b->gl.ColorMask(m[0], m[1], m[2], m[3]);
        }
    }
    for (i = 0; i < DGBGL_TOGGLE_COUNT; ++i)
        if (dgbgli_has_toggle(b, i)) dgbgli_enable(b, dgbgli_toggles[i].name, s->toggles[i] != 0);
    b->gl.DepthMask((unsigned char)s->depth_mask);
    b->gl.DepthFunc((unsigned)s->depth_func);
    if (b->gl.PolygonMode) b->gl.PolygonMode(DGBGLI_FRONT_AND_BACK, (unsigned)s->polygon_mode[0]);
    if (b->gl.ClipControl) b->gl.ClipControl((unsigned)s->clip_origin, (unsigned)s->clip_depth);
}

static void dgbgli_restore_bindings(const dgbgl_backend* b, const dgbgl_state* s) {
    const unsigned int binding = (unsigned)b->desc.uniform_binding;
    int i;
    b->gl.BindFramebuffer(DGBGLI_DRAW_FRAMEBUFFER, (unsigned)s->draw_framebuffer);
    b->gl.BindFramebuffer(DGBGLI_READ_FRAMEBUFFER, (unsigned)s->read_framebuffer);
    /* a program that was deleted while in use is gone once another was used */
    b->gl.UseProgram(b->gl.IsProgram((unsigned)s->program) ? (unsigned)s->program : 0);
    b->gl.BindVertexArray((unsigned)s->vertex_array);
    if (s->uniform_size > 0)
        b->gl.BindBufferRange(DGBGLI_UNIFORM_BUFFER, binding, (unsigned)s->uniform_binding, (ptrdiff_t)s->uniform_start,
                              (ptrdiff_t)s->uniform_size);
    else
        b->gl.BindBufferBase(DGBGLI_UNIFORM_BUFFER, binding, (unsigned)s->uniform_binding);
    b->gl.BindBuffer(DGBGLI_UNIFORM_BUFFER, (unsigned)s->uniform_buffer);
    for (i = 0; i <= DGBGL_MAX_UNITS; ++i) {
        const int unit = dgbgli_saved_unit(b, i);
        b->gl.ActiveTexture((unsigned)(DGBGLI_TEXTURE0 + unit));
        b->gl.BindTexture(DGBGLI_TEXTURE_2D, (unsigned)s->textures_2d[i]);
        b->gl.BindTexture(DGBGLI_TEXTURE_2D_ARRAY, (unsigned)s->textures_array[i]);
        b->gl.BindSampler((unsigned)unit, (unsigned)s->samplers[i]);
    }
    b->gl.ActiveTexture((unsigned)s->active_texture);
    dgbgli_restore_images(b, s);
    if (b->query_buffers) b->gl.BindBuffer(DGBGLI_QUERY_BUFFER, (unsigned)s->query_buffer);
    b->gl.BindBuffer(DGBGLI_PIXEL_UNPACK_BUFFER, (unsigned)s->unpack_buffer);
    for (i = 0; i < dgbgli_unpack_count(b); ++i) b->gl.PixelStorei(dgbgli_unpack[i], s->unpack[i]);
}

static void dgbgli_begin(void* user) {
    dgbgl_backend* b = (dgbgl_backend*)user;
    b->drawing = DGB_OK;
    if (!b->desc.keep_state) {
        dgbgli_drain_errors(b, DGBGLI_PENDING);
        dgbgli_save_raster(b, &b->state);
        dgbgli_save_bindings(b, &b->state);
    }
    dgbgli_set_defaults(b);
}

static dgb_result dgbgli_end(void* user) {
    dgbgl_backend* b = (dgbgl_backend*)user;
    if (b->desc.keep_state) return DGB_OK;
    dgbgli_note_errors(b);
    dgbgli_restore_raster(b, &b->state);
    dgbgli_restore_bindings(b, &b->state);
    return b->drawing;
}

/* >> textures: the handle holds the GL name, above it whether it is an array (bit 32) and its format (from bit 40) */

static bool dgbgli_is_array(dgb_texture texture) { return (texture.id >> 32 & 1u) != 0; }

static dgb_format dgbgli_format(dgb_texture texture) { return (dgb_format)(texture.id >> 40); }

static unsigned int dgbgli_target(dgb_texture texture) {
    return dgbgli_is_array(texture) ? DGBGLI_TEXTURE_2D_ARRAY : DGBGLI_TEXTURE_2D;
}

DGB_API dgb_texture dgbgl_texture(unsigned int name) {
    dgb_texture texture;
    texture.id = name;
    return texture;
}

DGB_API unsigned int dgbgl_texture_name(dgb_texture texture) { return (unsigned int)(texture.id & 0xffffffffu); }

static void dgbgli_allocate(const dgbgl_backend* b, const dgb_texture_desc* d, unsigned int target) {
    const unsigned int internal = dgbgli_formats[d->format].internal, format = dgbgli_formats[d->format].format,
                       type = dgbgli_formats[d->format].type;
    int level;
    if (d->layers && b->gl.TexStorage3D) {
        b->gl.TexStorage3D(target, d->levels, internal, d->width, d->height, d->layers);
    } else if (!d->layers && b->gl.TexStorage2D) {
        b->gl.TexStorage2D(target, d->levels, internal, d->width, d->height);
    } else {
        for (level = 0; level < d->levels; ++level) {
            const int w = d->width >> level, h = d->height >> level;
            if (d->layers)
                b->gl.TexImage3D(target, level, (int)internal, w, h, d->layers, 0, format, type, NULL);
            else
                b->gl.TexImage2D(target, level, (int)internal, w, h, 0, format, type, NULL);
        }
    }
}

static void dgbgli_upload(const dgbgl_backend* b, const dgb_texture_desc* d, unsigned int target) {
    b->gl.TexSubImage2D(target, 0, 0, 0, d->width, d->height, dgbgli_formats[d->format].format,
                        dgbgli_formats[d->format].type, d->pixels);
}

static void dgbgli_label(const dgbgl_backend* b, unsigned int kind, unsigned int name, const char* what) {
    char label[64];
    dgbgli_text t = dgbgli_text_on(label, sizeof label);
    dgbgli_put(&t, "dgb ");
    dgbgli_put(&t, what);
    if (b->gl.ObjectLabel) b->gl.ObjectLabel(kind, name, -1, label);
}

static dgb_result dgbgli_texture_create(void* user, const dgb_texture_desc* d, dgb_texture* texture) {
    dgbgl_backend* b = (dgbgl_backend*)user;
    const unsigned int target = d->layers ? DGBGLI_TEXTURE_2D_ARRAY : DGBGLI_TEXTURE_2D;
    unsigned int name = 0;
    dgb_result result;
    dgbgli_drain_errors(b, DGBGLI_PENDING);
    b->gl.GenTextures(1, &name);
    if (!name) return dgbgli_no_object(b);
    b->gl.ActiveTexture(DGBGLI_TEXTURE0);
    b->gl.BindTexture(target, name);
    dgbgli_allocate(b, d, target);
    b->gl.TexParameteri(target, DGBGLI_TEXTURE_MAX_LEVEL, d->levels - 1);
    b->gl.TexParameteri(target, DGBGLI_TEXTURE_MIN_FILTER, DGBGLI_NEAREST);
    b->gl.TexParameteri(target, DGBGLI_TEXTURE_MAG_FILTER, DGBGLI_NEAREST);
    b->gl.TexParameteri(target, DGBGLI_TEXTURE_WRAP_S, DGBGLI_CLAMP_TO_EDGE);
    b->gl.TexParameteri(target, DGBGLI_TEXTURE_WRAP_T, DGBGLI_CLAMP_TO_EDGE);
    result = dgbgli_check(b);
    if (result == DGB_OK && d->pixels) {
        dgbgli_upload(b, d, target);
        result = dgbgli_check(b);
    }
    if (result != DGB_OK) {
        b->gl.DeleteTextures(1, &name);
        return result;
    }
    dgbgli_label(b, DGBGLI_TEXTURE, name, dgb_slot_name(d->slot));
    texture->id = (uint64_t)name | (uint64_t)(d->layers > 0) << 32 | (uint64_t)d->format << 40;
    return DGB_OK;
}

static bool dgbgli_framebuffer_uses(const dgbgl_backend* b, int i, dgb_texture texture) {
    int t;
    for (t = 0; t < b->framebuffers[i].count; ++t)
        if (b->framebuffers[i].targets[t].texture.id == texture.id) return true;
    return false;
}

static void dgbgli_drop_framebuffer(dgbgl_backend* b, int i) {
    if (!b->framebuffers[i].name) return;
    b->gl.DeleteFramebuffers(1, &b->framebuffers[i].name);
    memset(&b->framebuffers[i], 0, sizeof b->framebuffers[i]);
}

static void dgbgli_texture_destroy(void* user, dgb_texture texture) {
    dgbgl_backend* b = (dgbgl_backend*)user;
    const unsigned int name = dgbgl_texture_name(texture);
    int i;
    for (i = 0; i < DGBGL_MAX_FRAMEBUFFERS; ++i)
        if (dgbgli_framebuffer_uses(b, i, texture)) dgbgli_drop_framebuffer(b, i);
    /* GL takes a deleted texture off its units, and so must the saved state: else it would bind a dead name */
    for (i = 0; i <= DGBGL_MAX_UNITS; ++i) {
        if (b->state.textures_2d[i] == (int)name) b->state.textures_2d[i] = 0;
        if (b->state.textures_array[i] == (int)name) b->state.textures_array[i] = 0;
    }
    b->gl.DeleteTextures(1, &name);
}

/* >> programs */

typedef struct dgbgli_chunks { /* shader text as GL takes it: pieces */
    const char* pieces[48];
    int count;
} dgbgli_chunks;

static void dgbgli_add_chunks(dgbgli_chunks* c, const char* const* chunks) {
    while (*chunks) {
        DGB_ASSERT(c->count < (int)(sizeof c->pieces / sizeof c->pieces[0]));
        c->pieces[c->count++] = *chunks++;
    }
}

static void dgbgli_put_pass_head(dgbgli_text* t, const dgb_program_desc* d, int version, bool es) {
    int i;
    dgbgli_put_version(t, version, es);
    dgbgli_put_precision(t, es);
    dgbgli_put_define(t, "DGB_MAX_TAPS", DGB_MAX_TAPS);
    dgbgli_put_define(t, "DGB_MAX_FILTER_RADIUS", DGB_MAX_FILTER_RADIUS);
    dgbgli_put_define(t, "DGB_MAX_GLOSSY_TAPS", DGB_MAX_GLOSSY_TAPS);
    for (i = 0; i < d->define_count; ++i) dgbgli_put_define(t, d->defines[i].name, d->defines[i].value);
}

/* AO and GATHER of DGB_ESTIMATOR_BITMASK. */
static bool dgbgli_is_bitmask(const dgb_program_desc* d) {
    int i;
    for (i = 0; i < d->define_count; ++i)
        if (strcmp(d->defines[i].name, "DGB_BITMASK_LIGHT") == 0) return true;
    return false;
}

static void dgbgli_pass_chunks(const dgb_program_desc* d, dgbgl_stage stage, dgbgli_chunks* c) {
    const dgb_pass_id pass = d->pass;
    const bool bitmask = dgbgli_is_bitmask(d);
    if (stage == DGBGL_VERTEX) {
        dgbgli_add_chunks(c, dgbgli_glsl_fullscreen);
        return;
    }
    dgbgli_add_chunks(c, dgbgli_glsl_common);
    if (pass == DGB_PASS_AO || pass == DGB_PASS_GATHER) dgbgli_add_chunks(c, dgbgli_glsl_taps);
    if (bitmask || pass == DGB_PASS_REFLECT) dgbgli_add_chunks(c, dgbgli_glsl_thickness);
    if (bitmask) dgbgli_add_chunks(c, dgbgli_glsl_sectors);
    if (pass == DGB_PASS_TILES || pass == DGB_PASS_RANGE) dgbgli_add_chunks(c, dgbgli_glsl_depths);
    if (pass == DGB_PASS_PACK || pass == DGB_PASS_TEMPORAL || pass == DGB_PASS_REFLECT || pass == DGB_PASS_GLOSSY)
        dgbgli_add_chunks(c, dgbgli_glsl_source);
    if (pass == DGB_PASS_PACK || pass == DGB_PASS_TEMPORAL || pass == DGB_PASS_GLOSSY)
        dgbgli_add_chunks(c, dgbgli_glsl_history);
    switch (pass) {
    case DGB_PASS_WARP: dgbgli_add_chunks(c, dgbgli_glsl_warp); break;
    case DGB_PASS_RESOLVE: dgbgli_add_chunks(c, dgbgli_glsl_resolve); break;
    case DGB_PASS_PACK: dgbgli_add_chunks(c, dgbgli_glsl_pack); break;
    case DGB_PASS_MIP: dgbgli_add_chunks(c, dgbgli_glsl_mip); break;
    case DGB_PASS_TILES: dgbgli_add_chunks(c, dgbgli_glsl_tiles); break;
    case DGB_PASS_AO: dgbgli_add_chunks(c, bitmask ? dgbgli_glsl_bitmask : dgbgli_glsl_ao); break;
    case DGB_PASS_GATHER: dgbgli_add_chunks(c, bitmask ? dgbgli_glsl_bitmask : dgbgli_glsl_gather); break;
    case DGB_PASS_TEMPORAL: dgbgli_add_chunks(c, dgbgli_glsl_temporal); break;
    case DGB_PASS_RECONSTRUCT: dgbgli_add_chunks(c, dgbgli_glsl_reconstruct); break;
    case DGB_PASS_RANGE: dgbgli_add_chunks(c, dgbgli_glsl_range); break;
    case DGB_PASS_REFLECT: dgbgli_add_chunks(c, dgbgli_glsl_reflect); break;
    case DGB_PASS_GLOSSY: dgbgli_add_chunks(c, dgbgli_glsl_glossy); break;
    case DGB_PASS_LAYERS: /* the engine's own */
    case DGB_PASS_BACK:
    case DGB_PASS_PREDICT:
    case DGB_PASS_COUNT: break;
    }
}

DGB_API size_t dgbgl_composite_snippet(char* text, size_t capacity) {
    dgbgli_text t = dgbgli_text_on(text, capacity);
    dgbgli_put_chunks(&t, dgbgli_glsl_composite);
    return t.length;
}

DGB_API size_t dgbgl_pass_source(const dgb_program_desc* program, dgbgl_stage stage, int version, bool es, char* text,
                                 size_t capacity) {
    dgbgli_text t = dgbgli_text_on(text, capacity);
    dgbgli_chunks c;
    int i;
    if (!program) return 0;
    c.count = 0;
    dgbgli_put_pass_head(&t, program, version, es);
    dgbgli_pass_chunks(program, stage, &c);
    for (i = 0; i < c.count; ++i) dgbgli_put(&t, c.pieces[i]);
    return t.length;
}

/* A compiled shader, or 0 and a message. */
static unsigned int dgbgli_compile(const dgbgl_backend* b, const char* what, dgbgl_stage stage,
                                   const dgbgli_chunks* c) {
    const unsigned int shader =
        b->gl.CreateShader(stage == DGBGL_VERTEX ? DGBGLI_VERTEX_SHADER : DGBGLI_FRAGMENT_SHADER);
    char log[2048];
    int ok = 0;
    if (!shader) {
        dgbgli_message(b, what, "the driver gives no shader");
        return 0;
    }
    b->gl.ShaderSource(shader, c->count, c->pieces, NULL);
    b->gl.CompileShader(shader);
    b->gl.GetShaderiv(shader, DGBGLI_COMPILE_STATUS, &ok);
    if (ok) return shader;
    log[0] = 0;
    b->gl.GetShaderInfoLog(shader, (int)sizeof log, NULL, log);
    dgbgli_message(b, what, log);
    b->gl.DeleteShader(shader);
    return 0;
}

static unsigned int dgbgli_link(const dgbgl_backend* b, const char* what, unsigned int vertex, unsigned int fragment) {
    const unsigned int program = b->gl.CreateProgram();
    char log[2048];
    int ok = 0;
    if (!program) {
        dgbgli_message(b, what, "the driver gives no program");
        return 0;
    }
    b->gl.AttachShader(program, vertex);
    b->gl.AttachShader(program, fragment);
    b->gl.LinkProgram(program);
    b->gl.GetProgramiv(program, DGBGLI_LINK_STATUS, &ok);
    if (ok) return program;
    log[0] = 0;
    b->gl.GetProgramInfoLog(program, (int)sizeof log, NULL, log);
    dgbgli_message(b, what, log);
    b->gl.DeleteProgram(program);
    return 0;
}

/* A linked and labelled program of the two texts, or 0 and a message. */
static unsigned int dgbgli_make_program(const dgbgl_backend* b, const char* what, const dgbgli_chunks* vertex_text,
                                        const dgbgli_chunks* fragment_text) {
    const unsigned int vertex = dgbgli_compile(b, what, DGBGL_VERTEX, vertex_text);
    const unsigned int fragment = vertex ? dgbgli_compile(b, what, DGBGL_FRAGMENT, fragment_text) : 0;
    const unsigned int program = fragment ? dgbgli_link(b, what, vertex, fragment) : 0;
    if (vertex) b->gl.DeleteShader(vertex);
    if (fragment) b->gl.DeleteShader(fragment);
    if (program) dgbgli_label(b, DGBGLI_PROGRAM, program, what);
    return program;
}

/* Texture unit of a slot. No pass reads two slots that share one. */
static int dgbgli_unit(const dgbgl_backend* b, dgb_slot slot) {
    switch (slot) {
    case DGB_Z:
    case DGB_DEPTH:
    case DGB_TILE_DEPTHS:
    case DGB_HALF:
    case DGB_ENGINE_DEPTH0: return 0;
    case DGB_NORMALS:
    case DGB_REGION_DEPTHS:
    case DGB_HALF1:
    case DGB_ENGINE_NORMAL0: return 1;
    case DGB_B0:
    case DGB_REFLECTION_RAW:
    case DGB_RADIANCE:
    case DGB_AO_RAW:
    case DGB_HALF_BENT:
    case DGB_ENGINE_RADIANCE0: return 2;
    case DGB_B1:
    case DGB_REFLECTION_HIT:
    case DGB_IRRADIANCE_RAW:
    case DGB_ENGINE_DEPTH1: return 3;
    case DGB_ROTATIONS:
    case DGB_IRRADIANCE1_RAW:
    case DGB_ENGINE_NORMAL1: return 4;
    case DGB_NORMAL: /* with roughness */
    case DGB_ENGINE_ROUGHNESS:
    case DGB_BENT_RAW:
    case DGB_ENGINE_RADIANCE1: return 5;
    case DGB_LAST_Z: return 6;
    case DGB_LAST_IRRADIANCE:
    case DGB_LAST_REFLECTION:
    case DGB_IRRADIANCE: return 7;
    case DGB_LAST_IRRADIANCE1:
    case DGB_LAST_REFLECTION_FRAMES:
    case DGB_IRRADIANCE1: return 8;
    case DGB_VELOCITY:
    case DGB_ENGINE_VELOCITY0: return 9;
    case DGB_ENGINE_VELOCITY1: return 10;
    case DGB_ALBEDO:
    case DGB_LAST_BENT:
    case DGB_ENGINE_ALBEDO0: return 11;
    case DGB_ENGINE_ALBEDO1: return 12;
    case DGB_LAST_FRAMES:
    case DGB_BACK:
    case DGB_ENGINE_BACK:
    case DGB_TILES: return 13;
    default: return b->desc.oracle_unit; /* key and oracle: beside passes of the engine's, whose units the others are */
    }
}

static void dgbgli_connect_samplers(const dgbgl_backend* b, unsigned int program) {
    int slot;
    b->gl.UseProgram(program);
    for (slot = DGB_SLOT_NONE + 1; slot < DGB_SLOT_COUNT; ++slot) {
        char name[48];
        dgbgli_text t = dgbgli_text_on(name, sizeof name);
        int location;
        dgbgli_put(&t, "dgb_");
        dgbgli_put(&t, dgb_slot_name((dgb_slot)slot));
        location = b->gl.GetUniformLocation(program, name);
        if (location >= 0) b->gl.Uniform1i(location, dgbgli_unit(b, (dgb_slot)slot));
    }
}

/* The pass that draws the engine's scene. */
static const dgb_plan_pass* dgbgli_layers_pass(const dgb_plan* plan) {
    const dgb_plan_pass* pass = plan->passes;
    while (pass->id != DGB_PASS_LAYERS) ++pass;
    return pass;
}

/* Image units: the key is 0, then the layer targets in the order of their locations. */
static void dgbgli_connect_images(const dgbgl_backend* b, const dgb_plan* plan, unsigned int program) {
    const dgb_plan_pass* pass = dgbgli_layers_pass(plan);
    int i;
    b->gl.UseProgram(program);
    for (i = -1; i < pass->output_count; ++i) {
        char name[48];
        dgbgli_text t = dgbgli_text_on(name, sizeof name);
        int location;
        dgbgli_put(&t, "dgb_image_");
        dgbgli_put(&t, i < 0 ? "key" : dgb_slot_name(pass->outputs[i]));
        location = b->gl.GetUniformLocation(program, name);
        if (location >= 0) b->gl.Uniform1i(location, i + 1);
    }
}

static void dgbgli_connect_block(const dgbgl_backend* b, unsigned int program, const char* pass) {
    char name[48];
    dgbgli_text t = dgbgli_text_on(name, sizeof name);
    unsigned int block;
    dgbgli_put(&t, "dgb_");
    dgbgli_put(&t, pass);
    dgbgli_put(&t, "_block");
    block = b->gl.GetUniformBlockIndex(program, name);
    if (block != 0xffffffffu) b->gl.UniformBlockBinding(program, block, (unsigned)b->desc.uniform_binding);
}

static dgb_result dgbgli_program_create(void* user, const dgb_program_desc* d, dgb_program* program) {
    dgbgl_backend* b = (dgbgl_backend*)user;
    char head[1024];
    dgbgli_text t = dgbgli_text_on(head, sizeof head);
    dgbgli_chunks vertex, fragment;
    unsigned int name;
    dgbgli_put_pass_head(&t, d, b->version, b->es);
    vertex.pieces[0] = fragment.pieces[0] = head;
    vertex.count = fragment.count = 1;
    dgbgli_pass_chunks(d, DGBGL_VERTEX, &vertex);
    dgbgli_pass_chunks(d, DGBGL_FRAGMENT, &fragment);
    name = dgbgli_make_program(b, dgb_pass_name(d->pass), &vertex, &fragment);
    if (!name) return DGB_DEVICE;
    dgbgli_connect_samplers(b, name);
    dgbgli_connect_block(b, name, dgbgli_is_bitmask(d) ? "bitmask" : dgb_pass_name(d->pass));
    program->id = name;
    return DGB_OK;
}

static void dgbgli_program_destroy(void* user, dgb_program program) {
    dgbgl_backend* b = (dgbgl_backend*)user;
    b->gl.DeleteProgram((unsigned)program.id);
}

/* >> passes */

static void dgbgli_attach(const dgbgl_backend* b, unsigned int attachment, const dgb_target* target) {
    const unsigned int name = dgbgl_texture_name(target->texture);
    if (!dgbgli_is_array(target->texture))
        b->gl.FramebufferTexture2D(DGBGLI_FRAMEBUFFER, attachment, DGBGLI_TEXTURE_2D, name, target->level);
    else if (target->layer < 0)
        b->gl.FramebufferTexture(DGBGLI_FRAMEBUFFER, attachment, name, target->level);
    else
        b->gl.FramebufferTextureLayer(DGBGLI_FRAMEBUFFER, attachment, name, target->level, target->layer);
}

static int dgbgli_gather_targets(const dgb_pass* pass, dgb_target targets[DGB_MAX_TARGETS + 1]) {
    int count = pass->color_count;
    memset(targets, 0, sizeof(dgb_target) * (DGB_MAX_TARGETS + 1));
    memcpy(targets, pass->colors, sizeof(dgb_target) * (size_t)count);
    if (pass->depth.texture.id) targets[count++] = pass->depth;
    return count;
}

static bool dgbgli_same_targets(const dgb_target* a, const dgb_target* b, int count) {
    int i;
    for (i = 0; i < count; ++i)
        if (a[i].texture.id != b[i].texture.id || a[i].level != b[i].level || a[i].layer != b[i].layer) return false;
    return true;
}

/* Draw and read buffers belong to the framebuffer: an engine's callback may have changed those of the last pass. */
static void dgbgli_set_buffers(const dgbgl_backend* b, const dgb_pass* pass) {
    static const unsigned int buffers[DGB_MAX_TARGETS] = {DGBGLI_COLOR_ATTACHMENT0, DGBGLI_COLOR_ATTACHMENT0 + 1,
                                                          DGBGLI_COLOR_ATTACHMENT0 + 2, DGBGLI_COLOR_ATTACHMENT0 + 3};
    b->gl.DrawBuffers(pass->color_count, buffers);
    b->gl.ReadBuffer(pass->color_count ? DGBGLI_COLOR_ATTACHMENT0 : DGBGLI_NONE);
}

/* False, and a message, when it is of no use; it is then gone again. */
static bool dgbgli_make_framebuffer(dgbgl_backend* b, int i, const dgb_pass* pass) {
    int c;
    b->gl.GenFramebuffers(1, &b->framebuffers[i].name);
    if (!b->framebuffers[i].name) { /* 0 would be the engine's own */
        dgbgli_message(b, dgb_pass_name(pass->id), "the driver gives no framebuffer");
        return false;
    }
    b->gl.BindFramebuffer(DGBGLI_FRAMEBUFFER, b->framebuffers[i].name);
    for (c = 0; c < pass->color_count; ++c)
        dgbgli_attach(b, (unsigned)(DGBGLI_COLOR_ATTACHMENT0 + c), &pass->colors[c]);
    if (pass->depth.texture.id) dgbgli_attach(b, DGBGLI_DEPTH_ATTACHMENT, &pass->depth);
    dgbgli_set_buffers(b, pass);
    if (b->gl.CheckFramebufferStatus(DGBGLI_FRAMEBUFFER) != DGBGLI_FRAMEBUFFER_COMPLETE) {
        dgbgli_message(b, dgb_pass_name(pass->id), "the driver cannot render to this combination of formats");
        dgbgli_drop_framebuffer(b, i);
        return false;
    }
    dgbgli_label(b, DGBGLI_FRAMEBUFFER, b->framebuffers[i].name, dgb_pass_name(pass->id));
    return true;
}

/* Framebuffers are made once for each combination of targets and found again by it. */
static bool dgbgli_bind_framebuffer(dgbgl_backend* b, const dgb_pass* pass) {
    dgb_target targets[DGB_MAX_TARGETS + 1];
    const int count = dgbgli_gather_targets(pass, targets);
    int i;
    for (i = 0; i < DGBGL_MAX_FRAMEBUFFERS; ++i)
        if (b->framebuffers[i].name && b->framebuffers[i].count == count &&
            dgbgli_same_targets(b->framebuffers[i].targets, targets, count)) {
            b->gl.BindFramebuffer(DGBGLI_FRAMEBUFFER, b->framebuffers[i].name);
            dgbgli_set_buffers(b, pass);
            return true;
        }
    i = b->next_framebuffer;
    b->next_framebuffer = (i + 1) % DGBGL_MAX_FRAMEBUFFERS;
    dgbgli_drop_framebuffer(b, i);
    if (!dgbgli_make_framebuffer(b, i, pass)) return false;
    b->framebuffers[i].count = count;
    memcpy(b->framebuffers[i].targets, targets, sizeof targets);
    return true;
}

static void dgbgli_clear(const dgbgl_backend* b, const dgb_pass* pass) {
    static const float black[4] = {0.0f, 0.0f, 0.0f, 0.0f};
    int i;
    for (i = 0; i < pass->color_count; ++i) b->gl.ClearBufferfv(DGBGLI_COLOR, i, black);
    if (pass->depth.texture.id) b->gl.ClearBufferfv(DGBGLI_DEPTH, 0, &pass->clear_depth);
}

static void dgbgli_bind_image(const dgbgl_backend* b, unsigned int unit, dgb_texture texture) {
    b->gl.BindImageTexture(unit, dgbgl_texture_name(texture), 0, DGBGLI_TRUE, 0, DGBGLI_READ_WRITE,
                           dgbgli_formats[dgbgli_format(texture)].internal);
}

/* Image emission: empties the deeper layers and their keys, and binds all of them as images. */
static bool dgbgli_begin_images(dgbgl_backend* b, const dgb_pass* pass) {
    unsigned int clear_key[4] = {0, 0, 0, 0};
    dgb_pass deep = *pass, key;
    int i, layer;
    memcpy(clear_key, &pass->clear_depth, sizeof pass->clear_depth);
    memset(&key, 0, sizeof key);
    key.id = pass->id;
    key.color_count = 1;
    key.colors[0].texture = pass->key;
    for (layer = 1; layer <= pass->key_layers; ++layer) {
        for (i = 0; i < deep.color_count; ++i) deep.colors[i].layer = layer;
        deep.depth.layer = layer;
        if (!dgbgli_bind_framebuffer(b, &deep)) return false;
        dgbgli_clear(b, &deep);
        key.colors[0].layer = layer - 1;
        if (!dgbgli_bind_framebuffer(b, &key)) return false;
        b->gl.ClearBufferuiv(DGBGLI_COLOR, 0, clear_key);
    }
    dgbgli_bind_image(b, 0, pass->key);
    for (i = 0; i < pass->color_count; ++i) dgbgli_bind_image(b, (unsigned)(1 + i), pass->colors[i].texture);
    for (; i < DGB_MAX_TARGETS; ++i) /* what the material stores where nothing is kept goes nowhere */
        b->gl.BindImageTexture((unsigned)(1 + i), 0, 0, DGBGLI_FALSE, 0, DGBGLI_READ_WRITE, DGBGLI_RGBA8);
    b->gl.MemoryBarrier((unsigned)DGBGLI_ALL_BARRIER_BITS);
    return true;
}

static void dgbgli_viewports(const dgbgl_backend* b, const dgb_pass* pass) {
    if (b->indexed_viewports && pass->deep_width > 0.0f) {
        int i;
        /* multicast: viewport i is layer i, and all are alike; else viewport 1 serves every deeper layer */
        for (i = 0; i < DGB_MAX_LAYERS; ++i) b->gl.ViewportIndexedf((unsigned)i, 0.0f, 0.0f, pass->width, pass->height);
        if (pass->depth.layer < 0) b->gl.ViewportIndexedf(1, 0.0f, 0.0f, pass->deep_width, pass->deep_height);
    } else {
        b->gl.Viewport(pass->x, pass->y, (int)pass->width, (int)pass->height);
    }
}

/* What an engine's draw callback may count on. */
static void dgbgli_begin_layers(const dgbgl_backend* b, const dgb_pass* pass) {
    b->gl.Enable(DGBGLI_DEPTH_TEST);
    b->gl.DepthFunc(pass->reversed ? DGBGLI_GREATER : DGBGLI_LESS);
    if (b->gl.ClipControl)
        b->gl.ClipControl(DGBGLI_LOWER_LEFT,
                          pass->clip == DGB_CLIP_ZERO_TO_ONE ? DGBGLI_ZERO_TO_ONE : DGBGLI_NEGATIVE_ONE_TO_ONE);
    /* peeling reads the layer in front of the one it writes, from the same texture */
    if (pass->depth.layer > 0 && b->gl.TextureBarrier) b->gl.TextureBarrier();
}

static bool dgbgli_is_fullscreen(const dgb_pass* pass) {
    return pass->id != DGB_PASS_LAYERS && pass->id != DGB_PASS_BACK && pass->id != DGB_PASS_PREDICT;
}

static dgb_result dgbgli_pass_begin(void* user, const dgb_pass* pass) {
    dgbgl_backend* b = (dgbgl_backend*)user;
    b->pass = *pass;
    if (!dgbgli_is_fullscreen(pass)) dgbgli_set_defaults(b); /* another layer's callback may have changed anything */
    if (pass->key.id && !dgbgli_begin_images(b, pass)) return DGB_DEVICE;
    if (!dgbgli_bind_framebuffer(b, pass)) return DGB_DEVICE;
    dgbgli_viewports(b, pass);
    if (pass->clear) dgbgli_clear(b, pass);
    if (!dgbgli_is_fullscreen(pass)) {
        dgbgli_begin_layers(b, pass);
        return DGB_OK;
    }
    b->gl.BindVertexArray(b->vertex_array);
    if (pass->depth.texture.id) {
        b->gl.Enable(DGBGLI_DEPTH_TEST); /* warp, resolve: depth is written only with the test on */
        b->gl.DepthFunc(DGBGLI_ALWAYS);
    }
    return DGB_OK;
}

static void dgbgli_level_range(const dgbgl_backend* b, dgb_texture texture, int base, int max) {
    b->gl.TexParameteri(dgbgli_target(texture), DGBGLI_TEXTURE_BASE_LEVEL, base);
    b->gl.TexParameteri(dgbgli_target(texture), DGBGLI_TEXTURE_MAX_LEVEL, max);
}

static void dgbgli_texture_bind(void* user, dgb_slot slot, dgb_texture texture, int level) {
    dgbgl_backend* b = (dgbgl_backend*)user;
    const int unit = dgbgli_unit(b, slot);
    b->gl.ActiveTexture((unsigned)(DGBGLI_TEXTURE0 + unit));
    b->gl.BindTexture(dgbgli_target(texture), dgbgl_texture_name(texture));
    b->gl.BindSampler((unsigned)unit, b->sampler);
    if (level < 0) return;
    /* reading one level while another is written is defined only if the written one is out of reach */
    dgbgli_level_range(b, texture, level, level);
    b->narrowed[b->narrowed_count++] = texture;
}

static void dgbgli_uniforms_upload(void* user, const void* std140, size_t size) {
    dgbgl_backend* b = (dgbgl_backend*)user;
    b->gl.BindBuffer(DGBGLI_UNIFORM_BUFFER, b->uniform_buffer);
    b->gl.BufferData(DGBGLI_UNIFORM_BUFFER, (ptrdiff_t)size, std140, DGBGLI_STREAM_DRAW);
    b->gl.BindBufferBase(DGBGLI_UNIFORM_BUFFER, (unsigned)b->desc.uniform_binding, b->uniform_buffer);
    if (!b->desc.keep_state && !dgbgli_is_fullscreen(&b->pass))
        dgbgli_note_errors(b); /* the engine's callback follows */
}

static void dgbgli_draw_fullscreen(void* user, dgb_program program) {
    dgbgl_backend* b = (dgbgl_backend*)user;
    b->gl.UseProgram((unsigned)program.id);
    b->gl.DrawArrays(DGBGLI_TRIANGLES, 0, 3);
}

static void dgbgli_pass_end(void* user) {
    dgbgl_backend* b = (dgbgl_backend*)user;
    int i;
    for (i = 0; i < b->narrowed_count; ++i) {
        b->gl.BindTexture(dgbgli_target(b->narrowed[i]), dgbgl_texture_name(b->narrowed[i]));
        dgbgli_level_range(b, b->narrowed[i], 0, DGB_MAX_LEVELS - 1);
    }
    b->narrowed_count = 0;
    if (b->pass.id == DGB_PASS_RESOLVE) /* the key holds integers, and this is the unit of the engine's float sampler */
        b->gl.BindTexture(DGBGLI_TEXTURE_2D_ARRAY, 0);
    if (!b->desc.keep_state && !dgbgli_is_fullscreen(&b->pass)) dgbgli_drain_errors(b, "left by the draw callback");
    if (b->pass.key.id) b->gl.MemoryBarrier((unsigned)DGBGLI_ALL_BARRIER_BITS);
    if (b->pass.depth.texture.id) dgbgli_set_defaults(b); /* whatever the engine's callback left */
}

/* >> timers: two sets of queries a pass, read when they are ready, never waited for */

static void dgbgli_read_timer(dgbgl_backend* b, dgb_pass_id pass, int frame) {
    const unsigned int* queries = b->timers[pass].queries[frame];
    int ready = 0;
    uint64_t from = 0, to = 0;
    if (!b->timers[pass].pending[frame]) return;
    b->gl.GetQueryObjectiv(queries[1], DGBGLI_QUERY_RESULT_AVAILABLE, &ready);
    if (!ready) return;
    b->gl.GetQueryObjectui64v(queries[0], DGBGLI_QUERY_RESULT, &from);
    b->gl.GetQueryObjectui64v(queries[1], DGBGLI_QUERY_RESULT, &to);
    b->timers[pass].milliseconds = (double)(to - from) * 1e-6;
    b->timers[pass].pending[frame] = false;
}

static void dgbgli_marker(void* user, dgb_pass_id pass, bool begin) {
    dgbgl_backend* b = (dgbgl_backend*)user;
    const int frame = b->timers[pass].frame;
    if (begin && b->gl.PushDebugGroup)
        b->gl.PushDebugGroup(DGBGLI_DEBUG_SOURCE_APPLICATION, (unsigned)pass, -1, dgb_pass_name(pass));
    if (!begin && b->gl.PopDebugGroup) b->gl.PopDebugGroup();
    if (!b->timers[pass].queries[0][0]) return;
    if (begin) {
        dgbgli_read_timer(b, pass, frame);
        b->timers[pass].running = !b->timers[pass].pending[frame];
        if (b->timers[pass].running) b->gl.QueryCounter(b->timers[pass].queries[frame][0], DGBGLI_TIMESTAMP);
    } else if (b->timers[pass].running) {
        b->gl.QueryCounter(b->timers[pass].queries[frame][1], DGBGLI_TIMESTAMP);
        b->timers[pass].pending[frame] = true;
        b->timers[pass].frame = 1 - frame;
    }
}

DGB_API bool dgbgl_pass_time(const dgbgl_backend* gl, dgb_pass_id pass, double* milliseconds) {
    if (!gl || !milliseconds || (int)pass < 0 || pass >= DGB_PASS_COUNT || !gl->timers[pass].queries[0][0] ||
        gl->timers[pass].milliseconds < 0.0)
        return false;
    *milliseconds = gl->timers[pass].milliseconds;
    return true;
}

/* >> views: a texture as colours, drawn into the engine's framebuffer */

static const struct {
    const char *name, *legend, *define;
    dgb_slot slot;
} dgbgli_views[DGBGL_VIEW_COUNT] = {
#define DGBGLI_VIEW(name, word, slot, legend) {word, legend, "DGB_VIEW_" #name, slot},
    DGBGL_VIEWS(DGBGLI_VIEW)
#undef DGBGLI_VIEW
};

static bool dgbgli_is_view(dgbgl_view view) { return (int)view >= 0 && view < DGBGL_VIEW_COUNT; }

DGB_API const char* dgbgl_view_name(dgbgl_view view) { return dgbgli_is_view(view) ? dgbgli_views[view].name : "?"; }

DGB_API const char* dgbgl_view_legend(dgbgl_view view) {
    return dgbgli_is_view(view) ? dgbgli_views[view].legend : "?";
}

typedef struct dgbgli_view_uniforms { /* dgb_view_block */
    dgb_camera camera;
    float rectangle[4]; /* lower left corner; pixels of the image a pixel of the rectangle: x, y */
    float scale[4];     /* factor of light; m where depth has fallen to an eighth; weight of history */
    int32_t choice[4];  /* view, layer, its divisor, guard band of its texture */
    int32_t has[4];     /* x: packed z */
} dgbgli_view_uniforms;

/* Samplers of the program; the unit of each is its place. */
static const char* const dgbgli_view_samplers[4] = {"dgb_view_depth", "dgb_view_layer", "dgb_view_image", "dgb_view_z"};

static void dgbgli_put_view_head(dgbgli_text* t, int version, bool es) {
    int i;
    dgbgli_put_version(t, version, es);
    dgbgli_put_precision(t, es);
    for (i = 0; i < DGBGL_VIEW_COUNT; ++i) dgbgli_put_define(t, dgbgli_views[i].define, i);
}

static void dgbgli_view_chunks(dgbgl_stage stage, dgbgli_chunks* c) {
    dgbgli_add_chunks(c, stage == DGBGL_VERTEX ? dgbgli_glsl_fullscreen : dgbgli_glsl_common);
    if (stage == DGBGL_FRAGMENT) dgbgli_add_chunks(c, dgbgli_glsl_view);
}

static bool dgbgli_make_view_program(dgbgl_backend* b) {
    char head[1024];
    dgbgli_text t = dgbgli_text_on(head, sizeof head);
    dgbgli_chunks vertex, fragment;
    int i;
    if (b->view_program) return true;
    dgbgli_put_view_head(&t, b->version, b->es);
    vertex.pieces[0] = fragment.pieces[0] = head;
    vertex.count = fragment.count = 1;
    dgbgli_view_chunks(DGBGL_VERTEX, &vertex);
    dgbgli_view_chunks(DGBGL_FRAGMENT, &fragment);
    b->view_program = dgbgli_make_program(b, "view", &vertex, &fragment);
    if (!b->view_program) return false;
    dgbgli_connect_block(b, b->view_program, "view");
    b->gl.UseProgram(b->view_program);
    for (i = 0; i < 4; ++i) b->gl.Uniform1i(b->gl.GetUniformLocation(b->view_program, dgbgli_view_samplers[i]), i);
    return true;
}

/* Null, or why the view cannot be drawn. */
static const char* dgbgli_view_fault(const dgb_context* c, const dgbgl_view_desc* v) {
    if (!dgbgli_is_view(v->view)) return "there is no such view";
    if (v->width < 0 || v->height < 0) return "width and height must be 0 or more";
    if (!(v->exposure >= 0.0f && v->depth_range >= 0.0f)) return "exposure and depth_range must be 0 or more";
    if (v->view == DGBGL_VIEW_LIGHT) return v->texture ? NULL : "LIGHT needs a texture";
    if (!dgb_get_texture(c, dgbgli_views[v->view].slot).id)
        return "the context does not make this texture: set the effect or target, and build layers with the library";
    if (v->view <= DGBGL_VIEW_VALIDITY && (v->layer < 0 || v->layer >= c->plan.layers)) return "there is no such layer";
    return NULL;
}

static void dgbgli_bind_view(const dgbgl_backend* b, unsigned int unit, unsigned int target, unsigned int name) {
    b->gl.ActiveTexture(DGBGLI_TEXTURE0 + unit);
    b->gl.BindTexture(target, name);
    b->gl.BindSampler(unit, b->sampler);
}

static void dgbgli_bind_views(const dgbgl_backend* b, const dgb_context* c, const dgbgl_view_desc* v) {
    const bool of_layer = v->view <= DGBGL_VIEW_VALIDITY;
    const dgb_texture texture = dgb_get_texture(c, dgbgli_views[v->view].slot);
    const unsigned int name = v->view == DGBGL_VIEW_LIGHT ? v->texture : dgbgl_texture_name(texture);
    dgbgli_bind_view(b, 0, DGBGLI_TEXTURE_2D_ARRAY, dgbgl_texture_name(dgb_get_texture(c, DGB_DEPTH)));
    dgbgli_bind_view(b, 1, DGBGLI_TEXTURE_2D_ARRAY, of_layer ? name : 0);
    dgbgli_bind_view(b, 2, DGBGLI_TEXTURE_2D, of_layer ? 0 : name);
    dgbgli_bind_view(b, 3, DGBGLI_TEXTURE_2D, dgbgl_texture_name(dgb_get_texture(c, DGB_Z)));
}

static void dgbgli_view_block(const dgb_context* c, const dgbgl_view_desc* v, int width, int height,
                              dgbgli_view_uniforms* u) {
    memset(u, 0, sizeof *u);
    u->camera = c->camera;
    u->rectangle[0] = (float)v->x;
    u->rectangle[1] = (float)v->y;
    u->rectangle[2] = (float)c->desc.width / (float)width;
    u->rectangle[3] = (float)c->desc.height / (float)height;
    u->scale[0] = v->exposure > 0.0f ? v->exposure : 1.0f;
    u->scale[1] = v->depth_range > 0.0f ? v->depth_range : 20.0f;
    u->scale[2] = c->shaded_params.history_weight;
    u->choice[0] = (int32_t)v->view;
    u->choice[1] = v->layer;
    u->choice[2] = v->layer > 0 && c->desc.divisor > 0 ? c->desc.divisor : 1;
    u->choice[3] = v->view == DGBGL_VIEW_LIGHT ? 0 : c->desc.guard_band;
    u->has[0] = dgb_get_texture(c, DGB_Z).id != 0;
}

DGB_API dgb_result dgbgl_draw_view(const dgb_context* context, const dgbgl_view_desc* view) {
    dgbgl_backend* b;
    dgbgli_view_uniforms uniforms;
    const char* fault;
    dgb_result result = DGB_DEVICE, ended;
    bool scissor;
    int width, height;
    if (!context || !view || context->backend.texture_create != dgbgli_texture_create) return DGB_INVALID;
    b = (dgbgl_backend*)context->backend.user;
    fault = dgbgli_view_fault(context, view);
    if (fault) {
        dgbgli_message(b, "view", fault);
        return DGB_INVALID;
    }
    width = view->width ? view->width : context->desc.width;
    height = view->height ? view->height : context->desc.height;
    dgbgli_view_block(context, view, width, height, &uniforms);
    scissor = b->gl.IsEnabled(DGBGLI_SCISSOR_TEST) != 0;
    if (b->gl.PushDebugGroup) b->gl.PushDebugGroup(DGBGLI_DEBUG_SOURCE_APPLICATION, 0, -1, "view");
    dgbgli_begin(b);
    if (dgbgli_make_view_program(b)) {
        dgb_program program;
        program.id = b->view_program;
        dgbgli_enable(b, DGBGLI_SCISSOR_TEST, scissor);
        dgbgli_bind_views(b, context, view);
        dgbgli_uniforms_upload(b, &uniforms, sizeof uniforms);
        b->gl.Viewport(view->x, view->y, width, height);
        b->gl.BindVertexArray(b->vertex_array);
        dgbgli_draw_fullscreen(b, program);
        result = DGB_OK;
    }
    ended = dgbgli_end(b);
    if (b->gl.PopDebugGroup) b->gl.PopDebugGroup();
    return result == DGB_OK ? ended : result;
}

/* >> init, shutdown */

#define DGBGLI_MISSING "missing entry point"

static bool dgbgli_load(dgbgl_backend* b) {
    const char* missing = NULL;
    void* address;
    /* through memcpy: ISO C has no cast from object to function pointer */
#define DGBGLI_LOAD(result, name, arguments)       \
    address = b->desc.get_proc("gl" #name);        \
    memcpy(&b->gl.name, &address, sizeof address); \
    if (!address) missing = "gl" #name;
    DGBGL_FUNCTIONS(DGBGLI_LOAD)
    if (missing) {
        dgbgli_message(b, DGBGLI_MISSING, missing);
        return false;
    }
    DGBGL_OPTIONAL_FUNCTIONS(DGBGLI_LOAD)
#undef DGBGLI_LOAD
    return true;
}

static bool dgbgli_has_extension(const dgbgl_backend* b, const char* name) {
    const int count = dgbgli_get(b, DGBGLI_NUM_EXTENSIONS);
    int i;
    for (i = 0; i < count; ++i) {
        const char* extension = (const char*)b->gl.GetStringi(DGBGLI_EXTENSIONS, (unsigned)i);
        if (extension && strcmp(extension, name) == 0) return true;
    }
    return false;
}

/* Optional entry points: since which version of OpenGL and of OpenGL ES (0: never, or of no use here) a context offers
   them, or by which extension of OpenGL. */
#define DGBGLI_OFFERS(X)                                  \
    X(IsEnabledi, 330, 320, NULL)                         \
    X(Enablei, 330, 320, NULL)                            \
    X(Disablei, 330, 320, NULL)                           \
    X(GetBooleani_v, 330, 320, NULL)                      \
    X(ColorMaski, 330, 320, NULL)                         \
    X(PolygonMode, 330, 0, NULL)                          \
    X(DepthRangef, 0, 300, NULL)                          \
    X(DepthRange, 330, 0, NULL)                           \
    X(GetFloati_v, 410, 0, "GL_ARB_viewport_array")       \
    X(GetDoublei_v, 410, 0, "GL_ARB_viewport_array")      \
    X(ViewportIndexedf, 410, 0, "GL_ARB_viewport_array")  \
    X(DepthRangeIndexed, 410, 0, "GL_ARB_viewport_array") \
    X(ClipControl, 450, 0, "GL_ARB_clip_control")         \
    X(TextureBarrier, 450, 0, "GL_ARB_texture_barrier")   \
    X(MemoryBarrier, 430, 0, NULL)                        \
    X(BindImageTexture, 430, 0, NULL)                     \
    X(FramebufferTexture, 330, 320, NULL)                 \
    X(TexStorage2D, 420, 300, "GL_ARB_texture_storage")   \
    X(TexStorage3D, 420, 300, "GL_ARB_texture_storage")   \
    X(ObjectLabel, 430, 320, "GL_KHR_debug")              \
    X(PushDebugGroup, 430, 320, "GL_KHR_debug")           \
    X(PopDebugGroup, 430, 320, "GL_KHR_debug")            \
    X(QueryCounter, 330, 0, NULL)                         \
    X(GetQueryObjectiv, 330, 0, NULL)                     \
    X(GetQueryObjectui64v, 330, 0, NULL)

static bool dgbgli_offers(const dgbgl_backend* b, int since, int since_es, const char* extension) {
    if (b->es) return since_es != 0 && b->version >= since_es;
    return (since != 0 && b->version >= since) || (extension && dgbgli_has_extension(b, extension));
}

/* Entry points of what the context does not offer may still have an address: forget them. Those of what it does offer
   must have one. */
static bool dgbgli_settle_optional(dgbgl_backend* b) {
    const char* missing = NULL;
#define DGBGLI_SETTLE(name, since, since_es, extension) \
    if (!dgbgli_offers(b, since, since_es, extension))  \
        b->gl.name = NULL;                              \
    else if (!b->gl.name)                               \
        missing = "gl" #name;
    DGBGLI_OFFERS(DGBGLI_SETTLE)
#undef DGBGLI_SETTLE
    if (missing) dgbgli_message(b, DGBGLI_MISSING, missing);
    return !missing;
}

/* What lets a vertex shader write gl_Layer, or null. GLSL takes the first from version 410 on. */
static const char* dgbgli_layer_extension(const dgbgl_backend* b) {
    static const char* const extensions[] = {"GL_ARB_shader_viewport_layer_array", "GL_AMD_vertex_shader_layer"};
    int i;
    for (i = b->version >= 410 ? 0 : 1; !b->es && i < 2; ++i)
        if (dgbgli_has_extension(b, extensions[i])) return extensions[i];
    return NULL;
}

/* Rasterisers known to run the fragments of a pixel one after the other: there compare and store are safe. */
static bool dgbgli_in_order(const dgbgl_backend* b) {
    const char* renderer = (const char*)b->gl.GetString(DGBGLI_RENDERER);
    return renderer && strstr(renderer, "llvmpipe") != NULL;
}

static void dgbgli_read_caps(dgbgl_backend* b) {
    dgb_caps* caps = &b->backend.caps;
    const bool single_pass = !b->es && !b->desc.no_single_pass && b->gl.FramebufferTexture;
    const bool geometry = single_pass && dgbgli_get(b, DGBGLI_MAX_GEOMETRY_OUTPUT_VERTICES) >= 3 * DGB_MAX_LAYERS;
    b->indexed_buffers = b->gl.ColorMaski != NULL;
    b->indexed_viewports = b->gl.ViewportIndexedf != NULL;
    b->images = b->gl.BindImageTexture != NULL;
    b->query_buffers = dgbgli_offers(b, 440, 0, "GL_ARB_query_buffer_object");
    b->layer_extension = dgbgli_layer_extension(b);
    b->interlock = b->images && b->version >= 450 && dgbgli_has_extension(b, "GL_ARB_fragment_shader_interlock");
    caps->max_size = dgbgli_get(b, DGBGLI_MAX_TEXTURE_SIZE);
    caps->max_layers = dgbgli_get(b, DGBGLI_MAX_ARRAY_TEXTURE_LAYERS);
    caps->clip_zero_to_one = b->gl.ClipControl != NULL;
    caps->deep_viewport = b->indexed_viewports;
    caps->emission[DGB_EMISSION_SEPARATE] = true;
    caps->emission[DGB_EMISSION_GEOMETRY] = geometry;
    caps->emission[DGB_EMISSION_VERTEX] = single_pass && b->layer_extension;
    caps->emission[DGB_EMISSION_INSTANCED_GEOMETRY] = geometry && b->version >= 410;
    caps->emission[DGB_EMISSION_IMAGE] = single_pass && b->images && (b->interlock || dgbgli_in_order(b));
    /* in order means a software rasteriser: there images were the fastest from 100,000 triangles on (make bench) */
    if (caps->emission[DGB_EMISSION_IMAGE] && dgbgli_in_order(b)) caps->preferred = DGB_EMISSION_IMAGE;
    caps->emission[DGB_EMISSION_MULTICAST] = single_pass && b->version >= 430 &&
                                             dgbgli_has_extension(b, "GL_NV_viewport_array2") &&
                                             dgbgli_has_extension(b, "GL_NV_geometry_shader_passthrough");
}

static void dgbgli_fill_backend(dgbgl_backend* b) {
    dgb_backend* d = &b->backend;
    d->version = DGB_VERSION;
    d->user = b;
    d->begin = dgbgli_begin;
    d->end = dgbgli_end;
    d->texture_create = dgbgli_texture_create;
    d->texture_destroy = dgbgli_texture_destroy;
    d->program_create = dgbgli_program_create;
    d->program_destroy = dgbgli_program_destroy;
    d->pass_begin = dgbgli_pass_begin;
    d->texture_bind = dgbgli_texture_bind;
    d->uniforms_upload = dgbgli_uniforms_upload;
    d->draw_fullscreen = dgbgli_draw_fullscreen;
    d->pass_end = dgbgli_pass_end;
    d->marker = dgbgli_marker;
}

/* Binding makes objects of names, and only objects can have labels. */
static void dgbgli_set_up_objects(const dgbgl_backend* b) {
    b->gl.BindVertexArray(b->vertex_array);
    b->gl.BindBuffer(DGBGLI_UNIFORM_BUFFER, b->uniform_buffer);
    b->gl.BindSampler(0, b->sampler);
    b->gl.SamplerParameteri(b->sampler, DGBGLI_TEXTURE_MIN_FILTER, DGBGLI_NEAREST);
    b->gl.SamplerParameteri(b->sampler, DGBGLI_TEXTURE_MAG_FILTER, DGBGLI_NEAREST);
    b->gl.SamplerParameteri(b->sampler, DGBGLI_TEXTURE_WRAP_S, DGBGLI_CLAMP_TO_EDGE);
    b->gl.SamplerParameteri(b->sampler, DGBGLI_TEXTURE_WRAP_T, DGBGLI_CLAMP_TO_EDGE);
    b->gl.SamplerParameteri(b->sampler, DGBGLI_TEXTURE_COMPARE_MODE, 0);
    dgbgli_label(b, DGBGLI_VERTEX_ARRAY, b->vertex_array, "fullscreen");
    dgbgli_label(b, DGBGLI_BUFFER, b->uniform_buffer, "uniforms");
    dgbgli_label(b, DGBGLI_SAMPLER, b->sampler, "nearest");
}

static dgb_result dgbgli_create_objects(dgbgl_backend* b) {
    dgb_result result;
    int pass;
    dgbgli_begin(b);
    dgbgli_drain_errors(b, DGBGLI_PENDING);
    b->gl.GenSamplers(1, &b->sampler);
    b->gl.GenVertexArrays(1, &b->vertex_array);
    b->gl.GenBuffers(1, &b->uniform_buffer);
    for (pass = 0; pass < DGB_PASS_COUNT; ++pass) {
        b->timers[pass].milliseconds = -1.0;
        if (b->gl.QueryCounter) b->gl.GenQueries(4, b->timers[pass].queries[0]);
    }
    result = b->sampler && b->vertex_array && b->uniform_buffer ? dgbgli_check(b) : dgbgli_no_object(b);
    if (result == DGB_OK) dgbgli_set_up_objects(b);
    (void)dgbgli_end(b);
    return result;
}

static bool dgbgli_is_supported(const dgbgl_backend* b) {
    if (!b->es) return b->version >= 330;
    return b->version >= 320 || (b->version >= 300 && dgbgli_has_extension(b, "GL_EXT_color_buffer_float"));
}

static void dgbgli_refuse_version(const dgbgl_backend* b) {
    char sentence[160];
    dgbgli_text t = dgbgli_text_on(sentence, sizeof sentence);
    dgbgli_put(&t, "this is OpenGL ");
    if (b->es) dgbgli_put(&t, "ES ");
    dgbgli_put_int(&t, b->version / 100);
    dgbgli_put(&t, ".");
    dgbgli_put_int(&t, b->version / 10 % 10);
    dgbgli_put(
        &t, "; needs OpenGL 3.3, or OpenGL ES 3.0 with EXT_color_buffer_float: ask for it when creating the context");
    dgbgli_message(b, "unsupported context", sentence);
}

/* Null, or what is wrong with the desc in this context. */
static const char* dgbgli_fault(const dgbgl_backend* b) {
    if (b->desc.oracle_unit < 0 || b->desc.oracle_unit >= dgbgli_get(b, DGBGLI_MAX_COMBINED_TEXTURE_IMAGE_UNITS))
        return "oracle_unit is no texture unit of this context";
    if (b->desc.uniform_binding < 0 || b->desc.uniform_binding >= dgbgli_get(b, DGBGLI_MAX_UNIFORM_BUFFER_BINDINGS))
        return "uniform_binding is no uniform buffer binding of this context";
    return NULL;
}

/* The stages of dgbgl_init that can fail, but for loading. */
static dgb_result dgbgli_start(dgbgl_backend* b) {
    const char* version = (const char*)b->gl.GetString(DGBGLI_VERSION);
    const char* fault;
    dgb_result result;
    b->es = version && strncmp(version, "OpenGL ES", 9) == 0;
    b->version = dgbgli_get(b, DGBGLI_MAJOR_VERSION) * 100 + dgbgli_get(b, DGBGLI_MINOR_VERSION) * 10;
    if (!dgbgli_is_supported(b)) {
        dgbgli_refuse_version(b);
        return DGB_UNSUPPORTED;
    }
    fault = dgbgli_fault(b);
    if (fault) {
        dgbgli_message(b, "dgbgl_init", fault);
        return DGB_INVALID;
    }
    if (!dgbgli_settle_optional(b)) return DGB_DEVICE;
    if (b->desc.no_timers) b->gl.QueryCounter = NULL;
    dgbgli_read_caps(b);
    dgbgli_fill_backend(b);
    result = dgbgli_create_objects(b);
    if (result != DGB_OK) dgbgli_message(b, "dgbgl_init", "the driver gives no sampler, vertex array or buffer");
    return result;
}

DGB_API dgb_result dgbgl_init(dgbgl_backend* gl, const dgbgl_desc* desc) {
    dgb_result result;
    if (!gl) return DGB_INVALID;
    memset(gl, 0, sizeof *gl);
    if (!desc || !desc->get_proc) return DGB_INVALID;
    gl->desc = *desc;
    if (!gl->desc.oracle_unit) gl->desc.oracle_unit = 15;
    if (!gl->desc.uniform_binding) gl->desc.uniform_binding = 23;
    result = dgbgli_load(gl) ? dgbgli_start(gl) : DGB_DEVICE;
    if (result == DGB_OK) return DGB_OK;
    dgbgl_shutdown(gl);
    memset(gl, 0, sizeof *gl);
    return result;
}

DGB_API void dgbgl_shutdown(dgbgl_backend* gl) {
    int i;
    if (!gl || !gl->backend.user) return;
    for (i = 0; i < DGBGL_MAX_FRAMEBUFFERS; ++i) dgbgli_drop_framebuffer(gl, i);
    for (i = 0; i < DGB_PASS_COUNT; ++i)
        if (gl->timers[i].queries[0][0]) gl->gl.DeleteQueries(4, gl->timers[i].queries[0]);
    if (gl->view_program) gl->gl.DeleteProgram(gl->view_program);
    gl->gl.DeleteVertexArrays(1, &gl->vertex_array);
    gl->gl.DeleteBuffers(1, &gl->uniform_buffer);
    gl->gl.DeleteSamplers(1, &gl->sampler);
    memset(gl, 0, sizeof *gl);
}

/* >> material shaders: prefix, geometry shader */

static const dgbgl_backend* dgbgli_of(const dgb_context* context) {
    return dgb_get_texture(context, DGB_DEPTH).id ? (const dgbgl_backend*)context->backend.user : NULL;
}

/* Location of each layer target: its place among the outputs of the LAYERS pass. */
static void dgbgli_put_locations(dgbgli_text* t, const dgb_plan_pass* pass) {
    int i;
    for (i = 0; i < pass->output_count; ++i) {
        const dgb_slot slot = pass->outputs[i];
        dgbgli_put_define(t,
                          slot == DGB_ALBEDO     ? "DGB_ALBEDO_LOCATION"
                          : slot == DGB_NORMAL   ? "DGB_NORMAL_LOCATION"
                          : slot == DGB_RADIANCE ? "DGB_RADIANCE_LOCATION"
                                                 : "DGB_VELOCITY_LOCATION",
                          i);
    }
}

/* The library's own varyings, passed on like the engine's. */
static const dgbgl_varying dgbgli_varyings[] = {
    {NULL, "vec4", "dgb_v_current"}, {NULL, "vec4", "dgb_v_previous"}, {"flat", "int", "dgb_v_layer"}};
#define DGBGLI_VARYING_COUNT 3

static bool dgbgli_one_of(const char* word, const char* const* words) {
    for (; *words; ++words)
        if (strcmp(word, *words) == 0) return true;
    return false;
}

static bool dgbgli_is_digit(char c) { return c >= '0' && c <= '9'; }

static bool dgbgli_is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }

/* An identifier, alone or with a positive count in brackets. */
static bool dgbgli_name_ok(const char* name) {
    if (!dgbgli_is_letter(*name)) return false;
    while (dgbgli_is_letter(*name) || dgbgli_is_digit(*name)) ++name;
    if (*name == 0) return true;
    if (*name++ != '[' || !dgbgli_is_digit(*name) || *name == '0') return false;
    while (dgbgli_is_digit(*name)) ++name;
    return name[0] == ']' && name[1] == 0;
}

/* Length of the name without its brackets. */
static size_t dgbgli_base_length(const char* name) { return strcspn(name, "["); }

static bool dgbgli_same_name(const char* a, const char* b) {
    const size_t length = dgbgli_base_length(a);
    return length == dgbgli_base_length(b) && strncmp(a, b, length) == 0;
}

/* What is wrong with a varying, or null. */
static const char* dgbgli_varying_fault(const dgbgl_varying* v, const dgbgl_backend* b, bool through_geometry) {
    static const char* const qualifiers[] = {"flat", "smooth", "noperspective", "centroid", NULL};
    static const char* const integers[] = {"int", "ivec2", "ivec3", "ivec4", "uint", "uvec2", "uvec3", "uvec4", NULL};
    static const char* const floats[] = {"float",  "vec2",   "vec3",   "vec4",   "mat2",   "mat3",
                                         "mat4",   "mat2x2", "mat2x3", "mat2x4", "mat3x2", "mat3x3",
                                         "mat3x4", "mat4x2", "mat4x3", "mat4x4", NULL};
    if (!v->name || !v->name[0] || !v->type) return "a varying needs a type and a name";
    if (strncmp(v->name, "dgb_", 4) == 0 || strncmp(v->name, "gl_", 3) == 0) return "names with dgb_ and gl_ are taken";
    if (v->qualifier && !dgbgli_one_of(v->qualifier, qualifiers))
        return "the qualifier is not flat, smooth, noperspective, centroid";
    if (dgbgli_one_of(v->type, integers)) {
        if (!v->qualifier || strcmp(v->qualifier, "flat") != 0) return "an integer varying must be flat";
    } else if (!dgbgli_one_of(v->type, floats)) {
        return "the type is not a float, int or uint scalar or vector, or a float matrix";
    }
    if (strchr(v->name, '[') && through_geometry && b->version < 430)
        return "arrays through a geometry shader need OpenGL 4.3";
    return dgbgli_name_ok(v->name) ? NULL : "the name is no GLSL identifier, with or without [count]";
}

static bool dgbgli_varyings_ok(const dgbgl_backend* b, const dgbgl_varying* varyings, int count,
                               bool through_geometry) {
    int i, k;
    if (count < 0 || (count > 0 && !varyings)) return false;
    for (i = 0; i < count; ++i) {
        const char* fault = dgbgli_varying_fault(&varyings[i], b, through_geometry);
        for (k = 0; !fault && k < i; ++k)
            if (dgbgli_same_name(varyings[k].name, varyings[i].name)) fault = "two varyings have this name";
        if (!fault) continue;
        dgbgli_message(b, varyings[i].name ? varyings[i].name : "varying", fault);
        return false;
    }
    return true;
}

/* The name without its brackets. */
static void dgbgli_put_base(dgbgli_text* t, const dgbgl_varying* v) {
    dgbgli_put_part(t, v->name, dgbgli_base_length(v->name));
}

/* Behind a geometry shader the fragment shader reads dgb_g_NAME, so that its text need not change. */
static void dgbgli_put_renames(dgbgli_text* t, const dgbgl_varying* varyings, int count) {
    int i;
    for (i = 0; i < count; ++i) {
        dgbgli_put(t, "#define ");
        dgbgli_put_base(t, &varyings[i]);
        dgbgli_put(t, " dgb_g_");
        dgbgli_put_base(t, &varyings[i]);
        dgbgli_put(t, "\n");
    }
}

static void dgbgli_put_extension(dgbgli_text* t, const char* name) {
    dgbgli_put(t, "#extension ");
    dgbgli_put(t, name);
    dgbgli_put(t, " : require\n");
}

static void dgbgli_put_extensions(dgbgli_text* t, dgb_emission emission, const dgbgl_backend* b, dgbgl_stage stage) {
    if (emission == DGB_EMISSION_VERTEX && stage == DGBGL_VERTEX) dgbgli_put_extension(t, b->layer_extension);
    if (emission == DGB_EMISSION_IMAGE && stage == DGBGL_FRAGMENT && b->interlock)
        dgbgli_put_extension(t, "GL_ARB_fragment_shader_interlock");
    if (emission == DGB_EMISSION_MULTICAST && stage == DGBGL_GEOMETRY) {
        dgbgli_put_extension(t, "GL_NV_viewport_array2");
        dgbgli_put_extension(t, "GL_NV_geometry_shader_passthrough");
    }
}

/* As dgb_draw_uniforms.size[3]: what a fixed-point depth buffer can tell apart, less one. */
static int dgbgli_depth_codes(dgb_format format) {
    return format == DGB_FORMAT_D16 ? 65535 : format == DGB_FORMAT_D24 ? 16777215 : 0;
}

static void dgbgli_put_head(dgbgli_text* t, const dgb_context* context, const dgbgl_backend* b, dgbgl_stage stage) {
    const dgb_emission emission = context->plan.emission;
    dgbgli_put_version(t, b->version, b->es);
    dgbgli_put_extensions(t, emission, b, stage);
    dgbgli_put_precision(t, b->es);
    dgbgli_put_define(t, "DGB_LAYERS", context->plan.layers);
    dgbgli_put_define(t, "DGB_KEEP_TEST", context->plan.layers > 1 || dgb_get_texture(context, DGB_BACK).id != 0);
    dgbgli_put_define(t, "DGB_DIVISOR", context->desc.divisor);
    dgbgli_put_define(t, "DGB_REVERSED", context->desc.reversed);
    dgbgli_put_define(t, "DGB_DEPTH_CODES", dgbgli_depth_codes(context->desc.depth_format));
    dgbgli_put_define(t, "DGB_EMISSION_SEPARATE", emission == DGB_EMISSION_SEPARATE);
    dgbgli_put_define(t, "DGB_EMISSION_VERTEX", emission == DGB_EMISSION_VERTEX);
    dgbgli_put_define(t, "DGB_EMISSION_IMAGE", emission == DGB_EMISSION_IMAGE);
    dgbgli_put_define(t, "DGB_EMISSION_MULTICAST", emission == DGB_EMISSION_MULTICAST);
    dgbgli_put_define(t, "DGB_INTERLOCK", b->interlock);
    dgbgli_put_chunks(t, dgbgli_glsl_common);
    dgbgli_put_chunks(t, dgbgli_glsl_layers);
}

/* Emissions whose geometry shader passes varyings on under another name. */
static bool dgbgli_renames(dgb_emission emission) {
    return emission == DGB_EMISSION_GEOMETRY || emission == DGB_EMISSION_INSTANCED_GEOMETRY;
}

DGB_API size_t dgbgl_shader_prefix(const dgb_context* context, dgbgl_stage stage, const dgbgl_varying* varyings,
                                   int count, char* text, size_t capacity) {
    const dgbgl_backend* b = dgbgli_of(context);
    dgbgli_text t = dgbgli_text_on(text, capacity);
    if (!b || !dgbgli_varyings_ok(b, varyings, count, dgbgli_renames(context->plan.emission))) return 0;
    dgbgli_put_head(&t, context, b, stage);
    if (stage == DGBGL_VERTEX) dgbgli_put_chunks(&t, dgbgli_glsl_layers_vertex);
    if (stage == DGBGL_FRAGMENT) {
        if (dgbgli_renames(context->plan.emission)) {
            dgbgli_put_renames(&t, dgbgli_varyings, DGBGLI_VARYING_COUNT);
            dgbgli_put_renames(&t, varyings, count);
        }
        dgbgli_put_locations(&t, dgbgli_layers_pass(&context->plan));
        dgbgli_put_chunks(&t, dgbgli_glsl_layers_fragment);
    }
    dgbgli_put(&t, "#line 1\n");
    return t.length;
}

/* "flat out int dgb_g_v[3];" or "flat in int v[][3];" */
static void dgbgli_put_declaration(dgbgli_text* t, const dgbgl_varying* v, bool out) {
    if (v->qualifier) dgbgli_put(t, v->qualifier);
    dgbgli_put(t, out ? " out " : " in ");
    dgbgli_put(t, v->type);
    dgbgli_put(t, out ? " dgb_g_" : " ");
    dgbgli_put_base(t, v);
    if (!out) dgbgli_put(t, "[]");
    dgbgli_put(t, v->name + dgbgli_base_length(v->name));
    dgbgli_put(t, ";\n");
}

static void dgbgli_put_declarations(dgbgli_text* t, const dgbgl_varying* varyings, int count) {
    int i;
    for (i = 0; i < count; ++i) {
        dgbgli_put_declaration(t, &varyings[i], false);
        dgbgli_put_declaration(t, &varyings[i], true);
    }
}

static void dgbgli_put_copies(dgbgli_text* t, const dgbgl_varying* varyings, int count) {
    int i;
    for (i = 0; i < count; ++i) {
        dgbgli_put(t, "            dgb_g_");
        dgbgli_put_base(t, &varyings[i]);
        dgbgli_put(t, " = ");
        dgbgli_put_base(t, &varyings[i]);
        dgbgli_put(t, "[i];\n");
    }
}

/* The body that copies one triangle to `layer`. */
static void dgbgli_put_triangle(dgbgli_text* t, const dgb_context* context, const dgbgl_varying* varyings, int count) {
    dgbgli_put(t, "        for (int i = 0; i < 3; ++i) {\n");
    dgbgli_put_copies(t, dgbgli_varyings, DGBGLI_VARYING_COUNT);
    dgbgli_put_copies(t, varyings, count);
    dgbgli_put(t, "            dgb_g_dgb_v_layer = layer;\n"
                  "            gl_Layer = layer;\n");
    if (context->desc.divisor > 1)
        dgbgli_put(t, "            gl_ViewportIndex = dgb_draw_layer.y > 1 && layer > 0 ? 1 : 0;\n");
    dgbgli_put(t, "            gl_Position = gl_in[i].gl_Position;\n"
                  "            EmitVertex();\n"
                  "        }\n"
                  "        EndPrimitive();\n");
}

/* In a loop over the layers, or, instanced, one invocation a layer. */
static void dgbgli_put_emission(dgbgli_text* t, const dgb_context* context, const dgbgl_varying* varyings, int count) {
    const bool instanced = context->plan.emission == DGB_EMISSION_INSTANCED_GEOMETRY;
    dgbgli_put(t, "layout(triangles");
    if (instanced) {
        dgbgli_put(t, ", invocations = ");
        dgbgli_put_int(t, context->plan.layers);
    }
    dgbgli_put(t, ") in;\nlayout(triangle_strip, max_vertices = ");
    dgbgli_put_int(t, instanced ? 3 : 3 * context->plan.layers);
    dgbgli_put(t, ") out;\n");
    dgbgli_put_declarations(t, dgbgli_varyings, DGBGLI_VARYING_COUNT);
    dgbgli_put_declarations(t, varyings, count);
    dgbgli_put(
        t, instanced
               ? "void main() {\n"
                 "    int layer = dgb_draw_layer.x + gl_InvocationID;\n"
                 "    if (gl_InvocationID < dgb_draw_layer.y) {\n"
               : "void main() {\n"
                 "    for (int layer = dgb_draw_layer.x; layer < dgb_draw_layer.x + dgb_draw_layer.y; ++layer) {\n");
    dgbgli_put_triangle(t, context, varyings, count);
    dgbgli_put(t, "    }\n}\n");
}

static void dgbgli_put_passthrough(dgbgli_text* t, const dgbgl_varying* varyings, int count) {
    int i;
    for (i = 0; i < count; ++i) {
        dgbgli_put(t, "layout(passthrough) ");
        dgbgli_put_declaration(t, &varyings[i], false);
    }
}

/* The hardware sends the triangle to every viewport of the mask, and to the layer of the viewport's number. */
static void dgbgli_put_multicast(dgbgli_text* t, const dgbgl_varying* varyings, int count) {
    dgbgli_put(t, "layout(triangles) in;\n"
                  "layout(passthrough) in gl_PerVertex { vec4 gl_Position; } gl_in[];\n"
                  "layout(viewport_relative) out int gl_Layer;\n");
    dgbgli_put_passthrough(t, dgbgli_varyings, DGBGLI_VARYING_COUNT - 1); /* the layer is the hardware's */
    dgbgli_put_passthrough(t, varyings, count);
    dgbgli_put(t, "void main() {\n"
                  "    gl_ViewportMask[0] = (1 << dgb_draw_layer.y) - 1;\n"
                  "    gl_Layer = 0;\n"
                  "}\n");
}

DGB_API size_t dgbgl_geometry_shader(const dgb_context* context, const dgbgl_varying* varyings, int count, char* text,
                                     size_t capacity) {
    const dgbgl_backend* b = dgbgli_of(context);
    dgbgli_text t = dgbgli_text_on(text, capacity);
    if (!b || !dgbgli_varyings_ok(b, varyings, count, dgbgli_renames(context->plan.emission))) return 0;
    if (!dgbgli_renames(context->plan.emission) && context->plan.emission != DGB_EMISSION_MULTICAST) return 0;
    dgbgli_put_head(&t, context, b, DGBGL_GEOMETRY);
    if (context->plan.emission == DGB_EMISSION_MULTICAST)
        dgbgli_put_multicast(&t, varyings, count);
    else
        dgbgli_put_emission(&t, context, varyings, count);
    return t.length;
}

DGB_API dgb_result dgbgl_attach_program(const dgb_context* context, unsigned int program) {
    const dgbgl_backend* b = dgbgli_of(context);
    int current, linked = 0;
    if (!b || !b->gl.IsProgram(program)) return DGB_INVALID;
    b->gl.GetProgramiv(program, DGBGLI_LINK_STATUS, &linked);
    if (!linked) return DGB_INVALID;
    current = dgbgli_get(b, DGBGLI_CURRENT_PROGRAM);
    dgbgli_connect_samplers(b, program);
    dgbgli_connect_block(b, program, "draw");
    if (context->plan.emission == DGB_EMISSION_IMAGE) dgbgli_connect_images(b, &context->plan, program);
    /* as in restoring the state: a program deleted while in use is gone by now */
    b->gl.UseProgram(b->gl.IsProgram((unsigned)current) ? (unsigned)current : 0);
    return DGB_OK;
}

/* >> calibration */

static double dgbgli_now(const dgbgl_backend* b) {
    int64_t nanoseconds = 0;
    b->gl.Finish();
    b->gl.GetInteger64v(DGBGLI_TIMESTAMP, &nanoseconds);
    return (double)nanoseconds * 1e-6;
}

/* The least time of a frame of layers, ms; < 0 when this emission cannot be used. */
static double dgbgli_time_emission(dgbgl_backend* b, const dgbgl_calibration* k, const dgb_desc* desc) {
    const int warm_up = 3, frames = k->frames > 0 ? k->frames : 8;
    double least = -1.0;
    dgb_context context;
    int i;
    if (dgb_init(&context, desc) != DGB_OK) return -1.0;
    if (k->prepare(k->user, &context)) {
        for (i = 0; i < warm_up + frames; ++i) {
            const double before = dgbgli_now(b);
            const dgb_result result = dgb_build(&context, k->view, k->params, k->draw, k->user);
            const double taken = dgbgli_now(b) - before;
            if (result != DGB_OK) break;
            if (i >= warm_up && (least < 0.0 || taken < least)) least = taken;
        }
        if (k->release) k->release(k->user);
    }
    dgb_shutdown(&context);
    return least;
}

DGB_API dgb_result dgbgl_calibrate(dgbgl_backend* gl, const dgbgl_calibration* calibration, dgb_desc* desc,
                                   double milliseconds[DGB_EMISSION_COUNT]) {
    dgb_desc candidate;
    double best_time = -1.0;
    dgb_emission best = DGB_EMISSION_AUTO;
    int emission;
    if (!gl || !gl->backend.user || !calibration || !calibration->view || !calibration->params ||
        !calibration->prepare || !calibration->draw || !desc)
        return DGB_INVALID;
    if (gl->es) return DGB_UNSUPPORTED;
    candidate = *desc;
    candidate.effects = 0; /* the layers alone */
    candidate.backend = &gl->backend;
    for (emission = DGB_EMISSION_SEPARATE; emission < DGB_EMISSION_COUNT; ++emission) {
        double taken = -1.0;
        candidate.emission = (dgb_emission)emission;
        if (gl->backend.caps.emission[emission]) taken = dgbgli_time_emission(gl, calibration, &candidate);
        if (milliseconds) milliseconds[emission] = taken;
        if (taken < 0.0 || (best_time >= 0.0 && taken >= best_time)) continue;
        best_time = taken;
        best = (dgb_emission)emission;
    }
    if (milliseconds) milliseconds[DGB_EMISSION_AUTO] = best_time;
    if (best_time < 0.0) return DGB_UNSUPPORTED;
    desc->emission = best;
    if (best == DGB_EMISSION_SEPARATE && desc->oracle == DGB_ORACLE_DEFAULT) desc->oracle = DGB_ORACLE_PEEL;
    return DGB_OK;
}

#ifdef __cplusplus
}
#endif

#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

#endif /* DEEPGBUFFER_IMPLEMENTATION */
