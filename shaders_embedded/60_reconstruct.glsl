// Reconstruction: separable bilateral filter with normal and plane weights over ambient visibility, irradiance and
// confidence together, for the second layer along its own surfaces; run along x, then along y.

layout(std140) uniform dgb_reconstruct_block {
    dgb_camera dgb_reconstruct_camera;
    ivec4      dgb_reconstruct_rect;      // shaded rectangle: x0, y0, x1, y1 inclusive
    ivec4      dgb_reconstruct_axis;      // step in x, in y, taps on one side
    vec4       dgb_reconstruct_sharpness; // normal, plane
    vec4       dgb_reconstruct_weights[DGB_MAX_FILTER_RADIUS + 1];
};

uniform sampler2D dgb_z;
uniform sampler2D dgb_normals;
#if DGB_FILTER_AO
uniform sampler2D dgb_ao_raw;
#endif
#if DGB_FILTER_IRRADIANCE
uniform sampler2D dgb_irradiance_raw;
#endif
#if DGB_DEEP
uniform sampler2D dgb_irradiance1_raw;
#endif

#if DGB_FILTER_AO
layout(location = 0) out vec4 dgb_out_ao;
#endif
#if DGB_FILTER_IRRADIANCE
layout(location = DGB_FILTER_AO) out vec4 dgb_out_irradiance;
#endif
#if DGB_DEEP && DGB_FILTER_AO
layout(location = 2) out vec4 dgb_out_irradiance1;
#elif DGB_DEEP
layout(location = 1) out vec4 dgb_out_irradiance1;
#endif

// Weight of the surface at y, with normal n2, for the one at x; i steps away.
float dgb_weight(vec3 x, vec3 n, vec3 y, vec2 n2, int i) {
    float weight = dgb_bilateral_weight(n, dgb_oct16_decode(n2), y - x, dgb_reconstruct_sharpness.x, dgb_reconstruct_sharpness.y);
    return y.z > DGB_EMPTY_Z ? weight * dgb_reconstruct_weights[abs(i)].x : 0.0;
}

void main() {
    ivec2 axis    = dgb_reconstruct_axis.xy;
    ivec2 pixel   = ivec2(gl_FragCoord.xy);
    vec2  z       = texelFetch(dgb_z, pixel, 0).xy;
    vec4  normals = texelFetch(dgb_normals, pixel, 0);
    vec3  x       = dgb_position(gl_FragCoord.xy, z.x, dgb_reconstruct_camera);
    vec3  n       = dgb_oct16_decode(normals.xy);

    // the taps that lie in the shaded rectangle
    ivec2 room_before = (pixel - dgb_reconstruct_rect.xy) / max(axis, 1);
    ivec2 room_after  = (dgb_reconstruct_rect.zw - pixel) / max(axis, 1);
    int   side        = z.x > DGB_EMPTY_Z ? dgb_reconstruct_axis.z : 0;
    int   first       = -min(side, axis.x > 0 ? room_before.x : room_before.y);
    int   last        = min(side, axis.x > 0 ? room_after.x : room_after.y);

    float total = dgb_reconstruct_weights[0].x;
#if DGB_FILTER_AO
    float ao = total * texelFetch(dgb_ao_raw, pixel, 0).x;
#endif
#if DGB_FILTER_IRRADIANCE
    vec4 irradiance = total * dgb_weigh(texelFetch(dgb_irradiance_raw, pixel, 0));
#endif
    for (int i = first < 0 ? first : 1; i <= last; i += i == -1 ? 2 : 1) { // every tap but the centre
        ivec2 p      = pixel + i * axis;
        vec3  y      = dgb_position(vec2(p) + 0.5, texelFetch(dgb_z, p, 0).x, dgb_reconstruct_camera);
        float weight = dgb_weight(x, n, y, texelFetch(dgb_normals, p, 0).xy, i);
        total += weight;
#if DGB_FILTER_AO
        ao += weight * texelFetch(dgb_ao_raw, p, 0).x;
#endif
#if DGB_FILTER_IRRADIANCE
        irradiance += weight * dgb_weigh(texelFetch(dgb_irradiance_raw, p, 0));
#endif
    }
#if DGB_FILTER_AO
    dgb_out_ao = vec4(ao / total);
#endif
#if DGB_FILTER_IRRADIANCE
    irradiance         = dgb_unweigh(irradiance / total);
    dgb_out_irradiance = vec4(dgb_storable(irradiance.rgb), irradiance.a);
#endif

#if DGB_DEEP
    // the second layer, where there is one: in a loop of its own, so that it costs nothing elsewhere
    bool empty = !(z.y > DGB_EMPTY_Z);
    x          = dgb_position(dgb_centre(1, pixel), z.y, dgb_reconstruct_camera);
    n          = dgb_oct16_decode(normals.zw);
    total      = dgb_reconstruct_weights[0].x;
    irradiance = total * dgb_weigh(texelFetch(dgb_irradiance1_raw, pixel, 0));
    for (int i = empty ? last + 1 : first < 0 ? first : 1; i <= last; i += i == -1 ? 2 : 1) {
        ivec2 p      = pixel + i * axis;
        vec3  y      = dgb_position(dgb_centre(1, p), texelFetch(dgb_z, p, 0).y, dgb_reconstruct_camera);
        float weight = dgb_weight(x, n, y, texelFetch(dgb_normals, p, 0).zw, i);
        total += weight;
        irradiance += weight * dgb_weigh(texelFetch(dgb_irradiance1_raw, p, 0));
    }
    irradiance          = dgb_unweigh(irradiance / total);
    dgb_out_irradiance1 = vec4(dgb_storable(irradiance.rgb), irradiance.a);
#endif
}
