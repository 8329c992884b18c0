/* The monodromy of y = (q, p) of the modes that contacts see which close together, and the orbit
 * does not move. A flight turns each mode, or, while springs are closed, those of Omega^2 + sum k c
 * c' of all members of these contacts. An impact of contact f, of members m whose reflections
 * commute, is met by member m a time -c_m.q / s' early, with s' the speed of all of them, and
 * leaves
 *
 *   q - 2 sum c_m (c_m.q) / cc_m,   p - 2 sum c_m (c_m.p - (s''/s') c_m.q) / cc_m,
 *
 * s'' the acceleration of the gap there: saltation, as in floquet.c, of all of them at once. */
#include "parting.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <lapacke.h>

#include "base/room.h"
#include "model/room.h"

#define ROUNDING                                                                                   \
    16 /* last digits of its largest entry by which a product of maps is off, a flight */

int ric_parting_count(const ric_model *m)
{
    return m->members ? 2 * m->members->n : 0;
}

const char *ric_parting_undefined(const ric_model *m, const ric_periodic *c)
{
    if (!m->members) return NULL;
    if (!ric_periodic_has_events(m)) return "of a power law they are not computed";
    for (int i = 0; i < c->N; i++)
        if (m->face[c->face[i]].spring == 0 && m->members->disturbs[m->face[c->face[i]].contact])
            return "impacts on the two contacts disturb each other, so that what follows depends "
                   "on which comes first";
    return NULL;
}

/* Omega^2 + sum k c c', A [n * n], of the members of closed springs. */
static void stiffness(const ric_model *m, uint64_t closed, double *A)
{
    const ric_members *s = m->members;
    const int n = s->n;
    memset(A, 0, (size_t)n * (size_t)n * sizeof *A);
    for (int i = 0; i < n; i++) A[i * n + i] = s->omega[i] * s->omega[i];
    for (int face = 0; face < m->n_face; face++) {
        const int f = m->face[face].contact, count = s->first[f + 1] - s->first[f];
        if (!ric_face_in(closed, face)) continue;
        for (int a = s->first[f]; a < s->first[f + 1]; a++)
            for (int i = 0; i < n; i++)
                for (int j = 0; j < n; j++)
                    A[i * n + j] += m->face[face].spring / count * s->c[a * n + i] *
                                    s->c[a * n + j];
    }
}

/* A flight of columns Y [2n * 2n], q above p; of A = V diag(omega^2) V'. */
static bool fly(const ric_model *m, uint64_t closed, double tau, double *work, double *Y)
{
    const int n = m->members->n, width = 2 * n;
    double *V = work, *square = V + n * n, *turned = square + n;
    stiffness(m, closed, V);
    if (ric_lapack(LAPACKE_dsyev(LAPACK_ROW_MAJOR, 'V', 'U', n, V, n, square))) return false;
    memset(turned, 0, (size_t)(width * width) * sizeof *turned);
    for (int i = 0; i < n; i++)
        for (int k = 0; k < n; k++)
            for (int j = 0; j < width; j++) {
                turned[i * width + j] += V[k * n + i] * Y[k * width + j];
                turned[(n + i) * width + j] += V[k * n + i] * Y[(n + k) * width + j];
            }
    memset(Y, 0, (size_t)(width * width) * sizeof *Y);
    for (int i = 0; i < n; i++) {
        const double omega = sqrt(fmax(square[i], 0)), c = cos(omega * tau),
                     s = omega > 0 ? sin(omega * tau) / omega : tau;
        for (int j = 0; j < width; j++) {
            const double q = turned[i * width + j], p = turned[(n + i) * width + j],
                         q1 = c * q + s * p, p1 = c * p - omega * omega * s * q;
            for (int k = 0; k < n; k++) {
                Y[k * width + j] += V[k * n + i] * q1;
                Y[(n + k) * width + j] += V[k * n + i] * p1;
            }
        }
    }
    return true;
}

/* An impact of columns y [2n * 2n]; ratio = s'' / s' before it. All members meet what was there
 * before it, in modes that they share with others and alone are not orthogonal. */
static void strike(const ric_members *s, int contact, double ratio, double *Y)
{
    const int n = s->n, width = 2 * n;
    double before[2 * n];
    for (int j = 0; j < width; j++) {
        for (int i = 0; i < width; i++) before[i] = Y[i * width + j];
        for (int a = s->first[contact]; a < s->first[contact + 1]; a++) {
            const double *c = s->c + a * n, q = ric_dot(n, c, before),
                         p = ric_dot(n, c, before + n);
            for (int i = 0; i < n; i++) {
                Y[i * width + j] -= 2 / s->cc[a] * c[i] * q;
                Y[(n + i) * width + j] -= 2 / s->cc[a] * c[i] * (p - ratio * q);
            }
        }
    }
}

/* The map over a period from after impact 0, Y [2n * 2n], of the states W after each event; *noise:
 * its rounding. */
static bool monodromy(const ric_model *m, const ric_periodic *c, const double *W, double *work,
                      double *Y, double *noise)
{
    const int width = 2 * m->members->n;
    double rate[2 * m->n];
    uint64_t closed = c->closed;
    *noise = 0;
    for (int i = 0; i < width * width; i++) Y[i] = i % (width + 1) == 0;
    for (int i = 0; i < c->N; i++) {
        const int next = (i + 1) % c->N;
        const ric_face *face = &m->face[c->face[next]];
        const double *w = W + 2 * m->n * next;
        double largest = 0;
        if (!fly(m, closed, c->tau[i], work, Y)) return false;
        closed = ric_flight_toggle(m, closed, c->face[next]);
        if (face->spring == 0) { /* after the impact the gap opens as fast as it has closed */
            ric_flight_rate(m, closed, w, rate);
            const double speed = -ric_dot(m->n, face->c, w + m->n),
                         acceleration = ric_dot(m->n, face->c, rate + m->n);
            strike(m->members, face->contact, acceleration / speed, Y);
        }
        for (int k = 0; k < width * width; k++) largest = fmax(largest, fabs(Y[k]));
        *noise = fmax(*noise, largest);
    }
    *noise *= ROUNDING * (c->N + 1) * DBL_EPSILON;
    return true;
}

ric_status ric_parting_multipliers(const ric_model *m, const ric_periodic *c, double *out,
                                   double *error)
{
    const int width = ric_parting_count(m);
    const char *why = ric_parting_undefined(m, c);
    const size_t square = (size_t)width * (size_t)width;
    double noise;
    if (why) return ric_fail(RIC_E_INPUT, "%s", why);
    if (width == 0) return RIC_OK;
    double *Y = ric_calloc(3 * square + (size_t)c->N * 2 * (size_t)m->n, sizeof *Y),
           *W = Y ? Y + 3 * square : NULL;
    if (W) ric_periodic_states(m, c, W);
    ric_status status = Y ? RIC_OK : ric_no_memory("disturbances that part contacts");
    if (!status &&
        (!monodromy(m, c, W, Y + square, Y, &noise) || !ric_eigen_conditions(width, Y, out, error)))
        status = ric_fail(RIC_E_NUMERIC, "the multipliers of disturbances that part contacts could "
                                         "not be computed");
    for (int i = 0; i < width && !status; i++) error[i] *= noise;
    free(Y);
    return status;
}

ric_stability ric_parting_stability(int count, const double *l, const double *error)
{
    ric_stability out = RIC_STABLE_YES;
    for (int i = 0; i < count; i++) {
        if (hypot(l[2 * i], l[2 * i + 1]) - error[i] > 1) return RIC_STABLE_NO;
        for (int j = 0; j < i; j++) /* what is alone on the circle cannot leave it */
            if (!(hypot(l[2 * i] - l[2 * j], l[2 * i + 1] - l[2 * j + 1]) > error[i] + error[j]))
                out = RIC_STABLE_UNDECIDED;
        if (!(fabs(hypot(l[2 * i], l[2 * i + 1]) - 1) <= error[i])) out = RIC_STABLE_UNDECIDED;
    }
    return out;
}
