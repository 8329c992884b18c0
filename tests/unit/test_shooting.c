/* The orbit problem: its Jacobian against differences, its structured solve against a dense one,
 * its cost, its residual. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <cmocka.h>
#include <lapacke.h>

#include "explore/graph.h"
#include "random_orbits.h"
#include "sample.h"

enum { MAX_N = 6, MAX_CONTACT = 3, MAX_FLIGHT = 12, MAX_SIZE = 2 * MAX_N + MAX_FLIGHT + 1 };

/* ------------------------------------------------------------------ helpers */

static ric_shooting *random_chain(const ric_model *m, int form, int n_flight, double *u)
{
    int *face = malloc(((size_t)n_flight + 1) * sizeof *face);
    assert_non_null(face);
    random_word(m, form, n_flight, face);
    ric_shooting *chain = random_chain_over(m, form, n_flight, face, 1, u);
    free(face);
    return chain;
}

static double largest(int n, const double *x)
{
    double top = 0;
    for (int i = 0; i < n; i++) top = fmax(top, fabs(x[i]));
    return top;
}

/* What runs over random chains of every form: n = 1..6, one to three contacts, with and without a
 * zero frequency. */
typedef void check_chain(ric_shooting *chain, const double *u, const char *where);

static void over_random_chains(check_chain *check)
{
    double u[MAX_SIZE];
    for (int n = 1; n <= MAX_N; n++)
        for (int form = 0; form < N_FORM; form++)
            for (int trial = 0; trial < 6; trial += every()) {
                uint64_t seed = 10000u * (uint64_t)n + 100u * (uint64_t)form + (uint64_t)trial;
                char where[80];
                ric_model *m = random_structure_of(seed, n, 1 + trial % MAX_CONTACT,
                                                   n > 1 && trial % 4 == 3, false);
                ric_shooting *chain = random_chain(m, form, 1 + below(MAX_FLIGHT), u);
                snprintf(where, sizeof where, "seed %llu, n = %d, form %d, %d flights",
                         (unsigned long long)seed, n, form, chain->n_flight);
                check(chain, u, where);
                ric_shooting_free(chain);
                ric_model_free(m);
            }
}

/* ----------------------------------------------------------------- Jacobian */

/* Central differences of fourth order: error (h omega)^4, rounding eps / h. */
static void check_jacobian(ric_shooting *chain, const double *u, const char *where)
{
    static const double weight[4] = {1.0 / 12, -2.0 / 3, 2.0 / 3, -1.0 / 12},
                        offset[4] = {-2, -1, 1, 2};
    double J[MAX_SIZE * MAX_SIZE], moved[MAX_SIZE], r[4][MAX_SIZE];
    double fastest = chain->model->omega[chain->n - 1], h = 1e-3 / fmax(fastest, 1);
    int unknowns = chain->n_unknown, rows = ric_shooting_jacobian(chain, u, J);
    double top = largest(rows * unknowns, J);
    for (int j = 0; j < unknowns; j++) {
        for (int k = 0; k < 4; k++) {
            memcpy(moved, u, (size_t)unknowns * sizeof *u);
            moved[j] += offset[k] * h;
            assert_int_equal(ric_shooting_residuals(chain, moved, r[k]), rows);
        }
        for (int i = 0; i < rows; i++) {
            double difference = 0;
            for (int k = 0; k < 4; k++) difference += weight[k] * r[k][i] / h;
            if (!(fabs(difference - J[i * unknowns + j]) <= 1e-9 * (1 + top)))
                fail_msg("%s: row %d, column %d: %.12g against %.12g by differences (largest entry "
                         "%.3g)",
                         where, i, j, J[i * unknowns + j], difference, top);
        }
    }
}

static void jacobian_by_differences(void **state)
{
    (void)state;
    over_random_chains(check_jacobian);
}

/* ------------------------------------------------------------ lanes of two modes */

static void assert_bits(int n, const double *a, const double *b, const char *what,
                        const char *where)
{
    for (int i = 0; i < n; i++)
        if (memcmp(&a[i], &b[i], sizeof *a))
            fail_msg("%s: entry %d of %s is %.17g with lanes and %.17g without", where, i, what,
                     a[i], b[i]);
}

/* Step and kernel side by side, and the code of their own that two modes with rigid contacts have,
 * give the same bits. */
static void check_lanes(ric_shooting *chain, const double *u, const char *where)
{
    const int n = chain->n, flights = chain->n_flight;
    double left[1 + MAX_FLIGHT + 4], du[2][MAX_SIZE], plane[2][2 * MAX_SIZE], second[2];
    ric_shooting_evaluate(chain, u);
    ric_shooting_steps(chain, plane[0], plane[1]);
    for (int newton = 0; newton < 2; newton++) {
        ric_shooting_step(chain, newton, newton ? 0 : 1, du[0]);
        assert_bits(chain->n_unknown, plane[!newton], du[0], newton ? "step" : "kernel", where);
    }
    if (n != 2) return;
    ric_shooting *plain = ric_shooting_copy(chain);
    assert_non_null(plain);
    assert_false(chain->plain);
    plain->plain = true;
    for (int i = 0; i < 1 + flights + 4; i++) left[i] = uniform(-1, 1);
    for (int known = 0; known < 2; known++) {
        ric_shooting_evaluate_left(chain, u, known ? left : NULL);
        ric_shooting_evaluate_left(plain, u, known ? left : NULL);
        assert_bits((flights + 1) * 2 * n, chain->w, plain->w, "states", where);
        assert_bits(flights * n, chain->before, plain->before, "velocities", where);
        assert_bits(flights * 3 * n, chain->map, plain->map, "turns", where);
        for (int k = 0; k < flights; k++)
            if (chain->face[k + 1] >= 0)
                assert_bits(1, chain->approach + k + 1, plain->approach + k + 1, "speeds", where);
        for (int newton = 0; newton < 2; newton++) {
            ric_shooting_step(chain, newton, 0.3, du[0]);
            ric_shooting_step(plain, newton, 0.3, du[1]);
            assert_bits(chain->n_unknown, du[0], du[1], newton ? "step" : "kernel", where);
        }
        assert_true(ric_shooting_plane(chain, plane[0], &second[0]));
        assert_true(ric_shooting_plane(plain, plane[1], &second[1]));
        assert_bits(2 * chain->n_unknown, plane[0], plane[1], "plane", where);
        assert_bits(1, &chain->end_det, &plain->end_det, "determinant", where);
        assert_bits(1, &chain->smallest, &plain->smallest, "least pivot", where);
        assert_bits(1, &chain->residual, &plain->residual, "residual", where);
    }
    ric_shooting_free(plain);
}

static void lanes_have_the_same_bits(void **state)
{
    (void)state;
    over_random_chains(check_lanes);
}

/* --------------------------------------------------- structured and dense LQ */

/* The equations that the structured solve sees: closure rows taken perpendicular to h = w_N + sigma
 * w_0 (without the positions of zero modes), to which the closure is perpendicular for any u. A
 * [rows * unknowns], r [rows]. */
static int dense_equations(ric_shooting *chain, const double *u, double *A, double *r)
{
    double J[MAX_SIZE * MAX_SIZE], all[MAX_SIZE], h[2 * MAX_N], E[4 * MAX_N * MAX_N];
    int unknowns = chain->n_unknown, n = chain->n, rows = ric_shooting_jacobian(chain, u, J);
    ric_shooting_residuals(chain, u, all);
    if (chain->start != RIC_MIRROR_NONE) {
        memcpy(A, J, (size_t)(rows * unknowns) * sizeof *A);
        memcpy(r, all, (size_t)rows * sizeof *r);
        return rows;
    }
    int gaps = rows - 2 * n;
    for (int i = 0; i < 2 * n; i++) {
        bool zero = i < n && chain->model->omega[i] == 0;
        h[i] = zero ? 0 : chain->w[2 * n * chain->n_flight + i] + chain->sigma * chain->w[i];
    }
    ric_model_complement(2 * n, h, E);
    memcpy(A, J, (size_t)(gaps * unknowns) * sizeof *A);
    memcpy(r, all, (size_t)gaps * sizeof *r);
    double along = 0;
    for (int i = 0; i < 2 * n; i++) along += h[i] * all[gaps + i];
    assert_true(fabs(along) <= 1e-13 * (1 + largest(2 * n, h) * largest(2 * n, h)) * 4 * n);
    for (int i = 0; i < 2 * n - 1; i++) {
        r[gaps + i] = 0;
        for (int k = 0; k < 2 * n; k++) r[gaps + i] += E[i * 2 * n + k] * all[gaps + k];
        for (int j = 0; j < unknowns; j++) {
            double sum = 0;
            for (int k = 0; k < 2 * n; k++) sum += E[i * 2 * n + k] * J[(gaps + k) * unknowns + j];
            A[(gaps + i) * unknowns + j] = sum;
        }
    }
    return rows - 1;
}

static double distance(int n, const double *a, const double *b, double sign)
{
    double sum = 0;
    for (int i = 0; i < n; i++) sum += (a[i] - sign * b[i]) * (a[i] - sign * b[i]);
    return sqrt(sum);
}

static int ill_conditioned, compared;

static void check_step(ric_shooting *chain, const double *u, const char *where)
{
    double A[MAX_SIZE * MAX_SIZE], copy[MAX_SIZE * MAX_SIZE], b[MAX_SIZE] = {0}, r[MAX_SIZE],
                                                              sv[MAX_SIZE], V[MAX_SIZE * MAX_SIZE];
    double newton[MAX_SIZE], kernel[MAX_SIZE], both[MAX_SIZE], super[MAX_SIZE], one[1];
    int unknowns = chain->n_unknown, rows = dense_equations(chain, u, A, r);
    assert_int_equal(rows, unknowns - 1);
    lapack_int rank;
    for (int i = 0; i < rows; i++) b[i] = -r[i];
    memcpy(copy, A, (size_t)(rows * unknowns) * sizeof *A);
    assert_int_equal(LAPACKE_dgelsd(LAPACK_ROW_MAJOR, rows, unknowns, 1, copy, unknowns, b, 1, sv,
                                    1e-14, &rank),
                     0);
    memcpy(copy, A, (size_t)(rows * unknowns) * sizeof *A);
    assert_int_equal(LAPACKE_dgesvd(LAPACK_ROW_MAJOR, 'N', 'A', rows, unknowns, copy, unknowns, sv,
                                    one, 1, V, unknowns, super),
                     0);
    double condition = sv[0] / sv[rows - 1], tolerance = 1e-10 * fmax(1, condition / 1e4);
    const double *z = V + rows * unknowns;

    ric_shooting_evaluate(chain, u);
    ric_shooting_step(chain, true, 0, newton);
    ric_shooting_step(chain, false, 1, kernel);
    ric_shooting_step(chain, true, 0.7, both);
    if (condition > 1e8) {
        ill_conditioned++;
        return;
    }
    compared++;
    double inner = 0, size = 0, norm = 0;
    for (int i = 0; i < unknowns; i++) {
        inner += z[i] * kernel[i];
        size += b[i] * b[i];
        norm += kernel[i] * kernel[i];
    }
    if (!(distance(unknowns, newton, b, 1) <= tolerance * sqrt(size)))
        fail_msg("%s: step off by %.3g of %.3g, condition %.3g", where,
                 distance(unknowns, newton, b, 1), sqrt(size), condition);
    if (!(distance(unknowns, kernel, z, inner < 0 ? -1 : 1) <= tolerance) ||
        fabs(norm - 1) > 1e-13 * unknowns)
        fail_msg("%s: kernel off by %.3g, norm %.17g, condition %.3g", where,
                 distance(unknowns, kernel, z, inner < 0 ? -1 : 1), sqrt(norm), condition);
    for (int i = 0; i < unknowns; i++) newton[i] += 0.7 * kernel[i];
    assert_true(distance(unknowns, both, newton, 1) <=
                1e-13 * (1 + sqrt(size)) * fmax(1, condition));
}

static void step_against_dense(void **state)
{
    (void)state;
    ill_conditioned = compared = 0;
    over_random_chains(check_step);
    print_message("# %d chains compared, %d with a condition beyond 1e8\n", compared,
                  ill_conditioned);
    assert_true(ill_conditioned * 10 < compared);
}

/* Sign of det [A; kernel]. */
static double bordered_sign(ric_shooting *chain, const double *u)
{
    double A[MAX_SIZE * MAX_SIZE], r[MAX_SIZE], sign = 1;
    int unknowns = chain->n_unknown, rows = dense_equations(chain, u, A, r);
    lapack_int pivot[MAX_SIZE];
    ric_shooting_evaluate(chain, u);
    ric_shooting_step(chain, false, 1, A + rows * unknowns);
    LAPACKE_dgetrf(LAPACK_ROW_MAJOR, unknowns, unknowns, A, unknowns, pivot);
    for (int i = 0; i < unknowns; i++)
        sign *= (A[i * unknowns + i] < 0 ? -1 : 1) * (pivot[i] == i + 1 ? 1 : -1);
    return sign;
}

/* end_det may have any sign that is the same wherever the chain is evaluated. */
static void check_determinant(ric_shooting *chain, const double *u, const char *where)
{
    double v[MAX_SIZE], first = 0;
    for (int i = 0; i < 20; i++) {
        for (int j = 0; j < chain->n_unknown; j++)
            v[j] = j < chain->n_start ? uniform(-1, 1) : u[j] + uniform(-0.3, 0.6);
        double sign = bordered_sign(chain, v) * (chain->end_det < 0 ? -1 : 1);
        if (first == 0) first = sign;
        if (sign != first)
            fail_msg("%s: the sign of the bordered determinant does not follow (sample %d)", where,
                     i);
    }
}

/* The least singular value of the end rows and what bounds it from below. */
static void check_least(ric_shooting *chain, const double *u, const char *where)
{
    double plane[2 * MAX_SIZE], second;
    if (chain->n_end == 0) return; /* one mode, which ends at an impact */
    ric_shooting_evaluate(chain, u);
    assert_true(ric_shooting_plane(chain, plane, &second));
    double least = ric_shooting_least(chain);
    if (!(least <= second * (1 + 1e-6) && second <= least * sqrt(chain->n_end) * (1 + 1e-6)))
        fail_msg("%s: %.17g bounds %.17g", where, least, second);
}

static void least_value_is_bounded(void **state)
{
    (void)state;
    over_random_chains(check_least);
}

static void determinant_sign(void **state)
{
    (void)state;
    over_random_chains(check_determinant);
}

/* ------------------------------------------------------------ closed forms */

/* Time, energy and slope along any direction against their definitions. */
static void check_scalars(ric_shooting *chain, const double *u, const char *where)
{
    double du[MAX_SIZE], v[MAX_SIZE], h = 1e-4, sum = 0;
    int unknowns = chain->n_unknown, n = chain->n;
    for (int i = 0; i < unknowns; i++) du[i] = uniform(-1, 1);
    double energy[2];
    for (int side = 0; side < 2; side++) {
        for (int i = 0; i < unknowns; i++) v[i] = u[i] + (side ? h : -h) * du[i];
        ric_shooting_fly(chain, v);
        energy[side] = ric_shooting_energy(chain);
    }
    ric_shooting_fly(chain, u);
    double slope = ric_shooting_energy_slope(chain, du); /* E is a quadratic form of the start
                                                            block: central differences are exact */
    if (fabs(slope - (energy[1] - energy[0]) / (2 * h)) > 1e-10 * (1 + fabs(energy[0])))
        fail_msg("%s: dE %.12g against %.12g", where, slope, (energy[1] - energy[0]) / (2 * h));
    for (int i = 0; i < n; i++) {
        double a = chain->model->omega[i] > 0 ? chain->w[i] : 0, p = chain->w[n + i];
        sum += (a * a + p * p) / 2;
    }
    assert_true(fabs(sum - ric_shooting_energy(chain)) <= 1e-14 * (1 + sum) * n);
    for (int k = 0; k < chain->n_flight; k++) { /* conserved by every flight and impact */
        double now = 0;
        for (int i = 0; i < n; i++) {
            const double *w = chain->w + 2 * n * (k + 1);
            double a = chain->model->omega[i] > 0 ? w[i] : 0;
            now += (a * a + w[n + i] * w[n + i]) / 2;
        }
        if (fabs(now - sum) > 1e-13 * (1 + sum) * (k + 1))
            fail_msg("%s: energy %.15g after flight %d, %.15g before", where, now, k, sum);
    }
    double time = 0;
    for (int i = chain->n_start; i < unknowns; i++) time += u[i];
    assert_true(fabs(chain->multiple * time - ric_shooting_time(chain, u)) <=
                1e-14 * 4 * time * chain->n_flight);
}

static void scalars(void **state)
{
    (void)state;
    over_random_chains(check_scalars);
}

/* --------------------------------------------------------------------- cost */

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Seconds of one Newton iteration: the fastest of many. */
static double time_iteration(const ric_model *m, int form, int n_flight)
{
    double *u = calloc((size_t)n_flight + 2 * MAX_N + 1, sizeof *u),
           *du = calloc((size_t)n_flight + 2 * MAX_N + 1, sizeof *du), best = HUGE_VAL;
    assert_non_null(u);
    assert_non_null(du);
    ric_shooting *chain = random_chain(m, form, n_flight, u);
    for (int i = 0; i < 30; i++) {
        int repeat = 4096 / n_flight;
        double start = seconds();
        for (int k = 0; k < repeat; k++) {
            ric_shooting_evaluate(chain, u);
            ric_shooting_step(chain, true, 0, du);
        }
        best = fmin(best, (seconds() - start) / repeat);
    }
    ric_shooting_free(chain);
    free(u);
    free(du);
    return best;
}

/* What a flight and an impact are carried and reduced in has the same size however many there are
 * of them. */
static void work_is_linear(void **state)
{
    (void)state;
    enum { SHORT = 64, LONG = 1024 };
    double u[LONG + 2 * MAX_N + 1];
    for (int n = 2; n <= MAX_N; n += 4)
        for (int form = 0; form < 4; form++) {
            ric_model *m = random_structure_of(7, n, 2, false, false);
            ric_shooting *a = random_chain(m, form, SHORT, u), *b = random_chain(m, form, LONG, u);
            assert_int_equal(b->n_flight, LONG);
            assert_int_equal(a->ld, b->ld);
            assert_int_equal(a->stride, b->stride);
            assert_int_equal(a->n_end, b->n_end);
            assert_true(b->ld <= 2 * n + 1 && b->stride <= 3 * (size_t)n);
            ric_shooting_free(a);
            ric_shooting_free(b);
            ric_model_free(m);
        }
}

/* How the time grows is measured where nothing else runs: `make time`. */
static void cost_is_linear(void **state)
{
    (void)state;
    if (!getenv("RICOCHET_TEST_TIME")) skip();
    for (int n = 2; n <= MAX_N; n += 4)
        for (int form = 0; form < 4; form += 3) {
            ric_model *m = random_structure_of(7, n, 2, false, false);
            double exponent = log(time_iteration(m, form, 1024) / time_iteration(m, form, 64)) /
                              log(16);
            print_message("# n = %d, form %d: cost grows as N^%.2f\n", n, form, exponent);
            assert_true(exponent > 0.7 && exponent < 1.3);
            ric_model_free(m);
        }
}

/* ----------------------------------------------------------------- residual */

/* Largest residual of a fresh flight from the start block, relative to 1 + |w|: gaps and end
 * conditions. */
static double residual_at(ric_shooting *chain, const double *u)
{
    double *r = calloc((size_t)chain->n_unknown + 1, sizeof *r), size = 0;
    assert_non_null(r);
    int rows = ric_shooting_residuals(chain, u, r);
    for (int i = 0; i < 2 * chain->n; i++) size += chain->w[i] * chain->w[i];
    double worst = largest(rows, r) / (1 + sqrt(size));
    free(r);
    return worst;
}

/* Every stored point of an atlas of the article's model solves its problem to rounding. */
static void residual_of_points(void **state)
{
    (void)state;
    ric_study *study = NULL;
    ric_graph *graph = NULL;
    int points = 0;
    assert_int_equal(ric_study_read("examples/elementary/study.yaml", &study), RIC_OK);
    assert_int_equal(ric_graph_create(study, NULL, &graph), RIC_OK);
    assert_int_equal(ric_graph_explore(graph, NULL), RIC_OK);
    for (int e = 0; e < graph->n_edge; e++) {
        ric_continuation *trace = graph->edges[e].trace;
        if (!trace || !trace->chain) continue;
        double tolerance = ric_continuation_tolerance(trace->chain);
        for (int i = 0; i < trace->n_point; i++, points++) {
            const double *row = trace->points + (size_t)i * trace->stride,
                         *u = row + sizeof(ric_point) / sizeof(double);
            double again = residual_at(trace->chain, u);
            if (!(again <= tolerance))
                fail_msg("branch %d, point %d: residual %.3g above %.3g", e, i, again, tolerance);
            assert_true(((const ric_point *)row)->residual <= tolerance * (1 + 1e-6));
        }
    }
    print_message("# %d points\n", points);
    assert_true(points > 100);
    ric_graph_free(graph);
    ric_study_free(study);
}

/* The same chain with every flight as a matrix: springs of no stiffness change nothing but the path
 * through the code. */
static void check_dense(ric_shooting *chain, const double *u, const char *where)
{
    ric_model soft = *chain->model;
    double springs[MAX_CONTACT] = {0}, step[MAX_SIZE], dense_step[MAX_SIZE], kernel[MAX_SIZE],
           dense_kernel[MAX_SIZE];
    soft.law = RIC_LAW_POWER;
    soft.spring = springs;
    ric_shooting *dense = NULL;
    assert_int_equal(ric_shooting_create(&soft, chain->start, chain->end, chain->sigma,
                                         chain->n_flight, chain->face, &dense),
                     RIC_OK);
    ric_shooting_evaluate(chain, u);
    ric_shooting_evaluate(dense, u);
    ric_shooting_step(chain, true, 0, step);
    ric_shooting_step(dense, true, 0, dense_step);
    ric_shooting_step(chain, false, 1, kernel);
    ric_shooting_step(dense, false, 1, dense_kernel);
    double size = 1 + largest(chain->n_unknown, step), rounding = 1e-12 / fmin(1, chain->smallest);
    if (!(distance(chain->n_unknown, step, dense_step, 1) <= rounding * size))
        fail_msg("%s: steps differ", where);
    if (!(fmin(distance(chain->n_unknown, kernel, dense_kernel, 1),
               distance(chain->n_unknown, kernel, dense_kernel, -1)) <= rounding))
        fail_msg("%s: kernels differ", where);
    assert_true(fabs(chain->residual - dense->residual) <= 1e-13);
    ric_shooting_free(dense);
}

static void matrices_of_flights(void **state)
{
    (void)state;
    over_random_chains(check_dense);
}

/* Newton from a disturbed orbit, in either form, ends at rounding level. S2[01] in closed form:
 * centre to impact over a quarter, a velocity and one flight; the same orbit in the general form
 * over the half and the whole period. */
static void residual_of_corrected(void **state)
{
    (void)state;
    int tried = 0;
    for (uint64_t seed = 1; seed <= 60; seed += (uint64_t)every()) {
        int n = 1 + (int)(seed % MAX_N);
        ric_model *m = random_structure_of(seed, n, 1, false, false);
        double tau = uniform(0.2, 0.9) * 1.5707963267948966 / m->omega[n - 1], sum = 0, u[MAX_SIZE],
               v[MAX_SIZE], du[MAX_SIZE];
        /* p_i = J c_i / (2 cos(omega_i tau)) at the centre: the impact takes it to its image; s =
         * sum c_i p_i tan / omega = gap */
        int faces[3] = {-1, 0, -1}, iterations;
        for (int i = 0; i < n; i++) sum += m->c[i] * m->c[i] * tan(m->omega[i] * tau) / m->omega[i];
        for (int i = 0; i < n; i++) u[i] = m->face[0].gap / sum * m->c[i] / cos(m->omega[i] * tau);
        u[n] = tau;
        ric_shooting *chain = NULL;
        assert_int_equal(ric_shooting_create(m, RIC_MIRROR_CENTRE, RIC_MIRROR_IMPACT, 1, 1, faces,
                                             &chain),
                         RIC_OK);
        ric_shooting_evaluate(chain, u);
        if (!(chain->residual <= 1e-13))
            fail_msg("seed %llu: closed form has residual %.3g", (unsigned long long)seed,
                     chain->residual);
        for (int i = 0; i <= n; i++) v[i] = u[i] * (1 + uniform(-1e-5, 1e-5));
        assert_true(ric_continuation_correct(chain, v, NULL, NULL, 0, du, &iterations));
        if (!(chain->residual <= ric_continuation_tolerance(chain)))
            fail_msg("seed %llu: residual %.3g", (unsigned long long)seed, chain->residual);
        tried++;
        for (int sigma = -1; sigma <= 1; sigma += 2) {
            int flights = sigma < 0 ? 1 : 2, word[3] = {0, 1, 0};
            double start[MAX_SIZE];
            ric_shooting *whole = NULL;
            assert_int_equal(ric_shooting_create(m, RIC_MIRROR_NONE, RIC_MIRROR_NONE, sigma,
                                                 flights, word, &whole),
                             RIC_OK);
            for (int i = 0; i < n; i++) {
                start[i] = chain->w[2 * n + i];
                start[n + i] = -chain->before[i];
            }
            for (int i = 0; i < flights; i++) start[2 * n + i] = 2 * v[n];
            for (int i = 0; i < whole->n_unknown; i++) start[i] *= 1 + uniform(-1e-6, 1e-6);
            assert_true(ric_continuation_correct(whole, start, NULL, NULL, 0, du, &iterations));
            if (!(whole->residual <= ric_continuation_tolerance(whole)) ||
                !(residual_at(whole, start) <= 2 * ric_continuation_tolerance(whole)))
                fail_msg("seed %llu, sigma %d: residual %.3g", (unsigned long long)seed, sigma,
                         whole->residual);
            ric_shooting_free(whole);
        }
        ric_shooting_free(chain);
        ric_model_free(m);
    }
    assert_int_equal(tried, 60);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lanes_have_the_same_bits),
        cmocka_unit_test(jacobian_by_differences),
        cmocka_unit_test(step_against_dense),
        cmocka_unit_test(determinant_sign),
        cmocka_unit_test(scalars),
        cmocka_unit_test(work_is_linear),
        cmocka_unit_test(cost_is_linear),
        cmocka_unit_test(residual_of_points),
        cmocka_unit_test(residual_of_corrected),
        cmocka_unit_test(matrices_of_flights),
        cmocka_unit_test(least_value_is_bounded),
    };
    return cmocka_run_group_tests_name("chain", tests, NULL, NULL);
}
