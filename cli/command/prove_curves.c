/* ricochet prove ATLAS --curves: branches as curves of orbits. */
#define _POSIX_C_SOURCE 200809L

#include <math.h>
#include <stdlib.h>

#include "prove.h"

static const char *const state_text[] = {"proved", "not proved", "left out"};

static int points_of(const prove_list *w, int branch)
{
    ric_branch row;
    return ric_atlas_branch(w->atlas, branch, &row) ? 1 : row.n_point;
}

ric_status prove_curves_add(prove_list *w, int branch)
{
    const int first = branch ? branch : 1, last = branch ? branch : ric_atlas_n_branch(w->atlas);
    w->results = calloc((size_t)(last - first + 1), sizeof *w->results);
    if (!w->results) return RIC_E_NOMEM;
    for (int id = first; id <= last; id++) {
        prove_result *r = &w->results[w->n++];
        r->curve.branch = id;
        r->done = r->kept = !w->certified && ric_prover_available() &&
                            ric_curve_proof_kept(w->atlas, id, &r->curve) &&
                            !prove_again(r->curve.state, r->curve.prover);
        w->workers.finished += r->done;
        const ric_status status = r->done ? RIC_OK : prove_arcs_begin(w, r);
        if (status) return status;
        w->workers.n_part += points_of(w, id) - 1;
        w->workers.part += r->done ? points_of(w, id) - 1 : prove_arcs_reached(r);
    }
    w->workers.parts = "arcs";
    ric_branch row;
    return ric_atlas_branch(w->atlas, first, &row);
}

void prove_curves_count(prove_list *w, const prove_result *r)
{
    atomic_fetch_add(&w->workers.part, points_of(w, r->curve.branch) - 1 - prove_arcs_reached(r));
}

ric_status prove_curves_keep(const prove_list *w, const char *path)
{
    ric_curve_proof *proofs = calloc((size_t)w->n + 1, sizeof *proofs);
    int n = 0;
    for (int i = 0; proofs && i < w->n; i++)
        if (w->results[i].done && !w->results[i].kept) proofs[n++] = w->results[i].curve;
    const ric_status status = !proofs ? RIC_E_NOMEM
                              : n     ? ric_curve_proof_keep(path, w->atlas, n, proofs)
                                      : RIC_OK;
    free(proofs);
    return status;
}

static void add_row(json_t *rows, const ric_curve_proof *p, const char *label)
{
    const bool proved = p->state == RIC_PROOF_DONE;
    json_t *row = json_object();
    json_object_set_new(row, "branch", json_integer(p->branch));
    json_object_set_new(row, "label", json_string(label));
    json_object_set_new(row, "verdict", json_string(state_text[p->state]));
    json_object_set_new(row, "tubes", proved ? json_integer(p->tubes) : json_null());
    json_object_set_new(row, "from", proved ? json_boolean(p->from) : json_null());
    json_object_set_new(row, "to", proved ? json_boolean(p->to) : json_null());
    json_object_set_new(row, "stable", cli_number(proved ? p->stable : NAN));
    json_object_set_new(row, "unstable", cli_number(proved ? p->unstable : NAN));
    json_object_set_new(row, "approach", cli_number(proved ? p->approach : NAN));
    json_object_set_new(row, "why", json_string(p->why));
    json_array_append_new(rows, row);
}

static const char *why_of(const prove_result *r)
{
    return r->done && r->curve.state == RIC_PROOF_NONE ? r->curve.why : NULL;
}

int prove_curves_print(const prove_list *w, cli_format format, bool verbose, FILE *out)
{
    static const char columns[] = "branch label verdict tubes from to stable unstable approach why";
    int count[3] = {0}, done = 0, tubes = 0, whole = 0;
    json_t *rows = json_array();
    if (!rows) return cli_report(RIC_E_NOMEM);
    for (int i = 0; i < w->n; i++) {
        const ric_curve_proof *p = &w->results[i].curve;
        ric_branch row;
        if (!w->results[i].done || ric_atlas_branch(w->atlas, p->branch, &row)) continue;
        done++;
        count[p->state]++;
        tubes += p->tubes;
        whole += p->state == RIC_PROOF_DONE && p->from && p->to;
        add_row(rows, p, row.label);
        char is[40];
        if (p->state == RIC_PROOF_NONE && format == CLI_TEXT && !verbose &&
            prove_tells(w, why_of, i, sizeof is, is))
            cli_say("ricochet: branch %d %s %s not proved to be one curve: %s\n", p->branch,
                    row.label, is, p->why);
    }
    if (count[RIC_PROOF_NONE]) prove_tell_kept(w);
    int code = format != CLI_TEXT || verbose ? cli_print_rows(rows, columns, format) : CLI_DONE;
    json_decref(rows);
    if (out)
        cli_tell(out,
                 "%d of %d curves proved, %d of them from end to end, by %d tubes; %d branches "
                 "left out\n",
                 count[RIC_PROOF_DONE], count[RIC_PROOF_DONE] + count[RIC_PROOF_NONE], whole, tubes,
                 count[RIC_PROOF_LEFT_OUT]);
    if (!code) code = prove_tell_rest(w, done, "branches");
    return code ? code : count[RIC_PROOF_NONE] ? CLI_FAILED : CLI_DONE;
}
