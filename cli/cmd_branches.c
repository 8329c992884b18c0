/* ricochet branches ATLAS: one row per branch. */
#include <stdlib.h>

#include "cli.h"

static json_t *word_text(const ric_model *model, int n, const int *word)
{
    size_t size = 12 * (size_t)n + 1;
    char *text = calloc(size, 1);
    json_t *value = text && (n == 0 || !ric_word_format(model, n, word, size, text)) ? json_string(text) : NULL;
    free(text);
    return value;
}

static json_t *id_or_null(int id)
{
    return id ? json_integer(id) : json_null();
}

/* `energy` is the unit of energies: 1, or d^2 for physical ones. */
static json_t *branch_row(const ric_model *model, const ric_branch *branch, double energy)
{
    json_t *row = json_object(), *inner = json_array(), *at = json_array();
    for (int i = 0; i < branch->n_junction; i++) {
        json_array_append_new(inner, json_integer(branch->junctions[i]));
        json_array_append_new(at, cli_number(branch->junction_at[i]));
    }
    json_object_set_new(row, "id", json_integer(branch->id));
    json_object_set_new(row, "label", json_string(branch->label));
    json_object_set_new(row, "word", word_text(model, branch->impacts, branch->word));
    json_object_set_new(row, "impacts", json_integer(branch->impacts));
    json_object_set_new(row, "symmetric", json_boolean(branch->symmetric));
    json_object_set_new(row, "reversible", json_boolean(branch->reversible));
    json_object_set_new(row, "mirror", json_string(branch->mirror));
    json_object_set_new(row, "stable_fraction", cli_number(branch->stable_fraction));
    json_object_set_new(row, "points", json_integer(branch->n_point));
    json_object_set_new(row, "energy_min", cli_number(energy * branch->energy_min));
    json_object_set_new(row, "energy_max", cli_number(energy * branch->energy_max));
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
    return row;
}

static ric_status add_rows(json_t *rows, const ric_atlas *atlas, bool physical)
{
    const ric_model *model = ric_atlas_model(atlas);
    double d = physical ? ric_model_length(model) : 1;
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        ric_branch branch;
        ric_status status = ric_atlas_branch(atlas, id, &branch);
        if (status)
            return status;
        json_array_append_new(rows, branch_row(model, &branch, d * d));
    }
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
    cli_format format;
    ric_atlas *atlas = NULL;
    json_t *rows = json_array();
    int code = CLI_WRONG;
    bool physical = cli_take_flag(&argc, argv, "--physical");
    if (!cli_take_format(&argc, argv, &format) || !cli_operands(&cli_branches, argc, argv, 1))
        goto out;
    ric_status status = ric_atlas_read(argv[1], &atlas);
    if (!status)
        status = add_rows(rows, atlas, physical);
    code = status ? cli_report(status) : cli_print_rows(rows, format == CLI_TEXT ? few : all, format);
out:
    json_decref(rows);
    ric_atlas_free(atlas);
    return code;
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
