/* The dense orbit problem: singular vectors against the Jacobian, steps in its range, second
 * derivatives against differences of the residuals, and the row that says nothing new. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "orbit/room.h"
#include "random_orbits.h"
#include "sample.h"

enum { MAX_N = 4, MAX_FLIGHT = 6, MAX_SIZE = 2 * MAX_N + MAX_FLIGHT + 1 };

typedef void check_chain(ric_singular *q, ric_shooting *chain, const double *u);

static void over_random_chains(check_chain *check)
{
    double u[MAX_SIZE];
    for (int form = 0; form < N_FORM; form++)
        for (int trial = 0; trial < 8; trial += every()) {
            int n = 1 + trial % MAX_N, n_flight = 1 + trial % MAX_FLIGHT, face[MAX_FLIGHT + 1];
            ric_model *m = random_structure_of(77000u + 100u * (uint64_t)form + (uint64_t)trial, n,
                                               2, false, false);
            ric_singular q;
            random_word(m, form, n_flight, face);
            ric_shooting *chain = random_chain_over(m, form, n_flight, face, 1, u);
            ric_shooting_fly(chain, u);
            assert_int_equal(ric_singular_create(chain, true, &q), RIC_OK);
            assert_true(ric_singular_factor(&q, u));
            check(&q, chain, u);
            ric_singular_free(&q);
            ric_shooting_free(chain);
            ric_model_free(m);
        }
}

/* J v_i = s_i u_i, both ways round, and nothing for what is left of the right ones. */
static void check_vectors(ric_singular *q, ric_shooting *chain, const double *u)
{
    int n = q->unknowns, rows = q->equations, least = rows < n ? rows : n;
    double J[(MAX_SIZE + 4) * MAX_SIZE];
    assert_int_equal(ric_shooting_jacobian(chain, u, J), rows);
    for (int k = 0; k < n; k++)
        for (int e = 0; e < rows; e++) {
            double image = ric_dot(n, J + e * n, q->right + k * n),
                   want = k < least ? q->values[k] * q->left[e * rows + k] : 0;
            assert_true(fabs(image - want) <= 1e-12 * q->values[0]);
        }
    int rank = ric_singular_rank(q, 1e-10);
    assert_in_range(rank, 1, least);
    assert_ptr_equal(ric_singular_kernel(q, 2), q->right + (n - 2) * n);
    double left[rows * n];
    assert_int_equal(ric_singular_cokernel(q, n - rank, left), rows - rank);
    for (int i = 0; i < rows - rank; i++)
        for (int j = 0; j < n; j++) {
            double sum = 0;
            for (int e = 0; e < rows; e++) sum += left[i * rows + e] * J[e * n + j];
            assert_true(fabs(sum) <= 1e-9 * q->values[0]);
        }
}

static void singular_vectors(void **state)
{
    (void)state;
    over_random_chains(check_vectors);
}

/* In the general form one equation follows from the others at an orbit, and only there: the closure
 * is perpendicular to the mean gradient. */
static void check_redundant(ric_singular *q, ric_shooting *chain, const double *u)
{
    int rows = q->equations;
    double r[rows], h[rows], along = 0, size = 0;
    if (chain->start != RIC_MIRROR_NONE) return;
    ric_shooting_residuals(chain, u, r);
    ric_singular_redundant(q, h);
    assert_true(fabs(ric_dot(rows, h, h) - 1) < 1e-14);
    for (int i = 0; i < rows; i++) {
        along += h[i] * r[i];
        if (i >= rows - 2 * chain->n) size += r[i] * r[i];
    }
    assert_true(fabs(along) <= 1e-12 * (1 + sqrt(size)) * chain->scale);
}

static void one_equation_says_nothing_new(void **state)
{
    (void)state;
    over_random_chains(check_redundant);
}

/* A step in the whole range takes away what lies in it to first order, and leaves the rest. */
static void check_step(ric_singular *q, ric_shooting *chain, const double *u)
{
    int n = q->unknowns, rows = q->equations, rank = ric_singular_rank(q, 1e-6);
    double J[(MAX_SIZE + 4) * MAX_SIZE], r[rows], v[n], rest = 0;
    ric_shooting_jacobian(chain, u, J);
    for (int i = 0; i < rows; i++) r[i] = uniform(-1, 1);
    memcpy(v, u, sizeof v);
    double outside = ric_singular_step(q, rank, r, v);
    for (int j = 0; j < n; j++) v[j] -= u[j];
    for (int e = 0; e < rows; e++) rest = hypot(rest, r[e] + ric_dot(n, J + e * n, v));
    assert_true(fabs(rest - outside) <= 1e-9 * (1 + q->values[0] / q->values[rank - 1]));
    for (int k = rank; k < n; k++)
        assert_true(fabs(ric_dot(n, q->right + k * n, v)) <= 1e-9 * (1 + sqrt(ric_dot(n, v, v))));
}

static void steps_stay_in_the_range(void **state)
{
    (void)state;
    over_random_chains(check_step);
}

/* left . d^2 r / (du along du right) from second differences of the residuals, error h^2 and
 * rounding / h^2. */
static void check_bend(ric_singular *q, ric_shooting *chain, const double *u)
{
    int n = q->unknowns, rows = q->equations;
    double along[n], right[2 * n], left[rows], out[2], v[n], r[rows],
        h = 1e-3 / (1 + chain->model->omega[chain->n - 1]);
    for (int i = 0; i < n; i++) along[i] = uniform(-1, 1);
    for (int i = 0; i < 2 * n; i++) right[i] = uniform(-1, 1);
    for (int i = 0; i < rows; i++) left[i] = uniform(-1, 1);
    assert_true(ric_singular_bend(q, u, along, 1, left, 2, right, out));
    for (int k = 0; k < 2; k++) {
        double sum = 0;
        for (int a = -1; a <= 1; a += 2)
            for (int b = -1; b <= 1; b += 2) {
                for (int i = 0; i < n; i++) v[i] = u[i] + h * (a * along[i] + b * right[k * n + i]);
                ric_shooting_residuals(chain, v, r);
                sum += a * b * ric_dot(rows, left, r) / (4 * h * h);
            }
        assert_true(fabs(sum - out[k]) <= 1e-4 * (1 + q->values[0] * q->values[0]));
    }
}

static void second_derivatives(void **state)
{
    (void)state;
    over_random_chains(check_bend);
}

/* A kernel is told by a gap: values that fall without one are none. */
static void kernels_are_told_by_a_gap(void **state)
{
    (void)state;
    double values[5] = {100, 1, 1e-3, 1e-9, 1e-9};
    ric_singular q = {.unknowns = 6, .equations = 5, .values = values};
    assert_true(ric_singular_opens(&q, 3) && !ric_singular_opens(&q, 2) &&
                !ric_singular_opens(&q, 4));
    assert_int_equal(ric_singular_rank(&q, 1e-8), 3);
    values[2] = 1e-7; /* above the next by too little */
    assert_false(ric_singular_opens(&q, 3));
    assert_false(ric_singular_opens(&q, 6));
    q.unknowns = 7;
    assert_false(ric_singular_opens(&q, 1));
}

static void directions_have_one_sign(void **state)
{
    (void)state;
    double t[3] = {0.1, -0.7, 0.7 + 1e-9}, s[3] = {0.1, 0.2, 0.9};
    ric_singular_orient(3, t); /* of two alike the first counts */
    assert_true(t[0] == -0.1 && t[1] == 0.7);
    ric_singular_orient(3, s);
    assert_true(s[2] == 0.9);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(singular_vectors),
        cmocka_unit_test(one_equation_says_nothing_new),
        cmocka_unit_test(steps_stay_in_the_range),
        cmocka_unit_test(second_derivatives),
        cmocka_unit_test(kernels_are_told_by_a_gap),
        cmocka_unit_test(directions_have_one_sign),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
