// How far behind itself a surface hides what is there, shared by the bitmask and the reflections: no farther than `most`, m. What
// is known to lie behind the first layer ends it sooner. zs: as DGB_Z holds them.
vec2 dgb_thickness_of(vec4 zs, float most) {
    vec2 thickness = vec2(most);
#if DGB_LAYERS > 1 && DGB_THICKNESS != 1
    thickness.x = min(thickness.x, zs.x - zs.y);
#endif
#if DGB_THICKNESS == 2
    thickness.x = min(thickness.x, zs.x - zs.z);
#endif
    return thickness;
}
