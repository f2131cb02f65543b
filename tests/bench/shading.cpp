// What each pass costs with one layer and with two, as ratios in one process.
//     shading [SCENE[@ex,ey,ez,tx,ty,tz,fov]]...      without a scene: the atrium
//
// Absolute times mean little on a software rasteriser on a busy machine, so the contenders take turns frame by frame and
// every figure is a median: of times (wall clock between two glFinish), or of ratios of neighbouring frames. GL timer
// queries are not used: a tiler may time only part of the work.
#include "bench.hpp"
#include "scene_renderer.hpp"

#include <map>

namespace {

constexpr int kWarmUp = 4, kFrames = 24;

struct Taps {
    int ao, gather;
};
constexpr Taps kTaps[] = {{16, 14}, {32, 30}};

dgb_desc layers_desc(int layers) {
    dgb_desc desc{};
    desc.width = kWidth;
    desc.height = kHeight;
    desc.layers = layers;
    desc.effects = DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY;
    return desc;
}

// A full-screen pass that copies an RGBA16F texel: the unit of the last column.
class CopyPass {
public:
    CopyPass()
        : program_(make_fullscreen_program("copy",
                                           "uniform sampler2D source; out vec4 color;\n"
                                           "void main() { color = texelFetch(source, ivec2(gl_FragCoord.xy), 0); }\n")),
          vertices_(make_vertex_array()), framebuffer_(make_framebuffer()) {
        for (GlObject& texture : textures_) {
            texture = make_texture();
            glBindTexture(GL_TEXTURE_2D, texture.name());
            glTexStorage2D(GL_TEXTURE_2D, 1, GL_RGBA16F, kWidth, kHeight);
            glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
        }
        glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.name());
        glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, textures_[1].name(), 0);
    }

    void run(PassTimes* times) {
        times->begin();
        glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.name());
        glViewport(0, 0, kWidth, kHeight);
        glDisable(GL_DEPTH_TEST);
        glUseProgram(program_.name());
        glBindVertexArray(vertices_.name());
        bind_texture(program_.name(), "source", 0, GL_TEXTURE_2D, textures_[0].name());
        glDrawArrays(GL_TRIANGLES, 0, 3);
        times->end("copy");
    }

private:
    GlObject program_, vertices_, framebuffer_, textures_[2];
};

using Samples = std::map<std::string, std::vector<double>>; // milliseconds by pass

Samples measured(const PassTimes& times) {
    Samples samples;
    for (const PassTime& pass : times.passes()) {
        samples[pass.name] = {pass.cpu_ms.begin() + kWarmUp, pass.cpu_ms.end()};
    }
    return samples;
}

std::vector<double> sum(const Samples& samples, const std::vector<std::string>& passes) {
    std::vector<double> total(kFrames, 0.0);
    for (const std::string& pass : passes) {
        const std::vector<double>& times = samples.at(pass);
        for (int i = 0; i < kFrames; ++i) { total[size_t(i)] += times[size_t(i)]; }
    }
    return total;
}

void print_goal(const char* what, double value, double goal) {
    std::printf("    %-62s %5.2f  (goal %.2f)%s\n", what, value, goal, value > goal ? "  missed" : "");
}

void print_table(const View& view, Taps taps, const Samples& one, const Samples& two, const Samples& copy) {
    std::printf("\n%s, %dx%d, AO N = %d, radiosity N = %d with normal test\n", view.name.c_str(), kWidth, kHeight,
                taps.ao, taps.gather);
    std::printf("    %-12s %12s %12s %10s %12s\n", "pass", "1 layer, ms", "2 layers, ms", "2 / 1", "x copy pass");
    for (const char* pass : {"layers", "pack", "mip", "ao", "gather", "reconstruct"}) {
        std::printf("    %-12s %12.2f %12.2f %10.2f %12.1f\n", pass, median(one.at(pass)), median(two.at(pass)),
                    median_ratio(two.at(pass), one.at(pass)), median_ratio(two.at(pass), copy.at("copy")));
    }
    const std::vector<double> frame = sum(two, {"layers", "pack", "mip", "ao", "gather", "reconstruct"});
    print_goal("occlusion, two layers / one", median_ratio(two.at("ao"), one.at("ao")), 1.12);
    print_goal("gather, two layers / one", median_ratio(two.at("gather"), one.at("gather")), 1.40);
    print_goal("pack + mip / frame (layers to reconstruct)", median_ratio(sum(two, {"pack", "mip"}), frame), 0.15);
    print_goal("reconstruct / (ao + gather)", median_ratio(two.at("reconstruct"), sum(two, {"ao", "gather"})), 0.80);
}

void run(const View& view, const GpuScene& scene, const SceneLights& lights, Taps taps) {
    PassTimes times[2] = {PassTimes(true), PassTimes(true)}, copy_times(true);
    std::vector<std::unique_ptr<SceneRenderer>> renderers;
    for (int layers = 1; layers <= 2; ++layers) {
        RendererDesc desc;
        desc.get_proc = headless_get_proc;
        desc.layers = layers_desc(layers);
        desc.scene = &scene;
        desc.lights = &lights;
        desc.sky = uniform_sky(glm::vec3(0.2f));
        desc.probe = probe_of(desc.sky);
        desc.times = &times[layers - 1];
        renderers.push_back(std::make_unique<SceneRenderer>(desc));
    }
    dgb_params params = dgb_preset(DGB_PRESET_BALANCED);
    params.ao_samples = taps.ao;
    params.samples = taps.gather;
    const glm::mat4 projection = projection_matrix(view.camera, kAspect, ClipRange::standard);
    CopyPass copy;
    for (int frame = 0; frame < kWarmUp + kFrames; ++frame) {
        for (const auto& renderer : renderers) { renderer->render(view_matrix(view.camera), projection, params); }
        copy.run(&copy_times);
    }
    print_table(view, taps, measured(times[0]), measured(times[1]), measured(copy_times));
}

void run(const std::string& argument) {
    const View view = load_view(argument);
    const GpuScene scene(view.scene);
    SceneLights lights(view.scene, scene, {sun_light({0.3f, 0.6f, 0.7f}, 4.0f)});
    lights.update(*scene.first_pose());
    for (const Taps taps : kTaps) { run(view, scene, lights, taps); }
}

void run(const Options& options) {
    if (options.scenes.empty()) { run(std::string()); }
    for (const std::string& scene : options.scenes) { run(scene); }
}

} // namespace

int main(int argc, char** argv) { return run_benchmark("shading", argc, argv, run); }
