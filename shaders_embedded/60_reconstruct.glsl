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

float dgb_weight_at(ivec2 p, vec3 x, vec3 n) {
    float z      = texelFetch(dgb_z, p, 0).x;
    vec3  n2     = dgb_oct16_decode(texelFetch(dgb_normals, p, 0).xy);
    vec3  dq     = dgb_position(vec2(p) + 0.5, z, dgb_reconstruct_camera) - x;
    float weight = dgb_bilateral_weight(n, n2, dq, dgb_reconstruct_sharpness.x, dgb_reconstruct_sharpness.y);
    return z != 0.0 ? weight : 0.0;
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float z     = texelFetch(dgb_z, pixel, 0).x;
    vec3  x     = dgb_position(gl_FragCoord.xy, z, dgb_reconstruct_camera);
    vec3  n     = dgb_oct16_decode(texelFetch(dgb_normals, pixel, 0).xy);
    int   side  = z != 0.0 ? dgb_reconstruct_axis.z : 0;
    float total = dgb_reconstruct_weights[0].x;
#if DGB_FILTER_AO
    float ao = total * texelFetch(dgb_ao_raw, pixel, 0).x;
#endif
#if DGB_FILTER_IRRADIANCE
    vec4 irradiance = total * texelFetch(dgb_irradiance_raw, pixel, 0);
#endif
    for (int i = -side; i <= side; ++i) {
        ivec2 p      = pixel + i * dgb_reconstruct_axis.xy;
        ivec2 inside = clamp(p, dgb_reconstruct_rect.xy, dgb_reconstruct_rect.zw);
        float weight = i != 0 && p == inside ? dgb_reconstruct_weights[abs(i)].x * dgb_weight_at(inside, x, n) : 0.0;
        total += weight;
#if DGB_FILTER_AO
        ao += weight * texelFetch(dgb_ao_raw, inside, 0).x;
#endif
#if DGB_FILTER_IRRADIANCE
        irradiance += weight * texelFetch(dgb_irradiance_raw, inside, 0);
#endif
    }
#if DGB_FILTER_AO
    dgb_out_ao = vec4(ao / total);
#endif
#if DGB_FILTER_IRRADIANCE
    dgb_out_irradiance = vec4(dgb_storable(irradiance.rgb / total), irradiance.a / total);
#endif
}
