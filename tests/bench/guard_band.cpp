// What a guard band is good for: the error of occlusion and bounced light near the image's border, under a panning camera,
// against a very wide band.
//     guard_band [--quick] [SCENE[@ex,ey,ez,tx,ty,tz,fov[,sx,sy,sz]]]...      always: the atrium
//
// A pixel's taps are turned by its place in the buffer, band included, so that no two bands take the same taps: even between
// very wide bands some error is left, which is that noise. Light reaches metres, so a narrow band shows far inside as well.
#include "bench.hpp"
#include "scene_renderer.hpp"

#include <glm/gtc/type_ptr.hpp>

#include <array>
#include <cmath>

namespace {

constexpr std::array<int, 5> kBands = {0, 32, 64, 128, 256}; // pixels; the last is the truth
constexpr int kBorder = 32;                                  // pixels of the image that count as near its border
constexpr int kTaps = 128;                                   // many: little noise
constexpr float kPan = 1.0f;                                 // degrees a frame

using Pixels = std::vector<float>;

struct Error {
    double squares = 0.0, reference = 0.0;
    int64_t count = 0;

    void add(float value, float truth) {
        squares += (double(value) - truth) * (double(value) - truth);
        reference += truth;
        ++count;
    }
    double rmse() const { return std::sqrt(squares / double(count)); }
};

struct Errors {                 // of one band
    Error ao[2], irradiance[2]; // near the border, the rest
};

// Of the whole image's irradiance, W/m2: parts of it may be dark.
double mean_irradiance(const Errors& e) {
    return (e.irradiance[0].reference + e.irradiance[1].reference) /
           double(e.irradiance[0].count + e.irradiance[1].count);
}

bool is_near_border(size_t pixel) {
    const int x = int(pixel) % kWidth, y = int(pixel) / kWidth;
    return std::min({x, y, kWidth - 1 - x, kHeight - 1 - y}) < kBorder;
}

std::unique_ptr<SceneRenderer> make_renderer(int band, const GpuScene& scene, const SceneLights& lights,
                                             PassTimes* times) {
    RendererDesc desc;
    desc.get_proc = headless_get_proc;
    desc.layers.width = kWidth;
    desc.layers.height = kHeight;
    desc.layers.guard_band = band;
    desc.layers.effects = DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY;
    desc.scene = &scene;
    desc.lights = &lights;
    desc.sky = uniform_sky(glm::vec3(0.2f));
    desc.probe = probe_of(desc.sky);
    desc.times = times;
    return std::make_unique<SceneRenderer>(desc);
}

RenderCamera panned(RenderCamera camera, float degrees) {
    const glm::mat3 turn(glm::rotate(glm::mat4(1.0f), glm::radians(degrees), camera.up));
    camera.target = camera.eye + turn * (camera.target - camera.eye);
    return camera;
}

void add_frame(const Pixels& ao, const Pixels& true_ao, const Pixels& light, const Pixels& true_light, Errors* errors) {
    for (size_t i = 0; i < ao.size(); ++i) {
        const size_t part = is_near_border(i) ? 0 : 1;
        errors->ao[part].add(ao[i], true_ao[i]);
        for (size_t c = 3 * i; c < 3 * i + 3; ++c) { errors->irradiance[part].add(light[c], true_light[c]); }
    }
}

void print_table(const View& view, int frames, const std::array<Errors, kBands.size()>& errors) {
    std::printf("\n%s, %dx%d, %d frames, %.0f degree of pan each, N = %d; RMSE against a band of %d pixels\n",
                view.name.c_str(), kWidth, kHeight, frames, double(kPan), kTaps, kBands.back());
    std::printf("    %-10s | %12s %12s | %16s %16s\n", "band, px", "AO: border", "inside", "irradiance: border",
                "inside");
    for (size_t i = 0; i + 1 < kBands.size(); ++i) {
        const Errors& e = errors[i];
        const double mean = std::max(mean_irradiance(e), 1e-9);
        std::printf("    %-10d | %12.4f %12.4f | %17.2f%% %15.2f%%\n", kBands[i], e.ao[0].rmse(), e.ao[1].rmse(),
                    100.0 * e.irradiance[0].rmse() / mean, 100.0 * e.irradiance[1].rmse() / mean);
    }
}

void run(const std::string& argument, int frames) {
    const View view = load_view(argument);
    const GpuScene scene(view.scene);
    SceneLights lights(view.scene, scene, {sun_light(view.to_sun, 4.0f)});
    lights.update(*scene.first_pose());
    PassTimes times(false);
    std::vector<std::unique_ptr<SceneRenderer>> renderers;
    for (int band : kBands) { renderers.push_back(make_renderer(band, scene, lights, &times)); }

    dgb_params params = dgb_preset(DGB_PRESET_QUALITY);
    params.ao_samples = params.samples = kTaps;
    params.guard_fraction = 0.0f; // only the image itself is shaded: the band is there to be read
    const glm::mat4 projection = projection_matrix(view.camera, kAspect, ClipRange::standard);
    std::array<Errors, kBands.size()> errors{};
    for (int frame = 0; frame < frames; ++frame) {
        const glm::mat4 camera = view_matrix(panned(view.camera, kPan * float(frame)));
        Pixels true_ao, true_light;
        for (size_t i = kBands.size(); i-- > 0;) { // the truth first
            renderers[i]->render(camera, projection, params);
            const Pixels ao = renderers[i]->read_texture(DGB_AO, 0, GL_RED);
            const Pixels irradiance = weigh(renderers[i]->read_texture(DGB_IRRADIANCE, 0, GL_RGBA));
            if (i + 1 == kBands.size()) {
                true_ao = ao;
                true_light = irradiance;
            }
            add_frame(ao, true_ao, irradiance, true_light, &errors[i]);
        }
    }
    print_table(view, frames, errors);
}

void run(const Options& options) {
    const int frames = options.quick ? 4 : 24;
    run(std::string(), frames);
    for (const std::string& scene : options.scenes) { run(scene, frames); }
}

} // namespace

int main(int argc, char** argv) { return run_benchmark("guard_band", argc, argv, run); }
