#include "leaving.h"

#include "base/room.h"
#include "passage.h"

enum {
    LARGEST = 5,
    SMALLEST = 24, /* 2^-k: sizes that are tried */
    TRIES = 6,     /* boxes of each */
    NEWTON = 200,  /* steps towards the orbit at the end, with one derivative */
    TIGHT = 24     /* doublings of its radius */
};

typedef struct {
    ric_augmented *j;
    ric_contraction k;
    arb_mat_t J;
    arb_ptr F, box, centre;
    arb_t size;
} problem;

/* ------------------------------------------------------------------- the box */

static void place_box(problem *p)
{
    _arb_vec_set(p->box, p->centre, p->j->n);
    for (slong i = 0; i < p->j->n; i++) arb_add_error_mag(p->box + i, p->k.b + i);
}

/* y: at the centre, where all but vanishes what there is at e = 0. The mean adds e^2 / 2 G'' a a; the difference is G'
 * a and at most e / 2 times the radius of G'' a a, as its odd part cancels. */
static void bound_residual(problem *p)
{
    const ric_augmented *j = p->j;
    const slong n = j->n, N = j->n_orbit, prec = j->e->prec;
    arb_srcptr a = p->centre + N;
    arb_ptr F = _arb_vec_init(n), x = _arb_vec_init(n);
    arb_t y, radius;
    arb_init(y);
    arb_init(radius);
    ric_augmented_evaluate(p->j, p->centre, NULL, p->J, F);
    ric_augmented_evaluate(p->j, p->centre, p->size, p->J, x);
    for (slong i = 0; i < n - 1; i++) {
        if (i < N - 1) {
            arb_dot(y, NULL, 0, arb_mat_entry(p->J, i, N), 1, a, 1, j->n_motion, prec);
            arb_mul_2exp_si(y, y, -1);
            arb_zero(radius);
            arb_union(y, y, radius, prec); /* from e = 0 on */
            arb_add(F + i, F + i, y, prec);
        } else {
            arb_dot(y, NULL, 0, arb_mat_entry(p->J, i, 0), 1, a, 1, j->n_motion, prec);
            arf_set_mag(arb_midref(radius), arb_radref(y));
            mag_zero(arb_radref(radius));
            arb_mul(radius, radius, p->size, prec);
            arb_mul_2exp_si(radius, radius, -1);
            arb_add_error(F + i, radius);
        }
    }
    ric_contraction_apply(&p->k, F, x);
    for (slong i = 0; i < n; i++) arb_get_mag(p->k.y + i, x + i);
    arb_clear(y);
    arb_clear(radius);
    _arb_vec_clear(F, n);
    _arb_vec_clear(x, n);
}

static bool contracts(problem *p)
{
    const slong n = p->j->n;
    mag_t least;
    bool holds = false;
    bound_residual(p);
    mag_init(least);
    mag_set_ui_2exp_si(least, 1, 16 - p->j->e->prec);
    for (slong i = 0; i < n; i++) {
        mag_mul_2exp_si(p->k.b + i, p->k.y + i, 1);
        mag_max(p->k.b + i, p->k.b + i, least);
    }
    for (int i = 0; i < TRIES && !holds; i++) {
        place_box(p);
        ric_augmented_evaluate(p->j, p->box, p->size, p->J, p->F);
        ric_contraction_defect(&p->k, p->J);
        holds = ric_contraction_holds(&p->k);
    }
    mag_clear(least);
    return holds;
}

/* ------------------------------------------------------------------- the end */

/* u + by e a. */
static void place_half(const problem *p, arb_srcptr z, int by, arb_ptr out)
{
    const ric_augmented *j = p->j;
    _arb_vec_set(out, z, j->n_orbit);
    for (slong i = 0; i < j->n_motion; i++) {
        if (by > 0) arb_addmul(out + i, z + j->n_orbit + i, p->size, j->e->prec);
        else arb_submul(out + i, z + j->n_orbit + i, p->size, j->e->prec);
    }
}

/* G of one half [n_orbit - 1], and its state at the end [2n]. */
static void evaluate_half(problem *p, arb_srcptr z, int by, arb_ptr G, arb_ptr flown)
{
    ric_augmented *j = p->j;
    const slong n = j->e->n, last = (slong)(j->c.m - 1) * j->c.size;
    ric_equations q;
    arb_t slack, size;
    slong row = 0;
    place_half(p, z, by, j->c.u);
    ric_equation_create(&q, &j->c);
    ric_equation_evaluate(&q, &j->c, j->e);
    ric_equation_loosen(&q, &j->c, j->e, NULL);
    for (int i = 0; i < q.n - 1; i++)
        for (slong l = 0; l < q.group[i].rows; l++) arb_set(G + row++, arb_mat_entry(q.group[i].F, l, 0));
    ric_equation_free(&q);
    arb_init(slack);
    arb_init(size);
    ric_chain_fly(j->e, j->c.u + last, j->c.u + last + 2 * n, flown);
    ric_enclosure_slack(j->e, j->c.u + last + 2 * n, slack);
    ric_chain_norm(2 * n, j->c.u + last, j->e->prec, size);
    arb_mul(slack, slack, size, j->e->prec);
    for (slong i = 0; i < 2 * n; i++) arb_add_error(flown + i, slack);
    arb_clear(slack);
    arb_clear(size);
}

/* Rows of a mirror point on a difference. */
static slong put_mirror(const problem *p, bool last, arb_srcptr w, slong row, arb_ptr F)
{
    const ric_augmented *j = p->j;
    const bool broken = j->ask.broken[last];
    const slong n = j->e->n, rows = n + broken;
    arb_mat_t B;
    arb_mat_init(B, rows, 2 * n);
    ric_augmented_mirror(j, last, broken, B);
    for (slong l = 0; l < rows; l++) {
        if (last && l == j->redundant) continue;
        arb_dot(F + row++, NULL, 0, arb_mat_entry(B, l, 0), 1, w, 1, 2 * n, j->e->prec);
    }
    arb_mat_clear(B);
    return row;
}

/* The equations at e = size, in the order of those of the junction. */
static void evaluate_end(problem *p, arb_srcptr z, arb_ptr F)
{
    const ric_augmented *j = p->j;
    const slong N = j->n_orbit, n = j->e->n, prec = j->e->prec, links = (slong)(j->c.m - 1) * j->c.size;
    arb_ptr G = _arb_vec_init(2 * N), flown = _arb_vec_init(4 * n);
    arb_t twice;
    arb_init(twice);
    arb_mul_2exp_si(twice, p->size, 1);
    evaluate_half(p, z, 1, G, flown);
    evaluate_half(p, z, -1, G + N, flown + 2 * n);
    for (slong i = 0; i < N - 1; i++) {
        arb_add(F + i, G + i, G + N + i, prec);
        arb_mul_2exp_si(F + i, F + i, -1);
    }
    for (slong i = 0; i < links; i++) {
        arb_sub(F + N - 1 + i, G + i, G + N + i, prec);
        arb_div(F + N - 1 + i, F + N - 1 + i, twice, prec);
    }
    for (slong i = 0; i < 2 * n; i++) {
        arb_sub(flown + i, flown + i, flown + 2 * n + i, prec);
        arb_div(flown + i, flown + i, twice, prec);
    }
    slong row = put_mirror(p, false, z + N, N - 1 + links, F);
    row = put_mirror(p, true, flown, row, F);
    arb_dot(F + row, NULL, 0, j->l, 1, z + N, 1, j->n_motion, prec);
    arb_sub_ui(F + row, F + row, 1, prec);
    arb_clear(twice);
    _arb_vec_clear(G, 2 * N);
    _arb_vec_clear(flown, 4 * n);
}

/* The zero at e = size, as a small ball in the box, where Z holds: left in p->centre. */
static bool find_end(problem *p)
{
    const slong n = p->j->n;
    arb_ptr F = _arb_vec_init(n), x = _arb_vec_init(n), z = _arb_vec_init(n);
    mag_t radius;
    mag_init(radius);
    for (slong i = 0; i < n; i++) arb_get_mid_arb(z + i, p->box + i);
    for (int step = 0; step <= NEWTON; step++) {
        evaluate_end(p, z, F);
        ric_contraction_apply(&p->k, F, x);
        for (slong i = 0; i < n && step < NEWTON; i++) {
            arb_sub(z + i, z + i, x + i, p->j->e->prec);
            arb_get_mid_arb(z + i, z + i);
        }
    }
    mag_set_ui_2exp_si(radius, 1, 4 - p->j->e->prec);
    for (slong i = 0; i < n; i++) {
        arb_get_mag(p->k.y + i, x + i);
        mag_max(radius, radius, p->k.y + i);
    }
    bool tight = false;
    for (int i = 0; i < TIGHT && !tight; i++) {
        mag_mul_2exp_si(radius, radius, 1);
        for (slong l = 0; l < n; l++) mag_set(p->k.b + l, radius);
        tight = ric_contraction_holds(&p->k);
    }
    for (slong i = 0; i < n && tight; i++) {
        arb_add_error_mag(z + i, radius);
        tight = arb_contains(p->box + i, z + i);
    }
    if (tight) _arb_vec_set(p->centre, z, n);
    mag_clear(radius);
    _arb_vec_clear(F, n);
    _arb_vec_clear(x, n);
    _arb_vec_clear(z, n);
    return tight;
}

/* -------------------------------------------------------------------- motions */

/* All orbits of the arc: gaps, approach, and the row that was left out. */
static bool arc_stands(problem *p, ric_leaving *v)
{
    ric_augmented *j = p->j;
    const slong count = j->n_orbit;
    arb_ptr hull = _arb_vec_init(count);
    arb_t y;
    ric_passage passage;
    arb_init(y);
    _arb_vec_set(hull, p->box, count);
    for (slong i = 0; i < j->n_motion; i++) {
        arb_mul(y, p->box + count + i, p->size, j->e->prec);
        arb_add_error(hull + i, y);
    }
    ric_passage_init(&passage);
    ric_chain_energy(j->e, hull, y);
    const bool done = arb_is_positive(y) && ric_augmented_follows(j, hull) &&
                      ric_passage_prove(&passage, &j->c, j->e, &(ric_family){.hull = hull});
    v->approach = arf_get_d(arb_midref(passage.approach), ARF_RND_FLOOR);
    ric_passage_clear(&passage);
    arb_clear(y);
    _arb_vec_clear(hull, count);
    return done;
}

static bool try_size(problem *p, int size, ric_leaving *v)
{
    arb_set_si(p->size, 1);
    arb_mul_2exp_si(p->size, p->size, -size);
    for (slong i = 0; i < p->j->n; i++) arb_get_mid_arb(p->centre + i, p->j->z + i);
    if (!contracts(p) || !arc_stands(p, v) || !find_end(p)) return false;
    arb_set(v->size, p->size);
    place_half(p, p->centre, 1, v->x);
    place_half(p, p->centre, -1, v->y);
    return true;
}

bool ric_leaving_prove(ric_leaving *v, ric_augmented *junction)
{
    const slong n = junction->n;
    problem p = {.j = junction, .F = _arb_vec_init(n), .box = _arb_vec_init(n), .centre = _arb_vec_init(n)};
    bool done = false;
    *v = (ric_leaving){.count = junction->n_orbit};
    v->x = _arb_vec_init(v->count);
    v->y = _arb_vec_init(v->count);
    arb_init(v->size);
    arb_init(p.size);
    arb_mat_init(p.J, n, n);
    ric_contraction_create(&p.k, n, junction->e->prec);
    arb_mat_set(p.k.C, junction->k.C);
    for (int size = LARGEST; size <= SMALLEST && !done && junction->ask.kind == RIC_AUGMENTED_BREAK; size++)
        done = try_size(&p, size, v);
    for (slong i = 0; i < junction->n_orbit; i++) arb_get_mid_arb(junction->c.u + i, junction->z + i);
    ric_contraction_free(&p.k);
    arb_mat_clear(p.J);
    arb_clear(p.size);
    _arb_vec_clear(p.F, n);
    _arb_vec_clear(p.box, n);
    _arb_vec_clear(p.centre, n);
    return done;
}

void ric_leaving_free(ric_leaving *v)
{
    if (!v->x) return;
    _arb_vec_clear(v->x, v->count);
    _arb_vec_clear(v->y, v->count);
    arb_clear(v->size);
    v->x = NULL;
}
