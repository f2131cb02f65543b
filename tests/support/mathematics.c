#include "mathematics.h"

#include "deepgbuffer.h"
#include "numbers.h"

#include <string.h>

/* >> words */

static void floats_of(const uint32_t* words, float* x, int count) { memcpy(x, words, (size_t)count * sizeof *x); }

static void words_of(const float* x, uint32_t* words, int count) { memcpy(words, x, (size_t)count * sizeof *x); }

/* Of any size: an evenly drawn word is nearly always a huge integer. */
static int int_of(uint32_t word) {
    const uint32_t size = (word & 0x7fffffffu) >> (word * 2654435769u >> 27);
    return word >> 31 ? -(int)size : (int)size;
}

void mathematics_inputs(uint64_t* seed, uint32_t* in, int count) {
    static const uint32_t borders[] = {
        0u,          0x80000000u /* -0 */,       0x3f800000u /* 1 */, 0xbf800000u, 0x00000001u /* subnormal */,
        0x807fffffu, 0x00800000u /* FLT_MIN */,  0x3f7fffffu,         0x3f800001u, 0x7f7fffffu /* FLT_MAX */,
        0xff7fffffu, 0x7f800000u /* infinity */, 0xff800000u,         0x7fc00000u, 0xffc00001u /* NaN */,
        0x7f800001u, 0x5f3759dfu /* 1.3e19 */,   0x477c0000u /* 64512 */};
    const uint32_t kinds = random_bits(seed); /* a call in four is of ordinary numbers alone */
    int i;
    for (i = 0; i < count; ++i) {
        const uint32_t word = random_bits(seed), kind = kinds % 4u == 0u ? 3u : word & 3u;
        in[i] = kind == 0u   ? borders[(word >> 2) % (sizeof borders / sizeof borders[0])]
                : kind == 1u ? random_bits(seed)
                             : bits_of((float)((int)(word >> 8) - 8388608) / 4194304.0f);
    }
}

/* >> packing */

static void call_oct16_encode(const uint32_t* in, uint32_t* out) {
    float n[3];
    uint16_t code;
    floats_of(in, n, 3);
    code = dgb_oct16_encode(n);
    out[0] = code & 255u;
    out[1] = (uint32_t)code >> 8;
}

static void call_oct16_decode(const uint32_t* in, uint32_t* out) {
    float n[3];
    dgb_oct16_decode((uint16_t)(in[0] >> 16), n);
    words_of(n, out, 3);
}

static void call_pack_normals(const uint32_t* in, uint32_t* out) {
    float n[6];
    floats_of(in, n, 6);
    out[0] = dgb_pack_normals(n, n + 3);
}

static void call_unpack_normals(const uint32_t* in, uint32_t* out) {
    float n[6];
    dgb_unpack_normals(in[0], n, n + 3);
    words_of(n, out, 6);
}

static void call_storable(const uint32_t* in, uint32_t* out) { out[0] = bits_of(dgb_storable(from_bits(in[0]))); }

static void call_r11g11b10f_pack(const uint32_t* in, uint32_t* out) {
    float rgb[3];
    floats_of(in, rgb, 3);
    out[0] = dgb_r11g11b10f_pack(rgb);
}

static void call_r11g11b10f_unpack(const uint32_t* in, uint32_t* out) {
    float rgb[3];
    dgb_r11g11b10f_unpack(in[0], rgb);
    words_of(rgb, out, 3);
}

static void call_half_from_float(const uint32_t* in, uint32_t* out) {
    out[0] = dgb_half_from_float(from_bits(in[0])) & 0x7fffu;
}

static void call_half_to_float(const uint32_t* in, uint32_t* out) {
    out[0] = bits_of(dgb_half_to_float((uint16_t)(in[0] >> 16)));
}

static void call_dithered(const uint32_t* in, uint32_t* out) {
    out[0] = bits_of(dgb_dithered(from_bits(in[0]), from_bits(in[1])));
}

/* >> taps */

static void call_spiral_turns(const uint32_t* in, uint32_t* out) { out[0] = (uint32_t)dgb_spiral_turns(int_of(in[0])); }

static void call_spiral_tap(const uint32_t* in, uint32_t* out) {
    float tap[3];
    dgb_spiral_tap(int_of(in[0]), int_of(in[1]), tap);
    words_of(tap, out, 3);
}

static void call_rotation(const uint32_t* in, uint32_t* out) {
    float cos_sin[2];
    dgb_rotation(int_of(in[0]), cos_sin);
    words_of(cos_sin, out, 2);
}

static void call_pixel_hash(const uint32_t* in, uint32_t* out) {
    out[0] = (uint32_t)dgb_pixel_hash(int_of(in[0]), int_of(in[1]), int_of(in[2]));
}

static void call_pixel_pair(const uint32_t* in, uint32_t* out) {
    float u[2];
    dgb_pixel_pair(int_of(in[0]), int_of(in[1]), int_of(in[2]), u);
    words_of(u, out, 2);
}

static void call_hilbert_index(const uint32_t* in, uint32_t* out) {
    out[0] = (uint32_t)dgb_hilbert_index(int_of(in[0]), int_of(in[1]));
}

static void call_pixel_quad(const uint32_t* in, uint32_t* out) {
    float u[4];
    dgb_pixel_quad(int_of(in[0]), int_of(in[1]), int_of(in[2]), u);
    words_of(u, out, 4);
}

static void call_mip_level(const uint32_t* in, uint32_t* out) {
    out[0] = (uint32_t)dgb_mip_level(from_bits(in[0]), int_of(in[1]), 0, DGB_MAX_LEVELS - 1);
}

static void call_mip_levels(const uint32_t* in, uint32_t* out) {
    out[0] = (uint32_t)dgb_mip_levels(int_of(in[0]), int_of(in[1]));
}

static void call_mip_source(const uint32_t* in, uint32_t* out) {
    const int p[2] = {int_of(in[0]), int_of(in[1])};
    int source[2];
    dgb_mip_source(p, int_of(in[2]), source);
    out[0] = (uint32_t)source[0];
    out[1] = (uint32_t)source[1];
}

/* >> camera */

/* An ordinary projection whose entries are anything now and then; what is refused gives nothing. */
static dgb_camera camera_of(const uint32_t* in, dgb_result* result) {
    static const int entries[] = {0, 5, 8, 9, 10, 14};
    dgb_camera camera;
    float p[16] = {1.0f, 0.0f, 0.0f, 0.0f, 0.0f, 1.5f, 0.0f, 0.0f, 0.0f, 0.0f, -1.0f, -1.0f, 0.0f, 0.0f, -0.2f, 0.0f};
    const uint32_t odd = in[0] % 16u;
    memset(&camera, 0, sizeof camera);
    if (odd < 6u) p[entries[odd]] = from_bits(in[1]);
    *result =
        dgb_camera_from_matrix(p, int_of(in[2]), int_of(in[3]), (dgb_clip)(in[0] >> 8 & 1u), in[0] >> 9 & 1u, &camera);
    return camera;
}

static void call_camera_from_matrix(const uint32_t* in, uint32_t* out) {
    dgb_result result;
    const dgb_camera camera = camera_of(in, &result);
    memcpy(out, &camera, sizeof camera);
}

/* A matrix of anything: it must be refused, or give finite numbers. */
static void call_camera_from_anything(const uint32_t* in, uint32_t* out) {
    dgb_camera camera;
    float p[16];
    memset(&camera, 0, sizeof camera);
    floats_of(in, p, 16);
    (void)dgb_camera_from_matrix(p, int_of(in[16]), int_of(in[17]), (dgb_clip)(in[18] & 1u), in[18] >> 1 & 1u, &camera);
    memcpy(out, &camera, sizeof camera);
}

static void call_widen_projection(const uint32_t* in, uint32_t* out) {
    float p[16], jitter[2], widened[16];
    floats_of(in, p, 16);
    floats_of(in + 16, jitter, 2);
    dgb_widen_projection(p, int_of(in[18]), int_of(in[19]), int_of(in[20]), jitter, widened);
    words_of(widened, out, 16);
}

static void call_depth_code(const uint32_t* in, uint32_t* out) {
    out[0] = bits_of(dgb_depth_code(from_bits(in[0]), from_bits(in[1])));
}

static void call_linear_z(const uint32_t* in, uint32_t* out) {
    dgb_camera camera;
    memcpy(&camera, in + 1, sizeof camera);
    out[0] = bits_of(dgb_linear_z(from_bits(in[0]), &camera));
}

static void call_separation_limit(const uint32_t* in, uint32_t* out) {
    dgb_camera camera;
    memcpy(&camera, in + 2, sizeof camera);
    out[0] = bits_of(dgb_separation_limit(from_bits(in[0]), (dgb_format)(in[1] % DGB_FORMAT_COUNT), &camera));
}

static void call_position(const uint32_t* in, uint32_t* out) {
    dgb_camera camera;
    float point[3];
    memcpy(&camera, in + 3, sizeof camera);
    dgb_position(from_bits(in[0]), from_bits(in[1]), from_bits(in[2]), &camera, point);
    words_of(point, out, 3);
}

static void call_pixels_per_metre(const uint32_t* in, uint32_t* out) {
    dgb_camera camera;
    memcpy(&camera, in + 1, sizeof camera);
    out[0] = bits_of(dgb_pixels_per_metre(from_bits(in[0]), &camera));
}

/* >> layers, ambient occlusion and radiosity */

static void call_keep_test(const uint32_t* in, uint32_t* out) {
    out[0] = dgb_keep_test(from_bits(in[0]), from_bits(in[1]), from_bits(in[2]));
}

static void call_ao_term(const uint32_t* in, uint32_t* out) {
    float v[6];
    floats_of(in, v, 6);
    out[0] = bits_of(dgb_ao_term(v, v + 3, from_bits(in[6]), from_bits(in[7]), from_bits(in[8])));
}

static void call_ambient_visibility(const uint32_t* in, uint32_t* out) {
    out[0] = bits_of(dgb_ambient_visibility(from_bits(in[0]), int_of(in[1])));
}

static void call_gather_term(const uint32_t* in, uint32_t* out) {
    float v[9];
    floats_of(in, v, 9);
    out[0] = bits_of(dgb_gather_term(v, v + 3, v + 6, from_bits(in[9]), in[10] & 1u));
}

static void call_gather_scale(const uint32_t* in, uint32_t* out) {
    out[0] = bits_of(dgb_gather_scale(from_bits(in[0]), int_of(in[1]), from_bits(in[2])));
}

/* The factors are parameters, which are finite. */
static void call_boost(const uint32_t* in, uint32_t* out) {
    float albedo[3];
    floats_of(in, albedo, 3);
    out[0] = bits_of(dgb_boost(albedo, (float)(in[3] >> 16) / 65536.0f, (float)(in[4] >> 16) / 65536.0f));
}

static void call_bilateral_weight(const uint32_t* in, uint32_t* out) {
    float v[9];
    floats_of(in, v, 9);
    out[0] = bits_of(dgb_bilateral_weight(v, v + 3, v + 6, from_bits(in[9]), from_bits(in[10])));
}

/* >> visibility bitmask */

/* A number, so that there is a slice of it. */
static float number_of(uint32_t word) { return (float)((int)(word >> 8) - 8388608) / 4194304.0f; }

static void slice_of(const uint32_t* in, float slice[4]) {
    float v[9];
    floats_of(in, v, 9);
    dgb_slice(v, v + 3, v + 6, slice);
}

static void call_arc_sine(const uint32_t* in, uint32_t* out) { out[0] = bits_of(dgb_arc_sine(from_bits(in[0]))); }

static void call_slice_along(const uint32_t* in, uint32_t* out) {
    float v[9], along[3];
    floats_of(in, v, 9);
    dgb_slice_along(v, v + 3, v + 6, along);
    words_of(along, out, 3);
}

static void call_slice(const uint32_t* in, uint32_t* out) {
    float slice[4];
    slice_of(in, slice);
    words_of(slice, out, 3);
    out[3] = bits_of(slice[3] * 1e-5f); /* at most 1e5 */
}

static void call_slice_share(const uint32_t* in, uint32_t* out) {
    float slice[4], q[2];
    slice_of(in, slice);
    floats_of(in + 9, q, 2);
    out[0] = bits_of(dgb_slice_share(slice, q));
}

static void call_slice_angle(const uint32_t* in, uint32_t* out) {
    float slice[4];
    slice_of(in, slice);
    out[0] = bits_of(dgb_slice_angle(slice, from_bits(in[9])));
}

static void call_slice_sum(const uint32_t* in, uint32_t* out) {
    float slice[4], sum[2];
    slice_of(in, slice);
    dgb_slice_sum(slice, number_of(in[9]), sum);
    words_of(sum, out, 2);
}

static void call_sectors(const uint32_t* in, uint32_t* out) {
    out[0] = dgb_sectors(from_bits(in[0]), from_bits(in[1]), from_bits(in[2]));
}

static void call_sector_count(const uint32_t* in, uint32_t* out) { out[0] = (uint32_t)dgb_sector_count(in[0]); }

static void call_sectors_mean(const uint32_t* in, uint32_t* out) {
    float slice[4], sum[2];
    slice_of(in, slice);
    dgb_sectors_mean(slice, in[9], sum);
    words_of(sum, out, 2);
}

static void call_bent_cosine(const uint32_t* in, uint32_t* out) {
    float bent[4];
    floats_of(in, bent, 4);
    out[0] = bits_of(dgb_bent_cosine(bent));
}

/* >> reflections */

static void call_ggx_alpha(const uint32_t* in, uint32_t* out) { out[0] = bits_of(dgb_ggx_alpha(from_bits(in[0]))); }

static void call_ggx_normal(const uint32_t* in, uint32_t* out) {
    float v[9], h[3];
    floats_of(in, v, 9);
    dgb_ggx_normal(v, v + 3, v[6], v + 7, h);
    words_of(h, out, 3);
}

static void call_ggx_density(const uint32_t* in, uint32_t* out) {
    float v[10];
    floats_of(in, v, 10);
    out[0] = bits_of(dgb_ggx_density(v, v + 3, v + 6, v[9]));
}

/* >> all of them, in the header's order */

#define LARGEST 3.4028234663852886e38
#define ULPS 1.000001 /* above 1: a unit vector's part is off by rounding, with -ffast-math by some ulps */
#define QUARTER_TURN (1.5707963267948966 + 6.8e-5)

const mathematics_function mathematics[] = {
    {"dgb_oct16_encode", false, 3, 2, MATHEMATICS_COUNTS, 0, 254, call_oct16_encode},
    {"dgb_oct16_decode", false, 1, 3, MATHEMATICS_FLOATS, -ULPS, ULPS, call_oct16_decode},
    {"dgb_pack_normals", false, 6, 1, MATHEMATICS_WORDS, 0, 0, call_pack_normals},
    {"dgb_unpack_normals", false, 1, 6, MATHEMATICS_FLOATS, -ULPS, ULPS, call_unpack_normals},
    {"dgb_storable", false, 1, 1, MATHEMATICS_FLOATS, 0, 64512, call_storable},
    {"dgb_r11g11b10f_pack", true, 3, 1, MATHEMATICS_WORDS, 0, 0, call_r11g11b10f_pack},
    {"dgb_r11g11b10f_unpack", true, 1, 3, MATHEMATICS_WORDS, 0, 0, call_r11g11b10f_unpack},
    {"dgb_half_from_float", true, 1, 1, MATHEMATICS_COUNTS, 0, 0x7bff, call_half_from_float},
    {"dgb_half_to_float", true, 1, 1, MATHEMATICS_WORDS, 0, 0, call_half_to_float},
    {"dgb_dithered", true, 2, 1, MATHEMATICS_WORDS, 0, 0, call_dithered},
    {"dgb_spiral_turns", true, 1, 1, MATHEMATICS_COUNTS, 0, 820265627, call_spiral_turns},
    {"dgb_spiral_tap", false, 2, 3, MATHEMATICS_FLOATS, -1, 1, call_spiral_tap},
    {"dgb_rotation", false, 1, 2, MATHEMATICS_FLOATS, -1, 1, call_rotation},
    {"dgb_pixel_hash", true, 3, 1, MATHEMATICS_COUNTS, 0, DGB_ROTATION_COUNT - 1, call_pixel_hash},
    {"dgb_pixel_pair", true, 3, 2, MATHEMATICS_FLOATS, 5.9e-8, 1 - 5.9e-8, call_pixel_pair},
    {"dgb_hilbert_index", true, 2, 1, MATHEMATICS_COUNTS, 0, 4095, call_hilbert_index},
    {"dgb_pixel_quad", true, 3, 4, MATHEMATICS_FLOATS, 5.9e-8, 1 - 5.9e-8, call_pixel_quad},
    {"dgb_mip_level", true, 2, 1, MATHEMATICS_COUNTS, 0, DGB_MAX_LEVELS - 1, call_mip_level},
    {"dgb_mip_levels", true, 2, 1, MATHEMATICS_COUNTS, 1, DGB_MAX_LEVELS, call_mip_levels},
    {"dgb_mip_source", true, 3, 2, MATHEMATICS_WORDS, 0, 0, call_mip_source},
    {"dgb_camera_from_matrix", false, 4, 16, MATHEMATICS_FLOATS, -LARGEST, LARGEST, call_camera_from_matrix},
    {"dgb_camera_from_matrix", false, 19, 16, MATHEMATICS_FLOATS, -LARGEST, LARGEST, call_camera_from_anything},
    {"dgb_widen_projection", false, 21, 16, MATHEMATICS_WORDS, 0, 0, call_widen_projection},
    {"dgb_depth_code", false, 2, 1, MATHEMATICS_WORDS, 0, 0, call_depth_code},
    {"dgb_linear_z", false, 17, 1, MATHEMATICS_FLOATS, -1e15 * ULPS, 1e15 * ULPS, call_linear_z},
    {"dgb_separation_limit", false, 18, 1, MATHEMATICS_FLOATS, 0, 1e15 * ULPS, call_separation_limit},
    {"dgb_position", false, 19, 3, MATHEMATICS_WORDS, 0, 0, call_position},
    {"dgb_pixels_per_metre", false, 17, 1, MATHEMATICS_WORDS, 0, 0, call_pixels_per_metre},
    {"dgb_keep_test", false, 3, 1, MATHEMATICS_COUNTS, 0, 1, call_keep_test},
    {"dgb_ao_term", false, 9, 1, MATHEMATICS_FLOATS, 0, LARGEST, call_ao_term},
    {"dgb_ambient_visibility", false, 2, 1, MATHEMATICS_FLOATS, 0, 1, call_ambient_visibility},
    {"dgb_gather_term", false, 11, 1, MATHEMATICS_FLOATS, 0, LARGEST, call_gather_term},
    {"dgb_gather_scale", false, 3, 1, MATHEMATICS_FLOATS, 0, 6.2831855 * ULPS, call_gather_scale},
    {"dgb_boost", false, 5, 1, MATHEMATICS_FLOATS, -1e-6, ULPS, call_boost},
    {"dgb_bilateral_weight", false, 11, 1, MATHEMATICS_FLOATS, 0, LARGEST, call_bilateral_weight},
    {"dgb_arc_sine", false, 1, 1, MATHEMATICS_FLOATS, -QUARTER_TURN, QUARTER_TURN, call_arc_sine},
    {"dgb_slice_along", false, 9, 3, MATHEMATICS_FLOATS, -ULPS, ULPS, call_slice_along},
    {"dgb_slice", false, 9, 4, MATHEMATICS_FLOATS, -QUARTER_TURN, QUARTER_TURN, call_slice},
    {"dgb_slice_share", false, 11, 1, MATHEMATICS_FLOATS, 0, 1, call_slice_share},
    {"dgb_sectors", false, 3, 1, MATHEMATICS_WORDS, 0, 0, call_sectors},
    {"dgb_sector_count", true, 1, 1, MATHEMATICS_COUNTS, 0, 32, call_sector_count},
    {"dgb_slice_angle", false, 10, 1, MATHEMATICS_FLOATS, 0, 2 * QUARTER_TURN, call_slice_angle},
    {"dgb_slice_sum", false, 10, 2, MATHEMATICS_FLOATS, -1e6, 1e6, call_slice_sum},
    {"dgb_sectors_mean", false, 10, 2, MATHEMATICS_FLOATS, -1, 1.001, call_sectors_mean},
    {"dgb_bent_cosine", false, 4, 1, MATHEMATICS_FLOATS, 0, 1, call_bent_cosine},
    {"dgb_ggx_alpha", false, 1, 1, MATHEMATICS_FLOATS, 0, 1, call_ggx_alpha},
    {"dgb_ggx_normal", false, 9, 3, MATHEMATICS_FLOATS, -LARGEST, LARGEST, call_ggx_normal},
    {"dgb_ggx_density", false, 10, 1, MATHEMATICS_FLOATS, 0, LARGEST, call_ggx_density}};

const int mathematics_count = (int)(sizeof mathematics / sizeof mathematics[0]);
