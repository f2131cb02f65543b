// What mirror reflections cost: the linear tracer against the hierarchical one, and one layer against two, at equal steps.
//     reflections [--quick] [SCENE[@ex,ey,ez,tx,ty,tz,fov[,sx,sy,sz]]]...      without a scene: the atrium, along its floor
//
// The contenders take turns frame by frame and shade the same layers, in which every surface is a mirror. Figures are medians:
// of times, or of ratios within a turn; the clock is the process's own where the renderer is software, else the wall's. The
// hierarchical tracer's times include its ranges. A lookup is a texel that the march reads, of z or of the ranges; contexts that
// count them are not those that are timed.
#include "engine_layers.hpp"

#include <numeric>
#include <random>

namespace {

constexpr int kWarmUp = 2;
constexpr int kStrides[] = {1, 2, 4};

struct Variant {
    const char* name;
    dgb_tracer tracer;
    int layers;
};

enum VariantId { kLinearOne, kLinearTwo, kHierarchicalOne, kHierarchicalTwo, kVariantCount };

constexpr Variant kVariants[kVariantCount] = {{"linear, one layer", DGB_TRACER_LINEAR, 1},
                                              {"linear, two layers", DGB_TRACER_LINEAR, 2},
                                              {"hierarchical, one layer", DGB_TRACER_HIERARCHICAL, 1},
                                              {"hierarchical, two layers", DGB_TRACER_HIERARCHICAL, 2}};

struct Picture {
    glm::mat4 view, projection;
    const EngineLayers* layers;
};

class Tracer {
public:
    Tracer(const Picture& picture, const Variant& variant, bool counts)
        : view_(to_dgb_view(picture.view, picture.projection)), layers_(picture.layers->handles(variant.layers)),
          library_(describe(variant), &clock_, counts) {}

    void run(const dgb_params& params) {
        library_.set_layers(view_, layers_);
        library_.shade(params);
    }

    // Milliseconds of every frame: the march and what it needs.
    std::vector<double> times() const {
        std::vector<double> total = clock_.milliseconds().at("reflect");
        const auto range = clock_.milliseconds().find("range");
        for (size_t i = 0; range != clock_.milliseconds().end() && i < total.size(); ++i) {
            total[i] += range->second[i];
        }
        return total;
    }
    double range_ms() const {
        const auto range = clock_.milliseconds().find("range");
        return range != clock_.milliseconds().end() ? median(range->second) : 0.0;
    }
    void forget() { clock_.forget(); }

    std::vector<float> reflection() const { return library_.read(DGB_REFLECTION, GL_RGBA); }
    std::vector<float> hit() const { return library_.read(DGB_REFLECTION_HIT, GL_RG); }

private:
    static dgb_desc describe(const Variant& variant) {
        dgb_desc desc = EngineLayers::describe(kWidth, kHeight, variant.layers, DGB_EFFECT_REFLECT);
        desc.tracer = variant.tracer;
        return desc;
    }

    PassClock clock_;
    dgb_view view_;
    dgb_layers layers_;
    Library library_;
};

using Tracers = std::vector<std::unique_ptr<Tracer>>;

Tracers make_tracers(const Picture& picture, bool counts) {
    Tracers tracers;
    for (const Variant& variant : kVariants) { tracers.push_back(std::make_unique<Tracer>(picture, variant, counts)); }
    return tracers;
}

struct Measured {
    std::array<std::vector<double>, kVariantCount> times;
    std::array<double, kVariantCount> range_ms{}, lookups{}, long_lookups{}; // means over the rays; over the long ones
    double long_share = 0.0;                                                 // of the rays
    bool agree = true;                                                       // both tracers, bit for bit
};

// Rays of which the linear tracer tests steps across half the frame. Lookups of pixels without a ray count nothing.
void count_lookups(const Picture& picture, const dgb_params& params, Measured* m) {
    const Tracers counting = make_tracers(picture, true);
    std::array<std::vector<float>, kVariantCount> hits;
    for (size_t id = 0; id < kVariantCount; ++id) {
        counting[id]->run(params);
        hits[id] = counting[id]->hit();
    }
    double rays = 0.0, long_rays = 0.0;
    for (size_t i = 1; i < hits[0].size(); i += 2) {
        const float steps = hits[kLinearTwo][i];
        const bool is_long = steps * float(params.reflect_stride) >= 0.5f * float(kWidth);
        rays += steps > 0.0f ? 1.0 : 0.0;
        long_rays += is_long ? 1.0 : 0.0;
        for (size_t id = 0; id < kVariantCount; ++id) {
            m->lookups[id] += double(hits[id][i]);
            m->long_lookups[id] += is_long ? double(hits[id][i]) : 0.0;
        }
    }
    for (size_t id = 0; id < kVariantCount; ++id) { m->lookups[id] /= rays, m->long_lookups[id] /= long_rays; }
    m->long_share = long_rays / rays;
}

Measured measure(const Picture& picture, const dgb_params& params, int frames) {
    const Tracers tracers = make_tracers(picture, false);
    Measured m;
    std::vector<size_t> turns(tracers.size());
    std::iota(turns.begin(), turns.end(), size_t{0});
    std::mt19937 random(1); // the same each time
    for (int frame = 0; frame < kWarmUp + frames; ++frame) {
        if (frame == kWarmUp) {
            for (const auto& tracer : tracers) { tracer->forget(); }
        }
        std::shuffle(turns.begin(), turns.end(), random);
        for (const size_t turn : turns) { tracers[turn]->run(params); }
    }
    for (size_t id = 0; id < kVariantCount; ++id) {
        m.times[id] = tracers[id]->times();
        m.range_ms[id] = tracers[id]->range_ms();
    }
    for (size_t id : {kLinearOne, kLinearTwo}) {
        const Tracer &linear = *tracers[id], &hierarchical = *tracers[id + kHierarchicalOne];
        m.agree = m.agree && linear.reflection() == hierarchical.reflection() && linear.hit() == hierarchical.hit();
    }
    count_lookups(picture, params, &m);
    return m;
}

void print(const dgb_params& params, const Measured& m) {
    std::printf("  %d pixels a step, at most %d; %.0f %% of the rays are marched across half the frame\n",
                params.reflect_stride, params.reflect_steps, 100.0 * m.long_share);
    std::printf("    %-26s %10s %10s %12s %14s\n", "", "ms", "of ranges", "lookups/ray", "of long rays");
    for (size_t id = 0; id < kVariantCount; ++id) {
        std::printf("    %-26s %10.2f %10.2f %12.1f %14.1f\n", kVariants[id].name, median(m.times[id]), m.range_ms[id],
                    m.lookups[id], m.long_lookups[id]);
    }
    std::printf(
        "    linear / hierarchical, one layer, two: time %.2f, %.2f (goal for long rays of 1-pixel steps: 2 or more), "
        "lookups of long rays %.1f, %.1f (goal 3 or more)\n",
        median_ratio(m.times[kLinearOne], m.times[kHierarchicalOne]),
        median_ratio(m.times[kLinearTwo], m.times[kHierarchicalTwo]),
        m.long_lookups[kLinearOne] / m.long_lookups[kHierarchicalOne],
        m.long_lookups[kLinearTwo] / m.long_lookups[kHierarchicalTwo]);
    std::printf("    two layers / one: linear %.2f, hierarchical %.2f (goal 1.45 or less)\n",
                median_ratio(m.times[kLinearTwo], m.times[kLinearOne]),
                median_ratio(m.times[kHierarchicalTwo], m.times[kHierarchicalOne]));
    std::printf("    the two tracers %s\n", m.agree ? "agree bit for bit" : "DIFFER");
}

// Along the floor of the court, so that what is mirrored lies far off in the image.
const char* const kAlongTheFloor = "@-15,1.7,0,0,1,0,70";

void run(const std::string& argument, bool quick) {
    const View view = load_view(argument.empty() ? kAlongTheFloor : argument);
    const GpuScene scene(view.scene);
    SceneLights lights(view.scene, scene, {sun_light(view.to_sun, 4.0f)});
    lights.update(*scene.first_pose());
    dgb_params params = dgb_preset(DGB_PRESET_BALANCED);
    RendererDesc desc;
    desc.get_proc = headless_get_proc;
    desc.layers.width = kWidth;
    desc.layers.height = kHeight;
    desc.layers.layers = EngineLayers::kLayers;
    desc.scene = &scene;
    desc.lights = &lights;
    PassTimes unused(false);
    desc.times = &unused;
    SceneRenderer renderer(desc);
    const glm::mat4 projection = projection_matrix(view.camera, kAspect, ClipRange::standard);
    renderer.render(view_matrix(view.camera), projection, params);
    const EngineLayers layers(renderer);
    const Picture picture{view_matrix(view.camera), projection, &layers};
    std::printf("\n%s, %dx%d, mirrors everywhere\n", view.name.c_str(), kWidth, kHeight);
    for (const int stride : kStrides) {
        params.reflect_stride = stride;
        params.reflect_steps = 1024 / stride;
        params.reflect_distance = 100.0f;
        print(params, measure(picture, params, quick ? 4 : 16));
        std::fflush(stdout);
    }
}

void run(const Options& options) {
    std::printf("by %s time\n", is_software_rasteriser() ? "process" : "wall");
    if (options.scenes.empty()) { run(std::string(), options.quick); }
    for (const std::string& scene : options.scenes) { run(scene, options.quick); }
}

} // namespace

int main(int argc, char** argv) { return run_benchmark("reflections", argc, argv, run); }
