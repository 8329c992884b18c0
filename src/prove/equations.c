#include "equations.h"

#include "both.h"

#include <math.h>

#include "base/room.h"

/* ------------------------------------------------------------------- memory */

static void open_group(ric_equation_group *g, const ric_chain *c, int rows, int first, int second)
{
    *g = (ric_equation_group){.rows = rows, .first = first, .second = second};
    arb_mat_init(g->J, rows, ric_chain_width(c, first));
    arb_mat_init(g->K, rows, second < 0 ? 0 : ric_chain_width(c, second));
    arb_mat_init(g->F, rows, 1);
}

static void close_group(ric_equation_group *g)
{
    arb_mat_clear(g->J);
    arb_mat_clear(g->K);
    arb_mat_clear(g->F);
}

void ric_equation_create(ric_equations *q, const ric_chain *c)
{
    const bool general = ric_chain_general(c);
    const int n = c->n, m = c->m;
    q->n = m + 2;
    q->group = flint_calloc((size_t)q->n, sizeof *q->group);
    for (int k = 0; k + 1 < m; k++) open_group(&q->group[k], c, c->size, k, k + 1);
    open_group(ric_equation_start(q), c, general ? 1 : n, 0, -1);
    open_group(ric_equation_end(q), c, general ? 2 * n : n, m - 1, general && m > 1 ? 0 : -1);
    open_group(ric_equation_plane(q), c, 1, c->at, -1);
}

void ric_equation_free(ric_equations *q)
{
    for (int k = 0; k < q->n; k++) close_group(&q->group[k]);
    flint_free(q->group);
    q->group = NULL;
    q->n = 0;
}

/* ------------------------------------------------------------------ flights */

void ric_equation_turn(const ric_enclosure *e, slong i, const arb_t tau, arb_t c, arb_t s,
                       arb_t back)
{
    if (arb_is_zero(e->omega + i)) {
        arb_one(c);
        arb_set(s, tau);
        arb_zero(back);
        return;
    }
    arb_mul(s, e->omega + i, tau, e->prec + 32);
    arb_sin_cos(back, c, s, e->prec + 16);
    arb_div(s, back, e->omega + i, e->prec);
    arb_mul(back, back, e->omega + i, e->prec);
    arb_neg(back, back);
}

static void fly_modes(const ric_enclosure *e, arb_srcptr w, const arb_t tau, arb_mat_t out,
                      arb_ptr flown)
{
    slong n = e->n;
    for (slong i = 0; i < n; i++) {
        ric_equation_turn(e, i, tau, arb_mat_entry(out, i, i), arb_mat_entry(out, i, n + i),
                          arb_mat_entry(out, n + i, i));
        arb_set(arb_mat_entry(out, n + i, n + i), arb_mat_entry(out, i, i));
        for (slong half = 0; half < 2; half++) {
            arb_ptr to = flown + half * n + i;
            arb_mul(to, arb_mat_entry(out, half * n + i, i), w + i, e->prec);
            arb_addmul(to, arb_mat_entry(out, half * n + i, n + i), w + n + i, e->prec);
        }
        arb_set(arb_mat_entry(out, i, 2 * n), flown + n + i);
        arb_mul(arb_mat_entry(out, n + i, 2 * n), e->square + i, flown + i, e->prec);
        arb_neg(arb_mat_entry(out, n + i, 2 * n), arb_mat_entry(out, n + i, 2 * n));
    }
}

/* A [2n * 2n + 1] <- V A V', the last column V A, each half of it. */
static void turn_matrix(const ric_phase *phase, arb_mat_t A)
{
    const slong n = phase->e.n;
    arb_ptr v = _arb_vec_init(2 * n), turned = _arb_vec_init(2 * n);
    for (slong j = 0; j <= 2 * n; j++) {
        for (slong i = 0; i < 2 * n; i++) arb_set(v + i, arb_mat_entry(A, i, j));
        ric_phase_turn_back(phase, v, turned);
        for (slong i = 0; i < 2 * n; i++) arb_set(arb_mat_entry(A, i, j), turned + i);
    }
    for (slong i = 0; i < 2 * n; i++) {
        _arb_vec_set(v, arb_mat_entry(A, i, 0), 2 * n);
        ric_phase_turn_back(phase, v, arb_mat_entry(A, i, 0));
    }
    _arb_vec_clear(v, 2 * n);
    _arb_vec_clear(turned, 2 * n);
}

void ric_equation_flight(const ric_enclosure *e, const ric_phase *phase, arb_srcptr w,
                         const arb_t tau, arb_mat_t out, arb_ptr flown)
{
    if (!phase) {
        fly_modes(e, w, tau, out, flown);
        return;
    }
    arb_ptr from = _arb_vec_init(2 * e->n), to = _arb_vec_init(2 * e->n);
    ric_phase_enter(phase, w, from);
    fly_modes(&phase->e, from, tau, out, to);
    ric_phase_leave(phase, to, flown);
    turn_matrix(phase, out);
    _arb_vec_clear(from, 2 * e->n);
    _arb_vec_clear(to, 2 * e->n);
}

/* The reflection on the lower half of every column. */
static void reflect_columns(const ric_enclosure *e, int face, arb_mat_t J)
{
    slong n = e->n, columns = arb_mat_ncols(J);
    if (e->wall[face].closes) return;
    arb_ptr p = _arb_vec_init(n);
    for (slong j = 0; j < columns; j++) {
        for (slong i = 0; i < n; i++) arb_set(p + i, arb_mat_entry(J, n + i, j));
        ric_chain_reflect(e, face, p);
        for (slong i = 0; i < n; i++) arb_set(arb_mat_entry(J, n + i, j), p + i);
    }
    _arb_vec_clear(p, n);
}

/* c.q - d of block k, and as row `row` of J. */
static void value_gap(const ric_enclosure *e, const ric_chain *c, int k, arb_t out)
{
    ric_chain_along(e, c->face[k], ric_chain_block(c, k), out);
    arb_sub(out, out, e->wall[c->face[k]].gap, e->prec);
}
static void put_gap(const ric_enclosure *e, const ric_chain *c, int k, slong row, arb_mat_t J)
{
    arb_srcptr normal = ric_enclosure_c(e, e->wall[c->face[k]].contact);
    for (slong i = 0; i < c->n; i++) arb_set(arb_mat_entry(J, row, i), normal + i);
}

/* Adds Q - 1 of velocities. */
static void put_impact(const ric_enclosure *e, int face, arb_mat_t K)
{
    const slong n = e->n;
    if (e->wall[face].closes) return;
    arb_srcptr c = ric_enclosure_c(e, e->wall[face].contact),
               turn = arb_mat_entry(e->turn, e->wall[face].contact, 0);
    for (slong i = 0; i < n; i++)
        for (slong j = 0; j < n; j++)
            arb_submul(arb_mat_entry(K, n + i, n + j), turn + i, c + j, e->prec);
}

static void put_unit(arb_mat_t J, slong n)
{
    for (slong i = 0; i < n; i++)
        arb_add_ui(arb_mat_entry(J, i, i), arb_mat_entry(J, i, i), 1, ARF_PREC_EXACT);
}

/* Q w_k+1 - F(tau_k) w_k and the gap: F. */
static void value_link(const ric_enclosure *e, const ric_chain *c, int k, arb_srcptr flown,
                       ric_equation_group *g)
{
    arb_ptr before = _arb_vec_init(2 * c->n);
    _arb_vec_set(before, ric_chain_block(c, k + 1), 2 * c->n);
    ric_chain_reflect(e, c->face[k + 1], before + c->n);
    for (slong i = 0; i < 2 * c->n; i++)
        arb_sub(arb_mat_entry(g->F, i, 0), before + i, flown + i, e->prec);
    value_gap(e, c, k + 1, arb_mat_entry(g->F, 2 * c->n, 0));
    _arb_vec_clear(before, 2 * c->n);
}

/* F and its derivatives. */
static void put_link(const ric_enclosure *e, const ric_chain *c, int k, ric_equation_group *g)
{
    slong n = c->n;
    arb_ptr block = ric_chain_block(c, k), flown = _arb_vec_init(2 * n);
    arb_mat_t D;
    arb_mat_init(D, 2 * n, 2 * n + 1);
    ric_equation_flight(e, c->phase[k], block, block + 2 * n, D, flown);
    arb_mat_zero(g->K);
    put_unit(g->K, 2 * n);
    put_impact(e, c->face[k + 1], g->K);
    put_gap(e, c, k + 1, 2 * n, g->K);
    for (slong i = 0; i < 2 * n; i++)
        for (slong j = 0; j <= 2 * n; j++)
            arb_neg(arb_mat_entry(g->J, i, j), arb_mat_entry(D, i, j));
    value_link(e, c, k, flown, g);
    arb_mat_clear(D);
    _arb_vec_clear(flown, 2 * n);
}

/* ------------------------------------------------------------- mirror points */

/* The component of a normal that tangential velocities are measured by: the largest. */
static int pivot(const ric_enclosure *e, int face)
{
    int largest = 0;
    double most = -1;
    for (int i = 0; i < e->n; i++) {
        double size = fabs(
            arf_get_d(arb_midref(ric_enclosure_c(e, e->wall[face].contact) + i), ARF_RND_NEAR));
        if (size > most) {
            most = size;
            largest = i;
        }
    }
    return largest;
}

/* x = S x and v = -S v, each coordinate that goes to another one with that. */
static void twin_rows(const ric_enclosure *e, const ric_twin *twin, arb_mat_t B)
{
    slong n = e->n, row = 0;
    for (slong i = 0; i < n; i++) {
        const int j = twin->to[i];
        for (slong part = 0; part < 2 && j >= i; part++) {
            const int sign = part ? -twin->sign[i] : twin->sign[i];
            if (j == i && sign > 0) continue;
            arb_ptr to = arb_mat_entry(B, row++, part * n);
            _arb_vec_set(to, arb_mat_entry(e->X, i, 0), n);
            if (j > i && sign > 0) _arb_vec_sub(to, to, arb_mat_entry(e->X, j, 0), n, e->prec);
            else if (j > i) _arb_vec_add(to, to, arb_mat_entry(e->X, j, 0), n, e->prec);
        }
    }
}

void ric_equation_mirror(const ric_enclosure *e, const ric_chain *chain, bool last, arb_mat_t B,
                         arb_t gap)
{
    const ric_chain_end kind = last ? chain->end : chain->start;
    const int face = chain->face[last ? chain->m : 0];
    slong n = e->n, row = 1;
    arb_mat_zero(B);
    arb_zero(gap);
    if (kind == RIC_CHAIN_TWIN) {
        twin_rows(e, chain->twin, B);
        return;
    }
    if (kind == RIC_CHAIN_BOTH) {
        ric_both_mirror(e, chain, B, gap);
        return;
    }
    if (kind != RIC_CHAIN_IMPACT) {
        for (slong i = 0; i < n; i++)
            arb_one(arb_mat_entry(B, i, kind == RIC_CHAIN_REST ? n + i : i));
        return;
    }
    arb_srcptr c = ric_enclosure_c(e, e->wall[face].contact);
    slong j = pivot(e, face);
    for (slong i = 0; i < n; i++) arb_set(arb_mat_entry(B, 0, i), c + i);
    arb_set(gap, e->wall[face].gap);
    for (slong i = 0; i < n; i++) {
        if (i == j) continue;
        arb_set(arb_mat_entry(B, row, n + i), c + j);
        arb_neg(arb_mat_entry(B, row, n + j), c + i);
        row++;
    }
}

/* B w - gap. */
static void value_mirror(const ric_enclosure *e, const arb_mat_t B, const arb_t gap, arb_srcptr w,
                         ric_equation_group *g)
{
    for (slong i = 0; i < g->rows; i++)
        arb_dot(arb_mat_entry(g->F, i, 0), NULL, 0, arb_mat_entry(B, i, 0), 1, w, 1, 2 * e->n,
                e->prec);
    arb_sub(arb_mat_entry(g->F, 0, 0), arb_mat_entry(g->F, 0, 0), gap, e->prec);
}

static void put_start(const ric_enclosure *e, const ric_chain *c, ric_equation_group *g)
{
    arb_mat_zero(g->J);
    if (ric_chain_general(c)) {
        value_gap(e, c, 0, arb_mat_entry(g->F, 0, 0));
        put_gap(e, c, 0, 0, g->J);
        return;
    }
    arb_mat_t B;
    arb_t gap;
    arb_init(gap);
    arb_mat_init(B, c->n, 2 * c->n);
    ric_equation_mirror(e, c, false, B, gap);
    for (slong i = 0; i < c->n; i++)
        _arb_vec_set(arb_mat_entry(g->J, i, 0), arb_mat_entry(B, i, 0), 2 * c->n);
    value_mirror(e, B, gap, ric_chain_block(c, 0), g);
    arb_mat_clear(B);
    arb_clear(gap);
}

/* sigma (1 + lambda) */
static void closing_factor(const ric_enclosure *e, const ric_chain *c, arb_t out)
{
    arb_add_ui(out, c->u + (slong)c->m * c->size, 1, e->prec);
    if (c->sign < 0) arb_neg(out, out);
}

/* Of w_0 - sigma (1 + lambda) Q F(tau) w of the last block: F; `flown` becomes Q F(tau) w. */
static void value_closure(const ric_enclosure *e, const ric_chain *c, arb_ptr flown,
                          ric_equation_group *g)
{
    arb_srcptr start = ric_chain_block(c, 0);
    arb_t factor;
    arb_init(factor);
    closing_factor(e, c, factor);
    ric_chain_reflect(e, c->face[c->m], flown + c->n);
    for (slong i = 0; i < 2 * c->n; i++) {
        arb_ptr F = arb_mat_entry(g->F, i, 0);
        arb_mul(F, factor, flown + i, e->prec);
        arb_sub(F, start + i, F, e->prec);
    }
    arb_clear(factor);
}

static void put_closure(const ric_enclosure *e, const ric_chain *c, arb_mat_t D, arb_ptr flown,
                        ric_equation_group *g)
{
    slong n = c->n;
    arb_t factor;
    arb_init(factor);
    closing_factor(e, c, factor);
    reflect_columns(e, c->face[c->m], D);
    arb_mat_scalar_mul_arb(D, D, factor, e->prec);
    value_closure(e, c, flown, g);
    for (slong i = 0; i < 2 * n; i++) {
        for (slong j = 0; j <= 2 * n; j++)
            arb_neg(arb_mat_entry(g->J, i, j), arb_mat_entry(D, i, j));
        if (c->sign > 0) arb_neg(arb_mat_entry(g->J, i, 2 * n + 1), flown + i);
        else arb_set(arb_mat_entry(g->J, i, 2 * n + 1), flown + i);
    }
    if (g->second < 0) put_unit(g->J, 2 * n);
    else {
        arb_mat_zero(g->K);
        put_unit(g->K, 2 * n);
    }
    arb_clear(factor);
}

static void put_end(const ric_enclosure *e, const ric_chain *c, ric_equation_group *g)
{
    slong n = c->n;
    arb_ptr block = ric_chain_block(c, c->m - 1), flown = _arb_vec_init(2 * n);
    arb_mat_t D, B;
    arb_t gap;
    arb_init(gap);
    arb_mat_init(D, 2 * n, 2 * n + 1);
    arb_mat_init(B, n, 2 * n);
    ric_equation_flight(e, c->phase[c->m - 1], block, block + 2 * n, D, flown);
    if (ric_chain_general(c)) put_closure(e, c, D, flown, g);
    else {
        ric_equation_mirror(e, c, true, B, gap);
        arb_mat_mul(g->J, B, D, e->prec);
        value_mirror(e, B, gap, flown, g);
    }
    arb_mat_clear(D);
    arb_mat_clear(B);
    arb_clear(gap);
    _arb_vec_clear(flown, 2 * n);
}

static void value_end(const ric_enclosure *e, const ric_chain *c, ric_equation_group *g)
{
    arb_srcptr block = ric_chain_block(c, c->m - 1);
    arb_ptr flown = _arb_vec_init(2 * c->n);
    arb_mat_t B;
    arb_t gap;
    arb_init(gap);
    arb_mat_init(B, c->n, 2 * c->n);
    ric_chain_fly(e, c->phase[c->m - 1], block, block + 2 * c->n, flown);
    if (ric_chain_general(c)) value_closure(e, c, flown, g);
    else {
        ric_equation_mirror(e, c, true, B, gap);
        value_mirror(e, B, gap, flown, g);
    }
    arb_mat_clear(B);
    arb_clear(gap);
    _arb_vec_clear(flown, 2 * c->n);
}

/* A first plane that holds no number yet goes through the centre. */
static void put_plane(const ric_enclosure *e, const ric_chain *c, ric_equation_group *g)
{
    arb_t held;
    arb_mat_zero(g->J);
    arb_mat_zero(g->F);
    _arb_vec_set(arb_mat_entry(g->J, 0, 0), c->row, c->size);
    if (c->number < 0) return;
    arb_init(held);
    ric_chain_held(c, e->prec, held);
    arb_mul_2exp_si(held, held, -c->scale);
    arb_ptr F = arb_mat_entry(g->F, 0, 0);
    arb_dot(F, NULL, 0, c->row, 1, ric_chain_block(c, c->at), 1, c->size, e->prec);
    arb_sub(F, F, held, e->prec);
    arb_clear(held);
}

void ric_equation_evaluate(ric_equations *q, const ric_chain *c, const ric_enclosure *e)
{
    for (int k = 0; k + 1 < c->m; k++) put_link(e, c, k, &q->group[k]);
    put_start(e, c, ric_equation_start(q));
    put_end(e, c, ric_equation_end(q));
    put_plane(e, c, ric_equation_plane(q));
}

void ric_equation_values(ric_equations *q, const ric_chain *c, const ric_enclosure *e)
{
    arb_ptr flown = _arb_vec_init(2 * c->n);
    for (int k = 0; k + 1 < c->m; k++) {
        arb_srcptr block = ric_chain_block(c, k);
        ric_chain_fly(e, c->phase[k], block, block + 2 * c->n, flown);
        value_link(e, c, k, flown, &q->group[k]);
    }
    put_start(e, c, ric_equation_start(q));
    value_end(e, c, ric_equation_end(q));
    put_plane(e, c, ric_equation_plane(q));
    _arb_vec_clear(flown, 2 * c->n);
}

void ric_equation_move_plane(ric_equations *q, const ric_chain *c, const ric_enclosure *e)
{
    close_group(ric_equation_plane(q));
    open_group(ric_equation_plane(q), c, 1, c->at, -1);
    put_plane(e, c, ric_equation_plane(q));
}

/* -------------------------------------------------------------------- slack */

/* What a row of the group makes of an error of the flown state, at most: impacts turn it, mirror
 * rows are as long as a normal, or as two rows of the modes. */
static void bound_turned(const ric_chain *c, const ric_enclosure *e, bool inner, arb_t out)
{
    arb_one(out);
    if (inner) return;
    if (ric_chain_general(c)) {
        arb_abs(out, c->u + (slong)c->m * c->size);
        arb_add_ui(out, out, 2, e->prec);
    } else if (c->end == RIC_CHAIN_IMPACT)
        arb_add(out, out, e->cc + e->wall[c->face[c->m]].contact, e->prec);
    else if (c->end == RIC_CHAIN_TWIN) arb_addmul_ui(out, e->spread, 2, e->prec);
}

static void loosen_rows(ric_equation_group *g, slong rows, const arb_t error)
{
    for (slong i = 0; i < rows; i++) {
        arb_add_error(arb_mat_entry(g->F, i, 0), error);
        for (slong j = 0; j < arb_mat_ncols(g->J); j++)
            arb_add_error(arb_mat_entry(g->J, i, j), error);
    }
}

/* slack (1 + |w|) bounds what is left of F(tau) w and its derivatives by w, tau and the factor
 * behind it; times 1 + the size of a direction that of second derivatives in it. */
void ric_equation_slack(const ric_chain *c, const ric_enclosure *e, arb_srcptr along, arb_ptr out)
{
    arb_t x, size;
    arb_init(x);
    arb_init(size);
    if (along) ric_chain_norm((slong)c->m * c->size + 1, along, e->prec, size);
    arb_add_ui(size, size, 1, e->prec);
    for (int k = 0; k < c->m; k++) {
        arb_srcptr w = ric_chain_block(c, k);
        ric_chain_slack(e, c->phase[k], w, w + 2 * c->n, out + k);
        bound_turned(c, e, k < c->m - 1, x);
        arb_mul(out + k, out + k, x, e->prec);
        arb_mul(out + k, out + k, size, e->prec);
    }
    arb_clear(x);
    arb_clear(size);
}

void ric_equation_loosen(ric_equations *q, const ric_chain *c, const ric_enclosure *e,
                         arb_srcptr along)
{
    arb_ptr slack = _arb_vec_init(c->m);
    ric_equation_slack(c, e, along, slack);
    for (int k = 0; k < c->m; k++)
        loosen_rows(k < c->m - 1 ? &q->group[k] : ric_equation_end(q),
                    k < c->m - 1 || ric_chain_general(c) ? 2 * c->n : c->n, slack + k);
    _arb_vec_clear(slack, c->m);
}

/* -------------------------------------------------------- second derivatives */

/* Row `row` of F' on modes i and its velocity alone, and times v; x: the same row of F'' w. */
static void bend_row(const ric_enclosure *e, slong row, slong i, const arb_t x, arb_srcptr along,
                     arb_mat_t out)
{
    const slong n = e->n;
    arb_srcptr theta = along + 2 * n;
    arb_ptr q = arb_mat_entry(out, row, i), p = arb_mat_entry(out, row, n + i),
            last = arb_mat_entry(out, row, 2 * n);
    arb_mul(last, q, along + i, e->prec);
    arb_addmul(last, p, along + n + i, e->prec);
    arb_submul(last, x, theta, e->prec);
    arb_mul(q, q, theta, e->prec);
    arb_mul(p, p, theta, e->prec);
}

/* theta F', and F' v + theta F'' w; F' is (F of p; -L F of q), and F'' is -L F. F couples no two
 * modes: all else of `out` is zero. */
static void bend_modes(const ric_enclosure *e, const arb_mat_t D, arb_srcptr w, arb_srcptr along,
                       arb_mat_t out)
{
    const slong n = e->n;
    arb_t x;
    arb_init(x);
    arb_mat_zero(out);
    for (slong i = 0; i < n; i++) {
        for (slong half = 0; half < 2; half++) {
            const slong j = half * n + i;
            arb_set(arb_mat_entry(out, i, j), arb_mat_entry(D, n + i, j));
            arb_mul(arb_mat_entry(out, n + i, j), arb_mat_entry(D, i, j), e->square + i, e->prec);
            arb_neg(arb_mat_entry(out, n + i, j), arb_mat_entry(out, n + i, j));
        }
        for (slong half = 0; half < 2; half++) {
            const slong row = half * n + i;
            arb_mul(x, arb_mat_entry(D, row, i), w + i, e->prec);
            arb_addmul(x, arb_mat_entry(D, row, n + i), w + n + i, e->prec);
            arb_mul(x, x, e->square + i, e->prec);
            bend_row(e, row, i, x, along, out);
        }
    }
    arb_clear(x);
}

void ric_equation_bend(const ric_equation_span *f, const arb_mat_t D, arb_srcptr along,
                       arb_mat_t out)
{
    const slong n = f->e->n;
    const ric_phase *phase = f->phase;
    if (!phase) {
        bend_modes(f->e, D, f->w, along, out);
        return;
    }
    arb_ptr from = _arb_vec_init(2 * n), to = _arb_vec_init(2 * n), v = _arb_vec_init(2 * n + 1);
    arb_mat_t own;
    arb_mat_init(own, 2 * n, 2 * n + 1);
    ric_phase_enter(phase, f->w, from);
    ric_phase_turn(phase, along, v);
    arb_set(v + 2 * n, along + 2 * n);
    fly_modes(&phase->e, from, f->tau, own, to);
    bend_modes(&phase->e, own, from, v, out);
    turn_matrix(phase, out);
    arb_mat_clear(own);
    _arb_vec_clear(from, 2 * n);
    _arb_vec_clear(to, 2 * n);
    _arb_vec_clear(v, 2 * n + 1);
}

/* Of (1 + lambda) Q F w: by (w, tau) also lambda's part of the direction times D, by lambda D
 * along. */
static void second_of_closure(const ric_enclosure *e, const ric_chain *c, const arb_mat_t D,
                              const arb_mat_t second, arb_srcptr along, ric_equation_group *g)
{
    slong n = c->n;
    arb_srcptr v = along + (slong)(c->m - 1) * c->size, lambda = v + c->size;
    arb_t factor;
    arb_init(factor);
    arb_add_ui(factor, c->u + (slong)c->m * c->size, 1, e->prec);
    for (slong i = 0; i < 2 * n; i++) {
        for (slong j = 0; j <= 2 * n; j++) {
            arb_mul(arb_mat_entry(g->J, i, j), arb_mat_entry(second, i, j), factor, e->prec);
            arb_addmul(arb_mat_entry(g->J, i, j), arb_mat_entry(D, i, j), lambda, e->prec);
        }
        arb_dot(arb_mat_entry(g->J, i, 2 * n + 1), NULL, 0, arb_mat_entry(D, i, 0), 1, v, 1,
                2 * n + 1, e->prec);
    }
    reflect_columns(e, c->face[c->m], g->J);
    if (c->sign > 0) arb_mat_neg(g->J, g->J);
    arb_clear(factor);
}

arb_mat_t *ric_equation_flights(const ric_chain *c, const ric_enclosure *e)
{
    const slong n = c->n;
    arb_mat_t *D = flint_malloc((size_t)c->m * sizeof *D);
    arb_ptr flown = _arb_vec_init(2 * n);
    for (int k = 0; k < c->m; k++) {
        arb_srcptr w = ric_chain_block(c, k);
        arb_mat_init(D[k], 2 * n, 2 * n + 1);
        ric_equation_flight(e, c->phase[k], w, w + 2 * n, D[k], flown);
    }
    _arb_vec_clear(flown, 2 * n);
    return D;
}

void ric_equation_flights_free(const ric_chain *c, arb_mat_t *flights)
{
    for (int k = 0; k < c->m; k++) arb_mat_clear(flights[k]);
    flint_free(flights);
}

static void second_of_block(ric_equations *q, const ric_chain *c, const ric_enclosure *e,
                            const arb_mat_t D, arb_srcptr along, int k)
{
    slong n = c->n;
    const bool last = k == c->m - 1;
    ric_equation_group *g = last ? ric_equation_end(q) : &q->group[k];
    arb_ptr w = ric_chain_block(c, k);
    arb_srcptr v = along + (slong)k * c->size;
    arb_mat_t second, B;
    arb_t gap;
    arb_init(gap);
    arb_mat_init(second, 2 * n, 2 * n + 1);
    arb_mat_init(B, n, 2 * n);
    ric_equation_bend(&(ric_equation_span){e, c->phase[k], w, w + 2 * n}, D, v, second);
    if (last && ric_chain_general(c)) second_of_closure(e, c, D, second, along, g);
    else if (last) {
        ric_equation_mirror(e, c, true, B, gap);
        arb_mat_mul(g->J, B, second, e->prec);
    } else {
        for (slong i = 0; i < 2 * n; i++)
            for (slong j = 0; j <= 2 * n; j++)
                arb_neg(arb_mat_entry(g->J, i, j), arb_mat_entry(second, i, j));
    }
    arb_mat_clear(second);
    arb_mat_clear(B);
    arb_clear(gap);
}

void ric_equation_second(ric_equations *q, const ric_chain *c, const ric_enclosure *e,
                         arb_mat_t *flights, arb_srcptr along)
{
    for (int i = 0; i < q->n; i++) {
        arb_mat_zero(q->group[i].J);
        arb_mat_zero(q->group[i].K);
        arb_mat_zero(q->group[i].F);
    }
    for (int k = 0; k < c->m; k++) second_of_block(q, c, e, flights[k], along, k);
}

/* ---------------------------------------------------------------- gathering */

/* Into a matrix that is zero there. */
static void put_block(arb_mat_t to, slong row, slong column, const arb_mat_t block)
{
    for (slong i = 0; i < arb_mat_nrows(block); i++)
        for (slong j = 0; j < arb_mat_ncols(block); j++)
            if (!arb_is_zero(arb_mat_entry(block, i, j)))
                arb_set(arb_mat_entry(to, row + i, column + j), arb_mat_entry(block, i, j));
}

void ric_equation_gather(const ric_equations *q, const ric_chain *c, arb_mat_struct *J, arb_ptr F)
{
    slong row = 0;
    if (J) ric_arb_clean(J);
    for (int i = 0; i < q->n - 1; row += q->group[i++].rows) {
        const ric_equation_group *g = &q->group[i];
        if (J) put_block(J, row, (slong)g->first * c->size, g->J);
        if (J && g->second >= 0) put_block(J, row, (slong)g->second * c->size, g->K);
        for (slong l = 0; l < g->rows && F; l++) arb_set(F + row + l, arb_mat_entry(g->F, l, 0));
    }
}

void ric_equation_apply(const ric_equations *q, const ric_chain *c, arb_srcptr x, slong prec,
                        arb_ptr out)
{
    slong row = 0;
    for (int i = 0; i < q->n - 1; i++) {
        const ric_equation_group *g = &q->group[i];
        for (slong l = 0; l < g->rows; l++, row++) {
            arb_dot(out + row, NULL, 0, arb_mat_entry(g->J, l, 0), 1, x + (slong)g->first * c->size,
                    1, arb_mat_ncols(g->J), prec);
            if (g->second < 0) continue;
            arb_dot(out + row, out + row, 0, arb_mat_entry(g->K, l, 0), 1,
                    x + (slong)g->second * c->size, 1, arb_mat_ncols(g->K), prec);
        }
    }
}
