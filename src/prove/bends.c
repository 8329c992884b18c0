#include "bends.h"

#include <math.h>
#include <string.h>

#include "base/room.h"

void ric_bends_open(ric_bends *b, const ric_chain *c, const ric_enclosure *e)
{
    *b = (ric_bends){.c = c, .e = e, .flights = ric_equation_flights(c, e)};
    ric_equation_create(&b->q, c);
}

void ric_bends_close(ric_bends *b)
{
    ric_equation_flights_free(b->c, b->flights);
    ric_equation_free(&b->q);
}

void ric_bends_take(ric_bends *b, arb_srcptr along)
{
    ric_equation_second(&b->q, b->c, b->e, b->flights, along);
    ric_equation_loosen(&b->q, b->c, b->e, along);
}

void ric_bends_apply(const ric_bends *b, arb_srcptr x, arb_ptr out)
{
    slong row = 0;
    for (int i = 0; i < b->q.n - 1; i++) {
        const ric_equation_group *g = &b->q.group[i];
        for (slong l = 0; l < g->rows; l++, row++)
            arb_dot(out + row, NULL, 0, arb_mat_entry(g->J, l, 0), 1,
                    x + (slong)g->first * b->c->size, 1, arb_mat_ncols(g->J), b->e->prec);
    }
    arb_zero(out + row);
}

static bool in_basis(const ric_skew *s, slong j)
{
    bool found = false;
    for (int d = 0; d < s->count; d++) found = found || s->at[d] == j;
    return found;
}

/* What is added to: Z, and the columns of the basis, which all groups have a part in. */
typedef struct {
    const ric_skew *s;
    double by;
    ric_contraction *k;
    ric_contraction_column one, turned[RIC_SKEW_MOST];
} adding;

/* Those of columns from `first` on, A [rows * columns] from row `row` on. */
static void add_columns(adding *a, const ric_equation_group *g, slong row, slong first,
                        const ric_ball *A)
{
    const slong columns = arb_mat_ncols(g->J);
    for (slong j = 0; j < columns; j++) {
        if (in_basis(a->s, first + j)) continue;
        a->one.count = 0;
        for (slong l = 0; l < g->rows; l++) {
            const ric_ball x = A[l * columns + j];
            if (x.m != 0 || x.r != 0) ric_contraction_column_put(&a->one, row + l, x);
        }
        ric_contraction_add(a->k, first + j, &a->one, a->by);
    }
}

static void add_group(adding *a, const ric_equation_group *g, slong row, slong first)
{
    const slong rows = g->rows, columns = arb_mat_ncols(g->J);
    double *m = flint_malloc(2 * (size_t)columns * sizeof *m), *r = m + columns;
    ric_ball *A = flint_malloc((size_t)(rows * columns) * sizeof *A);
    for (slong i = 0; i < rows * columns; i++)
        A[i] = ric_ball_of(arb_mat_entry(g->J, i / columns, i % columns));
    add_columns(a, g, row, first, A);
    for (slong l = 0; l < rows; l++) {
        for (slong j = 0; j < columns; j++) {
            m[j] = A[l * columns + j].m;
            r[j] = A[l * columns + j].r;
        }
        for (int d = 0; d < a->s->count; d++)
            ric_contraction_column_put(&a->turned[d], row + l,
                                       ric_ball_dot((int)columns, a->s->r[d] + first, m, r));
    }
    flint_free(m);
    flint_free(A);
}

void ric_bends_add(const ric_bends *b, const ric_skew *s, double by, ric_contraction *k)
{
    adding a = {.s = s, .by = by, .k = k};
    ric_contraction_column_open(&a.one, k->n);
    for (int d = 0; d < s->count; d++) ric_contraction_column_open(&a.turned[d], k->n);
    slong row = 0;
    for (int i = 0; i < b->q.n - 1; row += b->q.group[i++].rows)
        add_group(&a, &b->q.group[i], row, (slong)b->q.group[i].first * b->c->size);
    for (int d = 0; d < s->count; d++) {
        ric_contraction_add(k, s->at[d], &a.turned[d], by);
        ric_contraction_column_close(&a.turned[d]);
    }
    ric_contraction_column_close(&a.one);
}

/* w [n] += C_l x, approximately. */
static void add_row(const ric_contraction *k, slong l, double x, double *w)
{
    for (slong i = 0; i < k->n; i++)
        w[i] += x * (k->wide ? ric_arb_middle(arb_mat_entry(k->own, i, l)) : k->C[l * k->n + i]);
}

void ric_bends_turn(const ric_bends *b, const ric_skew *s, const ric_contraction *k, double *W)
{
    const slong n = k->n;
    slong row = 0;
    memset(W, 0, (size_t)(n * n) * sizeof *W);
    for (int i = 0; i < b->q.n - 1; row += b->q.group[i++].rows) {
        const ric_equation_group *g = &b->q.group[i];
        for (slong j = 0; j < arb_mat_ncols(g->J); j++)
            for (slong l = 0; l < g->rows; l++) {
                const double x = ric_arb_middle(arb_mat_entry(g->J, l, j));
                if (x != 0) add_row(k, row + l, x, W + ((slong)g->first * b->c->size + j) * n);
            }
    }
    for (slong j = 0; j < n; j++) ric_skew_turn(s, W + j * n);
    for (slong i = 0; i < n * n; i++) W[i] = fabs(W[i]);
}
