/* ricochet points ATLAS --branch ID: the stored points of one branch, or its ghosts. */
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/cli.h"

/* The trace; beyond the range of a double, sign and logarithm as a text. */
static json_t *trace_of(const ric_point *point)
{
    char text[48];
    double trace = ric_point_trace(point);
    if (!isinf(trace) || isinf(point->trace)) return cli_number(trace);
    snprintf(text, sizeof text, "%sexp(%.17g)", point->trace < 0 ? "-" : "",
             ric_point_log_trace(point));
    return json_string(text);
}

/* Pairs re, im, or null if there are none beside the trivial ones or they cannot be had. */
static json_t *pairs(int n, const double *values)
{
    return values && n > 0 ? cli_pairs(n, values) : json_null();
}

/* What both kinds of points need to become rows. */
typedef struct {
    const ric_atlas *atlas;
    ric_branch branch;
    double d;            /* length that speeds are multiplied by, energies by its square */
    int n_multiplier;    /* 0: not wanted */
    double *multipliers; /* room for them, re and im */
    json_t *rows;
} listing;

static json_t *made(const ric_column *column, const void *row)
{
    const ric_point_row *at = row;
    return !strcmp(column->name, "trace")
               ? trace_of(&at->point)
               : json_string(cli_stability((ric_stability)at->point.stable));
}

static json_t *point_row(const listing *l, int i, const ric_point *point)
{
    const ric_point_row at = {.number = i, .point = *point};
    json_t *row = json_object();
    cli_table_row(&ric_table_point, &at, ric_atlas_model(l->atlas), l->d, made, row);
    return row;
}

static ric_status add_points(const listing *l)
{
    ric_status status = RIC_OK;
    for (int i = 0; !status && i < l->branch.n_point; i++) {
        ric_point point;
        status = ric_atlas_point(l->atlas, l->branch.id, i, &point, NULL, NULL);
        if (status) break;
        json_t *row = point_row(l, i, &point);
        if (l->n_multiplier) {
            int n = 0;
            ric_orbit **orbits = NULL;
            bool good = !ric_orbit_find(l->atlas, l->branch.id, RIC_AT_POINT, i, &n, &orbits) &&
                        n > 0 && !ric_orbit_multipliers(orbits[0], l->multipliers);
            json_object_set_new(row, "multipliers",
                                pairs(l->n_multiplier, good ? l->multipliers : NULL));
            ric_orbits_free(n, orbits);
        }
        json_array_append_new(l->rows, row);
    }
    return status;
}

/* ------------------------------------------------------------------- ghosts */

static ric_status add_ghost(const listing *l, const ric_ghost *ghost)
{
    ric_ghost_data data;
    ric_status status = RIC_OK;
    ric_ghost_describe(ghost, &data);
    const char *end = data.end == RIC_END_FROM ? "from" : "to";
    for (int i = 0; !status && i < data.n_point; i++) {
        ric_point point;
        status = ric_ghost_point(ghost, i, &point, NULL, NULL);
        if (status) break;
        json_t *row = point_row(l, i, &point);
        json_object_set_new(row, "end", json_string(end));
        json_object_set_new(row, "admissible", json_boolean(ric_point_admissible(&point)));
        if (l->n_multiplier) {
            bool good = !ric_ghost_multipliers(ghost, i, l->multipliers);
            json_object_set_new(row, "multipliers",
                                pairs(l->n_multiplier, good ? l->multipliers : NULL));
        }
        json_array_append_new(l->rows, row);
    }
    cli_say("ricochet: ghost beyond '%s': %d point%s; stopped: %s%s%s\n", end, data.n_point,
            cli_plural(data.n_point), ric_stop_text(data.stop), *data.why ? ", " : "", data.why);
    if (data.again >= 0)
        cli_say("ricochet: ghost beyond '%s': admissible again from point %d on\n", end,
                data.again);
    return status;
}

/* "grazing G1_2,4", "branch-point C1_32", "the upper end of the energy window" */
static void name_end(const listing *l, int junction_id, size_t size, char *out)
{
    ric_junction junction;
    if (junction_id && !ric_atlas_junction(l->atlas, junction_id, &junction))
        snprintf(out, size, "%s %s", ric_kind_text(junction.kind), junction.label);
    else snprintf(out, size, "%s", *l->branch.why ? l->branch.why : "no junction");
}

static int no_ghost(const listing *l, const char *path)
{
    char from[120], to[120];
    if (l->branch.impacts == 0) {
        cli_say("ricochet: branch %d has no ghost: a linear mode has no impacts and stays the same "
                "at any amplitude. "
                "The ghosts of the branches that leave it can be listed; `ricochet branches %s` "
                "shows them\n",
                l->branch.id, path);
        return CLI_FAILED;
    }
    name_end(l, l->branch.from, sizeof from, from);
    name_end(l, l->branch.to, sizeof to, to);
    cli_say("ricochet: branch %d has no ghost: a ghost goes on where a grazing or a corner ends a "
            "branch, and the ends "
            "of this one are: %s; %s. `ricochet branches %s` lists `from` and `to`, `ricochet "
            "junctions %s` their "
            "kinds\n",
            l->branch.id, from, to, path, path);
    return CLI_FAILED;
}

static int add_ghosts(const listing *l, const char *path)
{
    ric_ghost_limits limits;
    ric_ghost **ghosts = NULL;
    int n = 0;
    ric_ghost_limits_init(l->atlas, &limits);
    ric_status status = ric_ghost_find(l->atlas, l->branch.id, &limits, &n, &ghosts);
    for (int k = 0; !status && k < n; k++) status = add_ghost(l, ghosts[k]);
    ric_ghosts_free(n, ghosts);
    return status ? cli_report(status) : n ? CLI_DONE : no_ghost(l, path);
}

/* ---------------------------------------------------------------- the command */

static int print(const listing *l, bool ghost, bool multipliers_too, cli_format format)
{
    char *names = cli_table_names(&ric_table_point, format), *columns = NULL;
    if (names &&
        asprintf(&columns, "%s%s%s%s", ghost ? "end " : "", names, ghost ? " admissible" : "",
                 multipliers_too && format != CLI_TEXT ? " multipliers" : "") < 0)
        columns = NULL;
    const int code = columns ? cli_print_rows(l->rows, columns, format) : cli_report(RIC_E_NOMEM);
    free(names);
    free(columns);
    return code;
}

static int list(const char *path, int id, bool physical, bool ghost, cli_format format,
                const cli_choice *choice)
{
    ric_atlas *atlas = NULL;
    listing l = {.rows = json_array()};
    ric_status status = ric_atlas_read(path, &atlas);
    if (!status) status = ric_atlas_branch(atlas, id, &l.branch);
    int code = cli_report(status);
    if (status) goto out;
    const int n_mode = ric_model_n_mode(ric_atlas_model(atlas));
    l.atlas = atlas;
    l.d = cli_unit_of_lengths(ric_atlas_model(atlas), physical);
    l.n_multiplier = format != CLI_TEXT && n_mode > 2 ? 2 * (n_mode - 1) : 0;
    l.multipliers = calloc(2 * (size_t)l.n_multiplier + 1, sizeof *l.multipliers);
    code = !l.multipliers ? cli_report(RIC_E_NOMEM)
           : ghost        ? add_ghosts(&l, path)
                          : cli_report(add_points(&l));
    if (code == CLI_DONE && choice->hertz) cli_in_hertz(l.rows);
    if (code == CLI_DONE && !cli_choose(l.rows, choice)) code = CLI_WRONG;
    if (code == CLI_DONE) code = print(&l, ghost, n_mode > 2, format);
out:
    free(l.multipliers);
    json_decref(l.rows);
    ric_atlas_free(atlas);
    return code;
}

static int run(int argc, char **argv)
{
    cli_format format;
    const char *id_text;
    cli_choice choice;
    long id = 0;
    const bool physical = cli_take_flag(&argc, argv, "--physical"),
               ghost = cli_take_flag(&argc, argv, "--ghost"),
               hertz = cli_take_flag(&argc, argv, "--hz");
    if (!cli_take_format(&argc, argv, &format) || !cli_take_choice(&argc, argv, &choice) ||
        !cli_take_value(&argc, argv, "--branch", &id_text) ||
        !cli_operands(&cli_points, argc, argv, 1))
        return CLI_WRONG;
    choice.hertz = hertz;
    if (!id_text)
        return cli_wrong("points: --branch ID is missing; `ricochet branches %s` lists the ids",
                         argv[1]);
    if (!cli_parse_integer(id_text, "--branch", 1, INT_MAX, &id)) return CLI_WRONG;
    return list(argv[1], (int)id, physical, ghost, format, &choice);
}

static const cli_item items[] = {
    {.text = "The stored points of a branch in order; `ricochet orbit` gives the orbit at any of "
             "them, or between "
             "them."},
    {.name = "trace",
     .text = "of the monodromy without its trivial part, for two modes; sign and exp(logarithm) "
             "beyond the range "
             "of a double. log_trace is the logarithm of its modulus. For more modes both are "
             "empty and --json and "
             "--csv give the multipliers instead, as pairs of real and imaginary part"},
    {.name = "rotation", .text = "gamma in [0, 1): the multipliers are exp(+-2 pi i gamma)"},
    {.name = "stable", .text = "yes, no or undecided"},
    {.name = "reach", .text = "largest gap over clearance in flight: below 1 between touches"},
    {.name = "approach", .text = "smallest speed at which a face is met or a spring left"},
    {.name = "residual", .text = "relative residual of the orbit problem"},
    {.name = "--branch", .value = "ID", .text = "the branch, by its number in `ricochet branches`"},
    CLI_ITEM_AT,
    {.name = "--ghost",
     .text = "the ghosts of the branch instead: what its equations have beyond each end at a "
             "grazing or a corner, "
             "to the border of the study's windows. They are no motions: a gap is penetrated "
             "(reach above 1), or "
             "an impact comes from the wrong side (approach below 0). Nothing of them is in the "
             "atlas. The columns "
             "end and admissible come with it"},
    {.name = "end",
     .text = "of ghosts: from or to, the end of the branch that is extended, outwards; point 0 is "
             "the end itself"},
    {.name = "admissible", .text = "of ghosts: whether all margins are positive again"},
    {.name = "--physical",
     .text = "speeds and energies in the units of the study, not scaled by the clearance"},
    CLI_ITEM_STABLE,
    CLI_ITEMS_PLACE,
    CLI_ITEM_HZ,
    CLI_ITEM_JSON,
    CLI_ITEM_CSV,
    CLI_ITEM_WIDE,
    {0},
};

const cli_command cli_points = {
    .name = "points",
    .summary = "list the stored points of a branch, or its ghosts",
    .usage = "ricochet points ATLAS (--branch ID | --at E,OMEGA) [--ghost] [--physical]\n"
             "           [--stable S] [--energy A,B] [--frequency A,B]\n"
             "           [--sort COLUMN] [--limit N] [--hz] [--json | --csv | --wide]\n",
    .items = items,
    .example = "ricochet points study.ricochet --branch 3 --csv\n"
               "ricochet points study.ricochet --branch 3 --ghost\n",
    .run = run,
};
