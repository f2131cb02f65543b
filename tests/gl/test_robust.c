/* Engines that misbehave, and frames that are no ordinary ones: every oracle and emission goes on with a defined result. */
#include "gl_fixture.h"
#include "numbers.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { WIDTH = 72, HEIGHT = 48, GUARD = 8 };

static fixture f;

/* >> constructions */

typedef struct construction {
    dgb_oracle oracle;
    dgb_emission emission;
    int layers, divisor;
} construction;

typedef void (*construction_check)(const construction* c);

static construction running; /* for messages */

static const char* running_name(void) {
    static char name[96];
    snprintf(name, sizeof name, "%s, %s, %d layers, 1/%d", dgb_oracle_name(running.oracle),
             dgb_emission_name(running.emission), running.layers, running.divisor);
    return name;
}

static bool is_offered(const construction* c) {
    const bool divides = c->emission != DGB_EMISSION_IMAGE && c->emission != DGB_EMISSION_MULTICAST;
    if (c->oracle == DGB_ORACLE_PEEL && c->emission != DGB_EMISSION_SEPARATE) return false;
    return f.gl.backend.caps.emission[c->emission] && (divides || c->divisor == 1);
}

/* Two layers of the whole resolution, three of a lower one. */
static void for_every_construction(construction_check check) {
    int oracle, emission, kind, count = 0;
    for (oracle = DGB_ORACLE_PEEL; oracle < DGB_ORACLE_COUNT; ++oracle)
        for (emission = DGB_EMISSION_SEPARATE; emission < DGB_EMISSION_COUNT; ++emission)
            for (kind = 0; kind < 2; ++kind) {
                construction c;
                c.oracle = (dgb_oracle)oracle;
                c.emission = (dgb_emission)emission;
                c.layers = 2 + kind;
                c.divisor = 1 + kind;
                if (!is_offered(&c)) continue;
                running = c;
                check(&c);
                ++count;
            }
    assert_true(count >= 10); /* SEPARATE, wherever this runs */
}

/* >> an engine: a context, its material, and what it does wrong */

typedef struct engine {
    fixture_draw_user user; /* first: it is what fixture_draw takes */
    construction c;
    dgb_context context;
    dgb_params params;
    dgb_log_item logged;
    GLuint depth_program; /* has no dgb_store */
    bool wild;            /* scrambles the state after every draw */
    bool no_store;        /* draws with depth_program */
    bool masks[4];        /* leaves these targets out */
    int unready;          /* draw callbacks that did not find what they may count on */
} engine;

static void on_log(void* user, dgb_result result, dgb_log_item item, const char* sentence) {
    (void)result, (void)sentence;
    ((engine*)user)->logged = item;
}

static dgb_desc desc_of(const construction* c) {
    const fixture_view v = fixture_default_view();
    dgb_desc d = fixture_desc(&f, &v, WIDTH, HEIGHT, GUARD);
    d.log = NULL;
    d.layers = c->layers;
    d.divisor = c->divisor;
    d.oracle = c->oracle;
    d.emission = c->emission;
    d.effects = DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY;
    return d;
}

static GLuint compile(GLenum stage, const char* prefix, const char* body) {
    const char* text[2];
    GLuint shader = glCreateShader(stage);
    GLint ok = 0;
    text[0] = prefix;
    text[1] = body;
    glShaderSource(shader, 2, text, NULL);
    glCompileShader(shader);
    glGetShaderiv(shader, GL_COMPILE_STATUS, &ok);
    assert_true(ok);
    return shader;
}

/* The fixture's geometry, and nothing but depth. */
static GLuint make_depth_program(const dgb_context* context) {
    static const char vertex_body[] =
        "layout(location = 0) in vec3 position;\n"
        "uniform mat4 view, projection, previous_view, previous_projection; uniform vec3 offset, previous_offset;\n"
        "void main() {\n"
        "    dgb_vertex(projection * (view * vec4(position + offset, 1.0)),\n"
        "               previous_projection * (previous_view * vec4(position + previous_offset, 1.0)));\n"
        "}\n";
    static const char fragment_body[] = "void main() { if (!dgb_keep()) discard; }\n";
    static char prefix[1 << 16];
    const GLuint program = glCreateProgram();
    GLuint shader;
    assert_true(dgbgl_shader_prefix(context, DGBGL_VERTEX, NULL, 0, prefix, sizeof prefix) > 0);
    glAttachShader(program, shader = compile(GL_VERTEX_SHADER, prefix, vertex_body));
    glDeleteShader(shader);
    if (dgbgl_geometry_shader(context, NULL, 0, prefix, sizeof prefix)) {
        glAttachShader(program, shader = compile(GL_GEOMETRY_SHADER, prefix, ""));
        glDeleteShader(shader);
    }
    assert_true(dgbgl_shader_prefix(context, DGBGL_FRAGMENT, NULL, 0, prefix, sizeof prefix) > 0);
    glAttachShader(program, shader = compile(GL_FRAGMENT_SHADER, prefix, fragment_body));
    glDeleteShader(shader);
    glLinkProgram(program);
    assert_int_equal(dgbgl_attach_program(context, program), DGB_OK);
    return program;
}

static void start(engine* e, const construction* c) {
    dgb_desc d = desc_of(c);
    memset(e, 0, sizeof *e);
    e->c = *c;
    e->user.f = &f;
    d.log = on_log;
    d.log_user = e;
    e->params = dgb_preset(DGB_PRESET_BALANCED);
    e->params.guard_fraction = 1.0f; /* every pixel of every result is written */
    assert_int_equal(dgb_init(&e->context, &d), DGB_OK);
    e->user.program = fixture_program(&e->context);
    assert_true(e->user.program != 0);
}

static void stop(engine* e) {
    glDeleteProgram(e->user.program);
    if (e->depth_program) glDeleteProgram(e->depth_program);
    dgb_shutdown(&e->context);
}

/* The camera walks and turns, the box moves, and the next view is known. */
static dgb_view view_at(int frame, int width, int height) {
    fixture_view v = fixture_default_view(), next;
    dgb_view view;
    int i;
    v.eye[0] += 0.05f * (float)frame;
    v.yaw += 0.01f * (float)frame;
    next = v;
    next.eye[0] += 0.05f;
    next.yaw += 0.01f;
    for (i = 0; i < 4; ++i) f.offsets[i] = 0.1f * (float)(frame + i - 2);
    view = fixture_dgb_view(&v, width, height);
    view.has_next = true;
    memcpy(view.next_view, fixture_dgb_view(&next, width, height).view, sizeof view.next_view);
    return view;
}

/* >> state: everything that the library promises to restore, scrambled and compared */

static uint32_t random_state;

static unsigned random_below(unsigned n) { return (lcg(&random_state) >> 8) % n; }

static const GLenum capabilities[] = {GL_DEPTH_TEST,          GL_STENCIL_TEST,
                                      GL_CULL_FACE,           GL_DITHER,
                                      GL_POLYGON_OFFSET_FILL, GL_SAMPLE_ALPHA_TO_COVERAGE,
                                      GL_SAMPLE_COVERAGE,     GL_RASTERIZER_DISCARD,
                                      GL_SAMPLE_MASK,         GL_PRIMITIVE_RESTART_FIXED_INDEX,
                                      GL_COLOR_LOGIC_OP,      GL_MULTISAMPLE,
                                      GL_DEPTH_CLAMP,         GL_PRIMITIVE_RESTART,
                                      GL_FRAMEBUFFER_SRGB,    GL_CLIP_DISTANCE0,
                                      GL_CLIP_DISTANCE0 + 2,  GL_CLIP_DISTANCE0 + 7};
enum { CAPABILITY_COUNT = 18, LAST_UNIT = 15, BINDING = 23, IMAGE_UNITS = 5 };

typedef struct objects { /* an engine's own */
    GLuint framebuffers[2], textures[2], arrays[2], images[2], samplers[2], buffers[2], vertex_array;
} objects;

static objects own;

static void make_objects(objects* o) {
    int i;
    glGenFramebuffers(2, o->framebuffers);
    glGenTextures(2, o->textures);
    glGenTextures(2, o->arrays);
    glGenTextures(2, o->images);
    glGenSamplers(2, o->samplers);
    glGenBuffers(2, o->buffers);
    glGenVertexArrays(1, &o->vertex_array);
    for (i = 0; i < 2; ++i) {
        glBindTexture(GL_TEXTURE_2D, o->textures[i]);
        glBindTexture(GL_TEXTURE_2D_ARRAY, o->arrays[i]);
        glTexStorage3D(GL_TEXTURE_2D_ARRAY, 1, GL_R32F, 4, 4, 2);
        glBindTexture(GL_TEXTURE_2D, o->images[i]);
        glTexStorage2D(GL_TEXTURE_2D, 2, GL_RGBA8, 8, 8);
        glSamplerParameteri(o->samplers[i], GL_TEXTURE_MIN_FILTER, GL_LINEAR);
        glSamplerParameteri(o->samplers[i], GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
        glBindBuffer(GL_UNIFORM_BUFFER, o->buffers[i]);
        glBufferData(GL_UNIFORM_BUFFER, 4096, NULL, GL_STATIC_DRAW);
        glBindFramebuffer(GL_FRAMEBUFFER, o->framebuffers[i]);
    }
    glBindTexture(GL_TEXTURE_2D, 0);
    glBindTexture(GL_TEXTURE_2D_ARRAY, 0);
    glBindBuffer(GL_UNIFORM_BUFFER, 0);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
}

static void delete_objects(objects* o) {
    glDeleteFramebuffers(2, o->framebuffers);
    glDeleteTextures(2, o->textures);
    glDeleteTextures(2, o->arrays);
    glDeleteTextures(2, o->images);
    glDeleteSamplers(2, o->samplers);
    glDeleteBuffers(2, o->buffers);
    glDeleteVertexArrays(1, &o->vertex_array);
}

static void enable(GLenum name, bool on) {
    if (on)
        glEnable(name);
    else
        glDisable(name);
}

static void scramble_raster(void) {
    static const GLenum functions[] = {GL_NEVER, GL_NOTEQUAL, GL_GEQUAL, GL_ALWAYS};
    static const GLenum modes[] = {GL_LINE, GL_POINT, GL_FILL};
    GLuint i;
    for (i = 0; i < CAPABILITY_COUNT; ++i) enable(capabilities[i], random_below(2) == 0);
    for (i = 0; i < 16; ++i) {
        glViewportIndexedf(i, (float)random_below(9), 2.5f, (float)random_below(40), (float)random_below(40));
        glDepthRangeIndexed(i, 0.01 * random_below(100), 0.01 * random_below(100));
        glScissorIndexed(i, 1, 1, 3, 3);
        if (random_below(2))
            glEnablei(GL_SCISSOR_TEST, i);
        else
            glDisablei(GL_SCISSOR_TEST, i);
    }
    for (i = 0; i < 8; ++i) {
        if (random_below(2))
            glEnablei(GL_BLEND, i);
        else
            glDisablei(GL_BLEND, i);
        glColorMaski(i, random_below(2) == 0, random_below(2) == 0, random_below(2) == 0, random_below(2) == 0);
    }
    glBlendFunc(GL_ONE, GL_ONE);
    glBlendEquation(GL_FUNC_REVERSE_SUBTRACT);
    glDepthMask(random_below(2) == 0);
    glDepthFunc(functions[random_below(4)]);
    glPolygonMode(GL_FRONT_AND_BACK, modes[random_below(3)]);
    glPolygonOffset(50.0f, 50.0f);
    glCullFace(GL_FRONT_AND_BACK);
    glFrontFace(random_below(2) ? GL_CW : GL_CCW);
    glProvokingVertex(random_below(2) ? GL_FIRST_VERTEX_CONVENTION : GL_LAST_VERTEX_CONVENTION);
    glLogicOp(GL_INVERT);
    glStencilFunc(GL_NEVER, 1, 0xff);
    glStencilOp(GL_INVERT, GL_INVERT, GL_INVERT);
    glSampleMaski(0, 0);
    glSampleCoverage(0.0f, GL_TRUE);
    glPrimitiveRestartIndex(0);
    glPointSize(5.0f);
    glClearDepth(0.25);
    glClearColor(1.0f, 0.5f, 0.25f, 1.0f);
    glClipControl(random_below(2) ? GL_UPPER_LEFT : GL_LOWER_LEFT,
                  random_below(2) ? GL_ZERO_TO_ONE : GL_NEGATIVE_ONE_TO_ONE);
}

static void scramble_bindings(const objects* o) {
    GLuint unit;
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, o->framebuffers[random_below(2)]);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, o->framebuffers[random_below(2)]);
    glUseProgram(0);
    glBindVertexArray(random_below(2) ? o->vertex_array : 0);
    for (unit = 0; unit < 32; ++unit)
        glBindBufferRange(GL_UNIFORM_BUFFER, unit, o->buffers[random_below(2)], 256 * (GLintptr)random_below(4), 512);
    glBindBuffer(GL_UNIFORM_BUFFER, o->buffers[random_below(2)]);
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, o->buffers[random_below(2)]);
    for (unit = 0; unit < 8; ++unit)
        glBindImageTexture(unit, o->images[random_below(2)], (GLint)random_below(2), GL_FALSE, 0, GL_READ_ONLY,
                           GL_RGBA8);
    for (unit = 0; unit <= LAST_UNIT; ++unit) {
        glActiveTexture(GL_TEXTURE0 + unit);
        glBindTexture(GL_TEXTURE_2D, o->textures[random_below(2)]);
        glBindTexture(GL_TEXTURE_2D_ARRAY, o->arrays[random_below(2)]);
        glBindSampler(unit, o->samplers[random_below(2)]);
    }
    glActiveTexture(GL_TEXTURE0 + random_below(16));
    glPixelStorei(GL_UNPACK_ROW_LENGTH, (GLint)random_below(9));
    glPixelStorei(GL_UNPACK_SKIP_ROWS, (GLint)random_below(9));
    glPixelStorei(GL_UNPACK_SKIP_PIXELS, (GLint)random_below(9));
    glPixelStorei(GL_UNPACK_ALIGNMENT, 8);
    glPixelStorei(GL_UNPACK_IMAGE_HEIGHT, (GLint)random_below(9));
    glPixelStorei(GL_UNPACK_SKIP_IMAGES, (GLint)random_below(9));
}

static void scramble(void) {
    scramble_raster();
    scramble_bindings(&own);
}

typedef struct snapshot {
    char text[32768];
    size_t length;
} snapshot;

static void note(snapshot* s, const char* what, unsigned index, double value) {
    s->length +=
        (size_t)snprintf(s->text + s->length, sizeof s->text - s->length, "%s[%u] = %.9g\n", what, index, value);
    assert_true(s->length < sizeof s->text);
}

static void note_integer(snapshot* s, GLenum name, const char* label) {
    GLint v[4] = {0, 0, 0, 0};
    glGetIntegerv(name, v);
    note(s, label, 0, v[0]);
}
#define NOTE(name) note_integer(s, name, #name)

static void note_indexed(snapshot* s) {
    GLuint i;
    int k;
    for (i = 0; i < 16; ++i) {
        GLfloat viewport[4];
        GLdouble range[2];
        glGetFloati_v(GL_VIEWPORT, i, viewport);
        glGetDoublei_v(GL_DEPTH_RANGE, i, range);
        for (k = 0; k < 4; ++k) note(s, "viewport", i, (double)viewport[k]);
        note(s, "depth_range.near", i, range[0]);
        note(s, "depth_range.far", i, range[1]);
        note(s, "scissor", i, glIsEnabledi(GL_SCISSOR_TEST, i));
    }
    for (i = 0; i < 8; ++i) {
        GLboolean mask[4];
        glGetBooleani_v(GL_COLOR_WRITEMASK, i, mask);
        note(s, "blend", i, glIsEnabledi(GL_BLEND, i));
        note(s, "color_mask", i, mask[0] * 8 + mask[1] * 4 + mask[2] * 2 + mask[3]);
    }
}

/* The units of the full-screen passes and that of the oracle. */
static void note_units(snapshot* s) {
    static const GLenum properties[] = {GL_IMAGE_BINDING_NAME,  GL_IMAGE_BINDING_LEVEL,  GL_IMAGE_BINDING_LAYERED,
                                        GL_IMAGE_BINDING_LAYER, GL_IMAGE_BINDING_ACCESS, GL_IMAGE_BINDING_FORMAT};
    GLint active, value;
    GLuint unit, k;
    glGetIntegerv(GL_ACTIVE_TEXTURE, &active);
    note(s, "active_texture", 0, active);
    for (unit = 0; unit <= LAST_UNIT; unit += unit == 5 ? 10 : 1) {
        glActiveTexture(GL_TEXTURE0 + unit);
        glGetIntegerv(GL_TEXTURE_BINDING_2D, &value);
        note(s, "texture_2d", unit, value);
        glGetIntegerv(GL_TEXTURE_BINDING_2D_ARRAY, &value);
        note(s, "texture_2d_array", unit, value);
        glGetIntegerv(GL_SAMPLER_BINDING, &value);
        note(s, "sampler", unit, value);
    }
    glActiveTexture((GLenum)active);
    for (unit = 0; unit < IMAGE_UNITS; ++unit)
        for (k = 0; k < 6; ++k) {
            glGetIntegeri_v(properties[k], unit, &value);
            note(s, "image", unit, value);
        }
}

static void take_snapshot(snapshot* s) {
    GLint buffer;
    GLint64 start, size;
    GLuint i;
    memset(s, 0, sizeof *s);
    NOTE(GL_DRAW_FRAMEBUFFER_BINDING);
    NOTE(GL_READ_FRAMEBUFFER_BINDING);
    NOTE(GL_DEPTH_WRITEMASK);
    NOTE(GL_DEPTH_FUNC);
    NOTE(GL_POLYGON_MODE);
    NOTE(GL_CLIP_ORIGIN);
    NOTE(GL_CLIP_DEPTH_MODE);
    NOTE(GL_CURRENT_PROGRAM);
    NOTE(GL_VERTEX_ARRAY_BINDING);
    NOTE(GL_UNIFORM_BUFFER_BINDING);
    NOTE(GL_PIXEL_UNPACK_BUFFER_BINDING);
    NOTE(GL_UNPACK_ROW_LENGTH);
    NOTE(GL_UNPACK_SKIP_ROWS);
    NOTE(GL_UNPACK_SKIP_PIXELS);
    NOTE(GL_UNPACK_ALIGNMENT);
    NOTE(GL_UNPACK_IMAGE_HEIGHT);
    NOTE(GL_UNPACK_SKIP_IMAGES);
    for (i = 0; i < CAPABILITY_COUNT; ++i) note(s, "capability", i, glIsEnabled(capabilities[i]));
    glGetIntegeri_v(GL_UNIFORM_BUFFER_BINDING, BINDING, &buffer);
    glGetInteger64i_v(GL_UNIFORM_BUFFER_START, BINDING, &start);
    glGetInteger64i_v(GL_UNIFORM_BUFFER_SIZE, BINDING, &size);
    note(s, "uniform_buffer", BINDING, buffer);
    note(s, "uniform_start", BINDING, (double)start);
    note(s, "uniform_size", BINDING, (double)size);
    note_indexed(s);
    note_units(s);
}

static void expect_same(const snapshot* before, const char* after_what) {
    static snapshot after;
    const char *a = before->text, *b = after.text;
    take_snapshot(&after);
    while (*a && *a == *b) ++a, ++b;
    if (*a == *b) return;
    while (a > before->text && a[-1] != '\n') --a, --b;
    fail_msg("%s: %s changed the state: %.*s became %.*s", running_name(), after_what, (int)strcspn(a, "\n"), a,
             (int)strcspn(b, "\n"), b);
}

/* >> the draw callback */

static bool is_integer(GLenum name, GLint expected) {
    GLint v[4] = {0, 0, 0, 0};
    glGetIntegerv(name, v);
    return v[0] == expected;
}

static bool is_indexed_state_ready(void) {
    GLuint i;
    for (i = 0; i < 16; ++i) {
        GLdouble range[2];
        glGetDoublei_v(GL_DEPTH_RANGE, i, range);
        if (glIsEnabledi(GL_SCISSOR_TEST, i) || range[0] != 0.0 || range[1] != 1.0) return false;
    }
    for (i = 0; i < 8; ++i) {
        GLboolean mask[4];
        glGetBooleani_v(GL_COLOR_WRITEMASK, i, mask);
        if (glIsEnabledi(GL_BLEND, i) || !mask[0] || !mask[1] || !mask[2] || !mask[3]) return false;
    }
    return true;
}

static bool is_viewport(GLuint i, float width, float height) {
    GLfloat v[4];
    glGetFloati_v(GL_VIEWPORT, i, v);
    return v[0] == 0.0f && v[1] == 0.0f && v[2] == width && v[3] == height;
}

static bool are_viewports_ready(const engine* e, const dgb_draw* draw) {
    const float w = (float)draw->width, h = (float)draw->height, scale = e->c.divisor == 2 ? 0.5f : 1.0f;
    if (draw->layer_count == 1 && draw->first_layer > 0) return is_viewport(0, w * scale, h * scale);
    if (draw->layer_count > 1 && draw->emission != DGB_EMISSION_IMAGE && !is_viewport(1, w * scale, h * scale))
        return false;
    return is_viewport(0, w, h);
}

/* What an engine may count on when its callback is called. */
static bool is_ready(const engine* e, const dgb_draw* draw) {
    GLint buffer = 0;
    bool ready = is_indexed_state_ready() && are_viewports_ready(e, draw);
    GLuint i;
    for (i = 1; i < CAPABILITY_COUNT; ++i) ready = ready && !glIsEnabled(capabilities[i]);
    glGetIntegeri_v(GL_UNIFORM_BUFFER_BINDING, BINDING, &buffer);
    return ready && glIsEnabled(GL_DEPTH_TEST) && is_integer(GL_DEPTH_FUNC, GL_LESS) &&
           is_integer(GL_DEPTH_WRITEMASK, GL_TRUE) && is_integer(GL_POLYGON_MODE, GL_FILL) &&
           is_integer(GL_CLIP_ORIGIN, GL_LOWER_LEFT) && is_integer(GL_CLIP_DEPTH_MODE, GL_NEGATIVE_ONE_TO_ONE) &&
           buffer != 0 && buffer != (GLint)own.buffers[0] && buffer != (GLint)own.buffers[1] &&
           glCheckFramebufferStatus(GL_DRAW_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
}

static void on_draw(void* user, const dgb_draw* draw) {
    engine* e = (engine*)user;
    fixture_draw_user drawn = e->user;
    GLuint i;
    e->unready += !is_ready(e, draw);
    if (e->no_store) drawn.program = e->depth_program;
    for (i = 0; i < 4; ++i)
        if (e->masks[i]) glColorMaski(i, GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    /* what the library neither sets nor restores, and what moves the last bits of what is clipped, the engine sets */
    glProvokingVertex(GL_LAST_VERTEX_CONVENTION);
    glFrontFace(GL_CCW);
    fixture_draw(&drawn, draw);
    if (e->wild) scramble();
}

static void build(engine* e, const dgb_view* view) {
    const dgb_result result = dgb_build(&e->context, view, &e->params, on_draw, e);
    if (result != DGB_OK) fail_msg("%s: dgb_build: %s", running_name(), dgb_log_item_name(e->logged));
}

/* A frame of everything. */
static void run_frame(engine* e, int frame, bool cut) {
    dgb_view view = view_at(frame, e->context.desc.width, e->context.desc.height);
    view.cut = cut;
    build(e, &view);
    assert_int_equal(dgb_shade(&e->context, &e->params), DGB_OK);
}

/* >> results */

enum { RESULT_COUNT = 7 };

static const struct {
    dgb_slot slot;
    GLenum format;
    int channels;
    bool layered;
} results[RESULT_COUNT] = {{DGB_DEPTH, GL_DEPTH_COMPONENT, 1, true}, {DGB_ALBEDO, GL_RGBA, 4, true},
                           {DGB_NORMAL, GL_RGBA, 4, true},           {DGB_RADIANCE, GL_RGB, 3, true},
                           {DGB_VELOCITY, GL_RG, 2, true},           {DGB_AO, GL_RED, 1, false},
                           {DGB_IRRADIANCE, GL_RGBA, 4, false}};

typedef struct image { /* everything a frame gave */
    float* data[RESULT_COUNT];
    size_t counts[RESULT_COUNT]; /* floats, of all layers */
} image;

static image read_image(const dgb_context* c) {
    image all;
    int i;
    for (i = 0; i < RESULT_COUNT; ++i) {
        const int layers = results[i].layered ? c->plan.layers : 0;
        all.data[i] = fixture_read(dgb_get_texture(c, results[i].slot), 0, 0, c->plan.width, c->plan.height, layers,
                                   results[i].format, results[i].channels);
        all.counts[i] = (size_t)(c->plan.width * c->plan.height * results[i].channels) * (size_t)(layers ? layers : 1);
    }
    return all;
}

static void free_image(image* all) {
    int i;
    for (i = 0; i < RESULT_COUNT; ++i) free(all->data[i]);
}

static void expect_equal(const image* a, const image* b, const char* what) {
    int i;
    size_t k, count = 0;
    for (i = 0; i < RESULT_COUNT; ++i) {
        assert_int_equal(a->counts[i], b->counts[i]);
        for (k = 0; k < a->counts[i]; ++k) count += !same_bits(&a->data[i][k], &b->data[i][k], sizeof(float));
        if (count)
            fail_msg("%s: %s: %u of %u values of %s differ", running_name(), what, (unsigned)count,
                     (unsigned)a->counts[i], dgb_slot_name(results[i].slot));
    }
}

static bool is_all(const image* all, int result, float value) {
    size_t k;
    for (k = 0; k < all->counts[result]; ++k)
        if (!(all->data[result][k] == value)) return false;
    return true;
}

static void expect_finite(const image* all) {
    size_t k;
    int i;
    for (i = 0; i < RESULT_COUNT; ++i)
        for (k = 0; k < all->counts[i]; ++k)
            if (!(all->data[i][k] - all->data[i][k] == 0.0f))
                fail_msg("%s: %s is not finite", running_name(), dgb_slot_name(results[i].slot));
}

/* Something was drawn into both layers and lit, or the comparisons mean nothing. */
static void expect_scene(const image* all) {
    const size_t layer = all->counts[0] / 2;
    size_t k, first = 0, behind = 0;
    for (k = 0; k < layer; ++k) first += all->data[0][k] < 1.0f;
    for (; k < all->counts[0]; ++k) behind += all->data[0][k] < 1.0f;
    assert_true(first > layer / 4 && behind > layer / 50);
    assert_false(is_all(all, 5, 1.0f));
    assert_false(is_all(all, 6, 0.0f));
    expect_finite(all);
}

/* >> engines that misbehave */

static void expect_empty(engine* e) {
    image all = read_image(&e->context);
    int i;
    for (i = 0; i < RESULT_COUNT; ++i) {
        const bool one = results[i].slot == DGB_DEPTH || results[i].slot == DGB_AO;
        if (!is_all(&all, i, one ? 1.0f : 0.0f))
            fail_msg("%s: %s is not empty", running_name(), dgb_slot_name(results[i].slot));
    }
    free_image(&all);
}

static void check_nothing_drawn(const construction* c) {
    engine e;
    image all;
    int frame;
    start(&e, c);
    e.user.nothing = true;
    for (frame = 0; frame < 2; ++frame) { /* from the first on */
        run_frame(&e, frame, false);
        expect_empty(&e);
    }
    e.user.nothing = false;
    for (; frame < 5; ++frame) run_frame(&e, frame, false);
    all = read_image(&e.context);
    expect_scene(&all);
    free_image(&all);
    e.user.nothing = true; /* after a frame that was full */
    for (; frame < 8; ++frame) {
        run_frame(&e, frame, frame == 7);
        expect_empty(&e);
    }
    assert_int_equal(e.unready, 0);
    stop(&e);
}

static void test_nothing_is_drawn(void** state) {
    (void)state;
    for_every_construction(check_nothing_drawn);
}

/* Draws two frames as it should, if `first_well`, then four that leave something out. */
static image forgetful_frames(const construction* c, bool first_well, const bool masks[4], bool no_store) {
    engine e;
    image all;
    int frame;
    start(&e, c);
    e.depth_program = make_depth_program(&e.context);
    for (frame = 0; frame < 6; ++frame) {
        const bool well = first_well && frame < 2;
        if (!first_well && frame < 2) continue;
        e.no_store = no_store && !well;
        memcpy(e.masks, masks, sizeof e.masks);
        if (well) memset(e.masks, 0, sizeof e.masks);
        run_frame(&e, frame, frame == 2); /* the cut: from here on both engines are in the same position */
    }
    all = read_image(&e.context);
    stop(&e);
    return all;
}

/* Depth is what it was, and a target that was masked is what it was cleared to: nothing stays from frames before. */
static void check_masked(const construction* c, const image* full, const bool masks[4], const char* what) {
    image stale = forgetful_frames(c, true, masks, false), clean = forgetful_frames(c, false, masks, false);
    int target;
    expect_equal(&stale, &clean, what);
    expect_finite(&stale);
    assert_memory_equal(stale.data[0], full->data[0], full->counts[0] * sizeof(float));
    for (target = 0; target < 4; ++target) {
        if (!masks[target]) continue;
        /* deeper layers that are stored as images know no masks */
        if (c->emission == DGB_EMISSION_IMAGE) stale.counts[1 + target] /= (size_t)c->layers;
        if (!is_all(&stale, 1 + target, 0.0f))
            fail_msg("%s: %s: %s holds something", running_name(), what, dgb_slot_name(results[1 + target].slot));
        assert_false(is_all(full, 1 + target, 0.0f));
    }
    free_image(&stale);
    free_image(&clean);
}

/* GL leaves the colours of a shader that writes none undefined: depth is as it should be, and nothing runs wild. */
static void check_no_store(const construction* c, const image* full) {
    static const bool none[4] = {false, false, false, false};
    image forgetful = forgetful_frames(c, true, none, true);
    size_t k;
    assert_memory_equal(forgetful.data[0], full->data[0], full->counts[0] * sizeof(float));
    for (k = 0; k < forgetful.counts[5]; ++k) assert_true(forgetful.data[5][k] >= 0.0f && forgetful.data[5][k] <= 1.0f);
    for (k = 0; k < forgetful.counts[6]; ++k)
        assert_true(forgetful.data[6][k] >= 0.0f && forgetful.data[6][k] <= DGB_MAX_RADIANCE);
    free_image(&forgetful);
}

static void check_forgotten_targets(const construction* c) {
    static const bool all[4] = {true, true, true, true}, radiance[4] = {false, false, true, false};
    static const bool none[4] = {false, false, false, false};
    image full = forgetful_frames(c, false, none, false);
    expect_scene(&full);
    check_masked(c, &full, all, "depth alone");
    check_masked(c, &full, radiance, "no radiance");
    check_no_store(c, &full);
    free_image(&full);
}

static void test_targets_are_forgotten(void** state) {
    (void)state;
    for_every_construction(check_forgotten_targets);
}

static void check_wild(const construction* c) {
    enum { FRAMES = 5 };
    static snapshot before;
    image tame[FRAMES];
    engine e;
    int frame;
    start(&e, c);
    for (frame = 0; frame < FRAMES; ++frame) {
        run_frame(&e, frame, false);
        tame[frame] = read_image(&e.context);
    }
    expect_scene(&tame[FRAMES - 1]);
    assert_int_equal(e.unready, 0);
    stop(&e);

    make_objects(&own);
    start(&e, c);
    e.wild = true;
    for (frame = 0; frame < FRAMES; ++frame) {
        dgb_view view = view_at(frame, WIDTH, HEIGHT);
        image wild;
        scramble();
        take_snapshot(&before);
        build(&e, &view);
        expect_same(&before, "dgb_build");
        assert_int_equal(dgb_shade(&e.context, &e.params), DGB_OK);
        expect_same(&before, "dgb_shade");
        glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
        wild = read_image(&e.context);
        expect_equal(&tame[frame], &wild, "a wild engine");
        free_image(&wild);
        free_image(&tame[frame]);
    }
    assert_int_equal(e.unready, 0);
    scramble();
    take_snapshot(&before);
    assert_int_equal(dgb_resize(&e.context, WIDTH + 5, HEIGHT - 3), DGB_OK);
    expect_same(&before, "dgb_resize");
    glUseProgram(0);
    stop(&e);
    expect_same(&before, "dgb_shutdown");
    delete_objects(&own);
    memset(&own, 0, sizeof own);
}

/* In a context of its own: what the engine scrambled and the library does not touch ends with it. */
static void test_engine_is_wild(void** state) {
    (void)state;
    random_state = 17u;
    for_every_construction(check_wild);
    fixture_close(&f);
    assert_int_equal(fixture_open(&f, 4, 5, false, NULL), 0);
}

/* >> frames that are no ordinary ones */

static float not_a_number(void) { return from_bits(0x7fc00000u); }

/* What frame 3 looks like; with `disturbed`, bad calls come before each frame. */
static image frames_with_bad_input(const construction* c, bool disturbed) {
    static const struct {
        dgb_log_item item;
        int what; /* 0 view, 1 projection, 2 jitter, 3 next view */
        int entry;
        float value;
    } bad[] = {{DGB_LOG_MATRIX, 0, 5, 0},     {DGB_LOG_MATRIX, 1, 0, 0},          {DGB_LOG_MATRIX, 2, 1, 0},
               {DGB_LOG_MATRIX, 3, 12, 0},    {DGB_LOG_PROJECTION, 1, 5, 1e-42f}, {DGB_LOG_PROJECTION, 1, 2, 0.2f},
               {DGB_LOG_PROJECTION, 1, 11, 1}};
    engine e;
    image all;
    size_t i;
    int frame;
    start(&e, c);
    for (frame = 0; frame < 4; ++frame) {
        for (i = 0; disturbed && i < sizeof bad / sizeof bad[0]; ++i) {
            dgb_view view = view_at(frame + 7, WIDTH, HEIGHT);
            float* entries[4];
            const int draws = f.draws;
            entries[0] = view.view, entries[1] = view.projection, entries[2] = view.jitter, entries[3] = view.next_view;
            entries[bad[i].what][bad[i].entry] = bad[i].item == DGB_LOG_MATRIX ? not_a_number() : bad[i].value;
            view.cut = true;
            assert_int_equal(dgb_build(&e.context, &view, &e.params, on_draw, &e), DGB_INVALID);
            assert_int_equal(e.logged, bad[i].item);
            assert_int_equal(f.draws, draws);
        }
        run_frame(&e, frame, false);
    }
    all = read_image(&e.context);
    stop(&e);
    return all;
}

static void check_bad_input(const construction* c) {
    image calm = frames_with_bad_input(c, false), disturbed = frames_with_bad_input(c, true);
    expect_scene(&calm);
    expect_equal(&calm, &disturbed, "after views that were refused");
    free_image(&calm);
    free_image(&disturbed);
}

static void test_bad_matrices(void** state) {
    (void)state;
    for_every_construction(check_bad_input);
}

enum { CUT_FRAMES = 6 };

static void run_with_cuts(const construction* c, unsigned cuts, image images[CUT_FRAMES]) {
    engine e;
    int frame;
    start(&e, c);
    for (frame = 0; frame < CUT_FRAMES; ++frame) {
        run_frame(&e, frame, cuts >> frame & 1u);
        images[frame] = read_image(&e.context);
        expect_scene(&images[frame]);
    }
    stop(&e);
}

/* Peeling with the same cuts, frame by frame: a first frame and a cut are built like that, so they are the same to the bit.
   Between them PREDICT knows the next view, and DELAY shows the frame before, so they are exact, too. */
static void check_cuts(const construction* c) {
    static const unsigned patterns[] = {0x15u /* every other frame */, 0x3eu /* all but the first */};
    construction peel = *c;
    size_t p;
    int frame;
    /* clipping moves the last bits; predictions of deeper layers than the second are guesses */
    const bool exact =
        c->emission == DGB_EMISSION_SEPARATE || c->emission == DGB_EMISSION_VERTEX || c->emission == DGB_EMISSION_IMAGE;
    if (!exact || c->oracle == DGB_ORACLE_PEEL || (c->divisor > 1 && c->emission != DGB_EMISSION_SEPARATE)) return;
    peel.oracle = DGB_ORACLE_PEEL;
    peel.emission = DGB_EMISSION_SEPARATE;
    for (p = 0; p < sizeof patterns / sizeof patterns[0]; ++p) {
        image a[CUT_FRAMES], b[CUT_FRAMES];
        run_with_cuts(&peel, patterns[p], a);
        run_with_cuts(c, patterns[p], b);
        for (frame = 0; frame < CUT_FRAMES; ++frame) {
            const bool fresh = frame == 0 || (patterns[p] >> frame & 1u);
            const bool after = frame > 0 && !fresh;
            if (fresh) expect_equal(&a[frame], &b[frame], "a cut");
            if (after && c->layers == 2 && c->oracle == DGB_ORACLE_PREDICT)
                expect_equal(&a[frame], &b[frame], "between cuts, predict");
            if (after && c->oracle == DGB_ORACLE_DELAY) expect_equal(&a[frame - 1], &b[frame], "between cuts, delay");
        }
        for (frame = 0; frame < CUT_FRAMES; ++frame) {
            free_image(&a[frame]);
            free_image(&b[frame]);
        }
    }
}

static void test_cuts(void** state) {
    (void)state;
    for_every_construction(check_cuts);
}

/* Whatever ran before, after a resize it is as if the context had been made for that size. */
static void check_resize(const construction* c) {
    static const int sizes[][2] = {{53, 61}, {WIDTH, HEIGHT}, {8, 5}};
    engine resized;
    size_t i;
    int frame;
    start(&resized, c);
    for (frame = 0; frame < 3; ++frame) run_frame(&resized, frame, false);
    for (i = 0; i < 3; ++i) {
        const dgb_view view = view_at(9, resized.context.desc.width, resized.context.desc.height);
        engine fresh;
        image a, b;
        build(&resized, &view);
        assert_int_equal(dgb_resize(&resized.context, sizes[i][0], sizes[i][1]), DGB_OK);
        assert_int_equal(dgb_shade(&resized.context, &resized.params), DGB_INVALID); /* the layers are gone */
        assert_int_equal(resized.logged, DGB_LOG_NO_LAYERS);
        start(&fresh, c);
        assert_int_equal(dgb_resize(&fresh.context, sizes[i][0], sizes[i][1]), DGB_OK);
        for (frame = 0; frame < 3; ++frame) {
            run_frame(&resized, frame, false);
            run_frame(&fresh, frame, false);
            a = read_image(&resized.context);
            b = read_image(&fresh.context);
            expect_equal(&a, &b, "after a resize");
            free_image(&a);
            free_image(&b);
        }
        stop(&fresh);
    }
    stop(&resized);
}

static void test_resize(void** state) {
    (void)state;
    for_every_construction(check_resize);
}

static void test_guard_band_beyond_the_limit(void** state) {
    const construction c = {DGB_ORACLE_DELAY, DGB_EMISSION_SEPARATE, 2, 1};
    dgb_backend limited = f.gl.backend;
    dgb_desc d = desc_of(&c);
    dgb_context context;
    engine e;
    image before, after;
    (void)state;
    memset(&e, 0, sizeof e);
    memset(&context, 0, sizeof context);
    limited.caps.max_size = WIDTH + 2 * GUARD + 1;
    d.backend = &limited;
    d.log = on_log;
    d.log_user = &e;
    d.guard_band = GUARD + 1;
    assert_int_equal(dgb_init(&context, &d), DGB_INVALID);
    assert_int_equal(e.logged, DGB_LOG_GUARD_BAND);
    d.backend = &f.gl.backend;
    d.guard_band = f.gl.backend.caps.max_size;
    assert_int_equal(dgb_init(&context, &d), DGB_INVALID);
    assert_int_equal(e.logged, DGB_LOG_GUARD_BAND);
    d.backend = &limited;
    d.guard_band = GUARD;
    assert_int_equal(dgb_init(&context, &d), DGB_OK);
    e.context = context;
    e.c = c;
    e.user.f = &f;
    e.params = dgb_preset(DGB_PRESET_QUALITY);
    e.params.guard_fraction = 1.0f;
    e.user.program = fixture_program(&e.context);
    run_frame(&e, 0, false);
    before = read_image(&e.context);
    assert_int_equal(dgb_resize(&e.context, WIDTH + 2, HEIGHT), DGB_INVALID);
    assert_int_equal(e.logged, DGB_LOG_GUARD_BAND);
    assert_int_equal(dgb_shade(&e.context, &e.params), DGB_OK); /* what was built is there still */
    after = read_image(&e.context);
    expect_scene(&before);
    expect_equal(&before, &after, "a refused resize");
    free_image(&before);
    free_image(&after);
    stop(&e);
}

FIXTURE_CONTEXT(f, 4, 5, false)

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_nothing_is_drawn), cmocka_unit_test(test_targets_are_forgotten),
        cmocka_unit_test(test_bad_matrices),     cmocka_unit_test(test_cuts),
        cmocka_unit_test(test_resize),           cmocka_unit_test(test_guard_band_beyond_the_limit),
        cmocka_unit_test(test_no_messages),      cmocka_unit_test(test_engine_is_wild),
        cmocka_unit_test(test_no_messages),
    };
    return cmocka_run_group_tests(tests, open_context, close_context);
}
