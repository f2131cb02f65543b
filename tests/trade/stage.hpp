// A scene at the frame that is looked at, with the layers of any construction and the pictures of any setting.
#pragma once

#include "engine_layers.hpp"
#include "reference.hpp"
#include "setting.hpp"
#include "subject.hpp"

using Pixels = std::vector<float>;

struct Built {
    std::unique_ptr<EngineLayers> layers;
    double build_ms = 0.0; // median of the frames
};

// What the steps of a camera are measured on: a frame's picture and the surfaces that it shows.
struct Snapshot {
    glm::mat4 view{1.0f};
    std::vector<SurfacePoint> points;
    Pixels picture; // as the library left it
};

// What the library shows of the effect.
struct Shown {
    dgb_slot slot;
    GLenum format;
    size_t channels;
};
Shown shown_of(Effect effect);

class Stage {
public:
    Stage(const std::string& argument, int width, int height);

    float size() const { return subject_.size(); } // metres
    const ReferenceView& view() const { return reference_view_; }
    const ReferenceScene& reference() const { return *reference_; }
    dgb_view dgb_view_now() const { return to_dgb_view(reference_view_.view, reference_view_.projection); }
    const Pixels& z() const { return z_; }
    const std::vector<SurfacePoint>& points() const { return points_; }

    const Built& built(const Setting& setting);
    // A renderer that has built and shaded all frames of the setting. before: gets the last but one, where there is one.
    std::unique_ptr<SceneRenderer> shaded(const Setting& setting, Snapshot* before = nullptr) const;

private:
    SceneFrame at(const Condition& condition, int frame) const;
    std::unique_ptr<SceneRenderer> make_renderer(const Setting& setting, uint32_t effects) const;
    std::vector<SurfacePoint> points_of(const SceneRenderer& renderer, const glm::mat4& view) const;
    Built build(const Setting& setting) const;

    Subject subject_;
    GpuScene gpu_;
    SceneLights lights_;
    ReferenceView reference_view_;
    std::unique_ptr<ReferenceScene> reference_;
    Pixels z_; // of the first layer
    std::vector<SurfacePoint> points_;
    std::map<std::string, Built> built_; // by what a construction depends on
    mutable PassTimes unused_{false};    // a renderer keeps times
};
