/* A backend that needs no GPU: it hands out ids, checks the protocol and writes down what it was told.

   Every rule of "WRITING A BACKEND" in deepgbuffer.h that the library must keep is asserted (with cmocka) at
   the call that breaks it: nothing outside a frame or a pass, only live objects, no texture read and written
   at once, viewports inside their targets, uniform structs of the right size. What remains is text, to be
   compared with golden files. */

#ifndef RECORD_BACKEND_H
#define RECORD_BACKEND_H

#include "deepgbuffer.h"

/* >> text */

typedef struct record_text {
    char* data; /* zero-terminated; null when empty */
    size_t size, capacity;
} record_text;

#if defined(__GNUC__)
__attribute__((format(printf, 2, 3)))
#endif
void record_printf(record_text* text, const char* format, ...);
void record_text_clear(record_text* text); /* keeps the memory */
void record_text_free(record_text* text);

/* Compares with the lines of tests/backends/<name>; fails at the first that differs and says under which `==`
   heading. With DGB_BLESS=1 in the environment it writes the file instead. Run from the top of the
   repository. */
void record_check_golden(const char* name, const record_text* text);

/* "ao+radiosity", "none"; good until the next call. */
const char* record_effect_names(uint32_t effects);

/* "pack{DGB_LAYERS=2,DGB_NORMALS_FORMAT=1}" */
void record_print_program(record_text* text, const dgb_program_desc* program);

/* >> backend */

#define RECORD_MAX_OBJECTS 256
#define RECORD_MAX_UNIFORMS 32
#define RECORD_CALLBACKS 9 /* that a backend must have */

typedef struct record_object {
    uint64_t id;
    bool alive;
    bool is_program;
    bool engine; /* not created through the backend: not the library's to destroy */
    dgb_texture_desc texture;
    dgb_program_desc program;
    float first_pixels[2]; /* of the contents given at creation */
} record_object;

typedef struct record_uniforms {
    dgb_pass_id pass;
    union {
        dgb_draw_uniforms draw; /* LAYERS, BACK and PREDICT */
        dgb_warp_uniforms warp;
        int32_t resolve[4];
        dgb_pack_uniforms pack;
        dgb_tiles_uniforms tiles;
        dgb_ao_uniforms ao;
        dgb_gather_uniforms gather;
        dgb_bitmask_uniforms bitmask; /* AO and GATHER of DGB_ESTIMATOR_BITMASK */
        dgb_temporal_uniforms temporal;
        dgb_reconstruct_uniforms reconstruct;
        dgb_reflect_uniforms reflect;
        dgb_glossy_uniforms glossy;
    } u;
} record_uniforms;

typedef struct record_backend {
    dgb_backend backend; /* for desc.backend; may be changed before dgb_init */
    record_text trace;
    int creates;          /* calls of texture_create and program_create */
    int fail_at;          /* the create call, from 1, that fails; 0: none */
    dgb_result fail_with; /* DGB_OK: report success, but give no handle */
    int passes;           /* calls of pass_begin */
    int fail_pass_at;     /* the call of pass_begin, from 1, that fails with fail_with; 0: none */
    dgb_result end_with;  /* what `end` tells */
    int begins, ends;     /* calls */
    record_object objects[RECORD_MAX_OBJECTS];
    int object_count;
    bool in_pass;
    dgb_pass pass;
    int bind_count;
    dgb_slot bound[DGB_MAX_INPUTS];
    dgb_texture bound_textures[DGB_MAX_INPUTS];
    record_uniforms uniforms[RECORD_MAX_UNIFORMS]; /* in the order of upload */
    int uniform_count;
} record_backend;

/* A device that can do everything. */
void record_start(record_backend* r);
void record_stop(record_backend* r);                        /* frees the trace */
void record_clear(record_backend* r);                       /* forgets trace and uniforms, keeps the objects */
void record_drop_callback(record_backend* r, int callback); /* 0..RECORD_CALLBACKS-1 becomes null */

int record_alive(const record_backend* r); /* objects of the library that are alive */
bool record_is_alive(const record_backend* r, dgb_texture texture);
dgb_texture record_engine_texture(record_backend* r, dgb_slot slot, int width, int height);

/* Name of the texture as it was created ("depth"), whatever slot it is in now; "none" for no texture. */
const char* record_texture_name(const record_backend* r, dgb_texture texture);
/* The texture bound to a slot of the running pass; id 0 when there is none. */
dgb_texture record_bound(const record_backend* r, dgb_slot slot);

/* The n-th upload, from 0, for that pass since record_clear; fails when there is none. */
const record_uniforms* record_uniforms_of(const record_backend* r, dgb_pass_id pass, int n);

#endif /* RECORD_BACKEND_H */
