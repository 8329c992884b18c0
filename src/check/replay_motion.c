/* The motion that a replay expects: the stored orbit in the modal frame of the simulator
 * (verify.c). */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>

#include "verify_parts.h"

real ric_replay_dot(int n, const real *x, const real *y)
{
    real sum = 0;
    for (int i = 0; i < n; i++) sum += x[i] * y[i];
    return sum;
}

real ric_replay_distance(const replay *r, const real *a, const real *b)
{
    real sum = 0;
    for (int i = 0; i < r->n; i++) {
        real q = r->kappa[i] * (a[i] - (b ? b[i] : 0)), p = a[r->n + i] - (b ? b[r->n + i] : 0);
        sum += q * q + p * p;
    }
    return sqrt(sum);
}

bool ric_replay_closed(const replay *r, int k, int f)
{
    return r->closed && r->closed[(size_t)(k % r->n_flight) * (size_t)r->n_face + (size_t)f];
}

void ric_replay_accelerations(const replay *r, int k, const real *w, real *out)
{
    for (int i = 0; i < r->n; i++) out[i] = -r->omega[i] * r->omega[i] * w[i];
    for (int f = 0; f < r->n_face; f++) {
        const face_t *face = &r->face[f];
        if (!ric_replay_closed(r, k, f)) continue;
        real force = face->spring * (ric_replay_dot(r->n, face->c, w) - face->side * face->limit);
        for (int i = 0; i < r->n; i++) out[i] -= force * face->c[i];
    }
}

real ric_replay_rate(const replay *r, int k, const real *w)
{
    real sum = 0, force[r->n];
    ric_replay_accelerations(r, k, w, force);
    for (int i = 0; i < r->n; i++) {
        real q = r->kappa[i] * w[r->n + i], p = force[i];
        sum += q * q + p * p;
    }
    return sqrt(sum);
}

void ric_replay_fly(const replay *r, int k, real t, const real *w, real *after)
{
    int n = r->n;
    if (r->closed) {
        if (ric_simulator_fly(r->sim, r->closed + (size_t)(k % r->n_flight) * (size_t)r->n_face,
                              false, t, w, after))
            for (int i = 0; i < 2 * n; i++) after[i] = NAN;
        return;
    }
    for (int i = 0; i < n; i++) {
        real omega = r->omega[i], q = w[i], p = w[n + i], sine, cosine;
        sincosl(omega * t, &sine, &cosine);
        after[i] = omega > 0 ? q * cosine + p / omega * sine : q + p * t;
        after[n + i] = p * cosine - omega * q * sine;
    }
}

real ric_replay_reflect(const replay *r, const face_t *face, real *w)
{
    real speed = ric_replay_dot(r->n, face->c, w + r->n);
    if (face->spring > 0) return fabs(speed); /* it closes or opens */
    for (int i = 0; i < r->n; i++) w[r->n + i] -= 2 * speed / face->cc * face->c[i];
    return face->side * speed;
}

real ric_replay_gap(const replay *r, const face_t *face, const real *w)
{
    return face->side * ric_replay_dot(r->n, face->c, w) - face->limit;
}

real ric_replay_lever(const replay *r, const face_t *face)
{
    real sum = 0;
    for (int i = 0; i < r->n; i++) sum += face->c[i] / r->kappa[i] * (face->c[i] / r->kappa[i]);
    return sqrt(sum);
}

real ric_replay_fastest(const replay *r, const face_t *face)
{
    return sqrt(2 * r->energy * face->cc);
}

const face_t *ric_replay_end_face(const replay *r, int k)
{
    return r->n_event ? &r->face[r->event[(k + 1) % r->n_event]] : NULL;
}

bool ric_replay_opens(const replay *r, int k)
{
    const face_t *face = ric_replay_end_face(r, k);
    return face && ric_replay_closed(r, k, (int)(face - r->face));
}

real ric_replay_pull(const replay *r, int k, const face_t *face, const real *w)
{
    real force[r->n];
    ric_replay_accelerations(r, k, w, force);
    return -face->side * ric_replay_dot(r->n, face->c, force);
}

bool ric_replay_touches(const replay *r, int k, const face_t *face, const real *w, real speed)
{
    return speed * speed <= 2 * fabs(ric_replay_pull(r, k, face, w)) * r->depth * face->limit ||
           fabs(speed) <= BLUNT * ric_replay_fastest(r, face);
}

bool ric_replay_is_touch(const replay *r, int k)
{
    return ric_replay_touches(r, k, ric_replay_end_face(r, k),
                              r->chain + (size_t)(k + 1) * 2 * (size_t)r->n, r->speed[k + 1]);
}

void ric_replay_make_chain(replay *r)
{
    size_t step = 2 * (size_t)r->n;
    for (int k = 0; k < r->n_flight; k++) {
        real *w = r->chain + (size_t)k * step;
        for (int i = 0; i < r->n; i++) {
            real *cosine = r->trig + (size_t)k * step + i;
            sincosl(r->omega[i] * r->tau[k], cosine + r->n, cosine);
        }
        ric_replay_fly(r, k, r->tau[k], w, w + step);
        if (ric_replay_end_face(r, k))
            r->speed[k + 1] = ric_replay_reflect(r, ric_replay_end_face(r, k), w + step);
    }
}

void ric_replay_fold(replay *r)
{
    size_t step = 2 * (size_t)r->n;
    real w[step];
    memcpy(w, r->chain, sizeof w);
    for (int k = r->n_flight - 1; k >= r->n_flight / 2; k--) {
        const face_t *face = ric_replay_end_face(r, k);
        memcpy(r->chain + (size_t)(k + 1) * step, w, sizeof w);
        real speed = ric_replay_reflect(r, face, w);
        r->speed[k + 1] = face->spring > 0 ? speed : -speed;
        ric_replay_fly(r, k, -r->tau[k], w, w);
    }
}

double ric_replay_part(real error, real of)
{
    return error == 0 ? 0 : of > 0 ? (double)(error / of) : INFINITY;
}

void ric_replay_worsen(double *worst, double error)
{
    if (!(error <= *worst)) *worst = error;
}
