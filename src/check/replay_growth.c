/* What a period makes of a small error (verify.c). */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>

#include <lapacke.h>

#include "base/room.h"
#include "verify_parts.h"

real ric_replay_fly_column(const replay *r, int k, bool stretch, real *column)
{
    int n = r->n;
    const face_t *face = ric_replay_end_face(r, k);
    const real *w = r->chain + (size_t)(k + 1) * 2 * (size_t)n;
    const real *trig = r->trig + (size_t)k * 2 * (size_t)n;
    real t = r->tau[k], cq = 0, cp = 0, pull = 0;
    if (r->closed) {
        for (int i = 0; i < n; i++) column[i] /= r->kappa[i];
        ric_simulator_fly(r->sim, r->closed + (size_t)k * (size_t)r->n_face, true, t, column,
                          column);
        for (int i = 0; i < n; i++) column[i] *= r->kappa[i];
        t = 0;
    }
    real force[n];
    ric_replay_accelerations(r, k, w, force);
    for (int i = 0; i < n; i++) {
        real omega = r->omega[i], a = column[i], p = column[n + i],
             cosine = r->closed ? 1 : trig[i], sine = r->closed ? 0 : trig[n + i];
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

void ric_replay_fly_row(const replay *r, int k, real *row)
{
    const int n = r->n;
    const face_t *face = ric_replay_end_face(r, k);
    const real *w = r->chain + (size_t)(k + 1) * 2 * (size_t)n,
               *trig = r->trig + (size_t)k * 2 * (size_t)n;
    if (!(face->spring > 0)) {
        const real pull = face->side * ric_replay_pull(r, k, face, w),
                   speed = face->side * fmax(r->speed[k + 1], BLUNT * ric_replay_fastest(r, face));
        real moved = 0, kicked = 0;
        for (int i = 0; i < n; i++) {
            moved += row[i] * r->kappa[i] * face->c[i];
            kicked += row[n + i] * face->c[i];
        }
        for (int i = 0; i < n; i++) {
            row[i] -= 2 * (moved + kicked * pull / speed) / face->cc * face->c[i] / r->kappa[i];
            row[n + i] -= 2 * kicked / face->cc * face->c[i];
        }
    }
    if (r->closed) {
        for (int i = 0; i < n; i++) row[i] *= r->kappa[i];
        ric_simulator_fly_back(r->sim, r->closed + (size_t)k * (size_t)r->n_face, r->tau[k], row);
        for (int i = 0; i < n; i++) row[i] /= r->kappa[i];
        return;
    }
    for (int i = 0; i < n; i++) {
        const bool turns = r->omega[i] > 0;
        const real a = row[i], p = row[n + i], cosine = trig[i], sine = trig[n + i];
        row[i] = turns ? a * cosine - p * sine : a;
        row[n + i] = turns ? p * cosine + a * sine : p + r->kappa[i] * r->tau[k] * a;
    }
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

/* A [2n * 2n] becomes the monodromy over e^x, and x is returned; *most: the largest such x of all
 * ends of the period, each from some flight on. */
static real multiply(const replay *r, real *A, real *most)
{
    const int m = 2 * r->n;
    real scale = 0;
    memset(A, 0, (size_t)m * (size_t)m * sizeof *A);
    for (int i = 0; i < m; i++) A[i * m + i] = 1;
    for (int k = r->n_event - 1; k >= 0; k--) {
        for (int i = 0; i < m; i++) ric_replay_fly_row(r, k, A + i * m);
        scale += rescale((size_t)m * (size_t)m, A);
        *most = fmax(*most, scale);
    }
    return scale;
}

ric_status ric_replay_condition(replay *r)
{
    ric_status status = RIC_OK;
    int m = 2 * r->n;
    size_t size = (size_t)m * (size_t)m;
    real *A = ric_calloc(size, sizeof *A), scale, most = -INFINITY, largest = 0;
    double *B = ric_calloc(size + 2 * (size_t)m, sizeof *B), *re = B ? B + size : NULL,
           *im = B ? re + m : NULL;
    if (!A || !B) {
        status = ric_fail(RIC_E_NOMEM, "no memory for the multipliers of %d degrees of freedom",
                          r->n);
        goto out;
    }
    scale = multiply(r, A, &most);
    r->amplification = fmax(r->amplification, most + log((real)m));
    for (size_t i = 0; i < size; i++) B[i] = (double)A[i];
    if (ric_lapack(LAPACKE_dgeev(LAPACK_ROW_MAJOR, 'N', 'N', m, B, m, re, im, NULL, 1, NULL, 1))) {
        status = ric_fail(RIC_E_NUMERIC,
                          "the multipliers of branch %d, point %d could not be computed",
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
    for (int i = 0; i < n && !(face->spring > 0); i++)
        column[n + i] -= 2 * cf / face->cc * face->c[i];
}
