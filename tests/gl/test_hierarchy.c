/* The hierarchical tracer: its ranges against those found texel by texel, and its reflections against the linear
   tracer's, bit for bit. */
#include "gl_images.h"
#include "numbers.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static fixture f;

static uint32_t random_state = 1u;

static double random_unit(void) { return lcg_unit(&random_state); }

static int random_below(int count) { return (int)(random_unit() * count); }

/* >> layers made up at random, so that rays go everywhere: a relief, with holes, and now and then another behind it */

typedef struct camera {
    float fov; /* 0: orthographic */
    bool reversed;
    dgb_clip clip;
    float far_plane; /* 0: infinite */
} camera;

static const camera cameras[] = {{60.0f, true, DGB_CLIP_ZERO_TO_ONE, 0.0f},
                                 {100.0f, false, DGB_CLIP_NEGATIVE_ONE_TO_ONE, 60.0f},
                                 {0.0f, true, DGB_CLIP_ZERO_TO_ONE, 60.0f},
                                 {0.0f, false, DGB_CLIP_NEGATIVE_ONE_TO_ONE, 60.0f}};
enum { CAMERAS = sizeof cameras / sizeof cameras[0] };

static dgb_view view_of(const camera* c, int width, int height) {
    fixture_view v = fixture_default_view();
    v.fov = c->fov;
    v.reversed = c->reversed;
    v.clip = c->clip;
    v.near_plane = 0.1f;
    v.far_plane = c->far_plane;
    return fixture_dgb_view(&v, width, height);
}

static float depth_of(const camera* c, const dgb_view* view, double distance) {
    const float* m = view->projection;
    const double w = c->fov > 0.0f ? distance : 1.0, depth = ((double)m[14] - (double)m[10] * distance) / w;
    return (float)(c->clip == DGB_CLIP_ZERO_TO_ONE ? depth : 0.5 * depth + 0.5);
}

static void put(images* m, const camera* c, const dgb_view* view, int layer, int x, int y, double distance,
                const float n[3]) {
    float* radiance = images_at(m, IMAGE_RADIANCE, layer, x, y);
    *images_at(m, IMAGE_DEPTH, layer, x, y) = distance > 0.0 ? depth_of(c, view, distance) : c->reversed ? 0.0f : 1.0f;
    memcpy(images_at(m, IMAGE_NORMAL, layer, x, y), n, 3 * sizeof(float));
    radiance[0] = (float)(x % 97), radiance[1] = (float)(y % 97), radiance[2] = (float)(layer + 1);
}

static void put_back(images* m, const camera* c, const dgb_view* view, int x, int y, double distance) {
    m->back[y * m->width + x] = distance > 0.0 ? depth_of(c, view, distance) : c->reversed ? 0.0f : 1.0f;
}

typedef enum relief { /* from smooth to nothing but edges */
                      FLOOR,
                      BLOCKS,
                      NOISE,
                      RELIEFS
} relief;

static void random_normal(float n[3]) { /* that faces the eye; of any length */
    int i;
    for (i = 0; i < 3; ++i) n[i] = (float)(2.0 * random_unit() - 1.0);
    if (n[2] < 0.0f) n[2] = -n[2];
}

/* A floor that rises into the distance, below a strip of sky, or what stands before it, `before` > 0 metres away, and
   what that hides. */
static void put_texel(images* m, const camera* c, const dgb_view* view, int x, int y, double before, relief kind) {
    const double height = (y + 0.5) / m->height, floor = height > 0.9 ? 0.0 : 3.0 + 12.0 * height;
    const double behind = before + 0.6 + (kind == NOISE ? 4.0 * random_unit() : 0.0);
    float n[3] = {0.0f, 1.0f, 0.1f};
    if (kind == NOISE || before > 0.0) random_normal(n);
    put(m, c, view, 0, x, y, before > 0.0 ? before : floor, n);
    put_back(m, c, view, x, y, before > 0.0 && random_unit() < 0.7 ? before + 0.8 * random_unit() : 0.0);
    put(m, c, view, 1, x, y, before > 0.0 && random_unit() < 0.9 ? behind : 0.0, n);
}

/* Blocks stand on the floor, few or many, as large as a pixel where all is noise. */
static void put_relief(images* m, const camera* c, const dgb_view* view, relief kind) {
    const int side = kind == NOISE ? 1 : 8, columns = m->width / side + 1, rows = m->height / side + 1;
    const double share = kind == FLOOR ? 0.05 : 0.4;
    double* blocks = (double*)calloc((size_t)columns * (size_t)rows, sizeof *blocks);
    int x, y, i;
    for (i = 0; i < columns * rows; ++i) blocks[i] = random_unit() < share ? 2.0 + 10.0 * random_unit() : 0.0;
    for (y = 0; y < m->height; ++y)
        for (x = 0; x < m->width; ++x) put_texel(m, c, view, x, y, blocks[y / side * columns + x / side], kind);
    free(blocks);
}

/* >> both tracers on the same layers */

typedef struct pair {
    images m;
    int guard, layers;
    const camera* c;
    dgb_view view;
    dgb_context contexts[2]; /* by tracer */
} pair;

static void open_pair(pair* p, const camera* c, int width, int height, int guard, int layers) {
    int tracer;
    memset(p, 0, sizeof *p);
    p->m = images_open(width, height);
    p->c = c;
    p->guard = guard;
    p->layers = layers;
    p->view = view_of(c, width - 2 * guard, height - 2 * guard);
    for (tracer = 0; tracer < DGB_TRACER_COUNT; ++tracer) {
        dgb_desc d = images_desc(&f, &p->m, guard, layers, DGB_EFFECT_REFLECT);
        d.reversed = c->reversed;
        d.clip = c->clip;
        d.tracer = (dgb_tracer)tracer;
        d.thickness = (dgb_thickness)((layers + width) % DGB_THICKNESS_COUNT);
        assert_int_equal(dgb_init(&p->contexts[tracer], &d), DGB_OK);
    }
}

static void close_pair(pair* p) {
    dgb_shutdown(&p->contexts[0]), dgb_shutdown(&p->contexts[1]);
    images_close(&p->m);
}

/* RGBA of one level from (first, first) on, as every version of GL can read it. */
static float* read_level(dgb_texture texture, int level, int first, int width, int height) {
    float* texels;
    GLuint framebuffer;
    assert_true(width > 0 && height > 0);
    texels = (float*)malloc((size_t)width * (size_t)height * 4 * sizeof *texels);
    glGenFramebuffers(1, &framebuffer);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer);
    glFramebufferTexture2D(GL_READ_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, dgbgl_texture_name(texture),
                           level);
    glReadPixels(first, first, width, height, GL_RGBA, GL_FLOAT, texels);
    glDeleteFramebuffers(1, &framebuffer);
    return texels;
}

/* Reflections are made in the image alone, not in the guard band. */
static float* read_image(const dgb_context* c, dgb_slot slot) {
    return read_level(dgb_get_texture(c, slot), 0, c->desc.guard_band, c->desc.width, c->desc.height);
}

static bool same_texel(const float* a, const float* b) {
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2] && a[3] == b[3];
}

/* Hits of layer 0 and of layer 1, once both tracers have agreed on them. */
static void check_same(const dgb_context contexts[2], int hits[2]) {
    static const dgb_slot slots[] = {DGB_REFLECTION, DGB_REFLECTION_HIT};
    const int count = contexts[0].desc.width * contexts[0].desc.height;
    int i, k, different = 0;
    for (k = 0; k < 2; ++k) {
        float *linear = read_image(&contexts[0], slots[k]), *hierarchical = read_image(&contexts[1], slots[k]);
        for (i = 0; i < count; ++i) {
            different += !same_texel(linear + 4 * i, hierarchical + 4 * i);
            if (k == 1 && linear[4 * i] > 0.0f) ++hits[linear[4 * i] > 1.0f];
        }
        free(linear), free(hierarchical);
    }
    if (different) print_error("%d of %d pixels differ\n", different, count);
    assert_int_equal(different, 0);
}

static void check_pair(pair* p, const dgb_params* q, int hits[2]) {
    const dgb_layers layers = images_upload(&p->m);
    int tracer;
    for (tracer = 0; tracer < 2; ++tracer) {
        assert_int_equal(dgb_set_layers(&p->contexts[tracer], &p->view, &layers), DGB_OK);
        assert_int_equal(dgb_shade(&p->contexts[tracer], q), DGB_OK);
    }
    check_same(p->contexts, hits);
}

static dgb_params long_rays(void) {
    dgb_params q = dgb_preset(DGB_PRESET_QUALITY);
    q.reflect_stride = 1;
    q.reflect_steps = 4096;
    q.reflect_distance = 100.0f;
    q.reflect_border = 4.0f;
    q.strict_separation = false;
    return q;
}

/* Every size, stride and thickness that meets cells and borders in another way. The last sizes are as wide as a cell of
   some level, and a pixel more and less. */
static void test_same_hits(void** state) {
    static const int sizes[][3] = {{1, 1, 0},   {1, 64, 0},  {37, 1, 0},  {2, 3, 0},    {5, 5, 0},   {63, 41, 0},
                                   {75, 53, 6}, {64, 64, 0}, {65, 33, 0}, {31, 127, 0}, {203, 97, 3}};
    static const int strides[] = {1, 2, 3, 5, 16, 64};
    static const float thicknesses[] = {0.5f, 0.02f, 3.0f, 1e14f, 1e-15f};
    int hits[2] = {0, 0}, layers;
    size_t size, lens, kind, i;
    (void)state;
    for (size = 0; size < sizeof sizes / sizeof sizes[0]; ++size)
        for (lens = 0; lens < CAMERAS; ++lens)
            for (layers = 1; layers <= 2; ++layers) {
                pair p;
                open_pair(&p, &cameras[lens], sizes[size][0], sizes[size][1], sizes[size][2], layers);
                for (kind = 0; kind < RELIEFS; ++kind) {
                    dgb_params q = long_rays();
                    put_relief(&p.m, p.c, &p.view, (relief)kind);
                    for (i = 0; i < sizeof strides / sizeof strides[0]; ++i) {
                        q.reflect_stride = strides[i];
                        q.reflect_thickness = thicknesses[random_below(5)];
                        check_pair(&p, &q, hits);
                    }
                }
                close_pair(&p);
            }
    printf("# %d hits of the first layer, %d of the second\n", hits[0], hits[1]);
    assert_true(hits[0] > 100000 && hits[1] > 10000);
}

/* A ray that runs out of steps within what could be skipped misses, as if every step had been tested; one step more,
   and it hits where it did. */
static void test_same_exhaustion(void** state) {
    dgb_params q = long_rays();
    int steps, before = 0, layers;
    (void)state;
    for (layers = 1; layers <= 2; ++layers) {
        pair p;
        open_pair(&p, &cameras[0], 203, 97, 0, layers);
        put_relief(&p.m, p.c, &p.view, BLOCKS);
        for (before = 0, steps = 1; steps <= 200; steps += steps < 40 ? 1 : 23) {
            int hits[2] = {0, 0};
            q.reflect_steps = steps;
            check_pair(&p, &q, hits);
            assert_true(hits[0] + hits[1] >= before); /* more steps find more */
            before = hits[0] + hits[1];
        }
        assert_true(before > 1000);
        close_pair(&p);
    }
}

/* Mirrors in whose plane the eye all but lies: rays follow the surface, the row or the column of cells, for a long
   way. */
static void test_same_grazing(void** state) {
    static const float normals[][3] = {{0.0f, 1.0f, 0.02f}, {1.0f, 0.0f, 0.02f}, {0.0f, 1.0f, 0.0f},
                                       {-1.0f, 0.0f, 0.0f}, {0.7f, 0.7f, 0.05f}, {0.0f, 0.7f, 0.7f}};
    static const float facing[3] = {0.0f, 0.0f, 1.0f};
    int hits[2] = {0, 0}, x, y, layers;
    size_t i, lens;
    (void)state;
    for (lens = 0; lens < CAMERAS; ++lens)
        for (layers = 1; layers <= 2; ++layers)
            for (i = 0; i < sizeof normals / sizeof normals[0]; ++i) {
                dgb_params q = long_rays();
                pair p;
                q.reflect_thickness = 0.1f;
                open_pair(&p, &cameras[lens], 131, 66, 0, layers);
                for (y = 0; y < p.m.height; ++y)
                    for (x = 0; x < p.m.width; ++x) {
                        const bool post = x % 40 == 39 || y % 30 == 29;
                        const double distance = 3.0 + 0.05 * y + 0.02 * x;
                        put(&p.m, p.c, &p.view, 0, x, y, post ? distance - 0.4 : distance, post ? facing : normals[i]);
                        put(&p.m, p.c, &p.view, 1, x, y, post ? distance + 0.3 : 0.0, facing);
                    }
                check_pair(&p, &q, hits);
                close_pair(&p);
            }
    printf("# %d hits of the first layer, %d of the second\n", hits[0], hits[1]);
    assert_true(hits[0] > 1000 && hits[1] > 100);
}

/* >> layers that the library built: deeper layers of a lower resolution, depth in fewer bits */

static void build_room(dgb_context* c, dgb_desc d, int* hits) {
    fixture_view v = fixture_default_view();
    const dgb_view view = fixture_dgb_view(&v, d.width, d.height);
    const dgb_params q = long_rays();
    int tracer;
    for (tracer = 0; tracer < 2; ++tracer) {
        fixture_draw_user user = {&f, 0, false};
        d.tracer = (dgb_tracer)tracer;
        assert_int_equal(dgb_init(&c[tracer], &d), DGB_OK);
        user.program = fixture_program(&c[tracer]);
        assert_int_equal(dgb_build(&c[tracer], &view, &q, fixture_draw, &user), DGB_OK);
        assert_int_equal(dgb_shade(&c[tracer], &q), DGB_OK);
        glDeleteProgram(user.program);
    }
    check_same(c, hits);
}

/* Of pixels that both show a hit on the first layer, the share in which it is as far away within a tenth. */
static double share_of_equal_lengths(const dgb_context* a, const dgb_context* b) {
    float *x = read_image(a, DGB_REFLECTION_HIT), *y = read_image(b, DGB_REFLECTION_HIT);
    int i, both = 0, equal = 0;
    for (i = 0; i < a->desc.width * a->desc.height; ++i) {
        if (x[4 * i] != 1.0f || y[4 * i] != 1.0f) continue;
        ++both;
        equal += x[4 * i + 1] < 1.1f * y[4 * i + 1] && y[4 * i + 1] < 1.1f * x[4 * i + 1];
    }
    free(x), free(y);
    assert_true(both > 200);
    return (double)equal / both;
}

static void test_built_layers(void** state) {
    static const dgb_format formats[] = {DGB_FORMAT_D32F, DGB_FORMAT_D24, DGB_FORMAT_D16};
    const fixture_view v = fixture_default_view();
    dgb_desc d = fixture_desc(&f, &v, 141, 95, 5);
    dgb_context whole[2];
    int reference[2] = {0, 0}, divisor;
    size_t i;
    (void)state;
    d.effects = DGB_EFFECT_REFLECT;
    build_room(whole, d, reference);
    for (divisor = 1; divisor <= 4; divisor *= 2)
        for (i = 0; i < sizeof formats / sizeof formats[0]; ++i) {
            dgb_context c[2];
            int hits[2] = {0, 0};
            double equal;
            d.divisor = divisor;
            d.depth_format = formats[i];
            if (!fixture_offers(&f, &d)) continue;
            build_room(c, d, hits);
            equal = share_of_equal_lengths(&whole[0], &c[0]);
            printf("# divisor %d, %s: %d + %d hits, %.4f as far away\n", divisor, dgb_format_name(formats[i]), hits[0],
                   hits[1], equal);
            assert_true(hits[0] > 4000 && hits[1] > 500);
            /* rounded depth moves a hit a pixel on where a ray grazes, a coarser second layer caps thickness
               elsewhere */
            assert_true(equal > 0.99);
            dgb_shutdown(&c[0]), dgb_shutdown(&c[1]);
        }
    dgb_shutdown(&whole[0]), dgb_shutdown(&whole[1]);
}

/* >> the ranges themselves */

static void extend(float range[2], float z) {
    if (z <= DGB_EMPTY_Z) return;
    if (z > range[0]) range[0] = z;
    if (z < range[1]) range[1] = z;
}

/* Of the texels from the cell's corner on, as many as two cells, as far as there are texels. */
static void expected_range(const float* z, int width, int height, int cell, int column, int row, float range[4]) {
    int x, y;
    range[0] = range[2] = -1e30f, range[1] = range[3] = 1e30f;
    for (y = row * cell; y < (row + 2) * cell && y < height; ++y)
        for (x = column * cell; x < (column + 2) * cell && x < width; ++x) {
            extend(range, z[4 * (y * width + x)]);
            extend(range + 2, z[4 * (y * width + x) + 1]);
        }
}

static const dgb_texture_desc* ranges_of(const dgb_plan* plan) {
    int i;
    for (i = 0; i < plan->texture_count; ++i)
        if (plan->textures[i].slot == DGB_RANGES) return &plan->textures[i];
    fail_msg("no ranges");
    return NULL;
}

/* Every cell that begins within the buffer. How many of them are not empty. */
static int check_ranges(const dgb_context* c) {
    const dgb_texture_desc* t = ranges_of(&c->plan);
    const int width = c->plan.width, height = c->plan.height, channels = c->plan.layers > 1 ? 4 : 2;
    float* z = read_level(dgb_get_texture(c, DGB_Z), 0, 0, width, height);
    int level, x, y, filled = 0;
    for (level = 0; level < t->levels; ++level) {
        const int cell = 4 << level, columns = t->width >> level, rows = t->height >> level;
        float* ranges = read_level(dgb_get_texture(c, DGB_RANGES), level, 0, columns, rows);
        for (y = 0; y * cell < height; ++y)
            for (x = 0; x * cell < width; ++x) {
                float expected[4];
                assert_true(x < columns && y < rows);
                expected_range(z, width, height, cell, x, y, expected);
                assert_memory_equal(ranges + 4 * (y * columns + x), expected, (size_t)channels * sizeof(float));
                filled += expected[0] > DGB_EMPTY_Z;
            }
        free(ranges);
    }
    free(z);
    return filled;
}

static void test_ranges(void** state) {
    static const int sizes[][2] = {{1, 1}, {1, 64},  {37, 1},  {2, 3},   {5, 5},    {4, 4},    {8, 8},
                                   {9, 7}, {63, 41}, {64, 64}, {65, 33}, {130, 67}, {255, 19}, {300, 129}};
    int layers, filled = 0;
    size_t i, kind;
    (void)state;
    for (i = 0; i < sizeof sizes / sizeof sizes[0]; ++i)
        for (layers = 1; layers <= 2; ++layers) {
            pair p;
            open_pair(&p, &cameras[i % CAMERAS], sizes[i][0], sizes[i][1], 0, layers);
            for (kind = 0; kind < RELIEFS; ++kind) {
                const dgb_params q = long_rays();
                int hits[2] = {0, 0};
                put_relief(&p.m, p.c, &p.view, (relief)kind);
                check_pair(&p, &q, hits);
                filled += check_ranges(&p.contexts[1]);
            }
            close_pair(&p);
        }
    assert_true(filled > 10000);
}

/* Where nothing is, ranges hold nothing, and every ray misses. */
static void test_empty(void** state) {
    const float n[3] = {0.0f, 0.0f, 1.0f};
    const dgb_params q = long_rays();
    int x, y, hits[2] = {0, 0};
    pair p;
    (void)state;
    open_pair(&p, &cameras[0], 63, 41, 0, 2);
    for (y = 0; y < 41; ++y)
        for (x = 0; x < 63; ++x) put(&p.m, p.c, &p.view, 0, x, y, 0.0, n), put(&p.m, p.c, &p.view, 1, x, y, 0.0, n);
    check_pair(&p, &q, hits);
    assert_int_equal(check_ranges(&p.contexts[1]), 0);
    assert_int_equal(hits[0] + hits[1], 0);
    close_pair(&p);
}

static void test_no_messages(void** state) {
    (void)state;
    assert_int_equal(f.messages, 0);
    assert_int_equal(glGetError(), GL_NO_ERROR);
}

static int open_context(void** state) {
    (void)state;
    return fixture_open(&f, 4, 5, false, NULL);
}

static int open_33(void** state) { /* no immutable textures, no clip control */
    (void)state;
    return fixture_open(&f, 3, 3, false, NULL);
}

static int open_es(void** state) {
    (void)state;
    return fixture_open(&f, 3, 0, true, NULL);
}

static int close_context(void** state) {
    (void)state;
    fixture_close(&f);
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_ranges),       cmocka_unit_test(test_empty),
        cmocka_unit_test(test_same_hits),    cmocka_unit_test(test_same_exhaustion),
        cmocka_unit_test(test_same_grazing), cmocka_unit_test(test_built_layers),
        cmocka_unit_test(test_no_messages),
    };
    const struct CMUnitTest elsewhere[] = {
        cmocka_unit_test(test_ranges),
        cmocka_unit_test(test_same_exhaustion),
        cmocka_unit_test(test_no_messages),
    };
    int failed = cmocka_run_group_tests_name("GL 4.5", tests, open_context, close_context);
    failed += cmocka_run_group_tests_name("GL 3.3", elsewhere, open_33, close_context);
    failed += cmocka_run_group_tests_name("ES 3.0", elsewhere, open_es, close_context);
    return failed;
}
