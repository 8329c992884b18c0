/* The modes of a structure with some springs closed, by Jacobi rotations in extended precision
 * (simulator.c). */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>

#include "simulator_parts.h"
#include "base/room.h"

/* A mode whose displacement at a spring is less than this part of its terms is not held by it. */
#define EXTENDED (64 * LDBL_EPSILON)

bool ric_simulator_cholesky(int n, real *A)
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

/* One rotation that clears A[i][j] of a symmetric A kept in full; V collects the eigenvectors as
 * rows (Golub and Van Loan, 8.5). */
static void clear(int n, int i, int j, real *A, real *V)
{
    real aij = A[i * n + j], theta = (A[j * n + j] - A[i * n + i]) / (2 * aij);
    real t = copysign(1, theta) / (fabs(theta) + hypot(1, theta)), cosine = 1 / hypot(1, t),
         sine = t * cosine;
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
                real scale = sqrt(fabs(A[i * n + i] * A[j * n + j])) +
                             LDBL_EPSILON * (fabs(A[i * n + i]) + fabs(A[j * n + j]));
                if (fabs(A[i * n + j]) <= LDBL_EPSILON * scale) continue;
                clear(n, i, j, A, V);
                done = false;
            }
        if (done) return true;
    }
    return false;
}

/* phi' K phi, with K phi of twice the digits of a double, as it cancels; *size: what it is the sum
 * of. */
static real strain(const ric_simulator *sim, const real *phi, real *size)
{
    const int n = sim->n;
    real sum = 0;
    *size = 0;
    for (int i = 0; i < n; i++) {
        ric_twice force = {0, 0};
        for (int j = 0; j < n; j++) {
            force = ric_twice_add(force, ric_twice_scale(sim->K[i * n + j], ric_twice_of(phi[j])));
            *size += fabs(phi[i] * sim->K[i * n + j] * phi[j]);
        }
        sum += phi[i] * ((real)force.hi + force.lo);
    }
    return sum;
}

/* omega_i of row phi_i in a frame. It is exactly 0 if phi' K phi is no larger than the rounding of
 * the entries of K themselves, and no spring holds it. */
static real frequency(const ric_simulator *sim, const bool *closed, const real *phi)
{
    int n = sim->n;
    real size, sum = strain(sim, phi, &size), springs = 0;
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
            if (omega > 0)
                out->rest[i] += face->spring * face->side * face->limit *
                                out->c[face->contact * n + i] / (omega * omega);
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
    real *L = ric_calloc(3 * nn, sizeof *L), *A = L + nn, *V = A + nn;
    if (!L) {
        status = ric_fail(RIC_E_NOMEM, "no memory for the modes of %d degrees of freedom", n);
        goto out;
    }
    for (size_t i = 0; i < nn; i++) L[i] = sim->M[i];
    assemble(sim, out->closed, A);
    for (int i = 0; i < n; i++) V[i * n + i] = 1;
    if (!ric_simulator_cholesky(n, L)) {
        status = ric_fail(RIC_E_INPUT, "mass matrix is not positive definite");
        goto out;
    }
    solve_rows(n, L, A);
    transpose(n, A);
    solve_rows(n, L, A);
    if (!jacobi(n, A, V)) {
        status = ric_fail(
            RIC_E_NUMERIC,
            "the modes of the structure did not converge; are mass and stiffness scaled sensibly?");
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

void ric_simulator_frame_free(frame *f)
{
    if (!f) return;
    free(f->closed);
    free(f->omega);
    free(f);
}

ric_status ric_simulator_frame_create(ric_simulator *sim, const bool *closed, frame **out)
{
    size_t n = (size_t)sim->n, faces = (size_t)sim->n_face;
    frame *f = ric_calloc(1, sizeof *f);
    *out = NULL;
    if (!f || !(f->closed = ric_calloc(faces + 1, sizeof *f->closed)) ||
        !(f->omega = ric_calloc(2 * n + 3 * n * n + (size_t)sim->n_contact * n,
                                sizeof *f->omega))) {
        ric_simulator_frame_free(f);
        return ric_fail(RIC_E_NOMEM, "no memory for the modes of %d degrees of freedom", sim->n);
    }
    for (size_t i = 0; closed && i < faces; i++) f->closed[i] = closed[i];
    f->rest = f->omega + n;
    f->phi = f->rest + n;
    f->mphi = f->phi + n * n;
    f->turn = f->mphi + n * n;
    f->c = f->turn + n * n;
    ric_status status = make_modes(sim, f);
    if (status) {
        ric_simulator_frame_free(f);
        return status;
    }
    for (size_t i = 0; sim->open && i < n; i++)
        for (size_t j = 0; j < n; j++)
            for (size_t k = 0; k < n; k++)
                f->turn[i * n + j] += f->mphi[i * n + k] * sim->open->phi[j * n + k];
    *out = f;
    return RIC_OK;
}

void ric_simulator_frame_enter(ric_simulator *sim, const frame *f)
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

ric_status ric_simulator_frame_find(ric_simulator *sim, const bool *closed, const frame **out)
{
    frame *last = sim->open, *made;
    for (frame *f = sim->open; f; last = f, f = f->next)
        if (!memcmp(f->closed, closed, (size_t)sim->n_face * sizeof *closed)) {
            *out = f;
            return RIC_OK;
        }
    ric_status status = ric_simulator_frame_create(sim, closed, &made);
    if (!status) *out = last->next = made;
    return status;
}

void ric_simulator_frame_to_space(const ric_simulator *sim, const real *q, const real *p, real *x)
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

void ric_simulator_frame_to_modal(const ric_simulator *sim, const frame *f, bool linear,
                                  const real *x, real *w)
{
    int n = sim->n;
    for (int i = 0; i < n; i++) {
        w[i] = linear ? 0 : -f->rest[i];
        w[n + i] = 0;
        for (int j = 0; j < n; j++) {
            w[i] += f->mphi[i * n + j] * x[j];
            w[n + i] += f->mphi[i * n + j] * x[n + j];
        }
    }
}

void ric_simulator_frame_change(ric_simulator *sim, const frame *f)
{
    ric_simulator_frame_to_space(sim, sim->q, sim->p, sim->x);
    ric_simulator_frame_enter(sim, f);
    ric_simulator_frame_to_modal(sim, f, false, sim->x, sim->q); /* p follows q in memory */
}
