// What the tests of the reference make their scenes of.
#pragma once

#include "scene.hpp"

#include <glm/gtc/matrix_transform.hpp>

// A square of two triangles around the origin, 2 m wide, that faces +Z.
inline Mesh square(int material) {
    Mesh mesh;
    for (const glm::vec2 corner : {glm::vec2(-1, -1), glm::vec2(1, -1), glm::vec2(1, 1), glm::vec2(-1, 1)}) {
        Vertex vertex;
        vertex.position = glm::vec3(corner, 0.0f);
        vertex.normal = glm::vec3(0.0f, 0.0f, 1.0f);
        vertex.uv = 0.5f + 0.5f * corner;
        mesh.vertices.push_back(vertex);
    }
    mesh.indices = {0, 1, 2, 0, 2, 3};
    mesh.material = material;
    return mesh;
}

inline Node node_at(const glm::mat4& world, int mesh) {
    Node node;
    node.local = node.world = world;
    node.meshes = {mesh};
    return node;
}

inline glm::mat4 at(glm::vec3 place, glm::vec3 size = glm::vec3(1.0f), float degrees = 0.0f,
                    glm::vec3 axis = glm::vec3(0.0f, 1.0f, 0.0f)) {
    return glm::scale(glm::rotate(glm::translate(glm::mat4(1.0f), place), glm::radians(degrees), axis), size);
}
