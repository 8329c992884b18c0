/* ricochet help: what a command does, and what a word means. */
#include <stdio.h>
#include <string.h>

#include "study/options.h"
#include "common/cli.h"

enum {
    WIDTH = 100, /* columns */
    NAMES = 18,  /* columns of the words */
};

typedef struct {
    const char *word, *meaning;
} entry;

/* In alphabetical order. docs/glossary.md is this list, which the tests make sure of. */
static const entry glossary[] = {
    {"approach", "smallest speed at which a face is met: 0 at a grazing"},
    {"atlas",
     "what a run writes, one file: branches of periodic orbits and the junctions where they meet"},
    {"backbone", "the branch that a linear mode turns into where it first touches a contact"},
    {"base", "the branches that departures from one branch lead to, ordered by multiplicity "
             "(`ricochet bases`)"},
    {"branch", "a curve of periodic orbits that have their impacts in the same order; energy and "
               "frequency change along "
               "it. A branch and its mirror images are one"},
    {"branch point",
     "a junction where branches of lower symmetry, or of another kind, cross a branch"},
    {"corner",
     "a junction where two margins are lost at once, such as a touch in the moment of an impact"},
    {"departure", "a branch that may leave from a junction; each is tried once, and what became of "
                  "it is counted: taken, "
                  "known, inadmissible, over budget or refused"},
    {"depth",
     "how many departures lie between a branch and the linear modes, along the shortest way"},
    {"duplicate", "a branch gone through k times: the same motions, at frequency / k"},
    {"face", "one side of a contact. Faces are counted contact by contact, upper before lower, 0 "
             "to 9 and a to z"},
    {"ghost",
     "what the equations of a branch give beyond a grazing, where the orbit is no motion any more"},
    {"grazing", "a touch of a face with speed zero; there a branch ends or another one leaves"},
    {"inadmissible", "of a departure: only ghosts leave there, no motions"},
    {"junction", "an orbit where branches begin, end, meet or turn"},
    {"known", "of a departure: the branch was found another way"},
    {"multiplication",
     "a junction where a branch of q times the period leaves, q-tupling; 2 is a period doubling"},
    {"onset", "of a mode: the energy at which it first touches a contact; under a power law, where "
              "the force matters"},
    {"reach", "largest gap over clearance in flight: 1 at a touch"},
    {"scaled", "with lengths divided by the clearance d of the first contact, energies by d "
               "squared; --physical undoes it"},
    {"segment", "the part of a branch between two junctions that follow each other"},
    {"state", "displacements, then velocities, right after the first impact of the word"},
    {"study", "the YAML text that says what the structure is and where to look; `ricochet new` "
              "writes one with comments, "
              "`ricochet help study --schema` the JSON schema of it for editors"},
    {"tongue", "an internal resonance: where a linear mode turns m times while the motion goes "
               "round n times, a branch climbs "
               "along that mode, at a frequency that all but stays; behind a narrow one a branch "
               "may be continued "
               "(`explore.tongues`)"},
    {"word", "the faces that an orbit meets in one period, in order, such as 01"},
};

static void put_entry(const entry *e)
{
    printf("%-*s", NAMES, e->word);
    cli_print_wrapped(e->meaning, NAMES, NAMES, WIDTH);
}

static void put_glossary(void)
{
    for (size_t i = 0; i < sizeof glossary / sizeof *glossary; i++) put_entry(&glossary[i]);
}

static const entry *find(const char *word)
{
    for (size_t i = 0; i < sizeof glossary / sizeof *glossary; i++)
        if (!strcmp(word, glossary[i].word)) return &glossary[i];
    return NULL;
}

static int explain(const char *word)
{
    cli_guess guess = {.word = word};
    const entry *e = find(word);
    for (const cli_command *const *c = cli_commands; *c; c++) {
        if (!strcmp(word, (*c)->name)) {
            cli_print_help(*c);
            return CLI_DONE;
        }
        cli_nearest(&guess, (*c)->name);
    }
    if (e) {
        put_entry(e);
        return CLI_DONE;
    }
    for (size_t i = 0; i < sizeof glossary / sizeof *glossary; i++)
        cli_nearest(&guess, glossary[i].word);
    return cli_wrong("help: '%s' is no command and not in the glossary%s%s%s; `ricochet help` "
                     "lists the commands, "
                     "`ricochet help glossary` the words",
                     word, guess.known ? "; did you mean '" : "", guess.known ? guess.known : "",
                     guess.known ? "'" : "");
}

/* `help plot fep`: what belongs to one picture of a command. */
static int explain_picture(int argc, char **argv)
{
    const cli_command *command = NULL;
    for (const cli_command *const *c = cli_commands; *c; c++)
        if (!strcmp(argv[1], (*c)->name) && cli_has_pictures(*c)) command = *c;
    if (!command) return cli_operands(&cli_help, argc, argv, 1) ? CLI_DONE : CLI_WRONG;
    const char *picture = cli_find_picture(command, 2, argv + 1);
    if (!picture)
        return cli_wrong("help: %s has no picture '%s'; `ricochet help %s` lists them", argv[1],
                         argv[2], argv[1]);
    cli_print_picture_help(command, picture);
    return CLI_DONE;
}

static int run(int argc, char **argv)
{
    const bool schema = cli_take_flag(&argc, argv, "--schema");
    if (schema) {
        if (argc > 1 && strcmp(argv[1], "study") != 0)
            return cli_wrong("help: --schema is that of a study: ricochet help study --schema");
        ric_options_schema(stdout);
        return CLI_DONE;
    }
    if (argc == 1) {
        cli_print_program_help(stdout);
        return CLI_DONE;
    }
    if (argc == 3) return explain_picture(argc, argv);
    if (!cli_operands(&cli_help, argc, argv, 1)) return CLI_WRONG;
    if (strcmp(argv[1], "glossary") != 0) return explain(argv[1]);
    put_glossary();
    return CLI_DONE;
}

static const cli_item items[] = {
    {.text = "Without anything behind it the commands; behind a command what that does, its "
             "options and an example; "
             "behind a word of the glossary what it means."},
    {.name = "PICTURE", .text = "behind `plot`: what belongs to that picture"},
    {.name = "--schema",
     .text = "behind `study`: the JSON schema of a study, by which editors complete and check it"},
    {.name = "glossary", .text = "all words that lists, pictures and messages use"},
    {0},
};

const cli_command cli_help = {
    .name = "help",
    .summary = "what a command does, or what a word means",
    .usage = "ricochet help [COMMAND | plot PICTURE | WORD | glossary | study --schema]\n",
    .items = items,
    .example = "ricochet help run\n"
               "ricochet help plot fep\n"
               "ricochet help departure\n"
               "ricochet help study --schema\n",
    .run = run,
};
