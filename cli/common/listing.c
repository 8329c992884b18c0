/* The units in which an atlas is listed, and the commands that list it. */
#include <math.h>
#include <stdlib.h>

#include "cli.h"

const char *cli_plural(long n)
{
    return n == 1 ? "" : "s";
}

double cli_unit_of_lengths(const ric_model *model, bool physical)
{
    const ric_units *names = ric_model_units(model);
    if (physical && *names->length)
        cli_say("ricochet: lengths in %s, speeds in %s/%s, energies in %s %s\n", names->length,
                names->length, names->time, names->force, names->length);
    const double d = physical ? ric_model_length(model) : 1;
    if (isnan(cli_unit_of_energies(d)))
        cli_say("ricochet: lengths go by %g here, and energies by its square, which no double "
                "holds: they are left out; "
                "without --physical they are scaled\n",
                d);
    return d;
}

double cli_unit_of_energies(double d)
{
    return isnormal(d * d) ? d * d : NAN;
}

json_t *cli_energy(double energy, double d)
{
    return cli_number(cli_unit_of_energies(d) * energy);
}

static ric_status add_rows(json_t *rows, const cli_listing *listing, const ric_atlas *atlas,
                           bool physical)
{
    const double d = cli_unit_of_lengths(ric_atlas_model(atlas), physical);
    if (listing->rows) return listing->rows(atlas, d, listing->user, rows);
    for (int id = 1; id <= listing->count(atlas); id++) {
        json_t *row = json_object();
        ric_status status = listing->row(atlas, id, d, row);
        json_array_append_new(rows, row);
        if (status) return status;
    }
    return RIC_OK;
}

int cli_list(const cli_listing *listing, int argc, char **argv)
{
    cli_format format;
    ric_atlas *atlas = NULL;
    json_t *rows = json_array();
    int code = CLI_WRONG;
    cli_choice choice;
    const bool physical = cli_take_flag(&argc, argv, "--physical"),
               hertz = cli_take_flag(&argc, argv, "--hz");
    if (!cli_take_format(&argc, argv, &format) || !cli_take_choice(&argc, argv, &choice) ||
        !cli_operands(listing->command, argc, argv, 1))
        goto out;
    ric_status status = ric_atlas_read(argv[1], &atlas);
    if (!status) status = add_rows(rows, listing, atlas, physical);
    if (!status && hertz) cli_in_hertz(rows);
    if (!status && !cli_choose(rows, &choice)) goto out;
    char *names = listing->table ? cli_table_names(listing->table, format) : NULL;
    const char *columns = names ? names : format == CLI_TEXT ? listing->few : listing->all;
    code = status    ? cli_report(status)
           : columns ? cli_print_rows(rows, columns, format)
                     : cli_report(RIC_E_NOMEM);
    free(names);
out:
    json_decref(rows);
    ric_atlas_free(atlas);
    return code;
}
