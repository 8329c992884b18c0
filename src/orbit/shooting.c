#include "shooting_nodes.h"
#include "shooting_lanes.h"
#include "shooting_parts.h"

#include <stdlib.h>
#include <string.h>

#include <lapacke.h>

#include "base/room.h"

/* SMOOTH_ROUNDING: of what a flight of law power says it loses (power_flow.h): of 600 flights 599
 * keep within it */
#define SMOOTH_ROUNDING 4

static int count_start(const ric_model *m, ric_mirror start)
{
    return start == RIC_MIRROR_NONE ? 2 * m->n : start == RIC_MIRROR_IMPACT ? m->n + 1 : m->n;
}

static int count_end(int n, ric_mirror end)
{
    return end == RIC_MIRROR_NONE ? 2 * n - 1 : end == RIC_MIRROR_IMPACT ? n - 1 : n;
}

static int count_periods(ric_mirror start, ric_mirror end, int sigma)
{
    if (start == RIC_MIRROR_NONE) return sigma > 0 ? 1 : 2;
    return (start == RIC_MIRROR_CENTRE) != (end == RIC_MIRROR_CENTRE) ? 4 : 2;
}

ric_status ric_shooting_create(const ric_model *model, ric_mirror start, ric_mirror end, int sigma,
                               int n_flight, const int *face, ric_shooting **out)
{
    int n = model->n;
    ric_shooting *c = ric_calloc(1, sizeof *c);
    *out = NULL;
    if (!c) return ric_no_memory("an orbit problem");
    c->model = model;
    c->n = n;
    c->start = start;
    c->end = end;
    c->sigma = sigma;
    c->multiple = count_periods(start, end, sigma);
    c->n_flight = n_flight;
    c->n_start = count_start(model, start);
    c->parts = 1;
    c->scale = 1;
    c->n_unknown = c->n_start + n_flight;
    c->n_end = count_end(n, end);
    const size_t flights = (size_t)n_flight, nn = (size_t)n;
    c->stride = ric_flight_stride(model);
    c->face = ric_malloc((flights + 1) * sizeof *c->face);
    c->closed = ric_calloc(flights + 1, sizeof *c->closed);
    const size_t chord = ric_flight_law_of(model)->closes ? 2 * nn + 1 : 0;
    double **const arrays[] = {&c->w,        &c->before, &c->rate, &c->map,
                               &c->approach, &c->tau,    &c->chord};
    const size_t sizes[] = {(flights + 1) * 2 * nn, flights * nn, flights * 2 * nn,
                            flights * c->stride,    flights + 1,  flights,
                            flights * chord};
    if (!c->face || !c->closed || !ric_shooting_nodes_room(7, sizes, arrays) ||
        ric_shooting_nodes_divide(c, 1)) {
        ric_shooting_free(c);
        return ric_fail(RIC_E_NOMEM, "no memory for an orbit problem of %d flights", n_flight);
    }
    memcpy(c->face, face, (flights + 1) * sizeof *face);
    ric_shooting_close(c, 0);
    *out = c;
    return RIC_OK;
}

void ric_shooting_close(ric_shooting *c, uint64_t closed)
{
    double fastest = 0;
    c->closed[0] = closed;
    for (int k = 0; k < c->n_flight; k++)
        c->closed[k + 1] = ric_flight_toggle(c->model, c->closed[k], c->face[k + 1]);
    for (int k = 0; k < c->n_flight; k++)
        fastest = fmax(fastest, ric_flight_fastest(c->model, c->closed[k]));
    c->fastest = fastest;
}

ric_shooting *ric_shooting_copy(const ric_shooting *c)
{
    ric_shooting *copy = NULL;
    ric_shooting_create(c->model, c->start, c->end, c->sigma, c->n_flight, c->face, &copy);
    if (!copy) return NULL;
    ric_shooting_close(copy, c->closed[0]);
    if (c->parts == 1 || !ric_shooting_nodes_divide(copy, c->parts)) return copy;
    ric_shooting_free(copy);
    return NULL;
}

void ric_shooting_free(ric_shooting *c)
{
    if (!c) return;
    free(c->face);
    free(c->w); /* and what lies behind it */
    free(c->closed);
    free(c->hv); /* likewise */
    free(c->kept);
    free(c);
}

/* ---------------------------------------------------------------- states */

/* Start state from the start block; returns the gap residual at an impact start (0 elsewhere). */
static inline __attribute__((always_inline)) double start_state(ric_shooting *c, int n,
                                                                const double *u)
{
    double *w = c->w;
    const ric_face *face = c->face[0] >= 0 ? &c->model->face[c->face[0]] : NULL;
    switch (c->start) {
    case RIC_MIRROR_NONE:
        memcpy(w, u, 2 * (size_t)n * sizeof *w);
        return face ? ric_gap(n, face, w) - face->gap : 0;
    case RIC_MIRROR_REST:
        memcpy(w, u, (size_t)n * sizeof *w);
        memset(w + n, 0, (size_t)n * sizeof *w);
        return 0;
    case RIC_MIRROR_CENTRE:
        memset(w, 0, (size_t)n * sizeof *w);
        memcpy(w + n, u, (size_t)n * sizeof *w);
        return 0;
    case RIC_MIRROR_IMPACT:
        memcpy(w, u, (size_t)n * sizeof *w);
        for (int i = 0; i < n; i++) w[n + i] = -face->side * u[n] / sqrt(face->cc) * face->c[i];
        c->approach[0] = u[n] * sqrt(face->cc);
        return ric_gap(n, face, w) - face->gap;
    }
    return 0;
}

/* `u` from the time of flight k on. Returns what the flight leaves of the condition at its end. */
static inline __attribute__((always_inline)) double fly_one(ric_shooting *c, int n, int k,
                                                            const double *u)
{
    const ric_model *m = c->model;
    double *map = c->map + c->stride * (size_t)k, *w = c->w + 2 * n * (k + 1), tau = *u;
    const ric_face *face = c->face[k + 1] >= 0 ? &m->face[c->face[k + 1]] : NULL;
    c->tau[k] = tau;
    if (m->law == RIC_LAW_POWER) {
        if (!ric_shooting_nodes_fly(c, k, u)) return 0;
    } else if (ric_flight_dense(m, c->closed[k]))
        ric_flight_map(m, c->closed[k], ric_shooting_event(c, k), tau, c->w + 2 * n * k, map, w,
                       c->rate + 2 * n * k);
    else {
        ric_flight_trig(m, n, tau, map);
        ric_flight(n, map, c->w + 2 * n * k, w);
    }
    for (int i = 0; i < n; i++) c->before[n * k + i] = w[n + i];
    if (!face) return 0;
    double speed = 0;
    for (int i = 0; i < n; i++) speed += face->c[i] * w[n + i];
    c->approach[k + 1] = face->side * speed;
    if (face->spring == 0 && !(k + 1 == c->n_flight && c->end == RIC_MIRROR_IMPACT)) {
        const double factor = speed * (2 / face->cc);
        for (int i = 0; i < n; i++) w[n + i] -= factor * face->c[i];
    }
    if (ric_shooting_between(c, k)) {
        double *by = c->chord + (2 * n + 1) * k;
        const double chord = ric_flight_chord(m, c->closed[k], c->face[k], c->face[k + 1], tau,
                                              c->w + 2 * n * k, by, by + 2 * n);
        if (!c->plain) return chord;
    }
    return ric_gap(n, face, w) - face->gap;
}

/* Residual of end condition i of a reversible chain, and the row that it is of the state: rows of
 * p, of a, or of E p. */
static inline double end_residual(const ric_shooting *c, int n, int i)
{
    const double *w = c->w + 2 * n * c->n_flight;
    switch (c->end) {
    case RIC_MIRROR_REST: return w[n + i];
    case RIC_MIRROR_CENTRE: return w[i];
    case RIC_MIRROR_IMPACT:
        return ric_dot(n, c->model->face[c->face[c->n_flight]].E + i * n, w + n);
    default: return w[i] - c->sigma * c->w[i];
    }
}

static inline __attribute__((always_inline)) void set_residual(ric_shooting *c, int n,
                                                               const double *u, double largest)
{
    int rows = c->end == RIC_MIRROR_NONE ? 2 * n : c->n_end;
    double sum = 0;
    for (int i = 0; i < 2 * n; i++) sum += c->w[i] * c->w[i];
    for (int i = 0; i < rows; i++) largest = ric_larger(largest, fabs(end_residual(c, n, i)));
    c->scale = 1 + sqrt(sum);
    c->share = ric_model_detached(c->model) ? 1 : fmin(sqrt(sum), 1);
    largest = fmax(largest, ric_shooting_nodes_gap(c, u));
    double longest = 0, fastest = 0;
    const double *end = c->w + 2 * n * c->n_flight;
    for (int k = 0; k < c->n_flight; k++) longest = ric_larger(longest, u[c->n_start + k]);
    for (int i = 0; i < n; i++)
        fastest = ric_larger(fastest,
                             c->model->kappa[i] * ric_larger(fabs(end[i]), fabs(end[n + i])));
    double reach = 0;
    for (int i = 0; i < n; i++) reach += end[i] * end[i];
    c->stiff = c->fastest > 0 ? c->fastest * sqrt(reach) / c->scale : 0;
    c->grain = longest * fastest / c->scale;
    c->grain += SMOOTH_ROUNDING * c->lost / c->scale;
    c->residual = largest / c->scale;
    if (!(c->residual < HUGE_VAL)) c->residual = HUGE_VAL;
}

/* Nothing is known of the orbit any more. */
static bool halted(ric_shooting *c)
{
    if (!ric_halt((double)c->n_flight * c->n * (8 + c->n))) return false;
    c->residual = HUGE_VAL;
    c->singular = true;
    return true;
}

static inline __attribute__((always_inline)) void fly_all(ric_shooting *c, int n, const double *u)
{
    double largest = fabs(start_state(c, n, u));
    for (int k = 0; k < c->n_flight; k++) {
        double gap = fabs(fly_one(c, n, k, u + c->n_start + k));
        /* in the general form the last gap follows from the closure */
        if (!(ric_general(c) && k + 1 == c->n_flight)) largest = ric_larger(largest, gap);
    }
    set_residual(c, n, u, largest);
}

void ric_shooting_fly(ric_shooting *c, const double *u)
{
    if (halted(c)) return;
    switch (c->n) {
    case 2: fly_all(c, 2, u); break;
    case 3: fly_all(c, 3, u); break;
    default: fly_all(c, c->n, u);
    }
}

/* ---------------------------------------------------------- factorisation */

/* Columns of d(start state)/d(start block). */
static inline __attribute__((always_inline)) void start_columns(ric_shooting *c, int n, int rows,
                                                                int ld)
{
    double *X = c->X;
    memset(X, 0, (size_t)rows * (size_t)ld * sizeof *X);
    switch (c->start) {
    case RIC_MIRROR_NONE:
        for (int i = 0; i < 2 * n; i++) X[i * ld + i] = X[(2 * n + i) * ld + i] = 1;
        break;
    case RIC_MIRROR_REST:
        for (int i = 0; i < n; i++) X[i * ld + i] = 1;
        break;
    case RIC_MIRROR_CENTRE:
        for (int i = 0; i < n; i++) X[(n + i) * ld + i] = 1;
        break;
    case RIC_MIRROR_IMPACT: {
        const ric_face *face = &c->model->face[c->face[0]];
        for (int i = 0; i < n; i++) X[i * ld + i] = 1;
        for (int i = 0; i < n; i++) X[(n + i) * ld + n] = -face->side / sqrt(face->cc) * face->c[i];
    }
    }
}

/* State at the end of flight k, before the impact there. */
static inline void arriving(const ric_shooting *c, int n, int k, double *w)
{
    memcpy(w, c->w + 2 * n * (k + 1), (size_t)n * sizeof *w);
    memcpy(w + n, c->before + n * k, (size_t)n * sizeof *w);
}

static inline __attribute__((always_inline)) void carry_dense(ric_shooting *c, int n, int nz, int k,
                                                              int ld)
{
    const double *rate = c->rate + 2 * n * k;
    for (int i = 0; i < 2 * n; i++)
        c->X[i * ld + nz] = 0; /* was the column of the last time, pinned by now */
    ric_flight_carry(n, c->map + c->stride * (size_t)k, ld, ld, c->X);
    for (int i = 0; i < 2 * n; i++) c->X[i * ld + nz] = rate[i];
}

/* The row of a divided difference over flight k: entries of the live columns and of the
 * inhomogeneous one, which are still at its start; the derivative by its time is returned. */
static inline __attribute__((always_inline)) double chord_row(const ric_shooting *c, int n, int nz,
                                                              int k, int ld, double *g,
                                                              double *offset)
{
    const double *by_w = c->chord + (2 * n + 1) * k;
    *offset = 0;
    for (int j = 0; j < nz; j++) g[j] = 0;
    for (int i = 0; i < 2 * n; i++) {
        for (int j = 0; j < nz; j++) g[j] += by_w[i] * c->X[i * ld + j];
        *offset += by_w[i] * c->X[i * ld + ld - 1];
    }
    return by_w[2 * n];
}

/* g [ld] of the rows of X: those of the condition h [n]. */
static inline __attribute__((always_inline)) void row_of(int n, const double *h, int ld,
                                                         const double *X, double *g)
{
    for (int j = 0; j < ld; j++) g[j] = h[0] * X[j];
    for (int i = 1; i < n; i++)
        for (int j = 0; j < ld; j++) g[j] += h[i] * X[i * ld + j];
}

/* An impact of all columns: their velocities are reflected. */
static inline __attribute__((always_inline)) void strike_columns(int n, const ric_face *face,
                                                                 int ld, double *X)
{
    double sum[ld];
    row_of(n, face->c, ld, X + n * ld, sum);
    for (int i = 0; i < n; i++) {
        const double f = 2 / face->cc * face->c[i];
        for (int j = 0; j < ld; j++) X[(n + i) * ld + j] -= f * sum[j];
    }
}

/* Takes the live columns (nz of them and the inhomogeneous one) through flight k and its impact. */
static inline __attribute__((always_inline)) double carry(ric_shooting *c, int n, int nz, int k,
                                                          double gap, bool pinned, int rows, int ld)
{
    const ric_model *m = c->model;
    const double *map = c->map + c->stride * (size_t)k, *after = c->w + 2 * n * (k + 1),
                 *before = c->before + n * k;
    double *X = c->X, rho = 1, g[ld], offset = 0, by_tau = 0;
    bool chord = ric_shooting_between(c, k) && pinned;
    if (c->closed[k]) ric_flight_onto(m, c->closed[k], ric_shooting_event(c, k), ld, X);
    if (chord) by_tau = chord_row(c, n, nz, k, ld, g, &offset);
    if (ric_flight_dense(m, c->closed[k])) carry_dense(c, n, nz, k, ld);
    else
        for (int i = 0; i < n; i++) {
            double *restrict a = X + i * ld, *restrict p = X + (n + i) * ld;
            double co = map[i], s1 = map[n + i], s2 = map[2 * n + i];
            for (int j = 0; j < nz; j++) {
                double t = a[j];
                a[j] = co * t + s1 * p[j];
                p[j] = co * p[j] - s2 * t;
            }
            double t = a[ld - 1];
            a[ld - 1] = co * t + s1 * p[ld - 1];
            p[ld - 1] = co * p[ld - 1] - s2 * t;
            a[nz] = m->kappa[i] * before[i];
            p[nz] = -m->stiff[i] * after[i]; /* a does not change at an impact */
        }
    for (int r = 2 * n; r < rows; r++) X[r * ld + nz] = 0;
    if (c->face[k + 1] < 0) return rho;
    const ric_face *face = &m->face[c->face[k + 1]];
    /* rows are struck before columns are pinned, which wait for nothing of it */
    if (!(face->spring > 0 || (k + 1 == c->n_flight && c->end == RIC_MIRROR_IMPACT)))
        strike_columns(n, face, ld, X);
    if (!pinned) return rho;
    if (chord) g[nz] = by_tau;
    else {
        row_of(n, face->g, ld, X, g);
        offset = g[ld - 1];
    }
    return ric_pin(c, 1 + k, nz + 1, g, -gap - offset, rows, ld);
}

void ric_shooting_mean_gradient(const ric_shooting *c, double *h)
{
    int n = c->n;
    double from[2 * n];
    memcpy(from, c->w, sizeof from);
    for (int i = 0; i < 2 * n; i++) from[i] *= c->sigma;
    ric_flight_secant(c->model, c->closed[c->n_flight], from, c->w + 2 * n * c->n_flight, h);
}

/* Rows of the end conditions gathered at the top of X (2n - 1, n or n - 1 of them); the residual
 * goes into the inhomogeneous column. */
static inline __attribute__((always_inline)) double end_rows_general(ric_shooting *c, int n, int ld,
                                                                     int columns,
                                                                     const double *left)
{
    const double *wN = c->w + 2 * n * c->n_flight;
    double *X = c->X, h[2 * n], sum = 0;
    ric_shooting_mean_gradient(c, h);
    for (int r = 0; r < 2 * n; r++) {
        double *x = X + r * ld, *x0 = X + (2 * n + r) * ld;
        for (int j = 0; j < columns; j++) x[j] -= c->sigma * x0[j];
        x[ld - 1] += left ? -c->sigma * x0[ld - 1] + left[r]
                          : -c->sigma * x0[ld - 1] + wN[r] - c->sigma * c->w[r];
        sum += h[r] * h[r];
    }
    /* E(w_N) = E(w_0) holds for any u: the closure is perpendicular to the mean gradient h, and
     * that one row is dropped */
    int last = 2 * n - 1;
    double norm = sqrt(sum), sign = h[last] < 0 ? -1 : 1,
           beta = 1 / (norm * (norm + fabs(h[last])));
    h[last] += sign * norm;
    for (int j = 0; j < ld; j++) {
        if (j >= columns && j < ld - 1) continue;
        double s = 0;
        for (int r = 0; r < 2 * n; r++) s += h[r] * X[r * ld + j];
        s *= beta;
        for (int r = 0; r < 2 * n; r++) X[r * ld + j] -= s * h[r];
    }
    return sign;
}

static inline __attribute__((always_inline)) void end_rows_reversible(ric_shooting *c, int n,
                                                                      int ld, const double *left)
{
    double *X = c->X;
    if (c->end == RIC_MIRROR_REST) memmove(X, X + n * ld, (size_t)n * (size_t)ld * sizeof *X);
    else if (c->end == RIC_MIRROR_IMPACT) {
        ric_model_across(n, c->model->face[c->face[c->n_flight]].c, ld, ld, X + n * ld);
        memmove(X, X + n * ld, (size_t)(n - 1) * (size_t)ld * sizeof *X);
    }
    for (int r = 0; r < c->n_end; r++) X[r * ld + ld - 1] += left ? left[r] : end_residual(c, n, r);
}

/* The last 2n - 1, n or n - 1 rows, one Householder reflection each: one column is left, the
 * kernel. */
static inline __attribute__((always_inline)) void eliminate_end(ric_shooting *c, int rows, int ld,
                                                                double sign)
{
    int first = 1 + c->n_flight;
    double smallest = HUGE_VAL;
    for (int r = 0; r < rows; r++) {
        double g[ld];
        memcpy(g, c->X + r * ld, (size_t)ld * sizeof *g);
        double rho = ric_pin(c, first + r, rows + 1 - r, g, -g[ld - 1], rows, ld);
        sign *= rho;
        smallest = ric_smaller(smallest, fabs(rho));
    }
    c->smallest = smallest;
    c->end_det = sign;
}

static inline __attribute__((always_inline)) void evaluate(ric_shooting *c, const double *u, int n,
                                                           bool whole, bool nodes,
                                                           const double *left)
{
    int rows = whole ? 4 * n : 2 * n,
        ld = nodes   ? c->ld
             : whole ? 2 * n + 1
                     : n + 2,
        nz = c->n_start;
    double gap = start_state(c, n, u), largest = fabs(gap), sign = 1;
    const double *end = left ? left + 1 + c->n_flight : NULL;
    if (left) gap = left[0];
    c->singular = false;
    start_columns(c, n, rows, ld);
    if (c->start == RIC_MIRROR_NONE || c->start == RIC_MIRROR_IMPACT) {
        double g[ld];
        /* without an event to start from, not along the flow */
        if (c->face[0] < 0) ric_flight_rate(c->model, c->closed[0], c->w, g);
        else
            for (int j = 0; j < nz; j++) g[j] = j < n ? c->model->face[c->face[0]].g[j] : 0;
        if (ric_pin(c, 0, nz, g, -gap, rows, ld) < 0) sign = -sign;
        nz--;
    }
    int free_columns = whole ? 2 * n - 1 : n;
    for (int k = 0; k < c->n_flight; k++) {
        bool pinned = c->face[k + 1] >= 0 && !(whole && k + 1 == c->n_flight);
        gap = fly_one(c, n, k, u + c->n_start + k);
        if (left) gap = left[1 + k];
        if (nodes) sign *= ric_shooting_nodes_eliminate(c, u, free_columns, rows);
        else if (carry(c, n, free_columns, k, gap, pinned, rows, ld) < 0) sign = -sign;
        if (pinned) largest = ric_larger(largest, fabs(gap));
    }
    nz = c->end == RIC_MIRROR_IMPACT ? n : free_columns + 1;
    if (whole) sign *= end_rows_general(c, n, ld, nz, end);
    else end_rows_reversible(c, n, ld, end);
    if (whole) eliminate_end(c, 2 * n - 1, ld, sign);
    else if (c->end == RIC_MIRROR_IMPACT) eliminate_end(c, n - 1, ld, sign);
    else eliminate_end(c, n, ld, sign);
    set_residual(c, n, u, largest);
}

/* The same for two modes with rigid contacts. */
static void evaluate_lanes(ric_shooting *c, const double *u, const double *left)
{
    double gap = start_state(c, 2, u), largest = fabs(gap), sign;
    c->singular = false;
    if (ric_general(c)) ric_shooting_lanes_general(c, u, left, gap, &largest);
    else if (!ric_shooting_lanes_reversible(c, u, left, gap, &largest, &sign)) {
        end_rows_reversible(c, 2, 4, left ? left + 1 + c->n_flight : NULL);
        eliminate_end(c, 1, 4, sign);
    }
    set_residual(c, 2, u, largest);
}

void ric_shooting_evaluate(ric_shooting *c, const double *u)
{
    ric_shooting_evaluate_left(c, u, NULL);
}

void ric_shooting_evaluate_left(ric_shooting *c, const double *u, const double *left)
{
    bool whole = ric_general(c);
    if (halted(c)) return;
    if (c->parts > 1) {
        evaluate(c, u, c->n, whole, true, NULL);
        return;
    }
    if (ric_shooting_lanes_fit(c)) {
        evaluate_lanes(c, u, left);
        return;
    }
    /* the same code with n known to the compiler for the small structures that most atlases are
     * made of */
    switch (c->n) {
    case 1:
        whole ? evaluate(c, u, 1, true, false, left) : evaluate(c, u, 1, false, false, left);
        break;
    case 2:
        whole ? evaluate(c, u, 2, true, false, left) : evaluate(c, u, 2, false, false, left);
        break;
    case 3:
        whole ? evaluate(c, u, 3, true, false, left) : evaluate(c, u, 3, false, false, left);
        break;
    default: evaluate(c, u, c->n, whole, false, left);
    }
}

/* ------------------------------------------------------- back-substitution */

/* From the last column back to the start block: `end` [n_end + 1] are the values of the coordinates
 * that the end rows pinned, the first row's first, and that of the last column. With their number
 * known to the compiler what is live is in registers between two flights. */
static inline __attribute__((always_inline)) void unwind_of(const ric_shooting *c, int free_columns,
                                                            int ld, bool newton, const double *end,
                                                            double *du)
{
    const bool whole = ric_general(c);
    int m = 1;
    double z[ld];
    z[0] = end[c->n_end];
    for (int r = c->n_end - 1; r >= 0; r--) ric_unpin(c, 1 + c->n_flight + r, ++m, end[r], z);
    ric_shooting_nodes_unwind(c, newton, m, z, du);
    for (int k = c->n_flight - 1; k >= 0; k--) {
        bool pinned = c->face[k + 1] >= 0 && !(whole && k + 1 == c->n_flight);
        if (pinned) ric_unpin(c, 1 + k, free_columns + 1, newton ? c->zeta[1 + k] : 0, z);
        du[c->n_start + k] = z[free_columns];
    }
    if (c->n_start > free_columns) ric_unpin(c, 0, free_columns + 1, newton ? c->zeta[0] : 0, z);
    memcpy(du, z, (size_t)c->n_start * sizeof *du);
}

static void unwind(const ric_shooting *c, bool newton, const double *end, double *du)
{
    const bool whole = ric_general(c);
    switch (c->parts > 1 ? 0 : c->n) {
    case 2:
        whole ? unwind_of(c, 3, 5, newton, end, du) : unwind_of(c, 2, 4, newton, end, du);
        break;
    case 3:
        whole ? unwind_of(c, 5, 7, newton, end, du) : unwind_of(c, 3, 5, newton, end, du);
        break;
    default: unwind_of(c, whole ? 2 * c->n - 1 : c->n, c->ld, newton, end, du);
    }
}

void ric_shooting_step(const ric_shooting *c, bool newton, double alpha, double *du)
{
    double end[c->n_end + 1];
    for (int r = 0; r < c->n_end; r++) end[r] = newton ? c->zeta[1 + c->n_flight + r] : 0;
    end[c->n_end] = alpha;
    unwind(c, newton, end, du);
}

/* The square part of L, its columns in the order in which they were pinned, is lower triangular,
 * and its singular values are those of L: the least is above one over the norm of the inverse. */
double ric_shooting_least(const ric_shooting *c)
{
    int rows = c->n_end;
    double column[rows + 1], sum = 0; /* of the inverse */
    for (int j = 0; j < rows; j++)
        for (int i = j; i < rows; i++) {
            const double *row = c->X + i * c->ld + rows; /* column k of the square part is at -k */
            column[i] = i == j;
            for (int k = j; k < i; k++) column[i] -= row[-k] * column[k];
            column[i] /= row[-i];
            sum += column[i] * column[i];
        }
    return 1 / sqrt(sum);
}

/* What the flights leave of the Jacobian is the small matrix L [n_end, n_end + 1] of the end rows,
 * behind orthogonal maps: its kernel is the kernel of the whole, and its singular vectors are
 * carried back like a step. */
bool ric_shooting_plane(const ric_shooting *c, double *kernel, double *second)
{
    int rows = c->n_end, columns = rows + 1;
    double *L = ric_malloc((size_t)(rows + columns) * (size_t)columns * sizeof *L),
           *V = L + rows * columns;
    double values[rows], super[rows + 1];
    for (int r = 0; L && r < rows; r++)
        memcpy(L + r * columns, c->X + r * c->ld, (size_t)columns * sizeof *L);
    bool found = L && !ric_lapack(LAPACKE_dgesvd(LAPACK_ROW_MAJOR, 'N', 'A', rows, columns, L,
                                                 columns, values, NULL, 1, V, columns, super));
    *second = found ? values[rows - 1] : 0;
    for (int i = 0; found && i < 2; i++) {
        /* row r pinned column n_end - r */
        const double *y = V + (rows - 1 + i) * columns;
        double end[rows + 1];
        for (int r = 0; r <= rows; r++) end[r] = y[rows - r];
        unwind(c, false, end, kernel + (size_t)i * (size_t)c->n_unknown);
    }
    free(L);
    return found;
}

/* ----------------------------------------------------------------- scalars */

double ric_shooting_time(const ric_shooting *c, const double *u)
{
    double sum = 0;
    for (int k = 0; k < c->n_flight; k++) sum += u[c->n_start + k];
    return c->multiple * sum;
}

double ric_shooting_energy(const ric_shooting *c)
{
    return ric_flight_energy(c->model, c->closed[0], c->w);
}

double ric_shooting_energy_slope(const ric_shooting *c, const double *du)
{
    int n = c->n;
    double h[2 * n];
    if (c->start == RIC_MIRROR_CENTRE) return ric_dot(n, c->w + n, du);
    ric_flight_secant(c->model, c->closed[0], c->w, c->w, h);
    double sum = ric_dot(n, h, du) / 2;
    if (c->start == RIC_MIRROR_NONE) sum += ric_dot(n, c->w + n, du + n);
    if (c->start == RIC_MIRROR_IMPACT)
        sum += c->approach[0] / sqrt(c->model->face[c->face[0]].cc) * du[n];
    return sum;
}

/* ------------------------------------------------------------ dense (tests) */

int ric_shooting_residuals(ric_shooting *c, const double *u, double *r)
{
    int n = c->n, k = 0, rows = ric_general(c) ? 2 * n : c->n_end;
    double gap = start_state(c, n, u);
    if (c->face[0] >= 0 || ric_general(c))
        r[k++] = gap; /* without an event: the phase, which is free */
    for (int i = 0; i < c->n_flight; i++) {
        gap = fly_one(c, n, i, u + c->n_start + i);
        if (c->face[i + 1] >= 0 && !(ric_general(c) && i + 1 == c->n_flight)) r[k++] = gap;
    }
    k += ric_shooting_nodes_residuals(c, u, r + k);
    for (int i = 0; i < rows; i++) r[k++] = end_residual(c, n, i);
    return k;
}

/* Pushes du through the chain after a ric_shooting_fly; writes column j of J (n_unknown columns).
 */
static void push(const ric_shooting *c, const double *du, double *column)
{
    int n = c->n, k = 0, rows = ric_general(c) ? 2 * n : c->n_end;
    const ric_model *m = c->model;
    double dw[2 * n], dw0[2 * n], f[2 * n], end[2 * n];
    memset(dw, 0, sizeof dw);
    if (c->start == RIC_MIRROR_CENTRE) memcpy(dw + n, du, (size_t)n * sizeof *dw);
    else memcpy(dw, du, (size_t)(ric_general(c) ? 2 * n : n) * sizeof *dw);
    if (c->start == RIC_MIRROR_IMPACT) {
        const ric_face *face = &m->face[c->face[0]];
        for (int i = 0; i < n; i++) dw[n + i] = -face->side * du[n] / sqrt(face->cc) * face->c[i];
    }
    memcpy(dw0, dw, sizeof dw);
    if (c->face[0] >= 0) column[k++] = ric_gap(n, &m->face[c->face[0]], dw);
    else if (ric_general(c)) {
        ric_flight_rate(m, c->closed[0], c->w, f);
        column[k++] = ric_dot(2 * n, f, dw) / sqrt(ric_dot(2 * n, f, f));
    }
    for (int i = 0; i < c->n_flight; i++) {
        const double *map = c->map + c->stride * (size_t)i;
        double chord = 0;
        if (c->parts > 1) {
            k += ric_shooting_nodes_push(c, du, dw, column + k);
            continue;
        }
        if (c->closed[i]) ric_flight_onto(m, c->closed[i], ric_shooting_event(c, i), 1, dw);
        if (ric_shooting_between(c, i)) {
            const double *by_w = c->chord + (2 * n + 1) * i;
            chord = ric_dot(2 * n, by_w, dw) + by_w[2 * n] * du[c->n_start + i];
        }
        const double *rate = c->rate + 2 * n * i;
        if (ric_flight_dense(m, c->closed[i])) ric_flight_carry(n, map, 1, 1, dw);
        else {
            ric_flight(n, map, dw, dw);
            arriving(c, n, i, end);
            ric_flow(m, n, end, f);
            rate = f;
        }
        for (int j = 0; j < 2 * n; j++) dw[j] += rate[j] * du[c->n_start + i];
        if (c->face[i + 1] < 0) continue;
        const ric_face *face = &m->face[c->face[i + 1]];
        if (!(ric_general(c) && i + 1 == c->n_flight))
            column[k++] = ric_shooting_between(c, i) && !c->plain ? chord : ric_gap(n, face, dw);
        if (!(i + 1 == c->n_flight && c->end == RIC_MIRROR_IMPACT))
            ric_flight_strike(n, face, dw + n);
    }
    for (int i = 0; i < rows; i++) {
        double value;
        if (c->end == RIC_MIRROR_REST) value = dw[n + i];
        else if (c->end == RIC_MIRROR_CENTRE) value = dw[i];
        else if (c->end == RIC_MIRROR_IMPACT)
            value = ric_dot(n, m->face[c->face[c->n_flight]].E + i * n, dw + n);
        else value = dw[i] - c->sigma * dw0[i];
        column[k++] = value;
    }
}

int ric_shooting_jacobian(ric_shooting *c, const double *u, double *J)
{
    int unknowns = c->n_unknown, equations = ric_shooting_rows(c);
    double *du = ric_calloc((size_t)unknowns, sizeof *du),
           *column = ric_calloc((size_t)equations, sizeof *column);
    if (!du || !column) {
        equations = 0;
        goto out;
    }
    equations = ric_shooting_residuals(c, u, column);
    for (int j = 0; j < unknowns; j++) {
        du[j] = 1;
        push(c, du, column);
        for (int i = 0; i < equations; i++) J[i * unknowns + j] = column[i];
        du[j] = 0;
    }
out:
    free(du);
    free(column);
    return equations;
}
