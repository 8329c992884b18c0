#include "node.h"

#include <stdlib.h>
#include <string.h>

#include "corner.h"
#include "meeting.h"
#include "node_solve.h"
#include "model/room.h"
#include "branch/room.h"
#include "grazing_words.h"
#include "base/room.h"

#define NO_TIME 1e-7 /* scaled: a flight that is as short is none: a corner */
/* ALONE: a multiplier nearer to one root of unity than this part of its distance to the next one
 * means that one */
#define ALONE 0.25

void ric_node_free(ric_node *node)
{
    if (!node) return;
    ric_periodic_free(node->cycle);
    for (int i = 0; i < node->n_departure; i++) free(node->departures[i].why);
    free(node->departures);
    free(node);
}

ric_node *ric_node_copy(const ric_node *node)
{
    ric_node *copy = ric_malloc(sizeof *copy);
    if (!copy) return NULL;
    *copy = *node;
    copy->cycle = ric_periodic_copy(node->cycle);
    copy->departures = ric_malloc((size_t)(node->n_departure + 1) * sizeof *copy->departures);
    copy->n_departure = copy->departures ? node->n_departure : 0;
    for (int i = 0; i < copy->n_departure; i++)
        copy->departures[i] = (ric_departure){.choice = node->departures[i].choice,
                                              .state = node->departures[i].state};
    if (copy->cycle && copy->departures) return copy;
    ric_node_free(copy);
    return NULL;
}

const char *ric_budget_text(ric_budget budget)
{
    static const char *const texts[RIC_N_BUDGET] = {"frequency", "multiply", "impacts",
                                                    "symmetric", "touches",  "depth"};
    return budget >= 0 && budget < RIC_N_BUDGET ? texts[budget] : "";
}

const char *ric_node_refusal_text(ric_refusal refusal)
{
    switch (refusal) {
    case RIC_REFUSAL_TOUCHES: return "more touches at once than are enumerated";
    case RIC_REFUSAL_TOGETHER:
        return "two contacts with orthogonal normals close at one instant, and on the branches "
               "that go on they do so "
               "for good; such branches are not followed by this version";
    case RIC_REFUSAL_OBLIQUE:
        return "two contacts close at one instant and their normals are not orthogonal in the "
               "metric of M^-1: the "
               "impact law does not say what happens; the branch ends here";
    case RIC_REFUSAL_NONE: break;
    }
    return "";
}

ric_node *ric_node_create(const ric_model *m, ric_kind kind, ric_periodic *cycle)
{
    ric_node *node = cycle ? ric_calloc(1, sizeof *node) : NULL;
    if (!node) {
        ric_periodic_free(cycle);
        return NULL;
    }
    node->kind = kind;
    node->cycle = cycle;
    node->mirrors = m->symmetric;
    node->test = -1;
    node->multiple = 1;
    node->mode = node->mixture = -1;
    node->springs = ric_periodic_springs(m);
    node->energy = ric_periodic_energy(m, cycle);
    node->period = ric_periodic_period(cycle);
    return node;
}

/* A junction at an orbit that was solved for, which it takes over. */
static ric_status create_solved(const ric_model *m, ric_kind kind, ric_periodic *solved,
                                ric_node **out)
{
    *out = NULL;
    if (!ric_node_solve_admissible(m, solved)) {
        ric_status status =
            ric_fail(RIC_E_NUMERIC,
                     "a junction on a branch of %d impacts has a flight of less than no time, or "
                     "passes a stop",
                     solved->N);
        ric_periodic_free(solved);
        return status;
    }
    *out = ric_node_create(m, kind, solved);
    return *out ? RIC_OK : ric_no_memory("a junction");
}

/* ------------------------------------------------------------------ corners */

bool ric_node_coincident(const ric_model *m, const ric_periodic *cycle)
{
    if (m->n_contact < 2) return false;
    bool found = false, *kept = NULL;
    ric_periodic *full = ric_grazing_words_touches(m, cycle, &kept);
    for (int i = 0; full && kept && i < full->N; i++) {
        const int next = (i + 1) % full->N;
        found |= full->tau[i] < RIC_COINCIDENT && (kept[i] || kept[next]) &&
                 m->face[full->face[i]].contact != m->face[full->face[next]].contact;
    }
    free(kept);
    ric_periodic_free(full);
    return found;
}

/* With orthogonal normals the reflections commute: each pair of impacts at one instant may go on in
 * either order, and every choice of orders is a way out. */
static ric_status finish_corner(const ric_model *m, const ric_periodic *cycle, int n_pair,
                                const int *pairs, ric_node **out)
{
    ric_periodic *least = ric_corner_least(m, cycle, n_pair, pairs, RIC_SAME_LOCATED), *solved;
    if (!least) return ric_no_memory("a junction");
    solved = ric_node_solve(m, least, (ric_criterion){.test = RIC_TEST_FLIGHT}, NULL);
    ric_periodic_free(least);
    if (!solved)
        return ric_fail(RIC_E_NUMERIC, "a corner orbit of %d impacts does not converge", cycle->N);
    ric_node *node;
    ric_status status = create_solved(m, RIC_KIND_CORNER, solved, &node);
    if (status) return status;
    node->n_touch = ric_corner_pairs(m, solved, NO_TIME, RIC_MAX_TOUCHES, node->touch);
    if (node->n_touch != n_pair) {
        ric_node_free(node);
        return ric_fail(RIC_E_NUMERIC, "a corner orbit of %d impacts does not converge", cycle->N);
    }
    *out = node;
    return RIC_OK;
}

/* The corner at an orbit, canonical and taken over, that no branch leaves. */
static ric_status refuse(const ric_model *m, ric_periodic *cycle, ric_refusal why, ric_node **out)
{
    *out = ric_node_create(m, RIC_KIND_CORNER, cycle);
    if (!*out) return ric_no_memory("a junction");
    (*out)->refusal = why;
    return RIC_OK;
}

/* The branch ends where it comes to motions that close pairs together for good, whose curve it
 * `crosses`; if that is not known, another order of them seems to be the same motion, and what has
 * two orders after all is passed. */
static ric_status meet(const ric_model *m, const ric_periodic *cycle, bool crosses, ric_node **out)
{
    int pairs[RIC_MAX_TOUCHES];
    ric_periodic *met = ric_meeting_solve(m, cycle);
    const int n_pair = met && ric_node_solve_admissible(m, met)
                           ? ric_corner_pairs(m, met, NO_TIME, RIC_MAX_TOUCHES, pairs)
                           : 0;
    ric_status status = RIC_E_NUMERIC;
    if (n_pair > 0 && (crosses || ric_corner_fixed(m, met, n_pair, pairs, RIC_SAME_LOCATED))) {
        if ((status = refuse(m, met, RIC_REFUSAL_TOGETHER, out))) return status;
        (*out)->n_touch = n_pair;
        memcpy((*out)->touch, pairs, sizeof pairs);
        return RIC_OK;
    }
    if (n_pair > 0) status = finish_corner(m, met, n_pair, pairs, out);
    else
        ric_fail(status, "where two contacts meet, an orbit of %d impacts does not converge",
                 cycle->N);
    ric_periodic_free(met);
    return status;
}

/* Where the structure is its own image with both contacts exchanged, the other order is that image
 * of the branch, and motions that close both together for good are as good solutions of the corner:
 * which of them it comes to is rounding. */
static ric_status passed_corner(const ric_model *m, const ric_periodic *cycle, int n_pair,
                                const int *pairs, ric_node **out)
{
    const ric_status status = finish_corner(m, cycle, n_pair, pairs, out);
    if (status || !ric_meeting_stays(m, (*out)->cycle)) return status;
    ric_node_free(*out);
    *out = NULL;
    return meet(m, cycle, true, out);
}

/* The orbit at the end of a branch where a gap touches at the instant of an impact: where branches
 * cross there, the crossing, of which the end is off by the root of rounding. NULL: no orbit. */
static ric_periodic *touching_end(const ric_model *m, const ric_periodic *cycle)
{
    ric_periodic *crossing = ric_node_solve(m, cycle, (ric_criterion){.test = RIC_TEST_DET}, NULL);
    if (crossing && ric_periodic_same(m, cycle, crossing, RIC_SAME_LOCATED) &&
        ric_node_solve_touches(m, crossing))
        return crossing;
    ric_periodic_free(crossing);
    return ric_node_solve_admissible(m, cycle) && ric_node_solve_solved(m, cycle)
               ? ric_periodic_canonical(m, cycle)
               : NULL;
}

ric_status ric_node_corner(const ric_model *m, const ric_periodic *cycle, ric_node **out)
{
    int pairs[RIC_MAX_TOUCHES], n_pair = RIC_CORNER_UNDEFINED;
    bool fixed = false;
    ric_periodic *full = ric_grazing_words_touches(m, cycle, NULL);
    *out = NULL;
    if (!full) return ric_grazing_words_lost(cycle);
    n_pair = ric_corner_pairs(m, full, NO_TIME, RIC_MAX_TOUCHES, pairs);
    if (n_pair > 0 && full->N > cycle->N) n_pair = RIC_CORNER_TOGETHER;
    else fixed = n_pair > 0 && ric_corner_fixed(m, full, n_pair, pairs, RIC_SAME_EXTRAPOLATED);
    ric_periodic_free(full);
    if (fixed) return meet(m, cycle, false, out);
    if (n_pair > 0) return passed_corner(m, cycle, n_pair, pairs, out);
    ric_status status = ric_node_mode_together(m, cycle, out);
    if (status || *out) return status;
    ric_periodic *end = touching_end(m, cycle);
    if (!end && !ric_memory_failed())
        return ric_fail(RIC_E_NUMERIC, "where two contacts meet, an orbit of %d impacts is none",
                        cycle->N);
    return refuse(m, end,
                  n_pair == RIC_CORNER_TOGETHER ? RIC_REFUSAL_TOGETHER : RIC_REFUSAL_OBLIQUE, out);
}

/* ------------------------------------------------------------- branch points */

/* The branch that passes, and up to two that leave. */
static bool add_departures(ric_node *node, int count)
{
    node->departures = ric_calloc((size_t)count, sizeof *node->departures);
    if (!node->departures) return false;
    for (int i = 0; i < count; i++) node->departures[i].choice = RIC_THROUGH + (unsigned)i;
    node->n_departure = count;
    return true;
}

ric_status ric_node_interior(const ric_model *m, const ric_periodic *cycle, int test,
                             ric_node **out)
{
    ric_kind kind = test == RIC_TEST_SLOPE    ? RIC_KIND_EXTREMUM
                    : test == RIC_TEST_PERIOD ? RIC_KIND_PERIOD_EXTREMUM
                                              : RIC_KIND_BRANCH_POINT;
    *out = NULL;
    bool moved = false;
    ric_periodic *solved = ric_node_solve(m, cycle, (ric_criterion){.test = test}, &moved);
    /* on a branch of one energy, or of one period, an extremum that goes elsewhere, or is nowhere
     * sharp, is rounding */
    if (!solved && kind != RIC_KIND_BRANCH_POINT &&
        (moved || !ric_node_solve_sharp(m, cycle, test)))
        return RIC_OK;
    if (!solved)
        return ric_fail(RIC_E_NUMERIC, "a junction on a branch of %d impacts does not converge",
                        cycle->N);
    if (kind != RIC_KIND_BRANCH_POINT && !ric_node_solve_sharp(m, solved, test)) {
        ric_periodic_free(solved);
        return RIC_OK;
    }
    /* where an orbit of several periods crosses that of one, all its functions vanish: seen from
     * beside, one of them may be taken for a branch point of its own */
    if (kind == RIC_KIND_BRANCH_POINT && ric_periodic_repeats(m, solved, RIC_SAME_LOCATED)) {
        ric_status status = ric_node_arrival(m, solved, out);
        ric_periodic_free(solved);
        return status;
    }
    ric_node *node;
    ric_status status = create_solved(m, kind, solved, &node);
    if (status) return status;
    node->test = test;
    if (kind == RIC_KIND_BRANCH_POINT && !add_departures(node, 2)) {
        ric_node_free(node);
        return ric_no_memory("a junction");
    }
    *out = node;
    return RIC_OK;
}

ric_status ric_node_user(const ric_model *m, const ric_periodic *cycle, const ric_user_point *asked,
                         ric_node **out)
{
    *out = NULL;
    ric_periodic *solved = ric_node_solve(m, cycle,
                                          (ric_criterion){.test = RIC_TEST_ASKED, .asked = asked},
                                          NULL);
    if (!solved)
        return ric_fail(RIC_E_NUMERIC,
                        "an orbit of %d impacts with what was asked for does not converge",
                        cycle->N);
    ric_status status = create_solved(m, RIC_KIND_USER, solved, out);
    if (!status) (*out)->asked = *asked;
    return status;
}

ric_status ric_node_start(const ric_model *m, const ric_periodic *cycle, ric_node **out)
{
    ric_node *node = ric_node_create(m, RIC_KIND_START, ric_periodic_canonical(m, cycle));
    *out = NULL;
    if (!node || !add_departures(node, 1)) {
        ric_node_free(node);
        return ric_no_memory("a junction");
    }
    *out = node;
    return RIC_OK;
}

/* p of a q-tupling from the multipliers of the original orbit; 0 if none fits. Where a branch
 * arrives on a sharp turn rho is off, by 0.2 within 1e-5 of the orbit: the nearest p counts if no
 * other is near, and ric_node_solve tells whether it is met. rho alone does not tell p from q - p
 * unless it is that of half a period: then the smaller one. */
static int rotation_of(const ric_model *m, const ric_periodic *cycle, int q)
{
    ric_shooting *chain = NULL;
    ric_floquet floquet = {0};
    double *u = NULL, best = HUGE_VAL, other = HUGE_VAL;
    int p = 0, nearest = 0;
    if (!ric_periodic_to_chain(m, cycle, &chain, &u) && !ric_floquet_create(m->n, &floquet)) {
        bool half = ric_shooting_halves(chain);
        ric_shooting_evaluate(chain, u);
        if (!ric_floquet_compute(chain, &floquet)) {
            /* over half a period p and p + q would be taken for one; and the orbit run backwards,
             * which is the same one, has q - p */
            if (isfinite(floquet.rotation) && !half)
                p = (int)lrint(q * fmin(floquet.rotation, 1 - floquet.rotation));
            for (int k = 1; p == 0 && k <= (half ? q - 1 : q / 2); k++) {
                double off = HUGE_VAL;
                for (int i = 0; i < floquet.n_pair; i++)
                    off = fmin(off, hypot(floquet.own[2 * i] - ric_symmetry_rho(half, k, q),
                                          floquet.own[2 * i + 1]));
                other = fmin(other, fmax(off, best));
                if (off < best) {
                    best = off;
                    nearest = k;
                }
            }
            if (p == 0 && best < ALONE * other) p = nearest;
        }
    }
    ric_shooting_free(chain);
    ric_floquet_release(&floquet);
    free(u);
    return p;
}

/* On an S orbit with mirror points, at a multiplication of order 2 q, the families that keep points
 * of rest or impact are images of each other in half a period and x -> -x; a whole number of
 * periods, which is all that a structure without this symmetry has, takes each to itself. For even
 * q they are two curves, for odd q the halves of one. */
static bool has_image(const ric_node *node)
{
    const ric_periodic *c = node->cycle;
    return !node->mirrors && c->half && c->pure >= 0 && node->rotation[0] % 2;
}

ric_status ric_node_multiplication(const ric_model *m, const ric_periodic *cycle, int p, int q,
                                   ric_node **out)
{
    ric_criterion what = {.test = RIC_TEST_ROTATION, .rotation = {p, q}};
    ric_symmetry problems[2];
    int count = ric_symmetry_multiplying(cycle, p, q, problems),
        order = ric_symmetry_order(cycle, p, q);
    *out = NULL;
    ric_periodic *solved = ric_node_solve(m, cycle, what, NULL);
    if (!solved)
        return ric_fail(RIC_E_NUMERIC,
                        "the original orbit of a multiplication by %d does not converge", q);
    ric_node *node;
    ric_status status = create_solved(m, RIC_KIND_MULTIPLICATION, solved, &node);
    if (status) return status;
    if (!add_departures(node, 4)) {
        ric_node_free(node);
        return ric_no_memory("a junction");
    }
    int measured = rotation_of(m, solved, q); /* p or q - p: rho does not tell */
    if (measured == q - p) p = measured;
    node->multiple = q;
    node->rotation[0] = p;
    node->rotation[1] = q;
    if (order == 2) { /* the canonical orbit may start elsewhere: mirror points are counted anew */
        bool both = false;
        int which = 0;
        ric_symmetry_multiplying(solved, p, q, problems);
        if (count == 2) which = ric_symmetry_singular(m, solved, problems, &both);
        if (!both) node->departures[1].choice = RIC_SIDE + (unsigned)which;
        node->n_departure = both ? 4 : 2;
    } else
        node->n_departure = ric_symmetry_passes(solved, p, q) ? 2
                            : has_image(node) && q % 2 == 0   ? 4
                                                              : 3;
    *out = node;
    return RIC_OK;
}

/* Which test vanishes on the symmetric orbit `whole` where a branch with the symmetries of `part`
 * arrives: what is lost tells. */
static int broken_test(const ric_periodic *whole, const ric_periodic *part)
{
    if (!(whole->half && whole->pure >= 0))
        return whole->pure >= 0 || whole->flip >= 0 ? RIC_TEST_B : RIC_TEST_A;
    return part->half ? RIC_TEST_B : part->flip >= 0 ? RIC_TEST_A : RIC_TEST_D;
}

ric_status ric_node_arrival(const ric_model *m, const ric_periodic *cycle, ric_node **out)
{
    ric_periodic *sym = ric_periodic_copy(cycle);
    *out = NULL;
    if (!sym) return ric_no_memory("a junction");
    int q = ric_periodic_find_symmetries(m, sym, RIC_SAME_EXTRAPOLATED);
    if (q > 1) {
        ric_periodic *shorter = ric_periodic_shorten(sym, q);
        ric_periodic_free(sym);
        if (!(sym = shorter)) return ric_no_memory("a junction");
        ric_periodic_find_symmetries(m, sym, RIC_SAME_EXTRAPOLATED);
        int p = rotation_of(m, sym, q);
        ric_status status =
            p > 0 ? ric_node_multiplication(m, sym, p, q, out)
                  : ric_fail(RIC_E_NUMERIC,
                             "an orbit gone through %d times has no multiplier of that order", q);
        ric_periodic_free(sym);
        return status;
    }
    ric_status status = ric_node_interior(m, sym, broken_test(sym, cycle), out);
    if (status == RIC_E_NUMERIC && sym->half && sym->pure >= 0) {
        /* two branch points so close that the orbit of one seems to have the symmetry of the other:
         * one symmetry is gained at a time */
        ric_periodic less = *sym;
        for (int i = 0; i < 3 && status == RIC_E_NUMERIC; i++) {
            less.half = i == 0;
            less.pure = i == 1 ? sym->pure : -1;
            less.flip = i == 2 ? sym->flip : -1;
            if (less.half == cycle->half && less.pure == cycle->pure && less.flip == cycle->flip)
                continue;
            status = ric_node_interior(m, &less, broken_test(&less, cycle), out);
        }
    }
    ric_periodic_free(sym);
    if (!status && *out && ric_periodic_repeats(m, (*out)->cycle, RIC_SAME_LOCATED)) {
        /* read off, the orbit was too far from the repeated one to be known for it; solved, it is
         */
        ric_node *repeated = *out;
        status = ric_node_arrival(m, repeated->cycle, out);
        ric_node_free(repeated);
    }
    return status;
}

/* ------------------------------------------------------------------ identity */

bool ric_node_soft(const ric_node *node, int touch)
{
    return node->kind == RIC_KIND_GRAZING &&
           ric_face_in(node->springs, node->cycle->face[node->touch[touch]]);
}

bool ric_node_chooses(const ric_node *node)
{
    return node->kind == RIC_KIND_GRAZING || node->kind == RIC_KIND_CORNER;
}

/* Doublings whose branches lose different mirror points, at energies that tell them apart: where an
 * orbit is all but unstable two may lie within what counts as one orbit. */
static bool break_apart(const ric_node *a, const ric_node *b)
{
    return a->kind == RIC_KIND_MULTIPLICATION && a->n_departure == 2 && b->n_departure == 2 &&
           a->departures[1].choice != b->departures[1].choice &&
           fabs(a->energy - b->energy) > RIC_SAME_SOLVED * fabs(a->energy);
}

bool ric_node_same(const ric_model *m, const ric_node *a, const ric_node *b)
{
    if (a->kind != b->kind || a->multiple != b->multiple || a->rotation[0] != b->rotation[0] ||
        a->cycle->N != b->cycle->N || a->n_touch != b->n_touch || break_apart(a, b))
        return false;
    if (a->asked.frequency != b->asked.frequency || a->asked.value != b->asked.value) return false;
    if (fabs(a->energy - b->energy) > ric_node_near(a->energy) ||
        fabs(a->period - b->period) > RIC_SAME_LOCATED * a->period)
        return false;
    return ric_periodic_same(m, a->cycle, b->cycle, RIC_SAME_EXTRAPOLATED);
}

unsigned ric_node_arrived(const ric_model *m, const ric_node *node, const ric_periodic *cycle)
{
    unsigned result = RIC_SIDE;
    ric_turn turn;
    ric_periodic *repeated = node->multiple > 1 && node->n_departure > 2
                                 ? ric_periodic_repeat(node->cycle, node->multiple)
                                 : NULL,
                 *home = NULL;
    if (!repeated) return node->n_departure > 1 ? node->departures[1].choice : RIC_SIDE;
    ric_periodic *here = ric_periodic_copy(cycle);
    bool found = here && ric_periodic_divide(m, here, repeated->N);
    found = found && ric_periodic_match(m, repeated, here, RIC_SAME_READ_OFF, &turn);
    if (here && !found &&
        ric_periodic_half_mark(m, here)) /* one starts at a rest, the other at a centre */
        found = ric_periodic_match(m, repeated, here, RIC_SAME_READ_OFF, &turn);
    if (found) home = ric_periodic_transform(m, here, turn.shift, turn.reverse, turn.mirror);
    ric_periodic_free(here);
    ric_symmetry other = ric_node_problem(node, RIC_OTHER_SIDE);
    if (home && home->pure < 0 && home->flip < 0 && ric_node_unmirrored(node, RIC_IMAGE_SIDE))
        result = RIC_IMAGE_SIDE;
    /* on an S orbit the two differ by the reversal; else by the mirror points of it, of which those
     * a period (2N half positions) apart are the same, those half a period apart are not */
    int r = !home             ? -1
            : home->pure >= 0 ? home->pure
                              : home->flip,
        other_r = other.pure >= 0 ? other.pure : other.flip;
    bool reversal = home && result == RIC_SIDE && (home->flip >= 0) == (other.flip >= 0);
    if (reversal && (node->cycle->half || (r - other_r) % (2 * node->cycle->N) == 0))
        result = RIC_OTHER_SIDE;
    if (home && result == RIC_SIDE && has_image(node) && node->n_departure > 3 &&
        (r - node->cycle->pure) / node->cycle->N % 2)
        result = RIC_IMAGE_SIDE;
    ric_periodic_free(repeated);
    ric_periodic_free(home);
    return result;
}

/* ------------------------------------------------------------- the ways out */

ric_periodic *ric_node_regular(const ric_model *m, const ric_node *node)
{
    return node->kind == RIC_KIND_GRAZING ? ric_grazing_words_cycle(m, node, 0)
                                          : ric_periodic_copy(node->cycle);
}

ric_periodic *ric_node_original(const ric_model *m, const ric_node *node, bool *bare)
{
    ric_periodic *regular = ric_node_regular(m, node), *once = NULL, *canonical = NULL,
                 *again = NULL;
    const bool grazing = node->kind == RIC_KIND_GRAZING;
    *bare = !regular;
    if (!regular) return NULL;
    if (grazing && node->multiple > 1) once = ric_periodic_shorten(regular, node->multiple);
    if (once || !grazing || node->multiple == 1)
        canonical = ric_periodic_canonical(m, once ? once : regular);
    ric_periodic_free(regular);
    ric_periodic_free(once);
    if (canonical && grazing) again = ric_node_solve_again(m, canonical);
    if (!again) return canonical;
    ric_periodic_free(canonical);
    return again;
}

int ric_node_impacts(const ric_node *node, unsigned choice)
{
    int count = ric_periodic_impacts(node->springs, node->cycle), missing = 0;
    if (node->kind == RIC_KIND_MULTIPLICATION && choice != RIC_THROUGH)
        return count * node->multiple;
    if (node->kind != RIC_KIND_GRAZING) return count;
    for (int i = 0; i < node->n_touch * node->multiple; i++)
        missing += !ric_node_strikes(choice, i);
    return count * node->multiple - missing;
}

bool ric_node_half(const ric_model *m, const ric_node *node, unsigned choice)
{
    ric_periodic *c = ric_node_chooses(node) ? ric_grazing_words_cycle(m, node, choice)
                                             : ric_periodic_copy(node->cycle);
    bool half = c && c->half && !ric_node_leaves(node, choice);
    ric_periodic_free(c);
    return ric_node_leaves(node, choice) ? ric_node_problem(node, choice).half : half;
}

bool ric_node_leaves(const ric_node *node, unsigned choice)
{
    return !ric_node_chooses(node) && choice != RIC_THROUGH;
}

bool ric_node_unmirrored(const ric_node *node, unsigned choice)
{
    return node->kind == RIC_KIND_MULTIPLICATION && choice == RIC_IMAGE_SIDE &&
           ric_symmetry_order(node->cycle, node->rotation[0], node->rotation[1]) == 2;
}

ric_symmetry ric_node_problem(const ric_node *node, unsigned choice)
{
    const ric_periodic *c = node->cycle;
    ric_symmetry problems[2] = {{.copies = 1, .half = c->half, .pure = c->pure, .flip = c->flip}};
    if (node->kind == RIC_KIND_MULTIPLICATION) {
        ric_symmetry_multiplying(c, node->rotation[0], node->rotation[1], problems);
        if (ric_node_unmirrored(node, choice)) problems[0].pure = problems[0].flip = -1;
        else if (choice == RIC_IMAGE_SIDE)
            problems[0].pure = (c->pure + c->N) % (c->N * node->multiple);
        return problems[choice == RIC_OTHER_SIDE];
    }
    return node->test == RIC_TEST_DET ? problems[0] : ric_symmetry_breaking(c, node->test);
}

/* Whether the two halves of a side branch are mirror images in x -> -x and nothing else takes one
 * to the other: in a structure that lacks this symmetry they are different motions, and the branch
 * is one curve through both. */
static bool splits(const ric_node *node)
{
    const ric_periodic *c = node->cycle;
    return !node->mirrors && (c->half || c->flip >= 0) &&
           (c->pure < 0 || ric_symmetry_breaking(c, node->test).pure >= 0);
}

bool ric_node_passes(const ric_node *node, unsigned choice)
{
    if (!ric_node_leaves(node, choice)) return !ric_node_chooses(node);
    if (node->kind == RIC_KIND_MULTIPLICATION)
        return ric_symmetry_passes(node->cycle, node->rotation[0], node->rotation[1]) ||
               (choice == RIC_SIDE && has_image(node) && node->multiple % 2);
    return node->test == RIC_TEST_DET || splits(node);
}
