/* ricochet bases ATLAS: the fractal bases and the branches in them. */
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>

#include "common/cli.h"

typedef struct {
    long largest, branch;
} wanted; /* 0: found out; all */

static bool has_branch(const ric_base *base, long id)
{
    for (int i = 0; i < base->n_branch; i++)
        if (base->branches[i] == id) return true;
    return false;
}

static json_t *labels(const ric_atlas *atlas, const ric_base *base)
{
    json_t *array = json_array();
    for (int i = 0; i < base->n_branch; i++) {
        ric_branch branch;
        if (!ric_atlas_branch(atlas, base->branches[i], &branch))
            json_array_append_new(array, json_string(branch.label));
    }
    return array;
}

static json_t *duplicates(const ric_atlas *atlas, const ric_base *base)
{
    json_t *array = json_array();
    for (int i = 0; i < base->n_duplicate; i++) {
        ric_branch branch;
        json_t *one = json_object();
        json_array_append_new(array, one);
        if (ric_atlas_branch(atlas, base->duplicates[2 * i], &branch)) continue;
        json_object_set_new(one, "branch", json_integer(branch.id));
        json_object_set_new(one, "k", json_integer(base->duplicates[2 * i + 1]));
        json_object_set_new(one, "label",
                            cli_duplicate_label(&branch, base->duplicates[2 * i + 1]));
    }
    return array;
}

json_t *cli_base_row(const ric_atlas *atlas, const ric_base *base, double d)
{
    json_t *row = json_object();
    json_object_set_new(row, "base", json_sprintf("F%d_%d", base->j, base->mode));
    json_object_set_new(row, "mode", json_integer(base->mode));
    json_object_set_new(row, "j", json_integer(base->j));
    json_object_set_new(row, "number", json_integer(base->n_branch));
    json_object_set_new(row, "branches", cli_integers(base->n_branch, base->branches));
    json_object_set_new(row, "labels", labels(atlas, base));
    json_object_set_new(row, "duplicates", duplicates(atlas, base));
    json_object_set_new(row, "energy_min", cli_energy(base->energy[0], d));
    json_object_set_new(row, "energy_max", cli_energy(base->energy[1], d));
    json_object_set_new(row, "frequency_min", cli_number(base->frequency[0]));
    json_object_set_new(row, "frequency_max", cli_number(base->frequency[1]));
    return row;
}

static void report_left(const ric_atlas *atlas, const ric_bases *bases)
{
    int left = 0;
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        ric_base base;
        bool found = false;
        for (int i = 0; !found && !ric_bases_get(bases, i, &base); i++)
            found = has_branch(&base, id);
        left += !found;
    }
    if (left)
        cli_say("ricochet: %d branch%s in no base: no path to a backbone with duplicates up to %d; "
                "a larger "
                "--duplicates may find one, unless it is the family of a loose mass, which has no "
                "linear mode to start "
                "from\n",
                left, left == 1 ? " is" : "es are", ric_bases_largest(bases));
}

static ric_status add_rows(const ric_atlas *atlas, double d, const void *user, json_t *rows)
{
    const wanted *w = user;
    ric_branch branch;
    ric_bases *bases = NULL;
    ric_status status = w->branch ? ric_atlas_branch(atlas, (int)w->branch, &branch) : RIC_OK;
    if (!status) status = ric_bases_find(atlas, (int)w->largest, &bases);
    for (int i = 0; !status && i < ric_bases_n(bases); i++) {
        ric_base base;
        if (!(status = ric_bases_get(bases, i, &base)) &&
            (!w->branch || has_branch(&base, w->branch)))
            json_array_append_new(rows, cli_base_row(atlas, &base, d));
    }
    if (!status && (!w->branch || !json_array_size(rows))) report_left(atlas, bases);
    ric_bases_free(bases);
    return status;
}

static int run(int argc, char **argv)
{
    static const char all[] = "base mode j number branches labels duplicates energy_min energy_max "
                              "frequency_min frequency_max";
    static const char few[] =
        "base mode j number energy_min energy_max frequency_min frequency_max branches";
    const char *largest, *branch;
    wanted w = {0};
    if (!cli_take_value(&argc, argv, "--duplicates", &largest) ||
        !cli_take_value(&argc, argv, "--branch", &branch))
        return CLI_WRONG;
    if ((largest && !cli_parse_integer(largest, "--duplicates", 1, 64, &w.largest)) ||
        (branch && !cli_parse_integer(branch, "--branch", 1, INT_MAX, &w.branch)))
        return CLI_WRONG;
    const cli_listing listing = {.command = &cli_bases,
                                 .rows = add_rows,
                                 .user = &w,
                                 .all = all,
                                 .few = few};
    return cli_list(&listing, argc, argv);
}

static const cli_item items[] = {
    {.text = "One row per fractal base Fj_i (the article's F_i^j): the j-duplicate of the backbone "
             "of linear mode "
             "i and all branches that join it, through junctions and on any duplicate, without "
             "passing a backbone "
             "or one of its duplicates. A base of a higher mode leaves out what is in one of a "
             "lower mode. What is "
             "known of a base depends on the budgets of the atlas."},
    {.name = "number, branches",
     .text = "of the original branches in it, by id; labels are their labels (--json and --csv)"},
    {.name = "duplicates", .text = "the k-duplicates in it, k > 1 (--json and --csv)"},
    {.name = "energy, frequency", .text = "ranges of the original branches"},
    {.name = "--branch", .value = "ID", .text = "the bases of one branch"},
    CLI_ITEM_AT,
    {.name = "--duplicates",
     .value = "K",
     .text = "follow duplicates up to K, at most 64; otherwise up to the least number that gives "
             "every branch a "
             "base"},
    {.name = "--physical",
     .text = "energies in the units of the study, not scaled by the clearance"},
    CLI_ITEM_SORT,
    CLI_ITEM_HZ,
    CLI_ITEM_JSON,
    CLI_ITEM_CSV,
    {0},
};

const cli_command cli_bases = {
    .name = "bases",
    .summary = "list the fractal bases of an atlas and the branches in them",
    .usage = "ricochet bases ATLAS [--duplicates K] [--branch ID | --at E,OMEGA] [--physical]\n"
             "           [--sort COLUMN] [--hz] [--json | --csv]\n",
    .items = items,
    .example = "ricochet bases study.ricochet\n",
    .run = run,
};
