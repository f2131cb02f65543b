#include "viewer_views.hpp"

#include <glm/gtc/type_ptr.hpp>

#include <array>
#include <cmath>
#include <cstring>

namespace {

// From where a view gets its colours. The shader has the same numbers.
enum class Paint {
    radiance = 0,
    grey,
    depth,
    normal,
    albedo,
    layer_radiance,
    velocity,
    validity,
    irradiance,
    confidence,
    history,
    mirrored,
    hit
};

constexpr int kPicture = -1; // not a texture of the library, but one of SceneRenderer::Picture

struct ViewKind {
    const char* name;
    Paint paint;
    int source; // dgb_slot, or kPicture
    const char* help;
};

const std::array<ViewKind, size_t(View::count)> kViews = {{
    {"final", Paint::radiance, kPicture, "the picture"},
    {"direct", Paint::radiance, kPicture, "emission, direct light and the sky"},
    {"indirect", Paint::radiance, kPicture, "bounced light, the probe's light and reflections"},
    {"depth", Paint::depth, DGB_DEPTH, "near is white, far is black, nothing is blue"},
    {"normal", Paint::normal, DGB_NORMAL, "camera space: x red, y green, z blue; grey is 0"},
    {"albedo", Paint::albedo, DGB_ALBEDO, "what a surface reflects"},
    {"radiance", Paint::layer_radiance, DGB_RADIANCE, "what a surface sends: its emission and direct light"},
    {"velocity", Paint::velocity, DGB_VELOCITY, "motion since the last frame: right is red, up is green, grey is none"},
    {"validity", Paint::validity, DGB_DEPTH, "cyan: the layer has a surface; red: had one, too near to the first"},
    {"ao", Paint::grey, DGB_AO, "ambient visibility: 1 is open"},
    {"irradiance", Paint::irradiance, DGB_IRRADIANCE, "bounced light as white paper would show it"},
    {"confidence", Paint::confidence, DGB_IRRADIANCE, "share of taps that found a sender of light"},
    {"history", Paint::history, DGB_FRAMES, "frames averaged: black none, red few, white as many as count"},
    {"reflection", Paint::mirrored, DGB_REFLECTION, "what a mirror or lobe shows, by its confidence"},
    {"reflection_layer", Paint::hit, DGB_REFLECTION_HIT,
     "where the ray ended: blue layer 0, orange layer 1, black none"},
}};

const ViewKind& kind_of(View view) { return kViews[size_t(view)]; }

// Without #version, which make_fullscreen_program adds.
const char* const kFragment = R"(
const float PI = 3.14159265358979;

uniform sampler2D u_image;
uniform sampler2DArray u_layers;
uniform sampler2DArray u_first;   // depth of all layers
uniform sampler2D u_packed;       // camera z of two layers
uniform int u_paint;
uniform int u_layer;
uniform float u_divisor;          // of the layer's resolution
uniform float u_guard;            // pixels, of u_image
uniform float u_layer_guard;      // of u_layers
uniform vec3 u_to_image;          // pixels of the image a pixel of the window: x, y
uniform float u_exposure;         // factor
uniform float u_far;              // metres
uniform float u_empty_depth;
uniform float u_history;          // weight
uniform float u_packs;            // 1: u_packed is there
uniform vec4 u_linearise;         // dgb_camera's

out vec4 out_color;

vec3 srgb(vec3 linear) {
    return mix(1.055 * pow(max(linear, 0.0), vec3(1.0 / 2.4)) - 0.055, 12.92 * linear, lessThanEqual(linear, vec3(0.0031308)));
}

// Narkowicz's fit of the ACES filmic curve.
vec3 filmic(vec3 x) {
    x = min(u_exposure * x, 1e4);
    return srgb(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14));
}

// What dgb_oct16_decode does.
vec3 decode_normal(vec2 bytes) {
    vec2 p = (min(floor(bytes * 255.0 + 0.5), 254.0) - 127.0) / 127.0;
    float z = 1.0 - abs(p.x) - abs(p.y);
    vec2 folded = (1.0 - abs(p.yx)) * vec2(p.x < 0.0 ? -1.0 : 1.0, p.y < 0.0 ? -1.0 : 1.0);
    return normalize(vec3(z < 0.0 ? folded : p, z));
}

// Metres in front of the eye; what dgb_linear_z does.
float distance_of(float depth) {
    float t = depth - u_empty_depth;
    return -(u_linearise.x + u_linearise.y * t) / (u_linearise.z + u_linearise.w * t);
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy * u_to_image.xy);
    ivec2 guarded = pixel + int(u_guard);
    ivec3 texel = ivec3((pixel + int(u_layer_guard)) / int(u_divisor), u_layer);
    vec4 image = texelFetch(u_image, guarded, 0);
    vec4 layer = texelFetch(u_layers, texel, 0);
    float depth = texelFetch(u_first, texel, 0).r;
    float first = texelFetch(u_first, ivec3(pixel + int(u_layer_guard), 0), 0).r;
    bool empty = depth == u_empty_depth;
    vec3 color = vec3(0.0);
    if (u_paint == 0) color = filmic(image.rgb);
    if (u_paint == 1) color = image.rrr;
    if (u_paint == 2) color = empty ? vec3(0.05, 0.08, 0.3) : vec3(exp2(-3.0 * distance_of(depth) / u_far));
    if (u_paint == 3 && !empty) color = 0.5 + 0.5 * decode_normal(layer.rg);
    if (u_paint == 4 && !empty) color = srgb(layer.rgb);
    if (u_paint == 5 && !empty) color = filmic(layer.rgb);
    if (u_paint == 6 && !empty) color = vec3(clamp(0.5 + layer.rg / 32.0, 0.0, 1.0), 0.5);
    if (u_paint == 7) {
        bool kept = u_layer > 1 || u_packs == 0.0 || texelFetch(u_packed, pixel + int(u_layer_guard), 0)[min(u_layer, 1)] > -1e15;
        vec3 dim = first == u_empty_depth ? vec3(0.0) : vec3(0.1 + 0.3 * exp2(-3.0 * distance_of(first) / u_far));
        color = empty ? dim : dim + (kept ? vec3(0.0, 0.5, 0.5) : vec3(0.6, 0.0, 0.0));
    }
    if (u_paint == 8) color = filmic(image.rgb / PI);
    if (u_paint == 9) color = image.aaa;
    if (u_paint == 10) {
        float frames = max(image.g, image.b); // of visibility, of light
        float share = min(frames / (frames + 1.0), u_history) / max(u_history, 1e-3);
        color = frames == 0.0 ? vec3(0.0) : mix(vec3(0.8, 0.1, 0.0), vec3(1.0), share * share);
    }
    if (u_paint == 11) color = filmic(image.rgb * image.a);
    if (u_paint == 12) color = image.r == 0.0 ? vec3(0.0) : image.r < 1.5 ? vec3(0.1, 0.3, 0.9) : vec3(1.0, 0.5, 0.0);
    out_color = vec4(color, 1.0);
}
)";

GlObject make_nothing(GLenum target) {
    GlObject texture = make_texture();
    glBindTexture(target, texture.name());
    if (target == GL_TEXTURE_2D) {
        glTexImage2D(target, 0, GL_RGBA8, 1, 1, 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
    } else {
        glTexImage3D(target, 0, GL_RGBA8, 1, 1, 1, 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
    }
    glTexParameteri(target, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    return texture;
}

bool is_there(const SceneRenderer& renderer, ViewChoice choice) {
    const int source = kind_of(choice.view).source;
    if (is_of_layer(choice.view) && choice.layer >= renderer.plan().layers) { return false; }
    return source == kPicture || renderer.has(dgb_slot(source));
}

void fill(Area visible) {
    glEnable(GL_SCISSOR_TEST);
    glScissor(visible.x, visible.y, visible.width, visible.height);
    glClearColor(0.12f, 0.12f, 0.12f, 1.0f);
    glClear(GL_COLOR_BUFFER_BIT);
    glDisable(GL_SCISSOR_TEST);
}

} // namespace

const char* view_name(View view) { return kind_of(view).name; }
const char* view_help(View view) { return kind_of(view).help; }

std::optional<ViewChoice> view_of(const std::string& name) {
    for (size_t i = 0; i < kViews.size(); ++i) {
        const size_t length = std::strlen(kViews[i].name);
        if (name.compare(0, length, kViews[i].name) != 0) { continue; }
        ViewChoice choice;
        choice.view = View(i);
        if (name.size() == length) {
            choice.layer = choice.view == View::validity ? 1 : 0;
            return choice;
        }
        const char digit = name[length];
        if (name.size() == length + 1 && is_of_layer(choice.view) && '0' <= digit && digit < '0' + DGB_MAX_LAYERS) {
            choice.layer = digit - '0';
            return choice;
        }
    }
    return std::nullopt;
}

ViewPainter::ViewPainter()
    : program_(make_fullscreen_program("view", kFragment)), no_vertices_(make_vertex_array()),
      no_image_(make_nothing(GL_TEXTURE_2D)), no_array_(make_nothing(GL_TEXTURE_2D_ARRAY)) {}

bool ViewPainter::paint(const SceneRenderer& renderer, ViewChoice choice, Area window, Area visible, float exposure,
                        float depth_range, float history_weight) const {
    fill(visible);
    if (!is_there(renderer, choice)) { return false; }

    const ViewKind& kind = kind_of(choice.view);
    const bool of_layer = is_of_layer(choice.view), is_picture = kind.source == kPicture;
    const dgb_desc& layers = renderer.layers();
    const GLuint program = program_.name();
    const GLuint image = of_layer     ? no_image_.name()
                         : is_picture ? renderer.picture(SceneRenderer::Picture(int(choice.view)))
                                      : renderer.texture(dgb_slot(kind.source));
    glUseProgram(program);
    glBindVertexArray(no_vertices_.name());
    bind_texture(program, "u_image", 0, GL_TEXTURE_2D, image);
    bind_texture(program, "u_layers", 1, GL_TEXTURE_2D_ARRAY,
                 of_layer ? renderer.texture(dgb_slot(kind.source)) : no_array_.name());
    bind_texture(program, "u_first", 2, GL_TEXTURE_2D_ARRAY, renderer.texture(DGB_DEPTH));
    const bool packs = renderer.has(DGB_Z);
    bind_texture(program, "u_packed", 3, GL_TEXTURE_2D, packs ? renderer.texture(DGB_Z) : no_image_.name());
    set_uniform(program, "u_packs", packs ? 1.0f : 0.0f);
    set_uniform(program, "u_paint", int(kind.paint));
    set_uniform(program, "u_layer", of_layer ? choice.layer : 0);
    set_uniform(program, "u_divisor", float(of_layer ? renderer.divisor(choice.layer) : 1));
    set_uniform(program, "u_guard", is_picture ? 0.0f : float(layers.guard_band));
    set_uniform(program, "u_layer_guard", float(layers.guard_band));
    set_uniform(
        program, "u_to_image",
        glm::vec3(float(layers.width) / float(window.width), float(layers.height) / float(window.height), 0.0f));
    set_uniform(program, "u_exposure", std::exp2(exposure));
    set_uniform(program, "u_far", depth_range);
    set_uniform(program, "u_empty_depth", layers.reversed ? 0.0f : 1.0f);
    set_uniform(program, "u_history", history_weight);
    set_uniform(program, "u_linearise", glm::make_vec4(renderer.camera().linearise));
    glViewport(window.x, window.y, window.width, window.height);
    glEnable(GL_SCISSOR_TEST);
    glScissor(visible.x, visible.y, visible.width, visible.height);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glDisable(GL_SCISSOR_TEST);
    return true;
}
