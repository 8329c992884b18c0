/* ricochet branches ATLAS: one row per branch, or per segment; all or those of the elementary
 * structure. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "common/cli.h"

bool cli_point_at_junction(const ric_branch *branch, int i, const ric_point *point)
{
    if ((i == 0 && branch->from) || (i == branch->n_point - 1 && branch->to)) return true;
    for (int k = 0; k < branch->n_junction; k++)
        if (fabs(branch->junction_at[k] - point->arclength) <= 1e-9 * (1 + point->arclength))
            return true;
    return false;
}

bool cli_stability_changes(const ric_atlas *atlas, const ric_branch *branch, int i,
                           const ric_point *point)
{
    ric_point a, b;
    if (point->stable != RIC_STABLE_UNDECIDED || i == 0 || i + 1 >= branch->n_point ||
        ric_branch_steps_over(atlas, branch->id, i - 1) ||
        ric_branch_steps_over(atlas, branch->id, i) ||
        ric_atlas_point(atlas, branch->id, i - 1, &a, NULL, NULL) ||
        ric_atlas_point(atlas, branch->id, i + 1, &b, NULL, NULL))
        return false;
    return (a.stable == RIC_STABLE_YES && b.stable == RIC_STABLE_NO) ||
           (a.stable == RIC_STABLE_NO && b.stable == RIC_STABLE_YES);
}

/* ----------------------------------------------------------------- tongues */

/* Its place in the row; what stands there needs the atlas. */
static json_t *no_tongues(const ric_column *column, const void *row)
{
    (void)column;
    (void)row;
    return json_string("");
}

static void join(json_t **out, const char *more)
{
    json_t *before = *out;
    *out = before ? json_sprintf("%s; %s", json_string_value(before), more) : json_string(more);
    json_decref(before);
}

static double width(const ric_tongue *t)
{
    return fabs(log(t->frequency[1] / t->frequency[0]));
}

/* Tongues that are stepped over come by the hundred: of many the widest. */
static void add_crossed(int n, const ric_tongue *tongues, double unit, json_t **out)
{
    enum { FEW = 3 };
    int crossed = 0, widest = -1;
    char one[CLI_TONGUE], all[CLI_TONGUE + 64];
    for (int i = 0; i < n; i++) {
        crossed += tongues[i].crossed;
        if (tongues[i].crossed && (widest < 0 || width(&tongues[i]) > width(&tongues[widest])))
            widest = i;
    }
    for (int i = 0; crossed <= FEW && i < n; i++) {
        if (!tongues[i].crossed) continue;
        ric_tongue_text(&tongues[i], unit, sizeof one, one);
        join(out, one);
    }
    if (crossed <= FEW) return;
    ric_tongue_text(&tongues[widest], unit, sizeof one, one);
    snprintf(all, sizeof all, "steps over %d tongues, the widest: %s", crossed, one);
    join(out, all);
}

ric_status cli_tongues_text(const ric_atlas *atlas, int id, double d, json_t **out)
{
    int n = 0;
    ric_tongue *tongues = NULL;
    *out = NULL;
    const ric_status status = ric_branch_tongues(atlas, id, &n, &tongues);
    for (int i = 0; !status && i < n; i++) {
        char one[CLI_TONGUE];
        if (tongues[i].crossed) continue;
        ric_tongue_text(&tongues[i], cli_unit_of_energies(d), sizeof one, one);
        join(out, one);
    }
    if (!status) add_crossed(n, tongues, cli_unit_of_energies(d), out);
    if (!status && !*out) *out = json_string("");
    ric_tongues_free(tongues);
    return status || *out ? status : RIC_E_NOMEM;
}

/* The same as numbers: m turns of the mode while the motion goes round n times. */
static ric_status list_resonances(const ric_atlas *atlas, int id, double d, json_t *row)
{
    int n = 0;
    ric_tongue *tongues = NULL;
    json_t *list = json_array();
    const ric_status status = ric_branch_tongues(atlas, id, &n, &tongues);
    for (int i = 0; !status && i < n; i++) {
        const ric_tongue *t = &tongues[i];
        json_t *one = json_object();
        json_object_set_new(one, "m", json_integer(t->turns));
        json_object_set_new(one, "n", json_integer(t->per));
        json_object_set_new(one, "mode", json_integer(t->mode));
        json_object_set_new(one, "energy_from", cli_energy(t->energy[0], d));
        json_object_set_new(one, "energy_to", cli_energy(t->energy[1], d));
        json_object_set_new(one, "crossed", json_boolean(t->crossed));
        json_array_append_new(list, one);
    }
    json_object_set_new(row, "resonances", list);
    ric_tongues_free(tongues);
    return status;
}

ric_status cli_branch_row(const ric_atlas *atlas, int id, double d, json_t *row)
{
    ric_branch branch;
    json_t *tongues;
    ric_status status = ric_atlas_branch(atlas, id, &branch);
    if (status) return status;
    cli_table_row(&ric_table_branch, &branch, ric_atlas_model(atlas), d, no_tongues, row);
    status = cli_tongues_text(atlas, id, d, &tongues);
    if (status) return status;
    json_object_set_new(row, "tongues", tongues);
    return list_resonances(atlas, id, d, row);
}

static json_t *tongue_row(const ric_branch *branch, const ric_tongue *t, double d)
{
    json_t *row = json_object();
    json_object_set_new(row, "branch", json_integer(branch->id));
    json_object_set_new(row, "label", json_string(branch->label));
    json_object_set_new(row, "turns", json_integer(t->turns));
    json_object_set_new(row, "per", json_integer(t->per));
    json_object_set_new(row, "of_mode", json_integer(t->mode));
    json_object_set_new(row, "crossed", json_boolean(t->crossed));
    json_object_set_new(row, "others", json_integer(t->others));
    json_object_set_new(row, "energy_from", cli_energy(t->energy[0], d));
    json_object_set_new(row, "energy_to", cli_energy(t->energy[1], d));
    json_object_set_new(row, "frequency_from", cli_number(t->frequency[0]));
    json_object_set_new(row, "frequency_to", cli_number(t->frequency[1]));
    json_object_set_new(row, "first_point", json_integer(t->first));
    json_object_set_new(row, "last_point", json_integer(t->last));
    return row;
}

static ric_status tongue_rows(const ric_atlas *atlas, int id, double d, json_t *rows)
{
    int n = 0;
    ric_branch branch;
    ric_tongue *tongues = NULL;
    ric_status status = ric_atlas_branch(atlas, id, &branch);
    if (!status) status = ric_branch_tongues(atlas, id, &n, &tongues);
    for (int i = 0; !status && i < n; i++)
        json_array_append_new(rows, tongue_row(&branch, &tongues[i], d));
    ric_tongues_free(tongues);
    return status;
}

/* ---------------------------------------------------------------- segments */

/* How an end is called: by the name or the label of its junction, else by what is there instead. */
static const char *end_text(const ric_atlas *atlas, int id, const char *otherwise)
{
    ric_junction junction;
    if (!id || ric_atlas_junction(atlas, id, &junction)) return otherwise;
    return junction.name[0] ? junction.name : junction.label;
}

static json_t *stability(const ric_segment *segment)
{
    const double fraction = segment->stable_fraction;
    if (!segment->points) return json_null();
    return json_string(isnan(fraction) ? "undecided"
                       : fraction == 1 ? "yes"
                       : fraction == 0 ? "no"
                                       : "partly");
}

static json_t *segment_row(const ric_atlas *atlas, const ric_branch *branch,
                           const ric_segment *segment, double d)
{
    json_t *row = json_object();
    const char *from = end_text(atlas, segment->from, "start"),
               *to = end_text(atlas, segment->to, ric_stop_text(branch->stop));
    json_object_set_new(row, "segment", json_sprintf("%s|%s %s", branch->label, from, to));
    json_object_set_new(row, "branch", json_integer(segment->branch));
    json_object_set_new(row, "from", cli_id(segment->from));
    json_object_set_new(row, "to", cli_id(segment->to));
    json_object_set_new(row, "energy_min", cli_energy(segment->energy[0], d));
    json_object_set_new(row, "energy_max", cli_energy(segment->energy[1], d));
    json_object_set_new(row, "frequency_min", cli_number(segment->frequency[0]));
    json_object_set_new(row, "frequency_max", cli_number(segment->frequency[1]));
    json_object_set_new(row, "stable", stability(segment));
    json_object_set_new(row, "stable_fraction", cli_number(segment->stable_fraction));
    return row;
}

static ric_status segment_rows(const ric_atlas *atlas, int id, double d, json_t *rows)
{
    int n = 0;
    ric_branch branch;
    ric_status status = ric_atlas_branch(atlas, id, &branch);
    ric_segment *segments = status ? NULL : calloc((size_t)branch.n_junction + 1, sizeof *segments);
    if (!status) status = segments ? ric_branch_segments(atlas, id, &n, segments) : RIC_E_NOMEM;
    for (int i = 0; !status && i < n; i++)
        json_array_append_new(rows, segment_row(atlas, &branch, &segments[i], d));
    free(segments);
    return status;
}

/* --------------------------------------------------------------- selection */

typedef struct {
    bool segments, tongues, elementary;
} choice;

static ric_status branch_row(const ric_atlas *atlas, int id, double d, json_t *rows)
{
    json_t *row = json_object();
    const ric_status status = cli_branch_row(atlas, id, d, row);
    json_array_append_new(rows, row);
    return status;
}

static ric_status chosen_rows(const ric_atlas *atlas, double d, const void *user, json_t *rows)
{
    const choice *c = user;
    ric_bases *bases = NULL;
    ric_status status = c->elementary ? ric_bases_find(atlas, 0, &bases) : RIC_OK;
    for (int id = 1; !status && id <= ric_atlas_n_branch(atlas); id++)
        if (!bases || ric_bases_elementary(bases, id))
            status = c->segments  ? segment_rows(atlas, id, d, rows)
                     : c->tongues ? tongue_rows(atlas, id, d, rows)
                                  : branch_row(atlas, id, d, rows);
    ric_bases_free(bases);
    return status;
}

static int run(int argc, char **argv)
{
    static const char parts[] = "segment branch from to energy_min energy_max frequency_min "
                                "frequency_max stable stable_fraction";
    static const char places[] = "branch label turns per of_mode crossed others energy_from "
                                 "energy_to frequency_from frequency_to "
                                 "first_point last_point";
    const choice c = {.segments = cli_take_flag(&argc, argv, "--segments"),
                      .tongues = cli_take_flag(&argc, argv, "--tongues"),
                      .elementary = cli_take_flag(&argc, argv, "--elementary")};
    if (c.segments && c.tongues)
        return cli_wrong("--segments and --tongues are two lists; ask for one of them");
    const char *columns = c.tongues ? places : parts;
    const cli_listing listing = {.command = &cli_branches,
                                 .rows = chosen_rows,
                                 .user = &c,
                                 .table = c.segments || c.tongues ? NULL : &ric_table_branch,
                                 .all = columns,
                                 .few = columns};
    return cli_list(&listing, argc, argv);
}

static const cli_item items[] = {
    {.text = "One row per branch; a branch and its mirror images (x -> -x, time reversal, rotation "
             "of the word) "
             "are one row, and the linear normal modes are rows too. The table leaves out what "
             "does not fit on a "
             "line; --csv and --json show everything."},
    {.name = "key", .text = "stays the same whatever the budgets, unlike id and label"},
    {.name = "from, to", .text = "junctions at the ends, by id"},
    {.name = "stop, why",
     .text = "why the far end is where it is: junction, corner, window, budget, closed or failed, "
             "and a sentence "
             "on it, or on events that make no junction"},
    {.name = "junctions",
     .text = "ids of the junctions that the branch passes through, in order; junction_arclengths "
             "says where"},
    {.name = "tongues",
     .text = "internal resonances that the branch follows or steps over: \"follows 129 : 1 with "
             "mode 4 from E .. to "
             "E ..\" says that between these energies the linear mode turns 129 times while the "
             "motion goes round once"},
    {.name = "resonances",
     .text = "the same in --json, as a list of m, n, mode, energy_from, energy_to, crossed: the "
             "mode turns m times "
             "while the motion goes round n times"},
    {.name = "depth", .text = "least number of departures from the start"},
    {.name = "linked",
     .text = "whether a chain of junctions leads to a linear mode; what has none is an island "
             "(--csv and --json)"},
    {.name = "proved, curve_proved",
     .text = "how many of its points are proved, and whether it is proved to be one arc from end "
             "to end, by proofs that "
             "`ricochet prove` has kept (--csv and --json)"},
    {.name = "relative_energy_",
     .text = "energies as multiples of the onset of the lowest mode, where contacts begin to "
             "matter to it; numbers "
             "without a unit (min and max, in --csv and --json)"},
    {.name = "stable_fraction",
     .text =
         "share of the arclength on which the orbits are stable, of that on which it is decided; "
         "null if it is nowhere"},
    {.name = "--physical",
     .text = "energies in the units of the study, not scaled by the clearance"},
    {.name = "--elementary",
     .text = "only the elementary structure: the linear modes and backbones, what joins the "
             "backbone of the first "
             "mode, and what joins the 1- and 2-duplicates of the others; F_1^1, F_i^1 and F_i^2 "
             "of `ricochet "
             "bases`"},
    {.name = "--segments",
     .text = "one row per segment A_N[R]|P1 P2 instead, the part of a branch between consecutive "
             "junctions P1 and "
             "P2; `stable` says yes, no, undecided or partly of the stored points in between, "
             "nothing if there are "
             "none"},
    {.name = "--tongues",
     .text = "one row per internal resonance that a branch follows, or has stepped over "
             "(`crossed`, with `others` that "
             "are narrower), instead: `turns` of the linear mode `of_mode` while the motion goes "
             "round `per` times, "
             "with energies, frequencies and points where that begins and ends"},
    CLI_ITEMS_WORD,
    CLI_ITEM_STABLE,
    CLI_ITEMS_PLACE,
    CLI_ITEM_HZ,
    CLI_ITEM_JSON,
    CLI_ITEM_CSV,
    CLI_ITEM_WIDE,
    {0},
};

const cli_command cli_branches = {
    .name = "branches",
    .summary = "list the branches of an atlas",
    .usage =
        "ricochet branches ATLAS [--segments | --tongues] [--elementary] [--physical]\n"
        "           [--hz] [--json | --csv | --wide]\n"
        "           [--word WORD] [--impacts N] [--stable S] [--energy A,B] [--frequency A,B]\n"
        "           [--sort COLUMN] [--limit N]\n",
    .items = items,
    .example = "ricochet branches study.ricochet\n"
               "ricochet branches study.ricochet --elementary --segments\n"
               "ricochet branches study.ricochet --tongues\n",
    .run = run,
};
