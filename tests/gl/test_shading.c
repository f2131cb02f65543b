/* dgb_shade: every full-screen pass against a double-precision reference, pixel by pixel; and what must hold
   for any image. */
#include "gl_fixture.h"
#include "numbers.h"
#include "reference.h"
#include "tally.h"

#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { WIDTH = 200, HEIGHT = 120, GUARD = 16 };

static fixture f;

/* >> counting the programs that are created, and changing images between passes */

static int created_programs, compiled_shaders;

static GLuint GLAPIENTRY counting_create_program(void) {
    ++created_programs;
    return glCreateProgram();
}

static void GLAPIENTRY counting_compile_shader(GLuint shader) {
    ++compiled_shaders;
    glCompileShader(shader);
}

static void* counting_get_proc(const char* name) {
    GLuint(GLAPIENTRY * create)(void) = counting_create_program;
    void(GLAPIENTRY * compile)(GLuint) = counting_compile_shader;
    void* address = fixture_get_proc(name);
    if (strcmp(name, "glCreateProgram") == 0) memcpy(&address, &create, sizeof address);
    if (strcmp(name, "glCompileShader") == 0) memcpy(&address, &compile, sizeof address);
    return address;
}

static const dgb_context* raw_context; /* whose raw images the next reconstruction shall find replaced */
static const float *raw_ao, *raw_irradiance;

static dgb_result replacing_pass_begin(void* user, const dgb_pass* pass) {
    if (pass->id == DGB_PASS_RECONSTRUCT && raw_context) {
        fixture_put_image(raw_context, DGB_AO_RAW, 1, raw_ao);
        fixture_put_image(raw_context, DGB_IRRADIANCE_RAW, 4, raw_irradiance);
        raw_context = NULL;
    }
    return f.gl.backend.pass_begin(user, pass);
}

/* >> one image: how it is made, and everything the passes wrote */

typedef struct setup {
    int width, height, guard, layers, divisor, frames;
    dgb_oracle oracle;
    dgb_senders senders;
    dgb_normaliser normaliser;
    dgb_format depth_format;
    fixture_view view;
    float shift[2]; /* of the image plane, for off-centre projections */
    bool moving, nothing;
    const float* uniform_radiance; /* every texel's, null: the scene's */
    const dgb_backend* backend;
    dgb_params params;
} setup;

typedef struct shot {
    dgb_context c;
    int rect[4]; /* shaded: x0, y0, x1, y1, inclusive */
    float *z, *normals, *radiance[2];
    float *ao_raw, *ao_half, *ao, *irradiance_raw, *irradiance_half, *irradiance;
    reference r;
} shot;

static setup default_setup(void) {
    setup s;
    memset(&s, 0, sizeof s);
    s.width = WIDTH;
    s.height = HEIGHT;
    s.guard = GUARD;
    s.layers = 2;
    s.frames = 1;
    s.oracle = DGB_ORACLE_PEEL;
    s.view = fixture_default_view();
    s.params = dgb_preset(DGB_PRESET_BALANCED);
    return s;
}

static dgb_desc desc_of(const setup* s) {
    dgb_desc d = fixture_desc(&f, &s->view, s->width, s->height, s->guard);
    d.layers = s->layers;
    d.divisor = s->divisor;
    d.effects = DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY;
    d.oracle = s->oracle;
    d.senders = s->senders;
    d.normaliser = s->normaliser;
    d.depth_format = s->depth_format;
    if (s->backend) d.backend = s->backend;
    return d;
}

static bool is_offered(const setup* s) {
    const dgb_desc d = desc_of(s);
    return fixture_offers(&f, &d);
}

static dgb_view view_at(const setup* s, int frame) {
    fixture_view v = s->view;
    dgb_view view;
    int i;
    if (s->moving) {
        v.eye[0] += 0.045f * (float)frame;
        v.yaw += 0.006f * (float)frame;
    }
    view = fixture_dgb_view(&v, s->width, s->height);
    for (i = 0; i < 2; ++i) view.projection[v.fov > 0.0f ? 8 + i : 12 + i] += s->shift[i];
    for (i = 0; i < 4; ++i) f.offsets[i] = s->moving ? 0.1f * (float)(frame + i - 2) : 0.0f;
    return view;
}

static void read_shot(shot* s, const dgb_params* q) {
    const dgb_context* c = &s->c;
    s->r.layers = c->plan.layers < 2 ? 1 : 2;
    fixture_shaded_rect(c, q, s->rect);
    s->z = fixture_z(c, 0);
    s->normals = fixture_image(c, DGB_NORMALS, 0, 2 * s->r.layers);
    s->radiance[0] = fixture_image(c, DGB_B0, 0, 3);
    s->radiance[1] = fixture_image(c, DGB_B1, 0, 3);
    s->ao_raw = fixture_shaded(c, DGB_AO_RAW, 1);
    s->ao = fixture_shaded(c, DGB_AO, 1);
    s->irradiance_raw = fixture_shaded(c, DGB_IRRADIANCE_RAW, 4);
    s->irradiance_half = fixture_read_half(dgb_get_texture(c, DGB_HALF), c->plan.width, c->plan.height, &s->ao_half);
    fixture_blank_unshaded(c, s->irradiance_half, 4);
    fixture_blank_unshaded(c, s->ao_half, 1);
    s->irradiance = fixture_shaded(c, DGB_IRRADIANCE, 4);
    reference_open(&s->r, c, s->z, s->normals, (const float* const*)s->radiance);
}

static void free_images(shot* s) {
    float* images[] = {s->z,       s->normals, s->radiance[0],    s->radiance[1],     s->ao_raw,
                       s->ao_half, s->ao,      s->irradiance_raw, s->irradiance_half, s->irradiance};
    size_t i;
    for (i = 0; i < sizeof images / sizeof images[0]; ++i) free(images[i]);
    reference_close(&s->r);
}

static void close_shot(shot* s) {
    free_images(s);
    dgb_shutdown(&s->c);
}

static void build_shot(const setup* s, shot* out) {
    dgb_desc d = desc_of(s);
    fixture_draw_user user;
    int frame;
    memset(out, 0, sizeof *out);
    memset(&user, 0, sizeof user);
    user.f = &f;
    user.nothing = s->nothing;
    assert_int_equal(dgb_init(&out->c, &d), DGB_OK);
    user.program = fixture_program(&out->c);
    assert_true(user.program != 0);
    for (frame = 0; frame < s->frames; ++frame) {
        dgb_view view = view_at(s, frame);
        assert_int_equal(dgb_build(&out->c, &view, &s->params, fixture_draw, &user), DGB_OK);
    }
    glDeleteProgram(user.program);
    if (s->uniform_radiance)
        glClearTexImage(dgbgl_texture_name(dgb_get_texture(&out->c, DGB_RADIANCE)), 0, GL_RGB, GL_FLOAT,
                        s->uniform_radiance);
}

static shot take(const setup* s) {
    shot out;
    build_shot(s, &out);
    assert_int_equal(dgb_shade(&out.c, &s->params), DGB_OK);
    read_shot(&out, &s->params);
    return out;
}

/* >> comparison with the reference

   A stored value may be off by its rounding (R8: half a code; RGBA16F: one ulp, for it may be truncated or
   rounded) and by the error that the reference derives for float arithmetic, of which llvmpipe needs a third
   at most. One pixel in 10,000 may be off by more: a tap on the other side of a texel's edge. */

/* How much of its error bound the sum under the root needs to reach the code stored. */
static double needed_share(const reference_ao* ao, const dgb_params* q, double code) {
    const double edge[2] = {(code - 0.5) / 255.0, (code + 0.5) / 255.0}, scale = q->ao_samples / 3.14159265358979323846;
    const double most = scale * (1.0 - edge[0]) * (1.0 - edge[0]), least = scale * (1.0 - edge[1]) * (1.0 - edge[1]);
    if (ao->empty || ao->error == 0.0 || ao->reach < 3.0 || q->ao_intensity != 1.0f || code < 1.0) return 0.0;
    if (ao->sum > most) return (ao->sum - most) / ao->error;
    return code < 255.0 && ao->sum < least ? (least - ao->sum) / ao->error : 0.0;
}

static void compare_ao(const shot* s, const dgb_params* q) {
    tally t = tally_of("ao raw");
    int x, y;
    for (y = s->rect[1]; y <= s->rect[3]; ++y)
        for (x = s->rect[0]; x <= s->rect[2]; ++x) {
            const reference_ao ao = reference_occlusion(&s->r, q, x, y);
            const double code = floor(255.0 * (double)s->ao_raw[y * s->r.width + x] + 0.5);
            const double need = needed_share(&ao, q, code);
            const int wrong = t.wrong;
            tally_code(&t, code, reference_visibility(&ao, q, ao.sum + ao.error) - 1e-6,
                       reference_visibility(&ao, q, ao.sum - ao.error) + 1e-6, reference_visibility(&ao, q, ao.sum));
            if (t.wrong == wrong && need > t.needed) t.needed = need;
        }
    tally_report(&t);
}

static void compare_light(const shot* s, const setup* how) {
    tally t = tally_of("irradiance"), confidence = tally_of("confidence");
    tally doubtful = tally_of("in plane");
    int x, y, i;
    for (y = s->rect[1]; y <= s->rect[3]; ++y)
        for (x = s->rect[0]; x <= s->rect[2]; ++x) {
            const reference_light e = reference_irradiance(&s->r, &how->params, how->senders, how->normaliser, 0, x, y);
            const float* value = s->irradiance_raw + 4 * (y * s->r.width + x);
            doubtful.doubtful += e.doubtful > 0;
            t.unsure += e.unsure;
            if (e.unsure) continue;
            for (i = 0; i < 3; ++i) tally_half(e.doubtful ? &doubtful : &t, (double)value[i], e.low[i], e.high[i]);
            tally_half(&confidence, (double)value[3], e.low_confidence, e.high_confidence);
        }
    tally_report(&t);
    tally_report(&doubtful);
    /* with the normal test next to nothing hangs on rounding, or the comparison would mean little */
    if (how->params.normal_test) assert_true(20 * doubtful.doubtful <= t.pixels + doubtful.pixels);
    tally_report(&confidence);
}

/* Along one axis, from the image that the pass read to the one it wrote. */
static void compare_filter(const shot* s, const dgb_params* q, int axis) {
    const float *from_ao = axis ? s->ao_half : s->ao_raw, *to_ao = axis ? s->ao : s->ao_half;
    const float *from = axis ? s->irradiance_half : s->irradiance_raw, *to = axis ? s->irradiance : s->irradiance_half;
    tally ao = tally_of(axis ? "ao" : "ao half");
    tally e = tally_of(axis ? "E" : "E half");
    int x, y, i;
    for (y = s->rect[1]; y <= s->rect[3]; ++y)
        for (x = s->rect[0]; x <= s->rect[2]; ++x) {
            const int at = y * s->r.width + x;
            const reference_filtered a = reference_reconstruct(&s->r, q, axis, 0, s->rect, from_ao, 1, x, y);
            const reference_filtered b = reference_reconstruct(&s->r, q, axis, 0, s->rect, from, 4, x, y);
            tally_code(&ao, floor(255.0 * (double)to_ao[at] + 0.5), a.value[0] - a.error[0], a.value[0] + a.error[0],
                       a.value[0]);
            for (i = 0; i < 4; ++i)
                tally_half(&e, (double)to[4 * at + i], b.value[i] - b.error[i], b.value[i] + b.error[i]);
        }
    tally_report(&ao);
    tally_report(&e);
}

static void compare_levels(const shot* s) {
    int level;
    assert_int_equal(s->c.plan.levels, s->r.levels);
    for (level = 1; level < s->r.levels; ++level) {
        const size_t texels =
            (size_t)reference_size(s->r.width, level) * (size_t)reference_size(s->r.height, level) * sizeof(float);
        float *z = fixture_z(&s->c, level), *normals = fixture_image(&s->c, DGB_NORMALS, level, 2 * s->r.layers),
              *b = fixture_image(&s->c, DGB_B0, level, 3);
        assert_memory_equal(z, s->r.z[level], texels * (size_t)s->r.layers);
        assert_memory_equal(normals, s->r.normals[level], texels * (size_t)(2 * s->r.layers));
        assert_memory_equal(b, s->r.radiance[0][level], texels * 3);
        free(z), free(normals), free(b);
        if (s->r.layers == 1) continue;
        b = fixture_image(&s->c, DGB_B1, level, 3);
        assert_memory_equal(b, s->r.radiance[1][level], texels * 3);
        free(b);
    }
}

static bool in_range(const float* values, size_t count, float low, float high) {
    size_t i;
    for (i = 0; i < count; ++i)
        if (!(values[i] >= low && values[i] <= high)) return false; /* NaN too */
    return true;
}

/* Every image is finite and in range. */
static void check_ranges(const shot* s) {
    const size_t texels = (size_t)s->r.width * (size_t)s->r.height;
    const float* light[] = {s->irradiance_raw, s->irradiance_half, s->irradiance};
    size_t i, k;
    assert_true(in_range(s->z, texels * (size_t)s->r.layers, -DGB_MAX_DISTANCE, DGB_MAX_DISTANCE));
    assert_true(in_range(s->normals, texels * (size_t)(2 * s->r.layers), 0.0f, 1.0f));
    for (i = 0; i < (size_t)s->r.layers; ++i) assert_true(in_range(s->radiance[i], texels * 3, 0.0f, DGB_MAX_RADIANCE));
    assert_true(in_range(s->ao_raw, texels, 0.0f, 1.0f));
    assert_true(in_range(s->ao_half, texels, 0.0f, 1.0f));
    assert_true(in_range(s->ao, texels, 0.0f, 1.0f));
    for (k = 0; k < 3; ++k) {
        assert_true(in_range(light[k], texels * 4, 0.0f, DGB_MAX_RADIANCE));
        for (i = 0; i < texels; ++i) assert_true(light[k][4 * i + 3] <= 1.0f);
    }
}

static int filled_texels(const shot* s, int layer) {
    int i, count = 0;
    for (i = 0; i < s->r.width * s->r.height; ++i) count += s->z[i * s->r.layers + layer] != 0.0f;
    return count;
}

static void compare_all(const char* name, const setup* s) {
    shot t = take(s);
    printf("# %s: %d of %d texels in layer 1\n", name, s->layers > 1 ? filled_texels(&t, 1) : 0,
           t.r.width * t.r.height);
    compare_levels(&t);
    compare_ao(&t, &s->params);
    compare_light(&t, s);
    compare_filter(&t, &s->params, 0);
    compare_filter(&t, &s->params, 1);
    check_ranges(&t);
    close_shot(&t);
}

/* >> the passes against the reference */

static void test_reference(void** state) {
    setup s = default_setup();
    (void)state;
    compare_all("two layers", &s);
    s.layers = 1;
    compare_all("one layer", &s);
    s = default_setup();
    s.layers = 3;
    compare_all("three layers, two shaded", &s);
    s.layers = 2;
    s.divisor = 2;
    if (is_offered(&s)) compare_all("layer 1 at half the resolution", &s);
    s.divisor = 4;
    s.width += 1; /* no multiple of it */
    if (is_offered(&s)) compare_all("layer 1 at a quarter of the resolution", &s);
}

static void test_reference_cameras(void** state) {
    setup s = default_setup();
    (void)state;
    s.view.reversed = true, s.view.clip = DGB_CLIP_ZERO_TO_ONE, s.view.far_plane = 0.0f;
    if (is_offered(&s)) compare_all("reversed, infinite", &s);
    s = default_setup();
    s.shift[0] = 0.31f, s.shift[1] = -0.17f;
    s.view.jitter[0] = 0.37f, s.view.jitter[1] = -0.22f;
    compare_all("off-centre, jittered", &s);
    s = default_setup();
    s.view.fov = 0.0f;
    compare_all("orthographic", &s);
    s.shift[0] = 0.11f, s.shift[1] = 0.23f;
    s.view.reversed = true, s.view.clip = DGB_CLIP_ZERO_TO_ONE;
    if (is_offered(&s)) compare_all("orthographic, off-centre, reversed", &s);
    s = default_setup();
    s.depth_format = DGB_FORMAT_D16;
    compare_all("D16", &s);
}

static void test_reference_options(void** state) {
    int kind;
    (void)state;
    for (kind = 0; kind < 8; ++kind) {
        setup s = default_setup();
        s.params.normal_test = (kind & 1) != 0;
        s.senders = kind & 2 ? DGB_SENDERS_STRONGEST : DGB_SENDERS_BOTH;
        s.normaliser = kind & 4 ? DGB_NORMALISER_PAPER : DGB_NORMALISER_BOUNDED;
        printf("# normal test %d, senders %d, normaliser %d\n", kind & 1, kind & 2, kind & 4);
        compare_all("options", &s);
    }
}

static void test_reference_params(void** state) {
    setup s = default_setup();
    int preset;
    (void)state;
    for (preset = 0; preset < DGB_PRESET_COUNT; ++preset) {
        s.params = dgb_preset((dgb_preset_id)preset);
        compare_all("preset", &s);
    }
    s = default_setup();
    s.params.ao_radius = 0.12f; /* under three pixels in most of the image */
    s.params.ao_intensity = 1.7f;
    s.params.ao_min_level = 2;
    s.params.ao_samples = 5, s.params.samples = 99, s.params.radius = 1.5f;
    s.params.filter_taps = 25, s.params.filter_step = 3;
    s.params.normal_sharpness = 0.5f, s.params.plane_sharpness = 0.25f;
    compare_all("odd parameters", &s);
    s = default_setup();
    s.params.ao_samples = s.params.samples = 256;
    s.params.ao_radius = 40.0f, s.params.radius = 4000.0f; /* taps on every border */
    s.params.ao_bias = 0.0f, s.params.ao_epsilon = 0.0f;
    s.width = 90, s.height = 50;
    compare_all("huge radii", &s);
}

static void test_reference_sizes(void** state) {
    static const int sizes[][3] = {{1, 1, 0},   {1, 7, 0},   {7, 1, 0}, {33, 17, 0},
                                   {33, 17, 5}, {64, 64, 0}, {3, 2, 1}, {127, 65, 3}};
    size_t i;
    (void)state;
    for (i = 0; i < sizeof sizes / sizeof sizes[0]; ++i) {
        setup s = default_setup();
        s.width = sizes[i][0];
        s.height = sizes[i][1];
        s.guard = sizes[i][2];
        printf("# %dx%d, guard band %d\n", s.width, s.height, s.guard);
        compare_all("size", &s);
    }
}

/* >> pack */

/* What the pack pass should make of a texel of a layer, from the texture that the layers pass wrote. */
static void check_packed_layer(const shot* s, int layer, double* worst) {
    const dgb_context* c = &s->c;
    const int w = s->r.width, h = s->r.height, l = c->plan.layers;
    float* depth = fixture_read(dgb_get_texture(c, DGB_DEPTH), 0, layer, w, h, l, GL_DEPTH_COMPONENT, 1);
    float* normal = fixture_read(dgb_get_texture(c, DGB_NORMAL), 0, layer, w, h, l, GL_RGBA, 4);
    float* radiance = fixture_read(dgb_get_texture(c, DGB_RADIANCE), 0, layer, w, h, l, GL_RGB, 3);
    const float nothing[3] = {0.0f, 0.0f, 0.0f};
    int i;
    for (i = 0; i < w * h; ++i) {
        const int d = layer > 0 ? s->r.divisor : 1, from = i / w / d * w + i % w / d; /* texel of the layer */
        const float z = s->z[i * s->r.layers + layer], expected = dgb_linear_z(depth[from], &c->camera);
        const double error = fabs((double)z - (double)expected);
        if (layer && z == 0.0f && !dgb_keep_test(expected, s->z[i * s->r.layers], 0.5f)) continue;
        assert_true((z == 0.0f) == (expected == 0.0f));
        assert_true(error <= 4.0 * REFERENCE_EPSILON * fabs((double)expected));
        *worst = error > *worst * fabs((double)z) ? error / fabs((double)z) : *worst;
        assert_memory_equal(s->normals + (i * s->r.layers + layer) * 2, z != 0.0f ? normal + 4 * from : nothing,
                            2 * sizeof(float));
        assert_memory_equal(s->radiance[layer] + 3 * i, z != 0.0f ? radiance + 3 * from : nothing, 3 * sizeof(float));
    }
    free(depth), free(normal), free(radiance);
}

static void test_pack(void** state) {
    int kind, layer;
    (void)state;
    for (kind = 0; kind < 5; ++kind) {
        setup s = default_setup();
        shot t;
        double worst = 0.0;
        if (kind == 1) s.view.reversed = true, s.view.clip = DGB_CLIP_ZERO_TO_ONE, s.view.far_plane = 0.0f;
        if (kind == 2) s.view.fov = 0.0f;
        if (kind == 3) s.layers = 1;
        if (kind == 4) s.divisor = 4, s.width += 3;
        if (!is_offered(&s)) continue;
        t = take(&s);
        for (layer = 0; layer < s.layers; ++layer) check_packed_layer(&t, layer, &worst);
        printf("# camera z off by %g relative at most\n", worst);
        close_shot(&t);
    }
}

/* The engine's own normals and radiance, packed on the device and in C. */
typedef struct engine { /* images of DGB_SOURCE_ENGINE: depth 1, normal and radiance 3 floats a texel */
    int width, height;
    float *depth[2], *normal[2], *radiance[2];
    GLuint textures[6];
} engine;

static engine engine_of(int width, int height) {
    const size_t texels = (size_t)width * (size_t)height;
    engine e;
    int layer;
    memset(&e, 0, sizeof e);
    e.width = width;
    e.height = height;
    for (layer = 0; layer < 2; ++layer) {
        e.depth[layer] = (float*)calloc(texels, sizeof(float));
        e.normal[layer] = (float*)calloc(3 * texels, sizeof(float));
        e.radiance[layer] = (float*)calloc(3 * texels, sizeof(float));
    }
    glGenTextures(6, e.textures);
    return e;
}

static dgb_texture upload(GLuint name, GLint internal, const engine* e, GLenum format, const float* texels) {
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glBindTexture(GL_TEXTURE_2D, name);
    glTexImage2D(GL_TEXTURE_2D, 0, internal, e->width, e->height, 0, format, GL_FLOAT, texels);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
    glBindTexture(GL_TEXTURE_2D, 0);
    return dgbgl_texture(name);
}

static void close_engine(engine* e) {
    int layer;
    for (layer = 0; layer < 2; ++layer) {
        free(e->depth[layer]);
        free(e->normal[layer]);
        free(e->radiance[layer]);
    }
    glDeleteTextures(6, e->textures);
}

/* Depth in a reversed infinite projection: near / distance. */
static fixture_view engine_camera(void) {
    fixture_view v = fixture_default_view();
    v.reversed = true;
    v.clip = DGB_CLIP_ZERO_TO_ONE;
    v.far_plane = 0.0f;
    return v;
}

static dgb_view engine_view(const engine* e) {
    const fixture_view v = engine_camera();
    return fixture_dgb_view(&v, e->width, e->height);
}

static dgb_desc engine_desc(const engine* e, int layers, dgb_normals normals) {
    const fixture_view v = engine_camera();
    dgb_desc d = fixture_desc(&f, &v, e->width, e->height, 0);
    d.layers = layers;
    d.effects = DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY;
    d.source = DGB_SOURCE_ENGINE;
    d.normals = normals;
    return d;
}

static shot shade_engine(const engine* e, int layers, dgb_normals normals, const dgb_params* q) {
    dgb_desc d = engine_desc(e, layers, normals);
    dgb_view view = engine_view(e);
    dgb_layers given;
    shot s;
    int l;
    memset(&given, 0, sizeof given);
    memset(&s, 0, sizeof s);
    for (l = 0; l < layers; ++l) {
        given.depth[l] = upload(e->textures[l], GL_R32F, e, GL_RED, e->depth[l]);
        given.normal[l] = upload(e->textures[2 + l], GL_RGB32F, e, GL_RGB, e->normal[l]);
        given.radiance[l] = upload(e->textures[4 + l], GL_RGB32F, e, GL_RGB, e->radiance[l]);
    }
    assert_int_equal(dgb_init(&s.c, &d), DGB_OK);
    assert_int_equal(dgb_set_layers(&s.c, &view, &given), DGB_OK);
    assert_int_equal(dgb_shade(&s.c, q), DGB_OK);
    read_shot(&s, q);
    return s;
}

static uint32_t random_state = 1u;

static float random_in(float low, float high) {
    return low + (high - low) * (float)(lcg_bits(&random_state) >> 8) / 16777216.0f;
}

static void fill_random(engine* e) {
    int layer, i, k;
    for (layer = 0; layer < 2; ++layer)
        for (i = 0; i < e->width * e->height; ++i) {
            e->depth[layer][i] = 0.1f / random_in(2.0f, 6.0f);
            for (k = 0; k < 3; ++k) {
                e->normal[layer][3 * i + k] = random_in(-1.0f, 1.0f);
                e->radiance[layer][3 * i + k] = expf(random_in(-9.0f, 9.0f));
            }
        }
}

static void test_pack_engine(void** state) {
    engine e = engine_of(97, 61);
    dgb_params q = dgb_preset(DGB_PRESET_QUALITY);
    shot s;
    int layer, i, k, other_normals = 0, other_radiance = 0;
    (void)state;
    fill_random(&e);
    q.strict_separation = false;
    s = shade_engine(&e, 2, DGB_NORMALS_FLOAT, &q);
    for (layer = 0; layer < 2; ++layer)
        for (i = 0; i < e.width * e.height; ++i) {
            const unsigned code = dgb_oct16_encode(e.normal[layer] + 3 * i);
            const uint32_t b = dgb_r11g11b10f_pack(e.radiance[layer] + 3 * i);
            float rgb[3];
            dgb_r11g11b10f_unpack(b, rgb);
            for (k = 0; k < 2; ++k)
                other_normals +=
                    floor(255.0 * (double)s.normals[4 * i + 2 * layer + k] + 0.5) != (code >> 8 * k & 255u);
            for (k = 0; k < 3; ++k) /* the device may truncate */
                other_radiance +=
                    fabsf(s.radiance[layer][3 * i + k] - rgb[k]) > rgb[k] * (k == 2 ? 1.0f / 32.0f : 1.0f / 64.0f);
        }
    printf("# normals of another code: %d, radiance more than a code off: %d\n", other_normals, other_radiance);
    assert_int_equal(other_normals, 0);
    assert_int_equal(other_radiance, 0);
    compare_levels(&s);
    compare_ao(&s, &q);
    close_shot(&s);
    close_engine(&e);
}

/* Nothing that an engine's textures hold may come out as NaN, infinite or out of range. */
static void test_any_input(void** state) {
    int round, normals, layer, i;
    (void)state;
    for (round = 0; round < 3; ++round)
        for (normals = 0; normals < DGB_NORMALS_COUNT; ++normals) {
            engine e = engine_of(64, 48);
            dgb_params q = dgb_preset((dgb_preset_id)round);
            shot s;
            fill_random(&e);
            for (layer = 0; layer < 2; ++layer)
                for (i = 0; i < 3 * e.width * e.height; ++i) {
                    if (round == 1 && i < e.width * e.height) e.depth[layer][i] = lcg_pattern(&random_state);
                    e.normal[layer][i] = lcg_pattern(&random_state);
                    e.radiance[layer][i] = lcg_pattern(&random_state);
                }
            q.ao_epsilon = round == 2 ? 0.0f : q.ao_epsilon;
            s = shade_engine(&e, 2, (dgb_normals)normals, &q);
            check_ranges(&s);
            close_shot(&s);
            close_engine(&e);
        }
}

/* >> strict separation */

static int separation_violations(const shot* s, float separation) {
    int i, count = 0;
    for (i = 0; i < s->r.width * s->r.height; ++i)
        count += s->z[2 * i + 1] != 0.0f && !dgb_keep_test(s->z[2 * i + 1], s->z[2 * i], separation);
    return count;
}

static void test_strict_separation(void** state) {
    int strict, violations[2], filled[2];
    (void)state;
    for (strict = 0; strict < 2; ++strict) {
        setup s = default_setup();
        shot t;
        s.oracle = DGB_ORACLE_PREVIOUS;
        s.moving = true;
        s.frames = 6;
        s.params.strict_separation = strict != 0;
        t = take(&s);
        violations[strict] = separation_violations(&t, s.params.separation);
        filled[strict] = filled_texels(&t, 1);
        close_shot(&t);
    }
    printf("# violations: %d of %d as built, %d of %d strict\n", violations[0], filled[0], violations[1], filled[1]);
    assert_true(violations[0] > 100);
    assert_int_equal(violations[1], 0);
    assert_int_equal(filled[0] - violations[0], filled[1]); /* nothing else was lost */
}

/* >> occlusion: what must hold for any image */

/* A plane through (0, 0, -distance) over the whole image, the second layer a parallel one a metre behind. */
static void fill_plane(engine* e, const double n[3], double distance) {
    const dgb_view view = engine_view(e);
    int x, y, layer, k;
    for (layer = 0; layer < 2; ++layer)
        for (y = 0; y < e->height; ++y)
            for (x = 0; x < e->width; ++x) {
                const int i = y * e->width + x;
                const double ray_x = (2.0 * (x + 0.5) / e->width - 1.0) / (double)view.projection[0];
                const double ray_y = (2.0 * (y + 0.5) / e->height - 1.0) / (double)view.projection[5];
                /* n . (ray d) = n . (0, 0, -distance), ray = (x, y, -1) */
                const double d = -n[2] * (distance + layer) / (n[0] * ray_x + n[1] * ray_y - n[2]);
                e->depth[layer][i] = d > 0.11 && d < 1e4 ? (float)(0.1 / d) : 0.0f;
                for (k = 0; k < 3; ++k) e->normal[layer][3 * i + k] = (float)n[k];
            }
}

static void check_flat_plane(int k, int layers, dgb_normals normals) {
    const double tilt = k * 0.05, turn = k * 2.4;
    const double n[3] = {sin(tilt) * cos(turn), sin(tilt) * sin(turn), cos(tilt)};
    dgb_params q = dgb_preset(DGB_PRESET_QUALITY);
    engine e = engine_of(120, 90);
    shot s;
    int x, y;
    q.ao_samples = 8 + 4 * k;
    q.ao_min_level = k % 3;
    fill_plane(&e, n, 3.0 + k % 5);
    s = shade_engine(&e, layers, normals, &q);
    for (y = 0; y < e.height; ++y)
        for (x = 0; x < e.width; ++x) {
            assert_true(reference_occlusion(&s.r, &q, x, y).sum == 0.0);
            assert_true(s.ao_raw[y * e.width + x] == 1.0f && s.ao[y * e.width + x] == 1.0f);
        }
    close_shot(&s);
    close_engine(&e);
}

static void test_flat_plane(void** state) {
    int k, layers;
    (void)state;
    for (k = 0; k < 24; ++k)
        for (layers = 1; layers <= 2; ++layers) check_flat_plane(k, layers, DGB_NORMALS_FLOAT);
}

static void test_flat_plane_from_depth(void** state) {
    int k, layers;
    (void)state;
    for (k = 0; k < 24; ++k)
        for (layers = 1; layers <= 2; ++layers) check_flat_plane(k, layers, DGB_NORMALS_FROM_DEPTH);
}

static void test_sky(void** state) {
    setup s = default_setup();
    shot t;
    int x, y, i;
    (void)state;
    s.nothing = true;
    t = take(&s);
    for (y = t.rect[1]; y <= t.rect[3]; ++y)
        for (x = t.rect[0]; x <= t.rect[2]; ++x) {
            const int at = y * t.r.width + x;
            assert_true(t.z[2 * at] == 0.0f && t.z[2 * at + 1] == 0.0f);
            assert_true(t.ao_raw[at] == 1.0f && t.ao[at] == 1.0f);
            for (i = 0; i < 4; ++i)
                assert_true(t.irradiance_raw[4 * at + i] == 0.0f && t.irradiance[4 * at + i] == 0.0f);
        }
    close_shot(&t);
}

static void test_second_layer_only_darkens(void** state) {
    setup s = default_setup();
    shot one, two;
    int x, y, darker = 0;
    (void)state;
    two = take(&s);
    s.layers = 1;
    one = take(&s);
    for (y = one.rect[1]; y <= one.rect[3]; ++y)
        for (x = one.rect[0]; x <= one.rect[2]; ++x) {
            const int at = y * one.r.width + x;
            assert_true(two.z[2 * at] == one.z[at]);
            assert_true(two.ao_raw[at] <= one.ao_raw[at]);
            darker += two.ao_raw[at] < one.ao_raw[at];
        }
    printf("# darker with two layers: %d pixels\n", darker);
    assert_true(darker > 100);
    close_shot(&one);
    close_shot(&two);
}

/* No absolute length hides anywhere: world, radii and separation times a power of two change no bit. */
static void test_scale(void** state) {
    static const float scales[] = {1024.0f, 1.0f / 64.0f};
    static const float radiance[3] = {1.0f, 0.25f, 6.0f}; /* the scene's own material knows lengths */
    setup s = default_setup();
    shot a, b;
    size_t texels, i, k;
    (void)state;
    s.uniform_radiance = radiance;
    a = take(&s);
    texels = (size_t)a.r.width * (size_t)a.r.height;
    for (k = 0; k < 2; ++k) {
        s = default_setup();
        s.uniform_radiance = radiance;
        s.view.scale = scales[k];
        s.params.separation *= scales[k], s.params.ao_radius *= scales[k], s.params.radius *= scales[k];
        b = take(&s);
        for (i = 0; i < 2 * texels; ++i) assert_true(b.z[i] == a.z[i] * scales[k]);
        assert_memory_equal(a.ao_raw, b.ao_raw, texels * sizeof(float));
        assert_memory_equal(a.irradiance_raw, b.irradiance_raw, 4 * texels * sizeof(float));
        assert_memory_equal(a.ao, b.ao, texels * sizeof(float));
        assert_memory_equal(a.irradiance, b.irradiance, 4 * texels * sizeof(float));
        close_shot(&b);
    }
    close_shot(&a);
}

/* >> radiosity */

/* Senders that all send c give at most pi c, whatever they are and however many. */
static void test_energy(void** state) {
    static const float c[3] = {1.0f, 0.25f, 6.0f};
    int kind, x, y, i;
    (void)state;
    for (kind = 0; kind < 4; ++kind) {
        setup s = default_setup();
        shot t;
        double most = 0.0;
        s.uniform_radiance = c;
        s.params.normal_test = (kind & 1) != 0;
        s.senders = kind & 2 ? DGB_SENDERS_STRONGEST : DGB_SENDERS_BOTH;
        t = take(&s);
        for (y = t.rect[1]; y <= t.rect[3]; ++y)
            for (x = t.rect[0]; x <= t.rect[2]; ++x)
                for (i = 0; i < 3; ++i) {
                    const double e =
                        (double)t.irradiance_raw[4 * (y * t.r.width + x) + i] / (3.14159265358979 * (double)c[i]);
                    most = e > most ? e : most;
                }
        printf("# all send 1: irradiance over pi is %.6f at most\n", most);
        assert_true(most <= 1.0 + 1.0 / 2048.0);
        assert_true(most > 0.9); /* and the bound is reached, or this means nothing */
        close_shot(&t);
    }
}

/* >> reconstruction */

/* Shades with the given raw images in place of those that the passes before made. */
static shot reconstruct(setup* s, const float* ao, const float* irradiance) {
    dgb_backend hooked = f.gl.backend;
    shot t;
    hooked.pass_begin = replacing_pass_begin;
    s->backend = &hooked;
    build_shot(s, &t);
    raw_context = &t.c;
    raw_ao = ao;
    raw_irradiance = irradiance;
    assert_int_equal(dgb_shade(&t.c, &s->params), DGB_OK);
    assert_null(raw_context);
    read_shot(&t, &s->params);
    s->backend = NULL;
    return t;
}

static void raw_images(const setup* s, float** ao, float** irradiance) {
    const size_t texels = (size_t)(s->width + 2 * s->guard) * (size_t)(s->height + 2 * s->guard);
    *ao = (float*)malloc(texels * sizeof(float));
    *irradiance = (float*)malloc(4 * texels * sizeof(float));
}

static void check_constant(setup* s, float ao_value, const float light[4], double ulps) {
    const int texels = (s->width + 2 * s->guard) * (s->height + 2 * s->guard);
    float *ao, *irradiance;
    shot t;
    int i, x, y;
    double worst = 0.0;
    raw_images(s, &ao, &irradiance);
    for (i = 0; i < texels; ++i) ao[i] = ao_value;
    for (i = 0; i < 4 * texels; ++i) irradiance[i] = light[i % 4];
    t = reconstruct(s, ao, irradiance);
    for (y = t.rect[1]; y <= t.rect[3]; ++y)
        for (x = t.rect[0]; x <= t.rect[2]; ++x) {
            const int at = y * t.r.width + x;
            assert_true(t.ao[at] == t.ao_raw[at]);
            for (i = 0; i < 4; ++i) {
                const double value = (double)t.irradiance_raw[4 * at + i];
                const double off = fabs((double)t.irradiance[4 * at + i] - value) / tally_half_ulp(value);
                worst = off > worst ? off : worst;
            }
        }
    printf("# constant %g: off by %g ulps of a half at most\n", (double)light[0], worst);
    assert_true(worst <= ulps);
    close_shot(&t);
    free(ao), free(irradiance);
}

/* A power of two comes back exactly: its sums round as those of the weights do. Others may lose an ulp a
   pass. */
static void test_constant_stays(void** state) {
    static const int sizes[][3] = {{WIDTH, HEIGHT, GUARD}, {1, 1, 0}, {1, 7, 0}, {33, 17, 3}};
    const float exact[4] = {4.0f, 0.5f, 32768.0f, 0.25f}, other[4] = {1.7f, 0.3f, 60000.0f, 0.7f};
    size_t i;
    (void)state;
    for (i = 0; i < sizeof sizes / sizeof sizes[0]; ++i) {
        setup s = default_setup();
        s.width = sizes[i][0];
        s.height = sizes[i][1];
        s.guard = sizes[i][2];
        check_constant(&s, 102.0f / 255.0f, exact, 0.0);
        check_constant(&s, 1.0f, other, 2.0);
    }
}

/* Noise: every weight counts, those at the border of the shaded rectangle too. What lies outside must not
   count. */
static void test_noise(void** state) {
    setup s = default_setup();
    float *ao, *irradiance;
    int texels = (s.width + 2 * s.guard) * (s.height + 2 * s.guard), i, fraction;
    shot t;
    (void)state;
    raw_images(&s, &ao, &irradiance);
    for (i = 0; i < texels; ++i) ao[i] = (float)(lcg_bits(&random_state) >> 24) / 255.0f;
    for (i = 0; i < 4 * texels; ++i) irradiance[i] = i % 4 == 3 ? random_in(0.0f, 1.0f) : expf(random_in(-6.0f, 6.0f));
    for (fraction = 0; fraction < 3; ++fraction) {
        s.params.guard_fraction = 0.5f * (float)fraction;
        t = reconstruct(&s, ao, irradiance);
        compare_filter(&t, &s.params, 0);
        compare_filter(&t, &s.params, 1);
        close_shot(&t);
    }
    free(ao), free(irradiance);
}

static void test_one_tap_copies(void** state) {
    setup s = default_setup();
    shot t;
    int x, y;
    (void)state;
    s.params.filter_taps = 1;
    t = take(&s);
    for (y = t.rect[1]; y <= t.rect[3]; ++y)
        for (x = t.rect[0]; x <= t.rect[2]; ++x) {
            const int at = y * t.r.width + x;
            assert_true(t.ao[at] == t.ao_raw[at]);
            assert_memory_equal(t.irradiance + 4 * at, t.irradiance_raw + 4 * at, 4 * sizeof(float));
        }
    close_shot(&t);
}

/* >> presets at run time */

static void test_presets_switch(void** state) {
    setup s = default_setup();
    shot t;
    float *before, *again;
    int programs, shaders, preset;
    (void)state;
    build_shot(&s, &t);
    assert_int_equal(dgb_shade(&t.c, &s.params), DGB_OK);
    before = fixture_image(&t.c, DGB_IRRADIANCE, 0, 4);
    programs = created_programs;
    shaders = compiled_shaders;
    assert_true(programs > 0 && shaders > 0); /* the counters count */
    for (preset = 0; preset < 2 * DGB_PRESET_COUNT; ++preset) {
        const dgb_params q = dgb_preset((dgb_preset_id)(preset % DGB_PRESET_COUNT));
        assert_int_equal(dgb_shade(&t.c, &q), DGB_OK);
        again = fixture_image(&t.c, DGB_IRRADIANCE, 0, 4);
        if (preset % DGB_PRESET_COUNT != DGB_PRESET_BALANCED)
            assert_memory_not_equal(again, before, (size_t)(4 * t.c.plan.width * t.c.plan.height) * sizeof(float));
        free(again);
    }
    assert_int_equal(created_programs, programs);
    assert_int_equal(compiled_shaders, shaders);
    free(before);
    close_shot(&t);
}

static void test_no_messages(void** state) {
    (void)state;
    assert_int_equal(f.messages, 0);
    assert_int_equal(glGetError(), GL_NO_ERROR);
}

static int open_context(void** state) {
    dgbgl_desc d;
    (void)state;
    memset(&d, 0, sizeof d);
    d.get_proc = counting_get_proc;
    return fixture_open(&f, 4, 5, false, &d);
}

static int close_context(void** state) {
    (void)state;
    fixture_close(&f);
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_reference),
        cmocka_unit_test(test_reference_cameras),
        cmocka_unit_test(test_reference_options),
        cmocka_unit_test(test_reference_params),
        cmocka_unit_test(test_reference_sizes),
        cmocka_unit_test(test_pack),
        cmocka_unit_test(test_pack_engine),
        cmocka_unit_test(test_any_input),
        cmocka_unit_test(test_strict_separation),
        cmocka_unit_test(test_flat_plane),
        cmocka_unit_test(test_flat_plane_from_depth),
        cmocka_unit_test(test_sky),
        cmocka_unit_test(test_second_layer_only_darkens),
        cmocka_unit_test(test_scale),
        cmocka_unit_test(test_energy),
        cmocka_unit_test(test_constant_stays),
        cmocka_unit_test(test_noise),
        cmocka_unit_test(test_one_tap_copies),
        cmocka_unit_test(test_presets_switch),
        cmocka_unit_test(test_no_messages),
    };
    return cmocka_run_group_tests(tests, open_context, close_context);
}
