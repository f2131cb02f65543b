// Temporal filter: an exponentially weighted average along the motion of each surface, over ambient visibility, irradiance and
// confidence (paper, section 3.3). History may come from either layer, wherever the surface was last frame. The first frames
// weigh alike, so that a surface that has just come into view settles as fast as it can. With DGB_LIMITED, what stands out from
// the 3 x 3 pixels of this frame is limited: history where the surface moves, and single samples.

const float DGB_MOST_FRAMES = 1000.0; // counted: a half holds them exactly, and the greatest weight needs 999

layout(std140) uniform dgb_temporal_block {
    dgb_camera       dgb_temporal_camera;
    vec4             dgb_temporal_weight; // of history; standard deviations, and times the mean, that are let through; frame
    ivec4            dgb_temporal_present; // shaded rectangle: x0, y0, x1, y1, the last two inclusive
    dgb_reprojection dgb_temporal_past;
};

uniform sampler2D dgb_z;
uniform sampler2D dgb_normals;
uniform sampler2D dgb_last_frames;
#if DGB_FILTER_AO
uniform sampler2D dgb_ao_raw;
#endif
#if DGB_BENT
uniform sampler2D dgb_bent_raw;
uniform sampler2D dgb_last_bent;
#endif
#if DGB_LAST_LIGHT
uniform sampler2D dgb_irradiance_raw;
#endif
#if DGB_DEEP
uniform sampler2D dgb_irradiance1_raw;
#endif

layout(location = 0) out vec4 dgb_out_frames; // ambient visibility and the frames averaged: of it, of layer 0, of layer 1
#if DGB_LAST_LIGHT
layout(location = 1) out vec4 dgb_out_irradiance;
#endif
#if DGB_DEEP
layout(location = 2) out vec4 dgb_out_irradiance1;
#endif
#if DGB_BENT && DGB_DEEP
layout(location = 3) out vec4 dgb_out_bent;
#elif DGB_BENT && DGB_LAST_LIGHT
layout(location = 2) out vec4 dgb_out_bent;
#elif DGB_BENT
layout(location = 1) out vec4 dgb_out_bent;
#endif

// Averages over the texels that the surface was at; share: of the bilinear weights that these have, 0 where there is no history.
struct dgb_history {
    float moved; // pixels since last frame
    vec4  irradiance;
    float frames, share;
    float visibility, visibility_frames, visibility_share;
    vec4  bent; // with the visibility's frames and share
};

// Layers hand on irradiance to each other, but visibility exists for the first alone.
void dgb_add_history(inout dgb_history h, ivec2 texel, int shown, float weight) {
    vec4 frames = texelFetch(dgb_last_frames, texel, 0);
    if (shown < 0 || !(weight > 0.0)) return;
    h.share += weight;
    h.frames += weight * dgb_storable(shown == 1 ? frames.w : frames.z);
#if DGB_LAST_LIGHT
    h.irradiance += weight * dgb_weigh(dgb_last_irradiance_at(texel, shown));
#endif
    if (shown == 1) return;
    h.visibility_share += weight;
    h.visibility += weight * (frames.x < 1.0 ? dgb_storable(frames.x) : 1.0);
    h.visibility_frames += weight * dgb_storable(frames.y);
#if DGB_BENT
    h.bent += weight * dgb_storable_unit(texelFetch(dgb_last_bent, texel, 0));
#endif
}

dgb_history dgb_history_of(int layer, ivec2 pixel, float z, vec2 normal) {
    vec2        at   = dgb_centre(layer, pixel);
    vec3        x    = dgb_position(at, z, dgb_temporal_camera);
    dgb_past    past = dgb_past_of(at, x, dgb_oct16_decode(normal), dgb_velocity_at(layer, pixel), dgb_temporal_past);
    vec2        low  = floor(past.pixel - 0.5), part = past.pixel - 0.5 - low;
    dgb_history h;
    h.moved      = length(at - past.pixel);
    h.irradiance = h.bent = vec4(0.0);
    h.frames = h.share = h.visibility = h.visibility_frames = h.visibility_share = 0.0;
    for (int i = past.tolerance < 0.0 || !(z > DGB_EMPTY_Z) ? 4 : 0; i < 4; ++i) {
        ivec2 corner = ivec2(i & 1, i >> 1), texel = ivec2(low) + corner;
        vec2  weight = mix(1.0 - part, part, vec2(corner));
        texel        = clamp(texel, dgb_temporal_past.rect.xy, dgb_temporal_past.rect.zw);
        dgb_add_history(h, texel, dgb_past_layer(texel, past, dgb_temporal_past), weight.x * weight.y);
    }
    float whole = dgb_whole(h.share), whole_visibility = dgb_whole(h.visibility_share);
    h.share *= whole;
    h.irradiance *= whole;
    h.frames *= whole;
    h.visibility_share *= whole_visibility;
    h.visibility *= whole_visibility;
    h.visibility_frames *= whole_visibility;
    h.bent *= whole_visibility;
    return h;
}

// Weight of an average of so many frames against one frame more.
float dgb_history_weight(float frames) { return min(frames / (frames + 1.0), dgb_temporal_weight.x); }

float dgb_one_more(float frames) { return min(frames + 1.0, DGB_MOST_FRAMES); }

#if DGB_LIMITED
// What this frame found, of layer 0, of layer 1, or, for -1, of the visibility.
vec4 dgb_sample_at(int of, ivec2 p) {
#if DGB_DEEP
    if (of == 1) return dgb_weigh(texelFetch(dgb_irradiance1_raw, p, 0));
#endif
#if DGB_FILTER_AO
    if (of == -1) return vec4(texelFetch(dgb_ao_raw, p, 0).x);
#endif
#if DGB_LAST_LIGHT
    if (of == 0) return dgb_weigh(texelFetch(dgb_irradiance_raw, p, 0));
#endif
    return vec4(0.0);
}

float dgb_brightest(vec4 light) { return max(light.r, max(light.g, light.b)); }

// Limits a sample and the history, both weighed, by the mean and the standard deviation of the 3 x 3 samples. A surface that moves
// a pixel a frame or more has the narrowest box, one that stands still has none: there the box would only add the noise of a frame.
void dgb_limit(int of, ivec2 pixel, float moved, bool known, inout vec4 present, inout vec4 history) {
    vec4 sum = vec4(0.0), squares = vec4(0.0);
    for (int i = 0; i < 9; ++i) {
        ivec2 p = clamp(pixel + ivec2(i % 3, i / 3) - 1, dgb_temporal_present.xy, dgb_temporal_present.zw);
        vec4  s = dgb_sample_at(of, p);
        sum += s;
        squares += s * s;
    }
    vec4  mean = sum / 9.0, others = max(sum - present, 0.0) / 8.0;
    vec4  side = sqrt(max(squares / 9.0 - mean * mean, 0.0)) * (dgb_temporal_weight.y / clamp(moved, 1e-3, 1.0));
    if (dgb_temporal_weight.y > 0.0 && moved > 0.0) history = clamp(history, mean - side, mean + side);
    float own = dgb_brightest(present), most = dgb_temporal_weight.z * max(dgb_brightest(others), known ? dgb_brightest(history) : 0.0);
    if (dgb_temporal_weight.z > 0.0 && of >= 0 && own > most) present.rgb *= most / own;
}
#endif

vec4 dgb_filtered(int layer, ivec2 pixel, vec4 raw, dgb_history h) {
    vec4 present = dgb_weigh(raw);
#if DGB_LIMITED
    dgb_limit(layer, pixel, h.moved, h.share > 0.0, present, h.irradiance);
#endif
    float weight = dgb_history_weight(h.frames);
    vec4  mean   = dgb_unweigh(mix(present, h.irradiance, weight));
    return dgb_averaged(vec4(dgb_storable(mean.rgb), mean.a), weight, pixel, int(dgb_temporal_weight.w));
}

void main() {
    ivec2 pixel    = ivec2(gl_FragCoord.xy);
    vec2  z        = texelFetch(dgb_z, pixel, 0).xy;
    vec4  normals  = texelFetch(dgb_normals, pixel, 0);
    dgb_out_frames = vec4(1.0, 0.0, 0.0, 0.0);

    dgb_history h = dgb_history_of(0, pixel, z.x, normals.xy);
#if DGB_LAST_LIGHT
    vec4 raw           = texelFetch(dgb_irradiance_raw, pixel, 0);
    vec4 filtered      = dgb_filtered(0, pixel, raw, h);
    dgb_out_irradiance = z.x > DGB_EMPTY_Z ? filtered : raw;
#endif
#if DGB_FILTER_AO
    vec4 open = vec4(texelFetch(dgb_ao_raw, pixel, 0).x), before = vec4(h.visibility);
#if DGB_LIMITED
    dgb_limit(-1, pixel, h.moved, h.visibility_share > 0.0, open, before);
#endif
    float weight = dgb_history_weight(h.visibility_frames);
    open         = dgb_averaged(mix(open, before, weight), weight, pixel, int(dgb_temporal_weight.w));
    if (z.x > DGB_EMPTY_Z) dgb_out_frames.xy = vec2(open.x, dgb_one_more(h.visibility_frames));
#endif
#if DGB_BENT
    vec4 bent    = texelFetch(dgb_bent_raw, pixel, 0);
    vec4 average = mix(bent, h.bent, weight);
    dgb_out_bent = z.x > DGB_EMPTY_Z ? dgb_averaged(average, weight, pixel, int(dgb_temporal_weight.w)) : bent;
#endif
    if (z.x > DGB_EMPTY_Z) dgb_out_frames.z = dgb_one_more(h.frames);

#if DGB_DEEP
    dgb_history h1      = dgb_history_of(1, pixel, z.y, normals.zw);
    vec4        raw1    = texelFetch(dgb_irradiance1_raw, pixel, 0);
    vec4        deep    = dgb_filtered(1, pixel, raw1, h1);
    dgb_out_irradiance1 = z.y > DGB_EMPTY_Z ? deep : raw1;
    if (z.y > DGB_EMPTY_Z) dgb_out_frames.w = dgb_one_more(h1.frames);
#endif
}
