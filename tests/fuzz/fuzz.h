/* What the fuzz targets share. A target is a function of bytes, LLVMFuzzerTestOneInput: under libFuzzer (`make fuzz`) they are
   found, under driver.c they come from files. Fields are read one by one, never whole structs: pointers are the target's.
   What must hold is asserted with cmocka, whose failure ends the program. */
#ifndef FUZZ_H
#define FUZZ_H

#include "numbers.h"
#include "record_backend.h"

/* >> fields from bytes; after the last all are 0 */

typedef struct fuzz_bytes {
    const uint8_t* next;
    const uint8_t* end;
} fuzz_bytes;

uint8_t fuzz_byte(fuzz_bytes* b);
bool fuzz_bool(fuzz_bytes* b);
uint32_t fuzz_u32(fuzz_bytes* b);
int fuzz_int(fuzz_bytes* b);     /* mostly small, of either sign; any in the end */
float fuzz_float(fuzz_bytes* b); /* any 32 bits */
void fuzz_floats(fuzz_bytes* b, float* x, int count);
/* Replaces a few of the numbers, so that what was valid is nearly so. */
void fuzz_some_floats(fuzz_bytes* b, float* x, int count);

/* Without backend and log. */
dgb_desc fuzz_desc(fuzz_bytes* b);
/* BALANCED, with a few fields replaced. */
dgb_params fuzz_params(fuzz_bytes* b);
/* A perspective view, with a few numbers replaced. */
dgb_view fuzz_view(fuzz_bytes* b, bool reversed);
dgb_view fuzz_default_view(bool reversed);

/* >> a context on the recording backend */

typedef struct fuzz_device {
    record_backend r;
    dgb_layers layers; /* the engine's own */
    dgb_context context;
    int logs; /* since the last fuzz_check */
    dgb_result logged;
} fuzz_device;

/* Points desc at the device. */
void fuzz_start(fuzz_device* d, dgb_desc* desc);
/* One sentence if the call failed, of that result; none if it did not. Returns whether it succeeded. */
bool fuzz_check(fuzz_device* d, dgb_result result);
/* Likewise; and a refused call changes nothing. */
bool fuzz_check_refusal(fuzz_device* d, dgb_result result, const dgb_context* before);
/* dgb_build or dgb_set_layers, whichever the context was made for. */
dgb_result fuzz_layers(fuzz_device* d, const dgb_view* view, const dgb_params* params);
/* All that was uploaded is finite. Forgets the uploads. */
void fuzz_check_uniforms(fuzz_device* d);
/* Shuts down; nothing may be left. */
void fuzz_stop(fuzz_device* d);

#endif
