// The reference's rays against closed forms, against a loop over all triangles, and against what the examples draw.
#include "headless.h"
#include "reference.hpp"
#include "scene_renderer.hpp"
#include "test_scenes.hpp"

#include <glm/gtc/type_ptr.hpp>

#include <algorithm>
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstdio>
#include <random>

extern "C" {
#include <cmocka.h>
}

namespace {

using glm::dvec2;
using glm::dvec3;
using glm::vec2;
using glm::vec3;
using glm::vec4;

headless window;

int open_context(void**) {
    char error[256] = "";
    const bool opened = headless_create(&window, 3, 3, false, false, error, sizeof error);
    if (!opened) { std::printf("# %s\n", error); }
    return opened ? 0 : -1;
}

int close_context(void**) {
    headless_destroy(&window);
    return 0;
}

// ---- Scenes ---------------------------------------------------------------------------------------------

// 8 x 8 texels without filter: no level of detail that could differ.
int add_checkers(Scene* scene, bool alpha) {
    Image image{8, 8, {}};
    for (int i = 0; i < 64; ++i) {
        const uint8_t tone = (i + i / 8) % 2 == 0 ? 250 : 60;
        image.rgba.insert(image.rgba.end(), {tone, uint8_t(tone / 2), 200, alpha ? tone : uint8_t(255)});
    }
    Texture texture;
    texture.image = int(scene->images.size());
    texture.filter = Filter::nearest;
    texture.wrap_u = Wrap::mirror;
    texture.wrap_v = Wrap::clamp;
    scene->images.push_back(image);
    scene->textures.push_back(texture);
    return texture.image;
}

// A skin of two joints for the square: the right half turns about the Y axis.
void add_skin(Scene* scene, Mesh* mesh) {
    for (Vertex& vertex : mesh->vertices) {
        const float right = 0.5f + 0.5f * vertex.position.x;
        vertex.joints = glm::u16vec4(0, 1, 0, 0);
        vertex.weights = vec4(1.0f - right, right, 0.0f, 0.0f);
    }
    const int first = int(scene->nodes.size());
    for (const float degrees : {0.0f, 60.0f}) {
        Node joint = node_at(at(vec3(3.0f, 1.0f, -4.0f), vec3(0.8f), degrees), 0);
        joint.meshes.clear();
        scene->nodes.push_back(joint);
    }
    scene->skins.push_back({{first, first + 1}, {glm::mat4(1.0f), glm::mat4(1.0f)}});
}

enum Stuff { kWall, kMask, kCloth, kGlow, kFlatColor, kMetal, kGlass, kStuffCount };

// Everything that draws in its own way, in front of a wall: cut out, seen from behind with and without a back, mirrored,
// squeezed, skinned, glowing, without light, of metal, and glass, which is not drawn.
Scene make_zoo() {
    Scene scene;
    scene.name = "zoo";
    scene.materials.resize(kStuffCount);
    scene.materials[kWall].base_color = vec4(0.6f, 0.5f, 0.4f, 1.0f);
    scene.materials[kWall].base_color_texture = add_checkers(&scene, false);
    scene.materials[kMask].alpha_mode = AlphaMode::mask;
    const int checkers = scene.materials[kMask].base_color_texture = add_checkers(&scene, true);
    scene.materials[kMask].normal_texture = scene.materials[kGlow].normal_texture = checkers;
    scene.materials[kMask].normal_scale = 0.5f;
    scene.materials[kMask].emissive = vec3(0.3f);
    scene.materials[kMask].emissive_texture = checkers;
    scene.materials[kMask].metallic = 0.5f;
    scene.materials[kMask].metallic_roughness_texture = checkers;
    scene.materials[kCloth].base_color = vec4(0.7f, 0.1f, 0.2f, 1.0f);
    scene.materials[kCloth].double_sided = true;
    scene.materials[kGlow].base_color = vec4(0.2f, 0.2f, 0.9f, 1.0f);
    scene.materials[kGlow].emissive = vec3(0.5f, 0.25f, 0.125f);
    scene.materials[kFlatColor].base_color = vec4(0.25f, 0.75f, 0.5f, 1.0f);
    scene.materials[kFlatColor].unlit = true;
    scene.materials[kMetal].metallic = 0.75f;
    scene.materials[kGlass].alpha_mode = AlphaMode::blend;
    for (int material = 0; material < kStuffCount; ++material) { scene.meshes.push_back(square(material)); }

    for (Vertex& vertex : scene.meshes[kFlatColor].vertices) { vertex.normal = vec3(0.6f, 0.0f, 0.8f); }

    scene.nodes.push_back(node_at(at(vec3(0.0f, 0.0f, -6.0f), vec3(7.0f)), kWall));
    for (Vertex& vertex : scene.meshes[kMask].vertices) { vertex.uv = 2.5f * vertex.uv - 0.3f; }
    scene.nodes.push_back(node_at(at(vec3(-3.0f, 1.2f, -5.0f), vec3(1.0f), 20.0f), kMask));
    scene.nodes.push_back(node_at(at(vec3(-1.0f, 1.2f, -5.0f), vec3(0.8f), 160.0f), kCloth)); // its back
    scene.nodes.push_back(node_at(at(vec3(0.0f, 0.0f, -2.0f), vec3(3.0f), 180.0f), kWall));   // culled
    scene.nodes.push_back(node_at(at(vec3(1.0f, 1.2f, -5.0f), vec3(-0.8f, 0.8f, 0.8f), -25.0f), kGlow));
    scene.nodes.push_back(node_at(at(vec3(-2.5f, -1.2f, -5.0f), vec3(0.5f, 0.9f, 2.0f), 30.0f), kFlatColor));
    scene.nodes.push_back(node_at(at(vec3(-0.5f, -1.2f, -4.0f), vec3(0.7f), 40.0f, vec3(1.0f, 0.0f, 0.0f)), kMetal));
    scene.nodes.push_back(node_at(at(vec3(0.0f, 0.0f, -3.0f), vec3(2.0f)), kGlass));
    scene.meshes.push_back(square(kCloth));
    for (Vertex& vertex : scene.meshes.back().vertices) { vertex.color = vec4(0.5f + 0.5f * vertex.uv, 1.0f, 1.0f); }
    add_skin(&scene, &scene.meshes.back());
    Node skinned = node_at(at(vec3(100.0f)), kStuffCount); // the joints place it
    skinned.skin = 0;
    scene.nodes.push_back(skinned);
    update_bounds(&scene);
    return scene;
}

// ---- Drawn and traced -----------------------------------------------------------------------------------

struct Shot {
    const Scene* scene;
    RenderCamera camera;
    ClipRange clip = ClipRange::reversed;
    int width = 160, height = 90, layers = 1; // pixels
    std::vector<PunctualLight> lights{};
    float separation = 0.5f; // metres
};

ReferenceView view_of(const Shot& shot) {
    ReferenceView view;
    view.view = view_matrix(shot.camera);
    view.projection = projection_matrix(shot.camera, float(shot.width) / float(shot.height), shot.clip);
    view.clip = shot.clip;
    view.width = shot.width;
    view.height = shot.height;
    return view;
}

struct DrawnLayer {
    std::vector<float> z, normal, albedo, radiance;
};

// Peeled by the library.
std::vector<DrawnLayer> draw(const Shot& shot) {
    const GpuScene gpu_scene(*shot.scene);
    SceneLights lights(*shot.scene, gpu_scene, shot.lights);
    PassTimes times(false);
    RendererDesc desc;
    desc.get_proc = headless_get_proc;
    desc.layers.width = shot.width;
    desc.layers.height = shot.height;
    desc.layers.guard_band = 5;
    desc.layers.layers = shot.layers;
    desc.layers.oracle = DGB_ORACLE_PEEL;
    desc.layers.reversed = shot.clip != ClipRange::standard;
    desc.layers.clip = desc.layers.reversed ? DGB_CLIP_ZERO_TO_ONE : DGB_CLIP_NEGATIVE_ONE_TO_ONE;
    desc.scene = &gpu_scene;
    desc.lights = &lights;
    desc.times = &times;
    SceneRenderer renderer(desc);
    lights.update(*gpu_scene.first_pose());
    dgb_params params = dgb_preset(DGB_PRESET_QUALITY);
    params.separation = shot.separation;
    params.strict_separation = false; // against the layer in front, a peel needs none
    const ReferenceView view = view_of(shot);
    renderer.render(view.view, view.projection, params);
    std::vector<DrawnLayer> layers;
    for (int i = 0; i < shot.layers; ++i) {
        layers.push_back({renderer.read_z(i), renderer.read_normals(i), renderer.read_texture(DGB_ALBEDO, i, GL_RGB),
                          renderer.read_texture(DGB_RADIANCE, i, GL_RGB)});
    }
    return layers;
}

using Layers = std::vector<std::vector<Surface>>;

// Whether the picture ends within `reach` pixels of this one, or has a pixel there from which this one differs.
template <typename Differs>
bool on_edge(const ReferenceView& view, size_t pixel, int reach, Differs differs) {
    const int x = int(pixel) % view.width, y = int(pixel) / view.width;
    if (x < reach || y < reach || x >= view.width - reach || y >= view.height - reach) { return true; }
    for (int dy = -reach; dy <= reach; ++dy) {
        for (int dx = -reach; dx <= reach; ++dx) {
            if (differs(pixel, size_t(y + dy) * size_t(view.width) + size_t(x + dx))) { return true; }
        }
    }
    return false;
}

// Whether a neighbour shows another triangle, in any of the layers 0 to `last`.
bool on_silhouette(const Layers& layers, size_t last, const ReferenceView& view, size_t pixel) {
    return on_edge(view, pixel, 1, [&](size_t i, size_t j) {
        const auto differs = [=](const std::vector<Surface>& layer) {
            return layer[i].part != layer[j].part || layer[i].triangle != layer[j].triangle;
        };
        return std::any_of(layers.begin(), layers.begin() + std::ptrdiff_t(last) + 1, differs);
    });
}

// Of each pixel, whether any light reaches it.
std::vector<bool> lit_pixels(const ReferenceScene& scene, const std::vector<Surface>& layer) {
    std::vector<bool> lit;
    for (const Surface& s : layer) { lit.push_back(s.found() && scene.irradiance_of_lights(s) != vec3(0.0f)); }
    return lit;
}

// Metres of z from a pixel to the next, of the plane of the triangle: what of it moves when a vertex is snapped.
double slope(const PixelRays& rays, const ReferenceView& view, const Surface& surface, size_t pixel) {
    const auto z_at = [&](size_t i) {
        const Ray ray = rays.through(i);
        const dvec3 n(surface.face_normal);
        const double t = dot(n, dvec3(surface.position) - dvec3(ray.origin)) / dot(n, dvec3(ray.direction));
        return double(rays.z_of(ray.origin)) - t * rays.depth_along(ray);
    };
    const double here = z_at(pixel);
    return std::abs(z_at(pixel + 1) - here) + std::abs(z_at(pixel + size_t(view.width)) - here);
}

struct Count {
    int compared = 0, wrong = 0;
    double worst = 0.0; // of error over bound

    void add(double error, double bound) {
        ++compared;
        wrong += !(error <= bound);
        worst = std::max(worst, error / bound);
    }
    double share() const { return double(wrong) / std::max(compared, 1); }
    void print(const char* what) const {
        std::printf("# %-22s %6d compared, %d beyond the bound, at most %.3f of it\n", what, compared, wrong, worst);
    }
};

// ---- Rays of pixels -------------------------------------------------------------------------------------

// Every point of a pixel's ray is drawn at that pixel by the library's own widened and jittered projection.
void test_pixel_rays(void**) {
    RenderCamera camera;
    camera.eye = vec3(3.0f, 2.0f, -1.0f);
    camera.target = vec3(-4.0f, 1.0f, 5.0f);
    const float jitter[2] = {0.25f, -0.375f};
    std::mt19937 random(1);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    for (int variant = 0; variant < 5; ++variant) {
        ReferenceView view;
        view.width = 64;
        view.height = 40;
        view.guard = 9;
        view.jitter = vec2(jitter[0], jitter[1]);
        view.clip = variant == 2   ? ClipRange::reversed_infinite
                    : variant == 1 ? ClipRange::reversed
                                   : ClipRange::standard;
        camera.height = variant == 3 ? 8.0f : 0.0f;
        view.view = view_matrix(camera);
        view.projection = projection_matrix(camera, 1.6f, view.clip);
        if (variant == 4) { view.projection[2][0] = 0.3f; } // off-centre
        glm::mat4 widened;
        dgb_widen_projection(glm::value_ptr(view.projection), view.width, view.height, view.guard, jitter,
                             glm::value_ptr(widened));
        const PixelRays rays(view);
        for (int i = 0; i < 200; ++i) {
            const dvec2 pixel(uniform(random) * view.columns(), uniform(random) * view.rows());
            const Ray ray = rays.through(pixel);
            const double along = uniform(random) * 50.0;
            const dvec3 point = dvec3(ray.origin) + along * dvec3(ray.direction);
            const glm::dvec4 clip = glm::dmat4(widened) * glm::dmat4(view.view) * glm::dvec4(point, 1.0);
            const dvec2 drawn = (dvec2(clip) / clip.w * 0.5 + 0.5) * dvec2(view.columns(), view.rows());
            // single-precision matrices and rays: 1e-7 of some 50 pixels and of a distance 1000 times the near plane's
            assert_true(glm::distance(drawn, pixel) < (along < 1.0 ? 1e-2 : 1e-3));
            const double z = (glm::dmat4(view.view) * glm::dvec4(point, 1.0)).z;
            assert_true(std::abs(z - (double(rays.z_of(ray.origin)) - along * rays.depth_along(ray))) < 1e-4);
        }
        const Ray middle = rays.through(dvec2(view.columns(), view.rows()) * 0.5);
        assert_true(std::abs(rays.z_of(middle.origin) + camera.near_plane) < 1e-4f);
        const bool endless = view.clip == ClipRange::reversed_infinite;
        assert_int_equal(std::isinf(middle.farthest), endless);
        if (!endless) {
            const double end = double(rays.z_of(middle.origin)) - double(middle.farthest) * rays.depth_along(middle);
            assert_true(std::abs(end + double(camera.far_plane)) <
                        0.2); // a matrix holds the far plane to 1e-7 far / near
        }
    }
}

// ---- Closest hits ---------------------------------------------------------------------------------------

struct Brute {
    double distance = std::numeric_limits<double>::infinity();
    vec3 face_normal{0.0f};
};

// Without Embree, of the atrium, which has one node and only opaque materials.
Brute closest_of_all(const Scene& scene, const Ray& ray, Faces faces) {
    Brute best;
    const dvec3 o(ray.origin), d(ray.direction);
    for (const Mesh& mesh : scene.meshes) {
        for (size_t i = 0; i < mesh.indices.size(); i += 3) {
            const dvec3 a(mesh.vertices[mesh.indices[i]].position), b(mesh.vertices[mesh.indices[i + 1]].position),
                c(mesh.vertices[mesh.indices[i + 2]].position);
            const dvec3 n = cross(b - a, c - a);
            const double facing = dot(n, d), t = dot(n, a - o) / facing;
            const bool front_only = faces == Faces::front && !scene.materials[size_t(mesh.material)].double_sided;
            if ((front_only && facing >= 0.0) || !(t > 0.0) || t >= best.distance) { continue; }
            const dvec3 p = o + t * d;
            const bool inside = dot(n, cross(b - a, p - a)) >= 0.0 && dot(n, cross(c - b, p - b)) >= 0.0 &&
                                dot(n, cross(a - c, p - c)) >= 0.0;
            if (inside) { best = {t, vec3(glm::normalize(facing < 0.0 ? n : -n))}; }
        }
    }
    return best;
}

void test_closest(void**) {
    const Scene atrium = make_atrium();
    const ReferenceScene scene(atrium, current_pose(atrium), {});
    std::mt19937 random(2);
    std::normal_distribution<float> normal(0.0f, 1.0f);
    int differ = 0, hits = 0;
    for (int i = 0; i < 300; ++i) {
        Ray ray;
        ray.origin =
            vec3(4.0f, 1.0f, 3.0f) * vec3(normal(random), normal(random), normal(random)) + vec3(0.0f, 4.0f, 0.0f);
        ray.direction = glm::normalize(vec3(normal(random), normal(random), normal(random)));
        const Faces faces = i % 2 == 0 ? Faces::front : Faces::both;
        const Surface surface = scene.closest(ray, faces);
        const Brute brute = closest_of_all(atrium, ray, faces);
        hits += surface.found();
        // positions of 30 m are rounded to 2^-22 of that; along a grazing ray that is more
        const float cosine = std::abs(dot(brute.face_normal, ray.direction)),
                    rounding = 1e-5f / std::max(cosine, 1e-3f);
        const bool same = std::isinf(brute.distance)
                              ? !surface.found()
                              : std::abs(double(surface.distance) - brute.distance) < double(rounding) &&
                                    dot(surface.face_normal, brute.face_normal) > 0.9999f;
        differ += !same; // along an edge, one of the two may slip through
        const vec3 there = ray.origin + surface.distance * ray.direction;
        if (same && surface.found()) { assert_true(glm::distance(there, surface.position) < rounding); }
        assert_true(scene.occluded(ray) == scene.closest(ray, Faces::both).found());
    }
    std::printf("# %d of 300 rays hit, %d differ from the loop over all triangles\n", hits, differ);
    assert_true(hits > 200 && differ <= 1);
}

// ---- Layers ---------------------------------------------------------------------------------------------

RenderCamera atrium_camera(const Scene& atrium, int number) {
    RenderCamera camera = camera_of_file(atrium.cameras[0], atrium);
    if (number == 1) {
        camera.eye = vec3(-8.0f, 1.7f, -7.0f);
        camera.target = vec3(5.0f, 2.0f, 5.0f);
        camera.up = vec3(0.0f, 1.0f, 0.0f);
    }
    set_planes(atrium, &camera);
    return camera;
}

// Depth of the library's layers against the rays', away from edges. A driver snaps vertices to 1/256 pixel, which moves
// what a triangle shows at a pixel by half of that along each axis; and depth is stored to 24 bits, here of its own
// distance.
void check_layers(const Shot& shot) {
    const ReferenceView view = view_of(shot);
    const ReferenceScene scene(*shot.scene, current_pose(*shot.scene), {});
    const auto traced = trace_layers(scene, view, shot.layers, shot.separation);
    const std::vector<DrawnLayer> drawn = draw(shot);
    const PixelRays rays(view);
    for (size_t layer = 0; layer < drawn.size(); ++layer) {
        Count away, everywhere;
        for (size_t i = 0; i < view.pixels(); ++i) {
            const Surface& surface = traced[layer][i];
            const bool both = surface.found() && drawn[layer].z[i] != 0.0f;
            const bool neither = !surface.found() && drawn[layer].z[i] == 0.0f;
            const double error = both      ? std::abs(double(surface.z) - double(drawn[layer].z[i]))
                                 : neither ? 0.0
                                           : std::numeric_limits<double>::infinity();
            const double bound =
                both ? 1e-5 * std::abs(double(surface.z)) + slope(rays, view, surface, i) / 256.0 : 1.0;
            if (surface.found() || drawn[layer].z[i] != 0.0f) { everywhere.add(error, bound); }
            if (!on_silhouette(traced, layer, view, i)) { away.add(error, bound); }
        }
        std::printf("# layer %d: %.1f %% of the pixels are away from edges\n", int(layer),
                    100.0 * away.compared / double(view.pixels()));
        away.print("depth away from edges");
        everywhere.print("depth of all pixels");
        assert_int_equal(away.wrong, 0);
        assert_true(away.compared > 1000);
        assert_true(everywhere.share() < 1e-3); // vertices snapped across a pixel's centre
    }
}

void test_layers_of_atrium(void**) {
    const Scene atrium = make_atrium();
    for (int camera = 0; camera < 2; ++camera) {
        Shot shot{&atrium, atrium_camera(atrium, camera)};
        shot.width = 320;
        shot.height = 180;
        shot.layers = 4;
        check_layers(shot);
    }
}

void test_layers_of_orthographic_views(void**) {
    const Scene atrium = make_atrium();
    Shot shot{&atrium, atrium_camera(atrium, 0)};
    shot.camera.height = 12.0f;
    shot.width = 320;
    shot.height = 180;
    shot.layers = 3;
    check_layers(shot);
}

void test_layers_without_separation(void**) {
    const Scene atrium = make_atrium();
    Shot shot{&atrium, atrium_camera(atrium, 1)};
    shot.width = 320;
    shot.height = 180;
    shot.layers = 2;
    shot.separation = 0.0f;
    check_layers(shot);
}

// Squares one behind the other: which ones are kept is a matter of strictly more than the separation.
void test_separation(void**) {
    Scene scene;
    scene.materials.resize(1);
    scene.meshes.push_back(square(0));
    for (int i = 0; i < 12; ++i) {
        scene.nodes.push_back(node_at(at(vec3(0.0f, 0.0f, -4.0f - 0.25f * float(i)), vec3(8.0f)), 0));
    }
    const ReferenceScene traced(scene, current_pose(scene), {});
    ReferenceView view;
    view.width = view.height = 8;
    view.guard = 1;
    view.projection = glm::perspectiveRH_NO(1.0f, 1.0f, 0.1f, 100.0f);
    const float separations[] = {0.0f, 0.2f, 0.3f, 0.6f, 10.0f};
    const int steps[] = {1, 1, 2, 3, 100};
    for (int i = 0; i < 5; ++i) {
        const auto layers = trace_layers(traced, view, 8, separations[i]);
        for (int layer = 0; layer < 8; ++layer) {
            for (const Surface& surface : layers[size_t(layer)]) {
                const int expected = layer * steps[i];
                assert_int_equal(surface.found(), expected < 12);
                if (!surface.found()) { continue; }
                assert_int_equal(surface.part, expected);
                assert_true(std::abs(surface.z + 4.0f + 0.25f * float(expected)) < 1e-5f);
            }
        }
    }
}

// ---- Materials and lights -------------------------------------------------------------------------------

constexpr double kOct16Radians = 0.957 * 3.14159265 / 180.0; // its worst error
// Half a code of storage, and as much for the driver's own way from sRGB to linear.
constexpr double kAlbedo = 1.0 / 255.0;

// Against the radiance that the reference gives a surface with the normal and the albedo that the G-buffer stores for it.
// What is left is storage: emission, and then the sum, are cut off to 6 bits (blue: 5).
void add_radiance(const ReferenceScene& scene, const ReferenceView& view, Surface surface, const DrawnLayer& drawn,
                  size_t pixel, Count* count) {
    const size_t i = 3 * pixel;
    surface.normal = glm::transpose(glm::mat3(view.view)) * glm::make_vec3(&drawn.normal[i]);
    surface.albedo = glm::make_vec3(&drawn.albedo[i]);
    const vec3 radiance = scene.outgoing(surface);
    for (size_t c = 0; c < 3; ++c) {
        const double code = c == 2 ? 1.0 / 32.0 : 1.0 / 64.0;
        const double stored_twice = double(radiance[int(c)]) + double(surface.emission[int(c)]);
        count->add(std::abs(double(drawn.radiance[i + c]) - double(radiance[int(c)])), code * stored_twice + 1e-5);
    }
}

void test_zoo(void**) {
    const Scene zoo = make_zoo();
    Shot shot{&zoo, {}};
    shot.width = 320;
    shot.height = 180;
    shot.layers = 2;
    PunctualLight spot = point_light(vec3(2.0f, 0.0f, 0.0f), 30.0f);
    spot.kind = LightKind::spot;
    spot.inner_cone = 0.3f;
    spot.outer_cone = 0.9f;
    PunctualLight near_light = point_light(vec3(-3.0f, -1.0f, -1.0f), 20.0f);
    near_light.range = 6.0f;
    const std::vector<std::vector<PunctualLight>> lights = {
        {}, {sun_light(vec3(0.1f, 0.2f, 1.0f), 3.0f)}, {spot}, {near_light}};
    for (const std::vector<PunctualLight>& these : lights) {
        shot.lights = these;
        const ReferenceView view = view_of(shot);
        const ReferenceScene scene(zoo, current_pose(zoo), these);
        const auto traced = trace_layers(scene, view, shot.layers, shot.separation);
        const std::vector<DrawnLayer> drawn = draw(shot);
        const std::vector<bool> lit = lit_pixels(scene, traced[0]);
        const auto light_differs = [&](size_t i, size_t j) { return lit[i] != lit[j]; };
        const auto texel_differs = [&](size_t i, size_t j) {
            const auto differs = [=](const std::vector<Surface>& layer) {
                return glm::distance(layer[i].albedo, layer[j].albedo) > 0.05f ||
                       glm::distance(layer[i].normal, layer[j].normal) > 0.05f;
            };
            return differs(traced[0]) || differs(traced[1]);
        };
        Count z, albedo, normal, radiance;
        for (size_t i = 0; i < view.pixels(); ++i) {
            if (on_silhouette(traced, 1, view, i) || on_edge(view, i, 1, texel_differs)) { continue; }
            for (size_t layer = 0; layer < 2; ++layer) {
                const Surface& surface = traced[layer][i];
                const DrawnLayer& d = drawn[layer];
                assert_int_equal(surface.found(), d.z[i] != 0.0f);
                if (!surface.found()) { continue; }
                z.add(std::abs(double(surface.z) - double(d.z[i])), 1e-3);
                for (size_t c = 0; c < 3; ++c) {
                    albedo.add(std::abs(double(surface.albedo[int(c)]) - double(d.albedo[3 * i + c])), kAlbedo);
                }
                const vec3 n = glm::mat3(view.view) * surface.normal;
                const vec3 stored(d.normal[3 * i], d.normal[3 * i + 1], d.normal[3 * i + 2]);
                normal.add(double(glm::distance(n, stored)), kOct16Radians);
            }
            // shadow maps blur
            if (!traced[0][i].found() || on_edge(view, i, 4, light_differs)) { continue; }
            add_radiance(scene, view, traced[0][i], drawn[0], i, &radiance);
        }
        z.print("depth");
        albedo.print("albedo");
        normal.print("normal");
        radiance.print("radiance");
        assert_true(radiance.compared > 60000);
        assert_int_equal(z.wrong + albedo.wrong + normal.wrong + radiance.wrong, 0);
    }
}

// The radiance of the examples' G-buffer, away from edges of surfaces and shadows. Shadow maps have texels of 7 mm to some
// centimetres and lift a point by 3.5 of them: what stands in the shade of its own facet, or within some pixels of a
// shadow's edge, is theirs to get wrong.
void test_radiance_of_atrium(void**) {
    Scene atrium = make_atrium();
    for (Material& material : atrium.materials) { material.base_color_texture = -1; } // no levels of detail
    for (int camera = 0; camera < 2; ++camera) {
        Shot shot{&atrium, atrium_camera(atrium, camera)};
        shot.width = 320;
        shot.height = 180;
        shot.lights = {sun_light(vec3(0.25f, 0.9f, 0.3f), 6.0f)};
        const ReferenceView view = view_of(shot);
        const ReferenceScene scene(atrium, current_pose(atrium), shot.lights);
        const auto traced = trace_layers(scene, view, 1, shot.separation);
        const std::vector<DrawnLayer> drawn = draw(shot);
        const std::vector<bool> lit = lit_pixels(scene, traced[0]);
        const auto light_differs = [&](size_t i, size_t j) { return lit[i] != lit[j]; };
        Count radiance, everywhere;
        for (size_t i = 0; i < view.pixels(); ++i) {
            if (!traced[0][i].found()) { continue; }
            add_radiance(scene, view, traced[0][i], drawn[0], i, &everywhere);
            if (on_silhouette(traced, 0, view, i) || on_edge(view, i, 4, light_differs)) { continue; }
            add_radiance(scene, view, traced[0][i], drawn[0], i, &radiance);
        }
        radiance.print("radiance");
        everywhere.print("radiance, all pixels");
        assert_true(radiance.compared > 30000);
        assert_int_equal(radiance.wrong, 0);
    }
}

// ---- Mirror ---------------------------------------------------------------------------------------------

// A floor that mirrors a wall, both without end as far as rays go, and the sky above the wall.
Scene make_hall() {
    Scene scene;
    scene.materials.resize(2);
    scene.materials[0].double_sided = true;
    scene.materials[1].base_color = vec4(0.5f, 0.25f, 0.75f, 1.0f);
    scene.materials[1].emissive = vec3(0.3f, 0.2f, 0.1f);
    scene.meshes = {square(0), square(1)};
    scene.nodes.push_back(node_at(at(vec3(0.0f), vec3(20.0f), -90.0f, vec3(1.0f, 0.0f, 0.0f)), 0));
    scene.nodes.push_back(node_at(at(vec3(0.0f, 2.0f, -10.0f), vec3(20.0f, 2.0f, 1.0f)), 1));
    scene.nodes.push_back(node_at(at(vec3(0.0f, 1.0f, -5.0f), vec3(20.0f), 180.0f), 1)); // turned away: not drawn
    update_bounds(&scene);
    return scene;
}

void test_mirror_of_hall(void**) {
    const Scene hall = make_hall();
    const Sky sky = gradient_sky(vec3(0.2f, 0.4f, 0.8f));
    const ReferenceScene scene(hall, current_pose(hall), {point_light(vec3(0.0f, 3.0f, -8.0f), 7.0f)}, sky);
    Shot shot{&hall, {}};
    shot.camera.eye = vec3(0.5f, 1.0f, 0.0f);
    shot.camera.target = vec3(0.0f, 0.0f, -3.0f);
    ReferenceView view = view_of(shot);
    view.guard = 3;
    const PixelRays rays(view);
    const std::vector<Surface> first = trace_layers(scene, view, 1, 0.0f)[0];
    const std::vector<MirrorHit> hits = trace_mirror(scene, view, surface_points(first));
    const std::vector<MirrorHit> from_behind = trace_mirror(scene, view, surface_points(first), Faces::both);
    int on_wall = 0, in_sky = 0;
    for (size_t i = 0; i < view.pixels(); ++i) {
        if (!first[i].found() || first[i].part != 0) { continue; }
        const dvec3 d(rays.through(i).direction), x(first[i].position);
        const dvec3 expected = x + dvec3(d.x, -d.y, d.z) * ((-10.0 - x.z) / d.z);
        assert_true(glm::distance(dvec3(hits[i].direction), dvec3(d.x, -d.y, d.z)) < 1e-6);
        if (expected.y > 4.0) {
            ++in_sky;
            assert_true(hits[i].state == MirrorState::miss);
            const vec3 sky_there = sky.horizon + float(-d.y) * (sky.zenith - sky.horizon);
            assert_true(glm::distance(hits[i].radiance, sky_there) < 1e-6f);
            continue;
        }
        ++on_wall;
        const MirrorHit& hit = hits[i];
        assert_true(hit.state == MirrorState::hit && hit.surface.part == 1);
        // the lift of 1e-5 of the position, twice where the ray is steep against the wall
        assert_true(glm::distance(dvec3(hit.surface.position), expected) < 5e-4);
        assert_true(std::abs(double(hit.surface.distance) - glm::distance(x, expected)) < 5e-4);
        const dvec3 to_light = dvec3(0.0, 3.0, -8.0) - expected;
        const double irradiance = 7.0 * to_light.z / std::pow(glm::length(to_light), 3.0);
        const dvec3 radiance = dvec3(0.3, 0.2, 0.1) + dvec3(0.5, 0.25, 0.75) * (irradiance / glm::pi<double>());
        assert_true(glm::distance(dvec3(hit.radiance), radiance) < 1e-3 * glm::length(radiance));
        assert_true(std::abs(hit.surface.z - rays.z_of(hit.surface.position)) < 1e-5f);
        const bool behind = from_behind[i].surface.part == 2;
        assert_int_equal(behind, x.z > -5.0);
        if (behind) { assert_true(from_behind[i].radiance == vec3(0.0f)); }
    }
    std::printf("# %d pixels mirror the wall, %d the sky\n", on_wall, in_sky);
    assert_true(on_wall > 1000 && in_sky > 1000);
}

void test_mirror_without_rays(void**) {
    const Scene hall = make_hall();
    const ReferenceScene scene(hall, current_pose(hall), {});
    ReferenceView view;
    view.width = 2;
    view.height = 1;
    view.projection = glm::perspectiveRH_NO(1.0f, 2.0f, 0.1f, 100.0f);
    const std::vector<SurfacePoint> points = {{vec3(0.0f), vec3(0.0f), 0.0f},
                                              {vec3(0.0f, 1.0f, -2.0f), vec3(0.0f, 0.0f, -1.0f), 0.0f}};
    for (const MirrorHit& hit : trace_mirror(scene, view, points)) { assert_true(hit.state == MirrorState::none); }
}

// What the G-buffer's normals and depth make of the mirror: the same normals give the same hits, so that whatever
// differs with exact ones comes from Oct16.
void test_mirror_of_buffers(void**) {
    const Scene atrium = make_atrium();
    Shot shot{&atrium, atrium_camera(atrium, 1)};
    shot.width = 320;
    shot.height = 180;
    const ReferenceView view = view_of(shot);
    const ReferenceScene scene(atrium, current_pose(atrium), {sun_light(vec3(0.25f, 0.9f, 0.3f), 6.0f)});
    const std::vector<Surface> traced = trace_layers(scene, view, 1, 0.0f)[0];
    const DrawnLayer drawn = draw(shot)[0];
    const std::vector<SurfacePoint> stored = surface_points(view, drawn.z, drawn.normal),
                                    exact = surface_points(traced);
    std::vector<SurfacePoint> mixed = exact;
    for (size_t i = 0; i < mixed.size(); ++i) { mixed[i].normal = stored[i].normal; }
    const auto of_stored = trace_mirror(scene, view, stored), of_exact = trace_mirror(scene, view, exact),
               of_mixed = trace_mirror(scene, view, mixed);
    Count place, position, angle;
    int same_part = 0, hits = 0;
    for (size_t i = 0; i < stored.size(); ++i) {
        if (!traced[i].found() || drawn.z[i] == 0.0f) { continue; }
        place.add(double(glm::distance(stored[i].position, exact[i].position)), 1e-3);
        const bool both = of_stored[i].surface.found() && of_mixed[i].surface.found();
        const double apart = both ? double(glm::distance(of_stored[i].surface.position, of_mixed[i].surface.position))
                             : of_stored[i].state == of_mixed[i].state ? 0.0
                                                                       : std::numeric_limits<double>::infinity();
        position.add(apart, 0.01);
        // a reflected ray turns twice as far as the normal
        if (of_exact[i].state == MirrorState::none || of_stored[i].state == MirrorState::none) { continue; }
        angle.add(double(glm::distance(of_stored[i].direction, of_exact[i].direction)), 2.0 * kOct16Radians);
        hits += of_exact[i].state == MirrorState::hit;
        same_part += of_exact[i].state == MirrorState::hit && of_exact[i].surface.part == of_stored[i].surface.part;
    }
    place.print("position in the buffer");
    angle.print("direction, Oct16");
    position.print("hit, same normals");
    assert_true(place.share() < 1e-3); // at silhouettes, as depth
    assert_true(angle.share() < 1e-3); // likewise
    assert_true(position.share() <
                1e-2); // and where the reflected ray passes an edge, or meets a surface at a grazing angle
    std::printf("# of %d hits with exact normals, %.2f %% are on the same mesh with stored ones\n", hits,
                100.0 * same_part / hits);
}

} // namespace

int main() {
    const CMUnitTest tests[] = {
        cmocka_unit_test(test_pixel_rays),
        cmocka_unit_test(test_closest),
        cmocka_unit_test(test_separation),
        cmocka_unit_test(test_layers_of_atrium),
        cmocka_unit_test(test_layers_of_orthographic_views),
        cmocka_unit_test(test_layers_without_separation),
        cmocka_unit_test(test_zoo),
        cmocka_unit_test(test_radiance_of_atrium),
        cmocka_unit_test(test_mirror_of_hall),
        cmocka_unit_test(test_mirror_without_rays),
        cmocka_unit_test(test_mirror_of_buffers),
    };
    return cmocka_run_group_tests(tests, open_context, close_context);
}
