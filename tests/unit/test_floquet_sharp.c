/* Pairs of multipliers beside a large one, in a map that is far from normal: known to what is said
 * of them, and to many digits where they are asked for. */
#include <complex.h>
#include <inttypes.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "explored.h"
#include "multipliers.h"
#include "random_models.h"

/* H = S diag(3, 2^30) S^-1 with S = [1, 1; 1, 2]: integers, all of them doubles. */
static const double LARGE = 0x1p30;

static void an_eigenvalue_beside_a_large_one(void **state)
{
    (void)state;
    const long double H[4] = {6 - LARGE, LARGE - 3, 6 - 2 * LARGE, 2 * LARGE - 3},
                      one[4] = {1, 0, 0, 1};
    for (int product = 0; product < 2; product++) {
        const ric_eigen_factors factors = {2, H, product ? one : NULL, LARGE * 0x1p-64L};
        long double _Complex work[20];
        double mu[2] = {3.0001, 0}, error = 1e-3;
        assert_true(ric_eigen_fine(&factors, LARGE, work, mu, &error));
        assert_true(mu[1] == 0 && fabs(mu[0] - 3) <= error && error < 1e-7);
        /* what was known is not left */
        double off[2] = {3.1, 0}, little = 1e-3;
        assert_false(ric_eigen_fine(&factors, LARGE, work, off, &little));
        assert_true(off[0] == 3.1 && little == 1e-3);
        /* and with another one as near as that nothing is said */
        double near[2] = {3.0001, 0};
        little = 1e-3;
        assert_false(ric_eigen_fine(&factors, 1e-3, work, near, &little));
    }
}

static void a_complex_eigenvalue(void **state)
{
    (void)state;
    /* [0, -2; 1, 2] has 1 +- i; times 2^30 in one direction that it shares with nothing else */
    const long double A[9] = {0, -2, 5, 1, 2, -7, 0, 0, 0x1p30L};
    const ric_eigen_factors factors = {.m = 3, .B = A, .rounding = 1e-12L};
    long double _Complex work[42];
    double mu[2] = {1 + 1e-7, 1 - 1e-7}, error = 1e-5;
    assert_true(ric_eigen_fine(&factors, 2, work, mu, &error));
    assert_true(fabs(mu[0] - 1) <= error && fabs(mu[1] - 1) <= error && error < 1e-9);
}

static void conditions_of_eigenvalues(void **state)
{
    (void)state;
    const double A[9] = {1, 1e6, 0, 0, 2, 0, 0, 0, 7};
    double values[6], condition[3];
    assert_true(ric_eigen_conditions(3, A, values, condition));
    for (int i = 0; i < 3; i++) {
        const double meant = fabs(values[2 * i] - 7) < 1e-9 ? 1 : sqrt(1 + 1e12);
        assert_true(fabs(condition[i] / meant - 1) < 1e-9);
    }
}

/* Eigenvalues [2m] of B C, formed, of entries that are moved at random. */
static void moved_values(int m, const double *B, const double *C, double move, double *mu)
{
    double b[m * m], c[m * m], A[m * m];
    for (int i = 0; i < m * m; i++) {
        b[i] = B[i] + (random_bits() & 1 ? move : -move);
        c[i] = C[i] + (random_bits() & 1 ? move : -move);
        A[i] = 0;
    }
    for (int i = 0; i < m; i++)
        for (int l = 0; l < m; l++)
            for (int j = 0; j < m; j++) A[i * m + j] += b[i * m + l] * c[l * m + j];
    assert_true(ric_eigen(m, A, mu));
}

/* How far each eigenvalue mu [2m] is from the nearest of moved factors: the root mean square of 40
 * ways, off [m]. */
static void typical_moves(int m, const double *B, const double *C, double move, const double *mu,
                          double *off)
{
    enum { WAYS = 40 };
    double other[2 * m];
    for (int i = 0; i < m; i++) off[i] = 0;
    for (int way = 0; way < WAYS; way++) {
        moved_values(m, B, C, move, other);
        for (int i = 0; i < m; i++) {
            double near = HUGE_VAL;
            for (int j = 0; j < m; j++)
                near = fmin(near,
                            hypot(other[2 * j] - mu[2 * i], other[2 * j + 1] - mu[2 * i + 1]));
            off[i] += near * near / WAYS;
        }
    }
    for (int i = 0; i < m; i++) off[i] = sqrt(off[i]);
}

/* A single way of moving the entries may lie across what it moves: that of 3 * 3 by +, - moves
 * nothing. Of 1,500 errors by three ways 8 are less than what is usual. */
static void errors_of_a_product(void **state)
{
    (void)state;
    const double move = 0x1p-30;
    int count = 0, less = 0;
    seed_now = 20261125;
    print_message("# seed %" PRIu64 "\n", seed_now);
    for (int sample = 0; sample < 600; sample++) {
        const int m = 1 + sample % 4;
        double B[m * m], C[m * m], H[3 * m * m], mu[2 * m], off[m], error[m];
        for (int i = 0; i < m * m; i++) {
            B[i] = sample ? uniform(-1, 1) : 3;
            C[i] = sample ? uniform(-1, 1) : 3;
        }
        assert_true(ric_eigen_product(m, B, C, move, H, mu, error));
        typical_moves(m, B, C, move, mu, off);
        for (int i = 0; i < m; i++) {
            count++;
            less += off[i] > error[i];
            if (m == 1) assert_true(off[i] <= error[i]);
        }
    }
    print_message("# %d of %d errors are less than usual moves\n", less, count);
    assert_true(less <= count / 50);
}

/* A stop that is hit at a thousandth of the speed that others have, by five masses: one pair goes
 * with 1 / speed. */
static const char slow[] = "{'model': {'mass': [[2.484375, 0.3125, -0.109375, 0.203125, -0.03125], "
                           "[0.3125, 2.234375, 0.234375, -0.0625, "
                           "0.0625], [-0.109375, 0.234375, 2.59375, -0.453125, -0.28125], "
                           "[0.203125, -0.0625, -0.453125, 2.71875, 0.25], "
                           "[-0.03125, 0.0625, -0.28125, 0.25, 1.375]], 'stiffness': "
                           "[[4157726.2539241193, 2144845.109369286, "
                           "1903900.3185194172, -1093083.7750816809, 1943592.9121564946], "
                           "[2144845.109369286, 2929256.9366849638, "
                           "2244686.629136444, -995528.5180858144, 24846.0852736071], "
                           "[1903900.3185194172, 2244686.629136444, "
                           "6734052.650602731, -1985745.511920632, -341925.0609715717], "
                           "[-1093083.7750816809, -995528.5180858144, "
                           "-1985745.511920632, 1361720.996976631, -192554.7322440485], "
                           "[1943592.9121564946, 24846.0852736071, "
                           "-341925.0609715717, -192554.7322440485, 2544091.1235087276]], "
                           "'contacts': [{'normal': [0, 0, 0, -1, 1], "
                           "'law': 'rigid', 'clearance': 18, 'sides': 'both'}, {'normal': [1, 0, "
                           "0, 0, 0], 'law': 'rigid', 'clearance': "
                           "13.5, 'sides': 'upper'}, {'normal': [0, 0, 1, 0, 0], 'law': 'rigid', "
                           "'clearance': 7.98, 'sides': 'both'}]}, "
                           "'explore': {'start': 'modes', 'energy': [0, 4823000], 'frequency': "
                           "[100, 6000], 'impacts': 1, 'multiply': 1, "
                           "'depth': 0}}";

/* Over the period without use of reversibility: another map, of another size, with other
 * conditions. */
static ric_floquet general(const ric_continuation *trace, const double *u, ric_stability *flag)
{
    ric_periodic *cycle = ric_continuation_cycle(trace, u);
    ric_shooting *chain = NULL;
    double *v = NULL;
    ric_floquet out;
    assert_non_null(cycle);
    cycle->half = false;
    cycle->pure = cycle->flip = -1;
    assert_int_equal(ric_periodic_to_chain(trace->chain->model, cycle, &chain, &v), RIC_OK);
    assert_int_equal(ric_floquet_create(chain->n, &out), RIC_OK);
    assert_int_equal(ric_continuation_multipliers(chain, v, &out), RIC_OK);
    *flag = out.stable;
    ric_shooting_free(chain);
    ric_periodic_free(cycle);
    free(v);
    return out;
}

static int compared, sharp;

/* Every rho that is known of one is there in the other within what is said of both. */
static void compare(const ric_floquet *a, const ric_floquet *b, const char *where)
{
    for (int i = 0; i < a->n_pair; i++) {
        const double complex r = a->rho[2 * i] + a->rho[2 * i + 1] * I;
        double least = HUGE_VAL, allowed = 0;
        bool all = isfinite(creal(r)) && a->each[i] < 1e-4;
        for (int j = 0; j < b->n_pair && all; j++) {
            const double off = cabs(b->rho[2 * j] + b->rho[2 * j + 1] * I - r);
            all = isfinite(off);
            if (off - b->each[j] >= least) continue;
            least = off - b->each[j];
            allowed = b->each[j];
        }
        if (!all) continue;
        compared++;
        sharp += a->each[i] < 1e-8 * (1 + cabs(r));
        if (!(least <= a->each[i]))
            fail_msg("%s: rho %.12g %.3g is %.3g from the other form, %.3g and %.3g allowed", where,
                     creal(r), cimag(r), least + allowed, a->each[i], allowed);
    }
}

static void two_forms_of_a_slow_impact(void **state)
{
    (void)state;
    ric_study *study = NULL;
    if (ric_study_parse(slow, "slow", NULL, &study)) fail_msg("%s", ric_detail());
    ric_graph *graph = explored_graph(study);
    for (int e = 0; e < graph->n_edge; e++) {
        const ric_continuation *trace = graph->edges[e].trace;
        for (int i = 0; trace && trace->chain->n_flight && i < trace->n_point; i++) {
            const double *u = (const double *)((const ric_point *)(trace->points +
                                                                   (size_t)i * trace->stride) +
                                               1);
            ric_floquet own = multipliers(trace->chain, u);
            ric_stability flag;
            assert_int_equal(ric_continuation_multipliers(trace->chain, u, &own), RIC_OK);
            ric_floquet other = general(trace, u, &flag);
            char where[64];
            snprintf(where, sizeof where, "branch %d, point %d", e, i);
            compare(&own, &other, where);
            compare(&other, &own, where);
            if (own.stable != RIC_STABLE_UNDECIDED && flag != RIC_STABLE_UNDECIDED)
                assert_int_equal(own.stable, flag);
            ric_floquet_release(&own);
            ric_floquet_release(&other);
        }
    }
    print_message("# %d pairs, %d of them to 1e-8\n", compared, sharp);
    assert_true(compared > 100 && sharp > compared * 3 / 4);
    ric_graph_free(graph);
    ric_study_free(study);
}

/* Where a spring is closed for an instant its multiplier is lost by what rounding may make of the
 * orbit, and is still given from the stored trace: its error is that of what was lost, and not
 * none. */
static void error_of_what_is_lost(void **state)
{
    (void)state;
    ric_floquet f;
    assert_int_equal(ric_floquet_create(2, &f), RIC_OK);
    f.rho[0] = 1347.7;
    ric_floquet_widen(&f, (double[]){9.6});
    assert_true(isnan(f.rho[0]) && f.error >= 9.6);
    f.rho[0] = 1347.7;
    f.rho[1] = f.each[0] = 0;
    ric_floquet_widen(&f, (double[]){1e-4});
    assert_true(f.rho[0] == 1347.7 && f.error == 1e-4);
    ric_floquet_release(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_eigenvalue_beside_a_large_one), cmocka_unit_test(a_complex_eigenvalue),
        cmocka_unit_test(conditions_of_eigenvalues),        cmocka_unit_test(errors_of_a_product),
        cmocka_unit_test(two_forms_of_a_slow_impact),       cmocka_unit_test(error_of_what_is_lost),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
