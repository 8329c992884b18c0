/* A stored orbit under power-law springs is integrated over its period from the raw matrices
 * (simulator_power.h), and has to return.
 *
 * What the return may lose is measured: the variational equations give the matrix of a period,
 * whose largest multiplier is the condition. The last digits of the stored doubles come back
 * multiplied by its norm, which
 * may be much more than its multipliers. Where that is beyond STEEP an orbit that does not return
 * is polished: the period is cut into parts, each with a start of its own, and Newton's method
 * closes them all, by the shortest correction. How far that moves the stored start counts as an
 * error of the flight, and what is left between the parts as one of the return. */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <lapacke.h>

#include "simulator_power.h"
#include "base/room.h"
#include "verify_pairs.h"
#include "verify_smooth.h"

#define FLIGHT 1e-11 /* largest relative error of the energy, and of a polished orbit */
#define RETURN 1e-9  /* of the state after a period, times max(1, AMPLIFIED * multiplier) */
#define AMPLIFIED 1e-7
/* STEEP: beyond it the last digits of the stored doubles matter more than what is checked */
#define STEEP 1e4
#define NOISE (8 * DBL_EPSILON) /* of a part in double, relative */
/* IMAGE: half a period later a symmetric orbit is its image to this part */
#define IMAGE 1e-9
/* LIGHT: how much less than the stored start the starts of other parts count in a correction */
#define LIGHT 1e3
/* REGULAR: singular values below this part of the largest belong to the family and to the energy */
#define REGULAR 1e-9

enum { PARTS = 16 };

typedef ric_real real;

typedef struct {
    ric_simulator_power *springs;
    int n, parts;         /* of 2 n_dof coordinates; of the period */
    real period, size[2]; /* largest displacement and velocity of the start */
    real *start, *end;    /* [parts * n] of every part */
    double *M, *rate; /* [parts * n * n] and [parts * n]: derivatives of the ends by the starts and
                         by the period, in units of size */
    double *stored;   /* [n + 1] */
} replay;

static real unit(const replay *r, int i)
{
    return r->size[i >= r->n / 2];
}

static ric_status divide(replay *r, int parts)
{
    size_t n = (size_t)r->n, k = (size_t)parts;
    real *states = ric_realloc(r->start, 2 * k * n * sizeof *states);
    if (states) r->start = states;
    double *M = ric_realloc(r->M, k * n * (n + 1) * sizeof *M);
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
    if (!(r->stored = ric_calloc((size_t)n + 1, sizeof *r->stored)))
        return ric_fail(RIC_E_NOMEM, "no memory to replay an orbit");
    if ((status = divide(r, PARTS))) return status;
    if ((status = ric_atlas_point(atlas, branch, point, at, r->stored, r->stored + n)))
        return status;
    r->period = r->stored[n];
    for (int i = 0; i < n; i++) r->start[i] = r->stored[i];
    /* a mirror point may have no displacement or no velocity at all: the period joins the two */
    for (int i = 0; i < n; i++)
        r->size[i >= n / 2] = fmaxl(r->size[i >= n / 2], fabsl(r->start[i]));
    if (!(r->size[0] + r->size[1] > 0)) r->size[0] = 1; /* at rest for ever */
    real turn = r->period / RIC_TWO_PI_LONG;
    r->size[0] = fmaxl(r->size[0], r->size[1] * turn);
    r->size[1] = fmaxl(r->size[1], r->size[0] / turn);
    return ric_simulator_power_create(model, &r->springs);
}

/* Through part j of the period: its end, and M and rate there, the derivatives of the end. */
static ric_status fly(replay *r, int j)
{
    int n = r->n;
    double *M = r->M + n * n * j;
    real *end = r->end + n * j, rate[n];
    memcpy(end, r->start + n * j, (size_t)n * sizeof *end);
    for (int i = 0; i < n * n; i++) M[i] = i / n == i % n ? (double)unit(r, i / n) : 0;
    ric_status status = ric_simulator_power_go(r->springs, r->period / r->parts, end, M);
    for (int i = 0; i < n * n; i++) M[i] /= (double)unit(r, i / n);
    ric_simulator_power_accelerations(r->springs, end, rate + n / 2);
    memcpy(rate, end + n / 2, (size_t)(n / 2) * sizeof *rate);
    for (int i = 0; i < n; i++)
        r->rate[n * j + i] = (double)(rate[i] * r->period / r->parts / unit(r, i));
    return status;
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
    for (int j = 0; j < r->parts; j++)
        most = fmax(most, distance(r, r->end + r->n * j, next(r, j)));
    return most;
}

static ric_status fly_all(replay *r)
{
    ric_status status = RIC_OK;
    for (int j = 0; j < r->parts && !status; j++) status = fly(r, j);
    return status;
}

/* The first `count` of them one after the other from the first start. */
static ric_status fly_through(replay *r, int count)
{
    ric_status status = RIC_OK;
    for (int j = 0; j < count && !status; j++) {
        status = fly(r, j);
        if (j + 1 < r->parts)
            memcpy(next(r, j), r->end + r->n * j, (size_t)r->n * sizeof *r->start);
    }
    return status;
}

/* All parts; *condition, the modulus of the largest multiplier, and *growth, by which errors may
 * return larger in any direction. */
static ric_status find_condition(replay *r, double *condition, double *growth)
{
    int n = r->n;
    const size_t square = (size_t)n * (size_t)n;
    double *whole = ric_malloc(2 * square * sizeof *whole), *product = whole + square, re[n], im[n];
    if (!whole) return ric_no_memory("the matrix of a period");
    for (int j = 0; j < r->parts; j++) {
        memcpy(product, r->M + n * n * j, square * sizeof *product);
        for (int i = 0; i < n && j > 0; i++)
            for (int k = 0; k < n; k++) {
                product[i * n + k] = 0;
                for (int l = 0; l < n; l++)
                    product[i * n + k] += r->M[n * n * j + i * n + l] * whole[l * n + k];
            }
        memcpy(whole, product, square * sizeof *whole);
    }
    *growth = 0;
    for (int i = 0; i < n; i++) {
        double row = 0;
        for (int k = 0; k < n; k++) row += fabs(whole[i * n + k]);
        *growth = fmax(*growth, row);
    }
    *condition = 1;
    const bool lost = ric_lapack(
        LAPACKE_dgeev(LAPACK_ROW_MAJOR, 'N', 'N', n, whole, n, re, im, NULL, 1, NULL, 1));
    free(whole);
    if (lost)
        return ric_fail(RIC_E_NUMERIC, "the multipliers of a replayed orbit could not be computed");
    for (int i = 0; i < n; i++) *condition = fmax(*condition, hypot(re[i], im[i]));
    return RIC_OK;
}

/* One step, [.. M_j .. -1 .. rate_j] (starts, period) = - gaps, the starts of the parts following
 * one another round the orbit: of all that close them that which is nearest to what is stored, the
 * first start and the period, where a shift of the others costs next to nothing: else it would go
 * some way along the branch to meet them. A, F: workspace. */
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
            F[row] = (double)((next(r, j)[i] - r->end[row]) / unit(r, i)) +
                     A[row * columns + rows] * off[n];
            for (int k = 0; k < n; k++) F[row] += A[row * columns + k] * off[k];
            for (int k = n; k < rows; k++) A[row * columns + k] *= LIGHT;
        }
    if (ric_lapack(LAPACKE_dgelsd(LAPACK_ROW_MAJOR, rows, columns, 1, A, columns, F, 1, values,
                                  REGULAR, &rank)))
        return ric_fail(RIC_E_NUMERIC, "a stored orbit could not be polished");
    for (int i = 0; i < n; i++) r->start[i] = r->stored[i] + F[i] * unit(r, i);
    for (int i = n; i < rows; i++) r->start[i] += LIGHT * F[i] * unit(r, i % n);
    r->period = r->stored[n] * (1 + F[rows]);
    return fly_all(r);
}

/* Newton's method on all parts of the period, from the stored start on. */
static ric_status polish(replay *r, double *condition)
{
    enum { STEPS = 4 };
    double growth;
    size_t rows = (size_t)r->n * (size_t)r->parts;
    double *A = ric_calloc(rows * (rows + 1) + 2 * (rows + 1), sizeof *A),
           *F = A ? A + rows * (rows + 1) : NULL;
    if (!A) return ric_fail(RIC_E_NOMEM, "no memory to replay an orbit");
    ric_status status = RIC_OK;
    for (int step = 0; step < STEPS && !status; step++) status = correct(r, A, F, F + rows + 1);
    if (!status) status = find_condition(r, condition, &growth);
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

/* ------------------------------------------------------------------ claims */

/* M of some parts from the first on, as one, with the rounding of doubles added if `level` is not
 * 0; product [n * n] is workspace. */
static void multiply(const replay *r, int parts, real level, unsigned *bits, real *whole,
                     real *product)
{
    int n = r->n;
    real largest = 1;
    for (int i = 0; i < n * n; i++) whole[i] = i / n == i % n;
    for (int j = 0; j < parts; j++) {
        const double *M = r->M + n * n * j;
        for (int i = 0; i < n; i++)
            for (int k = 0; k < n; k++) {
                real sum = 0;
                for (int l = 0; l < n; l++) sum += M[i * n + l] * whole[l * n + k];
                product[i * n + k] = sum;
                largest = fmaxl(largest, fabsl(sum));
            }
        for (int i = 0; i < n * n; i++)
            whole[i] = product[i] +
                       (level > 0 ? level * largest * ric_verify_pairs_noise(bits) : 0);
    }
}

/* The flow and the gradient of the energy at the start, in units of size. */
static void find_trivial(const replay *r, const ric_model *m, real *flow, real *gradient)
{
    int n = r->n, d = n / 2;
    const double *mass = ric_model_mass(m);
    real a[d];
    ric_simulator_power_accelerations(r->springs, r->start, a);
    for (int i = 0; i < d; i++) {
        flow[i] = r->start[d + i] / r->size[0];
        flow[d + i] = a[i] / r->size[1];
        gradient[i] = gradient[d + i] = 0;
        for (int j = 0; j < d; j++) {
            gradient[i] -= mass[i * d + j] * a[j] * r->size[0];
            gradient[d + i] += mass[i * d + j] * r->start[d + j] * r->size[1];
        }
    }
}

ric_status ric_verify_smooth_modes(const ric_model *m, int d, int k, real *from, real *to)
{
    bool seen[d];
    const double *mass = ric_model_mass(m);
    double *shape = ric_malloc((size_t)d * (size_t)d * sizeof *shape);
    ric_status status = shape ? ric_model_modes(m, shape)
                              : ric_no_memory("the modes of a structure");
    if (!status) status = ric_model_seen(m, seen);
    for (int i = 0, s = 0; i < d && s < k && !status; i++) {
        if (!seen[i]) continue;
        for (int a = 0; a < d; a++) {
            from[a * k + s] = shape[a * d + i];
            to[s * d + a] = 0;
            for (int b = 0; b < d; b++) to[s * d + a] += shape[b * d + i] * mass[b * d + a];
        }
        s++;
    }
    free(shape);
    return status;
}

/* The columns, the flow, the gradient and the form [2 k] in these modes: the others have pairs of
 * their own. In place; workspace [3 n^2 / 2] behind J [n * n]. */
static ric_status see_modes(const replay *r, const ric_model *m, real *whole, real *J, real *flow,
                            real *gradient)
{
    int n = r->n, d = n / 2, k = ric_model_n_mode(m);
    real *to = J + n * n, *from = to + k * d, *product = from + d * k, f[2 * k], g[2 * k];
    ric_status status = ric_verify_smooth_modes(m, d, k, from, to);
    if (status) return status;
    for (int i = 0; i < 2 * k; i++) {
        f[i] = g[i] = 0;
        for (int a = 0; a < d; a++) {
            f[i] += to[i % k * d + a] * flow[i / k * d + a];
            g[i] += gradient[i / k * d + a] * from[a * k + i % k];
        }
        for (int c = 0; c < n; c++) {
            product[i * n + c] = 0;
            for (int a = 0; a < d; a++)
                product[i * n + c] += to[i % k * d + a] * whole[(i / k * d + a) * n + c];
        }
    }
    for (int i = 0; i < 2 * k; i++)
        for (int j = 0; j < 2 * k; j++) {
            whole[i * 2 * k + j] = 0;
            for (int a = 0; a < d; a++)
                whole[i * 2 * k + j] += product[i * n + j / k * d + a] * from[a * k + j % k];
            J[i * 2 * k + j] = i + k == j ? 1 : i == j + k ? -1 : 0;
        }
    memcpy(flow, f, sizeof f);
    memcpy(gradient, g, sizeof g);
    return RIC_OK;
}

/* rho of one run, after the columns of all parts. */
static bool run_once(const replay *r, const ric_model *m, int run, ric_pairs *pairs)
{
    int n = r->n;
    unsigned bits = 20011u + 97u * (unsigned)run;
    const size_t square = (size_t)n * (size_t)n;
    real *whole = ric_malloc(4 * square * sizeof *whole), *J = whole + square, *work = J + square,
         flow[n], gradient[n];
    if (!whole) return false;
    multiply(r, pairs->half ? r->parts / 2 : r->parts, run ? NOISE : 0, &bits, whole, work);
    for (int i = 0; i < n * n && pairs->half; i++) whole[i] = -whole[i];
    find_trivial(r, m, flow, gradient);
    const bool found = !see_modes(r, m, whole, J, flow, gradient) &&
                       ric_verify_pairs_find(2 * (pairs->n_pair + 1), whole, J, flow, gradient,
                                             pairs->own + run * pairs->n_pair, &pairs->way[run]);
    free(whole);
    return found;
}

/* Half a period later a symmetric orbit is its image. */
static double off_image(const replay *r)
{
    real image[r->n];
    if (r->parts % 2) return INFINITY;
    for (int i = 0; i < r->n; i++) image[i] = -r->start[r->n * (r->parts / 2) + i];
    return distance(r, image, r->start);
}

/* Run 0 has the columns as they are; the others add the rounding of doubles to them, and run 2 and
 * 3 are flown anew from starts that are off by it, or by what the stored digits leave open. */
static ric_status check_multipliers(replay *r, const ric_model *m, const ric_branch *b,
                                    const ric_point *at, const ric_verify_asked *asked,
                                    ric_claims *out)
{
    ric_status status = RIC_OK;
    bool half = b->symmetric && off_image(r) <= IMAGE;
    ric_pairs pairs = {.n_pair = ric_model_n_mode(m) - 1,
                       .runs = RIC_PAIR_RUNS,
                       .half = half,
                       .asked = asked};
    real level = fmaxl(NOISE, gap(r)), *kept = ric_malloc((size_t)(r->n * r->parts) * sizeof *kept);
    unsigned bits = 4711;
    bool found = true;
    if (!kept ||
        !(pairs.own = ric_calloc((size_t)pairs.n_pair * RIC_PAIR_RUNS + 1, sizeof *pairs.own))) {
        free(kept);
        return ric_fail(RIC_E_NOMEM, "no memory for %d multipliers", 2 * pairs.n_pair);
    }
    memcpy(kept, r->start, (size_t)(r->n * r->parts) * sizeof *kept);
    for (int run = 0; run < RIC_PAIR_RUNS && found && !status && pairs.n_pair; run++) {
        for (int i = 0; run == 2 && i < r->n * r->parts; i++)
            r->start[i] = kept[i] + level * unit(r, i % r->n) * ric_verify_pairs_noise(&bits);
        if (run == 2) status = fly_all(r);
        if (!status) found = run_once(r, m, run, &pairs);
    }
    memcpy(r->start, kept, (size_t)(r->n * r->parts) * sizeof *kept);
    if (found && !status) ric_verify_pairs_judge(&pairs, ric_model_n_mode(m), at, out);
    free(kept);
    free(pairs.own);
    return status;
}

static void check_numbers(const replay *r, const ric_point *at, double energy, ric_claims *out)
{
    double omega = RIC_TWO_PI / r->stored[r->n];
    const char *name = !(fabs(at->frequency - omega) <= FLIGHT * omega)  ? "frequency"
                       : !(fabs(at->energy - energy) <= FLIGHT * energy) ? "energy"
                       : !isnan(at->approach)                            ? "approach"
                       : !(isnan(at->reach) || at->reach == 0)           ? "reach"
                                                                         : NULL;
    out->numbers = name ? RIC_AGREES_NO : RIC_AGREES_YES;
    if (name)
        snprintf(out->finding, sizeof out->finding, "the stored %s is not that of the orbit", name);
}

/* A mode that no contact sees: a linear motion. */
static void check_linear(const ric_point *at, ric_claims *out)
{
    out->stable = at->stable == RIC_STABLE_YES ? RIC_AGREES_YES : RIC_AGREES_NO;
    if (out->stable == RIC_AGREES_NO)
        snprintf(out->finding, sizeof out->finding, "a linear mode is stable");
}

/* ------------------------------------------------------------------- motion */

static void put_away(replay *r)
{
    ric_simulator_power_free(r->springs);
    free(r->start);
    free(r->M);
    free(r->stored);
}

/* What is replayed, polished if need be; out, and the energy of the stored state. */
static ric_status check_motion(replay *r, const ric_model *m, const ric_point *at, ric_check *out,
                               double *energy)
{
    double growth;
    ric_status status = fly_through(r, r->parts);
    if (status) return status;
    *energy = ric_model_energy(m, r->stored, r->stored + r->n / 2);
    out->energy_error = *energy > 0 ? fabs(at->energy - *energy) / *energy : fabs(at->energy);
    if ((status = find_condition(r, &out->condition, &growth))) return status;
    if (growth > STEEP && gap(r) > RETURN * fmax(1, AMPLIFIED * out->condition)) {
        if ((status = polish(r, &out->condition))) return status;
        for (int i = 0; i < r->n; i++)
            out->flight_error = fmax(out->flight_error,
                                     (double)(fabsl(r->start[i] - r->stored[i]) / unit(r, i)));
    }
    double amplified = fmax(1, AMPLIFIED * out->condition);
    out->return_error = gap(r);
    out->energy_error = fmax(out->energy_error, drift(r, m, *energy) / amplified);
    out->passed = out->flight_error <= FLIGHT && out->energy_error <= FLIGHT &&
                  out->return_error <= RETURN * amplified;
    return RIC_OK;
}

ric_status ric_verify_smooth(const ric_atlas *atlas, int branch, int point, ric_check *out,
                             ric_claims *claims)
{
    replay r = {0};
    ric_point at;
    ric_branch b;
    ric_verify_asked asked = {0};
    double energy;
    const ric_model *m = ric_atlas_model(atlas);
    *out = (ric_check){.branch = branch, .point = point, .condition = 1, .faces_agree = true};
    ric_status status = set_up(&r, atlas, branch, point, &at);
    if (status || (status = ric_atlas_branch(atlas, branch, &b)) ||
        (status = check_motion(&r, m, &at, out, &energy)))
        goto out;
    if (!claims) goto out;
    check_numbers(&r, &at, energy, claims);
    if (ric_branch_linear(m, &b)) check_linear(&at, claims);
    else if (!(status = ric_verify_asked_open(atlas, branch, point, &at, &asked)))
        status = check_multipliers(&r, m, &b, &at, &asked, claims);
out:
    ric_verify_asked_close(&asked);
    put_away(&r);
    return status;
}

ric_status ric_verify_smooth_images(const ric_atlas *atlas, int branch, int point, real fit[2],
                                    real *start)
{
    replay r = {0};
    ric_point at;
    real size[2] = {0, 0};
    ric_status status = set_up(&r, atlas, branch, point, &at);
    if (!status) status = fly_through(&r, r.parts / 2);
    for (int i = 0; i < r.n && !status; i++) {
        start[i] = r.start[i] / unit(&r, i);
        size[i >= r.n / 2] = fmaxl(size[i >= r.n / 2], fabsl(start[i]));
    }
    if (!status) {
        fit[0] = off_image(&r);
        fit[1] = fminl(size[0], size[1]); /* at a centre, or at rest */
    }
    put_away(&r);
    return status;
}
