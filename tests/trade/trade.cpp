// The trade of speed for accuracy, measured: what each setting of each effect costs, and how far its picture is from the truth.
//     trade [--quick] [--questions | --thickness | --budget | --check-budget] [--size WxH] [--random COUNT] [--rays N] [--seed N] [SCENE[@ex,ey,ez,tx,ty,tz,fov[,sx,sy,sz]]]...
// Without a scene: the procedural ones. Writes build/trade/trade.csv and build/trade/trade.svg, and the tables that the
// documentation shows. What was measured is in build/trade/rows.csv and is not measured again: remove it to start afresh.
//
// --budget: in place of the sweep, the settings of which dgb_preset_for picks; writes tests/trade/budget.csv and the table in
// deepgbuffer.h; --check-budget says whether the two agree.
// --thickness: in place of the sweep, what ends a surface (dgb_thickness), and at what length at the latest.
// --questions: in place of the sweep, what a sweep cannot answer (questions.hpp); writes build/trade/questions.csv.
//
// Truth, by rays (tests/reference), for the fourth frame of a camera that walks and turns:
//     ao           the paper's obscurance integral over the true geometry, within the scene's radius; beside it (rmse_cosine)
//                  cosine-weighted visibility with rays as long as that radius
//     irradiance   light of one bounce from within the scene's radius, W/m2; from where nothing is known comes none, and the
//                  library's irradiance counts by the share of the hemisphere that the composite snippet gives it
//     reflection   radiance in a mirror at every pixel of a floor, as far as mirrored rays reach; where nothing is found stands the
//                  median of the truth. `wrong` is the share of the pixels whose hit is not within the separation of the true one
// Errors of the first two are relative to nothing: AO is a share, irradiance is divided by the true mean. No temporal filter.
// Cost is time to shade, as a ratio to the BALANCED preset with two layers, measured in turns in one process; cost_built adds
// the time to build the layers to both.
#include "budget.hpp"
#include "engine_layers.hpp"
#include "metrics.hpp"
#include "questions.hpp"
#include "reference.hpp"
#include "setting.hpp"

#include <fstream>
#include <iostream>
#include <set>
#include <sstream>

namespace {

using Pixels = std::vector<float>;

constexpr Motion kStep{0.045f, 0.34f, true};
constexpr int kFrame = 4;      // that is looked at
constexpr int kSilhouette = 3; // pixels
constexpr int kBorder = 16;    // pixels

// build/trade/NAME.
File open_result(const std::string& name, const char* mode) {
    File file(std::fopen(("build/trade/" + name).c_str(), mode));
    if (!file) { throw std::runtime_error("cannot write build/trade/" + name); }
    return file;
}

struct Plan {
    bool quick = false;
    int width = 320, height = 180;
    int random_count = 200;
    uint32_t seed = 1;
    bool questions = false, thickness = false, budget = false, check_budget = false;
    int samples = 1024, turns = 5; // rays a pixel of the truth; timed frames
    std::vector<std::string> scenes;
    float aspect() const { return float(width) / float(height); }
};

// ---- Stage ----------------------------------------------------------------------------------------------

struct Built {
    std::unique_ptr<EngineLayers> layers;
    double build_ms = 0.0; // median of the frames
};

// A scene at the frame that is looked at, with the layers of any construction.
class Stage {
public:
    Stage(const std::string& argument, const Plan& plan);

    const std::string& name() const { return subject_.view.name; }
    float size() const { return subject_.size(); } // metres
    const ReferenceView& view() const { return reference_view_; }
    const ReferenceScene& reference() const { return *reference_; }
    dgb_view dgb_view_now() const { return to_dgb_view(reference_view_.view, reference_view_.projection); }
    const Pixels& z() const { return z_; }
    const std::vector<SurfacePoint>& points() const { return points_; }
    const Built& built(const Setting& setting);
    // A renderer that has built and shaded the frame with the setting's construction and effect.
    std::unique_ptr<SceneRenderer> shaded(const Setting& setting, PassTimes* times) const;

private:
    SceneFrame at(int frame) const;
    Built build(const Setting& setting) const;

    const Plan& plan_;
    Subject subject_;
    GpuScene gpu_;
    SceneLights lights_;
    ReferenceView reference_view_;
    std::unique_ptr<ReferenceScene> reference_;
    Pixels z_; // of the first layer
    std::vector<SurfacePoint> points_;
    std::map<std::string, Built> built_; // by what a construction depends on
};

std::unique_ptr<SceneRenderer> make_renderer(const GpuScene& scene, const SceneLights& lights, const Plan& plan,
                                             const Setting& setting, uint32_t effects, PassTimes* times) {
    RendererDesc desc;
    desc.get_proc = headless_get_proc;
    desc.layers.width = plan.width;
    desc.layers.height = plan.height;
    desc.layers.layers = setting.layers;
    desc.layers.effects = effects;
    desc.layers.oracle = setting.layers > 1 ? setting.oracle : DGB_ORACLE_PEEL;
    desc.layers.divisor = setting.layers > 1 ? setting.divisor : 1;
    desc.layers.senders = setting.senders;
    desc.layers.normaliser = setting.normaliser;
    desc.layers.estimator = setting.estimator;
    desc.layers.tracer = setting.tracer;
    desc.layers.thickness = setting.thickness;
    desc.scene = &scene;
    desc.lights = &lights;
    desc.times = times;
    return std::make_unique<SceneRenderer>(desc);
}

Stage::Stage(const std::string& argument, const Plan& plan)
    : plan_(plan), subject_(load_subject(argument)), gpu_(subject_.view.scene),
      lights_(subject_.view.scene, gpu_, subject_.lights) {
    lights_.update(*gpu_.first_pose());
    reference_ =
        std::make_unique<ReferenceScene>(subject_.view.scene, current_pose(subject_.view.scene), subject_.lights);
    reference_view_.view = at(kFrame).view;
    reference_view_.projection = at(kFrame).projection;
    reference_view_.width = plan.width;
    reference_view_.height = plan.height;

    PassTimes times(false);
    const auto renderer = shaded(preset_setting(Effect::occlusion, DGB_PRESET_BALANCED), &times);
    z_ = renderer->read_z(0);
    points_ = surface_points(reference_view_, z_, renderer->read_normals(0));
}

SceneFrame Stage::at(int frame) const {
    SceneFrame at;
    at.view = view_matrix(moved(subject_.view.camera, kStep, frame));
    at.projection = projection_matrix(subject_.view.camera, plan_.aspect(), ClipRange::standard);
    at.next_view = view_matrix(moved(subject_.view.camera, kStep, frame + 1)); // PREDICT is told
    return at;
}

Built Stage::build(const Setting& setting) const {
    PassTimes times(false);
    const uint32_t effects = setting.thickness == DGB_THICKNESS_BACK_FACES ? DGB_EFFECT_REFLECT : 0; // which reads them
    const auto renderer = make_renderer(gpu_, lights_, plan_, setting, effects, &times);
    const dgb_params params = scaled(setting.params, size());
    Built built;
    std::vector<double> milliseconds;
    for (int frame = 0; frame <= kFrame; ++frame) {
        glFinish();
        const double start = deciding_ms();
        renderer->build(at(frame), params);
        glFinish();
        if (frame > 0) { milliseconds.push_back(deciding_ms() - start); } // the first is built by peeling
        renderer->shade(params);
    }
    built.layers = std::make_unique<EngineLayers>(*renderer); // a layer of lower resolution comes enlarged
    built.build_ms = median(milliseconds);
    return built;
}

std::unique_ptr<SceneRenderer> Stage::shaded(const Setting& setting, PassTimes* times) const {
    auto renderer = make_renderer(gpu_, lights_, plan_, setting, bits_of(setting.effect), times);
    const dgb_params params = scaled(setting.params, size());
    for (int frame = setting.layers > 1 ? 0 : kFrame; frame <= kFrame; ++frame) { // oracles look back
        renderer->build(at(frame), params);
        if (frame == kFrame) { renderer->shade(params); }
    }
    return renderer;
}

const Built& Stage::built(const Setting& setting) {
    const bool back = setting.thickness == DGB_THICKNESS_BACK_FACES;
    char key[64] = "one";
    if (setting.layers > 1) {
        std::snprintf(key, sizeof key, "%g %d %d", double(setting.params.separation), int(setting.oracle),
                      setting.divisor);
    }
    if (back) { std::strcat(key, " back"); }
    const auto found = built_.find(key);
    return found != built_.end() ? found->second : built_.emplace(key, build(setting)).first->second;
}

// ---- Truth ----------------------------------------------------------------------------------------------

struct Truth {
    Pixels obscurance, visibility; // of the AO radius: the paper's, cosine-weighted
    Pixels irradiance[2], both;    // two independent halves, and their mean; RGB, W/m2
    double mean_irradiance = 0.0;  // of all channels
    std::vector<MirrorHit> mirror;
    glm::vec3 environment{0.0f}; // median of what mirrors show
    std::vector<bool> surface, mirrors, silhouette, border;
};

glm::vec3 median_radiance(const std::vector<MirrorHit>& hits, const std::vector<bool>& mask) {
    glm::vec3 result(0.0f);
    for (int c = 0; c < 3; ++c) {
        std::vector<double> values;
        for (size_t i = 0; i < hits.size(); ++i) {
            if (mask[i]) { values.push_back(double(hits[i].radiance[c])); }
        }
        result[c] = float(median(std::move(values)));
    }
    return result;
}

std::vector<bool> both_of(std::vector<bool> a, const std::vector<bool>& b) {
    for (size_t i = 0; i < a.size(); ++i) { a[i] = a[i] && b[i]; }
    return a;
}

// The part of the truth that is light and shade, from rays that start where the G-buffer says that surfaces are.
void trace_light(const Stage& stage, const Plan& plan, Truth* truth) {
    const dgb_params q = scaled(dgb_preset(DGB_PRESET_BALANCED), stage.size());
    const ObscuranceOptions obscurance{q.ao_radius, q.ao_bias * q.ao_radius, q.ao_epsilon * q.ao_radius * q.ao_radius,
                                       8, 0.0f};
    const IrradianceOptions one_bounce{1, q.radius, false};
    for (const auto& e :
         trace_obscurance(stage.reference(), stage.view(), stage.points(), obscurance, plan.samples, plan.seed)) {
        truth->obscurance.push_back(float(visibility_of_obscurance(e.mean)));
    }
    for (const auto& e : trace_occlusion(stage.reference(), stage.points(), q.ao_radius, plan.samples, plan.seed)) {
        truth->visibility.push_back(float(e.mean.x));
    }
    double sum = 0.0, squares = 0.0;
    for (const auto& e : trace_irradiance(stage.reference(), stage.points(), one_bounce, plan.samples, plan.seed)) {
        for (int c = 0; c < 3; ++c) {
            truth->both.push_back(float(e.mean[c]));
            for (int half = 0; half < 2; ++half) { truth->irradiance[half].push_back(float(e.halves[half][c])); }
            sum += e.mean[c];
            squares += e.error[c] * e.error[c];
        }
    }
    const auto values = 3.0 * double(std::count(truth->surface.begin(), truth->surface.end(), true));
    truth->mean_irradiance = std::max(sum / std::max(values, 1.0), 1e-9);
    std::printf("    truth: %d rays a pixel; standard error of irradiance %.4f of its mean\n", plan.samples,
                std::sqrt(squares / std::max(values, 1.0)) / truth->mean_irradiance);
    std::fflush(stdout);
}

Truth trace_truth(const Stage& stage, const Plan& plan) {
    const auto width = size_t(plan.width), height = size_t(plan.height);
    Truth truth;
    for (const SurfacePoint& point : stage.points()) { truth.surface.push_back(point.normal != glm::vec3(0.0f)); }
    trace_light(stage, plan, &truth);
    truth.mirror = trace_mirror(stage.reference(), stage.view(), stage.points());
    const float farthest = dgb_preset(DGB_PRESET_BALANCED).reflect_distance;
    for (size_t i = 0; i < truth.mirror.size(); ++i) {
        const MirrorHit& hit = truth.mirror[i];
        const bool floor = stage.points()[i].normal.y > 0.95f;
        truth.mirrors.push_back(floor && hit.state == MirrorState::hit && hit.surface.distance <= farthest);
    }
    truth.environment = median_radiance(truth.mirror, truth.mirrors);
    truth.silhouette = near_silhouettes(stage.z(), width, height, kSilhouette, 0.1);
    truth.border = near_border(width, height, kBorder);
    return truth;
}

// ---- Rows -----------------------------------------------------------------------------------------------

// What is measured of a setting, in the order of the columns.
constexpr const char* kMeasures[] = {
    "rmse",        "mae",   "bias", "p95",        "relative", "ssim",  "gain", "rmse_cosine", "rmse_silhouette",
    "rmse_border", "wrong", "cost", "cost_built", "bytes",    "texels"};
enum Measure {
    kRmse,
    kMae,
    kBias,
    kP95,
    kRelative,
    kSsim,
    kGain,
    kRmseCosine,
    kRmseSilhouette,
    kRmseBorder,
    kWrong,
    kCost,
    kCostBuilt,
    kBytes,
    kTexels,
    kMeasureCount
};

struct Row {
    std::string scene, size, effect, around, varied, key;
    std::array<double, kMeasureCount> measures{};
    bool on_front = false; // no other setting of the scene and effect costs less and is nearer to the truth
};

std::vector<std::string> split(const std::string& line) {
    std::vector<std::string> words;
    std::istringstream stream(line);
    for (std::string word; std::getline(stream, word, ',');) { words.push_back(word); }
    return words;
}

std::string text_of(const Row& row) {
    std::string line =
        row.scene + "," + row.size + "," + row.effect + "," + row.around + "," + row.varied + "," + row.key;
    for (const double measure : row.measures) {
        char number[32];
        std::snprintf(number, sizeof number, ",%.6g", measure);
        line += number;
    }
    return line;
}

// Of a file that an earlier run left, or none. A line that was cut off is measured again.
std::vector<Row> read_rows(const std::string& path) {
    std::vector<Row> rows;
    std::ifstream file(path);
    for (std::string line; std::getline(file, line);) {
        const std::vector<std::string> words = split(line);
        if (words.size() != 6 + kMeasureCount) { continue; }
        Row row{words[0], words[1], words[2], words[3], words[4], words[5]};
        for (size_t i = 0; i < kMeasureCount; ++i) { row.measures[i] = std::strtod(words[6 + i].c_str(), nullptr); }
        rows.push_back(std::move(row));
    }
    return rows;
}

const Row* find_row(const std::vector<Row>& rows, const Row& wanted) {
    const auto found = std::find_if(rows.begin(), rows.end(), [&](const Row& row) {
        return row.scene == wanted.scene && row.size == wanted.size && row.effect == wanted.effect &&
               row.key == wanted.key;
    });
    return found != rows.end() ? &*found : nullptr;
}

// ---- Measuring ------------------------------------------------------------------------------------------

class Contender {
public:
    Contender(Stage* stage, const Plan& plan, const Setting& setting)
        : stage_(stage), setting_(setting), params_(scaled(setting.params, stage->size())),
          built_(&stage->built(setting)), library_(describe(plan, setting)) {}

    double build_ms() const { return built_->build_ms; }
    double bytes() const { return double(library_.context()->plan.bytes); }
    const dgb_params& params() const { return params_; }
    float coverage() const { return setting_.coverage; }

    double shade() { // milliseconds
        library_.set_layers(stage_->dgb_view_now(), built_->layers->handles(setting_.layers));
        glFinish();
        const double start = deciding_ms();
        library_.shade(params_);
        glFinish();
        return deciding_ms() - start;
    }

    // Of the effect, as the library left it.
    Pixels read(dgb_slot slot, GLenum format) const {
        if (setting_.layers == 1 || setting_.divisor == 1) { return library_.read(slot, format); }
        // An engine's own layers have one resolution. Shading takes as long, but the picture is another.
        PassTimes times(false);
        return stage_->shaded(setting_, &times)->read_texture(slot, 0, format);
    }

private:
    static dgb_desc describe(const Plan& plan, const Setting& setting) {
        dgb_desc desc = EngineLayers::describe(plan.width, plan.height, setting.layers, bits_of(setting.effect));
        desc.senders = setting.senders;
        desc.normaliser = setting.normaliser;
        desc.estimator = setting.estimator;
        desc.tracer = setting.tracer;
        desc.thickness = setting.thickness;
        return desc;
    }

    Stage* stage_;
    Setting setting_;
    dgb_params params_;
    const Built* built_;
    Library library_;
};

struct Picture {
    Pixels value, truth;
    const Pixels* halves; // two independent estimates of the truth, whose mean it is; null: it has no noise to speak of
    size_t channels;
    double unit; // that errors are divided by
    std::vector<bool> mask;
};

Pixels shown_in_mirrors(const Pixels& reflection, const Truth& truth) {
    Pixels shown;
    for (size_t i = 0; i < reflection.size(); i += 4) {
        const glm::vec3 rgb = glm::mix(truth.environment, glm::make_vec3(&reflection[i]), reflection[i + 3]);
        shown.insert(shown.end(), {rgb.x, rgb.y, rgb.z});
    }
    return shown;
}

// As the composite snippet has it, before a black probe.
Pixels composited(const Pixels& irradiance, float coverage) {
    Pixels rgb;
    for (size_t i = 0; i < irradiance.size(); i += 4) {
        const float share = std::min(coverage * irradiance[i + 3], 1.0f);
        for (size_t c = i; c < i + 3; ++c) { rgb.push_back(share * irradiance[c]); }
    }
    return rgb;
}

Picture picture_of(const Contender& contender, Effect effect, const Truth& truth) {
    if (effect == Effect::occlusion) {
        return {contender.read(DGB_AO, GL_RED), truth.obscurance, nullptr, 1, 1.0, truth.surface};
    }
    if (effect == Effect::light) {
        return {composited(contender.read(DGB_IRRADIANCE, GL_RGBA), contender.coverage()),
                truth.both,
                truth.irradiance,
                3,
                truth.mean_irradiance,
                truth.surface};
    }
    Pixels radiance;
    double sum = 0.0;
    for (const MirrorHit& hit : truth.mirror) {
        radiance.insert(radiance.end(), {hit.radiance.x, hit.radiance.y, hit.radiance.z});
    }
    for (size_t i = 0; i < truth.mirrors.size(); ++i) {
        const glm::vec3 rgb = truth.mirror[i].radiance;
        sum += truth.mirrors[i] ? double(rgb.x + rgb.y + rgb.z) / 3.0 : 0.0;
    }
    const auto count = double(std::count(truth.mirrors.begin(), truth.mirrors.end(), true));
    return {shown_in_mirrors(contender.read(DGB_REFLECTION, GL_RGBA), truth),
            radiance,
            nullptr,
            3,
            sum / std::max(count, 1.0),
            truth.mirrors};
}

// Share of the mirrored pixels whose hit is not where the true one is.
double wrong_hits(const Contender& contender, const Stage& stage, const Truth& truth) {
    const Pixels hits = contender.read(DGB_REFLECTION_HIT, GL_RGBA);
    int64_t wrong = 0, count = 0;
    for (size_t i = 0; i < truth.mirrors.size(); ++i) {
        if (!truth.mirrors[i]) { continue; }
        const glm::vec3 there = stage.points()[i].position + truth.mirror[i].direction * hits[4 * i + 1];
        const bool right = hits[4 * i] > 0.0f &&
                           glm::distance(there, truth.mirror[i].surface.position) <= contender.params().separation;
        wrong += !right;
        ++count;
    }
    return double(wrong) / double(std::max<int64_t>(count, 1));
}

Pixels gray(const Pixels& value, size_t channels, double unit) {
    Pixels result;
    for (size_t i = 0; i < value.size(); i += channels) {
        float sum = 0.0f;
        for (size_t c = i; c < i + channels; ++c) { sum += value[c]; }
        result.push_back(sum / float(double(channels) * unit));
    }
    return result;
}

// Without the noise of the truth, where it has some.
double rmse_of(const Picture& p, const std::vector<bool>& mask) {
    if (p.halves == nullptr) { return measure_error(p.value, p.truth, p.channels, mask).rmse / p.unit; }
    const double square = unbiased_squared_error(p.value, p.halves[0], p.halves[1], p.channels, mask);
    return std::sqrt(std::max(square, 0.0)) / p.unit;
}

void fill_errors(const Picture& p, const Plan& plan, const Truth& truth, Row* row) {
    const Metrics m = measure_error(p.value, p.truth, p.channels, p.mask);
    row->measures[kRmse] = rmse_of(p, p.mask);
    row->measures[kMae] = m.mae / p.unit;
    row->measures[kBias] = m.bias / p.unit;
    row->measures[kP95] = m.p95 / p.unit;
    row->measures[kRelative] = m.relative;
    row->measures[kGain] = m.gain;
    row->measures[kSsim] =
        structural_similarity(gray(p.value, p.channels, p.unit), gray(p.truth, p.channels, p.unit), size_t(plan.width),
                              size_t(plan.height), p.channels == 1 ? 1.0 : 4.0, p.mask);
    row->measures[kRmseSilhouette] = rmse_of(p, both_of(p.mask, truth.silhouette));
    row->measures[kRmseBorder] = rmse_of(p, both_of(p.mask, truth.border));
}

Row measure(Stage* stage, const Plan& plan, const Truth& truth, const Setting& setting, Row row) {
    Contender contender(stage, plan, setting);
    Contender baseline(stage, plan, preset_setting(setting.effect, DGB_PRESET_BALANCED));
    std::vector<double> ratios, ratios_built;
    contender.shade();
    baseline.shade();
    for (int turn = 0; turn < plan.turns; ++turn) {
        const double own = contender.shade(), base = baseline.shade();
        ratios.push_back(own / base);
        ratios_built.push_back((own + contender.build_ms()) / (base + baseline.build_ms()));
    }
    const Picture picture = picture_of(contender, setting.effect, truth);
    fill_errors(picture, plan, truth, &row);
    if (setting.effect == Effect::occlusion) {
        row.measures[kRmseCosine] = measure_error(picture.value, truth.visibility, 1, truth.surface).rmse;
    }
    if (setting.effect == Effect::mirror) { row.measures[kWrong] = wrong_hits(contender, *stage, truth); }
    row.measures[kCost] = median(ratios);
    row.measures[kCostBuilt] = median(ratios_built);
    row.measures[kBytes] = contender.bytes();
    row.measures[kTexels] = texels_of(setting);
    return row;
}

// ---- Fronts and answers ---------------------------------------------------------------------------------

bool same_contest(const Row& a, const Row& b) { return a.scene == b.scene && a.size == b.size && a.effect == b.effect; }

void mark_fronts(std::vector<Row>* rows) {
    for (Row& row : *rows) {
        row.on_front = std::none_of(rows->begin(), rows->end(), [&](const Row& other) {
            const auto &m = row.measures, &o = other.measures;
            const bool no_worse = o[kCostBuilt] <= m[kCostBuilt] && o[kRmse] <= m[kRmse];
            return same_contest(row, other) && no_worse && (o[kCostBuilt] < m[kCostBuilt] || o[kRmse] < m[kRmse]);
        });
    }
}

void write_csv(const std::vector<Row>& rows) {
    const File csv = open_result("trade.csv", "w");
    std::string head = "scene,size,effect,around,varied,setting";
    for (const char* measure : kMeasures) { head += std::string(",") + measure; }
    std::fprintf(csv.get(), "%s,front\n", head.c_str());
    for (const Row& row : rows) { std::fprintf(csv.get(), "%s,%d\n", text_of(row).c_str(), int(row.on_front)); }
}

// Of every contest in which both settings were measured: the ratio to the BALANCED preset, geometric mean of the scenes.
struct Worth {
    double error = 0.0, cost = 0.0, cost_built = 0.0; // logarithms, summed
    int scenes = 0;

    void add(const Row& row, const Row& base) {
        error += std::log(std::max(row.measures[kRmse], 1e-9) / std::max(base.measures[kRmse], 1e-9));
        cost += std::log(row.measures[kCost]);
        cost_built += std::log(row.measures[kCostBuilt]);
        ++scenes;
    }
    double of(double sum) const { return std::exp(sum / double(std::max(scenes, 1))); }
};

const Row* preset_row(const std::vector<Row>& rows, const Row& of) {
    const auto found = std::find_if(rows.begin(), rows.end(), [&](const Row& row) {
        return same_contest(row, of) && row.around == "balanced" && row.varied.empty();
    });
    return found != rows.end() ? &*found : nullptr;
}

void print_worth(const std::vector<Row>& rows, Effect effect) {
    std::vector<std::pair<std::string, Worth>> worths; // in the order of the settings
    for (const Row& row : rows) {
        const Row* base = preset_row(rows, row);
        const bool preset = row.varied.empty() && row.around != "random";
        if (row.effect != name_of(effect) || base == nullptr || (row.around != "balanced" && !preset)) { continue; }
        const std::string name = preset ? row.around : row.varied;
        auto found = std::find_if(worths.begin(), worths.end(), [&](const auto& w) { return w.first == name; });
        if (found == worths.end()) { found = worths.insert(worths.end(), {name, Worth{}}); }
        found->second.add(row, *base);
    }
    std::printf("\n%s: RMSE and cost as ratios to BALANCED with two layers, geometric mean of the scenes\n    %-18s "
                "%8s %8s %14s %7s\n",
                name_of(effect), "", "RMSE", "cost", "cost, built", "scenes");
    for (const auto& [name, w] : worths) {
        std::printf("    %-18s %8.3f %8.3f %14.3f %7d\n", name.c_str(), w.of(w.error), w.of(w.cost), w.of(w.cost_built),
                    w.scenes);
    }
}

// The least error of the settings of so many layers that cost no more.
double best_within(const std::vector<Row>& rows, const Row& of, int layers, double cost) {
    double best = std::numeric_limits<double>::infinity();
    const std::string prefix = "k" + std::to_string(layers) + " ";
    for (const Row& row : rows) {
        if (!same_contest(row, of) || row.key.compare(0, prefix.size(), prefix) != 0) { continue; }
        if (row.measures[kCostBuilt] <= cost) { best = std::min(best, row.measures[kRmse]); }
    }
    return best;
}

// Building included: what the second layer costs is in it.
void print_layers(const std::vector<Row>& rows) {
    std::printf("\nthe second layer at equal cost, building included: RMSE of the best setting of two layers / of "
                "one\n    %-24s %-12s",
                "scene", "effect");
    const double costs[] = {0.6, 0.8, 1.0, 1.5, 2.5};
    for (const double cost : costs) { std::printf(" %8.1f", cost); }
    std::printf("\n");
    std::set<std::string> seen;
    for (const Row& row : rows) {
        if (!seen.insert(row.scene + "," + row.effect).second) { continue; }
        std::printf("    %-24s %-12s", row.scene.c_str(), row.effect.c_str());
        for (const double cost : costs) {
            const double two = best_within(rows, row, 2, cost), one = best_within(rows, row, 1, cost);
            const bool both = std::isfinite(two) && one > 0.0 && std::isfinite(one);
            both ? std::printf(" %8.3f", two / one) : std::printf(" %8s", "-"); // nothing is that cheap
        }
        std::printf("\n");
    }
}

void print_presets(const std::vector<Row>& rows) {
    std::printf("\nthe presets\n    %-24s %-12s %-12s %9s %9s %8s %8s %9s %11s %8s %8s %6s\n", "scene", "effect",
                "preset", "RMSE", "bias", "SSIM", "gain", "wrong", "silhouette", "border", "cost", "front");
    for (const Row& row : rows) {
        if (!row.varied.empty() || row.around == "random") { continue; }
        const auto& m = row.measures;
        std::printf("    %-24s %-12s %-12s %9.4f %+9.4f %8.3f %8.3f %8.1f%% %11.4f %8.4f %8.3f %6s\n",
                    row.scene.c_str(), row.effect.c_str(), row.around.c_str(), m[kRmse], m[kBias], m[kSsim], m[kGain],
                    100.0 * m[kWrong], m[kRmseSilhouette], m[kRmseBorder], m[kCost], row.on_front ? "yes" : "");
    }
}

// ---- Plot -----------------------------------------------------------------------------------------------

// A row of panels an effect, one a scene: error over cost; the front is a line.
void write_plot_script(const std::vector<std::string>& scenes) {
    const File script = open_result("trade.gnuplot", "w");
    std::FILE* out = script.get();
    std::fprintf(out,
                 "set terminal svg size %zu, 1020 background rgb 'white'\nset output 'build/trade/trade.svg'\n"
                 "set datafile separator ','\nset datafile columnheaders\nset multiplot layout 3, %zu\nset grid\nset "
                 "logscale xy\nset autoscale fix\nset offsets graph 0.05, graph 0.05, graph 0.25, graph 0.05\n"
                 "set key font ',9'\nset format y '%%.3g'\nset format x '%%.2g'\n",
                 std::max<size_t>(360 * scenes.size(), 480), scenes.size());
    const int error = 7, cost = 7 + kCostBuilt, front = 7 + kMeasureCount; // columns, from 1
    for (const Effect effect : kEffects) {
        for (const std::string& scene : scenes) {
            const std::string mine = "strcol(1) eq '" + scene + "' && strcol(3) eq '" + name_of(effect) + "'";
            const auto points = [&](const std::string& which) {
                return "(" + mine + " && " + which + " ? $" + std::to_string(cost) + " : NaN):" + std::to_string(error);
            };
            std::fprintf(out,
                         "set title '%s, %s' noenhanced\nset xlabel 'cost, building included'\nset ylabel 'RMSE'\n",
                         scene.c_str(), name_of(effect));
            std::fprintf(
                out,
                "plot 'build/trade/trade.csv' using %s with points pt 7 ps 0.35 lc rgb '#d95f02' title '1 layer', "
                "'' using %s with points pt 7 ps 0.35 lc rgb '#1b9e77' title '2 layers', "
                "'' using %s with points pt 6 ps 0.8 lc rgb 'black' title 'front', "
                "'' using %s:4 with labels offset 0, 0.7 font ',9' notitle\n",
                points("strcol(6)[1:2] eq 'k1'").c_str(), points("strcol(6)[1:2] eq 'k2'").c_str(),
                points("$" + std::to_string(front) + " > 0").c_str(),
                points("strcol(5) eq '' && strcol(4) ne 'random'").c_str());
        }
    }
}

void plot(const std::vector<std::string>& scenes) {
    write_plot_script(scenes);
    if (std::system("command -v gnuplot >/dev/null && gnuplot build/trade/trade.gnuplot") == 0) { // NOLINT
        std::printf("\nbuild/trade/trade.csv, build/trade/trade.svg\n");
    } else {
        std::printf(
            "\nbuild/trade/trade.csv; for the plot: apt-get install gnuplot-nox; gnuplot build/trade/trade.gnuplot\n");
    }
}

// ---- Program --------------------------------------------------------------------------------------------

std::string size_text(const Plan& plan) { return std::to_string(plan.width) + "x" + std::to_string(plan.height); }

Row name_row(const Stage& stage, const Plan& plan, const Setting& setting) {
    return {stage.name(), size_text(plan), name_of(setting.effect), setting.around, setting.varied, key_of(setting)};
}

void sweep(const std::string& argument, const Plan& plan, const std::vector<Setting>& settings, std::vector<Row>* rows,
           std::vector<std::string>* scenes) {
    Stage stage(argument, plan);
    scenes->push_back(stage.name());
    std::vector<Setting> missing;
    for (const Setting& setting : settings) {
        if (find_row(*rows, name_row(stage, plan, setting)) == nullptr) { missing.push_back(setting); }
    }
    std::printf("%s, %s: %zu settings, %zu to measure\n", stage.name().c_str(), size_text(plan).c_str(),
                settings.size(), missing.size());
    std::fflush(stdout);
    if (missing.empty()) { return; }
    const Truth truth = trace_truth(stage, plan);
    const File file = open_result("rows.csv", "a");
    for (size_t i = 0; i < missing.size(); ++i) {
        rows->push_back(measure(&stage, plan, truth, missing[i], name_row(stage, plan, missing[i])));
        std::fprintf(file.get(), "%s\n", text_of(rows->back()).c_str());
        std::fflush(file.get());
        if ((i + 1) % 50 == 0) {
            std::printf("    %zu of %zu\n", i + 1, missing.size());
            std::fflush(stdout);
        }
    }
}

// In the order of the settings, whatever was measured when.
std::vector<Row> in_order(const std::vector<Row>& rows, const std::vector<std::string>& scenes, const Plan& plan,
                          const std::vector<Setting>& settings) {
    std::vector<Row> ordered;
    for (const std::string& scene : scenes) {
        for (const Setting& setting : settings) {
            Row wanted{scene,          size_text(plan), name_of(setting.effect),
                       setting.around, setting.varied,  key_of(setting)};
            if (const Row* row = find_row(rows, wanted)) {
                wanted.measures = row->measures;
                ordered.push_back(std::move(wanted));
            }
        }
    }
    return ordered;
}

Plan parse(const std::vector<std::string>& words) {
    Plan plan;
    for (size_t i = 0; i < words.size(); ++i) {
        const auto number = [&] {
            if (i + 1 >= words.size()) { throw std::runtime_error(words[i] + " needs a value"); }
            return words[++i];
        };
        if (words[i] == "--quick") {
            plan.quick = true;
            plan.width = 160;
            plan.height = 90;
            plan.samples = 64;
            plan.turns = 3;
        } else if (words[i] == "--budget" || words[i] == "--check-budget") {
            plan.budget = words[i] == "--budget";
            plan.check_budget = !plan.budget;
        } else if (words[i] == "--thickness") {
            plan.thickness = true;
        } else if (words[i] == "--questions") {
            plan.questions = true;
        } else if (words[i] == "--size") {
            if (std::sscanf(number().c_str(), "%dx%d", &plan.width, &plan.height) != 2 || plan.width < 32 ||
                plan.height < 32) { // NOLINT
                throw std::runtime_error("--size must be WxH, at least 32x32");
            }
        } else if (words[i] == "--random") {
            plan.random_count = std::max(std::atoi(number().c_str()), 0); // NOLINT
        } else if (words[i] == "--rays") {
            plan.samples = std::max(std::atoi(number().c_str()), 16); // NOLINT
        } else if (words[i] == "--seed") {
            plan.seed = uint32_t(std::strtoul(number().c_str(), nullptr, 10));
        } else if (words[i].compare(0, 2, "--") == 0) {
            throw std::runtime_error("unknown option " + words[i]);
        } else {
            plan.scenes.push_back(words[i]);
        }
    }
    if (plan.scenes.empty()) {
        plan.scenes = plan.quick ? std::vector<std::string>{""} : std::vector<std::string>{"", "gallery"};
    }
    return plan;
}

void answer(const Plan& plan) {
    const QuestionPlan question{plan.width, plan.height, plan.quick ? 4 : 2, plan.samples, plan.seed};
    const File csv = open_result("questions.csv", "w");
    std::fprintf(csv.get(), "scene,question,case,taps,ao_rmse,irradiance_rmse,irradiance_covered_rmse\n");
    for (const std::string& scene : plan.scenes) { answer_questions(load_subject(scene), question, csv.get()); }
    std::printf("\nbuild/trade/questions.csv\n");
}

// From where the header and its table stand.
constexpr const char* kHeader = "deepgbuffer.h";
constexpr const char* kBudget = "tests/trade/budget.csv";

void write_budget(const std::vector<Row>& rows, const std::vector<Setting>& settings) {
    std::vector<BudgetRow> budget;
    for (const Setting& setting : settings) {
        Worth worth;
        for (const Row& row : rows) {
            const Row* base = preset_row(rows, row);
            if (row.effect == name_of(setting.effect) && row.key == key_of(setting) && base != nullptr) {
                worth.add(row, *base);
            }
        }
        if (worth.scenes > 0) { budget.push_back(budget_row(setting, worth.of(worth.cost), worth.of(worth.error))); }
    }
    write_budget(kBudget, budget);
    const bool same = embed_budget(kHeader, read_budget(kBudget), false); // as rounded there
    std::printf("%s, %s%s\n", kBudget, kHeader, same ? " (as before)" : "");
}

void check_budget() {
    if (!embed_budget(kHeader, read_budget(kBudget), true)) {
        throw std::runtime_error("deepgbuffer.h does not hold the table of tests/trade/budget.csv");
    }
}

void run(const Options& options) {
    std::vector<std::string> words = options.scenes;
    if (options.quick) { words.insert(words.begin(), "--quick"); }
    const Plan plan = parse(words);
    mkdir("build", 0777);
    mkdir("build/trade", 0777);
    if (plan.questions) {
        answer(plan);
        return;
    }
    if (plan.check_budget) {
        check_budget();
        return;
    }
    const std::vector<Setting> settings = plan.budget      ? budget_settings()
                                          : plan.thickness ? thickness_settings()
                                          : plan.quick     ? few_settings()
                                                           : all_settings(plan.random_count, plan.seed);
    std::vector<Row> rows = read_rows("build/trade/rows.csv");
    std::vector<std::string> scenes;
    for (const std::string& scene : plan.scenes) { sweep(scene, plan, settings, &rows, &scenes); }
    std::vector<Row> ordered = in_order(rows, scenes, plan, settings);
    if (plan.budget) {
        write_budget(ordered, settings);
        return;
    }
    mark_fronts(&ordered);
    write_csv(ordered);
    print_presets(ordered);
    print_layers(ordered);
    for (const Effect effect : kEffects) { print_worth(ordered, effect); }
    plot(scenes);
}

} // namespace

int main(int argc, char** argv) { return run_benchmark("trade", argc, argv, run); }
