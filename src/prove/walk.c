#include "walk.h"

#include "base/room.h"

ric_status ric_walk_point(ric_walk *w, int i, ric_point *stored)
{
    return ric_atlas_point(w->p->atlas, w->branch.id, i, stored, w->state,
                           w->state + 2 * w->e->n_dof);
}

ric_status ric_walk_open(ric_walk *w, ric_prover *p, int id, int level)
{
    *w = (ric_walk){.p = p, .e = ric_prover_enclosure(p, level)};
    ric_status status = ric_atlas_branch(p->atlas, id, &w->branch);
    if (status) return status;
    w->state = ric_calloc((size_t)(2 * w->e->n_dof + w->branch.letters + 1), sizeof *w->state);
    return w->state ? RIC_OK : ric_no_memory("a proof");
}

ric_status ric_walk_class(ric_walk *w)
{
    ric_point stored;
    const ric_status status = ric_walk_point(w, w->branch.n_point / 2, &stored);
    ric_chain_free(&w->like);
    if (!status) ric_chain_create(&w->like, w->e, &w->branch, w->state, w->state + 2 * w->e->n_dof);
    return status;
}

ric_status ric_walk_chain(ric_walk *w, int i, ric_chain *out, bool *made)
{
    ric_point stored;
    const ric_status status = ric_walk_point(w, i, &stored);
    *made = !status &&
            ric_chain_like(out, w->e, &w->branch, w->state, w->state + 2 * w->e->n_dof, &w->like);
    return status;
}

ric_status ric_walk_between(ric_walk *w, double at, ric_chain *out, bool *made)
{
    ric_point a = {0}, b = {0};
    ric_status status = RIC_OK;
    int i = 0;
    *made = false;
    while (!status && i < w->branch.n_point && !(status = ric_walk_point(w, i, &b)) &&
           b.arclength < at) {
        a = b;
        i++;
    }
    if (status || i == 0 || i == w->branch.n_point) return status;
    ric_chain other = {0};
    bool both = false;
    status = ric_walk_chain(w, i - 1, out, made);
    if (!status) status = ric_walk_chain(w, i, &other, &both);
    *made = *made && both && ric_chain_same_class(out, &other);
    arb_t share, x;
    arb_init(share);
    arb_init(x);
    arb_set_d(share, (at - a.arclength) / (b.arclength - a.arclength));
    for (slong k = 0; k < (slong)out->m * out->size && *made; k++) {
        arb_sub(x, other.u + k, out->u + k, w->e->prec);
        arb_addmul(out->u + k, x, share, w->e->prec);
        arb_get_mid_arb(out->u + k, out->u + k);
    }
    arb_clear(share);
    arb_clear(x);
    ric_chain_free(&other);
    return status;
}

void ric_walk_close(ric_walk *w)
{
    ric_chain_free(&w->like);
    free(w->state);
}
