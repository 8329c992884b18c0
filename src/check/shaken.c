/* Event-driven motion of M x'' + C x' + K x = L f cos(Omega t + phase) between stops and springs.
 *
 * It shares no code with the solver of forced orbits and needs no modes: between two events the
 * state together with cos, sin and 1 obeys a linear system with constant coefficients, whose
 * exponential is summed in extended precision, in panels in which the fastest motion turns by less
 * than a radian (Moler and Van Loan, SIAM Rev. 45 (2003)). The terms of that sum are the Taylor
 * coefficients of every gap: in a panel a gap is a polynomial, and the first time at which it is
 * closed is found by bisection under a bound of its second derivative, so that none is overlooked.
 *
 * Under power laws the extrapolation of Gragg, Bulirsch and Stoer is used on the same equations. */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>

#include "base/room.h"
#include "shaken.h"

#define TURN 0.7L /* rad that the fastest motion makes in a panel */
/* STUCK: speed after an impact, relative to the largest, that ends in a lasting contact */
#define STUCK 1e-9
#define TOLERANCE 1e-17L /* of a step of extrapolation, relative */

enum { TERMS = 44, LEVELS = 11, AIM = 7, DEEPEST = 70, STEPS_MOST = 1000000 };

typedef ric_real real;

typedef struct {
    int contact, side;
    real limit, spring, cc;
    bool closed;
    const real *b;  /* [n] */
    const real *mb; /* [n] M^-1 b */
} face_t;

struct ric_shaken {
    int n, n_face, n_contact;
    real restitution, omega;
    real *A, *C, *f; /* M^-1 K, M^-1 C [n * n], M^-1 f L / d [n] */
    real *b, *mb;    /* [n_contact * n] */
    real *power;     /* [n_contact] power law: force on scaled s, 0 otherwise */
    int *exponent;
    face_t *face;
    real *y;     /* [2n + 2] x, v, cos, sin of the force */
    real *terms; /* [TERMS * (2n + 2)] */
    real *table; /* [(LEVELS + 4) * 2n] */
    real time, step, fastest;
    int own; /* the face that an event has just been on, -1: none */
    real *store;
};

void ric_shaken_free(ric_shaken *s)
{
    if (!s) return;
    free(s->store);
    free(s->exponent);
    free(s->face);
    free(s);
}

/* ------------------------------------------------------------------ create */

/* X <- M^-1 X, of columns; L the factor of M. */
static void divide(int n, const real *L, int ld, real *X)
{
    for (int j = 0; j < ld; j++) {
        for (int i = 0; i < n; i++) {
            for (int k = 0; k < i; k++) X[i * ld + j] -= L[i * n + k] * X[k * ld + j];
            X[i * ld + j] /= L[i * n + i];
        }
        for (int i = n - 1; i >= 0; i--) {
            for (int k = i + 1; k < n; k++) X[i * ld + j] -= L[k * n + i] * X[k * ld + j];
            X[i * ld + j] /= L[i * n + i];
        }
    }
}

/* Damping matrix C [n * n] in physical units from ratios: sum 2 zeta_i omega_i (M phi_i)(M phi_i)'.
 */
static ric_status make_matrix(const ric_model *model, int n_ratio, const double *ratios, double *C)
{
    const int n = ric_model_n_dof(model);
    const double *M = ric_model_mass(model);
    double omega[n], *Phi = ric_calloc(2 * (size_t)n * (size_t)n, sizeof *Phi),
                     *P = Phi + (size_t)n * (size_t)n;
    if (!Phi) return ric_no_memory("a damping matrix");
    ric_status status = ric_model_frequencies(model, omega);
    if (!status) status = ric_model_modes(model, Phi);
    for (int a = 0; a < n && !status; a++)
        for (int i = 0; i < n; i++)
            for (int k = 0; k < n; k++) P[a * n + i] += M[a * n + k] * Phi[k * n + i];
    for (int a = 0; a < n && !status; a++)
        for (int b = 0; b < n; b++) {
            C[a * n + b] = 0;
            for (int i = 0; i < n; i++)
                C[a * n + b] += P[a * n + i] * 2 * ratios[n_ratio > 1 ? i : 0] * omega[i] *
                                P[b * n + i];
        }
    free(Phi);
    return status;
}

static void take_contacts(ric_shaken *s, const ric_model *model)
{
    const int n = s->n;
    const real d = ric_model_length(model);
    for (int k = 0; k < s->n_contact; k++) {
        ric_contact c;
        ric_model_contact(model, k, &c);
        for (int i = 0; i < n; i++) s->b[k * n + i] = s->mb[k * n + i] = c.normal[i];
        s->exponent[k] = c.exponent;
        if (c.law == RIC_LAW_POWER)
            s->power[k] = c.length > 0 ? c.reference * pow(d / c.length, c.exponent - 1)
                                       : c.stiffness * pow(d, c.exponent - 1);
        for (int side = 1; side >= -1 && c.law != RIC_LAW_POWER; side -= 2) {
            if (c.sides == (side > 0 ? RIC_SIDES_LOWER : RIC_SIDES_UPPER)) continue;
            s->face[s->n_face++] = (face_t){.contact = k,
                                            .side = side,
                                            .limit = c.clearance / d,
                                            .spring = c.law == RIC_LAW_BILINEAR ? c.stiffness : 0,
                                            .b = s->b + k * n,
                                            .mb = s->mb + k * n};
        }
    }
}

static real norm(int n, const real *A)
{
    real most = 0;
    for (int i = 0; i < n; i++) {
        real sum = 0;
        for (int j = 0; j < n; j++) sum += fabs(A[i * n + j]);
        most = fmax(most, sum);
    }
    return most;
}

static real dot(int n, const real *x, const real *y)
{
    real sum = 0;
    for (int i = 0; i < n; i++) sum += x[i] * y[i];
    return sum;
}

static bool make_store(ric_shaken *s)
{
    const size_t n = (size_t)s->n, k = (size_t)s->n_contact;
    s->store = ric_calloc(2 * n * n + n + k * (2 * n + 1) + (2 * n + 2) * (TERMS + 1) +
                              (LEVELS + 4) * 2 * n,
                          sizeof *s->store);
    s->exponent = ric_calloc(k + 1, sizeof *s->exponent);
    s->face = ric_calloc(2 * k + 1, sizeof *s->face);
    if (!s->store || !s->exponent || !s->face) return false;
    s->A = s->store;
    s->C = s->A + n * n;
    s->f = s->C + n * n;
    s->b = s->f + n;
    s->mb = s->b + k * n;
    s->power = s->mb + k * n;
    s->y = s->power + k;
    s->terms = s->y + 2 * n + 2;
    s->table = s->terms + (2 * n + 2) * TERMS;
    return true;
}

ric_status ric_shaken_create(const ric_model *model, const ric_shaking *shaking, double omega,
                             double level, ric_shaken **out)
{
    const int n = ric_model_n_dof(model);
    const size_t nn = (size_t)n * (size_t)n;
    ric_shaken *s = ric_calloc(1, sizeof *s);
    double *C = ric_calloc(nn, sizeof *C);
    real *L = ric_calloc(nn, sizeof *L);
    ric_status status = RIC_OK;
    *out = NULL;
    if (s) *s = (ric_shaken){.n = n, .n_contact = ric_model_n_contact(model), .own = -1};
    if (!s || !C || !L || !make_store(s)) {
        status = ric_no_memory("a simulation");
        goto out;
    }
    s->restitution = shaking->restitution;
    s->omega = omega;
    if (shaking->matrix) memcpy(C, shaking->matrix, nn * sizeof *C);
    else if (shaking->ratios && (status = make_matrix(model, shaking->n_ratio, shaking->ratios, C)))
        goto out;
    for (size_t i = 0; i < nn; i++) {
        L[i] = ric_model_mass(model)[i];
        s->A[i] = ric_model_stiffness(model)[i];
        s->C[i] = C[i];
    }
    for (int i = 0; i < n && shaking->force; i++)
        s->f[i] = (real)level * shaking->force[i] / ric_model_length(model);
    if (!ric_simulator_cholesky(n, L)) {
        status = ric_fail(RIC_E_NUMERIC, "the mass matrix is not positive definite");
        goto out;
    }
    take_contacts(s, model);
    divide(n, L, n, s->A);
    divide(n, L, n, s->C);
    divide(n, L, 1, s->f);
    for (int k = 0; k < s->n_contact; k++) divide(n, L, 1, s->mb + k * n);
    for (int f = 0; f < s->n_face; f++) s->face[f].cc = dot(n, s->face[f].b, s->face[f].mb);
    real square = norm(n, s->A);
    for (int f = 0; f < s->n_face; f++) square += s->face[f].spring * s->face[f].cc;
    s->fastest = sqrt(square) + norm(n, s->C) + fabs(s->omega);
    *out = s;
    s = NULL;
out:
    free(C);
    free(L);
    ric_shaken_free(s);
    return status;
}

/* -------------------------------------------------------------------- state */

ric_status ric_shaken_start_long(ric_shaken *s, const real *y, real phase)
{
    memcpy(s->y, y, 2 * (size_t)s->n * sizeof *y);
    s->y[2 * s->n] = cos(phase);
    s->y[2 * s->n + 1] = sin(phase);
    s->time = s->step = 0;
    s->own = -1;
    for (int f = 0; f < s->n_face; f++) {
        face_t *face = &s->face[f];
        const real gap = face->side * dot(s->n, face->b, y);
        face->closed = face->spring > 0 && gap > face->limit;
        /* a state right after an impact, which rounding has put beyond the stop, leaves it */
        if (!(face->spring > 0) && gap > face->limit &&
            face->side * dot(s->n, face->b, y + s->n) < 0)
            s->own = f;
        if (face->spring > 0 || gap <= face->limit * (1 + STUCK)) continue;
        return ric_fail(RIC_E_INPUT, "state: face %d is passed by %.3g; start on this side of it",
                        f, (double)(gap - face->limit));
    }
    return RIC_OK;
}

ric_status ric_shaken_start(ric_shaken *s, const double *x, const double *v, double phase)
{
    real y[2 * s->n];
    for (int i = 0; i < s->n; i++) {
        y[i] = x[i];
        y[s->n + i] = v[i];
    }
    return ric_shaken_start_long(s, y, phase);
}

void ric_shaken_close(ric_shaken *s, int face)
{
    s->own = face;
    if (face < 0 || !(s->face[face].spring > 0)) return;
    s->face[face].closed = s->face[face].side * dot(s->n, s->face[face].b, s->y + s->n) > 0;
}

void ric_shaken_closed(const ric_shaken *s, bool *closed)
{
    for (int f = 0; f < s->n_face; f++) closed[f] = s->face[f].closed;
}

void ric_shaken_set(ric_shaken *s, const bool *closed)
{
    for (int f = 0; f < s->n_face; f++) s->face[f].closed = closed[f];
}

void ric_shaken_state_long(const ric_shaken *s, real *time, real *y)
{
    if (time) *time = s->time;
    memcpy(y, s->y, 2 * (size_t)s->n * sizeof *y);
}

void ric_shaken_state(const ric_shaken *s, double *time, double *x, double *v)
{
    if (time) *time = (double)s->time;
    for (int i = 0; i < s->n; i++) {
        x[i] = (double)s->y[i];
        v[i] = (double)s->y[s->n + i];
    }
}

/* -------------------------------------------------------------------- panels */

/* Taylor coefficients of the state in u = t / h. */
static void expand(ric_shaken *s, real h)
{
    const int n = s->n, size = 2 * n + 2;
    memcpy(s->terms, s->y, (size_t)size * sizeof *s->terms);
    for (int j = 0; j + 1 < TERMS; j++) {
        const real *y = s->terms + j * size, factor = h / (j + 1);
        real *next = s->terms + (j + 1) * size;
        for (int i = 0; i < n; i++) {
            next[i] = factor * y[n + i];
            next[n + i] = factor * (s->f[i] * y[2 * n] - dot(n, s->A + i * n, y) -
                                    dot(n, s->C + i * n, y + n));
        }
        next[2 * n] = -factor * s->omega * y[2 * n + 1];
        next[2 * n + 1] = factor * s->omega * y[2 * n];
        for (int f = 0; f < s->n_face; f++) {
            const face_t *face = &s->face[f];
            if (!face->closed) continue;
            const real push = factor * face->spring *
                              (dot(n, face->b, y) - (j ? 0 : face->side * face->limit));
            for (int i = 0; i < n; i++) next[n + i] -= push * face->mb[i];
        }
    }
}

static void move(ric_shaken *s, real u, real h)
{
    const int size = 2 * s->n + 2;
    for (int i = 0; i < size; i++) {
        real sum = s->terms[(TERMS - 1) * size + i];
        for (int j = TERMS - 2; j >= 0; j--) sum = sum * u + s->terms[j * size + i];
        s->y[i] = sum;
    }
    s->time += u * h;
}

/* A gap in a panel: above 0 beyond the face, of a closed one on its open side. */
typedef struct {
    real c[TERMS], bend;
} poly;

static poly gap_of(const ric_shaken *s, const face_t *face)
{
    const int n = s->n, size = 2 * n + 2;
    poly p = {.bend = 0};
    const real sign = face->closed ? -face->side : face->side;
    for (int j = 0; j < TERMS; j++) {
        p.c[j] = sign * dot(n, face->b, s->terms + j * size);
        p.bend += j * (j - 1) * fabs(p.c[j]);
    }
    p.c[0] -= face->closed ? -face->limit : face->limit;
    return p;
}

static real value(const poly *p, real u, real *slope)
{
    real sum = 0, derivative = 0;
    for (int j = TERMS - 1; j >= 0; j--) {
        derivative = derivative * u + sum;
        sum = sum * u + p->c[j];
    }
    *slope = derivative;
    return sum;
}

/* The first u in (a, b] at which the gap comes above 0 from below; 2: none. */
static real first_above(const poly *p, real a, real b, int depth)
{
    real up_a, up_b, middle = a + (b - a) / 2;
    const real at_a = value(p, a, &up_a), at_b = value(p, b, &up_b), most = p->bend * (b - a);
    if (at_a < 0 && at_b < 0 && fmax(at_a, at_b) + most * (b - a) / 8 < 0) return 2;
    if (at_a <= 0 && up_a + most < 0) return 2; /* it falls throughout */
    if (at_b <= 0 && (up_b - most > 0 || up_a - most > 0))
        return at_b == 0 && up_b > 0 ? b : 2;                           /* it rises */
    if (at_a < 0 && at_b > 0 && (up_a - most > 0 || up_b - most > 0)) { /* rises once: bisection */
        for (int k = 0; k < DEEPEST; k++) {
            real slope;
            middle = a + (b - a) / 2;
            if (value(p, middle, &slope) > 0) b = middle;
            else a = middle;
        }
        return b;
    }
    if (depth == 0) return at_b > 0 ? b : 2;
    const real first = first_above(p, a, middle, depth - 1);
    return first < 2 ? first : first_above(p, middle, b, depth - 1);
}

/* -------------------------------------------------------------------- events */

static ric_status strike(ric_shaken *s, int f, ric_impact *out)
{
    face_t *face = &s->face[f];
    const int n = s->n;
    const real speed = face->side * dot(n, face->b, s->y + n);
    *out = (ric_impact){.time = (double)s->time,
                        .face = f,
                        .approach = (double)speed,
                        .opens = face->closed};
    s->own = f;
    if (face->spring > 0) {
        face->closed = !face->closed;
        return RIC_OK;
    }
    const real kick = (1 + s->restitution) * speed / face->cc;
    for (int i = 0; i < n; i++) s->y[n + i] -= kick * face->side * face->mb[i];
    out->impulse = (double)kick;
    const real fast = sqrt(dot(n, s->y + n, s->y + n)) * sqrt(dot(n, face->b, face->b));
    if (s->restitution * speed > STUCK * fast) return RIC_OK;
    return ric_fail(RIC_E_RANGE,
                    "from time %.9g on the structure stays in contact with face %d: it rebounds "
                    "ever more slowly "
                    "(chatter), and motions that stay on a rigid stop are not followed",
                    (double)s->time, f);
}

/* The event that is first in this panel, from the start or from where a face was just left: 2 none.
 */
static real next_event(const ric_shaken *s, int *which)
{
    real first = 2;
    for (int f = 0; f < s->n_face; f++) {
        poly p = gap_of(s, &s->face[f]);
        if (f == s->own) { /* on it, and leaving: what rounding has left is taken off */
            p.c[0] = 0;
        }
        const real u = first_above(&p, 0, 1, DEEPEST);
        if (u < first) {
            first = u;
            *which = f;
        }
    }
    return first;
}

/* --------------------------------------------------------------- power laws */

static void rate(const ric_shaken *s, real t, const real *y, real *dy)
{
    const int n = s->n;
    const real push = s->y[2 * n] * cos(s->omega * t) - s->y[2 * n + 1] * sin(s->omega * t);
    for (int i = 0; i < n; i++) {
        dy[i] = y[n + i];
        dy[n + i] = s->f[i] * push - dot(n, s->A + i * n, y) - dot(n, s->C + i * n, y + n);
    }
    for (int k = 0; k < s->n_contact; k++) {
        const real gap = dot(n, s->b + k * n, y);
        real force = s->power[k];
        for (int e = 0; e < s->exponent[k]; e++) force *= gap;
        for (int i = 0; i < n; i++) dy[n + i] -= force * s->mb[k * n + i];
    }
}

/* Gragg's midpoint rule with `parts` sub-steps (Hairer, Norsett and Wanner II.9). */
static void midpoint(const ric_shaken *s, real H, int parts, real *out, real *work)
{
    const int size = 2 * s->n;
    const real h = H / parts;
    real *last = work, *dy = work + size;
    memcpy(last, s->y, (size_t)size * sizeof *last);
    rate(s, 0, last, dy);
    for (int i = 0; i < size; i++) out[i] = last[i] + h * dy[i];
    for (int k = 1; k < parts; k++) {
        rate(s, k * h, out, dy);
        for (int i = 0; i < size; i++) {
            const real next = last[i] + 2 * h * dy[i];
            last[i] = out[i];
            out[i] = next;
        }
    }
    rate(s, H, out, dy);
    for (int i = 0; i < size; i++) out[i] = (last[i] + out[i] + h * dy[i]) / 2;
}

/* A stage of the extrapolation; how far it moves displacements and velocities, each relative to the
 * largest of them at both ends of the step, infinite where the step is so long that it overflows.
 */
static real stage(int n, real ratio, const real *y, real *up, const real *down)
{
    real worst = 0;
    for (int half = 0; half < 2; half++) {
        real moved = 0, largest = 0;
        for (int i = half * n; i < (half + 1) * n; i++) {
            const real before = up[i];
            up[i] = down[i] + (down[i] - up[i]) / (ratio * ratio - 1);
            if (!isfinite(up[i])) worst = HUGE_VAL;
            moved = fmax(moved, fabs(up[i] - before));
            largest = fmax(largest, fmax(fabs(y[i]), fabs(up[i])));
        }
        if (moved > 0) worst = fmax(worst, moved / largest);
    }
    return worst;
}

/* One step of at most H; what was done, 0: it fails. */
static real extrapolate(ric_shaken *s, real H)
{
    const int size = 2 * s->n;
    real *work = s->table + LEVELS * size;
    for (int attempt = 0; attempt < 60; attempt++, H *= 0.4L)
        for (int k = 0; k < LEVELS; k++) {
            real moved = HUGE_VAL;
            midpoint(s, H, 2 * (k + 1), s->table + k * size, work);
            for (int j = k - 1; j >= 0; j--)
                moved = stage(s->n, (real)(k + 1) / (j + 1), s->y, s->table + j * size,
                              s->table + (j + 1) * size);
            if (k < 3 || !(moved <= TOLERANCE)) continue;
            memcpy(s->y, s->table, (size_t)size * sizeof *s->y);
            const real c = s->y[size], d = s->y[size + 1], turn = s->omega * H;
            s->y[size] = c * cos(turn) - d * sin(turn);
            s->y[size + 1] = c * sin(turn) + d * cos(turn);
            s->step = H * (k < AIM ? 1.5L : k > AIM ? 0.7L : 1);
            s->time += H;
            return H;
        }
    return 0;
}

static ric_status go_smooth(ric_shaken *s, real to)
{
    if (!(s->step > 0)) s->step = TURN / s->fastest;
    for (int k = 0; s->time < to; k++) {
        const real rest = to - s->time;
        if (k == STEPS_MOST || !(extrapolate(s, fmin(s->step, rest)) > 0))
            return ric_fail(RIC_E_NUMERIC, "the motion cannot be followed beyond time %.9g",
                            (double)s->time);
        if (to - s->time < LDBL_EPSILON * fabs(to)) s->time = to;
        if (ric_halt(1000)) return ric_fail(RIC_E_INTERRUPTED, "stopped on request");
    }
    return RIC_OK;
}

ric_status ric_shaken_advance(ric_shaken *s, double t, bool *hit, ric_impact *impact)
{
    const real to = t;
    *hit = false;
    if (s->n_contact > 0 && s->n_face == 0) return go_smooth(s, to);
    while (s->time < to) {
        int face = -1;
        const real rest = to - s->time, h = fmin(TURN / s->fastest, rest);
        if (ric_halt(TERMS))
            return ric_fail(RIC_E_INTERRUPTED, "stopped on request at time %.9g", (double)s->time);
        expand(s, h);
        const real u = next_event(s, &face);
        if (u <= 1) {
            move(s, u, h);
            *hit = true;
            return strike(s, face, impact);
        }
        move(s, 1, h);
        if (h == rest) s->time = to;
        s->own = -1;
    }
    return RIC_OK;
}
