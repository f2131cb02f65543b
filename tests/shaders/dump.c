/* Writes the text of every shader there is, in every dialect, into a directory: NAME.vert, NAME.geom and NAME.frag, for an
   offline compiler. The variants come from the plans of every desc that changes them. */
#define DEEPGBUFFER_IMPLEMENTATION
#include "deepgbuffer.h"
#include "deepgbuffer_gl.h"
#include <stdio.h>
#include <stdlib.h>

static char text[1 << 16];

static void write_text(const char* directory, const char* name, const char* stage, size_t length) {
    char path[1024];
    FILE* file;
    if (length >= sizeof text) exit(2);
    snprintf(path, sizeof path, "%s/%s.%s", directory, name, stage);
    file = fopen(path, "w");
    if (!file || fwrite(text, 1, length, file) != length || fclose(file)) {
        perror(path);
        exit(2);
    }
}

static void write_program(const char* directory, const dgb_program_desc* p, int version, bool es) {
    char name[512];
    int used = snprintf(name, sizeof name, "%s_%s%d", dgb_pass_name(p->pass), es ? "es" : "gl", version), i;
    for (i = 0; i < p->define_count; ++i)
        used += snprintf(name + used, sizeof name - (size_t)used, "_%s%d", p->defines[i].name + 4, p->defines[i].value);
    write_text(directory, name, "vert", dgbgl_pass_source(p, DGBGL_VERTEX, version, es, text, sizeof text));
    write_text(directory, name, "frag", dgbgl_pass_source(p, DGBGL_FRAGMENT, version, es, text, sizeof text));
}

static void write_plan(const char* directory, const dgb_desc* desc) {
    dgb_plan plan;
    int i;
    if (dgb_make_plan(desc, &plan) != DGB_OK) exit(2);
    for (i = 0; i < plan.program_count; ++i) {
        write_program(directory, &plan.programs[i], 330, false);
        write_program(directory, &plan.programs[i], 450, false);
        write_program(directory, &plan.programs[i], 300, true);
    }
}

static void write_view_stage(const char* directory, const char* name, dgbgl_stage stage, int version, bool es) {
    dgbgli_text t = dgbgli_text_on(text, sizeof text);
    dgbgli_chunks c = {{NULL}, 0};
    int i;
    dgbgli_put_view_head(&t, version, es);
    dgbgli_view_chunks(stage, &c);
    for (i = 0; i < c.count; ++i) dgbgli_put(&t, c.pieces[i]);
    write_text(directory, name, stage == DGBGL_VERTEX ? "vert" : "frag", t.length);
}

/* The program of dgbgl_draw_view, which no plan has. */
static void write_view(const char* directory, int version, bool es) {
    char name[32];
    snprintf(name, sizeof name, "view_%s%d", es ? "es" : "gl", version);
    write_view_stage(directory, name, DGBGL_VERTEX, version, es);
    write_view_stage(directory, name, DGBGL_FRAGMENT, version, es);
}

typedef struct variant { /* of the snippets */
    dgb_emission emission;
    int version;
    bool es, interlock;
    bool back; /* faces: even one layer is compared with */
    int layers, divisor;
    uint32_t targets; /* 0: all */
} variant;

static void name_variant(const variant* v, char* name, size_t capacity) {
    snprintf(name, capacity, "layers_%s%d_%s_k%d%s_divisor%d%s_targets%u", v->es ? "es" : "gl", v->version,
             dgb_emission_name(v->emission), v->layers, v->back ? "_back" : "", v->divisor,
             v->interlock ? "_interlock" : "", (unsigned)v->targets);
}

/* The reference compiler knows the interlock qualifiers from this version on, though the extension asks for less. */
static void require_450(void) {
    static const char old_line[] = "#version 430", new_line[] = "#version 450";
    if (strncmp(text, old_line, strlen(old_line)) == 0) memcpy(text, new_line, strlen(new_line));
}

/* A program that contains the snippets and does nothing else: what an engine's simplest material is. */
static void write_snippets(const char* directory, const variant* v) {
    static dgbgl_backend gl;
    static dgb_context context;
    const dgbgl_varying varyings[] = {{NULL, "vec2", "v_uv"}, {"flat", "int", "v_material"}};
    char name[128];
    size_t length;
    dgb_desc desc;
    memset(&context, 0, sizeof context);
    memset(&desc, 0, sizeof desc);
    desc.width = desc.height = 64;
    desc.emission = v->emission;
    desc.layers = v->layers;
    desc.divisor = v->divisor;
    desc.targets = v->targets;
    if (dgb_make_plan(&desc, &context.plan) != DGB_OK) exit(2);
    context.desc = desc;
    gl.version = v->version;
    gl.es = v->es;
    gl.interlock = v->interlock;
    gl.layer_extension = "GL_ARB_shader_viewport_layer_array";
    context.backend.user = &gl;
    context.initialised = DGBI_INITIALISED;
    context.textures[DGB_DEPTH].id = 1;
    context.textures[DGB_BACK].id = v->back;
    name_variant(v, name, sizeof name);
    length = dgbgl_shader_prefix(&context, DGBGL_VERTEX, varyings, 2, text, sizeof text);
    length += (size_t)snprintf(text + length, sizeof text - length,
                               "in vec3 position; uniform mat4 now, before; out vec2 v_uv; flat out int v_material;\n"
                               "void main() {\n    v_uv = position.xy;\n    v_material = dgb_instance();\n"
                               "    dgb_vertex(now * vec4(position, 1.0), before * vec4(position, 1.0));\n}\n");
    write_text(directory, name, "vert", length);
    length = dgbgl_geometry_shader(&context, varyings, 2, text, sizeof text);
    if (length) write_text(directory, name, "geom", length);
    length = dgbgl_shader_prefix(&context, DGBGL_FRAGMENT, varyings, 2, text, sizeof text);
    length += (size_t)snprintf(
        text + length, sizeof text - length,
        "in vec2 v_uv; flat in int v_material;\nvoid main() {\n    if (!dgb_keep()) discard;\n"
        "    dgb_store(vec4(v_uv, float(v_material), 1.0), vec3(0.0, 0.0, 1.0), vec2(0.0), vec3(0.0));\n}\n");
    if (v->interlock) require_450();
    write_text(directory, name, "frag", length);
}

static void write_all_snippets(const char* directory) {
    static const struct {
        dgb_emission emission;
        int version;
        bool es, interlock;
        bool divides; /* takes a divisor */
    } emissions[] = {{DGB_EMISSION_SEPARATE, 330, false, false, true},
                     {DGB_EMISSION_SEPARATE, 450, false, false, true},
                     {DGB_EMISSION_SEPARATE, 300, true, false, false}, /* a viewport in whole pixels only */
                     {DGB_EMISSION_GEOMETRY, 330, false, false, false},
                     {DGB_EMISSION_GEOMETRY, 450, false, false, true},
                     {DGB_EMISSION_VERTEX, 450, false, false, true},
                     {DGB_EMISSION_INSTANCED_GEOMETRY, 450, false, false, true},
                     {DGB_EMISSION_INSTANCED_GEOMETRY, 410, false, false, true},
                     {DGB_EMISSION_IMAGE, 450, false, false, false},
                     {DGB_EMISSION_IMAGE, 450, false, true, false},
                     {DGB_EMISSION_MULTICAST, 450, false, false, false}};
    static const int layers[] = {1, 2, 3};
    static const uint32_t targets[] = {0, DGB_TARGET_NORMAL | DGB_TARGET_RADIANCE};
    size_t i, k, t;
    for (i = 0; i < sizeof emissions / sizeof emissions[0]; ++i)
        for (k = 0; k < sizeof layers / sizeof layers[0]; ++k)
            for (t = 0; t < sizeof targets / sizeof targets[0]; ++t) {
                variant v;
                /* one layer is always SEPARATE; an attachment more or less is no matter of the count of layers */
                if (layers[k] == 1 && emissions[i].emission != DGB_EMISSION_SEPARATE) continue;
                if (layers[k] == 3 && targets[t]) continue;
                v.emission = emissions[i].emission;
                v.version = emissions[i].version;
                v.es = emissions[i].es;
                v.interlock = emissions[i].interlock;
                v.layers = layers[k];
                v.targets = targets[t];
                v.back = layers[k] == 1 && t == 0;
                for (v.divisor = 1; v.divisor <= (emissions[i].divides ? 2 : 1); ++v.divisor)
                    write_snippets(directory, &v);
            }
}

/* What BENT adds to programs, with and without light, a second layer and frames. */
static void write_bent(const char* directory) {
    static const uint32_t others[] = {0, DGB_EFFECT_RADIOSITY, DGB_EFFECT_RADIOSITY | DGB_EFFECT_BOUNCES};
    int i, layers;
    for (i = 0; i < 6; ++i)
        for (layers = 1; layers <= 2; ++layers) {
            dgb_desc desc;
            memset(&desc, 0, sizeof desc);
            desc.width = desc.height = 64;
            desc.layers = layers;
            desc.effects = DGB_EFFECT_AO | DGB_EFFECT_BENT | others[i / 2] | (i % 2 ? DGB_EFFECT_TEMPORAL : 0u);
            desc.estimator = DGB_ESTIMATOR_BITMASK;
            write_plan(directory, &desc);
        }
}

int main(int argc, char** argv) {
    int effects, layers, normals, senders, thickness;
    dgb_plan plan;
    if (argc != 2) return 2;
    write_bent(argv[1]);
    for (effects = 1; effects < 64; ++effects)
        for (layers = 1; layers <= 2; ++layers) {
            dgb_desc desc;
            memset(&desc, 0, sizeof desc);
            desc.width = desc.height = 64;
            desc.layers = layers;
            desc.effects = (uint32_t)effects;
            if (dgb_make_plan(&desc, &plan) != DGB_OK) continue; /* BOUNCES without RADIOSITY, GLOSSY without REFLECT */
            for (senders = 0; senders < DGB_SENDERS_COUNT; ++senders)
                for (desc.divisor = 1; desc.divisor <= 2; ++desc.divisor) {
                    desc.senders = (dgb_senders)senders;
                    write_plan(argv[1], &desc);
                    desc.estimator = DGB_ESTIMATOR_BITMASK;
                    for (thickness = 0; thickness < DGB_THICKNESS_COUNT; ++thickness) {
                        desc.thickness = (dgb_thickness)thickness;
                        write_plan(argv[1], &desc);
                    }
                    desc.thickness = DGB_THICKNESS_LAYERS;
                    desc.estimator = DGB_ESTIMATOR_PAPER;
                }
            desc.divisor = 1;
            desc.tracer = DGB_TRACER_HIERARCHICAL; /* brings ranges */
            write_plan(argv[1], &desc);
            desc.tracer = DGB_TRACER_LINEAR;
            desc.emission = DGB_EMISSION_IMAGE; /* brings resolve */
            write_plan(argv[1], &desc);
            desc.emission = DGB_EMISSION_AUTO;
            desc.oracle = DGB_ORACLE_WARP;
            write_plan(argv[1], &desc);
            desc.oracle = DGB_ORACLE_DEFAULT;
            desc.source = DGB_SOURCE_ENGINE;
            for (normals = 0; normals < DGB_NORMALS_COUNT; ++normals) {
                desc.normals = (dgb_normals)normals;
                write_plan(argv[1], &desc);
            }
        }
    write_view(argv[1], 330, false);
    write_view(argv[1], 450, false);
    write_view(argv[1], 300, true);
    write_all_snippets(argv[1]);
    return 0;
}
