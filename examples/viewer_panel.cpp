#include "viewer_panel.hpp"

#include <imgui.h>

#include <algorithm>
#include <cfloat>
#include <cstdio>
#include <cstring>

// ---- Times ----------------------------------------------------------------------------------------------

namespace {

constexpr size_t kFramesShown = 120;
constexpr double kFrameWeight = 0.1; // of a new frame in a pass's average

double sum(const std::vector<double>& values) {
    double total = 0.0;
    for (const double value : values) { total += value; }
    return total;
}

} // namespace

PassHistory::Pass& PassHistory::pass(const std::string& name) {
    const auto found = std::find_if(passes_.begin(), passes_.end(), [&](const Pass& p) { return p.name == name; });
    return found != passes_.end() ? *found : passes_.emplace_back(Pass{name, -1.0, false});
}

bool PassHistory::has_gpu() const {
    return std::any_of(passes_.begin(), passes_.end(), [](const Pass& p) { return p.gpu; });
}

void PassHistory::add(const PassTimes& times) {
    double total = 0.0;
    for (Pass& known : passes_) { known.milliseconds *= 1.0 - kFrameWeight; } // what does not run again fades
    for (const PassTime& time : times.passes()) {
        const double now = sum(time.gpu_ms.empty() ? time.cpu_ms : time.gpu_ms);
        Pass& known = pass(time.name);
        known.gpu = !time.gpu_ms.empty();
        known.milliseconds = known.milliseconds < 0.0 ? now : known.milliseconds + kFrameWeight * now;
        total += now;
    }
    if (frames_.size() == kFramesShown) { frames_.erase(frames_.begin()); }
    frames_.push_back(float(total));
}

// ---- What there is to choose ----------------------------------------------------------------------------

const std::array<Demo, 3> kDemos = {{
    {"halos",
     "gallery --camera=0.5,1.6,1,-4,1.5,-4,60 --effects ao --view ao --preset quality --ao-samples 40 --ao-radius 2.5",
     "Ambient visibility. One layer does not know the wall and the floor behind the sphere and the columns: what "
     "stands beside them turns bright, in a halo that follows the sphere. Tab compares."},
    {"hidden light", "atrium --view irradiance --preset quality --sky 0.02,0.02,0.02 --exposure 0.5",
     "Bounced light. The drape on the left hides a sunlit green one, whose light is missing on balustrade and floor "
     "with one layer. Tab compares."},
    {"mirrors", "gallery --camera=0,1.7,3.2,1.9,1.65,-6,75 --effects ao,gi,glossy --preset quality --split 0.79",
     "The mirrors on the right show the pictures behind the columns. One layer does not have them: the sky shows "
     "instead. Tab compares."},
}};

namespace {

struct FloatParam {
    const char* label;
    float dgb_params::*member;
    float low, high; // of the slider; a number typed in may be any, and the library judges it
    const char* help;
};

struct IntParam {
    const char* label;
    int dgb_params::*member;
    int low, high;
    const char* help;
};

struct BoolParam {
    const char* label;
    bool dgb_params::*member;
    const char* help;
};

struct ParamGroup {
    const char* title;
    std::vector<FloatParam> floats;
    std::vector<IntParam> ints;
    std::vector<BoolParam> bools;
};

using P = dgb_params;

const std::vector<ParamGroup>& param_groups() {
    static const std::vector<ParamGroup> groups = {
        {"Layers",
         {{"separation", &P::separation, 0.0f, 4.0f, "least distance between layers, m"},
          {"guard fraction", &P::guard_fraction, 0.0f, 1.0f, "share of the guard band that is shaded"}},
         {},
         {{"strict separation", &P::strict_separation, "empty what lies nearer to the first layer"},
          {"second layer alone", &P::second_alone, "only its surfaces occlude and send light"},
          {"adaptive", &P::adaptive, "skip the second layer where it cannot matter"}}},
        {"Ambient occlusion",
         {{"ao radius", &P::ao_radius, 0.01f, 8.0f, "m"},
          {"ao bias", &P::ao_bias, 0.0f, 0.2f, "of the radius"},
          {"ao epsilon", &P::ao_epsilon, 0.0f, 0.1f, "of the radius squared"},
          {"ao intensity", &P::ao_intensity, 0.0f, 4.0f, "exponent of the visibility"}},
         {{"ao samples", &P::ao_samples, 1, 64, "taps a pixel"},
          {"ao min level", &P::ao_min_level, 0, 5, "coarsest detail near by: MIP level"}},
         {}},
        {"Bounced light",
         {{"radius", &P::radius, 0.1f, 32.0f, "reach of bounced light, m"},
          {"bounce damping", &P::bounce_damping, 0.0f, 1.0f, "share of last frame's light that is sent on"},
          {"boost, grey", &P::boost_unsaturated, 0.0f, 4.0f, "factor of light from grey surfaces"},
          {"boost, colour", &P::boost_saturated, 0.0f, 4.0f, "factor of light from saturated surfaces"}},
         {{"samples", &P::samples, 1, 64, "taps a pixel"},
          {"min level", &P::min_level, 0, 5, "coarsest detail near by: MIP level"}},
         {{"normal test", &P::normal_test, "senders must face the receiver"}}},
        {"Visibility bitmask",
         {{"thickness", &P::thickness, 0.01f, 4.0f, "how far behind a surface its object hides, m"}},
         {{"slices", &P::slices, 1, DGB_MAX_SLICES, "planes that share the taps"}},
         {}},
        {"History",
         {{"history weight", &P::history_weight, 0.0f, 0.999f, "0: no history"},
          {"history tolerance", &P::history_tolerance, 0.0f, 0.1f, "share of the distance"},
          {"history floor", &P::history_floor, 0.0f, 0.1f, "m"},
          {"history clamp", &P::history_clamp, 0.0f, 4.0f, "deviations of neighbours, where surfaces move; 0: off"},
          {"sample clamp", &P::sample_clamp, 0.0f, 16.0f, "times the neighbours' mean; 0: off"}},
         {},
         {}},
        {"Reconstruction filter",
         {{"normal sharpness", &P::normal_sharpness, 0.0f, 16.0f, "0 ignores normals"},
          {"plane sharpness", &P::plane_sharpness, 0.0f, 16.0f, "0 ignores depth"}},
         {{"filter taps", &P::filter_taps, 1, 25, "in each direction, odd"},
          {"filter step", &P::filter_step, 1, 8, "pixels from tap to tap"}},
         {}},
        {"Reflections",
         {{"reflect distance", &P::reflect_distance, 0.1f, 100.0f, "longest ray, m"},
          {"reflect thickness", &P::reflect_thickness, 0.01f, 4.0f,
           "how far behind its surface an object stops a ray, m"},
          {"reflect border", &P::reflect_border, 0.0f, 64.0f, "pixels in which confidence fades"},
          {"glossy radius", &P::glossy_radius, 0.0f, 64.0f, "pixels"}},
         {{"reflect steps", &P::reflect_steps, 1, 1024, "most steps of a ray"},
          {"reflect stride", &P::reflect_stride, 1, 16, "pixels a step"},
          {"glossy taps", &P::glossy_taps, 0, 32, "neighbours whose rays count"}},
         {}},
    };
    return groups;
}

struct Effect {
    const char* label;
    uint32_t bit;
};
const Effect kEffects[] = {{"occlusion", DGB_EFFECT_AO},         {"bounced light", DGB_EFFECT_RADIOSITY},
                           {"many bounces", DGB_EFFECT_BOUNCES}, {"temporal", DGB_EFFECT_TEMPORAL},
                           {"mirrors", DGB_EFFECT_REFLECT},      {"glossy", DGB_EFFECT_GLOSSY}};

void explain(const char* help) {
    if (ImGui::IsItemHovered()) { ImGui::SetTooltip("%s", help); }
}

// A drop-down list of the names of 0 to count - 1. Returns whether another one was chosen.
template <typename T, typename Name>
bool choose(const char* label, T* value, int count, Name name) {
    bool changed = false;
    if (!ImGui::BeginCombo(label, name(int(*value)))) { return false; }
    for (int i = 0; i < count; ++i) {
        if (ImGui::Selectable(name(i), i == int(*value)) && i != int(*value)) {
            *value = T(i);
            changed = true;
        }
    }
    ImGui::EndCombo();
    return changed;
}

// ---- One side -------------------------------------------------------------------------------------------

// A side, and the one that follows it, if any.
struct Edited {
    Config* config;
    Config* follower; // null: none

    template <typename Part, typename Value>
    void follow(Part Config::*part, Value Part::*member) const {
        if (follower != nullptr) { follower->*part.*member = config->*part.*member; }
    }
    template <typename Value>
    void follow(Value dgb_params::*member) const {
        follow(&Config::params, member);
    }
    template <typename Value>
    bool follow(Value dgb_desc::*member) const {
        follow(&Config::layers, member);
        return true;
    }
};

bool edit_layers(const Edited& side) {
    dgb_desc& d = side.config->layers;
    bool changed = ImGui::SliderInt("layers", &d.layers, 1, DGB_MAX_LAYERS);
    explain("that are built; the shading reads the first two");
    const auto oracle = [](int i) { return i == 0 ? "default" : dgb_oracle_name(dgb_oracle(i)); };
    if (choose("oracle", &d.oracle, DGB_ORACLE_COUNT, oracle)) { changed = side.follow(&dgb_desc::oracle); }
    const auto emission = [](int i) { return i == 0 ? "auto" : dgb_emission_name(dgb_emission(i)); };
    if (choose("emission", &d.emission, DGB_EMISSION_COUNT, emission)) { changed = side.follow(&dgb_desc::emission); }
    int halvings = d.divisor >= 4 ? 2 : d.divisor - 1;
    const auto resolution = [](int i) { return i == 0 ? "1" : i == 1 ? "1/2" : "1/4"; };
    if (choose("deep resolution", &halvings, 3, resolution)) {
        d.divisor = 1 << halvings;
        changed = side.follow(&dgb_desc::divisor);
    }
    ImGui::SliderInt("guard band", &d.guard_band, 0, 256, "%d pixels");
    if (ImGui::IsItemDeactivatedAfterEdit()) { changed = side.follow(&dgb_desc::guard_band); }
    return changed;
}

bool edit_effects(const Edited& side) {
    dgb_desc& d = side.config->layers;
    bool changed = false;
    for (const Effect& effect : kEffects) {
        if (ImGui::CheckboxFlags(effect.label, &d.effects, effect.bit)) { changed = side.follow(&dgb_desc::effects); }
        if (&effect - kEffects != 2 && &effect - kEffects != 5) { ImGui::SameLine(); }
    }
    return changed;
}

bool edit_methods(const Edited& side) {
    dgb_desc& d = side.config->layers;
    bool changed = false;
    const auto tracer = [](int i) { return i == DGB_TRACER_LINEAR ? "linear" : "hierarchical"; };
    if (choose("tracer", &d.tracer, DGB_TRACER_COUNT, tracer)) { changed = side.follow(&dgb_desc::tracer); }
    const auto estimator = [](int i) { return i == DGB_ESTIMATOR_PAPER ? "paper" : "bitmask"; };
    if (choose("estimator", &d.estimator, DGB_ESTIMATOR_COUNT, estimator)) {
        changed = side.follow(&dgb_desc::estimator);
    }
    const auto thickness = [](int i) {
        return i == DGB_THICKNESS_LAYERS ? "layers" : i == DGB_THICKNESS_CONSTANT ? "constant" : "back faces";
    };
    if (choose("thickness from", &d.thickness, DGB_THICKNESS_COUNT, thickness)) {
        changed = side.follow(&dgb_desc::thickness);
    }
    const auto senders = [](int i) { return i == DGB_SENDERS_BOTH ? "both" : "strongest"; };
    if (choose("senders", &d.senders, DGB_SENDERS_COUNT, senders)) { changed = side.follow(&dgb_desc::senders); }
    const auto normaliser = [](int i) { return i == DGB_NORMALISER_BOUNDED ? "bounded" : "paper"; };
    if (choose("normaliser", &d.normaliser, DGB_NORMALISER_COUNT, normaliser)) {
        changed = side.follow(&dgb_desc::normaliser);
    }
    return changed;
}

void edit_view(const Edited& side) {
    ViewChoice& choice = side.config->view;
    if (choose("view", &choice.view, int(View::count), [](int i) { return view_name(View(i)); })) {
        choice.layer = choice.view == View::validity ? 1 : choice.layer;
        if (side.follower != nullptr) { side.follower->view = choice; }
    }
    explain(view_help(choice.view));
    if (is_of_layer(choice.view) && ImGui::SliderInt("of layer", &choice.layer, 0, DGB_MAX_LAYERS - 1)) {
        if (side.follower != nullptr) { side.follower->view = choice; }
    }
}

void edit_presets(const Edited& side) {
    const char* const names[] = {"performance", "balanced", "quality"};
    ImGui::TextUnformatted("preset:");
    for (int i = 0; i < DGB_PRESET_COUNT; ++i) {
        ImGui::SameLine();
        if (!ImGui::SmallButton(names[i])) { continue; }
        set_preset(dgb_preset_id(i), &side.config->params);
        if (side.follower != nullptr) { set_preset(dgb_preset_id(i), &side.follower->params); }
    }
}

void edit_group(const ParamGroup& group, const Edited& side) {
    dgb_params& params = side.config->params;
    if (!ImGui::TreeNode(group.title)) { return; }
    for (const FloatParam& p : group.floats) {
        if (ImGui::SliderFloat(p.label, &(params.*p.member), p.low, p.high, "%.3f")) { side.follow(p.member); }
        explain(p.help);
    }
    for (const IntParam& p : group.ints) {
        if (ImGui::SliderInt(p.label, &(params.*p.member), p.low, p.high)) { side.follow(p.member); }
        explain(p.help);
    }
    for (const BoolParam& p : group.bools) {
        if (ImGui::Checkbox(p.label, &(params.*p.member))) { side.follow(p.member); }
        explain(p.help);
    }
    ImGui::TreePop();
}

bool edit_side(const Edited& side) {
    edit_view(side);
    bool changed = edit_layers(side);
    changed = edit_effects(side) || changed;
    edit_presets(side);
    for (const ParamGroup& group : param_groups()) { edit_group(group, side); }
    if (ImGui::TreeNode("Methods")) {
        changed = edit_methods(side) || changed;
        ImGui::TreePop();
    }
    return changed;
}

bool edit_sides(Panel* panel) {
    bool changed = false;
    ImGui::SliderFloat("split", &panel->split, 0.0f, 1.0f, "%.2f");
    explain("or drag the line between the halves; 0 shows the right one alone, 1 the left one");
    ImGui::Checkbox("change both sides", &panel->linked);
    explain("but for the number of layers");
    if (!ImGui::BeginTabBar("sides")) { return false; }
    for (size_t i = 0; i < 2; ++i) {
        if (!ImGui::BeginTabItem(i == 0 ? "left" : "right")) { continue; }
        const Edited side = {&panel->sides[i].config, panel->linked ? &panel->sides[1 - i].config : nullptr};
        changed = edit_side(side) || changed;
        ImGui::EndTabItem();
    }
    ImGui::EndTabBar();
    return changed;
}

// ---- What it costs --------------------------------------------------------------------------------------

void show_milliseconds(const PassHistory& history, const std::string& name) {
    ImGui::TableNextColumn();
    for (const PassHistory::Pass& pass : history.passes()) {
        if (pass.name == name) { ImGui::Text("%8.2f", pass.milliseconds); }
    }
}

std::vector<std::string> pass_names(const Panel& panel) {
    std::vector<std::string> names;
    for (const PanelSide& side : panel.sides) {
        for (const PassHistory::Pass& pass : side.history.passes()) {
            if (std::find(names.begin(), names.end(), pass.name) == names.end()) { names.push_back(pass.name); }
        }
    }
    return names;
}

void plot_frames(const char* label, const std::vector<float>& frames) {
    if (frames.empty()) { return; }
    char now[40];
    std::snprintf(now, sizeof now, "%.1f ms", double(frames.back()));
    ImGui::PlotLines(label, frames.data(), int(frames.size()), 0, now, 0.0f, FLT_MAX,
                     ImVec2(0.0f, 2.5f * ImGui::GetTextLineHeight()));
}

void show_times(Panel* panel) {
    const bool gpu = panel->sides[0].history.has_gpu() || panel->sides[1].history.has_gpu();
    plot_frames("left", panel->sides[0].history.frames());
    plot_frames("right", panel->sides[1].history.frames());
    ImGui::TextWrapped("%s", gpu ? "by the GPU's clock; shadow, light and composite, which are not of the library, by "
                                   "the CPU's"
                             : panel->wait ? "by the CPU's clock, until the GPU is done"
                                           : "by the CPU's clock, as it submits: the GPU has no clock here");
    ImGui::Checkbox("wait for the GPU after each pass", &panel->wait);
    if (!ImGui::BeginTable("times", 3, ImGuiTableFlags_RowBg)) { return; }
    ImGui::TableSetupColumn("ms");
    ImGui::TableSetupColumn("left");
    ImGui::TableSetupColumn("right");
    ImGui::TableHeadersRow();
    for (const std::string& name : pass_names(*panel)) {
        ImGui::TableNextRow();
        ImGui::TableNextColumn();
        ImGui::TextUnformatted(name.c_str());
        show_milliseconds(panel->sides[0].history, name);
        show_milliseconds(panel->sides[1].history, name);
    }
    ImGui::EndTable();
}

uint64_t bytes_of(const dgb_plan* plan, dgb_slot slot) {
    if (plan == nullptr) { return 0; }
    for (int i = 0; i < plan->texture_count; ++i) {
        if (plan->textures[i].slot == slot) { return plan->textures[i].bytes; }
    }
    return 0;
}

void show_bytes(uint64_t bytes) {
    ImGui::TableNextColumn();
    if (bytes > 0) { ImGui::Text("%9.2f", double(bytes) / (1 << 20)); }
}

void show_row(const char* name, uint64_t left, uint64_t right) {
    if (left == 0 && right == 0) { return; }
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    ImGui::TextUnformatted(name);
    show_bytes(left);
    show_bytes(right);
}

void show_memory(const Panel& panel) {
    const dgb_plan *left = panel.sides[0].plan, *right = panel.sides[1].plan;
    if (!ImGui::BeginTable("bytes", 3, ImGuiTableFlags_RowBg)) { return; }
    ImGui::TableSetupColumn("MiB");
    ImGui::TableSetupColumn("left");
    ImGui::TableSetupColumn("right");
    ImGui::TableHeadersRow();
    show_row("all textures", left != nullptr ? left->bytes : 0, right != nullptr ? right->bytes : 0);
    for (int i = 1; i < DGB_SLOT_COUNT; ++i) {
        const auto slot = dgb_slot(i);
        show_row(dgb_slot_name(slot), bytes_of(left, slot), bytes_of(right, slot));
    }
    ImGui::EndTable();
}

// ---- The rest -------------------------------------------------------------------------------------------

void choose_demo(Panel* panel, PanelRequests* requests) {
    ImGui::TextUnformatted("what the second layer cures:");
    for (const Demo& demo : kDemos) {
        if (ImGui::Button(demo.name)) {
            requests->demo = &demo;
            panel->message = demo.look_for;
        }
        explain(demo.words);
        ImGui::SameLine();
    }
    ImGui::NewLine();
}

PanelRequests edit_light(Panel* panel) {
    PanelRequests requests;
    Sun& sun = panel->sun;
    requests.light_changed = ImGui::Checkbox("sun", &sun.on);
    ImGui::SliderFloat("azimuth", &sun.azimuth, -180.0f, 180.0f, "%.0f degrees");
    requests.light_changed |= ImGui::IsItemDeactivatedAfterEdit();
    ImGui::SliderFloat("elevation", &sun.elevation, -90.0f, 90.0f, "%.0f degrees");
    requests.light_changed |= ImGui::IsItemDeactivatedAfterEdit();
    ImGui::SliderFloat("strength", &sun.strength, 0.0f, 50.0f, "%.1f W/m2");
    requests.light_changed |= ImGui::IsItemDeactivatedAfterEdit();
    requests.sky_changed = ImGui::ColorEdit3("sky", &panel->sky.x, ImGuiColorEditFlags_Float | ImGuiColorEditFlags_HDR);
    ImGui::SliderFloat("exposure", &panel->exposure, -8.0f, 8.0f, "%.1f stops");
    return requests;
}

void edit_motion(Panel* panel) {
    ImGui::SliderFloat("speed", &panel->speed, 0.01f, 50.0f, "%.2f m/s", ImGuiSliderFlags_Logarithmic);
    if (panel->has_animation) { ImGui::Checkbox("play the animation (space)", &panel->playing); }
    if (panel->recording) { ImGui::TextUnformatted("recording the camera's path"); }
    if (panel->replaying) { ImGui::TextUnformatted("replaying the camera's path"); }
}

void show_keys() {
    ImGui::TextUnformatted("right drag, WASD, Q, E   fly\n"
                           "left drag                turn around the middle\n"
                           "wheel                    speed\n"
                           "Home                     back to the start\n"
                           "Tab                      left alone, right alone, both\n"
                           "space                    hold the animation\n"
                           "F1, F2                   panel, labels\n"
                           "F5                       read the file again\n"
                           "F9, F10                  record, replay the path\n"
                           "F12                      screenshot\n"
                           "drop a .gltf or .glb here to see it");
}

} // namespace

// ---- Whole ----------------------------------------------------------------------------------------------

void set_preset(dgb_preset_id preset, dgb_params* params) {
    const dgb_params old = *params;
    *params = dgb_preset(preset);
    params->separation = old.separation;
    params->ao_radius = old.ao_radius;
    params->radius = old.radius;
    params->thickness = old.thickness;
    params->reflect_distance = old.reflect_distance;
    params->reflect_thickness = old.reflect_thickness;
    params->history_floor = old.history_floor;
}

std::string label_of(const PanelSide& side) {
    const Config& config = side.config;
    if (side.plan == nullptr) { return "nothing to show"; }
    const dgb_plan& plan = *side.plan;
    std::string label = plan.layers == 1   ? "one layer"
                        : plan.layers == 2 ? "two layers"
                                           : std::to_string(plan.layers) + " layers";
    if (plan.layers > 1) {
        label += std::string(", ") + dgb_oracle_name(plan.oracle);
        if (config.layers.divisor > 1) { label += ", 1/" + std::to_string(config.layers.divisor) + " resolution"; }
    }
    if (config.view.view == View::final) { return label; }
    label += std::string(": ") + view_name(config.view.view);
    if (is_of_layer(config.view.view)) { label += " of layer " + std::to_string(config.view.layer); }
    return side.shows_view ? label : label + " (not there)";
}

namespace {

// Up to the column `end`.
void draw_label(const std::string& text, float x, float y, float end) {
    const ImVec2 size = ImGui::CalcTextSize(text.c_str());
    const float border = 0.4f * ImGui::GetTextLineHeight();
    ImDrawList* list = ImGui::GetBackgroundDrawList();
    list->PushClipRect(ImVec2(0.0f, 0.0f), ImVec2(end, FLT_MAX), true);
    list->AddRectFilled(ImVec2(x - border, y - border), ImVec2(x + size.x + border, y + size.y + border),
                        IM_COL32(0, 0, 0, 160), border);
    list->AddText(ImVec2(x, y), IM_COL32_WHITE, text.c_str());
    list->PopClipRect();
}

void draw_error(const char* side, const std::string& sentence) {
    if (!sentence.empty()) { ImGui::TextWrapped("%s: %s", side, sentence.c_str()); }
}

} // namespace

void draw_labels(const Panel& panel, float width, float height) {
    const float line = ImGui::GetTextLineHeight(), split = panel.shown_split(), x = split * width;
    if (split > 0.0f) { draw_label(label_of(panel.sides[0]), line, line, x); }
    if (split < 1.0f) { draw_label(label_of(panel.sides[1]), x + line, line, width); }
    if (split == 0.0f || split == 1.0f) { return; }
    ImDrawList* list = ImGui::GetBackgroundDrawList();
    list->AddLine(ImVec2(x, 0.0f), ImVec2(x, height), IM_COL32(0, 0, 0, 160), 3.0f);
    list->AddLine(ImVec2(x, 0.0f), ImVec2(x, height), IM_COL32_WHITE, 1.0f);
    list->AddCircleFilled(ImVec2(x, 0.5f * height), 0.5f * line, IM_COL32_WHITE);
}

void draw_errors(const Panel& panel, float width, float height) {
    const std::string left = panel.sides[0].desc_error + panel.sides[0].frame_error;
    const std::string right = panel.sides[1].desc_error + panel.sides[1].frame_error;
    if (left.empty() && right.empty()) { return; }
    ImGui::SetNextWindowPos(ImVec2(0.0f, height), ImGuiCond_Always, ImVec2(0.0f, 1.0f));
    ImGui::SetNextWindowSize(ImVec2(width, 0.0f));
    ImGui::PushStyleColor(ImGuiCol_Text, ImVec4(1.0f, 0.4f, 0.3f, 1.0f));
    ImGui::Begin("errors", nullptr, ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoInputs);
    draw_error("left", left);
    draw_error("right", right);
    ImGui::End();
    ImGui::PopStyleColor();
}

float panel_width(float window_width) {
    const float font = 13.0f * ImGui::GetIO().FontGlobalScale; // ImGui's own
    return std::min(27.0f * font, 0.5f * window_width);
}

PanelRequests draw_panel(Panel* panel, float left, float width, float height) {
    PanelRequests requests;
    ImGui::SetNextWindowPos(ImVec2(left, 0.0f));
    ImGui::SetNextWindowSize(ImVec2(width, height));
    const bool open = ImGui::Begin("deepgbuffer", &panel->visible, ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize);
    if (!open) {
        ImGui::End();
        return requests;
    }
    ImGui::PushItemWidth(-9.0f * ImGui::GetFontSize());
    choose_demo(panel, &requests);
    if (!panel->message.empty()) { ImGui::TextWrapped("%s", panel->message.c_str()); }
    if (ImGui::CollapsingHeader("Keys")) { show_keys(); }
    if (ImGui::CollapsingHeader("Compare", ImGuiTreeNodeFlags_DefaultOpen)) {
        requests.desc_changed = edit_sides(panel);
    }
    if (ImGui::CollapsingHeader("Times", ImGuiTreeNodeFlags_DefaultOpen)) { show_times(panel); }
    if (ImGui::CollapsingHeader("Memory")) { show_memory(*panel); }
    if (ImGui::CollapsingHeader("Light")) {
        const PanelRequests light = edit_light(panel);
        requests.light_changed = light.light_changed;
        requests.sky_changed = light.sky_changed;
    }
    if (ImGui::CollapsingHeader("Camera and animation")) { edit_motion(panel); }
    ImGui::PopItemWidth();
    ImGui::End();
    return requests;
}
