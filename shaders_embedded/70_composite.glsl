// Composite: the one line that an engine needs, for Lambert surfaces. Light the surface with
//     emission + direct + albedo / pi * dgb_fallback(...)

// Irradiance, W/m2. probe: what comes from where nothing is known: a light probe's irradiance for the normal, or a constant.
// visibility: of DGB_AO; 1 without. irradiance: of DGB_IRRADIANCE; vec4(0) without.
vec3 dgb_fallback(vec3 probe, float visibility, vec4 irradiance) {
    return mix(visibility * probe, irradiance.rgb, irradiance.a);
}
