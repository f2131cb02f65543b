/* Mirror reflections by either tracer against rays and planes in double precision. Layers made up texel by texel; every
   texel's radiance says where it lies, so that a reflection tells exactly what was hit. */
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

#define OTHERS (DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY | DGB_EFFECT_BOUNCES | DGB_EFFECT_TEMPORAL)

static fixture f;
static dgb_tracer tracer; /* of every context; all tests run with each */
static dgb_thickness thickness_from;

static const double radian = 3.14159265358979323846 / 180.0;

/* >> what a context makes of one frame */

typedef struct setup {
    int width, height, guard, layers; /* of the image, without guard band */
    uint32_t effects;
    float fov; /* 0: orthographic */
    bool reversed;
    dgb_clip clip;
} setup;

static const setup plain = {63, 41, 0, 2, DGB_EFFECT_REFLECT, 60.0f, true, DGB_CLIP_ZERO_TO_ONE};

static stage open_stage(const setup* p) {
    stage s;
    dgb_desc d;
    fixture_view v = fixture_default_view();
    v.fov = p->fov;
    v.reversed = p->reversed;
    v.clip = p->clip;
    v.near_plane = 0.1f;
    v.far_plane = p->fov > 0.0f && p->reversed ? 0.0f : 60.0f;
    stage_init(&s, p->width + 2 * p->guard, p->height + 2 * p->guard, p->guard);
    s.view = fixture_dgb_view(&v, p->width, p->height);
    s.params.reflect_stride = 1;
    s.params.reflect_border = 0.0f;
    s.params.reflect_steps = 4096;
    d = images_desc(&f, &s.m, p->guard, p->layers, p->effects);
    d.reversed = p->reversed;
    d.clip = p->clip;
    d.tracer = tracer;
    d.thickness = thickness_from;
    assert_int_equal(dgb_init(&s.c, &d), DGB_OK);
    return s;
}

typedef struct result { /* RGBA of the buffer; nothing in the guard band is written */
    float *reflection, *hit;
} result;

static result shade(stage* s) {
    result r;
    assert_int_equal(stage_shade(s), DGB_OK);
    r.reflection = fixture_image(&s->c, DGB_REFLECTION, 0, 4);
    r.hit = fixture_image(&s->c, DGB_REFLECTION_HIT, 0, 4);
    return r;
}

static void drop(result* r) { free(r->reflection), free(r->hit); }

/* >> cameras and planes, in double */

typedef struct plane {
    double n[3], d; /* n x = d */
} plane;

static double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static double clip_w(const stage* s, double z) { return s->view.projection[11] < 0.0f ? -z : 1.0; }

static void position_of(const stage* s, const double pixel[2], double z, double x[3]) {
    const double w = clip_w(s, z);
    x[0] = (2.0 * (pixel[0] - s->guard) / (s->m.width - 2 * s->guard) - 1.0) * w / (double)s->view.projection[0];
    x[1] = (2.0 * (pixel[1] - s->guard) / (s->m.height - 2 * s->guard) - 1.0) * w / (double)s->view.projection[5];
    x[2] = z;
}

static void pixel_of(const stage* s, const double x[3], double pixel[2]) {
    const double w = clip_w(s, x[2]);
    pixel[0] = s->guard + 0.5 * ((double)s->view.projection[0] * x[0] / w + 1.0) * (s->m.width - 2 * s->guard);
    pixel[1] = s->guard + 0.5 * ((double)s->view.projection[5] * x[1] / w + 1.0) * (s->m.height - 2 * s->guard);
}

static void direction_to(const stage* s, const double x[3], double direction[3]) {
    const double length = sqrt(dot(x, x));
    const bool perspective = s->view.projection[11] < 0.0f;
    int i;
    for (i = 0; i < 3; ++i) direction[i] = perspective ? x[i] / length : i == 2 ? -1.0 : 0.0;
}

/* z of a plane in a pixel; 1 where it is nearer to the eye than a centimetre, farther than 50 m, or turned away. */
static double plane_z(const stage* s, const plane* p, const double pixel[2]) {
    double a[3], b[3], u[3], t;
    int i;
    position_of(s, pixel, -1.0, a);
    position_of(s, pixel, -2.0, b);
    for (i = 0; i < 3; ++i) u[i] = b[i] - a[i]; /* a metre of z */
    t = (p->d - dot(p->n, a)) / dot(p->n, u);
    return dot(p->n, u) < 0.0 && t > -0.99 && t < 49.0 ? -1.0 - t : 1.0;
}

static void put(stage* s, int layer, int x, int y, double z, const double n[3]) {
    const float* m = s->view.projection;
    const double depth = ((double)m[10] * z + (double)m[14]) / clip_w(s, z);
    float* radiance = images_at(&s->m, IMAGE_RADIANCE, layer, x, y);
    int i;
    *images_at(&s->m, IMAGE_DEPTH, layer, x, y) =
        (float)(s->c.desc.clip == DGB_CLIP_ZERO_TO_ONE ? depth : 0.5 * depth + 0.5);
    for (i = 0; i < 3; ++i) images_at(&s->m, IMAGE_NORMAL, layer, x, y)[i] = (float)n[i];
    /* exact in 11 bits: integers below 128 */
    radiance[0] = (float)(x + 1), radiance[1] = (float)(y + 1), radiance[2] = (float)(layer + 1);
}

static void put_empty(stage* s, int layer, int x, int y) {
    *images_at(&s->m, IMAGE_DEPTH, layer, x, y) = s->c.desc.reversed ? 0.0f : 1.0f;
}

/* The nearest of some planes at a point of the image: its index, -1 for none. */
static int nearest(const stage* s, const plane* planes, int count, const double pixel[2]) {
    double best = -1e30;
    int i, found = -1;
    for (i = 0; i < count; ++i) {
        const double z = plane_z(s, &planes[i], pixel);
        if (z < 0.0 && z > best) best = z, found = i;
    }
    return found;
}

static int nearest_at(const stage* s, const plane* planes, int count, int x, int y) {
    const double centre[2] = {x + 0.5, y + 0.5};
    return nearest(s, planes, count, centre);
}

static void put_planes(stage* s, const plane* planes, int count) {
    int x, y;
    for (y = 0; y < s->m.height; ++y)
        for (x = 0; x < s->m.width; ++x) {
            const double centre[2] = {x + 0.5, y + 0.5};
            const int i = nearest(s, planes, count, centre);
            put_empty(s, 0, x, y), put_empty(s, 1, x, y);
            if (i >= 0) put(s, 0, x, y, plane_z(s, &planes[i], centre), planes[i].n);
        }
}

/* A plane through (0, 0, z) whose normal leans from the camera's y towards its z, then towards its x. */
static plane plane_of(double z, double lean, double aside) {
    plane p;
    p.n[0] = sin(aside * radian);
    p.n[1] = cos(aside * radian) * cos(lean * radian);
    p.n[2] = cos(aside * radian) * sin(lean * radian);
    p.d = p.n[2] * z;
    return p;
}

/* Where the mirror in a pixel of a plane shows another plane. */
typedef struct mirrored {
    double x[3], there[3], pixel[2]; /* of the mirror; of what it shows */
    double t, grazing;               /* length of the way, < 0: never; its cosine with the mirror's normal */
} mirrored;

static mirrored mirror(const stage* s, int x, int y, const plane* own, const plane* other) {
    const double centre[2] = {x + 0.5, y + 0.5};
    float given[3], n[3];
    double view[3], r[3], normal[3];
    mirrored m;
    int i;
    for (i = 0; i < 3; ++i) given[i] = (float)own->n[i];
    dgb_oct16_decode(dgb_oct16_encode(given), n); /* it has no better one */
    position_of(s, centre, plane_z(s, own, centre), m.x);
    direction_to(s, m.x, view);
    for (i = 0; i < 3; ++i) normal[i] = (double)n[i];
    for (i = 0; i < 3; ++i) r[i] = view[i] - 2.0 * dot(view, normal) * normal[i];
    m.grazing = dot(r, normal);
    m.t = dot(r, other->n) < 0.0 ? (other->d - dot(other->n, m.x)) / dot(r, other->n) : -1.0;
    for (i = 0; i < 3; ++i) m.there[i] = m.x[i] + m.t * r[i];
    m.pixel[0] = m.pixel[1] = -1.0;
    if (m.there[2] > -0.1) m.t = -1.0; /* nearer than the near plane */
    if (m.t > 0.0) pixel_of(s, m.there, m.pixel);
    return m;
}

/* >> results */

static bool is_miss(const result* r, int at) {
    int k;
    for (k = 0; k < 4; ++k)
        if (r->reflection[4 * at + k] != 0.0f) return false;
    return r->hit[4 * at] == 0.0f && r->hit[4 * at + 1] == 0.0f;
}

/* A hit knows its texel: within `bound` pixels of the point, on the layer, as long as the way to the texel's own
   point. */
static bool is_hit(const stage* s, const result* r, int at, const mirrored* m, int layer, const plane* other,
                   double bound) {
    const float *light = r->reflection + 4 * at, *hit = r->hit + 4 * at;
    const double texel[2] = {(double)light[0] - 0.5, (double)light[1] - 0.5};
    double there[3], v[3], length;
    int i;
    if (!(light[3] > 0.0f && light[3] <= 1.0f) || hit[0] != (float)(layer + 1) || light[2] != (float)(layer + 1))
        return false;
    if (!(fabs(texel[0] - m->pixel[0]) <= bound && fabs(texel[1] - m->pixel[1]) <= bound)) return false;
    position_of(s, texel, plane_z(s, other, texel), there);
    for (i = 0; i < 3; ++i) v[i] = there[i] - m->x[i];
    length = sqrt(dot(v, v));
    return fabs((double)hit[1] - length) <= length / 1024.0 + 1e-3; /* a half, and what depth lost */
}

static int count_hits(const stage* s, const result* r) {
    int x, y, count = 0;
    for (y = s->guard; y < s->m.height - s->guard; ++y)
        for (x = s->guard; x < s->m.width - s->guard; ++x) count += !is_miss(r, y * s->m.width + x);
    return count;
}

static void check_range(const stage* s, const result* r) {
    int x, y, k;
    for (y = s->guard; y < s->m.height - s->guard; ++y)
        for (x = s->guard; x < s->m.width - s->guard; ++x) {
            const float *light = r->reflection + 4 * (y * s->m.width + x), *hit = r->hit + 4 * (y * s->m.width + x);
            for (k = 0; k < 3; ++k) assert_true(light[k] >= 0.0f && light[k] <= DGB_MAX_RADIANCE); /* and no NaN */
            assert_true(light[3] >= 0.0f && light[3] <= 1.0f);
            assert_true(hit[0] == 0.0f || hit[0] == 1.0f || hit[0] == 2.0f);
            assert_true(hit[1] >= 0.0f && hit[1] <= DGB_MAX_RADIANCE);
            assert_true((hit[0] > 0.0f) == (light[3] > 0.0f));
        }
}

/* >> a floor that mirrors a wall */

/* Surfaces are flat within a texel, so a ray meets one up to half a texel and a step beside where it meets the plane:
   1.5 pixels. Where the plane is met so near the border, the edge or the limit of the angle, either verdict is
   right. */
static const double footprint = 1.5;

static bool is_seen(const stage* s, const plane* planes, const double pixel[2], double dx, double dy) {
    const double p[2] = {pixel[0] + dx, pixel[1] + dy};
    return p[0] > 0.0 && p[1] > 0.0 && p[0] < s->m.width && p[1] < s->m.height && nearest(s, planes, 2, p) == 1;
}

/* In how many of the four corners of its footprint the wall is in view. */
static int seen_corners(const stage* s, const plane* planes, const double pixel[2]) {
    return is_seen(s, planes, pixel, -footprint, -footprint) + is_seen(s, planes, pixel, footprint, -footprint) +
           is_seen(s, planes, pixel, -footprint, footprint) + is_seen(s, planes, pixel, footprint, footprint);
}

/* How many misses there are. */
static int check_mirror(const setup* p, plane floor, plane wall) {
    const plane planes[2] = {floor, wall};
    stage s = open_stage(p);
    int x, y, hits = 0, wrong = 0, misses = 0, doubtful = 0;
    result r;
    put_planes(&s, planes, 2);
    s.params.reflect_distance = 100.0f;
    r = shade(&s);
    for (y = p->guard; y < p->guard + p->height; ++y)
        for (x = p->guard; x < p->guard + p->width; ++x) {
            const int at = y * s.m.width + x;
            mirrored m;
            int corners;
            bool grazes;
            if (nearest_at(&s, planes, 2, x, y) != 0) continue;
            m = mirror(&s, x, y, &floor, &wall);
            corners = m.t > 0.0 && m.t < 99.0 ? seen_corners(&s, planes, m.pixel) : 0;
            grazes = fabs(m.grazing - (double)DGB_MIN_COSINE) < 0.003;
            if (corners == 4 && m.grazing > (double)DGB_MIN_COSINE && !grazes) {
                ++hits;
                wrong += !is_hit(&s, &r, at, &m, 0, &wall, footprint);
            } else if ((corners == 0 || m.grazing < (double)DGB_MIN_COSINE) && !grazes) {
                ++misses;
                assert_true(is_miss(&r, at));
            } else {
                ++doubtful;
            }
        }
    check_range(&s, &r);
    printf("# %dx%d + %d, fov %g: %d of %d hits agree, %d misses, %d either\n", p->width, p->height, p->guard,
           (double)p->fov, hits - wrong, hits, misses, doubtful);
    assert_true(hits > 100);
    assert_true(100 * wrong <= hits);
    assert_true(5 * doubtful <= hits + misses);
    drop(&r);
    stage_close(&s);
    return misses;
}

static void test_mirror(void** state) {
    static const setup guarded = {64, 48, 8, 2, DGB_EFFECT_REFLECT, 60.0f, false, DGB_CLIP_NEGATIVE_ONE_TO_ONE};
    static const setup flat = {97, 53, 0, 2, DGB_EFFECT_REFLECT, 0.0f, true, DGB_CLIP_ZERO_TO_ONE};
    static const setup flat_guarded = {71, 64, 5, 1, DGB_EFFECT_REFLECT, 0.0f, false, DGB_CLIP_NEGATIVE_ONE_TO_ONE};
    plane floor = plane_of(0.0, 0.0, 0.0), wall = plane_of(-10.0, 90.0, 0.0);
    int misses = 0;
    (void)state;
    floor.d = -1.5;
    misses += check_mirror(&plain, floor, wall);
    misses += check_mirror(&guarded, floor, wall);
    floor.d = -0.4; /* grazing */
    misses += check_mirror(&plain, floor, wall);
    floor.d = -1.5;
    wall = plane_of(-10.0, 80.0, 35.0);
    misses += check_mirror(&plain, floor, wall);
    floor = plane_of(-10.3, 90.0, -40.0),
    wall = plane_of(-10.0, 90.0, 45.0); /* a corner: rays come back towards the eye */
    misses += check_mirror(&plain, floor, wall);
    misses += check_mirror(&guarded, floor, wall);
    wall = plane_of(-10.0, 80.0, 35.0);
    floor = plane_of(-5.0, 20.0, 7.0); /* a normal that no 16 bits hold */
    misses += check_mirror(&plain, floor, wall);
    misses += check_mirror(&guarded, floor, wall);
    floor = plane_of(-20.0, 4.0, 8.0),
    wall = plane_of(-12.0, 90.0, 0.0); /* the same, grazing: the error of the normal is a good part of the angle */
    misses += check_mirror(&guarded, floor, wall);
    floor = plane_of(-12.0, 30.0, 0.0), wall = plane_of(-15.0, 80.0, 10.0);
    misses += check_mirror(&flat, floor, wall);
    misses += check_mirror(&flat_guarded, floor, wall);
    assert_true(misses > 200);
}

/* A mirror that leans by 45 degrees sends what an orthographic camera sees along the image, but for a degree that the
   normal cannot tell, towards the eye or away. */
static void test_parallel_to_the_image(void** state) {
    static const setup flat = {97, 53, 0, 2, DGB_EFFECT_REFLECT, 0.0f, true, DGB_CLIP_ZERO_TO_ONE};
    const plane wall = plane_of(-15.0, 135.0, 0.0);
    (void)state;
    check_mirror(&flat, plane_of(-12.0, 44.5, 0.0), wall);
    check_mirror(&flat, plane_of(-12.0, 45.5, 0.0), wall);
}

/* A floor 2 cm below the eye: a good part of it is nearer than the near plane. */
static void test_before_the_near_plane(void** state) {
    plane floor = plane_of(0.0, 0.0, 0.0);
    const double centre[2] = {31.5, 3.5};
    stage s = open_stage(&plain);
    (void)state;
    floor.d = -0.02;
    assert_true(plane_z(&s, &floor, centre) > -0.05); /* the near plane is at -0.1 */
    stage_close(&s);
    check_mirror(&plain, floor, plane_of(-10.0, 90.0, 0.0));
}

/* The two sides of a ridge, each of which sends its rays away from the other; at the border they leave the image at
   once. */
static void test_out_of_the_image(void** state) {
    const plane sides[2] = {plane_of(-10.0, 90.0, 40.0), plane_of(-10.0, 90.0, -40.0)};
    int guard, x, y;
    (void)state;
    for (guard = 0; guard <= 6; guard += 6) {
        setup p = plain;
        stage s;
        result r;
        p.guard = guard;
        s = open_stage(&p);
        for (y = 0; y < s.m.height; ++y)
            for (x = 0; x < s.m.width; ++x) {
                const double centre[2] = {x + 0.5, y + 0.5};
                const plane* side = &sides[2 * x < s.m.width];
                put_empty(&s, 1, x, y);
                put(&s, 0, x, y, plane_z(&s, side, centre), side->n);
            }
        s.params.reflect_thickness = 100.0f;
        r = shade(&s);
        assert_int_equal(count_hits(&s, &r), 0);
        drop(&r);
        stage_close(&s);
    }
}

/* Nothing is beside a plane to be mirrored by it. */
static void test_no_self_hits(void** state) {
    int tilt, stride, layers;
    (void)state;
    for (layers = 1; layers <= 2; ++layers) {
        setup p = plain, flat = plain;
        stage of[2];
        p.layers = flat.layers = layers;
        flat.fov = 0.0f;
        of[0] = open_stage(&p), of[1] = open_stage(&flat);
        for (tilt = 1; tilt <= 90; ++tilt)
            for (stride = 1; stride <= 3; stride += 2) {
                stage* s = &of[tilt % 3 == 0];
                const plane floor = plane_of(-7.0, (double)tilt, (double)(tilt * 37 % 80 - 40));
                result r;
                put_planes(s, &floor, 1);
                s->params.reflect_stride = stride;
                s->params.reflect_thickness = tilt % 2 ? 0.5f : 100.0f;
                r = shade(s);
                if (count_hits(s, &r)) print_error("tilt %d, stride %d: %d hits\n", tilt, stride, count_hits(s, &r));
                assert_int_equal(count_hits(s, &r), 0);
                drop(&r);
            }
        stage_close(&of[0]), stage_close(&of[1]);
    }
}

/* >> what hides behind an object */

enum { LEFT = 22, RIGHT = 42, LOW = 16, HIGH = 36 }; /* texels of the object, above where the floor ends */

static bool is_object(double x, double y, double inset) {
    return x > LEFT + inset && x < RIGHT - inset && y > LOW + inset && y < HIGH - inset;
}

/* The floor and the wall, and a sheet that hangs before them; behind it, on the second layer, what it hides. */
static void put_sheet(stage* s, const plane planes[2], const plane* sheet, const plane* hidden) {
    int x, y;
    put_planes(s, planes, 2);
    for (y = LOW; y < HIGH; ++y)
        for (x = LEFT; x < RIGHT; ++x) {
            const double centre[2] = {x + 0.5, y + 0.5};
            put(s, 0, x, y, plane_z(s, sheet, centre), sheet->n);
            if (hidden) put(s, 1, x, y, plane_z(s, hidden, centre), hidden->n);
        }
}

/* Floor and wall meet at row 16.2 of 41. */
static void floor_and_wall(plane planes[2]) {
    planes[0] = plane_of(0.0, 0.0, 0.0), planes[1] = plane_of(-10.0, 90.0, 0.0);
    planes[0].d = -1.2;
}

static void check_hidden(int layers) {
    const plane sheet = plane_of(-4.0, 90.0, 0.0);
    plane planes[2];
    setup p = plain;
    stage s;
    int x, y, hidden = 0, found = 0, open = 0, right = 0, on_sheet = 0;
    result r;
    p.layers = layers;
    s = open_stage(&p);
    floor_and_wall(planes);
    put_sheet(&s, planes, &sheet, &planes[1]);
    r = shade(&s);
    check_range(&s, &r);
    for (y = 0; y < LOW; ++y)
        for (x = 0; x < p.width; ++x) {
            const int at = y * p.width + x;
            mirrored m;
            if (nearest_at(&s, planes, 2, x, y) != 0) continue;
            m = mirror(&s, x, y, &planes[0], &planes[1]);
            if (m.t < 0.0 || m.t > 29.0 || m.x[2] > -4.6 || m.grazing < 0.02)
                continue; /* behind the sheet from the start */
            if (seen_corners(&s, planes, m.pixel) < 4) continue;
            on_sheet +=
                r.hit[4 * at] == 1.0f && is_object((double)r.reflection[4 * at], (double)r.reflection[4 * at + 1], 0.0);
            if (is_object(m.pixel[0], m.pixel[1], footprint)) {
                ++hidden;
                found += is_hit(&s, &r, at, &m, 1, &planes[1], footprint);
            } else if (!is_object(m.pixel[0], m.pixel[1], -footprint)) {
                ++open;
                right += is_hit(&s, &r, at, &m, 0, &planes[1], footprint);
            }
        }
    printf("# %d layers: %d of %d hidden and %d of %d open points found\n", layers, found, hidden, right, open);
    assert_true(hidden > 30 && open > 30);
    assert_int_equal(on_sheet, 0);
    assert_true(layers > 1 ? found == hidden : found == 0);
    assert_int_equal(right, open);
    drop(&r);
    stage_close(&s);
}

static void test_second_layer(void** state) {
    (void)state;
    check_hidden(2);
    check_hidden(1);
}

/* How many pixels of the floor from z = low to high show a layer of the sheet, or miss. */
static void count_sheet(stage* s, const plane planes[2], double low, double high, int counts[3]) {
    result r = shade(s);
    int x, y;
    check_range(s, &r);
    counts[0] = counts[1] = counts[2] = 0;
    for (y = 0; y < LOW; ++y)
        for (x = LEFT + 4; x < RIGHT - 4; ++x) {
            const int at = y * s->m.width + x;
            const double centre[2] = {x + 0.5, y + 0.5}, z = plane_z(s, &planes[0], centre);
            const bool shown = is_object((double)r.reflection[4 * at], (double)r.reflection[4 * at + 1], 0.0);
            if (nearest_at(s, planes, 2, x, y) != 0 || z < low || z > high) continue;
            ++counts[shown ? (int)r.hit[4 * at] : 0];
        }
    drop(&r);
}

/* Whoever passes behind the sheet by more than its thickness does not meet it, and the first layer ends where the
   second begins at the latest. */
static void test_thickness(void** state) {
    const plane sheet = plane_of(-4.0, 90.0, 0.0), behind = plane_of(-4.25, 90.0, 0.0);
    setup p = plain;
    plane planes[2];
    int layers, counts[3];
    (void)state;
    floor_and_wall(planes);
    for (layers = 1; layers <= 2; ++layers) {
        stage s;
        p.layers = layers;
        s = open_stage(&p);
        s.params.separation = 0.1f;
        put_sheet(&s, planes, &sheet, NULL);
        count_sheet(&s, planes, -9.9, -4.6, counts); /* deeper than half a metre */
        assert_int_equal(counts[1] + counts[2], 0);
        s.params.reflect_thickness = 3.0f; /* it comes to lie 1.7 to 2.5 m behind the lower edge */
        count_sheet(&s, planes, -4.9, -4.05, counts);
        printf("# %d layers, thick: %d, %d behind, %d none\n", layers, counts[1], counts[2], counts[0]);
        assert_true(counts[1] > 20 && counts[2] == 0);
        put_sheet(&s, planes, &sheet, &behind);
        count_sheet(&s, planes, -4.9, -4.05, counts);
        if (layers > 1) assert_true(counts[1] == 0 && counts[2] > 20);
        if (layers < 2) assert_true(counts[1] > 20 && counts[2] == 0);
        stage_close(&s);
    }
}

/* Depth of back faces behind the sheet, camera z; 0: none. */
static void put_back(stage* s, double z) {
    const float* p = s->view.projection;
    int x, y;
    for (y = LOW; y < HIGH; ++y)
        for (x = LEFT; x < RIGHT; ++x)
            s->m.back[y * s->m.width + x] = z < 0.0 ? (float)((double)p[14] / -z - (double)p[10]) : 0.0f; /* 0 to 1 */
}

/* What is told about back faces ends the sheet, by either layer count: rays pass behind a plate, and meet a block. */
static void test_back_faces(void** state) {
    const plane sheet = plane_of(-4.0, 90.0, 0.0);
    static const struct {
        double back;
        bool met; /* 1.7 to 2.5 m behind the lower edge */
    } cases[] = {{0.0, true}, {-4.1, false}, {-5.0, false}, {-6.9, true}, {-9.0, true}, {-3.9, true}, {-4.0, true}};
    setup p = plain;
    plane planes[2];
    int layers, counts[3];
    size_t i;
    (void)state;
    thickness_from = DGB_THICKNESS_BACK_FACES;
    floor_and_wall(planes);
    for (layers = 1; layers <= 2; ++layers) {
        stage s;
        p.layers = layers;
        s = open_stage(&p);
        s.params.separation = 0.1f;
        s.params.reflect_thickness = 3.0f;
        put_sheet(&s, planes, &sheet, NULL);
        for (i = 0; i < sizeof cases / sizeof cases[0]; ++i) { /* the last two are no back faces behind the sheet */
            put_back(&s, cases[i].back);
            count_sheet(&s, planes, -4.9, -4.05, counts);
            assert_true(cases[i].met ? counts[1] > 20 : counts[1] == 0);
            assert_int_equal(counts[2], 0);
        }
        stage_close(&s);
    }
    thickness_from = DGB_THICKNESS_LAYERS;
}

/* >> limits of a ray */

/* The mirror of `test_mirror` under other limits: of every hit, the texel is near enough, and beyond it all miss. */
static void check_limit(int steps, float distance) {
    plane planes[2];
    stage s = open_stage(&plain);
    int x, y, k, near = 0, far = 0;
    result r;
    floor_and_wall(planes);
    put_planes(&s, planes, 2);
    s.params.reflect_steps = steps;
    s.params.reflect_distance = distance;
    r = shade(&s);
    for (y = 0; y < plain.height; ++y)
        for (x = 0; x < plain.width; ++x) {
            const int at = y * plain.width + x;
            double reach = 0.0;
            mirrored m;
            if (nearest_at(&s, planes, 2, x, y) != 0) continue;
            m = mirror(&s, x, y, &planes[0], &planes[1]);
            if (m.t < 0.0 || m.grazing < 0.02 || seen_corners(&s, planes, m.pixel) < 4) continue;
            for (k = 0; k < 2; ++k) reach = fmax(reach, fabs(m.pixel[k] - (k ? y : x) - 0.5));
            if (reach > steps + footprint || m.t > (double)distance) {
                ++far;
                assert_true(is_miss(&r, at));
            } else if (reach < steps - footprint - 1.0 && m.t < (double)distance - 0.5) {
                ++near;
                assert_true(is_hit(&s, &r, at, &m, 0, &planes[1], footprint));
            }
        }
    assert_true(near > 20 && far > 20);
    drop(&r);
    stage_close(&s);
}

static void test_limits(void** state) {
    (void)state;
    check_limit(9, 100.0f);
    check_limit(4096, 6.0f);
}

/* Long steps find the same as short ones, within the step. */
static void test_strides(void** state) {
    static const int strides[] = {2, 4, 16};
    plane planes[2];
    stage s = open_stage(&plain);
    size_t i;
    (void)state;
    floor_and_wall(planes);
    put_planes(&s, planes, 2);
    for (i = 0; i < sizeof strides / sizeof strides[0]; ++i) {
        int x, y, hits = 0, right = 0;
        result r;
        s.params.reflect_stride = strides[i];
        r = shade(&s);
        for (y = 0; y < plain.height; ++y)
            for (x = 0; x < plain.width; ++x) {
                mirrored m;
                if (nearest_at(&s, planes, 2, x, y) != 0) continue;
                m = mirror(&s, x, y, &planes[0], &planes[1]);
                if (m.t < 0.0 || m.t > 29.0 || m.grazing < 0.02 || seen_corners(&s, planes, m.pixel) < 4) continue;
                ++hits;
                /* halved four times */
                right += is_hit(&s, &r, y * plain.width + x, &m, 0, &planes[1], 0.5 + strides[i] / 16.0 + 0.01);
            }
        printf("# stride %d: %d of %d\n", strides[i], right, hits);
        assert_true(100 * right >= 99 * hits && hits > 200);
        drop(&r);
    }
    stage_close(&s);
}

/* >> confidence */

static void test_border(void** state) {
    plane planes[2];
    stage s = open_stage(&plain);
    result sharp, soft;
    int at, faded = 0;
    (void)state;
    floor_and_wall(planes);
    put_planes(&s, planes, 2);
    sharp = shade(&s);
    s.params.reflect_border = 8.0f;
    soft = shade(&s);
    for (at = 0; at < plain.width * plain.height; ++at) {
        const float *a = sharp.reflection + 4 * at, *b = soft.reflection + 4 * at;
        const double x = (double)a[0] - 0.5, y = (double)a[1] - 0.5;
        const double margin = fmin(fmin(x, y), fmin(plain.width - x, plain.height - y));
        if (is_miss(&sharp, at)) {
            assert_true(is_miss(&soft, at));
            continue;
        }
        assert_memory_equal(a, b, 3 * sizeof(float));
        assert_true(fabs((double)b[3] - (double)a[3] * fmin(margin / 8.0, 1.0)) <= 1e-3);
        faded += margin < 8.0;
    }
    assert_true(faded > 50);
    drop(&sharp), drop(&soft);
    stage_close(&s);
}

/* A ray that comes to a wall from before it is sure of what it meets, but where it grazes the wall. */
static int check_confidence(plane wall) {
    plane planes[2];
    stage s = open_stage(&plain);
    float given[3], n[3];
    result r;
    int x, y, i, oblique = 0;
    floor_and_wall(planes);
    planes[1] = wall;
    for (i = 0; i < 3; ++i) given[i] = (float)wall.n[i];
    dgb_oct16_decode(dgb_oct16_encode(given), n);
    put_planes(&s, planes, 2);
    s.params.reflect_thickness = 0.05f; /* much less than a pixel's way */
    r = shade(&s);
    for (y = 0; y < plain.height; ++y)
        for (x = 0; x < plain.width; ++x) {
            double facing = 0.0;
            mirrored m;
            if (nearest_at(&s, planes, 2, x, y) != 0) continue;
            m = mirror(&s, x, y, &planes[0], &wall);
            if (m.t < 0.0 || m.t > 29.0 || m.grazing < 0.02 || seen_corners(&s, planes, m.pixel) < 4) continue;
            for (i = 0; i < 3; ++i) facing -= 4.0 * (double)n[i] * (m.there[i] - m.x[i]) / m.t;
            oblique += facing < 1.0;
            facing = fmax(fmin(facing, 1.0), 0.0);
            assert_true(fabs((double)r.reflection[4 * (y * plain.width + x) + 3] - facing) < 1e-3);
        }
    drop(&r);
    stage_close(&s);
    return oblique;
}

static void test_confidence(void** state) {
    (void)state;
    assert_int_equal(check_confidence(plane_of(-10.0, 90.0, 0.0)), 0);
    assert_true(check_confidence(plane_of(-20.0, 90.0, 78.0)) > 20);
}

/* >> with other effects */

static void test_with_other_effects(void** state) {
    plane planes[2];
    setup all = plain, one = plain;
    stage a = open_stage(&plain), b, c;
    result ra, rb, rc;
    const size_t bytes = (size_t)(4 * plain.width * plain.height) * sizeof(float);
    (void)state;
    all.effects |= OTHERS;
    one.layers = 1;
    b = open_stage(&all), c = open_stage(&one);
    floor_and_wall(planes);
    put_planes(&a, planes, 2), put_planes(&b, planes, 2), put_planes(&c, planes, 2);
    ra = shade(&a), rb = shade(&b), rc = shade(&c);
    assert_true(count_hits(&a, &ra) > 200);
    assert_memory_equal(ra.reflection, rb.reflection, bytes); /* no light has bounced yet */
    assert_memory_equal(ra.hit, rb.hit, bytes);
    assert_memory_equal(ra.reflection, rc.reflection, bytes); /* an empty layer changes nothing */
    assert_memory_equal(ra.hit, rc.hit, bytes);
    assert_int_equal(dgb_get_texture(&a.c, DGB_ROTATIONS).id, 0); /* nor is there a spiral to turn */
    drop(&ra), drop(&rb), drop(&rc);
    stage_close(&a), stage_close(&b), stage_close(&c);
}

/* A mirror shows what the wall sends on of last frame's light. */
static void test_bounced_light(void** state) {
    static const float white[3] = {1.0f, 1.0f, 1.0f}, black[3] = {0.0f, 0.0f, 0.0f};
    const int count = plain.width * plain.height;
    plane planes[2];
    setup p = plain;
    stage s;
    float *light, *b0;
    result r;
    int i, hits = 0;
    (void)state;
    p.effects |= OTHERS;
    s = open_stage(&p);
    floor_and_wall(planes);
    put_planes(&s, planes, 2);
    images_fill(&s.m, IMAGE_RADIANCE, black), images_fill(&s.m, IMAGE_ALBEDO, white);
    r = shade(&s);
    for (i = 0; i < count; ++i) hits += r.reflection[4 * i + 3] > 0.0f, assert_true(r.reflection[4 * i] == 0.0f);
    assert_true(hits > 200);
    drop(&r);
    light = (float*)malloc((size_t)(4 * count) * sizeof *light);
    for (i = 0; i < 4 * count; ++i) light[i] = 1.0f;
    fixture_put_image(&s.c, DGB_IRRADIANCE, 4, light);
    r = shade(&s);
    b0 = fixture_image(&s.c, DGB_B0, 0, 3);
    for (i = 0, hits = 0; i < count; ++i)
        if (r.reflection[4 * i + 3] > 0.0f) {
            ++hits;
            assert_true(r.reflection[4 * i] > 0.1f && r.reflection[4 * i] == b0[3 * (count - p.width / 2)]);
        }
    assert_true(hits > 200);
    free(light), free(b0);
    drop(&r);
    stage_close(&s);
}

/* Of a result, RGBA, what a texel of one of the layers adds to a mirror: albedo/pi * confidence * E. */
static double indirect(const float* irradiance, const float albedo[3], int k) {
    const double pi = 3.14159265358979323846;
    return (double)albedo[k] / pi * (double)irradiance[k] * (double)irradiance[3];
}

/* Floor, wall, sheet, and the wall again behind the sheet. Radiance says which texel a mirror shows, so the reflection
   without light tells where it looks, and what the light adds is known from that texel's irradiance. */
static void check_indirect(int layers, int guard, float guard_fraction) {
    static const float albedo[2][3] = {{0.9f, 0.5f, 0.0f}, {0.25f, 1.0f, 0.75f}};
    const plane sheet = plane_of(-4.0, 90.0, 0.0);
    plane planes[2];
    setup p = plain, lit = plain;
    stage a, b;
    result ra, rb;
    float* light[2] = {NULL, NULL};
    int at, i, l, k, seen[2] = {0, 0}, dark = 0;
    p.layers = lit.layers = layers;
    p.guard = lit.guard = guard, p.width = lit.width = plain.width - 2 * guard;
    p.height = lit.height = plain.height - 2 * guard;
    lit.effects |= DGB_EFFECT_RADIOSITY;
    a = open_stage(&p), b = open_stage(&lit);
    b.params.guard_fraction = 1.0f;
    b.params.radius = 20.0f;
    floor_and_wall(planes);
    put_sheet(&a, planes, &sheet, &planes[1]), put_sheet(&b, planes, &sheet, &planes[1]);
    for (l = 0; l < 2; ++l)
        for (i = 0; i < 3 * b.m.width * b.m.height; ++i) b.m.texels[IMAGE_ALBEDO][l][i] = albedo[l][i % 3];
    rb = shade(&b);
    drop(&rb); /* leaves light all over the guard band */
    b.params.guard_fraction = guard_fraction;
    ra = shade(&a), rb = shade(&b);
    for (l = 0; l < layers; ++l) light[l] = fixture_image(&b.c, l ? DGB_IRRADIANCE1 : DGB_IRRADIANCE, 0, 4);
    for (at = 0; at < b.m.width * b.m.height; ++at) {
        const float *before = ra.reflection + 4 * at, *after = rb.reflection + 4 * at;
        const int inset = guard - (int)((float)guard * guard_fraction + 0.5f);
        int x, y;
        bool shaded;
        if (at % b.m.width < guard || at % b.m.width >= b.m.width - guard || at / b.m.width < guard ||
            at / b.m.width >= b.m.height - guard)
            continue; /* nothing is written there */
        assert_memory_equal(ra.hit + 4 * at, rb.hit + 4 * at, 4 * sizeof(float));
        assert_true(before[3] == after[3]);
        if (is_miss(&ra, at)) continue;
        x = (int)before[0] - 1, y = (int)before[1] - 1, l = (int)before[2] - 1;
        shaded = x >= inset && x < b.m.width - inset && y >= inset && y < b.m.height - inset;
        ++seen[l];
        for (k = 0; k < 3; ++k) {
            const double e = shaded ? indirect(light[l] + 4 * (y * b.m.width + x), albedo[l], k) : 0.0;
            dark += e == 0.0 && k < 2; /* the first layer's blue is black */
            /* a half in the reflection, which a device may truncate */
            assert_true(fabs((double)after[k] - (double)before[k] - e) <= ((double)before[k] + e) / 1024.0);
        }
    }
    printf("# %d layers: %d and %d mirrored, dark %d\n", layers, seen[0], seen[1], dark);
    assert_true(seen[0] > 100 && (layers > 1 ? seen[1] > 30 : seen[1] == 0));
    assert_true(guard_fraction < 1.0f ? dark > 5 : dark < seen[0] / 20);
    free(light[0]), free(light[1]);
    drop(&ra), drop(&rb);
    stage_close(&a), stage_close(&b);
}

static void test_indirect_light(void** state) {
    (void)state;
    check_indirect(1, 0, 1.0f);
    check_indirect(2, 0, 1.0f);
    check_indirect(2, 8, 0.0f); /* what the guard band shows there has no irradiance */
}

/* >> what an engine may hand over */

static void check_no_hits(const setup* p, const plane* planes, int count, float normal_sign, float depth_factor) {
    stage s = open_stage(p);
    result r;
    int i;
    put_planes(&s, planes, count);
    for (i = 0; i < 3 * s.m.width * s.m.height; ++i) s.m.texels[IMAGE_NORMAL][0][i] *= normal_sign;
    for (i = 0; i < s.m.width * s.m.height; ++i) s.m.texels[IMAGE_DEPTH][0][i] *= depth_factor;
    r = shade(&s);
    check_range(&s, &r);
    assert_int_equal(count_hits(&s, &r), 0);
    drop(&r);
    stage_close(&s);
}

/* The back of a wall is nothing that anyone knows. */
static void check_turned_wall(const plane planes[2]) {
    stage s = open_stage(&plain);
    result r;
    int i;
    put_planes(&s, planes, 2);
    for (i = 0; i < plain.width * plain.height; ++i) {
        float* n = s.m.texels[IMAGE_NORMAL][0] + 3 * i;
        n[2] = -n[2]; /* the floor has none */
    }
    r = shade(&s);
    assert_int_equal(count_hits(&s, &r), 0);
    drop(&r);
    stage_close(&s);
}

static void test_no_mirror(void** state) {
    static const int sides[][2] = {{1, 1}, {1, 64}, {37, 1}, {2, 3}, {5, 5}};
    plane planes[2];
    size_t i;
    (void)state;
    floor_and_wall(planes);
    check_no_hits(&plain, planes, 0, 1.0f, 1.0f);  /* sky alone */
    check_no_hits(&plain, planes, 2, -1.0f, 1.0f); /* all faces away */
    check_turned_wall(planes);
    check_no_hits(&plain, planes + 1, 1, 1.0f, 1.0f);   /* back to the eye: a ray of no length in the middle */
    check_no_hits(&plain, planes + 1, 1, 1.0f, 100.0f); /* at the near plane */
    check_no_hits(&plain, planes + 1, 1, 1.0f, 500.0f); /* before it */
    for (i = 0; i < sizeof sides / sizeof sides[0]; ++i) {
        setup p = plain;
        p.width = sides[i][0], p.height = sides[i][1];
        check_no_hits(&p, planes + 1, 1, 1.0f, 1.0f);
        check_no_hits(&p, planes, 1, 1.0f, 1.0f);
    }
}

/* A normal that is none counts as one that faces the eye. */
static void test_nan_normals(void** state) {
    plane planes[2];
    stage s = open_stage(&plain);
    const size_t bytes = (size_t)(4 * plain.width * plain.height) * sizeof(float);
    result facing, none;
    int i, kind;
    (void)state;
    floor_and_wall(planes);
    for (kind = 0; kind < 2; ++kind) {
        put_planes(&s, planes, 2);
        for (i = 0; i < plain.width * plain.height; i += kind ? 1 : 3) { /* all, or every third */
            float* n = s.m.texels[IMAGE_NORMAL][0] + 3 * i;
            n[0] = n[1] = 0.0f, n[2] = 1.0f;
        }
        facing = shade(&s);
        for (i = 0; i < plain.width * plain.height; i += kind ? 1 : 3) s.m.texels[IMAGE_NORMAL][0][3 * i] = NAN;
        none = shade(&s);
        check_range(&s, &none);
        assert_memory_equal(facing.reflection, none.reflection, bytes);
        assert_memory_equal(facing.hit, none.hit, bytes);
        if (kind == 0) assert_true(count_hits(&s, &none) > 200);
        drop(&facing), drop(&none);
    }
    stage_close(&s);
}

static uint32_t random_state = 1u;

static float random_unit(void) { return (float)(lcg_bits(&random_state) >> 8) / 16777216.0f; }

static void test_any_input(void** state) {
    static const setup setups[] = {
        {63, 41, 0, 2, DGB_EFFECT_REFLECT, 60.0f, true, DGB_CLIP_ZERO_TO_ONE},
        {33, 40, 6, 1, DGB_EFFECT_REFLECT | OTHERS, 100.0f, false, DGB_CLIP_NEGATIVE_ONE_TO_ONE},
        {40, 40, 3, 2, DGB_EFFECT_REFLECT, 0.0f, true, DGB_CLIP_ZERO_TO_ONE}};
    plane planes[2];
    size_t i;
    int frame, kind, l, k, hits = 0;
    (void)state;
    floor_and_wall(planes);
    for (i = 0; i < sizeof setups / sizeof setups[0]; ++i) {
        stage s;
        thickness_from = DGB_THICKNESS_BACK_FACES;
        s = open_stage(&setups[i]);
        thickness_from = DGB_THICKNESS_LAYERS;
        for (frame = 0; frame < 16; ++frame) {
            result r;
            put_planes(&s, planes, 2);
            for (k = 0; k < s.m.width * s.m.height; ++k)
                s.m.back[k] = frame % 4 ? random_unit() : lcg_pattern(&random_state);
            for (kind = 0; kind < IMAGE_KINDS; ++kind)
                for (l = 0; l < 2; ++l)
                    for (k = 0; k < (kind == IMAGE_DEPTH ? 1 : 3) * s.m.width * s.m.height; ++k) {
                        const bool odd = lcg_bits(&random_state) >> 16 < 1u << frame;
                        if (odd)
                            s.m.texels[kind][l][k] =
                                frame % 2 ? lcg_pattern(&random_state) : random_unit() * 2.0f - 0.5f;
                    }
            s.params.reflect_stride = 1 + frame;
            s.params.reflect_thickness = frame % 3 ? 0.5f : frame % 2 ? 1e-15f : 1e14f;
            s.params.reflect_distance = frame % 4 ? 30.0f : frame % 8 ? 1e-15f : 1e14f;
            r = shade(&s);
            check_range(&s, &r);
            hits += count_hits(&s, &r);
            drop(&r);
        }
        stage_close(&s);
    }
    assert_true(hits > 1000);
}

FIXTURE_CONTEXT(f, 4, 5, false)

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_mirror),
        cmocka_unit_test(test_parallel_to_the_image),
        cmocka_unit_test(test_before_the_near_plane),
        cmocka_unit_test(test_out_of_the_image),
        cmocka_unit_test(test_no_self_hits),
        cmocka_unit_test(test_second_layer),
        cmocka_unit_test(test_thickness),
        cmocka_unit_test(test_back_faces),
        cmocka_unit_test(test_limits),
        cmocka_unit_test(test_strides),
        cmocka_unit_test(test_border),
        cmocka_unit_test(test_confidence),
        cmocka_unit_test(test_with_other_effects),
        cmocka_unit_test(test_bounced_light),
        cmocka_unit_test(test_indirect_light),
        cmocka_unit_test(test_no_mirror),
        cmocka_unit_test(test_nan_normals),
        cmocka_unit_test(test_any_input),
        cmocka_unit_test(test_no_messages),
    };
    int failed = cmocka_run_group_tests_name("linear", tests, open_context, close_context);
    tracer = DGB_TRACER_HIERARCHICAL;
    failed += cmocka_run_group_tests_name("hierarchical", tests, open_context, close_context);
    return failed;
}
