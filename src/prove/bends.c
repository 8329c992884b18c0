#include "bends.h"

#include <math.h>
#include <string.h>

#include "base/room.h"

static int count_rows(const ric_chain *c, int k)
{
    return k < c->m - 1 || ric_chain_general(c) ? 2 * c->n : c->n;
}

/* Rows and columns of flight k; those of the beginning come before those of the end. */
static ric_bend lay_out(const ric_chain *c, int k)
{
    const int before = k < c->m - 1 ? 0 : ric_chain_general(c) ? 1 : c->n;
    return (ric_bend){.row = (slong)k * c->size + before,
                      .rows = count_rows(c, k),
                      .first = (slong)k * c->size,
                      .columns = ric_chain_width(c, k)};
}

static void take_end(ric_bends *b)
{
    const ric_chain *c = b->c;
    const ric_enclosure *e = b->e;
    const int n = c->n;
    if (ric_chain_general(c)) {
        const int contact = e->wall[c->face[c->m]].contact;
        for (int i = 0; i < n; i++) {
            b->normal[i] = ric_ball_of(arb_mat_entry(e->C, contact, i));
            b->normal[n + i] = ric_ball_of(arb_mat_entry(e->turn, contact, i));
        }
        return;
    }
    arb_mat_t B;
    arb_t gap;
    arb_init(gap);
    arb_mat_init(B, n, 2 * n);
    ric_equation_mirror(e, c, true, B, gap);
    for (int i = 0; i < 2 * n * n; i++)
        b->B[i] = ric_ball_of(arb_mat_entry(B, i / (2 * n), i % (2 * n)));
    arb_mat_clear(B);
    arb_clear(gap);
}

void ric_bends_open(ric_bends *b, const ric_chain *c, const ric_enclosure *e)
{
    const int n = c->n, wide = 2 * n + 1, block = 2 * n * wide;
    *b = (ric_bends){.c = c, .e = e, .flights = ric_equation_flights(c, e)};
    b->D = flint_calloc((size_t)(c->m * block), sizeof *b->D);
    b->B = flint_calloc((size_t)(2 * n * n + 2 * n), sizeof *b->B);
    b->normal = b->B + 2 * n * n;
    b->at = flint_calloc((size_t)c->m, sizeof *b->at);
    b->rows = (slong)c->m * c->size + ric_chain_general(c) - 1;
    for (int k = 0; k < c->m; k++) {
        for (int i = 0; i < block; i++)
            b->D[k * block + i] = ric_ball_of(arb_mat_entry(b->flights[k], i / wide, i % wide));
        b->at[k] = lay_out(c, k);
        b->at[k].A = flint_calloc((size_t)(b->at[k].rows * b->at[k].columns), sizeof *b->at[k].A);
    }
    take_end(b);
}

void ric_bends_close(ric_bends *b)
{
    ric_equation_flights_free(b->c, b->flights);
    for (int k = 0; k < b->c->m; k++) flint_free(b->at[k].A);
    flint_free(b->at);
    flint_free(b->D);
    flint_free(b->B);
}

static ric_ball negative(ric_ball x)
{
    return (ric_ball){-x.m, x.r};
}

static ric_ball add_product(ric_ball sum, ric_ball x, ric_ball y)
{
    return ric_ball_add(sum, ric_ball_mul(x, y));
}

/* S of a flight without springs, as ric_equation_bend has it: theta F' of each mode, and F' v +
 * theta F'' w, where F' is (F of p; -L F of q), and F'' is -L F. w, v [2n + 1]: the flight and the
 * direction. */
static void bend_modes(const ric_bends *b, const ric_ball *D, const ric_ball *w, const ric_ball *v,
                       ric_ball *S)
{
    const int n = b->c->n, wide = 2 * n + 1;
    for (int i = 0; i < n; i++) {
        const ric_ball square = ric_ball_of(b->e->square + i), theta = v[2 * n];
        const ric_ball *rows[] = {D + i * wide, D + (n + i) * wide};
        for (int half = 0; half < 2; half++) {
            ric_ball *to = S + (half * n + i) * wide, q = rows[1 - half][i],
                     p = rows[1 - half][n + i];
            if (half) q = negative(ric_ball_mul(square, q));
            if (half) p = negative(ric_ball_mul(square, p));
            const ric_ball flown = add_product(ric_ball_mul(rows[half][i], w[i]), rows[half][n + i],
                                               w[n + i]);
            to[i] = ric_ball_mul(q, theta);
            to[n + i] = ric_ball_mul(p, theta);
            to[2 * n] = add_product(ric_ball_mul(q, v[i]), p, v[n + i]);
            to[2 * n] = ric_ball_sub(to[2 * n], ric_ball_mul(ric_ball_mul(square, flown), theta));
        }
    }
}

static void bend_phase(const ric_bends *b, int k, arb_srcptr along, ric_ball *S)
{
    const ric_chain *c = b->c;
    const int n = c->n, wide = 2 * n + 1;
    arb_srcptr w = ric_chain_block(c, k);
    arb_mat_t second;
    arb_mat_init(second, 2 * n, wide);
    ric_equation_bend(&(ric_equation_span){b->e, c->phase[k], w, w + 2 * n}, b->flights[k], along,
                      second);
    for (int i = 0; i < 2 * n * wide; i++)
        S[i] = ric_ball_of(arb_mat_entry(second, i / wide, i % wide));
    arb_mat_clear(second);
}

/* p <- Q p of each column, where the chain ends. */
static void reflect(const ric_bends *b, ric_bend *to)
{
    const int n = b->c->n, columns = (int)to->columns;
    if (b->e->wall[b->c->face[b->c->m]].closes) return;
    for (int j = 0; j < columns; j++) {
        ric_ball *p = to->A + n * columns + j, sum = {0, 0};
        for (int i = 0; i < n; i++) sum = add_product(sum, b->normal[i], p[i * columns]);
        for (int i = 0; i < n; i++)
            p[i * columns] = ric_ball_sub(p[i * columns], ric_ball_mul(sum, b->normal[n + i]));
    }
}

/* Of -sigma (1 + lambda) Q F w: by (w, tau) also lambda's part of the direction times D, by lambda
 * D along. */
static void put_closure(const ric_bends *b, const ric_ball *D, const ric_ball *S, const ric_ball *v,
                        ric_bend *to)
{
    const int n = b->c->n, wide = 2 * n + 1;
    const ric_ball factor = ric_ball_add(ric_ball_of(b->c->u + (slong)b->c->m * b->c->size),
                                         ric_ball_exact(1));
    for (int i = 0; i < 2 * n; i++) {
        ric_ball *row = to->A + i * to->columns, sum = {0, 0};
        for (int j = 0; j < wide; j++) {
            row[j] = ric_ball_mul(S[i * wide + j], factor);
            row[j] = add_product(row[j], D[i * wide + j], v[wide]);
            sum = add_product(sum, D[i * wide + j], v[j]);
        }
        row[wide] = sum;
    }
    reflect(b, to);
    for (slong i = 0; i < to->rows * to->columns && b->c->sign > 0; i++)
        to->A[i] = negative(to->A[i]);
}

static bool is_nothing(ric_ball x)
{
    return x.m == 0 && x.r == 0;
}

/* B S */
static void put_mirror(const ric_bends *b, const ric_ball *S, ric_bend *to)
{
    const int n = b->c->n, wide = 2 * n + 1;
    memset(to->A, 0, (size_t)(to->rows * to->columns) * sizeof *to->A);
    for (int i = 0; i < n; i++)
        for (int l = 0; l < 2 * n; l++) {
            const ric_ball x = b->B[2 * n * i + l];
            for (int j = 0; j < wide && !is_nothing(x); j++)
                if (!is_nothing(S[l * wide + j]))
                    to->A[i * wide + j] = add_product(to->A[i * wide + j], x, S[l * wide + j]);
        }
}

/* along: [size + 1] of the last block, with lambda's part. */
static void take_flight(ric_bends *b, int k, arb_srcptr along)
{
    const ric_chain *c = b->c;
    const int n = c->n, wide = 2 * n + 1, block = 2 * n * wide, count = (int)ric_chain_width(c, k);
    const ric_ball *D = b->D + k * block;
    ric_ball *S = flint_calloc((size_t)(block + wide + count), sizeof *S), *w = S + block,
             *v = w + wide;
    for (int i = 0; i < wide; i++) w[i] = ric_ball_of(ric_chain_block(c, k) + i);
    for (int i = 0; i < count; i++) v[i] = ric_ball_of(along + i);
    if (c->phase[k]) bend_phase(b, k, along, S);
    else bend_modes(b, D, w, v, S);
    if (k == c->m - 1 && ric_chain_general(c)) put_closure(b, D, S, v, &b->at[k]);
    else if (k == c->m - 1) put_mirror(b, S, &b->at[k]);
    else
        for (int i = 0; i < block; i++) b->at[k].A[i] = negative(S[i]);
    flint_free(S);
}

void ric_bends_take(ric_bends *b, arb_srcptr along)
{
    arb_ptr slack = _arb_vec_init(b->c->m);
    ric_equation_slack(b->c, b->e, along, slack);
    for (int k = 0; k < b->c->m; k++) {
        take_flight(b, k, along + (slong)k * b->c->size);
        b->at[k].slack = ric_ball_most(ric_ball_of(slack + k));
    }
    _arb_vec_clear(slack, b->c->m);
}

void ric_bends_apply(const ric_bends *b, arb_srcptr x, arb_ptr out)
{
    _arb_vec_zero(out, b->rows + 1);
    for (int k = 0; k < b->c->m; k++) {
        const ric_bend *at = &b->at[k];
        double size = 0;
        for (slong j = 0; j < at->columns; j++)
            size = ric_up(size + ric_ball_most(ric_ball_of(x + at->first + j)));
        for (slong l = 0; l < at->rows; l++) {
            ric_ball sum = {0, ric_up(size * at->slack)};
            for (slong j = 0; j < at->columns; j++)
                sum = add_product(sum, at->A[l * at->columns + j], ric_ball_of(x + at->first + j));
            arb_set_d(out + at->row + l, sum.m);
            mag_set_d(arb_radref(out + at->row + l), sum.r);
        }
    }
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

static void add_columns(adding *a, const ric_bend *at)
{
    for (slong j = 0; j < at->columns; j++) {
        if (in_basis(a->s, at->first + j)) continue;
        a->one.count = 0;
        for (slong l = 0; l < at->rows; l++) {
            const ric_ball x = at->A[l * at->columns + j];
            if (!is_nothing(x)) ric_contraction_column_put(&a->one, at->row + l, x);
        }
        ric_contraction_add(a->k, at->first + j, &a->one, a->by);
    }
}

static void add_flight(adding *a, const ric_bend *at)
{
    const slong columns = at->columns;
    double *m = flint_malloc(2 * (size_t)columns * sizeof *m), *r = m + columns;
    add_columns(a, at);
    for (slong l = 0; l < at->rows; l++) {
        for (slong j = 0; j < columns; j++) {
            m[j] = at->A[l * columns + j].m;
            r[j] = at->A[l * columns + j].r;
        }
        for (int d = 0; d < a->s->count; d++)
            ric_contraction_column_put(&a->turned[d], at->row + l,
                                       ric_ball_dot((int)columns, a->s->r[d] + at->first, m, r));
    }
    flint_free(m);
}

/* Z += by |C S T|, where S is at most the slack in the rows and columns of a flight. */
static void add_slack(const ric_bend *at, const ric_skew *s, double by, ric_contraction *k)
{
    const slong end = at->first + at->columns;
    const double most = ric_up(by * at->slack);
    double *weight = flint_calloc((size_t)k->n, sizeof *weight);
    for (slong j = at->first; j < end; j++) weight[j] = most;
    for (int d = 0; d < s->count; d++) {
        double sum = 0;
        for (slong j = at->first; j < end; j++) sum = ric_up(sum + fabs(s->r[d][j]));
        weight[s->at[d]] = ric_up(sum * most);
    }
    ric_contraction_loosen(k, at->row, at->rows, weight);
    flint_free(weight);
}

void ric_bends_add(const ric_bends *b, const ric_skew *s, double by, ric_contraction *k)
{
    adding a = {.s = s, .by = by, .k = k};
    ric_contraction_column_open(&a.one, k->n);
    for (int d = 0; d < s->count; d++) ric_contraction_column_open(&a.turned[d], k->n);
    for (int i = 0; i < b->c->m; i++) add_flight(&a, &b->at[i]);
    for (int d = 0; d < s->count; d++) {
        ric_contraction_add(k, s->at[d], &a.turned[d], by);
        ric_contraction_column_close(&a.turned[d]);
    }
    ric_contraction_column_close(&a.one);
    for (int i = 0; i < b->c->m; i++) add_slack(&b->at[i], s, by, k);
}

void ric_bends_loosen(const ric_chain *c, const ric_enclosure *e, const ric_skew *s,
                      ric_contraction *k)
{
    arb_ptr slack = _arb_vec_init(c->m);
    ric_equation_slack(c, e, NULL, slack);
    for (int i = 0; i < c->m; i++) {
        ric_bend at = lay_out(c, i);
        at.slack = ric_ball_most(ric_ball_of(slack + i));
        add_slack(&at, s, 1, k);
    }
    _arb_vec_clear(slack, c->m);
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
    memset(W, 0, (size_t)(n * n) * sizeof *W);
    for (int i = 0; i < b->c->m; i++) {
        const ric_bend *at = &b->at[i];
        for (slong j = 0; j < at->columns; j++)
            for (slong l = 0; l < at->rows; l++) {
                const double x = at->A[l * at->columns + j].m;
                if (x != 0) add_row(k, at->row + l, x, W + (at->first + j) * n);
            }
    }
    for (slong j = 0; j < n; j++) ric_skew_turn(s, W + j * n);
    for (slong i = 0; i < n * n; i++) W[i] = fabs(W[i]);
}
