/* What the full-screen passes cost on a GPU, without a GPU: every variant is compiled for NAVI21 by Mesa's RADV, and
   none is run.
       gpu_cost [DIRECTORY]      default build; writes DIRECTORY/gpu_cost.csv, and the shaders to DIRECTORY/gpu_cost/
   Where the driver or glslangValidator is missing it says so, writes no table and ends well. */
#define _POSIX_C_SOURCE 200112L /* mkdir */
#define DEEPGBUFFER_IMPLEMENTATION
#include "deepgbuffer.h"
#include "deepgbuffer_gl.h"
#include "driver.h"
#include "isa.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static void fail(const char* what, const char* why) {
    fprintf(stderr, "gpu_cost: %s: %s\n", what, why);
    exit(1);
}

/* >> how often loops run */

/* A ray goes on until it hits something, so this is no more than an assumption. */
enum { ASSUMED_REFLECT_STEPS = 20 };
/* Rows and columns of tiles that are looked at one by one: 64 pixels each way around a tile of 16. */
enum { TILES_ACROSS = 10 };
enum { HILBERT_BITS = 6 }; /* of each coordinate, in dgb_hilbert_index */

static int define_of(const dgb_program_desc* p, const char* name) {
    int i;
    for (i = 0; i < p->define_count; ++i)
        if (strcmp(p->defines[i].name, name) == 0) return p->defines[i].value;
    return 0;
}

/* The two estimators share the passes; only the bitmask's programs have the define, whatever its value. */
static bool is_bitmask(const dgb_program_desc* p) {
    int i;
    for (i = 0; i < p->define_count; ++i)
        if (strcmp(p->defines[i].name, "DGB_BITMASK_LIGHT") == 0) return true;
    return false;
}

/* The bits of the pixel's place along the Hilbert curve; then, for each layer that receives, slices, to both sides, and
   within them the steps of all. */
static int find_bitmask_trips(const dgb_program_desc* p, const dgb_params* q, double trips[ISA_MAX_LOOPS]) {
    const int receivers = 1 + define_of(p, "DGB_DEEP"), sides = 2 * q->slices;
    const int taps = p->pass == DGB_PASS_AO ? q->ao_samples : q->samples;
    int k;
    trips[0] = HILBERT_BITS;
    for (k = 0; k < receivers; ++k) {
        trips[1 + 2 * k] = sides;
        trips[2 + 2 * k] = sides * (taps > sides ? taps / sides : 1);
    }
    return 1 + 2 * receivers;
}

/* Trips of each loop of a pass in the order of the text, in all, and how many loops there are. The gather's taps have a
   loop for each thing that the second layer may be in a tile: receiver, sender, of no matter; those of occlusion have
   one, and a branch within it. all: it is all that this variant knows; else it is of no matter. */
static int find_trips(const dgb_program_desc* p, const dgb_params* q, bool all, double trips[ISA_MAX_LOOPS]) {
    const int layers = define_of(p, "DGB_LAYERS"), deep = define_of(p, "DGB_DEEP");
    const int step = define_of(p, "DGB_TILES_STEP");
    const int tap_loops = p->pass == DGB_PASS_AO ? 1 : layers + deep;
    const int taps_on_a_side = q->filter_taps / 2;
    int count = 0, k;
    if (is_bitmask(p)) return find_bitmask_trips(p, q, trips);
    switch (p->pass) {
    case DGB_PASS_TILES:
        if (step == 0) trips[count++] = 1 << 4; /* rows of pixels; those of a row are unrolled */
        for (k = 0; step == 2 && k < 2; ++k) {  /* for occlusion, for light */
            trips[count++] = TILES_ACROSS;
            trips[count++] = TILES_ACROSS * TILES_ACROSS;
        }
        return count;
    case DGB_PASS_AO:
    case DGB_PASS_GATHER:
        for (k = 0; k < tap_loops; ++k) trips[k] = 0;
        trips[all ? 0 : tap_loops - 1] = p->pass == DGB_PASS_AO ? q->ao_samples : q->samples;
        return tap_loops;
    case DGB_PASS_TEMPORAL: /* bilinear: four texels */
        for (k = 0; k <= deep; ++k) trips[k] = 4;
        return 1 + deep;
    case DGB_PASS_RECONSTRUCT: /* a tap on either side */
        for (k = 0; k <= deep; ++k) trips[k] = taps_on_a_side;
        return 1 + deep;
    case DGB_PASS_REFLECT: /* until something is hit; to refine that; further, where it does not stand */
        trips[0] = ASSUMED_REFLECT_STEPS;
        trips[1] = 1;
        trips[2] = 0;
        return 3;
    default: return 0;
    }
}

/* >> compilation */

enum { MAX_TEXT = 1 << 16, MAX_WORDS = 1 << 17 };

typedef struct compiler {
    driver gpu;
    char directory[512]; /* of the shaders */
    uint32_t vertex_words[MAX_WORDS], fragment_words[MAX_WORDS];
    size_t vertex_count;
} compiler;

typedef struct variant {
    const dgb_program_desc* program;
    const dgb_plan_pass* pass;
    const dgb_plan* plan;
    char name[160];
    driver_code code;
    isa_code isa;
    double texel_bytes[ISA_MAX_TEXTURES]; /* by binding */
} variant;

/* "DGB_NORMAL_TEST" 1 becomes " normal_test=1"; what is off is left out, as is the resolution, which is full
   everywhere. */
static void name_variant(const dgb_program_desc* p, char* name, size_t capacity) {
    size_t used = (size_t)snprintf(name, capacity, "%s", dgb_pass_name(p->pass));
    int i;
    char* c;
    for (i = 0; i < p->define_count; ++i) {
        const dgb_define d = p->defines[i];
        const bool says_nothing =
            d.value == 0 && strcmp(d.name, "DGB_TILES_STEP") != 0 && strcmp(d.name, "DGB_BITMASK_LIGHT") != 0;
        if (says_nothing || strcmp(d.name, "DGB_DIVISOR") == 0) continue;
        used += (size_t)snprintf(name + used, capacity - used, " %s=%d", d.name + strlen("DGB_"), d.value);
    }
    for (c = name; *c; ++c)
        if (*c >= 'A' && *c <= 'Z') *c = (char)(*c - 'A' + 'a');
}

static void write_text(const char* path, const char* text, size_t length) {
    FILE* file = fopen(path, "wb");
    if (!file || fwrite(text, 1, length, file) != length || fclose(file)) fail(path, "cannot write");
}

static size_t read_words(const char* path, uint32_t* words) {
    FILE* file = fopen(path, "rb");
    const size_t count = file ? fread(words, sizeof *words, MAX_WORDS, file) : 0;
    if (count == 0 || count == MAX_WORDS) fail(path, "cannot read");
    fclose(file);
    return count;
}

/* OpenGL's GLSL to SPIR-V: textures get the bindings 0, 1, ... and the uniform block one behind them all. */
static size_t translate(const compiler* c, const dgb_program_desc* p, dgbgl_stage stage, uint32_t* words) {
    static char text[MAX_TEXT];
    const char* extension = stage == DGBGL_VERTEX ? "vert" : "frag";
    char source[600], binary[600], command[2048];
    const size_t length = dgbgl_pass_source(p, stage, 450, false, text, sizeof text);
    if (length >= sizeof text) fail(dgb_pass_name(p->pass), "the text is too long");
    snprintf(source, sizeof source, "%s/shader.%s", c->directory, extension);
    snprintf(binary, sizeof binary, "%s/%s.spv", c->directory, extension);
    write_text(source, text, length);
    snprintf(command, sizeof command,
             "glslangValidator -V -R --target-env vulkan1.1 --auto-map-bindings --auto-map-locations "
             "--shift-ubo-binding %d -o '%s' '%s' >'%s/log'",
             ISA_MAX_TEXTURES, binary, source, c->directory);
    if (system(command) != 0) fail(source, "glslangValidator refuses it"); /* NOLINT: the command is our own */
    return read_words(binary, words);
}

static VkFormat vulkan_format(dgb_format format) {
    switch (format) {
    case DGB_FORMAT_R8: return VK_FORMAT_R8_UNORM;
    case DGB_FORMAT_RG8: return VK_FORMAT_R8G8_UNORM;
    case DGB_FORMAT_RGBA8: return VK_FORMAT_R8G8B8A8_UNORM;
    case DGB_FORMAT_R11G11B10F: return VK_FORMAT_B10G11R11_UFLOAT_PACK32;
    case DGB_FORMAT_RG16F: return VK_FORMAT_R16G16_SFLOAT;
    case DGB_FORMAT_RGBA16F: return VK_FORMAT_R16G16B16A16_SFLOAT;
    case DGB_FORMAT_R32F: return VK_FORMAT_R32_SFLOAT;
    case DGB_FORMAT_RG32F: return VK_FORMAT_R32G32_SFLOAT;
    case DGB_FORMAT_RGBA32F: return VK_FORMAT_R32G32B32A32_SFLOAT;
    case DGB_FORMAT_RG32UI: return VK_FORMAT_R32G32_UINT;
    case DGB_FORMAT_RGBA32UI: return VK_FORMAT_R32G32B32A32_UINT;
    default: fail(dgbi_formats[format].name, "not known to Vulkan here"); return VK_FORMAT_UNDEFINED;
    }
}

static dgb_format format_of(const dgb_plan* plan, dgb_slot slot) {
    int i;
    for (i = 0; i < plan->texture_count; ++i)
        if (plan->textures[i].slot == slot) return plan->textures[i].format;
    return DGB_FORMAT_NONE;
}

/* Bytes of a texel of what the pass binds to the sampler of that name; 0: nothing. */
static double texel_bytes(const variant* v, const char* sampler) {
    int i;
    for (i = 0; i < v->pass->input_count; ++i)
        if (strcmp(dgb_slot_name(v->pass->inputs[i].name), sampler + strlen("dgb_")) == 0)
            return dgbi_formats[format_of(v->plan, v->pass->inputs[i].texture)].bytes;
    return 0;
}

static void find_texel_bytes(variant* v, spirv_shader fragment) {
    spirv_resource resources[ISA_MAX_TEXTURES + 1];
    const int count = spirv_resources(fragment, resources, ISA_MAX_TEXTURES + 1);
    int i;
    for (i = 0; i < count; ++i)
        if (resources[i].is_texture && resources[i].binding < ISA_MAX_TEXTURES)
            v->texel_bytes[resources[i].binding] = texel_bytes(v, resources[i].name);
}

static void compile(compiler* c, variant* v) {
    VkFormat formats[DGB_MAX_TARGETS];
    spirv_shader vertex, fragment;
    const char* complaint;
    int i;
    if (!c->vertex_count) c->vertex_count = translate(c, v->program, DGBGL_VERTEX, c->vertex_words);
    vertex.words = c->vertex_words;
    vertex.count = c->vertex_count;
    fragment.words = c->fragment_words;
    fragment.count = translate(c, v->program, DGBGL_FRAGMENT, c->fragment_words);
    for (i = 0; i < v->pass->output_count; ++i) formats[i] = vulkan_format(format_of(v->plan, v->pass->outputs[i]));
    complaint = driver_compile(&c->gpu, vertex, fragment, formats, v->pass->output_count, &v->code);
    if (!complaint) complaint = isa_read(v->code.assembly, &v->isa);
    if (!complaint && (unsigned)v->isa.instruction_count != v->code.instructions)
        complaint = "the assembly has not as many instructions as the driver says";
    if (complaint) fail(v->name, complaint);
    find_texel_bytes(v, fragment);
}

/* >> figures */

typedef struct figures { /* for 64 pixels, fetches and bytes for one */
    double cycles, skippable, fetches, bytes;
} figures;

/* Loops whose count of trips is a constant may have been unrolled. */
static bool may_unroll(dgb_pass_id pass) { return pass == DGB_PASS_TILES || pass == DGB_PASS_TEMPORAL; }

/* Whether all branches are those that look at the second layer, which a tile where it is of no matter skips. The
   bitmask has others as well: what it saves there is not told. */
static bool tile_branches(const dgb_program_desc* p) { return p->pass == DGB_PASS_AO && !is_bitmask(p); }

static figures figures_of(const variant* v, const dgb_params* q, bool all) {
    double trips[ISA_MAX_LOOPS] = {0};
    const int loops = find_trips(v->program, q, all, trips), found = v->isa.loop_count;
    figures f = {0};
    isa_work work;
    int i;
    if (found != loops && !(found == 0 && may_unroll(v->program->pass)))
        fail(v->name, "the code has other loops than find_trips knows of");
    work = isa_sum(&v->isa, trips);
    f.cycles = isa_busy_cycles(&work) - (!all && tile_branches(v->program) ? work.skippable : 0);
    f.skippable = work.cycles[ISA_VECTOR] > 0 ? work.skippable / work.cycles[ISA_VECTOR] : 0;
    for (i = 0; i < ISA_MAX_TEXTURES; ++i) {
        if (work.fetches[i] > 0 && v->texel_bytes[i] == 0) fail(v->name, "it fetches from what the plan does not bind");
        f.fetches += work.fetches[i];
        f.bytes += work.fetches[i] * v->texel_bytes[i];
    }
    return f;
}

/* What the driver's own estimate should be if our account of the instructions is its. */
static double driver_estimate(const variant* v) {
    double trips[ISA_MAX_LOOPS];
    isa_work work;
    isa_assumed_trips(&v->isa, trips);
    work = isa_sum(&v->isa, trips);
    return isa_busy_cycles(&work);
}

/* >> table */

static const char* const preset_names[DGB_PRESET_COUNT] = {"performance", "balanced", "quality"};

static void print_header(const driver* gpu) {
    printf("NAVI21 code by Mesa's RADV, compiled, never run: %s, %s.\n\n", gpu->name, gpu->version);
    printf(
        "cycles     that 64 pixels keep the busiest unit busy, every branch taken, at the taps of preset BALANCED: "
        "those\n"
        "           outside of loops (once), and each loop's times its trips. Memory and occupancy do not count: the\n"
        "           figures compare shaders, and say nothing of milliseconds. A reflected ray is assumed to take %d "
        "steps.\n"
        "layer 0    cycles in a tile where the second layer cannot matter\n"
        "behind     share of the cycles that stand behind a branch, which a wave takes if any of its pixels does\n"
        "texels     fetched a pixel, and their bytes\n"
        "estimate   the driver's inverse throughput, which takes every loop for 8 trips and a branch for half or "
        "three\n"
        "           quarters of one; ours: the same count by our account, branches in full. Where nothing branches,\n"
        "           they agree: that proves the account.\n\n",
        ASSUMED_REFLECT_STEPS);
    printf("%-72s %5s %4s %4s %6s %7s %7s %7s %6s %6s %6s %7s %8s %7s\n", "pass and variant", "instr", "VGPR", "SGPR",
           "spills", "cycles", "once", "layer 0", "behind", "texels", "bytes", "latency", "estimate", "ours");
}

static void print_variant(const variant* v) {
    const dgb_params q = dgb_preset(DGB_PRESET_BALANCED);
    const figures all = figures_of(v, &q, true), first = figures_of(v, &q, false);
    printf("%-72s %5u %4u %4u %3u+%-2u %7.0f %7.0f %7.0f %5.0f%% %6.0f %6.0f %7u %8u %7.0f\n", v->name,
           v->code.instructions, v->code.vector_registers, v->code.scalar_registers, v->code.vector_spills,
           v->code.scalar_spills, all.cycles, isa_busy_cycles(&v->isa.once), first.cycles, 100.0 * all.skippable,
           all.fetches, all.bytes, v->code.latency, v->code.inverse_throughput, driver_estimate(v));
}

static void write_csv_header(FILE* csv) {
    int i;
    fprintf(csv, "pass,variant,instructions,vgprs,sgprs,vgpr_spills,sgpr_spills,latency,inverse_throughput,"
                 "our_inverse_throughput,cycles_once");
    for (i = 0; i < DGB_PRESET_COUNT; ++i)
        fprintf(csv, ",cycles_%s,cycles_layer_0_%s,fetches_%s,bytes_%s", preset_names[i], preset_names[i],
                preset_names[i], preset_names[i]);
    fprintf(csv, "\n");
}

static void write_csv_row(FILE* csv, const variant* v) {
    int i;
    fprintf(csv, "%s,%s,%u,%u,%u,%u,%u,%u,%u,%.0f,%.0f", dgb_pass_name(v->program->pass), v->name, v->code.instructions,
            v->code.vector_registers, v->code.scalar_registers, v->code.vector_spills, v->code.scalar_spills,
            v->code.latency, v->code.inverse_throughput, driver_estimate(v), isa_busy_cycles(&v->isa.once));
    for (i = 0; i < DGB_PRESET_COUNT; ++i) {
        const dgb_params q = dgb_preset((dgb_preset_id)i);
        const figures all = figures_of(v, &q, true), first = figures_of(v, &q, false);
        fprintf(csv, ",%.0f,%.0f,%.0f,%.0f", all.cycles, first.cycles, all.fetches, all.bytes);
    }
    fprintf(csv, "\n");
}

/* >> variants */

enum { MAX_VARIANTS = 128 };

typedef struct table {
    compiler compiler;
    FILE* csv;
    char names[MAX_VARIANTS][160]; /* that it has already */
    int count;
} table;

static void add_program(table* t, const dgb_plan* plan, const dgb_plan_pass* pass, int program) {
    variant v;
    int i;
    memset(&v, 0, sizeof v);
    v.plan = plan;
    v.pass = pass;
    v.program = &plan->programs[program];
    name_variant(v.program, v.name, sizeof v.name);
    for (i = 0; i < t->count; ++i)
        if (strcmp(t->names[i], v.name) == 0) return;
    if (t->count == MAX_VARIANTS) fail(v.name, "too many variants");
    memcpy(t->names[t->count++], v.name, sizeof v.name);
    compile(&t->compiler, &v);
    print_variant(&v);
    write_csv_row(t->csv, &v);
    free(v.code.assembly);
}

static void add_pass(table* t, const dgb_desc* desc, dgb_pass_id id) {
    static dgb_plan plan;
    int i;
    if (dgb_make_plan(desc, &plan) != DGB_OK) fail(dgb_pass_name(id), "there is no plan");
    for (i = 0; i < plan.pass_count; ++i) {
        if (plan.passes[i].id != id) continue;
        add_program(t, &plan, &plan.passes[i], plan.passes[i].program);
        if (id == DGB_PASS_GATHER) add_program(t, &plan, &plan.passes[i], plan.passes[i].program + 1); /* normal test */
    }
}

/* By pass, so that variants stand side by side. */
static void add_all(table* t) {
    static const dgb_pass_id passes[] = {DGB_PASS_PACK,   DGB_PASS_MIP,      DGB_PASS_TILES,       DGB_PASS_AO,
                                         DGB_PASS_GATHER, DGB_PASS_TEMPORAL, DGB_PASS_RECONSTRUCT, DGB_PASS_REFLECT};
    static const uint32_t light = DGB_EFFECT_RADIOSITY, bounces = DGB_EFFECT_RADIOSITY | DGB_EFFECT_BOUNCES;
    const uint32_t effects[] = {DGB_EFFECT_AO, light, DGB_EFFECT_AO | light | DGB_EFFECT_REFLECT,
                                DGB_EFFECT_AO | light | DGB_EFFECT_TEMPORAL,
                                DGB_EFFECT_AO | bounces | DGB_EFFECT_TEMPORAL};
    size_t p, e;
    for (p = 0; p < sizeof passes / sizeof passes[0]; ++p) {
        dgb_desc desc;
        memset(&desc, 0, sizeof desc);
        desc.width = 1920;
        desc.height = 1080;
        for (desc.layers = 1; desc.layers <= 2; ++desc.layers)
            for (e = 0; e < sizeof effects / sizeof effects[0]; ++e) {
                int senders;
                desc.effects = effects[e];
                desc.estimator = DGB_ESTIMATOR_BITMASK;
                desc.senders = DGB_SENDERS_BOTH;
                add_pass(t, &desc, passes[p]);
                desc.estimator = DGB_ESTIMATOR_PAPER;
                for (senders = 0; senders < (desc.layers > 1 ? DGB_SENDERS_COUNT : 1); ++senders) {
                    desc.senders = (dgb_senders)senders;
                    add_pass(t, &desc, passes[p]);
                }
            }
    }
}

static void skip(const char* why) {
    printf("gpu_cost: skipped: %s\n", why);
    exit(0);
}

int main(int argc, char** argv) {
    static table t;
    const char* directory = argc > 1 ? argv[1] : "build";
    const char* complaint;
    char path[600];
    snprintf(path, sizeof path, "%s/gpu_cost.csv", directory);
    remove(path); /* of an earlier run: what stays says that this one measured nothing */
    if (system("glslangValidator --version >/dev/null 2>&1") != 0) skip("glslangValidator is missing"); /* NOLINT */
    complaint = driver_open(&t.compiler.gpu);
    if (complaint) skip(complaint);
    snprintf(t.compiler.directory, sizeof t.compiler.directory, "%s/gpu_cost", directory);
    mkdir(directory, 0777);
    mkdir(t.compiler.directory, 0777);
    t.csv = fopen(path, "w");
    if (!t.csv) fail(path, "cannot write");
    print_header(&t.compiler.gpu);
    write_csv_header(t.csv);
    add_all(&t);
    fclose(t.csv);
    driver_close(&t.compiler.gpu);
    return 0;
}
