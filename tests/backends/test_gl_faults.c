/* The OpenGL backend on a GL without a GPU: in every context it calls only what is offered, and whatever fails there, it says
   so, leaves nothing behind and goes on. */
#include "gl_faults.h"
#include "gl_session.h"
#include "gl_stub.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <epoxy/gl.h> /* for its values: nothing of it is called */

#define PAPER_EFFECTS                                                                                       \
    (DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY | DGB_EFFECT_BOUNCES | DGB_EFFECT_TEMPORAL | DGB_EFFECT_REFLECT | \
     DGB_EFFECT_GLOSSY)
#define ALL_EFFECTS (PAPER_EFFECTS | DGB_EFFECT_BENT) /* with BITMASK */

/* Of long loops, every so manieth turn, a prime so that all kinds of turns come; with DGB_FULL=1 (make test-full) each. */
static int stride(void) { return getenv("DGB_FULL") ? 1 : 11; }

/* >> contexts */

static const struct context {
    const char* name;
    gl_stub_desc desc;
} contexts[] = {
    {"OpenGL 3.3", {330, false, NULL, NULL}},
    {"OpenGL 3.3 and extensions",
     {330, false,
      "GL_ARB_viewport_array GL_ARB_texture_barrier GL_ARB_texture_storage GL_ARB_clip_control GL_KHR_debug "
      "GL_AMD_vertex_shader_layer",
      NULL}},
    {"OpenGL 4.1", {410, false, "GL_ARB_shader_viewport_layer_array", NULL}},
    {"OpenGL 4.3", {430, false, "GL_NV_viewport_array2 GL_NV_geometry_shader_passthrough", NULL}},
    {"OpenGL 4.5", {450, false, "GL_ARB_shader_viewport_layer_array GL_ARB_fragment_shader_interlock", NULL}},
    {"OpenGL 4.5 in order", {450, false, "GL_ARB_shader_viewport_layer_array", "llvmpipe"}},
    {"OpenGL ES 3.0", {300, true, "GL_EXT_color_buffer_float", NULL}},
    {"OpenGL ES 3.1", {310, true, "GL_EXT_color_buffer_float GL_KHR_debug", NULL}},
    {"OpenGL ES 3.2", {320, true, NULL, NULL}}};
enum { CONTEXTS = (int)(sizeof contexts / sizeof contexts[0]) };

/* >> an engine on the stub: its calls go past the faults */

enum { LAYERS = 12 }; /* textures of an engine's own layers */

static dgbgl_functions own; /* entry points */

static struct engine {
    const struct context* context;
    GLuint vertex_array, textures[LAYERS];
    size_t state_size;
    void* state;
    GLuint program;
    int draws;
    int start;      /* GL calls before the session */
    int last_shade; /* of those in it, before the last dgb_shade */
    int asked;      /* of GL, before this call of the library */
} engine;

static GLuint compile(GLenum stage, const char* prefix) {
    const GLuint shader = own.CreateShader(stage);
    const char* text[2];
    text[0] = prefix;
    text[1] = "void main() {}\n";
    own.ShaderSource(shader, 2, text, NULL);
    own.CompileShader(shader);
    return shader;
}

static void attach(GLuint program, GLuint shader) {
    own.AttachShader(program, shader);
    own.DeleteShader(shader);
}

static unsigned int make_program(void* user, const dgb_context* c) {
    static char prefix[1 << 16];
    const GLuint program = own.CreateProgram();
    (void)user;
    assert_true(dgbgl_shader_prefix(c, DGBGL_VERTEX, NULL, 0, prefix, sizeof prefix) > 0);
    attach(program, compile(GL_VERTEX_SHADER, prefix));
    if (dgbgl_geometry_shader(c, NULL, 0, prefix, sizeof prefix)) attach(program, compile(GL_GEOMETRY_SHADER, prefix));
    assert_true(dgbgl_shader_prefix(c, DGBGL_FRAGMENT, NULL, 0, prefix, sizeof prefix) > 0);
    attach(program, compile(GL_FRAGMENT_SHADER, prefix));
    own.LinkProgram(program);
    engine.program = dgbgl_attach_program(c, program) == DGB_OK ? program : 0;
    engine.asked = gl_stub_gets();
    if (engine.program) return program;
    own.DeleteProgram(program);
    return 0;
}

static void delete_program(void* user, unsigned int program) {
    (void)user;
    own.DeleteProgram(program);
}

static void draw(void* user, const dgb_draw* d) {
    (void)user, (void)d;
    ++engine.draws;
    own.UseProgram(engine.program);
    own.BindVertexArray(engine.vertex_array);
    own.DrawArrays(GL_TRIANGLES, 0, 3);
    own.Enable(GL_BLEND); /* and leaves what it likes */
    own.DepthMask(GL_FALSE);
}

static void check_state(void* user, const char* call) {
    size_t size;
    const void* state = gl_stub_state(&size);
    (void)user;
    size_t i;
    for (i = 0; i < size; ++i)
        if (((const char*)state)[i] != ((const char*)engine.state)[i])
            fail_msg("%s, %s: byte %u of the state changed (%s failed)", engine.context->name, call, (unsigned)i,
                     gl_faults_failed());
    if (strcmp(call, "dgb_shade") != 0 && strcmp(call, "dgb_shutdown") != 0 && strcmp(call, "dgbgl_shutdown") != 0)
        engine.last_shade = gl_stub_calls() - engine.start;
}

static void load_own(void) {
#define LOAD(result, name, arguments)                 \
    {                                                 \
        void* address = gl_stub_get_proc("gl" #name); \
        memcpy(&own.name, &address, sizeof address);  \
    }
    DGBGL_FUNCTIONS(LOAD)
    DGBGL_OPTIONAL_FUNCTIONS(LOAD)
#undef LOAD
}

static dgb_layers make_layers(void) {
    dgb_texture* where[LAYERS];
    dgb_layers layers;
    int i;
    memset(&layers, 0, sizeof layers);
    for (i = 0; i < 2; ++i) {
        where[i] = &layers.depth[i];
        where[2 + i] = &layers.normal[i];
        where[4 + i] = &layers.radiance[i];
        where[6 + i] = &layers.albedo[i];
        where[8 + i] = &layers.velocity[i];
    }
    where[10] = &layers.roughness;
    where[11] = &layers.back;
    own.GenTextures(LAYERS, engine.textures);
    for (i = 0; i < LAYERS; ++i) {
        own.BindTexture(GL_TEXTURE_2D, engine.textures[i]);
        if (i < 2 || i == 11)
            own.TexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT32F, 96, 64, 0, GL_DEPTH_COMPONENT, GL_FLOAT, NULL);
        else
            own.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA16F, 96, 64, 0, GL_RGBA, GL_FLOAT, NULL);
        *where[i] = dgbgl_texture(engine.textures[i]);
    }
    return layers;
}

/* A context that an engine has left in disorder. */
static void start(const struct context* context) {
    load_own();
    gl_stub_start(&context->desc);
    memset(&engine, 0, sizeof engine);
    engine.context = context;
    own.GenVertexArrays(1, &engine.vertex_array);
}

static void remember_state(void) {
    const void* state;
    gl_stub_scramble();
    state = gl_stub_state(&engine.state_size);
    engine.state = malloc(engine.state_size);
    memcpy(engine.state, state, engine.state_size);
}

static void stop(void) {
    free(engine.state);
    gl_stub_stop();
}

typedef struct setup {
    uint32_t effects;
    dgb_source source;
    dgb_oracle oracle;
    dgb_emission emission;
    int layers, divisor;
    dgb_estimator estimator;
    dgb_tracer tracer;
    dgb_thickness thickness;
} setup;

static gl_session session_of(const setup* u, const dgb_layers* layers) {
    gl_session s;
    memset(&s, 0, sizeof s);
    s.gl.get_proc = gl_faults_get_proc;
    s.desc.width = 64;
    s.desc.height = 48;
    s.desc.guard_band = 8;
    s.desc.effects = u->effects;
    s.desc.source = u->source;
    s.desc.oracle = u->oracle;
    s.desc.emission = u->emission;
    s.desc.layers = u->layers;
    s.desc.divisor = u->divisor;
    s.desc.estimator = u->estimator;
    s.desc.tracer = u->tracer;
    s.desc.thickness = u->thickness;
    s.make_program = u->source == DGB_SOURCE_BUILD ? make_program : NULL;
    s.delete_program = u->source == DGB_SOURCE_BUILD ? delete_program : NULL;
    s.draw = draw;
    s.after = check_state;
    s.layers = u->source == DGB_SOURCE_ENGINE ? layers : NULL;
    return s;
}

/* One session from an empty stub to an empty stub. The call `fail_at` fails; the context is lost at GL call `lose_at`. */
static gl_session run(const struct context* context, const setup* u, int fail_at, int lose_at) {
    gl_session s;
    dgb_layers layers;
    int alive;
    start(context);
    layers = make_layers();
    remember_state();
    alive = gl_stub_alive();
    gl_faults_start(gl_stub_get_proc, fail_at);
    s = session_of(u, &layers);
    s.is_lost = lose_at > 0;
    engine.start = gl_stub_calls();
    if (lose_at) gl_stub_lose_at(engine.start + lose_at);
    gl_session_run(&s);
    if (!lose_at && gl_stub_alive() != alive)
        fail_msg("%s: %d objects are left, %s failed at %s", context->name, gl_stub_alive() - alive, s.failed,
                 gl_faults_failed());
    return s;
}

/* >> nothing fails */

static bool is_offered(const struct context* context, const setup* u) {
    dgbgl_desc gd;
    dgbgl_backend gl;
    dgb_desc d;
    dgb_plan plan;
    bool offered;
    start(context);
    memset(&gd, 0, sizeof gd);
    gd.get_proc = gl_stub_get_proc;
    assert_int_equal(dgbgl_init(&gl, &gd), DGB_OK);
    d = session_of(u, NULL).desc;
    d.backend = &gl.backend;
    offered = dgb_make_plan(&d, &plan) == DGB_OK;
    dgbgl_shutdown(&gl);
    stop();
    return offered;
}

static void check_well(const struct context* context, const setup* u) {
    gl_session s = run(context, u, 0, 0);
    assert_int_equal(s.failures, 0);
    if (gl_stub_refusals())
        fail_msg("%s, effects %u, %s, %s, %d layers, 1/%d: %d refusals, first: %s", context->name, (unsigned)u->effects,
                 dgb_oracle_name(u->oracle), dgb_emission_name(u->emission), u->layers, u->divisor, gl_stub_refusals(),
                 gl_stub_refusal());
    assert_true(engine.draws > 0 || u->source == DGB_SOURCE_ENGINE);
    stop();
}

static void test_every_construction(void** state) {
    int i, oracle, emission, kind, count = 0;
    (void)state;
    for (i = 0; i < CONTEXTS; ++i)
        for (oracle = DGB_ORACLE_PEEL; oracle < DGB_ORACLE_COUNT; ++oracle)
            for (emission = DGB_EMISSION_SEPARATE; emission < DGB_EMISSION_COUNT; ++emission)
                for (kind = 0; kind < 3; ++kind) {
                    setup u;
                    memset(&u, 0, sizeof u);
                    u.oracle = (dgb_oracle)oracle;
                    u.emission = (dgb_emission)emission;
                    u.layers = kind == 2 ? 4 : 2;
                    u.divisor = kind == 1 ? 2 : 1;
                    if (!is_offered(&contexts[i], &u)) continue;
                    check_well(&contexts[i], &u);
                    ++count;
                }
    printf("# %d constructions\n", count);
    assert_true(count > 200);
}

static void test_every_effect(void** state) {
    int i, count = 0;
    unsigned kind;
    (void)state;
    for (i = 0; i < CONTEXTS; ++i)
        for (kind = (unsigned)i; kind < 128u * 16u; kind += (unsigned)stride()) {
            setup u;
            memset(&u, 0, sizeof u);
            u.effects = kind % 128u;
            u.source = kind & 128u ? DGB_SOURCE_ENGINE : DGB_SOURCE_BUILD;
            u.estimator = kind & 256u ? DGB_ESTIMATOR_BITMASK : DGB_ESTIMATOR_PAPER;
            u.tracer = u.estimator == DGB_ESTIMATOR_BITMASK ? DGB_TRACER_LINEAR : DGB_TRACER_HIERARCHICAL;
            u.layers = kind & 512u ? 1 : 2;
            u.thickness = kind & 1024u ? DGB_THICKNESS_BACK_FACES : DGB_THICKNESS_LAYERS;
            if (!is_offered(&contexts[i], &u)) continue;
            check_well(&contexts[i], &u);
            ++count;
        }
    printf("# %d choices of effects\n", count);
    assert_true(count > 2000 / stride());
}

/* >> one thing fails */

/* Contexts and setups that between them use all that the backend knows. */
static const struct trial {
    int context;
    setup u;
} trials[] = {
    {0,
     {DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY, DGB_SOURCE_BUILD, DGB_ORACLE_PREDICT, DGB_EMISSION_GEOMETRY, 3, 1, 0, 0,
      0}},
    {1, {PAPER_EFFECTS, DGB_SOURCE_BUILD, DGB_ORACLE_WARP, DGB_EMISSION_SEPARATE, 2, 2, 0, DGB_TRACER_HIERARCHICAL, 0}},
    {5,
     {ALL_EFFECTS, DGB_SOURCE_BUILD, DGB_ORACLE_REPROJECT, DGB_EMISSION_AUTO, 2, 1, DGB_ESTIMATOR_BITMASK, 0,
      DGB_THICKNESS_BACK_FACES}},
    {6, {DGB_EFFECT_AO | DGB_EFFECT_TEMPORAL, DGB_SOURCE_BUILD, DGB_ORACLE_PEEL, DGB_EMISSION_AUTO, 2, 1, 0, 0, 0}},
    {4, {ALL_EFFECTS, DGB_SOURCE_ENGINE, 0, 0, 2, 1, DGB_ESTIMATOR_BITMASK, 0, DGB_THICKNESS_BACK_FACES}}};
enum { TRIALS = (int)(sizeof trials / sizeof trials[0]) };

enum { INIT_FAULTS = 130 };

/* What a session need not tell of: it goes on without an optional function, without timers. */
static bool may_go_on(void) { return gl_faults_was_lookup() || strcmp(gl_faults_failed(), "glGenQueries") == 0; }

/* False when there was no n-th call that could fail. */
static bool check_fault(const struct trial* t, int n) {
    const gl_session s = run(&contexts[t->context], &t->u, n, 0);
    const char* fault = gl_faults_failed();
    if (fault[0] && !s.failures && !may_go_on())
        fail_msg("%s: %s fails (%d), and nobody says so", engine.context->name, fault, n);
    /* a buffer without storage is drawn with before the driver is asked; GL leaves undefined what that reads */
    if (gl_stub_refusals() && strcmp(fault, "glBufferData") != 0)
        fail_msg("%s: %s fails (%d), then: %s", engine.context->name, fault, n, gl_stub_refusal());
    stop();
    return fault[0] != 0;
}

static void test_every_fault(void** state) {
    int i, n, count = 0;
    (void)state;
    for (i = 0; i < TRIALS; ++i) {
        /* dgbgl_init has little more than entry points, and what else it has must not slip through */
        for (n = 1 + i; check_fault(&trials[i], n); n += i == 2 && n < INIT_FAULTS ? 1 : stride()) ++count;
    }
    printf("# %d faults\n", count);
    assert_true(count > 2000 / stride());
}

/* >> the context is lost */

/* Somebody says so; all calls end, and call nothing that is null. */
static void check_loss(const struct trial* t, int n) {
    const gl_session s = run(&contexts[t->context], &t->u, 0, n);
    if (!s.failures) fail_msg("%s: lost at GL call %d, and nobody says so", engine.context->name, n);
    stop();
    if (n % 64 < stride()) check_well(&contexts[t->context], &t->u); /* anew */
}

static void test_lost_context(void** state) {
    int i, n;
    (void)state;
    for (i = 0; i < TRIALS; ++i) {
        int calls; /* a loss after these need not be noticed */
        run(&contexts[trials[i].context], &trials[i].u, 0, 0);
        calls = engine.last_shade;
        stop();
        assert_true(calls > 1000);
        for (n = 1 + i; n < calls; n += 7 * stride()) check_loss(&trials[i], n);
    }
}

/* >> contexts that will not do */

static int messages;

static void count_message(void* user, const char* text) {
    (void)user, (void)text;
    ++messages;
}

static void check_refused(const gl_stub_desc* desc, int unit, int binding, dgb_result expected) {
    dgbgl_desc gd;
    dgbgl_backend gl, zero;
    memset(&zero, 0, sizeof zero);
    load_own();
    gl_stub_start(desc);
    memset(&gd, 0, sizeof gd);
    gd.get_proc = gl_stub_get_proc;
    gd.message = count_message;
    gd.oracle_unit = unit;
    gd.uniform_binding = binding;
    messages = 0;
    assert_int_equal(dgbgl_init(&gl, &gd), expected);
    assert_int_equal(messages, expected != DGB_OK);
    if (expected != DGB_OK) assert_memory_equal(&gl, &zero, sizeof gl);
    dgbgl_shutdown(&gl);
    assert_int_equal(gl_stub_alive(), 0);
    if (gl_stub_refusals()) fail_msg("%s", gl_stub_refusal());
    gl_stub_stop();
}

static void test_contexts_that_will_not_do(void** state) {
    const gl_stub_desc old = {320, false, NULL, NULL}, es = {300, true, "GL_EXT_color_buffer_floats", NULL};
    const gl_stub_desc* fine = &contexts[0].desc;
    (void)state;
    check_refused(&old, 0, 0, DGB_UNSUPPORTED);
    check_refused(&es, 0, 0, DGB_UNSUPPORTED);
    check_refused(fine, -1, 0, DGB_INVALID);
    check_refused(fine, 48, 0, DGB_INVALID);
    check_refused(fine, 47, 35, DGB_OK);
    check_refused(fine, 0, -1, DGB_INVALID);
    check_refused(fine, 0, 36, DGB_INVALID);
}

/* >> an engine that keeps track of its state itself */

static void check_gets(void* user, const char* call) {
    const bool frame = strcmp(call, "dgb_build") == 0 || strcmp(call, "dgb_shade") == 0;
    (void)user;
    if (frame && gl_stub_gets() != engine.asked)
        fail_msg("%s, %s: %d questions to GL", engine.context->name, call, gl_stub_gets() - engine.asked);
    engine.asked = gl_stub_gets();
}

/* With keep_state no frame asks GL for anything. */
static void test_nothing_is_asked(void** state) {
    int i;
    (void)state;
    for (i = 0; i < CONTEXTS; ++i) {
        const setup u = {PAPER_EFFECTS, DGB_SOURCE_BUILD, DGB_ORACLE_DEFAULT, DGB_EMISSION_AUTO, 2, 1, 0, 0, 0};
        gl_session s = session_of(&u, NULL);
        start(&contexts[i]);
        gl_stub_scramble();
        s.gl.get_proc = gl_stub_get_proc;
        s.gl.keep_state = s.gl.no_timers = true;
        s.after = check_gets;
        gl_session_run(&s);
        assert_int_equal(s.failures, 0);
        stop();
    }
}

/* >> errors of the engine's */

static void draw_badly(void* user, const dgb_draw* d) {
    draw(user, d);
    own.DepthFunc(0); /* GL_INVALID_ENUM */
}

/* What was pending and what the callback leaves is told of, and no failure of the library's. */
static void test_errors_of_the_engine(void** state) {
    static const float projection[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1.002f, -1, 0, 0, -0.2002f, 0};
    const dgb_params q = dgb_preset(DGB_PRESET_BALANCED);
    const setup u = {DGB_EFFECT_AO, DGB_SOURCE_BUILD, DGB_ORACLE_DEFAULT, DGB_EMISSION_SEPARATE, 2, 1, 0, 0, 0};
    dgbgl_desc gd;
    dgbgl_backend gl;
    dgb_desc d = session_of(&u, NULL).desc;
    dgb_context k;
    dgb_view view;
    (void)state;
    start(&contexts[4]);
    memset(&gd, 0, sizeof gd);
    memset(&view, 0, sizeof view);
    memcpy(view.projection, projection, sizeof projection);
    view.view[0] = view.view[5] = view.view[10] = view.view[15] = 1.0f;
    gd.get_proc = gl_stub_get_proc;
    gd.message = count_message;
    assert_int_equal(dgbgl_init(&gl, &gd), DGB_OK);
    d.backend = &gl.backend;
    assert_int_equal(dgb_init(&k, &d), DGB_OK);
    assert_true(make_program(NULL, &k) != 0);
    messages = 0;
    assert_int_equal(dgb_build(&k, &view, &q, draw_badly, NULL), DGB_OK);
    assert_int_equal(messages, 2); /* layers */
    own.DepthFunc(0);
    assert_int_equal(dgb_shade(&k, &q), DGB_OK);
    assert_int_equal(messages, 3);
    assert_int_equal(own.GetError(), GL_NO_ERROR);
    own.DeleteProgram(engine.program);
    dgb_shutdown(&k);
    dgbgl_shutdown(&gl);
    stop();
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_construction),
        cmocka_unit_test(test_every_effect),
        cmocka_unit_test(test_every_fault),
        cmocka_unit_test(test_lost_context),
        cmocka_unit_test(test_contexts_that_will_not_do),
        cmocka_unit_test(test_nothing_is_asked),
        cmocka_unit_test(test_errors_of_the_engine),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
