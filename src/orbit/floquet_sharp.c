#include "floquet_sharp.h"

#include <complex.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"

#define MOST_PAIRS                                                                                                     \
    16 /* each costs some twelve eliminations of [2k * 2k], which above take longer than a reader waits */

typedef long double _Complex complex_t;

typedef ric_eigen_factors source; /* of b' c, whose eigenvalues are (rho - 2) / 4; with C NULL of the map, lambda */

static void eigenvalue_of(const source *s, const double *rho, double error, double *mu, double *its_error)
{
    const double complex r = rho[0] + rho[1] * I, root = csqrt(r * r - 4);
    double complex lambda = (r + root) / 2;
    if (cabs(lambda) < 1) lambda = (r - root) / 2;
    const double complex value = s->C ? (r - 2) / 4 : lambda;
    mu[0] = creal(value);
    mu[1] = cimag(value);
    *its_error = s->C ? error / 4 : error * cabs(lambda) / fmax(cabs(root), sqrt(error));
}

static void rho_of(const source *s, const double *mu, double its_error, double *rho, double *error)
{
    const double complex value = mu[0] + mu[1] * I, r = s->C ? 2 + 4 * value : value + 1 / value;
    rho[0] = creal(r);
    /* on the unit circle lambda is complex, and rho is not */
    rho[1] = fabs(rho[1]) > 0 ? cimag(r) : 0;
    *error = s->C ? 4 * its_error : its_error * cabs(1 - 1 / (value * value)) + its_error * its_error;
    *error += 16 * DBL_EPSILON * (1 + cabs(r));
}

/* How far the other eigenvalues are from that of pair i, its own inverse among them where it is one. */
static double apart_from(const ric_floquet *f, const source *s, int i, const double *mu)
{
    const double complex own = mu[0] + mu[1] * I;
    double least = s->C ? HUGE_VAL : cabs(own - 1 / own), other[2], error;
    for (int j = 0; j < f->n_pair; j++) {
        if (j == i) continue;
        eigenvalue_of(s, f->rho + 2 * j, 0, other, &error);
        const double complex x = other[0] + other[1] * I;
        least = fmin(least, fmin(cabs(own - x), s->C ? HUGE_VAL : cabs(own - 1 / x)));
    }
    return least;
}

static void sharpen(ric_floquet *f, const source *s, ric_floquet_pairs *pairs)
{
    const size_t size = (size_t)s->m;
    if (!(f->sharp > 0) || f->n_pair > MOST_PAIRS) return;
    complex_t *work = ric_calloc(4 * size * size + 2 * size, sizeof *work);
    for (int i = 0; i < f->n_pair && work; i++) {
        double *rho = f->rho + 2 * i, mu[2], error;
        if (!(pairs->alone[i] > f->sharp * (1 + hypot(rho[0], rho[1])))) continue;
        eigenvalue_of(s, rho, pairs->alone[i], mu, &error);
        const double apart = apart_from(f, s, i, mu);
        if (!ric_eigen_fine(s, apart, work, mu, &error)) continue;
        rho_of(s, mu, error, rho, &pairs->error[i]);
        pairs->alone[i] = pairs->error[i];
    }
    free(work);
}

void ric_floquet_sharpen_blocks(ric_floquet *f, const ric_fine_real *b, const ric_fine_real *c, ric_fine_real rounding,
                                ric_floquet_pairs *pairs)
{
    const int k = f->n_pair;
    ric_fine_real turned[k * k];
    if (f->n_pair > MOST_PAIRS) return;
    for (int i = 0; i < k; i++)
        for (int j = 0; j < k; j++) turned[i * k + j] = b[j * k + i];
    sharpen(f, &(source){.m = k, .B = turned, .C = c, .rounding = rounding}, pairs);
}

void ric_floquet_sharpen_map(ric_floquet *f, const ric_fine_real *M, ric_fine_real rounding, ric_floquet_pairs *pairs)
{
    sharpen(f, &(source){.m = 2 * f->n_pair, .B = M, .rounding = rounding}, pairs);
}
