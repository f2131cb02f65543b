// Fragment part. Discard on alpha first, then `if (!dgb_keep()) discard;`, then dgb_store.

in vec4 dgb_v_current;
in vec4 dgb_v_previous;
#if DGB_EMISSION_MULTICAST
#define dgb_v_layer (dgb_draw_layer.y > 1 ? gl_Layer : dgb_draw_layer.x)
#elif DGB_EMISSION_SEPARATE || DGB_EMISSION_IMAGE
#define dgb_v_layer dgb_draw_layer.x // no varying: small triangles pay for each
#else
flat in int dgb_v_layer;
#endif

#if DGB_KEEP_TEST
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
    return dgb_v_current.xy / dgb_v_current.z - dgb_v_previous.xy / dgb_v_previous.z;
}

// Some software rasterisers gather every uniform for every lane, so the keep test reads few: what is known when the program is
// made is a constant, the size is the texture's.
float dgb_oracle_z(float depth, dgb_camera camera) {
    camera.footprint.w = float(1 - DGB_REVERSED); // the empty depth
    return dgb_linear_z(dgb_depth_code(depth, float(DGB_DEPTH_CODES)), camera);
}

// Whether this fragment belongs to a layer behind the first: it lies behind the layer before it, in the oracle, by more than
// the separation (paper, Listing 2). Both depths go through the same function, and REPROJECT adds differences that are exactly 0
// when nothing moves: then every oracle gives what peeling gives, bit for bit.
bool dgb_kept_in(int layer) {
#if DGB_KEEP_TEST
    vec2  pixel = gl_FragCoord.xy * float(DGB_DIVISOR); // of the first layer
    float z     = dgb_oracle_z(gl_FragCoord.z, dgb_draw_camera);
    if (dgb_draw_layer.z == DGB_ORACLE_REPROJECT) {
        vec2 then = pixel - dgb_velocity(), size = vec2(textureSize(dgb_oracle, 0).xy);
        // behind the previous eye or off its buffer: judged at its own pixel, as PREVIOUS does
        if (dgb_v_previous.z > 0.0 && then.x >= 0.0 && then.y >= 0.0 && then.x < size.x && then.y < size.y) {
            pixel = then;
            z -= dgb_v_previous.w - dgb_v_current.w;
        }
    }
    ivec2 texel = ivec2(pixel) / (layer > 1 ? DGB_DIVISOR : 1);
    float front = dgb_oracle_z(texelFetch(dgb_oracle, ivec3(texel, layer - 1), 0).r, dgb_draw_previous);
    return dgb_keep_test(z, front, dgb_draw_size.z);
#else
    return true;
#endif
}

// What is in the targets of a material that never calls dgb_store.
void dgb_store_nothing() {
#ifdef DGB_ALBEDO_LOCATION
    dgb_out_albedo = vec4(0.0);
#endif
#ifdef DGB_NORMAL_LOCATION
    dgb_out_normal = vec4(0.0);
#endif
#ifdef DGB_RADIANCE_LOCATION
    dgb_out_radiance = vec4(0.0);
#endif
#ifdef DGB_VELOCITY_LOCATION
    dgb_out_velocity = vec4(0.0);
#endif
}

// Whether to go on with this fragment. The first layer keeps all; what the second would say is remembered, for image emission.
bool dgb_kept_second = false;

bool dgb_keep() {
    dgb_store_nothing();
    dgb_kept_second = dgb_kept_in(max(dgb_v_layer, 1));
    return dgb_v_layer == 0 || dgb_kept_second;
}

float dgb_storable_velocity(float v) { return abs(v) <= DGB_MAX_RADIANCE ? v : 0.0; }

// albedo.rgb: linear; albedo.a and material: the engine's own, 0..1, but with glossy reflections material.x is the roughness.
// normal: camera space, any length. radiance: outgoing, W/(m2 sr): emission, and direct light if the material shader computes it.
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

#if DGB_EMISSION_IMAGE
// Image emission: the pipeline rasterises the first layer only; a fragment that a deeper layer would keep competes for it here,
// nearest depth bits first. Only after the engine's own main, so that what it discards stores nothing.
layout(r32ui) coherent uniform uimage2DArray dgb_image_key;
#ifdef DGB_ALBEDO_LOCATION
layout(rgba8) writeonly uniform image2DArray dgb_image_albedo;
#endif
#ifdef DGB_NORMAL_LOCATION
layout(rgba8) writeonly uniform image2DArray dgb_image_normal;
#endif
#ifdef DGB_RADIANCE_LOCATION
layout(r11f_g11f_b10f) writeonly uniform image2DArray dgb_image_radiance;
#endif
#ifdef DGB_VELOCITY_LOCATION
layout(rg16f) writeonly uniform image2DArray dgb_image_velocity;
#endif
#if DGB_INTERLOCK
layout(pixel_interlock_ordered) in;
#endif

void dgb_compete(int layer) {
    ivec3 texel = ivec3(ivec2(gl_FragCoord.xy), layer);
    uint  key = floatBitsToUint(dgb_depth_code(gl_FragCoord.z, float(DGB_DEPTH_CODES))); // positive floats sort as integers
    uint  nearest = imageLoad(dgb_image_key, texel - ivec3(0, 0, 1)).x;
    if (DGB_REVERSED != 0 ? key <= nearest : key >= nearest) return;
    imageStore(dgb_image_key, texel - ivec3(0, 0, 1), uvec4(key));
#ifdef DGB_ALBEDO_LOCATION
    imageStore(dgb_image_albedo, texel, dgb_out_albedo);
#endif
#ifdef DGB_NORMAL_LOCATION
    imageStore(dgb_image_normal, texel, dgb_out_normal);
#endif
#ifdef DGB_RADIANCE_LOCATION
    imageStore(dgb_image_radiance, texel, dgb_out_radiance);
#endif
#ifdef DGB_VELOCITY_LOCATION
    imageStore(dgb_image_velocity, texel, dgb_out_velocity);
#endif
}

void dgb_engine_main();

void main() {
    dgb_engine_main();
#if DGB_INTERLOCK
    beginInvocationInterlockARB();
#endif
    if (dgb_draw_layer.y > 1 && dgb_kept_second) dgb_compete(1);
#if DGB_LAYERS > 2 // else a software rasteriser runs the loop's body once, for nothing
    int layer = 2;
    do {
        if (layer < dgb_draw_layer.y && dgb_kept_in(layer)) dgb_compete(layer);
    } while (++layer < DGB_LAYERS);
#endif
#if DGB_INTERLOCK
    endInvocationInterlockARB();
#endif
}
#define main dgb_engine_main
#endif
