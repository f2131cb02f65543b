// A scene in OpenGL 3.3: buffers, textures, and a list of draws.
#pragma once

#include "scene.hpp"

#include <epoxy/gl.h>

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

// Owns one OpenGL object. Its context must be current when it dies.
class GlObject {
public:
    using Destroy = void (*)(GLuint name);

    GlObject() = default;
    GlObject(GLuint name, Destroy destroy) : name_(name), destroy_(destroy) {}
    GlObject(GlObject&& other) noexcept : name_(std::exchange(other.name_, 0)), destroy_(other.destroy_) {}
    GlObject& operator=(GlObject&& other) noexcept {
        std::swap(name_, other.name_);
        std::swap(destroy_, other.destroy_);
        return *this;
    }
    GlObject(const GlObject&) = delete;
    GlObject& operator=(const GlObject&) = delete;
    ~GlObject() {
        if (name_ != 0) { destroy_(name_); }
    }

    GLuint name() const { return name_; }

private:
    GLuint name_ = 0;
    Destroy destroy_ = nullptr;
};

GlObject make_texture();
GlObject make_buffer(GLenum target, size_t size, const void* data); // stays bound
GlObject make_framebuffer();
GlObject make_vertex_array();

// Compiles and links; an empty geometry shader is left out. Throws std::runtime_error with the compiler's
// message.
GlObject make_program(const std::string& what, const std::string& vertex, const std::string& geometry,
                      const std::string& fragment);

// A program that draws the scene and keeps nothing but depth: of GpuScene's vertex text, with a uniform mat4 u_clip from
// world space.
GlObject make_depth_program(const std::string& what, const std::string& scene_vertex);

// A program for one triangle that covers the viewport. The fragment shader comes without its #version line.
GlObject make_fullscreen_program(const std::string& what, const std::string& fragment);

// The program must be in use. Names that the compiler removed are ignored.
void set_uniform(GLuint program, const char* name, int value);
void set_uniform(GLuint program, const char* name, float value);
void set_uniform(GLuint program, const char* name, glm::vec3 value);
void set_uniform(GLuint program, const char* name, glm::vec4 value);
void set_uniform(GLuint program, const char* name, const glm::mat4& value);
void set_uniform(GLuint program, const char* name, const std::vector<glm::vec3>& values);

// Sets the sampler's unit and binds the texture there. The current program must hold the sampler.
void bind_texture(GLuint program, const char* name, int unit, GLenum target, GLuint texture);

struct DrawCounts {
    int64_t draw_calls = 0;
    int64_t triangles = 0; // handed to OpenGL, once an instance
};

// The material's factors and textures, for the start of every fragment shader that draws the scene.
extern const char* const kSceneMaterial;

// A pose that can be drawn.
class GpuPose {
public:
    explicit GpuPose(Pose matrices);

    const Pose& matrices() const { return matrices_; }
    void bind_joints(int unit) const; // a buffer texture, 4 texels a matrix

private:
    Pose matrices_;
    GlObject joints_, texture_; // none without joints
};

class GpuScene {
public:
    explicit GpuScene(const Scene& scene);

    // The pose that the scene had when it was uploaded.
    std::shared_ptr<const GpuPose> first_pose() const { return first_pose_; }

    // For the start of every vertex shader that draws the scene: attributes a_*, and what moves them,
    //     mat4 to_world(); mat4 to_world_before(); mat3 normal_to_world(); float handedness()
    // of which the last is -1 where the vertex is mirrored.
    std::string vertex_text() const;

    enum class Sides { as_material, both, back }; // back: what single-sided materials do not show

    // Draws all opaque and alpha-masked meshes with a program made of the texts above. `before` is where they were a
    // frame ago. Leaves face culling and the front face as the last mesh needed them.
    DrawCounts draw(GLuint program, const GpuPose& pose, const GpuPose& before, int instances, Sides sides) const;

private:
    struct GpuMaterial {
        std::array<glm::vec4, 3> factors; // layout in kSceneMaterial
        std::array<GLuint, 4> textures;   // base color, metallic-roughness, normal, emissive
        bool double_sided;
    };
    struct Draw {
        int material;
        int node;
        int first_joint; // -1: the node places the mesh
        GLsizei index_count;
        size_t first_index;
        GLint first_vertex;
    };
    struct Places; // of uniforms

    void upload_geometry(const Scene& scene);
    void upload_materials(const Scene& scene);
    void list_draws(const Scene& scene);
    static void set_material(GLuint program, const GpuMaterial& material, Sides sides);
    static void place(const Draw& draw, const Pose& pose, const Pose& before, const Places& places);

    GlObject vertex_array_, vertices_, indices_;
    std::vector<GlObject> textures_;
    std::vector<GpuMaterial> materials_;
    std::vector<Draw> draws_;
    bool has_skins_ = false;
    std::shared_ptr<const GpuPose> first_pose_;
};
