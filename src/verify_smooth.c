/* A stored orbit under power-law springs is integrated over its period from the raw matrices (springs.h), and has to
 * return.
 *
 * What the return may lose is measured: neighbours at a small distance on both sides give the matrix of a period, whose
 * largest multiplier is the condition. The last digits of the stored doubles come back multiplied by its norm, which
 * may be much more than its multipliers. Where that is beyond STEEP an orbit that does not return is polished: the
 * period is cut into parts, each with a start of its own, and Newton's method closes them all, by the shortest
 * correction. How far that moves the stored start counts as an error of the flight, and what is left between the parts
 * as one of the return. */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <lapacke.h>

#include "springs.h"
#include "status.h"
#include "verify_smooth.h"

#define FLIGHT 1e-11    /* largest relative error of the energy, and of a polished orbit */
#define RETURN 1e-9     /* of the state after a period, times max(1, AMPLIFIED * multiplier) */
#define AMPLIFIED 1e-7
#define STEEP 1e4       /* beyond it the last digits of the stored doubles matter more than what is checked */
#define NEAR 1e-7L      /* distance of neighbours, relative: central differences leave its square */
#define LIGHT 1e3      /* how much less than the stored start the starts of other parts count in a correction */
#define REGULAR 1e-9    /* singular values below this part of the largest belong to the family and to the energy */

typedef ric_real real;

typedef struct {
    ric_springs *springs;
    int n, parts;        /* of 2 n_dof coordinates; of the period */
    real period, size[2]; /* largest displacement and velocity of the start */
    real *start, *end;   /* [parts * n] of every part */
    double *M, *rate;    /* [parts * n * n] and [parts * n]: derivatives of the ends by the starts and by the period, in
                          * units of size */
    double *stored;      /* [n + 1] */
} replay;

static real unit(const replay *r, int i)
{
    return r->size[i >= r->n / 2];
}

static ric_status divide(replay *r, int parts)
{
    size_t n = (size_t)r->n, k = (size_t)parts;
    real *states = realloc(r->start, 2 * k * n * sizeof *states);
    if (states) r->start = states;
    double *M = realloc(r->M, k * n * (n + 1) * sizeof *M);
    if (M) r->M = M;
    if (!states || !M) return ric_fail(RIC_E_NOMEM, "no memory to replay an orbit");
    r->parts = parts;
    r->end = r->start + k * n;
    r->rate = r->M + k * n * n;
    return RIC_OK;
}

static ric_status set_up(replay *r, const ric_atlas *atlas, int branch, int point, ric_point *at)
{
    const ric_model *model = ric_atlas_model(atlas);
    ric_branch b;
    ric_status status = ric_atlas_branch(atlas, branch, &b);
    if (status) return status;
    int n = r->n = 2 * ric_model_n_dof(model);
    if (!(r->stored = calloc((size_t)n + 1, sizeof *r->stored)))
        return ric_fail(RIC_E_NOMEM, "no memory to replay an orbit");
    if ((status = divide(r, 1))) return status;
    if ((status = ric_atlas_point(atlas, branch, point, at, r->stored, r->stored + n))) return status;
    r->period = r->stored[n];
    for (int i = 0; i < n; i++) r->start[i] = r->stored[i];
    /* a mirror point may have no displacement or no velocity at all: the period joins the two */
    for (int i = 0; i < n; i++) r->size[i >= n / 2] = fmaxl(r->size[i >= n / 2], fabsl(r->start[i]));
    real turn = r->period / 6.283185307179586L;
    r->size[0] = fmaxl(r->size[0], r->size[1] * turn);
    r->size[1] = fmaxl(r->size[1], r->size[0] / turn);
    return ric_springs_create(model, &r->springs);
}

/* Through one part of the period. */
static ric_status fly(replay *r, const real *from, real *to)
{
    if (to != from) memcpy(to, from, (size_t)r->n * sizeof *to);
    return ric_springs_go(r->springs, r->period / r->parts, to);
}

static double distance(const replay *r, const real *a, const real *b)
{
    real most = 0;
    for (int i = 0; i < r->n; i++) most = fmaxl(most, fabsl(a[i] - b[i]) / unit(r, i));
    return (double)most;
}

/* The start of the part after part j. */
static real *next(const replay *r, int j)
{
    return r->start + r->n * ((j + 1) % r->parts);
}

/* What is left between the parts. */
static double gap(const replay *r)
{
    double most = 0;
    for (int j = 0; j < r->parts; j++) most = fmax(most, distance(r, r->end + r->n * j, next(r, j)));
    return most;
}

static ric_status fly_all(replay *r)
{
    ric_status status = RIC_OK;
    for (int j = 0; j < r->parts && !status; j++) status = fly(r, r->start + r->n * j, r->end + r->n * j);
    return status;
}

/* M and rate of part j. */
static ric_status differentiate(replay *r, int j)
{
    int n = r->n;
    double *M = r->M + n * n * j, *rate = r->rate + n * j;
    real shifted[n], ahead[n], behind[n];
    for (int k = 0; k < n; k++) {
        for (int side = 1; side >= -1; side -= 2) {
            memcpy(shifted, r->start + n * j, sizeof shifted);
            shifted[k] += side * NEAR * unit(r, k);
            ric_status status = fly(r, shifted, side > 0 ? ahead : behind);
            if (status) return status;
        }
        for (int i = 0; i < n; i++) M[i * n + k] = (double)((ahead[i] - behind[i]) / (2 * NEAR * unit(r, i)));
    }
    /* the flow, from a short time on */
    real brief = 1e-6L * r->period;
    memcpy(ahead, r->end + n * j, sizeof ahead);
    ric_status status = ric_springs_go(r->springs, brief, ahead);
    for (int i = 0; i < n; i++)
        rate[i] = (double)((ahead[i] - r->end[n * j + i]) / brief * r->period / r->parts / unit(r, i));
    return status;
}

/* All parts; *condition, the modulus of the largest multiplier, and *growth, by which errors may return larger in any
 * direction. */
static ric_status differentiate_all(replay *r, double *condition, double *growth)
{
    int n = r->n;
    double whole[n * n], product[n * n], re[n], im[n];
    for (int j = 0; j < r->parts; j++) {
        ric_status status = differentiate(r, j);
        if (status) return status;
        memcpy(product, r->M + n * n * j, sizeof product);
        for (int i = 0; i < n && j > 0; i++)
            for (int k = 0; k < n; k++) {
                product[i * n + k] = 0;
                for (int l = 0; l < n; l++) product[i * n + k] += r->M[n * n * j + i * n + l] * whole[l * n + k];
            }
        memcpy(whole, product, sizeof whole);
    }
    *growth = 0;
    for (int i = 0; i < n; i++) {
        double row = 0;
        for (int k = 0; k < n; k++) row += fabs(whole[i * n + k]);
        *growth = fmax(*growth, row);
    }
    *condition = 1;
    if (ric_lapack(LAPACKE_dgeev(LAPACK_ROW_MAJOR, 'N', 'N', n, whole, n, re, im, NULL, 1, NULL, 1)))
        return ric_fail(RIC_E_NUMERIC, "the multipliers of a replayed orbit could not be computed");
    for (int i = 0; i < n; i++) *condition = fmax(*condition, hypot(re[i], im[i]));
    return RIC_OK;
}

/* One step, [.. M_j .. -1 .. rate_j] (starts, period) = - gaps, the starts of the parts following one another round the
 * orbit: of all that close them that which is nearest to what is stored, the first start and the period, where a shift
 * of the others costs next to nothing: else it would go some way along the branch to meet them. A, F: workspace. */
static ric_status correct(replay *r, double *A, double *F, double *values)
{
    int n = r->n, rows = n * r->parts, columns = rows + 1, rank;
    double off[n + 1];
    for (int i = 0; i < n; i++) off[i] = (double)((r->start[i] - r->stored[i]) / unit(r, i));
    off[n] = (double)((r->period - r->stored[n]) / r->stored[n]);
    memset(A, 0, (size_t)rows * (size_t)columns * sizeof *A);
    for (int j = 0; j < r->parts; j++)
        for (int i = 0; i < n; i++) {
            int row = n * j + i, to = n * ((j + 1) % r->parts);
            memcpy(A + row * columns + n * j, r->M + n * row, (size_t)n * sizeof *A);
            A[row * columns + to + i] -= 1;
            A[row * columns + rows] = r->rate[row];
            F[row] = (double)((next(r, j)[i] - r->end[row]) / unit(r, i)) + A[row * columns + rows] * off[n];
            for (int k = 0; k < n; k++) F[row] += A[row * columns + k] * off[k];
            for (int k = n; k < rows; k++) A[row * columns + k] *= LIGHT;
        }
    if (ric_lapack(LAPACKE_dgelsd(LAPACK_ROW_MAJOR, rows, columns, 1, A, columns, F, 1, values, REGULAR, &rank)))
        return ric_fail(RIC_E_NUMERIC, "a stored orbit could not be polished");
    for (int i = 0; i < n; i++) r->start[i] = r->stored[i] + F[i] * unit(r, i);
    for (int i = n; i < rows; i++) r->start[i] += LIGHT * F[i] * unit(r, i % n);
    r->period = r->stored[n] * (1 + F[rows]);
    return fly_all(r);
}

/* Newton's method on all parts of the period, from the stored start on. */
static ric_status polish(replay *r, double *condition)
{
    enum { PARTS = 16, STEPS = 4 };
    double growth;
    ric_status status = divide(r, PARTS);
    size_t rows = (size_t)r->n * PARTS;
    double *A = calloc(rows * (rows + 1) + 2 * (rows + 1), sizeof *A), *F = A ? A + rows * (rows + 1) : NULL;
    if (!A) return ric_fail(RIC_E_NOMEM, "no memory to replay an orbit");
    for (int j = 0; j < PARTS && !status; j++) {
        status = fly(r, r->start + r->n * j, r->end + r->n * j);
        if (j + 1 < PARTS) memcpy(next(r, j), r->end + r->n * j, (size_t)r->n * sizeof *r->start);
    }
    for (int step = 0; step < STEPS && !status; step++)
        if (!(status = differentiate_all(r, condition, &growth))) status = correct(r, A, F, F + rows + 1);
    free(A);
    return status;
}

/* Largest relative difference from `energy` of that at the ends of all parts. */
static double drift(const replay *r, const ric_model *m, double energy)
{
    double most = 0, state[r->n];
    for (int j = 0; j < r->parts; j++) {
        for (int i = 0; i < r->n; i++) state[i] = (double)r->end[r->n * j + i];
        most = fmax(most, fabs(ric_model_energy(m, state, state + r->n / 2) - energy) / energy);
    }
    return most;
}

ric_status ric_verify_smooth(const ric_atlas *atlas, int branch, int point, ric_check *out)
{
    replay r = {0};
    ric_point at;
    const ric_model *m = ric_atlas_model(atlas);
    *out = (ric_check){.branch = branch, .point = point, .condition = 1, .faces_agree = true};
    ric_status status = set_up(&r, atlas, branch, point, &at);
    if (status || (status = fly_all(&r))) goto out;
    double energy = ric_model_energy(m, r.stored, r.stored + r.n / 2), growth;
    out->energy_error = fabs(at.energy - energy) / energy;
    if ((status = differentiate_all(&r, &out->condition, &growth))) goto out;
    if (growth > STEEP && gap(&r) > RETURN * fmax(1, AMPLIFIED * out->condition)) {
        if ((status = polish(&r, &out->condition))) goto out;
        for (int i = 0; i < r.n; i++)
            out->flight_error = fmax(out->flight_error, (double)(fabsl(r.start[i] - r.stored[i]) / unit(&r, i)));
    }
    double amplified = fmax(1, AMPLIFIED * out->condition);
    out->return_error = gap(&r);
    out->energy_error = fmax(out->energy_error, drift(&r, m, energy) / amplified);
    out->passed = out->flight_error <= FLIGHT && out->energy_error <= FLIGHT && out->return_error <= RETURN * amplified;
out:
    ric_springs_free(r.springs);
    free(r.start);
    free(r.M);
    free(r.stored);
    return status;
}

ric_status ric_verify_smooth_claims(const ric_atlas *atlas, int branch, int point, ric_claims *out)
{
    (void)atlas; (void)branch; (void)point; (void)out;
    return RIC_OK;
}
