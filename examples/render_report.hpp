// What render says about its work: the plan as text, a run as JSON.
#pragma once

#include "scene_renderer.hpp"

#include "deepgbuffer.h"

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

struct RunReport {
    std::string gl_renderer;
    dgb_desc desc{};
    dgb_plan plan{};
    DrawCounts build; // of the last frame's layers
    std::optional<uint64_t> vertices_shaded;
    std::vector<PassTime> passes;
    std::vector<PunctualLight> lights; // where the last frame has them
    int map_size = 0, map_count = 0;   // of their shadow maps; texels along one side
    std::string probe_kind;
    Probe probe{};
    int bounces = 0; // that the last frame shows
    dgb_params params{};
    std::optional<double> mean_confidence; // none without bounced light
    uint64_t hash = 0;                     // of the final picture's 8-bit pixels
};

namespace render_report {

inline std::string print(const char* format, ...) __attribute__((format(printf, 1, 2)));

// One line at most.
inline std::string print(const char* format, ...) {
    char line[512];
    va_list arguments;
    va_start(arguments, format);
    std::vsnprintf(line, sizeof line, format, arguments);
    va_end(arguments);
    return line;
}

inline std::string quoted(const std::string& text) {
    std::string json = "\"";
    for (char c : text) {
        const bool control = static_cast<unsigned char>(c) < 0x20;
        if (c == '"' || c == '\\') { json += '\\'; }
        json += control ? print("\\u%04x", unsigned(c)) : std::string(1, c);
    }
    return json + "\"";
}

// Neither needs sorted nor non-empty times.
inline std::string statistics(std::vector<double> times) {
    if (times.empty()) { return "null"; }
    std::sort(times.begin(), times.end());
    const size_t n = times.size();
    const double median = 0.5 * (times[(n - 1) / 2] + times[n / 2]);
    return print(R"({"median": %.6f, "min": %.6f, "max": %.6f})", median, times.front(), times.back());
}

template <typename Items, typename ToJson>
std::string array(const Items& items, ToJson to_json) {
    std::string json = "[";
    const char* separator = "\n    ";
    for (const auto& item : items) {
        json += separator + to_json(item);
        separator = ",\n    ";
    }
    return json + "\n  ]";
}

inline std::vector<dgb_texture_desc> textures_of(const dgb_plan& plan) {
    return {plan.textures, plan.textures + plan.texture_count};
}

inline std::string pass_to_json(const PassTime& pass) {
    return "{\"name\": " + quoted(pass.name) + ", \"cpu_ms\": " + statistics(pass.cpu_ms) +
           ", \"gpu_ms\": " + statistics(pass.gpu_ms) + "}";
}

inline std::string texture_to_json(const dgb_texture_desc& texture) {
    return "{\"name\": " + quoted(dgb_slot_name(texture.slot)) +
           print(", \"bytes\": %llu}", static_cast<unsigned long long>(texture.bytes));
}

inline std::string build_to_json(const RunReport& report) {
    const std::string vertices = report.vertices_shaded ? std::to_string(*report.vertices_shaded) : "null";
    return print(R"({"triangles": %lld, "draw_calls": %lld, "vertices_shaded": %s})",
                 static_cast<long long>(report.build.triangles), static_cast<long long>(report.build.draw_calls),
                 vertices.c_str());
}

inline std::string vector_to_json(glm::vec3 v) {
    return print("[%.9g, %.9g, %.9g]", double(v.x), double(v.y), double(v.z));
}

// Only what its kind has. A direction is the one in which light travels.
inline std::string light_to_json(const PunctualLight& light) {
    static const char* const kinds[] = {"directional", "point", "spot"};
    const bool directional = light.kind == LightKind::directional, spot = light.kind == LightKind::spot;
    std::string json = print(R"({"kind": "%s", "intensity": )", kinds[int(light.kind)]);
    json += vector_to_json(light.intensity);
    if (!directional) { json += R"(, "position": )" + vector_to_json(glm::vec3(light.world[3])); }
    if (directional || spot) { json += R"(, "direction": )" + vector_to_json(-direction_to(light)); }
    if (light.range > 0.0f && !directional) { json += print(R"(, "range": %.9g)", double(light.range)); }
    if (spot) { json += print(R"(, "cone": [%.9g, %.9g])", double(light.inner_cone), double(light.outer_cone)); }
    return json + "}";
}

} // namespace render_report

inline std::string report_to_json(const RunReport& report) {
    using namespace render_report;
    const dgb_plan& plan = report.plan;
    std::string json = "{\n";
    json += "  \"renderer\": " + quoted(report.gl_renderer) + ",\n";
    json += print("  \"width\": %d,\n  \"height\": %d,\n", report.desc.width, report.desc.height);
    json += print("  \"guard\": %d,\n  \"layers\": %d,\n", report.desc.guard_band, plan.layers);
    json += "  \"oracle\": " + quoted(dgb_oracle_name(plan.oracle)) + ",\n";
    json += "  \"emission\": " + quoted(dgb_emission_name(plan.emission)) + ",\n";
    json += "  \"lights\": " + array(report.lights, light_to_json) + ",\n";
    json += print("  \"shadow_maps\": {\"count\": %d, \"size\": %d},\n", report.map_count, report.map_size);
    json += "  \"probe\": " + quoted(report.probe_kind) + ",\n";
    json += "  \"probe_harmonics\": " + array(report.probe, vector_to_json) + ",\n";
    json += print("  \"bounces\": %d,\n", report.bounces);
    json += print("  \"alpha\": %.9g,\n", double(report.params.history_weight));
    json += print("  \"delta\": %.9g,\n", double(report.params.bounce_damping));
    json +=
        "  \"mean_confidence\": " + (report.mean_confidence ? print("%.6f", *report.mean_confidence) : "null") + ",\n";
    json += "  \"build\": " + build_to_json(report) + ",\n";
    json += "  \"passes\": " + array(report.passes, pass_to_json) + ",\n";
    json += "  \"textures\": " + array(textures_of(plan), texture_to_json) + ",\n";
    json += print("  \"bytes_total\": %llu,\n", static_cast<unsigned long long>(plan.bytes));
    json += print("  \"hash\": \"%016llx\"\n}\n", static_cast<unsigned long long>(report.hash));
    return json;
}

inline std::string plan_to_text(const dgb_plan& plan) {
    using namespace render_report;
    std::string text =
        print("%d x %d pixels with guard band, %d layers, oracle %s, emission %s\n\npasses\n", plan.width, plan.height,
              plan.layers, dgb_oracle_name(plan.oracle), dgb_emission_name(plan.emission));
    for (int i = 0; i < plan.pass_count; ++i) {
        const dgb_plan_pass& pass = plan.passes[i];
        text += print("    %-12s", dgb_pass_name(pass.id));
        for (int k = 0; k < pass.input_count; ++k) { text += print(" %s", dgb_slot_name(pass.inputs[k].texture)); }
        text += " ->";
        if (pass.id == DGB_PASS_LAYERS) { text += print(" %s", dgb_slot_name(DGB_DEPTH)); }
        for (int k = 0; k < pass.output_count; ++k) { text += print(" %s", dgb_slot_name(pass.outputs[k])); }
        text += "\n";
    }
    text += "\ntextures\n";
    for (const dgb_texture_desc& t : textures_of(plan)) {
        text += print("    %-16s %-10s %5d x %-5d %d layers %d levels %12llu bytes\n", dgb_slot_name(t.slot),
                      dgb_format_name(t.format), t.width, t.height, std::max(t.layers, 1), t.levels,
                      static_cast<unsigned long long>(t.bytes));
    }
    return text + print("\ntotal %llu bytes\n", static_cast<unsigned long long>(plan.bytes));
}
