/* The smooth flow of law power: against CVODE, invariants, neighbours by differences and in two
 * ways. */
#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "flow/flight.h"
#include "random_models.h"
#include "flow/power_flow.h"

#include "cvode_flow.h"
#include "quad_flow.h"
#include "sample.h"

enum { MOST = 6, CONTACTS = 3 };

typedef struct {
    int n, n_contact;
    double M[MOST * MOST], K[MOST * MOST], normal[CONTACTS * MOST];
    ric_contact contacts[CONTACTS];
    ric_model *model;
    double *work;
} structure;

static void create(structure *s)
{
    if (ric_model_create(s->n, s->M, s->K, s->n_contact, s->contacts, 1, &s->model))
        fail_msg("%s", ric_detail());
    assert_int_equal(s->model->n, s->n);
    s->work = calloc(ric_power_flow_work(s->model, 2 * s->n), sizeof *s->work);
    assert_non_null(s->work);
}

static void release(structure *s)
{
    ric_model_free(s->model);
    free(s->work);
}

/* Exponents as given, cycled through by the contacts. */
static void random_structure(uint64_t seed, int n, int n_contact, const int *exponents,
                             bool floating, structure *s)
{
    seed_now = seed;
    memset(s, 0, sizeof *s);
    s->n = n;
    s->n_contact = n_contact;
    random_definite(n, n, 0.5, s->M);
    random_definite(n, floating ? n - 1 : n, floating ? 0 : 0.3, s->K);
    for (int f = 0; f < n_contact; f++) {
        for (int i = 0; i < n; i++) s->normal[f * n + i] = uniform(-1, 1);
        s->contacts[f] = (ric_contact){.normal = s->normal + f * n,
                                       .law = RIC_LAW_POWER,
                                       .exponent = exponents[f]};
        if (f % 2) s->contacts[f].stiffness = uniform(0.3, 3);
        else {
            s->contacts[f].length = uniform(0.5, 2);
            s->contacts[f].reference = uniform(0.3, 3);
        }
    }
    create(s);
}

/* The two masses of the article, eq. 50. */
static void article(int exponent, structure *s)
{
    static const double M[] = {2, 0, 0, 1}, K[] = {9, -1, -1, 1}, normal[] = {-1, 1};
    memset(s, 0, sizeof *s);
    s->n = 2;
    s->n_contact = 1;
    memcpy(s->M, M, sizeof M);
    memcpy(s->K, K, sizeof K);
    memcpy(s->normal, normal, sizeof normal);
    s->contacts[0] = (ric_contact){.normal = s->normal,
                                   .law = RIC_LAW_POWER,
                                   .exponent = exponent,
                                   .length = 1,
                                   .reference = 1};
    create(s);
}

/* Coordinates up to `size`, less where contacts of high exponent would be pressed beyond reason. */
static void random_state(const structure *s, double size, double *w)
{
    for (int i = 0; i < 2 * s->n; i++) w[i] = uniform(-size, size);
    while (ric_flight_energy(s->model, 0, w) > 30 * s->n)
        for (int i = 0; i < 2 * s->n; i++) w[i] *= 0.9;
}

static double largest(int count, const double *x)
{
    double top = 0;
    for (int i = 0; i < count; i++) top = fmax(top, fabs(x[i]));
    return top;
}

static const int exponents[][CONTACTS] = {{3, 5, 7},
                                          {7, 3, 21},
                                          {21, 9, 3},
                                          {99, 3, 51},
                                          {11, 33, 65}};
enum { N_SET = sizeof exponents / sizeof exponents[0] };

/* ------------------------------------------------------------------- CVODE */

static void follows_cvode(void **state)
{
    (void)state;
    for (int i = 0; i < 30; i++) {
        structure s;
        random_structure((uint64_t)(100 + i), 1 + i % MOST, 1 + i % CONTACTS, exponents[i % N_SET],
                         i % 7 == 6 && i % MOST > 0, &s);
        int n = s.n;
        double w[2 * n], x[n], v[n], y[n], z[n], time = uniform(1, 8);
        random_state(&s, i % 2 ? 0.8 : 2, w);
        ric_model_to_state(s.model, w, x, v);
        double error = cvode_fly(s.model, n, s.M, s.K, s.n_contact, s.contacts, time, x, v),
               size = fmax(largest(n, x), largest(n, v));
        assert_true(ric_power_flow_fly(s.model, time * s.model->omega_ref, w, 0, NULL, s.work));
        ric_model_to_state(s.model, w, y, z);
        for (int j = 0; j < n; j++)
            if (!(fabs(x[j] - y[j]) <= (1e-11 + 10 * error) * size &&
                  fabs(v[j] - z[j]) <= (1e-11 + 10 * error) * size))
                fail_msg("structure %d: x[%d] %.15g %.15g, v %.15g %.15g; CVODE is sure of %g", i,
                         j, x[j], y[j], v[j], z[j], error);
        assert_true(error < 1e-7);
        release(&s);
    }
}

/* -------------------------------------------------------------- invariants */

/* Energy in the raw matrices, to rounding, over several periods; and the way back. */
static void conserves(void **state)
{
    (void)state;
    for (int i = 0; i < 60; i++) {
        structure s;
        random_structure((uint64_t)(200 + i), 1 + i % MOST, 1 + i % CONTACTS, exponents[i % N_SET],
                         i % 5 == 4 && i % MOST > 0, &s);
        int n = s.n;
        double w[2 * n], w0[2 * n], x[n], v[n];
        random_state(&s, i % 2 ? 0.5 : 3, w);
        memcpy(w0, w, sizeof w);
        ric_model_to_state(s.model, w, x, v);
        double E = ric_model_energy(s.model, x, v),
               here = ric_flight_energy(s.model, 0, w) * s.model->energy_unit;
        assert_true(fabs(E - here) <= 1e-13 * E || ric_model_n_mode(s.model) < n);
        assert_true(ric_power_flow_fly(s.model, 10, w, 0, NULL, s.work));
        ric_model_to_state(s.model, w, x, v);
        if (!(fabs(ric_model_energy(s.model, x, v) - E) <= 2e-13 * E))
            fail_msg("structure %d: energy %.17g became %.17g", i, E,
                     ric_model_energy(s.model, x, v));
        double X[4 * n * n];
        memset(X, 0, sizeof X);
        for (int j = 0; j < 2 * n; j++) X[j * 2 * n + j] = 1;
        random_state(&s, 1, w);
        memcpy(w0, w, sizeof w);
        assert_true(ric_power_flow_fly(s.model, 1.3, w, 2 * n, X, s.work));
        assert_true(ric_power_flow_fly(s.model, -1.3, w, 0, NULL, s.work));
        for (int j = 0; j < 2 * n; j++)
            assert_true(fabs(w[j] - w0[j]) <= 1e-13 * largest(4 * n * n, X) * largest(2 * n, w0));
        release(&s);
    }
}

/* Without contact forces (vanishing amplitude) a flight is a rotation. */
static void becomes_linear(void **state)
{
    (void)state;
    structure s;
    random_structure(7, 4, 2, exponents[0], false, &s);
    double w[8], w0[8];
    random_state(&s, 1e-9, w);
    memcpy(w0, w, sizeof w);
    assert_true(ric_power_flow_fly(s.model, 5, w, 0, NULL, s.work));
    for (int i = 0; i < 4; i++) {
        double c = cos(5 * s.model->omega[i]), d = sin(5 * s.model->omega[i]);
        assert_true(fabs(w[i] - (c * w0[i] + d * w0[4 + i])) <= 1e-23);
        assert_true(fabs(w[4 + i] - (c * w0[4 + i] - d * w0[i])) <= 1e-23);
    }
    release(&s);
}

/* -------------------------------------------------------------- neighbours */

/* Central differences of sixth order: 1, 2, 3 times the distance. */
static void neighbours_are_derivatives(void **state)
{
    (void)state;
    static const double weight[] = {45.0 / 60, -9.0 / 60, 1.0 / 60};
    for (int i = 0; i < 30; i++) {
        structure s;
        random_structure((uint64_t)(300 + i), 1 + i % MOST, 1 + i % CONTACTS, exponents[i % 3],
                         i % 7 == 6 && i % MOST > 0, &s);
        int n = s.n, ld = 2 * n;
        double w[ld], end[ld], X[ld * ld], tau = uniform(0.5, 3), h = 2e-3;
        random_state(&s, 0.7, w);
        memset(X, 0, sizeof X);
        for (int j = 0; j < ld; j++) X[j * ld + j] = 1;
        memcpy(end, w, sizeof w);
        assert_true(ric_power_flow_fly(s.model, tau, end, ld, X, s.work));
        double size = largest(ld * ld, X);
        for (int j = 0; j < ld; j++) {
            double sum[ld], moved[ld];
            memset(sum, 0, sizeof sum);
            for (int k = 1; k <= 3; k++)
                for (int side = -1; side <= 1; side += 2) {
                    memcpy(moved, w, sizeof moved);
                    moved[j] += side * k * h;
                    assert_true(ric_power_flow_fly(s.model, tau, moved, 0, NULL, s.work));
                    for (int r = 0; r < ld; r++) sum[r] += side * weight[k - 1] * moved[r] / h;
                }
            for (int r = 0; r < ld; r++)
                if (!(fabs(sum[r] - X[r * ld + j]) <= 1e-7 * size))
                    fail_msg("structure %d: entry %d, %d is %.15g, by differences %.15g", i, r, j,
                             X[r * ld + j], sum[r]);
        }
        release(&s);
    }
}

/* In (q, p) the matrix is symplectic, and it maps the flow at the start to that at the end. */
static void neighbours_are_symplectic(void **state)
{
    (void)state;
    for (int i = 0; i < 60; i++) {
        structure s;
        random_structure((uint64_t)(400 + i), 1 + i % MOST, 1 + i % CONTACTS, exponents[i % N_SET],
                         i % 7 == 6 && i % MOST > 0, &s);
        int n = s.n, ld = 2 * n;
        double w[ld], X[ld * ld], f0[ld], f1[ld], *kappa = s.model->kappa;
        random_state(&s, 1, w);
        memset(X, 0, sizeof X);
        for (int j = 0; j < ld; j++) X[j * ld + j] = 1;
        ric_flight_rate(s.model, 0, w, f0);
        assert_true(ric_power_flow_fly(s.model, 4, w, ld, X, s.work));
        ric_flight_rate(s.model, 0, w, f1);
        double size = largest(ld * ld, X), top = largest(ld, f0);
        for (int r = 0; r < ld; r++) {
            double sum = 0;
            for (int j = 0; j < ld; j++) sum += X[r * ld + j] * f0[j];
            if (!(fabs(sum - f1[r]) <= 1e-13 * size * top))
                fail_msg("structure %d: flow %.15g, carried %.15g", i, f1[r], sum);
        }
        for (int j = 0; j < ld; j++)
            for (int k = 0; k < ld; k++) {
                double sum = 0, J = j < n && k == j + n   ? 1 / kappa[j]
                                    : k < n && j == k + n ? -1 / kappa[k]
                                                          : 0;
                for (int l = 0; l < n; l++)
                    sum += (X[l * ld + j] * X[(n + l) * ld + k] -
                            X[(n + l) * ld + j] * X[l * ld + k]) /
                           kappa[l];
                if (!(fabs(sum - J) <= 1e-13 * size * size))
                    fail_msg("structure %d: J[%d][%d] = %g, size %g", i, j, k, sum - J, size);
            }
        release(&s);
    }
}

/* A flight and the same in pieces take other steps and round in other ways: they differ by no more
 * than a flight is said to lose. What the matrix of the whole says alone, from its start, is left
 * behind by more than a factor of two in some. */
static void tells_what_it_loses(void **state)
{
    double beyond = 0;
    (void)state;
    for (int i = 0; i < 200; i++) {
        structure s;
        random_structure((uint64_t)(300 + i), 1 + i % MOST, 1 + i % CONTACTS, exponents[i % N_SET],
                         false, &s);
        int n = s.n, ld = 2 * n, pieces = 2 + i % 7;
        double w[ld], x[ld], rate[ld], M[ld * ld], lost, tau = uniform(1, i % 5 ? 8 : 40), off = 0;
        random_state(&s, i % 3 ? 3 : 8, w);
        memcpy(x, w, sizeof x);
        double size = largest(ld, w);
        assert_true(ric_power_flow_map(s.model, tau, w, M, &lost, s.work));
        for (int k = 0; k < pieces; k++)
            assert_true(ric_power_flow_fly(s.model, tau / pieces, x, 0, NULL, s.work));
        for (int j = 0; j < ld; j++) off = fmax(off, fabs(x[j] - w[j]));
        ric_flight_rate(s.model, 0, w, rate);
        double digit = largest(ld, rate) * tau, most = largest(ld * ld, M) * size;
        if (!(off <= DBL_EPSILON * (4 * lost + digit)))
            fail_msg("structure %d: %g off after %d pieces, said to lose %g", i, off, pieces,
                     DBL_EPSILON * (4 * lost + digit));
        beyond = fmax(beyond,
                      off / (DBL_EPSILON * (4 * most * fmax(1, digit / (2 * size)) + digit)));
        release(&s);
    }
    if (!(beyond > 2)) fail_msg("no flight lost more than its matrix tells: %g", beyond);
}

/* Against the flow in quadruple precision: a flight in double is off by no more than it says, and
 * where it says much, the one in more digits is left with the last digit of a double and what those
 * digits lose. */
static void more_digits_lose_less(void **state)
{
    int again = 0;
    double gained = 0;
    (void)state;
    for (int i = 0; i < 60; i += every_of(4)) {
        structure s;
        random_structure((uint64_t)(900 + i), 1 + i % MOST, 1 + i % CONTACTS, exponents[i % N_SET],
                         false, &s);
        int ld = 2 * s.n;
        double w[ld], x[ld], y[ld], M[ld * ld], lost[2], tau = uniform(1, i % 5 ? 8 : 40),
                                                         off[2] = {0};
        random_state(&s, i % 3 ? 3 : 8, w);
        memcpy(x, w, sizeof x);
        memcpy(y, w, sizeof y);
        double start = largest(ld, w), own = 0;
        assert_true(ric_power_flow_map(s.model, tau, x, M, &lost[0], s.work));
        assert_true(ric_power_flow_map_surely(s.model, tau, y, M, &lost[1], s.work));
        assert_true(quad_fly(s.model, tau, w));
        for (int j = 0; j < ld; j++) {
            double row = 0;
            for (int k = 0; k < ld; k++) row += M[j * ld + k] * M[j * ld + k];
            own = fmax(own, start * sqrt(row));
            off[0] = fmax(off[0], fabs(x[j] - w[j]));
            off[1] = fmax(off[1], fabs(y[j] - w[j]));
        }
        if (!(off[0] <= DBL_EPSILON * 4 * lost[0]))
            fail_msg("structure %d: %g off in double, said to lose %g", i, off[0],
                     DBL_EPSILON * 4 * lost[0]);
        if (lost[1] != lost[0]) {
            double digits = (double)(LDBL_EPSILON / DBL_EPSILON);
            again++;
            gained = fmax(gained, off[0] / off[1]);
            if (!(off[1] <= DBL_EPSILON * (largest(ld, w) + 4 * digits * lost[0])) ||
                !(lost[1] >= 0.99 * own))
                fail_msg("structure %d: %g off with more digits, %g in double, said to lose %g and "
                         "%g, own %g",
                         i, off[1], off[0], lost[1], lost[0], own);
        }
        release(&s);
    }
    if (!(again >= 3 && gained > 100)) fail_msg("%d flights again, %g gained", again, gained);
}

/* Sums, products and quotients of twice the digits against quadruple precision. */
static void twice_the_digits(void **state)
{
    (void)state;
    if (!QUAD_FLOW_HAS_113_BITS) skip();
    for (int i = 0; i < 20000; i++) {
        const double a = uniform(-1, 1), b = uniform(-1, 1) * pow(2, uniform(-60, 60));
        const ric_twice x = ric_twice_ordered(a, uniform(-0.5, 0.5) * fabs(a) * DBL_EPSILON);
        const ric_twice y = ric_twice_ordered(b, uniform(-0.5, 0.5) * fabs(b) * DBL_EPSILON);
        const int count = 1 + i % 99;
        const real p = (real)x.hi + x.lo, q = (real)y.hi + y.lo,
                   larger = fabs(a) > fabs(b) ? fabs(a) : fabs(b);
        const ric_twice sum = ric_twice_add(x, y), product = ric_twice_multiply(x, y),
                        part = ric_twice_over(a, count);
        const ric_twice scaled = ric_twice_scale(b, x);
        const real off[] = {((real)sum.hi + sum.lo - (p + q)) / larger,
                            ((real)product.hi + product.lo) / (p * q) - 1,
                            ((real)part.hi + part.lo) / ((real)a / count) - 1,
                            ((real)scaled.hi + scaled.lo) / (p * b) - 1};
        for (int k = 0; k < 4; k++) assert_true(fabs((double)off[k]) < RIC_TWICE_EPSILON);
    }
}

/* Flights with twice the digits against quadruple precision: what a flight in double loses, they
 * lose of their own. */
static void twice_the_digits_in_flight(void **state)
{
    (void)state;
    if (!QUAD_FLOW_HAS_113_BITS) skip();
    for (int i = 0; i < 30; i += every_of(4)) {
        structure s;
        random_structure((uint64_t)(500 + i), 1 + i % MOST, 1 + i % CONTACTS, exponents[i % N_SET],
                         false, &s);
        const int ld = 2 * s.n;
        double w[ld], x[ld], M[ld * ld], lost, tau = uniform(1, 8);
        real truth[ld];
        ric_twice twice[ld], *work = malloc(ric_power_flow_twice_work(s.model, 0) * sizeof *work);
        random_state(&s, 3, w);
        memcpy(x, w, sizeof x);
        for (int j = 0; j < ld; j++) twice[j] = ric_twice_from(truth[j] = w[j]);
        assert_true(ric_power_flow_map(s.model, tau, x, M, &lost, s.work));
        assert_true(quad_fly_all(s.model, tau, truth));
        assert_true(ric_power_flow_twice(s.model, ric_twice_from(tau), twice, 0, NULL, work));
        for (int j = 0; j < ld; j++) {
            const double off = fabs((double)((real)twice[j].hi + twice[j].lo - truth[j]));
            if (!(off <= 8 * RIC_TWICE_EPSILON * (lost + largest(ld, x))))
                fail_msg("structure %d: %g off, %g lost in double", i, off, lost);
        }
        free(work);
        release(&s);
    }
}

/* Code that knows the power has the bits of that which does not: columns of zeros take the latter.
 */
static void powers_are_known(void **state)
{
    static const int exponent[] = {3, 5, 7, 9, 21};
    enum { N = 4, WIDE = N + 2 };
    (void)state;
    for (int e = 0; e < (int)(sizeof exponent / sizeof *exponent); e++) {
        structure s;
        article(exponent[e], &s);
        double *work = calloc(ric_power_flow_work(s.model, WIDE), sizeof *work);
        double alone[N] = {0.9, -0.4, 0.3, 1.1}, known[N], wide[N], M[N * N] = {0},
               X[N * WIDE] = {0};
        memcpy(known, alone, sizeof alone);
        memcpy(wide, alone, sizeof alone);
        for (int i = 0; i < N; i++) M[i * N + i] = X[i * WIDE + i] = 1;
        assert_non_null(work);
        assert_true(ric_power_flow_fly(s.model, 7.5, known, N, M, work));
        assert_true(ric_power_flow_fly(s.model, 7.5, wide, WIDE, X, work));
        assert_memory_equal(known, wide, sizeof wide);
        for (int i = 0; i < N; i++) assert_memory_equal(M + i * N, X + i * WIDE, N * sizeof *M);
        memcpy(wide, alone, sizeof alone);
        memset(X, 0, sizeof X);
        assert_true(ric_power_flow_fly(s.model, 7.5, alone, 0, NULL, work));
        assert_true(ric_power_flow_fly(s.model, 7.5, wide, 2, X, work));
        assert_memory_equal(alone, wide, sizeof wide);
        free(work);
        release(&s);
    }
}

/* A flight of many steps is refused, not followed for ever; so is one that overflows. */
static void endless_flights_are_refused(void **state)
{
    (void)state;
    structure s;
    article(99, &s);
    double w[4] = {1e6, 0, 0, 0};
    assert_false(ric_power_flow_fly(s.model, 1, w, 0, NULL, s.work));
    memset(w, 0, sizeof w);
    w[0] = 1;
    assert_false(ric_power_flow_fly(s.model, 1e9, w, 0, NULL, s.work));
    assert_false(ric_power_flow_fly(s.model, HUGE_VAL, w, 0, NULL, s.work));
    release(&s);
}

/* States on the way are those of flights that end there: at the start, twice at one time, several
 * in a step and none in others. */
static void states_on_the_way(void **state)
{
    enum { COUNT = 9 };
    static const double tau[COUNT] = {0, 1e-9, 0.01, 0.02, 0.02, 0.4, 3, 3.001, 9};
    (void)state;
    for (int i = 0; i < 40; i++) {
        structure s;
        random_structure((uint64_t)(700 + i), 1 + i % MOST, 1 + i % CONTACTS, exponents[i % N_SET],
                         i % 7 == 6 && i % MOST > 0, &s);
        int ld = 2 * s.n;
        double from[ld], seen[COUNT * ld], M[ld * ld], lost, alone[ld];
        random_state(&s, i % 2 ? 0.8 : 0.01, from);
        assert_true(ric_power_flow_visit(s.model, COUNT, tau, from, seen, s.work));
        assert_memory_equal(seen, from, sizeof from);
        double *work = calloc(ric_power_flow_work(s.model, ld), sizeof *work);
        assert_non_null(work);
        for (int k = 1; k < COUNT; k++) {
            memcpy(alone, from, sizeof alone);
            assert_true(ric_power_flow_map(s.model, tau[k], alone, M, &lost, work));
            double off = 0;
            for (int j = 0; j < ld; j++) off = fmax(off, fabs(alone[j] - seen[k * ld + j]));
            /* what the steps of either lose */
            assert_true(off <= 20 * DBL_EPSILON * (lost + largest(ld, from)));
        }
        free(work);
        release(&s);
    }
    structure s;
    article(7, &s);
    double w[4] = {1, 0, 0, 0}, end[4];
    assert_false(ric_power_flow_visit(s.model, 1, &(double){1e9}, w, end, s.work));
    assert_false(ric_power_flow_visit(s.model, 1, &(double){HUGE_VAL}, w, end, s.work));
    release(&s);
}

/* h . (w1 - w0) is twice the difference of the energies, near and far. */
static void secants(void **state)
{
    (void)state;
    for (int i = 0; i < 60; i++) {
        structure s;
        random_structure((uint64_t)(500 + i), 1 + i % MOST, 1 + i % CONTACTS, exponents[i % N_SET],
                         i % 7 == 6 && i % MOST > 0, &s);
        int ld = 2 * s.n;
        double w0[ld], w1[ld], h[ld], sum = 0, E0, E1;
        random_state(&s, 1, w0);
        random_state(&s, i % 2 ? 1 : 1e-6, w1);
        for (int j = 0; j < ld && i % 2 == 0; j++) w1[j] += w0[j];
        E0 = ric_flight_energy(s.model, 0, w0);
        E1 = ric_flight_energy(s.model, 0, w1);
        ric_flight_secant(s.model, 0, w0, w1, h);
        for (int j = 0; j < ld; j++) sum += h[j] * (w1[j] - w0[j]);
        assert_true(fabs(sum / 2 - (E1 - E0)) <= 1e-14 * (E0 + E1));
        release(&s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(follows_cvode),
        cmocka_unit_test(conserves),
        cmocka_unit_test(becomes_linear),
        cmocka_unit_test(neighbours_are_derivatives),
        cmocka_unit_test(neighbours_are_symplectic),
        cmocka_unit_test(tells_what_it_loses),
        cmocka_unit_test(more_digits_lose_less),
        cmocka_unit_test(twice_the_digits),
        cmocka_unit_test(twice_the_digits_in_flight),
        cmocka_unit_test(powers_are_known),
        cmocka_unit_test(endless_flights_are_refused),
        cmocka_unit_test(states_on_the_way),
        cmocka_unit_test(secants),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
