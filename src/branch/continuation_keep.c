/* What is kept of a branch: points, and its end. */
#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "continuation.h"
#include "model/room.h"
#include "orbit/room.h"

/* STALLED: residual of a point that has lost more than the digits which flights cost it */
#define STALLED (512 * DBL_EPSILON)

static void write_point(ric_continuation *tr, int i, const ric_point *row, const double *u)
{
    double *out = tr->points + (size_t)i * tr->stride;
    memcpy(out, row, sizeof *row);
    memcpy(out + sizeof *row / sizeof *out, u, (size_t)tr->chain->n_unknown * sizeof *out);
}

/* Where events fall together, as at a grazing of a spring or at a corner, a flight of no length is
 * solved for to its rounding, on either side of zero. What is kept lasts no negative time: the
 * point is that with zero in its place, and filled anew, so that all that is said is said of what
 * is stored. */
static ric_status without_negative_flights(ric_continuation *tr, ric_station *p)
{
    const ric_shooting *c = tr->chain;
    bool any = false, undecided = p->row.stable == RIC_STABLE_UNDECIDED;
    for (int k = c->n_start; k < c->n_start + c->n_flight; k++) {
        if (!(p->u[k] < 0)) continue;
        if (p->u[k] < -RIC_MARGIN) p->solved = false;
        any = true;
        p->u[k] = 0;
    }
    if (!any || !p->solved) return RIC_OK;
    ric_status status = ric_continuation_fill(tr, p->s, p);
    if (undecided) p->row.stable = RIC_STABLE_UNDECIDED;
    return status;
}

bool ric_continuation_goes_wrong(const ric_continuation *tr, const ric_station *p)
{
    const double unit = tr->chain->model->length * tr->chain->model->omega_ref;
    return p->row.approach < -RIC_MARGIN * unit;
}

/* Whether an orbit that extended precision does not come to is farther away than one that is
 * solved. */
static bool strays(ric_shooting *c, const double *u)
{
    ric_fine_real orbit[2 * c->n + c->n_flight];
    double moved = 0;
    return ric_floquet_fine_fits(c) && !ric_floquet_fine_orbit(c, u, orbit, &moved) &&
           moved > RIC_SAME_SOLVED * c->scale;
}

static bool lasts(const ric_shooting *c, const double *u)
{
    bool all = true;
    for (int k = c->n_start; k < c->n_start + c->n_flight; k++) all &= u[k] >= 0;
    return all;
}

/* Beside a contact that lasts next to no time Newton's method in double stalls: a point there is
 * kept with the digits that it has in extended precision, or not at all. The trace goes on from
 * where it was. */
static ric_status polish(ric_continuation *tr, ric_station *p)
{
    ric_shooting *c = tr->chain;
    const int size = c->n_unknown;
    const ric_point row = p->row;
    double u[size], moved = 0;
    if (!(row.residual > STALLED) || tr->limits->ghost || tr->n_point == 0) return RIC_OK;
    memcpy(u, p->u, sizeof u);
    if (!ric_floquet_fine_nearest(c, p->u)) {
        p->solved = !strays(c, p->u);
        return RIC_OK;
    }
    for (int i = 0; i < size; i++) moved = fmax(moved, fabs(p->u[i] - u[i]));
    ric_status status = RIC_OK;
    if (moved <= RIC_SAME_LOCATED * c->scale && lasts(c, p->u)) {
        status = ric_continuation_fill(tr, p->s, p);
        if (row.stable == RIC_STABLE_UNDECIDED) p->row.stable = row.stable;
        if (status || (p->row.residual < row.residual && !ric_continuation_goes_wrong(tr, p)))
            return status;
    }
    memcpy(p->u, u, sizeof u);
    p->row = row;
    p->solved = true;
    return RIC_OK;
}

ric_status ric_continuation_keep(ric_continuation *tr, const ric_station *station)
{
    double u[tr->chain->n_unknown];
    ric_station kept = *station, *p = &kept;
    memcpy(p->u = u, station->u, sizeof u);
    p->s = p->row.arclength;
    ric_status status = !p->solved || tr->limits->ghost ? RIC_OK : without_negative_flights(tr, p);
    bool inadmissible = p->row.reach > 1 + RIC_MARGIN || ric_continuation_goes_wrong(tr, p);
    if (status || !p->solved || (inadmissible && !tr->limits->ghost)) return status;
    if (p->doubtful && (status = ric_trust(ric_continuation_fill(tr, p->s, p)))) return status;
    if ((status = ric_trust(polish(tr, p))) || !p->solved) return status;
    if (tr->n_point == tr->point_capacity) {
        int capacity = tr->point_capacity + tr->point_capacity / 2 +
                       64; /* one point, too, may be a full array */
        double *grown = ric_realloc(tr->points, (size_t)capacity * tr->stride * sizeof *grown);
        if (!grown) return ric_fail(RIC_E_NOMEM, "no memory for %d points of a branch", capacity);
        tr->points = grown;
        tr->point_capacity = capacity;
    }
    write_point(tr, tr->n_point++, &p->row, p->u);
    return RIC_OK;
}

ric_status ric_continuation_end_at(ric_continuation *tr, const double *u)
{
    double own[tr->chain->n_unknown];
    memcpy(own, u, sizeof own);
    ric_station p = {.u = own};
    ric_status status = ric_continuation_fill(tr, tr->end.s, &p);
    if (!status && p.solved) status = without_negative_flights(tr, &p);
    if (status || !p.solved || ric_continuation_goes_wrong(tr, &p)) return status;
    p.row.stable = RIC_STABLE_UNDECIDED; /* two branches meet there */
    memcpy(tr->end.u, own, sizeof own);
    if (ric_continuation_row(tr, tr->n_point - 1)->arclength > tr->end.s)
        p.row.arclength = tr->end.s = ric_continuation_place_end(tr, own);
    const ric_point *last = ric_continuation_row(tr, tr->n_point - 1);
    if (last->arclength < tr->end.s) return ric_continuation_keep(tr, &p);
    write_point(tr, tr->n_point - 1, &p.row, own);
    return RIC_OK;
}
