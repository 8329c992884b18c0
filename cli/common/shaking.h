/* What shakes a structure: the options that `force` and `response` share. */
#ifndef CLI_SHAKING_H
#define CLI_SHAKING_H

#include "common/cli.h"

enum { CLI_NUMBERS_MOST = 1000, CLI_HARMONICS_MOST = 64 };

typedef struct {
    double force[CLI_NUMBERS_MOST], ratios[CLI_NUMBERS_MOST], *matrix;
    int n_force, n_ratio, n_matrix; /* n_force 0: not given */
    double restitution, restitutions[2];
    int n_restitution; /* as given; the last one counts where one is wanted */
    int harmonics[CLI_HARMONICS_MOST], n_harmonic;
    bool harmonic_given;
    ric_numbers amplitude; /* of the study; n 0: none */
    double frequency[2];   /* of the study; 0, 0: none */
} cli_shaking;

bool cli_take_shaking(int *argc, char **argv, cli_shaking *out, int *code);
/* The same from the study of a file, which has to be that of this structure, or from `own` where
 * path is NULL; the exit code. */
int cli_shaking_read(cli_shaking *shaking, const char *command, const char *path,
                     const ric_study *own);
/* One sentence about the losses and the force of a study, which its atlas has not; "" without them.
 */
const char *cli_forcing_remark(const ric_study *study);
/* The same on standard error, of what else is made of the study in file `name`: "the section". */
void cli_forcing_warn(const ric_study *study, const char *name, const char *what);
/* Borrows. */
ric_shaking cli_shaking_of(const cli_shaking *shaking);
void cli_shaking_free(cli_shaking *shaking);

/* One motion under damping and force, from a state: what `simulate` and `plot simulate` take. */
typedef struct {
    cli_shaking shaking;
    bool is_shaken;             /* under damping or force, or a restitution that was given */
    bool phased, own_force;     /* --omega, --level or --phase; --force */
    bool still;                 /* --omega 0 */
    double omega, level, phase; /* level NaN: not given */
} cli_drive;

bool cli_take_drive(int *argc, char **argv, cli_drive *out, int *code);
/* Options, and the study where they say nothing; `command` for messages. The exit code. */
int cli_drive_complete(cli_drive *drive, const char *command, const ric_study *study);
/* The shaken structure at a state [2n] at time 0. */
ric_status cli_drive_start(const cli_drive *drive, const ric_model *model, const double *state,
                           ric_shaken **out);

#define CLI_ITEMS_SHAKING                                                                          \
    {.name = "--force",                                                                            \
     .value = "F1,F2,..",                                                                          \
     .text = "the vector f, one number per displacement, physical"},                               \
        {.name = "--damping",                                                                      \
         .value = "ZETA|FILE",                                                                     \
         .text = "modal damping ratios, one for all modes or one for each, Z1,Z2,..; or a Matrix " \
                 "Market file with "                                                               \
                 "the damping "                                                                    \
                 "matrix C, physical"},                                                            \
        {.name = "--restitution",                                                                  \
         .value = "E",                                                                             \
         .text = "of all rigid stops, above 0; 1, which loses nothing, unless given"},             \
    {                                                                                              \
        .name = "--harmonic", .value = "M",                                                        \
        .text = "harmonics m of the orbit, M or M1,M2,..; 1 unless given"                          \
    }

#define CLI_ITEM_SHAKING_STUDY                                                                     \
    {                                                                                              \
        .name = "--study", .value = "STUDY",                                                       \
        .text = "takes what is not given, as force, damping, restitution, levels and "             \
                "frequencies, from this study "                                                    \
                "instead of the one in the atlas"                                                  \
    }

#endif
