#include "floquet.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "floquet_again.h"
#include "floquet_fine.h"
#include "floquet_judge.h"
#include "floquet_known.h"
#include "floquet_pairs.h"
#include "floquet_sharp.h"

/* Rounding of one flight and impact, in units of DBL_EPSILON: measured against 40-digit arithmetic,
 * with a margin. */
#define ROUNDING 16.0
/* SMOOTH_STEPS: of law power, in the same units: several of its steps make one error, tens of them
 * a period */
#define SMOOTH_STEPS 12
#define NO_SPEED 1e-60
#define ACCURATE 1e-6 /* error of rho from which on the factors of the map are not multiplied */
/* MOST_PAIRS: up to which the halves are taken apart, or extended precision is used: they need 32
 * k^2 numbers */
#define MOST_PAIRS 64
/* ROUGH: error of rho, over 1 + |rho|, from which on the map is made in extended precision */
#define ROUGH 1e-12

ric_status ric_floquet_create(int n, ric_floquet *out)
{
    size_t k = (size_t)(n > 1 ? n - 1 : 1), nn = (size_t)n;
    memset(out, 0, sizeof *out);
    out->n_pair = n - 1;
    out->n_work = 4 * nn * k + 2 * nn * nn + 20 * k * k + 8 * nn +
                  (k <= MOST_PAIRS ? 12 * k * k : 0);
    out->rho = ric_calloc(2 * k, sizeof(double));
    out->own = ric_calloc(2 * k, sizeof(double));
    out->each = ric_calloc(k, sizeof(double));
    out->work = ric_calloc(out->n_work, sizeof(double));
    out->fine = ric_calloc(k <= MOST_PAIRS ? ric_floquet_fine_size(n) : 1, sizeof *out->fine);
    const bool known = ric_floquet_known_create(n, &out->known) &&
                       ric_floquet_again_create(n, &out->again);
    if (!known || !out->rho || !out->own || !out->each || !out->work || !out->fine) {
        ric_floquet_release(out);
        return ric_fail(RIC_E_NOMEM, "no memory for %d Floquet multipliers", 2 * out->n_pair);
    }
    return RIC_OK;
}

void ric_floquet_release(ric_floquet *f)
{
    free(f->rho);
    free(f->own);
    free(f->each);
    free(f->work);
    free(f->fine);
    ric_floquet_known_free(f->known);
    ric_floquet_again_free(f->again);
    f->known = NULL;
    f->again = NULL;
    f->rho = f->own = f->each = f->work = NULL;
    f->fine = NULL;
}

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

/* *error: of the determinant, when every entry of A may be off by `rounding`: the smallest pivot
 * decides whether it has a sign. */
static double determinant(int k, int ld, const double *A, double *work, double rounding,
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

/* Blocks from P; a centre exchanges the roles of q and p, (Q, P) = (dp, -dq), so that P stays
 * symplectic. */
static void blocks(const ric_shooting *c, const double *P, double *a, double *b, double *cc,
                   double *d)
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

/* Those that its neighbours go through, which the times of springs move. Determinants, whose signs
 * tell branch points, are bounded without: what moves them by less than themselves is looked for by
 * moving the orbit. */
static double roundings(const ric_shooting *c)
{
    double sum = steps(c);
    for (int k = 1; k <= c->n_flight; k++)
        if (c->face[k] >= 0 && c->model->face[c->face[k]].spring > 0) sum += of_switch(c, k);
    return sum;
}

/* ------------------------------------------------------ extended precision */

/* Whether rho is worth another map. */
static bool is_rough(const ric_floquet *f)
{
    double least = HUGE_VAL;
    for (int i = 0; i < f->n_pair; i++)
        least = fmin(least, hypot(f->own[2 * i], f->own[2 * i + 1]));
    return f->rough > fmax(ROUGH, f->enough) * (1 + least) || !isfinite(least);
}

/* Whether rho that are off by `error` at least are so, by the product of all rho + 2: one of them
 * is not larger than its root. */
static bool is_surely_rough(const ric_floquet *f, double error, double product)
{
    const double least = 2 + pow(product, 1.0 / f->n_pair);
    return f->n_pair > 2 && f->n_pair <= MOST_PAIRS && !f->orbit &&
           error > fmax(ROUGH, f->enough) * (1 + least);
}

/* Another map, if there is one: *size of its largest entry. */
static bool made_fine(const ric_shooting *c, ric_floquet *f, const double *start, const double *end,
                      double *size)
{
    return f->n_pair <= MOST_PAIRS && ric_floquet_fine_fits(c) &&
           (f->orbit ? ric_floquet_fine_map(c, f->orbit, start, end, f->fine, size)
                     : ric_floquet_known_map(f->known, c, start, end, f->fine, size));
}

/* ------------------------------------------------------- what a matrix says */

/* A matrix, and what is known of it. */
typedef struct {
    bool period;            /* the map [2k * 2k] of the general form, else 2 + 4 b'c [k * k] */
    bool part;              /* of a part of the period, after which full ones are judged */
    const double *H;        /* itself */
    double *work;           /* of the general form H + H^-1, used up, else [k * k] free */
    double error;           /* of its entries */
    double rough;           /* the same of the map in double, if it has not been judged, else 0 */
    ric_fine_real rounding; /* of f->fine, which it was made of: the map, or b and c; else 0 */
} matrix;

static bool find_pairs(const matrix *m, bool asked, ric_floquet_pairs *out)
{
    if (!m->period) return ric_floquet_pairs_of_matrix(m->H, asked, m->work, out);
    if (!ric_floquet_pairs_of_period(m->work, out)) return false;
    for (int i = 0; i < out->count; i++) out->condition[i] = HUGE_VAL;
    if (asked) ric_floquet_pairs_conditions(m->H, out);
    return true;
}

static void allow(const matrix *m, double error, ric_floquet_pairs *pairs)
{
    ric_floquet_pairs_allow(m->period ? 2 * pairs->count : pairs->count, m->H, error, pairs);
}

/* Both maps of an orbit have the same rho and conditions, to the error of the rough one. */
static void judge_rough(ric_floquet *f, const matrix *m, ric_floquet_pairs *pairs)
{
    double rho[2 * pairs->count];
    memcpy(rho, f->rho, sizeof rho);
    allow(m, m->rough, pairs);
    ric_floquet_judge_pairs(f, m->part, pairs);
    f->rough = f->error;
    memcpy(f->rho, rho, sizeof rho);
}

static void sharpen(ric_floquet *f, const matrix *m, ric_floquet_pairs *pairs)
{
    const int k = pairs->count;
    if (!(f->sharp > 0) || !(m->rounding > 0)) return;
    if (m->period) ric_floquet_sharpen_map(f->fine, m->rounding, f->sharp, pairs);
    else ric_floquet_sharpen_blocks(f->fine, f->fine + k * k, m->rounding, f->sharp, pairs);
}

/* Whether what is known without conditions leaves open which rho are known, or whether another map
 * has to be made. */
static bool is_vague(ric_floquet *f, const matrix *m)
{
    bool lost = false;
    for (int i = 0; i < f->n_pair; i++) lost |= isnan(f->own[2 * i]);
    if (m->rounding > 0) return lost;
    f->rough = f->error;
    return lost || is_rough(f);
}

/* False: no rho were found. */
static bool judge(ric_floquet *f, const matrix *m)
{
    const int k = f->n_pair;
    double known[3 * k], rho[2 * k];
    ric_floquet_pairs pairs = {.count = k,
                               .rho = f->rho,
                               .error = known,
                               .alone = known + k,
                               .condition = known + 2 * k};
    const bool asked = !f->coarse;
    if (!find_pairs(m, asked, &pairs)) return false;
    memcpy(rho, f->rho, sizeof rho);
    if (asked && m->rough > 0) judge_rough(f, m, &pairs);
    allow(m, m->error, &pairs);
    sharpen(f, m, &pairs);
    ric_floquet_judge_pairs(f, m->part, &pairs);
    if (asked || !is_vague(f, m)) return true;
    memcpy(f->rho, rho, sizeof rho);
    if (m->period) ric_floquet_pairs_conditions(m->H, &pairs);
    else if (!find_pairs(m, true, &pairs)) return false;
    allow(m, m->error, &pairs);
    ric_floquet_judge_pairs(f, m->part, &pairs);
    return true;
}

/* Two blocks whose product has the rho: as they are, 2^-exponent times their size. */
typedef struct {
    bool part;
    const double *b, *c;
    int exponent;
    double rounding;    /* of their entries */
    ric_fine_real fine; /* as of a matrix */
} factors;

/* Where the rounding of the largest rho matters to the others. work [4 k^2]. */
static bool judge_blocks(ric_floquet *f, const factors *q, double *work)
{
    const int k = f->n_pair;
    double known[2 * k];
    ric_floquet_pairs pairs = {.count = k, .rho = f->rho, .error = known, .alone = known + k};
    if (!ric_floquet_pairs_of_blocks(q->b, q->c, q->exponent, q->rounding, work, &pairs))
        return false;
    sharpen(f, &(matrix){.rounding = q->fine}, &pairs);
    ric_floquet_judge_pairs(f, q->part, &pairs);
    return true;
}

/* ------------------------------------------------------ from another map */

/* P as the sum of two matrices in double. */
static void split(int count, const ric_fine_real *P, double *high, double *low)
{
    for (int i = 0; i < count; i++) {
        high[i] = (double)P[i];
        low[i] = (double)(P[i] - high[i]);
    }
}

/* Rounding of a map of this size in extended precision. */
static double fine_rounding(const ric_shooting *c, double size)
{
    return ROUNDING * (double)LDBL_EPSILON * roundings(c) * size;
}

/* H = 2 + 4 b'c of blocks b, c of [4 k^2] numbers each of high and low; both parts of the blocks
 * are summed in b_c [2 k^2]. Returns the largest entry. */
static double fine_product(int k, const double *high, const double *low, ric_fine_real *b_c,
                           double *H)
{
    const int kk = k * k;
    const ric_fine_real *b = b_c, *c = b_c + kk;
    double most = 0;
    for (int i = 0; i < 2 * kk; i++) b_c[i] = (ric_fine_real)high[kk + i] + low[kk + i];
    for (int i = 0; i < k; i++)
        for (int j = 0; j < k; j++) {
            ric_fine_real s = 0;
            for (int l = 0; l < k; l++) s += b[l * k + i] * c[l * k + j];
            H[i * k + j] = (i == j ? 2 : 0) + (double)(4 * s);
            most = fmax(most, fabs(H[i * k + j]));
        }
    return most;
}

/* The reversible form: work [8 k^2] and f->work beside it are free, E0 and E1 are not. `rough`:
 * error of the map in double if that has not been judged, else 0. False: nothing was judged. */
static bool reversible_fine(const ric_shooting *c, ric_floquet *f, const double *E0,
                            const double *E1, double *work, double rough)
{
    int k = c->n - 1, kk = k * k;
    double size, *high = f->work, *low = high + 4 * kk, *x = work, *y = x + 4 * kk;
    bool quarter = c->multiple == 4;
    if (!made_fine(c, f, E0, E1, &size)) return false;
    split(4 * kk, f->fine, high, low);
    blocks(c, high, x, x + kk, x + 2 * kk, x + 3 * kk);
    blocks(c, low, y, y + kk, y + 2 * kk, y + 3 * kk);
    double error = fine_rounding(c, size) * size;
    if (k == 1) {
        ric_fine_real part[4];
        for (int i = 0; i < 4; i++) part[i] = (ric_fine_real)x[i] + y[i];
        double bc = (double)(part[1] * part[2]), ad = (double)(part[0] * part[3]);
        if (!isfinite(bc) || !isfinite(ad))
            return false; /* beyond a double, where the scaled map has its logarithm */
        error += 8 * DBL_EPSILON * fmin(1 + fabs(bc), 1 + fabs(ad));
        ric_floquet_judge_plane(f, quarter, bc, ad, x[3] * x[1], 0, error);
        return true;
    }
    error += 8 * k * DBL_EPSILON * (1 + fine_product(k, x, y, f->fine, high));
    if (error <= ACCURATE)
        return judge(f, &(matrix){.part = quarter,
                                  .H = high,
                                  .work = low,
                                  .error = error,
                                  .rough = rough,
                                  .rounding = fine_rounding(c, size)});
    return !(rough > 0) &&
           judge_blocks(f,
                        &(factors){.part = quarter,
                                   .b = x + kk,
                                   .c = x + 2 * kk,
                                   .rounding = fine_rounding(c, size) + 2 * DBL_EPSILON * size,
                                   .fine = fine_rounding(c, size)},
                        high);
}

/* The general form. work [16 k^2]; `rough` as above. */
static bool whole_fine(const ric_shooting *c, ric_floquet *f, double *work, double rough)
{
    int k = c->n - 1, ld = 2 * k, count = ld * ld;
    double size, *high = work, *low = high + count, *A = low + count, *B = A + count, most = 0;
    if (!made_fine(c, f, NULL, NULL, &size)) return false;
    ric_fine_real trace = 0;
    for (int i = 0; i < count; i++) f->fine[i] *= c->sigma;
    for (int i = 0; i < ld; i++) trace += f->fine[i * ld + i];
    double error = fine_rounding(c, size);
    if (k == 1) {
        if (!isfinite((double)trace)) return false; /* likewise */
        error += 4 * DBL_EPSILON * fabs((double)trace);
        ric_floquet_judge_trace(f, c->sigma < 0, (double)trace, (double)f->fine[1], 0, error);
        return true;
    }
    split(count, f->fine, high, low);
    ric_floquet_pairs_inverse(k, high, 1, high, A);
    ric_floquet_pairs_inverse(k, low, 1, low, B);
    for (int i = 0; i < count; i++) {
        A[i] += B[i];
        most = fmax(most, fabs(A[i]));
    }
    error += 8 * ld * DBL_EPSILON * (1 + most);
    if (error > ACCURATE && (rough > 0 || f->error < error)) return false; /* others know better */
    return judge(f, &(matrix){.period = true,
                              .part = c->sigma < 0,
                              .H = high,
                              .work = A,
                              .error = error,
                              .rough = rough,
                              .rounding = fine_rounding(c, size)});
}

/* The blocks of a map, and the workspace that is left. */
typedef struct {
    double *P, *E0, *E1, *a, *b, *c, *d, *A, *tmp, growth, size;
    int exponent;
} linear_map;

/* The map of a reversible chain in f->work, and the determinants of its blocks. */
static linear_map reversible_map(const ric_shooting *c, ric_floquet *f)
{
    int n = c->n, k = n - 1, ld = 2 * k;
    double *V = f->work, *P = V + 2 * n * ld, *E0 = P + ld * ld, *E1 = E0 + k * n, *a = E1 + k * n,
           *b = a + k * k, *cc = b + k * k, *d = cc + k * k, *A = d + k * k, first[n], last[n];
    linear_map q =
        {.P = P, .E0 = E0, .E1 = E1, .a = a, .b = b, .c = cc, .d = d, .A = A, .tmp = A + k * k};
    left_out(c, c->start, c->closed[0], c->w, c->face[0], first);
    left_out(c, c->end, c->closed[c->n_flight], c->w + 2 * n * c->n_flight, c->face[c->n_flight],
             last);
    ric_model_complement(n, first, E0);
    ric_model_complement(n, last, E1);
    section_columns(c, E0, V);
    propagate(c, 0, c->n_flight, V, &q.exponent, &q.growth);
    project(c, last, V, P);
    blocks(c, P, a, b, cc, d);
    for (int i = 0; i < ld * ld; i++) q.size = fmax(q.size, fabs(P[i]));
    q.size = fmax(q.size, q.growth);
    double rounding = ROUNDING * DBL_EPSILON * steps(c) * q.size;
    if (f->coarse && k > MOST_PAIRS) return q; /* they would tell whether to make another map */
    f->det_a = determinant(k, k, a, q.tmp, rounding, &f->error_a);
    f->det_b = determinant(k, k, b, q.tmp, rounding, &f->error_b);
    f->det_d = determinant(k, k, d, q.tmp, rounding, &f->error_d);
    f->size_a = f->size_b = bound(k, a, b);
    f->size_d = bound(k, cc, d);
    return q;
}

/* Unless rho are good enough; f->orbit has a map of its own. */
static void improve(const ric_shooting *c, ric_floquet *f, const linear_map *q)
{
    f->rough = f->error;
    if (!f->orbit && !is_rough(f)) return;
    if (c->start == RIC_MIRROR_NONE) whole_fine(c, f, f->work, 0);
    else reversible_fine(c, f, q->E0, q->E1, q->A, 0);
}

static void reversible(const ric_shooting *c, ric_floquet *f)
{
    const linear_map q = reversible_map(c, f);
    int k = c->n - 1, exponent = q.exponent;
    bool quarter = c->multiple == 4, found = exponent < 500;
    const double rounding = ROUNDING * DBL_EPSILON * roundings(c) * q.size;
    double error = rounding * q.size + ldexp(8 * DBL_EPSILON, -2 * exponent);
    if (k == 1) {
        ric_floquet_judge_plane(f, quarter, q.b[0] * q.c[0], q.a[0] * q.d[0], q.d[0] * q.b[0],
                                exponent, error);
        improve(c, f, &q);
        return;
    }
    f->trace_asinh = f->rotation = NAN;
    error = ldexp(error, exponent < 500 ? 2 * exponent : 1000);
    if (found && error <= ACCURATE) {
        const double most = ldexp((fabs(f->det_a) + f->error_a) * (fabs(f->det_d) + f->error_d),
                                  2 * k * (1 + exponent));
        if (is_surely_rough(f, error, most) && reversible_fine(c, f, q.E0, q.E1, q.A, error))
            return;
        ric_floquet_pairs_product(k, q.b, q.c, exponent, q.A);
        found = judge(f, &(matrix){.part = quarter, .H = q.A, .work = q.P, .error = error});
    } else if (found)
        found = judge_blocks(f, &(factors){quarter, q.b, q.c, exponent, rounding, 0}, q.P);
    if (found) improve(c, f, &q);
    else ric_floquet_judge_lost(f);
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

/* With the return map M = sigma P2 P1 from two halves, M + M^-1 + 2 = sigma (P2 + sigma P1^-1) (P1
 * + sigma P2^-1): the factors have the square root of the size of M. work [28 k^2], V [2n * 2k].
 * False: it cannot be done. */
static bool rho_of_halves(const ric_shooting *c, double *work, double *V, ric_floquet_pairs *out)
{
    int n = c->n, k = n - 1, ld = 2 * k, exponent[2], middle;
    if (!ric_flight_law_of(c->model)->turns || k > MOST_PAIRS || !(middle = middle_impact(c)))
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
    double rounding = 2 * ROUNDING * DBL_EPSILON * roundings(c) * size;
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

/* The return map of the general form in f->work, with sigma, and its determinant: a multiplier -1
 * of the half-period map breaks z(t+T/2) = -z(t). */
static linear_map whole_map(const ric_shooting *c, ric_floquet *f)
{
    int n = c->n, k = n - 1, ld = 2 * k;
    double *V = f->work, *P = V + 2 * n * ld, *A = P + ld * ld;
    linear_map q = {.P = P, .A = A, .tmp = A + ld * ld};
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
    const double rounding = ROUNDING * DBL_EPSILON * steps(c) * q.size;
    if (k == 1) {
        /* det(1 + P) = 2 + trace P, without the cancellation */
        f->det_a = ldexp(2, -q.exponent) + P[0] + P[3];
        f->error_a = rounding;
        f->size_a = ldexp(2, -q.exponent) + q.size;
        return q;
    }
    memcpy(A, P, (size_t)ld * (size_t)ld * sizeof *A);
    for (int i = 0; i < ld; i++) A[i * ld + i] += q.exponent ? 0 : 1;
    f->det_a = determinant(ld, ld, A, q.tmp, rounding, &f->error_a);
    for (int i = 0; i < ld; i++) {
        double sum = 1;
        for (int j = 0; j < ld; j++) sum += P[i * ld + j] * P[i * ld + j];
        f->size_a *= sqrt(sum);
    }
    return q;
}

/* The product of all rho + 2, det(1 + P). */
static double above_minus_one(const ric_shooting *c, const ric_floquet *f, const linear_map *q)
{
    const int ld = 2 * (c->n - 1);
    double error;
    if (c->sigma < 0) return fabs(f->det_a) + f->error_a;
    memcpy(q->A, q->P, (size_t)ld * (size_t)ld * sizeof *q->A);
    for (int i = 0; i < ld; i++) q->A[i * ld + i] += 1;
    const double det = determinant(ld, ld, q->A, q->tmp, 0, &error);
    return fabs(det);
}

static void whole(const ric_shooting *c, ric_floquet *f)
{
    const linear_map q = whole_map(c, f);
    int k = c->n - 1, ld = 2 * k, exponent = q.exponent;
    double rounding = ROUNDING * DBL_EPSILON * roundings(c), trace = 0;
    double error = rounding * ldexp(q.size, exponent < 1000 ? exponent : 1000) + 8 * DBL_EPSILON;
    for (int i = 0; i < ld; i++) trace += q.P[i * ld + i];
    if (k == 1) {
        ric_floquet_judge_trace(f, c->sigma < 0, trace, q.P[1], exponent, rounding * q.size);
        improve(c, f, &q);
        return;
    }
    f->trace_asinh = f->rotation = NAN;
    if (!isfinite(error) || exponent) {
        ric_floquet_judge_lost(f);
        return;
    }
    bool found = false;
    if (!(error <= ACCURATE)) {
        double known[2 * k];
        ric_floquet_pairs pairs = {.count = k, .rho = f->rho, .error = known, .alone = known + k};
        if ((found = rho_of_halves(c, q.A, f->work, &pairs)))
            ric_floquet_judge_pairs(f, c->sigma < 0, &pairs);
    } else if (error > ROUGH && k > 2 && is_surely_rough(f, error, above_minus_one(c, f, &q)) &&
               whole_fine(c, f, q.A, error))
        return;
    if (!found) {
        ric_floquet_pairs_inverse(k, q.P, 1, q.P, q.A);
        found = judge(f, &(matrix){.period = true,
                                   .part = c->sigma < 0,
                                   .H = q.P,
                                   .work = q.A,
                                   .error = error});
    }
    if (found) improve(c, f, &q);
    else ric_floquet_judge_lost(f);
}

/* One seen mode: no multipliers besides the trivial ones; every periodic orbit is (orbitally)
 * stable. */
static void alone(ric_floquet *f)
{
    f->trace_asinh = f->rotation = NAN;
    f->stable = RIC_STABLE_YES;
    f->det_a = f->det_b = f->det_d = 1;
    f->error = f->rough = f->error_a = f->error_b = f->error_d = 0;
}

ric_status ric_floquet_compute(const ric_shooting *c, ric_floquet *f)
{
    if (ric_floquet_again_find(f->again, c, f)) return RIC_OK;
    if (c->n < 2) alone(f);
    else if (c->start == RIC_MIRROR_NONE) whole(c, f);
    else reversible(c, f);
    ric_floquet_again_keep(f->again, c, f);
    return RIC_OK;
}

void ric_floquet_factors(const ric_shooting *c, ric_floquet *f)
{
    if (c->n > 1) c->start == RIC_MIRROR_NONE ? whole_map(c, f) : reversible_map(c, f);
    else alone(f);
}
