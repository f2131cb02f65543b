/* Any parameters, for all effects: refused with a sentence and no change, or shaded with finite numbers. */
#include "fuzz.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <string.h>

static dgb_desc every_effect(fuzz_bytes* b) {
    dgb_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.width = 64;
    desc.height = 48;
    desc.guard_band = 8;
    desc.layers = 1 + fuzz_byte(b) % 2;
    desc.source = (dgb_source)(fuzz_byte(b) % 2);
    desc.effects = DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY | DGB_EFFECT_BOUNCES | DGB_EFFECT_TEMPORAL |
                   DGB_EFFECT_REFLECT | DGB_EFFECT_GLOSSY;
    desc.tracer = (dgb_tracer)(fuzz_byte(b) % DGB_TRACER_COUNT);
    desc.estimator = (dgb_estimator)(fuzz_byte(b) % DGB_ESTIMATOR_COUNT);
    return desc;
}

/* Every preset shades, for any budget: none is refused. */
static dgb_params any_preset(fuzz_bytes* b) {
    const bool named = fuzz_bool(b);
    const uint32_t which = fuzz_u32(b);
    return named ? dgb_preset((dgb_preset_id)which) : dgb_preset_for(fuzz_float(b), which);
}

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size);
int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
    static fuzz_device d;
    fuzz_bytes b = {bytes, bytes + size};
    dgb_desc desc = every_effect(&b);
    const dgb_view view = fuzz_default_view(desc.reversed);
    int frame;
    fuzz_start(&d, &desc);
    if (!fuzz_check(&d, dgb_init(&d.context, &desc))) fail_msg("a good desc is refused");
    for (frame = 0; frame < 3; ++frame) {
        const bool changed = fuzz_bool(&b);
        const dgb_params params = changed ? fuzz_params(&b) : any_preset(&b);
        dgb_context before;
        bool taken;
        memcpy(&before, &d.context, sizeof before);
        taken = fuzz_check_refusal(&d, fuzz_layers(&d, &view, &params), &before);
        if (!taken && !changed) fail_msg("a preset is refused");
        if (taken || d.context.has_layers) {
            memcpy(&before, &d.context, sizeof before);
            fuzz_check_refusal(&d, dgb_shade(&d.context, &params), &before);
        }
        fuzz_check_uniforms(&d);
    }
    fuzz_stop(&d);
    return 0;
}
