#include "regime.h"

#include <float.h>
#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"

/* SMALL: phases y below which differences of 1, cos y and sin y / y are summed as series */
#define SMALL 0.25
/* NO_STIFFNESS: eigenvalues below this many last digits of the largest, in extended precision, are
 * those of free modes */
#define NO_STIFFNESS 64

struct ric_phases {
    int n_set;
    int *place;                   /* [n_face] 3^k of the contact, 0 if rigid */
    _Atomic(ric_regime *) *table; /* [n_set] */
};

/* --------------------------------------------------------------------- sets */

ric_status ric_regimes_create(ric_model *m)
{
    struct ric_phases *p = ric_calloc(1, sizeof *p);
    int count = 0;
    if (!p || !(p->place = ric_calloc((size_t)m->n_face + 1, sizeof *p->place))) {
        free(p);
        return ric_no_memory("the phases of a model");
    }
    m->phases = p;
    p->n_set = 1;
    for (int f = 0; f < m->n_face; f++) {
        const ric_face *face = &m->face[f];
        if (!(face->spring > 0)) continue;
        if (m->n_face > RIC_FACES_MAX)
            return ric_fail(RIC_E_INPUT,
                            "face %d belongs to a contact of law bilinear; this version takes such "
                            "contacts in structures of %d faces at most, and there are %d, two of "
                            "a contact with both sides: leave out some, or make all contacts rigid",
                            f, RIC_FACES_MAX, m->n_face);
        bool second = f > 0 && m->face[f - 1].contact == face->contact;
        if (second) {
            p->place[f] = p->place[f - 1];
            continue;
        }
        if (++count > RIC_REGIME_CONTACTS)
            return ric_fail(RIC_E_INPUT,
                            "more than %d contacts have law bilinear; this version takes that "
                            "many, as each set of closed ones has "
                            "modes of its own; make some of them rigid",
                            RIC_REGIME_CONTACTS);
        p->place[f] = p->n_set;
        p->n_set *= 3;
    }
    if (!(p->table = ric_calloc((size_t)p->n_set, sizeof *p->table)))
        return ric_fail(RIC_E_NOMEM, "no memory for %d phases", p->n_set);
    return RIC_OK;
}

static void phase_free(ric_regime *phase)
{
    if (!phase) return;
    free(phase->omega); /* all doubles lie behind it */
    free(phase->exact);
    free(phase);
}

void ric_regimes_free(ric_model *m)
{
    struct ric_phases *p = m->phases;
    if (!p) return;
    for (int i = 0; p->table && i < p->n_set; i++) phase_free(atomic_load(&p->table[i]));
    free(p->table);
    free(p->place);
    free(p);
    m->phases = NULL;
}

bool ric_regime_exists(const ric_model *m, uint64_t closed)
{
    for (int f = 0; closed >> f; f++) {
        if (!ric_face_in(closed, f)) continue;
        if (f >= m->n_face || !(m->face[f].spring > 0)) return false;
        if (ric_face_in(closed, m->face[f].mirror)) return false;
    }
    return true;
}

/* Its place in the table: digits to the base of 3, 0 open, 1 upper, 2 lower face closed. */
static int index_of(const ric_model *m, uint64_t closed)
{
    int index = 0;
    for (int f = 0; closed >> f; f++)
        if (ric_face_in(closed, f)) index += (m->face[f].side > 0 ? 1 : 2) * m->phases->place[f];
    return index;
}

/* -------------------------------------------------------------------- modes */

/* Eigenvalues of the symmetric A [n * n] on its diagonal, eigenvectors in the rows of V, by cyclic
 * Jacobi rotations (Golub and Van Loan, Matrix Computations, 8.5): stiff springs grade A, and soft
 * modes keep their digits. False: no convergence. */
static bool jacobi(int n, long double *A, long double *V)
{
    enum { SWEEPS = 64 };
    for (int sweep = 0; sweep < SWEEPS; sweep++) {
        bool done = true;
        for (int i = 0; i < n; i++)
            for (int j = i + 1; j < n; j++) {
                long double off = A[i * n + j], d = A[i * n + i], e = A[j * n + j];
                if (fabsl(off) <=
                    LDBL_EPSILON * (sqrtl(fabsl(d * e)) + LDBL_EPSILON * (fabsl(d) + fabsl(e))))
                    continue;
                done = false;
                long double theta = (e - d) / (2 * off),
                            t = copysignl(1, theta) / (fabsl(theta) + hypotl(1, theta));
                long double co = 1 / hypotl(1, t), si = t * co;
                for (int k = 0; k < n; k++) {
                    long double x = A[k * n + i], y = A[k * n + j];
                    A[k * n + i] = co * x - si * y;
                    A[k * n + j] = si * x + co * y;
                }
                for (int k = 0; k < n; k++) {
                    long double x = A[i * n + k], y = A[j * n + k], v = V[i * n + k],
                                w = V[j * n + k];
                    A[i * n + k] = co * x - si * y;
                    A[j * n + k] = si * x + co * y;
                    V[i * n + k] = co * v - si * w;
                    V[j * n + k] = si * v + co * w;
                }
                A[i * n + i] = d - t * off;
                A[j * n + j] = e + t * off;
                A[i * n + j] = A[j * n + i] = 0;
            }
        if (done) return true;
    }
    return false;
}

/* K_phase [n * n] and the constant force f [n] in modal coordinates. */
static void assemble(const ric_model *m, uint64_t closed, long double *K, long double *f)
{
    int n = m->n;
    for (int i = 0; i < n; i++) {
        long double omega = (long double)m->omega[i] + m->omega_low[i];
        K[i * n + i] = omega * omega;
    }
    for (int g = 0; closed >> g; g++) {
        const ric_face *face = &m->face[g];
        if (!ric_face_in(closed, g)) continue;
        for (int i = 0; i < n; i++) {
            f[i] += (long double)face->spring * face->c[i] * face->gap;
            for (int j = 0; j < n; j++)
                K[i * n + j] += (long double)face->spring * face->c[i] * face->c[j];
        }
    }
}

static bool allocate(ric_regime *p, int n, int n_contact)
{
    size_t k = (size_t)n, c = (size_t)n_contact;
    if (!(p->omega = ric_calloc(4 * k + 3 * k * k + c * (k + 1), sizeof(double)))) return false;
    if (!(p->exact = ric_calloc(3 * k * k + k, sizeof *p->exact))) return false;
    p->omega_low = p->omega + k;
    p->kappa = p->omega_low + k;
    p->shift = p->kappa + k;
    p->into = p->shift + k;
    p->from = p->into + k * k;
    p->U = p->from + k * k;
    p->G = p->U + k * k;
    p->rest = p->G + c * k;
    return true;
}

/* From eigenvalues `square` (stride n + 1), eigenvectors in the rows of V, and force f. */
static void fill(const ric_model *m, ric_regime *p, const long double *square, const long double *V,
                 const long double *f)
{
    int n = p->n;
    long double largest = 0, balance[n], *x = p->exact;
    for (int i = 0; i < n; i++) largest = fmaxl(largest, fabsl(square[i * (n + 1)]));
    for (int i = 0; i < n; i++) {
        const long double *v = V + i * n;
        long double value = square[i * (n + 1)], pull = 0;
        bool holds = value > NO_STIFFNESS * LDBL_EPSILON * n * largest;
        long double omega = holds ? sqrtl(value) : 0, kappa = holds ? omega : 1;
        for (int j = 0; j < n; j++) pull += v[j] * f[j];
        balance[i] = holds ? pull / value : 0; /* what holds no mode pushes none */
        p->omega[i] = (double)omega;
        p->omega_low[i] = (double)(omega - p->omega[i]);
        p->kappa[i] = (double)kappa;
        p->shift[i] = (double)(x[3 * n * n + i] = kappa * balance[i]);
        for (int j = 0; j < n; j++) {
            p->into[i * n + j] = (double)(x[i * n + j] = kappa * v[j] / m->kappa[j]);
            p->from[j * n + i] = (double)(x[n * n + j * n + i] = m->kappa[j] * v[j] / kappa);
            p->U[j * n + i] = (double)(x[2 * n * n + j * n + i] = v[j]);
        }
    }
    for (int c = 0; c < m->n_contact; c++) {
        long double rest = 0;
        for (int i = 0; i < n; i++) {
            long double sum = 0;
            for (int j = 0; j < n; j++) sum += V[i * n + j] * m->c[c * n + j];
            p->G[c * n + i] = (double)(sum / (p->omega[i] > 0
                                                  ? (long double)p->omega[i] + p->omega_low[i]
                                                  : 1));
            rest += sum * balance[i];
        }
        p->rest[c] = (double)rest;
    }
}

static ric_status phase_create(const ric_model *m, uint64_t closed, ric_regime **out)
{
    ric_status status = RIC_OK;
    int n = m->n;
    size_t nn = (size_t)n * (size_t)n;
    ric_regime *p = ric_calloc(1, sizeof *p);
    long double *K = ric_calloc(3 * nn + (size_t)n, sizeof *K), *A = K + nn, *V = A + nn,
                *f = V + nn;
    *out = NULL;
    if (!p || !K || !allocate(p, n, m->n_contact)) {
        status = ric_no_memory("the modes with closed contacts");
        goto out;
    }
    p->n = n;
    assemble(m, closed, K, f);
    memcpy(A, K, nn * sizeof *A);
    for (int i = 0; i < n; i++) V[i * n + i] = 1;
    if (!jacobi(n, A, V)) {
        status = ric_fail(RIC_E_NUMERIC, "the modes with closed contacts do not converge");
        goto out;
    }
    fill(m, p, A, V, f);
    *out = p;
    p = NULL;
out:
    phase_free(p);
    free(K);
    return status;
}

ric_status ric_regime_get(const ric_model *m, uint64_t closed, const ric_regime **out)
{
    *out = NULL;
    if (!ric_regime_exists(m, closed))
        return ric_fail(RIC_E_NUMERIC, "both faces of a contact cannot be closed at one time");
    _Atomic(ric_regime *) *slot = &m->phases->table[index_of(m, closed)];
    ric_regime *known = atomic_load(slot), *made = NULL;
    if (!known) {
        ric_status status = phase_create(m, closed, &made);
        if (status) return status;
        if (atomic_compare_exchange_strong(slot, &known, made)) known = made;
        else phase_free(made); /* another thread was faster */
    }
    *out = known;
    return RIC_OK;
}

/* ------------------------------------------------------------------- flight */

/* Routines `_of` have the number of modes known to the compiler for the small structures that most
 * atlases are made of; their sums have one order whatever it is. */
#define INLINE static inline __attribute__((always_inline))

/* A = omega (r - rest) is the difference of displacements a thousand times the depth of a contact:
 * taken in doubles it loses as many digits, and they are missing in the velocity that a stiff
 * spring gives back. */

INLINE void enter_of(const ric_regime *p, int n, const double *w, double *z)
{
    const long double *into = p->exact, *U = into + 2 * n * n, *shift = U + n * n;
    double x[2 * n];
    for (int i = 0; i < n; i++) {
        long double a = -shift[i], v = 0;
        for (int j = 0; j < n; j++) {
            a += into[i * n + j] * w[j];
            v += U[j * n + i] * w[n + j];
        }
        x[i] = (double)a;
        x[n + i] = (double)v;
    }
    memcpy(z, x, sizeof x);
}

void ric_regime_enter(const ric_regime *p, const double *w, double *z)
{
    enter_of(p, p->n, w, z);
}

/* From the face that closes there: displacements at the clearance to the last digit of extended
 * precision. Not in place. */
INLINE void enter_at(const ric_regime *p, int n, const ric_face *closing, const double *w,
                     double *z)
{
    const long double *into = p->exact, *shift = p->exact + 3 * n * n;
    long double off = 0, size = 0;
    enter_of(p, n, w, z);
    if (!closing) return;
    for (int i = 0; i < n; i++) {
        off += (long double)closing->g[i] * w[i];
        size += (long double)closing->g[i] * closing->g[i];
    }
    off = (off - closing->gap) / size;
    for (int i = 0; i < n; i++) {
        long double a = -shift[i];
        for (int j = 0; j < n; j++) a += into[i * n + j] * (w[j] - off * closing->g[j]);
        z[i] = (double)a;
    }
}

void ric_regime_onto(int n, const ric_face *closing, int ld, double *X)
{
    double size = ric_dot(n, closing->g, closing->g);
    for (int j = 0; j < ld; j++) {
        double along = 0;
        for (int i = 0; i < n; i++) along += closing->g[i] * X[i * ld + j];
        for (int i = 0; i < n; i++) X[i * ld + j] -= along / size * closing->g[i];
    }
}

INLINE void leave_of(const ric_regime *p, int n, const double *z, double *w)
{
    const long double *from = p->exact + n * n, *U = from + n * n, *shift = U + n * n;
    double x[2 * n];
    for (int i = 0; i < n; i++) {
        long double a = 0, v = 0;
        for (int j = 0; j < n; j++) {
            a += from[i * n + j] * (z[j] + shift[j]);
            v += U[i * n + j] * z[n + j];
        }
        x[i] = (double)a;
        x[n + i] = (double)v;
    }
    memcpy(w, x, sizeof x);
}

void ric_regime_leave(const ric_regime *p, const double *z, double *w)
{
    leave_of(p, p->n, z, w);
}

/* cos and sin of omega tau of two modes, with what rounding took from the phases. */
INLINE void turn(const ric_regime *p, int i, int j, double tau, ric_lane *co, ric_lane *si)
{
    const ric_lane omega = {p->omega[i], p->omega[j]},
                   omega_low = {p->omega_low[i], p->omega_low[j]}, y = omega * tau,
                   lost = {fma(omega[0], tau, -y[0]), fma(omega[1], tau, -y[1])},
                   low = lost + omega_low * tau;
    ric_lane s, c;
    ric_sine_lanes(y, &s, &c);
    *co = c - low * s;
    *si = s + low * c;
}

/* The same of all, [n] each. */
INLINE void turns_of(const ric_regime *p, int n, double tau, double *co, double *si)
{
    ric_lane c, s;
    for (int i = 0; i + 1 < n; i += 2) {
        turn(p, i, i + 1, tau, &c, &s);
        ric_lane_store(co + i, c);
        ric_lane_store(si + i, s);
    }
    if (n % 2 == 0) return;
    turn(p, n - 1, n - 1, tau, &c, &s);
    co[n - 1] = c[0];
    si[n - 1] = s[0];
}

/* By the cosines and sines of its modes. */
INLINE void fly_of(const ric_regime *p, int n, const ric_regime_course *from,
                   const double *const turns[2], double *after, double *pull)
{
    const double *co = turns[0], *si = turns[1];
    double z[2 * n];
    enter_at(p, n, from->closing, from->w, z);
    for (int i = 0; i < n; i++) {
        double A = z[i], P = z[n + i];
        z[i] = p->omega[i] > 0 ? co[i] * A + si[i] * P : A + from->tau * P;
        z[n + i] = p->omega[i] > 0 ? co[i] * P - si[i] * A : P;
    }
    leave_of(p, n, z, after);
    for (int i = 0; pull && i < n; i++) {
        pull[i] = 0;
        for (int j = 0; j < n; j++) pull[i] -= p->U[i * n + j] * p->omega[j] * z[j];
    }
}

INLINE void matrix_of(const ric_regime *p, int n, double tau, const double *co, const double *si,
                      double *D)
{
    int ld = 2 * n;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            double aa = 0, ap = 0, pa = 0, pp = 0;
            for (int k = 0; k < n; k++) {
                const bool turns = p->omega[k] > 0;
                double f = p->from[i * n + k], u = p->U[i * n + k], t = p->into[k * n + j],
                       v = p->U[j * n + k];
                aa += f * co[k] * t;
                ap += f * (turns ? si[k] : tau) * v;
                pa -= u * (turns ? si[k] : 0) * t;
                pp += u * co[k] * v;
            }
            D[i * ld + j] = aa;
            D[i * ld + n + j] = ap;
            D[(n + i) * ld + j] = pa;
            D[(n + i) * ld + n + j] = pp;
        }
}

INLINE void map_of(const ric_regime *p, int n, const ric_regime_course *from, double *D,
                   double *after, double *pull)
{
    double co[n], si[n];
    turns_of(p, n, from->tau, co, si);
    fly_of(p, n, from, (const double *const[]){co, si}, after, pull);
    if (D) matrix_of(p, n, from->tau, co, si, D);
}

void ric_regime_map(const ric_regime *p, const ric_regime_course *from, double *D, double *after,
                    double *pull)
{
    switch (p->n) {
    case 2: map_of(p, 2, from, D, after, pull); break;
    case 3: map_of(p, 3, from, D, after, pull); break;
    default: map_of(p, p->n, from, D, after, pull);
    }
}

void ric_regime_fly(const ric_regime *p, const ric_regime_course *from, double *after)
{
    ric_regime_map(p, from, NULL, after, NULL);
}

void ric_regime_matrix(const ric_regime *p, double tau, double *D)
{
    const int n = p->n;
    double co[n], si[n];
    turns_of(p, n, tau, co, si);
    matrix_of(p, n, tau, co, si, D);
}

/* ------------------------------------------------------ extended precision */

void ric_regime_turn_fine(const ric_regime *p, long double tau, long double *by)
{
    for (int i = 0; i < p->n; i++, by += 3) {
        long double omega = (long double)p->omega[i] + p->omega_low[i];
        ric_sine_cosine_fine(omega * tau, &by[1], &by[0]);
        by[2] = by[1];
        if (!(omega > 0)) by[1] = tau;
    }
}

INLINE void fly_fine_of(const ric_regime *p, int n, const long double *by, int ld, bool states,
                        long double *W)
{
    const long double *into = p->exact, *from = into + n * n, *U = from + n * n, *shift = U + n * n;
    for (int c = 0; c < ld; c++) {
        long double z[2 * n];
        for (int i = 0; i < n; i++) {
            long double A = states ? -shift[i] : 0, P = 0;
            for (int j = 0; j < n; j++) {
                A += into[i * n + j] * W[j * ld + c];
                P += U[j * n + i] * W[(n + j) * ld + c];
            }
            z[i] = by[3 * i] * A + by[3 * i + 1] * P + (states ? shift[i] : 0);
            z[n + i] = by[3 * i] * P - by[3 * i + 2] * A;
        }
        for (int i = 0; i < n; i++) {
            long double a = 0, v = 0;
            for (int j = 0; j < n; j++) {
                a += from[i * n + j] * z[j];
                v += U[i * n + j] * z[n + j];
            }
            W[i * ld + c] = a;
            W[(n + i) * ld + c] = v;
        }
    }
}

void ric_regime_fly_fine(const ric_regime *p, const long double *by, int ld, bool states,
                         long double *W)
{
    switch (p->n) {
    case 2: fly_fine_of(p, 2, by, ld, states, W); break;
    case 3: fly_fine_of(p, 3, by, ld, states, W); break;
    default: fly_fine_of(p, p->n, by, ld, states, W);
    }
}

/* -------------------------------------------------------- divided difference */

/* (1 - cos y) / y and sin y / y with their derivatives, regular at y = 0. */
static void ratios(double y, double *h1, double *h2, double *d1, double *d2)
{
    if (fabs(y) < SMALL) {
        double x = y * y; /* the next terms are below x^6 / 13! = 1e-17 */
        *h1 = y / 2 * (1 - x / 12 * (1 - x / 30 * (1 - x / 56 * (1 - x / 90))));
        *h2 = 1 - x / 6 * (1 - x / 20 * (1 - x / 42 * (1 - x / 72)));
        *d1 = 0.5 * (1 - x / 4 * (1 - x / 18 * (1 - x / 40 * (1 - x / 70))));
        *d2 = -y / 3 * (1 - x / 10 * (1 - x / 28 * (1 - x / 54 * (1 - x / 88))));
        return;
    }
    ric_lane s, c; /* of y and its half */
    ric_sine_lanes((ric_lane){y, y / 2}, &s, &c);
    *h1 = 2 * s[1] * s[1] / y;
    *h2 = s[0] / y;
    *d1 = (s[0] - *h1) / y;
    *d2 = (c[0] - *h2) / y;
}

INLINE double chord_of(const ric_regime *p, int n, const ric_regime_course *from, int contact,
                       double *by_w, double *by_tau)
{
    const double *G = p->G + contact * n, tau = from->tau;
    double z[2 * n], kA[n], kP[n], sum = 0, slope = 0;
    enter_at(p, n, from->closing, from->w, z);
    for (int i = 0; i < n; i++) {
        double omega = p->omega[i], h1, h2, d1, d2;
        ratios(omega * tau, &h1, &h2, &d1, &d2);
        kA[i] = -G[i] * omega * h1;
        kP[i] = omega > 0 ? G[i] * omega * h2 : G[i];
        sum += kA[i] * z[i] + kP[i] * z[n + i];
        slope += G[i] * omega * omega * (d2 * z[n + i] - d1 * z[i]);
    }
    if (by_tau) *by_tau = slope;
    for (int j = 0; by_w && j < n; j++) {
        by_w[j] = by_w[n + j] = 0;
        for (int i = 0; i < n; i++) {
            by_w[j] += kA[i] * p->into[i * n + j];
            by_w[n + j] += kP[i] * p->U[j * n + i];
        }
    }
    return sum;
}

double ric_regime_chord(const ric_regime *p, const ric_regime_course *from, int contact,
                        double *by_w, double *by_tau)
{
    switch (p->n) {
    case 2: return chord_of(p, 2, from, contact, by_w, by_tau);
    case 3: return chord_of(p, 3, from, contact, by_w, by_tau);
    default: return chord_of(p, p->n, from, contact, by_w, by_tau);
    }
}
