// Reconstruction: separable bilateral filter with normal and plane weights over ambient visibility, irradiance and
// confidence together, for the second layer along its own surfaces; run along x, then along y. What the first run finds it
// leaves in one texel beside the surface that it is for, so that the second run fetches once a tap.

layout(std140) uniform dgb_reconstruct_block {
    dgb_camera dgb_reconstruct_camera;
    ivec4      dgb_reconstruct_rect;      // shaded rectangle: x0, y0, x1, y1 inclusive
    ivec4      dgb_reconstruct_axis;      // step in x, in y, taps on one side
    vec4       dgb_reconstruct_sharpness; // normal, plane
    vec4       dgb_reconstruct_weights[DGB_MAX_FILTER_RADIUS + 1];
};

struct dgb_lit { // a surface and what is known of its light
    float z;
    vec2  normal; // Oct16
    float ao;
    vec4  irradiance; // a: confidence
    vec4  bent;
};

// Two numbers from 0 to 64512 in 32 bits, each as exact as a half float: no sign, 6 bits of exponent, 10 of mantissa. Less than
// 2^-46 becomes 0, NaN too. Neither function meets a subnormal number, which implementations may flush.
uint dgb_pack(vec2 v) {
    uvec2 codes = (floatBitsToUint(v * 8.271806125530277e-25) + 0x1000u) >> 13; // 2^-80
    codes       = min(codes, 0xffffu);
    if (!(v.x >= 1.4210854715202004e-14)) codes.x = 0u; // 2^-46
    if (!(v.y >= 1.4210854715202004e-14)) codes.y = 0u;
    return codes.x | codes.y << 16;
}

vec2 dgb_unpack(uint codes) {
    return uintBitsToFloat(uvec2(codes << 13, codes >> 3) & 0x1fffe000u) * 1.2089258196146292e24; // 2^80
}

// In: what the passes before have left, then what the first run has.
#if DGB_AXIS == 0
uniform sampler2D dgb_z;
uniform sampler2D dgb_normals;
#if DGB_FILTER_AO
uniform sampler2D dgb_ao_raw;
#endif
#if DGB_BENT
uniform sampler2D dgb_bent_raw;
#endif
#if DGB_FILTER_IRRADIANCE
uniform sampler2D dgb_irradiance_raw;
#endif
#if DGB_DEEP
uniform sampler2D dgb_irradiance1_raw;
#endif

dgb_lit dgb_lit_at(int layer, ivec2 p) {
    vec2    z       = texelFetch(dgb_z, p, 0).xy;
    vec4    normals = texelFetch(dgb_normals, p, 0);
    dgb_lit s       = dgb_lit(z.x, normals.xy, 1.0, vec4(0.0), vec4(0.0));
#if DGB_FILTER_AO
    s.ao = texelFetch(dgb_ao_raw, p, 0).x;
#endif
#if DGB_BENT
    s.bent = texelFetch(dgb_bent_raw, p, 0);
#endif
#if DGB_FILTER_IRRADIANCE
    s.irradiance = texelFetch(dgb_irradiance_raw, p, 0);
#endif
#if DGB_DEEP
    if (layer == 1) s = dgb_lit(z.y, normals.zw, 1.0, texelFetch(dgb_irradiance1_raw, p, 0), vec4(0.0));
#endif
    return s;
}
#else
uniform usampler2D dgb_half;
#if DGB_DEEP
uniform usampler2D dgb_half1;
#endif
#if DGB_BENT
uniform sampler2D dgb_half_bent;
#endif

dgb_lit dgb_lit_at(int layer, ivec2 p) {
    uvec4 t = texelFetch(dgb_half, p, 0);
#if DGB_DEEP
    if (layer == 1) t = texelFetch(dgb_half1, p, 0);
#endif
    vec2 normal = vec2(t.y & 255u, (t.y >> 8) & 255u) * (1.0 / 255.0);
    vec4 bent   = vec4(0.0);
#if DGB_BENT
    bent = texelFetch(dgb_half_bent, p, 0);
#endif
    return dgb_lit(uintBitsToFloat(t.x), normal, float(t.y >> 16) * (1.0 / 65535.0), vec4(dgb_unpack(t.z), dgb_unpack(t.w)), bent);
}
#endif

// Out: z | Oct16 and, above it, ambient visibility | irradiance and confidence; then the results.
#if DGB_AXIS == 0
layout(location = 0) out uvec4 dgb_out_half;
#if DGB_DEEP
layout(location = 1) out uvec4 dgb_out_half1;
#endif
#if DGB_BENT && DGB_DEEP
layout(location = 2) out vec4 dgb_out_half_bent;
#elif DGB_BENT
layout(location = 1) out vec4 dgb_out_half_bent;
#endif

uvec4 dgb_texel(dgb_lit s) {
    uvec3 bytes = uvec3(vec3(s.normal * 255.0, s.ao * 65535.0) + 0.5);
    return uvec4(floatBitsToUint(s.z), bytes.x | bytes.y << 8 | bytes.z << 16, dgb_pack(s.irradiance.xy), dgb_pack(s.irradiance.zw));
}
#else
#if DGB_FILTER_AO
layout(location = 0) out vec4 dgb_out_ao;
#endif
#if DGB_FILTER_IRRADIANCE
layout(location = DGB_FILTER_AO) out vec4 dgb_out_irradiance;
#endif
#if DGB_DEEP && DGB_FILTER_AO
layout(location = 2) out vec4 dgb_out_irradiance1;
#elif DGB_DEEP
layout(location = 1) out vec4 dgb_out_irradiance1;
#endif
#if DGB_BENT && DGB_DEEP
layout(location = 3) out vec4 dgb_out_bent;
#elif DGB_BENT && DGB_FILTER_IRRADIANCE
layout(location = 2) out vec4 dgb_out_bent;
#elif DGB_BENT
layout(location = 1) out vec4 dgb_out_bent;
#endif
#endif

struct dgb_sums {
    float weight, ao;
    vec4  irradiance, bent;
};

void dgb_add(inout dgb_sums sums, float weight, dgb_lit s) {
    sums.weight += weight;
    sums.ao += weight * s.ao;
    sums.bent += weight * s.bent;
    sums.irradiance += vec4(s.irradiance.rgb * (weight * s.irradiance.a), weight * s.irradiance.a); // dgb_weigh
}

struct dgb_filter { // of one surface
    int        layer;
    ivec2      pixel;
    dgb_origin x;
    vec3       n;
};

// The tap at a place along the axis. nearest: the place nearest to it in the shaded rectangle; weight: by distance in the image.
void dgb_add_tap(inout dgb_sums sums, dgb_filter f, int at, int nearest, float weight) {
    ivec2   p  = DGB_AXIS == 0 ? ivec2(nearest, f.pixel.y) : ivec2(f.pixel.x, nearest);
    dgb_lit t  = dgb_lit_at(f.layer, p);
    vec3    dq = dgb_offset(dgb_centre(f.layer, p), t.z, f.x, dgb_reconstruct_camera);
    // a factor for what must not count: a select between a read and none becomes a branch
    weight *= at == nearest && t.z > DGB_EMPTY_Z ? 1.0 : 0.0;
    weight *= dgb_bilateral_weight(f.n, dgb_oct16_decode(t.normal), dq, dgb_reconstruct_sharpness.x, dgb_reconstruct_sharpness.y);
    dgb_add(sums, weight, t);
}

dgb_lit dgb_filtered(int layer, ivec2 pixel) {
    dgb_lit    s    = dgb_lit_at(layer, pixel);
    dgb_origin x    = dgb_origin_at(dgb_centre(layer, pixel), s.z, dgb_reconstruct_camera);
    dgb_filter f    = dgb_filter(layer, pixel, x, dgb_oct16_decode(s.normal));
    int        side = s.z > DGB_EMPTY_Z ? dgb_reconstruct_axis.z : 0, here = pixel[DGB_AXIS];
    dgb_sums   sums = dgb_sums(0.0, 0.0, vec4(0.0), vec4(0.0));
    dgb_add(sums, dgb_reconstruct_weights[0].x, s);
    for (int i = 1; i <= side; ++i) { // on both sides at once: i is the same for all pixels, and so is what it reads
        int   before = here - i * dgb_reconstruct_axis[DGB_AXIS], after = here + i * dgb_reconstruct_axis[DGB_AXIS];
        float weight = dgb_reconstruct_weights[i].x;
        dgb_add_tap(sums, f, before, max(before, dgb_reconstruct_rect[DGB_AXIS]), weight);
        dgb_add_tap(sums, f, after, min(after, dgb_reconstruct_rect[DGB_AXIS + 2]), weight);
    }
    vec4 irradiance = dgb_unweigh(sums.irradiance / sums.weight);
    s.ao            = sums.ao / sums.weight;
    s.bent          = sums.bent / sums.weight;
    s.irradiance    = vec4(dgb_storable(irradiance.rgb), irradiance.a);
    return s;
}

void main() {
    ivec2   pixel = ivec2(gl_FragCoord.xy);
    dgb_lit s     = dgb_filtered(0, pixel);
#if DGB_AXIS == 0
    dgb_out_half = dgb_texel(s);
#if DGB_DEEP
    dgb_out_half1 = dgb_texel(dgb_filtered(1, pixel));
#endif
#if DGB_BENT
    dgb_out_half_bent = s.bent;
#endif
#else
#if DGB_FILTER_AO
    dgb_out_ao = vec4(s.ao);
#endif
#if DGB_BENT
    dgb_out_bent = s.bent;
#endif
#if DGB_FILTER_IRRADIANCE
    dgb_out_irradiance = s.irradiance;
#endif
#if DGB_DEEP
    dgb_out_irradiance1 = dgb_filtered(1, pixel).irradiance;
#endif
#endif
}
