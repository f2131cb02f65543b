// The trade of speed for accuracy, measured: what each setting of each effect costs, and how far its picture is from the truth.
//     trade [--quick] [--estimators | --thickness | --questions | --budget | --check-budget] [--size WxH]
//           [--random COUNT] [--rays N] [--seed N] [SCENE[@ex,ey,ez,tx,ty,tz,fov[,sx,sy,sz]]]...
// Without a scene: the procedural ones. Writes build/trade/trade.csv and build/trade/trade.svg, and the tables that the
// documentation shows. What was measured is in build/trade/rows.csv and is not measured again: remove it to start afresh.
//
// --budget: in place of the sweep, the settings of which dgb_preset_for picks; writes tests/trade/budget.csv and the table in
// deepgbuffer.h; --check-budget says whether the two agree.
// --estimators: in place of the sweep, the library's estimators against others' (baselines.hpp), at equal cost, after 1 to 64
// frames (quick: 1); the truth of ao is cosine-weighted visibility; rows are in build/trade/estimators.csv.
// --thickness: in place of the sweep, what ends a surface (dgb_thickness), and at what length at the latest.
// --questions: in place of the sweep, what a sweep cannot answer (questions.hpp); writes build/trade/questions.csv.
//
// Truth, by rays (tests/reference), for the view of the scene, at which a camera that walks and turns has arrived:
//     ao           the paper's obscurance integral over the true geometry, within the scene's radius; beside it (rmse_cosine)
//                  cosine-weighted visibility with rays as long as that radius
//     irradiance   light of one bounce from within the scene's radius, W/m2; from where nothing is known comes none, and the
//                  library's irradiance counts by the share of the hemisphere that the composite snippet gives it
//     reflection   radiance in a mirror at every pixel of a floor, as far as mirrored rays reach; where nothing is found stands the
//                  median of the truth. `wrong` is the share of the pixels whose hit is not within the separation of the true one
// Errors of the first two are relative to nothing: AO is a share, irradiance is divided by the true mean.
// `frames` is how many were shaded: more than one go through the temporal filter, of a camera that is `still` or `moving` on its
// way to the view. `change` is by how much the picture of a surface, which stands still, changes from the last frame but one to
// the last, in the units of the errors.
// Cost is time to shade, as a ratio to one frame of the BALANCED preset with two layers, measured in turns in one process;
// cost_built adds the time to build the layers to both.
#include "budget.hpp"
#include "metrics.hpp"
#include "questions.hpp"
#include "stage.hpp"

#include <fstream>
#include <iostream>
#include <set>
#include <sstream>

namespace {

constexpr int kSilhouette = 3; // pixels
constexpr int kBorder = 16;    // pixels

// build/trade/NAME.
File open_result(const std::string& name, const char* mode) {
    File file(std::fopen(("build/trade/" + name).c_str(), mode));
    if (!file) { throw std::runtime_error("cannot write build/trade/" + name); }
    return file;
}

enum class Task { sweep, estimators, thickness, questions, budget, check_budget };

struct Plan {
    Task task = Task::sweep;
    bool quick = false;
    int width = 320, height = 180;
    int random_count = 200;
    uint32_t seed = 1;
    int samples = 1024, turns = 5; // rays a pixel of the truth; timed frames
    std::vector<std::string> scenes;

    const char* rows() const { return task == Task::estimators ? "estimators.csv" : "rows.csv"; } // what was measured
};

// ---- Truth ----------------------------------------------------------------------------------------------

struct Truth {
    Pixels obscurance, visibility; // of the AO radius: what ao is compared with, and cosine-weighted
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
    if (plan.task == Task::estimators) { truth->obscurance = truth->visibility; }
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
    "rmse",        "mae",    "bias",  "p95",  "relative",   "ssim",  "gain",  "power", "rmse_cosine", "rmse_silhouette",
    "rmse_border", "change", "wrong", "cost", "cost_built", "bytes", "texels"};
enum Measure {
    kRmse,
    kMae,
    kBias,
    kP95,
    kRelative,
    kSsim,
    kGain,
    kPower,
    kRmseCosine,
    kRmseSilhouette,
    kRmseBorder,
    kChange,
    kWrong,
    kCost,
    kCostBuilt,
    kBytes,
    kTexels,
    kMeasureCount
};

struct NamedView {
    std::string name; // in this run
    std::string view; // file and camera: the same in all runs, and no other's
};

struct Row {
    std::string scene, view; // as above
    std::string size, effect, frames, camera, around, varied, key;
    std::array<double, kMeasureCount> measures{};
    bool on_front = false; // no other setting of the scene and effect costs less and is nearer to the truth
};

constexpr size_t kTexts = 9; // columns before the measures

std::vector<std::string> split(const std::string& line) {
    std::vector<std::string> words;
    std::istringstream stream(line);
    for (std::string word; std::getline(stream, word, ',');) { words.push_back(word); }
    return words;
}

std::string text_of(const Row& row) {
    std::string line = row.scene;
    for (const std::string* text :
         {&row.view, &row.size, &row.effect, &row.frames, &row.camera, &row.around, &row.varied, &row.key}) {
        line += "," + *text;
    }
    for (const double measure : row.measures) {
        char number[32];
        std::snprintf(number, sizeof number, ",%.6g", measure);
        line += number;
    }
    return line;
}

// Of a file that an earlier run left, or none, without a line that was cut off.
std::vector<Row> read_rows(const std::string& path) {
    std::vector<Row> rows;
    std::ifstream file(path);
    for (std::string line; std::getline(file, line);) {
        const std::vector<std::string> words = split(line);
        if (file.eof() || words.size() != kTexts + kMeasureCount) { continue; }
        Row row{words[0], words[1], words[2], words[3], words[4], words[5], words[6], words[7], words[8]};
        for (size_t i = 0; i < kMeasureCount; ++i) {
            row.measures[i] = std::strtod(words[kTexts + i].c_str(), nullptr);
        }
        rows.push_back(std::move(row));
    }
    return rows;
}

void write_rows(const std::string& name, const std::vector<Row>& rows) {
    const File file = open_result(name, "w");
    for (const Row& row : rows) { std::fprintf(file.get(), "%s\n", text_of(row).c_str()); }
}

// Of the same view, effect and condition: only these are compared with each other.
bool same_contest(const Row& a, const Row& b) {
    return a.view == b.view && a.size == b.size && a.effect == b.effect && a.frames == b.frames && a.camera == b.camera;
}

const Row* find_row(const std::vector<Row>& rows, const Row& wanted) {
    const auto found = std::find_if(rows.begin(), rows.end(),
                                    [&](const Row& row) { return same_contest(row, wanted) && row.key == wanted.key; });
    return found != rows.end() ? &*found : nullptr;
}

// ---- Measuring ------------------------------------------------------------------------------------------

// A setting, its pictures of all frames, and its time to shade.
class Contender {
public:
    Contender(Stage* stage, const Setting& setting)
        : stage_(stage), setting_(setting), params_(scaled(setting.params, stage->size())),
          built_(&stage->built(setting)),
          library_(describe(stage->view(), setting), nullptr, false, get_proc_of(setting.baseline)) {}

    const Setting& setting() const { return setting_; }
    const dgb_params& params() const { return params_; }
    double build_ms() const { return built_->build_ms; }
    double bytes() const { return double(library_.context()->plan.bytes); }

    // All frames of the setting, after which there is something to read.
    void run() {
        const bool moves = setting_.condition.moving && setting_.condition.frames > 1;
        const bool is_smaller = setting_.desc.layers > 1 && setting_.desc.divisor > 1;
        if (moves || is_smaller) { // the layers that are kept are of one pose, and of one resolution
            renderer_ = stage_->shaded(setting_, &before_);
            return;
        }
        for (int frame = 1; frame <= setting_.condition.frames; ++frame) {
            if (frame > 1) { before_ = {stage_->view().view, stage_->points(), shown()}; }
            shade();
        }
    }

    double shade() { // milliseconds; again: one frame more, in which nothing moved
        library_.set_layers(stage_->dgb_view_now(), built_->layers->handles(setting_.desc.layers));
        glFinish();
        const double start = deciding_ms();
        library_.shade(params_);
        glFinish();
        return deciding_ms() - start;
    }

    Pixels read(dgb_slot slot, GLenum format) const {
        return renderer_ ? renderer_->read_texture(slot, 0, format) : library_.read(slot, format);
    }
    Pixels shown() const {
        const Shown what = shown_of(setting_.effect);
        return read(what.slot, what.format);
    }
    const Snapshot& before() const { return before_; } // the last frame but one; without one there is no picture

private:
    static dgb_desc describe(const ReferenceView& view, const Setting& setting) {
        dgb_desc desc = setting.desc;
        desc.oracle = DGB_ORACLE_DEFAULT; // the layers are there already
        desc.divisor = 0;
        return EngineLayers::describe(view.width, view.height, desc.layers, effects_of(setting), desc);
    }

    Stage* stage_;
    Setting setting_;
    dgb_params params_;
    const Built* built_;
    Library library_;
    std::unique_ptr<SceneRenderer> renderer_; // that has the pictures; none: the library above
    Snapshot before_;
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

// What a composite would make of what the library shows, in the units of the truth.
Pixels seen(const Pixels& shown, const Setting& setting, const Truth& truth) {
    switch (setting.effect) {
    case Effect::occlusion: return shown;
    case Effect::light: return composited(shown, setting.coverage);
    case Effect::mirror: break;
    }
    return shown_in_mirrors(shown, truth);
}

Picture picture_of(const Contender& contender, const Truth& truth) {
    const Setting& setting = contender.setting();
    Pixels value = seen(contender.shown(), setting, truth);
    if (setting.effect == Effect::occlusion) {
        return {std::move(value), truth.obscurance, nullptr, 1, 1.0, truth.surface};
    }
    if (setting.effect == Effect::light) {
        return {std::move(value), truth.both, truth.irradiance, 3, truth.mean_irradiance, truth.surface};
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
    return {std::move(value), radiance, nullptr, 3, sum / std::max(count, 1.0), truth.mirrors};
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

// The picture of the frame before, where it shows the same surface: bilinear, of texels whose surfaces lie in the plane of the
// point, within a hundredth of its distance; less than half of the weights is not a place to compare with.
bool sample_before(const Snapshot& before, const Pixels& picture, size_t channels, const ReferenceView& view,
                   const SurfacePoint& point, float value[3]) {
    const glm::vec4 clip = view.projection * before.view * glm::vec4(point.position, 1.0f);
    const glm::vec2 size(view.width, view.height);
    const glm::vec2 at = (glm::vec2(clip) / clip.w * 0.5f + 0.5f) * size - 0.5f, low = glm::floor(at), part = at - low;
    float total = 0.0f;
    std::fill_n(value, channels, 0.0f);
    for (int i = 0; i < 4; ++i) {
        const glm::ivec2 corner(i & 1, i >> 1), texel = glm::ivec2(low) + corner;
        if (texel.x < 0 || texel.y < 0 || texel.x >= view.width || texel.y >= view.height) { continue; }
        const size_t index = size_t(texel.y) * size_t(view.width) + size_t(texel.x);
        const SurfacePoint& there = before.points[index];
        const bool same = there.normal != glm::vec3(0.0f) &&
                          std::abs(glm::dot(point.normal, there.position - point.position)) <= 0.01f * clip.w;
        const float weight = (corner.x != 0 ? part.x : 1.0f - part.x) * (corner.y != 0 ? part.y : 1.0f - part.y);
        if (!same) { continue; }
        for (size_t c = 0; c < channels; ++c) { value[c] += weight * picture[index * channels + c]; }
        total += weight;
    }
    for (size_t c = 0; c < channels; ++c) { value[c] /= std::max(total, 0.5f); }
    return clip.w > 0.0f && total >= 0.5f;
}

// How much a surface changes from the last frame but one to the last, on average, which should not be at all.
double change_of(const Contender& contender, const Picture& p, const Stage& stage, const Truth& truth) {
    const Snapshot& before = contender.before();
    if (before.picture.empty()) { return 0.0; }
    const Pixels picture = seen(before.picture, contender.setting(), truth);
    double sum = 0.0;
    int64_t count = 0;
    for (size_t i = 0; i < stage.points().size(); ++i) {
        float value[3];
        if (!p.mask[i] || !sample_before(before, picture, p.channels, stage.view(), stage.points()[i], value)) {
            continue;
        }
        for (size_t c = 0; c < p.channels; ++c) { sum += double(std::abs(p.value[i * p.channels + c] - value[c])); }
        count += int64_t(p.channels);
    }
    return sum / double(std::max<int64_t>(count, 1)) / p.unit;
}

Row measure(Stage* stage, const Plan& plan, const Truth& truth, const Setting& setting, Contender* baseline, Row row) {
    Contender contender(stage, setting);
    contender.run();
    const Picture picture = picture_of(contender, truth);
    fill_errors(picture, plan, truth, &row);
    row.measures[kChange] = change_of(contender, picture, *stage, truth);
    if (setting.effect == Effect::occlusion) {
        row.measures[kPower] = best_power(picture.value, picture.truth, truth.surface);
        row.measures[kRmseCosine] = measure_error(picture.value, truth.visibility, 1, truth.surface).rmse;
    }
    if (setting.effect == Effect::mirror) { row.measures[kWrong] = wrong_hits(contender, *stage, truth); }
    row.measures[kBytes] = contender.bytes();
    row.measures[kTexels] = texels_of(setting);

    std::vector<double> ratios, ratios_built;
    contender.shade();
    baseline->shade();
    for (int turn = 0; turn < plan.turns; ++turn) {
        const double own = contender.shade(), base = baseline->shade();
        ratios.push_back(own / base);
        ratios_built.push_back((own + contender.build_ms()) / (base + baseline->build_ms()));
    }
    row.measures[kCost] = median(ratios);
    row.measures[kCostBuilt] = median(ratios_built);
    return row;
}

// ---- Fronts and answers ---------------------------------------------------------------------------------

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
    std::string head = "scene,view,size,effect,frames,camera,around,varied,setting";
    for (const char* measure : kMeasures) { head += std::string(",") + measure; }
    std::fprintf(csv.get(), "%s,front\n", head.c_str());
    for (const Row& row : rows) { std::fprintf(csv.get(), "%s,%d\n", text_of(row).c_str(), int(row.on_front)); }
}

// Of every contest in which both settings were measured: ratios to the BALANCED preset, geometric mean of the scenes; of costs,
// to those of its first frame.
struct Worth {
    double error = 0.0, silhouette = 0.0, change = 0.0, cost = 0.0, cost_built = 0.0; // logarithms, summed
    int scenes = 0;

    void add(const Row& row, const Row& base) {
        const auto ratio = [&](Measure m) {
            return std::log(std::max(row.measures[m], 1e-9) / std::max(base.measures[m], 1e-9));
        };
        error += ratio(kRmse);
        silhouette += ratio(kRmseSilhouette);
        change += ratio(kChange);
        cost += std::log(row.measures[kCost]);
        cost_built += std::log(row.measures[kCostBuilt]);
        ++scenes;
    }
    double of(double sum) const { return std::exp(sum / double(std::max(scenes, 1))); }
};

// The condition of most settings.
bool is_first_frame(const Row& row) { return row.frames == "1" && row.camera == "moving"; }

// Where the preset stands in a contest.
const Row* preset_row(const std::vector<Row>& rows, const Row& of) {
    const auto found = std::find_if(rows.begin(), rows.end(), [&](const Row& row) {
        return same_contest(row, of) && row.around == "balanced" && row.varied.empty();
    });
    return found != rows.end() ? &*found : nullptr;
}

// And where its first frame does, with a moving camera.
const Row* first_frame(const std::vector<Row>& rows, Row of) {
    of.frames = "1";
    of.camera = "moving";
    return preset_row(rows, of);
}

using Worths = std::vector<std::pair<std::string, Worth>>; // in the order of the settings

Worth& worth_of(Worths* worths, const std::string& name) {
    const auto found = std::find_if(worths->begin(), worths->end(), [&](const auto& w) { return w.first == name; });
    return found != worths->end() ? found->second : worths->emplace_back(name, Worth{}).second;
}

void print_worth(const std::vector<Row>& rows, Effect effect, const Row& contest) {
    Worths worths;
    Worth own; // of the preset, to its first frame
    for (const Row& row : rows) {
        const Row *base = preset_row(rows, row), *first = first_frame(rows, row);
        const bool preset = row.varied.empty() && row.around != "random";
        const bool same = row.effect == name_of(effect) && row.frames == contest.frames && row.camera == contest.camera;
        if (!same || base == nullptr || first == nullptr || (row.around != "balanced" && !preset)) { continue; }
        if (&row == base) { own.add(row, *first); }
        worth_of(&worths, preset ? row.around : row.varied).add(row, *base);
    }
    if (worths.empty()) { return; }
    std::printf(
        "\n%s, frame %s, camera %s: ratios to BALANCED with two layers, which errs by %.3f of its first frame under "
        "a moving camera; geometric mean of the scenes\n    %-32s %8s %11s %8s %8s %14s %7s\n",
        name_of(effect), contest.frames.c_str(), contest.camera.c_str(), own.of(own.error), "", "RMSE", "silhouettes",
        "change", "cost", "cost, built", "scenes");
    for (const auto& [name, w] : worths) {
        std::printf("    %-32s %8.3f %11.3f %8.3f %8.3f %14.3f %7d\n", name.c_str(), w.of(w.error), w.of(w.silhouette),
                    w.of(w.change), w.of(w.cost), w.of(w.cost_built), w.scenes);
    }
}

// Of every condition under which something was measured.
void print_worths(const std::vector<Row>& rows) {
    for (const Effect effect : kEffects) {
        std::set<std::string> seen;
        for (const Row& row : rows) {
            if (seen.insert(row.frames + row.camera).second) { print_worth(rows, effect, row); }
        }
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
        if (!is_first_frame(row) || !seen.insert(row.scene + "," + row.effect).second) { continue; }
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
        if (!row.varied.empty() || row.around == "random" || !is_first_frame(row)) { continue; }
        const auto& m = row.measures;
        std::printf("    %-24s %-12s %-12s %9.4f %+9.4f %8.3f %8.3f %8.1f%% %11.4f %8.4f %8.3f %6s\n",
                    row.scene.c_str(), row.effect.c_str(), row.around.c_str(), m[kRmse], m[kBias], m[kSsim], m[kGain],
                    100.0 * m[kWrong], m[kRmseSilhouette], m[kRmseBorder], m[kCost], row.on_front ? "yes" : "");
    }
}

// ---- Estimators -----------------------------------------------------------------------------------------

// The estimators of one effect under one condition, in the order of the rows.
struct League {
    const std::vector<Row>& rows;
    Row contest; // of all its scenes

    bool has(const Row& row) const {
        return row.effect == contest.effect && row.frames == contest.frames && row.camera == contest.camera;
    }
    std::vector<std::string> each(std::string Row::*column) const {
        std::vector<std::string> values;
        for (const Row& row : rows) {
            const bool seen = std::count(values.begin(), values.end(), row.*column) > 0;
            if (has(row) && !seen) { values.push_back(row.*column); }
        }
        return values;
    }
    // The least error of an estimator in a scene for so much; infinite when there is none.
    double best(const std::string& view, const std::string& estimator, double cost, Measure error) const {
        double least = std::numeric_limits<double>::infinity();
        for (const Row& row : rows) {
            const bool may =
                has(row) && row.view == view && row.around == estimator && row.measures[kCostBuilt] <= cost;
            if (may) { least = std::min(least, row.measures[error]); }
        }
        return least;
    }
    // Over that of the first estimator, geometric mean of the scenes; NaN where it is not to be had for so much.
    double ratio(const std::string& estimator, double cost, Measure error) const {
        double sum = 0.0;
        const std::vector<std::string> views = each(&Row::view);
        for (const std::string& view : views) {
            sum += std::log(best(view, estimator, cost, error) / best(view, contest.around, kAnyCost, error));
        }
        return std::isfinite(sum) ? std::exp(sum / double(views.size())) : std::numeric_limits<double>::quiet_NaN();
    }
    // Scenes in which nobody errs less for so much.
    int wins(const std::string& estimator, double cost) const {
        int count = 0;
        for (const std::string& view : each(&Row::view)) {
            const double own = best(view, estimator, cost, kRmse);
            bool least = std::isfinite(own);
            for (const std::string& other : each(&Row::around)) {
                least = least && own <= best(view, other, cost, kRmse);
            }
            count += least;
        }
        return count;
    }

    static constexpr double kAnyCost = 1e9;
};

// At the preset's taps and filter.
void print_equal_taps(const League& league, const std::string& estimator) {
    double mean[kMeasureCount] = {}, scenes = 0.0;
    for (const Row& row : league.rows) {
        if (!league.has(row) || row.around != estimator || !row.varied.empty()) { continue; }
        for (size_t i = 0; i < kMeasureCount; ++i) { mean[i] += row.measures[i]; }
        scenes += 1.0;
    }
    for (const Measure m : {kRmse, kRmseSilhouette, kSsim, kGain, kPower, kChange, kCost}) {
        std::printf(" %7.3f", mean[m] / std::max(scenes, 1.0));
    }
}

void print_league(const League& league) {
    constexpr double kCosts[] = {0.8, 1.0, 1.5, 2.5};
    std::printf("\n%s, frame %s, camera %s, %zu scenes. Equal taps: means. Equal cost, building included: least error "
                "over the least of "
                "%s at any cost, geometric mean; in brackets: scenes in which it is the least of all\n    %-18s",
                league.contest.effect.c_str(), league.contest.frames.c_str(), league.contest.camera.c_str(),
                league.each(&Row::view).size(), league.contest.around.c_str(), "");
    for (const char* head : {"RMSE", "edges", "SSIM", "gain", "power", "change", "cost"}) { std::printf(" %7s", head); }
    for (const double cost : kCosts) { std::printf("   cost %.1f", cost); }
    std::printf("\n");
    for (const std::string& estimator : league.each(&Row::around)) {
        std::printf("    %-18s", estimator.c_str());
        print_equal_taps(league, estimator);
        for (const double cost : kCosts) {
            const double ratio = league.ratio(estimator, cost, kRmse); // of scenes where it is to be had for so much
            std::isnan(ratio) ? std::printf("  %5s    ", "-")
                              : std::printf("  %5.2f (%d)", ratio, league.wins(estimator, cost));
        }
        std::printf("\n");
    }
}

void print_estimators(const std::vector<Row>& rows) {
    std::set<std::string> seen;
    for (const Row& row : rows) {
        if (seen.insert(row.effect + row.frames + row.camera).second) { print_league({rows, row}); }
    }
}

// ---- Plot -----------------------------------------------------------------------------------------------

// A row of panels an effect, one a scene: error over cost; the front is a line.
void write_plot_script(const std::vector<NamedView>& scenes) {
    const File script = open_result("trade.gnuplot", "w");
    std::FILE* out = script.get();
    std::fprintf(out,
                 "set terminal svg size %zu, 1020 background rgb 'white'\nset output 'build/trade/trade.svg'\n"
                 "set datafile separator ','\nset datafile columnheaders\nset multiplot layout 3, %zu\nset grid\nset "
                 "logscale xy\nset autoscale fix\nset offsets graph 0.05, graph 0.05, graph 0.25, graph 0.05\n"
                 "set key font ',9'\nset format y '%%.3g'\nset format x '%%.2g'\n",
                 std::max<size_t>(360 * scenes.size(), 480), scenes.size());
    for (const Effect effect : kEffects) {
        for (const NamedView& scene : scenes) {
            const std::string mine = "strcol('scene') eq '" + scene.name + "' && strcol('effect') eq '" +
                                     name_of(effect) + "' && column('frames') == 1 && strcol('camera') eq 'moving'";
            const auto points = [&](const std::string& which) {
                return "(" + mine + " && " + which + " ? column('cost_built') : NaN):'rmse'";
            };
            std::fprintf(out,
                         "set title '%s, %s' noenhanced\nset xlabel 'cost, building included'\nset ylabel 'RMSE'\n",
                         scene.name.c_str(), name_of(effect));
            std::fprintf(
                out,
                "plot 'build/trade/trade.csv' using %s with points pt 7 ps 0.35 lc rgb '#d95f02' title '1 layer', "
                "'' using %s with points pt 7 ps 0.35 lc rgb '#1b9e77' title '2 layers', "
                "'' using %s with points pt 6 ps 0.8 lc rgb 'black' title 'front', "
                "'' using %s:'around' with labels offset 0, 0.7 font ',9' notitle\n",
                points("strcol('setting')[1:2] eq 'k1'").c_str(), points("strcol('setting')[1:2] eq 'k2'").c_str(),
                points("column('front') > 0").c_str(),
                points("strcol('varied') eq '' && strcol('around') ne 'random'").c_str());
        }
    }
}

void plot(const std::vector<NamedView>& scenes) {
    write_plot_script(scenes);
    if (std::system("command -v gnuplot >/dev/null && gnuplot build/trade/trade.gnuplot") == 0) { // NOLINT
        std::printf("\nbuild/trade/trade.csv, build/trade/trade.svg\n");
    } else {
        std::printf(
            "\nbuild/trade/trade.csv; for the plot: apt-get install gnuplot-nox; gnuplot build/trade/trade.gnuplot\n");
    }
}

// ---- Program --------------------------------------------------------------------------------------------

// File, without its folder, and camera; no commas.
std::string view_text(const std::string& argument) {
    const size_t at = std::min(argument.find('@'), argument.size());
    const std::string file = at == 0 ? "atrium" : argument.substr(0, at);
    std::string text = file.substr(file.find_last_of('/') + 1) + argument.substr(at);
    std::replace(text.begin(), text.end(), ',', ' ');
    return text;
}

std::string size_text(const Plan& plan) { return std::to_string(plan.width) + "x" + std::to_string(plan.height); }

Row name_row(const NamedView& scene, const Plan& plan, const Setting& setting) {
    return {scene.name,
            scene.view,
            size_text(plan),
            name_of(setting.effect),
            std::to_string(setting.condition.frames),
            setting.condition.moving ? "moving" : "still",
            setting.around,
            setting.varied,
            key_of(setting)};
}

// Everything that is not in `rows` yet goes there and, at once, into rows.csv.
void sweep(const std::string& argument, const NamedView& scene, const Plan& plan, const std::vector<Setting>& settings,
           std::vector<Row>* rows) {
    std::vector<Setting> missing;
    for (const Setting& setting : settings) {
        if (find_row(*rows, name_row(scene, plan, setting)) == nullptr) { missing.push_back(setting); }
    }
    std::printf("%s, %s: %zu settings, %zu to measure\n", scene.name.c_str(), size_text(plan).c_str(), settings.size(),
                missing.size());
    std::fflush(stdout);
    if (missing.empty()) { return; }
    Stage stage(argument, plan.width, plan.height);
    const Truth truth = trace_truth(stage, plan);
    const File file = open_result(plan.rows(), "a");
    std::map<Effect, Contender> baselines;
    for (const Effect effect : kEffects) {
        baselines.try_emplace(effect, &stage, preset_setting(effect, DGB_PRESET_BALANCED));
    }
    for (size_t i = 0; i < missing.size(); ++i) {
        rows->push_back(measure(&stage, plan, truth, missing[i], &baselines.at(missing[i].effect),
                                name_row(scene, plan, missing[i])));
        std::fprintf(file.get(), "%s\n", text_of(rows->back()).c_str());
        std::fflush(file.get());
        if ((i + 1) % 50 == 0) {
            std::printf("    %zu of %zu\n", i + 1, missing.size());
            std::fflush(stdout);
        }
    }
}

// In the order of the settings, whatever was measured when.
std::vector<Row> in_order(const std::vector<Row>& rows, const std::vector<NamedView>& scenes, const Plan& plan,
                          const std::vector<Setting>& settings) {
    std::vector<Row> ordered;
    for (const NamedView& scene : scenes) {
        for (const Setting& setting : settings) {
            Row wanted = name_row(scene, plan, setting);
            if (const Row* row = find_row(rows, wanted)) {
                wanted.measures = row->measures;
                ordered.push_back(std::move(wanted));
            }
        }
    }
    return ordered;
}

// The scenes' names, each once.
std::vector<NamedView> name_views(const std::vector<std::string>& arguments) {
    std::vector<NamedView> views;
    std::vector<std::string> names;
    for (const std::string& argument : arguments) {
        const std::string view = view_text(argument);
        names.push_back(view.substr(0, view.find('@')));
        tell_from({names.begin(), names.end() - 1}, &names.back());
        views.push_back({names.back(), view});
    }
    return views;
}

const std::map<std::string, Task> kTasks = {{"--estimators", Task::estimators},
                                            {"--thickness", Task::thickness},
                                            {"--questions", Task::questions},
                                            {"--budget", Task::budget},
                                            {"--check-budget", Task::check_budget}};

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
        } else if (const auto task = kTasks.find(words[i]); task != kTasks.end()) {
            plan.task = task->second;
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

std::vector<Setting> settings_of(const Plan& plan) {
    switch (plan.task) {
    case Task::budget: return budget_settings();
    case Task::thickness: return thickness_settings();
    case Task::estimators: return estimator_settings(plan.quick);
    default: return plan.quick ? few_settings() : all_settings(plan.random_count, plan.seed);
    }
}

void run(const Options& options) {
    std::vector<std::string> words = options.scenes;
    if (options.quick) { words.insert(words.begin(), "--quick"); }
    const Plan plan = parse(words);
    mkdir("build", 0777);
    mkdir("build/trade", 0777);
    if (plan.task == Task::questions) {
        answer(plan);
        return;
    }
    if (plan.task == Task::check_budget) {
        check_budget();
        return;
    }
    const std::vector<Setting> settings = settings_of(plan);
    const std::vector<NamedView> scenes = name_views(plan.scenes);
    std::vector<Row> rows = read_rows(std::string("build/trade/") + plan.rows());
    write_rows(plan.rows(), rows); // without a line that was cut off, which the next would go on
    for (size_t i = 0; i < scenes.size(); ++i) { sweep(plan.scenes[i], scenes[i], plan, settings, &rows); }
    std::vector<Row> ordered = in_order(rows, scenes, plan, settings);
    if (plan.task == Task::budget) {
        write_budget(ordered, settings);
        return;
    }
    if (plan.task == Task::estimators) {
        print_estimators(ordered);
        return;
    }
    mark_fronts(&ordered);
    write_csv(ordered);
    print_presets(ordered);
    print_layers(ordered);
    print_worths(ordered);
    plot(scenes);
}

} // namespace

int main(int argc, char** argv) { return run_benchmark("trade", argc, argv, run); }
