/* From a junction of an atlas to what vanishes there. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "locus_parts.h"
#include "request/room.h"

/* By its energy and frequency; of modes of one frequency none is meant. */
int ric_locus_start_mode(const ric_atlas *atlas, const ric_junction *j)
{
    const ric_model *m = ric_atlas_model(atlas);
    const int n = m->n_dof;
    double energy[n];
    int contact[n], found = -1, equal = 0;
    if (j->kind != RIC_KIND_GRAZING || j->letters || ric_model_grazing_energies(m, energy, contact))
        return -1;
    for (int i = 0; i < n; i++) {
        if (!m->seen[i] ||
            fabs(m->frequency[i] / (j->multiple * j->frequency) - 1) > RIC_SAME_SOLVED)
            continue;
        equal++;
        if (fabs(energy[i] / j->energy - 1) <= RIC_SAME_SOLVED) found = i;
    }
    return equal == 1 ? found : -1;
}

/* A branch that passes the junction, else one that ends there. */
static ric_status branch_of(const ric_atlas *atlas, const ric_junction *j, ric_branch *out)
{
    ric_status status = ric_fail(RIC_E_RANGE, "no branch meets junction %d", j->id);
    for (int i = 0; i < j->n_branch; i++) {
        ric_branch b;
        const ric_status read = ric_atlas_branch(atlas, j->branches[i], &b);
        if (read) return read;
        if (!status && (b.from == j->id || b.to == j->id)) continue;
        *out = b;
        status = RIC_OK;
        if (b.from != j->id && b.to != j->id) break;
    }
    return status;
}

static ric_status orbit_of(const ric_atlas *atlas, const ric_junction *j, ric_periodic **out)
{
    const ric_model *m = ric_atlas_model(atlas);
    const int letters = j->letters > 0 ? j->letters : 1;
    ric_branch branch = {.id = 0};
    double tau[letters];
    ric_status status = branch_of(atlas, j, &branch);
    if (status) return status;
    for (int i = 0; i < letters; i++) tau[i] = j->flights[i] * m->omega_ref;
    if (!(*out = ric_periodic_spelled(m, j->letters, j->word, tau)))
        return ric_no_memory("the orbit of a junction");
    ric_model_from_state(m, j->state, j->state + m->n_dof, (*out)->w);
    if (ric_periodic_has_events(m)) ric_periodic_find_symmetries(m, *out, RIC_SAME_LOCATED);
    else {
        const ric_periodic_claim claim = {branch.symmetric, branch.reversible,
                                          strstr(branch.mirror, "centre"),
                                          strstr(branch.mirror, "rest"),
                                          strstr(branch.mirror, "impact")};
        ric_periodic_claimed(m, &claim, *out);
    }
    return ric_trust(RIC_OK);
}

/* Which kernel a branch point has: that whose zero is found again at its orbit. RIC_N_TEST: none of
 * them. */
static int kernel_of(const ric_model *m, const ric_periodic *cycle)
{
    static const int tests[] = {RIC_TEST_A, RIC_TEST_B, RIC_TEST_D, RIC_TEST_DET};
    const bool plain = !cycle->half && cycle->pure < 0 && cycle->flip < 0;
    for (int i = plain ? 3 : 0; i < (int)(sizeof tests / sizeof *tests); i++) {
        ric_periodic *found = ric_node_solve(m, cycle, (ric_criterion){.test = tests[i]}, NULL);
        const bool same = found && ric_periodic_same(m, cycle, found, RIC_SAME_LOCATED);
        ric_periodic_free(found);
        if (same) return tests[i];
    }
    return RIC_N_TEST;
}

/* Of a corner: whether the flight between its two contacts is one of the orbit. One that only
 * touches, as where normals are orthogonal, is not in the word. */
static bool has_its_flight(const ric_periodic *cycle)
{
    double least = HUGE_VAL;
    for (int i = 0; i < cycle->N; i++) least = fmin(least, fabs(cycle->tau[i]));
    return least <= RIC_SAME_LOCATED * ric_periodic_period(cycle);
}

static ric_status criterion_of(const ric_junction *j, const ric_model *m, const ric_periodic *cycle,
                               ric_criterion *out)
{
    *out = (ric_criterion){.rotation = {j->rotation[0], j->rotation[1]}};
    switch (j->kind) {
    case RIC_KIND_GRAZING: out->test = RIC_TEST_TOUCH; return RIC_OK;
    case RIC_KIND_CORNER:
        out->test = RIC_TEST_FLIGHT;
        if (has_its_flight(cycle)) return RIC_OK;
        return ric_fail(
            RIC_E_INPUT,
            "corner %s: one of the two contacts is met without an impact, and no flight "
            "between them vanishes: there is no locus of it",
            j->label);
    case RIC_KIND_EXTREMUM: out->test = RIC_TEST_SLOPE; return RIC_OK;
    case RIC_KIND_PERIOD_EXTREMUM: out->test = RIC_TEST_PERIOD; return RIC_OK;
    case RIC_KIND_MULTIPLICATION: out->test = RIC_TEST_ROTATION; return RIC_OK;
    case RIC_KIND_BRANCH_POINT:
        out->test = kernel_of(m, cycle);
        if (out->test != RIC_N_TEST) return RIC_OK;
        return ric_fail(RIC_E_INPUT, "branch point %s: what its kernel breaks was not found",
                        j->label);
    default:
        return ric_fail(RIC_E_INPUT,
                        "junction %s is a place that was asked for, where nothing vanishes: there "
                        "is no locus of it; "
                        "name a grazing, a corner, an extremum, a branch point or a multiplication",
                        j->label);
    }
}

ric_status ric_locus_start(const ric_atlas *atlas, int junction, ric_locus_problem *q,
                           ric_periodic **cycle)
{
    const ric_model *m = ric_atlas_model(atlas);
    ric_junction j;
    ric_status status = ric_atlas_junction(atlas, junction, &j);
    *cycle = NULL;
    q->base = m;
    q->kind = j.kind;
    q->choice = q->place = -1;
    if (!status && j.kind == RIC_KIND_GRAZING && !j.letters)
        status = ric_fail(RIC_E_INPUT,
                          "grazing %s is that of a mixture of modes of one frequency, which no "
                          "parameter leaves as it "
                          "is; name that of a mode",
                          j.label);
    if (!status) status = orbit_of(atlas, &j, cycle);
    if (!status) status = criterion_of(&j, m, *cycle, &q->what);
    if (q->what.test != RIC_TEST_ROTATION) q->choice = 0;
    return status;
}
