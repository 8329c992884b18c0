#include "floquet_judge.h"

#include <complex.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"

#define LOST 1e-3 /* error of rho, over 1 + |rho|, from which on it is not given */
#define LOG_2 0.693147180559945309

/* ---------------------------------------------------------------- two modes */

/* Of a map whose rho is known to f->error: that of the whole period, which is `full`, where the map
 * is that of a half or a quarter of it. */
static void put_rho(ric_floquet *f, bool part, double rho, double full)
{
    f->each[0] = (part ? f->error * (2 * fabs(rho) + f->error) : f->error) +
                 DBL_EPSILON * fabs(full);
    f->own[0] = rho;
    f->own_error[0] = f->error;
    f->rho[0] = full;
    f->own[1] = f->rho[1] = 0;
}

static double turns(bool part, double angle, double twist)
{
    if (twist > 0) angle = 1 - angle;
    return fmod(part ? 2 * angle : angle, 1);
}

void ric_floquet_judge_plane(ric_floquet *f, bool quarter, double bc, double ad, double twist,
                             int exponent, double error)
{
    /* rho - 2, rho + 2 of the chain's map */
    double minus = ldexp(4 * bc, 2 * exponent), plus = ldexp(4 * ad, 2 * exponent);
    double rho = fabs(minus) < fabs(plus) ? 2 + minus : plus - 2,
           full = quarter ? rho * rho - 2 : rho;
    double log_rho = log(fmax(fabs(4 * bc), DBL_MIN)) + 2 * exponent * LOG_2;
    f->error = ldexp(error, 2 * exponent);
    put_rho(f, quarter, rho, full);
    if (fabs(rho) > 0x1p400 || !isfinite(rho))
        f->trace_asinh = quarter ? 2 * log_rho : copysign(log_rho, bc);
    else f->trace_asinh = asinh(full / 2);
    bool inside = 4 * bc < -error && 4 * ad > error, outside = 4 * bc > error || 4 * ad < -error;
    f->stable = inside ? RIC_STABLE_YES : outside ? RIC_STABLE_NO : RIC_STABLE_UNDECIDED;
    f->rotation = NAN;
    if (minus <= 0 && plus >= 0) {
        double angle = atan2(sqrt(fabs(minus * plus)), rho) /
                       RIC_TWO_PI; /* in [0, 1/2]; a product of -0 would give -1/2 */
        f->rotation = turns(quarter, angle, twist);
    }
}

void ric_floquet_judge_trace(ric_floquet *f, bool half, double trace, double twist, int exponent,
                             double error)
{
    double rho = ldexp(trace, exponent), full = half ? rho * rho - 2 : rho,
           two = ldexp(2, -exponent);
    error += ldexp(8 * DBL_EPSILON, -exponent);
    f->error = ldexp(error, exponent);
    put_rho(f, half, rho, full);
    if (fabs(rho) < 0x1p400) f->trace_asinh = asinh(full / 2);
    else f->trace_asinh = copysign((half ? 2 : 1) * (log(fabs(trace)) + exponent * LOG_2), full);
    f->stable = fabs(trace) < two - error   ? RIC_STABLE_YES
                : fabs(trace) > two + error ? RIC_STABLE_NO
                                            : RIC_STABLE_UNDECIDED;
    f->rotation = NAN;
    if (fabs(rho) <= 2) {
        double angle = acos(rho / 2) / RIC_TWO_PI;
        f->rotation = turns(half, angle, twist);
    }
}

/* --------------------------------------------------------------- more modes */

/* rho of the square of a map whose rho is r: r^2 - 2, complex. */
static void square(double *r)
{
    double re = r[0] * r[0] - r[1] * r[1] - 2, im = 2 * r[0] * r[1];
    r[0] = re;
    r[1] = im;
}

static int by_size(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* How far rho i may be off, by itself and, with_other, with one more that it is as good as one
 * with: m of them that may be one are moved by the m-th root of the error, relative to their size
 * (Kato, Perturbation Theory for Linear Operators, II section 1.2), so that within that of each lie
 * m. near [n_pair] is workspace: distances from this one that are within the widest. */
static double radius_of(const ric_floquet *f, int i, double error, double *near, double *with_other)
{
    const double *r = f->rho + 2 * i;
    const double size = 1 + fabs(r[0]) + fabs(r[1]), part = error / size,
                 widest = pow(part, 1.0 / (error < size ? f->n_pair : 2)) * size;
    double radius = error;
    int most = 0;
    for (int j = 0; j < f->n_pair; j++) {
        const double distance = hypot(f->rho[2 * j] - r[0], f->rho[2 * j + 1] - r[1]);
        if (distance <= widest) near[most++] = distance;
    }
    qsort(near, (size_t)most, sizeof *near, by_size);
    for (int m = 2; m <= most; m++) {
        const double wide = pow(part, 1.0 / m) * size;
        if (near[m - 1] <= wide) radius = fmax(radius, wide);
    }
    *with_other = fmax(radius, sqrt(part) * size);
    return radius;
}

void ric_floquet_judge_pairs(ric_floquet *f, bool quarter, const ric_floquet_pairs *known)
{
    bool undecided = false, unstable = false;
    double near[f->n_pair + 1], radius[f->n_pair + 1];
    f->error = 0;
    for (int i = 0; i < f->n_pair; i++) {
        double pair, alone = fmax(known->alone[i], radius_of(f, i, known->error[i], near, &pair));
        pair = fmax(pair, alone);
        radius[i] = alone;
        bool complex_pair = fabs(f->rho[2 * i + 1]) > 0;
        if (fabs(f->rho[2 * i + 1]) > pair || fabs(f->rho[2 * i]) - 2 > alone) unstable = true;
        else if (complex_pair || fabs(f->rho[2 * i]) > 2 - alone) undecided = true;
    }
    for (int i = 0; i < f->n_pair; i++) {
        double *r = f->rho + 2 * i, size = 1 + fabs(r[0]) + fabs(r[1]);
        bool lost = !(radius[i] <= LOST * size), far = r[1] == 0 && fabs(r[0]) - radius[i] > 2;
        memcpy(f->own + 2 * i, r, 2 * sizeof *r);
        if (lost && !far) f->own[2 * i] = f->own[2 * i + 1] = NAN;
        f->own_error[i] = radius[i];
        if (quarter) square(r);
        f->each[i] = quarter ? 2 * size * radius[i] : radius[i];
        if (lost) r[0] = r[1] = NAN;
        else f->error = fmax(f->error, f->each[i]);
    }
    f->stable = unstable ? RIC_STABLE_NO : undecided ? RIC_STABLE_UNDECIDED : RIC_STABLE_YES;
}

void ric_floquet_judge_lost(ric_floquet *f)
{
    f->stable = RIC_STABLE_NO;
    f->error = f->rough = 0;
    for (int i = 0; i < 2 * f->n_pair; i++) f->rho[i] = f->own[i] = NAN;
}

/* -------------------------------------------------------------- multipliers */

void ric_floquet_widen(ric_floquet *f, const double *more)
{
    double worst = 0, lost = 0;
    int known = 0;
    for (int i = 0; i < f->n_pair; i++) {
        double *r = f->rho + 2 * i;
        f->each[i] += more[i];
        /* of rho beyond a double infinite errors would be a small part */
        if (isfinite(more[i]) && f->each[i] <= LOST * (1 + hypot(r[0], r[1]))) {
            worst = fmax(worst, f->each[i]);
            known++;
            continue;
        }
        lost = isfinite(f->each[i]) ? fmax(lost, f->each[i]) : HUGE_VAL;
        r[0] = r[1] = NAN;
        f->trace_asinh = f->rotation = NAN; /* of two modes, which have one pair */
    }
    f->error = known ? worst : lost;
}

void ric_floquet_pair(const double *rho, double *out)
{
    double complex lambda = ric_floquet_pairs_large(rho), inverse = 1 / lambda;
    out[0] = creal(lambda);
    out[1] = cimag(lambda);
    out[2] = creal(inverse);
    out[3] = cimag(inverse);
}

void ric_floquet_multipliers(const ric_floquet *f, double *out)
{
    for (int i = 0; i < f->n_pair; i++) {
        const double *rho = f->rho + 2 * i;
        bool known = f->each[i] == 0 || ric_floquet_pairs_large_error(rho, f->each[i]) <= LOST;
        if (known) ric_floquet_pair(rho, out + 4 * i);
        else
            for (int k = 0; k < 4; k++) out[4 * i + k] = NAN;
    }
}
