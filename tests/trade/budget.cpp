#include "budget.hpp"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace {

constexpr double kWorthwhile = 0.99; // of the error of what costs less
constexpr const char* kBegin = "/* budget: begin; written by `make budget`, do not edit */\n";
constexpr const char* kEnd = "/* budget: end */\n";

template <typename... Values>
std::string text(const char* format, Values... values) {
    char buffer[256];
    std::snprintf(buffer, sizeof buffer, format, values...);
    return buffer;
}

Effect effect_of(const std::string& name) {
    for (const Effect effect : kEffects) {
        if (name == name_of(effect)) { return effect; }
    }
    throw std::runtime_error("no such effect: " + name);
}

std::string read_file(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) { throw std::runtime_error("cannot read " + path); }
    std::ostringstream stream;
    stream << file.rdbuf();
    return stream.str();
}

// {cost, taps, min level, filter taps, normal test} or, of mirrors, {cost, stride}.
std::string initialiser(const BudgetRow& row) {
    if (row.effect == Effect::mirror) { return text("{%.2ff, %d}", row.cost, row.stride); }
    const std::string first = text("{%.2ff, %d, %d, %d", row.cost, row.taps, row.min_level, row.filter_taps);
    return row.effect == Effect::light ? first + (row.normal_test ? ", true}" : ", false}") : first + ", true}";
}

std::string table_of(const std::vector<BudgetRow>& rows, Effect effect, const char* type, const char* name) {
    std::string table = text("static const %s %s[] = {\n", type, name);
    for (const BudgetRow& row : budget_front(rows, effect)) {
        table += text("    %s, /* error %.3f of BALANCED's */\n", initialiser(row).c_str(), row.error);
    }
    return table + "};\n";
}

} // namespace

BudgetRow budget_row(const Setting& setting, double cost, double error) {
    const dgb_params& q = setting.params;
    BudgetRow row;
    row.effect = setting.effect;
    row.cost = cost;
    row.error = error;
    if (setting.effect == Effect::mirror) {
        row.stride = q.reflect_stride;
        return row;
    }
    const bool light = setting.effect == Effect::light;
    row.taps = light ? q.samples : q.ao_samples;
    row.min_level = light ? q.min_level : q.ao_min_level;
    row.filter_taps = q.filter_taps;
    row.normal_test = q.normal_test;
    return row;
}

void write_budget(const std::string& path, const std::vector<BudgetRow>& rows) {
    std::ofstream file(path);
    file << "effect,taps,min_level,filter_taps,normal_test,stride,cost,error\n";
    for (const BudgetRow& row : rows) {
        file << name_of(row.effect)
             << text(",%d,%d,%d,%d,%d,%.3f,%.4f\n", row.taps, row.min_level, row.filter_taps, int(row.normal_test),
                     row.stride, row.cost, row.error);
    }
    if (!file.flush()) { throw std::runtime_error("cannot write " + path); }
}

std::vector<BudgetRow> read_budget(const std::string& path) {
    std::istringstream file(read_file(path));
    std::vector<BudgetRow> rows;
    std::string line;
    std::getline(file, line); // names
    while (std::getline(file, line)) {
        char effect[16] = "";
        int normal_test = 0;
        BudgetRow row;
        const int count =
            std::sscanf(line.c_str(), "%15[a-z],%d,%d,%d,%d,%d,%lf,%lf", effect, &row.taps, // NOLINT
                        &row.min_level, &row.filter_taps, &normal_test, &row.stride, &row.cost, &row.error);
        if (count != 8) { throw std::runtime_error(path + ": not a row: " + line); }
        row.effect = effect_of(effect);
        row.normal_test = normal_test != 0;
        rows.push_back(row);
    }
    return rows;
}

std::vector<BudgetRow> budget_front(const std::vector<BudgetRow>& rows, Effect effect) {
    std::vector<BudgetRow> sorted, front;
    std::copy_if(rows.begin(), rows.end(), std::back_inserter(sorted),
                 [&](const BudgetRow& r) { return r.effect == effect; });
    std::stable_sort(sorted.begin(), sorted.end(),
                     [](const BudgetRow& a, const BudgetRow& b) { return a.cost < b.cost; });
    for (const BudgetRow& row : sorted) {
        if (front.empty() || row.error < kWorthwhile * front.back().error) { front.push_back(row); }
    }
    return front;
}

bool embed_budget(const std::string& header, const std::vector<BudgetRow>& rows, bool check) {
    const std::string before = read_file(header);
    const size_t begin = before.find(kBegin), end = before.find(kEnd);
    if (begin == std::string::npos || end == std::string::npos || end < begin) {
        throw std::runtime_error(header + ": no markers of the budget");
    }
    const std::string tables = table_of(rows, Effect::occlusion, "dgbi_budget", "dgbi_ao_budget") +
                               table_of(rows, Effect::light, "dgbi_budget", "dgbi_light_budget") +
                               table_of(rows, Effect::mirror, "dgbi_mirror_budget", "dgbi_reflect_budget");
    const std::string after = before.substr(0, begin) + kBegin + tables + before.substr(end);
    if (!check && after != before) {
        std::ofstream file(header, std::ios::binary);
        file << after;
        if (!file.flush()) { throw std::runtime_error("cannot write " + header); }
    }
    return after == before;
}
