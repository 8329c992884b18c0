#include "atlas.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "model/room.h"
#include "base/room.h"
#include "store.h"

static_assert(sizeof(ric_point) % sizeof(double) == 0,
              "points lie one after the other in an array of doubles");

/* NO_SHARE: of an arclength: that of a trace which rounding takes over its border, at the end of a
 * branch */
#define NO_SHARE 1e-12

/* ----------------------------------------------------------------- records */

void ric_atlas_branch_record_free(ric_branch_record *branch)
{
    if (!branch) return;
    free(branch->key);
    free(branch->label);
    free(branch->mirror);
    free(branch->why);
    free(branch->word);
    free(branch->junctions);
    free(branch->junction_at);
    free(branch->points);
    free(branch->gaps);
    *branch = (ric_branch_record){0};
}

void ric_atlas_junction_record_free(ric_junction_record *junction)
{
    if (!junction) return;
    free(junction->key);
    free(junction->label);
    free(junction->name);
    free(junction->refusal);
    free(junction->word);
    free(junction->branches);
    free(junction->state);
    free(junction->flights);
    *junction = (ric_junction_record){0};
}

size_t ric_atlas_point_stride(int n_dof, int letters)
{
    return sizeof(ric_point) / sizeof(double) + 2 * (size_t)n_dof +
           (size_t)(letters > 0 ? letters : 1);
}

/* ------------------------------------------------------------------- atlas */

bool ric_branch_linear(const ric_model *m, const ric_branch *b)
{
    return b->impacts == 0 && (ric_model_detached(m) || !(b->mode == 0 || m->seen[b->mode - 1]));
}

ric_status ric_atlas_read(const char *path, ric_atlas **out)
{
    return ric_store_read(path, out);
}

void ric_atlas_free(ric_atlas *atlas)
{
    if (!atlas) return;
    for (int i = 0; atlas->branches && i < atlas->n_branch; i++)
        ric_atlas_branch_record_free(&atlas->branches[i]);
    for (int i = 0; atlas->junctions && i < atlas->n_junction; i++)
        ric_atlas_junction_record_free(&atlas->junctions[i]);
    for (int i = 0; i < atlas->n_proof; i++) free(atlas->proofs[i].certificate);
    free(atlas->proofs);
    free(atlas->graph_proofs);
    for (int i = 0; i < atlas->n_arc; i++) free(atlas->arc_texts[i]);
    free(atlas->arcs);
    free(atlas->arc_texts);
    free(atlas->labels);
    free(atlas->branches);
    free(atlas->junctions);
    ric_study_free(atlas->study);
    free(atlas);
}

const ric_study *ric_atlas_study(const ric_atlas *atlas)
{
    return atlas->study;
}

const ric_model *ric_atlas_model(const ric_atlas *atlas)
{
    return ric_study_model(atlas->study);
}

bool ric_atlas_finished(const ric_atlas *atlas)
{
    return atlas->finished;
}

int ric_atlas_n_unplaced(const ric_atlas *atlas)
{
    return atlas->n_unplaced;
}

int ric_atlas_n_blind(const ric_atlas *atlas)
{
    return atlas->n_blind;
}

int ric_atlas_n_branch(const ric_atlas *atlas)
{
    return atlas->n_branch;
}

int ric_atlas_n_junction(const ric_atlas *atlas)
{
    return atlas->n_junction;
}

static ric_status check_id(const char *what, int id, int n)
{
    if (id >= 1 && id <= n) return RIC_OK;
    if (n == 0) return ric_fail(RIC_E_RANGE, "no %s %d: the atlas has none yet", what, id);
    return ric_fail(RIC_E_RANGE, "no %s %d: the numbers run from 1 to %d", what, id, n);
}

ric_status ric_atlas_branch(const ric_atlas *atlas, int id, ric_branch *out)
{
    ric_status status = check_id("branch", id, atlas->n_branch);
    if (status) return status;
    *out = atlas->branches[id - 1].row;
    if (out->stable_fraction < NO_SHARE) out->stable_fraction = 0;
    if (out->stable_fraction > 1 - NO_SHARE) out->stable_fraction = 1;
    return RIC_OK;
}

ric_status ric_atlas_junction(const ric_atlas *atlas, int id, ric_junction *out)
{
    ric_status status = check_id("junction", id, atlas->n_junction);
    if (!status) *out = atlas->junctions[id - 1].row;
    return status;
}

ric_point_row ric_atlas_point_row(const ric_atlas *atlas, int branch, int i)
{
    const ric_branch_record *record = &atlas->branches[branch - 1];
    const double *at = record->points + (size_t)i * record->stride,
                 *state = at + sizeof(ric_point) / sizeof *at;
    ric_point_row row = {.branch = branch,
                         .number = i,
                         .letters = record->row.letters,
                         .state = state,
                         .flights = state + 2 * ric_model_n_dof(ric_atlas_model(atlas))};
    memcpy(&row.point, at, sizeof row.point);
    return row;
}

ric_status ric_atlas_point(const ric_atlas *atlas, int branch, int i, ric_point *point,
                           double *state, double *flights)
{
    ric_status status = check_id("branch", branch, atlas->n_branch);
    if (status) return status;
    const ric_branch_record *record = &atlas->branches[branch - 1];
    int n_point = record->row.n_point;
    if (i < 0 || i >= n_point)
        return n_point ? ric_fail(RIC_E_RANGE, "no point %d: branch %d has points 0 to %d", i,
                                  branch, n_point - 1)
                       : ric_fail(RIC_E_RANGE, "no point %d: branch %d has no points", i, branch);
    const ric_point_row row = ric_atlas_point_row(atlas, branch, i);
    if (point) *point = row.point;
    if (state) memcpy(state, row.state, (size_t)(row.flights - row.state) * sizeof *state);
    if (flights)
        memcpy(flights, row.flights, (size_t)(row.letters > 0 ? row.letters : 1) * sizeof *flights);
    return RIC_OK;
}

/* ----------------------------------------------------------------- columns */

double ric_point_trace(const ric_point *p)
{
    return 2 * sinh(p->trace);
}

double ric_point_log_trace(const ric_point *p)
{
    return fabs(p->trace) + log(-expm1(-2 * fabs(p->trace)));
}

static ric_status find_column(const char *name, const ric_column **out)
{
    const ric_table *table = &ric_table_point;
    char all[400] = "";
    for (*out = table->column; *out < table->column + table->n; ++*out) {
        if ((*out)->type == RIC_COLUMN_OF_BRANCH || (*out)->type == RIC_COLUMN_PLACE) continue;
        if (!strcmp(name, (*out)->name)) return RIC_OK;
        snprintf(all + strlen(all), sizeof all - strlen(all), "%s%s", *all ? ", " : "",
                 (*out)->name);
    }
    return ric_fail(RIC_E_RANGE, "no column '%s': a point has %s", name, all);
}

ric_status ric_atlas_column(const ric_atlas *atlas, int branch, const char *name, int *width,
                            double *out)
{
    const ric_column *c = NULL;
    ric_status status = check_id("branch", branch, atlas->n_branch);
    if (!status) status = find_column(name, &c);
    if (status) return status;
    const ric_branch *row = &atlas->branches[branch - 1].row;
    const ric_point_row first = {.letters = row->letters};
    const size_t n = ric_column_width(c, &first, ric_model_n_dof(ric_atlas_model(atlas)));
    *width = (int)n;
    for (int i = 0; out && i < row->n_point; i++) {
        const ric_point_row at = ric_atlas_point_row(atlas, branch, i);
        if (c->type == RIC_COLUMN_STATE) memcpy(out + (size_t)i * n, at.state, n * sizeof *out);
        else if (c->type == RIC_COLUMN_FLIGHTS)
            memcpy(out + (size_t)i * n, at.flights, n * sizeof *out);
        else out[i] = ric_column_number(c, &at);
    }
    return RIC_OK;
}

/* ------------------------------------------------------------------- texts */

const char *ric_stop_text(ric_stop stop)
{
    switch (stop) {
    case RIC_STOP_JUNCTION: return "junction";
    case RIC_STOP_CORNER: return "corner";
    case RIC_STOP_WINDOW: return "window";
    case RIC_STOP_BUDGET: return "budget";
    case RIC_STOP_CLOSED: return "closed";
    case RIC_STOP_FAILED: return "failed";
    }
    return "unknown";
}

const char *ric_kind_text(ric_kind kind)
{
    switch (kind) {
    case RIC_KIND_START: return "start";
    case RIC_KIND_GRAZING: return "grazing";
    case RIC_KIND_CORNER: return "corner";
    case RIC_KIND_EXTREMUM: return "extremum";
    case RIC_KIND_BRANCH_POINT: return "branch-point";
    case RIC_KIND_MULTIPLICATION: return "multiplication";
    case RIC_KIND_PERIOD_EXTREMUM: return "period-extremum";
    case RIC_KIND_USER: return "user";
    }
    return "unknown";
}
