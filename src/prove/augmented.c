#include "augmented.h"

#include <math.h>

#include "augmented_rows.h"
#include "base/room.h"
#include "lu.h"
#include "monodromy.h"

/* CONVERGED: step of Newton's method from which on the test of the box says more than it */
#define CONVERGED 1e-12

enum {
    NEWTON = 24, /* steps at most */
    CHORD = 48,  /* the same with an inverse in doubles */
    FIRST = 6,   /* steps that need not shrink */
    SLOW = -4, /* a step of 2^-4 of the one before, or more, has the next one take a new inverse */
    POWER = 4, /* steps of the inverse iteration for motions beside the orbit */
    WIDEST = 3,
    FINEST = 50, /* 2^-k: radii in which there is no other zero, as far as they are tried */
    TIGHT = 24,  /* doublings of a radius of existence */
    NARROW = 40  /* 2^-k: radii in which there is no other multiplier */
};

/* What A makes least of, x [n], by inverse iteration: in doubles, */
static bool find_least_quickly(const arb_mat_t A, double *x)
{
    const slong n = arb_mat_nrows(A);
    double *y = flint_malloc((size_t)n * sizeof *y);
    ric_lu lu;
    ric_lu_create(&lu, n);
    bool done = ric_lu_make(&lu, A);
    for (slong i = 0; i < n; i++) x[i] = (double)(1 + i % 3);
    for (int step = 0; step < POWER && done; step++) {
        double sum = 0;
        ric_lu_solve(&lu, x, y);
        for (slong i = 0; i < n; i++) sum += y[i] * y[i];
        for (slong i = 0; i < n; i++) x[i] = y[i] / sqrt(sum);
        done = sum > 0 && isfinite(sum);
    }
    ric_lu_free(&lu);
    flint_free(y);
    return done;
}

/* and with all digits. */
static bool find_least_widely(arb_mat_t A, slong prec, double *x)
{
    const slong n = arb_mat_nrows(A);
    slong *order = flint_malloc((size_t)n * sizeof *order);
    arb_mat_t b;
    arb_mat_init(b, n, 1);
    for (slong i = 0; i < n; i++) arb_set_si(arb_mat_entry(b, i, 0), 1 + i % 3);
    bool done = arb_mat_approx_lu(order, A, A, prec);
    for (int step = 0; step < POWER && done; step++) {
        arb_mat_approx_solve_lu_precomp(b, order, A, b, prec);
        done = ric_arb_normalise(b, prec);
    }
    for (slong i = 0; i < n; i++) x[i] = ric_arb_middle(arb_mat_entry(b, i, 0));
    flint_free(order);
    arb_mat_clear(b);
    return done;
}

/* The motions beside the orbit: the rows on them are a square matrix that is all but singular. */
static bool find_motions(ric_augmented *x, bool widely, arb_mat_t J, arb_ptr F)
{
    const slong first = x->n_orbit, count = ric_augmented_motions(x) * x->n_motion;
    arb_mat_t A;
    double *least = flint_malloc((size_t)count * sizeof *least);
    arb_mat_init(A, count, count);
    ric_augmented_evaluate(x, x->z, J, F);
    for (slong i = 0; i < count; i++)
        for (slong j = 0; j < count; j++)
            arb_get_mid_arb(arb_mat_entry(A, i, j), arb_mat_entry(J, first - 1 + i, first + j));
    const bool done = widely ? find_least_widely(A, x->e->prec, least)
                             : find_least_quickly(A, least);
    for (slong i = 0; i < count && done; i++) {
        arb_set_d(x->z + first + i, least[i]);
        arb_set_d(x->l + i, least[i]);
    }
    flint_free(least);
    arb_mat_clear(A);
    return done;
}

/* z <- z - C F, in balls that are cut to their middles; the largest number of that. C F has as many
 * digits as doubles, F all of them, so that a step is told as well as the inverse bears. */
static double step_back(ric_augmented *x, const ric_lu *lu, arb_srcptr F, double *step)
{
    double size = 0, *f = step + x->n;
    arb_t y;
    arb_init(y);
    for (slong i = 0; i < x->n; i++) f[i] = ric_arb_middle(F + i);
    ric_lu_solve(lu, f, step);
    for (slong i = 0; i < x->n; i++) {
        if (!(fabs(step[i]) <= size)) size = fabs(step[i]);
        arb_set_d(y, step[i]);
        arb_sub(x->z + i, x->z + i, y, x->e->prec);
        arb_get_mid_arb(x->z + i, x->z + i);
    }
    arb_clear(y);
    return size;
}

/* Newton's method with factors in doubles, which are made again where they do not do: each step has
 * as many digits more as they bear. */
static bool refine_quickly(ric_augmented *x, arb_mat_t J, arb_ptr F)
{
    const double last = ldexp(1, 12 - (int)x->e->prec), noise = ldexp(1, 32 - (int)x->e->prec);
    double *step = flint_malloc(2 * (size_t)x->n * sizeof *step), before = HUGE_VAL;
    bool done = false, good = true, fresh = false;
    ric_lu lu;
    ric_lu_create(&lu, x->n);
    for (int k = 0; k < CHORD && good && !done; k++) {
        ric_augmented_evaluate(x, x->z, J, F);
        if (!fresh) good = ric_lu_make(&lu, J);
        const double size = good ? step_back(x, &lu, F, step) : HUGE_VAL;
        fresh = size < ldexp(before, SLOW);
        done = size < last || (size > before / 2 && before < noise);
        good = good && isfinite(size) && (k < FIRST || size < before / 2);
        before = size;
    }
    ric_lu_free(&lu);
    flint_free(step);
    return done;
}

/* The same with all digits, until steps no longer shrink. */
static bool refine_widely(ric_augmented *x, arb_mat_t J, arb_ptr F)
{
    arb_mat_t b;
    arb_mat_init(b, x->n, 1);
    double before = HUGE_VAL;
    bool done = true;
    for (int step = 0; step < NEWTON && done; step++) {
        double size = 0;
        ric_augmented_evaluate(x, x->z, J, F);
        arb_mat_get_mid(J, J);
        for (slong i = 0; i < x->n; i++) arb_get_mid_arb(arb_mat_entry(b, i, 0), F + i);
        done = arb_mat_approx_solve(b, J, b, x->e->prec);
        for (slong i = 0; i < x->n && done; i++)
            size = fmax(size, fabs(ric_arb_middle(arb_mat_entry(b, i, 0))));
        if (!done || !isfinite(size) || (step > FIRST && size > before / 2)) break;
        for (slong i = 0; i < x->n; i++) {
            arb_sub(x->z + i, x->z + i, arb_mat_entry(b, i, 0), x->e->prec);
            arb_get_mid_arb(x->z + i, x->z + i);
        }
        before = size;
        if (size < ldexp(1, 12 - (int)x->e->prec)) break;
    }
    arb_mat_clear(b);
    return done && before < CONVERGED;
}

/* Whether an inverse in doubles is one where the way begins, so that more digits would take the
 * same way. */
static bool is_sound(ric_augmented *x, arb_mat_t J, arb_ptr F)
{
    ric_augmented_evaluate(x, x->z, J, F);
    if (!ric_contraction_invert_quickly(&x->k, J)) return false;
    ric_contraction_defect(&x->k, J);
    return ric_contraction_left(&x->k) < RIC_CONTRACTION_EVEN;
}

static bool refine(ric_augmented *x, arb_mat_t J, arb_ptr F)
{
    arb_ptr start = _arb_vec_init(x->n);
    _arb_vec_set(start, x->z, x->n);
    bool done = refine_quickly(x, J, F);
    if (!done) _arb_vec_set(x->z, start, x->n);
    if (!done && !is_sound(x, J, F)) done = refine_widely(x, J, F);
    _arb_vec_clear(start, x->n);
    return done;
}

/* NULL, or why there is none. Where motions from doubles lead to none, those with all digits may:
 * it is singular where frequencies are far apart, too. */
static const char *find_near(ric_augmented *x, arb_mat_t J, arb_ptr F)
{
    arb_ptr start = _arb_vec_init(x->n);
    const char *why = NULL;
    _arb_vec_set(start, x->z, x->n);
    for (int widely = 0; widely < 2; widely++) {
        _arb_vec_set(x->z, start, x->n);
        why = NULL;
        if (ric_augmented_motions(x) && !find_motions(x, widely, J, F))
            why = "its equations are singular beyond what a junction makes them";
        else if (!refine(x, J, F)) why = "no junction of this kind was found from it";
        if (!why || !ric_augmented_motions(x)) break;
    }
    _arb_vec_clear(start, x->n);
    return why;
}

/* z with all of a box; the radii of k.b. */
static void place_box(const ric_augmented *x, arb_ptr box)
{
    _arb_vec_set(box, x->z, x->n);
    for (slong i = 0; i < x->n; i++) arb_add_error_mag(box + i, x->k.b + i);
}

/* The least box, of one radius, that is taken into itself with Z of the larger one around it. */
static bool tighten(ric_augmented *x)
{
    mag_t radius;
    mag_init(radius);
    mag_set_ui_2exp_si(radius, 1, 4 - x->e->prec);
    for (slong i = 0; i < x->n; i++) mag_max(radius, radius, x->k.y + i);
    bool tight = false;
    for (int k = 0; k < TIGHT && !tight; k++) {
        mag_mul_2exp_si(radius, radius, 1);
        for (slong i = 0; i < x->n; i++) mag_set(x->k.b + i, radius);
        tight = ric_contraction_holds(&x->k);
    }
    mag_clear(radius);
    return tight;
}

/* Whether the box of radius 2^-width is taken into itself, with y. */
static bool box_holds(ric_augmented *x, int width, arb_mat_t J, arb_ptr F, arb_ptr box)
{
    const ric_enclosure *e = x->e, coarse = ric_enclosure_coarse(e);
    for (slong i = 0; i < x->n; i++) mag_set_ui_2exp_si(x->k.b + i, 1, -width);
    place_box(x, box);
    x->e = &coarse;
    ric_augmented_evaluate(x, box, J, F);
    x->e = e;
    ric_contraction_defect(&x->k, J);
    return ric_contraction_holds(&x->k);
}

/* How many halvings of a box Z asks for that is `left` on it, if it is that of the radius, and not
 * of its square. */
static int halvings(double left)
{
    enum { MOST = 8 };
    const double share = log2(left) / 2;
    return !(share < MOST) ? MOST : share > 1 ? (int)share : 1;
}

/* The largest box, of one radius, that is taken into itself: Z, which it then leaves behind, grows
 * with the box, so that it lies between one that is too large and one that is not. */
static bool find_box(ric_augmented *x, arb_mat_t J, arb_ptr F, arb_ptr box)
{
    int large = WIDEST - 1, small = FINEST + 1, width = WIDEST;
    bool holds = false;
    while (small - large > 1) {
        holds = box_holds(x, width, J, F, box);
        const double left = ric_contraction_left(&x->k);
        if (holds) small = width;
        else large = width;
        width += holds ? -halvings(1 / left) : halvings(left);
        if (width <= large) width = large + 1;
        if (width >= small) width = small - 1;
    }
    if (!holds && small <= FINEST) holds = box_holds(x, small, J, F, box);
    arb_one(x->unique);
    arb_mul_2exp_si(x->unique, x->unique, -small);
    return holds;
}

static bool contracts(ric_augmented *x, arb_mat_t J, arb_ptr F)
{
    arb_ptr box = _arb_vec_init(x->n);
    bool holds = false;
    ric_augmented_evaluate(x, x->z, J, F);
    if (ric_contraction_invert(&x->k, J, RIC_CONTRACTION_EVEN)) {
        ric_contraction_apply(&x->k, F, box);
        for (slong i = 0; i < x->n; i++) arb_get_mag(x->k.y + i, box + i);
        holds = find_box(x, J, F, box);
    }
    const bool tight = holds && tighten(x);
    if (tight) place_box(x, box);
    if (tight) _arb_vec_swap(x->z, box, x->n);
    if (tight && x->ask.kind == RIC_AUGMENTED_MEET)
        arb_zero(x->z + (slong)x->ask.place * x->c.size + 2 * x->e->n);
    _arb_vec_clear(box, x->n);
    return tight;
}

/* With both mirrors broken a row at the end is left out: what it says, that the energy of the
 * motion is that of the orbit to first order, follows for orbits in the balls u where this number
 * is not zero. */
static bool row_follows(const ric_augmented *x, arb_srcptr u)
{
    const ric_enclosure *e = x->e;
    const slong n = e->n, last = (slong)(x->c.m - 1) * x->c.size;
    if (x->redundant < 0) return true;
    arb_srcptr w = u + last;
    ric_augmented_flight g;
    arb_t y, error;
    arb_init(y);
    arb_init(error);
    ric_augmented_flight_open(&g, e, x->c.phase[x->c.m - 1], w, w + 2 * n, NULL);
    arb_srcptr flown = g.flown;
    if (x->c.end == RIC_CHAIN_IMPACT) ric_chain_along(e, x->c.face[x->c.m], flown + n, y);
    else if (x->c.end == RIC_CHAIN_CENTRE) arb_set(y, flown + n + x->redundant);
    else {
        arb_ptr pull = _arb_vec_init(n);
        ric_chain_pull(e, x->c.phase[x->c.m - 1], flown, pull);
        arb_set(y, pull + x->redundant);
        _arb_vec_clear(pull, n);
    }
    const bool done = arb_is_positive(y) || arb_is_negative(y);
    arb_clear(y);
    arb_clear(error);
    ric_augmented_flight_close(&g);
    return done;
}

/* ---------------------------------------------------------------- directions */

/* Along the motion at a state: (p, p'). */
static void put_gauge(ric_augmented *x, int end, const ric_phase *phase, arb_srcptr w)
{
    const slong n = x->e->n;
    arb_ptr pull = _arb_vec_init(n);
    ric_chain_pull(x->e, phase, w, pull);
    for (slong i = 0; i < n; i++) {
        arb_get_mid_arb(arb_mat_entry(x->gauge, end, i), w + n + i);
        arb_get_mid_arb(arb_mat_entry(x->gauge, end, n + i), pull + i);
    }
    _arb_vec_clear(pull, n);
}

static int largest(arb_srcptr x, slong n)
{
    int at = 0;
    for (slong i = 1; i < n; i++)
        if (fabs(ric_arb_middle(x + i)) > fabs(ric_arb_middle(x + at))) at = (int)i;
    return at;
}

static void lay_directions(ric_augmented *x)
{
    const slong n = x->e->n;
    const ric_augmented_question *ask = &x->ask;
    arb_srcptr w = ric_chain_block(&x->c, x->c.m - 1);
    arb_ptr flown = _arb_vec_init(2 * n);
    ric_chain_fly(x->e, x->c.phase[x->c.m - 1], w, w + 2 * n, flown);
    put_gauge(x, 0, x->c.phase[0], x->c.u);
    put_gauge(x, 1, x->c.phase[x->c.m - 1], flown);
    x->redundant = -1;
    if (ask->kind == RIC_AUGMENTED_BREAK && ask->broken[0] && ask->broken[1]) {
        arb_srcptr gauge = arb_mat_entry(x->gauge, 1, 0);
        x->redundant = x->c.end == RIC_CHAIN_IMPACT
                           ? (int)n
                           : largest(x->c.end == RIC_CHAIN_REST ? gauge + n : gauge, n);
    }
    _arb_vec_clear(flown, 2 * n);
}

static void open_system(ric_augmented *x, const ric_chain *c, const ric_enclosure *e,
                        const ric_augmented_question *ask)
{
    *x = (ric_augmented){.e = e, .ask = *ask, .times = 1};
    x->together = flint_calloc((size_t)e->n_contact, sizeof *x->together);
    ric_chain_copy(&x->c, c);
    x->n_orbit = (slong)c->m * c->size + ric_chain_general(c);
    x->n_motion = ask->kind <= RIC_AUGMENTED_PERIOD ? x->n_orbit : (slong)c->m * c->size;
    x->n = x->n_orbit + ric_augmented_motions(x) * x->n_motion +
           (ask->kind == RIC_AUGMENTED_TOUCH || ric_augmented_has_factor(x));
    x->z = _arb_vec_init(x->n);
    x->l = _arb_vec_init(x->n - x->n_orbit + 1);
    arb_mat_init(x->gauge, 2, 2 * e->n);
    arb_init(x->exists);
    arb_init(x->unique);
    ric_contraction_create(&x->k, x->n, e->prec);
    _arb_vec_set(x->z, c->u, x->n_orbit);
    if (ask->kind == RIC_AUGMENTED_TOUCH) arb_set_d(x->z + x->n_orbit, ask->time);
}

/* E > 0 and |lambda| < 1 close chains. */
static bool closes(const ric_augmented *x)
{
    arb_t y;
    arb_init(y);
    ric_chain_energy(x->e, x->c.phase[0], x->z, y);
    const bool done = arb_is_positive(y) && ric_chain_closes(&x->c, x->e, x->z);
    arb_clear(y);
    return done;
}

/* Whether the polynomial has one root alone within r of 0: the linear term is larger than all
 * others together on that circle (Rouche). */
static bool has_one_root(const acb_poly_t p, const arb_t r, slong prec)
{
    arb_t rest, size, power, linear;
    arb_init(rest);
    arb_init(size);
    arb_init(linear);
    arb_init(power);
    arb_one(power);
    for (slong k = 0; k < acb_poly_length(p); k++) {
        acb_abs(size, acb_poly_get_coeff_ptr(p, k), prec);
        arb_mul(size, size, power, prec);
        if (k == 1) arb_set(linear, size);
        else arb_add(rest, rest, size, prec);
        arb_mul(power, power, r, prec);
    }
    const bool one = arb_gt(linear, rest);
    arb_clear(rest);
    arb_clear(size);
    arb_clear(linear);
    arb_clear(power);
    return one;
}

/* A multiplier (1 + mu) exp(2 i g) has exp(2 i g) / (1 + mu) beside it, and both are one where the
 * return has one multiplier alone as near: mu = 0. Of two modes that is so, as there are no others.
 */
static bool stays_on_circle(const ric_augmented *x)
{
    const slong n = 2 * x->e->n, prec = x->e->prec;
    bool alone = false;
    arb_mat_t H;
    arb_poly_t p;
    acb_poly_t q;
    acb_t turn;
    arb_t off, r;
    arb_mat_init(H, n, n);
    arb_poly_init(p);
    acb_poly_init(q);
    acb_init(turn);
    arb_init(off);
    arb_init(r);
    ric_monodromy_map(&x->c, x->e, x->z, H);
    arb_mat_charpoly(p, H, prec);
    acb_poly_set_arb_poly(q, p);
    arb_set_si(off, 2 * x->ask.p);
    arb_div_si(off, off, x->ask.q, prec);
    arb_sin_cos_pi(acb_imagref(turn), acb_realref(turn), off, prec);
    acb_poly_taylor_shift(q, q, turn, prec);
    arb_abs(off, x->z + x->n - 1);
    arb_mul_2exp_si(off, off, 1);
    for (int k = 1; k <= NARROW && !alone; k++) {
        arb_one(r);
        arb_mul_2exp_si(r, r, -k);
        alone = arb_lt(off, r) && has_one_root(q, r, prec);
    }
    arb_mat_clear(H);
    arb_poly_clear(p);
    acb_poly_clear(q);
    acb_clear(turn);
    arb_clear(off);
    arb_clear(r);
    return alone;
}

static const char *prove(ric_augmented *x, arb_mat_t J, arb_ptr F)
{
    const double work = 10 * pow((double)x->n, 3);
    if (ric_halt(work)) return "stopped";
    const char *why = find_near(x, J, F);
    if (why) return why;
    if (ric_halt(work)) return "stopped";
    if (!contracts(x, J, F)) return "its equations are not proved to be regular";
    if (!closes(x)) return "the energy is not proved to be positive";
    if (ric_augmented_has_factor(x) && x->e->n != 2 && !stays_on_circle(x))
        return "other multipliers may be as near";
    return row_follows(x, x->z) ? NULL : "at the broken mirror the motion is not told from rest";
}

bool ric_augmented_prove(ric_augmented *x, const ric_chain *c, const ric_enclosure *e,
                         const ric_augmented_question *ask)
{
    arb_mat_t J;
    open_system(x, c, e, ask);
    lay_directions(x);
    arb_ptr F = _arb_vec_init(x->n);
    arb_mat_init(J, x->n, x->n);
    x->why = prove(x, J, F);
    for (slong i = 0; i < x->n_orbit; i++) {
        arb_get_mid_arb(x->c.u + i, x->z + i);
        mag_t radius;
        arb_t r;
        mag_init(radius);
        arb_init(r);
        mag_set(radius, arb_radref(x->z + i));
        arf_set_mag(arb_midref(r), radius);
        arb_max(x->exists, x->exists, r, e->prec);
        mag_clear(radius);
        arb_clear(r);
    }
    arb_mat_clear(J);
    _arb_vec_clear(F, x->n);
    return !x->why;
}

void ric_augmented_free(ric_augmented *x)
{
    if (!x->z) return;
    _arb_vec_clear(x->l, x->n - x->n_orbit + 1);
    _arb_vec_clear(x->z, x->n);
    arb_mat_clear(x->gauge);
    arb_clear(x->exists);
    arb_clear(x->unique);
    flint_free(x->together);
    ric_contraction_free(&x->k);
    ric_chain_free(&x->c);
    x->z = NULL;
}
