#include "hermite.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>

#include "root.h"

/* Of a panel: the quintic is not the function, and its zero need not be known any better. */
#define GUESSED 1e-9

/* Where the quintic through values and both derivatives at lo and hi has its zero (order 0) or that
 * of its slope (order 1); it is off by D6 h^6 / 46080. */
static double guess(int order, const ric_sample *lo, const ric_sample *hi)
{
    const double h = hi->t - lo->t, rise = hi->g[0] - lo->g[0], v0 = h * lo->g[1],
                 v1 = h * hi->g[1], a0 = h * h * lo->g[2] / 2, a1 = h * h * hi->g[2] / 2;
    double c[7] = {lo->g[0],
                   v0,
                   a0,
                   10 * rise - 6 * v0 - 4 * v1 - 3 * a0 + a1,
                   -15 * rise + 8 * v0 + 7 * v1 + 3 * a0 - 2 * a1,
                   6 * rise - 3 * v0 - 3 * v1 - a0 + a1};
    if (order == 1)
        for (int k = 0; k < 6; k++) c[k] = (k + 1) * c[k + 1];
    bool low_nearer = fabs(lo->g[order]) < fabs(hi->g[order]);
    ric_root_slope r = ric_root_slope_between(0, 1, hi->g[order] > 0, low_nearer ? 0 : 1);
    double value, slope, half; /* half the second derivative */
    r.least = GUESSED;
    do {
        value = c[5];
        slope = half = 0;
        for (int k = 4; k >= 0; k--) {
            half = half * r.x + slope;
            slope = slope * r.x + value;
            value = value * r.x + c[k];
        }
    } while (ric_root_slope_bent(&r, value, slope, 2 * half));
    double t = lo->t + r.x * h;
    return t > lo->t && t < hi->t ? t : low_nearer ? lo->t : hi->t;
}

/* Whether the step from x that was just taken ends at the zero to rounding: what the next term of
 * Taylor's series leaves, with the third derivative as large as the second one can make it. */
static bool arrived(const ric_root_slope *r, int order, const ric_sample *x, double third)
{
    double d = r->step, left = order == 0 ? third * d * d * d / 6 : third * d * d / 2;
    return !r->halved && left <= fabs(x->g[order + 1]) * DBL_EPSILON / 2 * fabs(r->x);
}

/* Where one more step of the series leads from a sample. */
static ric_sample moved(ric_sample x, double t)
{
    double d = t - x.t;
    return (ric_sample){t, {x.g[0] + d * (x.g[1] + d * x.g[2] / 2), x.g[1] + d * x.g[2], x.g[2]}};
}

ric_sample ric_hermite_zero(ric_hermite_look *look, const void *of, int order, ric_sample lo,
                            ric_sample hi)
{
    ric_root_slope r = ric_root_slope_between(lo.t, hi.t, hi.g[order] > 0, guess(order, &lo, &hi));
    const double third = 2 * (fabs(lo.g[2]) + fabs(hi.g[2])) / (hi.t - lo.t);
    r.part = DBL_EPSILON / 2;
    for (;;) {
        ric_sample x = look(of, r.x);
        bool on = order == 0 ? ric_root_slope_bent(&r, x.g[0], x.g[1], x.g[2])
                             : ric_root_slope_next(&r, x.g[1], x.g[2]);
        if (!on) return x;
        if (arrived(&r, order, &x, third)) return moved(x, r.x);
    }
}
