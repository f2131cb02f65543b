// Tiles: where the second layer can matter at all. Three steps: the depth range of each tile, of each region of 8 x 8 tiles, and
// for each tile whether a second-layer surface lies within reach of its pixels. What it rejects, no tap would have found: the
// results are the same, bit for bit, only the work is less.

const int DGB_LOG2_REGION = 7; // 8 x 8 tiles

#if DGB_TILES_STEP < 2
layout(location = 0) out vec4 dgb_out_depths;
#endif

#if DGB_TILES_STEP == 0
uniform sampler2D dgb_z;

void main() {
    ivec2 tile = ivec2(gl_FragCoord.xy), last = textureSize(dgb_z, 0) - 1;
    vec4  depths = DGB_NO_DEPTHS;
    for (int y = 0; y < 1 << DGB_LOG2_TILE; ++y)
        for (int x = 0; x < 1 << DGB_LOG2_TILE; ++x)
            depths = dgb_join(depths, dgb_depths_of(texelFetch(dgb_z, min((tile << DGB_LOG2_TILE) + ivec2(x, y), last), 0).xy));
    dgb_out_depths = depths;
}
#elif DGB_TILES_STEP == 1
uniform sampler2D dgb_tile_depths;

void main() {
    ivec2 region = ivec2(gl_FragCoord.xy), last = textureSize(dgb_tile_depths, 0) - 1;
    vec4  depths = DGB_NO_DEPTHS;
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 8; ++x)
            depths = dgb_join(depths, texelFetch(dgb_tile_depths, min(region * 8 + ivec2(x, y), last), 0));
    dgb_out_depths = depths;
}
#else
layout(std140) uniform dgb_tiles_block {
    dgb_camera dgb_tiles_camera;
    vec4       dgb_tiles_radius; // of occlusion and of light (m), largest reach, 2^least level (pixels)
};

uniform sampler2D dgb_tile_depths;
uniform sampler2D dgb_region_depths;

layout(location = 0) out vec4 dgb_out_tiles; // the second layer matters to occlusion, to light, and is there

const float DGB_FEW_TILES = 64.0; // pixels of reach up to which tiles are looked at one by one, beyond by regions

bool dgb_within(vec4 theirs, vec4 ours, float radius) { return theirs.w <= ours.x + radius && theirs.z >= ours.y - radius; }

// Whether any second-layer surface lies within the radius, in depth and in the image, of any first-layer surface of the tile.
bool dgb_second_matters(ivec2 tile, vec4 ours, float radius) {
    float reach = dgb_reach(ours.x, radius, dgb_tiles_radius.z, dgb_tiles_camera);
    float range = radius * 1.001; // rounding must not decide
    // a tap at MIP level m lies up to 2 * 2^m pixels off; it is 8 * 2^m away, or m is the least level
    float pixels = reach * 1.25 + 2.0 * dgb_tiles_radius.w + 1.0;
    bool  few    = pixels <= DGB_FEW_TILES;
    int   shift  = few ? DGB_LOG2_TILE : DGB_LOG2_REGION;
    ivec2 last   = few ? textureSize(dgb_tile_depths, 0) - 1 : textureSize(dgb_region_depths, 0) - 1;
    ivec2 corner = tile << DGB_LOG2_TILE;
    ivec2 low    = max((corner - int(ceil(pixels))) >> shift, ivec2(0));
    ivec2 high   = min((corner + (1 << DGB_LOG2_TILE) + int(ceil(pixels))) >> shift, last);
    bool  found  = false;
    for (int y = ours.x > DGB_EMPTY_Z ? low.y : high.y + 1; y <= high.y; ++y)
        for (int x = low.x; x <= high.x; ++x) {
            vec4 theirs = few ? texelFetch(dgb_tile_depths, ivec2(x, y), 0) : texelFetch(dgb_region_depths, ivec2(x, y), 0);
            found       = found || dgb_within(theirs, ours, range);
        }
    return found;
}

void main() {
    ivec2 tile    = ivec2(gl_FragCoord.xy);
    vec4  ours    = texelFetch(dgb_tile_depths, tile, 0);
    bool  ao      = dgb_second_matters(tile, ours, dgb_tiles_radius.x);
    bool  light   = dgb_second_matters(tile, ours, dgb_tiles_radius.y);
    dgb_out_tiles = vec4(ao, light, ours.z > DGB_EMPTY_Z, 1.0);
}
#endif
