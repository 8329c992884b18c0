/* ricochet prove ATLAS --junctions: junctions as zeros of equations of their own. */
#define _POSIX_C_SOURCE 200809L

#include <math.h>
#include <stdlib.h>

#include "prove.h"

static const char *const state_text[] = {"proved", "not proved", "left out"};

ric_status prove_junctions_add(prove_list *w)
{
    const int n = ric_atlas_n_junction(w->atlas);
    w->results = calloc((size_t)n + 1, sizeof *w->results);
    if (!w->results) return RIC_E_NOMEM;
    for (int id = 1; id <= n; id++) {
        prove_result *r = &w->results[w->n++];
        r->junction.junction = id;
        r->done = r->kept = !w->certified && ric_prover_available() &&
                            ric_junction_proof_kept(w->atlas, id, &r->junction) &&
                            !prove_again(r->junction.state, r->junction.prover);
        w->workers.finished += r->done;
    }
    return RIC_OK;
}

ric_status prove_junctions_keep(const prove_list *w, const char *path)
{
    ric_junction_proof *proofs = calloc((size_t)w->n + 1, sizeof *proofs);
    int n = 0;
    for (int i = 0; proofs && i < w->n; i++)
        if (w->results[i].done && !w->results[i].kept) proofs[n++] = w->results[i].junction;
    const ric_status status = !proofs ? RIC_E_NOMEM
                              : n     ? ric_junction_proof_keep(path, w->atlas, n, proofs)
                                      : RIC_OK;
    free(proofs);
    return status;
}

static void add_row(json_t *rows, const ric_junction_proof *p, const ric_junction *junction)
{
    const bool proved = p->state == RIC_PROOF_DONE;
    json_t *row = json_object();
    json_object_set_new(row, "junction", json_integer(p->junction));
    json_object_set_new(row, "label", json_string(junction->label));
    json_object_set_new(row, "kind", json_string(ric_kind_text(junction->kind)));
    json_object_set_new(row, "verdict", json_string(state_text[p->state]));
    json_object_set_new(row, "branch", proved ? json_integer(p->branch) : json_null());
    json_object_set_new(row, "how", json_string(proved ? p->how : ""));
    json_object_set_new(row, "distance", cli_number(proved ? p->distance : NAN));
    json_object_set_new(row, "exists", cli_number(proved ? p->exists : NAN));
    json_object_set_new(row, "unique", cli_number(proved ? p->unique : NAN));
    json_object_set_new(row, "why", json_string(p->why));
    if (proved) {
        json_object_set_new(row, "energy", cli_numbers(2, p->energy, 1));
        json_object_set_new(row, "period", cli_numbers(2, p->period, 1));
    }
    json_array_append_new(rows, row);
}

static const char *why_of(const prove_result *r)
{
    return r->done && r->junction.state == RIC_PROOF_NONE ? r->junction.why : NULL;
}

int prove_junctions_print(const prove_list *w, cli_format format, bool verbose, FILE *out)
{
    static const char columns[] =
        "junction label kind verdict branch how distance exists unique why";
    int count[3] = {0}, done = 0;
    json_t *rows = json_array();
    if (!rows) return cli_report(RIC_E_NOMEM);
    for (int i = 0; i < w->n; i++) {
        const ric_junction_proof *p = &w->results[i].junction;
        ric_junction row;
        if (!w->results[i].done || ric_atlas_junction(w->atlas, p->junction, &row)) continue;
        done++;
        count[p->state]++;
        add_row(rows, p, &row);
        char is[40];
        if (p->state == RIC_PROOF_NONE && format == CLI_TEXT && !verbose &&
            prove_tells(w, why_of, i, sizeof is, is))
            cli_say("ricochet: junction %d %s %s not proved: %s\n", p->junction, row.label, is,
                    p->why);
    }
    if (count[RIC_PROOF_NONE]) prove_tell_kept(w);
    int code = format != CLI_TEXT || verbose ? cli_print_rows(rows, columns, format) : CLI_DONE;
    json_decref(rows);
    if (out)
        cli_tell(out, "%d of %d junctions proved; %d left out\n", count[RIC_PROOF_DONE],
                 count[RIC_PROOF_DONE] + count[RIC_PROOF_NONE], count[RIC_PROOF_LEFT_OUT]);
    if (!code) code = prove_tell_rest(w, done, "junctions");
    return code ? code : count[RIC_PROOF_NONE] ? CLI_FAILED : CLI_DONE;
}
