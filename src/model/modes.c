#include "modes.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <lapacke.h>

#include "modal.h"
#include "base/room.h"

/* Of c.c: beyond it, and below its inverse, squares and products of three leave what a double can
 * hold. */
#define EXTREME 1e100
/* Frequencies closer than this (relative, in omega^2) may count as equal, where rounding of the
 * entries of M and K makes as much: their eigenvectors are not determined by M and K. */
#define EQUAL 1e-11
/* ROUNDINGS: of omega^2, by which equal ones differ in any case: 2e-13 of a state in a turn */
#define ROUNDINGS 512
/* TURNED: of a vector, the largest correction: what is left of it is its square, and squares of
 * that in the next steps */
#define TURNED 1e-2L
/* REFINED: largest n for which eigenpairs are refined: beyond it the cubic cost in long double is
 * felt */
#define REFINED 400

/* out = A X, of square matrices; row by row, which is how they lie in memory. */
static void multiply(int n, const double *A, const long double *X, long double *out)
{
    memset(out, 0, (size_t)n * (size_t)n * sizeof *out);
    for (int i = 0; i < n; i++)
        for (int k = 0; k < n; k++) {
            if (A[i * n + k] == 0) continue; /* chains and meshes are mostly zeros */
            for (int j = 0; j < n; j++) out[i * n + j] += A[i * n + k] * X[k * n + j];
        }
}

/* The same with sums of twice the digits of a double: of a low mode K x cancels by as much as the
 * highest mode is stiffer, 1e9 in a beam of short finite elements, and what rounding leaves of it
 * mixes the low modes. `room` [n * n]. */
static void multiply_twice(int n, const double *A, const long double *X, long double *out,
                           ric_twice *room)
{
    for (int i = 0; i < n * n; i++) room[i] = ric_twice_of(X[i]);
    for (int i = 0; i < n; i++) {
        ric_twice sum[n];
        memset(sum, 0, sizeof sum);
        for (int k = 0; k < n; k++) {
            const double a = A[i * n + k];
            if (a == 0) continue;
            for (int j = 0; j < n; j++)
                sum[j] = ric_twice_add(sum[j], ric_twice_scale(a, room[k * n + j]));
        }
        for (int j = 0; j < n; j++) out[i * n + j] = (long double)sum[j].hi + sum[j].lo;
    }
}

/* out = factor X' Y, and one more with `and_one`. */
static void multiply_transposed(int n, bool and_one, double factor, const long double *X,
                                const long double *Y, long double *out)
{
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) out[i * n + j] = and_one && i == j;
        for (int k = 0; k < n; k++)
            for (int j = 0; j < n; j++) out[i * n + j] += factor * X[k * n + i] * Y[k * n + j];
    }
}

/* X <- X (1 + factor S); `room` [n * n]. */
static void turn(int n, double factor, const long double *S, long double *X, long double *room)
{
    memcpy(room, X, (size_t)n * (size_t)n * sizeof *room);
    for (int i = 0; i < n; i++)
        for (int k = 0; k < n; k++)
            for (int j = 0; j < n; j++) room[i * n + j] += factor * X[i * n + k] * S[k * n + j];
    memcpy(X, room, (size_t)n * (size_t)n * sizeof *X);
}

/* Columns i and j of A [n * n] turned: c a_i - s a_j and s a_i + c a_j. */
static void turn_columns(int n, int i, int j, long double c, long double s, long double *A)
{
    for (int k = 0; k < n; k++) {
        const long double one = A[k * n + i], other = A[k * n + j];
        A[k * n + i] = c * one - s * other;
        A[k * n + j] = s * one + c * other;
    }
}

/* The same of rows. */
static void turn_rows(int n, int i, int j, long double c, long double s, long double *A)
{
    for (int k = 0; k < n; k++) {
        const long double one = A[i * n + k], other = A[j * n + k];
        A[i * n + k] = c * one - s * other;
        A[j * n + k] = s * one + c * other;
    }
}

/* A turn of two vectors of nearly equal frequencies by any angle (Jacobi), the lower one first,
 * that brings S = X' K X and R = 1 - X' M X along. LAPACK turns them by rounding over their
 * distance, which is a hundredth at 1e-13, in another way for each order of the coordinates; S has
 * the digits of a long double. What is one frequency is left as it is. */
static void turn_pair(int n, int i, int j, long double *X, long double *S, long double *R)
{
    const long double low = S[i * n + i] / (1 - R[i * n + i]),
                      high = S[j * n + j] / (1 - R[j * n + j]), size = fabsl(low) + fabsl(high),
                      across = 2 * S[i * n + j] + (low + high) * R[i * n + j];
    const long double apart = hypotl(high - low, across);
    if (!(apart <= EQUAL * size) || !(apart > ROUNDINGS * DBL_EPSILON * size / 2)) return;
    const long double angle = atan2l(across, high - low) / 2, c = cosl(angle), s = sinl(angle);
    turn_columns(n, i, j, c, s, X);
    turn_columns(n, i, j, c, s, S);
    turn_rows(n, i, j, c, s, S);
    turn_columns(n, i, j, c, s, R);
    turn_rows(n, i, j, c, s, R);
}

/* The corrections E of both vectors of a pair, from S = X' K X, which it replaces, and R = 1 - X' M
 * X. Vectors of equal frequencies are any that are orthonormal, and those of nearly equal ones may
 * be turned by more than a correction of first order can undo: they are only kept so here. */
static void correct_pair(int n, int i, int j, const long double *lambda, const long double *R,
                         long double *S)
{
    const int ij = i * n + j, ji = j * n + i;
    const long double gap = lambda[j] - lambda[i], one = (S[ij] + lambda[j] * R[ij]) / gap,
                      other = (S[ji] + lambda[i] * R[ji]) / -gap;
    const bool known = fabsl(gap) > EQUAL * (fabsl(lambda[i]) + fabsl(lambda[j])) &&
                       fabsl(one) <= TURNED && fabsl(other) <= TURNED;
    S[ij] = known ? one : R[ij] / 2;
    S[ji] = known ? other : R[ji] / 2;
}

/* One step of Ogita and Aishima (Japan J. Indust. Appl. Math. 35 (2018) 1007) for K X = M X Lambda
 * in long double: LAPACK's small eigenvalues are accurate relative to the largest one only, and a
 * period needs them relative to themselves. */
static void refine_once(const ric_model *m, int n, long double *X, long double *MX, long double *KX,
                        long double *R, long double *S, long double *lambda)
{
    multiply(n, m->M, X, MX);
    multiply_twice(n, m->K, X, KX, (ric_twice *)R);
    multiply_transposed(n, true, -1, X, MX, R);
    multiply_transposed(n, false, 1, X, KX, S);
    for (int i = 0; i < n; i++)
        for (int j = i + 1; j < n; j++) turn_pair(n, i, j, X, S, R);
    for (int i = 0; i < n; i++) lambda[i] = S[i * n + i] / (1 - R[i * n + i]);
    for (int i = 0; i < n; i++) { /* S becomes the correction E */
        S[i * n + i] = R[i * n + i] / 2;
        for (int j = i + 1; j < n; j++) correct_pair(n, i, j, lambda, R, S);
    }
    turn(n, 1, S, X, MX);
}

/* X <- X (1 + R/2), R = 1 - X' M X: orthonormal in M to the square of what was missing, whatever
 * the gaps between the frequencies (Newton and Schulz: Higham, Functions of Matrices, SIAM 2008,
 * section 8.3). A division by a gap leaves the vectors of a cluster off by rounding over that gap.
 */
static void orthonormalise(const ric_model *m, int n, long double *X, long double *MX,
                           long double *R)
{
    multiply(n, m->M, X, MX);
    multiply_transposed(n, true, -1, X, MX, R);
    turn(n, 0.5, R, X, MX);
}

static ric_status refine_modes(ric_model *m)
{
    int n = m->n_dof;
    size_t square = (size_t)n * (size_t)n;
    if (n > REFINED) return RIC_OK;
    long double *work = ric_calloc(5 * square + (size_t)n, sizeof *work);
    if (!work) return ric_fail(RIC_E_NOMEM, "no memory to refine %d modes", n);
    long double *lambda = work + 5 * square;
    for (size_t i = 0; i < square; i++) work[i] = m->Phi[i];
    for (int step = 0; step < 3; step++)
        refine_once(m, n, work, work + square, work + 2 * square, work + 3 * square,
                    work + 4 * square, lambda);
    for (int step = 0; step < 2; step++)
        orthonormalise(m, n, work, work + square, work + 2 * square);
    for (size_t i = 0; i < square; i++) m->Phi[i] = (double)work[i];
    for (int i = 0; i < n; i++) {
        m->frequency[i] = (double)lambda[i];
        m->frequency_low[i] = (double)(lambda[i] - m->frequency[i]);
    }
    free(work);
    return RIC_OK;
}

/* K phi = lambda M phi; rigid-body modes get exactly omega = 0. */
static ric_status eigenmodes(ric_model *m)
{
    ric_status status = RIC_OK;
    int n = m->n_dof;
    double *B = ric_calloc((size_t)n * (size_t)n, sizeof *B);
    if (!B) {
        status = ric_fail(RIC_E_NOMEM, "no memory for %d modes", n);
        goto out;
    }
    memcpy(m->Phi, m->K, (size_t)n * (size_t)n * sizeof *B);
    memcpy(B, m->M, (size_t)n * (size_t)n * sizeof *B);
    if (ric_lapack(
            LAPACKE_dsygv(LAPACK_ROW_MAJOR, 1, 'V', 'U', n, m->Phi, n, B, n, m->frequency))) {
        status = ric_fail(RIC_E_NUMERIC, "the eigenvalue problem of stiffness and mass could not "
                                         "be solved; are they scaled sensibly?");
        goto out;
    }
    if ((status = refine_modes(m))) goto out;
    double norm = 0;
    for (int i = 0; i < n * n; i++) norm = fmax(norm, fabs(m->K[i]));
    for (int i = 0; i < n; i++) {
        double lambda = m->frequency[i], phi2 = 0, rounding;
        for (int j = 0; j < n; j++) phi2 += m->Phi[j * n + i] * m->Phi[j * n + i];
        rounding = 16.0 * n * DBL_EPSILON * norm * phi2; /* of phi' K phi */
        if (lambda < -rounding) {
            status = ric_fail(RIC_E_INPUT,
                              "stiffness matrix is not positive semidefinite: mode %d has omega^2 "
                              "= %g; an unstable "
                              "structure has no free vibration about this equilibrium",
                              i + 1, lambda);
            goto out;
        }
        long double omega = lambda <= rounding ? 0
                                               : sqrtl((long double)lambda + m->frequency_low[i]);
        m->frequency[i] = (double)omega;
        m->frequency_low[i] = (double)(omega - m->frequency[i]); /* of omega, from here on */
    }
out:
    free(B);
    return status;
}

bool ric_modes_near(double lower, double upper)
{
    return !(upper - lower > EQUAL * upper);
}

static long double squared(const ric_model *m, int mode)
{
    const long double omega = (long double)m->frequency[mode] + m->frequency_low[mode];
    return omega * omega;
}

/* What one rounding of every entry of M and K makes of omega^2 of a mode. */
static double rounding_of(const ric_model *m, int mode)
{
    const int n = m->n_dof;
    const double lambda = m->frequency[mode] * m->frequency[mode];
    double sum = 0;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            sum += fabs(m->Phi[i * n + mode] * m->Phi[j * n + mode]) *
                   (fabs(m->K[i * n + j]) + lambda * fabs(m->M[i * n + j]));
    return DBL_EPSILON * sum;
}

/* Whether rounding alone may tell apart the frequencies of two modes, the lower one first. What is
 * taken for equal and is not, every orbit of these modes is off by: no more than that may be. */
static bool are_equal(const ric_model *m, int lower, int upper)
{
    const double square = (double)squared(m, upper),
                 gap = (double)(squared(m, upper) - squared(m, lower));
    if (!(gap <= EQUAL * square)) return false;
    return m->n_dof > REFINED || gap <= ROUNDINGS * DBL_EPSILON * square ||
           gap <= rounding_of(m, lower) + rounding_of(m, upper);
}

/* Modes first..last have one frequency from here on, that of their mean square, whatever their
 * basis is. */
static void join_frequencies(ric_model *m, int first, int last)
{
    long double sum = 0;
    for (int i = first; i <= last; i++) sum += squared(m, i);
    const long double omega = sqrtl(sum / (last - first + 1));
    for (int i = first; i <= last; i++) {
        m->frequency[i] = (double)omega;
        m->frequency_low[i] = (double)(omega - m->frequency[i]);
    }
}

/* Within modes first..last of one frequency, turns the basis by the right singular vectors of the
 * modal normals: the first rank(C) vectors are seen, the others are not (docs/theory.md section 1).
 */
static ric_status rotate_equal(ric_model *m, int first, int last)
{
    ric_status status = RIC_OK;
    int n = m->n_dof, k = last - first + 1, f = m->n_contact;
    double *C = ric_calloc((size_t)f * (size_t)k, sizeof *C),
           *V = ric_calloc((size_t)k * (size_t)k, sizeof *V);
    double *s = ric_calloc((size_t)(f > k ? f : k), sizeof *s),
           *row = ric_calloc((size_t)k, sizeof *row);
    double *super = ric_calloc((size_t)(f > k ? f : k), sizeof *super);
    if (!C || !V || !s || !row || !super) {
        status = ric_no_memory("equal frequencies");
        goto out;
    }
    for (int i = 0; i < f; i++)
        for (int j = 0; j < k; j++)
            for (int l = 0; l < n; l++) C[i * k + j] += m->b[i * n + l] * m->Phi[l * n + first + j];
    if (ric_lapack(
            LAPACKE_dgesvd(LAPACK_ROW_MAJOR, 'N', 'A', f, k, C, k, s, NULL, 1, V, k, super))) {
        status = ric_fail(RIC_E_NUMERIC, "equal frequencies could not be separated");
        goto out;
    }
    for (int l = 0; l < n; l++) {
        for (int j = 0; j < k; j++) row[j] = ric_dot(k, &V[j * k], &m->Phi[l * n + first]);
        memcpy(&m->Phi[l * n + first], row, (size_t)k * sizeof *row);
    }
out:
    free(C);
    free(V);
    free(s);
    free(row);
    free(super);
    return status;
}

static ric_status separate_equal(ric_model *m)
{
    ric_status status = RIC_OK;
    int n = m->n_dof;
    for (int i = 0, j; i < n && !status; i = j) {
        for (j = i + 1; j < n && are_equal(m, i, j); j++) continue;
        if (j - i == 1) continue;
        join_frequencies(m, i, j - 1);
        status = rotate_equal(m, i, j - 1);
    }
    return status;
}

/* The sign of an eigenvector is free: the component of largest modulus is made positive, so that
 * results do not depend on LAPACK. */
static void fix_signs(ric_model *m)
{
    int n = m->n_dof;
    for (int i = 0; i < n; i++) {
        int largest = 0;
        for (int j = 1; j < n; j++)
            if (fabs(m->Phi[j * n + i]) > fabs(m->Phi[largest * n + i]) * (1 + RIC_TIE))
                largest = j;
        if (m->Phi[largest * n + i] < 0)
            for (int j = 0; j < n; j++) m->Phi[j * n + i] = -m->Phi[j * n + i];
    }
}

static ric_status find_seen(ric_model *m)
{
    int n = m->n_dof;
    for (int f = 0; f < m->n_contact; f++) {
        double cc = 0;
        for (int i = 0; i < n; i++) {
            double c = 0;
            for (int j = 0; j < n; j++) c += m->b[f * n + j] * m->Phi[j * n + i];
            m->normal[f * n + i] = c;
            cc += c * c;
        }
        if (!(cc >= 1 / EXTREME && cc <= EXTREME))
            return ric_fail(RIC_E_INPUT,
                            "contact %d: c.c = b M^-1 b is %.3g, and %g to %g are taken; choose "
                            "another unit of mass, or divide normal and clearance by one number",
                            f + 1, cc, 1 / EXTREME, EXTREME);
        for (int i = 0; i < n; i++) {
            if (fabs(m->normal[f * n + i]) <= RIC_UNSEEN * sqrt(cc)) m->normal[f * n + i] = 0;
            else m->seen[i] = true;
        }
    }
    for (int i = 0; i < n; i++) m->n += m->seen[i];
    return RIC_OK;
}

/* Groups of modes that no contact joins vibrate independently: several conserved energies, no
 * isolated branches. */
static int count_parts(const ric_model *m)
{
    int n = m->n_dof, parts = 0; /* stays 0 without memory */
    bool *done = ric_calloc((size_t)n, sizeof *done),
         *queued = ric_calloc((size_t)n, sizeof *queued);
    int *queue = ric_calloc((size_t)n, sizeof *queue);
    if (!done || !queued || !queue) n = 0;
    for (int start = 0; start < n; start++) {
        if (!m->seen[start] || queued[start]) continue;
        int head = 0, tail = 0;
        queue[tail++] = start;
        queued[start] = true;
        parts++;
        while (head < tail) {
            int i = queue[head++];
            for (int f = 0; f < m->n_contact; f++) {
                if (m->normal[f * n + i] == 0) continue;
                for (int j = 0; j < n; j++)
                    if (m->normal[f * n + j] != 0 && !queued[j]) {
                        queued[j] = true;
                        queue[tail++] = j;
                    }
            }
        }
    }
    free(done);
    free(queued);
    free(queue);
    return parts;
}

ric_status ric_modes_find(ric_model *m)
{
    ric_status status = eigenmodes(m);
    if (!status) status = separate_equal(m);
    if (status) return status;
    fix_signs(m);
    return RIC_OK;
}

bool ric_modes_distinct(const ric_model *m)
{
    for (int i = 1; i < m->n_dof; i++)
        if (m->frequency[i - 1] == m->frequency[i] &&
            m->frequency_low[i - 1] == m->frequency_low[i])
            return false;
    return true;
}

bool ric_modes_take(ric_model *m, const ric_model *same)
{
    const size_t n = (size_t)m->n_dof, square = n * n * sizeof *m->M;
    if (same->n_dof != m->n_dof || memcmp(same->M, m->M, square) || memcmp(same->K, m->K, square) ||
        !ric_modes_distinct(same))
        return false;
    memcpy(m->frequency, same->frequency, n * sizeof *m->frequency);
    memcpy(m->frequency_low, same->frequency_low, n * sizeof *m->frequency_low);
    memcpy(m->Phi, same->Phi, square);
    return true;
}

ric_status ric_modes_see(ric_model *m)
{
    ric_status status = find_seen(m);
    if (status) return status;
    m->n_part = count_parts(m);
    return m->n_part ? RIC_OK : ric_no_memory("a model");
}

#define SAME_SHAPE                                                                                 \
    0.7 /* cosine of the angle between two shapes that are one mode: beyond half a right angle     \
         * another                                                                                 \
         */

/* phi_i . M phi_i' of mode i here and there. */
static double overlap(const ric_model *m, const ric_model *near, int i)
{
    const int n = m->n_dof;
    double sum = 0;
    for (int j = 0; j < n; j++)
        for (int k = 0; k < n; k++)
            sum += m->Phi[j * n + i] * m->M[j * n + k] * near->Phi[k * n + i];
    return sum;
}

ric_status ric_modes_orient(ric_model *m, const ric_model *near)
{
    const int n = m->n_dof;
    for (int i = 0; i < n; i++) {
        const double o = overlap(m, near, i);
        if (m->seen[i] != near->seen[i])
            return ric_fail(RIC_E_NUMERIC, "mode %d begins or ceases to be seen by the contacts",
                            i + 1);
        if (m->seen[i] && fabs(o) < SAME_SHAPE)
            return ric_fail(RIC_E_NUMERIC, "mode %d changes its place with another one", i + 1);
        if (o >= 0) continue;
        for (int j = 0; j < n; j++) m->Phi[j * n + i] = -m->Phi[j * n + i];
        for (int f = 0; f < m->n_contact; f++) m->normal[f * n + i] = -m->normal[f * n + i];
    }
    return RIC_OK;
}
