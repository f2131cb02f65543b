// Random numbers that depend on nothing but a key: the same whatever the number of threads and the order of work.
#pragma once

#include <cstdint>

// A counter, mixed: SplitMix64 (Steele, Lea and Flood 2014). Streams of different keys are independent for all that a
// Monte-Carlo estimate can tell.
class Random {
public:
    Random(uint64_t seed, uint64_t point, uint64_t batch) : counter_(mix(mix(mix(seed) + point) + batch)) {}

    double uniform() { // at least 0, below 1
        counter_ += kStep;
        return double(mix(counter_) >> 11) * 0x1p-53;
    }

private:
    static constexpr uint64_t kStep = 0x9e3779b97f4a7c15u; // 2^64 over the golden ratio

    static uint64_t mix(uint64_t x) {
        x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
        x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
        return x ^ (x >> 31);
    }

    uint64_t counter_;
};
