#include "viewer_views.hpp"

#include <cmath>
#include <cstring>

namespace {

// The pictures of a renderer come first, then the views of the library.
const char* const kPictures[][2] = {
    {"final", "the picture"},
    {"direct", "emission, direct light and the sky"},
    {"indirect", "bounced light, the probe's light and reflections"},
};
constexpr int kPictureCount = int(View::depth);
static_assert(sizeof kPictures / sizeof *kPictures == kPictureCount, "");
static_assert(int(View::count) - kPictureCount == DGBGL_VIEW_LIGHT, "every view of the library is one of the viewer's");

bool is_picture(View view) { return int(view) < kPictureCount; }
dgbgl_view library_view(View view) { return dgbgl_view(int(view) - kPictureCount); }

void fill(Area visible) {
    glEnable(GL_SCISSOR_TEST);
    glScissor(visible.x, visible.y, visible.width, visible.height);
    glClearColor(0.12f, 0.12f, 0.12f, 1.0f);
    glClear(GL_COLOR_BUFFER_BIT);
    glDisable(GL_SCISSOR_TEST);
}

} // namespace

const char* view_name(View view) {
    return is_picture(view) ? kPictures[int(view)][0] : dgbgl_view_name(library_view(view));
}

const char* view_help(View view) {
    return is_picture(view) ? kPictures[int(view)][1] : dgbgl_view_legend(library_view(view));
}

std::optional<ViewChoice> view_of(const std::string& name) {
    for (int i = 0; i < int(View::count); ++i) {
        const size_t length = std::strlen(view_name(View(i)));
        if (name.compare(0, length, view_name(View(i))) != 0) { continue; }
        ViewChoice choice;
        choice.view = View(i);
        if (name.size() == length) {
            choice.layer = choice.view == View::validity ? 1 : 0;
            return choice;
        }
        const char digit = name[length];
        if (name.size() == length + 1 && is_of_layer(choice.view) && '0' <= digit && digit < '0' + DGB_MAX_LAYERS) {
            choice.layer = digit - '0';
            return choice;
        }
    }
    return std::nullopt;
}

bool paint_view(const SceneRenderer& renderer, ViewChoice choice, Area window, Area visible, float exposure,
                float depth_range) {
    dgbgl_view_desc view{};
    view.view = is_picture(choice.view) ? DGBGL_VIEW_LIGHT : library_view(choice.view);
    view.layer = is_of_layer(choice.view) ? choice.layer : 0;
    view.x = window.x, view.y = window.y, view.width = window.width, view.height = window.height;
    view.exposure = std::exp2(exposure);
    view.depth_range = depth_range;
    view.texture = is_picture(choice.view) ? renderer.picture(SceneRenderer::Picture(int(choice.view))) : 0;
    fill(visible);
    glEnable(GL_SCISSOR_TEST);
    glScissor(visible.x, visible.y, visible.width, visible.height);
    const bool drawn = renderer.draw_view(view);
    glDisable(GL_SCISSOR_TEST);
    return drawn;
}
