/* ricochet prove ATLAS: what it says of itself. The work is done by the module prove, which brings
 * FLINT. */
#include "common/module.h"
#include "prove.h"

static int run(int argc, char **argv)
{
    return cli_module_run("prove", "prove_command", argc, argv);
}

int cli_prove_atlas(const char *path, int workers, FILE *out)
{
    int (*prove)(const char *, int,
                 FILE *) = (int (*)(const char *, int, FILE *))cli_module_find("prove",
                                                                               "prove_atlas");
    return prove ? prove(path, workers, out) : CLI_FAILED;
}

static const cli_item items[] = {
    {.text = "Proves by ball arithmetic that there is exactly one orbit with the word of its "
             "branch near a stored "
             "point, that its impacts approach and no stop is passed in between, encloses its "
             "energy, period and trace, "
             "and decides its stability. The decimals of masses, stiffnesses, normals and "
             "clearances count as exact. "
             "docs/proofs.md states the theorems, which hold for stops and for springs of law "
             "bilinear; power laws are "
             "left "
             "out. Proofs are kept in the atlas, outside its digest, and what is kept is not "
             "proved again."},
    {.name = "verdict", .text = "proved, not proved (and why), or left out"},
    {.name = "bits", .text = "of the numbers that were needed: 128, 256 or 512"},
    {.name = "distance",
     .text = "of the orbit that was proved from the stored one, relative; at most 1e-8"},
    {.name = "exists, unique",
     .text = "radii: the orbit is within the first one of a centre, and there is no other within "
             "the second with the same "
             "value of the number that is held"},
    {.name = "approach", .text = "no impact is slower"},
    {.name = "stable, symmetric, reversible", .text = "as proved"},
    {.name = "--branch", .value = "ID", .text = "only this branch"},
    CLI_ITEM_AT,
    {.name = "--point", .value = "I", .text = "with --branch: only this point, from 0"},
    {.name = "--curves",
     .text = "branches as curves: that the orbits between its points are one arc of motions, in "
             "tubes that are glued "
             "where they meet, up to the grazings that end them and from the mirrors that are "
             "broken where they begin. "
             "Columns branch, label, verdict, tubes, "
             "from, to (whether its first and last points are on it, too), stable, unstable "
             "(proved on these shares of "
             "its length), approach, why"},
    {.name = "--junctions",
     .text = "junctions as zeros of equations of their own, each the only one nearby: impacts of "
             "no speed and gaps that "
             "touch, where branches end; turns of energy and period; where a mirror is broken, and "
             "where multipliers "
             "pass a root of unity, so that branches cross. Columns junction, label, kind, "
             "verdict, branch (in the "
             "class of which), how (what vanishes), distance, exists, unique, why"},
    {.name = "--complete",
     .text = "experimental, of a STUDY of rigid stops that see two modes: all periodic orbits of "
             "one energy with few "
             "impacts. Flight times are divided into boxes, each proved to have no orbit or to lie "
             "where exactly one "
             "is; boxes that are neither are counted and measured. A hunt for the same orbits "
             "follows, and what it "
             "finds has to be there. An orbit stands for its images, run backwards, mirrored, or "
             "begun at another "
             "impact. The exit code is 1 unless all is decided"},
    {.name = "--energy", .value = "E", .text = "with --complete: the scaled energy"},
    {.name = "--impacts",
     .value = "N",
     .text = "with --complete: words of up to N letters, 3 unless given, 6 at most"},
    {.name = "--period",
     .value = "T",
     .text = "with --complete: periods up to T seconds; unless given 2 pi over the lower end of "
             "the study's frequency "
             "window. Where both modes reach a stop at this energy, no flight lasts for ever, and "
             "a longest one is "
             "proved: then all periods are looked through if T is long enough"},
    {.name = "--physical",
     .text = "with --complete: energies, --energy too, and states in the units of the study"},
    CLI_ITEM_SORT,
    CLI_ITEM_HZ,
    {.name = "-o",
     .value = "FILE",
     .text = "write certificates, one line of JSON for each point, curve, or grazing of which an "
             "impact has no speed"},
    {.name = "-j",
     .value = "WORKERS",
     .text = "how many at a time, 1 unless given; 0: one for each core"},
    {.name = "--jobs", .value = "WORKERS", .text = "the same"},
    {.name = "--seconds", .value = "S", .text = "stop after that time and show what was done"},
    {.name = "--verbose", .text = "a row for every point as well"},
    {.text = "The exit code is 1 if a curve or a junction is not proved, or a point that is no end "
             "of a branch, 3 if "
             "the time was "
             "over, 130 after "
             "Ctrl-C."},
    CLI_ITEM_JSON,
    CLI_ITEM_CSV,
    CLI_ITEM_WIDE,
    {0},
};

const cli_command cli_prove = {
    .name = "prove",
    .summary = "prove the orbits of an atlas, by ball arithmetic",
    .usage =
        "ricochet prove ATLAS [(--branch ID | --at E,OMEGA) [--point I]] [-o FILE]\n"
        "                      [-j WORKERS | --jobs WORKERS] [--seconds S] [--verbose] [--json | "
        "--csv]\n"
        "ricochet prove ATLAS --curves [--branch ID | --at E,OMEGA] [-o FILE] [-j WORKERS]\n"
        "                      [--seconds S] [--json | --csv]\n"
        "ricochet prove ATLAS --junctions [-o FILE] [-j WORKERS] [--seconds S] [--json | --csv]\n"
        "ricochet prove STUDY --complete --energy E [--impacts N] [--period T] [-j WORKERS]\n"
        "                      [--seconds S] [--physical] [--hz] [--sort COLUMN]\n"
        "                      [--json | --csv | --wide]\n",
    .items = items,
    .example = "ricochet prove study.ricochet --branch 3\n"
               "ricochet prove examples/elementary/study.yaml --complete --energy 5 --impacts 2\n",
    .run = run,
};
