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

// Square of the occlusion by the surface at depth z on the ray through a tap; ray_1 is relative to the shaded point's x, y.
float dgb_occlusion_squared(vec2 ray_z, vec2 ray_1, float z, float shaded_z, vec3 n) {
    vec3 v = vec3(ray_z * z + ray_1, z - shaded_z);
    return dgb_ao_term_squared(v, n, dgb_ao_radius.y, dgb_ao_radius.z, dgb_ao_radius.w);
}

struct dgb_shaded {
    ivec2 pixel;
    vec3  x, n;
    float reach; // pixels
    vec2  rotation;
};

// Occlusion that tap i finds. second: look at the second layer, which costs no fetch; the same in a whole tile, so that a
// processor that branches skips it. A loop without it, as the gather has, costs those that do not more than it saves.
float dgb_tap_occlusion(int i, dgb_shaded s, bool second) {
    dgb_tap tap   = dgb_tap_at(dgb_ao_taps[i], s.rotation, s.reach, vec2(s.pixel) + 0.5, dgb_ao_size.xy, dgb_ao_level);
    vec2    at    = vec2(tap.pixel) + 0.5;
    vec2    ray_z = at * dgb_ao_camera.position_z.xy + dgb_ao_camera.position_z.zw;
    vec2    ray_1 = at * dgb_ao_camera.position_1.xy + (dgb_ao_camera.position_1.zw - s.x.xy);
    vec2    zs    = texelFetch(dgb_z, tap.texel, tap.level).xy;
    float   a2    = dgb_occlusion_squared(ray_z, ray_1, zs.x, s.x.z, s.n) * dgb_ao_scale.w;
#if DGB_LAYERS > 1
    if (second) {
#if DGB_DIVISOR > 1
        at    = dgb_centre(1, tap.pixel);
        ray_z = at * dgb_ao_camera.position_z.xy + dgb_ao_camera.position_z.zw;
        ray_1 = at * dgb_ao_camera.position_1.xy + (dgb_ao_camera.position_1.zw - s.x.xy);
#endif
        a2 = max(a2, dgb_occlusion_squared(ray_z, ray_1, zs.y, s.x.z, s.n));
    }
#endif
    return tap.pixel != s.pixel ? sqrt(a2) : 0.0;
}

void main() {
    dgb_shaded s;
    s.pixel    = ivec2(gl_FragCoord.xy);
    float z    = texelFetch(dgb_z, s.pixel, 0).x;
    s.x        = dgb_position(gl_FragCoord.xy, z, dgb_ao_camera);
    s.n        = dgb_oct16_decode(texelFetch(dgb_normals, s.pixel, 0).xy);
    s.reach    = min(dgb_pixels_per_metre(z, dgb_ao_camera) * dgb_ao_radius.x, dgb_ao_scale.z);
    s.rotation = dgb_rotation(s.pixel, dgb_ao_size.w);
    int   taps = z > DGB_EMPTY_Z && s.reach > DGB_AO_FADE_START ? dgb_ao_size.z : 0;
    float sum  = 0.0;
#if DGB_LAYERS > 1
    bool second = dgb_tile_at(s.pixel, dgb_ao_level.w != 0).x;
#else
    bool second = false;
#endif
    for (int i = 0; i < taps; ++i) sum += dgb_tap_occlusion(i, s, second);
    float visibility = dgb_ambient_visibility(sum, dgb_ao_scale.x);
    visibility       = dgb_ao_scale.y == 1.0 ? visibility : pow(visibility, dgb_ao_scale.y);
    float full       = clamp((s.reach - DGB_AO_FADE_START) / (DGB_AO_FADE_END - DGB_AO_FADE_START), 0.0, 1.0);
    dgb_out_ao       = vec4(taps > 0 ? mix(1.0, visibility, full) : 1.0);
}
