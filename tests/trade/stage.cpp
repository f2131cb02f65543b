#include "stage.hpp"

namespace {

constexpr Motion kStep{0.045f, 0.34f, true};
constexpr int kWarmUp = 4; // frames before the first that is shaded: oracles look back

// DELAY shows what was submitted a frame ago.
int lead_of(const Setting& setting) {
    return setting.desc.layers > 1 && setting.desc.oracle == DGB_ORACLE_DELAY ? 1 : 0;
}

} // namespace

Shown shown_of(Effect effect) {
    switch (effect) {
    case Effect::occlusion: return {DGB_AO, GL_RED, 1};
    case Effect::light: return {DGB_IRRADIANCE, GL_RGBA, 4};
    case Effect::mirror: break;
    }
    return {DGB_REFLECTION, GL_RGBA, 4};
}

Stage::Stage(const std::string& argument, int width, int height)
    : subject_(load_subject(argument)), gpu_(subject_.view.scene), lights_(subject_.view.scene, gpu_, subject_.lights) {
    lights_.update(*gpu_.first_pose());
    reference_ =
        std::make_unique<ReferenceScene>(subject_.view.scene, current_pose(subject_.view.scene), subject_.lights);
    reference_view_.width = width;
    reference_view_.height = height;
    reference_view_.view = at({}, 0).view;
    reference_view_.projection = at({}, 0).projection;

    const auto renderer = shaded(preset_setting(Effect::occlusion, DGB_PRESET_BALANCED));
    z_ = renderer->read_z(0);
    points_ = points_of(*renderer, reference_view_.view);
}

std::vector<SurfacePoint> Stage::points_of(const SceneRenderer& renderer, const glm::mat4& view) const {
    ReferenceView at = reference_view_;
    at.view = view;
    return surface_points(at, renderer.read_z(0), renderer.read_normals(0));
}

// The last frame is 0, those before it are negative: whatever the path, it ends at the view of the scene.
SceneFrame Stage::at(const Condition& condition, int frame) const {
    const auto view_at = [&](int f) {
        return view_matrix(condition.moving ? moved(subject_.view.camera, kStep, f) : subject_.view.camera);
    };
    const float aspect = float(reference_view_.width) / float(reference_view_.height);
    SceneFrame at;
    at.view = view_at(frame);
    at.projection = projection_matrix(subject_.view.camera, aspect, ClipRange::standard);
    at.next_view = view_at(frame + 1); // PREDICT is told
    return at;
}

std::unique_ptr<SceneRenderer> Stage::make_renderer(const Setting& setting, uint32_t effects) const {
    RendererDesc desc;
    desc.get_proc = get_proc_of(setting.baseline);
    desc.layers = setting.desc;
    desc.layers.width = reference_view_.width;
    desc.layers.height = reference_view_.height;
    desc.layers.effects = effects;
    if (setting.desc.layers == 1) {
        desc.layers.oracle = DGB_ORACLE_PEEL;
        desc.layers.divisor = 1;
    }
    desc.scene = &gpu_;
    desc.lights = &lights_;
    desc.times = &unused_;
    return std::make_unique<SceneRenderer>(desc);
}

Built Stage::build(const Setting& setting) const {
    const bool back = setting.desc.thickness == DGB_THICKNESS_BACK_FACES;
    const auto renderer = make_renderer(setting, back ? DGB_EFFECT_REFLECT : 0); // which reads them
    const dgb_params params = scaled(setting.params, size());
    Built built;
    std::vector<double> milliseconds;
    for (int frame = -kWarmUp; frame <= 0; ++frame) {
        glFinish();
        const double start = deciding_ms();
        renderer->build(at(setting.condition, frame + lead_of(setting)), params);
        glFinish();
        if (frame > -kWarmUp) { milliseconds.push_back(deciding_ms() - start); } // the first is built by peeling
        renderer->shade(params);
    }
    built.layers = std::make_unique<EngineLayers>(*renderer); // a layer of lower resolution comes enlarged
    built.build_ms = median(milliseconds);
    return built;
}

const Built& Stage::built(const Setting& setting) {
    const char* camera = setting.condition.moving ? "moving" : "still";
    char key[64];
    std::snprintf(key, sizeof key, "one %s", camera);
    if (setting.desc.layers > 1) {
        std::snprintf(key, sizeof key, "%g %d %d %s", double(setting.params.separation), int(setting.desc.oracle),
                      setting.desc.divisor, camera);
    }
    const bool back = setting.desc.thickness == DGB_THICKNESS_BACK_FACES;
    const std::string name = std::string(key) + (back ? " back" : "");
    const auto found = built_.find(name);
    return found != built_.end() ? found->second : built_.emplace(name, build(setting)).first->second;
}

std::unique_ptr<SceneRenderer> Stage::shaded(const Setting& setting, Snapshot* before) const {
    auto renderer = make_renderer(setting, effects_of(setting));
    const dgb_params params = scaled(setting.params, size());
    const int first = 1 - setting.condition.frames;
    for (int frame = first - kWarmUp; frame <= 0; ++frame) {
        renderer->build(at(setting.condition, frame + lead_of(setting)), params);
        if (frame < first) { continue; }
        renderer->shade(params);
        if (frame == -1 && before != nullptr) {
            const Shown shown = shown_of(setting.effect);
            before->view = at(setting.condition, frame).view;
            before->points = points_of(*renderer, before->view);
            before->picture = renderer->read_texture(shown.slot, 0, shown.format);
        }
    }
    return renderer;
}
