/* Branch points with twice the digits: those of double precision where that suffices, in two forms
 * of the problem, and where it does not the same from everywhere. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "explored.h"
#include "sample.h"
#include "junction/node_solve.h"
#include "junction/node_solve_twice.h"
#include "branch/continuation.h"

static ric_atlas *explore(double max_step)
{
    return explore_text_with(
        "title: fine\nmodel: {mass: [[2, 0], [0, 1]], stiffness: [[9, -1], [-1, 1]], contacts: "
        "[{normal: [-1, 1], law: power, exponent: 3, length: 1, reference: 1}]}\n"
        "explore: {energy: [0, 1000], frequency: [0.2, 10], multiply: 2, depth: 2}\n",
        NULL, max_step);
}

/* The branch point nearest to an energy. */
static ric_junction branch_point(const ric_atlas *atlas, double energy)
{
    ric_junction best = {.id = 0};
    for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
        ric_junction j = junction_of(atlas, id);
        if (j.kind == RIC_KIND_BRANCH_POINT &&
            (!best.id || fabs(j.energy - energy) < fabs(best.energy - energy)))
            best = j;
    }
    if (!best.id || fabs(best.energy / energy - 1) > 1e-9)
        fail_msg("no branch point at energy %.12g", energy);
    return best;
}

/* The orbit of a junction as an orbit problem with the mirror points given; u [n_unknown] is the
 * caller's to free. */
static ric_shooting *chain_of(const ric_atlas *atlas, const ric_junction *j, ric_mirror start,
                              ric_mirror end, int sigma, double **u)
{
    static const int face[] = {-1, -1};
    const ric_model *m = ric_atlas_model(atlas);
    ric_shooting *c;
    double w[4];
    assert_int_equal(ric_shooting_create(m, start, end, sigma, 1, face, &c), RIC_OK);
    *u = calloc((size_t)c->n_unknown, sizeof **u);
    assert_non_null(*u);
    ric_model_from_state(m, j->state, j->state + 2, w);
    memcpy(*u, start == RIC_MIRROR_CENTRE ? w + 2 : w, (size_t)c->n_start * sizeof *w);
    (*u)[c->n_start] = j->flights[0] * m->omega_ref / c->multiple;
    ric_shooting_evaluate(c, *u);
    assert_true(c->residual < 1e-13);
    return c;
}

/* From beside the junction on its branch each kind of test is sought: exactly one leads back to it.
 */
static void leads_back(const ric_atlas *atlas, const ric_junction *j, ric_mirror start,
                       ric_mirror end, int sigma)
{
    double *u;
    ric_shooting *c = chain_of(atlas, j, start, end, sigma, &u);
    double energy = ric_shooting_energy(c), time = ric_shooting_time(c, u), t[8], du[8], from[8],
           aside = 1e-5 * c->scale;
    int back = 0, iterations, size = c->n_unknown;
    ric_continuation_tangent(c, NULL, t);
    memcpy(from, u, (size_t)size * sizeof *u);
    for (int i = 0; i < size; i++) from[i] += aside * t[i];
    assert_true(ric_continuation_correct(c, from, u, t, aside, du, &iterations));
    ric_continuation_tangent(c, t, t);
    for (int kind = RIC_TEST_A; kind < RIC_TEST_A + (start == RIC_MIRROR_NONE ? 1 : 3); kind++) {
        double found[8];
        memcpy(found, from, sizeof found);
        ric_shooting_evaluate(c, found);
        if (!ric_node_solve_twice(c, kind, t, found)) continue;
        ric_shooting_evaluate(c, found);
        back += fabs(ric_shooting_energy(c) / energy - 1) < 1e-12 &&
                fabs(ric_shooting_time(c, found) / time - 1) < 1e-12;
    }
    if (back != 1) fail_msg("%d kinds of tests lead back to %s", back, j->label);
    ric_shooting_free(c);
    free(u);
}

static void agrees_with_double(void **state)
{
    (void)state;
    ric_atlas *atlas = explore(0);
    ric_junction j = branch_point(atlas, 2.76418789722);
    leads_back(atlas, &j, RIC_MIRROR_CENTRE, RIC_MIRROR_REST, 1);
    leads_back(atlas, &j, RIC_MIRROR_NONE, RIC_MIRROR_NONE,
               -1); /* over half a period, whatever its mirror points */
    j = branch_point(atlas, 132.408540238);
    leads_back(atlas, &j, RIC_MIRROR_CENTRE, RIC_MIRROR_CENTRE, 1);
    j = branch_point(atlas, 132.112495324);
    leads_back(atlas, &j, RIC_MIRROR_REST, RIC_MIRROR_REST, 1);
    ric_atlas_free(atlas);
}

/* Behind the multiplication 3/5 the multipliers of both families pass 1 at a rate of 1e-6: double
 * precision knows the place to 1e-9. */
static void same_from_everywhere(void **state)
{
    static const double steps[] = {0.02, 0.2, 1},
                        near[] = {80.3832957126, 80.3833254924}; /* one of each family */
    double at[2][2];
    (void)state;
    for (int i = 0; i < 3; i += every_of(2)) {
        ric_atlas *atlas = explore(steps[i]);
        for (int k = 0; k < 2; k++) {
            ric_junction j = branch_point(atlas, near[k]);
            if (i == 0) {
                at[k][0] = j.energy;
                at[k][1] = j.frequency;
            }
            print_message("# step %g: E %.15g, omega %.15g\n", steps[i], j.energy, j.frequency);
            assert_true(fabs(j.energy / at[k][0] - 1) < 1e-13 &&
                        fabs(j.frequency / at[k][1] - 1) < 1e-13);
        }
        ric_atlas_free(atlas);
    }
}

/* Two masses and a cubic spring (Peeters et al. 2009). Behind the multiplication 7/10 the sign of
 * tau2 - 2 is lost in rounding up to energy 2000, and changes at 5165: steps as long as that may
 * not be the first to see it. */
static void seen_when_it_emerges(void **state)
{
    (void)state;
    ric_atlas *atlas = explore_text_with("title: late\nmodel: {mass: [[1, 0], [0, 1]], stiffness: "
                                         "[[2, -1], [-1, 2]], contacts: [{normal: [1, 0], law: "
                                         "power, exponent: 3, stiffness: 0.5}]}\n"
                                         "explore: {start: [2], energy: [443, 5500], frequency: "
                                         "[0.4, 4.7], multiply: 10, depth: 2}\n",
                                         NULL, 1);
    branch_point(atlas, 5165.35126174);
    branch_point(atlas, 5165.351578659);
    ric_atlas_free(atlas);
}

/* Energy of the branch point that is found from an orbit at `aside` of its size along the branch of
 * u; 0: none. */
static double found_from(const ric_model *m, ric_shooting *c, const double *u, double aside,
                         int test)
{
    enum { SIZE = 4 };
    double t[SIZE], du[SIZE], from[SIZE];
    int iterations;
    assert_int_equal(c->n_unknown, SIZE);
    ric_shooting_evaluate(c, u);
    ric_continuation_tangent(c, NULL, t);
    for (int i = 0; i < SIZE; i++) from[i] = u[i] + aside * c->scale * t[i];
    assert_true(ric_continuation_correct(c, from, u, t, aside * c->scale, du, &iterations));
    ric_periodic *source = ric_periodic_from_chain(c, from),
                 *found = ric_node_solve(m, source, (ric_criterion){.test = test}, NULL);
    const double energy = found ? ric_periodic_energy(m, found) : 0;
    ric_periodic_free(found);
    ric_periodic_free(source);
    return energy;
}

/* Three masses, power 11, and one of its orbits from the centre to rest. */
typedef struct {
    ric_study *study;
    ric_graph *graph;
    ric_shooting *c;
    double u[4];
} three_masses;

static void three_masses_create(const double *velocity, double period, three_masses *out)
{
    static const int none[] = {-1, -1};
    const double x[3] = {0};
    double w[6];
    *out = (three_masses){0};
    if (ric_study_parse("model:\n  mass: [[1.21875, 0.125, -0.203125], [0.125, 2.0625, -0.25], "
                        "[-0.203125, -0.25, 2.328125]]\n  stiffness: [[3.75, -1.75, 0.5], "
                        "[-1.75, 4.875, -2.5], [0.5, -2.5, 6.1875]]\n  contacts: [{normal: "
                        "[0, 1, 0], law: power, exponent: 11, length: 0.00176, reference: "
                        "0.7264}]\nexplore: {energy: [0, 470000], frequency: [0.2199, 6.552]}\n",
                        "three masses", ".", &out->study) ||
        ric_graph_create(out->study, NULL, &out->graph) ||
        ric_shooting_create(out->graph->model, RIC_MIRROR_CENTRE, RIC_MIRROR_REST, 1, 1, none,
                            &out->c))
        fail_msg("%s", ric_detail());
    ric_model_from_state(out->graph->model, x, velocity, w);
    memcpy(out->u, w + 3, 3 * sizeof *w);
    out->u[3] = period * out->graph->model->omega_ref / out->c->multiple;
    ric_shooting_evaluate(out->c, out->u);
}

static void three_masses_free(three_masses *s)
{
    ric_shooting_free(s->c);
    ric_graph_free(s->graph);
    ric_study_free(s->study);
}

/* The bound of the rounding of this determinant is a thousandth of what the secant leaves of it,
 * and its slope is flat: double precision knows the place to 3e-8. */
static void same_from_beside(void **state)
{
    static const double velocity[] = {-368.1433490816657, 33.19568172403751, -196.12382205901469},
                        aside[] = {-1e-6, 1e-7, 3e-7, 1e-6};
    three_masses s;
    int kinds = 0;
    (void)state;
    three_masses_create(velocity, 3.296186780159428, &s);
    for (int test = RIC_TEST_A; test < RIC_TEST_A + 3; test++) {
        const double first = found_from(s.graph->model, s.c, s.u, aside[0], test);
        if (first == 0) continue;
        kinds++;
        for (int i = 1; i < 4; i++) {
            const double off = found_from(s.graph->model, s.c, s.u, aside[i], test) / first - 1;
            print_message("# test %d, %g beside: %.3g\n", test, aside[i], off);
            assert_true(fabs(off) < 1e-12);
        }
    }
    assert_int_equal(kinds, 1);
    three_masses_free(&s);
}

/* The energy has a largest value within 1e-5 of the size, outside of which its slope is 1 or -1:
 * that is no rounding. */
static void turns_at_once(void **state)
{
    static const double velocity[] = {207.45399707857464, -1.474672550562928, -218.36018321706018};
    three_masses s;
    (void)state;
    three_masses_create(velocity, 4.178969135119806, &s);
    ric_periodic *orbit = ric_periodic_from_chain(s.c, s.u);
    assert_true(ric_node_solve_sharp(s.graph->model, orbit, RIC_TEST_SLOPE));
    ric_periodic_free(orbit);
    three_masses_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(agrees_with_double),
                                       cmocka_unit_test(same_from_everywhere),
                                       cmocka_unit_test(seen_when_it_emerges),
                                       cmocka_unit_test(same_from_beside),
                                       cmocka_unit_test(turns_at_once)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
