#include "passage.h"

#include <stdio.h>

#include "base/room.h"

enum {
    DEEPEST = 40, /* bisections of a flight: a gap that is not told from closed then touches */
    SURE = 2,     /* the gap of an impact opens over the time speed / |acceleration|, and is positive for twice that */
};

/* A gap along a flight: h = d - side c.q. */
typedef struct {
    const ric_enclosure *e;
    arb_srcptr w; /* [2n] at the beginning */
    arb_srcptr c; /* normal */
    int side;
    arb_t d;           /* clearance > 0 */
    arb_t bend, slack; /* bound of |h''|; of what flights leave open of h and h' */
    arb_ptr flown;     /* [2n] scratch */
} gap;

static void gap_init(gap *g, const ric_enclosure *e)
{
    *g = (gap){.e = e, .flown = _arb_vec_init(2 * e->n)};
    arb_init(g->d);
    arb_init(g->bend);
    arb_init(g->slack);
}

static void gap_clear(gap *g)
{
    _arb_vec_clear(g->flown, 2 * g->e->n);
    arb_clear(g->d);
    arb_clear(g->bend);
    arb_clear(g->slack);
}

/* |h''| <= sum |c_i| omega_i sqrt(omega_i^2 q_i^2 + p_i^2) + |c| slack |w|. */
static void gap_bend(gap *g, const arb_t slack)
{
    const ric_enclosure *e = g->e;
    slong n = e->n;
    arb_t x;
    arb_init(x);
    arb_zero(g->bend);
    for (slong i = 0; i < n; i++) {
        arb_mul(x, g->w + i, g->w + i, e->prec);
        arb_mul(x, x, e->square + i, e->prec);
        arb_addmul(x, g->w + n + i, g->w + n + i, e->prec);
        arb_sqrtpos(x, x, e->prec);
        arb_mul(x, x, e->omega + i, e->prec);
        arb_mul(x, x, g->c + i, e->prec);
        arb_abs(x, x);
        arb_add(g->bend, g->bend, x, e->prec);
    }
    ric_chain_norm(n, g->c, e->prec, g->slack);
    ric_chain_norm(2 * n, g->w, e->prec, x);
    arb_mul(g->slack, g->slack, x, e->prec);
    arb_mul(g->slack, g->slack, slack, e->prec);
    arb_add(g->bend, g->bend, g->slack, e->prec);
    arb_clear(x);
}

/* A face, or its image under x -> -x, over the flight of length tau that begins at w. */
static void gap_place(gap *g, const ric_wall *wall, bool image, arb_srcptr w, const arb_t slack)
{
    g->w = w;
    g->c = ric_enclosure_c(g->e, wall->contact);
    g->side = image ? -wall->side : wall->side;
    arb_set(g->d, wall->gap);
    if (wall->side < 0) arb_neg(g->d, g->d);
    gap_bend(g, slack);
}

/* side c.x [n]. */
static void gap_along(const gap *g, arb_srcptr x, arb_t out)
{
    arb_dot(out, NULL, 0, g->c, 1, x, 1, g->e->n, g->e->prec);
    if (g->side < 0) arb_neg(out, out);
}

/* Whether h > 0 on [from, to]: h(mid) - |h'(mid)| r - bend r^2 / 2 > 0 on parts of length 2 r. */
static bool is_open(const gap *g, const arb_t from, const arb_t to, int depth)
{
    const slong prec = g->e->prec;
    arb_t mid, r, h, x;
    arb_init(mid);
    arb_init(r);
    arb_init(h);
    arb_init(x);
    arb_add(mid, from, to, prec);
    arb_mul_2exp_si(mid, mid, -1);
    arb_get_mid_arb(mid, mid);
    arb_sub(r, to, mid, prec);
    arb_sub(x, mid, from, prec);
    arb_max(r, r, x, prec);
    ric_chain_fly(g->e, g->w, mid, g->flown);
    gap_along(g, g->flown, h);
    arb_sub(h, g->d, h, prec);
    gap_along(g, g->flown + g->e->n, x);
    arb_add_error(h, g->slack);
    arb_add_error(x, g->slack);
    arb_abs(x, x);
    arb_submul(h, x, r, prec);
    arb_mul(x, r, r, prec);
    arb_mul(x, x, g->bend, prec);
    arb_mul_2exp_si(x, x, -1);
    arb_sub(h, h, x, prec);
    bool open = arb_is_positive(h);
    if (!open && depth < DEEPEST) open = is_open(g, from, mid, depth + 1) && is_open(g, mid, to, depth + 1);
    arb_clear(mid);
    arb_clear(r);
    arb_clear(h);
    arb_clear(x);
    return open;
}

/* Whether the flight begins, or ends, with an impact on this very face; its image is another one. */
static bool is_at(const gap *g, const ric_enclosure *e, int face)
{
    return face >= 0 && ric_enclosure_c(e, e->wall[face].contact) == g->c && e->wall[face].side == g->side;
}

/* The time for which a gap that opens with the speed is open for sure; all the flight if nothing draws it back. */
static void opening_time(const gap *g, const arb_t speed, const arb_t tau, arb_t out)
{
    if (arb_is_zero(g->bend)) arb_set(out, tau);
    else arb_div(out, speed, g->bend, g->e->prec);
    arb_get_lbound_arf(arb_midref(out), out, g->e->prec);
    mag_zero(arb_radref(out));
}

/* The gap over one flight from face `from` to face `to`, w behind it (before the impact). */
static bool stays_open(const gap *g, int from, int to, arb_srcptr w, const arb_t tau)
{
    const ric_enclosure *e = g->e;
    arb_t first, last, x, speed;
    arb_init(first);
    arb_init(last);
    arb_init(x);
    arb_init(speed);
    bool opens = true;
    arb_set(last, tau);
    if (is_at(g, e, from)) {
        gap_along(g, g->w + e->n, speed);
        arb_neg(speed, speed);
        opens = arb_is_positive(speed);
        if (opens) opening_time(g, speed, tau, first);
    }
    if (opens && is_at(g, e, to)) {
        gap_along(g, w + e->n, speed);
        arb_add_error(speed, g->slack);
        opens = arb_is_positive(speed);
        if (opens) opening_time(g, speed, tau, x);
        if (opens) arb_sub(last, last, x, e->prec);
    }
    if (opens && !arb_ge(first, last)) opens = is_open(g, first, last, 0);
    arb_clear(first);
    arb_clear(last);
    arb_clear(x);
    arb_clear(speed);
    return opens;
}

/* The speed into `face` with the velocities p before the impact; false if it is not positive. */
static bool approaches(ric_passage *p, const ric_enclosure *e, int face, arb_srcptr velocities, const arb_t error)
{
    arb_t speed;
    arb_init(speed);
    ric_chain_along(e, face, velocities, speed);
    if (e->wall[face].side < 0) arb_neg(speed, speed);
    arb_add_error(speed, error);
    const bool positive = arb_is_positive(speed);
    arb_get_lbound_arf(arb_midref(speed), speed, e->prec);
    mag_zero(arb_radref(speed));
    arb_min(p->approach, p->approach, speed, e->prec);
    arb_clear(speed);
    return positive;
}

/* The impact that a chain begins with, from the velocities behind it, turned. */
static bool begins_with_approach(ric_passage *p, const ric_chain *c, const ric_enclosure *e, arb_srcptr u)
{
    if (c->face[0] < 0) return true;
    arb_ptr back = _arb_vec_init(e->n);
    arb_t zero;
    arb_init(zero);
    _arb_vec_neg(back, u + e->n, e->n);
    const bool positive = approaches(p, e, c->face[0], back, zero);
    _arb_vec_clear(back, e->n);
    arb_clear(zero);
    return positive;
}

static bool flight_stands(ric_passage *p, const ric_chain *c, gap *g, int k, arb_srcptr w, arb_ptr flown)
{
    const ric_enclosure *e = g->e;
    arb_srcptr tau = w + 2 * c->n;
    arb_t slack;
    arb_init(slack);
    ric_enclosure_slack(e, tau, slack);
    ric_chain_fly(e, w, tau, flown);
    snprintf(p->why, sizeof p->why, "flight %d does not last", k + 1);
    bool stands = arb_is_positive(tau);
    for (int f = 0; f < e->n_face && stands; f++)
        for (int image = 0; image <= ric_chain_imaged(c) && stands; image++) {
            gap_place(g, &e->wall[f], image, w, slack);
            snprintf(p->why, sizeof p->why, "face %d%s is not proved to stay open in flight %d", f,
                     image ? ", or its image," : "", k + 1);
            stands = stays_open(g, c->face[k], c->face[k + 1], flown, tau);
        }
    if (stands && c->face[k + 1] >= 0) {
        snprintf(p->why, sizeof p->why, "the impact behind flight %d is not proved to approach", k + 1);
        gap_place(g, &e->wall[c->face[k + 1]], false, w, slack);
        stands = approaches(p, e, c->face[k + 1], flown + c->n, g->slack);
    }
    arb_clear(slack);
    return stands;
}

void ric_passage_init(ric_passage *p)
{
    *p = (ric_passage){.done = false};
    arb_init(p->approach);
    arb_pos_inf(p->approach);
}

void ric_passage_clear(ric_passage *p)
{
    arb_clear(p->approach);
}

bool ric_passage_prove(ric_passage *p, const ric_chain *c, const ric_enclosure *e, arb_srcptr u)
{
    gap g;
    gap_init(&g, e);
    arb_ptr flown = _arb_vec_init(2 * c->n);
    snprintf(p->why, sizeof p->why, "the first impact is not proved to approach");
    p->done = begins_with_approach(p, c, e, u);
    for (int k = 0; k < c->m && p->done; k++) p->done = flight_stands(p, c, &g, k, u + (slong)k * c->size, flown);
    _arb_vec_clear(flown, 2 * c->n);
    gap_clear(&g);
    return p->done;
}
