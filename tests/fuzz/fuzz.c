#include "fuzz.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <string.h>

/* >> fields from bytes */

uint8_t fuzz_byte(fuzz_bytes* b) { return b->next < b->end ? *b->next++ : 0; }

bool fuzz_bool(fuzz_bytes* b) { return fuzz_byte(b) & 1u; }

static uint32_t take(fuzz_bytes* b, int count) {
    uint32_t u = 0;
    int i;
    for (i = 0; i < count; ++i) u |= (uint32_t)fuzz_byte(b) << (8 * i);
    return u;
}

uint32_t fuzz_u32(fuzz_bytes* b) { return take(b, 4); }

/* One byte tells 0..223 and -1..-16 by itself; else so many bytes follow. */
int fuzz_int(fuzz_bytes* b) {
    const int first = fuzz_byte(b);
    if (first < 224) return first;
    if (first < 240) return 223 - first;
    return first < 248 ? (int)take(b, 2) : (int)take(b, 4);
}

float fuzz_float(fuzz_bytes* b) {
    const uint32_t u = fuzz_u32(b);
    float x;
    memcpy(&x, &u, sizeof x);
    return x;
}

void fuzz_floats(fuzz_bytes* b, float* x, int count) {
    int i;
    for (i = 0; i < count; ++i) x[i] = fuzz_float(b);
}

void fuzz_some_floats(fuzz_bytes* b, float* x, int count) {
    int changes = fuzz_byte(b) & 7;
    while (changes-- > 0) {
        const int i = fuzz_byte(b) % count;
        x[i] = fuzz_float(b);
    }
}

dgb_desc fuzz_desc(fuzz_bytes* b) {
    dgb_desc d;
    memset(&d, 0, sizeof d);
    d.width = fuzz_int(b);
    d.height = fuzz_int(b);
    d.guard_band = fuzz_int(b);
    d.layers = fuzz_int(b);
    d.divisor = fuzz_int(b);
    d.effects = (uint32_t)fuzz_int(b);
    d.targets = (uint32_t)fuzz_int(b);
    d.source = (dgb_source)fuzz_int(b);
    d.oracle = (dgb_oracle)fuzz_int(b);
    d.emission = (dgb_emission)fuzz_int(b);
    d.depth_format = (dgb_format)fuzz_int(b);
    d.clip = (dgb_clip)fuzz_int(b);
    d.reversed = fuzz_bool(b);
    d.normals = (dgb_normals)fuzz_int(b);
    d.world_normals = fuzz_bool(b);
    d.senders = (dgb_senders)fuzz_int(b);
    d.normaliser = (dgb_normaliser)fuzz_int(b);
    d.tracer = (dgb_tracer)fuzz_int(b);
    d.estimator = (dgb_estimator)fuzz_int(b);
    return d;
}

/* Every number of the params, in their order; the flags are read before. */
static void change_param(fuzz_bytes* b, dgb_params* p) {
    float* const floats[] = {&p->separation,        &p->guard_fraction,    &p->ao_radius,        &p->ao_bias,
                             &p->ao_epsilon,        &p->ao_intensity,      &p->radius,           &p->thickness,
                             &p->bounce_damping,    &p->boost_unsaturated, &p->boost_saturated,  &p->history_weight,
                             &p->history_tolerance, &p->history_floor,     &p->normal_sharpness, &p->plane_sharpness,
                             &p->reflect_distance,  &p->reflect_thickness, &p->reflect_border,   &p->glossy_radius};
    int* const ints[] = {&p->ao_samples,  &p->ao_min_level, &p->samples,       &p->min_level,      &p->slices,
                         &p->filter_taps, &p->filter_step,  &p->reflect_steps, &p->reflect_stride, &p->glossy_taps};
    const size_t float_count = sizeof floats / sizeof floats[0], int_count = sizeof ints / sizeof ints[0];
    const size_t i = fuzz_byte(b) % (float_count + int_count);
    if (i < float_count)
        *floats[i] = fuzz_float(b);
    else
        *ints[i - float_count] = fuzz_int(b);
}

dgb_params fuzz_params(fuzz_bytes* b) {
    dgb_params p = dgb_preset(DGB_PRESET_BALANCED);
    int changes = fuzz_byte(b) & 15;
    p.strict_separation = fuzz_bool(b);
    p.normal_test = fuzz_bool(b);
    p.second_alone = fuzz_bool(b);
    p.adaptive = fuzz_bool(b);
    while (changes-- > 0) change_param(b, &p);
    return p;
}

/* 90 degrees, 0.1 m to 100 m, at the origin. */
dgb_view fuzz_default_view(bool reversed) {
    const float nearer = reversed ? 100.0f : 0.1f, farther = reversed ? 0.1f : 100.0f;
    dgb_view v;
    memset(&v, 0, sizeof v);
    v.view[0] = v.view[5] = v.view[10] = v.view[15] = 1.0f;
    memcpy(v.next_view, v.view, sizeof v.view);
    v.projection[0] = 0.75f;
    v.projection[5] = 1.0f;
    v.projection[10] = -(farther + nearer) / (farther - nearer);
    v.projection[11] = -1.0f;
    v.projection[14] = -2.0f * farther * nearer / (farther - nearer);
    return v;
}

dgb_view fuzz_view(fuzz_bytes* b, bool reversed) {
    dgb_view v = fuzz_default_view(reversed);
    v.cut = fuzz_bool(b);
    v.has_next = fuzz_bool(b);
    fuzz_some_floats(b, v.view, 16);
    fuzz_some_floats(b, v.projection, 16);
    fuzz_some_floats(b, v.jitter, 2);
    fuzz_some_floats(b, v.next_view, 16);
    return v;
}

/* >> a context on the recording backend */

static void on_log(void* user, dgb_result result, dgb_log_item item, const char* sentence) {
    fuzz_device* d = (fuzz_device*)user;
    d->logged = result;
    ++d->logs;
    if (item == DGB_LOG_NONE || dgb_log_item_name(item)[0] == '?') fail_msg("log item %d", (int)item);
    if (!sentence || !sentence[0]) fail_msg("%s has no sentence", dgb_log_item_name(item));
}

/* As large as one texel: nothing here reads them. */
static dgb_layers engine_layers(record_backend* r) {
    dgb_layers l;
    int i;
    for (i = 0; i < DGB_MAX_SHADED_LAYERS; ++i) {
        l.depth[i] = record_engine_texture(r, i ? DGB_ENGINE_DEPTH1 : DGB_ENGINE_DEPTH0, 1, 1);
        l.normal[i] = record_engine_texture(r, i ? DGB_ENGINE_NORMAL1 : DGB_ENGINE_NORMAL0, 1, 1);
        l.radiance[i] = record_engine_texture(r, i ? DGB_ENGINE_RADIANCE1 : DGB_ENGINE_RADIANCE0, 1, 1);
        l.albedo[i] = record_engine_texture(r, i ? DGB_ENGINE_ALBEDO1 : DGB_ENGINE_ALBEDO0, 1, 1);
        l.velocity[i] = record_engine_texture(r, i ? DGB_ENGINE_VELOCITY1 : DGB_ENGINE_VELOCITY0, 1, 1);
    }
    l.roughness = record_engine_texture(r, DGB_ENGINE_ROUGHNESS, 1, 1);
    return l;
}

void fuzz_start(fuzz_device* d, dgb_desc* desc) {
    memset(&d->context, 0, sizeof d->context);
    d->logs = 0;
    record_start(&d->r);
    d->layers = engine_layers(&d->r);
    desc->backend = &d->r.backend;
    desc->log = on_log;
    desc->log_user = d;
}

bool fuzz_check(fuzz_device* d, dgb_result result) {
    if (d->logs != (result != DGB_OK)) fail_msg("%s with %d sentences", dgb_result_name(result), d->logs);
    if (d->logs && d->logged != result)
        fail_msg("%s is logged as %s", dgb_result_name(result), dgb_result_name(d->logged));
    d->logs = 0;
    return result == DGB_OK;
}

bool fuzz_check_refusal(fuzz_device* d, dgb_result result, const dgb_context* before) {
    if (result != DGB_OK && !same_bits(&d->context, before, sizeof *before))
        fail_msg("%s, but the context has changed", dgb_result_name(result));
    return fuzz_check(d, result);
}

static void check_finite(const float* x, int count, const char* what) {
    int i;
    for (i = 0; i < count; ++i)
        if (!isfinite(x[i])) fail_msg("%s[%d] is %g", what, i, (double)x[i]);
}

static void on_draw(void* user, const dgb_draw* draw) {
    const fuzz_device* d = (const fuzz_device*)user;
    const dgb_plan* plan = &d->context.plan;
    if (draw->first_layer < 0 || draw->layer_count < 1 || draw->first_layer + draw->layer_count > plan->layers)
        fail_msg("layers %d+%d of %d", draw->first_layer, draw->layer_count, plan->layers);
    if (draw->instances < 1 || draw->instances > plan->layers) fail_msg("%d instances", draw->instances);
    if (draw->width != plan->width || draw->height != plan->height) fail_msg("%dx%d", draw->width, draw->height);
    check_finite(draw->view, 16, "view");
    check_finite(draw->projection, 16, "projection");
    check_finite(draw->previous_view, 16, "previous_view");
    check_finite(draw->previous_projection, 16, "previous_projection");
}

dgb_result fuzz_layers(fuzz_device* d, const dgb_view* view, const dgb_params* params) {
    if (d->context.desc.source == DGB_SOURCE_ENGINE) return dgb_set_layers(&d->context, view, &d->layers);
    return dgb_build(&d->context, view, params, on_draw, d);
}

/* Uniform blocks hold floats and small integers: as bits, numbers up to 2^16 of either sign are no float that is not
   finite, but for NaNs that no arithmetic makes. */
void fuzz_check_uniforms(fuzz_device* d) {
    int i;
    for (i = 0; i < d->r.uniform_count; ++i) {
        const record_uniforms* u = &d->r.uniforms[i];
        size_t word;
        for (word = 0; word < sizeof u->u / 4; ++word) {
            int32_t bits;
            float x;
            memcpy(&bits, (const char*)&u->u + 4 * word, sizeof bits);
            memcpy(&x, &bits, sizeof x);
            if (!isfinite(x) && (bits < -65536 || bits > 65536))
                fail_msg("word %u of the uniforms of %s is %g", (unsigned)word, dgb_pass_name(u->pass), (double)x);
        }
    }
    record_clear(&d->r);
}

void fuzz_stop(fuzz_device* d) {
    dgb_shutdown(&d->context);
    if (record_alive(&d->r)) fail_msg("%d objects are left", record_alive(&d->r));
    if (d->r.begins != d->r.ends) fail_msg("%d begins, %d ends", d->r.begins, d->r.ends);
    record_stop(&d->r);
}
