// Reconstruction: separable bilateral filter with normal and plane weights over ambient visibility, irradiance and
// confidence together; run along x, then along y.

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

#if DGB_FILTER_AO
layout(location = 0) out vec4 dgb_out_ao;
#endif
#if DGB_FILTER_IRRADIANCE
layout(location = DGB_FILTER_AO) out vec4 dgb_out_irradiance;
#endif

void main() {
    dgb_camera camera = dgb_reconstruct_camera;
    ivec2      axis   = dgb_reconstruct_axis.xy;
    ivec2      pixel  = ivec2(gl_FragCoord.xy);
    float      z      = texelFetch(dgb_z, pixel, 0).x;
    vec3       n      = dgb_oct16_decode(texelFetch(dgb_normals, pixel, 0).xy);

    // offset of the point i steps away, at depth zi: (ray_z + i step_z) zi + (ray_1 + i step_1)
    vec2 ray_z  = gl_FragCoord.xy * camera.position_z.xy + camera.position_z.zw;
    vec2 ray_1  = -ray_z * z;
    vec2 step_z = vec2(axis) * camera.position_z.xy;
    vec2 step_1 = vec2(axis) * camera.position_1.xy;

    // the taps that lie in the shaded rectangle
    ivec2 room_before = (pixel - dgb_reconstruct_rect.xy) / max(axis, 1);
    ivec2 room_after  = (dgb_reconstruct_rect.zw - pixel) / max(axis, 1);
    int   side        = z > DGB_EMPTY_Z ? dgb_reconstruct_axis.z : 0;
    int   first       = -min(side, axis.x > 0 ? room_before.x : room_before.y);
    int   last        = min(side, axis.x > 0 ? room_after.x : room_after.y);

    float total = dgb_reconstruct_weights[0].x;
#if DGB_FILTER_AO
    float ao = total * texelFetch(dgb_ao_raw, pixel, 0).x;
#endif
#if DGB_FILTER_IRRADIANCE
    vec4 irradiance = total * texelFetch(dgb_irradiance_raw, pixel, 0);
#endif
    for (int i = first < 0 ? first : 1; i <= last; i += i == -1 ? 2 : 1) { // every tap but the centre
        ivec2 p      = pixel + i * axis;
        float zi     = texelFetch(dgb_z, p, 0).x;
        vec3  ni     = dgb_oct16_decode(texelFetch(dgb_normals, p, 0).xy);
        vec3  dq     = vec3((ray_z + float(i) * step_z) * zi + (ray_1 + float(i) * step_1), zi - z);
        float weight = dgb_bilateral_weight(n, ni, dq, dgb_reconstruct_sharpness.x, dgb_reconstruct_sharpness.y);
        weight       = zi > DGB_EMPTY_Z ? weight * dgb_reconstruct_weights[abs(i)].x : 0.0;
        total += weight;
#if DGB_FILTER_AO
        ao += weight * texelFetch(dgb_ao_raw, p, 0).x;
#endif
#if DGB_FILTER_IRRADIANCE
        irradiance += weight * texelFetch(dgb_irradiance_raw, p, 0);
#endif
    }
#if DGB_FILTER_AO
    dgb_out_ao = vec4(ao / total);
#endif
#if DGB_FILTER_IRRADIANCE
    dgb_out_irradiance = vec4(dgb_storable(irradiance.rgb / total), irradiance.a / total);
#endif
}
