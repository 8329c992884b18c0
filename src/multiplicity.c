#include "multiplicity.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <lapacke.h>

#include "status.h"

/* Error of the singular values of J, relative to its largest entry: rounding of the entries and of the decomposition.
 * What vanishes for a reason stays below it. A deflation divides the error of all others by the smallest singular value
 * that is kept, as it turns the two subspaces by that much. */
#define ERROR (4 * DBL_EPSILON)
#define PLACED 1e-9 /* a junction that is known less exactly than this has no ranks */
#define CLEAR 30    /* a singular value above the error by this factor is none of a zero; in between nobody can tell */
#define LOST (-2)
#define NO_NUMBER (-1)
#define LARGEST 400 /* rows of J; beyond it labels are those of the kind */

/* What the kind of a junction lets expect (docs/theory.md section 7). */
static void expected(const ric_node *node, int *a, int *b)
{
    bool half = node->cycle->half, extremum = node->kind == RIC_KIND_EXTREMUM;
    *b = extremum ? 1 : 2;
    /* with one flight its time fraction is fixed */
    *a = half || (extremum && ric_cycle_letters(node->cycle) < 2) ? 3 : 2;
    if (node->kind != RIC_KIND_MULTIPLICATION) return;
    bool doubling = node->multiple == 2 && !half;
    *b = doubling ? 2 : 3;
    *a = doubling && ric_cycle_letters(node->cycle) > 0 ? 2 : 3; /* without impacts the doubled orbit is one flight,
                                                                  * too */
}

/* One step of the staircase form: with V2 the kernel of A [size * size] and V1 its complement, A is similar to
 * [[V1'A V1, 0], [*, 0]], so its eigenvalues are those of V1'A V1 and as many zeros as the kernel has dimensions. A is
 * replaced by V1'A V1. Returns the dimension of the kernel, or what is wrong. Better conditioned than ranks of powers
 * (Kublanovskaya 1966). Relative to scale, singular values are zero up to `zero_at`; *error is that of the others, then
 * that of the next A. */
static int deflate(int size, double *A, double scale, double zero_at, double *error, double *work, double *V, double *s)
{
    int zero = 0;
    if (size == 0) return 0;
    memcpy(work, A, (size_t)size * size * sizeof *A);
    if (ric_lapack(LAPACKE_dgesvd(LAPACK_ROW_MAJOR, 'N', 'A', size, size, work, size, s, NULL, 1, V, size, s + size)))
        return NO_NUMBER;
    for (int i = 0; i < size; i++) zero += s[i] <= zero_at * scale;
    int kept = size - zero;
    if (kept == 0 || s[kept - 1] < CLEAR * *error * scale) return LOST;
    *error *= fmax(1, scale / s[kept - 1]);
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

/* J of eq. 29: unknowns w0, beta, T with tau_k = beta_k T; rows w_N - w_0, the N gaps, sum beta - 1. G: gaps then
 * closure. Under a power law N = 1 and the phase condition takes the place of the gap. */
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

/* The place of a junction is known to what is left of the singular values that vanish there, `b` of them at least. */
static double located(int size, const double *J, double scale, int b, double rounding, double *work, double *s)
{
    memcpy(work, J, (size_t)size * size * sizeof *J);
    if (ric_lapack(LAPACKE_dgesvd(LAPACK_ROW_MAJOR, 'N', 'N', size, size, work, size, s, NULL, 1, NULL, 1, s + size)))
        return HUGE_VAL;
    return fmax(rounding, s[size - b] / scale);
}

/* Entries that are rounding are zeros: balanced with others of a block they would be made as large. */
static void clear(int size, double rounding, double *J)
{
    double scale = 0;
    for (int i = 0; i < size * size; i++) scale = fmax(scale, fabs(J[i]));
    for (int i = 0; i < size * size; i++)
        if (fabs(J[i]) <= rounding * scale) J[i] = 0;
}

/* ERROR; under a power law a flight adds up that of its steps, in proportion to the angle turned (chain.c). */
static double rounding_of(const ric_model *m, const ric_cycle *whole)
{
    int n = 2 * m->n;
    double rate[n];
    if (!m->smooth) return ERROR;
    ric_flight_rate(m, 0, whole->w, rate);
    return ERROR * (1 + ric_cycle_period(whole) * sqrt(ric_dot(n, rate, rate) / (1 + ric_dot(n, whole->w, whole->w))));
}

/* Both multiplicities from the ranks; *decided = false where one of them is lost in rounding: two different points lie
 * so close together that both seem to be in one place, or the orbit is too long for a dense matrix. `least`: of b. */
static ric_status measure(const ric_model *m, const ric_cycle *cycle, int multiple, int least, int *a, int *b,
                          bool *decided)
{
    ric_status status = RIC_OK;
    int n = m->n, N = m->smooth ? 1 : cycle->N * multiple, size = 2 * n + N + 1;
    ric_chain *chain = NULL;
    double *u = NULL, *G = NULL, *J = NULL, *V = NULL, *work = NULL, *s = NULL;
    ric_cycle *whole = NULL;
    *a = *b = 0;
    *decided = false;
    if (size > LARGEST) return RIC_OK;
    whole = m->smooth ? ric_cycle_repeat(cycle, multiple) : ric_cycle_create(n, N);
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
    for (int i = 0; i < N && !m->smooth; i++) {
        whole->face[i] = cycle->face[i % cycle->N];
        whole->tau[i] = cycle->tau[i % cycle->N];
    }
    memcpy(whole->w, cycle->w, 2 * (size_t)n * sizeof *whole->w);
    whole->closed = cycle->closed;
    whole->parts = 0;
    if ((status = ric_cycle_to_chain(m, whole, &chain, &u))) goto out;
    chain->plain = true; /* the article's equations, of which the multiplicities are */
    ric_chain_jacobian(chain, u, G);
    article_jacobian(n, N, u + 2 * n, G, J);
    double scale = 0, rounding = rounding_of(m, whole);
    lapack_int low, high; /* springs make entries of all sizes; a similarity by a diagonal matrix evens them out */
    if (m->springs) clear(size, rounding, J);
    if (m->springs && ric_lapack(LAPACKE_dgebal(LAPACK_ROW_MAJOR, 'S', size, J, size, &low, &high, s))) {
        status = ric_fail(RIC_E_NUMERIC, "the label of a junction could not be computed");
        goto out;
    }
    for (int i = 0; i < size * size; i++) scale = fmax(scale, fabs(J[i]));
    double zero_at = located(size, J, scale, least, rounding, work, s), error = zero_at;
    if (zero_at > PLACED) goto out;
    for (int zero = 1; size > 0 && zero > 0; size -= zero) {
        zero = deflate(size, J, scale, zero_at, &error, work, V, s);
        zero_at = rounding; /* what the place of the junction leaves open is in the error, and no zero */
        if (zero == NO_NUMBER) status = ric_fail(RIC_E_NUMERIC, "the label of a junction could not be computed");
        if (zero < 0) goto out;
        if (!*b) *b = zero;
        *a += zero;
    }
    *decided = *b > 0;
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

ric_status ric_multiplicity(const ric_model *m, const ric_node *node, int *a, int *b, bool *decided)
{
    int kind_a, kind_b;
    expected(node, &kind_a, &kind_b);
    ric_status status = measure(m, node->cycle, node->multiple, kind_b, a, b, decided);
    if (status || (*decided && *a >= kind_a && *b >= kind_b)) return status;
    *decided = false; /* a kind has no less than that: what was kept was rounding */
    *a = kind_a;
    *b = kind_b;
    return RIC_OK;
}
