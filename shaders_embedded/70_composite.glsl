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

// Direction, world space, in which a point is open; bent: of DGB_BENT, normal: of the surface, for where nothing is open.
vec3 dgb_bent_direction(vec4 bent, vec3 normal) {
    float d2 = dot(bent.xyz, bent.xyz);
    return d2 > 1e-6 ? bent.xyz * inversesqrt(d2) : normal;
}

// Cosine of the half angle of the cone that is as open. Twin of the C function of the same name.
float dgb_bent_cosine(vec4 bent) {
    float k      = max(1.5 * length(bent.xyz) / max(bent.a, 1e-6) - 1.0, 0.0);
    float cosine = 0.5 * (k + sqrt(k * k + 4.0 * k));
    return bent.a > 0.0 && cosine < 1.0 ? cosine : 1.0;
}

// Irradiance, W/m2, of the open directions, from a cube map of radiance whose MIP level m is blurred over a cone of 2^m texels
// of its level 0, `texels` along a face's side. Never more than pi times its brightest texel times the open share.
vec3 dgb_probe_visible(samplerCube radiance, float texels, vec4 bent, vec3 normal) {
    float cosine = dgb_bent_cosine(bent), across = sqrt(max(1.0 - cosine * cosine, 0.0)) * texels;
    return 3.14159265 * bent.a * textureLod(radiance, dgb_bent_direction(bent, normal), log2(max(across, 1.0))).rgb;
}

// Radiance, W/(m2 sr). environment: of your environment map in the mirrored direction, prefiltered for the roughness if glossy.
// reflection: of DGB_REFLECTION.
vec3 dgb_mirror(vec3 environment, vec4 reflection) { return mix(environment, reflection.rgb, reflection.a); }
