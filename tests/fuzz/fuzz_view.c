/* Any views, a frame each, under every construction: refused with a sentence and no change, or drawn with finite numbers. */
#include "fuzz.h"

#include <string.h>

/* Small, with whatever oracle, emission and effects the desc allows. */
static dgb_desc valid_desc(fuzz_bytes* b) {
    dgb_desc desc;
    dgb_plan plan;
    memset(&desc, 0, sizeof desc);
    desc.width = 64;
    desc.height = 48;
    desc.guard_band = 8;
    desc.reversed = fuzz_bool(b);
    desc.source = (dgb_source)(fuzz_byte(b) % 2);
    desc.effects = fuzz_byte(b) & 63u;
    desc.oracle = (dgb_oracle)(fuzz_byte(b) % DGB_ORACLE_COUNT);
    desc.emission = (dgb_emission)(fuzz_byte(b) % DGB_EMISSION_COUNT);
    desc.estimator = (dgb_estimator)(fuzz_byte(b) % DGB_ESTIMATOR_COUNT);
    desc.clip = (dgb_clip)(fuzz_byte(b) % DGB_CLIP_COUNT);
    if (dgb_make_plan(&desc, &plan) != DGB_OK) desc.emission = DGB_EMISSION_AUTO, desc.oracle = DGB_ORACLE_DEFAULT;
    if (dgb_make_plan(&desc, &plan) != DGB_OK) desc.effects = DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY;
    return desc;
}

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size);
int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
    static fuzz_device d;
    const dgb_params params = dgb_preset(DGB_PRESET_BALANCED);
    fuzz_bytes b = {bytes, bytes + size};
    dgb_desc desc = valid_desc(&b);
    int frame;
    fuzz_start(&d, &desc);
    if (fuzz_check(&d, dgb_init(&d.context, &desc))) {
        for (frame = 0; frame < 4; ++frame) {
            const dgb_view view = fuzz_view(&b, desc.reversed);
            dgb_context before;
            memcpy(&before, &d.context, sizeof before);
            if (fuzz_check_refusal(&d, fuzz_layers(&d, &view, &params), &before))
                fuzz_check(&d, dgb_shade(&d.context, &params));
            fuzz_check_uniforms(&d);
        }
    }
    fuzz_stop(&d);
    return 0;
}
