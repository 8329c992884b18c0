/* Event-driven motion: from M, K, the contacts and a state it finds every impact itself, and every closing and opening of a spring.
 *
 * It shares no code with the orbit solver, so that agreement between the two means something (docs/theory.md section 11). It makes its
 * own modal decomposition, K phi = omega^2 M phi with phi' M phi = 1, by Jacobi rotations in extended precision. Flight is closed form
 * from the last impact on: with h = omega tau / 2,
 *     q(tau) = q + 2 sin h (cos h p / omega - sin h q),   p(tau) = p cos 2h - omega q sin 2h,
 * which keeps the relative accuracy of q(tau) - q for short times; q + p tau where omega = 0. Impact on face f: p -= (1+eps) (c.p)/(c.c) c.
 *
 * Contacts of law bilinear switch: while faces are closed the structure has K + sum k_f b_f b_f' for its stiffness and the modes of that, and
 * q counts from its equilibrium. A closed face is searched like an open one, with the sign of its gap turned round: it opens where the gap
 * coordinate falls through the clearance. State and acceleration are continuous there.
 *
 * The next impact is searched with a guarantee. On [a, b], h = b - a, the cubic Hermite interpolant H of a gap g satisfies
 *     |g - H| <= D4 h^4 / 384,  |g' - H'| <= D4 h^3 sqrt(3) / 216,  |g'' - H''| <= D4 h^2 / 12   (Birkhoff and Priver 1967),
 * where D4 = sum |c_i| omega_i^3 sqrt((omega_i q_i)^2 + p_i^2) bounds the fourth derivative for ever. The Bernstein coefficients of H, H', H''
 * bound these in turn. An interval is dropped, or known to be monotone, convex or concave, or is halved.
 * Only a maximum beyond the face by more than rounding is an impact; anything less is a touch, which changes no velocity.
 * Cost: O(n) per evaluation, some dozen evaluations per face and impact. */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>

#include "simulate.h"
#include "springs.h"
#include "status.h"

/* Extended where the machine has it, so that the replay of an unstable orbit loses less than its check allows. */
typedef ric_real real;

/* Gaps that differ by less than this part of the sum of the moduli of their modes are equal to a caller, who has doubles. */
#define ROUNDING (32 * DBL_EPSILON)
/* A start may be beyond a stop by this part of the clearance: twelve digits of a state typed by hand leave that much. */
#define BEYOND 1e-10
/* Faces that close within this part of the clearance of each other close together. */
#define TOGETHER 1e-12
/* Cosine of two normals in the metric M^-1 below which impacts commute. */
#define ORTHOGONAL 1e-12
/* Accelerations below this part of their bound have no certain sign. */
#define STEADY 1e-10
/* A mode whose displacement at a spring is less than this part of its terms is not held by it. */
#define EXTENDED (64 * LDBL_EPSILON)
/* Rebounds slower than this part of the velocity bound, under an acceleration into the face, end in a lasting contact. */
#define CHATTER 1e-6

typedef struct {
    int contact, side;
    real limit;          /* scaled clearance: the face is at side * s = limit */
    real spring;         /* stiffness of law bilinear, 0: rigid */
    real cc;
    real noise;          /* what the rounding of the given state leaves uncertain in s */
    bool closed;         /* the spring is engaged */
    real impulse;        /* exchanged since the face closed */
    /* of the present flight */
    const real *c;       /* [n] modal normal in its frame */
    int sign;            /* side, or -side while closed: an event is sign * s rising beyond edge */
    real edge;           /* limit, or -limit while closed */
    real start;          /* sign * s - level at its start; exactly 0 on the face */
    real level;          /* edge, or a little more if the flight starts beyond it by rounding */
    real D[5];           /* D[k] bounds the k-th derivative of s; D[0] = infinity if a free mode drifts */
    real rest;           /* s in equilibrium */
    real band;           /* rounding of s */
} face_t;

/* The structure with some faces closed, in modes of its own. */
typedef struct frame {
    struct frame *next;
    bool *closed;        /* [n_face] */
    real *omega;         /* [n] rad/s, 0 for a free mode */
    real *phi, *mphi;    /* [n * n] row i is mode i: phi_i and M phi_i */
    real *c;             /* [n_contact * n] */
    real *rest;          /* [n] equilibrium */
} frame;

struct ric_simulator {
    ric_springs *springs; /* under a power law all motion is theirs: y [2n] = x, v at the time now, and nothing else here is used */
    real *y;
    int n, n_face, n_contact;
    real restitution;
    bool started;
    frame *open;         /* the frame with every spring open; the others follow as they are met */
    const frame *frame;  /* of the present flight */
    const real *omega;   /* [n] of that */
    const double *M, *K; /* raw matrices, copied */
    face_t *face;          /* [n_face] */
    real *b;             /* [n_contact * n] raw normals */
    real *q, *p;         /* [n] modal state at the start of the flight, from the equilibrium of the frame */
    real *x;             /* [2n] scratch: displacement, velocity */
    double *rough;       /* [3n + n_contact n] omega, q, p, c in double, for the search */
    real origin, origin_low; /* time of that, with what rounding dropped from it */
    real now;            /* present time, from the origin */
    real known;          /* no impact before this time, from the origin */
    real scanned;        /* reach is known up to here */
    real next;           /* time of the next impact, infinite if it is not found yet */
    int next_face;
    bool examined;         /* the start of the flight has been looked at */
    real reach;
    real *store;         /* what the arrays above lie in */
};

/* A face's gap g = sign * s - level and its first two derivatives at one time. */
typedef struct { double t, g[3]; } sample;

/* ------------------------------------------------------------------- modes */

/* A = L L' in place; false if A is not positive definite. */
static bool cholesky(int n, real *A)
{
    for (int j = 0; j < n; j++) {
        for (int i = j; i < n; i++) {
            real sum = A[i * n + j];
            for (int k = 0; k < j; k++) sum -= A[i * n + k] * A[j * n + k];
            if (i == j && !(sum > 0)) return false;
            A[i * n + j] = i == j ? sqrt(sum) : sum / A[j * n + j];
        }
    }
    return true;
}

/* Rows of X [n * n] each become L^-1 times them. */
static void solve_rows(int n, const real *L, real *X)
{
    for (int r = 0; r < n; r++)
        for (int i = 0; i < n; i++) {
            for (int k = 0; k < i; k++) X[r * n + i] -= L[i * n + k] * X[r * n + k];
            X[r * n + i] /= L[i * n + i];
        }
}

static void transpose(int n, real *A)
{
    for (int i = 0; i < n; i++)
        for (int j = 0; j < i; j++) {
            real t = A[i * n + j];
            A[i * n + j] = A[j * n + i];
            A[j * n + i] = t;
        }
}

static void rotate(int n, real *x, real *y, real cosine, real sine)
{
    for (int k = 0; k < n; k++) {
        real u = x[k], v = y[k];
        x[k] = cosine * u - sine * v;
        y[k] = sine * u + cosine * v;
    }
}

/* One rotation that clears A[i][j] of a symmetric A kept in full; V collects the eigenvectors as rows (Golub and Van Loan, 8.5). */
static void clear(int n, int i, int j, real *A, real *V)
{
    real aij = A[i * n + j], theta = (A[j * n + j] - A[i * n + i]) / (2 * aij);
    real t = copysign(1, theta) / (fabs(theta) + hypot(1, theta)), cosine = 1 / hypot(1, t), sine = t * cosine;
    real aii = A[i * n + i] - t * aij, ajj = A[j * n + j] + t * aij;
    rotate(n, A + i * n, A + j * n, cosine, sine);
    for (int k = 0; k < n; k++) {
        A[k * n + i] = A[i * n + k];
        A[k * n + j] = A[j * n + k];
    }
    A[i * n + i] = aii;
    A[j * n + j] = ajj;
    A[i * n + j] = A[j * n + i] = 0;
    rotate(n, V + i * n, V + j * n, cosine, sine);
}

static bool jacobi(int n, real *A, real *V)
{
    enum { SWEEPS = 60 };
    for (int sweep = 0; sweep < SWEEPS; sweep++) {
        bool done = true;
        for (int i = 0; i < n; i++)
            for (int j = i + 1; j < n; j++) {
                real scale = sqrt(fabs(A[i * n + i] * A[j * n + j])) + LDBL_EPSILON * (fabs(A[i * n + i]) + fabs(A[j * n + j]));
                if (fabs(A[i * n + j]) <= LDBL_EPSILON * scale) continue;
                clear(n, i, j, A, V);
                done = false;
            }
        if (done) return true;
    }
    return false;
}

/* omega_i of row phi_i in a frame. It is exactly 0 if phi' K phi is no larger than the rounding of the entries of K themselves, and no spring
 * holds it. */
static real frequency(const ric_simulator *sim, const bool *closed, const real *phi)
{
    int n = sim->n;
    real sum = 0, size = 0, springs = 0;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            real term = phi[i] * sim->K[i * n + j] * phi[j];
            sum += term;
            size += fabs(term);
        }
    for (int f = 0; f < sim->n_face; f++) {
        const face_t *face = &sim->face[f];
        real s = 0, largest = 0;
        if (!closed[f]) continue;
        for (int i = 0; i < n; i++) {
            s += phi[i] * sim->b[face->contact * n + i];
            largest = fmax(largest, fabs(phi[i] * sim->b[face->contact * n + i]));
        }
        if (fabs(s) > EXTENDED * largest) springs += face->spring * s * s;
    }
    return sum + springs <= ROUNDING * size ? 0 : sqrt(sum + springs);
}

static void store_modes(ric_simulator *sim, frame *out, const real *phi)
{
    int n = sim->n;
    for (int i = 0; i < n; i++) {
        out->omega[i] = frequency(sim, out->closed, phi + i * n);
        for (int j = 0; j < n; j++) {
            real sum = 0;
            for (int k = 0; k < n; k++) sum += phi[i * n + k] * sim->M[k * n + j];
            out->phi[i * n + j] = phi[i * n + j];
            out->mphi[i * n + j] = sum;
        }
    }
    for (int f = 0; f < sim->n_contact; f++)
        for (int i = 0; i < n; i++) {
            real sum = 0;
            for (int j = 0; j < n; j++) sum += phi[i * n + j] * sim->b[f * n + j];
            out->c[f * n + i] = sum;
        }
    for (int f = 0; f < sim->n_face; f++) {
        const face_t *face = &sim->face[f];
        for (int i = 0; i < n && out->closed[f]; i++) {
            real omega = out->omega[i];
            if (omega > 0) out->rest[i] += face->spring * face->side * face->limit * out->c[face->contact * n + i] / (omega * omega);
        }
    }
}

/* K and the springs of closed faces. */
static void assemble(const ric_simulator *sim, const bool *closed, real *A)
{
    int n = sim->n;
    for (int i = 0; i < n * n; i++) A[i] = sim->K[i];
    for (int f = 0; f < sim->n_face; f++) {
        const real *b = sim->b + sim->face[f].contact * n;
        for (int i = 0; i < n && closed[f]; i++)
            for (int j = 0; j < n; j++) A[i * n + j] += sim->face[f].spring * b[i] * b[j];
    }
}

/* M = L L', A = L^-1 K L^-T = V' diag V, phi = L^-T V. */
static ric_status make_modes(ric_simulator *sim, frame *out)
{
    ric_status status = RIC_OK;
    int n = sim->n;
    size_t nn = (size_t)n * (size_t)n;
    real *L = calloc(3 * nn, sizeof *L), *A = L + nn, *V = A + nn;
    if (!L) {
        status = ric_fail(RIC_E_NOMEM, "no memory for the modes of %d degrees of freedom", n);
        goto out;
    }
    for (size_t i = 0; i < nn; i++) L[i] = sim->M[i];
    assemble(sim, out->closed, A);
    for (int i = 0; i < n; i++) V[i * n + i] = 1;
    if (!cholesky(n, L)) {
        status = ric_fail(RIC_E_INPUT, "mass matrix is not positive definite");
        goto out;
    }
    solve_rows(n, L, A);
    transpose(n, A);
    solve_rows(n, L, A);
    if (!jacobi(n, A, V)) {
        status = ric_fail(RIC_E_NUMERIC, "the modes of the structure did not converge; are mass and stiffness scaled sensibly?");
        goto out;
    }
    for (int r = 0; r < n; r++) /* rows of V: solve L' x = v */
        for (int i = n - 1; i >= 0; i--) {
            for (int k = i + 1; k < n; k++) V[r * n + i] -= L[k * n + i] * V[r * n + k];
            V[r * n + i] /= L[i * n + i];
        }
    store_modes(sim, out, V);
out:
    free(L);
    return status;
}

static void frame_free(frame *f)
{
    if (!f) return;
    free(f->closed);
    free(f->omega);
    free(f);
}

static ric_status frame_create(ric_simulator *sim, const bool *closed, frame **out)
{
    size_t n = (size_t)sim->n, faces = (size_t)sim->n_face;
    frame *f = calloc(1, sizeof *f);
    *out = NULL;
    if (!f || !(f->closed = calloc(faces + 1, sizeof *f->closed)) ||
        !(f->omega = calloc(2 * n + 2 * n * n + (size_t)sim->n_contact * n, sizeof *f->omega))) {
        frame_free(f);
        return ric_fail(RIC_E_NOMEM, "no memory for the modes of %d degrees of freedom", sim->n);
    }
    for (size_t i = 0; closed && i < faces; i++) f->closed[i] = closed[i];
    f->rest = f->omega + n;
    f->phi = f->rest + n;
    f->mphi = f->phi + n * n;
    f->c = f->mphi + n * n;
    ric_status status = make_modes(sim, f);
    if (status) frame_free(f);
    else *out = f;
    return status;
}

static void enter_frame(ric_simulator *sim, const frame *f)
{
    int n = sim->n;
    sim->frame = f;
    sim->omega = f->omega;
    for (int i = 0; i < n; i++) sim->rough[i] = (double)f->omega[i];
    for (int i = 0; i < sim->n_contact * n; i++) sim->rough[3 * n + i] = (double)f->c[i];
    for (int k = 0; k < sim->n_face; k++) {
        face_t *face = &sim->face[k];
        face->closed = f->closed[k];
        face->sign = face->closed ? -face->side : face->side;
        face->edge = face->closed ? -face->limit : face->limit;
        face->c = f->c + face->contact * n;
        face->rest = 0;
        for (int i = 0; i < n; i++) face->rest += face->c[i] * f->rest[i];
    }
}

/* The frame with these faces closed, made when it is first met. */
static ric_status find_frame(ric_simulator *sim, const bool *closed, const frame **out)
{
    frame *last = sim->open, *made;
    for (frame *f = sim->open; f; last = f, f = f->next)
        if (!memcmp(f->closed, closed, (size_t)sim->n_face * sizeof *closed)) {
            *out = f;
            return RIC_OK;
        }
    ric_status status = frame_create(sim, closed, &made);
    if (!status) *out = last->next = made;
    return status;
}

/* Displacement and velocity [2n] of a modal state of the present frame, and back. */
static void to_space(const ric_simulator *sim, const real *q, const real *p, real *x)
{
    int n = sim->n;
    for (int j = 0; j < n; j++) {
        x[j] = x[n + j] = 0;
        for (int i = 0; i < n; i++) {
            x[j] += sim->frame->phi[i * n + j] * (q[i] + sim->frame->rest[i]);
            x[n + j] += sim->frame->phi[i * n + j] * p[i];
        }
    }
}

static void to_modal(const ric_simulator *sim, const frame *f, const real *x, real *w)
{
    int n = sim->n;
    for (int i = 0; i < n; i++) {
        w[i] = -f->rest[i];
        w[n + i] = 0;
        for (int j = 0; j < n; j++) {
            w[i] += f->mphi[i * n + j] * x[j];
            w[n + i] += f->mphi[i * n + j] * x[n + j];
        }
    }
}

/* From the modal state in q, p of the present frame to that of another one. */
static void change_frame(ric_simulator *sim, const frame *f)
{
    to_space(sim, sim->q, sim->p, sim->x);
    enter_frame(sim, f);
    to_modal(sim, f, sim->x, sim->q); /* p follows q in memory */
}

/* ------------------------------------------------------------------ create */

static ric_status make_faces(ric_simulator *sim, const ric_model *model)
{
    int n = sim->n;
    for (int f = 0; f < ric_model_n_contact(model); f++) {
        ric_contact contact;
        ric_status status = ric_model_contact(model, f, &contact);
        if (status) return status;
        if (contact.law == RIC_LAW_POWER)
            return ric_fail(RIC_E_INPUT, "contact %d has law power; the simulator knows rigid stops and bilinear springs", f + 1);
        for (int i = 0; i < n; i++) sim->b[f * n + i] = contact.normal[i];
        for (int side = 1; side >= -1; side -= 2) {
            if (contact.sides == (side > 0 ? RIC_SIDES_LOWER : RIC_SIDES_UPPER)) continue;
            sim->face[sim->n_face++] = (face_t){
                .contact = f, .side = side, .limit = contact.clearance / ric_model_length(model),
                .spring = contact.law == RIC_LAW_BILINEAR ? contact.stiffness : 0};
        }
    }
    return RIC_OK;
}

static real dot(int n, const real *x, const real *y)
{
    real sum = 0;
    for (int i = 0; i < n; i++) sum += x[i] * y[i];
    return sum;
}

ric_status ric_simulator_create(const ric_model *model, ric_simulator **out)
{
    ric_status status = RIC_OK;
    int n = ric_model_n_dof(model), n_contact = ric_model_n_contact(model);
    size_t nn = (size_t)n * (size_t)n, cn = (size_t)n_contact * (size_t)n;
    ric_simulator *sim = calloc(1, sizeof *sim);
    double *raw = NULL;
    *out = NULL;
    if (!sim || !(sim->store = calloc(4 * (size_t)n + cn, sizeof(real))) ||
        !(sim->rough = calloc(3 * (size_t)n + cn + 2 * nn, sizeof(double))) ||
        !(sim->face = calloc(2 * (size_t)n_contact + 1, sizeof *sim->face))) {
        status = ric_fail(RIC_E_NOMEM, "no memory for a simulator of %d degrees of freedom", n);
        goto out;
    }
    sim->n = n;
    sim->n_contact = n_contact;
    sim->restitution = ric_model_restitution(model);
    sim->q = sim->store;
    sim->p = sim->q + n;
    sim->x = sim->p + n;
    sim->b = sim->x + 2 * n;
    raw = sim->rough + 3 * (size_t)n + cn;
    memcpy(raw, ric_model_mass(model), nn * sizeof *raw);
    memcpy(raw + nn, ric_model_stiffness(model), nn * sizeof *raw);
    sim->M = raw;
    sim->K = raw + nn;
    if (n_contact > 0 && ric_model_n_face(model) == 0) {
        sim->y = sim->x;
        if ((status = ric_springs_create(model, &sim->springs))) goto out;
        *out = sim;
        return RIC_OK;
    }
    if ((status = make_faces(sim, model))) goto out;
    if ((status = frame_create(sim, NULL, &sim->open))) goto out;
    enter_frame(sim, sim->open);
    for (int f = 0; f < sim->n_face; f++) sim->face[f].cc = dot(n, sim->face[f].c, sim->face[f].c);
    *out = sim;
    sim = NULL;
out:
    ric_simulator_free(sim);
    return status;
}

void ric_simulator_free(ric_simulator *sim)
{
    if (!sim) return;
    ric_springs_free(sim->springs);
    for (frame *f = sim->open, *next; f; f = next) {
        next = f->next;
        frame_free(f);
    }
    free(sim->store);
    free(sim->rough);
    free(sim->face);
    free(sim);
}

/* ------------------------------------------------------------------ flight */

/* In double, for the search. */
static sample look(const ric_simulator *sim, const face_t *face, double t)
{
    int n = sim->n;
    const double *omega = sim->rough, *q = omega + n, *p = q + n, *c = p + n + face->contact * n;
    double s = 0, v = 0, a = 0;
    for (int i = 0; i < n; i++) {
        if (omega[i] > 0) {
            double sine, cosine;
            sincos(omega[i] * t / 2, &sine, &cosine);
            double both = 2 * sine * cosine, one = 1 - 2 * sine * sine, stretch = omega[i] * q[i];
            s += c[i] * 2 * sine * (cosine * p[i] - sine * stretch) / omega[i];
            v += c[i] * (p[i] * one - stretch * both);
            a -= c[i] * omega[i] * (stretch * one + p[i] * both);
        } else {
            s += c[i] * p[i] * t;
            v += c[i] * p[i];
        }
    }
    return (sample){t, {(double)face->start + face->sign * s, face->sign * v, face->sign * a}};
}

/* g, g', g'' in full precision. */
static void look_closely(const ric_simulator *sim, const face_t *face, real t, real *g)
{
    real s = 0, v = 0, a = 0;
    for (int i = 0; i < sim->n; i++) {
        real c = face->c[i], omega = sim->omega[i], q = sim->q[i], p = sim->p[i], sine, cosine;
        sincosl(omega * t / 2, &sine, &cosine);
        real both = 2 * sine * cosine, one = 1 - 2 * sine * sine;
        s += c * (omega > 0 ? 2 * sine * (cosine * p / omega - sine * q) : p * t);
        v += c * (p * one - omega * q * both);
        a -= c * omega * (omega * q * one + p * both);
    }
    g[0] = face->start + face->sign * s;
    g[1] = face->sign * v;
    g[2] = face->sign * a;
}

/* Modal state at time t of the flight; may work in place. */
static void fly_mode(const ric_simulator *sim, int i, real t, real *q, real *p)
{
    real omega = sim->omega[i], qi = sim->q[i], pi = sim->p[i], sine, cosine;
    sincosl(omega * t, &sine, &cosine);
    *q = omega > 0 ? qi * cosine + pi / omega * sine : qi + pi * t;
    *p = pi * cosine - omega * qi * sine;
}

static void bound_face(const ric_simulator *sim, face_t *face)
{
    real s = face->rest, size = face->limit + fabs(face->rest);
    memset(face->D, 0, sizeof face->D);
    for (int i = 0; i < sim->n; i++) {
        real c = fabs(face->c[i]), omega = sim->omega[i], speed = c * hypot(omega * sim->q[i], sim->p[i]);
        s += face->c[i] * sim->q[i];
        size += omega > 0 ? speed / omega : c * fabs(sim->q[i]);
        face->D[0] += omega > 0 ? speed / omega : speed > 0 ? INFINITY : c * fabs(sim->q[i]);
        for (int k = 1; k <= 4; k++, speed *= omega) face->D[k] += speed;
    }
    face->band = ROUNDING * size + face->noise;
    face->level = fmax(face->edge, face->sign * s);
    face->start = face->sign * s - face->level;
    if (face->start >= -face->band) face->start = 0;
}

/* From the modal state in sim->q, sim->p at the present origin on. */
static void begin_flight(ric_simulator *sim)
{
    for (int i = 0; i < 2 * sim->n; i++) sim->rough[sim->n + i] = (double)sim->q[i]; /* p follows q in memory */
    for (int f = 0; f < sim->n_face; f++) bound_face(sim, &sim->face[f]);
    sim->now = sim->known = sim->scanned = 0;
    sim->next = INFINITY;
    sim->next_face = -1;
    sim->examined = false;
}

static double time_of(const ric_simulator *sim, real t)
{
    return (double)(sim->origin + (sim->origin_low + t));
}

/* Moves the origin to time t of the flight; compensated, so that long runs lose no time (Kahan 1965). */
static void move_origin(ric_simulator *sim, real t)
{
    real step = sim->origin_low + t, sum = sim->origin + step;
    sim->origin_low = step - (sum - sim->origin);
    sim->origin = sum;
}

/* ---------------------------------------------------- guaranteed intervals */

typedef enum { BELOW, RISING, FALLING, CONVEX, CONCAVE, FLAT, UNKNOWN } shape;

/* What is certain about g on [a, b]; BELOW: g <= level throughout; FLAT: it is a straight line to rounding. */
static shape classify(const face_t *face, const sample *a, const sample *b, double level)
{
    double h = b->t - a->t, D4 = (double)face->D[4], e0 = D4 * h * h * h * h / 384, e1 = D4 * h * h * h * (0.5773502691896258 / 72), e2 = D4 * h * h / 12;
    double left = a->g[0] + h * a->g[1] / 3, right = b->g[0] - h * b->g[1] / 3;
    if (fmax(fmax(a->g[0], b->g[0]), fmax(left, right)) + e0 <= level) return BELOW;
    double band = (double)face->band, noise = band / (8 * h);
    double middle = 3 * (right - left) / h;
    if (fmin(fmin(a->g[1], b->g[1]), middle - noise) - e1 > 0) return RISING;
    if (fmax(fmax(a->g[1], b->g[1]), middle + noise) + e1 < 0) return FALLING;
    double first = 2 * (middle - a->g[1]) / h, last = 2 * (b->g[1] - middle) / h, noise2 = 2 * noise / h;
    if (fmin(first, last) - noise2 - e2 > 0) return CONVEX;
    if (fmax(first, last) + noise2 + e2 < 0) return CONCAVE;
    double bend = h * h * fmax(fabs(first), fabs(last)) / 8;
    return e0 + bend <= band / 2 ? FLAT : UNKNOWN;
}

/* Zero of g (order 0) or g' (order 1) between lo and hi, where it changes sign: Newton's method kept inside a shrinking bracket. */
static sample zero(const ric_simulator *sim, const face_t *face, int order, sample lo, sample hi)
{
    enum { STEPS = 200 };
    bool rising = hi.g[order] > 0;
    sample x = fabs(lo.g[order]) < fabs(hi.g[order]) ? lo : hi;
    double last = hi.t - lo.t;
    for (int i = 0; i < STEPS && x.g[order] != 0; i++) {
        double step = -x.g[order] / x.g[order + 1], t = x.t + step;
        if (!(t > lo.t && t < hi.t) || fabs(step) > last / 2) t = lo.t + (hi.t - lo.t) / 2;
        last = fabs(t - x.t);
        if (t == lo.t || t == hi.t || last <= DBL_EPSILON / 2 * t) break;
        x = look(sim, face, t);
        if ((x.g[order] > 0) == rising) hi = x;
        else lo = x;
    }
    return x;
}

/* The last digits of a root t of g that lies in [lo, hi]; t itself where the slope does not tell them. */
static real refine(const ric_simulator *sim, const face_t *face, double lo, double hi, double t)
{
    enum { STEPS = 6 };
    real x = t;
    for (int i = 0; i < STEPS; i++) {
        real g[3], next;
        look_closely(sim, face, x, g);
        next = g[1] > 0 ? x - g[0] / g[1] : t;
        if (!(next >= lo && next <= hi)) return t;
        if (fabs(next - x) <= LDBL_EPSILON * x) return next;
        x = next;
    }
    return x;
}

/* Where g rises through 0 in [a, b], given g(a) <= rounding < g(b) and that g is monotone, or convex, there. */
static real rise(const ric_simulator *sim, const face_t *face, sample a, const sample *b)
{
    if (a.g[1] < 0 && b->g[1] > 0) a = zero(sim, face, 1, a, *b);
    if (a.g[0] < 0) return refine(sim, face, a.t, b->t, zero(sim, face, 0, a, *b).t);
    double t = fmax(0, a.g[1] > 0 ? a.t - a.g[0] / a.g[1] : a.t), h = b->t - a.t;
    return refine(sim, face, fmax(0, t - h), b->t, t);
}

/* First time in [a, b] at which the face is met, infinite if it is not. */
static real first_crossing(const ric_simulator *sim, const face_t *face, const sample *a, const sample *b)
{
    shape kind = classify(face, a, b, (double)face->band);
    if (kind == BELOW || kind == FALLING) return INFINITY;
    if (kind == CONCAVE && a->g[1] > 0 && b->g[1] < 0) {
        sample top = zero(sim, face, 1, *a, *b);
        return top.g[0] > face->band ? rise(sim, face, *a, &top) : INFINITY;
    }
    if (kind != UNKNOWN) return b->g[0] > face->band ? rise(sim, face, *a, b) : INFINITY;
    sample middle = look(sim, face, a->t + (b->t - a->t) / 2);
    real t = first_crossing(sim, face, a, &middle);
    return t < INFINITY ? t : first_crossing(sim, face, &middle, b);
}

/* Largest stationary value of g in [a, b], if it is above `best` by more than rounding; else `best`. */
static double highest(const ric_simulator *sim, const face_t *face, const sample *a, const sample *b, double best)
{
    shape kind = classify(face, a, b, best + (double)face->band);
    if (kind == CONCAVE && a->g[1] >= 0 && b->g[1] <= 0) return fmax(best, zero(sim, face, 1, *a, *b).g[0]);
    if (kind != UNKNOWN) return best;
    sample middle = look(sim, face, a->t + (b->t - a->t) / 2);
    best = highest(sim, face, a, &middle, best);
    return highest(sim, face, &middle, b, best);
}

/* A first length for which the interpolant is within a few percent of the clearance. */
static double panel(const face_t *face)
{
    return face->D[4] > 0 ? (double)sqrt(sqrt(20 * face->limit / face->D[4])) : INFINITY;
}

static real search_face(const ric_simulator *sim, const face_t *face, double from, double to)
{
    if (face->sign * face->rest + face->D[0] < face->level) return INFINITY;
    real found = INFINITY;
    double h = panel(face);
    sample a = look(sim, face, from);
    while (a.t < to && found == INFINITY) {
        sample b = look(sim, face, fmin(to, a.t + h));
        if (b.t <= a.t) break;
        found = first_crossing(sim, face, &a, &b);
        a = b;
    }
    return found;
}

/* ------------------------------------------------------------------- reach */

/* g <-> reach, the gap coordinate over the clearance, of open faces. */
static double to_reach(const face_t *face, double g)
{
    return (g + face->level) / face->limit;
}

static void scan_reach(ric_simulator *sim, double to)
{
    for (int f = 0; f < sim->n_face; f++) {
        const face_t *face = &sim->face[f];
        double h = panel(face);
        sample a = look(sim, face, sim->scanned);
        while (a.t < to && !face->closed && face->sign * face->rest + face->D[0] > sim->reach * face->limit + face->band) {
            sample b = look(sim, face, fmin(to, a.t + h));
            if (b.t <= a.t) break;
            double level = sim->reach * face->limit - face->level, top = highest(sim, face, &a, &b, level);
            if (top > level) sim->reach = to_reach(face, top);
            a = b;
        }
    }
    sim->scanned = fmax(sim->scanned, to);
}

/* The start itself is a largest value where the gap coordinate falls from there on, unless the face has just been left. */
static void start_reach(ric_simulator *sim)
{
    for (int f = 0; f < sim->n_face; f++) {
        const face_t *face = &sim->face[f];
        sample a = look(sim, face, 0);
        bool still = fabs(a.g[1]) <= ROUNDING * face->D[1], left = a.g[0] >= -BEYOND * face->limit && !still;
        if (!face->closed && (a.g[1] <= 0 || still))
            if (!left) sim->reach = fmax(sim->reach, to_reach(face, a.g[0]));
    }
}

double ric_simulator_reach(const ric_simulator *sim)
{
    double reach = sim->reach;
    if (!sim->started || sim->now == 0) return (double)reach;
    for (int f = 0; f < sim->n_face; f++) {
        sample a = look(sim, &sim->face[f], sim->now);
        if (a.g[1] >= 0 && !sim->face[f].closed) reach = fmax(reach, to_reach(&sim->face[f], a.g[0]));
    }
    return (double)reach;
}

/* ------------------------------------------------------------------ events */

/* A face that the flight starts on: moving into it is an impact at once, or a switch; a switch, too, is resting on it under an acceleration
 * into it. On a stop, resting on it under an acceleration into it, or rebounding ever
 * faster (the sum of all flights 2u/a (1 + eps + eps^2 + ...) is over before the acceleration a changes), is a lasting contact. */
static ric_status examine_face(ric_simulator *sim, int f)
{
    const face_t *face = &sim->face[f];
    real g[3];
    look_closely(sim, face, 0, g);
    if (g[0] != 0) return RIC_OK;
    real still = ROUNDING * face->D[1], u = -g[1], acceleration = g[2], eps = sim->restitution;
    if (-u > still) {
        sim->next = 0;
        sim->next_face = f;
        return RIC_OK;
    }
    if (acceleration <= STEADY * face->D[2]) return RIC_OK;
    if (face->spring > 0) {
        if (fabs(u) <= still) {
            sim->next = 0;
            sim->next_face = f;
        }
        return RIC_OK;
    }
    if (fabs(u) <= still)
        return ric_fail(RIC_E_NUMERIC, "at time %.9g the structure stays on face %d: no speed and an acceleration of %.3g into it; a lasting "
                        "contact is outside the impact law, so the motion ends here", time_of(sim, 0), f, (double)acceleration);
    if (eps < 1 && u <= CHATTER * face->D[1] && face->D[3] * 2 * u / (1 - eps) <= acceleration * acceleration / 2)
        return ric_fail(RIC_E_NUMERIC, "impacts on face %d pile up before time %.9g (chatter with restitution %g); the structure comes to rest "
                        "on the stop, which is outside the impact law, so the motion ends here", f,
                        time_of(sim, 2 * u / acceleration / (1 - eps)), (double)eps);
    return RIC_OK;
}

/* Finds the next impact, or that there is none up to time `to` of the flight. */
static ric_status find_next(ric_simulator *sim, real to)
{
    enum { PANELS = 16 };
    real chunk = INFINITY;
    if (!sim->examined) {
        for (int f = 0; f < sim->n_face; f++) {
            ric_status status = examine_face(sim, f);
            if (status) return status;
        }
        sim->examined = true;
    }
    for (int f = 0; f < sim->n_face; f++) chunk = fmin(chunk, PANELS * panel(&sim->face[f]));
    while (sim->next == INFINITY && sim->known < to) {
        real end = chunk < INFINITY ? sim->known + chunk : to;
        bool open = false;
        for (int f = 0; f < sim->n_face; f++) {
            real t = search_face(sim, &sim->face[f], sim->known, fmin(end, sim->next));
            open |= sim->face[f].sign * sim->face[f].rest + sim->face[f].D[0] >= sim->face[f].level;
            if (t >= sim->next) continue;
            sim->next = t;
            sim->next_face = f;
        }
        if (end <= sim->known) return ric_fail(RIC_E_NUMERIC, "time %.17g is too long for the fastest motion of the structure", (double)to);
        sim->known = open ? end : INFINITY;
    }
    return RIC_OK;
}

/* Two stops at one instant: only if their normals are orthogonal in M^-1 does the order not matter. A spring that closes has no force yet. */
static ric_status check_alone(const ric_simulator *sim, int f, real t)
{
    const face_t *face = &sim->face[f];
    for (int k = 0; k < sim->n_face; k++) {
        const face_t *other = &sim->face[k];
        if (k == f || other->contact == face->contact || other->spring > 0) continue;
        real g = look(sim, other, t).g[0];
        if (fabs(g) > TOGETHER * other->limit + other->band) continue;
        if (fabs(dot(sim->n, face->c, other->c)) <= ORTHOGONAL * sqrt(face->cc * other->cc)) continue;
        return ric_fail(RIC_E_NUMERIC, "faces %d and %d are met together at time %.9g and one impact changes the speed at the other: the impact "
                        "law is undefined there, so the motion ends here", f < k ? f : k, f < k ? k : f, time_of(sim, t));
    }
    return RIC_OK;
}

/* An impact turns the gap coordinates of other contacts back too: a largest value with a kink. */
static void kink_reach(ric_simulator *sim, const face_t *face, real t, real change)
{
    for (int k = 0; k < sim->n_face; k++) {
        const face_t *other = &sim->face[k];
        if (other->contact == face->contact || other->closed) continue;
        sample a = look(sim, other, t);
        real after = a.g[1] + other->side * change * dot(sim->n, face->c, other->c);
        if (a.g[1] > 0 && after < 0) sim->reach = fmax(sim->reach, to_reach(other, a.g[0]));
    }
}

/* What closed springs exchange up to time t of the flight: the integral of k (side s - limit). */
static void collect_impulses(ric_simulator *sim, real t)
{
    for (int f = 0; f < sim->n_face; f++) {
        face_t *face = &sim->face[f];
        if (!face->closed) continue;
        real sum = face->rest * t;
        for (int i = 0; i < sim->n; i++) {
            real omega = sim->omega[i], sine, cosine;
            sincosl(omega * t / 2, &sine, &cosine);
            sum += face->c[i] * (omega > 0 ? 2 * sine / omega * (cosine * sim->q[i] + sine * sim->p[i] / omega)
                                           : sim->q[i] * t + sim->p[i] * t * t / 2);
        }
        face->impulse += face->spring * (face->side * sum - face->limit * t);
    }
}

static void move_state(ric_simulator *sim, real t)
{
    collect_impulses(sim, t);
    for (int i = 0; i < sim->n; i++) fly_mode(sim, i, t, &sim->q[i], &sim->p[i]);
    move_origin(sim, t);
}

/* A spring engages or lets go: the state is continuous, the modes are others. */
static ric_status toggle(ric_simulator *sim, ric_impact *impact)
{
    bool closed[sim->n_face];
    int f = sim->next_face;
    face_t *face = &sim->face[f];
    const frame *other;
    real g[3], t = sim->next;
    scan_reach(sim, t);
    sim->now = t;
    look_closely(sim, face, t, g);
    for (int k = 0; k < sim->n_face; k++) closed[k] = sim->face[k].closed != (k == f);
    ric_status status = find_frame(sim, closed, &other);
    if (status) return status;
    move_state(sim, t);
    if (!face->closed) face->impulse = 0;
    if (impact) *impact = (ric_impact){time_of(sim, 0), f, (double)(face->closed ? -g[1] : g[1]), (double)face->impulse, face->closed};
    change_frame(sim, other);
    begin_flight(sim);
    return RIC_OK;
}

static ric_status strike(ric_simulator *sim, ric_impact *impact)
{
    int n = sim->n, f = sim->next_face;
    const face_t *face = &sim->face[f];
    if (face->spring > 0) return toggle(sim, impact);
    real t = sim->next;
    scan_reach(sim, t);
    sim->now = t;
    ric_status status = check_alone(sim, f, t);
    if (status) return status;
    real g[3];
    look_closely(sim, face, t, g);
    real speed = g[1], change = -(1 + sim->restitution) * speed / face->cc * face->side;
    if (t == 0 && speed <= ROUNDING * face->D[1])
        return ric_fail(RIC_E_NUMERIC, "at time %.9g the structure stays on face %d; a lasting contact is outside the impact law, so the motion "
                        "ends here", time_of(sim, 0), f);
    if (impact) *impact = (ric_impact){time_of(sim, t), f, (double)speed, (double)fabs(change), false};
    kink_reach(sim, face, t, change);
    move_state(sim, t);
    for (int i = 0; i < n; i++) sim->p[i] += change * face->c[i];
    begin_flight(sim);
    return RIC_OK;
}

/* --------------------------------------------------------------- interface */

/* The last digit of the given x and v, carried through the modes to the gaps. */
static void start_noise(ric_simulator *sim, const double *x, const double *v)
{
    int n = sim->n;
    for (int f = 0; f < sim->n_face; f++) {
        face_t *face = &sim->face[f];
        face->noise = 0;
        for (int i = 0; i < n; i++)
            for (int j = 0; j < n; j++) {
                real size = fabs(x[j]) + (sim->omega[i] > 0 ? fabs(v[j]) / sim->omega[i] : 0);
                face->noise += 2 * DBL_EPSILON * fabs(face->c[i] * sim->frame->mphi[i * n + j]) * size;
            }
    }
}

static ric_status check_start(const ric_simulator *sim, const double *x, const double *v)
{
    for (int i = 0; i < sim->n; i++)
        if (!isfinite(x[i]) || !isfinite(v[i]))
            return ric_fail(RIC_E_INPUT, "state: number %d is not finite", isfinite(x[i]) ? sim->n + i + 1 : i + 1);
    return RIC_OK;
}

/* From the modal state of the open frame, with given springs closed or, if none are given, those that it lies beyond. */
static ric_status start_here(ric_simulator *sim, const bool *given)
{
    bool closed[sim->n_face + 1];
    const frame *other;
    for (int f = 0; f < sim->n_face; f++) {
        const face_t *face = &sim->face[f];
        real s = face->side * dot(sim->n, face->c, sim->q);
        closed[f] = face->spring > 0 && (given ? given[f] : s > face->limit * (1 + BEYOND));
        if (!(face->spring > 0) && s > face->limit * (1 + BEYOND))
            return ric_fail(RIC_E_INPUT, "state: face %d is passed by %.3g: its gap coordinate is %.9g and the stop is at %.9g; start on this "
                            "side of it", f, (double)(s - face->limit), (double)(face->side * s), (double)(face->side * face->limit));
    }
    ric_status status = find_frame(sim, closed, &other);
    if (status) return status;
    for (int f = 0; f < sim->n_face; f++) sim->face[f].impulse = 0;
    change_frame(sim, other);
    sim->origin = sim->origin_low = 0;
    sim->reach = 0;
    begin_flight(sim);
    start_reach(sim);
    sim->started = true;
    return RIC_OK;
}

void ric_simulator_modal(const ric_simulator *sim, const double *x, const double *v, ric_real *w)
{
    int n = sim->n;
    real state[2 * n];
    for (int j = 0; j < n; j++) {
        state[j] = x[j];
        state[n + j] = v[j];
    }
    to_modal(sim, sim->open, state, w);
}

ric_status ric_simulator_start(ric_simulator *sim, const double *x, const double *v)
{
    ric_status status = check_start(sim, x, v);
    sim->started = false;
    if (status) return status;
    if (sim->springs) {
        for (int i = 0; i < sim->n; i++) {
            sim->y[i] = x[i];
            sim->y[sim->n + i] = v[i];
        }
        sim->now = sim->reach = 0;
        sim->started = true;
        return RIC_OK;
    }
    enter_frame(sim, sim->open);
    ric_simulator_modal(sim, x, v, sim->q); /* p follows q in memory */
    start_noise(sim, x, v);
    return start_here(sim, NULL);
}

ric_status ric_simulator_start_modal(ric_simulator *sim, const bool *closed, const ric_real *w)
{
    sim->started = false;
    enter_frame(sim, sim->open);
    memcpy(sim->q, w, 2 * (size_t)sim->n * sizeof *w);
    for (int f = 0; f < sim->n_face; f++) sim->face[f].noise = 0;
    return start_here(sim, closed);
}

ric_status ric_simulator_advance(ric_simulator *sim, double t, bool *hit, ric_impact *impact)
{
    *hit = false;
    if (!sim->started) return ric_fail(RIC_E_INPUT, "the simulator has no state yet; start it first");
    real to = (t - sim->origin) - sim->origin_low;
    if (!isfinite(t) || to < sim->now - 4 * DBL_EPSILON * fabs(t))
        return ric_fail(RIC_E_INPUT, "time %.9g is not a time from %.9g on", t, time_of(sim, sim->now));
    to = fmax(to, sim->now);
    if (sim->springs) {
        ric_status gone = ric_springs_go(sim->springs, to - sim->now, sim->y);
        sim->now = to;
        return gone;
    }
    ric_status status = find_next(sim, to);
    if (status) return status;
    if (sim->next <= to) {
        if ((status = strike(sim, impact))) return status;
        *hit = true;
        return RIC_OK;
    }
    scan_reach(sim, to);
    sim->now = to;
    return RIC_OK;
}

/* Displacement and velocity now, x [2n]. */
static void present(const ric_simulator *sim, real *x)
{
    real w[2 * sim->n];
    for (int i = 0; i < sim->n; i++) fly_mode(sim, i, sim->now, w + i, w + sim->n + i);
    to_space(sim, w, w + sim->n, x);
}

void ric_simulator_state(const ric_simulator *sim, double *time, double *x, double *v)
{
    int n = sim->n;
    real state[2 * n];
    if (time) *time = time_of(sim, sim->now);
    for (int j = 0; sim->springs && j < n; j++) {
        if (x) x[j] = (double)sim->y[j];
        if (v) v[j] = (double)sim->y[n + j];
    }
    if (sim->springs) return;
    present(sim, state);
    for (int j = 0; j < n; j++) {
        if (x) x[j] = (double)state[j];
        if (v) v[j] = (double)state[n + j];
    }
}

void ric_simulator_state_modal(const ric_simulator *sim, ric_real *time, ric_real *w)
{
    int n = sim->n;
    real state[2 * n];
    if (time) *time = sim->origin + (sim->origin_low + sim->now);
    if (sim->frame == sim->open) {
        for (int i = 0; i < n; i++) fly_mode(sim, i, sim->now, w + i, w + n + i);
        return;
    }
    present(sim, state);
    to_modal(sim, sim->open, state, w);
}

ric_status ric_simulator_fly(ric_simulator *sim, const bool *closed, bool linear, ric_real t, const ric_real *w, ric_real *after)
{
    int n = sim->n;
    const frame *f;
    real x[2 * n], z[2 * n];
    ric_status status = find_frame(sim, closed, &f);
    if (status) return status;
    for (int j = 0; j < n; j++) {
        x[j] = x[n + j] = 0;
        for (int i = 0; i < n; i++) {
            x[j] += sim->open->phi[i * n + j] * w[i];
            x[n + j] += sim->open->phi[i * n + j] * w[n + i];
        }
    }
    to_modal(sim, f, x, z);
    for (int i = 0; i < n; i++) {
        real omega = f->omega[i], sine, cosine, rest = linear ? 0 : f->rest[i], q = z[i] + f->rest[i] - rest, p = z[n + i];
        sincosl(omega * t, &sine, &cosine);
        z[i] = rest + (omega > 0 ? q * cosine + p / omega * sine : q + p * t);
        z[n + i] = p * cosine - omega * q * sine;
    }
    for (int j = 0; j < n; j++) {
        x[j] = x[n + j] = 0;
        for (int i = 0; i < n; i++) {
            x[j] += f->phi[i * n + j] * z[i];
            x[n + j] += f->phi[i * n + j] * z[n + i];
        }
    }
    to_modal(sim, sim->open, x, after);
    return RIC_OK;
}

void ric_simulator_frame(const ric_simulator *sim, const ric_real **omega, const ric_real **c)
{
    *omega = sim->open->omega;
    *c = sim->open->c;
}
