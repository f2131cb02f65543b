#include "scene_shapes.hpp"

#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>

namespace {

using glm::vec2;
using glm::vec3;

constexpr float kTau = glm::two_pi<float>();

// One texture repeat every kTextureSize metres, projected along the axis that the face looks along most.
vec2 planar_uv(vec3 position, vec3 normal) {
    const vec3 size = glm::abs(normal);
    if (size.y > size.x && size.y > size.z) { return vec2(position.x, position.z) / kTextureSize; }
    return vec2(size.x > size.z ? position.z : position.x, -position.y) / kTextureSize;
}

// Central difference, kept inside 0..1 so that poles of a sphere still get a direction.
vec3 surface_normal(const Surface& surface, float u, float v) {
    const float step = 1e-3f;
    u = glm::clamp(u, step, 1.0f - step);
    v = glm::clamp(v, step, 1.0f - step);
    const vec3 along_u = surface(u + step, v) - surface(u - step, v);
    const vec3 along_v = surface(u, v + step) - surface(u, v - step);
    return glm::normalize(glm::cross(along_u, along_v));
}

} // namespace

void add_quad(Mesh* mesh, vec3 a, vec3 b, vec3 c, vec3 d) {
    const vec3 normal = glm::normalize(glm::cross(c - a, d - b));
    const auto first = uint32_t(mesh->vertices.size());
    for (vec3 position : {a, b, c, d}) {
        Vertex& vertex = mesh->vertices.emplace_back();
        vertex.position = position;
        vertex.normal = normal;
        vertex.uv = planar_uv(position, normal);
    }
    for (uint32_t corner : {0u, 1u, 2u, 0u, 2u, 3u}) { mesh->indices.push_back(first + corner); }
}

void add_box(Mesh* mesh, vec3 center, vec3 half_size, float yaw) {
    const auto rotation = glm::rotate(glm::mat4(1.0f), yaw, vec3(0.0f, 1.0f, 0.0f));
    const auto corner = [&](float x, float y, float z) {
        return center + vec3(rotation * glm::vec4(vec3(x, y, z) * half_size, 0.0f));
    };
    add_quad(mesh, corner(-1, -1, 1), corner(1, -1, 1), corner(1, 1, 1), corner(-1, 1, 1));
    add_quad(mesh, corner(1, -1, -1), corner(-1, -1, -1), corner(-1, 1, -1), corner(1, 1, -1));
    add_quad(mesh, corner(1, -1, 1), corner(1, -1, -1), corner(1, 1, -1), corner(1, 1, 1));
    add_quad(mesh, corner(-1, -1, -1), corner(-1, -1, 1), corner(-1, 1, 1), corner(-1, 1, -1));
    add_quad(mesh, corner(-1, 1, 1), corner(1, 1, 1), corner(1, 1, -1), corner(-1, 1, -1));
    add_quad(mesh, corner(-1, -1, -1), corner(1, -1, -1), corner(1, -1, 1), corner(-1, -1, 1));
}

void add_surface(Mesh* mesh, uint32_t columns, uint32_t rows, const Surface& surface) {
    const auto first = uint32_t(mesh->vertices.size());
    for (uint32_t row = 0; row <= rows; ++row) {
        for (uint32_t column = 0; column <= columns; ++column) {
            const vec2 uv(float(column) / float(columns), float(row) / float(rows));
            Vertex& vertex = mesh->vertices.emplace_back();
            vertex.position = surface(uv.x, uv.y);
            vertex.normal = surface_normal(surface, uv.x, uv.y);
            vertex.uv = uv;
        }
    }
    for (uint32_t row = 0; row < rows; ++row) {
        for (uint32_t column = 0; column < columns; ++column) {
            const uint32_t a = first + row * (columns + 1) + column;
            const uint32_t d = a + columns + 1;
            mesh->indices.insert(mesh->indices.end(), {a, a + 1, d + 1, a, d + 1, d});
        }
    }
}

void add_lathe(Mesh* mesh, vec3 base, float height, uint32_t segments, uint32_t rings,
               const std::function<float(float v, float angle)>& radius) {
    add_surface(mesh, segments, rings, [&](float u, float v) {
        const float angle = -kTau * u;
        const float r = radius(v, angle);
        return base + vec3(r * std::cos(angle), height * v, r * std::sin(angle));
    });
}

void add_sphere(Mesh* mesh, vec3 center, float radius) {
    add_surface(mesh, 48, 24, [&](float u, float v) {
        const float longitude = -kTau * u;
        const float latitude = glm::pi<float>() * (v - 0.5f);
        const vec3 direction(std::cos(latitude) * std::cos(longitude), std::sin(latitude),
                             std::cos(latitude) * std::sin(longitude));
        return center + radius * direction;
    });
}

Material matte(const char* name, vec3 base_color) {
    Material material;
    material.name = name;
    material.base_color = glm::vec4(base_color, 1.0f);
    material.roughness = 0.9f;
    return material;
}
