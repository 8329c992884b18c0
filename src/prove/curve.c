#include "curve.h"

#include <math.h>
#include <stdio.h>

#include "base/room.h"
#include "existence.h"
#include "monodromy.h"
#include "prover.h"

enum {
    LEAST = -22,    /* 2^-22 of a step: where two branches meet, or a gap closes */
    MOST = 1500,    /* tubes of a step that are not proved: some tens are where they get shorter
                       towards    an end, and any number where nothing is gained by that */
    TUBE = 1000000, /* multiplications of one, about */
    NEARER = 4,     /* a quarter of its share of what is left: what an orbit between is nearer by */
    FINEST = 128,   /* parts of a tube for its certificate */
    MANY_PARTS = 7, /* halvings of a tube for its stability: of two modes */
    FEW_PARTS = 5   /* of more, where it is dear */
};

/* The root of the contraction that a tube is to have. It grows with the length, and with its square
 * or cube where the bend of the arc asks for a wide box; one that failed has boxes that were made
 * larger, too. SHORTER: than that at most. */
#define GOAL 0.45
#define SHORTER 0.0625
/* Where gaps, and no roots, say how long a tube may be: the share that the next one has, and what
 * each behind it may be longer. */
#define BACK 0.6
#define ON 1.1
/* Roots that grow from tube to tube go on to do so, but for the next one to no more than that. */
#define TREND 0.25

/* Of lines between orbits of a certificate: a checker halves them some four times, which takes it
 * as long as as many orbits would. */
#define STRAIN 2.

/* -------------------------------------------------------------------- nodes */

void ric_curve_node_init(ric_node *a)
{
    *a = (ric_node){.why = "it has no chain"};
    arb_init(a->exists);
}

void ric_curve_node_clear(ric_node *a)
{
    if (a->last) _arb_vec_clear(a->last, (slong)a->c.m * a->c.size + 1);
    a->last = NULL;
    flint_free(a->tangent);
    a->tangent = NULL;
    ric_chain_free(&a->c);
    arb_clear(a->exists);
}

static void take_proof(ric_node *a, ric_existence *x, const char *why)
{
    a->why = why;
    a->way = x->way;
    arb_set(a->exists, x->exists);
    a->tangent = x->tangent;
    x->tangent = NULL;
}

void ric_curve_node_prove(ric_node *a, const ric_enclosure *e)
{
    ric_existence x;
    ric_existence_init(&x);
    take_proof(a, &x, ric_existence_prove(&x, &a->c, e));
    if (!a->why && !x.identified) a->why = "another orbit may lie as near: a junction";
    if (!a->why && !(x.moved <= RIC_PROVER_NEAR) && !(x.shift <= x.blur))
        a->why = "the orbit that was proved lies elsewhere";
    a->unique = a->why ? 0 : arf_get_d(arb_midref(x.unique), ARF_RND_FLOOR);
    ric_existence_clear(&x);
}

void ric_curve_node_place(ric_node *a, const ric_chain *like, arb_srcptr u, bool last,
                          const ric_enclosure *e)
{
    const slong count = (slong)like->m * like->size + 1;
    arb_t radius;
    arb_init(radius);
    ric_chain_copy(&a->c, like);
    arb_zero(a->exists);
    for (slong i = 0; i < count; i++) {
        arb_get_mid_arb(a->c.u + i, u + i);
        arf_set_mag(arb_midref(radius), arb_radref(u + i));
        arb_add(a->exists, a->exists, radius, e->prec);
    }
    arb_get_ubound_arf(arb_midref(a->exists), a->exists, e->prec);
    mag_zero(arb_radref(a->exists));
    if (last) {
        a->last = _arb_vec_init(count);
        _arb_vec_set(a->last, u, count);
    }
    a->why = NULL;
    arb_clear(radius);
}

/* out += weight times what the curve is beside its chord at an end, over s (1 - s): its slope there
 * less the chord. The tangent, which is known, may point either way. */
static void add_bend(const ric_node *a, bool end, arb_srcptr chord, double weight, double *out)
{
    const slong count = (slong)a->c.m * a->c.size;
    double along = 0, length = 0;
    for (slong i = 0; i < count; i++) {
        const double way = ric_arb_middle(chord + i);
        along += way * a->tangent[i];
        length += way * way;
    }
    length = copysign(sqrt(length), along);
    for (slong i = 0; i < count; i++) {
        const double bend = length * a->tangent[i] - ric_arb_middle(chord + i);
        out[i] += end ? -weight * bend : weight * bend;
    }
}

/* A share of the way along the cubic that has the tangents of both, or the parabola with that of
 * one: off the curve by the fourth power of the chord, where the chord is by its square, from which
 * Newton's method need not come back if D is near to singular. */
static void place_between(ric_chain *c, const ric_node *a, const ric_node *b, double share,
                          slong prec)
{
    const slong count = (slong)c->m * c->size;
    arb_ptr chord = _arb_vec_init(count);
    double *bend = flint_calloc((size_t)count, sizeof *bend);
    arb_t x, at;
    arb_init(x);
    arb_init(at);
    arb_set_d(at, share);
    _arb_vec_sub(chord, b->c.u, a->c.u, count, prec);
    if (a->tangent) add_bend(a, false, chord, b->tangent ? 1 - share : 1, bend);
    if (b->tangent) add_bend(b, true, chord, a->tangent ? share : 1, bend);
    for (slong i = 0; i < count; i++) {
        arb_mul(chord + i, chord + i, at, prec);
        arb_add(c->u + i, a->c.u + i, chord + i, prec);
        arb_set_d(x, bend[i] * share * (1 - share));
        arb_add(c->u + i, c->u + i, x, prec);
        arb_get_mid_arb(c->u + i, c->u + i);
    }
    _arb_vec_clear(chord, count);
    flint_free(bend);
    arb_clear(x);
    arb_clear(at);
}

/* The orbit near a share of the way from one to another; it is solved from there, so that it may be
 * moved by more than a stored one. Where it took one of both more than doubles to tell, so it does
 * there. */
static void node_between(ric_node *m, const ric_node *a, const ric_node *b, double share,
                         const ric_enclosure *e)
{
    ric_existence x;
    ric_existence_init(&x);
    ric_chain_copy(&m->c, &a->c);
    place_between(&m->c, a, b, share, e->prec);
    x.way = a->way > b->way ? a->way : b->way;
    take_proof(m, &x, ric_existence_find(&x, &m->c, e));
    ric_existence_clear(&x);
}

/* -------------------------------------------------------------------- tubes */

static double size_of(const ric_tube *t)
{
    arb_t x;
    arb_init(x);
    ric_chain_norm(t->k.n, t->chord, t->k.prec, x);
    const double size = arf_get_d(arb_midref(x), ARF_RND_NEAR);
    arb_clear(x);
    return size;
}

/* What multipliers say of a part of a tube; of two modes also the trace along it. */
static ric_stability judge(const ric_curve *x, const ric_tube *t, double from, double to,
                           ric_line *along)
{
    const slong count = (slong)t->hull.m * t->hull.size + 1;
    ric_monodromy multipliers;
    arb_ptr middle = _arb_vec_init(count), half = _arb_vec_init(count);
    ric_monodromy_init(&multipliers);
    ric_tube_line(t, from, to, middle, half);
    ric_monodromy_judge(&multipliers, &t->hull, x->e, &(ric_monodromy_line){middle, half});
    const ric_stability stable = multipliers.stable;
    *along = multipliers.along;
    ric_monodromy_clear(&multipliers);
    _arb_vec_clear(middle, count);
    _arb_vec_clear(half, count);
    return stable;
}

/* Whether halves of a part on which nothing is told say more than it does: nothing is told of its
 * middle alone where multipliers are on the unit circle, and as near as those balls are wide. Of
 * two modes one passes from stable to unstable somewhere else, unless the trace is nowhere on the
 * part farther from 2 or -2 than it is known. */
static bool halves_tell(const ric_curve *x, const ric_tube *t, double mid, ric_line along)
{
    ric_line there;
    if (judge(x, t, mid, mid, &there) != RIC_STABLE_UNDECIDED) return true;
    return x->e->n == 2 && !(fabs(fabs(along.m) - 2) + fabs(along.g) <= there.r);
}

/* From s = at on; where that is nothing, along its halves. */
static void judge_part(ric_curve *x, const ric_tube *t, double at, double part, int depth)
{
    ric_line along;
    const ric_stability stable = judge(x, t, at, at + part, &along);
    if (stable != RIC_STABLE_UNDECIDED || depth == 0 || ric_halt(TUBE) ||
        !halves_tell(x, t, at + part / 2, along))
        x->length[stable] += part * size_of(t);
    else
        for (int half = 0; half < 2; half++)
            judge_part(x, t, at + half * part / 2, part / 2, depth - 1);
}

/* All of the arc are motions, but for its end where that is `last`: gaps, and what multipliers say.
 */
static bool tube_stands(ric_curve *x, const ric_tube *t, arb_srcptr last)
{
    const slong count = (slong)t->hull.m * t->hull.size + 1;
    arb_ptr slope = _arb_vec_init(count);
    const ric_arrival arrival = {slope, last};
    if (last) ric_tube_slope(t, x->e, slope);
    ric_passage passage;
    ric_passage_init(&passage);
    const bool stands = ric_passage_prove(&passage, &t->hull, x->e,
                                          &(ric_family){.hull = t->hull.u,
                                                        .middle = t->middle,
                                                        .half = t->half,
                                                        .arrival = last ? &arrival : NULL});
    snprintf(x->why, sizeof x->why, "%s", passage.why);
    if (stands) {
        judge_part(x, t, 0, 1, x->e->n > 2 ? FEW_PARTS : MANY_PARTS);
        x->approach = fmin(x->approach, arf_get_d(arb_midref(passage.approach), ARF_RND_FLOOR));
        x->tubes++;
    }
    ric_passage_clear(&passage);
    _arb_vec_clear(slope, count);
    return stands;
}

static bool lies_in(const ric_tube *t, const ric_node *m)
{
    bool inside = true;
    for (slong i = 0; i < (slong)m->c.m * m->c.size && inside; i++)
        inside = arb_contains(t->hull.u + i, m->c.u + i);
    return inside;
}

/* What is between two orbits of a tube, b itself left out, so that there are `parts` lines: a
 * checker that bounds all number by number needs shorter ones. */
static void record_between(ric_curve *x, const ric_tube *t, const ric_node *a, const ric_node *b,
                           int parts)
{
    if (parts < 2) return;
    const int first = parts / 2;
    ric_node m;
    ric_curve_node_init(&m);
    node_between(&m, a, b, (double)first / parts, x->e);
    if (!m.why && m.c.number >= 0 && lies_in(t, &m)) {
        record_between(x, t, a, &m, first);
        ric_certificate_arcs_add(x->arcs, &m.c, x->e, m.exists);
        record_between(x, t, &m, b, parts - first);
    }
    ric_curve_node_clear(&m);
}

/* In the certificate are orbits that hold a number: those of junctions do not. */
static void record(ric_curve *x, const ric_tube *t, const ric_node *a, const ric_node *b)
{
    if (!x->arcs || a->last || b->last) return;
    if (!x->arcs->open && a->c.number >= 0)
        ric_certificate_arcs_add(x->arcs, &a->c, x->e, a->exists);
    const double strain = ric_tube_strain(t, x->e);
    const int parts = strain > STRAIN ? (int)fmin(ceil(strain / STRAIN), FINEST) : 1;
    if (x->arcs->open && b->c.number >= 0) record_between(x, t, a, b, parts);
    if (b->c.number >= 0) ric_certificate_arcs_add(x->arcs, &b->c, x->e, b->exists);
}

/* What came of a tube; one that does not stand is an arc, but not all of it is told to be motions.
 */
typedef struct {
    enum { JOINED, NO_ARC, NO_MOTIONS } end;
    double length, root; /* of the contraction, which is about as the length */
} outcome;

static outcome join_by_one(ric_curve *x, const ric_node *a, const ric_node *b)
{
    ric_tube t;
    snprintf(x->why, sizeof x->why, "the arc between two orbits is not proved to be one");
    bool done = ric_tube_create(&t, (ric_tube_end){&a->c, a->exists},
                                (ric_tube_end){&b->c, b->exists}, x->e);
    outcome out = {NO_ARC, size_of(&t), ric_contraction_root(t.k.n, t.k.Z)};
    if (done) {
        snprintf(x->why, sizeof x->why, "tubes are not proved to meet");
        done = ric_tube_holds(&t);
    }
    if (done) out.end = tube_stands(x, &t, b->last) ? JOINED : NO_MOTIONS;
    if (out.end == JOINED) record(x, &t, a, b);
    ric_tube_free(&t);
    return out;
}

/* How long tubes are taken to be: what the root of one says of the next one, and no more than
 * `most` while gaps ask for shorter ones. */
typedef struct {
    double length, most;
    int failed; /* in a row */
} stride;

static void step_on(stride *s, outcome tube)
{
    const double before = s->failed ? HUGE_VAL : s->length,
                 next = tube.root > 0 ? tube.length * cbrt(GOAL / tube.root) : HUGE_VAL;
    s->length = next < before && isfinite(before) ? next * fmax(TREND, next / before) : next;
    s->most *= ON;
    s->failed = 0;
}

/* Near an orbit where D is singular roots hardly fall with the length until it is much shorter. */
static void step_back(stride *s, outcome tube)
{
    s->failed++;
    if (tube.end == NO_MOTIONS) {
        s->most = tube.length * BACK;
        return;
    }
    const double share = fmin(ldexp(1, -s->failed), sqrt(GOAL / tube.root));
    s->length = tube.length * (share > SHORTER ? share : SHORTER);
}

/* The share of what is left that the next tube takes: one of a number that are alike. */
static double share_of(const stride *s, double left)
{
    const double length = fmin(s->length, s->most);
    return length < left ? 1 / ceil(left / length) : 1;
}

static double distance(const ric_node *a, const ric_node *b)
{
    double sum = 0;
    for (slong i = 0; i < (slong)a->c.m * a->c.size; i++)
        sum += pow(ric_arb_middle(b->c.u + i) - ric_arb_middle(a->c.u + i), 2);
    return sqrt(sum);
}

/* From orbit to orbit, tube by tube. */
static bool join(ric_curve *x, const ric_node *a, const ric_node *b)
{
    ric_node between[2];
    const ric_node *from = a;
    const double least = ldexp(distance(a, b), LEAST);
    stride s = {HUGE_VAL, HUGE_VAL, 0};
    bool done = false, lost = false;
    for (int i = 0; i < 2; i++) ric_curve_node_init(&between[i]);
    while (!done && !lost && !ric_halt(TUBE)) {
        const double left = distance(from, b), share = share_of(&s, left);
        ric_node *m = from == &between[0] ? &between[1] : &between[0];
        if (share < 1) {
            ric_curve_node_clear(m);
            ric_curve_node_init(m);
            node_between(m, from, b, share, x->e);
            if (!m->why && !(distance(m, b) < left * (1 - share / NEARER)))
                m->why = "the one that is found is no nearer";
            if (m->why) snprintf(x->why, sizeof x->why, "between two orbits: %s", m->why);
        }
        const ric_node *to = share < 1 ? m : b;
        const outcome tube = to->why ? (outcome){NO_MOTIONS, share * left, 0}
                                     : join_by_one(x, from, to);
        if (tube.end == JOINED) {
            step_on(&s, tube);
            done = to == b;
            from = to;
        } else {
            step_back(&s, tube);
            lost = ++x->tried > MOST || !(fmin(s.length, s.most) > least);
        }
    }
    for (int i = 0; i < 2; i++) ric_curve_node_clear(&between[i]);
    return done;
}

/* Two stored points of one orbit: they hold the same number at the same value, and that of b lies
 * where a is alone. */
static bool is_one_orbit(const ric_curve *x, const ric_node *a, const ric_node *b)
{
    const ric_chain *c = &a->c, *d = &b->c;
    if (c->number < 0 || c->number != d->number || c->at != d->at || !fmpz_equal(c->held, d->held))
        return false;
    const slong count = (slong)c->m * c->size;
    arb_ptr way = _arb_vec_init(count);
    arb_t far, unique;
    arb_init(far);
    arb_init(unique);
    _arb_vec_sub(way, c->u, d->u, count, x->e->prec);
    ric_chain_norm(count, way, x->e->prec, far);
    arb_add(far, far, b->exists, x->e->prec);
    arb_set_d(unique, a->unique);
    const bool one = arb_lt(far, unique);
    arb_clear(far);
    arb_clear(unique);
    _arb_vec_clear(way, count);
    return one;
}

bool ric_curve_join(ric_curve *x, const ric_node *a, const ric_node *b)
{
    x->tried = 0;
    if (!ric_chain_same_class(&a->c, &b->c)) return false;
    if (is_one_orbit(x, a, b)) return true;
    return a->last ? !b->last && join(x, b, a) : join(x, a, b);
}
