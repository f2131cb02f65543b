// What render writes of a frame that was rendered: the floats of a dump, the pictures made of them.
#pragma once

#include "image.hpp"
#include "scene_renderer.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

namespace render_pictures {

using Floats = std::vector<float>;
using Rgb = std::vector<uint8_t>;

// ---- From floats to bytes -------------------------------------------------------------------------------

inline float srgb(float linear) {
    return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1.0f / 2.4f) - 0.055f;
}

// Narkowicz's fit of the ACES filmic curve: 1 becomes 0.8, highlights roll off towards 1.
inline float filmic(float x) {
    x = std::min(x, 1e4f); // far into the white, and far from an overflow
    return x * (2.51f * x + 0.03f) / (x * (2.43f * x + 0.59f) + 0.14f);
}

// NaN is black.
inline uint8_t to_byte(float x) { return uint8_t(x > 0.0f ? std::lround(255.0f * std::min(x, 1.0f)) : 0); }

// PNG has the top row first and three channels; one channel is repeated.
template <typename Curve>
Rgb to_rgb(const Floats& pixels, int width, int height, Curve curve) {
    const size_t row = size_t(width), channels = pixels.size() / (row * size_t(height));
    Rgb rgb;
    rgb.reserve(row * size_t(height) * 3);
    for (size_t y = size_t(height); y-- > 0;) {
        for (size_t x = 0; x < row; ++x) {
            const float* pixel = &pixels[(y * row + x) * channels];
            for (size_t c = 0; c < 3; ++c) { rgb.push_back(to_byte(curve(pixel[std::min(c, channels - 1)]))); }
        }
    }
    return rgb;
}

// ---- What a dump holds ----------------------------------------------------------------------------------

inline Floats one_of_four(const Floats& rgba, size_t channel) {
    Floats values(rgba.size() / 4);
    for (size_t i = 0; i < values.size(); ++i) { values[i] = rgba[4 * i + channel]; }
    return values;
}

// Colors of layer 0 or 1, black where the shading sees no surface.
inline Floats layer_colors(const SceneRenderer& renderer, dgb_slot slot, int layer) {
    Floats colors = renderer.read_texture(slot, layer, GL_RGB);
    const Floats z = renderer.read_z(layer);
    for (size_t i = 0; i < colors.size(); ++i) {
        if (z[i / 3] == 0.0f) { colors[i] = 0.0f; }
    }
    return colors;
}

inline Floats dump_pixels(const SceneRenderer& r, const std::string& name) {
    const int layer = name.back() == '1' ? 1 : 0;
    if (name == "z0" || name == "z1") { return r.read_z(layer); }
    if (name == "normal0" || name == "normal1") { return r.read_normals(layer); }
    if (name == "albedo0" || name == "albedo1") { return layer_colors(r, DGB_ALBEDO, layer); }
    if (name == "radiance0" || name == "radiance1") { return layer_colors(r, DGB_RADIANCE, layer); }
    if (name == "ao") { return r.read_texture(DGB_AO, 0, GL_RED); }
    if (name == "ao_raw") { return r.read_texture(DGB_AO_RAW, 0, GL_RED); }
    if (name == "bent") { return r.read_texture(DGB_BENT, 0, GL_RGB); }
    if (name == "irradiance0") { return r.read_texture(DGB_IRRADIANCE, 0, GL_RGB); }
    if (name == "irradiance0_raw") { return r.read_texture(DGB_IRRADIANCE_RAW, 0, GL_RGB); }
    if (name == "irradiance1") { return r.read_texture(DGB_IRRADIANCE1, 0, GL_RGB); }
    if (name == "irradiance1_raw") { return r.read_texture(DGB_IRRADIANCE1_RAW, 0, GL_RGB); }
    if (name == "confidence0") { return one_of_four(r.read_texture(DGB_IRRADIANCE, 0, GL_RGBA), 3); }
    if (name == "confidence1") { return one_of_four(r.read_texture(DGB_IRRADIANCE1, 0, GL_RGBA), 3); }
    if (name == "history0") { return one_of_four(r.read_texture(DGB_FRAMES, 0, GL_RGBA), 2); }
    if (name == "history1") { return one_of_four(r.read_texture(DGB_FRAMES, 0, GL_RGBA), 3); }
    if (name == "reflection") { return r.read_texture(DGB_REFLECTION, 0, GL_RGB); }
    if (name == "reflection_raw") { return r.read_texture(DGB_REFLECTION_RAW, 0, GL_RGB); }
    if (name == "reflect_confidence") { return one_of_four(r.read_texture(DGB_REFLECTION, 0, GL_RGBA), 3); }
    if (name == "reflect_layer") { return one_of_four(r.read_texture(DGB_REFLECTION_HIT, 0, GL_RGBA), 0); }
    if (name == "reflect_length") { return one_of_four(r.read_texture(DGB_REFLECTION_HIT, 0, GL_RGBA), 1); }
    return r.read_picture(SceneRenderer::Picture::final);
}

// ---- Views ----------------------------------------------------------------------------------------------

inline float luminance(const float* rgb) { return 0.2126f * rgb[0] + 0.7152f * rgb[1] + 0.0722f * rgb[2]; }

// The mean over the pixels with a surface; 0 if there is none.
inline double mean_confidence(const SceneRenderer& r) {
    const Floats confidence = dump_pixels(r, "confidence0"), z = r.read_z(0);
    double sum = 0.0;
    size_t surfaces = 0;
    for (size_t i = 0; i < z.size(); ++i) {
        if (z[i] == 0.0f) { continue; }
        sum += double(confidence[i]);
        ++surfaces;
    }
    return surfaces == 0 ? 0.0 : sum / double(surfaces);
}

// Of the pixels with a surface. 1 counts in the last bin.
inline std::vector<size_t> confidence_counts(const Floats& confidence, const Floats& z, size_t bins) {
    std::vector<size_t> counts(bins);
    for (size_t i = 0; i < z.size(); ++i) {
        if (z[i] != 0.0f) { ++counts[std::min(size_t(confidence[i] * float(bins)), bins - 1)]; }
    }
    return counts;
}

// Paper, Figure 9 a.
inline Rgb confidence_view(const SceneRenderer& r, int width, int height) {
    const Floats confidence = dump_pixels(r, "confidence0");
    Rgb rgb = to_rgb(confidence, width, height, [](float x) { return x; });
    draw_label(&rgb, width, height, 8, 8, label_scale(height), "confidence, and how many pixels have it");
    draw_histogram(&rgb, width, height, confidence_counts(confidence, r.read_z(0), 32), "0", "1");
    return rgb;
}

// What the gathered light adds to the picture: reflected, by its confidence.
inline Floats radiosity(const SceneRenderer& r) {
    const Floats albedo = r.read_texture(DGB_ALBEDO, 0, GL_RGBA), gathered = r.read_texture(DGB_IRRADIANCE, 0, GL_RGBA);
    const Floats z = r.read_z(0);
    Floats light(z.size() * 3);
    for (size_t i = 0; i < z.size(); ++i) {
        if (z[i] == 0.0f) { continue; }
        const float factor = albedo[4 * i + 3] * gathered[4 * i + 3] / glm::pi<float>(); // albedo's a: 0 unlit, 1 lit
        for (size_t c = 0; c < 3; ++c) { light[3 * i + c] = albedo[4 * i + c] * gathered[4 * i + c] * factor; }
    }
    return light;
}

struct LabelledFloats {
    Floats pixels;
    std::string label;
};

// The power of two, 1 to 1024, with which the brightest percent of the pixels are nearly white.
inline float brightening(const Floats& light) {
    Floats values(light.size() / 3);
    for (size_t i = 0; i < values.size(); ++i) { values[i] = luminance(&light[3 * i]); }
    const auto bright = values.begin() + std::ptrdiff_t(values.size() * 99 / 100);
    std::nth_element(values.begin(), bright, values.end());
    return std::exp2(std::floor(std::log2(std::clamp(1.0f / std::max(*bright, 1e-9f), 1.0f, 1024.0f))));
}

enum class Disoccluded { not_at_all, in_first_layer, in_both };

// Layers hand on irradiance to each other, but visibility exists for the first alone: where only that begins anew, the
// surface was in the second layer.
inline std::vector<Disoccluded> disocclusions(const SceneRenderer& r) {
    const Floats frames = r.read_texture(DGB_FRAMES, 0, GL_RGBA), z = r.read_z(0);
    std::vector<Disoccluded> result(z.size(), Disoccluded::not_at_all);
    for (size_t i = 0; i < z.size(); ++i) {
        if (z[i] == 0.0f || frames[4 * i + 1] > 1.0f) { continue; }
        result[i] = frames[4 * i + 2] > 1.0f ? Disoccluded::in_first_layer : Disoccluded::in_both;
    }
    return result;
}

// Greyed, half as bright.
inline Rgb greyed(Rgb rgb) {
    for (size_t i = 0; i < rgb.size(); i += 3) {
        const float color[3] = {float(rgb[i]), float(rgb[i + 1]), float(rgb[i + 2])};
        std::fill_n(&rgb[i], 3, uint8_t(0.5f * luminance(color)));
    }
    return rgb;
}

inline std::string percent_label(const std::vector<Disoccluded>& all, Disoccluded which, const char* text) {
    char label[80];
    const auto count = std::count(all.begin(), all.end(), which);
    std::snprintf(label, sizeof label, "%.2f %% %s", 100.0 * double(count) / double(all.size()), text);
    return label;
}

// Paper, Figure 12, over a picture of the frame.
inline Rgb disocclusion_view(const SceneRenderer& r, const Rgb& picture, int width, int height) {
    const std::vector<Disoccluded> what = disocclusions(r);
    Rgb rgb = greyed(picture);
    const size_t row = size_t(width);
    for (size_t i = 0; i < what.size(); ++i) {
        if (what[i] == Disoccluded::not_at_all) { continue; }
        const size_t top_down = (size_t(height) - 1 - i / row) * row + i % row;
        const uint8_t red = what[i] == Disoccluded::in_both ? 255 : 0;
        rgb[3 * top_down] = red;
        rgb[3 * top_down + 1] = 255;
        rgb[3 * top_down + 2] = uint8_t(255 - red);
    }
    const int scale = label_scale(height);
    draw_label(&rgb, width, height, 8, 8, scale,
               percent_label(what, Disoccluded::in_first_layer, "cyan: last frame had it in the second layer only"));
    draw_label(&rgb, width, height, 8, 8 + 16 * scale, scale,
               percent_label(what, Disoccluded::in_both, "yellow: in neither layer"));
    return rgb;
}

} // namespace render_pictures
