#include "impact_map.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "check/room.h"
#include "base/room.h"

/* UNSEEN: part of the largest modal normal of a contact below which a mode is not seen by it */
#define UNSEEN 1e-12
#define ONE_STOP 1e-12 /* normals and distances of faces that are one, relative */
/* PANEL: search step over 1 / omega of the faster mode: the gap has at most one maximum in it but
 * for tiny motions */
#define PANEL 0.5
/* ROUNDING: relative change of the unknowns at which Newton's method has converged; its last step
 * is far below */
#define ROUNDING 1e-13
#define RIGHT_ANGLE 1.57079632679489661923
/* NEARLY: relative: from there on Newton's method goes by its steps, and may rest */
#define NEARLY 1e-9
#define ASTRAY 1e6   /* a step that long leads nowhere */
#define STEEPEST 1.6 /* just beyond grazing, so that Newton's method may pass it on its way */
/* REPLAY: the simulator's impacts agree with the orbit within this, and, near a grazing, */
#define REPLAY 1e-8
/* NEAR_GRAZING: within the time that rounding of the gap means: this over the cosine of the angle
 */
#define NEAR_GRAZING 1e-12

/* ------------------------------------------------------------------ create */

static ric_status find_modes(ric_impact_map *s, const ric_model *m, const ric_real *omega,
                             const ric_real *c)
{
    int n = s->n_dof, seen = 0;
    for (int i = 0; i < n; i++) {
        bool sees = false;
        for (int f = 0; f < ric_model_n_contact(m); f++) {
            ric_real largest = 0;
            for (int j = 0; j < n; j++) largest = fmaxl(largest, fabsl(c[f * n + j]));
            sees |= fabsl(c[f * n + i]) > UNSEEN * largest;
        }
        if (sees && seen < 2) s->mode[seen] = i;
        seen += sees;
    }
    if (seen != 2 && ric_model_n_mode(m) == 2)
        return ric_fail(RIC_E_INPUT,
                        "modes have one frequency, and the stops see a mixture of them, which the "
                        "search by brute force does not take out");
    if (seen != 2 || ric_model_n_mode(m) != 2)
        return ric_fail(RIC_E_INPUT,
                        "the stops see %d modes; the map from impact to impact has a "
                        "two-dimensional section for 2 only",
                        ric_model_n_mode(m));
    for (int k = 0; k < 2; k++) s->omega[k] = (double)omega[s->mode[k]];
    if (s->omega[0] == 0 && s->omega[1] == 0)
        return ric_fail(RIC_E_INPUT, "both modes are free: nothing holds the motion in place");
    return RIC_OK;
}

/* V along the face is V0 + k^2 (y - middle)^2 / 2; k > 0, for a free mode is seen by the contact.
 */
static void fill_face(const ric_impact_map *s, ric_impact_map_face *face)
{
    double k2 = 0, mixed = 0, constant = 0;
    for (int i = 0; i < 2; i++) {
        double w2 = s->omega[i] * s->omega[i], q = face->at * face->normal[i];
        k2 += w2 * face->along[i] * face->along[i];
        mixed += w2 * q * face->along[i];
        constant += w2 * q * q;
    }
    face->middle = -mixed / k2;
    double kinetic = 2 * s->energy - (constant - mixed * mixed / k2);
    face->radius[1] = kinetic > 0 ? sqrt(kinetic) : 0;
    face->radius[0] = face->radius[1] / sqrt(k2);
}

static ric_status make_faces(ric_impact_map *s, const ric_model *m, const ric_real *c)
{
    s->n_face = ric_model_n_face(m);
    s->face = ric_calloc((size_t)s->n_face + 1, sizeof *s->face);
    if (!s->face) return ric_no_memory("a section");
    for (int f = 0; f < s->n_face; f++) {
        ric_impact_map_face *face = &s->face[f];
        ric_contact contact;
        ric_model_face(m, f, &face->contact, &face->side, &face->mirror);
        ric_model_contact(m, face->contact, &contact);
        double c0 = (double)c[face->contact * s->n_dof + s->mode[0]],
               c1 = (double)c[face->contact * s->n_dof + s->mode[1]];
        face->norm = hypot(c0, c1);
        face->clearance = contact.clearance / ric_model_length(m);
        face->at = face->side * face->clearance / face->norm;
        face->normal[0] = c0 / face->norm;
        face->normal[1] = c1 / face->norm;
        face->along[0] = -face->normal[1];
        face->along[1] = face->normal[0];
        fill_face(s, face);
        if (!isfinite(face->radius[0]))
            return ric_fail(RIC_E_INPUT,
                            "contact %d does not see the free mode: motions along it have no bound",
                            face->contact + 1);
    }
    return RIC_OK;
}

/* Which of two faces at one place is met is rounding alone: neighbours never stay together, and
 * what is found on one of them touches the other. */
static ric_status check_faces(const ric_impact_map *s)
{
    for (int f = 1; f < s->n_face; f++)
        for (int g = 0; g < f; g++) {
            const ric_impact_map_face *a = &s->face[g], *b = &s->face[f];
            double off = fabs(fabs(a->at) - fabs(b->at)) / fabs(a->at);
            for (int i = 0; i < 2; i++)
                off = fmax(off, fabs(a->side * a->normal[i] - b->side * b->normal[i]));
            if (off < ONE_STOP)
                return ric_fail(RIC_E_INPUT,
                                "contacts %d and %d are one stop: their normals and clearances are "
                                "in the same proportion; leave one of them out",
                                a->contact + 1, b->contact + 1);
        }
    return RIC_OK;
}

static ric_status check_laws(const ric_model *m)
{
    for (int i = 0; i < ric_model_n_contact(m); i++) {
        ric_contact contact;
        ric_model_contact(m, i, &contact);
        if (contact.law != RIC_LAW_RIGID)
            return ric_fail(RIC_E_INPUT,
                            "contact %d is no rigid stop; hunting knows rigid stops only", i + 1);
    }
    if (ric_model_restitution(m) != 1)
        return ric_fail(
            RIC_E_INPUT,
            "with losses at impacts there are no families of periodic orbits to hunt for");
    return RIC_OK;
}

ric_status ric_impact_map_create(const ric_model *m, double energy, ric_impact_map **out)
{
    ric_impact_map *s = ric_calloc(1, sizeof *s);
    const ric_real *omega, *c;
    ric_status status;
    *out = NULL;
    if (!s) return ric_no_memory("a section");
    s->model = m;
    s->n_dof = ric_model_n_dof(m);
    s->energy = energy;
    if ((status = check_laws(m)) || (status = ric_simulator_create(m, &s->sim))) goto out;
    ric_simulator_frame(s->sim, &omega, &c);
    if ((status = find_modes(s, m, omega, c)) || (status = make_faces(s, m, c)) ||
        (status = check_faces(s)))
        goto out;
    s->panel = PANEL / fmax(s->omega[0], s->omega[1]);
    for (int i = 0; i < 2; i++)
        sincos(s->omega[i] * s->panel, &s->turn[2 * i + 1], &s->turn[2 * i]);
    *out = s;
    s = NULL;
out:
    ric_impact_map_free(s);
    return status;
}

void ric_impact_map_free(ric_impact_map *s)
{
    if (!s) return;
    ric_simulator_free(s->sim);
    free(s->face);
    free(s);
}

/* ------------------------------------------------------------------ states */

static double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1];
}

double ric_impact_map_speed(const ric_impact_map *s, int face, double y)
{
    const ric_impact_map_face *f = &s->face[face];
    double twice = 2 * s->energy;
    for (int i = 0; i < 2; i++) {
        double x = s->omega[i] * (f->at * f->normal[i] + y * f->along[i]);
        twice -= x * x;
    }
    return twice > 0 ? sqrt(twice) : 0;
}

bool ric_impact_map_state(const ric_impact_map *s, const ric_hit *hit, double *w)
{
    const ric_impact_map_face *face = &s->face[hit->face];
    double P = ric_impact_map_speed(s, hit->face, hit->y), sine, cosine;
    if (P == 0) return false;
    sincos(hit->angle, &sine, &cosine);
    for (int i = 0; i < 2; i++) {
        w[i] = face->at * face->normal[i] + hit->y * face->along[i];
        w[2 + i] = P * (sine * face->along[i] - face->side * cosine * face->normal[i]);
    }
    return true;
}

/* The impact of a modal state that is on a face, before it or after. */
static ric_hit hit_of(const ric_impact_map *s, int face, const double *w)
{
    const ric_impact_map_face *f = &s->face[face];
    return (ric_hit){face, dot(f->along, w),
                     atan2(dot(f->along, w + 2), fabs(dot(f->normal, w + 2))), 0};
}

ric_hit ric_impact_map_mirrored(const ric_impact_map *s, ric_hit hit)
{
    return (ric_hit){s->face[hit.face].mirror, -hit.y, -hit.angle, hit.tau};
}

ric_hit ric_impact_map_reversed(ric_hit hit)
{
    return (ric_hit){hit.face, hit.y, -hit.angle, hit.tau};
}

void ric_impact_map_write(const ric_impact_map *s, const ric_hit *hit, double *x, double *v)
{
    double w[4];
    ric_real full[2 * s->n_dof];
    memset(full, 0, sizeof full);
    memset(x, 0, (size_t)s->n_dof * sizeof *x);
    memset(v, 0, (size_t)s->n_dof * sizeof *v);
    if (!ric_impact_map_state(s, hit, w)) return;
    for (int i = 0; i < 2; i++) {
        full[s->mode[i]] = w[i];
        full[s->n_dof + s->mode[i]] = w[2 + i];
    }
    if (ric_simulator_start_modal(s->sim, NULL, full)) return;
    ric_simulator_state(s->sim, NULL, x, v);
}

void ric_impact_map_read(const ric_impact_map *s, int face, const double *x, const double *v,
                         ric_hit *hit)
{
    ric_real full[2 * s->n_dof];
    double w[4];
    ric_simulator_modal(s->sim, x, v, full);
    for (int i = 0; i < 2; i++) {
        w[i] = (double)full[s->mode[i]];
        w[2 + i] = (double)full[s->n_dof + s->mode[i]];
    }
    *hit = hit_of(s, face, w);
}

/* ------------------------------------------------------------------ flight */

static void turn(const double *w, const double *omega, const double *cs, double t, double *after)
{
    for (int i = 0; i < 2; i++) {
        double c = cs[2 * i], sn = cs[2 * i + 1], q = w[i], p = w[2 + i];
        after[i] = omega[i] > 0 ? c * q + sn / omega[i] * p : q + p * t;
        after[2 + i] = c * p - omega[i] * sn * q;
    }
}

static void fly(const ric_impact_map *s, const double *w, double t, double *after)
{
    double cs[4];
    for (int i = 0; i < 2; i++) sincos(s->omega[i] * t, &cs[2 * i + 1], &cs[2 * i]);
    turn(w, s->omega, cs, t, after);
}

/* Gap beyond the face, in modal length: negative inside; and its rate. */
static double beyond(const ric_impact_map_face *face, const double *w)
{
    return face->side * dot(face->normal, w) - face->side * face->at;
}

bool ric_impact_map_inside(const ric_impact_map *s, const double *w, int but)
{
    for (int f = 0; f < s->n_face; f++)
        if (f != but && beyond(&s->face[f], w) > 0) return false;
    return true;
}

static double rate(const ric_impact_map_face *face, const double *w)
{
    return face->side * dot(face->normal, w + 2);
}

/* Zero of the gap (order 0), or of its rate (order 1), between times a and b from w, where it
 * changes sign; divided by the time if the flight starts on the face, which takes that zero away.
 */
static double zero_between(const ric_impact_map *s, const ric_impact_map_face *face,
                           const double *w, int order, bool leaving, double a, double b)
{
    double at[4], f, slope;
    fly(s, w, b, at);
    ric_root_slope r = ric_root_slope_between(a, b,
                                              order ? rate(face, at) > 0 : beyond(face, at) > 0,
                                              (a + b) / 2);
    r.part = 2 * DBL_EPSILON;
    do {
        fly(s, w, r.x, at);
        double g = beyond(face, at), v = rate(face, at), acceleration = 0;
        for (int i = 0; order && i < 2; i++)
            acceleration -= face->side * face->normal[i] * s->omega[i] * s->omega[i] * at[i];
        f = order ? v : leaving ? g / r.x : g;
        slope = order ? acceleration : leaving ? (v - g / r.x) / r.x : v;
    } while (ric_root_slope_next(&r, f, slope));
    return r.x;
}

/* Time of the impact on a face within a panel that goes from w to end; infinite if there is none.
 */
static double within_panel(const ric_impact_map *s, const ric_impact_map_face *face,
                           const double *w, const double *end, bool leaving)
{
    double h = s->panel, g0 = beyond(face, w), g1 = beyond(face, end), v0 = rate(face, w),
           v1 = rate(face, end);
    if (g1 > 0) return zero_between(s, face, w, 0, leaving, 0, h);
    if (leaving || !(v0 > 0 && v1 < 0))
        return INFINITY; /* hops shorter than a panel are left to the simulator */
    double cross = (g1 - v1 * h - g0) / (v0 - v1); /* where the tangents meet, above the maximum */
    if (g0 + v0 * cross < 0) return INFINITY;
    double top = zero_between(s, face, w, 1, false, 0, h), at[4];
    fly(s, w, top, at);
    return beyond(face, at) > 0 ? zero_between(s, face, w, 0, false, 0, top) : INFINITY;
}

bool ric_impact_map_next(const ric_impact_map *s, const double *w, int from, double horizon,
                         double *time, ric_hit *hit, double *after)
{
    double here[4], end[4];
    memcpy(here, w, sizeof here);
    for (double t = 0; t < horizon; t += s->panel) {
        double first = INFINITY;
        int face = -1;
        turn(here, s->omega, s->turn, s->panel, end);
        for (int f = 0; f < s->n_face; f++) {
            double found = within_panel(s, &s->face[f], here, end, t == 0 && f == from);
            if (found < first) {
                first = found;
                face = f;
            }
        }
        if (face >= 0) {
            const ric_impact_map_face *g = &s->face[face];
            fly(s, here, first, after);
            double speed = dot(g->normal, after + 2);
            for (int i = 0; i < 2; i++) after[2 + i] -= 2 * speed * g->normal[i];
            *time = t + first;
            *hit = hit_of(s, face, after);
            return *time <= horizon;
        }
        memcpy(here, end, sizeof here);
    }
    return false;
}

/* ------------------------------------------------------------- derivatives */

/* From impact a over its tau to the face of b: gap beyond that face, y and angle there [3], and
 * their derivatives by y, angle of a and by tau [9]. */
static bool flight_slopes(const ric_impact_map *s, const ric_hit *a, int to, double *value,
                          double *slope)
{
    const ric_impact_map_face *face = &s->face[a->face], *goal = &s->face[to];
    double w[4], end[4], push[4], start[4], P = ric_impact_map_speed(s, a->face, a->y), pull = 0,
                                            sine, cosine;
    if (!ric_impact_map_state(s, a, w)) return false;
    fly(s, w, a->tau, end);
    for (int i = 0; i < 2; i++) pull += s->omega[i] * s->omega[i] * w[i] * face->along[i];
    sincos(a->angle, &sine, &cosine);
    double v = goal->side * dot(goal->normal, end + 2), p = dot(goal->along, end + 2);
    for (int k = 0; k < 3; k++) {
        for (int i = 0; i < 2; i++) {
            double e = face->along[i], n = face->side * face->normal[i];
            start[i] = k == 0 ? e : 0;
            start[2 + i] = k == 0 ? -pull / P / P * w[2 + i] : P * (cosine * e + sine * n);
            push[i] = end[2 + i];
            push[2 + i] = -s->omega[i] * s->omega[i] * end[i];
        }
        if (k < 2) fly(s, start, a->tau, push);
        slope[k] = goal->side * dot(goal->normal, push);
        slope[3 + k] = dot(goal->along, push);
        slope[6 + k] = (v * dot(goal->along, push + 2) -
                        p * goal->side * dot(goal->normal, push + 2)) /
                       (v * v + p * p);
    }
    value[0] = beyond(goal, end);
    value[1] = dot(goal->along, end);
    value[2] = atan2(p, v);
    return true;
}

bool ric_impact_map_slope(const ric_impact_map *s, const ric_hit *a, const ric_hit *b, double *D)
{
    double value[3], slope[9];
    if (!flight_slopes(s, a, b->face, value, slope) || !(slope[2] > 0)) return false;
    for (int r = 0; r < 2; r++)
        for (int k = 0; k < 2; k++)
            D[2 * r + k] = slope[3 * (r + 1) + k] - slope[3 * (r + 1) + 2] * slope[k] / slope[2];
    return true;
}

bool ric_impact_map_around(const ric_impact_map *s, int N, const ric_hit *hits, double *D)
{
    double total[4] = {1, 0, 0, 1};
    for (int k = 0; k < N; k++) {
        double step[4];
        if (!ric_impact_map_slope(s, &hits[k], &hits[(k + 1) % N], step)) return false;
        double a = total[0], b = total[1], c = total[2], d = total[3];
        total[0] = step[0] * a + step[1] * c;
        total[1] = step[0] * b + step[1] * d;
        total[2] = step[2] * a + step[3] * c;
        total[3] = step[2] * b + step[3] * d;
    }
    memcpy(D, total, sizeof total);
    return true;
}

/* ------------------------------------------------------------------ polish */

size_t ric_impact_map_work(int N)
{
    return (size_t)(3 * N) * (size_t)(3 * N) + (size_t)(3 * N);
}

/* Residuals r [3N] and their derivatives A [3N * 3N] by y_k, angle_k, tau_k; the largest residual,
 * infinite where there is no motion. */
static double assemble(const ric_impact_map *s, int N, bool half, const ric_hit *hits, double *A,
                       double *r)
{
    int n = 3 * N;
    double largest = 0;
    memset(A, 0, (size_t)n * (size_t)n * sizeof *A);
    for (int k = 0; k < N; k++) {
        ric_hit next = k + 1 < N ? hits[k + 1]
                       : half    ? ric_impact_map_mirrored(s, hits[0])
                                 : hits[0];
        double value[3], slope[9], sign = k + 1 == N && half ? 1 : -1;
        if (!flight_slopes(s, &hits[k], next.face, value, slope)) return INFINITY;
        int column = 3 * ((k + 1) % N);
        for (int i = 0; i < 3; i++) {
            for (int j = 0; j < 3; j++) A[(3 * k + i) * n + 3 * k + j] = slope[3 * i + j];
            r[3 * k + i] = i == 0 ? value[0] : value[i] - (i == 1 ? next.y : next.angle);
            largest = fmax(largest, fabs(r[3 * k + i]));
        }
        A[(3 * k + 1) * n + column] += sign;
        A[(3 * k + 2) * n + column + 1] += sign;
    }
    return largest;
}

/* Part of the step that keeps every impact within the energy and every time positive: at most all
 * of it. */
static double allowed(const ric_impact_map *s, int N, const ric_hit *hits, const double *step)
{
    double part = 1;
    for (int tries = 0; tries < 6; tries++, part /= 2) {
        bool good = true;
        for (int k = 0; k < N && good; k++)
            good = hits[k].tau - part * step[3 * k + 2] > 0 &&
                   fabs(hits[k].angle - part * step[3 * k + 1]) < STEEPEST &&
                   ric_impact_map_speed(s, hits[k].face, hits[k].y - part * step[3 * k]) > 0;
        if (good) return part;
    }
    return 0;
}

bool ric_impact_map_polish(const ric_impact_map *s, int N, bool half, ric_hit *hits, double *work)
{
    enum { STEPS = 24 };
    int n = 3 * N, settled = 0;
    double *A = work, *r = work + (size_t)n * (size_t)n, before = INFINITY;
    for (int i = 0; i < STEPS; i++) {
        double size = 1, change = 0, residual = assemble(s, N, half, hits, A, r);
        if (!(residual < INFINITY) || !ric_dense_solve(n, 1, A, r, DBL_MIN)) return false;
        if (i > 8 && residual > before / 2 && residual > NEARLY) return false;
        before = residual;
        double part = allowed(s, N, hits, r);
        if (part == 0) return false;
        for (int k = 0; k < N; k++) {
            size = fmax(size, fmax(fabs(hits[k].y), hits[k].tau));
            for (int j = 0; j < 3; j++) change = fmax(change, fabs(r[3 * k + j]));
            hits[k].y -= part * r[3 * k];
            hits[k].angle -= part * r[3 * k + 1];
            hits[k].tau -= part * r[3 * k + 2];
        }
        if (!(change < ASTRAY)) return false;
        settled += change < NEARLY * size;
        if (change < ROUNDING * size || settled > 3) return true;
    }
    return settled > 0;
}

/* ------------------------------------------------------------------- check */

static bool replay_flight(const ric_impact_map *s, const ric_hit *a, const ric_hit *b)
{
    int n = s->n_dof;
    double w[4];
    ric_real full[2 * n];
    ric_impact impact;
    bool hit;
    memset(full, 0, sizeof full);
    if (!ric_impact_map_state(s, a, w)) return false;
    for (int i = 0; i < 2; i++) {
        full[s->mode[i]] = w[i];
        full[n + s->mode[i]] = w[2 + i];
    }
    double slack = REPLAY * (1 + a->tau) + NEAR_GRAZING / cos(b->angle), later = a->tau + slack;
    if (ric_simulator_start_modal(s->sim, NULL, full) ||
        ric_simulator_advance(s->sim, later, &hit, &impact))
        return false;
    if (!hit || impact.face != b->face || fabs(impact.time - a->tau) > slack) return false;
    ric_simulator_state_modal(s->sim, NULL, full);
    for (int i = 0; i < 2; i++) {
        w[i] = (double)full[s->mode[i]];
        w[2 + i] = (double)full[n + s->mode[i]];
    }
    ric_hit end = hit_of(s, b->face, w);
    return fabs(end.y - b->y) < slack * (1 + fabs(b->y)) && fabs(end.angle - b->angle) < slack;
}

bool ric_impact_map_admissible(const ric_impact_map *s, int N, const ric_hit *hits)
{
    for (int k = 0; k < N; k++)
        if (!(fabs(hits[k].angle) < RIGHT_ANGLE) || !replay_flight(s, &hits[k], &hits[(k + 1) % N]))
            return false;
    return true;
}
