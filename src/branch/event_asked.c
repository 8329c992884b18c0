/* Passages of energies and frequencies that were asked for, within a step. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "event_parts.h"

/* Relative distance from what was asked for at which orbits are not told apart by shorter steps. */
#define ROUNDING 1e-12

int ric_event_by_place(const void *a, const void *b)
{
    const ric_event_root *p = a, *q = b;
    return p->x < q->x ? -1 : p->x > q->x ? 1 : p->test - q->test;
}

/* The point at distance x: solved, or in a step over a branch point, where nothing can be, on the
 * cubic. */
static ric_status look(ric_continuation *tr, bool solve, double x, double h, ric_station *out,
                       bool *good)
{
    *good = true;
    if (solve) return ric_event_solve(tr, x, h, RIC_LOOK_ALL, out, good);
    ric_event_cubic(tr, x, h, out->u);
    memcpy(out->t, tr->now.t, (size_t)tr->chain->n_unknown * sizeof *out->t);
    return ric_continuation_fill(tr, tr->now.s + (tr->next.s - tr->now.s) * (x / h), out);
}

static double on_cubic(ric_continuation *tr, int test, double xa, double fa, double xb, double fb,
                       double h)
{
    bool good;
    ric_root r = ric_root_between(xa, fa, xb, fb, RIC_LAST_DIGIT * h);
    while (ric_root_next(&r)) {
        look(tr, false, r.x, h, &tr->mid, &good);
        r.f = ric_event_value(tr, test, &tr->mid);
    }
    return r.x;
}

/* Passages between the distances xa and xb, at which what was asked for is `before` and `after`
 * away, with no extremum in between. A value met exactly counts as above, so that it is found in
 * one of the two steps that end there. */
static ric_status find_monotonic(ric_continuation *tr, bool solve, double xa, double xb,
                                 const double *before, const double *after, double h,
                                 ric_event_root *roots, int *n, bool *retry)
{
    /* on a horizontal branch the frequency is one number but for rounding, and passes nothing */
    bool horizontal = tr->now.test[RIC_TEST_PERIOD] == 0 && tr->next.test[RIC_TEST_PERIOD] == 0;
    for (int k = 0; k < tr->limits->n_asked; k++) {
        int test = RIC_N_TEST + tr->n_resonance + k;
        double fa = before[k], fb = after[k], x = xb;
        bool zero = true;
        if ((fa < 0) == (fb < 0) || (horizontal && tr->limits->asked[k].frequency)) continue;
        if (!solve) x = on_cubic(tr, test, xa, fa, xb, fb, h);
        else {
            ric_status status = ric_event_locate(tr, test, xa, fa, xb, fb, h, &x, &zero);
            if (status) return status;
        }
        if (!zero && fmax(fabs(fa), fabs(fb)) > ROUNDING) {
            *retry = true;
            return RIC_OK;
        }
        roots[(*n)++] = (ric_event_root){test, zero ? x : xb};
    }
    return RIC_OK;
}

static void distances(const ric_continuation *tr, const ric_station *p, double *out)
{
    for (int k = 0; k < tr->limits->n_asked; k++)
        out[k] = ric_event_value(tr, RIC_N_TEST + tr->n_resonance + k, p);
}

ric_status ric_event_asked_find(ric_continuation *tr, bool solve, double to, double h,
                                ric_event_root *roots, int *n, bool *retry)
{
    int known = *n;
    double from = 0, f[2][RIC_USER_POINTS_MAX];
    if (tr->limits->n_asked == 0) return RIC_OK;
    qsort(roots, (size_t)known, sizeof *roots, ric_event_by_place);
    distances(tr, &tr->now, f[0]);
    for (int i = 0; i <= known && !*retry; i++) {
        if (i < known && roots[i].test != RIC_TEST_SLOPE && roots[i].test != RIC_TEST_PERIOD)
            continue;
        double x = i < known ? roots[i].x : to;
        bool good = true, last = i == known && to == h;
        ric_status status = last ? RIC_OK : look(tr, solve, x, h, &tr->mid, &good);
        if (status) return status;
        distances(tr, last ? &tr->next : &tr->mid, f[1]);
        if (!(*retry = !good))
            status = find_monotonic(tr, solve, from, x, f[0], f[1], h, roots, n, retry);
        if (status) return status;
        memcpy(f[0], f[1], sizeof f[0]);
        from = x;
    }
    return RIC_OK;
}

ric_status ric_event_asked_cross(ric_continuation *tr, int first, double to, double h)
{
    int n = 0, known = tr->n_event - first;
    double scale = h / (tr->next.s - tr->now.s);
    ric_event_root roots[known + RIC_EVENT_STRETCHES * tr->limits->n_asked + 1];
    bool good, retry = false;
    for (; n < known; n++)
        roots[n] = (ric_event_root){tr->events[first + n].test,
                                    (tr->events[first + n].s - tr->now.s) * scale};
    ric_status status = ric_event_asked_find(tr, false, to, h, roots, &n, &retry);
    for (int i = known; i < n && !status; i++)
        if (!(status = look(tr, false, roots[i].x, h, &tr->mid, &good)))
            status = ric_event_keep(tr, roots[i].test, &tr->mid);
    return status;
}
