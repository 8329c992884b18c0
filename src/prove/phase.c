#include "phase.h"

#include <string.h>

#include "base/room.h"
#include "basis.h"

struct ric_phase_list {
    int n;
    ric_phase **of; /* [n] */
};

/* -------------------------------------------------------------------- making */

/* L + sum k c c', and sum k d c [n]. */
static void press_together(const ric_phase *p, const ric_enclosure *e, arb_mat_t K, arb_ptr force)
{
    const slong prec = 2 * (e->prec + RIC_BASIS_GUARD);
    arb_t kc;
    arb_init(kc);
    arb_mat_zero(K);
    for (slong i = 0; i < e->n; i++) arb_set(arb_mat_entry(K, i, i), e->square + i);
    for (int f = 0; f < e->n_face; f++) {
        if (!ric_phase_closed(p, f)) continue;
        const ric_wall *wall = &e->wall[f];
        arb_srcptr c = ric_enclosure_c(e, wall->contact);
        for (slong i = 0; i < e->n; i++) {
            arb_mul(kc, wall->spring, c + i, prec);
            arb_addmul(force + i, kc, wall->gap, prec);
            for (slong j = 0; j < e->n; j++) arb_addmul(arb_mat_entry(K, i, j), kc, c + j, prec);
        }
    }
    arb_clear(kc);
}

/* The modes of the solver are where the refinement begins. */
static bool guess(const ric_phase *p, const ric_enclosure *e, ric_basis *z)
{
    const ric_regime *regime;
    if (ric_regime_get(e->model, p->closed, &regime)) return false;
    for (slong i = 0; i < (slong)e->n * e->n; i++)
        arb_set_d(arb_mat_entry(z->X, i / e->n, i % e->n), regime->U[i]);
    return true;
}

/* rest = (L + R + sum k c c')^-1 force; where a mode of the phase may be free any place is taken
 * that solves this exactly. */
static bool find_rest(ric_phase *p, const ric_enclosure *e, arb_mat_t K, arb_srcptr force)
{
    arb_mat_t f, x;
    bool firm = true;
    arb_mat_init(f, e->n, 1);
    arb_mat_init(x, e->n, 1);
    for (slong i = 0; i < e->n; i++) {
        arb_set(arb_mat_entry(f, i, 0), force + i);
        for (slong j = 0; j < e->n; j++) arb_add_error(arb_mat_entry(K, i, j), e->rho);
        firm = firm && arb_is_positive(p->e.omega + i);
    }
    firm = firm && arb_mat_solve(x, K, f, e->prec + RIC_BASIS_GUARD);
    for (slong i = 0; i < e->n && firm; i++) arb_set(p->rest + i, arb_mat_entry(x, i, 0));
    const bool rests = firm || ric_enclosure_rest(e, p->closed, p->rest);
    arb_mat_clear(f);
    arb_mat_clear(x);
    return rests;
}

/* NULL, or what is missing. */
static const char *enclose(ric_phase *p, const ric_enclosure *e)
{
    const char *why = NULL;
    ric_basis z;
    arb_mat_t K;
    arb_t error;
    arb_ptr force = _arb_vec_init(e->n);
    arb_init(error);
    arb_mat_init(K, e->n, e->n);
    ric_basis_open(&z, e->n, e->prec);
    press_together(p, e, K, force);
    arb_mat_one(z.M);
    arb_mat_set(z.K, K);
    bool done = guess(p, e, &z);
    if (done) {
        ric_squares squares = {p->e.omega, p->e.square, p->e.rho, p->e.top};
        ric_basis_refine(&z);
        arb_mat_set(p->V, z.X);
        done = ric_basis_orthonormalise(&z, p->V, error) && ric_basis_squares(&z, p->V, &squares);
        arb_add(p->e.rho, p->e.rho, e->rho, e->prec);
        arb_get_ubound_arf(arb_midref(p->e.rho), p->e.rho, e->prec);
        mag_zero(arb_radref(p->e.rho));
    }
    if (!done) why = "the modes of the structure with closed springs are not enclosed";
    else if (!find_rest(p, e, K, force))
        why = "no place of rest with closed springs is found in rational numbers";
    arb_mat_transpose(p->back, p->V);
    arb_mat_mul(p->e.C, e->C, p->V, e->prec + RIC_BASIS_GUARD / 2);
    ric_basis_close(&z);
    arb_mat_clear(K);
    arb_clear(error);
    _arb_vec_clear(force, e->n);
    return why;
}

static ric_phase *make(const ric_enclosure *e, uint64_t closed)
{
    ric_phase *p = flint_calloc(1, sizeof *p);
    *p = (ric_phase){.closed = closed,
                     .e = {.prec = e->prec,
                           .model = e->model,
                           .n = e->n,
                           .n_contact = e->n_contact,
                           .time = e->time}};
    arb_mat_init(p->V, e->n, e->n);
    arb_mat_init(p->back, e->n, e->n);
    p->rest = _arb_vec_init(e->n);
    arb_mat_init(p->e.C, e->n_contact, e->n);
    p->e.omega = _arb_vec_init(e->n);
    p->e.square = _arb_vec_init(e->n);
    arb_init(p->e.rho);
    arb_init(p->e.top);
    p->why = enclose(p, e);
    return p;
}

const char *ric_phase_get(const ric_enclosure *e, uint64_t closed, const ric_phase **out)
{
    struct ric_phase_list *list = e->phases;
    *out = NULL;
    if (!closed) return NULL;
    if (!ric_regime_exists(e->model, closed))
        return "both sides of a contact would be closed at once";
    int i = 0;
    while (i < list->n && list->of[i]->closed != closed) i++;
    if (i == list->n) {
        list->of = flint_realloc(list->of, ((size_t)list->n + 1) * sizeof(ric_phase *));
        list->of[list->n++] = make(e, closed);
    }
    *out = list->of[i];
    return list->of[i]->why;
}

struct ric_phase_list *ric_phase_list_create(void)
{
    return flint_calloc(1, sizeof(struct ric_phase_list));
}

void ric_phase_list_free(struct ric_phase_list *list)
{
    for (int i = 0; i < list->n; i++) {
        ric_phase *p = list->of[i];
        arb_mat_clear(p->V);
        arb_mat_clear(p->back);
        _arb_vec_clear(p->rest, p->e.n);
        arb_mat_clear(p->e.C);
        _arb_vec_clear(p->e.omega, p->e.n);
        _arb_vec_clear(p->e.square, p->e.n);
        arb_clear(p->e.rho);
        arb_clear(p->e.top);
        flint_free(p);
    }
    flint_free(list->of);
    flint_free(list);
}

/* -------------------------------------------------------------------- states */

/* A [n * n] times both halves of w. */
static void turn(const arb_mat_t A, arb_srcptr w, arb_ptr out, slong prec)
{
    const slong n = arb_mat_nrows(A);
    for (slong half = 0; half < 2; half++)
        for (slong i = 0; i < n; i++)
            arb_dot(out + half * n + i, NULL, 0, arb_mat_entry(A, i, 0), 1, w + half * n, 1, n,
                    prec);
}

void ric_phase_turn(const ric_phase *p, arb_srcptr v, arb_ptr out)
{
    turn(p->back, v, out, p->e.prec);
}

void ric_phase_turn_back(const ric_phase *p, arb_srcptr v, arb_ptr out)
{
    turn(p->V, v, out, p->e.prec);
}

void ric_phase_enter(const ric_phase *p, arb_srcptr w, arb_ptr out)
{
    const slong n = p->e.n;
    arb_ptr away = _arb_vec_init(2 * n);
    _arb_vec_set(away, w, 2 * n);
    _arb_vec_sub(away, away, p->rest, n, p->e.prec);
    turn(p->back, away, out, p->e.prec);
    _arb_vec_clear(away, 2 * n);
}

void ric_phase_leave(const ric_phase *p, arb_srcptr z, arb_ptr out)
{
    turn(p->V, z, out, p->e.prec);
    _arb_vec_add(out, out, p->rest, p->e.n, p->e.prec);
}

void ric_phase_press(const ric_enclosure *e, int face, arb_srcptr q, arb_t out)
{
    const ric_wall *wall = &e->wall[face];
    arb_dot(out, NULL, 0, ric_enclosure_c(e, wall->contact), 1, q, 1, e->n, e->prec);
    arb_sub(out, out, wall->gap, e->prec);
    if (wall->side < 0) arb_neg(out, out);
}
