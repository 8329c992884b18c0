/* Sines and cosines of base/sine.h: against the C library in more digits, exact where they have to
 * be, and the same bits in either lane and as other processors make them. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/sine.h"

#include "sample.h"

enum { CASES = 1 << 12 };

static uint64_t state = 20261127;

static double random_in(double low, double high)
{
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return low + (high - low) * (double)(state >> 11) * 0x1p-53;
}

/* An argument: of any size up to the limit, in every third case beside a multiple of a quarter of
 * pi, where the reduction cancels or the octants meet. */
static double argument(int k)
{
    const double pi_4 = 0.78539816339744830962;
    const double x = exp2(random_in(-4, 20)) * (k % 2 ? 1 : -1);
    if (k % 3) return x;
    const double near = nearbyint(x / pi_4) * pi_4;
    return k % 9 ? near : nextafter(near, k % 5 ? 2 * near : 0);
}

static bool same(double x, double y)
{
    return !memcmp(&x, &y, sizeof x);
}

static void digits(void **unused)
{
    const int rounds = long_form() ? 2000 : 400;
    double worst = 0, round = 0;
    (void)unused;
    for (int k = 0; k < rounds * CASES; k += every()) {
        double s, c, x = argument(k);
        if (fabs(x) > RIC_SINE_LIMIT) continue;
        ric_sine_cosine(x, &s, &c);
        worst = fmax(worst, fabs((double)(s - sinl(x))));
        worst = fmax(worst, fabs((double)(c - cosl(x))));
        round = fmax(round, fabs((double)((long double)s * s + (long double)c * c - 1)));
        if (worst >= 0x1p-53 || round >= 0x1p-52)
            fail_msg("sine %.17g and cosine %.17g of %.17g are off by %.3g", s, c, x, worst);
    }
}

/* What the C library rounds away of its own result, half a unit of the last place, comes to what is
 * promised of it. */
static void fine_digits(void **unused)
{
    const long double most = LDBL_EPSILON / 2 + LDBL_EPSILON / 4;
    const int rounds = long_form() ? 1000 : 50;
    (void)unused;
    for (int k = 0; k < rounds * CASES; k += every()) {
        long double s, c, x = argument(k);
        x += x * random_in(0, 1) * DBL_EPSILON;
        if (fabsl(x) > RIC_SINE_LIMIT) continue;
        ric_sine_cosine_fine(x, &s, &c);
        if (!(fabsl(s - sinl(x)) <= most) || !(fabsl(c - cosl(x)) <= most))
            fail_msg("sine %.21Lg and cosine %.21Lg of %.21Lg", s, c, x);
    }
}

static void exact(void **unused)
{
    long double fine[2];
    double s, c, t, d;
    (void)unused;
    ric_sine_cosine(0, &s, &c);
    assert_true(same(s, 0) && c == 1);
    ric_sine_cosine_fine(0, &fine[0], &fine[1]);
    assert_true(fine[0] == 0 && fine[1] == 1);
    ric_sine_cosine(0x1p-40, &s, &c);
    assert_true(s == 0x1p-40 && c == 1);
    for (int k = 0; k < CASES; k++) {
        double x = argument(k);
        ric_sine_cosine(x, &s, &c);
        ric_sine_cosine(-x, &t, &d);
        assert_true(same(t, -s) && same(d, c));
    }
}

/* Beyond the limit, and of what is no number: the C library's, in either lane, and the other lane
 * is what it is beside anything else. */
static void beyond(void **unused)
{
    static const double far[] = {0x1.0000000000001p20, 1e9, -1e22, HUGE_VAL, -HUGE_VAL, NAN};
    (void)unused;
    for (size_t i = 0; i < sizeof far / sizeof *far; i++)
        for (int lane = 0; lane < 2; lane++) {
            ric_lane x = {1.25, 1.25}, s, c;
            double own[2], near[2];
            x[lane] = far[i];
            sincos(far[i], &own[0], &own[1]);
            ric_sine_lanes(x, &s, &c);
            ric_sine_cosine(1.25, &near[0], &near[1]);
            assert_true(isnan(own[0]) ? isnan(s[lane]) && isnan(c[lane])
                                      : same(s[lane], own[0]) && same(c[lane], own[1]));
            assert_true(same(s[1 - lane], near[0]) && same(c[1 - lane], near[1]));
        }
}

/* ------------------------------------------------------------------ other processors */

typedef void way(const double *x, double *sine, double *cosine);

static inline __attribute__((always_inline)) void in_lanes(const double *x, double *sine,
                                                           double *cosine)
{
    for (int k = 0; k < CASES; k += 2) {
        ric_lane s, c;
        ric_sine_lanes(ric_lane_load(x + k), &s, &c);
        ric_lane_store(sine + k, s);
        ric_lane_store(cosine + k, c);
    }
}

static void as_built(const double *x, double *sine, double *cosine)
{
    in_lanes(x, sine, cosine);
}

#ifdef __clang__
#define OPTIMISED
#else
#define OPTIMISED __attribute__((optimize("O3"), optimize("fp-contract=off")))
#endif

#ifdef __x86_64__
/* Optimised, as only then a compiler could fuse products with sums: the flags of the build forbid
 * it. */
#define WAY(name, instructions)                                                                    \
    OPTIMISED __attribute__((target(instructions))) static void name(const double *x,              \
                                                                     double *sine, double *cosine) \
    {                                                                                              \
        in_lanes(x, sine, cosine);                                                                 \
    }
WAY(with_avx2, "avx2")
WAY(with_fma, "avx2,fma")
WAY(with_avx512, "avx512f,avx512vl,avx512dq,fma")

static int ways(way **out)
{
    int count = 0;
    out[count++] = as_built;
    if (__builtin_cpu_supports("avx2")) out[count++] = with_avx2;
    if (__builtin_cpu_supports("fma")) out[count++] = with_fma;
    if (__builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq"))
        out[count++] = with_avx512;
    return count;
}
#else
static int ways(way **out)
{
    out[0] = as_built;
    return 1;
}
#endif

/* Nor does it matter in which lane an argument stands, or that it stands in both. */
static void the_same_everywhere(void **unused)
{
    static double x[CASES], sine[2][CASES], cosine[2][CASES];
    way *all[4];
    (void)unused;
    for (int k = 0; k < CASES; k++) x[k] = argument(k) * (k % 100 == 7 ? 1e3 : 1);
    for (int k = 0; k < CASES; k++) ric_sine_cosine(x[k], &sine[0][k], &cosine[0][k]);
    for (int i = ways(all) - 1; i >= 0; i--) {
        all[i](x, sine[1], cosine[1]);
        assert_memory_equal(sine[1], sine[0], sizeof *sine);
        assert_memory_equal(cosine[1], cosine[0], sizeof *cosine);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(digits), cmocka_unit_test(fine_digits),         cmocka_unit_test(exact),
        cmocka_unit_test(beyond), cmocka_unit_test(the_same_everywhere),
    };
    return cmocka_run_group_tests_name("sine", tests, NULL, NULL);
}
