#include "subset.h"

#include <stdlib.h>
#include <string.h>

#include "corner.h"
#include "reach.h"

#define TOUCH 1e-9      /* reach within this of 1 at a located event is a touch */
#define SAME 1e-6       /* two located orbits closer than this (relative) are one */
#define FITS 1e-4       /* distance within which the end of a branch is the orbit of its junction */

/* ------------------------------------------------------------------ touches */

ric_cycle *ric_subset_touches(const ric_model *m, const ric_cycle *cycle, bool **kept)
{
    ric_cycle *plain = ric_cycle_copy(cycle), *out = NULL;
    ric_chain *chain = NULL;
    ric_touch touches[4 * RIC_MAX_TOUCHES];
    double *u = NULL;
    int n = cycle->n, count, more, k = 0;
    if (!plain) return NULL;
    plain->half = false;
    plain->pure = plain->flip = -1;
    if (ric_cycle_to_chain(m, plain, &chain, &u)) goto out;
    ric_chain_fly(chain, u);
    count = ric_reach_all(chain, u, 1 - TOUCH, 4 * RIC_MAX_TOUCHES, touches);
    int first = ric_cycle_start(m, plain);
    if ((more = count) > 4 * RIC_MAX_TOUCHES) goto out;
    for (int j = 0; j < count; j++) more += m->face[touches[j].face].spring > 0;
    if (!(out = ric_cycle_create(n, cycle->N + more))) goto out;
    memcpy(out->w, cycle->w, 2 * (size_t)n * sizeof *out->w);
    out->closed = cycle->closed;
    if (kept && !(*kept = calloc((size_t)out->N, sizeof **kept))) goto out;
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
    ric_chain_free(chain);
    ric_cycle_free(plain);
    free(u);
    return out;
}

/* ------------------------------------------------------------------ classes */

/* An operation on the orbit gone through `multiple` times: element 0 identity, 1 half period, 2 reversal, 3 both, then
 * `shift` periods. */
typedef struct { int element, shift; } operation;

static bool exists(const ric_cycle *c, int element)
{
    return element == 0 || (element == 1 && c->half) || (element == 2 && c->pure >= 0) ||
           (element == 3 && c->flip >= 0);
}

static int image(const ric_node *node, operation o, int i)
{
    const ric_cycle *c = node->cycle;
    int N = c->N, all = N * node->multiple, shift = o.shift * N;
    /* at a corner, and at the touch of a spring, a bit stands for an event and the next one, which a reversal
     * exchanges */
    int next = node->kind == RIC_KIND_CORNER || node->springs >> c->face[i % N] & 1;
    int out = o.element == 0   ? i + shift
              : o.element == 1 ? i + N / 2 + shift
                               : (o.element == 2 ? c->pure : c->flip) + shift - i - next;
    return (out % all + all) % all;
}

static unsigned mapped(const ric_node *node, operation o, unsigned choice)
{
    unsigned out = 0;
    int p = node->n_touch, N = node->cycle->N;
    for (int bit = 0; bit < p * node->multiple; bit++) {
        if (!(choice & 1u << bit)) continue;
        int place = image(node, o, bit / p * N + node->touch[bit % p]);
        for (int i = 0; i < p; i++)
            if (node->touch[i] == place % N) out |= 1u << (place / N * p + i);
    }
    return out;
}

/* Whether an operation on the orbit is one on motions of the structure. */
static bool acts(const ric_node *node, int element)
{
    return exists(node->cycle, element) && (node->mirrors || element == 0 || element == 2);
}

/* Smallest choice equivalent under the symmetries of the node's orbit. */
static unsigned class_of(const ric_node *node, unsigned choice)
{
    unsigned best = choice;
    for (int e = 0; e < 4; e++)
        for (int s = 0; s < node->multiple && acts(node, e); s++) {
            unsigned other = mapped(node, (operation){e, s}, choice);
            if (other < best) best = other;
        }
    return best;
}

/* Shift of the operation of type `element` that keeps a choice; -1: none. */
static int keeper(const ric_node *node, int element, int first, unsigned choice)
{
    for (int s = first; s < node->multiple && exists(node->cycle, element); s++)
        if (mapped(node, (operation){element, s}, choice) == choice) return s;
    return -1;
}

/* Every operation but the identity as a permutation of bits; *n their number. NULL: no memory. */
static unsigned char *permutations(const ric_node *node, int *n)
{
    int bits = node->n_touch * node->multiple;
    unsigned char *table = malloc((size_t)4 * node->multiple * (bits ? bits : 1));
    *n = 0;
    for (int e = 0; table && e < 4; e++)
        for (int s = e == 0; s < node->multiple && acts(node, e); s++) {
            unsigned char *row = table + (size_t)(*n)++ * bits;
            for (int bit = 0; bit < bits; bit++) {
                unsigned to = mapped(node, (operation){e, s}, 1u << bit);
                for (row[bit] = 0; to > 1; to >>= 1) row[bit]++;
            }
        }
    return table;
}

/* Whether a choice is the smallest of its class and, on a duplicate, no repetition of a shorter one: the first
 * operations are shifts. */
static bool is_listed(const ric_node *node, const unsigned char *table, int n, unsigned choice)
{
    int bits = node->n_touch * node->multiple;
    for (int k = 0; k < n; k++) {
        const unsigned char *row = table + (size_t)k * bits;
        unsigned other = 0;
        for (int bit = 0; bit < bits; bit++)
            if (choice & 1u << bit) other |= 1u << row[bit];
        if (other < choice || (other == choice && k < node->multiple - 1)) return false;
    }
    return true;
}

static bool add(ric_node *node, int *capacity, ric_departure departure)
{
    if (node->n_departure == *capacity) {
        *capacity = *capacity ? 2 * *capacity : 8;
        ric_departure *grown = realloc(node->departures, (size_t)*capacity * sizeof *grown);
        if (!grown) return false;
        node->departures = grown;
    }
    node->departures[node->n_departure++] = departure;
    return true;
}

bool ric_subset_list(ric_node *node)
{
    int n, capacity = 0;
    if (node->refusal) return add(node, &capacity, (ric_departure){.state = RIC_DEPARTURE_OVER_BUDGET,
                                                                   .budget = RIC_BUDGET_TOUCHES});
    unsigned char *table = permutations(node, &n);
    bool good = table;
    for (unsigned choice = 0; good && choice < 1u << (node->n_touch * node->multiple); choice++)
        if (is_listed(node, table, n, choice)) good = add(node, &capacity, (ric_departure){.choice = choice});
    free(table);
    return good;
}

/* ------------------------------------------------------------------- orbits */

/* A symmetry that the touches hide, and which the orbit has without them: that of x -> -x, where the touch is one of a
 * wall that has no opposite side (theory section 2), or the reversal, where contacts close at one instant, as it turns
 * round the order in which they are listed. A branch on one side of its grazing has every symmetry of its orbit there:
 * its problem has one solution to either side, and that with the touch is not the image of the one without. */
ric_cycle *ric_subset_keep(const ric_model *m, const ric_cycle *whole, const bool *keep)
{
    ric_cycle *out = ric_cycle_keep(m, whole, keep), *seen = out ? ric_cycle_copy(out) : NULL;
    if (seen && ric_cycle_find_symmetries(m, seen, SAME) == 1) {
        out->half |= seen->half;
        if (out->pure < 0) out->pure = seen->pure;
        if (out->flip < 0) out->flip = seen->flip;
    } else if (!seen) {
        ric_cycle_free(out);
        out = NULL;
    }
    ric_cycle_free(seen);
    return out;
}

ric_cycle *ric_subset_cycle(const ric_model *m, const ric_node *node, unsigned choice)
{
    int N = node->cycle->N, all = N * node->multiple, kept = 0, p = node->n_touch;
    bool keep[all];
    if (node->kind == RIC_KIND_CORNER) return ric_corner_swap(m, node->cycle, p, node->touch, choice, SAME);
    ric_cycle *whole = ric_cycle_repeat(node->cycle, node->multiple), *out = NULL;
    if (!whole) return NULL;
    for (int i = 0; i < all; i++) keep[i] = true;
    for (int bit = 0; bit < p * node->multiple; bit++) {
        int place = bit / p * N + node->touch[bit % p];
        keep[place] = choice & 1u << bit;
        if (ric_node_soft(node, bit % p)) keep[(place + 1) % all] = keep[place];
    }
    for (int i = 0; i < all; i++) kept += keep[i];
    int pure = keeper(node, 2, 0, choice), flip = keeper(node, 3, 0, choice), half = (node->multiple - 1) / 2;
    whole->half = node->cycle->half && node->multiple % 2 && mapped(node, (operation){1, half}, choice) == choice;
    whole->pure = pure < 0 ? -1 : (node->cycle->pure + pure * N) % all;
    whole->flip = flip < 0 ? -1 : (node->cycle->flip + flip * N) % all;
    if (kept) out = ric_subset_keep(m, whole, keep);
    ric_cycle_free(whole);
    return out;
}

/* The order of pairs at a corner that is the word of `cycle`. */
static int corner_choice(const ric_model *m, const ric_node *node, const ric_cycle *cycle)
{
    int result = -1, shift;
    bool reverse, mirror;
    for (int i = 0; i < node->n_departure && result < 0; i++) {
        unsigned choice = node->departures[i].choice;
        ric_cycle *swapped = ric_subset_cycle(m, node, choice);
        if (swapped && ric_cycle_match(m, swapped, cycle, FITS, &shift, &reverse, &mirror)) result = (int)choice;
        ric_cycle_free(swapped);
    }
    return result;
}

int ric_subset_choice(const ric_model *m, const ric_node *node, const ric_cycle *cycle)
{
    int result = -1, shift, N = node->cycle->N, all = N * node->multiple, p = node->n_touch;
    bool reverse, mirror, *kept = NULL;
    if (node->kind == RIC_KIND_CORNER) return corner_choice(m, node, cycle);
    ric_cycle *full = ric_subset_touches(m, cycle, &kept), *whole = ric_cycle_repeat(node->cycle, node->multiple);
    if (full && kept && whole && full->N == all && ric_cycle_match(m, whole, full, FITS, &shift, &reverse, &mirror)) {
        unsigned choice = 0;
        for (int bit = 0; bit < p * node->multiple; bit++) {
            int i = bit / p * N + node->touch[bit % p],
                j = reverse ? ((shift - i) % all + all) % all : (shift + i) % all;
            if (kept[j]) choice |= 1u << bit;
        }
        result = (int)class_of(node, choice);
    }
    free(kept);
    ric_cycle_free(full);
    ric_cycle_free(whole);
    return result;
}
