// How far behind itself a surface hides what is there, shared by the bitmask and the reflections: no farther than `most`, m. What
// is known to lie behind the first layer ends it sooner; but behind a thin object may stand the next, too near for the second
// layer, so that a back face ends no surface before a part of the way. zs: as DGB_Z holds them.
const float DGB_LEAST_THICKNESS = 0.25; // of the most; without it occlusion errs more in every scene measured

vec2 dgb_thickness_of(vec4 zs, float most) {
    vec2 thickness = vec2(most);
#if DGB_LAYERS > 1 && DGB_THICKNESS != 1
    thickness.x = min(thickness.x, zs.x - zs.y);
#endif
#if DGB_THICKNESS == 2
    thickness.x = min(thickness.x, max(zs.x - zs.z, DGB_LEAST_THICKNESS * most));
#endif
    return thickness;
}
