/* Junctions and backbones of random models against closed forms, from M and K by code that shares
 * nothing with the solver.
 *
 * One two-sided contact, clearance d, c_i = phi_i . b, tau = pi / omega the flight of S2[01].
 * Between its impacts
 *   s(t) / d = sum(c_i^2 sin(omega_i t) / (omega_i cos(omega_i tau/2))) / F,  F = sum(c_i^2
 *   tan(omega_i tau/2) /
 * omega_i),  |t| < tau/2, and E / d^2 = sum(c_i^2 sec^2(omega_i tau/2)) / (2 F^2). */
#include <complex.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <lapacke.h>

#include "explored.h"
#include "random_models.h"
#include "sample.h"

enum { MAX_N = 12 };

static const double PI = 3.14159265358979323846;

/* ------------------------------------------------------------------ helpers */

/* A structure with one contact, and its modes. */
typedef struct {
    int n;
    double M[MAX_N * MAX_N], K[MAX_N * MAX_N], b[MAX_N], clearance;
    double omega[MAX_N], c[MAX_N];
} structure;

static void solve_modes(structure *s)
{
    double A[MAX_N * MAX_N], B[MAX_N * MAX_N], square[MAX_N];
    int n = s->n;
    memcpy(A, s->K, sizeof A);
    memcpy(B, s->M, sizeof B);
    assert_int_equal(LAPACKE_dsygv(LAPACK_ROW_MAJOR, 1, 'V', 'U', n, A, n, B, n, square), 0);
    for (int i = 0; i < n; i++) {
        s->omega[i] = sqrt(square[i]);
        s->c[i] = 0;
        for (int j = 0; j < n; j++) s->c[i] += A[j * n + i] * s->b[j];
    }
}

static structure random_pair(uint64_t seed)
{
    structure s = {.n = 2, .b = {-1, 1}};
    seed_now = seed;
    double m1 = uniform(0.5, 3), m2 = uniform(0.5, 3), k1 = uniform(1, 10), k2 = uniform(0.5, 6);
    if (seed % 2) { /* nearer to the article's, where S2+ goes on beyond its first branch point */
        m1 = uniform(1.5, 2.5);
        m2 = uniform(0.7, 1.3);
        k1 = uniform(6, 10);
        k2 = uniform(0.7, 1.4);
    }
    s.M[0] = m1;
    s.M[3] = m2;
    s.K[0] = k1 + k2;
    s.K[1] = s.K[2] = -k2;
    s.K[3] = k2;
    s.clearance = uniform(0.3, 3);
    solve_modes(&s);
    return s;
}

/* Random matrices, far from equal frequencies and from modes that the contact hardly sees. */
static structure random_structure(uint64_t seed, int n)
{
    structure s = {.n = n};
    seed_now = seed;
    for (;;) {
        random_definite(n, n, n / 0.3, s.M);
        random_definite(n, n, 0, s.K);
        for (int i = 0; i < n * n; i++) {
            s.M[i] *= 0.3 / n;
            s.K[i] /= n;
        }
        for (int i = 0; i < n; i++) s.K[i * n + i] += 0.5 + i;
        for (int i = 0; i < n; i++) s.b[i] = uniform(-1, 1);
        s.clearance = uniform(0.3, 3);
        solve_modes(&s);
        bool good = true;
        for (int i = 0; i < n; i++)
            good = good && fabs(s.c[i]) > 0.02 && (i == 0 || s.omega[i] > 1.01 * s.omega[i - 1]);
        if (good) return s;
    }
}

static int print_matrix(char *out, size_t size, const char *key, int n, const double *A)
{
    int used = snprintf(out, size, "  %s: [", key);
    for (int i = 0; i < n; i++) {
        used += snprintf(out + used, size - (size_t)used, "%s[", i ? ", " : "");
        for (int j = 0; j < n; j++)
            used += snprintf(out + used, size - (size_t)used, "%s%.17g", j ? ", " : "",
                             A[i * n + j]);
        used += snprintf(out + used, size - (size_t)used, "]");
    }
    return used + snprintf(out + used, size - (size_t)used, "]\n");
}

static ric_atlas *explore(const structure *s, const char *sides, double energy, double slowest,
                          double fastest, int impacts, int depth)
{
    static char text[16384];
    size_t size = sizeof text;
    int used = snprintf(text, size, "model:\n");
    used += print_matrix(text + used, size - (size_t)used, "mass", s->n, s->M);
    used += print_matrix(text + used, size - (size_t)used, "stiffness", s->n, s->K);
    used += snprintf(text + used, size - (size_t)used,
                     "  contacts:\n    - {clearance: %.17g, sides: %s, normal: [", s->clearance,
                     sides);
    for (int i = 0; i < s->n; i++)
        used += snprintf(text + used, size - (size_t)used, "%s%.17g", i ? ", " : "", s->b[i]);
    snprintf(text + used, size - (size_t)used,
             "]}\nexplore: {energy: [0, %.17g], frequency: [%.17g, %.17g], impacts: %d, multiply: "
             "2, depth: %d}\n",
             energy, slowest, fastest, impacts, depth);
    return explore_text(text);
}

/* ------------------------------------------------------------- closed forms */

/* Energy of S2[01] at frequency omega; analytic in omega, so that an imaginary step gives its
 * derivative without cancellation. */
static double complex s2_energy(const structure *s, double complex omega)
{
    double complex top = 0, F = 0;
    for (int i = 0; i < s->n; i++) {
        double complex x = s->omega[i] * PI / (2 * omega);
        top += s->c[i] * s->c[i] / (ccos(x) * ccos(x));
        F += s->c[i] * s->c[i] * ctan(x) / s->omega[i];
    }
    return top / (2 * F * F);
}

/* The same for A1[0] with one-sided contact; 0/0 where a mode's period is the orbit's. */
static double complex a1_energy(const structure *s, double complex omega)
{
    double complex top = 0, F = 0;
    for (int i = 0; i < s->n; i++) {
        double complex x = s->omega[i] * PI / omega;
        top += s->c[i] * s->c[i] / (csin(x) * csin(x));
        F += s->c[i] * s->c[i] * ccos(x) / csin(x) / s->omega[i];
    }
    return top / (2 * F * F);
}

typedef double complex closed_form(const structure *s, double complex omega);

static double slope_of(closed_form *E, const structure *s, double omega)
{
    return cimag(E(s, omega + 1e-30 * I)) / 1e-30;
}

/* Relative conditioning of E(omega): of its argument, and of the sum in the denominator. */
static double conditioning(closed_form *E, const structure *s, double omega)
{
    double sum = 0, size = 0;
    for (int i = 0; i < s->n; i++) {
        double x = s->omega[i] * PI / omega, term = s->c[i] * s->c[i] / s->omega[i];
        term *= E == s2_energy ? tan(x / 2) : 1 / tan(x);
        sum += term;
        size += fabs(term);
    }
    return 1 + size / fabs(sum) + fabs(omega * slope_of(E, s, omega) / creal(E(s, omega)));
}

static void check_energy(closed_form *E, const structure *s, double omega, double energy,
                         const char *where)
{
    double closed = creal(E(s, omega)), allowed = 1e-12 * conditioning(E, s, omega);
    if (!(fabs(energy - closed) <= allowed * fabs(closed)))
        fail_msg("%s: omega %.15g: E %.15g, closed form %.15g, off by %.3g of %.3g allowed", where,
                 omega, energy, closed, fabs(energy - closed) / closed, allowed);
}

/* Branch points of S2[01], T = 2 pi / omega, and the derivative over omega. kind 0: impulses of
 * different size, equal flights, sum (c_i^2 / omega_i) cot(omega_i T/4) = 0. Kind 1: equal
 * impulses, different flights: sum K' = 0 of the impulse form must have a free second time,
 * K''(T/2) = 0 or sum c_i^2 omega_i / sin(omega_i T/2) = 0. */
static double branching(const structure *s, int kind, double omega, double *slope)
{
    double sum = 0, d = 0;
    for (int i = 0; i < s->n; i++) {
        double x = s->omega[i] * PI / (2 * omega), cc = s->c[i] * s->c[i];
        if (kind == 0) {
            sum += cc / s->omega[i] / tan(x);
            d += cc / s->omega[i] / (sin(x) * sin(x)) * x / omega;
        } else {
            sum += cc * s->omega[i] / sin(2 * x);
            d += cc * s->omega[i] * cos(2 * x) / (sin(2 * x) * sin(2 * x)) * 2 * x / omega;
        }
    }
    *slope = d;
    return sum;
}

/* Gap coordinate of S2[01] between impacts, -tau/2 < t < tau/2, over the clearance; and its
 * derivative. */
static double s2_gap(const structure *s, double omega, double t, double *slope)
{
    double sum = 0, d = 0, F = 0;
    for (int i = 0; i < s->n; i++) {
        double x = s->omega[i] * PI / (2 * omega), w = s->c[i] * s->c[i];
        sum += w * sin(s->omega[i] * t) / (s->omega[i] * cos(x));
        d += w * cos(s->omega[i] * t) / cos(x);
        F += w * tan(x) / s->omega[i];
    }
    *slope = d / F;
    return sum / F;
}

/* Largest |s| at stationary points in flight, 0 if there is none; `touches`: how many in one flight
 * reach 1. */
static double s2_reach(const structure *s, double omega, int *touches)
{
    int steps = 2000;
    double half = PI / omega / 2, top = 0, before, slope;
    *touches = 0;
    s2_gap(s, omega, 0, &before);
    for (int k = 1; k <= steps; k++) {
        double l = half * (k - 1) / steps, r = half * k / steps;
        s2_gap(s, omega, r, &slope);
        if (slope * before < 0) {
            double left = before, mid;
            for (int i = 0; i < 60; i++) {
                s2_gap(s, omega, (l + r) / 2, &mid);
                if (mid * left > 0) l = (l + r) / 2;
                else r = (l + r) / 2;
            }
            double value = s2_gap(s, omega, (l + r) / 2, &mid);
            /* a maximum of s > 0 or a minimum of s < 0 */
            if (value * left > 0) {
                top = fmax(top, fabs(value));
                if (fabs(value) > 1 - 1e-8) *touches += 2; /* and at -t */
            }
        }
        before = slope;
    }
    return top;
}

/* ------------------------------------------------------- two masses, junctions */

static bool is_s2(const ric_branch *b)
{
    return b->impacts == 2 && b->symmetric && b->word[0] == 0 && b->word[1] == 1;
}

typedef struct {
    int extrema, branch_points[2], grazings, linear, points;
} tally;

static bool has(int n, const int *list, int item)
{
    for (int i = 0; i < n; i++)
        if (list[i] == item) return true;
    return false;
}

static void check_linear(const structure *s, const ric_junction *j, const char *where, tally *count)
{
    for (int i = 0; i < s->n; i++) {
        double E = s->omega[i] * s->omega[i] / (2 * s->c[i] * s->c[i]);
        if (fabs(j->frequency - s->omega[i]) > 1e-9 * s->omega[i]) continue;
        if (!(fabs(j->energy - E) <= 1e-12 * E))
            fail_msg("%s: linear grazing of mode %d at %.15g, not %.15g", where, i + 1, j->energy,
                     E);
        count->linear++;
    }
}

static void check_s2_junction(const structure *s, const ric_branch *b, const ric_junction *j,
                              const char *where, tally *count)
{
    double omega = j->frequency, slope;
    int touches;
    if (j->multiple != 1) return;
    if (j->impacts == 0) return; /* linear grazing, 0/0 there */
    check_energy(s2_energy, s, omega, j->energy, where);
    if (j->kind == RIC_KIND_EXTREMUM) {
        double h = 1e-5 * omega, E1 = slope_of(s2_energy, s, omega);
        double E2 = (slope_of(s2_energy, s, omega + h) - slope_of(s2_energy, s, omega - h)) /
                    (2 * h);
        if (!(fabs(E1 / E2) <= 1e-10 * omega))
            fail_msg("%s: extremum of E at omega %.15g, off by %.3g", where, omega, E1 / E2);
        assert_true(j->a == 3 && j->b == 1);
        count->extrema++;
    } else if (j->kind == RIC_KIND_BRANCH_POINT && has(b->n_junction, b->junctions, j->id)) {
        double off[2];
        for (int kind = 0; kind < 2; kind++) {
            off[kind] = branching(s, kind, omega, &slope);
            off[kind] = fabs(off[kind] / slope);
        }
        if (!(fmin(off[0], off[1]) <= 1e-10 * omega))
            fail_msg("%s: branch point at omega %.15g, off by %.3g and %.3g", where, omega, off[0],
                     off[1]);
        if (j->a != 3 || j->b != 2)
            fail_msg("%s: branch point at omega %.15g: C_%d%d", where, omega, j->a, j->b);
        count->branch_points[off[1] < off[0]]++;
    } else if (j->kind == RIC_KIND_GRAZING) {
        double reach = s2_reach(s, omega, &touches);
        if (!(fabs(reach - 1) <= 1e-10))
            fail_msg("%s: grazing at omega %.15g, but the gap opens to %.15g", where, omega, reach);
        if (j->grazings != 2 * touches)
            fail_msg("%s: grazing at omega %.15g with p = %d, %d touches a flight", where, omega,
                     j->grazings, touches);
        count->grazings++;
    }
}

/* Zeros of dE/domega (kind -1) or of a branching equation strictly between two frequencies, from
 * the closed forms; poles do not count. */
static int count_zeros(const structure *s, int kind, double lo, double hi)
{
    int steps = 6000, zeros = 0;
    double before = 0, slope;
    for (int k = 0; k <= steps; k++) {
        double omega = lo + (hi - lo) * (1e-6 + (1 - 2e-6) * k / steps);
        double value = kind < 0 ? slope_of(s2_energy, s, omega) : branching(s, kind, omega, &slope);
        for (int i = 0; i < s->n && kind >= 0; i++)
            value *= sin(s->omega[i] * PI / ((kind ? 1 : 2) * omega));
        zeros += k > 0 && value * before < 0;
        before = value;
    }
    return zeros;
}

static void check_s2_branch(const structure *s, const ric_atlas *atlas, const ric_branch *b,
                            const char *where, tally *count)
{
    int extrema = 0, branch_points = 0, touches;
    for (int i = 0; i < b->n_point; i++) {
        ric_point p;
        double state[2 * MAX_N], flights[2];
        assert_int_equal(ric_atlas_point(atlas, b->id, i, &p, state, flights), RIC_OK);
        bool linear = false; /* 0/0 in the closed form */
        for (int k = 0; k < s->n; k++)
            linear = linear || fabs(p.frequency / s->omega[k] - 1) < 1e-6;
        if (linear) continue;
        check_energy(s2_energy, s, p.frequency, p.energy, where);
        assert_true(fabs(flights[0] - PI / p.frequency) <= 1e-13 * flights[0] &&
                    fabs(flights[1] - flights[0]) <= 1e-13 * flights[0]);
        if (s->n == 2) {
            double reach = s2_reach(s, p.frequency, &touches),
                   stored = isnan(p.reach) ? 0 : p.reach;
            if (!(fabs(reach - stored) <= 1e-9))
                fail_msg("%s: omega %.15g: reach %.12g, closed form %.12g", where, p.frequency,
                         p.reach, reach);
        }
        count->points++;
    }
    for (int k = 0; k < b->n_junction; k++) {
        ric_junction j;
        assert_int_equal(ric_atlas_junction(atlas, b->junctions[k], &j), RIC_OK);
        check_s2_junction(s, b, &j, where, count);
        extrema += j.kind == RIC_KIND_EXTREMUM;
        branch_points += j.kind == RIC_KIND_BRANCH_POINT;
    }
    for (int end = 0; end < 2; end++) {
        ric_junction j;
        int id = end ? b->to : b->from;
        if (!id) continue;
        assert_int_equal(ric_atlas_junction(atlas, id, &j), RIC_OK);
        check_s2_junction(s, b, &j, where, count);
    }
    /* none is missed: omega grows along a backbone */
    int expected = count_zeros(s, -1, b->frequency_min, b->frequency_max);
    if (extrema != expected)
        fail_msg("%s: %d extrema, %d zeros of dE/domega", where, extrema, expected);
    expected = count_zeros(s, 0, b->frequency_min, b->frequency_max) +
               count_zeros(s, 1, b->frequency_min, b->frequency_max);
    if (branch_points != expected)
        fail_msg("%s: %d branch points, %d zeros of the branching equation", where, branch_points,
                 expected);
}

static void junctions_of_two_masses(void **state)
{
    (void)state;
    tally count = {0};
    for (uint64_t seed = 1; seed <= 20; seed += (uint64_t)every()) {
        structure s = random_pair(seed);
        ric_atlas *atlas = explore(&s, "both", 300, 0.2 * s.omega[0], 4 * s.omega[1], 6, 2);
        int linear = count.linear;
        for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
            ric_junction j;
            assert_int_equal(ric_atlas_junction(atlas, id, &j), RIC_OK);
            char where[80];
            snprintf(where, sizeof where, "seed %llu, junction %d %s", (unsigned long long)seed, id,
                     j.label);
            if (j.impacts == 0 && j.kind == RIC_KIND_GRAZING && j.multiple == 1)
                check_linear(&s, &j, where, &count);
        }
        if (count.linear - linear != 2)
            fail_msg("seed %llu: %d linear grazings", (unsigned long long)seed,
                     count.linear - linear);
        for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
            ric_branch b;
            char where[80];
            assert_int_equal(ric_atlas_branch(atlas, id, &b), RIC_OK);
            snprintf(where, sizeof where, "seed %llu, branch %d %s", (unsigned long long)seed, id,
                     b.label);
            if (b.stop == RIC_STOP_FAILED) fail_msg("%s: %s", where, b.why);
            if (is_s2(&b)) check_s2_branch(&s, atlas, &b, where, &count);
        }
        ric_atlas_free(atlas);
    }
    print_message(
        "# %d extrema, %d + %d branch points, %d grazings of S2, %d linear grazings, %d points\n",
        count.extrema, count.branch_points[0], count.branch_points[1], count.grazings, count.linear,
        count.points);
    assert_true(count.extrema >= 20 && count.branch_points[0] >= 5 && count.branch_points[1] >= 1 &&
                count.grazings >= 5 && count.linear == 40);
}

/* -------------------------------------------------------- backbones, n = 1..12 */

static void backbones(void **state)
{
    (void)state;
    tally count = {0};
    for (int n = 1; n <= MAX_N; n += n < 8 ? 1 : every_of(4))
        for (int trial = n > 8; trial < 2; trial += every_of(2)) {
            uint64_t seed = 1000u * (uint64_t)n + (uint64_t)trial;
            structure s = random_structure(seed, n);
            double window = 0;
            for (int i = 0; i < n; i++)
                window = fmax(window, 2 * s.omega[i] * s.omega[i] / (s.c[i] * s.c[i]));
            ric_atlas *atlas = explore(&s, "both", window, 0.5 * s.omega[0], 2 * s.omega[n - 1], 2,
                                       1);
            int backbones = 0, linear = count.linear;
            for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
                ric_junction j;
                assert_int_equal(ric_atlas_junction(atlas, id, &j), RIC_OK);
                if (j.impacts == 0 && j.kind == RIC_KIND_GRAZING && j.multiple == 1)
                    check_linear(&s, &j, "backbones", &count);
            }
            assert_int_equal(count.linear - linear, n);
            for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
                ric_branch b;
                char where[80];
                assert_int_equal(ric_atlas_branch(atlas, id, &b), RIC_OK);
                snprintf(where, sizeof where, "seed %llu, n = %d, branch %d %s",
                         (unsigned long long)seed, n, id, b.label);
                if (b.stop == RIC_STOP_FAILED) fail_msg("%s: %s", where, b.why);
                if (!is_s2(&b)) continue;
                check_s2_branch(&s, atlas, &b, where, &count);
                backbones++;
            }
            if (backbones < 1)
                fail_msg("seed %llu, n = %d: no backbone", (unsigned long long)seed, n);
            ric_atlas_free(atlas);
        }
    print_message("# %d points, %d extrema, %d + %d branch points, %d grazings\n", count.points,
                  count.extrema, count.branch_points[0], count.branch_points[1], count.grazings);
    assert_true(count.points > 500);
}

/* ------------------------------------------------------------------ one mass */

static void one_mass(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 10; seed += (uint64_t)every()) {
        for (int sided = 0; sided < 3; sided++) {
            static const char *const sides[3] = {"both", "upper", "lower"};
            structure s = random_structure(seed, 1);
            double E0 = s.omega[0] * s.omega[0] / (2 * s.c[0] * s.c[0]);
            ric_atlas *atlas = explore(&s, sides[sided], 50 * E0, 0.1 * s.omega[0], 20 * s.omega[0],
                                       12, 5);
            if (ric_atlas_n_branch(atlas) != 2)
                fail_msg("seed %llu, %s: %d branches", (unsigned long long)seed, sides[sided],
                         ric_atlas_n_branch(atlas));
            ric_branch b;
            assert_int_equal(ric_atlas_branch(atlas, 1, &b), RIC_OK);
            assert_true(!strncmp(b.label, "S0", 2) && b.impacts == 0 && b.n_junction == 0);
            assert_int_equal(ric_atlas_branch(atlas, 2, &b), RIC_OK);
            if (strncmp(b.label, sided ? "A1" : "S2", 2) || b.impacts != (sided ? 1 : 2))
                fail_msg("seed %llu, %s: %s", (unsigned long long)seed, sides[sided], b.label);
            if (b.stop != RIC_STOP_WINDOW || b.n_junction)
                fail_msg("seed %llu, %s: %s stops: %s (%s), passes %d", (unsigned long long)seed,
                         sides[sided], b.label, ric_stop_text(b.stop), b.why, b.n_junction);
            for (int i = 0; i < b.n_point; i++) {
                ric_point p;
                double x[2], tau[2];
                assert_int_equal(ric_atlas_point(atlas, 2, i, &p, x, tau), RIC_OK);
                assert_int_equal(p.stable, RIC_STABLE_YES);
                if (fabs(p.frequency / s.omega[0] - 1) > 1e-6)
                    check_energy(sided ? a1_energy : s2_energy, &s, p.frequency, p.energy,
                                 sides[sided]);
            }
            int singles = 0;
            for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
                ric_junction j;
                assert_int_equal(ric_atlas_junction(atlas, id, &j), RIC_OK);
                assert_int_equal(j.kind, RIC_KIND_GRAZING);
                assert_true(fabs(j.energy - E0) <= 1e-12 * E0);
                /* nothing leaves its duplicates */
                if (j.multiple > 1) assert_int_equal(j.departures.taken + j.departures.known, 0);
                else singles++;
            }
            assert_int_equal(singles, 1);
            ric_atlas_free(atlas);
        }
    }
}

/* One-sided contacts: A1[0] of random models. */
static void one_sided(void **state)
{
    (void)state;
    int points = 0;
    for (uint64_t seed = 1; seed <= 12; seed += (uint64_t)every()) {
        int n = 1 + (int)(seed % 6);
        structure s = random_structure(seed, n);
        double window = 0;
        for (int i = 0; i < n; i++)
            window = fmax(window, 2 * s.omega[i] * s.omega[i] / (s.c[i] * s.c[i]));
        ric_atlas *atlas = explore(&s, "upper", window, 0.5 * s.omega[0], 4 * s.omega[n - 1], 1, 1);
        for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
            ric_branch b;
            char where[80];
            assert_int_equal(ric_atlas_branch(atlas, id, &b), RIC_OK);
            snprintf(where, sizeof where, "seed %llu, n = %d, branch %d %s",
                     (unsigned long long)seed, n, id, b.label);
            if (b.stop == RIC_STOP_FAILED) fail_msg("%s: %s", where, b.why);
            for (int i = 0; i < b.n_point && b.impacts == 1; i++) {
                ric_point p;
                double state_[2 * MAX_N], tau[2];
                bool linear = false;
                assert_int_equal(ric_atlas_point(atlas, id, i, &p, state_, tau), RIC_OK);
                for (int k = 0; k < n; k++)
                    linear = linear || fabs(remainder(s.omega[k] / p.frequency, 1)) < 1e-6;
                if (linear) continue;
                check_energy(a1_energy, &s, p.frequency, p.energy, where);
                points++;
            }
        }
        ric_atlas_free(atlas);
    }
    assert_true(points > 100);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(junctions_of_two_masses),
        cmocka_unit_test(backbones),
        cmocka_unit_test(one_mass),
        cmocka_unit_test(one_sided),
    };
    return cmocka_run_group_tests_name("identities", tests, NULL, NULL);
}
