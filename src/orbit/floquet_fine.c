#include "floquet_fine.h"

#include <complex.h>
#include <float.h>
#include <math.h>
#include <string.h>

#define NO_SPEED 1e-60L
#define LATE 1e-10L  /* share of a flight by which its end is moved at most */
#define MET 0x1p-60L /* distance from a spring's face, over the scale, that is none */
/* Steps of Newton's method, of the size of the orbit: DONE is rounding of this precision, and where
 * the steps shrink no more they have come to it, or to nothing if they are longer than GOOD; SLOW:
 * of the step before */
#define DONE 0x1p-64
#define GOOD 0x1p-44
#define SLOW 0.5
/* FEW: modes up to which the basis of a section is made from that in double */
#define FEW 3
#define LARGEST 1e200L /* of an entry: its square is still a double */

typedef ric_fine_real real;
typedef long double _Complex complex_t;

typedef struct {
    const ric_shooting *c;
    int n, k, ld;
    real *P, *V, *E, *w; /* [ld * ld], [2n * ld], [k * n], [2n] the state on the way */
    real *stiff;         /* [n] omega^2 / kappa of each mode */
    const real *tau;     /* [n_flight] times of the flights, NULL: those of the chain */
    uint64_t closed;     /* springs, there */
    real size;
} course;

size_t ric_floquet_fine_size(int n)
{
    size_t k = (size_t)(n > 1 ? n - 1 : 1), ld = 2 * k, nn = (size_t)n;
    return ld * ld + 2 * nn * ld + k * nn + 3 * nn;
}

bool ric_floquet_fine_fits(const ric_shooting *c)
{
    return !ric_flight_law_of(c->model)->integrated && c->n > 1;
}

static real dot(int n, const real *x, const real *y)
{
    real sum = 0;
    for (int i = 0; i < n; i++) sum += x[i] * y[i];
    return sum;
}

/* The same basis to the last digit at once, rows 1.. of the reflection that takes h [n] to a
 * multiple of e_0 (ric_model_complement), and what it makes of columns X [n * ld]: their
 * coordinates are rows 0.. of it then (ric_model_across). */
typedef struct {
    real first, beta;
} reflection;

static reflection reflection_of(int n, const real *h)
{
    const real norm = sqrtl(dot(n, h, h));
    return (reflection){h[0] + copysignl(norm, h[0]), 1 / (norm * (norm + fabsl(h[0])))};
}

static void complement(int n, const real *h, real *E)
{
    const reflection q = reflection_of(n, h);
    for (int i = 1; i < n; i++)
        for (int j = 0; j < n; j++)
            E[(i - 1) * n + j] = (i == j) - q.beta * h[i] * (j ? h[j] : q.first);
    for (int j = 0; h[0] < 0 && j < n; j++) E[j] = -E[j];
}

static void across(int n, const real *h, int ld, real *X)
{
    const reflection q = reflection_of(n, h);
    real along[ld];
    for (int j = 0; j < ld; j++) along[j] = q.first * X[j];
    for (int i = 1; i < n; i++)
        for (int j = 0; j < ld; j++) along[j] += h[i] * X[i * ld + j];
    for (int j = 0; j < ld; j++) along[j] *= q.beta;
    for (int i = 1; i < n; i++)
        for (int j = 0; j < ld; j++) X[(i - 1) * ld + j] = X[i * ld + j] - h[i] * along[j];
    for (int j = 0; h[0] < 0 && j < ld; j++) X[j] = -X[j];
}

/* The basis in double, made orthonormal and perpendicular to h [n] to the last digit. */
static void sharpen(course *q, const double *E, const real *h)
{
    int n = q->n;
    real hh = dot(n, h, h);
    for (int j = 0; j < q->k; j++) {
        real *row = q->E + j * n;
        for (int i = 0; i < n; i++) row[i] = E[j * n + i];
        real off = hh > 0 ? dot(n, h, row) / hh : 0;
        for (int i = 0; i < n; i++) row[i] -= off * h[i];
        for (int l = 0; l < j; l++) {
            off = dot(n, q->E + l * n, row);
            for (int i = 0; i < n; i++) row[i] -= off * q->E[l * n + i];
        }
        real norm = sqrtl(dot(n, row, row));
        for (int i = 0; i < n; i++) row[i] /= norm;
    }
}

/* How far a state is beyond a face. */
static real beyond(const course *q, const ric_face *f, const real *w)
{
    real over = -(real)f->gap;
    for (int i = 0; i < q->n; i++) over += f->c[i] / (real)q->c->model->kappa[i] * w[i];
    return over;
}

/* omega^2 q of each mode and what closed springs add, that is -dp/dt. */
static void pulls(const course *q, real *out)
{
    const ric_model *m = q->c->model;
    for (int i = 0; i < q->n; i++) out[i] = q->stiff[i] * q->w[i];
    for (int g = 0; q->closed >> g; g++) {
        const ric_face *f = &m->face[g];
        if (!ric_face_in(q->closed, g)) continue;
        real over = beyond(q, f, q->w);
        for (int i = 0; i < q->n; i++) out[i] += f->spring * over * f->c[i];
    }
}

static real not_zero(real speed)
{
    return fabsl(speed) < NO_SPEED ? copysignl(NO_SPEED, speed) : speed;
}

/* c . x. */
static real along(const course *q, const ric_face *f, const real *x)
{
    real sum = 0;
    for (int i = 0; i < q->n; i++) sum += f->c[i] * x[i];
    return sum;
}

static real square(const course *q, const ric_face *f)
{
    real sum = 0;
    for (int i = 0; i < q->n; i++) sum += (real)f->c[i] * f->c[i];
    return sum;
}

/* A mirror point at an impact: normal displacement and velocity of V [2n * count] exchange their
 * roles (floquet.c). */
static void exchange(const course *q, const ric_face *f, bool back, int count, real *V)
{
    int n = q->n;
    const double *kappa = q->c->model->kappa;
    real pull[n], length = sqrtl(square(q, f));
    pulls(q, pull);
    real slope = -along(q, f, pull) / not_zero(along(q, f, q->w + n));
    for (int j = 0; j < count; j++) {
        real s = 0, p = 0;
        for (int i = 0; i < n; i++) {
            s += f->c[i] / (real)kappa[i] * V[i * count + j] / length;
            p += f->c[i] * V[(n + i) * count + j] / length;
        }
        real x = back ? -p : p - slope * s, y = back ? s - slope * p : -s;
        for (int i = 0; i < n; i++) {
            V[i * count + j] += (x - s) * kappa[i] * f->c[i] / length;
            V[(n + i) * count + j] += (y - p) * f->c[i] / length;
        }
    }
}

/* What the section at the present state leaves out, h = rate + n of rate [2n]. */
static void left_out(const course *q, ric_mirror mirror, int face, real *rate)
{
    int n = q->n;
    real *h = rate + n;
    pulls(q, h);
    for (int i = 0; i < n; i++) {
        rate[i] = q->c->model->kappa[i] * q->w[n + i];
        h[i] = mirror == RIC_MIRROR_CENTRE ? q->w[n + i] : -h[i];
    }
    if (mirror == RIC_MIRROR_IMPACT) exchange(q, &q->c->model->face[face], false, 1, rate);
}

/* The basis E of the section at the present state, to the last digit. */
static void section(course *q, ric_mirror mirror, int face, const double *E)
{
    real rate[2 * q->n];
    left_out(q, mirror, face, rate);
    if (q->n > FEW) complement(q->n, rate + q->n, q->E);
    else sharpen(q, E, rate + q->n);
}

static void start_columns(course *q, ric_mirror mirror, int face)
{
    int n = q->n, k = q->k, ld = q->ld;
    const ric_model *m = q->c->model;
    memset(q->V, 0, (size_t)2 * (size_t)n * (size_t)ld * sizeof *q->V);
    for (int j = 0; j < k; j++)
        for (int i = 0; i < n; i++) {
            q->V[i * ld + j] = m->kappa[i] * q->E[j * n + i];
            q->V[(n + i) * ld + k + j] = q->E[j * n + i];
        }
    if (mirror == RIC_MIRROR_IMPACT) exchange(q, &m->face[face], true, ld, q->V);
}

/* Displacements a and velocities p [count] of one mode, by its cosine and its two sines. */
static void turn(int count, const real *by, real *a, real *p)
{
    for (int j = 0; j < count; j++) {
        real t = a[j];
        a[j] = by[0] * t + by[1] * p[j];
        p[j] = by[0] * p[j] - by[2] * t;
    }
}

/* A state w [2n] through a flight, and, unless NULL, deviations V [2n * ld]: sines of this
 * precision are dear, and the same for both. False: no memory for the modes of its springs. */
static bool fly(const course *q, real tau, real *w, real *V)
{
    const ric_model *m = q->c->model;
    if (q->closed) return ric_flight_fine(m, q->closed, tau, w, q->ld, V);
    for (int i = 0; i < q->n; i++) {
        real omega = (real)m->omega[i] + m->omega_low[i], kappa = m->kappa[i], s,
             by[3] = {1, tau, 0};
        if (m->omega[i] > 0) {
            ric_sine_cosine_fine(omega * tau, &s, &by[0]);
            by[1] = kappa * s / omega;
            by[2] = omega * s / kappa;
        }
        turn(1, by, w + i, w + q->n + i);
        if (V) turn(q->ld, by, V + i * q->ld, V + (q->n + i) * q->ld);
    }
    return true;
}

/* Moves the end of the flight from w to where the spring of a face opens. What a rounded time
 * leaves between state and face, times the stiffness, is a force that ends with a jump, and a
 * product of flights that end so takes no flow to flow: beside a spring of 4,400 times the
 * stiffness of the modes a trace of 2 became 2 - 9e-12. Of a slow touch the time says more than the
 * gap, and is left as it is. False: no memory. */
static bool meet(const course *q, const ric_face *f, real *tau)
{
    enum { STEPS = 6 };
    int n = q->n;
    real w[2 * n], over, meant = *tau;
    for (int step = 0; step < STEPS; step++) {
        memcpy(w, q->w, sizeof w);
        if (!fly(q, *tau, w, NULL)) return false;
        over = beyond(q, f, w);
        if (fabsl(over) <= MET * (1 + fabs(f->gap))) return true;
        *tau -= over / along(q, f, w + n);
        if (!(fabsl(*tau - meant) <= LATE * meant)) break;
    }
    *tau = meant;
    return true;
}

/* What starts on the face of a spring is there to the last digit, and pushes with nothing. */
static void begin_on(course *q, const ric_face *f)
{
    const double *kappa = q->c->model->kappa;
    real over = beyond(q, f, q->w), size = 0;
    for (int i = 0; i < q->n; i++) size += f->c[i] / (real)kappa[i] * f->c[i] / kappa[i];
    for (int i = 0; i < q->n; i++) q->w[i] -= over / size * f->c[i] / kappa[i];
}

static void grow(course *q, int count, const real *X)
{
    real size = q->size;
    for (int i = 0; i < count; i++) {
        const real entry = fabsl(X[i]);
        if (entry > size) size = entry;
    }
    q->size = size;
}

/* A state through an impact. */
static void bounce(const course *q, const ric_face *f)
{
    real twice = 2 * along(q, f, q->w + q->n) / square(q, f);
    for (int i = 0; i < q->n; i++) q->w[q->n + i] -= twice * f->c[i];
}

/* State and columns through an impact (saltation, eq. 41-46 of the article). */
static void strike(course *q, const ric_face *f)
{
    const ric_model *m = q->c->model;
    int n = q->n, ld = q->ld;
    real pull[n], c[n], cc = square(q, f), normal = along(q, f, q->w + n), speed = not_zero(normal);
    pulls(q, pull);
    real kick = -2 * along(q, f, pull) / (cc * speed);
    for (int i = 0; i < n; i++) c[i] = f->c[i] / (real)m->kappa[i];
    for (int j = 0; j < ld; j++) {
        real gap = 0, push = 0;
        for (int i = 0; i < n; i++) {
            gap += c[i] * q->V[i * ld + j];
            push += f->c[i] * q->V[(n + i) * ld + j];
        }
        real dq = 2 * gap / cc, dp = 2 * push / cc - kick * gap;
        for (int i = 0; i < n; i++) {
            q->V[i * ld + j] -= dq * m->kappa[i] * f->c[i];
            q->V[(n + i) * ld + j] -= dp * f->c[i];
        }
    }
    bounce(q, f);
    grow(q, 2 * q->n * q->ld, q->V);
}

/* The same of more than FEW modes, for which V is used up: n^2 operations and not n^3. */
static void project_across(course *q, ric_mirror mirror, int face)
{
    int n = q->n, k = q->k, ld = q->ld;
    const double *kappa = q->c->model->kappa;
    real rate[2 * n], *h = rate + n, *a = q->V, *p = q->V + n * ld;
    left_out(q, mirror, face, rate);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < ld && kappa[i] != 1; j++) a[i * ld + j] /= kappa[i];
    across(n, h, ld, a);
    across(n, h, ld, p);
    memcpy(q->P, a, (size_t)(k * ld) * sizeof *q->P);
    memcpy(q->P + k * ld, p, (size_t)(k * ld) * sizeof *q->P);
}

static void project(course *q)
{
    int n = q->n, k = q->k, ld = q->ld;
    const ric_model *m = q->c->model;
    memset(q->P, 0, (size_t)(ld * ld) * sizeof *q->P);
    for (int r = 0; r < k; r++)
        for (int i = 0; i < n; i++)
            for (int j = 0; j < ld; j++) {
                q->P[r * ld + j] += q->E[r * n + i] * q->V[i * ld + j] / m->kappa[i];
                q->P[(k + r) * ld + j] += q->E[r * n + i] * q->V[(n + i) * ld + j];
            }
}

/* Rows 1.. of the Householder reflection that takes eta [n] to a multiple of e_0, [k * n]: eta is
 * overwritten. */
static void unitary_complement(int n, complex_t *eta, complex_t *e)
{
    real norm = 0, lead = cabsl(eta[0]);
    for (int i = 0; i < n; i++)
        norm += creall(eta[i]) * creall(eta[i]) + cimagl(eta[i]) * cimagl(eta[i]);
    norm = sqrtl(norm);
    eta[0] += lead > 0 ? eta[0] / lead * norm : norm;
    real beta = 1 / (norm * (norm + lead));
    for (int j = 1; j < n; j++)
        for (int i = 0; i < n; i++) e[(j - 1) * n + i] = (i == j) - beta * eta[i] * conjl(eta[j]);
}

/* Columns perpendicular to flow and gradient, and inner products with those that they started as
 * (the free section of floquet.c): on the face of the first impact the entries of the map would go
 * with 1 / speed, and with them what the orbit's rounding leaves open of its closure. */
static void around(course *q, const complex_t *e, bool start)
{
    int n = q->n, k = q->k, ld = q->ld;
    const double *kappa = q->c->model->kappa;
    if (!start) memset(q->P, 0, (size_t)(ld * ld) * sizeof *q->P);
    for (int j = 0; j < k; j++)
        for (int i = 0; i < n; i++) {
            real re = creall(e[j * n + i]), im = cimagl(e[j * n + i]);
            real *a = q->V + i * ld, *p = q->V + (n + i) * ld;
            if (start) {
                a[j] = kappa[i] * re;
                p[j] = im;
                a[k + j] = -kappa[i] * im;
                p[k + j] = re;
                continue;
            }
            for (int l = 0; l < ld; l++) {
                q->P[j * ld + l] += re / kappa[i] * a[l] + im * p[l];
                q->P[(k + j) * ld + l] += re * p[l] - im / kappa[i] * a[l];
            }
        }
}

/* False: no memory. */
static bool flights(course *q)
{
    const ric_shooting *c = q->c;
    real early = 0;
    for (int k = 0; k < c->n_flight; k++) {
        const ric_face *next = c->face[k + 1] < 0 ? NULL : &c->model->face[c->face[k + 1]];
        real tau = (q->tau ? q->tau[k] : c->tau[k]) + early, meant = tau;
        q->closed = c->closed[k];
        const bool spring = next && next->spring > 0,
                   closes = spring && ric_face_in(c->closed[k + 1], c->face[k + 1]);
        if (spring && !closes && !meet(q, next, &tau)) return false;
        early = meant - tau;
        if (!fly(q, tau, q->w, q->V)) return false;
        if (next && next->spring == 0 && !(k + 1 == c->n_flight && c->end == RIC_MIRROR_IMPACT))
            strike(q, next);
        else if (q->closed) grow(q, 2 * q->n * q->ld, q->V);
        if (closes) begin_on(q, next);
    }
    q->closed = c->closed[c->n_flight];
    return true;
}

/* The map of the general form. */
static bool return_map(course *q)
{
    int n = q->n;
    real pull[n];
    complex_t eta[n], e[q->k * n];
    pulls(q, pull);
    for (int i = 0; i < n; i++) eta[i] = pull[i] + q->w[n + i] * I;
    unitary_complement(n, eta, e);
    around(q, e, true);
    if (!flights(q)) return false;
    around(q, e, false);
    return true;
}

/* --------------------------------------------------------------------- the orbit */

/* The start state of unknowns u. Returns what it leaves of the condition of a start on a face. */
static real start_state(const course *q, const real *u)
{
    const ric_shooting *c = q->c;
    const int n = q->n;
    const ric_face *face = c->face[0] >= 0 ? &c->model->face[c->face[0]] : NULL;
    real *a = q->w, *p = q->w + n;
    for (int i = 0; i < n; i++) {
        a[i] = c->start == RIC_MIRROR_CENTRE ? 0 : u[i];
        p[i] = c->start == RIC_MIRROR_CENTRE ? u[i] : c->start == RIC_MIRROR_NONE ? u[n + i] : 0;
        if (c->start == RIC_MIRROR_IMPACT)
            p[i] = -face->side * u[n] / sqrtl(square(q, face)) * face->c[i];
    }
    return face ? beyond(q, face, q->w) : 0;
}

/* What the end, the present state, leaves of its conditions. */
static void end_left(course *q, const real *first, double *left)
{
    const ric_shooting *c = q->c;
    const int n = q->n;
    real *p = q->w + n;
    if (c->end == RIC_MIRROR_IMPACT) {
        const ric_face *f = &c->model->face[c->face[c->n_flight]];
        const real off = along(q, f, p) / square(q, f);
        for (int i = 0; i < n; i++) p[i] -= off * f->c[i];
        for (int j = 0; j < n - 1; j++) {
            real sum = 0;
            for (int i = 0; i < n; i++) sum += f->E[j * n + i] * p[i];
            left[j] = (double)sum;
        }
        return;
    }
    for (int i = 0; i < n && c->end != RIC_MIRROR_NONE; i++)
        left[i] = (double)(c->end == RIC_MIRROR_REST ? p[i] : q->w[i]);
    for (int i = 0; i < 2 * n && c->end == RIC_MIRROR_NONE; i++)
        left[i] = (double)(q->w[i] - c->sigma * first[i]);
}

/* What u leaves of all equations (shooting.h). False: no memory. */
static bool all_left(course *q, const real *u, double *left)
{
    const ric_shooting *c = q->c;
    const ric_face *faces = c->model->face;
    real first[2 * q->n];
    left[0] = (double)start_state(q, u);
    memcpy(first, q->w, sizeof first);
    for (int k = 0; k < c->n_flight; k++) {
        const int at = c->face[k], to = c->face[k + 1];
        const real tau = u[c->n_start + k];
        q->closed = c->closed[k];
        if (ric_face_in(q->closed, at)) begin_on(q, &faces[at]);
        const real from = to >= 0 ? beyond(q, &faces[to], q->w) : 0;
        if (!fly(q, tau, q->w, NULL)) return false;
        const real over = to >= 0 ? beyond(q, &faces[to], q->w) : 0;
        left[1 + k] = (double)(ric_shooting_between(c, k) ? (over - from) / tau : over);
        if (to >= 0 && faces[to].spring == 0 &&
            !(k + 1 == c->n_flight && c->end == RIC_MIRROR_IMPACT))
            bounce(q, &faces[to]);
    }
    end_left(q, first, left + 1 + c->n_flight);
    return true;
}

/* Newton's method in extended precision from the chain's u to x [n_unknown]. */
static bool solve(course *q, ric_shooting *c, const double *u, real *x, double *moved)
{
    enum { STEPS = 8 };
    const int size = c->n_unknown;
    double left[1 + c->n_flight + 2 * c->n], du[size], length = HUGE_VAL, last;
    for (int i = 0; i < size; i++) x[i] = u[i];
    for (int step = 0; step < STEPS && length > DONE * c->scale; step++) {
        if (!all_left(q, x, left)) break;
        ric_shooting_evaluate_left(c, u, left);
        if (c->singular) break;
        ric_shooting_step(c, true, 0, du);
        last = length;
        length = sqrt(ric_dot(size, du, du));
        if (step == 0) *moved = length;
        if (!(length < SLOW * last)) break;
        for (int i = 0; i < size; i++) x[i] += du[i];
    }
    ric_shooting_evaluate(c, u);
    return length <= GOOD * c->scale;
}

bool ric_floquet_fine_orbit(ric_shooting *c, const double *u, ric_fine_real *orbit, double *moved)
{
    course q = {.c = c, .n = c->n, .w = orbit};
    real x[c->n_unknown];
    const bool found = solve(&q, c, u, x, moved);
    start_state(&q, x);
    for (int k = 0; k < c->n_flight; k++) orbit[2 * c->n + k] = x[c->n_start + k];
    return found;
}

bool ric_floquet_fine_nearest(ric_shooting *c, double *u)
{
    real w[2 * c->n], x[c->n_unknown];
    course q = {.c = c, .n = c->n, .w = w};
    double moved;
    if (!ric_floquet_fine_fits(c) || !solve(&q, c, u, x, &moved)) return false;
    for (int i = 0; i < c->n_unknown; i++) u[i] = (double)x[i];
    ric_shooting_evaluate(c, u);
    return true;
}

/* ----------------------------------------------------------------------- the map */

bool ric_floquet_fine_map(const ric_shooting *c, const real *orbit, const double *start,
                          const double *end, ric_fine_real *store, double *size)
{
    int n = c->n, k = n - 1, ld = 2 * k, last = c->n_flight;
    const ric_model *m = c->model;
    course q = {.c = c, .n = n, .k = k, .ld = ld, .P = store, .closed = c->closed[0], .size = 1};
    q.V = q.P + ld * ld;
    q.E = q.V + 2 * n * ld;
    q.w = q.E + k * n;
    q.stiff = q.w + 2 * n;
    for (int i = 0; i < n; i++) {
        ric_fine_real omega = (ric_fine_real)m->omega[i] + m->omega_low[i];
        q.stiff[i] = omega * omega / m->kappa[i];
    }
    for (int i = 0; i < 2 * n; i++) q.w[i] = orbit ? orbit[i] : c->w[i];
    q.tau = orbit ? orbit + 2 * n : NULL;
    if (c->face[0] >= 0 && m->face[c->face[0]].spring > 0) begin_on(&q, &m->face[c->face[0]]);
    if (c->start == RIC_MIRROR_NONE) {
        if (!return_map(&q)) return false;
    } else {
        section(&q, c->start, c->face[0], start);
        start_columns(&q, c->start, c->face[0]);
        if (!flights(&q)) return false;
        if (c->end == RIC_MIRROR_IMPACT) exchange(&q, &m->face[c->face[last]], false, ld, q.V);
        if (n > FEW) project_across(&q, c->end, c->face[last]);
        else {
            section(&q, c->end, c->face[last], end);
            project(&q);
        }
    }
    grow(&q, ld * ld, q.P);
    *size = (double)q.size;
    return q.size < LARGEST; /* false for what is no number */
}
