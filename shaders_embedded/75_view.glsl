// What dgbgl_draw_view shows: a texture of the library's as colours, scaled to a rectangle of any framebuffer.
layout(std140) uniform dgb_view_block {
    dgb_camera dgb_view_camera;
    vec4       dgb_view_rectangle; // lower left corner; pixels of the image a pixel of the rectangle: x, y
    vec4       dgb_view_scale;     // factor of light; m where depth has fallen to an eighth; weight of history
    ivec4      dgb_view_choice;    // view, layer, its divisor, guard band of its texture
    ivec4      dgb_view_has;       // x: packed z
};

uniform sampler2DArray dgb_view_depth;
uniform sampler2DArray dgb_view_layer;
uniform sampler2D      dgb_view_image;
uniform sampler2D      dgb_view_z;

out vec4 dgb_view_color;

vec3 dgb_srgb(vec3 x) {
    vec3 low = 12.92 * x, high = 1.055 * pow(max(x, 0.0), vec3(1.0 / 2.4)) - 0.055;
    return vec3(x.r < 0.0031308 ? low.r : high.r, x.g < 0.0031308 ? low.g : high.g, x.b < 0.0031308 ? low.b : high.b);
}

// Narkowicz's fit of the ACES filmic curve: 1 becomes 0.8, highlights roll off towards 1.
vec3 dgb_filmic(vec3 light) {
    vec3 x = min(dgb_view_scale.x * light, 1e4);
    return dgb_srgb(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14));
}

// 1 at the eye, an eighth at dgb_view_scale.y.
float dgb_nearness(float depth) { return exp2(3.0 * dgb_linear_z(depth, dgb_view_camera) / dgb_view_scale.y); }

vec3 dgb_velocity_color(vec2 velocity) { return vec3(clamp(0.5 + velocity / 32.0, 0.0, 1.0), 0.5); }

// Over the first layer, dimmed: what this one keeps, and what was too near to the first to be kept.
vec3 dgb_validity_color(ivec2 pixel, bool empty) {
    float first = texelFetch(dgb_view_depth, ivec3(pixel, 0), 0).r;
    vec3  dim   = first == dgb_view_camera.footprint.w ? vec3(0.0) : vec3(0.1 + 0.3 * dgb_nearness(first));
    bool  kept  = true;
    if (dgb_view_has.x != 0 && dgb_view_choice.y < 2)
        kept = texelFetch(dgb_view_z, pixel, 0)[dgb_view_choice.y] > DGB_EMPTY_Z;
    return empty ? dim : dim + (kept ? vec3(0.0, 0.5, 0.5) : vec3(0.6, 0.0, 0.0));
}

vec3 dgb_layer_color(ivec2 pixel) {
    ivec3 texel = ivec3(pixel / dgb_view_choice.z, dgb_view_choice.y);
    float depth = texelFetch(dgb_view_depth, texel, 0).r;
    vec4  value = texelFetch(dgb_view_layer, texel, 0);
    bool  empty = depth == dgb_view_camera.footprint.w;
    int   view  = dgb_view_choice.x;
    if (view == DGB_VIEW_VALIDITY) return dgb_validity_color(pixel, empty);
    if (view == DGB_VIEW_DEPTH) return empty ? vec3(0.05, 0.08, 0.3) : vec3(dgb_nearness(depth));
    if (empty) return vec3(0.0);
    if (view == DGB_VIEW_NORMAL) return 0.5 + 0.5 * dgb_oct16_decode(value.rg);
    if (view == DGB_VIEW_ALBEDO) return dgb_srgb(value.rgb);
    if (view == DGB_VIEW_RADIANCE) return dgb_filmic(value.rgb);
    return dgb_velocity_color(value.rg);
}

vec3 dgb_history_color(vec4 value) {
    float frames = max(value.g, value.b); // averaged of visibility, of light
    float share  = min(frames / (frames + 1.0), dgb_view_scale.z) / max(dgb_view_scale.z, 1e-3);
    return frames == 0.0 ? vec3(0.0) : mix(vec3(0.8, 0.1, 0.0), vec3(1.0), share * share);
}

vec3 dgb_image_color(ivec2 pixel) {
    vec4 value = texelFetch(dgb_view_image, pixel, 0);
    int  view  = dgb_view_choice.x;
    if (view == DGB_VIEW_AO) return value.rrr;
    if (view == DGB_VIEW_IRRADIANCE) return dgb_filmic(value.rgb / DGB_PI);
    if (view == DGB_VIEW_CONFIDENCE) return value.aaa;
    if (view == DGB_VIEW_HISTORY) return dgb_history_color(value);
    if (view == DGB_VIEW_REFLECTION) return dgb_filmic(value.rgb * value.a);
    if (view == DGB_VIEW_REFLECTION_LAYER)
        return value.r == 0.0 ? vec3(0.0) : value.r < 1.5 ? vec3(0.1, 0.3, 0.9) : vec3(1.0, 0.5, 0.0);
    return dgb_filmic(value.rgb);
}

void main() {
    ivec2 pixel    = ivec2((gl_FragCoord.xy - dgb_view_rectangle.xy) * dgb_view_rectangle.zw) + dgb_view_choice.w;
    bool  of_layer = dgb_view_choice.x <= DGB_VIEW_VALIDITY;
    dgb_view_color = vec4(of_layer ? dgb_layer_color(pixel) : dgb_image_color(pixel), 1.0);
}
