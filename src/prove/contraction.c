#include "contraction.h"

#include <math.h>
#include <string.h>

#include "base/room.h"
#include "lu.h"

enum { ROUNDS = 40 }; /* of radii that are looked for with one Z */

void ric_contraction_create(ric_contraction *k, slong n, slong prec)
{
    *k = (ric_contraction){.n = n, .prec = prec};
    k->C = flint_malloc((size_t)n * (size_t)n * sizeof *k->C);
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

static bool invert_middle(ric_contraction *k, const arb_mat_t J)
{
    ric_lu lu;
    ric_lu_create(&lu, k->n);
    const bool done = ric_lu_make(&lu, J);
    if (done) ric_lu_invert(&lu, k->C);
    ric_lu_free(&lu);
    return done;
}

double ric_contraction_left(const ric_contraction *k)
{
    double most = 0;
    for (slong i = 0; i < k->n; i++) {
        double sum = 0;
        for (slong j = 0; j < k->n; j++) sum += k->Z[j * k->n + i];
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

void ric_contraction_column_open(ric_contraction_column *x, slong n)
{
    *x = (ric_contraction_column){.at = flint_malloc((size_t)n * sizeof *x->at),
                                  .x = flint_malloc((size_t)n * sizeof *x->x)};
}

void ric_contraction_column_close(ric_contraction_column *x)
{
    flint_free(x->at);
    flint_free(x->x);
}

/* A sum of products C x, and what it is off by at most: `unit` of the sizes of all, and what x is
 * not known of. */
typedef struct {
    double *restrict sum, *restrict bound, unit;
} product;

/* What C_l x is off by over |C_l|. */
static double slack_of(const product *p, ric_ball x)
{
    return fabs(x.m) * p->unit + x.r;
}

/* Numbers i to i + 3 of x, which go through the sums at once. */
static void add_four(const ric_contraction *k, const ric_contraction_column *x, slong i,
                     const product *p)
{
    const slong n = k->n, *at = x->at + i;
    const double *a = k->C + at[0] * n, *b = k->C + at[1] * n, *c = k->C + at[2] * n,
                 *d = k->C + at[3] * n;
    double m[4], off[4], *restrict sum = p->sum, *restrict bound = p->bound;
    for (int l = 0; l < 4; l++) {
        m[l] = x->x[i + l].m;
        off[l] = slack_of(p, x->x[i + l]);
    }
    for (slong l = 0; l < n; l++) {
        sum[l] += (a[l] * m[0] + b[l] * m[1]) + (c[l] * m[2] + d[l] * m[3]);
        bound[l] += (fabs(a[l]) * off[0] + fabs(b[l]) * off[1]) +
                    (fabs(c[l]) * off[2] + fabs(d[l]) * off[3]);
    }
}

static void add_terms(const ric_contraction *k, const ric_contraction_column *x, const product *p)
{
    const slong n = k->n;
    double *restrict sum = p->sum, *restrict bound = p->bound;
    slong i = 0;
    for (; i + 4 <= x->count; i += 4) add_four(k, x, i, p);
    for (; i < x->count; i++) {
        const double *C = k->C + x->at[i] * n, m = x->x[i].m, off = slack_of(p, x->x[i]);
        for (slong l = 0; l < n; l++) {
            sum[l] += C[l] * m;
            bound[l] += fabs(C[l]) * off;
        }
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
    ric_contraction_column few;
    ric_contraction_column_open(&few, n);
    for (slong l = 0; l < n; l++)
        if (!arb_is_zero(x + l)) ric_contraction_column_put(&few, l, ric_ball_of(x + l));
    add_terms(k, &few, &(product){sum, bound, rounding(few.count)});
    for (slong i = 0; i < n; i++) {
        arb_set_d(out + i, sum[i]);
        mag_set_d(arb_radref(out + i), round_up(bound[i]));
    }
    ric_contraction_column_close(&few);
    flint_free(sum);
}

/* Column j of Z += by |C x|, or by |C x - 1|; sum [2 * n]: scratch. */
static void add_column(ric_contraction *k, slong j, const ric_contraction_column *x, bool less_one,
                       double by, double *sum)
{
    const slong n = k->n;
    double *bound = sum + n, *Z = k->Z + j * n;
    const double unit = rounding(x->count);
    memset(sum, 0, 2 * (size_t)n * sizeof *sum);
    if (less_one) sum[j] = -1;
    if (less_one) bound[j] = unit;
    add_terms(k, x, &(product){sum, bound, unit});
    for (slong i = 0; i < n; i++) Z[i] = round_up(Z[i] + by * (fabs(sum[i]) + bound[i]));
}

/* A number of C x, as it is; row: scratch, without a copy of its own. */
static void dot_wide(const ric_contraction *k, slong i, const ric_contraction_column *x,
                     arb_srcptr column, arb_ptr row, arb_t out)
{
    for (slong l = 0; l < x->count; l++) row[l] = *arb_mat_entry(k->own, i, x->at[l]);
    arb_dot(out, NULL, 0, row, 1, column, 1, x->count, k->prec);
}

/* The same with C in Arb's numbers, and with those of x, `column`. */
static void add_wide_column(ric_contraction *k, slong j, const ric_contraction_column *x,
                            arb_srcptr column, bool less_one, double by)
{
    const slong n = k->n;
    arb_ptr row = flint_malloc((size_t)n * sizeof *row);
    arb_t y;
    mag_t size;
    arb_init(y);
    mag_init(size);
    for (slong i = 0; i < n; i++) {
        double *Z = k->Z + j * n + i;
        dot_wide(k, i, x, column, row, y);
        if (less_one && i == j) arb_sub_ui(y, y, 1, k->prec);
        arb_get_mag(size, y);
        *Z = round_up(*Z + by * mag_get_d(size)); /* rounded up */
    }
    mag_clear(size);
    arb_clear(y);
    flint_free(row);
}

void ric_contraction_add(ric_contraction *k, slong j, const ric_contraction_column *x, double by)
{
    if (x->count == 0) return;
    if (!k->wide) {
        double *sum = flint_malloc(2 * (size_t)k->n * sizeof *sum);
        add_column(k, j, x, false, by, sum);
        flint_free(sum);
        return;
    }
    arb_ptr column = _arb_vec_init(x->count);
    for (slong i = 0; i < x->count; i++) {
        arb_set_d(column + i, x->x[i].m);
        mag_set_d(arb_radref(column + i), x->x[i].r);
    }
    add_wide_column(k, j, x, column, false, by);
    _arb_vec_clear(column, x->count);
}

void ric_contraction_loosen(ric_contraction *k, slong row, slong rows, const double *weight)
{
    const slong n = k->n;
    double *sum = flint_calloc((size_t)n, sizeof *sum);
    for (slong l = row; l < row + rows; l++)
        for (slong i = 0; i < n; i++)
            sum[i] += k->wide ? ric_ball_most(ric_ball_of(arb_mat_entry(k->own, i, l)))
                              : fabs(k->C[l * n + i]);
    for (slong j = 0; j < n; j++)
        for (slong i = 0; i < n && weight[j] != 0; i++)
            k->Z[j * n + i] = round_up(k->Z[j * n + i] + round_up(sum[i]) * weight[j]);
    flint_free(sum);
}

/* Numbers of J that are not zero, column by column: those of column j from[j] .. from[j + 1] - 1,
 * at rows `at`. Row by row, as they lie in memory. */
typedef struct {
    slong *from, *at;
} entries;

static void entries_open(entries *f, const arb_mat_t J)
{
    const slong n = arb_mat_nrows(J);
    f->from = flint_calloc((size_t)n + 2, sizeof *f->from);
    slong *next = f->from + 1;
    for (slong i = 0; i < n; i++)
        for (slong j = 0; j < n; j++) next[j + 1] += !arb_is_zero(arb_mat_entry(J, i, j));
    for (slong j = 0; j < n; j++) next[j + 1] += next[j];
    f->at = flint_malloc((size_t)(next[n] + 1) * sizeof *f->at);
    for (slong i = 0; i < n; i++)
        for (slong j = 0; j < n; j++)
            if (!arb_is_zero(arb_mat_entry(J, i, j))) f->at[next[j]++] = i;
}

static void entries_close(entries *f)
{
    flint_free(f->from);
    flint_free(f->at);
}

void ric_contraction_defect(ric_contraction *k, const arb_mat_t J)
{
    const slong n = k->n;
    double *sum = flint_malloc(2 * (size_t)n * sizeof *sum);
    arb_ptr column = flint_malloc((size_t)n * sizeof *column); /* without copies of their own */
    entries all;
    ric_contraction_column few;
    entries_open(&all, J);
    ric_contraction_column_open(&few, n);
    memset(k->Z, 0, (size_t)(n * n) * sizeof *k->Z);
    for (slong j = 0; j < n; j++) {
        few.count = 0;
        for (slong l = all.from[j]; l < all.from[j + 1]; l++) {
            arb_srcptr x = arb_mat_entry(J, all.at[l], j);
            column[few.count] = *x;
            ric_contraction_column_put(&few, all.at[l],
                                       k->wide ? (ric_ball){0, 0} : ric_ball_of(x));
        }
        if (k->wide) add_wide_column(k, j, &few, column, true, 1);
        else add_column(k, j, &few, true, 1, sum);
    }
    ric_contraction_column_close(&few);
    entries_close(&all);
    flint_free(column);
    flint_free(sum);
}

void ric_contraction_map(const ric_contraction *k, mag_srcptr x, mag_ptr out)
{
    const slong n = k->n;
    double *sum = flint_calloc((size_t)n, sizeof *sum);
    for (slong j = 0; j < n; j++) {
        const double size = mag_get_d(x + j), *Z = k->Z + j * n; /* rounded up */
        for (slong i = 0; i < n; i++) sum[i] += Z[i] * size;
    }
    for (slong i = 0; i < n; i++) mag_set_d(out + i, round_up(sum[i]));
    flint_free(sum);
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

bool ric_contraction_may_hold(ric_contraction *k)
{
    bool holds = false;
    for (int round = 0; round <= ROUNDS && !holds; round++) holds = ric_contraction_holds(k);
    return holds;
}

double ric_contraction_root(slong n, const double *W)
{
    enum { STEPS = 12 };
    double *x = flint_malloc(2 * (size_t)n * sizeof *x), *y = x + n, most = 0;
    for (slong i = 0; i < n; i++) x[i] = 1;
    for (int step = 0; step < STEPS; step++) {
        memset(y, 0, (size_t)n * sizeof *y);
        for (slong j = 0; j < n; j++)
            for (slong i = 0; i < n; i++) y[i] += W[j * n + i] * x[j];
        most = 0;
        for (slong i = 0; i < n; i++) most = fmax(most, y[i]);
        for (slong i = 0; i < n; i++) x[i] = most > 0 ? y[i] / most : 0;
    }
    flint_free(x);
    return most;
}

/* sqrt(|x|_1 |x|_inf) of x [n * n] */
static double bound_norm(slong n, const double *x)
{
    double rows = 0, columns = 0;
    for (slong i = 0; i < n; i++) {
        double row = 0, column = 0;
        for (slong j = 0; j < n; j++) {
            row += fabs(x[i * n + j]);
            column += fabs(x[j * n + i]);
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
    const double defect = bound_norm(n, k->Z), size = bound_norm(n, k->C);
    return ric_down(ric_down(1 - defect) / size);
}
