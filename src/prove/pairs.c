#include "pairs.h"

#include <complex.h>
#include <stdlib.h>

enum { STEPS = 60 }; /* of the search for roots, which is a guess */

/* The polynomial, coefficients from the constant one on; the last one is 1. */
typedef struct {
    int d;
    ric_line a[RIC_PAIRS_MOST + 1];
} polynomial;

/* rho^k is the sum of C(k, j) x^(k - 2 j). */
static void sum_powers(int d, const ric_line *sum, ric_line *power)
{
    for (int k = 1; k <= d; k++) {
        double binomial = 1;
        power[k] = (ric_line){0, 0, 0};
        for (int j = 0; 2 * j <= k; j++) {
            const ric_line x = 2 * j < k ? sum[k - 2 * j - 1] : ric_line_exact(d);
            power[k] = ric_line_add(power[k], ric_line_mul(ric_line_exact(binomial), x));
            binomial = binomial * (k - j) / (j + 1);
        }
    }
}

/* Newton's identities: k e_k = e_k-1 p_1 - e_k-2 p_2 + .., which keep what is known where no root
 * is much larger than the others. */
static polynomial make(int d, const ric_line *sum)
{
    ric_line power[RIC_PAIRS_MOST + 1], e[RIC_PAIRS_MOST + 1];
    polynomial p = {.d = d};
    sum_powers(d, sum, power);
    e[0] = ric_line_exact(1);
    for (int k = 1; k <= d; k++) {
        e[k] = (ric_line){0, 0, 0};
        for (int i = 1; i <= k; i++) {
            const ric_line x = ric_line_mul(e[k - i], power[i]);
            e[k] = i % 2 ? ric_line_add(e[k], x) : ric_line_sub(e[k], x);
        }
        e[k] = ric_line_mul(e[k], ric_line_inverse(ric_line_exact(k)));
    }
    for (int k = 0; k <= d; k++)
        p.a[d - k] = k % 2 ? ric_line_sub((ric_line){0, 0, 0}, e[k]) : e[k];
    return p;
}

/* -1, 1, or 0 where it is not told. */
static int sign_at(const polynomial *p, double x)
{
    ric_line y = p->a[p->d];
    for (int k = p->d - 1; k >= 0; k--)
        y = ric_line_add(ric_line_mul(y, ric_line_exact(x)), p->a[k]);
    const ric_ball whole = ric_line_whole(y);
    return whole.m > whole.r ? 1 : whole.m < -whole.r ? -1 : 0;
}

/* All of the roots in the middle of the line at once (Durand, Solutions numeriques des equations
 * algebriques 1 (1960)). */
static void find_roots(const polynomial *p, double complex *z)
{
    for (int i = 0; i < p->d; i++) z[i] = (i > 0 ? z[i - 1] : 2) * (0.4 + 0.9 * I);
    for (int step = 0; step < STEPS; step++)
        for (int i = 0; i < p->d; i++) {
            double complex y = 1, apart = 1;
            for (int k = p->d - 1; k >= 0; k--) y = y * z[i] + p->a[k].m;
            for (int k = 0; k < p->d; k++)
                if (k != i) apart *= z[i] - z[k];
            if (cabs(apart) > 0) z[i] -= y / apart;
        }
}

/* Bounds of the polynomial, or of its derivative, at z, whatever s is: by the sizes of what is
 * rounded at most 16 (d + 1) u of them, complex products and all. */
typedef struct {
    double size, off;
} bounds;

static bounds bound(const polynomial *p, double complex z, bool derivative)
{
    const double unit = 16 * (p->d + 1) * RIC_BALL_UNIT, r = cabs(z) * (1 + 4 * RIC_BALL_UNIT);
    double complex middle = 0, slope = 0;
    double off = 0;
    for (int k = p->d; k >= (derivative ? 1 : 0); k--) {
        const double by = derivative ? k : 1;
        middle = middle * z + by * p->a[k].m;
        slope = slope * z + by * p->a[k].g;
        off = off * r + by * (p->a[k].r + unit * ric_line_size(p->a[k]));
    }
    return (bounds){cabs(middle), (cabs(slope) + off) * (1 + unit)};
}

/* Q'/Q is the sum of 1 / (z - root): one of the d roots is within d |Q / Q'| of z. */
static bool is_off(const polynomial *p, double complex z)
{
    const bounds at = bound(p, z, false), rate = bound(p, z, true);
    const double least = rate.size * (1 - 0x1p-40) - rate.off;
    if (!(least > 0)) return false;
    const double radius = p->d * (at.size + at.off) / least * (1 + 0x1p-40) + 0x1p-900;
    return fabs(cimag(z)) > radius || fabs(creal(z)) - 2 > radius;
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* It changes sign d times between -2 and 2. */
static bool all_inside(const polynomial *p, const double complex *z)
{
    double x[RIC_PAIRS_MOST], last = -HUGE_VAL;
    bool inside = sign_at(p, 2) > 0;
    for (int i = 0; i < p->d; i++) x[i] = creal(z[i]);
    qsort(x, (size_t)p->d, sizeof *x, ascending);
    for (int i = 0; i < p->d && inside; i++) {
        const double at = i ? (x[i - 1] + x[i]) / 2 : -2;
        inside = last < at && at < 2 && sign_at(p, at) == ((p->d - i) % 2 ? -1 : 1);
        last = at;
    }
    return inside;
}

ric_stability ric_pairs_judge(int d, const ric_line *sum)
{
    const polynomial p = make(d, sum);
    double complex z[RIC_PAIRS_MOST];
    if (sign_at(&p, 2) < 0 || sign_at(&p, -2) * (d % 2 ? -1 : 1) < 0) return RIC_STABLE_NO;
    find_roots(&p, z);
    if (all_inside(&p, z)) return RIC_STABLE_YES;
    for (int i = 0; i < d; i++)
        if (is_off(&p, z[i])) return RIC_STABLE_NO;
    return RIC_STABLE_UNDECIDED;
}
