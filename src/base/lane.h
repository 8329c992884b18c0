/* Lanes of two numbers, in which one instruction does what otherwise takes two: each lane has the
 * operations, and the bits, that its number has alone. */
#ifndef RIC_BASE_LANE_H
#define RIC_BASE_LANE_H

#include <string.h>

typedef double ric_lane __attribute__((vector_size(16)));

static inline __attribute__((always_inline)) ric_lane ric_lane_load(const double *x)
{
    ric_lane out;
    memcpy(&out, x, sizeof out);
    return out;
}

static inline __attribute__((always_inline)) void ric_lane_store(double *x, ric_lane value)
{
    memcpy(x, &value, sizeof value);
}

#endif
