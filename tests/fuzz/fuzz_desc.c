/* Any desc, on any device: refused with a sentence, or planned, created, run for two frames, resized and destroyed. */
#include "fuzz.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <string.h>

static bool has_texture(const dgb_plan* plan, dgb_slot slot) {
    int i;
    for (i = 0; i < plan->texture_count; ++i)
        if (plan->textures[i].slot == slot) return true;
    return slot >= DGB_ENGINE_DEPTH0 && slot <= DGB_ENGINE_ROUGHNESS; /* the engine brings them */
}

static void check_textures(const dgb_plan* plan) {
    uint64_t bytes = 0;
    int i;
    for (i = 0; i < plan->texture_count; ++i) {
        const dgb_texture_desc* t = &plan->textures[i];
        if (t->width < 1 || t->width > DGB_MAX_SIZE || t->height < 1 || t->height > DGB_MAX_SIZE || t->layers < 0 ||
            t->layers > DGB_MAX_LAYERS || t->levels < 1 || t->levels > DGB_MAX_LEVELS || !t->bytes)
            fail_msg("%s: %dx%d, %d layers, %d levels", dgb_slot_name(t->slot), t->width, t->height, t->layers,
                     t->levels);
        bytes += t->bytes;
    }
    if (bytes != plan->bytes) fail_msg("the bytes of the textures do not add up");
}

static void check_passes(const dgb_plan* plan) {
    int i, j;
    for (i = 0; i < plan->pass_count; ++i) {
        const dgb_plan_pass* pass = &plan->passes[i];
        if (pass->program < -1 || pass->program >= plan->program_count) fail_msg("program %d", pass->program);
        for (j = 0; j < pass->input_count; ++j)
            if (!has_texture(plan, pass->inputs[j].texture))
                fail_msg("%s reads %s, which the plan lacks", dgb_pass_name(pass->id),
                         dgb_slot_name(pass->inputs[j].texture));
        for (j = 0; j < pass->output_count; ++j)
            if (!has_texture(plan, pass->outputs[j]))
                fail_msg("%s writes %s, which the plan lacks", dgb_pass_name(pass->id),
                         dgb_slot_name(pass->outputs[j]));
    }
}

/* Returns whether the desc was taken; *plan, all bytes of which were the same, is untouched if not. */
static bool check_plan(fuzz_device* d, const dgb_desc* desc, dgb_plan* plan) {
    dgb_plan before;
    memset(plan, 0x5a, sizeof *plan);
    memcpy(&before, plan, sizeof before);
    if (fuzz_check(d, dgb_make_plan(desc, plan))) {
        check_textures(plan);
        check_passes(plan);
        return true;
    }
    if (!same_bits(plan, &before, sizeof before)) fail_msg("a refused desc has changed the plan");
    return false;
}

static void run_frames(fuzz_device* d) {
    const dgb_params params = dgb_preset(DGB_PRESET_BALANCED);
    const dgb_view view = fuzz_default_view(d->context.desc.reversed);
    int i;
    for (i = 0; i < 2; ++i) {
        if (!fuzz_check(d, fuzz_layers(d, &view, &params))) fail_msg("a good view is refused");
        if (!fuzz_check(d, dgb_shade(&d->context, &params))) fail_msg("good parameters are refused");
        fuzz_check_uniforms(d);
    }
}

static void limit_device(fuzz_bytes* b, dgb_caps* caps) {
    int i;
    caps->max_size = fuzz_int(b);
    caps->max_layers = fuzz_int(b);
    caps->clip_zero_to_one = fuzz_bool(b);
    caps->deep_viewport = fuzz_bool(b);
    caps->preferred = (dgb_emission)fuzz_int(b);
    for (i = 0; i < DGB_EMISSION_COUNT; ++i) caps->emission[i] = fuzz_bool(b);
}

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size);
int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
    static fuzz_device d;
    static dgb_plan plan;
    fuzz_bytes b = {bytes, bytes + size};
    dgb_desc desc = fuzz_desc(&b);
    const int width = fuzz_int(&b), height = fuzz_int(&b);
    dgb_context before;
    bool planned;
    fuzz_start(&d, &desc);
    if (fuzz_bool(&b)) limit_device(&b, &d.r.backend.caps);
    planned = check_plan(&d, &desc, &plan);
    memcpy(&before, &d.context, sizeof before);
    if (fuzz_check_refusal(&d, dgb_init(&d.context, &desc), &before) != planned) fail_msg("plan and init disagree");
    if (planned) {
        if (!same_bits(&plan, &d.context.plan, sizeof plan)) fail_msg("init follows another plan");
        run_frames(&d);
        memcpy(&before, &d.context, sizeof before);
        if (fuzz_check_refusal(&d, dgb_resize(&d.context, width, height), &before)) run_frames(&d);
    }
    fuzz_stop(&d);
    return 0;
}
