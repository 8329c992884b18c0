/* Without losses a pair of multipliers on the unit circle stays there under a small force, as the
 * map over a period is still symplectic and only where two pairs meet can they leave it (Krein).
 * The losses take it inside or outside, to first order by what they do along the orbit of the
 * atlas: damping that couples modes, and impacts, may well push one pair outside while all of them
 * together contract the volume. So the deviations from that orbit are carried through one period
 * with the losses and without the force, by the code of the exact forced orbits. */
#include "force_stability.h"

#include <math.h>
#include <stdlib.h>

#include "base/room.h"
#include "force_start.h"

typedef struct {
    double slowest; /* largest log |rho| of the multipliers but for the trivial pair */
    double typical; /* the mean of -log |rho| of all, or the largest |log |rho||: the size of a
                       first order */
} decay;

/* The two nearest to 1 are the trivial pair: the pendulum of energy and phase, whose centre is
 * asked for. */
static decay decay_of(int n, const double *multipliers)
{
    decay d = {-INFINITY, 0};
    double first = INFINITY, second = INFINITY, all = 0;
    for (int i = 0; i < 2 * n; i++) {
        const double off = hypot(multipliers[2 * i] - 1, multipliers[2 * i + 1]);
        second = fmin(second, fmax(off, first));
        first = fmin(first, off);
    }
    for (int i = 0; i < 2 * n; i++) {
        const double *rho = multipliers + 2 * i, growth = log(hypot(rho[0], rho[1]));
        all += growth;
        if (hypot(rho[0] - 1, rho[1]) <= second) continue;
        d.slowest = fmax(d.slowest, growth);
        d.typical = fmax(d.typical, fabs(growth));
    }
    d.typical = fmax(d.typical, fabs(all) / (2 * n));
    return d;
}

/* RIC_E_NUMERIC, RIC_E_INPUT: the deviations cannot be carried, and nothing is known. */
static ric_status carried(const ric_force *f, const ric_orbit *orbit, decay *out)
{
    ric_force_medium *medium = NULL;
    ric_force_orbit *o = NULL;
    double rounding, *multipliers = ric_malloc(4 * (size_t)f->n * sizeof *multipliers);
    ric_status status = multipliers ? ric_force_medium_create(f, &medium)
                                    : ric_no_memory("multipliers");
    if (!status) status = ric_force_start_from(medium, orbit, 1, 0, 0, &o);
    if (!status) status = ric_force_motion_multipliers(o, multipliers, &rounding, NULL);
    if (!status) *out = decay_of(f->n, multipliers);
    ric_force_orbit_free(o);
    ric_force_medium_free(medium);
    free(multipliers);
    return status;
}

/* Whether a stored point has another flag, no farther along the branch than the next order moves
 * the orbit: energies move by twice as much as amplitudes. */
static bool flag_changes(const ric_force *f, const ric_branch *b, const ric_orbit *orbit,
                         ric_stability flag, double next_order)
{
    ric_point here, p;
    ric_orbit_data(orbit, &here, NULL, NULL, NULL);
    for (int i = 0; i < b->n_point && !ric_atlas_point(f->atlas, b->id, i, &p, NULL, NULL); i++)
        if (p.stable != (int)flag && fabs(log(p.energy / here.energy)) <= 2 * next_order)
            return true;
    return false;
}

ric_status ric_force_stability(const ric_force *f, const ric_branch *branch, const ric_orbit *orbit,
                               double next_order, ric_stability *out)
{
    decay d;
    const ric_stability flag = ric_orbit_stability(orbit);
    *out = RIC_STABLE_UNDECIDED;
    if (flag == RIC_STABLE_UNDECIDED || !isfinite(next_order) ||
        flag_changes(f, branch, orbit, flag, next_order))
        return RIC_OK;
    if (f->lossless && f->restitution == 1) { /* the pairs stay where they are */
        *out = flag;
        return RIC_OK;
    }
    ric_status status = carried(f, orbit, &d);
    if (status == RIC_E_NUMERIC || status == RIC_E_INPUT) return RIC_OK;
    if (status) return status;
    const double least = next_order * d.typical;
    if (d.slowest > least) *out = RIC_STABLE_NO;
    else if (d.slowest < -least && flag == RIC_STABLE_YES) *out = RIC_STABLE_YES;
    return RIC_OK;
}
