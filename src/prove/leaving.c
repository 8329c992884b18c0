#include "leaving.h"

#include <math.h>

#include "base/room.h"
#include "passage.h"
#include "story.h"

/* NEAR: the chord beside it is that near to the junction, to be cut at the same places: what is
 * found there is proved, and joined with the orbits on both sides */
#define NEAR 1e-3
/* CONVERGED: step of Newton's method from which on the test of the box says more than it */
#define CONVERGED 1e-12

enum {
    FLOOR = -12, /* 2^FLOOR of the size: no radius of a box is less, so that orbits at its ends fit
                    in */
    LARGEST = 5,
    SMALLEST = 24, /* 2^-k: sizes that are tried */
    LEAST = 40,    /* of those of structures whose frequencies are far apart */
    FURTHER = 8,   /* behind one that contracts */
    TRIES = 6,     /* boxes of each */
    POWER = 4,     /* steps of the inverse iteration for directions */
    NEWTON = 12,
    CHORD = 200, /* steps towards the orbit at an end, with one derivative */
    LEFT = 16,   /* steps from the box to what is left of it */
    TIGHT = 24   /* doublings of its radius */
};

/* Unknowns z = (v, the state at its end, a); lambda of a chain that has none is no unknown. */
typedef struct {
    const ric_enclosure *e;
    ric_chain small, large;             /* G, F; u: balls while equations are evaluated */
    slong n_chain, n_small, n_large, n; /* of v; with the state at the end; of u; all of them */
    arb_mat_t T;                        /* [n_large * n_small] */
    arb_ptr l, k;                       /* [n_large] */
    ric_contraction c;
    arb_mat_t J;
    arb_ptr F, box, centre;
    arb_t size;
} problem;

static slong count_unknowns(const ric_chain *c)
{
    return (slong)c->m * c->size + ric_chain_general(c);
}

/* ---------------------------------------------------------------------- T */

/* A column: what becomes of one number where all others are zero. */
static void put_column(problem *p, slong j, const ric_story_way *way, arb_ptr v, arb_ptr u)
{
    ric_story story;
    arb_one(v + j);
    ric_story_tell_parts(&story, &p->small, v, v + p->n_chain, p->e);
    ric_story_follow(&story, &p->large, way, u);
    for (slong i = 0; i < (slong)p->large.m * p->large.size; i++)
        arb_set(arb_mat_entry(p->T, i, j), u + i);
    ric_story_free(&story);
    arb_zero(v + j);
}

/* false where the orbit of the junction is none of the larger class. */
static bool find_images(problem *p, arb_srcptr orbit)
{
    ric_story story;
    ric_story_way way;
    ric_story_tell(&story, &p->small, orbit, NULL, p->e);
    const bool found = ric_story_find(&story, &p->large, NEAR, &way);
    arb_ptr v = _arb_vec_init(p->n_small), u = _arb_vec_init((slong)p->large.m * p->large.size);
    for (slong j = 0; j < p->n_small && found; j++)
        if (j < (slong)p->small.m * p->small.size || j >= p->n_chain) put_column(p, j, &way, v, u);
    ric_story_way_free(&way);
    ric_story_free(&story);
    _arb_vec_clear(v, p->n_small);
    _arb_vec_clear(u, (slong)p->large.m * p->large.size);
    return found;
}

/* u = T v + e a. */
static void place_large(const problem *p, arb_srcptr z, const arb_t e, arb_ptr out)
{
    for (slong i = 0; i < p->n_large; i++) {
        arb_dot(out + i, NULL, 0, arb_mat_entry(p->T, i, 0), 1, z, 1, p->n_small, p->e->prec);
        arb_addmul(out + i, e, z + p->n_small + i, p->e->prec);
    }
}

/* ---------------------------------------------------------------- equations */

/* F and its derivative at u: all but the plane; J [n_large - 1 rows] or NULL. */
static void evaluate_large(problem *p, arb_srcptr u, arb_mat_struct *J, arb_ptr F)
{
    ric_equations q;
    _arb_vec_set(p->large.u, u, p->n_large);
    ric_equation_create(&q, &p->large);
    ric_equation_evaluate(&q, &p->large, p->e);
    ric_equation_loosen(&q, &p->large, p->e, NULL);
    ric_equation_gather(&q, &p->large, J, F);
    ric_equation_free(&q);
}

/* F'' a at u. */
static void bend_large(problem *p, arb_srcptr u, arb_srcptr a, arb_mat_struct *J)
{
    ric_equations q;
    arb_ptr along = _arb_vec_init(p->n_large + 1);
    _arb_vec_set(along, a, p->n_large);
    _arb_vec_set(p->large.u, u, p->n_large);
    arb_mat_t *flights = ric_equation_flights(&p->large, p->e);
    ric_equation_create(&q, &p->large);
    ric_equation_second(&q, &p->large, p->e, flights, along);
    ric_equation_loosen(&q, &p->large, p->e, along);
    ric_equation_gather(&q, &p->large, J, NULL);
    ric_equation_flights_free(&p->large, flights);
    ric_equation_free(&q);
    _arb_vec_clear(along, p->n_large + 1);
}

/* The state at the end of the smaller chain, less what the flight to it makes. */
static void put_last(problem *p, arb_srcptr z, arb_mat_struct *J, arb_ptr F, slong row)
{
    const ric_enclosure *e = p->e;
    const slong n = e->n, last = (slong)(p->small.m - 1) * p->small.size;
    arb_srcptr w = z + last;
    arb_mat_t D;
    arb_ptr flown = _arb_vec_init(2 * n);
    arb_t slack;
    arb_init(slack);
    arb_mat_init(D, 2 * n, 2 * n + 1);
    ric_equation_flight(e, p->small.phase[p->small.m - 1], w, w + 2 * n, D, flown);
    ric_chain_slack(e, p->small.phase[p->small.m - 1], w, w + 2 * n, slack);
    for (slong i = 0; i < 2 * n; i++) {
        arb_sub(F + row + i, z + p->n_chain + i, flown + i, e->prec);
        arb_add_error(F + row + i, slack);
        for (slong j = 0; j <= 2 * n; j++) {
            arb_neg(arb_mat_entry(J, row + i, last + j), arb_mat_entry(D, i, j));
            arb_add_error(arb_mat_entry(J, row + i, last + j), slack);
        }
        arb_one(arb_mat_entry(J, row + i, p->n_chain + i));
    }
    arb_mat_clear(D);
    _arb_vec_clear(flown, 2 * n);
    arb_clear(slack);
}

/* G, the state at the end, l.a = 1 and k.a = 0; the rows between are left free. Returns the first
 * of those. */
static slong put_small(problem *p, arb_srcptr z)
{
    ric_equations q;
    const slong row = p->n_chain - 1, n = p->n, prec = p->e->prec;
    arb_srcptr a = z + p->n_small;
    ric_arb_clean(p->J);
    _arb_vec_set(p->small.u, z, p->n_chain);
    ric_equation_create(&q, &p->small);
    ric_equation_evaluate(&q, &p->small, p->e);
    ric_equation_loosen(&q, &p->small, p->e, NULL);
    ric_equation_gather(&q, &p->small, p->J, p->F);
    ric_equation_free(&q);
    put_last(p, z, p->J, p->F, row);
    for (int k = 0; k < 2; k++) {
        arb_srcptr by = k ? p->k : p->l;
        arb_dot(p->F + n - 2 + k, NULL, 0, by, 1, a, 1, p->n_large, prec);
        _arb_vec_set(arb_mat_entry(p->J, n - 2 + k, p->n_small), by, p->n_large);
    }
    arb_sub_ui(p->F + n - 2, p->F + n - 2, 1, prec);
    return p->n_small - 1;
}

/* out = A B, of which both have few numbers that are not zero: those of a block, and images. */
static void multiply_few(arb_mat_t out, const arb_mat_t A, const arb_mat_t B, slong prec)
{
    ric_arb_clean(out);
    for (slong i = 0; i < arb_mat_nrows(A); i++)
        for (slong l = 0; l < arb_mat_ncols(A); l++) {
            arb_srcptr a = arb_mat_entry(A, i, l), row = arb_mat_entry(B, l, 0);
            for (slong j = 0; j < arb_mat_ncols(B) && !arb_is_zero(a); j++)
                if (!arb_is_zero(row + j)) arb_addmul(arb_mat_entry(out, i, j), a, row + j, prec);
        }
}

/* All equations and their derivatives at e = 0, with e = NULL; else their derivatives for all |e'|
 * <= e, where F is of no use: by a they are F', and by v F'' a, at some place between T v and T v +
 * e a. */
static void evaluate(problem *p, arb_srcptr z, const arb_struct *e)
{
    const slong first = put_small(p, z), rows = p->n_large - 1, prec = p->e->prec;
    arb_ptr u = _arb_vec_init(p->n_large), F = _arb_vec_init(rows);
    arb_mat_t D, S, ST;
    arb_t spread;
    arb_init(spread);
    arb_mat_init(D, rows, p->n_large);
    arb_mat_init(S, rows, p->n_large);
    arb_mat_init(ST, rows, p->n_small);
    if (e) arb_add_error(spread, e);
    place_large(p, z, spread, u);
    evaluate_large(p, u, D, F);
    bend_large(p, u, z + p->n_small, S);
    multiply_few(ST, S, p->T, prec);
    for (slong i = 0; i < rows; i++) {
        arb_dot(p->F + first + i, NULL, 0, arb_mat_entry(D, i, 0), 1, z + p->n_small, 1, p->n_large,
                prec);
        _arb_vec_set(arb_mat_entry(p->J, first + i, 0), arb_mat_entry(ST, i, 0), p->n_small);
        _arb_vec_set(arb_mat_entry(p->J, first + i, p->n_small), arb_mat_entry(D, i, 0),
                     p->n_large);
    }
    arb_mat_clear(D);
    arb_mat_clear(S);
    arb_mat_clear(ST);
    arb_clear(spread);
    _arb_vec_clear(u, p->n_large);
    _arb_vec_clear(F, rows);
}

/* The same on the box, with few bits. */
static void evaluate_box(problem *p)
{
    const ric_enclosure *e = p->e, coarse = ric_enclosure_coarse(e);
    p->e = &coarse;
    evaluate(p, p->box, p->size);
    p->e = e;
}

/* F alone, at one e that is not zero. */
static void evaluate_end(problem *p, arb_srcptr z, const arb_t e)
{
    const slong first = put_small(p, z), rows = p->n_large - 1, prec = p->e->prec;
    arb_ptr u = _arb_vec_init(p->n_large), F = _arb_vec_init(2 * rows);
    arb_t none;
    arb_init(none);
    place_large(p, z, e, u);
    evaluate_large(p, u, NULL, F);
    place_large(p, z, none, u);
    evaluate_large(p, u, NULL, F + rows);
    for (slong i = 0; i < rows; i++) {
        arb_sub(F + i, F + i, F + rows + i, prec);
        arb_div(p->F + first + i, F + i, e, prec);
    }
    arb_clear(none);
    _arb_vec_clear(u, p->n_large);
    _arb_vec_clear(F, 2 * rows);
}

/* --------------------------------------------------------------- directions */

/* What all rows of A but the last one, which is x itself or `across`, take to zero: x [n], by
 * inverse iteration. */
static bool find_null(arb_mat_t A, arb_srcptr across, slong prec, arb_ptr out)
{
    const slong n = arb_mat_nrows(A);
    arb_mat_t x;
    arb_mat_init(x, n, 1);
    for (slong i = 0; i < n; i++) arb_set_si(arb_mat_entry(x, i, 0), 1 + i % 3);
    bool done = ric_arb_normalise(x, prec);
    arb_mat_get_mid(A, A);
    for (int step = 0; step < POWER && done; step++) {
        for (slong j = 0; j < n; j++)
            arb_set(arb_mat_entry(A, n - 1, j), across ? across + j : arb_mat_entry(x, j, 0));
        if (!across) arb_mat_zero(x);
        if (!across) arb_one(arb_mat_entry(x, n - 1, 0));
        done = arb_mat_approx_solve(x, A, x, prec) && ric_arb_normalise(x, prec);
    }
    for (slong i = 0; i < n; i++) arb_set(out + i, arb_mat_entry(x, i, 0));
    arb_mat_clear(x);
    return done;
}

/* k: along the first curve, in the larger class. a, and l, across it. */
static bool lay_directions(problem *p)
{
    const slong prec = p->e->prec;
    arb_mat_t A, D;
    arb_ptr tangent = _arb_vec_init(p->n_small), u = _arb_vec_init(p->n_large);
    arb_t none;
    arb_init(none);
    arb_mat_init(A, p->n_small, p->n_small);
    arb_mat_init(D, p->n_large, p->n_large);
    put_small(p, p->centre);
    for (slong i = 0; i + 1 < p->n_small; i++)
        _arb_vec_set(arb_mat_entry(A, i, 0), arb_mat_entry(p->J, i, 0), p->n_small);
    bool done = find_null(A, NULL, prec, tangent);
    for (slong i = 0; i < p->n_large; i++) {
        arb_dot(p->k + i, NULL, 0, arb_mat_entry(p->T, i, 0), 1, tangent, 1, p->n_small, prec);
        arb_get_mid_arb(p->k + i, p->k + i);
    }
    place_large(p, p->centre, none, u);
    evaluate_large(p, u, D, NULL);
    done = done && find_null(D, p->k, prec, p->l);
    _arb_vec_set(p->centre + p->n_small, p->l, p->n_large);
    arb_mat_clear(A);
    arb_mat_clear(D);
    arb_clear(none);
    _arb_vec_clear(tangent, p->n_small);
    _arb_vec_clear(u, p->n_large);
    return done;
}

/* The zero at e = 0, and C there. */
static bool find_centre(problem *p)
{
    for (slong i = 0; i < 2 * p->e->n; i++) arb_zero(p->centre + p->n_chain + i);
    put_last(p, p->centre, p->J, p->F, p->n_chain - 1);
    for (slong i = 0; i < 2 * p->e->n; i++)
        arb_neg(p->centre + p->n_chain + i, p->F + p->n_chain - 1 + i);
    for (slong i = 0; i < p->n_small; i++) arb_get_mid_arb(p->centre + i, p->centre + i);
    if (!lay_directions(p)) return false;
    bool done = true;
    double size = HUGE_VAL;
    arb_ptr x = _arb_vec_init(p->n);
    for (int step = 0; step < NEWTON && done && size > ldexp(1, 20 - (int)p->e->prec); step++) {
        evaluate(p, p->centre, NULL);
        done = ric_contraction_invert(&p->c, p->J, RIC_CONTRACTION_EVEN);
        ric_contraction_apply(&p->c, p->F, x);
        size = 0;
        for (slong i = 0; i < p->n && done; i++) {
            size = fmax(size, fabs(ric_arb_middle(x + i)));
            arb_sub(p->centre + i, p->centre + i, x + i, p->e->prec);
            arb_get_mid_arb(p->centre + i, p->centre + i);
        }
    }
    _arb_vec_clear(x, p->n);
    return done && size < CONVERGED;
}

/* ------------------------------------------------------------------- the box */

static void place_box(problem *p)
{
    _arb_vec_set(p->box, p->centre, p->n);
    for (slong i = 0; i < p->n; i++) arb_add_error_mag(p->box + i, p->c.b + i);
}

/* y, at the centre: what there is at e = 0, where F' a all but vanishes, and at most e / 2 F'' a a.
 */
static void bound_residual(problem *p)
{
    const slong first = p->n_small - 1, rows = p->n_large - 1, prec = p->e->prec;
    arb_srcptr a = p->centre + p->n_small;
    arb_ptr u = _arb_vec_init(p->n_large), x = _arb_vec_init(p->n);
    arb_mat_t S;
    arb_t y, spread;
    arb_init(y);
    arb_init(spread);
    arb_mat_init(S, rows, p->n_large);
    evaluate(p, p->centre, NULL);
    arb_add_error(spread, p->size);
    place_large(p, p->centre, spread, u);
    bend_large(p, u, a, S);
    for (slong i = 0; i < rows; i++) {
        arb_dot(y, NULL, 0, arb_mat_entry(S, i, 0), 1, a, 1, p->n_large, prec);
        arb_mul(y, y, p->size, prec);
        arb_mul_2exp_si(y, y, -1);
        arb_add_error(p->F + first + i, y);
    }
    ric_contraction_apply(&p->c, p->F, x);
    for (slong i = 0; i < p->n; i++) arb_get_mag(p->c.y + i, x + i);
    arb_mat_clear(S);
    arb_clear(y);
    arb_clear(spread);
    _arb_vec_clear(u, p->n_large);
    _arb_vec_clear(x, p->n);
}

/* Whether larger radii may hold: not if none does for Z, which grows with them. */
static bool is_hopeful(problem *p)
{
    mag_ptr b = _mag_vec_init(p->n);
    for (slong i = 0; i < p->n; i++) mag_set(b + i, p->c.b + i);
    const bool hopeful = ric_contraction_may_hold(&p->c);
    for (slong i = 0; i < p->n; i++) mag_set(p->c.b + i, b + i);
    _mag_vec_clear(b, p->n);
    return hopeful;
}

static bool contracts(problem *p)
{
    mag_t least;
    bool holds = false, hopeful = true;
    bound_residual(p);
    mag_init(least);
    arb_get_mag(least, p->size);
    mag_mul_2exp_si(least, least, FLOOR);
    for (slong i = 0; i < p->n; i++) {
        mag_mul_2exp_si(p->c.b + i, p->c.y + i, 1);
        mag_max(p->c.b + i, p->c.b + i, least);
    }
    for (int i = 0; i < TRIES && !holds && hopeful; i++) {
        place_box(p);
        evaluate_box(p);
        ric_contraction_defect(&p->c, p->J);
        holds = ric_contraction_holds(&p->c);
        hopeful = holds || is_hopeful(p);
    }
    mag_clear(least);
    return holds;
}

/* ------------------------------------------------------------------ the ends */

/* Steps from the middle of the box until they no longer shrink; y of the last place. */
static void approach_end(problem *p, const arb_t e, arb_ptr z)
{
    arb_ptr x = _arb_vec_init(p->n);
    for (slong i = 0; i < p->n; i++) arb_get_mid_arb(z + i, p->box + i);
    double size = HUGE_VAL;
    for (int step = 0;; step++) {
        double next = 0;
        evaluate_end(p, z, e);
        ric_contraction_apply(&p->c, p->F, x);
        for (slong i = 0; i < p->n; i++) {
            arb_get_mag(p->c.y + i, x + i);
            next = fmax(next, fabs(ric_arb_middle(x + i)));
        }
        if (!(next < size) || step == CHORD) break;
        size = next;
        for (slong i = 0; i < p->n; i++) {
            arb_sub(z + i, z + i, x + i, p->e->prec);
            arb_get_mid_arb(z + i, z + i);
        }
    }
    _arb_vec_clear(x, p->n);
}

/* Radii that are a share of those of the box: Z, which makes less of these, makes less of them. */
static void share_radii(problem *p, mag_srcptr whole, double share)
{
    mag_t x;
    mag_init(x);
    mag_set_d(x, share);
    for (slong i = 0; i < p->n; i++) mag_mul(p->c.b + i, whole + i, x);
    mag_clear(x);
}

/* The zero at an e in a box that is small beside that of all, where Z holds, and its orbit; `even`:
 * with one radius for all numbers. */
static bool find_end(problem *p, const arb_t e, bool even, arb_ptr out)
{
    arb_ptr z = _arb_vec_init(p->n);
    mag_ptr whole = _mag_vec_init(p->n);
    double share = ldexp(1, 4 - (int)p->e->prec);
    for (slong i = 0; i < p->n; i++)
        if (even) mag_one(whole + i);
        else mag_set(whole + i, arb_radref(p->box + i));
    approach_end(p, e, z);
    for (slong i = 0; i < p->n; i++)
        share = fmax(share, mag_get_d(p->c.y + i) / mag_get_d(whole + i));
    bool tight = false;
    for (int i = 0; i < TIGHT && !tight; i++) {
        share *= 2;
        share_radii(p, whole, share);
        tight = ric_contraction_holds(&p->c);
    }
    share_radii(p, whole, share);
    for (slong i = 0; i < p->n && tight; i++) {
        arb_add_error_mag(z + i, p->c.b + i);
        tight = arb_contains(p->box + i, z + i);
    }
    if (tight) place_large(p, z, e, out);
    _mag_vec_clear(whole, p->n);
    _arb_vec_clear(z, p->n);
    return tight;
}

/* -------------------------------------------------------------------- motions */

/* The zeros lie in y + Z b, too, and so on: what is left of the box. */
static void place_tight(const problem *p, arb_ptr out)
{
    mag_ptr b = _mag_vec_init(p->n), next = _mag_vec_init(p->n);
    for (slong i = 0; i < p->n; i++) mag_set(b + i, p->c.b + i);
    for (int step = 0; step < LEFT; step++) {
        ric_contraction_map(&p->c, b, next);
        for (slong i = 0; i < p->n; i++) mag_add(b + i, next + i, p->c.y + i);
    }
    _arb_vec_set(out, p->centre, p->n);
    for (slong i = 0; i < p->n; i++) arb_add_error_mag(out + i, b + i);
    _mag_vec_clear(b, p->n);
    _mag_vec_clear(next, p->n);
}

/* The arc as a line along a, with the balls of what it is beside it; z: all of the zeros. */
static void place_line(const problem *p, arb_srcptr z, arb_ptr middle, arb_ptr half)
{
    arb_t y, x;
    arb_init(y);
    arb_init(x);
    place_large(p, z, y, middle);
    for (slong i = 0; i < p->n_large; i++) {
        arb_srcptr a = z + p->n_small + i;
        arb_get_mid_arb(y, a);
        arb_mul(half + i, y, p->size, p->e->prec);
        arb_sub(x, a, y, p->e->prec);
        arb_mul(x, x, p->size, p->e->prec);
        arb_add_error(middle + i, x);
    }
    arb_clear(y);
    arb_clear(x);
}

/* All orbits of the arc, and those of the smaller class that it is seen from, close, and they pass
 * no stop. */
static bool arc_stands(problem *p, ric_leaving *v)
{
    const slong count = (slong)p->large.m * p->large.size + 1;
    arb_ptr hull = _arb_vec_init(3 * count), middle = hull + count, half = middle + count,
            z = _arb_vec_init(p->n);
    arb_t y;
    ric_passage passage;
    arb_init(y);
    arb_add_error(y, p->size);
    place_tight(p, z);
    place_large(p, z, y, hull);
    place_line(p, z, middle, half);
    ric_passage_init(&passage);
    ric_chain_energy(p->e, p->large.phase[0], hull, y);
    const bool done = arb_is_positive(y) && ric_chain_closes(&p->large, p->e, hull) &&
                      ric_chain_closes(&p->small, p->e, z) &&
                      ric_passage_prove(&passage, &p->large, p->e,
                                        &(ric_family){.hull = hull,
                                                      .middle = middle,
                                                      .half = half});
    v->approach = arf_get_d(arb_midref(passage.approach), ARF_RND_FLOOR);
    ric_passage_clear(&passage);
    arb_clear(y);
    _arb_vec_clear(hull, 3 * count);
    _arb_vec_clear(z, p->n);
    return done;
}

/* Half of the halvings after which what grows as the size is 1, at least one. */
static int halvings(double excess)
{
    enum { MOST = 4 };
    const double share = log2(excess) / 2;
    return !(share < MOST) ? MOST : share > 1 ? (int)share : 1;
}

/* What sizes have shown: whether one contracts, the first of which it is not known that it does
 * not, and how much farther the next one is worth a trial. */
typedef struct {
    bool any;
    int first, next;
} trials;

/* One radius for all numbers is no solution where a row of Z adds up to 1. */
static bool try_size(problem *p, int size, bool even, trials *t, ric_leaving *v)
{
    arb_t e;
    arb_init(e);
    arb_one(p->size);
    arb_mul_2exp_si(p->size, p->size, -size);
    bool done = contracts(p);
    t->any = t->any || done;
    if (!t->any) t->first = size + 1;
    t->next = !done  ? halvings(ric_contraction_root(p->n, p->c.Z))
              : even ? halvings(ric_contraction_left(&p->c))
                     : 1;
    done = done && (!even || ric_contraction_left(&p->c) < 1) && arc_stands(p, v);
    for (int side = 0; side < 2 && done; side++) {
        arb_set(e, p->size);
        if (!side) arb_neg(e, e);
        done = find_end(p, e, even, v->end[side]);
    }
    arb_clear(e);
    return done;
}

/* The largest arc whose ends are told by one radius for all numbers, which is short but sharp, or
 * else one that is told at all. */
static bool find_size(problem *p, ric_leaving *v)
{
    trials t = {.first = LARGEST};
    bool done = false;
    for (int size = LARGEST; size <= SMALLEST && !done; size += t.next)
        done = try_size(p, size, true, &t, v);
    const int first = t.first, last = t.any ? first + FURTHER : LEAST;
    for (int size = first; size <= last && !done; size++) done = try_size(p, size, false, &t, v);
    return done;
}

static void problem_open(problem *p, const ric_augmented *junction, const ric_chain *like)
{
    *p = (problem){.e = junction->e};
    ric_chain_copy(&p->small, &junction->c);
    ric_chain_copy(&p->large, like);
    p->n_chain = count_unknowns(&p->small);
    p->n_small = p->n_chain + 2 * p->e->n;
    p->n_large = count_unknowns(&p->large);
    p->n = p->n_small + p->n_large;
    arb_mat_init(p->T, p->n_large, p->n_small);
    arb_mat_init(p->J, p->n, p->n);
    p->l = _arb_vec_init(p->n_large);
    p->k = _arb_vec_init(p->n_large);
    p->F = _arb_vec_init(p->n);
    p->box = _arb_vec_init(p->n);
    p->centre = _arb_vec_init(p->n);
    arb_init(p->size);
    ric_contraction_create(&p->c, p->n, p->e->prec);
}

static void problem_close(problem *p)
{
    ric_chain_free(&p->small);
    ric_chain_free(&p->large);
    arb_mat_clear(p->T);
    arb_mat_clear(p->J);
    _arb_vec_clear(p->l, p->n_large);
    _arb_vec_clear(p->k, p->n_large);
    _arb_vec_clear(p->F, p->n);
    _arb_vec_clear(p->box, p->n);
    _arb_vec_clear(p->centre, p->n);
    arb_clear(p->size);
    ric_contraction_free(&p->c);
}

bool ric_leaving_prove(ric_leaving *v, const ric_augmented *junction, const ric_chain *like)
{
    problem p;
    *v = (ric_leaving){.count = (slong)like->m * like->size + 1};
    for (int side = 0; side < 2; side++) v->end[side] = _arb_vec_init(v->count);
    problem_open(&p, junction, like);
    _arb_vec_set(p.centre, junction->z, junction->n_orbit);
    const bool done = find_images(&p, p.centre) && find_centre(&p) && find_size(&p, v);
    problem_close(&p);
    return done;
}

void ric_leaving_free(ric_leaving *v)
{
    for (int side = 0; side < 2; side++) {
        if (v->end[side]) _arb_vec_clear(v->end[side], v->count);
        v->end[side] = NULL;
    }
}
