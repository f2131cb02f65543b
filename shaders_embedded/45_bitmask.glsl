// Visibility bitmask: ambient visibility, or irradiance, by the share of the cosine-weighted hemisphere that each surface
// covers (Therrien et al. 2023), here of two layers. Slices are marched from near to far: each of a slice's 32 sectors is a
// ray of the hemisphere, stopped by the first step that finds something in its way. Where normals are read, a surface stands
// for the whole step around it, along its plane: else light would leak between steps that are longer than surfaces are
// thick. What lies beyond the buffer is not known, and counts as open.

layout(std140) uniform dgb_bitmask_block {
    dgb_camera dgb_bitmask_camera;
    ivec4      dgb_bitmask_size;   // buffer width, height, steps of a slice, frame
    ivec4      dgb_bitmask_level;  // log2 q, min level, max level, 1: the second layer matters everywhere
    vec4       dgb_bitmask_radius; // r (m), r^2, thickness (m), largest reach (pixels)
    vec4       dgb_bitmask_scale;  // slices, 1 / slices, exponent of visibility, 0 to leave out the first layer
    vec4       dgb_bitmask_world[3]; // camera to world, columns
};

uniform sampler2D dgb_z;
uniform sampler2D dgb_normals;
#if DGB_BITMASK_LIGHT
uniform sampler2D dgb_b0;
#if DGB_LAYERS > 1
uniform sampler2D dgb_b1;
#endif
layout(location = 0) out vec4 dgb_out_irradiance;
#if DGB_DEEP
layout(location = 1) out vec4 dgb_out_irradiance1;
#endif
#else
layout(location = 0) out vec4 dgb_out_ao;
#if DGB_BENT
layout(location = 1) out vec4 dgb_out_bent;
#endif
#endif

struct dgb_receiver {
    vec2  centre;  // of its pixel
    float z;
    vec3  n;
    vec2  side;    // metres between pixels at depth z
    float spread;  // at depth z + s they are 1 + spread s times as far apart
    vec3  sight;   // the pixel's line of sight, towards the eye by the metre of depth
    float stretch; // its length
    vec2  within;  // depths that are within the radius, as dgb_ends_beside takes them
    float pitch;   // pixels between steps
    vec4  noise;   // angle of the slice, of the steps, height of the slice, of the sectors; 0..1
};

struct dgb_march { // along one slice
    vec4  slice, scale; // scale: of its sectors
    vec3  d;            // across the line of sight, unit
    mat2  plane;        // {towards the eye, along d} of pixels at depth z: oblique, it keeps heights above the receiver's plane
    vec2  direction;    // in the image
    float room;         // pixels to the border
    float half_step;    // half a step, m along d; a metre along d, at depth z:
    vec2  aside;        //     in the image, m
    float towards;      //     towards the eye, m
    uint  seen;         // sectors that are covered
    vec3  light;        // sum over sectors: of what they see, or, for DGB_BENT, of the directions of those that are covered
};

// The line of sight of another pixel. Its point at depth z + s lies in the slice at q.xy + s q.zw, {towards the eye, along d}.
struct dgb_sight {
    vec2 offset; // of the pixel, m at depth z
    vec4 q;
};

struct dgb_surface {
    float s, thickness; // depth from z on, m
    vec3  n;            // of any length; 0 where it is not read
};

dgb_receiver dgb_receiver_at(int layer, ivec2 pixel, float z, vec2 normal) {
    vec4         a = dgb_bitmask_camera.position_z, b = dgb_bitmask_camera.position_1;
    float        reach = dgb_reach(z, dgb_bitmask_radius.x, dgb_bitmask_radius.w, dgb_bitmask_camera);
    dgb_receiver r;
    r.centre  = dgb_centre(layer, pixel);
    r.z       = z;
    r.n       = dgb_oct16_decode(normal);
    r.side    = a.xy * z + b.xy;
    r.spread  = a.x / r.side.x;
    r.sight   = vec3(r.centre * a.xy + a.zw, 1.0);
    r.stretch = length(r.sight);
    r.within  = vec2(-1.0, 1.0) / max(1.0 / dgb_bitmask_radius.x + r.spread * vec2(-1.0, 1.0), 1e-6);
    r.pitch   = reach / float(dgb_bitmask_size.z);
    r.noise   = dgb_pixel_quad(pixel, dgb_bitmask_size.w);
    return r;
}

vec3 dgb_towards_eye(dgb_receiver r) { return r.sight / r.stretch; } // unit

// Slice i: a direction of the cosine-weighted hemisphere picks it, so all slices weigh alike. shift: i of all, 0..1
dgb_march dgb_march_at(dgb_receiver r, float shift) {
    vec4  noise    = fract(r.noise + shift);
    vec2  rotation = texelFetch(dgb_rotations, ivec2(noise.x * 256.0, 0), 0).xy;
    float height   = 1.0 - 2.0 * noise.z;
    vec3  v        = dgb_towards_eye(r);
    vec3  d        = dgb_slice_along(r.n, v, vec3(rotation * sqrt(1.0 - height * height), height));
    vec3  across   = cross(d, v);
    vec2  normal   = vec2(max(dot(r.n, v), 0.0), dot(r.n, d)); // in the slice
    vec2  oblique  = normal * (dot(r.n, across) / max(dot(normal, normal), 1e-4));
    vec2  towards  = r.side * (v.xy + oblique.x * across.xy), along = r.side * (d.xy + oblique.y * across.xy);
    vec2  aside    = d.xy - r.sight.xy * d.z, pixels = aside / r.side; // a metre along d
    float metre    = inversesqrt(max(dot(pixels, pixels), 1e-30)); // by the pixel
    dgb_march m;
    m.slice     = dgb_slice(r.n, v, d);
    m.scale     = dgb_slice_scale(m.slice, 32.0);
    m.d         = d;
    m.plane     = mat2(towards.x, along.x, towards.y, along.y);
    m.direction = pixels * metre;
    m.room      = dgb_room(r.centre, m.direction, vec2(dgb_bitmask_size.xy));
    m.half_step = 0.5 * r.pitch * metre;
    m.aside     = aside;
    m.towards   = -r.stretch * d.z;
    m.seen      = 0u;
    m.light     = vec3(0.0);
    return m;
}

// pixels: from the receiver's
dgb_sight dgb_sight_of(vec2 pixels, dgb_receiver r, dgb_march m) {
    vec2 q = m.plane * pixels;
    return dgb_sight(r.side * pixels, vec4(q, r.spread * q + vec2(r.stretch, 0.0)));
}

#if DGB_NORMAL_TEST
float dgb_facing(dgb_receiver r, dgb_sight l, dgb_surface y) { return dot(y.n, r.sight) + r.spread * dot(y.n.xy, l.offset); }

// Cotangents of where the sight so many metres on along d enters a surface, if its plane goes on that far, and leaves it.
// plane: its depth at l, and by the metre. Depths are s / (1 + spread s): in these, planes are linear, and so are cotangents.
vec2 dgb_ends_beside(dgb_receiver r, dgb_march m, dgb_sight l, vec2 plane, float thickness, float on) {
    float front     = clamp(plane.x + on * plane.y, r.within.x, r.within.y);
    float behind    = thickness * (1.0 - r.spread * front);
    float back      = (front - behind) / (1.0 - r.spread * behind);
    vec2  q         = l.q.xy + on * vec2(m.towards, 1.0);
    vec2  cotangent = q.y > 0.0 ? vec2(q.x, r.stretch) * (1.0 / q.y) : vec2(-1e9, 0.0); // beyond x: below every horizon
    return cotangent.x + cotangent.y * vec2(front, back);
}

// Versines of where a surface begins and ends, with what it stands for: half a step on, and back, but not to x itself, where
// errors of the plane would hide everything. What is seen from behind lies as far away as can be. k: steps from x
vec2 dgb_ends(dgb_receiver r, dgb_march m, dgb_sight l, dgb_surface y, float k) {
    float facing = dgb_facing(r, l, y), inverse = 1.0 / (1.0 + r.spread * y.s);
    vec2  plane  = facing > 0.0 ? inverse * vec2(y.s, -dot(y.n.xy, m.aside) / facing) : vec2(r.within.x, 0.0);
    vec2  a      = dgb_ends_beside(r, m, l, plane, y.thickness, -m.half_step * min(k, 1.0));
    vec2  b      = dgb_ends_beside(r, m, l, plane, y.thickness, m.half_step);
    return vec2(dgb_versine(vec2(max(a.x, b.x), 1.0)), dgb_versine(vec2(min(a.y, b.y), 1.0)));
}
#endif

// Whether a sight may tell of the slice: it is not the receiver's own, and does not pass x on the other side, though where
// normals are read what it stands for may reach into the slice all the same.
bool dgb_known(dgb_sight l) {
#if DGB_NORMAL_TEST
    return l.q.y != 0.0;
#else
    return l.q.y > 0.0;
#endif
}

// Sectors that a surface covers with what is behind it, if either end is within the radius. k: steps from x; u: of the sectors
uint dgb_covered(dgb_receiver r, dgb_march m, dgb_sight l, dgb_surface y, float k, float u) {
    vec2 front = l.q.xy + y.s * l.q.zw, back = front - y.thickness * l.q.zw;
#if DGB_NORMAL_TEST
    vec2 ends = dgb_ends(r, m, l, y, k);
#else
    vec2 ends = vec2(dgb_versine(front), dgb_versine(back));
#endif
    uint covered = dgb_sectors_between(dgb_share(m.scale, ends.x), dgb_share(m.scale, ends.y), u);
    return min(dot(front, front), dot(back, back)) <= dgb_bitmask_radius.y ? covered : 0u;
}

// Takes what a surface covers of what is still open; radiance: what it sends, if it faces the receiver.
void dgb_stop(inout dgb_march m, uint covered, dgb_receiver r, dgb_sight l, dgb_surface y, vec3 radiance) {
    uint seen = m.seen | covered, stopped = seen ^ m.seen;
    m.seen = seen;
#if DGB_NORMAL_TEST
    if (!(dgb_facing(r, l, y) * y.s + dot(y.n.xy, l.offset) < 0.0)) stopped = 0u;
#endif
#if DGB_BITMASK_LIGHT
    m.light += radiance * float(dgb_sector_count(stopped));
#endif
}

// The step k, counted from x. second: look at the second layer
void dgb_step(dgb_receiver r, inout dgb_march m, float k, float u, bool second) {
    float       h   = max(k * r.pitch, 0.75); // nearer taps would land on the shaded pixel itself
    dgb_tap     tap = dgb_tap_of(r.centre + h * m.direction, h, dgb_bitmask_size.xy, dgb_bitmask_level);
    vec4        zs = texelFetch(dgb_z, tap.texel, tap.level);
    vec2        thickness = dgb_thickness_of(zs, dgb_bitmask_radius.z);
    vec3        b0 = vec3(0.0), b1 = vec3(0.0);
    dgb_sight   l  = dgb_sight_of(vec2(tap.pixel) + 0.5 - r.centre, r, m);
    dgb_surface y  = dgb_surface(zs.x - r.z, thickness.x, vec3(0.0));
    bool        known = dgb_known(l);
#if DGB_NORMAL_TEST
    vec4 normals = texelFetch(dgb_normals, tap.texel, tap.level);
    y.n          = dgb_oct16_direction(normals.xy);
#endif
#if DGB_BITMASK_LIGHT
    b0 = texelFetch(dgb_b0, tap.texel, tap.level).rgb;
#endif
    uint covered = dgb_covered(r, m, l, y, k, u);
    dgb_stop(m, dgb_bitmask_scale.w > 0.0 && known ? covered : 0u, r, l, y, b0);
#if DGB_LAYERS > 1
    if (second) {
#if DGB_DIVISOR > 1
        l     = dgb_sight_of(dgb_centre(1, tap.pixel) - r.centre, r, m);
        known = dgb_known(l);
#endif
        y = dgb_surface(zs.y - r.z, thickness.y, vec3(0.0));
#if DGB_NORMAL_TEST
        y.n = dgb_oct16_direction(normals.zw);
#endif
#if DGB_BITMASK_LIGHT
        b1 = texelFetch(dgb_b1, tap.texel, tap.level).rgb;
#endif
        covered = dgb_covered(r, m, l, y, k, u);
        dgb_stop(m, known ? covered : 0u, r, l, y, b1);
    }
#endif
}

// Means over all slices. rgb: irradiance over pi, or covered directions; a: share of the cosine-weighted hemisphere that is covered.
vec4 dgb_look(dgb_receiver r, bool there, bool second) {
    float steps = float(dgb_bitmask_size.z), pair = 0.5 * dgb_bitmask_scale.y;
    vec4  sum   = vec4(0.0);
    for (int i = 0; i < (there ? 2 * int(dgb_bitmask_scale.x) : 0); ++i) {
        float     shift  = float(i) * pair;
        dgb_march m      = dgb_march_at(r, shift);
        vec2      jitter = fract(r.noise.yw + shift);
        float     last   = min(steps, m.room / r.pitch);
        for (float k = jitter.x; k < last; k += 1.0) dgb_step(r, m, k, jitter.y, second);
#if DGB_BENT
        vec2 covered = 32.0 * dgb_sectors_mean(m.slice, m.seen);
        m.light      = covered.x * dgb_towards_eye(r) + covered.y * m.d;
#endif
        sum += vec4(m.light, float(dgb_sector_count(m.seen)));
    }
    return sum * (pair / 32.0);
}

#if DGB_BITMASK_LIGHT
// Irradiance of what is covered as if it covered all, and how much it covers: their product is what arrives.
vec4 dgb_irradiance(vec4 look) { return vec4(look.a > 0.0 ? dgb_storable(DGB_PI * look.rgb / look.a) : vec3(0.0), look.a); }
#endif

#if DGB_BENT
// Mean of the open directions in world space, weighted by the cosine, and their share. What is covered is taken from the whole,
// 2/3 of the normal: where nothing is, there is no noise.
vec4 dgb_bent(dgb_receiver r, vec4 look) {
    vec3 bent = 2.0 / 3.0 * r.n - look.rgb;
    vec3 world = bent.x * dgb_bitmask_world[0].xyz + bent.y * dgb_bitmask_world[1].xyz + bent.z * dgb_bitmask_world[2].xyz;
    return dgb_storable_unit(vec4(world, 1.0 - look.a)); // too near to the eye, there is no direction to it
}
#endif

void main() {
    ivec2        pixel   = ivec2(gl_FragCoord.xy);
    vec2         z       = texelFetch(dgb_z, pixel, 0).xy;
    vec4         normals = texelFetch(dgb_normals, pixel, 0);
    bvec3        tile    = bvec3(false);
#if DGB_LAYERS > 1
    tile = dgb_tile_at(pixel, dgb_bitmask_level.w != 0);
#endif
    dgb_receiver r = dgb_receiver_at(0, pixel, z.x, normals.xy);
#if DGB_BITMASK_LIGHT
    dgb_out_irradiance = dgb_irradiance(dgb_look(r, z.x > DGB_EMPTY_Z, tile.y));
#if DGB_DEEP
    r                   = dgb_receiver_at(1, pixel, z.y, normals.zw);
    dgb_out_irradiance1 = dgb_irradiance(dgb_look(r, z.x > DGB_EMPTY_Z && z.y > DGB_EMPTY_Z && tile.z, true));
#endif
#else
    vec4  look       = dgb_look(r, z.x > DGB_EMPTY_Z, tile.x);
    float visibility = 1.0 - look.a;
    dgb_out_ao       = vec4(dgb_bitmask_scale.z == 1.0 ? visibility : pow(visibility, dgb_bitmask_scale.z));
#if DGB_BENT
    dgb_out_bent = z.x > DGB_EMPTY_Z ? dgb_bent(r, look) : vec4(0.0, 0.0, 0.0, 1.0);
#endif
#endif
}
