/* Leaps over tongues (docs/theory.md section 12). Beside an internal resonance with mode k, omega_k
 * T = 2 pi m, the share of the mode in the motion is R / sin(pi (nu - m)), where nu = omega_k T / 2
 * pi counts its turns and R hardly changes: it changes its sign and nothing else does. A tongue is
 * what lies between the two places where that share has a given size. Both are orbits with given
 * periods, solved like any other; the one behind is looked for from the one before, with the sign
 * of the mode changed, and counts if the way back leads to the same orbit. */
#include "leap.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "event.h"
#include "orbit/room.h"
#include "symmetric_end.h"

/* At the border of a tongue the mode has this share of the energy, as a root, or of the clearance
 * of a face: the energy of the branch is off by two hundredths from what it is without the mode, at
 * most. */
#define OF_ENERGY 0.1
#define OF_CLEARANCE 0.01
#define HELD 2   /* times that, where the border was placed from farther away */
#define CLIMBS 3 /* times that, from which on a branch is on a tongue */
/* LEAST: turns: half the width of the narrowest gap; a resonance is where it is said to be up to
 * some of that, for while springs are closed the frequency of a mode is another one */
#define LEAST 2e-3
#define WIDEST 0.2     /* turns: half the width of tongues that are one by one */
#define EXCITED 1e-12  /* share below which a mode does not take part at all: there is no tongue */
#define ON_BORDER 1e-9 /* relative: of a period */
/* NEARER: of the distance to a resonance at which a leap was refused: from there it is tried again.
 * Beside the first touch of a spring the share of a mode is next to nothing and grows, so that it
 * cannot be told beforehand */
#define NEARER 0.7
/* MOVED: of the size: what modes that are not in resonance may change over a tongue */
#define MOVED 0.05
#define RETURNS 1e-8   /* of the size: the way back leads to the same orbit */
enum { ATTEMPTS = 4 }; /* at a border behind, ever farther away */
/* AWAY: of the width, the first step behind a tongue */
#define AWAY 0.2

/* ------------------------------------------------------------------- phases */

static double frequency_of(const ric_model *m, uint64_t closed, int mode)
{
    const ric_regime *phase;
    return closed && !ric_regime_get(m, closed, &phase) ? phase->omega[mode] : m->omega[mode];
}

/* Turns of a mode in a period, or of a direction t of the unknowns: how they change along it. */
static double turns_of(const ric_shooting *c, const double *u, int mode)
{
    double sum = 0;
    for (int k = 0; k < c->n_flight; k++)
        sum += frequency_of(c->model, c->closed[k], mode) * u[c->n_start + k];
    return c->multiple * sum / RIC_TWO_PI;
}

/* Share of a mode in the motion at the last flight, over that at a border. */
static double share_of(const ric_shooting *c, int mode)
{
    const ric_model *m = c->model;
    double most = 0, reach = 0;
    for (int k = 0; k <= c->n_flight; k++) {
        const double *w = c->w + (size_t)k * 2 * (size_t)c->n;
        most = fmax(most, w[mode] * w[mode] + w[c->n + mode] * w[c->n + mode]);
    }
    for (int f = 0; f < m->n_face; f++)
        reach = fmax(reach, fabs(m->face[f].g[mode] / m->face[f].gap));
    const double energy = 2 * ric_shooting_energy(c) + DBL_MIN;
    return sqrt(most) * fmax(reach / OF_CLEARANCE, 1 / (sqrt(energy) * OF_ENERGY));
}

/* ------------------------------------------------------------------ tongues */

/* Of mode `mode` in front of an orbit, in turns and in periods; on the near and on the far side. */
typedef struct {
    int mode;
    double turns, border[2], period[2];
} tongue;

/* A half chain repeats itself with the other sign half a period on, and meets odd resonances only.
 */
static double next_turns(const ric_shooting *c, double turns, double way)
{
    double step = ric_shooting_halves(c) ? 2 : 1, first = ric_shooting_halves(c) ? 1 : 0;
    double place = (turns - first) / step;
    return first + step * (way > 0 ? floor(place) + 1 : ceil(place) - 1);
}

/* sin of the phase by which a mode is off its resonance. */
static double off(const ric_shooting *c, double turns)
{
    return fabs(sin(RIC_TWO_PI / 2 * turns / (ric_shooting_halves(c) ? 2 : 1)));
}

/* The distance in turns at which a mode has the share 1, from that at one distance. */
static double half_width(const ric_shooting *c, double share, double distance)
{
    double part = share * off(c, distance), half = ric_shooting_halves(c) ? 2 : 1;
    return part < 1 ? fmax(LEAST, half * 2 * asin(part) / RIC_TWO_PI) : HUGE_VAL;
}

/* The next tongue of a mode in the direction t (way: its sign in turns) from an orbit at u that has
 * just been flown; false: there is none that may be stepped over. */
static bool tongue_ahead(const ric_continuation *tr, const double *u, const double *t, int mode,
                         tongue *out)
{
    const ric_shooting *c = tr->chain;
    const double slope = turns_of(c, t, mode), now = turns_of(c, u, mode),
                 share = share_of(c, mode);
    double rate = 0, period = ric_shooting_time(c, u);
    for (int k = c->n_start; k < c->n_start + c->n_flight; k++) rate += c->multiple * t[k];
    if (slope == 0 || rate == 0 || share < EXCITED || share > HELD || c->model->omega[mode] <= 0)
        return false;
    const double turns = next_turns(c, now, slope), width = half_width(c, share, turns - now);
    if (turns < 2 || width > WIDEST || 2 * width > tr->limits->tongue_width * turns) return false;
    *out = (tongue){.mode = mode, .turns = turns};
    for (int i = 0; i < 2; i++) {
        out->border[i] = turns + ((slope > 0) == (i > 0) ? width : -width);
        out->period[i] = period + (out->border[i] - now) * rate / slope;
    }
    return true;
}

/* Tongues that overlap are stepped over together. */
typedef struct {
    int n;
    double period[2];
    tongue *widest;
    tongue *of; /* [n modes] */
} cluster;

/* The first tongue in front of u, and all that overlap with it; n = 0: none. `list` [n modes] is
 * room for them. */
static cluster cluster_ahead(const ric_continuation *tr, const double *u, const double *t,
                             tongue *list)
{
    cluster all = {.of = list};
    int n = 0, first = -1;
    for (int k = 0; k < tr->chain->n; k++) n += tongue_ahead(tr, u, t, k, &list[n]);
    const double here = ric_shooting_time(tr->chain, u);
    for (int i = 0; i < n; i++) {
        const double place = list[i].period[0] + (list[i].period[1] - list[i].period[0]) / 2;
        const bool refused = (place - tr->refused[0]) * (place - tr->refused[1]) <= 0,
                   nearer = fabs(here - place) < NEARER * fabs(tr->refused[0] - place);
        if (refused && !nearer) list[i] = list[--n], i--;
    }
    for (int i = 0; i < n; i++)
        if (first < 0 || fabs(list[i].period[0] - here) < fabs(list[first].period[0] - here))
            first = i;
    if (first < 0) return all;
    tongue swap = list[0];
    list[0] = list[first];
    list[first] = swap;
    all.n = 1;
    memcpy(all.period, list[0].period, sizeof all.period);
    const double way = all.period[1] > all.period[0] ? 1 : -1;
    for (int i = 1; i < n; i++) {
        if (way * (list[i].period[0] - all.period[1]) > 0) continue;
        if (way * (list[i].period[1] - all.period[1]) > 0) all.period[1] = list[i].period[1];
        swap = list[all.n];
        list[all.n++] = list[i];
        list[i] = swap;
        i = all.n - 1; /* a longer one may reach others */
    }
    all.widest = list;
    for (int i = 1; i < all.n; i++)
        if (fabs(list[i].period[1] - list[i].period[0]) >
            fabs(all.widest->period[1] - all.widest->period[0]))
            all.widest = &list[i];
    return all;
}

/* ----------------------------------------------------------- given periods */

/* Newton from u to the orbit of a period. */
static bool solve_period(ric_continuation *tr, double period, double *u)
{
    ric_shooting *c = tr->chain;
    int iterations;
    double normal[c->n_unknown], origin[c->n_unknown];
    for (int i = 0; i < c->n_unknown; i++)
        normal[i] = i >= c->n_start && i < c->n_start + c->n_flight ? c->multiple : 0;
    memcpy(origin, u, sizeof origin);
    const double target = period - ric_shooting_time(c, u);
    const bool good = ric_continuation_correct(c, u, origin, normal, target, tr->du, &iterations);
    tr->evaluations += iterations + 1;
    return good && ric_continuation_solved(c);
}

static bool at_border(const ric_continuation *tr, double period)
{
    return tr->leap_at > 0 && fabs(period / tr->leap_at - 1) <= ON_BORDER;
}

bool ric_leap_ahead(ric_continuation *tr, double h, double *shorter)
{
    ric_shooting *c = tr->chain;
    const double from = ric_shooting_time(c, tr->now.u), to = ric_shooting_time(c, tr->next.u);
    tongue list[c->n];
    double u[c->n_unknown], along = 0;
    if (tr->limits->tongue_width <= 0 || tr->n_point < 2 || at_border(tr, to)) return false;
    tr->leap_at = 0;
    ric_shooting_fly(c, tr->now.u);
    const cluster all = cluster_ahead(tr, tr->now.u, tr->now.t, list);
    bool enters = all.n > 0 && (to - from) * (all.period[0] - from) > 0 &&
                  fabs(to - from) > fabs(all.period[0] - from);
    /* a resonance so near that its border lies behind: from here */
    const bool inside = all.n > 0 && (all.period[1] - from) * (all.period[0] - from) <= 0;
    if (inside) {
        tr->leap_at = from;
        *shorter = 0;
        return true;
    }
    if (enters) {
        const double part = (all.period[0] - from) / (to - from);
        for (int i = 0; i < c->n_unknown; i++)
            u[i] = tr->now.u[i] + part * (tr->next.u[i] - tr->now.u[i]);
        enters = solve_period(tr, all.period[0], u);
        for (int i = 0; i < c->n_unknown; i++) along += (u[i] - tr->now.u[i]) * tr->now.t[i];
        enters = enters && along > 0 && along < h;
    }
    if (enters) {
        tr->leap_at = all.period[0];
        *shorter = along;
    } else ric_shooting_evaluate(c, tr->next.u);
    return enters;
}

/* --------------------------------------------------------------------- leap */

/* An orbit of another period with what resonates turned round: in *u [n_unknown] the one before,
 * and the one found. */
static bool cross(ric_continuation *tr, const cluster *all, double period, double *u)
{
    const ric_shooting *c = tr->chain;
    const double factor = period / ric_shooting_time(c, u);
    for (int i = 0; i < all->n; i++) {
        u[all->of[i].mode] = -u[all->of[i].mode];
        if (c->start == RIC_MIRROR_NONE) u[c->n + all->of[i].mode] = -u[c->n + all->of[i].mode];
    }
    for (int k = c->n_start; k < c->n_start + c->n_flight; k++) u[k] *= factor;
    return solve_period(tr, period, u);
}

static double distance_of(const ric_shooting *c, const cluster *but, const double *a,
                          const double *b)
{
    double sum = 0;
    for (int i = 0; i < c->n_unknown; i++) {
        bool resonates = false;
        const int mode = i < c->n_start ? i % c->n : -1;
        for (int j = 0; but && j < but->n; j++) resonates |= mode == but->of[j].mode;
        if (!resonates) sum = fmax(sum, fabs(a[i] - b[i]));
    }
    return sum / c->scale;
}

/* From the orbit at `from` over the tongues to u; *period is where that is, and moves on where a
 * mode still has more than its share. False: no leap that is beyond doubt. */
static bool leap(ric_continuation *tr, const cluster *all, const double *from, double *period,
                 double *u)
{
    ric_shooting *c = tr->chain;
    const double start = ric_shooting_time(c, from);
    double back[c->n_unknown];
    bool good = false;
    for (int k = 0; k < ATTEMPTS && !good; k++) {
        double most = 0;
        memcpy(u, from, (size_t)c->n_unknown * sizeof *u);
        if (!cross(tr, all, *period, u)) return false;
        for (int i = 0; i < all->n; i++) most = fmax(most, share_of(c, all->of[i].mode));
        good = most <= HELD;
        if (!good) *period += (*period - start) * fmin(1, most - 1);
        if (fmax(*period / start, start / *period) - 1 > tr->limits->tongue_width) return false;
    }
    if (!good || distance_of(c, all, from, u) > MOVED) return false;
    memcpy(back, u, sizeof back);
    return cross(tr, all, start, back) && distance_of(c, NULL, from, back) < RETURNS;
}

static bool admissible(const ric_continuation *tr, const ric_station *p)
{
    static const int margins[] = {RIC_TEST_REACH, RIC_TEST_APPROACH, RIC_TEST_FLIGHT,
                                  RIC_TEST_E_MAX, RIC_TEST_E_MIN,    RIC_TEST_F_MAX,
                                  RIC_TEST_F_MIN};
    for (size_t i = 0; i < sizeof margins / sizeof *margins; i++)
        if (!(p->test[margins[i]] > 0)) return false;
    return p->solved && !(tr->may_gain && ric_symmetric_end_gains(tr->chain, p->u));
}

static ric_status note_gap(ric_continuation *tr, const cluster *all)
{
    ric_leap *gaps = ric_realloc(tr->gaps, ((size_t)tr->n_gap + 1) * sizeof *gaps);
    if (!gaps) return ric_no_memory("a gap of a branch");
    tr->gaps = gaps;
    gaps[tr->n_gap++] = (ric_leap){.point = tr->n_point - 1,
                                   .mode = tr->chain->model->mode[all->widest->mode] + 1,
                                   .turns = (int32_t)all->widest->turns,
                                   .others = all->n - 1};
    return RIC_OK;
}

/* `next` behind the tongue, with the direction in which the period goes on. */
static ric_status arrive(ric_continuation *tr, const double *u, double way)
{
    ric_shooting *c = tr->chain;
    ric_station *p = &tr->next;
    double rate = 0, length = 0, orientation = 1;
    memcpy(p->u, u, (size_t)c->n_unknown * sizeof *u);
    ric_shooting_evaluate(c, p->u);
    ric_continuation_tangent(c, NULL, p->t);
    for (int k = c->n_start; k < c->n_start + c->n_flight; k++) rate += p->t[k];
    if (rate * way < 0) {
        orientation = -1;
        for (int i = 0; i < c->n_unknown; i++) p->t[i] = -p->t[i];
    }
    for (int i = 0; i < c->n_unknown; i++) length += (u[i] - tr->now.u[i]) * (u[i] - tr->now.u[i]);
    p->s = tr->now.s + sqrt(length);
    return ric_continuation_look(tr, p, orientation, RIC_LOOK_ALL);
}

/* Behind the tongue everything begins anew: what is watched is not followed through it. */
static ric_status land(ric_continuation *tr, const cluster *all, double width)
{
    const ric_shooting *c = tr->chain;
    const int before = tr->n_point;
    double rate = 0;
    ric_status status = note_gap(tr, all);
    if (!status)
        status = ric_trust(
            ric_continuation_keep(tr, &tr->next)); /* a stop leaves the stations as they are */
    if (status || tr->n_point == before) {
        tr->n_gap -= !status;
        return status;
    }
    const ric_station old = tr->past;
    tr->past = tr->now;
    tr->now = tr->next;
    tr->next = old;
    tr->has_past = false;
    tr->avoided = false;
    tr->samples.n_past = 0;
    memcpy(tr->definite, tr->now.test, sizeof tr->definite);
    memset(tr->passed, 0, (size_t)tr->n_resonance * sizeof *tr->passed);
    ric_continuation_remember(tr, &tr->now);
    for (int k = c->n_start; k < c->n_start + c->n_flight; k++) rate += c->multiple * tr->now.t[k];
    tr->step = fmin(tr->step, AWAY * width / fabs(rate));
    return RIC_OK;
}

ric_status ric_leap_try(ric_continuation *tr, bool *over)
{
    ric_shooting *c = tr->chain;
    const double here = ric_shooting_time(c, tr->now.u);
    tongue list[c->n];
    double u[c->n_unknown];
    *over = false;
    if (tr->leap_at <= 0) return RIC_OK;
    const bool there = at_border(tr, here);
    tr->leap_at = 0;
    const ric_point *last = ric_continuation_row(tr, tr->n_point - 1);
    if (!there || last->arclength != tr->now.row.arclength) return RIC_OK;
    ric_shooting_fly(c, tr->now.u);
    const cluster all = cluster_ahead(tr, tr->now.u, tr->now.t, list);
    if (all.n == 0) return RIC_OK;
    double period = all.period[1];
    if (leap(tr, &all, tr->now.u, &period, u)) {
        ric_status status = arrive(tr, u, period - here);
        if (status) return status;
        const int before = tr->n_point;
        if (admissible(tr, &tr->next) && (status = land(tr, &all, fabs(period - here))))
            return status;
        *over = tr->n_point > before;
    }
    if (!*over) {
        tr->refused[0] = here;
        tr->refused[1] = period;
    }
    return RIC_OK;
}

bool ric_leap_behind(const ric_continuation *tr, int i)
{
    for (int k = 0; k < tr->n_gap; k++)
        if (tr->gaps[k].point == i) return true;
    return false;
}

/* -------------------------------------------------------------------- leaving */

/* The tongue behind an orbit that comes out of it, seen from where the branch passes. */
static bool passed_over(ric_continuation *tr, int mode, double turns)
{
    ric_shooting *c = tr->chain;
    double back[c->n_unknown], u[c->n_unknown];
    tongue behind;
    for (int i = 0; i < c->n_unknown; i++) back[i] = -tr->next.t[i];
    ric_shooting_fly(c, tr->next.u);
    bool good = tongue_ahead(tr, tr->next.u, back, mode, &behind) && behind.turns == turns;
    cluster all = {.n = 1, .of = &behind, .widest = &behind};
    double period = behind.period[1];
    good = good && leap(tr, &all, tr->next.u, &period, u);
    ric_shooting_evaluate(c, tr->next.u);
    return good;
}

ric_status ric_leap_leave(ric_continuation *tr, bool *done)
{
    ric_shooting *c = tr->chain;
    *done = false;
    if (tr->limits->tongue_width <= 0) return RIC_OK;
    ric_shooting_fly(c, tr->next.u);
    for (int k = 0; k < c->n && tr->on_mode == 0; k++) {
        const double now = turns_of(c, tr->next.u, k), ahead = next_turns(c, now, 1),
                     behind = next_turns(c, now, -1),
                     turns = ahead - now < now - behind ? ahead : behind;
        if (c->model->omega[k] <= 0 || turns < 2 || fabs(turns - now) > WIDEST ||
            share_of(c, k) < CLIMBS)
            continue;
        if (2 * fabs(turns - now) > tr->limits->tongue_width * turns) continue;
        tr->on_mode = k + 1;
        tr->on_turns = (int32_t)turns;
    }
    if (tr->on_mode == 0 || share_of(c, tr->on_mode - 1) > 1) return RIC_OK;
    const bool over = passed_over(tr, tr->on_mode - 1, tr->on_turns);
    tr->on_mode = 0;
    if (!over) return RIC_OK;
    *done = true;
    return ric_event_border(tr, &tr->next);
}
