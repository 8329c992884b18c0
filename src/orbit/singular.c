#include "singular.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <lapacke.h>

#include "base/room.h"

ric_status ric_singular_create(ric_shooting *chain, bool left, ric_singular *q)
{
    size_t n = (size_t)chain->n_unknown, rows = (size_t)ric_shooting_rows(chain),
           side = rows > n ? rows : n;
    *q = (ric_singular){.chain = chain, .unknowns = chain->n_unknown};
    q->memory = ric_calloc(rows * n + n * n + (left ? rows * rows : 0) + 2 * side,
                           sizeof *q->memory);
    if (!q->memory) return ric_no_memory("a singular point");
    q->J = q->memory;
    q->right = q->J + rows * n;
    q->values = q->right + n * n;
    q->super = q->values + side;
    q->left = left ? q->super + side : NULL;
    return RIC_OK;
}

void ric_singular_free(ric_singular *q)
{
    free(q->memory);
    q->memory = NULL;
}

bool ric_singular_factor(ric_singular *q, const double *u)
{
    int n = q->unknowns, rows = q->equations = ric_shooting_jacobian(q->chain, u, q->J);
    return rows && !ric_lapack(LAPACKE_dgesvd(LAPACK_ROW_MAJOR, q->left ? 'A' : 'N', 'A', rows, n,
                                              q->J, n, q->values, q->left, q->left ? rows : 1,
                                              q->right, n, q->super));
}

int ric_singular_rank(const ric_singular *q, double least)
{
    int rank = 0, most = q->equations < q->unknowns ? q->equations : q->unknowns;
    while (rank < most && q->values[rank] > least * q->values[0]) rank++;
    return rank;
}

bool ric_singular_opens(const ric_singular *q, int k)
{
    int rank = q->unknowns - k;
    if (rank < 1 || rank > q->equations) return false;
    double first = rank < q->equations ? q->values[rank] : 0;
    return first <= RIC_RANK * q->values[0] && first <= RIC_RANK_GAP * q->values[rank - 1];
}

const double *ric_singular_kernel(const ric_singular *q, int k)
{
    return q->right + (size_t)(q->unknowns - k) * (size_t)q->unknowns;
}

int ric_singular_cokernel(const ric_singular *q, int k, double *out)
{
    int rank = q->unknowns - k, count = q->equations - rank;
    for (int i = 0; i < count; i++)
        for (int j = 0; j < q->equations; j++)
            out[i * q->equations + j] = q->left[j * q->equations + rank + i];
    return count;
}

void ric_singular_redundant(const ric_singular *q, double *out)
{
    int states = 2 * q->chain->n, first = q->equations - states;
    memset(out, 0, (size_t)first * sizeof *out);
    ric_shooting_mean_gradient(q->chain, out + first);
    double norm = sqrt(ric_dot(states, out + first, out + first));
    for (int i = first; i < q->equations; i++) out[i] /= norm;
}

double ric_singular_step(const ric_singular *q, int rank, const double *r, double *u)
{
    double rest = 0;
    for (int k = 0; k < q->equations; k++) {
        double part = 0;
        for (int j = 0; j < q->equations; j++) part += q->left[j * q->equations + k] * r[j];
        if (k >= rank) rest = hypot(rest, part);
        for (int j = 0; k < rank && j < q->unknowns; j++)
            u[j] -= part / q->values[k] * q->right[k * q->unknowns + j];
    }
    return rest;
}

bool ric_singular_bend(ric_singular *q, const double *u, const double *along, int n_left,
                       const double *left, int n_right, const double *right, double *out)
{
    int n = q->unknowns;
    double h = RIC_DIFFERENCE * q->chain->scale, v[n], row[ric_shooting_rows(q->chain)];
    memset(out, 0, (size_t)n_left * (size_t)n_right * sizeof *out);
    for (int side = -1; side <= 1; side += 2) {
        for (int i = 0; i < n; i++) v[i] = u[i] + side * h * along[i];
        ric_shooting_fly(q->chain, v);
        int equations = ric_shooting_jacobian(q->chain, v, q->J);
        if (!equations) return false;
        for (int k = 0; k < n_right; k++) {
            for (int e = 0; e < equations; e++) row[e] = ric_dot(n, q->J + e * n, right + k * n);
            for (int i = 0; i < n_left; i++)
                out[i * n_right + k] += side * ric_dot(equations, left + i * equations, row) /
                                        (2 * h);
        }
    }
    return true;
}

void ric_singular_orient(int size, double *t)
{
    int largest = 0;
    for (int i = 1; i < size; i++)
        if (fabs(t[i]) > fabs(t[largest]) * (1 + RIC_TIE_IN_KERNEL)) largest = i;
    double sign = t[largest] < 0 ? -1 : 1;
    for (int i = 0; i < size; i++) t[i] *= sign;
}
