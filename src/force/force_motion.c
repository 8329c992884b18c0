#include "force_motion.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"

/* TOUCHES: relative to a clearance: a maximum this near to its face is not known to be below it */
#define TOUCHES 1e-10
#define STANDS 1e-10 /* scaled speed at an event that is none */
/* UNDECIDED: multipliers nearer to the circle than this decide nothing, however well they are known
 */
#define UNDECIDED 1e-9
#define FLAT 1e-14 /* relative: a maximum that is found cannot be passed by more */

#define AGREE 1e-13 /* relative: two quadratures of one flight; their rounding is a tenth of it */

enum { DEEPEST = 52, PARTS = 64, PANELS_MOST = 1024 };

/* ------------------------------------------------------------------- maxima */

typedef struct {
    const ric_force_reading *r;
    double best, time;
} hunt;

static double crest(const ric_force_reading *r, double a, double b)
{
    double slope;
    for (int k = 0; k < DEEPEST; k++) {
        const double t = a + (b - a) / 2;
        ric_force_frame_look(r, t, &slope);
        if (slope > 0) a = t;
        else b = t;
    }
    return a + (b - a) / 2;
}

static void take(hunt *h, double time, double value)
{
    if (!(value > h->best)) return;
    h->best = value;
    h->time = time;
}

/* A time, the value there, and its slope. */
typedef struct {
    double t, value, slope;
} place;

static place look(const ric_force_reading *r, double t)
{
    place p = {.t = t};
    p.value = ric_force_frame_look(r, t, &p.slope);
    return p;
}

/* Maxima between a and b. */
static void seek(hunt *h, place a, place b, int depth)
{
    const double length = b.t - a.t, most = h->r->bend * length;
    if (fmax(a.value, b.value) + most * length / 8 <= h->best + FLAT * (1 + fabs(h->best))) return;
    if (a.slope - most > 0 || b.slope - most > 0 || a.slope + most < 0 || b.slope + most < 0)
        return; /* it rises, or falls */
    /* Flat within rounding: parts of it could be told apart no better, and there are as many as one
     * looks at. */
    const bool last = depth == 0 || most * length / 8 <= FLAT * (1 + fabs(h->best));
    if (a.slope > 0 && b.slope < 0 && (last || depth <= DEEPEST - 4)) {
        const place top = look(h->r, crest(h->r, a.t, b.t));
        take(h, top.t, top.value);
    }
    if (last) return;
    const place middle = look(h->r, a.t + length / 2);
    seek(h, a, middle, depth - 1);
    seek(h, middle, b, depth - 1);
}

/* All of a flight, with the value at its start or at its end if that counts. */
static void seek_all(hunt *h, double tau, bool start, bool end)
{
    const place first = look(h->r, 0), last = look(h->r, tau);
    if (start) take(h, first.t, first.value);
    seek(h, first, last, DEEPEST);
    if (end) take(h, last.t, last.value);
}

ric_status ric_force_motion_highest(const ric_force_orbit *o, int k, int face, double least,
                                    double *highest, double *time)
{
    const ric_force_medium *m = o->medium;
    const int n = o->n;
    double row[2 * n], room[4 * n];
    const ric_force_start start = ric_force_orbit_start(o, k);
    const double *c = ric_force_medium_normal(m, face);
    const bool closed = ric_face_in(o->closed[k], face);
    const double sign = (closed ? -1 : 1) * m->model->face[face].side / m->gap[face];
    ric_force_reading r;
    for (int i = 0; i < n; i++) {
        row[i] = sign * c[i];
        row[n + i] = 0;
    }
    ric_status status = ric_force_frame_read(o->medium, &start, row, room, &r);
    if (status) return status;
    if (closed) r.rest += 2;
    hunt h = {&r, least, NAN};
    /* the impact of another contact may turn the gap round */
    seek_all(&h, ric_force_orbit_tau(o, k), false, ric_force_orbit_end(o, k) != face);
    *highest = h.best;
    *time = h.time;
    return RIC_OK;
}

/* -------------------------------------------------------------------- faults */

double ric_force_motion_speed(const ric_force_orbit *o, int k)
{
    const int face = o->face[k];
    const double v = ric_force_medium_towards(o->medium, face, ric_force_orbit_node(o, k) + o->n);
    if (ric_force_medium_rigid(o->medium, face)) return -v / o->drive.restitution;
    return ric_face_in(o->closed[k], face) ? v : -v;
}

ric_status ric_force_motion_fault(const ric_force_orbit *o, const char **fault)
{
    *fault = "";
    for (int k = 0; k < o->N; k++) {
        if (!(ric_force_orbit_tau(o, k) > 0)) *fault = "a flight takes no time";
        else if (o->events && !(ric_force_motion_speed(o, k) > STANDS))
            *fault = ric_force_medium_rigid(o->medium, o->face[k])
                         ? "an impact does not approach its stop"
                         : "a spring is not met in its direction";
        for (int f = 0; f < o->medium->model->n_face && !**fault; f++) {
            double highest, time;
            ric_status status = ric_force_motion_highest(o, k, f, 1 - TOUCHES, &highest, &time);
            if (status) return status;
            if (!isnan(time)) *fault = "a stop is passed, or touched, between two impacts";
        }
        if (**fault) return RIC_OK;
    }
    return RIC_OK;
}

/* --------------------------------------------------------------- multipliers */

/* Deviations X [2n * 2n] at one time through a flight and the event at its end, back to one time:
 * the event comes earlier where the face is nearer (the saltation of Mueller 1995). */
static ric_status carry(const ric_force_orbit *o, int k, double *X, double *room)
{
    const int n = o->n, size = 2 * n, ld = size + RIC_BY_COUNT, face = ric_force_orbit_end(o, k);
    ric_force_medium *m = o->medium;
    const double *u = ric_force_orbit_node(o, k), theta = u[size] + o->drive.omega * u[size + 1];
    double z[size], in[size], out[size], *D = room, *Y = D + size * ld;
    const ric_force_start start = ric_force_orbit_start(o, k);
    ric_status status = ric_force_frame_fly(m, &start, u[size + 1], z, D);
    if (status) return status;
    memset(Y, 0, (size_t)size * (size_t)size * sizeof *Y);
    for (int i = 0; i < size; i++)
        for (int l = 0; l < size; l++)
            for (int j = 0; j < size; j++) Y[i * size + j] += D[i * ld + l] * X[l * size + j];
    memcpy(X, Y, (size_t)size * (size_t)size * sizeof *X);
    if (face < 0 || !ric_force_medium_rigid(m, face))
        return RIC_OK; /* a spring begins without a force */
    const double *c = ric_force_medium_normal(m, face);
    ric_force_medium_rate(m, o->closed[k], &o->drive, theta, z, in);
    ric_force_medium_strike(m, o->drive.restitution, face, 1, z + n);
    ric_force_medium_rate(m, o->closed[(k + 1) % o->N], &o->drive, theta, z, out);
    for (int j = 0; j < size; j++) {
        double late = 0;
        for (int i = 0; i < n; i++) late -= c[i] * X[i * size + j];
        late /= ric_dot(n, c, in);
        for (int i = 0; i < size; i++) X[i * size + j] += in[i] * late;
        Y[j] = late;
    }
    ric_force_medium_strike(m, o->drive.restitution, face, size, X + (size_t)n * (size_t)size);
    for (int i = 0; i < size; i++)
        for (int j = 0; j < size; j++) X[i * size + j] -= out[i] * Y[j];
    return RIC_OK;
}

ric_status ric_force_motion_multipliers(const ric_force_orbit *o, double *out, double *rounding,
                                        double *keep)
{
    const size_t size = 2 * (size_t)o->n;
    double most = 1, *X = ric_calloc(2 * size * size + size * (size + RIC_BY_COUNT), sizeof *X);
    ric_status status = X ? RIC_OK : ric_no_memory("multipliers");
    for (size_t i = 0; i < size && X; i++) X[i * size + i] = 1;
    for (int k = 0; k < o->N && !status; k++) {
        status = carry(o, k, X, X + size * size);
        for (size_t i = 0; i < size * size; i++) most = fmax(most, fabs(X[i]));
    }
    if (keep && !status) memcpy(keep, X, size * size * sizeof *X);
    if (!status && !ric_eigen((int)size, X, out))
        status = ric_trust(
            ric_fail(RIC_E_NUMERIC, "the multipliers of a forced orbit cannot be computed"));
    *rounding = most * sqrt(DBL_EPSILON);
    free(X);
    return status;
}

ric_stability ric_force_motion_judge(int n, const double *multipliers, double rounding,
                                     double *largest)
{
    const double near = fmax(rounding, UNDECIDED);
    *largest = 0;
    for (int i = 0; i < 2 * n; i++)
        *largest = fmax(*largest, hypot(multipliers[2 * i], multipliers[2 * i + 1]));
    return *largest < 1 - near   ? RIC_STABLE_YES
           : *largest > 1 + near ? RIC_STABLE_NO
                                 : RIC_STABLE_UNDECIDED;
}

/* ------------------------------------------------------------------ measures */

void ric_force_motion_leave(const ric_force_medium *m, const double *z, double *state)
{
    const int n = m->n;
    for (int j = 0; j < n; j++) {
        state[j] = state[n + j] = 0;
        for (int i = 0; i < n; i++) {
            state[j] += m->model->Phi[j * n + i] * z[i] / m->unit;
            state[n + j] += m->model->Phi[j * n + i] * z[n + i] * m->time / m->unit;
        }
    }
}

void ric_force_motion_enter(const ric_force_medium *m, const double *state, double *z)
{
    ric_force_modal(m->force, state, state + m->n, z, z + m->n);
    for (int i = 0; i < m->n; i++) {
        z[i] *= m->unit;
        z[m->n + i] *= m->unit / m->time;
    }
}

/* int x_j^2 dt over a flight by so many panels, and the largest |x_j| at the nodes to peak. */
static ric_status sample(const ric_force_orbit *o, int k, int panels, double *squares, double *peak)
{
    const int n = o->n;
    const bool goes_on = o->medium->smooth;
    ric_force_start start = ric_force_orbit_start(o, k);
    double z[2 * n], state[2 * n], last = 0;
    for (int j = 0; j < n; j++) squares[j] = 0;
    for (int i = 0; i < 8 * panels; i++) {
        double weight;
        const double t = ric_gauss_node(ric_force_orbit_tau(o, k), panels, i, &weight);
        if (goes_on) start.theta = ric_force_orbit_theta(o, k) + o->drive.omega * last;
        ric_status status = ric_force_frame_fly(o->medium, &start, t - last, z, NULL);
        if (status) return status;
        if (goes_on) {
            start.z = z;
            last = t;
        }
        ric_force_motion_leave(o->medium, z, state);
        for (int j = 0; j < n; j++) {
            squares[j] += weight * state[j] * state[j];
            peak[j] = fmax(peak[j], fabs(state[j]));
        }
    }
    return RIC_OK;
}

/* Adds int x_j^2 dt over a flight to rms: panels are halved until two rules agree, as springs that
 * are closed, or under a power law, are faster than the modes. */
static ric_status squares_of(const ric_force_orbit *o, int k, int panels, ric_force_measures *out)
{
    const int n = o->n;
    double before[n], sum[n];
    ric_status status = sample(o, k, panels, sum, out->peak);
    for (double off = INFINITY, most = 0; !status && off > AGREE * most && panels < PANELS_MOST;) {
        memcpy(before, sum, sizeof sum);
        panels *= 2;
        status = sample(o, k, panels, sum, out->peak);
        off = most = 0;
        for (int j = 0; j < n; j++) {
            off = fmax(off, fabs(sum[j] - before[j]));
            most = fmax(most, sum[j]);
        }
    }
    for (int j = 0; j < n; j++) out->rms[j] += sum[j];
    return status;
}

/* Largest |x_j| over a flight, its ends among it. */
static ric_status peaks(const ric_force_orbit *o, int k, ric_force_measures *out)
{
    const int n = o->n;
    const ric_force_medium *m = o->medium;
    const ric_force_start start = ric_force_orbit_start(o, k);
    double row[2 * n], room[4 * n];
    memset(row, 0, sizeof row);
    for (int j = 0; j < 2 * n; j++) {
        ric_force_reading r;
        const double sign = j < n ? 1 : -1;
        for (int i = 0; i < n; i++) row[i] = sign * m->model->Phi[j % n * n + i] / m->unit;
        ric_status status = ric_force_frame_read(o->medium, &start, row, room, &r);
        if (status) return status;
        hunt h = {&r, out->peak[j % n], NAN};
        seek_all(&h, ric_force_orbit_tau(o, k), true, false);
        out->peak[j % n] = h.best;
    }
    return RIC_OK;
}

/* Where |x_j| is largest under a power law: the speed is zero between two samples, on a motion that
 * is flown anew. */
static ric_status smooth_peaks(const ric_force_orbit *o, int k, ric_force_measures *out)
{
    const int n = o->n;
    const double step = ric_force_orbit_tau(o, k) / PARTS;
    ric_force_start start = ric_force_orbit_start(o, k);
    double z[2 * n], next[2 * n], state[2 * n], after[2 * n];
    memcpy(z, start.z, sizeof z);
    start.z = z;
    for (int i = 0; i < PARTS; i++) {
        start.theta = ric_force_orbit_theta(o, k) + o->drive.omega * step * i;
        ric_status status = ric_force_series_fly(o->medium, &start, step, next, NULL);
        ric_force_motion_leave(o->medium, z, state);
        ric_force_motion_leave(o->medium, next, after);
        for (int j = 0; j < n && !status; j++) {
            double a = 0, b = step, at[2 * n], x[2 * n];
            out->peak[j] = fmax(out->peak[j], fabs(state[j]));
            if (state[n + j] * after[n + j] > 0) continue;
            for (int l = 0; l < DEEPEST && !status; l++) {
                status = ric_force_series_fly(o->medium, &start, (a + b) / 2, at, NULL);
                ric_force_motion_leave(o->medium, at, x);
                if (x[n + j] * state[n + j] > 0) a = (a + b) / 2;
                else b = (a + b) / 2;
            }
            out->peak[j] = fmax(out->peak[j], fabs(x[j]));
        }
        if (status) return status;
        memcpy(z, next, sizeof z);
    }
    return RIC_OK;
}

static ric_status find_reach(const ric_force_orbit *o, ric_force_measures *out)
{
    double best = 0.5; /* gaps that stay wider than half tell nothing */
    out->reach = out->approach = NAN;
    for (int k = 0; k < o->N; k++) {
        if (o->events) out->approach = fmin(out->approach, ric_force_motion_speed(o, k));
        for (int f = 0; f < o->medium->model->n_face; f++) {
            double time;
            ric_status status = ric_force_motion_highest(o, k, f, best, &best, &time);
            if (status) return status;
            if (!isnan(time)) out->reach = best;
        }
    }
    return RIC_OK;
}

ric_status ric_force_motion_measure(const ric_force_orbit *o, ric_force_measures *out)
{
    const int n = o->n;
    const double period = ric_force_orbit_period(o);
    double fastest = o->drive.omega;
    for (int i = 0; i < n; i++) {
        fastest = fmax(fastest, o->medium->omega[i]);
        out->peak[i] = out->rms[i] = 0;
    }
    ric_status status = find_reach(o, out);
    for (int k = 0; k < o->N && !status; k++) {
        status = squares_of(o, k, 1 + (int)(fastest * ric_force_orbit_tau(o, k) / 4), out);
        if (!status) status = o->medium->smooth ? smooth_peaks(o, k, out) : peaks(o, k, out);
    }
    for (int i = 0; i < n; i++) out->rms[i] = sqrt(out->rms[i] / period);
    return status;
}

ric_status ric_force_motion_strobe(const ric_force_orbit *o, double theta, double *z)
{
    const double first = ric_force_orbit_theta(o, 0), whole = o->harmonic * RIC_TWO_PI;
    theta = first + remainder(theta - first, whole);
    if (theta < first) theta += whole;
    for (int k = 0; k < o->N; k++) {
        const ric_force_start start = ric_force_orbit_start(o, k);
        const double t = (theta - start.theta) / o->drive.omega;
        if (t > ric_force_orbit_tau(o, k) && k + 1 < o->N) continue;
        return ric_force_frame_fly(o->medium, &start, t, z, NULL);
    }
    return RIC_OK;
}
