#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "hunt_line.h"
#include "base/room.h"

/* Orbits that are their own image in time: from one mirror point to the next (docs/theory.md
 * sections 4 and 11).
 *
 * A line of motions starts at mirror points of one kind. Mapped forward, it is looked at wherever
 * it could be at a mirror point again:
 *     at an impact                 angle = 0
 *     at rest in a flight          that leaves and meets one face: y' = y, angle' = -angle
 *     in the centre in a flight    from a face to the one on the other side: y' = -y, angle' =
 *                                  angle
 * A change of sign between two neighbours that stay together is a half of an orbit, or a quarter.
 */

#define APART 0.03
#define SHORTEST 1e-15
/* CLOSE: of the distance of two neighbours: as near as this Newton's method takes over */
#define CLOSE 1e-9
/* LONGEST: of the longest period asked for: Newton's method may shorten an orbit by so much */
#define LONGEST 1.01

typedef enum { IMPACT, REST, CENTRE } mirror_kind;

typedef double (*test)(const ric_strand *a, int j);

static bool start_impact(const ric_line *l, double x, ric_hit *hit, double *w)
{
    *hit = (ric_hit){l->face, x, 0, 0};
    return ric_impact_map_state(l->hunt->section, hit, w) &&
           ric_impact_map_inside(l->hunt->section, w, l->face);
}

/* On V = E: an ellipse, or two straight lines, one after the other, if a mode is free. */
static bool start_rest(const ric_line *l, double x, ric_hit *hit, double *w)
{
    const ric_impact_map *s = l->hunt->section;
    double speed = sqrt(2 * s->energy), span = l->high / 2;
    (void)hit;
    w[0] = s->omega[0] > 0 ? speed / s->omega[0] * cos(x) : 2 * (x < span ? x : x - span) - span;
    w[1] = s->omega[0] > 0 ? speed / s->omega[1] * sin(x)
                           : (x < span ? 1 : -1) * speed / s->omega[1];
    w[2] = w[3] = 0;
    return ric_impact_map_inside(s, w, -1);
}

static bool start_centre(const ric_line *l, double x, ric_hit *hit, double *w)
{
    double speed = sqrt(2 * l->hunt->section->energy);
    (void)hit;
    w[0] = w[1] = 0;
    w[2] = speed * cos(x);
    w[3] = speed * sin(x);
    return true;
}

static mirror_kind kind_of(const ric_line *l)
{
    return l->face >= 0 ? IMPACT : l->start == start_rest ? REST : CENTRE;
}

/* ------------------------------------------------------------------- tests */

static double at_impact(const ric_strand *a, int j)
{
    return a->hit[j].angle;
}

static double at_rest(const ric_strand *a, int j)
{
    return a->hit[j].y - a->hit[j - 1].y;
}

static double turning(const ric_strand *a, int j)
{
    return a->hit[j].angle + a->hit[j - 1].angle;
}

static double across(const ric_strand *a, int j)
{
    return a->hit[j].y + a->hit[j - 1].y;
}

static double onward(const ric_strand *a, int j)
{
    return a->hit[j].angle - a->hit[j - 1].angle;
}

/* Two for a flight: one alone may have a double zero. */
static const struct {
    test value;
    mirror_kind end;
} tests[] = {{at_impact, IMPACT},
             {at_rest, REST},
             {turning, REST},
             {across, CENTRE},
             {onward, CENTRE}};

/* Whether the test makes sense at hit j: on the flight that ends there, or at the impact itself. */
static bool applies(const ric_line *l, mirror_kind end, const ric_strand *a, int j)
{
    const ric_impact_map *s = l->hunt->section;
    if (end == IMPACT) return j > 0 || l->face < 0;
    if (j == 0) return false;
    int from = a->hit[j - 1].face, to = a->hit[j].face;
    return end == REST ? from == to : to == s->face[from].mirror && ric_model_symmetric(s->model);
}

/* ----------------------------------------------------------------- unfolding */

/* The whole orbit of a half or quarter one that ends at hit j, or in the middle of the flight
 * before it. out [4 (j + 1)]. */
static int unfold(const ric_line *l, const ric_strand *a, int j, mirror_kind end, ric_hit *out)
{
    const ric_impact_map *s = l->hunt->section;
    mirror_kind start = kind_of(l);
    double when[4 * (j + 1)], turn = end == IMPACT ? a->time[j] : (a->time[j - 1] + a->time[j]) / 2,
                              period = 2 * turn;
    int n = 0, last = end == IMPACT ? j : j - 1;
    for (int i = 0; i <= last; i++) {
        when[n] = a->time[i];
        out[n++] = a->hit[i];
    }
    for (int i = end == IMPACT ? last - 1 : last; i >= (start == IMPACT ? 1 : 0); i--) {
        when[n] = 2 * turn - a->time[i];
        /* a centre turns motion round and mirrors it: the velocity changes its sign twice */
        out[n++] = end == CENTRE ? ric_impact_map_mirrored(s, ric_impact_map_reversed(a->hit[i]))
                                 : ric_impact_map_reversed(a->hit[i]);
    }
    if ((end == CENTRE) != (start == CENTRE)) {
        for (int i = 0, m = n; i < m; i++) {
            when[n] = when[i] + period;
            out[n++] = ric_impact_map_mirrored(s, out[i]);
        }
        period *= 2;
    }
    for (int i = 0; i < n; i++)
        out[i].tau = i + 1 < n ? when[i + 1] - when[i] : when[0] + period - when[i];
    return n;
}

static ric_status try_half(const ric_line *l, const ric_strand *a, int j, mirror_kind end)
{
    ric_hit orbit[4 * (j + 1)];
    int N = unfold(l, a, j, end, orbit);
    double period = 0;
    for (int k = 0; k < N; k++) {
        if (!(orbit[k].tau > 0)) return RIC_OK;
        period += orbit[k].tau;
    }
    if (N < 1 || N > l->hunt->options.impacts || period > LONGEST * l->hunt->options.period[1])
        return RIC_OK;
    return ric_hunt_try(l->hunt, N, false, orbit, RIC_WAY_MIRRORS);
}

/* ---------------------------------------------------------------- the search */

/* A change of sign between a and b: closed in on, then solved. */
static ric_status close_in(const ric_line *l, const ric_strand *a, const ric_strand *b, int j,
                           int which)
{
    RIC_STRAND(low, l->K);
    RIC_STRAND(high, l->K);
    RIC_STRAND(mid, l->K);
    ric_hunt_strand_copy(&low, a);
    ric_hunt_strand_copy(&high, b);
    double f0 = tests[which].value(a, j), f1 = tests[which].value(b, j);
    ric_root r = ric_root_between(low.s, f0, high.s, f1, CLOSE * fabs(high.s - low.s));
    while (ric_root_next(&r)) {
        ric_hunt_line_fly(l, r.x, &mid);
        for (int k = 0; k <= j; k++)
            if (!ric_hunt_line_together(l, &low, &mid, k)) return RIC_OK;
        r.f = tests[which].value(&mid, j);
        bool first = (r.f > 0) == (f0 > 0);
        ric_hunt_strand_copy(first ? &low : &high, &mid);
        if (first) f0 = r.f;
        else f1 = r.f;
    }
    return try_half(l, fabs(f0) < fabs(f1) ? &low : &high, j, tests[which].end);
}

static ric_status compare(const ric_line *l, const ric_strand *a, const ric_strand *b, int joint)
{
    ric_status status = RIC_OK;
    for (int j = 0; j < joint && !status; j++)
        for (int t = 0; t < (int)(sizeof tests / sizeof *tests) && !status; t++)
            if (applies(l, tests[t].end, a, j) && tests[t].value(a, j) * tests[t].value(b, j) <= 0)
                status = close_in(l, a, b, j, t);
    return status;
}

static ric_status scan(ric_hunt *h, bool (*start)(const ric_line *, double, ric_hit *, double *),
                       int face, double low, double high)
{
    ric_line line = {.hunt = h,
                     .low = low,
                     .high = high,
                     .face = face,
                     .K = h->options.impacts / 2 + 2,
                     .times = 2,
                     .apart = APART,
                     .shortest = SHORTEST,
                     .start = start,
                     .compare = compare};
    return ric_hunt_line_scan(&line, h->options.lines);
}

ric_status ric_hunt_mirrors(ric_hunt *h)
{
    const ric_impact_map *s = h->section;
    bool symmetric = ric_model_symmetric(s->model);
    double widest = 0, round = RIC_TWO_PI;
    ric_status status = ric_hunt_report(h, "symmetry lines", 0);
    for (int f = 0; f < s->n_face && !status; f++) {
        const ric_impact_map_face *face = &s->face[f];
        widest = fmax(widest, fabs(face->at) + face->radius[0]);
        if (face->radius[0] > 0 &&
            !(symmetric && face->side < 0)) /* the other side is its mirror image */
            status = scan(h, start_impact, f, face->middle - face->radius[0],
                          face->middle + face->radius[0]);
    }
    /* V = E has its mirror image, too: half of it will do for a symmetric structure */
    if (!status)
        status = scan(h, start_rest, -1, 0,
                      s->omega[0] == 0 ? 8 * widest
                      : symmetric      ? round / 2
                                       : round);
    if (!status && symmetric) status = scan(h, start_centre, -1, 0, round / 2);
    return status;
}
