// Radiosity: Equations 4 and 5 of the paper over one or two layers of senders. A tap beyond the buffer finds none: with the
// border in its place, what stands there would send again and again.

layout(std140) uniform dgb_gather_block {
    dgb_camera dgb_gather_camera;
    ivec4      dgb_gather_size;   // buffer width, height, taps, frame
    ivec4      dgb_gather_level;  // log2 q, min level, max level
    vec4       dgb_gather_radius; // r (m), r^2, normaliser k, largest reach (pixels)
    vec4       dgb_gather_taps[DGB_MAX_TAPS];
};

uniform sampler2D dgb_z;
uniform sampler2D dgb_normals;
uniform sampler2D dgb_b0;
#if DGB_LAYERS > 1
uniform sampler2D dgb_b1;
#endif

layout(location = 0) out vec4 dgb_out_irradiance;

// Cosine of what the surface at depth z on the ray through a tap sends; 0 when it is too far (as an empty texel is), behind, or
// faces away. ray_1 is relative to the shaded point's x, y.
float dgb_sender(vec2 ray_z, vec2 ray_1, float z, float shaded_z, vec3 n, vec2 sender_normal) {
    vec3  v      = vec3(ray_z * z + ray_1, z - shaded_z);
    float cosine = dgb_gather_term(v, n, dgb_gather_radius.y);
#if DGB_NORMAL_TEST
    if (!(dot(v, dgb_oct16_decode(sender_normal)) < 0.0)) cosine = 0.0;
#endif
    return cosine;
}

void main() {
    ivec2 pixel    = ivec2(gl_FragCoord.xy);
    float z        = texelFetch(dgb_z, pixel, 0).x;
    vec3  x        = dgb_position(gl_FragCoord.xy, z, dgb_gather_camera);
    vec3  n        = dgb_oct16_decode(texelFetch(dgb_normals, pixel, 0).xy);
    float reach    = min(dgb_pixels_per_metre(z, dgb_gather_camera) * dgb_gather_radius.x, dgb_gather_radius.w);
    vec2  rotation = dgb_rotation(pixel, dgb_gather_size.w);
    int   taps     = z > DGB_EMPTY_Z && reach > 0.0 ? dgb_gather_size.z : 0;
    vec3  light    = vec3(0.0);
    float cosines = 0.0, senders = 0.0, useful_taps = 0.0;
    for (int i = 0; i < taps; ++i) {
        dgb_tap tap   = dgb_tap_at(dgb_gather_taps[i], rotation, reach, gl_FragCoord.xy, dgb_gather_size.xy, dgb_gather_level);
        vec2    at    = vec2(tap.pixel) + 0.5;
        vec2    ray_z = at * dgb_gather_camera.position_z.xy + dgb_gather_camera.position_z.zw;
        vec2    ray_1 = at * dgb_gather_camera.position_1.xy + (dgb_gather_camera.position_1.zw - x.xy);
        float   other = tap.inside && tap.pixel != pixel ? 1.0 : 0.0;
        vec2    zs    = texelFetch(dgb_z, tap.texel, tap.level).xy;
#if DGB_NORMAL_TEST
        vec4 normals = texelFetch(dgb_normals, tap.texel, tap.level);
#else
        vec4 normals = vec4(0.0);
#endif
        float c0 = other * dgb_sender(ray_z, ray_1, zs.x, z, n, normals.xy);
        vec3  l0 = texelFetch(dgb_b0, tap.texel, tap.level).rgb * c0;
#if DGB_LAYERS > 1
#if DGB_DIVISOR > 1
        at    = dgb_deep_centre(tap.pixel);
        ray_z = at * dgb_gather_camera.position_z.xy + dgb_gather_camera.position_z.zw;
        ray_1 = at * dgb_gather_camera.position_1.xy + (dgb_gather_camera.position_1.zw - x.xy);
#endif
        float c1 = other * dgb_sender(ray_z, ray_1, zs.y, z, n, normals.zw);
        vec3  l1 = texelFetch(dgb_b1, tap.texel, tap.level).rgb * c1;
        useful_taps += c0 + c1 > 0.0 ? 1.0 : 0.0;
#if DGB_STRONGEST_SENDER
        bool first = c1 == 0.0 || (c0 > 0.0 && dot(l0, vec3(1.0)) >= dot(l1, vec3(1.0)));
        c0         = first ? c0 : c1;
        l0         = first ? l0 : l1;
#else
        light += l1;
        cosines += c1;
        senders += c1 > 0.0 ? 1.0 : 0.0;
#endif
#else
        useful_taps += c0 > 0.0 ? 1.0 : 0.0;
#endif
        light += l0;
        cosines += c0;
        senders += c0 > 0.0 ? 1.0 : 0.0;
    }
    vec3 irradiance    = light * dgb_gather_scale(cosines, senders, dgb_gather_radius.z);
    dgb_out_irradiance = vec4(dgb_storable(irradiance), taps > 0 ? useful_taps / float(taps) : 0.0);
}
