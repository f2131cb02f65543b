// Glossy reflections: the radiance of a lobe, from the one ray that each pixel of it sends, those of neighbours on the same
// surface, and those of frames before. A neighbour's ray counts as much as this pixel's lobe would rather have sent it:
// density here over density there (ratio estimator; Stachowiak 2015). Misses count as confidence 0, not as black.

layout(std140) uniform dgb_glossy_block {
    dgb_camera       dgb_glossy_camera;
    ivec4            dgb_glossy_rect;    // where there are reflections: x0, y0, x1, y1 inclusive
    ivec4            dgb_glossy_size;    // taps, frame
    vec4             dgb_glossy_reach;   // largest radius (pixels), longest ray (m), weight of history
    vec4             dgb_glossy_sharpness; // normal, plane
    dgb_reprojection dgb_glossy_past;
    vec4             dgb_glossy_taps[DGB_MAX_GLOSSY_TAPS];
};

uniform sampler2D dgb_z;
uniform sampler2D dgb_normals;
uniform sampler2D dgb_reflection_raw;
uniform sampler2D dgb_reflection_hit;
#if DGB_HISTORY
uniform sampler2D dgb_last_reflection;
uniform sampler2D dgb_last_reflection_frames;
#endif

layout(location = 0) out vec4 dgb_out_reflection; // radiance, confidence
#if DGB_HISTORY
layout(location = 1) out vec4 dgb_out_frames; // averaged, in steps of 1 / 255
#endif

// The lobe of a pixel.
struct dgb_lobe {
    vec3  x, n, v; // v: towards the eye
    float alpha;   // 0: a mirror
};

dgb_lobe dgb_lobe_at(ivec2 pixel) {
    dgb_lobe lobe;
    lobe.x     = dgb_position(vec2(pixel) + 0.5, texelFetch(dgb_z, pixel, 0).x, dgb_glossy_camera);
    lobe.n     = dgb_oct16_decode(texelFetch(dgb_normals, pixel, 0).xy);
    lobe.v     = -dgb_view(lobe.x, dgb_glossy_camera);
    lobe.alpha = dgb_ggx_alpha(dgb_roughness_at(pixel));
    return lobe;
}

// The way of a ray, m: misses went all of it.
float dgb_way(vec4 hit) { return hit.x > 0.0 ? hit.y : dgb_glossy_reach.y; }

// A mirrored point a way off appears as far behind the surface. A microfacet turned by alpha shifts it by twice that angle.
vec3 dgb_image_of(dgb_lobe lobe, float way) { return lobe.x - way * lobe.v; }

float dgb_blur(dgb_lobe lobe, float way) {
    return 2.0 * lobe.alpha * way * dgb_pixels_per_metre(dgb_image_of(lobe, way).z, dgb_glossy_camera);
}

const float DGB_MOST_FRAMES = 64.0; // counted
const float DGB_MOST_WEIGHT = 4.0; // of a neighbour's ray: where lobes differ, one ray must not stand for all

// Weight of a neighbour's ray; zero light if it is not to be seen from here. A miss has a direction, a hit a point, which from
// here lies in another direction and takes up another angle.
float dgb_reuse(dgb_lobe own, dgb_lobe other, vec4 hit, inout vec4 light) {
    vec3  sent   = dgb_from_octahedral(hit.zw);
    vec3  to     = hit.x > 0.0 ? other.x + hit.y * sent - own.x : sent;
    float d2     = max(dot(to, to), 1e-30);
    vec3  l      = to * inversesqrt(d2);
    float here   = dgb_ggx_density(own.v, own.n, l, own.alpha) * (hit.x > 0.0 ? hit.y * hit.y / d2 : 1.0);
    float there  = dgb_ggx_density(other.v, other.n, sent, other.alpha); // 0 of a mirror: no ray of a lobe
    float same   = dgb_bilateral_weight(own.n, other.n, other.x - own.x, dgb_glossy_sharpness.x, dgb_glossy_sharpness.y);
    bool  usable = there > 0.0 && other.x.z > DGB_EMPTY_Z;
    light        = dot(l, own.n) > DGB_MIN_COSINE ? light : vec4(0.0); // below the horizon this pixel's rays miss as well
    return usable ? same * min(here / there, DGB_MOST_WEIGHT) : 0.0;
}

struct dgb_mean {
    vec4  weighed; // radiance times confidence, confidence
    float way;     // m
};

// Of this pixel's ray and those of its neighbours within the radius. A mirror has its own ray alone.
dgb_mean dgb_mean_at(ivec2 pixel, dgb_lobe own) {
    vec4     hit    = texelFetch(dgb_reflection_hit, pixel, 0);
    float    radius = min(dgb_blur(own, dgb_way(hit)), dgb_glossy_reach.x), total = 1.0;
    float    angle  = 2.0 * DGB_PI / 256.0 * float(dgb_pixel_hash(pixel, dgb_glossy_size.y));
    vec2     turn   = vec2(cos(angle), sin(angle));
    dgb_mean mean;
    mean.weighed = dgb_weigh(texelFetch(dgb_reflection_raw, pixel, 0));
    mean.way     = dgb_way(hit);
    for (int i = radius >= 0.5 ? 0 : dgb_glossy_size.x; i < dgb_glossy_size.x; ++i) {
        vec4  tap  = dgb_glossy_taps[i];
        vec2  at   = vec2(tap.x * turn.x - tap.y * turn.y, tap.x * turn.y + tap.y * turn.x);
        ivec2 p    = ivec2(floor(vec2(pixel) + 0.5 + radius * tap.z * at));
        bool  good = p != pixel && all(greaterThanEqual(p, dgb_glossy_rect.xy)) && all(lessThanEqual(p, dgb_glossy_rect.zw));
        p          = good ? p : pixel;
        hit        = texelFetch(dgb_reflection_hit, p, 0);
        vec4  light  = dgb_weigh(texelFetch(dgb_reflection_raw, p, 0));
        float weight = dgb_reuse(own, dgb_lobe_at(p), hit, light) * float(good);
        mean.weighed += weight * light;
        mean.way += weight * dgb_way(hit);
        total += weight;
    }
    mean.weighed /= total;
    mean.way /= total;
    return mean;
}

#if DGB_HISTORY
struct dgb_history {
    vec4  weighed;
    float frames;
};

vec4 dgb_last_reflection_at(ivec2 texel) {
    vec4 e = texelFetch(dgb_last_reflection, texel, 0);
    return vec4(dgb_storable(e.rgb), e.a > 0.0 ? (e.a < 1.0 ? e.a : 1.0) : 0.0);
}

dgb_history dgb_history_at(dgb_past past) {
    vec2        low = floor(past.pixel - 0.5), part = past.pixel - 0.5 - low;
    float       share = 0.0;
    dgb_history h;
    h.weighed = vec4(0.0);
    h.frames  = 0.0;
    for (int i = past.tolerance < 0.0 ? 4 : 0; i < 4; ++i) {
        ivec2 corner = ivec2(i & 1, i >> 1);
        ivec2 texel  = clamp(ivec2(low) + corner, dgb_glossy_past.rect.xy, dgb_glossy_past.rect.zw);
        vec2  w      = mix(1.0 - part, part, vec2(corner));
        float weight = dgb_past_layer(texel, past, dgb_glossy_past) == 0 ? w.x * w.y : 0.0;
        share += weight;
        h.weighed += weight * dgb_weigh(dgb_last_reflection_at(texel));
        h.frames += weight * 255.0 * texelFetch(dgb_last_reflection_frames, texel, 0).x;
    }
    float whole = dgb_whole(share);
    h.weighed *= whole;
    h.frames *= whole;
    return h;
}

// Pixels by which the mirrored image has slid over its surface since last frame: it moves with what is behind the surface.
float dgb_slide(dgb_lobe lobe, float way, dgb_past past) {
    vec4 a = dgb_glossy_past.to_last[0], b = dgb_glossy_past.to_last[1], c = dgb_glossy_past.to_last[2];
    vec4 x = vec4(lobe.x, 1.0), image = vec4(dgb_image_of(lobe, way), 1.0);
    vec2 surface = dgb_project(vec3(dot(a, x), dot(b, x), dot(c, x)), dgb_glossy_past.last);
    vec2 behind  = dgb_project(vec3(dot(a, image), dot(b, image), dot(c, image)), dgb_glossy_past.last);
    return length(behind - surface);
}

// History that has slid farther than the lobe blurs is of other things: frames count less the farther. A mirror has none.
dgb_history dgb_usable_history(ivec2 pixel, dgb_lobe lobe, float way) {
    vec2        at   = vec2(pixel) + 0.5;
    dgb_past    past = dgb_past_of(at, lobe.x, lobe.n, dgb_velocity_at(0, pixel), dgb_glossy_past);
    dgb_history h    = dgb_history_at(past);
    float       kept = dgb_blur(lobe, way) - dgb_slide(lobe, way, past);
    h.frames *= kept > 0.0 ? min(kept, 1.0) : 0.0;
    return h;
}
#endif

void main() {
    ivec2    pixel = ivec2(gl_FragCoord.xy);
    vec4     raw   = texelFetch(dgb_reflection_raw, pixel, 0);
    dgb_lobe own   = dgb_lobe_at(pixel);
    bool     rough = own.alpha > 0.0 && own.x.z > DGB_EMPTY_Z;
    dgb_mean mean  = dgb_mean_at(pixel, own);
#if DGB_HISTORY
    dgb_history h  = dgb_usable_history(pixel, own, mean.way);
    float weight   = min(h.frames / (h.frames + 1.0), dgb_glossy_reach.z);
    mean.weighed   = mix(mean.weighed, h.weighed, weight);
    dgb_out_frames = vec4(rough ? min(h.frames + 1.0, DGB_MOST_FRAMES) / 255.0 : 0.0);
#endif
    vec4 filtered = dgb_unweigh(mean.weighed);
    filtered.rgb  = dgb_storable(filtered.rgb);
#if DGB_HISTORY
    filtered = dgb_averaged(filtered, weight, pixel, dgb_glossy_size.y);
#endif
    dgb_out_reflection = rough ? filtered : raw;
}
