/* What the files of `ricochet prove` share: a list of what is to be proved, and what came of it. */
#ifndef RIC_CLI_PROVE_H
#define RIC_CLI_PROVE_H

#include <string.h>

#include "common/cli.h"
#include "common/workers.h"

typedef struct {
    bool done, kept;
    ric_proof proof;
    ric_curve_proof curve;       /* in its place where curves are proved, */
    ric_junction_proof junction; /* or junctions */
    char *certificate;           /* NULL or "": none */
    ric_arc_proof *arcs;         /* [n_arc] of a curve in work, the first n_arc_kept in the file */
    char **arc_texts;            /* their certificates */
    int n_arc, n_arc_kept;
} prove_result;

typedef struct {
    const char *path; /* of the atlas */
    const ric_atlas *atlas;
    bool curves;    /* proves branches, not points; */
    bool junctions; /* or junctions */
    bool certified; /* with certificates, which are not kept of curves and junctions */
    prove_result *results;
    int n;
    char *model; /* first line of the certificates */
    cli_workers workers;
    struct timespec last; /* when it was kept; and seconds until it is again */
    double pause;
} prove_list;

/* Whether what is kept is to be looked at again: it was refused by a prover of another version. */
static inline bool prove_again(ric_proof_state state, const char *prover)
{
    return state != RIC_PROOF_DONE && strcmp(prover, ric_prover_version()) != 0;
}
/* Keeps what is proved: all that is not kept, at the end; some seconds after the last time, with
 * the mutex of the workers held. */
void prove_keep_rest(prove_list *w);
void prove_keep_some(prove_list *w);
/* A curve, behind the arcs of it that are proved; each further one is kept. */
ric_status prove_curve_on(prove_list *w, ric_prover *prover, prove_result *r);
/* Takes those that the file keeps; up to which point they reach. */
ric_status prove_arcs_begin(const prove_list *w, prove_result *r);
int prove_arcs_reached(const prove_result *r);
void prove_arcs_free(prove_result *r);
/* Keeps in the file of the atlas what is proved now. */
ric_status prove_curves_keep(const prove_list *w, const char *path);
ric_status prove_junctions_keep(const prove_list *w, const char *path);
/* Why an entry of a list is not proved; NULL where it is, is left out, or was not looked at. */
typedef const char *prove_why(const prove_result *r);
/* Of a reason that more than a few have the first entry tells, for all of them: "is", or "and 14
 * more are". false: it was told. */
bool prove_tells(const prove_list *w, prove_why *why, int i, size_t size, char *is);
/* Where the study keeps some of its modes only: what that means here, and what to do. */
void prove_tell_kept(const prove_list *w);
/* Of a list that was stopped: says so, and is the exit code; CLI_DONE if it was not. */
int prove_tell_rest(const prove_list *w, int done, const char *what);
/* Branches that are proved as curves, into the list; and what came of them, the counts to `out`
 * unless it is NULL. */
ric_status prove_curves_add(prove_list *w, int branch);
/* Counts the rest of a curve that is done. */
void prove_curves_count(prove_list *w, const prove_result *r);
int prove_curves_print(const prove_list *w, cli_format format, bool verbose, FILE *out);
/* Junctions, the same. */
ric_status prove_junctions_add(prove_list *w);
int prove_junctions_print(const prove_list *w, cli_format format, bool verbose, FILE *out);
/* prove --complete STUDY ..: a command of its own. */
int prove_complete(int argc, char **argv);
/* Without --complete: false, with a message, if one of its options is given. */
bool prove_complete_only(int *argc, char **argv);

#endif
