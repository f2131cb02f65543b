#include "isa.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_BRANCHES = 512, MAX_SCALARS = 128 };

typedef struct jump {
    int from, to; /* blocks */
} jump;

typedef struct reader {
    isa_code* code;
    const char* complaint;
    jump loops[ISA_MAX_LOOPS]; /* first and last block */
    jump branches[MAX_BRANCHES];
    int branch_count;
    int block;                         /* of the line being read */
    int descriptor_bytes[MAX_SCALARS]; /* by scalar register: what it holds of the set, an offset; -1: nothing */
} reader;

/* >> lines */

/* Calls what for every line, without its comment. */
static void for_each_line(reader* r, const char* text, void (*what)(reader* r, const char* line)) {
    char line[512];
    while (*text && !r->complaint) {
        const size_t length = strcspn(text, "\n"), used = strcspn(text, ";\n");
        if (used >= sizeof line) {
            r->complaint = "a line of the assembly is too long";
            return;
        }
        memcpy(line, text, used);
        line[used] = 0;
        if (sscanf(line, "BB%d:", &r->block) != 1 && line[0] == '\t' && line[1]) what(r, line + 1);
        text += length + (text[length] != 0);
    }
}

static bool starts_with(const char* text, const char* start) { return strncmp(text, start, strlen(start)) == 0; }

static bool starts_with_any(const char* text, const char* const* starts) {
    for (; *starts; ++starts)
        if (starts_with(text, *starts)) return true;
    return false;
}

static bool is_branch(const char* line, int* to) {
    const char* target = strstr(line, " BB");
    if (!starts_with(line, "s_branch") && !starts_with(line, "s_cbranch")) return false;
    return target && sscanf(target, " BB%d", to) == 1;
}

/* >> loops and branches */

static void add_loop(reader* r, int head, int last) {
    int k;
    for (k = 0; k < r->code->loop_count; ++k)
        if (r->loops[k].from == head) { /* a second `continue` */
            if (last > r->loops[k].to) r->loops[k].to = last;
            return;
        }
    if (r->code->loop_count == ISA_MAX_LOOPS) {
        r->complaint = "the assembly has too many loops";
        return;
    }
    for (k = r->code->loop_count++; k > 0 && r->loops[k - 1].from > head; --k) r->loops[k] = r->loops[k - 1];
    r->loops[k].from = head;
    r->loops[k].to = last;
}

static void find_branch(reader* r, const char* line) {
    int to;
    if (!is_branch(line, &to)) return;
    if (to <= r->block) {
        add_loop(r, to, r->block);
    } else if (r->branch_count == MAX_BRANCHES) {
        r->complaint = "the assembly has too many branches";
    } else {
        r->branches[r->branch_count].from = r->block;
        r->branches[r->branch_count++].to = to;
    }
}

static bool is_within(jump loop, int block) { return loop.from <= block && block <= loop.to; }

/* The innermost loop around a block; -1: none. Inner loops begin later. */
static int loop_of(const reader* r, int block) {
    int k = r->code->loop_count - 1;
    while (k >= 0 && !is_within(r->loops[k], block)) --k;
    return k;
}

/* Whether a branch may skip the block; leaving a loop skips nothing of a trip. */
static bool is_skippable(const reader* r, int block) {
    int i;
    for (i = 0; i < r->branch_count; ++i) {
        const jump b = r->branches[i];
        const int loop = loop_of(r, b.from);
        if (b.from < block && block < b.to && (loop < 0 || is_within(r->loops[loop], b.to))) return true;
    }
    return false;
}

static void find_depths(reader* r) {
    int k, i;
    for (k = 0; k < r->code->loop_count; ++k) {
        r->code->depth[k] = 1;
        for (i = 0; i < k; ++i) r->code->depth[k] += is_within(r->loops[i], r->loops[k].from);
    }
}

/* >> instructions */

/* Cycles for 64 pixels on 32 lanes. Whole multiplications and 64-bit operations take longer on the vector unit; roots,
   reciprocals, exponentials and logarithms go to a unit of a quarter of the width besides. */
static void add_instruction(isa_work* work, const char* line) {
    static const char* const transcendental[] = {"v_rcp_", "v_rsq_", "v_sqrt_", "v_exp_",
                                                 "v_log_", "v_sin_", "v_cos_",  NULL};
    static const char* const quarter[] = {"v_mul_lo_u32", "v_mul_lo_i32", "v_mul_hi_u32", "v_mul_hi_i32", NULL};
    static const char* const wide[] = {"v_lshlrev_b64", "v_lshrrev_b64", "v_ashrrev_i64", NULL};
    static const char* const memory[] = {"image_", "buffer_", "global_", "scratch_", NULL};
    static const char* const free_scalar[] = {"s_waitcnt", "s_clause", "s_nop",           "s_branch",
                                              "s_cbranch", "s_endpgm", "s_inst_prefetch", NULL};
    if (starts_with(line, "v_"))
        work->cycles[ISA_VECTOR] += starts_with_any(line, quarter) ? 8 : starts_with_any(line, wide) ? 4 : 2;
    if (starts_with_any(line, transcendental)) work->cycles[ISA_TRANSCENDENTAL] += 8;
    if (starts_with(line, "s_") && !starts_with_any(line, free_scalar)) work->cycles[ISA_SCALAR] += 1;
    if (starts_with_any(line, memory)) work->cycles[ISA_MEMORY] += 2;
}

static void copy_scalars(reader* r, int to, int from, int count) {
    for (; count > 0 && to < MAX_SCALARS && from < MAX_SCALARS; --count)
        r->descriptor_bytes[to++] = r->descriptor_bytes[from++];
}

/* Descriptors are loaded into scalar registers, and may move there. */
static void follow_descriptors(reader* r, const char* line) {
    const char* offset = strrchr(line, ',');
    int first, last, from, bytes = 0;
    if (sscanf(line, "s_load_dwordx%*d s[%d:%d]", &first, &last) == 2 && offset) {
        const bool is_known = sscanf(offset, ", %i", &bytes) == 1 || strstr(offset, "null");
        for (; first <= last && first < MAX_SCALARS; bytes += 4) r->descriptor_bytes[first++] = is_known ? bytes : -1;
    } else if (sscanf(line, "s_mov_b64 s[%d:%*d], s[%d:", &first, &from) == 2) {
        copy_scalars(r, first, from, 2);
    } else if (sscanf(line, "s_mov_b32 s%d, s%d", &first, &from) == 2) {
        copy_scalars(r, first, from, 1);
    }
}

/* What the driver gives to each texture of a set. */
enum { DESCRIPTOR_BYTES = 96 };

static void add_fetch(reader* r, isa_work* work, const char* line) {
    const char* operand = strstr(line, " s[");
    int first, offset;
    if (!starts_with(line, "image_")) return;
    offset = operand && sscanf(operand, " s[%d:", &first) == 1 && first < MAX_SCALARS ? r->descriptor_bytes[first] : -1;
    if (offset < 0 || offset % DESCRIPTOR_BYTES || offset / DESCRIPTOR_BYTES >= ISA_MAX_TEXTURES)
        r->complaint = "cannot tell from which texture an instruction of the assembly fetches";
    else
        work->fetches[offset / DESCRIPTOR_BYTES] += 1;
}

static void read_instruction(reader* r, const char* line) {
    const int loop = loop_of(r, r->block);
    isa_work* work = loop < 0 ? &r->code->once : &r->code->trip[loop];
    const double before = work->cycles[ISA_VECTOR];
    ++r->code->instruction_count;
    follow_descriptors(r, line);
    add_instruction(work, line);
    add_fetch(r, work, line);
    if (is_skippable(r, r->block)) work->skippable += work->cycles[ISA_VECTOR] - before;
}

const char* isa_read(const char* assembly, isa_code* code) {
    static reader r;
    int i;
    memset(code, 0, sizeof *code);
    memset(&r, 0, sizeof r);
    for (i = 0; i < MAX_SCALARS; ++i) r.descriptor_bytes[i] = -1;
    r.code = code;
    for_each_line(&r, assembly, find_branch);
    find_depths(&r);
    r.block = 0;
    for_each_line(&r, assembly, read_instruction);
    return r.complaint;
}

/* >> sums */

static void add_times(isa_work* sum, const isa_work* work, double times) {
    int i;
    for (i = 0; i < ISA_UNIT_COUNT; ++i) sum->cycles[i] += times * work->cycles[i];
    for (i = 0; i < ISA_MAX_TEXTURES; ++i) sum->fetches[i] += times * work->fetches[i];
    sum->skippable += times * work->skippable;
}

isa_work isa_sum(const isa_code* code, const double trips[ISA_MAX_LOOPS]) {
    isa_work sum = code->once;
    int k;
    for (k = 0; k < code->loop_count; ++k) add_times(&sum, &code->trip[k], trips[k]);
    return sum;
}

void isa_assumed_trips(const isa_code* code, double trips[ISA_MAX_LOOPS]) {
    int k;
    for (k = 0; k < code->loop_count; ++k) trips[k] = code->depth[k] > 1 ? 32 : 8;
}

double isa_busy_cycles(const isa_work* work) {
    double most = 0;
    int i;
    for (i = 0; i < ISA_UNIT_COUNT; ++i)
        if (work->cycles[i] > most) most = work->cycles[i];
    return most;
}
