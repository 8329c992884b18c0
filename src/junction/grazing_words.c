#include "grazing_words.h"
#include "base/room.h"

#include <stdlib.h>
#include <string.h>

#include "corner.h"
#include "orbit/room.h"

#define TOUCH 1e-9 /* reach within this of 1 at a located event is a touch */
#define FITS 1e-4  /* distance within which the end of a branch is the orbit of its junction */

/* ------------------------------------------------------------------ touches */

/* They are found contact by contact: those of a flight in the order of time, at one instant as
 * found. */
static void sort_touches(ric_touch *touches, int count)
{
    for (int i = 1; i < count; i++) {
        const ric_touch one = touches[i];
        int k = i;
        for (; k > 0 && touches[k - 1].flight == one.flight &&
               touches[k - 1].time > one.time + RIC_COINCIDENT;
             k--)
            touches[k] = touches[k - 1];
        touches[k] = one;
    }
}

/* Of a contact that touches at the very instant of an impact both flights tell, and where it does
 * so with no acceleration the same flight more than once: the first of the latter, in the flight
 * behind the impact. Returns how many are left. */
static int drop_repeated(const ric_periodic *c, int first, ric_touch *touches, int count)
{
    int left = 0;
    for (int j = 0; j < count; j++) {
        const double tau = c->tau[(touches[j].flight + first) % c->N];
        bool again = false;
        for (int i = 0; i < count && touches[j].time > tau - RIC_COINCIDENT; i++)
            again |= touches[i].face == touches[j].face && touches[i].time < RIC_COINCIDENT &&
                     touches[i].flight == (touches[j].flight + 1) % c->N;
        for (int i = 0; i < left; i++)
            again |= touches[i].face == touches[j].face && touches[i].flight == touches[j].flight &&
                     fabs(touches[j].time - touches[i].time) < RIC_COINCIDENT;
        if (!again) touches[left++] = touches[j];
    }
    return left;
}

ric_periodic *ric_grazing_words_touches(const ric_model *m, const ric_periodic *cycle, bool **kept)
{
    ric_periodic *plain = ric_periodic_copy(cycle), *out = NULL;
    ric_shooting *chain = NULL;
    ric_touch touches[4 * RIC_MAX_TOUCHES];
    double *u = NULL;
    int n = cycle->n, count, more, k = 0;
    if (!plain) return NULL;
    plain->half = false;
    plain->pure = plain->flip = -1;
    if (ric_periodic_to_chain(m, plain, &chain, &u)) goto out;
    ric_shooting_fly(chain, u);
    count = ric_reach_all(chain, u, 1 - TOUCH, 4 * RIC_MAX_TOUCHES, touches);
    int first = ric_periodic_start(m, plain);
    if (count > 4 * RIC_MAX_TOUCHES) goto out;
    sort_touches(touches, count);
    more = count = drop_repeated(cycle, first, touches, count);
    for (int j = 0; j < count; j++) more += m->face[touches[j].face].spring > 0;
    if (!(out = ric_periodic_create(n, cycle->N + more))) goto out;
    memcpy(out->w, cycle->w, 2 * (size_t)n * sizeof *out->w);
    out->closed = cycle->closed;
    if (kept && !(*kept = ric_calloc((size_t)out->N, sizeof **kept))) goto out;
    for (int i = 0; i < cycle->N; i++) {
        double left = cycle->tau[i], past = 0;
        if (kept) (*kept)[k] = true;
        out->face[k] = cycle->face[i];
        for (int j = 0; j < count; j++) {
            if ((touches[j].flight + first) % cycle->N != i) continue;
            out->tau[k++] = touches[j].time - past;
            left = cycle->tau[i] - touches[j].time;
            past = touches[j].time;
            out->face[k] = touches[j].face;
            if (m->face[touches[j].face].spring > 0) { /* switched there and back at once */
                out->tau[k++] = 0;
                out->face[k] = touches[j].face;
            }
        }
        out->tau[k++] = left;
    }
out:
    ric_shooting_free(chain);
    ric_periodic_free(plain);
    free(u);
    return out;
}

ric_status ric_grazing_words_lost(const ric_periodic *cycle)
{
    if (ric_memory_failed()) return ric_no_memory("a junction");
    return ric_fail(RIC_E_NUMERIC,
                    "an orbit of %d impacts touches more often than is looked at, or for good",
                    cycle->N);
}

/* ------------------------------------------------------------------ classes */

/* A symmetry that the touches hide, and which the orbit has without them: that of x -> -x, where
 * the touch is one of a wall that has no opposite side (theory section 2), or the reversal, where
 * contacts close at one instant, as it turns round the order in which they are listed. A branch on
 * one side of its grazing has every symmetry of its orbit there: its problem has one solution to
 * either side, and that with the touch is not the image of the one without. */
ric_periodic *ric_grazing_words_keep(const ric_model *m, const ric_periodic *whole,
                                     const bool *keep)
{
    ric_periodic *out = ric_periodic_keep(m, whole, keep),
                 *seen = out ? ric_periodic_copy(out) : NULL;
    if (seen && ric_periodic_find_symmetries(m, seen, RIC_SAME_LOCATED) == 1) {
        out->half |= seen->half;
        if (out->pure < 0) out->pure = seen->pure;
        if (out->flip < 0) out->flip = seen->flip;
    } else if (!seen) {
        ric_periodic_free(out);
        out = NULL;
    }
    ric_periodic_free(seen);
    return out;
}

/* An operation on the orbit gone through `multiple` times: element 0 identity, 1 half period, 2
 * reversal, 3 both, then `shift` periods. */
typedef struct {
    int element, shift;
} operation;

/* What an element makes of bit i: bit to[i], later[i] periods on. */
typedef struct {
    bool exists;
    int to[RIC_MAX_TOUCHES], later[RIC_MAX_TOUCHES];
} action;

/* At a corner a bit stands for an event and the next one, which a reversal exchanges. */
static void act_on_pairs(const ric_node *node, action out[4])
{
    const ric_periodic *c = node->cycle;
    int N = c->N, from[4] = {0, N / 2, c->pure, c->flip};
    for (int e = 0; e < 4; e++) {
        out[e].exists = e == 0 || (e == 1 ? c->half : from[e] >= 0);
        for (int i = 0; i < node->n_touch && out[e].exists; i++) {
            int place = from[e] + (e < 2 ? node->touch[i] : -node->touch[i] - 1),
                at = (place % N + N) % N;
            out[e].later[i] = (place - at) / N;
            for (int j = 0; j < node->n_touch; j++)
                if (node->touch[j] == at) out[e].to[i] = j;
        }
    }
}

/* The time that each element adds, of reversals the sum of the times of an event and its image;
 * NAN: the motion lacks it. Two contacts that close at one instant hide a reversal
 * (ric_grazing_words_keep): then the orbit without touches tells, and where that is a linear mode,
 * at rest when it touches. */
static bool times_of(const ric_model *m, const ric_node *node, const double *t, double sums[4])
{
    const ric_periodic *c = node->cycle;
    int N = c->N, event[N], kept = 0;
    double period = ric_periodic_period(c);
    bool keep[N];
    sums[0] = 0;
    sums[1] = c->half ? period / 2 : NAN;
    sums[2] = c->pure < 0 ? NAN : t[0] + t[c->pure];
    sums[3] = c->flip < 0 ? NAN : t[0] + t[c->flip];
    for (int i = 0; i < N; i++) keep[i] = true;
    for (int i = 0; i < node->n_touch; i++) {
        keep[node->touch[i]] = false;
        if (ric_node_soft(node, i)) keep[(node->touch[i] + 1) % N] = false;
    }
    for (int i = 0; i < N; i++)
        if (keep[i]) event[kept++] = i;
    ric_periodic *rest = kept ? ric_grazing_words_keep(m, c, keep) : NULL;
    if (kept && !rest) return false;
    bool half = !rest || rest->half;
    int pure = rest ? rest->pure : 0, flip = rest ? rest->flip : 0;
    if (isnan(sums[1]) && half) sums[1] = period / 2;
    if (isnan(sums[2]) && pure >= 0)
        sums[2] = rest ? t[event[0]] + t[event[pure]] : 2 * t[node->touch[0]];
    if (isnan(sums[3]) && flip >= 0)
        sums[3] = rest ? t[event[0]] + t[event[flip]] : 2 * t[node->touch[0]] + period / 2;
    ric_periodic_free(rest);
    return true;
}

/* The touch of `face` nearest to a time; *later: periods after its own. -1: none is near. */
static int touch_at(const ric_node *node, const double *t, int face, double time, int *later)
{
    double period = ric_periodic_period(node->cycle), nearest = FITS * period;
    int found = -1;
    for (int j = 0; j < node->n_touch; j++) {
        double periods = rint((time - t[node->touch[j]]) / period),
               off = fabs(time - t[node->touch[j]] - periods * period);
        if (node->cycle->face[node->touch[j]] != face || off >= nearest) continue;
        nearest = off;
        *later = (int)periods;
        found = j;
    }
    return found;
}

/* Touches are told by their times and faces. */
static bool act_on_touches(const ric_model *m, const ric_node *node, action out[4])
{
    const ric_periodic *c = node->cycle;
    double t[c->N], sums[4];
    t[0] = 0;
    for (int i = 1; i < c->N; i++) t[i] = t[i - 1] + c->tau[i - 1];
    if (!times_of(m, node, t, sums)) return false;
    for (int e = 0; e < 4; e++) {
        out[e].exists = !isnan(sums[e]);
        for (int i = 0; i < node->n_touch && out[e].exists; i++) {
            int face = c->face[node->touch[i]];
            if (e % 2) face = m->face[face].mirror;
            double time = sums[e] + (e < 2 ? 1 : -1) * t[node->touch[i]];
            out[e].exists = (out[e].to[i] = touch_at(node, t, face, time, &out[e].later[i])) >= 0;
        }
    }
    return true;
}

static bool find_actions(const ric_model *m, const ric_node *node, action out[4])
{
    memset(out, 0, 4 * sizeof *out);
    if (node->kind != RIC_KIND_CORNER) return act_on_touches(m, node, out);
    act_on_pairs(node, out);
    return true;
}

static unsigned mapped(const ric_node *node, const action *actions, operation o, unsigned choice)
{
    const action *a = &actions[o.element];
    unsigned out = 0;
    int p = node->n_touch, k = node->multiple;
    for (int bit = 0; bit < p * k; bit++) {
        if (!ric_node_strikes(choice, bit)) continue;
        int turn = o.shift + a->later[bit % p] + (o.element < 2 ? bit / p : -(bit / p));
        out |= 1u << ((turn % k + k) % k * p + a->to[bit % p]);
    }
    return out;
}

/* Whether an operation on the orbit is one on motions of the structure. */
static bool acts(const ric_node *node, const action *actions, int element)
{
    return actions[element].exists && (node->mirrors || element == 0 || element == 2);
}

/* Smallest choice equivalent under the symmetries of the node's orbit. */
static unsigned class_of(const ric_node *node, const action *actions, unsigned choice)
{
    unsigned best = choice;
    for (int e = 0; e < 4; e++)
        for (int s = 0; s < node->multiple && acts(node, actions, e); s++) {
            unsigned other = mapped(node, actions, (operation){e, s}, choice);
            if (other < best) best = other;
        }
    return best;
}

/* Shift of the operation of type `element` that keeps a choice; -1: none. */
static int keeper(const ric_node *node, const action *actions, int element, unsigned choice)
{
    for (int s = 0; s < node->multiple && actions[element].exists; s++)
        if (mapped(node, actions, (operation){element, s}, choice) == choice) return s;
    return -1;
}

/* Every operation but the identity as a permutation of bits; *n their number. NULL: no memory. */
static unsigned char *permutations(const ric_model *m, const ric_node *node, int *n)
{
    int bits = node->n_touch * node->multiple;
    action actions[4];
    unsigned char *table = find_actions(m, node, actions)
                               ? ric_malloc((size_t)4 * (size_t)node->multiple *
                                            (size_t)(bits ? bits : 1))
                               : NULL;
    *n = 0;
    for (int e = 0; table && e < 4; e++)
        for (int s = e == 0; s < node->multiple && acts(node, actions, e); s++) {
            unsigned char *row = table + (size_t)(*n)++ * (size_t)bits;
            for (int bit = 0; bit < bits; bit++) {
                unsigned to = mapped(node, actions, (operation){e, s}, 1u << bit);
                for (row[bit] = 0; to > 1; to >>= 1) row[bit]++;
            }
        }
    return table;
}

/* Whether a choice is the smallest of its class and, on a duplicate, no repetition of a shorter
 * one: the first operations are shifts. */
static bool is_listed(const ric_node *node, const unsigned char *table, int n, unsigned choice)
{
    int bits = node->n_touch * node->multiple;
    for (int k = 0; k < n; k++) {
        const unsigned char *row = table + (size_t)k * (size_t)bits;
        unsigned other = 0;
        for (unsigned rest = choice; rest; rest &= rest - 1)
            other |= 1u << row[__builtin_ctz(rest)];
        if (other < choice || (other == choice && k < node->multiple - 1)) return false;
    }
    return true;
}

static bool add(ric_node *node, int *capacity, ric_departure departure)
{
    if (node->n_departure == *capacity) {
        *capacity = *capacity ? 2 * *capacity : 8;
        ric_departure *grown = ric_realloc(node->departures, (size_t)*capacity * sizeof *grown);
        if (!grown) return false;
        node->departures = grown;
    }
    node->departures[node->n_departure++] = departure;
    return true;
}

bool ric_grazing_words_list(const ric_model *m, ric_node *node)
{
    int n, capacity = 0;
    if (node->refusal)
        return add(node, &capacity,
                   (ric_departure){.state = RIC_DEPARTURE_OVER_BUDGET,
                                   .budget = RIC_BUDGET_TOUCHES});
    unsigned char *table = permutations(m, node, &n);
    bool good = table;
    for (unsigned choice = 0; good && choice < 1u << (node->n_touch * node->multiple); choice++)
        if (is_listed(node, table, n, choice))
            good = add(node, &capacity, (ric_departure){.choice = choice});
    free(table);
    return good;
}

/* ------------------------------------------------------------------- orbits */

ric_periodic *ric_grazing_words_cycle(const ric_model *m, const ric_node *node, unsigned choice)
{
    int N = node->cycle->N, all = N * node->multiple, kept = 0, p = node->n_touch;
    bool keep[all];
    if (node->kind == RIC_KIND_CORNER)
        return ric_corner_swap(m, node->cycle, p, node->touch, choice, RIC_SAME_LOCATED);
    action actions[4];
    ric_periodic *whole = find_actions(m, node, actions)
                              ? ric_periodic_repeat(node->cycle, node->multiple)
                              : NULL,
                 *out = NULL;
    if (!whole) return NULL;
    for (int i = 0; i < all; i++) keep[i] = true;
    for (int bit = 0; bit < p * node->multiple; bit++) {
        int place = bit / p * N + node->touch[bit % p];
        keep[place] = ric_node_strikes(choice, bit);
        if (ric_node_soft(node, bit % p)) keep[(place + 1) % all] = keep[place];
    }
    for (int i = 0; i < all; i++) kept += keep[i];
    /* what hides from the node's cycle is found on what is kept */
    int pure = keeper(node, actions, 2, choice), flip = keeper(node, actions, 3, choice),
        half = (node->multiple - 1) / 2;
    whole->half = node->cycle->half && node->multiple % 2 && actions[1].exists &&
                  mapped(node, actions, (operation){1, half}, choice) == choice;
    whole->pure = pure < 0 || node->cycle->pure < 0 ? -1 : (node->cycle->pure + pure * N) % all;
    whole->flip = flip < 0 || node->cycle->flip < 0 ? -1 : (node->cycle->flip + flip * N) % all;
    if (kept) out = ric_grazing_words_keep(m, whole, keep);
    ric_periodic_free(whole);
    return out;
}

int ric_grazing_words_order(const ric_model *m, const ric_node *node, const ric_periodic *cycle)
{
    int result = -1;
    ric_turn turn;
    for (int i = 0; i < node->n_departure && result < 0; i++) {
        unsigned choice = node->departures[i].choice;
        ric_periodic *swapped = ric_grazing_words_cycle(m, node, choice);
        if (swapped && ric_periodic_match(m, swapped, cycle, FITS, &turn)) result = (int)choice;
        ric_periodic_free(swapped);
    }
    return result;
}

/* Exchanges the events at the place of each pair in `order`, and whether they are kept. */
static void exchange(ric_periodic *c, bool *kept, int n_pair, const int *pairs, unsigned order)
{
    for (int k = 0; k < n_pair; k++) {
        const int i = pairs[k], j = (i + 1) % c->N, face = c->face[i];
        const bool keep = kept[i];
        if (!(order & 1u << k)) continue;
        c->face[i] = c->face[j];
        c->face[j] = face;
        kept[i] = kept[j];
        kept[j] = keep;
    }
}

/* Touches of two contacts at one instant are listed in either order: `full` in that in which it is
 * the orbit of the node. */
static bool match_touches(const ric_model *m, const ric_periodic *whole, ric_periodic *full,
                          bool *kept, ric_turn *turn)
{
    int pairs[RIC_MAX_TOUCHES], n = 0;
    bool found = false;
    for (int i = 0; i < full->N && n < RIC_MAX_TOUCHES; i++)
        if (full->tau[i] < RIC_COINCIDENT &&
            m->face[full->face[i]].contact != m->face[full->face[(i + 1) % full->N]].contact)
            pairs[n++] = i;
    for (unsigned order = 0; order < 1u << n && !found; order++) {
        exchange(full, kept, n, pairs, order);
        found = ric_periodic_match(m, whole, full, FITS, turn);
        if (!found) exchange(full, kept, n, pairs, order);
    }
    return found;
}

int ric_grazing_words_choice(const ric_model *m, const ric_node *node, ric_periodic *full,
                             bool *kept)
{
    int result = -1, N = node->cycle->N, all = N * node->multiple, p = node->n_touch;
    ric_turn turn;
    action actions[4];
    ric_periodic *whole = ric_periodic_repeat(node->cycle, node->multiple);
    if (whole && find_actions(m, node, actions) && full->N == all &&
        match_touches(m, whole, full, kept, &turn)) {
        unsigned choice = 0;
        for (int bit = 0; bit < p * node->multiple; bit++) {
            int i = bit / p * N + node->touch[bit % p],
                j = turn.reverse ? ((turn.shift - i) % all + all) % all : (turn.shift + i) % all;
            if (kept[j]) choice |= 1u << bit;
        }
        result = (int)class_of(node, actions, choice);
    }
    ric_periodic_free(whole);
    return result;
}
