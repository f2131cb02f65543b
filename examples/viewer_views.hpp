// What a half of the viewer's window shows of a renderer: the picture, or one of the textures it was made of.
#pragma once

#include "scene_renderer.hpp"

#include <optional>
#include <string>

enum class View {
    final,
    direct,
    indirect,
    depth, // from here on those of the library, in its order; to validity: of one layer
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

// Fills the window, but for what lies outside of `visible`. exposure: powers of two. depth_range: where views of depth have
// fallen to an eighth, metres. Returns whether the renderer has what the view shows; if not, all is dark grey.
bool paint_view(const SceneRenderer& renderer, ViewChoice choice, Area window, Area visible, float exposure,
                float depth_range);
