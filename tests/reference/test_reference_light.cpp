// Light and shade of the reference against closed forms, before it judges anything. Every figure must be right to 1e-3 of
// its unit or to three of the standard errors that it states itself.
#include "reference.hpp"
#include "reference_random.hpp"
#include "test_scenes.hpp"

#include <glm/gtc/constants.hpp>

#include <array>
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstdio>

extern "C" {
#include <cmocka.h>
}

namespace {

using glm::dvec2;
using glm::dvec3;
using glm::dvec4;
using glm::vec3;
using glm::vec4;

constexpr double kPi = glm::pi<double>();
constexpr vec3 kUp(0.0f, 0.0f, 1.0f); // of the points tested: they look along +Z

void check(const char* what, double value, double error, double expected, double unit = 1.0) {
    std::printf("# %-40s %.5f +- %.5f, expected %.5f\n", what, value, error, expected);
    assert_true(std::abs(value - expected) <= std::max(1e-3 * unit, 3.0 * error));
    assert_true(error < 0.01 * unit); // a test that knows nothing tests nothing
}

// ---- Scenes ---------------------------------------------------------------------------------------------

Scene scene_of(const Material& material) {
    Scene scene;
    scene.materials = {material};
    scene.meshes = {square(0)};
    return scene;
}

Material matte(float albedo, float radiance = 0.0f) {
    Material material;
    material.base_color = vec4(albedo, albedo, albedo, 1.0f);
    material.emissive = vec3(radiance);
    return material;
}

// Squares that face -Z or +Z.
Node facing_down(vec3 place, float half) { return node_at(at(place, vec3(half), 180.0f), 0); }
Node facing_up(vec3 place, float half) { return node_at(at(place, vec3(half)), 0); }

// Six squares that face a cube's middle.
Scene make_box(const Material& material) {
    Scene scene = scene_of(material);
    const vec3 x(1.0f, 0.0f, 0.0f), y(0.0f, 1.0f, 0.0f);
    scene.nodes = {node_at(at(vec3(0, 0, -1)), 0),
                   node_at(at(vec3(0, 0, 1), vec3(1), 180, y), 0),
                   node_at(at(vec3(-1, 0, 0), vec3(1), 90, y), 0),
                   node_at(at(vec3(1, 0, 0), vec3(1), -90, y), 0),
                   node_at(at(vec3(0, -1, 0), vec3(1), -90, x), 0),
                   node_at(at(vec3(0, 1, 0), vec3(1), 90, x), 0)};
    return scene;
}

Mesh sphere(float radius, int slices) {
    Mesh mesh;
    const int stacks = slices / 2;
    for (int i = 0; i <= stacks; ++i) {
        for (int j = 0; j <= slices; ++j) {
            const float polar = glm::pi<float>() * float(i) / float(stacks);
            const float around = glm::two_pi<float>() * float(j) / float(slices);
            Vertex vertex;
            vertex.normal =
                vec3(std::sin(polar) * std::cos(around), std::sin(polar) * std::sin(around), std::cos(polar));
            vertex.position = radius * vertex.normal;
            mesh.vertices.push_back(vertex);
        }
    }
    for (int i = 0; i < stacks; ++i) {
        for (int j = 0; j < slices; ++j) {
            const auto a = uint32_t(i * (slices + 1) + j), b = a + uint32_t(slices) + 1;
            mesh.indices.insert(mesh.indices.end(), {a, b, a + 1, a + 1, b, b + 1});
        }
    }
    return mesh;
}

struct Lit {
    Scene scene;
    std::vector<PunctualLight> lights;
};

Estimate<dvec4> irradiance_at(const Lit& lit, vec3 place, const IrradianceOptions& options, int samples = 65536,
                              const Sky& sky = {}) {
    const ReferenceScene scene(lit.scene, current_pose(lit.scene), lit.lights, sky);
    return trace_irradiance(scene, {{place, kUp, 0.0f}}, options, samples, 1)[0];
}

Estimate<dvec2> occlusion_at(const Scene& scene, vec3 place, float radius, int samples = 65536) {
    const ReferenceScene traced(scene, current_pose(scene), {});
    return trace_occlusion(traced, {{place, kUp, 0.0f}}, radius, samples, 1)[0];
}

constexpr float kFar = std::numeric_limits<float>::infinity();

// Of side x side cells of the unit square.
std::vector<dvec2> midpoints(int side) {
    std::vector<dvec2> points;
    for (int row = 0; row < side; ++row) {
        for (int column = 0; column < side; ++column) { points.push_back((dvec2(column, row) + 0.5) / double(side)); }
    }
    return points;
}

// ---- Form factors ---------------------------------------------------------------------------------------

// From a point to a parallel rectangle a x b with a corner at the distance 1 above it (any textbook on radiation).
double corner_factor(double a, double b) {
    const double p = std::sqrt(1.0 + a * a), q = std::sqrt(1.0 + b * b);
    return (a / p * std::atan(b / p) + b / q * std::atan(a / q)) / (2.0 * kPi);
}

// From a point to a square of the half width `half` right above it.
double square_factor(double half, double distance) { return 4.0 * corner_factor(half / distance, half / distance); }

// Between two equal squares of side 1, one right above the other.
double parallel_squares(double distance) {
    const double x = 1.0 / distance, s = 1.0 + x * x;
    return 2.0 / (kPi * x * x) *
           (0.5 * std::log(s * s / (1.0 + 2.0 * x * x)) + 2.0 * x * std::sqrt(s) * std::atan(x / std::sqrt(s)) -
            2.0 * x * std::atan(x));
}

// ---- Occlusion ------------------------------------------------------------------------------------------

void test_open_and_closed(void**) {
    const Estimate<dvec2> closed = occlusion_at(make_box(matte(0.5f)), vec3(0.2f, 0.1f, -0.9f), 10.0f, 1024);
    assert_true(closed.mean.x == 0.0 && closed.error.x == 0.0);
    Scene floor = scene_of(matte(0.5f));
    floor.nodes = {facing_up(vec3(0.0f, 0.0f, -1e-3f), 10.0f)};
    const Estimate<dvec2> open = occlusion_at(floor, vec3(0.0f), kFar, 1024);
    assert_true(open.mean == dvec2(1.0) && open.error == dvec2(0.0));
}

// A half-plane that ends right above the point hides half of the sky, and so does a wall without end at the point, which is
// seen from its back here.
void test_half_planes(void**) {
    Scene scene = scene_of(matte(0.5f));
    scene.nodes = {facing_down(vec3(1e3f, 0.0f, 1.0f), 1e3f)};
    Estimate<dvec2> open = occlusion_at(scene, vec3(0.0f), kFar);
    check("half-plane above", open.mean.x, open.error.x, 0.5);
    scene.nodes = {node_at(at(vec3(1e-4f, 0.0f, 0.0f), vec3(1e4f), 90.0f), 0)};
    open = occlusion_at(scene, vec3(0.0f), kFar);
    check("wall at the point", open.mean.x, open.error.x, 0.5);
}

// A ceiling at the height h without end. Rays of length r reach it within the angle of cosine q = h / r: visibility q^2;
// faded, 1 - 2 integral from q to 1 of (1 - q^2 / c^2) c dc = q^2 - 2 q^2 ln q.
void test_ceiling(void**) {
    Scene scene = scene_of(matte(0.5f));
    scene.nodes = {facing_down(vec3(0.0f, 0.0f, 0.4f), 1e3f)};
    const Estimate<dvec2> open = occlusion_at(scene, vec3(0.0f), 1.0f);
    check("ceiling", open.mean.x, open.error.x, 0.16);
    check("ceiling, faded", open.mean.y, open.error.y, 0.16 - 2.0 * 0.16 * std::log(0.4));
    assert_true(occlusion_at(scene, vec3(0.0f), 0.39f, 1024).mean == dvec2(1.0));
}

// A sphere above the horizon hides (R / D)^2 cos: of a plane it stands on, at the distance x from where it touches,
// D^2 = x^2 + R^2 and the cosine is R / D.
void test_sphere_on_plane(void**) {
    Scene scene = scene_of(matte(0.5f));
    scene.meshes.push_back(sphere(1.0f, 512)); // its facets lie 4e-5 inside
    scene.nodes = {facing_up(vec3(0.0f), 1e3f), node_at(at(vec3(0.0f, 0.0f, 1.0f)), 1)};
    for (const float x : {0.8f, 1.5f, 3.0f}) {
        SurfacePoint point{vec3(x, 0.0f, 0.0f), kUp, 1e-5f};
        const ReferenceScene traced(scene, current_pose(scene), {});
        const Estimate<dvec2> open = trace_occlusion(traced, {point}, kFar, 65536, 1)[0];
        check("sphere on plane", open.mean.x, open.error.x, 1.0 - std::pow(1.0 + double(x) * double(x), -1.5));
    }
}

// The mean over one square of what it sees of the other.
void test_parallel_squares(void**) {
    Scene scene = scene_of(matte(0.5f));
    scene.nodes = {facing_down(vec3(0.0f, 0.0f, 0.5f), 0.5f)};
    const ReferenceScene traced(scene, current_pose(scene), {});
    std::vector<SurfacePoint> points;
    for (const dvec2 at : midpoints(32)) { points.push_back({vec3(at - 0.5, 0.0), kUp, 0.0f}); }
    double sum = 0.0, variance = 0.0;
    for (const Estimate<dvec2>& open : trace_occlusion(traced, points, kFar, 256, 1)) {
        sum += 1.0 - open.mean.x;
        variance += open.error.x * open.error.x;
    }
    const auto count = double(points.size());
    check("unit squares, 0.5 apart", sum / count, std::sqrt(variance) / count, parallel_squares(0.5));
}

// ---- The paper's obscurance -----------------------------------------------------------------------------

using TwoOffsets = std::array<dvec3, 2>; // from the point, to what a tap meets in its two layers

double obscurance(dvec3 v, const ObscuranceOptions& options) {
    const double square = dot(v, v), fade = 1.0 - square / (double(options.radius) * double(options.radius));
    const double cosine = (v.z - double(options.beta)) / std::sqrt(square + double(options.epsilon));
    return std::max(fade, 0.0) * std::max(cosine, 0.0);
}

// The sum that Equation 1 takes the root of, by a fine grid in distance and angle. meets: of a tap that many metres away on
// the floor's plane.
template <typename Meets>
double quadrature(const ObscuranceOptions& options, Meets meets) {
    constexpr int kSteps = 2000;
    double sum = 0.0;
    for (const dvec2 at : midpoints(kSteps)) {
        const double h = double(options.radius) * at.x, angle = 2.0 * kPi * at.y;
        const TwoOffsets v = meets(dvec2(h * std::cos(angle), h * std::sin(angle)));
        sum += std::max(obscurance(v[0], options), obscurance(v[1], options));
    }
    return kPi * sum / (double(kSteps) * kSteps);
}

// A floor 10 m below the eye, and plates above a part of it.
void test_obscurance(void**) {
    ObscuranceOptions options;
    options.radius = 2.0f;
    options.beta = 0.04f;
    options.epsilon = 0.4f;
    options.separation = 0.25f;
    for (const bool orthographic : {true, false}) {
        ReferenceView view;
        view.width = 33;
        view.height = 21;
        view.guard = 2;
        view.projection = orthographic ? glm::orthoRH_NO(-3.3f, 3.3f, -2.1f, 2.1f, 0.1f, 20.0f)
                                       : glm::perspectiveRH_NO(0.6f, 33.0f / 21.0f, 0.1f, 20.0f);
        view.view = glm::translate(glm::mat4(1.0f), vec3(0.0f, 0.0f, -10.0f));
        Scene scene = scene_of(matte(0.5f));
        scene.nodes = {facing_up(vec3(0.0f), 100.0f), facing_up(vec3(-50.0f, 0.0f, 1.0f), 50.0f)};
        const auto measure = [&](float x, int layers) {
            const ReferenceScene traced(scene, current_pose(scene), {});
            options.layers = layers;
            std::vector<SurfacePoint> points(view.pixels()); // one point alone, at the pixel that shows it
            const double pixels_per_metre = orthographic ? 5.0 : 21.0 / (2.0 * 10.0 * std::tan(0.3));
            const size_t column = size_t(std::lround(double(x) * pixels_per_metre)) + 18, pixel = 12 * 37 + column;
            points[pixel] = {vec3(float((double(column) - 18.0) / pixels_per_metre), 0.0f, 0.0f), kUp, 0.0f};
            const Estimate<double> sum = trace_obscurance(traced, view, points, options, 65536, 1)[pixel];
            return std::make_pair(double(points[pixel].position.x), sum);
        };
        // what the ray through a point of the floor meets, where a plate at the height h covers x < 0; else the floor
        const auto met = [&](double x0, dvec2 tap, double h) {
            const double nearer = orthographic ? 1.0 : (10.0 - h) / 10.0, x = (x0 + tap.x) * nearer;
            return x < 0.0 ? dvec3(x - x0, tap.y * nearer, h) : dvec3(tap, 0.0);
        };
        const auto plates = [&](double x0, double h0, double h1) {
            return quadrature(options, [&](dvec2 tap) { return TwoOffsets{met(x0, tap, h0), met(x0, tap, h1)}; });
        };
        const auto [x0, one] = measure(0.4f, 1);
        check("obscurance of a step", one.mean, one.error, plates(x0, 1.0, 0.0));
        // a plate too high to obscure hides the lower one from a single layer
        scene.nodes.push_back(facing_up(vec3(-50.0f, 0.0f, 3.0f), 50.0f));
        const Estimate<double> hidden = measure(0.4f, 1).second, second = measure(0.4f, 2).second;
        check("the same, hidden", hidden.mean, hidden.error, 0.0);
        check("the same, in the second layer", second.mean, second.error, plates(x0, 1.0, 0.0));
        // of two that do, the one that obscures more counts
        scene.nodes.back() = facing_up(vec3(-50.0f, 0.0f, 0.5f), 50.0f);
        const Estimate<double> both = measure(0.4f, 2).second;
        check("two steps", both.mean, both.error, plates(x0, 1.0, 0.5));
    }
    assert_true(visibility_of_obscurance(0.25) == 0.5 && visibility_of_obscurance(2.0) == 0.0);
}

// ---- Irradiance -----------------------------------------------------------------------------------------

// In a closed box of emission M = pi L and albedo rho, n bounces add up to pi L (1 - rho^n) / (1 - rho).
void test_furnace(void**) {
    for (const float albedo : {0.0f, 0.5f, 0.9f}) {
        const Lit furnace{make_box(matte(albedo, 0.25f)), {}};
        for (const int bounces : {1, 2, 5}) {
            IrradianceOptions options;
            options.bounces = bounces;
            const Estimate<dvec4> e = irradiance_at(furnace, vec3(0.3f, -0.2f, -0.5f), options, 256);
            const double rho = albedo, expected = 0.25 * kPi * (1.0 - std::pow(rho, bounces)) / (1.0 - rho);
            assert_true(std::abs(e.mean.y - expected) < 1e-5 * expected); // all paths are alike
            assert_true(e.mean.w == 1.0);
        }
        IrradianceOptions options;
        options.bounces = kEndless;
        const Estimate<dvec4> e = irradiance_at(furnace, vec3(0.3f, -0.2f, -0.5f), options);
        const double expected = 0.25 * kPi / (1.0 - double(albedo));
        check("furnace, all bounces", e.mean.x, e.error.x, expected, expected);
    }
}

// Two parallel plates without end, of which the upper one glows: of n bounces, every second one that arrives at the lower
// plate has gone down and up once more.
void test_parallel_plates(void**) {
    Lit plates;
    plates.scene.materials = {matte(0.5f), matte(0.8f, 1.0f)};
    plates.scene.meshes = {square(0), square(1)};
    plates.scene.nodes = {facing_up(vec3(0.0f), 1e4f), node_at(at(vec3(0.0f, 0.0f, 1.0f), vec3(1e4f), 180.0f), 1)};
    const double expected[] = {1.0, 1.0, 1.4, 1.4, 1.56};
    for (int n = 1; n <= 5; ++n) {
        IrradianceOptions options;
        options.bounces = n;
        const Estimate<dvec4> e = irradiance_at(plates, vec3(0.0f, 0.0f, 1e-3f), options, 4096);
        check("glowing ceiling", e.mean.x / kPi, e.error.x / kPi, expected[n - 1]);
    }
    // rays of length 1.25 reach the other plate within the angle of cosine 0.8
    IrradianceOptions options;
    options.bounces = 3;
    options.radius = 1.25f;
    const Estimate<dvec4> e = irradiance_at(plates, vec3(0.0f, 0.0f, 1e-4f), options);
    check("glowing ceiling, within the radius", e.mean.x / kPi, e.error.x / kPi, 0.36 + 0.4 * 0.36 * 0.36 * 0.36);
}

// A square right above the point is lit from below by the sun. Its radiance is albedo / pi * irradiance, and so the point gets
// form factor * albedo * irradiance; colours are those of lights and surfaces.
void test_one_bounce(void**) {
    Lit lit{scene_of(matte(0.5f)), {sun_light(vec3(0.0f, 3.0f, -4.0f), 2.0f)}};
    lit.lights[0].intensity = vec3(2.0f, 4.0f, 0.0f);
    lit.scene.nodes = {facing_down(vec3(0.0f, 0.0f, 0.7f), 0.5f)};
    const Estimate<dvec4> e = irradiance_at(lit, vec3(0.0f), {});
    const double factor = square_factor(0.5, 0.7), reflected = 0.5 * 0.8;
    check("square in the sun, red", e.mean.x, e.error.x, 2.0 * reflected * factor);
    check("square in the sun, green", e.mean.y, e.error.y, 4.0 * reflected * factor);
    assert_true(e.mean.z == 0.0);
    check("share of the hemisphere", e.mean.w, e.error.w, factor);

    // a second bounce has nowhere to go, and the back of a square is black
    IrradianceOptions many;
    many.bounces = 8;
    const Estimate<dvec4> again = irradiance_at(lit, vec3(0.0f), many);
    assert_true(again.mean.x > 0.0 && std::abs(again.mean.x - e.mean.x) < 3.0 * (again.error.x + e.error.x));
    lit.scene.nodes = {facing_up(vec3(0.0f, 0.0f, 0.7f), 0.5f)};
    lit.lights.push_back(point_light(vec3(0.0f, 0.0f, 0.3f), 1.0f));
    lit.scene.nodes.push_back(facing_up(vec3(0.0f, 0.0f, -1.0f), 5.0f)); // what it would reflect
    const Estimate<dvec4> back = irradiance_at(lit, vec3(0.0f), many, 4096);
    assert_true(back.mean.x == 0.0 && back.mean.w > 0.2);
}

// A shade between the sun and the square, and a point light that does not mind it.
void test_shadow(void**) {
    Lit lit{scene_of(matte(0.5f)), {sun_light(vec3(0.0f, 0.0f, -1.0f), 2.0f)}};
    lit.scene.nodes = {facing_down(vec3(0.0f, 0.0f, 0.7f), 0.5f), facing_down(vec3(0.0f, 0.0f, -5.0f), 2.0f)};
    assert_true(irradiance_at(lit, vec3(0.0f), {}, 4096).mean.x == 0.0);
    lit.lights.push_back(point_light(vec3(0.0f, 0.0f, -0.3f), 3.0f));
    const Estimate<dvec4> e = irradiance_at(lit, vec3(0.0f), {});
    double expected = 0.0; // the sum over the square of radiance * cosine^2 / distance^2
    for (const dvec2 at : midpoints(1000)) {
        const dvec3 y(at - 0.5, 0.7);
        const double lit_from = dot(y + dvec3(0, 0, 0.3), y + dvec3(0, 0, 0.3)), square = dot(y, y);
        const double irradiance = 3.0 * 1.0 / std::pow(lit_from, 1.5);
        expected += 0.5 / kPi * irradiance * 0.7 * 0.7 / (square * square) / 1e6;
    }
    check("square and point light", e.mean.x, e.error.x, expected);
}

// A ceiling without end in the sun: within the radius r there is 1 - (h / r)^2 of it, and beyond is the sky, when it is asked for
// and no radius is.
void test_radius_and_sky(void**) {
    Lit lit{scene_of(matte(0.5f)), {sun_light(vec3(0.0f, 0.0f, -1.0f), 2.0f)}};
    lit.scene.nodes = {facing_down(vec3(0.0f, 0.0f, 0.4f), 1e3f)};
    IrradianceOptions options;
    options.radius = 1.0f;
    const Estimate<dvec4> e = irradiance_at(lit, vec3(0.0f), options);
    check("ceiling within the radius", e.mean.x, e.error.x, 0.84);
    check("share within the radius", e.mean.w, e.error.w, 0.84);

    lit.scene.nodes = {facing_down(vec3(0.0f, 0.0f, 0.7f), 0.5f)};
    lit.lights.clear();
    IrradianceOptions sky;
    sky.sky = true;
    const double factor = square_factor(0.5, 0.7);
    const Estimate<dvec4> one = irradiance_at(lit, vec3(0.0f), sky, 65536, uniform_sky(vec3(0.5f)));
    check("sky around a square", one.mean.x / kPi, one.error.x / kPi, 0.5 * (1.0 - factor));
    sky.bounces = 2; // the square sees the sky's lower half alone
    const Estimate<dvec4> two = irradiance_at(lit, vec3(0.0f), sky, 65536, uniform_sky(vec3(0.5f)));
    check("and off the square", two.mean.x / kPi, two.error.x / kPi, 0.5 * (1.0 - 0.5 * factor));
}

// ---- Randomness -----------------------------------------------------------------------------------------

// Pairs of numbers fill the unit square evenly, be they neighbours in a stream or the first of neighbouring streams.
void test_random(void**) {
    constexpr int kCells = 16, kPairs = 1 << 20;
    for (int variant = 0; variant < 4; ++variant) {
        std::vector<int> counts(kCells * kCells, 0);
        Random stream(1, 2, 3);
        for (uint64_t i = 0; i < kPairs; ++i) {
            const auto first_of = [&](uint64_t key) {
                return Random(variant == 1 ? key : 1, variant == 2 ? key : 1, variant == 3 ? key : 1).uniform();
            };
            const double x = variant == 0 ? stream.uniform() : first_of(2 * i);
            const double y = variant == 0 ? stream.uniform() : first_of(2 * i + 1);
            assert_true(x >= 0.0 && x < 1.0 && y >= 0.0 && y < 1.0);
            ++counts[size_t(kCells * x) * kCells + size_t(kCells * y)];
        }
        double chi_square = 0.0;
        const double expected = double(kPairs) / double(counts.size()), freedoms = double(counts.size()) - 1.0;
        for (const int count : counts) { chi_square += (count - expected) * (count - expected) / expected; }
        std::printf("# chi square %.1f of %.0f degrees of freedom\n", chi_square, freedoms);
        assert_true(std::abs(chi_square - freedoms) < 3.0 * std::sqrt(2.0 * freedoms));
    }
}

// Many estimates of one number scatter as they say, halves are independent, and nothing depends on the order of work.
void test_errors(void**) {
    Scene scene = scene_of(matte(0.5f));
    scene.nodes = {facing_down(vec3(0.1f, 0.2f, 0.7f), 0.5f)};
    const ReferenceScene traced(scene, current_pose(scene), {});
    const std::vector<SurfacePoint> points(2000, SurfacePoint{vec3(0.1f, 0.2f, 0.0f), kUp, 0.0f});
    const auto open = trace_occlusion(traced, points, kFar, 64, 7);
    const double truth = 1.0 - square_factor(0.5, 0.7);
    double mean = 0.0, square = 0.0, stated = 0.0, product = 0.0, half_square = 0.0;
    for (const Estimate<dvec2>& e : open) {
        mean += (e.mean.x - truth) / double(open.size());
        square += std::pow(e.mean.x - truth, 2.0) / double(open.size());
        stated += e.error.x * e.error.x / double(open.size());
        product += (truth - e.halves[0].x) * (truth - e.halves[1].x) / double(open.size());
        half_square += std::pow(truth - e.halves[0].x, 2.0) / double(open.size());
        assert_true(std::abs(0.5 * (e.halves[0].x + e.halves[1].x) - e.mean.x) < 1e-12);
    }
    std::printf("# mean square error %.3e, stated %.3e; product of the halves' errors %.1e\n", square, stated, product);
    const double one_of =
        1.0 / std::sqrt(double(open.size())); // relative error of a variance from so many: sqrt 2 times
    assert_true(std::abs(mean) < 3.0 * std::sqrt(square) * one_of);
    assert_true(std::abs(square / stated - 1.0) < 3.0 * std::sqrt(2.0) * one_of);
    assert_true(std::abs(product) < 3.0 * half_square * one_of);

    int same_by_seed = 0, same_by_point = 0;
    const std::vector<SurfacePoint> some(points.begin(), points.begin() + 10);
    const auto again = trace_occlusion(traced, some, kFar, 64, 7), other = trace_occlusion(traced, some, kFar, 64, 8);
    for (size_t i = 0; i < some.size(); ++i) {
        assert_true(again[i].mean == open[i].mean && again[i].error == open[i].error);
        same_by_seed += other[i].mean == open[i].mean;
        same_by_point += open[i + 10].mean == open[i].mean;
    }
    assert_true(same_by_seed < 5 && same_by_point < 5); // of 64 samples as many may hit by chance
    const std::vector<SurfacePoint> none(1);
    assert_true(trace_occlusion(traced, none, kFar, 64, 7)[0].mean == dvec2(0.0));
}

} // namespace

int main() {
    const CMUnitTest tests[] = {
        cmocka_unit_test(test_open_and_closed),  cmocka_unit_test(test_half_planes),
        cmocka_unit_test(test_ceiling),          cmocka_unit_test(test_sphere_on_plane),
        cmocka_unit_test(test_parallel_squares), cmocka_unit_test(test_obscurance),
        cmocka_unit_test(test_furnace),          cmocka_unit_test(test_parallel_plates),
        cmocka_unit_test(test_one_bounce),       cmocka_unit_test(test_shadow),
        cmocka_unit_test(test_radius_and_sky),   cmocka_unit_test(test_random),
        cmocka_unit_test(test_errors),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
