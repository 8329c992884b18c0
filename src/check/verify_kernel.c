/* What makes an orbit a junction, told by the derivatives of its equations (docs/theory.md section
 * 11). Unknowns are the states behind all events and the times of all flights, so that nothing is
 * divided by the speed of an impact, and no growth is multiplied up: beside a slow contact the
 * matrix is as well conditioned as elsewhere. */
#include <complex.h>
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>

#define lapack_complex_double double _Complex
#define lapack_complex_float float _Complex
#include <lapacke.h>

#include "base/room.h"
#include "verify_parts.h"

/* ROUNDING: of a matrix relative to its norm, and of the orbit over what holds it. Measured, not
 * derived: of 3,600 junctions of 180 random structures none needs more; a 16th is not enough */
#define ROUNDING (256 * DBL_EPSILON)
/* SURE: a second kernel vector that is not told from none to this proves nothing; VAGUE: what is
 * zero to more tells nothing */
#define SURE 1e-9
#define VAGUE 1e-6
/* CLEAR: times less than what holds an orbit; what rounding does to one held by less is not linear
 */
#define CLEAR 16
/* BESIDE: turns: a rotation that is not told from one so far off is not checked; PLACED: of that,
 * so far a located one may be off */
#define BESIDE 0.01
#define PLACED 1e-4

enum { LONGEST = 600 }; /* of the matrix: its singular values take seconds */

typedef double _Complex number;
typedef enum { NOTHING, ENERGY, PERIOD } stationary;

typedef struct {
    const replay *r;
    int n_seen, size; /* size: of the matrix, (2 n_seen + 1) n_flight */
    const real *share;
    number turn;        /* the end of the period is this times its start */
    number *J;          /* [(size + 1) * size] by columns */
    double *sv, *super; /* [size] singular values, ascending; and workspace */
    double open;        /* what the stored digits leave open, of the norm */
    double *unit;       /* [n_flight] time in which the state at its end moves by one */
} kernel;

/* Of a column (kappa q, p) over the modes what lies along the directions that contacts see. */
static void put_state(const kernel *q, const real *column, number *out)
{
    const int n = q->r->n, s = q->n_seen;
    for (int i = 0; i < 2 * s; i++)
        out[i] = (double)ric_replay_dot(n, q->share + i % s * n, column + (i < s ? 0 : n));
}

/* The gap of a face over what a unit of the state moves it at most. */
static double lever(const kernel *q, const face_t *face)
{
    real sum = 0;
    for (int i = 0; i < q->r->n; i++) sum += pow(face->c[i] / q->r->kappa[i], 2);
    return (double)sqrt(sum);
}

static void fill_flight(const kernel *q, int k)
{
    const replay *r = q->r;
    const int n = r->n, s = q->n_seen, rows = 2 * s + 1, last = k == r->n_flight - 1;
    const face_t *face = ric_replay_end_face(r, k);
    const double length = lever(q, face);
    const size_t ld = (size_t)q->size + 1;
    number *block = q->J + (size_t)(k * rows) * ld + k * rows;
    real column[2 * n], w[2 * n];
    for (int j = 0; j < 2 * s; j++) {
        memset(column, 0, sizeof column);
        memcpy(column + (j < s ? 0 : n), q->share + j % s * n, (size_t)n * sizeof *column);
        number *to = block + (size_t)j * ld;
        to[2 * s] = (double)ric_replay_fly_column(r, k, false, column) / length;
        put_state(q, column, to);
        /* the start of the next flight is its end */
        q->J[(size_t)((last ? 0 : k + 1) * rows + j) * ld + (size_t)(k * rows + j)] -= last
                                                                                           ? q->turn
                                                                                           : 1;
    }
    memcpy(w, r->chain + (size_t)(k + 1) * 2 * (size_t)n, sizeof w);
    ric_replay_reflect(r, face, w);
    ric_replay_delay_column(r, k, w, column);
    const real unit = 1 / sqrt(ric_replay_dot(2 * n, column, column));
    for (int i = 0; i < 2 * n; i++) column[i] *= unit;
    number *to = block + (size_t)(2 * s) * ld;
    put_state(q, column, to);
    to[2 * s] = (double)(unit * face->side * ric_replay_dot(n, face->c, w + n)) / length;
    q->unit[k] = (double)unit;
}

/* Of the energy, as the last row: over the norm. */
static void fill_energy(const kernel *q)
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
    number row[2 * s];
    put_state(q, gradient, row);
    for (int j = 0; j < 2 * s; j++)
        q->J[(size_t)j * ((size_t)q->size + 1) + (size_t)q->size] = row[j] / (double)norm;
}

/* Of the period, likewise. */
static void fill_period(const kernel *q)
{
    const int rows = 2 * q->n_seen + 1;
    double norm = 0;
    for (int k = 0; k < q->r->n_flight; k++) norm = hypot(norm, q->unit[k]);
    for (int k = 0; k < q->r->n_flight; k++)
        q->J[(size_t)(k * rows + rows - 1) * ((size_t)q->size + 1) + (size_t)q->size] = q->unit[k] /
                                                                                        norm;
}

/* Singular values of the equations, with the row of what is to be stationary. */
static ric_status find_values(kernel *q, double turns, stationary row)
{
    const int m = q->size, ld = m + 1;
    const double angle = RIC_TWO_PI * turns;
    q->turn = cos(angle) + I * sin(angle);
    memset(q->J, 0, (size_t)ld * (size_t)m * sizeof *q->J);
    for (int k = 0; k < q->r->n_flight; k++) fill_flight(q, k);
    if (row == ENERGY) fill_energy(q);
    if (row == PERIOD) fill_period(q);
    if (ric_lapack(LAPACKE_zgesvd(LAPACK_COL_MAJOR, 'N', 'N', row ? m + 1 : m, m, q->J, ld, q->sv,
                                  NULL, 1, NULL, 1, q->super)))
        return ric_fail(RIC_E_NUMERIC, "singular values of a junction could not be computed");
    for (int i = 0; i < m / 2; i++) {
        const double x = q->sv[i];
        q->sv[i] = q->sv[m - 1 - i];
        q->sv[m - 1 - i] = x;
    }
    return RIC_OK;
}

/* What the flights leave open at their faces and at the end: the orbit is off by as much. */
static double left_open(const kernel *q)
{
    const replay *r = q->r;
    const size_t step = 2 * (size_t)r->n;
    double open = (double)ric_replay_distance(r, r->chain + (size_t)r->n_flight * step, r->chain);
    for (int k = 0; k < r->n_flight; k++) {
        const face_t *face = ric_replay_end_face(r, k);
        const real gap = ric_replay_gap(r, face, r->chain + (size_t)(k + 1) * step);
        open = fmax(open, (double)fabs(gap) / lever(q, face));
    }
    return open / (double)r->norm;
}

/* What is zero of these values where the orbit is held by the i-th: rounding moves it by that over
 * this value, and no value by more than the matrix (Weyl). */
static double zero(const kernel *q, int i)
{
    return (ROUNDING + q->open) * q->sv[q->size - 1] + (i < q->size ? ROUNDING / q->sv[i] : 0);
}

static int count_zeros(const kernel *q, double bound)
{
    int count = 0;
    while (count < q->size && q->sv[count] <= bound) count++;
    return count;
}

/* Dimension of the kernel of a period, at least 1: a family; *bound: what is zero, infinite where
 * that is not told from what holds the orbit. */
static ric_status find_kernel(kernel *q, int *dimension, double *bound)
{
    const ric_status status = find_values(q, 0, NOTHING);
    *dimension = 1;
    while (!status && *dimension < q->size && q->sv[*dimension] <= zero(q, *dimension + 1))
        ++*dimension;
    *bound = zero(q, *dimension);
    const double hold = *dimension < q->size ? q->sv[*dimension] : INFINITY;
    if (*bound > fmin(VAGUE, hold / CLEAR)) *bound = INFINITY;
    return status;
}

static void find_fault(ric_claims *out, const char *what, double value, double bound)
{
    out->numbers = RIC_AGREES_NO;
    if (!*out->finding)
        snprintf(out->finding, sizeof out->finding, "%s: singular value %.2g, bound %.2g", what,
                 value, bound);
}

/* At an extremum no direction in which the orbit has neighbours changes the number. */
static ric_status check_extremum(kernel *q, stationary what, ric_claims *out)
{
    int dimension;
    double bound;
    ric_status status = find_kernel(q, &dimension, &bound);
    if (status || (status = find_values(q, 0, what))) return status;
    const int still = count_zeros(q, bound);
    if (isinf(bound)) ric_verify_digits_doubt(out, "kind");
    else if (!still)
        find_fault(out, what == ENERGY ? "no extremum of energy" : "no extremum of period",
                   q->sv[0], bound);
    else if (still < dimension && bound <= SURE)
        find_fault(out, "an extremum where branches meet", q->sv[still], bound);
    else if (still < dimension) ric_verify_digits_doubt(out, "kind");
    return RIC_OK;
}

/* A second direction in which the orbit has neighbours; where no direction changes the energy it
 * may be an extremum of a family of two parameters. */
static ric_status check_branch_point(kernel *q, ric_claims *out)
{
    int dimension;
    double bound;
    ric_status status = find_kernel(q, &dimension, &bound);
    const double next = q->size > 1 ? q->sv[1] : INFINITY, nothing = zero(q, 2);
    if (status || (status = find_values(q, 0, ENERGY))) return status;
    if (isinf(bound)) ric_verify_digits_doubt(out, "kind");
    else if (dimension < 2) find_fault(out, "no branch point", next, nothing);
    else if (count_zeros(q, bound) >= dimension) ric_verify_digits_doubt(out, "kind");
    return RIC_OK;
}

static ric_status check_rotation(kernel *q, const int rotation[2], ric_claims *out)
{
    int dimension;
    double bound;
    char what[64];
    const double turns = (double)rotation[0] / rotation[1];
    ric_status status = find_kernel(q, &dimension, &bound);
    if (!status) status = find_values(q, turns, NOTHING);
    if (status) return status;
    const double least = q->sv[0];
    if ((status = find_values(q, turns + BESIDE, NOTHING))) return status;
    bound = fmax(bound, PLACED * q->sv[0]);
    if (!(bound < q->sv[0])) {
        ric_verify_digits_doubt(out, "multipliers");
        return RIC_OK;
    }
    snprintf(what, sizeof what, "no multipliers exp(+-2 pi i %d/%d)", rotation[0], rotation[1]);
    if (least > bound) find_fault(out, what, least, bound);
    return RIC_OK;
}

static ric_status check(kernel *q, const ric_junction *j, ric_claims *out)
{
    switch (j->kind) {
    case RIC_KIND_EXTREMUM: return check_extremum(q, ENERGY, out);
    case RIC_KIND_PERIOD_EXTREMUM: return check_extremum(q, PERIOD, out);
    case RIC_KIND_BRANCH_POINT: return check_branch_point(q, out);
    case RIC_KIND_MULTIPLICATION: return check_rotation(q, j->rotation, out);
    default: return RIC_OK;
    }
}

ric_status ric_verify_kind(const replay *r, const ric_junction *j, ric_claims *out)
{
    const int n = r->n;
    const bool asked = j->kind == RIC_KIND_EXTREMUM || j->kind == RIC_KIND_PERIOD_EXTREMUM ||
                       j->kind == RIC_KIND_BRANCH_POINT || j->kind == RIC_KIND_MULTIPLICATION;
    int seen[n];
    real share[(n + 1) * n];
    kernel q = {.r = r, .share = share};
    q.n_seen = ric_verify_seen(r, seen, share);
    q.size = (2 * q.n_seen + 1) * r->n_flight;
    if (asked && (r->n_event == 0 || q.size > LONGEST))
        ric_verify_digits_doubt(out, j->kind == RIC_KIND_MULTIPLICATION ? "multipliers" : "kind");
    if (!asked || r->n_event == 0 || q.size > LONGEST) return RIC_OK;
    const size_t m = (size_t)q.size;
    q.J = ric_malloc((m + 1) * m * sizeof *q.J);
    q.sv = ric_malloc((2 * m + (size_t)r->n_flight) * sizeof *q.sv);
    q.super = q.sv + m;
    q.unit = q.super + m;
    q.open = left_open(&q);
    const ric_status status = q.J && q.sv ? check(&q, j, out)
                                          : ric_no_memory("what makes an orbit a junction");
    free(q.J);
    free(q.sv);
    return status;
}
