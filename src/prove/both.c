#include "both.h"

#include <math.h>

#include "base/room.h"

/* Whether the motion goes back from a state, before the impact if there is one, the way it came. */
static bool turns(const ric_enclosure *e, ric_chain_end kind, int face, arb_srcptr w)
{
    arb_ptr image = _arb_vec_init(2 * e->n);
    _arb_vec_set(image, w, 2 * e->n);
    if (kind == RIC_CHAIN_CENTRE) _arb_vec_neg(image, image, 2 * e->n);
    else if (kind == RIC_CHAIN_IMPACT) ric_chain_reflect(e, face, image + e->n);
    const bool found = ric_chain_goes_back(e, w, image);
    _arb_vec_clear(image, 2 * e->n);
    return found;
}

/* The kind of mirror point behind the last flight, or RIC_CHAIN_GENERAL. */
static ric_chain_end kind_at(const ric_chain *c, const ric_enclosure *e)
{
    static const ric_chain_end in_flight[] = {RIC_CHAIN_REST, RIC_CHAIN_CENTRE};
    const int face = c->face[c->m], last = c->m - 1;
    ric_chain_end found = RIC_CHAIN_GENERAL;
    arb_srcptr w = ric_chain_block(c, last);
    arb_ptr flown = _arb_vec_init(2 * c->n);
    ric_chain_fly(e, c->phase[last], w, w + 2 * c->n, flown);
    if (face >= 0 && !e->wall[face].closes && turns(e, RIC_CHAIN_IMPACT, face, flown))
        found = RIC_CHAIN_IMPACT;
    for (int k = 0; face < 0 && !c->phase[last] && k < 2; k++)
        if (turns(e, in_flight[k], -1, flown)) found = in_flight[k];
    _arb_vec_clear(flown, 2 * c->n);
    return found;
}

/* From behind the flight of no length, over `left` as far as that goes, to an impact or in flight.
 */
static bool fill(ric_chain *c, const ric_chain *general, const ric_enclosure *e, int flight,
                 double left, double near)
{
    const int m = general->m, first = (flight + 1) % m;
    int count = 0;
    while (count < m && left > near)
        left -= ric_arb_middle(ric_chain_block(general, (first + count++) % m) + 2 * general->n);
    if (!count) return false;
    ric_chain_allocate(c, e, count);
    c->also = general->face[flight];
    for (int k = 0; k < count; k++) {
        const int from = (first + k) % m;
        _arb_vec_set(ric_chain_block(c, k), ric_chain_block(general, from), c->size);
        c->face[k] = general->face[from];
        c->phase[k] = general->phase[from];
    }
    c->face[count] = left < -near ? -1 : general->face[(first + count) % m];
    arb_ptr tau = ric_chain_block(c, count - 1) + 2 * c->n;
    arb_t over;
    arb_init(over);
    arb_set_d(over, left);
    if (c->face[count] < 0) arb_add(tau, tau, over, e->prec);
    arb_get_mid_arb(tau, tau);
    arb_clear(over);
    return true;
}

bool ric_both_create(ric_chain *c, const ric_chain *general, const ric_enclosure *e, int flight,
                     int way, bool broken[2])
{
    static const struct {
        int share; /* of the period of the branch */
        bool last, halved;
    } ways[RIC_BOTH_WAYS] = {{2, true, false},
                             {4, false, false},
                             {4, false, true},
                             {4, true, true}};
    const int m = general->m;
    const ric_wall *f = &e->wall[general->face[(flight + 1) % m]],
                   *g = &e->wall[general->face[flight]];
    double period = 0;
    *c = (ric_chain){.sign = 1, .number = -1, .start = RIC_CHAIN_BOTH};
    broken[0] = true;
    broken[1] = ways[way].last;
    if (f->closes || g->closes || !ric_enclosure_orthogonal(e->model, f->contact, g->contact))
        return false;
    for (int k = 0; k < m; k++)
        period += ric_arb_middle(ric_chain_block(general, k) + 2 * general->n);
    if (!fill(c, general, e, flight, period / ways[way].share, RIC_AT_MIRROR * period))
        return false;
    c->end = kind_at(c, e);
    return c->end != RIC_CHAIN_GENERAL && ric_chain_halved(c) == ways[way].halved;
}

/* ---------------------------------------------------------------------- rows */

/* out = x_i y_j - x_j y_i */
static void minor(arb_srcptr x, arb_srcptr y, slong i, slong j, slong prec, arb_t out)
{
    arb_mul(out, x + i, y + j, prec);
    arb_submul(out, x + j, y + i, prec);
}

/* The two components by which the normals are told apart best. */
static void pivots(int n, arb_srcptr x, arb_srcptr y, slong out[2])
{
    double most = -1;
    for (slong i = 0; i < n; i++)
        for (slong j = i + 1; j < n; j++) {
            const double size = fabs(ric_arb_middle(x + i) * ric_arb_middle(y + j) -
                                     ric_arb_middle(x + j) * ric_arb_middle(y + i));
            if (!(size > most)) continue;
            most = size;
            out[0] = i;
            out[1] = j;
        }
}

void ric_both_across(const ric_enclosure *e, const ric_chain *c, bool speed, slong row, arb_mat_t B)
{
    const slong n = e->n, part = speed ? n : 0;
    arb_srcptr x = ric_enclosure_c(e, e->wall[c->face[0]].contact),
               y = ric_enclosure_c(e, e->wall[c->also].contact);
    slong at[2] = {0, 1};
    pivots(e->n, x, y, at);
    for (slong i = 0; i < n; i++) {
        if (i == at[0] || i == at[1]) continue;
        minor(x, y, at[0], at[1], e->prec, arb_mat_entry(B, row, part + i));
        minor(x, y, at[1], i, e->prec, arb_mat_entry(B, row, part + at[0]));
        minor(x, y, i, at[0], e->prec, arb_mat_entry(B, row, part + at[1]));
        row++;
    }
}

void ric_both_mirror(const ric_enclosure *e, const ric_chain *c, arb_mat_t B, arb_t gap)
{
    const ric_wall *f = &e->wall[c->face[0]], *g = &e->wall[c->also];
    const slong n = e->n;
    arb_t turned;
    arb_init(turned);
    arb_set(gap, f->gap);
    _arb_vec_set(arb_mat_entry(B, 0, 0), ric_enclosure_c(e, f->contact), n);
    /* c_f q = d_f has d_g c_f q = d_f c_g q */
    arb_ptr row = arb_mat_entry(B, 1, 0);
    _arb_vec_scalar_mul(row, ric_enclosure_c(e, f->contact), n, g->gap, e->prec);
    arb_neg(turned, f->gap);
    _arb_vec_scalar_addmul(row, ric_enclosure_c(e, g->contact), n, turned, e->prec);
    ric_both_across(e, c, true, 2, B);
    arb_clear(turned);
}
