/* What is stored of the multipliers of a branch: every number of a point belongs to its orbit, and
 * the stability flag says no more than the error of the multipliers allows. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "explored.h"
#include "orbit/floquet_known.h"
#include "multipliers.h"
#include "random_models.h"
#include "sample.h"

static bool near(double a, double b, double scale)
{
    return (isnan(a) && isnan(b)) || fabs(a - b) <= 1e-9 * scale;
}

/* Everything that is stored of a point belongs to the orbit that is stored, at the ends too, which
 * are read off cubics or replaced by the orbit of a junction; and that orbit is solved. */
static void check_rows(ric_continuation *trace, const char *where)
{
    double *u = malloc((size_t)trace->chain->n_unknown * sizeof *u);
    for (int i = 0; i < trace->n_point; i++) {
        const ric_point *row = (const ric_point *)(trace->points + (size_t)i * trace->stride);
        ric_station p = {.u = u};
        memcpy(u, row + 1, (size_t)trace->chain->n_unknown * sizeof *u);
        assert_int_equal(ric_continuation_fill(trace, row->arclength, &p), RIC_OK);
        if (!p.solved)
            fail_msg("%s, point %d of %d: residual %.3g", where, i, trace->n_point, p.row.residual);
        if (!near(row->energy, p.row.energy, 1 + row->energy) ||
            !near(row->frequency, p.row.frequency, row->frequency) ||
            !near(row->reach, p.row.reach, 1) || !near(row->approach, p.row.approach, 1) ||
            (fabs(row->trace) < 10 &&
             !near(row->trace, p.row.trace, 1000 * (1 + trace->floquet.error))))
            fail_msg("%s, point %d of %d: E %.12g omega %.12g trace %.12g reach %.12g approach "
                     "%.12g stored, %.12g %.12g "
                     "%.12g %.12g %.12g found",
                     where, i, trace->n_point, row->energy, row->frequency, row->trace, row->reach,
                     row->approach, p.row.energy, p.row.frequency, p.row.trace, p.row.reach,
                     p.row.approach);
    }
    free(u);
}

static void rows_belong_to_orbits(void **state)
{
    (void)state;
    static const char *const files[] = {"examples/two-springs/study.yaml",
                                        "examples/stop-and-spring/study.yaml",
                                        "examples/paper/power-3.yaml",
                                        "examples/paper/power-21.yaml"};
    int arrivals = 0;
    for (size_t s = 0; s < sizeof files / sizeof *files - !long_form(); s++) {
        ric_study *study = NULL;
        assert_int_equal(ric_study_read(files[s], &study), RIC_OK);
        ric_graph *graph = explored_graph(study);
        for (int e = 0; e < graph->n_edge; e++) {
            char where[96];
            snprintf(where, sizeof where, "%s, branch %d", files[s], e);
            arrivals += graph->edges[e].trace && graph->edges[e].trace->arrival;
            if (graph->edges[e].trace) check_rows(graph->edges[e].trace, where);
        }
        ric_graph_free(graph);
        ric_study_free(study);
    }
    if (!(arrivals > (long_form() ? 5 : 2))) fail_msg("%d arrivals", arrivals);
}

/* Stability at u, and at states that are the same orbit but for rounding. With `judge`, as
 * it is stored. */
static ric_stability flag_at(ric_shooting *c, const double *u, bool judge)
{
    ric_floquet f = multipliers(c, u);
    if (judge) assert_int_equal(ric_continuation_judge(c, u, &f), RIC_OK);
    ric_stability stable = f.stable;
    ric_floquet_release(&f);
    return stable;
}

static bool contradicts(ric_shooting *c, const double *u, bool judge)
{
    double v[c->n_unknown], du[c->n_unknown];
    bool yes = false, no = false;
    for (int k = 0; k < 6; k++) {
        int steps;
        ric_stability flag = RIC_STABLE_UNDECIDED;
        for (int i = 0; i < c->n_unknown; i++) v[i] = u[i] * (1 + 1e-15 * k * uniform(-1, 1));
        if (ric_continuation_correct(c, v, NULL, NULL, 0, du, &steps)) flag = flag_at(c, v, judge);
        yes |= flag == RIC_STABLE_YES;
        no |= flag == RIC_STABLE_NO;
    }
    return yes && no;
}

/* A stiff spring that is hardly closed: the branch from its grazing passes the border of stability
 * at once. */
static const char hardly_closed[] =
    "{'model': {'mass': [[1.515625, 0.0, 0.234375, 0.0], [0.0, 1.265625, 0.015625, -0.078125], "
    "[0.234375, "
    "0.015625, 1.09375, -0.421875], [0.0, -0.078125, -0.421875, 2.03125]], 'stiffness': [[2.875, "
    "2.4375, "
    "0.875, 0.6875], [2.4375, 7.875, 4.3125, -0.6875], [0.875, 4.3125, 6.5625, -0.375], [0.6875, "
    "-0.6875, "
    "-0.375, 3.125]], 'contacts': [{'normal': [0.0, 0.0, 0.0, 1.0], 'law': 'bilinear', "
    "'clearance': 0.000731, "
    "'sides': 'both', 'stiffness': 22130.0}, {'normal': [0.0, -2.0, 1.0, 2.0], 'law': 'bilinear', "
    "'clearance': "
    "0.002, 'sides': 'upper', 'stiffness': 2590000.0}, {'normal': [1.0, 0.0, 0.0, 0.0], 'law': "
    "'bilinear', "
    "'clearance': 0.00192, 'sides': 'both', 'stiffness': 36.45}]}, 'explore': {'start': 'modes', "
    "'energy': [0, "
    "12.87], 'frequency': [0.1734, 9.532], 'impacts': 4, 'multiply': 3, 'depth': 1}}";

/* Distance of the nearest pair from the border of stability. */
static double from_border(const ric_floquet *f)
{
    double least = HUGE_VAL;
    for (int i = 0; i < f->n_pair; i++)
        least = fmin(least, hypot(fabs(f->rho[2 * i]) - 2, f->rho[2 * i + 1]));
    return least;
}

/* The flag and the bound of the multipliers are one: with the touch of a spring all stabilities are
 * passed within what is known of its length: arithmetic of 50 digits finds rho 1.4e-9 from what
 * doubles have beside the border there. */
static void flags_keep_to_the_bound(void **state)
{
    (void)state;
    static const char *const files[] = {NULL, "examples/two-springs/study.yaml",
                                        "examples/stop-and-spring/study.yaml"};
    int seen = 0;
    for (size_t s = 0; s < sizeof files / sizeof *files; s++) {
        ric_study *study = NULL;
        ric_status read = files[s] ? ric_study_read(files[s], &study)
                                   : ric_study_parse(hardly_closed, "hardly closed", NULL, &study);
        assert_int_equal(read, RIC_OK);
        ric_graph *graph = explored_graph(study);
        for (int e = 0; e < graph->n_edge; e++) {
            const ric_continuation *trace = graph->edges[e].trace;
            for (int i = 0; trace && i < trace->n_point; i++) {
                const ric_point *p = (const ric_point *)(trace->points + (size_t)i * trace->stride);
                if (p->stable == RIC_STABLE_UNDECIDED || trace->chain->multiple == 4) continue;
                if (trace->chain->n < 2 || ric_shooting_halves(trace->chain)) continue;
                ric_shooting_evaluate(trace->chain, (const double *)(p + 1));
                ric_floquet f = multipliers(trace->chain, (const double *)(p + 1));
                double off = from_border(&f);
                ric_status status = ric_continuation_multipliers(trace->chain,
                                                                 (const double *)(p + 1), &f);
                assert_int_equal(status, RIC_OK);
                if (f.stable == RIC_STABLE_UNDECIDED || (s == 0 && off < 1e-9))
                    fail_msg("study %zu, branch %d, point %d: stable %d, rho %.3g from the border "
                             "within %.3g",
                             s, e, i, p->stable, off, f.each[0]);
                ric_floquet_release(&f);
                seen++;
            }
        }
        ric_graph_free(graph);
        ric_study_free(study);
    }
    print_message("# %d flags\n", seen);
    assert_true(seen > 100);
}

/* Towards points where stability is undecided: of two solutions that differ by rounding none may be
 * called stable and the other one not. */
static void flags_agree(void **state)
{
    (void)state;
    static const char *const files[] = {"examples/fractal-base/study.yaml",
                                        "examples/three-masses/study.yaml",
                                        "examples/elementary/study.yaml"};
    int borders = 0, raw = 0;
    for (size_t s = 0; s < sizeof files / sizeof *files; s++) {
        ric_study *study = NULL;
        seed_now = s + 20;
        assert_int_equal(ric_study_read(files[s], &study), RIC_OK);
        ric_graph *graph = explored_graph(study);
        for (int e = 0; e < graph->n_edge; e++) {
            const ric_continuation *trace = graph->edges[e].trace;
            for (int i = 0; trace && i + 1 < trace->n_point; i++) {
                ric_shooting *c = trace->chain;
                int size = c->n_unknown, steps;
                const ric_point *p = (const ric_point *)(trace->points + (size_t)i * trace->stride),
                                *q = (const ric_point *)((const double *)p + trace->stride);
                const double *a = (const double *)(p + 1), *b = (const double *)(q + 1);
                double u[size], du[size];
                if ((p->stable == RIC_STABLE_UNDECIDED) == (q->stable == RIC_STABLE_UNDECIDED))
                    continue;
                borders++;
                for (double x = 0.3; x > 1e-12; x /= long_form() ? 1.7 : 3.1) {
                    double y = p->stable == RIC_STABLE_UNDECIDED ? x : 1 - x;
                    for (int k = 0; k < size; k++) u[k] = a[k] + y * (b[k] - a[k]);
                    if (!ric_continuation_correct(c, u, NULL, NULL, 0, du, &steps)) break;
                    raw += contradicts(c, u, false);
                    if (contradicts(c, u, true))
                        fail_msg("%s, branch %d, beside point %d: stable, and not, by rounding",
                                 files[s], e, i);
                }
            }
        }
        ric_graph_free(graph);
        ric_study_free(study);
    }
    print_message("# %d borders; %d places where rounding decides a bound that knows of no error "
                  "of the orbit\n",
                  borders, raw);
    assert_true(borders >= 10 && raw > 0);
}

/* A multiplier goes through infinity where an impact loses its speed, and rounding says where:
 * traces of 1e34 stood there, or any small number. */
static void traces_at_grazings_are_lost(void **state)
{
    (void)state;
    int lost = 0, kept = 0;
    ric_study *study = NULL;
    assert_int_equal(ric_study_read("examples/fractal-base/study.yaml", &study), RIC_OK);
    ric_graph *graph = explored_graph(study);
    for (int e = 0; e < graph->n_edge; e++) {
        const ric_continuation *trace = graph->edges[e].trace;
        for (int i = 0; trace && trace->chain->n_flight > 0 && i < trace->n_point; i++) {
            const ric_point *row = (const ric_point *)(trace->points + (size_t)i * trace->stride);
            assert_true(isfinite(row->trace) || isnan(row->rotation));
            lost += fabs(row->approach) < 1e-13 && isnan(row->trace);
            kept += isfinite(row->trace);
            if (fabs(row->approach) > 1e-6 && !isfinite(row->trace))
                fail_msg("branch %d, point %d: no trace, and its slowest impact has %.3g", e, i,
                         row->approach);
            if (fabs(row->approach) < 1e-13 && row->trace > 40)
                fail_msg("branch %d, point %d: trace %.3g at a grazing", e, i,
                         2 * sinh(row->trace));
        }
    }
    assert_true(lost > 20 && kept > 500);
    ric_graph_free(graph);
    ric_study_free(study);
}

/* Four impacts that become touches together leave five directions of the orbit open to rounding.
 * rho is -3.9 here, and anything between -2 and 2 a rounding beside it. */
static const char four_touches[] = "{'model': {'mass': [[1.578125, 0.03125], [0.03125, 1.515625]], "
                                   "'stiffness': [[5.8076475283004845, "
                                   "1.546760431817365], [1.546760431817365, 2.058662262965859]], "
                                   "'contacts': [{'normal': [1, 0], 'law': 'rigid', "
                                   "'clearance': 1.91, 'sides': 'both'}]}}";

static void no_flag_beside_several_touches(void **state)
{
    (void)state;
    static const struct {
        double state[4], flights[4];
    } orbits[] = {
        {{0x1.0000000000001p+0, -0x1.6539a39bda9f3p+1, -0x1.cc0e677095677p-23,
          0x1.624a34119f1fap-21},
         {0x1.921f9605237d4p+2, 0x1.921f9605237d4p+2, 0x1.921f9818183a1p+1, 0x1.921f9818183a1p+1}},
        {{0x1.0000000000000p+0, -0x1.6539a39bda9f3p+1, -0x1.cbf4ecbc5b8d2p-23,
          0x1.6280c8ab1c364p-21},
         {0x1.921f9604fbfd3p+2, 0x1.921f9604fbfd3p+2, 0x1.921f98185a717p+1, 0x1.921f98185a717p+1}},
        {{0x1.fffffffffffffp-1, -0x1.6539a39bda9f3p+1, -0x1.cc3f0e3309733p-23,
          0x1.626be9f1cc005p-21},
         {0x1.921f96050b551p+2, 0x1.921f96050b551p+2, 0x1.921f981831612p+1, 0x1.921f981831612p+1}},
    };
    ric_study *study = NULL;
    assert_int_equal(ric_study_parse(four_touches, "four touches", NULL, &study), RIC_OK);
    const ric_model *m = ric_study_model(study);
    for (size_t k = 0; k < sizeof orbits / sizeof *orbits; k++) {
        ric_periodic *orbit = ric_periodic_create(m->n, 4);
        ric_shooting *c = NULL;
        double *u = NULL;
        for (int i = 0; i < 4; i++) {
            orbit->face[i] = i == 3;
            orbit->tau[i] = orbits[k].flights[i] * m->omega_ref;
        }
        ric_model_from_state(m, orbits[k].state, orbits[k].state + 2, orbit->w);
        ric_periodic_find_symmetries(m, orbit, 1e-8);
        assert_int_equal(ric_periodic_to_chain(m, orbit, &c, &u), RIC_OK);
        ric_shooting_evaluate(c, u);
        assert_true(ric_continuation_solved(c));
        ric_stability flag = flag_at(c, u, true);
        if (flag != RIC_STABLE_UNDECIDED)
            fail_msg("orbit %zu: flag %d at touches that are known to a percent", k, flag);
        ric_shooting_free(c);
        ric_periodic_free(orbit);
        free(u);
    }
    ric_study_free(study);
}

/* Four masses with a stop and a spring of 4e10, three pairs near the border: the bound of all of
 * them together left a stable part of a branch undecided; each pair by itself, and the independent
 * judge, know it. */
static void each_pair_decides(void **state)
{
    (void)state;
    ric_atlas *atlas = explore_text(
        "model:\n  mass: [[1.765625, -0.171875, -0.234375, 0.1875], [-0.171875, 1.1875, 0.3125, "
        "-0.1875], [-0.234375, 0.3125, 1.65625, -0.078125], [0.1875, -0.1875, -0.078125, "
        "1.65625]]\n"
        "  stiffness: [[454017.8865822943, -74776.00559623481, 42656.05946630573, "
        "107141.28241822192], "
        "[-74776.00559623481, 2591253.069304248, 667719.7738236744, -783112.3026049485], "
        "[42656.05946630573, 667719.7738236744, 1513487.8365518416, 223773.91380033208], "
        "[107141.28241822192, -783112.3026049485, 223773.91380033208, 847617.8843934726]]\n"
        "  contacts:\n    - {normal: [0, 1, 0, 0], law: bilinear, clearance: 0.00141, sides: "
        "lower, "
        "stiffness: 4.431e10}\n"
        "    - {normal: [1, 0, 0, 0], law: rigid, clearance: 0.00123, sides: lower}\n"
        "explore: {energy: [0, 8584000], frequency: [99.94, 4501], impacts: 4, multiply: 1, depth: "
        "1}\n");
    int decided = 0;
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        ric_branch b;
        assert_int_equal(ric_atlas_branch(atlas, id, &b), RIC_OK);
        for (int i = 2; i < b.n_point; i += 3) {
            ric_claims claims;
            assert_int_equal(ric_verify_claims(atlas, id, i, &claims), RIC_OK);
            if (claims.stable == RIC_AGREES_NO)
                fail_msg("branch %d, point %d: %s", id, i, claims.finding);
            decided += claims.stable == RIC_AGREES_YES;
        }
    }
    assert_true(decided > 0);
    ric_atlas_free(atlas);
}

/* Impacts between mirror points with 1e-7 of the fastest speed: the chain has lost what the orbit,
 * asked for again, is known to be. */
static void no_flag_is_left_to_slow_impacts(void **state)
{
    (void)state;
    ric_atlas *atlas = explore_text(
        "model:\n  mass: [[0.5, 0], [0, 2]]\n  stiffness: [[9, -5.5], [-5.5, 7.5]]\n"
        "  contacts:\n    - {normal: [1, -1], law: rigid, clearance: 0.698, sides: both}\n"
        "    - {normal: [0, 1], law: bilinear, clearance: 0.000698, sides: both, stiffness: "
        "194700}\n"
        "explore: {energy: [0, 0.0007631], frequency: [0.2738, 13.37], impacts: 4, multiply: 2, "
        "depth: 2}\n");
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++)
        for (int i = 0; i < branch_of(atlas, id).n_point; i++) {
            ric_point p;
            assert_int_equal(ric_atlas_point(atlas, id, i, &p, NULL, NULL), RIC_OK);
            const double trace = ric_point_trace(&p);
            if (p.stable == RIC_STABLE_UNDECIDED && fabs(fabs(trace) - 2) > 1e-3)
                fail_msg("branch %d, point %d: undecided at trace %.10g", id, i, trace);
        }
    ric_atlas_free(atlas);
}

/* How often so much was multiplied that a thread asks whether to stop. */
static bool count_work(void *asked)
{
    ++*(int *)asked;
    return false;
}

/* What it is to judge a point many times, or to measure all of its multipliers. */
static int work_of(ric_shooting *c, const double *u, ric_floquet *f, bool all)
{
    enum { TIMES = 1000 };
    int asked = 0;
    ric_halt_ask(count_work, &asked);
    for (int k = 0; k < TIMES; k++) {
        ric_shooting_evaluate(c, u);
        assert_int_equal(ric_floquet_compute(c, f), RIC_OK);
        assert_int_equal(all ? ric_continuation_multipliers(c, u, f)
                             : ric_continuation_judge(c, u, f),
                         RIC_OK);
        f->sharp = 0;
    }
    ric_halt_ask(NULL, NULL);
    return asked;
}

/* Points of which the orbit leaves the flag open that the map alone has: their number, and what the
 * flag takes of them, and all multipliers. */
static int lost_in(const char *file, int *judged, int *measured)
{
    ric_study *study = NULL;
    int lost = 0;
    assert_int_equal(ric_study_read(file, &study), RIC_OK);
    ric_graph *graph = explored_graph(study);
    for (int e = 0; e < graph->n_edge; e++) {
        const ric_continuation *trace = graph->edges[e].trace;
        for (int i = 0; i < trace->n_point && lost < 6; i++) {
            const ric_point *row = (const ric_point *)(trace->points + (size_t)i * trace->stride);
            const double *u = (const double *)(row + 1);
            ric_floquet f = multipliers(trace->chain, u);
            if (row->stable == RIC_STABLE_UNDECIDED && f.stable != RIC_STABLE_UNDECIDED &&
                flag_at(trace->chain, u, true) == RIC_STABLE_UNDECIDED) {
                lost++;
                *judged += work_of(trace->chain, u, &f, false);
                *measured += work_of(trace->chain, u, &f, true);
            }
            ric_floquet_release(&f);
        }
    }
    ric_graph_free(graph);
    ric_study_free(study);
    return lost;
}

/* A flag that the first orbits about a point have lost is not found again by others. */
static void what_is_lost_is_measured_no_further(void **state)
{
    (void)state;
    static const char *const files[] = {"examples/elementary/study.yaml",
                                        "examples/symmetric-path/study.yaml",
                                        "examples/symmetric-chain/study.yaml"};
    int lost = 0, judged = 0, measured = 0;
    for (size_t i = 0; i < sizeof files / sizeof *files && lost < 6; i++)
        lost += lost_in(files[i], &judged, &measured);
    if (!(lost >= 3 && 2 * judged < measured))
        fail_msg("judged for %d of the %d million that all multipliers of %d points take", judged,
                 measured, lost);
}

/* Along A6[010101] the trace is 2 to 2e-7 and orbits that are the same but for rounding are on both
 * sides of the border; those in extended precision are not, and what is stored is what is answered
 * when it is asked for. */
static void a_flag_is_that_of_the_answer(void **state)
{
    (void)state;
    ric_atlas *atlas = explore_text(
        "model:\n  mass: [[0.75, 0], [0, 1.25]]\n  stiffness: [[11.75, -7], [-7, 15]]\n"
        "  contacts:\n"
        "    - {normal: [1, 0], law: bilinear, clearance: 0.528, sides: both, stiffness: 52590}\n"
        "    - {normal: [0, 1], law: rigid, clearance: 1.23, sides: lower}\n"
        "explore: {energy: [0, 76.79], frequency: [0.505, 13.84], impacts: 6, multiply: 3, depth: "
        "2}\n");
    int found = 0;
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        const ric_branch b = branch_of(atlas, id);
        if (strcmp(b.label, "A6[010101]") != 0) continue;
        for (int i = 1; i + 1 < b.n_point; i++) {
            ric_point p;
            ric_orbit **orbits;
            int n;
            assert_int_equal(ric_atlas_point(atlas, id, i, &p, NULL, NULL), RIC_OK);
            if (!(fabs(ric_point_trace(&p) - 2) < 1e-6)) continue;
            assert_int_equal(ric_orbit_find(atlas, id, RIC_AT_POINT, i, &n, &orbits), RIC_OK);
            if (n > 0 && ric_orbit_stability(orbits[0]) == RIC_STABLE_YES) {
                if (p.stable != RIC_STABLE_YES) fail_msg("point %d: stored as %d", i, p.stable);
                found++;
            }
            ric_orbits_free(n, orbits);
        }
    }
    print_message("# %d flags\n", found);
    assert_true(found > 0);
    ric_atlas_free(atlas);
}

/* A map that was made before is had again, and none that differs in any number. */
static void known_maps_are_those_of_the_orbit(void **state)
{
    (void)state;
    ric_study *study = NULL;
    ric_floquet_known *known = NULL;
    assert_int_equal(ric_study_read("examples/elementary/study.yaml", &study), RIC_OK);
    assert_true(ric_floquet_known_create(2, &known));
    ric_graph *graph = explored_graph(study);
    const ric_model *m = graph->model;
    for (int round = 0; round < 3; round++)
        for (int e = 0; e < graph->n_edge && e < 12; e++) {
            const ric_continuation *trace = graph->edges[e].trace;
            ric_shooting *c = trace->chain;
            double u[c->n_unknown], sizes[2], basis[2][2];
            long double store[2][64];
            ric_model_complement(2, (const double[]){1, e + 1.0}, basis[0]);
            ric_model_complement(2, (const double[]){e - 0.5, 1}, basis[1]);
            memcpy(u, (const ric_point *)trace->points + 1, sizeof u);
            for (int changed = -1; changed < c->n_unknown; changed++) {
                const double before = changed < 0 ? 0 : u[changed];
                if (changed >= 0) u[changed] = nextafter(before, 10);
                ric_shooting_fly(c, u);
                const bool made = ric_floquet_fine_map(c, NULL, basis[0], basis[1], store[0],
                                                       &sizes[0]);
                assert_int_equal(ric_floquet_known_map(known, c, basis[0], basis[1], store[1],
                                                       &sizes[1]),
                                 made);
                for (int i = 0; i < 4 && made; i++)
                    assert_true(store[0][i] == store[1][i] || isnan(store[0][i]));
                assert_true(!made || sizes[0] == sizes[1]);
                if (changed >= 0) u[changed] = before;
            }
        }
    assert_int_equal(m->n, 2);
    ric_floquet_known_free(known);
    ric_graph_free(graph);
    ric_study_free(study);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_flag_beside_several_touches),
        cmocka_unit_test(rows_belong_to_orbits),
        cmocka_unit_test(flags_keep_to_the_bound),
        cmocka_unit_test(flags_agree),
        cmocka_unit_test(traces_at_grazings_are_lost),
        cmocka_unit_test(each_pair_decides),
        cmocka_unit_test(no_flag_is_left_to_slow_impacts),
        cmocka_unit_test(what_is_lost_is_measured_no_further),
        cmocka_unit_test(a_flag_is_that_of_the_answer),
        cmocka_unit_test(known_maps_are_those_of_the_orbit),
    };
    return cmocka_run_group_tests_name("floquet_flags", tests, NULL, NULL);
}
