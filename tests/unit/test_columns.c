/* Numbers of a branch as columns, the sample of points that is replayed, and what is measured on an
 * orbit. */
#include <complex.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "explored.h"

#define TWO_PI 6.283185307179586

static const char text[] =
    "title: Two masses\n"
    "model:\n"
    "  mass: [[2, 0], [0, 1]]\n"
    "  stiffness: [[9, -1], [-1, 1]]\n"
    "  contacts:\n"
    "    - {normal: [-1, 1], clearance: 1, sides: both, law: rigid}\n"
    "explore: {energy: [0, 20], frequency: [0.2, 10], impacts: 4, multiply: 1}\n";

static int width_of(const ric_atlas *atlas, int branch, const char *name)
{
    int width = -1;
    assert_int_equal(ric_atlas_column(atlas, branch, name, &width, NULL), RIC_OK);
    return width;
}

static double *column_of(const ric_atlas *atlas, int branch, const char *name)
{
    int width;
    size_t n = (size_t)branch_of(atlas, branch).n_point * (size_t)width_of(atlas, branch, name);
    double *out = calloc(n + 1, sizeof *out);
    assert_non_null(out);
    assert_int_equal(ric_atlas_column(atlas, branch, name, &width, out), RIC_OK);
    return out;
}

static bool same(double a, double b)
{
    return a == b || (isnan(a) && isnan(b));
}

static void check_numbers(const ric_atlas *atlas, int id)
{
    static const char *const names[] = {"arclength", "energy",    "frequency", "period",
                                        "trace",     "log_trace", "rotation",  "stable",
                                        "reach",     "approach",  "residual"};
    for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
        double *column = column_of(atlas, id, names[k]);
        assert_int_equal(width_of(atlas, id, names[k]), 1);
        for (int i = 0; i < branch_of(atlas, id).n_point; i++) {
            ric_point p;
            assert_int_equal(ric_atlas_point(atlas, id, i, &p, NULL, NULL), RIC_OK);
            const double wanted[] = {p.arclength,
                                     p.energy,
                                     p.frequency,
                                     TWO_PI / p.frequency,
                                     ric_point_trace(&p),
                                     ric_point_log_trace(&p),
                                     p.rotation,
                                     p.stable,
                                     p.reach,
                                     p.approach,
                                     p.residual};
            assert_true(same(column[i], wanted[k]));
            /* moderate traces: the logarithm is that of the trace */
            if (fabs(p.trace) < 100 && p.trace != 0)
                assert_true(fabs(ric_point_log_trace(&p) - log(fabs(ric_point_trace(&p)))) < 1e-12);
        }
        free(column);
    }
}

static void check_vectors(const ric_atlas *atlas, int id)
{
    const ric_branch branch = branch_of(atlas, id);
    int n_state = width_of(atlas, id, "state"), n_flight = width_of(atlas, id, "flights");
    double *states = column_of(atlas, id, "state"), *flights = column_of(atlas, id, "flights"),
           state[4], flight[8];
    assert_int_equal(n_state, 4);
    assert_int_equal(n_flight, branch.letters > 0 ? branch.letters : 1);
    for (int i = 0; i < branch.n_point; i++) {
        assert_int_equal(ric_atlas_point(atlas, id, i, NULL, state, flight), RIC_OK);
        assert_memory_equal(state, states + 4 * i, sizeof state);
        assert_memory_equal(flight, flights + n_flight * i, (size_t)n_flight * sizeof *flight);
    }
    free(states);
    free(flights);
}

static void test_columns_are_the_points(void **unused)
{
    (void)unused;
    ric_atlas *atlas = explore_text(text);
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        check_numbers(atlas, id);
        check_vectors(atlas, id);
    }
    int width = 7;
    assert_int_equal(ric_atlas_column(atlas, 1, "speed", &width, NULL), RIC_E_RANGE);
    assert_non_null(strstr(ric_detail(), "speed"));
    assert_int_equal(ric_atlas_column(atlas, 0, "energy", &width, NULL), RIC_E_RANGE);
    ric_atlas_free(atlas);
}

/* Many at once, by any number of threads, are those of every orbit for itself. */
static void test_multipliers_at_once_are_those_of_the_orbits(void **unused)
{
    (void)unused;
    int compared = 0;
    ric_atlas *atlas = explore_text(text);
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        const int n = branch_of(atlas, id).n_point, tail = n / 2;
        double *one = calloc(4 * (size_t)n, sizeof *one),
               *three = calloc(4 * (size_t)n, sizeof *three), alone[4];
        assert_non_null(one);
        assert_non_null(three);
        assert_int_equal(ric_atlas_multipliers(atlas, id, 0, n, 1, one), RIC_OK);
        assert_int_equal(ric_atlas_multipliers(atlas, id, tail, n - tail, 3, three + 4 * tail),
                         RIC_OK);
        for (int i = 0; i < n; i++) {
            ric_orbit **orbits = NULL;
            int found = 0;
            assert_int_equal(ric_orbit_find(atlas, id, RIC_AT_POINT, i, &found, &orbits), RIC_OK);
            assert_int_equal(ric_orbit_multipliers(orbits[0], alone), RIC_OK);
            for (int k = 0; k < 4; k++) {
                assert_true(same(one[4 * i + k], alone[k]));
                assert_true(i < tail || same(three[4 * i + k], alone[k]));
                compared += isfinite(alone[k]) != 0;
            }
            ric_orbits_free(found, orbits);
        }
        free(one);
        free(three);
    }
    assert_true(compared > 500);
    assert_int_equal(ric_atlas_multipliers(atlas, 1, -1, 1, 1, NULL), RIC_E_RANGE);
    assert_int_equal(ric_atlas_multipliers(atlas, 1, 0, 1 << 30, 1, NULL), RIC_E_RANGE);
    assert_non_null(strstr(ric_detail(), "they run from 0"));
    ric_atlas_free(atlas);
}

/* Of two modes they are those of the trace that is stored with the point, to the bit, where it
 * decides the stability. */
static void test_multipliers_of_two_modes_are_in_the_trace(void **unused)
{
    (void)unused;
    int compared = 0;
    ric_atlas *atlas = explore_text(text);
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        const ric_branch b = branch_of(atlas, id);
        double *found = calloc(4 * (size_t)b.n_point, sizeof *found);
        assert_non_null(found);
        assert_int_equal(ric_atlas_multipliers(atlas, id, 0, b.n_point, 2, found), RIC_OK);
        for (int i = 0; i < b.n_point; i++) {
            ric_point p;
            assert_int_equal(ric_atlas_point(atlas, id, i, &p, NULL, NULL), RIC_OK);
            const double trace = ric_point_trace(&p);
            if (ric_branch_linear(ric_atlas_model(atlas), &b) || p.stable == RIC_STABLE_UNDECIDED ||
                isnan(trace))
                continue;
            const double complex rho = trace, root = csqrt(rho * rho - 4), sum = (rho + root) / 2,
                                 lambda = cabs(sum) < 1 ? (rho - root) / 2 : sum;
            assert_true(found[4 * i] == creal(lambda) && found[4 * i + 1] == cimag(lambda));
            compared++;
        }
        free(found);
    }
    assert_true(compared > 200);
    ric_atlas_free(atlas);
}

static void test_a_sample_has_the_ends_and_the_middle(void **unused)
{
    (void)unused;
    ric_atlas *atlas = explore_text(text);
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        int n = 0, chosen[RIC_VERIFY_SAMPLE], last = branch_of(atlas, id).n_point - 1;
        bool middle = false;
        assert_int_equal(ric_verify_sample(atlas, id, &n, chosen), RIC_OK);
        assert_true(n >= 1 && n <= RIC_VERIFY_SAMPLE && n <= last + 1);
        assert_int_equal(chosen[0], 0);
        assert_int_equal(chosen[n - 1], last);
        for (int i = 0; i < n; i++) {
            assert_true(i == 0 || chosen[i] > chosen[i - 1]);
            middle |= chosen[i] == (last + 1) / 2;
        }
        assert_true(middle);
    }
    ric_atlas_free(atlas);
}

/* The momentum that an impact exchanges is what changes: M (v+ - v-) = impulse b, and half of
 * b.M^-1 b times it is the speed. The masses move farthest somewhere: no sample is beyond the
 * amplitude, one comes close. */
static void check_orbit(const ric_orbit *orbit)
{
    double x[2], v[2], before[2], amplitude[2], largest[2] = {0}, speeds[8], impulses[8],
                                                flights[8];
    int n = 0, word[8], N = ric_orbit_letters(orbit);
    ric_point point;
    ric_orbit_data(orbit, &point, NULL, flights, word);
    assert_int_equal(ric_orbit_amplitudes(orbit, amplitude), RIC_OK);
    for (int k = 0; k < 4000; k++) {
        ric_orbit_at_time(orbit, k * TWO_PI / point.frequency / 4000, x, v);
        for (int i = 0; i < 2; i++) largest[i] = fmax(largest[i], fabs(x[i]));
    }
    for (int i = 0; i < 2; i++) assert_true(largest[i] <= amplitude[i] * (1 + 1e-8));
    for (int i = 0; i < 2; i++) assert_true(largest[i] >= amplitude[i] * (1 - 1e-2));
    assert_int_equal(ric_orbit_exchanges(orbit, &n, speeds, impulses), RIC_OK);
    assert_int_equal(n, N);
    double t = 0;
    for (int k = 0; k < n; k++, t += flights[k - 1]) {
        const double step = 1e-9;
        ric_orbit_at_time(orbit, t + step, x, v);
        ric_orbit_at_time(orbit, t - step + (k ? 0 : TWO_PI / point.frequency), x, before);
        assert_true(fabs(fabs(2 * (v[0] - before[0])) - impulses[k]) < 1e-6);
        assert_true(fabs(fabs(v[1] - before[1]) - impulses[k]) < 1e-6);
        assert_true(fabs(0.75 * impulses[k] - speeds[k]) < 1e-12 * (1 + speeds[k]));
    }
}

static void test_impacts_exchange_the_momentum(void **unused)
{
    (void)unused;
    int checked = 0;
    ric_atlas *atlas = explore_text(text);
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        ric_orbit **orbits = NULL;
        int n = 0;
        const ric_branch branch = branch_of(atlas, id);
        if (branch.impacts == 0) continue;
        assert_int_equal(ric_orbit_find(atlas, id, RIC_AT_POINT, branch.n_point / 2, &n, &orbits),
                         RIC_OK);
        assert_ptr_equal(ric_orbit_model(orbits[0]), ric_atlas_model(atlas));
        check_orbit(orbits[0]);
        ric_orbits_free(n, orbits);
        checked++;
    }
    assert_true(checked > 3);
    ric_atlas_free(atlas);
}

/* Over the contact behind letter k, by Simpson's rule: what the second mass gains, and what the
 * structure's own springs took from it. */
static double gained_by_second(const ric_orbit *orbit, double begin, double contact)
{
    enum { PARTS = 400 };
    double sum = 0, x[2], first[2], last[2];
    for (int i = 0; i <= PARTS; i++) {
        ric_orbit_at_time(orbit, begin + contact * i / PARTS, x, i ? last : first);
        const double weight = i == 0 || i == PARTS ? 1 : i % 2 ? 4 : 2;
        sum += weight * contact / (3.0 * PARTS) * (x[1] - x[0]);
    }
    return last[1] - first[1] + sum;
}

static int check_springs(const ric_orbit *orbit)
{
    double speeds[12], impulses[12], flights[24], t = 0;
    int n = 0, word[24], N = ric_orbit_letters(orbit), empty = 0;
    ric_point point;
    ric_orbit_data(orbit, &point, NULL, flights, word);
    assert_int_equal(ric_orbit_exchanges(orbit, &n, speeds, impulses), RIC_OK);
    assert_int_equal(2 * n, N);
    for (int k = 0, i = 0; k < N; t += flights[k++]) {
        if (word[k] >= 2) continue;
        assert_int_equal(word[(k + 1) % N], word[k] + 2);
        const double gained = gained_by_second(orbit, t, flights[k]), impulse = impulses[i++];
        assert_true(fabs(fabs(gained) - impulse) < 1e-9 * (1 + impulse));
        if (flights[k] == 0) empty += impulse == 0;
    }
    return empty;
}

/* What a spring exchanges is the integral of its force, at every contact: of the last two, of no
 * length, too. */
static void test_springs_exchange_the_integral_of_their_force(void **unused)
{
    (void)unused;
    int empty = 0;
    ric_atlas *atlas = explore_text(
        "model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  contacts:\n"
        "    - {normal: [-1, 1], clearance: 1, law: bilinear, stiffness: 1e4}\n"
        "explore: {energy: [0, 200], frequency: [0.2, 10], impacts: 12, multiply: 3, depth: 3}");
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        const ric_branch branch = branch_of(atlas, id);
        for (int i = 0; branch.impacts > 0 && i<branch.n_point; i += branch.n_point> 1
                            ? branch.n_point - 1
                            : 1) {
            ric_orbit **orbits = NULL;
            int n = 0;
            assert_int_equal(ric_orbit_find(atlas, id, RIC_AT_POINT, i, &n, &orbits), RIC_OK);
            empty += check_springs(orbits[0]);
            ric_orbits_free(n, orbits);
        }
    }
    assert_true(empty > 10);
    ric_atlas_free(atlas);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_columns_are_the_points),
        cmocka_unit_test(test_multipliers_at_once_are_those_of_the_orbits),
        cmocka_unit_test(test_multipliers_of_two_modes_are_in_the_trace),
        cmocka_unit_test(test_a_sample_has_the_ends_and_the_middle),
        cmocka_unit_test(test_impacts_exchange_the_momentum),
        cmocka_unit_test(test_springs_exchange_the_integral_of_their_force),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
