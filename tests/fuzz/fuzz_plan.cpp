// Plans as `render --plan` prints them: every name is known, every line is whole. Names of any number: never null.
extern "C" {
#include "fuzz.h"
}
#include "render_report.hpp"

#include <csetjmp>
#include <cstdarg>

extern "C" {
#include <cmocka.h>
}

namespace {

void check_name(const char* name, bool known, int number) {
    const bool is_known = name != nullptr && name[0] != '\0' && name[0] != '?';
    if (name == nullptr || is_known != known) { fail_msg("the name of %d", number); }
}

// Slot 0 is none, and so is format 0.
void check_names(int i) {
    const auto below = [i](int count) { return i >= 0 && i < count; };
    check_name(dgb_result_name(dgb_result(i)), below(DGB_DEVICE + 1), i);
    check_name(dgb_slot_name(dgb_slot(i)), below(DGB_SLOT_COUNT), i);
    check_name(dgb_pass_name(dgb_pass_id(i)), below(DGB_PASS_COUNT), i);
    check_name(dgb_format_name(dgb_format(i)), below(DGB_FORMAT_COUNT), i);
    check_name(dgb_oracle_name(dgb_oracle(i)), below(DGB_ORACLE_COUNT), i);
    check_name(dgb_emission_name(dgb_emission(i)), below(DGB_EMISSION_COUNT), i);
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
    fuzz_bytes b = {bytes, bytes + size};
    const dgb_desc desc = fuzz_desc(&b);
    dgb_plan plan{};
    check_names(fuzz_int(&b));
    if (dgb_make_plan(&desc, &plan) != DGB_OK) { return 0; }
    const std::string text = plan_to_text(plan);
    const auto lines = std::count(text.begin(), text.end(), '\n');
    if (text.find('?') != std::string::npos || text.find("none ") != std::string::npos) {
        fail_msg("%s", text.c_str());
    }
    // The size, "passes", "textures" and the total, and an empty line before the last three.
    if (lines != plan.pass_count + plan.texture_count + 7) { fail_msg("a line is missing:\n%s", text.c_str()); }
    return 0;
}
