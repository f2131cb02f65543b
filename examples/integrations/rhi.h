/* An engine's own rendering interface, as many have one: no graphics API shows through. rhi_gl.c draws it with OpenGL. */
#ifndef RHI_H
#define RHI_H

#include <stddef.h>
#include <stdint.h>

typedef enum rhi_format {
    RHI_R8,
    RHI_RG8,
    RHI_RGBA8,
    RHI_RG11B10F,
    RHI_RG16F,
    RHI_RGBA16F,
    RHI_R32F,
    RHI_RG32F,
    RHI_RGBA32F,
    RHI_R32U,
    RHI_RG32U,
    RHI_RGBA32U,
    RHI_D32F
} rhi_format;

typedef uint32_t rhi_texture;  /* 0: none */
typedef uint32_t rhi_pipeline; /* 0: none */

typedef struct rhi_texture_desc {
    const char* label;
    rhi_format format;
    int width, height, levels;
    const void* pixels; /* of level 0, or null */
} rhi_texture_desc;

typedef struct rhi_target {
    rhi_texture texture;
    int level;
} rhi_target;

typedef struct rhi_render_pass {
    const char* label;
    int color_count;
    rhi_target colors[4];
    int x, y, width, height; /* viewport, pixels */
} rhi_render_pass;

void rhi_start(void); /* ends the program where there is no device */
void rhi_stop(void);
int rhi_max_texture_size(void);

/* 0 when the device refuses. */
rhi_texture rhi_create_texture(const rhi_texture_desc* desc);
void rhi_destroy_texture(rhi_texture texture);
rhi_pipeline rhi_create_pipeline(const char* label, const char* vertex_text, const char* fragment_text);
void rhi_destroy_pipeline(rhi_pipeline pipeline);

void rhi_begin_pass(const rhi_render_pass* pass);
/* By the name that the shaders give it. level -1: all levels; else a view of that one. */
void rhi_bind_texture(const char* name, rhi_texture texture, int level);
/* Into the one constant buffer that a pipeline has. The data is copied. */
void rhi_set_constants(const void* data, size_t size);
void rhi_draw(rhi_pipeline pipeline, int vertices);
void rhi_end_pass(void);

/* The engine's renderer: the depth of its scene. And its picture: the red channel of a texture, as grey. */
rhi_texture rhi_draw_scene_depth(void);
void rhi_save_picture(rhi_texture texture, const char* path);

#endif
