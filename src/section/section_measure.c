#include "section_measure.h"

#include <math.h>

#include "base/room.h"

/* ------------------------------------------------------------------ growth */

double ric_section_measure_growth(ric_section_measure *s, double *u)
{
    int size = 2 * s->m->n;
    double square = ric_dot(size, u, u), length;
    if (square > RIC_SECTION_SHORT && square < RIC_SECTION_LONG) return s->scale + log(square) / 2;
    length = hypot(u[0], u[1]); /* the square may have overflowed */
    for (int i = 2; i < size; i++) length = hypot(length, u[i]);
    if (!(length > 0) || !isfinite(length)) return s->scale;
    for (int i = 0; i < size; i++) u[i] /= length;
    return s->scale += log(length);
}

/* A fixed direction that no structure prefers, made tangent to the energy surface. */
void ric_section_measure_begin(const ric_model *m, const double *w, const double *rate, double *u,
                               ric_section_measure *out)
{
    int n = m->n;
    double gradient[2 * n];
    *out = (ric_section_measure){.m = m, .turning = n == 2};
    for (int i = 0; i < n; i++) {
        gradient[i] = -rate[n + i] / m->kappa[i];
        gradient[n + i] = w[n + i];
    }
    for (int i = 0; i < 2 * n; i++) u[i] = cos(1 + i * M_SQRT2);
    double part = ric_dot(2 * n, gradient, u) / ric_dot(2 * n, gradient, gradient);
    for (int i = 0; i < 2 * n; i++) u[i] -= part * gradient[i];
    out->begin = ric_section_measure_growth(out, u);
}

void ric_section_measure_exponent(const ric_section_measure *s, long impacts, double *exponent,
                                  double *error)
{
    int B = s->n_batch;
    double total = B ? s->time[B - 1] : 0, sum = 0;
    *exponent = *error = NAN;
    if (!(total > 0)) return;
    *exponent = (s->growth[B - 1] - s->begin) / total;
    for (int k = 0; k < B; k++) {
        double from = k ? s->time[k - 1] : 0, before = k ? s->growth[k - 1] : s->begin,
               length = s->time[k] - from;
        double off = length > 0 ? (s->growth[k] - before) / length - *exponent : 0;
        sum += off * off * length / total;
    }
    *error = (B > 1 ? sqrt(sum / (B - 1)) : 0) + log(fmax(2, (double)impacts)) / total;
}

/* ----------------------------------------------------------------- turning */

/* The scale of a mode: its displacement and momentum are of one size then. A free mode has none. */
static double scale_of(const ric_model *m, int i)
{
    return m->omega[i] > 0 ? sqrt(m->omega[i]) : 1;
}

/* G_1 u_2 - G_2 u_1 of displacements x and momenta p of the deviation. */
static void number_of(const ric_model *m, const double *w, const double *rate, const double *x,
                      const double *p, double *c)
{
    double s0 = scale_of(m, 0), s1 = scale_of(m, 1),
           g[4] = {-rate[2] / s0, s0 * w[2], -rate[3] / s1, s1 * w[3]},
           d[4] = {s0 * x[0], p[0] / s0, s1 * x[1], p[1] / s1};
    c[0] = g[0] * d[2] - g[1] * d[3] - g[2] * d[0] + g[3] * d[1];
    c[1] = g[0] * d[3] + g[1] * d[2] - g[2] * d[1] - g[3] * d[0];
}

void ric_section_measure_number(const ric_model *m, const double *w, const double *rate,
                                const double *u, double *c)
{
    number_of(m, w, rate, (double[]){u[0] / m->kappa[0], u[1] / m->kappa[1]}, u + 2, c);
}

/* Displacement y and momentum r along the face of a deviation, moved along the flow onto the face.
 */
static void on_face(const ric_section_measure *s, const ric_face *face, const double *w,
                    const double *rate, const double *u, double *y, double *r)
{
    const double *k = s->m->kappa, norm = sqrt(face->cc),
                 N[2] = {face->c[0] / norm, face->c[1] / norm};
    double x[2] = {u[0] / k[0], u[1] / k[1]},
           dt = -(N[0] * x[0] + N[1] * x[1]) / (N[0] * w[2] + N[1] * w[3]);
    *y = -N[1] * (x[0] + dt * w[2]) + N[0] * (x[1] + dt * w[3]);
    *r = -N[1] * (u[2] + dt * rate[2]) + N[0] * (u[3] + dt * rate[3]);
}

/* Angle of c of the direction (1, 0) on the face, and from there to that of (y, r), in [0, pi)
 * where r >= 0, else in [-pi, 0). */
static void angles(const ric_section_measure *s, const ric_face *face, const double *w,
                   const double *rate, double *first, double *turn)
{
    double norm = sqrt(face->cc), N[2] = {face->c[0] / norm, face->c[1] / norm}, a[2], b[2],
           speed = N[0] * w[2] + N[1] * w[3], along = -N[1] * w[2] + N[0] * w[3],
           lift = (-N[1] * rate[2] + N[0] * rate[3]) / speed, drop = -along / speed;
    number_of(s->m, w, rate, (double[]){-N[1], N[0]}, (double[]){lift * N[0], lift * N[1]}, a);
    number_of(s->m, w, rate, (double[]){0, 0}, (double[]){-N[1] + drop * N[0], N[0] + drop * N[1]},
              b);
    double c[2] = {s->y * a[0] + s->r * b[0], s->y * a[1] + s->r * b[1]};
    double angle = atan2(fabs(a[0] * c[1] - a[1] * c[0]), a[0] * c[0] + a[1] * c[1]);
    *first = atan2(a[1], a[0]);
    *turn = s->r >= 0 ? angle : -angle;
}

void ric_section_measure_arrive(ric_section_measure *s, const ric_face *face, const double *w,
                                const double *rate, const double *u)
{
    double first, turn;
    if (!s->turning) return;
    on_face(s, face, w, rate, u, &s->y, &s->r);
    angles(s, face, w, rate, &first, &turn);
    s->turns = round((s->angle - first - turn) / RIC_TWO_PI);
}

void ric_section_measure_leave(ric_section_measure *s, const ric_face *face, const double *w,
                               const double *rate, const double *u)
{
    double first, turn;
    if (!s->turning) return;
    if (!s->started) on_face(s, face, w, rate, u, &s->y, &s->r);
    angles(s, face, w, rate, &first, &turn);
    s->now = turn + RIC_TWO_PI * s->turns; /* u keeps its direction on the face: its half turn is
                                              that of the arrival */
    s->angle = first + s->now;
    if (!s->started) s->origin = s->now;
    s->started = true;
}

double ric_section_measure_rotation(const ric_section_measure *s, long impacts)
{
    double turns = (s->origin - s->now) / RIC_TWO_PI / (double)impacts;
    return turns - floor(turns);
}
