// The ray-traced reference: what the pictures of the library are measured against. For tests and benchmarks; needs Embree 3
// or 4. It shares the scene, the camera and GLM with the examples, and no line of an estimator with the library.
//
// Everything is in world space, metres, and linear units, but for `z`: camera z in metres, negative, 0 where nothing is.
// Pictures have (width + 2 guard) x (height + 2 guard) pixels, the bottom row first, as the library's buffers have; pixel i is
// traced through its centre, shifted by the jitter as the library shifts it.
//
//     trace_layers     the exact layers: at each pixel the nearest front face, and behind it the nearest one whose camera
//                      distance is greater by more than the minimum separation, and so on. Alpha test and culling as the
//                      examples draw. Error: rounding of single-precision rays, about 1e-6 of the scene's size; the alpha
//                      test reads the finest level of textures, where OpenGL takes the pixel's.
//     trace_mirror     what a mirror at given points would show: nearest surface along the reflected ray, and the direct
//                      radiance that leaves it. Error: as above, and `lift` (see there).
//     trace_occlusion  ambient visibility: one minus the integral of (hidden or not, or hidden and faded with distance) times
//                      cosine / pi over the hemisphere around the normal. All surfaces, from both sides, wherever they are.
//                      It reaches below a triangle whose normals lean: there the triangle itself hides everything.
//     trace_obscurance the paper's own integral (Equations 1 and 2), which is not that: over a disk of the image around
//                      the pixel, as large as the radius is there, evenly in distance and angle, as the spiral's taps
//                      are. Each point of the disk is a ray of its own, also beyond the border of the picture; of the exact
//                      layers that it meets, the one that obscures most counts. The ends of rays are not rounded to
//                      pixels, nothing comes from MIP levels, and what is closer than a pixel counts.
//     visibility_of_obscurance   error: that of the sum over 2 sqrt(sum), and a bias of + error^2 / (8 sum^1.5).
//     trace_irradiance irradiance from surfaces: emission, and what they reflect of all lights after up to so many bounces,
//                      Lambert's law, path tracing with a shadow ray to every light from every surface. Back sides
//                      of single-sided materials are black. With a radius, no way between two surfaces is longer.
//     Estimates state their standard error, and the two halves of their samples: with T under test and halves A, B, the
//     mean of (T - A)(T - B) over pixels is its mean square error without that of the reference.
//     outgoing         direct radiance of a surface, emission + albedo / pi * irradiance of all lights, W/m2/sr: what
//                      the examples write into DGB_RADIANCE, with rays for shadow maps, exact normals for Oct16, and the
//                      finest level of textures. No bounced light, nothing of the sky.
#pragma once

#include "render_camera.hpp"
#include "scene.hpp"
#include "scene_probe.hpp"

#include <glm/glm.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <vector>

// ---- Rays and surfaces ----------------------------------------------------------------------------------

struct Ray {
    glm::vec3 origin{0.0f};
    glm::vec3 direction{0.0f, 0.0f, -1.0f}; // unit
    float nearest = 0.0f;                   // metres, both
    float farthest = std::numeric_limits<float>::infinity();
};

// Which faces of single-sided materials a ray meets. Those of double-sided ones it meets from both sides.
enum class Faces { front, both };

constexpr uint32_t kNothing = ~0u;

struct Surface {
    uint32_t part = kNothing;                                // a mesh of a node: ReferenceScene's own count
    uint32_t triangle = kNothing;                            // of the mesh
    float distance = std::numeric_limits<float>::infinity(); // along the ray
    float z = 0.0f;                                          // only where there is a view
    glm::vec3 position{0.0f};
    glm::vec3 normal{0.0f};      // unit, for shading; on the side that was met, as the examples turn it
    glm::vec3 face_normal{0.0f}; // unit, of the triangle; against the ray
    glm::vec3 albedo{0.0f};
    glm::vec3 emission{0.0f}; // W/m2/sr
    bool front = true;        // or the back of a single-sided material, which the examples do not draw
    bool lit = true;          // by lights

    bool found() const { return part != kNothing; }
};

// A ray that leaves a surface that was found, on the side of its face normal, and does not meet that triangle again.
Ray leaving(const Surface& surface, glm::vec3 direction);

// ---- Scene ----------------------------------------------------------------------------------------------

// Only reads; may be used by several threads.
class ReferenceScene {
public:
    // The scene must outlive this. Lights as SceneLights takes them; those on a node are taken to where the pose has it.
    // Throws std::runtime_error when Embree fails.
    ReferenceScene(const Scene& scene, const Pose& pose, std::vector<PunctualLight> lights, const Sky& sky = {});
    ReferenceScene(const ReferenceScene&) = delete;
    ReferenceScene& operator=(const ReferenceScene&) = delete;
    ~ReferenceScene();

    Surface closest(const Ray& ray, Faces faces) const;
    float distance(const Ray& ray, Faces faces) const; // of the closest, infinity without one
    // Whether anything is in the way, seen from whichever side, as the examples' shadow maps have it.
    bool occluded(const Ray& ray) const;

    glm::vec3 outgoing(const Surface& surface) const;
    glm::vec3 irradiance_of_lights(const Surface& surface) const; // W/m2
    glm::vec3 sky(glm::vec3 direction) const;                     // radiance that comes from there, W/m2/sr

private:
    struct Embree;
    struct Part;

    void add_part(const Scene& scene, const Pose& pose, int node, int mesh, int first_joint);
    glm::vec3 irradiance_from(const PunctualLight& light, const Surface& surface) const;

    std::vector<PunctualLight> lights_;
    Sky sky_;
    std::vector<std::unique_ptr<Part>> parts_; // Embree keeps their addresses
    std::unique_ptr<Embree> embree_;
};

// ---- Views ----------------------------------------------------------------------------------------------

struct ReferenceView {
    glm::mat4 view{1.0f};
    glm::mat4 projection{1.0f}; // of the image: no guard band, no jitter
    ClipRange clip = ClipRange::standard;
    int width = 0, height = 0; // pixels of the image
    int guard = 0;             // pixels on every side of it
    glm::vec2 jitter{0.0f};    // pixels

    int columns() const { return width + 2 * guard; }
    int rows() const { return height + 2 * guard; }
    size_t pixels() const { return size_t(columns()) * size_t(rows()); }
};

// The rays of a view's pixels, from the near plane to the far one.
class PixelRays {
public:
    explicit PixelRays(const ReferenceView& view);

    Ray through(glm::dvec2 pixel) const; // of the whole picture, from its lower left; centres are at +0.5
    Ray through(size_t pixel) const;     // its centre
    glm::dvec2 centre(size_t pixel) const;
    double depth_along(const Ray& ray) const; // metres of camera distance a metre of the ray
    float z_of(glm::vec3 position) const;

private:
    glm::dmat4 view_, from_pixel_; // the latter from (pixel, 0 near .. 1 far)
    int columns_;
};

// Runs work(i) for every i below count, on all cores and in any order.
void for_each(size_t count, const std::function<void(size_t i)>& work);

// ---- Layers ---------------------------------------------------------------------------------------------

// What a pixel's ray meets, front to back, each more than the separation behind the one before; at most so many.
void peel(const ReferenceScene& scene, const PixelRays& rays, Ray ray, int layers, float separation,
          const std::function<void(int layer, const Surface& surface)>& visit);

// layers: 1 to 8; separation: metres, 0 for classic depth peeling. [layer][pixel]
std::vector<std::vector<Surface>> trace_layers(const ReferenceScene& scene, const ReferenceView& view, int layers,
                                               float separation);

// ---- Points ---------------------------------------------------------------------------------------------

// Where a mirror stands, or light arrives.
struct SurfacePoint {
    glm::vec3 position{0.0f};
    glm::vec3 normal{0.0f}; // unit; 0: there is no surface
    // How far off the surface rays start, along the normal, metres. It must be more than the error of the position, or
    // they hit what they come from; what is nearer than this is not seen.
    float lift = 0.0f;
};

// Points of a picture: of the camera z and camera-space unit normals that SceneRenderer::read_z and read_normals give, which
// have no guard band, or of a layer traced. lift is 1e-4 of the distance from the eye, respectively 1e-5 of the position.
std::vector<SurfacePoint> surface_points(const ReferenceView& view, const std::vector<float>& z,
                                         const std::vector<float>& normals);
std::vector<SurfacePoint> surface_points(const std::vector<Surface>& layer);

// ---- Mirror ---------------------------------------------------------------------------------------------

enum class MirrorState {
    none, // there is no surface, or the reflected ray goes into it: the normal is turned away from the eye
    miss,
    hit
};

struct MirrorHit {
    MirrorState state = MirrorState::none;
    glm::vec3 direction{0.0f}; // of the reflected ray, unit
    Surface surface;           // at a hit, z in the view
    glm::vec3 radiance{0.0f};  // outgoing() at a hit, the sky's at a miss, W/m2/sr
};

// One ray a pixel, of any length. faces: front is what the examples would draw there.
std::vector<MirrorHit> trace_mirror(const ReferenceScene& scene, const ReferenceView& view,
                                    const std::vector<SurfacePoint>& points, Faces faces = Faces::front);

// ---- Light from all around ------------------------------------------------------------------------------

// Of a mean over random samples. Samples are rounded up to 16 times a square number; the same seed, point and number of
// samples give the same result.
template <typename T>
struct Estimate {
    T mean{0.0};
    T error{0.0};                   // its standard error, from 16 independent batches: itself known to a fifth
    T halves[2] = {T{0.0}, T{0.0}}; // means of the two independent halves of the samples
};

// x: share of the cosine-weighted hemisphere that is open within the radius (metres, may be infinite); y: the same where
// a surface at distance d hides (1 - d^2 / r^2) of what is behind it.
std::vector<Estimate<glm::dvec2>> trace_occlusion(const ReferenceScene& scene, const std::vector<SurfacePoint>& points,
                                                  float radius, int samples, uint64_t seed);

struct ObscuranceOptions {
    float radius = 1.0f;     // r, metres
    float beta = 0.0f;       // metres
    float epsilon = 0.0f;    // square metres
    int layers = 1;          // 1 to 8, exact ones
    float separation = 0.5f; // metres
};

// pi times the mean obscurance, from which the paper makes ambient visibility. points: of the pixels of the view.
std::vector<Estimate<double>> trace_obscurance(const ReferenceScene& scene, const ReferenceView& view,
                                               const std::vector<SurfacePoint>& points,
                                               const ObscuranceOptions& options, int samples, uint64_t seed);

// Paper, Equation 1.
inline double visibility_of_obscurance(double sum) { return std::max(0.0, 1.0 - std::sqrt(sum)); }

constexpr int kEndless = 0;

struct IrradianceOptions {
    int bounces = 1; // 1: light that some surface emits or mirrors straight from the lights; or kEndless
    float radius = std::numeric_limits<float>::infinity(); // longest way from surface to surface, metres
    bool sky = false;                                      // what misses everything meets the sky
};

// rgb: irradiance, W/m2; a: share of the cosine-weighted hemisphere in which there is a surface within the radius.
std::vector<Estimate<glm::dvec4>> trace_irradiance(const ReferenceScene& scene, const std::vector<SurfacePoint>& points,
                                                   const IrradianceOptions& options, int samples, uint64_t seed);
