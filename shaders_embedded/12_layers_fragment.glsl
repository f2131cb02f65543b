// Fragment part. Discard on alpha first, then `if (!dgb_keep()) discard;`, then dgb_store.

in vec4     dgb_v_current;
in vec4     dgb_v_previous;
flat in int dgb_v_layer;

#if DGB_LAYERS > 1
uniform sampler2DArray dgb_oracle;
#endif

#ifdef DGB_ALBEDO_LOCATION
layout(location = DGB_ALBEDO_LOCATION) out vec4 dgb_out_albedo;
#endif
#ifdef DGB_NORMAL_LOCATION
layout(location = DGB_NORMAL_LOCATION) out vec4 dgb_out_normal;
#endif
#ifdef DGB_RADIANCE_LOCATION
layout(location = DGB_RADIANCE_LOCATION) out vec4 dgb_out_radiance;
#endif
#ifdef DGB_VELOCITY_LOCATION
layout(location = DGB_VELOCITY_LOCATION) out vec4 dgb_out_velocity;
#endif

// Pixels that this point moved since the last frame.
vec2 dgb_velocity() {
    return (dgb_v_current.xy / dgb_v_current.z - dgb_v_previous.xy / dgb_v_previous.z) * 0.5 * dgb_draw_size.xy;
}

// Whether this fragment belongs to its layer. Layer 0 keeps all; layer j what is behind layer j-1 of the oracle by more
// than the separation (paper, Listing 2). Both depths go through the same function, and REPROJECT adds differences that are
// exactly 0 when nothing moves: then every oracle gives what peeling gives, bit for bit.
bool dgb_keep() {
#if DGB_LAYERS > 1
    if (dgb_v_layer == 0) return true;
    vec2  pixel = gl_FragCoord.xy;
    float z     = dgb_linear_z(dgb_depth_code(gl_FragCoord.z, dgb_draw_size.w), dgb_draw_camera);
    if (dgb_draw_layer.z == DGB_ORACLE_REPROJECT) {
        vec2 then = pixel - dgb_velocity();
        // behind the previous eye or off its buffer: judged at its own pixel, as PREVIOUS does
        if (dgb_v_previous.z > 0.0 && then.x >= 0.0 && then.y >= 0.0 && then.x < dgb_draw_size.x && then.y < dgb_draw_size.y) {
            pixel = then;
            z -= dgb_v_previous.w - dgb_v_current.w;
        }
    }
    float front = texelFetch(dgb_oracle, ivec3(ivec2(pixel), dgb_v_layer - 1), 0).r;
    return dgb_keep_test(z, dgb_linear_z(dgb_depth_code(front, dgb_draw_size.w), dgb_draw_previous), dgb_draw_size.z);
#else
    return true;
#endif
}

float dgb_storable_velocity(float v) { return abs(v) <= DGB_MAX_RADIANCE ? v : 0.0; }

// albedo.rgb: linear; albedo.a and material: the engine's own, 0..1. normal: camera space, any length. radiance: outgoing,
// W/(m2 sr): emission, and direct light if the material shader computes it.
void dgb_store(vec4 albedo, vec3 normal, vec2 material, vec3 radiance) {
#ifdef DGB_ALBEDO_LOCATION
    dgb_out_albedo = albedo;
#endif
#ifdef DGB_NORMAL_LOCATION
    dgb_out_normal = vec4(dgb_oct16_encode(normal), material);
#endif
#ifdef DGB_RADIANCE_LOCATION
    dgb_out_radiance = vec4(dgb_storable(radiance), 1.0);
#endif
#ifdef DGB_VELOCITY_LOCATION
    vec2 velocity    = dgb_velocity();
    dgb_out_velocity = vec4(dgb_storable_velocity(velocity.x), dgb_storable_velocity(velocity.y), 0.0, 0.0);
#endif
}
