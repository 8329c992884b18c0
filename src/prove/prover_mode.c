/* Points that are no orbits of a word in general position: those of linear modes, in closed form,
 * and those that are junctions themselves. docs/proofs.md states the theorems. */
#include "prover_mode.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "atlas/room.h"
#include "base/room.h"
#include "prover_junction.h"

/* Of a clearance: a mode that comes as near to a stop touches it, and the junction is what is to be
 * proved. */
#define TOUCH 1e-12

/* Energy and frequency of what was proved, and those that are stored. */
static bool agrees(const ric_point *stored, ric_proof *out)
{
    const double turn = 8 * atan(1), frequency[2] = {turn / out->period[1], turn / out->period[0]};
    const bool near = ric_prover_near(out->energy, stored->energy) &&
                      ric_prover_near(frequency, stored->frequency);
    if (!near)
        snprintf(out->why, sizeof out->why,
                 "the stored energy or frequency is not that of the orbit");
    return near;
}

/* ------------------------------------------------------------- linear modes */

/* Mode k of L + R: the largest part of a motion, its size A, and how far the vector of the mode, of
 * length one, is from that of L. Where L_k is away from all others by delta the angle between them
 * has a sine of at most rho / (delta - rho) (Davis and Kahan, SIAM J. Numer. Anal. 7 (1970) 1-46),
 * and what it differs by is sqrt(2) times that at most. */
typedef struct {
    const ric_enclosure *e;
    slong k;
    arb_t square, size, off;  /* omega^2, A, and the bound of A times the difference */
    double distance, largest; /* from the mode; the largest part */
} mode;

static void mode_open(mode *m, const ric_enclosure *e)
{
    *m = (mode){.e = e};
    arb_init(m->square);
    arb_init(m->size);
    arb_init(m->off);
}

static void mode_close(mode *m)
{
    arb_clear(m->square);
    arb_clear(m->size);
    arb_clear(m->off);
}

/* (q, p) [2n] of a state x, v; A of mode k. At rest it is the mode of the frequency, 2^-time s. */
static void measure_mode(mode *m, const double *state, double frequency)
{
    const ric_enclosure *e = m->e;
    const slong n = e->n;
    double largest = -1, least = HUGE_VAL, others = 0;
    arb_ptr w = _arb_vec_init(2 * n);
    arb_t x;
    arb_init(x);
    for (slong i = 0; i < 2 * n; i++) {
        const slong part = i / n;
        for (slong j = 0; j < e->n_dof; j++) {
            arb_set_d(x, state[part * e->n_dof + j]);
            if (part) arb_mul_2exp_si(x, x, -e->time);
            arb_addmul(w + i, arb_mat_entry(e->back, i % n, j), x, e->prec);
        }
    }
    for (slong i = 0; i < n; i++) {
        const double size = hypot(ric_arb_middle(w + i) * ric_arb_middle(e->omega + i),
                                  ric_arb_middle(w + n + i));
        const double off = fabs(ric_arb_middle(e->omega + i) - frequency);
        if (size > largest || (size == largest && off < least)) {
            m->k = i;
            least = off;
        }
        largest = fmax(largest, size);
    }
    m->largest = largest;
    for (slong i = 0; i < n; i++)
        if (i != m->k)
            others = hypot(others, hypot(ric_arb_middle(w + i), ric_arb_middle(w + n + i)));
    m->distance = others / (1 + hypot(ric_arb_middle(w + m->k), ric_arb_middle(w + n + m->k)));
    arb_mul(m->size, w + n + m->k, w + n + m->k, e->prec);
    arb_div(m->size, m->size, e->square + m->k, e->prec);
    arb_addmul(m->size, w + m->k, w + m->k, e->prec);
    arb_get_mid_arb(m->size, m->size);
    arb_sqrtpos(m->size, m->size, e->prec);
    arb_clear(x);
    _arb_vec_clear(w, 2 * n);
}

/* Whether mode k has a frequency of its own, above zero. */
static bool is_simple(mode *m)
{
    const ric_enclosure *e = m->e;
    arb_t delta, x;
    arb_init(delta);
    arb_init(x);
    arb_pos_inf(delta);
    for (slong i = 0; i < e->n; i++) {
        arb_sub(x, e->square + i, e->square + m->k, e->prec);
        arb_abs(x, x);
        if (i != m->k) arb_min(delta, delta, x, e->prec);
    }
    arb_sub(delta, delta, e->rho, e->prec);
    arb_set(m->square, e->square + m->k);
    arb_add_error(m->square, e->rho);
    const bool simple = arb_is_positive(delta) && arb_is_positive(m->square);
    arb_div(m->off, e->rho, delta, e->prec);
    if (!arf_is_finite(arb_midref(delta))) arb_zero(m->off);
    arb_mul_ui(m->off, m->off, 2, e->prec);
    arb_mul(m->off, m->off, m->size, e->prec);
    arb_clear(delta);
    arb_clear(x);
    return simple;
}

/* The motion reaches A |c_k| to both sides of each stop; what rounding makes of a touch is none. */
static bool stays_open(const mode *m)
{
    const ric_enclosure *e = m->e;
    bool open = true;
    arb_t reach, x;
    arb_init(reach);
    arb_init(x);
    for (int f = 0; f < e->n_face && open; f++) {
        arb_srcptr c = ric_enclosure_c(e, e->wall[f].contact);
        arb_abs(reach, c + m->k);
        arb_mul(reach, reach, m->size, e->prec);
        ric_chain_norm(e->n, c, e->prec, x);
        arb_addmul(reach, x, m->off, e->prec);
        arb_set_d(x, TOUCH);
        arb_addmul(reach, reach, x, e->prec);
        arb_abs(x, e->wall[f].gap);
        open = arb_lt(reach, x);
    }
    arb_clear(reach);
    arb_clear(x);
    return open;
}

/* The others turn by omega_i T in a period: on the unit circle where no frequency is zero. */
static void tell_multipliers(const mode *m, const arb_t period, ric_proof *out)
{
    const ric_enclosure *e = m->e;
    arb_t x;
    arb_init(x);
    out->stable = RIC_STABLE_YES;
    for (slong i = 0; i < e->n; i++) {
        arb_set(x, e->square + i);
        arb_add_error(x, e->rho);
        if (!arb_is_positive(x)) out->stable = RIC_STABLE_UNDECIDED;
        if (e->n != 2 || i == m->k) continue;
        arb_sqrtpos(x, x, e->prec);
        arb_mul(x, x, period, e->prec);
        arb_cos(x, x, e->prec);
        arb_mul_2exp_si(x, x, 1);
        ric_arb_interval(x, out->trace);
    }
    arb_clear(x);
}

static void tell_mode(const mode *m, ric_proof *out)
{
    const ric_enclosure *e = m->e;
    arb_t period, energy;
    double both[2];
    arb_init(period);
    arb_init(energy);
    arb_mul(energy, m->size, m->size, e->prec);
    arb_mul(energy, energy, m->square, e->prec);
    arb_mul_2exp_si(energy, energy, 2 * e->time - e->mass - 1);
    ric_arb_interval(energy, out->energy);
    arb_const_pi(period, e->prec);
    arb_mul_2exp_si(period, period, 1);
    arb_sqrtpos(energy, m->square, e->prec);
    arb_div(period, period, energy, e->prec);
    tell_multipliers(m, period, out);
    arb_mul_2exp_si(period, period, -e->time);
    ric_arb_interval(period, out->period);
    ric_arb_interval(m->off, both);
    out->exists = both[1];
    out->unique = out->approach = NAN;
    out->distance = m->distance;
    out->bits = (int)e->prec;
    out->symmetric = out->reversible = true;
    arb_clear(period);
    arb_clear(energy);
}

/* The motion has next to none of its energy in the modes that contacts see: another mode of a
 * frequency that one of them has. */
static bool is_unseen(const mode *m, const ric_point *stored)
{
    const slong to_scaled = 2 * m->e->time - m->e->mass - 1;
    return ldexp(m->largest * m->largest, (int)to_scaled) < RIC_PROVER_NEAR * stored->energy;
}

static bool has_frequency(const ric_enclosure *e, double frequency)
{
    for (slong i = 0; i < e->n; i++)
        if (fabs(ric_arb_middle(e->omega + i) - frequency) <= RIC_PROVER_NEAR * frequency)
            return true;
    return false;
}

void ric_prover_mode(const ric_enclosure *e, const ric_point *stored, const double *state,
                     ric_proof *out)
{
    mode m;
    const double frequency = ldexp(stored->frequency, -e->time);
    mode_open(&m, e);
    measure_mode(&m, state, frequency);
    if (!has_frequency(e, frequency) || is_unseen(&m, stored)) {
        out->state = RIC_PROOF_LEFT_OUT;
        snprintf(out->why, sizeof out->why, "a linear mode that no contact sees");
    } else if (!is_simple(&m))
        snprintf(out->why, sizeof out->why,
                 "a linear mode of a frequency that others have, or of none");
    else if (!(m.distance <= RIC_PROVER_NEAR))
        snprintf(out->why, sizeof out->why, "the stored orbit is no linear mode, by %.1e",
                 m.distance);
    else if (!stays_open(&m))
        snprintf(out->why, sizeof out->why, "a stop is not proved to stay open");
    else {
        tell_mode(&m, out);
        if (agrees(stored, out)) {
            out->state = RIC_PROOF_DONE;
            *out->why = 0;
        }
    }
    mode_close(&m);
}

/* ------------------------------------------------------------- at junctions */

/* The junction that a point is, or 0. */
static int junction_of(const ric_branch *b, int i, double arclength)
{
    const double near = 1e-9;
    if (i == 0) return b->from;
    if (i == b->n_point - 1) return b->to;
    for (int k = 0; k < b->n_junction; k++)
        if (fabs(b->junction_at[k] - arclength) <= near * (1 + arclength)) return b->junctions[k];
    return 0;
}

static void tell_chain(const ric_chain *c, const ric_enclosure *e, arb_srcptr u, ric_proof *out)
{
    arb_t x;
    arb_init(x);
    ric_chain_energy(e, c->phase[0], u, x);
    arb_mul_2exp_si(x, x, 2 * e->time - e->mass);
    ric_arb_interval(x, out->energy);
    arb_zero(x);
    for (int k = 0; k < c->m; k++) arb_add(x, x, u + (slong)k * c->size + 2 * e->n, e->prec);
    arb_mul_ui(x, x, (ulong)ric_chain_copies(c), e->prec);
    arb_mul_2exp_si(x, x, -e->time);
    ric_arb_interval(x, out->period);
    out->symmetric = ric_chain_symmetric(c);
    out->reversible = !ric_chain_general(c);
    arb_clear(x);
}

/* The largest difference from the centre of a chain, over 1 + its size. */
static double differs(const ric_chain *c, arb_srcptr u)
{
    double worst = 0, size = 0;
    for (slong i = 0; i < (slong)c->m * c->size; i++) {
        worst = fmax(worst, fabs(ric_arb_middle(c->u + i) - ric_arb_middle(u + i)));
        size = fmax(size, fabs(ric_arb_middle(c->u + i)));
    }
    return worst / (1 + size);
}

/* The orbit of the junction told with the word and in the class of the branch. */
static ric_status compare(ric_walk *w, int i, ric_story *story, ric_proof *out)
{
    bool made;
    ric_chain c = {0};
    ric_status status = ric_walk_class(w);
    if (!status) status = ric_walk_chain(w, i, &c, &made);
    if (!status && made) {
        arb_ptr u = _arb_vec_init((slong)c.m * c.size + 1);
        const bool cut = ric_story_cut(story, &c, RIC_PROVER_NEAR, u);
        if (cut) out->distance = differs(&c, u);
        if (cut) tell_chain(&c, w->e, u, out);
        _arb_vec_clear(u, (slong)c.m * c.size + 1);
    }
    ric_chain_free(&c);
    return status;
}

static ric_status compare_at(ric_walk *w, int i, const ric_junction *row, const ric_augmented *x,
                             const ric_junction_proof *proof, ric_proof *out)
{
    ric_point stored;
    ric_story story;
    ric_status status = ric_walk_point(w, i, &stored);
    if (status) return status;
    ric_prover_junction_tell(x, &story);
    *out = (ric_proof){.branch = out->branch,
                       .point = i,
                       .state = RIC_PROOF_NONE,
                       .stable = RIC_STABLE_UNDECIDED};
    out->distance = HUGE_VAL;
    out->approach = out->trace[0] = out->trace[1] = NAN;
    out->bits = proof->bits;
    out->exists = proof->exists;
    out->unique = proof->unique;
    if (w->branch.letters > 0) status = compare(w, i, &story, out);
    else {
        out->distance = ric_story_distance(&story, 0, 0, NULL, w->state,
                                           w->state + 2 * w->e->n_dof);
        out->symmetric = out->reversible = true;
        for (int k = 0; k < 2; k++) out->energy[k] = proof->energy[k];
        for (int k = 0; k < 2; k++) out->period[k] = proof->period[k];
    }
    ric_story_free(&story);
    if (status) return status;
    if (!(out->distance <= RIC_PROVER_NEAR))
        snprintf(out->why, sizeof out->why, "the stored orbit is not that of the junction %s",
                 row->label);
    else if (agrees(&stored, out)) {
        out->state = RIC_PROOF_DONE;
        snprintf(out->why, sizeof out->why, "the junction %s itself", row->label);
    }
    return RIC_OK;
}

/* What is proved of the junction, by any branch or in the class of this one, against point i. */
static ric_status look_at(ric_prover *p, ric_walk *w, int i, const ric_junction *row, bool own,
                          ric_proof *out)
{
    ric_augmented x = {0};
    ric_junction_proof proof = {.state = RIC_PROOF_NONE};
    ric_status status = own ? ric_walk_class(w) : RIC_OK;
    w->slow = own ? RIC_PROVER_SLOW : 0;
    if (!own) status = ric_prover_junction_find(p, row, 0, &x, &proof);
    else if (!status && w->like.u) status = ric_prover_junction_end(w, row, i > 0, &x, &proof);
    if (!status && proof.state == RIC_PROOF_DONE) {
        ric_proof found = *out;
        status = compare_at(w, i, row, &x, &proof, &found);
        if (!status && found.state == RIC_PROOF_DONE) *out = found;
    }
    ric_augmented_free(&x);
    return status;
}

/* A corner has two orders; a grazing may lack mirrors in the class of another branch that this one
 * has. */
ric_status ric_prover_at_junction(ric_prover *p, const ric_branch *branch, int i, ric_proof *out)
{
    ric_walk w;
    ric_point stored;
    ric_junction row;
    ric_status status = ric_atlas_point(p->atlas, branch->id, i, &stored, NULL, NULL);
    const int junction = status ? 0 : junction_of(branch, i, stored.arclength);
    if (!junction || !p->at[0].good) return status;
    status = ric_walk_open(&w, p, branch->id, 0);
    if (!status) status = ric_atlas_junction(p->atlas, junction, &row);
    const bool corner = !status && row.kind == RIC_KIND_CORNER,
               grazes = !status && row.kind == RIC_KIND_GRAZING && branch->letters > 0;
    if (!status && !corner) status = look_at(p, &w, i, &row, false, out);
    if (!status && (corner || grazes) && out->state != RIC_PROOF_DONE)
        status = look_at(p, &w, i, &row, true, out);
    ric_walk_close(&w);
    return status;
}
