#include "multiplicity.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "border.h"
#include "one_period.h"
#include "base/room.h"

#define ROUNDING (2 * DBL_EPSILON) /* of entries of J and of the unknowns, relative */
#define MARGIN 2                   /* of an error that is the largest of a few measured ones */
#define CLEAR                                                                                      \
    30 /* a number above its error by this factor is none of a zero; in between nobody can tell */
/* BEYOND: what one moved reading says counts if it holds with an error larger by this factor. By
 * chance the error is a three-hundredth of that of all readings once in some hundred times, and
 * only then numbers that all of them lose could count */
#define BEYOND 300
#define STEP                                                                                       \
    1e-8 /* of the unknowns, along the branch: the orbit is left by its square, which is rounding  \
          */
/* PLACED: a junction that is known less exactly has no label: what changes with its place is no
 * longer linear */
#define PLACED 1e-6
/* EXACT: a zero that the kind of a junction does not demand is one only if its error is that small:
 * two points farther apart are not taken for one */
#define EXACT 5e-9
enum {
    MOST_B = 4,   /* kernels beyond that are not counted */
    ORDERS = 5,   /* a - b is smaller */
    READINGS = 4, /* with entries moved by rounding, at most */
    FEW = 1,      /* the same at first */
    DET = 0,
    BLOCK = DET + ORDERS,
    SIGMA = BLOCK + MOST_B * MOST_B,
    NUMBERS = SIGMA + 1
};

/* What the kind of a junction lets expect (docs/theory.md section 7). */
static void expected(const ric_node *node, int *a, int *b)
{
    bool half = node->cycle->half, extremum = node->kind == RIC_KIND_EXTREMUM;
    *b = extremum ? 1 : 2;
    /* with one flight its time fraction is fixed */
    *a = half || (extremum && ric_periodic_letters(node->cycle) < 2) ? 3 : 2;
    if (node->kind != RIC_KIND_MULTIPLICATION) return;
    bool doubling = node->multiple == 2 && !half;
    *b = doubling ? 2 : 3;
    *a = doubling && ric_periodic_letters(node->cycle) > 0 ? 2 : 3; /* without impacts the doubled
                                                                     * orbit is one flight, too */
}

/* What is read off J: the singular value behind the b least, and the determinant of the border,
 * order by order. With the zero columns of a kernel of dimension b taken out,
 *
 *     det(J - lambda I) = det B(lambda) det g(lambda),  g = lambda (g_1 + lambda g_2 + ..)
 *
 * where B(lambda) is J - lambda I bordered, regular at 0, and g the block of its inverse at the
 * border (Griewank and Reddien 1984; Govaerts 2000): the order of the zero of det g is a, b of it
 * from the factor lambda. */
typedef struct {
    double at[NUMBERS]; /* DET of g_1 + lambda g_2 + .. order by order, BLOCK: g_0, zero at the
                           junction; SIGMA */
    double off;         /* where the junction is, along the branch */
    double apart;       /* of S from that at the junction, in the Frobenius norm */
} reading;

/* det [ORDERS] of a matrix of series, entry (i, j) of order l at g[l * b * b + i * b + j]:
 * expansion by the first of the rows that are left; b is at most MOST_B. */
static void determinant(int b, const double *g, int row, unsigned columns, double *det)
{
    int sign = 1;
    memset(det, 0, ORDERS * sizeof *det);
    det[0] = row == b;
    for (int j = 0; j < b && row < b; j++) {
        double minor[ORDERS];
        if (!(columns >> j & 1)) continue;
        determinant(b, g, row + 1, columns & ~(1u << j), minor);
        for (int l = 0; l < ORDERS; l++)
            for (int k = 0; k <= l; k++) det[l] += sign * g[(k * b + row) * b + j] * minor[l - k];
        sign = -sign;
    }
}

/* Order by order J x_j + U g_j = x_(j-1), V' x_j = 0, from J x_0 + U g_0 = 0, V' x_0 = I on, as far
 * as the first `orders` of DET need it; the others stay 0. x [2 * rows * MOST_B]. */
static void read_border(ric_border *q, int orders, double *x, reading *out)
{
    const int b = q->b, rows = q->unknowns + 1;
    double g[ORDERS * MOST_B * MOST_B] = {0}, zero[MOST_B * MOST_B] = {0}, unit[MOST_B * MOST_B];
    double *from = x, *to = x + rows * b;
    memset(out, 0, sizeof *out);
    memset(from, 0, (size_t)(rows * b) * sizeof *from);
    for (int i = 0; i < b * b; i++) unit[i] = i % (b + 1) == 0;
    for (int l = -1; l < orders; l++) {
        ric_border_solve(q, b, from, l < 0 ? unit : zero, l + 1 < orders ? to : NULL,
                         l < 0 ? out->at + BLOCK : g + l * b * b);
        double *swap = from;
        from = to;
        to = swap;
    }
    determinant(b, g, 0, (1u << b) - 1, out->at + DET);
    memset(out->at + DET + orders, 0, (size_t)(ORDERS - orders) * sizeof *out->at);
}

/* All that the measure of one junction needs. */
typedef struct {
    const ric_model *model;
    ric_shooting *chain;
    double *u, *at, *x; /* unknowns of the chain, moved ones; workspace */
    ric_border *base, *moved;
    double rounding; /* of the flights */
    int a, b;        /* of the kind, least */
    bool multiplied; /* a multiplication, whose kernel has no more than its kind */
    bool all;        /* all readings and orders, and the singular values of each reading */
} gauge;

/* The least order of the determinant that can be there: a kind has no less than its own, as its
 * place is known by it. */
static int least_order(const gauge *t, int b)
{
    return b == t->b ? t->a - t->b : 0;
}

/* Orders of the determinant that are looked at: the least, unless it vanishes. */
static int orders_of(const gauge *t, int b)
{
    return t->all ? ORDERS : least_order(t, b) + 1;
}

static int readings_of(const gauge *t)
{
    return t->all ? READINGS : FEW;
}

/* The orbit of the junction gone through as often as it is multiplied, in the general form. */
static ric_status unfold(const ric_model *m, const ric_periodic *cycle, int multiple,
                         ric_periodic **out)
{
    int n = m->n;
    ric_periodic *whole = ric_periodic_repeat(cycle, multiple);
    *out = whole;
    if (!whole) return ric_no_memory("the label of a junction");
    memcpy(whole->w, cycle->w, 2 * (size_t)n * sizeof *whole->w);
    whole->closed = cycle->closed;
    whole->parts = 0;
    return RIC_OK;
}

/* Under a power law the rounding of a flight adds up that of its steps, in proportion to the angle
 * turned (shooting.c).
 */
static double rounding_of(const ric_model *m, const ric_periodic *whole)
{
    int n = 2 * m->n;
    double rate[n];
    if (!ric_flight_law_of(m)->integrated) return ROUNDING;
    ric_flight_rate(m, 0, whole->w, rate);
    double turned = sqrt(ric_dot(n, rate, rate) / (1 + ric_dot(n, whole->w, whole->w)));
    return ROUNDING * (1 + ric_periodic_period(whole) * turned);
}

static void gauge_free(gauge *t)
{
    ric_border_free(t->base);
    ric_border_free(t->moved);
    ric_shooting_free(t->chain);
    free(t->u);
    free(t->at);
    free(t->x);
}

static ric_status gauge_make(const ric_model *m, const ric_node *node, gauge *t)
{
    ric_periodic *whole;
    ric_status status = unfold(m, node->cycle, node->multiple, &whole);
    t->model = m;
    if (!status) status = ric_periodic_to_chain(m, whole, &t->chain, &t->u);
    if (!status) {
        t->rounding = rounding_of(m, whole);
        t->chain->plain = true; /* the article's equations, of which the multiplicities are */
        size_t unknowns = (size_t)t->chain->n_unknown;
        t->at = ric_calloc(unknowns, sizeof *t->at);
        t->x = ric_calloc(2 * MOST_B * (unknowns + 1), sizeof *t->x);
        t->base = ric_border_create(t->chain);
        t->moved = ric_border_create(t->chain);
        if (!t->at || !t->x || !t->base || !t->moved)
            status = ric_no_memory("the label of a junction");
    }
    ric_periodic_free(whole);
    return status;
}

/* The singular value behind the b least; 1 where there is none. */
static double value_behind(const ric_border *q, int b)
{
    int m = 2 * q->n;
    return b < m ? q->sigma[m - 1 - b] : 1;
}

/* What J says where the chain was flown last, bordered as at the junction itself. */
static bool read_moved(gauge *t, int b, double rounding, unsigned bits, reading *out)
{
    ric_border *q = t->moved;
    double sum = 0;
    if (!ric_border_factor(q, rounding, bits) || !ric_border_set(q, t->base, b)) return false;
    read_border(q, orders_of(t, b), t->x, out);
    for (int i = 0; i < 4 * q->n * q->n; i++)
        sum += (q->S[i] - t->base->S[i]) * (q->S[i] - t->base->S[i]);
    out->apart = sqrt(sum);
    if (t->all && !ric_border_values(q)) return false;
    if (t->all) out->at[SIGMA] = value_behind(q, b);
    return true;
}

/* The direction of the branch that passes, du [unknowns], within the kernel: what leaves it there
 * keeps energy and period to first order. */
static void along_branch(gauge *t, int b, double *du)
{
    int unknowns = t->chain->n_unknown;
    double energy[MOST_B], period[MOST_B], sum[2] = {0, 0};
    for (int i = 0; i < b; i++) {
        ric_border_kernel(t->base, i, du);
        energy[i] = ric_shooting_energy_slope(t->chain, du) / (t->base->size * t->base->size);
        period[i] = 0;
        for (int k = 2 * t->base->n; k < unknowns; k++) period[i] += du[k] / t->base->T;
        sum[0] += energy[i] * energy[i];
        sum[1] += period[i] * period[i];
    }
    const double *by = sum[0] > sum[1] ? energy : period;
    double norm = sqrt(fmax(sum[0], sum[1])), next[unknowns];
    memset(du, 0, (size_t)unknowns * sizeof *du);
    for (int i = 0; i < b && norm > 0; i++) {
        ric_border_kernel(t->base, i, next);
        for (int k = 0; k < unknowns; k++) du[k] += by[i] / norm * next[k];
    }
}

static bool read_at(gauge *t, int b, double step, const double *du, reading *out)
{
    for (int i = 0; i < t->chain->n_unknown; i++) t->at[i] = t->u[i] + step * du[i];
    ric_shooting_fly(t->chain, t->at);
    return read_moved(t, b, 0, 0, out);
}

/* The derivative of the numbers along the branch; of a few readings only the right side is looked
 * at. */
static bool read_slope(gauge *t, int b, const reading *here, reading *slope)
{
    double du[t->chain->n_unknown];
    reading right, left = *here;
    along_branch(t, b, du);
    if (!read_at(t, b, STEP, du, &right) || (t->all && !read_at(t, b, -STEP, du, &left)))
        return false;
    double step = t->all ? 2 * STEP : STEP;
    for (int i = 0; i < NUMBERS; i++) slope->at[i] = (right.at[i] - left.at[i]) / step;
    slope->apart = right.apart / STEP;
    return true;
}

/* The numbers at the junction, value[0], those with entries moved by rounding, from value[1] on,
 * and their derivative along the branch. */
static bool read_all(gauge *t, int b, reading *value, reading *slope)
{
    int unknowns = t->chain->n_unknown;
    unsigned bits = 1;
    ric_shooting_fly(t->chain, t->u);
    double least = fmax(ROUNDING, t->chain->residual);
    if (!ric_border_factor(t->base, 0, 0) || !ric_border_set(t->base, t->base, b)) return false;
    read_border(t->base, orders_of(t, b), t->x, &value[0]);
    value[0].at[SIGMA] = value_behind(t->base, b);
    if (!read_slope(t, b, &value[0], slope)) return false;
    for (int k = 1; k <= readings_of(t); k++) {
        for (int i = 0; i < unknowns; i++)
            t->at[i] = t->u[i] + ric_moved(&bits, least * fabs(t->u[i]));
        ric_shooting_fly(t->chain, t->at);
        if (!read_moved(t, b, t->rounding, bits, &value[k])) return false;
    }
    return true;
}

/* Whether a number vanishes at every junction of the kind. */
static bool vanishes(const gauge *t, int b, int i)
{
    if (b != t->b) return i >= BLOCK && i < BLOCK + b * b;
    return (i >= DET && i < DET + t->a - t->b) || (i >= BLOCK && i < BLOCK + b * b && b > 1);
}

static double spread(const gauge *t, const reading *value, int i)
{
    double widest = 0;
    for (int k = 1; k <= readings_of(t); k++)
        widest = fmax(widest, fabs(value[k].at[i] - value[0].at[i]));
    return MARGIN * widest;
}

/* The singular value and its error by the distance of the matrices, which no singular value moves
 * by more than (Weyl): without those of the other readings. */
static void bound_value(const gauge *t, reading *value, const reading *slope, reading *error)
{
    double widest = 0;
    for (int k = 1; k <= readings_of(t); k++)
        widest = fmax(widest, value[k].apart + fabs(value[k].off - value[0].off) * slope->apart);
    error->at[SIGMA] = fmax(MARGIN * widest, DBL_EPSILON * value[0].at[SIGMA]);
    value[0].at[SIGMA] = fmax(0, value[0].at[SIGMA] - fabs(value[0].off) * slope->apart);
}

/* Moves all readings along the branch to where the number vanishes that tells the place best: what
 * is then left of their spread is the error of the numbers at the junction. Other numbers that
 * vanish there show whether that is large enough. False: the place is not known. */
static bool settle_place(const gauge *t, int b, reading *value, const reading *slope,
                         reading *error)
{
    int by = -1;
    double best = HUGE_VAL, factor = 1;
    for (int i = 0; i < NUMBERS; i++) {
        if (!vanishes(t, b, i) || slope->at[i] == 0) continue;
        double off = (spread(t, value, i) + fabs(value[0].at[i])) / fabs(slope->at[i]);
        if (!(off < best)) continue;
        best = off;
        by = i;
    }
    if (!(best * (t->all ? 1 : BEYOND) <= PLACED)) return false;
    for (int k = 0; k <= readings_of(t); k++) {
        value[k].off = value[k].at[by] / slope->at[by];
        for (int i = 0; i < SIGMA + t->all; i++) value[k].at[i] -= value[k].off * slope->at[i];
    }
    for (int i = 0; i < NUMBERS; i++) {
        error->at[i] = fmax(spread(t, value, i), DBL_EPSILON * fabs(value[0].at[i]));
        if (vanishes(t, b, i) && i != by && value[0].at[i] != 0)
            factor = fmax(factor, fabs(value[0].at[i]) / error->at[i]);
    }
    if (!t->all) bound_value(t, value, slope, error);
    for (int i = 0; i < NUMBERS; i++) error->at[i] *= factor;
    return true;
}

enum { ZERO, CLEAR_OF_ZERO, LOST };

static int judge(double value, double error)
{
    return fabs(value) <= error ? ZERO : fabs(value) > CLEAR * error ? CLEAR_OF_ZERO : LOST;
}

/* The order of the determinant; -1: lost. */
static int order_of(const gauge *t, int b, const reading *value, const reading *error)
{
    double widest = 0;
    for (int order = least_order(t, b); order < ORDERS; order++) {
        double number = value->at[DET + order], of = error->at[DET + order];
        int is = judge(number, of);
        if (is == CLEAR_OF_ZERO) return widest <= EXACT * fabs(number) ? order : -1;
        if (is == LOST) return -1;
        widest = fmax(widest, of);
    }
    return -1;
}

/* Whether a few readings say beyond doubt that there are b vectors, and the least order of the
 * determinant. */
static bool measure_few(gauge *t, int b)
{
    reading value[FEW + 1], error, slope;
    int order = DET + least_order(t, b);
    t->all = false;
    return read_all(t, b, value, &slope) && settle_place(t, b, value, &slope, &error) &&
           judge(value[0].at[SIGMA], BEYOND * error.at[SIGMA]) == CLEAR_OF_ZERO &&
           judge(value[0].at[order], BEYOND * error.at[order]) == CLEAR_OF_ZERO;
}

/* Both multiplicities; false where one of them is lost in rounding: two different points lie so
 * close together that both seem to be in one place. */
static bool measure(gauge *t, int *a, int *b)
{
    reading value[READINGS + 1], error, slope;
    int states = 2 * t->model->n;
    for (*b = t->b; *b <= MOST_B && *b <= states; (*b)++) {
        *a = *b + least_order(t, *b);
        if (measure_few(t, *b)) return true;
        t->all = true;
        if (!read_all(t, *b, value, &slope) || !settle_place(t, *b, value, &slope, &error))
            return false;
        double next = value[0].at[SIGMA], of = *b < states ? error.at[SIGMA] : 0;
        int is = judge(next, of);
        if (is == LOST || (is == ZERO && (of > EXACT || t->multiplied))) return false;
        if (is == ZERO) continue;
        int order = order_of(t, *b, &value[0], &error);
        *a = *b + order;
        return order >= 0;
    }
    return false;
}

ric_status ric_multiplicity(const ric_model *m, const ric_node *node, int *a, int *b, bool *decided)
{
    gauge t = {.multiplied = node->kind == RIC_KIND_MULTIPLICATION};
    expected(node, &t.a, &t.b);
    ric_status status = ric_one_period_tells(m, node, decided);
    *a = t.a;
    *b = t.b;
    if (status || *decided) return status;
    status = gauge_make(m, node, &t);
    *decided = !status && t.chain->n_unknown == 2 * m->n + t.chain->n_flight && measure(&t, a, b);
    if (!*decided) {
        *a = t.a;
        *b = t.b;
    }
    gauge_free(&t);
    return status;
}
