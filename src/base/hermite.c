#include "hermite.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>

#include "root.h"

ric_sample ric_hermite_zero(ric_hermite_look *look, const void *of, int order, ric_sample lo,
                            ric_sample hi)
{
    ric_sample x = fabs(lo.g[order]) < fabs(hi.g[order]) ? lo : hi;
    ric_root_slope r = ric_root_slope_between(lo.t, hi.t, hi.g[order] > 0, x.t);
    r.part = DBL_EPSILON / 2;
    while (ric_root_slope_next(&r, x.g[order], x.g[order + 1])) x = look(of, r.x);
    return x;
}
