#include "walk.h"

#include "base/room.h"

ric_status ric_walk_point(ric_walk *w, int i, ric_point *stored)
{
    return ric_atlas_point(w->p->atlas, w->branch.id, i, stored, w->state, w->state + 2 * w->e->n_dof);
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
    if (!status) ric_chain_create(&w->like, w->e, &w->branch, w->state, w->state + 2 * w->e->n_dof);
    return status;
}

ric_status ric_walk_chain(ric_walk *w, int i, ric_chain *out, bool *made)
{
    ric_point stored;
    const ric_status status = ric_walk_point(w, i, &stored);
    *made = !status && ric_chain_like(out, w->e, &w->branch, w->state, w->state + 2 * w->e->n_dof, &w->like);
    return status;
}

void ric_walk_close(ric_walk *w)
{
    ric_chain_free(&w->like);
    free(w->state);
}
