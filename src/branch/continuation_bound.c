/* How far the multipliers of an orbit may be off: the orbit itself is known to rounding, and its map moves with it. */
#include "continuation.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "base/room.h"

#define UNKNOWN (4 * DBL_EPSILON) /* of the size: error of an unknown, in the frame of the modes or as it is stored */

bool ric_continuation_move(const ric_shooting *c, const double *u, int way, double *out)
{
    int size = c->n_unknown;
    double plane[2 * size], second;
    unsigned bits = (unsigned)way * 2654435769u;
    if (!ric_shooting_plane(c, plane, &second)) return false;
    double across = ric_continuation_tolerance(c) * c->scale / second * (way & 1 ? 1 : -1);
    for (int i = 0; i < size; i++) out[i] = u[i] + ric_moved(&bits, UNKNOWN * c->scale) + across * plane[i];
    return isfinite(across);
}

/* How far the nearest of the pairs `rho` [2 count] is from one. */
static double off_pair(int count, const double *rho, const double *one)
{
    double off = HUGE_VAL;
    for (int i = 0; i < count; i++) off = fmin(off, hypot(rho[2 * i] - one[0], rho[2 * i + 1] - one[1]));
    return off;
}

ric_status ric_continuation_bound(ric_shooting *c, const double *u, ric_floquet *f)
{
    enum { WAYS = RIC_TRACE_WAYS };
    int k = f->n_pair, size = c->n_unknown;
    double at[2 * k + 1], seen[k + 1], moved[WAYS * size + 1];
    ric_status status = RIC_OK;
    ric_stability stable = f->stable;
    if (k < 1) return RIC_OK;
    memcpy(at, f->rho, 2 * (size_t)k * sizeof *at);
    memset(seen, 0, sizeof seen);
    bool known = true;
    for (int way = 0; way < WAYS; way++) known = known && ric_continuation_move(c, u, way + 1, moved + way * size);
    for (int way = 0; way < WAYS && known && !status; way++) {
        ric_shooting_fly(c, moved + way * size);
        status = ric_floquet_compute(c, f);
        for (int i = 0; i < k; i++) seen[i] = fmax(seen[i], off_pair(k, f->rho, at + 2 * i));
    }
    ric_shooting_fly(c, u);
    if (!status) status = ric_floquet_compute(c, f);
    f->stable = stable;
    for (int i = 0; i < k; i++) seen[i] = known ? RIC_MEASURED * seen[i] : HUGE_VAL;
    ric_floquet_widen(f, seen);
    return status;
}
