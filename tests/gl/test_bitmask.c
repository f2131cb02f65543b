/* DGB_ESTIMATOR_BITMASK: scenes whose visibility and irradiance are known, and what must hold for any image. */
#include "gl_images.h"
#include "tally.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define PI 3.14159265358979323846

static fixture f;
static dgb_thickness thickness_from; /* of every context */
static double back_behind;           /* the panes of bodies, m: where their back faces are */

/* >> scenes: panes that are traced into the layers, the eye at the origin, looking down -Z */

typedef struct pane {
    double corner[3], u[3], v[3]; /* two sides from a corner; it faces u x v */
    double sent;                  /* radiance, of all channels */
} pane;

static double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void cross(const double a[3], const double b[3], double c[3]) {
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

static void normal_of(const pane* p, double n[3]) {
    double length;
    int k;
    cross(p->u, p->v, n);
    length = sqrt(dot(n, n));
    for (k = 0; k < 3; ++k) n[k] /= length;
}

/* Distance along the ray in units of its direction; 0: missed, or met from behind. */
static double meet(const pane* p, const double from[3], const double way[3]) {
    double n[3], to[3], t, a, b;
    int k;
    normal_of(p, n);
    if (dot(n, way) >= 0.0) return 0.0;
    for (k = 0; k < 3; ++k) to[k] = p->corner[k] - from[k];
    t = dot(n, to) / dot(n, way);
    for (k = 0; k < 3; ++k) to[k] = from[k] + t * way[k] - p->corner[k];
    a = dot(to, p->u) / dot(p->u, p->u);
    b = dot(to, p->v) / dot(p->v, p->v);
    return t > 0.0 && a >= 0.0 && a < 1.0 && b >= 0.0 && b < 1.0 ? t : 0.0;
}

/* Direction of a pixel's ray, z -1. */
static void ray_of(const stage* s, int x, int y, double way[3]) {
    const float* p = s->view.projection;
    way[0] = (2.0 * (x + 0.5) / s->m.width - 1.0) / (double)p[0];
    way[1] = (2.0 * (y + 0.5) / s->m.height - 1.0) / (double)p[5];
    way[2] = -1.0;
}

/* Panes have right angles. The second layer is the first pane that is met beyond the separation behind the nearest. */
static void trace(stage* s, const pane* panes, int count) {
    static const double eye[3] = {0.0, 0.0, 0.0};
    int x, y, i, layer;
    for (y = 0; y < s->m.height; ++y)
        for (x = 0; x < s->m.width; ++x) {
            double way[3], beyond = 0.0;
            ray_of(s, x, y, way);
            for (layer = 0; layer < 2; ++layer) {
                double best = 1e30, n[3];
                int found = -1;
                for (i = 0; i < count; ++i) {
                    const double t = meet(&panes[i], eye, way);
                    if (t > beyond && t < best) best = t, found = i;
                }
                if (found < 0) break;
                normal_of(&panes[found], n);
                images_put(&s->m, layer, x, y, best, (const float[3]){(float)n[0], (float)n[1], (float)n[2]});
                for (i = 0; i < 3; ++i) images_at(&s->m, IMAGE_RADIANCE, layer, x, y)[i] = (float)panes[found].sent;
                beyond = best + (double)s->params.separation;
            }
        }
}

static stage open_stage(int width, int height, int layers, uint32_t effects, dgb_estimator estimator) {
    stage s;
    dgb_desc d;
    stage_init(&s, width, height, 0);
    s.params.min_level = 0;
    d = images_desc(&f, &s.m, 0, layers, effects);
    d.estimator = estimator;
    d.thickness = thickness_from;
    assert_int_equal(dgb_init(&s.c, &d), DGB_OK);
    return s;
}

static void shade(stage* s) { assert_int_equal(stage_shade(s), DGB_OK); }

/* Raw results, a mean over so many frames, which all take other slices and steps. Irradiance is that which arrives:
   times its confidence. Caller frees. */
static double* mean_of(stage* s, dgb_slot slot, int frames) {
    const int pixels = s->m.width * s->m.height, channels = slot == DGB_AO_RAW ? 1 : 4;
    double* mean = (double*)calloc((size_t)pixels, sizeof *mean);
    int i, frame;
    for (frame = 0; frame < frames; ++frame) {
        float* image;
        shade(s);
        image = fixture_image(&s->c, slot, 0, channels);
        for (i = 0; i < pixels; ++i)
            mean[i] += (double)(channels == 1 ? image[i] : image[4 * i] * image[4 * i + 3]) / frames;
        free(image);
    }
    return mean;
}

/* The pixel's point on a pane. */
static void point_on(const stage* s, const pane* p, int x, int y, double point[3]) {
    static const double eye[3] = {0.0, 0.0, 0.0};
    double t;
    int k;
    ray_of(s, x, y, point);
    t = meet(p, eye, point);
    assert_true(t > 0.0);
    for (k = 0; k < 3; ++k) point[k] *= t;
}

/* What a body hides, that stands behind a pane that is parallel to the image: all that the eye would see through it, so
   many metres deep. */
typedef struct body {
    const pane* front;
    double thickness;
} body;

static bool hides(const body* b, const double x[3], const double way[3], double radius) {
    enum { DEPTHS = 100 };
    const double *c = b->front->corner, *u = b->front->u, *v = b->front->v;
    int i;
    for (i = 0; i <= DEPTHS; ++i) {
        const double z = c[2] - b->thickness * i / DEPTHS, t = (z - x[2]) / way[2], scale = c[2] / z;
        const double at_x = (x[0] + t * way[0]) * scale - c[0], at_y = (x[1] + t * way[1]) * scale - c[1];
        if (t > 0.0 && t <= radius && at_x >= 0.0 && at_x < u[0] && at_y >= 0.0 && at_y < v[1]) return true;
    }
    return false;
}

/* Cosine-weighted visibility from a point of a surface that faces the eye's image plane, by 256 x 64 directions. */
static double true_visibility(const double x[3], const body* bodies, int count, double radius) {
    enum { TURNS = 256, RINGS = 64 };
    int turn, ring, i, open = 0;
    for (turn = 0; turn < TURNS; ++turn)
        for (ring = 0; ring < RINGS; ++ring) {
            const double sine2 = (ring + 0.5) / RINGS, angle = 2.0 * PI * (turn + 0.5) / TURNS;
            const double way[3] = {sqrt(sine2) * cos(angle), sqrt(sine2) * sin(angle), sqrt(1.0 - sine2)};
            bool hidden = false;
            for (i = 0; i < count; ++i) hidden = hidden || hides(&bodies[i], x, way, radius);
            open += !hidden;
        }
    return (double)open / (TURNS * RINGS);
}

/* Share of what arrives at a point with normal n from a whole pane above its horizon: Lambert's sum over its sides. */
static double form_factor(const double x[3], const double n[3], const pane* p) {
    double corners[4][3], sum = 0.0;
    int i, k;
    for (i = 0; i < 4; ++i)
        for (k = 0; k < 3; ++k)
            corners[i][k] = p->corner[k] + (i == 1 || i == 2 ? p->u[k] : 0.0) + (i >= 2 ? p->v[k] : 0.0) - x[k];
    for (i = 0; i < 4; ++i) {
        const double *a = corners[i], *b = corners[(i + 1) % 4];
        double c[3], length;
        cross(a, b, c);
        length = sqrt(dot(c, c));
        sum += atan2(length, dot(a, b)) * dot(c, n) / length;
    }
    return fabs(sum) / (2.0 * PI);
}

/* >> nothing in the way */

/* Planes of all tilts: nothing hides anything. A frame has two half planes of 32 sectors, and one that lies nearly
   across the normal may be hidden as a whole, by the error of the Oct16 normal, up to 0.96 degrees: 1/2, in two of 16
   frames at most. On average over the image that is next to nothing. */
static void test_planes_are_open(void** state) {
    static const double tilts[] = {0.0, 0.4, 0.8, 1.1, 1.3};
    size_t i;
    int turn, k;
    (void)state;
    for (i = 0; i < sizeof tilts / sizeof tilts[0]; ++i)
        for (turn = 0; turn < 3; ++turn) {
            const double a = tilts[i], b = turn * 1.1;
            /* the normal, and two sides of a pane so large that the eye sees nothing else */
            const double n[3] = {sin(a) * cos(b), sin(a) * sin(b), cos(a)};
            pane p = {{0.0, 0.0, -4.0}, {-sin(b), cos(b), 0.0}, {0.0, 0.0, 0.0}, 0.0};
            stage s = open_stage(97, 71, 2, DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY | DGB_EFFECT_TEMPORAL,
                                 DGB_ESTIMATOR_BITMASK);
            double *open, *light, sum = 0.0, least = 1.0, most = 0.0;
            int count = 0;
            cross(n, p.u, p.v);
            for (k = 0; k < 3; ++k) p.corner[k] -= 500.0 * (p.u[k] + p.v[k]), p.u[k] *= 1000.0, p.v[k] *= 1000.0;
            p.sent = 1.0;
            trace(&s, &p, 1);
            open = mean_of(&s, DGB_AO_RAW, 16);
            light = mean_of(&s, DGB_IRRADIANCE_RAW, 16);
            for (k = 0; k < 97 * 71; ++k) {
                least = fmin(least, open[k]);
                most = fmax(most, light[k]);
                sum += open[k], ++count;
            }
            assert_true(least >= 1.0 - 2.0 * 0.5 / 16.0 - 1.5 / 255.0); /* stored in a byte */
            assert_true(sum / count > 0.9995 && most < 0.02);
            assert_true(sum / count > 0.999);
            free(open);
            free(light);
            stage_close(&s);
        }
}

/* >> visibility beside bodies of known shape */

static void put_backs(stage* s, const body* bodies, int count) {
    static const double eye[3] = {0.0, 0.0, 0.0};
    int x, y, i;
    for (y = 0; y < s->m.height; ++y)
        for (x = 0; x < s->m.width; ++x)
            for (i = 0; i < count; ++i) {
                double way[3], t;
                ray_of(s, x, y, way);
                t = meet(bodies[i].front, eye, way);
                if (t > 0.0) s->m.back[y * s->m.width + x] = images_depth(t + back_behind);
            }
}

/* A wall that faces the eye at 5 m, panes before it. Compared at pixels of the middle row that see the wall, averaged
   over frames. The bounds: the panes' borders are known to half a pixel, 2 cm, of a hemisphere of 0.6 to 1.5 m; a step
   up to 16 pixels away is of one pixel, and farther ones of two and four. Over all pixels half of that cancels. */
static void check_bodies(const char* name, int layers, const body* bodies, int count, float thickness, double bound,
                         double mean_bound) {
    static const pane wall = {{-50.0, -50.0, -5.0}, {100.0, 0.0, 0.0}, {0.0, 100.0, 0.0}, 0.0};
    const double radius = 1.5;
    pane all[4];
    stage s = open_stage(193, 145, layers, DGB_EFFECT_AO | DGB_EFFECT_TEMPORAL, DGB_ESTIMATOR_BITMASK);
    double *open, worst = 0.0, sum = 0.0;
    int x, i, compared = 0, hidden = 0;
    for (i = 0; i < count; ++i) all[i] = *bodies[i].front;
    all[count] = wall;
    s.params.ao_radius = (float)radius;
    s.params.ao_samples = 96;
    s.params.thickness = thickness;
    trace(&s, all, count + 1);
    put_backs(&s, bodies, count);
    open = mean_of(&s, DGB_AO_RAW, 64);
    for (x = 50; x < 143; x += 4) {
        double point[3], truth, error;
        if (fabs((double)*images_at(&s.m, IMAGE_DEPTH, 0, x, 72) - (double)images_depth(5.0)) > 1e-6) continue;
        point_on(&s, &wall, x, 72, point);
        truth = true_visibility(point, bodies, count, radius);
        error = open[72 * 193 + x] - truth;
        worst = fmax(worst, fabs(error));
        sum += error;
        hidden += truth < 0.9;
        ++compared;
    }
    print_message("%s: %d points, error %.4f at most, %+.4f on average\n", name, compared, worst, sum / compared);
    assert_true(compared >= 10 && hidden >= 4);
    assert_true(worst < bound && fabs(sum / compared) < mean_bound);
    free(open);
    stage_close(&s);
}

static void test_bodies(void** state) {
    /* 0.6 m before the wall, from a little to the right of the middle on; and 0.6 m before that, one that hides it and
       one that does not hide its border */
    static const pane panes[] = {{{0.4, -3.0, -4.4}, {3.0, 0.0, 0.0}, {0.0, 6.0, 0.0}, 0.0},
                                 {{0.3, -3.0, -3.8}, {3.0, 0.0, 0.0}, {0.0, 6.0, 0.0}, 0.0},
                                 {{0.4, -2.0, -3.8}, {2.0, 0.0, 0.0}, {0.0, 4.0, 0.0}, 0.0}};
    static const body thin = {&panes[0], 0.2}, thick = {&panes[0], 0.4},
                      plates[] = {{&panes[0], 0.2}, {&panes[1], 0.2}}, ended[] = {{&panes[0], 2.0}, {&panes[2], 0.6}};
    (void)state;
    check_bodies("a half plane of 0.2 m", 1, &thin, 1, 0.2f, 0.03, 0.01);
    check_bodies("a slab of 0.4 m", 1, &thick, 1, 0.4f, 0.03, 0.01);
    check_bodies("parallel plates, two layers", 2, plates, 2, 0.2f, 0.03, 0.01);
    check_bodies("thicker than the way to the second layer", 2, ended, 2, 2.0f, 0.03, 0.01);
}

/* A pane stands on a wall, so wide that it nears the eye, in steps so long that its plane goes on along them beyond
   every radius. From the wall it is seen no higher than the radius above it: at a distance d from it, a slice towards
   it has at most r^2 / (r^2 + d^2) of its cosine-weighted share below. A frame has one such slice, and one away from
   it. The line of sight, about which slices turn, is off the wall's normal by up to 12 degrees, and sectors are 1/64
   of the whole: 0.05. */
static void test_nothing_reaches_beyond_the_radius(void** state) {
    static const pane panes[] = {{{-50.0, -50.0, -5.0}, {100.0, 0.0, 0.0}, {0.0, 100.0, 0.0}, 0.0},
                                 {{0.4, -3.0, -5.0}, {0.0, 0.0, 4.0}, {0.0, 6.0, 0.0}, 0.0}};
    stage s = open_stage(193, 145, 1, DGB_EFFECT_RADIOSITY | DGB_EFFECT_TEMPORAL, DGB_ESTIMATOR_BITMASK);
    double worst = -1.0;
    int frame, x, y, hit = 0;
    (void)state;
    s.params.radius = 1.5f;
    s.params.samples = 2;
    trace(&s, panes, 2);
    for (frame = 0; frame < 16; ++frame) {
        float* light;
        shade(&s);
        light = fixture_image(&s.c, DGB_IRRADIANCE_RAW, 0, 4);
        for (y = 50; y < 95; ++y)
            for (x = 70; x < 90; ++x) { /* 0.3 to 0.98 of the radius from it */
                double point[3], hidden = (double)light[4 * (y * 193 + x) + 3], d;
                point_on(&s, &panes[0], x, y, point);
                d = (0.4 - point[0]) / 1.5;
                hit += hidden > 0.1;
                worst = fmax(worst, hidden - 0.5 / (1.0 + d * d));
            }
        free(light);
    }
    print_message("beside a pane: hidden %d times, %+.4f more than its height at most\n", hit, worst);
    assert_true(hit > 100 && worst < 0.05);
    stage_close(&s);
}

/* A slab that is taken to be 0.6 m thick at most is that without anything to end it, is as thick as it is where its
   back is drawn, but for a quarter of the most, and goes as far as the second layer at the latest, which is the
   wall. */
static void test_thickness(void** state) {
    static const pane front = {{0.4, -3.0, -4.4}, {3.0, 0.0, 0.0}, {0.0, 6.0, 0.0}, 0.0};
    static const struct {
        const char* name;
        dgb_thickness from;
        int layers;
        double back, most, thickness; /* the last is what comes of it */
    } cases[] = {{"constant", DGB_THICKNESS_CONSTANT, 2, 0.2, 0.6, 0.6},
                 {"to the second layer", DGB_THICKNESS_LAYERS, 2, 0.2, 2.0, 0.6},
                 {"back faces of 0.2 m", DGB_THICKNESS_BACK_FACES, 2, 0.2, 0.6, 0.2},
                 {"back faces of 0.4 m, one layer", DGB_THICKNESS_BACK_FACES, 1, 0.4, 1.0, 0.4},
                 {"back faces of 0.01 m, one layer", DGB_THICKNESS_BACK_FACES, 1, 0.01, 0.8, 0.2}};
    size_t i;
    (void)state;
    for (i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        const body slab = {&front, cases[i].thickness};
        thickness_from = cases[i].from;
        back_behind = cases[i].back;
        check_bodies(cases[i].name, cases[i].layers, &slab, 1, (float)cases[i].most, 0.03, 0.01);
    }
    thickness_from = DGB_THICKNESS_LAYERS;
}

/* A pane that glows towards the eye hangs before a wall: the wall sees its back. */
static void test_back_of_a_lamp(void** state) {
    const pane panes[] = {{{-50.0, -50.0, -5.0}, {100.0, 0.0, 0.0}, {0.0, 100.0, 0.0}, 0.0},
                          {{0.3, -1.0, -4.5}, {2.0, 0.0, 0.0}, {0.0, 2.0, 0.0}, 5.0}};
    int normal_test, i;
    (void)state;
    for (normal_test = 0; normal_test < 2; ++normal_test) {
        stage s = open_stage(193, 145, 2, DGB_EFFECT_RADIOSITY | DGB_EFFECT_TEMPORAL, DGB_ESTIMATOR_BITMASK);
        double *light, sum = 0.0;
        s.params.normal_test = normal_test != 0;
        s.params.radius = 2.0f;
        trace(&s, panes, 2);
        light = mean_of(&s, DGB_IRRADIANCE_RAW, 4);
        for (i = 0; i < 193 * 145; ++i) sum += light[i];
        if (normal_test) assert_true(sum == 0.0);
        if (!normal_test) assert_true(sum > 100.0); /* nobody asked which way it faces */
        free(light);
        stage_close(&s);
    }
}

/* A wall's texels in the second layer, behind what hangs 0.6 m before it. A pane as thick as that hides all from them but
   for the sectors before the first step, which is up to 2 pixels away, 0.12 m: the angle's sin^2 is 0.04, up to 2
   sectors of 32. A dot of one pixel hides 1/400, less than a sector of 64, which rounding may cover. All that a march may
   find of it is in the receiver's own pixel, which does not count: at the image's border, where the first step would
   leave it, and where a level's texel stands for that pixel. */
static void test_behind_the_first_layer(void** state) {
    enum { SIZE = 97, APART = 32 };
    static const struct {
        int every;         /* pixels between dots; 1: a pane */
        int border;        /* left out: within the radius of it a part is open */
        int levels;        /* that are tried as the least */
        float least, most; /* hidden */
    } cases[] = {{1, 32, 1, 60.0f / 64.0f, 1.0f}, {APART, 0, 4, 0.0f, 1.0f / 64.0f}};
    static const pane wall = {{-50.0, -50.0, -5.0}, {100.0, 0.0, 0.0}, {0.0, 100.0, 0.0}, 0.0};
    static const float n[3] = {0.0f, 0.0f, 1.0f};
    int k, i, x, y;
    (void)state;
    for (k = 0; k < 2; ++k) {
        stage s = open_stage(SIZE, SIZE, 2, DGB_EFFECT_RADIOSITY | DGB_EFFECT_BOUNCES | DGB_EFFECT_TEMPORAL,
                             DGB_ESTIMATOR_BITMASK);
        s.params.radius = 1.2f; /* 20 pixels: no dot is within another's reach */
        s.params.thickness = 1.0f;
        trace(&s, &wall, 1);
        for (y = 0; y < SIZE; y += cases[k].every)
            for (x = 0; x < SIZE; x += cases[k].every) {
                images_put(&s.m, 1, x, y, 5.0, n);
                images_put(&s.m, 0, x, y, 4.4, n);
            }
        for (i = 0; i < 4 * cases[k].levels; ++i) {
            float* light;
            s.params.min_level = i / 4;
            s.params.normal_test = i % 2 != 0;
            shade(&s);
            light = fixture_image(&s.c, DGB_IRRADIANCE1_RAW, 0, 4);
            for (y = cases[k].border; y < SIZE - cases[k].border; y += APART)
                for (x = cases[k].border; x < SIZE - cases[k].border; x += APART) {
                    const float hidden = light[4 * (y * SIZE + x) + 3];
                    assert_true(hidden >= cases[k].least && hidden <= cases[k].most);
                }
            free(light);
        }
        stage_close(&s);
    }
}

/* >> bent directions */

/* As true_visibility, the mean of the open directions, camera space. */
static void true_bent(const double x[3], const body* b, double radius, double bent[3]) {
    enum { TURNS = 256, RINGS = 64 };
    int turn, ring, k;
    memset(bent, 0, 3 * sizeof *bent);
    for (turn = 0; turn < TURNS; ++turn)
        for (ring = 0; ring < RINGS; ++ring) {
            const double sine2 = (ring + 0.5) / RINGS, angle = 2.0 * PI * (turn + 0.5) / TURNS;
            const double way[3] = {sqrt(sine2) * cos(angle), sqrt(sine2) * sin(angle), sqrt(1.0 - sine2)};
            for (k = 0; k < 3 && !hides(b, x, way, radius); ++k) bent[k] += way[k] / (TURNS * RINGS);
        }
}

/* A turn of the world: its rows are the camera's axes. */
static void turn_view(stage* s, float turned[3][3]) {
    static const float rows[3][3] = {{0.36f, 0.48f, -0.8f}, {-0.8f, 0.6f, 0.0f}, {0.48f, 0.64f, 0.6f}};
    int i, k;
    memcpy(turned, rows, sizeof rows);
    for (i = 0; i < 3; ++i)
        for (k = 0; k < 3; ++k) s->view.view[4 * k + i] = rows[i][k];
}

/* An open wall: 2/3 of its normal, in every frame and after both filters, within some ulps of halves; and all of it. */
static void test_open_is_the_normal(void** state) {
    const dgb_slot slots[] = {DGB_BENT_RAW, DGB_BENT_MEAN, DGB_BENT};
    const pane wall = {{-50.0, -50.0, -5.0}, {100.0, 0.0, 0.0}, {0.0, 100.0, 0.0}, 0.0};
    stage s = open_stage(97, 71, 2, DGB_EFFECT_AO | DGB_EFFECT_BENT | DGB_EFFECT_TEMPORAL, DGB_ESTIMATOR_BITMASK);
    float rows[3][3];
    int slot, i, k;
    (void)state;
    turn_view(&s, rows);
    trace(&s, &wall, 1);
    for (i = 0; i < 3; ++i) shade(&s);
    for (slot = 0; slot < 3; ++slot) {
        float* bent = fixture_image(&s.c, slots[slot], 0, 4);
        for (i = 0; i < 97 * 71; ++i) {
            for (k = 0; k < 3; ++k) assert_true(fabsf(bent[4 * i + k] - 2.0f / 3.0f * rows[2][k]) < 1e-3f);
            assert_true(bent[4 * i + 3] == 1.0f);
        }
        free(bent);
    }
    stage_close(&s);
}

/* Beside the bodies of test_bodies, an average of so many frames against rays; bounds as there. The filter of one tap
   hands on what the temporal filter has, and sky is open to nowhere. */
static void test_bent_beside_a_body(void** state) {
    static const pane panes[] = {{{0.4, -3.0, -4.4}, {3.0, 0.0, 0.0}, {0.0, 6.0, 0.0}, 0.0},
                                 {{-50.0, -50.0, -5.0}, {100.0, 0.0, 0.0}, {0.0, 52.0, 0.0}, 0.0}};
    static const body thick = {&panes[0], 0.4};
    stage s = open_stage(193, 145, 1, DGB_EFFECT_AO | DGB_EFFECT_BENT | DGB_EFFECT_TEMPORAL, DGB_ESTIMATOR_BITMASK);
    float rows[3][3], *bent, *mean, *frames;
    double worst = 0.0, sum[3] = {0.0, 0.0, 0.0}, aside = 0.0;
    int x, i, k, frame, compared = 0;
    (void)state;
    turn_view(&s, rows);
    s.params.ao_radius = 1.5f;
    s.params.ao_samples = 96;
    s.params.thickness = 0.4f;
    s.params.filter_taps = 1;
    s.params.history_weight = 0.98f;
    trace(&s, panes, 2);
    for (frame = 0; frame < 64; ++frame) shade(&s);
    bent = fixture_image(&s.c, DGB_BENT, 0, 4);
    mean = fixture_image(&s.c, DGB_BENT_MEAN, 0, 4);
    frames = fixture_image(&s.c, DGB_FRAMES, 0, 4);
    for (i = 0; i < 4 * 193 * 145; ++i) assert_true(fabsf(bent[i] - mean[i]) <= 1e-3f);
    for (k = 0; k < 4; ++k) assert_true(bent[4 * (144 * 193 + 10) + k] == (k < 3 ? 0.0f : 1.0f));
    for (x = 50; x < 143; x += 4) {
        double point[3], truth[3];
        if (fabs((double)*images_at(&s.m, IMAGE_DEPTH, 0, x, 72) - (double)images_depth(5.0)) > 1e-6) continue;
        point_on(&s, &panes[1], x, 72, point);
        true_bent(point, &thick, 1.5, truth);
        for (i = 0; i < 3; ++i) {
            double value = 0.0;
            for (k = 0; k < 3; ++k) value += (double)rows[i][k] * (double)bent[4 * (72 * 193 + x) + k];
            worst = fmax(worst, fabs(value - truth[i]));
            sum[i] += value - truth[i];
        }
        aside = fmin(aside, truth[0]);
        /* the share is the visibility, but for what bytes and halves round */
        assert_true(fabsf(bent[4 * (72 * 193 + x) + 3] - frames[4 * (72 * 193 + x)]) < 3e-3f);
        ++compared;
    }
    print_message("bent: %d points, %.3f aside, error %.4f at most, %+.4f %+.4f %+.4f on average\n", compared, aside,
                  worst, sum[0] / compared, sum[1] / compared, sum[2] / compared);
    assert_true(compared >= 10 && aside < -0.1);
    assert_true(worst < 0.03);
    for (i = 0; i < 3; ++i) assert_true(fabs(sum[i] / compared) < 0.01);
    free(bent), free(mean), free(frames);
    stage_close(&s);
}

/* >> light */

static const pane ground = {{-50.0, -1.0, -0.5}, {100.0, 0.0, 0.0}, {0.0, 0.0, -5.5}, 0.0};
static const double up[3] = {0.0, 1.0, 0.0};

/* A glowing wall stands on black ground: what arrives is its form factor. The bounds: the wall's foot and borders are
   known to half a pixel, up to 3 cm where points are 0.5 m away, and what is seen of it stands for its step. */
static void test_glowing_wall(void** state) {
    const pane panes[] = {ground, {{-1.5, -1.0, -6.0}, {3.0, 0.0, 0.0}, {0.0, 2.5, 0.0}, 2.0}};
    stage s = open_stage(193, 145, 1, DGB_EFFECT_RADIOSITY | DGB_EFFECT_TEMPORAL, DGB_ESTIMATOR_BITMASK);
    double *light, worst = 0.0, sum = 0.0;
    int x, y, compared = 0;
    (void)state;
    s.params.radius = 5.0f;
    s.params.samples = 128;
    trace(&s, panes, 2);
    light = mean_of(&s, DGB_IRRADIANCE_RAW, 64);
    for (y = 28; y < 50; y += 3)
        for (x = 70; x < 124; x += 9) {
            double point[3], truth, error;
            point_on(&s, &ground, x, y, point);
            truth = 2.0 * PI * form_factor(point, up, &panes[1]);
            error = (light[y * 193 + x] - truth) / truth;
            worst = fmax(worst, fabs(error));
            sum += error;
            ++compared;
        }
    print_message("a glowing wall: %d points, relative error %.4f at most, %+.4f on average\n", compared, worst,
                  sum / compared);
    assert_true(worst < 0.08 && fabs(sum / compared) < 0.02);
    free(light);
    stage_close(&s);
}

/* A lamp behind a black wall, in the second layer, which the ground before the wall cannot see. */
static double light_of_hidden_lamp(dgb_estimator estimator) {
    const pane panes[] = {ground,
                          {{-4.0, -1.0, -5.0}, {8.0, 0.0, 0.0}, {0.0, 0.8, 0.0}, 0.0},
                          {{-1.0, -1.0, -5.8}, {2.0, 0.0, 0.0}, {0.0, 0.4, 0.0}, 10.0}};
    stage s = open_stage(193, 145, 2, DGB_EFFECT_RADIOSITY | DGB_EFFECT_TEMPORAL, estimator);
    double *light, sum = 0.0;
    int x, y, count = 0, lit = 0;
    s.params.radius = 3.0f;
    s.params.samples = 64;
    trace(&s, panes, 3);
    for (x = 0; x < 193 * 145; ++x) lit += *images_at(&s.m, IMAGE_RADIANCE, 1, x % 193, x / 193) > 0.0f;
    assert_true(lit > 50);
    light = mean_of(&s, DGB_IRRADIANCE_RAW, 16);
    for (y = 30; y < 45; ++y)
        for (x = 80; x < 113; ++x) sum += light[y * 193 + x], ++count;
    free(light);
    stage_close(&s);
    return sum / count;
}

static void test_hidden_lamp(void** state) {
    const double paper = light_of_hidden_lamp(DGB_ESTIMATOR_PAPER),
                 bitmask = light_of_hidden_lamp(DGB_ESTIMATOR_BITMASK);
    (void)state;
    print_message("a hidden lamp: %.5f by the paper's estimator, %.5f by the bitmask\n", paper, bitmask);
    assert_true(paper > 0.02);
    assert_true(bitmask < 0.02 * paper);
}

/* >> an off-centre projection */

/* Leaves of the whole only what the window shows, a camera of the same pixels. corner: the window's lower left one */
static void cut_window(stage* whole, stage* window, int corner) {
    const int from = whole->m.width, size = window->m.width; /* squares */
    int axis, kind, layer, x, y;
    for (axis = 0; axis < 2; ++axis) {
        window->view.projection[5 * axis] = whole->view.projection[5 * axis] * (float)from / (float)size;
        window->view.projection[8 + axis] = (float)(2 * corner + size - from) / (float)size;
    }
    for (layer = 0; layer < 2; ++layer)
        for (y = 0; y < from; ++y)
            for (x = 0; x < from; ++x) {
                const int to_x = x - corner, to_y = y - corner;
                const bool shown = to_x >= 0 && to_y >= 0 && to_x < size && to_y < size;
                for (kind = 0; kind < IMAGE_KINDS; ++kind) {
                    float* texel = images_at(&whole->m, (image_kind)kind, layer, x, y);
                    const size_t bytes = (kind == IMAGE_DEPTH ? 1 : 3) * sizeof *texel;
                    if (shown) memcpy(images_at(&window->m, (image_kind)kind, layer, to_x, to_y), texel, bytes);
                    if (!shown) memset(texel, 0, bytes);
                }
            }
}

/* Stored as halves, of sums of terms up to 1 in floats; where rounding decides about a sector, a texel is wrong. The
   outermost are left out: their first step may be longer than the way to the border, and lands beside it. */
static void compare_window(const stage* whole, const stage* window, int corner, dgb_slot slot, int channels) {
    const int from = whole->m.width, size = window->m.width;
    const double rounding = 5e-7;
    tally t = tally_of(dgb_slot_name(slot));
    float *wide = fixture_image(&whole->c, slot, 0, channels), *part = fixture_image(&window->c, slot, 0, channels);
    int x, y, k, lit = 0;
    for (y = 1; y < size - 1; ++y)
        for (x = 1; x < size - 1; ++x)
            for (k = 0; k < channels; ++k) {
                const double expected = (double)wide[channels * ((y + corner) * from + x + corner) + k];
                tally_half(&t, (double)part[channels * (y * size + x) + k], expected - rounding, expected + rounding);
                lit += expected > 0.0;
            }
    assert_true(lit > 1000);
    tally_report(&t);
    free(wide);
    free(part);
}

/* A window of a wider image with nothing around it, and the same seen by an off-centre camera that ends there: what lies
   beyond a border neither hides nor sends. A ground, walls behind and across the window's right border, a pane in the
   middle. The window's corner is a multiple of the noise's period, 64 pixels, and all reaches are below its diagonal,
   which limits them. */
static void test_off_centre(void** state) {
    enum { WHOLE = 256, SIZE = 64, CORNER = 64 };
    static const pane panes[] = {{{-50.0, -1.0, -0.5}, {100.0, 0.0, 0.0}, {0.0, 0.0, -5.5}, 0.5},
                                 {{-50.0, -1.0, -6.0}, {100.0, 0.0, 0.0}, {0.0, 50.0, 0.0}, 1.0},
                                 {{-0.3, -1.0, -5.0}, {0.6, 0.0, 0.6}, {0.0, 3.0, 0.0}, 4.0},
                                 {{-1.0, -0.8, -4.0}, {0.4, 0.0, 0.0}, {0.0, 0.6, 0.0}, 2.0}};
    const uint32_t effects = DGB_EFFECT_AO | DGB_EFFECT_BENT | DGB_EFFECT_RADIOSITY | DGB_EFFECT_BOUNCES;
    stage whole = open_stage(WHOLE, WHOLE, 2, effects, DGB_ESTIMATOR_BITMASK),
          window = open_stage(SIZE, SIZE, 2, effects, DGB_ESTIMATOR_BITMASK);
    int normal_test;
    (void)state;
    trace(&whole, panes, 4);
    cut_window(&whole, &window, CORNER);
    whole.params.radius = window.params.radius = 1.2f;
    for (normal_test = 0; normal_test < 2; ++normal_test) {
        whole.params.normal_test = window.params.normal_test = normal_test != 0;
        shade(&whole);
        shade(&window);
        compare_window(&whole, &window, CORNER, DGB_AO_RAW, 1);
        compare_window(&whole, &window, CORNER, DGB_BENT_RAW, 4);
        compare_window(&whole, &window, CORNER, DGB_IRRADIANCE_RAW, 4);
        compare_window(&whole, &window, CORNER, DGB_IRRADIANCE1_RAW, 4);
    }
    stage_close(&whole);
    stage_close(&window);
}

/* >> any image */

static void fill_at_random(stage* s, uint32_t seed) {
    int layer, x, y, k;
    for (layer = 0; layer < 2; ++layer)
        for (y = 0; y < s->m.height; ++y)
            for (x = 0; x < s->m.width; ++x) {
                const int hash = dgb_pixel_hash(x, y, (int)seed + layer), kind = hash % 16;
                const float n[3] = {kind == 1 ? NAN : (float)(hash % 7 - 3), (float)(hash % 5 - 2),
                                    kind == 2 ? INFINITY : (float)(hash % 11 - 3)};
                if (kind == 0 || (layer && kind < 8)) continue; /* nothing there */
                images_put(&s->m, layer, x, y, 2.0 + hash % 64 / 20.0 + layer, n);
                for (k = 0; k < 3; ++k)
                    images_at(&s->m, IMAGE_RADIANCE, layer, x, y)[k] = kind == 3 ? NAN : kind == 4 ? 4.0f : 1.0f;
            }
}

/* Whatever is there: visibility and confidence in 0..1, never more light than the brightest sender would send from
   everywhere, all finite, the same frame for frame without TEMPORAL, and the same with tiles that are left out. */
static void check_any(int width, int height, int layers, uint32_t effects, uint32_t seed) {
    const dgb_slot slots[] = {DGB_AO_RAW, DGB_IRRADIANCE_RAW, DGB_IRRADIANCE1_RAW};
    const bool averaged = (effects & DGB_EFFECT_TEMPORAL) != 0;
    stage s = open_stage(width, height, layers, effects, DGB_ESTIMATOR_BITMASK);
    float* first[3] = {NULL, NULL, NULL};
    int frame, i, k;
    fill_at_random(&s, seed);
    s.params.bounce_damping = 0.0f; /* nothing is brighter than what is emitted */
    s.params.slices = 1 + (int)(seed % 3u);
    s.params.thickness = seed % 2u ? 3.0f : 0.1f;
    for (frame = 0; frame < 2; ++frame) {
        s.params.adaptive = frame == 0 || averaged;
        shade(&s);
        for (k = 0; k < 3; ++k) {
            const int channels = k ? 4 : 1, count = width * height * channels;
            float* image;
            if (!dgb_get_texture(&s.c, slots[k]).id) continue;
            image = fixture_image(&s.c, slots[k], 0, channels);
            for (i = 0; i < count; ++i) {
                const double most = k && i % 4 < 3 ? 4.0 * PI * 1.001 : 1.0; /* an ulp of a half */
                assert_true((double)image[i] >= 0.0 && (double)image[i] <= most);
            }
            if (frame == 0) first[k] = image;
            if (frame == 1 && !averaged) assert_memory_equal(image, first[k], sizeof *image * (size_t)count);
            if (frame == 1) free(image);
        }
    }
    for (k = 0; k < 3; ++k) free(first[k]);
    stage_close(&s);
}

static void test_any_image(void** state) {
    static const int sizes[][2] = {{1, 1}, {2, 1}, {3, 5}, {37, 23}, {65, 130}};
    size_t i;
    uint32_t seed = 0;
    int layers;
    (void)state;
    for (i = 0; i < sizeof sizes / sizeof sizes[0]; ++i)
        for (layers = 1; layers <= 2; ++layers) {
            check_any(sizes[i][0], sizes[i][1], layers, DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY, seed++);
            check_any(sizes[i][0], sizes[i][1], layers,
                      DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY | DGB_EFFECT_BOUNCES | DGB_EFFECT_TEMPORAL, seed++);
        }
}

FIXTURE_CONTEXT(f, 4, 5, false)

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_open_is_the_normal),
        cmocka_unit_test(test_bent_beside_a_body),
        cmocka_unit_test(test_planes_are_open),
        cmocka_unit_test(test_bodies),
        cmocka_unit_test(test_nothing_reaches_beyond_the_radius),
        cmocka_unit_test(test_thickness),
        cmocka_unit_test(test_behind_the_first_layer),
        cmocka_unit_test(test_glowing_wall),
        cmocka_unit_test(test_back_of_a_lamp),
        cmocka_unit_test(test_hidden_lamp),
        cmocka_unit_test(test_off_centre),
        cmocka_unit_test(test_any_image),
        cmocka_unit_test(test_no_messages),
    };
    return cmocka_run_group_tests_name("bitmask", tests, open_context, close_context);
}
