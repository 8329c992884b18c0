#include "twin_chain.h"

#include <math.h>

#include "base/room.h"

void ric_twin_chain_image(const ric_enclosure *e, const ric_twin *twin, arb_ptr w)
{
    const int n = e->n, n_dof = e->n_dof;
    arb_mat_t x, q;
    arb_mat_init(x, n_dof, 1);
    arb_mat_init(q, n, 1);
    for (int part = 0; part < 2; part++) {
        for (int i = 0; i < n_dof; i++) {
            arb_ptr to = arb_mat_entry(x, twin->to[i], 0);
            arb_dot(to, NULL, 0, arb_mat_entry(e->X, i, 0), 1, w + part * n, 1, n, e->prec);
            if (twin->sign[i] < 0) arb_neg(to, to);
        }
        arb_mat_mul(q, e->back, x, e->prec);
        for (int i = 0; i < n; i++) arb_set(w + part * n + i, arb_mat_entry(q, i, 0));
    }
    arb_mat_clear(x);
    arb_mat_clear(q);
}

/* What the state w [2n] is turned into by a mirror point of a kind, but for the direction of time.
 */
static void reflect(const ric_enclosure *e, const ric_twin *twin, ric_chain_end kind, int face,
                    arb_ptr w)
{
    if (kind == RIC_CHAIN_TWIN) ric_twin_chain_image(e, twin, w);
    else if (kind == RIC_CHAIN_IMPACT) ric_chain_reflect(e, face, w + e->n);
}

/* Whether the motion goes back from a state as what it came by, to a part of its speed. */
static bool turns(const ric_enclosure *e, const ric_twin *twin, ric_chain_end kind, int face,
                  arb_srcptr w)
{
    arb_ptr image = _arb_vec_init(2 * e->n);
    _arb_vec_set(image, w, 2 * e->n);
    reflect(e, twin, kind, face, image);
    const bool turns = ric_chain_goes_back(e, w, image);
    _arb_vec_clear(image, 2 * e->n);
    return turns;
}

/* The state at a place: 2 k is impact k, 2 k + 1 the middle of the flight behind it. */
static void state_at(const ric_chain *c, const ric_enclosure *e, int place, arb_ptr w)
{
    const int k = place / 2 % c->m;
    arb_srcptr block = ric_chain_block(c, k);
    arb_t half;
    arb_init(half);
    arb_mul_2exp_si(half, block + 2 * c->n, -1);
    if (place % 2) ric_chain_fly(e, c->phase[k], block, half, w);
    else _arb_vec_set(w, block, 2 * c->n);
    for (int i = 0; i < 2 * c->n; i++) arb_get_mid_arb(w + i, w + i);
    arb_clear(half);
}

/* The kind of mirror point at a place, or RIC_CHAIN_GENERAL. */
static ric_chain_end kind_at(const ric_chain *c, const ric_enclosure *e, const ric_twin *twin,
                             int place)
{
    static const ric_chain_end in_flight[] = {RIC_CHAIN_REST, RIC_CHAIN_TWIN};
    const int face = c->face[place / 2 % c->m];
    ric_chain_end found = RIC_CHAIN_GENERAL;
    arb_ptr w = _arb_vec_init(2 * c->n);
    state_at(c, e, place, w);
    if (place % 2 == 0) {
        if (turns(e, twin, RIC_CHAIN_IMPACT, face, w)) found = RIC_CHAIN_IMPACT;
    } else
        for (int k = 0; k < 2 && found == RIC_CHAIN_GENERAL; k++)
            if (turns(e, twin, in_flight[k], -1, w)) found = in_flight[k];
    _arb_vec_clear(w, 2 * c->n);
    return found;
}

/* From one place to a later one, both mirror points. */
static void fill(ric_chain *c, const ric_chain *general, const ric_enclosure *e, int from, int to)
{
    ric_chain_allocate(c, e, (to + 1) / 2 - from / 2);
    c->first = from / 2;
    c->half_flight = true;
    for (int k = 0; k < c->m; k++) {
        const int impact = (c->first + k) % general->m;
        const bool cut = k == 0 || (k == c->m - 1 && to % 2);
        arb_ptr block = ric_chain_block(c, k);
        _arb_vec_set(block, ric_chain_block(general, impact), c->size);
        arb_mul_2exp_si(block + 2 * c->n, block + 2 * c->n, cut ? -1 : 0);
        c->face[k] = k == 0 ? -1 : general->face[impact];
        c->phase[k] = general->phase[impact];
    }
    state_at(general, e, from, c->u);
    c->face[c->m] = to % 2 ? -1 : general->face[to / 2 % general->m];
}

bool ric_twin_chain_create(ric_chain *c, const ric_chain *general, const ric_enclosure *e,
                           const ric_twin *twin)
{
    const int around = 2 * general->m;
    int from = 1, to;
    *c = (ric_chain){.sign = 1, .number = -1, .start = RIC_CHAIN_TWIN, .twin = twin};
    if (e->n != e->n_dof) return false;
    while (from < around && kind_at(general, e, twin, from) != RIC_CHAIN_TWIN) from += 2;
    for (to = from + 1; to < from + around && c->end == RIC_CHAIN_GENERAL; to++)
        c->end = kind_at(general, e, twin, to);
    if (from >= around || c->end == RIC_CHAIN_GENERAL) return false;
    fill(c, general, e, from, to - 1);
    return true;
}
