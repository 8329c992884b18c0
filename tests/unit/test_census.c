/* The parts of a census: Taylor polynomials of its rows against differences; boxes around orbits of
 * the hunt, of which none may be thrown away; and all orbits of one energy against that hunt. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "ricochet.h"

#if __has_include(<arb.h>) || __has_include(<flint/arb.h>)
#include "prove/census_box.h"
#include "prove/census_scan.h"
#include "close.h"

static const char elementary[] =
    "model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  contacts:\n"
    "    - {normal: [-1, 1], clearance: 1, sides: both, law: rigid}\n";
/* Full matrices, two contacts, three faces. */
static const char oblique[] =
    "model:\n  mass: [[0.9, 0.2], [0.2, 1.3]]\n  stiffness: [[1.7, -0.4], [-0.4, 3.1]]\n"
    "  contacts:\n    - {normal: [0.8, -0.5], clearance: 0.9, sides: both, law: rigid}\n"
    "    - {normal: [0.3, 0.9], clearance: 1.4, sides: upper, law: rigid}\n";

typedef struct {
    ric_study *study;
    ric_enclosure e;
    ric_census_pair pair;
} structure;

static void open_structure(structure *s, const char *text, double energy)
{
    char why[160];
    assert_int_equal(ric_study_parse(text, "test", ".", &s->study), RIC_OK);
    assert_true(ric_enclosure_create(&s->e, ric_study_model(s->study), 128));
    assert_true(ric_census_pair_create(&s->pair, &s->e, energy, 1e4, why));
    assert_true(ric_census_turns(&s->pair, 40));
}

static void close_structure(structure *s)
{
    ric_census_pair_free(&s->pair);
    ric_enclosure_free(&s->e);
    ric_study_free(s->study);
}

static double any(double lo, double hi)
{
    return lo + (hi - lo) * rand() / RAND_MAX;
}

/* --------------------------------------------------------------------- rows */

/* Turns of the table hold those of Arb, of times in it and beyond, and are as narrow but for some
 * roundings. */
static void turns_are_those_of_arb(void **state)
{
    (void)state;
    structure s;
    open_structure(&s, oblique, 4);
    ric_census_pair bare = s.pair;
    bare.n_turn = 0;
    srand(2);
    for (int i = 0; i < 20000; i++) {
        const double t = i % 7 ? any(-1, 50) : pow(10, any(-9, 1));
        ric_ball c[2], sn[2], cosine[2], sine[2];
        ric_census_turn(&s.pair, t, c, sn);
        ric_census_turn(&bare, t, cosine, sine);
        for (int k = 0; k < 2; k++) {
            assert_true(fabs(c[k].m - cosine[k].m) <= c[k].r + cosine[k].r && c[k].r < 1e-15);
            assert_true(fabs(sn[k].m - sine[k].m) <= sn[k].r + sine[k].r && sn[k].r < 1e-15);
        }
    }
    close_structure(&s);
}

static ric_census_word any_word(const ric_census_pair *p)
{
    ric_census_word w = {.N = 1 + rand() % 4};
    for (int i = 0; i < w.N; i++) w.face[i] = rand() % p->n_face;
    return w;
}

/* Rows at times moved by z in direction k: the polynomial of the first and second order, up to the
 * third. */
static void check_row(const ric_census_rows *at, const ric_census_rows *moved, int k, int q,
                      double z)
{
    const double linear = at->residual.m[q] + z * at->time[k].m[q];
    const double square = linear + z * z / 2 * at->bent[k * (k + 1) / 2 + k].m[q];
    const double top = at->pair->top,
                 third = at->size[q] * top * top * top * at->pair->size * fabs(z * z * z) / 6;
    assert_true(fabs(moved->residual.m[q] - square) <= third + 1e-11 * at->pair->size);
    assert_true(moved->residual.r[q] < 1e-11 * at->pair->size);
}

static void rows_are_polynomials_up_to_their_bound(void **state)
{
    (void)state;
    structure s;
    ric_census_rows at, moved;
    open_structure(&s, oblique, 4);
    srand(3);
    for (int trial = 0; trial < 300; trial++) {
        const ric_census_word word = any_word(&s.pair);
        double t[RIC_CENSUS_IMPACTS], w[4], size = 0;
        for (int k = 0; k < word.N; k++) t[k] = trial % 3 ? any(0.01, 6) : pow(10, any(-5, 0));
        for (int i = 0; i < 4; i++) w[i] = any(-1, 1), size += w[i] * w[i];
        for (int i = 0; i < 4; i++) w[i] *= s.pair.size / sqrt(size);
        ric_census_rows_place(&at, &s.pair, &word, t);
        ric_census_rows_centre(&at, w);
        const int k = rand() % word.N;
        const double z = any(-1, 1) * pow(10, any(-4, -1));
        t[k] += z;
        ric_census_rows_place(&moved, &s.pair, &word, t);
        ric_census_rows_centre(&moved, w);
        for (int q = 0; q < at.n - 1; q++) check_row(&at, &moved, k, q, z);
    }
    close_structure(&s);
}

/* Mixed derivatives: the first ones by t, differentiated by another t and by w. */
static void rows_have_the_mixed_derivatives(void **state)
{
    (void)state;
    structure s;
    ric_census_rows at, moved;
    open_structure(&s, oblique, 4);
    srand(4);
    for (int trial = 0; trial < 100; trial++) {
        const ric_census_word word = any_word(&s.pair);
        double t[RIC_CENSUS_IMPACTS], w[4];
        const double h = 1e-6;
        for (int k = 0; k < word.N; k++) t[k] = any(0.05, 5);
        for (int i = 0; i < 4; i++) w[i] = any(-1, 1);
        ric_census_rows_place(&at, &s.pair, &word, t);
        ric_census_rows_centre(&at, w);
        const int l = rand() % word.N, j = rand() % (l + 1), i = rand() % 4;
        w[i] += h;
        ric_census_rows_place(&moved, &s.pair, &word, t);
        ric_census_rows_centre(&moved, w);
        for (int q = 0; q < at.n - 1; q++)
            assert_close((moved.time[l].m[q] - at.time[l].m[q]) / h, at.turned[l][i].m[q], 1e-7);
        w[i] -= h;
        t[j] += h;
        ric_census_rows_place(&moved, &s.pair, &word, t);
        ric_census_rows_centre(&moved, w);
        for (int q = 0; q < at.n - 1; q++)
            assert_close((moved.time[l].m[q] - at.time[l].m[q]) / h,
                         at.bent[l * (l + 1) / 2 + j].m[q], 1e-3);
    }
    close_structure(&s);
}

/* -------------------------------------------------------------------- boxes */

/* The orbit of the hunt in the numbers of a census, begun at impact `shift`. */
static void orbit_of(const structure *s, const ric_hunt *hunt, int i, int shift,
                     ric_census_word *word, double *t, double *w)
{
    ric_found found;
    int letters[RIC_HUNT_IMPACTS];
    double state[4], flights[RIC_HUNT_IMPACTS];
    ric_ball now[4];
    assert_int_equal(ric_hunt_found(hunt, i, &found, letters, state, flights), RIC_OK);
    word->N = found.impacts;
    for (int k = 0; k < 2; k++) {
        double q = 0, p = 0;
        for (int j = 0; j < 2; j++) {
            const double back = arf_get_d(arb_midref(arb_mat_entry(s->e.back, k, j)), ARF_RND_NEAR);
            q += back * state[j];
            p += back * ldexp(state[2 + j], -(int)s->e.time);
        }
        now[k] = ric_ball_exact(q * s->pair.omega[k].m);
        now[2 + k] = ric_ball_exact(p);
    }
    for (int k = 0; k < shift; k++) {
        ric_ball cosine[2], sine[2];
        ric_census_turn(&s->pair, ldexp(flights[k], (int)s->e.time), cosine, sine);
        ric_census_fly(cosine, sine, now);
        ric_census_reflect(&s->pair.face[letters[(k + 1) % word->N]], now);
    }
    for (int k = 0; k < 4; k++) w[k] = now[k].m;
    for (int k = 0; k < word->N; k++) {
        word->face[k] = letters[(k + shift) % word->N];
        t[k] = ldexp(flights[(k + shift) % word->N], (int)s->e.time);
    }
}

static int longest(int N, const double *t)
{
    int at = 0;
    for (int k = 1; k < N; k++)
        if (t[k] > t[at]) at = k;
    return at;
}

/* Boxes with the orbit anywhere in them, of all sizes; states known to anything from 1e-6 to
 * nothing. */
static void keep_orbit(const structure *s, const ric_census_word *word, const double *t,
                       const double *w)
{
    const ric_census_limits limits = {1e3, {0, 1e3}};
    for (int trial = 0; trial < 40; trial++) {
        ric_census_box b;
        const double width = pow(10, any(-6, 0)) * 1.5 / s->pair.top,
                     states = pow(10, any(-6, 0.3)) * s->pair.size;
        for (int k = 0; k < word->N; k++) {
            b.t[k].lo = fmax(0, t[k] - 1e-9 - any(0, width));
            b.t[k].hi = t[k] + 1e-9 + any(0, width);
        }
        for (int i = 0; i < 4; i++) {
            b.w[i].lo = fmax(w[i] - 1e-9 - any(0, states), -s->pair.size);
            b.w[i].hi = fmin(w[i] + 1e-9 + any(0, states), s->pair.size);
        }
        assert_true(ric_census_box_reduce(&b, &s->pair, word, &limits));
        for (int k = 0; k < word->N; k++)
            assert_true(b.t[k].lo < t[k] + 1e-8 && b.t[k].hi > t[k] - 1e-8);
        for (int i = 0; i < 4; i++) assert_true(b.w[i].lo < w[i] + 1e-8 && b.w[i].hi > w[i] - 1e-8);
    }
}

/* Any flights, and states known to anything from 1e-6 to half of |w|: the orbit stays. known: where
 * the state is, and where the first and last flight are then found to some looks at a gap. */
static void scan_orbit(const structure *s, const ric_census_word *word, const double *t,
                       const double *w, int known[2])
{
    for (int trial = 0; trial < 100; trial++) {
        ric_census_box b;
        const double states = pow(10, any(-6, -0.3)) * s->pair.size,
                     most = t[0] + any(0, 20) / s->pair.top;
        for (int k = 0; k < word->N; k++) b.t[k] = (ric_range){0, fmax(most, t[k] + 1e-9)};
        for (int i = 0; i < 4; i++)
            b.w[i] = (ric_range){w[i] - any(0, states), w[i] + any(0, states)};
        assert_true(ric_census_scan(&b, &s->pair, word));
        for (int k = 0; k < word->N; k++)
            assert_true(b.t[k].lo < t[k] + 1e-8 && b.t[k].hi > t[k] - 1e-8);
        if (states < 1e-5 * s->pair.size) {
            const ric_range *last = &b.t[word->N - 1];
            known[0]++;
            known[1] += fmax(b.t[0].hi - b.t[0].lo, last->hi - last->lo) < 0.6 / s->pair.top;
        }
    }
}

/* Nothing comes to the other face at once, nor is a state away from the face of event 0 one behind
 * it. */
static void scan_lie(const structure *s, const ric_census_word *word, const double *t,
                     const double *w)
{
    ric_census_box b;
    for (int k = 0; k < word->N; k++) b.t[k] = (ric_range){fmax(0, t[k] - 0.1), t[k] + 0.1};
    for (int i = 0; i < 4; i++) b.w[i] = (ric_range){w[i] - 1e-4, w[i] + 1e-4};
    ric_census_box other = b;
    other.t[0] = (ric_range){t[0] + 1 / s->pair.top, t[0] + 2 / s->pair.top};
    assert_false(ric_census_scan(&other, &s->pair, word));
    other = b;
    other.w[0] = (ric_range){-w[0] - 1e-4, -w[0] + 1e-4};
    other.w[1] = (ric_range){-w[1] - 1e-4, -w[1] + 1e-4};
    assert_false(ric_census_scan(&other, &s->pair, word));
    for (int i = 0; i < 4; i++) b.w[i].lo = b.w[i].hi = NAN;
    assert_true(ric_census_scan(&b, &s->pair, word));
}

static ric_hunt *hunt_for(const structure *s, double energy, int impacts, double period)
{
    ric_hunt_options o;
    ric_hunt *hunt = NULL;
    ric_hunt_options_init(&o);
    o.energy = energy;
    o.impacts = impacts;
    o.period[1] = period;
    o.lines = 4000;
    o.rows = 20;
    o.row = 300;
    o.random = 4000;
    assert_int_equal(ric_hunt_create(ric_study_model(s->study), &o, &hunt), RIC_OK);
    assert_int_equal(ric_hunt_run(hunt), RIC_OK);
    return hunt;
}

static void boxes_keep_their_orbits(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        double energy;
    } trials[] = {{elementary, 1.5}, {elementary, 5}, {oblique, 1.3}, {oblique, 6}};
    int orbits = 0, known[2] = {0};
    srand(5);
    for (size_t i = 0; i < sizeof trials / sizeof *trials; i++) {
        structure s;
        open_structure(&s, trials[i].text, trials[i].energy);
        ric_hunt *hunt = hunt_for(&s, trials[i].energy, 4, 20);
        for (int j = 0; j < ric_hunt_n_found(hunt); j++, orbits++) {
            ric_census_word word;
            double t[RIC_CENSUS_IMPACTS], w[4];
            orbit_of(&s, hunt, j, 0, &word, t, w);
            orbit_of(&s, hunt, j, longest(word.N, t), &word, t, w);
            keep_orbit(&s, &word, t, w);
            scan_orbit(&s, &word, t, w, known);
            scan_lie(&s, &word, t, w);
        }
        ric_hunt_free(hunt);
        close_structure(&s);
    }
    assert_true(orbits >= 20);
    assert_true(known[0] > 100 &&
                known[1] > 0.8 * known[0]); /* not where a gap all but touches before */
}

/* -------------------------------------------------------------------- census */

static ric_census *census_of(const structure *s, double energy, int impacts, double period)
{
    ric_census_options o;
    ric_census *census = NULL;
    ric_census_options_init(&o);
    o.energy = energy;
    o.impacts = impacts;
    o.period[1] = period;
    assert_int_equal(ric_census_run(ric_study_model(s->study), &o, &census), RIC_OK);
    return census;
}

static void same_as_the_hunt(const char *text, double energy, int impacts, double period)
{
    structure s;
    ric_census_account a;
    open_structure(&s, text, energy);
    ric_census *census = census_of(&s, energy, impacts, period);
    ric_hunt *hunt = hunt_for(&s, energy, impacts, period);
    ric_census_account_of(census, &a);
    assert_true(a.undecided == 0 && a.open == 0 && !a.stopped);
    assert_int_equal(ric_census_n_orbit(census), ric_hunt_n_found(hunt));
    for (int i = 0; i < ric_hunt_n_found(hunt); i++) {
        ric_found found;
        int matches = 0;
        ric_hunt_found(hunt, i, &found, NULL, NULL, NULL);
        for (int j = 0; j < ric_census_n_orbit(census); j++) {
            ric_census_orbit z;
            ric_census_orbit_at(census, j, &z, NULL, NULL, NULL);
            matches += z.impacts == found.impacts && fabs(z.period[0] - found.period) < 1e-9 &&
                       fabs(z.trace[0] - found.trace) < 1e-6 * (1 + fabs(found.trace)) &&
                       z.symmetric == found.symmetric && z.reversible == found.reversible;
        }
        assert_int_equal(matches, 1);
    }
    ric_hunt_free(hunt);
    ric_census_free(census);
    close_structure(&s);
}

static void orbits_are_those_of_the_hunt(void **state)
{
    (void)state;
    same_as_the_hunt(elementary, 5, 2, 40);
    same_as_the_hunt(elementary, 1.5, 2, 20);
    same_as_the_hunt(elementary, 0.9, 2, 20);
    same_as_the_hunt(oblique, 6, 2, 15);
}

/* Below the touch of both modes there is no impact; a census without a longest period is refused
 * where flights may last for ever, and one that is stopped is not complete. */
static void says_what_it_cannot_do(void **state)
{
    (void)state;
    structure s;
    ric_census_options o;
    ric_census_account a;
    ric_census *census = NULL;
    open_structure(&s, elementary, 1.5);
    ric_census_options_init(&o);
    o.energy = 1.5;
    assert_int_equal(ric_census_run(ric_study_model(s.study), &o, &census), RIC_E_INPUT);
    assert_non_null(strstr(ric_detail(), "longest period"));
    o.period[1] = 20;
    o.seconds = 1e-9;
    assert_int_equal(ric_census_run(ric_study_model(s.study), &o, &census), RIC_OK);
    ric_census_account_of(census, &a);
    assert_true(a.stopped && a.undecided > 0 && a.measure > 0.9 && a.measure <= 1);
    ric_census_free(census);
    o = (ric_census_options){.energy = 0.3,
                             .impacts = 3,
                             .period = {0, 40},
                             .workers = 2,
                             .seconds = 60};
    assert_int_equal(ric_census_run(ric_study_model(s.study), &o, &census), RIC_OK);
    ric_census_account_of(census, &a);
    assert_true(a.undecided == 0 && ric_census_n_orbit(census) == 0);
    ric_census_free(census);
    close_structure(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(turns_are_those_of_arb),
        cmocka_unit_test(rows_are_polynomials_up_to_their_bound),
        cmocka_unit_test(rows_have_the_mixed_derivatives),
        cmocka_unit_test(boxes_keep_their_orbits),
        cmocka_unit_test(orbits_are_those_of_the_hunt),
        cmocka_unit_test(says_what_it_cannot_do),
    };
    return cmocka_run_group_tests_name("census", tests, NULL, NULL);
}
#else
int main(void)
{
    return 77;
}
#endif
