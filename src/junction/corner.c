#include "corner.h"
#include "base/room.h"

#include <stdlib.h>

#include "model/room.h"

bool ric_corner_commute(const ric_model *m, const ric_face *f, const ric_face *g)
{
    return (f->spring > 0 && g->spring > 0) || ric_model_orthogonal(m, f->contact, g->contact);
}

int ric_corner_pairs(const ric_model *m, const ric_periodic *c, double speed, int capacity,
                     int *pairs)
{
    int N = c->N, n = c->n, count = 0;
    double *W = ric_calloc((size_t)N * 2 * (size_t)n, sizeof *W);
    bool defined = W, touch = false, three = false;
    if (W) ric_periodic_states(m, c, W);
    for (int i = 0; i < N && defined; i++) {
        int j = (i + 1) % N;
        const ric_face *f = &m->face[c->face[i]], *g = &m->face[c->face[j]];
        bool pair = c->tau[i] < RIC_COINCIDENT && f->contact != g->contact;
        /* three at once: the impact in the middle belongs to two pairs */
        if (pair && (!ric_corner_commute(m, f, g) || count == capacity)) defined = false;
        if (!pair || !defined) continue;
        touch |= fabs(ric_dot(n, f->c, W + 2 * n * i + n)) < speed ||
                 fabs(ric_dot(n, g->c, W + 2 * n * j + n)) < speed;
        three |= count > 0 && (pairs[count - 1] == i - 1 || (pairs[0] == 0 && i == N - 1));
        pairs[count++] = i;
    }
    free(W);
    return !defined ? RIC_CORNER_UNDEFINED : touch || three ? RIC_CORNER_TOGETHER : count;
}

ric_periodic *ric_corner_swap(const ric_model *m, const ric_periodic *c, int n_pair,
                              const int *pairs, unsigned choice, double tolerance)
{
    ric_periodic *out = ric_periodic_copy(c);
    if (!out) return NULL;
    for (int k = 0; k < n_pair; k++) {
        if (!(choice & 1u << k)) continue;
        int i = pairs[k], j = (i + 1) % c->N, face = c->face[i];
        out->face[i] = c->face[j];
        out->face[j] = face;
        /* w is the state between the two */
        if (i == 0)
            for (int side = 0; side < 2; side++)
                out->closed = ric_flight_toggle(m, out->closed, c->face[side]);
        if (i == 0)
            for (int side = 0; side < 2; side++)
                ric_flight_strike(c->n, &m->face[c->face[side]], out->w + c->n);
    }
    ric_periodic_find_symmetries(m, out, tolerance);
    return out;
}

static int symmetries(const ric_periodic *c)
{
    return c->half + (c->pure >= 0) + (c->flip >= 0);
}

ric_periodic *ric_corner_least(const ric_model *m, const ric_periodic *c, int n_pair,
                               const int *pairs, double tolerance)
{
    ric_periodic *best = NULL;
    for (unsigned choice = 0; choice < 1u << n_pair; choice++) {
        ric_periodic *swapped = ric_corner_swap(m, c, n_pair, pairs, choice, tolerance);
        ric_periodic *canonical = swapped ? ric_periodic_canonical(m, swapped) : NULL;
        ric_periodic_free(swapped);
        if (!canonical) {
            ric_periodic_free(best);
            return NULL;
        }
        int more = best ? symmetries(canonical) - symmetries(best) : 1;
        if (more > 0 ||
            (more == 0 && ric_periodic_compare(ric_periodic_springs(m), canonical, best) < 0)) {
            ric_periodic *old = best;
            best = canonical;
            canonical = old;
        }
        ric_periodic_free(canonical);
    }
    return best;
}

bool ric_corner_fixed(const ric_model *m, const ric_periodic *c, int n_pair, const int *pairs,
                      double tolerance)
{
    bool found = false;
    for (unsigned choice = 1; choice < 1u << n_pair && !found; choice++) {
        ric_turn turn;
        ric_periodic *swapped = ric_corner_swap(m, c, n_pair, pairs, choice, tolerance);
        found = swapped && ric_periodic_match(m, c, swapped, tolerance, &turn);
        ric_periodic_free(swapped);
    }
    return found;
}
