// The lights of a scene and their shadow maps, in OpenGL 3.3: every light has one map, or six where it shines all around.
#pragma once

#include "scene.hpp"
#include "scene_gpu.hpp"

#include <glm/glm.hpp>

#include <optional>
#include <vector>

constexpr int kMaxLights = 16;

// For the start of a fragment shader, behind its #version line:
//     vec3 direct_irradiance(vec3 world, vec3 normal)
// of all lights, W/m2; both arguments in world space.
extern const char* const kDirectLight;

class SceneLights {
public:
    // Lights that are dark are left out. Throws std::runtime_error when there are too many. The scene on the GPU must
    // outlive the lights.
    SceneLights(const Scene& scene, const GpuScene& gpu_scene, const std::vector<PunctualLight>& lights);

    // Takes the lights to where the pose has them and draws their maps, unless they show this very pose. Returns whether
    // it did.
    bool update(const GpuPose& pose);

    // Gives a program what kDirectLight reads. The program must be in use.
    void bind(GLuint program, int unit) const;

    bool empty() const { return lights_.empty(); }
    const std::vector<PunctualLight>& lights() const { return lights_; } // where the last update took them
    int map_size() const { return map_size_; }                           // texels along one side
    int map_count() const { return map_count_; }

private:
    void place(const Pose& pose);
    void draw_maps(const GpuPose& pose) const;

    const GpuScene* scene_;
    glm::vec3 bounds_min_, bounds_max_; // of the scene, metres
    std::vector<PunctualLight> lights_;
    int map_size_ = 0, map_count_ = 0;
    std::vector<glm::mat4> clips_; // a map, from world
    GlObject maps_, uniforms_, program_;
    std::optional<Pose> pose_; // that the maps show; none yet
};
