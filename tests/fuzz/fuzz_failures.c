/* A context's life, call after call, on a device whose n-th create fails: all or nothing, at any point. */
#include "fuzz.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <string.h>

enum {
    MAX_CALLS = 6
}; /* that many plans, not all of which create programs, have fewer than RECORD_MAX_OBJECTS objects */

/* What a create answers when it fails: an error, or success without a handle, which counts as DGB_DEVICE. */
static void plan_failure(fuzz_bytes* b, record_backend* r) {
    r->creates = 0;
    r->fail_at = fuzz_byte(b) & 31;
    r->fail_with = (dgb_result)(fuzz_byte(b) % (DGB_DEVICE + 1));
}

/* Whether the failure that was planned has come, and the result is that. */
static void check_failure(const record_backend* r, dgb_result result) {
    const bool failed = r->fail_at && r->creates >= r->fail_at;
    const dgb_result expected = r->fail_with == DGB_OK ? DGB_DEVICE : r->fail_with;
    if (failed && result != expected) fail_msg("create %d fails, the call: %s", r->fail_at, dgb_result_name(result));
    if (failed && r->creates > r->fail_at) fail_msg("it goes on after create %d has failed", r->fail_at);
}

static void one_call(fuzz_device* d, fuzz_bytes* b, const dgb_desc* desc) {
    const dgb_params params = dgb_preset(DGB_PRESET_BALANCED);
    const dgb_view view = fuzz_default_view(desc->reversed);
    const bool is_live = d->context.initialised != 0, has_layers = d->context.has_layers;
    const int alive = record_alive(&d->r);
    int size;
    dgb_context before;
    dgb_result result = DGB_OK;
    memcpy(&before, &d->context, sizeof before);
    plan_failure(b, &d->r);
    switch (fuzz_byte(b) % 5) {
    case 0:
        if (!is_live) result = dgb_init(&d->context, desc);
        break;
    case 1:
        size = fuzz_byte(b);
        if (is_live) result = dgb_resize(&d->context, size, size);
        break;
    case 2:
        if (is_live) result = fuzz_layers(d, &view, &params);
        break;
    case 3:
        if (is_live && has_layers) result = dgb_shade(&d->context, &params);
        break;
    default: dgb_shutdown(&d->context); break;
    }
    check_failure(&d->r, result);
    if (!fuzz_check_refusal(d, result, &before) && record_alive(&d->r) != alive)
        fail_msg("%d objects before a call that failed, %d after", alive, record_alive(&d->r));
    fuzz_check_uniforms(d);
}

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size);
int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
    static fuzz_device d;
    fuzz_bytes b = {bytes, bytes + size};
    dgb_desc desc;
    int i;
    memset(&desc, 0, sizeof desc);
    desc.width = 64;
    desc.height = 48;
    desc.source = (dgb_source)(fuzz_byte(&b) % 2);
    desc.effects = fuzz_byte(&b) & 63u;
    fuzz_start(&d, &desc);
    for (i = 0; i < MAX_CALLS; ++i) one_call(&d, &b, &desc);
    fuzz_stop(&d);
    return 0;
}
