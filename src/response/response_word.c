#include "response_word.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"

#define STANDS 1e-6 /* speed at an event, or gap inside a flight, at a grazing that was located */
#define SPEED 1e-3  /* of an impact where it begins, relative to that of the structure */
#define AWAY 1e-3   /* step along another direction, relative to 1 + |unknowns| */

/* An event of a new word in the order of phases. */
typedef struct {
    int face;
    uint64_t closed; /* after it */
    double theta;
    double *z; /* [2n] right after it */
    bool fresh;
} entry;

/* ------------------------------------------------------------------- touches */

ric_status ric_response_word_touches(const ric_force_orbit *o, ric_response_touch *out, int *n)
{
    *n = 0;
    for (int k = 0; k < o->N; k++) {
        if (o->events && fabs(ric_force_motion_speed(o, k)) < STANDS) {
            if (*n == RIC_TOUCHES_MOST) return *n = -1, RIC_OK;
            out[(*n)++] = (ric_response_touch){true, k, o->face[k], 0};
        }
        for (int f = 0; f < o->medium->model->n_face; f++) {
            double highest, time;
            ric_status status = ric_force_motion_highest(o, k, f, 1 - STANDS, &highest, &time);
            if (status) return status;
            const double tau = ric_force_orbit_tau(o, k), near = sqrt(STANDS) * tau;
            /* beside an event without speed the touch is that event */
            if (isnan(time) ||
                (o->events && ((time < near && o->face[k] == f) ||
                               (time > tau - near && ric_force_orbit_end(o, k) == f))))
                continue;
            if (*n == RIC_TOUCHES_MOST) return *n = -1, RIC_OK;
            out[(*n)++] = (ric_response_touch){false, k, f, time};
        }
    }
    return RIC_OK;
}

/* --------------------------------------------------------------------- words */

static int by_theta(const void *p, const void *q)
{
    const entry *a = p, *b = q;
    return (a->theta > b->theta) - (a->theta < b->theta);
}

/* Adds an event at phase theta, in flight k of o; struck there. */
static ric_status add(const ric_force_orbit *o, int k, int face, double time, entry *out)
{
    const double *u = ric_force_orbit_node(o, k);
    const int n = o->n;
    const ric_force_start start = ric_force_orbit_start(o, k);
    ric_status status = RIC_OK;
    if (time > 0) status = ric_force_frame_fly(o->medium, &start, time, out->z, NULL);
    else memcpy(out->z, u, 2 * (size_t)n * sizeof *u);
    out->theta = u[2 * n] + o->drive.omega * time;
    out->face = face;
    out->fresh = true;
    return status;
}

/* Half the time that a touch lasts as a contact of a given speed: s'' at it. */
static double half_time(const ric_force_orbit *o, const ric_response_touch *t, double speed)
{
    const int n = o->n;
    const ric_force_start start = ric_force_orbit_start(o, t->flight);
    double z[2 * n], rate[2 * n];
    memcpy(z, start.z, sizeof z);
    if (t->time > 0 && ric_force_frame_fly(o->medium, &start, t->time, z, NULL)) return 0;
    ric_force_medium_rate(o->medium, start.closed, start.drive,
                          start.theta + o->drive.omega * t->time, z, rate);
    const double bend = fabs(ric_force_medium_towards(o->medium, t->face, rate + n));
    return bend > 0 ? speed / bend : 0;
}

/* Events of o that stay, and the touches of `set` at a small speed; how many. */
static int list(const ric_force_orbit *o, int n_touch, const ric_response_touch *touches,
                unsigned set, double speed, entry *out)
{
    int count = 0;
    for (int k = 0; o->events && k < o->N; k++) {
        bool touched = false;
        for (int i = 0; i < n_touch; i++) {
            const int mate = touches[i].event ? touches[i].flight : -1;
            touched = touched || mate == k ||
                      /* the other switch of a spring that is closed for no time */
                      (mate >= 0 && !ric_force_medium_rigid(o->medium, touches[i].face) &&
                       o->face[k] == touches[i].face &&
                       (k == (mate + 1) % o->N || mate == (k + 1) % o->N));
        }
        if (touched) continue;
        if (add(o, k, o->face[k], 0, &out[count])) return -1;
        out[count++].fresh = false;
    }
    for (int i = 0; i < n_touch; i++) {
        const ric_response_touch *t = &touches[i];
        const bool rigid = ric_force_medium_rigid(o->medium, t->face);
        const double half = half_time(o, t, speed), before = t->time - half;
        if (!(set >> i & 1)) continue;
        if (t->event && !rigid) return -1; /* a spring that stays is not changed */
        if (!(half > 0) || (before < 0 && t->event == false)) return -1;
        if (add(o, t->flight, t->face, t->event ? 0 : before, &out[count])) return -1;
        if (rigid && !t->event)
            ric_force_medium_strike(o->medium, o->drive.restitution, t->face, 1,
                                    out[count].z + o->n);
        count++;
        if (rigid) continue;
        if (add(o, t->flight, t->face, t->time + half, &out[count])) return -1;
        out[count++].fresh = false;
    }
    qsort(out, (size_t)count, sizeof *out, by_theta);
    return count;
}

/* The springs that are closed when the new word starts: none of those that only touch. */
static void close_springs(const ric_force_medium *m, int n, entry *e, uint64_t closed)
{
    for (int i = 0; i < n; i++) {
        if (!ric_force_medium_rigid(m, e[i].face)) closed ^= (uint64_t)1 << e[i].face;
        e[i].closed = closed;
    }
}

/* Springs closed right before the first entry: those whose first switch opens them. */
static uint64_t before_first(const ric_force_orbit *o, int n, const entry *e)
{
    uint64_t closed = 0, seen = 0;
    for (int i = 0; i < n; i++) {
        const uint64_t bit = (uint64_t)1 << e[i].face;
        if (ric_force_medium_rigid(o->medium, e[i].face) || seen & bit) continue;
        seen |= bit;
        if (ric_force_medium_towards(o->medium, e[i].face, e[i].z + o->n) < 0) closed |= bit;
    }
    return closed;
}

static ric_force_orbit *without_events(const ric_force_orbit *o)
{
    ric_force_orbit *out;
    if (o->harmonic != 1 || ric_force_orbit_create(o->medium, 1, NULL, NULL, 1, &out)) return NULL;
    out->drive = o->drive;
    if (ric_force_motion_strobe(o, 0, out->u)) {
        ric_force_orbit_free(out);
        return NULL;
    }
    out->u[2 * o->n] = 0;
    out->u[2 * o->n + 1] = ric_force_orbit_period(o);
    return out;
}

/* The new word as an orbit that starts with entry `first`. */
static ric_force_orbit *assemble(const ric_force_orbit *o, int n, entry *e, int first)
{
    ric_force_orbit *out;
    int face[n + 1];
    uint64_t closed[n + 1];
    if (n == 0) return without_events(o);
    close_springs(o->medium, n, e, before_first(o, n, e));
    for (int i = 0; i < n; i++) {
        face[i] = e[(first + i) % n].face;
        closed[i] = e[(first + i) % n].closed;
    }
    if (ric_force_orbit_create(o->medium, n, face, closed, o->harmonic, &out)) return NULL;
    out->drive = o->drive;
    for (int i = 0; i < n; i++) {
        const entry *at = &e[(first + i) % n], *next = &e[(first + i + 1) % n];
        const double turn = o->harmonic * RIC_TWO_PI, wrap = first + i >= n ? turn : 0;
        double *u = ric_force_orbit_node(out, i);
        memcpy(u, at->z, 2 * (size_t)o->n * sizeof *u);
        u[2 * o->n] = at->theta + wrap;
        u[2 * o->n + 1] = (next->theta - at->theta + ((first + i + 1) % n == 0 ? turn : 0)) /
                          o->drive.omega;
    }
    return out;
}

/* ------------------------------------------------------------------- changes */

/* Off the grazing in the sense in which the solution is a motion; without new impacts both are
 * tried. */
static bool leave_without(ric_force_orbit *x, const ric_response_trace_options *options,
                          double *direction)
{
    const int m = x->m;
    const size_t all = (size_t)x->N * (size_t)m;
    double *full = ric_calloc(2 * all + 1, sizeof *full), row[m + 1],
           *parameter = ric_force_orbit_parameter(x, options->along);
    bool found = false;
    memset(row, 0, sizeof row);
    row[m] = 1;
    if (full && ric_force_orbit_solve(x, options->along, options->scale, NULL, 0, NULL) &&
        ric_force_orbit_tangent(x, options->along, options->scale, row, full)) {
        double *kept = full + all + 1, held = *parameter, margin;
        memcpy(kept, x->u, all * sizeof *kept);
        for (int sign = 1; sign >= -1 && !found; sign -= 2) {
            memcpy(x->u, kept, all * sizeof *kept);
            *parameter = held;
            for (int i = 0; i < m; i++) direction[i] = sign * full[i];
            direction[m] = sign * full[all];
            const double aim = ric_dot(m, direction, x->u) + direction[m] * held / options->scale +
                               AWAY;
            for (size_t i = 0; i < all; i++) x->u[i] += sign * AWAY * full[i];
            *parameter += sign * AWAY * full[all] * options->scale;
            found = ric_force_orbit_solve(x, options->along, options->scale, direction, aim,
                                          NULL) &&
                    !ric_response_trace_margin(x, &margin) && margin > 0;
        }
    }
    free(full);
    return found;
}

/* With the speed of the first event held, and the parameter free. */
static bool leave_with(ric_force_orbit *x, const ric_response_trace_options *options, double speed,
                       double *direction)
{
    const int n = x->n, m = x->m, face = x->face[0];
    const double *c = ric_force_medium_normal(x->medium, face);
    const bool rigid = ric_force_medium_rigid(x->medium, face);
    double row[m + 1], margin, *full = ric_calloc((size_t)x->N * (size_t)m + 1, sizeof *full);
    memset(row, 0, sizeof row);
    /* right after it a stop has given back e times the speed */
    for (int i = 0; i < n; i++)
        row[n + i] = (rigid ? -1 / x->drive.restitution : 1) * x->medium->model->face[face].side *
                     c[i];
    bool found = full &&
                 ric_force_orbit_solve(x, options->along, options->scale, row, speed, NULL) &&
                 !ric_response_trace_margin(x, &margin) && margin > 0 &&
                 ric_force_orbit_tangent(x, options->along, options->scale, row, full);
    for (int i = 0; i < m && found; i++) direction[i] = full[i];
    if (found) direction[m] = full[(size_t)x->N * (size_t)m];
    free(full);
    return found;
}

ric_force_orbit *ric_response_word_change(const ric_force_orbit *o,
                                          const ric_response_trace_options *options, int n,
                                          const ric_response_touch *touches, unsigned set,
                                          double *direction)
{
    const size_t size = 2 * (size_t)o->n, most = (size_t)o->N + 2 * (size_t)n;
    entry *e = ric_calloc(most + 1, sizeof *e);
    double *states = ric_calloc((most + 1) * size, sizeof *states),
           pace = sqrt(ric_dot(o->n, o->u + o->n, o->u + o->n));
    ric_force_orbit *out = NULL;
    for (int attempt = 0; e && states && attempt < 3 && !out; attempt++) {
        static const double part[] = {1, 0.1, 10};
        const double speed = SPEED * part[attempt] * fmax(pace, SPEED);
        for (size_t i = 0; i < most; i++) e[i].z = states + i * size;
        const int count = list(o, n, touches, set, speed, e);
        int first = 0;
        if (count < 0) break;
        while (first < count - 1 && !e[first].fresh) first++;
        out = assemble(o, count, e, count ? first : 0);
        if (!out) break;
        const bool left = set && count && e[first].fresh
                              ? leave_with(out, options, speed, direction)
                              : leave_without(out, options, direction);
        if (left) break;
        ric_force_orbit_free(out);
        out = NULL;
    }
    free(e);
    free(states);
    return out;
}

/* -------------------------------------------------------------------- aside */

ric_force_orbit *ric_response_word_repeat(const ric_force_orbit *o, int copies)
{
    ric_force_orbit *out;
    const int N = o->N * copies;
    int face[N];
    uint64_t closed[N];
    for (int k = 0; k < N; k++) {
        face[k] = o->face[k % o->N];
        closed[k] = o->closed[k % o->N];
    }
    if (ric_force_orbit_create(o->medium, N, o->events ? face : NULL, closed, o->harmonic * copies,
                               &out))
        return NULL;
    out->drive = o->drive;
    for (int k = 0; k < N; k++) {
        double *u = ric_force_orbit_node(out, k);
        memcpy(u, ric_force_orbit_node(o, k % o->N), (size_t)o->m * sizeof *u);
        u[2 * o->n] += k / o->N * o->harmonic * RIC_TWO_PI;
    }
    return out;
}

ric_force_orbit *ric_response_word_aside(const ric_force_orbit *o,
                                         const ric_response_trace_options *options,
                                         const double *tangent, int copies, double sign,
                                         double *direction)
{
    ric_force_orbit *out = ric_response_word_repeat(o, copies);
    const int m = o->m;
    const size_t all = (size_t)o->N * (size_t)copies * (size_t)m;
    double *aside = ric_calloc(all + 1, sizeof *aside), second, margin, size = 1;
    bool found = out && aside &&
                 ric_force_orbit_aside(out, options->along, options->scale, tangent, aside,
                                       &second);
    for (int i = 0; i < 2 * o->n; i++) size += fabs(o->u[i]);
    if (found) {
        double row[m + 1];
        const double length = sign * AWAY * size;
        for (int i = 0; i < m; i++) row[i] = aside[i];
        row[m] = aside[all];
        const double *parameter = ric_force_orbit_parameter(out, options->along),
                     aim = ric_dot(m, row, out->u) + row[m] * *parameter / options->scale + length;
        for (size_t i = 0; i < all; i++) out->u[i] += length * aside[i];
        found = ric_force_orbit_solve(out, options->along, options->scale, row, aim, NULL) &&
                !ric_response_trace_margin(out, &margin) && margin > 0;
        for (int i = 0; i <= m; i++) direction[i] = sign * row[i];
    }
    free(aside);
    if (found) return out;
    ric_force_orbit_free(out);
    return NULL;
}
