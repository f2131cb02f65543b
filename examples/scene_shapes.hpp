// What the procedural scenes are made of. Lengths in metres, fronts counter-clockwise.
#pragma once

#include "scene.hpp"

#include <functional>

constexpr float kTextureSize = 2.0f; // metres that one repeat of a texture covers on quads and boxes

// Corners counter-clockwise as seen from the front.
void add_quad(Mesh* mesh, glm::vec3 a, glm::vec3 b, glm::vec3 c, glm::vec3 d);

// yaw: radians around the vertical axis through its center.
void add_box(Mesh* mesh, glm::vec3 center, glm::vec3 half_size, float yaw = 0.0f);

// A position for u and v in 0..1. The front is on the side of cross(dposition/du, dposition/dv).
using Surface = std::function<glm::vec3(float u, float v)>;

void add_surface(Mesh* mesh, uint32_t columns, uint32_t rows, const Surface& surface);

// A vertical surface of revolution: radius(v, angle) for v in 0..1 from bottom to top.
void add_lathe(Mesh* mesh, glm::vec3 base, float height, uint32_t segments, uint32_t rings,
               const std::function<float(float v, float angle)>& radius);

void add_sphere(Mesh* mesh, glm::vec3 center, float radius);

Material matte(const char* name, glm::vec3 base_color);
