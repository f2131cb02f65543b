// The table behind dgb_preset_for: from measured settings, the ones that nothing cheaper beats.
#pragma once

#include "setting.hpp"

#include <string>
#include <vector>

struct BudgetRow {
    Effect effect = Effect::occlusion;
    int taps = 0, min_level = 0, filter_taps = 1; // of occlusion and light
    bool normal_test = true;                      // of light
    int stride = 1;                               // of mirrors
    double cost = 1.0, error = 1.0;               // ratios to the BALANCED preset, geometric means of the scenes
};

BudgetRow budget_row(const Setting& setting, double cost, double error);

// One line a row. Both throw std::runtime_error when there is no such file or no room for it.
void write_budget(const std::string& path, const std::vector<BudgetRow>& rows);
std::vector<BudgetRow> read_budget(const std::string& path);

// Of an effect, by growing cost: each is nearer to the truth than all cheaper ones, by a hundredth and more.
std::vector<BudgetRow> budget_front(const std::vector<BudgetRow>& rows, Effect effect);

// Writes the fronts between the two markers of the header; check: only says whether they stand there already. Returns that.
bool embed_budget(const std::string& header, const std::vector<BudgetRow>& rows, bool check);
