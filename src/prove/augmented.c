#include "augmented.h"

#include <math.h>

#include "augmented_rows.h"
#include "base/room.h"

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
    TIGHT = 24   /* doublings of a radius of existence */
};

/* The motions beside the orbit, by inverse iteration: the rows on them are a square matrix that is
 * all but singular. */
static bool find_motions(ric_augmented *x, arb_mat_t J, arb_ptr F)
{
    const slong first = x->n_orbit, count = ric_augmented_motions(x) * x->n_motion;
    arb_mat_t A, b;
    slong *order = flint_malloc((size_t)count * sizeof *order);
    arb_mat_init(A, count, count);
    arb_mat_init(b, count, 1);
    ric_augmented_evaluate(x, x->z, J, F);
    for (slong i = 0; i < count; i++) {
        arb_set_si(arb_mat_entry(b, i, 0), 1 + i % 3);
        for (slong j = 0; j < count; j++)
            arb_get_mid_arb(arb_mat_entry(A, i, j), arb_mat_entry(J, first - 1 + i, first + j));
    }
    bool done = arb_mat_approx_lu(order, A, A, x->e->prec);
    for (int step = 0; step < POWER && done; step++) {
        arb_mat_approx_solve_lu_precomp(b, order, A, b, x->e->prec);
        done = ric_arb_normalise(b, x->e->prec);
    }
    for (slong i = 0; i < count && done; i++) {
        arb_set(x->z + first + i, arb_mat_entry(b, i, 0));
        arb_set(x->l + i, arb_mat_entry(b, i, 0));
    }
    flint_free(order);
    arb_mat_clear(A);
    arb_mat_clear(b);
    return done;
}

/* z <- z - C F, in balls that are cut to their middles; the largest number of that. */
static double step_back(ric_augmented *x, arb_srcptr F, arb_ptr step)
{
    double size = 0;
    ric_contraction_apply(&x->k, F, step);
    for (slong i = 0; i < x->n; i++) {
        arb_get_mid_arb(step + i, step + i);
        const double here = fabs(ric_arb_middle(step + i));
        if (!(here <= size)) size = here;
        arb_sub(x->z + i, x->z + i, step + i, x->e->prec);
        arb_get_mid_arb(x->z + i, x->z + i);
    }
    return size;
}

/* Newton's method with an inverse in doubles, which is made again where it does not do: F has all
 * digits, so that each step has as many more as the inverse bears. `sound`: the first inverse is
 * one, so that more digits would take the same way. */
static bool refine_quickly(ric_augmented *x, arb_mat_t J, arb_ptr F, bool *sound)
{
    const double last = ldexp(1, 12 - (int)x->e->prec), noise = ldexp(1, 32 - (int)x->e->prec);
    arb_ptr step = _arb_vec_init(x->n);
    double before = HUGE_VAL;
    bool done = false, good = true, fresh = false;
    *sound = false;
    for (int k = 0; k < CHORD && good && !done; k++) {
        ric_augmented_evaluate(x, x->z, J, F);
        if (!fresh) good = ric_contraction_invert_quickly(&x->k, J);
        if (k == 0 && good) ric_contraction_defect(&x->k, J);
        if (k == 0) *sound = good && ric_contraction_left(&x->k) < RIC_CONTRACTION_EVEN;
        const double size = good ? step_back(x, F, step) : HUGE_VAL;
        fresh = size < ldexp(before, SLOW);
        done = size < last || (size > before / 2 && before < noise);
        good = good && isfinite(size) && (k < FIRST || size < before / 2);
        before = size;
    }
    _arb_vec_clear(step, x->n);
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

static bool refine(ric_augmented *x, arb_mat_t J, arb_ptr F)
{
    arb_ptr start = _arb_vec_init(x->n);
    bool sound;
    _arb_vec_set(start, x->z, x->n);
    bool done = refine_quickly(x, J, F, &sound);
    if (!done && !sound) {
        _arb_vec_set(x->z, start, x->n);
        done = refine_widely(x, J, F);
    }
    _arb_vec_clear(start, x->n);
    return done;
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

static bool contracts(ric_augmented *x, arb_mat_t J, arb_ptr F)
{
    arb_ptr box = _arb_vec_init(x->n);
    bool holds = false;
    ric_augmented_evaluate(x, x->z, J, F);
    if (ric_contraction_invert(&x->k, J, RIC_CONTRACTION_EVEN)) {
        ric_contraction_apply(&x->k, F, box);
        for (slong i = 0; i < x->n; i++) arb_get_mag(x->k.y + i, box + i);
        for (int width = WIDEST; width <= FINEST && !holds; width++) {
            for (slong i = 0; i < x->n; i++) mag_set_ui_2exp_si(x->k.b + i, 1, -width);
            place_box(x, box);
            ric_augmented_evaluate(x, box, J, F);
            ric_contraction_defect(&x->k, J);
            holds = ric_contraction_holds(&x->k);
            arb_one(x->unique);
            arb_mul_2exp_si(x->unique, x->unique, -width);
        }
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

static const char *prove(ric_augmented *x, arb_mat_t J, arb_ptr F)
{
    const double work = 10 * pow((double)x->n, 3);
    if (ric_halt(work)) return "stopped";
    if (ric_augmented_motions(x) && !find_motions(x, J, F))
        return "its equations are singular beyond what a junction makes them";
    if (!refine(x, J, F)) return "no junction of this kind was found from it";
    if (ric_halt(work)) return "stopped";
    if (!contracts(x, J, F)) return "its equations are not proved to be regular";
    if (!closes(x)) return "the energy is not proved to be positive";
    if (ric_augmented_has_factor(x) && x->e->n != 2)
        return "a turn of a chain without mirrors, of more than two modes: not yet";
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
