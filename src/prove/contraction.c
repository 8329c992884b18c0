#include "contraction.h"

#include <math.h>
#include <string.h>

#include "ball.h"
#include "base/room.h"

void ric_contraction_create(ric_contraction *k, slong n, slong prec)
{
    *k = (ric_contraction){.n = n, .prec = prec};
    k->C = flint_malloc(2 * (size_t)n * (size_t)n * sizeof *k->C);
    k->size = k->C + n * n;
    k->Z = flint_malloc((size_t)n * (size_t)n * sizeof *k->Z);
    k->y = _mag_vec_init(n);
    k->b = _mag_vec_init(n);
}

static void go_wide(ric_contraction *k, bool wide)
{
    if (wide && !k->wide) arb_mat_init(k->own, k->n, k->n);
    if (!wide && k->wide) arb_mat_clear(k->own);
    k->wide = wide;
}

void ric_contraction_free(ric_contraction *k)
{
    if (!k->Z) return;
    go_wide(k, false);
    flint_free(k->C);
    flint_free(k->Z);
    _mag_vec_clear(k->y, k->n);
    _mag_vec_clear(k->b, k->n);
    k->Z = NULL;
}

/* ------------------------------------------------------------------ inverse */

/* x [n] -= f y. */
static void take(slong n, double *x, double f, const double *y)
{
    for (slong i = 0; i < n; i++) x[i] -= f * y[i];
}

static void swap(slong n, double *x, double *y)
{
    for (slong i = 0; i < n; i++) {
        const double t = x[i];
        x[i] = y[i];
        y[i] = t;
    }
}

/* Gauss with row pivots, in a band but for some rows: what is zero is passed over. a [n * n] is
 * lost, b [n * n], 1 before, is its inverse. */
static bool invert(slong n, double *a, double *b)
{
    for (slong p = 0; p < n; p++) {
        slong best = p;
        for (slong i = p + 1; i < n; i++)
            if (fabs(a[i * n + p]) > fabs(a[best * n + p])) best = i;
        if (!(fabs(a[best * n + p]) > 0)) return false;
        if (best != p) swap(n - p, a + p * n + p, a + best * n + p);
        if (best != p) swap(n, b + p * n, b + best * n);
        for (slong i = p + 1; i < n; i++) {
            const double f = a[i * n + p] / a[p * n + p];
            if (f == 0) continue;
            take(n - p, a + i * n + p, f, a + p * n + p);
            take(n, b + i * n, f, b + p * n);
        }
    }
    for (slong p = n - 1; p >= 0; p--) {
        for (slong i = 0; i < n; i++) b[p * n + i] /= a[p * n + p];
        for (slong i = 0; i < p; i++)
            if (a[i * n + p] != 0) take(n, b + i * n, a[i * n + p], b + p * n);
    }
    return true;
}

static bool invert_middle(ric_contraction *k, const arb_mat_t J)
{
    const slong n = k->n;
    double *a = k->size, *b = flint_calloc((size_t)(n * n), sizeof *b);
    for (slong i = 0; i < n; i++) {
        b[i * n + i] = 1;
        for (slong j = 0; j < n; j++) {
            const bool zero = arb_is_zero(arb_mat_entry(J, i, j));
            a[i * n + j] = zero ? 0 : ric_arb_middle(arb_mat_entry(J, i, j));
        }
    }
    const bool done = invert(n, a, b);
    for (slong i = 0; i < n && done; i++)
        for (slong j = 0; j < n; j++) {
            k->C[j * n + i] = b[i * n + j];
            k->size[j * n + i] = fabs(b[i * n + j]);
        }
    flint_free(b);
    return done;
}

double ric_contraction_left(const ric_contraction *k)
{
    double most = 0;
    for (slong i = 0; i < k->n; i++) {
        double sum = 0;
        for (slong j = 0; j < k->n; j++) sum += k->Z[i * k->n + j];
        if (!(sum <= most)) most = sum;
    }
    return most;
}

bool ric_contraction_is_fine(const ric_contraction *k)
{
    return ric_contraction_left(k) < RIC_CONTRACTION_FINE;
}

/* What C is off the inverse by, which Z is then. */
static double find_left(ric_contraction *k, const arb_mat_t J)
{
    arb_mat_t middle;
    arb_mat_init(middle, k->n, k->n);
    arb_mat_get_mid(middle, J);
    ric_contraction_defect(k, middle);
    arb_mat_clear(middle);
    return ric_contraction_left(k);
}

bool ric_contraction_invert_quickly(ric_contraction *k, const arb_mat_t J)
{
    go_wide(k, false);
    return invert_middle(k, J);
}

bool ric_contraction_invert_widely(ric_contraction *k, const arb_mat_t J)
{
    arb_mat_t mid;
    go_wide(k, true);
    arb_mat_init(mid, k->n, k->n);
    arb_mat_get_mid(mid, J);
    const bool done = arb_mat_approx_inv(k->own, mid, k->prec);
    arb_mat_get_mid(k->own, k->own);
    arb_mat_clear(mid);
    return done;
}

bool ric_contraction_invert(ric_contraction *k, const arb_mat_t J, double left)
{
    return (ric_contraction_invert_quickly(k, J) && find_left(k, J) < left) ||
           ric_contraction_invert_widely(k, J);
}

/* ----------------------------------------------------------------- products */

/* What a sum of `count` products of which the sizes add up to 1 is off by. */
static double rounding(slong count)
{
    return (double)(count + 4) * 2 * RIC_BALL_UNIT;
}

/* sum += C_l x and bound += |C_l| (|x| unit + r): C_l x is known to that. */
static void add_column(const ric_contraction *k, slong l, ric_ball x, double unit, double *sum,
                       double *bound)
{
    const double *C = k->C + l * k->n, *size = k->size + l * k->n;
    const double more = fabs(x.m) * unit + x.r;
    for (slong i = 0; i < k->n; i++) {
        sum[i] += C[i] * x.m;
        bound[i] += size[i] * more;
    }
}

/* A bound that is itself a sum of fewer than 2^20 terms, rounded. */
static double round_up(double bound)
{
    return bound * (1 + 0x1p-30) + 0x1p-900;
}

void ric_contraction_apply(const ric_contraction *k, arb_srcptr x, arb_ptr out)
{
    const slong n = k->n;
    if (k->wide) {
        for (slong i = 0; i < n; i++)
            arb_dot(out + i, NULL, 0, arb_mat_entry(k->own, i, 0), 1, x, 1, n, k->prec);
        return;
    }
    double *sum = flint_calloc(2 * (size_t)n, sizeof *sum), *bound = sum + n;
    for (slong j = 0; j < n; j++)
        if (!arb_is_zero(x + j)) add_column(k, j, ric_ball_of(x + j), rounding(n), sum, bound);
    for (slong i = 0; i < n; i++) {
        arb_set_d(out + i, sum[i]);
        mag_set_d(arb_radref(out + i), round_up(bound[i]));
    }
    flint_free(sum);
}

/* Rows of a column that are not zero. */
static slong count_rows(const arb_mat_t J, slong j)
{
    slong count = 0;
    for (slong l = 0; l < arb_mat_nrows(J); l++) count += !arb_is_zero(arb_mat_entry(J, l, j));
    return count;
}

/* Z += by |C A - 1|, or without the 1. */
static void add_product(ric_contraction *k, const arb_mat_t A, bool less_one, double by)
{
    const slong n = k->n;
    double *sum = flint_malloc(2 * (size_t)n * sizeof *sum), *bound = sum + n;
    for (slong j = 0; j < n; j++) {
        const slong rows = count_rows(A, j);
        const double unit = rounding(rows);
        if (rows == 0 && !less_one) continue;
        memset(sum, 0, 2 * (size_t)n * sizeof *sum);
        if (less_one) sum[j] = -1;
        if (less_one) bound[j] = unit;
        for (slong l = 0; l < n; l++)
            if (!arb_is_zero(arb_mat_entry(A, l, j)))
                add_column(k, l, ric_ball_of(arb_mat_entry(A, l, j)), unit, sum, bound);
        for (slong i = 0; i < n; i++)
            k->Z[i * n + j] = round_up(k->Z[i * n + j] + by * (fabs(sum[i]) + bound[i]));
    }
    flint_free(sum);
}

/* A column of A has few numbers that are not zero: those are gathered, as they are, without a copy
 * of their own. */
static void add_wide_product(ric_contraction *k, const arb_mat_t A, bool less_one, double by)
{
    const slong n = k->n;
    arb_ptr column = flint_malloc((size_t)n * sizeof *column),
            row = flint_malloc((size_t)n * sizeof *row);
    slong *at = flint_malloc((size_t)n * sizeof *at);
    arb_t x;
    mag_t size;
    arb_init(x);
    mag_init(size);
    for (slong j = 0; j < n; j++) {
        slong count = 0;
        for (slong i = 0; i < n; i++) {
            if (arb_is_zero(arb_mat_entry(A, i, j))) continue;
            column[count] = *arb_mat_entry(A, i, j);
            at[count++] = i;
        }
        for (slong i = 0; i < n && (count > 0 || less_one); i++) {
            for (slong l = 0; l < count; l++) row[l] = *arb_mat_entry(k->own, i, at[l]);
            arb_dot(x, NULL, 0, row, 1, column, 1, count, k->prec);
            if (less_one && i == j) arb_sub_ui(x, x, 1, k->prec);
            arb_get_mag(size, x);
            k->Z[i * n + j] = round_up(k->Z[i * n + j] + by * mag_get_d(size)); /* rounded up */
        }
    }
    mag_clear(size);
    arb_clear(x);
    flint_free(column);
    flint_free(row);
    flint_free(at);
}

static void add(ric_contraction *k, const arb_mat_t A, bool less_one, double by)
{
    if (k->wide) add_wide_product(k, A, less_one, by);
    else add_product(k, A, less_one, by);
}

void ric_contraction_defect(ric_contraction *k, const arb_mat_t J)
{
    memset(k->Z, 0, (size_t)k->n * (size_t)k->n * sizeof *k->Z);
    add(k, J, true, 1);
}

void ric_contraction_add(ric_contraction *k, const arb_mat_t A, double by)
{
    add(k, A, false, by);
}

/* Rows i to i + 3 of Z x, which wait for one another less than the numbers of one row. */
static void map_rows(const ric_contraction *k, const double *size, slong i, double *sum)
{
    const slong n = k->n;
    const double *row = k->Z + i * n;
    for (int r = 0; r < 4; r++) sum[r] = 0;
    if (i + 4 > n) {
        for (slong r = 0; r < n - i; r++)
            for (slong j = 0; j < n; j++) sum[r] += row[r * n + j] * size[j];
        return;
    }
    for (slong j = 0; j < n; j++)
        for (int r = 0; r < 4; r++) sum[r] += row[r * n + j] * size[j];
}

void ric_contraction_map(const ric_contraction *k, mag_srcptr x, mag_ptr out)
{
    const slong n = k->n;
    double *size = flint_malloc((size_t)n * sizeof *size);
    for (slong j = 0; j < n; j++) size[j] = mag_get_d(x + j); /* rounded up */
    for (slong i = 0; i < n; i += 4) {
        double sum[4];
        map_rows(k, size, i, sum);
        for (slong r = 0; r < 4 && i + r < n; r++) mag_set_d(out + i + r, round_up(sum[r]));
    }
    flint_free(size);
}

bool ric_contraction_holds(ric_contraction *k)
{
    mag_ptr next = _mag_vec_init(k->n);
    mag_t eighth;
    mag_init(eighth);
    bool holds = true;
    ric_contraction_map(k, k->b, next);
    for (slong i = 0; i < k->n; i++) {
        mag_add(next + i, next + i, k->y + i);
        holds = holds &&
                mag_cmp(next + i, k->b + i) < 0; /* what is no number is infinite, and not less */
    }
    for (slong i = 0; i < k->n && !holds; i++) {
        if (mag_cmp(next + i, k->b + i) < 0)
            continue; /* large enough; a number that never changes has a next of 0 */
        mag_mul_2exp_si(eighth, next + i, -3);
        mag_add(k->b + i, next + i, eighth);
    }
    _mag_vec_clear(next, k->n);
    mag_clear(eighth);
    return holds;
}

/* sqrt(|x|_1 |x|_inf) of x [n * n] */
static double bound_norm(slong n, const double *x)
{
    double rows = 0, columns = 0;
    for (slong i = 0; i < n; i++) {
        double row = 0, column = 0;
        for (slong j = 0; j < n; j++) {
            row += x[i * n + j];
            column += x[j * n + i];
        }
        if (!(row <= rows)) rows = row;
        if (!(column <= columns)) columns = column;
    }
    return round_up(sqrt(round_up(rows * columns)));
}

double ric_contraction_least(const ric_contraction *k)
{
    const slong n = k->n;
    if (k->wide) return 0;
    const double defect = bound_norm(n, k->Z), size = bound_norm(n, k->size);
    return ric_down(ric_down(1 - defect) / size);
}
