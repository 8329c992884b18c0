/* Births and joins of detached resonances: extrema of the threshold along a branch, against
 * differences of what is predicted at neighbouring energies, and against the exact forced
 * structure. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "responses.h"

#include "explored.h"

enum { FREQUENCIES = 5 };

#define WINDOW                                                                                     \
    "explore: {energy: [0, 12], frequency: [0.5, 6], impacts: 4, multiply: 1, depth: 2}\n"
#define TWO_MASSES                                                                                 \
    "title: t\nmodel:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  contacts:\n"
static const char *const rigid = TWO_MASSES
    "    - {normal: [-1, 1], clearance: 1, sides: both, law: rigid}\n"
    "explore: {energy: [0, 60], frequency: [0.3, 4], impacts: 4, multiply: 2, depth: 2}\n";
static const char *const spring = TWO_MASSES
    "    - {normal: [-1, 1], clearance: 0.5, sides: both, law: bilinear, stiffness: 30}\n" WINDOW;
static const char *const cubic = TWO_MASSES
    "    - {normal: [-1, 1], law: power, exponent: 3, stiffness: 2}\n" WINDOW;

static ric_force *shaken(const ric_atlas *atlas, double second, double zeta, double e)
{
    ric_force *force = NULL;
    const double f[] = {1, second};
    const ric_shaking shaking = {.n_force = 2,
                                 .force = f,
                                 .n_ratio = 1,
                                 .ratios = &zeta,
                                 .restitution = e};
    if (ric_force_create(atlas, &shaking, &force)) fail_msg("%s", ric_detail());
    return force;
}

/* ---------------------------------------------------------------- differences */

/* log F* of the orbit nearest to that frequency, at this energy. */
static double log_threshold(const ric_force *force, const ric_atlas *atlas, int id, int harmonic,
                            double energy, double frequency)
{
    ric_orbit **orbits;
    int n;
    double nearest = INFINITY, out = NAN;
    if (ric_orbit_find(atlas, id, RIC_AT_ENERGY, energy, &n, &orbits)) fail_msg("%s", ric_detail());
    for (int i = 0; i < n; i++) {
        ric_prediction p;
        assert_int_equal(ric_force_predict(force, id, orbits[i], harmonic, 0, &p), RIC_OK);
        if (!(fabs(p.frequency - frequency) < nearest)) continue;
        nearest = fabs(p.frequency - frequency);
        out = log(p.threshold);
    }
    ric_orbits_free(n, orbits);
    return out;
}

/* d log F* / d log E and its derivative, by central differences of fourth order. */
static void differences(const ric_force *force, const ric_atlas *atlas, int id,
                        const ric_force_extreme *x, double h, double out[2])
{
    double y[5];
    for (int k = -2; k <= 2; k++)
        y[k + 2] = log_threshold(force, atlas, id, x->at.harmonic, x->at.energy * exp(k * h),
                                 x->at.frequency);
    out[0] = (y[0] - 8 * y[1] + 8 * y[3] - y[4]) / (12 * h);
    out[1] = (-y[0] + 16 * y[1] - 30 * y[2] + 16 * y[3] - y[4]) / (12 * h * h);
}

/* Rounding of log F* beside an extreme, where energies that differ by no more have the same: high
 * harmonics are the small rest of what cancels. */
static double noise(const ric_force *force, const ric_atlas *atlas, int id,
                    const ric_force_extreme *x)
{
    double least = INFINITY, most = -INFINITY;
    for (int k = -4; k <= 4; k++) {
        const double y = log_threshold(force, atlas, id, x->at.harmonic,
                                       x->at.energy * exp(k * 1e-11), x->at.frequency);
        least = fmin(least, y);
        most = fmax(most, y);
    }
    return most - least;
}

/* How far off the place is by the differences, in log E, no more than they are known themselves;
 * false: they tell little. */
static bool is_extreme(const ric_force *force, const ric_atlas *atlas, int id,
                       const ric_force_extreme *x)
{
    double coarse[2], fine[2];
    differences(force, atlas, id, x, 4e-3, coarse);
    differences(force, atlas, id, x, 2e-3, fine);
    const double off = fabs(fine[0] / fine[1]),
                 rounding = 1e-11 + 18 / (12 * 2e-3) * noise(force, atlas, id, x),
                 known = fabs((coarse[0] - fine[0]) / fine[1]) / 4 + rounding / fabs(fine[1]);
    if (!(known < 1e-7)) return false; /* a fold of the energy, or an end, is near */
    if (!(off <= known) || !((fine[1] > 0) == x->birth))
        fail_msg("branch %d harmonic %d: the place is off by %.3g, known to %.3g; second "
                 "derivative %.3g",
                 id, x->at.harmonic, off, known, fine[1]);
    if (!(x->error < 1e-9)) fail_msg("branch %d: the error is said to be %.3g", id, x->error);
    return true;
}

/* All extrema of a structure that lie clear of folds of the energy, where differences by it tell
 * nothing. */
static void all_extremes(const char *study, double second, double e, int births, int joins)
{
    ric_atlas *atlas = explore_text(study);
    ric_force *force = shaken(atlas, second, 0.01, e);
    int found[2] = {0, 0};
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++)
        for (int harmonic = 1; harmonic <= 5; harmonic += 2) {
            ric_force_extreme *list;
            int n;
            assert_int_equal(ric_force_extremes(force, id, harmonic, &n, &list), RIC_OK);
            for (int i = 0; i < n; i++) {
                const double slope = list[i].at.slope * list[i].at.energy * list[i].at.frequency;
                if (isnan(list[i].error) || !(fabs(slope) > 0.05) || fabs(slope) > 20) continue;
                found[list[i].birth] += is_extreme(force, atlas, id, &list[i]);
            }
            ric_force_extremes_free(list);
        }
    if (found[1] < births || found[0] < joins)
        fail_msg("%d births, %d joins: %s", found[1], found[0], study);
    ric_force_free(force);
    ric_atlas_free(atlas);
}

static void test_located(void **state)
{
    (void)state;
    all_extremes(rigid, -0.1, 0.9, 4, 0);
    all_extremes(rigid, -0.5, 0.9, 2, 1);
    all_extremes(spring, -0.1, 1, 1, 0);
    all_extremes(cubic, -0.1, 1, 1, 0);
}

/* ---------------------------------------------------------------------- exact */

/* Level at which the exact curve of that branch folds at a frequency, nearest to `near`. */
static double fold_at(const ric_atlas *atlas, int id, double zeta, double e, double omega,
                      double near)
{
    const double f[] = {1, -0.1};
    ric_response_options o;
    double best = INFINITY;
    ric_response_defaults(&o);
    o.along = RIC_RESPONSE_LEVEL;
    o.shaking = (ric_shaking){.n_force = 2,
                              .force = f,
                              .n_ratio = 1,
                              .ratios = &zeta,
                              .restitution = e};
    o.window[0] = near * 0.7;
    o.window[1] = near * 1.3;
    o.omega = omega;
    o.branch = id;
    o.impacts = 2;
    o.periods = 1;
    ric_response *r = response_of(atlas, &o);
    for (int k = 1; k <= ric_response_n_event(r); k++) {
        ric_response_event x;
        assert_int_equal(ric_response_event_at(r, k, &x), RIC_OK);
        if (x.kind == RIC_RESPONSE_FOLD && fabs(x.at.level - near) < fabs(best - near))
            best = x.at.level;
    }
    ric_response_free(r);
    if (!isfinite(best)) fail_msg("no fold at omega %.10g", omega);
    return best;
}

/* The least value, and its place, of the polynomial through levels at evenly spaced frequencies, -2
 * .. 2. */
static void least(const double y[FREQUENCIES], double *at, double *value)
{
    const double c1 = (y[0] - 8 * y[1] + 8 * y[3] - y[4]) / 12,
                 c2 = (-y[0] + 16 * y[1] - 30 * y[2] + 16 * y[3] - y[4]) / 24,
                 c3 = (-y[0] + 2 * y[1] - 2 * y[3] + y[4]) / 12,
                 c4 = (y[0] - 4 * y[1] + 6 * y[2] - 4 * y[3] + y[4]) / 24;
    double x = 0;
    for (int k = 0; k < 50; k++)
        x -= (c1 + x * (2 * c2 + x * (3 * c3 + x * 4 * c4))) /
             (2 * c2 + x * (6 * c3 + x * 12 * c4));
    *at = x;
    *value = y[2] + x * (c1 + x * (c2 + x * (c3 + x * c4)));
}

/* Losses halved: the force and the frequency at which the isola of S2+ is born exactly come nearer
 * to what is predicted, and that at least by a half each time. */
static void test_exact_birth(void **state)
{
    (void)state;
    ric_atlas *atlas = explore_text(rigid);
    double last[2] = {NAN, NAN};
    const int id = branch_named(atlas, "S2+[01]");
    for (int k = 0; k < 4; k++) {
        const double zeta = ldexp(0.002, -k), e = 1 - ldexp(0.02, -k), width = 0.004;
        ric_force *force = shaken(atlas, -0.1, zeta, e);
        ric_force_extreme *x;
        double level[FREQUENCIES], at, value;
        int n;
        assert_int_equal(ric_force_extremes(force, id, 1, &n, &x), RIC_OK);
        assert_true(n == 1 && x[0].birth);
        for (int j = 0; j < FREQUENCIES; j++)
            level[j] = fold_at(atlas, id, zeta, e, x[0].at.omega * (1 + width * (j - 2)),
                               x[0].at.threshold);
        least(level, &at, &value);
        const double off[] = {fabs(value / x[0].at.threshold - 1), fabs(at * width)};
        print_message(
            "zeta %g: predicted %.12g at %.12g, exact %.12g at %.12g, off by %.3g and %.3g\n", zeta,
            x[0].at.threshold, x[0].at.omega, value, x[0].at.omega * (1 + at * width), off[0],
            off[1]);
        for (int j = 0; j < 2; j++) {
            if (k > 0 && !(fabs(log2(last[j] / off[j]) - 1) < 0.1))
                fail_msg("step %d: slope %g", k, log2(last[j] / off[j]));
            last[j] = off[j];
        }
        ric_force_extremes_free(x);
        ric_force_free(force);
    }
    ric_atlas_free(atlas);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_located),
                                       cmocka_unit_test(test_exact_birth)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
