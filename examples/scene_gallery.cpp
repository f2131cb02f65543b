// A procedural gallery for reflections: mirrors along one wall, pictures along the other, and a row of columns in front of the
// pictures. From the camera the columns hide parts of the pictures that the mirrors show, and so does the visitor, a sphere
// on a plinth that glides up and down the hall in ten seconds: one depth layer loses them, and they come and go as it passes.
#include "scene_shapes.hpp"

#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

namespace {

using glm::vec3;

// All lengths in metres. The hall reaches from +kDepthNear to -kDepthFar along z.
constexpr float kHalfWidth = 4.0f, kHeight = 4.6f, kDepthNear = 3.5f, kDepthFar = 16.0f;
constexpr float kWallThickness = 0.3f;
constexpr float kBay = 2.5f; // from column to column, and from picture to picture
constexpr int kBays = 7;
constexpr float kColumnX = -2.2f, kColumnRadius = 0.32f;
constexpr float kVisitorX = -0.9f;

enum MaterialIndex { kWall, kFloor, kColumn, kMirror, kFrame, kCeilingLamp, kVisitor, kFirstPicture };

// Saturated and unlike their neighbours, so that what a mirror shows can be told apart.
const vec3 kPictureColors[] = {
    {0.80f, 0.10f, 0.06f}, {0.06f, 0.25f, 0.75f}, {0.85f, 0.62f, 0.06f}, {0.07f, 0.50f, 0.14f}, {0.60f, 0.08f, 0.50f}};
constexpr int kPictureColorCount = int(std::size(kPictureColors));
constexpr int kMaterialCount = kFirstPicture + kPictureColorCount;

float bay_z(float bay) { return 0.5f * kBay - bay * kBay; }

// Tiles of half a metre in two tones.
Image tile_image() {
    const int size = 128, tile = size / 4; // pixels
    Image image{size, size, {}};
    for (int y = 0; y < size; ++y) {
        for (int x = 0; x < size; ++x) {
            const uint8_t tone = (x / tile + y / tile) % 2 == 0 ? 235 : 150;
            image.rgba.insert(image.rgba.end(), {tone, tone, tone, 255});
        }
    }
    return image;
}

std::vector<Material> make_materials() {
    std::vector<Material> materials(kMaterialCount);
    materials[kWall] = matte("wall", vec3(0.75f, 0.72f, 0.66f));
    materials[kFloor] = matte("polished floor", vec3(0.45f, 0.43f, 0.40f));
    materials[kFloor].base_color_texture = 0;
    materials[kFloor].roughness = 0.2f;
    materials[kColumn] = matte("column", vec3(0.80f, 0.78f, 0.74f));
    materials[kMirror] = matte("mirror", vec3(0.95f));
    materials[kMirror].metallic = 1.0f;
    materials[kMirror].roughness = 0.0f;
    materials[kFrame] = matte("frame", vec3(0.30f, 0.17f, 0.07f));
    materials[kCeilingLamp] = matte("lamp", vec3(0.8f));
    materials[kCeilingLamp].emissive = vec3(3.0f, 2.8f, 2.5f);
    materials[kVisitor] = matte("visitor", vec3(0.85f, 0.85f, 0.88f));
    for (int i = 0; i < kPictureColorCount; ++i) {
        materials[size_t(i) + kFirstPicture] = matte("picture", kPictureColors[i]);
    }
    return materials;
}

void add_shell(Mesh* meshes) {
    const float middle = 0.5f * (kDepthNear - kDepthFar), half_depth = 0.5f * (kDepthNear + kDepthFar);
    const float outside = kHalfWidth + kWallThickness, t = 0.5f * kWallThickness;
    add_box(&meshes[kFloor], vec3(0.0f, -t, middle), vec3(outside, t, half_depth));
    add_box(&meshes[kWall], vec3(0.0f, kHeight + t, middle), vec3(outside, t, half_depth));
    for (const float side : {-1.0f, 1.0f}) {
        add_box(&meshes[kWall], vec3(side * (kHalfWidth + t), 0.5f * kHeight, middle),
                vec3(t, 0.5f * kHeight, half_depth));
    }
    for (const float z : {kDepthNear + t, -kDepthFar - t}) {
        add_box(&meshes[kWall], vec3(0.0f, 0.5f * kHeight, z), vec3(outside, 0.5f * kHeight, t));
    }
}

void add_bay(Mesh* meshes, int bay) {
    const float at = bay_z(float(bay) + 0.5f), column = bay_z(float(bay));
    const float half_length = 0.4f * kBay;
    add_lathe(&meshes[kColumn], vec3(kColumnX, -0.01f, column), kHeight + 0.02f, 48, 12, [](float v, float) {
        const float end = glm::clamp((std::abs(v - 0.5f) - 0.44f) / 0.05f, 0.0f, 1.0f); // foot and capital
        return kColumnRadius * (1.0f + 0.3f * end * end);
    });
    add_box(&meshes[kFrame], vec3(-kHalfWidth, 2.0f, at), vec3(0.06f, 1.1f, half_length));
    add_box(&meshes[kFirstPicture + bay % kPictureColorCount], vec3(-kHalfWidth + 0.05f, 2.0f, at),
            vec3(0.03f, 1.0f, half_length - 0.1f));
    // a second picture within the first, so that a mirrored one has more than one edge
    add_box(&meshes[kFirstPicture + (bay + 2) % kPictureColorCount], vec3(-kHalfWidth + 0.07f, 2.2f, at),
            vec3(0.03f, 0.4f, 0.4f));
    add_box(&meshes[kFrame], vec3(kHalfWidth, 2.0f, at), vec3(0.05f, 1.9f, half_length + 0.05f));
    add_box(&meshes[kMirror], vec3(kHalfWidth - 0.04f, 2.0f, at), vec3(0.03f, 1.85f, half_length));
    if (bay % 2 == 1) { add_box(&meshes[kCeilingLamp], vec3(0.8f, kHeight, at), vec3(0.5f, 0.05f, 0.8f)); }
}

// Around its own origin: the node moves it.
Mesh make_visitor() {
    Mesh mesh;
    mesh.material = kVisitor;
    add_box(&mesh, vec3(0.0f, 0.55f, 0.0f), vec3(0.3f, 0.55f, 0.3f));
    add_sphere(&mesh, vec3(0.0f, 1.55f, 0.0f), 0.5f);
    return mesh;
}

// To the far end of the hall and back.
Animation make_walk(int node) {
    const float near = -1.0f, far = -11.0f;
    Animation animation;
    animation.name = "walk";
    animation.duration = 10.0f;
    Sampler sampler;
    sampler.times = {0.0f, 5.0f, 10.0f};
    for (const float z : {near, far, near}) { sampler.values.emplace_back(kVisitorX, 0.0f, z, 0.0f); }
    animation.samplers = {sampler};
    animation.channels = {{node, AnimatedPart::translation, 0}};
    return animation;
}

// Under the lamps, which give light to the eye alone: a renderer's emissive surfaces cast none.
std::vector<PunctualLight> make_lights() {
    std::vector<PunctualLight> lights;
    for (int bay = 1; bay < kBays; bay += 2) {
        lights.push_back(point_light(vec3(0.8f, kHeight - 0.5f, bay_z(float(bay) + 0.5f)), 14.0f));
    }
    return lights;
}

Camera make_camera() {
    Camera camera;
    camera.world = glm::inverse(glm::lookAt(vec3(1.0f, 1.7f, 2.8f), vec3(0.9f, 1.65f, -10.0f), vec3(0.0f, 1.0f, 0.0f)));
    camera.vertical_fov = glm::radians(60.0f);
    return camera;
}

} // namespace

Scene make_gallery() {
    Scene scene;
    scene.name = "gallery";
    scene.images = {tile_image()};
    scene.textures.resize(1);
    scene.textures[0].image = 0;
    scene.materials = make_materials();
    scene.meshes.resize(kMaterialCount);
    scene.nodes.resize(2);
    for (int i = 0; i < kMaterialCount; ++i) { scene.meshes[size_t(i)].material = i; }
    add_shell(scene.meshes.data());
    for (int bay = 0; bay < kBays; ++bay) { add_bay(scene.meshes.data(), bay); }
    scene.meshes[kVisitor] = make_visitor();
    for (int i = 0; i < kMaterialCount; ++i) { scene.nodes[i == kVisitor ? 1 : 0].meshes.push_back(i); }
    scene.nodes[1].rest = Transform{vec3(kVisitorX, 0.0f, -1.0f)};
    scene.animations = {make_walk(1)};
    scene.lights = make_lights();
    scene.cameras = {make_camera()};
    pose(&scene, 0.0);
    update_bounds(&scene);
    return scene;
}
