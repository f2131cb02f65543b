// Pack: camera z, normals and radiance of up to two layers into the shading input (paper, Table 1). With bounces, what fell on
// a surface last frame is part of what it sends (Equation 6).

layout(std140) uniform dgb_pack_block {
    dgb_camera dgb_pack_camera;
    vec4       dgb_pack_rotation[3]; // world to camera, columns
    vec4       dgb_pack_separation;  // separation in m (-1: keep what the oracle let through), depth codes
    ivec4      dgb_pack_size;        // buffer width, height
    vec4       dgb_pack_bounce;      // damping, boost of grey, boost of saturated colour, taps
    dgb_reprojection dgb_pack_past;
};

float dgb_z_of(float depth) { return dgb_linear_z(dgb_depth_code(depth, dgb_pack_separation.y), dgb_pack_camera); }

float dgb_z_at(int layer, ivec2 p) { return dgb_z_of(dgb_depth_at(layer, p)); }

layout(location = 0) out vec4 dgb_out_z;
layout(location = 1) out vec4 dgb_out_normals;
#if DGB_PACK_RADIANCE
layout(location = 2) out vec4 dgb_out_b0;
#if DGB_LAYERS > 1
layout(location = 3) out vec4 dgb_out_b1;
#endif
#endif

// The Oct16 bytes of a layer's normal, from whatever the engine has.
#if DGB_NORMALS_FORMAT == 0
// From depth. Along each axis the tangent comes from the side on which the surface goes on: the one whose two texels
// extrapolate best to this one. Window depth is linear in the image over a plane, so a plane extrapolates exactly.
bool dgb_inside(ivec2 p) { return p.x >= 0 && p.y >= 0 && p.x < dgb_pack_size.x && p.y < dgb_pack_size.y; }

vec3 dgb_point(int layer, ivec2 p) { return dgb_position(vec2(p) + 0.5, dgb_z_at(layer, p), dgb_pack_camera); }

// How badly the texels at p + step and p + 2 step foretell the depth at p; 2: there is no surface to ask.
float dgb_kink(int layer, ivec2 p, ivec2 step, float depth) {
    if (!dgb_inside(p + step) || dgb_z_at(layer, p + step) == 0.0) return 2.0;
    float near = dgb_depth_at(layer, p + step);
    if (!dgb_inside(p + 2 * step) || dgb_z_at(layer, p + 2 * step) == 0.0) return abs(near - depth);
    return abs(2.0 * near - dgb_depth_at(layer, p + 2 * step) - depth);
}

vec3 dgb_tangent(int layer, ivec2 p, ivec2 step, vec3 here) {
    float depth = dgb_depth_at(layer, p);
    float after = dgb_kink(layer, p, step, depth), before = dgb_kink(layer, p, -step, depth);
    if (after < 2.0 && after <= before) return dgb_point(layer, p + step) - here;
    return before < 2.0 ? here - dgb_point(layer, p - step) : vec3(0.0);
}

vec2 dgb_normal_bytes(int layer, ivec2 p, float z) {
    vec3 here = dgb_point(layer, p);
    vec3 x    = dgb_tangent(layer, p, ivec2(1, 0), here);
    vec3 y    = dgb_tangent(layer, p, ivec2(0, 1), here);
    return dgb_oct16_encode(cross(x / z, y / z)); // free of units; zero without neighbours: +Z, towards the eye
}
#elif DGB_NORMALS_FORMAT == 1
vec2 dgb_normal_bytes(int layer, ivec2 p, float z) { return dgb_normal_at(layer, p).rg; }
#else
vec2 dgb_normal_bytes(int layer, ivec2 p, float z) {
#if DGB_NORMALS_FORMAT == 2
    vec3 n = dgb_normal_at(layer, p) * 2.0 - 1.0;
#else
    vec3 n = dgb_normal_at(layer, p);
#endif
    return dgb_oct16_encode(dgb_pack_rotation[0].xyz * n.x + dgb_pack_rotation[1].xyz * n.y + dgb_pack_rotation[2].xyz * n.z);
}
#endif

#if DGB_LAST_LIGHT
// Light that fell on the surface last frame and that it sends on: albedo/pi * damping * boost * E.
vec3 dgb_bounced(int layer, ivec2 p, float z, vec2 normal) {
    vec2     pixel  = dgb_centre(layer, p);
    vec3     x      = dgb_position(pixel, z, dgb_pack_camera);
    dgb_past past   = dgb_past_of(pixel, x, dgb_oct16_decode(normal), dgb_velocity_at(layer, p), dgb_pack_past);
    ivec2    texel  = ivec2(past.pixel);
    int      shown  = dgb_past_layer(texel, past, dgb_pack_past);
    vec3     albedo = dgb_storable(dgb_albedo_at(layer, p));
    float    factor = dgb_pack_bounce.x * dgb_boost(albedo, dgb_pack_bounce.y, dgb_pack_bounce.z) / DGB_PI;
    vec4     e      = dgb_last_irradiance_at(texel, shown);
    float    found  = min(e.a * dgb_pack_bounce.w, 1.0); // below one tap a frame: light that has gone must not bounce on
    return shown < 0 ? vec3(0.0) : factor * found * albedo * e.rgb;
}
#endif

vec3 dgb_packed_radiance(int layer, ivec2 p, float z, vec2 normal) {
    vec3 radiance = dgb_storable(dgb_radiance_at(layer, p));
#if DGB_LAST_LIGHT
    radiance = dgb_storable(radiance + dgb_bounced(layer, p, z, normal));
#endif
    return z != 0.0 ? dgb_nearest(radiance) : vec3(0.0);
}

float dgb_packed_z(float z) { return z != 0.0 ? z : DGB_EMPTY_Z; }

vec2 dgb_packed_normal(int layer, ivec2 p, float z) { return z != 0.0 ? dgb_normal_bytes(layer, p, z) : vec2(0.0); }

void main() {
    ivec2 p         = ivec2(gl_FragCoord.xy);
    float z0        = dgb_z_at(0, p);
    dgb_out_z       = vec4(dgb_packed_z(z0), 0.0, 0.0, 0.0);
    dgb_out_normals = vec4(dgb_packed_normal(0, p, z0), 0.0, 0.0);
#if DGB_BACK
    float back = dgb_z_of(dgb_back_at(p)); // behind another pixel's layer 0, with a divisor: never before this one's
    dgb_out_z.z = dgb_packed_z(dgb_keep_test(back, z0, 0.0) ? back : 0.0);
#endif
#if DGB_PACK_RADIANCE
    dgb_out_b0 = vec4(dgb_packed_radiance(0, p, z0, dgb_out_normals.xy), 1.0);
#endif
#if DGB_LAYERS > 1
    float z1 = dgb_z_at(1, p);
    // strict separation, against the true layer 0: a wrong guess of the oracle becomes a hole
    if (dgb_pack_separation.x >= 0.0 && !dgb_keep_test(z1, z0, dgb_pack_separation.x)) z1 = 0.0;
    dgb_out_z.y        = dgb_packed_z(z1);
    dgb_out_normals.zw = dgb_packed_normal(1, p, z1);
#if DGB_PACK_RADIANCE
    dgb_out_b1 = vec4(dgb_packed_radiance(1, p, z1, dgb_out_normals.zw), 1.0);
#endif
#endif
}
