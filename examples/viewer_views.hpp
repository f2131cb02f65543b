// What a half of the viewer's window shows of a renderer: the picture, or one of the textures it was made of.
#pragma once

#include "scene_renderer.hpp"

#include <optional>
#include <string>

enum class View {
    final,
    direct,
    indirect,
    depth, // from here to validity: of one layer
    normal,
    albedo,
    radiance,
    velocity,
    validity,
    ao,
    irradiance,
    confidence,
    history,
    reflection,
    reflection_layer,
    count
};

struct ViewChoice {
    View view = View::final;
    int layer = 0;
};

// As the command line has it: "albedo", and in the panel what its colours mean.
const char* view_name(View view);
const char* view_help(View view);
inline bool is_of_layer(View view) { return View::depth <= view && view <= View::validity; }

// "albedo" or "albedo1", the digit being that of the layer; validity is that of layer 1 if it has none. None: no such view.
std::optional<ViewChoice> view_of(const std::string& name);

struct Area { // of the window's framebuffer, pixels, from the lower left
    int x = 0, y = 0, width = 0, height = 0;
};

class ViewPainter {
public:
    ViewPainter();

    // Fills the window, but for what lies outside of `visible`. exposure: powers of two. depth_range: where views of depth
    // have fallen to an eighth, metres. history_weight: that of the frame. Returns whether the renderer has what the view
    // shows; if not, all is dark grey.
    bool paint(const SceneRenderer& renderer, ViewChoice choice, Area window, Area visible, float exposure,
               float depth_range, float history_weight) const;

private:
    GlObject program_, no_vertices_;
    GlObject no_image_, no_array_; // a sampler must not be without a texture
};
