/* Floats as bits, and random numbers, whose state the caller keeps. */
#ifndef NUMBERS_H
#define NUMBERS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

static inline uint32_t bits_of(float x) {
    uint32_t u;
    memcpy(&u, &x, sizeof u);
    return u;
}

static inline float from_bits(uint32_t u) {
    float x;
    memcpy(&x, &u, sizeof x);
    return x;
}

static inline bool is_finite(float x) { return (bits_of(x) & 0x7f800000u) != 0x7f800000u; }

/* To the last bit: what == says of floats and padding is not the question. */
static inline bool same_bits(const void* a, const void* b, size_t size) { return memcmp(a, b, size) == 0; }

/* splitmix64 without its last step, which mends the low bits: use the high ones. */
static inline uint64_t random_long(uint64_t* state) {
    uint64_t z = *state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z;
}

static inline uint32_t random_bits(uint64_t* state) { return (uint32_t)(random_long(state) >> 32); }

/* A linear congruential generator: 24 good bits, the high ones. */
static inline uint32_t lcg(uint32_t* state) { return *state = *state * 1664525u + 1013904223u; }

/* 0 <= x < 1 */
static inline double lcg_unit(uint32_t* state) { return (double)(lcg(state) >> 8) / 16777216.0; }

static inline uint32_t lcg_bits(uint32_t* state) {
    const uint32_t u = lcg(state);
    return u ^ u >> 15;
}

/* Any bit pattern, with those that matter more often than chance has them. */
static inline float lcg_pattern(uint32_t* state) {
    static const uint32_t special[] = {0x7fc00000u, 0x7f800000u, 0xff800000u, 0x80000000u, 0x00000001u, 0x7f7fffffu,
                                       0xff7fffffu, 0x3f800000u, 0x00000000u, 0x7f800001u, 0xffc12345u, 0x47800000u};
    const uint32_t low = lcg_bits(state), bits = low ^ lcg_bits(state) << 16;
    if ((lcg_bits(state) & 0x40000u) == 0) return from_bits(bits);
    return from_bits(special[(lcg_bits(state) >> 8) % (sizeof special / sizeof special[0])]);
}

#endif
