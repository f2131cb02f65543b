// The viewer's panel: everything that can be chosen, what it costs, and what the library says about it.
#pragma once

#include "scene_renderer.hpp"
#include "viewer_views.hpp"

#include "deepgbuffer.h"

#include <glm/glm.hpp>

#include <array>
#include <string>
#include <vector>

// What a pass took lately, and what whole frames took.
class PassHistory {
public:
    struct Pass {
        std::string name;
        double milliseconds = 0.0; // a moving average
        bool gpu = false;          // by the GPU's clock
    };

    void add(const PassTimes& times); // of one frame
    const std::vector<Pass>& passes() const { return passes_; }
    const std::vector<float>& frames() const { return frames_; } // sums, ms, the last one at the end
    bool has_gpu() const;

private:
    Pass& pass(const std::string& name);

    std::vector<Pass> passes_;
    std::vector<float> frames_;
};

// What one half of the window shows, and how it is made.
struct Config {
    dgb_desc layers{}; // without backend and log
    dgb_params params{};
    ViewChoice view;
};

struct PanelSide {
    Config config;
    const dgb_plan* plan = nullptr; // null: nothing is drawn
    std::string desc_error;         // the library's sentence: what is drawn is not what the panel says
    std::string frame_error;
    bool shows_view = true; // it has what the view shows
    PassHistory history;
};

struct Sun {
    bool on = true;
    float azimuth = 0.0f, elevation = 45.0f; // degrees: from +Z over +X, from the horizon
    float strength = 6.0f;                   // W/m2
};

// A place to see what a second layer does, in words of the command line.
struct Demo {
    const char *name, *words, *look_for;
};
extern const std::array<Demo, 3> kDemos;

enum class Alone { none, left, right };

struct Panel {
    std::array<PanelSide, 2> sides; // left, right
    bool linked = true;             // what is changed on one side is changed on the other, but for the number of layers
    float split = 0.5f;             // share of the width
    Alone alone = Alone::none;      // one half fills the window for now; the other goes on behind it
    bool visible = true, labels = true;
    Sun sun;
    glm::vec3 sky{0.0f};   // radiance, W/m2/sr
    float exposure = 0.0f; // powers of two
    float speed = 1.0f;    // of flying, m/s
    bool has_animation = false, playing = true;
    bool wait = false;      // for the GPU after each pass, so that CPU times are all of it
    bool recording = false; // the camera's path
    bool replaying = false;
    std::string message; // what was done last, or why not

    float shown_split() const { return alone == Alone::left ? 1.0f : alone == Alone::right ? 0.0f : split; }
};

// What the panel asks for.
struct PanelRequests {
    bool desc_changed = false; // of any side
    bool light_changed = false;
    bool sky_changed = false;
    const Demo* demo = nullptr;
};

// Lengths (separation, radii) stay as they are: they belong to the scene.
void set_preset(dgb_preset_id preset, dgb_params* params);

// "two layers, reproject: albedo of layer 1".
std::string label_of(const PanelSide& side);

// Of the window's width, in its own coordinates; at most half of it.
float panel_width(float window_width);

// All between ImGui's NewFrame and Render. Sizes are those of the picture, which is left of the panel, in the window's own
// coordinates.
void draw_labels(const Panel& panel, float width, float height);
void draw_errors(const Panel& panel, float width, float height);
PanelRequests draw_panel(Panel* panel, float left, float width, float height);
