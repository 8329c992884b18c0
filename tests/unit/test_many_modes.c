/* What makes multipliers of many modes quick leaves them as they are: factors and products by
 * blocks have the bits of the textbook, an orbit that is asked for again has those of the first
 * answer, and no pair is known or lost because less is asked. */
#include <float.h>
#include <inttypes.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/room.h"
#include "explored.h"
#include "multipliers.h"
#include "orbit/floquet_again.h"
#include "random_models.h"

static void fill(int count, double *A)
{
    for (int i = 0; i < count; i++) A[i] = uniform(-1, 1);
}

/* Elimination entry by entry; the sign of the exchanges. */
static int eliminated(int m, double *A)
{
    int sign = 1;
    for (int c = 0; c < m; c++) {
        int best = c;
        for (int i = c + 1; i < m; i++)
            if (fabs(A[i * m + c]) > fabs(A[best * m + c])) best = i;
        if (best != c) sign = -sign;
        for (int j = 0; j < m && best != c; j++) {
            const double swap = A[c * m + j];
            A[c * m + j] = A[best * m + j];
            A[best * m + j] = swap;
        }
        const double inverse = 1 / A[c * m + c];
        for (int i = c + 1; i < m; i++) {
            A[i * m + c] *= inverse;
            for (int j = c + 1; j < m; j++) A[i * m + j] -= A[i * m + c] * A[c * m + j];
        }
    }
    return sign;
}

static void factors_are_those_of_the_textbook(void **state)
{
    (void)state;
    for (int m = 1; m < 100; m += 1 + m / 8) {
        double A[m * m], B[m * m];
        fill(m * m, A);
        memcpy(B, A, sizeof B);
        assert_int_equal(ric_dense_factor(m, A), eliminated(m, B));
        assert_memory_equal(A, B, sizeof B);
    }
    /* what has no inverse has a zero on its diagonal */
    double A[9] = {1, 2, 3, 2, 4, 6, 0, 1, 1};
    ric_dense_factor(3, A);
    assert_true(A[8] == 0);
}

static void products_are_those_of_the_textbook(void **state)
{
    (void)state;
    for (int m = 1; m < 40; m++) {
        double B[m * m], C[m * m], A[m * m], other[m * m];
        fill(m * m, B);
        fill(m * m, C);
        fill(m * m, A);
        memcpy(other, A, sizeof A);
        ric_dense_add_transposed(m, B, C, A);
        for (int l = 0; l < m; l++)
            for (int i = 0; i < m; i++)
                for (int j = 0; j < m; j++) other[i * m + j] += B[l * m + i] * C[l * m + j];
        assert_memory_equal(A, other, sizeof A);
    }
}

static void conditions_have_no_size(void **state)
{
    (void)state;
    enum { M = 12 };
    for (int exponent = -900; exponent <= 900; exponent += 900) {
        double A[M * M], values[2 * M], large[2 * M], condition[M], same[M];
        fill(M * M, A);
        assert_true(ric_eigen_conditions(M, A, values, condition));
        for (int i = 0; i < M * M; i++) A[i] = ldexp(A[i], exponent);
        assert_true(ric_eigen_conditions(M, A, large, same));
        for (int i = 0; i < M; i++) {
            assert_true(fabs(same[i] / condition[i] - 1) < 1e-9 && condition[i] > 1 - 1e-12);
            for (int j = 2 * i; j < 2 * i + 2; j++)
                assert_true(fabs(ldexp(large[j], -exponent) - values[j]) < 1e-12 * condition[i]);
        }
    }
    const double nan[4] = {1, NAN, 0, 1};
    double values[4], condition[2];
    assert_false(ric_eigen_conditions(2, nan, values, condition));
}

/* What one scale of unknowns makes of a matrix is taken back by balancing, and nothing of a
 * symmetric one. */
static void scales_are_seen(void **state)
{
    (void)state;
    enum { M = 9 };
    double A[M * M], work[M * M];
    fill(M * M, A);
    for (int i = 0; i < M; i++)
        for (int j = 0; j < i; j++) A[i * M + j] = A[j * M + i];
    assert_true(ric_eigen_balanced(M, A, work));
    for (int i = 0; i < M; i++) {
        A[i * M] *= 64;
        A[i] /= 64;
    }
    assert_false(ric_eigen_balanced(M, A, work));
    for (int i = 0; i < M; i++) {
        A[i * M] /= 32;
        A[i] *= 32;
    }
    assert_true(ric_eigen_balanced(M, A, work));
    A[3] = NAN;
    assert_false(ric_eigen_balanced(M, A, work));
}

/* --------------------------------------------------------------- a row of masses */

/* Rows of a matrix of a study: 2 and 1.2 on the diagonal in turn, -1 beside it; or masses. */
static void write_matrix(int n, bool masses, size_t size, char *out)
{
    size_t used = 0;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            const double diagonal = masses ? 1 + 0.1 * ((3 * i) % 7) : i % 3 ? 2 : 2.3;
            used += (size_t)snprintf(out + used, size - used, "%s%g%s",
                                     j   ? ", "
                                     : i ? ", ["
                                         : "[[",
                                     i == j                       ? diagonal
                                     : !masses && abs(i - j) == 1 ? -1
                                                                  : 0,
                                     j + 1 < n   ? ""
                                     : i + 1 < n ? "]"
                                                 : "]]");
            assert_true(used < size);
        }
}

/* n masses between walls, the last one between two stops. */
static ric_graph *row(int n, const char *explore, ric_study **study)
{
    char mass[3000], stiffness[3000], normal[100] = "[", text[8000];
    write_matrix(n, true, sizeof mass, mass);
    write_matrix(n, false, sizeof stiffness, stiffness);
    for (int i = 0; i < n; i++) strcat(normal, i + 1 < n ? "0, " : "1]");
    const int used =
        snprintf(text, sizeof text,
                 "model:\n  mass: %s\n  stiffness: %s\n  contacts:\n    - {normal: %s, law: rigid, "
                 "clearance: 1, sides: both}\nexplore: {%s}\n",
                 mass, stiffness, normal, explore);
    assert_true(used < (int)sizeof text);
    if (ric_study_parse(text, "test", ".", study)) fail_msg("%s\n%s", ric_detail(), text);
    return explored_graph(*study);
}

static bool same(const ric_floquet *a, const ric_floquet *b)
{
    const size_t k = (size_t)a->n_pair;
    return !memcmp(a->rho, b->rho, 2 * k * sizeof *a->rho) &&
           !memcmp(a->own, b->own, 2 * k * sizeof *a->own) &&
           !memcmp(a->each, b->each, k * sizeof *a->each) && a->stable == b->stable &&
           a->error == b->error && a->rough == b->rough && a->det_a == b->det_a &&
           a->det_b == b->det_b && a->det_d == b->det_d && a->error_d == b->error_d;
}

/* The same of a chain at u by one that has said nothing before. */
static void check_again(ric_shooting *c, const double *u, const double *other, ric_floquet *f)
{
    ric_floquet fresh = multipliers(c, u);
    assert_int_equal(ric_floquet_compute(c, f), RIC_OK);
    assert_true(same(f, &fresh));
    ric_shooting_evaluate(c, other);
    assert_false(ric_floquet_again_find(f->again, c, f));
    assert_int_equal(ric_floquet_compute(c, f), RIC_OK);
    ric_shooting_evaluate(c, u);
    memset(f->own, 0, 2 * (size_t)f->n_pair * sizeof *f->own);
    assert_true(ric_floquet_again_find(f->again, c, f));
    assert_true(same(f, &fresh));
    /* to another accuracy it is another answer */
    f->enough = 1e-3;
    assert_false(ric_floquet_again_find(f->again, c, f));
    f->enough = 0;
    ric_floquet_release(&fresh);
}

/* Of less all that is asked for is the same, to rounding. */
static void check_coarse(ric_shooting *c, const double *u, ric_floquet *f)
{
    ric_floquet all = multipliers(c, u);
    int lost = 0;
    f->coarse = true;
    assert_int_equal(ric_floquet_compute(c, f), RIC_OK);
    f->coarse = false;
    for (int i = 0; i < f->n_pair; i++) {
        double off = HUGE_VAL;
        for (int j = 0; j < f->n_pair; j++) {
            const double distance = hypot(f->own[2 * j] - all.own[2 * i],
                                          f->own[2 * j + 1] - all.own[2 * i + 1]);
            lost += i == 0 && isnan(f->own[2 * j]);
            if (distance < off) off = distance;
        }
        if (isnan(all.own[2 * i])) lost--;
        else assert_true(off <= all.each[i]);
    }
    assert_int_equal(lost, 0);
    ric_floquet_release(&all);
}

static void every_answer_stays(void **state)
{
    (void)state;
    ric_study *study;
    ric_graph *graph = row(7,
                           "start: [1, 2], energy: [0, 4], frequency: [0.1, 4], impacts: 4, "
                           "multiply: 1, depth: 2",
                           &study);
    int general = 0, reversible = 0;
    for (int e = 0; e < graph->n_edge; e++) {
        const ric_continuation *trace = graph->edges[e].trace;
        ric_shooting *c = trace->chain;
        ric_floquet f;
        assert_int_equal(ric_floquet_create(c->n, &f), RIC_OK);
        for (int i = 1; i < trace->n_point - 1; i += 5) {
            const double *u = trace->points + (size_t)i * trace->stride +
                              sizeof(ric_point) / sizeof(double);
            check_again(c, u, u + trace->stride, &f);
            check_coarse(c, u, &f);
            *(c->start == RIC_MIRROR_NONE ? &general : &reversible) += 1;
        }
        ric_floquet_release(&f);
    }
    assert_true(reversible > 20);
    print_message("# %d points with mirrors, %d without\n", reversible, general);
    ric_graph_free(graph);
    ric_study_free(study);
}

/* Where there are too many pairs to bring each to more digits, the answer is the one that there
 * was.
 */
static void more_digits_are_asked_for_in_vain(void **state)
{
    static const int modes[] = {7, 18};
    (void)state;
    for (int i = 0; i < 2; i++) {
        ric_study *study;
        ric_graph *graph = row(modes[i],
                               "start: [2, 3], energy: [0, 20], frequency: [0.01, 4], impacts: 2, "
                               "multiply: 1, depth: 1",
                               &study);
        assert_true(graph->n_edge > 0);
        const ric_continuation *trace = graph->edges[0].trace;
        assert_true(trace->n_point > 2);
        const double *u = trace->points + trace->stride + sizeof(ric_point) / sizeof(double);
        ric_floquet f = multipliers(trace->chain, u), fresh;
        assert_int_equal(ric_floquet_create(modes[i], &fresh), RIC_OK);
        assert_int_equal(ric_floquet_compute(trace->chain, &f), RIC_OK);
        f.sharp = fresh.sharp = 1e-10;
        assert_int_equal(ric_floquet_again_find(f.again, trace->chain, &f), i == 1);
        assert_int_equal(ric_floquet_compute(trace->chain, &f), RIC_OK);
        assert_int_equal(ric_floquet_compute(trace->chain, &fresh), RIC_OK);
        assert_true(f.sharp > 0);
        assert_true(same(&f, &fresh));
        ric_floquet_release(&f);
        ric_floquet_release(&fresh);
        ric_graph_free(graph);
        ric_study_free(study);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(factors_are_those_of_the_textbook),
                                       cmocka_unit_test(products_are_those_of_the_textbook),
                                       cmocka_unit_test(conditions_have_no_size),
                                       cmocka_unit_test(scales_are_seen),
                                       cmocka_unit_test(every_answer_stays),
                                       cmocka_unit_test(more_digits_are_asked_for_in_vain)};
    return cmocka_run_group_tests_name("many modes", tests, NULL, NULL);
}
