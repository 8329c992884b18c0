/* Stored orbits as theorems: docs/proofs.md states them. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "atlas/room.h"
#include "base/room.h"
#include "certificate.h"
#include "existence.h"
#include "monodromy.h"
#include "passage.h"
#include "prover.h"
#include "prover_at_junction.h"
#include "prover_version.h"

/* Speed, in d and 2^-time s, that the rounding of what is stored makes of a touch: a slower impact
 * may be one of either sign, and the junction is what is to be proved. */
#define TOUCH 1e-12
#define TRACE 1e-3 /* relative to 1 + |trace| */

static const slong bits[PRECISIONS] = {128, 256, 512};

bool ric_prover_available(void)
{
    return true;
}

const char *ric_prover_version(void)
{
    return RIC_PROVER_VERSION;
}

const char *ric_prover_left_out_model(const ric_model *model)
{
    for (int i = 0; i < ric_model_n_contact(model); i++) {
        ric_contact contact;
        if (ric_model_contact(model, i, &contact)) return "the model cannot be read";
        if (contact.exponent > 0 || contact.length > 0) return "power law: no closed form";
    }
    if (ric_model_restitution(model) < 1) return "impacts with losses";
    return ric_model_n_part(model) > 1 ? "independent parts: families of two parameters" : NULL;
}

bool ric_prover_springs(const ric_model *model)
{
    for (int f = 0; f < model->n_face; f++)
        if (model->face[f].spring > 0) return true;
    return false;
}

ric_status ric_prover_create(const ric_atlas *atlas, ric_prover **out)
{
    ric_prover *p = *out = ric_calloc(1, sizeof *p);
    if (!p) return ric_no_memory("proofs");
    p->atlas = atlas;
    p->left_out = ric_prover_left_out_model(ric_atlas_model(atlas));
    p->model = ric_certificate_model(ric_atlas_model(atlas));
    p->certificate = ric_strdup("");
    if (p->model && p->certificate) return RIC_OK;
    ric_prover_free(p);
    *out = NULL;
    return ric_no_memory("proofs");
}

void ric_prover_free(ric_prover *p)
{
    if (!p) return;
    for (int i = 0; i < PRECISIONS; i++)
        if (p->at[i].made) {
            ric_linear_modes_free(&p->at[i].modes);
            ric_enclosure_free(&p->at[i].e);
        }
    free(p->model);
    free(p->certificate);
    free(p);
    flint_cleanup();
}

const char *ric_prover_certificate(const ric_prover *p)
{
    return p->certificate;
}

const char *ric_prover_model(const ric_prover *p)
{
    return p->model;
}

const ric_enclosure *ric_prover_enclosure(ric_prover *p, int level)
{
    if (!p->at[level].made)
        p->at[level].good = ric_enclosure_create(&p->at[level].e, ric_atlas_model(p->atlas),
                                                 bits[level]);
    p->at[level].made = true;
    return &p->at[level].e;
}

const char *ric_prover_left_out(const ric_prover *p, const ric_branch *branch)
{
    return p->left_out ? p->left_out : branch->letters == 0 ? "a linear mode" : NULL;
}

/* ------------------------------------------------------------------- a proof */

typedef struct {
    const ric_enclosure *e;
    ric_chain chain;
    ric_existence existence;
    ric_passage passage;
    ric_monodromy monodromy;
    arb_t energy, period;
    arb_ptr u;    /* the orbit: the centre with the radius of existence */
    bool crowded; /* it is there, but may not be alone as near: what more bits do not change */
} theorem;

static void theorem_open(theorem *t, const ric_enclosure *e)
{
    *t = (theorem){.e = e};
    ric_existence_init(&t->existence);
    ric_passage_init(&t->passage);
    ric_monodromy_init(&t->monodromy);
    arb_init(t->energy);
    arb_init(t->period);
}

static void theorem_close(theorem *t)
{
    if (t->u) _arb_vec_clear(t->u, (slong)t->chain.m * t->chain.size + 1);
    ric_chain_free(&t->chain);
    ric_existence_clear(&t->existence);
    ric_passage_clear(&t->passage);
    ric_monodromy_clear(&t->monodromy);
    arb_clear(t->energy);
    arb_clear(t->period);
}

/* Energy over d^2 and period in seconds, and the ball of states. */
static void measure(theorem *t)
{
    const ric_chain *c = &t->chain;
    slong count = (slong)c->m * c->size + 1, prec = t->e->prec;
    t->u = _arb_vec_init(count);
    for (slong i = 0; i < count; i++) {
        arb_set(t->u + i, c->u + i);
        arb_add_error(t->u + i, t->existence.exists);
    }
    ric_chain_energy(t->e, c->phase[0], t->u, t->energy);
    arb_mul_2exp_si(t->energy, t->energy, 2 * t->e->time - t->e->mass);
    for (int k = 0; k < c->m; k++)
        arb_add(t->period, t->period, t->u + (slong)k * c->size + 2 * c->n, prec);
    arb_mul_ui(t->period, t->period, (ulong)ric_chain_copies(c), prec);
    arb_mul_2exp_si(t->period, t->period, -t->e->time);
}

bool ric_prover_near(const double x[2], double stored)
{
    return fabs(x[0] - stored) <= RIC_PROVER_NEAR * fabs(stored) &&
           fabs(x[1] - stored) <= RIC_PROVER_NEAR * fabs(stored);
}

static bool is_another(const double x[2], double stored)
{
    const double near = RIC_PROVER_NEAR * fabs(stored);
    return x[1] < stored - near || x[0] > stored + near;
}

bool ric_prover_agrees(const ric_point *stored, ric_proof *out)
{
    const double turn = 8 * atan(1), frequency[2] = {turn / out->period[1], turn / out->period[0]};
    if (ric_prover_near(out->energy, stored->energy) &&
        ric_prover_near(frequency, stored->frequency))
        return true;
    const bool another = is_another(out->energy, stored->energy) ||
                         is_another(frequency, stored->frequency);
    snprintf(out->why, sizeof out->why,
             another ? "the stored energy or frequency is not that of the orbit"
                     : "the energy or frequency of the orbit is known to less than is stored");
    return false;
}

/* Of two modes: the stored trace is lost where less than three digits of it are known. */
static bool trace_agrees(const arb_t trace, double stored)
{
    double both[2];
    if (!arb_is_finite(trace) || !isfinite(stored)) return true;
    ric_arb_interval(trace, both);
    const double near = TRACE * (1 + fabs(stored));
    return both[1] > stored - near && both[0] < stored + near;
}

/* Whether the stored point says what is proved of its orbit; `why` where it does not. */
static bool agrees(const theorem *t, const ric_point *stored, ric_proof *out)
{
    static const char *const verdict[] = {"unstable", "stable", "undecided"};
    const ric_stability proved = t->monodromy.stable;
    const int flag = stored->stable;
    if (!ric_prover_agrees(stored, out)) return false;
    if (!trace_agrees(t->monodromy.trace, ric_point_trace(stored)))
        snprintf(out->why, sizeof out->why, "the stored trace is not that of the orbit");
    else if (proved != RIC_STABLE_UNDECIDED && flag != RIC_STABLE_UNDECIDED && flag != (int)proved)
        snprintf(out->why, sizeof out->why, "stored as %s, and proved to be %s",
                 flag == RIC_STABLE_YES ? verdict[1] : verdict[0], verdict[proved]);
    else return true;
    return false;
}

static void tell(const theorem *t, ric_proof *out)
{
    double both[2];
    out->bits = (int)t->e->prec;
    out->distance = t->existence.moved;
    ric_arb_interval(t->existence.exists, both);
    out->exists = both[1];
    ric_arb_interval(t->existence.unique, both);
    out->unique = both[0];
    ric_arb_interval(t->energy, out->energy);
    ric_arb_interval(t->period, out->period);
    ric_arb_interval(t->monodromy.trace, out->trace);
    ric_arb_interval(t->passage.approach, both);
    out->approach = ldexp(both[0], t->e->time);
    out->stable = t->monodromy.stable;
    out->symmetric = ric_chain_symmetric(&t->chain);
    out->reversible = !ric_chain_general(&t->chain);
}

/* Existence, distance, passage, multipliers: false with the reason in `out` where one of them is
 * missing. */
static bool prove(theorem *t, const ric_branch *branch, const double *state, const double *flights,
                  ric_proof *out)
{
    const char *why = ric_chain_create(&t->chain, t->e, branch, state, flights);
    if (!why) why = ric_existence_prove(&t->existence, &t->chain, t->e);
    t->crowded = !why && !t->existence.identified;
    if (t->crowded) why = "another orbit may lie as near: a junction";
    if (why) snprintf(out->why, sizeof out->why, "%s", why);
    if (why) return false;
    if (!(t->existence.moved <= RIC_PROVER_NEAR)) {
        snprintf(out->why, sizeof out->why, "the orbit that was proved lies %.1e away",
                 t->existence.moved);
        return false;
    }
    measure(t);
    const bool closes = arb_is_positive(t->energy) && ric_chain_closes(&t->chain, t->e, t->u);
    if (!closes) snprintf(out->why, sizeof out->why, "the energy is not proved to close the chain");
    else if (!ric_passage_prove(&t->passage, &t->chain, t->e, &(ric_family){.hull = t->u}))
        snprintf(out->why, sizeof out->why, "%s", t->passage.why);
    if (!closes || !t->passage.done) return false;
    if (arf_get_d(arb_midref(t->passage.approach), ARF_RND_FLOOR) < TOUCH) {
        snprintf(out->why, sizeof out->why, "an impact is no faster than rounding: a touch");
        return false;
    }
    ric_monodromy_enclose(&t->monodromy, &t->chain, t->e, t->u);
    return true;
}

/* A point of a linear mode, which has no certificate. */
static void prove_mode(ric_prover *p, int level, const ric_point *stored, const double *state,
                       ric_proof *out)
{
    ric_linear_modes *modes = &p->at[level].modes;
    if (!p->at[level].modes_made) ric_linear_modes_create(modes, &p->at[level].e);
    p->at[level].modes_made = true;
    if (!ric_linear_mode_prove(modes, stored->frequency, state, out) ||
        !ric_prover_agrees(stored, out))
        return;
    out->state = RIC_PROOF_DONE;
    *out->why = 0;
}

/* One precision; `more`: whether a larger one may say more. */
static ric_status attempt(ric_prover *p, int level, int id, int i, ric_proof *out, bool *more)
{
    ric_branch branch;
    ric_point stored;
    const ric_model *m = ric_atlas_model(p->atlas);
    ric_status status = ric_atlas_branch(p->atlas, id, &branch);
    if (status) return status;
    double *state = ric_calloc((size_t)(2 * ric_model_n_dof(m) + branch.letters + 1),
                               sizeof *state);
    if (!state) return ric_no_memory("a proof");
    double *flights = state + 2 * ric_model_n_dof(m);
    status = ric_atlas_point(p->atlas, id, i, &stored, state, flights);
    theorem t;
    const ric_enclosure *e = ric_prover_enclosure(p, level);
    theorem_open(&t, e);
    *more = true;
    p->contradicted = false;
    out->bits = (int)bits[level];
    if (!p->at[level].good) snprintf(out->why, sizeof out->why, "%s", e->why);
    else if (!status && branch.letters == 0) prove_mode(p, level, &stored, state, out);
    else if (!status && prove(&t, &branch, state, flights, out)) {
        tell(&t, out);
        const bool agree = agrees(&t, &stored, out);
        const ric_measured z = {t.u, t.energy, t.period, t.monodromy.trace};
        p->contradicted = !agree;
        out->state = agree ? RIC_PROOF_DONE : RIC_PROOF_NONE;
        free(p->certificate);
        p->certificate = agree ? ric_certificate_point(&t.chain, e, &z, out) : ric_strdup("");
        if (!p->certificate) status = ric_no_memory("a certificate");
        *more = !agree || !p->certificate || !*p->certificate ||
                (e->n > 1 && out->stable == RIC_STABLE_UNDECIDED);
    } else *more = !t.crowded;
    theorem_close(&t);
    free(state);
    return status;
}

ric_status ric_prover_point(ric_prover *p, int branch, int i, ric_proof *out)
{
    ric_branch row;
    ric_status status = ric_atlas_branch(p->atlas, branch, &row);
    *out = (ric_proof){.branch = branch,
                       .point = i,
                       .state = RIC_PROOF_NONE,
                       .stable = RIC_STABLE_UNDECIDED,
                       .prover = RIC_PROVER_VERSION};
    if (status) return status;
    if (p->left_out) {
        out->state = RIC_PROOF_LEFT_OUT;
        snprintf(out->why, sizeof out->why, "%s", p->left_out);
        return RIC_OK;
    }
    bool more = true;
    *p->certificate = 0;
    for (int level = 0; level < PRECISIONS && more && !status && !ric_halted(); level++) {
        ric_proof next = *out;
        status = attempt(p, level, branch, i, &next, &more);
        /* A verdict that stays open with more bits does not take back what fewer have proved. */
        if (!status && (next.state == RIC_PROOF_DONE || out->state != RIC_PROOF_DONE)) *out = next;
        if (out->state == RIC_PROOF_LEFT_OUT) break;
        if (!status && level == 0 && out->state != RIC_PROOF_DONE && !p->contradicted)
            status = ric_prover_at_junction(p, &row, i, out);
        more = more &&
               (out->state != RIC_PROOF_DONE || !*out->why); /* a junction is not proved again */
    }
    return status;
}
