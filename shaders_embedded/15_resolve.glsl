// Resolve, after image emission: the depth bits of a deeper layer become its depth.

layout(std140) uniform dgb_resolve_block {
    ivec4 dgb_resolve_layer; // x: image of the key
};

uniform usampler2DArray dgb_key;

void main() {
    gl_FragDepth = uintBitsToFloat(texelFetch(dgb_key, ivec3(ivec2(gl_FragCoord.xy), dgb_resolve_layer.x), 0).x);
}
