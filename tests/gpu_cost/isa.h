#ifndef ISA_H
#define ISA_H

#include <stdbool.h>

/* What a shader costs on RDNA 2, from the assembly text that Mesa's RADV shows of it: how many cycles 64 pixels keep each
   unit busy, and how often they fetch from each texture. Cycles as in the driver's own estimate ("inverse throughput"), which
   assumes 8 trips of every loop; here each loop is kept apart, so that it can count as often as it runs. */

enum { ISA_MAX_LOOPS = 8, ISA_MAX_TEXTURES = 16 };

typedef enum isa_unit { ISA_VECTOR, ISA_TRANSCENDENTAL, ISA_SCALAR, ISA_MEMORY, ISA_UNIT_COUNT } isa_unit;

typedef struct isa_work {
    double cycles[ISA_UNIT_COUNT];
    double fetches[ISA_MAX_TEXTURES]; /* a pixel, by binding */
    double skippable;                 /* of the vector unit's cycles: behind branches that a wave may take */
} isa_work;

typedef struct isa_code {
    int instruction_count, loop_count;
    isa_work once;                /* outside of every loop */
    isa_work trip[ISA_MAX_LOOPS]; /* one trip of each loop without the loops within it, by where they begin */
    int depth[ISA_MAX_LOOPS];     /* 1: not within another loop */
} isa_code;

/* Null, or what is wrong with the text, a sentence. */
const char* isa_read(const char* assembly, isa_code* code);

/* The work of one run: every branch taken, loop k run trips[k] times in all. */
isa_work isa_sum(const isa_code* code, const double trips[ISA_MAX_LOOPS]);

/* Trips as the driver's estimate assumes them: 8, in a loop within a loop 4 for each of those. */
void isa_assumed_trips(const isa_code* code, double trips[ISA_MAX_LOOPS]);

/* Of the busiest unit. */
double isa_busy_cycles(const isa_work* work);

#endif
