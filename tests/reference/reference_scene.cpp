// Geometry in Embree, and materials as the examples draw them.
#include "reference.hpp"

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

namespace {

using glm::mat3;
using glm::mat4;
using glm::vec2;
using glm::vec3;
using glm::vec4;

// Of the largest coordinate: how far a new ray starts from its surface. A position between three vertices is exact to about
// 2^-22 of it, and Embree's own test is as exact.
constexpr float kLift = 4e-6f;

// ---- Textures -------------------------------------------------------------------------------------------

float linear_of_srgb(float s) { return s <= 0.04045f ? s / 12.92f : std::pow((s + 0.055f) / 1.055f, 2.4f); }

vec4 texel(const Image& image, int x, int y, bool srgb) {
    static const std::array<float, 256> linear = [] {
        std::array<float, 256> table{};
        for (size_t i = 0; i < table.size(); ++i) { table[i] = linear_of_srgb(float(i) / 255.0f); }
        return table;
    }();
    const uint8_t* p = &image.rgba[4 * (size_t(y) * size_t(image.width) + size_t(x))];
    const vec4 stored = vec4(p[0], p[1], p[2], p[3]) / 255.0f;
    return srgb ? vec4(linear[p[0]], linear[p[1]], linear[p[2]], stored.w) : stored;
}

int wrapped(int i, int size, Wrap wrap) {
    if (wrap == Wrap::clamp) { return std::clamp(i, 0, size - 1); }
    const int period = wrap == Wrap::mirror ? 2 * size : size, inside = ((i % period) + period) % period;
    return inside < size ? inside : period - 1 - inside;
}

// Of the finest level.
vec4 sample(const Scene& scene, int index, vec2 uv, bool srgb, vec4 missing) {
    if (index < 0 || scene.textures[size_t(index)].image < 0) { return missing; }
    const Texture& texture = scene.textures[size_t(index)];
    const Image& image = scene.images[size_t(texture.image)];
    const auto at = [&](int x, int y) {
        return texel(image, wrapped(x, image.width, texture.wrap_u), wrapped(y, image.height, texture.wrap_v), srgb);
    };
    const vec2 place = uv * vec2(image.width, image.height);
    if (texture.filter == Filter::nearest) { return at(int(std::floor(place.x)), int(std::floor(place.y))); }
    const vec2 corner = glm::floor(place - 0.5f), share = place - 0.5f - corner;
    const int x = int(corner.x), y = int(corner.y);
    return glm::mix(glm::mix(at(x, y), at(x + 1, y), share.x), glm::mix(at(x, y + 1), at(x + 1, y + 1), share.x),
                    share.y);
}

RTCRay to_embree(const Ray& ray, Faces faces) {
    RTCRay result{};
    result.org_x = ray.origin.x;
    result.org_y = ray.origin.y;
    result.org_z = ray.origin.z;
    result.dir_x = ray.direction.x;
    result.dir_y = ray.direction.y;
    result.dir_z = ray.direction.z;
    result.tnear = ray.nearest;
    result.tfar = ray.farthest;
    result.mask = ~0u;
    result.id = unsigned(faces);
    return result;
}

// ---- Placing --------------------------------------------------------------------------------------------

// Cofactors: the inverse transpose times the determinant.
mat3 cofactors(const mat3& m) { return {cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])}; }

mat4 matrix_of(const Vertex& vertex, const mat4* joints) {
    mat4 sum(0.0f);
    for (int i = 0; i < 4; ++i) { sum += vertex.weights[i] * joints[vertex.joints[i]]; }
    return sum;
}

} // namespace

struct ReferenceScene::Part {
    const Scene* scene;
    const Mesh* mesh;
    const Material* material;
    bool mirrored; // front faces are clockwise
    // a vertex each
    std::vector<vec3> positions;
    std::vector<vec3> normals;  // not unit, as the examples interpolate them
    std::vector<vec4> tangents; // likewise; w is the sign of the bitangent

    template <typename T>
    T blend(const T& a, const T& b, const T& c, vec2 at) const {
        return (1.0f - at.x - at.y) * a + at.x * b + at.y * c;
    }
    template <typename T>
    T of(const std::vector<T>& values, uint32_t triangle, vec2 at) const {
        const uint32_t* corner = &mesh->indices[3 * size_t(triangle)];
        return blend(values[corner[0]], values[corner[1]], values[corner[2]], at);
    }
    template <typename T>
    T of(T Vertex::*member, uint32_t triangle, vec2 at) const {
        const uint32_t* corner = &mesh->indices[3 * size_t(triangle)];
        return blend(mesh->vertices[corner[0]].*member, mesh->vertices[corner[1]].*member,
                     mesh->vertices[corner[2]].*member, at);
    }

    // Not unit; out of the front.
    vec3 face_normal(uint32_t triangle) const {
        const uint32_t* corner = &mesh->indices[3 * size_t(triangle)];
        const vec3 a = positions[corner[0]], n = cross(positions[corner[1]] - a, positions[corner[2]] - a);
        return mirrored ? -n : n;
    }
    vec4 base_color(uint32_t triangle, vec2 at) const {
        return material->base_color * of(&Vertex::color, triangle, at) *
               sample(*scene, material->base_color_texture, of(&Vertex::uv, triangle, at), true, vec4(1.0f));
    }
    bool is_cut_out(uint32_t triangle, vec2 at) const {
        return material->alpha_mode == AlphaMode::mask && base_color(triangle, at).w < material->alpha_cutoff;
    }
    vec3 mapped_normal(uint32_t triangle, vec2 at) const;
    void fill(Surface* surface, vec3 direction, vec2 at) const;
};

vec3 ReferenceScene::Part::mapped_normal(uint32_t triangle, vec2 at) const {
    const vec3 n = glm::normalize(of(normals, triangle, at));
    if (material->normal_texture < 0) { return n; }
    const vec4 tangent = of(tangents, triangle, at);
    const vec3 t = vec3(tangent) - n * dot(n, vec3(tangent)), b = cross(n, t) * tangent.w;
    const vec4 flat(0.5f, 0.5f, 1.0f, 1.0f);
    const vec3 m =
        vec3(sample(*scene, material->normal_texture, of(&Vertex::uv, triangle, at), false, flat)) * 2.0f - 1.0f;
    const float to_unit = 1.0f / std::sqrt(std::max(dot(t, t), 1e-20f));
    return glm::normalize((t * m.x + b * m.y) * (to_unit * material->normal_scale) + n * m.z);
}

void ReferenceScene::Part::fill(Surface* surface, vec3 direction, vec2 at) const {
    const uint32_t triangle = surface->triangle;
    const vec2 uv = of(&Vertex::uv, triangle, at);
    const vec3 out = face_normal(triangle);
    const bool seen_from_front = dot(out, direction) < 0.0f;
    surface->position = of(positions, triangle, at);
    surface->face_normal = glm::normalize(seen_from_front ? out : -out);
    surface->normal = mapped_normal(triangle, at) * (seen_from_front ? 1.0f : -1.0f);
    surface->front = seen_from_front || material->double_sided;
    surface->lit = !material->unlit;

    const vec3 base(base_color(triangle, at));
    const float metal =
        material->metallic * sample(*scene, material->metallic_roughness_texture, uv, false, vec4(1.0f)).z;
    surface->albedo = base * (1.0f - metal);
    surface->emission =
        material->unlit ? base
                        : material->emissive * vec3(sample(*scene, material->emissive_texture, uv, true, vec4(1.0f)));
}

// ---- Embree ---------------------------------------------------------------------------------------------

struct ReferenceScene::Embree {
    RTCDevice device = rtcNewDevice(nullptr);
    RTCScene scene = rtcNewScene(device);

    Embree() { rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST); }
    Embree(const Embree&) = delete;
    Embree& operator=(const Embree&) = delete;
    ~Embree() {
        rtcReleaseScene(scene);
        rtcReleaseDevice(device);
    }

    void add(Part* part) const;
    void finish() const;
    RTCRayHit intersect(const Ray& ray, Faces faces) const;
    bool occluded(const Ray& ray) const;

    // Both reject what is cut out, and the first one back faces where the ray's id says so.
    static void filter_hit(const RTCFilterFunctionNArguments* args);
    static void filter_shadow(const RTCFilterFunctionNArguments* args);
};

void ReferenceScene::Embree::filter_hit(const RTCFilterFunctionNArguments* args) {
    const auto& part = *static_cast<const Part*>(args->geometryUserPtr);
    const vec3 direction(RTCRayN_dir_x(args->ray, args->N, 0), RTCRayN_dir_y(args->ray, args->N, 0),
                         RTCRayN_dir_z(args->ray, args->N, 0));
    const unsigned triangle = RTCHitN_primID(args->hit, args->N, 0);
    const bool front_only = RTCRayN_id(args->ray, args->N, 0) == unsigned(Faces::front);
    if (front_only && !part.material->double_sided && dot(part.face_normal(triangle), direction) >= 0.0f) {
        args->valid[0] = 0;
    }
    filter_shadow(args);
}

void ReferenceScene::Embree::filter_shadow(const RTCFilterFunctionNArguments* args) {
    const auto& part = *static_cast<const Part*>(args->geometryUserPtr);
    const vec2 at(RTCHitN_u(args->hit, args->N, 0), RTCHitN_v(args->hit, args->N, 0));
    if (part.is_cut_out(RTCHitN_primID(args->hit, args->N, 0), at)) { args->valid[0] = 0; }
}

void ReferenceScene::Embree::add(Part* part) const {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    const size_t triangles = part->mesh->indices.size() / 3;
    auto* positions = static_cast<vec3*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                                 sizeof(vec3), part->positions.size()));
    auto* indices = static_cast<uint32_t*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(uint32_t), triangles));
    std::copy(part->positions.begin(), part->positions.end(), positions);
    std::copy_n(part->mesh->indices.begin(), 3 * triangles, indices);
    rtcSetGeometryUserData(geometry, part);
    rtcSetGeometryIntersectFilterFunction(geometry, filter_hit);
    if (part->material->alpha_mode == AlphaMode::mask) {
        rtcSetGeometryOccludedFilterFunction(geometry, filter_shadow);
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry); // counts up from 0, as the parts do
    rtcReleaseGeometry(geometry);
}

void ReferenceScene::Embree::finish() const {
    rtcCommitScene(scene);
    const RTCError error = rtcGetDeviceError(device);
    if (error != RTC_ERROR_NONE) { throw std::runtime_error("Embree reports error " + std::to_string(int(error))); }
}

RTCRayHit ReferenceScene::Embree::intersect(const Ray& ray, Faces faces) const {
    RTCRayHit hit{};
    hit.ray = to_embree(ray, faces);
    hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION_MAJOR >= 4
    rtcIntersect1(scene, &hit);
#else
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene, &context, &hit);
#endif
    return hit;
}

bool ReferenceScene::Embree::occluded(const Ray& ray) const {
    RTCRay shadow = to_embree(ray, Faces::both);
#if RTC_VERSION_MAJOR >= 4
    rtcOccluded1(scene, &shadow);
#else
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded1(scene, &context, &shadow);
#endif
    return shadow.tfar < 0.0f;
}

// ---- Scene ----------------------------------------------------------------------------------------------

ReferenceScene::ReferenceScene(const Scene& scene, const Pose& pose, std::vector<PunctualLight> lights, const Sky& sky)
    : lights_(std::move(lights)), sky_(sky), embree_(std::make_unique<Embree>()) {
    for (PunctualLight& light : lights_) {
        if (light.node >= 0) { light.world = pose.nodes[size_t(light.node)]; }
    }
    const std::vector<int> first_joints = first_joints_of(scene);
    for (size_t i = 0; i < scene.nodes.size(); ++i) {
        const int skin = scene.nodes[i].skin;
        for (int mesh : scene.nodes[i].meshes) {
            add_part(scene, pose, int(i), mesh, skin < 0 ? -1 : first_joints[size_t(skin)]);
        }
    }
    embree_->finish();
}

ReferenceScene::~ReferenceScene() = default;

// As GpuScene places and draws it.
void ReferenceScene::add_part(const Scene& scene, const Pose& pose, int node, int mesh_index, int first_joint) {
    const Mesh& mesh = scene.meshes[size_t(mesh_index)];
    const Material& material = scene.materials[size_t(mesh.material)];
    if (material.alpha_mode == AlphaMode::blend || mesh.indices.size() < 3) { return; }
    const mat4* joints = first_joint < 0 ? nullptr : &pose.joints[size_t(first_joint)];
    const mat4& of_node = pose.nodes[size_t(node)];
    const bool mirrored = glm::determinant(mat3(joints != nullptr ? joints[0] : of_node)) < 0.0f;
    const float hand = mirrored ? -1.0f : 1.0f;

    auto part = std::make_unique<Part>(Part{&scene, &mesh, &material, mirrored, {}, {}, {}});
    for (const Vertex& vertex : mesh.vertices) {
        const mat4 world = joints != nullptr ? matrix_of(vertex, joints) : of_node;
        part->positions.emplace_back(world * vec4(vertex.position, 1.0f));
        part->normals.push_back(cofactors(mat3(world)) * vertex.normal * hand);
        part->tangents.emplace_back(mat3(world) * vec3(vertex.tangent), vertex.tangent.w * hand);
    }
    embree_->add(part.get());
    parts_.push_back(std::move(part));
}

Surface ReferenceScene::closest(const Ray& ray, Faces faces) const {
    const RTCRayHit hit = embree_->intersect(ray, faces);
    Surface surface;
    if (hit.hit.geomID == RTC_INVALID_GEOMETRY_ID) { return surface; }
    surface.part = hit.hit.geomID;
    surface.triangle = hit.hit.primID;
    surface.distance = hit.ray.tfar;
    parts_[surface.part]->fill(&surface, ray.direction, {hit.hit.u, hit.hit.v});
    return surface;
}

float ReferenceScene::distance(const Ray& ray, Faces faces) const {
    const RTCRayHit hit = embree_->intersect(ray, faces);
    return hit.hit.geomID != RTC_INVALID_GEOMETRY_ID ? hit.ray.tfar : std::numeric_limits<float>::infinity();
}

bool ReferenceScene::occluded(const Ray& ray) const { return embree_->occluded(ray); }

Ray leaving(const Surface& surface, vec3 direction) {
    const vec3 size = glm::abs(surface.position);
    const float lift = kLift * std::max({size.x, size.y, size.z, 1.0f});
    return {surface.position + lift * surface.face_normal, direction};
}
