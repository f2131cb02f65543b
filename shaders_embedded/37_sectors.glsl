// The mathematics of the visibility bitmask (Therrien et al. 2023). A slice is a half plane bounded by the line of sight. Each
// function is the twin of the C function of the same name in deepgbuffer.h, which documents it.

float dgb_arc_sine(float x) {
    float a = min(abs(x), 1.0);
    float b = 1.57079633 - sqrt(1.0 - a) * (1.5707288 + a * (-0.2121144 + a * (0.0742610 - 0.0187293 * a)));
    return x < 0.0 ? -b : b;
}

vec3 dgb_slice_along(vec3 n, vec3 v, vec3 s) {
    vec3  w  = n + s;
    vec3  d  = w - dot(w, v) * v;
    float d2 = dot(d, d);
    return d2 > 1e-12 ? d * inversesqrt(d2) : vec3(1.0, 0.0, 0.0);
}

// cos g, sin g, g, 1 / (cos g + (g + pi/2) sin g)
vec4 dgb_slice(vec3 n, vec3 v, vec3 along) {
    vec2  p  = vec2(max(dot(n, v), 0.0), dot(n, along));
    float p2 = dot(p, p);
    p        = p2 > 1e-12 ? p * inversesqrt(p2) : vec2(1.0, 0.0);
    float g  = dgb_arc_sine(p.y);
    return vec4(p, g, 1.0 / max(p.x + (g + 0.5 * DGB_PI) * p.y, 1e-5));
}

// sin^2 cos g + (angle - sin cos) sin g of an angle from the eye; g: cos g, sin g, 2 cos g; x: the angle's versine, 1 - cosine.
float dgb_slice_part(vec3 g, float x) {
    float segment = sqrt(x) * (1.8772000 + x * (-0.3058190 + x * (0.0586256 - 0.0473906 * x))); // angle - sin cos, by x
    return x * (g.z - g.x * x + g.y * segment);
}

// dgb_slice_share in three steps: what is the same for all directions, cos g and sin g over the part up to the horizon and the
// horizon's versine; that of a direction {towards the eye, along}, which lies in the slice; the share, of so many sectors.
vec4 dgb_slice_scale(vec4 slice, float sectors) {
    vec3  g       = vec3(slice.xy, 2.0 * slice.x);
    float horizon = 1.0 + slice.y;
    return vec4(g * (sectors / max(dgb_slice_part(g, horizon), 1e-5)), horizon);
}

float dgb_versine(vec2 q) { return 1.0 - q.x * inversesqrt(dot(q, q)); }

// rounded, a versine may be below 0
float dgb_share(vec4 scale, float versine) { return dgb_slice_part(scale.xyz, min(abs(versine), scale.w)); }

float dgb_slice_share(vec4 slice, vec2 q) {
    float versine = q.y >= 0.0 ? 1.0 - q.x * inversesqrt(dot(q, q) + 1e-30) : 2.0;
    return clamp(dgb_share(dgb_slice_scale(slice, 1.0), versine), 0.0, 1.0);
}

// from, to: in sectors, 0..32
uint dgb_sectors_between(float from, float to, float u) {
    uint low = uint(from + u), high = min(uint(to + u), 32u);
    return low < high ? 0xffffffffu >> ((low - high) & 31u) << low : 0u;
}

uint dgb_sectors(float from, float to, float u) { return dgb_sectors_between(32.0 * from, 32.0 * to, u); }

int dgb_sector_count(uint sectors) {
#if __VERSION__ >= 400
    return bitCount(sectors);
#else // 330 and 300 es have none
    uint pairs = sectors - ((sectors >> 1) & 0x55555555u);
    uint fours = (pairs & 0x33333333u) + ((pairs >> 2) & 0x33333333u);
    return int((((fours + (fours >> 4)) & 0x0f0f0f0fu) * 0x01010101u) >> 24);
#endif
}

float dgb_slice_angle(vec4 slice, float share) {
    float horizon = slice.z + 0.5 * DGB_PI;
    float t       = horizon * (2.0 / DGB_PI) * dgb_arc_sine(sqrt(share));
    for (int i = 0; i < 3; ++i) { // Newton's; at the ends, where the share does not grow, t stays
        float s = sin(t), c = cos(t);
        float off = (s * s * slice.x + (t - s * c) * slice.y) * slice.w - share, slope = 2.0 * s * (c * slice.x + s * slice.y) * slice.w;
        t = clamp(t - off / max(slope, 1e-3), 0.0, horizon);
    }
    return share < 1.0 ? t : horizon;
}

vec2 dgb_slice_sum(vec4 slice, float angle) {
    float s = sin(angle), c = cos(angle), s3 = s * s * s, c3 = c * c * c;
    return vec2(slice.x * (1.0 - c3) + slice.y * s3, slice.x * s3 + slice.y * (2.0 - 3.0 * c + c3)) * (2.0 / 3.0 * slice.w);
}

// Four sectors at a time, which lie so near together that any of them has their mean direction.
vec2 dgb_sectors_mean(vec4 slice, uint sectors) {
    vec2 sum = vec2(0.0), before = vec2(0.0);
    for (int i = 1; i <= 8; ++i) {
        vec2 up_to = dgb_slice_sum(slice, dgb_slice_angle(slice, 0.125 * float(i)));
        sum += (up_to - before) * (0.25 * float(dgb_sector_count(sectors & 15u)));
        before = up_to;
        sectors >>= 4u;
    }
    return sum;
}
