// Spiral taps, shared by ao and gather (paper, section 3.4). Angles come from tables, so that every implementation lands on
// the same texels.

uniform sampler2D dgb_rotations;

struct dgb_tap {
    ivec2 texel; // what to fetch
    int   level; // from this MIP level
    ivec2 pixel; // the level-0 pixel it was copied from: where the surface really is
    bool  inside; // whether it lies in the buffer; else the border stands in for what is not known
};

vec2 dgb_rotation(ivec2 pixel, int frame) { return texelFetch(dgb_rotations, ivec2(dgb_pixel_hash(pixel, frame), 0), 0).rg; }

// table: cos, sin, kappa of the tap; reach: radius of the spiral in pixels; size: of the buffer; levels: log2 q, min, max.
dgb_tap dgb_tap_at(vec4 table, vec2 rotation, float reach, vec2 centre, ivec2 size, ivec4 levels) {
    vec2    direction = vec2(table.x * rotation.x - table.y * rotation.y, table.x * rotation.y + table.y * rotation.x);
    float   h         = max(reach * table.z, 0.75); // nearer taps would land on the shaded pixel itself
    vec2    at        = centre + h * direction;
    ivec2   p         = ivec2(clamp(at, vec2(0.0), vec2(size - 1)));
    dgb_tap tap;
    tap.inside = all(greaterThanEqual(at, vec2(0.0))) && all(lessThan(at, vec2(size)));
    tap.level = dgb_mip_level(h, levels.x, levels.y, levels.z);
    tap.texel = min(p >> tap.level, (size >> tap.level) - 1);
    tap.pixel = dgb_mip_source(tap.texel, tap.level);
    return tap;
}

#if DGB_LAYERS > 1
uniform sampler2D dgb_tiles;

// Whether the second layer matters to occlusion, to light, and is there, in the pixel's tile; all: as if it did everywhere.
bvec3 dgb_tile_at(ivec2 pixel, bool all) {
    return greaterThan(texelFetch(dgb_tiles, pixel >> DGB_LOG2_TILE, 0).rgb + vec3(all), vec3(0.0));
}
#endif
