/* Whether the numbers of an atlas that was read can be those of an atlas: finite, in their ranges,
 * of the model, and in agreement with each other. What commands do with them, they may then do
 * without asking: a number that is none is never decided by a bisection, and a time of 1e300 s is
 * searched for ever. The digest finds damage, not forgery. */
#include "store_parts.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "model/room.h"
#include "study/room.h"
#include "base/room.h"

/* Largest relative difference between numbers that say the same: the stored ones agree to 1e-12 and
 * better. */
#define AGREE 1e-6
/* Digits that the energy of a state loses where elastic forces balance, relative to the sum of its
 * terms. */
#define CANCEL 1e-12
/* Largest phase of a mode in one period, ten times what a run admits in its window. */
#define PHASE 1e8
/* Longest period, of the longest in the windows of the study and its regions, where branches end,
 * and of the linear modes, which are listed wherever they lie: a border is met to rounding, and
 * this allows for more than a step beyond. What takes longer would be integrated for as long. */
#define BEYOND 2
/* Where a multiplier lies exactly at -1 older files have a rotation of minus a half. */
#define HALF -0.5

typedef struct {
    const char *path;
    const ric_model *model;
    double fastest; /* rad/s, of the seen modes */
    double longest; /* s, period */
    const char *table;
    int row, sub; /* id of the branch or junction; number of the point or position, -1: none */
} judge;

static ric_status refuse(const judge *j, const char *field, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

static ric_status refuse(const judge *j, const char *field, const char *format, ...)
{
    char what[200], where[48] = "", all[400];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(what, sizeof what, format, arguments);
    va_end(arguments);
    if (j->sub >= 0) snprintf(where, sizeof where, ", %d", j->sub);
    snprintf(all, sizeof all, "table %s, row %d%s, %s: %s", j->table, j->row, where, field, what);
    return ric_store_fail_damaged(j->path, all);
}

static ric_status check_column(const judge *j, const ric_column *c, const void *row)
{
    const double value = ric_column_number(c, row);
    if (isnan(value))
        return c->type == RIC_COLUMN_MAYBE ? RIC_OK : refuse(j, c->name, "not a number");
    return (value >= c->min && value <= c->max) || (value == HALF && !strcmp(c->name, "rotation"))
               ? RIC_OK
               : refuse(j, c->name, "%.6g is not between %g and %g", value, c->min, c->max);
}

/* Whether the numbers with a fraction are in the ranges of their columns; whole ones have been
 * looked at. */
static ric_status check_columns(const judge *j, const ric_table *table, const void *row)
{
    ric_status status = RIC_OK;
    for (const ric_column *c = NULL; !status && (c = ric_store_next_column(table, c, false));)
        if (c->type == RIC_COLUMN_REAL || c->type == RIC_COLUMN_MAYBE ||
            c->type == RIC_COLUMN_SINGLE)
            status = check_column(j, c, row);
    return status;
}

static bool is_finite(int n, const double *values, double max)
{
    for (int i = 0; i < n; i++)
        if (!(fabs(values[i]) <= max)) return false;
    return true;
}

/* The sum of the sizes of the terms that ric_model_energy adds for the structure. */
static double size_of_terms(const ric_model *m, const double *x, const double *v)
{
    double sum = 0;
    for (int i = 0; i < m->n_dof; i++)
        for (int k = 0; k < m->n_dof; k++)
            sum += fabs(x[i] * m->K[i * m->n_dof + k] * x[k]) +
                   fabs(v[i] * m->M[i * m->n_dof + k] * v[k]);
    return sum / 2;
}

static ric_status check_state(const judge *j, const double *state, double energy)
{
    int n = j->model->n_dof;
    const double *x = state, *v = state + n;
    if (!is_finite(2 * n, state, RIC_LARGEST))
        return refuse(j, "state", "a number in it is not finite, or beyond %g", RIC_LARGEST);
    double found = ric_model_energy(j->model, x, v);
    return fabs(found - energy) <= AGREE * fabs(energy) + CANCEL * size_of_terms(j->model, x, v)
               ? RIC_OK
               : refuse(j, "state", "its energy is %.6g where the row says %.6g", found, energy);
}

/* Flights of an orbit of frequency omega: none goes back in time, and together they make a period.
 */
static ric_status check_flights(const judge *j, int n, const double *flights, double omega)
{
    double sum = 0, period = RIC_TWO_PI / omega;
    if (!is_finite(n, flights, RIC_LARGEST))
        return refuse(j, "flights", "a number in it is not finite, or beyond %g", RIC_LARGEST);
    for (int i = 0; i < n; i++) {
        sum += flights[i];
        if (flights[i] < -RIC_SLACK * period)
            return refuse(j, "flights", "%.6g s is less than no time", flights[i]);
    }
    if (fabs(sum - period) > AGREE * period)
        return refuse(j, "flights", "together %.6g s where the period is %.6g s", sum, period);
    if (period > j->longest)
        return refuse(
            j, "flights",
            "a period of %.6g s, where the windows and the modes of the study end at %.6g s",
            period, j->longest / BEYOND);
    if (j->fastest * period > PHASE)
        return refuse(j, "flights", "the fastest mode turns %.3g times in a period",
                      j->fastest * period / RIC_TWO_PI);
    return RIC_OK;
}

static ric_status check_point(const judge *j, const ric_point_row *row)
{
    const ric_point *p = &row->point;
    ric_status status = check_columns(j, &ric_table_point, row);
    if (!status) status = check_state(j, row->state, p->energy);
    return status
               ? status
               : check_flights(j, row->letters > 0 ? row->letters : 1, row->flights, p->frequency);
}

static ric_status check_points(judge *j, const ric_atlas *atlas, const ric_branch *branch)
{
    double last = 0;
    ric_status status = RIC_OK;
    j->table = "point";
    for (int i = 0; !status && i < branch->n_point; i++) {
        const ric_point_row row = ric_atlas_point_row(atlas, branch->id, i);
        const double at = row.point.arclength;
        j->sub = i;
        status = check_point(j, &row);
        if (!status && at < last) status = refuse(j, "arclength", "%.6g after %.6g", at, last);
        last = at;
    }
    return status;
}

static ric_status check_passed(judge *j, const ric_branch *branch)
{
    ric_status status = RIC_OK;
    j->table = "branch_junction";
    for (int i = 0; !status && i < branch->n_junction; i++) {
        const ric_link_row link = {.arclength = branch->junction_at[i]};
        j->sub = i;
        status = check_columns(j, &ric_table_branch_junction, &link);
    }
    return status;
}

static ric_status check_branch(judge *j, const ric_branch *b)
{
    bool linear = b->impacts == 0 && ric_model_detached(j->model);
    j->table = "branch";
    j->sub = -1;
    ric_status status = check_columns(j, &ric_table_branch, b);
    if (!status && (b->energy_min > b->energy_max || b->frequency_min > b->frequency_max))
        status = refuse(j, b->energy_min > b->energy_max ? "energy_min" : "frequency_min",
                        "more than the largest");
    if (!status && linear && b->mode == 0)
        status = refuse(j, "mode", "0 where nothing is hit, which a linear mode is");
    if (!status && b->n_point == 0) status = refuse(j, "points", "a branch has no point");
    return status;
}

static ric_status check_junction(judge *j, const ric_junction *at)
{
    j->table = "junction";
    j->sub = -1;
    ric_status status = check_columns(j, &ric_table_junction, at);
    if (!status && (at->rotation[0] < 0 || at->rotation[0] > at->rotation[1]))
        status = refuse(j, "rotation_p", "%d of %d", at->rotation[0], at->rotation[1]);
    if (!status) status = check_state(j, at->state, at->energy);
    if (!status)
        status = check_flights(j, at->letters > 0 ? at->letters : 1, at->flights,
                               at->frequency * at->multiple);
    return status;
}

/* ------------------------------------------------------------- references */

static bool lists(const ric_junction *at, int branch)
{
    int from = 0, to = at->n_branch;
    while (from < to) { /* ascending, and so found by halves */
        int half = from + (to - from) / 2;
        if (at->branches[half] < branch) from = half + 1;
        else to = half;
    }
    return from < at->n_branch && at->branches[from] == branch;
}

/* A junction that a branch names lists that branch. `met` counts, once for each branch, what lists
 * each junction. */
static ric_status check_named(judge *j, const ric_atlas *atlas, const ric_branch *b, int id,
                              const char *field, int *met, int *last)
{
    if (!id) return RIC_OK;
    if (!lists(&atlas->junctions[id - 1].row, b->id))
        return refuse(j, field, "junction %d does not list branch %d in table junction_branch", id,
                      b->id);
    met[id - 1] += last[id - 1] != b->id;
    last[id - 1] = b->id;
    return RIC_OK;
}

static ric_status check_references(judge *j, const ric_atlas *atlas)
{
    int *met = ric_calloc(2 * (size_t)atlas->n_junction + 1, sizeof *met),
        *last = met ? met + atlas->n_junction : NULL;
    ric_status status = met ? RIC_OK : ric_store_fail_memory();
    for (int k = 0; !status && k < atlas->n_branch; k++) {
        const ric_branch *b = &atlas->branches[k].row;
        *j = (judge){j->path, j->model, j->fastest, j->longest, "branch", b->id, -1};
        status = check_named(j, atlas, b, b->from, "from_junction", met, last);
        if (!status) status = check_named(j, atlas, b, b->to, "to_junction", met, last);
        j->table = "branch_junction";
        for (int i = 0; !status && i < b->n_junction; i++) {
            j->sub = i;
            status = check_named(j, atlas, b, b->junctions[i], "junction", met, last);
        }
    }
    for (int k = 0; !status && k < atlas->n_junction; k++) {
        *j = (judge){j->path, j->model, j->fastest, j->longest, "junction_branch", k + 1, -1};
        if (met[k] != atlas->junctions[k].row.n_branch)
            status = refuse(j, "branch", "a branch is listed that neither ends here nor passes");
    }
    free(met);
    return status;
}

ric_status ric_store_check_numbers(const char *path, const ric_atlas *atlas)
{
    judge j = {.path = path, .model = ric_atlas_model(atlas), .sub = -1};
    double energy[2], frequency[2];
    ric_status status = RIC_OK;
    ric_region_window(ric_study_options(atlas->study), energy, frequency);
    for (int i = 0; i < j.model->n_dof; i++) {
        if (j.model->seen[i]) j.fastest = fmax(j.fastest, j.model->frequency[i]);
        if (j.model->frequency[i] > 0) frequency[0] = fmin(frequency[0], j.model->frequency[i]);
    }
    j.longest = BEYOND * RIC_TWO_PI / frequency[0];
    for (int k = 0; !status && k < atlas->n_branch; k++) {
        const ric_branch_record *record = &atlas->branches[k];
        j.row = k + 1;
        status = check_branch(&j, &record->row);
        if (!status) status = check_points(&j, atlas, &record->row);
        if (!status) status = check_passed(&j, &record->row);
    }
    for (int k = 0; !status && k < atlas->n_junction; k++) {
        j.row = k + 1;
        status = check_junction(&j, &atlas->junctions[k].row);
    }
    return status ? status : check_references(&j, atlas);
}
