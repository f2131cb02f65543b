// A probe from what a scene looks like in all directions.
#pragma once

#include "scene_probe.hpp"
#include "scene_renderer.hpp"

#include <memory>

// Draws six pictures around a point: emission, direct light and two bounces of it, and the sky where nothing is. desc is
// that of a renderer of the scene, whose lights must be where the pose has them; its layers and probe are left aside.
Probe bake_probe(const RendererDesc& desc, const std::shared_ptr<const GpuPose>& pose, glm::vec3 eye, float near_plane,
                 float far_plane);
