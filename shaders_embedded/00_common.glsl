// Mathematics shared by every pass. Each function is the twin of the C function of the same name in deepgbuffer.h, which
// documents it. NaN is removed by selects (a comparison with NaN is false), never by min, max or clamp, whose treatment of
// NaN differs between implementations.

const float DGB_PI           = 3.14159265358979;
const float DGB_MAX_RADIANCE = 64512.0;
const float DGB_MAX_DISTANCE = 1e15;
const float DGB_EMPTY_Z      = -1e15; // packed z of no surface: so far away that it reaches nothing
const float DGB_MIN_COSINE   = 0.017;
const float DGB_MIN_ROUGHNESS = 1.0 / 512.0;
const int   DGB_LOG2_TILE    = 4; // tiles are 16 x 16 pixels

struct dgb_camera {
    vec4 linearise;
    vec4 position_z;
    vec4 position_1;
    vec4 footprint;
};

// Oct16: two bytes as the unorm8 channels of a texture hold them.
vec2 dgb_sign(vec2 v) { return vec2(v.x < 0.0 ? -1.0 : 1.0, v.y < 0.0 ? -1.0 : 1.0); }

// A direction on the unfolded octahedron, -1..1, and back.
vec2 dgb_octahedral(vec3 n) {
    float s     = abs(n.x) + abs(n.y) + abs(n.z);
    bool  valid = s > 1e-30 && s < 1e30;
    vec2  p     = valid ? n.xy / s : vec2(0.0);
    return valid && n.z < 0.0 ? (1.0 - abs(p.yx)) * dgb_sign(p) : p;
}

// The direction that they mean, of any length: enough where only a sign is asked for.
vec3 dgb_unfolded(vec2 p) {
    float z = 1.0 - abs(p.x) - abs(p.y);
    uvec2 fold = floatBitsToUint(vec2(max(-z, 0.0))) | (floatBitsToUint(p) & 0x80000000u); // with the signs of p
    return vec3(p - uintBitsToFloat(fold), z); // what lies below the equator is folded back
}

vec3 dgb_from_octahedral(vec2 p) { return normalize(dgb_unfolded(p)); }

vec2 dgb_oct16_encode(vec3 n) { return (floor(dgb_octahedral(n) * 127.0 + 0.5) + 127.0) / 255.0; }

vec3 dgb_oct16_direction(vec2 bytes) { return dgb_unfolded(min(bytes * (255.0 / 127.0) - 1.0, 1.0)); }

vec3 dgb_oct16_decode(vec2 bytes) { return normalize(dgb_oct16_direction(bytes)); }

float dgb_storable(float x) { return x > 0.0 ? (x < DGB_MAX_RADIANCE ? x : DGB_MAX_RADIANCE) : 0.0; }

vec3 dgb_storable(vec3 v) { return vec3(dgb_storable(v.x), dgb_storable(v.y), dgb_storable(v.z)); }

// The same for parts of directions and shares: what is beyond -1..1, or NaN, becomes 0.
vec4 dgb_storable_unit(vec4 v) { return mix(vec4(0.0), v, lessThanEqual(abs(v), vec4(1.0))); }

// The nearest value >= 0 that a small float of so many mantissa bits holds. Implementations round or truncate what they store;
// truncated bounce after bounce, light loses a tenth, and its blue a fifth.
float dgb_nearest(float x, int bits) {
    int   shift = 23 - bits;
    float least = exp2(float(-14 - bits)); // step of the subnormal values, below 2^-14
    uint  code  = (floatBitsToUint(x) + (1u << (shift - 1))) >> shift << shift;
    return x < 6.103515625e-5 ? floor(x / least + 0.5) * least : uintBitsToFloat(code);
}

vec3 dgb_nearest(vec3 v) { return vec3(dgb_nearest(v.x, 6), dgb_nearest(v.y, 6), dgb_nearest(v.z, 5)); }

vec4 dgb_dithered(vec4 x, vec4 u) {
    uvec4 below  = 2u + uvec4(u * 8188.0);
    vec4  coarse = uintBitsToFloat((floatBitsToUint(x) + below) & 0xffffe000u);
    vec4  fine   = floor(x * 16777216.0 + vec4(below) / 8192.0) / 16777216.0;
    return mix(fine, coarse, greaterThanEqual(abs(x), vec4(6.103515625e-5)));
}

int dgb_pixel_hash(ivec2 pixel, int frame) {
    uint h = uint(pixel.x) * 0x8da6b343u ^ uint(pixel.y) * 0xd8163841u;
    h      = (h ^ (h >> 16)) * 0x7feb352du;
    h      = (h ^ (h >> 15)) * 0x846ca68bu;
    return int(((h >> 24) + uint(frame) * 159u) & 255u);
}

vec2 dgb_pixel_pair(ivec2 pixel, int frame) {
    uint h = uint(pixel.x) * 0x8da6b343u ^ uint(pixel.y) * 0xd8163841u;
    h      = (h ^ (h >> 16)) * 0x7feb352du;
    h      = (h ^ (h >> 15)) * 0x846ca68bu;
    uint g = (h ^ (h >> 16)) * 0x2c1b3c6du;
    g      = (g ^ (g >> 15)) * 0x297a2d39u;
    uvec2 turns = uvec2(h, g) + uint(frame) * uvec2(3242174889u, 2447445414u);
    return (vec2(turns >> 9u) + 0.5) / 8388608.0;
}

int dgb_hilbert_index(ivec2 pixel) {
    uvec2 p     = uvec2(pixel);
    uint  index = 0u;
    for (int bit = 5; bit >= 0; --bit) {
        uvec2 quarter = (p >> uint(bit)) & 1u; // right, upper
        index         = index << 2u | ((3u * quarter.x) ^ quarter.y);
        p             = quarter.y == 0u ? p.yx ^ (0u - quarter.x) : p;
    }
    return int(index);
}

vec4 dgb_pixel_quad(ivec2 pixel, int frame) {
    uint place = uint(dgb_hilbert_index(pixel)) + uint(frame) * 288u + 1u;
    return (vec4((place * uvec4(3242174889u, 2447445414u, 2700274806u, 2313257605u)) >> 9u) + 0.5) / 8388608.0;
}

int dgb_mip_level(float h, int log2_q, int min_level, int max_level) {
    // in brackets: what is the same for all taps
    return h > 0.0 ? clamp((floatBitsToInt(h) >> 23) - (127 + log2_q), min_level, max_level) : min_level;
}

// All bits set where a coordinate is odd.
ivec2 dgb_odd(ivec2 p) {
#if __VERSION__ >= 400
    return bitfieldExtract(p, 0, 1); // with its sign: one instruction
#else // 330 and 300 es have none
    return -(p & 1);
#endif
}

ivec2 dgb_mip_source(ivec2 p, int level) {
    ivec2 odd_texel = dgb_odd(p);
    return (p << level) | (odd_texel.yx & (0xaaaa >> (16 - level))) | (odd_texel & (0x5555 >> (16 - level)));
}

float dgb_depth_code(float depth, float codes) {
    float scaled = depth * codes;
    if (!(codes > 0.0) || !(scaled >= 0.0 && scaled <= codes)) return depth;
    return (scaled < 8388608.0 ? floor(scaled + 0.5) : scaled) / codes;
}

float dgb_linear_z(float depth, dgb_camera camera) {
    float t           = depth - camera.footprint.w;
    float z           = (camera.linearise.x + camera.linearise.y * t) / (camera.linearise.z + camera.linearise.w * t);
    bool  perspective = camera.linearise.w != 0.0; // footprint.y says the same, but is one uniform more to read
    return abs(z) <= DGB_MAX_DISTANCE && t != 0.0 && (!perspective || z < 0.0) ? z : 0.0;
}

vec3 dgb_position(vec2 pixel, float z, dgb_camera camera) {
    vec4 a = camera.position_z, b = camera.position_1;
    return vec3((pixel * a.xy + a.zw) * z + (pixel * b.xy + b.zw), z);
}

// A point that offsets are from.
struct dgb_origin {
    vec2  pixel; // where it is seen
    float z;
    vec2  side; // metres between pixels at its depth
};

dgb_origin dgb_origin_at(vec2 pixel, float z, dgb_camera camera) {
    return dgb_origin(pixel, z, camera.position_z.xy * z + camera.position_1.xy);
}

// To what a pixel shows at depth z: the difference of two dgb_position, but cheaper where many share an origin, and exact where
// that cancels: to the origin itself it is 0.
vec3 dgb_offset(vec2 pixel, float z, dgb_origin o, dgb_camera camera) {
    vec2  ray = pixel * camera.position_z.xy + camera.position_z.zw;
    float dz  = z - o.z;
    return vec3(ray * dz + (pixel - o.pixel) * o.side, dz);
}

// Pixel position of a camera-space point.
vec2 dgb_project(vec3 point, dgb_camera camera) {
    vec4 a = camera.position_z, b = camera.position_1;
    return (point.xy - a.zw * point.z - b.zw) / (a.xy * point.z + b.xy);
}

// Unit vector from the eye to a point.
vec3 dgb_view(vec3 point, dgb_camera camera) { return camera.footprint.y != 0.0 ? normalize(point) : vec3(0.0, 0.0, -1.0); }

#ifdef DGB_DIVISOR
// Where in the image the texel of a layer lies that a pixel shows: deeper layers may have a lower resolution.
vec2 dgb_centre(int layer, ivec2 pixel) {
    int divisor = layer > 0 ? DGB_DIVISOR : 1;
    return (vec2(pixel / divisor) + 0.5) * float(divisor);
}
#endif

float dgb_pixels_per_metre(float z, dgb_camera camera) {
    float w = camera.footprint.y * z + camera.footprint.z;
    return w > 0.0 ? camera.footprint.x / w : 0.0;
}

// Pixels that a radius (m) covers at depth z, `most` of them at most.
float dgb_reach(float z, float radius, float most, dgb_camera camera) {
    return min(dgb_pixels_per_metre(z, camera) * radius, most);
}

bool dgb_keep_test(float z, float z_front, float separation) { return z_front != 0.0 && -z > -z_front + separation; }

// The square, so that the larger of two layers is known before a root is taken. For finite v and epsilon > 0, which the
// passes guarantee; dgb_ao_term below takes anything.
float dgb_ao_term_squared(vec3 v, vec3 n, float inv_r2, float beta, float epsilon) {
    float d2 = dot(v, v);
    float a  = max(1.0 - d2 * inv_r2, 0.0) * max(dot(vec4(v, 1.0), vec4(n, -beta)), 0.0);
    return a * a / (d2 + epsilon);
}

float dgb_ao_term(vec3 v, vec3 n, float inv_r2, float beta, float epsilon) {
    float squared = dgb_ao_term_squared(v, n, inv_r2, beta, epsilon);
    return squared > 0.0 && squared <= 1.0 ? sqrt(squared) : 0.0;
}

float dgb_ambient_visibility(float sum, float pi_over_count) {
    return sum > 0.0 ? max(1.0 - sqrt(pi_over_count * sum), 0.0) : 1.0;
}

float dgb_gather_term(vec3 v, vec3 n_x, float r2) {
    float d2     = dot(v, v);
    float cosine = dot(v, n_x) * inversesqrt(d2);
    return d2 <= r2 && cosine > DGB_MIN_COSINE ? cosine : 0.0;
}

float dgb_gather_scale(float sum_cos, float count, float k) {
    return count > 0.0 ? DGB_PI / max(sum_cos * k, 0.5 * count) : 0.0;
}

float dgb_boost(vec3 albedo, float unsaturated, float saturated) {
    const float largest = 3.4028234e38;
    float       high = 0.0, low = largest;
    for (int i = 0; i < 3; ++i) { // NaN changes neither
        high = albedo[i] > high ? albedo[i] : high;
        low  = albedo[i] < low ? albedo[i] : low;
    }
    low = max(low, 0.0);
    return unsaturated + (saturated - unsaturated) * (high > low && high <= largest ? (high - low) / high : 0.0);
}

// Irradiance and its confidence are averaged with the confidence as weight: a pixel whose taps found nothing says nothing.
vec4 dgb_weigh(vec4 irradiance) { return vec4(irradiance.rgb * irradiance.a, irradiance.a); }

vec4 dgb_unweigh(vec4 weighed) { return vec4(weighed.a > 0.0 ? weighed.rgb / weighed.a : vec3(0.0), weighed.a); }

float dgb_bilateral_weight(vec3 n, vec3 n2, vec3 dq, float normal_sharpness, float plane_sharpness) {
    float normal = max(1.0 - normal_sharpness * (1.0 - dot(n, n2)), 0.0);
    float d2     = dot(dq, dq);
    float off    = max(abs(dot(dq, n)), abs(dot(dq, n2)));
    float plane  = d2 > 0.0 ? max(1.0 - plane_sharpness * off * inversesqrt(d2), 0.0) : 1.0;
    return normal * plane * plane;
}

float dgb_ggx_alpha(float roughness) { return roughness >= DGB_MIN_ROUGHNESS ? (roughness < 1.0 ? roughness * roughness : 1.0) : 0.0; }

vec3 dgb_ggx_normal(vec3 v, vec3 n, float alpha, vec2 u) {
    float along     = dot(v, n);
    vec3  stretched = normalize(alpha * (v - along * n) + max(along, 0.0) * n);
    // the cap of the unit sphere that the stretched viewer sees, uniformly: about n, from the pole down to its horizon
    float height = 1.0 - u.y * (1.0 + dot(stretched, n)), radius = sqrt(max(1.0 - height * height, 0.0)), turn = 2.0 * DGB_PI * u.x;
    float side   = n.z < 0.0 ? -1.0 : 1.0, a = -1.0 / (side + n.z), b = n.x * n.y * a;
    vec3  s      = vec3(1.0 + side * n.x * n.x * a, side * b, -side * n.x), t = vec3(b, side + n.y * n.y * a, -n.y);
    vec3  m      = stretched + radius * (cos(turn) * s + sin(turn) * t) + height * n; // halfway
    float up     = dot(m, n);
    vec3  h      = normalize(alpha * (m - up * n) + up * n);
    return alpha > 0.0 ? (dot(v, h) >= 0.0 ? h : v) : n;
}

float dgb_ggx_density(vec3 v, vec3 n, vec3 l, float alpha) {
    vec3  h       = v + l, off = cross(n, h);
    float h2      = dot(h, h), up = dot(h, n), a2 = alpha * alpha, k = a2 * up * up + dot(off, off);
    float along   = max(dot(v, n), 0.0);
    float masking = 2.0 * (along + sqrt(a2 + (1.0 - a2) * along * along)); // 4 n.v / G1
    float density = a2 * h2 * h2 / (DGB_PI * k * k * masking);
    if (!(alpha > 0.0)) return 0.0; // a test of its own: of two, compilers make one of the lesser, and NaN is not less
    return up > 0.0 ? density : 0.0;
}
