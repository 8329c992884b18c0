/* Traces of two modes between stiff springs, as they are stored and as they are given on request,
 * against those that are proved. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdlib.h>

#include "explored.h"

/* Of what is asked for again, over 1 + its size, that is not measured more closely. */
#define GOOD 5e-5

/* 250,000 times as stiff as the structure: the map has entries of 1e6 where its trace is 20. */
static const char stiff[] =
    "model:\n  mass: [[1.265625, -0.046875], [-0.046875, 2.03125]]\n"
    "  stiffness: [[2.8125, -0.875], [-0.875, 1.0]]\n  contacts:\n"
    "    - {normal: [0, 1], law: bilinear, clearance: 1.05, sides: both, stiffness: 635700}\n"
    "explore: {energy: [0, 150.9], frequency: [0.1166, 4.594], impacts: 4, multiply: 3, depth: "
    "2}\n";
/* Beside a stop: contacts of 6e-6 s, in the midst of which chains begin. */
static const char beside_stop[] =
    "model:\n  mass: [[0.5, 0], [0, 0.5]]\n  stiffness: [[1, -1], [-1, 1]]\n  contacts:\n"
    "    - {normal: [0, 1], law: bilinear, clearance: 0.733, sides: both, stiffness: 332600}\n"
    "    - {normal: [1, 1], law: rigid, clearance: 0.000733, sides: upper}\n"
    "explore: {energy: [0, 6.931], frequency: [0.4, 6], impacts: 4, multiply: 3, depth: 2}\n";

static void assert_done(ric_status status)
{
    if (status) fail_msg("%s", ric_detail());
}

/* How much the trace changes from one point to the next over what the energy does. */
static double slope_between(const ric_atlas *atlas, int branch, int i)
{
    ric_point a, b;
    assert_done(ric_atlas_point(atlas, branch, i, &a, NULL, NULL));
    assert_done(ric_atlas_point(atlas, branch, i + 1, &b, NULL, NULL));
    const double slope = (ric_point_trace(&b) - ric_point_trace(&a)) / (b.energy - a.energy);
    return isfinite(slope) ? fabs(slope) : 0;
}

/* Point i: given as it is stored, and off by what is said, which is not much more than that. The
 * orbit that is proved has other last digits, and its energy tells by how much. */
static void compare(const ric_atlas *atlas, ric_prover *prover, int branch, int i, int *lost)
{
    ric_point point;
    ric_proof proof;
    ric_orbit **orbits;
    double z[4];
    int n;
    assert_done(ric_atlas_point(atlas, branch, i, &point, NULL, NULL));
    assert_done(ric_prover_point(prover, branch, i, &proof));
    if (proof.state != RIC_PROOF_DONE || isnan(proof.trace[0])) return;
    assert_done(ric_orbit_find(atlas, branch, RIC_AT_POINT, i, &n, &orbits));
    assert_done(ric_orbit_multipliers(orbits[0], z));
    const double given = z[0] + z[2], error = ric_orbit_multiplier_error(orbits[0]),
                 stored = ric_point_trace(&point), proved = (proof.trace[0] + proof.trace[1]) / 2,
                 size = 1 + fabs(proved),
                 elsewhere = fabs((proof.energy[0] + proof.energy[1]) / 2 - point.energy),
                 away = elsewhere *
                        fmax(slope_between(atlas, branch, i - 1), slope_between(atlas, branch, i)),
                 off = fabs(given - proved);
    ric_orbits_free(n, orbits);
    /* beside 2 and -2 multipliers have half the digits of their trace */
    const bool border = fabs(fabs(proved) - 2) < 1e-3;
    if (isnan(stored) || (isnan(given) && !border)) ++*lost;
    else if (border) return;
    else if (!(off <= error + away) || !(error <= fmax(30 * off, GOOD * size)))
        fail_msg("branch %d, point %d: trace %.17g proved, %.17g stored, %.17g given to %.2g",
                 branch, i, proved, stored, given, error);
}

/* All points of all branches with impacts but their ends, where a spring may be hardly touched;
 * at most `unknown` of those that are proved have no trace. */
static void as_proved(const char *study, int least, int unknown)
{
    if (!ric_prover_available()) skip();
    ric_atlas *atlas = explore_text(study);
    ric_prover *prover;
    int lost = 0, compared = 0;
    assert_done(ric_prover_create(atlas, &prover));
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        ric_branch b;
        assert_done(ric_atlas_branch(atlas, id, &b));
        for (int i = 1; b.impacts > 0 && i + 1 < b.n_point; i++, compared++)
            compare(atlas, prover, id, i, &lost);
    }
    ric_prover_free(prover);
    ric_atlas_free(atlas);
    assert_true(compared >= least);
    assert_true(lost <= unknown);
}

static void trace_of_a_stiff_spring(void **state)
{
    (void)state;
    as_proved(stiff, 100, 4); /* beside a grazing, where impacts have a speed of 1.2e-5 */
}

static void trace_beside_a_stop(void **state)
{
    (void)state;
    as_proved(beside_stop, 40, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(trace_of_a_stiff_spring),
        cmocka_unit_test(trace_beside_a_stop),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
