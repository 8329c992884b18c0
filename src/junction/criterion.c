#include "criterion.h"

#include <stdlib.h>
#include <string.h>

#include "base/room.h"

/* UNDECIDED: which of the problems of a multiplication has the kernel is not known yet */
#define UNDECIDED (-1)

ric_criterion_work ric_criterion_begin(ric_criterion what, ric_shooting *chain)
{
    return (ric_criterion_work){.chain = chain,
                                .test = what.test,
                                .rotation = {what.rotation[0], what.rotation[1]},
                                .asked = what.asked,
                                .choice = what.test == RIC_TEST_ROTATION ? UNDECIDED : 0};
}

void ric_criterion_release(ric_criterion_work *q)
{
    ric_floquet_release(&q->floquet);
    free(q->along);
    q->along = NULL;
}

/* The problem with fewer symmetries whose determinant vanishes at the junction. */
static ric_symmetry smaller_problem(ric_criterion_work *q, const ric_periodic *cycle)
{
    ric_symmetry problems[2];
    if (q->test != RIC_TEST_ROTATION) return ric_symmetry_breaking(cycle, q->test);
    int count = ric_symmetry_multiplying(cycle, q->rotation[0], q->rotation[1], problems);
    /* which is which depends on where the cycle starts: decided once, on the first one seen */
    if (q->choice == UNDECIDED)
        q->choice = count == 2 && ric_symmetry_singular(q->chain->model, cycle, problems, NULL);
    return problems[q->choice];
}

/* Bordered determinant of a problem with fewer symmetries, or over several periods, at the orbit u:
 * it vanishes where the factors of section 5 do, or where the multiplier is a root of unity, but
 * does not divide by impact speeds and keeps its digits however unstable the orbit is. */
static double larger_determinant(ric_criterion_work *q, const double *u)
{
    ric_shooting *large = NULL;
    double *v = NULL, value = NAN;
    ric_periodic *here = ric_periodic_from_chain(q->chain, u), *cycle = NULL;
    if (here) {
        ric_symmetry problem = smaller_problem(q, here);
        cycle = ric_symmetry_cycle(here, &problem);
    }
    if (cycle && !ric_periodic_to_chain(q->chain->model, cycle, &large, &v)) {
        double t[large->n_unknown];
        ric_shooting_evaluate(large, v);
        double sign = ric_continuation_tangent(large, q->along, t);
        value = sign * large->end_det;
        q->noise = ric_continuation_tolerance(large) * fabs(large->end_det / large->smallest);
        q->n_along = large->n_unknown;
        if (!q->along) q->along = ric_malloc(sizeof t);
        if (q->along) memcpy(q->along, t, sizeof t);
    }
    ric_shooting_free(large);
    ric_periodic_free(here);
    ric_periodic_free(cycle);
    free(v);
    return value;
}

/* Distance of the nearest pair from lambda + 1/lambda of the multiplier sought, on the chain's own
 * map: where the period is its square, that of the period only touches -2. q->aside: its imaginary
 * part. */
double ric_criterion_off_rotation(ric_criterion_work *q)
{
    const ric_shooting *c = q->chain;
    q->aside = HUGE_VAL;
    if (ric_floquet_compute(c, &q->floquet)) return NAN;
    double nearest = HUGE_VAL,
           target = ric_symmetry_rho(ric_shooting_halves(c), q->rotation[0], q->rotation[1]);
    for (int i = 0; i < q->floquet.n_pair; i++) {
        double off = q->floquet.own[2 * i] - target, aside = fabs(q->floquet.own[2 * i + 1]);
        if (!(hypot(off, aside) < hypot(nearest, q->aside))) continue;
        nearest = off;
        q->aside = aside;
    }
    return nearest;
}

/* Whether the determinant of the larger problem tells a multiplication: it passes zero where one
 * direction is lost. That is so between mirror points, and at a doubling of the period's own map
 * without them; of higher order without mirror points two directions are lost at once, and it only
 * touches zero. */
bool ric_criterion_by_larger(const ric_criterion_work *q)
{
    return q->chain->start != RIC_MIRROR_NONE ||
           (q->rotation[1] == 2 && !ric_shooting_halves(q->chain));
}

static double off_asked(const ric_criterion_work *q, const double *u)
{
    const ric_model *m = q->chain->model;
    return ric_user_point_off(q->asked, ric_shooting_energy(q->chain) * m->energy_unit,
                              RIC_TWO_PI / ric_shooting_time(q->chain, u) * m->omega_ref);
}

double ric_criterion_value(ric_criterion_work *q, const double *u, const double *t,
                           double orientation)
{
    const ric_shooting *c = q->chain;
    switch (q->test) {
    case RIC_TEST_APPROACH: return q->soft ? q->u[c->n_start + q->place] : c->approach[q->place];
    case RIC_TEST_SLOPE: return ric_shooting_energy_slope(c, t) / c->scale;
    case RIC_TEST_DET: return orientation * c->end_det;
    case RIC_TEST_FLIGHT: return q->u[c->n_start + q->place];
    case RIC_TEST_PERIOD: {
        double sum = 0;
        for (int k = c->n_start; k < c->n_start + c->n_flight; k++) sum += t[k];
        return sum;
    }
    case RIC_TEST_ASKED: return off_asked(q, u);
    case RIC_TEST_ROTATION:
        return ric_criterion_by_larger(q) ? larger_determinant(q, u)
                                          : ric_criterion_off_rotation(q);
    default: return larger_determinant(q, u);
    }
}

bool ric_criterion_breaks_symmetry(int test)
{
    return test == RIC_TEST_A || test == RIC_TEST_B || test == RIC_TEST_D;
}

int ric_criterion_shortest(const ric_shooting *c, const double *u)
{
    const ric_model *m = c->model;
    int best = -1;
    for (int k = 0; k < c->n_flight; k++) {
        int f = c->face[k], g = c->face[k + 1];
        if (f < 0 || g < 0 || m->face[f].contact == m->face[g].contact) continue;
        if (best < 0 || u[c->n_start + k] < u[c->n_start + best]) best = k;
    }
    return best;
}
