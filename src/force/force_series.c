/* Flights of the shaken structure under power laws, summed as power series in time step by step
 * (Jorba and Zou, Exp. Math. 14 (2005)): with it small deviations, which are linear,
 *     d'' = -omega^2 d - C d' - spring m s^(m-1) (c.d) c + (what theta, Omega and the level make of
 *     the force).
 * A step is a part of the radius of convergence, at which the last coefficients are below rounding.
 */
#include "force_medium.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"

enum { ORDER = 24, TERMS = ORDER + 1, STEPS_MOST = 100000 };

/* Coefficients of x y at order k. */
static double product(int k, const double *x, const double *y)
{
    double sum = 0;
    for (int j = 0; j <= k; j++) sum += x[j] * y[k - j];
    return sum;
}

/* One contact: s, and its powers up to s^exponent. */
typedef struct {
    double *s, *powers; /* [TERMS], [exponent * TERMS]: s^1, s^2, .. */
    int exponent;
} contact;

typedef struct {
    const ric_force_medium *m;
    const ric_force_drive *d;
    int n, columns;
    double *q, *p;           /* [n * TERMS] */
    double *Q, *P;           /* [columns * n * TERMS] */
    double *c, *sine, *late; /* [TERMS] cos, sin of theta0 + omega t; t sin */
    contact *contacts;
} series;

static void shake(series *s, double theta, double begin)
{
    double factor = 1;
    for (int k = 0; k < TERMS; k++) {
        const double turn = theta + k * RIC_PI / 2;
        s->c[k] = factor * cos(turn);
        s->sine[k] = factor * sin(turn);
        factor *= s->d->omega / (k + 1);
    }
    for (int k = 0; k < TERMS; k++) s->late[k] = begin * s->sine[k] + (k ? s->sine[k - 1] : 0);
}

static void powers_at(series *s, int k)
{
    const int n = s->n;
    for (int f = 0; f < s->m->model->n_contact; f++) {
        contact *c = &s->contacts[f];
        const double *normal = s->m->normal + (size_t)f * (size_t)n;
        c->s[k] = 0;
        for (int i = 0; i < n; i++) c->s[k] += normal[i] * s->q[i * TERMS + k];
        c->powers[k] = c->s[k];
        for (int e = 1; e < c->exponent; e++)
            c->powers[e * TERMS + k] = product(k, c->powers + (e - 1) * TERMS, c->s);
    }
}

/* Coefficient k + 1 of p, and of q. */
static void state_at(series *s, int k)
{
    const ric_force_medium *m = s->m;
    const int n = s->n;
    powers_at(s, k);
    for (int i = 0; i < n; i++) {
        double a = s->d->level * m->push[i] * s->c[k] -
                   m->omega[i] * m->omega[i] * s->q[i * TERMS + k];
        for (int j = 0; j < n; j++) a -= m->C[i * n + j] * s->p[j * TERMS + k];
        for (int f = 0; f < m->model->n_contact; f++)
            a -= m->spring[f] * m->normal[f * n + i] *
                 s->contacts[f].powers[(s->contacts[f].exponent - 1) * TERMS + k];
        s->p[i * TERMS + k + 1] = a / (k + 1);
        s->q[i * TERMS + k + 1] = s->p[i * TERMS + k] / (k + 1);
    }
}

/* What a change of theta, Omega or the level makes of the force at order k. */
static double forced(const series *s, int column, int k)
{
    const int by = column - 2 * s->n;
    if (by == RIC_BY_THETA) return -s->d->level * s->sine[k];
    if (by == RIC_BY_OMEGA) return -s->d->level * s->late[k];
    return by == RIC_BY_LEVEL ? s->c[k] : 0;
}

static void deviation_at(series *s, int column, int k)
{
    const ric_force_medium *m = s->m;
    const int n = s->n;
    double *Q = s->Q + (size_t)column * (size_t)n * TERMS,
           *P = s->P + (size_t)column * (size_t)n * TERMS, push = forced(s, column, k),
           pull[m->model->n_contact];
    for (int f = 0; f < m->model->n_contact; f++) {
        const contact *c = &s->contacts[f];
        double sum = 0;
        for (int j = 0; j <= k; j++) {
            double gap = 0;
            for (int i = 0; i < n; i++) gap += m->normal[f * n + i] * Q[i * TERMS + k - j];
            sum += c->powers[(c->exponent - 2) * TERMS + j] * gap;
        }
        pull[f] = m->spring[f] * c->exponent * sum;
    }
    for (int i = 0; i < n; i++) {
        double a = push * m->push[i] - m->omega[i] * m->omega[i] * Q[i * TERMS + k];
        for (int j = 0; j < n; j++) a -= m->C[i * n + j] * P[j * TERMS + k];
        for (int f = 0; f < m->model->n_contact; f++) a -= pull[f] * m->normal[f * n + i];
        P[i * TERMS + k + 1] = a / (k + 1);
        Q[i * TERMS + k + 1] = P[i * TERMS + k] / (k + 1);
    }
}

/* The step at which the last two coefficients are rounding of the largest. */
static double length(int rows, const double *x, double step)
{
    double size = 0, last[2] = {0, 0};
    for (int i = 0; i < rows; i++) {
        size = fmax(size, fabs(x[i * TERMS]));
        last[0] = fmax(last[0], fabs(x[i * TERMS + ORDER - 1]));
        last[1] = fmax(last[1], fabs(x[i * TERMS + ORDER]));
    }
    if (size == 0) return step;
    for (int k = 0; k < 2; k++)
        if (last[k] > 0)
            step = fmin(step, pow(DBL_EPSILON / 8 * size / last[k], 1.0 / (ORDER - 1 + k)));
    return step;
}

static double sum_at(const double *x, double t)
{
    double sum = x[ORDER];
    for (int k = ORDER - 1; k >= 0; k--) sum = sum * t + x[k];
    return sum;
}

static double step(series *s, double theta, double begin, double most)
{
    const int n = s->n;
    shake(s, theta, begin);
    for (int k = 0; k < ORDER; k++) {
        state_at(s, k);
        for (int j = 0; j < s->columns; j++) deviation_at(s, j, k);
    }
    double h = length(n, s->q, length(n, s->p, most));
    for (int j = 0; j < s->columns; j++) {
        const size_t at = (size_t)j * (size_t)n * TERMS;
        h = length(n, s->Q + at, length(n, s->P + at, h));
    }
    for (int i = 0; i < (s->columns + 1) * n; i++) {
        double *q = i < n ? s->q + i * TERMS : s->Q + (i - n) * TERMS,
               *p = i < n ? s->p + i * TERMS : s->P + (i - n) * TERMS;
        const double q1 = sum_at(q, h), p1 = sum_at(p, h);
        q[0] = q1;
        p[0] = p1;
    }
    return h;
}

static bool create(ric_force_medium *m, const ric_force_drive *d, int columns, series *out)
{
    const size_t n = (size_t)m->n, contacts = (size_t)m->model->n_contact;
    size_t powers = 0;
    for (size_t f = 0; f < contacts; f++) powers += (size_t)m->model->contact[f].exponent + 1;
    *out = (series){.m = m, .d = d, .n = m->n, .columns = columns};
    out->contacts = ric_calloc(contacts, sizeof *out->contacts);
    out->q = ric_calloc((2 * n * (size_t)(columns + 1) + 3 + powers) * TERMS, sizeof *out->q);
    if (!out->contacts || !out->q) return false;
    out->p = out->q + n * TERMS;
    out->Q = out->p + n * TERMS;
    out->P = out->Q + (size_t)columns * n * TERMS;
    out->c = out->P + (size_t)columns * n * TERMS;
    out->sine = out->c + TERMS;
    out->late = out->sine + TERMS;
    double *at = out->late + TERMS;
    for (size_t f = 0; f < contacts; f++) {
        const int exponent = m->model->contact[f].exponent;
        out->contacts[f] = (contact){at, at + TERMS, exponent};
        at += (size_t)(exponent + 1) * TERMS;
    }
    return true;
}

ric_status ric_force_series_fly(ric_force_medium *m, const ric_force_start *start, double tau,
                                double *z1, double *D)
{
    const ric_force_drive *d = start->drive;
    const int n = m->n, columns = D ? 2 * n + RIC_BY_COUNT : 0;
    series s;
    double done = 0;
    int steps = 0;
    ric_status status = create(m, d, columns, &s) ? RIC_OK : ric_no_memory("a forced flight");
    for (int i = 0; i < n && !status; i++) {
        s.q[i * TERMS] = start->z[i];
        s.p[i * TERMS] = start->z[n + i];
        if (!columns) continue;
        s.Q[(i * n + i) * TERMS] = 1;
        s.P[((n + i) * n + i) * TERMS] = 1;
    }
    while (!status && done < tau) {
        const double h = step(&s, start->theta + d->omega * done, done, tau - done);
        if (!(h > 0) || !isfinite(s.q[0]) || ++steps > STEPS_MOST)
            status = ric_fail(RIC_E_NUMERIC,
                              "the forced motion cannot be followed beyond %.6g of a flight",
                              done / tau);
        done = h >= tau - done ? tau : done + h;
    }
    for (int i = 0; i < n && !status; i++) {
        z1[i] = s.q[i * TERMS];
        z1[n + i] = s.p[i * TERMS];
        for (int j = 0; j < columns; j++) {
            D[i * columns + j] = s.Q[(j * n + i) * TERMS];
            D[(n + i) * columns + j] = s.P[(j * n + i) * TERMS];
        }
    }
    free(s.contacts);
    free(s.q);
    return status;
}
