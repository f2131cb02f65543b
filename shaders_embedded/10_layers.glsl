// Start of every material shader that draws into the layers: what the keep test needs to know about the frame.

const int DGB_ORACLE_REPROJECT = 3;

layout(std140) uniform dgb_draw_block {
    dgb_camera dgb_draw_camera;
    dgb_camera dgb_draw_previous;          // of the frame that the oracle holds
    vec4       dgb_draw_distance;          // distance = dot(this.xyz, vec3(clip.z, clip.w, 1))
    vec4       dgb_draw_previous_distance;
    vec4       dgb_draw_size;              // buffer width, height (pixels), separation (m), depth codes (0: float depth)
    ivec4      dgb_draw_layer;             // first layer, layer count, oracle, instance multiplier
    ivec4      dgb_draw_flags;             // divisor of deeper layers' resolution, 1 for reversed depth
};
