#include "floquet_map.h"

#include <complex.h>
#include <float.h>
#include <math.h>
#include <string.h>

#include <lapacke.h>

#include "base/room.h"

/* SMOOTH_STEPS: of law power, in the same units: several of its steps make one error, tens of them
 * a period */
#define SMOOTH_STEPS 12
#define NO_SPEED 1e-60

/* ---------------------------------------------------------------- sections */

/* At a touch a derivative by the time of impact has no bound: its sign and a size far beyond any
 * regular one are kept, the products are scaled. */
static double not_zero(double speed)
{
    return fabs(speed) < NO_SPEED ? copysign(NO_SPEED, speed) : speed;
}

/* A mirror point at an impact, w on one side of it: the reversal followed by the impact keeps
 * displacements along the face and the normal velocity, the latter less what the force `pull` makes
 * of a normal displacement. These are the coordinates of what is symmetric, so that normal
 * displacement and velocity of the columns V [2n * count] exchange their roles: (q, p) -> (p -
 * slope q, -q), which is canonical and does not divide by the speed but for the kick that there is.
 */
static void exchange(const ric_shooting *c, uint64_t closed, const double *w, const ric_face *f,
                     bool back, int count, double *V)
{
    int n = c->n;
    const ric_model *m = c->model;
    double rate[2 * n], length = sqrt(f->cc);
    ric_flight_rate(m, closed, w, rate);
    double slope = ric_dot(n, f->c, rate + n) / not_zero(ric_dot(n, f->c, w + n));
    for (int j = 0; j < count; j++) {
        double q = 0, p = 0;
        for (int i = 0; i < n; i++) {
            q += f->g[i] * V[i * count + j] / length;
            p += f->c[i] * V[(n + i) * count + j] / length;
        }
        double x = back ? -p : p - slope * q, y = back ? q - slope * p : -q;
        for (int i = 0; i < n; i++) {
            V[i * count + j] += (x - q) * m->kappa[i] * f->c[i] / length;
            V[(n + i) * count + j] += (y - p) * f->c[i] / length;
        }
    }
}

/* The direction h [n] that the section of a mirror point leaves out, which is the velocity at a
 * centre, else the gradient of the energy in the coordinates of what is symmetric. E is what is
 * perpendicular to it. Written in canonical coordinates (q, p). */
static void left_out(const ric_shooting *c, ric_mirror mirror, uint64_t closed, const double *w,
                     int face, double *h)
{
    int n = c->n;
    double rate[2 * n];
    ric_flight_rate(c->model, closed, w, rate);
    if (mirror == RIC_MIRROR_IMPACT) exchange(c, closed, w, &c->model->face[face], false, 1, rate);
    for (int i = 0; i < n; i++) h[i] = mirror == RIC_MIRROR_CENTRE ? w[n + i] : -rate[n + i];
}

/* Columns of the section at the start as states (da, dp): the first k move q along E, the others p
 * along E. */
static void section_columns(const ric_shooting *c, const double *E, double *V)
{
    int n = c->n, k = n - 1, ld = 2 * k;
    const ric_model *m = c->model;
    memset(V, 0, (size_t)2 * (size_t)n * (size_t)ld * sizeof *V);
    for (int j = 0; j < k; j++)
        for (int i = 0; i < n; i++) {
            V[i * ld + j] = m->kappa[i] * E[j * n + i];
            V[(n + i) * ld + k + j] = E[j * n + i];
        }
    if (c->start == RIC_MIRROR_IMPACT)
        exchange(c, c->closed[0], c->w, &m->face[c->face[0]], true, ld, V);
}

/* Coordinates (E dq, E dp) of a state's columns at the end, on the side of an impact that V is on;
 * V is used up. */
static void project(const ric_shooting *c, const double *h, double *V, double *P)
{
    int n = c->n, k = n - 1, ld = 2 * k, last = c->n_flight;
    const ric_model *m = c->model;
    if (c->end == RIC_MIRROR_IMPACT)
        exchange(c, c->closed[last], c->w + 2 * n * last, &m->face[c->face[last]], false, ld, V);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < ld; j++) V[i * ld + j] /= m->kappa[i];
    ric_model_across(n, h, ld, ld, V);
    ric_model_across(n, h, ld, ld, V + n * ld);
    memcpy(P, V, (size_t)(k * ld) * sizeof *P);
    memcpy(P + k * ld, V + n * ld, (size_t)(k * ld) * sizeof *P);
}

/* ------------------------------------------------------------- propagation */

/* One impact at w, the state right after it, on columns: both q and p are reflected, and p gets a
 * kick proportional to 1 / speed (saltation, eq. 41-46 of the article in modal coordinates). The
 * kick goes with the whole force that pulls the structure towards the stop, that of the closed
 * springs included (docs/theory.md section 5). */
static inline __attribute__((always_inline)) void saltation(const ric_model *m, int n,
                                                            const ric_face *f, uint64_t closed,
                                                            const double *w, const double *before,
                                                            double *V)
{
    const int ld = 2 * (n - 1);
    double rate[2 * n];
    if (ric_flight_law_of(m)->turns) ric_flow(m, n, w, rate); /* no contact pushes */
    else ric_flight_rate(m, closed, w, rate);
    double speed = not_zero(ric_dot(n, f->c, before)), pull = ric_dot(n, f->c, rate + n);
    double kick = 2 * pull / (f->cc * speed);
    for (int j = 0; j < ld; j++) {
        double gap = 0, push = 0;
        for (int i = 0; i < n; i++) {
            gap += f->g[i] * V[i * ld + j];
            push += f->c[i] * V[(n + i) * ld + j];
        }
        double dq = 2 * gap / f->cc, dp = 2 * push / f->cc - kick * gap;
        for (int i = 0; i < n; i++) {
            V[i * ld + j] -= dq * m->kappa[i] * f->c[i];
            V[(n + i) * ld + j] -= dp * f->c[i];
        }
    }
}

/* Keeps the columns finite: returns the power of two taken out. */
static inline __attribute__((always_inline)) int rescale(int count, double *V, double *largest)
{
    double top = 0;
    int exponent;
    for (int i = 0; i < count; i++) top = ric_raise(top, fabs(V[i]));
    *largest = top;
    if (top < 0x1p200) return 0;
    frexp(top, &exponent);
    for (int i = 0; i < count; i++) V[i] = ldexp(V[i], -exponent);
    *largest = ldexp(top, -exponent);
    return exponent;
}

/* Takes V through the flights from .. to - 1; *exponent collects the scaling, *growth the largest
 * entry met (scaled likewise). */
static inline __attribute__((always_inline)) void propagate_of(const ric_shooting *c, int n,
                                                               const int *span, double *V,
                                                               int *exponent, double *growth)
{
    const int ld = 2 * (n - 1);
    const ric_model *m = c->model;
    *exponent = 0;
    *growth = 1;
    for (int k = span[0]; k < span[1]; k++) {
        const double *map = c->map + c->stride * (size_t)k;
        bool dense = ric_flight_dense(m, c->closed[k]), ends = k + 1 == c->n_flight;
        if (dense) ric_flight_carry(n, map, ld, ld, V);
        else
            for (int i = 0; i < n; i++) {
                double *a = V + i * ld, *p = V + (n + i) * ld, co = map[i], s1 = map[n + i],
                       s2 = map[2 * n + i];
                for (int j = 0; j < ld; j++) {
                    double t = a[j];
                    a[j] = co * t + s1 * p[j];
                    p[j] = co * p[j] - s2 * t;
                }
            }
        bool struck = c->face[k + 1] >= 0 && m->face[c->face[k + 1]].spring == 0 &&
                      !(ends && c->end == RIC_MIRROR_IMPACT);
        if (!struck && !dense) continue;
        double top;
        if (struck)
            saltation(m, n, &m->face[c->face[k + 1]], c->closed[k], c->w + 2 * n * (k + 1),
                      c->before + n * k, V);
        int shift = rescale(2 * n * ld, V, &top);
        *exponent += shift;
        *growth = ric_larger(shift ? ldexp(*growth, -shift) : *growth, top);
    }
}

static void propagate(const ric_shooting *c, int from, int to, double *V, int *exponent,
                      double *growth)
{
    const int span[2] = {from, to};
    switch (c->n) {
    case 2: propagate_of(c, 2, span, V, exponent, growth); break;
    case 3: propagate_of(c, 3, span, V, exponent, growth); break;
    default: propagate_of(c, c->n, span, V, exponent, growth);
    }
}

/* --------------------------------------------------------- small matrices */

double ric_floquet_map_determinant(int k, int ld, const double *A, double *work, double rounding,
                                   double *error)
{
    double det = 1, others = 1, least = HUGE_VAL;
    *error = 0;
    if (k == 0) return 1;
    for (int i = 0; i < k; i++) memcpy(work + i * k, A + i * ld, (size_t)k * sizeof *work);
    det = ric_dense_factor(k, work);
    for (int i = 0; i < k; i++) {
        double p = work[i * k + i];
        det *= p;
        if (fabs(p) < least) {
            if (least < HUGE_VAL) others *= least;
            least = fabs(p);
        } else others *= fabs(p);
    }
    *error = k * rounding * others;
    return det;
}

/* ------------------------------------------------------------ reversible */

void ric_floquet_map_blocks(const ric_shooting *c, const double *P, double *a, double *b,
                            double *cc, double *d)
{
    int k = c->n - 1, ld = 2 * k;
    bool start = c->start == RIC_MIRROR_CENTRE, end = c->end == RIC_MIRROR_CENTRE;
    for (int r = 0; r < k; r++)
        for (int j = 0; j < k; j++) {
            int s = start ? k + j : j,
                t = start ? j : k + j; /* columns: symmetric, antisymmetric */
            int S = end ? k + r : r, T = end ? r : k + r;
            double from = start ? -1 : 1, to = end ? -1 : 1;
            a[r * k + j] = P[S * ld + s];
            b[r * k + j] = from * P[S * ld + t];
            cc[r * k + j] = to * P[T * ld + s];
            d[r * k + j] = from * to * P[T * ld + t];
        }
}

/* Hadamard's bound of the determinants of two blocks side by side: no pivot, which may change its
 * place, but the lengths of their common rows. */
static double bound(int k, const double *left, const double *right)
{
    double product = 1;
    for (int r = 0; r < k; r++) {
        double sum = 0;
        for (int j = 0; j < k; j++)
            sum += left[r * k + j] * left[r * k + j] + right[r * k + j] * right[r * k + j];
        product *= sqrt(sum);
    }
    return product;
}

/* What closing or opening of a spring at event k adds to the roundings: its time is off by the
 * rounding of its gap over the speed there (over what the speed changes by, where it is less), its
 * stiffness acts so much too long, and where a family is almost one of two parameters that turns up
 * in the trace with its full size (two equal modes beside a spring of 4,400 times their stiffness:
 * 9e-12 of a trace that is 2). */
static double of_switch(const ric_shooting *c, int k)
{
    int n = c->n;
    const ric_face *f = &c->model->face[c->face[k]];
    double rate[2 * n];
    ric_flight_rate(c->model, c->closed[k], c->w + 2 * n * k, rate);
    return f->spring * f->cc * c->scale /
           not_zero(fabs(c->approach[k]) + fabs(ric_dot(n, f->c, rate + n)));
}

/* Roundings that a state goes through: one of a rigid flight, one of every step of a smooth one. */
static double steps(const ric_shooting *c)
{
    return ric_flight_law_of(c->model)->integrated ? SMOOTH_STEPS : c->n_flight + 2;
}

/* Determinants, whose signs
 * tell branch points, are bounded without: what moves them by less than themselves is looked for by
 * moving the orbit. */
double ric_floquet_map_roundings(const ric_shooting *c)
{
    double sum = steps(c);
    for (int k = 1; k <= c->n_flight; k++)
        if (c->face[k] >= 0 && c->model->face[c->face[k]].spring > 0) sum += of_switch(c, k);
    return sum;
}

ric_floquet_linear ric_floquet_map_reversible(const ric_shooting *c, ric_floquet *f)
{
    int n = c->n, k = n - 1, ld = 2 * k;
    double *V = f->work, *P = V + 2 * n * ld, *E0 = P + ld * ld, *E1 = E0 + k * n, *a = E1 + k * n,
           *b = a + k * k, *cc = b + k * k, *d = cc + k * k, *A = d + k * k, first[n], last[n];
    ric_floquet_linear q =
        {.P = P, .E0 = E0, .E1 = E1, .a = a, .b = b, .c = cc, .d = d, .A = A, .tmp = A + k * k};
    left_out(c, c->start, c->closed[0], c->w, c->face[0], first);
    left_out(c, c->end, c->closed[c->n_flight], c->w + 2 * n * c->n_flight, c->face[c->n_flight],
             last);
    ric_model_complement(n, first, E0);
    ric_model_complement(n, last, E1);
    section_columns(c, E0, V);
    propagate(c, 0, c->n_flight, V, &q.exponent, &q.growth);
    project(c, last, V, P);
    ric_floquet_map_blocks(c, P, a, b, cc, d);
    for (int i = 0; i < ld * ld; i++) q.size = fmax(q.size, fabs(P[i]));
    q.size = fmax(q.size, q.growth);
    double rounding = RIC_FLOQUET_ROUNDING * DBL_EPSILON * steps(c) * q.size;
    if (f->coarse && k > RIC_FLOQUET_MOST_PAIRS)
        return q; /* they would tell whether to make another map */
    f->det_a = ric_floquet_map_determinant(k, k, a, q.tmp, rounding, &f->error_a);
    f->det_b = ric_floquet_map_determinant(k, k, b, q.tmp, rounding, &f->error_b);
    f->det_d = ric_floquet_map_determinant(k, k, d, q.tmp, rounding, &f->error_d);
    f->size_a = f->size_b = bound(k, a, b);
    f->size_d = bound(k, cc, d);
    return q;
}

/* --------------------------------------------------------------- general */

/* No event is cut at: a map on the face of a slow impact has entries of 1 / speed^2, whose sum is
 * all that is wanted (1e7 and 1e-9 of the trace at a speed of 2.4e-4 of the fastest). q + i p has a
 * complex structure that turns the gradient of the energy into the flow; a unitary basis of the
 * complement of the gradient is a symplectic basis of what is perpendicular to both, real parts
 * first. At the start of a flight: V [2n * ld] as states; inner products with dual [2n * ld] are
 * coordinates. */
static void free_section(const ric_shooting *c, int flight, double *V, double *dual)
{
    int n = c->n, k = n - 1, ld = 2 * k;
    const ric_model *m = c->model;
    const double *w = c->w + 2 * n * flight;
    double h[2 * n], norm = 0, lead;
    double complex eta[n];
    ric_flight_secant(m, c->closed[flight], w, w, h);
    for (int i = 0; i < n; i++) {
        eta[i] = m->kappa[i] * h[i] + I * h[n + i];
        norm += creal(eta[i]) * creal(eta[i]) + cimag(eta[i]) * cimag(eta[i]);
    }
    /* rows 1.. of the Householder reflection that takes eta to a multiple of e_0 */
    norm = sqrt(norm);
    lead = cabs(eta[0]);
    eta[0] += lead > 0 ? eta[0] / lead * norm : norm;
    double beta = 1 / (norm * (norm + lead));
    for (int j = 0; j < k; j++)
        for (int i = 0; i < n; i++) {
            double complex e = (i == j + 1) - beta * eta[i] * conj(eta[j + 1]);
            double kappa = m->kappa[i], inverse = 1 / kappa;
            V[i * ld + j] = kappa * creal(e);
            V[i * ld + k + j] = -kappa * cimag(e);
            dual[i * ld + j] = inverse * creal(e);
            dual[i * ld + k + j] = -inverse * cimag(e);
            V[(n + i) * ld + j] = dual[(n + i) * ld + j] = cimag(e);
            V[(n + i) * ld + k + j] = dual[(n + i) * ld + k + j] = creal(e);
        }
}

/* P [ld * ld]: coordinates of V with the basis that dual belongs to. */
static void in_section(int n, const double *dual, const double *V, double *P)
{
    int ld = 2 * (n - 1);
    memset(P, 0, (size_t)(ld * ld) * sizeof *P);
    for (int r = 0; r < ld; r++)
        for (int i = 0; i < 2 * n; i++)
            for (int j = 0; j < ld; j++) P[r * ld + j] += dual[i * ld + r] * V[i * ld + j];
}

/* P [ld * ld] of the return map; V and dual [2n * ld] are workspace. */
static void return_map(const ric_shooting *c, double *V, double *dual, double *P, int *exponent,
                       double *growth)
{
    free_section(c, 0, V, dual);
    propagate(c, 0, c->n_flight, V, exponent, growth);
    in_section(c->n, dual, V, P);
}

/* The impact between two halves of about the same growth, which is that of 1 / speed. 0: there is
 * none. */
static int middle_impact(const ric_shooting *c)
{
    int best = 0;
    double all = 0, half = 0, off = HUGE_VAL;
    for (int k = 1; k <= c->n_flight; k++) all += log(fmax(c->approach[k], NO_SPEED));
    for (int k = 1; k < c->n_flight; k++) {
        half += log(fmax(c->approach[k], NO_SPEED));
        double next = fabs(half - all / 2);
        if (next >= off) continue;
        off = next;
        best = k;
    }
    return best;
}

bool ric_floquet_map_halves(const ric_shooting *c, double *work, double *V, ric_floquet_pairs *out)
{
    int n = c->n, k = n - 1, ld = 2 * k, exponent[2], middle;
    if (!ric_flight_law_of(c->model)->turns || k > RIC_FLOQUET_MOST_PAIRS ||
        !(middle = middle_impact(c)))
        return false;
    double *P1 = work, *P2 = P1 + ld * ld, *X = P2 + ld * ld, *Y = X + ld * ld, *H = Y + ld * ld,
           *first = H, *second = first + 2 * n * ld, growth[2], mu[2 * ld], error[ld], rho[2 * k],
           apart[k];
    free_section(c, 0, V, first);
    propagate(c, 0, middle, V, &exponent[0], &growth[0]);
    free_section(c, middle, X, second); /* 2n * ld fit into X and Y together, as both bases fit into
                                           H, for k > 1 */
    in_section(n, second, V, P1);
    propagate(c, middle, c->n_flight, X, &exponent[1], &growth[1]);
    in_section(n, first, X, P2);
    if (exponent[0] || exponent[1]) return false;
    ric_floquet_pairs_inverse(k, P2, c->sigma, P1, X);
    ric_floquet_pairs_inverse(k, P1, c->sigma, P2, Y);
    double size = fmax(growth[0], growth[1]);
    for (int i = 0; i < ld * ld; i++) size = fmax(size, fmax(fabs(P1[i]), fabs(P2[i])));
    double rounding = 2 * RIC_FLOQUET_ROUNDING * DBL_EPSILON * ric_floquet_map_roundings(c) * size;
    if (!isfinite(size) || !ric_eigen_product(ld, X, Y, rounding, H, mu, error)) return false;
    ric_floquet_pairs_up(k, mu, rho, apart);
    for (int i = 0; i < k; i++) {
        out->rho[2 * i] = c->sigma * rho[2 * i] - 2;
        out->rho[2 * i + 1] = c->sigma * rho[2 * i + 1];
        double best = HUGE_VAL; /* the error is that of the nearest of the two */
        out->error[i] = apart[i];
        for (int j = 0; j < ld; j++) {
            double distance = hypot(mu[2 * j] - rho[2 * i], mu[2 * j + 1] - rho[2 * i + 1]);
            if (distance > best) continue;
            best = distance;
            out->error[i] = fmax(apart[i], error[j]);
        }
        out->alone[i] = out->error[i];
    }
    return true;
}

ric_floquet_linear ric_floquet_map_whole(const ric_shooting *c, ric_floquet *f)
{
    int n = c->n, k = n - 1, ld = 2 * k;
    double *V = f->work, *P = V + 2 * n * ld, *A = P + ld * ld;
    ric_floquet_linear q = {.P = P, .A = A, .tmp = A + ld * ld};
    return_map(c, V, A, P, &q.exponent, &q.growth); /* A and tmp together hold 2n * ld */
    q.size = q.growth;
    for (int i = 0; i < ld * ld; i++) {
        P[i] *= c->sigma;
        q.size = fmax(q.size, fabs(P[i]));
    }
    f->det_a = f->det_b = f->det_d = 1;
    f->error_a = f->error_b = f->error_d = 0;
    f->size_a = f->size_b = f->size_d = 1;
    if (c->sigma > 0) return q;
    const double rounding = RIC_FLOQUET_ROUNDING * DBL_EPSILON * steps(c) * q.size;
    if (k == 1) {
        /* det(1 + P) = 2 + trace P, without the cancellation */
        f->det_a = ldexp(2, -q.exponent) + P[0] + P[3];
        f->error_a = rounding;
        f->size_a = ldexp(2, -q.exponent) + q.size;
        return q;
    }
    memcpy(A, P, (size_t)ld * (size_t)ld * sizeof *A);
    for (int i = 0; i < ld; i++) A[i * ld + i] += q.exponent ? 0 : 1;
    f->det_a = ric_floquet_map_determinant(ld, ld, A, q.tmp, rounding, &f->error_a);
    for (int i = 0; i < ld; i++) {
        double sum = 1;
        for (int j = 0; j < ld; j++) sum += P[i * ld + j] * P[i * ld + j];
        f->size_a *= sqrt(sum);
    }
    return q;
}
