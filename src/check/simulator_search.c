/* Flights in closed form, and the guaranteed search for the next time at which a face is met
 * (simulator.c). */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>

#include "simulator_parts.h"
#include "base/room.h"

/* LEVEL_PARTS: of a panel, in each of which a gap bends the other way once at most, or in vain */
#define LEVEL_PARTS 8

ric_sample ric_simulator_search_look(const ric_simulator *sim, const face_t *face, double t)
{
    int n = sim->n;
    const double *omega = sim->rough, *q = omega + n, *p = q + n, *c = p + n + face->contact * n;
    double s = 0, v = 0, a = 0;
    for (int i = 0; i < n; i++) {
        if (omega[i] > 0) {
            double sine, cosine;
            sincos(omega[i] * t / 2, &sine, &cosine);
            double both = 2 * sine * cosine, one = 1 - 2 * sine * sine, stretch = omega[i] * q[i];
            s += c[i] * 2 * sine * (cosine * p[i] - sine * stretch) / omega[i];
            v += c[i] * (p[i] * one - stretch * both);
            a -= c[i] * omega[i] * (stretch * one + p[i] * both);
        } else {
            s += c[i] * p[i] * t;
            v += c[i] * p[i];
        }
    }
    return (ric_sample){t, {(double)face->start + face->sign * s, face->sign * v, face->sign * a}};
}

void ric_simulator_search_look_closely(const ric_simulator *sim, const face_t *face, real t,
                                       real *g)
{
    real s = 0, v = 0, a = 0;
    for (int i = 0; i < sim->n; i++) {
        real c = face->c[i], omega = sim->omega[i], q = sim->q[i], p = sim->p[i], sine, cosine;
        sincosl(omega * t / 2, &sine, &cosine);
        real both = 2 * sine * cosine, one = 1 - 2 * sine * sine;
        s += c * (omega > 0 ? 2 * sine * (cosine * p / omega - sine * q) : p * t);
        v += c * (p * one - omega * q * both);
        a -= c * omega * (omega * q * one + p * both);
    }
    g[0] = face->start + face->sign * s;
    g[1] = face->sign * v;
    g[2] = face->sign * a;
}

void ric_simulator_search_fly_mode(const ric_simulator *sim, int i, real t, real *q, real *p)
{
    real omega = sim->omega[i], qi = sim->q[i], pi = sim->p[i], sine, cosine;
    sincosl(omega * t, &sine, &cosine);
    *q = omega > 0 ? qi * cosine + pi / omega * sine : qi + pi * t;
    *p = pi * cosine - omega * qi * sine;
}

static void bound_face(const ric_simulator *sim, face_t *face)
{
    real s = face->rest, size = face->limit + fabs(face->rest);
    memset(face->D, 0, sizeof face->D);
    for (int i = 0; i < sim->n; i++) {
        real c = fabs(face->c[i]), omega = sim->omega[i],
             speed = c * hypot(omega * sim->q[i], sim->p[i]);
        s += face->c[i] * sim->q[i];
        size += omega > 0 ? speed / omega : c * fabs(sim->q[i]);
        face->D[0] += omega > 0 ? speed / omega : speed > 0 ? INFINITY : c * fabs(sim->q[i]);
        for (int k = 1; k <= 4; k++, speed *= omega) face->D[k] += speed;
    }
    face->band = ROUNDING * size + face->noise;
    face->level = fmax(face->edge, face->sign * s);
    face->start = face->sign * s - face->level;
    if (face->start >= -face->band) face->start = 0;
}

void ric_simulator_search_begin(ric_simulator *sim)
{
    for (int i = 0; i < 2 * sim->n; i++)
        sim->rough[sim->n + i] = (double)sim->q[i]; /* p follows q in memory */
    for (int f = 0; f < sim->n_face; f++) bound_face(sim, &sim->face[f]);
    sim->now = sim->known = sim->scanned = 0;
    sim->next = INFINITY;
    sim->next_face = -1;
    sim->examined = false;
}

double ric_simulator_search_time(const ric_simulator *sim, real t)
{
    return (double)(sim->origin + (sim->origin_low + t));
}

void ric_simulator_search_move_origin(ric_simulator *sim, real t)
{
    real step = sim->origin_low + t, sum = sim->origin + step;
    sim->origin_low = step - (sum - sim->origin);
    sim->origin = sum;
}

/* ---------------------------------------------------- guaranteed intervals */

static ric_shape classify(const face_t *face, const ric_sample *a, const ric_sample *b,
                          double level)
{
    return ric_hermite_shape((double)face->D[4], (double)face->band, a, b, level);
}

typedef struct {
    const ric_simulator *sim;
    const face_t *face;
} flight;

static ric_sample look(const void *of, double t)
{
    const flight *at = of;
    return ric_simulator_search_look(at->sim, at->face, t);
}

static ric_sample zero(const ric_simulator *sim, const face_t *face, int order, ric_sample lo,
                       ric_sample hi)
{
    return ric_hermite_zero(look, &(flight){sim, face}, order, lo, hi);
}

/* The last digits of a root t of g that lies in [lo, hi]; t itself where the slope does not tell
 * them. */
static real refine(const ric_simulator *sim, const face_t *face, double lo, double hi, double t)
{
    enum { STEPS = 6 };
    real x = t;
    for (int i = 0; i < STEPS; i++) {
        real g[3], next;
        ric_simulator_search_look_closely(sim, face, x, g);
        next = g[1] > 0 ? x - g[0] / g[1] : t;
        if (!(next >= lo && next <= hi)) return t;
        if (fabs(next - x) <= LDBL_EPSILON * x) return next;
        x = next;
    }
    return x;
}

/* Where g rises through 0 in [a, b], given g(a) <= rounding < g(b) and that g is monotone, or
 * convex, there. */
static real rise(const ric_simulator *sim, const face_t *face, ric_sample a, const ric_sample *b)
{
    if (a.g[1] < 0 && b->g[1] > 0) a = zero(sim, face, 1, a, *b);
    if (a.g[0] < 0) return refine(sim, face, a.t, b->t, zero(sim, face, 0, a, *b).t);
    double t = fmax(0, a.g[1] > 0 ? a.t - a.g[0] / a.g[1] : a.t), h = b->t - a.t;
    return refine(sim, face, fmax(0, t - h), b->t, t);
}

/* First time in [a, b] at which the face is met, infinite if it is not. */
static real first_crossing(const ric_simulator *sim, const face_t *face, const ric_sample *a,
                           const ric_sample *b)
{
    ric_shape kind = classify(face, a, b, (double)face->band);
    if (kind == RIC_SHAPE_BELOW || kind == RIC_SHAPE_FALLING) return INFINITY;
    if (kind == RIC_SHAPE_CONCAVE && a->g[1] > 0 && b->g[1] < 0) {
        ric_sample top = zero(sim, face, 1, *a, *b);
        return top.g[0] > face->band ? rise(sim, face, *a, &top) : INFINITY;
    }
    if (kind != RIC_SHAPE_UNKNOWN) return b->g[0] > face->band ? rise(sim, face, *a, b) : INFINITY;
    ric_sample middle = ric_simulator_search_look(sim, face, a->t + (b->t - a->t) / 2);
    real t = first_crossing(sim, face, a, &middle);
    return is_finite(t) ? t : first_crossing(sim, face, &middle, b);
}

/* Largest stationary value of g in [a, b], if it is above `best` by more than rounding; else
 * `best`. */
static double highest(const ric_simulator *sim, const face_t *face, const ric_sample *a,
                      const ric_sample *b, double best)
{
    ric_shape kind = classify(face, a, b, best + (double)face->band);
    if (kind == RIC_SHAPE_CONCAVE && a->g[1] >= 0 && b->g[1] <= 0)
        return fmax(best, zero(sim, face, 1, *a, *b).g[0]);
    /* an arc that rounding hides has a slope that it does not, as within the contact of a stiff
     * spring */
    const real none = ROUNDING * face->D[1];
    if (kind == RIC_SHAPE_FLAT && a->g[1] > none && b->g[1] < -none)
        return fmax(best, zero(sim, face, 1, *a, *b).g[0]);
    if (kind != RIC_SHAPE_UNKNOWN) return best;
    ric_sample middle = ric_simulator_search_look(sim, face, a->t + (b->t - a->t) / 2);
    best = highest(sim, face, a, &middle, best);
    return highest(sim, face, &middle, b, best);
}

double ric_simulator_search_panel(const face_t *face)
{
    return face->D[4] > 0 ? (double)sqrt(sqrt(20 * face->limit / face->D[4])) : INFINITY;
}

real ric_simulator_search_face(const ric_simulator *sim, const face_t *face, double from, double to)
{
    if (face->sign * face->rest + face->D[0] < face->level) return INFINITY;
    real found = INFINITY;
    double h = ric_simulator_search_panel(face);
    ric_sample a = ric_simulator_search_look(sim, face, from);
    while (a.t < to && !is_finite(found)) {
        ric_sample b = ric_simulator_search_look(sim, face, fmin(to, a.t + h));
        if (b.t <= a.t) break;
        found = first_crossing(sim, face, &a, &b);
        a = b;
    }
    return found;
}

/* ------------------------------------------------------------------- reach */

double ric_simulator_search_to_reach(const face_t *face, double g)
{
    return (double)((g + face->level) / face->limit);
}

void ric_simulator_search_scan_reach(ric_simulator *sim, double to)
{
    for (int f = 0; f < sim->n_face; f++) {
        const face_t *face = &sim->face[f];
        double h = ric_simulator_search_panel(face);
        ric_sample a = ric_simulator_search_look(sim, face, (double)sim->scanned);
        while (a.t < to && !face->closed &&
               face->sign * face->rest + face->D[0] > sim->reach * face->limit + face->band) {
            ric_sample b = ric_simulator_search_look(sim, face, fmin(to, a.t + h));
            if (b.t <= a.t) break;
            double level = (double)(sim->reach * face->limit - face->level),
                   top = highest(sim, face, &a, &b, level);
            if (top > level) sim->reach = ric_simulator_search_to_reach(face, top);
            a = b;
        }
    }
    sim->scanned = fmax(sim->scanned, to);
}

void ric_simulator_search_start_reach(ric_simulator *sim)
{
    for (int f = 0; f < sim->n_face; f++) {
        const face_t *face = &sim->face[f];
        ric_sample a = ric_simulator_search_look(sim, face, 0);
        bool still = fabs(a.g[1]) <= ROUNDING * face->D[1],
             left = a.g[0] >= -BEYOND * face->limit && !still;
        if (!face->closed && (a.g[1] <= 0 || still))
            if (!left) sim->reach = fmax(sim->reach, ric_simulator_search_to_reach(face, a.g[0]));
    }
}

/* The face seen from the other side, on which the motion is its image. */
static face_t image_of(face_t face)
{
    real s = face.start + face.level; /* sign * s */
    face.sign = -face.sign;
    face.start = -s - face.level;
    face.rest = -face.rest;
    return face;
}

double ric_simulator_highest(const ric_simulator *sim, int f, bool image, double from, double to,
                             double best)
{
    face_t face = image ? image_of(sim->face[f]) : sim->face[f];
    double h = ric_simulator_search_panel(&face), more = face.closed ? 2 : 0;
    if (!isfinite(h)) return best;
    ric_sample a = ric_simulator_search_look(sim, &face, from);
    while (a.t < to) {
        ric_sample b = ric_simulator_search_look(sim, &face, fmin(to, a.t + h));
        if (b.t <= a.t) break;
        double level = (best - more) * (double)face.limit - (double)face.level,
               top = highest(sim, &face, &a, &b, level);
        if (top > level) best = ric_simulator_search_to_reach(&face, top) + more;
        a = b;
    }
    return best;
}

double ric_simulator_level(const ric_simulator *sim, int f, bool image, const double part[2],
                           double slow, double wanted)
{
    face_t face = image ? image_of(sim->face[f]) : sim->face[f];
    double h = ric_simulator_search_panel(&face) / LEVEL_PARTS, more = face.closed ? 2 : 0,
           best = HUGE_VAL;
    if (!isfinite(h)) return best;
    ric_sample a = ric_simulator_search_look(sim, &face, part[0]);
    while (a.t < part[1]) {
        ric_sample b = ric_simulator_search_look(sim, &face, fmin(part[1], a.t + h)), at = b;
        if (b.t <= a.t) break;
        if (a.g[2] * b.g[2] < 0) {
            ric_root root = ric_root_between(a.t, a.g[2], b.t, b.g[2], DBL_EPSILON * b.t);
            while (ric_root_next(&root))
                root.f = ric_simulator_search_look(sim, &face, root.x).g[2];
            at = ric_simulator_search_look(sim, &face, root.x);
        }
        const double value = ric_simulator_search_to_reach(&face, at.g[0]) + more;
        if (a.g[2] * b.g[2] <= 0 && fabs(at.g[1]) <= slow &&
            fabs(value - wanted) < fabs(best - wanted))
            best = value;
        a = b;
    }
    return best;
}

double ric_simulator_reach(const ric_simulator *sim)
{
    double reach = (double)sim->reach;
    if (!sim->started || sim->now == 0) return (double)reach;
    for (int f = 0; f < sim->n_face; f++) {
        ric_sample a = ric_simulator_search_look(sim, &sim->face[f], (double)sim->now);
        if (a.g[1] >= 0 && !sim->face[f].closed)
            reach = fmax(reach, ric_simulator_search_to_reach(&sim->face[f], a.g[0]));
    }
    return (double)reach;
}
