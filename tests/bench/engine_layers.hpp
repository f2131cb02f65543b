// One or two layers that a renderer built and lit, as the textures of an engine: every contender shades the very same ones, and they
// are drawn once, however many contenders there are.
#pragma once

#include "library.hpp"
#include "scene_renderer.hpp"

#include <array>

class EngineLayers {
public:
    static constexpr int kLayers = 2;

    // The renderer's image is the contenders' buffer, guard band included. It must have lit its layers.
    explicit EngineLayers(const SceneRenderer& renderer)
        : width_(renderer.plan().width), height_(renderer.plan().height),
          layers_(std::min(renderer.plan().layers, kLayers)) {
        if (renderer.has(DGB_BACK)) { back_ = make_storage(GL_R32F); }
        for (int layer = 0; layer < layers_; ++layer) {
            for (size_t i = 0; i < kTargets.size(); ++i) {
                textures_[size_t(layer)][i] = make_storage(kTargets[i].format);
            }
        }
        take(renderer);
    }

    void take(const SceneRenderer& renderer) {
        glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
        for (int layer = 0; layer < layers_; ++layer) {
            for (size_t i = 0; i < kTargets.size(); ++i) {
                const Target& target = kTargets[i];
                upload(textures_[size_t(layer)][i], target.channels,
                       renderer.read_texture(target.slot, layer, target.read_as));
            }
        }
        if (renderer.has(DGB_BACK)) { upload(back_, GL_RED, renderer.read_texture(DGB_BACK, 0, GL_DEPTH_COMPONENT)); }
        glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
    }

    int width() const { return width_; }
    int height() const { return height_; }

    GLuint texture(dgb_slot slot, int layer) const {
        for (size_t i = 0; i < kTargets.size(); ++i) {
            if (kTargets[i].slot == slot) { return textures_[size_t(layer)][i].name(); }
        }
        return 0;
    }

    dgb_layers handles(int layers) const {
        dgb_layers handles{};
        for (int i = 0; i < layers; ++i) {
            handles.depth[i] = dgbgl_texture(texture(DGB_DEPTH, i));
            handles.albedo[i] = dgbgl_texture(texture(DGB_ALBEDO, i));
            handles.normal[i] = dgbgl_texture(texture(DGB_NORMAL, i));
            handles.radiance[i] = dgbgl_texture(texture(DGB_RADIANCE, i));
            handles.velocity[i] = dgbgl_texture(texture(DGB_VELOCITY, i));
        }
        handles.back = dgbgl_texture(back_.name());
        return handles;
    }

    // Of contexts that shade these layers, or one of them. desc: what else they are to have.
    static dgb_desc describe(int width, int height, int layers, uint32_t effects, dgb_desc desc = {}) {
        desc.width = width;
        desc.height = height;
        desc.layers = layers;
        desc.effects = effects;
        desc.source = DGB_SOURCE_ENGINE;
        desc.normals = DGB_NORMALS_OCT16;
        return desc;
    }

private:
    struct Target {
        dgb_slot slot;
        GLenum format, read_as, channels; // the format holds every value that was read
    };
    static constexpr std::array<Target, 5> kTargets = {{{DGB_DEPTH, GL_R32F, GL_DEPTH_COMPONENT, GL_RED},
                                                        {DGB_ALBEDO, GL_RGBA8, GL_RGBA, GL_RGBA},
                                                        {DGB_NORMAL, GL_RGBA8, GL_RGBA, GL_RGBA},
                                                        {DGB_RADIANCE, GL_R11F_G11F_B10F, GL_RGB, GL_RGB},
                                                        {DGB_VELOCITY, GL_RG16F, GL_RG, GL_RG}}};

    GlObject make_storage(GLenum format) const {
        GlObject texture = make_texture();
        glBindTexture(GL_TEXTURE_2D, texture.name());
        glTexStorage2D(GL_TEXTURE_2D, 1, format, width_, height_);
        glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
        glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
        return texture;
    }

    void upload(const GlObject& texture, GLenum channels, const std::vector<float>& pixels) const {
        glBindTexture(GL_TEXTURE_2D, texture.name());
        glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, width_, height_, channels, GL_FLOAT, pixels.data());
    }

    int width_, height_, layers_;
    std::array<std::array<GlObject, kTargets.size()>, kLayers> textures_;
    GlObject back_; // none where the renderer draws no back faces
};
