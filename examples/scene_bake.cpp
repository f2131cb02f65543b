#include "scene_bake.hpp"

#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include <vector>

namespace {

using glm::vec3;

// Emission and direct light first; each further round adds a bounce, without which all shade would be black.
constexpr int kRounds = 3;
constexpr int kFaceSize = 64; // pixels: far more than order 2 can tell apart, so that small bright things are met

struct Face {
    vec3 forward, up;
};
const Face kFaces[] = {{{1, 0, 0}, {0, 1, 0}},  {{-1, 0, 0}, {0, 1, 0}}, {{0, 1, 0}, {0, 0, 1}},
                       {{0, -1, 0}, {0, 0, 1}}, {{0, 0, 1}, {0, 1, 0}},  {{0, 0, -1}, {0, 1, 0}}};

void add_face(const std::vector<float>& rgb, const glm::mat4& view, ProbeSum* sum) {
    const glm::mat3 to_world(glm::transpose(view));
    const float pixel = 2.0f / kFaceSize; // at distance 1
    for (int i = 0; i < kFaceSize * kFaceSize; ++i) {
        const int column = i % kFaceSize, row = i / kFaceSize; // the bottom row first
        const vec3 ray((float(column) + 0.5f) * pixel - 1.0f, (float(row) + 0.5f) * pixel - 1.0f, -1.0f);
        const float length = glm::length(ray);
        const float* color = &rgb[3 * size_t(i)];
        sum->add(to_world * ray / length, {color[0], color[1], color[2]}, pixel * pixel / (length * length * length));
    }
}

// A round.
Probe bake_once(const RendererDesc& desc, const std::shared_ptr<const GpuPose>& pose, vec3 eye,
                const glm::mat4& projection) {
    SceneRenderer renderer(desc);
    SceneFrame frame;
    frame.pose = pose;
    frame.projection = projection;
    const dgb_params params = dgb_preset(DGB_PRESET_BALANCED);
    ProbeSum sum;
    for (const Face& face : kFaces) {
        frame.view = glm::lookAt(eye, eye + face.forward, face.up);
        renderer.build(frame, params);
        renderer.shade(params);
        add_face(renderer.read_picture(SceneRenderer::Picture::final), frame.view, &sum);
    }
    return sum.probe();
}

} // namespace

Probe bake_probe(const RendererDesc& desc, const std::shared_ptr<const GpuPose>& pose, vec3 eye, float near_plane,
                 float far_plane) {
    RendererDesc round = desc;
    round.layers = {};
    round.layers.width = round.layers.height = kFaceSize;
    round.layers.layers = 1;
    round.probe = {};
    const glm::mat4 projection = glm::perspective(glm::half_pi<float>(), 1.0f, near_plane, far_plane);
    for (int i = 0; i < kRounds; ++i) { round.probe = bake_once(round, pose, eye, projection); }
    return round.probe;
}
