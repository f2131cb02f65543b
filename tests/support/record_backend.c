#include "record_backend.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifndef DGB_TEST_DIR
#define DGB_TEST_DIR "tests"
#endif

/* >> text */

static void reserve(record_text* text, size_t more) {
    const size_t need = text->size + more + 1;
    char* data;
    if (need <= text->capacity) return;
    text->capacity = need * 2;
    data = (char*)realloc(text->data, text->capacity);
    if (!data) abort();
    text->data = data;
}

void record_printf(record_text* text, const char* format, ...) {
    va_list arguments;
    int length;
    va_start(arguments, format);
    length = vsnprintf(NULL, 0, format, arguments); /* NOLINT: va_start is just above */
    va_end(arguments);
    if (length < 0) abort();
    reserve(text, (size_t)length);
    va_start(arguments, format);
    vsnprintf(text->data + text->size, (size_t)length + 1, format, arguments);
    va_end(arguments);
    text->size += (size_t)length;
}

void record_text_clear(record_text* text) {
    text->size = 0;
    if (text->data) text->data[0] = 0;
}

void record_text_free(record_text* text) {
    free(text->data);
    memset(text, 0, sizeof *text);
}

const char* record_effect_names(uint32_t effects) {
    static const char* const words[] = {"ao", "radiosity", "bounces", "temporal", "reflect", "glossy"};
    static char names[64];
    size_t length = 0, i;
    snprintf(names, sizeof names, "none");
    for (i = 0; i < sizeof words / sizeof words[0]; ++i)
        if (effects >> i & 1u)
            length += (size_t)snprintf(names + length, sizeof names - length, "%s%s", length ? "+" : "", words[i]);
    return names;
}

void record_print_program(record_text* text, const dgb_program_desc* program) {
    int i;
    record_printf(text, "%s{", dgb_pass_name(program->pass));
    for (i = 0; i < program->define_count; ++i)
        record_printf(text, "%s%s=%d", i ? "," : "", program->defines[i].name, program->defines[i].value);
    record_printf(text, "}");
}

/* >> golden files */

static void write_file(const char* path, const record_text* text) {
    FILE* file = fopen(path, "wb");
    if (!file) fail_msg("cannot write %s", path);
    fwrite(text->data, 1, text->size, file);
    if (fclose(file)) fail_msg("cannot write %s", path);
}

static void read_file(const char* path, record_text* text) {
    FILE* file = fopen(path, "rb");
    int c;
    if (!file) fail_msg("cannot read %s: run from the top of the repository; DGB_BLESS=1 writes it", path);
    while ((c = fgetc(file)) != EOF)
        if (c != '\r') record_printf(text, "%c", c);
    fclose(file);
}

static size_t line_length(const char* line) { return strcspn(line, "\n"); }

static const char* next_line(const char* line) {
    const size_t length = line_length(line);
    return line[length] ? line + length + 1 : line + length;
}

static void compare_lines(const char* path, const char* expected, const char* actual) {
    const char* heading = "";
    int line = 1;
    for (; *expected || *actual; ++line, expected = next_line(expected), actual = next_line(actual)) {
        const size_t a = line_length(expected), b = line_length(actual);
        if (actual[0] == '=') heading = actual;
        if (a != b || memcmp(expected, actual, a) != 0)
            fail_msg("%s:%d: under \"%.*s\"\n  expected: %.*s\n  actual:   %.*s", path, line, (int)line_length(heading),
                     heading, (int)a, expected, (int)b, actual);
    }
}

void record_check_golden(const char* name, const record_text* text) {
    const char* bless = getenv("DGB_BLESS");
    record_text expected = {0};
    char path[256];
    snprintf(path, sizeof path, "%s/backends/%s", DGB_TEST_DIR, name);
    if (bless && strcmp(bless, "1") == 0) {
        write_file(path, text);
        return;
    }
    record_printf(&expected, "%s", "");
    read_file(path, &expected);
    compare_lines(path, expected.data, text->data);
    record_text_free(&expected);
}

/* >> objects */

static record_object* find(const record_backend* r, uint64_t id) {
    int i;
    for (i = 0; i < r->object_count; ++i)
        if (r->objects[i].id == id) return (record_object*)&r->objects[i];
    return NULL;
}

static record_object* find_alive(const record_backend* r, uint64_t id, bool is_program, const char* call) {
    record_object* object = find(r, id);
    if (!object || !object->alive || object->is_program != is_program)
        fail_msg("%s: %u is no live %s", call, (unsigned)id, is_program ? "program" : "texture");
    return object;
}

/* Ids of different backends differ, so that a context which mixes them up is found out. */
static uint64_t new_id(const record_backend* r) {
    return (uint64_t)(uintptr_t)r * 1024u + (uint64_t)r->object_count + 1u;
}

static record_object* add_object(record_backend* r) {
    record_object* object = &r->objects[r->object_count];
    if (r->object_count == RECORD_MAX_OBJECTS) fail_msg("more than %d objects", RECORD_MAX_OBJECTS);
    memset(object, 0, sizeof *object);
    object->id = new_id(r);
    object->alive = true;
    ++r->object_count;
    return object;
}

static bool create_fails(record_backend* r) { return ++r->creates == r->fail_at; }

int record_alive(const record_backend* r) {
    int i, alive = 0;
    for (i = 0; i < r->object_count; ++i) alive += r->objects[i].alive && !r->objects[i].engine;
    return alive;
}

bool record_is_alive(const record_backend* r, dgb_texture texture) {
    const record_object* object = find(r, texture.id);
    return object && object->alive;
}

const char* record_texture_name(const record_backend* r, dgb_texture texture) {
    const record_object* object = find(r, texture.id);
    return object ? dgb_slot_name(object->texture.slot) : "none";
}

dgb_texture record_bound(const record_backend* r, dgb_slot slot) {
    dgb_texture none = {0};
    int i;
    for (i = 0; i < r->bind_count; ++i)
        if (r->bound[i] == slot) return r->bound_textures[i];
    return none;
}

dgb_texture record_engine_texture(record_backend* r, dgb_slot slot, int width, int height) {
    record_object* object = add_object(r);
    dgb_texture texture;
    object->engine = true;
    object->texture.slot = slot;
    object->texture.width = width;
    object->texture.height = height;
    object->texture.levels = 1;
    texture.id = object->id;
    return texture;
}

/* >> callbacks: frame and objects */

static record_backend* self(void* user) { return (record_backend*)user; }

static void check_in_frame(const record_backend* r, const char* call) {
    if (r->begins != r->ends + 1) fail_msg("%s outside of begin and end", call);
}

static void on_begin(void* user) {
    record_backend* r = self(user);
    if (r->begins != r->ends) fail_msg("begin inside of begin (%d begins)", r->begins);
    ++r->begins;
}

static dgb_result on_end(void* user) {
    record_backend* r = self(user);
    check_in_frame(r, "end");
    if (r->in_pass) fail_msg("end inside of pass %s", dgb_pass_name(r->pass.id));
    ++r->ends;
    return r->end_with;
}

static dgb_result on_texture_create(void* user, const dgb_texture_desc* desc, dgb_texture* texture) {
    record_backend* r = self(user);
    record_object* object;
    check_in_frame(r, "texture_create");
    if (create_fails(r)) return r->fail_with;
    object = add_object(r);
    object->texture = *desc;
    if (desc->pixels) memcpy(object->first_pixels, desc->pixels, sizeof object->first_pixels);
    object->texture.pixels = NULL; /* valid during the call only */
    texture->id = object->id;
    record_printf(&r->trace, "create %s %s %dx%d", dgb_slot_name(desc->slot), dgb_format_name(desc->format),
                  desc->width, desc->height);
    if (desc->layers) record_printf(&r->trace, " layers %d", desc->layers);
    record_printf(&r->trace, " levels %d%s\n", desc->levels, desc->pixels ? " with pixels" : "");
    return DGB_OK;
}

static void on_texture_destroy(void* user, dgb_texture texture) {
    record_backend* r = self(user);
    record_object* object;
    check_in_frame(r, "texture_destroy");
    object = find_alive(r, texture.id, false, "texture_destroy");
    if (object->engine) fail_msg("the engine's own %s was destroyed", dgb_slot_name(object->texture.slot));
    object->alive = false;
    record_printf(&r->trace, "destroy %s\n", dgb_slot_name(object->texture.slot));
}

static dgb_result on_program_create(void* user, const dgb_program_desc* desc, dgb_program* program) {
    record_backend* r = self(user);
    record_object* object;
    check_in_frame(r, "program_create");
    if (create_fails(r)) return r->fail_with;
    object = add_object(r);
    object->is_program = true;
    object->program = *desc;
    program->id = object->id;
    record_printf(&r->trace, "create ");
    record_print_program(&r->trace, desc);
    record_printf(&r->trace, "\n");
    return DGB_OK;
}

static void on_program_destroy(void* user, dgb_program program) {
    record_backend* r = self(user);
    record_object* object;
    check_in_frame(r, "program_destroy");
    object = find_alive(r, program.id, true, "program_destroy");
    object->alive = false;
    record_printf(&r->trace, "destroy ");
    record_print_program(&r->trace, &object->program);
    record_printf(&r->trace, "\n");
}

/* >> callbacks: passes */

/* "z@2", "albedo@0/all": level, and layer where the texture has layers. */
static void print_target(record_backend* r, const dgb_target* target) {
    const dgb_texture_desc* t = &find_alive(r, target->texture.id, false, "pass_begin")->texture;
    record_printf(&r->trace, " %s@%d", dgb_slot_name(t->slot), target->level);
    if (!t->layers) return;
    if (target->layer < 0)
        record_printf(&r->trace, "/all");
    else
        record_printf(&r->trace, "/%d", target->layer);
}

static void check_target(record_backend* r, const dgb_target* target, const dgb_pass* pass) {
    const dgb_texture_desc* t = &find_alive(r, target->texture.id, false, "pass_begin")->texture;
    const char* name = dgb_slot_name(t->slot);
    if (target->level < 0 || target->level >= t->levels) fail_msg("%s has no level %d", name, target->level);
    if (target->layer < -1 || target->layer >= (t->layers ? t->layers : 1) || (target->layer < 0 && !t->layers))
        fail_msg("%s has no layer %d", name, target->layer);
    if (pass->x < 0 || pass->y < 0 || !(pass->width > 0.0f) || !(pass->height > 0.0f) ||
        (float)pass->x + pass->width > (float)(t->width >> target->level) ||
        (float)pass->y + pass->height > (float)(t->height >> target->level))
        fail_msg("viewport %d %d %g %g leaves %s@%d", pass->x, pass->y, (double)pass->width, (double)pass->height, name,
                 target->level);
}

/* The image that deeper layers compete in, of IMAGE emission: there when all layers are drawn at once, else not. */
static void check_key(const record_backend* r, const dgb_pass* pass) {
    const dgb_texture_desc* t;
    if (!pass->key.id) {
        if (pass->key_layers)
            fail_msg("pass %s has %d key layers and no key", dgb_pass_name(pass->id), pass->key_layers);
        return;
    }
    t = &find_alive(r, pass->key.id, false, "pass_begin")->texture;
    /* the prediction has one layer fewer */
    if ((pass->id != DGB_PASS_LAYERS && pass->id != DGB_PASS_PREDICT) || pass->emission != DGB_EMISSION_IMAGE ||
        t->slot != DGB_KEY || pass->key_layers != t->layers - (pass->id == DGB_PASS_PREDICT) || pass->depth.layer != 0)
        fail_msg("pass %s has %s as key, %d layers of %d", dgb_pass_name(pass->id), dgb_slot_name(t->slot),
                 pass->key_layers, t->layers);
}

/* Layered passes give the deeper layers a viewport of their own, which no pass but those has. */
static void check_deep_viewport(const record_backend* r, const dgb_pass* pass) {
    const dgb_texture_desc* t;
    if (pass->id != DGB_PASS_LAYERS && pass->id != DGB_PASS_BACK && pass->id != DGB_PASS_PREDICT) {
        if (pass->deep_width != 0.0f || pass->deep_height != 0.0f)
            fail_msg("pass %s has a second viewport", dgb_pass_name(pass->id));
        return;
    }
    t = &find_alive(r, pass->depth.texture.id, false, "pass_begin")->texture;
    if (!(pass->deep_width >= 1.0f) || !(pass->deep_height >= 1.0f) || pass->deep_width > (float)t->width ||
        pass->deep_height > (float)t->height)
        fail_msg("second viewport %g %g", (double)pass->deep_width, (double)pass->deep_height);
}

static dgb_result on_pass_begin(void* user, const dgb_pass* pass) {
    record_backend* r = self(user);
    int i;
    check_in_frame(r, "pass_begin");
    if (r->in_pass) fail_msg("pass %s inside of a pass", dgb_pass_name(pass->id));
    if (pass->color_count < 0 || pass->color_count > DGB_MAX_TARGETS) fail_msg("%d targets", pass->color_count);
    if (++r->passes == r->fail_pass_at) return r->fail_with;
    r->in_pass = true;
    r->pass = *pass;
    r->bind_count = 0;
    record_printf(&r->trace, "pass %s ->", dgb_pass_name(pass->id));
    for (i = 0; i < pass->color_count; ++i) {
        check_target(r, &pass->colors[i], pass);
        print_target(r, &pass->colors[i]);
    }
    if (pass->depth.texture.id) {
        check_target(r, &pass->depth, pass);
        record_printf(&r->trace, " depth");
        print_target(r, &pass->depth);
    }
    check_key(r, pass);
    check_deep_viewport(r, pass);
    record_printf(&r->trace, " [%d %d %g %g]", pass->x, pass->y, (double)pass->width, (double)pass->height);
    if (pass->deep_width != pass->width && pass->deep_width > 0.0f)
        record_printf(&r->trace, " deep [%g %g]", (double)pass->deep_width, (double)pass->deep_height);
    if (pass->key.id) record_printf(&r->trace, " key");
    if (pass->clear) record_printf(&r->trace, " clear %g", (double)pass->clear_depth);
    if (pass->reversed) record_printf(&r->trace, " reversed");
    if (pass->clip == DGB_CLIP_ZERO_TO_ONE) record_printf(&r->trace, " clip01");
    record_printf(&r->trace, "\n");
    return DGB_OK;
}

/* Reading what is being written is undefined. Peeling reads layer j - 1 of the depth array while it writes
   layer j. */
static void check_no_feedback(const record_backend* r, dgb_texture texture, int level) {
    const dgb_pass* pass = &r->pass;
    const bool peels =
        (pass->id == DGB_PASS_LAYERS || pass->id == DGB_PASS_PREDICT) && pass->depth.layer >= 0 && !pass->key.id;
    int i;
    for (i = 0; i < pass->color_count; ++i)
        if (pass->colors[i].texture.id == texture.id && (level < 0 || level == pass->colors[i].level))
            fail_msg("pass %s reads and writes target %d at level %d", dgb_pass_name(pass->id), i, level);
    if (pass->depth.texture.id == texture.id && !peels)
        fail_msg("pass %s reads and writes depth", dgb_pass_name(pass->id));
}

static void on_texture_bind(void* user, dgb_slot slot, dgb_texture texture, int level) {
    record_backend* r = self(user);
    const dgb_texture_desc* t;
    int i;
    if (!r->in_pass) fail_msg("texture_bind of %s outside of a pass", dgb_slot_name(slot));
    t = &find_alive(r, texture.id, false, "texture_bind")->texture;
    if (level < -1 || level >= t->levels) fail_msg("bind: %s has no level %d", dgb_slot_name(slot), level);
    for (i = 0; i < r->bind_count; ++i)
        if (r->bound[i] == slot) fail_msg("%s is bound twice", dgb_slot_name(slot));
    if (r->bind_count == DGB_MAX_INPUTS) fail_msg("more than %d inputs", DGB_MAX_INPUTS);
    r->bound_textures[r->bind_count] = texture;
    r->bound[r->bind_count++] = slot;
    check_no_feedback(r, texture, level);
    record_printf(&r->trace, " bind %s", dgb_slot_name(slot));
    if (t->slot != slot) record_printf(&r->trace, "=%s", dgb_slot_name(t->slot));
    if (level >= 0) record_printf(&r->trace, "@%d", level);
    record_printf(&r->trace, "\n");
}

static size_t uniform_size(dgb_pass_id pass) {
    switch (pass) {
    case DGB_PASS_LAYERS:
    case DGB_PASS_BACK:
    case DGB_PASS_PREDICT: return sizeof(dgb_draw_uniforms);
    case DGB_PASS_WARP: return sizeof(dgb_warp_uniforms);
    case DGB_PASS_RESOLVE: return sizeof(int32_t[4]);
    case DGB_PASS_PACK: return sizeof(dgb_pack_uniforms);
    case DGB_PASS_TILES: return sizeof(dgb_tiles_uniforms);
    case DGB_PASS_AO: return sizeof(dgb_ao_uniforms);
    case DGB_PASS_GATHER: return sizeof(dgb_gather_uniforms);
    case DGB_PASS_TEMPORAL: return sizeof(dgb_temporal_uniforms);
    case DGB_PASS_RECONSTRUCT: return sizeof(dgb_reconstruct_uniforms);
    case DGB_PASS_REFLECT: return sizeof(dgb_reflect_uniforms);
    case DGB_PASS_GLOSSY: return sizeof(dgb_glossy_uniforms);
    case DGB_PASS_MIP:
    case DGB_PASS_RANGE:
    case DGB_PASS_COUNT: break;
    }
    return 0;
}

static void on_uniforms_upload(void* user, const void* std140, size_t size) {
    record_backend* r = self(user);
    record_uniforms* u = &r->uniforms[r->uniform_count];
    const bool tapped = r->pass.id == DGB_PASS_AO || r->pass.id == DGB_PASS_GATHER; /* by either estimator */
    if (!r->in_pass) fail_msg("uniforms_upload of %u bytes outside of a pass", (unsigned)size);
    if ((size != uniform_size(r->pass.id) && !(tapped && size == sizeof(dgb_bitmask_uniforms))) || size % 16 != 0)
        fail_msg("pass %s uploads %u bytes", dgb_pass_name(r->pass.id), (unsigned)size);
    if (r->uniform_count == RECORD_MAX_UNIFORMS) fail_msg("more than %d uploads", RECORD_MAX_UNIFORMS);
    u->pass = r->pass.id;
    memcpy(&u->u, std140, size);
    ++r->uniform_count;
    record_printf(&r->trace, " uniforms %u\n", (unsigned)size);
}

static void on_draw_fullscreen(void* user, dgb_program program) {
    record_backend* r = self(user);
    const record_object* object;
    if (!r->in_pass) fail_msg("draw_fullscreen of program %u outside of a pass", (unsigned)program.id);
    object = find_alive(r, program.id, true, "draw_fullscreen");
    if (object->program.pass != r->pass.id)
        fail_msg("pass %s draws with a program of %s", dgb_pass_name(r->pass.id), dgb_pass_name(object->program.pass));
    record_printf(&r->trace, " draw ");
    record_print_program(&r->trace, &object->program);
    record_printf(&r->trace, "\n");
}

static void on_pass_end(void* user) {
    record_backend* r = self(user);
    if (!r->in_pass) fail_msg("pass_end outside of a pass (%d begins)", r->begins);
    r->in_pass = false;
}

static void on_marker(void* user, dgb_pass_id pass, bool begin) {
    record_backend* r = self(user);
    check_in_frame(r, "marker");
    if (r->in_pass) fail_msg("marker of %s inside of a pass", dgb_pass_name(pass));
    record_printf(&r->trace, "%s %s\n", begin ? "begin" : "end", dgb_pass_name(pass));
}

/* >> backend */

void record_start(record_backend* r) {
    dgb_backend* b = &r->backend;
    int i;
    memset(r, 0, sizeof *r);
    r->fail_with = DGB_OUT_OF_MEMORY;
    b->version = DGB_VERSION;
    b->user = r;
    b->caps.max_size = DGB_MAX_SIZE;
    b->caps.max_layers = DGB_MAX_LAYERS;
    b->caps.clip_zero_to_one = true;
    b->caps.deep_viewport = true;
    for (i = 0; i < DGB_EMISSION_COUNT; ++i) b->caps.emission[i] = true;
    b->begin = on_begin;
    b->end = on_end;
    b->texture_create = on_texture_create;
    b->texture_destroy = on_texture_destroy;
    b->program_create = on_program_create;
    b->program_destroy = on_program_destroy;
    b->pass_begin = on_pass_begin;
    b->texture_bind = on_texture_bind;
    b->uniforms_upload = on_uniforms_upload;
    b->draw_fullscreen = on_draw_fullscreen;
    b->pass_end = on_pass_end;
    b->marker = on_marker;
    record_printf(&r->trace, "%s", "");
}

void record_stop(record_backend* r) { record_text_free(&r->trace); }

void record_clear(record_backend* r) {
    record_text_clear(&r->trace);
    r->uniform_count = 0;
}

void record_drop_callback(record_backend* r, int callback) {
    dgb_backend* b = &r->backend;
    switch (callback) {
    case 0: b->texture_create = NULL; break;
    case 1: b->texture_destroy = NULL; break;
    case 2: b->program_create = NULL; break;
    case 3: b->program_destroy = NULL; break;
    case 4: b->pass_begin = NULL; break;
    case 5: b->texture_bind = NULL; break;
    case 6: b->uniforms_upload = NULL; break;
    case 7: b->draw_fullscreen = NULL; break;
    case 8: b->pass_end = NULL; break;
    default: fail_msg("no callback %d", callback);
    }
}

const record_uniforms* record_uniforms_of(const record_backend* r, dgb_pass_id pass, int n) {
    int i;
    for (i = 0; i < r->uniform_count; ++i)
        if (r->uniforms[i].pass == pass && n-- == 0) return &r->uniforms[i];
    fail_msg("no more uniforms for %s", dgb_pass_name(pass));
    return NULL;
}
