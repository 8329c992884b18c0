#include "reach.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "model/room.h"

/* The gap coordinate of one contact over one flight: s(t) = sum g_i (a_i cos + p_i sin), known with
 * its slope at both ends. On an interval of length h the cubic through values and slopes differs
 * from s by at most D4 h^4 / 384 and its slope by at most D4 h^3 sqrt(3) / 216, D4 = sum |g_i|
 * omega_i^4 |w_i| (interpolation error of Hermite's cubic: Birkhoff and Priver, J. Math. Phys. 46
 * (1967) 440). Bernstein coefficients bound the cubic: no stationary point can hide. While springs
 * are closed the sinusoids are those of the phase, about its equilibrium (docs/theory.md section
 * 10). A closed face is looked at from the other side: it must stay beyond the clearance d, and
 * what counts is 2 - s / d, which is 1 where it touches. */

#define SLOPE_BOUND 0.008018753738744785 /* sqrt(3) / 216 */
#define LEVELS 48
#define BLUR (16 * DBL_EPSILON) /* of the sum of the terms of a gap coordinate: rounding of it */
/* Below this part of the flight a stationary point at the very end of a flight is the impact there,
 * at zero speed. */
#define CLOSE 1e-7
#define BERNSTEIN 1e-13  /* rounding of a bound from Bernstein coefficients, relative */
#define NARROWEST 1e-12  /* of the flight: an interval that is not divided any more */
#define STATIONARY 1e-10 /* of the flight: step to a stationary point */
/* COARSE: the same where its time is not asked for, and only as long as the third power of the
 * step, to which the value there is met, is MET of the clearance */
#define COARSE 1e-6
#define MET 1e-16
/* ITSELF: relative: what rounding may take from the largest reach when it is computed again */
#define ITSELF 1e-14
/* NO_TIME: scaled: a contact of a spring that has shrunk to this lasts no time, and its s' is
 * rounding throughout */
#define NO_TIME 1e-12
/* LEVEL: slope that counts as none, relative to the largest that D3 allows within the flight, or,
 * in one that lasts no time, to its terms added up */
#define LEVEL 1e-8
/* INSTANT: scaled: a flight that short lies between two events at one instant */
#define INSTANT 1e-4
/* BELOW: relative: what is less than the level by more is so whatever rounding did to either */
#define BELOW 1e-12

typedef struct {
    double t, s, ds, bend; /* s' and s'' */
} sample;

typedef struct {
    const ric_shooting *chain;
    int flight, contact, n;
    const ric_regime *phase; /* NULL while all springs are open */
    double *start,
        *end; /* [2n] the states at both ends of the flight in coordinates of the phase: (A, P) */
    const double *omega, *kappa, *g; /* [n] of the phase; g of the contact */
    double rest;                     /* of the gap coordinate */
    bool closed;      /* a face of the contact is: only that one counts, the other way round */
    int upper, lower; /* faces, -1 if none */
    double gap;       /* > 0 */
    bool mirrored; /* the orbit goes on with the mirror image of the chain: what comes to one side
                      comes to the other */
    double D3, D4, tau;
    double D1;   /* of a flight that lasts no time: the terms of s' there, added up */
    double blur; /* a gap coordinate below it is no motion: terms of the modes that cancel, to
                    rounding */
    bool own_start, own_end; /* the flight starts or ends on this contact */
    double bend_start,
        bend_end; /* |s''| at a mirror point of rest, where s' = 0 exactly; 0 elsewhere */
    /* outcome */
    double best, threshold;
    ric_touch *touches; /* NULL: only the best is wanted */
    int capacity, count;
} search;

/* Adds what mode i gives, at time t, from cosine and sine of its phase. */
static inline __attribute__((always_inline)) void add_mode(const search *q, int i, double co,
                                                           double si, sample *at)
{
    const double a = q->start[i], p = q->start[q->n + i], g = q->g[i], omega = q->omega[i];
    if (!(omega > 0)) {
        at->s += g * (a + p * at->t);
        at->ds += g * p;
        return;
    }
    const double sum = g * (a * co + p * si);
    at->s += sum;
    at->ds += g * omega * (p * co - a * si);
    at->bend -= omega * omega * sum;
}

static sample sample_at(const search *q, double t)
{
    const int n = q->n;
    sample out = {t, q->rest, 0, 0};
    for (int i = 0; i < n; i += 2) {
        const int j = i + 1 < n ? i + 1 : i;
        ric_lane si, co;
        ric_sine_lanes((ric_lane){q->omega[i], q->omega[j]} * t, &si, &co);
        add_mode(q, i, co[0], si[0], &out);
        if (j > i) add_mode(q, j, co[1], si[1], &out);
    }
    return out;
}

static void offer(search *q, double t, double s, int side, bool kink)
{
    int face = q->closed  ? q->chain->model->face[q->upper].side == -side ? q->upper : -1
               : side > 0 ? q->upper
                          : q->lower;
    double value = q->closed ? 2 + side * s / q->gap : side * s / q->gap;
    if (face < 0) return;
    if (!q->touches) {
        q->best = ric_larger(q->best, value);
        return;
    }
    if (value < q->threshold) return;
    if (q->count < q->capacity) q->touches[q->count] = (ric_touch){value, q->flight, face, t, kink};
    q->count++;
}

/* A stationary point, which is a maximum on one side only: a closed face that is farthest beyond
 * the clearance does not come near to opening. Where the gap stands still it is one on both. */
static void offer_stationary(search *q, sample at)
{
    if (at.bend <= 0) offer(q, at.t, at.s, 1, false);
    if (at.bend >= 0) offer(q, at.t, at.s, -1, false);
}

/* An impact of another contact puts a kink into this gap, but not if the normals are orthogonal,
 * nor does a spring: then only a maximum that happens to fall on the impact must not be lost
 * between the flights before and after. A closed face may be left there as far as to the other side
 * of the contact. */
static void offer_impact(search *q, const ric_face *other, sample at)
{
    bool kink = other->spring == 0 &&
                !ric_model_orthogonal(q->chain->model, q->contact, other->contact);
    const int side = q->closed ? -q->chain->model->face[q->upper].side : at.s > 0 ? 1 : -1;
    const double bend = q->D3 * q->tau, slope = q->tau <= NO_TIME ? q->D1 : bend * q->tau;
    if (kink) offer(q, at.t, at.s, side, true);
    else if (fabs(at.ds) < LEVEL * slope) {
        if (fabs(at.bend) < LEVEL * bend) at.bend = 0;
        offer_stationary(q, at);
    }
}

static double largest(double a, double b, double c, double d)
{
    return ric_larger(ric_larger(a, b), ric_larger(c, d));
}

static double level(const search *q)
{
    return (q->touches ? q->threshold : q->best) * q->gap;
}

/* Whether the stationary point in the bracket, of s' that is monotone there, is below the level:
 * the gap coordinate stays under its tangent. */
static bool stays_below(const search *q, const ric_root_slope *in, sample at, int side)
{
    const double ahead = side * at.ds > 0 ? in->high - at.t : at.t - in->low, top = level(q);
    return side * at.s + fabs(at.ds) * ahead + q->blur < top - BELOW * fabs(top);
}

/* Where the slope of the cubic through l and r vanishes between them, in which s' changes its sign,
 * by its Bernstein coefficients; on short intervals the one in the middle cancels, and the chord of
 * s' is left. */
static double stationary_of_cubic(sample l, sample r)
{
    const double h = r.t - l.t, middle = 3 * (r.s - l.s) / h - l.ds - r.ds,
                 a = l.ds - 2 * middle + r.ds, b = 2 * (middle - l.ds),
                 root = sqrt(ric_larger(0, b * b - 4 * a * l.ds)),
                 y = 2 * l.ds / (-b + copysign(root, l.ds));
    return l.t + h * (y > 0 && y < 1 ? y : l.ds / (l.ds - r.ds));
}

/* The step of Newton's method at which the value is known. */
static double least_step(const search *q)
{
    return ric_smaller(COARSE * q->tau,
                       ric_larger(STATIONARY * q->tau, cbrt(MET * q->gap / q->D3)));
}

/* A single sign change of the slope between l and r, and the value there, unless it is below the
 * level; `monotone`: so is the slope. After a step of STATIONARY Newton's method is at the last
 * digit of the time; what the last step adds to the value is half of it times s'. */
static void polish(search *q, sample l, sample r, bool monotone)
{
    bool maximum = l.ds > 0;
    const bool below = monotone && !q->closed;
    ric_root_slope root = ric_root_slope_between(l.t, r.t, !maximum, stationary_of_cubic(l, r));
    root.least = q->touches ? STATIONARY * q->tau : least_step(q);
    sample mid = l;
    do {
        mid = sample_at(q, root.x);
        if (below && stays_below(q, &root, mid, maximum ? 1 : -1)) return;
    } while (ric_root_slope_next(&root, mid.ds, mid.bend));
    mid.s += mid.ds * (root.x - mid.t) / 2;
    mid.t = root.x;
    /* a stationary point at the very end of the flight is the impact there, at no speed */
    if ((q->own_start && mid.t < CLOSE * q->tau) || (q->own_end && q->tau - mid.t < CLOSE * q->tau))
        return;
    offer(q, mid.t, mid.s, maximum ? 1 : -1, false);
}

/* The largest of four values of s on the scale of the level: towards the faces that count. */
static double towards(const search *q, double a, double b, double c, double d)
{
    double reach = -HUGE_VAL;
    if (q->closed) {
        int side = q->chain->model->face[q->upper].side;
        return 2 * q->gap + largest(-side * a, -side * b, -side * c, -side * d);
    }
    if (q->upper >= 0) reach = largest(a, b, c, d);
    if (q->lower >= 0) reach = ric_larger(reach, largest(-a, -b, -c, -d));
    return reach;
}

/* Whether [l, r] can hold a stationary point above the level; *single when it holds exactly one
 * sign change of the slope. */
static bool undecided(const search *q, sample l, sample r, bool *single)
{
    double h = r.t - l.t, slope = 3 * (r.s - l.s) / h - l.ds - r.ds, error = q->D4 * h * h * h;
    const double least = ric_smaller(l.ds, r.ds), most = ric_larger(l.ds, r.ds);
    const double low = ric_smaller(least, slope), high = ric_larger(most, slope);
    *single = false;
    if (low > error * SLOPE_BOUND || high < -error * SLOPE_BOUND) return false;
    /* on short intervals the cubic's middle slope is a difference that cancels; the chord of s'
     * itself is off by D3 h^2 / 8 only */
    double chord = q->D3 * h * h / 8;
    if (least > chord || most < -chord) return false;
    /* beside a point of rest s' grows from zero as long as s'' keeps its sign */
    if ((l.t == 0 && q->bend_start > q->D3 * h) || (r.t == q->tau && q->bend_end > q->D3 * h))
        return false;
    double b1 = l.s + h * l.ds / 3, b2 = r.s - h * r.ds / 3, value = error * h / 384;
    const double farthest = towards(q, l.s, b1, b2, r.s) + value;
    if (farthest <= level(q) * (1 + BERNSTEIN) || (!q->closed && farthest <= q->blur)) return false;
    /* slope monotone on the interval: second differences of its Bernstein coefficients beyond the
     * error of s'' (D4 h^2 / 12) */
    double d1 = slope - l.ds, d2 = r.ds - slope, bend = error / 12;
    *single = l.ds * r.ds < 0 && ((d1 > bend && d2 > bend) || (d1 < -bend && d2 < -bend));
    return true;
}

/* Whether a gap stands still on [l, r], to rounding: where it touches with its velocity and its
 * acceleration, as that of a mass which is met by no force while another one strikes, the sign of
 * its slope is rounding for a while, and each half would show stationary points. */
static bool is_still(const search *q, sample l, sample r)
{
    const double h = r.t - l.t, slope = ric_larger(fabs(l.ds), fabs(r.ds));
    return (slope + q->D3 * h * h / 8) * h <= q->blur;
}

/* Interval after interval in order of time: one that is halved goes on with its left half, and the
 * ends of what waits are those of the intervals behind it. */
static inline __attribute__((always_inline)) void search_flight(search *q, sample l, sample r)
{
    sample ends[LEVELS];
    int waiting = 0;
    for (;;) {
        bool single = false, open = r.t > l.t && undecided(q, l, r, &single);
        const bool close = r.t - l.t < CLOSE * q->tau;
        if (close && ((q->own_start && l.t == 0) || (q->own_end && r.t == q->tau))) open = false;
        if (open && !single && waiting < LEVELS && !(r.t - l.t < NARROWEST * q->tau) &&
            !is_still(q, l, r)) {
            if (ric_halt(32 * q->n)) return;
            ends[waiting++] = r;
            r = sample_at(q, (l.t + r.t) / 2);
            if (r.ds == 0) offer_stationary(q, r);
            continue;
        }
        if (open && l.ds * r.ds < 0) polish(q, l, r, single);
        if (waiting == 0) return;
        l = r;
        r = ends[--waiting];
    }
}

/* Whether the bounds bound anything: numbers that overflow decide no interval, and all of them
 * would be halved. */
static bool is_bounded(const search *q, sample l, sample r)
{
    double sum = fabs(l.s) + fabs(r.s) + q->tau * (fabs(l.ds) + fabs(r.ds)) +
                 q->D4 * (q->tau * q->tau) * (q->tau * q->tau);
    return isfinite(sum);
}

/* The gap coordinate of the contact in the phase of the flight. */
static void enter_contact(search *q)
{
    const double *all = q->phase ? q->phase->G : q->chain->model->g;
    q->g = all + q->contact * q->n;
    q->rest = q->phase ? q->phase->rest[q->contact] : 0;
}

/* The gap coordinate of the contact, with the samples of both ends of the flight and the bounds of
 * its derivatives. Returns that of the second one. */
static inline __attribute__((always_inline)) double bound_contact(search *q, sample *l, sample *r)
{
    const int n = q->n;
    enter_contact(q);
    const double *w = q->start, *e = q->end, *g = q->g;
    double D2 = 0;
    *l = (sample){0, q->rest, 0, 0};
    *r = (sample){q->tau, q->rest, 0, 0};
    q->D3 = q->D4 = q->bend_start = q->bend_end = q->blur = 0;
    for (int i = 0; i < n; i++) {
        double omega = q->omega[i];
        q->blur += BLUR * fabs(g[i]) * sqrt(w[i] * w[i] + w[n + i] * w[n + i]);
        l->s += g[i] * w[i];
        r->s += g[i] * e[i];
        l->ds += g[i] * q->kappa[i] * w[n + i];
        r->ds += g[i] * q->kappa[i] * e[n + i];
        l->bend -= omega * omega * (g[i] * w[i]);
        r->bend -= omega * omega * (g[i] * e[i]);
        double second = omega > 0
                            ? fabs(g[i]) * sqrt(w[i] * w[i] + w[n + i] * w[n + i]) * omega * omega
                            : 0;
        D2 += second;
        q->D3 += second * omega;
        q->D4 += second * omega * omega;
    }
    return D2;
}

static void search_contact(search *q)
{
    const ric_shooting *c = q->chain;
    const ric_model *m = c->model;
    const int k = q->flight, last = c->n_flight - 1;
    sample l, r;
    const double D2 = bound_contact(q, &l, &r);
    if (!is_bounded(q, l, r)) {
        q->best = HUGE_VAL;
        return;
    }
    int f0 = c->face[k], f1 = c->face[k + 1];
    q->own_start = f0 >= 0 && m->face[f0].contact == q->contact;
    q->own_end = f1 >= 0 && m->face[f1].contact == q->contact;
    /* the gap of a loose mass at rest stands still, and no interval shows a maximum */
    if (D2 == 0 && l.ds == 0) {
        if (!q->own_start && !q->own_end) offer_stationary(q, l);
        return;
    }
    /* between two events of one face the gap leaves it by no more than D2 tau^2 / 8; what rounding
     * hides is no arc */
    if (q->own_start && f0 == f1 && D2 * q->tau * q->tau < 8 * q->blur) return;
    /* at rest every gap is stationary */
    if (k == 0 && c->start == RIC_MIRROR_REST) {
        offer_stationary(q, l);
        q->bend_start = fabs(l.bend);
        l.ds = 0;
    }
    const bool rests = k == last && c->end == RIC_MIRROR_REST;
    if (rests) {
        q->bend_end = fabs(r.bend);
        r.ds = 0;
    }
    /* between two events at one instant a gap moves by less than rounding, and no interval decides
     * whether it has a maximum: the flights beside it tell */
    const bool still = fabs(l.ds) * q->tau + D2 * q->tau * q->tau / 2 <= q->blur;
    if (!still || q->tau > INSTANT) search_flight(q, l, r);
    if (rests) offer_stationary(q, r);
    /* the start of the chain counts for the end in the general form */
    if (k == 0 && c->start == RIC_MIRROR_IMPACT && f0 >= 0 && !q->own_start)
        offer_impact(q, &m->face[f0], l);
    if (f1 >= 0 && !q->own_end) offer_impact(q, &m->face[f1], r);
}

/* The ends of the present flight in coordinates of its phase; false where it has none. */
static bool enter_flight(search *q)
{
    const ric_shooting *c = q->chain;
    const ric_model *m = c->model;
    int n = q->n, k = q->flight;
    memcpy(q->start, c->w + 2 * n * k, 2 * (size_t)n * sizeof *q->start);
    memcpy(q->end, c->w + 2 * n * (k + 1), (size_t)n * sizeof *q->end);
    memcpy(q->end + n, c->before + n * k, (size_t)n * sizeof *q->end);
    q->phase = NULL;
    q->omega = m->omega;
    q->kappa = m->kappa;
    if (!c->closed[k]) return true;
    if (ric_regime_get(m, c->closed[k], &q->phase)) return false;
    q->omega = q->phase->omega;
    q->kappa = q->phase->kappa;
    ric_regime_enter(q->phase, q->start, q->start);
    ric_regime_enter(q->phase, q->end, q->end);
    return true;
}

/* The faces of a contact that count, the first of them `first`. */
static void choose_faces(search *q, int first)
{
    const ric_face *face = &q->chain->model->face[first];
    uint64_t closed = q->chain->closed[q->flight];
    q->contact = face->contact;
    q->gap = fabs(face->gap);
    int other = q->mirrored && face->mirror < 0 ? first : face->mirror;
    q->upper = face->side > 0 ? first : other;
    q->lower = face->side < 0 ? first : other;
    q->closed = false;
    for (int f = first; closed && f >= 0 && !q->closed; f = f == first ? face->mirror : -1)
        if (ric_face_in(closed, f)) {
            q->closed = true;
            q->upper = q->lower = f;
        }
}

/* At rest in the middle of a contact, or of a gap between two, that lasts no time the gaps of all
 * others are stationary, and neither flight beside it has that point inside. */
static void search_rest(search *q)
{
    const ric_shooting *c = q->chain;
    const ric_model *m = c->model;
    int k = q->flight, last = c->n_flight - 1;
    bool first = k == 0 && c->start == RIC_MIRROR_REST;
    if (!ric_shooting_touches(c, k) || fabs(q->tau) >= NO_TIME) return;
    if (!first && (k != last || c->end != RIC_MIRROR_REST)) return;
    if (!enter_flight(q)) {
        q->best = HUGE_VAL;
        return;
    }
    int own = m->face[c->face[first ? 1 : k]].contact;
    for (int f = 0; f < m->n_face; f += m->face[f].mirror >= 0 ? 2 : 1) {
        choose_faces(q, f);
        enter_contact(q);
        if (q->contact != own) offer_stationary(q, sample_at(q, first ? 0 : q->tau));
    }
}

/* The gap of one contact at an end of a flight that lasts no time. */
static void offer_end(search *q, const ric_face *impact, bool start)
{
    const double *w = start ? q->start : q->end;
    sample at = {start ? 0 : q->tau, q->rest, 0, 0};
    q->D1 = 0;
    for (int i = 0; i < q->n; i++) {
        const double slope = q->g[i] * q->kappa[i] * w[q->n + i];
        at.s += q->g[i] * w[i];
        at.ds += slope;
        at.bend -= q->omega[i] * q->omega[i] * q->g[i] * w[i];
        q->D1 += fabs(slope);
    }
    offer_impact(q, impact, at);
}

/* Where a spring closes or opens at the impact on a stop, or stops are met together, the flight
 * between the two lasts no time and is not searched: what other gaps do at the impact would be
 * lost, as an impact counts for the flight that ends there. */
static void search_no_time(search *q)
{
    const ric_shooting *c = q->chain;
    const ric_model *m = c->model;
    const int k = q->flight;
    const ric_face *begin = c->face[k] >= 0 ? &m->face[c->face[k]] : NULL;
    const ric_face *end = c->face[k + 1] >= 0 ? &m->face[c->face[k + 1]] : NULL;
    const bool at_start = k == 0 && c->start == RIC_MIRROR_IMPACT && begin && begin->spring == 0;
    const bool at_end = end && end->spring == 0;
    if (!(fabs(q->tau) < NO_TIME) || (!at_start && !at_end) || !enter_flight(q)) return;
    for (int f = 0; f < m->n_face; f += m->face[f].mirror >= 0 ? 2 : 1) {
        choose_faces(q, f);
        enter_contact(q);
        if ((begin && begin->contact == q->contact) || (end && end->contact == q->contact))
            continue;
        if (at_start) offer_end(q, begin, true);
        if (at_end) offer_end(q, end, false);
    }
}

static void search_all(search *q, const double *u)
{
    const ric_shooting *c = q->chain;
    const ric_model *m = c->model;
    const bool springs = ric_flight_law_of(m)->closes;
    double ends[4 * q->n];
    q->start = ends;
    q->end = ends + 2 * q->n;
    for (q->flight = 0; q->flight < c->n_flight; q->flight++) {
        q->tau = u[c->n_start + q->flight];
        if (isnan(q->tau)) q->best = HUGE_VAL;
        if (springs) search_rest(q);
        if (springs || !(q->tau > 0)) search_no_time(q);
        if (!(q->tau > 0) || (springs && q->tau < NO_TIME)) continue;
        if (!enter_flight(q)) {
            q->best = HUGE_VAL;
            continue;
        }
        for (int f = 0; f < m->n_face;) {
            const ric_face *face = &m->face[f];
            choose_faces(q, f);
            search_contact(q);
            f += face->mirror >= 0 ? 2 : 1;
        }
    }
}

static bool shows_image(const ric_shooting *c)
{
    return ric_shooting_halves(c) || c->start == RIC_MIRROR_CENTRE;
}

double ric_reach(const ric_shooting *chain, const double *u, ric_touch *where)
{
    search q = {.chain = chain, .n = chain->n, .mirrored = shows_image(chain)};
    if (!ric_model_detached(chain->model)) { /* nothing to touch */
        if (where) where->face = -1;
        return 0;
    }
    search_all(&q, u);
    if (where) {
        where->face = -1;
        if (q.best > 0) ric_reach_all(chain, u, q.best * (1 - ITSELF), 1, where);
    }
    return q.best;
}

int ric_reach_all(const ric_shooting *chain, const double *u, double threshold, int capacity,
                  ric_touch *touches)
{
    search q = {.chain = chain,
                .n = chain->n,
                .mirrored = shows_image(chain),
                .threshold = threshold,
                .capacity = capacity,
                .touches = touches};
    if (!ric_model_detached(chain->model)) return 0;
    search_all(&q, u);
    return q.count;
}
