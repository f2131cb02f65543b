#define _POSIX_C_SOURCE 200112L /* setenv */

/* The OpenGL backend as a guest in an engine's context: it leaves objects as it found them. Of state, see
   test_guest.c. */
#include "gl_fixture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { WIDTH = 96, HEIGHT = 64 };

static fixture f;

static dgb_desc small_desc(void) {
    const fixture_view v = fixture_default_view();
    dgb_desc d = fixture_desc(&f, &v, WIDTH, HEIGHT, 8);
    d.effects = DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY;
    return d;
}

/* One frame of everything. */
static void run_frame(dgb_context* c, GLuint program) {
    const fixture_view v = fixture_default_view();
    const dgb_view view = fixture_dgb_view(&v, c->desc.width, c->desc.height);
    const dgb_params q = dgb_preset(DGB_PRESET_BALANCED);
    fixture_draw_user user;
    memset(&user, 0, sizeof user);
    user.f = &f;
    user.program = program;
    assert_int_equal(dgb_build(c, &view, &q, fixture_draw, &user), DGB_OK);
    assert_int_equal(dgb_shade(c, &q), DGB_OK);
}

static float* read_irradiance(const dgb_context* c) { return fixture_shaded(c, DGB_IRRADIANCE, 4); }

/* >> bindings that die */

static void test_deleted_program(void** state) {
    dgb_desc d = small_desc();
    GLuint program = glCreateProgram(), own;
    dgb_context c;
    GLint current;
    (void)state;
    assert_int_equal(dgb_init(&c, &d), DGB_OK);
    own = fixture_program(&c);
    glLinkProgram(program);
    glUseProgram(own);
    glDeleteProgram(own); /* in use: only flagged */
    run_frame(&c, own);
    glGetIntegerv(GL_CURRENT_PROGRAM, &current);
    assert_true(current == 0 || glIsProgram((GLuint)current));
    glUseProgram(0);
    glDeleteProgram(program);
    dgb_shutdown(&c);
}

/* An engine may still have a texture of the library bound when it goes. */
static void test_bound_texture_goes(void** state) {
    dgb_desc d = small_desc();
    dgb_context c;
    GLint bound;
    (void)state;
    assert_int_equal(dgb_init(&c, &d), DGB_OK);
    glActiveTexture(GL_TEXTURE2);
    glBindTexture(GL_TEXTURE_2D, dgbgl_texture_name(dgb_get_texture(&c, DGB_AO)));
    dgb_shutdown(&c);
    glGetIntegerv(GL_TEXTURE_BINDING_2D, &bound);
    assert_int_equal(bound, 0);
    assert_int_equal(f.messages, 0);
    glActiveTexture(GL_TEXTURE0);
}

/* >> objects */

static void test_no_objects_left(void** state) {
    dgb_desc d;
    dgb_context c;
    dgbgl_backend gl;
    dgbgl_desc gd;
    GLuint program;
    int before;
    (void)state;
    memset(&gd, 0, sizeof gd);
    gd.get_proc = headless_get_proc;
    before = fixture_count_objects();
    assert_int_equal(dgbgl_init(&gl, &gd), DGB_OK);
    d = small_desc();
    d.backend = &gl.backend;
    assert_int_equal(dgb_init(&c, &d), DGB_OK);
    assert_true(fixture_count_objects() > before + 20); /* or the count sees nothing */
    program = fixture_program(&c);
    run_frame(&c, program);
    assert_int_equal(dgb_resize(&c, 50, 70), DGB_OK);
    run_frame(&c, program);
    run_frame(&c, program);
    glDeleteProgram(program);
    dgb_shutdown(&c);
    dgbgl_shutdown(&gl);
    assert_int_equal(fixture_count_objects(), before);
}

static void test_two_contexts(void** state) {
    dgb_desc d = small_desc(), e = small_desc();
    dgb_context one, two;
    GLuint program_one, program_two;
    float *alone, *together;
    (void)state;
    assert_int_equal(dgb_init(&one, &d), DGB_OK);
    program_one = fixture_program(&one);
    run_frame(&one, program_one);
    run_frame(&one, program_one);
    alone = read_irradiance(&one);
    e.width = 40;
    e.layers = 1;
    assert_int_equal(dgb_init(&two, &e), DGB_OK);
    program_two = fixture_program(&two);
    run_frame(&two, program_two);
    run_frame(&one, program_one);
    run_frame(&two, program_two);
    together = read_irradiance(&one);
    assert_memory_equal(alone, together, sizeof(float) * 4 * (size_t)(one.plan.width * one.plan.height));
    free(alone);
    free(together);
    dgb_shutdown(&two);
    run_frame(&one, program_one); /* the other's end is not this one's */
    glDeleteProgram(program_one);
    glDeleteProgram(program_two);
    dgb_shutdown(&one);
}

/* >> the engine's own layers */

static dgb_texture layer_view(const dgb_context* c, dgb_slot slot, int layer, GLenum format) {
    GLuint name;
    glGenTextures(1, &name);
    glTextureView(name, GL_TEXTURE_2D, dgbgl_texture_name(dgb_get_texture(c, slot)), format, 0, 1, (GLuint)layer, 1);
    return dgbgl_texture(name);
}

/* Layers that the library built, handed back as an engine's own, shade to the same bits. */
static void test_own_layers(void** state) {
    dgb_desc d = small_desc();
    dgb_context built, own;
    dgb_layers layers;
    dgb_params q = dgb_preset(DGB_PRESET_BALANCED);
    fixture_view v = fixture_default_view();
    dgb_view view = fixture_dgb_view(&v, WIDTH, HEIGHT);
    GLuint program;
    float *a, *b;
    int layer;
    (void)state;
    assert_int_equal(dgb_init(&built, &d), DGB_OK);
    program = fixture_program(&built);
    run_frame(&built, program);
    memset(&layers, 0, sizeof layers);
    for (layer = 0; layer < 2; ++layer) {
        layers.depth[layer] = layer_view(&built, DGB_DEPTH, layer, GL_DEPTH_COMPONENT32F);
        layers.normal[layer] = layer_view(&built, DGB_NORMAL, layer, GL_RGBA8);
        layers.radiance[layer] = layer_view(&built, DGB_RADIANCE, layer, GL_R11F_G11F_B10F);
    }
    d.source = DGB_SOURCE_ENGINE;
    d.normals = DGB_NORMALS_OCT16;
    assert_int_equal(dgb_init(&own, &d), DGB_OK);
    assert_int_equal(dgb_set_layers(&own, &view, &layers), DGB_OK);
    assert_int_equal(dgb_shade(&own, &q), DGB_OK);
    a = read_irradiance(&built);
    b = read_irradiance(&own);
    assert_memory_equal(a, b, sizeof(float) * 4 * (size_t)(own.plan.width * own.plan.height));
    free(a);
    free(b);
    for (layer = 0; layer < 2; ++layer) {
        const GLuint names[3] = {dgbgl_texture_name(layers.depth[layer]), dgbgl_texture_name(layers.normal[layer]),
                                 dgbgl_texture_name(layers.radiance[layer])};
        glDeleteTextures(3, names);
    }
    glDeleteProgram(program);
    dgb_shutdown(&own);
    dgb_shutdown(&built);
}

/* Depth alone: the derived normals agree with the true ones away from edges. */
static void test_depth_only(void** state) {
    dgb_desc d = small_desc();
    dgb_context built, own;
    dgb_layers layers;
    dgb_params q = dgb_preset(DGB_PRESET_BALANCED);
    fixture_view v = fixture_default_view();
    dgb_view view = fixture_dgb_view(&v, WIDTH, HEIGHT);
    GLuint program, name;
    float *truth, *derived;
    int i, close = 0, surface = 0;
    (void)state;
    d.effects = DGB_EFFECT_AO;
    d.layers = 1;
    d.width = 3 * WIDTH, d.height = 3 * HEIGHT;
    assert_int_equal(dgb_init(&built, &d), DGB_OK);
    program = fixture_program(&built);
    run_frame(&built, program);
    memset(&layers, 0, sizeof layers);
    layers.depth[0] = layer_view(&built, DGB_DEPTH, 0, GL_DEPTH_COMPONENT32F);
    d.source = DGB_SOURCE_ENGINE;
    assert_int_equal(dgb_init(&own, &d), DGB_OK);
    assert_int_equal(dgb_set_layers(&own, &view, &layers), DGB_OK);
    assert_int_equal(dgb_shade(&own, &q), DGB_OK);
    truth = fixture_image(&built, DGB_NORMALS, 0, 2);
    derived = fixture_image(&own, DGB_NORMALS, 0, 2);
    for (i = 0; i < own.plan.width * own.plan.height; ++i) {
        float a[3], b[3];
        unsigned ax = (unsigned)(truth[2 * i] * 255.0f + 0.5f), ay = (unsigned)(truth[2 * i + 1] * 255.0f + 0.5f);
        unsigned bx = (unsigned)(derived[2 * i] * 255.0f + 0.5f), by = (unsigned)(derived[2 * i + 1] * 255.0f + 0.5f);
        if (ax + ay == 0) continue; /* sky */
        dgb_oct16_decode((uint16_t)(ax | ay << 8), a);
        dgb_oct16_decode((uint16_t)(bx | by << 8), b);
        ++surface;
        close += a[0] * b[0] + a[1] * b[1] + a[2] * b[2] > 0.998f; /* 3.6 degrees: two Oct16 errors and some */
    }
    printf("# normals from depth: %d of %d close to the true ones\n", close, surface);
    assert_true(close > surface * 95 / 100);
    free(truth);
    free(derived);
    name = dgbgl_texture_name(layers.depth[0]);
    glDeleteTextures(1, &name);
    glDeleteProgram(program);
    dgb_shutdown(&own);
    dgb_shutdown(&built);
}

/* >> init, timers, floors */

static void* no_proc(const char* name) { return strcmp(name, "glDrawBuffers") == 0 ? NULL : headless_get_proc(name); }

static void test_bad_init(void** state) {
    dgbgl_backend gl;
    dgbgl_desc gd;
    (void)state;
    memset(&gd, 0, sizeof gd);
    assert_int_equal(dgbgl_init(NULL, &gd), DGB_INVALID);
    assert_int_equal(dgbgl_init(&gl, NULL), DGB_INVALID);
    assert_int_equal(dgbgl_init(&gl, &gd), DGB_INVALID);
    gd.get_proc = no_proc;
    assert_int_equal(dgbgl_init(&gl, &gd), DGB_DEVICE);
    dgbgl_shutdown(&gl);
    dgbgl_shutdown(NULL);
}

static void test_out_of_memory(void** state) {
    dgb_desc d = small_desc();
    dgb_context c;
    GLuint program;
    int before;
    (void)state;
    d.layers = 8;
    assert_int_equal(dgb_init(&c, &d), DGB_OK);
    program = fixture_program(&c);
    run_frame(&c, program);
    before = fixture_count_objects();
    assert_int_equal(dgb_resize(&c, 16000, 16000), DGB_OUT_OF_MEMORY); /* 8 GB of depth: refused at once */
    assert_int_equal(fixture_count_objects(), before);
    run_frame(&c, program); /* the old textures go on */
    glDeleteProgram(program);
    dgb_shutdown(&c);
    f.messages = 0; /* the driver says so, too */
}

static void test_timers(void** state) {
    dgb_desc d = small_desc();
    dgb_context c;
    GLuint program;
    double ms = -1.0;
    int frame, pass;
    (void)state;
    d.effects |= DGB_EFFECT_BOUNCES | DGB_EFFECT_TEMPORAL | DGB_EFFECT_REFLECT | DGB_EFFECT_GLOSSY;
    d.tracer = DGB_TRACER_HIERARCHICAL;
    d.thickness = DGB_THICKNESS_BACK_FACES;
    assert_int_equal(dgb_init(&c, &d), DGB_OK);
    program = fixture_program(&c);
    for (frame = 0; frame < 4; ++frame) {
        run_frame(&c, program);
        glFinish();
    }
    for (pass = 0; pass < DGB_PASS_COUNT; ++pass) {
        const bool ran = pass != DGB_PASS_WARP && pass != DGB_PASS_PREDICT &&
                         (pass != DGB_PASS_RESOLVE || c.plan.emission == DGB_EMISSION_IMAGE);
        assert_true(dgbgl_pass_time(&f.gl, (dgb_pass_id)pass, &ms) == ran);
        assert_true(!ran || ms >= 0.0);
    }
    assert_false(dgbgl_pass_time(&f.gl, DGB_PASS_COUNT, &ms));
    assert_false(dgbgl_pass_time(NULL, DGB_PASS_AO, &ms));
    glDeleteProgram(program);
    dgb_shutdown(&c);
}

static void test_prefix_lengths(void** state) {
    dgb_desc d = small_desc();
    dgb_context c;
    char small[8], whole[1 << 16];
    size_t length;
    GLuint unlinked;
    (void)state;
    assert_int_equal(dgb_init(&c, &d), DGB_OK);
    length = dgbgl_shader_prefix(&c, DGBGL_VERTEX, NULL, 0, NULL, 0);
    assert_int_equal(dgbgl_shader_prefix(&c, DGBGL_VERTEX, NULL, 0, small, sizeof small), length);
    assert_string_equal(small, "#versio");
    assert_int_equal(dgbgl_shader_prefix(&c, DGBGL_VERTEX, NULL, 0, whole, sizeof whole), length);
    assert_int_equal(strlen(whole), length);
    assert_int_equal(dgbgl_shader_prefix(NULL, DGBGL_VERTEX, NULL, 0, whole, sizeof whole), 0);
    assert_int_equal(dgbgl_attach_program(&c, 0), DGB_INVALID);
    unlinked = glCreateProgram();
    assert_int_equal(dgbgl_attach_program(&c, unlinked), DGB_INVALID);
    assert_int_equal(glGetError(), GL_NO_ERROR);
    glDeleteProgram(unlinked);
    dgb_shutdown(&c);
    assert_int_equal(dgbgl_shader_prefix(&c, DGBGL_VERTEX, NULL, 0, whole, sizeof whole), 0);
}

static GLuint fullscreen_program(const char* fragment) {
    const char* texts[2] = {
        "#version 330 core\nvoid main() {\n"
        "    gl_Position = vec4(4.0 * vec2(gl_VertexID & 1, gl_VertexID >> 1) - 1.0, 0.0, 1.0);\n}\n",
        fragment};
    const GLenum stages[2] = {GL_VERTEX_SHADER, GL_FRAGMENT_SHADER};
    const GLuint program = glCreateProgram();
    GLint linked = 0;
    int i;
    for (i = 0; i < 2; ++i) {
        const GLuint shader = glCreateShader(stages[i]);
        glShaderSource(shader, 1, &texts[i], NULL);
        glCompileShader(shader);
        glAttachShader(program, shader);
        glDeleteShader(shader);
    }
    glLinkProgram(program);
    glGetProgramiv(program, GL_LINK_STATUS, &linked);
    assert_true(linked);
    return program;
}

/* The snippet for composites: its length as snprintf gives it, and one pixel of light drawn with it. */
static void test_composite_snippet(void** state) {
    static const char end[] =
        "out vec4 color;\nvoid main() {\n"
        "    color = vec4(dgb_fallback(vec3(2.0, 4.0, 0.0), 0.5, vec4(5.0, 0.0, 8.0, 0.25)), 1.0);\n}\n";
    char text[4096] = "#version 330 core\n", small[8];
    const size_t length = dgbgl_composite_snippet(NULL, 0), head = strlen(text);
    float color[4];
    GLuint program, vertices, framebuffer, target;
    (void)state;
    assert_int_equal(dgbgl_composite_snippet(small, sizeof small), length);
    assert_true(length + head + sizeof end < sizeof text);
    assert_int_equal(dgbgl_composite_snippet(text + head, sizeof text - head), length);
    assert_int_equal(strlen(text), length + head);
    memcpy(text + head + length, end, sizeof end);
    program = fullscreen_program(text);
    glGenTextures(1, &target);
    glBindTexture(GL_TEXTURE_2D, target);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, 1, 1, 0, GL_RGBA, GL_FLOAT, NULL);
    glGenFramebuffers(1, &framebuffer);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, target, 0);
    glGenVertexArrays(1, &vertices);
    glBindVertexArray(vertices);
    glViewport(0, 0, 1, 1);
    glUseProgram(program);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glReadPixels(0, 0, 1, 1, GL_RGBA, GL_FLOAT, color);
    /* a confidence of a quarter is half of the hemisphere */
    assert_true(color[0] == 0.5f * 1.0f + 2.5f && color[1] == 0.5f * 2.0f && color[2] == 4.0f);
    glUseProgram(0);
    glDeleteProgram(program);
    glDeleteVertexArrays(1, &vertices);
    glDeleteFramebuffers(1, &framebuffer);
    glDeleteTextures(1, &target);
}

/* The whole path on OpenGL 3.3, with what AUTO finds there and without single-pass emission. */
static void test_gl33(void** state) {
    int pretend;
    (void)state;
    fixture_close(&f);
    setenv("MESA_GL_VERSION_OVERRIDE", "3.3",
           1); /* a driver that gives more than was asked for would hide what is missing */
    setenv("MESA_GLSL_VERSION_OVERRIDE", "330", 1);
    for (pretend = 0; pretend < 2; ++pretend) {
        dgbgl_desc gd;
        dgb_desc d;
        dgb_context c;
        GLuint program;
        memset(&gd, 0, sizeof gd);
        gd.no_single_pass = pretend == 1;
        assert_int_equal(fixture_open(&f, 3, 3, false, &gd), 0);
        d = small_desc();
        assert_int_equal(dgb_init(&c, &d), DGB_OK);
        printf("# OpenGL %d: %s\n", f.gl.version, dgb_emission_name(c.plan.emission));
        program = fixture_program(&c);
        run_frame(&c, program);
        run_frame(&c, program);
        glDeleteProgram(program);
        dgb_shutdown(&c);
        assert_int_equal(f.messages, 0);
        fixture_close(&f);
    }
    unsetenv("MESA_GL_VERSION_OVERRIDE");
    unsetenv("MESA_GLSL_VERSION_OVERRIDE");
    assert_int_equal(fixture_open(&f, 4, 5, false, NULL), 0);
}

static void keep_message(void* user, const char* text) { snprintf((char*)user, 256, "%s", text); }

static void say_gl32(GLenum name, GLint* value) {
    glGetIntegerv(name, value);
    if (name == GL_MAJOR_VERSION) *value = 3;
    if (name == GL_MINOR_VERSION) *value = 2;
}

static void* gl32_get_proc(const char* name) {
    void (*const get)(GLenum, GLint*) = say_gl32;
    void* address = headless_get_proc(name);
    if (strcmp(name, "glGetIntegerv") == 0) memcpy(&address, &get, sizeof address);
    return address;
}

/* An older context is refused in a sentence that names it, and nothing is left to shut down. */
static void test_gl32(void** state) {
    dgbgl_backend gl, zero;
    dgbgl_desc gd;
    char message[256] = "";
    (void)state;
    memset(&zero, 0, sizeof zero);
    memset(&gd, 0, sizeof gd);
    gd.get_proc = gl32_get_proc;
    gd.message = keep_message;
    gd.message_user = message;
    assert_int_equal(dgbgl_init(&gl, &gd), DGB_UNSUPPORTED);
    assert_non_null(strstr(message, "this is OpenGL 3.2; needs OpenGL 3.3, or OpenGL ES 3.0 with"));
    assert_memory_equal(&gl, &zero, sizeof gl);
}

/* >> geometry shader from a list of varyings */

static int faults; /* messages of the backend */

static void count_fault(void* user, const char* text) {
    (void)user, (void)text;
    ++faults;
}

/* Compiles vertex, geometry and fragment shader for one varying; the vertex shader writes it, the fragment reads it. */
static bool varying_compiles(const dgb_context* c, const dgbgl_varying* v, const char* write, const char* read) {
    static const GLenum stages[] = {GL_VERTEX_SHADER, GL_GEOMETRY_SHADER, GL_FRAGMENT_SHADER};
    static char text[3][1 << 16], body[2][512];
    const GLuint program = glCreateProgram();
    const char* q = v->qualifier ? v->qualifier : "";
    GLint linked = 0;
    size_t length;
    int i;
    snprintf(body[0], sizeof body[0], "%s out %s %s;\nvoid main() { %s dgb_vertex(vec4(1.0), vec4(1.0)); }\n", q,
             v->type, v->name, write);
    snprintf(body[1], sizeof body[1],
             "%s in %s %s;\nvoid main() { if (!dgb_keep()) discard;"
             " dgb_store(vec4(float(%s)), vec3(0.0), vec2(0.0), vec3(0.0)); }\n",
             q, v->type, v->name, read);
    for (i = 0; i < 3; ++i) {
        const char* pieces[2] = {text[i], i == 0 ? body[0] : i == 2 ? body[1] : ""};
        GLuint shader = glCreateShader(stages[i]);
        length = i == 1 ? dgbgl_geometry_shader(c, v, 1, text[i], sizeof text[i])
                        : dgbgl_shader_prefix(c, i == 0 ? DGBGL_VERTEX : DGBGL_FRAGMENT, v, 1, text[i], sizeof text[i]);
        if (!length) return false;
        glShaderSource(shader, 2, pieces, NULL);
        glCompileShader(shader);
        glAttachShader(program, shader);
        glDeleteShader(shader);
    }
    glLinkProgram(program);
    glGetProgramiv(program, GL_LINK_STATUS, &linked);
    glDeleteProgram(program);
    return linked != 0;
}

static void test_varyings(void** state) {
    static const struct {
        dgbgl_varying varying;
        const char *write, *read;
    } good[] = {{{NULL, "float", "v_a"}, "v_a = 1.0;", "v_a"},
                {{NULL, "vec2", "v_uv"}, "v_uv = vec2(1.0);", "v_uv.x"},
                {{"smooth", "vec3", "v_n"}, "v_n = vec3(1.0);", "v_n.x"},
                {{"noperspective", "vec4", "v_c"}, "v_c = vec4(1.0);", "v_c.x"},
                {{"centroid", "vec2", "v_d"}, "v_d = vec2(1.0);", "v_d.x"},
                {{"flat", "vec4", "v_e"}, "v_e = vec4(1.0);", "v_e.x"},
                {{"flat", "int", "v_f"}, "v_f = 1;", "v_f"},
                {{"flat", "uint", "v_g"}, "v_g = 1u;", "v_g"},
                {{"flat", "ivec3", "v_h"}, "v_h = ivec3(1);", "v_h.x"},
                {{"flat", "uvec4", "v_i"}, "v_i = uvec4(1u);", "v_i.x"},
                {{NULL, "mat3", "v_tbn"}, "v_tbn = mat3(1.0);", "v_tbn[0].x"},
                {{NULL, "mat2x4", "v_m"}, "v_m = mat2x4(1.0);", "v_m[0].x"},
                {{NULL, "vec4", "v_w[3]"}, "v_w[0] = v_w[1] = v_w[2] = vec4(1.0);", "v_w[2].x"},
                {{"flat", "int", "v_k[2]"}, "v_k[0] = v_k[1] = 1;", "v_k[1]"}};
    static const dgbgl_varying bad[] = {
        {NULL, "int", "v_a"},      {"flat", "sampler2D", "v_a"}, {"invariant", "vec2", "v_a"}, {NULL, "vec2", "dgb_a"},
        {NULL, "vec2", "gl_a"},    {NULL, "vec2", "1a"},         {NULL, "vec2", "v a"},        {NULL, "vec2", ""},
        {NULL, NULL, "v_a"},       {NULL, "vec2", NULL},         {NULL, "vec2", "v_a[0]"},     {NULL, "vec2", "v_a[2"},
        {NULL, "vec2", "v_a[2]x"}, {NULL, "vec2", "v_a[-1]"}};
    static const dgbgl_varying twice[] = {{NULL, "vec2", "v_a"}, {NULL, "vec4", "v_a[2]"}};
    static const dgb_emission emissions[] = {DGB_EMISSION_GEOMETRY, DGB_EMISSION_INSTANCED_GEOMETRY};
    char text[16];
    size_t i, e;
    (void)state;
    for (e = 0; e < 2; ++e) {
        dgb_desc d = small_desc();
        dgb_context c;
        d.emission = emissions[e];
        if (!fixture_offers(&f, &d)) continue;
        assert_int_equal(dgb_init(&c, &d), DGB_OK);
        for (i = 0; i < sizeof good / sizeof good[0]; ++i) {
            const dgbgl_varying* v = &good[i].varying;
            const bool refused = strchr(v->name, '[') && f.gl.version < 430; /* arrays need it */
            if (varying_compiles(&c, v, good[i].write, good[i].read) == refused)
                fail_msg("%s %s %s", v->type, v->name, refused ? "is taken" : "does not compile");
        }
        faults = 0;
        f.gl.desc.message = count_fault;
        for (i = 0; i < sizeof bad / sizeof bad[0]; ++i)
            if (dgbgl_geometry_shader(&c, &bad[i], 1, text, sizeof text)) fail_msg("bad varying %d is taken", (int)i);
        assert_int_equal(faults, sizeof bad / sizeof bad[0]);
        assert_int_equal(dgbgl_geometry_shader(&c, twice, 2, text, sizeof text), 0);
        assert_int_equal(dgbgl_shader_prefix(&c, DGBGL_FRAGMENT, bad, 1, text, sizeof text), 0);
        dgb_shutdown(&c);
    }
}

/* >> calibration */

typedef struct candidate {
    fixture_draw_user draw; /* first: fixture_draw reads it */
    int prepared, released;
    dgb_emission refused;
} candidate;

static bool prepare(void* user, const dgb_context* context) {
    candidate* k = (candidate*)user;
    if (context->plan.emission == k->refused || k->refused == DGB_EMISSION_COUNT) return false;
    k->draw.program = fixture_program(context);
    ++k->prepared;
    return k->draw.program != 0;
}

static void release(void* user) {
    candidate* k = (candidate*)user;
    glDeleteProgram(k->draw.program);
    ++k->released;
}

static void test_calibration(void** state) {
    const fixture_view v = fixture_default_view();
    const dgb_view view = fixture_dgb_view(&v, WIDTH, HEIGHT);
    const dgb_params q = dgb_preset(DGB_PRESET_BALANCED);
    dgb_desc d = small_desc(), untouched;
    double ms[DGB_EMISSION_COUNT];
    dgbgl_calibration k;
    candidate user;
    int before, emission;
    (void)state;
    memset(&k, 0, sizeof k);
    memset(&user, 0, sizeof user);
    user.draw.f = &f;
    k.view = &view, k.params = &q, k.prepare = prepare, k.release = release, k.draw = fixture_draw, k.user = &user,
    k.frames = 2;
    assert_int_equal(dgbgl_calibrate(&f.gl, &k, &d, ms),
                     DGB_OK); /* the timers' queries come to life in their first use */
    before = fixture_count_objects();
    d = small_desc(); /* for where SEPARATE was fastest d asks for PEEL, which goes with nothing else */
    assert_int_equal(dgbgl_calibrate(&f.gl, &k, &d, ms), DGB_OK);
    assert_int_equal(fixture_count_objects(), before);
    assert_true(d.emission > DGB_EMISSION_AUTO && f.gl.backend.caps.emission[d.emission]);
    assert_true(ms[d.emission] == ms[DGB_EMISSION_AUTO] && ms[DGB_EMISSION_AUTO] > 0.0);
    assert_int_equal(user.prepared, user.released);
    for (emission = DGB_EMISSION_SEPARATE; emission < DGB_EMISSION_COUNT; ++emission) {
        assert_true((ms[emission] >= 0.0) == f.gl.backend.caps.emission[emission]);
        assert_true(ms[emission] < 0.0 || ms[emission] >= ms[DGB_EMISSION_AUTO]);
    }
    user.refused = d.emission; /* the fastest cannot be prepared: another is chosen */
    d = small_desc();
    assert_int_equal(dgbgl_calibrate(&f.gl, &k, &d, ms), DGB_OK);
    assert_true(d.emission != user.refused && ms[user.refused] < 0.0);
    user.refused = DGB_EMISSION_COUNT; /* none can */
    untouched = d;
    assert_int_equal(dgbgl_calibrate(&f.gl, &k, &d, NULL), DGB_UNSUPPORTED);
    assert_memory_equal(&d, &untouched, sizeof d);
    assert_int_equal(dgbgl_calibrate(NULL, &k, &d, NULL), DGB_INVALID);
    k.draw = NULL;
    assert_int_equal(dgbgl_calibrate(&f.gl, &k, &d, NULL), DGB_INVALID);
}

FIXTURE_CONTEXT(f, 4, 5, false)

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_no_objects_left),
        cmocka_unit_test(test_two_contexts),
        cmocka_unit_test(test_own_layers),
        cmocka_unit_test(test_depth_only),
        cmocka_unit_test(test_bad_init),
        cmocka_unit_test(test_timers),
        cmocka_unit_test(test_prefix_lengths),
        cmocka_unit_test(test_composite_snippet),
        cmocka_unit_test(test_calibration),
        cmocka_unit_test(test_deleted_program),
        cmocka_unit_test(test_bound_texture_goes),
        cmocka_unit_test(test_no_messages),
        cmocka_unit_test(test_out_of_memory),
        cmocka_unit_test(test_gl33),
        cmocka_unit_test(test_gl32),
        cmocka_unit_test(test_varyings),
        cmocka_unit_test(test_no_messages),
    };
    return cmocka_run_group_tests(tests, open_context, close_context);
}
