/* A stored orbit under power-law springs is integrated over its period from the raw matrices (springs.h), and has to return.
 *
 * What the return may lose is measured: neighbours at a small distance on both sides give the matrix of a period, whose largest multiplier is
 * the condition. The last digits of the stored doubles come back multiplied by its norm, which may be much more than its multipliers. Where that
 * is beyond STEEP an orbit that does not return is polished: Newton's method on the return, the shortest correction; how far that moves it counts
 * as an error of the flight. */
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
#define REGULAR 1e-9    /* singular values below this part of the largest belong to the family and to the energy */

typedef ric_real real;

typedef struct {
    ric_springs *springs;
    int n;               /* of 2 n_dof coordinates */
    real period, size[2]; /* largest displacement and velocity of the start */
    real *start, *end, *work; /* [n] */
    double *stored, *D;  /* [n + 1] and [n * (n + 1)]: derivative of the return in units of size, last column by the period */
} replay;

static real unit(const replay *r, int i)
{
    return r->size[i >= r->n / 2];
}

static ric_status set_up(replay *r, const ric_atlas *atlas, int branch, int point, ric_point *at)
{
    const ric_model *model = ric_atlas_model(atlas);
    ric_branch b;
    ric_status status = ric_atlas_branch(atlas, branch, &b);
    if (status) return status;
    int n = r->n = 2 * ric_model_n_dof(model);
    r->start = calloc(3 * (size_t)n, sizeof *r->start);
    r->stored = calloc((size_t)n + 1 + (size_t)n * ((size_t)n + 1), sizeof *r->stored);
    if (!r->start || !r->stored) return ric_fail(RIC_E_NOMEM, "no memory to replay an orbit");
    r->end = r->start + n;
    r->work = r->end + n;
    r->D = r->stored + n + 1;
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

static ric_status fly(replay *r, const real *from, real *to)
{
    if (to != from) memcpy(to, from, (size_t)r->n * sizeof *to);
    return ric_springs_go(r->springs, r->period, to);
}

static double distance(const replay *r, const real *a, const real *b)
{
    real most = 0;
    for (int i = 0; i < r->n; i++) most = fmaxl(most, fabsl(a[i] - b[i]) / unit(r, i));
    return (double)most;
}

/* D, *condition, the modulus of the largest multiplier, and *growth, by which errors may return larger in any direction. */
static ric_status differentiate(replay *r, double *condition, double *growth)
{
    int n = r->n;
    real shifted[n], ahead[n];
    double M[n * n], re[n], im[n];
    for (int j = 0; j < n; j++) {
        for (int side = 1; side >= -1; side -= 2) {
            memcpy(shifted, r->start, sizeof shifted);
            shifted[j] += side * NEAR * unit(r, j);
            ric_status status = fly(r, shifted, side > 0 ? ahead : r->work);
            if (status) return status;
        }
        for (int i = 0; i < n; i++) M[i * n + j] = (double)((ahead[i] - r->work[i]) / (2 * NEAR * unit(r, i)));
    }
    /* the flow, from a short time on */
    real brief = 1e-6L * r->period;
    memcpy(ahead, r->end, sizeof ahead);
    ric_status status = ric_springs_go(r->springs, brief, ahead);
    if (status) return status;
    *growth = 0;
    for (int i = 0; i < n; i++) {
        double row = 0;
        for (int j = 0; j < n; j++) {
            row += fabs(M[i * n + j]);
            r->D[i * (n + 1) + j] = M[i * n + j] - (i == j);
        }
        *growth = fmax(*growth, row);
        r->D[i * (n + 1) + n] = (double)((ahead[i] - r->end[i]) / brief * r->period / unit(r, i));
    }
    *condition = 1;
    if (ric_lapack(LAPACKE_dgeev(LAPACK_ROW_MAJOR, 'N', 'N', n, M, n, re, im, NULL, 1, NULL, 1)))
        return ric_fail(RIC_E_NUMERIC, "the multipliers of a replayed orbit could not be computed");
    for (int i = 0; i < n; i++) *condition = fmax(*condition, hypot(re[i], im[i]));
    return RIC_OK;
}

static ric_status polish(replay *r)
{
    enum { STEPS = 3 };
    int n = r->n, rank;
    double A[n * (n + 1)], F[n + 1], values[n + 1];
    for (int step = 0; step < STEPS; step++) {
        for (int i = 0; i < n; i++) F[i] = (double)((r->end[i] - r->start[i]) / unit(r, i));
        F[n] = 0;
        memcpy(A, r->D, sizeof A);
        if (ric_lapack(LAPACKE_dgelsd(LAPACK_ROW_MAJOR, n, n + 1, 1, A, n + 1, F, 1, values, REGULAR, &rank)))
            return ric_fail(RIC_E_NUMERIC, "a stored orbit could not be polished");
        for (int i = 0; i < n; i++) r->start[i] -= F[i] * unit(r, i);
        r->period -= F[n] * r->period;
        ric_status status = fly(r, r->start, r->end);
        if (status) return status;
    }
    return RIC_OK;
}

ric_status ric_verify_smooth(const ric_atlas *atlas, int branch, int point, ric_check *out)
{
    replay r = {0};
    ric_point at;
    *out = (ric_check){.branch = branch, .point = point, .condition = 1, .faces_agree = true};
    ric_status status = set_up(&r, atlas, branch, point, &at);
    if (status || (status = fly(&r, r.start, r.end))) goto out;
    double energy = ric_model_energy(ric_atlas_model(atlas), r.stored, r.stored + r.n / 2), growth, *last = r.stored;
    out->energy_error = fabs(at.energy - energy) / energy;
    if ((status = differentiate(&r, &out->condition, &growth))) goto out;
    double limit = RETURN * fmax(1, AMPLIFIED * out->condition);
    if (growth > STEEP && distance(&r, r.end, r.start) > limit) {
        real stored[r.n];
        memcpy(stored, r.start, sizeof stored);
        if ((status = polish(&r))) goto out;
        out->flight_error = distance(&r, r.start, stored);
    }
    out->return_error = distance(&r, r.end, r.start);
    for (int i = 0; i < r.n; i++) last[i] = (double)r.end[i];
    double after = ric_model_energy(ric_atlas_model(atlas), last, last + r.n / 2);
    double drift = fabs(after - energy) / energy / fmax(1, AMPLIFIED * out->condition);
    out->energy_error = fmax(out->energy_error, drift);
    out->passed = out->flight_error <= FLIGHT && out->energy_error <= FLIGHT && out->return_error <= limit;
out:
    ric_springs_free(r.springs);
    free(r.start);
    free(r.stored);
    return status;
}
