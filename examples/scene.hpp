// A scene on the CPU: what the loaders produce and the examples upload to OpenGL.
// Units are metres and radians, Y is up, colours are linear unless a comment says sRGB.
#pragma once

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/gtc/type_precision.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

struct Vertex {
    glm::vec3 position{0.0f};
    glm::vec3 normal{0.0f, 1.0f, 0.0f};
    glm::vec4 tangent{1.0f, 0.0f, 0.0f, 1.0f}; // w is the sign of the bitangent, cross(normal, tangent) * w
    glm::vec2 uv{0.0f};                        // (0, 0) is the first byte of the image
    glm::vec4 color{1.0f};                     // multiplies the base color
    glm::u16vec4 joints{0};                    // of the skin of the node that draws the mesh
    glm::vec4 weights{0.0f};                   // of these joints; add up to 1 in skinned meshes
};

struct Image {
    int width = 0;
    int height = 0;
    std::vector<uint8_t> rgba; // 4 bytes per pixel, top row first
};

enum class Wrap { repeat, mirror, clamp };
enum class Filter { linear, nearest };

struct Texture {
    int image = -1;
    Wrap wrap_u = Wrap::repeat;
    Wrap wrap_v = Wrap::repeat;
    Filter filter = Filter::linear;
};

enum class AlphaMode { opaque, mask, blend };

// Factors multiply their textures. A texture of -1 means none, which counts as white.
struct Material {
    std::string name;
    glm::vec4 base_color{1.0f};
    int base_color_texture = -1; // sRGB
    float metallic = 0.0f;
    float roughness = 1.0f;
    int metallic_roughness_texture = -1; // roughness in green, metallic in blue
    int normal_texture = -1;
    float normal_scale = 1.0f;
    glm::vec3 emissive{0.0f};  // radiance, W/m2/sr
    int emissive_texture = -1; // sRGB
    AlphaMode alpha_mode = AlphaMode::opaque;
    float alpha_cutoff = 0.5f; // only for AlphaMode::mask
    bool double_sided = false;
    bool unlit = false; // the base color is the final color
};

// Indexed triangles, counter-clockwise when seen from the front.
struct Mesh {
    std::vector<Vertex> vertices;
    std::vector<uint32_t> indices;
    int material = 0;
};

// Scales first, translates last.
struct Transform {
    glm::vec3 translation{0.0f};
    glm::quat rotation{1.0f, 0.0f, 0.0f, 0.0f}; // w first
    glm::vec3 scale{1.0f};
};

// A world matrix with a negative determinant mirrors its meshes: their front faces are clockwise.
struct Node {
    int parent = -1;
    std::optional<Transform>
        rest; // what no animation touches; none where the file gives a matrix, which none may touch
    glm::mat4 local{1.0f};
    glm::mat4 world{1.0f};
    std::vector<int> meshes; // several nodes may draw the same mesh
    int skin = -1;           // then the joints place the meshes, and the world matrix does not
};

// Vertices follow nodes. A joint's matrix is the world matrix of its node times the inverse bind matrix.
struct Skin {
    std::vector<int> nodes; // one a joint
    std::vector<glm::mat4> inverse_bind;
};

enum class Interpolation { step, linear, cubic };

// A curve through keys. A cubic one has three values a key: the tangent before it (1/s), the value, the tangent after.
struct Sampler {
    Interpolation interpolation = Interpolation::linear;
    std::vector<float> times; // seconds, increasing, at least one
    std::vector<glm::vec4> values;
};

enum class AnimatedPart { translation, rotation, scale }; // a rotation is a quaternion, w last

struct Channel {
    int node = 0;
    AnimatedPart part = AnimatedPart::translation;
    int sampler = 0;
};

struct Animation {
    std::string name;
    float duration = 0.0f; // seconds
    std::vector<Sampler> samplers;
    std::vector<Channel> channels;
};

// Looks along the -Z axis of its world matrix, +Y is up in the picture.
struct Camera {
    glm::mat4 world{1.0f};
    bool orthographic = false;
    float vertical_fov = 1.0f; // radians, perspective only
    float half_height = 1.0f;  // metres, orthographic only
};

enum class LightKind { directional, point, spot };

// A light without a size, as KHR_lights_punctual has it. Shines along the -Z axis of its world matrix, a point light
// everywhere.
struct PunctualLight {
    LightKind kind = LightKind::point;
    glm::vec3 intensity{0.0f};  // W/sr; of a directional light its irradiance at normal incidence, W/m2
    float range = 0.0f;         // where its light ends, metres; 0: nowhere; not of directional lights
    float inner_cone = 0.0f;    // of a spot light, radians from its axis: up to here it is full,
    float outer_cone = 0.7854f; // and from here on dark
    int node = -1;              // that places it; none: it stands still
    glm::mat4 world{1.0f};
};

// Against the axis, unit length. A node without size has no axis.
inline glm::vec3 direction_to(const PunctualLight& light) {
    const glm::vec3 axis(light.world[2]);
    return axis != glm::vec3(0.0f) ? glm::normalize(axis) : glm::vec3(0.0f, 0.0f, 1.0f);
}

// to_sun: of any length.
inline PunctualLight sun_light(glm::vec3 to_sun, float strength) {
    PunctualLight sun;
    sun.kind = LightKind::directional;
    sun.intensity = glm::vec3(strength);
    sun.world[2] = glm::vec4(to_sun, 0.0f);
    return sun;
}

inline PunctualLight point_light(glm::vec3 position, float intensity) {
    PunctualLight point;
    point.intensity = glm::vec3(intensity);
    point.world[3] = glm::vec4(position, 1.0f);
    return point;
}

struct Scene {
    std::string name;
    std::vector<Image> images;
    std::vector<Texture> textures;
    std::vector<Material> materials;
    std::vector<Mesh> meshes;
    std::vector<Node> nodes; // a parent always stands before its children
    std::vector<Skin> skins;
    std::vector<Animation> animations;
    std::vector<Camera> cameras;
    std::vector<PunctualLight> lights;
    glm::vec3 bounds_min{0.0f}; // world space, at any time of the first animation
    glm::vec3 bounds_max{0.0f};
};

// Where everything stands at one moment.
struct Pose {
    std::vector<glm::mat4> nodes;  // world matrices
    std::vector<glm::mat4> joints; // of skin after skin
};

glm::mat4 to_matrix(const Transform& transform);

// One forward pass suffices because parents stand before their children.
inline void update_world_matrices(Scene* scene) {
    for (Node& node : scene->nodes) {
        node.world = node.parent < 0 ? node.local : scene->nodes[size_t(node.parent)].world * node.local;
    }
}

// Moves the nodes to where the first animation, which repeats for ever, has them. Without one, nothing happens.
void pose(Scene* scene, double seconds);

// As the nodes stand now.
Pose current_pose(const Scene& scene);

// Where each skin's joints start in Pose::joints; one number more than there are skins.
std::vector<int> first_joints_of(const Scene& scene);

// Needs at least one vertex and up-to-date world matrices. Leaves the nodes as they are at 0 seconds.
void update_bounds(Scene* scene);

// Reads a .gltf or .glb file. On failure returns false, sets *error to one sentence and leaves *scene alone.
bool load_gltf(const std::string& path, Scene* scene, std::string* error);

// A court with two storeys of columns, open to the sky, with drapes behind the columns. Needs no files.
Scene make_atrium();

// A hall with mirrors along one wall, columns and pictures along the other, and something that passes. Needs no files.
Scene make_gallery();
