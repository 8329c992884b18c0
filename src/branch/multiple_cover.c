#include "multiple_cover.h"

#include <stdlib.h>
#include <string.h>

#include "model/room.h"
#include "orbit/room.h"
#include "base/room.h"

/* NEAR: distance of an orbit from its shifted image, relative to its size, from which on it may be
 * near a repeated one */
#define NEAR 0.2
/* CLOSE: where the extrapolation, whose error is of fourth order (of second, at order 3), starts */
#define CLOSE 5e-3
/* CLOSEST: where it is given up: along some branches the rotation number changes by all it can
 * within 1e-3 */
#define CLOSEST 2e-4
/* CLOSEST_3: the same of order 3: the branch passes, and is known to rounding / distance all the
 * way */
#define CLOSEST_3 1e-6
/* FASTEST: how fast the distance from the first image falls with arclength, 2 sin(pi p / r), where
 * shifts are nearly isometric; under a power law it was seen to fall twice as fast */
#define FASTEST 2
#define STEPS 8   /* so many steps ahead an orbit of fewer periods is taken into account */
#define FLAT 1e-6 /* smallest pivot below which no step is made any more */
/* MULTIPLIER: accuracy of lambda + 1/lambda of an extrapolated orbit that shows its order */
#define MULTIPLIER 1e-3

/* The word of the chain repeats itself after `step` flights, with the faces exchanged for sign =
 * -1. */
static bool word_repeats(const ric_shooting *c, int step, int sign)
{
    for (int k = 0; k + step <= c->n_flight; k++) {
        int f = c->face[k];
        if (sign < 0 && (f = c->model->face[f].mirror) < 0) return false;
        if (c->face[k + step] != f) return false;
    }
    return true;
}

/* By its flight times the orbit may be near one that repeats itself after `step` flights, and is
 * none: on a duplicate all along there is nothing ahead. */
static bool may_repeat(const ric_shooting *c, const double *u, int step)
{
    const double *tau = u + c->n_start;
    double sum = 0, limit = NEAR * c->scale;
    for (int k = 0; k < c->n_flight && sum <= limit * limit; k++) {
        double d = tau[k + step < c->n_flight ? k + step : k + step - c->n_flight] - tau[k];
        sum += d * d;
    }
    return sum <= limit * limit && sum > RIC_SAME_LOCATED * RIC_SAME_LOCATED * c->scale * c->scale;
}

/* Mean [size] of the orbit and its images under the shift by n_flight / r flights; returns the
 * distance to the first image. */
static double average(ric_shooting *c, const double *u, int order, int sign, double *mean)
{
    int n = 2 * c->n, step = c->n_flight / order;
    double distance = 0;
    ric_shooting_fly(c, u);
    memset(mean, 0, (size_t)c->n_unknown * sizeof *mean);
    for (int k = 0, s = 1; k < order; k++, s *= sign)
        for (int i = 0; i < n; i++) mean[i] += s * c->w[n * step * k + i] / order;
    for (int k = 0; k < c->n_flight; k++)
        for (int j = 0; j < order; j++) mean[n + k] += u[n + (k + j * step) % c->n_flight] / order;
    for (int i = 0; i < n; i++) distance += pow(sign * c->w[n * step + i] - u[i], 2);
    for (int k = 0; k < c->n_flight; k++)
        distance += pow(u[n + (k + step) % c->n_flight] - u[n + k], 2);
    return sqrt(distance);
}

/* Of an orbit without events, one flight, its image that has the state w: what lies across the flow
 * at its own start, off [2n]. */
static void across(const ric_shooting *c, const double *u, const double *w, int sign, double *off)
{
    int n = 2 * c->n;
    double rate[n], along = 0;
    ric_flight_rate(c->model, 0, u, rate);
    for (int i = 0; i < n; i++) off[i] = sign * w[i] - u[i];
    for (int i = 0; i < n; i++) along += rate[i] * off[i] / ric_dot(n, rate, rate);
    for (int i = 0; i < n; i++) off[i] -= along * rate[i];
}

/* The mean of `average` of such an orbit. */
static void average_smooth(const ric_shooting *c, const double *u, int order, int sign,
                           double *mean)
{
    int n = 2 * c->n;
    double w[n], off[n];
    memcpy(mean, u, (size_t)c->n_unknown * sizeof *mean);
    memcpy(w, u, sizeof w);
    for (int k = 1, s = sign; k < order; k++, s *= sign) {
        ric_flight_go(c->model, 0, -1, u[n] / order, w, w);
        across(c, u, w, s, off);
        for (int i = 0; i < n; i++) mean[i] += off[i] / order;
    }
}

/* Distances of an orbit without events from its images after 1 / r of its time, by sign and for
 * every r from 3 on. */
typedef struct {
    double image[2][RIC_COPIES + 1];
} distances;

static void measure(const ric_shooting *c, const double *u, distances *out)
{
    int n = 2 * c->n;
    double time[RIC_COPIES - 2], w[(RIC_COPIES - 2) * n], off[n];
    for (int r = RIC_COPIES; r >= 3; r--) time[RIC_COPIES - r] = u[n] / r;
    ric_flight_visit(c->model, RIC_COPIES - 2, time, u, w);
    for (int r = RIC_COPIES; r >= 3; r--)
        for (int back = 0; back < 2; back++) {
            across(c, u, w + (RIC_COPIES - r) * n, 1 - 2 * back, off);
            out->image[back][r] = sqrt(ric_dot(n, off, off));
        }
}

/* Solves the orbit of one period of the map from the mean u, puts it back into u, repeated, and
 * looks for a multiplier of the order. */
static ric_status solve_short(const ric_shooting *c, int order, int sign, double *u, bool *found)
{
    bool smooth = !ric_periodic_has_events(c->model); /* one flight for all periods */
    int n = 2 * c->n, step = smooth ? 1 : c->n_flight / order, iterations;
    ric_shooting *one = NULL;
    ric_floquet floquet = {0};
    double v[n + step], du[n + step];
    ric_status status = ric_shooting_create(c->model, RIC_MIRROR_NONE, RIC_MIRROR_NONE, sign, step,
                                            c->face, &one);
    *found = false;
    if (status || (status = ric_floquet_create(c->n, &floquet))) goto out;
    memcpy(v, u, sizeof v);
    if (smooth) v[n] /= order;
    if (!ric_continuation_correct(one, v, NULL, NULL, 0, du, &iterations)) goto out;
    if ((status = ric_floquet_compute(one, &floquet))) goto out;
    for (int i = 0; i < floquet.n_pair; i++)
        for (int k = 1; 2 * k < order; k++)
            *found |= hypot(floquet.own[2 * i] - 2 * cos(RIC_TWO_PI * k / order),
                            floquet.own[2 * i + 1]) < MULTIPLIER;
    memcpy(u, v, (size_t)n * sizeof *u);
    for (int k = 0; k < c->n_flight; k++) u[n + k] = v[n + k % step];
    if (smooth) {
        u[n] *= order;
        ric_shooting_nodes_spread(c, u);
    }
out:
    ric_shooting_free(one);
    ric_floquet_release(&floquet);
    return status;
}

/* An orbit that is no station; in its tests everything is at zero. */
static ric_status fill_row(ric_continuation *tr, double s, ric_station *p)
{
    memcpy(p->t, tr->now.t, (size_t)tr->chain->n_unknown * sizeof *p->t);
    ric_status status = ric_continuation_fill(tr, s, p);
    p->row.stable = RIC_STABLE_UNDECIDED;
    return status;
}

/* The last two orbits and their images after 1 / order of their time: the distances of those
 * without events. */
typedef struct {
    int order, sign;
    double past, now;
} images;

/* At distance d the mean is off by d^2 (by d at order 3, where the branch passes with a slope). */
static ric_status ahead(ric_continuation *tr, const images *of, double *h, bool *found,
                        ric_station *out)
{
    ric_shooting *c = tr->chain;
    const int order = of->order, sign = of->sign;
    const bool smooth = !ric_periodic_has_events(c->model);
    double before[c->n_unknown], now[c->n_unknown], d0 = of->past, d1 = of->now;
    if (!smooth) {
        d0 = average(c, tr->past.u, order, sign, before);
        d1 = average(c, tr->now.u, order, sign, now);
    }
    const double scale = c->scale;
    *found = false;
    if (!(d1 < d0) || d1 > NEAR * scale) return RIC_OK;
    double slope = (d0 - d1) / (tr->now.s - tr->past.s), left = d1 / slope,
           nearest = d1 / fmax(FASTEST, 2 * slope);
    double x = order == 3 ? d1 / (d0 - d1) : d1 * d1 / (d0 * d0 - d1 * d1);
    ric_shooting_evaluate(c, tr->now.u);
    bool flat = order > 3 && c->smallest < FLAT;
    /* such an orbit may be nearer than the distance has fallen so far: close to it, it falls
     * faster; and the determinant vanishes there, too */
    bool far = left > 2 * *h && !flat;
    /* from farther away the determinant is none of its rounding, and a zero of it on this step,
     * which goes half the way at most, is a crossing */
    const bool near = flat || left < STEPS * RIC_CROSSING * scale;
    if (left < STEPS * *h) *h = fmin(*h, fmax(nearest, left / 4));
    if (nearest < RIC_CROSSING * scale && near) tr->longest = fmin(tr->longest, *h);
    if (far) return RIC_OK;
    if (smooth) {
        average_smooth(c, tr->past.u, order, sign, before);
        average_smooth(c, tr->now.u, order, sign, now);
    }
    for (int i = 0; i < c->n_unknown; i++) out->u[i] = now[i] + x * (now[i] - before[i]);
    ric_status status = solve_short(c, order, sign, out->u, found);
    if (status) return status;
    if (!flat && left > (*found       ? CLOSE
                         : order == 3 ? CLOSEST_3
                                      : CLOSEST) *
                            scale) { /* nearer first */
        *h = fmin(*h, left / 2);
        *found = false;
    }
    if (near) tr->longest = fmin(tr->longest, *h);
    if (!*found) return RIC_OK;
    if ((status = fill_row(tr, tr->now.s + left, out))) return status;
    if (order == 3) *h = 2 * left; /* as far beyond */
    return RIC_OK;
}

/* Whether the orbit may be near one of 1 / r of its flights, by its word and its times; without
 * events, by its distance. */
static bool candidate(const ric_shooting *c, const double *u, const images *of)
{
    int r = of->order;
    if (of->sign > 0 ? c->sigma < 0 : (c->sigma < 0) != r % 2) return false;
    if (!ric_periodic_has_events(c->model))
        return of->now <= NEAR * c->scale && of->now > RIC_SAME_LOCATED * c->scale;
    return c->n_flight % r == 0 && may_repeat(c, u, c->n_flight / r) &&
           word_repeats(c, c->n_flight / r, of->sign);
}

ric_status ric_multiple_cover_ahead(ric_continuation *tr, double *h, int *order, ric_station *out)
{
    const ric_shooting *c = tr->chain;
    bool smooth = !ric_periodic_has_events(c->model), asked = false;
    distances past = {0}, now = {0};
    *order = 0;
    if (c->start != RIC_MIRROR_NONE || !tr->has_past || tr->ignore || tr->limits->ghost || c->n < 2)
        return RIC_OK;
    if (smooth) measure(c, tr->now.u, &now);
    /* the longest repetition first: one of 6 half periods is one of 3 periods, too */
    for (int r = smooth ? RIC_COPIES : c->n_flight; r >= 3; r--)
        for (int back = 0; back < 2; back++) {
            images of = {.order = r, .sign = 1 - 2 * back, .now = smooth ? now.image[back][r] : 0};
            bool found;
            if (!candidate(c, tr->now.u, &of)) continue;
            if (smooth && !asked) measure(c, tr->past.u, &past);
            asked = true;
            of.past = smooth ? past.image[back][r] : 0;
            ric_status status = ahead(tr, &of, h, &found, out);
            if (status) return status;
            if (!found) continue;
            *order = r;
            return RIC_OK;
        }
    return RIC_OK;
}
