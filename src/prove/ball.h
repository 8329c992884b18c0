/* Balls of doubles: a centre and a radius that holds every rounding, for searches that would wait
 * for Arb. Each result is rounded to nearest, which is off by at most 2^-53 of it, and that is
 * added to the radius; a radius is a sum of a few products that are not negative, and up() makes it
 * larger than all their roundings and underflows. A ball that is not a number compares false with
 * everything. */
#ifndef RIC_PROVE_BALL_H
#define RIC_PROVE_BALL_H

#include <float.h>
#include <math.h>

#include "arb_numbers.h"

typedef struct {
    double m, r;
} ric_ball;

#define RIC_BALL_UNIT 0x1p-53 /* of rounding to nearest */

/* At most eight roundings of numbers that are not negative. */
static inline double ric_up(double r)
{
    return r * (1 + 0x1p-49) + 0x1p-1000;
}
/* From below, the same. */
static inline double ric_down(double r)
{
    return r * (1 - 0x1p-49) - 0x1p-1000;
}
static inline ric_ball ric_ball_exact(double x)
{
    return (ric_ball){x, 0};
}
static inline ric_ball ric_ball_add(ric_ball a, ric_ball b)
{
    const double m = a.m + b.m;
    return (ric_ball){m, ric_up(a.r + b.r + fabs(m) * RIC_BALL_UNIT)};
}
static inline ric_ball ric_ball_sub(ric_ball a, ric_ball b)
{
    return ric_ball_add(a, (ric_ball){-b.m, b.r});
}
static inline ric_ball ric_ball_mul(ric_ball a, ric_ball b)
{
    const double m = a.m * b.m;
    return (ric_ball){m,
                      ric_up(fabs(a.m) * b.r + a.r * (fabs(b.m) + b.r) + fabs(m) * RIC_BALL_UNIT)};
}
/* Over an exact number that is not zero. */
static inline ric_ball ric_ball_over(ric_ball a, double b)
{
    const double m = a.m / b;
    return (ric_ball){m, ric_up(a.r / fabs(b) + fabs(m) * RIC_BALL_UNIT)};
}
/* At least |x| of every number of the ball. */
static inline double ric_ball_most(ric_ball a)
{
    return ric_up(fabs(a.m) + a.r);
}

/* sum y_i x_i with exact y. The error of a sum of n products in any order is at most n u / (1 - n
 * u) of the sum of their sizes (Higham, Accuracy and Stability of Numerical Algorithms, 2002,
 * section 3.1). */
static inline ric_ball ric_ball_dot(int n, const double *y, const double *m, const double *r)
{
    double sum = 0, size = 0, radius = 0;
    for (int i = 0; i < n; i++) {
        const double product = y[i] * m[i];
        sum += product;
        size += fabs(product);
        radius += fabs(y[i]) * r[i];
    }
    const double more = (n + 2) * 2 * RIC_BALL_UNIT;
    return (ric_ball){sum, ric_up((radius + size * more) * (1 + more) + n * 0x1p-1000)};
}

/* The ball of doubles that holds one of Arb. */
static inline ric_ball ric_ball_of(const arb_t x)
{
    if (arb_is_zero(x)) return ric_ball_exact(0);
    const double m = ric_arb_nearest(arb_midref(x));
    mag_t r;
    mag_init(r);
    mag_set(r, arb_radref(x));
    const double radius = mag_get_d(r); /* rounded up */
    mag_clear(r);
    return (ric_ball){m, ric_up(radius + fabs(m) * RIC_BALL_UNIT)};
}

#endif
