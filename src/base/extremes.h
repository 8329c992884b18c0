/* Extremes of numbers where loops ask for them: calls of fmax and fmin take longer than the
 * comparison. */
#ifndef RIC_BASE_EXTREMES_H
#define RIC_BASE_EXTREMES_H

/* The larger and the smaller of two; as for fmax and fmin what is no number does not count. */
static inline double ric_larger(double a, double b)
{
    return a > b || b != b ? a : b;
}

static inline double ric_smaller(double a, double b)
{
    return a < b || b != b ? a : b;
}

/* The larger of a number and of what may be none. */
static inline double ric_raise(double most, double x)
{
    return x > most ? x : most;
}

#endif
