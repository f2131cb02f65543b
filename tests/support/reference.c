#include "reference.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846

/* >> vectors */

static double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void subtract(const double a[3], const double b[3], double out[3]) {
    int i;
    for (i = 0; i < 3; ++i) out[i] = a[i] - b[i];
}

static double above_zero(double x) { return x > 0.0 ? x : 0.0; }

/* >> packed input: levels, normals, positions */

int reference_size(int size, int level) { return size >> level; }

/* Texel p of a level copies texel 2p + (p.y & 1, p.x & 1) of the level before. */
static void copied_from(const int p[2], int q[2]) {
    q[0] = 2 * p[0] + (p[1] & 1);
    q[1] = 2 * p[1] + (p[0] & 1);
}

static float* copy_level(const float* from, int width, int height, int from_width, int channels) {
    float* to = (float*)malloc((size_t)width * (size_t)height * (size_t)channels * sizeof(float));
    int p[2], q[2];
    for (p[1] = 0; p[1] < height; ++p[1])
        for (p[0] = 0; p[0] < width; ++p[0]) {
            copied_from(p, q);
            memcpy(to + (size_t)(p[1] * width + p[0]) * (size_t)channels,
                   from + (size_t)(q[1] * from_width + q[0]) * (size_t)channels, (size_t)channels * sizeof(float));
        }
    return to;
}

static void make_chain(const reference* r, const float* level0, int channels, float* chain[DGB_MAX_LEVELS]) {
    const size_t size = (size_t)r->width * (size_t)r->height * (size_t)channels * sizeof(float);
    int level;
    if (!level0) return;
    chain[0] = (float*)malloc(size);
    memcpy(chain[0], level0, size);
    for (level = 1; level < r->levels; ++level)
        chain[level] = copy_level(chain[level - 1], reference_size(r->width, level), reference_size(r->height, level),
                                  reference_size(r->width, level - 1), channels);
}

void reference_open(reference* r, const dgb_context* context, const float* z, const float* normals,
                    const float* const radiance[2]) {
    int i;
    memset(r, 0, sizeof *r);
    r->width = context->plan.width;
    r->height = context->plan.height;
    r->layers = context->plan.layers < DGB_MAX_SHADED_LAYERS ? context->plan.layers : DGB_MAX_SHADED_LAYERS;
    r->levels = 1;
    while (r->levels < DGB_MAX_LEVELS && reference_size(r->width, r->levels) && reference_size(r->height, r->levels))
        ++r->levels;
    r->divisor = context->desc.divisor > 1 ? context->desc.divisor : 1;
    for (i = 0; i < 16; ++i) r->projection[i] = (double)context->drawn.projection[i];
    r->camera = context->camera;
    make_chain(r, z, r->layers, r->z);
    make_chain(r, normals, 2 * r->layers, r->normals);
    for (i = 0; i < r->layers; ++i) make_chain(r, radiance[i], 3, r->radiance[i]);
}

void reference_close(reference* r) {
    int level;
    for (level = 0; level < DGB_MAX_LEVELS; ++level) {
        free(r->z[level]);
        free(r->normals[level]);
        free(r->radiance[0][level]);
        free(r->radiance[1][level]);
    }
    memset(r, 0, sizeof *r);
}

typedef struct place { /* a texel of a level, and the pixel of level 0 that it was copied from */
    int texel[2], level, pixel[2];
    bool inside; /* false: beyond the buffer, and moved to its border */
} place;

static place place_of(int x, int y) {
    place p;
    p.texel[0] = p.pixel[0] = x;
    p.texel[1] = p.pixel[1] = y;
    p.level = 0;
    p.inside = true;
    return p;
}

static size_t index_of(const reference* r, const place* p) {
    return (size_t)p->texel[1] * (size_t)reference_size(r->width, p->level) + (size_t)p->texel[0];
}

static double z_at(const reference* r, const place* p, int layer) {
    return (double)r->z[p->level][index_of(r, p) * (size_t)r->layers + (size_t)layer];
}

/* Octahedral map: the lower half is folded over the diagonals of the upper one. Bytes are snorm, plus 127. */
static void normal_at(const reference* r, const place* p, int layer, double n[3]) {
    const float* bytes = r->normals[p->level] + index_of(r, p) * (size_t)(2 * r->layers) + 2 * layer;
    double o[2], length;
    int i;
    for (i = 0; i < 2; ++i) {
        const double byte = floor((double)bytes[i] * 255.0 + 0.5);
        n[i] = o[i] = (byte > 254.0 ? 127.0 : byte - 127.0) / 127.0;
    }
    n[2] = 1.0 - fabs(o[0]) - fabs(o[1]);
    for (i = 0; i < 2 && n[2] < 0.0; ++i) n[i] = (o[i] < 0.0 ? -1.0 : 1.0) * (1.0 - fabs(o[1 - i]));
    length = sqrt(dot(n, n));
    for (i = 0; i < 3; ++i) n[i] /= length;
}

/* The point that projects to the middle of a pixel, or of the deeper layer's larger texel that the pixel shows, at camera z:
   x p_x + z p_z + p_1 = ndc (z w_z + w_1). */
static void point_in(const reference* r, int layer, const int pixel[2], double z, double point[3]) {
    const int divisor = layer > 0 ? r->divisor : 1;
    const double* p = r->projection;
    const double w = p[11] * z + p[15], size[2] = {r->width, r->height};
    int axis;
    for (axis = 0; axis < 2; ++axis) {
        const int texel = pixel[axis] / divisor;
        const double ndc = 2.0 * (texel + 0.5) * divisor / size[axis] - 1.0;
        point[axis] = (ndc * w - p[8 + axis] * z - p[12 + axis]) / p[5 * axis];
    }
    point[2] = z;
}

static void point_at(const reference* r, const int pixel[2], double z, double point[3]) {
    point_in(r, 0, pixel, z, point);
}

/* What floats may be off in a point at z: a few roundings of numbers as large as the frustum is there. */
static double point_error(const reference* r, double z) {
    const double* p = r->projection;
    const double w = fabs(p[11] * z) + fabs(p[15]);
    const double x = (w + fabs(p[8] * z) + fabs(p[12])) / fabs(p[0]),
                 y = (w + fabs(p[9] * z) + fabs(p[13])) / fabs(p[5]);
    return REFERENCE_EPSILON * (x + y);
}

/* >> taps: float arithmetic, operation for operation */

static int level_of(float h, int log2_q, int min_level, int max_level) {
    int exponent, level;
    (void)frexpf(h, &exponent); /* h = m 2^exponent, m in [0.5, 1) */
    level = exponent - 1 - log2_q;
    return level < min_level ? min_level : level > max_level ? max_level : level;
}

static int clamped_pixel(float position, int size) {
    const float last = (float)(size - 1);
    return (int)(position < 0.0f ? 0.0f : position > last ? last : position);
}

static place tap_place(const reference* r, int x, int y, int i, int count, float reach, int log2_q, int min_level) {
    float tap[3], turn[2], h, c, s;
    int hash = dgb_pixel_hash(x, y, r->frame), last = r->levels - 1, axis, step;
    const int size[2] = {r->width, r->height};
    place p;
    dgb_spiral_tap(i, count, tap);
    dgb_rotation(hash, turn);
    c = tap[0] * turn[0] - tap[1] * turn[1];
    s = tap[0] * turn[1] + tap[1] * turn[0];
    h = reach * tap[2];
    h = h > 0.75f ? h : 0.75f;
    p.level = level_of(h, log2_q, min_level < last ? min_level : last, last);
    p.inside = true;
    for (axis = 0; axis < 2; ++axis) {
        const float at = axis ? (float)y + 0.5f + h * s : (float)x + 0.5f + h * c;
        const int end = reference_size(size[axis], p.level) - 1;
        p.inside = p.inside && at >= 0.0f && at < (float)size[axis];
        p.texel[axis] = clamped_pixel(at, size[axis]) >> p.level;
        if (p.texel[axis] > end) p.texel[axis] = end;
        p.pixel[axis] = p.texel[axis];
    }
    for (step = 0; step < p.level; ++step) {
        const int q[2] = {p.pixel[0], p.pixel[1]};
        copied_from(q, p.pixel);
    }
    return p;
}

/* Radius of the spiral: no farther than the buffer's diagonal. */
static float reach_of(const reference* r, double z, float radius) {
    const float w = (float)r->width, h = (float)r->height, diagonal = sqrtf(w * w + h * h);
    const float reach = dgb_pixels_per_metre((float)z, &r->camera) * radius;
    return reach < diagonal ? reach : diagonal;
}

/* >> ambient occlusion */

/* Equation 2, and what floats may be off in it. */
static double occlusion_term(const double v[3], const double n[3], const dgb_params* q, double v_error, double* error) {
    const double r = (double)q->ao_radius, d2 = dot(v, v), length = sqrt(d2 + (double)q->ao_epsilon * r * r);
    const double falloff = 1.0 - d2 / (r * r), cosine = (dot(v, n) - (double)q->ao_bias * r) / length;
    const double falloff_error = 2.0 * sqrt(d2) * v_error / (r * r) + 4.0 * REFERENCE_EPSILON;
    const double cosine_error = 2.0 * v_error / length + 4.0 * REFERENCE_EPSILON;
    const bool nothing = falloff < -falloff_error || cosine < -cosine_error;
    *error = nothing ? 0.0 : falloff_error + cosine_error;
    return above_zero(falloff) * above_zero(cosine);
}

/* The stronger of the layers under a tap. */
static double occlusion_tap(const reference* r, const dgb_params* q, const place* tap, const double x[3],
                            const double n[3], double* error) {
    double best = 0.0;
    int layer;
    *error = 0.0;
    for (layer = 0; layer < r->layers; ++layer) {
        const double z = z_at(r, tap, layer);
        double y[3], v[3], term, term_error;
        if (z == 0.0) continue;
        point_in(r, layer, tap->pixel, z, y);
        subtract(y, x, v);
        term = occlusion_term(v, n, q, point_error(r, z) + point_error(r, x[2]), &term_error);
        best = term > best ? term : best;
        *error = term_error > *error ? term_error : *error;
    }
    return best;
}

reference_ao reference_occlusion(const reference* r, const dgb_params* q, int x, int y) {
    const place here = place_of(x, y);
    const double z = z_at(r, &here, 0);
    reference_ao ao;
    double point[3], n[3], error;
    int i;
    memset(&ao, 0, sizeof ao);
    ao.empty = z == 0.0;
    if (ao.empty) return ao;
    ao.reach = (double)reach_of(r, z, q->ao_radius);
    point_at(r, here.pixel, z, point);
    normal_at(r, &here, 0, n);
    for (i = 0; i < q->ao_samples; ++i) {
        const place tap = tap_place(r, x, y, i, q->ao_samples, (float)ao.reach, DGB_AO_LOG2_Q, q->ao_min_level);
        if (tap.pixel[0] == x && tap.pixel[1] == y) continue;
        ao.sum += occlusion_tap(r, q, &tap, point, n, &error);
        ao.error += error;
    }
    return ao;
}

/* Equation 1, faded out where the radius covers less than three pixels. */
double reference_visibility(const reference_ao* ao, const dgb_params* q, double sum) {
    const double open = above_zero(1.0 - sqrt(PI / q->ao_samples * above_zero(sum)));
    const double weight = ao->reach <= 1.5 ? 0.0 : ao->reach >= 3.0 ? 1.0 : (ao->reach - 1.5) / 1.5;
    return ao->empty ? 1.0 : 1.0 + (pow(open, (double)q->ao_intensity) - 1.0) * weight;
}

/* >> radiosity */

typedef struct sender {   /* one surface under a tap */
    double cosine, error; /* 0: sends nothing */
    double light[3];      /* radiance */
    double strength;      /* sum of radiance times cosine */
    bool doubtful;        /* in the receiver's plane: adds no light, but may count */
    bool unsure;          /* rounding decides about light that matters */
} sender;

/* Whether the cosine counts (Equations 4 and 5), with the three comparisons that rounding may turn. */
static void judge_sender(sender* s, const double v[3], const double n_x[3], const double n_y[3], const dgb_params* q,
                         double v_error) {
    const double d2 = dot(v, v), length = sqrt(d2), r2 = (double)q->radius * (double)q->radius;
    const double slack = 2.0 * v_error + 4.0 * REFERENCE_EPSILON * length, facing = dot(v, n_y),
                 ahead = dot(v, n_x) - (double)DGB_MIN_COSINE * length;
    const double d2_slack = 2.0 * length * v_error + 4.0 * REFERENCE_EPSILON * d2;
    /* with one normal for both the same number cannot be above and below 0 */
    const bool same = n_x[0] == n_y[0] && n_x[1] == n_y[1] && n_x[2] == n_y[2];
    const bool out_surely = d2 > r2 + d2_slack || ahead < -slack || (q->normal_test && (same || facing > slack));
    const bool in_surely = d2 < r2 - d2_slack && ahead > slack && (!q->normal_test || facing < -slack);
    if (out_surely || length == 0.0) return;
    s->cosine = above_zero(dot(v, n_x) / length);
    s->error = 2.0 * slack / length;
    s->doubtful = !in_surely && ahead <= slack;
    s->unsure = !in_surely && !s->doubtful;
}

static sender sender_at(const reference* r, const dgb_params* q, const place* tap, int layer, const double x[3],
                        const double n_x[3]) {
    const double z = z_at(r, tap, layer);
    const float* b = r->radiance[layer][tap->level] + index_of(r, tap) * 3;
    sender s;
    double y[3], v[3], n_y[3];
    int i;
    memset(&s, 0, sizeof s);
    if (z == 0.0) return s;
    point_in(r, layer, tap->pixel, z, y);
    subtract(y, x, v);
    normal_at(r, tap, layer, n_y);
    judge_sender(&s, v, n_x, n_y, q, point_error(r, z) + point_error(r, x[2]));
    for (i = 0; i < 3; ++i) {
        s.light[i] = (double)b[i];
        s.strength += s.light[i] * s.cosine;
    }
    return s;
}

typedef struct gathered { /* sums over all senders */
    double light[3], light_error[3], cosines, cosines_error;
    int count, doubtful, taps, doubtful_taps;
    bool unsure;
} gathered;

static void add_sender(gathered* g, const sender* s) {
    int i;
    for (i = 0; i < 3; ++i) {
        g->light[i] += s->doubtful ? 0.0 : s->light[i] * s->cosine;
        g->light_error[i] += s->light[i] * (s->doubtful ? s->cosine + s->error : s->error);
    }
    g->cosines += s->doubtful ? 0.0 : s->cosine;
    g->cosines_error += s->doubtful ? s->cosine + s->error : s->error;
    g->count += !s->doubtful && s->cosine > 0.0;
    g->doubtful += s->doubtful;
    g->unsure = g->unsure || s->unsure;
}

/* Of two surfaces the one that sends more; a doubtful one loses against a sure one. */
static const sender* stronger(const sender* a, const sender* b) {
    if (a->doubtful != b->doubtful && a->cosine + a->error > 0.0 && b->cosine + b->error > 0.0)
        return a->doubtful ? b : a;
    if (b->cosine + b->error == 0.0) return a;
    return a->cosine + a->error > 0.0 && a->strength >= b->strength ? a : b;
}

static void add_tap(gathered* g, const sender* senders, int layers, dgb_senders rule) {
    bool sure = false, doubtful = false;
    int layer;
    for (layer = 0; layer < layers; ++layer) {
        sure = sure || (senders[layer].cosine > 0.0 && !senders[layer].doubtful);
        doubtful = doubtful || senders[layer].doubtful;
    }
    g->taps += sure;
    g->doubtful_taps += doubtful && !sure;
    if (layers > 1 && rule == DGB_SENDERS_STRONGEST) {
        add_sender(g, stronger(&senders[0], &senders[1]));
        return;
    }
    for (layer = 0; layer < layers; ++layer) add_sender(g, &senders[layer]);
}

static double larger(double a, double b) { return a > b ? a : b; }

static double smaller(double a, double b) { return a < b ? a : b; }

/* E = pi sum(B cos) / max(k sum(cos), M / 2): lowest with every doubtful sender counted, highest with
   none. */
static void normalise(const gathered* g, const dgb_params* q, dgb_normaliser normaliser, reference_light* e) {
    const double k = normaliser == DGB_NORMALISER_BOUNDED ? 1.0 : 0.0, rounding = 16.0 * REFERENCE_EPSILON;
    const double most = larger(k * (g->cosines + g->cosines_error), 0.5 * (g->count + g->doubtful));
    const double least = larger(k * (g->cosines - g->cosines_error), 0.5 * (g->count ? g->count : 1));
    int i;
    for (i = 0; i < 3 && g->count + g->doubtful; ++i) {
        e->low[i] = above_zero(PI * (g->light[i] - g->light_error[i]) / most * (1.0 - rounding));
        e->high[i] = PI * (g->light[i] + g->light_error[i]) / least * (1.0 + rounding);
        e->low[i] = e->low[i] < (double)DGB_MAX_RADIANCE ? e->low[i] : (double)DGB_MAX_RADIANCE;
        e->high[i] = e->high[i] < (double)DGB_MAX_RADIANCE ? e->high[i] : (double)DGB_MAX_RADIANCE;
    }
    e->low_confidence = (double)g->taps / q->samples;
    e->high_confidence = (double)(g->taps + g->doubtful_taps) / q->samples;
    e->doubtful = g->doubtful;
    e->unsure = g->unsure;
}

reference_light reference_irradiance(const reference* r, const dgb_params* q, dgb_senders senders,
                                     dgb_normaliser normaliser, int layer, int x, int y) {
    const place here = place_of(x, y);
    const double z = z_at(r, &here, layer);
    const float reach = reach_of(r, z_at(r, &here, 0), q->radius);
    reference_light e;
    gathered g;
    double point[3], n[3];
    int i, l;
    memset(&e, 0, sizeof e);
    memset(&g, 0, sizeof g);
    if (z == 0.0 || z_at(r, &here, 0) == 0.0) return e;
    point_in(r, layer, here.pixel, z, point);
    normal_at(r, &here, layer, n);
    for (i = 0; i < q->samples; ++i) {
        const place tap = tap_place(r, x, y, i, q->samples, reach, DGB_GATHER_LOG2_Q, q->min_level);
        sender under[2];
        if (!tap.inside || (tap.pixel[0] == x && tap.pixel[1] == y)) continue;
        for (l = 0; l < r->layers; ++l) under[l] = sender_at(r, q, &tap, l, point, n);
        add_tap(&g, under, r->layers, senders);
    }
    normalise(&g, q, normaliser, &e);
    if (layer == 1) { /* of the taps within its own reach, which is shorter than the first layer's */
        const double share = (double)reach_of(r, z, q->radius) / (double)reach;
        const double within = larger(share * q->samples, 1.0), rounding = 8.0 * REFERENCE_EPSILON;
        e.low_confidence = smaller(e.low_confidence * q->samples / within, 1.0) * (1.0 - rounding);
        e.high_confidence = smaller(e.high_confidence * q->samples / within, 1.0) * (1.0 + rounding);
    }
    return e;
}

/* >> last frame */

void reference_set_views(reference_last* last, const float now[16], const float then[16]) {
    const double a[3][3] = {{now[0], now[4], now[8]}, {now[1], now[5], now[9]}, {now[2], now[6], now[10]}};
    double inverse[3][3], determinant = 0.0;
    int row, column, k;
    for (row = 0; row < 3; ++row)
        for (column = 0; column < 3; ++column) /* transposed cofactors */
            inverse[column][row] = a[(row + 1) % 3][(column + 1) % 3] * a[(row + 2) % 3][(column + 2) % 3] -
                                   a[(row + 1) % 3][(column + 2) % 3] * a[(row + 2) % 3][(column + 1) % 3];
    for (k = 0; k < 3; ++k) determinant += a[0][k] * inverse[k][0];
    for (row = 0; row < 3; ++row) {
        double moved = (double)then[12 + row];
        for (column = 0; column < 3; ++column) {
            double sum = 0.0;
            for (k = 0; k < 3; ++k) sum += (double)then[4 * k + row] * inverse[k][column] / determinant;
            last->to_last[3 * column + row] = sum;
            moved -= sum * (double)now[12 + column];
        }
        last->to_last[9 + row] = moved;
    }
}

typedef struct past { /* where a point was last frame */
    float pixel[2];   /* by float arithmetic: which texels are asked must not hang on rounding */
    double point[3], normal[3], point_error;
    double tolerance, tolerance_error; /* less than 0: nobody knows */
    double own;                        /* pixels that the object moved across by itself */
} past;

/* Pixels of `size` per unit, for one axis: ndc w = p_x x + p_z z + p_1. */
static double project_axis(const double p[16], int axis, int size, const double point[3]) {
    const double w = p[11] * point[2] + p[15];
    return ((p[5 * axis] * point[axis] + p[8 + axis] * point[2] + p[12 + axis]) / w + 1.0) * 0.5 * size;
}

static void past_point(const reference* r, const reference_last* last, int layer, const place* here, past* p) {
    const double* m = last->to_last;
    const double z = z_at(r, here, layer);
    double x[3], n[3], largest = 0.0, error = point_error(r, z);
    int row, column;
    point_in(r, layer, here->pixel, z, x);
    normal_at(r, here, layer, n);
    for (row = 0; row < 3; ++row) {
        double size = fabs(m[9 + row]);
        p->point[row] = m[9 + row];
        p->normal[row] = 0.0;
        for (column = 0; column < 3; ++column) {
            p->point[row] += m[3 * column + row] * x[column];
            p->normal[row] += m[3 * column + row] * n[column];
            size += fabs(m[3 * column + row] * x[column]);
        }
        largest = larger(largest, size);
    }
    p->point_error = 2.0 * error + 8.0 * REFERENCE_EPSILON * largest;
}

/* How far across an object moved by itself, m; it may have come as much nearer. */
static double own_motion(const reference* r, const reference_last* last, past* p, double* error) {
    const double* m = last->projection;
    const int size[2] = {r->width, r->height};
    const double w = m[11] * p->point[2] + m[15], pixels_per_metre = 0.5 * fabs(m[5]) * r->height / w;
    double own[2];
    int axis;
    for (axis = 0; axis < 2; ++axis) own[axis] = (double)p->pixel[axis] - project_axis(m, axis, size[axis], p->point);
    *error = 4.0 * p->point_error +
             16.0 * REFERENCE_EPSILON * ((double)(r->width + r->height) / pixels_per_metre + fabs(p->point[2]));
    p->own = sqrt(own[0] * own[0] + own[1] * own[1]);
    return p->own / pixels_per_metre;
}

static past past_of(const reference* r, const reference_last* last, const dgb_params* q, int layer, const place* here) {
    const float* velocity = last->velocity[layer] + 3 * (here->pixel[1] * r->width + here->pixel[0]);
    const int divisor = layer > 0 ? r->divisor : 1;
    double error = 0.0;
    bool usable = last->usable;
    past p;
    int axis;
    memset(&p, 0, sizeof p);
    p.tolerance = -1.0;
    past_point(r, last, layer, here, &p);
    for (axis = 0; axis < 2; ++axis) {
        const int texel = here->pixel[axis] / divisor;
        const float centre = ((float)texel + 0.5f) * (float)divisor;
        p.pixel[axis] = last->still ? centre : centre - velocity[axis];
        usable = usable && p.pixel[axis] >= (float)last->rect[axis] &&
                 p.pixel[axis] < (float)(last->rect[2 + axis] + 1); /* and not NaN */
    }
    if (!usable || !(last->projection[11] * p.point[2] + last->projection[15] > 0.0)) return p;
    p.tolerance = larger((double)q->history_tolerance * fabs(p.point[2]), (double)q->history_floor) +
                  own_motion(r, last, &p, &error);
    p.tolerance_error = error + 4.0 * REFERENCE_EPSILON * p.tolerance;
    if (!last->still) p.point[2] -= (double)velocity[2];
    return p;
}

typedef struct range {
    double low, high;
} range;

static range range_of(double x, double error) {
    range out;
    x = fabs(x);
    out.low = above_zero(x - error);
    out.high = x + error;
    return out;
}

/* How far a layer of a texel of last frame is from the point's plane on the texel's ray, or from the point's own depth:
   whichever is less. */
static range past_error(const reference* r, const reference_last* last, const past* p, int layer, const int texel[2]) {
    const double* m = last->projection;
    const int divisor = layer > 0 ? r->divisor : 1, size[2] = {r->width, r->height};
    const double z = (double)last->z[(texel[1] * r->width + texel[0]) * r->layers + layer];
    double start = 0.0, along = p->normal[2], start_size = fabs(p->normal[2] * p->point[2]), along_size = 1.0, on_plane;
    range own, plane;
    int axis;
    if (z == 0.0) { /* sky is nowhere near */
        own.low = own.high = HUGE_VAL;
        return own;
    }
    for (axis = 0; axis < 2; ++axis) { /* the ray: (ray_z, 1) z + (ray_1, 0) */
        const int shown = texel[axis] / divisor;
        const double ndc = 2.0 * (shown + 0.5) * divisor / size[axis] - 1.0;
        const double ray_z = (ndc * m[11] - m[8 + axis]) / m[5 * axis];
        const double ray_1 = (ndc * m[15] - m[12 + axis]) / m[5 * axis];
        start += p->normal[axis] * (p->point[axis] - ray_1);
        along += p->normal[axis] * ray_z;
        start_size += fabs(p->point[axis]) + fabs(ray_1);
        along_size += fabs(m[11] / m[5 * axis]) + fabs(m[8 + axis] / m[5 * axis]);
    }
    start += p->normal[2] * p->point[2];
    start_size = 2.0 * p->point_error + 16.0 * REFERENCE_EPSILON * start_size; /* from here on what floats may be off */
    along_size *= 16.0 * REFERENCE_EPSILON;
    own = range_of(z - p->point[2], p->point_error + 2.0 * REFERENCE_EPSILON * fabs(z));
    if (!(fabs(along) > 2.0 * along_size)) { /* edge on: the plane may be anywhere */
        own.low = 0.0;
        return own;
    }
    on_plane = start / along;
    plane = range_of(z - on_plane, (start_size + fabs(on_plane) * along_size) / (fabs(along) - along_size) +
                                       2.0 * REFERENCE_EPSILON * fabs(z));
    own.low = plane.low < own.low ? plane.low : own.low;
    own.high = plane.high < own.high ? plane.high : own.high;
    return own;
}

/* Which layer of a texel shows the surface, -1: none. The second counts with deep propagation only, where it has light. */
static int shown_in(const reference* r, const reference_last* last, const past* p, bool deep, const int texel[2],
                    bool* unsure) {
    const range tolerance = {p->tolerance - p->tolerance_error, p->tolerance + p->tolerance_error};
    range error[2];
    int best = 0;
    if (p->tolerance < 0.0) return -1;
    error[0] = error[1] = past_error(r, last, p, 0, texel);
    if (deep) {
        error[1] = past_error(r, last, p, 1, texel);
        best = error[1].low + error[1].high < error[0].low + error[0].high ? 1 : 0;
        /* both near enough, and rounding decides which is nearer */
        if (error[1 - best].low <= tolerance.high && error[1 - best].low <= error[best].high) *unsure = true;
    }
    if (error[best].high > tolerance.low && error[best].low <= tolerance.high) *unsure = true;
    return error[best].low + error[best].high <= 2.0 * p->tolerance ? best : -1;
}

static double storable(double x) {
    return x > 0.0 ? (x < (double)DGB_MAX_RADIANCE ? x : (double)DGB_MAX_RADIANCE) : 0.0;
}

/* Of last frame; confidence is 0 to 1. */
static double last_light(const reference_last* last, int layer, const reference* r, const int texel[2], int channel) {
    const double x = storable((double)last->light[layer][4 * (texel[1] * r->width + texel[0]) + channel]);
    return channel == 3 && x > 1.0 ? 1.0 : x;
}

/* Factor of the bounced light: lerp(unsaturated, saturated, (max - min) / max). */
static double boost_of(const double albedo[3], const dgb_params* q) {
    const double high = larger(albedo[0], larger(albedo[1], albedo[2]));
    const double low = -larger(-albedo[0], larger(-albedo[1], -albedo[2]));
    const double saturation = high > 0.0 ? (high - low) / high : 0.0;
    return (double)q->boost_unsaturated * (1.0 - saturation) + (double)q->boost_saturated * saturation;
}

reference_sent reference_radiance(const reference* r, const reference_last* last, const dgb_params* q, int layer,
                                  const float radiance[3], const float albedo[3], int x, int y) {
    const place here = place_of(x, y);
    const bool deep = last && last->light[1];
    double color[3], error;
    reference_sent s;
    past p;
    int shown = -1, texel[2] = {0, 0}, i;
    memset(&s, 0, sizeof s);
    if (z_at(r, &here, layer) == 0.0) return s;
    if (last) {
        p = past_of(r, last, q, layer, &here);
        for (i = 0; i < 2 && p.tolerance >= 0.0; ++i) texel[i] = (int)p.pixel[i];
        shown = shown_in(r, last, &p, deep, texel, &s.unsure);
    }
    for (i = 0; i < 3; ++i) color[i] = storable((double)albedo[i]);
    for (i = 0; i < 3; ++i) {
        double bounced = 0.0;
        if (shown >= 0) {
            const double found = last_light(last, shown, r, texel, 3) * q->samples;
            bounced = color[i] / PI * (double)q->bounce_damping * boost_of(color, q) * (found < 1.0 ? found : 1.0) *
                      last_light(last, shown, r, texel, i);
        }
        error = 16.0 * REFERENCE_EPSILON *
                (bounced + (shown >= 0 ? color[i] * last_light(last, shown, r, texel, i) *
                                             ((double)q->boost_unsaturated + (double)q->boost_saturated)
                                       : 0.0));
        s.bounced = s.bounced || bounced > 0.0;
        s.low[i] = storable(storable((double)radiance[i]) + bounced - error);
        s.high[i] = storable(storable((double)radiance[i]) + bounced + error);
    }
    return s;
}

typedef struct history { /* sums over four texels, each with its bilinear weight */
    double share, light[4], frames;
    double visibility_share, visibility, visibility_frames;
    double spread[4], frames_spread, visibility_spread, visibility_frames_spread; /* sums of magnitudes: what errors
                                                                                     of the weights may do */
} history;

static void add_texel(const reference* r, const reference_last* last, const int texel[2], int shown, double weight,
                      history* h) {
    const float* frames = last->frames + 4 * (texel[1] * r->width + texel[0]);
    const double count = storable((double)frames[2 + shown]);
    int i;
    h->share += weight;
    h->frames += weight * count;
    h->frames_spread += count;
    for (i = 0; i < 4 && last->light[0]; ++i) {
        /* irradiance counts as much as its confidence, the fourth channel */
        const double counts = i < 3 ? last_light(last, shown, r, texel, 3) : 1.0;
        h->light[i] += weight * counts * last_light(last, shown, r, texel, i);
        h->spread[i] += counts * last_light(last, shown, r, texel, i);
    }
    if (shown == 1) return; /* there is no visibility of the second layer */
    h->visibility_share += weight;
    h->visibility += weight * storable((double)frames[0]);
    h->visibility_frames += weight * storable((double)frames[1]);
    h->visibility_spread += storable((double)frames[0]);
    h->visibility_frames_spread += storable((double)frames[1]);
}

/* Bilinear weights are off by a few roundings, and so is each sum, relative to what remains of the weights. */
static const double weight_error = 8.0 * REFERENCE_EPSILON;
static const double least_share = 0.05; /* with less of the weights there is no history */

/* An average of `count` +- count_error frames, `past` +- past_error, and one frame more. */
static void mix(const dgb_params* q, double raw, double old, double old_error, double count, double count_error,
                double* value, double* error) {
    const double weight =
        count / (count + 1.0) < (double)q->history_weight ? count / (count + 1.0) : (double)q->history_weight;
    const double off = count_error / ((count + 1.0) * (count + 1.0)) + 4.0 * REFERENCE_EPSILON;
    *value = raw + (old - raw) * weight;
    *error = weight * old_error + (weight > 0.0 ? off * fabs(old - raw) : 0.0) +
             (weight > 0.0 ? 4.0 * REFERENCE_EPSILON * (fabs(old) + fabs(raw)) : 0.0);
}

/* From irradiance times confidence to irradiance; none where no tap has found any. */
static void unweigh(reference_mean* m) {
    const double least = m->value[3] - m->error[3];
    int i;
    m->unsure = m->unsure || (m->value[3] > 0.0 && least <= 0.0);
    for (i = 0; i < 3; ++i) {
        m->value[i] = m->value[3] > 0.0 ? m->value[i] / m->value[3] : 0.0;
        m->error[i] = least > 0.0 ? (m->error[i] + m->value[i] * m->error[3]) / least : 0.0;
        m->error[i] += 8.0 * REFERENCE_EPSILON * m->value[i];
    }
}

static double one_more(double frames) { return frames + 1.0 < 1000.0 ? frames + 1.0 : 1000.0; }

static void finish_mean(const history* h, const dgb_params* q, const float light[4], float visibility,
                        reference_mean* m) {
    const bool known = h->share > least_share, seen = h->visibility_share > least_share;
    const double share = known ? h->share : 1.0, open_share = seen ? h->visibility_share : 1.0;
    const double frames = known ? h->frames / share : 0.0, open_frames = seen ? h->visibility_frames / open_share : 0.0;
    int i;
    m->frames_error = known ? 2.0 * weight_error * (h->frames_spread / share + frames) : 0.0;
    m->visibility_frames_error =
        seen ? 2.0 * weight_error * (h->visibility_frames_spread / open_share + open_frames) : 0.0;
    for (i = 0; i < 4; ++i) {
        const double old = known ? h->light[i] / share : 0.0;
        mix(q, (double)light[i] * (i < 3 ? (double)light[3] : 1.0), old,
            2.0 * weight_error * (h->spread[i] / share + old), frames, m->frames_error, &m->value[i], &m->error[i]);
    }
    unweigh(m);
    mix(q, (double)visibility, seen ? h->visibility / open_share : 0.0,
        2.0 * weight_error * (h->visibility_spread + h->visibility) / open_share, open_frames,
        m->visibility_frames_error, &m->visibility, &m->visibility_error);
    m->frames = one_more(frames);
    m->visibility_frames = one_more(open_frames);
    m->unsure = m->unsure || fabs(h->share - least_share) < 4.0 * weight_error ||
                fabs(h->visibility_share - least_share) < 4.0 * weight_error;
}

reference_mean reference_average(const reference* r, const reference_last* last, const dgb_params* q, int layer,
                                 const float light[4], float visibility, int x, int y) {
    const place here = place_of(x, y);
    reference_mean m;
    history h;
    past p;
    int i, axis;
    memset(&m, 0, sizeof m);
    memset(&h, 0, sizeof h);
    if (z_at(r, &here, layer) == 0.0) { /* open sky, which no frame adds to */
        for (i = 0; i < 4; ++i) m.value[i] = (double)light[i];
        m.visibility = 1.0;
        return m;
    }
    p = past_of(r, last, q, layer, &here);
    m.own = p.own;
    for (i = 0; i < 4 && p.tolerance >= 0.0; ++i) {
        const int corner[2] = {i & 1, i >> 1};
        int texel[2], shown;
        double weight = 1.0;
        bool inside = true, unsure = false;
        for (axis = 0; axis < 2; ++axis) {
            const float low = floorf(p.pixel[axis] - 0.5f), part = p.pixel[axis] - 0.5f - low;
            texel[axis] = (int)low + corner[axis];
            weight *= corner[axis] ? (double)part : 1.0 - (double)part;
            inside = inside && texel[axis] >= last->rect[axis] && texel[axis] <= last->rect[2 + axis];
        }
        if (!inside || !(weight > 0.0)) continue;
        shown = shown_in(r, last, &p, last->light[1] != NULL, texel, &unsure);
        m.unsure = m.unsure || unsure;
        if (shown < 0) continue;
        ++m.texels;
        m.from_second = m.from_second || shown == 1;
        add_texel(r, last, texel, shown, weight, &h);
    }
    finish_mean(&h, q, light, visibility, &m);
    return m;
}

/* >> reconstruction */

/* Product of normal and plane weight, and what floats may be off in it. */
static double bilateral(const reference* r, const dgb_params* q, int layer, const place* a, const place* b,
                        double* error) {
    const double z_a = z_at(r, a, layer), z_b = z_at(r, b, layer), v_error = point_error(r, z_a) + point_error(r, z_b);
    double x[3], y[3], dq[3], n[3], n2[3], length, off, normal, plane, plane_error;
    point_in(r, layer, a->pixel, z_a, x);
    point_in(r, layer, b->pixel, z_b, y);
    subtract(y, x, dq);
    normal_at(r, a, layer, n);
    normal_at(r, b, layer, n2);
    length = sqrt(dot(dq, dq));
    off = larger(fabs(dot(dq, n)), fabs(dot(dq, n2)));
    normal = above_zero(1.0 - (double)q->normal_sharpness * (1.0 - dot(n, n2)));
    plane = length > 0.0 ? above_zero(1.0 - (double)q->plane_sharpness * off / length) : 1.0;
    plane_error = length > 0.0 ? (double)q->plane_sharpness * (2.0 * v_error / length + 4.0 * REFERENCE_EPSILON) : 0.0;
    *error = (2.0 * plane + plane_error) * plane_error + 8.0 * REFERENCE_EPSILON * (double)q->normal_sharpness * plane;
    return normal * plane * plane;
}

typedef struct neighbour { /* one tap of the filter */
    double weight, error;
    const float* texel;
} neighbour;

/* Gaussian of half the radius as standard deviation; empty or unshaded texels weigh nothing. */
static neighbour neighbour_at(const reference* r, const dgb_params* q, const place* here, int axis, int layer, int i,
                              const int rect[4]) {
    const int side = q->filter_taps / 2;
    const double sigma = 0.5 * side;
    const int step = i * q->filter_step;
    const place there = place_of(here->pixel[0] + (axis == 0 ? step : 0), here->pixel[1] + (axis == 1 ? step : 0));
    neighbour n = {0.0, 0.0, NULL};
    double spatial;
    if (there.pixel[0] < rect[0] || there.pixel[1] < rect[1] || there.pixel[0] > rect[2] || there.pixel[1] > rect[3])
        return n;
    if (z_at(r, &there, layer) == 0.0) return n;
    spatial = exp(-0.5 * i * i / (sigma * sigma));
    n.weight = spatial * bilateral(r, q, layer, here, &there, &n.error);
    n.error *= spatial;
    return n;
}

/* All taps of one direction; the centre weighs 1. Returns how many. */
static int neighbours_of(const reference* r, const dgb_params* q, const place* here, int axis, int layer,
                         const int rect[4], const float* image, int channels,
                         neighbour taps[2 * DGB_MAX_FILTER_RADIUS + 1]) {
    const int side = z_at(r, here, layer) == 0.0 ? 0 : q->filter_taps / 2, stride = axis == 0 ? 1 : r->width;
    const int centre = here->pixel[1] * r->width + here->pixel[0];
    int i;
    for (i = -side; i <= side; ++i) {
        neighbour* tap = &taps[i + side];
        *tap = neighbour_at(r, q, here, axis, layer, i, rect);
        if (i == 0) tap->weight = 1.0, tap->error = 0.0;
        if (tap->weight > 0.0 || tap->error > 0.0)
            tap->texel = image + (centre + i * q->filter_step * stride) * channels;
    }
    return 2 * side + 1;
}

reference_filtered reference_reconstruct(const reference* r, const dgb_params* q, int axis, int layer,
                                         const int rect[4], const float* image, int channels, int x, int y) {
    const place here = place_of(x, y);
    neighbour taps[2 * DGB_MAX_FILTER_RADIUS + 1] = {{0.0, 0.0, NULL}};
    const int count = neighbours_of(r, q, &here, axis, layer, rect, image, channels, taps);
    reference_filtered out;
    int i, c;
    memset(&out, 0, sizeof out);
    for (c = 0; c < channels; ++c) {
        double total = 0.0;
        /* irradiance counts as much as its confidence, the fourth channel */
        for (i = 0; i < count; ++i)
            total += taps[i].weight * (channels == 4 && c < 3 && taps[i].texel ? (double)taps[i].texel[3] : 1.0);
        if (total == 0.0) continue;
        for (i = 0; i < count; ++i) {
            const double counts = channels == 4 && c < 3 && taps[i].texel ? (double)taps[i].texel[3] : 1.0;
            if (taps[i].texel) out.value[c] += taps[i].weight * counts * (double)taps[i].texel[c] / total;
        }
        out.error[c] = 16.0 * REFERENCE_EPSILON * fabs(out.value[c]);
        for (i = 0; i < count; ++i) {
            const double counts = channels == 4 && c < 3 && taps[i].texel ? (double)taps[i].texel[3] : 1.0;
            if (taps[i].texel)
                out.error[c] += taps[i].error * counts * fabs((double)taps[i].texel[c] - out.value[c]) / total;
        }
    }
    return out;
}
