// Ranges of depth: largest and smallest z of layer 0, then of layer 1. A texel without a surface adds nothing to them.

const vec4 DGB_NO_DEPTHS = vec4(-1e30, 1e30, -1e30, 1e30);

vec4 dgb_join(vec4 a, vec4 b) { return vec4(max(a.x, b.x), min(a.y, b.y), max(a.z, b.z), min(a.w, b.w)); }

// Of one texel.
vec4 dgb_depths_of(vec2 z) {
    vec4 depths = DGB_NO_DEPTHS;
    if (z.x > DGB_EMPTY_Z) depths.xy = z.xx;
    if (z.y > DGB_EMPTY_Z) depths.zw = z.yy;
    return depths;
}
