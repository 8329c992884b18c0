/* The root finder: zeros with all digits, how often the function is asked for, and what a function
 * without a clean zero makes of it. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "base/hermite.h"
#include "base/root.h"

typedef struct {
    double (*f)(double), (*slope)(double);
    double a, b, zero;
} example;

static double line(double x)
{
    return 3 * (x - 0.7);
}

static double line_slope(double x)
{
    (void)x;
    return 3;
}

static double cosine(double x)
{
    return cos(x) - x;
}

static double cosine_slope(double x)
{
    return -sin(x) - 1;
}

/* A root of order three: no slope at it. */
static double flat(double x)
{
    return pow(x - 1, 3);
}

static double flat_slope(double x)
{
    return 3 * pow(x - 1, 2);
}

/* Newton's method alone runs off. */
static double arc(double x)
{
    return atan(x - 0.01);
}

static double arc_slope(double x)
{
    return 1 / (1 + (x - 0.01) * (x - 0.01));
}

/* Steep at one end: false position alone creeps. */
static double steep(double x)
{
    return exp(30 * x) - 2;
}

static double steep_slope(double x)
{
    return 30 * exp(30 * x);
}

static double jump(double x)
{
    return x < 0.3 ? -2 : 5;
}

static const example examples[] = {
    {line, line_slope, 0, 1, 0.7},
    {cosine, cosine_slope, 0, 1, 0.7390851332151607},
    {flat, flat_slope, 0, 3, 1},
    {arc, arc_slope, -40, 30, 0.01},
    {steep, steep_slope, 0, 1, 0.023104906018664842},
    {jump, NULL, 0, 1, 0.3},
};
enum { N = sizeof examples / sizeof *examples };

static double by_values(const example *e, bool turned, double tolerance, int *asked)
{
    double a = turned ? e->b : e->a, b = turned ? e->a : e->b;
    ric_root r = ric_root_between(a, e->f(a), b, e->f(b), tolerance);
    for (*asked = 0; ric_root_next(&r); ++*asked) r.f = e->f(r.x);
    return r.x;
}

static void zeros_have_all_digits_by_values(void **state)
{
    (void)state;
    for (int k = 0; k < N; k++)
        for (int turned = 0; turned < 2; turned++) {
            int asked;
            double x = by_values(&examples[k], turned, 1e-15, &asked);
            /* a root of order three comes nearer by a part in each pass only */
            double known = examples[k].f == flat ? 1e-5 : 4e-15;
            assert_true(fabs(x - examples[k].zero) <= known * (1 + fabs(examples[k].zero)));
            assert_in_range(asked, 1, 60);
        }
}

/* Nowhere outside the bracket, and a coarse tolerance asks less often. */
static void the_function_is_asked_for_inside_only(void **state)
{
    (void)state;
    for (int k = 0; k < N; k++) {
        const example *e = &examples[k];
        int coarse, fine;
        ric_root r = ric_root_between(e->a, e->f(e->a), e->b, e->f(e->b), 1e-12);
        while (ric_root_next(&r)) {
            assert_true(r.x >= e->a && r.x <= e->b);
            r.f = e->f(r.x);
        }
        by_values(e, false, 1e-2, &coarse);
        by_values(e, false, 1e-15, &fine);
        assert_true(coarse <= fine);
    }
}

static void smooth_functions_take_few_values(void **state)
{
    (void)state;
    int asked;
    by_values(&examples[1], false, 1e-15, &asked);
    assert_in_range(asked, 1, 8);
    by_values(&examples[0], false, 1e-15, &asked);
    assert_in_range(asked, 1, 3);
}

/* A pole beside the zero: with the interpolation that is exact for it, and with the usual one. */
static double beside_a_pole(double x)
{
    return (x - 0.3) / (x + 1e-4);
}

static void a_quotient_of_lines_takes_three_values(void **state)
{
    (void)state;
    int asked[2] = {0};
    for (int quotient = 0; quotient <= 1; quotient++) {
        ric_root r = ric_root_between(0, beside_a_pole(0), 1, beside_a_pole(1), 1e-13);
        r.quotient = quotient;
        for (; ric_root_next(&r); asked[quotient]++) r.f = beside_a_pole(r.x);
        assert_true(fabs(r.x - 0.3) < 1e-12);
    }
    if (asked[1] > 6 || asked[1] >= asked[0])
        fail_msg("%d values, and %d by quotients", asked[0], asked[1]);
}

/* A value that is rounding is a zero: it is not looked into. */
static void noise_ends_the_search(void **state)
{
    (void)state;
    int asked = 0;
    ric_root r = ric_root_between(0, cosine(0), 1, cosine(1), 1e-15);
    r.noise = 1e-3;
    for (; ric_root_next(&r); asked++) r.f = cosine(r.x);
    assert_true(fabs(r.f) <= 1e-3 && fabs(r.x - examples[1].zero) < 1e-3);
    assert_in_range(asked, 1, 3);
}

static void a_zero_at_an_end_is_found_there(void **state)
{
    (void)state;
    ric_root r = ric_root_between(0, 0, 1, 5, 1e-15);
    assert_false(ric_root_next(&r));
    assert_true(r.x == 0);
    r = ric_root_between(0, -5, 1, 0, 1e-15);
    assert_false(ric_root_next(&r));
    assert_true(r.x == 1);
}

static void a_function_that_is_no_number_comes_to_an_end(void **state)
{
    (void)state;
    int asked = 0;
    ric_root r = ric_root_between(0, -1, 1, 1, 1e-15);
    for (; ric_root_next(&r); asked++) r.f = NAN;
    assert_in_range(asked, 1, 60);
    ric_root_slope s = ric_root_slope_between(0, 1, true, 0.5);
    for (asked = 0; ric_root_slope_next(&s, NAN, NAN); asked++) assert_in_range(asked, 0, 60);
    assert_true(s.x >= 0 && s.x <= 1);
}

/* A zero that is met to the last digit is an end of the bracket, whatever rounding the function has
 * there: its other end is not sought by halves. */
static void a_zero_that_is_met_ends_the_search(void **state)
{
    (void)state;
    for (int i = -50; i <= 50; i++) {
        const double zero = 0.3 + 1e-3 * i, rest = 1e-18 * (i % 2 ? -1 : 1);
        int asked = 0;
        ric_root_slope r = ric_root_slope_between(0, 1, true, 0.6);
        r.least = 1e-10;
        double f;
        do {
            const double off = r.x - zero;
            f = off == 0 ? rest : off + off * off;
            asked++;
        } while (ric_root_slope_next(&r, f, 1 + 2 * (r.x - zero)));
        assert_true(fabs(r.x - zero) < 1e-15);
        assert_in_range(asked, 1, 8);
    }
}

/* With the derivative, from any start in the bracket. */
static void zeros_have_all_digits_by_slopes(void **state)
{
    (void)state;
    for (int k = 0; k < N; k++)
        for (int from = 0; from <= 8 && examples[k].slope; from++) {
            const example *e = &examples[k];
            int asked = 0;
            double start = e->a + (e->b - e->a) * from / 8;
            ric_root_slope r = ric_root_slope_between(e->a, e->b, e->f(e->b) > 0, start);
            r.least = 1e-16;
            r.part = DBL_EPSILON;
            while (ric_root_slope_next(&r, e->f(r.x), e->slope(r.x))) {
                assert_true(r.x >= e->a && r.x <= e->b);
                assert_in_range(++asked, 1, 60);
            }
            /* steps towards the root of order three shrink by a third only: they end where they are
             * short */
            double known = e->f == flat ? 1e-7 : 4e-15;
            assert_true(fabs(r.x - e->zero) <= known * (1 + fabs(e->zero)));
        }
}

/* Beside an extremum the parabola knows the zero, and the tangent overshoots. */
static void a_zero_beside_an_extremum_takes_fewer_values_by_parabolas(void **state)
{
    (void)state;
    for (double off = 1e-2; off > 1e-9; off /= 10) {
        const double zero = -acos(1 - off); /* of cos x - (1 - off), which rises to its top at 0 */
        int asked[2] = {0};
        for (int bent = 0; bent < 2; bent++) {
            ric_root_slope r = ric_root_slope_between(-1, 0, true, -1);
            r.part = 1e-8;
            for (bool on = true; on; asked[bent]++) {
                double f = off - 2 * sin(r.x / 2) * sin(r.x / 2);
                on = bent ? ric_root_slope_bent(&r, f, -sin(r.x), -cos(r.x))
                          : ric_root_slope_next(&r, f, -sin(r.x));
            }
            assert_true(fabs(r.x - zero) <= 1e-6 * fabs(zero));
        }
        assert_true(asked[1] < asked[0]);
    }
}

/* --------------------------------------------- samples with two derivatives */

typedef struct {
    double part, phase, level; /* sin t + part sin(2.7 t + phase) - level */
    int asked;
} wave;

static long double wave_at(const wave *w, int order, long double t)
{
    const long double o = 2.7L, p = o * t + w->phase, m = w->part;
    return order == 0   ? sinl(t) + m * sinl(p) - w->level
           : order == 1 ? cosl(t) + m * o * cosl(p)
           : order == 2 ? -sinl(t) - m * o * o * sinl(p)
                        : -cosl(t) - m * o * o * o * cosl(p);
}

static ric_sample look(const void *of, double t)
{
    const wave *w = of;
    ((wave *)of)->asked++;
    return (
        ric_sample){t,
                    {(double)wave_at(w, 0, t), (double)wave_at(w, 1, t), (double)wave_at(w, 2, t)}};
}

/* On panels of 0.7 rad of the faster wave: the zero of the wave or of its slope to the rounding of
 * the values, with 2.2 values on average. */
static void zeros_between_samples_have_all_digits_after_two_or_three_looks(void **state)
{
    (void)state;
    int found = 0, asked = 0;
    srand(5);
    for (int k = 0; k < 20000; k++) {
        wave w = {rand() / (RAND_MAX + 1.0) - 0.5, 6 * (rand() / (RAND_MAX + 1.0)),
                  2 * (rand() / (RAND_MAX + 1.0)) - 1, 0};
        const double from = 6 * (rand() / (RAND_MAX + 1.0)), h = 0.7 / 2.7;
        const int order = k % 2;
        ric_sample a = look(&w, from), b = look(&w, from + h);
        if (a.g[order] * b.g[order] >= 0 || a.g[order + 1] * b.g[order + 1] <= 0) continue;
        w.asked = 0;
        ric_sample zero = ric_hermite_zero(look, &w, order, a, b);
        long double t = zero.t;
        for (int i = 0; i < 5; i++) t -= wave_at(&w, order, t) / wave_at(&w, order + 1, t);
        double slope = fabs((double)wave_at(&w, order + 1, t)),
               known = 4 * DBL_EPSILON * (t + 3 / slope);
        if (!(fabsl(zero.t - t) <= known))
            fail_msg("%d: %.3g off, %.3g known", k, (double)fabsl(zero.t - t), known);
        assert_true(fabsl(zero.g[0] - wave_at(&w, 0, zero.t)) <= 1e-14);
        asked += w.asked;
        found++;
    }
    assert_true(found > 2000);
    if (asked > 2.3 * found) fail_msg("%d looks at %d zeros", asked, found);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(zeros_have_all_digits_by_values),
        cmocka_unit_test(the_function_is_asked_for_inside_only),
        cmocka_unit_test(smooth_functions_take_few_values),
        cmocka_unit_test(a_quotient_of_lines_takes_three_values),
        cmocka_unit_test(noise_ends_the_search),
        cmocka_unit_test(a_zero_at_an_end_is_found_there),
        cmocka_unit_test(a_function_that_is_no_number_comes_to_an_end),
        cmocka_unit_test(a_zero_that_is_met_ends_the_search),
        cmocka_unit_test(zeros_have_all_digits_by_slopes),
        cmocka_unit_test(a_zero_beside_an_extremum_takes_fewer_values_by_parabolas),
        cmocka_unit_test(zeros_between_samples_have_all_digits_after_two_or_three_looks),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
