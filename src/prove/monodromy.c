#include "monodromy.h"

#include <math.h>

#include "base/room.h"
#include "equations.h"
#include "pairs.h"

enum {
    ROOT_STEPS = 0, /* of the search for roots: as many as Arb takes */
    SQUARINGS = 3,  /* of the map, in search of a multiplier outside */
};

/* MUCH: of what roundings come to: radii beyond that are the width of balls */
#define MUCH 64
#define LOST 1024 /* what coefficients may be off by */

void ric_monodromy_init(ric_monodromy *m)
{
    *m = (ric_monodromy){.stable = RIC_STABLE_UNDECIDED, .along = {NAN, NAN, NAN}};
    arb_init(m->trace);
    arb_indeterminate(m->trace);
}

void ric_monodromy_clear(ric_monodromy *m)
{
    arb_clear(m->trace);
}

/* -------------------------------------------------------------------- parts */

/* Derivative of the flight by the state, with the slack in every entry. */
static void flight_matrix(const ric_enclosure *e, const ric_phase *phase, arb_srcptr w,
                          arb_mat_t out)
{
    slong n = e->n;
    arb_mat_t D;
    arb_t slack;
    arb_ptr flown = _arb_vec_init(2 * n);
    arb_init(slack);
    arb_mat_init(D, 2 * n, 2 * n + 1);
    ric_equation_flight(e, phase, w, w + 2 * n, D, flown);
    ric_enclosure_slack(ric_phase_enclosure(phase, e), w + 2 * n, slack);
    for (slong i = 0; i < 2 * n; i++)
        for (slong j = 0; j < 2 * n; j++) {
            arb_set(arb_mat_entry(out, i, j), arb_mat_entry(D, i, j));
            arb_add_error(arb_mat_entry(out, i, j), slack);
        }
    arb_mat_clear(D);
    arb_clear(slack);
    _arb_vec_clear(flown, 2 * n);
}

/* The slack in every number of F, times the columns that were flown. */
static void loosen_columns(arb_mat_t P, const arb_mat_t before, const arb_t slack)
{
    mag_t sum, x;
    mag_init(sum);
    mag_init(x);
    for (slong j = 0; j < arb_mat_ncols(P); j++) {
        mag_zero(sum);
        for (slong i = 0; i < arb_mat_nrows(P); i++) {
            arb_get_mag(x, arb_mat_entry(before, i, j));
            mag_add(sum, sum, x);
        }
        arb_get_mag(x, slack);
        mag_mul(sum, sum, x);
        for (slong i = 0; i < arb_mat_nrows(P); i++) arb_add_error_mag(arb_mat_entry(P, i, j), sum);
    }
    mag_clear(sum);
    mag_clear(x);
}

/* P <- F P, mode by mode. */
static void fly(const ric_enclosure *e, arb_srcptr w, arb_mat_t P)
{
    const slong n = e->n;
    arb_srcptr tau = w + 2 * n;
    arb_mat_t before;
    arb_t c, s, back, x;
    arb_init(c);
    arb_init(s);
    arb_init(back);
    arb_init(x);
    arb_mat_init(before, 2 * n, 2 * n);
    arb_mat_swap(before, P);
    for (slong i = 0; i < n; i++) {
        ric_equation_turn(e, i, tau, c, s, back);
        for (slong j = 0; j < 2 * n; j++) {
            arb_srcptr q = arb_mat_entry(before, i, j), p = arb_mat_entry(before, n + i, j);
            arb_mul(arb_mat_entry(P, i, j), c, q, e->prec);
            arb_addmul(arb_mat_entry(P, i, j), s, p, e->prec);
            arb_mul(arb_mat_entry(P, n + i, j), back, q, e->prec);
            arb_addmul(arb_mat_entry(P, n + i, j), c, p, e->prec);
        }
    }
    ric_enclosure_slack(e, tau, x);
    loosen_columns(P, before, x);
    arb_mat_clear(before);
    arb_clear(c);
    arb_clear(s);
    arb_clear(back);
    arb_clear(x);
}

/* 2 (c.q'') / ((c.c) (c.p-)) of an impact with the state w behind it: c.p- = -c.p, q'' = -(L + R) q
 * - sum k (c.q - d) c. */
static void find_kick(const ric_enclosure *e, const ric_phase *phase, int face, arb_srcptr w,
                      arb_t out)
{
    const int contact = e->wall[face].contact;
    arb_ptr pull = _arb_vec_init(e->n);
    arb_t x;
    arb_init(x);
    ric_chain_pull(e, phase, w, pull);
    ric_chain_along(e, face, pull, out);
    arb_neg(out, out);
    ric_chain_along(e, face, w + e->n, x);
    arb_mul(x, x, e->cc + contact, e->prec);
    arb_div(out, out, x, e->prec);
    arb_mul_2exp_si(out, out, 1);
    arb_clear(x);
    _arb_vec_clear(pull, e->n);
}

/* P <- S P with the saltation of an impact: dq+ = Q dq, dp+ = Q dp + kick (c.dq) c. Where springs
 * switch the force goes on as it was: S = 1. */
static void salt(const ric_enclosure *e, const ric_phase *phase, int face, arb_srcptr w,
                 arb_mat_t P)
{
    slong n = e->n;
    if (e->wall[face].closes) return;
    const int contact = e->wall[face].contact;
    arb_srcptr c = ric_enclosure_c(e, contact), turn = arb_mat_entry(e->turn, contact, 0);
    arb_t factor, q, p;
    arb_init(factor);
    arb_init(q);
    arb_init(p);
    find_kick(e, phase, face, w, factor);
    for (slong j = 0; j < 2 * n; j++) {
        arb_dot(q, NULL, 0, c, 1, arb_mat_entry(P, 0, j), 2 * n, n, e->prec);
        arb_dot(p, NULL, 0, c, 1, arb_mat_entry(P, n, j), 2 * n, n, e->prec);
        for (slong i = 0; i < n; i++) {
            arb_submul(arb_mat_entry(P, i, j), q, turn + i, e->prec);
            arb_submul(arb_mat_entry(P, n + i, j), p, turn + i, e->prec);
        }
        arb_mul(q, q, factor, e->prec);
        for (slong i = 0; i < n; i++) arb_addmul(arb_mat_entry(P, n + i, j), q, c + i, e->prec);
    }
    arb_clear(factor);
    arb_clear(q);
    arb_clear(p);
}

/* P along the chain, from behind its first impact to before its last. */
static void along_chain(const ric_chain *c, const ric_enclosure *e, arb_srcptr u, arb_mat_t P)
{
    arb_mat_t F;
    arb_mat_init(F, 2 * c->n, 2 * c->n);
    arb_mat_one(P);
    for (int k = 0; k < c->m; k++) {
        arb_srcptr w = u + (slong)k * c->size;
        if (k > 0) salt(e, c->phase[k], c->face[k], w, P);
        if (!c->phase[k]) fly(e, w, P);
        else {
            flight_matrix(e, c->phase[k], w, F);
            arb_mat_mul(P, F, P, e->prec);
        }
    }
    arb_mat_clear(F);
}

/* The way back: R P^-1 R = (d' b'; c' a') for a symplectic P = (a b; c d), both for (q, -p) and for
 * (-q, p). */
static void turn_back(const arb_mat_t P, arb_mat_t out)
{
    slong n = arb_mat_nrows(P) / 2;
    for (slong i = 0; i < n; i++)
        for (slong j = 0; j < n; j++) {
            arb_set(arb_mat_entry(out, i, j), arb_mat_entry(P, n + j, n + i));
            arb_set(arb_mat_entry(out, i, n + j), arb_mat_entry(P, j, n + i));
            arb_set(arb_mat_entry(out, n + i, j), arb_mat_entry(P, n + j, i));
            arb_set(arb_mat_entry(out, n + i, n + j), arb_mat_entry(P, j, i));
        }
}

static void fly_to_end(const ric_chain *c, const ric_enclosure *e, arb_srcptr u, arb_ptr out)
{
    arb_srcptr w = u + (slong)(c->m - 1) * c->size;
    arb_t slack;
    arb_init(slack);
    ric_chain_fly(e, c->phase[c->m - 1], w, w + 2 * c->n, out);
    ric_chain_slack(e, c->phase[c->m - 1], w, w + 2 * c->n, slack);
    for (slong i = 0; i < 2 * c->n; i++) arb_add_error(out + i, slack);
    ric_chain_reflect(e, c->face[c->m], out + c->n);
    arb_clear(slack);
}

/* P, along the chain, becomes the map over the period, or over half of it, turned round, if the
 * orbit is symmetric. */
static void round_trip(const ric_chain *c, const ric_enclosure *e, arb_srcptr u, arb_mat_t H)
{
    arb_mat_t back;
    arb_mat_init(back, 2 * c->n, 2 * c->n);
    if (!ric_chain_general(c)) {
        turn_back(H, back);
        if (c->end == RIC_CHAIN_IMPACT) {
            arb_ptr w = _arb_vec_init(2 * c->n);
            fly_to_end(c, e, u, w);
            salt(e, c->phase[c->m - 1], c->face[c->m], w, H);
            _arb_vec_clear(w, 2 * c->n);
        }
        arb_mat_mul(H, back, H, e->prec);
    }
    if (c->face[0] >= 0) salt(e, c->phase[0], c->face[0], u, H);
    if (ric_chain_symmetric(c)) arb_mat_neg(H, H);
    arb_mat_clear(back);
}

/* ------------------------------------------------------------------ verdict */

/* n = 2: what the trivial multipliers, 1 twice, leave of the trace decides. */
static void judge_trace(ric_monodromy *m, const arb_mat_t H, bool symmetric, slong prec)
{
    arb_t x;
    arb_init(x);
    arb_mat_trace(m->trace, H, prec);
    arb_sub_ui(m->trace, m->trace, 2, prec);
    arb_abs(x, m->trace);
    arb_sub_ui(x, x, 2, prec);
    if (arb_is_negative(x)) m->stable = RIC_STABLE_YES;
    if (arb_is_positive(x)) m->stable = RIC_STABLE_NO;
    if (symmetric) {
        arb_mul(m->trace, m->trace, m->trace, prec);
        arb_sub_ui(m->trace, m->trace, 2, prec);
    }
    arb_clear(x);
}

/* tr H^k = 2 + the sum of x^k + x^-k over n - 1 pairs: if that is more than 2 (n - 1) in
 * size, one is off the unit circle. It needs few bits where multipliers are large, and all of them
 * at once need many. */
static bool one_is_outside(const arb_mat_t H, slong prec)
{
    const slong n = arb_mat_nrows(H) / 2;
    bool outside = false;
    arb_mat_t P;
    arb_t x;
    arb_init(x);
    arb_mat_init(P, 2 * n, 2 * n);
    arb_mat_set(P, H);
    for (int k = 0; k <= SQUARINGS && !outside; k++) {
        if (k > 0) arb_mat_sqr(P, P, prec);
        arb_mat_trace(x, P, prec);
        arb_sub_ui(x, x, 2, prec);
        arb_abs(x, x);
        arb_sub_ui(x, x, 2 * (ulong)(n - 1), prec);
        outside = arb_is_positive(x);
    }
    arb_mat_clear(P);
    arb_clear(x);
    return outside;
}

/* The polynomial in rho = x + 1/x of a reciprocal one of even degree 2 k: x^j + x^-j is a Chebyshev
 * polynomial of it. */
static void fold(arb_poly_t out, const arb_poly_t p, slong prec)
{
    slong k = arb_poly_degree(p) / 2;
    arb_poly_t before, now, after;
    arb_poly_init(before);
    arb_poly_init(now);
    arb_poly_init(after);
    arb_poly_set_si(before, 2);
    arb_poly_set_coeff_si(now, 1, 1);
    arb_poly_zero(out);
    arb_poly_set_coeff_arb(out, 0, arb_poly_get_coeff_ptr(p, k));
    for (slong j = 1; j <= k; j++) {
        arb_poly_scalar_mul(after, now, arb_poly_get_coeff_ptr(p, k - j), prec);
        arb_poly_add(out, out, after, prec);
        arb_poly_shift_left(after, now, 1);
        arb_poly_sub(after, after, before, prec);
        arb_poly_set(before, now);
        arb_poly_set(now, after);
    }
    arb_poly_clear(before);
    arb_poly_clear(now);
    arb_poly_clear(after);
}

/* All roots real, apart and in (-2, 2): stable; one that is surely not real, or outside: not. */
static ric_stability judge_roots(const arb_poly_t rho, slong prec)
{
    slong degree = arb_poly_degree(rho), inside = 0;
    bool outside = false;
    acb_poly_t p;
    acb_poly_init(p);
    acb_poly_set_arb_poly(p, rho);
    acb_ptr roots = _acb_vec_init(degree);
    const bool apart = acb_poly_find_roots(roots, p, NULL, ROOT_STEPS, prec) == degree;
    const bool real = apart && acb_poly_validate_real_roots(roots, p, prec);
    arb_t x;
    arb_init(x);
    for (slong i = 0; i < degree && apart; i++) {
        arb_abs(x, acb_realref(roots + i));
        arb_sub_ui(x, x, 2, prec);
        outside = outside || arb_is_positive(x) || !arb_contains_zero(acb_imagref(roots + i));
        inside += real && arb_is_negative(x) && arb_contains_zero(acb_imagref(roots + i));
    }
    arb_clear(x);
    _acb_vec_clear(roots, degree);
    acb_poly_clear(p);
    return outside ? RIC_STABLE_NO : inside == degree ? RIC_STABLE_YES : RIC_STABLE_UNDECIDED;
}

/* The characteristic polynomial without (x - 1)^2. */
static void judge_polynomial(ric_monodromy *m, const arb_mat_t H, slong prec)
{
    arb_poly_t p, rho;
    arb_t one;
    arb_init(one);
    arb_one(one);
    arb_poly_init(p);
    arb_poly_init(rho);
    arb_mat_charpoly(p, H, prec);
    for (int i = 0; i < 2; i++) { /* the remainder is 0, as the multiplier is there */
        slong degree = arb_poly_degree(p);
        for (slong j = degree - 1; j >= 0; j--)
            arb_add(p->coeffs + j, p->coeffs + j, p->coeffs + j + 1, prec);
        arb_poly_shift_right(p, p, 1);
    }
    fold(rho, p, prec);
    if (arb_poly_degree(rho) > 0) m->stable = judge_roots(rho, prec);
    arb_clear(one);
    arb_poly_clear(p);
    arb_poly_clear(rho);
}

/* The largest radius of a matrix. */
static double radius_of(const arb_mat_t H)
{
    mag_t most;
    mag_init(most);
    for (slong i = 0; i < arb_mat_nrows(H); i++)
        for (slong j = 0; j < arb_mat_ncols(H); j++)
            mag_max(most, most, arb_radref(arb_mat_entry(H, i, j)));
    const double radius = mag_get_d(most);
    mag_clear(most);
    return radius;
}

/* Coefficients of a polynomial of degree d with all roots on the unit circle are up to 2^d, and its
 * matrix is known to less than that times its radius: with more than LOST nothing is told from it.
 */
static bool polynomial_tells(int n, double radius)
{
    return ldexp(radius, n - 2) < LOST;
}

static void judge(ric_monodromy *m, const ric_chain *c, const ric_enclosure *e, const arb_mat_t H)
{
    if (c->n == 2) judge_trace(m, H, ric_chain_symmetric(c), e->prec);
    else if (one_is_outside(H, e->prec)) m->stable = RIC_STABLE_NO;
    else if (polynomial_tells(2 * c->n, radius_of(H))) judge_polynomial(m, H, e->prec);
}

void ric_monodromy_map(const ric_chain *c, const ric_enclosure *e, arb_srcptr u, arb_mat_t H)
{
    along_chain(c, e, u, H);
    round_trip(c, e, u, H);
}

void ric_monodromy_enclose(ric_monodromy *m, const ric_chain *c, const ric_enclosure *e,
                           arb_srcptr u)
{
    if (c->n < 2) m->stable = RIC_STABLE_YES; /* it has no multipliers but those that are 1 */
    if (c->n < 2) return;
    arb_mat_t H;
    arb_mat_init(H, 2 * c->n, 2 * c->n);
    ric_monodromy_map(c, e, u, H);
    judge(m, c, e, H);
    arb_mat_clear(H);
}

/* What H in doubles says; returns how wide it is. */
static double judge_quickly(ric_monodromy *m, const ric_line *H, int n, slong prec)
{
    double wide = 0;
    for (int i = 0; i < n * n; i++) {
        const double r = ric_line_whole(H[i]).r;
        if (!(r <= wide)) wide = r;
    }
    const int d = n / 2 - 1;
    if (d > 1 && ric_monodromy_leaves(n, H, SQUARINGS)) m->stable = RIC_STABLE_NO;
    else if (d <= RIC_PAIRS_MOST) {
        ric_line sum[RIC_PAIRS_MOST];
        ric_monodromy_traces(n, H, d, sum);
        m->stable = ric_pairs_judge(d, sum);
        if (d == 1) m->along = sum[0];
    } else if (polynomial_tells(n, wide)) {
        arb_mat_t A;
        arb_mat_init(A, n, n);
        for (int i = 0; i < n * n; i++) {
            const ric_ball x = ric_line_whole(H[i]);
            arb_set_d(arb_mat_entry(A, i / n, i % n), x.m);
            mag_set_d(arb_radref(arb_mat_entry(A, i / n, i % n)), x.r);
        }
        judge_polynomial(m, A, prec);
        arb_mat_clear(A);
    }
    return wide;
}

/* All of the line in balls. */
static void judge_in_balls(ric_monodromy *m, const ric_chain *c, const ric_enclosure *e,
                           const ric_monodromy_line *u)
{
    const slong count = (slong)c->m * c->size + 1;
    arb_ptr hull = _arb_vec_init(count);
    for (slong i = 0; i < count; i++) {
        arb_set(hull + i, u->middle + i);
        arb_add_error(hull + i, u->half + i);
    }
    ric_monodromy_enclose(m, c, e, hull);
    _arb_vec_clear(hull, count);
}

void ric_monodromy_judge(ric_monodromy *m, const ric_chain *c, const ric_enclosure *e,
                         const ric_monodromy_line *u)
{
    bool wide = false;
    if (c->n > 1) {
        ric_line *H = flint_malloc((size_t)(4 * c->n * c->n) * sizeof *H);
        const double noise = ric_monodromy_quick(c, e, u, H);
        if (isfinite(noise)) wide = judge_quickly(m, H, 2 * c->n, e->prec) > MUCH * noise;
        flint_free(H);
    }
    if (m->stable == RIC_STABLE_UNDECIDED && !wide) judge_in_balls(m, c, e, u);
}
