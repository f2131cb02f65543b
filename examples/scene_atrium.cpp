// A procedural atrium: an open court, two storeys of fluted columns around it, and coloured drapes in the
// aisle behind the columns. From the court the columns hide parts of the drapes and of the sunlit walls,
// and one depth layer loses the light that these bounce. Solids are closed with counter-clockwise fronts;
// only faces buried in another solid are left out.
//
// A sun in direction (0.6, 0.6, 0.3) lights the sides at -X and -Z: their columns, the drapes behind them on
// the gallery, and half of the court. Seen from the gallery's corner, columns and drapes hide most of that.
#include "scene_shapes.hpp"

#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

namespace {

using glm::vec2;
using glm::vec3;

// All lengths in metres. The columns stand on the edge of the court, the aisle lies behind them.
const vec2 kCourt(12.0f, 5.0f); // half extents in x and z
constexpr float kAisleDepth = 4.0f;
constexpr float kWallThickness = 0.4f;
constexpr float kSlabThickness = 0.4f;
constexpr float kSlabOverhang = 0.4f; // of gallery and roof, into the court
constexpr float kGalleryHeight = 5.4f;
constexpr float kRoofHeight = 11.0f;
constexpr float kColumnHeight = 3.3f; // up to where the arches spring
constexpr float kArcadeThickness = 0.5f;
constexpr float kJambHalfWidth = 0.35f;  // of the wall that stands on a column between two arches
constexpr float kDrapeDistance = 1.75f;  // behind the column axis
constexpr float kBalusterSpacing = 0.3f; // centre to centre
constexpr float kEmbed = 0.01f;          // solids that touch overlap by this, so that no crack shows
constexpr float kTau = glm::two_pi<float>();

enum MaterialIndex { kStone, kWall, kFloor, kRed, kGreen, kBlue, kWood, kPlaster, kLamp, kMaterialCount };

// ---- Parts of the building ------------------------------------------------------------------------------

// A rectangular frame around the court, between two half extents in x and z.
void add_ring(Mesh* mesh, vec2 inner, vec2 outer, float bottom, float top) {
    const vec2 signs[] = {vec2(-1, 1), vec2(1, 1), vec2(1, -1), vec2(-1, -1)};
    const auto corner = [&](vec2 half_extent, int i, float y) {
        const vec2 p = half_extent * signs[i % 4];
        return vec3(p.x, y, p.y);
    };
    for (int i = 0; i < 4; ++i) {
        const int j = i + 1;
        add_quad(mesh, corner(outer, i, top), corner(outer, j, top), corner(inner, j, top), corner(inner, i, top));
        add_quad(mesh, corner(inner, i, bottom), corner(inner, j, bottom), corner(outer, j, bottom),
                 corner(outer, i, bottom));
        add_quad(mesh, corner(outer, i, bottom), corner(outer, j, bottom), corner(outer, j, top),
                 corner(outer, i, top));
        add_quad(mesh, corner(inner, j, bottom), corner(inner, i, bottom), corner(inner, i, top),
                 corner(inner, j, top));
    }
}

// Foot and capital narrow to less than the shaft, which reaches into both: no gap shows between them.
void add_column(Mesh* mesh, vec3 base) {
    const float plinth = 0.15f, foot = 0.25f, capital = 0.3f, abacus = 0.15f, overlap = 0.05f;
    const float shaft = kColumnHeight - plinth - foot - capital - abacus;
    const uint32_t flutes = 16, segments = 4 * flutes;

    add_box(mesh, base + vec3(0.0f, plinth / 2.0f, 0.0f), vec3(0.4f, plinth / 2.0f, 0.4f));
    base.y += plinth;
    add_lathe(mesh, base, foot, segments, 5, [](float v, float) { return 0.25f + 0.12f * std::sqrt(1.0f - v * v); });
    base.y += foot;
    add_lathe(mesh, base - vec3(0.0f, overlap, 0.0f), shaft + 2.0f * overlap, segments, 4, [](float v, float angle) {
        const float flute = std::abs(std::sin(angle * float(flutes) / 2.0f));
        return (0.3f - 0.04f * v * v) * (1.0f - 0.07f * flute);
    });
    base.y += shaft;
    add_lathe(mesh, base, capital, segments, 5,
              [](float v, float) { return 0.2f + 0.17f * std::sqrt(v * (2.0f - v)); });
    base.y += capital;
    add_box(mesh, base + vec3(0.0f, abacus / 2.0f, 0.0f), vec3(0.4f, abacus / 2.0f, 0.4f));
}

// A bay spans two neighbouring columns. Its frame: "along" points to the right as seen from the court.
struct Bay {
    vec3 start; // axis of the left column, at the foot of the storey
    vec3 along;
    vec3 inward; // towards the court
    float length;

    vec3 point(float distance, float height, float depth) const {
        return start + along * distance + inward * depth + vec3(0.0f, height, 0.0f);
    }
};

// The wall over the columns with a round arch cut out. Its ends meet the neighbours, its top is in the slab.
void add_arch(Mesh* mesh, const Bay& bay, float top) {
    const int segments = 16;
    const float depth = kArcadeThickness / 2.0f;
    const float radius = bay.length / 2.0f - kJambHalfWidth;
    const float springing = kColumnHeight - kEmbed;

    std::vector<vec2> edge = {vec2(0.0f, springing)}; // distance, height
    for (int i = 0; i <= segments; ++i) {
        const float angle = glm::pi<float>() * (1.0f - float(i) / float(segments));
        edge.emplace_back(bay.length / 2.0f + radius * std::cos(angle), springing + radius * std::sin(angle));
    }
    edge.emplace_back(bay.length, springing);

    for (size_t i = 0; i + 1 < edge.size(); ++i) {
        const vec2 a = edge[i], b = edge[i + 1];
        add_quad(mesh, bay.point(a.x, a.y, depth), bay.point(b.x, b.y, depth), bay.point(b.x, top, depth),
                 bay.point(a.x, top, depth));
        add_quad(mesh, bay.point(b.x, b.y, -depth), bay.point(a.x, a.y, -depth), bay.point(a.x, top, -depth),
                 bay.point(b.x, top, -depth));
    }
    add_surface(mesh, segments, 1, [&](float u, float v) {
        const float angle = glm::pi<float>() * (1.0f - u);
        return bay.point(bay.length / 2.0f + radius * std::cos(angle), springing + radius * std::sin(angle),
                         depth * (2.0f * v - 1.0f));
    });
}

// Covers the open ends of the two arcades that meet over a corner column.
void add_corner_pier(Mesh* mesh, vec3 foot, float top) {
    const float half_width = kArcadeThickness / 2.0f + 0.03f;
    const float half_height = (top - kColumnHeight) / 2.0f;
    add_box(mesh, foot + vec3(0.0f, kColumnHeight + half_height, 0.0f), vec3(half_width, half_height, half_width));
}

void add_balusters(Mesh* mesh, const Bay& bay) {
    const float column_clearance = 0.5f;
    const float span = bay.length - 2.0f * column_clearance;
    const int count = int(span / kBalusterSpacing) + 1;
    for (int i = 0; i < count; ++i) {
        const float distance = column_clearance + span * float(i) / float(count - 1);
        add_lathe(mesh, bay.point(distance, 0.1f - kEmbed, 0.0f), 0.8f + 2.0f * kEmbed, 8, 8,
                  [](float v, float) { return 0.03f + 0.045f * std::pow(std::sin(kTau * v * 0.75f), 2.0f); });
    }
}

// Hangs from the ceiling behind the first column of the bay, so that the column hides its middle.
void add_drape(Mesh* mesh, const Bay& bay, float bottom, float ceiling) {
    const float half_width = 1.15f, folds = 5.0f;
    add_surface(mesh, 40, 12, [&](float u, float v) {
        const float fullness = 0.07f + 0.08f * (1.0f - v); // the folds open towards the lower edge
        const float fold = fullness * std::sin(kTau * folds * u + 2.0f * v);
        const float gathered = half_width * (1.0f - 0.15f * v);
        return bay.point(gathered * (2.0f * u - 1.0f), glm::mix(bottom, ceiling + kEmbed, v), fold - kDrapeDistance);
    });
}

std::vector<Bay> bays_around_court() {
    std::vector<Bay> bays;
    const auto add_side = [&](vec3 inward, float side_length, float distance, int count) {
        const vec3 along = glm::cross(vec3(0.0f, 1.0f, 0.0f), inward);
        const float length = side_length / float(count);
        for (int i = 0; i < count; ++i) {
            const vec3 start = -inward * distance + along * (length * float(i) - side_length / 2.0f);
            bays.push_back({start, along, inward, length});
        }
    };
    add_side(vec3(0, 0, 1), 2.0f * kCourt.x, kCourt.y, 8);
    add_side(vec3(-1, 0, 0), 2.0f * kCourt.y, kCourt.x, 3);
    add_side(vec3(0, 0, -1), 2.0f * kCourt.x, kCourt.y, 8);
    add_side(vec3(1, 0, 0), 2.0f * kCourt.y, kCourt.x, 3);
    return bays;
}

void add_storey(Mesh* meshes, float floor, float ceiling) {
    const bool is_gallery = floor > 0.0f;
    int drape_count = 0;
    for (Bay bay : bays_around_court()) {
        bay.start.y = floor;
        const float height = ceiling - floor;
        add_column(&meshes[kStone], bay.start);
        add_arch(&meshes[kStone], bay, height + kEmbed);
        if (is_gallery) { add_balusters(&meshes[kStone], bay); }
        const bool at_corner = glm::abs(bay.start.x) == kCourt.x && glm::abs(bay.start.z) == kCourt.y;
        if (at_corner) {
            add_corner_pier(&meshes[kStone], bay.start, height + kEmbed);
        } else {
            add_drape(&meshes[kRed + drape_count++ % 3], bay, 0.6f, height);
        }
    }
}

void add_shell(Mesh* meshes) {
    const vec2 wall_inner = kCourt + kAisleDepth;
    const vec2 wall_outer = wall_inner + kWallThickness;
    const vec2 eaves = wall_outer + 0.1f; // floor and roof stick out under and over the wall
    const vec2 slab_inner = kCourt - kSlabOverhang;
    const vec2 slab_outer = wall_inner + kEmbed;
    const float rail_bottom = kGalleryHeight + 0.9f;

    add_box(&meshes[kFloor], vec3(0.0f, -kSlabThickness / 2.0f, 0.0f), vec3(eaves.x, kSlabThickness / 2.0f, eaves.y));
    add_ring(&meshes[kWall], wall_inner, wall_outer, -kEmbed, kRoofHeight - kSlabThickness + kEmbed);
    add_ring(&meshes[kStone], slab_inner, slab_outer, kGalleryHeight - kSlabThickness, kGalleryHeight);
    add_ring(&meshes[kStone], slab_inner, eaves, kRoofHeight - kSlabThickness, kRoofHeight);
    add_ring(&meshes[kStone], kCourt - 0.1f, kCourt + 0.1f, kGalleryHeight - kEmbed, kGalleryHeight + 0.1f);
    add_ring(&meshes[kStone], kCourt - 0.1f, kCourt + 0.1f, rail_bottom, rail_bottom + 0.12f);
}

void add_lamp(Mesh* meshes, vec3 center) {
    const float ceiling = kGalleryHeight - kSlabThickness;
    add_sphere(&meshes[kLamp], center, 0.35f);
    add_lathe(&meshes[kWood], center, ceiling + kEmbed - center.y, 8, 1, [](float, float) { return 0.015f; });
}

void add_furniture(Mesh* meshes) {
    add_box(&meshes[kWood], vec3(-3.4f, 0.5f, -0.9f), vec3(0.6f, 0.5f, 0.4f), 0.4f);
    add_box(&meshes[kWood], vec3(-3.5f, 1.25f, -0.9f), vec3(0.3f, 0.25f, 0.3f), -0.3f);
    add_box(&meshes[kPlaster], vec3(2.5f, 0.75f, -2.4f), vec3(0.5f, 0.75f, 0.5f), 0.7f);
    add_box(&meshes[kPlaster], vec3(6.5f, 0.3f, 1.5f), vec3(1.2f, 0.3f, 0.5f), 0.1f);
    add_sphere(&meshes[kPlaster], vec3(-0.5f, 0.8f, -2.6f), 0.8f);
    add_lamp(meshes, vec3(-4.5f, 3.4f, -7.6f));
    add_lamp(meshes, vec3(7.5f, 3.4f, 7.6f));
}

// ---- Materials, texture, camera -------------------------------------------------------------------------

// Two courses of two slabs each, the second course shifted by half a slab, with dark joints.
Image slab_image() {
    const int size = 256, slab = size / 2, joint = 3; // pixels
    const uint8_t tones[2][2] = {{232, 214}, {222, 240}};
    Image image{size, size, {}};
    for (int y = 0; y < size; ++y) {
        const int course = y / slab;
        for (int x = 0; x < size; ++x) {
            const int shifted = (x + course * slab / 2) % size;
            const bool in_joint = y % slab < joint || shifted % slab < joint;
            const uint8_t tone = in_joint ? 120 : tones[course][shifted / slab];
            image.rgba.insert(image.rgba.end(), {tone, tone, tone, 255});
        }
    }
    return image;
}

Material drape(const char* name, vec3 base_color) {
    Material material = matte(name, base_color);
    material.double_sided = true;
    return material;
}

Material slabs(const char* name, vec3 base_color) {
    Material material = matte(name, base_color);
    material.base_color_texture = 0;
    return material;
}

std::vector<Material> make_materials() {
    std::vector<Material> materials(kMaterialCount);
    materials[kStone] = matte("stone", vec3(0.72f, 0.68f, 0.60f));
    materials[kWall] = slabs("wall", vec3(0.80f, 0.74f, 0.64f));
    materials[kFloor] = slabs("floor", vec3(0.62f, 0.60f, 0.57f));
    materials[kRed] = drape("red drape", vec3(0.75f, 0.04f, 0.03f));
    materials[kGreen] = drape("green drape", vec3(0.05f, 0.55f, 0.08f));
    materials[kBlue] = drape("blue drape", vec3(0.04f, 0.10f, 0.70f));
    materials[kWood] = matte("wood", vec3(0.36f, 0.20f, 0.10f));
    materials[kPlaster] = matte("plaster", vec3(0.85f, 0.85f, 0.85f));
    materials[kLamp] = matte("lamp", vec3(0.8f));
    materials[kLamp].emissive = vec3(2.4f, 1.7f, 1.0f);
    return materials;
}

// On the gallery behind a drape of the short side: it hides the sunlit cloth that the columns mirror.
Camera make_camera() {
    const vec3 eye(-13.8f, 7.1f, 3.5f);
    const vec3 target(-4.0f, 5.5f, -6.0f);
    Camera camera;
    camera.world = glm::inverse(glm::lookAt(eye, target, vec3(0.0f, 1.0f, 0.0f)));
    camera.vertical_fov = glm::radians(60.0f);
    return camera;
}

} // namespace

Scene make_atrium() {
    Scene scene;
    scene.name = "atrium";
    scene.images = {slab_image()};
    scene.textures.resize(1);
    scene.textures[0].image = 0;
    scene.materials = make_materials();
    scene.meshes.resize(kMaterialCount);
    scene.nodes.resize(1);
    for (int i = 0; i < kMaterialCount; ++i) {
        scene.meshes[size_t(i)].material = i;
        scene.nodes[0].meshes.push_back(i);
    }
    add_shell(scene.meshes.data());
    add_storey(scene.meshes.data(), 0.0f, kGalleryHeight - kSlabThickness);
    add_storey(scene.meshes.data(), kGalleryHeight, kRoofHeight - kSlabThickness);
    add_furniture(scene.meshes.data());
    scene.cameras = {make_camera()};
    update_bounds(&scene);
    return scene;
}
