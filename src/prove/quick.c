#include "quick.h"

#include <math.h>
#include <string.h>

#include "ball.h"

/* ------------------------------------------------------------------- memory */

static double *doubles(size_t n)
{
    return flint_calloc(n, sizeof(double));
}

void ric_quick_create(ric_quick *f, const ric_chain *c)
{
    *f = (ric_quick){.m = c->m, .n = c->m + 2, .size = c->size};
    f->wide = ric_chain_width(c, c->m - 1);
    const size_t block = (size_t)f->wide * (size_t)f->wide, m = (size_t)f->m;
    f->A = doubles(5 * m * block);
    f->U = f->A + m * block;
    f->L = f->U + m * block;
    f->G = f->L + m * block;
    f->H = f->G + m * block;
    f->off_A = doubles(2 * m);
    f->off_U = f->off_A + m;
    f->work = doubles(2 * block);
    f->group = flint_calloc((size_t)f->n, sizeof *f->group);
    for (int i = 0; i < f->n; i++) {
        f->group[i].J = doubles(2 * block);
        f->group[i].K = f->group[i].J + block;
    }
    f->row = doubles((m + 2) * (size_t)f->wide);
    f->spare = doubles((size_t)ric_quick_unknowns(f));
}

void ric_quick_free(ric_quick *f)
{
    for (int i = 0; i < f->n; i++) flint_free(f->group[i].J);
    flint_free(f->group);
    flint_free(f->A);
    flint_free(f->off_A);
    flint_free(f->work);
    flint_free(f->row);
    flint_free(f->spare);
    f->n = 0;
}

static double *block_of(const ric_quick *f, double *blocks, int k)
{
    return blocks + (size_t)k * (size_t)f->wide * (size_t)f->wide;
}

static int width(const ric_quick *f, int k)
{
    return k == f->m - 1 ? f->wide : f->size;
}

/* -------------------------------------------------------------------- sizes */

/* At least the root of a sum of up to 2^20 squares: their roundings, and those that underflow. */
static double root_up(double sum)
{
    return sqrt(sum) * (1 + 0x1p-30) + 0x1p-500;
}

/* At least sqrt(sum x^2). */
static double norm(size_t n, const double *x)
{
    double sum = 0;
    for (size_t i = 0; i < n; i++) sum += x[i] * x[i];
    return root_up(sum);
}

static double block_norm(const ric_quick *f, const double *block)
{
    return norm((size_t)f->wide * (size_t)f->wide, block);
}

/* Of the sum of sizes of `count` products: what their sum is off by. Bounds are themselves sums of
 * fewer terms, rounded, for which the last factor is. */
static double rounding(double count, double sizes)
{
    return (count + 8) * 2 * RIC_BALL_UNIT * sizes * (1 + 0x1p-20) + 0x1p-500;
}

/* ----------------------------------------------------------------- products */

/* to += sign left' right; what a block does not fill is zero. */
static void add_gram(const ric_quick *f, double *to, const double *left, const double *right,
                     double sign)
{
    const int wide = f->wide;
    for (int r = 0; r < wide; r++)
        for (int i = 0; i < wide; i++) {
            const double x = sign * left[r * wide + i];
            if (x == 0) continue;
            for (int j = 0; j < wide; j++) to[i * wide + j] += x * right[r * wide + j];
        }
}

/* to += left right, `left` without what is right of its diagonal. */
static void add_lower(const ric_quick *f, double *to, const double *left, const double *right)
{
    const int wide = f->wide;
    for (int i = 0; i < wide; i++)
        for (int l = 0; l <= i; l++) {
            const double x = left[i * wide + l];
            for (int j = 0; j < wide; j++) to[i * wide + j] += x * right[l * wide + j];
        }
}

/* The doubles of a matrix of balls, [rows * wide]; returns how far off they are at most. */
static double take_middle(const ric_quick *f, const arb_mat_t from, double *to)
{
    double sum = 0;
    memset(to, 0, (size_t)f->wide * (size_t)f->wide * sizeof *to);
    for (slong i = 0; i < arb_mat_nrows(from); i++)
        for (slong j = 0; j < arb_mat_ncols(from); j++) {
            if (arb_is_zero(arb_mat_entry(from, i, j))) continue;
            const ric_ball x = ric_ball_of(arb_mat_entry(from, i, j));
            to[i * f->wide + j] = x.m;
            sum += x.r * x.r;
        }
    return root_up(sum);
}

/* |left' right - what doubles say|, where both are off by what is given. */
static double off_product(double count, const double size[2], const double off[2])
{
    return (size[0] * off[1] + off[0] * (size[1] + off[1])) * (1 + 0x1p-40) +
           rounding(count, size[0] * size[1]);
}

static void add_group(ric_quick *f, ric_quick_group *to, const ric_equation_group *g)
{
    const double count = 6.0 * f->wide;
    *to = (ric_quick_group){g->rows, g->first, g->second, to->J, to->K};
    double off[2] = {take_middle(f, g->J, to->J), 0}, size[2] = {block_norm(f, to->J), 0};
    add_gram(f, block_of(f, f->A, g->first), to->J, to->J, 1);
    f->off_A[g->first] += off_product(count, (double[]){size[0], size[0]},
                                      (double[]){off[0], off[0]});
    if (g->second < 0) return;
    off[1] = take_middle(f, g->K, to->K);
    size[1] = block_norm(f, to->K);
    add_gram(f, block_of(f, f->A, g->second), to->K, to->K, 1);
    f->off_A[g->second] += off_product(count, (double[]){size[1], size[1]},
                                       (double[]){off[1], off[1]});
    const bool corner = g->second < g->first;
    const int at = corner ? f->m - 1 : g->first;
    if (corner) add_gram(f, block_of(f, f->U, at), to->K, to->J, 1);
    else add_gram(f, block_of(f, f->U, at), to->J, to->K, 1);
    f->off_U[at] += off_product(count, size, off);
    f->corner = f->corner || corner;
}

void ric_quick_assemble(ric_quick *f, const ric_equations *q)
{
    const size_t block = (size_t)f->wide * (size_t)f->wide, m = (size_t)f->m;
    memset(f->A, 0, 2 * m * block * sizeof *f->A);
    memset(f->off_A, 0, 2 * m * sizeof *f->off_A);
    f->corner = false;
    for (int i = 0; i < q->n; i++) add_group(f, &f->group[i], &q->group[i]);
}

/* ------------------------------------------------------------ factorisation */

/* The lower triangle of a - alpha in place; false at a pivot that is not positive. */
static bool cholesky(const ric_quick *f, double *a, int n, double alpha)
{
    const int wide = f->wide;
    for (int j = 0; j < n; j++) {
        double *row = a + j * wide;
        double sum = row[j] - alpha;
        for (int l = 0; l < j; l++) sum -= row[l] * row[l];
        if (!(sum > 0) || !isfinite(sum)) return false;
        row[j] = sqrt(sum);
        for (int i = j + 1; i < n; i++) {
            double *lower = a + i * wide;
            sum = lower[j];
            for (int l = 0; l < j; l++) sum -= lower[l] * row[l];
            lower[j] = sum / row[j];
            row[i] = 0;
        }
    }
    return true;
}

/* x [n * columns] <- L^-1 x, or L'^-1 x. */
static void solve_lower(const double *L, int wide, int n, double *x, int columns, int stride)
{
    for (int i = 0; i < n; i++) {
        for (int l = 0; l < i; l++) {
            const double y = L[i * wide + l];
            for (int j = 0; j < columns; j++) x[i * stride + j] -= y * x[l * stride + j];
        }
        for (int j = 0; j < columns; j++) x[i * stride + j] /= L[i * wide + i];
    }
}

static void solve_upper(const double *L, int wide, int n, double *x)
{
    for (int i = n - 1; i >= 0; i--) {
        x[i] /= L[i * wide + i];
        for (int l = 0; l < i; l++) x[l] -= L[i * wide + l] * x[i];
    }
}

/* Whether H_k is not zero: every k with a corner, else only where it is the block (m - 2, m - 1).
 */
static bool fills(const ric_quick *f, int k)
{
    return f->m > 1 && k < f->m - 1 && (k == f->m - 2 || f->corner);
}

/* Block (k, m - 1) of A; returns what it is off by. */
static double last_column(const ric_quick *f, int k, double *out)
{
    const int wide = f->wide;
    const double *corner = block_of(f, f->U, f->m - 1), *beside = block_of(f, f->U, k);
    for (int i = 0; i < wide * wide; i++)
        out[i] = (k == 0 ? corner[i] : 0) + (k == f->m - 2 ? beside[i] : 0);
    return (k == 0 ? f->off_U[f->m - 1] : 0) + (k == f->m - 2 ? f->off_U[k] : 0);
}

bool ric_quick_make(ric_quick *f, double alpha)
{
    const int m = f->m, wide = f->wide;
    const size_t block = (size_t)wide * (size_t)wide;
    memcpy(f->L, f->A, (size_t)m * block * sizeof *f->L);
    memset(f->G, 0, 2 * (size_t)m * block * sizeof *f->G);
    double *end = block_of(f, f->L, m - 1);
    for (int k = 0; k < m - 1; k++) {
        const int n = f->size;
        double *L = block_of(f, f->L, k), *G = block_of(f, f->G, k), *H = block_of(f, f->H, k);
        const double *before = k > 0 ? G - block : NULL;
        if (before) add_gram(f, L, before, before, -1);
        if (!cholesky(f, L, n, alpha)) return false;
        if (k < m - 2) {
            memcpy(G, block_of(f, f->U, k), block * sizeof *G);
            solve_lower(L, wide, n, G, n, wide);
        }
        if (!fills(f, k)) continue;
        last_column(f, k, H);
        if (before && fills(f, k - 1)) add_gram(f, H, before, H - block, -1);
        solve_lower(L, wide, n, H, wide, wide);
        add_gram(f, end, H, H, -1);
    }
    return cholesky(f, end, wide, alpha);
}

/* ---------------------------------------------------------------- solutions */

/* y [columns] -= a' x, or x [rows] -= a y. */
static void take_turned(const ric_quick *f, const double *a, int rows, int columns, const double *x,
                        double *y)
{
    for (int r = 0; r < rows; r++)
        for (int j = 0; j < columns; j++) y[j] -= a[r * f->wide + j] * x[r];
}
static void take(const ric_quick *f, const double *a, int rows, int columns, const double *y,
                 double *x)
{
    for (int r = 0; r < rows; r++)
        for (int j = 0; j < columns; j++) x[r] -= a[r * f->wide + j] * y[j];
}

void ric_quick_solve(const ric_quick *f, double *x)
{
    const int m = f->m, n = f->size, wide = f->wide;
    double *end = x + (size_t)(m - 1) * (size_t)n;
    for (int k = 0; k < m; k++) {
        double *here = x + (size_t)k * (size_t)n;
        if (k > 0 && k < m - 1) take_turned(f, block_of(f, f->G, k - 1), n, n, here - n, here);
        solve_lower(block_of(f, f->L, k), wide, width(f, k), here, 1, 1);
        if (fills(f, k)) take_turned(f, block_of(f, f->H, k), n, wide, here, end);
    }
    for (int k = m - 1; k >= 0; k--) {
        double *here = x + (size_t)k * (size_t)n;
        if (k < m - 2) take(f, block_of(f, f->G, k), n, n, here + n, here);
        if (fills(f, k)) take(f, block_of(f, f->H, k), n, wide, end, here);
        solve_upper(block_of(f, f->L, k), wide, width(f, k), here);
    }
}

/* x <- (D'D)^-1 D' r. */
static void solve_rows(const ric_quick *f, const double *r, double *x)
{
    memset(x, 0, (size_t)ric_quick_unknowns(f) * sizeof *x);
    for (int i = 0; i < f->n; r += f->group[i++].rows) {
        const ric_quick_group *g = &f->group[i];
        const int at = g->first * f->size, beside = g->second * f->size;
        for (int l = 0; l < g->rows; l++) {
            for (int j = 0; j < width(f, g->first); j++) x[at + j] += g->J[l * f->wide + j] * r[l];
            for (int j = 0; g->second >= 0 && j < width(f, g->second); j++)
                x[beside + j] += g->K[l * f->wide + j] * r[l];
        }
    }
    ric_quick_solve(f, x);
}

/* r <- r - D x. */
static void take_rows(const ric_quick *f, const double *x, double *r)
{
    for (int i = 0; i < f->n; r += f->group[i++].rows) {
        const ric_quick_group *g = &f->group[i];
        const double *first = x + (size_t)g->first * (size_t)f->size;
        take(f, g->J, g->rows, width(f, g->first), first, r);
        if (g->second < 0) continue;
        take(f, g->K, g->rows, width(f, g->second), x + (size_t)g->second * (size_t)f->size, r);
    }
}

/* The normal equations lose as many digits again as D'D is worse than D: what is left of the rows
 * is solved for once more. */
void ric_quick_step(const ric_quick *f, const ric_equations *q, double *x)
{
    double *r = f->row;
    for (int i = 0, at = 0; i < q->n; i++)
        for (int l = 0; l < q->group[i].rows; l++)
            r[at++] = ric_arb_middle(arb_mat_entry(q->group[i].F, l, 0));
    solve_rows(f, r, x);
    take_rows(f, x, r);
    solve_rows(f, r, f->spare);
    for (int i = 0; i < ric_quick_unknowns(f); i++) x[i] += f->spare[i];
}

/* ----------------------------------------------------------------- residual */

/* |w - b|^2 as a bound, w a sum of `count` products of which `sizes` bounds the sizes, and b off by
 * `off`. */
static double square(const ric_quick *f, double *w, const double *b, double count, double sizes,
                     double off)
{
    for (int i = 0; i < f->wide * f->wide; i++) w[i] -= b[i];
    const double all = block_norm(f, w) + rounding(count + 2, sizes + block_norm(f, b)) +
                       off * (1 + 0x1p-40);
    return all * all * (1 + 0x1p-40);
}

/* Of a diagonal block: w + L_k L_k' - (A_k - alpha). */
static double square_diagonal(const ric_quick *f, int k, double alpha, double *w, double count,
                              double sizes)
{
    const int n = width(f, k);
    const double *L = block_of(f, f->L, k), size = block_norm(f, L);
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++)
            for (int l = 0; l <= i && l <= j; l++)
                w[i * f->wide + j] += L[i * f->wide + l] * L[j * f->wide + l];
        w[i * f->wide + i] += alpha;
    }
    return square(f, w, block_of(f, f->A, k), count + n + 1, sizes + size * size + alpha * n,
                  f->off_A[k]);
}

/* Of block (k, m - 1). */
static double square_last(const ric_quick *f, int k, double *w)
{
    const size_t block = (size_t)f->wide * (size_t)f->wide;
    const int wide = f->wide;
    double *H = block_of(f, f->H, k), *b = f->work + block;
    double sizes = block_norm(f, block_of(f, f->L, k)) * block_norm(f, H);
    const double off = last_column(f, k, b);
    memset(w, 0, block * sizeof *w);
    if (k > 0 && fills(f, k - 1)) {
        double *G = block_of(f, f->G, k - 1);
        add_gram(f, w, G, H - block, 1);
        sizes += block_norm(f, G) * block_norm(f, H - block);
    }
    add_lower(f, w, block_of(f, f->L, k), H);
    return square(f, w, b, 2.0 * wide, sizes, off);
}

double ric_quick_residual(const ric_quick *f, double alpha)
{
    const size_t block = (size_t)f->wide * (size_t)f->wide;
    const int m = f->m, n = f->size, wide = f->wide;
    double *w = f->work, *end = doubles(block), sum = 0, sizes = 0;
    for (int k = 0; k < m - 1; k++) {
        double *L = block_of(f, f->L, k), *G = block_of(f, f->G, k), *H = block_of(f, f->H, k);
        double size = 0;
        memset(w, 0, block * sizeof *w);
        if (k > 0) {
            add_gram(f, w, G - block, G - block, 1);
            size = pow(block_norm(f, G - block), 2);
        }
        sum += square_diagonal(f, k, alpha, w, wide, size);
        if (k < m - 2) {
            memset(w, 0, block * sizeof *w);
            add_lower(f, w, L, G);
            size = block_norm(f, L) * block_norm(f, G);
            sum += 2 * square(f, w, block_of(f, f->U, k), wide, size, f->off_U[k]);
        }
        if (!fills(f, k)) continue;
        sum += 2 * square_last(f, k, w);
        add_gram(f, end, H, H, 1);
        sizes += pow(block_norm(f, H), 2);
    }
    sum += square_diagonal(f, m - 1, alpha, end, (double)m * n, sizes);
    flint_free(end);
    return sqrt(sum) * (1 + 0x1p-20);
}
