/* Maps of the return along lines of orbits, in doubles, against the same in many digits: what is
 * told of a line holds for all of it. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdlib.h>

#include "random_models.h"
#include "ricochet.h"

#if __has_include(<arb.h>) || __has_include(<flint/arb.h>)
#include "prove/monodromy.h"
#include "prove/pairs.h"
#include "random_chains.h"

enum { BITS = 512 };

/* A line of about that size, and in `inside` a number of it at s. */
static ric_line draw_line(double size, double slope, double radius, double s, arb_t inside)
{
    const ric_line x = {size * draw(), size * slope * draw(), size * radius};
    arb_t part;
    arb_init(part);
    arb_set_d(inside, x.g);
    arb_set_d(part, s);
    arb_mul(inside, inside, part, BITS);
    arb_set_d(part, x.m);
    arb_add(inside, inside, part, BITS);
    arb_set_d(part, draw() * x.r);
    arb_add(inside, inside, part, BITS);
    arb_clear(part);
    return x;
}

/* Whether the line has x at s. */
static bool line_holds(ric_line a, double s, const arb_t x)
{
    arb_t ball, slope, at;
    arb_init(ball);
    arb_init(slope);
    arb_init(at);
    arb_set_d(slope, a.g);
    arb_set_d(at, s);
    arb_mul(slope, slope, at, BITS);
    arb_set_d(ball, a.m);
    arb_add(ball, ball, slope, BITS);
    arb_set_d(at, a.r);
    arb_add_error(ball, at);
    const bool holds = arb_contains(ball, x);
    arb_clear(ball);
    arb_clear(slope);
    arb_clear(at);
    return holds;
}

/* Sums, products and inverses of lines hold those of their numbers, at the same place along them.
 */
static void lines_hold_their_numbers(void **state)
{
    (void)state;
    arb_t a, b, x;
    arb_init(a);
    arb_init(b);
    arb_init(x);
    for (int i = 0; i < 4000; i++) {
        const double s = i % 3   ? draw()
                         : i % 2 ? 1
                                 : -1,
                     slope = pow(4, -(i % 30)), radius = i % 5 ? pow(16, -(i % 14)) : 0;
        const ric_line A = draw_line(pow(10, i % 7), slope, radius, s, a);
        const ric_line B = draw_line(pow(10, -(i % 5)), slope, radius, s, b);
        arb_add(x, a, b, BITS);
        assert_true(line_holds(ric_line_add(A, B), s, x));
        arb_sub(x, a, b, BITS);
        assert_true(line_holds(ric_line_sub(A, B), s, x));
        arb_mul(x, a, b, BITS);
        assert_true(line_holds(ric_line_mul(A, B), s, x));
        const ric_line inverse = ric_line_inverse(A);
        arb_inv(x, a, BITS);
        arb_get_mid_arb(x, x);
        if (fabs(A.m) > 1.01 * (fabs(A.g) + A.r)) assert_true(line_holds(inverse, s, x));
        if (fabs(A.m) <= fabs(A.g) + A.r) assert_true(isnan(inverse.m));
    }
    arb_clear(a);
    arb_clear(b);
    arb_clear(x);
}

/* What is bent is of second order: of a product of two lines the radius falls as the square of
 * their slopes. */
static void radii_are_of_second_order(void **state)
{
    (void)state;
    for (int i = 1; i < 12; i++) {
        const double g = ldexp(1, -i);
        const ric_line x = {0.7, g, 0}, y = {-1.3, 2 * g, 0};
        assert_true(ric_line_mul(x, y).r <= 1.001 * g * g + 1e-15);
        assert_true(g > 0.3 || ric_line_inverse(x).r <= 3 * g * g + 1e-15);
    }
}

/* Products hold those of their numbers; what is too large for doubles is told. */
static void products_are_bounded(void **state)
{
    (void)state;
    enum { N = 12 };
    ric_line A[N * N], B[N * N], product[N * N];
    arb_mat_t a, b, exact;
    arb_mat_init(a, N, N);
    arb_mat_init(b, N, N);
    arb_mat_init(exact, N, N);
    for (int i = 0; i < 40; i++) {
        const double radius = i % 4 ? pow(10, -3 * (i % 4)) : 0, size = pow(10, 4 * (i % 40)),
                     s = draw(), slope = i % 3 ? pow(10, -(i % 3)) : 0;
        for (slong l = 0; l < N * N; l++) {
            A[l] = draw_line(size, slope, radius, s, arb_mat_entry(a, l / N, l % N));
            B[l] = draw_line(size, slope, radius, s, arb_mat_entry(b, l / N, l % N));
        }
        const bool holds = ric_monodromy_product(N, A, B, product);
        assert_int_equal(holds, size < 1e154);
        arb_mat_mul(exact, a, b, BITS);
        for (slong l = 0; l < N * N && holds; l++) {
            arb_get_mid_arb(arb_mat_entry(exact, 0, 0), arb_mat_entry(exact, l / N, l % N));
            assert_true(line_holds(product[l], s, arb_mat_entry(exact, 0, 0)));
        }
    }
    arb_mat_clear(a);
    arb_mat_clear(b);
    arb_mat_clear(exact);
}

enum { SIX = 6 };

/* H: turns by two angles, and a shear, with all multipliers on the circle. */
static void set_turns(ric_line *H, const double *angle)
{
    for (int l = 0; l < SIX * SIX; l++) H[l] = ric_line_exact(0);
    for (int k = 0; k < SIX; k += 2) {
        const double at = k ? angle[k / 2 - 1] : 0;
        H[k * SIX + k] = H[(k + 1) * SIX + k + 1] = ric_line_exact(cos(at));
        H[k * SIX + k + 1] = ric_line_exact(k ? sin(at) : 0.5);
        H[(k + 1) * SIX + k] = ric_line_exact(k ? -sin(at) : 0);
    }
}

/* With 4 and 1/4 in place of one turn not all multipliers are on the circle; lines that hold both
 * say nothing. */
static void traces_tell_what_leaves(void **state)
{
    (void)state;
    for (int i = 0; i < 30; i++) {
        const bool stretched = i % 2;
        ric_line H[SIX * SIX];
        set_turns(H, (double[]){3 * draw(), 3 * draw()});
        if (stretched) {
            H[2 * SIX + 2] = ric_line_exact(4);
            H[3 * SIX + 3] = ric_line_exact(0.25);
            H[2 * SIX + 3] = H[3 * SIX + 2] = ric_line_exact(0);
        }
        assert_int_equal(ric_monodromy_leaves(SIX, H, 3), stretched);
        for (int l = 0; l < SIX * SIX; l++) H[l].r = 1e3;
        assert_false(ric_monodromy_leaves(SIX, H, 3));
        H[0].r = NAN;
        assert_false(ric_monodromy_leaves(SIX, H, 3));
    }
}

/* What powers of H say of its pairs, from their traces. */
static ric_stability judge(const ric_line *H)
{
    ric_line sum[2];
    ric_monodromy_traces(SIX, H, 2, sum);
    return ric_pairs_judge(2, sum);
}

static void pairs_are_told(void **state)
{
    (void)state;
    ric_line H[SIX * SIX];
    set_turns(H, (double[]){0.7, 2.1});
    assert_int_equal(judge(H), RIC_STABLE_YES);
    H[0].r = 1e3;
    assert_int_equal(judge(H), RIC_STABLE_UNDECIDED);
    H[0].r = NAN;
    assert_int_equal(judge(H), RIC_STABLE_UNDECIDED);
    set_turns(H, (double[]){0.7, 0.7}); /* two that are the same */
    assert_int_equal(judge(H), RIC_STABLE_UNDECIDED);
    for (int k = 2; k < SIX; k += 2) { /* four off the circle, and off the real line */
        const double by = k == 2 ? 1.01 : 1 / 1.01;
        set_turns(H, (double[]){0.7, 0.7});
        for (int l = 0; l < SIX * SIX; l++)
            if (l / SIX > 1) H[l].m *= l / SIX / 2 == k / 2 ? by : 1 / by;
        assert_int_equal(judge(H), RIC_STABLE_NO);
    }
}

/* d pairs along a line, some of them off [-2, 2] if `wild`; how far they are from each other, and
 * from -2 and 2. */
static double draw_pairs(int d, double width, bool wild, ric_line *rho)
{
    double nearest = 4;
    for (int k = 0; k < d; k++) {
        rho[k] = (ric_line){(wild ? 2.4 : 2) * draw(), width * draw(), 0};
        nearest = fmin(nearest, fabs(2 - fabs(rho[k].m)));
        for (int l = 0; l < k; l++) nearest = fmin(nearest, fabs(rho[k].m - rho[l].m));
    }
    return nearest;
}

/* x^j + x^-j = rho (x^(j - 1) + x^(1 - j)) - (x^(j - 2) + x^(2 - j)), and their sums. */
static void sum_pairs(int d, const ric_line *rho, ric_line *sum)
{
    for (int j = 0; j < d; j++) sum[j] = ric_line_exact(0);
    for (int k = 0; k < d; k++) {
        ric_line before = ric_line_exact(2), now = rho[k];
        for (int j = 0; j < d; j++) {
            const ric_line next = ric_line_sub(ric_line_mul(rho[k], now), before);
            sum[j] = ric_line_add(sum[j], now);
            before = now;
            now = next;
        }
    }
}

/* What is told of pairs along a line holds for all of it, and is told where they are apart. */
static void pairs_are_told_along_lines(void **state)
{
    (void)state;
    int told[3] = {0};
    for (int i = 0; i < 2000; i++) {
        const int d = 1 + i % RIC_PAIRS_MOST;
        const double width = pow(10, -(i % 6));
        ric_line rho[RIC_PAIRS_MOST], sum[RIC_PAIRS_MOST];
        const double nearest = draw_pairs(d, width, i % 4 == 0, rho);
        bool inside = true, off = false; /* all of the line; in its middle */
        for (int k = 0; k < d; k++) {
            inside = inside && ric_line_size(rho[k]) < 2;
            off = off || fabs(rho[k].m) > 2;
        }
        sum_pairs(d, rho, sum);
        const ric_stability stable = ric_pairs_judge(d, sum);
        told[stable]++;
        assert_true(stable != RIC_STABLE_YES || inside);
        assert_true(stable != RIC_STABLE_NO || off);
        if (nearest > 0.15 && width < 5e-5)
            assert_int_equal(stable, inside ? RIC_STABLE_YES : RIC_STABLE_NO);
    }
    assert_true(told[RIC_STABLE_YES] > 200 && told[RIC_STABLE_NO] > 100);
}

/* ------------------------------------------------------------------- returns */

/* States and times along a line, as wide as `width`, and how far balls hold beside it. */
static void lay_line(const ric_chain *c, double width, double radius, arb_ptr middle, arb_ptr half)
{
    const slong count = (slong)c->m * c->size;
    for (slong i = 0; i < count; i++) {
        const bool time = i % c->size == c->size - 1;
        arb_set_d(middle + i, time ? uniform(0.3, 2) : 2 * draw());
        mag_set_d(arb_radref(middle + i), radius);
        arb_set_d(half + i, width * draw());
    }
}

/* An orbit of the line: at s, anywhere in the balls. */
static void draw_orbit(slong count, arb_srcptr middle, arb_srcptr half, double s, arb_ptr out)
{
    arb_t at, off;
    arb_init(at);
    arb_init(off);
    arb_set_d(at, s);
    for (slong i = 0; i < count; i++) {
        arb_get_mid_arb(out + i, middle + i);
        arb_addmul(out + i, half + i, at, BITS);
        arb_set_d(off, draw() * mag_get_d(arb_radref(middle + i)));
        arb_add(out + i, out + i, off, BITS);
    }
    arb_clear(at);
    arb_clear(off);
}

/* Whether all numbers of the line of maps have those of three orbits on it; *wide: the largest
 * radius of the first. */
static void check_map(const ric_chain *c, const ric_enclosure *e, double width, double radius,
                      double *wide)
{
    const slong count = (slong)c->m * c->size + 1;
    const int n = 2 * c->n;
    arb_ptr middle = _arb_vec_init(count), half = _arb_vec_init(count), u = _arb_vec_init(count);
    ric_line *H = calloc((size_t)(n * n), sizeof *H);
    arb_mat_t exact;
    arb_mat_init(exact, n, n);
    lay_line(c, width, radius, middle, half);
    const double noise = ric_monodromy_quick(c, e, &(ric_monodromy_line){middle, half}, H);
    *wide = 0;
    for (int i = 0; i < n * n; i++) *wide = fmax(*wide, H[i].r);
    for (int place = 0; place < 3 && isfinite(noise) && isfinite(*wide); place++) {
        const double s = place == 0 ? -1 : place == 1 ? 1 : draw();
        draw_orbit(count, middle, half, s, u);
        ric_monodromy_map(c, e, u, exact);
        for (int i = 0; i < n * n; i++) {
            arb_ptr x = arb_mat_entry(exact, i / n, i % n);
            arb_get_mid_arb(x, x);
            assert_true(line_holds(H[i], s, x));
        }
    }
    arb_mat_clear(exact);
    free(H);
    _arb_vec_clear(middle, count);
    _arb_vec_clear(half, count);
    _arb_vec_clear(u, count);
}

/* Of random chains, of stops and of springs, general or from mirror point to mirror point. */
static void maps_hold_those_of_orbits(void **state)
{
    (void)state;
    int known = 0;
    for (unsigned seed = 1; seed <= 24; seed++) {
        seed_now = seed;
        const int n = 2 + (int)seed % 3;
        ric_model *model = structure(n, (int)seed / 3 % 3);
        ric_enclosure e;
        assert_true(ric_enclosure_create(&e, model, 256));
        for (int i = 0; i < 25; i++) {
            ric_chain c;
            double wide;
            lay_chain(&c, &e, 1 + i % 7, i);
            check_map(&c, &e, pow(10, -1 - i % 6), i % 2 ? pow(10, -4 - i % 6) : 0, &wide);
            known += isfinite(wide);
            ric_chain_free(&c);
        }
        ric_enclosure_free(&e);
        ric_model_free(model);
    }
    assert_true(known > 400);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lines_hold_their_numbers),
        cmocka_unit_test(radii_are_of_second_order),
        cmocka_unit_test(products_are_bounded),
        cmocka_unit_test(traces_tell_what_leaves),
        cmocka_unit_test(pairs_are_told),
        cmocka_unit_test(pairs_are_told_along_lines),
        cmocka_unit_test(maps_hold_those_of_orbits),
    };
    return cmocka_run_group_tests_name("prove_returns", tests, NULL, NULL);
}
#else
int main(void)
{
    return 77;
}
#endif
