#include "rows.h"
#include "base/room.h"

#include <stdlib.h>
#include <string.h>

#include "rows_parts.h"

/* Whether a run starts at a mode. */
static bool started(const ric_explore_options *o, int mode)
{
    bool wanted = o->n_start == 0;
    for (int j = 0; j < o->n_start; j++) wanted |= o->start[j] == mode + 1;
    return wanted;
}

/* Whether the linear mode that grazes at a node was reached from there. */
static bool departed(const ric_node *node)
{
    for (int i = 0; i < node->n_departure; i++)
        if (ric_node_impacts(node, node->departures[i].choice) == 0)
            return node->departures[i].state == RIC_DEPARTURE_KNOWN ||
                   node->departures[i].state == RIC_DEPARTURE_TAKEN;
    return false;
}

static ric_status linear_rows(const ric_graph *g, ric_branch_row *branches, int *n,
                              ric_junction_row *junctions, int *n_junction)
{
    const ric_model *m = g->model;
    double *energy = ric_calloc((size_t)m->n_dof, sizeof *energy);
    int *contact = ric_calloc((size_t)m->n_dof, sizeof *contact);
    ric_status status = energy && contact ? ric_model_grazing_energies(m, energy, contact)
                                          : ric_no_rows();
    for (int i = 0; i < m->n_dof && !status; i++) {
        int seen = -1, node = -1;
        for (int k = 0; k < m->n; k++)
            if (m->mode[k] == i) seen = k;
        if (!ric_model_detached(m) && seen >= 0) continue; /* its branch is traced */
        for (int k = 0; k < g->n_node; k++)
            if (seen >= 0 && g->nodes[k]->mode == seen && g->nodes[k]->multiple == 1) node = k;
        if (m->frequency[i] == 0 || ric_joined_parts(m, i) ||
            !(started(g->options, i) || (node >= 0 && departed(g->nodes[node]))))
            continue;
        status = ric_branch_row_linear(m, g->options, i, seen, node,
                                       seen >= 0 ? energy[i] : HUGE_VAL, &branches[*n]);
        if (!started(g->options, i)) branches[*n].record.row.depth = g->nodes[node]->depth + 1;
        if (!status) status = ric_junction_row_energies(g, i, &branches[*n], junctions, n_junction);
        (*n)++;
    }
    free(energy);
    free(contact);
    return status;
}

/* Whether a start has a branch that could not be followed, which its row says. */
static bool is_refused(const ric_node *node)
{
    bool refused = false;
    for (int i = 0; i < node->n_departure; i++)
        refused |= node->departures[i].state == RIC_DEPARTURE_REFUSED;
    return refused && node->kind == RIC_KIND_START;
}

/* The nodes that some branch meets, or that belong to a mode, and starts that were refused. */
static void find_used(const ric_graph *g, bool *used)
{
    for (int i = 0; i < g->n_node; i++)
        used[i] = g->nodes[i]->mode >= 0 || g->nodes[i]->mixture >= 0 || is_refused(g->nodes[i]);
    for (int i = 0; i < g->n_edge; i++) {
        const ric_edge *e = &g->edges[i];
        if (e->from >= 0) used[e->from] = true;
        if (e->to >= 0) used[e->to] = true;
        for (int k = 0; k < e->n_inner; k++) used[e->inner[k].node] = true;
    }
}

/* Branch `id` meets junction k; branches come in order. */
static ric_status list_branch(ric_junction_row *k, int id)
{
    ric_junction_record *r = &k->record;
    if (r->row.n_branch > 0 && r->branches[r->row.n_branch - 1] == id) return RIC_OK;
    int *grown = ric_realloc(r->branches, (size_t)(r->row.n_branch + 1) * sizeof *grown);
    if (!grown) return ric_no_rows();
    r->row.branches = r->branches = grown;
    r->branches[r->row.n_branch++] = id;
    return RIC_OK;
}

/* For each junction the branches that meet there. `junctions` lie in the order of ids. */
static ric_status list_branches(ric_junction_row *junctions, int n, const ric_branch_row *branches,
                                const int *id)
{
    ric_status status = RIC_OK;
    for (int i = 0; i < n && !status; i++) {
        const ric_branch_row *s = &branches[i];
        if (s->from >= 0) status = list_branch(&junctions[id[s->from] - 1], i + 1);
        if (s->to >= 0 && !status) status = list_branch(&junctions[id[s->to] - 1], i + 1);
        for (int j = 0; j < s->record.row.n_junction && !status; j++)
            if (ric_branch_row_passed(s, j) >= 0)
                status = list_branch(&junctions[id[ric_branch_row_passed(s, j)] - 1], i + 1);
    }
    return status;
}

static void note_ends(ric_branch_row *s, const int *id)
{
    const ric_edge *e = s->edge;
    if (!e) return;
    const int ends[4] = {e->from >= 0 ? id[e->from] : 0, (int)e->leave, e->to >= 0 ? id[e->to] : 0,
                         (int)e->arrive};
    memcpy(s->ends, ends, sizeof ends);
}

static void link_branches(int n, ric_branch_row *branches, const int *id)
{
    for (int i = 0; i < n; i++) {
        ric_branch_record *r = &branches[i].record;
        r->row.id = i + 1;
        r->row.from = branches[i].from >= 0 ? id[branches[i].from] : 0;
        r->row.to = branches[i].to >= 0 ? id[branches[i].to] : 0;
        for (int k = 0; k < r->row.n_junction; k++)
            r->junctions[k] = id[ric_branch_row_passed(&branches[i], k)];
    }
}

/* Rows are made one by one from what is finished: by all workers, while one keeps the work itself,
 * which stays even if the tables cannot be written. */
typedef struct {
    const ric_graph *graph;
    ric_branch_row *branches;
    ric_junction_row *junctions;
} making;

static ric_status make_row(void *user, int i)
{
    const making *s = user;
    const ric_graph *g = s->graph;
    if (i == 0) return g->store ? ric_store_commit(g->store) : RIC_OK;
    if (--i < g->n_edge) return ric_branch_row_make(g, &g->edges[i], &s->branches[i]);
    ric_junction_row *row = &s->junctions[i - g->n_edge];
    return ric_junction_row_make(g->model, g->nodes[row->index], row->index, row);
}

/* Junctions are numbered, and branches in the order of what they meet. */
static ric_status put_in_order(int n_junction, ric_junction_row *junctions, int n_branch,
                               ric_branch_row *branches, int *id)
{
    qsort(junctions, (size_t)n_junction, sizeof *junctions, ric_junction_row_order);
    for (int i = 0; i < n_junction; i++) {
        junctions[i].record.row.id = i + 1;
        id[junctions[i].index] = i + 1;
    }
    for (int i = 0; i < n_branch; i++) note_ends(&branches[i], id);
    qsort(branches, (size_t)n_branch, sizeof *branches, ric_branch_row_order);
    link_branches(n_branch, branches, id);
    return list_branches(junctions, n_branch, branches, id);
}

/* All records come into the atlas; what fails leaves them in the rows. */
static ric_status take_records(int n, const ric_branch_row *branches, int n_junction,
                               const ric_junction_row *junctions, ric_atlas *atlas)
{
    atlas->branches = ric_calloc((size_t)n + 1, sizeof *atlas->branches);
    atlas->junctions = ric_calloc((size_t)n_junction + 1, sizeof *atlas->junctions);
    if (!atlas->branches || !atlas->junctions) return ric_no_rows();
    for (int i = 0; i < n; i++) atlas->branches[i] = branches[i].record;
    for (int i = 0; i < n_junction; i++) atlas->junctions[i] = junctions[i].record;
    atlas->n_branch = n;
    atlas->n_junction = n_junction;
    return RIC_OK;
}

typedef struct {
    ric_store *store; /* NULL: where points are laid out later */
    ric_atlas *atlas;
} finishing;

/* What needs no labels. */
static ric_status finish_part(void *user, int part)
{
    const finishing *s = user;
    if (part == 1) return ric_keys_make(s->atlas);
    return s->store ? ric_store_stage_points(s->store, s->atlas) : RIC_OK;
}

/* With workers the points of branches, which have their ids, are laid out for the store while
 * junctions get their names: that takes one of them longest, so that it comes first. */
static ric_status finish_rows(ric_graph *g, const ric_junction_row *junctions, ric_atlas *atlas)
{
    finishing work = {g->n_worker > 1 ? g->store : NULL, atlas};
    const ric_rows_task first = {2, finish_part, &work};
    ric_status status = ric_junction_rows_measure(g, junctions, atlas, &first);
    if (!status) status = ric_junction_labels_give(g->labels, atlas);
    if (!status) status = ric_links_make(atlas);
    if (status && g->store) ric_store_stage_drop(g->store);
    return status;
}

ric_status ric_rows_make(ric_graph *g, const ric_study *study, bool finished, ric_atlas **out)
{
    ric_status status = RIC_OK;
    const ric_model *m = g->model;
    int n_branch = 0, n_junction = 0;
    ric_branch_row *branches = ric_calloc((size_t)(g->n_edge + m->n_dof), sizeof *branches);
    size_t most = (size_t)g->n_node + (size_t)m->n_dof * (size_t)g->limits.n_asked + 1;
    ric_junction_row *junctions = ric_calloc(most, sizeof *junctions);
    int *id = ric_calloc(most, sizeof *id);
    bool *used = ric_calloc(most, sizeof *used);
    ric_atlas *atlas = ric_calloc(1, sizeof *atlas);
    *out = NULL;
    if (!branches || !junctions || !id || !used || !atlas) {
        status = ric_no_rows();
        goto out;
    }
    if ((status = linear_rows(g, branches, &n_branch, junctions, &n_junction))) goto out;
    making work = {.graph = g,
                   .branches = branches + n_branch,
                   .junctions = junctions + n_junction};
    n_branch += g->n_edge;
    find_used(g, used);
    for (int i = 0; i < g->n_node; i++)
        if (used[i]) junctions[n_junction++].index = i;
    const int n_made = 1 + g->n_edge + (int)(junctions + n_junction - work.junctions);
    if ((status = ric_together(g->n_worker, n_made, make_row, &work))) goto out;
    if ((status = put_in_order(n_junction, junctions, n_branch, branches, id))) goto out;
    if ((status = ric_junction_rows_name(study, n_junction, junctions))) goto out;
    atlas->finished = finished;
    if ((status = ric_study_copy(study, &atlas->study))) goto out;
    if ((status = take_records(n_branch, branches, n_junction, junctions, atlas))) goto out;
    n_branch = n_junction = 0;
    for (int i = 0; i < g->n_edge; i++) {
        atlas->n_unplaced += g->edges[i].n_unplaced;
        atlas->n_blind += g->edges[i].trace->blind > 0;
    }
    if ((status = finish_rows(g, junctions, atlas))) goto out;
    *out = atlas;
    atlas = NULL;
out:
    for (int i = 0; branches && i < n_branch; i++)
        ric_atlas_branch_record_free(&branches[i].record);
    for (int i = 0; junctions && i < n_junction; i++)
        ric_atlas_junction_record_free(&junctions[i].record);
    free(branches);
    free(junctions);
    free(id);
    free(used);
    ric_atlas_free(atlas);
    return status;
}
