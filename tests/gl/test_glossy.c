/* Glossy reflections: a floor of any roughness that mirrors a wall, against the integral over its lobe in double
   precision. */
#include "gl_images.h"
#include "numbers.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define MIRROR DGB_EFFECT_REFLECT
#define GLOSSY (DGB_EFFECT_REFLECT | DGB_EFFECT_GLOSSY)
#define OVER_TIME (GLOSSY | DGB_EFFECT_TEMPORAL)
#define OTHERS (DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY | DGB_EFFECT_BOUNCES | DGB_EFFECT_TEMPORAL)

static fixture f;

static const double pi = 3.14159265358979323846;

/* >> the scene: a floor, and a wall that faces the eye; the camera looks down -Z from the origin of its own space */

static const double floor_y = -1.2, wall_z = -10.0;

enum { WIDTH = 96, HEIGHT = 64, COUNT = WIDTH * HEIGHT };

static void position_of(const stage* s, double px, double py, double z, double x[3]) {
    x[0] = (2.0 * (px - s->guard) / (s->m.width - 2 * s->guard) - 1.0) * -z / (double)s->view.projection[0];
    x[1] = (2.0 * (py - s->guard) / (s->m.height - 2 * s->guard) - 1.0) * -z / (double)s->view.projection[5];
    x[2] = z;
}

static void pixel_of(const stage* s, const double x[3], double pixel[2]) {
    pixel[0] = s->guard + 0.5 * ((double)s->view.projection[0] * x[0] / -x[2] + 1.0) * (s->m.width - 2 * s->guard);
    pixel[1] = s->guard + 0.5 * ((double)s->view.projection[5] * x[1] / -x[2] + 1.0) * (s->m.height - 2 * s->guard);
}

/* z of what a pixel shows; is_floor: which of the two. */
static double scene_z(const stage* s, int px, int py, bool* is_floor) {
    double x[3], z;
    position_of(s, px + 0.5, py + 0.5, -1.0, x);
    z = x[1] < 0.0 ? -floor_y / x[1] : -1e30;
    *is_floor = z > wall_z;
    return *is_floor ? z : wall_z;
}

/* Radiance of the wall: bright, and a little different everywhere. */
static void light_of(const double x[3], double light[3]) {
    light[0] = 4.0 + 0.25 * x[0];
    light[1] = 4.0 + 0.4 * x[1];
    light[2] = 1.0;
}

static void put_scene(stage* s) {
    static const float up[3] = {0.0f, 1.0f, 0.0f}, forth[3] = {0.0f, 0.0f, 1.0f};
    int px, py, k;
    for (py = 0; py < s->m.height; ++py)
        for (px = 0; px < s->m.width; ++px) {
            bool is_floor;
            const double z = scene_z(s, px, py, &is_floor);
            double x[3], light[3];
            images_put(&s->m, 0, px, py, -z, is_floor ? up : forth);
            position_of(s, px + 0.5, py + 0.5, z, x);
            light_of(x, light);
            for (k = 0; k < 3; ++k) images_at(&s->m, IMAGE_RADIANCE, 0, px, py)[k] = is_floor ? 0.0f : (float)light[k];
        }
}

static void set_roughness(stage* s, float roughness) {
    int i;
    for (i = 0; i < s->m.width * s->m.height; ++i) s->m.roughness[i] = roughness;
}

static stage open_stage(uint32_t effects, int layers, int guard) {
    stage s;
    dgb_desc d;
    stage_init(&s, WIDTH + 2 * guard, HEIGHT + 2 * guard, guard);
    s.params.reflect_stride = 1;
    s.params.reflect_border = 0.0f;
    s.params.reflect_steps = 4096;
    s.params.reflect_distance = 100.0f;
    d = images_desc(&f, &s.m, guard, layers, effects);
    assert_int_equal(dgb_init(&s.c, &d), DGB_OK);
    put_scene(&s);
    return s;
}

static void shade(stage* s) { assert_int_equal(dgb_shade(&s->c, &s->params), DGB_OK); }

static void show(stage* s) { assert_int_equal(stage_shade(s), DGB_OK); }

static float* read_slot(const stage* s, dgb_slot slot) { return fixture_image(&s->c, slot, 0, 4); }

/* A pixel of the image, not of the guard band, that shows the floor. */
static bool is_floor_at(const stage* s, int at) {
    const int px = at % s->m.width, py = at / s->m.width;
    bool is_floor;
    if (px < s->guard || py < s->guard || px >= s->m.width - s->guard || py >= s->m.height - s->guard) return false;
    (void)scene_z(s, px, py, &is_floor);
    return is_floor;
}

static bool in_image(const stage* s, int at) {
    const int px = at % s->m.width, py = at / s->m.width;
    return px >= s->guard && py >= s->guard && px < s->m.width - s->guard && py < s->m.height - s->guard;
}

static void check_range(const stage* s, const float* reflection) {
    int at, k;
    for (at = 0; at < s->m.width * s->m.height; ++at) {
        if (!in_image(s, at)) continue;
        for (k = 0; k < 3; ++k)
            assert_true(reflection[4 * at + k] >= 0.0f && reflection[4 * at + k] <= DGB_MAX_RADIANCE);
        assert_true(reflection[4 * at + 3] >= 0.0f && reflection[4 * at + 3] <= 1.0f);
    }
}

/* >> mirrors */

static void check_same(const stage* a, const stage* b, dgb_slot slot, int channels) {
    float *x = read_slot(a, slot), *y = read_slot(b, slot);
    int at, hits = 0;
    for (at = 0; at < a->m.width * a->m.height; ++at) {
        if (!in_image(a, at)) continue;
        assert_memory_equal(x + 4 * at, y + 4 * at, (size_t)channels * sizeof(float));
        hits += x[4 * at] > 0.0f;
    }
    assert_true(hits > 500);
    free(x), free(y);
}

/* Roughness 0, or none: the mirror, to the last bit, frame after frame. */
static void test_mirror(void** state) {
    static const uint32_t with[] = {GLOSSY, OVER_TIME, GLOSSY | OTHERS};
    const float none[] = {0.0f, 0.0019f, -1.0f, -INFINITY, NAN};
    size_t i;
    int layers, frame, at;
    (void)state;
    for (layers = 1; layers <= 2; ++layers)
        for (i = 0; i < 3; ++i) {
            stage a = open_stage(i == 2 ? MIRROR | OTHERS : MIRROR, layers, 5), b = open_stage(with[i], layers, 5);
            for (at = 0; at < b.m.width * b.m.height; ++at) b.m.roughness[at] = none[at % 5];
            for (frame = 0; frame < 3; ++frame) {
                show(&a), show(&b);
                check_same(&a, &b, DGB_REFLECTION, 4);
                check_same(&a, &b, DGB_REFLECTION_HIT, 2);
            }
            stage_close(&a), stage_close(&b);
        }
}

/* Rough neighbours change no mirror. */
static void test_mirror_among_others(void** state) {
    stage a = open_stage(MIRROR, 2, 0), b = open_stage(OVER_TIME, 2, 0);
    int frame, at, rough = 0;
    float *x, *y;
    (void)state;
    for (at = 0; at < COUNT; ++at) b.m.roughness[at] = (at ^ at / WIDTH) & 1 ? 0.5f : 0.0f;
    for (frame = 0; frame < 4; ++frame) show(&a), show(&b);
    x = read_slot(&a, DGB_REFLECTION), y = read_slot(&b, DGB_REFLECTION);
    for (at = 0; at < COUNT; ++at) {
        const bool same = same_bits(x + 4 * at, y + 4 * at, 4 * sizeof *x);
        if (b.m.roughness[at] == 0.0f) assert_true(same);
        rough += !same;
    }
    assert_true(rough > 500);
    free(x), free(y);
    stage_close(&a), stage_close(&b);
}

/* More than 1 is 1. */
static void test_roughest(void** state) {
    stage a = open_stage(OVER_TIME, 2, 0), b = open_stage(OVER_TIME, 2, 0);
    int frame;
    (void)state;
    set_roughness(&a, 1.0f);
    for (frame = 0; frame < 3; ++frame) {
        set_roughness(&b, frame == 0 ? 1.5f : frame == 1 ? INFINITY : 1e30f);
        show(&a), show(&b);
        check_same(&a, &b, DGB_REFLECTION, 4);
    }
    stage_close(&a), stage_close(&b);
}

/* >> furnace */

/* Where all that is mirrored is equally bright, so is every lobe: the weights of rays, of neighbours and of frames add
   up. */
static void test_furnace(void** state) {
    static const float roughnesses[] = {0.02f, 0.1f, 0.3f, 0.6f, 1.0f};
    static const float light[3] = {0.75f, 4.0f, 0.0f};
    size_t i;
    int frame, at, k;
    (void)state;
    for (i = 0; i < 5; ++i) {
        stage s = open_stage(OVER_TIME, 2, 3);
        int hits = 0;
        float* r;
        images_fill(&s.m, IMAGE_RADIANCE, light);
        set_roughness(&s, roughnesses[i]);
        for (frame = 0; frame < 12; ++frame) show(&s);
        r = read_slot(&s, DGB_REFLECTION);
        check_range(&s, r);
        for (at = 0; at < s.m.width * s.m.height; ++at) {
            if (!in_image(&s, at) || r[4 * at + 3] == 0.0f) continue;
            ++hits;
            /* a device that truncates loses a half's last bit a frame, and history keeps 85 % of what was lost: 1 /
               0.15 */
            for (k = 0; k < 3; ++k) assert_true(fabsf(r[4 * at + k] - light[k]) <= 7.0f * light[k] / 1024.0f);
        }
        assert_true(hits > 1500);
        free(r);
        stage_close(&s);
    }
}

/* >> the lobe, integrated */

enum { RADIAL = 96, AROUND = 192 };

typedef struct lobe {
    double weighed[3], confidence; /* radiance times confidence */
} lobe;

/* Over the microfacets that a pixel of the floor shows; a hit counts if it lies `inset` pixels within the buffer. The
   variables of tests/unit/test_ggx.c: share = v.h / cos * 2 s ds dphi / 2 pi, brought to 1. */
static lobe integrate(const stage* s, int px, int py, double alpha, double inset) {
    lobe sum = {{0.0, 0.0, 0.0}, 0.0};
    double x[3], v[3], length, total = 0.0;
    bool is_floor;
    int i, j, k;
    position_of(s, px + 0.5, py + 0.5, scene_z(s, px, py, &is_floor), x);
    length = sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
    for (k = 0; k < 3; ++k) v[k] = -x[k] / length;
    for (i = 0; i < RADIAL; ++i)
        for (j = 0; j < AROUND; ++j) {
            const double share = (i + 0.5) / RADIAL, turn = 2.0 * pi * (j + 0.5) / AROUND;
            const double tangent = alpha * sqrt(1.0 - share * share) / share, up = 1.0 / sqrt(1.0 + tangent * tangent);
            const double h[3] = {up * tangent * cos(turn), up, up * tangent * sin(turn)};
            const double seen = v[0] * h[0] + v[1] * h[1] + v[2] * h[2], weight = seen / up * share;
            double l[3], there[3], pixel[2], light[3], facing, t;
            if (seen <= 0.0) continue;
            total += weight;
            for (k = 0; k < 3; ++k) l[k] = 2.0 * seen * h[k] - v[k];
            if (l[1] <= (double)DGB_MIN_COSINE || l[2] >= 0.0) continue;
            t = (wall_z - x[2]) / l[2];
            for (k = 0; k < 3; ++k) there[k] = x[k] + t * l[k];
            pixel_of(s, there, pixel);
            if (t > (double)s->params.reflect_distance || pixel[0] < inset || pixel[1] < inset ||
                pixel[0] > s->m.width - inset || pixel[1] > s->m.height - inset)
                continue;
            facing = fmin(-4.0 * l[2], 1.0); /* how far a hit is trusted */
            light_of(there, light);
            for (k = 0; k < 3; ++k) sum.weighed[k] += weight * facing * light[k];
            sum.confidence += weight * facing;
        }
    for (k = 0; k < 3; ++k) sum.weighed[k] /= total;
    sum.confidence /= total;
    return sum;
}

enum { FRAMES = 400, STEP = 5 }; /* STEP: every so many pixels are compared */

typedef struct mean {
    double sum[COUNT][4], squares[COUNT][4];
} mean;

static void add_frame(mean* m, const float* r) {
    int at, k;
    for (at = 0; at < COUNT; ++at)
        for (k = 0; k < 4; ++k) {
            const double x = (double)r[4 * at + k] * (k < 3 ? (double)r[4 * at + 3] : 1.0);
            m->sum[at][k] += x;
            m->squares[at][k] += x * x;
        }
}

/* Means of so many frames: of the rays themselves, and of what neighbours and history make of them. */
static void average(stage* s, int frames, mean* raw, mean* final) {
    int frame;
    memset(raw, 0, sizeof *raw), memset(final, 0, sizeof *final);
    for (frame = 0; frame < 32; ++frame) show(s); /* settles */
    for (frame = 0; frame < frames; ++frame) {
        float *x, *y;
        shade(s);
        x = read_slot(s, DGB_REFLECTION_RAW), y = read_slot(s, DGB_REFLECTION);
        add_frame(raw, x), add_frame(final, y);
        free(x), free(y);
    }
}

/* The tests' tolerances, in order: a hit lies up to 1.5 pixels beside where the ray meets the wall (test_reflect.c), so
   hits within that of the border may count or not, and show a radiance so far beside; the stored radiance of a hit is
   rounded to 7 bits (2^-8, on average less); five standard errors of the mean, as if rays were independent: the
   sequence does better. An average of frames is not: with history's weight w the mean of so many varies sqrt((1 + w) /
   (1 - w)) as much as of independent ones. A ratio of few rays is biased, by 2 % on average here: bias. */
static bool is_near(const stage* s, const mean* m, int at, int k, const lobe* low, const lobe* high, double bias) {
    const double metre = 10.0 / (0.5 * HEIGHT * (double)s->view.projection[5]); /* a pixel on the wall */
    const double slope = k == 0 ? 0.25 : k == 1 ? 0.4 : 0.0, average_of = m->sum[at][k] / FRAMES;
    const double variance = m->squares[at][k] / FRAMES - average_of * average_of;
    const double l = k < 3 ? low->weighed[k] : low->confidence, h = k < 3 ? high->weighed[k] : high->confidence;
    const double beside = 1.5 * metre * slope * high->confidence + h / 256.0;
    const double w = bias > 0.0 ? (double)s->params.history_weight : 0.0;
    const double chance = 5.0 * sqrt(fmax(variance, 0.0) / FRAMES * (1.0 + w) / (1.0 - w)) + 1e-3;
    return average_of >= l * (1.0 - bias) - beside - chance && average_of <= h * (1.0 + bias) + beside + chance;
}

/* RMS of what neighbours and history make of the rays' own mean, as a share of it, where there is much to see. */
static double rms_bias(const stage* s, const mean* raw, const mean* final) {
    double sum = 0.0;
    int at, count = 0;
    for (at = 0; at < COUNT; ++at) {
        if (!is_floor_at(s, at) || raw->sum[at][1] < 0.5 * FRAMES) continue;
        sum += pow(final->sum[at][1] / raw->sum[at][1] - 1.0, 2.0);
        ++count;
    }
    assert_true(count > 500);
    return sqrt(sum / count);
}

/* bias: of rms_bias, a third more than was measured; the means' own noise is part of it. */
static void check_lobe(float roughness, double bias) {
    static mean raw, final;
    const double alpha = (double)dgb_ggx_alpha(roughness);
    stage s = open_stage(OVER_TIME, 1, 0);
    double rms;
    int px, py, k, pixels = 0, off = 0, off_final = 0;
    set_roughness(&s, roughness);
    average(&s, FRAMES, &raw, &final);
    for (py = 1; py < HEIGHT; py += STEP)
        for (px = 1; px < WIDTH; px += STEP) {
            const int at = py * WIDTH + px;
            lobe low, high;
            if (!is_floor_at(&s, at)) continue;
            low = integrate(&s, px, py, alpha, 1.5), high = integrate(&s, px, py, alpha, -1.5);
            ++pixels;
            for (k = 0; k < 4; ++k) {
                off += !is_near(&s, &raw, at, k, &low, &high, 0.0);
                off_final += !is_near(&s, &final, at, k, &low, &high, 0.05);
            }
        }
    rms = rms_bias(&s, &raw, &final);
    printf("# roughness %g: %d pixels, %d and %d values off, bias %.4f\n", (double)roughness, pixels, off, off_final,
           rms);
    assert_true(rms <= bias);
    assert_true(pixels > 50);
    assert_int_equal(off, 0);
    assert_int_equal(off_final, 0);
    stage_close(&s);
}

static void test_lobe(void** state) {
    (void)state;
    check_lobe(0.1f, 0.0076);
    check_lobe(0.3f, 0.036);
    check_lobe(0.6f, 0.061);
    check_lobe(1.0f, 0.059);
}

/* >> frames */

/* RMS deviation of the green of the floor's pixels from what it should be, in the lower half of the image, where all is
   seen. */
static double noise(stage* s, const mean* expected) {
    float* r = read_slot(s, DGB_REFLECTION);
    double sum = 0.0;
    int at, count = 0;
    for (at = 0; at < COUNT / 3; ++at) {
        const double m = expected->sum[at][1] / FRAMES;
        if (!is_floor_at(s, at)) continue;
        sum += pow((double)r[4 * at + 1] * (double)r[4 * at + 3] / m - 1.0, 2.0);
        ++count;
    }
    free(r);
    assert_true(count > 500);
    return sqrt(sum / count);
}

/* One ray; with neighbours; with history; with more. Of independent samples, 9 leave a third of the noise and a history
   of weight w sqrt((1 - w) / (1 + w)): 0.28, 0.13. Neighbours overlap, and lobes differ, so that a half is asked of
   each. */
static void test_noise(void** state) {
    static mean raw, final;
    stage s = open_stage(OVER_TIME, 1, 0);
    double alone, neighbours, history, more;
    int frame;
    (void)state;
    set_roughness(&s, 0.4f);
    average(&s, FRAMES, &raw, &final);
    s.params.history_weight = 0.0f, s.params.glossy_taps = 0;
    show(&s);
    alone = noise(&s, &raw);
    s.params.glossy_taps = 8;
    shade(&s);
    neighbours = noise(&s, &raw);
    s.params.history_weight = 0.85f;
    for (frame = 0; frame < 64; ++frame) shade(&s);
    history = noise(&s, &raw);
    s.params.history_weight = 0.97f;
    for (frame = 0; frame < 128; ++frame) shade(&s);
    more = noise(&s, &raw);
    printf("# one ray %.3f, neighbours %.3f, history %.3f, more %.3f\n", alone, neighbours, history, more);
    assert_true(neighbours < 0.5 * alone);
    assert_true(history < 0.5 * neighbours);
    assert_true(more < history);
    stage_close(&s);
}

/* The least and the most frames that the pixels of the floor have averaged. */
static void count_frames(const stage* s, int* least, int* most) {
    float* frames = read_slot(s, DGB_REFLECTION_FRAMES);
    int at;
    *least = 255, *most = 0;
    for (at = 0; at < s->m.width * s->m.height; ++at) {
        const int count = (int)(frames[4 * at] * 255.0f + 0.5f);
        if (!is_floor_at(s, at)) continue;
        *least = count < *least ? count : *least;
        *most = count > *most ? count : *most;
    }
    free(frames);
}

static void check_frames(const stage* s, int expected) {
    int least, most;
    count_frames(s, &least, &most);
    if (least != expected || most != expected) fail_msg("%d to %d frames, not %d", least, most, expected);
}

/* What gives another result, or another place, starts afresh; what only changes how well does not. */
static void test_history_ends(void** state) {
    stage s = open_stage(OVER_TIME, 2, 4);
    int frame;
    (void)state;
    set_roughness(&s, 1.0f); /* blurs by pixels even next to the wall */
    s.params.glossy_taps = 0;
    for (frame = 1; frame <= 70; ++frame) show(&s), check_frames(&s, frame < 64 ? frame : 64);
    s.view.cut = true, show(&s), check_frames(&s, 1);
    s.view.cut = false, show(&s), check_frames(&s, 2);
    s.params.history_weight = 0.5f, s.params.filter_taps = 3, s.params.radius = 2.0f, s.params.reflect_steps = 999;
    show(&s), check_frames(&s, 3);
    s.params.reflect_distance = 50.0f, show(&s), check_frames(&s, 1);
    show(&s), check_frames(&s, 2);
    s.params.reflect_thickness = 0.25f, show(&s), check_frames(&s, 1);
    s.params.separation = 0.25f, show(&s), check_frames(&s, 1);
    show(&s), check_frames(&s, 2);
    stage_close(&s);
}

/* A camera that moves along x sees the same floor and the same wall; their velocity in pixels is that of their
   distance. */
static void move(stage* s, float step) {
    int px, py;
    s->view.view[12] -= step;
    for (py = 0; py < s->m.height; ++py)
        for (px = 0; px < s->m.width; ++px) {
            bool is_floor;
            const double z = scene_z(s, px, py, &is_floor);
            images_at(&s->m, IMAGE_VELOCITY, 0, px, py)[0] =
                (float)(-0.5 * (double)step * (double)s->view.projection[0] / -z * s->m.width);
        }
}

/* A sharp image slides over its surface when the camera moves, and its history is of other things; a blurred one
   stays. */
static void test_sliding(void** state) {
    stage s = open_stage(OVER_TIME, 1, 0);
    int least, most, frame;
    (void)state;
    s.params.glossy_taps = 0;
    set_roughness(&s, 0.2f); /* blurs by two pixels at most, and an image slides up to four */
    for (frame = 0; frame < 8; ++frame) show(&s);
    count_frames(&s, &least, &most);
    printf("# roughness 0.2: %d to %d frames at rest", least, most);
    assert_true(most == 8);
    for (frame = 0; frame < 8; ++frame) move(&s, 0.6f), show(&s);
    count_frames(&s, &least, &most);
    printf(", %d to %d in motion\n", least, most);
    assert_true(most <= 2);
    set_roughness(&s, 0.9f);
    s.view.cut = true, show(&s), s.view.cut = false;
    for (frame = 0; frame < 8; ++frame) move(&s, 0.02f), show(&s);
    count_frames(&s, &least, &most);
    printf("# roughness 0.9: %d to %d in motion\n", least, most);
    assert_true(most == 9); /* the border comes into view */
    stage_close(&s);
}

static void fill_slot(const stage* s, dgb_slot slot, float value) {
    const int count = 4 * s->m.width * s->m.height;
    float* texels = (float*)malloc((size_t)count * sizeof *texels);
    int i;
    for (i = 0; i < count; ++i) texels[i] = value;
    fixture_put_image(&s->c, slot, 4, texels);
    free(texels);
}

/* History that is no number is gone a frame later, and takes nothing of this frame's rays with it. */
static void test_heals(void** state) {
    static const float odd[] = {NAN, INFINITY, -INFINITY, -5.0f};
    stage s = open_stage(OVER_TIME, 1, 0);
    size_t i;
    (void)state;
    set_roughness(&s, 0.5f);
    show(&s), show(&s);
    for (i = 0; i < sizeof odd / sizeof odd[0]; ++i) {
        float *r, *raw;
        int at, hits = 0;
        fill_slot(&s, DGB_REFLECTION, odd[i]); /* last frame's from now on */
        shade(&s);
        r = read_slot(&s, DGB_REFLECTION), raw = read_slot(&s, DGB_REFLECTION_RAW);
        check_range(&s, r);
        for (at = 0; at < COUNT; ++at) {
            if (!is_floor_at(&s, at) || raw[4 * at + 3] < 0.5f) continue;
            ++hits;
            assert_true(r[4 * at + 3] > 0.0f && r[4 * at + 1] > 0.0f);
        }
        assert_true(hits > 500);
        free(r), free(raw);
    }
    stage_close(&s);
}

/* >> layers that the library has built */

static void upload_array(const stage* s, dgb_slot slot, GLenum format, const float* texels) {
    glBindTexture(GL_TEXTURE_2D_ARRAY, dgbgl_texture_name(dgb_get_texture(&s->c, slot)));
    glTexSubImage3D(GL_TEXTURE_2D_ARRAY, 0, 0, 0, 0, s->m.width, s->m.height, 1, format, GL_FLOAT, texels);
    glBindTexture(GL_TEXTURE_2D_ARRAY, 0);
}

static void draw_nothing(void* user, const dgb_draw* draw) { (void)user, (void)draw; }

/* The same images as an engine's own layers and in the library's arrays, roughness in the blue of DGB_NORMAL: the same
   result. */
static void test_built_layers(void** state) {
    stage a = open_stage(GLOSSY, 1, 3), b;
    const int count = a.m.width * a.m.height;
    float* normals = (float*)calloc((size_t)count, 4 * sizeof *normals);
    dgb_desc d = images_desc(&f, &a.m, 3, 1, GLOSSY);
    int i;
    (void)state;
    for (i = 0; i < count; ++i) {
        const uint16_t code = dgb_oct16_encode(a.m.texels[IMAGE_NORMAL][0] + 3 * i);
        normals[4 * i] = (float)(code & 255) / 255.0f, normals[4 * i + 1] = (float)(code >> 8) / 255.0f;
        normals[4 * i + 2] = a.m.roughness[i] = i % 3 ? 1.0f : 0.0f; /* the same in a byte */
        normals[4 * i + 3] = 0.5f;                                   /* the engine's own */
        dgb_r11g11b10f_unpack(dgb_r11g11b10f_pack(a.m.texels[IMAGE_RADIANCE][0] + 3 * i),
                              a.m.texels[IMAGE_RADIANCE][0] + 3 * i);
    }
    b = a;
    d.source = DGB_SOURCE_BUILD, d.normals = DGB_NORMALS_FROM_DEPTH;
    assert_int_equal(dgb_init(&b.c, &d), DGB_OK);
    assert_int_equal(dgb_build(&b.c, &b.view, &b.params, draw_nothing, NULL), DGB_OK);
    upload_array(&b, DGB_DEPTH, GL_DEPTH_COMPONENT, a.m.texels[IMAGE_DEPTH][0]);
    upload_array(&b, DGB_NORMAL, GL_RGBA, normals);
    upload_array(&b, DGB_RADIANCE, GL_RGB, a.m.texels[IMAGE_RADIANCE][0]);
    show(&a), shade(&b);
    check_same(&a, &b, DGB_REFLECTION, 4);
    check_same(&a, &b, DGB_REFLECTION_HIT, 4);
    dgb_shutdown(&b.c);
    stage_close(&a);
    free(normals);
}

/* >> what an engine may hand over */

static uint32_t random_state = 1u;

static void test_any_input(void** state) {
    stage s = open_stage(OVER_TIME, 2, 2);
    int frame, kind, i;
    (void)state;
    for (frame = 0; frame < 24; ++frame) {
        float* r;
        put_scene(&s);
        for (i = 0; i < s.m.width * s.m.height; ++i) {
            const uint32_t bits = lcg_bits(&random_state) ^ lcg_bits(&random_state) << 16;
            memcpy(&s.m.roughness[i], &bits, sizeof bits);
            if (i % 3) s.m.roughness[i] = (float)(bits >> 8) / 16777216.0f;
            for (kind = 0; kind < IMAGE_KINDS; ++kind) /* one texel in 32 is anything */
                if (lcg_bits(&random_state) >> 16 < 2048u) memcpy(&s.m.texels[kind][frame % 2][i], &bits, sizeof bits);
        }
        s.params.glossy_taps = frame % 33;
        s.params.glossy_radius = frame % 5 ? 16.0f : frame % 2 ? 0.0f : 1e6f;
        s.params.normal_sharpness = s.params.plane_sharpness = frame % 4 ? 4.0f : 0.0f;
        show(&s);
        r = read_slot(&s, DGB_REFLECTION);
        check_range(&s, r);
        free(r);
    }
    stage_close(&s);
}

FIXTURE_CONTEXT(f, 4, 5, false)

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_mirror),       cmocka_unit_test(test_mirror_among_others),
        cmocka_unit_test(test_roughest),     cmocka_unit_test(test_furnace),
        cmocka_unit_test(test_lobe),         cmocka_unit_test(test_noise),
        cmocka_unit_test(test_history_ends), cmocka_unit_test(test_sliding),
        cmocka_unit_test(test_heals),        cmocka_unit_test(test_built_layers),
        cmocka_unit_test(test_any_input),    cmocka_unit_test(test_no_messages),
    };
    return cmocka_run_group_tests(tests, open_context, close_context);
}
