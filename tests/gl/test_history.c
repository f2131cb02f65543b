/* What one frame takes from the frame before: many bounces, deep propagation and the temporal filter, against the
   double-precision reference at every pixel; and what must hold for any image. */
#include "gl_fixture.h"
#include "reference.h"
#include "tally.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { WIDTH = 120, HEIGHT = 80, GUARD = 12 };

#define ALL (DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY | DGB_EFFECT_BOUNCES | DGB_EFFECT_TEMPORAL)

static fixture f;

/* >> how a film is made, and all that is known of one frame */

typedef struct how {
    int width, height, guard, layers, divisor;
    uint32_t effects;
    dgb_oracle oracle;
    bool engine;   /* the layers are the engine's own: built by a context of its own, and copied */
    bool approach; /* with a third component of velocity */
    bool nothing;  /* an empty scene */
    dgb_format depth_format;
    fixture_view view; /* of frame 0 */
    float step[3], turn, zoom,
        shake;  /* of the camera a frame: m, radians, degrees of the field of view, pixels of jitter */
    float walk; /* of the box a frame, m */
    const float* uniform_radiance; /* every texel's, null: the scene's */
    dgb_params params;
} how;

typedef struct frame {
    dgb_params params;
    float view[16], projection[16]; /* widened and jittered */
    int rect[4];                    /* shaded: x0, y0, x1, y1, inclusive */
    float *z, *normals, *sent[2];
    float *radiance[2], *albedo[2], *velocity[2]; /* of the layers at each pixel: 3 a pixel */
    float *ao_raw, *frames, *ao, *raw[2], *mean[2], *half[2], *light[2];
    reference r;
} frame;

typedef struct film {
    how h;
    dgb_context c, engine; /* the second builds the engine's layers */
    GLuint program, textures[10];
    int shot; /* frames so far */
} film;

static how default_how(void) {
    how h;
    memset(&h, 0, sizeof h);
    h.width = WIDTH;
    h.height = HEIGHT;
    h.guard = GUARD;
    h.layers = 2;
    h.effects = ALL;
    h.view = fixture_default_view();
    h.view.yaw = 0.1f;
    h.step[0] = 0.045f;
    h.step[2] = -0.05f;
    h.turn = 0.006f;
    h.shake = 0.4f;
    h.walk = 0.1f;
    h.params = dgb_preset(DGB_PRESET_BALANCED);
    h.params.radius = 3.0f;
    return h;
}

static how still_how(void) {
    how h = default_how();
    memset(h.step, 0, sizeof h.step);
    h.turn = h.shake = h.walk = 0.0f;
    return h;
}

static dgb_desc desc_of(const how* h) {
    dgb_desc d = fixture_desc(&f, &h->view, h->width, h->height, h->guard);
    d.layers = h->layers;
    d.divisor = h->divisor;
    d.effects = h->effects;
    d.oracle = h->oracle;
    d.depth_format = h->depth_format;
    if (h->engine) {
        d.source = DGB_SOURCE_ENGINE;
        d.normals = DGB_NORMALS_OCT16;
        d.divisor = 0;
        d.oracle = DGB_ORACLE_DEFAULT;
    }
    return d;
}

static bool is_offered(const how* h) {
    const dgb_desc d = desc_of(h);
    return fixture_offers(&f, &d);
}

static float turn_of(int n, int axis) { return sinf((float)(n * (axis ? 3 : 2) + axis)); } /* no two frames alike */

static dgb_view view_at(const how* h, int n) {
    fixture_view v = h->view;
    int i;
    for (i = 0; i < 3; ++i) v.eye[i] += h->step[i] * (float)n;
    v.yaw += h->turn * (float)n;
    v.fov += h->zoom * (float)n;
    for (i = 0; i < 2; ++i) v.jitter[i] += h->shake * turn_of(n, i);
    for (i = 0; i < 4; ++i) f.offsets[i] = h->walk * (float)(n + i - 2);
    return fixture_dgb_view(&v, h->width, h->height);
}

/* Which frame is seen in frame n: with DELAY the one before, after the first. */
static int seen_at(const how* h, int n) { return h->oracle == DGB_ORACLE_DELAY && n > 0 ? n - 1 : n; }

static film open_film(const how* h) {
    dgb_desc d = desc_of(h), e;
    film m;
    memset(&m, 0, sizeof m);
    m.h = *h;
    assert_int_equal(dgb_init(&m.c, &d), DGB_OK);
    if (h->engine) {
        how build = *h;
        build.engine = false;
        build.effects = 0;
        build.oracle = DGB_ORACLE_PEEL;
        e = desc_of(&build);
        assert_int_equal(dgb_init(&m.engine, &e), DGB_OK);
        glGenTextures(10, m.textures);
    }
    m.program = fixture_program(h->engine ? &m.engine : &m.c);
    assert_true(m.program != 0);
    return m;
}

static void close_film(film* m) {
    glDeleteProgram(m->program);
    if (m->h.engine) glDeleteTextures(10, m->textures);
    dgb_shutdown(&m->engine);
    dgb_shutdown(&m->c);
}

static const dgb_context* builder_of(const film* m) { return m->h.engine ? &m->engine : &m->c; }

/* >> reading */

/* What a layer holds at each pixel, though its texels may be larger. */
static float* read_layer(const dgb_context* c, dgb_slot slot, int layer, GLenum format, int channels) {
    const int w = c->plan.width, h = c->plan.height, divisor = layer > 0 && c->desc.divisor ? c->desc.divisor : 1;
    float* texels = fixture_read(dgb_get_texture(c, slot), 0, layer, w, h, c->plan.layers, format, channels);
    float* pixels = (float*)calloc((size_t)w * (size_t)h, (size_t)channels * sizeof(float));
    int x, y;
    for (y = 0; y < h; ++y)
        for (x = 0; x < w; ++x)
            memcpy(pixels + (y * w + x) * channels, texels + (y / divisor * w + x / divisor) * channels,
                   (size_t)channels * sizeof(float));
    free(texels);
    return pixels;
}

static bool is_box(const float albedo[3]) { /* the one that moves is blue */
    return fabsf(albedo[0] - 0.1f) < 0.01f && fabsf(albedo[1] - 0.2f) < 0.01f && fabsf(albedo[2] - 0.9f) < 0.01f;
}

/* Pixels, and for the engine's own layers metres of z, in last frame's camera space, that the box moved. */
static float* read_velocity(const film* m, int layer, const float* albedo) {
    const dgb_context* c = builder_of(m);
    const int texels = c->plan.width * c->plan.height;
    const dgb_view last = view_at(&m->h, m->shot > 0 ? m->shot - 1 : 0);
    float* velocity = read_layer(c, DGB_VELOCITY, layer, GL_RGB, 3);
    int i;
    (void)view_at(&m->h, m->shot);
    for (i = 0; i < texels; ++i)
        velocity[3 * i + 2] = m->h.approach && is_box(albedo + 3 * i) ? last.view[2] * m->h.walk : 0.0f;
    return velocity;
}

static void read_results(const dgb_context* c, frame* out) {
    static const dgb_slot raw[] = {DGB_IRRADIANCE_RAW, DGB_IRRADIANCE1_RAW},
                          mean[] = {DGB_IRRADIANCE_MEAN, DGB_IRRADIANCE1_MEAN}, half[] = {DGB_HALF, DGB_HALF1},
                          light[] = {DGB_IRRADIANCE, DGB_IRRADIANCE1};
    int l;
    out->ao_raw = fixture_shaded(c, DGB_AO_RAW, 1);
    out->frames = fixture_shaded(c, DGB_FRAMES, 4);
    out->ao = fixture_shaded(c, DGB_AO, 1);
    for (l = 0; l < 2; ++l) {
        out->raw[l] = fixture_shaded(c, raw[l], 4);
        out->mean[l] = fixture_shaded(c, mean[l], 4);
        out->half[l] = fixture_read_half(dgb_get_texture(c, half[l]), c->plan.width, c->plan.height, NULL);
        fixture_blank_unshaded(c, out->half[l], 4);
        out->light[l] = fixture_shaded(c, light[l], 4);
    }
}

static void read_frame(const film* m, frame* out) {
    const dgb_context *c = &m->c, *b = builder_of(m);
    const int layers = m->h.layers < 2 ? 1 : 2;
    int l;
    out->r.layers = layers;
    fixture_shaded_rect(c, &out->params, out->rect);
    out->z = fixture_z(c, 0);
    out->normals = fixture_image(c, DGB_NORMALS, 0, 2 * layers);
    for (l = 0; l < layers; ++l) {
        out->sent[l] = fixture_image(c, l ? DGB_B1 : DGB_B0, 0, 3);
        out->radiance[l] = read_layer(b, DGB_RADIANCE, l, GL_RGB, 3);
        out->albedo[l] = read_layer(b, DGB_ALBEDO, l, GL_RGB, 3);
        out->velocity[l] = read_velocity(m, l, out->albedo[l]);
    }
    read_results(c, out);
    reference_open(&out->r, c, out->z, out->normals, (const float* const*)out->sent);
    out->r.frame = (m->h.effects & DGB_EFFECT_TEMPORAL) && out->params.history_weight > 0.0f ? m->shot : 0;
}

static void free_frame(frame* s) {
    int l;
    free(s->z), free(s->normals), free(s->ao_raw), free(s->frames), free(s->ao);
    for (l = 0; l < 2; ++l) {
        free(s->sent[l]), free(s->radiance[l]), free(s->albedo[l]), free(s->velocity[l]);
        free(s->raw[l]), free(s->mean[l]), free(s->half[l]), free(s->light[l]);
    }
    reference_close(&s->r);
    memset(s, 0, sizeof *s);
}

/* >> one frame more */

static dgb_texture copy_of(const film* m, dgb_slot slot, int layer, GLenum internal, GLuint name) {
    const dgb_context* e = &m->engine;
    glBindTexture(GL_TEXTURE_2D, name);
    glTexImage2D(GL_TEXTURE_2D, 0, (GLint)internal, e->plan.width, e->plan.height, 0,
                 slot == DGB_DEPTH ? GL_DEPTH_COMPONENT : GL_RGBA, GL_FLOAT, NULL);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
    glBindTexture(GL_TEXTURE_2D, 0);
    glCopyImageSubData(dgbgl_texture_name(dgb_get_texture(e, slot)), GL_TEXTURE_2D_ARRAY, 0, 0, 0, layer, name,
                       GL_TEXTURE_2D, 0, 0, 0, 0, e->plan.width, e->plan.height, 1);
    return dgbgl_texture(name);
}

static dgb_texture upload(const film* m, GLuint name, const float* rgb) {
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glBindTexture(GL_TEXTURE_2D, name);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, m->engine.plan.width, m->engine.plan.height, 0, GL_RGB, GL_FLOAT, rgb);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
    glBindTexture(GL_TEXTURE_2D, 0);
    return dgbgl_texture(name);
}

static void give_layers(film* m, const dgb_view* view) {
    dgb_layers own;
    int l;
    memset(&own, 0, sizeof own);
    for (l = 0; l < m->h.layers; ++l) {
        float* albedo = read_layer(&m->engine, DGB_ALBEDO, l, GL_RGB, 3);
        float* velocity = read_velocity(m, l, albedo);
        own.depth[l] = copy_of(m, DGB_DEPTH, l, GL_DEPTH_COMPONENT32F, m->textures[l]);
        own.normal[l] = copy_of(m, DGB_NORMAL, l, GL_RGBA8, m->textures[2 + l]);
        own.radiance[l] = copy_of(m, DGB_RADIANCE, l, GL_R11F_G11F_B10F, m->textures[4 + l]);
        own.albedo[l] = copy_of(m, DGB_ALBEDO, l, GL_RGBA8, m->textures[6 + l]);
        own.velocity[l] = m->h.approach ? upload(m, m->textures[8 + l], velocity)
                                        : copy_of(m, DGB_VELOCITY, l, GL_RG16F, m->textures[8 + l]);
        free(albedo), free(velocity);
    }
    assert_int_equal(dgb_set_layers(&m->c, view, &own), DGB_OK);
}

static void build_frame(film* m, bool cut) {
    dgb_view view = view_at(&m->h, m->shot);
    fixture_draw_user user;
    memset(&user, 0, sizeof user);
    user.f = &f;
    user.program = m->program;
    user.nothing = m->h.nothing;
    view.cut = cut;
    assert_int_equal(dgb_build(m->h.engine ? &m->engine : &m->c, &view, &m->h.params, fixture_draw, &user), DGB_OK);
    if (m->h.engine) give_layers(m, &view);
    if (m->h.uniform_radiance)
        glClearTexImage(dgbgl_texture_name(dgb_get_texture(&m->c, DGB_RADIANCE)), 0, GL_RGB, GL_FLOAT,
                        m->h.uniform_radiance);
}

static void shade_frame(film* m) { assert_int_equal(dgb_shade(&m->c, &m->h.params), DGB_OK); }

static frame frame_of(film* m) {
    const dgb_view view = view_at(&m->h, seen_at(&m->h, m->shot));
    frame out;
    memset(&out, 0, sizeof out);
    out.params = m->h.params;
    memcpy(out.view, view.view, sizeof out.view);
    dgb_widen_projection(view.projection, m->h.width, m->h.height, m->h.guard, view.jitter, out.projection);
    read_frame(m, &out);
    return out;
}

static void run_frame(film* m, bool cut) {
    build_frame(m, cut);
    shade_frame(m);
    ++m->shot;
}

static frame next_frame(film* m) {
    frame out;
    build_frame(m, false);
    shade_frame(m);
    out = frame_of(m);
    ++m->shot;
    return out;
}

/* >> comparison with the reference */

static bool same_result(const dgb_params* a, const dgb_params* b) {
    return a->separation == b->separation && a->strict_separation == b->strict_separation && a->radius == b->radius &&
           a->ao_radius == b->ao_radius && a->ao_bias == b->ao_bias && a->ao_epsilon == b->ao_epsilon &&
           a->ao_intensity == b->ao_intensity;
}

/* What `now` may know of `last`, null for nothing; mean: as the temporal filter does, else as packing does. */
static reference_last last_of(const frame* now, const frame* last, bool mean) {
    reference_last l;
    int i;
    memset(&l, 0, sizeof l);
    for (i = 0; i < 2; ++i) l.velocity[i] = now->velocity[i];
    l.usable = last && (!mean || same_result(&now->params, &last->params));
    if (!last) last = now;
    for (i = 0; i < 2; ++i) l.light[i] = mean ? last->mean[i] : last->light[i];
    reference_set_views(&l, now->view, last->view);
    for (i = 0; i < 16; ++i) l.projection[i] = (double)last->projection[i];
    memcpy(l.rect, last->rect, sizeof l.rect);
    l.z = last->z;
    l.frames = last->frames;
    return l;
}

/* Where rounding decides what last frame shows there is no telling; there must not be many such pixels. */
static void report(const tally* t, int undecided) {
    printf("#     %-12s undecided %d\n", t->what, undecided);
    tally_report(t);
    assert_true(200 * undecided <= t->pixels + 200);
}

static void compare_sent(const frame* now, const frame* last, int layer, bool bounces) {
    const reference_last l = last_of(now, last, false);
    tally t = tally_of(layer ? "B1" : "B0");
    int x, y, i, undecided = 0, bounced = 0;
    for (y = 0; y < now->r.height; ++y)
        for (x = 0; x < now->r.width; ++x) {
            const int at = 3 * (y * now->r.width + x);
            const reference_sent s = reference_radiance(&now->r, bounces ? &l : NULL, &now->params, layer,
                                                        now->radiance[layer] + at, now->albedo[layer] + at, x, y);
            undecided += s.unsure;
            bounced += s.bounced;
            for (i = 0; i < 3 && !s.unsure; ++i)
                tally_small_float(&t, i < 2 ? 6 : 5, (double)now->sent[layer][at + i], s.low[i], s.high[i]);
        }
    report(&t, undecided);
    printf("#     bounced at %d\n", bounced);
    if (bounces && last) assert_true(bounced > (layer ? 100 : 1000)); /* or this proves little */
}

static void compare_gathered(const frame* now, const how* h, int layer) {
    tally t = tally_of(layer ? "E1 raw" : "E raw"), confidence = tally_of("confidence");
    int x, y, i;
    for (y = now->rect[1]; y <= now->rect[3]; ++y)
        for (x = now->rect[0]; x <= now->rect[2]; ++x) {
            const reference_light e =
                reference_irradiance(&now->r, &h->params, DGB_SENDERS_BOTH, DGB_NORMALISER_BOUNDED, layer, x, y);
            const float* value = now->raw[layer] + 4 * (y * now->r.width + x);
            t.unsure += e.unsure;
            for (i = 0; i < 3 && !e.unsure; ++i) tally_half(&t, (double)value[i], e.low[i], e.high[i]);
            if (!e.unsure) tally_half(&confidence, (double)value[3], e.low_confidence, e.high_confidence);
        }
    tally_report(&t);
    tally_report(&confidence);
}

static void count_mean(const frame* now, const reference_mean* m, int layer, int at, tally* light, tally* frames,
                       tally* open) {
    int i;
    for (i = 0; i < 4 && now->mean[layer]; ++i)
        tally_half(light, (double)now->mean[layer][4 * at + i], m->value[i] - m->error[i], m->value[i] + m->error[i]);
    tally_half(frames, (double)now->frames[4 * at + 2 + layer], m->frames - m->frames_error,
               m->frames + m->frames_error);
    if (layer > 0 || !now->ao_raw) return;
    tally_half(open, (double)now->frames[4 * at], m->visibility - m->visibility_error,
               m->visibility + m->visibility_error);
    tally_half(frames, (double)now->frames[4 * at + 1], m->visibility_frames - m->visibility_frames_error,
               m->visibility_frames + m->visibility_frames_error);
}

static void compare_means(const frame* now, const frame* last, int layer) {
    static const float nothing[4] = {0.0f, 0.0f, 0.0f, 0.0f};
    const reference_last l = last_of(now, last, true);
    tally light = tally_of(layer ? "E1 mean" : "E mean"), frames = tally_of("frames"), open = tally_of("visibility");
    int x, y, undecided = 0, old = 0, second = 0;
    for (y = now->rect[1]; y <= now->rect[3]; ++y)
        for (x = now->rect[0]; x <= now->rect[2]; ++x) {
            const int at = y * now->r.width + x;
            const reference_mean m = reference_average(&now->r, &l, &now->params, layer,
                                                       now->raw[layer] ? now->raw[layer] + 4 * at : nothing,
                                                       now->ao_raw ? now->ao_raw[at] : 1.0f, x, y);
            undecided += m.unsure;
            old += m.frames > 1.5;
            second += m.from_second;
            if (!m.unsure) count_mean(now, &m, layer, at, &light, &frames, &open);
        }
    printf("#     with history %d, from the second layer %d\n", old, second);
    report(&frames, undecided);
    if (light.pixels) tally_report(&light);
    if (open.pixels) tally_report(&open);
}

static void compare_filter(const frame* now, int layer, int axis) {
    const float* before = now->mean[layer] ? now->mean[layer] : now->raw[layer];
    const float *from = axis ? now->half[layer] : before, *to = axis ? now->light[layer] : now->half[layer];
    tally t = tally_of(layer ? "E1 filtered" : "E filtered");
    int x, y, i;
    for (y = now->rect[1]; y <= now->rect[3]; ++y)
        for (x = now->rect[0]; x <= now->rect[2]; ++x) {
            const reference_filtered e =
                reference_reconstruct(&now->r, &now->params, axis, layer, now->rect, from, 4, x, y);
            for (i = 0; i < 4; ++i)
                tally_half(&t, (double)to[4 * (y * now->r.width + x) + i], e.value[i] - e.error[i],
                           e.value[i] + e.error[i]);
        }
    tally_report(&t);
}

static void compare_frame(const film* m, const frame* now, const frame* last, bool all) {
    const bool bounces = (m->h.effects & DGB_EFFECT_BOUNCES) != 0, light = (m->h.effects & DGB_EFFECT_RADIOSITY) != 0;
    const bool temporal = (m->h.effects & DGB_EFFECT_TEMPORAL) != 0;
    const int layers = now->r.layers;
    int l;
    for (l = 0; l < layers && light; ++l) compare_sent(now, last, l, bounces);
    for (l = 0; l < layers && temporal; ++l)
        if (l == 0 || now->raw[l]) compare_means(now, last, l);
    for (l = 0; l < layers && all; ++l) {
        if (!now->raw[l]) continue;
        compare_gathered(now, &m->h, l);
        compare_filter(now, l, 0);
        compare_filter(now, l, 1);
    }
}

static void compare_film(const char* name, const how* h, int frames) {
    film m = open_film(h);
    frame last, now;
    int n;
    memset(&last, 0, sizeof last);
    for (n = 0; n < frames; ++n) {
        now = next_frame(&m);
        printf("# %s, frame %d\n", name, n);
        compare_frame(&m, &now, n ? &last : NULL, n + 1 == frames);
        free_frame(&last);
        last = now;
    }
    free_frame(&last);
    close_film(&m);
}

static void test_reference(void** state) {
    how h = default_how();
    (void)state;
    compare_film("two layers", &h, 4);
    h.layers = 1;
    compare_film("one layer", &h, 3);
    h.layers = 3;
    compare_film("three layers, two shaded", &h, 3);
}

static void test_reference_divisor(void** state) {
    how h = default_how();
    (void)state;
    h.divisor = 2;
    compare_film("layer 1 at half the resolution", &h, 4);
}

static void test_reference_cameras(void** state) {
    how h = default_how();
    (void)state;
    h.view.reversed = true, h.view.clip = DGB_CLIP_ZERO_TO_ONE, h.view.far_plane = 0.0f;
    if (is_offered(&h)) compare_film("reversed, infinite", &h, 3);
    h = default_how();
    h.view.fov = 0.0f;
    compare_film("orthographic", &h, 3);
    h = default_how();
    h.zoom = 2.0f, h.step[2] = 0.1f; /* the border comes in */
    h.params.guard_fraction = 1.0f;
    compare_film("zooming out, the whole guard band", &h, 3);
}

static void test_reference_engine(void** state) {
    how h = default_how();
    (void)state;
    h.engine = true;
    h.walk = 0.05f, h.view.yaw = 0.5f; /* the box comes nearer as it moves across */
    compare_film("the engine's own", &h, 3);
    h.approach = true;
    compare_film("the engine's own, z of velocity", &h, 3);
    h.layers = 1;
    compare_film("the engine's own, one layer", &h, 3);
}

/* Damping, boosts, weight and tolerances away from their defaults. */
static void test_reference_params(void** state) {
    how h = default_how();
    (void)state;
    h.params.bounce_damping = 0.7f;
    h.params.boost_unsaturated = 0.3f, h.params.boost_saturated = 1.7f;
    h.params.history_weight = 0.6f;
    h.params.history_tolerance = 0.02f, h.params.history_floor = 0.0f;
    compare_film("share alone", &h, 4);
    h.params.history_tolerance = 0.0f, h.params.history_floor = 0.15f;
    compare_film("floor alone", &h, 3);
}

/* Tiles in which the second layer is skipped change no bit of what goes on to the next frame. */
static void test_adaptive_changes_nothing(void** state) {
    how h = default_how();
    film with, without;
    int n;
    (void)state;
    with = open_film(&h);
    h.params.adaptive = !h.params.adaptive;
    without = open_film(&h);
    for (n = 0; n < 4; ++n) {
        frame a = next_frame(&with), b = next_frame(&without);
        const size_t image = (size_t)(a.r.width * a.r.height) * sizeof(float);
        int l;
        assert_memory_equal(a.frames, b.frames, 4 * image);
        for (l = 0; l < 2; ++l) {
            assert_memory_equal(a.sent[l], b.sent[l], 3 * image);
            assert_memory_equal(a.light[l], b.light[l], 4 * image);
        }
        free_frame(&a), free_frame(&b);
    }
    close_film(&with), close_film(&without);
}

/* PREDICT shows the pose that is submitted, DELAY the one before it. */
static void test_reference_oracles(void** state) {
    how h = default_how();
    (void)state;
    h.oracle = DGB_ORACLE_PREDICT;
    compare_film("predict", &h, 3);
    h.oracle = DGB_ORACLE_DELAY;
    compare_film("delay", &h, 4);
    h.oracle = DGB_ORACLE_PREVIOUS;
    h.depth_format = DGB_FORMAT_D24;
    compare_film("previous, D24", &h, 3);
}

/* No absolute length hides anywhere: the world and every length of the parameters times a power of two change no
   bit. */
static void test_scale(void** state) {
    static const float scales[] = {1.0f, 1024.0f, 1.0f / 64.0f};
    static const float radiance[3] = {1.0f, 0.25f, 6.0f}; /* the scene's own material knows lengths */
    frame frames[3];
    size_t image;
    int i, n, l;
    (void)state;
    for (i = 0; i < 3; ++i) {
        how h = default_how();
        film m;
        h.uniform_radiance = radiance;
        h.view.scale = scales[i];
        h.params.separation *= scales[i], h.params.ao_radius *= scales[i], h.params.radius *= scales[i];
        h.params.history_floor *= scales[i];
        m = open_film(&h);
        for (n = 0; n < 3; ++n) run_frame(&m, false);
        frames[i] = next_frame(&m);
        close_film(&m);
    }
    image = (size_t)(frames[0].r.width * frames[0].r.height) * sizeof(float);
    for (i = 1; i < 3; ++i) {
        assert_memory_equal(frames[0].frames, frames[i].frames, 4 * image);
        for (l = 0; l < 2; ++l) {
            assert_memory_equal(frames[0].sent[l], frames[i].sent[l], 3 * image);
            assert_memory_equal(frames[0].mean[l], frames[i].mean[l], 4 * image);
            assert_memory_equal(frames[0].light[l], frames[i].light[l], 4 * image);
        }
    }
    for (i = 0; i < 3; ++i) free_frame(&frames[i]);
}

static void test_reference_effects(void** state) {
    static const uint32_t effects[] = {1 | 8, 2 | 8, 3 | 8, 2 | 4, 3 | 4, 2 | 4 | 8};
    size_t i;
    (void)state;
    for (i = 0; i < sizeof effects / sizeof effects[0]; ++i) {
        how h = default_how();
        h.effects = effects[i];
        printf("# effects %u\n", (unsigned)effects[i]);
        compare_film("effects", &h, 3);
    }
}

/* >> when history is dropped, and when it is not */

static bool is_inside(const int rect[4], int x, int y) {
    return x >= rect[0] && y >= rect[1] && x <= rect[2] && y <= rect[3];
}

/* Every shaded surface of both layers is an average of so many frames. */
static void check_counts(const frame* s, float count, const char* what) {
    int x, y, l, wrong = 0;
    for (y = s->rect[1]; y <= s->rect[3]; ++y)
        for (x = s->rect[0]; x <= s->rect[2]; ++x) {
            const int at = y * s->r.width + x;
            wrong += s->z[at * s->r.layers] != 0.0f && s->ao_raw && s->frames[4 * at + 1] != count;
            for (l = 0; l < s->r.layers; ++l)
                wrong +=
                    s->z[at * s->r.layers + l] != 0.0f && (l == 0 || s->raw[1]) && s->frames[4 * at + 2 + l] != count;
        }
    if (wrong) print_error("%s: %d surfaces are not averages of %g frames\n", what, wrong, (double)count);
    assert_int_equal(wrong, 0);
}

/* The averages are this frame's results, bit for bit. */
static void check_raw(const frame* s) {
    int x, y, l;
    for (y = s->rect[1]; y <= s->rect[3]; ++y)
        for (x = s->rect[0]; x <= s->rect[2]; ++x) {
            const int at = y * s->r.width + x;
            for (l = 0; l < 2; ++l)
                if (s->raw[l]) assert_memory_equal(s->mean[l] + 4 * at, s->raw[l] + 4 * at, 4 * sizeof(float));
            if (!s->ao_raw || s->z[at * s->r.layers] == 0.0f) continue;
            assert_true(fabs((double)s->frames[4 * at] - (double)s->ao_raw[at]) <=
                        tally_half_ulp((double)s->ao_raw[at]));
        }
}

/* Nothing of last frame is in what the surfaces send. */
static void check_unbounced(const frame* s) {
    const int texels = s->r.width * s->r.height;
    int i, l;
    for (l = 0; l < s->r.layers; ++l)
        for (i = 0; i < texels; ++i)
            if (s->z[i * s->r.layers + l] != 0.0f)
                assert_memory_equal(s->sent[l] + 3 * i, s->radiance[l] + 3 * i, 3 * sizeof(float));
}

static void check_fresh(frame s, const char* what) {
    check_counts(&s, 1.0f, what);
    check_raw(&s);
    free_frame(&s);
}

static void test_first_frame_cut_resize(void** state) {
    how h = default_how();
    film m;
    frame s;
    int n, layers;
    (void)state;
    for (layers = 1; layers <= 2; ++layers) {
        h.layers = layers;
        m = open_film(&h);
        s = next_frame(&m);
        check_unbounced(&s);
        check_fresh(s, "first frame");
        for (n = 0; n < 2; ++n) run_frame(&m, false);
        build_frame(&m, true);
        shade_frame(&m);
        s = frame_of(&m);
        check_unbounced(&s);
        check_fresh(s, "cut");
        run_frame(&m, false);
        m.h.width = 93, m.h.height = 57;
        assert_int_equal(dgb_resize(&m.c, m.h.width, m.h.height), DGB_OK);
        s = next_frame(&m);
        check_unbounced(&s);
        check_fresh(s, "resize");
        close_film(&m);
    }
}

/* Velocities reach back one frame: layers that were never shaded break the chain. */
static void test_two_builds_without_a_shade(void** state) {
    how h = default_how();
    int engine;
    (void)state;
    for (engine = 0; engine < 2; ++engine) {
        film m;
        frame s;
        h.engine = engine != 0;
        m = open_film(&h);
        run_frame(&m, false);
        run_frame(&m, false);
        build_frame(&m, false);
        ++m.shot; /* and not shaded */
        build_frame(&m, false);
        shade_frame(&m);
        s = frame_of(&m);
        s.r.frame = 0;
        check_unbounced(&s);
        check_fresh(s, "two builds");
        close_film(&m);
    }
}

/* What stands still moves as the camera does, jitter included: its velocity brings it to where the matrices say it was,
   but for the rounding of a half (2^-11 of the pixels it moved, in two directions) and of the rasteriser's
   interpolation. So no tolerance is widened but the moving box's. */
static void test_velocities_agree_with_matrices(void** state) {
    how h = default_how();
    int kind;
    (void)state;
    for (kind = 0; kind < 3; ++kind) {
        static const float nothing[4] = {0.0f, 0.0f, 0.0f, 0.0f};
        film m;
        frame last, now;
        reference_last l;
        double worst = 0.0, box = 0.0;
        int i, layer;
        if (kind == 1) h.view.fov = 0.0f;
        if (kind == 2) h.divisor = 2, h.view.fov = 60.0f;
        if (!is_offered(&h)) continue;
        m = open_film(&h);
        last = next_frame(&m), now = next_frame(&m);
        l = last_of(&now, &last, true);
        for (layer = 0; layer < 2; ++layer)
            for (i = 0; i < now.r.width * now.r.height; ++i) {
                const reference_mean mean =
                    reference_average(&now.r, &l, &h.params, layer, nothing, 1.0f, i % now.r.width, i / now.r.width);
                const float* v = now.velocity[layer] + 3 * i;
                const double rounding = (fabs((double)v[0]) + fabs((double)v[1])) / 1024.0;
                if (is_box(now.albedo[layer] + 3 * i))
                    box = fmax(box, mean.own);
                else
                    worst = fmax(worst, mean.own - rounding);
            }
        printf("# own motion %g pixels at most, of the box %g\n", worst, box);
        assert_true(worst < 0.005 && box > 0.5);
        free_frame(&last), free_frame(&now);
        close_film(&m);
    }
}

/* The same layers once more: another frame, in which nothing moved, whatever the velocities say. */
static void test_shading_twice(void** state) {
    how h = default_how();
    int engine;
    (void)state;
    for (engine = 0; engine < 2; ++engine) {
        film m;
        frame first, second;
        int x, y, layer, box = 0;
        h.engine = h.approach = engine != 0;
        h.view.yaw = 0.5f, h.walk = 0.2f; /* the box comes nearer by more than history tolerates */
        m = open_film(&h);
        run_frame(&m, false);
        run_frame(&m, false);
        build_frame(&m, false);
        shade_frame(&m);
        first = frame_of(&m);
        shade_frame(&m);
        second = frame_of(&m);
        for (layer = 0; layer < 2; ++layer)
            for (y = first.rect[1]; y <= first.rect[3]; ++y)
                for (x = first.rect[0]; x <= first.rect[2]; ++x) {
                    const int at = y * first.r.width + x;
                    if (first.z[2 * at + layer] == 0.0f) continue;
                    box += is_box(first.albedo[layer] + 3 * at);
                    assert_true(fabs((double)second.frames[4 * at + 2 + layer] -
                                     (double)first.frames[4 * at + 2 + layer] - 1.0) <= 1.0 / 256.0);
                }
        assert_true(box > 20);
        free_frame(&first), free_frame(&second);
        close_film(&m);
    }
}

static void change_radius(dgb_params* q) { q->radius *= 1.01f; }
static void change_ao_radius(dgb_params* q) { q->ao_radius *= 1.01f; }
static void change_ao_bias(dgb_params* q) { q->ao_bias += 0.001f; }
static void change_ao_epsilon(dgb_params* q) { q->ao_epsilon += 0.001f; }
static void change_ao_intensity(dgb_params* q) { q->ao_intensity += 0.1f; }
static void change_separation(dgb_params* q) { q->separation += 0.01f; }
static void change_strictness(dgb_params* q) { q->strict_separation = !q->strict_separation; }
static void change_second_alone(dgb_params* q) { q->second_alone = !q->second_alone; }
static void change_samples(dgb_params* q) { q->samples += 3; }
static void change_ao_samples(dgb_params* q) { q->ao_samples += 5; }
static void change_filter_taps(dgb_params* q) { q->filter_taps += 2; }
static void change_filter_step(dgb_params* q) { ++q->filter_step; }
static void change_normal_test(dgb_params* q) { q->normal_test = !q->normal_test; }
static void change_min_level(dgb_params* q) { q->min_level = 1; }
static void change_ao_min_level(dgb_params* q) { q->ao_min_level = 1; }
static void change_normal_sharpness(dgb_params* q) { q->normal_sharpness += 1.0f; }
static void change_plane_sharpness(dgb_params* q) { q->plane_sharpness += 1.0f; }
static void change_history_weight(dgb_params* q) { q->history_weight = 0.5f; }
static void change_history_tolerance(dgb_params* q) { q->history_tolerance *= 2.0f; }
static void change_history_floor(dgb_params* q) { q->history_floor *= 2.0f; }
static void change_damping(dgb_params* q) { q->bounce_damping = 0.7f; }
static void change_boosts(dgb_params* q) { q->boost_unsaturated = 0.8f, q->boost_saturated = 0.9f; }
static void change_guard_fraction(dgb_params* q) { q->guard_fraction = 0.25f; }

static void test_parameters_that_reset(void** state) {
    static const struct {
        const char* name;
        void (*change)(dgb_params* q);
        bool resets;
    } rows[] = {{"radius", change_radius, true},
                {"samples", change_samples, false},
                {"ao_radius", change_ao_radius, true},
                {"ao_samples", change_ao_samples, false},
                {"ao_bias", change_ao_bias, true},
                {"filter_taps", change_filter_taps, false},
                {"ao_epsilon", change_ao_epsilon, true},
                {"filter_step", change_filter_step, false},
                {"ao_intensity", change_ao_intensity, true},
                {"normal_test", change_normal_test, false},
                {"separation", change_separation, true},
                {"min_level", change_min_level, false},
                {"strict_separation", change_strictness, true},
                {"ao_min_level", change_ao_min_level, false},
                {"second_alone", change_second_alone, true},
                {"normal_sharpness", change_normal_sharpness, false},
                {"plane_sharpness", change_plane_sharpness, false},
                {"history_weight", change_history_weight, false},
                {"history_tolerance", change_history_tolerance, false},
                {"history_floor", change_history_floor, false},
                {"bounce_damping", change_damping, false},
                {"boosts", change_boosts, false},
                {"guard_fraction", change_guard_fraction, false}};
    how h = still_how();
    film m = open_film(&h);
    float count = 1.0f;
    size_t i;
    (void)state;
    run_frame(&m, false);
    for (i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
        frame s;
        rows[i].change(&m.h.params);
        count = rows[i].resets ? 1.0f : count + 1.0f;
        s = next_frame(&m);
        check_counts(&s, count, rows[i].name);
        if (rows[i].resets) check_raw(&s);
        free_frame(&s);
    }
    close_film(&m);
}

/* What was not shaded last frame has no history, and the rest goes on. */
static void test_more_of_the_guard_band(void** state) {
    how h = still_how();
    film m;
    frame last, now;
    int x, y;
    (void)state;
    h.params.guard_fraction = 0.25f;
    m = open_film(&h);
    run_frame(&m, false);
    last = next_frame(&m);
    m.h.params.guard_fraction = 1.0f;
    now = next_frame(&m);
    assert_int_equal(last.rect[0], GUARD - GUARD / 4);
    assert_int_equal(now.rect[0], 0);
    for (y = now.rect[1]; y <= now.rect[3]; ++y)
        for (x = now.rect[0]; x <= now.rect[2]; ++x) {
            const int at = y * now.r.width + x;
            if (now.z[2 * at] == 0.0f) continue;
            assert_true(now.frames[4 * at + 2] == (is_inside(last.rect, x, y) ? 3.0f : 1.0f));
            if (is_inside(last.rect, x, y)) continue;
            assert_memory_equal(now.mean[0] + 4 * at, now.raw[0] + 4 * at, 4 * sizeof(float));
            assert_memory_equal(now.sent[0] + 3 * at, now.radiance[0] + 3 * at, 3 * sizeof(float));
        }
    compare_frame(&m, &now, &last, true);
    free_frame(&last), free_frame(&now);
    close_film(&m);
}

/* While nothing moves every surface counts 1, 2, 3, ... */
static void test_still_frames_count(void** state) {
    int kind, n;
    (void)state;
    for (kind = 0; kind < 3; ++kind) {
        how h = still_how();
        film m;
        h.width = 60, h.height = 40;
        h.engine = kind == 1;
        h.divisor = kind == 2 ? 4 : 1;
        if (kind == 2) h.oracle = DGB_ORACLE_PEEL; /* elsewhere a divided layer may move by a bit of depth */
        if (!is_offered(&h)) continue;
        m = open_film(&h);
        for (n = 0; n < (kind ? 4 : 9); ++n) {
            frame s = next_frame(&m);
            check_counts(&s, (float)(n + 1), "still");
            free_frame(&s);
        }
        close_film(&m);
    }
}

/* Without weight there is no history, though it is counted; and then every frame takes the same taps. */
static void test_weight_0_is_raw(void** state) {
    how h = default_how();
    film m;
    int n;
    (void)state;
    h.params.history_weight = 0.0f;
    m = open_film(&h);
    for (n = 0; n < 4; ++n) {
        frame s = next_frame(&m);
        check_raw(&s);
        if (n == 3) compare_gathered(&s, &h, 0);
        free_frame(&s);
    }
    close_film(&m);
}

/* >> poison: what must not spread, and must not stay */

static const dgb_slot poisoned[] = {
    DGB_FRAMES,           DGB_LAST_FRAMES,    DGB_IRRADIANCE_MEAN, DGB_IRRADIANCE1_MEAN, DGB_LAST_IRRADIANCE,
    DGB_LAST_IRRADIANCE1, DGB_IRRADIANCE_RAW, DGB_IRRADIANCE1_RAW, DGB_IRRADIANCE,       DGB_IRRADIANCE1};

/* Writes a value into every texel of these images outside (or, with everywhere, inside as well) of a rectangle. */
static void poison(const film* m, float value, bool everywhere, const int rect[4]) {
    const int w = m->c.plan.width, h = m->c.plan.height;
    size_t i;
    int x, y, k;
    for (i = 0; i < sizeof poisoned / sizeof poisoned[0]; ++i) {
        float* texels = fixture_image(&m->c, poisoned[i], 0, 4);
        if (!texels) continue;
        for (y = 0; y < h; ++y)
            for (x = 0; x < w; ++x)
                for (k = 0; k < 4; ++k)
                    if (everywhere || !is_inside(rect, x, y)) texels[4 * (y * w + x) + k] = value;
        fixture_put_image(&m->c, poisoned[i], 4, texels);
        free(texels);
    }
}

static void check_range(const frame* s, const float* image, int channels, float high) {
    int x, y, k;
    for (y = s->rect[1]; y <= s->rect[3]; ++y)
        for (x = s->rect[0]; x <= s->rect[2]; ++x)
            for (k = 0; k < channels && image; ++k) {
                const float value = image[channels * (y * s->r.width + x) + k];
                assert_true(value >= 0.0f && value <= (k == 3 ? 1.0f : high)); /* and no NaN */
            }
}

static void check_ranges(const frame* s) {
    const int texels = s->r.width * s->r.height;
    int l, i;
    check_range(s, s->ao_raw, 1, 1.0f);
    check_range(s, s->ao, 1, 1.0f);
    for (l = 0; l < 2; ++l) {
        check_range(s, s->raw[l], 4, DGB_MAX_RADIANCE);
        check_range(s, s->mean[l], 4, DGB_MAX_RADIANCE);
        check_range(s, s->half[l], 4, DGB_MAX_RADIANCE);
        check_range(s, s->light[l], 4, DGB_MAX_RADIANCE);
        for (i = 0; i < 3 * texels && s->sent[l]; ++i)
            assert_true(s->sent[l][i] >= 0.0f && s->sent[l][i] <= DGB_MAX_RADIANCE);
    }
    for (i = 0; i < texels && s->frames; ++i)
        if (is_inside(s->rect, i % s->r.width, i / s->r.width))
            for (l = 1; l < 4; ++l) assert_true(s->frames[4 * i + l] >= 0.0f && s->frames[4 * i + l] <= 1000.0f);
}

static const float poisons[] = {NAN, INFINITY, -INFINITY, -1.0f, 65504.0f};

/* A poisoned film beside a clean one that shows the same frames. */
static void two_films(const how* h, int before, film* clean, film* sick) {
    int n;
    *clean = open_film(h);
    *sick = open_film(h);
    for (n = 0; n < before; ++n) run_frame(clean, false), run_frame(sick, false);
}

/* Largest difference between channels first..last of two images inside the rectangle, less `ulps` of the larger. */
static double farthest(const frame* a, const float* x, const float* y, int first, int last, double ulps) {
    double worst = 0.0;
    int i, k;
    for (i = 0; i < a->r.width * a->r.height; ++i)
        for (k = first; k <= last && is_inside(a->rect, i % a->r.width, i / a->r.width); ++k) {
            const double p = (double)x[4 * i + k], q = (double)y[4 * i + k];
            const double off = fabs(p - q) - ulps * tally_half_ulp(fabs(p) > fabs(q) ? p : q);
            worst = off > worst ? off : worst;
        }
    return worst;
}

/* Times its confidence: what an engine adds to its picture. */
static void weigh(const frame* s, float* image) {
    int i, k;
    for (i = 0; i < s->r.width * s->r.height; ++i)
        for (k = 0; k < 3; ++k) image[4 * i + k] *= image[4 * i + 3];
}

static bool same_image(const frame* a, const float* x, const float* y) { return farthest(a, x, y, 0, 3, 0.0) == 0.0; }

static void check_visibility(const frame* s) {
    int i;
    for (i = 0; i < s->r.width * s->r.height; ++i)
        if (is_inside(s->rect, i % s->r.width, i / s->r.width))
            assert_true(s->frames[4 * i] >= 0.0f && s->frames[4 * i] <= 1.0f);
}

/* Finite at once. A weight of 1/2 halves what is left every frame, so that 64512 is less than an ulp of 1/500 after 44;
   where both averages are of the same frames but one is rounded otherwise, they stay within 1 / (1 - 1/2) ulps:
   irradiance and confidence each. */
static void check_healing(float value) {
    how h = still_how();
    film clean, sick;
    frame a, b;
    int n;
    h.effects = DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY | DGB_EFFECT_TEMPORAL;
    h.width = 60, h.height = 40;
    h.params.history_weight = 0.5f;
    two_films(&h, 3, &clean, &sick);
    poison(&sick, value, true, NULL);
    for (n = 0; n < 44; ++n) {
        a = next_frame(&clean), b = next_frame(&sick);
        check_ranges(&b);
        check_visibility(&b);
        if (n < 43) free_frame(&a), free_frame(&b);
    }
    weigh(&a, a.mean[0]), weigh(&b, b.mean[0]);
    assert_true(farthest(&a, a.mean[0], b.mean[0], 0, 2, 4.0) <= 64512.0 * ldexp(1.0, -44));
    assert_true(farthest(&a, a.mean[0], b.mean[0], 3, 3, 2.0) <= ldexp(1.0, -44));
    assert_true(farthest(&a, a.frames, b.frames, 0, 0, 2.0) <= 64512.0 * ldexp(1.0, -44));
    free_frame(&a), free_frame(&b);
    close_film(&clean), close_film(&sick);
}

/* With bounces the light that was there comes back with every bounce, but the surfaces keep a part of it each time, so
   that it dies out geometrically. What remains is rounding: a device may truncate the radiance that is sent to 6 bits
   (blue: 5), and where a sum lies between two codes either may stay. One code is 1/32, and all bounces add up to less
   than 1 / (1 - 1/2) of it with a damping of 1/2. */
static void check_healing_of_bounces(float value) {
    how h = still_how();
    film clean, sick;
    frame a, b;
    int n, i, k;
    h.width = 60, h.height = 40;
    h.params.history_weight = 0.5f;
    h.params.bounce_damping = 0.5f;
    two_films(&h, 3, &clean, &sick);
    poison(&sick, value, true, NULL);
    for (n = 0; n < 80; ++n) {
        run_frame(&clean, false);
        if (n % 8) {
            run_frame(&sick, false);
            continue;
        }
        b = next_frame(&sick);
        check_ranges(&b);
        free_frame(&b);
    }
    a = next_frame(&clean), b = next_frame(&sick);
    for (i = 0; i < a.r.width * a.r.height; ++i)
        for (k = 0; k < 3 && is_inside(a.rect, i % a.r.width, i / a.r.width); ++k) {
            const double p = (double)a.light[0][4 * i + k], q = (double)b.light[0][4 * i + k];
            assert_true(fabs(p - q) <= (p > q ? p : q) / 16.0 + 1e-6);
        }
    free_frame(&a), free_frame(&b);
    close_film(&clean), close_film(&sick);
}

/* With bounces too: finite at once, and where last frame is of no use as if nothing had been. */
static void check_poison_and_cut(float value) {
    how h = default_how();
    film clean, sick;
    frame a, b;
    h.width = 60, h.height = 40;
    two_films(&h, 3, &clean, &sick);
    poison(&sick, value, true, NULL);
    b = next_frame(&sick);
    check_ranges(&b);
    free_frame(&b);
    run_frame(&clean, false);
    poison(&sick, value, true, NULL);
    build_frame(&sick, true), build_frame(&clean, true);
    shade_frame(&sick), shade_frame(&clean);
    a = frame_of(&clean), b = frame_of(&sick);
    assert_true(same_image(&a, a.light[0], b.light[0]));
    assert_true(same_image(&a, a.light[1], b.light[1]));
    assert_true(same_image(&a, a.frames, b.frames));
    free_frame(&a), free_frame(&b);
    close_film(&clean), close_film(&sick);
}

/* Nothing outside of the shaded rectangle is ever read: poison there changes no bit, whatever moves. */
static void check_poison_outside(float value, float fraction) {
    how h = default_how();
    film clean, sick;
    int n, rect[4];
    h.width = 61, h.height = 43; /* odd */
    h.step[0] = 0.3f, h.shake = 1.5f;
    h.params.guard_fraction = fraction;
    h.params.filter_taps = 25, h.params.filter_step = 3;
    two_films(&h, 1, &clean, &sick);
    fixture_shaded_rect(&sick.c, &h.params, rect);
    for (n = 0; n < 3; ++n) {
        frame a, b;
        poison(&sick, value, false, rect);
        a = next_frame(&clean), b = next_frame(&sick);
        assert_true(same_image(&a, a.light[0], b.light[0]));
        assert_true(same_image(&a, a.light[1], b.light[1]));
        assert_true(same_image(&a, a.frames, b.frames));
        assert_memory_equal(a.sent[0], b.sent[0], (size_t)(3 * a.r.width * a.r.height) * sizeof(float));
        assert_memory_equal(a.sent[1], b.sent[1], (size_t)(3 * a.r.width * a.r.height) * sizeof(float));
        check_ranges(&b);
        free_frame(&a), free_frame(&b);
    }
    close_film(&clean), close_film(&sick);
}

static void test_poison_heals(void** state) {
    size_t i;
    (void)state;
    for (i = 0; i < sizeof poisons / sizeof poisons[0]; ++i) check_healing(poisons[i]);
}

static void test_poison_of_bounces_heals(void** state) {
    (void)state;
    check_healing_of_bounces(NAN);
    check_healing_of_bounces(65504.0f);
}

static void test_poison_and_cut(void** state) {
    size_t i;
    (void)state;
    for (i = 0; i < sizeof poisons / sizeof poisons[0]; ++i) check_poison_and_cut(poisons[i]);
}

static void test_poison_outside(void** state) {
    (void)state;
    check_poison_outside(NAN, 0.0f);
    check_poison_outside(65504.0f, 0.5f);
    check_poison_outside(INFINITY, 0.1f);
}

/* >> every combination of effects, and presets that change at run time */

static bool makes_sense(uint32_t effects) {
    if ((effects & DGB_EFFECT_BOUNCES) && !(effects & DGB_EFFECT_RADIOSITY)) return false;
    return (effects & (DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY)) != 0;
}

static void test_every_combination_runs(void** state) {
    uint32_t effects;
    int layers, engine, n;
    (void)state;
    for (effects = 1; effects <= ALL; ++effects)
        for (layers = 1; layers <= 2; ++layers)
            for (engine = 0; engine < 2 && makes_sense(effects); ++engine) {
                how h = default_how();
                film m;
                h.effects = effects;
                h.layers = layers;
                h.engine = engine != 0;
                h.width = 40, h.height = 24;
                m = open_film(&h);
                for (n = 0; n < 2 * DGB_PRESET_COUNT; ++n) {
                    frame s;
                    m.h.params = dgb_preset((dgb_preset_id)(n % DGB_PRESET_COUNT));
                    s = next_frame(&m);
                    check_ranges(&s);
                    free_frame(&s);
                }
                close_film(&m);
                assert_int_equal(f.messages, 0);
            }
}

/* Mean of irradiance times confidence, which is what an engine adds to its picture, over the image without its guard
   band. */
static double mean_of(const frame* s, const float* image) {
    double sum = 0.0;
    int x, y, k, count = 0;
    for (y = GUARD; y < s->r.height - GUARD; ++y)
        for (x = GUARD; x < s->r.width - GUARD; ++x, ++count) {
            const float* texel = image + 4 * (y * s->r.width + x);
            for (k = 0; k < 3; ++k) sum += (double)texel[k] * (double)texel[3];
        }
    return sum / (3.0 * count);
}

static dgb_params preset_of(int n) {
    dgb_params q = dgb_preset((dgb_preset_id)(n % DGB_PRESET_COUNT));
    q.radius = 3.0f;
    return q;
}

/* Another preset every frame. The mean may move by the share that a new frame has, 15 %, of how far that frame's own
   result is from it; the filter, which keeps a mean up to what crosses the rectangle's border, may add 1 %. */
static void test_presets_do_not_flash(void** state) {
    how h = still_how();
    film m;
    double last = 0.0, last_mean = 0.0, worst = 0.0, worst_raw = 0.0, excess = 0.0;
    int n;
    (void)state;
    h.params = preset_of(DGB_PRESET_BALANCED);
    m = open_film(&h);
    for (n = 0; n < 20; ++n) run_frame(&m, false);
    for (n = 0; n < 13; ++n) {
        frame s;
        double now, raw, change;
        m.h.params = preset_of(n + 1);
        s = next_frame(&m);
        now = mean_of(&s, s.light[0]);
        raw = mean_of(&s, s.raw[0]);
        change = fabs(now - last) / now;
        if (n > 0) {
            worst = fmax(worst, change);
            worst_raw = fmax(worst_raw, fabs(raw - last_mean) / now);
            excess = fmax(excess, change - 0.15 * fabs(raw - last_mean) / now);
        }
        last = now;
        last_mean = mean_of(&s, s.mean[0]);
        free_frame(&s);
    }
    printf("# presets: irradiance changes by %.4f a frame at most, raw by %.4f; %.4f more than its share\n", worst,
           worst_raw, excess);
    assert_true(excess <= 0.01);
    assert_true(worst <= 0.15 * worst_raw + 0.01);
    assert_true(worst_raw > 0.05); /* or the presets would be all the same, and this would prove nothing */
    close_film(&m);
}

FIXTURE_CONTEXT(f, 4, 5, false)

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_reference),
        cmocka_unit_test(test_reference_divisor),
        cmocka_unit_test(test_reference_cameras),
        cmocka_unit_test(test_reference_engine),
        cmocka_unit_test(test_reference_effects),
        cmocka_unit_test(test_reference_params),
        cmocka_unit_test(test_reference_oracles),
        cmocka_unit_test(test_scale),
        cmocka_unit_test(test_adaptive_changes_nothing),
        cmocka_unit_test(test_first_frame_cut_resize),
        cmocka_unit_test(test_two_builds_without_a_shade),
        cmocka_unit_test(test_velocities_agree_with_matrices),
        cmocka_unit_test(test_shading_twice),
        cmocka_unit_test(test_parameters_that_reset),
        cmocka_unit_test(test_more_of_the_guard_band),
        cmocka_unit_test(test_still_frames_count),
        cmocka_unit_test(test_weight_0_is_raw),
        cmocka_unit_test(test_poison_heals),
        cmocka_unit_test(test_poison_of_bounces_heals),
        cmocka_unit_test(test_poison_and_cut),
        cmocka_unit_test(test_poison_outside),
        cmocka_unit_test(test_every_combination_runs),
        cmocka_unit_test(test_presets_do_not_flash),
        cmocka_unit_test(test_no_messages),
    };
    return cmocka_run_group_tests(tests, open_context, close_context);
}
