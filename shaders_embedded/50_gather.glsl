// Radiosity: Equations 4 and 5 of the paper over one or two layers of senders. A tap beyond the buffer finds none: with the
// border in its place, what stands there would send again and again. Deep: the second layer receives as well, from the same taps
// (section 3.3).

layout(std140) uniform dgb_gather_block {
    dgb_camera dgb_gather_camera;
    ivec4      dgb_gather_size;   // buffer width, height, taps, frame
    ivec4      dgb_gather_level;  // log2 q, min level, max level, 1: the second layer matters everywhere
    vec4       dgb_gather_radius; // r (m), r^2, normaliser k, largest reach (pixels)
    vec4       dgb_gather_first;  // x: 0 to leave out first-layer senders
    vec4       dgb_gather_taps[DGB_MAX_TAPS];
};

uniform sampler2D dgb_z;
uniform sampler2D dgb_normals;
uniform sampler2D dgb_b0;
#if DGB_LAYERS > 1
uniform sampler2D dgb_b1;
#endif

layout(location = 0) out vec4 dgb_out_irradiance;
#if DGB_DEEP
layout(location = 1) out vec4 dgb_out_irradiance1;
#endif

struct dgb_receiver {
    dgb_origin x;
    vec3       n;
    vec3       light;
    float      cosines;
    int        senders, useful_taps;
};

// A surface that a tap finds.
struct dgb_sender {
    vec2  pixel;
    float z;
    vec3  n, radiance; // n: of any length
    bool  counts;
};

// Cosine of what a sender sends; 0 when it is too far (as an empty texel is), behind, or faces away.
float dgb_received(dgb_sender s, dgb_receiver r) {
    vec3  v      = dgb_offset(s.pixel, s.z, r.x, dgb_gather_camera);
    float cosine = dgb_gather_term(v, r.n, dgb_gather_radius.y);
    bool  counts = s.counts;
#if DGB_NORMAL_TEST
    counts = counts && dot(v, s.n) < 0.0;
#endif
    return counts ? cosine : 0.0;
}

void dgb_add(inout dgb_receiver r, float cosine, vec3 light) {
    r.light += light;
    r.cosines += cosine;
    r.senders += int(cosine > 0.0);
}

#if DGB_LAYERS > 1
void dgb_receive(inout dgb_receiver r, dgb_sender s0, dgb_sender s1) {
    float c0 = dgb_received(s0, r), c1 = dgb_received(s1, r);
    vec3  l0 = s0.radiance * c0, l1 = s1.radiance * c1;
    r.useful_taps += int(c0 > 0.0 || c1 > 0.0);
#if DGB_STRONGEST_SENDER
    bool first = c1 == 0.0 || (c0 > 0.0 && dot(l0, vec3(1.0)) >= dot(l1, vec3(1.0)));
    dgb_add(r, first ? c0 : c1, first ? l0 : l1);
#else
    dgb_add(r, c0, l0);
    dgb_add(r, c1, l1);
#endif
}
#endif

void dgb_receive(inout dgb_receiver r, dgb_sender s) {
    float cosine = dgb_received(s, r);
    r.useful_taps += int(cosine > 0.0);
    dgb_add(r, cosine, s.radiance * cosine);
}

dgb_receiver dgb_receiver_at(vec2 pixel, float z, vec2 normal) {
    dgb_receiver r;
    r.x       = dgb_origin_at(pixel, z, dgb_gather_camera);
    r.n       = dgb_oct16_decode(normal);
    r.light   = vec3(0.0);
    r.cosines = 0.0;
    r.senders = r.useful_taps = 0;
    return r;
}

dgb_sender dgb_sender_at(vec2 pixel, float z, vec2 normal, vec3 radiance, bool counts) {
    dgb_sender s;
    s.pixel = pixel;
    s.z     = z;
#if DGB_NORMAL_TEST
    s.n = dgb_oct16_direction(normal);
#endif
    s.radiance = radiance;
    s.counts   = counts;
    return s;
}

float dgb_gather_reach(float z) { return dgb_reach(z, dgb_gather_radius.x, dgb_gather_radius.w, dgb_gather_camera); }

// taps: that lie within the receiver's own reach.
vec4 dgb_irradiance(dgb_receiver r, float taps) {
    vec3 irradiance = r.light * dgb_gather_scale(r.cosines, float(r.senders), dgb_gather_radius.z);
    return vec4(dgb_storable(irradiance), taps > 0.0 ? min(float(r.useful_taps) / taps, 1.0) : 0.0);
}

struct dgb_shaded {
    ivec2      pixel;
    dgb_spiral spiral;
};

// What tap i finds, for the first layer's receiver and, if `deep`, the second's. second: look at second-layer senders. Both are
// constant wherever this is called.
void dgb_gather_tap(int i, dgb_shaded s, bool second, bool deep, inout dgb_receiver r0, inout dgb_receiver r1) {
    dgb_tap tap    = dgb_tap_at(dgb_gather_taps[i], s.spiral, dgb_gather_level);
    // the shaded surface sends itself nothing anyway, but those behind one another at the pixel might
    bool    counts = tap.inside && (!second || tap.pixel != s.pixel);
    vec2    zs     = texelFetch(dgb_z, tap.texel, tap.level).xy;
    vec3    b0     = texelFetch(dgb_b0, tap.texel, tap.level).rgb;
#if DGB_NORMAL_TEST
    vec4 ns = texelFetch(dgb_normals, tap.texel, tap.level);
#else
    vec4 ns = vec4(0.0);
#endif
    dgb_sender s0 = dgb_sender_at(vec2(tap.pixel) + 0.5, zs.x, ns.xy, b0, counts && dgb_gather_first.x != 0.0);
#if DGB_LAYERS > 1
    if (second) {
        vec3       b1 = texelFetch(dgb_b1, tap.texel, tap.level).rgb;
        dgb_sender s1 = dgb_sender_at(dgb_centre(1, tap.pixel), zs.y, ns.zw, b1, counts);
        dgb_receive(r0, s0, s1);
        if (deep) dgb_receive(r1, s0, s1);
        return;
    }
#endif
    dgb_receive(r0, s0);
}

void main() {
    dgb_shaded s;
    s.pixel              = ivec2(gl_FragCoord.xy);
    vec2         z       = texelFetch(dgb_z, s.pixel, 0).xy;
    vec4         normals = texelFetch(dgb_normals, s.pixel, 0);
    dgb_receiver r0      = dgb_receiver_at(gl_FragCoord.xy, z.x, normals.xy), r1 = r0;
    float        reach   = dgb_gather_reach(z.x);
    s.spiral             = dgb_spiral_at(gl_FragCoord.xy, reach, dgb_gather_size);
    int taps             = z.x > DGB_EMPTY_Z && reach > 0.0 ? dgb_gather_size.z : 0;
#if DGB_LAYERS > 1
    // loops, not branches: every processor skips a loop that it does not run
    bvec3 tile = dgb_tile_at(s.pixel, dgb_gather_level.w != 0);
    bool  deep = false;
#if DGB_DEEP
    deep = tile.z;
    if (deep) r1 = dgb_receiver_at(dgb_centre(1, s.pixel), z.y, normals.zw);
    for (int i = 0; i < (deep ? taps : 0); ++i) dgb_gather_tap(i, s, true, true, r0, r1);
#endif
    for (int i = 0; i < (!deep && tile.y ? taps : 0); ++i) dgb_gather_tap(i, s, true, false, r0, r1);
    for (int i = 0; i < (!deep && !tile.y ? taps : 0); ++i) dgb_gather_tap(i, s, false, false, r0, r1);
#else
    for (int i = 0; i < taps; ++i) dgb_gather_tap(i, s, false, false, r0, r1);
#endif
    dgb_out_irradiance = dgb_irradiance(r0, float(taps));
#if DGB_DEEP
    // taps go out evenly; those beyond the second layer's reach, which is shorter, could not have found anything for it
    float within        = float(taps) * dgb_gather_reach(z.y) / reach;
    dgb_out_irradiance1 = taps > 0 && z.y > DGB_EMPTY_Z ? dgb_irradiance(r1, max(within, 1.0)) : vec4(0.0);
#endif
}
