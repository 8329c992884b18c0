/* What a period makes of a small error, and the stored orbit solved to the last digit before it is replayed
 * (verify.c). */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>

#include <lapacke.h>

#include "base/room.h"
#include "verify_parts.h"

#define SAME 1e-8 /* polishing stays within this of the stored orbit, relative; times of slow contacts weighed */
#define NO_EQUATION 1e-13 /* rows of the Jacobian smaller than this, of differences of numbers near 1, are rounding */
/* REGULAR: singular values below this part of the largest belong to the family and to the energy, not to the
 * polishing */
#define REGULAR 1e-9

real ric_replay_fly_column(const replay *r, int k, bool stretch, real *column)
{
    int n = r->n;
    const face_t *face = ric_replay_end_face(r, k);
    const real *w = r->chain + (size_t)(k + 1) * 2 * (size_t)n;
    const real *trig = r->trig + (size_t)k * 2 * (size_t)n;
    real t = r->tau[k], cq = 0, cp = 0, pull = 0;
    if (r->closed) {
        for (int i = 0; i < n; i++) column[i] /= r->kappa[i];
        ric_simulator_fly(r->sim, r->closed + (size_t)k * (size_t)r->n_face, true, t, column, column);
        for (int i = 0; i < n; i++) column[i] *= r->kappa[i];
        t = 0;
    }
    real force[n];
    ric_replay_accelerations(r, k, w, force);
    for (int i = 0; i < n; i++) {
        real omega = r->omega[i], a = column[i], p = column[n + i], cosine = r->closed ? 1 : trig[i],
             sine = r->closed ? 0 : trig[n + i];
        column[i] = omega > 0 ? a * cosine + p * sine : a + r->kappa[i] * t * p;
        column[n + i] = omega > 0 ? p * cosine - a * sine : p;
        cq += face->c[i] * column[i] / r->kappa[i];
        cp += face->c[i] * column[n + i];
        pull -= face->c[i] * force[i];
    }
    if (face->spring > 0) return face->side * cq;
    real dt = -cq / (face->side * fmax(r->speed[k + 1], BLUNT * ric_replay_fastest(r, face)));
    for (int i = 0; i < n; i++) {
        if (stretch) column[i] -= r->kappa[i] * 2 * cq / face->cc * face->c[i];
        column[n + i] += 2 * ((stretch ? dt * pull : 0) - cp) / face->cc * face->c[i];
    }
    return face->side * cq;
}

/* Divides by the largest entry and returns its logarithm, so that long products do not overflow. */
static real rescale(size_t size, real *A)
{
    real largest = 0;
    for (size_t i = 0; i < size; i++) largest = fmax(largest, fabs(A[i]));
    if (!(largest > 0)) return 0;
    for (size_t i = 0; i < size; i++) A[i] /= largest;
    return log(largest);
}

/* Rows of A [2n * 2n] become the columns of the derivative from impact `first` to the end, over e^x; returns x. */
static real multiply(const replay *r, int first, real *A)
{
    int m = 2 * r->n;
    real scale = 0;
    memset(A, 0, (size_t)m * (size_t)m * sizeof *A);
    for (int i = 0; i < m; i++) A[i * m + i] = 1;
    for (int k = first; k < r->n_event; k++) {
        for (int i = 0; i < m; i++) ric_replay_fly_column(r, k, true, A + i * m);
        scale += rescale((size_t)m * (size_t)m, A);
    }
    return scale;
}

ric_status ric_replay_condition(replay *r)
{
    ric_status status = RIC_OK;
    int m = 2 * r->n;
    size_t size = (size_t)m * (size_t)m;
    real *A = ric_calloc(size, sizeof *A), scale = 0, largest = 0;
    double *B = ric_calloc(size + 2 * (size_t)m, sizeof *B), *re = B ? B + size : NULL, *im = B ? re + m : NULL;
    if (!A || !B) {
        status = ric_fail(RIC_E_NOMEM, "no memory for the multipliers of %d degrees of freedom", r->n);
        goto out;
    }
    for (int first = r->n_event - 1; first >= 0; first--) {
        scale = multiply(r, first, A);
        r->amplification = fmax(r->amplification, scale + log((real)m));
    }
    for (size_t i = 0; i < size; i++) B[i] = (double)A[i];
    if (ric_lapack(LAPACKE_dgeev(LAPACK_ROW_MAJOR, 'N', 'N', m, B, m, re, im, NULL, 1, NULL, 1))) {
        status = ric_fail(RIC_E_NUMERIC, "the multipliers of branch %d, point %d could not be computed",
                          r->check->branch, r->check->point);
        goto out;
    }
    for (int i = 0; i < m; i++) largest = fmax(largest, hypot(re[i], im[i]));
    r->check->condition = (double)fmax(1, exp(fmin(700, scale + log(largest))));
out:
    free(A);
    free(B);
    return status;
}

real ric_replay_growth(const replay *r, int from, int to)
{
    int m = 2 * r->n;
    real column[m], most = 1;
    for (int first = from; first < to; first++)
        for (int j = 0; j < m; j++) {
            for (int i = 0; i < m; i++) column[i] = i == j;
            for (int k = first; k < to; k++) {
                ric_replay_fly_column(r, k, false, column);
                most = fmax(most, sqrt(ric_replay_dot(m, column, column)));
            }
        }
    return most;
}

/* -------------------------------------------------------------------- polish */

/* Residuals [n_flight + 2n]: gaps at the ends of the flights, then w_N - w_0 in the energy norm. */
static void residuals(const replay *r, double *F)
{
    int n = r->n, N = r->n_flight;
    for (int k = 0; k < N; k++)
        F[k] = (double)ric_replay_gap(r, ric_replay_end_face(r, k), r->chain + (size_t)(k + 1) * 2 * (size_t)n);
    for (int i = 0; i < n; i++) {
        const real *first = r->chain, *last = r->chain + (size_t)N * 2 * (size_t)n;
        F[N + i] = (double)(r->kappa[i] * (last[i] - first[i]));
        F[N + n + i] = (double)(last[n + i] - first[n + i]);
    }
}

/* Column of the derivatives of the residuals along a column that starts behind flight k - 1
 * (k = 0: the initial state). */
static void carry_column(const replay *r, int k, int j, int m, real *column, double *J)
{
    int N = r->n_flight;
    for (; k < N; k++) J[k * m + j] = (double)ric_replay_fly_column(r, k, false, column);
    for (int i = 0; i < 2 * r->n; i++) J[(N + i) * m + j] = (double)column[i];
}

/* Later by dt: dw = R f(w) dt, f taken before the impact. */
void ric_replay_delay_column(const replay *r, int k, const real *w, real *column)
{
    int n = r->n;
    const face_t *face = ric_replay_end_face(r, k);
    real cf = 0;
    ric_replay_accelerations(r, k, w, column + n);
    for (int i = 0; i < n; i++) {
        column[i] = r->kappa[i] * w[n + i];
        cf += face->c[i] * column[n + i];
    }
    for (int i = 0; i < n && !(face->spring > 0); i++) column[n + i] -= 2 * cf / face->cc * face->c[i];
}

/* J [m * m], m = n_flight + 2n; unknowns in the order flight times, initial state. */
static void jacobian(const replay *r, real *column, double *J)
{
    int n = r->n, N = r->n_flight, m = N + 2 * n;
    for (int k = 0; k < N; k++) {
        const face_t *face = ric_replay_end_face(r, k);
        real *w = column + 2 * n;
        memcpy(w, r->chain + (size_t)(k + 1) * 2 * (size_t)n, 2 * (size_t)n * sizeof *w);
        ric_replay_reflect(r, face, w);
        J[k * m + k] = (double)(face->side * ric_replay_dot(n, face->c, w + n));
        ric_replay_delay_column(r, k, w, column);
        carry_column(r, k + 1, k, m, column, J);
    }
    for (int j = 0; j < 2 * n; j++) {
        memset(column, 0, 2 * (size_t)n * sizeof *column);
        column[j] = 1;
        carry_column(r, 0, N + j, m, column, J);
        J[(N + j) * m + N + j] -= 1;
    }
}

/* The momentum of a rigid motion that no contact sees is kept whatever the orbit: such a row says nothing, and goes.
 * Divides the rows of J [m * m] and F by the norms of the rows, and the columns of the N flight times by theirs: a time
 * then counts as much as the way that it is flown, singular values compare like with like, and the shortest correction
 * is one of the state. */
static void equilibrate(int m, int N, double *J, double *F, double *columns)
{
    for (int i = 0; i < m; i++) {
        double sum = 0;
        for (int j = 0; j < m; j++) sum += J[i * m + j] * J[i * m + j];
        double scale = sum > NO_EQUATION * NO_EQUATION ? 1 / sqrt(sum) : 0;
        for (int j = 0; j < m; j++) J[i * m + j] *= scale;
        F[i] *= scale;
    }
    for (int j = 0; j < m; j++) {
        double sum = 0;
        for (int i = 0; i < m; i++) sum += J[i * m + j] * J[i * m + j];
        columns[j] = sum > 0 && j < N ? 1 / sqrt(sum) : 1;
        for (int i = 0; i < m; i++) J[i * m + j] *= columns[j];
    }
}

/* Largest relative residual of the stored orbit: gaps over clearances, closure over the state. */
static double largest_residual(const replay *r)
{
    double largest = ric_replay_part(ric_replay_distance(r, r->chain + (size_t)r->n_flight * 2 * (size_t)r->n,
                                                         r->chain),
                                     r->norm);
    for (int k = 0; k < r->n_flight; k++) {
        const face_t *face = ric_replay_end_face(r, k);
        ric_replay_worsen(&largest,
                          (double)(fabs(ric_replay_gap(r, face, r->chain + (size_t)(k + 1) * 2 * (size_t)r->n)) /
                                   face->limit));
    }
    return largest;
}

/* Through a row of stiff springs even the rounding of extended precision grows beyond what is compared. There every
 * flight starts from a state of its own, chain[k], and what it ends with, ends[k], is joined to the next by Newton's
 * method: the breaks between them are carried to the residuals (condensing: Bock and Plitt 1984), so that its equations
 * remain those of one chain. */
static void fly_apart(replay *r, real *ends)
{
    size_t step = 2 * (size_t)r->n;
    for (int k = 0; k < r->n_flight; k++) {
        ric_replay_fly(r, k, r->tau[k], r->chain + (size_t)k * step, ends + (size_t)k * step);
        r->speed[k + 1] = ric_replay_reflect(r, ric_replay_end_face(r, k), ends + (size_t)k * step);
    }
    memcpy(r->chain + (size_t)r->n_flight * step, ends + (size_t)(r->n_flight - 1) * step, step * sizeof *ends);
}

/* column += what lies between the end of a flight and the state behind it, `next`. */
static void add_break(const replay *r, const real *end, const real *next, real *column)
{
    for (int i = 0; i < r->n; i++) {
        column[i] += r->kappa[i] * (end[i] - next[i]);
        column[r->n + i] += end[r->n + i] - next[r->n + i];
    }
}

/* The residuals of flights that are apart, in the place of those of one chain. */
static void residuals_apart(const replay *r, const real *ends, real *column, double *F)
{
    int n = r->n, N = r->n_flight;
    memset(column, 0, 2 * (size_t)n * sizeof *column);
    for (int k = 0; k < N; k++) {
        const real *end = ends + (size_t)k * 2 * (size_t)n;
        F[k] = (double)(ric_replay_gap(r, ric_replay_end_face(r, k), end) + ric_replay_fly_column(r, k, false, column));
        add_break(r, end, k + 1 < N ? r->chain + (size_t)(k + 1) * 2 * (size_t)n : r->chain, column);
    }
    for (int i = 0; i < 2 * n; i++) F[N + i] = (double)column[i];
}

/* The correction -F of one chain moves all states; the times move afterwards. */
static void correct_apart(replay *r, const double *F, real *ends, real *column)
{
    int n = r->n, N = r->n_flight;
    real force[n], moved[2 * n];
    for (int i = 0; i < 2 * n; i++) column[i] = -F[N + i];
    for (int k = 0; k < N; k++) {
        real *w = r->chain + (size_t)k * 2 * (size_t)n;
        const real *end = ends + (size_t)k * 2 * (size_t)n;
        memcpy(moved, column, sizeof moved);
        ric_replay_fly_column(r, k, false, column);
        ric_replay_accelerations(r, k, end, force);
        for (int i = 0; i < n; i++) {
            column[i] -= F[k] * r->kappa[i] * end[n + i];
            column[n + i] -= F[k] * force[i];
        }
        add_break(r, end, w + 2 * n, column);
        for (int i = 0; i < n; i++) {
            w[i] += moved[i] / r->kappa[i];
            w[n + i] += moved[n + i];
        }
    }
    for (int k = 0; k < N; k++) r->tau[k] -= F[k];
    fly_apart(r, ends);
}

/* Where springs alone are met: between a stop and the next event the time of a flight would have to go through the
 * impact. */
static bool goes_apart(const replay *r)
{
    bool springs = r->closed;
    for (int k = 0; k < r->n_flight; k++) springs = springs && ric_replay_end_face(r, k)->spring > 0;
    return springs;
}

/* How far polishing has moved the flight times, relative to a mean flight. What a slow contact of a spring leaves
 * uncertain is its time. */
static real times_moved(const replay *r, const real *kept, bool weighed)
{
    real moved = 0;
    int N = r->n_flight;
    for (int k = 0; k < N; k++) {
        real late = fabs(r->tau[k] - kept[k]), least = 1;
        for (int end = 0; weighed && end < 2; end++) {
            int last = (k + N - end) % N; /* end = 1: the flight whose end is the start of this one */
            least = fmin(least,
                         fabs(r->speed[last + 1]) / (SLOW * ric_replay_fastest(r, ric_replay_end_face(r, last))));
        }
        moved = fmax(moved, least * late / (r->period / N));
    }
    return moved;
}

ric_status ric_replay_polish(replay *r, bool keep)
{
    enum { STEPS = 3 };
    ric_status status = RIC_OK;
    int n = r->n, N = r->n_flight, m = N + 2 * n, rank;
    size_t size = (size_t)m * (size_t)m;
    double *J = ric_calloc(size + 3 * (size_t)m, sizeof *J), *F = J ? J + size : NULL, *values = J ? F + m : NULL,
           *columns = J ? values + m : NULL;
    real *column = ric_calloc(4 * (size_t)n + (size_t)m + 2 * (size_t)n * (size_t)N, sizeof *column),
         *kept = column ? column + 4 * n : NULL, moved = 0;
    real *ends = column ? kept + m : NULL;
    bool apart = goes_apart(r);
    if (!J || !column) {
        status = ric_fail(RIC_E_NOMEM, "no memory to polish an orbit of %d flights", N);
        goto out;
    }
    double left_open = largest_residual(r);
    memcpy(kept, r->tau, (size_t)N * sizeof *kept);
    memcpy(kept + N, r->chain, 2 * (size_t)n * sizeof *kept);
    if (apart) fly_apart(r, ends);
    for (int step = 0; step < STEPS; step++) {
        memset(J, 0, size * sizeof *J);
        jacobian(r, column, J);
        if (apart) residuals_apart(r, ends, column, F);
        else residuals(r, F);
        equilibrate(m, N, J, F, columns);
        if (ric_lapack(LAPACKE_dgelsd(LAPACK_ROW_MAJOR, m, m, 1, J, m, F, 1, values, REGULAR, &rank))) {
            status = ric_fail(RIC_E_NUMERIC, "branch %d, point %d could not be polished", r->check->branch,
                              r->check->point);
            goto out;
        }
        for (int j = 0; j < m; j++) F[j] *= columns[j];
        if (apart) {
            correct_apart(r, F, ends, column);
            continue;
        }
        for (int k = 0; k < N; k++) r->tau[k] -= F[k];
        for (int i = 0; i < n; i++) {
            r->chain[i] -= F[N + i] / r->kappa[i];
            r->chain[n + i] -= F[N + n + i];
        }
        ric_replay_make_chain(r);
    }
    real aside = ric_replay_distance(r, r->chain, kept + N) / r->norm;
    moved = fmax(times_moved(r, kept, r->closed), aside);
    /* through stiff springs the residual may be the rounding of the stored displacements times their stiffness, and
     * beside a branch point the correction is rounding over the distance from it: the orbit is right if either is
     * small */
    ric_replay_worsen(&r->check->flight_error,
                      r->closed ? fmin(left_open, (double)fmax(times_moved(r, kept, true), aside)) : left_open);
    if (keep && moved <= SAME) goto out;
    memcpy(r->tau, kept, (size_t)N * sizeof *kept);
    memcpy(r->chain, kept + N, 2 * (size_t)n * sizeof *kept);
    ric_replay_make_chain(r);
out:
    free(J);
    free(column);
    return status;
}
