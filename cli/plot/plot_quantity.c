#include "plot_quantity.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const struct {
    const char *name, *title;
} columns[] = {
    [PLOT_ARCLENGTH] = {"arclength", "arclength"},
    [PLOT_ENERGY] = {"energy", "scaled energy E"},
    [PLOT_FREQUENCY] = {"frequency", "frequency ω (rad/s)"},
    [PLOT_PERIOD] = {"period", "period T (s)"},
    [PLOT_TRACE] = {"trace", "trace τ_2"},
    [PLOT_ROTATION] = {"rotation", "rotation number γ"},
    [PLOT_REACH] = {"reach", "reach: gap / clearance"},
    [PLOT_APPROACH] = {"approach", "least approach speed"},
    [PLOT_DISPLACEMENT] = {"x", "x_{%d}"},
    [PLOT_SPEED] = {"v", "v_{%d}"},
    [PLOT_FLIGHT] = {"tau", "τ_{%d} (s)"},
};

bool plot_quantity_find(const char *name, const char *what, int n_dof, plot_quantity *out)
{
    for (plot_quantity_kind k = PLOT_ARCLENGTH; k < PLOT_DISPLACEMENT; k++)
        if (!strcmp(name, columns[k].name)) {
            *out = (plot_quantity){.kind = k};
            snprintf(out->title, sizeof out->title, "%s", columns[k].title);
            return true;
        }
    for (plot_quantity_kind k = PLOT_DISPLACEMENT; k <= PLOT_FLIGHT; k++) {
        const size_t n = strlen(columns[k].name);
        if (strncmp(name, columns[k].name, n) || !isdigit((unsigned char)name[n])) continue;
        long index;
        if (!cli_parse_integer(name + n, what, 1, k == PLOT_FLIGHT ? 1000000 : n_dof, &index))
            return false;
        *out = (plot_quantity){.kind = k, .index = (int)index - 1};
        if (k == PLOT_FLIGHT) snprintf(out->title, sizeof out->title, "τ_{%ld} (s)", index);
        else snprintf(out->title, sizeof out->title, "%s_{%ld}", columns[k].name, index);
        return true;
    }
    cli_wrong("%s %s: there are arclength energy frequency period trace rotation reach approach "
              "x1.. v1.. tau1..",
              what, name);
    return false;
}

void plot_quantity_set_unit(plot_quantity *q, const plot_options *common, const ric_atlas *atlas)
{
    const plot_units unit = plot_units_of(common, ric_atlas_model(atlas));
    q->unit = q->kind == PLOT_ENERGY      ? unit.energy
              : q->kind == PLOT_FREQUENCY ? unit.frequency
              : q->kind == PLOT_DISPLACEMENT || q->kind == PLOT_SPEED || q->kind == PLOT_APPROACH
                  ? unit.length
                  : 1;
    if (q->kind == PLOT_ENERGY)
        plot_energy_title(common, 1, (const ric_model *const[]){ric_atlas_model(atlas)},
                          sizeof q->title, q->title);
    if (q->kind == PLOT_FREQUENCY)
        snprintf(q->title, sizeof q->title, "%s", plot_frequency_title(common));
    const char *length = ric_model_units(ric_atlas_model(atlas))->length;
    const bool named = common->physical && *length;
    const size_t end = strlen(q->title);
    if (named && q->kind == PLOT_DISPLACEMENT)
        snprintf(q->title + end, sizeof q->title - end, " (%s)", length);
    if (named && q->kind == PLOT_SPEED)
        snprintf(q->title + end, sizeof q->title - end, " (%s/s)", length);
}

bool plot_quantity_smooth(const plot_quantity *q)
{
    return q->kind != PLOT_REACH && q->kind != PLOT_APPROACH && q->kind != PLOT_ROTATION;
}

static double read_quantity(const plot_quantity *q, const ric_branch *branch, int n_dof,
                            const ric_point *p, const double *state, const double *flights)
{
    switch (q->kind) {
    case PLOT_ARCLENGTH: return p->arclength;
    case PLOT_ENERGY: return p->energy;
    case PLOT_FREQUENCY: return p->frequency;
    case PLOT_PERIOD: return 2 * CLI_PI / p->frequency;
    case PLOT_TRACE: return p->trace; /* asinh(trace / 2), drawn on that scale */
    case PLOT_ROTATION: return p->rotation;
    case PLOT_REACH: return p->reach;
    case PLOT_APPROACH: return p->approach;
    case PLOT_DISPLACEMENT: return state[q->index];
    case PLOT_SPEED: return state[n_dof + q->index];
    case PLOT_FLIGHT:
        return q->index < (branch->letters > 0 ? branch->letters : 1) ? flights[q->index] : NAN;
    }
    return NAN;
}

ric_status plot_quantity_track(const ric_atlas *atlas, const ric_branch *branch,
                               const plot_quantity *x, const plot_quantity *y, plot_track *t)
{
    const int n_dof = ric_model_n_dof(ric_atlas_model(atlas));
    double *state = calloc(2 * (size_t)n_dof, sizeof *state),
           *flights = calloc((size_t)branch->letters + 1, sizeof *flights);
    ric_status status = state && flights ? RIC_OK : RIC_E_NOMEM;
    for (int i = 0; status == RIC_OK && i < branch->n_point; i++) {
        ric_point p;
        status = ric_atlas_point(atlas, branch->id, i, &p, state, flights);
        if (status != RIC_OK) break;
        const plot_point at = {read_quantity(x, branch, n_dof, &p, state, flights),
                               read_quantity(y, branch, n_dof, &p, state, flights)};
        if (!plot_track_add(t, at, p.arclength, plot_point_stability(atlas, branch, i, &p)))
            status = RIC_E_NOMEM;
        if (ric_branch_steps_over(atlas, branch->id, i)) plot_track_gap(t);
    }
    free(state);
    free(flights);
    return status;
}
