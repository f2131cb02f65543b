// The command line of the viewer: what it shares with render, and what its window adds.
#pragma once

#include "render_options.hpp"
#include "viewer_views.hpp"

#include <CLI/CLI.hpp>

#include <optional>
#include <string>

struct ViewerOptions {
    Options left, right; // of the two halves; what is not of layers or shading counts from the right one
    ViewChoice view;
    float split = 0.5f;     // where the left half ends, share of the width
    int frames = 0;         // then the window closes; 0: never
    std::string screenshot; // empty: none
    std::string path;       // empty: none
    bool panel = true, labels = true;
    struct {
        bool separation = false, ao_radius = false, radius = false;
    } given; // lengths that the user said
};

namespace viewer_options {

using render_options::between;

inline void parse_view(const std::string& name, ViewerOptions* options) {
    const std::optional<ViewChoice> choice = view_of(name);
    if (!choice) {
        std::string names;
        for (int i = 0; i < int(View::count); ++i) { names += (i == 0 ? "" : ", ") + std::string(view_name(View(i))); }
        render_options::require(false, "--view",
                                "must be one of " + names + ", those of a layer with its number behind");
    }
    options->view = *choice;
}

inline void add_window(CLI::App* app, ViewerOptions* o) {
    app->add_option_function<std::string>(
        "--view", [=](const std::string& name) { parse_view(name, o); },
        "what both halves show: final (default), direct, indirect; depth, normal, albedo, radiance, velocity, "
        "validity, "
        "each with the layer's number behind, like albedo1; ao, irradiance, confidence, history, reflection, "
        "reflection_layer");
    app->add_option("--split", o->split, "where the left half ends, 0 to 1 (default 0.5); 0: right alone")
        ->check(between(0, 1, "0 to 1"));
    app->add_option("--frames", o->frames, "frames to draw before the window closes (default: until you close it)")
        ->check(between(1, 1e6, "1 to 1000000"));
    app->add_option("--screenshot", o->screenshot,
                    "FILE.png or FILE.pfm: the window in its last frame; needs --frames");
    app->add_option("--path", o->path,
                    "camera path, a text file: it is followed from the start if it is there, and F9 writes it");
    app->add_flag("!--no-panel", o->panel, "without the panel (F1 shows it)")->disable_flag_override();
    app->add_flag("!--no-labels", o->labels, "without labels and the line between the halves (F2 shows them)")
        ->disable_flag_override();
}

inline bool ends_with(const std::string& text, const std::string& end) {
    return text.size() > end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

inline void check_window(const ViewerOptions& options) {
    if (options.screenshot.empty()) { return; }
    const bool known = ends_with(options.screenshot, ".png") || ends_with(options.screenshot, ".pfm");
    render_options::require(known, "--screenshot", "must end in .png or .pfm");
    render_options::require(options.frames > 0, "--screenshot", "needs --frames");
}

// The left half is as the right one but for the words of its own. Only those of layers and shading count.
inline Options parse_left(const Options& right, render_options::Overrides overrides, const std::string& words) {
    CLI::App app;
    Options left = right;
    app.set_help_flag();
    render_options::add_layers(&app, &left, &overrides);
    render_options::add_shading(&app, &left, &overrides);
    app.parse(words);
    render_options::apply(overrides, &left);
    left.width = right.width;
    left.height = right.height;
    return left;
}

inline Options one_layer(Options options) {
    options.layers = options.divisor = 1;
    options.oracle = DGB_ORACLE_DEFAULT;
    options.emission = DGB_EMISSION_AUTO;
    return options;
}

// Lengths that the user did not give are those of render in rooms and courts; where a file holds a shoe or a city, they
// are the same shares of its diagonal as they are of the atrium's, 45 m.
inline void scale_lengths(const ViewerOptions& options, float diagonal, dgb_params* params) {
    const float scale = diagonal > 4.0f && diagonal < 200.0f ? 1.0f : diagonal / 45.0f;
    if (!options.given.separation) { params->separation *= scale; }
    if (!options.given.ao_radius) { params->ao_radius *= scale; }
    if (!options.given.radius) { params->radius *= scale; }
}

} // namespace viewer_options

// Throws CLI::ParseError: CLI::Success to show the help, anything else is the user's mistake in one sentence. parse: hands
// the words to the app.
template <typename Parse>
ViewerOptions parse_viewer_options(CLI::App* app, Parse parse) {
    using namespace viewer_options;
    ViewerOptions options;
    render_options::Overrides overrides;
    std::optional<std::string> left;
    app->set_help_flag("--help", "print this help");
    render_options::add_scene(app, &options.right);
    render_options::add_layers(app, &options.right, &overrides);
    render_options::add_shading(app, &options.right, &overrides);
    render_options::add_picture(app, &options.right);
    add_window(app, &options);
    app->add_option("--left", left,
                    "options of layers and shading in which the left half differs from the right one, like "
                    "--left=\"--oracle peel --divisor 2\" (default: one layer)");
    parse(app);
    render_options::apply(overrides, &options.right);
    options.left = left ? parse_left(options.right, overrides, *left) : one_layer(options.right);
    options.given.separation = app->count("--separation") > 0;
    options.given.ao_radius = app->count("--ao-radius") > 0;
    options.given.radius = app->count("--radius") > 0;
    check_window(options);
    return options;
}
