/* What the files of `ricochet prove` share: a list of what is to be proved, and what came of it. */
#ifndef RIC_CLI_PROVE_H
#define RIC_CLI_PROVE_H

#include "common/cli.h"
#include "common/workers.h"

typedef struct {
    bool done, kept;
    ric_proof proof;
    ric_curve_proof curve;       /* in its place where curves are proved, */
    ric_junction_proof junction; /* or junctions */
    char *certificate;           /* NULL or "": none */
} prove_result;

typedef struct {
    const ric_atlas *atlas;
    bool curves;    /* proves branches, not points; */
    bool junctions; /* or junctions */
    bool certified; /* with certificates, which are not kept of curves and junctions */
    prove_result *results;
    int n;
    char *model; /* first line of the certificates */
    cli_workers workers;
} prove_list;

/* Keeps in the file of the atlas what is proved now. */
ric_status prove_curves_keep(const prove_list *w, const char *path);
ric_status prove_junctions_keep(const prove_list *w, const char *path);
/* Of a list that was stopped: says so, and is the exit code; CLI_DONE if it was not. */
int prove_tell_rest(const prove_list *w, int done, const char *what);
/* Branches that are proved as curves, into the list; and what came of them, the counts to `out`
 * unless it is NULL. */
ric_status prove_curves_add(prove_list *w, int branch);
int prove_curves_print(const prove_list *w, cli_format format, bool verbose, FILE *out);
/* Junctions, the same. */
ric_status prove_junctions_add(prove_list *w);
int prove_junctions_print(const prove_list *w, cli_format format, bool verbose, FILE *out);
/* prove --complete STUDY ..: a command of its own. */
int prove_complete(int argc, char **argv);
/* Without --complete: false, with a message, if one of its options is given. */
bool prove_complete_only(int *argc, char **argv);

#endif
