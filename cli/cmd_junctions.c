/* ricochet junctions ATLAS: one row per junction. */
#include "cli.h"

static json_t *numbers(int n, const double *values, double unit)
{
    json_t *array = json_array();
    for (int i = 0; i < n; i++)
        json_array_append_new(array, cli_number(unit * values[i]));
    return array;
}

static json_t *integers(int n, const int *values)
{
    json_t *array = json_array();
    for (int i = 0; i < n; i++)
        json_array_append_new(array, json_integer(values[i]));
    return array;
}

static json_t *departures(const ric_departures *count)
{
    json_t *object = json_object();
    json_object_set_new(object, "taken", json_integer(count->taken));
    json_object_set_new(object, "known", json_integer(count->known));
    json_object_set_new(object, "inadmissible", json_integer(count->inadmissible));
    json_object_set_new(object, "over_budget", json_integer(count->over_budget));
    json_object_set_new(object, "refused", json_integer(count->refused));
    return object;
}

/* A multiplicity of C_ab, null where there is none. */
static json_t *multiplicity(const ric_junction *junction, int value)
{
    return junction->a || junction->b ? json_integer(value) : json_null();
}

static ric_status make_row(const ric_atlas *atlas, int id, double d, json_t *row)
{
    const ric_model *model = ric_atlas_model(atlas);
    ric_junction found, *junction = &found;
    ric_status status = ric_atlas_junction(atlas, id, junction);
    if (status)
        return status;
    json_object_set_new(row, "id", json_integer(junction->id));
    json_object_set_new(row, "kind", json_string(ric_kind_text(junction->kind)));
    json_object_set_new(row, "label", json_string(junction->label));
    json_object_set_new(row, "name", json_string(junction->name));
    json_object_set_new(row, "word", cli_word(model, junction->impacts, junction->word));
    json_object_set_new(row, "impacts", json_integer(junction->impacts));
    json_object_set_new(row, "grazings", json_integer(junction->grazings));
    json_object_set_new(row, "multiple", json_integer(junction->multiple));
    json_object_set_new(row, "rotation", junction->rotation[1] ? integers(2, junction->rotation) : json_null());
    json_object_set_new(row, "a", multiplicity(junction, junction->a));
    json_object_set_new(row, "b", multiplicity(junction, junction->b));
    json_object_set_new(row, "energy", cli_number(d * d * junction->energy));
    json_object_set_new(row, "frequency", cli_number(junction->frequency));
    json_object_set_new(row, "state", numbers(2 * ric_model_n_dof(model), junction->state, d));
    json_object_set_new(row, "flights", numbers(junction->impacts ? junction->impacts : 1, junction->flights, 1));
    json_object_set_new(row, "branches", integers(junction->n_branch, junction->branches));
    json_object_set_new(row, "departures", departures(&junction->departures));
    json_object_set_new(row, "refusal", json_string(junction->refusal));
    return RIC_OK;
}

static int run(int argc, char **argv)
{
    static const char *const all[] = {
        "id", "kind", "label", "name", "word", "impacts", "grazings", "multiple", "rotation", "a", "b", "energy", "frequency", "state",
        "flights", "branches", "departures", "refusal", NULL};
    static const char *const few[] = {
        "id", "kind", "label", "name", "word", "impacts", "grazings", "multiple", "rotation", "energy", "frequency", "branches", NULL};
    static const cli_listing listing = {&cli_junctions, ric_atlas_n_junction, make_row, all, few};
    return cli_list(&listing, argc, argv);
}

const cli_command cli_junctions = {
    .name = "junctions",
    .summary = "list the junctions of an atlas",
    .help =
        "usage: ricochet junctions ATLAS [--physical] [--json | --csv]\n"
        "\n"
        "One row per junction: where branches begin, end, meet or turn. The table leaves out what does not fit on a line; --csv and --json\n"
        "show everything.\n"
        "\n"
        "  kind         start, grazing, corner, extremum, branch-point, multiplication, period-extremum or user\n"
        "  word         of the original orbit, touches left out; impacts is its length, grazings the number of touches\n"
        "  multiple     q of a q-tupling, 1 otherwise; rotation is its p/q\n"
        "  a, b         multiplicities of a point C_ab\n"
        "  frequency    where it is drawn: omega / q for a q-tupling\n"
        "  state        x then v right after the first impact of the word, at a mirror point if there is no impact\n"
        "  flights      flight times, or the period if there is no impact\n"
        "  branches     ids of the branches that end at it or pass through it\n"
        "  departures   what became of the candidates: taken, known, inadmissible, over_budget, refused; refusal says why\n"
        "  --physical   lengths, speeds and energies in the units of the study, not scaled by the clearance\n"
        "\n"
        "example: ricochet junctions study.ricochet\n",
    .run = run,
};
