// Taps, shared by ao, gather and bitmask; those of the first two lie on a spiral (paper, section 3.4). Angles come from tables, so
// that every implementation lands on the same texels.

uniform sampler2D dgb_rotations;

struct dgb_tap {
    ivec2 texel; // what to fetch
    int   level; // from this MIP level
    ivec2 pixel; // the level-0 pixel it was copied from: where the surface really is
    bool  inside; // whether it lies in the buffer; else the border stands in for what is not known
};

vec2 dgb_rotation(ivec2 pixel, int frame) { return texelFetch(dgb_rotations, ivec2(dgb_pixel_hash(pixel, frame), 0), 0).rg; }

struct dgb_spiral { // what the taps of one pixel have in common; compilers for GPUs do not find it in a loop
    vec2  centre, rotation;
    float reach; // pixels
    ivec2 size;  // of the buffer
    vec2  last;  // the last position in it: the float before its size
};

// size: of the buffer, (unused), frame.
dgb_spiral dgb_spiral_at(vec2 centre, float reach, ivec4 size) {
    return dgb_spiral(centre, dgb_rotation(ivec2(centre), size.w), reach, size.xy, vec2(size.xy) * 0.99999994);
}

// The tap at a position in the buffer, h pixels from the centre; levels: log2 q, min, max.
dgb_tap dgb_tap_of(vec2 at, float h, ivec2 size, ivec4 levels) {
    dgb_tap tap;
    tap.level  = dgb_mip_level(h, levels.x, levels.y, levels.z);
    tap.texel  = min(ivec2(at), size - (1 << tap.level)) >> tap.level; // a level's last texels stand for all that is left
    tap.pixel  = dgb_mip_source(tap.texel, tap.level);
    tap.inside = true;
    return tap;
}

// table: cos, sin, kappa of the tap.
dgb_tap dgb_tap_at(vec4 table, dgb_spiral s, ivec4 levels) {
    float h         = max(s.reach * table.z, 0.75); // nearer taps would land on the shaded pixel itself
    vec2  direction = vec2(table.x * s.rotation.x - table.y * s.rotation.y, table.x * s.rotation.y + table.y * s.rotation.x);
    vec2  at        = s.centre + h * direction, within = clamp(at, vec2(0.0), s.last);
    bool  inside    = at == within; // asked first, so that `at` takes no registers in the meantime
    dgb_tap tap     = dgb_tap_of(within, h, s.size, levels);
    tap.inside      = inside;
    return tap;
}

// How far it is to the border of the buffer; direction: unit.
float dgb_room(vec2 at, vec2 direction, vec2 size) {
    vec2 room = mix(at, size - at, greaterThan(direction, vec2(0.0))) / max(abs(direction), 1e-6);
    return min(room.x, room.y);
}

#if DGB_LAYERS > 1
uniform sampler2D dgb_tiles;

// Whether the second layer matters to occlusion, to light, and is there, in the pixel's tile; all: as if it did everywhere.
bvec3 dgb_tile_at(ivec2 pixel, bool all) {
    return greaterThan(texelFetch(dgb_tiles, pixel >> DGB_LOG2_TILE, 0).rgb + vec3(all), vec3(0.0));
}
#endif
