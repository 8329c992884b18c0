#include "multiplicity.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <lapacke.h>

#include "status.h"

/* Singular values below this part of the largest are zero: junctions are located to about 1e-12, regular points beside them have 1e-3. */
#define ZERO 1e-6
#define LARGEST 400 /* rows of J; beyond it labels are left out */

/* One step of the staircase form: with V2 the kernel of A [size * size] and V1 its complement, A is similar to [[V1'A V1, 0], [*, 0]],
 * so its eigenvalues are those of V1'A V1 and as many zeros as the kernel has dimensions. A is replaced by V1'A V1.
 * Returns the dimension of the kernel, -1 if LAPACK fails. Better conditioned than ranks of powers (Kublanovskaya 1966). */
static int deflate(int size, double *A, double scale, double *work, double *V, double *s)
{
    int zero = 0;
    if (size == 0) return 0;
    memcpy(work, A, (size_t)size * size * sizeof *A);
    if (LAPACKE_dgesvd(LAPACK_ROW_MAJOR, 'N', 'A', size, size, work, size, s, NULL, 1, V, size, s + size)) return -1;
    for (int i = 0; i < size; i++) zero += s[i] <= ZERO * scale;
    int kept = size - zero;
    for (int i = 0; i < kept; i++) /* work = V1' A (rows of V are right singular vectors) */
        for (int j = 0; j < size; j++) {
            double sum = 0;
            for (int k = 0; k < size; k++) sum += V[i * size + k] * A[k * size + j];
            work[i * size + j] = sum;
        }
    for (int i = 0; i < kept; i++)
        for (int j = 0; j < kept; j++) {
            double sum = 0;
            for (int k = 0; k < size; k++) sum += work[i * size + k] * V[j * size + k];
            A[i * kept + j] = sum;
        }
    return zero;
}

/* J of eq. 29: unknowns w0, beta, T with tau_k = beta_k T; rows w_N - w_0, the N gaps, sum beta - 1. G: gaps then closure. */
static void article_jacobian(int n, int N, const double *tau, const double *G, double *J)
{
    int size = 2 * n + N + 1, unknowns = 2 * n + N;
    double T = 0;
    for (int k = 0; k < N; k++) T += tau[k];
    memset(J, 0, (size_t)size * size * sizeof *J);
    for (int r = 0; r < 2 * n + N; r++) {
        const double *g = G + (size_t)(r < 2 * n ? N + r : r - 2 * n) * unknowns;
        double *row = J + (size_t)r * size;
        memcpy(row, g, 2 * (size_t)n * sizeof *row);
        for (int k = 0; k < N; k++) {
            row[2 * n + k] = g[2 * n + k] * T;
            row[2 * n + N] += g[2 * n + k] * tau[k] / T;
        }
    }
    for (int k = 0; k < N; k++) J[(size_t)(size - 1) * size + 2 * n + k] = 1;
}

ric_status ric_multiplicity(const ric_model *m, const ric_cycle *cycle, int multiple, int *a, int *b)
{
    ric_status status = RIC_OK;
    int n = m->n, N = cycle->N * multiple, size = 2 * n + N + 1;
    ric_chain *chain = NULL;
    double *u = NULL, *G = NULL, *J = NULL, *V = NULL, *work = NULL, *s = NULL;
    ric_cycle *whole = NULL;
    *a = *b = 0;
    if (size > LARGEST) return RIC_OK;
    whole = ric_cycle_create(n, N);
    size_t square = (size_t)size * size;
    G = calloc((size_t)(2 * n + N + 2) * (size_t)(2 * n + N), sizeof *G);
    J = calloc(square, sizeof *J);
    V = calloc(square, sizeof *V);
    work = calloc(square, sizeof *work);
    s = calloc(2 * (size_t)size, sizeof *s);
    if (!whole || !G || !J || !V || !work || !s) {
        status = ric_fail(RIC_E_NOMEM, "no memory for the label of a junction");
        goto out;
    }
    for (int i = 0; i < N; i++) {
        whole->face[i] = cycle->face[i % cycle->N];
        whole->tau[i] = cycle->tau[i % cycle->N];
    }
    memcpy(whole->w, cycle->w, 2 * (size_t)n * sizeof *whole->w);
    if ((status = ric_cycle_to_chain(m, whole, &chain, &u))) goto out;
    ric_chain_jacobian(chain, u, G);
    article_jacobian(n, N, u + 2 * n, G, J);
    double scale = 0;
    for (int i = 0; i < size * size; i++) scale = fmax(scale, fabs(J[i]));
    for (int zero = 1; size > 0 && zero > 0; size -= zero) {
        zero = deflate(size, J, scale, work, V, s);
        if (zero < 0) {
            status = ric_fail(RIC_E_NUMERIC, "the label of a junction could not be computed");
            goto out;
        }
        if (!*b) *b = zero;
        *a += zero;
    }
out:
    ric_chain_free(chain);
    ric_cycle_free(whole);
    free(u);
    free(G);
    free(J);
    free(V);
    free(work);
    free(s);
    return status;
}
