/* The elimination of one row of the Jacobian by a Householder reflection, of which shooting.c and
 * shooting_nodes.c make the factorisation: no Jacobian is stored (head of shooting.h). */
#ifndef RIC_ORBIT_SHOOTING_PARTS_H
#define RIC_ORBIT_SHOOTING_PARTS_H

#include <string.h>

#include "shooting.h"

static inline bool ric_general(const ric_shooting *c)
{
    return c->start == RIC_MIRROR_NONE;
}

/* The state, or the neighbour, w [2n] that the start block of u makes, of a chain that starts at a
 * rest, at a centre, or anywhere. */
static inline void ric_start_of(const ric_shooting *c, const double *u, double *w)
{
    memset(w, 0, 2 * (size_t)c->n * sizeof *w);
    memcpy(c->start == RIC_MIRROR_CENTRE ? w + c->n : w, u, (size_t)c->n_start * sizeof *w);
}

/* In two sums, and in four where a row is long: one alone waits for every addition. They begin at
 * -0, which leaves the first product as it is. */
static inline __attribute__((always_inline)) double ric_row_dot(int m, const double *x,
                                                                const double *v)
{
    double sum[4] = {-0.0, -0.0, -0.0, -0.0};
    int j = 0;
    for (; m >= 32 && j + 4 <= m; j += 4)
        for (int k = 0; k < 4; k++) sum[k] += x[j + k] * v[j + k];
    for (; j + 1 < m; j += 2)
        for (int k = 0; k < 2; k++) sum[k] += x[j + k] * v[j + k];
    if (j < m) sum[0] += x[j] * v[j];
    return sum[0] + sum[1] + (sum[2] + sum[3]);
}

/* Householder vector that turns the row g [m] into (0, .., 0, rho), applied with what is stored of
 * it: x.g / rho, which waits for less, is its last entry only as far as rounding lets it, and
 * labels beside branch points are lost by that. The constraint g.z + offset = -residual then pins
 * the last coordinate. Applies it to `rows` rows of X and moves the pinned part into the last
 * column of X (the inhomogeneous one). */
static inline __attribute__((always_inline)) double ric_pin(ric_shooting *c, int vector, int m,
                                                            const double *g, double rhs, int rows,
                                                            int ld)
{
    double *v = c->hv + (size_t)vector * (size_t)ld, *X = c->X;
    if (m >= ld) __builtin_unreachable(); /* of the last column nothing is pinned */
    const double norm = sqrt(ric_row_dot(m, g, g));
    if (!(norm > 0)) {
        c->singular = true;
        for (int j = 0; j < m; j++) v[j] = 0;
        c->beta[vector] = c->zeta[vector] = 0;
        return 0;
    }
    const double last = g[m - 1], rho = -copysign(norm, last), zeta = rhs / rho,
                 beta = 1 / (norm * (norm + fabs(last)));
    for (int j = 0; j < m; j++) v[j] = g[j];
    v[m - 1] = last - rho;
    c->beta[vector] = beta;
    c->zeta[vector] = zeta;
    for (int r = 0; r < rows; r++) {
        double *x = X + r * ld, s = beta * ric_row_dot(m, x, v);
        for (int j = 0; j < m; j++) x[j] -= s * v[j];
        x[ld - 1] += x[m - 1] * zeta;
    }
    return rho;
}

/* Undoes one Householder reflection on z [m], whose last coordinate was pinned at `pinned`. */
static inline void ric_unpin(const ric_shooting *c, int vector, int m, double pinned, double *z)
{
    const double *v = c->hv + (size_t)vector * (size_t)c->ld;
    z[m - 1] = pinned;
    const double s = ric_row_dot(m, v, z) * c->beta[vector];
    for (int j = 0; j < m; j++) z[j] -= s * v[j];
}

#endif
