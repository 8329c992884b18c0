/* The predicted stability of forced orbits beside that of the exact ones: where the prediction is
 * trusted, it decides nothing that the exact multipliers decide otherwise. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "explored.h"

enum { MOST = 3, LETTERS = 64 };

#define WINDOW "explore: {energy: [0, 6], frequency: [0.4, 4], impacts: 2, multiply: 1, depth: 1}\n"
#define TWO_MASS                                                                                   \
    "title: t\nmodel:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  contacts:\n  " \
    "  - {normal: [-1, "                                                                           \
    "1], "
#define THREE_MASS                                                                                 \
    "title: t\nmodel:\n  mass: [[1, 0, 0], [0, 1.3, 0], [0, 0, 0.7]]\n  stiffness: [[3, -1, 0], "  \
    "[-1, 3, -1], [0, -1, "                                                                        \
    "2]]\n  contacts:\n    - {normal: [0, 0, 1], "

static const char *const studies[] = {
    TWO_MASS "clearance: 1, sides: both, law: rigid}\n" WINDOW,
    THREE_MASS "clearance: 0.4, sides: both, law: rigid}\n" WINDOW,
    THREE_MASS "clearance: 0.4, sides: upper, law: rigid}\n" WINDOW,
    THREE_MASS "clearance: 0.4, sides: upper, law: bilinear, stiffness: 3}\n" WINDOW,
    THREE_MASS "law: power, exponent: 3, stiffness: 2}\n" WINDOW,
};

/* Damping that is alike in all modes, that hardly reaches some of them, and impacts alone. */
static const struct {
    double ratios[MOST], restitution;
} losses[] = {{{0.004, 0.004, 0.004}, 1},
              {{0.004, 1e-5, 0.004}, 1},
              {{1e-5, 0.004, 1e-5}, 0.999},
              {{0.004, 0.004, 1e-6}, 1},
              {{1e-6, 1e-6, 1e-6}, 0.99}};

typedef struct {
    int agree, undecided, exact_undecided;
} counts;

static void compare(const ric_force *force, const ric_branch *b, const ric_orbit *orbit,
                    double times, counts *c)
{
    ric_prediction p;
    ric_forced x;
    double state[2 * MOST], flights[LETTERS], multipliers[4 * MOST];
    assert_int_equal(ric_force_predict(force, b->id, orbit, 1, 0, &p), RIC_OK);
    if (!(p.threshold > 0) || isinf(p.threshold)) return;
    const double level = times * p.threshold;
    assert_int_equal(ric_force_predict(force, b->id, orbit, 1, level, &p), RIC_OK);
    if (!p.trusted || p.n_phase < 2) return;
    if (ric_force_solve(force, orbit, 1, level, p.phases[0], &x, state, flights, multipliers) ||
        *x.fault)
        return;
    if (p.stable == RIC_STABLE_UNDECIDED) c->undecided++;
    else if (x.stable == RIC_STABLE_UNDECIDED) c->exact_undecided++;
    else if (p.stable == x.stable) c->agree++;
    else
        fail_msg("%s at E %.6g: predicted %d, the exact orbit has |rho| = %.9g (next order %.3g)",
                 b->label, p.energy, p.stable, x.largest, p.estimate);
}

static void test_exact_multipliers(void **unused)
{
    (void)unused;
    counts all = {0, 0, 0};
    for (size_t i = 0; i < sizeof studies / sizeof *studies; i++) {
        ric_atlas *atlas = explore_text(studies[i]);
        const int n = ric_model_n_dof(ric_atlas_model(atlas));
        for (size_t k = 0; k < sizeof losses / sizeof *losses; k++) {
            const double f[] = {1, -0.3, 0.2};
            const ric_shaking shaking = {.n_force = n,
                                         .force = f,
                                         .n_ratio = n,
                                         .ratios = losses[k].ratios,
                                         .restitution = i < 3 ? losses[k].restitution : 1};
            ric_force *force;
            if (ric_force_create(atlas, &shaking, &force)) fail_msg("%s", ric_detail());
            for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
                const ric_branch b = branch_of(atlas, id);
                for (int at = 2; at < b.n_point - 2; at += 1 + b.n_point / 12) {
                    ric_orbit **orbits;
                    int count;
                    assert_int_equal(ric_orbit_find(atlas, id, RIC_AT_POINT, at, &count, &orbits),
                                     RIC_OK);
                    compare(force, &b, orbits[0], 1.3, &all);
                    compare(force, &b, orbits[0], 3, &all);
                    ric_orbits_free(count, orbits);
                }
            }
            ric_force_free(force);
        }
        ric_atlas_free(atlas);
    }
    print_message("%d agree, %d not predicted, %d not decided by the exact multipliers\n",
                  all.agree, all.undecided, all.exact_undecided);
    assert_true(all.agree > 400 && all.agree > 2 * all.undecided);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_exact_multipliers)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
