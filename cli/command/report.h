/* What the files of `ricochet report` share: its rows, and the items that `run` counts. */
#ifndef RIC_CLI_REPORT_H
#define RIC_CLI_REPORT_H

#include "common/cli.h"

/* Items that name one branch or junction of which places are known to less than others. */
#define CLI_REPORT_RANGES "places known to less on branch"
#define CLI_REPORT_BESIDE "last orbit beside the junction of branch"
#define CLI_REPORT_ALONG "a mode goes along on branch"
#define CLI_REPORT_CLOSE "grazings beside a singular point"
#define CLI_REPORT_TURNS "turns without a junction on branch"
#define CLI_REPORT_ASIDE "junctions aside of their orbits"
#define CLI_REPORT_STILL "corners without speed"
#define CLI_REPORT_LOST "multiplications of lost multipliers"
#define CLI_REPORT_OPEN "label not decided of junction"

/* Appends a row and lends it, so that numbers can be added that only --json shows; NULL: no
 * memory. */
json_t *cli_report_add(json_t *rows, const char *item, json_t *value, const char *detail);

/* report_places.c: where energies are known to less than 1e-9 of themselves, to what, and why. */
ric_status cli_report_places(const ric_atlas *atlas, json_t *rows);

#endif
