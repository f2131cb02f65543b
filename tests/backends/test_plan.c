/* Plans: what every desc would create and run, and what is wrong with the descs that are refused. No device
   at all. */

#include "numbers.h"
#include "record_backend.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <limits.h>
#include <string.h>

#define ALL_EFFECTS                                                                                         \
    (DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY | DGB_EFFECT_BOUNCES | DGB_EFFECT_TEMPORAL | DGB_EFFECT_REFLECT | \
     DGB_EFFECT_GLOSSY)

static const char* const normals_names[DGB_NORMALS_COUNT] = {"from depth", "oct16", "unorm", "float"};

static dgb_desc small_desc(int layers, uint32_t effects) {
    dgb_desc d;
    memset(&d, 0, sizeof d);
    d.width = 64;
    d.height = 48;
    d.guard_band = 8;
    d.layers = layers;
    d.effects = effects;
    return d;
}

static dgb_plan make_plan(const dgb_desc* desc) {
    dgb_plan plan;
    memset(&plan, 0, sizeof plan);
    if (dgb_make_plan(desc, &plan) != DGB_OK)
        fail_msg("refused: %d layers, effects %u, oracle %d, emission %d", desc->layers, (unsigned)desc->effects,
                 (int)desc->oracle, (int)desc->emission);
    return plan;
}

/* >> plans as text */

static void print_texture(record_text* text, const dgb_texture_desc* t) {
    record_printf(text, "texture %s %s %dx%d", dgb_slot_name(t->slot), dgb_format_name(t->format), t->width, t->height);
    if (t->layers) record_printf(text, " layers %d", t->layers);
    record_printf(text, " levels %d, %u bytes\n", t->levels, (unsigned)t->bytes);
}

static void print_pass(record_text* text, const dgb_plan_pass* pass) {
    int i;
    record_printf(text, "pass %s", dgb_pass_name(pass->id));
    if (pass->id == DGB_PASS_MIP || pass->id == DGB_PASS_RECONSTRUCT || pass->id == DGB_PASS_RANGE)
        record_printf(text, " %d", pass->level);
    if (pass->program >= 0) record_printf(text, " #%d", pass->program);
    record_printf(text, ":");
    for (i = 0; i < pass->input_count; ++i) {
        record_printf(text, " %s", dgb_slot_name(pass->inputs[i].name));
        if (pass->inputs[i].texture != pass->inputs[i].name)
            record_printf(text, "=%s", dgb_slot_name(pass->inputs[i].texture));
    }
    record_printf(text, " ->");
    for (i = 0; i < pass->output_count; ++i) record_printf(text, " %s", dgb_slot_name(pass->outputs[i]));
    record_printf(text, "\n");
}

static void print_program(record_text* text, const dgb_plan* plan, int i) {
    record_printf(text, "program #%d ", i);
    record_print_program(text, &plan->programs[i]);
    record_printf(text, "\n");
}

static void print_plan(record_text* text, const dgb_plan* plan) {
    int i;
    record_printf(text, "%dx%d, %d layers, %d levels, oracle %s\n", plan->width, plan->height, plan->layers,
                  plan->levels, dgb_oracle_name(plan->oracle));
    for (i = 0; i < plan->texture_count; ++i) print_texture(text, &plan->textures[i]);
    for (i = 0; i < plan->program_count; ++i) print_program(text, plan, i);
    for (i = 0; i < plan->pass_count; ++i) print_pass(text, &plan->passes[i]);
    record_printf(text, "%u bytes\n", (unsigned)plan->bytes);
}

/* >> golden plans */

/* Many bounces are more of the first, glossy reflections are reflections; the temporal filter needs something to
   filter. */
enum { GLOSSY = DGB_EFFECT_GLOSSY | DGB_EFFECT_REFLECT };

static bool makes_sense(uint32_t effects) {
    const bool ao = (effects & DGB_EFFECT_AO) != 0, light = (effects & DGB_EFFECT_RADIOSITY) != 0;
    const bool glossy = (effects & DGB_EFFECT_GLOSSY) != 0;
    return effects <= ALL_EFFECTS && (light || !(effects & DGB_EFFECT_BOUNCES)) &&
           (!glossy || (effects & DGB_EFFECT_REFLECT)) && (ao || light || glossy || !(effects & DGB_EFFECT_TEMPORAL));
}

/* How the layers are emitted is no matter of textures and passes, so one section holds for all that are
   allowed, but for image emission, which has a section of its own. */
static void print_built_section(record_text* text, int layers, uint32_t effects, dgb_oracle oracle) {
    record_text first = {0}, other = {0};
    dgb_desc d = small_desc(layers, effects);
    dgb_emission emission = DGB_EMISSION_AUTO;
    record_printf(text, "== built, effects %s, layers %d, oracle %s\nemission", record_effect_names(effects), layers,
                  dgb_oracle_name(oracle));
    d.oracle = oracle;
    for (; emission < DGB_EMISSION_COUNT; emission = (dgb_emission)(emission + 1)) {
        dgb_plan plan;
        if (oracle == DGB_ORACLE_PEEL && emission > DGB_EMISSION_SEPARATE) continue;
        if (emission == DGB_EMISSION_IMAGE) continue;
        d.emission = emission;
        plan = make_plan(&d);
        record_printf(text, " %s=%s", dgb_emission_name(emission), dgb_emission_name(plan.emission));
        record_text_clear(&other);
        print_plan(first.data ? &other : &first, &plan);
        if (other.size && strcmp(first.data, other.data) != 0) fail_msg("emission %d changes the plan", (int)emission);
    }
    record_printf(text, "\n%s\n", first.data);
    if (oracle != DGB_ORACLE_PEEL && layers > 1) {
        dgb_plan plan;
        d.emission = DGB_EMISSION_IMAGE;
        plan = make_plan(&d);
        record_printf(text, "emission image\n");
        print_plan(text, &plan);
        record_printf(text, "\n");
    }
    record_text_free(&first);
    record_text_free(&other);
}

/* The format of the engine's normals changes the pack pass only; later ones are printed as far as they may
   differ. */
static void print_engine_section(record_text* text, int layers, uint32_t effects, dgb_normals normals) {
    dgb_desc d = small_desc(layers, effects);
    dgb_plan plan;
    d.source = DGB_SOURCE_ENGINE;
    d.normals = normals;
    plan = make_plan(&d);
    assert_int_equal(plan.oracle, DGB_ORACLE_DEFAULT); /* there is nothing to build */
    record_printf(text, "== engine's own, effects %s, layers %d, normals %s\n", record_effect_names(effects), layers,
                  normals_names[normals]);
    if (normals == DGB_NORMALS_FROM_DEPTH) {
        print_plan(text, &plan);
    } else if (plan.pass_count) {
        print_program(text, &plan, 0);
        print_pass(text, &plan.passes[0]);
    }
    record_printf(text, "\n");
}

static void print_hierarchical_section(record_text* text, int layers) {
    dgb_desc d = small_desc(layers, DGB_EFFECT_REFLECT);
    dgb_plan plan;
    d.tracer = DGB_TRACER_HIERARCHICAL;
    plan = make_plan(&d);
    record_printf(text, "== hierarchical tracer, layers %d\n", layers);
    print_plan(text, &plan);
    record_printf(text, "\n");
}

static void print_back_section(record_text* text, int layers) {
    dgb_desc d = small_desc(layers, DGB_EFFECT_AO | DGB_EFFECT_REFLECT);
    dgb_plan plan;
    d.thickness = DGB_THICKNESS_BACK_FACES;
    plan = make_plan(&d);
    record_printf(text, "== back faces, layers %d\n", layers);
    print_plan(text, &plan);
    record_printf(text, "\n");
}

static void test_golden_plans(void** state) {
    record_text text = {0};
    uint32_t effects;
    int layers, oracle, normals;
    (void)state;
    for (effects = 0; effects < 4; ++effects)
        for (layers = 1; layers <= 2; ++layers)
            for (oracle = 0; oracle < DGB_ORACLE_COUNT; ++oracle)
                if (oracle != DGB_ORACLE_DEFAULT || layers == 1)
                    print_built_section(&text, layers, effects, (dgb_oracle)oracle);
    print_built_section(&text, 3, 3, DGB_ORACLE_REPROJECT);
    for (layers = 3; layers <= 8; layers += 5)
        for (oracle = DGB_ORACLE_PREDICT; oracle <= DGB_ORACLE_DELAY; ++oracle)
            print_built_section(&text, layers, 0, (dgb_oracle)oracle);
    print_built_section(&text, 8, 3, DGB_ORACLE_DELAY);
    for (effects = 0; effects < 4; ++effects)
        for (layers = 1; layers <= 2; ++layers)
            for (normals = 0; normals < DGB_NORMALS_COUNT; ++normals)
                print_engine_section(&text, layers, effects, (dgb_normals)normals);
    for (effects = 4; effects < DGB_EFFECT_REFLECT; ++effects)
        for (layers = 1; layers <= 2 && makes_sense(effects); ++layers)
            print_built_section(&text, layers, effects, DGB_ORACLE_PEEL);
    for (layers = 1; layers <= 2; ++layers) { /* reflections add a pass, and radiance where nothing else packs it */
        print_built_section(&text, layers, DGB_EFFECT_REFLECT, DGB_ORACLE_PEEL);
        print_built_section(&text, layers, DGB_EFFECT_REFLECT | DGB_EFFECT_AO, DGB_ORACLE_PEEL);
        print_built_section(&text, layers, DGB_EFFECT_REFLECT | DGB_EFFECT_RADIOSITY, DGB_ORACLE_PEEL);
        print_built_section(&text, layers, ALL_EFFECTS, DGB_ORACLE_PEEL);
        print_engine_section(&text, layers, DGB_EFFECT_REFLECT, DGB_NORMALS_FROM_DEPTH);
        print_hierarchical_section(&text, layers);
        print_back_section(&text, layers);
        print_built_section(&text, layers, GLOSSY, DGB_ORACLE_PEEL);
        print_built_section(&text, layers, GLOSSY | DGB_EFFECT_TEMPORAL, DGB_ORACLE_PEEL);
        print_engine_section(&text, layers, GLOSSY | DGB_EFFECT_TEMPORAL, DGB_NORMALS_FROM_DEPTH);
    }
    print_engine_section(&text, 2, DGB_EFFECT_REFLECT | DGB_EFFECT_RADIOSITY, DGB_NORMALS_FROM_DEPTH);
    print_engine_section(&text, 1, ALL_EFFECTS, DGB_NORMALS_FROM_DEPTH);
    print_engine_section(&text, 2, ALL_EFFECTS, DGB_NORMALS_FROM_DEPTH);
    print_engine_section(&text, 2, DGB_EFFECT_AO | DGB_EFFECT_TEMPORAL, DGB_NORMALS_FROM_DEPTH);
    record_check_golden("plan.golden", &text);
    record_text_free(&text);
}

/* >> what every plan keeps to */

typedef void (*desc_check)(const dgb_desc* desc);
typedef void (*plan_check)(const dgb_desc* desc, const dgb_plan* plan);

/* Which of the combinations below are good, and why the others are not. */
static dgb_log_item expected_item(const dgb_desc* d) {
    const bool divides = d->divisor != 0 && d->divisor != 1;
    if (d->source == DGB_SOURCE_ENGINE && d->layers > 2) return DGB_LOG_LAYERS;
    if (!makes_sense(d->effects)) return DGB_LOG_EFFECTS;
    if (d->source == DGB_SOURCE_ENGINE) {
        return d->oracle || d->emission || divides ? DGB_LOG_SOURCE_OPTIONS : DGB_LOG_NONE;
    }
    if (d->oracle == DGB_ORACLE_PEEL && d->emission != DGB_EMISSION_AUTO && d->emission != DGB_EMISSION_SEPARATE)
        return DGB_LOG_PEEL_EMISSION;
    if (divides && d->divisor != 2 && d->divisor != 4) return DGB_LOG_DIVISOR;
    if (divides && (d->emission == DGB_EMISSION_IMAGE || d->emission == DGB_EMISSION_MULTICAST)) return DGB_LOG_DIVISOR;
    return DGB_LOG_NONE;
}

static void for_every_oracle(dgb_desc d, desc_check check) {
    static const int divisors[] = {0, 1, 2, 4, 3, 8, -1, -2};
    int oracle, emission, normals;
    size_t divisor;
    for (oracle = 0; oracle < DGB_ORACLE_COUNT; ++oracle)
        for (emission = 0; emission < DGB_EMISSION_COUNT; ++emission)
            for (normals = 0; normals < DGB_NORMALS_COUNT; ++normals)
                for (divisor = 0; divisor < sizeof divisors / sizeof divisors[0]; ++divisor) {
                    d.oracle = (dgb_oracle)oracle;
                    d.emission = (dgb_emission)emission;
                    d.normals = (dgb_normals)normals;
                    d.divisor = divisors[divisor];
                    check(&d);
                }
}

static void for_every_desc(desc_check check) {
    uint32_t effects;
    int layers, source;
    for (effects = 0; effects <= ALL_EFFECTS; ++effects)
        for (layers = 0; layers <= DGB_MAX_LAYERS; ++layers)
            for (source = 0; source < 2; ++source) {
                dgb_desc d = small_desc(layers, effects);
                d.source = (dgb_source)source;
                for_every_oracle(d, check);
            }
}

static plan_check running_check;

static void check_if_good(const dgb_desc* desc) {
    dgb_plan plan;
    if (expected_item(desc) != DGB_LOG_NONE) return;
    plan = make_plan(desc);
    running_check(desc, &plan);
}

static void for_every_plan(plan_check check) {
    running_check = check;
    for_every_desc(check_if_good);
}

static const dgb_texture_desc* find_texture(const dgb_plan* plan, dgb_slot slot) {
    int i;
    for (i = 0; i < plan->texture_count; ++i)
        if (plan->textures[i].slot == slot) return &plan->textures[i];
    return NULL;
}

static bool has_pass(const dgb_plan* plan, dgb_pass_id id) {
    int i;
    for (i = 0; i < plan->pass_count; ++i)
        if (plan->passes[i].id == id) return true;
    return false;
}

static bool has_program(const dgb_plan* plan, dgb_pass_id id) {
    int i;
    for (i = 0; i < plan->program_count; ++i)
        if (plan->programs[i].pass == id) return true;
    return false;
}

static void check_stage(const dgb_plan* plan, dgb_pass_id id, bool wanted) {
    if (has_pass(plan, id) != wanted || has_program(plan, id) != wanted)
        fail_msg("pass %s is %s", dgb_pass_name(id), wanted ? "missing" : "not wanted");
}

static void check_texture(const dgb_plan* plan, dgb_slot slot, bool wanted, dgb_format format) {
    const dgb_texture_desc* t = find_texture(plan, slot);
    if ((t != NULL) != wanted) fail_msg("texture %s is %s", dgb_slot_name(slot), wanted ? "missing" : "not wanted");
    if (t && t->format != format) fail_msg("%s is %s", dgb_slot_name(slot), dgb_format_name(t->format));
    if (t) assert_true(t->width == plan->width && t->height == plan->height && t->layers == 0);
}

/* Last frame's depths for whoever looks back; averages for the temporal filter; the second layer's light where it
   bounces on. An average needs a half: in R11G11B10F it would stick far below its aim. */
static void check_history(const dgb_desc* desc, const dgb_plan* plan) {
    const bool bounces = (desc->effects & DGB_EFFECT_BOUNCES) != 0,
               temporal = (desc->effects & DGB_EFFECT_TEMPORAL) != 0;
    const bool light = (desc->effects & DGB_EFFECT_RADIOSITY) != 0, reflect = (desc->effects & DGB_EFFECT_REFLECT) != 0;
    const bool deep =
        (bounces || (light && reflect)) && plan->layers > 1; /* what is mirrored shows its bounced light */
    const bool spiral = light || (desc->effects & DGB_EFFECT_AO);
    const dgb_format z = plan->layers > 1 ? DGB_FORMAT_RG32F : DGB_FORMAT_R32F;
    check_texture(plan, DGB_LAST_Z, bounces || temporal, z);
    if (bounces || temporal) /* they change places: one must be as the other */
        assert_int_equal(find_texture(plan, DGB_LAST_Z)->levels, find_texture(plan, DGB_Z)->levels);
    check_texture(plan, DGB_FRAMES, temporal && spiral, DGB_FORMAT_RGBA16F);
    check_texture(plan, DGB_LAST_FRAMES, temporal && spiral, DGB_FORMAT_RGBA16F);
    check_texture(plan, DGB_IRRADIANCE_MEAN, temporal && light, DGB_FORMAT_RGBA16F);
    check_texture(plan, DGB_LAST_IRRADIANCE, temporal && light, DGB_FORMAT_RGBA16F);
    check_texture(plan, DGB_IRRADIANCE1_MEAN, temporal && deep, DGB_FORMAT_RGBA16F);
    check_texture(plan, DGB_LAST_IRRADIANCE1, temporal && deep, DGB_FORMAT_RGBA16F);
    check_texture(plan, DGB_IRRADIANCE1_RAW, deep, DGB_FORMAT_RGBA16F);
    check_texture(plan, DGB_HALF1, deep, DGB_FORMAT_RGBA32UI);
    check_texture(plan, DGB_IRRADIANCE1, deep, DGB_FORMAT_RGBA16F);
    check_stage(plan, DGB_PASS_TEMPORAL, temporal && spiral);
}

/* One ray a pixel, what neighbours make of it, and what that was last frame. */
static void check_glossy(const dgb_desc* desc, const dgb_plan* plan) {
    const bool glossy = (desc->effects & DGB_EFFECT_GLOSSY) != 0, reflect = (desc->effects & DGB_EFFECT_REFLECT) != 0;
    const bool averaged = glossy && (desc->effects & DGB_EFFECT_TEMPORAL);
    int i, k;
    check_texture(plan, DGB_REFLECTION_RAW, glossy, DGB_FORMAT_RGBA16F);
    check_texture(plan, DGB_REFLECTION_HIT, reflect, glossy ? DGB_FORMAT_RGBA16F : DGB_FORMAT_RG16F);
    check_texture(plan, DGB_LAST_REFLECTION, averaged, DGB_FORMAT_RGBA16F);
    check_texture(plan, DGB_REFLECTION_FRAMES, averaged, DGB_FORMAT_R8);
    check_texture(plan, DGB_LAST_REFLECTION_FRAMES, averaged, DGB_FORMAT_R8);
    check_stage(plan, DGB_PASS_GLOSSY, glossy);
    for (i = 0; i < plan->program_count; ++i) /* no mirror is traced by a program that knows of roughness */
        for (k = 0; k < plan->programs[i].define_count; ++k)
            if (strcmp(plan->programs[i].defines[k].name, "DGB_GLOSSY") == 0)
                assert_int_equal(plan->programs[i].defines[k].value, glossy);
    for (i = 0; i < plan->pass_count && !glossy; ++i) /* nor does it read any */
        for (k = 0; k < plan->passes[i].input_count && plan->passes[i].id == DGB_PASS_REFLECT; ++k)
            assert_true(plan->passes[i].inputs[k].name != DGB_NORMAL &&
                        plan->passes[i].inputs[k].name != DGB_ENGINE_ROUGHNESS);
}

static void check_effects_cost_only_what_is_on(const dgb_desc* desc, const dgb_plan* plan) {
    static const dgb_slot of_ao[] = {DGB_AO_RAW, DGB_AO};
    static const dgb_slot of_light[] = {DGB_IRRADIANCE_RAW, DGB_IRRADIANCE};
    static const dgb_slot of_any[] = {DGB_Z, DGB_NORMALS};
    const bool ao = desc->effects & DGB_EFFECT_AO, light = (desc->effects & DGB_EFFECT_RADIOSITY) != 0;
    const bool reflect = (desc->effects & DGB_EFFECT_REFLECT) != 0, spiral = ao || light;
    size_t i;
    for (i = 0; i < 2; ++i) assert_int_equal(find_texture(plan, of_ao[i]) != NULL, ao);
    for (i = 0; i < 2; ++i) assert_int_equal(find_texture(plan, of_light[i]) != NULL, light);
    check_texture(plan, DGB_HALF, spiral, light ? DGB_FORMAT_RGBA32UI : DGB_FORMAT_RG32UI); /* no light: half as wide */
    for (i = 0; i < 2; ++i) assert_int_equal(find_texture(plan, of_any[i]) != NULL, desc->effects != 0);
    assert_int_equal(find_texture(plan, DGB_ROTATIONS) != NULL, spiral);
    assert_int_equal(find_texture(plan, DGB_B0) != NULL, light || reflect);
    assert_int_equal(find_texture(plan, DGB_B1) != NULL, (light || reflect) && plan->layers > 1);
    /* a ray is marched at full resolution */
    if (desc->effects) assert_int_equal(find_texture(plan, DGB_Z)->levels, spiral ? plan->levels : 1);
    if (reflect && !light) assert_int_equal(find_texture(plan, DGB_B0)->levels, 1);
    check_texture(plan, DGB_REFLECTION, reflect, DGB_FORMAT_RGBA16F);
    check_stage(plan, DGB_PASS_AO, ao);
    check_stage(plan, DGB_PASS_GATHER, light);
    check_stage(plan, DGB_PASS_PACK, desc->effects != 0);
    check_stage(plan, DGB_PASS_MIP, spiral);
    check_stage(plan, DGB_PASS_TILES, spiral && plan->layers > 1);
    check_stage(plan, DGB_PASS_RECONSTRUCT, spiral);
    check_stage(plan, DGB_PASS_RANGE, reflect && desc->tracer == DGB_TRACER_HIERARCHICAL);
    check_stage(plan, DGB_PASS_REFLECT, reflect);
    check_history(desc, plan);
    check_glossy(desc, plan);
    assert_int_equal(has_pass(plan, DGB_PASS_LAYERS), desc->source == DGB_SOURCE_BUILD);
    assert_false(has_program(plan, DGB_PASS_LAYERS)); /* the engine's programs draw it */
}

static bool is_engine_slot(dgb_slot slot) { return slot >= DGB_ENGINE_DEPTH0 && slot <= DGB_ENGINE_ROUGHNESS; }

/* Textures of last frame, and those of this frame that change places with them. */
static const dgb_slot turns[][2] = {{DGB_LAST_Z, DGB_Z},
                                    {DGB_LAST_FRAMES, DGB_FRAMES},
                                    {DGB_LAST_IRRADIANCE, DGB_IRRADIANCE_MEAN},
                                    {DGB_LAST_IRRADIANCE1, DGB_IRRADIANCE1_MEAN},
                                    {DGB_LAST_REFLECTION, DGB_REFLECTION},
                                    {DGB_LAST_REFLECTION_FRAMES, DGB_REFLECTION_FRAMES}};

/* Packing looks at last frame's final light, where it still is. */
static bool is_of_last_frame(const dgb_plan_pass* pass, const dgb_plan_input* input) {
    return pass->id == DGB_PASS_PACK && ((input->name == DGB_LAST_IRRADIANCE && input->texture == DGB_IRRADIANCE) ||
                                         (input->name == DGB_LAST_IRRADIANCE1 && input->texture == DGB_IRRADIANCE1));
}

/* Whatever is read was written before, or comes from the engine; whatever is written exists and has that
   level. */
static void check_passes_connect(const dgb_desc* desc, const dgb_plan* plan) {
    bool written[DGB_SLOT_COUNT] = {false};
    int i, k;
    (void)desc;
    for (i = 0; i < (int)(sizeof turns / sizeof turns[0]); ++i)
        written[turns[i][0]] = find_texture(plan, turns[i][1]) != NULL;
    /* depth and oracle hold the frame before; the key is written by the layers pass, in images */
    written[DGB_ROTATIONS] = written[DGB_ORACLE] = written[DGB_DEPTH] = written[DGB_KEY] = true;
    for (i = 0; i < plan->pass_count; ++i) {
        const dgb_plan_pass* pass = &plan->passes[i];
        for (k = 0; k < pass->input_count; ++k) {
            const dgb_slot slot = pass->inputs[k].texture;
            if (is_engine_slot(slot) || is_of_last_frame(pass, &pass->inputs[k])) continue;
            if (!find_texture(plan, slot) || !written[slot])
                fail_msg("pass %s reads %s too early", dgb_pass_name(pass->id), dgb_slot_name(slot));
        }
        for (k = 0; k < pass->output_count; ++k) {
            const dgb_texture_desc* t = find_texture(plan, pass->outputs[k]);
            if (!t || ((pass->id == DGB_PASS_MIP || pass->id == DGB_PASS_RANGE) && pass->level >= t->levels))
                fail_msg("pass %s writes %s", dgb_pass_name(pass->id), dgb_slot_name(pass->outputs[k]));
            written[pass->outputs[k]] = true;
        }
        if (pass->program >= plan->program_count ||
            (pass->program < 0) !=
                (pass->id == DGB_PASS_LAYERS || pass->id == DGB_PASS_BACK || pass->id == DGB_PASS_PREDICT) ||
            (pass->program >= 0 && plan->programs[pass->program].pass != pass->id))
            fail_msg("pass %s has program %d", dgb_pass_name(pass->id), pass->program);
    }
    for (i = 0; i < plan->texture_count; ++i)
        if (!written[plan->textures[i].slot]) fail_msg("nobody writes %s", dgb_slot_name(plan->textures[i].slot));
}

static void check_bytes(const dgb_desc* desc, const dgb_plan* plan) {
    uint64_t sum = 0;
    int i, k;
    (void)desc;
    for (i = 0; i < plan->texture_count; ++i) {
        sum += plan->textures[i].bytes;
        for (k = 0; k < i; ++k)
            if (plan->textures[k].slot == plan->textures[i].slot)
                fail_msg("two of %s", dgb_slot_name(plan->textures[i].slot));
    }
    if (sum != plan->bytes) fail_msg("%u bytes, not %u", (unsigned)plan->bytes, (unsigned)sum);
}

/* Arrays of the plan hold what goes into them, with the counts telling the truth: nothing is left behind them. */
static void check_limits(const dgb_desc* desc, const dgb_plan* plan) {
    int i, k;
    (void)desc;
    assert_in_range(plan->texture_count, 0, DGB_MAX_TEXTURES);
    assert_in_range(plan->program_count, 0, DGB_MAX_PROGRAMS);
    assert_in_range(plan->pass_count, 0, DGB_MAX_PASSES);
    assert_in_range(plan->levels, 1, DGB_MAX_LEVELS);
    for (i = 0; i < plan->program_count; ++i) {
        assert_in_range(plan->programs[i].define_count, 0, DGB_MAX_DEFINES);
        for (k = 0; k < plan->programs[i].define_count; ++k) assert_non_null(plan->programs[i].defines[k].name);
    }
    for (i = 0; i < plan->pass_count; ++i) {
        const dgb_plan_pass* pass = &plan->passes[i];
        assert_in_range(pass->input_count, 0, DGB_MAX_INPUTS);
        assert_in_range(pass->output_count, 1, DGB_MAX_TARGETS);
        for (k = 0; k < pass->input_count; ++k) assert_true(pass->inputs[k].name && pass->inputs[k].texture);
        for (k = 0; k < pass->output_count; ++k) assert_true(pass->outputs[k]);
    }
    for (i = 0; i < plan->texture_count; ++i) {
        const dgb_texture_desc* t = &plan->textures[i];
        assert_true(t->slot && t->format && t->width > 0 && t->height > 0 && t->levels > 0 && t->bytes > 0);
        assert_in_range(t->layers, 0, DGB_MAX_LAYERS);
    }
}

static void test_plans_keep_their_limits(void** state) {
    (void)state;
    for_every_plan(check_limits);
}

/* What the oracle and the emission bring: textures, passes and the choice as it was made. */
static void check_construction(const dgb_desc* desc, const dgb_plan* plan) {
    const bool built = desc->source == DGB_SOURCE_BUILD, deep = built && plan->layers > 1;
    const bool predicts = deep && (desc->oracle == DGB_ORACLE_PREDICT || desc->oracle == DGB_ORACLE_DELAY);
    const bool warps = deep && desc->oracle == DGB_ORACLE_WARP;
    const bool peels = plan->oracle == DGB_ORACLE_PEEL, image = deep && desc->emission == DGB_EMISSION_IMAGE;
    const dgb_texture_desc* t = find_texture(plan, DGB_ORACLE);
    assert_int_equal(plan->layers, desc->layers ? desc->layers : 2);
    assert_int_equal(t != NULL, deep && !peels);
    if (t) assert_int_equal(t->layers, predicts || warps ? plan->layers - 1 : plan->layers);
    t = find_texture(plan, DGB_PREDICTED);
    assert_int_equal(t != NULL, predicts);
    if (t) assert_int_equal(t->layers, plan->layers - 1);
    t = find_texture(plan, DGB_KEY);
    assert_int_equal(t != NULL, image);
    if (t) assert_true(t->layers == plan->layers - 1 && t->format == DGB_FORMAT_R32UI);
    check_stage(plan, DGB_PASS_WARP, warps);
    check_stage(plan, DGB_PASS_RESOLVE, image);
    assert_int_equal(has_pass(plan, DGB_PASS_PREDICT), predicts);
    if (!built) return;
    if (desc->oracle) assert_int_equal(plan->oracle, desc->oracle);
    if (peels || plan->layers == 1)
        assert_int_equal(plan->emission, DGB_EMISSION_SEPARATE);
    else
        assert_int_equal(plan->emission, desc->emission ? desc->emission : DGB_EMISSION_VERTEX);
}

static void test_constructions_bring_what_they_need(void** state) {
    (void)state;
    for_every_plan(check_construction);
}

static void test_effects_that_are_off_cost_nothing(void** state) {
    (void)state;
    for_every_plan(check_effects_cost_only_what_is_on);
}

static void test_passes_connect(void** state) {
    (void)state;
    for_every_plan(check_passes_connect);
}

static void test_bytes_add_up(void** state) {
    (void)state;
    for_every_plan(check_bytes);
}

/* >> bytes */

static uint64_t bytes_of(const dgb_plan* plan, dgb_slot slot) {
    const dgb_texture_desc* t = find_texture(plan, slot);
    return t ? t->bytes : 0;
}

/* 160 bits a pixel for each layer that is built, and 160 for the packed input of two. */
static void test_160_bits(void** state) {
    dgb_desc d = small_desc(2, DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY);
    const uint64_t pixels = 80 * 64;
    dgb_plan plan;
    uint64_t built, level0 = 0;
    const dgb_slot packed[] = {DGB_Z, DGB_NORMALS, DGB_B0, DGB_B1};
    int i;
    (void)state;
    plan = make_plan(&d);
    built = bytes_of(&plan, DGB_DEPTH) + bytes_of(&plan, DGB_ALBEDO) + bytes_of(&plan, DGB_NORMAL) +
            bytes_of(&plan, DGB_RADIANCE) + bytes_of(&plan, DGB_VELOCITY);
    assert_int_equal(built * 8, pixels * 2 * 160);
    for (i = 0; i < 4; ++i) {
        const dgb_texture_desc* t = find_texture(&plan, packed[i]);
        uint64_t texels = pixels;
        int level;
        for (level = 1; level < t->levels; ++level) texels += (uint64_t)(80 >> level) * (uint64_t)(64 >> level);
        assert_int_equal(t->bytes % texels, 0);
        level0 += t->bytes / texels * pixels;
    }
    assert_int_equal(level0 * 8, pixels * 160);
}

/* 16384 x 16384 x 8 layers: 2^28 pixels, 2^31 texels a target, 2^33 bytes each; nothing may wrap. */
static void test_bytes_of_the_largest(void** state) {
    const uint64_t pixels = (uint64_t)1 << 28, tiles = pixels >> 8, regions = pixels >> 14;
    dgb_desc d = small_desc(8, DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY);
    dgb_plan plan;
    uint64_t chain = 0;
    int level;
    (void)state;
    d.width = d.height = 16384;
    d.guard_band = 0;
    plan = make_plan(&d);
    for (level = 0; level < 6; ++level) chain += pixels >> (2 * level);
    assert_true(bytes_of(&plan, DGB_ALBEDO) == pixels * 32);
    assert_true(bytes_of(&plan, DGB_ORACLE) == pixels * 32);
    /* six layered targets; z, normals and two radiances with levels; two R8, two RGBA16F, one RGBA32UI; 256
       rotations; two depth ranges and a class of each tile, a range of each region */
    assert_true(plan.bytes ==
                6 * 32 * pixels + 20 * chain + 2 * pixels + (16 + 16) * pixels + 2048 + 20 * tiles + 16 * regions);
}

/* k colour layers with their depth, and what the oracle takes: nothing, k depth layers, 2 (k - 1), or k - 1. */
static void test_bytes_of_k_layers(void** state) {
    static const int of_oracle[DGB_ORACLE_COUNT][2] = {{1, 0},  {0, 0},  {1, 0}, {1, 0},
                                                       {2, -2}, {2, -2}, {1, -1}}; /* times k, plus */
    const uint64_t image = (uint64_t)80 * 64 * 4;
    int oracle, layers, is_image;
    (void)state;
    for (oracle = 1; oracle < DGB_ORACLE_COUNT; ++oracle)
        for (layers = 1; layers <= DGB_MAX_LAYERS; ++layers)
            for (is_image = 0; is_image < 2; ++is_image) {
                dgb_desc d = small_desc(layers, 0);
                int depths = layers > 1 ? of_oracle[oracle][0] * layers + of_oracle[oracle][1] : 0;
                dgb_plan plan;
                if (is_image && oracle == DGB_ORACLE_PEEL) continue;
                d.oracle = (dgb_oracle)oracle;
                if (is_image) d.emission = DGB_EMISSION_IMAGE, depths += layers - 1; /* and the keys */
                plan = make_plan(&d);
                if (plan.bytes != image * (uint64_t)(5 * layers + depths))
                    fail_msg("oracle %s, %d layers: %u bytes", dgb_oracle_name(d.oracle), layers, (unsigned)plan.bytes);
            }
}

/* What bounces and the temporal filter cost at 1920 x 1080 in two layers: per pixel, last frame's z with its levels,
   three images of 8 bytes for the second layer's light, six for averages. */
static void test_bytes_of_history(void** state) {
    const uint64_t pixels = 1920u * 1080u;
    static const struct {
        uint32_t effects;
        uint64_t images; /* of 8 bytes a pixel, besides last frame's z */
    } rows[] = {{3 | 4, 4}, {3 | 8, 4}, {3 | 4 | 8, 4 + 6}, {1 | 8, 2}, {2 | 8, 4}, {2 | 4, 4}};
    size_t i;
    (void)state;
    for (i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
        dgb_desc d = small_desc(2, rows[i].effects);
        dgb_plan with, without;
        d.width = 1920, d.height = 1080, d.guard_band = 0;
        with = make_plan(&d);
        d.effects &= 3u;
        without = make_plan(&d);
        assert_int_equal(bytes_of(&with, DGB_LAST_Z), bytes_of(&without, DGB_Z));
        assert_int_equal(with.bytes - without.bytes, bytes_of(&without, DGB_Z) + 8 * pixels * rows[i].images);
    }
}

static void test_odd_sizes(void** state) {
    static const int sizes[][3] = {{1, 1, 0},    {1, 77, 0}, {16384, 1, 0},    {1, 16384, 0},
                                   {1, 1, 8191}, {3, 5, 1},  {16384, 16384, 0}};
    size_t i;
    int k;
    (void)state;
    for (i = 0; i < sizeof sizes / sizeof sizes[0]; ++i) {
        dgb_desc d = small_desc(2, DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY);
        dgb_plan plan;
        int mips = 0;
        d.width = sizes[i][0], d.height = sizes[i][1], d.guard_band = sizes[i][2];
        plan = make_plan(&d);
        assert_int_equal(plan.width, d.width + 2 * d.guard_band);
        assert_int_equal(plan.height, d.height + 2 * d.guard_band);
        assert_int_equal(plan.levels, dgb_mip_levels(plan.width, plan.height));
        for (k = 0; k < plan.pass_count; ++k) mips += plan.passes[k].id == DGB_PASS_MIP;
        assert_int_equal(mips, plan.levels - 1);
        check_bytes(&d, &plan);
        check_passes_connect(&d, &plan);
    }
}

/* >> options that change a plan */

static void test_depth_formats(void** state) {
    static const dgb_format formats[] = {DGB_FORMAT_NONE, DGB_FORMAT_D16, DGB_FORMAT_D24, DGB_FORMAT_D32F};
    static const uint64_t bytes[] = {4, 2, 4, 4};
    int i;
    (void)state;
    for (i = 0; i < 4; ++i) {
        dgb_desc d = small_desc(2, 0);
        dgb_plan plan;
        d.depth_format = formats[i];
        plan = make_plan(&d);
        assert_int_equal(find_texture(&plan, DGB_DEPTH)->format, i ? formats[i] : DGB_FORMAT_D32F);
        assert_int_equal(find_texture(&plan, DGB_ORACLE)->format, i ? formats[i] : DGB_FORMAT_D32F);
        assert_int_equal(bytes_of(&plan, DGB_DEPTH), 2 * 80 * 64 * bytes[i]);
    }
}

static void test_targets(void** state) {
    static const dgb_slot slots[] = {DGB_ALBEDO, DGB_NORMAL, DGB_RADIANCE, DGB_VELOCITY};
    uint32_t targets;
    int i;
    (void)state;
    for (targets = 0; targets <= DGB_TARGET_ALL; ++targets) {
        dgb_desc d = small_desc(2, 0);
        dgb_plan plan;
        d.targets = targets;
        plan = make_plan(&d);
        for (i = 0; i < 4; ++i)
            assert_int_equal(find_texture(&plan, slots[i]) != NULL, !targets || (targets >> i & 1u));
    }
}

static int define_of(const dgb_plan* plan, dgb_pass_id pass, const char* name) {
    int i, k;
    for (i = 0; i < plan->program_count; ++i)
        for (k = 0; k < plan->programs[i].define_count; ++k)
            if (plan->programs[i].pass == pass && strcmp(plan->programs[i].defines[k].name, name) == 0)
                return plan->programs[i].defines[k].value;
    fail_msg("no %s", name);
    return -1;
}

static void test_senders_choose_the_program(void** state) {
    dgb_desc d = small_desc(2, DGB_EFFECT_RADIOSITY);
    dgb_plan plan;
    (void)state;
    plan = make_plan(&d);
    assert_int_equal(define_of(&plan, DGB_PASS_GATHER, "DGB_STRONGEST_SENDER"), 0);
    d.senders = DGB_SENDERS_STRONGEST;
    plan = make_plan(&d);
    assert_int_equal(define_of(&plan, DGB_PASS_GATHER, "DGB_STRONGEST_SENDER"), 1);
}

/* The estimators read and write the same: only the programs of AO and GATHER differ, and neither has the other's
   choices. */
static void check_estimator(dgb_desc d) {
    const dgb_plan paper = make_plan(&d);
    dgb_plan plan;
    int i, k;
    d.estimator = DGB_ESTIMATOR_BITMASK;
    plan = make_plan(&d);
    assert_true(same_bits(paper.textures, plan.textures, sizeof plan.textures));
    assert_true(same_bits(paper.passes, plan.passes, sizeof plan.passes));
    assert_int_equal(paper.program_count, plan.program_count);
    for (i = 0; i < plan.program_count; ++i) {
        const dgb_program_desc* p = &plan.programs[i];
        const bool tapped = p->pass == DGB_PASS_AO || p->pass == DGB_PASS_GATHER;
        bool found = false;
        if (!tapped) assert_true(same_bits(p, &paper.programs[i], sizeof *p));
        for (k = 0; k < p->define_count; ++k) {
            assert_string_not_equal(p->defines[k].name, "DGB_STRONGEST_SENDER");
            if (strcmp(p->defines[k].name, "DGB_BITMASK_LIGHT") != 0) continue;
            assert_int_equal(p->defines[k].value, p->pass == DGB_PASS_GATHER);
            found = true;
        }
        assert_true(found == tapped);
    }
}

static bool reads(const dgb_plan_pass* pass, dgb_slot name, dgb_slot texture) {
    int i;
    for (i = 0; i < pass->input_count; ++i)
        if (pass->inputs[i].name == name && pass->inputs[i].texture == texture) return true;
    return false;
}

/* Last of all that a pass writes, so that the others stay where they are. */
static bool writes_last(const dgb_plan_pass* pass, dgb_slot slot) {
    return pass->output_count > 0 && pass->outputs[pass->output_count - 1] == slot;
}

/* The way of DGB_BENT through the passes; without the effect nothing of it is there. */
static void check_bent(uint32_t effects, int layers) {
    const bool temporal = (effects & DGB_EFFECT_TEMPORAL) != 0;
    dgb_desc d = small_desc(layers, effects | DGB_EFFECT_BENT);
    dgb_plan with, without;
    int i, textures = 0;
    d.estimator = DGB_ESTIMATOR_BITMASK;
    with = make_plan(&d);
    d.effects = effects;
    without = make_plan(&d);
    assert_int_equal(with.pass_count, without.pass_count);
    assert_int_equal(with.texture_count, without.texture_count + (temporal ? 5 : 3));
    for (i = 0; i < with.texture_count; ++i)
        textures += with.textures[i].slot == DGB_BENT && with.textures[i].format == DGB_FORMAT_RGBA16F;
    assert_int_equal(textures, 1);
    for (i = 0; i < with.pass_count; ++i) {
        const dgb_plan_pass* p = &with.passes[i];
        if (p->id == DGB_PASS_AO) assert_true(writes_last(p, DGB_BENT_RAW));
        if (p->id == DGB_PASS_TEMPORAL)
            assert_true(reads(p, DGB_BENT_RAW, DGB_BENT_RAW) && reads(p, DGB_LAST_BENT, DGB_LAST_BENT) &&
                        writes_last(p, DGB_BENT_MEAN));
        if (p->id == DGB_PASS_RECONSTRUCT && p->level == 0)
            assert_true(reads(p, DGB_BENT_RAW, temporal ? DGB_BENT_MEAN : DGB_BENT_RAW) &&
                        writes_last(p, DGB_HALF_BENT));
        if (p->id == DGB_PASS_RECONSTRUCT && p->level == 1)
            assert_true(reads(p, DGB_HALF_BENT, DGB_HALF_BENT) && writes_last(p, DGB_BENT));
    }
    assert_int_equal(define_of(&with, DGB_PASS_AO, "DGB_BENT"), 1);
    assert_int_equal(define_of(&without, DGB_PASS_AO, "DGB_BENT"), 0);
}

static void test_bent(void** state) {
    uint32_t effects;
    int layers;
    (void)state;
    for (effects = 0; effects <= ALL_EFFECTS; ++effects)
        for (layers = 1; layers <= 2 && makes_sense(effects) && (effects & DGB_EFFECT_AO); ++layers)
            check_bent(effects, layers);
}

static void test_estimator(void** state) {
    uint32_t effects;
    int layers;
    (void)state;
    for (effects = 0; effects <= ALL_EFFECTS; ++effects)
        for (layers = 1; layers <= 2 && makes_sense(effects); ++layers) {
            dgb_desc d = small_desc(layers, effects);
            check_estimator(d);
            d.divisor = 2;
            check_estimator(d);
        }
}

/* What the hierarchical tracer adds, and nothing else: without reflections nothing, else the ranges, from z to cells
   that are no longer than the buffer. All levels have whole cells, also of a buffer that is not divisible. */
static void check_tracer(dgb_desc d) {
    const bool reflects = (d.effects & DGB_EFFECT_REFLECT) != 0;
    const dgb_plan linear = make_plan(&d);
    const dgb_texture_desc* ranges;
    dgb_plan plan;
    int longer, level;
    uint64_t bytes = 0;
    d.tracer = DGB_TRACER_HIERARCHICAL;
    plan = make_plan(&d);
    assert_null(find_texture(&linear, DGB_RANGES));
    assert_false(has_pass(&linear, DGB_PASS_RANGE) || has_program(&linear, DGB_PASS_RANGE));
    if (!reflects) {
        assert_true(same_bits(&linear, &plan, sizeof plan));
        return;
    }
    ranges = find_texture(&plan, DGB_RANGES);
    longer = plan.width > plan.height ? plan.width : plan.height;
    assert_int_equal(define_of(&linear, DGB_PASS_REFLECT, "DGB_HIERARCHICAL"), 0);
    assert_int_equal(define_of(&plan, DGB_PASS_REFLECT, "DGB_HIERARCHICAL"), 1);
    assert_non_null(ranges);
    assert_int_equal(ranges->format, plan.layers > 1 ? DGB_FORMAT_RGBA32F : DGB_FORMAT_RG32F);
    assert_true(ranges->levels == 1 || 4 << (ranges->levels - 1) <= longer);
    assert_true(ranges->levels == DGB_MAX_LEVELS || 4 << ranges->levels > longer);
    for (level = 0; level < ranges->levels; ++level) {
        const int cell = 4 << level;
        assert_int_equal(ranges->width % (1 << level), 0);
        assert_int_equal(ranges->height % (1 << level), 0);
        assert_true((ranges->width >> level) * cell >= plan.width && (ranges->height >> level) * cell >= plan.height);
        bytes +=
            (uint64_t)(ranges->width >> level) * (uint64_t)(ranges->height >> level) * (plan.layers > 1 ? 16u : 8u);
    }
    assert_true(ranges->bytes == bytes);
    assert_int_equal(plan.texture_count, linear.texture_count + 1);
    assert_int_equal(plan.pass_count, linear.pass_count + ranges->levels);
    check_limits(&d, &plan);
    check_bytes(&d, &plan);
    check_passes_connect(&d, &plan);
}

static void test_tracer(void** state) {
    static const int sizes[][2] = {{1, 1}, {3, 2}, {4, 4}, {5, 3}, {7, 900}, {63, 41}, {640, 360}, {16384, 1}};
    uint32_t effects;
    size_t i;
    int layers;
    (void)state;
    for (effects = 0; effects <= ALL_EFFECTS; ++effects)
        for (layers = 1; layers <= 2 && makes_sense(effects); ++layers)
            for (i = 0; i < sizeof sizes / sizeof sizes[0]; ++i) {
                dgb_desc d = small_desc(layers, effects);
                d.width = sizes[i][0], d.height = sizes[i][1], d.guard_band = 0;
                if (layers > 1) d.emission = DGB_EMISSION_IMAGE, d.oracle = DGB_ORACLE_PREDICT; /* the most passes */
                check_tracer(d);
            }
}

/* What back faces add: where nothing reads them nothing, else a texture and a pass before the prediction, and room for
   their z in that of the layers. Of the engine's own layers, an input. */
static void check_back(dgb_desc d) {
    const bool covers = d.estimator == DGB_ESTIMATOR_BITMASK && (d.effects & (DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY));
    const bool reads = covers || (d.effects & DGB_EFFECT_REFLECT), built = d.source == DGB_SOURCE_BUILD;
    const dgb_plan layers = make_plan(&d);
    const dgb_texture_desc* t;
    dgb_plan plan;
    d.thickness = DGB_THICKNESS_BACK_FACES;
    plan = make_plan(&d);
    assert_null(find_texture(&layers, DGB_BACK));
    check_texture(&plan, DGB_BACK, reads && built, DGB_FORMAT_D32F);
    assert_int_equal(has_pass(&plan, DGB_PASS_BACK), reads && built);
    if (d.effects) assert_int_equal(define_of(&plan, DGB_PASS_PACK, "DGB_BACK"), reads);
    t = find_texture(&plan, DGB_Z);
    if (t && reads) assert_int_equal(t->format, DGB_FORMAT_RGBA32F);
    if (t && !reads) assert_int_equal(t->format, find_texture(&layers, DGB_Z)->format);
    if (t && find_texture(&plan, DGB_LAST_Z)) assert_int_equal(find_texture(&plan, DGB_LAST_Z)->format, t->format);
    if (covers && (d.effects & DGB_EFFECT_AO)) assert_int_equal(define_of(&plan, DGB_PASS_AO, "DGB_THICKNESS"), 2);
    if (d.effects & DGB_EFFECT_REFLECT) assert_int_equal(define_of(&plan, DGB_PASS_REFLECT, "DGB_THICKNESS"), 2);
    assert_int_equal(plan.texture_count, layers.texture_count + (reads && built));
    assert_int_equal(plan.pass_count, layers.pass_count + (reads && built));
    check_limits(&d, &plan);
    check_bytes(&d, &plan);
    check_passes_connect(&d, &plan);
}

static void test_back(void** state) {
    uint32_t effects;
    int layers, i;
    (void)state;
    for (effects = 0; effects <= ALL_EFFECTS; ++effects)
        for (layers = 1; layers <= 2 && makes_sense(effects); ++layers)
            for (i = 0; i < 4; ++i) {
                dgb_desc d = small_desc(layers, effects);
                d.estimator = i % 2 ? DGB_ESTIMATOR_BITMASK : DGB_ESTIMATOR_PAPER;
                d.tracer = DGB_TRACER_HIERARCHICAL;
                if (i >= 2) d.source = DGB_SOURCE_ENGINE, d.normals = DGB_NORMALS_FLOAT; /* the most inputs */
                if (i < 2 && layers > 1)
                    d.emission = DGB_EMISSION_IMAGE, d.oracle = DGB_ORACLE_PREDICT; /* and passes */
                check_back(d);
            }
}

/* A lower resolution of the deeper layers is a matter of viewports and programs: no texture changes. */
static void test_divisor(void** state) {
    static const struct {
        dgb_pass_id pass;
        int places;
    } users[] = {
        {DGB_PASS_PACK, 1}, {DGB_PASS_AO, 1}, {DGB_PASS_GATHER, 2}, {DGB_PASS_TEMPORAL, 2}, {DGB_PASS_RECONSTRUCT, 2}};
    int divisor, i, k;
    size_t user;
    (void)state;
    for (divisor = 1; divisor <= 4; divisor *= 2) {
        dgb_desc d = small_desc(2, DGB_EFFECT_AO | DGB_EFFECT_RADIOSITY | DGB_EFFECT_BOUNCES | DGB_EFFECT_TEMPORAL);
        const dgb_plan whole = make_plan(&d);
        dgb_plan plan;
        int places = 0;
        d.divisor = divisor;
        plan = make_plan(&d);
        for (user = 0; user < sizeof users / sizeof users[0]; ++user) {
            assert_int_equal(define_of(&plan, users[user].pass, "DGB_DIVISOR"), divisor);
            assert_int_equal(define_of(&whole, users[user].pass, "DGB_DIVISOR"), 1);
            places += users[user].places;
        }
        for (i = 0; i < plan.program_count; ++i)
            for (k = 0; k < plan.programs[i].define_count; ++k)
                if (strcmp(plan.programs[i].defines[k].name, "DGB_DIVISOR") == 0) {
                    assert_int_equal(plan.programs[i].defines[k].value, divisor);
                    plan.programs[i].defines[k].value = 1; /* all that differs */
                    --places;
                }
        assert_int_equal(places, 0);
        if (!same_bits(&plan, &whole, sizeof plan)) fail_msg("divisor %d changes more than the programs", divisor);
    }
}

static dgb_emission automatic(bool geometry, bool vertex, dgb_oracle oracle, int layers) {
    record_backend r;
    dgb_desc d = small_desc(layers, 0);
    dgb_plan plan;
    record_start(&r);
    r.backend.caps.emission[DGB_EMISSION_GEOMETRY] = geometry;
    r.backend.caps.emission[DGB_EMISSION_VERTEX] = vertex;
    d.backend = &r.backend;
    d.oracle = oracle;
    plan = make_plan(&d);
    record_stop(&r);
    return plan.emission;
}

static void test_automatic_emission(void** state) {
    (void)state;
    assert_int_equal(automatic(true, true, DGB_ORACLE_REPROJECT, 2), DGB_EMISSION_VERTEX);
    assert_int_equal(automatic(true, false, DGB_ORACLE_REPROJECT, 2), DGB_EMISSION_GEOMETRY);
    assert_int_equal(automatic(false, true, DGB_ORACLE_PREVIOUS, 2), DGB_EMISSION_VERTEX);
    assert_int_equal(automatic(false, false, DGB_ORACLE_PREVIOUS, 2), DGB_EMISSION_SEPARATE);
    assert_int_equal(automatic(true, true, DGB_ORACLE_PEEL, 2), DGB_EMISSION_SEPARATE);
    assert_int_equal(automatic(true, true, DGB_ORACLE_REPROJECT, 1), DGB_EMISSION_SEPARATE);
    assert_int_equal(automatic(true, true, DGB_ORACLE_DEFAULT, 1), DGB_EMISSION_SEPARATE);
    assert_int_equal(automatic(true, true, DGB_ORACLE_PREDICT, 8), DGB_EMISSION_VERTEX);
    assert_int_equal(automatic(true, false, DGB_ORACLE_DELAY, 3), DGB_EMISSION_GEOMETRY);
    assert_int_equal(automatic(true, true, DGB_ORACLE_DELAY, 1), DGB_EMISSION_SEPARATE);
}

/* >> refusals */

typedef struct logged {
    int count;
    dgb_result result;
    dgb_log_item item;
    const char* sentence;
} logged;

static void on_log(void* user, dgb_result result, dgb_log_item item, const char* sentence) {
    logged* log = (logged*)user;
    log->result = result;
    log->item = item;
    log->sentence = sentence;
    ++log->count;
}

static const dgb_backend weak_device = {.caps = {.max_size = 512, .max_layers = 4}};
static const dgb_backend one_layer = {.caps = {.max_size = 512, .max_layers = 1}};

static const dgb_backend no_viewports = {
    .caps = {.max_size = 512, .max_layers = 4, .emission = {[DGB_EMISSION_SEPARATE] = true}}};

#define SIZE .width = 64, .height = 48
#define BAD(enumeration) (enumeration)(-1)

static const struct {
    const char* what;
    dgb_desc desc;
    dgb_result result;
    dgb_log_item item;
} refusals[] = {
    {"no size", {.layers = 2}, DGB_INVALID, DGB_LOG_SIZE},
    {"width 0", {.height = 48}, DGB_INVALID, DGB_LOG_SIZE},
    {"height 0", {.width = 64}, DGB_INVALID, DGB_LOG_SIZE},
    {"width -1", {.width = -1, .height = 48}, DGB_INVALID, DGB_LOG_SIZE},
    {"height INT_MIN", {.width = 64, .height = INT_MIN}, DGB_INVALID, DGB_LOG_SIZE},
    {"width 16385", {.width = 16385, .height = 48}, DGB_INVALID, DGB_LOG_SIZE},
    {"height INT_MAX", {.width = 64, .height = INT_MAX}, DGB_INVALID, DGB_LOG_SIZE},
    {"guard band -1", {SIZE, .guard_band = -1}, DGB_INVALID, DGB_LOG_GUARD_BAND},
    {"guard band 8161", {SIZE, .guard_band = 8161}, DGB_INVALID, DGB_LOG_GUARD_BAND},
    {"guard band INT_MAX", {SIZE, .guard_band = INT_MAX}, DGB_INVALID, DGB_LOG_GUARD_BAND},
    {"guard band INT_MIN", {SIZE, .guard_band = INT_MIN}, DGB_INVALID, DGB_LOG_GUARD_BAND},
    {"16384 and 1", {.width = 16384, .height = 1, .guard_band = 1}, DGB_INVALID, DGB_LOG_GUARD_BAND},
    {"1 by 16384 and 1", {.width = 1, .height = 16384, .guard_band = 1}, DGB_INVALID, DGB_LOG_GUARD_BAND},
    {"device of 512",
     {.width = 500, .height = 48, .guard_band = 7, .backend = &weak_device},
     DGB_INVALID,
     DGB_LOG_GUARD_BAND},
    {"layers -1", {SIZE, .layers = -1}, DGB_INVALID, DGB_LOG_LAYERS},
    {"layers 9", {SIZE, .layers = 9}, DGB_INVALID, DGB_LOG_LAYERS},
    {"3 of the engine's", {SIZE, .layers = 3, .source = DGB_SOURCE_ENGINE}, DGB_INVALID, DGB_LOG_LAYERS},
    {"5 of 4 layers", {SIZE, .layers = 5, .backend = &weak_device}, DGB_INVALID, DGB_LOG_LAYERS},
    {"default layers of 1", {SIZE, .backend = &one_layer}, DGB_INVALID, DGB_LOG_LAYERS},
    {"bounces of nothing", {SIZE, .effects = DGB_EFFECT_BOUNCES}, DGB_INVALID, DGB_LOG_EFFECTS},
    {"bounces of occlusion", {SIZE, .effects = DGB_EFFECT_AO | DGB_EFFECT_BOUNCES}, DGB_INVALID, DGB_LOG_EFFECTS},
    {"directions of the paper's estimator",
     {SIZE, .effects = DGB_EFFECT_AO | DGB_EFFECT_BENT},
     DGB_INVALID,
     DGB_LOG_EFFECTS},
    {"directions without occlusion",
     {SIZE, .effects = DGB_EFFECT_RADIOSITY | DGB_EFFECT_BENT, .estimator = DGB_ESTIMATOR_BITMASK},
     DGB_INVALID,
     DGB_LOG_EFFECTS},
    {"temporal filter of nothing", {SIZE, .effects = DGB_EFFECT_TEMPORAL}, DGB_INVALID, DGB_LOG_EFFECTS},
    {"temporal filter of bounces",
     {SIZE, .effects = DGB_EFFECT_BOUNCES | DGB_EFFECT_TEMPORAL},
     DGB_INVALID,
     DGB_LOG_EFFECTS},
    {"effect 128", {SIZE, .effects = 128 | DGB_EFFECT_AO}, DGB_INVALID, DGB_LOG_EFFECTS},
    {"glossy alone", {SIZE, .effects = DGB_EFFECT_GLOSSY | DGB_EFFECT_AO}, DGB_INVALID, DGB_LOG_EFFECTS},
    {"glossy over time, no velocity",
     {SIZE, .effects = GLOSSY | DGB_EFFECT_TEMPORAL, .targets = DGB_TARGET_NORMAL | DGB_TARGET_RADIANCE},
     DGB_INVALID,
     DGB_LOG_TARGETS},
    {"bounces, no albedo",
     {SIZE, .effects = 2 | DGB_EFFECT_BOUNCES, .targets = DGB_TARGET_ALL & ~DGB_TARGET_ALBEDO},
     DGB_INVALID,
     DGB_LOG_TARGETS},
    {"bounces, no velocity",
     {SIZE, .effects = 2 | DGB_EFFECT_BOUNCES, .targets = DGB_TARGET_ALL & ~DGB_TARGET_VELOCITY},
     DGB_INVALID,
     DGB_LOG_TARGETS},
    {"temporal filter of occlusion, no velocity",
     {SIZE, .effects = DGB_EFFECT_AO | DGB_EFFECT_TEMPORAL, .targets = DGB_TARGET_NORMAL},
     DGB_INVALID,
     DGB_LOG_TARGETS},
    {"temporal filter of light, no velocity",
     {SIZE, .effects = 2 | DGB_EFFECT_TEMPORAL, .targets = DGB_TARGET_NORMAL | DGB_TARGET_RADIANCE},
     DGB_INVALID,
     DGB_LOG_TARGETS},
    {"temporal filter of reflections",
     {SIZE, .effects = DGB_EFFECT_REFLECT | DGB_EFFECT_TEMPORAL},
     DGB_INVALID,
     DGB_LOG_EFFECTS},
    {"reflections, no radiance",
     {SIZE, .effects = DGB_EFFECT_REFLECT, .targets = DGB_TARGET_NORMAL},
     DGB_INVALID,
     DGB_LOG_TARGETS},
    {"reflections of bounced light, no albedo",
     {SIZE, .effects = 2 | DGB_EFFECT_REFLECT, .targets = DGB_TARGET_ALL & ~DGB_TARGET_ALBEDO},
     DGB_INVALID,
     DGB_LOG_TARGETS},
    {"effect 2^31", {SIZE, .effects = 0x80000001u}, DGB_INVALID, DGB_LOG_EFFECTS},
    {"target 16", {SIZE, .targets = 16}, DGB_INVALID, DGB_LOG_TARGETS},
    {"ao, no normal", {SIZE, .effects = DGB_EFFECT_AO, .targets = DGB_TARGET_RADIANCE}, DGB_INVALID, DGB_LOG_TARGETS},
    {"light, no radiance",
     {SIZE, .effects = DGB_EFFECT_RADIOSITY, .targets = DGB_TARGET_NORMAL},
     DGB_INVALID,
     DGB_LOG_TARGETS},
    {"light, no normal",
     {SIZE, .effects = DGB_EFFECT_RADIOSITY, .targets = DGB_TARGET_RADIANCE},
     DGB_INVALID,
     DGB_LOG_TARGETS},
    {"source", {SIZE, .source = BAD(dgb_source)}, DGB_INVALID, DGB_LOG_ENUM},
    {"source 2", {SIZE, .source = (dgb_source)2}, DGB_INVALID, DGB_LOG_ENUM},
    {"oracle", {SIZE, .oracle = BAD(dgb_oracle)}, DGB_INVALID, DGB_LOG_ENUM},
    {"oracle 6", {SIZE, .oracle = DGB_ORACLE_COUNT}, DGB_INVALID, DGB_LOG_ENUM},
    {"emission", {SIZE, .emission = BAD(dgb_emission)}, DGB_INVALID, DGB_LOG_ENUM},
    {"emission 7", {SIZE, .emission = DGB_EMISSION_COUNT, .backend = &weak_device}, DGB_INVALID, DGB_LOG_ENUM},
    {"clip", {SIZE, .clip = BAD(dgb_clip)}, DGB_INVALID, DGB_LOG_ENUM},
    {"clip 2", {SIZE, .clip = DGB_CLIP_COUNT}, DGB_INVALID, DGB_LOG_ENUM},
    {"normals", {SIZE, .normals = BAD(dgb_normals)}, DGB_INVALID, DGB_LOG_ENUM},
    {"normals 4", {SIZE, .normals = DGB_NORMALS_COUNT, .source = DGB_SOURCE_ENGINE}, DGB_INVALID, DGB_LOG_ENUM},
    {"senders", {SIZE, .senders = BAD(dgb_senders)}, DGB_INVALID, DGB_LOG_ENUM},
    {"senders 2", {SIZE, .senders = DGB_SENDERS_COUNT}, DGB_INVALID, DGB_LOG_ENUM},
    {"normaliser", {SIZE, .normaliser = BAD(dgb_normaliser)}, DGB_INVALID, DGB_LOG_ENUM},
    {"normaliser 2", {SIZE, .normaliser = DGB_NORMALISER_COUNT}, DGB_INVALID, DGB_LOG_ENUM},
    {"tracer", {SIZE, .tracer = BAD(dgb_tracer)}, DGB_INVALID, DGB_LOG_ENUM},
    {"tracer 2", {SIZE, .tracer = DGB_TRACER_COUNT}, DGB_INVALID, DGB_LOG_ENUM},
    {"estimator", {SIZE, .estimator = BAD(dgb_estimator)}, DGB_INVALID, DGB_LOG_ENUM},
    {"estimator 2", {SIZE, .estimator = DGB_ESTIMATOR_COUNT}, DGB_INVALID, DGB_LOG_ENUM},
    {"thickness", {SIZE, .thickness = BAD(dgb_thickness)}, DGB_INVALID, DGB_LOG_ENUM},
    {"thickness 3", {SIZE, .thickness = DGB_THICKNESS_COUNT}, DGB_INVALID, DGB_LOG_ENUM},
    {"depth in R32F", {SIZE, .depth_format = DGB_FORMAT_R32F}, DGB_INVALID, DGB_LOG_ENUM},
    {"depth format 13", {SIZE, .depth_format = DGB_FORMAT_COUNT}, DGB_INVALID, DGB_LOG_ENUM},
    {"depth format -1", {SIZE, .depth_format = BAD(dgb_format)}, DGB_INVALID, DGB_LOG_ENUM},
    {"peel by geometry",
     {SIZE, .oracle = DGB_ORACLE_PEEL, .emission = DGB_EMISSION_GEOMETRY},
     DGB_INVALID,
     DGB_LOG_PEEL_EMISSION},
    {"peel by vertex",
     {SIZE, .oracle = DGB_ORACLE_PEEL, .emission = DGB_EMISSION_VERTEX},
     DGB_INVALID,
     DGB_LOG_PEEL_EMISSION},
    {"peel by instanced geometry",
     {SIZE, .oracle = DGB_ORACLE_PEEL, .emission = DGB_EMISSION_INSTANCED_GEOMETRY},
     DGB_INVALID,
     DGB_LOG_PEEL_EMISSION},
    {"peel by image",
     {SIZE, .oracle = DGB_ORACLE_PEEL, .emission = DGB_EMISSION_IMAGE},
     DGB_INVALID,
     DGB_LOG_PEEL_EMISSION},
    {"peel by multicast",
     {SIZE, .oracle = DGB_ORACLE_PEEL, .emission = DGB_EMISSION_MULTICAST},
     DGB_INVALID,
     DGB_LOG_PEEL_EMISSION},
    {"divisor 3", {SIZE, .divisor = 3}, DGB_INVALID, DGB_LOG_DIVISOR},
    {"divisor 8", {SIZE, .divisor = 8}, DGB_INVALID, DGB_LOG_DIVISOR},
    {"divisor -1", {SIZE, .divisor = -1}, DGB_INVALID, DGB_LOG_DIVISOR},
    {"divisor -2", {SIZE, .divisor = -2}, DGB_INVALID, DGB_LOG_DIVISOR},
    {"divisor INT_MIN", {SIZE, .divisor = INT_MIN}, DGB_INVALID, DGB_LOG_DIVISOR},
    {"divisor INT_MAX", {SIZE, .divisor = INT_MAX}, DGB_INVALID, DGB_LOG_DIVISOR},
    {"divisor 4 of 3 rows", {.width = 64, .height = 3, .divisor = 4}, DGB_INVALID, DGB_LOG_DIVISOR},
    {"divisor 2 of 1 column", {.width = 1, .height = 48, .divisor = 2}, DGB_INVALID, DGB_LOG_DIVISOR},
    {"divisor 2 by image", {SIZE, .divisor = 2, .emission = DGB_EMISSION_IMAGE}, DGB_INVALID, DGB_LOG_DIVISOR},
    {"divisor 4 by multicast", {SIZE, .divisor = 4, .emission = DGB_EMISSION_MULTICAST}, DGB_INVALID, DGB_LOG_DIVISOR},
    {"no viewport for divisor 2",
     {SIZE, .divisor = 2, .backend = &weak_device},
     DGB_UNSUPPORTED,
     DGB_LOG_DEEP_VIEWPORT},
    {"no viewport for divisor 4, separate",
     {SIZE, .divisor = 4, .emission = DGB_EMISSION_SEPARATE, .backend = &no_viewports},
     DGB_UNSUPPORTED,
     DGB_LOG_DEEP_VIEWPORT},
    {"instanced geometry not there",
     {SIZE, .emission = DGB_EMISSION_INSTANCED_GEOMETRY, .backend = &weak_device},
     DGB_UNSUPPORTED,
     DGB_LOG_EMISSION},
    {"image not there",
     {SIZE, .emission = DGB_EMISSION_IMAGE, .backend = &weak_device},
     DGB_UNSUPPORTED,
     DGB_LOG_EMISSION},
    {"multicast not there",
     {SIZE, .emission = DGB_EMISSION_MULTICAST, .backend = &weak_device},
     DGB_UNSUPPORTED,
     DGB_LOG_EMISSION},
    {"engine and divisor", {SIZE, .source = DGB_SOURCE_ENGINE, .divisor = 2}, DGB_INVALID, DGB_LOG_SOURCE_OPTIONS},
    {"engine and divisor -1", {SIZE, .source = DGB_SOURCE_ENGINE, .divisor = -1}, DGB_INVALID, DGB_LOG_SOURCE_OPTIONS},
    {"engine and delay",
     {SIZE, .source = DGB_SOURCE_ENGINE, .oracle = DGB_ORACLE_DELAY},
     DGB_INVALID,
     DGB_LOG_SOURCE_OPTIONS},
    {"engine and image",
     {SIZE, .source = DGB_SOURCE_ENGINE, .emission = DGB_EMISSION_IMAGE},
     DGB_INVALID,
     DGB_LOG_SOURCE_OPTIONS},
    {"geometry not there",
     {SIZE, .emission = DGB_EMISSION_GEOMETRY, .backend = &weak_device},
     DGB_UNSUPPORTED,
     DGB_LOG_EMISSION},
    {"vertex not there",
     {SIZE, .emission = DGB_EMISSION_VERTEX, .backend = &weak_device},
     DGB_UNSUPPORTED,
     DGB_LOG_EMISSION},
    {"clip not there", {SIZE, .clip = DGB_CLIP_ZERO_TO_ONE, .backend = &weak_device}, DGB_UNSUPPORTED, DGB_LOG_CLIP},
    {"engine and oracle",
     {SIZE, .source = DGB_SOURCE_ENGINE, .oracle = DGB_ORACLE_PREVIOUS},
     DGB_INVALID,
     DGB_LOG_SOURCE_OPTIONS},
    {"engine and emission",
     {SIZE, .source = DGB_SOURCE_ENGINE, .emission = DGB_EMISSION_SEPARATE},
     DGB_INVALID,
     DGB_LOG_SOURCE_OPTIONS},
    {"engine and targets",
     {SIZE, .source = DGB_SOURCE_ENGINE, .targets = DGB_TARGET_NORMAL},
     DGB_INVALID,
     DGB_LOG_SOURCE_OPTIONS},
};

static void test_refusals(void** state) {
    size_t i;
    (void)state;
    for (i = 0; i < sizeof refusals / sizeof refusals[0]; ++i) {
        dgb_desc d = refusals[i].desc;
        logged log = {0};
        dgb_plan plan, before;
        dgb_result result;
        memset(&plan, 0x5a, sizeof plan);
        memcpy(&before, &plan, sizeof plan);
        d.log = on_log;
        d.log_user = &log;
        result = dgb_make_plan(&d, &plan);
        if (result != refusals[i].result || log.result != result || log.count != 1 || log.item != refusals[i].item)
            fail_msg("%s: %s, %d logged, %s", refusals[i].what, dgb_result_name(result), log.count,
                     dgb_log_item_name(log.item));
        if (!log.sentence || strlen(log.sentence) < 10) fail_msg("%s: no sentence", refusals[i].what);
        if (!same_bits(&plan, &before, sizeof plan)) fail_msg("%s: the plan changed", refusals[i].what);
        d.log = NULL; /* nobody need listen */
        assert_int_equal(dgb_make_plan(&d, &plan), refusals[i].result);
    }
}

/* Every combination is taken or refused as it should be, for the right reason. */
static void check_verdict(const dgb_desc* desc) {
    const dgb_log_item item = expected_item(desc);
    dgb_desc d = *desc;
    logged log = {0};
    dgb_plan plan;
    dgb_result result;
    d.log = on_log;
    d.log_user = &log;
    result = dgb_make_plan(&d, &plan);
    if (result != (item ? DGB_INVALID : DGB_OK) || log.item != item || log.count != (item != DGB_LOG_NONE))
        fail_msg("source %d, layers %d, oracle %s, emission %s, divisor %d: %s, %s, not %s", (int)d.source, d.layers,
                 dgb_oracle_name(d.oracle), dgb_emission_name(d.emission), d.divisor, dgb_result_name(result),
                 dgb_log_item_name(log.item), dgb_log_item_name(item));
}

static void test_every_combination_has_its_verdict(void** state) {
    (void)state;
    for_every_desc(check_verdict);
}

/* No reason that a plan can be refused for goes without a row in the table. */
static void test_every_refusal_is_tried(void** state) {
    static const dgb_log_item of_a_desc[] = {DGB_LOG_SIZE,    DGB_LOG_GUARD_BAND,     DGB_LOG_LAYERS,
                                             DGB_LOG_EFFECTS, DGB_LOG_TARGETS,        DGB_LOG_ENUM,
                                             DGB_LOG_CLIP,    DGB_LOG_EMISSION,       DGB_LOG_PEEL_EMISSION,
                                             DGB_LOG_DIVISOR, DGB_LOG_SOURCE_OPTIONS, DGB_LOG_DEEP_VIEWPORT};
    bool tried[DGB_LOG_COUNT] = {false};
    size_t i;
    (void)state;
    for (i = 0; i < sizeof refusals / sizeof refusals[0]; ++i) tried[refusals[i].item] = true;
    for (i = 0; i < sizeof of_a_desc / sizeof of_a_desc[0]; ++i)
        if (!tried[of_a_desc[i]]) fail_msg("nothing trips %s", dgb_log_item_name(of_a_desc[i]));
}

/* The other side of every limit. */
static void test_limits_are_inclusive(void** state) {
    static const dgb_desc descs[] = {
        {SIZE, .guard_band = 8160},
        {.width = 16384, .height = 16384},
        {.width = 498, .height = 498, .guard_band = 7, .layers = 4, .backend = &weak_device},
        {SIZE, .layers = 8},
        {SIZE, .layers = 1, .backend = &one_layer},
        {SIZE, .layers = 2, .source = DGB_SOURCE_ENGINE},
        {SIZE, .layers = 2, .source = DGB_SOURCE_ENGINE, .backend = &one_layer}, /* 2D textures, no array */
        {SIZE, .source = DGB_SOURCE_ENGINE, .clip = DGB_CLIP_ZERO_TO_ONE, .backend = &weak_device}, /* no clip to set */
        {SIZE, .effects = DGB_EFFECT_AO, .targets = DGB_TARGET_NORMAL},
        {SIZE, .effects = DGB_EFFECT_RADIOSITY, .targets = DGB_TARGET_NORMAL | DGB_TARGET_RADIANCE},
        {SIZE, .effects = DGB_EFFECT_AO | DGB_EFFECT_TEMPORAL, .targets = DGB_TARGET_NORMAL | DGB_TARGET_VELOCITY},
        {SIZE, .effects = 2 | DGB_EFFECT_TEMPORAL, .targets = DGB_TARGET_ALL & ~DGB_TARGET_ALBEDO},
        {SIZE, .effects = DGB_EFFECT_REFLECT, .targets = DGB_TARGET_NORMAL | DGB_TARGET_RADIANCE},
        {SIZE, .effects = 2 | DGB_EFFECT_REFLECT, .targets = DGB_TARGET_ALL & ~DGB_TARGET_VELOCITY},
        {SIZE, .effects = GLOSSY, .targets = DGB_TARGET_NORMAL | DGB_TARGET_RADIANCE},
        {SIZE, .effects = GLOSSY | DGB_EFFECT_TEMPORAL, .targets = DGB_TARGET_ALL & ~DGB_TARGET_ALBEDO},
        {SIZE, .effects = ALL_EFFECTS, .targets = DGB_TARGET_ALL},
        {SIZE, .effects = ALL_EFFECTS, .layers = 8},
        {SIZE, .oracle = DGB_ORACLE_PEEL, .emission = DGB_EMISSION_SEPARATE},
        {SIZE, .oracle = DGB_ORACLE_PEEL, .divisor = 4},
        {SIZE, .divisor = 1, .emission = DGB_EMISSION_IMAGE},
        {SIZE, .divisor = 1, .source = DGB_SOURCE_ENGINE},
        {SIZE, .divisor = 1, .backend = &no_viewports},
        {.width = 4, .height = 4, .divisor = 4},
        {.width = 1, .height = 2, .guard_band = 1, .divisor = 2}, /* the guard band counts */
    };
    size_t i;
    (void)state;
    for (i = 0; i < sizeof descs / sizeof descs[0]; ++i) {
        dgb_desc d = descs[i];
        logged log = {0};
        dgb_plan plan;
        d.log = on_log;
        d.log_user = &log;
        if (dgb_make_plan(&d, &plan) != DGB_OK || log.count)
            fail_msg("row %d is refused: %s", (int)i, dgb_log_item_name(log.item));
    }
}

static void test_null_arguments(void** state) {
    logged log = {0};
    dgb_desc d = small_desc(2, 0);
    dgb_plan plan;
    (void)state;
    d.log = on_log;
    d.log_user = &log;
    assert_int_equal(dgb_make_plan(NULL, &plan), DGB_INVALID);
    assert_int_equal(dgb_make_plan(NULL, NULL), DGB_INVALID);
    assert_int_equal(log.count, 0);
    assert_int_equal(dgb_make_plan(&d, NULL), DGB_INVALID);
    assert_int_equal(log.count, 1);
    assert_int_equal(log.item, DGB_LOG_NULL_ARGUMENT);
}

/* >> names */

static void test_names(void** state) {
    int i, k;
    (void)state;
    assert_string_equal(dgb_result_name(DGB_OK), "DGB_OK");
    assert_string_equal(dgb_result_name(DGB_DEVICE), "DGB_DEVICE");
    assert_string_equal(dgb_result_name((dgb_result)(DGB_DEVICE + 1)), "?");
    assert_string_equal(dgb_result_name((dgb_result)-1), "?");
    assert_string_equal(dgb_log_item_name(DGB_LOG_NONE), "NONE");
    assert_string_equal(dgb_log_item_name(DGB_LOG_SIZE), "SIZE");
    assert_string_equal(dgb_log_item_name(DGB_LOG_NO_LAYERS), "NO_LAYERS");
    assert_string_equal(dgb_log_item_name(DGB_LOG_COUNT), "?");
    assert_string_equal(dgb_slot_name(DGB_AO_RAW), "ao_raw");
    assert_string_equal(dgb_slot_name(DGB_IRRADIANCE), "irradiance");
    assert_string_equal(dgb_slot_name(DGB_SLOT_COUNT), "?");
    assert_string_equal(dgb_pass_name(DGB_PASS_GATHER), "gather");
    assert_string_equal(dgb_pass_name(DGB_PASS_REFLECT), "reflect");
    assert_string_equal(dgb_pass_name(DGB_PASS_GLOSSY), "glossy");
    assert_string_equal(dgb_pass_name(DGB_PASS_COUNT), "?");
    assert_string_equal(dgb_format_name(DGB_FORMAT_RG32F), "RG32F");
    assert_string_equal(dgb_format_name(DGB_FORMAT_D32F), "D32F");
    assert_string_equal(dgb_format_name(DGB_FORMAT_COUNT), "?");
    assert_string_equal(dgb_oracle_name(DGB_ORACLE_REPROJECT), "reproject");
    assert_string_equal(dgb_oracle_name(DGB_ORACLE_COUNT), "?");
    assert_string_equal(dgb_oracle_name(DGB_ORACLE_PREDICT), "predict");
    assert_string_equal(dgb_oracle_name(DGB_ORACLE_DELAY), "delay");
    assert_string_equal(dgb_oracle_name(DGB_ORACLE_WARP), "warp");
    assert_string_equal(dgb_pass_name(DGB_PASS_WARP), "warp");
    assert_string_equal(dgb_pass_name(DGB_PASS_RESOLVE), "resolve");
    assert_string_equal(dgb_pass_name(DGB_PASS_PREDICT), "predict");
    assert_string_equal(dgb_pass_name(DGB_PASS_RECONSTRUCT), "reconstruct");
    assert_string_equal(dgb_format_name(DGB_FORMAT_R32UI), "R32UI");
    assert_string_equal(dgb_format_name(DGB_FORMAT_RG32UI), "RG32UI");
    assert_string_equal(dgb_format_name(DGB_FORMAT_RGBA32UI), "RGBA32UI");
    assert_string_equal(dgb_slot_name(DGB_PREDICTED), "predicted");
    assert_string_equal(dgb_slot_name(DGB_KEY), "key");
    assert_string_equal(dgb_emission_name(DGB_EMISSION_INSTANCED_GEOMETRY), "instanced-geometry");
    assert_string_equal(dgb_emission_name(DGB_EMISSION_IMAGE), "image");
    assert_string_equal(dgb_emission_name(DGB_EMISSION_MULTICAST), "multicast");
    assert_string_equal(dgb_emission_name(DGB_EMISSION_VERTEX), "vertex");
    assert_string_equal(dgb_emission_name(DGB_EMISSION_COUNT), "?");
    for (i = 0; i < DGB_SLOT_COUNT; ++i)
        for (k = 0; k < i; ++k) assert_string_not_equal(dgb_slot_name((dgb_slot)i), dgb_slot_name((dgb_slot)k));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_golden_plans),
        cmocka_unit_test(test_effects_that_are_off_cost_nothing),
        cmocka_unit_test(test_passes_connect),
        cmocka_unit_test(test_bytes_add_up),
        cmocka_unit_test(test_plans_keep_their_limits),
        cmocka_unit_test(test_constructions_bring_what_they_need),
        cmocka_unit_test(test_160_bits),
        cmocka_unit_test(test_bytes_of_k_layers),
        cmocka_unit_test(test_bytes_of_the_largest),
        cmocka_unit_test(test_bytes_of_history),
        cmocka_unit_test(test_odd_sizes),
        cmocka_unit_test(test_depth_formats),
        cmocka_unit_test(test_targets),
        cmocka_unit_test(test_senders_choose_the_program),
        cmocka_unit_test(test_tracer),
        cmocka_unit_test(test_back),
        cmocka_unit_test(test_estimator),
        cmocka_unit_test(test_bent),
        cmocka_unit_test(test_divisor),
        cmocka_unit_test(test_automatic_emission),
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_every_combination_has_its_verdict),
        cmocka_unit_test(test_every_refusal_is_tried),
        cmocka_unit_test(test_limits_are_inclusive),
        cmocka_unit_test(test_null_arguments),
        cmocka_unit_test(test_names),
    };
    return cmocka_run_group_tests_name("plan", tests, NULL, NULL);
}
