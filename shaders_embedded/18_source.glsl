// What the layers hold at a pixel, shared by pack, temporal, reflect and glossy; `layer` is constant wherever these are called.

#if DGB_ENGINE_LAYERS
uniform sampler2D dgb_engine_depth0;
uniform sampler2D dgb_engine_depth1;
uniform sampler2D dgb_engine_normal0;
uniform sampler2D dgb_engine_normal1;
uniform sampler2D dgb_engine_radiance0;
uniform sampler2D dgb_engine_radiance1;
uniform sampler2D dgb_engine_albedo0;
uniform sampler2D dgb_engine_albedo1;
uniform sampler2D dgb_engine_velocity0;
uniform sampler2D dgb_engine_velocity1;
uniform sampler2D dgb_engine_back;
uniform sampler2D dgb_engine_roughness;

float dgb_depth_at(int layer, ivec2 p) { return layer == 0 ? texelFetch(dgb_engine_depth0, p, 0).r : texelFetch(dgb_engine_depth1, p, 0).r; }
vec3  dgb_normal_at(int layer, ivec2 p) { return layer == 0 ? texelFetch(dgb_engine_normal0, p, 0).rgb : texelFetch(dgb_engine_normal1, p, 0).rgb; }
vec3  dgb_radiance_at(int layer, ivec2 p) { return layer == 0 ? texelFetch(dgb_engine_radiance0, p, 0).rgb : texelFetch(dgb_engine_radiance1, p, 0).rgb; }
vec3  dgb_albedo_at(int layer, ivec2 p) { return layer == 0 ? texelFetch(dgb_engine_albedo0, p, 0).rgb : texelFetch(dgb_engine_albedo1, p, 0).rgb; }
vec3  dgb_velocity_at(int layer, ivec2 p) { return layer == 0 ? texelFetch(dgb_engine_velocity0, p, 0).rgb : texelFetch(dgb_engine_velocity1, p, 0).rgb; }
float dgb_back_at(ivec2 p) { return texelFetch(dgb_engine_back, p, 0).r; }
float dgb_roughness_at(ivec2 p) { return texelFetch(dgb_engine_roughness, p, 0).r; }
#else
uniform sampler2DArray dgb_depth;
uniform sampler2DArray dgb_normal;
uniform sampler2DArray dgb_radiance;
uniform sampler2DArray dgb_albedo;
uniform sampler2DArray dgb_velocity;
uniform sampler2D dgb_back;

// Deeper layers may have a lower resolution: they fill a part of their images.
ivec3 dgb_texel(int layer, ivec2 p) { return ivec3(p / (layer > 0 ? DGB_DIVISOR : 1), layer); }

float dgb_depth_at(int layer, ivec2 p) { return texelFetch(dgb_depth, dgb_texel(layer, p), 0).r; }
vec3  dgb_normal_at(int layer, ivec2 p) { return texelFetch(dgb_normal, dgb_texel(layer, p), 0).rgb; }
vec3  dgb_radiance_at(int layer, ivec2 p) { return texelFetch(dgb_radiance, dgb_texel(layer, p), 0).rgb; }
vec3  dgb_albedo_at(int layer, ivec2 p) { return texelFetch(dgb_albedo, dgb_texel(layer, p), 0).rgb; }
vec3  dgb_velocity_at(int layer, ivec2 p) { return texelFetch(dgb_velocity, dgb_texel(layer, p), 0).rgb; }
float dgb_back_at(ivec2 p) { return texelFetch(dgb_back, dgb_texel(1, p).xy, 0).r; }
float dgb_roughness_at(ivec2 p) { return texelFetch(dgb_normal, ivec3(p, 0), 0).b; }
#endif
