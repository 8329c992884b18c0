/* Passages of a spring of law power through s = 0: the flow is smooth and goes in Taylor steps
 * (flow/power_flow.h). A step is a part of the radius of convergence, in which a gap coordinate
 * turns at most once: a sign that differs at its ends is a passage, and where the speed changes its
 * sign the place in between is looked at, too. */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "section_motion.h"
#include "base/room.h"

/* Longest step over 1 / omega of the fastest mode, and over that of the series: neither a gap nor
 * c(u) turns twice. */
#define STEP 0.7
#define PART_OF_PACE 0.5
/* Steps without a passage after which a motion is given up. */
#define STEPS_MOST 100000
/* A zero is found when a step of Newton's method is this part of the step that holds it. */
#define FOUND (8 * DBL_EPSILON)

/* s and ds/dt of a contact. */
static void gap_of(const ric_model *m, int contact, const double *w, double *s)
{
    s[0] = ric_dot(m->n, m->g + contact * m->n, w);
    s[1] = ric_dot(m->n, m->c + contact * m->n, w + m->n);
}

static double *flow_work(const ric_section_motion *s)
{
    double *work = s->work + 8 * s->n;
    return work + ((uintptr_t)work / sizeof *work & 1); /* a multiple of 16 bytes */
}

/* The state `after` a time t of the present step, which may be zero. */
static bool go(const ric_section_motion *s, double t, double *after)
{
    memcpy(after, s->w, 2 * (size_t)s->n * sizeof *after);
    return t == 0 || ric_power_flow_fly(s->m, t, after, 0, NULL, flow_work(s));
}

/* Zero of s (order 0) or ds/dt (order 1) of a contact between the times a and b, where it changes
 * its sign; `up`: to plus. */
static double zero_between(const ric_section_motion *s, int contact, int order, bool up, double a,
                           double b)
{
    double gap[2], slope, *w = s->next, rate[2 * s->n];
    ric_root_slope r = ric_root_slope_between(a, b, up, (a + b) / 2);
    r.least = FOUND * (b - a);
    do {
        if (!go(s, r.x, w)) break;
        gap_of(s->m, contact, w, gap);
        ric_flight_rate(s->m, 0, w, rate);
        slope = order ? ric_dot(s->n, s->m->c + contact * s->n, rate + s->n) : gap[1];
    } while (ric_root_slope_next(&r, gap[order], slope));
    return r.x;
}

/* The time of the first passage of a contact within a step h that ends at `end`; infinite if there
 * is none. */
static double passage(const ric_section_motion *s, int contact, double h, const double *end)
{
    double from[2], to[2], top[2], *w = s->next;
    gap_of(s->m, contact, s->w, from);
    gap_of(s->m, contact, end, to);
    bool left = s->face >= 0 && s->face / 2 == contact, above = left ? from[1] > 0 : from[0] > 0;
    bool turns = (from[1] > 0) != (to[1] > 0), crossed = (to[0] > 0) != above;
    double mid = 0;
    if (turns) {
        mid = zero_between(s, contact, 1, to[1] > 0, 0, h);
        if (!go(s, mid, w)) return INFINITY;
        gap_of(s->m, contact, w, top);
        if ((top[0] > 0) != above) return zero_between(s, contact, 0, !above, 0, mid);
    }
    return crossed ? zero_between(s, contact, 0, !above, mid, h) : INFINITY;
}

/* State and deviation through t, with the turning of c(u). */
static bool advance(ric_section_motion *s, double t)
{
    int n = s->n;
    double *X = s->work, before[2], after[2];
    if (s->measure.turning) ric_section_measure_number(s->m, s->w, s->rate, s->u, before);
    for (int i = 0; i < 2 * n; i++) {
        X[2 * i] = s->u[i];
        X[2 * i + 1] = 0;
    }
    if (!ric_power_flow_fly(s->m, t, s->w, 2, X, flow_work(s))) return false;
    for (int i = 0; i < 2 * n; i++) s->u[i] = X[2 * i];
    ric_flight_rate(s->m, 0, s->w, s->rate);
    ric_section_motion_pass(s, t);
    if (!s->measure.turning) return true;
    ric_section_measure_number(s->m, s->w, s->rate, s->u, after);
    s->measure.angle += atan2(before[0] * after[1] - before[1] * after[0],
                              before[0] * after[0] + before[1] * after[1]);
    return true;
}

static double step_of(const ric_section_motion *s)
{
    double fastest = 0, pace = PART_OF_PACE * ric_power_flow_pace(s->m, s->w, flow_work(s));
    for (int i = 0; i < s->n; i++) fastest = fmax(fastest, s->m->omega[i]);
    return fastest * pace > STEP ? STEP / fastest : pace;
}

/* On s = 0 of the contact, with the energy of the section. */
static void settle(ric_section_motion *s, int contact, bool falls)
{
    const ric_model *m = s->m;
    ric_face plane = {.contact = contact, .c = m->c + contact * s->n, .g = m->g + contact * s->n};
    plane.cc = ric_dot(s->n, plane.c, plane.c);
    ric_section_motion_onto(s->n, plane.g, 0, s->w);
    ric_section_motion_level(s);
    ric_flight_rate(m, 0, s->w, s->rate);
    ric_section_measure_arrive(&s->measure, &plane, s->w, s->rate, s->u);
    ric_section_measure_leave(&s->measure, &plane, s->w, s->rate, s->u);
    s->face = 2 * contact + falls;
}

ric_status ric_section_power_next(ric_section_motion *s, int *face)
{
    double end[2 * s->n], gap[2];
    for (int k = 0; k < STEPS_MOST; k++) {
        double h = step_of(s), first = INFINITY;
        int contact = -1;
        if (!(h > 0) || !go(s, h, end))
            return ric_fail(RIC_E_NUMERIC, "the flow under a power law cannot be followed");
        for (int f = 0; f < s->m->n_contact; f++) {
            double t = passage(s, f, h, end);
            if (t < first) contact = f;
            first = fmin(first, t);
        }
        double square = ric_dot(2 * s->n, s->u, s->u);
        if (!(square > RIC_SECTION_SHORT && square < RIC_SECTION_LONG))
            ric_section_measure_growth(&s->measure, s->u);
        if (!advance(s, fmin(h, first)))
            return ric_fail(RIC_E_NUMERIC, "the flow under a power law overflows");
        s->face = -1;
        if (contact < 0) continue;
        gap_of(s->m, contact, s->w, gap);
        settle(s, contact, gap[1] < 0);
        *face = s->face;
        return RIC_OK;
    }
    snprintf(s->why, sizeof s->why, "the motion passes no spring any more");
    return RIC_OK;
}
