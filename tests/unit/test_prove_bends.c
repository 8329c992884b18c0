/* Second derivatives of the equations of a chain, against differences of first ones, and what a
 * contraction takes of them in a basis; and what is said of a gap on parts of a flight, against the
 * flight. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdlib.h>

#include "ricochet.h"

#if __has_include(<arb.h>) || __has_include(<flint/arb.h>)
#include "prove/augmented_rows.h"
#include "prove/bends.h"
#include "prove/glide.h"
#include "random_chains.h"

enum { BITS = 512, STEP = -80 };

/* J at u + v 2^STEP, or at u - v 2^STEP. */
static void evaluate(ric_chain *c, const ric_enclosure *e, arb_srcptr v, bool back, arb_mat_t J)
{
    const slong count = (slong)c->m * c->size + 1;
    arb_ptr u = _arb_vec_init(2 * count), way = u + count;
    ric_equations q;
    _arb_vec_set(u, c->u, count);
    _arb_vec_scalar_mul_2exp_si(way, v, count, STEP);
    if (back) _arb_vec_neg(way, way, count);
    _arb_vec_add(c->u, u, way, count, BITS);
    ric_equation_create(&q, c);
    ric_equation_evaluate(&q, c, e);
    ric_equation_gather(&q, c, J, NULL);
    ric_equation_free(&q);
    _arb_vec_set(c->u, u, count);
    _arb_vec_clear(u, 2 * count);
}

/* A: D^2 F v, within 2^(2 STEP) times what third derivatives are; the plane has none. */
static void differ(ric_chain *c, const ric_enclosure *e, arb_srcptr v, arb_mat_t A)
{
    arb_mat_t before;
    arb_mat_init(before, arb_mat_nrows(A), arb_mat_ncols(A));
    evaluate(c, e, v, true, before);
    evaluate(c, e, v, false, A);
    arb_mat_sub(A, A, before, BITS);
    arb_mat_scalar_mul_2exp_si(A, A, -STEP - 1);
    arb_mat_get_mid(A, A);
    arb_mat_clear(before);
}

static void lay_orbit(ric_chain *c)
{
    for (slong i = 0; i < (slong)c->m * c->size; i++)
        arb_set_d(c->u + i, i % c->size == c->size - 1 ? uniform(0.3, 2) : 2 * draw());
}

static bool is_near(arb_srcptr x, arb_srcptr y)
{
    return fabs(ric_arb_middle(x) - ric_arb_middle(y)) < 1e-12 * (1 + fabs(ric_arb_middle(y)));
}

/* Random, near 1, and three directions of it. */
static void lay_basis(ric_contraction *k, ric_skew *s)
{
    const slong n = k->n;
    for (slong i = 0; i < n * n; i++) k->C[i] = (i % (n + 1) == 0) + 0.1 * draw();
    while (s->count < 3 && ric_skew_find(s, k)) continue;
}

/* Z is |C A T| of the numbers that A has, and no more than roundings beside it. */
static void check_product(const ric_contraction *k, const ric_skew *s, arb_mat_t A)
{
    const slong n = k->n;
    arb_mat_t C, product;
    arb_mat_init(C, n, n);
    arb_mat_init(product, n, n);
    for (slong i = 0; i < n * n; i++) arb_set_d(arb_mat_entry(C, i % n, i / n), k->C[i]);
    ric_skew_columns(s, A, BITS);
    arb_mat_mul(product, C, A, BITS);
    for (slong i = 0; i < n * n; i++) {
        const double size = fabs(ric_arb_middle(arb_mat_entry(product, i % n, i / n)));
        assert_true(size / 2 <= k->Z[i] * (1 + 1e-12) + 1e-20);
        assert_true(k->Z[i] <= size / 2 * (1 + 1e-8) + 1e-11);
    }
    arb_mat_clear(C);
    arb_mat_clear(product);
}

static void check_bends(ric_chain *c, const ric_enclosure *e)
{
    const slong n = (slong)c->m * c->size + ric_chain_general(c);
    arb_ptr v = _arb_vec_init(n + 1), F = _arb_vec_init(2 * n), own = F + n;
    ric_contraction k;
    ric_skew s;
    ric_bends bends;
    arb_mat_t A;
    arb_mat_init(A, n, n);
    ric_contraction_create(&k, n, e->prec);
    ric_skew_create(&s, n);
    lay_orbit(c);
    lay_basis(&k, &s);
    ric_bends_open(&bends, c, e);
    for (int way = 0; way < 2; way++) {
        for (slong i = 0; i < n; i++) arb_set_d(v + i, draw());
        ric_bends_take(&bends, v);
        ric_bends_apply(&bends, v, own);
        differ(c, e, v, A);
        for (slong i = 0; i < n; i++) {
            arb_dot(F + i, NULL, 0, arb_mat_entry(A, i, 0), 1, v, 1, n, BITS);
            assert_true(is_near(own + i, F + i));
        }
        for (slong i = 0; i < n * n; i++) k.Z[i] = 0;
        ric_bends_add(&bends, &s, 0.5, &k);
        check_product(&k, &s, A);
    }
    ric_bends_close(&bends);
    ric_skew_free(&s);
    ric_contraction_free(&k);
    arb_mat_clear(A);
    _arb_vec_clear(v, n + 1);
    _arb_vec_clear(F, 2 * n);
}

/* Of random chains, of stops and of springs, general or from mirror point to mirror point. */
static void bends_are_differences(void **state)
{
    (void)state;
    for (unsigned seed = 1; seed <= 12; seed++) {
        seed_now = seed;
        ric_model *model = structure(2 + (int)seed % 3, (int)seed / 3 % 3);
        ric_enclosure e;
        assert_true(ric_enclosure_create(&e, model, BITS));
        for (int i = 0; i < 10; i++) {
            ric_chain c;
            lay_chain(&c, &e, 1 + i % 4, i);
            check_bends(&c, &e);
            ric_chain_free(&c);
        }
        ric_enclosure_free(&e);
        ric_model_free(model);
    }
}

/* Where two impacts turn a motion round together, of a motion beside it that parts them: the
 * derivative of all rows along v, against differences. */
static void check_rows(ric_augmented *x)
{
    const slong n = x->n;
    arb_ptr z = _arb_vec_init(6 * n), v = z + n, step = v + n, F[] = {step + n, z + 4 * n};
    arb_t along;
    arb_mat_t J, other;
    arb_init(along);
    arb_mat_init(J, n, n);
    arb_mat_init(other, n, n);
    for (slong i = 0; i < n; i++) arb_set_d(z + i, uniform(0.3, 2));
    for (slong i = 0; i < n; i++) arb_set_d(v + i, draw());
    for (slong i = 0; i < n - x->n_orbit; i++) arb_set_d(x->l + i, draw());
    for (slong i = 0; i < 2 * x->e->n; i++) arb_set_d(arb_mat_entry(x->gauge, 0, i), draw());
    ric_augmented_evaluate(x, z, J, F[0]);
    for (int side = 0; side < 2; side++) {
        _arb_vec_scalar_mul_2exp_si(step, v, n, STEP);
        if (side) _arb_vec_neg(step, step, n);
        _arb_vec_add(step, step, z, n, BITS);
        ric_augmented_evaluate(x, step, other, F[side]);
    }
    _arb_vec_sub(F[0], F[0], F[1], n, BITS);
    _arb_vec_scalar_mul_2exp_si(F[0], F[0], n, -STEP - 1);
    for (slong i = 0; i < n; i++) {
        arb_dot(along, NULL, 0, arb_mat_entry(J, i, 0), 1, v, 1, n, BITS);
        assert_true(is_near(F[0] + i, along));
    }
    arb_clear(along);
    arb_mat_clear(J);
    arb_mat_clear(other);
    _arb_vec_clear(z, 6 * n);
}

static void partings_are_differences(void **state)
{
    (void)state;
    for (unsigned seed = 1; seed <= 12; seed++) {
        seed_now = seed;
        ric_model *model = structure(2 + (int)seed % 3, 0);
        ric_enclosure e;
        assert_true(ric_enclosure_create(&e, model, BITS));
        for (int i = 0; i < 4; i++) {
            ric_augmented x = {.e = &e, .ask = {.kind = RIC_AUGMENTED_BREAK}, .redundant = -1};
            lay_chain(&x.c, &e, 1 + i, 1 + i % 2 * 2);
            x.c.start = RIC_CHAIN_BOTH;
            x.c.face[0] = 0;
            x.c.also = e.n_face - 1;
            assert_true(e.wall[0].contact != e.wall[x.c.also].contact);
            x.ask.broken[0] = true;
            x.n_orbit = x.n_motion = (slong)x.c.m * x.c.size;
            x.n = 2 * x.n_orbit;
            x.l = _arb_vec_init(x.n);
            arb_mat_init(x.gauge, 2, 2 * e.n);
            check_rows(&x);
            arb_mat_clear(x.gauge);
            _arb_vec_clear(x.l, x.n);
            ric_chain_free(&x.c);
        }
        ric_enclosure_free(&e);
        ric_model_free(model);
    }
}

/* Flights of a line of states, of which one starts at `state`. */
typedef struct {
    const ric_enclosure *e;
    ric_glide g;
    arb_ptr line; /* [3 * 2n] hull, middle, half */
    arb_ptr state, flown;
    arb_t slack, d;
} glide_test;

static bool holds(ric_ball x, double y)
{
    return fabs(y - x.m) <= x.r + 1e-12 * fabs(x.m);
}

/* That flight at a time of the part: h, h' and h'' lie where they are said to. Returns h. */
static double check_instant(glide_test *x, int contact, int side, const arb_t t,
                            ric_glide_part part)
{
    const ric_enclosure *e = x->e;
    const slong n = e->n;
    arb_ptr bent = _arb_vec_init(n);
    arb_t y;
    double h[3];
    arb_init(y);
    ric_chain_fly(e, NULL, x->state, t, x->flown);
    for (slong i = 0; i < n; i++) arb_mul(bent + i, x->flown + i, e->square + i, BITS);
    arb_srcptr rows[] = {x->flown, x->flown + n, bent};
    for (int k = 0; k < 3; k++) {
        arb_dot(y, NULL, 0, ric_enclosure_c(e, contact), 1, rows[k], 1, n, BITS);
        h[k] = side * ric_arb_middle(y);
    }
    h[0] = ric_arb_middle(x->d) - h[0];
    assert_true(part.least <= h[0]);
    assert_true(holds(part.rate, -h[1]) && holds(part.bend, h[2]));
    _arb_vec_clear(bent, n);
    arb_clear(y);
    return h[0];
}

/* A part of half length r, at states all along the line. A short one is known well, and the longest
 * one no worse than modes can swing: three times their sizes. */
static void check_part(glide_test *x, int contact, int side, double r)
{
    const slong n = x->e->n;
    arb_t mid, half, t;
    double most = -HUGE_VAL;
    arb_init(mid);
    arb_init(half);
    arb_init(t);
    arb_set_d(mid, uniform(0, 3));
    arb_set_d(half, r);
    arb_zero(x->slack);
    ric_glide_place(&x->g, ric_enclosure_c(x->e, contact), side, x->d, x->slack);
    const ric_glide_part part = ric_glide_look(&x->g, mid, half);
    arb_set_d(x->slack, 0.125);
    ric_glide_place(&x->g, ric_enclosure_c(x->e, contact), side, x->d, x->slack);
    const ric_glide_part loose = ric_glide_look(&x->g, mid, half);
    assert_true(loose.least <= part.least - 0.124 && loose.rate.r >= part.rate.r + 0.124 &&
                loose.bend.r >= part.bend.r + 0.124);
    for (int i = 0; i < 8; i++) {
        const double s = i < 2 ? 2 * i - 1 : draw();
        for (slong l = 0; l < 2 * n; l++) {
            arb_set_d(x->state + l, s);
            arb_mul(x->state + l, x->state + l, x->line + 4 * n + l, BITS);
            arb_add(x->state + l, x->state + l, x->line + 2 * n + l, BITS);
        }
        arb_set_d(t, i < 4 ? (i % 2 ? r : -r) : draw() * r);
        arb_add(t, t, mid, BITS);
        most = fmax(most, check_instant(x, contact, side, t, part));
    }
    double swing = 0;
    for (slong i = 0; i < n; i++)
        swing += fabs(ric_arb_middle(ric_enclosure_c(x->e, contact) + i)) * x->g.size[i];
    assert_true(part.least >= ric_arb_middle(x->d) - 3 * swing);
    if (r < 1e-6) assert_true(part.least > most - 1e-3 && part.rate.r < 1e-3 && part.bend.r < 1e-2);
    arb_clear(mid);
    arb_clear(half);
    arb_clear(t);
}

static void parts_hold_their_gaps(void **state)
{
    (void)state;
    for (unsigned seed = 1; seed <= 12; seed++) {
        seed_now = seed;
        ric_model *model = structure(2 + (int)seed % 3, 0);
        ric_enclosure e;
        assert_true(ric_enclosure_create(&e, model, BITS));
        const slong n = e.n;
        glide_test x = {.e = &e, .line = _arb_vec_init(10 * n)};
        x.state = x.line + 6 * n;
        x.flown = x.line + 8 * n;
        arb_init(x.slack);
        arb_init(x.d);
        arb_set_d(x.d, uniform(0.5, 2));
        ric_glide_create(&x.g, (int)n);
        for (slong i = 0; i < 2 * n; i++) {
            arb_set_d(x.line + 2 * n + i, 2 * draw());
            arb_set_d(x.line + 4 * n + i, 1e-5 * draw());
            arb_set(x.line + i, x.line + 4 * n + i);
            arb_zero(x.state);
            arb_add_error(x.state, x.line + i);
            arb_add(x.line + i, x.line + 2 * n + i, x.state, BITS);
        }
        ric_glide_board(&x.g, &e, x.line, x.line + 2 * n, x.line + 4 * n);
        for (int i = 0; i < 3 * RIC_GLIDE_READINGS; i++)
            check_part(&x, i % 2, i % 4 < 2 ? 1 : -1, pow(2, -(double)(i % 24)));
        ric_glide_free(&x.g);
        arb_clear(x.slack);
        arb_clear(x.d);
        _arb_vec_clear(x.line, 10 * n);
        ric_enclosure_free(&e);
        ric_model_free(model);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(bends_are_differences),
                                       cmocka_unit_test(partings_are_differences),
                                       cmocka_unit_test(parts_hold_their_gaps)};
    return cmocka_run_group_tests_name("prove_bends", tests, NULL, NULL);
}
#else
int main(void)
{
    return 77;
}
#endif
