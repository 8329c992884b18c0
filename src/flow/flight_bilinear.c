/* Flights with springs that are closed: linear in the modes of the structure that the springs have
 * joined (regime.h). Such a set of springs acts from its faces on. */
#include "flight_law.h"

/* The regime of a set of closed springs. Without one, for want of memory or because both faces of a
 * contact would be closed, the states are no numbers, and the chain does not converge. */
static const ric_regime *regime_of(const ric_model *m, uint64_t closed, double *lost)
{
    const ric_regime *regime;
    ric_regime_get(m, closed, &regime);
    for (int i = 0; !regime && i < 2 * m->n; i++) lost[i] = NAN;
    return regime;
}

static const ric_face *closing(const ric_model *m, uint64_t closed, int event)
{
    return ric_face_in(closed, event) ? &m->face[event] : NULL;
}

static void go(const ric_model *m, uint64_t closed, int event, double tau, const double *w,
               double *after)
{
    if (!closed) {
        ric_flight_rigid.go(m, closed, event, tau, w, after);
        return;
    }
    const ric_regime *regime = regime_of(m, closed, after);
    if (regime)
        ric_regime_fly(regime, &(ric_regime_course){closing(m, closed, event), tau, w}, after);
}

static void map(const ric_model *m, uint64_t closed, int event, double tau, const double *w,
                double *matrix, double *after, double *rate)
{
    int n = m->n;
    if (!closed) {
        ric_flight_rigid.map(m, closed, event, tau, w, matrix, after, rate);
        return;
    }
    const ric_regime *regime = regime_of(m, closed, after);
    if (!regime) return;
    ric_regime_map(regime, &(ric_regime_course){closing(m, closed, event), tau, w}, matrix, after,
                   rate + n);
    for (int i = 0; i < n; i++) rate[i] = m->kappa[i] * after[n + i];
}

/* How far a closed face is pressed in, w [2n]. */
static double over(const ric_model *m, const ric_face *face, const double *w)
{
    return ric_gap(m->n, face, w) - face->gap;
}

static void push(const ric_model *m, uint64_t closed, const double *w, double *rate)
{
    for (int f = 0; closed >> f && f < m->n_face; f++) {
        if (!ric_face_in(closed, f)) continue;
        double force = m->face[f].spring * over(m, &m->face[f], w);
        for (int i = 0; i < m->n; i++) rate[m->n + i] -= force * m->face[f].c[i];
    }
}

static double store(const ric_model *m, uint64_t closed, const double *w)
{
    double springs = 0;
    for (int f = 0; closed >> f && f < m->n_face; f++) {
        if (!ric_face_in(closed, f)) continue;
        double s = over(m, &m->face[f], w);
        springs += m->face[f].spring * s * s;
    }
    return springs;
}

static void secant(const ric_model *m, uint64_t closed, const double *w0, const double *w1,
                   double *h)
{
    for (int f = 0; closed >> f && f < m->n_face; f++) {
        if (!ric_face_in(closed, f)) continue;
        const ric_face *face = &m->face[f];
        double force = face->spring *
                       (ric_gap(m->n, face, w0) + ric_gap(m->n, face, w1) - 2 * face->gap);
        for (int i = 0; i < m->n; i++) h[i] += force * face->g[i];
    }
}

const ric_flight_law ric_flight_bilinear =
    {.closes = true, .go = go, .map = map, .push = push, .store = store, .secant = secant};

/* --------------------------------------------------- flights between events */

double ric_flight_chord(const ric_model *m, uint64_t closed, int event, int face, double tau,
                        const double *w, double *by_w, double *by_tau)
{
    const ric_regime *regime;
    double lost = NAN;
    if (ric_regime_get(m, closed, &regime)) return lost;
    const ric_regime_course from = {closing(m, closed, event), tau, w};
    return ric_regime_chord(regime, &from, m->face[face].contact, by_w, by_tau);
}

bool ric_flight_fine(const ric_model *m, uint64_t closed, long double tau, long double *w, int ld,
                     long double *V)
{
    const ric_regime *regime;
    long double by[3 * m->n];
    if (ric_regime_get(m, closed, &regime)) return false;
    ric_regime_turn_fine(regime, tau, by);
    ric_regime_fly_fine(regime, by, 1, true, w);
    if (V) ric_regime_fly_fine(regime, by, ld, false, V);
    return true;
}

void ric_flight_onto(const ric_model *m, uint64_t closed, int event, int ld, double *X)
{
    const ric_face *from = closing(m, closed, event);
    if (from) ric_regime_onto(m->n, from, ld, X);
}

double ric_flight_fastest(const ric_model *m, uint64_t closed)
{
    const ric_regime *regime;
    double fastest = 0;
    if (!closed || ric_regime_get(m, closed, &regime)) return 0;
    for (int i = 0; i < m->n; i++) fastest = fmax(fastest, regime->omega[i]);
    return fastest;
}

uint64_t ric_flight_mirror(const ric_model *m, uint64_t closed)
{
    uint64_t image = 0;
    for (int f = 0; closed >> f && f < m->n_face; f++)
        if (ric_face_in(closed, f) && m->face[f].mirror >= 0)
            image |= (uint64_t)1 << m->face[f].mirror;
    return image;
}
