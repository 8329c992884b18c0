/* Branches that leave where the rotation number of an orbit without mirror points passes p / q:
 * orbits of exactly q periods, elliptic or hyperbolic as the theory has it (Meyer 1970), known to
 * the simulator or to CVODE, and told apart again when they come back. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "junction/switching.h"
#include "explore/graph.h"
#include "junction/multiplication.h"

#include "cvode_flow.h"
#include "sample.h"

enum { MAX_SIZE = 200, PER_ORDER = 2, MAX_ORDER = 16 };

/* Nodes of an order that a study is asked for. A node of a structure with a power law, which has no
 * closed form of its flights, takes seconds, one with stops milliseconds. */
static int per_order(bool smooth)
{
    return every() > 1 || (smooth && !long_form()) ? 1 : PER_ORDER;
}

#define EXPLORE                                                                                    \
    "explore: {start: modes, energy: [0, 60], frequency: [0.1, 8], impacts: 9, multiply: 1, "      \
    "depth: 4}\n"

/* The article's model, which has A5[00101]; another of two masses, with a wall on both sides of
 * one; three masses, whose branches without mirror include such with z(t + T/2) = -z(t); two
 * structures with a cubic spring. */
static const char *const studies[] = {
    "model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n"
    "  contacts:\n    - {normal: [-1, 1], clearance: 1, sides: both, law: rigid}\n"
    "explore: {start: modes, energy: [0, 200], frequency: [0.2, 10], impacts: 24, multiply: 1, "
    "depth: 4}\n",
    "model:\n  mass: [[0.637, 0], [0, 1.04]]\n  stiffness: [[6.17, -4.91], [-4.91, 4.91]]\n"
    "  contacts:\n    - {normal: [1, 0], clearance: 1, sides: both, law: rigid}\n" EXPLORE,
    "model:\n  mass: [[0.751, 0, 0], [0, 0.85, 0], [0, 0, 1.76]]\n"
    "  stiffness: [[8.35, -5.32, 0], [-5.32, 8.65, -3.34], [0, -3.34, 6.64]]\n  contacts:\n"
    "    - {normal: [0, 0, 1], clearance: 1, sides: both, law: rigid}\n"
    "    - {normal: [0, 0, 1], clearance: 0.782, sides: both, law: rigid}\n" EXPLORE,
    "model:\n  mass: [[0.55, 0], [0, 1.67]]\n  stiffness: [[5.94, -4.93], [-4.93, 6.83]]\n"
    "  contacts:\n    - {normal: [1, 0], law: power, exponent: 3, stiffness: 1}\n"
    "explore: {start: modes, energy: [0, 500], frequency: [0.15, 20], multiply: 2, depth: 4}\n",
    "model:\n  mass: [[1.28, 0, 0], [0, 1.68, 0], [0, 0, 1.55]]\n"
    "  stiffness: [[1.87, -1.56, 0], [-1.56, 5.37, -2.94], [0, -2.94, 3.15]]\n"
    "  contacts:\n    - {normal: [0, 0, 1], law: power, exponent: 3, stiffness: 1}\n"
    "explore: {start: modes, energy: [0, 500], frequency: [0.15, 20], multiply: 1, depth: 4}\n",
};

/* ------------------------------------------------------------------ helpers */

/* Smallest distance of lambda + 1/lambda of the chain's own map from a value, over real pairs; its
 * error (may be NULL). */
static double off_by(ric_shooting *c, const double *u, double value, double *error)
{
    ric_floquet f;
    double best = HUGE_VAL;
    assert_int_equal(ric_floquet_create(c->n, &f), RIC_OK);
    ric_shooting_evaluate(c, u);
    if (ric_floquet_compute(c, &f)) fail_msg("%s", ric_detail());
    for (int i = 0; i < f.n_pair; i++)
        if (fabs(f.own[2 * i + 1]) < 1e-9 && fabs(f.own[2 * i] - value) < fabs(best))
            best = f.own[2 * i] - value;
    if (error) *error = f.error;
    ric_floquet_release(&f);
    return best;
}

static const double *unknowns(const ric_continuation *tr, int i)
{
    return tr->points + (size_t)i * tr->stride + sizeof(ric_point) / sizeof(double);
}

/* Bisection between points i and i + 1 of a branch for the rotation p / q. */
static bool locate(ric_continuation *tr, int i, double target, double *u)
{
    ric_shooting *c = tr->chain;
    const double *a = unknowns(tr, i), *b = unknowns(tr, i + 1);
    int size = c->n_unknown, iterations;
    double normal[MAX_SIZE], du[MAX_SIZE],
        lo = 0, hi = 1, length = 0, fa = off_by(c, a, target, NULL), f = off_by(c, b, target, NULL);
    if (!(fa * f < 0) || fabs(fa) + fabs(f) > 3) return false;
    for (int j = 0; j < size; j++) {
        normal[j] = b[j] - a[j];
        length += normal[j] * normal[j];
    }
    for (int k = 0; k < 45; k++) {
        double x = (lo + hi) / 2;
        for (int j = 0; j < size; j++) u[j] = a[j] + x * normal[j];
        if (!ric_continuation_correct(c, u, a, normal, x * length, du, &iterations)) return false;
        f = off_by(c, u, target, NULL);
        if (f * fa > 0) lo = x;
        else hi = x;
    }
    return fabs(f) < 1e-6;
}

static double return_tolerance(ric_shooting *c, const double *u)
{
    ric_floquet f;
    double largest = 1;
    assert_int_equal(ric_floquet_create(c->n, &f), RIC_OK);
    ric_shooting_evaluate(c, u);
    assert_int_equal(ric_floquet_compute(c, &f), RIC_OK);
    for (int i = 0; i < f.n_pair; i++)
        largest = fmax(largest, hypot(f.rho[2 * i], f.rho[2 * i + 1]));
    ric_floquet_release(&f);
    /* docs/theory.md section 11: what the state is solved to, times the multiplier */
    return fmax(1e-9, ric_continuation_tolerance(c) * largest);
}

/* CVODE comes back after the full period, as far as it is sure of itself. */
static void integrate(const ric_model *m, const ric_periodic *cycle, double tolerance,
                      const char *where)
{
    int n = m->n_dof;
    double x[n], v[n], x1[n], v1[n], off = 0, size = 0;
    ric_contact contact;
    assert_int_equal(ric_model_contact(m, 0, &contact), RIC_OK);
    ric_model_to_state(m, cycle->w, x, v);
    memcpy(x1, x, sizeof x);
    memcpy(v1, v, sizeof v);
    double sure = cvode_fly(m, n, ric_model_mass(m), ric_model_stiffness(m), 1, &contact,
                            ric_periodic_period(cycle) / m->omega_ref, x1, v1);
    for (int i = 0; i < n; i++) {
        off = fmax(off, fmax(fabs(x1[i] - x[i]), fabs(v1[i] - v[i])));
        size = fmax(size, fmax(fabs(x[i]), fabs(v[i])));
    }
    if (!(off <= (tolerance + 10 * sure) * size && sure < 1e-6))
        fail_msg("%s: CVODE returns to %.3g, sure of %.3g", where, off / size, sure);
}

/* The simulator, which shares no code with the solver, meets the same faces and comes back after
 * the full period. */
static void replay(const ric_model *m, const ric_periodic *cycle, double tolerance,
                   const char *where)
{
    if (!ric_model_detached(m)) {
        integrate(m, cycle, tolerance, where);
        return;
    }
    ric_simulator *sim = NULL;
    int n = m->n_dof;
    double x[n], v[n], x1[n], v1[n], end = ric_periodic_period(cycle) / m->omega_ref, off = 0,
                                     size = 1;
    assert_int_equal(ric_simulator_create(m, &sim), RIC_OK);
    ric_model_to_state(m, cycle->w, x, v);
    if (ric_simulator_start(sim, x, v)) fail_msg("%s: %s", where, ric_detail());
    double t = 0;
    for (int k = 1; k <= cycle->N; k++) {
        bool hit;
        ric_impact impact;
        t += cycle->tau[k - 1] / m->omega_ref;
        if (ric_simulator_advance(sim, end * 1.01, &hit, &impact))
            fail_msg("%s: %s", where, ric_detail());
        if (!hit || impact.face != cycle->face[k % cycle->N] ||
            fabs(impact.time - t) > tolerance * (1 + t))
            fail_msg("%s: impact %d on face %d at %.12g, not on %d at %.12g", where, k, impact.face,
                     impact.time, cycle->face[k % cycle->N], t);
    }
    ric_simulator_state(sim, NULL, x1, v1);
    for (int i = 0; i < n; i++) {
        off = fmax(off, fmax(fabs(x1[i] - x[i]), fabs(v1[i] - v[i])));
        size = fmax(size, fmax(fabs(x[i]), fabs(v[i])));
    }
    if (off > tolerance * size)
        fail_msg("%s: returns to %.3g of its start, %.3g allowed", where, off / size, tolerance);
    ric_simulator_free(sim);
}

/* ------------------------------------------------------------------- one node */

typedef struct {
    double energy, off, error; /* off: the pair that came from the multiplier, minus 2 */
    ric_periodic *cycle;
} family;

/* One way out: a solved orbit of exactly q periods beside the node, known to the simulator. */
static family leave(const ric_model *m, const ric_node *node, unsigned choice, int side,
                    const char *where)
{
    ric_outset from;
    double u[MAX_SIZE], distance = 0, period;
    unsigned choice2;
    int side2;
    if (ric_switching_depart(m, node, choice, side, &from)) fail_msg("%s: %s", where, ric_detail());
    ric_shooting *chain = from.chain;
    for (int i = 0; i < chain->n_unknown; i++) {
        u[i] = from.u[i] + from.t[i];
        distance += from.t[i] * from.t[i];
    }
    distance = sqrt(distance) / chain->scale;
    family out = {0};
    out.off = off_by(chain, u, 2, &out.error);
    out.energy = ric_shooting_energy(chain); /* of the evaluation there */
    if (chain->residual > ric_continuation_tolerance(chain))
        fail_msg("%s: residual %.3g, %.3g allowed", where, chain->residual,
                 ric_continuation_tolerance(chain));
    period = ric_shooting_time(chain, u);
    if (fabs(period / (node->multiple * node->period) - 1) > 10 * distance)
        fail_msg("%s: period %.12g, not near %d times %.12g", where, period, node->multiple,
                 node->period);
    out.cycle = ric_periodic_from_chain(chain, u);
    if (ric_periodic_find_symmetries(m, out.cycle, 1e-3 * distance) != 1)
        fail_msg("%s: a repeated orbit at distance %.3g", where, distance);
    replay(m, out.cycle, return_tolerance(chain, u), where);
    ric_periodic *turned = ric_periodic_canonical(m, out.cycle);
    if (ric_multiplication_class(m, node, turned, &choice2, &side2))
        fail_msg("%s: %s", where, ric_detail());
    if (choice2 != choice || side2 != side)
        fail_msg("%s: taken for %u, side %d", where, choice2, side2);
    ric_periodic_free(turned);
    ric_outset_clear(&from);
    return out;
}

/* Ways back to a node, and those that missed it; an atlas says `the way back does not lead home`
 * then. */
static int ways, missed;

/* Whether the node was found again. */
static bool check_home(bool found, const char *where)
{
    ways++;
    missed += !found;
    if (!found) fprintf(stderr, "%s: the way back does not lead home\n", where);
    return found;
}

/* Back from a point of the branch to the node, which is found there again. Order 3 passes. */
static void come_back(const ric_model *m, const ric_continuation *tr, const ric_node *node,
                      unsigned choice, const char *where)
{
    const double *from = unknowns(tr, tr->n_point - 1), *to = unknowns(tr, tr->n_point - 2);
    bool passes = ric_node_passes(node, choice), found = false;
    double t[MAX_SIZE];
    ric_continuation *back = NULL;
    ric_node *home = NULL;
    ric_limits limits = *tr->limits;
    limits.max_points = passes ? 30 : 300;
    for (int i = 0; i < tr->chain->n_unknown; i++) t[i] = to[i] - from[i];
    if (ric_continuation_create(ric_shooting_copy(tr->chain), from, t, (1u << RIC_N_TEST) - 1,
                                &limits, &back) ||
        ric_continuation_run(back))
        fail_msg("%s: %s", where, ric_detail());
    for (int i = passes ? 0 : -1;
         (passes || back->arrival) && i < (passes ? back->n_event : 0) && !found; i++) {
        ric_shooting_fly(back->chain, i < 0 ? back->end.u : back->events[i].u);
        ric_periodic *cycle = ric_periodic_from_chain(back->chain,
                                                      i < 0 ? back->end.u : back->events[i].u);
        if (!ric_node_arrival(m, cycle, &home) && ric_node_same(m, node, home)) found = true;
        ric_periodic_free(cycle);
        ric_node_free(home);
        home = NULL;
    }
    if (check_home(found, where) && !passes) {
        unsigned arrived;
        int side;
        ric_shooting_fly(back->chain, unknowns(back, back->n_point - 2));
        ric_periodic *near = ric_periodic_from_chain(back->chain,
                                                     unknowns(back, back->n_point - 2));
        if (ric_multiplication_class(m, node, near, &arrived, &side) || arrived != choice)
            fail_msg("%s: comes back as %u, not %u", where, arrived, choice);
        ric_periodic_free(near);
    }
    ric_continuation_free(back);
}

/* The branch itself: it begins at the node and goes on from there to orbits of its own. */
static void follow(const ric_model *m, const ric_limits *window, const ric_node *node,
                   unsigned choice, int side, const char *where)
{
    ric_limits limits = *window;
    ric_outset from;
    ric_continuation *tr = NULL;
    limits.max_points = 5;
    if (ric_switching_depart(m, node, choice, side, &from) ||
        ric_continuation_create(from.chain, from.u, from.t, from.ignore, &limits, &tr) ||
        ric_continuation_run(tr))
        fail_msg("%s: %s", where, ric_detail());
    from.chain = NULL;
    if (tr->stop == RIC_STOP_FAILED || tr->n_point < 3)
        fail_msg("%s: stops after %d points, %s", where, tr->n_point, tr->why);
    assert_memory_equal(unknowns(tr, 0), from.u, (size_t)tr->chain->n_unknown * sizeof *from.u);
    for (int i = 1; i < tr->n_point; i++) {
        const double *u = unknowns(tr, i);
        ric_shooting_fly(tr->chain, u);
        ric_periodic *cycle = ric_periodic_from_chain(tr->chain, u);
        if (ric_periodic_find_symmetries(m, cycle, 1e-6) != 1)
            fail_msg("%s: point %d is a repeated orbit", where, i);
        ric_periodic_free(cycle);
    }
    come_back(m, tr, node, choice, where);
    ric_continuation_free(tr);
    ric_outset_clear(&from);
}

static int types_checked[MAX_ORDER];

/* Order 3: hyperbolic both ways. Order 4: one of each, or both hyperbolic. Above: one of each. The
 * elliptic one comes first. */
static void check_types(int order, const family f[2], const char *where)
{
    bool elliptic[2] = {f[0].off < 0, f[1].off < 0};
    /* another pair of the order of 1e6 drowns it */
    if (fabs(f[0].off) < f[0].error || fabs(f[1].off) < f[1].error) return;
    types_checked[order]++;
    if (elliptic[1] || (order > 4 && !elliptic[0]) || (order == 3 && elliptic[0]))
        fail_msg("%s: lambda + 1/lambda - 2 is %.6g and %.6g at order %d", where, f[0].off,
                 f[1].off, order);
    if (!elliptic[0] && !(f[0].energy < f[1].energy))
        fail_msg("%s: energies %.12g and %.12g", where, f[0].energy, f[1].energy);
}

static void check_node(const ric_model *m, const ric_limits *limits, const ric_node *node,
                       const char *where)
{
    int order = ric_symmetry_order(node->cycle, node->rotation[0], node->rotation[1]);
    bool two = node->n_departure > 2;
    ric_turn turn;
    family f[2];
    for (int i = 0; i < 2; i++) {
        unsigned choice = two && i ? RIC_OTHER_SIDE : RIC_SIDE;
        assert_true(ric_multiplication_applies(node, choice));
        f[i] = leave(m, node, choice, i && !two ? -1 : 1, where);
        follow(m, limits, node, choice, i && !two ? -1 : 1, where);
    }
    check_types(order, f, where);
    if (ric_periodic_match(m, f[0].cycle, f[1].cycle, 1e-6, &turn))
        fail_msg("%s: both ways lead to one orbit", where);
    for (int i = 0; i < 2; i++) ric_periodic_free(f[i].cycle);
}

/* ---------------------------------------------------------------- the branches */

/* count [2][MAX_ORDER]: nodes checked, by sigma and order, of multiplications by `largest` at most.
 */
static void check_branch(const ric_graph *g, ric_continuation *tr, const char *name, int largest,
                         int count[2][MAX_ORDER])
{
    static const int rotations[][2] = {{1, 3}, {2, 3}, {1, 4}, {3, 4}, {1, 5},
                                       {2, 5}, {4, 5}, {1, 7}, {2, 7}, {3, 7}};
    ric_shooting *c = tr->chain;
    const int most = per_order(!ric_model_detached(g->model));
    bool half = c->sigma < 0;
    double u[MAX_SIZE];
    char where[128];
    assert_true(c->n_unknown < MAX_SIZE);
    for (int k = 0; k < (int)(sizeof rotations / sizeof *rotations); k++)
        for (int i = 0; i + 1 < tr->n_point; i++) {
            int p = rotations[k][0], q = rotations[k][1], order = half && p % 2 ? 2 * q : q;
            if (q > largest || (!half && 2 * p > q) || count[half][order] == most ||
                !locate(tr, i, ric_symmetry_rho(half, p, q), u))
                continue;
            ric_periodic *cycle = ric_periodic_from_chain(c, u);
            ric_node *node = NULL;
            snprintf(where, sizeof where, "%s, %d impacts, sigma %d, %d/%d at E %.9g", name,
                     cycle->N, c->sigma, p, q, ric_shooting_energy(c));
            if (ric_node_multiplication(g->model, cycle, p, q, &node))
                fail_msg("%s: %s", where, ric_detail());
            check_node(g->model, &g->limits, node, where);
            count[half][order]++;
            ric_node_free(node);
            ric_periodic_free(cycle);
        }
}

static void check_study(int which, int count[2][MAX_ORDER])
{
    ric_study *study = NULL;
    ric_graph *g = NULL;
    char name[32];
    snprintf(name, sizeof name, "study %d", which);
    if (ric_study_parse(studies[which], name, ".", &study)) fail_msg("%s", ric_detail());
    if (ric_graph_create(study, NULL, &g) || ric_graph_explore(g, NULL))
        fail_msg("%s", ric_detail());
    const int largest = ric_model_detached(g->model) ? 7
                        : long_form()                ? 5
                                      : 4; /* a node under a power law takes seconds */
    for (int i = 0; i < g->n_edge; i++)
        if (g->edges[i].trace->chain->start == RIC_MIRROR_NONE)
            check_branch(g, g->edges[i].trace, name, largest, count);
    ric_graph_free(g);
    ric_study_free(study);
}

static void two_masses(void **state)
{
    (void)state;
    int count[2][MAX_ORDER] = {{0}};
    check_study(0, count);
    assert_true(count[0][4] && count[0][5] && count[0][7]);
    check_study(1, count);
    assert_true(count[0][3] && count[0][4] && count[0][5] == PER_ORDER && count[0][7] == PER_ORDER);
    assert_true(types_checked[3] && types_checked[4] && types_checked[5] > 1 &&
                types_checked[7] > 1);
}

static void three_masses(void **state)
{
    (void)state;
    int count[2][MAX_ORDER] = {{0}};
    check_study(2, count);
    assert_true(count[0][3] && count[0][4] && count[0][5] && count[0][7]);
    assert_true(count[1][3] && count[1][5]); /* of half a period */
}

/* A cubic spring at one of three masses; of two, whose nodes take seconds each, in the long form.
 */
static void cubic_spring(void **state)
{
    (void)state;
    int two[2][MAX_ORDER] = {{0}}, three[2][MAX_ORDER] = {{0}};
    const int most = per_order(true);
    if (long_form()) {
        check_study(3, two);
        assert_true(two[0][3] == most && two[0][4] == most && two[0][5] == most);
    }
    check_study(4, three);
    assert_true(three[0][3] && three[0][4] && (three[0][5] || !long_form()));
}

static void all_ways_lead_home(void **state)
{
    (void)state;
    printf("# %d ways back, %d missed\n", ways, missed);
    assert_true(ways > (long_form() ? 60 : 35));
    assert_int_equal(missed, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(two_masses), cmocka_unit_test(three_masses),
                                       cmocka_unit_test(cubic_spring),
                                       cmocka_unit_test(all_ways_lead_home)};
    return cmocka_run_group_tests_name("ring", tests, NULL, NULL);
}
