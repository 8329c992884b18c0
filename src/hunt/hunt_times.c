#include "hunt_times.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "base/room.h"

#define STEPS 40
#define HALVINGS 8
/* SOLVED: of r, relative to the speed sqrt(2 E): what follows is left to ric_impact_map_polish */
#define SOLVED 1e-9
/* NEARLY: the same, where no step makes it smaller: beside a slow impact rounding may leave as much
 */
#define NEARLY 1e-6
#define GAIN 0.1      /* a step has to take at least this part of what it promises */
#define BRIEFEST 1e-6 /* flights, in seconds: two impacts of one stop that are no closer */
#define RESONANT 1e-9 /* sin(omega tau) is no smaller */
#define BEYOND 1.2    /* the period may be this much over its bound on the way */

static double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1];
}

static const ric_impact_map_face *face_of(const ric_times *t, const ric_hit *hits, int k)
{
    return &t->section->face[hits[k % t->N].face];
}

/* a and b of every flight. */
static void turn(ric_times *t, const ric_hit *hits)
{
    for (int k = 0; k < t->N; k++) {
        ric_times_flight *f = &t->flight[k];
        double sign = t->half && k + 1 == t->N ? -1 : 1;
        for (int i = 0; i < 2; i++) {
            double omega = t->section->omega[i], tau = hits[k].tau, s, c;
            sincos(omega * tau, &s, &c);
            if (fabs(s) < RESONANT) s = copysign(RESONANT, s);
            f->a[i] = omega > 0 ? omega * c / s : 1 / tau;
            f->b[i] = sign * (omega > 0 ? omega / s : 1 / tau);
        }
    }
}

/* K y = what is left of e.(arrive - leave) at every impact for y = 0; columns of y [N * (N + 1)]
 * but the first are free. */
static void assemble_places(ric_times *t, const ric_hit *hits)
{
    int N = t->N, columns = N + 1;
    memset(t->K, 0, (size_t)(N * N) * sizeof *t->K);
    memset(t->y, 0, (size_t)(N * columns) * sizeof *t->y);
    for (int k = 0; k < N; k++) {
        int to = (k + 1) % N;
        const ric_impact_map_face *from = face_of(t, hits, k), *goal = face_of(t, hits, to);
        const ric_times_flight *f = &t->flight[k];
        for (int i = 0; i < 2; i++) {
            double e0 = from->along[i], e1 = goal->along[i];
            double q0 = from->at * from->normal[i], q1 = goal->at * goal->normal[i];
            t->K[k * N + k] += f->a[i] * e0 * e0;
            t->K[k * N + to] -= f->b[i] * e0 * e1;
            t->K[to * N + to] += f->a[i] * e1 * e1;
            t->K[to * N + k] -= f->b[i] * e0 * e1;
            t->y[k * columns] += e0 * (f->b[i] * q1 - f->a[i] * q0);
            t->y[to * columns] -= e1 * (f->a[i] * q1 - f->b[i] * q0);
        }
    }
}

/* Velocities at the ends of every flight, from the places. */
static void set_velocities(ric_times *t, const ric_hit *hits)
{
    int columns = t->N + 1;
    for (int k = 0; k < t->N; k++) {
        int to = (k + 1) % t->N;
        const ric_impact_map_face *from = face_of(t, hits, k), *goal = face_of(t, hits, to);
        ric_times_flight *f = &t->flight[k];
        for (int i = 0; i < 2; i++) {
            double q0 = from->at * from->normal[i] + t->y[k * columns] * from->along[i];
            double q1 = goal->at * goal->normal[i] + t->y[to * columns] * goal->along[i];
            f->leave[i] = f->b[i] * q1 - f->a[i] * q0;
            f->arrive[i] = f->a[i] * q1 - f->b[i] * q0;
        }
    }
}

/* Places and velocities, and the derivatives of the places: a longer flight changes its velocities
 * by -b times those at its other end. */
static bool place(ric_times *t, const ric_hit *hits)
{
    int N = t->N, columns = N + 1;
    double first[RIC_TIMES_MOST];
    turn(t, hits);
    assemble_places(t, hits);
    memcpy(t->A, t->K, (size_t)(N * N) * sizeof *t->A);
    for (int k = 0; k < N; k++) first[k] = t->y[k * columns];
    if (!ric_dense_solve(N, 1, t->A, first, DBL_MIN)) return false;
    for (int k = 0; k < N; k++) t->y[k * columns] = first[k];
    set_velocities(t, hits);
    double change[RIC_TIMES_MOST * (RIC_TIMES_MOST + 1)];
    memset(change, 0, sizeof change);
    for (int k = 0; k < N; k++) {
        const ric_times_flight *f = &t->flight[k];
        int to = (k + 1) % N;
        for (int i = 0; i < 2; i++) {
            change[k * N + k] -= face_of(t, hits, k)->along[i] * f->b[i] * f->arrive[i];
            change[to * N + k] += face_of(t, hits, to)->along[i] * f->b[i] * f->leave[i];
        }
    }
    memcpy(t->A, t->K, (size_t)(N * N) * sizeof *t->A);
    if (!ric_dense_solve(N, N, t->A, change, DBL_MIN)) return false;
    for (int k = 0; k < N; k++)
        memcpy(&t->y[k * columns + 1], &change[k * N], (size_t)N * sizeof *change);
    return true;
}

/* Adds what flight k gives to r and J at both of its ends. */
static void add_flight(ric_times *t, const ric_hit *hits, int k)
{
    int N = t->N, columns = N + 1, to = (k + 1) % N;
    const ric_impact_map_face *from = face_of(t, hits, k), *goal = face_of(t, hits, to);
    const ric_times_flight *f = &t->flight[k];
    const double *y0 = &t->y[k * columns + 1], *y1 = &t->y[to * columns + 1];
    double out[2],
        in[2]; /* of y0 and y1: the change of n.leave at the start, and of n.arrive at the end */
    out[0] = out[1] = in[0] = in[1] = 0;
    for (int i = 0; i < 2; i++) {
        out[0] -= from->normal[i] * f->a[i] * from->along[i] / 2;
        out[1] += from->normal[i] * f->b[i] * goal->along[i] / 2;
        in[0] -= goal->normal[i] * f->b[i] * from->along[i] / 2;
        in[1] += goal->normal[i] * f->a[i] * goal->along[i] / 2;
        t->J[k * N + k] -= from->normal[i] * f->b[i] * f->arrive[i] / 2;
        t->J[to * N + k] -= goal->normal[i] * f->b[i] * f->leave[i] / 2;
    }
    for (int c = 0; c < N; c++) {
        t->J[k * N + c] += out[0] * y0[c] + out[1] * y1[c];
        t->J[to * N + c] += in[0] * y0[c] + in[1] * y1[c];
    }
    t->r[k] += dot(from->normal, f->leave) / 2;
    t->r[to] += dot(goal->normal, f->arrive) / 2;
}

/* The energy right after impact 0, over the speed that belongs to it, and its derivatives. */
static void add_energy(ric_times *t, const ric_hit *hits)
{
    int N = t->N, columns = N + 1;
    const ric_impact_map_face *from = face_of(t, hits, 0), *goal = face_of(t, hits, 1);
    const ric_times_flight *f = &t->flight[0];
    const double *y0 = &t->y[1], *y1 = &t->y[(1 % N) * columns + 1],
                 speed = sqrt(2 * t->section->energy);
    t->r[N] = -t->section->energy / speed;
    for (int i = 0; i < 2; i++) {
        double stiffness = t->section->omega[i] * t->section->omega[i];
        double q = from->at * from->normal[i] + t->y[0] * from->along[i], p = f->leave[i] / speed;
        t->r[N] += (p * f->leave[i] + stiffness * q * q / speed) / 2;
        t->J[N * N] -= p * f->b[i] * f->arrive[i];
        for (int c = 0; c < N; c++)
            t->J[N * N + c] += (stiffness * q / speed - p * f->a[i]) * from->along[i] * y0[c] +
                               p * f->b[i] * goal->along[i] * y1[c];
    }
}

/* r and J; the size of r, infinite where the times determine no places. */
static double evaluate(ric_times *t, const ric_hit *hits)
{
    int N = t->N;
    double sum = 0;
    if (!place(t, hits)) return INFINITY;
    memset(t->r, 0, sizeof t->r);
    memset(t->J, 0, (size_t)((N + 1) * N) * sizeof *t->J);
    for (int k = 0; k < N; k++) add_flight(t, hits, k);
    add_energy(t, hits);
    for (int k = 0; k <= N; k++) sum += t->r[k] * t->r[k];
    return isfinite(sum) ? sqrt(sum) : INFINITY;
}

/* The impact of the largest impulse. */
static int strongest(const ric_times *t, const ric_hit *hits)
{
    int best = 0;
    double most = -1;
    for (int k = 0; k < t->N; k++) {
        const double *normal = face_of(t, hits, k)->normal;
        double impulse = fabs(dot(normal, t->flight[k].leave) -
                              dot(normal, t->flight[(k + t->N - 1) % t->N].arrive));
        if (!(impulse > most)) continue;
        most = impulse;
        best = k;
    }
    return best;
}

static bool newton_step(ric_times *t, const ric_hit *hits)
{
    int N = t->N, row = strongest(t, hits);
    memcpy(t->A, t->J, (size_t)(N * N) * sizeof *t->A);
    memcpy(t->step, t->r, (size_t)N * sizeof *t->step);
    memcpy(t->A + row * N, t->J + N * N, (size_t)N * sizeof *t->A);
    t->step[row] = t->r[N];
    return ric_dense_solve(N, 1, t->A, t->step, DBL_MIN);
}

/* Part of the step; false: beyond the bounds. */
static bool go(const ric_times *t, double part, const ric_hit *from, ric_hit *to)
{
    double sum = 0;
    for (int k = 0; k < t->N; k++) {
        to[k].tau = from[k].tau - part * t->step[k];
        if (!(to[k].tau > BRIEFEST)) return false;
        sum += to[k].tau;
    }
    return sum < BEYOND * t->longest;
}

/* Places and angles of the solution; false: an impact pulls. */
static bool read_off(const ric_times *t, ric_hit *hits)
{
    for (int k = 0; k < t->N; k++) {
        const ric_impact_map_face *face = face_of(t, hits, k);
        const ric_times_flight *f = &t->flight[k];
        if (!(face->side * dot(face->normal, f->leave) < 0)) return false;
        hits[k].y = t->y[k * (t->N + 1)];
        hits[k].angle = atan2(dot(face->along, f->leave), fabs(dot(face->normal, f->leave)));
    }
    return true;
}

bool ric_hunt_times_solve(ric_times *t, ric_hit *hits)
{
    ric_hit next[RIC_TIMES_MOST];
    double small = sqrt(2 * t->section->energy), before = evaluate(t, hits);
    for (int i = 0; i < STEPS && before < INFINITY; i++) {
        if (before < SOLVED * small) return read_off(t, hits);
        if (!newton_step(t, hits)) return false;
        double part = 1, now = INFINITY;
        memcpy(next, hits, (size_t)t->N * sizeof *next);
        for (int halved = 0; halved < HALVINGS; halved++, part /= 2) {
            if (!go(t, part, hits, next)) continue;
            now = evaluate(t, next);
            if (now < (1 - GAIN * part) * before || now < SOLVED * small) break;
            now = INFINITY;
        }
        if (!(now < INFINITY))
            return before < NEARLY * small && evaluate(t, hits) < INFINITY && read_off(t, hits);
        memcpy(hits, next, (size_t)t->N * sizeof *hits);
        before = now;
    }
    return false;
}
