/* The equations of a junction as a regular zero (augmented.h), row by row. */
#include "augmented_rows.h"

#include "both.h"

typedef struct {
    ric_augmented *x;
    arb_srcptr z;      /* where */
    arb_mat_struct *J; /* [n * n] */
    arb_ptr F;         /* [n] */
    ric_equations q;
    slong row; /* the next one */
} filling;

int ric_augmented_motions(const ric_augmented *x)
{
    return x->ask.kind == RIC_AUGMENTED_TURN ? 2 : x->ask.kind < RIC_AUGMENTED_SPEED;
}

bool ric_augmented_has_factor(const ric_augmented *x)
{
    return x->ask.kind == RIC_AUGMENTED_TURN && ric_chain_general(&x->c);
}

/* ------------------------------------------------------------------ rows */

/* coefficient z_at, and its derivative, in the row. */
static void add_term(filling *f, slong row, slong at, const arb_t coefficient)
{
    arb_addmul(f->F + row, coefficient, f->z + at, f->x->e->prec);
    arb_add(arb_mat_entry(f->J, row, at), arb_mat_entry(f->J, row, at), coefficient, f->x->e->prec);
}

static void add_derivative(filling *f, slong row, slong at, const arb_t value)
{
    arb_add(arb_mat_entry(f->J, row, at), arb_mat_entry(f->J, row, at), value, f->x->e->prec);
}

/* G(u) but for the plane. */
static void put_orbit(filling *f)
{
    const int size = f->x->c.size;
    for (int i = 0; i < f->q.n - 1; i++) {
        const ric_equation_group *g = &f->q.group[i];
        for (slong l = 0; l < g->rows; l++, f->row++) {
            arb_set(f->F + f->row, arb_mat_entry(g->F, l, 0));
            for (slong j = 0; j < arb_mat_ncols(g->J); j++)
                add_derivative(f, f->row, (slong)g->first * size + j, arb_mat_entry(g->J, l, j));
            for (slong j = 0; j < arb_mat_ncols(g->K); j++)
                add_derivative(f, f->row, (slong)g->second * size + j, arb_mat_entry(g->K, l, j));
        }
    }
}

/* The rows of a group on the motion at `from`; with `other` 2 a - those, which close with the other
 * sign. */
static void put_group(filling *f, slong from, const ric_equation_group *g,
                      const ric_equation_group *second, bool other)
{
    const slong size = f->x->c.size, width = f->x->n_motion, first = g->first * size,
                next = g->second * size;
    arb_t x;
    arb_init(x);
    for (slong l = 0; l < g->rows; l++, f->row++) {
        for (slong j = 0; j < arb_mat_ncols(g->J); j++) {
            arb_set(x, arb_mat_entry(g->J, l, j));
            if (other) arb_neg(x, x);
            if (first + j < width) add_term(f, f->row, from + first + j, x);
            arb_set(x, arb_mat_entry(second->J, l, j));
            if (other) arb_neg(x, x);
            add_derivative(f, f->row, first + j, x);
        }
        for (slong j = 0; j < arb_mat_ncols(g->K); j++) {
            arb_set(x, arb_mat_entry(g->K, l, j));
            if (other) arb_neg(x, x);
            if (next + j < width) add_term(f, f->row, from + next + j, x);
        }
        arb_set_ui(x, 2);
        if (other) add_term(f, f->row, from + l, x);
    }
    arb_clear(x);
}

/* --------------------------------------------------------- motions beside it */

/* [m * size + 1] of motion `from`, with no part of lambda where it has none. */
static arb_ptr copy_motion(const filling *f, slong from)
{
    const ric_augmented *x = f->x;
    arb_ptr along = _arb_vec_init((slong)x->c.m * x->c.size + 1);
    _arb_vec_set(along, f->z + from, x->n_motion);
    return along;
}

static void open_second(const filling *f, slong from, ric_equations *second)
{
    const ric_augmented *x = f->x;
    arb_ptr along = copy_motion(f, from);
    arb_mat_t *flights = ric_equation_flights(&x->c, x->e);
    ric_equation_create(second, &x->c);
    ric_equation_second(second, &x->c, x->e, flights, along);
    ric_equation_loosen(second, &x->c, x->e, along);
    ric_equation_flights_free(&x->c, flights);
    _arb_vec_clear(along, (slong)x->c.m * x->c.size + 1);
}

static void put_links(filling *f, slong from, const ric_equations *second)
{
    for (int i = 0; i + 1 < f->x->c.m; i++)
        put_group(f, from, &f->q.group[i], &second->group[i], false);
}

/* E' a at the first block: E' is (K q - sum k d c, p), less the pull; its derivative in the
 * direction of a is that of K a. */
static void put_energy(filling *f, slong from)
{
    const ric_augmented *x = f->x;
    const slong n = x->e->n;
    const ric_phase *phase = x->c.phase[0];
    arb_ptr force = _arb_vec_init(2 * n), change = _arb_vec_init(2 * n);
    ric_chain_pull(x->e, phase, f->z, force);
    _arb_vec_neg(force, force, n);
    _arb_vec_set(force + n, f->z + n, n);
    ric_chain_stiffen(x->e, phase, f->z + from, change);
    _arb_vec_set(change + n, f->z + from + n, n);
    for (slong i = 0; i < 2 * n; i++) {
        add_term(f, f->row, from + i, force + i);
        add_derivative(f, f->row, i, change + i);
    }
    _arb_vec_clear(force, 2 * n);
    _arb_vec_clear(change, 2 * n);
}

/* Of the tangent: all of G', and E' or T'. */
static void put_tangent(filling *f)
{
    const ric_augmented *x = f->x;
    const slong from = x->n_orbit;
    ric_equations second;
    arb_t one;
    open_second(f, from, &second);
    for (int i = 0; i < f->q.n - 1; i++)
        put_group(f, from, &f->q.group[i], &second.group[i], false);
    ric_equation_free(&second);
    arb_init(one);
    arb_one(one);
    if (x->ask.kind == RIC_AUGMENTED_ENERGY) put_energy(f, from);
    for (int k = 0; k < x->c.m && x->ask.kind == RIC_AUGMENTED_PERIOD; k++)
        add_term(f, f->row, from + (slong)k * x->c.size + 2 * x->e->n, one);
    f->row++;
    arb_clear(one);
}

/* What holds at a mirror point for motions that are turned into themselves, n rows, or into their
 * opposite, n + 1: B [rows * 2n] on states. */
static void mirror_rows(const ric_augmented *x, bool last, bool opposite, arb_mat_t B)
{
    const slong n = x->e->n;
    const ric_chain_end kind = last ? x->c.end : x->c.start;
    const int face = x->c.face[last ? x->c.m : 0];
    arb_t gap;
    arb_mat_zero(B);
    if (!opposite) {
        arb_init(gap);
        ric_equation_mirror(x->e, &x->c, last, B, gap);
        arb_clear(gap);
        return;
    }
    for (slong i = 0; i < n; i++)
        arb_one(arb_mat_entry(B, i, kind == RIC_CHAIN_CENTRE ? n + i : i));
    if (kind == RIC_CHAIN_IMPACT) {
        arb_srcptr c = ric_enclosure_c(x->e, x->e->wall[face].contact);
        _arb_vec_set(arb_mat_entry(B, n, n), c, n);
    } else _arb_vec_set(arb_mat_entry(B, n, 0), arb_mat_entry(x->gauge, last, 0), 2 * n);
}

static slong count_rows(const ric_augmented *x, bool opposite)
{
    return x->e->n + opposite;
}

/* (c.p)' (c.p) = (c.p) (c.p)': the motion beside it meets the face earlier by t = c.dq / c.p, and
 * dp is what the force does in that time, c.dp = t c.p'. */
static void put_earlier(filling *f, slong from, int face)
{
    const ric_enclosure *e = f->x->e;
    const slong n = e->n, prec = e->prec;
    const ric_phase *phase = f->x->c.phase[0];
    arb_srcptr c = ric_enclosure_c(e, e->wall[face].contact);
    arb_ptr pull = _arb_vec_init(n);
    arb_t speed, force, dq, dp, y;
    arb_init(speed);
    arb_init(force);
    arb_init(dq);
    arb_init(dp);
    arb_init(y);
    ric_chain_pull(e, phase, f->z, pull);
    arb_dot(speed, NULL, 0, c, 1, f->z + n, 1, n, prec);
    arb_dot(force, NULL, 0, c, 1, pull, 1, n, prec);
    arb_dot(dq, NULL, 0, c, 1, f->z + from, 1, n, prec);
    arb_dot(dp, NULL, 0, c, 1, f->z + from + n, 1, n, prec);
    arb_neg(force, force);
    ric_chain_stiffen(e, phase, c, pull);
    for (slong i = 0; i < n; i++) {
        arb_mul(y, speed, c + i, prec);
        add_term(f, f->row, from + n + i, y);
        arb_mul(y, force, c + i, prec);
        add_term(f, f->row, from + i, y);
        arb_mul(y, dp, c + i, prec);
        add_derivative(f, f->row, n + i, y);
        arb_mul(y, dq, pull + i, prec);
        add_derivative(f, f->row, i, y);
    }
    f->row++;
    arb_clear(speed);
    arb_clear(force);
    arb_clear(dq);
    arb_clear(dp);
    arb_clear(y);
    _arb_vec_clear(pull, n);
}

/* What parts the two impacts that turn a motion round, and is turned into its opposite: before both
 * -dq and dp, so that dq is along what they kick, one part for each instant. A time shift is one,
 * too. */
static void put_parting(filling *f, slong from)
{
    const ric_augmented *x = f->x;
    const slong n = x->e->n;
    arb_mat_t B;
    arb_mat_init(B, n - 1, 2 * n);
    ric_both_across(x->e, &x->c, false, 0, B);
    _arb_vec_set(arb_mat_entry(B, n - 2, 0), arb_mat_entry(x->gauge, 0, 0), 2 * n);
    for (slong l = 0; l < n - 1; l++, f->row++)
        for (slong j = 0; j < 2 * n; j++) add_term(f, f->row, from + j, arb_mat_entry(B, l, j));
    arb_mat_clear(B);
    put_earlier(f, from, x->c.face[0]);
    put_earlier(f, from, x->c.also);
}

static void put_start(filling *f, slong from, bool opposite)
{
    if (opposite && f->x->c.start == RIC_CHAIN_BOTH) {
        put_parting(f, from);
        return;
    }
    const slong n = f->x->e->n, rows = count_rows(f->x, opposite);
    arb_mat_t B;
    arb_mat_init(B, rows, 2 * n);
    mirror_rows(f->x, false, opposite, B);
    for (slong l = 0; l < rows; l++, f->row++)
        for (slong j = 0; j < 2 * n; j++) add_term(f, f->row, from + j, arb_mat_entry(B, l, j));
    arb_mat_clear(B);
}

static void widen(arb_mat_t D, const arb_t by)
{
    for (slong i = 0; i < arb_mat_nrows(D); i++)
        for (slong j = 0; j < arb_mat_ncols(D); j++) arb_add_error(arb_mat_entry(D, i, j), by);
}

void ric_augmented_flight_close(ric_augmented_flight *f)
{
    const slong n = arb_mat_nrows(f->D);
    arb_mat_clear(f->D);
    arb_mat_clear(f->second);
    _arb_vec_clear(f->flown, n);
}

void ric_augmented_flight_open(ric_augmented_flight *f, const ric_enclosure *e,
                               const ric_phase *phase, arb_srcptr w, const arb_t tau,
                               arb_srcptr along)
{
    const slong n = e->n;
    arb_t slack, size;
    arb_init(slack);
    arb_init(size);
    f->flown = _arb_vec_init(2 * n);
    arb_mat_init(f->D, 2 * n, 2 * n + 1);
    arb_mat_init(f->second, 2 * n, 2 * n + 1);
    ric_equation_flight(e, phase, w, tau, f->D, f->flown);
    if (along) ric_equation_bend(&(ric_equation_span){e, phase, w, tau}, f->D, along, f->second);
    ric_chain_slack(e, phase, w, tau, slack);
    widen(f->D, slack);
    for (slong i = 0; i < 2 * n; i++) arb_add_error(f->flown + i, slack);
    if (along) {
        ric_chain_norm(2 * n + 1, along, e->prec, size);
        arb_add_ui(size, size, 1, e->prec);
        arb_mul(slack, slack, size, e->prec);
        widen(f->second, slack);
    }
    arb_clear(slack);
    arb_clear(size);
}

/* Rows B of `factor` times the flown motion, added to those from f->row on. */
static void add_end(filling *f, slong from, const arb_mat_t B, const arb_t factor, int skipped)
{
    const ric_augmented *x = f->x;
    const slong n = x->e->n, last = (slong)(x->c.m - 1) * x->c.size;
    arb_srcptr w = x->c.u + last;
    ric_augmented_flight g;
    arb_mat_t BD, BS;
    arb_mat_init(BD, arb_mat_nrows(B), 2 * n + 1);
    arb_mat_init(BS, arb_mat_nrows(B), 2 * n + 1);
    ric_augmented_flight_open(&g, x->e, x->c.phase[x->c.m - 1], w, w + 2 * n, f->z + from + last);
    arb_mat_mul(BD, B, g.D, x->e->prec);
    arb_mat_mul(BS, B, g.second, x->e->prec);
    arb_mat_scalar_mul_arb(BD, BD, factor, x->e->prec);
    arb_mat_scalar_mul_arb(BS, BS, factor, x->e->prec);
    slong row = f->row;
    for (slong l = 0; l < arb_mat_nrows(B); l++) {
        if (l == skipped) continue;
        for (slong j = 0; j <= 2 * n; j++) {
            add_term(f, row, from + last + j, arb_mat_entry(BD, l, j));
            add_derivative(f, row, last + j, arb_mat_entry(BS, l, j));
        }
        row++;
    }
    arb_mat_clear(BD);
    arb_mat_clear(BS);
    ric_augmented_flight_close(&g);
}

/* The rows at the end of all motions, with their factors. */
static void put_end(filling *f, int motions, arb_srcptr factor, bool opposite, int skipped)
{
    const ric_augmented *x = f->x;
    const slong rows = count_rows(x, opposite);
    arb_mat_t B;
    arb_mat_init(B, rows, 2 * x->e->n);
    mirror_rows(x, true, opposite, B);
    for (int k = 0; k < motions; k++)
        add_end(f, x->n_orbit + k * x->n_motion, B, factor + k, skipped);
    f->row += rows - (skipped >= 0);
    arb_mat_clear(B);
}

static void put_break(filling *f)
{
    const ric_augmented *x = f->x;
    ric_equations second;
    arb_t one;
    arb_init(one);
    arb_one(one);
    open_second(f, x->n_orbit, &second);
    put_links(f, x->n_orbit, &second);
    ric_equation_free(&second);
    put_start(f, x->n_orbit, x->ask.broken[0]);
    put_end(f, 1, one, x->ask.broken[1], x->redundant);
    arb_clear(one);
}

static void put_turn(filling *f)
{
    const ric_augmented *x = f->x;
    arb_ptr factor = _arb_vec_init(3);
    fmpq_t angle;
    for (int k = 0; k < 2; k++) {
        ric_equations second;
        open_second(f, x->n_orbit + k * x->n_motion, &second);
        put_links(f, x->n_orbit + k * x->n_motion, &second);
        ric_equation_free(&second);
        put_start(f, x->n_orbit + k * x->n_motion, k == 1);
    }
    fmpq_init(angle);
    fmpq_set_si(angle, x->ask.p, (ulong)x->ask.q);
    arb_sin_cos_pi_fmpq(factor + 1, factor, angle, x->e->prec);
    put_end(f, 2, factor, false, -1);
    arb_neg(factor + 2, factor + 1);
    arb_swap(factor + 1, factor);
    arb_swap(factor, factor + 2); /* -sin, cos */
    put_end(f, 2, factor, true, -1);
    fmpq_clear(angle);
    _arb_vec_clear(factor, 3);
}

/* Twice a_0 less the rows of the closure is a_0 and what the motion at `from` returns as, which is
 * to be (1 + mu) (factor[0] a_0 + factor[1] b_0). */
static void put_return(filling *f, slong from, const ric_equations *second, arb_srcptr factor)
{
    const ric_augmented *x = f->x;
    const slong row = f->row, prec = x->e->prec;
    arb_t y, grown;
    arb_init(y);
    arb_init(grown);
    put_group(f, from, ric_equation_end(&f->q), ric_equation_end(second), true);
    arb_add_ui(grown, f->z + x->n - 1, 1, prec);
    for (slong l = 0; l < 2 * x->e->n; l++) {
        arb_set_si(y, -1);
        add_term(f, row + l, from + l, y);
        for (int k = 0; k < 2; k++) {
            const slong at = x->n_orbit + k * x->n_motion + l;
            arb_mul(y, factor + k, grown, prec);
            arb_neg(y, y);
            add_term(f, row + l, at, y);
            arb_mul(y, factor + k, f->z + at, prec);
            arb_neg(y, y);
            add_derivative(f, row + l, x->n - 1, y);
        }
    }
    arb_clear(y);
    arb_clear(grown);
}

static void put_general_turn(filling *f)
{
    const ric_augmented *x = f->x;
    arb_ptr factor = _arb_vec_init(2);
    fmpq_t angle;
    fmpq_init(angle);
    fmpq_set_si(angle, 2 * x->ask.p, (ulong)x->ask.q);
    for (int k = 0; k < 2; k++) {
        const slong from = x->n_orbit + k * x->n_motion;
        ric_equations second;
        open_second(f, from, &second);
        put_links(f, from, &second);
        put_group(f, from, ric_equation_start(&f->q), ric_equation_start(&second), false);
        arb_sin_cos_pi_fmpq(factor + 1, factor, angle, x->e->prec);
        if (k == 0) arb_neg(factor + 1, factor + 1);
        else arb_swap(factor, factor + 1);
        put_return(f, from, &second, factor);
        ric_equation_free(&second);
    }
    fmpq_clear(angle);
    _arb_vec_clear(factor, 2);
}

static void put_double(filling *f)
{
    ric_equations second;
    open_second(f, f->x->n_orbit, &second);
    put_links(f, f->x->n_orbit, &second);
    put_group(f, f->x->n_orbit, ric_equation_start(&f->q), ric_equation_start(&second), false);
    put_group(f, f->x->n_orbit, ric_equation_end(&f->q), ric_equation_end(&second), true);
    ric_equation_free(&second);
}

/* ------------------------------------------------------------------ touches */

/* c . q at the end of a flight, or c . p, as the row at work: its derivatives by the 2n unknowns at
 * `at` and by the time at `time`. */
static void put_flown(filling *f, const ric_augmented_flight *g, bool speed, arb_srcptr c, slong at,
                      slong time)
{
    const slong n = f->x->e->n, from = speed ? n : 0, prec = f->x->e->prec;
    arb_t sum;
    arb_init(sum);
    arb_dot(f->F + f->row, NULL, 0, c, 1, g->flown + from, 1, n, prec);
    for (slong j = 0; j <= 2 * n; j++) {
        arb_zero(sum);
        for (slong i = 0; i < n; i++)
            arb_addmul(sum, c + i, arb_mat_entry(g->D, from + i, j), prec);
        add_derivative(f, f->row, j < 2 * n ? at + j : time, sum);
    }
    arb_clear(sum);
}

/* The row at work less the gap of the face that is asked about. */
static void put_clearance(filling *f)
{
    const ric_augmented *x = f->x;
    const ric_wall *wall = &x->e->wall[x->ask.face];
    if (x->ask.image) arb_add(f->F + f->row, f->F + f->row, wall->gap, x->e->prec);
    else arb_sub(f->F + f->row, f->F + f->row, wall->gap, x->e->prec);
}

static void put_speed(filling *f)
{
    const ric_augmented *x = f->x;
    const ric_enclosure *e = x->e;
    const slong n = e->n, last = (slong)(x->c.m - 1) * x->c.size;
    arb_srcptr c = ric_enclosure_c(e, e->wall[x->c.face[x->ask.place]].contact);
    if (x->ask.place < x->c.m) {
        for (slong i = 0; i < n; i++)
            add_term(f, f->row, (slong)x->ask.place * x->c.size + n + i, c + i);
        f->row++;
        return;
    }
    ric_augmented_flight g;
    ric_augmented_flight_open(&g, e, x->c.phase[x->c.m - 1], x->c.u + last, x->c.u + last + 2 * n,
                              NULL);
    put_flown(f, &g, true, c, last, last + 2 * n);
    f->row++;
    ric_augmented_flight_close(&g);
}

static void put_touch(filling *f)
{
    const ric_augmented *x = f->x;
    const ric_enclosure *e = x->e;
    const slong at = (slong)x->ask.place * x->c.size;
    arb_srcptr c = ric_enclosure_c(e, e->wall[x->ask.face].contact);
    ric_augmented_flight g;
    ric_augmented_flight_open(&g, e, x->c.phase[x->ask.place], x->c.u + at, f->z + x->n_orbit,
                              NULL);
    put_flown(f, &g, false, c, at, x->n_orbit);
    put_clearance(f);
    f->row++;
    put_flown(f, &g, true, c, at, x->n_orbit);
    f->row++;
    ric_augmented_flight_close(&g);
}

/* c . q of the state behind event `place`, or before it at the end of the chain. */
static void put_gap(filling *f)
{
    const ric_augmented *x = f->x;
    const ric_enclosure *e = x->e;
    const slong n = e->n, last = (slong)(x->c.m - 1) * x->c.size;
    arb_srcptr c = ric_enclosure_c(e, e->wall[x->ask.face].contact);
    ric_augmented_flight g;
    if (x->ask.place < x->c.m)
        for (slong i = 0; i < n; i++)
            add_term(f, f->row, (slong)x->ask.place * x->c.size + i, c + i);
    else {
        ric_augmented_flight_open(&g, e, x->c.phase[x->c.m - 1], x->c.u + last,
                                  x->c.u + last + 2 * n, NULL);
        put_flown(f, &g, false, c, last, last + 2 * n);
        ric_augmented_flight_close(&g);
    }
    put_clearance(f);
    f->row++;
}

static void put_meet(filling *f)
{
    arb_t one;
    arb_init(one);
    arb_one(one);
    add_term(f, f->row++, (slong)f->x->ask.place * f->x->c.size + 2 * f->x->e->n, one);
    arb_clear(one);
}

/* l . a = 1; of motions that may be turned into one another also l rotated: (a, b) to (-b, a). */
static void put_norm(filling *f)
{
    const ric_augmented *x = f->x;
    const slong all = ric_augmented_motions(x) * x->n_motion;
    arb_t y;
    if (!all) return;
    for (slong i = 0; i < all; i++) add_term(f, f->row, x->n_orbit + i, x->l + i);
    arb_sub_ui(f->F + f->row, f->F + f->row, 1, x->e->prec);
    f->row++;
    if (!ric_augmented_has_factor(x)) return;
    arb_init(y);
    for (slong i = 0; i < all; i++) {
        if (i < x->n_motion) arb_neg(y, x->l + i + x->n_motion);
        else arb_set(y, x->l + i - x->n_motion);
        add_term(f, f->row, x->n_orbit + i, y);
    }
    arb_clear(y);
    f->row++;
}

/* ------------------------------------------------------------------------ all */

void ric_augmented_evaluate(ric_augmented *x, arb_srcptr z, arb_mat_struct *J, arb_ptr F)
{
    filling f = {.x = x, .z = z, .J = J, .F = F};
    ric_arb_clean(J);
    _arb_vec_zero(F, x->n);
    _arb_vec_set(x->c.u, z, x->n_orbit);
    ric_equation_create(&f.q, &x->c);
    ric_equation_evaluate(&f.q, &x->c, x->e);
    ric_equation_loosen(&f.q, &x->c, x->e, NULL);
    put_orbit(&f);
    switch (x->ask.kind) {
    case RIC_AUGMENTED_ENERGY:
    case RIC_AUGMENTED_PERIOD: put_tangent(&f); break;
    case RIC_AUGMENTED_BREAK: put_break(&f); break;
    case RIC_AUGMENTED_TURN:
        if (ric_augmented_has_factor(x)) put_general_turn(&f);
        else put_turn(&f);
        break;
    case RIC_AUGMENTED_DOUBLE: put_double(&f); break;
    case RIC_AUGMENTED_SPEED: put_speed(&f); break;
    case RIC_AUGMENTED_TOUCH: put_touch(&f); break;
    case RIC_AUGMENTED_GAP: put_gap(&f); break;
    case RIC_AUGMENTED_MEET: put_meet(&f); break;
    }
    ric_equation_free(&f.q);
    put_norm(&f);
}
