/* Layers made up texel by texel, as an engine's own (DGB_SOURCE_ENGINE): reversed infinite depth, float normals. */
#ifndef GL_IMAGES_H
#define GL_IMAGES_H

#include "gl_fixture.h"

typedef enum image_kind {
    IMAGE_DEPTH,
    IMAGE_NORMAL,
    IMAGE_RADIANCE,
    IMAGE_ALBEDO,
    IMAGE_VELOCITY,
    IMAGE_KINDS
} image_kind;

typedef struct images {
    int width, height;             /* of the buffers */
    float* texels[IMAGE_KINDS][2]; /* of both layers; depth 1 float a texel, the others 3; all 0: empty */
    GLuint textures[IMAGE_KINDS][2];
    float* back;      /* depth of back faces behind the first layer, 1 float a texel; 0: none */
    float* roughness; /* of the first layer, 1 float a texel */
    GLuint back_texture, roughness_texture;
} images;

images images_open(int width, int height);
void images_close(images* m);

/* The texel of a layer. */
float* images_at(const images* m, image_kind kind, int layer, int x, int y);
/* Depth of a surface so many metres away. */
float images_depth(double distance);
/* A surface at a texel of a layer, that sends nothing, reflects nothing and does not move. */
void images_put(images* m, int layer, int x, int y, double distance, const float normal[3]);
/* The same colour at every texel of both layers. */
void images_fill(images* m, image_kind kind, const float color[3]);

/* Uploads all; the same textures every time. */
dgb_layers images_upload(const images* m);

/* Where fixture_default_view stands: 60 degrees, for an image of the size that leaves `guard` texels on every side. */
dgb_view images_view(const images* m, int guard);
dgb_desc images_desc(const fixture* f, const images* m, int guard, int layers, uint32_t effects);

/* A context that shades images, and with what. */
typedef struct stage {
    images m;
    dgb_context c;
    dgb_view view;
    dgb_params params;
    int guard;
} stage;

/* Images, images_view and the preset QUALITY; the context is for the caller to initialise. */
void stage_init(stage* s, int width, int height, int guard);
void stage_close(stage* s);
/* Uploads the images and shades them. */
dgb_result stage_shade(stage* s);

#endif
