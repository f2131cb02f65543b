// Mip: texel p copies texel 2p + (p.y & 1, p.x & 1) of the level before. Copying, not averaging: an average of two depths or
// of two encoded normals is neither. dgb_mip_levels stops where the copy would leave the texture.

uniform sampler2D dgb_z;
layout(location = 0) out vec4 dgb_out_z;
#if DGB_PACK_RADIANCE
uniform sampler2D dgb_normals;
uniform sampler2D dgb_b0;
layout(location = 1) out vec4 dgb_out_normals;
layout(location = 2) out vec4 dgb_out_b0;
#if DGB_LAYERS > 1
uniform sampler2D dgb_b1;
layout(location = 3) out vec4 dgb_out_b1;
#endif
#endif

void main() {
    ivec2 p   = ivec2(gl_FragCoord.xy);
    ivec2 q   = 2 * p + (p.yx & 1);
    dgb_out_z = texelFetch(dgb_z, q, 0);
#if DGB_PACK_RADIANCE
    dgb_out_normals = texelFetch(dgb_normals, q, 0);
    dgb_out_b0      = texelFetch(dgb_b0, q, 0);
#if DGB_LAYERS > 1
    dgb_out_b1 = texelFetch(dgb_b1, q, 0);
#endif
#endif
}
