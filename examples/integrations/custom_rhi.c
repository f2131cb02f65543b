/* A backend for an engine's own rendering interface: the nine callbacks, none of which knows a graphics API. Ambient occlusion
   from the engine's depth buffer; layers that the library builds would need pass->depth, clearing and array textures as well.
   build  make build/release/integrations/custom_rhi
   run    build/release/integrations/custom_rhi FILE.ppm     writes the picture of ao_depth
   copy   what stands between `>> deepgbuffer` and `<< deepgbuffer`, 100 lines; then put your interface in place of rhi.h */
#include "engine_camera.h"
#include "rhi.h"
#include "rhi_shaders.h"

#include <stdio.h>
#include <stdlib.h>

/* >> deepgbuffer */
#define DEEPGBUFFER_IMPLEMENTATION
#include "deepgbuffer.h"

static dgb_backend backend;
static dgb_context dgb;

static dgb_result texture_create(void* user, const dgb_texture_desc* desc, dgb_texture* texture) {
    static const rhi_format formats[DGB_FORMAT_COUNT] = {
        [DGB_FORMAT_R8] = RHI_R8,       [DGB_FORMAT_RG8] = RHI_RG8,         [DGB_FORMAT_RGBA8] = RHI_RGBA8,
        [DGB_FORMAT_RG16F] = RHI_RG16F, [DGB_FORMAT_RGBA16F] = RHI_RGBA16F, [DGB_FORMAT_R11G11B10F] = RHI_RG11B10F,
        [DGB_FORMAT_R32F] = RHI_R32F,   [DGB_FORMAT_RG32F] = RHI_RG32F,     [DGB_FORMAT_RGBA32F] = RHI_RGBA32F,
        [DGB_FORMAT_R32UI] = RHI_R32U,  [DGB_FORMAT_RG32UI] = RHI_RG32U,    [DGB_FORMAT_RGBA32UI] = RHI_RGBA32U,
        [DGB_FORMAT_D32F] = RHI_D32F};
    const rhi_texture_desc d = {
        dgb_slot_name(desc->slot), formats[desc->format], desc->width, desc->height, desc->levels, desc->pixels};
    (void)user; /* the engine's device, if it has more than one */
    texture->id = rhi_create_texture(&d);
    return texture->id ? DGB_OK : DGB_DEVICE;
}

static void texture_destroy(void* user, dgb_texture texture) {
    (void)user;
    rhi_destroy_texture((rhi_texture)texture.id);
}

static dgb_result program_create(void* user, const dgb_program_desc* desc, dgb_program* program) {
    (void)user;
    program->id = rhi_create_pipeline(dgb_pass_name(desc->pass), rhi_shader_text(desc, RHI_VERTEX_SHADER),
                                      rhi_shader_text(desc, RHI_FRAGMENT_SHADER));
    return program->id ? DGB_OK : DGB_DEVICE;
}

static void program_destroy(void* user, dgb_program program) {
    (void)user;
    rhi_destroy_pipeline((rhi_pipeline)program.id);
}

static dgb_result pass_begin(void* user, const dgb_pass* pass) {
    rhi_render_pass p = {0};
    int i;
    (void)user;
    p.label = dgb_pass_name(pass->id);
    p.x = pass->x, p.y = pass->y, p.width = (int)pass->width, p.height = (int)pass->height;
    p.color_count = pass->color_count;
    for (i = 0; i < pass->color_count; ++i) {
        p.colors[i].texture = (rhi_texture)pass->colors[i].texture.id;
        p.colors[i].level = pass->colors[i].level;
    }
    rhi_begin_pass(&p);
    return DGB_OK;
}

static void texture_bind(void* user, dgb_slot slot, dgb_texture texture, int level) {
    char name[32]; /* the shaders say dgb_z */
    (void)user;
    snprintf(name, sizeof name, "dgb_%s", dgb_slot_name(slot));
    rhi_bind_texture(name, (rhi_texture)texture.id, level);
}

static void uniforms_upload(void* user, const void* std140, size_t size) {
    (void)user;
    rhi_set_constants(std140, size);
}

static void draw_fullscreen(void* user, dgb_program program) {
    (void)user;
    rhi_draw((rhi_pipeline)program.id, 3);
}

static void pass_end(void* user) {
    (void)user;
    rhi_end_pass();
}

static void on_log(void* user, dgb_result result, dgb_log_item item, const char* sentence) {
    (void)user;
    fprintf(stderr, "%s %s: %s\n", dgb_result_name(result), dgb_log_item_name(item), sentence);
}

static dgb_result create_ao(int width, int height) {
    dgb_desc desc = {.width = width, .height = height, .layers = 1, .backend = &backend, .log = on_log};
    desc.source = DGB_SOURCE_ENGINE;
    desc.effects = DGB_EFFECT_AO;
    backend.version = DGB_VERSION;
    backend.caps.max_size = rhi_max_texture_size();
    backend.caps.max_layers = 1;
    backend.caps.emission[DGB_EMISSION_SEPARATE] = true;
    backend.texture_create = texture_create, backend.texture_destroy = texture_destroy;
    backend.program_create = program_create, backend.program_destroy = program_destroy;
    backend.pass_begin = pass_begin, backend.pass_end = pass_end;
    backend.texture_bind = texture_bind, backend.uniforms_upload = uniforms_upload;
    backend.draw_fullscreen = draw_fullscreen;
    return dgb_init(&dgb, &desc);
}

static rhi_texture shade_ao(rhi_texture depth, const dgb_view* view) {
    const dgb_params params = dgb_preset(DGB_PRESET_BALANCED);
    const dgb_layers layers = {.depth = {{depth}}};
    dgb_set_layers(&dgb, view, &layers);
    dgb_shade(&dgb, &params);
    return (rhi_texture)dgb_get_texture(&dgb, DGB_AO).id;
}

static void destroy_ao(void) { dgb_shutdown(&dgb); }
/* << deepgbuffer */

static const dgb_view camera = {.view = ENGINE_VIEW, .projection = ENGINE_PROJECTION};

int main(int argc, char** argv) {
    if (argc != 2) {
        fprintf(stderr, "give the FILE.ppm to write\n");
        return 2;
    }
    rhi_start();
    if (create_ao(ENGINE_WIDTH, ENGINE_HEIGHT) != DGB_OK) return 2;
    rhi_save_picture(shade_ao(rhi_draw_scene_depth(), &camera), argv[1]);
    destroy_ao();
    rhi_stop();
    return 0;
}
