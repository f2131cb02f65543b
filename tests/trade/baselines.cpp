#include "baselines.hpp"

#include "headless.h"

#include <epoxy/gl.h>

#include <cstring>
#include <stdexcept>
#include <string>

namespace {

// What the library's own shader begins with, and what follows it here.
constexpr const char* kBlock = "layout(std140) uniform dgb_ao_block {";
constexpr const char* kHead = R"(
layout(std140) uniform dgb_ao_block {
    dgb_camera dgb_ao_camera;
    ivec4      dgb_ao_size;   // buffer width, height, taps, frame
    ivec4      dgb_ao_level;  // log2 q, min level, max level
    vec4       dgb_ao_radius; // r (m)
    vec4       dgb_ao_scale;  // z: largest reach (pixels)
    vec4       dgb_ao_taps[DGB_MAX_TAPS];
};
uniform sampler2D dgb_z;
uniform sampler2D dgb_normals;
layout(location = 0) out vec4 dgb_out_ao;

float reach_of(float z) { return min(dgb_pixels_per_metre(z, dgb_ao_camera) * dgb_ao_radius.x, dgb_ao_scale.z); }
)";

// Lengths in radii. Bias and epsilon as the authors give them for a radius of a metre.
constexpr const char* kSao = R"(
void main() {
    ivec2      pixel  = ivec2(gl_FragCoord.xy);
    float      z      = texelFetch(dgb_z, pixel, 0).x, reach = reach_of(z), sum = 0.0;
    vec3       n      = dgb_oct16_decode(texelFetch(dgb_normals, pixel, 0).xy);
    dgb_origin x      = dgb_origin_at(gl_FragCoord.xy, z, dgb_ao_camera);
    dgb_spiral spiral = dgb_spiral_at(gl_FragCoord.xy, reach, dgb_ao_size);
    int        taps   = z > DGB_EMPTY_Z && reach > 1.0 ? dgb_ao_size.z : 0;
    for (int i = 0; i < taps; ++i) {
        dgb_tap tap     = dgb_tap_at(dgb_ao_taps[i], spiral, dgb_ao_level);
        float   y       = texelFetch(dgb_z, tap.texel, tap.level).x;
        vec3    v       = dgb_offset(vec2(tap.pixel) + 0.5, y, x, dgb_ao_camera) / dgb_ao_radius.x;
        float   d2      = dot(v, v);
        float   falloff = max(1.0 - d2, 0.0);
        sum += falloff * falloff * falloff * max((dot(v, n) - 0.01) / (d2 + 0.01), 0.0);
    }
    dgb_out_ao = vec4(taps > 0 ? max(1.0 - 5.0 * sum / float(taps), 0.0) : 1.0);
}
)";

// Two slices for 16 taps, three for 18 and more: as many as there are steps, roughly, on each side.
constexpr const char* kGtao = R"(
const float FADE_START = 1.0, FADE_END = 1.2; // of the radius: found by others to fit rays that end at the radius

// Largest cosine with the line of sight on one side of a slice.
float horizon(vec2 direction, float lowest, float shift, int steps, float reach, vec3 x, vec3 v) {
    float highest = lowest;
    for (int k = 0; k < steps; ++k) {
        float s      = (float(k) + shift) / float(steps);
        float h      = max(s * s * reach * FADE_END, 1.0); // denser where occlusion counts most
        vec2  at     = clamp(gl_FragCoord.xy + h * direction, vec2(0.0), vec2(dgb_ao_size.xy) * 0.99999994);
        int   level  = dgb_mip_level(h, dgb_ao_level.x, dgb_ao_level.y, dgb_ao_level.z);
        ivec2 texel  = min(ivec2(at) >> level, (dgb_ao_size.xy >> level) - 1);
        float y      = texelFetch(dgb_z, texel, level).x;
        vec3  d      = dgb_position(vec2(dgb_mip_source(texel, level)) + 0.5, y, dgb_ao_camera) - x;
        float length = sqrt(dot(d, d));
        float weight = clamp((FADE_END - length / dgb_ao_radius.x) / (FADE_END - FADE_START), 0.0, 1.0);
        if (length > 0.0) highest = max(highest, mix(lowest, dot(d, v) / length, weight));
    }
    return highest;
}

float arc(float h, float g) { return 0.25 * (cos(g) + 2.0 * h * sin(g) - cos(2.0 * h - g)); }

// Visibility of one slice. angle: in the image
float slice(float angle, float shift, int steps, float reach, vec3 x, vec3 v, vec3 n) {
    vec2  direction = vec2(cos(angle), sin(angle));
    vec2  side      = dgb_ao_camera.position_z.xy * x.z + dgb_ao_camera.position_1.xy; // metres between pixels
    vec3  d         = vec3(direction * side, 0.0);
    vec3  along     = normalize(d - dot(d, v) * v), across = cross(along, v);
    vec3  projected = n - dot(n, across) * across;
    float length    = max(sqrt(dot(projected, projected)), 1e-6);
    float g         = sign(dot(projected, along)) * acos(clamp(dot(projected, v) / length, -1.0, 1.0));
    float ahead     = horizon(direction, cos(g + 0.5 * DGB_PI), shift, steps, reach, x, v);
    float behind    = horizon(-direction, cos(g - 0.5 * DGB_PI), shift, steps, reach, x, v);
    return length * (arc(acos(clamp(ahead, -1.0, 1.0)), g) + arc(-acos(clamp(behind, -1.0, 1.0)), g));
}

void main() {
    ivec2 pixel  = ivec2(gl_FragCoord.xy);
    float z      = texelFetch(dgb_z, pixel, 0).x, reach = reach_of(z), sum = 0.0;
    vec3  n      = dgb_oct16_decode(texelFetch(dgb_normals, pixel, 0).xy);
    vec3  x      = dgb_position(gl_FragCoord.xy, z, dgb_ao_camera);
    int   slices = max(int(sqrt(0.5 * float(dgb_ao_size.z))), 1), steps = max(dgb_ao_size.z / (2 * slices), 1);
    vec2  noise  = dgb_pixel_pair(pixel, dgb_ao_size.w);
    bool  there  = z > DGB_EMPTY_Z && reach > 1.0;
    for (int i = 0; i < (there ? slices : 0); ++i) {
        float angle = DGB_PI * (float(i) + noise.x) / float(slices);
        sum += slice(angle, fract(noise.y + 0.618 * float(i)), steps, reach, x, -dgb_view(x, dgb_ao_camera), n);
    }
    dgb_out_ao = vec4(there ? clamp(sum / float(slices), 0.0, 1.0) : 1.0);
}
)";

template <Baseline baseline>
void shader_source(GLuint shader, GLsizei count, const GLchar* const* pieces, const GLint* /*lengths: none*/) {
    std::string text;
    for (GLsizei i = 0; i < count; ++i) { text += pieces[i]; }
    const size_t block = text.find(kBlock);
    if (block != std::string::npos) {
        text.resize(block);
        text += kHead;
        text += baseline == Baseline::sao ? kSao : kGtao;
    }
    const char* whole = text.c_str();
    glShaderSource(shader, 1, &whole, nullptr);
}

template <Baseline baseline>
void* get_proc(const char* name) {
    if (std::strcmp(name, "glShaderSource") != 0) { return headless_get_proc(name); }
    return reinterpret_cast<void*>(shader_source<baseline>);
}

} // namespace

const char* name_of(Baseline baseline) {
    return baseline == Baseline::sao ? "sao" : baseline == Baseline::gtao ? "gtao" : "none";
}

dgbgl_get_proc_fn get_proc_of(Baseline baseline) {
    return baseline == Baseline::sao    ? get_proc<Baseline::sao>
           : baseline == Baseline::gtao ? get_proc<Baseline::gtao>
                                        : headless_get_proc;
}
