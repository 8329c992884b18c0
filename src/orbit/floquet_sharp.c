#include "floquet_sharp.h"

#include <complex.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "base/room.h"

/* Each costs some twelve eliminations of [2k * 2k], which above take longer than a reader waits. */
#define MOST_PAIRS 16

typedef long double _Complex complex_t;

typedef ric_eigen_factors
    source; /* of b' c, whose eigenvalues are (rho - 2) / 4; with C NULL of the map, lambda */

static double complex eigenvalue_of(const source *s, const double *rho)
{
    return s->C ? (rho[0] + rho[1] * I - 2) / 4 : ric_floquet_pairs_large(rho);
}

static void rho_of(const source *s, const double *mu, double its_error, double *rho, double *error)
{
    const double complex value = mu[0] + mu[1] * I, r = s->C ? 2 + 4 * value : value + 1 / value;
    rho[0] = creal(r);
    /* on the unit circle lambda is complex, and rho is not */
    rho[1] = fabs(rho[1]) > 0 ? cimag(r) : 0;
    *error = s->C ? 4 * its_error
                  : its_error * cabs(1 - 1 / (value * value)) + its_error * its_error;
    *error += 16 * DBL_EPSILON * (1 + cabs(r));
}

/* How far the other eigenvalues are from that of pair i, its own inverse among them where it is
 * one. */
static double apart_from(const ric_floquet_pairs *pairs, const source *s, int i)
{
    const double complex own = eigenvalue_of(s, pairs->rho + 2 * i);
    double least = s->C ? HUGE_VAL : cabs(own - 1 / own);
    for (int j = 0; j < pairs->count; j++) {
        if (j == i) continue;
        const double complex x = eigenvalue_of(s, pairs->rho + 2 * j);
        least = fmin(least, fmin(cabs(own - x), s->C ? HUGE_VAL : cabs(own - 1 / x)));
    }
    return least;
}

static void sharpen(const source *s, double to, ric_floquet_pairs *pairs)
{
    const size_t size = (size_t)s->m;
    complex_t *work = ric_calloc(4 * size * size + 2 * size, sizeof *work);
    for (int i = 0; i < pairs->count && work; i++) {
        double *rho = pairs->rho + 2 * i, known = pairs->alone[i];
        if (!(known > to * (1 + hypot(rho[0], rho[1])))) continue;
        const double complex value = eigenvalue_of(s, rho);
        double mu[2] = {creal(value), cimag(value)},
               error = s->C ? known / 4 : cabs(value) * ric_floquet_pairs_large_error(rho, known);
        if (!ric_eigen_fine(s, apart_from(pairs, s, i), work, mu, &error)) continue;
        rho_of(s, mu, error, rho, &pairs->error[i]);
        pairs->alone[i] = pairs->error[i];
    }
    free(work);
}

bool ric_floquet_sharpens(int n_pair)
{
    return n_pair <= MOST_PAIRS;
}

void ric_floquet_sharpen_blocks(const ric_fine_real *b, const ric_fine_real *c,
                                ric_fine_real rounding, double to, ric_floquet_pairs *pairs)
{
    const int k = pairs->count;
    if (!ric_floquet_sharpens(k)) return;
    ric_fine_real turned[k * k];
    for (int i = 0; i < k; i++)
        for (int j = 0; j < k; j++) turned[i * k + j] = b[j * k + i];
    sharpen(&(source){.m = k, .B = turned, .C = c, .rounding = rounding}, to, pairs);
}

void ric_floquet_sharpen_map(const ric_fine_real *M, ric_fine_real rounding, double to,
                             ric_floquet_pairs *pairs)
{
    if (!ric_floquet_sharpens(pairs->count)) return;
    sharpen(&(source){.m = 2 * pairs->count, .B = M, .rounding = rounding}, to, pairs);
}
