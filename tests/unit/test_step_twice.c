/* What a function passes and comes back over within one step is found, however near to each other
 * the two places lie, and whichever way it bends. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "close.h"
#include "branch/continuation_step.h"
#include "branch/event_parts.h"
#include "explore/graph_parts.h"
#include "explored.h"
#include "steps.h"

#define LOOKS 16 /* places of a step at which a function is looked at for an extremum */
/* Parts of a step between two places where one value is passed. */
static const double apart[] = {1e-1, 1e-2, 1e-3, 1e-4, 1e-5};
enum { N_APART = sizeof apart / sizeof *apart };

/* An extremum of a function within a step: its arclength, its value, half of its second derivative
 * and the length of the step. */
typedef struct {
    double s, value, bend, h;
} extremum;

enum { ENERGY = -1, PERIOD = -2 };

/* Pair j, the energy or the period at distance x of the step ahead. */
static double at(ric_continuation *tr, int pair, double x, double h)
{
    bool good;
    assert_int_equal(ric_event_solve(tr, x, h, RIC_LOOK_ALL, &tr->mid, &good), RIC_OK);
    if (!good) return NAN;
    if (pair == PERIOD) return ric_shooting_time(tr->chain, tr->mid.u);
    if (pair == ENERGY) return ric_shooting_energy(tr->chain);
    return tr->mid.own[2 * pair + 1] == 0 ? tr->mid.own[2 * pair] : NAN;
}

/* The extremum between two places, by golden section. */
static extremum between(ric_continuation *tr, int pair, double a, double b, double h, double sign)
{
    const double part = (sqrt(5) - 1) / 2;
    double low = b - part * (b - a), high = a + part * (b - a), f = sign * at(tr, pair, low, h),
           g = sign * at(tr, pair, high, h);
    while (b - a > 1e-8 * h) {
        if (f > g) {
            b = high;
            high = low;
            g = f;
            f = sign * at(tr, pair, low = b - part * (b - a), h);
        } else {
            a = low;
            low = high;
            f = g;
            g = sign * at(tr, pair, high = a + part * (b - a), h);
        }
    }
    const double x = (a + b) / 2, value = at(tr, pair, x, h);
    double bend[2];
    for (int i = 0; i < 2; i++) {
        const double d = (i + 1) * 0.01 * h;
        bend[i] = ((at(tr, pair, x + d, h) + at(tr, pair, x - d, h)) / 2 - value) / (d * d);
    }
    return (extremum){.s = tr->now.s + (tr->next.s - tr->now.s) * x / h,
                      .value = value,
                      .bend = agrees(bend[0], bend[1], 0.3) ? bend[0] : 0, /* two cross there */
                      .h = h};
}

/* Whether the values between two places, a part of the step apart, are more than rounding. */
static bool is_seen(const extremum *e, double part)
{
    const double half = part * e->h / 2;
    return fabs(e->bend) * half * half > 1e-12 * (1 + fabs(e->value));
}

/* Of the step ahead; false: there is none inside, or none that is steep enough to be told from
 * rounding. */
static bool ahead(ric_continuation *tr, int pair, extremum *out)
{
    ric_course way = {0};
    const double h = tr->step;
    double f[LOOKS + 1];
    tr->solved.n = 0;
    if (!tr->has_past || !ric_continuation_try(tr, h, &way) || !ric_continuation_stays(tr, &way))
        return false;
    for (int i = 0; i <= LOOKS; i++) f[i] = at(tr, pair, h * i / LOOKS, h);
    for (int i = 2; i < LOOKS - 1; i++) {
        const double before = f[i] - f[i - 1], after = f[i + 1] - f[i];
        if (!(before * after < 0) || !(fabs(f[i]) < 20)) continue;
        *out = between(tr, pair, h * (i - 1) / LOOKS, h * (i + 1) / LOOKS, h, before > 0 ? 1 : -1);
        return is_seen(out, apart[pair < 0 ? 1 : N_APART - 2]);
    }
    return false;
}

/* The branch of another one from its second point on, with one resonance, at `rho`. */
static ric_continuation *again(const ric_continuation *tr, const ric_limits *limits, double rho)
{
    const int size = tr->chain->n_unknown;
    const double *u = (const double *)(ric_continuation_row(tr, 1) + 1),
                 *v = (const double *)(ric_continuation_row(tr, 2) + 1);
    double t[size];
    ric_continuation *out = NULL;
    for (int i = 0; i < size; i++) t[i] = v[i] - u[i];
    if (ric_continuation_create(ric_shooting_copy(tr->chain), u, t, 0, limits, &out))
        fail_msg("%s", ric_detail());
    assert_true(out->n_resonance >= 1);
    out->n_resonance = 1;
    out->resonances[0].rho = rho;
    return out;
}

static int passed(const ric_continuation *tr, double s, double within)
{
    int count = 0;
    for (int i = 0; i < tr->n_event; i++)
        count += tr->events[i].test == RIC_N_TEST && fabs(tr->events[i].s - s) < within;
    return count;
}

/* A value beside the extremum is passed twice. */
static void pair_passes_twice(const ric_continuation *tr, const ric_limits *limits,
                              const extremum *e)
{
    for (int i = 0; i < N_APART && is_seen(e, apart[i]); i++) {
        const double half = apart[i] * e->h / 2;
        ric_continuation *other = again(tr, limits, e->value + e->bend * half * half);
        assert_int_equal(ric_continuation_run(other), RIC_OK);
        const int n = passed(other, e->s, 0.1 * e->h);
        if (n != 2 && !other->unresolved)
            fail_msg("%d passages at s %.9g, %g of a step apart, pair %.12g, %d modes, %d flights",
                     n, e->s, apart[i], e->value, tr->chain->n, tr->chain->n_flight);
        ric_continuation_free(other);
    }
}

/* An end of the window beside the extremum of the energy or the period: the branch comes to it. */
static void window_passes_twice(const ric_continuation *tr, const ric_limits *limits, int of,
                                const extremum *e)
{
    const bool lower = e->bend > 0;
    const ric_why why = of == ENERGY ? (lower ? RIC_WHY_ENERGY_MIN : RIC_WHY_ENERGY_MAX)
                                     : (lower ? RIC_WHY_FREQUENCY_MAX : RIC_WHY_FREQUENCY_MIN);
    for (int i = 0; i < N_APART && is_seen(e, apart[i]); i++) {
        const double half = apart[i] * e->h / 2;
        ric_limits window = *limits;
        *(of == ENERGY ? &window.energy[!lower] : &window.period[!lower]) = e->value +
                                                                            e->bend * half * half;
        ric_continuation *other = again(tr, &window, 1e9);
        assert_int_equal(ric_continuation_run(other), RIC_OK);
        if (other->why != why || fabs(other->end.s - e->s) > 0.1 * e->h)
            fail_msg("no end at s %.9g, %g of a step beside an extremum", e->s, apart[i]);
        ric_continuation_free(other);
    }
}

/* All extrema of one pair, the energy or the period on a branch; their number. */
static int check_branch(const ric_continuation *tr, const ric_limits *limits, int pair, int most)
{
    int count = 0;
    if (tr->n_point < 12 || tr->chain->n < 2) return 0;
    ric_continuation *way = again(tr, limits, 1e9);
    for (bool done = false; !done && way->n_point < tr->n_point && count < most;) {
        extremum e;
        const bool found = ahead(way, pair, &e);
        assert_int_equal(ric_continuation_advance(way, &done), RIC_OK);
        if (!found || done || e.s > way->now.s) continue; /* beyond the end, or a shorter step */
        if (pair < 0) window_passes_twice(tr, limits, pair, &e);
        else pair_passes_twice(tr, limits, &e);
        count++;
    }
    ric_continuation_free(way);
    return count;
}

static void check_study(const char *text, int pairs, int least, int least_of_window)
{
    ric_study *study = NULL;
    assert_int_equal(ric_study_parse(text, "test", ".", &study), RIC_OK);
    ric_graph *graph = explored_graph(study);
    int n_pair = 0, n_window = 0;
    const ric_limits limits = graph->limits;
    for (int i = 0; i < graph->n_edge; i++) {
        const ric_continuation *tr = graph->edges[i].trace;
        for (int j = 0; j < pairs; j++) n_pair += check_branch(tr, &limits, j, 2);
        n_window += check_branch(tr, &limits, ENERGY, 1) + check_branch(tr, &limits, PERIOD, 1);
    }
    print_message("# %d branches, %d extrema of pairs, %d of energies and periods\n", graph->n_edge,
                  n_pair, n_window);
    assert_true(n_pair >= least && n_window >= least_of_window);
    ric_graph_free(graph);
    ric_study_free(study);
}

static void two_modes(void **state)
{
    (void)state;
    check_study("model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  contacts:\n"
                "    - {normal: [-1, 1], clearance: 1, sides: both, law: rigid}\n"
                "explore: {energy: [0, 50], frequency: [0.3, 10], impacts: 10, multiply: 2, depth: "
                "3}\n",
                1, 1, 1);
}

static void three_modes(void **state)
{
    (void)state;
    check_study("model:\n  mass: [[1.5, 0, 0], [0, 1, 0], [0, 0, 0.8]]\n"
                "  stiffness: [[5, -1, 0], [-1, 3, -2], [0, -2, 5]]\n  contacts:\n"
                "    - {normal: [1, 0, 0], clearance: 1, sides: upper, law: rigid}\n"
                "    - {normal: [0, -1, 1], clearance: 0.7, sides: both, law: rigid}\n"
                "explore: {energy: [0, 20], frequency: [0.2, 10], impacts: 6, multiply: 2, depth: "
                "2}\n",
                2, 1, 1);
}

static void springs(void **state)
{
    (void)state;
    check_study("model:\n  mass: [[1, 0], [0, 1]]\n  stiffness: [[2, -1], [-1, 2]]\n  contacts:\n"
                "    - {normal: [1, 0], law: bilinear, clearance: 1, sides: upper, stiffness: 20}\n"
                "    - {normal: [0, 1], law: rigid, clearance: 1.2, sides: both}\n"
                "explore: {energy: [0, 20], frequency: [0.2, 8], impacts: 6, multiply: 2, depth: "
                "3}\n",
                1, 1, 1);
}

static int count_at(const ric_atlas *atlas, ric_kind kind, double energy)
{
    int count = 0;
    for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
        const ric_junction j = junction_of(atlas, id);
        count += j.kind == kind && agrees(j.energy, energy, 1e-9);
    }
    return count;
}

/* A step has room for so many points: one more is not taken, nor written behind them. */
static void no_more_points_than_there_is_room_for(void **state)
{
    (void)state;
    ric_study *study = NULL;
    const char *text = "model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n"
                       "  contacts:\n"
                       "    - {normal: [-1, 1], clearance: 1, sides: both, law: rigid}\n"
                       "explore: {energy: [0, 50], frequency: [0.3, 10], impacts: 2, depth: 1}\n";
    assert_int_equal(ric_study_parse(text, "test", ".", &study), RIC_OK);
    ric_graph *graph = explored_graph(study);
    int i = 0;
    while (graph->edges[i].trace->n_point < 12 || graph->edges[i].trace->chain->n < 2) i++;
    const ric_limits limits = graph->limits;
    ric_continuation *way = again(graph->edges[i].trace, &limits, 1e9);
    ric_course course = {0};
    bool done, good = true;
    for (int k = 0; k < 4; k++) assert_int_equal(ric_continuation_advance(way, &done), RIC_OK);
    const double h = way->step;
    way->solved.n = 0;
    assert_true(ric_continuation_try(way, h, &course) && ric_continuation_stays(way, &course));
    ric_event_samples_begin(way, h);
    for (int k = 1; k < 2 * RIC_MOST_SAMPLES; k++) {
        const int n = way->samples.n;
        assert_int_equal(ric_event_samples_insert(way, h * k / (2 * RIC_MOST_SAMPLES), h, &good),
                         RIC_OK);
        assert_true(good == (n < RIC_MOST_SAMPLES));
        assert_int_equal(way->samples.n, good ? n + 1 : n);
    }
    assert_int_equal(way->samples.n, RIC_MOST_SAMPLES);
    ric_continuation_free(way);
    ric_graph_free(graph);
    ric_study_free(study);
}

/* A3[001] passes -1 with one multiplier and comes back within a thirtieth of a step. */
static void doubling_and_back(void **state)
{
    (void)state;
    ric_atlas *atlas = same_for_all_steps_to(
        1e-9,
        "model:\n  mass: [[1.5, 0, 0], [0, 1.75, 0], [0, 0, 1.25]]\n"
        "  stiffness: [[1687500, -1687500, 0], [-1687500, 2000000, -312500], [0, -312500, "
        "312500]]\n"
        "  contacts:\n    - {normal: [0, 0, 1], law: rigid, clearance: 0.00099, sides: both}\n"
        "    - {normal: [-1, 1, 0], law: rigid, clearance: 0.00099, sides: both}\n"
        "explore: {energy: [0, 2954000], frequency: [115, 4437], impacts: 8, multiply: 3, depth: "
        "1}\n");
    assert_int_equal(count_at(atlas, RIC_KIND_MULTIPLICATION, 236697.919963165), 1);
    assert_int_equal(count_at(atlas, RIC_KIND_MULTIPLICATION, 236857.664902367), 1);
    ric_atlas_free(atlas);
}

/* A5[22323] passes two doublings, at the second of which the other mirror point is lost; and
 * A2[23] passes a third of a turn where the points of the usual step show a straight way to zero
 * and on, S4[2233] where they show a parabola and nothing beyond. */
static void tripling_and_back(void **state)
{
    (void)state;
    static const double energy[] = {81956.347636, 81958.071438, 82107.518453,
                                    82110.551926, 82226.779542, 82226.784080};
    ric_atlas *atlas = same_for_all_steps_to(
        1e-9,
        "model:\n  mass: [[0.25, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1.5, 0], [0, 0, 0, 1.75]]\n"
        "  stiffness: [[2875000, -937500, 0, 0], [-937500, 1562500, -625000, 0], "
        "[0, -625000, 1125000, -500000], [0, 0, -500000, 1937500]]\n  contacts:\n"
        "    - {normal: [0, 0, -1, 1], law: bilinear, clearance: 1.44, sides: both, stiffness: "
        "4794000}\n"
        "    - {normal: [0, 0, 1, 0], law: rigid, clearance: 0.672, sides: both}\n"
        "explore: {energy: [0, 3056000], frequency: [116.5, 10320], impacts: 5, multiply: 3, "
        "depth: 1}\n");
    for (int i = 0; i < 6; i++)
        assert_int_equal(count_at(atlas, RIC_KIND_MULTIPLICATION, energy[i]), 1);
    ric_atlas_free(atlas);
}

/* The orbit at the end of A4[0101] cannot be solved for: its last point is that of an extremum,
 * which does not lie at the end. */
static void last_point_is_an_extremum(void **state)
{
    (void)state;
    ric_atlas *atlas = same_for_all_steps_to(
        1e-9,
        "model:\n  mass: [[1.453125, 0.0625, 0.125], [0.0625, 1.3125, 0.125], [0.125, 0.125, "
        "2.078125]]\n"
        "  stiffness: [[8.948909688988948, 0.9339232972672882, 7.357868851629151], "
        "[0.9339232972672882, 5.141586666354565, 0.09345235001423882], [7.357868851629151, "
        "0.09345235001423882, 9.261459203572533]]\n  contacts:\n"
        "    - {normal: [0, -1, 1], law: bilinear, clearance: 1.55, sides: both, stiffness: "
        "15.07}\n"
        "    - {normal: [0, 1, 0], law: rigid, clearance: 1.55, sides: upper}\n"
        "explore: {energy: [0, 16.57], frequency: [0.2, 9], impacts: 6, multiply: 2, depth: 2}\n");
    assert_int_equal(count_at(atlas, RIC_KIND_EXTREMUM, 2.09226343891794), 1);
    ric_atlas_free(atlas);
}

/* A gap closes by 1e-11 of itself at the end of S2(1)[01], and would open again, and close, within
 * one step. */
static void closes_three_times(void **state)
{
    (void)state;
    ric_atlas *atlas = same_for_all_steps_to(
        1e-9,
        "model:\n  mass: [[2.078125, 0.0625, 0.15625], [0.0625, 1.0625, 0], [0.15625, 0, 2.125]]\n"
        "  stiffness: [[8.314353064878517, 0.008420664473354295, 0.10901631767809518], "
        "[0.008420664473354295, 1.0911988572002815, -0.688163610879783], "
        "[0.10901631767809518, -0.688163610879783, 18.91762872537218]]\n  contacts:\n"
        "    - {normal: [1, 1, 1], law: bilinear, clearance: 0.0015, sides: both, stiffness: "
        "73890}\n"
        "explore: {energy: [0, 15.28], frequency: [0.2, 9], impacts: 4, multiply: 1, depth: 1}\n");
    assert_int_equal(count_at(atlas, RIC_KIND_GRAZING, 0.843232319283115), 1);
    ric_atlas_free(atlas);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(two_modes),
                                       cmocka_unit_test(three_modes),
                                       cmocka_unit_test(springs),
                                       cmocka_unit_test(no_more_points_than_there_is_room_for),
                                       cmocka_unit_test(doubling_and_back),
                                       cmocka_unit_test(tripling_and_back),
                                       cmocka_unit_test(last_point_is_an_extremum),
                                       cmocka_unit_test(closes_three_times)};
    return cmocka_run_group_tests_name("step_twice", tests, NULL, NULL);
}
