// Composite: the lines that an engine needs. A Lambert surface sends emission + direct + albedo / pi * dgb_fallback(...), a
// mirror its reflectance times dgb_mirror(...), a rough surface its environment BRDF (split sum) times dgb_mirror(...).

// Share of the hemisphere that the irradiance comes from. Around a flat surface half of the taps look at its own plane and
// behind it: half a confidence is all that there is to find. Against ray-traced light, twice the confidence is nearer to the
// truth than once in every scene of the sweep (`make trade`).
float dgb_covered(float confidence) { return min(2.0 * confidence, 1.0); }

// Irradiance, W/m2. probe: what comes from where nothing is known: a light probe's irradiance for the normal, or a constant.
// visibility: of DGB_AO; 1 without. irradiance: of DGB_IRRADIANCE; vec4(0) without.
vec3 dgb_fallback(vec3 probe, float visibility, vec4 irradiance) {
    return mix(visibility * probe, irradiance.rgb, dgb_covered(irradiance.a));
}

// Radiance, W/(m2 sr). environment: of your environment map in the mirrored direction, prefiltered for the roughness if glossy.
// reflection: of DGB_REFLECTION.
vec3 dgb_mirror(vec3 environment, vec4 reflection) { return mix(environment, reflection.rgb, reflection.a); }
