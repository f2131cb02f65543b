// How far each oracle is from exact peeling while the camera moves, and the objects with it where the scene is animated.
//     oracles [--quick] [SCENE[@ex,ey,ez,tx,ty,tz,fov[,sx,sy,sz]]]...      always: the atrium
//
// Every oracle builds three layers of every frame, each compared with PEEL's of the same pose; layer 1 is what two layers
// would give. Emission is by separate draws, the same for all, so that what differs is the oracle's doing. DELAY shows a
// frame late and is submitted a frame early. Shares are of all pixels of the image.
#include "bench.hpp"
#include "scene_renderer.hpp"

#include <glm/gtc/type_ptr.hpp>

#include <array>
#include <cmath>
#include <cstdint>
#include <map>

namespace {

constexpr float kFramesPerSecond = 30.0f;
constexpr int kLayers = 3, kTaps = 30;
constexpr int kWarmUp = 3; // frames until the deepest layer rests on nothing that was peeled as a first frame
constexpr Motion kMotions[] = {{0.022f, 0.17f, false},
                               {0.045f, 0.34f, false},
                               {0.089f, 0.68f, false},
                               {0.179f, 1.36f, false},
                               {0.045f, 0.34f, true}};
constexpr Motion kQuickMotions[] = {{0.045f, 0.34f, false}, {0.179f, 1.36f, false}, {0.045f, 0.34f, true}};

struct Oracle {
    const char* name;
    dgb_oracle oracle;
    bool knows_next; // PREDICT: the engine tells the next view and pose
    int lead;        // frames between what is submitted and what is drawn
};

constexpr std::array<Oracle, 7> kOracles = {{{"peel", DGB_ORACLE_PEEL, false, 0},
                                             {"previous", DGB_ORACLE_PREVIOUS, false, 0},
                                             {"reproject", DGB_ORACLE_REPROJECT, false, 0},
                                             {"warp", DGB_ORACLE_WARP, false, 0},
                                             {"predict extrapolated", DGB_ORACLE_PREDICT, false, 0},
                                             {"predict true", DGB_ORACLE_PREDICT, true, 0},
                                             {"delay", DGB_ORACLE_DELAY, false, 1}}};
constexpr size_t kPeel = 0, kPrevious = 1, kReproject = 2, kWarp = 3, kPredictTrue = 5, kDelay = 6;

// ---- Stage ----------------------------------------------------------------------------------------------

// What there is to draw.
class Stage {
public:
    explicit Stage(const std::string& argument)
        : view_(load_view(argument)), gpu_(view_.scene), lights_(view_.scene, gpu_, {sun_light(view_.to_sun, 4.0f)}) {}

    const std::string& name() const { return view_.name; }
    void tell_from(const std::vector<std::string>& names) { ::tell_from(names, &view_.name); }
    const GpuScene& gpu() const { return gpu_; }
    const SceneLights& lights() const { return lights_; }
    float size() const { return glm::length(view_.scene.bounds_max - view_.scene.bounds_min); } // metres
    glm::mat4 projection() const { return projection_matrix(view_.camera, kAspect, ClipRange::standard); }

    // Everything at a frame: the one place where time passes.
    SceneFrame at(int frame, Motion motion, bool knows_next);
    void show_shadows_of(const GpuPose& pose) { lights_.update(pose); }

private:
    std::shared_ptr<const GpuPose> pose_at(int frame);

    View view_;
    GpuScene gpu_;
    SceneLights lights_;
    std::map<int, std::shared_ptr<const GpuPose>> poses_;
};

std::shared_ptr<const GpuPose> Stage::pose_at(int frame) {
    if (view_.scene.animations.empty()) { return gpu_.first_pose(); }
    std::shared_ptr<const GpuPose>& stored = poses_[frame];
    if (!stored) {
        pose(&view_.scene, double(frame) / kFramesPerSecond);
        stored = std::make_shared<GpuPose>(current_pose(view_.scene));
    }
    return stored;
}

SceneFrame Stage::at(int frame, Motion motion, bool knows_next) {
    SceneFrame at;
    at.view = view_matrix(moved(view_.camera, motion, frame));
    at.projection = projection();
    at.pose = pose_at(frame);
    if (knows_next) {
        at.next_view = view_matrix(moved(view_.camera, motion, frame + 1));
        at.next_pose = pose_at(frame + 1);
    }
    return at;
}

// The separation and the radii of the preset suit rooms: smaller scenes get smaller ones.
dgb_params params_for(const Stage& stage) {
    dgb_params params = dgb_preset(DGB_PRESET_QUALITY);
    params.ao_samples = params.samples = kTaps;
    params.separation = std::min(params.separation, 0.05f * stage.size());
    params.ao_radius = std::min(params.ao_radius, 0.1f * stage.size());
    params.radius = std::min(params.radius, 0.5f * stage.size());
    return params;
}

// ---- Contenders -----------------------------------------------------------------------------------------

using Pixels = std::vector<float>;

struct Frame {
    std::array<Pixels, kLayers> z; // metres, 0 where empty: as built, before strict separation
    Pixels strict_z[2];            // as shaded; this and below only of frames that are shaded
    Pixels ao, irradiance;         // the latter RGB times confidence
};

class Contender {
public:
    Contender(const Oracle& oracle, Stage* stage) : oracle_(oracle), stage_(stage), params_(params_for(*stage)) {
        RendererDesc desc;
        desc.get_proc = headless_get_proc;
        desc.layers.width = kWidth;
        desc.layers.height = kHeight;
        desc.layers.layers = kLayers;
        desc.layers.oracle = oracle.oracle;
        desc.layers.emission = DGB_EMISSION_SEPARATE;
        desc.layers.effects = DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY;
        desc.scene = &stage->gpu();
        desc.lights = &stage->lights();
        desc.sky = uniform_sky(glm::vec3(0.2f));
        desc.probe = probe_of(desc.sky);
        desc.times = &times_;
        renderer_ = std::make_unique<SceneRenderer>(desc);
    }

    // Draws the pose of `frame`, whatever it takes.
    void build(int frame, Motion motion) {
        renderer_->build(stage_->at(frame + oracle_.lead, motion, oracle_.knows_next), params_);
    }
    Frame read(bool shade);

private:
    Pixels read_built_z(int layer) const;

    Oracle oracle_;
    Stage* stage_;
    dgb_params params_;
    PassTimes times_{false};
    std::unique_ptr<SceneRenderer> renderer_;
};

Pixels Contender::read_built_z(int layer) const {
    dgb_camera camera{};
    const glm::mat4 projection = stage_->projection();
    dgb_camera_from_matrix(glm::value_ptr(projection), kWidth, kHeight, DGB_CLIP_NEGATIVE_ONE_TO_ONE, false, &camera);
    Pixels z = renderer_->read_texture(DGB_DEPTH, layer, GL_DEPTH_COMPONENT);
    for (float& value : z) { value = dgb_linear_z(value, &camera); }
    return z;
}

Frame Contender::read(bool shade) {
    Frame frame;
    for (int layer = 0; layer < kLayers; ++layer) { frame.z[size_t(layer)] = read_built_z(layer); }
    if (!shade) { return frame; }
    stage_->show_shadows_of(renderer_->drawn_pose());
    renderer_->shade(params_);
    for (int layer = 0; layer < 2; ++layer) { frame.strict_z[layer] = renderer_->read_z(layer); }
    frame.ao = renderer_->read_texture(DGB_AO, 0, GL_RED);
    frame.irradiance = weigh(renderer_->read_texture(DGB_IRRADIANCE, 0, GL_RGBA));
    return frame;
}

// ---- Errors ---------------------------------------------------------------------------------------------

// Counts of texels; the first line adds up to `differ`.
struct Errors {
    int64_t violated = 0, missing = 0,
            too_far = 0;                    // nearer than layer 0 + separation; empty; behind what peeling finds
    int64_t differ = 0, deeper_differ = 0;  // layer 1, layer 2
    int64_t holes = 0, strict_violated = 0; // with strict separation
    int64_t texels = 0, filled = 0;         // filled: where peeling finds a layer 1
    int64_t strict_texels = 0;              // of the frames that were shaded
    double ao_squares = 0.0, irradiance_squares = 0.0, irradiance_sum = 0.0;
};

// The same surface: where programs differ, a driver may round depth differently.
bool is_same(float a, float b) { return std::abs(a - b) <= 1e-4f * std::abs(b); }

void add_built(const Frame& frame, const Frame& peel, float separation, Errors* errors) {
    for (size_t i = 0; i < peel.z[0].size(); ++i) {
        const float z = frame.z[1][i], truth = peel.z[1][i];
        const bool violated = z != 0.0f && !dgb_keep_test(z, peel.z[0][i], separation);
        const bool differs = !is_same(z, truth);
        errors->violated += violated && differs;
        errors->missing += z == 0.0f && truth != 0.0f;
        errors->too_far += !violated && differs && z != 0.0f;
        errors->holes += truth != 0.0f && (z == 0.0f || violated);
        errors->differ += differs;
        errors->deeper_differ += !is_same(frame.z[2][i], peel.z[2][i]);
        errors->filled += truth != 0.0f;
    }
    errors->texels += int64_t(peel.z[0].size());
}

double sum_of_squares(const Pixels& a, const Pixels& b) {
    double sum = 0.0;
    for (size_t i = 0; i < a.size(); ++i) { sum += (double(a[i]) - b[i]) * (double(a[i]) - b[i]); }
    return sum;
}

void add_shaded(const Frame& frame, const Frame& peel, float separation, Errors* errors) {
    for (size_t i = 0; i < frame.strict_z[0].size(); ++i) {
        const float z = frame.strict_z[1][i];
        errors->strict_violated += z != 0.0f && !dgb_keep_test(z, frame.strict_z[0][i], separation);
    }
    errors->strict_texels += int64_t(frame.strict_z[0].size());
    errors->ao_squares += sum_of_squares(frame.ao, peel.ao);
    errors->irradiance_squares += sum_of_squares(frame.irradiance, peel.irradiance);
    for (float value : peel.irradiance) { errors->irradiance_sum += value; }
}

double percent(int64_t part, int64_t whole) { return 100.0 * double(part) / double(whole); }

double ao_rmse(const Errors& e) { return std::sqrt(e.ao_squares / double(e.strict_texels)); }

// Relative to the mean of what peeling gives.
double irradiance_rmse(const Errors& e) {
    const double values = 3.0 * double(e.strict_texels);
    return e.irradiance_sum > 0.0 ? std::sqrt(e.irradiance_squares / values) / (e.irradiance_sum / values) : 0.0;
}

using AllErrors = std::array<Errors, kOracles.size()>;

AllErrors measure(Stage* stage, Motion motion, int frames, int shade_every) {
    std::vector<std::unique_ptr<Contender>> contenders;
    for (const Oracle& oracle : kOracles) { contenders.push_back(std::make_unique<Contender>(oracle, stage)); }
    const float separation = params_for(*stage).separation;
    AllErrors errors{};
    for (int frame = 0; frame < kWarmUp + frames; ++frame) {
        const bool shade = frame % shade_every == kWarmUp % shade_every;
        Frame peel;
        for (size_t i = 0; i < contenders.size(); ++i) {
            contenders[i]->build(frame, motion);
            if (frame < kWarmUp) { continue; }
            const Frame built = contenders[i]->read(shade);
            if (i == kPeel) { peel = built; }
            add_built(built, peel, separation, &errors[i]);
            if (shade) { add_shaded(built, peel, separation, &errors[i]); }
        }
    }
    return errors;
}

// ---- Results --------------------------------------------------------------------------------------------

const char* direction(Motion motion) { return motion.sideways ? "sideways" : "ahead"; }

void print_errors(const Stage& stage, Motion motion, int frames, const AllErrors& all) {
    std::printf(
        "\n%s, %.1f cm %s and %.2f degrees a frame, %d frames, separation %.2f m; layer 1 fills %.1f %% of the image\n",
        stage.name().c_str(), double(motion.metres) * 100.0, direction(motion), double(motion.degrees), frames,
        double(params_for(stage).separation), percent(all[kPeel].filled, all[kPeel].texels));
    std::printf("    %-22s %8s = %8s + %7s + %7s | %8s %8s | %8s | %8s %10s\n", "% of pixels", "differ", "violated",
                "missing", "too far", "strict:", "holes", "layer 2", "AO RMSE", "irr. RMSE");
    for (size_t i = 0; i < all.size(); ++i) {
        const Errors& e = all[i];
        const auto share = [&](int64_t count) { return percent(count, e.texels); };
        std::printf("    %-22s %8.3f   %8.3f   %7.3f   %7.3f | %8lld %8.3f | %8.3f | %8.4f %9.2f%%\n", kOracles[i].name,
                    share(e.differ), share(e.violated), share(e.missing), share(e.too_far),
                    static_cast<long long>(e.strict_violated), share(e.holes - all[kPeel].holes),
                    share(e.deeper_differ), ao_rmse(e), 100.0 * irradiance_rmse(e));
    }
    std::fflush(stdout);
}

void write_errors(std::FILE* csv, const Stage& stage, Motion motion, int frames, const AllErrors& all) {
    for (size_t i = 0; i < all.size(); ++i) {
        const Errors& e = all[i];
        std::fprintf(csv, "%s,%s,%.1f,%s,%.2f,%d,%.5f,%.5f,%.5f,%.5f,%.5f,%.5f,%lld,%.5f,%.6f,%.6f\n",
                     stage.name().c_str(), kOracles[i].name, double(motion.metres) * 100.0, direction(motion),
                     double(motion.degrees), frames, percent(e.filled, e.texels), percent(e.differ, e.texels),
                     percent(e.violated, e.texels), percent(e.missing, e.texels), percent(e.too_far, e.texels),
                     percent(e.holes, e.texels), static_cast<long long>(e.strict_violated),
                     percent(e.deeper_differ, e.texels), ao_rmse(e), irradiance_rmse(e));
    }
    std::fflush(csv);
}

struct Result {
    std::string scene;
    Motion motion;
    AllErrors errors;
};

// PREVIOUS's error over another's.
double gain(const Result& result, size_t oracle) {
    return double(result.errors[kPrevious].differ) / double(std::max<int64_t>(result.errors[oracle].differ, 1));
}

const char* verdict(bool hit) { return hit ? "hit" : "missed"; }

// REPROJECT has no goal sideways: what is near moves most against what is far, its worst case.
void print_gain(const Result& result, const char* name, size_t oracle) {
    const Motion motion = result.motion;
    const double times = gain(result, oracle);
    std::printf("    %s at least 3 times closer to PEEL than PREVIOUS, %s, %.1f cm %s: %.2f, %s\n", name,
                result.scene.c_str(), double(motion.metres) * 100.0, direction(motion), times,
                motion.sideways && oracle == kReproject ? "no goal" : verdict(times >= 3.0));
}

void print_goals(const std::vector<Result>& results) {
    std::printf("\ngoals\n");
    std::vector<double> large_steps;
    int64_t inexact = 0, violated = 0;
    for (const Result& result : results) {
        inexact += result.errors[kPredictTrue].differ + result.errors[kDelay].differ;
        for (const Errors& errors : result.errors) { violated += errors.strict_violated; }
        print_gain(result, "REPROJECT", kReproject);
        print_gain(result, "WARP", kWarp);
        if (result.motion.metres >= 0.04f && !result.motion.sideways) { large_steps.push_back(gain(result, kWarp)); }
    }
    std::printf("    WARP in the median 4 times, steps of 4 cm and more: %.2f, %s\n", median(large_steps),
                verdict(median(large_steps) >= 4.0));
    std::printf("    DELAY and PREDICT with the true next view exact for layer 1: %lld texels differ, %s\n",
                static_cast<long long>(inexact), verdict(inexact == 0));
    std::printf("    no violation after strict separation: %lld texels, %s\n", static_cast<long long>(violated),
                verdict(violated == 0));
}

// One panel a scene: the error of layer 1 over the step.
void write_plot_script(const std::vector<std::string>& scenes) {
    const File script = result_file("oracles.gnuplot");
    std::FILE* out = script.get();
    const size_t columns = std::min<size_t>(scenes.size(), 2), rows = (scenes.size() + columns - 1) / columns;
    std::fprintf(out, "set terminal svg size %zu, %zu background rgb 'white'\nset output 'build/bench/oracles.svg'\n",
                 480 * columns, 360 * rows);
    std::fprintf(out,
                 "set datafile separator ','\nset datafile missing NaN\nset multiplot layout %zu, %zu\nset key top "
                 "left\nset grid\n",
                 rows, columns);
    std::fprintf(out, "set xlabel 'camera step, cm a frame'\nset ylabel 'layer-1 texels unlike peeling, %%'\n");
    for (const std::string& scene : scenes) {
        std::fprintf(out, "set title '%s' noenhanced\nplot ", scene.c_str());
        for (size_t i = kPrevious; i < kOracles.size(); ++i) {
            std::fprintf(out,
                         "%s'build/bench/oracles.csv' using (strcol(1) eq '%s' && strcol(2) eq '%s' && strcol(4) eq "
                         "'ahead' ? $3 : NaN):8 "
                         "with linespoints title '%s'",
                         i == kPrevious ? "" : ", ", scene.c_str(), kOracles[i].name, kOracles[i].name);
        }
        std::fprintf(out, "\n");
    }
}

void plot(const std::vector<std::string>& scenes) {
    write_plot_script(scenes);
    if (std::system("command -v gnuplot >/dev/null && gnuplot build/bench/oracles.gnuplot") == 0) { // NOLINT
        std::printf("\nbuild/bench/oracles.csv, build/bench/oracles.svg\n");
    } else {
        std::printf("\nbuild/bench/oracles.csv; for the plot: apt-get install gnuplot-nox; "
                    "gnuplot build/bench/oracles.gnuplot\n");
    }
}

void run(const Options& options) {
    const int frames = options.quick ? 12 : 60, shade_every = 6;
    std::vector<Motion> motions(std::begin(kMotions), std::end(kMotions));
    if (options.quick) { motions.assign(std::begin(kQuickMotions), std::end(kQuickMotions)); }
    std::vector<std::string> arguments = options.scenes, names;
    arguments.insert(arguments.begin(), std::string());
    std::vector<Result> results;
    {
        const File csv = result_file("oracles.csv");
        std::fprintf(csv.get(),
                     "scene,oracle,step_cm,direction,step_degrees,frames,filled,differ,violated,missing,too_far,"
                     "strict_holes,strict_violated,layer2_differ,ao_rmse,irradiance_relative_rmse\n");
        for (const std::string& argument : arguments) {
            Stage stage(argument);
            stage.tell_from(names);
            names.push_back(stage.name());
            for (const Motion motion : motions) {
                const AllErrors errors = measure(&stage, motion, frames, shade_every);
                print_errors(stage, motion, frames, errors);
                write_errors(csv.get(), stage, motion, frames, errors);
                results.push_back({stage.name(), motion, errors});
            }
        }
    }
    print_goals(results);
    plot(names);
}

} // namespace

int main(int argc, char** argv) { return run_benchmark("oracles", argc, argv, run); }
