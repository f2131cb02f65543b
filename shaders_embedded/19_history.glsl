// Where a surface was last frame, and which texels of last frame show it (paper, section 3.3). Shared by pack,
// temporal and glossy.

const float DGB_LEAST_SHARE = 0.05; // of the bilinear weights: with less there is no history

// What makes an average of a sum whose weights add up to `share`: 0 where there is no history.
float dgb_whole(float share) { return share > DGB_LEAST_SHARE ? 1.0 / share : 0.0; }

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

// z where the ray through a pixel position meets the point's plane.
float dgb_plane_z(vec2 at, dgb_past past, dgb_camera last) {
    vec3 ray_z = vec3(at * last.position_z.xy + last.position_z.zw, 1.0);
    vec3 ray_1 = vec3(at * last.position_1.xy + last.position_1.zw, 0.0);
    return dot(past.normal, past.point - ray_1) / dot(past.normal, ray_z);
}

// How far a layer of a texel of last frame is from the point's plane there, or from its own z: whichever is less.
float dgb_past_error(float z, vec2 at, dgb_past past, dgb_camera last) {
    float to_own = abs(z - past.point.z), to_plane = abs(z - dgb_plane_z(at, past, last));
    return to_plane < to_own ? to_plane : to_own;
}

// Whether a texel shows the surface: 0 in the first layer, 1 in the second, -1 in neither.
int dgb_past_layer(ivec2 texel, dgb_past past, dgb_reprojection r) {
    vec2  zs    = texelFetch(dgb_last_z, texel, 0).xy;
    float first = dgb_past_error(zs.x, vec2(texel) + 0.5, past, r.last);
#if DGB_DEEP
    float second = dgb_past_error(zs.y, dgb_centre(1, texel), past, r.last);
    if (second < first) return second <= past.tolerance ? 1 : -1;
#endif
    return first <= past.tolerance ? 0 : -1;
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

// An average with last frame's, as it is stored. weight: of history; without it x is no average, and stays.
vec4 dgb_averaged(vec4 x, float weight, ivec2 pixel, int frame) {
    vec2 pair = dgb_pixel_pair(pixel, frame);
    return weight > 0.0 ? dgb_dithered(x, fract(vec4(pair, pair + 0.5))) : x;
}
