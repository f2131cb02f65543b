// How right mirrors are: the rays of the library against rays traced through the scene itself, with one layer and with two, by
// the linear and by the hierarchical tracer.
//     mirrors [--quick] [SCENE[@ex,ey,ez,tx,ty,tz,fov[,sx,sy,sz]]]...      always: the gallery's mirrors, the atrium's floor
//
// Scenes of the command line get a polished floor. Every mirrored pixel is asked for the ray that the library follows, from
// the position and the normal that its G-buffer holds, so that what differs is the tracing alone. A hit is right when it lies
// within the minimum separation of the true one. Of the true hits, some are in the first layer, some in the second alone, and
// the rest in neither: these, the backs of things and what is outside the image, nobody who has two layers can find.
// In the gallery something passes in front of what the mirrors show, before a camera that rests: what comes or goes in a
// mirror though the true hit stays is what an eye sees as popping.
#include "engine_layers.hpp"
#include "reference.hpp"

#include <cmath>
#include <cstdint>
#include <functional>
#include <numeric>

namespace {

using Pixels = std::vector<float>;

constexpr Motion kStep{0.045f, 0.34f, false};
constexpr float kKnown = 0.05f;           // metres between a true hit and a layer that holds it
constexpr float kFramesPerSecond = 12.0f; // of what passes

double mean(const Pixels& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / double(std::max<size_t>(values.size(), 1));
}

double percent(double part, double whole) { return whole > 0.0 ? 100.0 * part / whole : 0.0; }

// ---- Stage ----------------------------------------------------------------------------------------------

// Which surfaces are mirrors: by place and normal, world space.
using IsMirror = bool (*)(glm::vec3 position, glm::vec3 normal);

bool is_floor(glm::vec3, glm::vec3 normal) { return normal.y > 0.95f; }

bool is_gallery_mirror(glm::vec3 position, glm::vec3 normal) { return normal.x < -0.95f && position.x > 3.9f; }

struct Subject {
    View view;
    IsMirror is_mirror;
    std::vector<PunctualLight> lights;
};

Subject make_gallery_subject() {
    Subject subject;
    subject.view.name = "gallery";
    subject.view.scene = make_gallery();
    subject.view.camera = camera_of_file(subject.view.scene.cameras[0], subject.view.scene);
    set_planes(subject.view.scene, &subject.view.camera);
    subject.is_mirror = is_gallery_mirror;
    subject.lights = subject.view.scene.lights;
    return subject;
}

Subject make_floor_subject(const std::string& argument) {
    Subject subject;
    subject.view = load_view(argument);
    if (argument.empty()) { // from the court: the default camera stands on the gallery
        parse_camera("10.5,1.7,2.2,-8,2.6,-2.5,60", &subject.view);
        set_planes(subject.view.scene, &subject.view.camera);
    }
    subject.is_mirror = is_floor;
    subject.lights = subject.view.scene.lights;
    if (subject.lights.empty()) { subject.lights = {sun_light(subject.view.to_sun, 4.0f)}; }
    return subject;
}

// A subject at one moment: the layers as an engine has them, and the truth.
class Stage {
public:
    explicit Stage(Subject subject)
        : subject_(std::move(subject)), gpu_(subject_.view.scene), lights_(subject_.view.scene, gpu_, subject_.lights) {
        RendererDesc desc;
        desc.get_proc = headless_get_proc;
        desc.layers.width = kWidth;
        desc.layers.height = kHeight;
        desc.scene = &gpu_;
        desc.lights = &lights_;
        desc.times = &times_;
        renderer_ = std::make_unique<SceneRenderer>(desc);
    }

    // The camera of a frame and the pose of a time, s.
    void show(int frame, float seconds);

    const std::string& name() const { return subject_.view.name; }
    bool moves() const { return !subject_.view.scene.animations.empty(); }
    const EngineLayers& layers() const { return *layers_; }
    dgb_view dgb_view_now() const { return to_dgb_view(view_.view, view_.projection); }
    const ReferenceView& view() const { return view_; }

    std::vector<MirrorHit> trace() const;      // of every pixel; state none where there is no mirror
    std::vector<SurfacePoint> mirrors() const; // normal 0 where there is none
    Pixels z(int layer) const { return renderer_->read_z(layer); }

private:
    Subject subject_;
    GpuScene gpu_;
    SceneLights lights_;
    PassTimes times_{false};
    ReferenceView view_;
    std::shared_ptr<const GpuPose> pose_;
    std::unique_ptr<SceneRenderer> renderer_;
    std::unique_ptr<EngineLayers> layers_;
};

void Stage::show(int frame, float seconds) {
    if (moves()) { pose(&subject_.view.scene, double(seconds)); }
    pose_ = std::make_shared<GpuPose>(current_pose(subject_.view.scene));
    lights_.update(*pose_);
    view_.view = view_matrix(moved(subject_.view.camera, kStep, frame));
    view_.projection = projection_matrix(subject_.view.camera, kAspect, ClipRange::standard);
    view_.width = kWidth;
    view_.height = kHeight;
    const dgb_params params = dgb_preset(DGB_PRESET_BALANCED);
    renderer_->build({view_.view, view_.projection, std::nullopt, pose_, nullptr}, params);
    renderer_->shade(params);
    if (!layers_) { layers_ = std::make_unique<EngineLayers>(*renderer_); }
    layers_->take(*renderer_);
}

std::vector<SurfacePoint> Stage::mirrors() const {
    std::vector<SurfacePoint> points = surface_points(view_, renderer_->read_z(0), renderer_->read_normals(0));
    for (SurfacePoint& point : points) {
        if (!subject_.is_mirror(point.position, point.normal)) { point.normal = glm::vec3(0.0f); }
    }
    return points;
}

std::vector<MirrorHit> Stage::trace() const {
    const ReferenceScene scene(subject_.view.scene, current_pose(subject_.view.scene), subject_.lights);
    return trace_mirror(scene, view_, mirrors());
}

// ---- Contenders -----------------------------------------------------------------------------------------

struct Contest {
    int layers;
    dgb_tracer tracer;
    int stride; // pixels
};

constexpr Contest kContests[] = {{1, DGB_TRACER_LINEAR, 1},       {2, DGB_TRACER_LINEAR, 1},
                                 {1, DGB_TRACER_HIERARCHICAL, 1}, {2, DGB_TRACER_HIERARCHICAL, 1},
                                 {1, DGB_TRACER_LINEAR, 4},       {2, DGB_TRACER_LINEAR, 4}};
constexpr size_t kOneLayer = 0, kTwoLayers = 1; // that pop

std::string name_of(const Contest& contest) {
    return std::to_string(contest.layers) + (contest.layers > 1 ? " layers, " : " layer, ") +
           (contest.tracer == DGB_TRACER_LINEAR ? "linear" : "hierarchical") + ", stride " +
           std::to_string(contest.stride);
}

struct Image {
    Pixels reflection; // RGB and confidence
    Pixels hit;        // layer + 1, length of the ray in m, of four channels
};

class Contender {
public:
    explicit Contender(const Contest& contest)
        : contest_(contest), params_(dgb_preset(DGB_PRESET_BALANCED)), library_(describe(contest)) {
        params_.reflect_stride = contest.stride;
        params_.reflect_steps = 1024; // more than the image's diagonal: no ray ends for want of steps
        params_.reflect_border = 0.0f;
    }

    const dgb_params& params() const { return params_; }

    Image shade(const Stage& stage) {
        library_.set_layers(stage.dgb_view_now(), stage.layers().handles(contest_.layers));
        library_.shade(params_);
        return {library_.read(DGB_REFLECTION, GL_RGBA), library_.read(DGB_REFLECTION_HIT, GL_RGBA)};
    }

private:
    static dgb_desc describe(const Contest& contest) {
        dgb_desc desc = EngineLayers::describe(kWidth, kHeight, contest.layers, DGB_EFFECT_REFLECT);
        desc.tracer = contest.tracer;
        return desc;
    }

    Contest contest_;
    dgb_params params_;
    Library library_;
};

using Contenders = std::vector<std::unique_ptr<Contender>>;

Contenders all_contenders() {
    Contenders contenders;
    for (const Contest& contest : kContests) { contenders.push_back(std::make_unique<Contender>(contest)); }
    return contenders;
}

// ---- Truth and score ------------------------------------------------------------------------------------

enum class Held { first, second, neither }; // which layer holds a true hit

// The first layer of the pixel that the point projects to, or the second.
Held held_by(glm::vec3 position, const ReferenceView& view, const Pixels z[2]) {
    const glm::vec4 camera = view.view * glm::vec4(position, 1.0f), clip = view.projection * camera;
    const glm::vec2 pixel = (glm::vec2(clip) / clip.w * 0.5f + 0.5f) * glm::vec2(view.width, view.height);
    const bool inside = clip.w > 0.0f && pixel.x >= 0.0f && pixel.y >= 0.0f && pixel.x < float(view.width) &&
                        pixel.y < float(view.height);
    if (!inside) { return Held::neither; }
    const size_t i = size_t(pixel.y) * size_t(view.width) + size_t(pixel.x);
    for (int layer = 0; layer < 2; ++layer) {
        // a surface seen at an angle is farther away at the edge of its pixel than in the middle
        const float slack = kKnown + 0.02f * std::abs(camera.z);
        if (z[layer][i] != 0.0f && std::abs(z[layer][i] - camera.z) <= slack) {
            return layer == 0 ? Held::first : Held::second;
        }
    }
    return Held::neither;
}

struct Truth { // counts of mirror pixels
    int64_t held[3] = {0, 0, 0};
    int64_t nothing = 0; // the ray leaves the scene, or ends
    int64_t count() const { return held[0] + held[1] + held[2] + nothing; }
};

struct Score {
    int64_t right[3] = {0, 0, 0};            // by where the true hit is held
    int64_t wrong = 0, missed = 0, lies = 0; // elsewhere; none where there is one; one where there is none
    double error = 0.0;                      // of the radiance, absolute, summed
    int64_t right_count() const { return right[0] + right[1] + right[2]; }
};

struct Results {
    Truth truth;
    double radiance = 0.0; // true, summed
    std::vector<Score> scores;
};

bool is_hit(const MirrorHit& hit, const dgb_params& params) {
    return hit.state == MirrorState::hit && hit.surface.distance <= params.reflect_distance;
}

// What stands in for what a ray does not find: the median, by channel, of all that mirrors show. Lamps would rule a mean.
glm::vec3 find_environment(const std::vector<MirrorHit>& truth) {
    glm::vec3 environment(0.0f);
    for (int c = 0; c < 3; ++c) {
        std::vector<double> values;
        for (const MirrorHit& hit : truth) {
            if (hit.state != MirrorState::none) { values.push_back(double(hit.radiance[c])); }
        }
        environment[c] = float(median(std::move(values)));
    }
    return environment;
}

// As the composite snippet blends.
glm::vec3 shown_at(const Image& image, size_t pixel, glm::vec3 environment) {
    const float* rgba = &image.reflection[4 * pixel];
    return glm::mix(environment, glm::make_vec3(rgba), rgba[3]);
}

double distance(glm::vec3 a, glm::vec3 b) { // mean of the channels
    return double(std::abs(a.x - b.x) + std::abs(a.y - b.y) + std::abs(a.z - b.z)) / 3.0;
}

bool is_right(const Image& image, size_t pixel, const SurfacePoint& point, const MirrorHit& truth,
              const dgb_params& params) {
    const glm::vec3 position = point.position + truth.direction * image.hit[4 * pixel + 1];
    return image.hit[4 * pixel] > 0.0f && is_hit(truth, params) &&
           glm::distance(position, truth.surface.position) <= params.separation;
}

void add_pixel(const Image& image, size_t pixel, const SurfacePoint& point, const MirrorHit& truth, Held held,
               const dgb_params& params, Score* score) {
    const bool claims = image.hit[4 * pixel] > 0.0f;
    if (!is_hit(truth, params)) {
        score->lies += claims;
    } else if (!claims) {
        ++score->missed;
    } else if (is_right(image, pixel, point, truth, params)) {
        ++score->right[int(held)];
    } else {
        ++score->wrong;
    }
}

void add_frame(const Stage& stage, Contenders* contenders, Results* results) {
    const std::vector<MirrorHit> truth = stage.trace();
    const std::vector<SurfacePoint> points = stage.mirrors();
    const Pixels z[2] = {stage.z(0), stage.z(1)};
    const dgb_params& params = contenders->front()->params();
    std::vector<Held> held(truth.size(), Held::neither);
    for (size_t i = 0; i < truth.size(); ++i) {
        if (truth[i].state == MirrorState::none) { continue; }
        const bool found = is_hit(truth[i], params);
        held[i] = found ? held_by(truth[i].surface.position, stage.view(), z) : Held::neither;
        found ? ++results->truth.held[int(held[i])] : ++results->truth.nothing;
        results->radiance += distance(truth[i].radiance, glm::vec3(0.0f));
    }
    results->scores.resize(contenders->size());
    const glm::vec3 environment = find_environment(truth);
    for (size_t c = 0; c < contenders->size(); ++c) {
        const Image image = (*contenders)[c]->shade(stage);
        for (size_t i = 0; i < truth.size(); ++i) {
            if (truth[i].state == MirrorState::none) { continue; }
            add_pixel(image, i, points[i], truth[i], held[i], params, &results->scores[c]);
            results->scores[c].error += distance(shown_at(image, i, environment), truth[i].radiance);
        }
    }
}

// ---- Popping --------------------------------------------------------------------------------------------

// Of one contender, by frame, shares of the mirror pixels.
struct Popping {
    Pixels flips;  // a hit turns right or ceases to be, though the true hit stays within the separation
    Pixels change; // of the mirrored radiance, beyond the truth's: a share of the mean radiance, mean of the pixels
};

struct Passing { // a frame
    std::vector<MirrorHit> truth;
    Image image[2];
    std::vector<bool> right[2];
};

Passing passing_at(const Stage& stage, Contenders* contenders) {
    const std::vector<SurfacePoint> points = stage.mirrors();
    Passing passing;
    passing.truth = stage.trace();
    for (const size_t c : {kOneLayer, kTwoLayers}) {
        const dgb_params& params = (*contenders)[c]->params();
        passing.image[c] = (*contenders)[c]->shade(stage);
        for (size_t i = 0; i < points.size(); ++i) {
            passing.right[c].push_back(is_right(passing.image[c], i, points[i], passing.truth[i], params));
        }
    }
    return passing;
}

void add_change(const Passing& now, const Passing& last, size_t c, glm::vec3 environment, float separation,
                Popping* popping) {
    double change = 0.0, radiance = 0.0;
    int64_t flips = 0, count = 0;
    for (size_t i = 0; i < now.truth.size(); ++i) {
        const MirrorHit &a = now.truth[i], &b = last.truth[i];
        if (a.state != MirrorState::hit || b.state != MirrorState::hit) { continue; }
        const glm::vec3 shown = shown_at(now.image[c], i, environment) - shown_at(last.image[c], i, environment);
        change += distance(shown, a.radiance - b.radiance);
        radiance += distance(a.radiance, glm::vec3(0.0f));
        flips +=
            glm::distance(a.surface.position, b.surface.position) <= separation && now.right[c][i] != last.right[c][i];
        ++count;
    }
    popping->flips.push_back(float(double(flips) / double(std::max<int64_t>(count, 1))));
    popping->change.push_back(float(change / std::max(radiance, 1e-9)));
}

std::array<Popping, 2> measure_popping(Stage* stage, int frames, Contenders* contenders) {
    std::array<Popping, 2> popping;
    glm::vec3 environment(0.0f);
    Passing last;
    for (int frame = 0; frame <= frames; ++frame) {
        stage->show(0, float(frame) / kFramesPerSecond);
        Passing now = passing_at(*stage, contenders);
        if (frame == 0) { environment = find_environment(now.truth); }
        for (const size_t c : {kOneLayer, kTwoLayers}) {
            const float separation = (*contenders)[c]->params().separation;
            if (frame > 0) { add_change(now, last, c, environment, separation, &popping[c]); }
        }
        last = std::move(now);
    }
    return popping;
}

// ---- Tables, plot ---------------------------------------------------------------------------------------

void print_results(const Stage& stage, int frames, const Results& r) {
    const auto count = double(r.truth.count());
    std::printf("\n%s, %dx%d, %d frames of a moving camera, %.1f %% of the pixels mirror\n", stage.name().c_str(),
                kWidth, kHeight, frames, percent(count, double(frames) * kWidth * kHeight));
    std::printf("    true hits, %% of the mirror pixels: in the first layer %.1f, in the second alone %.1f, in neither "
                "%.1f; nothing is hit %.1f\n",
                percent(double(r.truth.held[0]), count), percent(double(r.truth.held[1]), count),
                percent(double(r.truth.held[2]), count), percent(double(r.truth.nothing), count));
    std::printf("    %-34s | %6s %6s %6s %6s | %19s | %14s\n", "", "right", "wrong", "missed", "lies",
                "of those held: right", "radiance error");
    for (size_t i = 0; i < r.scores.size(); ++i) {
        const Score& s = r.scores[i];
        std::printf("    %-34s | %5.1f%% %5.1f%% %5.1f%% %5.1f%% | %8.1f%% %9.1f%% | %13.3f\n",
                    name_of(kContests[i]).c_str(), percent(double(s.right_count()), count),
                    percent(double(s.wrong), count), percent(double(s.missed), count), percent(double(s.lies), count),
                    percent(double(s.right[0]), double(r.truth.held[0])),
                    percent(double(s.right[1]), double(r.truth.held[1])), s.error / r.radiance);
    }
    std::fflush(stdout);
}

void write_results(std::FILE* csv, const Stage& stage, int frames, const Results& r) {
    const auto count = double(r.truth.count());
    for (size_t i = 0; i < r.scores.size(); ++i) {
        const Score& s = r.scores[i];
        std::fprintf(csv, "%s,%d,%s,%d,%d,%lld,%.3f,%.3f,%.3f,%.3f,%.3f,%.3f,%.3f,%.3f,%.3f,%.3f,%.5f\n",
                     stage.name().c_str(), kContests[i].layers,
                     kContests[i].tracer == DGB_TRACER_LINEAR ? "linear" : "hierarchical", kContests[i].stride, frames,
                     static_cast<long long>(r.truth.count()), percent(double(r.truth.held[0]), count),
                     percent(double(r.truth.held[1]), count), percent(double(r.truth.held[2]), count),
                     percent(double(r.truth.nothing), count), percent(double(s.right_count()), count),
                     percent(double(s.wrong), count), percent(double(s.missed), count), percent(double(s.lies), count),
                     percent(double(s.right[0]), double(r.truth.held[0])),
                     percent(double(s.right[1]), double(r.truth.held[1])), s.error / r.radiance);
    }
    std::fflush(csv);
}

void print_popping(const Stage& stage, int frames, const std::array<Popping, 2>& popping) {
    std::printf(
        "\n%s, the camera rests, something passes, %d frames at %.0f a second; a frame, of the mirror pixels:\n",
        stage.name().c_str(), frames, double(kFramesPerSecond));
    const char* names[] = {"1 layer", "2 layers"};
    for (const size_t c : {kOneLayer, kTwoLayers}) {
        std::printf(
            "    %-9s hits that come or go %.3f %%; change of radiance beyond the true one %.3f %% of the mean\n",
            names[c], 100.0 * mean(popping[c].flips), 100.0 * mean(popping[c].change));
    }
    std::fflush(stdout);
}

void write_popping(std::FILE* csv, const Stage& stage, const std::array<Popping, 2>& popping) {
    for (size_t frame = 0; frame < popping[0].flips.size(); ++frame) {
        std::fprintf(csv, "%s,%zu,%.6f,%.6f,%.6f,%.6f\n", stage.name().c_str(), frame + 1,
                     double(popping[0].flips[frame]), double(popping[1].flips[frame]), double(popping[0].change[frame]),
                     double(popping[1].change[frame]));
    }
}

// Bars of what is right, wrong and missed, a cluster a scene; below, the popping by frame.
void write_plot_script(const std::vector<std::string>& scenes) {
    const File script = result_file("mirrors.gnuplot");
    std::FILE* out = script.get();
    std::fprintf(
        out,
        "set terminal svg size %zu, 820 background rgb 'white'\nset output 'build/bench/mirrors.svg'\n"
        "set termoption noenhanced\nset datafile separator ','\nset datafile columnheaders\nset multiplot layout 2, 1\n"
        "set key outside top center horizontal\nset style data histograms\n"
        "set style histogram rowstacked title offset 0, -1.5\nset style fill solid 0.8\nset boxwidth 0.8\n"
        "set yrange [0:100]\nset ylabel '%% of the mirror pixels'\nset bmargin 9\n"
        "set xtics rotate by -40 scale 0 font ',9'\nplot ",
        std::max<size_t>(320 * scenes.size(), 640));
    const char* columns[] = {"right", "wrong", "missed", "lies"};
    const size_t rows = std::size(kContests);
    for (size_t scene = 0; scene < scenes.size(); ++scene) {
        std::fprintf(out, "%snewhistogram '%s' lt 1", scene > 0 ? ", " : "", scenes[scene].c_str());
        for (int i = 0; i < 4; ++i) {
            const std::string title = scene == 0 ? "title '" + std::string(columns[i]) + "'" : "notitle";
            std::fprintf(out,
                         ", 'build/bench/mirrors.csv' every ::%zu::%zu using %d:xtic(strcol(2).' '.strcol(3).' '."
                         "strcol(4)) %s lt %d",
                         scene * rows, scene * rows + rows - 1, 11 + i, title.c_str(), i + 1);
        }
    }
    std::fprintf(out,
                 "\nset style data lines\nset yrange [0:*]\nset bmargin 4\nset xtics norotate autofreq font ',11'\n"
                 "set xlabel 'frame'\nset ylabel 'hits that come or go, %%'\n"
                 "plot 'build/bench/popping.csv' using 2:($3 * 100) title '1 layer', '' using 2:($4 * 100) title "
                 "'2 layers'\n");
}

void plot(const std::vector<std::string>& scenes) {
    write_plot_script(scenes);
    if (std::system("command -v gnuplot >/dev/null && gnuplot build/bench/mirrors.gnuplot") == 0) { // NOLINT
        std::printf("\nbuild/bench/mirrors.csv, build/bench/popping.csv, build/bench/mirrors.svg\n");
    } else {
        std::printf("\nbuild/bench/mirrors.csv, build/bench/popping.csv; for the plot: apt-get install gnuplot-nox; "
                    "gnuplot build/bench/mirrors.gnuplot\n");
    }
}

// A motion step every so many frames of the camera: neighbours would say the same twice.
constexpr int kFrameSkip = 3;

void measure(Subject subject, int frames, Contenders* contenders, std::FILE* csv, std::FILE* popping_csv) {
    Stage stage(std::move(subject));
    Results results;
    for (int frame = 0; frame < frames; ++frame) {
        stage.show(kFrameSkip * frame, 0.0f);
        add_frame(stage, contenders, &results);
    }
    print_results(stage, frames, results);
    write_results(csv, stage, frames, results);
    if (!stage.moves()) { return; }
    const int passing = 5 * frames;
    const std::array<Popping, 2> popping = measure_popping(&stage, passing, contenders);
    print_popping(stage, passing, popping);
    write_popping(popping_csv, stage, popping);
}

void run(const Options& options) {
    const int frames = options.quick ? 2 : 12;
    std::vector<std::string> names;
    {
        const File csv = result_file("mirrors.csv"), popping_csv = result_file("popping.csv");
        std::fprintf(csv.get(),
                     "scene,layers,tracer,stride,frames,mirror_pixels,held_first,held_second,held_neither,nothing,"
                     "right,wrong,missed,lies,right_of_first,right_of_second,radiance_error\n");
        std::fprintf(popping_csv.get(), "scene,frame,flips_1,flips_2,change_1,change_2\n");
        Contenders contenders = all_contenders();
        std::vector<Subject> subjects;
        subjects.push_back(make_gallery_subject());
        subjects.push_back(make_floor_subject(std::string()));
        for (const std::string& argument : options.scenes) { subjects.push_back(make_floor_subject(argument)); }
        for (Subject& subject : subjects) {
            tell_from(names, &subject.view.name);
            names.push_back(subject.view.name);
            measure(std::move(subject), frames, &contenders, csv.get(), popping_csv.get());
        }
    }
    plot(names);
}

} // namespace

int main(int argc, char** argv) { return run_benchmark("mirrors", argc, argv, run); }
