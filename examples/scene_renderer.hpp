// Draws a scene with deepgbuffer, the way an engine would: layers, direct light in every layer, occlusion and
// bounced light, composite. One context, one image size.
#pragma once

#include "scene_gpu.hpp"
#include "scene_lights.hpp"
#include "scene_probe.hpp"

#include "deepgbuffer.h"
#include "deepgbuffer_gl.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

struct PassTime {
    std::string name;
    std::vector<double> cpu_ms; // one a frame
    std::vector<double> gpu_ms; // empty where the GPU's clock cannot be read
};

// A stopwatch for passes that follow one another.
class PassTimes {
public:
    // wait: times the work itself, until the GPU is idle; else only its submission.
    explicit PassTimes(bool wait) : wait_(wait) {}

    void begin();
    void end(const char* name);
    void add_gpu(const char* name, double milliseconds) { pass(name).gpu_ms.push_back(milliseconds); }
    const std::vector<PassTime>& passes() const { return passes_; }

private:
    PassTime& pass(const char* name);

    bool wait_;
    std::chrono::steady_clock::time_point start_;
    std::vector<PassTime> passes_;
};

struct RendererDesc { // what the pointers point to must outlive the renderer
    dgbgl_get_proc_fn get_proc = nullptr;
    dgb_desc layers{}; // without backend and log
    const GpuScene* scene = nullptr;
    const SceneLights* lights = nullptr; // null: none
    Sky sky;                             // what is seen where there is no surface,
    Probe probe{};                       // and what a surface gets from where none is known
    std::optional<float> roughness;      // of every surface; none: as the materials say
    PassTimes* times = nullptr;
};

struct SceneFrame {
    glm::mat4 view{1.0f}, projection{1.0f};         // the projection is that of the image without guard band
    std::optional<glm::mat4> next_view;             // of the next frame, where it is known
    std::shared_ptr<const GpuPose> pose, next_pose; // none: that of the scene; none: the same as `pose`
};

class SceneRenderer {
public:
    // Throws std::runtime_error when the device cannot do what desc asks for.
    explicit SceneRenderer(const RendererDesc& desc);
    SceneRenderer(const SceneRenderer&) = delete;
    SceneRenderer& operator=(const SceneRenderer&) = delete;

    // One frame, in two halves. The lights must be where the pose drawn has them by the time of the second.
    void build(const SceneFrame& frame, const dgb_params& params);
    void shade(const dgb_params& params);
    // Both, for a scene in which nothing moves.
    void render(const glm::mat4& view, const glm::mat4& projection, const dgb_params& params);

    // The layers of the last frame once more, lit as they are, without pictures. For the library it is one frame more, in
    // which nothing moved.
    void shade_again(const dgb_params& params);
    // Pictures of the last frame with light from this share of the hemisphere everywhere; none: by each pixel's confidence, as
    // every frame has them.
    void composite(std::optional<float> covered = std::nullopt);

    // What the layers show: the pose of the frame, but for DGB_ORACLE_DELAY, which shows the one before.
    const GpuPose& drawn_pose() const { return *drawn_; }

    const dgb_plan& plan() const { return library_.context.plan; }
    const dgb_desc& layers() const { return desc_.layers; } // as the renderer was asked for them

    // Pixels of the image. The next frame has no past. Throws std::runtime_error, and then goes on with the old size, when the
    // device has no room.
    void resize(int width, int height);
    // What is seen where there is no surface, and what a surface gets from where none is known, from the next frame on.
    void set_surroundings(const Sky& sky, const Probe& probe);

    // What it took to build the last frame's layers.
    DrawCounts draw_counts() const { return draw_counts_; }
    std::optional<uint64_t> vertices_shaded() const; // none where the driver does not count

    // All pictures are of the last frame, without guard band, bottom row first.
    enum class Picture { final, direct, indirect }; // linear RGB; direct holds emission and the sky's pixels
    std::vector<float> read_picture(Picture picture) const;
    // The same for a shader: the picture; a texture of the library, guard band included. The next frame or its shading may
    // take another texture.
    GLuint picture(Picture picture) const { return pictures_[int(picture)].name(); }
    GLuint texture(dgb_slot slot) const;
    bool has(dgb_slot slot) const { return dgb_get_texture(&library_.context, slot).id != 0; }
    int divisor(int layer) const { return layer > 0 ? std::max(desc_.layers.divisor, 1) : 1; } // of its resolution
    // Into the framebuffer that is bound; false where the renderer does not have it.
    bool draw_view(const dgbgl_view_desc& view) const { return dgbgl_draw_view(&library_.context, &view) == DGB_OK; }

    // format: GL_RED, GL_RGB or GL_RGBA. layer is 0 for textures without layers. A layer of lower resolution is enlarged.
    std::vector<float> read_texture(dgb_slot slot, int layer, GLenum format) const;
    // Camera z in metres, 0 where empty: what the shading read, strict separation included.
    std::vector<float> read_z(int layer) const;
    // Camera-space unit normals, 0 where empty.
    std::vector<float> read_normals(int layer) const;

private:
    // Wraps the backend's marker with a stopwatch.
    struct TimedBackend {
        dgbgl_backend gl; // first: the callbacks get its address
        void (*gl_marker)(void* user, dgb_pass_id pass, bool begin);
        PassTimes* times;
    };
    struct Library {
        TimedBackend backend{};
        dgb_context context{};
        std::string complaint; // the last failure

        Library() = default;
        Library(const Library&) = delete;
        Library& operator=(const Library&) = delete;
        ~Library();
    };

    static void mark(void* user, dgb_pass_id pass, bool begin);
    void init_library();
    void make_programs();
    void make_targets();
    GlObject make_layers_program(const char* what, const char* fragment) const;
    std::shared_ptr<const GpuPose> pose_to_draw(int pose) const;
    void draw_layers(const dgb_draw& draw);
    void light_layers();
    void copy_emission();
    void collect_gpu_times();
    glm::mat4 world_from_buffer() const;
    glm::mat4 rays_from_buffer() const;
    glm::mat4 from_buffer(const glm::mat4& view) const;
    float empty_depth() const { return desc_.layers.reversed ? 0.0f : 1.0f; }
    std::vector<float> read_linear_depth(int layer) const;
    std::vector<float> read_pixels(GLenum attachment, GLenum format, int first, int divisor) const;

    RendererDesc desc_;
    Library library_;

    GlObject material_program_, depth_program_; // the second keeps no color
    GlObject light_program_, composite_program_;
    GlObject no_vertices_;                     // full-screen passes need a vertex array, an empty one
    GlObject direct_;                          // emission + direct light of layer 0, guard band included
    std::vector<GlObject> light_framebuffers_; // one a layer
    GlObject pictures_[3], picture_framebuffer_, read_framebuffer_;
    GlObject vertex_query_; // none where the driver lacks pipeline statistics

    glm::mat4 view_{1.0f}, projection_{1.0f};       // of what was drawn last; the projection with guard band
    std::shared_ptr<const GpuPose> drawn_, before_; // what was drawn last, and the time before
    std::shared_ptr<const GpuPose> earlier_, submitted_, next_; // of the frame before, of this one, of the next
    dgb_params params_{};
    DrawCounts draw_counts_;
};
