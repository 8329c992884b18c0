/* Independent integrator of M x'' + K x + sum_f k_f(b_f . x) b_f = 0 with power-law springs.
 *
 * It shares no code with the orbit solver: no modes, no series, but the extrapolation of Gragg,
 * Bulirsch and Stoer (Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, II.9 and
 * II.14) on the raw matrices in extended precision. A step H is taken with 2, 4, 6, ... sub-steps
 * of the leap-frog for second-order equations, whose errors are even powers of the sub-step, and
 * extrapolated to none; it is accepted where two neighbours in the table agree to TOLERANCE.
 *
 * Small deviations are integrated along, each sub-step with the stiffness of the springs where it
 * takes the state. They are doubles: what is asked of them are multipliers, and not to the last
 * digit. */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>

#include "simulator_power.h"
#include "base/room.h"

enum { LEVELS = 12, AIM = 8, MOST_STEPS = 100000 };
/* TOLERANCE: of a step, relative to the largest displacement and the largest velocity: a hundred
 * roundings of 80 bits */
#define TOLERANCE 1e-17L
/* DEVIATION: of columns, relative to the largest entry: the table is then off by a hundredth of it,
 * some roundings of a double; a motion in a slow mode says nothing of what the fast ones need */
#define DEVIATION 1e-12
#define ROUNDINGS 90 /* or as many of what the machine, or what pretends to be one, has instead */

typedef ric_real real;

struct ric_simulator_power {
    int n, n_contact;
    real length;  /* x is displacement / length */
    real *L;      /* [n * n] Cholesky factor of M */
    real *K;      /* [n * n] */
    real *b;      /* [n_contact * n] */
    real *factor; /* [n_contact] force on scaled x: factor s^m */
    int *exponent;
    real tolerance; /* TOLERANCE or ROUNDINGS */
    real step;      /* of the last accepted step */
    real *table;    /* [(LEVELS + 6) * 2n] */
    /* of deviations: */
    double *A, *d;   /* [n * n] M^-1 K, [n_contact * n] M^-1 b_f */
    double *stiff;   /* [n_contact] derivatives of the forces */
    double *columns; /* [(LEVELS + 3) * 4 n^2] table, workspace */
};

/* Of a real as it is computed: valgrind gives it the 53 bits of a double. */
static real epsilon(void)
{
    volatile real e = 1, sum = 2;
    while (sum > 1) {
        e /= 2;
        sum = 1 + e / 2;
    }
    return e;
}

static real power(real s, int exponent)
{
    real result = 1;
    for (; exponent > 0; exponent /= 2) {
        if (exponent % 2) result *= s;
        s *= s;
    }
    return result;
}

/* M^-1 x in place. */
static void divide_by_mass(const ric_simulator_power *s, real *a)
{
    int n = s->n;
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < i; k++) a[i] -= s->L[i * n + k] * a[k];
        a[i] /= s->L[i * n + i];
    }
    for (int i = n - 1; i >= 0; i--) {
        for (int k = i + 1; k < n; k++) a[i] -= s->L[k * n + i] * a[k];
        a[i] /= s->L[i * n + i];
    }
}

static ric_status prepare_columns(ric_simulator_power *s)
{
    int n = s->n;
    size_t nn = (size_t)n * (size_t)n, cn = (size_t)s->n_contact * (size_t)n;
    real column[n];
    if (!(s->A = ric_calloc(nn + cn + (size_t)s->n_contact + (LEVELS + 3) * 4 * nn, sizeof *s->A)))
        return ric_fail(RIC_E_NOMEM, "no memory to integrate %d degrees of freedom", n);
    s->d = s->A + nn;
    s->stiff = s->d + cn;
    s->columns = s->stiff + s->n_contact;
    for (int j = 0; j < n; j++) {
        for (int i = 0; i < n; i++) column[i] = s->K[i * n + j];
        divide_by_mass(s, column);
        for (int i = 0; i < n; i++) s->A[i * n + j] = (double)column[i];
    }
    for (int f = 0; f < s->n_contact; f++) {
        memcpy(column, s->b + f * n, sizeof column);
        divide_by_mass(s, column);
        for (int i = 0; i < n; i++) s->d[f * n + i] = (double)column[i];
    }
    return RIC_OK;
}

ric_status ric_simulator_power_create(const ric_model *model, ric_simulator_power **out)
{
    ric_status status = RIC_OK;
    int n = ric_model_n_dof(model), n_contact = ric_model_n_contact(model);
    size_t nn = (size_t)n * (size_t)n,
           all = 2 * nn + (size_t)n_contact * ((size_t)n + 1) + (LEVELS + 6) * 2 * (size_t)n;
    ric_simulator_power *s = ric_calloc(1, sizeof *s);
    *out = NULL;
    if (!s || !(s->L = ric_calloc(all, sizeof *s->L)) ||
        !(s->exponent = ric_calloc((size_t)n_contact, sizeof *s->exponent))) {
        status = ric_fail(RIC_E_NOMEM, "no memory to integrate %d degrees of freedom", n);
        goto out;
    }
    s->n = n;
    s->n_contact = n_contact;
    s->length = ric_model_length(model);
    s->tolerance = fmax(TOLERANCE, ROUNDINGS * epsilon());
    s->K = s->L + nn;
    s->b = s->K + nn;
    s->factor = s->b + (size_t)n_contact * (size_t)n;
    s->table = s->factor + n_contact;
    for (size_t i = 0; i < nn; i++) {
        s->L[i] = ric_model_mass(model)[i];
        s->K[i] = ric_model_stiffness(model)[i];
    }
    if (!ric_simulator_cholesky(n, s->L)) {
        status = ric_fail(RIC_E_NUMERIC, "the mass matrix is not positive definite");
        goto out;
    }
    for (int f = 0; f < n_contact && !status; f++) {
        ric_contact contact;
        if ((status = ric_model_contact(model, f, &contact))) break;
        for (int i = 0; i < n; i++) s->b[f * n + i] = contact.normal[i];
        s->exponent[f] = contact.exponent;
        s->factor[f] = contact.length > 0
                           ? contact.reference *
                                 power(s->length / contact.length, contact.exponent) *
                                 contact.length / s->length
                           : contact.stiffness * power(s->length, contact.exponent) / s->length;
    }
    if (status || (status = prepare_columns(s))) goto out;
    *out = s;
    s = NULL;
out:
    ric_simulator_power_free(s);
    return status;
}

void ric_simulator_power_free(ric_simulator_power *s)
{
    if (!s) return;
    free(s->L);
    free(s->exponent);
    free(s->A);
    free(s);
}

/* x'' [n] of a displacement; with `stiff` also the slopes of the forces there. */
static void accelerate(const ric_simulator_power *s, const real *x, bool stiff, real *a)
{
    int n = s->n;
    for (int i = 0; i < n; i++) {
        a[i] = 0;
        for (int j = 0; j < n; j++) a[i] -= s->K[i * n + j] * x[j];
    }
    for (int f = 0; f < s->n_contact; f++) {
        real gap = 0;
        for (int i = 0; i < n; i++) gap += s->b[f * n + i] * x[i];
        real slope = s->factor[f] * power(gap, s->exponent[f] - 1), force = slope * gap;
        if (stiff) s->stiff[f] = (double)(s->exponent[f] * slope);
        for (int i = 0; i < n; i++) a[i] -= force * s->b[f * n + i];
    }
    divide_by_mass(s, a);
}

/* V [n * m] += kick times the accelerations of the displacements X [n * m] of m = 2n deviations,
 * under the slopes s->stiff. */
static void kick_columns(const ric_simulator_power *s, double kick, const double *X, double *V)
{
    int n = s->n, m = 2 * n;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            double factor = -kick * s->A[i * n + j];
            for (int c = 0; c < m; c++) V[i * m + c] += factor * X[j * m + c];
        }
    for (int f = 0; f < s->n_contact; f++) {
        double gap[m];
        memset(gap, 0, sizeof gap);
        for (int j = 0; j < n; j++) {
            double b = (double)s->b[f * n + j];
            for (int c = 0; c < m && b != 0; c++) gap[c] += b * X[j * m + c];
        }
        for (int i = 0; i < n; i++) {
            double factor = -kick * s->stiff[f] * s->d[f * n + i];
            for (int c = 0; c < m; c++) V[i * m + c] += factor * gap[c];
        }
    }
}

/* `parts` sub-steps of the leap-frog, kicked by halves at both ends; a [n], first that of y. Y [2n
 * * 2n], displacements above velocities, are deviations, NULL: none; stiff0 [n_contact] the slopes
 * at their start. */
static void leap(const ric_simulator_power *s, real H, int parts, const real *y, const real *a0,
                 real *a, real *out, const double *Y, const double *stiff0, double *Out)
{
    int n = s->n, half = 2 * n * n;
    real h = H / parts;
    memcpy(out, y, 2 * (size_t)n * sizeof *out);
    for (int i = 0; i < n; i++) out[n + i] += h / 2 * a0[i];
    if (Y) {
        memcpy(Out, Y, 2 * (size_t)half * sizeof *Out);
        memcpy(s->stiff, stiff0, (size_t)s->n_contact * sizeof *stiff0);
        kick_columns(s, (double)(h / 2), Y, Out + half);
    }
    for (int k = 1; k <= parts; k++) {
        for (int i = 0; i < n; i++) out[i] += h * out[n + i];
        accelerate(s, out, Y, a);
        real kick = k < parts ? h : h / 2;
        for (int i = 0; i < n; i++) out[n + i] += kick * a[i];
        if (!Y) continue;
        double step = (double)h;
        for (int i = 0; i < half; i++) Out[i] += step * Out[half + i];
        kick_columns(s, (double)kick, Out, Out + half);
    }
}

/* Error of a table's last column relative to the size of the halves of y. */
static real difference(int n, const real *a, const real *b, const real *y)
{
    real worst = 0;
    for (int half = 0; half < 2; half++) {
        real size = 0, off = 0;
        for (int i = half * n; i < (half + 1) * n; i++) {
            if (!isfinite(a[i]) || !isfinite(b[i])) return HUGE_VAL;
            size = fmax(size, fmax(fabs(y[i]), fabs(a[i])));
            off = fmax(off, fabs(a[i] - b[i]));
        }
        if (off > 0) worst = fmax(worst, off / size);
    }
    return worst;
}

/* One step of at most H; returns what was done, with y after it, 0 if it fails. */
/* One stage of the extrapolation of columns; how far it moves them, relative to the largest entry.
 */
static double extrapolate_columns(size_t size, double factor, double *Up, const double *Down)
{
    double most = 0, largest = 0;
    for (size_t i = 0; i < size; i++) {
        double before = Up[i];
        Up[i] = Down[i] + (Down[i] - Up[i]) * factor;
        most = fmax(most, fabs(Up[i] - before));
        largest = fmax(largest, fabs(Up[i]));
    }
    return most > 0 ? most / largest : 0;
}

static real step(ric_simulator_power *s, real H, real *y, double *Y)
{
    int n = s->n;
    size_t size = 4 * (size_t)n * (size_t)n;
    double stiff0[s->n_contact + 1];
    real *a0 = s->table + LEVELS * 2 * n, *a = a0 + n, *last = a + n, *corner = last + 2 * n;
    accelerate(s, y, Y, a0);
    memcpy(stiff0, s->stiff, (size_t)s->n_contact * sizeof *stiff0);
    for (int attempt = 0; attempt < 60; attempt++) {
        for (int k = 0; k < LEVELS; k++) {
            real *row = s->table + (size_t)k * 2 * (size_t)n;
            double moved = 0;
            leap(s, H, 2 * (k + 1), y, a0, a, row, Y, stiff0, s->columns + (size_t)k * size);
            /* Aitken and Neville, in place from the newest row upwards */
            if (k) memcpy(corner, s->table, 2 * (size_t)n * sizeof *corner);
            for (int j = k - 1; j >= 0; j--) {
                real ratio = (real)(k + 1) / (j + 1), factor = 1 / (ratio * ratio - 1);
                real *up = s->table + (size_t)j * 2 * (size_t)n, *down = up + 2 * n;
                for (int i = 0; i < 2 * n; i++) up[i] = down[i] + (down[i] - up[i]) * factor;
                double *Up = s->columns + (size_t)j * size;
                if (Y) moved = extrapolate_columns(size, (double)factor, Up, Up + size);
            }
            if (k < 3 || difference(n, s->table, corner, y) > s->tolerance || !(moved <= DEVIATION))
                continue;
            memcpy(y, s->table, 2 * (size_t)n * sizeof *y);
            if (Y) memcpy(Y, s->columns, size * sizeof *Y);
            s->step = H * (k < AIM ? 1.5L : k > AIM ? 0.7L : 1);
            return H;
        }
        H *= 0.4L;
    }
    return 0;
}

ric_status ric_simulator_power_go(ric_simulator_power *s, ric_real time, ric_real *y, double *Y)
{
    real done = 0;
    if (!(s->step > 0)) s->step = 0.1L;
    for (int k = 0; done < time; k++) {
        if (k == MOST_STEPS)
            return ric_fail(RIC_E_RANGE,
                            "the motion up to time %.9g took %d steps; follow it in shorter pieces",
                            (double)done, k);
        if (ric_halt(LEVELS * LEVELS * 8.0 * s->n * s->n * (Y ? s->n : 1)))
            return ric_fail(RIC_E_INTERRUPTED, "stopped on request at time %.9g", (double)done);
        real rest = time - done, H = fmin(s->step, rest), kept = s->step, taken = step(s, H, y, Y);
        if (!(taken > 0))
            return ric_fail(RIC_E_NUMERIC, "the motion cannot be followed beyond time %.9g",
                            (double)done);
        if (taken == rest) { /* the last step is as short as what was left */
            s->step = fmax(s->step, kept < rest ? 0 : kept);
            break;
        }
        done += taken;
    }
    return RIC_OK;
}

void ric_simulator_power_accelerations(const ric_simulator_power *s, const ric_real *x, ric_real *a)
{
    accelerate(s, x, false, a);
}
