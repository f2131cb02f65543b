#include "scene_renderer.hpp"

#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace {

using glm::mat4;
using glm::vec3;

// ---- Shaders --------------------------------------------------------------------------------------------

// From the material's vertex to its fragment shader.
const dgbgl_varying kVaryings[] = {{nullptr, "vec3", "v_normal"},
                                   {nullptr, "vec4", "v_tangent"},
                                   {nullptr, "vec2", "v_uv"},
                                   {nullptr, "vec4", "v_color"}};
constexpr int kVaryingCount = 4;

const char* const kMaterialVertex = R"(
uniform mat4 u_view;
uniform mat4 u_clip;          // from world
uniform mat4 u_previous_clip; // the same, one frame ago

out vec3 v_normal;  // camera space
out vec4 v_tangent; // camera space
out vec2 v_uv;
out vec4 v_color;

void main() {
    mat4 world = to_world();
    v_normal = mat3(u_view) * (normal_to_world() * a_normal);
    v_tangent = vec4(mat3(u_view) * (mat3(world) * a_tangent.xyz), a_tangent.w * handedness());
    v_uv = a_uv;
    v_color = a_color;
    vec4 position = vec4(a_position, 1.0);
    dgb_vertex(u_clip * (world * position), u_previous_clip * (to_world_before() * position));
}
)";

// For passes that keep no color.
const char* const kDepthFragment = R"(
in vec2 v_uv;
in vec4 v_color;

void main() {
    if (is_cut_out(base_color(v_uv, v_color))) discard;
    if (!dgb_keep()) discard;
}
)";

const char* const kMaterialFragment = R"(
in vec3 v_normal;
in vec4 v_tangent;
in vec2 v_uv;
in vec4 v_color;

uniform float u_roughness; // of everything; negative: as the materials say

vec3 mapped_normal() {
    vec3 n = normalize(v_normal);
    vec3 t = v_tangent.xyz - n * dot(n, v_tangent.xyz);
    vec3 b = cross(n, t) * v_tangent.w;
    vec3 m = texture(u_normal, v_uv).xyz * 2.0 - 1.0;
    float to_unit = inversesqrt(max(dot(t, t), 1e-20));
    vec3 mapped = (t * m.x + b * m.y) * to_unit * u_factors[2].z + n * m.z;
    return gl_FrontFacing ? mapped : -mapped; // only double-sided materials show their back
}

void main() {
    vec4 base = base_color(v_uv, v_color);
    vec2 metallic_roughness = u_factors[2].xy * texture(u_metallic_roughness, v_uv).bg;
    if (u_roughness >= 0.0) metallic_roughness.y = u_roughness;
    vec3 emission = u_factors[1].rgb * texture(u_emissive, v_uv).rgb;
    vec3 normal = mapped_normal();
    // not before: a texture read behind a discard has no defined level of detail
    if (is_cut_out(base)) discard;
    if (!dgb_keep()) discard;

    bool unlit = u_factors[2].w > 0.0;
    vec3 albedo = base.rgb * (1.0 - metallic_roughness.x);
    dgb_store(vec4(albedo, unlit ? 0.0 : 1.0), normal, metallic_roughness.yx, unlit ? base.rgb : emission);
}
)";

// Before those that read a layer.
const char* const kDecodeNormal = R"(
// What dgb_oct16_decode does.
vec3 decode_normal(vec2 bytes) {
    vec2 p = (min(floor(bytes * 255.0 + 0.5), 254.0) - 127.0) / 127.0;
    float z = 1.0 - abs(p.x) - abs(p.y);
    vec2 folded = (1.0 - abs(p.yx)) * vec2(p.x < 0.0 ? -1.0 : 1.0, p.y < 0.0 ? -1.0 : 1.0);
    return normalize(vec3(z < 0.0 ? folded : p, z));
}
)";

// Behind kDecodeNormal and kDirectLight. Adds the light of all lights to a layer. The same value goes to a target of full
// precision in layer 0.
const char* const kLightFragment = R"(
const float PI = 3.14159265358979;
const float BRIGHTEST = 32768.0; // W/m2/sr: twice that does not fit into a layer

uniform sampler2DArray u_depth;
uniform sampler2DArray u_albedo;
uniform sampler2DArray u_normal;
uniform int u_layer;
uniform float u_divisor; // of the layer's resolution
uniform float u_empty_depth;
uniform mat4 u_view;
uniform mat4 u_world_from_buffer; // pixel, depth

layout(location = 0) out vec4 out_layer;
layout(location = 1) out vec4 out_direct;

void main() {
    ivec3 at = ivec3(gl_FragCoord.xy, u_layer);
    float depth = texelFetch(u_depth, at, 0).r;
    vec4 albedo = texelFetch(u_albedo, at, 0); // a: 0 unlit, 1 lit
    if (depth == u_empty_depth || albedo.a == 0.0) discard;
    vec3 normal = transpose(mat3(u_view)) * decode_normal(texelFetch(u_normal, at, 0).rg);
    vec4 world = u_world_from_buffer * vec4(gl_FragCoord.xy * u_divisor, depth, 1.0);
    vec3 radiance = albedo.rgb / PI * direct_irradiance(world.xyz / world.w, normal);
    out_layer = vec4(min(radiance, BRIGHTEST), 0.0);
    out_direct = out_layer;
}
)";

// Behind kDecodeNormal.
const char* const kCompositeFragment = R"(
const float PI = 3.14159265358979;

uniform sampler2DArray u_depth;
uniform sampler2DArray u_albedo;
uniform sampler2DArray u_normal;
uniform sampler2D u_direct;
uniform sampler2D u_ao;
uniform sampler2D u_irradiance;
uniform sampler2D u_reflection;
uniform sampler2D u_bent;
uniform int u_has_ao;
uniform int u_has_bent;
uniform int u_has_irradiance;
uniform int u_has_reflection; // 1: of mirrors only; 2: of rough surfaces as well
uniform float u_covered; // share of the hemisphere; negative: by the confidence of the irradiance
uniform int u_guard;        // pixels
uniform float u_empty_depth;
uniform mat4 u_view;
uniform mat4 u_rays_from_buffer;  // pixel, depth
uniform vec3 u_sky[3];            // zenith, horizon, ground
uniform vec3 u_probe[9];          // irradiance by normal, over pi

layout(location = 0) out vec4 out_final;
layout(location = 1) out vec4 out_direct;
layout(location = 2) out vec4 out_indirect;

// Of the ray through a pixel, from one point on it to the other: the farther may be at infinity, where w is 0.
vec3 ray_direction(vec2 pixel) {
    vec4 a = u_rays_from_buffer * vec4(pixel, 1.0 - u_empty_depth, 1.0);
    vec4 b = u_rays_from_buffer * vec4(pixel, u_empty_depth, 1.0);
    return normalize(b.xyz * a.w - a.xyz * b.w);
}

// Written so that a uniform sky is exactly that.
vec3 sky_radiance(vec3 direction) {
    return direction.y < 0.0 ? u_sky[2] : u_sky[1] + (u_sky[0] - u_sky[1]) * direction.y;
}

vec3 probe_radiance(vec3 n) {
    vec3 sum = u_probe[0] + u_probe[1] * n.y + u_probe[2] * n.z + u_probe[3] * n.x + u_probe[4] * (n.x * n.y) +
               u_probe[5] * (n.y * n.z) + u_probe[6] * (3.0 * n.y * n.y - 1.0) + u_probe[7] * (n.x * n.z) +
               u_probe[8] * (n.z * n.z - n.x * n.x);
    return max(sum, 0.0); // a cut series undershoots
}

// What a surface makes of a lobe's average radiance (split sum): the fit of Karis (2014), with the reflectance of metals, whose
// base color no layer keeps, that of a bright grey one.
float environment_brdf(float roughness, float metallic, float cosine) {
    float smoothness = 1.0 - roughness;
    float grazing = smoothness * min(smoothness * smoothness, exp2(-9.28 * cosine)) + 0.0425 - 0.0275 * roughness;
    vec2 scale_bias = vec2(1.04 - 0.572 * roughness, 0.022 * roughness - 0.04) + vec2(-1.04, 1.04) * grazing;
    return mix(0.04, 0.9, metallic) * scale_bias.x + scale_bias.y;
}

const float ROUGHEST_MIRROR = 0.3; // on which a mirror's sharp image fades out

// material: roughness, metallic. Where no ray of the lobe hit anything, the sky, blurred to its irradiance.
vec3 mirrored(vec3 normal, vec3 view, vec2 material, float visibility, vec4 reflection) {
    vec3 l = reflect(view, normal);
    vec3 environment = visibility * mix(sky_radiance(l), probe_radiance(l), material.x);
    float cosine = clamp(-dot(view, normal), 0.0, 1.0);
    float sharp = u_has_reflection == 1 ? max(1.0 - material.x / ROUGHEST_MIRROR, 0.0) : 1.0;
    return sharp * environment_brdf(material.x, material.y, cosine) * dgb_mirror(environment, reflection);
}

void main() {
    ivec2 p = ivec2(gl_FragCoord.xy) + u_guard;
    bool empty = texelFetch(u_depth, ivec3(p, 0), 0).r == u_empty_depth;
    vec4 albedo = texelFetch(u_albedo, ivec3(p, 0), 0); // a: 0 unlit, 1 lit
    float visibility = u_has_ao != 0 ? texelFetch(u_ao, p, 0).r : 1.0;
    vec4 irradiance = u_has_irradiance != 0 ? texelFetch(u_irradiance, p, 0) : vec4(0.0); // a: confidence
    vec4 surface = texelFetch(u_normal, ivec3(p, 0), 0);
    vec3 normal = transpose(mat3(u_view)) * decode_normal(surface.rg);
    float confidence = u_covered < 0.0 ? irradiance.a : 0.5 * u_covered; // which dgb_fallback doubles
    vec3 open = u_has_bent != 0 ? dgb_bent_direction(texelFetch(u_bent, p, 0), normal) : normal;
    vec3 ambient = dgb_fallback(PI * probe_radiance(open), visibility, vec4(irradiance.rgb, confidence));

    vec3 view = ray_direction(gl_FragCoord.xy + float(u_guard)), sky = sky_radiance(view);
    vec3 direct = empty ? sky : texelFetch(u_direct, p, 0).rgb;
    vec3 indirect = empty ? vec3(0.0) : albedo.rgb * albedo.a / PI * ambient;
    if (u_has_reflection != 0 && !empty)
        indirect += albedo.a * mirrored(normal, view, surface.ba, visibility, texelFetch(u_reflection, p, 0));
    out_final = vec4(direct + indirect, 1.0);
    out_direct = vec4(direct, 1.0);
    out_indirect = vec4(indirect, 1.0);
}
)";

// ---- Helpers --------------------------------------------------------------------------------------------

// Calls a function that writes text as snprintf does: once for the length, once for the text.
template <typename Write>
std::string text_of(Write write) {
    std::string text(write(nullptr, size_t{0}), '\0');
    write(text.data(), text.size() + 1);
    return text;
}

GlObject make_target(GLint format, int width, int height) {
    GlObject texture = make_texture();
    glBindTexture(GL_TEXTURE_2D, texture.name());
    glTexImage2D(GL_TEXTURE_2D, 0, format, width, height, 0, GL_RGBA, GL_FLOAT, nullptr);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    return texture;
}

void check_framebuffer(const char* what) {
    if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
        throw std::runtime_error(std::string("the driver cannot draw into the ") + what + " target");
    }
}

void bind_layer(GLuint program, const char* name, int unit, GLuint texture) {
    bind_texture(program, name, unit, GL_TEXTURE_2D_ARRAY, texture);
}

void draw_fullscreen() { glDrawArrays(GL_TRIANGLES, 0, 3); }

int channel_count(GLenum format) {
    switch (format) {
    case GL_RG: return 2;
    case GL_RGB: return 3;
    case GL_RGBA: return 4;
    default: return 1;
    }
}

mat4 to_mat4(const float matrix[16]) { return glm::make_mat4(matrix); }

} // namespace

// ---- Times ----------------------------------------------------------------------------------------------

void PassTimes::begin() {
    if (wait_) { glFinish(); }
    start_ = std::chrono::steady_clock::now();
}

void PassTimes::end(const char* name) {
    if (wait_) { glFinish(); }
    const std::chrono::duration<double, std::milli> elapsed = std::chrono::steady_clock::now() - start_;
    pass(name).cpu_ms.push_back(elapsed.count());
}

PassTime& PassTimes::pass(const char* name) {
    const auto found = std::find_if(passes_.begin(), passes_.end(), [&](const PassTime& p) { return p.name == name; });
    return found != passes_.end() ? *found : passes_.emplace_back(PassTime{name, {}, {}});
}

// ---- Start ----------------------------------------------------------------------------------------------

SceneRenderer::Library::~Library() {
    dgb_shutdown(&context);
    dgbgl_shutdown(&backend.gl);
}

SceneRenderer::SceneRenderer(const RendererDesc& desc) : desc_(desc) {
    init_library();
    make_programs();
    make_targets();
    if (epoxy_gl_version() >= 46 || epoxy_has_gl_extension("GL_ARB_pipeline_statistics_query")) {
        GLuint query = 0;
        glGenQueries(1, &query);
        vertex_query_ = GlObject(query, [](GLuint name) { glDeleteQueries(1, &name); });
    }
}

// The library's marker callback: user is the backend, which is the first member of ours.
void SceneRenderer::mark(void* user, dgb_pass_id pass, bool begin) {
    const auto* backend = static_cast<const TimedBackend*>(user);
    if (begin) {
        backend->gl_marker(user, pass, begin);
        backend->times->begin();
    } else {
        backend->times->end(dgb_pass_name(pass));
        backend->gl_marker(user, pass, begin);
    }
}

void SceneRenderer::init_library() {
    TimedBackend& backend = library_.backend;
    dgbgl_desc gl_desc{};
    gl_desc.get_proc = desc_.get_proc;
    gl_desc.message = [](void* user, const char* text) { static_cast<std::string*>(user)->append(text); };
    gl_desc.message_user = &library_.complaint;
    if (dgbgl_init(&backend.gl, &gl_desc) != DGB_OK) {
        throw std::runtime_error("the OpenGL driver lacks what deepgbuffer needs: " + library_.complaint);
    }
    backend.times = desc_.times;
    backend.gl_marker = std::exchange(backend.gl.backend.marker, mark);

    dgb_desc layers = desc_.layers;
    layers.backend = &backend.gl.backend;
    layers.log = [](void* user, dgb_result, dgb_log_item, const char* sentence) {
        static_cast<std::string*>(user)->append(sentence);
    };
    layers.log_user = &library_.complaint;
    if (dgb_init(&library_.context, &layers) != DGB_OK) { throw std::runtime_error(library_.complaint); }
}

GlObject SceneRenderer::make_layers_program(const char* what, const char* fragment) const {
    const dgb_context* context = &library_.context;
    const auto prefix = [&](dgbgl_stage stage) {
        return text_of([&](char* text, size_t size) {
            return dgbgl_shader_prefix(context, stage, kVaryings, kVaryingCount, text, size);
        });
    };
    const std::string geometry = text_of(
        [&](char* text, size_t size) { return dgbgl_geometry_shader(context, kVaryings, kVaryingCount, text, size); });
    GlObject program = make_program(what, prefix(DGBGL_VERTEX) + desc_.scene->vertex_text() + kMaterialVertex, geometry,
                                    prefix(DGBGL_FRAGMENT) + kSceneMaterial + fragment);
    if (dgbgl_attach_program(context, program.name()) != DGB_OK) {
        throw std::runtime_error(std::string("the ") + what + " program lacks the library's text");
    }
    return program;
}

void SceneRenderer::make_programs() {
    material_program_ = make_layers_program("material", kMaterialFragment);
    if (has(DGB_PREDICTED) || has(DGB_BACK)) { depth_program_ = make_layers_program("depth", kDepthFragment); }
    light_program_ = make_fullscreen_program("light", std::string(kDecodeNormal) + kDirectLight + kLightFragment);
    const std::string fallback = text_of(dgbgl_composite_snippet);
    composite_program_ = make_fullscreen_program("composite", fallback + kDecodeNormal + kCompositeFragment);
}

void SceneRenderer::make_targets() {
    const GLenum buffers[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1, GL_COLOR_ATTACHMENT2};
    no_vertices_ = make_vertex_array();
    read_framebuffer_ = make_framebuffer();

    direct_ = make_target(GL_RGBA16F, plan().width, plan().height);
    light_framebuffers_.clear();
    for (int layer = 0; layer < plan().layers; ++layer) {
        const GLuint framebuffer = light_framebuffers_.emplace_back(make_framebuffer()).name();
        glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
        glFramebufferTextureLayer(GL_FRAMEBUFFER, buffers[0], texture(DGB_RADIANCE), 0, layer);
        if (layer == 0) { glFramebufferTexture2D(GL_FRAMEBUFFER, buffers[1], GL_TEXTURE_2D, direct_.name(), 0); }
        check_framebuffer("light");
    }

    picture_framebuffer_ = make_framebuffer();
    glBindFramebuffer(GL_FRAMEBUFFER, picture_framebuffer_.name());
    for (size_t i = 0; i < 3; ++i) {
        pictures_[i] = make_target(GL_RGBA32F, desc_.layers.width, desc_.layers.height);
        glFramebufferTexture2D(GL_FRAMEBUFFER, buffers[i], GL_TEXTURE_2D, pictures_[i].name(), 0);
    }
    glDrawBuffers(3, buffers);
    check_framebuffer("composite");
}

void SceneRenderer::resize(int width, int height) {
    if (width == desc_.layers.width && height == desc_.layers.height) { return; }
    library_.complaint.clear();
    if (dgb_resize(&library_.context, width, height) != DGB_OK) { throw std::runtime_error(library_.complaint); }
    desc_.layers.width = width;
    desc_.layers.height = height;
    make_targets();
}

void SceneRenderer::set_surroundings(const Sky& sky, const Probe& probe) {
    desc_.sky = sky;
    desc_.probe = probe;
}

GLuint SceneRenderer::texture(dgb_slot slot) const {
    return dgbgl_texture_name(dgb_get_texture(&library_.context, slot));
}

// ---- A frame --------------------------------------------------------------------------------------------

void SceneRenderer::build(const SceneFrame& frame, const dgb_params& params) {
    dgb_view camera{};
    std::copy_n(glm::value_ptr(frame.view), 16, camera.view);
    std::copy_n(glm::value_ptr(frame.projection), 16, camera.projection);
    camera.has_next = frame.next_view.has_value();
    if (frame.next_view) { std::copy_n(glm::value_ptr(*frame.next_view), 16, camera.next_view); }
    const auto draw = [](void* user, const dgb_draw* what) { static_cast<SceneRenderer*>(user)->draw_layers(*what); };
    params_ = params;
    draw_counts_ = {};
    library_.complaint.clear();
    earlier_ = submitted_;
    submitted_ = frame.pose ? frame.pose : desc_.scene->first_pose();
    next_ = frame.next_pose ? frame.next_pose : submitted_;
    before_ = drawn_;

    if (vertex_query_.name() != 0) { glBeginQuery(GL_VERTEX_SHADER_INVOCATIONS, vertex_query_.name()); }
    const dgb_result built = dgb_build(&library_.context, &camera, &params, draw, this);
    if (vertex_query_.name() != 0) { glEndQuery(GL_VERTEX_SHADER_INVOCATIONS); }
    if (built != DGB_OK) { throw std::runtime_error(library_.complaint); }
    view_ = to_mat4(library_.context.drawn.view);
    projection_ = to_mat4(library_.context.drawn.projection);
}

void SceneRenderer::shade(const dgb_params& params) {
    light_layers();
    shade_again(params);
    desc_.times->begin();
    composite();
    desc_.times->end("composite");
    collect_gpu_times();
}

void SceneRenderer::shade_again(const dgb_params& params) {
    if (dgb_shade(&library_.context, &params) != DGB_OK) { throw std::runtime_error(library_.complaint); }
}

void SceneRenderer::render(const mat4& view, const mat4& projection, const dgb_params& params) {
    SceneFrame frame;
    frame.view = view;
    frame.projection = projection;
    build(frame, params);
    shade(params);
}

// pose: of a dgb_draw.
std::shared_ptr<const GpuPose> SceneRenderer::pose_to_draw(int pose) const {
    return pose < 0 ? earlier_ : pose > 0 ? next_ : submitted_;
}

// The library's draw callback: once for all layers, or once for each. As with the cameras, what was a frame ago is what
// was drawn then; the first frame has only itself; and the depth ahead of the layers comes after them.
void SceneRenderer::draw_layers(const dgb_draw& draw) {
    const GLuint program = (draw.depth_only ? depth_program_ : material_program_).name();
    const std::shared_ptr<const GpuPose> pose = pose_to_draw(draw.pose);
    if (!draw.depth_only) { drawn_ = pose; }
    const GpuPose& before = draw.depth_only ? *drawn_ : before_ ? *before_ : *pose;
    const mat4 view = to_mat4(draw.view);
    glUseProgram(program);
    set_uniform(program, "u_view", view);
    set_uniform(program, "u_roughness", desc_.roughness.value_or(-1.0f));
    set_uniform(program, "u_clip", to_mat4(draw.projection) * view);
    set_uniform(program, "u_previous_clip", to_mat4(draw.previous_projection) * to_mat4(draw.previous_view));
    const DrawCounts counts = desc_.scene->draw(program, *pose, before, draw.instances,
                                                draw.back_faces ? GpuScene::Sides::back : GpuScene::Sides::as_material);
    draw_counts_.draw_calls += counts.draw_calls;
    draw_counts_.triangles += counts.triangles;
}

mat4 SceneRenderer::world_from_buffer() const { return from_buffer(view_); }

// World space with the eye as its origin, where directions are exact however far the eye is from that of the world.
mat4 SceneRenderer::rays_from_buffer() const { return from_buffer(mat4(glm::mat3(view_))); }

// What the view comes from, from (pixel, depth) of the buffer, guard band included. In double precision: with a near
// plane of centimetres and a far one of hundreds of metres the matrix is hard to invert.
mat4 SceneRenderer::from_buffer(const mat4& view) const {
    const bool zero_to_one = desc_.layers.clip == DGB_CLIP_ZERO_TO_ONE;
    const glm::dvec3 first(-1.0, -1.0, zero_to_one ? 0.0 : -1.0); // pixel (0, 0), depth 0
    const glm::dvec3 step(2.0 / plan().width, 2.0 / plan().height, zero_to_one ? 1.0 : 2.0);
    const glm::dmat4 clip_from_buffer = glm::scale(glm::translate(glm::dmat4(1.0), first), step);
    return mat4(glm::inverse(glm::dmat4(projection_) * glm::dmat4(view)) * clip_from_buffer);
}

// Layer 0's radiance, which is still emission alone, goes to the target of full precision.
void SceneRenderer::copy_emission() {
    const GLenum only_direct[] = {GL_NONE, GL_COLOR_ATTACHMENT1};
    glBindFramebuffer(GL_FRAMEBUFFER, light_framebuffers_[0].name());
    glReadBuffer(GL_COLOR_ATTACHMENT0);
    glDrawBuffers(2, only_direct);
    glBlitFramebuffer(0, 0, plan().width, plan().height, 0, 0, plan().width, plan().height, GL_COLOR_BUFFER_BIT,
                      GL_NEAREST);
    const GLenum both[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
    glDrawBuffers(2, both);
}

void SceneRenderer::light_layers() {
    desc_.times->begin();
    copy_emission();
    if (desc_.lights != nullptr && !desc_.lights->empty()) {
        const GLuint program = light_program_.name();
        glUseProgram(program);
        glBindVertexArray(no_vertices_.name());
        bind_layer(program, "u_depth", 0, texture(DGB_DEPTH));
        bind_layer(program, "u_albedo", 1, texture(DGB_ALBEDO));
        bind_layer(program, "u_normal", 2, texture(DGB_NORMAL));
        desc_.lights->bind(program, 3);
        set_uniform(program, "u_empty_depth", empty_depth());
        set_uniform(program, "u_view", view_);
        set_uniform(program, "u_world_from_buffer", world_from_buffer());
        glEnable(GL_BLEND);
        glBlendFunc(GL_ONE, GL_ONE);
        for (int layer = 0; layer < plan().layers; ++layer) {
            const int shrink = divisor(layer); // rounded up: a texel on the edge is one
            glBindFramebuffer(GL_FRAMEBUFFER, light_framebuffers_[size_t(layer)].name());
            glViewport(0, 0, (plan().width + shrink - 1) / shrink, (plan().height + shrink - 1) / shrink);
            set_uniform(program, "u_layer", layer);
            set_uniform(program, "u_divisor", float(shrink));
            draw_fullscreen();
        }
        glDisable(GL_BLEND);
    }
    desc_.times->end("light");
}

void SceneRenderer::composite(std::optional<float> covered) {
    const GLuint program = composite_program_.name();
    const auto bind_if_there = [&](const char* name, int unit, dgb_slot slot) {
        const GLuint unread = direct_.name(); // a sampler must not be without a texture
        bind_texture(program, name, unit, GL_TEXTURE_2D, has(slot) ? texture(slot) : unread);
    };
    glUseProgram(program);
    glBindVertexArray(no_vertices_.name());
    glBindFramebuffer(GL_FRAMEBUFFER, picture_framebuffer_.name());
    glViewport(0, 0, desc_.layers.width, desc_.layers.height);
    bind_layer(program, "u_depth", 0, texture(DGB_DEPTH));
    bind_layer(program, "u_albedo", 1, texture(DGB_ALBEDO));
    bind_texture(program, "u_direct", 2, GL_TEXTURE_2D, direct_.name());
    bind_if_there("u_ao", 3, DGB_AO);
    bind_if_there("u_irradiance", 4, DGB_IRRADIANCE);
    bind_layer(program, "u_normal", 5, texture(DGB_NORMAL));
    bind_if_there("u_reflection", 6, DGB_REFLECTION);
    bind_if_there("u_bent", 7, DGB_BENT);
    set_uniform(program, "u_has_reflection", has(DGB_REFLECTION_RAW) ? 2 : int(has(DGB_REFLECTION)));
    set_uniform(program, "u_has_ao", int(has(DGB_AO)));
    set_uniform(program, "u_has_bent", int(has(DGB_BENT)));
    set_uniform(program, "u_has_irradiance", int(has(DGB_IRRADIANCE)));
    set_uniform(program, "u_covered", covered.value_or(-1.0f));
    set_uniform(program, "u_guard", desc_.layers.guard_band);
    set_uniform(program, "u_empty_depth", empty_depth());
    set_uniform(program, "u_view", view_);
    set_uniform(program, "u_rays_from_buffer", rays_from_buffer());
    const Sky& sky = desc_.sky;
    set_uniform(program, "u_sky", std::vector<vec3>{sky.zenith, sky.horizon, sky.ground});
    set_uniform(program, "u_probe", std::vector<vec3>(desc_.probe.begin(), desc_.probe.end()));
    draw_fullscreen();
}

void SceneRenderer::collect_gpu_times() {
    for (int pass = 0; pass < DGB_PASS_COUNT; ++pass) {
        double milliseconds = 0.0;
        if (dgbgl_pass_time(&library_.backend.gl, dgb_pass_id(pass), &milliseconds)) {
            desc_.times->add_gpu(dgb_pass_name(dgb_pass_id(pass)), milliseconds);
        }
    }
}

// ---- Results --------------------------------------------------------------------------------------------

std::optional<uint64_t> SceneRenderer::vertices_shaded() const {
    if (vertex_query_.name() == 0) { return std::nullopt; }
    GLuint64 count = 0;
    glGetQueryObjectui64v(vertex_query_.name(), GL_QUERY_RESULT, &count);
    return count;
}

// From the attachment of the read framebuffer, one image large, from the pixel (first, first) on. A lower resolution is
// enlarged: every pixel is that of the texel it lies in.
std::vector<float> SceneRenderer::read_pixels(GLenum attachment, GLenum format, int first, int divisor) const {
    const int width = desc_.layers.width, height = desc_.layers.height, start = first / divisor;
    const int columns = (first + width - 1) / divisor + 1 - start, rows = (first + height - 1) / divisor + 1 - start;
    const size_t channels = size_t(channel_count(format));
    std::vector<float> texels(size_t(columns) * size_t(rows) * channels);
    glReadBuffer(attachment);
    glReadPixels(start, start, columns, rows, format, GL_FLOAT, texels.data());
    if (divisor == 1) { return texels; }

    std::vector<float> pixels;
    pixels.reserve(size_t(width) * size_t(height) * channels);
    for (int y = first; y < first + height; ++y) {
        for (int x = first; x < first + width; ++x) {
            const auto texel = size_t(y / divisor - start) * size_t(columns) + size_t(x / divisor - start);
            pixels.insert(pixels.end(), &texels[texel * channels], &texels[texel * channels] + channels);
        }
    }
    return pixels;
}

std::vector<float> SceneRenderer::read_picture(Picture picture) const {
    glBindFramebuffer(GL_READ_FRAMEBUFFER, picture_framebuffer_.name());
    return read_pixels(GLenum(GL_COLOR_ATTACHMENT0 + int(picture)), GL_RGB, 0, 1);
}

std::vector<float> SceneRenderer::read_texture(dgb_slot slot, int layer, GLenum format) const {
    const bool is_depth = slot == DGB_DEPTH || slot == DGB_BACK;
    const bool has_layers = slot <= DGB_KEY; // arrays come first among the slots
    const GLenum attachment = is_depth ? GL_DEPTH_ATTACHMENT : GL_COLOR_ATTACHMENT0;
    const int guard = desc_.layers.guard_band;
    glBindFramebuffer(GL_READ_FRAMEBUFFER, read_framebuffer_.name());
    glFramebufferTexture2D(GL_READ_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, 0, 0);
    glFramebufferTexture2D(GL_READ_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, 0, 0);
    if (has_layers) {
        glFramebufferTextureLayer(GL_READ_FRAMEBUFFER, attachment, texture(slot), 0, layer);
    } else {
        glFramebufferTexture2D(GL_READ_FRAMEBUFFER, attachment, GL_TEXTURE_2D, texture(slot), 0);
    }
    return read_pixels(is_depth ? GL_NONE : GL_COLOR_ATTACHMENT0, format, guard, divisor(slot == DGB_BACK ? 1 : layer));
}

std::vector<float> SceneRenderer::read_linear_depth(int layer) const {
    dgb_camera camera{};
    dgb_camera_from_matrix(glm::value_ptr(projection_), plan().width, plan().height, desc_.layers.clip,
                           desc_.layers.reversed, &camera);
    std::vector<float> z = read_texture(DGB_DEPTH, layer, GL_DEPTH_COMPONENT);
    for (float& value : z) { value = dgb_linear_z(value, &camera); }
    return z;
}

std::vector<float> SceneRenderer::read_z(int layer) const {
    if (has(DGB_Z)) {
        const std::vector<float> both = read_texture(DGB_Z, 0, GL_RG);
        std::vector<float> z(both.size() / 2);
        for (size_t i = 0; i < z.size(); ++i) {
            const float packed = both[2 * i + size_t(layer)];
            z[i] = packed > DGB_EMPTY_Z ? packed : 0.0f;
        }
        return z;
    }
    // without effects there is no pack pass, and strict separation is up to us
    std::vector<float> z = read_linear_depth(layer);
    if (layer == 0 || !params_.strict_separation) { return z; }
    const std::vector<float> front = read_linear_depth(0);
    for (size_t i = 0; i < z.size(); ++i) {
        if (!dgb_keep_test(z[i], front[i], params_.separation)) { z[i] = 0.0f; }
    }
    return z;
}

std::vector<float> SceneRenderer::read_normals(int layer) const {
    const std::vector<float> bytes = read_texture(DGB_NORMAL, layer, GL_RG);
    const std::vector<float> z = read_z(layer);
    std::vector<float> normals(z.size() * 3);
    for (size_t i = 0; i < z.size(); ++i) {
        if (z[i] == 0.0f) { continue; }
        const long low = std::lround(bytes[2 * i] * 255.0f), high = std::lround(bytes[2 * i + 1] * 255.0f);
        dgb_oct16_decode(uint16_t(low | high << 8), &normals[3 * i]);
    }
    return normals;
}
