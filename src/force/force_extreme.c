/* Where the threshold F* = D / |V| along a branch is least, or largest (docs/forcing.md).
 *
 * Three stored points tell that there is one. Between the outer two log F* is an analytic function
 * of the place x on their chord; what is sought is the zero of the derivative of its Chebyshev
 * interpolant, on windows around it that are halved: first the interpolant is too poor, at last
 * rounding over the width of the window is left, and where two windows agree best is the answer,
 * and their difference its error (Trefethen, Approximation Theory and Approximation Practice, SIAM
 * 2013). A search for the least value itself would know its place to half the digits only. */
#include <complex.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "force.h"
#include "request/room.h"

#define FIRST_HALF 0.25 /* of the chord: half the second window; the first is the whole chord */
#define WELL_DONE 1e-13 /* of the chord: no later window knows the place better */
#define FLAT 1e-12      /* of log F*: what rounding and quadrature leave */
/* RESOLVED: relative: last coefficients of an interpolant that says where the place is */
#define RESOLVED 1e-11

enum { NODES = 16, WINDOWS = 9, GRID = 64 /* places where the derivative is looked at */ };

typedef struct {
    const ric_force *force;
    ric_branch branch;
    int harmonic, at[3]; /* stored points, the outer two of them the ends of a chord */
} ridge;

/* log F* and V of an orbit; false: no work is done. */
static bool look(const ridge *r, const ric_orbit *orbit, double *log_threshold,
                 double _Complex *work)
{
    ric_force_balance sum;
    if (ric_force_balance_of(r->force, orbit, false, r->harmonic, &sum) ||
        !ric_force_predict_works(&sum))
        return false;
    *work = sum.work[0] + I * sum.work[1];
    *log_threshold = log((sum.damping + sum.impacts) / cabs(*work));
    return isfinite(*log_threshold);
}

static bool look_at(const ridge *r, double x, double *out)
{
    ric_orbit *orbit = NULL;
    double _Complex work;
    const bool found = !ric_orbit_at_chord(r->force->atlas, &r->branch, r->at, x, &orbit) &&
                       look(r, orbit, out, &work);
    ric_orbit_at_free(orbit);
    return found;
}

/* ------------------------------------------------------------- interpolants */

/* Chebyshev coefficients of log F* at centre + half t, |t| <= 1; the size of the last ones. */
static bool interpolate(const ridge *r, double centre, double half, double *c, double *last)
{
    double y[NODES], mean = 0;
    for (int k = 0; k < NODES; k++) {
        if (!look_at(r, centre + half * cos(RIC_PI * (k + 0.5) / NODES), &y[k])) return false;
        mean += y[k] / NODES;
    }
    for (int j = 0; j < NODES; j++) {
        c[j] = 0;
        for (int k = 0; k < NODES; k++)
            c[j] += 2.0 / NODES * (y[k] - mean) * cos(RIC_PI * j * (k + 0.5) / NODES);
    }
    *last = fmax(fabs(c[NODES - 1]), fabs(c[NODES - 2]));
    return true;
}

/* Derivative by t: sum c_j T_j' = sum j c_j U_{j-1}. */
static double slope(const double *c, double t)
{
    double sum = 0, before = 0, now = 1;
    for (int j = 1; j < NODES; j++) {
        const double next = 2 * t * now - before;
        sum += j * c[j] * now;
        before = now;
        now = next;
    }
    return sum;
}

/* The zero of the derivative nearest to t = 0, from falling to rising of a minimum. */
static bool turning(const double *c, bool minimum, double *out)
{
    double best = INFINITY;
    for (int k = 0; k < GRID; k++) {
        const double a = -1 + 2.0 * k / GRID, b = a + 2.0 / GRID, fa = slope(c, a),
                     fb = slope(c, b);
        if ((fa < 0) != minimum || (fb < 0) == minimum) continue;
        ric_root root = ric_root_between(a, fa, b, fb, 0);
        while (ric_root_next(&root)) root.f = slope(c, root.x);
        if (fabs(root.x) < fabs(best)) best = root.x;
    }
    *out = best;
    return isfinite(best);
}

/* Its place on the chord and how well that is known; NaN: not at all. */
static void locate(const ridge *r, bool minimum, double *x, double *error)
{
    double centre = 0.5, half = 0.5, c[NODES], t, last;
    *x = *error = NAN;
    for (int k = 0; k < WINDOWS && !(*error < WELL_DONE); k++) {
        if (!interpolate(r, centre, half, c, &last) || !turning(c, minimum, &t)) break;
        const double at = centre + half * t, moved = k ? fabs(at - centre) : INFINITY;
        if (last < RESOLVED && !(moved >= *error)) {
            *error = moved;
            *x = at;
        }
        centre = fmin(1, fmax(0, at));
        half = fmin(half / 2, k ? half / 2 : FIRST_HALF);
    }
}

/* --------------------------------------------------------------- the branch */

typedef struct {
    bool known; /* whether the force does work there */
    double log_threshold;
    double _Complex work;
} sample;

/* Stored points of a branch; those without energy, which move nothing, are not known. */
static ric_status sample_all(const ridge *r, sample *out)
{
    ric_status status = RIC_OK;
    for (int i = 0; i < r->branch.n_point && !status; i++) {
        ric_orbit **orbits = NULL;
        ric_point point;
        int n = 0;
        status = ric_atlas_point(r->force->atlas, r->branch.id, i, &point, NULL, NULL);
        if (status || !(point.energy > 0)) continue;
        status = ric_orbit_find(r->force->atlas, r->branch.id, RIC_AT_POINT, i, &n, &orbits);
        if (!status) out[i].known = look(r, orbits[0], &out[i].log_threshold, &out[i].work);
        ric_orbits_free(n, orbits);
    }
    return status;
}

/* Points of the branch at places of their own, as a junction may be stored twice; how many. */
static int places_of(const ridge *r, int *out)
{
    int n = 0;
    double last = NAN;
    for (int i = 0; i < r->branch.n_point; i++) {
        ric_point p;
        if (ric_atlas_point(r->force->atlas, r->branch.id, i, &p, NULL, NULL)) break;
        if (n > 0 && fabs(p.arclength - last) <= RIC_TIE * (1 + fabs(last))) continue;
        out[n++] = i;
        last = p.arclength;
    }
    return n;
}

/* Whether a tongue was stepped over between two stored points: they are not neighbours on one
 * curve. */
static bool torn(const ridge *r)
{
    for (int i = r->at[0]; i < r->at[2]; i++)
        if (ric_branch_steps_over(r->force->atlas, r->branch.id, i)) return true;
    return false;
}

/* 1: F* is larger in the middle than on both sides, -1: smaller, 0: neither, or V passes through 0,
 * and no force is large enough there. */
static int bends(const sample *a, const sample *b, const sample *c)
{
    if (!a->known || !b->known || !c->known) return 0;
    const double before = b->log_threshold - a->log_threshold,
                 behind = c->log_threshold - b->log_threshold;
    if (before < -FLAT && behind > FLAT) return -1;
    return before > FLAT && behind < -FLAT && creal(a->work * conj(c->work)) > 0;
}

/* The orbit there and what is predicted of it; where it is not located, the stored one. */
static ric_status extreme_at(ridge *r, bool birth, ric_force_extreme *out)
{
    double x, error;
    ric_orbit *orbit = NULL, **stored = NULL;
    ric_point from, to;
    int n = 0;
    locate(r, birth, &x, &error);
    const bool located = !isnan(x) && isfinite(error);
    ric_status status = located ? ric_orbit_at_chord(r->force->atlas, &r->branch, r->at, x, &orbit)
                                : ric_orbit_find(r->force->atlas, r->branch.id, RIC_AT_POINT,
                                                 r->at[1], &n, &stored);
    if (!status)
        status = ric_force_predict(r->force, r->branch.id, located ? orbit : stored[0], r->harmonic,
                                   0, &out->at);
    if (!status)
        status = ric_atlas_point(r->force->atlas, r->branch.id, r->at[0], &from, NULL, NULL);
    if (!status) status = ric_atlas_point(r->force->atlas, r->branch.id, r->at[2], &to, NULL, NULL);
    if (!status) {
        ric_point point;
        ric_orbit_data(located ? orbit : stored[0], &point, NULL, NULL, NULL);
        out->arclength = point.arclength;
        out->birth = birth;
        out->error = located ? error * fmax(fabs(log(to.energy / from.energy)),
                                            fabs(log(to.frequency / from.frequency)))
                             : NAN;
    }
    ric_orbit_at_free(orbit);
    ric_orbits_free(n, stored);
    return status;
}

ric_status ric_force_extremes(const ric_force *f, int branch, int harmonic, int *n,
                              ric_force_extreme **out)
{
    ridge r = {.force = f, .harmonic = harmonic};
    ric_status status = ric_atlas_branch(f->atlas, branch, &r.branch);
    *n = 0;
    *out = NULL;
    if (status) return status;
    if (harmonic < 1)
        return ric_fail(RIC_E_INPUT, "harmonic %d; harmonics are 1, 2, 3, ...", harmonic);
    if (ric_branch_linear(f->model, &r.branch)) return RIC_OK; /* F* grows with the amplitude */
    sample *s = ric_calloc((size_t)r.branch.n_point + 1, sizeof *s);
    int *place = ric_calloc((size_t)r.branch.n_point + 1, sizeof *place);
    ric_force_extreme *list = ric_calloc((size_t)r.branch.n_point + 1, sizeof *list);
    status = s && place && list ? sample_all(&r, s) : ric_no_memory("extrema of the threshold");
    const int count = status ? 0 : places_of(&r, place);
    for (int i = 1; i + 1 < count && !status; i++) {
        const int way = bends(&s[place[i - 1]], &s[place[i]], &s[place[i + 1]]);
        memcpy(r.at, place + i - 1, sizeof r.at);
        if (!way || torn(&r)) continue;
        status = extreme_at(&r, way < 0, &list[*n]);
        *n += !status;
    }
    free(s);
    free(place);
    if (!status) *out = list;
    else free(list);
    return status;
}

void ric_force_extremes_free(ric_force_extreme *list)
{
    free(list);
}
