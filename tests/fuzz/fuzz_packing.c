/* The mathematics with any bits: what comes out is what the header promises, and finite where it promises no NaN.
   Sizes, levels and counts are those that a plan can have, except where the header says what others give. */
#include "fuzz.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <string.h>

static void in_range(float x, float low, float high, const char* what) {
    if (!(x >= low && x <= high)) fail_msg("%s: %g is not in %g..%g", what, (double)x, (double)low, (double)high);
}

static void all_finite(const float* x, int count, const char* what) {
    int i;
    for (i = 0; i < count; ++i)
        if (!isfinite(x[i])) fail_msg("%s[%d] is %g", what, i, (double)x[i]);
}

/* Within what a few roundings of its parts leave. */
static void is_unit(const float* x, int count, const char* what) {
    float square = 0.0f;
    int i;
    for (i = 0; i < count; ++i) square += x[i] * x[i];
    in_range(square, 1.0f - 1e-5f, 1.0f + 1e-5f, what);
}

static void normals(fuzz_bytes* b) {
    float n[6], back[6];
    uint32_t packed;
    int i;
    fuzz_floats(b, n, 6);
    packed = dgb_pack_normals(n, n + 3);
    for (i = 0; i < 4; ++i) in_range((float)(packed >> 8 * i & 255u), 0.0f, 254.0f, "byte of a normal");
    dgb_unpack_normals(packed, back, back + 3);
    is_unit(back, 3, "normal of layer 0");
    is_unit(back + 3, 3, "normal of layer 1");
    dgb_oct16_decode((uint16_t)fuzz_u32(b), back);
    is_unit(back, 3, "normal of a code");
}

static void colours(fuzz_bytes* b) {
    float x[3], back[3];
    uint32_t packed;
    uint16_t half;
    int i;
    fuzz_floats(b, x, 3);
    packed = dgb_r11g11b10f_pack(x);
    dgb_r11g11b10f_unpack(packed, back);
    for (i = 0; i < 3; ++i) {
        in_range(dgb_storable(x[i]), 0.0f, 64512.0f, "storable");
        in_range(back[i], 0.0f, 64512.0f, "R11G11B10F");
    }
    if (dgb_r11g11b10f_pack(back) != packed) fail_msg("%08x is not what it unpacks to", (unsigned)packed);
    in_range(dgb_half_to_float(dgb_half_from_float(x[0])), -65504.0f, 65504.0f, "half");
    if (isnan(x[0]) && dgb_half_from_float(x[0]) != 0) fail_msg("half of NaN");
    half = (uint16_t)fuzz_u32(b);
    if (isfinite(dgb_half_to_float(half)) && dgb_half_from_float(dgb_half_to_float(half)) != half)
        fail_msg("the half %04x is not what it unpacks to", half);
}

static void taps(fuzz_bytes* b) {
    const int i = fuzz_int(b), n = fuzz_int(b), x = fuzz_int(b), y = fuzz_int(b), frame = fuzz_int(b);
    float tap[3];
    dgb_spiral_tap(i, n, tap);
    is_unit(tap, 2, "direction of a tap");
    in_range(tap[2], 0.0f, 1.0f, "distance of a tap");
    if (dgb_spiral_turns(n) < 0 || (n < 1) != (dgb_spiral_turns(n) == 0)) fail_msg("%d turns", dgb_spiral_turns(n));
    dgb_rotation(i, tap);
    is_unit(tap, 2, "rotation");
    in_range((float)dgb_pixel_hash(x, y, frame), 0.0f, 255.0f, "hash");
    dgb_pixel_pair(x, y, frame, tap);
    if (!(tap[0] > 0.0f && tap[0] < 1.0f && tap[1] > 0.0f && tap[1] < 1.0f)) fail_msg("pair on the border");
}

static void levels(fuzz_bytes* b) {
    const int low = fuzz_byte(b) % DGB_MAX_LEVELS, log2_q = fuzz_byte(b) % 16;
    const int width = fuzz_int(b), height = fuzz_int(b), level = fuzz_byte(b) % DGB_MAX_LEVELS;
    int p[2], source[2], i, count;
    in_range((float)dgb_mip_level(fuzz_float(b), log2_q, low, DGB_MAX_LEVELS - 1), (float)low, DGB_MAX_LEVELS - 1,
             "level");
    count = dgb_mip_levels(width < 1 ? 1 : width, height < 1 ? 1 : height);
    in_range((float)count, 1.0f, DGB_MAX_LEVELS, "levels");
    for (i = 0; i < 2; ++i) p[i] = (int)(fuzz_u32(b) % (uint32_t)(DGB_MAX_SIZE >> level));
    dgb_mip_source(p, level, source);
    for (i = 0; i < 2; ++i)
        in_range((float)source[i], (float)(p[i] << level), (float)(((p[i] + 1) << level) - 1), "source");
}

static void cameras(fuzz_bytes* b) {
    const bool reversed = fuzz_bool(b);
    dgb_view view = fuzz_view(b, reversed);
    const dgb_clip clip = (dgb_clip)(fuzz_byte(b) % DGB_CLIP_COUNT);
    const int width = 1 + fuzz_byte(b), height = 1 + fuzz_byte(b), guard = fuzz_byte(b);
    dgb_camera camera, before;
    float widened[16], pixel[2], point[3], z;
    memset(&camera, 0x5a, sizeof camera);
    memcpy(&before, &camera, sizeof before);
    dgb_widen_projection(view.projection, width, height, guard, view.jitter, widened);
    if (dgb_camera_from_matrix(widened, width + 2 * guard, height + 2 * guard, clip, reversed, &camera) != DGB_OK) {
        if (!same_bits(&camera, &before, sizeof camera)) fail_msg("a refused matrix has changed the camera");
        return;
    }
    all_finite(camera.linearise, 4, "linearise");
    all_finite(camera.position_z, 4, "position_z");
    all_finite(camera.position_1, 4, "position_1");
    all_finite(camera.footprint, 4, "footprint");
    z = dgb_linear_z(fuzz_float(b), &camera);
    in_range(z, -DGB_MAX_DISTANCE, DGB_MAX_DISTANCE, "z");
    if (view.projection[11] < 0.0f) in_range(z, -DGB_MAX_DISTANCE, 0.0f, "z of a perspective");
    fuzz_floats(b, pixel, 2);
    dgb_position(pixel[0], pixel[1], z, &camera, point); /* promises nothing of pixels far outside */
    z = dgb_pixels_per_metre(fuzz_float(b), &camera);
    if (!(z >= 0.0f)) fail_msg("%g pixels a metre", (double)z);
    z = fuzz_float(b);
    if (!isnan(z)) in_range(dgb_depth_code(z < 0.0f || z > 1.0f ? 0.5f : z, 16777215.0f), 0.0f, 1.0f, "depth code");
}

static void terms(fuzz_bytes* b) {
    const int count = fuzz_int(b);
    const bool flag = fuzz_bool(b);
    float v[3], n[3], n2[3], x[3];
    bool keeps;
    int i;
    fuzz_floats(b, v, 3);
    fuzz_floats(b, n, 3);
    fuzz_floats(b, n2, 3);
    fuzz_floats(b, x, 3);
    keeps = dgb_keep_test(x[0], x[1], x[2]);
    if (keeps && (x[1] == 0.0f || isnan(x[0]) || isnan(x[1]) || isnan(x[2]))) fail_msg("kept behind nothing");
    for (i = 0; i < 3; ++i) x[i] = fabsf(x[i]);
    if (!(dgb_ao_term(v, n, x[0], x[1], x[2]) >= 0.0f)) fail_msg("occlusion below 0, or none");
    in_range(dgb_ambient_visibility(x[0], count), 0.0f, 1.0f, "visibility");
    if (!(dgb_gather_term(v, n, n2, x[0], flag) >= 0.0f)) fail_msg("cosine below 0, or none");
    in_range(dgb_gather_scale(x[0], count, flag ? 1.0f : 0.0f), 0.0f, 6.2832f, "scale");
    in_range(dgb_boost(v, 1.0f, 2.0f), 1.0f, 2.0f, "boost");
    x[2] = dgb_bilateral_weight(n, n2, v, x[0], x[1]);
    if (!(x[2] >= 0.0f) || !isfinite(x[2])) fail_msg("weight %g", (double)x[2]);
}

/* A unit vector from three numbers; the axes where they give none. */
static void unit(const float x[3], float n[3]) { dgb_oct16_decode(dgb_oct16_encode(x), n); }

static void sectors(fuzz_bytes* b) {
    float x[9], n[3], v[3], along[3], slice[4];
    uint32_t mask;
    int i, count = 0;
    fuzz_floats(b, x, 9);
    unit(x, n);
    unit(x + 3, v);
    dgb_slice_along(n, v, x + 6, along);
    is_unit(along, 3, "along");
    dgb_slice(n, v, along, slice);
    all_finite(slice, 4, "slice");
    in_range(dgb_slice_share(slice, x), 0.0f, 1.0f, "share");
    in_range(dgb_arc_sine(isnan(x[0]) ? 0.0f : x[0]), -1.5708f, 1.5708f, "arc sine");
    mask = dgb_sectors(x[0], x[1], x[2]);
    for (i = 0; i < 32; ++i) count += (int)(mask >> i & 1u);
    if (dgb_sector_count(mask) != count) fail_msg("%d sectors are counted as %d", count, dgb_sector_count(mask));
}

static void lobes(fuzz_bytes* b) {
    float x[12], v[3], n[3], l[3], h[3], alpha, density;
    fuzz_floats(b, x, 12);
    unit(x, v);
    unit(x + 3, n);
    unit(x + 6, l);
    alpha = dgb_ggx_alpha(x[9]);
    in_range(alpha, 0.0f, 1.0f, "alpha");
    dgb_ggx_normal(v, n, alpha, x + 10, h);
    is_unit(h, 3, "microfacet");
    dgb_ggx_normal(x, x + 3, x[9], x + 10, h);
    all_finite(h, 3, "microfacet");
    density = dgb_ggx_density(v, n, l, x[9]);
    if (!(density >= 0.0f) || !isfinite(density)) fail_msg("density %g", (double)density);
    density = dgb_ggx_density(x, x + 3, x + 6, x[9]);
    if (!(density >= 0.0f) || !isfinite(density)) fail_msg("density %g", (double)density);
}

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size);
int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
    static void (*const parts[])(fuzz_bytes*) = {normals, colours, taps, levels, cameras, terms, sectors, lobes};
    fuzz_bytes b = {bytes, bytes + size};
    parts[fuzz_byte(&b) % (sizeof parts / sizeof parts[0])](&b);
    return 0;
}
