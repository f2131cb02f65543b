// Where a surface was last frame, and which texels of last frame show it (paper, section 3.3). Shared by pack and temporal.

struct dgb_reprojection {
    dgb_camera last;
    vec4       to_last[3]; // rows: from this frame's camera space to last frame's
    vec4       tolerance;  // share of the distance, least (m), 1 if last frame is of use, 0 if nothing has moved since
    ivec4      rect;       // shaded last frame: x0, y0, x1, y1, the last two inclusive
};

uniform sampler2D dgb_last_z;
#if DGB_LAST_LIGHT
uniform sampler2D dgb_last_irradiance;
#endif
#if DGB_DEEP
uniform sampler2D dgb_last_irradiance1;
#endif

// A point last frame.
struct dgb_past {
    vec2  pixel;
    vec3  point;     // camera space
    vec3  normal;
    float tolerance; // how far from it a texel may be and still show it, m; -1: there is no such frame or no such place
};

vec2 dgb_project(vec3 point, dgb_camera camera) {
    vec4 a = camera.position_z, b = camera.position_1;
    return (point.xy - a.zw * point.z - b.zw) / (a.xy * point.z + b.xy);
}

// velocity: pixels since last frame, and metres of z by which the object itself moved, where the engine says so. Where it does
// not, nobody knows how far an object came nearer: as far, it is assumed, as it moved across.
dgb_past dgb_past_of(vec2 pixel, vec3 x, vec3 n, vec3 velocity, dgb_reprojection r) {
    dgb_past past;
    vec4     a   = r.to_last[0], b = r.to_last[1], c = r.to_last[2];
    past.point   = vec3(dot(a, vec4(x, 1.0)), dot(b, vec4(x, 1.0)), dot(c, vec4(x, 1.0)));
    past.normal  = vec3(dot(a.xyz, n), dot(b.xyz, n), dot(c.xyz, n));
    past.pixel   = pixel - velocity.xy * r.tolerance.w;
    float scale  = dgb_pixels_per_metre(past.point.z, r.last);
    vec2  own    = past.pixel - dgb_project(past.point, r.last); // what the camera did not do
    float least  = max(r.tolerance.x * abs(past.point.z), r.tolerance.y) + length(own) / scale;
    vec2  low    = vec2(r.rect.xy), high = vec2(r.rect.zw) + 1.0;
    bool  usable = r.tolerance.z > 0.0 && scale > 0.0 && all(greaterThanEqual(past.pixel, low)) && all(lessThan(past.pixel, high));
    past.point.z -= velocity.z * r.tolerance.w;
    past.tolerance = usable ? least : -1.0;
    past.pixel     = usable ? past.pixel : low + 0.5;
    return past;
}

// How far each layer of a texel of last frame is from the point's plane there, or from its own z: whichever is less.
vec2 dgb_past_error(ivec2 texel, dgb_past past, dgb_reprojection r) {
    vec2  at      = vec2(texel) + 0.5;
    vec3  ray_z   = vec3(at * r.last.position_z.xy + r.last.position_z.zw, 1.0);
    vec3  ray_1   = vec3(at * r.last.position_1.xy + r.last.position_1.zw, 0.0);
    float on_ray  = dot(past.normal, past.point - ray_1) / dot(past.normal, ray_z); // where the ray meets the plane
    vec2  zs      = texelFetch(dgb_last_z, texel, 0).xy;
    vec2  to_own  = abs(zs - past.point.z), to_plane = abs(zs - on_ray);
    return vec2(to_plane.x < to_own.x ? to_plane.x : to_own.x, to_plane.y < to_own.y ? to_plane.y : to_own.y);
}

// Whether a texel shows the surface: 0 in the first layer, 1 in the second, -1 in neither.
int dgb_past_layer(ivec2 texel, dgb_past past, dgb_reprojection r) {
    vec2 error = dgb_past_error(texel, past, r);
#if DGB_DEEP
    if (error.y < error.x) return error.y <= past.tolerance ? 1 : -1;
#endif
    return error.x <= past.tolerance ? 0 : -1;
}

#if DGB_LAST_LIGHT
// What last frame holds for that layer of a texel. Nothing that is not finite gets through: history heals.
vec4 dgb_last_irradiance_at(ivec2 texel, int layer) {
    vec4 e = texelFetch(dgb_last_irradiance, texel, 0);
#if DGB_DEEP
    vec4 e1 = texelFetch(dgb_last_irradiance1, texel, 0);
    e       = layer == 1 ? e1 : e;
#endif
    return vec4(dgb_storable(e.rgb), e.a > 0.0 ? (e.a < 1.0 ? e.a : 1.0) : 0.0);
}
#endif
