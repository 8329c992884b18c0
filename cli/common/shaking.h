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
} cli_shaking;

bool cli_take_shaking(int *argc, char **argv, cli_shaking *out, int *code);
/* Borrows. */
ric_shaking cli_shaking_of(const cli_shaking *shaking);
void cli_shaking_free(cli_shaking *shaking);

#define CLI_ITEMS_SHAKING                                                                                              \
    {.name = "--force", .value = "F1,F2,..", .text = "the vector f, one number per displacement, physical"},           \
        {.name = "--damping",                                                                                          \
         .value = "ZETA|FILE",                                                                                         \
         .text = "modal damping ratios, one for all modes or one for each, Z1,Z2,..; or a Matrix Market file with "    \
                 "the damping "                                                                                        \
                 "matrix C, physical"},                                                                                \
        {.name = "--restitution",                                                                                      \
         .value = "E",                                                                                                 \
         .text = "of all rigid stops, above 0; 1, which loses nothing, unless given"},                                 \
    {                                                                                                                  \
        .name = "--harmonic", .value = "M", .text = "harmonics m of the orbit, M or M1,M2,..; 1 unless given"          \
    }

#endif
