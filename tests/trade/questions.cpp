#include "questions.hpp"

#include "estimate.hpp"
#include "metrics.hpp"
#include "setting.hpp"

#include <cmath>

namespace {

using glm::vec3;
using Layers = std::vector<std::vector<Surface>>;
using Radiance = std::vector<std::vector<vec3>>;
using Pixels = std::vector<float>;

constexpr int kMany = 256;     // taps that leave no noise to speak of
constexpr int kFrames = 16;    // averaged
constexpr float kSame = 0.05f; // metres between a point and a layer that holds it, and 1 % of its distance

struct Case { // one line of a table
    std::string question, name;
    int taps = 0;
    double ao = 0.0;         // RMSE against the paper's integral over the true geometry; NaN: does not apply
    double irradiance = 0.0; // RMSE of irradiance times confidence, a share of the true mean
    double covered = 0.0;    // the same with the true share of the hemisphere in place of the confidence
};

// One view of a scene with the truth for it.
class Bench {
public:
    Bench(const Subject& subject, const QuestionPlan& plan);

    const dgb_params& params() const { return params_; }
    const ReferenceScene& scene() const { return scene_; }
    const ReferenceView& view() const { return view_; }
    const QuestionPlan& plan() const { return plan_; }
    const std::vector<bool>& mask() const { return mask_; }
    const Layers& two_layers() const { return two_; }
    const Radiance& two_radiances() const { return two_radiance_; }

    Case judge(const std::string& question, const std::string& name, int taps, const Shading& shading) const;
    // Of RGB as it is, in W/m2.
    double irradiance_rmse(const Pixels& rgb) const;
    double noise() const { return noise_; } // standard error of the true irradiance, a share of its mean
    const std::vector<SurfacePoint>& points() const { return points_; } // normal 0 where nothing is asked

private:
    const QuestionPlan& plan_;
    dgb_params params_;
    ReferenceScene scene_;
    ReferenceView view_;
    Layers two_;
    Radiance two_radiance_;
    std::vector<SurfacePoint> points_;
    std::vector<bool> mask_;
    Pixels ao_, halves_[2], coverage_;
    double mean_ = 0.0, noise_ = 0.0;
};

ReferenceView view_of(const Subject& subject, const QuestionPlan& plan) {
    ReferenceView view;
    view.view = view_matrix(subject.view.camera);
    view.projection =
        projection_matrix(subject.view.camera, float(plan.width) / float(plan.height), ClipRange::standard);
    view.width = plan.width;
    view.height = plan.height;
    return view;
}

Bench::Bench(const Subject& subject, const QuestionPlan& plan)
    : plan_(plan), params_(scaled(dgb_preset(DGB_PRESET_QUALITY), subject.size())),
      scene_(subject.view.scene, current_pose(subject.view.scene), subject.lights), view_(view_of(subject, plan)),
      two_(trace_layers(scene_, view_, 2, params_.separation)), two_radiance_(radiance_of(scene_, two_)),
      points_(surface_points(two_[0])) {
    for (size_t i = 0; i < points_.size(); ++i) {
        const size_t x = i % size_t(plan.width), y = i / size_t(plan.width), step = size_t(plan.stride);
        mask_.push_back(two_[0][i].found() && x % step == 0 && y % step == 0);
        if (!mask_.back()) { points_[i].normal = vec3(0.0f); }
    }
    const float r = params_.ao_radius;
    const ObscuranceOptions obscurance{r, params_.ao_bias * r, params_.ao_epsilon * r * r, 8, 0.0f};
    for (const auto& e : trace_obscurance(scene_, view_, points_, obscurance, plan.rays, plan.seed)) {
        ao_.push_back(float(visibility_of_obscurance(e.mean)));
    }
    double squares = 0.0;
    for (const auto& e : trace_irradiance(scene_, points_, {1, params_.radius, false}, plan.rays, plan.seed)) {
        for (int c = 0; c < 3; ++c) {
            for (int half = 0; half < 2; ++half) { halves_[half].push_back(float(e.halves[half][c])); }
            mean_ += e.mean[c];
            squares += e.error[c] * e.error[c];
        }
        coverage_.push_back(float(e.mean.w));
    }
    const double count = 3.0 * double(std::count(mask_.begin(), mask_.end(), true));
    mean_ = std::max(mean_ / std::max(count, 1.0), 1e-9);
    noise_ = std::sqrt(squares / std::max(count, 1.0)) / mean_;
}

double Bench::irradiance_rmse(const Pixels& rgb) const {
    return std::sqrt(std::max(unbiased_squared_error(rgb, halves_[0], halves_[1], 3, mask_), 0.0)) / mean_;
}

Case Bench::judge(const std::string& question, const std::string& name, int taps, const Shading& shading) const {
    Pixels weighed, covered;
    for (size_t i = 0; i < mask_.size(); ++i) {
        for (size_t c = 4 * i; c < 4 * i + 3; ++c) {
            weighed.push_back(shading.irradiance[c] * shading.irradiance[4 * i + 3]);
            covered.push_back(shading.irradiance[c] * coverage_[i]);
        }
    }
    return {question,
            name,
            taps,
            measure_error(shading.visibility, ao_, 1, mask_).rmse,
            irradiance_rmse(weighed),
            irradiance_rmse(covered)};
}

EstimateOptions options_for(const Bench& bench, int taps) {
    EstimateOptions options;
    options.params = bench.params();
    options.params.ao_samples = options.params.samples = taps;
    options.stride = bench.plan().stride;
    return options;
}

Shading shade(const Bench& bench, const EstimateOptions& options) {
    return estimate(bench.scene(), bench.view(), bench.two_layers(), bench.two_radiances(), options);
}

// ---- How many layers ------------------------------------------------------------------------------------

void ask_for_layers(const Bench& bench, std::vector<Case>* cases) {
    const auto ask = [&](int count, float separation) {
        const Layers layers = trace_layers(bench.scene(), bench.view(), count, separation);
        const Shading shading = estimate(bench.scene(), bench.view(), layers, radiance_of(bench.scene(), layers),
                                         options_for(bench, kMany));
        char name[64];
        std::snprintf(name, sizeof name, "%d layer%s, separation %g m", count, count > 1 ? "s" : "",
                      double(separation));
        cases->push_back(bench.judge("layers", name, kMany, shading));
    };
    ask(1, 0.0f);
    for (const float share : {0.0f, 0.1f, 0.5f, 1.0f, 2.0f}) { ask(2, share * bench.params().separation); }
    for (const int count : {3, 4, 8}) {
        for (const float share : {0.0f, 1.0f}) { ask(count, share * bench.params().separation); }
    }
}

// ---- Where the error comes from -------------------------------------------------------------------------

// The layer of the pixel that a point projects to which holds it, or -1: nobody who has these layers can know it.
int holder_of(vec3 position, const Layers& layers, const ReferenceView& view) {
    const glm::vec4 camera = view.view * glm::vec4(position, 1.0f), clip = view.projection * camera;
    const glm::vec2 at = (glm::vec2(clip) / clip.w * 0.5f + 0.5f) * glm::vec2(view.width, view.height);
    const bool inside =
        clip.w > 0.0f && at.x >= 0.0f && at.y >= 0.0f && at.x < float(view.width) && at.y < float(view.height);
    if (!inside) { return -1; }
    const size_t pixel = size_t(at.y) * size_t(view.width) + size_t(at.x);
    for (size_t layer = 0; layer < layers.size(); ++layer) {
        const Surface& surface = layers[layer][pixel];
        if (surface.found() && std::abs(surface.z - camera.z) <= kSame + 0.01f * std::abs(camera.z)) {
            return int(layer);
        }
    }
    return -1;
}

// Irradiance by rays over the hemisphere, of what the first `layers` layers hold.
Pixels limited_to_view(const Bench& bench, int layers, int rays) {
    const ReferenceView& view = bench.view();
    Pixels rgb(3 * view.pixels(), 0.0f);
    for_each(view.pixels(), [&](size_t i) {
        if (!bench.mask()[i]) { return; }
        const SurfacePoint& point = bench.points()[i];
        const vec3 side =
            glm::normalize(glm::cross(point.normal, std::abs(point.normal.y) < 0.9f ? vec3(0, 1, 0) : vec3(1, 0, 0)));
        const vec3 other = glm::cross(point.normal, side);
        vec3 sum(0.0f);
        for (int k = 0; k < rays; ++k) { // cosine-weighted, by the R2 sequence turned by the pixel
            const float u = glm::fract(0.5f + 0.7548776662f * float(k + 1) + 0.618034f * float(i % 65536));
            const float v = glm::fract(0.5f + 0.5698402910f * float(k + 1) + 0.754878f * float(i % 65536));
            const float sine = std::sqrt(u), angle = 6.2831853f * v;
            const vec3 direction =
                sine * std::cos(angle) * side + sine * std::sin(angle) * other + std::sqrt(1.0f - u) * point.normal;
            Ray ray{point.position + point.lift * point.normal, glm::normalize(direction)};
            ray.farthest = bench.params().radius;
            const Surface hit = bench.scene().closest(ray, Faces::both);
            if (!hit.found() || !hit.front) { continue; }
            const int holder = holder_of(hit.position, bench.two_layers(), view);
            if (holder >= 0 && holder < layers) { sum += bench.scene().outgoing(hit); }
        }
        for (int c = 0; c < 3; ++c) { rgb[3 * i + size_t(c)] = 3.14159265f * sum[c] / float(rays); }
    });
    return rgb;
}

void ask_for_errors(const Bench& bench, std::vector<Case>* cases) {
    const auto add = [&](const std::string& name, int taps, const EstimateOptions& options) {
        cases->push_back(bench.judge("ladder", name, taps, shade(bench, options)));
    };
    for (const int layers : {2, 1}) {
        const Pixels rgb = limited_to_view(bench, layers, kMany);
        const double rmse = bench.irradiance_rmse(rgb);
        cases->push_back({"ladder",
                          "rays, what " + std::to_string(layers) + (layers > 1 ? " layers" : " layer") + " hold", kMany,
                          std::nan(""), rmse, rmse});
    }
    EstimateOptions options = options_for(bench, kMany);
    options.rays = true;
    add("spiral, visibility by rays", kMany, options);
    options.rays = false;
    add("spiral, none", kMany, options);
    options.params.normal_test = false;
    add("and no normal test", kMany, options);
    options = options_for(bench, bench.params().samples);
    add("spiral of the QUALITY preset", bench.params().samples, options);
}

// ---- Patterns -------------------------------------------------------------------------------------------

// The average of frames that take turned taps; irradiance weighed by confidence, as the temporal filter has it.
Shading mean_of_frames(const Bench& bench, EstimateOptions options, int frames) {
    Shading mean;
    mean.visibility.assign(bench.view().pixels(), 0.0f);
    mean.irradiance.assign(4 * bench.view().pixels(), 0.0f);
    const float share = 1.0f / float(frames);
    for (options.frame = 0; options.frame < frames; ++options.frame) {
        const Shading one = shade(bench, options);
        for (size_t i = 0; i < mean.visibility.size(); ++i) {
            const float confidence = one.irradiance[4 * i + 3];
            mean.visibility[i] += share * one.visibility[i];
            for (size_t c = 4 * i; c < 4 * i + 3; ++c) { mean.irradiance[c] += share * confidence * one.irradiance[c]; }
            mean.irradiance[4 * i + 3] += share * confidence;
        }
    }
    for (size_t i = 0; i < mean.irradiance.size(); ++i) {
        const float confidence = mean.irradiance[i - i % 4 + 3];
        if (i % 4 < 3 && confidence > 0.0f) { mean.irradiance[i] /= confidence; }
    }
    return mean;
}

void ask_for_patterns(const Bench& bench, std::vector<Case>* cases) {
    constexpr std::pair<Pattern, const char*> kPatterns[] = {{Pattern::spiral, "spiral"},
                                                             {Pattern::hammersley, "hammersley"},
                                                             {Pattern::r2, "r2"},
                                                             {Pattern::random, "random"}};
    for (const int taps : {8, 14, 30}) {
        for (const int frames : {1, kFrames}) {
            for (const auto& [pattern, name] : kPatterns) {
                EstimateOptions options = options_for(bench, taps);
                options.pattern = pattern;
                const std::string frames_text = ", " + std::to_string(frames) + (frames > 1 ? " frames" : " frame");
                cases->push_back(
                    bench.judge("pattern", name + frames_text, taps, mean_of_frames(bench, options, frames)));
            }
        }
    }
}

// The measure that the table of turns minimises: the largest difference of (share of the taps inside) - (area) over boxes with
// edges at taps in the unit square of radius and angle (the angle goes around), times 2 n n.
int discrepancy(int n, int turns) {
    const auto angle = [&](int i) { return (2 * i + 1) * turns % (2 * n); };
    int worst = 0;
    for (int first = 0; first < n; ++first) {
        for (int last = first; last < n; ++last) {
            for (int from = first; from <= last; ++from) {
                for (int to = first; to <= last; ++to) {
                    const int width = (angle(to) - angle(from) + 2 * n) % (2 * n);
                    int inside = 0;
                    for (int i = first; i <= last; ++i) {
                        inside += (angle(i) - angle(from) + 2 * n) % (2 * n) <= width;
                    }
                    worst = std::max(worst, 2 * n * inside - (last - first) * width);
                }
            }
        }
    }
    return worst;
}

std::vector<double> ranks(const std::vector<double>& values) { // ties share their mean rank
    std::vector<double> result;
    for (const double value : values) {
        const auto below = std::count_if(values.begin(), values.end(), [&](double v) { return v < value; });
        const auto same = std::count(values.begin(), values.end(), value);
        result.push_back(double(below) + 0.5 * double(same - 1));
    }
    return result;
}

double correlation(const std::vector<double>& a, const std::vector<double>& b) {
    double ma = 0.0, mb = 0.0, ab = 0.0, aa = 0.0, bb = 0.0;
    for (size_t i = 0; i < a.size(); ++i) {
        ma += a[i] / double(a.size());
        mb += b[i] / double(b.size());
    }
    for (size_t i = 0; i < a.size(); ++i) {
        ab += (a[i] - ma) * (b[i] - mb);
        aa += (a[i] - ma) * (a[i] - ma);
        bb += (b[i] - mb) * (b[i] - mb);
    }
    return aa > 0.0 && bb > 0.0 ? ab / std::sqrt(aa * bb) : 0.0;
}

// Whether fewer boxes that are too full mean less error: Spearman's rank correlation over all numbers of turns.
void ask_for_turns(const Bench& bench, int taps, std::vector<Case>* cases) {
    std::vector<double> measure, ao, irradiance;
    for (int turns = 1; turns <= taps; ++turns) {
        EstimateOptions options = options_for(bench, taps);
        options.turns = turns;
        const Case result = bench.judge("turns", std::to_string(turns) + " turns", taps, shade(bench, options));
        cases->push_back(result);
        measure.push_back(discrepancy(taps, turns));
        ao.push_back(result.ao);
        irradiance.push_back(result.covered);
    }
    const int chosen = dgb_spiral_turns(taps);
    std::printf("    turns, %d taps: rank correlation of the table's measure with the error of AO %.2f, of irradiance "
                "%.2f; the table's "
                "%d turns are number %.0f of %d by AO, number %.0f by irradiance; error / least error %.3f, %.3f\n",
                taps, correlation(ranks(measure), ranks(ao)), correlation(ranks(measure), ranks(irradiance)), chosen,
                ranks(ao)[size_t(chosen - 1)] + 1.0, taps, ranks(irradiance)[size_t(chosen - 1)] + 1.0,
                ao[size_t(chosen - 1)] / *std::min_element(ao.begin(), ao.end()),
                irradiance[size_t(chosen - 1)] / *std::min_element(irradiance.begin(), irradiance.end()));
}

void print_cases(const std::vector<Case>& cases) {
    std::printf("    %-8s %-34s %5s %9s %12s %22s\n", "question", "", "taps", "AO", "irradiance", "with true coverage");
    for (const Case& c : cases) {
        if (c.question == "turns") { continue; } // its answer is the correlation
        std::printf("    %-8s %-34s %5d %9.4f %12.4f %22.4f\n", c.question.c_str(), c.name.c_str(), c.taps, c.ao,
                    c.irradiance, c.covered);
    }
}

} // namespace

void answer_questions(const Subject& subject, const QuestionPlan& plan, std::FILE* csv) {
    const Bench bench(subject, plan);
    std::printf("\n%s, %dx%d, every %dth pixel in x and y, %d rays a pixel (standard error of irradiance %.3f of its "
                "mean, which the "
                "errors do not hold); separation %g m, radii %g m and %g m\n",
                subject.view.name.c_str(), plan.width, plan.height, plan.stride, plan.rays, bench.noise(),
                double(bench.params().separation), double(bench.params().ao_radius), double(bench.params().radius));
    std::fflush(stdout);
    std::vector<Case> cases;
    ask_for_layers(bench, &cases);
    ask_for_errors(bench, &cases);
    ask_for_patterns(bench, &cases);
    for (const int taps : {14, 30}) { ask_for_turns(bench, taps, &cases); }
    print_cases(cases);
    for (const Case& c : cases) {
        std::fprintf(csv, "%s,%s,\"%s\",%d,%.6f,%.6f,%.6f\n", subject.view.name.c_str(), c.question.c_str(),
                     c.name.c_str(), c.taps, c.ao, c.irradiance, c.covered);
    }
    std::fflush(csv);
}
