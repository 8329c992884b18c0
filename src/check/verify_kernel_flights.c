/* The equations of an orbit between stops and springs. Unknowns are the states behind all events
 * and the times of all flights, so that nothing is divided by the speed of an impact, and no growth
 * is multiplied up: beside a slow contact the matrix is as well conditioned as elsewhere. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>

#include "base/room.h"
#include "verify_kernel.h"
#include "verify_parts.h"

typedef struct {
    const replay *r;
    int n_seen, size; /* size: (2 n_seen + 1) n_flight */
    const real *share;
    double *unit; /* [n_flight] time in which the state at its end moves by one */
} chain;

/* Of a column (kappa q, p) over the modes what lies along the directions that contacts see. */
static void put_state(const chain *q, const real *column, ric_number *out)
{
    const int n = q->r->n, s = q->n_seen;
    for (int i = 0; i < 2 * s; i++)
        out[i] = (double)ric_replay_dot(n, q->share + i % s * n, column + (i < s ? 0 : n));
}

static void fill_flight(const chain *q, int k, ric_number *J, ric_number turn)
{
    const replay *r = q->r;
    const int n = r->n, s = q->n_seen, rows = 2 * s + 1, last = k == r->n_flight - 1;
    const face_t *face = ric_replay_end_face(r, k);
    const double length = (double)ric_replay_lever(r, face);
    const size_t ld = (size_t)q->size + 1;
    ric_number *block = J + (size_t)(k * rows) * ld + k * rows;
    real column[2 * n], w[2 * n];
    for (int j = 0; j < 2 * s; j++) {
        memset(column, 0, sizeof column);
        memcpy(column + (j < s ? 0 : n), q->share + j % s * n, (size_t)n * sizeof *column);
        ric_number *to = block + (size_t)j * ld;
        to[2 * s] = (double)ric_replay_fly_column(r, k, false, column) / length;
        put_state(q, column, to);
        /* the start of the next flight is its end */
        J[(size_t)((last ? 0 : k + 1) * rows + j) * ld + (size_t)(k * rows + j)] -= last ? turn : 1;
    }
    memcpy(w, r->chain + (size_t)(k + 1) * 2 * (size_t)n, sizeof w);
    ric_replay_reflect(r, face, w);
    ric_replay_delay_column(r, k, w, column);
    const real unit = 1 / sqrt(ric_replay_dot(2 * n, column, column));
    for (int i = 0; i < 2 * n; i++) column[i] *= unit;
    ric_number *to = block + (size_t)(2 * s) * ld;
    put_state(q, column, to);
    to[2 * s] = (double)(unit * face->side * ric_replay_dot(n, face->c, w + n)) / length;
    q->unit[k] = (double)unit;
}

/* Of the energy, as the last row: over the norm. */
static void fill_energy(const chain *q, ric_number *J)
{
    const replay *r = q->r;
    const int n = r->n, s = q->n_seen;
    real gradient[2 * n], force[n], norm;
    ric_replay_accelerations(r, 0, r->chain, force);
    for (int i = 0; i < n; i++) {
        gradient[i] = -force[i] / r->kappa[i];
        gradient[n + i] = r->chain[n + i];
    }
    norm = sqrt(ric_replay_dot(2 * n, gradient, gradient));
    ric_number row[2 * s];
    put_state(q, gradient, row);
    for (int j = 0; j < 2 * s; j++)
        J[(size_t)j * ((size_t)q->size + 1) + (size_t)q->size] = row[j] / (double)norm;
}

/* Of the period, likewise. */
static void fill_period(const chain *q, ric_number *J)
{
    const int rows = 2 * q->n_seen + 1;
    double norm = 0;
    for (int k = 0; k < q->r->n_flight; k++) norm = hypot(norm, q->unit[k]);
    for (int k = 0; k < q->r->n_flight; k++)
        J[(size_t)(k * rows + rows - 1) * ((size_t)q->size + 1) + (size_t)q->size] = q->unit[k] /
                                                                                     norm;
}

/* What the flights leave open at their faces and at the end: the orbit is off by as much. */
static double left_open(const chain *q)
{
    const replay *r = q->r;
    const size_t step = 2 * (size_t)r->n;
    double open = (double)ric_replay_distance(r, r->chain + (size_t)r->n_flight * step, r->chain);
    for (int k = 0; k < r->n_flight; k++) {
        const face_t *face = ric_replay_end_face(r, k);
        const real gap = ric_replay_gap(r, face, r->chain + (size_t)(k + 1) * step);
        open = fmax(open, (double)fabs(gap) / (double)ric_replay_lever(r, face));
    }
    return open / (double)r->norm;
}

static void fill(const ric_equations *of, ric_number *J, ric_number turn, ric_still row)
{
    const chain *q = of->of;
    for (int k = 0; k < q->r->n_flight; k++) fill_flight(q, k, J, turn);
    if (row == RIC_STILL_ENERGY) fill_energy(q, J);
    if (row == RIC_STILL_PERIOD) fill_period(q, J);
}

ric_status ric_verify_kind(const replay *r, const ric_junction *j, ric_claims *out)
{
    const int n = r->n;
    int seen[n];
    real share[(n + 1) * n];
    if (!ric_verify_kernel_tells(j->kind)) return RIC_OK;
    double *unit = ric_malloc((size_t)r->n_flight * sizeof *unit);
    if (!unit) return ric_no_memory("the flights of a junction");
    chain q = {.r = r, .n_seen = ric_verify_seen(r, seen, share), .share = share, .unit = unit};
    q.size = r->n_event ? (2 * q.n_seen + 1) * r->n_flight : 0;
    const ric_equations of = {.size = q.size,
                              .open = r->n_event ? left_open(&q) : 0,
                              .of = &q,
                              .fill = fill};
    const ric_status status = ric_verify_kernel(&of, j, out);
    free(unit);
    return status;
}
