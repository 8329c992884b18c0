#include "factor.h"

static arb_mat_t *open_blocks(const ric_chain *c, int (*column)(int k, int m))
{
    arb_mat_t *blocks = flint_calloc((size_t)c->m, sizeof *blocks);
    for (int k = 0; k < c->m; k++)
        arb_mat_init(blocks[k], ric_chain_width(c, k), ric_chain_width(c, column(k, c->m)));
    return blocks;
}

static void close_blocks(int m, arb_mat_t *blocks)
{
    for (int k = 0; k < m; k++) arb_mat_clear(blocks[k]);
    flint_free(blocks);
}

static int same(int k, int m)
{
    (void)m;
    return k;
}
static int next(int k, int m)
{
    return k < m - 1 ? k + 1 : m - 1;
}
static int last(int k, int m)
{
    (void)k;
    return m - 1;
}

void ric_factor_create(ric_factor *f, const ric_chain *c, slong prec)
{
    *f = (ric_factor){.m = c->m, .prec = prec};
    f->A = open_blocks(c, same);
    f->U = open_blocks(c, next);
    f->L = open_blocks(c, same);
    f->G = open_blocks(c, next);
    f->H = open_blocks(c, last);
    if (f->m == 1) return;
    arb_mat_clear(f->U[f->m - 1]);
    arb_mat_init(f->U[f->m - 1], ric_chain_width(c, 0), ric_chain_width(c, f->m - 1));
}

void ric_factor_free(ric_factor *f)
{
    close_blocks(f->m, f->A);
    close_blocks(f->m, f->U);
    close_blocks(f->m, f->L);
    close_blocks(f->m, f->G);
    close_blocks(f->m, f->H);
}

/* to += left' right. */
static void add_product(arb_mat_t to, const arb_mat_t left, const arb_mat_t right, slong prec)
{
    arb_mat_t t, product;
    arb_mat_init(t, arb_mat_ncols(left), arb_mat_nrows(left));
    arb_mat_init(product, arb_mat_nrows(to), arb_mat_ncols(to));
    arb_mat_transpose(t, left);
    arb_mat_mul(product, t, right, prec);
    arb_mat_add(to, to, product, prec);
    arb_mat_clear(t);
    arb_mat_clear(product);
}

void ric_factor_assemble(ric_factor *f, const ric_equations *q)
{
    for (int k = 0; k < f->m; k++) {
        arb_mat_zero(f->A[k]);
        arb_mat_zero(f->U[k]);
    }
    for (int i = 0; i < q->n; i++) {
        const ric_equation_group *g = &q->group[i];
        add_product(f->A[g->first], g->J, g->J, f->prec);
        if (g->second < 0) continue;
        add_product(f->A[g->second], g->K, g->K, f->prec);
        if (g->second > g->first) add_product(f->U[g->first], g->J, g->K, f->prec);
        else add_product(f->U[f->m - 1], g->K, g->J, f->prec);
    }
}

/* ------------------------------------------------------------ factorisation */

/* a <- mid(a - left' right). */
static void take_product(arb_mat_t a, const arb_mat_t left, const arb_mat_t right, slong prec)
{
    arb_mat_t t, product;
    arb_mat_init(t, arb_mat_ncols(left), arb_mat_nrows(left));
    arb_mat_init(product, arb_mat_nrows(a), arb_mat_ncols(a));
    arb_mat_transpose(t, left);
    arb_mat_approx_mul(product, t, right, prec);
    arb_mat_sub(a, a, product, prec);
    arb_mat_get_mid(a, a);
    arb_mat_clear(t);
    arb_mat_clear(product);
}

/* The lower triangle of a - alpha in place; false at a pivot that is not positive. */
static bool cholesky(arb_mat_t a, const arb_t alpha, slong prec)
{
    slong n = arb_mat_nrows(a);
    arb_t sum;
    arb_init(sum);
    bool positive = true;
    for (slong j = 0; j < n && positive; j++) {
        arb_ptr row = a->rows[j];
        arb_sub(row + j, row + j, alpha, prec);
        arb_approx_dot(sum, row + j, 1, row, 1, row, 1, j, prec);
        positive = arf_is_finite(arb_midref(sum)) && arf_sgn(arb_midref(sum)) > 0;
        if (!positive) break;
        mag_zero(arb_radref(sum));
        arb_sqrt(row + j, sum, prec);
        arb_get_mid_arb(row + j, row + j);
        for (slong i = j + 1; i < n; i++) {
            arb_ptr lower = a->rows[i];
            arb_approx_dot(sum, lower + j, 1, lower, 1, row, 1, j, prec);
            mag_zero(arb_radref(sum));
            arb_div(lower + j, sum, row + j, prec);
            arb_get_mid_arb(lower + j, lower + j);
            arb_zero(row + i);
        }
    }
    arb_clear(sum);
    return positive;
}

/* Whether H_k is not zero: every k with a corner, else only where it is the block (m - 2, m - 1).
 */
static bool fills(const ric_factor *f, int k)
{
    return f->m > 1 && k < f->m - 1 && (k == f->m - 2 || !arb_mat_is_zero(f->U[f->m - 1]));
}

/* Block (k, m - 1) of A. */
static void last_column(const ric_factor *f, int k, arb_mat_t out)
{
    arb_mat_zero(out);
    if (k == 0) arb_mat_add(out, out, f->U[f->m - 1], f->prec);
    if (k == f->m - 2) arb_mat_add(out, out, f->U[k], f->prec);
}

bool ric_factor_make(ric_factor *f, const arb_t alpha)
{
    const int m = f->m;
    arb_mat_get_mid(f->L[m - 1], f->A[m - 1]);
    for (int k = 0; k < m - 1; k++) {
        arb_mat_get_mid(f->L[k], f->A[k]);
        if (k > 0) take_product(f->L[k], f->G[k - 1], f->G[k - 1], f->prec);
        if (!cholesky(f->L[k], alpha, f->prec)) return false;
        arb_mat_get_mid(f->G[k], f->U[k]);
        if (k < m - 2) arb_mat_approx_solve_tril(f->G[k], f->L[k], f->G[k], 0, f->prec);
        if (!fills(f, k)) continue;
        last_column(f, k, f->H[k]);
        arb_mat_get_mid(f->H[k], f->H[k]);
        if (k > 0 && fills(f, k - 1)) take_product(f->H[k], f->G[k - 1], f->H[k - 1], f->prec);
        arb_mat_approx_solve_tril(f->H[k], f->L[k], f->H[k], 0, f->prec);
        arb_mat_get_mid(f->H[k], f->H[k]);
        take_product(f->L[m - 1], f->H[k], f->H[k], f->prec);
        arb_mat_get_mid(f->G[k], f->G[k]);
    }
    for (int k = 0; k < m - 2; k++) arb_mat_get_mid(f->G[k], f->G[k]);
    return cholesky(f->L[m - 1], alpha, f->prec);
}

static void solve_lower(const arb_mat_t L, arb_mat_t x, bool transposed, slong prec)
{
    arb_mat_t t;
    arb_mat_init(t, arb_mat_nrows(L), arb_mat_nrows(L));
    if (transposed) {
        arb_mat_transpose(t, L);
        arb_mat_approx_solve_triu(x, t, x, 0, prec);
    } else arb_mat_approx_solve_tril(x, L, x, 0, prec);
    arb_mat_get_mid(x, x);
    arb_mat_clear(t);
}

/* x <- mid(x - a b). */
static void take(arb_mat_t x, const arb_mat_t a, const arb_mat_t b, slong prec)
{
    arb_mat_t product;
    arb_mat_init(product, arb_mat_nrows(x), arb_mat_ncols(x));
    arb_mat_approx_mul(product, a, b, prec);
    arb_mat_sub(x, x, product, prec);
    arb_mat_get_mid(x, x);
    arb_mat_clear(product);
}

void ric_factor_solve(const ric_factor *f, arb_mat_t *x)
{
    const int m = f->m;
    for (int k = 0; k < m; k++) {
        if (k > 0 && k < m - 1) take_product(x[k], f->G[k - 1], x[k - 1], f->prec);
        solve_lower(f->L[k], x[k], false, f->prec);
        if (fills(f, k)) take_product(x[m - 1], f->H[k], x[k], f->prec);
    }
    for (int k = m - 1; k >= 0; k--) {
        if (k < m - 2) take(x[k], f->G[k], x[k + 1], f->prec);
        if (fills(f, k)) take(x[k], f->H[k], x[m - 1], f->prec);
        solve_lower(f->L[k], x[k], true, f->prec);
    }
}

/* ----------------------------------------------------------------- residual */

/* to += weight |a|^2, Frobenius. */
static void add_square(arb_t to, const arb_mat_t a, ulong weight, slong prec)
{
    arb_t norm;
    arb_init(norm);
    arb_mat_frobenius_norm(norm, a, prec);
    arb_mul(norm, norm, norm, prec);
    arb_addmul_ui(to, norm, weight, prec);
    arb_clear(norm);
}

/* sum += |L_k L_k' + (rest) - (A_k - alpha)|^2 where `rest` is in w already. */
static void compare_diagonal(const ric_factor *f, int k, const arb_t alpha, arb_mat_t w, arb_t sum)
{
    arb_mat_t t;
    arb_mat_init(t, arb_mat_nrows(w), arb_mat_ncols(w));
    arb_mat_transpose(t, f->L[k]);
    arb_mat_t product;
    arb_mat_init(product, arb_mat_nrows(w), arb_mat_ncols(w));
    arb_mat_mul(product, f->L[k], t, f->prec);
    arb_mat_add(w, w, product, f->prec);
    arb_mat_sub(w, w, f->A[k], f->prec);
    for (slong i = 0; i < arb_mat_nrows(w); i++)
        arb_add(arb_mat_entry(w, i, i), arb_mat_entry(w, i, i), alpha, f->prec);
    add_square(sum, w, 1, f->prec);
    arb_mat_clear(t);
    arb_mat_clear(product);
}

/* sum += 2 |L_k x + (rest) - b|^2. */
static void compare_beside(const ric_factor *f, int k, const arb_mat_t x, arb_mat_t rest,
                           const arb_mat_t b, arb_t sum)
{
    arb_mat_t product;
    arb_mat_init(product, arb_mat_nrows(rest), arb_mat_ncols(rest));
    arb_mat_mul(product, f->L[k], x, f->prec);
    arb_mat_add(rest, rest, product, f->prec);
    arb_mat_sub(rest, rest, b, f->prec);
    add_square(sum, rest, 2, f->prec);
    arb_mat_clear(product);
}

static void compare_last_column(const ric_factor *f, int k, arb_t sum)
{
    arb_mat_t rest, b;
    arb_mat_init(rest, arb_mat_nrows(f->H[k]), arb_mat_ncols(f->H[k]));
    arb_mat_init(b, arb_mat_nrows(f->H[k]), arb_mat_ncols(f->H[k]));
    last_column(f, k, b);
    if (k > 0 && fills(f, k - 1)) add_product(rest, f->G[k - 1], f->H[k - 1], f->prec);
    compare_beside(f, k, f->H[k], rest, b, sum);
    arb_mat_clear(rest);
    arb_mat_clear(b);
}

void ric_factor_residual(const ric_factor *f, const arb_t alpha, arb_t out)
{
    const int m = f->m;
    arb_mat_t end;
    arb_mat_init(end, arb_mat_nrows(f->L[m - 1]), arb_mat_nrows(f->L[m - 1]));
    arb_zero(out);
    for (int k = 0; k < m - 1; k++) {
        arb_mat_t w;
        arb_mat_init(w, arb_mat_nrows(f->L[k]), arb_mat_nrows(f->L[k]));
        if (k > 0) add_product(w, f->G[k - 1], f->G[k - 1], f->prec);
        compare_diagonal(f, k, alpha, w, out);
        arb_mat_clear(w);
        if (k < m - 2) {
            arb_mat_init(w, arb_mat_nrows(f->U[k]), arb_mat_ncols(f->U[k]));
            compare_beside(f, k, f->G[k], w, f->U[k], out);
            arb_mat_clear(w);
        }
        if (!fills(f, k)) continue;
        compare_last_column(f, k, out);
        add_product(end, f->H[k], f->H[k], f->prec);
    }
    compare_diagonal(f, m - 1, alpha, end, out);
    arb_mat_clear(end);
    arb_sqrtpos(out, out, f->prec); /* a sum of squares */
    arb_get_ubound_arf(arb_midref(out), out, f->prec);
    mag_zero(arb_radref(out));
}
