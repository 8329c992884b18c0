#include "tube.h"

#include <math.h>
#include <string.h>

#include "base/room.h"
#include "bends.h"

enum {
    TRIES = 5,  /* boxes */
    TIGHT = 8,  /* steps from the radii that are alone to those that hold the zeros */
    CLOSE = 32, /* .. */
    FEW = 3,    /* directions of the basis: of two modes */
    MANY = 4,   /* and of more */
};

/* DIGITS: the root of 1 - C J T beside which digits are not why no box holds */
#define DIGITS 0x1p-5

/* The unknowns of a chain in a row; lambda of a reversible one is none. */
static slong count_unknowns(const ric_chain *c)
{
    return (slong)c->m * c->size + ric_chain_general(c);
}

/* ---------------------------------------------------------------- equations */

/* J, the plane last, but for the slack of flights. */
static void evaluate(const ric_tube *t, const ric_chain *c, const ric_enclosure *e, arb_mat_t J)
{
    ric_equations q;
    ric_equation_create(&q, c);
    ric_equation_evaluate(&q, c, e);
    ric_equation_gather(&q, c, J, NULL);
    ric_equation_free(&q);
    _arb_vec_set(arb_mat_entry(J, t->k.n - 1, 0), t->row, t->k.n);
}

/* out [n] = D x on all of the hull. */
static void apply(const ric_tube *t, const ric_enclosure *e, arb_srcptr x, arb_ptr out)
{
    ric_equations q;
    ric_equation_create(&q, &t->hull);
    ric_equation_evaluate(&q, &t->hull, e);
    ric_equation_loosen(&q, &t->hull, e, NULL);
    ric_equation_apply(&q, &t->hull, x, e->prec, out);
    ric_equation_free(&q);
    arb_dot(out + t->k.n - 1, NULL, 0, t->row, 1, x, 1, t->k.n, e->prec);
}

/* --------------------------------------------------------------------- line */

static bool lay_line(ric_tube *t)
{
    double largest = 0;
    for (slong i = 0; i < t->k.n; i++) {
        arb_sub(t->chord + i, t->to->u + i, t->from->u + i, ARF_PREC_EXACT);
        largest = fmax(largest, fabs(ric_arb_middle(t->chord + i)));
    }
    if (!(largest > 0) || !isfinite(largest)) return false;
    _arb_vec_scalar_mul_2exp_si(t->row, t->chord, t->k.n, -ilogb(largest));
    arb_dot(t->length, NULL, 0, t->row, 1, t->chord, 1, t->k.n, t->k.prec);
    return true;
}

/* p(s), for a ball s. */
static void place(const ric_tube *t, const arb_t s, arb_ptr out)
{
    for (slong i = 0; i < t->k.n; i++) {
        arb_set(out + i, t->from->u + i);
        arb_addmul(out + i, t->chord + i, s, t->k.prec);
    }
}

void ric_tube_part(const ric_tube *t, double from, double to, arb_ptr out)
{
    arb_t s, end;
    arb_init(s);
    arb_init(end);
    arb_set_d(s, from);
    arb_set_d(end, to);
    arb_union(s, s, end, t->k.prec);
    place(t, s, out);
    for (slong i = 0; i < t->k.n; i++) arb_add_error_mag(out + i, t->spread + i);
    arb_clear(s);
    arb_clear(end);
}

/* s (1 - s) = at (1 - at) + (1 - 2 at) s' - s'^2 with s = at + s', and s'^2 is half of way^2 within
 * the other half. */
void ric_tube_line(const ric_tube *t, double from, double to, arb_ptr middle, arb_ptr half)
{
    const slong prec = t->k.prec;
    arb_ptr x = _arb_vec_init(5), at = x, way = x + 1, bend = x + 2, sag = x + 3, own = x + 4;
    arb_set_d(at, from);
    arb_set_d(way, to);
    arb_sub(way, way, at, ARF_PREC_EXACT);
    arb_mul_2exp_si(way, way, -1);
    arb_add(at, at, way, ARF_PREC_EXACT);
    place(t, at, middle);
    arb_mul(bend, way, way, prec);
    arb_mul_2exp_si(bend, bend, -1);
    arb_mul(sag, at, at, prec);
    arb_sub(sag, at, sag, prec);
    arb_sub(sag, sag, bend, prec);
    arb_mul_2exp_si(at, at, 1);
    arb_sub_ui(at, at, 1, prec);
    arb_mul(at, at, way, prec);
    for (slong i = 0; i < t->k.n; i++) {
        arb_addmul(middle + i, t->sag + i, sag, prec);
        arb_mul(own, t->sag + i, bend, prec);
        arb_add_error(middle + i, own);
        arb_add_error_mag(middle + i, t->rest + i);
        arb_mul(half + i, t->chord + i, way, prec);
        arb_submul(half + i, t->sag + i, at, prec);
    }
    _arb_vec_clear(x, 5);
}

/* All s, and the box around. */
static void place_hull(ric_tube *t)
{
    ric_skew_spread(&t->basis, t->k.b, t->spread);
    ric_tube_part(t, -RIC_TUBE_MORE, 1 + RIC_TUBE_MORE, t->hull.u);
}

/* ---------------------------------------------------------------- conditions */

/* y <- y + 2^exponent |C F|. */
static void add_defect(ric_tube *t, arb_srcptr F, slong exponent)
{
    const slong n = t->k.n;
    arb_ptr x = _arb_vec_init(n);
    mag_t size;
    mag_init(size);
    ric_contraction_apply(&t->k, F, x);
    for (slong i = 0; i < n; i++) {
        arb_get_mag(size, x + i);
        mag_mul_2exp_si(size, size, exponent);
        mag_add(t->k.y + i, t->k.y + i, size);
    }
    mag_clear(size);
    _arb_vec_clear(x, n);
}

static void evaluate_ends(ric_tube *t, const ric_enclosure *e)
{
    for (int end = 0; end < 2; end++) {
        const ric_chain *c = end ? t->to : t->from;
        ric_equations q;
        ric_equation_create(&q, c);
        ric_equation_values(&q, c, e);
        ric_equation_loosen(&q, c, e, NULL);
        ric_equation_gather(&q, c, NULL, t->ends + end * t->k.n);
        ric_equation_free(&q);
    }
}

/* y: C times what the equations are at both ends, */
static void bound_ends(ric_tube *t)
{
    const slong n = t->k.n;
    for (slong i = 0; i < n; i++) mag_zero(t->k.y + i);
    for (int end = 0; end < 2; end++)
        add_defect(t, t->ends + end * n, 1); /* interpolated: 1 + 2 RIC_TUBE_MORE times at most */
}

/* and C D^2 F (b - a)^2 times s (1 - s) / 2 <= 1 / 8, from D^2 F (b - a). */
static void bound_bend(ric_tube *t, const ric_bends *along)
{
    arb_ptr F = _arb_vec_init(t->k.n);
    ric_bends_apply(along, t->chord, F);
    add_defect(t, F, -3);
    _arb_vec_clear(F, t->k.n);
}

/* The orbit u at an end is on the plane of s = s0 + v.(u - centre) / (v.(b - a)), |s - s0| <= |v|
 * exists / length < MORE, and the box around p(s) holds it if radii = |T^-1| (exists + |s - s0| |b
 * - a|) < b. */
static bool reach_end(const ric_tube *t, arb_srcptr exists, mag_ptr radii)
{
    const slong n = t->k.n;
    mag_t away, x, radius;
    arb_t y;
    mag_init(away);
    mag_init(x);
    mag_init(radius);
    arb_init(y);
    ric_chain_norm(n, t->row, t->k.prec, y);
    arb_mul(y, y, exists, t->k.prec);
    arb_div(y, y, t->length, t->k.prec);
    arb_get_mag(away, y);
    arb_get_mag(radius, exists);
    mag_set_d_lower(x, RIC_TUBE_MORE);
    const bool near = mag_cmp(away, x) < 0;
    for (slong i = 0; i < n; i++) {
        arb_get_mag(x, t->chord + i);
        mag_mul(x, x, away);
        mag_add(radii + i, x, radius);
    }
    ric_skew_enter(&t->basis, radii, radii);
    mag_clear(away);
    mag_clear(x);
    mag_clear(radius);
    arb_clear(y);
    return near;
}

/* No radius is less than twice what the orbits at the ends need. */
static void floor_box(ric_tube *t)
{
    const slong n = t->k.n;
    mag_ptr radii = _mag_vec_init(n);
    for (slong i = 0; i < n; i++) mag_zero(t->k.b + i);
    for (int end = 0; end < 2; end++) {
        reach_end(t, t->exists[end], radii);
        for (slong i = 0; i < n; i++) {
            mag_mul_2exp_si(radii + i, radii + i, 1);
            mag_max(t->k.b + i, t->k.b + i, radii + i);
        }
    }
    _mag_vec_clear(radii, n);
}

/* C and the basis from J in the middle, which becomes J T, in doubles; and Z, what is left of 1 - C
 * J T. */
static bool invert(ric_tube *t, arb_mat_t J)
{
    ric_contraction *k = &t->k;
    if (!ric_contraction_invert_quickly(k, J)) return false;
    for (int i = 0; i < (t->hull.n > 2 ? MANY : FEW); i++) ric_skew_find(&t->basis, k);
    ric_skew_columns(&t->basis, J, k->prec);
    ric_contraction_defect(k, J);
    if (ric_contraction_is_fine(k)) return true;
    const bool done = ric_contraction_invert_quickly(k, J);
    if (done) ric_contraction_defect(k, J);
    return done;
}

static bool invert_widely(ric_tube *t, const arb_mat_t J)
{
    const bool done = ric_contraction_invert_widely(&t->k, J);
    if (done) ric_contraction_defect(&t->k, J);
    return done;
}

/* Z += what J is more in the hull than in the middle, beside the line: J(u) - J(p(1/2)) = D^2
 * F (u - p(1/2)), the mean of D^2 F on the way there, of which the parts along the line and each
 * direction of the basis keep what cancels in them. */
static void add_bends(ric_tube *t, ric_bends *bends)
{
    const slong n = t->k.n, count = (slong)t->hull.m * t->hull.size + 1;
    arb_ptr along = _arb_vec_init(count);
    for (int d = 0; d < t->basis.count; d++) {
        ric_skew_direction(&t->basis, d, along);
        ric_bends_take(bends, along);
        ric_bends_add(bends, &t->basis, mag_get_d(t->k.b + t->basis.at[d]), &t->k);
    }
    _arb_vec_zero(along, count);
    for (slong i = 0; i < n; i++) arb_add_error_mag(along + i, t->k.b + i);
    for (int d = 0; d < t->basis.count; d++) arb_zero(along + t->basis.at[d]);
    ric_bends_take(bends, along);
    ric_bends_add(bends, &t->basis, 1, &t->k);
    _arb_vec_clear(along, count);
}

/* Z from what is left of the middle, and what the line is off it: where no box holds for that, none
 * does for more. `first`: of a box of which y is not known yet. */
static bool add_all(ric_tube *t, const ric_enclosure *e, bool first)
{
    ric_bends bends;
    place_hull(t);
    ric_bends_open(&bends, &t->hull, e);
    ric_bends_take(&bends, t->chord);
    if (first) bound_bend(t, &bends);
    ric_bends_add(&bends, &t->basis, 0.5 + RIC_TUBE_MORE, &t->k);
    if (!first) add_bends(t, &bends);
    ric_bends_close(&bends);
    return first ? ric_contraction_may_hold(&t->k) : ric_contraction_holds(&t->k);
}

/* Boxes that grow while the one before is too small for Z on it, the first one with room for what
 * it adds to what the line does. */
static bool box_holds(ric_tube *t, const ric_enclosure *e)
{
    const ric_enclosure coarse = ric_enclosure_coarse(e);
    const size_t size = (size_t)t->k.n * (size_t)t->k.n * sizeof(double);
    double *least = flint_malloc(size);
    ric_bends_loosen(&t->hull, e, &t->basis, &t->k);
    memcpy(least, t->k.Z, size);
    bound_ends(t);
    floor_box(t);
    bool hopeful = add_all(t, &coarse, true), holds = false;
    for (slong i = 0; i < t->k.n; i++) {
        mag_mul_ui(t->k.b + i, t->k.b + i, 3);
        mag_mul_2exp_si(t->k.b + i, t->k.b + i, -1);
    }
    for (int i = 0; i < TRIES && !holds && hopeful; i++) {
        memcpy(t->k.Z, least, size);
        holds = add_all(t, &coarse, false);
        hopeful = holds || ric_contraction_may_hold(&t->k);
    }
    flint_free(least);
    return holds;
}

/* In Arb's numbers where doubles do not do, and leave of 1 - C J what may be why. */
static bool contracts(ric_tube *t, const ric_enclosure *e)
{
    const slong n = t->k.n;
    arb_mat_t J;
    arb_t half;
    arb_init(half);
    arb_mat_init(J, n, n);
    evaluate_ends(t, e);
    arb_set_d(half, 0.5);
    place(t, half, t->hull.u);
    for (slong i = 0; i < n; i++) arb_get_mid_arb(t->hull.u + i, t->hull.u + i);
    evaluate(t, &t->hull, e, J);
    bool holds = false;
    if (!ric_halt(pow((double)n, 3))) {
        bool fine = invert(t, J);
        if (fine) {
            fine = ric_contraction_root(n, t->k.Z) < DIGITS;
            holds = box_holds(t, e);
        }
        if (!holds && !fine && !ric_halted()) holds = invert_widely(t, J) && box_holds(t, e);
    }
    arb_mat_clear(J);
    arb_clear(half);
    return holds;
}

/* The zeros lie in y + Z b, too, and so on: the hull of what is left, and how far it spreads. */
static void tighten(ric_tube *t)
{
    const slong n = t->k.n;
    mag_ptr b = _mag_vec_init(n), next = _mag_vec_init(n);
    for (slong i = 0; i < n; i++) mag_set(b + i, t->k.b + i);
    for (int step = 0; step < TIGHT; step++) {
        ric_contraction_map(&t->k, b, next);
        for (slong i = 0; i < n; i++) mag_add(b + i, next + i, t->k.y + i);
    }
    ric_skew_spread(&t->basis, b, t->spread);
    ric_tube_part(t, -RIC_TUBE_MORE, 1 + RIC_TUBE_MORE, t->hull.u);
    _mag_vec_clear(b, n);
    _mag_vec_clear(next, n);
}

static void set_family(ric_tube *t)
{
    arb_t half;
    arb_init(half);
    arb_set_d(half, 0.5);
    place(t, half, t->middle);
    arb_set_d(half, 0.5 + RIC_TUBE_MORE);
    for (slong i = 0; i < t->k.n; i++) {
        arb_add_error_mag(t->middle + i, t->spread + i);
        arb_mul(t->half + i, t->chord + i, half, t->k.prec);
    }
    arb_clear(half);
}

/* w: half of C D^2 F (b - a)^2, where D is all but C^-1. */
static void guess_sag(ric_tube *t, const ric_bends *along)
{
    const slong n = t->k.n;
    arb_ptr F = _arb_vec_init(n);
    double *w = flint_malloc((size_t)n * sizeof *w);
    ric_bends_apply(along, t->chord, F);
    ric_contraction_apply(&t->k, F, t->sag);
    for (slong i = 0; i < n; i++) w[i] = ric_arb_middle(t->sag + i) / 2;
    ric_skew_turn(&t->basis, w);
    for (slong i = 0; i < n; i++) arb_set_d(t->sag + i, w[i]);
    flint_free(w);
    _arb_vec_clear(F, n);
}

/* y <- what C F is along q(s) = p(s) + s (1 - s) w: at its ends, and an eighth of its second
 * derivative C (D^2 F (q', q') - 2 D w), q' = b - a within 1 + 2 RIC_TUBE_MORE of w. */
static void bound_sag(ric_tube *t, const ric_enclosure *e, ric_bends *bends)
{
    const slong n = t->k.n, count = (slong)t->hull.m * t->hull.size + 1;
    arb_ptr way = _arb_vec_init(count), F = _arb_vec_init(2 * n), G = F + n;
    mag_t size;
    arb_t all;
    mag_init(size);
    arb_init(all);
    arb_set_d(all, 1 + 2 * RIC_TUBE_MORE);
    for (slong i = 0; i < n; i++) {
        arb_mul(way + i, t->sag + i, all, t->k.prec);
        arb_get_mag(size, way + i);
        arb_set(way + i, t->chord + i);
        arb_add_error_mag(way + i, size);
    }
    bound_ends(t);
    ric_bends_take(bends, way);
    ric_bends_apply(bends, way, F);
    apply(t, e, t->sag, G);
    for (slong i = 0; i < n; i++) {
        arb_mul_2exp_si(G + i, G + i, 1);
        arb_sub(F + i, F + i, G + i, t->k.prec);
    }
    add_defect(t, F, -3);
    mag_clear(size);
    arb_clear(all);
    _arb_vec_clear(way, count);
    _arb_vec_clear(F, 2 * n);
}

static double sum_of(slong n, mag_srcptr x)
{
    double sum = 0;
    for (slong i = 0; i < n; i++) sum += mag_get_d(x + i);
    return sum;
}

/* The arc is bent as its chord is not: how it is, and what is left of the box around that, of third
 * order in the chord. 0 = C F(q + T x) = C F(q) + C D T x has |x| <= |C F(q)| + Z |x|, and x is at
 * most b and |T^-1 w| / 4 to begin with. */
static void bend_line(ric_tube *t, const ric_enclosure *e)
{
    const slong n = t->k.n;
    const ric_enclosure coarse = ric_enclosure_coarse(e);
    mag_ptr x = _mag_vec_init(n), next = _mag_vec_init(n);
    ric_bends bends;
    ric_bends_open(&bends, &t->hull, &coarse);
    ric_bends_take(&bends, t->chord);
    guess_sag(t, &bends);
    bound_sag(t, &coarse, &bends);
    ric_bends_close(&bends);
    for (slong i = 0; i < n; i++) arb_get_mag(x + i, t->sag + i);
    ric_skew_enter(&t->basis, x, x);
    for (slong i = 0; i < n; i++) {
        mag_mul_2exp_si(x + i, x + i, -2);
        mag_add(x + i, x + i, t->k.b + i);
    }
    for (int step = 0; step < CLOSE; step++) {
        ric_contraction_map(&t->k, x, next);
        for (slong i = 0; i < n; i++) mag_add(x + i, next + i, t->k.y + i);
    }
    ric_skew_spread(&t->basis, x, t->rest);
    if (!(sum_of(n, t->rest) < sum_of(n, t->spread)))
        for (slong i = 0; i < n; i++) {
            arb_zero(t->sag + i);
            mag_set(t->rest + i, t->spread + i);
        }
    _mag_vec_clear(x, n);
    _mag_vec_clear(next, n);
}

bool ric_tube_create(ric_tube *t, ric_tube_end from, ric_tube_end to, const ric_enclosure *e)
{
    const slong count = (slong)from.c->m * from.c->size + 1;
    *t = (ric_tube){.from = from.c, .to = to.c, .exists = {from.exists, to.exists}};
    ric_chain_copy(&t->hull, from.c);
    ric_contraction_create(&t->k, count_unknowns(from.c), e->prec);
    ric_skew_create(&t->basis, t->k.n);
    t->spread = _mag_vec_init(t->k.n);
    t->chord = _arb_vec_init(count);
    t->middle = _arb_vec_init(count);
    t->half = _arb_vec_init(count);
    t->row = _arb_vec_init(t->k.n);
    t->ends = _arb_vec_init(2 * t->k.n);
    t->sag = _arb_vec_init(t->k.n);
    t->rest = _mag_vec_init(t->k.n);
    arb_init(t->length);
    const bool done = lay_line(t) && contracts(t, e) && ric_chain_closes(&t->hull, e, t->hull.u);
    if (done) tighten(t);
    if (done) set_family(t);
    if (done) bend_line(t, e);
    return done;
}

void ric_tube_free(ric_tube *t)
{
    const slong count = (slong)t->hull.m * t->hull.size + 1;
    _arb_vec_clear(t->chord, count);
    _arb_vec_clear(t->middle, count);
    _arb_vec_clear(t->half, count);
    _arb_vec_clear(t->row, t->k.n);
    _arb_vec_clear(t->ends, 2 * t->k.n);
    _arb_vec_clear(t->sag, t->k.n);
    _mag_vec_clear(t->rest, t->k.n);
    _mag_vec_clear(t->spread, t->k.n);
    arb_clear(t->length);
    ric_skew_free(&t->basis);
    ric_contraction_free(&t->k);
    ric_chain_free(&t->hull);
}

/* ---------------------------------------------------------------- the arc */

bool ric_tube_holds(const ric_tube *t)
{
    const slong n = t->k.n;
    mag_ptr radii = _mag_vec_init(n);
    bool holds = true;
    for (int end = 0; end < 2; end++) {
        holds = reach_end(t, t->exists[end], radii) && holds;
        for (slong i = 0; i < n && holds; i++) holds = mag_cmp(radii + i, t->k.b + i) < 0;
    }
    _mag_vec_clear(radii, n);
    return holds;
}

/* The derivative u' has D u' = (0, .., 0, v.v) and (b - a) all but that: with C D T = 1 - E, |E| <=
 * Z, T x = u' - (b - a) has |x| <= r + Z |x|, r = |C (G' (b - a), 0)|. As Z b <= theta b with theta
 * < 1, |x| <= r + mu Z b, mu = max(r / b) / (1 - theta). */
void ric_tube_slope(const ric_tube *t, const ric_enclosure *e, arb_ptr out)
{
    const slong n = t->k.n;
    arb_ptr F = _arb_vec_init(n), x = _arb_vec_init(n);
    mag_ptr zb = _mag_vec_init(n);
    mag_t theta, mu, y;
    mag_init(theta);
    mag_init(mu);
    mag_init(y);
    apply(t, e, t->chord, F);
    arb_zero(F + n - 1);
    ric_contraction_apply(&t->k, F, x);
    ric_contraction_map(&t->k, t->k.b, zb);
    for (slong i = 0; i < n; i++) {
        mag_div(y, zb + i, t->k.b + i);
        mag_max(theta, theta, y);
        arb_get_mag(y, x + i);
        mag_div(y, y, t->k.b + i);
        mag_max(mu, mu, y);
    }
    mag_one(y);
    mag_sub_lower(y, y, theta);
    mag_div(mu, mu, y);
    for (slong i = 0; i < n; i++) {
        arb_set(out + i, t->chord + i);
        arb_get_mag(y, x + i);
        mag_mul(zb + i, zb + i, mu);
        mag_add(zb + i, zb + i, y);
    }
    ric_skew_spread(&t->basis, zb, zb);
    for (slong i = 0; i < n; i++) arb_add_error_mag(out + i, zb + i);
    mag_clear(theta);
    mag_clear(mu);
    mag_clear(y);
    _mag_vec_clear(zb, n);
    _arb_vec_clear(F, n);
    _arb_vec_clear(x, n);
}

/* ----------------------------------------------------------------- its length */

double ric_tube_strain(const ric_tube *t, const ric_enclosure *e)
{
    const slong n = t->k.n;
    const ric_enclosure coarse = ric_enclosure_coarse(e);
    double *W = flint_malloc((size_t)(n * n) * sizeof *W);
    ric_bends bends;
    ric_bends_open(&bends, &t->hull, &coarse);
    ric_bends_take(&bends, t->chord);
    ric_bends_turn(&bends, &t->basis, &t->k, W);
    ric_bends_close(&bends);
    const double root = ric_contraction_root(n, W) / 2;
    flint_free(W);
    return root;
}
