#include "section_search.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"

/* Length of a panel over 1 / omega of the fastest mode, rad: the interpolant of its motion is then
 * off by 6e-4 of its amplitude, so that most panels decide without being halved. Ten times as much
 * halves most of them. */
#define PANEL 0.7
/* BAND: a maximum beyond the face by less than this part of the size of the gap coordinate is
 * rounding: a touch. */
#define BAND (16 * DBL_EPSILON)
/* STILL: speed over its bound below which a start on a face is one at rest: rounding of the
 * reflection leaves less. */
#define STILL (64 * DBL_EPSILON)

/* ------------------------------------------------------------------ phases */

ric_status ric_section_phase_create(const ric_model *m, uint64_t closed, ric_section_phase *p)
{
    int n = m->n;
    double fastest = 0;
    *p = (ric_section_phase){.closed = closed, .omega = m->omega, .G = m->g};
    if (closed) {
        ric_status status = ric_regime_get(m, closed, &p->regime);
        if (status) return status;
        p->omega = p->regime->omega;
        p->G = p->regime->G;
        p->rest = p->regime->rest;
    }
    p->turn = ric_calloc(3 * (size_t)n + 2 * (size_t)m->n_contact, sizeof *p->turn);
    if (!p->turn) return ric_no_memory("a phase of a section");
    p->fourth = p->turn + 3 * n;
    p->bulge = p->fourth + m->n_contact;
    for (int i = 0; i < n; i++) fastest = fmax(fastest, p->omega[i]);
    p->panel = fastest > 0 ? PANEL / fastest : 0;
    for (int i = 0; i < n; i++) {
        bool turns = p->omega[i] > 0;
        p->turn[i] = turns ? cos(p->omega[i] * p->panel) : 1;
        p->turn[n + i] = turns ? sin(p->omega[i] * p->panel) : p->panel;
        p->turn[2 * n + i] = turns ? p->turn[n + i] : 0;
    }
    for (int f = 0; f < m->n_contact; f++) {
        double second = 0, fourth = 0;
        for (int i = 0; i < n; i++) {
            double square = p->omega[i] * p->omega[i], part = p->G[f * n + i] * square;
            second += part * part;
            fourth += part * square * part * square;
        }
        p->fourth[f] = sqrt(fourth);
        p->bulge[f] = sqrt(second) * p->panel * p->panel / 8;
    }
    return RIC_OK;
}

void ric_section_phase_release(ric_section_phase *p)
{
    free(p->turn);
    p->turn = NULL;
}

/* ----------------------------------------------------------------- samples */

typedef struct {
    const ric_section_phase *phase;
    int n;
    const double *z; /* [2n] at the start of the flight */
    const double *G; /* [n] of the contact */
    double sign;     /* of s in g: side of the face, the opposite of a closed one */
    double start;    /* g at the start, exactly 0 on the face that is left */
    double fourth, band;
} gap;

/* g by its change since the start, so that a short flight keeps its relative accuracy. */
/* g = sign * s - level of a face, negative before the event. */
static ric_sample look(const void *of, double t)
{
    const gap *g = of;
    int n = g->n;
    double s = 0, v = 0, a = 0;
    for (int i = 0; i < n; i++) {
        double omega = g->phase->omega[i], A = g->z[i], P = g->z[n + i], sine, cosine;
        if (omega == 0) {
            s += g->G[i] * P * t;
            v += g->G[i] * P;
            continue;
        }
        sincos(omega * t / 2, &sine, &cosine);
        double both = 2 * sine * cosine, one = 1 - 2 * sine * sine, weight = g->G[i] * omega;
        s += 2 * g->G[i] * sine * (cosine * P - sine * A);
        v += weight * (one * P - both * A);
        a -= weight * omega * (one * A + both * P);
    }
    return (ric_sample){t, {g->start + g->sign * s, g->sign * v, g->sign * a}};
}

/* s, s', s'' of a contact at the state z. */
static void look_here(const ric_section_phase *p, int n, int contact, const double *z, double *s)
{
    const double *G = p->G + contact * n;
    s[0] = p->rest ? p->rest[contact] : 0;
    s[1] = s[2] = 0;
    for (int i = 0; i < n; i++) {
        double omega = p->omega[i], weight = omega > 0 ? G[i] * omega : G[i];
        s[0] += G[i] * z[i];
        s[1] += weight * z[n + i];
        s[2] -= weight * omega * z[i];
    }
}

/* ------------------------------------------------------ guaranteed intervals */

static ric_shape classify(const gap *face, const ric_sample *a, const ric_sample *b)
{
    return ric_hermite_shape(face->fourth, face->band, a, b, face->band);
}

/* Where g rises through 0 in [a, b], given g(a) <= rounding < g(b) and that g is monotone, or
 * convex, there. */
static double rise(const gap *face, ric_sample a, const ric_sample *b)
{
    if (a.g[1] < 0 && b->g[1] > 0) a = ric_hermite_zero(look, face, 1, a, *b);
    if (a.g[0] < 0) return ric_hermite_zero(look, face, 0, a, *b).t;
    return fmax(0, a.g[1] > 0 ? a.t - a.g[0] / a.g[1] : a.t);
}

/* First time in [a, b] at which the face is met, infinite if it is not. */
static double first_crossing(const gap *face, const ric_sample *a, const ric_sample *b)
{
    ric_shape kind = classify(face, a, b);
    if (kind == RIC_SHAPE_BELOW || kind == RIC_SHAPE_FALLING) return INFINITY;
    if (kind == RIC_SHAPE_CONCAVE && a->g[1] > 0 && b->g[1] < 0) {
        ric_sample top = ric_hermite_zero(look, face, 1, *a, *b);
        return top.g[0] > face->band ? rise(face, *a, &top) : INFINITY;
    }
    if (kind != RIC_SHAPE_UNKNOWN) return b->g[0] > face->band ? rise(face, *a, b) : INFINITY;
    ric_sample middle = look(face, a->t + (b->t - a->t) / 2);
    if (middle.t <= a->t || middle.t >= b->t) return INFINITY;
    double t = first_crossing(face, a, &middle);
    return t < INFINITY ? t : first_crossing(face, &middle, b);
}

/* ------------------------------------------------------------------ search */

typedef struct {
    const ric_model *m;
    const ric_section_phase *phase;
    const double *z;
    int left; /* the face that the flight starts on */
    double size;
    ric_section_event *found;
} search;

static double sign_of(const search *q, int f)
{
    return q->phase->closed >> f & 1 ? -q->m->face[f].side : q->m->face[f].side;
}

/* The gap of a face from s at the start of the flight. */
static gap gap_of(const search *q, int f, const double *s)
{
    const ric_face *face = &q->m->face[f];
    int n = q->m->n;
    gap g = {.phase = q->phase,
             .n = n,
             .z = q->z,
             .G = q->phase->G + face->contact * n,
             .sign = sign_of(q, f),
             .fourth = q->phase->fourth[face->contact] * q->size};
    g.start = f == q->left ? 0 : g.sign * (s[0] - face->gap);
    g.band = BAND * (fabs(face->gap) + fabs(s[0]));
    return g;
}

/* At the start: on a face and moving into it there is an event at once; resting on it under an
 * acceleration into it there is no flight, but for a spring. */
static void look_at_start(const search *q, const double *all)
{
    const ric_model *m = q->m;
    for (int f = 0; f < m->n_face; f++) {
        const double *s = all + 3 * m->face[f].contact;
        gap g = gap_of(q, f, s);
        double speed = g.sign * s[1], still = STILL * sqrt(m->face[f].cc) * q->size;
        if (g.start < -g.band || speed < -still) continue;
        if (speed > still && f != q->left) *q->found = (ric_section_event){.time = 0, .face = f};
        else if (g.sign * s[2] > 0 && m->face[f].spring == 0)
            *q->found = (ric_section_event){.face = f, .rests = true};
    }
}

/* Over the panel that begins at time t, with s at its ends: the first event of each face. Most
 * panels lie so far below a face that the chord of the gap and its largest bulge over that tell. */
static void look_at_panel(const search *q, double t, const double *begin, const double *from,
                          const double *to)
{
    const ric_model *m = q->m;
    for (int f = 0; f < m->n_face; f++) {
        int contact = m->face[f].contact;
        const double *a = from + 3 * contact, *b = to + 3 * contact, gap_here = m->face[f].gap;
        const double sign = sign_of(q, f), level = sign * gap_here;
        if (fmax(sign * a[0], sign * b[0]) - level + q->size * q->phase->bulge[contact] <
            -BAND * fabs(gap_here))
            continue;
        const gap g = gap_of(q, f, begin + 3 * contact);
        ric_sample first = {t, {g.sign * a[0] - level, g.sign * a[1], g.sign * a[2]}},
                   last = {t + q->phase->panel,
                           {g.sign * b[0] - level, g.sign * b[1], g.sign * b[2]}};
        if (t == 0) first.g[0] = fmin(g.start, 0);
        double found = first_crossing(&g, &first, &last);
        if (found < q->found->time) *q->found = (ric_section_event){.time = found, .face = f};
    }
}

/* Without a mode that turns the gaps are straight lines. */
static void look_straight(const search *q, const double *s)
{
    for (int f = 0; f < q->m->n_face; f++) {
        const double *c = s + 3 * q->m->face[f].contact;
        gap g = gap_of(q, f, c);
        double t = g.sign * c[1] > 0 ? -g.start / (g.sign * c[1]) : INFINITY;
        if (f != q->left && t < q->found->time)
            *q->found = (ric_section_event){.time = fmax(0, t), .face = f};
    }
}

static double size_of(int n, const ric_section_phase *p, const double *z)
{
    double sum = 0;
    for (int i = 0; i < n; i++) sum += (p->omega[i] > 0 ? z[i] * z[i] : 0) + z[n + i] * z[n + i];
    return sqrt(sum);
}

ric_section_event ric_section_search(const ric_model *m, const ric_section_phase *p,
                                     const double *z, int face, long panels, double *work)
{
    int n = m->n, contacts = m->n_contact;
    double *here = work, *begin = here + 2 * n, *from = begin + 3 * contacts,
           *to = from + 3 * contacts;
    ric_section_event found = {.time = INFINITY, .face = -1};
    search q = {m, p, z, face, size_of(n, p, z), &found};
    memcpy(here, z, 2 * (size_t)n * sizeof *here);
    for (int f = 0; f < contacts; f++) look_here(p, n, f, z, begin + 3 * f);
    look_at_start(&q, begin);
    if (found.face >= 0) return found;
    if (p->panel == 0) look_straight(&q, begin);
    memcpy(from, begin, 3 * (size_t)contacts * sizeof *from);
    for (long k = 0; k < panels && found.face < 0 && p->panel > 0; k++) {
        ric_flight(n, p->turn, here, here);
        for (int f = 0; f < contacts; f++) look_here(p, n, f, here, to + 3 * f);
        look_at_panel(&q, (double)k * p->panel, begin, from, to);
        double *last = from;
        from = to;
        to = last;
    }
    return found;
}
