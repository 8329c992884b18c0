/* ricochet export ATLAS: what it says of itself. The work is done by the module export, which
 * brings HDF5 and matio. */
#include "common/cli.h"
#include "common/module.h"

static int run(int argc, char **argv)
{
    return cli_module_run("export", "export_command", argc, argv);
}

static const cli_item items[] = {
    {.text = "Writes all of an atlas for other programs: HDF5 (h5py, Julia, Matlab), a MAT file of "
             "version 5 (Octave, "
             "Matlab, SciPy) or comma-separated columns. Numbers are those of the atlas to the "
             "last bit, lengths scaled "
             "by the clearance, and so are the names of the columns, which are those of --json."},
    {.name = "about",
     .text =
         "one row: program, n_dof, length (the clearance), finished (0 if the run was stopped)"},
    {.name = "branches",
     .text = "one row per branch, as `ricochet branches` has them, with lists resonances_m, "
             "resonances_n, .. of its resonances"},
    {.name = "points",
     .text =
         "all stored points in the order of branches: branch, point (from 0), arclength, energy, "
         "frequency, period, trace, log_trace, rotation, stable (0 no, 1 yes, 2 undecided), reach, "
         "approach, residual, state (x then v), flights"},
    {.name = "junctions", .text = "one row per junction, as `ricochet junctions` has them"},
    {.name = "graph",
     .text =
         "one row for every junction on every branch: branch, junction, arclength and place (from, "
         "inner or to)"},
    {.text = "A table is a group in HDF5, a structure in a MAT file, and in CSV a part of the file "
             "after a line '# NAME'. "
             "Rows of different lengths (flights, word lists) follow each other in one column, and "
             "NAME_n says how many "
             "each has; in CSV they are one cell with blanks between. What is not there is NaN or "
             "empty, 0 of an id or "
             "a number, and -1 of what is yes (1) or no (0)."},
    {.name = "-o",
     .value = "FILE",
     .text = "the file to write, its ending .h5, .mat or .csv; it takes the place of one "
             "that is there when all of it is written"},
    {0},
};

const cli_command cli_export = {
    .name = "export",
    .summary = "write an atlas as HDF5, as a MAT file or as CSV",
    .usage = "ricochet export ATLAS -o FILE\n",
    .items = items,
    .example = "ricochet export study.ricochet -o study.h5\n",
    .run = run,
};
