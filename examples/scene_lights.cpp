#include "scene_lights.hpp"

#include <glm/gtc/matrix_access.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace {

using glm::mat4;
using glm::vec3;
using glm::vec4;

constexpr int kCubeMaps = 6;
constexpr int kLargestMap = 4096;                 // texels along one side
constexpr int64_t kMapBytes = int64_t(256) << 20; // of all maps at most; more maps are smaller
constexpr GLuint kUniformBinding = 0;

// Beyond this angle from its axis, a spot light takes the six maps of a point light: one would be too coarse.
constexpr float kWidestMap = 1.05f; // radians

// Texels around what a map of a spot or point light must show, for the filter.
constexpr float kMapBorder = 4.0f;

// Shadow map texels by which a point is lifted off its surface before it is looked up. The filter reaches
// 2 sqrt(2) texels: with more than that no plane shadows itself, however slanted, and depth needs no bias.
constexpr float kNormalOffset = 3.5f;
// Of the distance to the light, in a perspective map: where texels are finer than its depth is exact.
constexpr float kLeastOffset = 1e-3f;
// Of a perspective map. What is nearer to the light than this share of the farthest point it lights casts no shadow.
constexpr float kNearOfFar = 1e-3f;

mat4 to_texture(const mat4& clip) { // -1..1 to 0..1
    return glm::scale(glm::translate(mat4(1.0f), vec3(0.5f)), vec3(0.5f)) * clip;
}

vec3 position_of(const PunctualLight& light) { return light.world[3]; }
vec3 any_up(vec3 direction) { return std::abs(direction.y) < 0.99f ? vec3(0.0f, 1.0f, 0.0f) : vec3(0.0f, 0.0f, 1.0f); }

bool is_dark(const PunctualLight& light) { return light.intensity == vec3(0.0f); }

int maps_of(const PunctualLight& light) {
    const bool is_wide_spot = light.kind == LightKind::spot && light.outer_cone > kWidestMap;
    return light.kind == LightKind::point || is_wide_spot ? kCubeMaps : 1;
}

int size_of_maps(int count) {
    int64_t size = kLargestMap;
    while (size * size * int64_t(sizeof(float)) * count > kMapBytes) { size /= 2; }
    return int(size);
}

vec3 corner_of(vec3 low, vec3 high, int corner) {
    return {(corner & 1) != 0 ? high.x : low.x, (corner & 2) != 0 ? high.y : low.y, (corner & 4) != 0 ? high.z : low.z};
}

// Clip space of an orthographic picture along the light's rays that holds all of the scene.
mat4 directional_clip(vec3 bounds_min, vec3 bounds_max, vec3 direction) {
    const mat4 view = glm::lookAt(direction, vec3(0.0f), any_up(direction));
    vec3 low(std::numeric_limits<float>::infinity()), high(-low);
    for (int corner = 0; corner < 8; ++corner) {
        const vec3 seen(view * vec4(corner_of(bounds_min, bounds_max, corner), 1.0f));
        low = glm::min(low, seen);
        high = glm::max(high, seen);
    }
    const float margin = 0.01f * glm::length(high - low); // room for the filter, and for flat scenes
    low -= margin;
    high += margin;
    return glm::ortho(low.x, high.x, low.y, high.y, -high.z, -low.z) * view;
}

// Camera space of one of the six maps around a light, as cube_face in kDirectLight has it. Some mirror: nothing is
// culled.
mat4 face_view(int face, vec3 position) {
    const int axis = face / 2;
    mat4 view(0.0f);
    view[(axis + 1) % 3][0] = 1.0f;
    view[(axis + 2) % 3][1] = 1.0f;
    view[axis][2] = face % 2 == 0 ? -1.0f : 1.0f;
    view[3][3] = 1.0f;
    return glm::translate(view, -position);
}

// As kDirectLight has it. std140: what has four floats needs no padding.
struct GpuLight {
    vec4 to_light{0.0f};
    vec4 position{0.0f};
    vec4 intensity{0.0f};
    vec4 shape{0.0f, 1.0f, 0.0f, 1.0f};
    mat4 map{1.0f};
};

struct Placed {
    GpuLight light;
    std::vector<mat4> clips; // a map, from world
};

// What the maps have to show.
struct Stage {
    vec3 bounds_min, bounds_max; // metres
    int map_size;                // texels along one side
};

void place_directional(const Stage& stage, Placed* placed) {
    const mat4 clip = directional_clip(stage.bounds_min, stage.bounds_max, vec3(placed->light.to_light));
    // rows of an orthographic matrix are 2 / extent long
    const float texel = 2.0f / std::min(glm::length(vec3(glm::row(clip, 0))), glm::length(vec3(glm::row(clip, 1)))) /
                        float(stage.map_size);
    placed->light.intensity.w = kNormalOffset * texel;
    placed->light.map = to_texture(clip);
    placed->clips = {clip};
}

// How far the light is seen: as far as the scene goes, or its range.
float reach_of(const PunctualLight& light, const Stage& stage) {
    float farthest = 1e-3f; // metres: a scene may be smaller than a map can show
    for (int corner = 0; corner < 8; ++corner) {
        const vec3 point = corner_of(stage.bounds_min, stage.bounds_max, corner);
        farthest = std::max(farthest, 1.01f * glm::distance(position_of(light), point));
    }
    return light.range > 0.0f ? std::min(farthest, light.range) : farthest;
}

// tangent: of half the angle that the map must show, without border.
mat4 map_projection(const PunctualLight& light, const Stage& stage, float tangent, Placed* placed) {
    const float half = tangent * float(stage.map_size) / (float(stage.map_size) - 2.0f * kMapBorder);
    const float far_plane = reach_of(light, stage), near_plane = kNearOfFar * far_plane, side = half * near_plane;
    placed->light.position = vec4(position_of(light), 1.0f);
    placed->light.to_light.w = light.range > 0.0f ? 1.0f / light.range : 0.0f;
    placed->light.intensity.w = std::max(kNormalOffset * 2.0f * half / float(stage.map_size), kLeastOffset);
    return glm::frustum(-side, side, -side, side, near_plane, far_plane);
}

void place_one_map(const PunctualLight& light, const Stage& stage, Placed* placed) {
    const vec3 position = position_of(light), axis = -vec3(placed->light.to_light);
    const mat4 clip = map_projection(light, stage, std::tan(light.outer_cone), placed) *
                      glm::lookAt(position, position + axis, any_up(axis));
    placed->light.map = to_texture(clip);
    placed->clips = {clip};
}

void place_cube(const PunctualLight& light, const Stage& stage, Placed* placed) {
    const mat4 projection = map_projection(light, stage, 1.0f, placed);
    placed->light.map = to_texture(projection);
    for (int face = 0; face < kCubeMaps; ++face) {
        placed->clips.push_back(projection * face_view(face, position_of(light)));
    }
}

// What KHR_lights_punctual recommends.
void shape_cone(const PunctualLight& light, GpuLight* gpu) {
    const float inner = std::cos(light.inner_cone), outer = std::cos(light.outer_cone);
    gpu->shape.x = 1.0f / std::max(0.001f, inner - outer);
    gpu->shape.y = -outer * gpu->shape.x;
}

Placed place_light(const PunctualLight& light, const Stage& stage, int first_map) {
    Placed placed;
    placed.light.to_light = vec4(direction_to(light), 0.0f);
    placed.light.intensity = vec4(light.intensity, 0.0f);
    placed.light.shape.z = float(first_map);
    placed.light.shape.w = float(maps_of(light));
    if (light.kind == LightKind::spot) { shape_cone(light, &placed.light); }
    if (light.kind == LightKind::directional) {
        place_directional(stage, &placed);
    } else if (maps_of(light) == 1) {
        place_one_map(light, stage, &placed);
    } else {
        place_cube(light, stage, &placed);
    }
    return placed;
}

GlObject make_maps(int size, int count) {
    GlObject texture = make_texture();
    glBindTexture(GL_TEXTURE_2D_ARRAY, texture.name());
    glTexImage3D(GL_TEXTURE_2D_ARRAY, 0, GL_DEPTH_COMPONENT32F, size, size, count, 0, GL_DEPTH_COMPONENT, GL_FLOAT,
                 nullptr);
    glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
    return texture;
}

} // namespace

// ---- Shader ---------------------------------------------------------------------------------------------

const char* const kDirectLight = R"(
const float NEAREST = 0.01; // metres: nearer to a light, it gets no brighter

struct Light {
    vec4 to_light;  // against the axis, unit; 1 / range or 0
    vec4 position;  // 1, or 0 for a directional light
    vec4 intensity; // W/sr or W/m2; metres to lift a point off its own shadow, in perspective at a metre's distance
    vec4 shape;     // cosine from the axis to attenuation: scale, offset; first map, number of maps
    mat4 map;       // from world space, or with six maps from that of a face's camera
};
layout(std140) uniform Lights { Light lights[16]; }; // kMaxLights
uniform int u_light_count;
uniform sampler2DArrayShadow u_shadow_maps;

// The face of a cube around the origin that a point is seen through: camera space, and its number.
vec4 cube_face(vec3 p) {
    vec3 a = abs(p);
    int axis = a.x >= a.y && a.x >= a.z ? 0 : a.y >= a.z ? 1 : 2;
    return vec4(p[(axis + 1) % 3], p[(axis + 2) % 3], -a[axis], float(2 * axis) + (p[axis] < 0.0 ? 1.0 : 0.0));
}

// 3 x 3 comparisons, each filtered over 2 x 2 texels by the sampler.
float filtered_shadow(vec3 p, float map) {
    vec2 texel = 1.0 / vec2(textureSize(u_shadow_maps, 0).xy);
    float lit = 0.0;
    for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x) lit += texture(u_shadow_maps, vec4(p.xy + vec2(x, y) * texel, map, p.z));
    return lit / 9.0;
}

float light_visibility(Light light, vec3 world, vec3 normal) {
    bool is_cube = light.shape.w > 1.0;
    vec3 from_light = world - light.position.xyz;
    float depth = light.position.w == 0.0 ? 1.0
                : is_cube ? -cube_face(from_light).z : -dot(from_light, light.to_light.xyz);
    vec3 lifted = world + normal * (light.intensity.w * depth);
    vec4 face = cube_face(lifted - light.position.xyz);
    vec4 p = light.map * vec4(is_cube ? face.xyz : lifted, 1.0);
    return filtered_shadow(p.xyz / p.w, light.shape.z + (is_cube ? face.w : 0.0));
}

// What KHR_lights_punctual recommends: the inverse square in a window that closes at the range, and a cone.
float attenuation(Light light, vec3 to_light, float square) {
    float share = square * light.to_light.w * light.to_light.w;
    float window = clamp(1.0 - share * share, 0.0, 1.0);
    float cone = clamp(dot(light.to_light.xyz, to_light) * light.shape.x + light.shape.y, 0.0, 1.0);
    return window * cone * cone / square;
}

vec3 irradiance_from(Light light, vec3 world, vec3 normal) {
    bool is_directional = light.position.w == 0.0;
    vec3 path = light.position.xyz - world;
    float square = max(dot(path, path), NEAREST * NEAREST);
    vec3 to_light = is_directional ? light.to_light.xyz : path * inversesqrt(square);
    float cosine = dot(normal, to_light);
    float reach = is_directional ? 1.0 : attenuation(light, to_light, square);
    if (cosine <= 0.0 || reach <= 0.0) return vec3(0.0);
    return light.intensity.rgb * reach * cosine * light_visibility(light, world, normal);
}

vec3 direct_irradiance(vec3 world, vec3 normal) {
    vec3 sum = vec3(0.0);
    for (int i = 0; i < u_light_count; ++i) sum += irradiance_from(lights[i], world, normal);
    return sum;
}
)";

// ---- Lights ---------------------------------------------------------------------------------------------

SceneLights::SceneLights(const Scene& scene, const GpuScene& gpu_scene, const std::vector<PunctualLight>& lights)
    : scene_(&gpu_scene), bounds_min_(scene.bounds_min), bounds_max_(scene.bounds_max) {
    std::remove_copy_if(lights.begin(), lights.end(), std::back_inserter(lights_), is_dark);
    if (lights_.size() > size_t(kMaxLights)) {
        throw std::runtime_error("there are " + std::to_string(lights_.size()) + " lights, but at most " +
                                 std::to_string(kMaxLights) + " are supported");
    }
    if (lights_.empty()) { return; }
    for (const PunctualLight& light : lights_) { map_count_ += maps_of(light); }
    map_size_ = size_of_maps(map_count_);
    maps_ = make_maps(map_size_, map_count_);
    program_ = make_depth_program("shadow", gpu_scene.vertex_text());
}

bool SceneLights::update(const GpuPose& pose) {
    const Pose& matrices = pose.matrices();
    if (empty() || (pose_ && pose_->nodes == matrices.nodes && pose_->joints == matrices.joints)) { return false; }
    pose_ = matrices;
    place(matrices);
    draw_maps(pose);
    return true;
}

void SceneLights::place(const Pose& pose) {
    const Stage stage{bounds_min_, bounds_max_, map_size_};
    std::vector<GpuLight> gpu_lights(kMaxLights);
    clips_.clear();
    for (size_t i = 0; i < lights_.size(); ++i) {
        PunctualLight& light = lights_[i];
        if (light.node >= 0) { light.world = pose.nodes[size_t(light.node)]; }
        const Placed placed = place_light(light, stage, int(clips_.size()));
        gpu_lights[i] = placed.light;
        clips_.insert(clips_.end(), placed.clips.begin(), placed.clips.end());
    }
    uniforms_ = make_buffer(GL_UNIFORM_BUFFER, gpu_lights.size() * sizeof(GpuLight), gpu_lights.data());
}

void SceneLights::draw_maps(const GpuPose& pose) const {
    const GlObject framebuffer = make_framebuffer();
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
    glDrawBuffer(GL_NONE);
    glReadBuffer(GL_NONE);
    glViewport(0, 0, map_size_, map_size_);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);
    glUseProgram(program_.name());
    for (int map = 0; map < map_count_; ++map) {
        glFramebufferTextureLayer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, maps_.name(), 0, map);
        glClear(GL_DEPTH_BUFFER_BIT);
        set_uniform(program_.name(), "u_clip", clips_[size_t(map)]);
        scene_->draw(program_.name(), pose, pose, 1, GpuScene::Sides::both);
    }
    glDisable(GL_DEPTH_TEST);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
}

void SceneLights::bind(GLuint program, int unit) const {
    set_uniform(program, "u_light_count", int(lights_.size()));
    bind_texture(program, "u_shadow_maps", unit, GL_TEXTURE_2D_ARRAY, maps_.name());
    glUniformBlockBinding(program, glGetUniformBlockIndex(program, "Lights"), kUniformBinding);
    glBindBufferBase(GL_UNIFORM_BUFFER, kUniformBinding, uniforms_.name());
}
