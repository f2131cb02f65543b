#include "gl_images.h"

#include <stdlib.h>
#include <string.h>

static const float near_plane = 0.1f;

static int channels_of(int kind) { return kind == IMAGE_DEPTH ? 1 : 3; }

images images_open(int width, int height) {
    images m;
    int kind, layer;
    memset(&m, 0, sizeof m);
    m.width = width;
    m.height = height;
    for (kind = 0; kind < IMAGE_KINDS; ++kind)
        for (layer = 0; layer < 2; ++layer)
            m.texels[kind][layer] =
                (float*)calloc((size_t)width * (size_t)height * (size_t)channels_of(kind), sizeof(float));
    m.back = (float*)calloc((size_t)width * (size_t)height, sizeof(float));
    m.roughness = (float*)calloc((size_t)width * (size_t)height, sizeof(float));
    glGenTextures(2 * IMAGE_KINDS, m.textures[0]);
    glGenTextures(1, &m.back_texture);
    glGenTextures(1, &m.roughness_texture);
    return m;
}

void images_close(images* m) {
    int kind, layer;
    for (kind = 0; kind < IMAGE_KINDS; ++kind)
        for (layer = 0; layer < 2; ++layer) free(m->texels[kind][layer]);
    free(m->back);
    free(m->roughness);
    glDeleteTextures(2 * IMAGE_KINDS, m->textures[0]);
    glDeleteTextures(1, &m->back_texture);
    glDeleteTextures(1, &m->roughness_texture);
}

float* images_at(const images* m, image_kind kind, int layer, int x, int y) {
    return m->texels[kind][layer] + (y * m->width + x) * channels_of(kind);
}

float images_depth(double distance) { return (float)((double)near_plane / distance); }

void images_put(images* m, int layer, int x, int y, double distance, const float normal[3]) {
    *images_at(m, IMAGE_DEPTH, layer, x, y) = images_depth(distance);
    memcpy(images_at(m, IMAGE_NORMAL, layer, x, y), normal, 3 * sizeof(float));
    memset(images_at(m, IMAGE_RADIANCE, layer, x, y), 0, 3 * sizeof(float));
    memset(images_at(m, IMAGE_ALBEDO, layer, x, y), 0, 3 * sizeof(float));
    memset(images_at(m, IMAGE_VELOCITY, layer, x, y), 0, 3 * sizeof(float));
}

void images_fill(images* m, image_kind kind, const float color[3]) {
    int layer, i;
    for (layer = 0; layer < 2; ++layer)
        for (i = 0; i < 3 * m->width * m->height; ++i) m->texels[kind][layer][i] = color[i % 3];
}

static dgb_texture upload(GLuint name, GLenum internal, GLenum format, const images* m, const float* texels) {
    glBindTexture(GL_TEXTURE_2D, name);
    glTexImage2D(GL_TEXTURE_2D, 0, (GLint)internal, m->width, m->height, 0, format, GL_FLOAT, texels);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
    return dgbgl_texture(name);
}

dgb_layers images_upload(const images* m) {
    dgb_texture given[IMAGE_KINDS][2];
    dgb_layers layers;
    int kind, layer;
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    for (kind = 0; kind < IMAGE_KINDS; ++kind)
        for (layer = 0; layer < 2; ++layer)
            given[kind][layer] = upload(m->textures[kind][layer], kind == IMAGE_DEPTH ? GL_R32F : GL_RGB32F,
                                        kind == IMAGE_DEPTH ? GL_RED : GL_RGB, m, m->texels[kind][layer]);
    memset(&layers, 0, sizeof layers);
    layers.back = upload(m->back_texture, GL_R32F, GL_RED, m, m->back);
    layers.roughness = upload(m->roughness_texture, GL_R32F, GL_RED, m, m->roughness);
    glBindTexture(GL_TEXTURE_2D, 0);
    memcpy(layers.depth, given[IMAGE_DEPTH], sizeof layers.depth);
    memcpy(layers.normal, given[IMAGE_NORMAL], sizeof layers.normal);
    memcpy(layers.radiance, given[IMAGE_RADIANCE], sizeof layers.radiance);
    memcpy(layers.albedo, given[IMAGE_ALBEDO], sizeof layers.albedo);
    memcpy(layers.velocity, given[IMAGE_VELOCITY], sizeof layers.velocity);
    return layers;
}

static fixture_view camera(void) {
    fixture_view v = fixture_default_view();
    v.reversed = true;
    v.clip = DGB_CLIP_ZERO_TO_ONE;
    v.near_plane = near_plane;
    v.far_plane = 0.0f;
    return v;
}

dgb_view images_view(const images* m, int guard) {
    const fixture_view v = camera();
    return fixture_dgb_view(&v, m->width - 2 * guard, m->height - 2 * guard);
}

dgb_desc images_desc(const fixture* f, const images* m, int guard, int layers, uint32_t effects) {
    const fixture_view v = camera();
    dgb_desc d = fixture_desc(f, &v, m->width - 2 * guard, m->height - 2 * guard, guard);
    d.layers = layers;
    d.effects = effects;
    d.source = DGB_SOURCE_ENGINE;
    d.normals = DGB_NORMALS_FLOAT;
    return d;
}

void stage_init(stage* s, int width, int height, int guard) {
    memset(s, 0, sizeof *s);
    s->guard = guard;
    s->m = images_open(width, height);
    s->view = images_view(&s->m, guard);
    s->params = dgb_preset(DGB_PRESET_QUALITY);
}

void stage_close(stage* s) {
    dgb_shutdown(&s->c);
    images_close(&s->m);
}

dgb_result stage_shade(stage* s) {
    const dgb_layers layers = images_upload(&s->m);
    const dgb_result result = dgb_set_layers(&s->c, &s->view, &layers);
    return result ? result : dgb_shade(&s->c, &s->params);
}
