/* A section from the command line, shared by `ricochet section` and `ricochet plot section`. */
#ifndef CLI_SECTION_H
#define CLI_SECTION_H

#include "cli.h"

/* Orbits of an atlas at one energy: what the section holds of it. */
typedef struct {
    int branch, impacts;
    ric_stability stable;
    double period;
} cli_section_orbit;

typedef struct {
    int n, room, off; /* off: were found at another energy, and are left out */
    cli_section_orbit *orbits;
    double *states; /* [n * 2 n_dof] */
} cli_section_orbits;

/* All of them that meet a contact, or those of one branch (0: all). */
ric_status cli_section_find(const ric_atlas *atlas, int branch, double energy,
                            cli_section_orbits *out);
void cli_section_release(cli_section_orbits *orbits);

/* What is asked for. */
typedef struct {
    ric_section_options options;
    double energy; /* as it was given */
    long branch;   /* 0: none */
    bool orbits;   /* start at all orbits of the atlas */
    double seconds;
} cli_section_request;

/* Takes --energy, --starts, --impacts, --branch, --orbits, --radius, -j and --seconds out of argv;
 * `what` begins its messages; unless given there are so many starts. */
bool cli_section_take(int *argc, char **argv, const char *what, long starts,
                      cli_section_request *out);

/* The model of a study or an atlas, and the section with every start followed. */
typedef struct {
    ric_study *study;
    ric_atlas *atlas; /* NULL: the file is a study */
    const ric_model *model;
    ric_section *section;
    cli_section_orbits given; /* at which the starts begin; none: the fixed sequence */
    bool late;                /* the time was over */
} cli_section;

/* Reads the file, `d` is the unit of lengths of the energy (0: scaled), and follows the starts,
 * showing progress. Returns an exit code; CLI_LIMIT and CLI_INTERRUPTED leave what was done. */
int cli_section_open(const char *path, cli_section *out);
int cli_section_follow(cli_section_request *request, double d, cli_section *section);
void cli_section_close(cli_section *section);

/* Starts of `ricochet section`, and of a picture, unless given. */
enum { CLI_SECTION_STARTS = 16, CLI_SECTION_DRAWN = 60 };

#define CLI_ITEMS_SECTION                                                                          \
    {.name = "--energy", .value = "E", .text = "scaled energy of all motions"},                    \
        {.name = "--starts",                                                                       \
         .value = "N",                                                                             \
         .text = "how many motions, 16 unless given, 60 in a picture; they begin at a fixed "      \
                 "sequence of places that "                                                        \
                 "fills the section "                                                              \
                 "evenly"},                                                                        \
        {.name = "--impacts", .value = "M", .text = "impacts of each, 1000 unless given"},         \
        {.name = "--branch",                                                                       \
         .value = "ID",                                                                            \
         .text = "of an atlas: start at the orbits of this branch at the energy"},                 \
        {.name = "--orbits", .text = "of an atlas: start at all its orbits of the energy"},        \
        {.name = "--radius",                                                                       \
         .value = "R",                                                                             \
         .text = "with these: N motions spread over a part of the section about them, of this "    \
                 "radius; the whole "                                                              \
                 "section has 1"},                                                                 \
        {.name = "-j",                                                                             \
         .value = "WORKERS",                                                                       \
         .text = "how many at a time, 1 unless given; 0: one for each core"},                      \
        {.name = "--jobs", .value = "WORKERS", .text = "the same"},                                \
    {                                                                                              \
        .name = "--seconds", .value = "S",                                                         \
        .text = "stop after that time and show what was done, with exit code 3"                    \
    }

#endif
