// Vertex part. Call dgb_vertex once, last; use dgb_instance() instead of gl_InstanceID.

out vec4      dgb_v_current;  // clip x, y in pixels times w; clip w; distance in metres
out vec4      dgb_v_previous; // the same point's, one frame ago
#if !(DGB_EMISSION_SEPARATE || DGB_EMISSION_IMAGE)
flat out int  dgb_v_layer;
#endif

int dgb_instance() { return gl_InstanceID / dgb_draw_layer.w; }

// clip: gl_Position of this frame; previous_clip: where the same point of the same object was last frame.
void dgb_vertex(vec4 clip, vec4 previous_clip) {
    vec2 scale     = 0.5 * dgb_draw_size.xy;
    gl_Position    = clip;
    dgb_v_current  = vec4(clip.xy * scale, clip.w, dot(dgb_draw_distance.xyz, vec3(clip.zw, 1.0)));
    dgb_v_previous = vec4(previous_clip.xy * scale, previous_clip.w,
                          dot(dgb_draw_previous_distance.xyz, vec3(previous_clip.zw, 1.0)));
#if !(DGB_EMISSION_SEPARATE || DGB_EMISSION_IMAGE)
    dgb_v_layer = dgb_draw_layer.x;
#endif
#if DGB_EMISSION_VERTEX
    dgb_v_layer += gl_InstanceID % dgb_draw_layer.w;
    gl_Layer = dgb_v_layer; // ignored while layers are drawn one at a time
#if DGB_DIVISOR > 1
    gl_ViewportIndex = dgb_draw_layer.y > 1 && dgb_v_layer > 0 ? 1 : 0;
#endif
#endif
}
