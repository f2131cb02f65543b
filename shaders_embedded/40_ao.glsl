// Ambient occlusion: Equations 1 and 2 of the paper over one or two layers. For a tap beyond the buffer the border stands in:
// leaving it out, as the gather does, nearly doubles the error near the border (tests/bench/guard_band).

layout(std140) uniform dgb_ao_block {
    dgb_camera dgb_ao_camera;
    ivec4      dgb_ao_size;   // buffer width, height, taps, frame
    ivec4      dgb_ao_level;  // log2 q, min level, max level, 1: the second layer matters everywhere
    vec4       dgb_ao_radius; // r (m), 1/r^2, beta (m), epsilon (m^2)
    vec4       dgb_ao_scale;  // pi / taps, intensity, largest reach (pixels), 0 to leave out first-layer occluders
    vec4       dgb_ao_taps[DGB_MAX_TAPS];
};

uniform sampler2D dgb_z;
uniform sampler2D dgb_normals;

layout(location = 0) out vec4 dgb_out_ao;

const float DGB_AO_FADE_START = 1.5; // reach in pixels below which there is nothing to sample
const float DGB_AO_FADE_END   = 3.0; // and from which on the result counts in full

// Square of the occlusion by the surface at depth z that a pixel shows.
float dgb_occlusion_squared(vec2 pixel, float z, dgb_origin x, vec3 n) {
    vec3 v = dgb_offset(pixel, z, x, dgb_ao_camera);
    return dgb_ao_term_squared(v, n, dgb_ao_radius.y, dgb_ao_radius.z, dgb_ao_radius.w);
}

struct dgb_shaded {
    ivec2      pixel;
    dgb_origin x;
    vec3       n;
    dgb_spiral spiral;
};

// Occlusion that tap i finds. second: look at the second layer, which costs no fetch; the same in a whole tile, so that a
// processor that branches skips it. A loop without it, as the gather has, costs those that do not more than it saves.
float dgb_tap_occlusion(int i, dgb_shaded s, bool second) {
    dgb_tap tap = dgb_tap_at(dgb_ao_taps[i], s.spiral, dgb_ao_level);
    vec2    zs  = texelFetch(dgb_z, tap.texel, tap.level).xy;
    float   a2  = dgb_occlusion_squared(vec2(tap.pixel) + 0.5, zs.x, s.x, s.n) * dgb_ao_scale.w;
#if DGB_LAYERS > 1
    if (second) {
        float b2 = dgb_occlusion_squared(dgb_centre(1, tap.pixel), zs.y, s.x, s.n);
        a2       = tap.pixel != s.pixel ? max(a2, b2) : a2; // what lies behind the shaded point itself does not count
    }
#endif
    return sqrt(a2);
}

void main() {
    dgb_shaded s;
    s.pixel     = ivec2(gl_FragCoord.xy);
    float z     = texelFetch(dgb_z, s.pixel, 0).x;
    float reach = dgb_reach(z, dgb_ao_radius.x, dgb_ao_scale.z, dgb_ao_camera);
    s.x         = dgb_origin_at(gl_FragCoord.xy, z, dgb_ao_camera);
    s.n         = dgb_oct16_decode(texelFetch(dgb_normals, s.pixel, 0).xy);
    s.spiral    = dgb_spiral_at(gl_FragCoord.xy, reach, dgb_ao_size);
    int   taps  = z > DGB_EMPTY_Z && reach > DGB_AO_FADE_START ? dgb_ao_size.z : 0;
    float sum   = 0.0;
#if DGB_LAYERS > 1
    bool second = dgb_tile_at(s.pixel, dgb_ao_level.w != 0).x;
#else
    bool second = false;
#endif
    for (int i = 0; i < taps; ++i) sum += dgb_tap_occlusion(i, s, second);
    float visibility = dgb_ambient_visibility(sum, dgb_ao_scale.x);
    visibility       = dgb_ao_scale.y == 1.0 ? visibility : pow(visibility, dgb_ao_scale.y);
    float full       = clamp((reach - DGB_AO_FADE_START) / (DGB_AO_FADE_END - DGB_AO_FADE_START), 0.0, 1.0);
    dgb_out_ao       = vec4(taps > 0 ? mix(1.0, visibility, full) : 1.0);
}
