/* Whether a solution of the forced problem is a motion, and its multipliers. */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "force_exact.h"

#define ON_FACE 1e-10 /* relative to a gap: where an impact is, to what Newton's method leaves */

enum { DEEPEST = 40 }; /* bisections of a flight: a gap that is not decided then is touched */

/* ---------------------------------------------------------------------- gaps */

/* A gap along a flight: side * c.q - gap, below 0 where it is open. */
typedef struct {
    const ric_force_exact *exact;
    const double *c, *z;           /* [n], [2n] at the start */
    double phase, side, gap, bend; /* bend: no second derivative is larger */
} watch;

static double distance(const watch *w, double t, double *speed)
{
    const int n = w->exact->n;
    double z[2 * n];
    ric_force_exact_fly(w->exact, t, w->phase, w->z, NULL, z);
    *speed = w->side * ric_dot(n, w->c, z + n);
    return w->side * ric_dot(n, w->c, z) - w->gap;
}

/* |q''| of a mode: what is left beside the steady answer has less and less energy, and |q''| <= omega^2 |q| + 2 delta
 * |p|. */
static double bound_bend(const watch *w)
{
    const ric_force_exact *e = w->exact;
    const int n = e->n;
    double sum = 0;
    for (int i = 0; i < n; i++) {
        const double re = e->steady[i], im = e->steady[n + i], c = cos(w->phase), s = sin(w->phase),
                     q = w->z[i] - (re * c - im * s), p = w->z[n + i] + e->Omega * (re * s + im * c),
                     energy = hypot(e->omega[i] * q, p);
        sum += fabs(w->c[i]) * ((e->omega[i] + 2 * e->delta[i]) * energy + e->Omega * e->Omega * hypot(re, im));
    }
    return sum;
}

/* Whether the gap stays open from a to b, where it may be at its face. */
static bool open_between(const watch *w, double a, double b, int depth)
{
    double speed_a, speed_b;
    const double at_a = distance(w, a, &speed_a), at_b = distance(w, b, &speed_b), length = b - a,
                 slack = ON_FACE * fabs(w->gap);
    if (at_a > slack || at_b > slack) return false;
    if (speed_a + w->bend * length < 0) return true; /* it moves away all the time */
    if (speed_b - w->bend * length > 0) return true; /* it comes near all the time, and arrives at b at the most */
    if (fmax(at_a, at_b) + w->bend * length * length / 8 < 0) return true;
    if (depth == 0) return false;
    return open_between(w, a, a + length / 2, depth - 1) && open_between(w, a + length / 2, b, depth - 1);
}

static bool flight_open(const ric_force_exact *e, double tau, double phase, const double *z)
{
    const ric_model *m = e->model;
    for (int f = 0; f < m->n_face; f++) {
        watch w = {e, e->normal + (size_t)m->face[f].contact * (size_t)e->n, z, phase, m->face[f].side, e->gap[f], 0};
        w.bend = bound_bend(&w);
        if (!open_between(&w, 0, tau, DEEPEST)) return false;
    }
    return true;
}

/* Speed towards the face. */
static double approach(const ric_force_exact *e, int face, const double *z)
{
    const ric_face *at = &e->model->face[face];
    return at->side * ric_dot(e->n, e->normal + (size_t)at->contact * (size_t)e->n, z + e->n);
}

const char *ric_force_motion_fault(const ric_force_exact *e, const double *u)
{
    const int n = e->n;
    double z[2 * n], z1[2 * n], phase = u[2 * n + e->N];
    memcpy(z, u, sizeof z);
    for (int k = 0; k < e->N; k++) {
        const double tau = u[2 * n + k];
        const int face = e->face[(k + 1) % e->N];
        if (!(tau > 0)) return "a flight takes no time";
        ric_force_exact_fly(e, tau, phase, z, NULL, z1);
        if (!(approach(e, face, z1) > ON_FACE)) return "an impact does not approach its stop";
        if (!flight_open(e, tau, phase, z)) return "a stop is passed, or touched, between two impacts";
        ric_force_exact_strike(e, face, 1, z1 + n);
        memcpy(z, z1, sizeof z);
        phase += e->Omega * tau;
    }
    return "";
}

/* --------------------------------------------------------------- multipliers */

/* Deviations X [2n * 2n] at one time, through a flight and the impact at its end, back to one time: the impact comes
 * earlier where the face is nearer (the saltation of Mueller 1995). */
static void carry(const ric_force_exact *e, int face, const double *turn, double phase, const double *before,
                  const double *after, double *X)
{
    const int n = e->n, ld = 2 * n;
    const double *c = e->normal + (size_t)e->model->face[face].contact * (size_t)n;
    double in[2 * n], out[2 * n], late[2 * n];
    for (int i = 0; i < n; i++)
        for (int j = 0; j < ld; j++) {
            const double *by = turn + 4 * i, q = X[i * ld + j], p = X[(n + i) * ld + j];
            X[i * ld + j] = by[0] * q + by[1] * p;
            X[(n + i) * ld + j] = by[2] * q + by[3] * p;
        }
    ric_force_exact_rate(e, phase, before, in);
    ric_force_exact_rate(e, phase, after, out);
    for (int j = 0; j < ld; j++) {
        double s = 0;
        for (int i = 0; i < n; i++) s += c[i] * X[i * ld + j];
        late[j] = -s / ric_dot(n, c, in);
    }
    for (int i = 0; i < ld; i++)
        for (int j = 0; j < ld; j++) X[i * ld + j] += in[i] * late[j];
    ric_force_exact_strike(e, face, ld, X + (size_t)n * (size_t)ld);
    for (int i = 0; i < ld; i++)
        for (int j = 0; j < ld; j++) X[i * ld + j] -= out[i] * late[j];
}

bool ric_force_motion_multipliers(const ric_force_exact *e, const double *u, double *out, double *rounding)
{
    const int n = e->n;
    double z[2 * n], z1[2 * n], turn[4 * n], phase = u[2 * n + e->N], most = 1;
    double *X = ric_calloc(4 * (size_t)n * (size_t)n, sizeof *X);
    if (!X) return false;
    for (int i = 0; i < 2 * n; i++) X[i * 2 * n + i] = 1;
    memcpy(z, u, sizeof z);
    for (int k = 0; k < e->N; k++) {
        const double tau = u[2 * n + k];
        const int face = e->face[(k + 1) % e->N];
        ric_force_exact_fly(e, tau, phase, z, turn, z1);
        memcpy(z, z1, sizeof z);
        ric_force_exact_strike(e, face, 1, z + n);
        phase += e->Omega * tau;
        carry(e, face, turn, phase, z1, z, X);
        for (int i = 0; i < 4 * n * n; i++) most = fmax(most, fabs(X[i]));
    }
    const bool found = ric_eigen(2 * n, X, out);
    *rounding = most * sqrt(DBL_EPSILON);
    free(X);
    return found;
}
