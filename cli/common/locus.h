/* A locus from the command line, shared by `ricochet locus` and `ricochet plot locus`. */
#ifndef CLI_LOCUS_H
#define CLI_LOCUS_H

#include "cli.h"

enum { CLI_LOCUS_VALUES = 256 };

typedef struct {
    int junction;
    const char *study; /* file whose section vary is taken; NULL: that of the atlas */
    int n_value;
    double values[CLI_LOCUS_VALUES], max_step;
} cli_locus_request;

/* Takes --junction, --study, --values and --max-step out of argv; `what` begins its messages. */
bool cli_locus_take(int *argc, char **argv, const char *what, cli_locus_request *out);

typedef struct {
    ric_atlas *atlas;
    ric_study *study; /* NULL: the section is that of the atlas */
    ric_vary vary;
    ric_locus *locus;
} cli_locus;

/* Reads the atlas and follows the junction, showing progress. Returns an exit code; CLI_INTERRUPTED
 * leaves what was found. */
int cli_locus_open(const char *path, const cli_locus_request *request, cli_locus *out);
void cli_locus_close(cli_locus *locus);

#define CLI_ITEMS_LOCUS                                                                            \
    {.name = "--junction",                                                                         \
     .value = "J",                                                                                 \
     .text = "the junction: id, key, name, label, or place E,OMEGA"},                              \
        {.name = "--study",                                                                        \
         .value = "FILE",                                                                          \
         .text = "study whose section vary is taken, of the same structure; that of the atlas "    \
                 "unless given"},                                                                  \
        {.name = "--values",                                                                       \
         .value = "A,B,..",                                                                        \
         .text = "values of the parameter at which the junction is solved as well, rows marked "   \
                 "`asked`"},                                                                       \
    {                                                                                              \
        .name = "--max-step", .value = "H",                                                        \
        .text = "largest step along the curve, of the range of the parameter and of the size of "  \
                "the orbit; 0.03 "                                                                 \
                "unless given"                                                                     \
    }

#endif
