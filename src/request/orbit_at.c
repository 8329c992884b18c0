#include "orbit_at.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "atlas/room.h"
#include "model/room.h"
#include "base/room.h"
#include "stored.h"
#include "branch/room.h"

#define ON_VALUE 4e-16 /* relative: two last digits of the energy or frequency asked for */
/* ITS_VALUE: relative: a stored orbit has the value asked for; at an extremum or an end rounding in
 * other units, or of the junction there, would leave none */
#define ITS_VALUE 1e-14
/* MET: relative: beside a branch point an orbit is known to rounding over the distance */
#define MET 1e-8
#define ITS_FREQUENCY 1e-12 /* relative: a frequency asked for that is that of a linear mode */

/* Orbits of a stored branch, solved again at the very point that is asked for. */

struct ric_orbit {
    const ric_model *model; /* borrowed from the atlas */
    ric_periodic *cycle;    /* NULL for a linear mode */
    ric_point point;
    double *state, *flights;
    double *multipliers;  /* 2 (n - 1) complex */
    double error;         /* of the sum of a pair */
    ric_stability stable; /* as they have it */
};

void ric_orbit_at_free(ric_orbit *o)
{
    if (!o) return;
    ric_periodic_free(o->cycle);
    free(o->state);
    free(o->flights);
    free(o->multipliers);
    free(o);
}

void ric_orbits_free(int n, ric_orbit **orbits)
{
    for (int i = 0; orbits && i < n; i++) ric_orbit_at_free(orbits[i]);
    free(orbits);
}

/* -------------------------------------------------------------- one orbit */

/* Everything that leaves, from a converged chain. */
static ric_status finish(const ric_model *m, ric_shooting *c, const double *u, const ric_turn *t,
                         const ric_point *stored, ric_orbit **out)
{
    ric_status status = RIC_OK;
    ric_floquet floquet = {0};
    ric_orbit *o = ric_calloc(1, sizeof *o);
    int n = m->n;
    *out = NULL;
    if (!o) return ric_no_memory("an orbit");
    if ((status = ric_floquet_create(n, &floquet))) goto out;
    if ((status = ric_continuation_multipliers(c, u, &floquet))) goto out;
    o->cycle = ric_turn_cycle(m, c, u, t);
    int N = o->cycle ? o->cycle->N : 0;
    o->state = ric_calloc(2 * (size_t)m->n_dof, sizeof *o->state);
    o->flights = ric_calloc((size_t)N + 1, sizeof *o->flights);
    o->multipliers = ric_calloc(4 * (size_t)n, sizeof *o->multipliers);
    if (!o->cycle || !o->state || !o->flights || !o->multipliers) {
        status = ric_no_memory("an orbit");
        goto out;
    }
    o->model = m;
    ric_model_to_state(m, o->cycle->w, o->state, o->state + m->n_dof);
    ric_periodic_flights(m, o->cycle, o->flights);
    ric_floquet_multipliers(&floquet, o->multipliers);
    o->error = floquet.error;
    o->stable = floquet.stable;
    const ric_margins margins = ric_continuation_margins(c, u);
    o->point = ric_continuation_point(c, &floquet, &margins, stored->arclength);
    /* what memory was missing for looks undecided or lost, not missing */
    if ((status = ric_trust(RIC_OK))) goto out;
    *out = o;
    o = NULL;
out:
    ric_floquet_release(&floquet);
    ric_orbit_at_free(o);
    return status;
}

static ric_status unfit(const ric_branch *b)
{
    return ric_fail(RIC_E_NUMERIC, "a stored orbit of branch %d does not fit its own symmetries",
                    b->id);
}

static ric_status at_point(const ric_atlas *a, const ric_branch *b, int i, ric_orbit **out)
{
    const ric_model *m = ric_atlas_model(a);
    ric_periodic *cycle;
    ric_shooting *chain = NULL;
    ric_point point;
    double *u = NULL;
    *out = NULL;
    ric_status status = ric_stored_cycle(a, b, i, &point, &cycle);
    if (!status) status = ric_stored_symmetries(a, b, i, cycle);
    if (!status) status = ric_stored_chain(m, b, i, cycle, &chain, &u);
    ric_turn t;
    if (!status && !ric_turn_find(m, chain, u, cycle, &t)) status = unfit(b);
    if (!status) status = finish(m, chain, u, &t, &point, out);
    /* as it is stored: the same numbers, not merely equal ones */
    if (!status)
        status = ric_atlas_point(a, b->id, i, &(*out)->point, (*out)->state, (*out)->flights);
    if (!status) ric_stored_multipliers(m, &point, (*out)->multipliers);
    ric_shooting_free(chain);
    ric_periodic_free(cycle);
    free(u);
    return status;
}

/* ------------------------------------------------------------- in between */

static double quantity(const ric_model *m, const ric_shooting *c, const double *u, ric_at at)
{
    return at == RIC_AT_ENERGY ? ric_shooting_energy(c) * m->energy_unit
                               : RIC_TWO_PI / ric_shooting_time(c, u) * m->omega_ref;
}

/* Along the chord between two stored points, each trial solved in the plane across it. False where
 * none has the value: Newton's method may have gone over to another branch on one side of it. */
static bool solve_between(const ric_model *m, ric_shooting *c, const double *ua, const double *ub,
                          double fa, double fb, ric_at at, double value, double *u)
{
    int size = c->n_unknown, iterations;
    double normal[size], du[size], length = 0;
    for (int i = 0; i < size; i++) {
        normal[i] = ub[i] - ua[i];
        length += normal[i] * normal[i];
    }
    length = sqrt(length);
    for (int i = 0; i < size; i++) normal[i] /= length;
    ric_root r = ric_root_between(0, fa, length, fb, RIC_LAST_DIGIT / 2 * length);
    while (ric_root_next(&r)) {
        for (int i = 0; i < size; i++) u[i] = ua[i] + r.x / length * (ub[i] - ua[i]);
        if (!ric_continuation_correct(c, u, ua, normal, r.x, du, &iterations)) return false;
        r.f = quantity(m, c, u, at) - value;
        r.noise = ON_VALUE * fabs(value);
    }
    return fabs(quantity(m, c, u, at) - value) <= MET * fabs(value);
}

static ric_status between_points(const ric_atlas *a, const ric_branch *b, int i, ric_at at,
                                 double value, double fa, double fb, ric_orbit **out)
{
    const ric_model *m = ric_atlas_model(a);
    ric_periodic *from = NULL, *to = NULL;
    ric_shooting *chain = NULL, *other = NULL;
    double *ua = NULL, *ub = NULL, *u = NULL;
    ric_point point, far;
    *out = NULL;
    ric_status status = ric_stored_cycle(a, b, i, &point, &from);
    if (!status) status = ric_stored_cycle(a, b, i + 1, &far, &to);
    if (!status) status = ric_stored_symmetries(a, b, i, from);
    if (status) goto out;
    ric_periodic_take_symmetries(to, from);
    if ((status = ric_stored_chain(m, b, i, from, &chain, &ua)) ||
        (status = ric_stored_chain(m, b, i + 1, to, &other, &ub)))
        goto out;
    if (!(u = ric_calloc((size_t)chain->n_unknown, sizeof *u))) {
        status = ric_no_memory("an orbit");
        goto out;
    }
    ric_turn t;
    if (!ric_turn_find(m, chain, ua, from, &t)) status = unfit(b);
    else if (!solve_between(m, chain, ua, ub, fa, fb, at, value, u))
        status =
            ric_fail(RIC_E_NUMERIC,
                     "no orbit with this value converged between points %d and %d of branch %d", i,
                     i + 1, b->id);
    else {
        double x = fa / (fa - fb);
        point.arclength += x * (far.arclength - point.arclength);
        status = finish(m, chain, u, &t, &point, out);
    }
out:
    ric_shooting_free(chain);
    ric_shooting_free(other);
    ric_periodic_free(from);
    ric_periodic_free(to);
    free(ua);
    free(ub);
    free(u);
    return status;
}

/* Three neighbouring stored points as unknowns of one problem. */
typedef struct {
    ric_periodic *cycle[3];
    ric_shooting *chain[3];
    double *u[3];
    ric_point point[3];
} trio;

static void trio_free(trio *t)
{
    for (int k = 0; k < 3; k++) {
        ric_periodic_free(t->cycle[k]);
        ric_shooting_free(t->chain[k]);
        free(t->u[k]);
    }
}

static ric_status trio_create(const ric_atlas *a, const ric_branch *b, const int points[3], trio *t)
{
    ric_status status = RIC_OK;
    *t = (trio){0};
    for (int k = 0; k < 3 && !status; k++)
        status = ric_stored_cycle(a, b, points[k], &t->point[k], &t->cycle[k]);
    if (!status) status = ric_stored_symmetries(a, b, points[1], t->cycle[1]);
    for (int k = 0; k < 3 && !status; k++) {
        if (k != 1) ric_periodic_take_symmetries(t->cycle[k], t->cycle[1]);
        status = ric_stored_chain(ric_atlas_model(a), b, points[k], t->cycle[k], &t->chain[k],
                                  &t->u[k]);
    }
    return status;
}

/* Newton's method in the plane, from the parabola through the three. */
static bool solve_across(const trio *t, double x, double *u)
{
    const int size = t->chain[1]->n_unknown;
    double normal[size], du[size], length = 0, middle = 0;
    int iterations;
    for (int k = 0; k < size; k++) normal[k] = t->u[2][k] - t->u[0][k];
    length = sqrt(ric_dot(size, normal, normal));
    for (int k = 0; k < size; k++) {
        normal[k] /= length;
        middle += normal[k] * (t->u[1][k] - t->u[0][k]) / length;
    }
    for (int k = 0; k < size; k++)
        u[k] = t->u[0][k] * (x - middle) * (x - 1) / middle +
               t->u[1][k] * x * (1 - x) / (middle * (1 - middle)) +
               t->u[2][k] * x * (x - middle) / (1 - middle);
    return ric_continuation_correct(t->chain[1], u, t->u[0], normal, x * length, du, &iterations);
}

ric_status ric_orbit_at_chord(const ric_atlas *a, const ric_branch *b, const int points[3],
                              double x, ric_orbit **out)
{
    const ric_model *m = ric_atlas_model(a);
    trio t;
    ric_turn turn;
    *out = NULL;
    ric_status status = trio_create(a, b, points, &t);
    double *u = status ? NULL : ric_calloc((size_t)t.chain[1]->n_unknown, sizeof *u);
    if (!status && !u) status = ric_no_memory("an orbit");
    if (!status && !ric_turn_find(m, t.chain[1], t.u[1], t.cycle[1], &turn)) status = unfit(b);
    if (!status && !solve_across(&t, x, u))
        status = ric_fail(RIC_E_NUMERIC, "no orbit converged beside point %d of branch %d",
                          points[1], b->id);
    if (!status) {
        t.point[0].arclength += x * (t.point[2].arclength - t.point[0].arclength);
        status = finish(m, t.chain[1], u, &turn, &t.point[0], out);
    }
    trio_free(&t);
    free(u);
    return status;
}

/* ----------------------------------------------------------- linear modes */

static ric_status linear(const ric_atlas *a, const ric_branch *b, double amplitude2, int i,
                         ric_orbit **out)
{
    const ric_model *m = ric_atlas_model(a);
    ric_orbit *o = ric_calloc(1, sizeof *o);
    if (!o) return ric_no_memory("an orbit");
    o->model = m;
    o->state = ric_calloc(2 * (size_t)m->n_dof, sizeof *o->state);
    o->flights = ric_calloc(1, sizeof *o->flights);
    o->multipliers = ric_calloc(4 * (size_t)m->n, sizeof *o->multipliers);
    ric_status status = o->state && o->flights && o->multipliers
                            ? ric_atlas_point(a, b->id, i, &o->point, o->state, o->flights)
                            : ric_no_memory("an orbit");
    if (status) {
        ric_orbit_at_free(o);
        return status;
    }
    double factor = sqrt(amplitude2); /* of the stored state */
    o->stable = RIC_STABLE_YES;
    for (int j = 0; j < 2 * m->n_dof; j++) o->state[j] *= factor;
    o->point.energy *= amplitude2;
    o->point.reach *= factor;
    o->point.arclength *= factor;
    for (int k = 0, out_k = 0; k < m->n; k++) {
        if (m->mode[k] == b->mode - 1 || out_k == m->n - 1) continue;
        double angle = m->frequency[m->mode[k]] * RIC_TWO_PI / b->frequency_min;
        double *p = o->multipliers + 4 * out_k++;
        p[0] = p[2] = cos(angle);
        p[1] = sin(angle);
        p[3] = -p[1];
    }
    *out = o;
    return RIC_OK;
}

static ric_status find_linear(const ric_atlas *a, const ric_branch *b, ric_at at, double value,
                              int *n, ric_orbit **list)
{
    *n = 0;
    if (at == RIC_AT_FREQUENCY) {
        if (fabs(value / b->frequency_min - 1) > ITS_FREQUENCY) return RIC_OK;
        return linear(a, b, 1, b->n_point - 1,
                      &list[(*n)++]); /* all amplitudes fit: the largest stands for them */
    }
    if (at == RIC_AT_ENERGY) {
        if (!(value >= 0 && value <= (1 + ITS_VALUE) * b->energy_max)) return RIC_OK;
        return linear(a, b, b->energy_max > 0 ? value / b->energy_max : 0, b->n_point - 1,
                      &list[(*n)++]);
    }
    return linear(a, b, 1, (int)value, &list[(*n)++]);
}

/* ---------------------------------------------------------------- interface */

ric_status ric_orbit_find(const ric_atlas *a, int branch, ric_at at, double value, int *n,
                          ric_orbit ***out)
{
    ric_branch b;
    ric_status status = ric_atlas_branch(a, branch, &b);
    *n = 0;
    *out = NULL;
    if (status) return status;
    if (at == RIC_AT_POINT && !(value >= 0 && value < b.n_point))
        return ric_fail(RIC_E_RANGE, "branch %d has no point %g; they run from 0 to %d", branch,
                        value, b.n_point - 1);
    ric_orbit **list = ric_calloc((size_t)b.n_point + 1, sizeof *list);
    if (!list) return ric_no_memory("an orbit");
    if (ric_branch_linear(ric_atlas_model(a), &b)) status = find_linear(a, &b, at, value, n, list);
    else if (at == RIC_AT_POINT) status = at_point(a, &b, (int)value, &list[(*n)++]);
    else {
        ric_point p;
        double last = 0;
        for (int i = 0; i < b.n_point && !status; i++) {
            if ((status = ric_atlas_point(a, branch, i, &p, NULL, NULL))) break;
            double f = (at == RIC_AT_ENERGY ? p.energy : p.frequency) - value;
            if (fabs(f) <= ITS_VALUE * fabs(value)) f = 0;
            if (f == 0) status = at_point(a, &b, i, &list[(*n)++]);
            else if (i && last * f < 0 && !ric_branch_steps_over(a, branch, i - 1))
                status = between_points(a, &b, i - 1, at, value, last, f, &list[(*n)++]);
            last = f;
        }
    }
    if (status) {
        ric_orbits_free(*n, list);
        *n = 0;
        return status;
    }
    *out = list;
    return RIC_OK;
}

const ric_model *ric_orbit_model(const ric_orbit *o)
{
    return o->model;
}

int ric_orbit_impacts(const ric_orbit *o)
{
    return o->cycle ? ric_periodic_impacts(ric_periodic_springs(o->model), o->cycle) : 0;
}

int ric_orbit_letters(const ric_orbit *o)
{
    return o->cycle ? ric_periodic_letters(o->cycle) : 0;
}

void ric_orbit_data(const ric_orbit *o, ric_point *point, double *state, double *flights, int *word)
{
    int N = ric_orbit_letters(o);
    if (point) *point = o->point;
    if (state) memcpy(state, o->state, 2 * (size_t)o->model->n_dof * sizeof *state);
    if (flights) memcpy(flights, o->flights, (size_t)(N ? N : 1) * sizeof *flights);
    if (word && N) ric_periodic_word(o->model, o->cycle, word);
}

ric_status ric_orbit_multipliers(const ric_orbit *o, double *out)
{
    memcpy(out, o->multipliers, 4 * (size_t)(o->model->n - 1) * sizeof *out);
    return RIC_OK;
}

double ric_orbit_multiplier_error(const ric_orbit *o)
{
    return o->error;
}

ric_stability ric_orbit_stability(const ric_orbit *o)
{
    return o->stable;
}

ric_status ric_orbit_parting(const ric_orbit *o, int *n, double *out, ric_stability *stable)
{
    const int count = o->cycle ? ric_parting_count(o->model) : 0;
    double error[count + 1];
    const ric_status status = count ? ric_parting_multipliers(o->model, o->cycle, out, error)
                                    : RIC_OK;
    *n = status ? 0 : count;
    *stable = status ? RIC_STABLE_UNDECIDED : ric_parting_stability(count, out, error);
    return status;
}

void ric_orbit_at_time(const ric_orbit *o, double t, double *x, double *v)
{
    const ric_model *m = o->model;
    if (!o->cycle) {
        /* a linear mode: all of its displacement is in one coordinate, seen or not */
        double phase = RIC_TWO_PI * fmod(t, o->flights[0]) / o->flights[0];
        for (int j = 0; j < m->n_dof; j++) {
            x[j] = o->state[j] * cos(phase);
            v[j] = -o->state[j] * sin(phase) * RIC_TWO_PI / o->flights[0];
        }
        return;
    }
    double w[2 * m->n];
    ric_periodic_at_time(m, o->cycle, t * m->omega_ref, w);
    ric_model_to_state(m, w, x, v);
}
