// Warp: last frame's depth as this frame's camera sees it, for a world that stands still. One run a layer. A guess of the depth at
// a pixel says which texel of last frame to look at, and what is there is the next guess (a fixed point). It starts twice: from
// the depth that the pixel had, and from the nearest depth around it, which finds what comes in front.

layout(std140) uniform dgb_warp_block {
    dgb_camera dgb_warp_camera;
    dgb_camera dgb_warp_last;
    vec4       dgb_warp_to_last[3]; // rows: from this frame's camera space to last frame's
    ivec4      dgb_warp_layer;      // layer, pixels a texel along one side, last column and row of texels
    vec4       dgb_warp_depth;      // depth codes
};

uniform sampler2DArray dgb_oracle; // last frame's depth

const int   DGB_WARP_LOOKS = 3;     // texels looked at from each start
const float DGB_WARP_INSIDE = 0.505; // texels from a texel's centre that are still it: half, and rounding

// The pixel's ray in last frame's camera space: z of this frame's camera times `along`, plus `from`.
struct dgb_ray {
    vec3 along, from;
};

struct dgb_find {
    float z;     // camera space, m
    float depth; // of the texel looked at
    float off;   // texels from its centre to where the point was, the larger of x and y
};

vec3 dgb_to_last(vec3 v, float w) {
    vec4 point = vec4(v, w);
    return vec3(dot(dgb_warp_to_last[0], point), dot(dgb_warp_to_last[1], point), dot(dgb_warp_to_last[2], point));
}

float dgb_last_depth(ivec2 texel) {
    return texelFetch(dgb_oracle, ivec3(clamp(texel, ivec2(0), dgb_warp_layer.zw), dgb_warp_layer.x), 0).r;
}

// Sky lies on the far plane, or where there is none at the greatest distance.
float dgb_last_z(float depth) {
    float z   = dgb_linear_z(dgb_depth_code(depth, dgb_warp_depth.x), dgb_warp_last);
    float far = dgb_warp_last.linearise.x / dgb_warp_last.linearise.z;
    return z != 0.0 ? z : abs(far) <= DGB_MAX_DISTANCE ? far : DGB_EMPTY_Z;
}

// Where the point at z was, in texels of last frame; beyond the buffer, on its border.
vec2 dgb_last_texel(dgb_ray ray, float z) {
    vec2 texel = dgb_project(ray.along * z + ray.from, dgb_warp_last) / float(dgb_warp_layer.y);
    return clamp(texel, vec2(0.0), vec2(dgb_warp_layer.zw) + 1.0);
}

dgb_find dgb_look(dgb_ray ray, float z_last) {
    dgb_find find;
    vec2     at;
    float    z = (z_last - ray.from.z) / ray.along.z; // exactly z_last when the camera stands still
    for (int i = 0; i < DGB_WARP_LOOKS; ++i) {
        at         = floor(dgb_last_texel(ray, z));
        find.depth = dgb_last_depth(ivec2(at));
        z          = (dgb_last_z(find.depth) - ray.from.z) / ray.along.z;
    }
    vec2 off = abs(dgb_last_texel(ray, z) - (min(at, vec2(dgb_warp_layer.zw)) + 0.5));
    find.z   = z;
    find.off = max(off.x, off.y);
    return find;
}

// Nearest depth among the pixel and eight around it, as far off as things come nearer in a frame. Reversed depth is compared
// with its sign changed.
float dgb_nearest_around(ivec2 texel) {
    float empty = dgb_warp_last.footprint.w, order = empty > 0.0 ? 1.0 : -1.0, nearest = order * empty;
    for (int y = -16; y <= 16; y += 16)
        for (int x = -16; x <= 16; x += 16) nearest = min(nearest, order * dgb_last_depth(texel + ivec2(x, y)));
    return dgb_last_z(order * nearest);
}

// The inverse of dgb_linear_z.
float dgb_depth_of(float z, dgb_camera camera) {
    vec4 l = camera.linearise;
    return (l.x - l.z * z) / (l.w * z - l.y) + camera.footprint.w;
}

void main() {
    ivec2    texel = ivec2(gl_FragCoord.xy);
    vec2     pixel = gl_FragCoord.xy * float(dgb_warp_layer.y);
    vec3     one   = dgb_position(pixel, 1.0, dgb_warp_camera), zero = dgb_position(pixel, 0.0, dgb_warp_camera);
    dgb_ray  ray   = dgb_ray(dgb_to_last(one - zero, 0.0), dgb_to_last(zero, 1.0));
    float    own   = dgb_last_depth(texel);
    dgb_find a     = dgb_look(ray, dgb_last_z(own)), b = dgb_look(ray, dgb_nearest_around(texel));
    bool     a_in  = a.off <= DGB_WARP_INSIDE, b_in = b.off <= DGB_WARP_INSIDE;
    // the nearer of two surfaces that are there, else what is least far off
    if (b_in ? !a_in || b.z > a.z : !a_in && b.off < a.off) a = b;
    float same   = dgb_linear_z(dgb_depth_code(a.depth, dgb_warp_depth.x), dgb_warp_camera);
    float depth  = a.z == same ? a.depth : dgb_depth_of(a.z, dgb_warp_camera);
    gl_FragDepth = same == 0.0 ? dgb_warp_camera.footprint.w : depth >= 0.0 && depth <= 1.0 ? depth : own;
}
