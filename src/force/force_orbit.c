/* Exact forced orbits: equations, elimination, Newton's method. */
#include "force_orbit.h"

#include <float.h>
#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"

#define CONVERGED 1e-11 /* residual, relative to 1 + |state| */
#define LAST 1e-13      /* Newton's step, relative: the next one is rounding */

enum { NEWTON_MOST = 40, HALVINGS_MOST = 12, CROSSINGS_MOST = 12 };

/* ------------------------------------------------------------------- orbits */

/* Width of a row of the elimination: this flight, the first one, the next state and phase,
 * parameter, residual. */
static size_t width(const ric_force_orbit *o)
{
    return 3 * (size_t)o->m + 1;
}

static size_t room_size(const ric_force_orbit *o)
{
    const size_t m = (size_t)o->m, size = 2 * (size_t)o->n;
    return (size_t)(o->N + 2) * 2 * m * width(o) + (m + 1) * (m + 4) +
           size * (size + RIC_BY_COUNT) + 3 * size + 2 * ((size_t)o->N * m + 1);
}

void ric_force_orbit_free(ric_force_orbit *o)
{
    if (!o) return;
    free(o->face);
    free(o->closed);
    free(o->u);
    free(o->room);
    free(o);
}

ric_status ric_force_orbit_create(ric_force_medium *medium, int N, const int *face,
                                  const uint64_t *closed, int harmonic, ric_force_orbit **out)
{
    ric_force_orbit *o = ric_calloc(1, sizeof *o);
    *out = NULL;
    if (!o) return ric_no_memory("a forced orbit");
    *o = (ric_force_orbit){.medium = medium,
                           .n = medium->n,
                           .N = N,
                           .m = 2 * medium->n + 2,
                           .harmonic = harmonic};
    o->events = face;
    o->face = ric_calloc((size_t)N, sizeof *o->face);
    o->closed = ric_calloc((size_t)N, sizeof *o->closed);
    o->u = ric_calloc((size_t)N * (size_t)o->m, sizeof *o->u);
    o->room = ric_malloc(room_size(o) * sizeof *o->room);
    if (!o->face || !o->closed || !o->u || !o->room) {
        ric_force_orbit_free(o);
        return ric_no_memory("a forced orbit");
    }
    for (int k = 0; k < N; k++) {
        o->face[k] = face ? face[k] : -1;
        o->closed[k] = closed ? closed[k] : 0;
    }
    *out = o;
    return RIC_OK;
}

void ric_force_orbit_take(ric_force_orbit *o, const ric_force_orbit *from)
{
    memcpy(o->u, from->u, (size_t)o->N * (size_t)o->m * sizeof *o->u);
    o->drive = from->drive;
    o->residual = from->residual;
}

ric_force_orbit *ric_force_orbit_copy(const ric_force_orbit *from)
{
    ric_force_orbit *o;
    if (ric_force_orbit_create(from->medium, from->N, from->events ? from->face : NULL,
                               from->closed, from->harmonic, &o))
        return NULL;
    ric_force_orbit_take(o, from);
    return o;
}

double *ric_force_orbit_parameter(ric_force_orbit *o, ric_force_along along)
{
    return along == RIC_ALONG_OMEGA   ? &o->drive.omega
           : along == RIC_ALONG_LEVEL ? &o->drive.level
                                      : &o->drive.restitution;
}

double ric_force_orbit_period(const ric_force_orbit *o)
{
    return o->harmonic * RIC_TWO_PI / o->drive.omega;
}

ric_status ric_force_orbit_spread(ric_force_orbit *o)
{
    const int n = o->n;
    for (int k = 0; k + 1 < o->N; k++) {
        const double *u = ric_force_orbit_node(o, k);
        double *next = ric_force_orbit_node(o, k + 1);
        const ric_force_start start = ric_force_orbit_start(o, k);
        ric_status status = ric_force_frame_fly(o->medium, &start, u[2 * n + 1], next, NULL);
        if (status) return status;
        if (o->events)
            ric_force_medium_strike(o->medium, o->drive.restitution, o->face[k + 1], 1, next + n);
        next[2 * n] = u[2 * n] + o->drive.omega * u[2 * n + 1];
    }
    return RIC_OK;
}

/* ---------------------------------------------------------------- equations */

/* The phase of the force goes on by omega tau in flight k; `scale` is that of the column of omega,
 * 0 for another parameter. */
static void fill_phase(const ric_force_orbit *o, int k, double scale, double *phase)
{
    const int size = 2 * o->n;
    const size_t w = width(o), next = 2 * (size_t)o->m, last = w - 1, by = w - 2;
    const double *u = ric_force_orbit_node(o, k), *v = ric_force_orbit_node(o, (k + 1) % o->N),
                 tau = u[size + 1];
    phase[size] = -1;
    phase[size + 1] = -o->drive.omega;
    phase[next + (size_t)size] = 1;
    phase[by] = -tau * scale;
    phase[last] = u[size] + o->drive.omega * tau - v[size] -
                  (k == o->N - 1 ? o->harmonic * RIC_TWO_PI : 0);
}

/* The m equations of flight k in rows of the elimination: flight k, first, next, parameter,
 * -residual. */
static bool fill(ric_force_orbit *o, int k, ric_force_along along, double scale, double *rows)
{
    const int n = o->n, size = 2 * n, m = o->m, ld = size + RIC_BY_COUNT,
              face = ric_force_orbit_end(o, k);
    const size_t w = width(o), next = 2 * (size_t)m, last = w - 1, by = w - 2;
    const double *u = ric_force_orbit_node(o, k), *v = ric_force_orbit_node(o, (k + 1) % o->N),
                 tau = u[size + 1];
    double D[size * ld], z[size], rate[size], force[size], kick[size];
    const bool closes = k == o->N - 1;
    ric_force_medium *medium = o->medium;
    const ric_force_start start = ric_force_orbit_start(o, k);
    if (ric_force_frame_fly(medium, &start, tau, z, D)) return false;
    ric_force_medium_rate(medium, o->closed[k], &o->drive, u[size] + o->drive.omega * tau, z, rate);
    for (int i = 0; i < size; i++)
        force[i] =
            along == RIC_ALONG_RESTITUTION
                ? 0
                : D[i * ld + size + (along == RIC_ALONG_OMEGA ? RIC_BY_OMEGA : RIC_BY_LEVEL)];
    memset(rows, 0, (size_t)m * w * sizeof *rows);
    double *gap = rows + (size_t)(m - 1) * w, *phase = gap - w;
    if (face >= 0) {
        const double *c = ric_force_medium_normal(medium, face);
        for (int i = 0; i < n; i++) {
            for (int j = 0; j <= size; j++) gap[j] += c[i] * D[i * ld + j];
            gap[size + 1] += c[i] * rate[i];
            gap[by] += c[i] * force[i] * scale;
        }
        gap[last] = medium->model->face[face].side * medium->gap[face] - ric_dot(n, c, z);
        memset(kick, 0, sizeof kick);
        if (along == RIC_ALONG_RESTITUTION && ric_force_medium_rigid(medium, face))
            for (int i = 0; i < n; i++)
                kick[n + i] = -ric_dot(n, c, z + n) / ric_dot(n, c, c) * c[i];
        ric_force_medium_strike(medium, o->drive.restitution, face, ld, D + (size_t)n * (size_t)ld);
        ric_force_medium_strike(medium, o->drive.restitution, face, 1, z + n);
        ric_force_medium_strike(medium, o->drive.restitution, face, 1, rate + n);
        ric_force_medium_strike(medium, o->drive.restitution, face, 1, force + n);
    } else {
        gap[size + 1] = 1;
        gap[by] = along == RIC_ALONG_OMEGA
                      ? ric_force_orbit_period(o) / o->N / o->drive.omega * scale
                      : 0;
        gap[last] = ric_force_orbit_period(o) / o->N - tau;
        memset(kick, 0, sizeof kick);
    }
    for (int i = 0; i < size; i++) {
        double *row = rows + (size_t)i * w;
        for (int j = 0; j <= size; j++) row[j] = -D[i * ld + j];
        row[size + 1] = -rate[i];
        row[next + (size_t)i] = 1;
        row[by] = -(force[i] + kick[i]) * scale;
        row[last] = z[i] - v[i];
    }
    if (closes && !o->events) {
        phase[o->N > 1 ? m + size : size] = 1;
        phase[last] = -ric_force_orbit_node(o, 0)[size];
        return true;
    }
    fill_phase(o, k, along == RIC_ALONG_OMEGA ? scale : 0, phase);
    return true;
}

/* Householder reflections of A [rows * w] that make the first `columns` of them triangular. */
static void triangular(int rows, int columns, size_t w, double *A)
{
    for (int j = 0; j < columns; j++) {
        double sum = 0, *top = A + (size_t)j * w;
        for (int i = j; i < rows; i++)
            sum += A[(size_t)i * w + (size_t)j] * A[(size_t)i * w + (size_t)j];
        const double first = top[j], length = sqrt(sum), beta = first > 0 ? -length : length;
        if (length == 0) continue;
        const double factor = 1 / (beta * (first - beta)); /* -2 / v.v */
        double dot[w];
        memset(dot, 0, sizeof dot);
        top[j] = first - beta;
        for (int i = j; i < rows; i++) {
            const double *row = A + (size_t)i * w, v = row[j];
            for (size_t c = (size_t)j + 1; v != 0 && c < w; c++) dot[c] += v * row[c];
        }
        for (int i = j; i < rows; i++) {
            double *row = A + (size_t)i * w, v = row[j] * factor;
            for (size_t c = (size_t)j + 1; v != 0 && c < w; c++) row[c] += v * dot[c];
            row[j] = 0;
        }
        top[j] = beta;
    }
}

/* Rows of flight k, with the right sides psi [m] of the last flight, 0 of others, instead of the
 * residual. */
static bool fill_with(ric_force_orbit *o, int k, ric_force_along along, double scale,
                      const double *psi, double *rows)
{
    const size_t w = width(o);
    if (!fill(o, k, along, scale, rows)) return false;
    for (int i = 0; psi && i < o->m; i++) rows[(size_t)i * w + w - 1] = k == o->N - 1 ? psi[i] : 0;
    return true;
}

/* All flights but the first eliminated: in stage k (1 .. N - 1) of `room` the triangular rows of
 * flight k; in S [m * (m + 2)] what is left of the first flight, the parameter and minus the
 * residual, or psi unless it is NULL. */
static bool eliminate(ric_force_orbit *o, ric_force_along along, double scale, const double *psi,
                      double *S, double *residual)
{
    const int m = o->m;
    const size_t w = width(o), block = (size_t)m * w, next = 2 * (size_t)m;
    double *carry = o->room;
    *residual = 0;
    if (!fill_with(o, 0, along, scale, psi, carry)) return false;
    for (int i = 0; i < m; i++) *residual = fmax(*residual, fabs(carry[(size_t)i * w + w - 1]));
    if (o->N > 1)
        for (int i = 0; i < m;
             i++) { /* flight 0 is the first: its columns lie there, and the next is on turn */
            double *row = carry + (size_t)i * w;
            memcpy(row + m, row, (size_t)m * sizeof *row);
            memcpy(row, row + next, (size_t)(m - 1) * sizeof *row);
            row[m - 1] = 0;
            memset(row + next, 0, (size_t)(m - 1) * sizeof *row);
        }
    for (int k = 1; k < o->N; k++) {
        double *A = o->room + (size_t)k * 2 * block, *fresh = A + block;
        memcpy(A, carry, block * sizeof *A);
        if (!fill_with(o, k, along, scale, psi, fresh)) return false;
        for (int i = 0; i < m; i++) *residual = fmax(*residual, fabs(fresh[(size_t)i * w + w - 1]));
        triangular(2 * m, m, w, A);
        carry = fresh;
        if (k == o->N - 1) break;
        carry = A + 2 * block; /* the next stage begins here */
        memcpy(carry, fresh, block * sizeof *carry);
        for (int i = 0; i < m; i++) {
            double *row = carry + (size_t)i * w;
            memcpy(row, row + next, (size_t)(m - 1) * sizeof *row);
            row[m - 1] = 0;
            memset(row + next, 0, (size_t)(m - 1) * sizeof *row);
        }
    }
    const size_t first = o->N > 1 ? (size_t)m : 0;
    for (int i = 0; i < m; i++) {
        const double *row = carry + (size_t)i * w;
        double *out = S + (size_t)i * (size_t)(m + 2);
        for (int j = 0; j < m; j++)
            out[j] = row[first + (size_t)j] + (j < m - 1 ? row[next + (size_t)j] : 0);
        out[m] = row[w - 2];
        out[m + 1] = row[w - 1];
    }
    return isfinite(*residual);
}

/* x [N m + 1] of all flights from its first m and last entries; `with`: the residual takes part. */
static void back(const ric_force_orbit *o, bool with, double *x)
{
    const int m = o->m;
    const size_t w = width(o), block = (size_t)m * w;
    const double by = x[(size_t)o->N * (size_t)m];
    for (int k = o->N - 1; k > 0; k--) {
        const double *A = o->room + (size_t)k * 2 * block,
                     *next = x + (size_t)((k + 1) % o->N) * (size_t)m;
        double *out = x + (size_t)k * (size_t)m;
        for (int i = m - 1; i >= 0; i--) {
            const double *row = A + (size_t)i * w;
            double sum = (with ? row[w - 1] : 0) - row[w - 2] * by - ric_dot(m, row + m, x) -
                         ric_dot(m - 1, row + 2 * m, next);
            for (int j = i + 1; j < m; j++) sum -= row[j] * out[j];
            out[i] = sum / row[i];
        }
    }
}

/* The last system: S and the row [m + 1], with right sides r [m] and aim; the answer in x [N m +
 * 1]. */
static bool solve_first(const ric_force_orbit *o, const double *S, const double *row, bool with,
                        double aim, double *x)
{
    const int m = o->m, size = row ? m + 1 : m;
    double A[(m + 1) * (m + 1)], b[m + 1];
    lapack_int pivot[m + 1];
    for (int i = 0; i < m; i++) {
        memcpy(A + i * size, S + i * (m + 2), (size_t)size * sizeof *A);
        b[i] = with ? S[i * (m + 2) + m + 1] : 0;
    }
    if (row) memcpy(A + m * size, row, (size_t)size * sizeof *A);
    b[m] = aim;
    if (ric_lapack(LAPACKE_dgesv(LAPACK_ROW_MAJOR, size, 1, A, size, pivot, b, 1))) return false;
    memcpy(x, b, (size_t)m * sizeof *x);
    x[(size_t)o->N * (size_t)m] = row ? b[m] : 0;
    back(o, with, x);
    return true;
}

/* -------------------------------------------------------------------- Newton */

static double *left(ric_force_orbit *o)
{
    return o->room + (size_t)(o->N + 2) * 2 * (size_t)o->m * width(o);
}

static double *step_of(ric_force_orbit *o)
{
    return left(o) + (size_t)(o->m + 1) * (size_t)(o->m + 4);
}

static double size_of(const ric_force_orbit *o)
{
    double most = 0;
    for (int k = 0; k < o->N; k++)
        for (int i = 0; i < 2 * o->n; i++) most = fmax(most, fabs(ric_force_orbit_node(o, k)[i]));
    return 1 + most;
}

/* The part of a step that leaves all flights positive. */
static double possible(const ric_force_orbit *o, const double *x)
{
    double part = 1;
    for (int k = 0; k < o->N; k++) {
        const double tau = ric_force_orbit_tau(o, k),
                     move = x[(size_t)k * (size_t)o->m + 2 * (size_t)o->n + 1];
        while (!(tau + part * move > 0) && part > DBL_EPSILON) part /= 2;
    }
    return part;
}

/* u = best + part x, and the parameter. */
static void go(ric_force_orbit *o, const double *best, double held, double part, const double *x,
               double scale, double *parameter)
{
    const size_t all = (size_t)o->N * (size_t)o->m;
    for (size_t i = 0; i < all; i++) o->u[i] = best[i] + part * x[i];
    *parameter = held + part * x[all] * scale;
}

static double longest(size_t n, const double *x)
{
    double most = 0;
    for (size_t i = 0; i < n; i++) most = fmax(most, fabs(x[i]));
    return most;
}

/* A step after which the residual is larger is halved: beside a turning point the first one leads
 * to the other orbit. */
bool ric_force_orbit_solve(ric_force_orbit *o, ric_force_along along, double scale,
                           const double *row, double aim, int *steps)
{
    const int m = o->m;
    const size_t all = (size_t)o->N * (size_t)m;
    double *S = left(o), *x = step_of(o), *best = x + all + 1,
           *parameter = ric_force_orbit_parameter(o, along), now, held = *parameter, part = 0;
    int k = 0, halved = 0;
    o->residual = INFINITY;
    memcpy(best, o->u, all * sizeof *best);
    for (; k < NEWTON_MOST; k++) {
        if (!eliminate(o, along, scale, NULL, S, &now)) break;
        const double off = row ? aim - ric_dot(m, row, o->u) - row[m] * *parameter / scale : 0,
                     size = size_of(o);
        now = fmax(now, fabs(off)) / size;
        if (now < o->residual) {
            o->residual = now;
            memcpy(best, o->u, all * sizeof *best);
            held = *parameter;
            if (part > 0 && longest(all, x) < LAST * size) break;
            if (!solve_first(o, S, row, true, off, x)) break;
            part = possible(o, x);
        } else if (o->residual < CONVERGED || ++halved > HALVINGS_MOST) break;
        else part /= 2;
        go(o, best, held, part, x, scale, parameter);
        if (!(*parameter > 0)) break;
    }
    memcpy(o->u, best, all * sizeof *best);
    *parameter = held;
    if (steps) *steps = k;
    return o->residual <= CONVERGED;
}

bool ric_force_orbit_tangent(ric_force_orbit *o, ric_force_along along, double scale,
                             const double *row, double *out)
{
    double residual, *S = left(o), length = 0;
    const int m = o->m;
    const size_t all = (size_t)o->N * (size_t)m;
    if (!eliminate(o, along, scale, NULL, S, &residual) || !solve_first(o, S, row, false, 1, out))
        return false;
    for (int i = 0; i < m; i++) length += out[i] * out[i];
    length = sqrt(length + out[all] * out[all]);
    for (size_t i = 0; i <= all; i++) out[i] /= length;
    return isfinite(length);
}

bool ric_force_orbit_aside(ric_force_orbit *o, ric_force_along along, double scale,
                           const double *tangent, double *out, double *second)
{
    const int m = o->m, size = m + 1;
    double residual, *S = left(o), A[size * size], values[size], U[1], Vt[size * size], super[size];
    if (!eliminate(o, along, scale, NULL, S, &residual)) return false;
    for (int i = 0; i < m; i++) memcpy(A + i * size, S + i * (m + 2), (size_t)size * sizeof *A);
    memcpy(A + m * size, tangent, (size_t)size * sizeof *A);
    if (ric_lapack(LAPACKE_dgesvd(LAPACK_ROW_MAJOR, 'N', 'A', size, size, A, size, values, U, size,
                                  Vt, size, super)))
        return false;
    memcpy(out, Vt + m * size, (size_t)m * sizeof *out);
    out[(size_t)o->N * (size_t)m] = Vt[m * size + m];
    back(o, false, out);
    *second = values[m] / values[0];
    return true;
}

/* ------------------------------------------------------------- branch points */

/* At a branch point the equations F(y) = 0 of the curve have two directions, and an orbit is known
 * by them to the third root of rounding only. Unfolded, F + b psi = 0 with psi outside of the
 * range, and with two coordinates a = T y of the kernel given, they are regular: y and b are
 * analytic in a, the curves are those where b is 0, and they cross where its two derivatives are,
 * too (method of Lyapunov and Schmidt; Govaerts, Numerical Methods for Bifurcations of Dynamical
 * Equilibria, SIAM 2000). */
typedef struct {
    ric_force_along along;
    double scale;
    double *psi;  /* [m] right sides of the last flight */
    double *rows; /* [2 (m + 1)] T */
    double *top;  /* [m] psi in the rows of the last stage */
    double aim[2], b, slope[2];
} unfolding;

/* Solves [S p; T 0] x = r, all m + 2 numbers. */
static bool bordered(int m, const double *S, const double *p, const double *rows, double *x)
{
    const int size = m + 2;
    double A[size * size];
    lapack_int pivot[size];
    for (int i = 0; i < m; i++) {
        memcpy(A + i * size, S + i * size, (size_t)(m + 1) * sizeof *A);
        A[i * size + m + 1] = p[i];
    }
    for (int j = 0; j < 2; j++) {
        memcpy(A + (m + j) * size, rows + j * (m + 1), (size_t)(m + 1) * sizeof *A);
        A[(m + j) * size + m + 1] = 0;
    }
    return !ric_lapack(LAPACKE_dgesv(LAPACK_ROW_MAJOR, size, 1, A, size, pivot, x, 1));
}

/* psi as it comes out of the elimination, p [m]. */
static bool eliminate_psi(ric_force_orbit *o, const unfolding *f, double *p)
{
    const int m = o->m;
    const size_t w = width(o);
    double *S = left(o), unused;
    if (!eliminate(o, f->along, f->scale, f->psi, S, &unused)) return false;
    for (int i = 0; i < m; i++) {
        p[i] = S[i * (m + 2) + m + 1];
        if (o->N > 1)
            f->top[i] = o->room[((size_t)(o->N - 1) * 2 * (size_t)m + (size_t)i) * w + w - 1];
    }
    return true;
}

/* T from the kernel of the orbit, and of the unit vectors of the last flight the one that is
 * farthest from the range. */
static bool unfold(ric_force_orbit *o, unfolding *f)
{
    const int m = o->m;
    double residual, *S = left(o), A[m * (m + 1)], U[m * m], Vt[(m + 1) * (m + 1)], values[m],
                     super[m], p[m], most = 0;
    if (!eliminate(o, f->along, f->scale, NULL, S, &residual)) return false;
    for (int i = 0; i < m; i++)
        memcpy(A + i * (m + 1), S + i * (m + 2), (size_t)(m + 1) * sizeof *A);
    if (ric_lapack(LAPACKE_dgesvd(LAPACK_ROW_MAJOR, 'A', 'A', m, m + 1, A, m + 1, values, U, m, Vt,
                                  m + 1, super)))
        return false;
    memcpy(f->rows, Vt + (m - 1) * (m + 1), 2 * (size_t)(m + 1) * sizeof *Vt);
    int best = 0;
    for (int i = 0; i < m; i++) {
        double part = 0;
        memset(f->psi, 0, (size_t)m * sizeof *f->psi);
        f->psi[i] = 1;
        if (!eliminate_psi(o, f, p)) return false;
        for (int j = 0; j < m; j++) part += U[j * m + m - 1] * p[j];
        if (fabs(part) > most) {
            most = fabs(part);
            best = i;
        }
    }
    memset(f->psi, 0, (size_t)m * sizeof *f->psi);
    f->psi[best] = 1;
    for (int j = 0; j < 2; j++)
        f->aim[j] = ric_dot(m, f->rows + j * (m + 1), o->u) +
                    f->rows[j * (m + 1) + m] * *ric_force_orbit_parameter(o, f->along) / f->scale;
    return most > 0;
}

/* One step of Newton's method on the unfolded equations; its length, NaN: none. b and its
 * derivatives are those where the step begins. */
static double unfolded_step(ric_force_orbit *o, unfolding *f)
{
    const int m = o->m;
    const size_t w = width(o), all = (size_t)o->N * (size_t)m;
    double *S = left(o), *x = step_of(o), *parameter = ric_force_orbit_parameter(o, f->along), p[m],
           r[m + 2], e[m + 2], unused;
    if (!eliminate_psi(o, f, p) || !eliminate(o, f->along, f->scale, NULL, S, &unused)) return NAN;
    for (int i = 0; i < m; i++) r[i] = S[i * (m + 2) + m + 1];
    for (int j = 0; j < 2; j++) {
        const double *row = f->rows + j * (m + 1);
        r[m + j] = f->aim[j] - ric_dot(m, row, o->u) - row[m] * *parameter / f->scale;
        memset(e, 0, sizeof e);
        e[m + j] = 1;
        if (!bordered(m, S, p, f->rows, e)) return NAN;
        f->slope[j] = e[m + 1];
    }
    if (!bordered(m, S, p, f->rows, r)) return NAN;
    f->b = r[m + 1];
    for (int i = 0; i < m && o->N > 1; i++)
        o->room[((size_t)(o->N - 1) * 2 * (size_t)m + (size_t)i) * w + w - 1] -= f->b * f->top[i];
    memcpy(x, r, (size_t)m * sizeof *x);
    x[all] = r[m];
    back(o, true, x);
    for (size_t i = 0; i < all; i++) o->u[i] += x[i];
    *parameter += x[all] * f->scale;
    return fmax(longest(all, x), fabs(x[all]));
}

static bool unfolded(ric_force_orbit *o, unfolding *f)
{
    double last = INFINITY;
    for (int k = 0; k < NEWTON_MOST; k++) {
        const double length = unfolded_step(o, f), size = size_of(o);
        if (!isfinite(length) || !(*ric_force_orbit_parameter(o, f->along) > 0)) return false;
        if (length < LAST * size || (length < CONVERGED * size && length >= last / 2)) return true;
        last = length;
    }
    return false;
}

/* Derivatives of b at a + off, from the orbit `base`. */
static bool slopes_at(ric_force_orbit *o, unfolding *f, const ric_force_orbit *base, int j,
                      double off, double *out)
{
    ric_force_orbit_take(o, base);
    f->aim[j] += off;
    const bool found = unfolded(o, f);
    f->aim[j] -= off;
    memcpy(out, f->slope, sizeof f->slope);
    return found;
}

/* One step towards the place where both derivatives of b are 0; its length, NaN: none. */
static double towards_crossing(ric_force_orbit *o, ric_force_orbit *base, unfolding *f)
{
    const double h = RIC_DIFFERENCE * size_of(base);
    double H[2][2], g[2], up[2], down[2];
    for (int j = 0; j < 2; j++) {
        if (!slopes_at(o, f, base, j, h, up) || !slopes_at(o, f, base, j, -h, down)) return NAN;
        for (int i = 0; i < 2; i++) H[i][j] = (up[i] - down[i]) / (2 * h);
    }
    if (!slopes_at(o, f, base, 0, 0, g)) return NAN;
    const double det = H[0][0] * H[1][1] - H[0][1] * H[1][0],
                 move[] = {-(H[1][1] * g[0] - H[0][1] * g[1]) / det,
                           -(H[0][0] * g[1] - H[1][0] * g[0]) / det};
    ric_force_orbit_take(base, o);
    for (int j = 0; j < 2; j++) f->aim[j] += move[j];
    if (!unfolded(base, f)) return NAN;
    return hypot(move[0], move[1]);
}

bool ric_force_orbit_branch_point(ric_force_orbit *o, ric_force_along along, double scale)
{
    const size_t m = (size_t)o->m;
    ric_force_orbit *base = ric_force_orbit_copy(o), *trial = ric_force_orbit_copy(o);
    double *room = ric_calloc(2 * m + 2 * (m + 1), sizeof *room), last = INFINITY,
           residual = INFINITY;
    unfolding f = {.along = along, .scale = scale, .psi = room};
    bool found = false;
    if (base && trial && room) {
        f.top = room + m;
        f.rows = room + 2 * m;
        bool begun = unfold(base, &f);
        for (int k = 0; begun && k < CROSSINGS_MOST && !found; k++) {
            const double length = towards_crossing(trial, base, &f);
            if (!isfinite(length)) break;
            found = length < LAST * size_of(base) ||
                    (length < CONVERGED * size_of(base) && length >= last / 2);
            last = length;
        }
        found = found && eliminate(base, along, scale, NULL, left(base), &residual) &&
                residual < CONVERGED * size_of(base);
    }
    if (found) {
        base->residual = residual / size_of(base);
        ric_force_orbit_take(o, base);
    }
    ric_force_orbit_free(base);
    ric_force_orbit_free(trial);
    free(room);
    return found;
}
