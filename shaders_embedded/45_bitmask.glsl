// Visibility bitmask: ambient visibility, or irradiance, by the share of the cosine-weighted hemisphere that each surface covers
// (Therrien et al. 2023), here of two layers. Slices are marched from near to far:
// each of a slice's 32 sectors is a ray of the hemisphere, stopped by the first step that finds something in its way. Where normals
// are read, a surface stands for the whole step around it, along its plane: else light would leak between steps that are longer
// than surfaces are thick. What lies beyond the buffer is not known, and counts as open.

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
    ivec2      pixel;
    dgb_spiral around;  // of the taps
    vec3       x, n, v; // v: towards the eye
    vec2       side;    // metres between pixels at its depth
    vec4       noise;   // angle of the slice, of the steps, height of the slice, of the sectors; 0..1
};

struct dgb_march { // along one slice
    vec4 slice;
    vec3 scale;          // of its shares
    vec3 d;              // across the line of sight, unit
    vec3 towards, along; // a point of the slice from an offset: oblique, so that it keeps its height above the receiver's plane
    vec2 direction;      // in the image
    uint seen;           // sectors that are covered
    vec3 light;          // sum over sectors: of what they see, or, for DGB_BENT, of the directions of those that are covered
};

// Points of the line of sight at depth x.z + s are at (offset + slope s, s) from x; in the slice, {towards the eye, along}, at
// q.xy + q.zw s.
struct dgb_sight {
    vec2 offset, slope;
    vec4 q;
};

struct dgb_surface {
    float s, thickness; // depth from x.z on, m
    vec3  n;            // of any length; 0 where it is not read
};

dgb_receiver dgb_receiver_at(int layer, ivec2 pixel, float z, vec2 normal) {
    vec4         a     = dgb_bitmask_camera.position_z, b = dgb_bitmask_camera.position_1;
    vec2         at    = dgb_centre(layer, pixel);
    float        reach = min(dgb_pixels_per_metre(z, dgb_bitmask_camera) * dgb_bitmask_radius.x, dgb_bitmask_radius.w);
    dgb_receiver r;
    r.pixel  = pixel;
    r.around = dgb_spiral_at(at, reach, dgb_bitmask_size);
    r.x      = dgb_position(at, z, dgb_bitmask_camera);
    r.n      = dgb_oct16_decode(normal);
    r.v      = -dgb_view(r.x, dgb_bitmask_camera);
    r.side   = a.xy * z + b.xy;
    r.noise  = dgb_pixel_quad(pixel, dgb_bitmask_size.w);
    return r;
}

// Slice i: a direction of the cosine-weighted hemisphere picks it, so all slices weigh alike. shift: i of all, 0..1
dgb_march dgb_march_at(dgb_receiver r, float shift) {
    vec4  noise    = fract(r.noise + shift);
    vec2  rotation = texelFetch(dgb_rotations, ivec2(noise.x * 256.0, 0), 0).xy;
    float height   = 1.0 - 2.0 * noise.z;
    vec3  d        = dgb_slice_along(r.n, r.v, vec3(rotation * sqrt(1.0 - height * height), height));
    vec3  across   = cross(d, r.v);
    vec2  plane    = vec2(max(dot(r.n, r.v), 0.0), dot(r.n, d));
    vec2  oblique  = plane * (dot(r.n, across) / max(dot(plane, plane), 1e-4));
    vec4  a        = dgb_bitmask_camera.position_z;
    vec2  moved    = (d.xy - (r.around.centre * a.xy + a.zw) * d.z) / r.side; // pixels a metre along d
    dgb_march m;
    m.slice     = dgb_slice(r.n, r.v, d);
    m.scale     = dgb_slice_scale(m.slice);
    m.d         = d;
    m.towards   = r.v + oblique.x * across;
    m.along     = d + oblique.y * across;
    m.direction = moved * inversesqrt(max(dot(moved, moved), 1e-30));
    m.seen      = 0u;
    m.light     = vec3(0.0);
    return m;
}

// How a sight, or what changes one, lies in the slice.
dgb_sight dgb_sight_of(vec2 offset, vec2 slope, dgb_march m) {
    vec4 q = vec4(dot(offset, m.towards.xy), dot(offset, m.along.xy), dot(slope, m.towards.xy), dot(slope, m.along.xy));
    return dgb_sight(offset, slope, q);
}

dgb_sight dgb_sight_at(vec2 at, dgb_receiver r, dgb_march m) {
    vec4      a = dgb_bitmask_camera.position_z;
    dgb_sight l = dgb_sight_of((at - r.around.centre) * r.side, at * a.xy + a.zw, m);
    l.q.zw += vec2(m.towards.z, m.along.z);
    return l;
}

#if DGB_NORMAL_TEST
float dgb_facing(dgb_sight l, dgb_surface y) { return dot(y.n, vec3(l.slope, 1.0)); }

// Versines of where the sight so many pixels on enters a surface, if its plane goes on that far, and leaves it. on: a pixel's change
vec2 dgb_ends_beside(dgb_sight l, dgb_sight on, dgb_surface y, float pixels) {
    vec4  q      = l.q + pixels * on.q;
    float facing = dgb_facing(l, y), turned = facing + pixels * dot(y.n.xy, on.slope), r = dgb_bitmask_radius.x;
    float s      = (facing * y.s - pixels * dot(y.n.xy, on.offset)) / turned;
    vec2  front  = q.xy + (turned > 0.0 ? clamp(s, -r, r) : -r) * q.zw;
    return vec2(dgb_versine(front), dgb_versine(front - y.thickness * q.zw));
}
#endif

// Sectors that a surface covers with what is behind it, if either end is within the radius. step: pixels that it stands for, before
// and after it; u: of the sectors
uint dgb_covered(dgb_receiver r, dgb_march m, dgb_sight l, dgb_surface y, vec2 step, float u) {
    vec2 front = l.q.xy + y.s * l.q.zw, back = front - y.thickness * l.q.zw;
#if DGB_NORMAL_TEST
    dgb_sight on   = dgb_sight_of(m.direction * r.side, m.direction * dgb_bitmask_camera.position_z.xy, m);
    vec2      a    = dgb_ends_beside(l, on, y, -step.x), b = dgb_ends_beside(l, on, y, step.y);
    vec2      ends = vec2(min(a.x, b.x), max(a.y, b.y));
#else
    vec2 ends = vec2(dgb_versine(front), dgb_versine(back));
#endif
    bool there = min(dgb_square(front), dgb_square(back)) <= dgb_bitmask_radius.y;
    return there ? dgb_sectors(dgb_share(m.scale, ends.x), dgb_share(m.scale, ends.y), u) : 0u;
}

// Takes what a surface covers of what is still open; radiance: what it sends, if it faces the receiver.
void dgb_stop(inout dgb_march m, uint covered, dgb_sight l, dgb_surface y, vec3 radiance) {
    uint stopped = covered & ~m.seen;
    m.seen |= covered;
#if DGB_NORMAL_TEST
    if (!(dgb_facing(l, y) * y.s + dot(y.n.xy, l.offset) < 0.0)) radiance = vec3(0.0);
#endif
#if DGB_BITMASK_LIGHT
    m.light += radiance * float(dgb_sector_count(stopped));
#endif
}

// One step, h pixels away, that stands for `pitch` pixels. second: look at the second layer
void dgb_step(dgb_receiver r, inout dgb_march m, float h, float pitch, float u, bool second) {
    dgb_tap tap   = dgb_tap_beside(m.direction, h, r.around, dgb_bitmask_level);
    vec2    step  = 0.5 * vec2(min(pitch, h), pitch); // not back to x itself, where errors of the plane would hide everything
    bool    known = tap.inside && tap.pixel != r.pixel;

    vec4        zs = texelFetch(dgb_z, tap.texel, tap.level);
    vec2        thickness = dgb_thickness_of(zs, dgb_bitmask_radius.z);
    vec3        b0 = vec3(0.0), b1 = vec3(0.0);
    dgb_sight   l  = dgb_sight_at(vec2(tap.pixel) + 0.5, r, m);
    dgb_surface y  = dgb_surface(zs.x - r.x.z, thickness.x, vec3(0.0));
#if DGB_NORMAL_TEST
    vec4 normals = texelFetch(dgb_normals, tap.texel, tap.level);
    y.n          = dgb_oct16_direction(normals.xy);
#endif
#if DGB_BITMASK_LIGHT
    b0 = texelFetch(dgb_b0, tap.texel, tap.level).rgb;
#endif
    uint covered = dgb_covered(r, m, l, y, step, u);
    dgb_stop(m, known && dgb_bitmask_scale.w > 0.0 ? covered : 0u, l, y, b0);
#if DGB_LAYERS > 1
    if (second) {
#if DGB_DIVISOR > 1
        l = dgb_sight_at(dgb_centre(1, tap.pixel), r, m);
#endif
        y = dgb_surface(zs.y - r.x.z, thickness.y, vec3(0.0));
#if DGB_NORMAL_TEST
        y.n = dgb_oct16_direction(normals.zw);
#endif
#if DGB_BITMASK_LIGHT
        b1 = texelFetch(dgb_b1, tap.texel, tap.level).rgb;
#endif
        covered = dgb_covered(r, m, l, y, step, u);
        dgb_stop(m, known ? covered : 0u, l, y, b1);
    }
#endif
}

// Means over all slices. rgb: irradiance over pi, or covered directions; a: share of the cosine-weighted hemisphere that is covered.
vec4 dgb_look(dgb_receiver r, bool there, bool second) {
    int   steps = dgb_bitmask_size.z;
    float pair  = 0.5 * dgb_bitmask_scale.y, pitch = r.around.reach / float(steps);
    vec4  sum   = vec4(0.0);
    for (int i = 0; i < (there ? 2 * int(dgb_bitmask_scale.x) : 0); ++i) {
        float     shift  = float(i) * pair;
        dgb_march m      = dgb_march_at(r, shift);
        vec2      jitter = fract(r.noise.yw + shift);
        for (int k = 0; k < steps; ++k) dgb_step(r, m, max((float(k) + jitter.x) * pitch, 0.75), pitch, jitter.y, second);
#if DGB_BENT
        vec2 covered = 32.0 * dgb_sectors_mean(m.slice, m.seen);
        m.light      = covered.x * r.v + covered.y * m.d;
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
