/* ricochet prove: what is proved is kept in the file of the atlas, while the rest is worked on and
 * at the end, so that it need not be proved again. It is no failure of the proofs if the file is
 * one that cannot be written, or that a run has open. */
#define _POSIX_C_SOURCE 200809L

#include <stdlib.h>

#include "prove.h"

/* Seconds between two times that it is written meanwhile, and times what writing takes. */
#define BETWEEN 1
#define SHARE 20

static ric_status keep_points(const prove_list *w)
{
    ric_proof *proofs = calloc((size_t)w->n + 1, sizeof *proofs);
    const char **certificates = calloc((size_t)w->n + 1, sizeof *certificates);
    int n = 0;
    for (int i = 0; proofs && certificates && i < w->n; i++) {
        if (!w->results[i].done || w->results[i].kept) continue;
        proofs[n] = w->results[i].proof;
        certificates[n++] = w->results[i].certificate;
    }
    const ric_status status = n ? ric_proof_keep(w->path, w->atlas, n, proofs, certificates)
                                : RIC_OK;
    free(proofs);
    free(certificates);
    return status;
}

/* Arcs of curves in work of which some are new. */
static ric_status keep_arcs(const prove_list *w)
{
    int n = 0;
    for (int i = 0; i < w->n; i++) n += w->results[i].n_arc;
    ric_arc_proof *arcs = calloc((size_t)n + 1, sizeof *arcs);
    if (!arcs) return RIC_E_NOMEM;
    n = 0;
    for (int i = 0; i < w->n; i++) {
        const prove_result *r = &w->results[i];
        for (int k = 0; !r->done && r->n_arc > r->n_arc_kept && k < r->n_arc; k++)
            arcs[n++] = r->arcs[k];
    }
    const ric_status status = n ? ric_arc_proof_keep(w->path, w->atlas, n, arcs) : RIC_OK;
    free(arcs);
    return status;
}

static ric_status keep_new(const prove_list *w)
{
    if (w->junctions) return prove_junctions_keep(w, w->path);
    if (!w->curves) return keep_points(w);
    const ric_status status = prove_curves_keep(w, w->path);
    return status ? status : keep_arcs(w);
}

static ric_status keep(prove_list *w)
{
    struct timespec start;
    clock_gettime(CLOCK_MONOTONIC, &start);
    const ric_status status = keep_new(w);
    for (int i = 0; !status && i < w->n; i++) {
        prove_result *r = &w->results[i];
        r->kept = r->done;
        r->n_arc_kept = r->n_arc;
    }
    w->pause = BETWEEN + SHARE * cli_seconds_since(&start);
    clock_gettime(CLOCK_MONOTONIC, &w->last);
    return status;
}

void prove_keep_rest(prove_list *w)
{
    if (keep(w)) cli_say("ricochet: the proofs are not kept: %s\n", ric_detail());
}

void prove_keep_some(prove_list *w)
{
    if (w->pause == 0) {
        w->pause = BETWEEN;
        w->last = w->workers.start;
    }
    if (cli_seconds_since(&w->last) > w->pause) keep(w); /* what fails is told at the end */
}

/* --------------------------------------------------------------------- arcs */

static ric_status add_arc(prove_result *r, const ric_arc_proof *arc)
{
    ric_arc_proof *more = realloc(r->arcs, (size_t)(r->n_arc + 1) * sizeof *more);
    if (more) r->arcs = more;
    char **texts = more ? realloc(r->arc_texts, (size_t)(r->n_arc + 1) * sizeof *texts) : NULL;
    if (texts) r->arc_texts = texts;
    char *text = texts ? strdup(arc->certificate) : NULL;
    if (!text) return RIC_E_NOMEM;
    texts[r->n_arc] = text;
    more[r->n_arc] = *arc;
    more[r->n_arc++].certificate = text;
    return RIC_OK;
}

static void drop_arcs(prove_result *r)
{
    for (int i = 0; i < r->n_arc; i++) free(r->arc_texts[i]);
    r->n_arc = 0;
}

void prove_arcs_free(prove_result *r)
{
    drop_arcs(r);
    free(r->arcs);
    free(r->arc_texts);
}

ric_status prove_arcs_begin(const prove_list *w, prove_result *r)
{
    int n;
    const ric_arc_proof *arcs = ric_arc_proof_kept(w->atlas, r->curve.branch, &n);
    ric_status status = RIC_OK;
    for (int i = 0; i < n; i++)
        if (strcmp(arcs[i].prover, ric_prover_version()) != 0 || (w->certified && !arcs[i].told))
            n = 0;
    for (int i = 0; i < n && !status; i++) status = add_arc(r, &arcs[i]);
    r->n_arc_kept = r->n_arc;
    return status;
}

int prove_arcs_reached(const prove_result *r)
{
    return r->n_arc ? r->arcs[r->n_arc - 1].point : 0;
}

/* What a thread works on. */
typedef struct {
    prove_list *list;
    prove_result *result;
} working;

static ric_status tell_arc(const ric_arc_proof *arc, void *user)
{
    const working *at = user;
    prove_list *w = at->list;
    pthread_mutex_lock(&w->workers.mutex);
    const int before = prove_arcs_reached(at->result);
    if (arc->point <= before) drop_arcs(at->result); /* it was begun anew */
    const ric_status status = add_arc(at->result, arc);
    atomic_fetch_add(&w->workers.part, arc->point - before);
    if (!status) prove_keep_some(w);
    pthread_mutex_unlock(&w->workers.mutex);
    return status;
}

ric_status prove_curve_on(prove_list *w, ric_prover *prover, prove_result *r)
{
    working at = {w, r};
    /* it grows meanwhile: what was proved before is read where it lies now */
    const int n = r->n_arc;
    ric_arc_proof *before = calloc((size_t)n + 1, sizeof *before);
    if (!before) return RIC_E_NOMEM;
    for (int i = 0; i < n; i++) before[i] = r->arcs[i];
    const ric_curve_work work = {n, before, tell_arc, &at, !w->certified};
    const ric_status status = ric_prover_curve_from(prover, r->curve.branch, &work, &r->curve);
    free(before);
    return status;
}
