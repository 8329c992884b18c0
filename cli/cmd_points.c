/* ricochet points ATLAS --branch ID: the stored points of one branch. */
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "cli.h"

static const double two_pi = 6.283185307179586;

static json_t *stability(int stable)
{
    return json_string(stable == RIC_STABLE_YES ? "yes" : stable == RIC_STABLE_NO ? "no" : "undecided");
}

/* log |2 sinh y| */
static double log_trace(double y)
{
    return fabs(y) + log(-expm1(-2 * fabs(y)));
}

/* The trace 2 sinh y; beyond the range of a double, sign and logarithm as a text. */
static json_t *trace_of(double y)
{
    char text[48];
    double trace = 2 * sinh(y);
    if (!isinf(trace) || isinf(y))
        return cli_number(trace);
    snprintf(text, sizeof text, "%sexp(%.17g)", y < 0 ? "-" : "", log_trace(y));
    return json_string(text);
}

/* Pairs re, im, or null if there are none beside the trivial ones or they cannot be had. */
static json_t *multipliers(const ric_atlas *atlas, int branch, int i)
{
    int n = 2 * (ric_model_n_mode(ric_atlas_model(atlas)) - 1), n_orbit = 0;
    ric_orbit **orbits = NULL;
    double *values = calloc(2 * (size_t)n, sizeof *values);
    json_t *pairs = json_array();
    if (values && !ric_orbit_find(atlas, branch, RIC_AT_POINT, i, &n_orbit, &orbits) && n_orbit > 0
        && !ric_orbit_multipliers(orbits[0], values))
        for (int k = 0; k < n; k++) {
            json_t *pair = json_array();
            json_array_append_new(pair, cli_number(values[2 * k]));
            json_array_append_new(pair, cli_number(values[2 * k + 1]));
            json_array_append_new(pairs, pair);
        }
    ric_orbits_free(n_orbit, orbits);
    free(values);
    if (json_array_size(pairs))
        return pairs;
    json_decref(pairs);
    return json_null();
}

static json_t *point_row(int i, const ric_point *point, double d)
{
    json_t *row = json_object();
    json_object_set_new(row, "point", json_integer(i));
    json_object_set_new(row, "arclength", cli_number(point->arclength));
    json_object_set_new(row, "energy", cli_number(d * d * point->energy));
    json_object_set_new(row, "frequency", cli_number(point->frequency));
    json_object_set_new(row, "period", cli_number(two_pi / point->frequency));
    json_object_set_new(row, "trace", trace_of(point->trace));
    json_object_set_new(row, "log_trace", cli_number(log_trace(point->trace)));
    json_object_set_new(row, "rotation", cli_number(point->rotation));
    json_object_set_new(row, "stable", stability(point->stable));
    json_object_set_new(row, "reach", cli_number(point->reach));
    json_object_set_new(row, "approach", cli_number(d * point->approach));
    json_object_set_new(row, "residual", cli_number((double)point->residual));
    return row;
}

static ric_status add_rows(json_t *rows, const ric_atlas *atlas, int id, bool physical, bool want_multipliers)
{
    const ric_model *model = ric_atlas_model(atlas);
    double d = physical ? ric_model_length(model) : 1;
    ric_branch branch;
    ric_status status = ric_atlas_branch(atlas, id, &branch);
    for (int i = 0; !status && i < branch.n_point; i++) {
        ric_point point;
        status = ric_atlas_point(atlas, id, i, &point, NULL, NULL);
        if (status)
            break;
        json_t *row = point_row(i, &point, d);
        if (want_multipliers && ric_model_n_mode(model) > 2)
            json_object_set_new(row, "multipliers", multipliers(atlas, id, i));
        json_array_append_new(rows, row);
    }
    return status;
}

static int run(int argc, char **argv)
{
    static const char *const plain[] = {
        "point", "arclength", "energy", "frequency", "period", "trace", "log_trace", "rotation", "stable", "reach", "approach",
        "residual", NULL};
    static const char *const with_multipliers[] = {
        "point", "arclength", "energy", "frequency", "period", "trace", "log_trace", "rotation", "stable", "reach", "approach",
        "residual", "multipliers", NULL};
    static const char *const few[] = {
        "point", "arclength", "energy", "frequency", "period", "trace", "rotation", "stable", "reach", "approach", "residual", NULL};
    cli_format format;
    ric_atlas *atlas = NULL;
    const char *id_text;
    long id = 0;
    json_t *rows = json_array();
    int code = CLI_WRONG;
    bool physical = cli_take_flag(&argc, argv, "--physical");
    if (!cli_take_format(&argc, argv, &format) || !cli_take_value(&argc, argv, "--branch", &id_text)
        || !cli_operands(&cli_points, argc, argv, 1))
        goto out;
    if (!id_text) {
        cli_wrong("points: --branch ID is missing; `ricochet branches %s` lists the ids", argv[1]);
        goto out;
    }
    if (!cli_parse_integer(id_text, "--branch", 1, INT_MAX, &id))
        goto out;
    ric_status status = ric_atlas_read(argv[1], &atlas);
    if (!status)
        status = add_rows(rows, atlas, (int)id, physical, format != CLI_TEXT);
    bool many = atlas && ric_model_n_mode(ric_atlas_model(atlas)) > 2;
    code = status ? cli_report(status) : cli_print_rows(rows, format == CLI_TEXT ? few : many ? with_multipliers : plain, format);
out:
    json_decref(rows);
    ric_atlas_free(atlas);
    return code;
}

const cli_command cli_points = {
    .name = "points",
    .summary = "list the stored points of a branch",
    .help =
        "usage: ricochet points ATLAS --branch ID [--physical] [--json | --csv]\n"
        "\n"
        "The stored points of a branch in order; `ricochet orbit` gives the orbit at any of them, or between them.\n"
        "\n"
        "  trace        of the monodromy without its trivial part, for two modes; sign and exp(logarithm) beyond the range of a double.\n"
        "               log_trace is the logarithm of its modulus. For more modes both are empty and --json and --csv give the\n"
        "               multipliers instead, as pairs of real and imaginary part\n"
        "  rotation     gamma in [0, 1): the multipliers are exp(+-2 pi i gamma)\n"
        "  stable       yes, no or undecided\n"
        "  reach        largest gap over clearance in flight: below 1 between touches\n"
        "  approach     smallest speed of approach of the impacts\n"
        "  residual     relative residual of the orbit problem\n"
        "  --physical   speeds and energies in the units of the study, not scaled by the clearance\n"
        "\n"
        "example: ricochet points study.ricochet --branch 3 --csv\n",
    .run = run,
};
