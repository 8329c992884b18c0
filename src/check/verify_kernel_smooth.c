/* The equations of an orbit under power-law springs: the period is cut into parts, each flown from
 * a start of its own, and takes the same part of it. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>

#include "simulator_power.h"
#include "base/room.h"
#include "verify_kernel.h"
#include "verify_smooth.h"

typedef ric_real real;
enum { PARTS = 16 };

typedef struct {
    ric_simulator_power *springs;
    int d, k;          /* degrees of freedom, and modes that contacts see */
    real period, turn; /* turn: what a displacement counts beside a velocity */
    double size[2];    /* largest displacement and velocity */
    real *to, *from;   /* [k * d] and [d * k]: into the modes and back */
    real *start;       /* [(PARTS + 1) * 2d] of every part, and the end */
    double *M,
        *flow; /* [PARTS * 2k * 2k] of every part and [PARTS * 2k] at its end, in the modes */
} parts;

/* Modes, times `turn` for displacements, of a state. */
static void put_state(const parts *q, const real *y, double *out)
{
    for (int i = 0; i < 2 * q->k; i++) {
        real sum = 0;
        for (int a = 0; a < q->d; a++) sum += q->to[i % q->k * q->d + a] * y[i / q->k * q->d + a];
        out[i] = (double)(i < q->k ? q->turn * sum : sum);
    }
}

static void find_flow(const parts *q, const real *y, double *out)
{
    real rate[2 * q->d];
    memcpy(rate, y + q->d, (size_t)q->d * sizeof *rate);
    ric_simulator_power_accelerations(q->springs, y, rate + q->d);
    put_state(q, rate, out);
}

/* Part j from its start: the start of the next, its matrix and its flow. Y [2d * 2d] workspace. */
static ric_status fly(const parts *q, int j, double *Y)
{
    const int d = q->d, k = q->k, n = 2 * d;
    real *y = q->start + (j + 1) * n;
    memcpy(y, y - n, (size_t)n * sizeof *y);
    for (int i = 0; i < n * n; i++) Y[i] = i / n == i % n ? q->size[i % n >= d] : 0;
    const ric_status status = ric_simulator_power_go(q->springs, q->period / PARTS, y, Y);
    for (int c = 0; c < 2 * k && !status; c++) {
        real column[n];
        double image[2 * k];
        for (int i = 0; i < n; i++) {
            column[i] = 0;
            for (int a = 0; a < d; a++)
                column[i] += Y[i * n + c / k * d + a] / q->size[c / k] * q->from[a * k + c % k];
            if (c < k) column[i] /= q->turn;
        }
        put_state(q, column, image);
        for (int i = 0; i < 2 * k; i++) q->M[(j * 2 * k + i) * 2 * k + c] = image[i];
    }
    if (!status) find_flow(q, y, q->flow + j * 2 * k);
    return status;
}

static double norm_of(int n, const double *x)
{
    double sum = 0;
    for (int i = 0; i < n; i++) sum += x[i] * x[i];
    return sqrt(sum);
}

/* Rows: the ends of all parts, and that the start does not move along the orbit, which a start that
 * turns does not. */
static void fill(const ric_equations *of, ric_number *J, ric_number turn, ric_still row)
{
    const parts *q = of->of;
    const int m = 2 * q->k, last = m * PARTS, ld = of->size + 1;
    const bool turns = turn != 1;
    const double *ahead = q->flow + (PARTS - 1) * m, ahead_norm = norm_of(m, ahead);
    double most = 0;
    for (int j = 0; j < PARTS; j++) most = fmax(most, norm_of(m, q->flow + j * m));
    for (int j = 0; j < PARTS; j++)
        for (int i = 0; i < m; i++) {
            const int at = j * m + i;
            for (int c = 0; c < m; c++) J[(j * m + c) * ld + at] = q->M[at * m + c];
            J[((j + 1) % PARTS * m + i) * ld + at] -= j + 1 < PARTS ? 1 : turn;
            if (!turns) J[last * ld + at] = q->flow[at] / most;
        }
    for (int c = 0; c < m && !turns; c++) J[c * ld + last] = ahead[c] / ahead_norm;
    if (turns) J[last * ld + last] = 1;
    /* the gradient of the energy is the flow, turned by a quarter, each part by its unit */
    double gradient[m];
    for (int i = 0; i < q->k; i++) {
        gradient[i] = -ahead[q->k + i] / (double)q->turn;
        gradient[q->k + i] = ahead[i] / (double)q->turn;
    }
    const double size = norm_of(m, gradient);
    for (int c = 0; c < m && row == RIC_STILL_ENERGY; c++)
        J[c * ld + last + 1] = gradient[c] / size;
    if (row == RIC_STILL_PERIOD) J[last * ld + last + 1] = 1;
}

/* The period in parts, from the stored start. Returns what is left open at its end, relative. */
static ric_status fly_all(parts *q, const ric_junction *j, double *open)
{
    const int n = 2 * q->d;
    double end[2 * q->k], *Y = ric_malloc((size_t)(n * n) * sizeof *Y);
    ric_status status = Y ? RIC_OK : ric_no_memory("the parts of an orbit");
    for (int i = 0; i < n; i++) {
        q->start[i] = j->state[i];
        q->size[i >= q->d] = fmax(q->size[i >= q->d], fabs(j->state[i]));
    }
    q->size[0] = fmax(q->size[0], q->size[1] / (double)q->turn);
    q->size[1] = fmax(q->size[1], q->size[0] * (double)q->turn);
    for (int i = 0; i < PARTS && !status; i++) status = fly(q, i, Y);
    if (!status) {
        real apart[n];
        for (int i = 0; i < n; i++) apart[i] = q->start[PARTS * n + i] - q->start[i];
        put_state(q, apart, end);
        *open = norm_of(2 * q->k, end);
        put_state(q, q->start, end);
        *open /= norm_of(2 * q->k, end);
    }
    free(Y);
    return status;
}

ric_status ric_verify_kind_smooth(const ric_model *m, ric_simulator_power *springs,
                                  const ric_junction *j, ric_real period, ric_claims *out)
{
    if (!ric_verify_kernel_tells(j->kind)) return RIC_OK;
    parts q = {.springs = springs,
               .d = ric_model_n_dof(m),
               .k = ric_model_n_mode(m),
               .period = period,
               .turn = RIC_TWO_PI_LONG / period};
    const size_t d = (size_t)q.d, k = (size_t)q.k, n = 2 * k;
    q.to = ric_malloc((2 * k * d + (PARTS + 1) * 2 * d) * sizeof *q.to);
    q.M = ric_malloc(PARTS * n * (n + 1) * sizeof *q.M);
    if (!q.to || !q.M) {
        free(q.to);
        free(q.M);
        return ric_no_memory("the parts of an orbit");
    }
    q.from = q.to + k * d;
    q.start = q.from + d * k;
    q.flow = q.M + PARTS * n * n;
    ric_equations of = {.size = PARTS * (int)n + 1, .of = &q, .fill = fill};
    ric_status status = ric_verify_smooth_modes(m, q.d, q.k, q.from, q.to);
    if (!status) status = fly_all(&q, j, &of.open);
    if (!status) status = ric_verify_kernel(&of, j, out);
    free(q.to);
    free(q.M);
    return status;
}
