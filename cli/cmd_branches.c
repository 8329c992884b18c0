/* ricochet branches ATLAS: one row per branch. */
#include "cli.h"

static json_t *id_or_null(int id)
{
    return id ? json_integer(id) : json_null();
}

static ric_status make_row(const ric_atlas *atlas, int id, double d, json_t *row)
{
    const ric_model *model = ric_atlas_model(atlas);
    ric_branch found, *branch = &found;
    ric_status status = ric_atlas_branch(atlas, id, branch);
    if (status)
        return status;
    json_t *inner = json_array(), *at = json_array();
    for (int i = 0; i < branch->n_junction; i++) {
        json_array_append_new(inner, json_integer(branch->junctions[i]));
        json_array_append_new(at, cli_number(branch->junction_at[i]));
    }
    json_object_set_new(row, "id", json_integer(branch->id));
    json_object_set_new(row, "label", json_string(branch->label));
    json_object_set_new(row, "word", cli_word(model, branch->impacts, branch->word));
    json_object_set_new(row, "impacts", json_integer(branch->impacts));
    json_object_set_new(row, "symmetric", json_boolean(branch->symmetric));
    json_object_set_new(row, "reversible", json_boolean(branch->reversible));
    json_object_set_new(row, "mirror", json_string(branch->mirror));
    json_object_set_new(row, "stable_fraction", cli_number(branch->stable_fraction));
    json_object_set_new(row, "points", json_integer(branch->n_point));
    json_object_set_new(row, "energy_min", cli_number(d * d * branch->energy_min));
    json_object_set_new(row, "energy_max", cli_number(d * d * branch->energy_max));
    json_object_set_new(row, "frequency_min", cli_number(branch->frequency_min));
    json_object_set_new(row, "frequency_max", cli_number(branch->frequency_max));
    json_object_set_new(row, "from", id_or_null(branch->from));
    json_object_set_new(row, "to", id_or_null(branch->to));
    json_object_set_new(row, "stop", json_string(ric_stop_text(branch->stop)));
    json_object_set_new(row, "why", json_string(branch->why));
    json_object_set_new(row, "junctions", inner);
    json_object_set_new(row, "junction_arclengths", at);
    json_object_set_new(row, "depth", json_integer(branch->depth));
    json_object_set_new(row, "mode", id_or_null(branch->mode));
    return RIC_OK;
}

static int run(int argc, char **argv)
{
    static const char *const all[] = {
        "id", "label", "word", "impacts", "symmetric", "reversible", "mirror", "stable_fraction", "points", "energy_min", "energy_max",
        "frequency_min", "frequency_max", "from", "to", "stop", "why", "junctions", "junction_arclengths", "depth", "mode", NULL};
    static const char *const few[] = {
        "id", "label", "impacts", "symmetric", "reversible", "stable_fraction", "points", "energy_min", "energy_max", "frequency_min",
        "frequency_max", "from", "to", "stop", "junctions", "depth", NULL};
    static const cli_listing listing = {&cli_branches, ric_atlas_n_branch, make_row, all, few};
    return cli_list(&listing, argc, argv);
}

const cli_command cli_branches = {
    .name = "branches",
    .summary = "list the branches of an atlas",
    .help =
        "usage: ricochet branches ATLAS [--physical] [--json | --csv]\n"
        "\n"
        "One row per branch; a branch and its mirror images (x -> -x, time reversal, rotation of the word) are one row, and the linear\n"
        "normal modes are rows too. The table leaves out what does not fit on a line; --csv and --json show everything.\n"
        "\n"
        "  from, to          junctions at the ends, by id\n"
        "  stop, why         why the far end is where it is: junction, corner, window, budget, closed or failed, and a sentence on it\n"
        "  junctions         ids of the junctions that the branch passes through, in order; junction_arclengths says where\n"
        "  depth             least number of departures from the start\n"
        "  stable_fraction   share of the arclength on which the orbits are stable\n"
        "  --physical        energies in the units of the study, not scaled by the clearance\n"
        "\n"
        "example: ricochet branches study.ricochet\n",
    .run = run,
};
