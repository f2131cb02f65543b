/* Every function of deepgbuffer.h's mathematics behind one signature: words in, words out. Any word may come in. */
#ifndef MATHEMATICS_H
#define MATHEMATICS_H

#include <stdbool.h>
#include <stdint.h>

enum { MATHEMATICS_MOST_INPUTS = 24, MATHEMATICS_MOST_OUTPUTS = 16 };

typedef enum mathematics_result {
    MATHEMATICS_FLOATS, /* finite, within low..high */
    MATHEMATICS_COUNTS, /* integers, within low..high */
    MATHEMATICS_WORDS   /* anything: what goes in comes through */
} mathematics_result;

typedef struct mathematics_function {
    const char* name;
    bool integers; /* computes in integers, or exactly: gives the same bits with -ffast-math, too */
    int inputs, outputs;
    mathematics_result result;
    double low, high;
    void (*call)(const uint32_t* in, uint32_t* out);
} mathematics_function;

extern const mathematics_function mathematics[];
extern const int mathematics_count;

/* Inputs for a call: any bits, those at the borders of floats, and ordinary numbers from -2 to 2, all of them often. */
void mathematics_inputs(uint64_t* seed, uint32_t* in, int count);

#endif
