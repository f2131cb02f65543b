// Reflections: the reflected ray marched through the image, perspective-correct, against both layers. A hit is a ray that
// comes to lie behind a surface by no more than its thickness; everything else is a miss, which the engine fills from its
// environment map.

layout(std140) uniform dgb_reflect_block {
    dgb_camera dgb_reflect_camera;
    ivec4      dgb_reflect_size; // buffer width, height, most steps, frame
    ivec4      dgb_reflect_rect; // where there is irradiance: x0, y0, x1, y1 inclusive
    vec4       dgb_reflect_ray;  // longest (m), thickness of a surface (m), pixels a step, z of the near plane (m)
    vec4       dgb_reflect_fade; // width of the border where confidence fades (pixels)
    ivec4      dgb_reflect_skip; // log2 of the most steps skipped at once, of the least power of two >= pixels a step
};

uniform sampler2D dgb_z;
uniform sampler2D dgb_normals;
uniform sampler2D dgb_b0;
#if DGB_LAYERS > 1
uniform sampler2D dgb_b1;
#endif
#if DGB_HIERARCHICAL
uniform sampler2D dgb_ranges;
#endif
#if DGB_INDIRECT
uniform sampler2D dgb_irradiance;
#if DGB_LAYERS > 1
uniform sampler2D dgb_irradiance1;
#endif
#endif

layout(location = 0) out vec4 dgb_out_reflection; // radiance, confidence
layout(location = 1) out vec4 dgb_out_hit;        // layer + 1, 0 for none; length of the ray (m); glossy: its direction

// A ray in the image: pixel, z / w and 1 / w are linear along it.
struct dgb_ray {
    vec3  x, n, direction;
    vec2  pixel, pixels;  // first, and from first to last
    vec2  depth, depths;  // z / w and 1 / w likewise
    float step;           // share of the way that a step goes
    int   steps;          // 0: there is nothing to march
};

float dgb_clip_w(float z, dgb_camera camera) { return camera.footprint.y * z + camera.footprint.z; }

vec2 dgb_ray_pixel(dgb_ray ray, float s) { return ray.pixel + s * ray.pixels; }

float dgb_ray_z(dgb_ray ray, float s) {
    vec2 d = ray.depth + s * ray.depths;
    return d.x / d.y;
}

// Share of the way from a to b at which a coordinate leaves low..high; 1 if it does not.
float dgb_leaves(float a, float b, float low, float high) {
    float bound = b > a ? high : low;
    return b != a ? min(max((bound - a) / (b - a), 0.0), 1.0) : 1.0;
}

dgb_ray dgb_ray_of(vec3 from, vec3 n, vec3 direction) {
    dgb_camera camera = dgb_reflect_camera;
    vec2       high   = vec2(dgb_reflect_size.xy);
    float      reach  = dgb_reflect_ray.x;
    // towards the eye a ray ends at the near plane
    if (direction.z > 0.0) reach = min(reach, (dgb_reflect_ray.w - from.z) / direction.z);
    vec3    to = from + max(reach, 0.0) * direction;
    float   k0 = 1.0 / dgb_clip_w(from.z, camera), k1 = 1.0 / dgb_clip_w(to.z, camera);
    dgb_ray ray;
    ray.x         = from;
    ray.n         = n;
    ray.direction = direction;
    ray.pixel  = dgb_project(from, camera);
    ray.pixels = dgb_project(to, camera) - ray.pixel;
    ray.depth  = vec2(from.z * k0, k0);
    ray.depths = vec2(to.z * k1, k1) - ray.depth;
    // and everywhere at the border of the buffer
    float inside = min(dgb_leaves(ray.pixel.x, ray.pixel.x + ray.pixels.x, 0.0, high.x),
                       dgb_leaves(ray.pixel.y, ray.pixel.y + ray.pixels.y, 0.0, high.y));
    ray.pixels *= inside;
    ray.depths *= inside;
    float pixels = max(abs(ray.pixels.x), abs(ray.pixels.y));
    // a ray in the plane of its surface, within the error of an Oct16 normal, or behind it is none, and NaN is no ray either
    bool  valid  = from.z > DGB_EMPTY_Z && reach > 0.0 && pixels < 1e6 && dot(direction, n) > DGB_MIN_COSINE;
    ray.step     = valid && pixels > 0.0 ? dgb_reflect_ray.z / pixels : 1.0;
    // the first step is a part of one, so that it takes one more to reach the end
    ray.steps    = valid ? min(int(ceil(1.0 / ray.step)) + 1, dgb_reflect_size.z) : 0;
    return ray;
}

// Whether the ray, at z now and at z_before one step ago, lies behind a surface within its thickness.
bool dgb_is_behind(float z, float z_before, float surface, float thickness) {
    return surface > DGB_EMPTY_Z && z <= surface && max(z, z_before) >= surface - thickness;
}

// Whether the ray's own surface could not reach there: else a flat mirror sees itself in stripes. The shaded pixel itself never
// is above, on either layer.
bool dgb_is_above(vec2 pixel, float z, dgb_ray ray) {
    vec3 v = dgb_position(pixel, z, dgb_reflect_camera) - ray.x;
    return dot(v, ray.n) > DGB_MIN_COSINE * length(v);
}

// Where step i ends. Before the first lies the beginning.
float dgb_step_end(dgb_ray ray, float jitter, int i) { return clamp((float(i) + jitter) * ray.step, 0.0, 1.0); }

const int DGB_REFLECT_HALVINGS = 4; // of a step, once something is hit

int dgb_lookups = 0; // texels that the march has read; only benchmarks look at it

struct dgb_hit {
    int   layer; // -1: none
    float s;     // share of the way
    ivec2 texel;
    float depth; // behind the surface when the ray came there, as a share of the thickness; 0: it came from before it
};

dgb_hit dgb_hit_at(dgb_ray ray, float s, float z_before) {
    float   z = dgb_ray_z(ray, s), nearest = max(z, z_before);
    dgb_hit hit;
    hit.s     = s;
    hit.texel = clamp(ivec2(dgb_ray_pixel(ray, s)), ivec2(0), dgb_reflect_size.xy - 1);
    vec4 zs        = texelFetch(dgb_z, hit.texel, 0);
    vec2 thickness = dgb_thickness_of(zs, dgb_reflect_ray.y);
    ++dgb_lookups;
    bool first = dgb_is_behind(z, z_before, zs.x, thickness.x) && dgb_is_above(dgb_centre(0, hit.texel), zs.x, ray), second = false;
#if DGB_LAYERS > 1
    second = dgb_is_behind(z, z_before, zs.y, thickness.y) && dgb_is_above(dgb_centre(1, hit.texel), zs.y, ray);
#endif
    hit.layer = first ? 0 : second ? 1 : -1;
    hit.depth = max(first ? (zs.x - nearest) / thickness.x : (zs.y - nearest) / thickness.y, 0.0);
    return hit;
}

// Halves the step from `before`, so that a hit of a long step lies where the ray first meets the surface. What is left of the
// step must meet it too: past an edge, a ray may come to lie far behind a surface that it never was before.
dgb_hit dgb_refined(dgb_hit hit, dgb_ray ray, float before) {
    for (int i = 0; i < DGB_REFLECT_HALVINGS; ++i) {
        dgb_hit middle = dgb_hit_at(ray, 0.5 * (before + hit.s), dgb_ray_z(ray, before));
        if (middle.layer >= 0) hit = middle; // on whichever layer
        else before = middle.s;
    }
    return dgb_hit_at(ray, hit.s, dgb_ray_z(ray, before));
}

#if DGB_HIERARCHICAL
const int   DGB_LOG2_RUN   = 2;              // of 4 steps, which are tested one by one when they cannot be skipped together
const int   DGB_LOG2_CELL  = 2;              // of the 4 pixels of a cell of the finest ranges
const float DGB_Z_ROUNDING = 1.0 / 262144.0; // relative: some 30 times that of the quotient in dgb_ray_z

// Whether a step could hit a surface of a range, its z being low to high. Not if all of them lie behind it, nor if it begins
// farther behind all of them than they are thick. NaN says nothing.
bool dgb_may_hit(vec2 range, float low, float high) { return !(low > range.x || high < range.y - dgb_reflect_ray.y); }

// Whether steps `first` to `last`, which together are shorter than a cell, hit nothing; z: where they begin and end. In between,
// pixels are monotonic in every rounding, z all but monotonic.
bool dgb_is_clear(dgb_ray ray, float jitter, int first, int last, vec2 z, int log2_cell) {
    vec2  a = dgb_ray_pixel(ray, dgb_step_end(ray, jitter, first)), b = dgb_ray_pixel(ray, dgb_step_end(ray, jitter, last));
    ivec2 corner = clamp(ivec2(min(a, b)), ivec2(0), dgb_reflect_size.xy - 1);
    vec4  range  = texelFetch(dgb_ranges, corner >> log2_cell, log2_cell - DGB_LOG2_CELL);
    float low = min(z.x, z.y), high = max(z.x, z.y);
    low -= DGB_Z_ROUNDING * abs(low);
    high += DGB_Z_ROUNDING * abs(high);
    ++dgb_lookups;
    bool hits = dgb_may_hit(range.xy, low, high);
#if DGB_LAYERS > 1
    hits = hits || dgb_may_hit(range.zw, low, high);
#endif
    return !hits;
}

// Skips steps from i on as long as the ranges tell that they hit nothing: twice as many after a success, half as many after a
// failure. z: where step i begins.
void dgb_skip(dgb_ray ray, float jitter, inout int i, inout float z) {
    int log2_steps = min(DGB_LOG2_RUN, dgb_reflect_skip.x); // long steps: no cell is as long as a run
    while (log2_steps >= DGB_LOG2_RUN && i < ray.steps) {
        int   last  = min(i + (1 << log2_steps), ray.steps) - 1;
        float z_end = dgb_ray_z(ray, dgb_step_end(ray, jitter, last));
        bool  clear = dgb_is_clear(ray, jitter, i, last, vec2(z, z_end), log2_steps + dgb_reflect_skip.y);
        i = clear ? last + 1 : i;
        z = clear ? z_end : z;
        log2_steps = clear ? min(log2_steps + 1, dgb_reflect_skip.x) : log2_steps - 1;
    }
}
#endif

// The first step from i on that hits; i moves behind it. The hierarchical tracer takes the same steps as the linear one, and
// leaves out what cannot hit.
dgb_hit dgb_next_hit(dgb_ray ray, float jitter, inout int i) {
    float   z = dgb_ray_z(ray, dgb_step_end(ray, jitter, i - 1));
    int     end = ray.steps;
    dgb_hit hit;
    hit.layer = -1;
    hit.s     = hit.depth = 0.0;
    hit.texel = ivec2(0);
#if DGB_HIERARCHICAL
    while (hit.layer < 0 && i < ray.steps) {
        dgb_skip(ray, jitter, i, z);
        end = min(i + (1 << DGB_LOG2_RUN), ray.steps);
#endif
        for (; hit.layer < 0 && i < end; ++i) {
            float s = dgb_step_end(ray, jitter, i);
            hit     = dgb_hit_at(ray, s, z);
            z       = dgb_ray_z(ray, s);
        }
#if DGB_HIERARCHICAL
    }
#endif
    return hit;
}

// The first hit that stands.
dgb_hit dgb_march(dgb_ray ray, float jitter) {
    int     i   = 0;
    dgb_hit hit = dgb_next_hit(ray, jitter, i);
    while (hit.layer >= 0) {
        hit = dgb_refined(hit, ray, dgb_step_end(ray, jitter, i - 2));
        if (hit.layer >= 0) break;
        hit = dgb_next_hit(ray, jitter, i);
    }
    return hit;
}

// How far a hit can be trusted: less near the border of the buffer, deep behind a surface, and where that faces away.
float dgb_trust(dgb_hit hit, dgb_ray ray, vec3 hit_normal) {
    vec2  centre = vec2(hit.texel) + 0.5, margin = min(centre, vec2(dgb_reflect_size.xy) - centre);
    float border = clamp(min(margin.x, margin.y) / max(dgb_reflect_fade.x, 0.5), 0.0, 1.0);
    float inside = clamp(2.0 - 2.0 * hit.depth, 0.0, 1.0);
    float facing = clamp(-4.0 * dot(ray.direction, hit_normal), 0.0, 1.0);
    return border * inside * facing;
}

#if DGB_INDIRECT
// Irradiance of a layer as far as it is known: by its confidence, and none where nothing was shaded.
vec3 dgb_known(ivec2 texel, bool second) {
    vec4 e = texelFetch(dgb_irradiance, texel, 0);
#if DGB_LAYERS > 1
    if (second) e = texelFetch(dgb_irradiance1, texel, 0);
#endif
    bool shaded = all(greaterThanEqual(texel, dgb_reflect_rect.xy)) && all(lessThanEqual(texel, dgb_reflect_rect.zw));
    return shaded ? e.rgb * e.a : vec3(0.0);
}

// What a Lambert surface makes of the light that this frame has gathered: albedo/pi * E.
vec3 dgb_indirect(ivec2 texel, bool second) {
    vec3 albedo = dgb_albedo_at(0, texel);
#if DGB_LAYERS > 1
    if (second) albedo = dgb_albedo_at(1, texel);
#endif
    return dgb_storable(albedo) / DGB_PI * dgb_known(texel, second);
}
#endif

void main() {
    ivec2 pixel  = ivec2(gl_FragCoord.xy);
    float z      = texelFetch(dgb_z, pixel, 0).x;
    vec3  x      = dgb_position(gl_FragCoord.xy, z, dgb_reflect_camera);
    vec3  n      = dgb_oct16_decode(texelFetch(dgb_normals, pixel, 0).xy);
    vec3  view   = dgb_view(x, dgb_reflect_camera), facet = n;
    int   frame  = 0; // nothing averages the frames of a mirror: always the same
#if DGB_GLOSSY
    float alpha = dgb_ggx_alpha(dgb_roughness_at(pixel));
    frame       = alpha > 0.0 ? dgb_reflect_size.w : 0;
    facet       = dgb_ggx_normal(-view, n, alpha, dgb_pixel_pair(pixel, frame));
#endif
    float jitter = (float(dgb_pixel_hash(pixel, frame)) + 0.5) / 256.0;
    dgb_ray ray  = dgb_ray_of(x, n, reflect(view, facet));
    dgb_hit hit  = dgb_march(ray, jitter);

    vec4 normals = texelFetch(dgb_normals, hit.texel, 0);
    vec3 light   = texelFetch(dgb_b0, hit.texel, 0).rgb;
    vec2 zs      = texelFetch(dgb_z, hit.texel, 0).xy;
    bool second  = false;
#if DGB_LAYERS > 1
    second = hit.layer == 1;
    light  = second ? texelFetch(dgb_b1, hit.texel, 0).rgb : light;
#endif
#if DGB_INDIRECT
    light += dgb_indirect(hit.texel, second);
#endif
    float trust    = hit.layer < 0 ? 0.0 : dgb_trust(hit, ray, dgb_oct16_decode(second ? normals.zw : normals.xy));
    vec3  there    = dgb_position(dgb_centre(int(second), hit.texel), second ? zs.y : zs.x, dgb_reflect_camera);
    dgb_out_reflection = trust > 0.0 ? vec4(dgb_storable(light), trust) : vec4(0.0);
    dgb_out_hit        = trust > 0.0 ? vec4(hit.layer + 1, min(length(there - x), DGB_MAX_RADIANCE), 0.0, 0.0) : vec4(0.0);
#ifdef DGB_COUNT_LOOKUPS
    dgb_out_hit.y = float(dgb_lookups);
#endif
#if DGB_GLOSSY
    dgb_out_hit.zw = dgb_octahedral(ray.direction);
#endif
}
