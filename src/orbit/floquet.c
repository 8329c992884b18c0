#include "floquet.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "floquet_again.h"
#include "floquet_fine.h"
#include "floquet_judge.h"
#include "floquet_known.h"
#include "floquet_map.h"
#include "floquet_pairs.h"
#include "floquet_sharp.h"

#define ACCURATE 1e-6 /* error of rho from which on the factors of the map are not multiplied */
/* ROUGH: error of rho, over 1 + |rho|, from which on the map is made in extended precision; of two
 * modes that of asinh(rho / 2), over itself or 1, which is what is kept of it */
#define ROUGH 1e-12

ric_status ric_floquet_create(int n, ric_floquet *out)
{
    size_t k = (size_t)(n > 1 ? n - 1 : 1), nn = (size_t)n;
    memset(out, 0, sizeof *out);
    out->n_pair = n - 1;
    out->n_work = 4 * nn * k + 2 * nn * nn + 20 * k * k + 8 * nn +
                  (k <= RIC_FLOQUET_MOST_PAIRS ? 12 * k * k : 0);
    out->rho = ric_calloc(2 * k, sizeof(double));
    out->own = ric_calloc(2 * k, sizeof(double));
    out->each = ric_calloc(k, sizeof(double));
    out->own_error = ric_calloc(k, sizeof(double));
    out->work = ric_calloc(out->n_work, sizeof(double));
    out->fine = ric_calloc(k <= RIC_FLOQUET_MOST_PAIRS ? ric_floquet_fine_size(n) : 1,
                           sizeof *out->fine);
    const bool known = ric_floquet_known_create(n, &out->known) &&
                       ric_floquet_again_create(n, &out->again);
    if (!known || !out->rho || !out->own || !out->own_error || !out->each || !out->work ||
        !out->fine) {
        ric_floquet_release(out);
        return ric_fail(RIC_E_NOMEM, "no memory for %d Floquet multipliers", 2 * out->n_pair);
    }
    return RIC_OK;
}

void ric_floquet_release(ric_floquet *f)
{
    free(f->rho);
    free(f->own);
    free(f->own_error);
    free(f->each);
    free(f->work);
    free(f->fine);
    ric_floquet_known_free(f->known);
    ric_floquet_again_free(f->again);
    f->known = NULL;
    f->again = NULL;
    f->rho = f->own = f->own_error = f->each = f->work = NULL;
    f->fine = NULL;
}

/* ------------------------------------------------------ extended precision */

/* Whether rho is worth another map. */
static bool is_rough(const ric_floquet *f)
{
    double least = HUGE_VAL;
    for (int i = 0; i < f->n_pair; i++)
        least = fmin(least, hypot(f->own[2 * i], f->own[2 * i + 1]));
    const double told = f->n_pair == 1 ? fmax(asinh(least / 2), 1) : 1;
    return f->rough > fmax(ROUGH, f->enough) * told * (1 + least) || !isfinite(least);
}

/* Whether rho that are off by `error` at least are so: one of the eigenvalues of H [size * size] is
 * not larger than the root of their product. work [size^2]. */
static bool is_surely_rough(const ric_floquet *f, double error, int size, const double *H,
                            double *work)
{
    const double most = fmax(ROUGH, f->enough);
    double unused;
    if (f->n_pair <= 2 || f->n_pair > RIC_FLOQUET_MOST_PAIRS || f->orbit || !(error > most))
        return false;
    const double product = ric_floquet_map_determinant(size, size, H, work, 0, &unused);
    return error > most * (1 + pow(fabs(product), 1.0 / size));
}

/* Another map, if there is one: *size of its largest entry. */
static bool made_fine(const ric_shooting *c, ric_floquet *f, const double *start, const double *end,
                      double *size)
{
    return f->n_pair <= RIC_FLOQUET_MOST_PAIRS && ric_floquet_fine_fits(c) &&
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
    return RIC_FLOQUET_ROUNDING * (double)LDBL_EPSILON * ric_floquet_map_roundings(c) * size;
}

/* Rows i, i + 1 and columns j, j + 1 of 4 b'c, as far as there are such, in registers. */
static void fine_tile(int k, int i, int j, const ric_fine_real *b, const ric_fine_real *c,
                      double *H)
{
    const int below = i + 1 < k ? 1 : 0, beside = j + 1 < k ? 1 : 0;
    ric_fine_real first = 0, right = 0, under = 0, last = 0;
    for (int l = 0; l < k; l++) {
        const ric_fine_real *x = b + l * k + i, *y = c + l * k + j;
        const ric_fine_real x0 = x[0], x1 = x[below], y0 = y[0], y1 = y[beside];
        first += x0 * y0;
        right += x0 * y1;
        under += x1 * y0;
        last += x1 * y1;
    }
    H += i * k + j;
    H[below * k + beside] = (double)(4 * last);
    H[below * k] = (double)(4 * under);
    H[beside] = (double)(4 * right);
    H[0] = (double)(4 * first);
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
    for (int i = 0; i < k; i += 2)
        for (int j = 0; j < k; j += 2) fine_tile(k, i, j, b, c, H);
    for (int i = 0; i < kk; i++) {
        H[i] += i % (k + 1) == 0 ? 2 : 0;
        most = fmax(most, fabs(H[i]));
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
    ric_floquet_map_blocks(c, high, x, x + kk, x + 2 * kk, x + 3 * kk);
    ric_floquet_map_blocks(c, low, y, y + kk, y + 2 * kk, y + 3 * kk);
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

/* Unless rho are good enough, or the only one is beyond a double, where no other map tells more
 * than the logarithm of the scaled one; f->orbit has a map of its own. */
static void improve(const ric_shooting *c, ric_floquet *f, const ric_floquet_linear *q)
{
    f->rough = f->error;
    if (!f->orbit && (!is_rough(f) || (f->n_pair == 1 && isinf(f->own[0])))) return;
    if (c->start == RIC_MIRROR_NONE) whole_fine(c, f, f->work, 0);
    else reversible_fine(c, f, q->E0, q->E1, q->A, 0);
}

static void reversible(const ric_shooting *c, ric_floquet *f)
{
    const ric_floquet_linear q = ric_floquet_map_reversible(c, f);
    int k = c->n - 1, exponent = q.exponent;
    bool quarter = c->multiple == 4, found = exponent < 500;
    const double rounding = RIC_FLOQUET_ROUNDING * DBL_EPSILON * ric_floquet_map_roundings(c) *
                            q.size;
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
        ric_floquet_pairs_product(k, q.b, q.c, exponent, q.A);
        if (is_surely_rough(f, error, k, q.A, q.P)) {
            if (reversible_fine(c, f, q.E0, q.E1, q.A, error)) return;
            ric_floquet_pairs_product(k, q.b, q.c, exponent, q.A);
        }
        found = judge(f, &(matrix){.part = quarter, .H = q.A, .work = q.P, .error = error});
    } else if (found)
        found = judge_blocks(f, &(factors){quarter, q.b, q.c, exponent, rounding, 0}, q.P);
    if (found) improve(c, f, &q);
    else ric_floquet_judge_lost(f);
}

static void whole(const ric_shooting *c, ric_floquet *f)
{
    const ric_floquet_linear q = ric_floquet_map_whole(c, f);
    int k = c->n - 1, ld = 2 * k, exponent = q.exponent;
    double rounding = RIC_FLOQUET_ROUNDING * DBL_EPSILON * ric_floquet_map_roundings(c), trace = 0;
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
        if ((found = ric_floquet_map_halves(c, q.A, f->work, &pairs)))
            ric_floquet_judge_pairs(f, c->sigma < 0, &pairs);
    }
    if (!found) {
        ric_floquet_pairs_inverse(k, q.P, 1, q.P, q.A);
        if (error <= ACCURATE && is_surely_rough(f, error, ld, q.A, q.tmp)) {
            if (whole_fine(c, f, q.A, error)) return;
            ric_floquet_pairs_inverse(k, q.P, 1, q.P, q.A);
        }
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
    if (c->n > 1)
        c->start == RIC_MIRROR_NONE ? ric_floquet_map_whole(c, f)
                                    : ric_floquet_map_reversible(c, f);
    else alone(f);
}
