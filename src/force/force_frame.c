/* Flights of the shaken structure while a set of springs is closed:
 *     z(tau) = r + L Re(a e^{i theta1}) + e^{A tau} (z - r - L Re(a e^{i theta0})),
 * r the equilibrium, a the steady answer, A the matrix of the first-order system. Where the damping
 * couples no modes e^{A tau} is a decay and a turn of each mode; otherwise it is so in the complex
 * modes of A (Foss 1958), kept as real pairs. */
#include "force_medium.h"

#include <float.h>
#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"

#define RESONANT 1e-9  /* relative: the force has the frequency of a mode that is not damped */
#define CRITICAL 1e-7  /* relative: roots of a mode that are one to half of all digits */
#define SINGULAR 1e-14 /* relative: a stiffness that rounding makes of none */
/* DEFECTIVE: condition of the complex modes from on which less than seven digits of a flight are
 * left */
#define DEFECTIVE 1e9

typedef double _Complex cplx;

void ric_force_frame_free(ric_force_frame *f)
{
    if (!f) return;
    free(f->V);
    free(f->answer);
    free(f);
}

/* -------------------------------------------------------------------- modes */

/* A [2n * 2n] of the first-order system. */
static void first_order(const ric_force_medium *m, uint64_t closed, double *A)
{
    const int n = m->n, ld = 2 * n;
    memset(A, 0, (size_t)ld * (size_t)ld * sizeof *A);
    for (int i = 0; i < n; i++) {
        A[i * ld + n + i] = 1;
        A[(n + i) * ld + i] = -m->omega[i] * m->omega[i];
        for (int j = 0; j < n; j++) A[(n + i) * ld + n + j] = -m->C[i * n + j];
    }
    for (int f = 0; f < m->model->n_face; f++) {
        if (!ric_face_in(closed, f)) continue;
        const double *c = ric_force_medium_normal(m, f), k = m->spring[m->model->face[f].contact];
        for (int i = 0; i < n; i++)
            for (int j = 0; j < n; j++) A[(n + i) * ld + j] -= k * c[i] * c[j];
    }
}

static double norm(int n, const double *A)
{
    double most = 0;
    for (int i = 0; i < n; i++) {
        double sum = 0;
        for (int j = 0; j < n; j++) sum += fabs(A[i * n + j]);
        most = isfinite(sum) ? fmax(most, sum) : INFINITY;
    }
    return most;
}

/* V with columns of length one, alpha + i beta and W = V^-1. */
static ric_status complex_modes(const ric_force_medium *m, ric_force_frame *f)
{
    const int ld = 2 * m->n;
    double *A = ric_malloc((size_t)ld * (size_t)ld * sizeof *A);
    lapack_int pivot[ld];
    if (!A) return ric_no_memory("complex modes");
    first_order(m, f->closed, A);
    int info = ric_lapack(LAPACKE_dgeev(LAPACK_ROW_MAJOR, 'N', 'V', ld, A, ld, f->alpha, f->beta,
                                        NULL, ld, f->V, ld));
    free(A);
    memcpy(f->W, f->V, (size_t)ld * (size_t)ld * sizeof *f->W);
    if (!info) info = ric_lapack(LAPACKE_dgetrf(LAPACK_ROW_MAJOR, ld, ld, f->W, ld, pivot));
    if (!info) info = ric_lapack(LAPACKE_dgetri(LAPACK_ROW_MAJOR, ld, f->W, ld, pivot));
    const double condition = info ? INFINITY : norm(ld, f->V) * norm(ld, f->W);
    if (condition < DEFECTIVE) return RIC_OK;
    return ric_trust(ric_fail(
        RIC_E_NUMERIC,
        "two complex modes of the damped structure are the same to %.1g of their digits, near "
        "critical damping; change the damping a little",
        1 / condition));
}

/* K r = k gap side c: pseudo-inverse, as a free mode has no place of its own. */
static ric_status find_rest(const ric_force_medium *m, ric_force_frame *f)
{
    const int n = m->n;
    double *K = ric_calloc((size_t)n * (size_t)n, sizeof *K), S[n];
    lapack_int rank;
    if (!K) return ric_no_memory("an equilibrium");
    for (int i = 0; i < n; i++) K[i * n + i] = m->omega[i] * m->omega[i];
    for (int face = 0; face < m->model->n_face; face++) {
        if (!ric_face_in(f->closed, face)) continue;
        const double *c = ric_force_medium_normal(m, face),
                     k = m->spring[m->model->face[face].contact];
        for (int i = 0; i < n; i++) {
            f->rest[i] += k * m->gap[face] * m->model->face[face].side * c[i];
            for (int j = 0; j < n; j++) K[i * n + j] += k * c[i] * c[j];
        }
    }
    const int info = ric_lapack(
        LAPACKE_dgelsd(LAPACK_ROW_MAJOR, n, n, 1, K, n, f->rest, 1, S, SINGULAR, &rank));
    free(K);
    return info
               ? ric_trust(ric_fail(RIC_E_NUMERIC, "no equilibrium of the closed springs is found"))
               : RIC_OK;
}

/* ------------------------------------------------------------ steady answer */

static ric_status resonance(const ric_force_medium *m, double omega)
{
    int mode = 0;
    for (int i = 1; i < m->n; i++)
        if (fabs(m->omega[i] - omega) < fabs(m->omega[mode] - omega)) mode = i;
    return ric_fail(RIC_E_NUMERIC,
                    "the force has the frequency %.10g of mode %d, which is not damped: its answer "
                    "grows without bound; "
                    "give that mode a damping",
                    m->omega[mode] * m->time, mode + 1);
}

/* (-Omega^2 + i Omega C + K) a = g, and (..) a' = (2 Omega - i C) a. */
static ric_status solve_steady(const ric_force_medium *m, ric_force_frame *f, double omega)
{
    const int n = m->n;
    cplx *Z = ric_malloc(((size_t)n * (size_t)n + 2 * (size_t)n) * sizeof *Z),
         *b = Z + (size_t)n * (size_t)n;
    lapack_int pivot[n];
    double push = 0, size = 0;
    if (!Z) return ric_no_memory("a steady answer");
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) Z[i * n + j] = I * omega * m->C[i * n + j];
        Z[i * n + i] += (m->omega[i] - omega) * (m->omega[i] + omega);
        f->answer[i] = m->push[i];
        push = fmax(push, fabs(m->push[i]));
    }
    for (int face = 0; face < m->model->n_face; face++) {
        if (!ric_face_in(f->closed, face)) continue;
        const double *c = ric_force_medium_normal(m, face),
                     k = m->spring[m->model->face[face].contact];
        for (int i = 0; i < n; i++)
            for (int j = 0; j < n; j++) Z[i * n + j] += k * c[i] * c[j];
    }
    int info = ric_lapack(LAPACKE_zgetrf(LAPACK_ROW_MAJOR, n, n, Z, n, pivot));
    if (!info)
        info = ric_lapack(LAPACKE_zgetrs(LAPACK_ROW_MAJOR, 'N', n, 1, Z, n, pivot, f->answer, 1));
    for (int i = 0; i < n && !info; i++) {
        size = fmax(size, cabs(f->answer[i]));
        b[i] = 2 * omega * f->answer[i];
        for (int j = 0; j < n; j++) b[i] -= I * m->C[i * n + j] * f->answer[j];
    }
    if (!info) info = ric_lapack(LAPACKE_zgetrs(LAPACK_ROW_MAJOR, 'N', n, 1, Z, n, pivot, b, 1));
    for (int i = 0; i < n && !info; i++) f->slope[i] = b[i];
    free(Z);
    return !info && size * omega * omega * RESONANT < push ? RIC_OK
                                                           : ric_trust(resonance(m, omega));
}

static ric_status modal_steady(const ric_force_medium *m, ric_force_frame *f, double omega)
{
    for (int i = 0; i < m->n; i++) {
        const double loss = m->C[i * m->n + i];
        const cplx Z = (m->omega[i] - omega) * (m->omega[i] + omega) + I * omega * loss;
        f->answer[i] = f->slope[i] = 0;
        if (m->push[i] == 0) continue;
        if (!(cabs(Z) > RESONANT * omega * omega)) return resonance(m, omega);
        f->answer[i] = m->push[i] / Z;
        f->slope[i] = (2 * omega - I * loss) * f->answer[i] / Z;
    }
    return RIC_OK;
}

static ric_status steady(const ric_force_medium *m, ric_force_frame *f, double omega)
{
    const int n = m->n;
    ric_status status = f->plain ? modal_steady(m, f, omega) : solve_steady(m, f, omega);
    for (int i = 0; i < n; i++) {
        f->answer[n + i] = I * omega * f->answer[i];
        f->slope[n + i] = I * (f->answer[i] + omega * f->slope[i]);
    }
    f->omega = status ? NAN : omega;
    return status;
}

/* ------------------------------------------------------------------- frames */

static ric_status make_frame(ric_force_medium *m, uint64_t closed, ric_force_frame **out)
{
    const size_t n = (size_t)m->n;
    ric_force_frame *f = ric_calloc(1, sizeof *f);
    *out = f;
    if (!f) return ric_no_memory("the modes of a damped structure");
    f->closed = closed;
    f->plain = !closed && m->force->diagonal;
    f->omega = NAN;
    f->V = ric_calloc((f->plain ? 0 : 8 * n * n) + 6 * n, sizeof *f->V);
    f->answer = ric_calloc(4 * n, sizeof *f->answer);
    if (!f->V || !f->answer) return ric_no_memory("the modes of a damped structure");
    f->slope = f->answer + 2 * n;
    f->W = f->V + (f->plain ? 0 : 4 * n * n);
    f->rest = f->W + (f->plain ? 0 : 4 * n * n);
    f->alpha = f->rest + 2 * n;
    f->beta = f->alpha + 2 * n;
    ric_status status = closed ? find_rest(m, f) : RIC_OK;
    return status || f->plain ? status : complex_modes(m, f);
}

ric_status ric_force_frame_find(ric_force_medium *m, uint64_t closed, double omega,
                                const ric_force_frame **out)
{
    ric_force_frame *f = m->frames;
    ric_status status = RIC_OK;
    while (f && f->closed != closed) f = f->next;
    if (!f) {
        if ((status = make_frame(m, closed, &f))) {
            ric_force_frame_free(f);
            return status;
        }
        f->next = m->frames;
        m->frames = f;
    }
    if (f->omega != omega) status = steady(m, f, omega);
    *out = f;
    return status;
}

/* ------------------------------------------------------------------ flights */

void ric_force_frame_decay(double omega, double delta, double tau, double *c, double *s)
{
    const double square = (omega - delta) * (omega + delta), root = sqrt(fabs(square)),
                 decay = exp(-delta * tau);
    if (root * tau <= CRITICAL) {
        *c = decay;
        *s = decay * tau;
    } else if (square > 0) {
        *c = decay * cos(root * tau);
        *s = decay * sin(root * tau) / root;
    } else {
        /* Neither the slower rate, root - delta, nor slow - fast is taken as a difference: digits
         * would be lost. */
        const double slow = exp(-omega * omega / (root + delta) * tau),
                     part = -expm1(-2 * root * tau);
        *c = slow * (2 - part) / 2;
        *s = slow * part / (2 * root);
    }
}

/* Re(a e^{i theta}) [2n] */
static void turned(int size, const cplx *a, double theta, double *out)
{
    const double c = cos(theta), s = sin(theta);
    for (int i = 0; i < size; i++) out[i] = creal(a[i]) * c - cimag(a[i]) * s;
}

/* Re(i a e^{i theta}) */
static void turned_on(int size, const cplx *a, double theta, double *out)
{
    const double c = cos(theta), s = sin(theta);
    for (int i = 0; i < size; i++) out[i] = -creal(a[i]) * s - cimag(a[i]) * c;
}

/* Of mode i: (q, p) after tau is by [4] times (q, p). */
static void mode_matrix(const ric_force_medium *m, int i, double tau, double by[4])
{
    const double omega = m->omega[i], delta = m->C[i * m->n + i] / 2;
    double c, s;
    ric_force_frame_decay(omega, delta, tau, &c, &s);
    by[0] = c + delta * s;
    by[1] = s;
    by[2] = -omega * omega * s;
    by[3] = c - delta * s;
}

/* X [2n * ld] <- e^{A tau} X; room [2n * ld]. */
static void carry(const ric_force_medium *m, const ric_force_frame *f, double tau, int ld,
                  double *X, double *room)
{
    const int n = m->n, size = 2 * n;
    for (int i = 0; f->plain && i < n; i++) {
        double by[4], *q = X + (size_t)i * (size_t)ld, *p = X + (size_t)(n + i) * (size_t)ld;
        mode_matrix(m, i, tau, by);
        for (int j = 0; j < ld; j++) {
            const double a = q[j], b = p[j];
            q[j] = by[0] * a + by[1] * b;
            p[j] = by[2] * a + by[3] * b;
        }
    }
    if (f->plain) return;
    memset(room, 0, (size_t)size * (size_t)ld * sizeof *room);
    for (int i = 0; i < size; i++)
        for (int k = 0; k < size; k++)
            for (int j = 0; j < ld; j++) room[i * ld + j] += f->W[i * size + k] * X[k * ld + j];
    for (int i = 0; i < size; i++) {
        const double decay = exp(f->alpha[i] * tau), c = decay * cos(f->beta[i] * tau),
                     s = decay * sin(f->beta[i] * tau);
        double *a = room + (size_t)i * (size_t)ld;
        for (int j = 0; f->beta[i] == 0 && j < ld; j++) a[j] *= decay;
        for (int j = 0; f->beta[i] > 0 && j < ld; j++) {
            const double x = a[j], y = a[ld + j];
            a[j] = c * x + s * y;
            a[ld + j] = c * y - s * x;
        }
    }
    memset(X, 0, (size_t)size * (size_t)ld * sizeof *X);
    for (int i = 0; i < size; i++)
        for (int k = 0; k < size; k++)
            for (int j = 0; j < ld; j++) X[i * ld + j] += f->V[i * size + k] * room[k * ld + j];
}

/* Columns of deviations: identity, then what theta, Omega and the level at the start make of the
 * steady answer, whose difference is carried. */
static void derivatives(const ric_force_medium *m, const ric_force_frame *f,
                        const ric_force_start *start, double tau, double *D, double *room)
{
    const ric_force_drive *d = start->drive;
    const int size = 2 * m->n, ld = size + RIC_BY_COUNT;
    const double theta = start->theta, theta1 = theta + d->omega * tau;
    double on0[size], on1[size], by0[size], by1[size], at0[size], at1[size];
    turned_on(size, f->answer, theta, on0);
    turned_on(size, f->answer, theta1, on1);
    turned(size, f->slope, theta, by0);
    turned(size, f->slope, theta1, by1);
    turned(size, f->answer, theta, at0);
    turned(size, f->answer, theta1, at1);
    memset(D, 0, (size_t)size * (size_t)ld * sizeof *D);
    for (int i = 0; i < size; i++) {
        double *row = D + (size_t)i * (size_t)ld;
        row[i] = 1;
        row[size + RIC_BY_THETA] = -d->level * on0[i];
        row[size + RIC_BY_OMEGA] = -d->level * by0[i];
        row[size + RIC_BY_LEVEL] = -at0[i];
    }
    carry(m, f, tau, ld, D, room);
    for (int i = 0; i < size; i++) {
        double *row = D + (size_t)i * (size_t)ld;
        row[size + RIC_BY_THETA] += d->level * on1[i];
        row[size + RIC_BY_OMEGA] += d->level * (by1[i] + tau * on1[i]);
        row[size + RIC_BY_LEVEL] += at1[i];
    }
}

ric_status ric_force_frame_fly(ric_force_medium *m, const ric_force_start *start, double tau,
                               double *z1, double *D)
{
    const ric_force_drive *d = start->drive;
    const int size = 2 * m->n;
    double at[size], x[size], room[size * (D ? size + RIC_BY_COUNT : 1)];
    const ric_force_frame *f;
    if (m->smooth) return ric_force_series_fly(m, start, tau, z1, D);
    ric_status status = ric_force_frame_find(m, start->closed, d->omega, &f);
    if (status) return status;
    turned(size, f->answer, start->theta, at);
    for (int i = 0; i < size; i++) x[i] = start->z[i] - f->rest[i] - d->level * at[i];
    carry(m, f, tau, 1, x, room);
    turned(size, f->answer, start->theta + d->omega * tau, at);
    for (int i = 0; i < size; i++) z1[i] = f->rest[i] + d->level * at[i] + x[i];
    if (D) derivatives(m, f, start, tau, D, room);
    return RIC_OK;
}

/* ----------------------------------------------------------------- readings */

/* |s''| <= sum |weight| ..: what is left beside the steady answer has less and less energy in every
 * mode. */
static double bend_of(const ric_force_reading *r)
{
    const ric_force_medium *m = r->medium;
    const ric_force_frame *f = r->frame;
    const int n = m->n;
    double sum = cabs(r->steady) * r->omega * r->omega;
    for (int i = 0; f->plain && i < n; i++) {
        const double omega = m->omega[i], loss = m->C[i * n + i],
                     energy = hypot(omega * r->y[i], r->y[n + i]);
        sum += fabs(r->weight[i]) * (omega + loss) * energy;
        sum += fabs(r->weight[n + i]) * ((omega + loss) * (omega + loss) + omega * omega) * energy;
    }
    for (int i = 0; !f->plain && i < 2 * n; i++) {
        const double square = f->alpha[i] * f->alpha[i] + f->beta[i] * f->beta[i];
        if (f->beta[i] == 0) sum += square * fabs(r->weight[i] * r->y[i]);
        if (f->beta[i] > 0)
            sum += square * hypot(r->weight[i], r->weight[i + 1]) * hypot(r->y[i], r->y[i + 1]);
    }
    return sum;
}

ric_status ric_force_frame_read(ric_force_medium *m, const ric_force_start *start,
                                const double *row, double *room, ric_force_reading *out)
{
    const ric_force_drive *d = start->drive;
    const int size = 2 * m->n;
    double at[size], x[size];
    const ric_force_frame *f;
    ric_status status = ric_force_frame_find(m, start->closed, d->omega, &f);
    if (status) return status;
    *out = (ric_force_reading){.medium = m,
                               .frame = f,
                               .row = row,
                               .y = room,
                               .weight = room + size,
                               .rest = ric_dot(size, row, f->rest),
                               .theta = start->theta,
                               .omega = d->omega};
    turned(size, f->answer, start->theta, at);
    for (int i = 0; i < size; i++) {
        x[i] = start->z[i] - f->rest[i] - d->level * at[i];
        out->steady += d->level * row[i] * f->answer[i];
    }
    for (int i = 0; i < size; i++) {
        out->y[i] = f->plain ? x[i] : ric_dot(size, f->W + i * size, x);
        out->weight[i] = f->plain ? row[i] : 0;
        for (int k = 0; !f->plain && k < size; k++) out->weight[i] += row[k] * f->V[k * size + i];
    }
    out->bend = bend_of(out);
    return RIC_OK;
}

static double look_plain(const ric_force_reading *r, double t, double *slope)
{
    const ric_force_medium *m = r->medium;
    const int n = m->n;
    double s = 0;
    for (int i = 0; i < n; i++) {
        double by[4];
        const double a = r->weight[i], b = r->weight[n + i];
        if (a == 0 && b == 0) continue;
        mode_matrix(m, i, t, by);
        const double q = by[0] * r->y[i] + by[1] * r->y[n + i],
                     p = by[2] * r->y[i] + by[3] * r->y[n + i];
        s += a * q + b * p;
        *slope += a * p - b * (m->omega[i] * m->omega[i] * q + m->C[i * n + i] * p);
    }
    return s;
}

double ric_force_frame_look(const ric_force_reading *r, double t, double *slope)
{
    const ric_force_frame *f = r->frame;
    const cplx steady = r->steady * cexp(I * (r->theta + r->omega * t));
    double s = r->rest + creal(steady);
    *slope = creal(I * r->omega * steady);
    if (f->plain) return s + look_plain(r, t, slope);
    for (int i = 0; i < 2 * r->medium->n; i++) {
        const double decay = exp(f->alpha[i] * t);
        if (f->beta[i] < 0) continue;
        if (f->beta[i] == 0) {
            s += decay * r->weight[i] * r->y[i];
            *slope += decay * f->alpha[i] * r->weight[i] * r->y[i];
            continue;
        }
        const double c = decay * cos(f->beta[i] * t), d = decay * sin(f->beta[i] * t), x = r->y[i],
                     y = r->y[i + 1], u = c * x + d * y, v = c * y - d * x;
        s += r->weight[i] * u + r->weight[i + 1] * v;
        *slope += r->weight[i] * (f->alpha[i] * u + f->beta[i] * v) +
                  r->weight[i + 1] * (f->alpha[i] * v - f->beta[i] * u);
    }
    return s;
}
