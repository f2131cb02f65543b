#include "scene_gpu.hpp"

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>

#include <algorithm>
#include <cstddef>
#include <map>
#include <stdexcept>

namespace {

using glm::mat4;
using glm::vec3;
using glm::vec4;

// ---- Shaders --------------------------------------------------------------------------------------------

const char* const kVersion = "#version 330 core\n";

const char* const kFullscreenVertex = R"(
void main() { // (-1,-1) (3,-1) (-1,3)
    vec2 corner = vec2(float((gl_VertexID & 1) << 2), float((gl_VertexID & 2) << 1));
    gl_Position = vec4(corner - 1.0, 0.0, 1.0);
}
)";

// Behind `#define SCENE_SKINS` where there are any: a scene without them shall not pay for them.
const char* const kSceneVertex = R"(
layout(location = 0) in vec3 a_position;
layout(location = 1) in vec3 a_normal;
layout(location = 2) in vec4 a_tangent;
layout(location = 3) in vec2 a_uv;
layout(location = 4) in vec4 a_color;

uniform mat4 u_world;
uniform mat4 u_world_before; // the same, one frame ago
uniform mat3 u_normal_to_world;
uniform float u_handedness;

float handedness() { return u_handedness; }

#ifdef SCENE_SKINS
layout(location = 5) in uvec4 a_joints;
layout(location = 6) in vec4 a_weights;

uniform int u_first_joint; // -1: the mesh has no skin
uniform samplerBuffer u_joints;
uniform samplerBuffer u_joints_before;

mat4 joint(samplerBuffer joints, uint index) {
    int t = 4 * (u_first_joint + int(index));
    return mat4(texelFetch(joints, t), texelFetch(joints, t + 1), texelFetch(joints, t + 2), texelFetch(joints, t + 3));
}

mat4 skin(samplerBuffer joints) {
    return a_weights.x * joint(joints, a_joints.x) + a_weights.y * joint(joints, a_joints.y) +
           a_weights.z * joint(joints, a_joints.z) + a_weights.w * joint(joints, a_joints.w);
}

mat4 to_world() { return u_first_joint < 0 ? u_world : skin(u_joints); }
mat4 to_world_before() { return u_first_joint < 0 ? u_world_before : skin(u_joints_before); }

// Cofactors are the inverse transpose times the determinant: they need no division.
mat3 normal_to_world() {
    if (u_first_joint < 0) return u_normal_to_world;
    mat3 m = mat3(to_world());
    return mat3(cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])) * u_handedness;
}
#else
mat4 to_world() { return u_world; }
mat4 to_world_before() { return u_world_before; }
mat3 normal_to_world() { return u_normal_to_world; }
#endif
)";

const char* const kDepthVertex = R"(
uniform mat4 u_clip;
out vec2 v_uv;
out vec4 v_color;

void main() {
    v_uv = a_uv;
    v_color = a_color;
    gl_Position = u_clip * (to_world() * vec4(a_position, 1.0));
}
)";

const char* const kDepthFragment = R"(
in vec2 v_uv;
in vec4 v_color;

void main() {
    if (is_cut_out(base_color(v_uv, v_color))) discard;
}
)";

GlObject compile_shader(const std::string& what, GLenum stage, const std::string& text) {
    GlObject shader(glCreateShader(stage), [](GLuint name) { glDeleteShader(name); });
    const char* source = text.c_str();
    glShaderSource(shader.name(), 1, &source, nullptr);
    glCompileShader(shader.name());
    GLint compiled = GL_FALSE;
    glGetShaderiv(shader.name(), GL_COMPILE_STATUS, &compiled);
    if (compiled == GL_FALSE) {
        char log[1024] = "";
        glGetShaderInfoLog(shader.name(), sizeof log, nullptr, log);
        throw std::runtime_error("a shader of the " + what + " program does not compile: " + log);
    }
    return shader;
}

void link_program(const std::string& what, GLuint program) {
    glLinkProgram(program);
    GLint linked = GL_FALSE;
    glGetProgramiv(program, GL_LINK_STATUS, &linked);
    if (linked != GL_FALSE) { return; }
    char log[1024] = "";
    glGetProgramInfoLog(program, sizeof log, nullptr, log);
    throw std::runtime_error("the " + what + " program does not link: " + log);
}

// ---- Textures -------------------------------------------------------------------------------------------

GLint wrap_mode(Wrap wrap) {
    switch (wrap) {
    case Wrap::mirror: return GL_MIRRORED_REPEAT;
    case Wrap::clamp: return GL_CLAMP_TO_EDGE;
    case Wrap::repeat: break;
    }
    return GL_REPEAT;
}

GlObject upload_texture(const Image& image, const Texture& texture, bool srgb) {
    GlObject object = make_texture();
    glBindTexture(GL_TEXTURE_2D, object.name());
    glTexImage2D(GL_TEXTURE_2D, 0, srgb ? GL_SRGB8_ALPHA8 : GL_RGBA8, image.width, image.height, 0, GL_RGBA,
                 GL_UNSIGNED_BYTE, image.rgba.data());
    const bool nearest = texture.filter == Filter::nearest;
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, nearest ? GL_NEAREST : GL_LINEAR_MIPMAP_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, nearest ? GL_NEAREST : GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, wrap_mode(texture.wrap_u));
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, wrap_mode(texture.wrap_v));
    if (!nearest) { glGenerateMipmap(GL_TEXTURE_2D); }
    return object;
}

GlObject upload_pixel(std::vector<uint8_t> rgba) {
    Texture nearest;
    nearest.filter = Filter::nearest;
    return upload_texture(Image{1, 1, std::move(rgba)}, nearest, false);
}

// A normal texture for want of one. Half is no byte: 128 of 255 would tilt every normal by 0.32 degrees.
GlObject upload_flat() {
    GlObject object = upload_pixel({0, 0, 0, 0});
    const float half[] = {0.5f, 0.5f, 1.0f, 1.0f};
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA16F, 1, 1, 0, GL_RGBA, GL_FLOAT, half);
    return object;
}

// ---- Geometry -------------------------------------------------------------------------------------------

void set_attribute(GLuint location, GLint components, size_t offset) {
    glEnableVertexAttribArray(location);
    // OpenGL takes the offset into the bound buffer as a pointer
    glVertexAttribPointer(location, components, GL_FLOAT, GL_FALSE, GLsizei(sizeof(Vertex)),
                          reinterpret_cast<const void*>(offset)); // NOLINT(performance-no-int-to-ptr)
}

} // namespace

// ---- Shared helpers -------------------------------------------------------------------------------------

GlObject make_texture() {
    GLuint name = 0;
    glGenTextures(1, &name);
    return {name, [](GLuint texture) { glDeleteTextures(1, &texture); }};
}

GlObject make_buffer(GLenum target, size_t size, const void* data) {
    GLuint name = 0;
    glGenBuffers(1, &name);
    GlObject buffer(name, [](GLuint buffer_name) { glDeleteBuffers(1, &buffer_name); });
    glBindBuffer(target, name);
    glBufferData(target, GLsizeiptr(size), data, GL_STATIC_DRAW);
    return buffer;
}

GlObject make_framebuffer() {
    GLuint name = 0;
    glGenFramebuffers(1, &name);
    return {name, [](GLuint framebuffer) { glDeleteFramebuffers(1, &framebuffer); }};
}

GlObject make_vertex_array() {
    GLuint name = 0;
    glGenVertexArrays(1, &name);
    return {name, [](GLuint vertex_array) { glDeleteVertexArrays(1, &vertex_array); }};
}

GlObject make_program(const std::string& what, const std::string& vertex, const std::string& geometry,
                      const std::string& fragment) {
    GlObject program(glCreateProgram(), [](GLuint name) { glDeleteProgram(name); });
    const auto attach = [&](GLenum stage, const std::string& text) {
        if (!text.empty()) { glAttachShader(program.name(), compile_shader(what, stage, text).name()); }
    };
    attach(GL_VERTEX_SHADER, vertex);
    attach(GL_GEOMETRY_SHADER, geometry);
    attach(GL_FRAGMENT_SHADER, fragment);
    link_program(what, program.name());
    return program;
}

GlObject make_depth_program(const std::string& what, const std::string& scene_vertex) {
    return make_program(what, kVersion + scene_vertex + kDepthVertex, "",
                        std::string(kVersion) + kSceneMaterial + kDepthFragment);
}

GlObject make_fullscreen_program(const std::string& what, const std::string& fragment) {
    return make_program(what, std::string(kVersion) + kFullscreenVertex, "", kVersion + fragment);
}

void set_uniform(GLuint program, const char* name, int value) {
    glUniform1i(glGetUniformLocation(program, name), value);
}

void set_uniform(GLuint program, const char* name, float value) {
    glUniform1f(glGetUniformLocation(program, name), value);
}

void set_uniform(GLuint program, const char* name, vec3 value) {
    glUniform3fv(glGetUniformLocation(program, name), 1, glm::value_ptr(value));
}

void set_uniform(GLuint program, const char* name, glm::vec4 value) {
    glUniform4fv(glGetUniformLocation(program, name), 1, glm::value_ptr(value));
}

void set_uniform(GLuint program, const char* name, const mat4& value) {
    glUniformMatrix4fv(glGetUniformLocation(program, name), 1, GL_FALSE, glm::value_ptr(value));
}

void set_uniform(GLuint program, const char* name, const std::vector<vec3>& values) {
    glUniform3fv(glGetUniformLocation(program, name), GLsizei(values.size()), glm::value_ptr(values[0]));
}

void bind_texture(GLuint program, const char* name, int unit, GLenum target, GLuint texture) {
    set_uniform(program, name, unit);
    glActiveTexture(GLenum(GL_TEXTURE0 + unit));
    glBindTexture(target, texture);
}

// ---- Scene ----------------------------------------------------------------------------------------------

const char* const kSceneMaterial = R"(
uniform vec4 u_factors[3]; // base color | emissive, alpha cutoff | metallic, roughness, normal scale, unlit
uniform sampler2D u_base_color;
uniform sampler2D u_metallic_roughness;
uniform sampler2D u_normal;
uniform sampler2D u_emissive;

vec4 base_color(vec2 uv, vec4 vertex_color) {
    return u_factors[0] * texture(u_base_color, uv) * vertex_color;
}

bool is_cut_out(vec4 base) { return base.a < u_factors[1].a; }
)";

GpuPose::GpuPose(Pose matrices) : matrices_(std::move(matrices)) {
    const std::vector<mat4>& joints = matrices_.joints;
    if (joints.empty()) { return; }
    joints_ = make_buffer(GL_TEXTURE_BUFFER, joints.size() * sizeof(mat4), joints.data());
    texture_ = make_texture();
    glBindTexture(GL_TEXTURE_BUFFER, texture_.name());
    glTexBuffer(GL_TEXTURE_BUFFER, GL_RGBA32F, joints_.name());
}

void GpuPose::bind_joints(int unit) const {
    glActiveTexture(GLenum(GL_TEXTURE0 + unit));
    glBindTexture(GL_TEXTURE_BUFFER, texture_.name());
}

GpuScene::GpuScene(const Scene& scene) : first_pose_(std::make_shared<GpuPose>(current_pose(scene))) {
    upload_geometry(scene);
    upload_materials(scene);
    list_draws(scene);
}

std::string GpuScene::vertex_text() const {
    return std::string(has_skins_ ? "#define SCENE_SKINS\n" : "") + kSceneVertex;
}

void GpuScene::upload_geometry(const Scene& scene) {
    std::vector<Vertex> vertices;
    std::vector<uint32_t> indices;
    for (const Mesh& mesh : scene.meshes) {
        vertices.insert(vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
        indices.insert(indices.end(), mesh.indices.begin(), mesh.indices.end());
    }
    vertex_array_ = make_vertex_array();
    glBindVertexArray(vertex_array_.name());
    vertices_ = make_buffer(GL_ARRAY_BUFFER, vertices.size() * sizeof(Vertex), vertices.data());
    indices_ = make_buffer(GL_ELEMENT_ARRAY_BUFFER, indices.size() * sizeof(uint32_t), indices.data());
    set_attribute(0, 3, offsetof(Vertex, position));
    set_attribute(1, 3, offsetof(Vertex, normal));
    set_attribute(2, 4, offsetof(Vertex, tangent));
    set_attribute(3, 2, offsetof(Vertex, uv));
    set_attribute(4, 4, offsetof(Vertex, color));
    glEnableVertexAttribArray(5);
    glVertexAttribIPointer(
        5, 4, GL_UNSIGNED_SHORT, GLsizei(sizeof(Vertex)),
        reinterpret_cast<const void*>(offsetof(Vertex, joints))); // NOLINT(performance-no-int-to-ptr)
    set_attribute(6, 4, offsetof(Vertex, weights));
    glBindVertexArray(0);
}

void GpuScene::upload_materials(const Scene& scene) {
    const GLuint white = textures_.emplace_back(upload_pixel({255, 255, 255, 255})).name();
    const GLuint flat = textures_.emplace_back(upload_flat()).name();
    std::map<std::pair<int, bool>, GLuint> uploaded; // one image may hold colors for one material, data for another
    const auto texture = [&](int index, bool srgb, GLuint missing) {
        if (index < 0 || scene.textures[size_t(index)].image < 0) { return missing; }
        const auto [found, is_new] = uploaded.try_emplace({index, srgb}, 0);
        if (is_new) {
            const Texture& source = scene.textures[size_t(index)];
            textures_.push_back(upload_texture(scene.images[size_t(source.image)], source, srgb));
            found->second = textures_.back().name();
        }
        return found->second;
    };
    for (const Material& m : scene.materials) {
        const float cutoff = m.alpha_mode == AlphaMode::mask ? m.alpha_cutoff : 0.0f;
        GpuMaterial& material = materials_.emplace_back();
        material.factors = {m.base_color, vec4(m.emissive, cutoff),
                            vec4(m.metallic, m.roughness, m.normal_scale, m.unlit ? 1.0f : 0.0f)};
        material.textures = {texture(m.base_color_texture, true, white),
                             texture(m.metallic_roughness_texture, false, white),
                             texture(m.normal_texture, false, flat), texture(m.emissive_texture, true, white)};
        material.double_sided = m.double_sided;
    }
}

void GpuScene::list_draws(const Scene& scene) {
    std::vector<std::pair<size_t, size_t>> starts; // first index, first vertex of each mesh
    size_t index_count = 0, vertex_count = 0;
    for (const Mesh& mesh : scene.meshes) {
        starts.emplace_back(index_count, vertex_count);
        index_count += mesh.indices.size();
        vertex_count += mesh.vertices.size();
    }
    const std::vector<int> first_joints = first_joints_of(scene);
    for (size_t node_index = 0; node_index < scene.nodes.size(); ++node_index) {
        const Node& node = scene.nodes[node_index];
        const int first_joint = node.skin < 0 ? -1 : first_joints[size_t(node.skin)];
        has_skins_ = has_skins_ || first_joint >= 0;
        for (int mesh_index : node.meshes) {
            const Mesh& mesh = scene.meshes[size_t(mesh_index)];
            const auto [first_index, first_vertex] = starts[size_t(mesh_index)];
            const Material& material = scene.materials[size_t(mesh.material)];
            if (material.alpha_mode == AlphaMode::blend || mesh.indices.empty()) { continue; }
            draws_.push_back({mesh.material, int(node_index), first_joint, GLsizei(mesh.indices.size()), first_index,
                              GLint(first_vertex)});
        }
    }
    std::stable_sort(draws_.begin(), draws_.end(),
                     [](const Draw& a, const Draw& b) { return a.material < b.material; });
}

void GpuScene::set_material(GLuint program, const GpuMaterial& material, Sides sides) {
    glUniform4fv(glGetUniformLocation(program, "u_factors"), GLsizei(material.factors.size()),
                 glm::value_ptr(material.factors[0]));
    for (size_t unit = 0; unit < material.textures.size(); ++unit) {
        glActiveTexture(GLenum(GL_TEXTURE0 + unit));
        glBindTexture(GL_TEXTURE_2D, material.textures[unit]);
    }
    (material.double_sided || sides == Sides::both ? glDisable : glEnable)(GL_CULL_FACE);
    glCullFace(sides == Sides::back ? GL_FRONT : GL_BACK);
}

// Of the uniforms that place a mesh.
struct GpuScene::Places {
    explicit Places(GLuint program)
        : world(glGetUniformLocation(program, "u_world")),
          world_before(glGetUniformLocation(program, "u_world_before")),
          normal_to_world(glGetUniformLocation(program, "u_normal_to_world")),
          handedness(glGetUniformLocation(program, "u_handedness")),
          first_joint(glGetUniformLocation(program, "u_first_joint")) {}

    GLint world, world_before, normal_to_world, handedness, first_joint;
};

// A skinned mesh is mirrored when its first joint is.
void GpuScene::place(const Draw& draw, const Pose& pose, const Pose& before, const Places& places) {
    const mat4& world = pose.nodes[size_t(draw.node)];
    const glm::mat3 linear(draw.first_joint < 0 ? world : pose.joints[size_t(draw.first_joint)]);
    const bool mirrored = glm::determinant(linear) < 0.0f;
    glFrontFace(mirrored ? GL_CW : GL_CCW);
    glUniformMatrix4fv(places.world, 1, GL_FALSE, glm::value_ptr(world));
    glUniformMatrix4fv(places.world_before, 1, GL_FALSE, glm::value_ptr(before.nodes[size_t(draw.node)]));
    glUniformMatrix3fv(places.normal_to_world, 1, GL_FALSE, glm::value_ptr(glm::transpose(glm::inverse(linear))));
    glUniform1f(places.handedness, mirrored ? -1.0f : 1.0f);
    glUniform1i(places.first_joint, draw.first_joint);
}

DrawCounts GpuScene::draw(GLuint program, const GpuPose& pose, const GpuPose& before, int instances,
                          Sides sides) const {
    static const char* const samplers[] = {"u_base_color", "u_metallic_roughness", "u_normal", "u_emissive",
                                           "u_joints",     "u_joints_before"};
    const Places places(program);
    for (int unit = 0; unit < 6; ++unit) { set_uniform(program, samplers[unit], unit); }
    pose.bind_joints(4);
    before.bind_joints(5);
    glBindVertexArray(vertex_array_.name());

    DrawCounts counts;
    int bound_material = -1;
    for (const Draw& d : draws_) {
        if (d.material != bound_material) {
            bound_material = d.material;
            set_material(program, materials_[size_t(d.material)], sides);
        }
        place(d, pose.matrices(), before.matrices(), places);
        const size_t offset = d.first_index * sizeof(uint32_t);
        glDrawElementsInstancedBaseVertex(GL_TRIANGLES, d.index_count, GL_UNSIGNED_INT,
                                          reinterpret_cast<const void*>(offset), // NOLINT(performance-no-int-to-ptr)
                                          instances, d.first_vertex);
        ++counts.draw_calls;
        counts.triangles += int64_t(d.index_count) / 3 * instances;
    }
    return counts;
}
