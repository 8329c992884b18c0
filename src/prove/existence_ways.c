/* The ways in which a proof of existence is tried (existence.h), and what more is asked of an orbit
 * where bounds of norms do not do: boxes. */
#include <math.h>
#include <string.h>

#include "base/room.h"
#include "existence_problem.h"

enum {
    WIDEST = 1024, /* numbers of a block whose sums quick.h bounds */
    DENSE = 400,   /* unknowns of a matrix that is not taken apart */
    WEIGHTS = 24,  /* weights of the unknowns that are tried in it */
    BOXES = 4,     /* that are tried */
    SHARE = -20,   /* 2^-20 of the largest: the least radius of those */
    NARROW = -9,   /* 2^-9 of what all have moved by: the least radius of a box that is narrow */
};

void ric_existence_init(ric_existence *x)
{
    *x = (ric_existence){.moved = HUGE_VAL, .shift = HUGE_VAL};
    arb_init(x->exists);
    arb_init(x->unique);
}

void ric_existence_clear(ric_existence *x)
{
    arb_clear(x->exists);
    arb_clear(x->unique);
    flint_free(x->tangent);
}

/* -------------------------------------------------------------------- boxes */

/* What is stored lies where the orbit is the only one. */
static bool identifies(const ric_existence *x)
{
    return x->shift < arf_get_d(arb_midref(x->unique), ARF_RND_FLOOR);
}

/* J and F of all equations on a box around the centre; the plane is the last row. */
static void evaluate_box(ric_existence_problem *p, const ric_chain *box)
{
    ric_equations q;
    ric_equation_create(&q, box);
    ric_equation_evaluate(&q, box, p->e);
    ric_equation_loosen(&q, box, p->e, NULL);
    ric_equation_gather(&q, box, p->J, p->F);
    arb_set(p->F + p->n - 1, arb_mat_entry(ric_equation_plane(&q)->F, 0, 0));
    ric_equation_free(&q);
    _arb_vec_set(arb_mat_entry(p->J, p->n - 1, (slong)box->at * box->size), box->row, box->size);
}

/* Whether a box around the centre, whose radii are the weights of k, holds no other orbit. With any
 * C and Z >= |1 - C D| on it two zeros in it differ by at most Z times what they differ by, number
 * by number: by nothing, if Z b < b for weights b > 0, which need not be the radii. */
static bool box_is_alone(ric_existence_problem *p)
{
    ric_chain box;
    bool alone = false;
    ric_chain_copy(&box, p->c);
    for (slong i = 0; i < p->n; i++) arb_add_error_mag(box.u + i, p->k.b + i);
    evaluate_box(p, &box);
    ric_contraction_defect(&p->k, p->J);
    for (int i = 0; i < WEIGHTS && !alone; i++) alone = ric_contraction_holds(&p->k);
    ric_chain_free(&box);
    return alone;
}

/* Radii of at least `least`, and at least twice what each number has moved by from `start`. */
static void lay_radii(ric_existence_problem *p, arb_srcptr start, double least)
{
    const slong count = (slong)p->c->m * p->c->size;
    const ric_contraction *k = &p->k;
    arb_t moved;
    mag_t twice;
    arb_init(moved);
    mag_init(twice);
    for (slong i = 0; i < k->n; i++) {
        mag_set_d(k->b + i, least);
        if (i == count || !start) continue;
        arb_sub(moved, p->c->u + i, start + i, p->e->prec);
        arb_get_mag(twice, moved);
        mag_mul_2exp_si(twice, twice, 1);
        mag_max(k->b + i, k->b + i, twice);
    }
    arb_clear(moved);
    mag_clear(twice);
}

/* That no other orbit is near, number by number: bounds of norms are too coarse where frequencies
 * are far apart. The first box has one radius, the other one is as narrow as what is stored allows.
 * Dense, so only for what is not large. start [m * size]: the centre as it was stored. */
static bool alone_in_box(ric_existence_problem *p, ric_existence *x, arb_srcptr start)
{
    const double radius[2] = {2 * x->shift, ldexp(x->shift, NARROW)};
    if (p->n > DENSE || !(radius[1] > 0) || !isfinite(radius[0])) return false;
    ric_existence_open_dense(p);
    bool alone = true, done = false;
    if (p->way != RIC_EXISTENCE_INVERSE) {
        evaluate_box(p, p->c);
        alone = p->way == RIC_EXISTENCE_BALLS
                    ? ric_contraction_invert(&p->k, p->J, RIC_CONTRACTION_FINE)
                    : ric_contraction_invert_quickly(&p->k, p->J);
    }
    for (int i = 0; i < 2 && alone && !done; i++) {
        lay_radii(p, i ? start : NULL, radius[i]);
        done = arf_cmp_d(arb_midref(x->exists), radius[i]) < 0 && box_is_alone(p);
        if (done) arf_set_d(arb_midref(x->unique), radius[i]);
    }
    return done;
}

/* Krawczyk's test in a box of the radii of what C makes of F, number by number, and of no less than
 * a share of the largest. Where D has a condition of 10^13 bounds of norms do not do, as those of
 * F'' grow with the squares of the frequencies. Nothing is told of other orbits near. */
static bool contracts_in_box(ric_existence_problem *p, ric_existence *x)
{
    ric_chain box;
    mag_t least;
    mag_init(least);
    ric_chain_copy(&box, p->c);
    evaluate_box(p, &box);
    ric_contraction_apply(&p->k, p->F, p->z);
    for (slong i = 0; i < p->n; i++) {
        arb_get_mag(p->k.y + i, p->z + i);
        mag_max(least, least, p->k.y + i);
    }
    mag_mul_2exp_si(least, least, SHARE);
    for (slong i = 0; i < p->n; i++) {
        mag_mul_2exp_si(p->k.b + i, p->k.y + i, 1);
        mag_max(p->k.b + i, p->k.b + i, least);
    }
    bool holds = false;
    for (int i = 0; i < BOXES && !holds; i++) {
        _arb_vec_set(box.u, p->c->u, (slong)p->c->m * p->c->size + 1);
        for (slong l = 0; l < p->n; l++) arb_add_error_mag(box.u + l, p->k.b + l);
        evaluate_box(p, &box);
        ric_contraction_defect(&p->k, p->J);
        holds = ric_contraction_holds(&p->k);
    }
    for (slong i = 0; i < p->n; i++) arf_set_mag(arb_midref(p->z + i), p->k.b + i);
    for (slong i = 0; i < p->n; i++) mag_zero(arb_radref(p->z + i));
    ric_chain_norm(p->n, p->z, p->e->prec, x->exists);
    arb_zero(x->unique);
    arb_get_ubound_arf(arb_midref(x->exists), x->exists, p->e->prec);
    mag_zero(arb_radref(x->exists));
    ric_chain_free(&box);
    mag_clear(least);
    return holds;
}

/* --------------------------------------------------------------------- ways */

/* start [m * size]: the centre as it is stored; `alone`: whether it is the only one there is asked.
 */
static const char *prove(ric_existence_problem *p, ric_existence *x, arb_srcptr start, bool alone)
{
    arb_t least;
    if (!ric_existence_find_plane(p)) return "the equations are singular there: a junction";
    if (!ric_existence_refine(p, &x->shift, &x->moved)) return "no orbit was found from it";
    if (!ric_existence_factorise(p)) return "the equations are singular there: a junction";
    ric_existence_keep_tangent(p, x);
    arb_init(least);
    const char *why = !ric_existence_bound_inverse(p, least)
                          ? "the equations are all but singular there"
                      : !ric_existence_conclude(p, x, least)
                          ? "the equations are too near to singular for what is left of them"
                          : NULL;
    if (why && !alone && p->way == RIC_EXISTENCE_INVERSE && contracts_in_box(p, x)) why = NULL;
    x->identified = !why && alone && (identifies(x) || alone_in_box(p, x, start));
    x->blur = ric_existence_size(start, (slong)p->c->m * p->c->size) * RIC_BALL_UNIT /
              arf_get_d(arb_midref(least), ARF_RND_NEAR);
    arb_clear(least);
    return why;
}

static void open_problem(ric_existence_problem *p)
{
    const ric_chain *c = p->c;
    arb_init(p->zero);
    ric_factor_create(&p->f, c, p->e->prec);
    ric_quick_create(&p->d, c);
    p->n = ric_quick_unknowns(&p->d);
    p->y = flint_calloc((size_t)p->n, sizeof *p->y);
    p->x = flint_calloc((size_t)c->m, sizeof *p->x);
    for (int k = 0; k < c->m; k++) arb_mat_init(p->x[k], ric_chain_width(c, k), 1);
}

static void close_problem(ric_existence_problem *p)
{
    for (int k = 0; k < p->c->m; k++) arb_mat_clear(p->x[k]);
    flint_free(p->x);
    flint_free(p->y);
    ric_factor_free(&p->f);
    ric_quick_free(&p->d);
    if (p->q.group) ric_equation_free(&p->q);
    arb_clear(p->zero);
    if (!p->F) return;
    ric_contraction_free(&p->k);
    arb_mat_clear(p->J);
    _arb_vec_clear(p->F, p->n);
    _arb_vec_clear(p->z, p->n);
}

/* In each way, until one proves it and, where that is asked, tells it apart from others. */
static const char *prove_in_ways(ric_existence *x, ric_chain *c, const ric_enclosure *e, bool alone)
{
    ric_existence_problem p = {.c = c, .e = e};
    open_problem(&p);
    const slong count = (slong)c->m * c->size;
    arb_ptr start = _arb_vec_init(count);
    _arb_vec_set(start, c->u, count);
    const char *why = NULL;
    for (p.way = (ric_existence_way)x->way; p.way <= RIC_EXISTENCE_BALLS; p.way++) {
        if (ric_halt((double)(RIC_EXISTENCE_WORK * p.n))) why = "stopped";
        if (ric_halted()) break;
        if (p.way == RIC_EXISTENCE_QUICK && p.d.wide > WIDEST) continue;
        if (p.way == RIC_EXISTENCE_INVERSE && p.n > DENSE) continue;
        if (p.way == RIC_EXISTENCE_INVERSE) ric_existence_open_dense(&p);
        _arb_vec_set(c->u, start, count);
        why = prove(&p, x, start, alone);
        x->way = (int)p.way;
        if (!why && (x->identified || !alone)) break;
    }
    _arb_vec_clear(start, count);
    close_problem(&p);
    return why;
}

const char *ric_existence_prove(ric_existence *x, ric_chain *c, const ric_enclosure *e)
{
    return prove_in_ways(x, c, e, true);
}

const char *ric_existence_find(ric_existence *x, ric_chain *c, const ric_enclosure *e)
{
    return prove_in_ways(x, c, e, false);
}
