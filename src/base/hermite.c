#include "hermite.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>

ric_sample ric_hermite_zero(ric_hermite_look *look, const void *of, int order, ric_sample lo, ric_sample hi)
{
    enum { STEPS = 200 };
    bool rising = hi.g[order] > 0;
    ric_sample x = fabs(lo.g[order]) < fabs(hi.g[order]) ? lo : hi;
    double last = hi.t - lo.t;
    for (int i = 0; i < STEPS && x.g[order] != 0; i++) {
        double step = -x.g[order] / x.g[order + 1], t = x.t + step;
        if (!(t > lo.t && t < hi.t) || fabs(step) > last / 2) t = lo.t + (hi.t - lo.t) / 2;
        last = fabs(t - x.t);
        if (t == lo.t || t == hi.t || last <= DBL_EPSILON / 2 * t) break;
        x = look(of, t);
        if ((x.g[order] > 0) == rising) hi = x;
        else lo = x;
    }
    return x;
}
