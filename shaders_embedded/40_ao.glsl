// Ambient occlusion: Equations 1 and 2 of the paper over one or two layers. For a tap beyond the buffer the border stands in:
// leaving it out, as the gather does, nearly doubles the error near the border (tests/bench/guard_band).

layout(std140) uniform dgb_ao_block {
    dgb_camera dgb_ao_camera;
    ivec4      dgb_ao_size;   // buffer width, height, taps, frame
    ivec4      dgb_ao_level;  // log2 q, min level, max level
    vec4       dgb_ao_radius; // r (m), 1/r^2, beta (m), epsilon (m^2)
    vec4       dgb_ao_scale;  // pi / taps, intensity, largest reach (pixels)
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

void main() {
    ivec2 pixel    = ivec2(gl_FragCoord.xy);
    float z        = texelFetch(dgb_z, pixel, 0).x;
    vec3  x        = dgb_position(gl_FragCoord.xy, z, dgb_ao_camera);
    vec3  n        = dgb_oct16_decode(texelFetch(dgb_normals, pixel, 0).xy);
    float reach    = min(dgb_pixels_per_metre(z, dgb_ao_camera) * dgb_ao_radius.x, dgb_ao_scale.z);
    vec2  rotation = dgb_rotation(pixel, dgb_ao_size.w);
    int   taps     = z > DGB_EMPTY_Z && reach > DGB_AO_FADE_START ? dgb_ao_size.z : 0;
    float sum      = 0.0;
    for (int i = 0; i < taps; ++i) {
        dgb_tap tap   = dgb_tap_at(dgb_ao_taps[i], rotation, reach, gl_FragCoord.xy, dgb_ao_size.xy, dgb_ao_level);
        vec2    at    = vec2(tap.pixel) + 0.5;
        vec2    ray_z = at * dgb_ao_camera.position_z.xy + dgb_ao_camera.position_z.zw;
        vec2    ray_1 = at * dgb_ao_camera.position_1.xy + (dgb_ao_camera.position_1.zw - x.xy);
        vec2    zs    = texelFetch(dgb_z, tap.texel, tap.level).xy;
        float   a2    = dgb_occlusion_squared(ray_z, ray_1, zs.x, z, n);
#if DGB_LAYERS > 1
#if DGB_DIVISOR > 1
        at    = dgb_centre(1, tap.pixel);
        ray_z = at * dgb_ao_camera.position_z.xy + dgb_ao_camera.position_z.zw;
        ray_1 = at * dgb_ao_camera.position_1.xy + (dgb_ao_camera.position_1.zw - x.xy);
#endif
        a2 = max(a2, dgb_occlusion_squared(ray_z, ray_1, zs.y, z, n));
#endif
        sum += tap.pixel != pixel ? sqrt(a2) : 0.0;
    }
    float visibility = dgb_ambient_visibility(sum, dgb_ao_scale.x);
    visibility       = dgb_ao_scale.y == 1.0 ? visibility : pow(visibility, dgb_ao_scale.y);
    float full       = clamp((reach - DGB_AO_FADE_START) / (DGB_AO_FADE_END - DGB_AO_FADE_START), 0.0, 1.0);
    dgb_out_ao       = vec4(taps > 0 ? mix(1.0, visibility, full) : 1.0);
}
