/* What proofs compute in doubles, against the same in many digits: bounds hold for the numbers
 * inside of the balls, whatever these are, and are of use for those that are well behaved. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "ricochet.h"

#if __has_include(<arb.h>) || __has_include(<flint/arb.h>)
#include "prove/contraction.h"
#include "prove/lu.h"
#include "prove/prover.h"
#include "prove/quick.h"
#include "prove/skew.h"

enum { BITS = 512 };

static uint64_t seed = 7;

/* In [-1, 1). */
static double draw(void)
{
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    return (double)(int64_t)(seed >> 11) * 0x1p-52 - 1;
}

/* A ball around x, and in `inside` a number of it. */
static void draw_ball(double x, double radius, arb_t ball, arb_t inside)
{
    arb_set_d(ball, x);
    arb_add_ui(inside, ball, 0, BITS);
    mag_set_d(arb_radref(ball), radius);
    arb_set_d(inside, draw() * radius);
    arb_t centre;
    arb_init(centre);
    arb_set_d(centre, x);
    arb_add(inside, inside, centre, BITS);
    arb_clear(centre);
}

/* sum of the squares of a - b, less than bound^2. */
static void assert_near(const arb_mat_t a, const arb_mat_t b, double bound)
{
    arb_mat_t d;
    arb_t size;
    arb_init(size);
    arb_mat_init(d, arb_mat_nrows(a), arb_mat_ncols(a));
    arb_mat_sub(d, a, b, BITS);
    arb_mat_frobenius_norm(size, d, BITS);
    assert_true(ric_arb_middle(size) <= bound);
    arb_mat_clear(d);
    arb_clear(size);
}

/* -------------------------------------------------------------- contraction */

/* Of singular values down to 10^-digits: a random matrix with a row that is all but that of
 * others. */
static void draw_matrix(arb_mat_t J, arb_mat_t inside, double digits, double radius)
{
    const slong n = arb_mat_nrows(J);
    double *last = calloc((size_t)n, sizeof *last);
    for (slong i = 0; i < n; i++)
        for (slong j = 0; j < n; j++) {
            const bool zero = i + 1 < n && labs(i - j) > 3;
            double x = zero ? 0 : draw();
            if (i + 1 < n) last[j] += x;
            else x = last[j] + x * pow(10, -digits);
            if (!zero) draw_ball(x, radius, arb_mat_entry(J, i, j), arb_mat_entry(inside, i, j));
        }
    free(last);
}

/* C out of C e_j, whose balls hold it. */
static void take_inverse(const ric_contraction *k, arb_mat_t C)
{
    const slong n = k->n;
    arb_ptr unit = _arb_vec_init(n), column = _arb_vec_init(n);
    for (slong j = 0; j < n; j++) {
        _arb_vec_zero(unit, n);
        arb_one(unit + j);
        ric_contraction_apply(k, unit, column);
        for (slong i = 0; i < n; i++) arb_set(arb_mat_entry(C, i, j), column + i);
        for (slong i = 0; i < n && !k->wide; i++)
            assert_true(arb_contains_si(column + i, 0) ||
                        ric_arb_middle(column + i) == k->C[j * n + i]);
        for (slong i = 0; i < n && !k->wide; i++)
            arb_set_d(arb_mat_entry(C, i, j), k->C[j * n + i]);
    }
    _arb_vec_clear(unit, n);
    _arb_vec_clear(column, n);
}

static void check_defect(const ric_contraction *k, const arb_mat_t inside, const arb_mat_t C)
{
    const slong n = k->n;
    arb_mat_t product;
    arb_t x;
    arb_init(x);
    arb_mat_init(product, n, n);
    arb_mat_mul(product, C, inside, BITS);
    for (slong i = 0; i < n; i++)
        for (slong j = 0; j < n; j++) {
            arb_sub_si(x, arb_mat_entry(product, i, j), i == j, BITS);
            assert_true(fabs(ric_arb_middle(x)) <= k->Z[j * n + i]);
        }
    arb_mat_clear(product);
    arb_clear(x);
}

static void check_apply(const ric_contraction *k, const arb_mat_t C, double radius)
{
    const slong n = k->n;
    arb_ptr x = _arb_vec_init(n), inside = _arb_vec_init(n), out = _arb_vec_init(n);
    arb_t exact;
    arb_init(exact);
    for (slong i = 0; i < n; i++) draw_ball(draw() * 1e-30, radius * 1e-30, x + i, inside + i);
    ric_contraction_apply(k, x, out);
    for (slong i = 0; i < n; i++) {
        arb_dot(exact, NULL, 0, arb_mat_entry(C, i, 0), 1, inside, 1, n, BITS);
        arb_get_mid_arb(exact, exact);
        assert_true(arb_contains(out + i, exact));
    }
    arb_clear(exact);
    _arb_vec_clear(x, n);
    _arb_vec_clear(inside, n);
    _arb_vec_clear(out, n);
}

/* |J^-1| <= 1 / least: of 20 directions none is longer. */
static void check_least(const ric_contraction *k, const arb_mat_t inside, double least)
{
    const slong n = k->n;
    arb_mat_t x, y;
    arb_t size;
    arb_init(size);
    arb_mat_init(x, n, 1);
    arb_mat_init(y, n, 1);
    for (int i = 0; i < 20; i++) {
        for (slong j = 0; j < n; j++) arb_set_d(arb_mat_entry(x, j, 0), draw());
        for (int step = 0; step < 3; step++) {
            assert_true(arb_mat_solve(y, inside, x, BITS));
            arb_mat_frobenius_norm(size, x, BITS);
            const double before = ric_arb_middle(size);
            arb_mat_frobenius_norm(size, y, BITS);
            assert_true(ric_arb_middle(size) * least <= before);
            arb_mat_set(x, y);
        }
    }
    arb_mat_clear(x);
    arb_mat_clear(y);
    arb_clear(size);
}

static void check_contraction(double digits, double radius, bool *wide, double *least)
{
    const slong n = 30;
    ric_contraction k;
    arb_mat_t J, inside, C;
    arb_mat_init(J, n, n);
    arb_mat_init(inside, n, n);
    arb_mat_init(C, n, n);
    draw_matrix(J, inside, digits, radius);
    ric_contraction_create(&k, n, 128);
    assert_true(ric_contraction_invert(&k, J, RIC_CONTRACTION_FINE));
    *wide = k.wide;
    take_inverse(&k, C);
    ric_contraction_defect(&k, J);
    check_defect(&k, inside, C);
    check_apply(&k, C, radius);
    assert_true(ric_contraction_invert_quickly(&k, J));
    ric_contraction_defect(&k, J);
    *least = ric_contraction_least(&k);
    if (*least > 0) check_least(&k, inside, *least);
    ric_contraction_free(&k);
    arb_mat_clear(J);
    arb_mat_clear(inside);
    arb_mat_clear(C);
}

static void inverses_are_bounded(void **state)
{
    (void)state;
    for (int i = 0; i < 40; i++) {
        const double digits = i % 20, radius = pow(10, -4.0 * (i % 5) - 2);
        bool wide;
        double least;
        check_contraction(digits, i % 5 == 4 ? 0 : radius, &wide, &least);
        if (digits < 5) assert_false(wide);
        if (digits > 14) assert_true(wide && !(least > 0));
        if (digits < 5 && radius < 1e-12) assert_true(least > 0);
    }
}

static void numbers_that_are_none_prove_nothing(void **state)
{
    (void)state;
    ric_contraction k;
    arb_mat_t J;
    arb_mat_init(J, 3, 3);
    arb_mat_one(J);
    ric_contraction_create(&k, 3, 128);
    assert_true(ric_contraction_invert(&k, J, RIC_CONTRACTION_FINE) && !k.wide);
    arb_indeterminate(arb_mat_entry(J, 1, 2));
    ric_contraction_defect(&k, J);
    for (int i = 0; i < 3; i++) mag_one(k.b + i);
    assert_false(ric_contraction_least(&k) > 0);
    assert_false(ric_contraction_holds(&k));
    ric_contraction_free(&k);
    arb_mat_clear(J);
}

/* ------------------------------------------------------------------- blocks */

enum { BLOCKS = 5, SIZE = 5, WIDE = SIZE + 1, ALL = (BLOCKS - 1) * SIZE + WIDE };

static int width_of(int k)
{
    return k == BLOCKS - 1 ? WIDE : SIZE;
}

/* Groups of rows as those of a general chain; the last block is joined with the first one. */
static void open_group(ric_equation_group *g, int rows, int first, int second)
{
    *g = (ric_equation_group){.rows = rows, .first = first, .second = second};
    arb_mat_init(g->J, rows, width_of(first));
    arb_mat_init(g->K, rows, second < 0 ? 0 : width_of(second));
    arb_mat_init(g->F, rows, 1);
}

static void draw_rows(arb_mat_t block, arb_mat_t D, slong row, slong column, double radius)
{
    for (slong i = 0; i < arb_mat_nrows(block); i++)
        for (slong j = 0; j < arb_mat_ncols(block); j++)
            draw_ball(draw() + (i == j ? 3 : 0), radius, arb_mat_entry(block, i, j),
                      arb_mat_entry(D, row + i, column + j));
}

/* The same rows as numbers of the balls: D [ALL * ALL]. */
static void draw_equations(ric_equations *q, arb_mat_t D, double radius)
{
    slong row = 0;
    q->n = BLOCKS + 2;
    q->group = calloc((size_t)q->n, sizeof *q->group);
    for (int k = 0; k + 1 < BLOCKS; k++) open_group(&q->group[k], SIZE, k, k + 1);
    open_group(&q->group[BLOCKS - 1], 1, 0, -1);
    open_group(&q->group[BLOCKS], SIZE - 1, BLOCKS - 1, 0);
    open_group(&q->group[BLOCKS + 1], 1, 2, -1);
    for (int i = 0; i < q->n; row += q->group[i++].rows) {
        ric_equation_group *g = &q->group[i];
        draw_rows(g->J, D, row, g->first * SIZE, radius);
        if (g->second >= 0) draw_rows(g->K, D, row, g->second * SIZE, radius);
        for (slong l = 0; l < g->rows; l++) arb_set_d(arb_mat_entry(g->F, l, 0), draw() * 1e-40);
    }
}

static void close_equations(ric_equations *q)
{
    for (int i = 0; i < q->n; i++) {
        arb_mat_clear(q->group[i].J);
        arb_mat_clear(q->group[i].K);
        arb_mat_clear(q->group[i].F);
    }
    free(q->group);
}

static void put_lower(const ric_quick *f, const double *blocks, int k, int row, int column,
                      bool turned, arb_mat_t L)
{
    const double *block = blocks + k * WIDE * WIDE;
    for (int i = 0; i < width_of(row); i++)
        for (int j = 0; j < width_of(column); j++)
            arb_set_d(arb_mat_entry(L, row * SIZE + i, column * SIZE + j),
                      turned ? block[j * f->wide + i] : block[i * f->wide + j]);
}

/* L as a whole. */
static void gather_lower(const ric_quick *f, arb_mat_t L)
{
    arb_mat_zero(L);
    for (int k = 0; k < BLOCKS; k++) put_lower(f, f->L, k, k, k, false, L);
    for (int k = 0; k < BLOCKS - 2; k++) put_lower(f, f->G, k, k + 1, k, true, L);
    for (int k = 0; k < BLOCKS - 1; k++) put_lower(f, f->H, k, BLOCKS - 1, k, true, L);
}

/* |L L' - (D'D - alpha)| of numbers of the balls. */
static void check_residual(const ric_quick *f, const arb_mat_t D, double alpha)
{
    arb_mat_t L, A, turned, product;
    arb_mat_init(L, ALL, ALL);
    arb_mat_init(A, ALL, ALL);
    arb_mat_init(turned, ALL, ALL);
    arb_mat_init(product, ALL, ALL);
    arb_mat_transpose(turned, D);
    arb_mat_mul(A, turned, D, BITS);
    for (slong i = 0; i < ALL; i++) {
        arb_t x;
        arb_init(x);
        arb_set_d(x, alpha);
        arb_sub(arb_mat_entry(A, i, i), arb_mat_entry(A, i, i), x, BITS);
        arb_clear(x);
    }
    gather_lower(f, L);
    arb_mat_transpose(turned, L);
    arb_mat_mul(product, L, turned, BITS);
    assert_near(product, A, ric_quick_residual(f, alpha));
    arb_mat_clear(L);
    arb_mat_clear(A);
    arb_mat_clear(turned);
    arb_mat_clear(product);
}

/* D x = F but for what doubles are. */
static void check_step(const ric_quick *f, const ric_equations *q, const arb_mat_t D)
{
    double x[ALL], most = 0, row[ALL] = {0};
    int at = 0;
    ric_quick_step(f, q, x);
    for (int i = 0; i < q->n; i++)
        for (int l = 0; l < q->group[i].rows; l++, at++) {
            row[at] = -ric_arb_middle(arb_mat_entry(q->group[i].F, l, 0));
            for (int j = 0; j < ALL; j++) row[at] += ric_arb_middle(arb_mat_entry(D, at, j)) * x[j];
            most = fmax(most, fabs(row[at]));
        }
    assert_int_equal(at, ALL);
    assert_true(most < 1e-52);
}

static void blocks_are_bounded(void **state)
{
    (void)state;
    for (int i = 0; i < 20; i++) {
        const double radius = i % 4 ? pow(10, -4.0 * (i % 4) - 4) : 0, alpha = 1e-7 * (i % 3);
        ric_chain c = {.n = 2, .m = BLOCKS, .size = SIZE, .start = RIC_CHAIN_GENERAL};
        ric_equations q;
        ric_quick f;
        arb_mat_t D;
        arb_mat_init(D, ALL, ALL);
        draw_equations(&q, D, radius);
        ric_quick_create(&f, &c);
        assert_int_equal(ric_quick_unknowns(&f), (int)ALL);
        ric_quick_assemble(&f, &q);
        assert_true(ric_quick_make(&f, alpha));
        check_residual(&f, D, alpha);
        const double residual = ric_quick_residual(&f, alpha);
        assert_true(residual < 1e3 * radius + 1e-10);
        if (alpha == 0 && radius == 0) check_step(&f, &q, D);
        ric_quick_free(&f);
        close_equations(&q);
        arb_mat_clear(D);
    }
}

/* ------------------------------------------------------------------- basis */

/* u = T x, column by column. */
static void leave_basis(const ric_skew *s, arb_srcptr x, arb_ptr u)
{
    arb_ptr direction = _arb_vec_init(s->n);
    _arb_vec_set(u, x, s->n);
    for (int d = 0; d < s->count; d++) arb_zero(u + s->at[d]);
    for (int d = 0; d < s->count; d++) {
        ric_skew_direction(s, d, direction);
        _arb_vec_scalar_addmul(u, direction, s->n, x + s->at[d], BITS);
    }
    _arb_vec_clear(direction, s->n);
}

/* u in |T| |x|, x in |T^-1| |u|, and J u = (J T) x. */
static void check_basis(const ric_skew *s, const arb_mat_t J, const arb_mat_t skewed)
{
    const slong n = s->n;
    arb_ptr x = _arb_vec_init(n), u = _arb_vec_init(n);
    mag_ptr radii = _mag_vec_init(n), bounds = _mag_vec_init(n);
    arb_t left, right;
    mag_t size;
    arb_init(left);
    arb_init(right);
    mag_init(size);
    for (slong i = 0; i < n; i++) arb_set_d(x + i, draw());
    leave_basis(s, x, u);
    for (slong i = 0; i < n; i++) arb_get_mag(radii + i, x + i);
    ric_skew_spread(s, radii, bounds);
    for (slong i = 0; i < n; i++) {
        arb_get_mag_lower(size, u + i);
        assert_true(mag_cmp(size, bounds + i) <= 0);
        arb_get_mag(radii + i, u + i);
    }
    ric_skew_enter(s, radii, bounds);
    for (slong i = 0; i < n; i++) {
        arb_get_mag_lower(size, x + i);
        assert_true(mag_cmp(size, bounds + i) <= 0);
        arb_dot(left, NULL, 0, arb_mat_entry(J, i, 0), 1, u, 1, n, BITS);
        arb_dot(right, NULL, 0, arb_mat_entry(skewed, i, 0), 1, x, 1, n, BITS);
        assert_true(arb_overlaps(left, right) && arb_rel_accuracy_bits(left) > 100);
    }
    arb_clear(left);
    arb_clear(right);
    mag_clear(size);
    _arb_vec_clear(x, n);
    _arb_vec_clear(u, n);
    _mag_vec_clear(radii, n);
    _mag_vec_clear(bounds, n);
}

/* Z += by |C A|, column by column. */
static void add_matrix(ric_contraction *k, const arb_mat_t A, double by)
{
    ric_contraction_column x;
    ric_contraction_column_open(&x, k->n);
    for (slong j = 0; j < k->n; j++) {
        x.count = 0;
        for (slong i = 0; i < k->n; i++)
            if (!arb_is_zero(arb_mat_entry(A, i, j)))
                ric_contraction_column_put(&x, i, ric_ball_of(arb_mat_entry(A, i, j)));
        ric_contraction_add(k, j, &x, by);
    }
    ric_contraction_column_close(&x);
}

/* Z of 1 - C J T and half of |C A| beside it. */
static void check_sum(ric_contraction *k, const arb_mat_t skewed, const arb_mat_t C)
{
    const slong n = k->n;
    arb_mat_t A, inside, first, second;
    arb_mat_init(A, n, n);
    arb_mat_init(inside, n, n);
    arb_mat_init(first, n, n);
    arb_mat_init(second, n, n);
    for (slong i = 0; i < n; i++)
        for (slong j = i / 2; j < n && j < i + 2; j++)
            draw_ball(draw(), 1e-3, arb_mat_entry(A, i, j), arb_mat_entry(inside, i, j));
    ric_contraction_defect(k, skewed);
    add_matrix(k, A, 0.5);
    arb_mat_mul(first, C, skewed, BITS);
    arb_mat_mul(second, C, inside, BITS);
    for (slong i = 0; i < n; i++)
        for (slong j = 0; j < n; j++) {
            const double defect = ric_arb_middle(arb_mat_entry(first, i, j)) - (i == j);
            const double more = fabs(ric_arb_middle(arb_mat_entry(second, i, j))) / 2;
            assert_true((fabs(defect) + more) * (1 - 1e-12) <= k->Z[j * n + i]);
        }
    arb_mat_clear(A);
    arb_mat_clear(inside);
    arb_mat_clear(first);
    arb_mat_clear(second);
}

/* Matrices with one direction that is all but lost: in the basis doubles invert them well. */
static void bases_keep_what_cancels(void **state)
{
    (void)state;
    const slong n = 30;
    for (int i = 0; i < 20; i++) {
        ric_contraction k;
        ric_skew s;
        arb_mat_t J, inside, skewed, C;
        arb_mat_init(J, n, n);
        arb_mat_init(inside, n, n);
        arb_mat_init(skewed, n, n);
        arb_mat_init(C, n, n);
        draw_matrix(J, inside, 6 + i % 8, 0);
        ric_contraction_create(&k, n, 128);
        ric_skew_create(&s, n);
        assert_true(ric_contraction_invert_quickly(&k, J));
        assert_true(ric_skew_find(&s, &k) && ric_skew_find(&s, &k));
        assert_true(s.count == 2 && s.at[0] != s.at[1] && s.r[1][s.at[0]] == 0);
        arb_mat_set(skewed, J);
        ric_skew_columns(&s, skewed, BITS);
        check_basis(&s, J, skewed);
        assert_true(ric_contraction_invert_quickly(&k, skewed));
        ric_contraction_defect(&k, skewed);
        double most = 0;
        for (slong l = 0; l < n * n; l++)
            if (l % n != s.at[0] && l % n != s.at[1]) most = fmax(most, k.Z[l]);
        assert_true(most < 1e-9 && !k.wide);
        take_inverse(&k, C);
        check_sum(&k, skewed, C);
        ric_skew_free(&s);
        ric_contraction_free(&k);
        arb_mat_clear(J);
        arb_mat_clear(inside);
        arb_mat_clear(skewed);
        arb_mat_clear(C);
    }
}

/* Of one to six limbs, half way between doubles and just beside, and where doubles end. */
/* Of matrices in a band with some full rows, of more columns than are taken at a time. */
static void factors_solve(void **state)
{
    (void)state;
    for (slong n = 1; n < 200; n += 33) {
        arb_mat_t J;
        ric_lu lu;
        double *C = calloc((size_t)(n * n), sizeof *C), *x = calloc(2 * (size_t)n, sizeof *x);
        arb_mat_init(J, n, n);
        for (slong i = 0; i < n; i++)
            for (slong j = 0; j < n; j++)
                if (labs(i - j) < 4 || i % 50 == 7) arb_set_d(arb_mat_entry(J, i, j), draw());
        for (slong i = 0; i < n; i++) x[i] = draw();
        ric_lu_create(&lu, n);
        assert_true(ric_lu_make(&lu, J));
        ric_lu_invert(&lu, C);
        ric_lu_solve(&lu, x, x + n);
        for (slong i = 0; i < n; i++) {
            double solved = 0, inverse = 0;
            for (slong j = 0; j < n; j++) {
                const double y = ric_arb_middle(arb_mat_entry(J, i, j));
                solved += y * x[n + j];
                inverse += y * C[(n / 2) * n + j];
            }
            assert_true(fabs(solved - x[i]) < 1e-9);
            assert_true(fabs(inverse - (i == n / 2)) < 1e-9);
        }
        for (slong i = 0; i < n; i++) arb_zero(arb_mat_entry(J, i, n / 3));
        assert_false(ric_lu_make(&lu, J));
        ric_lu_free(&lu);
        arb_mat_clear(J);
        free(C);
        free(x);
    }
}

static void nearest_doubles(void **state)
{
    (void)state;
    arb_t x, small;
    arb_init(x);
    arb_init(small);
    for (int i = 0; i < 4000; i++) {
        arb_set_d(x, draw());
        if (i % 2) arb_set_d(small, ldexp(i % 3 ? 1 : -1, ilogb(ric_arb_middle(x)) - 53));
        else arb_set_d(small, ldexp(draw(), -40));
        arb_add(x, x, small, ARF_PREC_EXACT);
        arb_set_d(small, ldexp(i % 5 ? 1 : -1, -100 - 50 * (i % 7)));
        if (i % 4) arb_add(x, x, small, ARF_PREC_EXACT);
        arb_mul_2exp_si(x, x, i % 11 ? 37 * (i % 60 - 30) : 0);
        assert_true(ric_arb_nearest(arb_midref(x)) == arf_get_d(arb_midref(x), ARF_RND_NEAR));
    }
    arb_zero(x);
    assert_true(ric_arb_nearest(arb_midref(x)) == 0);
    arb_pos_inf(x);
    assert_true(isinf(ric_arb_nearest(arb_midref(x))));
    arf_nan(arb_midref(x));
    assert_true(isnan(ric_arb_nearest(arb_midref(x))));
    arb_clear(x);
    arb_clear(small);
}

/* What is enclosed to less than what is stored does not say that another orbit is stored. */
static void another_is_told_from_less(void **state)
{
    (void)state;
    const ric_point stored = {.energy = 2, .frequency = 8 * atan(1)};
    ric_proof out = {.energy = {1.9, 2.1}, .period = {1, 1}};
    assert_false(ric_prover_agrees(&stored, &out));
    assert_non_null(strstr(out.why, "known to less"));
    out.energy[0] = 2.01;
    assert_false(ric_prover_agrees(&stored, &out));
    assert_non_null(strstr(out.why, "is not that of the orbit"));
    out.energy[0] = out.energy[1] = 2;
    assert_true(ric_prover_agrees(&stored, &out));
    out.period[0] = 0.9;
    assert_false(ric_prover_agrees(&stored, &out));
    assert_non_null(strstr(out.why, "known to less"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(inverses_are_bounded),
        cmocka_unit_test(numbers_that_are_none_prove_nothing),
        cmocka_unit_test(blocks_are_bounded),
        cmocka_unit_test(bases_keep_what_cancels),
        cmocka_unit_test(factors_solve),
        cmocka_unit_test(nearest_doubles),
        cmocka_unit_test(another_is_told_from_less),
    };
    return cmocka_run_group_tests_name("prove_doubles", tests, NULL, NULL);
}
#else
int main(void)
{
    return 77;
}
#endif
