/* Hashes of what each function of the mathematics returns for a large sample of inputs, a line a function. Each line says
   first whether that is computed in integers. */
#include "../support/mathematics.c"
#define DEEPGBUFFER_IMPLEMENTATION
#include "deepgbuffer.h" /* NOLINT: a second time on purpose */

#include <stdio.h>

/* One NaN is as good as another: which one an operation gives is the compiler's choice of operands. */
static uint32_t plain(mathematics_result result, uint32_t word) {
    const bool nan = (word & 0x7fffffffu) > 0x7f800000u;
    return result != MATHEMATICS_COUNTS && nan ? 0x7fc00000u : word;
}

static uint64_t hash_of(const mathematics_function* f, uint64_t seed) { /* FNV-1a, a word at a time */
    uint32_t in[MATHEMATICS_MOST_INPUTS], out[MATHEMATICS_MOST_OUTPUTS];
    uint64_t hash = 14695981039346656037u;
    int call, i;
    for (call = 0; call < 20000; ++call) {
        mathematics_inputs(&seed, in, f->inputs);
        f->call(in, out);
        for (i = 0; i < f->outputs; ++i) hash = (hash ^ plain(f->result, out[i])) * 1099511628211u;
    }
    return hash;
}

int main(void) {
    int i;
    for (i = 0; i < mathematics_count; ++i)
        printf("%s %s %016llx\n", mathematics[i].integers ? "integers" : "floats", mathematics[i].name,
               (unsigned long long)hash_of(&mathematics[i], (uint64_t)i));
    return 0;
}
