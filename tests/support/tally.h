/* Counts how far stored values are from where they may be, in units of the storage. */
#ifndef TALLY_H
#define TALLY_H

#include <stdbool.h>

typedef struct tally {
    const char* what;
    int pixels, wrong, doubtful, unsure;
    double worst, sum; /* of |difference| in units of the storage: codes or ulps */
    double needed;     /* largest share of the float error's bound that a right value needed */
} tally;

tally tally_of(const char* what);
/* Prints it; at most one value in 10,000, and one in any case where there are more than 1000, may be wrong. */
void tally_report(const tally* t);

void tally_value(tally* t, double difference, bool right);
/* One ulp of the half that x is stored as, for a device may truncate. */
double tally_half_ulp(double x);
/* Whether half-stored `value` may come from anything in low..high. */
void tally_half(tally* t, double value, double low, double high);
/* Whether `code` of 255 may come from low..high; reference: without float errors. */
void tally_code(tally* t, double code, double low, double high, double exact);
/* Whether `value`, stored in a float of 5 bits of exponent and so many of mantissa, may come from anything in low..high. */
void tally_small_float(tally* t, int mantissa, double value, double low, double high);

#endif
