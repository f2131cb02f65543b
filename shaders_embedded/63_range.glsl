// Range: the depth ranges by which the hierarchical tracer skips what a ray cannot meet. There is a cell of level m for every
// 4 * 2^m pixels along a side, but it holds the range of twice as many, those of its neighbours to the right and above with its
// own: a stretch of a ray that is shorter than a cell lies wholly within what one cell holds, whatever borders it crosses.

layout(location = 0) out vec4 dgb_out_ranges; // largest and smallest z of layer 0, of layer 1

#if DGB_RANGE_STEP == 0
uniform sampler2D dgb_z;

const int DGB_CHILDREN = 4, DGB_NEXT = 1; // along a side of a cell; from one to the next

vec4 dgb_child(ivec2 p) { return dgb_depths_of(texelFetch(dgb_z, min(p, textureSize(dgb_z, 0) - 1), 0).xy); }
#else
uniform sampler2D dgb_ranges; // the level before

const int DGB_CHILDREN = 2, DGB_NEXT = 2; // every other one: they overlap

vec4 dgb_child(ivec2 p) { return texelFetch(dgb_ranges, min(p, textureSize(dgb_ranges, 0) - 1), 0); }
#endif

void main() {
    ivec2 corner = DGB_CHILDREN * ivec2(gl_FragCoord.xy);
    vec4  range  = DGB_NO_DEPTHS;
    for (int y = 0; y < 2 * DGB_CHILDREN; y += DGB_NEXT)
        for (int x = 0; x < 2 * DGB_CHILDREN; x += DGB_NEXT) range = dgb_join(range, dgb_child(corner + ivec2(x, y)));
    dgb_out_ranges = range;
}
