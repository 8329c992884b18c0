#include "verify_pairs.h"
#include "base/room.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>

typedef ric_real real;

/* The matrix A of a period has A f = f for the flow f and g' A = g' for the gradient g of the
 * energy, g.f = 0. Two Householder reflections take f and then g out (deflation: Wilkinson 1965,
 * chapter 9), which leaves the 2(n - 1) multipliers that say something. Their errors are measured:
 * the whole is computed once as exactly as extended precision can, and three times with the
 * rounding of a double added to every state, time and column. */

#define RESOLUTION (64 * DBL_EPSILON) /* of a stored number */
/* UNSAID: a flag that the library decides when it is asked again may be stored as undecided this
 * many bounds off the border, no farther: between the two lies the rounding of the state */
#define UNSAID 16
#define LOCATED 1e-5 /* where branches meet, rho is on the border to this */
/* Rounding of the matrix whose pairs are given on request, relative: tens of roundings in each of
 * some hundred steps under a power law. */
#define GIVEN 1e-12
#define VAGUE 1e-3      /* beyond this bound, relative, a trace says nothing */
#define VAGUE_TURN 1e-2 /* nor a rotation beyond this one, in turns */

real ric_verify_pairs_noise(unsigned *bits)
{
    *bits = *bits * 1664525u + 1013904223u;
    return (real)(*bits >> 8) / (1u << 23) - 1;
}

/* A <- P A P with the reflection P = 1 - 2 u u' / u'u that takes v [m] to a multiple of e_0; other,
 * if given, likewise. */
static void reflect_all(int m, int ld, real *A, const real *v, real *other)
{
    real u[m], norm = 0, uu = 0;
    for (int i = 0; i < m; i++) norm += v[i] * v[i];
    norm = sqrt(norm);
    memcpy(u, v, sizeof u);
    u[0] += copysign(norm, u[0]);
    for (int i = 0; i < m; i++) uu += u[i] * u[i];
    if (!(uu > 0)) return;
    for (int side = 0; side < 3; side++)
        for (int i = 0; i < (side < 2 ? m : other ? 1 : 0); i++) {
            real *x = side == 0 ? A + i : side == 1 ? A + i * ld : other, sum = 0;
            int stride = side == 0 ? ld : 1;
            for (int k = 0; k < m; k++) sum += u[k] * x[k * stride];
            for (int k = 0; k < m; k++) x[k * stride] -= 2 * sum / uu * u[k];
        }
}

/* ------------------------------------------------------------- eigenvalues */

typedef long double _Complex complex_t;

/* To Hessenberg form by elimination with pivots (Golub and Van Loan, 7.4.7); real, which is a
 * quarter of the work. */
static void make_hessenberg(int n, real *A)
{
    for (int k = 1; k + 1 < n; k++) {
        int pivot = k;
        for (int i = k + 1; i < n; i++)
            if (fabs(A[i * n + k - 1]) > fabs(A[pivot * n + k - 1])) pivot = i;
        if (A[pivot * n + k - 1] == 0) continue;
        for (int j = 0; j < n && pivot != k; j++) {
            real t = A[k * n + j];
            A[k * n + j] = A[pivot * n + j];
            A[pivot * n + j] = t;
        }
        for (int j = 0; j < n && pivot != k; j++) {
            real t = A[j * n + k];
            A[j * n + k] = A[j * n + pivot];
            A[j * n + pivot] = t;
        }
        for (int i = k + 1; i < n; i++) {
            real factor = A[i * n + k - 1] / A[k * n + k - 1];
            for (int j = 0; j < n; j++) A[i * n + j] -= factor * A[k * n + j];
            for (int j = 0; j < n; j++) A[j * n + k] += factor * A[j * n + i];
        }
    }
}

/* (x, y) <- (c x + conj(s) y, c y - s x), part by part: products of complex numbers look for
 * infinities. */
static inline void rotate(real c, complex_t s, complex_t *x, complex_t *y)
{
    const real sr = creall(s), si = cimagl(s), xr = creall(*x), xi = cimagl(*x), yr = creall(*y),
               yi = cimagl(*y);
    real *to = (real *)x, *below = (real *)y;
    to[0] = c * xr + (sr * yr + si * yi);
    to[1] = c * xi + (sr * yi - si * yr);
    below[0] = c * yr - (sr * xr - si * xi);
    below[1] = c * yi - (sr * xi + si * xr);
}

/* One step of the QR algorithm with a shift on rows and columns low .. high (Golub and Van
 * Loan, 7.5). */
static void turn(int n, int low, int high, complex_t shift, complex_t *A, complex_t *rotation)
{
    for (int i = low; i <= high; i++) A[i * n + i] -= shift;
    for (int k = low; k < high; k++) {
        complex_t a = A[k * n + k], b = A[(k + 1) * n + k];
        real far = cabsl(a), size = hypot(far, cabsl(b)),
             c = size > 0 ? far / size : 1; /* real, for half the work */
        complex_t s = size > 0 ? b * (far > 0 ? conj(a) / far : 1) / size : 0;
        rotation[2 * k] = c;
        rotation[2 * k + 1] = s;
        for (int j = k; j <= high; j++) rotate(c, s, &A[k * n + j], &A[(k + 1) * n + j]);
    }
    for (int k = low; k < high; k++) {
        real c = creall(rotation[2 * k]);
        complex_t s = conj(rotation[2 * k + 1]);
        for (int i = low; i <= (k + 1 < high ? k + 1 : high); i++)
            rotate(c, s, &A[i * n + k], &A[i * n + k + 1]);
    }
    for (int i = low; i <= high; i++) A[i * n + i] += shift;
}

/* The eigenvalue of the last two rows that is nearer to the last entry (Wilkinson's shift). */
static complex_t choose_shift(int n, int high, const complex_t *A)
{
    const complex_t *x = A + (high - 1) * n + high - 1, *y = x + n;
    complex_t half = (x[0] - y[1]) / 2, root = csqrtl(half * half + x[1] * y[0]);
    if (cabsl(half + root) < cabsl(half - root)) root = -root;
    return half + root == 0 ? y[1] : y[1] - x[1] * y[0] / (half + root);
}

/* Of a matrix in Hessenberg form. */
static bool eigenvalues(int n, complex_t *A, complex_t *out)
{
    enum { STEPS = 60 };
    complex_t *rotation = ric_calloc(2 * (size_t)n + 2, sizeof *rotation);
    int high = n - 1, tries = 0;
    if (!rotation) return false;
    while (high >= 0 && tries < STEPS) {
        int low = high;
        for (; low > 0; low--) {
            real near = cabsl(A[low * n + low]) + cabsl(A[(low - 1) * n + low - 1]);
            if (cabsl(A[low * n + low - 1]) <= LDBL_EPSILON * near) break;
        }
        if (low == high) {
            out[high] = A[high * n + high];
            high--;
            tries = 0;
            continue;
        }
        complex_t shift = choose_shift(n, high, A);
        if (++tries % 11 == 10) shift += cabsl(A[high * n + high - 1]); /* out of a circle */
        turn(n, low, high, shift, A, rotation);
    }
    free(rotation);
    return high < 0;
}

/* -------------------------------------------------------------------- pairs */

static int by_size(const void *a, const void *b)
{
    real x = cabsl(*(const complex_t *)a), y = cabsl(*(const complex_t *)b);
    return (x < y) - (x > y);
}

static int by_real_part(const void *a, const void *b)
{
    const complex_t x = *(const complex_t *)a, y = *(const complex_t *)b;
    if (creall(x) != creall(y)) return (creall(x) > creall(y)) - (creall(x) < creall(y));
    return (cimagl(x) > cimagl(y)) - (cimagl(x) < cimagl(y));
}

/* lambda and 1 / lambda belong together; rho is made of the larger one, which is known better. */
static void pair_up(int m, complex_t *lambda, ric_pair *rho)
{
    bool used[m];
    memset(used, 0, sizeof used);
    qsort(lambda, (size_t)m, sizeof *lambda, by_size);
    for (int i = 0, k = 0; i < m && k < m / 2; i++) {
        int partner = -1;
        if (used[i]) continue;
        for (int j = i + 1; j < m; j++)
            if (!used[j] && (partner < 0 || cabsl(lambda[i] * lambda[j] - 1) <
                                                cabsl(lambda[i] * lambda[partner] - 1)))
                partner = j;
        if (partner >= 0) used[partner] = true;
        rho[k++] = lambda[i] + 1 / lambda[i];
    }
    qsort(rho, (size_t)(m / 2), sizeof *rho, by_real_part);
}

bool ric_verify_pairs_find(int m, real *A, real *J, real *flow, real *gradient, ric_pair *rho,
                           int *way)
{
    int k = m - 2;
    reflect_all(m, m, J, flow, NULL);
    reflect_all(m, m, A, flow, gradient);
    reflect_all(m - 1, m, J + m + 1, gradient + 1, NULL);
    reflect_all(m - 1, m, A + m + 1, gradient + 1, NULL);
    const real *B = A + 2 * m + 2;
    for (int i = 0; i < k; i++)
        for (int j = 0; j < k; j++)
            if (!isfinite(B[i * m + j])) return false;
    if (k == 2) { /* the trace, exact to the last digit where the multipliers are not */
        real area = J[2 * m + 3] *
                    B[m]; /* that e_0 and its image span: for a free oscillator negative at first */
        rho[0] = B[0] + B[m + 1];
        *way = area > 0 ? 1 : area < 0 ? -1 : 0;
        return true;
    }
    complex_t *C = ric_calloc((size_t)k * (size_t)k + (size_t)k + 1, sizeof *C),
              *lambda = C ? C + k * k : NULL;
    if (!C) return false;
    for (int i = 0; i < k; i++) memmove(A + i * k, B + i * m, (size_t)k * sizeof *A);
    make_hessenberg(k, A);
    for (int i = 0; i < k; i++)
        for (int j = i > 0 ? i - 1 : 0; j < k; j++) C[i * k + j] = A[i * k + j];
    bool found = eigenvalues(k, C, lambda);
    if (found) pair_up(k, lambda, rho);
    free(C);
    return found;
}

/* ----------------------------------------------------------------- verdict */

static ric_pair own(const ric_pairs *p, int run, int i)
{
    return p->own[run * p->n_pair + i];
}

/* How far a run is from pair i of the first, each of which orders its pairs in its own way. */
static real off_run(const ric_pairs *p, int run, int i)
{
    real off = INFINITY;
    for (int j = 0; j < p->n_pair; j++) off = fmin(off, cabsl(own(p, run, j) - own(p, 0, i)));
    return off;
}

/* How far the runs are apart in pair i. */
static real spread(const ric_pairs *p, int i)
{
    real most = 0;
    for (int run = 1; run < p->runs; run++) {
        const real off = off_run(p, run, i);
        if (!(off <= most)) most = off;
    }
    return RIC_PAIR_SAFETY * most + RESOLUTION * (1 + cabsl(own(p, 0, i)));
}

/* Whether a pair of the nearest orbit is farther from that of the stored state than rounding on the
 * way takes it: what the solver makes of such an orbit is for the last digits of the state to say.
 */
static bool is_hardly_held(const ric_pairs *p)
{
    for (int i = 0; i < p->n_pair && p->runs == RIC_PAIR_MOST; i++) {
        real most = 0;
        for (int run = 1; run < RIC_PAIR_RUNS; run++) most = fmax(most, off_run(p, run, i));
        if (off_run(p, RIC_PAIR_RUNS, i) > UNSAID * most) return true;
    }
    return false;
}

/* Largest number that is certain of how far outside the stable range the pairs are (> 0: unstable),
 * and how far inside (> 0: stable). */
static void weigh(const ric_pairs *p, real *outside, real *inside)
{
    real errors[p->n_pair + 1];
    *outside = -INFINITY;
    *inside = INFINITY;
    for (int i = 0; i < p->n_pair; i++) errors[i] = spread(p, i);
    for (int i = 0; i < p->n_pair; i++) {
        real error = errors[i], re = fabs(creall(own(p, 0, i))), im = fabs(cimagl(own(p, 0, i)));
        if (isnan(error)) error = INFINITY;
        real apart = INFINITY;
        for (int j = 0; j < p->n_pair; j++)
            if (j != i) apart = fmin(apart, cabsl(own(p, 0, i) - own(p, 0, j)) - error - errors[j]);
        *outside = fmax(*outside, fmax(re - 2, im) - error);
        *inside = fmin(*inside, fmin(2 - re - error, apart));
        if (im > error) *inside = fmin(*inside, -im);
    }
    if (p->n_pair == 0) *outside = -1;
}

/* Runs that all lie outside decide as well: without a bound, as beside an impact that has no speed.
 */
static bool all_outside(const ric_pairs *p)
{
    for (int run = 0; run < p->runs; run++) {
        bool any = false;
        for (int i = 0; i < p->n_pair; i++) any |= fabs(creall(own(p, run, i))) > 2 + VAGUE;
        if (!any) return false;
    }
    return true;
}

static const char *flag(int stable)
{
    return stable == RIC_STABLE_YES ? "stable" : stable == RIC_STABLE_NO ? "unstable" : "undecided";
}

/* Whether the library gives every pair: where some are lost in rounding it may know, or not, that
 * one is unstable. */
static bool all_given(const ric_verify_asked *asked)
{
    bool all = asked && asked->given;
    for (int i = 0; all && i < 4 * asked->n_pair; i++) all = isfinite(asked->multipliers[i]);
    return all;
}

/* Undecided is a statement on what the library knows of the orbit, which is asked again, and need
 * not say so where branches meet. */
static ric_agreement judge_undecided(const ric_pairs *p, real outside, real inside)
{
    const ric_verify_asked *asked = p->asked;
    real border = 0;
    if (!(inside > 0) && !(outside > 0) && !all_outside(p))
        return RIC_AGREES_YES; /* nor is it decided here */
    if (is_hardly_held(p)) return RIC_AGREES_UNCHECKED;
    if (asked && (asked->end || (asked->joint && fmin(fabs(inside), fabs(outside)) <= LOCATED) ||
                  (asked->given && asked->stable == RIC_STABLE_UNDECIDED)))
        return RIC_AGREES_UNCHECKED;
    for (int i = 0; i < p->n_pair; i++) border = fmax(border, UNSAID * spread(p, i));
    if (asked && asked->given) border = fmax(border, UNSAID * asked->error);
    bool clear = inside > border || outside > border;
    return clear && all_given(asked) ? RIC_AGREES_NO : RIC_AGREES_UNCHECKED;
}

static void judge_flag(const ric_pairs *p, const ric_point *stored, ric_claims *out)
{
    real outside, inside;
    weigh(p, &outside, &inside);
    bool unstable = outside > 0, stable = inside > 0, far = all_outside(p);
    bool wrong = stored->stable == RIC_STABLE_YES ? unstable || far : stable,
         sure = stored->stable == RIC_STABLE_YES ? stable : unstable || far;
    out->stable = stored->stable == RIC_STABLE_UNDECIDED ? judge_undecided(p, outside, inside)
                  : wrong                                ? RIC_AGREES_NO
                  : sure                                 ? RIC_AGREES_YES
                                                         : RIC_AGREES_UNCHECKED;
    if (out->stable == RIC_AGREES_NO && !*out->finding)
        snprintf(out->finding, sizeof out->finding, "stored as %s, found %s", flag(stored->stable),
                 flag(stable ? RIC_STABLE_YES : RIC_STABLE_NO));
}

static real full(const ric_pairs *p, int run, int i)
{
    real rho = creall(own(p, run, i));
    return p->half ? rho * rho - 2 : rho;
}

/* Of the upper of the two, in [0, 1/2]. */
static real upper_turns(real rho)
{
    rho = fmax(-2, fmin(2, rho));
    return atan2(sqrt((2 - rho) * (2 + rho)), rho) / RIC_TWO_PI_LONG;
}

/* gamma in [0, 1) of a pair rho of the map that is used, off the unit circle that of the place
 * where it left it; the sense is that of the symplectic form (Krein: Yakubovich and Starzhinskii
 * 1975, chapter 3), against that of a free oscillator. */
static real turns(const ric_pairs *p, real rho)
{
    real angle = upper_turns(rho);
    if (p->way[0] < 0) angle = 1 - angle;
    angle = p->half ? 2 * angle : angle;
    return angle < 1 ? angle : angle - 1;
}

/* On a circle of one turn. */
static real apart(real a, real b)
{
    real off = fabs(a - b);
    return fmin(off, 1 - off);
}

/* How far the rotation may be from that of the exact run, in turns, NaN if a run is lost: where a
 * pair meets 1 or -1 the root of its error, on whichever side of the circle the runs are. Of half a
 * period twice that of the map: what is known of it may go once round. */
static real turns_known(const ric_pairs *p)
{
    const real rho = creall(own(p, 0, 0)), found = upper_turns(rho),
               stated = p->asked && p->asked->given ? p->asked->error : 0,
               off = spread(p, 0) + stated + 8 * LDBL_EPSILON * (2 + fabs(rho));
    if (isnan(off) || isnan(rho)) return NAN;
    return RESOLUTION +
           (p->half ? 2 : 1) * fmax(found - upper_turns(rho + off), upper_turns(rho - off) - found);
}

static void judge_rotation(const ric_pairs *p, const ric_point *stored, ric_claims *out)
{
    /* on which side of the circle a pair is, the library need not know better than it states */
    const real stated = p->asked && p->asked->given ? p->asked->error : 0;
    real outside, inside, found = turns(p, creall(own(p, 0, 0))), bound = turns_known(p);
    if (isnan(stored->rotation) && isnan(stored->trace))
        return; /* lost together, which the trace answers for */
    weigh(p, &outside, &inside);
    bool wrong = isnan(stored->rotation)
                     ? inside > stated
                     : outside > stated || !(stored->rotation >= 0 && stored->rotation < 1) ||
                           apart(stored->rotation, found) > bound;
    if (!wrong && !isnan(stored->rotation) && !(bound <= VAGUE_TURN) &&
        out->multipliers == RIC_AGREES_YES)
        out->multipliers = RIC_AGREES_UNCHECKED;
    if (!wrong) return;
    out->multipliers = RIC_AGREES_NO;
    if (!*out->finding)
        snprintf(out->finding, sizeof out->finding,
                 "rotation %.17g stored, %.17g found, bound %.2g", stored->rotation, (double)found,
                 (double)bound);
}

/* n = 2: asinh(trace / 2), in which an error is one of the trace over sqrt(trace^2 + 4). */
static void judge_trace(const ric_pairs *p, const ric_point *stored, ric_claims *out)
{
    real found = asinh(full(p, 0, 0) / 2), bound = 0;
    for (int run = 1; run < p->runs; run++) {
        real off = fabs(asinh(full(p, run, 0) / 2) - found);
        if (!(off <= bound)) bound = off;
    }
    bound = RIC_PAIR_SAFETY * bound + RESOLUTION * (1 + fabs(found));
    if (p->asked && p->asked->given)
        bound += p->asked->error / hypot(2, full(p, 0, 0)); /* as the library states it */
    out->multiplier_error = (double)fabs(stored->trace - found);
    out->multiplier_bound = (double)bound;
    bool vague = !(bound <= VAGUE);
    /* nor does the library give it when it is asked again; and at an end it need not have, as with
     * a flag */
    if (isnan(stored->trace)) vague |= !all_given(p->asked) || p->asked->end || is_hardly_held(p);
    out->multipliers = vague                            ? RIC_AGREES_UNCHECKED
                       : out->multiplier_error <= bound ? RIC_AGREES_YES
                                                        : RIC_AGREES_NO;
    if (out->multipliers == RIC_AGREES_NO && !*out->finding)
        snprintf(out->finding, sizeof out->finding, "trace %.17g stored, %.17g found, bound %.2g",
                 2 * sinh(stored->trace), (double)full(p, 0, 0),
                 (double)(bound * hypot(2, full(p, 0, 0))));
}

/* Pairs that are near each other go apart like a square root: by what the rounding that the library
 * states of a matrix makes of them. */
static real between(const ric_pairs *p, int i)
{
    real off = GIVEN * (1 + cabsl(own(p, 0, i))), near = INFINITY;
    for (int j = 0; j < p->n_pair; j++)
        if (j != i) near = fmin(near, cabsl(own(p, 0, i) - own(p, 0, j)));
    return fmin(sqrt(off), off / near);
}

static void worsen(double *worst, real value)
{
    if (isnan(*worst) || value > *worst) *worst = (double)value;
}

/* One pair that the library gives, z [4], against the nearest that is not yet used. */
static ric_agreement judge_pair(const ric_pairs *p, const double *z, bool *used, ric_claims *out)
{
    ric_pair rho = (z[0] + z[2]) + (z[1] + z[3]) * I;
    real off = INFINITY;
    int best = -1;
    if (isnan(creall(rho))) return RIC_AGREES_UNCHECKED;
    for (int i = 0; i < p->n_pair; i++) {
        ric_pair at = own(p, 0, i), all = p->half ? at * at - 2 : at;
        if (used[i] || !(cabsl(all - rho) < off)) continue;
        off = cabsl(all - rho);
        best = i;
    }
    if (best < 0) return RIC_AGREES_UNCHECKED;
    used[best] = true;
    real error = spread(p, best) + between(p, best), at = cabsl(own(p, 0, best)),
         size = hypot(2, cabsl(rho)),
         bound = error * (p->half ? 2 * at + error : 1) + RESOLUTION * (1 + cabsl(rho)) +
                 p->asked->error;
    worsen(&out->multiplier_error, off / size);
    worsen(&out->multiplier_bound, bound / size);
    if (!(bound <= VAGUE * fmin(size, hypot(2, p->half ? at * at : at))))
        return RIC_AGREES_UNCHECKED;
    if (off <= bound) return RIC_AGREES_YES;
    if (*out->finding) return RIC_AGREES_NO;
    snprintf(out->finding, sizeof out->finding,
             "multipliers %.17g and %.17g given, their sum is off by %.2g, bound %.2g", z[0], z[2],
             (double)off, (double)bound);
    return RIC_AGREES_NO;
}

/* Any number of modes: every pair that the library gives is one of those found here, each taken
 * once. */
static void judge_given(const ric_pairs *p, ric_claims *out)
{
    bool used[p->n_pair + 1];
    memset(used, 0, sizeof used);
    out->multipliers = RIC_AGREES_YES;
    for (int k = 0; k < p->n_pair; k++) {
        ric_agreement agrees = judge_pair(p, p->asked->multipliers + 4 * k, used, out);
        if (agrees == RIC_AGREES_NO || out->multipliers == RIC_AGREES_YES)
            out->multipliers = agrees;
    }
}

void ric_verify_pairs_judge(const ric_pairs *p, int n_mode, const ric_point *stored,
                            ric_claims *out)
{
    if (p->n_pair == 1 && n_mode == 2) {
        judge_trace(p, stored, out);
        judge_rotation(p, stored, out);
    } else if (p->asked && p->asked->given && p->asked->n_pair == p->n_pair) {
        judge_given(p, out);
    }
    judge_flag(p, stored, out);
}
