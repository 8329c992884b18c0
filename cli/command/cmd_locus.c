/* ricochet locus ATLAS: a junction as a parameter of the structure varies. */
#include <stdio.h>
#include <string.h>

#include "common/locus.h"

static json_t *point_row(const cli_locus *x, const ric_junction *j, const ric_locus_point *p,
                         bool physical)
{
    const int n = ric_model_n_dof(ric_atlas_model(x->atlas)),
              flights = j->letters > 0 ? j->letters : 1;
    const double d = physical ? p->length : 1;
    json_t *row = json_object();
    json_object_set_new(row, "parameter", json_string(x->vary.name));
    json_object_set_new(row, "value", cli_number(p->value));
    json_object_set_new(row, "energy", cli_energy(p->energy, d));
    json_object_set_new(row, "frequency", cli_number(p->frequency));
    json_object_set_new(row, "mark", json_string(ric_locus_mark_text(p->mark)));
    json_object_set_new(row, "what", json_string(p->what));
    json_object_set_new(row, "length", cli_number(p->length));
    json_object_set_new(row, "residual", cli_number(p->residual));
    json_object_set_new(row, "state", cli_numbers(2 * n, p->state, d));
    json_object_set_new(row, "flights", cli_numbers(flights, p->flights, 1));
    return row;
}

/* In one line where the curve ends, and how often it turns. */
static void summarise(const cli_locus *x)
{
    const int n = ric_locus_n_point(x->locus);
    int folds = 0;
    ric_locus_point p, ends[2];
    for (int i = 0; i < n; i++)
        if (!ric_locus_point_at(x->locus, i, &p)) folds += p.mark == RIC_LOCUS_FOLD;
    if (!n || ric_locus_point_at(x->locus, 0, &ends[0]) ||
        ric_locus_point_at(x->locus, n - 1, &ends[1]))
        return;
    cli_say("%d point%s, %d fold%s; from %s = %.9g", n, cli_plural(n), folds, cli_plural(folds),
            x->vary.name, ends[0].value);
    cli_say(" (%s) to %.9g", ends[0].what, ends[1].value);
    cli_say(" (%s)\n", ends[1].what);
}

static int run(int argc, char **argv)
{
    static const char columns[] = "value energy frequency mark what";
    cli_format format;
    cli_locus_request request;
    cli_locus x = {.atlas = NULL};
    ric_junction j;
    const bool physical = cli_take_flag(&argc, argv, "--physical"),
               hertz = cli_take_flag(&argc, argv, "--hz");
    if (!cli_take_format(&argc, argv, &format) || !cli_locus_take(&argc, argv, "locus", &request) ||
        !cli_operands(&cli_locus_command, argc, argv, 1))
        return CLI_WRONG;
    int code = cli_locus_open(argv[1], &request, &x);
    if (x.locus && !ric_atlas_junction(x.atlas, request.junction, &j)) {
        json_t *rows = json_array();
        ric_locus_point p;
        for (int i = 0; i < ric_locus_n_point(x.locus); i++)
            if (!ric_locus_point_at(x.locus, i, &p))
                json_array_append_new(rows, point_row(&x, &j, &p, physical));
        if (hertz) cli_in_hertz(rows);
        const int printed = cli_print_rows(rows, columns, format);
        summarise(&x);
        json_decref(rows);
        if (printed) code = printed;
    }
    cli_locus_close(&x);
    return code;
}

static const cli_item items[] = {
    {.text = "Follows a junction while the parameter of section vary changes the structure: a "
             "curve in the plane of "
             "the parameter and the energy or the frequency, through its own folds, where two "
             "junctions annihilate "
             "each other, to the border of the range or to a place of codimension two. Rigid "
             "stops, bilinear springs "
             "and power laws; docs/loci.md."},
    {.name = "value, energy, frequency",
     .text = "of the parameter; of the orbit, scaled by the clearance that the first contact has "
             "there, and in rad/s"},
    {.name = "mark, what",
     .text = "start: the junction of the atlas; asked; fold; meets: it is another kind of "
             "junction, too; end, and why"},
    CLI_ITEMS_LOCUS,
    {.name = "--physical", .text = "energies and states in the study's own units of length"},
    CLI_ITEM_HZ,
    CLI_ITEM_JSON,
    CLI_ITEM_CSV,
    {0},
};

const cli_command cli_locus_command = {
    .name = "locus",
    .summary = "a junction as a parameter of the structure varies",
    .usage = "ricochet locus ATLAS --junction J [--study FILE] [--values A,B,..] [--max-step H]\n"
             "           [--physical] [--hz] [--json | --csv]\n",
    .items = items,
    .example = "ricochet locus varied.ricochet --junction C1_32 --values 0.5,2\n",
    .run = run,
};
