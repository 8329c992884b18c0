#include "passage.h"

#include <stdio.h>

#include "base/room.h"
#include "equations.h"
#include "glide.h"

enum {
    DEEPEST = 32, /* bisections of a flight: a gap that is not told from closed then touches */
    PART = 100,   /* multiplications of a part and mode, about */
    READINGS =
        16, /* times of a flight whose states are kept: faces are asked about the same ones */
};

/* What a flight has at a time, whatever the face: q, p and L q. */
typedef struct {
    arb_t time;
    arb_ptr at; /* [3n] */
} reading;

/* A gap along a flight: h = d - side c.q, in the modes of its phase; of a closed spring how far it
 * is pressed in, which is the same with the other signs. */
typedef struct {
    const ric_enclosure *e;     /* of the structure */
    const ric_enclosure *modes; /* of the phase */
    const ric_phase *phase;
    arb_ptr own;             /* [4 * 2n] what follows, in the modes of the phase */
    arb_srcptr w;            /* [2n] at the beginning */
    arb_srcptr middle, half; /* of an arc, from there on; or w, NULL */
    ric_glide glide;         /* of an arc, in doubles */
    int contact, facing;     /* of the face, and its side */
    arb_srcptr c;            /* normal */
    int side;
    bool slow;        /* impacts may be of exactly no speed: h'' > 0 opens the gap beside them */
    arb_srcptr slope; /* [2n] towards the end of the arc (ric_arrival), or NULL */
    arb_srcptr last;  /* the length of the flight there */
    bool mirrored;    /* the flight ends with a mirror point */
    arb_srcptr touch; /* a time at which h = h' = 0, or NULL */
    arb_t d;          /* clearance > 0 */
    arb_t open;       /* what the flight leaves open of the state and its derivatives */
    arb_t bend, jerk,
        slack; /* bounds of |h''|, |h'''|; of what flights leave open of h and its derivatives */
    arb_ptr flown;     /* [2n] scratch */
    arb_ptr swing;     /* [n] bounds of |q_i''| */
    reading *readings; /* [READINGS + 1] of this flight; the last one is not kept */
    int *n_reading;
} gap;

static void gap_init(gap *g, const ric_enclosure *e)
{
    *g = (gap){.e = e, .own = _arb_vec_init(8 * e->n), .flown = _arb_vec_init(2 * e->n)};
    g->swing = _arb_vec_init(e->n);
    ric_glide_create(&g->glide, e->n);
    g->readings = flint_calloc(READINGS + 1, sizeof *g->readings);
    g->n_reading = flint_calloc(1, sizeof *g->n_reading);
    for (int i = 0; i <= READINGS; i++) {
        arb_init(g->readings[i].time);
        g->readings[i].at = _arb_vec_init(3 * e->n);
    }
    arb_init(g->d);
    arb_init(g->open);
    arb_init(g->bend);
    arb_init(g->jerk);
    arb_init(g->slack);
}

static void gap_clear(gap *g)
{
    _arb_vec_clear(g->own, 8 * g->e->n);
    _arb_vec_clear(g->flown, 2 * g->e->n);
    _arb_vec_clear(g->swing, g->e->n);
    ric_glide_free(&g->glide);
    for (int i = 0; i <= READINGS; i++) {
        arb_clear(g->readings[i].time);
        _arb_vec_clear(g->readings[i].at, 3 * g->e->n);
    }
    flint_free(g->readings);
    flint_free(g->n_reading);
    arb_clear(g->d);
    arb_clear(g->open);
    arb_clear(g->bend);
    arb_clear(g->jerk);
    arb_clear(g->slack);
}

/* |q_i''| <= omega_i sqrt(omega_i^2 q_i^2 + p_i^2) in flight. */
static void find_swing(gap *g)
{
    const ric_enclosure *e = g->modes;
    const slong n = e->n;
    arb_t x;
    arb_init(x);
    for (slong i = 0; i < n; i++) {
        arb_mul(x, g->w + i, g->w + i, e->prec);
        arb_mul(x, x, e->square + i, e->prec);
        arb_addmul(x, g->w + n + i, g->w + n + i, e->prec);
        arb_sqrtpos(x, x, e->prec);
        arb_mul(g->swing + i, x, e->omega + i, e->prec);
    }
    arb_clear(x);
}

/* |h''| <= sum |c_i q_i''| + |c| slack |w|; h''' has an omega_i more. */
static void gap_bend(gap *g)
{
    const ric_enclosure *e = g->modes;
    slong n = e->n;
    arb_t x;
    arb_init(x);
    arb_zero(g->bend);
    arb_zero(g->jerk);
    for (slong i = 0; i < n; i++) {
        arb_mul(x, g->swing + i, g->c + i, e->prec);
        arb_abs(x, x);
        arb_add(g->bend, g->bend, x, e->prec);
        arb_addmul(g->jerk, x, e->omega + i, e->prec);
    }
    ric_chain_norm(n, g->c, e->prec, g->slack);
    arb_mul(g->slack, g->slack, g->open, e->prec);
    arb_add(g->bend, g->bend, g->slack, e->prec);
    arb_add(g->jerk, g->jerk, g->slack, e->prec);
    arb_clear(x);
}

static void gap_enter(gap *g)
{
    const slong n = g->e->n;
    arb_ptr w = g->own, middle = w + 2 * n, half = middle + 2 * n, slope = half + 2 * n;
    ric_phase_enter(g->phase, g->w, w);
    ric_phase_enter(g->phase, g->middle, middle);
    if (g->half) ric_phase_turn(g->phase, g->half, half);
    if (g->slope) ric_phase_turn(g->phase, g->slope, slope);
    g->w = w;
    g->middle = middle;
    g->half = g->half ? half : NULL;
    g->slope = g->slope ? slope : NULL;
}

/* d - side c.rest, with the other sign of a spring that is closed. */
static void gap_shift(gap *g, bool closed)
{
    const ric_enclosure *e = g->e;
    arb_t shift;
    arb_init(shift);
    arb_dot(shift, NULL, 0, ric_enclosure_c(e, g->contact), 1, g->phase->rest, 1, e->n, e->prec);
    if (g->side > 0) arb_neg(shift, shift);
    arb_add(g->d, g->d, shift, e->prec);
    if (closed) arb_neg(g->d, g->d);
    if (closed) g->side = -g->side;
    arb_clear(shift);
}

/* Flight k of a chain, whatever the face. */
static void gap_board(gap *g, const ric_chain *c, int k, const ric_family *u)
{
    const slong at = (slong)k * c->size;
    arb_t size;
    arb_init(size);
    g->phase = c->phase[k];
    g->modes = ric_phase_enclosure(g->phase, g->e);
    g->w = u->hull + at;
    g->middle = u->middle ? u->middle + at : g->w;
    g->half = u->half ? u->half + at : NULL;
    g->slope = u->arrival ? u->arrival->slope + at : NULL;
    if (g->phase) gap_enter(g);
    if (g->half) ric_glide_board(&g->glide, g->modes, g->w, g->middle, g->half);
    find_swing(g);
    *g->n_reading = 0;
    g->slow = u->half || u->touch;
    g->last = u->arrival ? u->arrival->last + at + 2 * c->n : NULL;
    g->mirrored = c->face[k + 1] < 0;
    ric_enclosure_slack(g->modes, u->hull + at + 2 * c->n, g->open);
    ric_chain_norm(2 * c->n, g->w, g->e->prec, size);
    arb_mul(g->open, g->open, size, g->e->prec);
    arb_clear(size);
}

/* A face, or its image under x -> -x, over that flight. */
static void gap_place(gap *g, int face, bool image)
{
    const ric_wall *wall = &g->e->wall[face];
    g->contact = wall->contact;
    g->c = ric_enclosure_c(g->modes, wall->contact);
    g->facing = g->side = image ? -wall->side : wall->side;
    g->touch = NULL;
    arb_set(g->d, wall->gap);
    if (wall->side < 0) arb_neg(g->d, g->d);
    if (g->phase) gap_shift(g, ric_phase_closed(g->phase, image ? wall->mirror : face));
    gap_bend(g);
    if (g->half) ric_glide_place(&g->glide, g->c, g->side, g->d, g->slack);
}

/* side c.x [n]. */
static void gap_along(const gap *g, arb_srcptr x, arb_t out)
{
    arb_dot(out, NULL, 0, g->c, 1, x, 1, g->e->n, g->e->prec);
    if (g->side < 0) arb_neg(out, out);
}

/* A part of a flight, at the ends of which the gap may be closed by an impact, or the motion be at
 * rest. */
typedef struct {
    arb_srcptr from, to;
    bool opens, closes;
    bool rests[2];
    bool still[2]; /* what opens, or closes, has exactly no speed there */
} part;

/* The flight at a time, exact. */
static arb_srcptr read_at(const gap *g, const arb_t time)
{
    const ric_enclosure *e = g->modes;
    const slong n = e->n;
    for (int i = 0; i < *g->n_reading; i++)
        if (arb_equal(g->readings[i].time, time)) return g->readings[i].at;
    reading *fresh = &g->readings[*g->n_reading];
    *g->n_reading += *g->n_reading < READINGS;
    arb_set(fresh->time, time);
    ric_chain_fly(e, NULL, g->w, time, fresh->at);
    for (slong i = 0; i < n; i++)
        arb_mul(fresh->at + 2 * n + i, fresh->at + i, e->square + i, e->prec);
    return fresh->at;
}

/* On a part of length 2 r, of one orbit: no more than h, h' and h''; the parts that a normal takes
 * of q, p and -L q in its middle, and what they change by. */
static void look(const gap *g, const arb_t mid, const arb_t r, arb_ptr h)
{
    const slong n = g->e->n, prec = g->e->prec;
    arb_srcptr at = read_at(g, mid);
    arb_t x;
    arb_init(x);
    for (int k = 0; k < 3; k++) gap_along(g, at + k * n, h + k);
    arb_sub(h, g->d, h, g->modes->prec);
    arb_neg(h + 1, h + 1);
    for (int k = 0; k < 3; k++) arb_add_error(h + k, g->slack);
    arb_abs(x, h + 1);
    arb_submul(h, x, r, prec);
    arb_mul(x, g->bend, r, prec);
    arb_add_error(h + 1, x);
    arb_mul(x, x, r, prec);
    arb_mul_2exp_si(x, x, -1);
    arb_sub(h, h, x, prec);
    arb_mul(x, g->jerk, r, prec);
    arb_add_error(h + 2, x);
    arb_clear(x);
}

static void set_ball(arb_t to, ric_ball x)
{
    arb_set_d(to, x.m);
    mag_set_d(arb_radref(to), x.r);
}

/* The same of an arc. */
static void look_along(gap *g, const arb_t mid, const arb_t r, arb_ptr h)
{
    const ric_glide_part here = ric_glide_look(&g->glide, mid, r);
    arb_set_d(h, here.least);
    set_ball(h + 1, here.rate);
    set_ball(h + 2, here.bend);
}

/* h > 0 on a part of length 2 r as it is no less than h(mid) - |h'(mid)| r - bend r^2 / 2. Behind
 * an impact, where h is zero and h' is not negative whatever else is open of the states, also as h'
 * > 0, and before one as h' < 0; along an arc, or where an impact is a touch, as h'' > 0, too: of
 * any other orbit whose impacts are that slow rounding would decide. Around a touch in flight h'' >
 * 0 closes it there alone. All of a contact, or what is left of it from a place at rest on, where
 * h' = 0, has h > 0 as h'' < 0, however short it is. */
static bool part_is_open(gap *g, const part *p, const arb_t mid, const arb_t r)
{
    arb_ptr h = _arb_vec_init(3);
    if (g->half) look_along(g, mid, r, h);
    else look(g, mid, r, h);
    const bool one = p->opens != p->closes;
    const bool touches = g->touch && arb_le(p->from, g->touch) && arb_le(g->touch, p->to);
    const bool whole = (p->opens && p->closes) || (p->rests[0] && p->closes) ||
                       (p->opens && p->rests[1]);
    const bool open = arb_is_positive(h) || (whole && arb_is_negative(h + 2)) ||
                      (((one && (g->slow || p->still[p->closes])) || touches) &&
                       arb_is_positive(h + 2)) ||
                      (one && p->opens && arb_is_positive(h + 1)) ||
                      (one && p->closes && arb_is_negative(h + 1));
    _arb_vec_clear(h, 3);
    return open;
}

/* Whether h falls along the arc at all times of a part that its end has, too: its flight goes on as
 * long again behind a mirror point. */
static bool part_falls(const gap *g, const part *p, const arb_t mid, const arb_t r)
{
    const ric_enclosure *e = g->modes;
    if (!g->slope) return false;
    arb_t time, rate, error;
    arb_init(time);
    arb_mul_2exp_si(time, g->last, g->mirrored);
    if (!arb_le(p->to, time)) {
        arb_clear(time);
        return false;
    }
    arb_init(rate);
    arb_init(error);
    arb_set(time, mid);
    arb_add_error(time, r);
    ric_chain_fly(e, NULL, g->slope, time, g->flown);
    gap_along(g, g->flown, rate);
    ric_enclosure_slack(e, g->last, error);
    ric_chain_norm(2 * e->n, g->slope, e->prec, time);
    arb_mul(error, error, time, e->prec);
    ric_chain_norm(e->n, g->c, e->prec, time);
    arb_mul(error, error, time, e->prec);
    arb_add_error(rate, error);
    const bool falls = arb_is_positive(rate); /* h = d - side c.q */
    arb_clear(time);
    arb_clear(rate);
    arb_clear(error);
    return falls;
}

static bool is_open(gap *g, part p, int depth)
{
    const slong prec = g->e->prec;
    arb_t mid, r, x;
    arb_init(mid);
    arb_init(r);
    arb_init(x);
    arb_add(mid, p.from, p.to, prec);
    arb_mul_2exp_si(mid, mid, -1);
    arb_get_mid_arb(mid, mid);
    arb_sub(r, p.to, mid, prec);
    arb_sub(x, mid, p.from, prec);
    arb_max(r, r, x, prec);
    const bool open =
        part_is_open(g, &p, mid, r) || part_falls(g, &p, mid, r) ||
        (depth < DEEPEST && !ric_halt(PART * (double)g->e->n) &&
         is_open(g, (part){p.from, mid, p.opens, false, {p.rests[0], false}, {p.still[0], false}},
                 depth + 1) &&
         is_open(g, (part){mid, p.to, false, p.closes, {false, p.rests[1]}, {false, p.still[1]}},
                 depth + 1));
    arb_clear(mid);
    arb_clear(r);
    arb_clear(x);
    return open;
}

/* Whether the flight begins, or ends, with an event on this very face; its image is another one. */
static bool is_at(const gap *g, const ric_enclosure *e, int face)
{
    return face >= 0 && e->wall[face].contact == g->contact && e->wall[face].side == g->facing;
}

/* The same of a second contact that is closed at that instant. */
static const ric_closure *at_corner(const gap *g, const ric_corner *corner, int flight, bool end)
{
    for (int i = 0; corner && i < corner->n; i++) {
        const ric_closure *at = &corner->at[i];
        if (at->flight == flight && at->end == end && at->contact == g->contact &&
            at->side == g->facing)
            return at;
    }
    return NULL;
}

/* The gap over flight k. Where it touches at a mirror point the flight is longer by what is not
 * known of that time. */
static bool stays_open(gap *g, const ric_chain *c, int k, const arb_t tau, const ric_corner *corner)
{
    const int from = c->face[k], to = c->face[k + 1];
    const bool rests[2] = {k == 0 && c->start == RIC_CHAIN_REST,
                           k == c->m - 1 && c->end == RIC_CHAIN_REST};
    arb_t start, end, x;
    arb_init(start);
    arb_init(end);
    arb_init(x);
    arb_set(end, tau);
    if (g->touch && from < 0) {
        arb_get_lbound_arf(arb_midref(x), g->touch, g->e->prec);
        if (arb_is_negative(x)) arb_set(start, x);
    } else if (g->touch && to < 0) {
        arb_get_ubound_arf(arb_midref(x), g->touch, g->e->prec);
        arb_get_ubound_arf(arb_midref(end), tau, g->e->prec);
        mag_zero(arb_radref(end));
        arb_max(end, end, x, g->e->prec);
    }
    const bool own[2] = {is_at(g, g->e, from), is_at(g, g->e, to)};
    const ric_closure *first = at_corner(g, corner, k, false),
                      *last = at_corner(g, corner, k, true);
    const part all = {.from = start,
                      .to = end,
                      .opens = own[0] || first,
                      .closes = own[1] || last,
                      .rests = {rests[0], rests[1]},
                      .still = {!own[0] && first && first->still, !own[1] && last && last->still}};
    const bool open = is_open(g, all, 0);
    arb_clear(start);
    arb_clear(end);
    arb_clear(x);
    return open;
}

/* The speed of the event that block k begins with, or that the chain ends with (m), from velocities
 * before it, or any change of them: into a face, or out of a spring that opens. */
static void speed_of(const ric_chain *c, const ric_enclosure *e, int k, arb_srcptr velocities,
                     arb_t out)
{
    const int face = c->face[k];
    ric_chain_along(e, face, velocities, out);
    if ((e->wall[face].side < 0) != ric_chain_opens(c, e, k)) arb_neg(out, out);
}

/* Whether a speed is positive. Where it falls towards the end of an arc, `rate` with its error, it
 * is, and how large is not said. */
static bool approaches(ric_passage *p, const ric_enclosure *e, arb_t speed, arb_srcptr rate)
{
    const bool positive = arb_is_positive(speed);
    if (!positive && rate) return arb_is_negative(rate);
    arb_get_lbound_arf(arb_midref(speed), speed, e->prec);
    mag_zero(arb_radref(speed));
    arb_min(p->approach, p->approach, speed, e->prec);
    return positive;
}

static bool is_touch(const ric_chain *c, const ric_family *u, int block)
{
    if (!u->touch || u->touch->impact < 0) return false;
    return block == u->touch->impact ||
           (ric_chain_general(c) && block == c->m && u->touch->impact == 0);
}

/* The speed of the event that block k begins with, from velocities behind it, or any change of
 * them: an impact turns them. */
static void speed_behind(const ric_chain *c, const ric_enclosure *e, int k, arb_srcptr velocities,
                         arb_t out)
{
    speed_of(c, e, k, velocities, out);
    if (!e->wall[c->face[k]].closes) arb_neg(out, out);
}

/* That is linear in the unknowns: along an arc it is what it is in the middle, and what the line
 * changes of it. */
static bool block_approaches(ric_passage *p, const ric_chain *c, const ric_enclosure *e, int k,
                             const ric_family *u)
{
    const slong at = (slong)k * c->size + e->n;
    if (c->face[k] < 0 || is_touch(c, u, k)) return true;
    arb_t speed, rate;
    arb_init(speed);
    arb_init(rate);
    speed_behind(c, e, k, (u->middle ? u->middle : u->hull) + at, speed);
    if (u->half) speed_behind(c, e, k, u->half + at, rate);
    arb_add_error(speed, rate);
    if (u->arrival) speed_behind(c, e, k, u->arrival->slope + at, rate);
    const bool positive = approaches(p, e, speed, u->arrival ? rate : NULL);
    arb_clear(speed);
    arb_clear(rate);
    return positive;
}

/* How the speed of the impact that the chain ends with changes along `slope`: c . (F w + F' w tau)
 * of it, for all that the hull holds. */
static void find_rate(const ric_chain *c, const ric_enclosure *e, arb_srcptr hull, arb_srcptr slope,
                      arb_t out)
{
    const slong n = c->n, at = (slong)(c->m - 1) * c->size;
    const ric_phase *phase = c->phase[c->m - 1];
    arb_srcptr w = hull + at;
    arb_ptr flown = _arb_vec_init(2 * n), change = _arb_vec_init(n);
    arb_mat_t D;
    arb_t slack;
    arb_init(slack);
    arb_mat_init(D, 2 * n, 2 * n + 1);
    ric_equation_flight(e, phase, w, w + 2 * n, D, flown);
    ric_chain_slack(e, phase, w, w + 2 * n, slack);
    for (slong i = 0; i < n; i++) {
        for (slong j = 0; j <= 2 * n; j++) arb_add_error(arb_mat_entry(D, n + i, j), slack);
        arb_dot(change + i, NULL, 0, arb_mat_entry(D, n + i, 0), 1, slope + at, 1, 2 * n + 1,
                e->prec);
    }
    speed_of(c, e, c->m, change, out);
    arb_mat_clear(D);
    arb_clear(slack);
    _arb_vec_clear(flown, 2 * n);
    _arb_vec_clear(change, n);
}

/* The impact that a chain between mirror points ends with; g: of its last flight, and its face. */
static bool end_approaches(ric_passage *p, const ric_chain *c, const gap *g, const ric_family *u)
{
    const ric_enclosure *e = g->e;
    const slong n = c->n, at = (slong)(c->m - 1) * c->size;
    arb_srcptr w = (u->middle ? u->middle : u->hull) + at;
    arb_ptr flown = _arb_vec_init(2 * n);
    arb_t speed, rate;
    arb_init(speed);
    arb_init(rate);
    ric_chain_fly(e, c->phase[c->m - 1], w, w + 2 * n, flown);
    speed_of(c, e, c->m, flown + n, speed);
    arb_add_error(speed, g->slack);
    if (u->half) find_rate(c, e, u->hull, u->half, rate);
    arb_add_error(speed, rate);
    if (u->arrival) find_rate(c, e, u->hull, u->arrival->slope, rate);
    const bool positive = approaches(p, e, speed, u->arrival ? rate : NULL);
    arb_clear(speed);
    arb_clear(rate);
    _arb_vec_clear(flown, 2 * n);
    return positive;
}

/* A face is the image of another one of its contact. */
static bool touches_in(const gap *g, const ric_family *u, int flight)
{
    const ric_touch *t = u->touch;
    if (!t || t->impact >= 0 || t->flight != flight) return false;
    const ric_wall *wall = &g->e->wall[t->face];
    return (wall->contact == g->contact && (t->image ? -wall->side : wall->side) == g->facing) ||
           (t->together && t->together[g->contact] == g->facing);
}

/* Flight k lasts, passes no face, and ends with an approach. */
static bool flight_stands(ric_passage *p, const ric_chain *c, gap *g, int k, const ric_family *u)
{
    const ric_enclosure *e = g->e;
    const slong at = (slong)k * c->size;
    arb_srcptr tau = u->hull + at + 2 * c->n;
    snprintf(p->why, sizeof p->why, "flight %d does not last", k + 1);
    const bool empty = u->corner && u->corner->empty == k;
    bool stands = empty || arb_is_positive(tau) ||
                  (u->arrival && arb_is_negative(u->arrival->slope + at + 2 * c->n));
    gap_board(g, c, k, u);
    for (int f = 0; f < e->n_face && stands && !empty; f++)
        for (int image = 0; image <= ric_chain_imaged(c) && stands; image++) {
            gap_place(g, f, image);
            if (touches_in(g, u, k)) g->touch = u->touch->time;
            snprintf(p->why, sizeof p->why, "face %d%s is not proved to stay open in flight %d", f,
                     image ? ", or its image," : "", k + 1);
            stands = stays_open(g, c, k, tau, u->corner);
        }
    if (!stands) return false;
    snprintf(p->why, sizeof p->why, "the impact behind flight %d is not proved to approach", k + 1);
    if (k < c->m - 1) return block_approaches(p, c, e, k + 1, u);
    if (ric_chain_general(c) || c->face[k + 1] < 0 || is_touch(c, u, k + 1)) return true;
    gap_place(g, c->face[k + 1], false);
    return end_approaches(p, c, g, u);
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

bool ric_passage_prove(ric_passage *p, const ric_chain *c, const ric_enclosure *e,
                       const ric_family *u)
{
    gap g;
    gap_init(&g, e);
    snprintf(p->why, sizeof p->why, "the first impact is not proved to approach");
    p->done = block_approaches(p, c, e, 0, u);
    for (int k = 0; k < c->m && p->done; k++) p->done = flight_stands(p, c, &g, k, u);
    gap_clear(&g);
    return p->done;
}
