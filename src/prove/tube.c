#include "tube.h"

#include <math.h>

#include "base/room.h"

enum {
    TRIES = 4,   /* boxes */
    FLOOR = -14, /* 2^FLOOR of the largest change along the line: no radius is less, so that orbits
                    at its ends fit in */
};

/* The unknowns of a chain in a row; lambda of a reversible one is none. */
static slong count_unknowns(const ric_chain *c)
{
    return (slong)c->m * c->size + ric_chain_general(c);
}

/* ---------------------------------------------------------------- equations */

/* With the plane as the last row. */
static void evaluate(const ric_tube *t, const ric_chain *c, const ric_enclosure *e,
                     arb_mat_struct *J, arb_ptr F)
{
    ric_equations q;
    ric_equation_create(&q, c);
    ric_equation_evaluate(&q, c, e);
    ric_equation_loosen(&q, c, e, NULL);
    ric_equation_gather(&q, c, J, F);
    ric_equation_free(&q);
    if (J) _arb_vec_set(arb_mat_entry(J, t->k.n - 1, 0), t->row, t->k.n);
}

/* --------------------------------------------------------------------- line */

static bool lay_line(ric_tube *t)
{
    double largest = 0;
    for (slong i = 0; i < t->k.n; i++) {
        arb_sub(t->chord + i, t->to->u + i, t->from->u + i, ARF_PREC_EXACT);
        largest = fmax(largest, fabs(ric_arb_middle(t->chord + i)));
    }
    if (!(largest > 0) || !isfinite(largest)) return false;
    _arb_vec_scalar_mul_2exp_si(t->row, t->chord, t->k.n, -ilogb(largest));
    arb_dot(t->length, NULL, 0, t->row, 1, t->chord, 1, t->k.n, t->k.prec);
    return true;
}

/* p(s), for a ball s. */
static void place(const ric_tube *t, const arb_t s, arb_ptr out)
{
    for (slong i = 0; i < t->k.n; i++) {
        arb_set(out + i, t->from->u + i);
        arb_addmul(out + i, t->chord + i, s, t->k.prec);
    }
}

void ric_tube_part(const ric_tube *t, double from, double to, arb_ptr out)
{
    arb_t s, end;
    arb_init(s);
    arb_init(end);
    arb_set_d(s, from);
    arb_set_d(end, to);
    arb_union(s, s, end, t->k.prec);
    place(t, s, out);
    for (slong i = 0; i < t->k.n; i++) arb_add_error_mag(out + i, t->k.b + i);
    arb_clear(s);
    arb_clear(end);
}

/* All s, and the box around. */
static void place_hull(ric_tube *t)
{
    ric_tube_part(t, -RIC_TUBE_MORE, 1 + RIC_TUBE_MORE, t->hull.u);
}

/* ---------------------------------------------------------------- conditions */

/* y: C times what the equations are at both ends, and C D^2 F (b - a)^2 times s (1 - s) / 2 <= 1
 * / 8. */
static void bound_residual(ric_tube *t, const ric_enclosure *e)
{
    const slong n = t->k.n;
    ric_equations q;
    arb_mat_t J;
    arb_ptr F = _arb_vec_init(n), x = _arb_vec_init(n);
    mag_t size;
    arb_mat_init(J, n, n);
    mag_init(size);
    ric_equation_create(&q, &t->hull);
    ric_equation_second(&q, &t->hull, e, t->chord);
    ric_equation_loosen(&q, &t->hull, e, t->chord);
    ric_equation_gather(&q, &t->hull, J, NULL);
    ric_equation_free(&q);
    for (slong i = 0; i < n; i++)
        arb_dot(F + i, NULL, 0, arb_mat_entry(J, i, 0), 1, t->chord, 1, n, e->prec);
    ric_contraction_apply(&t->k, F, x);
    for (slong i = 0; i < n; i++) {
        arb_get_mag(t->k.y + i, x + i);
        mag_mul_2exp_si(t->k.y + i, t->k.y + i, -3);
    }
    for (int end = 0; end < 2; end++) {
        evaluate(t, end ? t->to : t->from, e, NULL, F);
        arb_zero(F + n - 1);
        ric_contraction_apply(&t->k, F, x);
        for (slong i = 0; i < n; i++) {
            arb_get_mag(size, x + i);
            mag_mul_2exp_si(size, size, 1); /* interpolated: 1 + 2 RIC_TUBE_MORE times at most */
            mag_add(t->k.y + i, t->k.y + i, size);
        }
    }
    arb_mat_clear(J);
    mag_clear(size);
    _arb_vec_clear(F, n);
    _arb_vec_clear(x, n);
}

/* A box to begin with: twice y, and no less than the floor. */
static void begin_box(ric_tube *t)
{
    mag_t floor, x;
    mag_init(floor);
    mag_init(x);
    for (slong i = 0; i < t->k.n; i++) {
        arb_get_mag(x, t->chord + i);
        mag_max(floor, floor, x);
    }
    mag_mul_2exp_si(floor, floor, FLOOR);
    for (slong i = 0; i < t->k.n; i++) {
        mag_mul_2exp_si(x, t->k.y + i, 1);
        mag_max(t->k.b + i, x, floor);
    }
    mag_clear(floor);
    mag_clear(x);
}

static bool contracts(ric_tube *t, const ric_enclosure *e)
{
    arb_mat_t J;
    arb_t half;
    arb_init(half);
    arb_mat_init(J, t->k.n, t->k.n);
    arb_set_d(half, 0.5);
    place(t, half, t->hull.u);
    for (slong i = 0; i < t->k.n; i++) arb_get_mid_arb(t->hull.u + i, t->hull.u + i);
    evaluate(t, &t->hull, e, J, NULL);
    bool holds = false;
    if (!ric_halt(pow((double)t->k.n, 3)) && ric_contraction_invert(&t->k, J)) {
        place_hull(t);
        bound_residual(t, e);
        begin_box(t);
        for (int i = 0; i < TRIES && !holds; i++) {
            place_hull(t);
            evaluate(t, &t->hull, e, J, NULL);
            ric_contraction_defect(&t->k, J);
            holds = ric_contraction_holds(&t->k);
        }
    }
    arb_mat_clear(J);
    arb_clear(half);
    return holds;
}

static void set_family(ric_tube *t)
{
    arb_t half;
    arb_init(half);
    arb_set_d(half, 0.5);
    place(t, half, t->middle);
    arb_set_d(half, 0.5 + RIC_TUBE_MORE);
    for (slong i = 0; i < t->k.n; i++) {
        arb_add_error_mag(t->middle + i, t->k.b + i);
        arb_mul(t->half + i, t->chord + i, half, t->k.prec);
    }
    arb_clear(half);
}

bool ric_tube_create(ric_tube *t, const ric_chain *from, const ric_chain *to,
                     const ric_enclosure *e)
{
    const slong count = (slong)from->m * from->size + 1;
    *t = (ric_tube){.from = from, .to = to};
    ric_chain_copy(&t->hull, from);
    ric_contraction_create(&t->k, count_unknowns(from), e->prec);
    t->chord = _arb_vec_init(count);
    t->middle = _arb_vec_init(count);
    t->half = _arb_vec_init(count);
    t->row = _arb_vec_init(t->k.n);
    arb_init(t->length);
    const bool done = lay_line(t) && contracts(t, e) && ric_chain_closes(&t->hull, e, t->hull.u);
    if (done) set_family(t);
    return done;
}

void ric_tube_free(ric_tube *t)
{
    const slong count = (slong)t->hull.m * t->hull.size + 1;
    _arb_vec_clear(t->chord, count);
    _arb_vec_clear(t->middle, count);
    _arb_vec_clear(t->half, count);
    _arb_vec_clear(t->row, t->k.n);
    arb_clear(t->length);
    ric_contraction_free(&t->k);
    ric_chain_free(&t->hull);
}

/* ---------------------------------------------------------------- the arc */

/* The orbit u is on the plane of s = s0 + v.(u - centre) / (v.(b - a)), |s - s0| <= |v| exists /
 * length < MORE, and the box around p(s) holds it if exists + |s - s0| |b - a|_i < b_i. */
bool ric_tube_holds(const ric_tube *t, const ric_chain *centre, const arb_t exists)
{
    mag_t away, x, radius;
    arb_t y;
    mag_init(away);
    mag_init(x);
    mag_init(radius);
    arb_init(y);
    ric_chain_norm(t->k.n, t->row, t->k.prec, y);
    arb_mul(y, y, exists, t->k.prec);
    arb_div(y, y, t->length, t->k.prec);
    arb_get_mag(away, y);
    arb_get_mag(radius, exists);
    mag_set_d_lower(x, RIC_TUBE_MORE);
    bool holds = (centre == t->from || centre == t->to) && mag_cmp(away, x) < 0;
    for (slong i = 0; i < t->k.n && holds; i++) {
        arb_get_mag(x, t->chord + i);
        mag_mul(x, x, away);
        mag_add(x, x, radius);
        holds = mag_cmp(x, t->k.b + i) < 0;
    }
    mag_clear(away);
    mag_clear(x);
    mag_clear(radius);
    arb_clear(y);
    return holds;
}

/* The derivative u' has D u' = (0, .., 0, v.v) and (b - a) all but that: with C D = 1 - E, |E| <=
 * Z, x = u' - (b - a) has |x| <= r + Z |x|, r = |C (G' (b - a), 0)|. As Z b <= theta b with theta <
 * 1, |x| <= r + mu Z b, mu = max(r / b) / (1 - theta). */
void ric_tube_slope(const ric_tube *t, const ric_enclosure *e, arb_ptr out)
{
    const slong n = t->k.n;
    arb_mat_t J;
    arb_ptr F = _arb_vec_init(n), x = _arb_vec_init(n);
    mag_ptr zb = _mag_vec_init(n);
    mag_t theta, mu, y;
    mag_init(theta);
    mag_init(mu);
    mag_init(y);
    arb_mat_init(J, n, n);
    evaluate(t, &t->hull, e, J, NULL);
    for (slong i = 0; i < n - 1; i++)
        arb_dot(F + i, NULL, 0, arb_mat_entry(J, i, 0), 1, t->chord, 1, n, e->prec);
    ric_contraction_apply(&t->k, F, x);
    ric_contraction_map(&t->k, t->k.b, zb);
    for (slong i = 0; i < n; i++) {
        mag_div(y, zb + i, t->k.b + i);
        mag_max(theta, theta, y);
        arb_get_mag(y, x + i);
        mag_div(y, y, t->k.b + i);
        mag_max(mu, mu, y);
    }
    mag_one(y);
    mag_sub_lower(y, y, theta);
    mag_div(mu, mu, y);
    for (slong i = 0; i < n; i++) {
        arb_set(out + i, t->chord + i);
        arb_get_mag(y, x + i);
        mag_addmul(y, mu, zb + i);
        arb_add_error_mag(out + i, y);
    }
    arb_mat_clear(J);
    mag_clear(theta);
    mag_clear(mu);
    mag_clear(y);
    _mag_vec_clear(zb, n);
    _arb_vec_clear(F, n);
    _arb_vec_clear(x, n);
}
