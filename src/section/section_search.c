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
/* Far from all faces a stretch of twice or four times a panel is passed at once: over more than
 * that the gap bulges beyond its chord by as much as it ever moves. */
enum { STRETCHES = 3 };
/* BAND: a maximum beyond the face by less than this part of the size of the gap coordinate is
 * rounding: a touch. */
#define BAND (16 * DBL_EPSILON)
/* STILL: speed over its bound below which a start on a face is one at rest: rounding of the
 * reflection leaves less. */
#define STILL (64 * DBL_EPSILON)

/* ------------------------------------------------------------------ phases */

/* The rotation of every mode over a time, as ric_flight_trig has it. */
static void tabulate_turn(const ric_section_phase *p, int n, double time, double *turn)
{
    for (int i = 0; i < n; i++) {
        bool turns = p->omega[i] > 0;
        double sine, cosine;
        ric_sine_cosine(p->omega[i] * time, &sine, &cosine);
        turn[i] = turns ? cosine : 1;
        turn[n + i] = turns ? sine : time;
        turn[2 * n + i] = turns ? turn[n + i] : 0;
    }
}

/* The side on which a face is met: from behind where its spring is closed. */
static double side_of(const ric_section_phase *p, const ric_model *m, int f)
{
    return ric_face_in(p->closed, f) ? -m->face[f].side : m->face[f].side;
}

ric_status ric_section_phase_create(const ric_model *m, uint64_t closed, ric_section_phase *p)
{
    size_t n = (size_t)m->n, contacts = (size_t)m->n_contact;
    double fastest = 0;
    *p = (ric_section_phase){.closed = closed, .omega = m->omega, .G = m->g};
    if (closed) {
        ric_status status = ric_regime_get(m, closed, &p->regime);
        if (status) return status;
        p->omega = p->regime->omega;
        p->G = p->regime->G;
        p->rest = p->regime->rest;
    }
    p->turn = ric_calloc(3 * STRETCHES * n + (2 * n + 2) * contacts, sizeof *p->turn);
    if (!p->turn) return ric_no_memory("a phase of a section");
    p->speed = p->turn + 3 * STRETCHES * n;
    p->bend = p->speed + n * contacts;
    p->low = p->bend + n * contacts;
    p->high = p->low + contacts;
    for (int i = 0; i < m->n; i++) fastest = fmax(fastest, p->omega[i]);
    p->panel = fastest > 0 ? PANEL / fastest : 0;
    for (int k = 0; k < STRETCHES; k++)
        tabulate_turn(p, m->n, (1 << k) * p->panel, p->turn + 3 * n * (size_t)k);
    for (size_t k = 0; k < n * contacts; k++) {
        double omega = p->omega[k % n];
        p->speed[k] = omega > 0 ? p->G[k] * omega : p->G[k];
        p->bend[k] = p->G[k] * omega * omega;
    }
    for (size_t c = 0; c < contacts; c++) p->low[c] = -(p->high[c] = INFINITY);
    for (int f = 0; f < m->n_face; f++) {
        const ric_face *face = &m->face[f];
        const int c = face->contact;
        if (side_of(p, m, f) > 0) p->high[c] = fmin(p->high[c], face->gap - BAND * fabs(face->gap));
        else p->low[c] = fmax(p->low[c], face->gap + BAND * fabs(face->gap));
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

/* g = sign * s - level of a face, negative before the event: by its change since the start, so that
 * a short flight keeps its relative accuracy. */
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
        ric_sine_cosine(omega * t / 2, &sine, &cosine);
        double both = 2 * sine * cosine, one = 1 - 2 * sine * sine, weight = g->G[i] * omega;
        s += 2 * g->G[i] * sine * (cosine * P - sine * A);
        v += weight * (one * P - both * A);
        a -= weight * omega * (one * A + both * P);
    }
    return (ric_sample){t, {g->start + g->sign * s, g->sign * v, g->sign * a}};
}

/* s and s' of every contact at the state z. */
static void look_here(const ric_section_phase *p, int n, int contacts, const double *z, double *s)
{
    for (int c = 0; c < contacts; c++, s += 2) {
        const double *G = p->G + c * n, *speed = p->speed + c * n;
        s[0] = p->rest ? p->rest[c] : 0;
        s[1] = 0;
        for (int i = 0; i < n; i++) {
            s[0] += G[i] * z[i];
            s[1] += speed[i] * z[n + i];
        }
    }
}

static double bend_here(const ric_section_phase *p, int n, int contact, const double *z)
{
    return -ric_dot(n, p->bend + contact * n, z);
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
    int left;                      /* the face that the flight starts on */
    double size;                   /* length of z */
    const double *second, *fourth; /* [n_contact] bounds of s'' and of its own second derivative */
    ric_section_event *found;
} search;

/* The gap of a face at the start of the flight, from s there. */
static double start_of(const search *q, int f, double s)
{
    return f == q->left ? 0 : side_of(q->phase, q->m, f) * (s - q->m->face[f].gap);
}

static double band_of(const search *q, int f, double s)
{
    return BAND * (fabs(q->m->face[f].gap) + fabs(s));
}

static gap gap_of(const search *q, int f, double s)
{
    const int contact = q->m->face[f].contact, n = q->m->n;
    return (gap){.phase = q->phase,
                 .n = n,
                 .z = q->z,
                 .G = q->phase->G + contact * n,
                 .sign = side_of(q->phase, q->m, f),
                 .start = start_of(q, f, s),
                 .fourth = q->fourth[contact],
                 .band = band_of(q, f, s)};
}

/* At the start: on a face and moving into it there is an event at once; resting on it under an
 * acceleration into it there is no flight, but for a spring. */
static void look_at_start(const search *q, const double *all)
{
    const ric_model *m = q->m;
    for (int f = 0; f < m->n_face; f++) {
        const int contact = m->face[f].contact;
        const double *s = all + 2 * contact, sign = side_of(q->phase, m, f);
        if (start_of(q, f, s[0]) < -band_of(q, f, s[0])) continue;
        const double speed = sign * s[1], still = STILL * sqrt(m->face[f].cc) * q->size;
        if (speed < -still) continue;
        if (speed > still && f != q->left) *q->found = (ric_section_event){.time = 0, .face = f};
        else if (m->face[f].spring == 0 && sign * bend_here(q->phase, m->n, contact, q->z) > 0)
            *q->found = (ric_section_event){.face = f, .rests = true};
    }
}

static double larger(double a, double b)
{
    return a > b ? a : b;
}

static double smaller(double a, double b)
{
    return a < b ? a : b;
}

/* Whether no face of a contact is met over a stretch of length h, with s and s' at its ends: its
 * chord with the largest bulge over that stays between the faces, or the Hermite interpolant with
 * what it is off. */
static bool stays_open(const search *q, int c, double h, const double *a, const double *b)
{
    const double low = q->phase->low[c], high = q->phase->high[c], least = smaller(a[0], b[0]),
                 most = larger(a[0], b[0]), bulge = q->second[c] * h * h * (1.0 / 8);
    if (most + bulge < high && least - bulge > low) return true;
    const double off = q->fourth[c] * h * h * h * h * (1.0 / 384), left = a[0] + h / 3 * a[1],
                 right = b[0] - h / 3 * b[1];
    return larger(most, larger(left, right)) + off < high &&
           smaller(least, smaller(left, right)) - off > low;
}

/* Over the panel that begins at time t, with states z, s and s' at its ends: the first event of
 * each face of a contact that is s at the start of the flight. */
static void look_at_faces(const search *q, int contact, double t, double s,
                          const double *const z[2], const double *const ends[2])
{
    const ric_model *m = q->m;
    const double bend[2] = {bend_here(q->phase, m->n, contact, z[0]),
                            bend_here(q->phase, m->n, contact, z[1])},
                 *a = ends[0] + 2 * contact, *b = ends[1] + 2 * contact, h = q->phase->panel,
                 bulge = q->second[contact] * h * h * (1.0 / 8);
    for (int f = 0; f < m->n_face; f++) {
        const double sign = side_of(q->phase, m, f), level = sign * m->face[f].gap,
                     top = larger(sign * a[0], sign * b[0]) + bulge;
        if (m->face[f].contact != contact || top < level - band_of(q, f, s)) continue;
        const gap g = gap_of(q, f, s);
        ric_sample first = {t, {sign * a[0] - level, sign * a[1], sign * bend[0]}},
                   last = {t + h, {sign * b[0] - level, sign * b[1], sign * bend[1]}};
        if (t == 0) first.g[0] = fmin(g.start, 0);
        double found = first_crossing(&g, &first, &last);
        if (found < q->found->time) *q->found = (ric_section_event){.time = found, .face = f};
    }
}

/* Without a mode that turns the gaps are straight lines. */
static void look_straight(const search *q, const double *s)
{
    for (int f = 0; f < q->m->n_face; f++) {
        const double *c = s + 2 * q->m->face[f].contact;
        double speed = side_of(q->phase, q->m, f) * c[1],
               t = speed > 0 ? -start_of(q, f, c[0]) / speed : INFINITY;
        if (f != q->left && t < q->found->time)
            *q->found = (ric_section_event){.time = fmax(0, t), .face = f};
    }
}

/* The amplitudes of a flight, which no part of it changes: bounds of the derivatives of every gap
 * [n_contact each]. */
static void bound_flight(const ric_section_phase *p, int n, int contacts, const double *z,
                         double *second, double *fourth)
{
    memset(second, 0, (size_t)contacts * sizeof *second);
    memset(fourth, 0, (size_t)contacts * sizeof *fourth);
    for (int i = 0; i < n; i++) {
        if (!(p->omega[i] > 0)) continue;
        double square = p->omega[i] * p->omega[i],
               amplitude = sqrt(z[i] * z[i] + z[n + i] * z[n + i]) * (1 + 4 * DBL_EPSILON);
        for (int c = 0; c < contacts; c++) {
            double part = fabs(p->bend[c * n + i]) * amplitude;
            second[c] += part;
            fourth[c] += square * part;
        }
    }
}

static double size_of(int n, const ric_section_phase *p, const double *z)
{
    double sum = 0;
    for (int i = 0; i < n; i++) sum += (p->omega[i] > 0 ? z[i] * z[i] : 0) + z[n + i] * z[n + i];
    return sqrt(sum);
}

static void swap(double **a, double **b)
{
    double *keep = *a;
    *a = *b;
    *b = keep;
}

/* Panel by panel, and in longer stretches as long as these tell that no face is met. work [4n + 4
 * n_contact]. */
static void look_ahead(const search *q, const double *begin, long panels, double *work)
{
    const ric_section_phase *p = q->phase;
    const int n = q->m->n, contacts = q->m->n_contact;
    double *z = work, *next = z + 2 * n, *from = next + 2 * n, *to = from + 2 * contacts;
    memcpy(z, q->z, 2 * (size_t)n * sizeof *z);
    memcpy(from, begin, 2 * (size_t)contacts * sizeof *from);
    for (long done = 0, k = 0; done < panels && q->found->face < 0;) {
        const double h = (double)(1L << k) * p->panel;
        ric_flight(n, p->turn + 3 * n * k, z, next);
        look_here(p, n, contacts, next, to);
        bool open = true;
        for (int c = 0; c < contacts; c++) {
            if (stays_open(q, c, h, from + 2 * c, to + 2 * c)) continue;
            open = false;
            if (k > 0) break;
            look_at_faces(q, c, (double)done * p->panel, begin[2 * c], (const double *[]){z, next},
                          (const double *[]){from, to});
        }
        if (!open && k > 0) {
            k = 0;
            continue;
        }
        done += 1L << k;
        k = !open ? 0 : k + 1 < STRETCHES ? k + 1 : k;
        swap(&z, &next);
        swap(&from, &to);
    }
}

ric_section_event ric_section_search(const ric_model *m, const ric_section_phase *p,
                                     const double *z, int face, long panels, double *work)
{
    ric_section_event found = {.time = INFINITY, .face = -1};
    double *begin = work, *second = begin + 2 * m->n_contact, *fourth = second + m->n_contact;
    search q = {m, p, z, face, size_of(m->n, p, z), second, fourth, &found};
    bound_flight(p, m->n, m->n_contact, z, second, fourth);
    look_here(p, m->n, m->n_contact, z, begin);
    look_at_start(&q, begin);
    if (found.face >= 0) return found;
    if (p->panel == 0) look_straight(&q, begin);
    else look_ahead(&q, begin, panels, fourth + m->n_contact);
    return found;
}
