/* Inner nodes of flights under a power law: the structured solve against the dense equations, and
 * against the flight in one piece. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <lapacke.h>

#include "orbit/shooting_nodes.h"
#include "random_models.h"
#include "sample.h"

enum { MOST = 4, PARTS = 5, SIZE = 2 * MOST * (PARTS + 1) + 4 };

typedef struct {
    ric_mirror start, end;
    int sigma;
} form;
static const form forms[] = {{RIC_MIRROR_NONE, RIC_MIRROR_NONE, 1},
                             {RIC_MIRROR_NONE, RIC_MIRROR_NONE, -1},
                             {RIC_MIRROR_REST, RIC_MIRROR_REST, 1},
                             {RIC_MIRROR_CENTRE, RIC_MIRROR_CENTRE, 1},
                             {RIC_MIRROR_CENTRE, RIC_MIRROR_REST, 1},
                             {RIC_MIRROR_REST, RIC_MIRROR_CENTRE, 1}};
enum { N_FORM = sizeof forms / sizeof *forms };
static const int no_face[] = {-1, -1};

static ric_model *random_structure(int n)
{
    static const int exponents[] = {3, 5, 7, 11};
    double M[MOST * MOST], K[MOST * MOST], normal[2 * MOST];
    ric_contact contacts[2];
    ric_model *m;
    random_definite(n, n, 0.5, M);
    random_definite(n, n, 0.3, K);
    for (int f = 0; f < 2; f++) {
        for (int i = 0; i < n; i++) normal[f * n + i] = uniform(-1, 1);
        contacts[f] = (ric_contact){.normal = normal + f * n,
                                    .law = RIC_LAW_POWER,
                                    .exponent = exponents[below(4)],
                                    .stiffness = uniform(0.3, 2)};
    }
    if (ric_model_create(n, M, K, 1 + below(2), contacts, 1, &m)) fail_msg("%s", ric_detail());
    return m;
}

static ric_shooting *chain_of(const ric_model *m, const form *f, int parts)
{
    ric_shooting *c;
    assert_int_equal(ric_shooting_create(m, f->start, f->end, f->sigma, 1, no_face, &c), RIC_OK);
    if (parts > 1) assert_int_equal(ric_shooting_nodes_divide(c, parts), RIC_OK);
    return c;
}

typedef void check_chain(ric_shooting *c, const double *u, const char *where);

/* Unknowns anywhere, the nodes beside the flight. */
static void over_random_chains(check_chain *check)
{
    for (int n = 1; n <= MOST; n++)
        for (int k = 0; k < N_FORM; k++)
            for (int parts = 2; parts <= PARTS; parts += every()) {
                char where[80];
                double u[SIZE];
                seed_now = (uint64_t)(1000 * n + 100 * k + parts);
                snprintf(where, sizeof where, "n = %d, form %d, %d parts", n, k, parts);
                ric_model *m = random_structure(n);
                ric_shooting *c = chain_of(m, &forms[k], parts);
                for (int i = 0; i < c->n_start; i++) u[i] = uniform(-1, 1);
                u[c->n_start] = uniform(0.5, 3);
                ric_shooting_nodes_spread(c, u);
                for (int i = c->n_start + 1; i < c->n_unknown; i++) u[i] += uniform(-0.1, 0.1);
                check(c, u, where);
                ric_shooting_free(c);
                ric_model_free(m);
            }
}

/* ----------------------------------------------------------------- Jacobian */

static void check_jacobian(ric_shooting *c, const double *u, const char *where)
{
    static const double weight[4] = {1.0 / 12, -2.0 / 3, 2.0 / 3, -1.0 / 12},
                        offset[4] = {-2, -1, 1, 2};
    double J[SIZE * SIZE], moved[SIZE], r[4][SIZE], top = 0, h = 1e-4;
    /* the phase is free, not an equation */
    int unknowns = c->n_unknown, rows = ric_shooting_jacobian(c, u, J),
        first = c->start == RIC_MIRROR_NONE;
    assert_int_equal(rows, c->start == RIC_MIRROR_NONE ? unknowns : unknowns - 1);
    for (int i = 0; i < rows * unknowns; i++) top = fmax(top, fabs(J[i]));
    for (int j = 0; j < unknowns; j++) {
        for (int k = 0; k < 4; k++) {
            memcpy(moved, u, (size_t)unknowns * sizeof *u);
            moved[j] += offset[k] * h;
            assert_int_equal(ric_shooting_residuals(c, moved, r[k]), rows);
        }
        for (int i = first; i < rows; i++) {
            double slope = 0;
            for (int k = 0; k < 4; k++) slope += weight[k] * r[k][i] / h;
            if (!(fabs(slope - J[i * unknowns + j]) <= 1e-7 * (1 + top)))
                fail_msg("%s: row %d, column %d: %.12g against %.12g by differences", where, i, j,
                         J[i * unknowns + j], slope);
        }
    }
}

static void jacobian_by_differences(void **state)
{
    (void)state;
    over_random_chains(check_jacobian);
}

/* --------------------------------------------------- structured and dense */

/* The equations as the structured solve sees them: closure rows perpendicular to the secant
 * gradient of the energy. Returns their number. */
static int dense_equations(ric_shooting *c, const double *u, double *A, double *r)
{
    double J[SIZE * SIZE], all[SIZE], from[2 * MOST], h[2 * MOST], E[4 * MOST * MOST];
    int unknowns = c->n_unknown, n2 = 2 * c->n, rows = ric_shooting_jacobian(c, u, J),
        before = rows - n2;
    ric_shooting_residuals(c, u, all);
    memcpy(A, J, (size_t)(rows * unknowns) * sizeof *A);
    memcpy(r, all, (size_t)rows * sizeof *r);
    if (c->start != RIC_MIRROR_NONE) return rows;
    for (int i = 0; i < n2; i++) from[i] = c->sigma * c->w[i];
    ric_flight_secant(c->model, 0, from, c->w + n2, h);
    ric_model_complement(n2, h, E);
    for (int i = 0; i < n2 - 1; i++) {
        r[before + i] = ric_dot(n2, E + i * n2, all + before);
        for (int j = 0; j < unknowns; j++) {
            double sum = 0;
            for (int k = 0; k < n2; k++) sum += E[i * n2 + k] * J[(before + k) * unknowns + j];
            A[(before + i) * unknowns + j] = sum;
        }
    }
    return rows - 1;
}

/* The step solves the equations and is perpendicular to the kernel: there is one such. */
static void check_step(ric_shooting *c, const double *u, const char *where)
{
    double A[SIZE * SIZE], r[SIZE], newton[SIZE], kernel[SIZE], both[SIZE], plane[2 * SIZE], second,
        top = 0;
    int unknowns = c->n_unknown, rows = dense_equations(c, u, A, r);
    assert_int_equal(rows, unknowns - 1);
    ric_shooting_evaluate(c, u);
    ric_shooting_step(c, true, 0, newton);
    ric_shooting_step(c, false, 1, kernel);
    ric_shooting_step(c, true, 0.7, both);
    for (int i = 0; i < rows * unknowns; i++) top = fmax(top, fabs(A[i]));
    double size = sqrt(ric_dot(unknowns, newton, newton)), limit = 1e-12 * (1 + top);
    for (int i = 0; i < rows; i++) {
        double off = r[i] + ric_dot(unknowns, A + i * unknowns, newton),
               null = ric_dot(unknowns, A + i * unknowns, kernel);
        if (!(fabs(off) <= limit * (1 + size)) || !(fabs(null) <= limit))
            fail_msg("%s: row %d is off by %g, of the kernel by %g", where, i, off, null);
    }
    assert_true(fabs(ric_dot(unknowns, kernel, kernel) - 1) < 1e-12);
    assert_true(fabs(ric_dot(unknowns, kernel, newton)) <= 1e-12 * (1 + size));
    for (int i = 0; i < unknowns; i++)
        assert_true(fabs(both[i] - newton[i] - 0.7 * kernel[i]) <= 1e-12 * (1 + size));
    assert_true(ric_shooting_plane(c, plane, &second));
    assert_true(fabs(fabs(ric_dot(unknowns, plane + unknowns, kernel)) - 1) < 1e-10);
}

static void step_against_dense(void **state)
{
    (void)state;
    over_random_chains(check_step);
}

/* end_det may have any sign that is the same wherever the chain is evaluated: that of det [A;
 * kernel], or the other. */
static void check_determinant(ric_shooting *c, const double *u, const char *where)
{
    double A[SIZE * SIZE], r[SIZE], v[SIZE], first = 0;
    int unknowns = c->n_unknown;
    lapack_int pivot[SIZE];
    for (int k = 0; k < 20; k++) {
        for (int i = 0; i < unknowns; i++)
            v[i] = u[i] + (i == c->n_start ? uniform(-0.3, 0.6) : uniform(-0.4, 0.4));
        int rows = dense_equations(c, v, A, r);
        ric_shooting_evaluate(c, v);
        ric_shooting_step(c, false, 1, A + rows * unknowns);
        LAPACKE_dgetrf(LAPACK_ROW_MAJOR, unknowns, unknowns, A, unknowns, pivot);
        double sign = c->end_det < 0 ? -1 : 1;
        for (int i = 0; i < unknowns; i++)
            sign *= (A[i * unknowns + i] < 0 ? -1 : 1) * (pivot[i] == i + 1 ? 1 : -1);
        if (first == 0) first = sign;
        if (sign != first)
            fail_msg("%s: the sign of the bordered determinant does not follow (sample %d)", where,
                     k);
    }
}

static void determinant_sign(void **state)
{
    (void)state;
    over_random_chains(check_determinant);
}

/* ------------------------------------------------------------ in one piece */

static double distance(int size, const double *a, const double *b)
{
    double most = 0;
    for (int i = 0; i < size; i++) most = fmax(most, fabs(a[i] - b[i]));
    return most;
}

/* With the nodes on the flight, everything is what it is without nodes. */
static void check_one_piece(ric_shooting *c, const double *u, const char *where)
{
    form same = {c->start, c->end, c->sigma};
    ric_shooting *one = chain_of(c->model, &same, 1), *copy = ric_shooting_copy(c);
    double v[SIZE], kernel[SIZE], along[SIZE], alone[SIZE];
    int n2 = 2 * c->n, size = one->n_unknown;
    memcpy(v, u, sizeof v);
    ric_shooting_nodes_spread(c, v);
    ric_shooting_evaluate(one, v);
    ric_shooting_evaluate(copy, v);
    assert_int_equal(copy->parts, c->parts);
    double growth = 1;
    for (int i = 0; i < n2 * n2; i++) growth = fmax(growth, fabs(one->map[i]));
    if (!(ric_shooting_nodes_gap(copy, v) <= 1e-14 * one->scale * growth) ||
        !(distance(n2, copy->w + n2, one->w + n2) <= 1e-13 * one->scale * growth) ||
        !(distance(n2 * n2, copy->map, one->map) <= 1e-12 * growth * growth))
        fail_msg("%s: not the flight in one piece: %g, %g", where,
                 distance(n2, copy->w + n2, one->w + n2), distance(n2 * n2, copy->map, one->map));
    /* the kernel has the same start, longer by what it is at the nodes */
    ric_shooting_step(one, false, 1, alone);
    ric_shooting_step(copy, false, 1, kernel);
    double part = ric_dot(size, alone, kernel);
    memcpy(along, kernel, sizeof along);
    ric_shooting_nodes_along(copy, along);
    assert_true(distance(copy->n_unknown, along, kernel) <= 1e-11 * growth);
    for (int i = 0; i < size; i++) assert_true(fabs(kernel[i] - part * alone[i]) <= 1e-10 * growth);
    ric_shooting_free(one);
    ric_shooting_free(copy);
}

static void like_one_piece(void **state)
{
    (void)state;
    over_random_chains(check_one_piece);
}

/* Flights in turn are flown once each, with the bits of a chain that has flown nothing before; a
 * chain that is done keeps none, and flies as before. */
static void flights_are_kept(void **state)
{
    (void)state;
    seed_now = 7;
    ric_model *m = random_structure(2);
    ric_shooting *c = chain_of(m, &forms[0], 1), *done = chain_of(m, &forms[0], 1);
    const size_t map = 16 * sizeof *c->map;
    double u[3][SIZE];
    for (int k = 0; k < 3; k++) {
        for (int i = 0; i < c->n_start; i++) u[k][i] = uniform(-1, 1);
        u[k][c->n_start] = uniform(1, 3);
    }
    ric_shooting_nodes_drop(done);
    for (int turn = 0; turn < 30; turn++) {
        const double *now = u[turn * turn % 7 % 3];
        ric_shooting *fresh = chain_of(m, &forms[0], 1);
        ric_shooting_evaluate(fresh, now);
        ric_shooting_evaluate(c, now);
        ric_shooting_evaluate(done, now);
        assert_true(c->n_kept <= 3);
        assert_int_equal(done->n_kept, 0);
        assert_memory_equal(c->w, fresh->w, 8 * sizeof *c->w);
        assert_memory_equal(c->rate, fresh->rate, 4 * sizeof *c->rate);
        assert_memory_equal(c->map, fresh->map, map);
        assert_memory_equal(done->map, fresh->map, map);
        assert_true(c->lost == fresh->lost && c->residual == fresh->residual);
        assert_true(c->end_det == fresh->end_det);
        ric_shooting_free(fresh);
    }
    assert_int_equal(c->n_kept, 3);
    ric_shooting_free(c);
    ric_shooting_free(done);
    ric_model_free(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(jacobian_by_differences), cmocka_unit_test(step_against_dense),
        cmocka_unit_test(determinant_sign),        cmocka_unit_test(like_one_piece),
        cmocka_unit_test(flights_are_kept),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
