/* The orbit nearest to a stored one (docs/theory.md section 11). Where a direction is hardly held
 * by the conditions of an orbit, a state that meets them to rounding may lie rounding over that
 * singular value beside it, and its multipliers are those of the replay, not of the orbit. This is
 * a diagnostic of how far they may be apart: nothing passes by it. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>

#include <lapacke.h>

#include "base/room.h"
#include "verify_parts.h"

/* HELD: of singular values, relative to the largest; below lie the branch itself, free modes and
 * the energy, which no impact changes, to the rounding of the derivatives */
#define HELD 1e-14
#define STEPS 8 /* of Newton; quadratic once the stored digits are left behind */
/* STILL: relative to the orbit. Steps become shorter until they are rounding, which is less: */
#define STILL 1e-12
/* NEAREST: what is farther, relative, than a fault that is looked for is another orbit */
#define NEAREST 1e-6

typedef struct {
    replay *r;
    int size;           /* of the square system: 2n + n_flight */
    double *J, *b, *sv; /* [size * size] by columns, [size], [size] singular values */
} nearest;

/* The derivative of gaps, over the norm, and of the end minus the start: column j of the state in
 * the energy norm, j < 2n, or of flight j - 2n. */
static void fill_column(const nearest *q, int j)
{
    const replay *r = q->r;
    const int n = r->n, N = r->n_flight, from = j < 2 * n ? 0 : j - 2 * n + 1;
    double *out = q->J + (size_t)j * (size_t)q->size;
    real column[2 * n];
    if (from) {
        const face_t *face = ric_replay_end_face(r, from - 1);
        real w[2 * n];
        memcpy(w, r->chain + (size_t)from * 2 * (size_t)n, sizeof w);
        ric_replay_reflect(r, face, w);
        ric_replay_delay_column(r, from - 1, w, column);
        out[from - 1] = (double)(face->side * ric_replay_dot(n, face->c, w + n));
    } else {
        memset(column, 0, sizeof column);
        column[j] = 1;
    }
    for (int k = from; k < N; k++) out[k] = (double)ric_replay_fly_column(r, k, false, column);
    for (int i = 0; i < 2 * n; i++) out[N + i] = (double)(column[i] - (i == j));
}

/* One step of Newton of least norm; its length relative to the orbit, NaN where there is none. */
static real take_step(const nearest *q)
{
    replay *r = q->r;
    const int n = r->n, N = r->n_flight, m = q->size;
    const real *end = r->chain + (size_t)N * 2 * (size_t)n;
    int rank;
    real length = 0;
    memset(q->J, 0, (size_t)m * (size_t)m * sizeof *q->J);
    for (int j = 0; j < m; j++) fill_column(q, j);
    for (int k = 0; k < N; k++)
        q->b[k] = (double)-ric_replay_gap(r, ric_replay_end_face(r, k),
                                          r->chain + (size_t)(k + 1) * 2 * (size_t)n);
    for (int i = 0; i < n; i++) {
        q->b[N + i] = (double)(r->kappa[i] * (r->chain[i] - end[i]));
        q->b[N + n + i] = (double)(r->chain[n + i] - end[n + i]);
    }
    if (ric_lapack(LAPACKE_dgelsd(LAPACK_COL_MAJOR, m, m, 1, q->J, m, q->b, m, q->sv, HELD, &rank)))
        return NAN;
    for (int i = 0; i < 2 * n; i++) r->chain[i] += q->b[i] / (i < n ? r->kappa[i] : 1);
    for (int k = 0; k < N; k++) r->tau[k] += q->b[2 * n + k];
    for (int j = 0; j < m; j++)
        length = fmax(length, fabs(q->b[j]) / (j < 2 * n ? r->norm : r->period));
    ric_replay_make_chain(r);
    return length;
}

ric_status ric_verify_nearest(replay *r, bool *found)
{
    const int n = r->n, N = r->n_flight, m = 2 * n + N;
    const size_t cells = (size_t)m * (size_t)m;
    nearest q = {.r = r, .size = m, .J = ric_malloc((cells + 2 * (size_t)m) * sizeof *q.J)};
    if (!q.J) return ric_no_memory("the orbit nearest to a stored one");
    q.b = q.J + cells;
    q.sv = q.b + m;
    real moved = 0, before, length = INFINITY;
    int steps = 0;
    do {
        before = length;
        moved += length = take_step(&q);
    } while (++steps < STEPS && length < before / 2 && moved <= NEAREST);
    *found = moved <= NEAREST && length <= STILL;
    free(q.J);
    return RIC_OK;
}
