/* Families of branches: what a chain of junctions joins. Those that have no linear mode are
 * islands, which nothing but a search over an energy finds (docs/theory.md section 7). */
#include "links.h"

#include <stdlib.h>

#include "base/room.h"
#include "query.h"

/* The least branch, or its place in `up`, of the set that i belongs to (Tarjan 1975, with halving
 * of paths). */
static int root_of(int *up, int i)
{
    while (up[i] != i) i = up[i] = up[up[i]];
    return i;
}

static void join(int *up, int i, int j)
{
    i = root_of(up, i);
    j = root_of(up, j);
    if (i < j) up[j] = i;
    else up[i] = j;
}

/* Branch ids and, behind them, junction ids, both from 1. A grazing of which more than one multiple
 * is listed is one touch, gone through several times. */
static void join_all(const ric_atlas *a, int *up)
{
    for (int i = 0; i < a->n_branch; i++) {
        const ric_branch *b = &a->branches[i].row;
        if (b->from) join(up, b->id, a->n_branch + b->from);
        if (b->to) join(up, b->id, a->n_branch + b->to);
        for (int k = 0; k < b->n_junction; k++) join(up, b->id, a->n_branch + b->junctions[k]);
    }
    for (int i = 0; i < a->n_junction; i++) {
        const ric_junction *j = &a->junctions[i].row;
        const int once = j->multiple > 1 ? ric_query_twin(a, j, 1) : 0;
        for (int k = 0; k < j->n_branch; k++) join(up, j->branches[k], a->n_branch + j->id);
        if (once) join(up, a->n_branch + j->id, a->n_branch + once);
    }
}

ric_status ric_links_make(ric_atlas *a)
{
    const int n = a->n_branch + a->n_junction + 1;
    int *up = ric_calloc((size_t)n, sizeof *up);
    bool *has_mode = ric_calloc((size_t)n, sizeof *has_mode);
    const ric_status status = up && has_mode ? RIC_OK : ric_no_memory("the families of an atlas");
    for (int i = 0; i < n && !status; i++) up[i] = i;
    if (!status) join_all(a, up);
    for (int i = 0; i < a->n_branch && !status; i++)
        has_mode[root_of(up, a->branches[i].row.id)] |= a->branches[i].row.mode > 0;
    for (int i = 0; i < a->n_branch && !status; i++) {
        ric_branch *b = &a->branches[i].row;
        b->family = root_of(up, b->id);
        b->linked = has_mode[b->family];
    }
    free(up);
    free(has_mode);
    return status;
}
