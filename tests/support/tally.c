#include "tally.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

tally tally_of(const char* what) {
    tally t;
    memset(&t, 0, sizeof t);
    t.what = what;
    return t;
}

void tally_report(const tally* t) {
    printf("#     %-12s %6d pixels, %d wrong, %d doubtful, %d unsure; off by %.3f at most, %.3f on average; "
           "%.4f of the bound needed\n",
           t->what, t->pixels, t->wrong, t->doubtful, t->unsure, t->worst, t->pixels ? t->sum / t->pixels : 0.0,
           t->needed);
    assert_true(t->wrong + t->unsure <= t->pixels / 10000 + (t->pixels > 1000 ? 1 : 0));
}

void tally_value(tally* t, double difference, bool right) {
    ++t->pixels;
    t->sum += difference;
    t->worst = right && difference > t->worst ? difference : t->worst;
    t->wrong += !right;
}

static double ulp_of(double x, int mantissa, int least) {
    int exponent;
    (void)frexp(fabs(x), &exponent);
    return ldexp(1.0, exponent - mantissa - 1 < least ? least : exponent - mantissa - 1);
}

double tally_half_ulp(double x) { return ulp_of(x, 10, -24); }

static void count_stored(tally* t, double ulp, double value, double low, double high) {
    const double middle = 0.5 * (low + high), beyond = fabs(value - middle) - ulp;
    const bool right = value >= low - ulp && value <= high + ulp;
    tally_value(t, fabs(value - middle) / ulp, right);
    if (right && high > low && beyond / (0.5 * (high - low)) > t->needed) t->needed = beyond / (0.5 * (high - low));
}

void tally_half(tally* t, double value, double low, double high) {
    count_stored(t, tally_half_ulp(value), value, low, high);
}

void tally_small_float(tally* t, int mantissa, double value, double low, double high) {
    count_stored(t, ulp_of(value, mantissa, -14 - mantissa), value, low, high);
}

void tally_code(tally* t, double code, double low, double high, double exact) {
    tally_value(t, fabs(code - 255.0 * exact), code >= 255.0 * low - 0.5 && code <= 255.0 * high + 0.5);
}
