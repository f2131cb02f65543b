// What building the layers costs, oracle by oracle and emission by emission, as ratios to one layer in one process.
//     construction [--quick] [SCENE[@ex,ey,ez,tx,ty,tz,fov]]...      always: a colonnade of 10k, 100k and 850k triangles
//
// The contenders take turns frame by frame; every figure is a median of ratios within a turn. Two clocks: wall time between
// two glFinish, and the process's own time, which does not mind a busy machine but counts all threads. Where the renderer
// is software, the process's time decides; else wall time. A small engine of its own draws: one buffer of skinned vertices,
// a texture a draw, no sorting.
#include "library.hpp"

#include <cmath>
#include <cstddef>

namespace {

using glm::mat4;
using glm::vec3;
using glm::vec4;

// ---- Colonnade ------------------------------------------------------------------------------------------

constexpr int kColumnsAcross = 8, kColumnsDeep = 15, kWalls = 5;
constexpr int kMeshes = kColumnsAcross * kColumnsDeep + kWalls;
constexpr float kSpacing = 3.0f, kHeightOfHall = 6.0f; // metres
constexpr float kHallWidth = kSpacing * kColumnsAcross, kHallDepth = kSpacing * kColumnsDeep;

// A grid over the unit square, carried to space by a function that gives a position; u x v must be the outward normal.
template <typename Surface>
Mesh tessellate(int columns, int rows, int material, Surface surface) {
    constexpr float kStep = 1e-3f;
    Mesh mesh;
    mesh.material = material;
    for (int j = 0; j <= rows; ++j) {
        for (int i = 0; i <= columns; ++i) {
            const float u = float(i) / float(columns), v = float(j) / float(rows);
            Vertex& vertex = mesh.vertices.emplace_back();
            vertex.position = surface(u, v);
            vertex.normal = glm::normalize(
                glm::cross(surface(u + kStep, v) - vertex.position, surface(u, v + kStep) - vertex.position));
            vertex.uv = 4.0f * glm::vec2(u, v);
        }
    }
    for (int j = 0; j < rows; ++j) {
        for (int i = 0; i < columns; ++i) {
            const auto a = uint32_t(j * (columns + 1) + i), b = a + uint32_t(columns) + 1;
            mesh.indices.insert(mesh.indices.end(), {a, a + 1, b + 1, a, b + 1, b});
        }
    }
    return mesh;
}

Mesh make_column(vec3 foot, int side) {
    return tessellate(side, side, 1, [=](float u, float v) {
        const float angle = -2.0f * glm::pi<float>() * u, radius = 0.45f - 0.1f * v;
        return foot + vec3(radius * std::cos(angle), kHeightOfHall * v, radius * std::sin(angle));
    });
}

Mesh make_wall(vec3 corner, vec3 u_edge, vec3 v_edge, int side) {
    return tessellate(side, side, 0, [=](float u, float v) { return corner + u * u_edge + v * v_edge; });
}

Image checkered() {
    Image image{256, 256, {}};
    for (int i = 0; i < image.width * image.height; ++i) {
        const bool light = ((i / 32) ^ (i / image.width / 32)) & 1;
        const auto value = uint8_t((light ? 200 : 120) + i * 7 % 32);
        image.rgba.insert(image.rgba.end(), {value, value, uint8_t(value - 20), 255});
    }
    return image;
}

// A hall of columns, each mesh with the same number of triangles. The camera stands in one corner and looks to the other.
View make_colonnade(int triangles) {
    const int side = std::max(1, int(std::lround(std::sqrt(triangles / (2.0 * kMeshes)))));
    const vec3 x(kHallWidth, 0.0f, 0.0f), y(0.0f, kHeightOfHall, 0.0f), z(0.0f, 0.0f, kHallDepth);
    View view;
    view.name = "colonnade " + std::to_string(triangles / 1000) + "k";
    Scene& scene = view.scene;
    scene.images = {checkered()};
    scene.textures = {Texture{0}};
    scene.materials.resize(2);
    scene.materials[0].base_color = vec4(0.8f, 0.6f, 0.5f, 1.0f);
    for (Material& material : scene.materials) { material.base_color_texture = 0; }
    for (int i = 0; i < kColumnsAcross * kColumnsDeep; ++i) {
        const int column = i % kColumnsAcross, row = i / kColumnsAcross;
        const vec3 foot(float(column) + 0.5f, 0.0f, float(row) + 0.5f);
        scene.meshes.push_back(make_column(kSpacing * foot, side));
    }
    scene.meshes.push_back(make_wall(vec3(0.0f), z, x, side));      // floor
    scene.meshes.push_back(make_wall(y, x, z, side));               // ceiling
    scene.meshes.push_back(make_wall(vec3(0.0f), x, y, side));      // back
    scene.meshes.push_back(make_wall(x, z, y, side));               // right
    scene.meshes.push_back(make_wall(vec3(0.0f) + z, -z, y, side)); // left
    scene.nodes.resize(1);
    for (int i = 0; i < kMeshes; ++i) {
        scene.nodes[0].meshes.push_back(i * 37 % kMeshes);
    } // neither near nor far first
    update_bounds(&scene);
    view.camera.eye = vec3(3.0f, 1.7f, kHallDepth - 3.0f);
    view.camera.target = vec3(14.0f, 2.2f, 0.0f);
    view.camera.vertical_fov = glm::radians(60.0f);
    set_planes(scene, &view.camera);
    return view;
}

// ---- Shaders --------------------------------------------------------------------------------------------

constexpr int kBones = 64;

// The expensive vertex stage: four bones, then ripples as dear as a few morph targets; now and one frame before.
const char* const kSkinning = R"(
layout(std140) uniform Bones { mat4 bones[64]; mat4 bones_before[64]; };
uniform float u_time, u_time_before; // frames

mat4 blended(uvec4 b, vec4 w) { return bones[b.x] * w.x + bones[b.y] * w.y + bones[b.z] * w.z + bones[b.w] * w.w; }

mat4 blended_before(uvec4 b, vec4 w) {
    return bones_before[b.x] * w.x + bones_before[b.y] * w.y + bones_before[b.z] * w.z + bones_before[b.w] * w.w;
}

vec3 rippled(vec3 p, vec3 n, float time) {
    float height = 0.0;
    for (int i = 1; i <= 8; ++i) height += sin(float(i) * (dot(p, vec3(1.7, 2.3, 1.1)) + 0.1 * time)) / float(i * i);
    return p + n * (0.002 * height);
}

void skin(vec3 position, vec3 normal, uvec4 b, vec4 w, out vec3 now, out vec3 before, out vec3 normal_now) {
    mat4 m = blended(b, w);
    normal_now = normalize(mat3(m) * normal);
    now = rippled((m * vec4(position, 1.0)).xyz, normal_now, u_time);
    before = rippled((blended_before(b, w) * vec4(position, 1.0)).xyz, normal_now, u_time_before);
}
)";

const char* const kSkinCompute = R"(
layout(local_size_x = 64) in;
struct Source { float position[3], normal[3], uv[2], weights[4]; uint bones; };
struct Skinned { vec4 now, before, normal; };
layout(std430, binding = 0) readonly buffer Sources { Source sources[]; };
layout(std430, binding = 1) writeonly buffer Cache { Skinned cache[]; };
uniform uint u_count;

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= u_count) return;
    Source s = sources[i];
    vec3 now, before, normal;
    uvec4 b = (uvec4(s.bones) >> uvec4(0, 8, 16, 24)) & 255u;
    skin(vec3(s.position[0], s.position[1], s.position[2]), vec3(s.normal[0], s.normal[1], s.normal[2]), b,
         vec4(s.weights[0], s.weights[1], s.weights[2], s.weights[3]), now, before, normal);
    cache[i] = Skinned(vec4(now, 1.0), vec4(before, 1.0), vec4(normal, 0.0));
}
)";

const char* const kVertex = R"(
layout(location = 0) in vec3 a_position;
layout(location = 1) in vec3 a_normal;
layout(location = 2) in vec2 a_uv;
layout(location = 3) in vec4 a_weights;
layout(location = 4) in uvec4 a_bones;
layout(location = 5) in vec3 a_before;
uniform mat4 u_view, u_clip, u_clip_before; // to camera, to clip space, the latter also one frame ago
out vec3 v_normal;
out vec2 v_uv;

void main() {
    vec3 now = a_position, before = a_before, normal = a_normal;
#ifdef SKINNED
    skin(a_position, a_normal, a_bones, a_weights, now, before, normal);
#endif
    v_normal = mat3(u_view) * normal;
    v_uv = a_uv;
    dgb_vertex(u_clip * vec4(now, 1.0), u_clip_before * vec4(before, 1.0));
}
)";

const char* const kFragment = R"(
in vec3 v_normal;
in vec2 v_uv;
uniform vec4 u_color;
uniform float u_cutoff;
uniform sampler2D u_texture;

void main() {
    vec4 base = u_color * texture(u_texture, v_uv);
    if (base.a < u_cutoff) discard;
    if (!dgb_keep()) discard;
    vec3 normal = normalize(gl_FrontFacing ? v_normal : -v_normal);
    dgb_store(vec4(base.rgb, 1.0), normal, vec2(1.0, 0.0), base.rgb * (0.3 + 0.3 * max(normal.y, 0.0)));
}
)";

// For depth alone: what PREDICT and DELAY draw of the next pose.
const char* const kDepthFragment = R"(
in vec2 v_uv;
uniform vec4 u_color;
uniform float u_cutoff;
uniform sampler2D u_texture;

void main() {
    if (u_color.a * texture(u_texture, v_uv).a < u_cutoff) discard;
    if (!dgb_keep()) discard;
}
)";

// ---- Programs -------------------------------------------------------------------------------------------

// Calls a function that writes text as snprintf does: once for the length, once for the text.
template <typename Write>
std::string text_of(Write write) {
    std::string text(write(nullptr, size_t{0}), '\0');
    write(text.data(), text.size() + 1);
    return text;
}

// A material program for the layers of a context.
GlObject make_material_program(const dgb_context* context, const std::vector<dgbgl_varying>& varyings,
                               const std::string& vertex, const std::string& fragment) {
    const int count = int(varyings.size());
    const auto prefix = [&](dgbgl_stage stage) {
        return text_of([&](char* text, size_t size) {
            return dgbgl_shader_prefix(context, stage, varyings.data(), count, text, size);
        });
    };
    const std::string geometry = text_of(
        [&](char* text, size_t size) { return dgbgl_geometry_shader(context, varyings.data(), count, text, size); });
    GlObject program =
        make_program("material", prefix(DGBGL_VERTEX) + vertex, geometry, prefix(DGBGL_FRAGMENT) + fragment);
    if (dgbgl_attach_program(context, program.name()) != DGB_OK) {
        throw std::runtime_error("the material program lacks the library's text");
    }
    return program;
}

// ---- Model ----------------------------------------------------------------------------------------------

struct SkinnedVertex { // `Source` in the compute shader
    vec3 position, normal;
    glm::vec2 uv;
    vec4 weights;
    uint8_t bones[4];
};

struct CachedVertex { // `Skinned` there
    vec4 now, before, normal;
};

GlObject upload_texture(const Image& image) {
    GlObject texture = make_texture();
    glBindTexture(GL_TEXTURE_2D, texture.name());
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, image.width, image.height, 0, GL_RGBA, GL_UNSIGNED_BYTE,
                 image.rgba.data());
    glGenerateMipmap(GL_TEXTURE_2D);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_NEAREST);
    return texture;
}

// Bones stand in a row through the scene; a point hangs on the four around it by the weights of a cubic spline.
void bind_to_bones(SkinnedVertex* vertex) {
    const float along = glm::clamp(vertex->position.x + vertex->position.z + 30.0f, 1.0f, float(kBones) - 3.0f);
    const int bone = int(along);
    const float t = along - float(bone), s = 1.0f - t;
    vertex->weights = vec4(s * s * s, 4 - 6 * t * t + 3 * t * t * t, 4 - 6 * s * s + 3 * s * s * s, t * t * t) / 6.0f;
    for (int i = 0; i < 4; ++i) { vertex->bones[i] = uint8_t(bone - 1 + i); }
}

mat4 bone_matrix(int bone, int frame) {
    const float angle = 0.1f * float(frame) + 0.7f * float(bone);
    const mat4 moved_up = glm::translate(mat4(1.0f), vec3(0.01f * std::sin(angle), 0.01f * std::cos(angle), 0.0f));
    return glm::rotate(moved_up, 0.0005f * std::sin(angle), vec3(0.0f, 1.0f, 0.0f));
}

// A scene in world space, in buffers.
class Model {
public:
    explicit Model(const Scene& scene);

    int64_t triangles() const { return triangles_; }
    int meshes() const { return int(draws_.size()); }

    void pose(int frame) const;      // sets the bones
    void skin(GLuint compute) const; // fills the cache
    // Returns the number of draw calls. back: of what has one side, the faces that are not seen
    int draw(GLuint program, bool cached, int instances, bool back) const;

private:
    struct Draw {
        vec4 color;
        float cutoff;
        GLuint texture;
        bool double_sided, mirrored;
        GLsizei index_count;
        size_t first_index;
    };

    void add_mesh(const Scene& scene, const Mesh& mesh, const mat4& world);
    void upload();

    std::vector<SkinnedVertex> vertices_;
    std::vector<uint32_t> indices_;
    std::vector<Draw> draws_;
    std::vector<GlObject> textures_; // those of the scene, then a white one
    GlObject vertex_buffer_, index_buffer_, cache_, bones_, arrays_[2];
    int64_t triangles_ = 0;
};

Model::Model(const Scene& scene) {
    for (const Image& image : scene.images) { textures_.push_back(upload_texture(image)); }
    textures_.push_back(upload_texture({1, 1, {255, 255, 255, 255}}));
    for (const Node& node : scene.nodes) {
        for (int mesh : node.meshes) { add_mesh(scene, scene.meshes[size_t(mesh)], node.world); }
    }
    upload();
}

void Model::add_mesh(const Scene& scene, const Mesh& mesh, const mat4& world) {
    const Material& material = scene.materials[size_t(mesh.material)];
    if (material.alpha_mode == AlphaMode::blend || mesh.indices.empty()) { return; }
    const glm::mat3 normal_to_world = glm::transpose(glm::inverse(glm::mat3(world)));
    const auto base = uint32_t(vertices_.size());
    for (const Vertex& source : mesh.vertices) {
        SkinnedVertex& vertex = vertices_.emplace_back();
        vertex.position = vec3(world * vec4(source.position, 1.0f));
        vertex.normal = normal_to_world * source.normal;
        vertex.uv = source.uv;
        bind_to_bones(&vertex);
    }
    const int texture = material.base_color_texture;
    const int image = texture < 0 ? -1 : scene.textures[size_t(texture)].image;
    draws_.push_back({material.base_color, material.alpha_mode == AlphaMode::mask ? material.alpha_cutoff : 0.0f,
                      (image < 0 ? textures_.back() : textures_[size_t(image)]).name(), material.double_sided,
                      glm::determinant(world) < 0.0f, GLsizei(mesh.indices.size()), indices_.size()});
    for (uint32_t index : mesh.indices) { indices_.push_back(base + index); }
    triangles_ += int64_t(mesh.indices.size()) / 3;
}

void set_attribute(GLuint location, int size, GLsizei stride, size_t offset) {
    glEnableVertexAttribArray(location);
    glVertexAttribPointer(location, size, GL_FLOAT, GL_FALSE, stride,
                          reinterpret_cast<const void*>(offset)); // NOLINT(performance-no-int-to-ptr)
}

void Model::upload() {
    constexpr auto kStride = GLsizei(sizeof(SkinnedVertex)), kCacheStride = GLsizei(sizeof(CachedVertex));
    for (GlObject& array : arrays_) { array = make_vertex_array(); }
    vertex_buffer_ = make_buffer(GL_ARRAY_BUFFER, vertices_.size() * sizeof(SkinnedVertex), vertices_.data());
    cache_ = make_buffer(GL_ARRAY_BUFFER, vertices_.size() * sizeof(CachedVertex), nullptr);
    index_buffer_ = make_buffer(GL_ARRAY_BUFFER, indices_.size() * sizeof(uint32_t), indices_.data());
    bones_ = make_buffer(GL_UNIFORM_BUFFER, 2 * kBones * sizeof(mat4), nullptr);
    for (const GlObject& array : arrays_) {
        const bool cached = &array == &arrays_[1];
        glBindVertexArray(array.name());
        glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, index_buffer_.name());
        glBindBuffer(GL_ARRAY_BUFFER, vertex_buffer_.name());
        set_attribute(2, 2, kStride, offsetof(SkinnedVertex, uv));
        set_attribute(3, 4, kStride, offsetof(SkinnedVertex, weights));
        glEnableVertexAttribArray(4);
        glVertexAttribIPointer(
            4, 4, GL_UNSIGNED_BYTE, kStride,
            reinterpret_cast<const void*>(offsetof(SkinnedVertex, bones))); // NOLINT(performance-no-int-to-ptr)
        if (cached) { glBindBuffer(GL_ARRAY_BUFFER, cache_.name()); }
        set_attribute(0, 3, cached ? kCacheStride : kStride, 0);
        set_attribute(5, 3, cached ? kCacheStride : kStride, cached ? offsetof(CachedVertex, before) : 0);
        set_attribute(1, 3, cached ? kCacheStride : kStride,
                      cached ? offsetof(CachedVertex, normal) : offsetof(SkinnedVertex, normal));
    }
    glBindVertexArray(0);
}

void Model::pose(int frame) const {
    std::vector<mat4> matrices;
    for (int time : {frame, frame - 1}) {
        for (int bone = 0; bone < kBones; ++bone) { matrices.push_back(bone_matrix(bone, time)); }
    }
    glBindBuffer(GL_UNIFORM_BUFFER, bones_.name());
    glBufferData(GL_UNIFORM_BUFFER, GLsizeiptr(matrices.size() * sizeof(mat4)), matrices.data(), GL_STREAM_DRAW);
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, bones_.name());
}

void Model::skin(GLuint compute) const {
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, vertex_buffer_.name());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, cache_.name());
    glUniform1ui(glGetUniformLocation(compute, "u_count"), GLuint(vertices_.size()));
    glDispatchCompute(GLuint(vertices_.size() + 63) / 64, 1, 1);
    glMemoryBarrier(GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT);
}

int Model::draw(GLuint program, bool cached, int instances, bool back) const {
    const GLint color = glGetUniformLocation(program, "u_color"), cutoff = glGetUniformLocation(program, "u_cutoff");
    set_uniform(program, "u_texture", 0);
    glActiveTexture(GL_TEXTURE0);
    glBindVertexArray(arrays_[cached ? 1 : 0].name());
    for (const Draw& draw : draws_) {
        const size_t offset = draw.first_index * sizeof(uint32_t);
        (draw.double_sided ? glDisable : glEnable)(GL_CULL_FACE);
        glCullFace(back ? GL_FRONT : GL_BACK);
        glFrontFace(draw.mirrored ? GL_CW : GL_CCW);
        glUniform4fv(color, 1, glm::value_ptr(draw.color));
        glUniform1f(cutoff, draw.cutoff);
        glBindTexture(GL_TEXTURE_2D, draw.texture);
        glDrawElementsInstanced(GL_TRIANGLES, draw.index_count, GL_UNSIGNED_INT,
                                reinterpret_cast<const void*>(offset), // NOLINT(performance-no-int-to-ptr)
                                instances);
    }
    return int(draws_.size());
}

// ---- Contenders -----------------------------------------------------------------------------------------

struct Method {
    const char* name;
    dgb_oracle oracle;
    dgb_emission emission;
    bool one_layer;
    bool cached;       // a compute shader transforms the vertices first; only where they are expensive
    bool back = false; // faces are drawn as well
};

constexpr Method kMethods[] = {
    {"one layer", DGB_ORACLE_PEEL, DGB_EMISSION_SEPARATE, true, false},
    {"peel", DGB_ORACLE_PEEL, DGB_EMISSION_SEPARATE, false, false},
    {"skin cache, one layer", DGB_ORACLE_PEEL, DGB_EMISSION_SEPARATE, true, true},
    {"skin cache, peel", DGB_ORACLE_PEEL, DGB_EMISSION_SEPARATE, false, true},
    {"separate", DGB_ORACLE_REPROJECT, DGB_EMISSION_SEPARATE, false, false},
    {"geometry", DGB_ORACLE_REPROJECT, DGB_EMISSION_GEOMETRY, false, false},
    {"instanced geometry", DGB_ORACLE_REPROJECT, DGB_EMISSION_INSTANCED_GEOMETRY, false, false},
    {"vertex", DGB_ORACLE_REPROJECT, DGB_EMISSION_VERTEX, false, false},
    {"image", DGB_ORACLE_REPROJECT, DGB_EMISSION_IMAGE, false, false},
    {"skin cache, image", DGB_ORACLE_REPROJECT, DGB_EMISSION_IMAGE, false, true},
    {"warp, vertex", DGB_ORACLE_WARP, DGB_EMISSION_VERTEX, false, false},
    {"warp, image", DGB_ORACLE_WARP, DGB_EMISSION_IMAGE, false, false},
    {"predict, vertex", DGB_ORACLE_PREDICT, DGB_EMISSION_VERTEX, false, false},
    {"predict, image", DGB_ORACLE_PREDICT, DGB_EMISSION_IMAGE, false, false},
    {"delay, vertex", DGB_ORACLE_DELAY, DGB_EMISSION_VERTEX, false, false},
    {"delay, image", DGB_ORACLE_DELAY, DGB_EMISSION_IMAGE, false, false},
    {"vertex, back faces", DGB_ORACLE_REPROJECT, DGB_EMISSION_VERTEX, false, false, true},
    {"image, back faces", DGB_ORACLE_REPROJECT, DGB_EMISSION_IMAGE, false, false, true},
};
constexpr size_t kOneLayer = 0, kPeel = 1; // rows that the others are compared with

struct Config {
    bool expensive; // vertex stage
    int layers, divisor;
    int frames; // measured
};

dgb_desc describe(const Method& method, const Config& config) {
    dgb_desc desc{};
    desc.width = kWidth;
    desc.height = kHeight;
    desc.layers = method.one_layer ? 1 : config.layers;
    desc.divisor = method.one_layer ? 1 : config.divisor;
    desc.oracle = method.oracle;
    desc.emission = method.emission;
    if (method.back) {
        desc.thickness = DGB_THICKNESS_BACK_FACES;
        desc.effects = DGB_EFFECT_REFLECT; // which reads them
    }
    return desc;
}

struct Times {
    std::vector<double> wall, cpu; // milliseconds, one a frame

    const std::vector<double>& deciding() const { return is_software_rasteriser() ? cpu : wall; }
};

struct Counts {
    int draw_calls = 0;
    GLuint64 vertices = 0;  // vertex-shader invocations
    GLuint64 fragments = 0; // that pass the alpha test, hidden ones as well
};

class Contender {
public:
    Contender(const Method& method, const Config& config, const View& view, const Model& model)
        : method_(method), expensive_(config.expensive), view_(view), model_(model),
          library_(describe(method, config)) {
        static const std::vector<dgbgl_varying> varyings = {{nullptr, "vec3", "v_normal"}, {nullptr, "vec2", "v_uv"}};
        const std::string vertex = expensive_ && !method.cached ? std::string("#define SKINNED\n") + kSkinning : "";
        program_ = make_material_program(library_.context(), varyings, vertex + kVertex, kFragment);
        if (method.oracle == DGB_ORACLE_PREDICT || method.oracle == DGB_ORACLE_DELAY || method.back) {
            depth_program_ = make_material_program(library_.context(), varyings, vertex + kVertex, kDepthFragment);
        }
        if (method.cached) { compute_ = make_compute(); }
    }

    const Method& method() const { return method_; }
    const Times& times() const { return times_; }

    void build(int frame);
    void measure(int frame);
    Counts count(int frame);

private:
    static GlObject make_compute();
    void draw(const dgb_draw& what);
    static void set_times(GLuint program, int frame);

    Method method_;
    bool expensive_;
    const View& view_;
    const Model& model_;
    Library library_;
    GlObject program_, depth_program_, compute_;
    Times times_;
    Counts counts_;
    int frame_ = 0;
    bool counts_fragments_ = false;
};

GlObject Contender::make_compute() {
    const std::string text = std::string("#version 430 core\n") + kSkinning + kSkinCompute;
    const char* source = text.c_str();
    GlObject program(glCreateShaderProgramv(GL_COMPUTE_SHADER, 1, &source), [](GLuint name) { glDeleteProgram(name); });
    GLint linked = GL_FALSE;
    glGetProgramiv(program.name(), GL_LINK_STATUS, &linked);
    if (linked == GL_FALSE) { throw std::runtime_error("the skinning program does not link"); }
    return program;
}

void Contender::set_times(GLuint program, int frame) {
    set_uniform(program, "u_time", float(frame));
    set_uniform(program, "u_time_before", float(frame - 1));
}

void Contender::draw(const dgb_draw& what) {
    const int frame = frame_ + what.pose;
    const mat4 view = glm::make_mat4(what.view);
    if (expensive_ && what.first_layer == 0) { model_.pose(frame); }
    if (method_.cached && what.first_layer == 0) {
        glUseProgram(compute_.name());
        set_times(compute_.name(), frame);
        model_.skin(compute_.name());
    }
    const GLuint program = (what.depth_only ? depth_program_ : program_).name();
    glUseProgram(program);
    set_times(program, frame);
    set_uniform(program, "u_view", view);
    set_uniform(program, "u_clip", glm::make_mat4(what.projection) * view);
    set_uniform(program, "u_clip_before",
                glm::make_mat4(what.previous_projection) * glm::make_mat4(what.previous_view));
    if (counts_fragments_) { glDisable(GL_DEPTH_TEST); }
    counts_.draw_calls += model_.draw(program, method_.cached, what.instances, what.back_faces);
}

void Contender::build(int frame) {
    constexpr Motion kMotion{0.045f, 0.34f, false};
    const dgb_params params = dgb_preset(DGB_PRESET_BALANCED);
    frame_ = frame;
    const RenderCamera camera = moved(view_.camera, kMotion, frame);
    library_.build(
        to_dgb_view(view_matrix(camera), projection_matrix(camera, kAspect, ClipRange::standard)), params,
        [](void* self, const dgb_draw* what) { static_cast<Contender*>(self)->draw(*what); }, this);
}

void Contender::measure(int frame) {
    glFinish();
    const double start = wall_ms(), cpu_start = process_ms();
    build(frame);
    glFinish();
    times_.cpu.push_back(process_ms() - cpu_start);
    times_.wall.push_back(wall_ms() - start);
}

// One frame more, not measured.
Counts Contender::count(int frame) {
    const GLenum targets[] = {GL_VERTEX_SHADER_INVOCATIONS, GL_SAMPLES_PASSED};
    GLuint queries[2];
    counts_ = {};
    glGenQueries(2, queries);
    for (int i = 0; i < 2; ++i) { glBeginQuery(targets[i], queries[i]); }
    counts_fragments_ = method_.one_layer;
    build(frame);
    counts_fragments_ = false;
    for (GLenum target : targets) { glEndQuery(target); }
    glGetQueryObjectui64v(queries[0], GL_QUERY_RESULT, &counts_.vertices);
    glGetQueryObjectui64v(queries[1], GL_QUERY_RESULT, &counts_.fragments);
    glDeleteQueries(2, queries);
    return counts_;
}

// ---- Results --------------------------------------------------------------------------------------------

struct Row {
    std::string name;
    double wall, cpu; // ratios to one layer
    double share;     // what the deeper layers cost, as a share of what they cost when peeled
    Counts counts;
};

// (over - base) / (under - base), frame by frame.
double median_share(const std::vector<double>& over, const std::vector<double>& under,
                    const std::vector<double>& base) {
    std::vector<double> extra, peel_extra;
    for (size_t i = 0; i < base.size(); ++i) {
        extra.push_back(over[i] - base[i]);
        peel_extra.push_back(under[i] - base[i]);
    }
    return median_ratio(extra, peel_extra);
}

using Contenders = std::vector<std::unique_ptr<Contender>>;

std::vector<Row> make_rows(const Contenders& contenders, int frame) {
    const Times &one = contenders[kOneLayer]->times(), &peel = contenders[kPeel]->times();
    std::vector<Row> rows;
    for (const auto& contender : contenders) {
        const Times& times = contender->times();
        rows.push_back({contender->method().name, median_ratio(times.wall, one.wall), median_ratio(times.cpu, one.cpu),
                        median_share(times.deciding(), peel.deciding(), one.deciding()), contender->count(frame)});
    }
    return rows;
}

void print_rows(const View& view, const Model& model, const Config& config, const Times& one,
                const std::vector<Row>& rows) {
    std::printf("\n%s: %lld triangles, %d meshes, depth complexity %.1f, %s vertices, %d layers, 1/%d resolution; "
                "one layer %.1f ms (process %.1f)\n",
                view.name.c_str(), static_cast<long long>(model.triangles()), model.meshes(),
                double(rows[kOneLayer].counts.fragments) / (kWidth * kHeight), config.expensive ? "skinned" : "plain",
                config.layers, config.divisor, median(one.wall), median(one.cpu));
    std::printf("    %-22s %8s %8s %12s %12s %12s\n", "", "x wall", "x cpu", "deeper/peel", "draw calls", "x vertices");
    for (const Row& row : rows) {
        std::printf("    %-22s %8.2f %8.2f %12.2f %12d %12.2f\n", row.name.c_str(), row.wall, row.cpu, row.share,
                    row.counts.draw_calls, double(row.counts.vertices) / double(rows[kOneLayer].counts.vertices));
    }
}

void write_rows(std::FILE* csv, const View& view, const Model& model, const Config& config,
                const std::vector<Row>& rows) {
    for (const Row& row : rows) {
        std::fprintf(csv, "%s,%lld,%.2f,%s,%d,%d,\"%s\",%.3f,%.3f,%.3f,%d,%llu\n", view.name.c_str(),
                     static_cast<long long>(model.triangles()),
                     double(rows[kOneLayer].counts.fragments) / (kWidth * kHeight),
                     config.expensive ? "skinned" : "plain", config.layers, config.divisor, row.name.c_str(), row.wall,
                     row.cpu, row.share, row.counts.draw_calls, static_cast<unsigned long long>(row.counts.vertices));
    }
    std::fflush(csv);
}

void print_goal(const std::vector<Row>& rows, double goal) {
    for (const Row& row : rows) {
        if (row.name != "image") { continue; }
        std::printf("    goal: image stores bring the second layer to %.2f of peel's: %.2f, %s\n", goal, row.share,
                    row.share <= goal ? "hit" : "missed");
    }
}

// ---- Runs -----------------------------------------------------------------------------------------------

// Emissions that this driver lacks, or that take no lower resolution, are left out.
bool is_offered(const Method& method, const Config& config) {
    if (method.cached && !config.expensive) { return false; }
    if (method.one_layer) { return true; }
    try {
        const Library trial(describe(method, config));
        return true;
    } catch (const std::runtime_error&) { return false; }
}

// goal: of image stores, 0 for none.
void run(const View& view, const Model& model, const Config& config, double goal, std::FILE* csv) {
    constexpr int kWarmUp = 2;
    Contenders contenders;
    for (const Method& method : kMethods) {
        if (!is_offered(method, config)) { continue; }
        contenders.push_back(std::make_unique<Contender>(method, config, view, model));
    }
    for (int frame = 0; frame < kWarmUp + config.frames; ++frame) {
        for (size_t turn = 0; turn < contenders.size(); ++turn) { // each frame begins with another contender
            Contender& contender = *contenders[(turn + size_t(frame)) % contenders.size()];
            frame < kWarmUp ? contender.build(frame) : contender.measure(frame);
        }
    }
    const std::vector<Row> rows = make_rows(contenders, kWarmUp + config.frames);
    print_rows(view, model, config, contenders[kOneLayer]->times(), rows);
    if (goal > 0.0) { print_goal(rows, goal); }
    std::fflush(stdout);
    write_rows(csv, view, model, config, rows);
}

struct ColonnadeRun {
    int triangles;
    Config config;
    bool quick; // also in a quick run
};

std::vector<ColonnadeRun> colonnade_runs(bool quick) {
    const int few = quick ? 3 : 15, many = quick ? 7 : 25;
    std::vector<ColonnadeRun> runs;
    for (int triangles : {10000, 100000, 850000}) {
        const int frames = triangles > 500000 ? few : many;
        for (bool expensive : {false, true}) {
            for (int divisor : {1, 2, 4}) {
                const bool first = divisor == 1 && (!expensive || triangles == 850000);
                runs.push_back({triangles, {expensive, 2, divisor, frames}, first});
            }
        }
        for (int layers : {3, 4, 8}) {
            if (triangles != 850000) {
                runs.push_back({triangles, {false, layers, 1, few}, layers == 4 && triangles == 10000});
            }
        }
    }
    if (quick) {
        runs.erase(std::remove_if(runs.begin(), runs.end(), [](const ColonnadeRun& r) { return !r.quick; }),
                   runs.end());
    }
    return runs;
}

// Only where the second layer has full resolution, as the goals were set.
double image_goal(const ColonnadeRun& run) {
    if (run.config.layers != 2 || run.config.divisor != 1) { return 0.0; }
    return run.triangles == 10000 ? 0.75 : run.triangles == 850000 ? 0.35 : 0.0;
}

void run_colonnades(bool quick, std::FILE* csv) {
    std::unique_ptr<View> view;
    std::unique_ptr<Model> model;
    int triangles = 0;
    for (const ColonnadeRun& r : colonnade_runs(quick)) {
        if (r.triangles != triangles) {
            triangles = r.triangles;
            view = std::make_unique<View>(make_colonnade(triangles));
            model = std::make_unique<Model>(view->scene);
        }
        run(*view, *model, r.config, image_goal(r), csv);
    }
}

void run_scene(const std::string& argument, bool quick, std::FILE* csv) {
    const View view = load_view(argument);
    const Model model(view.scene);
    run(view, model, {false, 2, 1, quick ? 3 : 15}, 0.0, csv);
    if (quick) { return; }
    run(view, model, {true, 2, 1, 15}, 0.0, csv);
    run(view, model, {false, 2, 2, 15}, 0.0, csv);
}

void run(const Options& options) {
    const File csv = result_file("construction.csv");
    std::fprintf(csv.get(), "scene,triangles,depth_complexity,vertices,layers,divisor,method,wall,cpu,deeper_over_peel,"
                            "draw_calls,vertex_invocations\n");
    std::printf(
        "x: median ratio to one layer (with its own vertex stage); deeper/peel by %s time; a skin cache's compute "
        "invocations, one a vertex, are not in \"x vertices\"\n",
        is_software_rasteriser() ? "process" : "wall");
    run_colonnades(options.quick, csv.get());
    for (const std::string& scene : options.scenes) { run_scene(scene, options.quick, csv.get()); }
}

} // namespace

int main(int argc, char** argv) { return run_benchmark("construction", argc, argv, run); }
