/* The hunt: its map against the simulator, differences and area, its orbits against closed forms,
 * and both ways against atlases. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "atlas/atlas.h"
#include "explored.h"
#include "hunt/hunt.h"
#include "random_models.h"
#include "studies.h"
#include "sample.h"
#include "check/simulator.h"
#include "close.h"

static const double PI = 3.14159265358979323846;

static ric_study *parse(const char *text)
{
    ric_study *study = NULL;
    if (ric_study_parse(text, "test", ".", &study)) fail_msg("%s", ric_detail());
    return study;
}

/* ---------------------------------------------------------------------- map */

/* A motion that has just left a face, away from grazing. */
static bool random_hit(const ric_impact_map *s, ric_hit *hit)
{
    int f = (int)(uniform(0, 1) * s->n_face);
    if (s->face[f].radius[0] == 0) return false;
    *hit = (ric_hit){f, s->face[f].middle + uniform(-0.9, 0.9) * s->face[f].radius[0],
                     uniform(-1.4, 1.4), 0};
    double w[4];
    return ric_impact_map_state(s, hit, w) && ric_impact_map_inside(s, w, f);
}

static bool follow(const ric_impact_map *s, ric_hit *a, ric_hit *b)
{
    double w[4], after[4];
    return ric_impact_map_state(s, a, w) &&
           ric_impact_map_next(s, w, a->face, 50, &a->tau, b, after);
}

static void map_is_the_simulators(const ric_impact_map *s)
{
    int flown = 0;
    for (int i = 0; i < 400; i++) {
        ric_hit pair[2];
        ric_simulator *sim = s->sim;
        double x[2], v[2], time;
        ric_impact impact;
        bool hit;
        if (!random_hit(s, &pair[0]) || !follow(s, &pair[0], &pair[1]) || fabs(pair[1].angle) > 1.5)
            continue;
        ric_impact_map_write(s, &pair[0], x, v);
        assert_close(ric_model_energy(s->model, x, v), s->energy, 1e-12 * s->energy);
        assert_int_equal(ric_simulator_start(sim, x, v), RIC_OK);
        if (ric_simulator_advance(sim, 60, &hit, &impact)) continue; /* two stops met together */
        assert_true(hit);
        assert_int_equal(impact.face, pair[1].face);
        assert_close(impact.time, pair[0].tau, 1e-11);
        ric_simulator_state(sim, &time, x, v);
        ric_impact_map_read(s, impact.face, x, v, &pair[0]);
        assert_close(pair[0].y, pair[1].y, 1e-10);
        assert_close(pair[0].angle, pair[1].angle, 1e-10);
        flown++;
    }
    assert_true(flown > 100);
}

static double across(const ric_impact_map *s, const ric_hit *hit)
{
    return ric_impact_map_speed(s, hit->face, hit->y) * cos(hit->angle);
}

/* Derivatives against central differences of the map itself; dy d(P sin(angle)) is kept. */
static void map_has_its_slopes(const ric_impact_map *s)
{
    const double h = 1e-5;
    int flown = 0;
    for (int i = 0; i < 200; i++) {
        ric_hit a, b, ends[2];
        double D[4];
        if (!random_hit(s, &a) || !follow(s, &a, &b) || fabs(b.angle) > 1.2) continue;
        assert_true(ric_impact_map_slope(s, &a, &b, D));
        assert_close((D[0] * D[3] - D[1] * D[2]) * across(s, &b) / across(s, &a), 1,
                     1e-9 * (1 + fabs(D[0] * D[3])));
        for (int k = 0; k < 2; k++) {
            bool good = true;
            for (int side = 0; side < 2; side++) {
                ric_hit moved = a;
                *(k ? &moved.angle : &moved.y) += side ? h : -h;
                good &= follow(s, &moved, &ends[side]) && ends[side].face == b.face &&
                        fabs(ends[side].y - b.y) < 1e-2;
            }
            if (!good) continue;
            double size = 1 + fabs(D[k]) + fabs(D[2 + k]);
            assert_close((ends[1].y - ends[0].y) / (2 * h), D[k], 1e-5 * size * size * size);
            assert_close((ends[1].angle - ends[0].angle) / (2 * h), D[2 + k],
                         1e-5 * size * size * size);
            flown++;
        }
    }
    assert_true(flown > 50);
}

static void test_map(void **state)
{
    static const char *const texts[] = {TWO_MASSES, LOOSE_MASS, TWO_WALLS};
    static const double energies[] = {0.7, 3, 12};
    (void)state;
    seed_now = 11;
    for (int i = 0; i < 3; i++)
        for (int e = 0; e < 3; e++) {
            ric_study *study = parse(texts[i]);
            ric_impact_map *s = NULL;
            assert_int_equal(ric_impact_map_create(ric_study_model(study), energies[e], &s),
                             RIC_OK);
            map_is_the_simulators(s);
            map_has_its_slopes(s);
            ric_impact_map_free(s);
            ric_study_free(study);
        }
}

/* Three seen modes, losses, springs: each refused with a message of its own. */
static void test_refusals(void **state)
{
    static const struct {
        const char *text, *message;
    } cases[] = {
        {"title: t\nmodel:\n  mass: [[1,0,0],[0,1,0],[0,0,1]]\n  stiffness: "
         "[[2,-1,0],[-1,2,-1],[0,-1,2]]\n"
         "  contacts:\n"
         "    - {normal: [1, 0, 0], clearance: 1.0, law: rigid}\n",
         "see 3 modes"},
        {"title: t\nmodel:\n  mass: [[1]]\n  stiffness: [[1]]\n  contacts:\n    - {normal: [1], "
         "clearance: 1.0, law: "
         "rigid}\n",
         "see 1 modes"},
        {"title: t\nmodel:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  "
         "restitution: 0.9\n"
         "  contacts:\n"
         "    - {normal: [-1, 1], clearance: 1.0, law: rigid}\n",
         "losses"},
        {"title: t\nmodel:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  "
         "contacts:\n"
         "    - {normal: [-1, 1], clearance: 1.0, law: bilinear, stiffness: 10}\n",
         "rigid"},
        {"title: t\nmodel:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  "
         "contacts:\n"
         "    - {normal: [-1, 1], law: power, exponent: 3, stiffness: 10}\n",
         "rigid"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        ric_study *study = parse(cases[i].text);
        ric_impact_map *s = NULL;
        assert_int_equal(ric_impact_map_create(ric_study_model(study), 1, &s), RIC_E_INPUT);
        assert_null(s);
        assert_non_null(strstr(ric_detail(), cases[i].message));
        ric_study_free(study);
    }
}

/* ------------------------------------------------------------------- orbits */

static ric_hunt *hunted(const ric_model *model, double energy, int impacts, double period,
                        ric_hunt_options o)
{
    ric_hunt *h = NULL;
    o.energy = energy;
    o.impacts = impacts;
    o.period[1] = period;
    if (ric_hunt_create(model, &o, &h) || ric_hunt_run(h)) fail_msg("%s", ric_detail());
    return h;
}

/* By motions. */
static ric_hunt *hunt(const ric_model *model, double energy, int impacts, double period, int rows,
                      int random)
{
    ric_hunt_options o;
    ric_hunt_options_init(&o);
    o.lines = 4000;
    o.rows = rows;
    o.row = 300;
    o.random = random;
    o.starts = 0;
    return hunted(model, energy, impacts, period, o);
}

/* Theory, section 11: E of S2[01] from the period, and of A1[0]. */
static double closed_form(const ric_impact_map *s, const ric_prey *p)
{
    double over = 0, under = 0, t = p->N == 2 ? p->period / 4 : p->period / 2;
    for (int i = 0; i < 2; i++) {
        double c = s->face[0].normal[i] * s->face[0].norm, x = s->omega[i] * t;
        over += p->N == 2 ? c * c / cos(x) / cos(x) : c * c / sin(x) / sin(x);
        under += c * c * (p->N == 2 ? tan(x) : 1 / tan(x)) / s->omega[i];
    }
    return over / (2 * under * under);
}

static void test_closed_forms(void **state)
{
    static const double energies[] = {0.65, 1.2, 2, 30};
    ric_study *study = parse(TWO_MASSES);
    int found = 0;
    (void)state;
    for (int e = 0; e < 4; e++) {
        ric_hunt *h = hunt(ric_study_model(study), energies[e], 2, 40, 5, 2000);
        for (int i = 0; i < h->n; i++) {
            const ric_prey *p = &h->prey[i];
            if (p->N == 2 && !p->symmetric) continue;
            assert_close(closed_form(h->section, p), energies[e], 1e-9 * energies[e]);
            assert_true(p->reversible);
            found++;
        }
        ric_hunt_free(h);
    }
    assert_true(found >= 8);
    ric_study_free(study);
}

/* Two searches that have nothing in common come to the same orbits, and all but the most unstable
 * are found by random starts alone. */
static void test_two_ways(void **state)
{
    ric_study *study = parse(TWO_MASSES);
    ric_hunt *rows = hunt(ric_study_model(study), 5, 4, 31, 40, 0),
             *random = hunt(ric_study_model(study), 5, 4, 31, 0, 60000);
    int common = 0;
    (void)state;
    for (int i = 0; i < random->n; i++)
        common += ric_hunt_find(rows, random->prey[i].N, random->prey[i].hits, 1e-8) >= 0;
    assert_int_equal(common, random->n);
    assert_int_equal(common, rows->n);
    assert_true(rows->n >= 10);
    for (int i = 0; i < rows->n; i++) {
        const ric_prey *p = &rows->prey[i];
        if (fabs(p->trace) < 1e3) assert_true(p->from[RIC_WAY_ROWS] > 0);
        if (p->reversible) assert_true(p->from[RIC_WAY_MIRRORS] > 0);
        else assert_int_equal(p->from[RIC_WAY_MIRRORS], 0);
    }
    ric_hunt_free(rows);
    ric_hunt_free(random);
    ric_study_free(study);
}

/* By guesses of all impact times alone. */
static ric_hunt *hunt_words(const ric_model *model, double energy, int impacts, double period,
                            int starts)
{
    ric_hunt_options o;
    ric_hunt_options_init(&o);
    o.lines = 2;
    o.rows = o.random = 0;
    o.starts = starts;
    return hunted(model, energy, impacts, period, o);
}

static const ric_prey *prey_of(const ric_hunt *h, int N, double period)
{
    for (int i = 0; i < h->n; i++)
        if (h->prey[i].N == N && fabs(h->prey[i].period - period) < 1e-8) return &h->prey[i];
    fail_msg("no orbit of %d impacts and period %.10g", N, period);
    return NULL;
}

/* Orbits whose words no start in double precision has, since it doubles its error fifty times in a
 * period. Periods and traces are those of Newton's method on all impacts with 60 digits. */
static void test_steep(void **state)
{
    static const struct {
        int N;
        double period, trace;
    } known[] = {{4, 17.43786268636519, -4.65357431139e14},
                 {7, 26.0682845412807, -9.75484272321e16}};
    ric_study *study = parse(TWO_MASSES);
    ric_hunt *h = hunt_words(ric_study_model(study), 2.5, 7, 10 * PI, 60);
    (void)state;
    for (int i = 0; i < 2; i++) {
        const ric_prey *p = prey_of(h, known[i].N, known[i].period);
        assert_close(p->period, known[i].period, 1e-11);
        assert_close(p->trace / known[i].trace, 1, 1e-6);
    }
    ric_hunt_free(h);
    ric_study_free(study);
}

/* What motions lead to is found by guesses of all times at once, for several structures (and, of
 * the loose mass, one orbit more); and the same again with the same seed. */
static void test_words(void **state)
{
    static const char *const texts[] = {TWO_MASSES, TWO_WALLS, LOOSE_MASS};
    static const double energies[] = {5, 3, 3};
    (void)state;
    for (int i = 0; i < 3; i++) {
        ric_study *study = parse(texts[i]);
        const ric_model *model = ric_study_model(study);
        ric_hunt *flown = hunt(model, energies[i], 4, 20, 40, 20000),
                 *words = hunt_words(model, energies[i], 4, 20, 300),
                 *again = hunt_words(model, energies[i], 4, 20, 300);
        print_message("structure %d: %d by motions, %d by words\n", i + 1, flown->n, words->n);
        for (int k = 0; k < flown->n; k++)
            assert_true(ric_hunt_find(words, flown->prey[k].N, flown->prey[k].hits, 1e-8) >= 0);
        assert_int_equal(words->n, again->n);
        for (int k = 0; k < words->n; k++) {
            assert_memory_equal(words->prey[k].hits, again->prey[k].hits,
                                (size_t)words->prey[k].N * sizeof(ric_hit));
        }
        ric_hunt_free(flown);
        ric_hunt_free(words);
        ric_hunt_free(again);
        ric_study_free(study);
    }
}

static bool stop_after_five(const char *what, double part, int found, void *user)
{
    (void)what;
    (void)part;
    (void)user;
    return found > 5;
}

/* A hunt that is stopped keeps what it has, in order. */
static void test_stopped(void **state)
{
    ric_study *study = parse(TWO_MASSES);
    ric_hunt *h = NULL;
    ric_hunt_options o;
    (void)state;
    ric_hunt_options_init(&o);
    o.energy = 5;
    o.lines = 2;
    o.rows = o.random = 0;
    o.period[1] = 20;
    o.progress = stop_after_five;
    assert_int_equal(ric_hunt_create(ric_study_model(study), &o, &h), RIC_OK);
    assert_int_equal(ric_hunt_run(h), RIC_E_INTERRUPTED);
    assert_true(h->n > 5 && h->n < 20);
    for (int i = 1; i < h->n; i++) assert_true(h->prey[i].N >= h->prey[i - 1].N);
    ric_hunt_free(h);
    ric_study_free(study);
}

/* ------------------------------------------------------------------ atlases */

/* What leaves the library is what it has inside; a call that asks for nonsense is told so. */
static void test_answers(void **unused)
{
    (void)unused;
    ric_study *study = parse(TWO_MASSES);
    const ric_model *model = ric_study_model(study);
    ric_hunt *h = hunt(model, 5, 2, 31, 20, 0);
    assert_true(ric_hunt_n_found(h) > 0);
    for (int i = 0; i < ric_hunt_n_found(h); i++) {
        ric_found found;
        int word[RIC_HUNT_IMPACTS];
        double state[4], flights[RIC_HUNT_IMPACTS], period = 0;
        assert_int_equal(ric_hunt_found(h, i, &found, word, state, flights), RIC_OK);
        for (int k = 0; k < found.impacts; k++) period += flights[k];
        assert_true(fabs(period / found.period - 1) < 1e-12);
        assert_true(fabs(ric_model_energy(model, state, state + 2) / 5 - 1) < 1e-10);
        assert_true(fabs(found.multipliers[0] + found.multipliers[2] - found.trace) <=
                    1e-14 * fabs(found.trace));
    }
    assert_int_equal(ric_hunt_found(h, ric_hunt_n_found(h), NULL, NULL, NULL, NULL), RIC_E_RANGE);
    ric_hunt_free(h);
    ric_hunt_options options;
    ric_hunt_options_init(&options);
    assert_int_equal(ric_hunt_create(model, &options, &h), RIC_E_INPUT);
    assert_null(h);
    options.energy = 5;
    options.impacts = RIC_HUNT_IMPACTS + 1;
    assert_int_equal(ric_hunt_create(model, &options, &h), RIC_E_INPUT);
    ric_study_free(study);
}

static int count(const ric_hunt *h, const ric_comparison *c, ric_found_state state)
{
    int n = 0;
    for (int i = 0; i < h->n; i++) n += c->findings[i].state == state;
    return n;
}

static ric_comparison *compare(ric_hunt *h, const ric_atlas *atlas)
{
    ric_comparison *c = NULL;
    if (ric_hunt_compare(h, atlas, &c)) fail_msg("%s", ric_detail());
    for (int i = 0; i < h->n; i++)
        if (c->findings[i].state == RIC_FOUND_UNEXPLAINED)
            fail_msg("E %g: an orbit of %d impacts and period %.12g is not explained: %s",
                     h->options.energy, h->prey[i].N, h->prey[i].period, c->findings[i].why);
    return c;
}

/* The short form of tools/hunt.sh. */
static void test_article(void **state)
{
    static const double energies[] = {0.7, 1.5, 2.5, 5, 12};
    ric_atlas *atlas = explore_text(
        TWO_MASSES
        "explore: {energy: [0, 40], frequency: [0.2, 10], impacts: 10, multiply: 4, depth: 0}\n");
    (void)state;
    for (int e = 0; e < 5; e += every_of(4)) {
        ric_hunt *h = hunt(ric_atlas_model(atlas), energies[e], 6, 2 * PI / 0.2, 12, 20000);
        ric_comparison *c = compare(h, atlas);
        print_message(
            "E %g: %d of %d found again, %d found in all, %d beyond budgets, %d isolated\n",
            energies[e], c->n_again, c->n_atlas, h->n, count(h, c, RIC_FOUND_BUDGET),
            count(h, c, RIC_FOUND_ISOLATED));
        assert_true(c->n_atlas >= 10);
        assert_true(c->n_again >= 0.95 * c->n_atlas);
        assert_int_equal(c->n_atlas - c->n_again, c->n_missed);
        ric_comparison_free(c);
        ric_hunt_free(h);
    }
    ric_atlas_free(atlas);
}

/* An atlas of small depth lacks what lies beyond it, and the reason is named; said to have left
 * everything, it would be at fault. */
static void test_fault(void **state)
{
    ric_atlas *atlas = explore_text(
        TWO_MASSES
        "explore: {energy: [0, 40], frequency: [0.2, 10], impacts: 8, multiply: 2, depth: 1}\n");
    ric_hunt *h = hunt(ric_atlas_model(atlas), 1.5, 4, 2 * PI / 0.2, 12, 20000);
    ric_comparison *c = compare(h, atlas);
    (void)state;
    assert_true(count(h, c, RIC_FOUND_BUDGET) > 0);
    assert_int_equal(c->n_again, c->n_atlas);
    ric_comparison_free(c);
    for (int i = 0; i < atlas->n_junction; i++) {
        ric_junction *row = &atlas->junctions[i].row;
        row->departures.known += row->departures.over_budget + row->departures.refused;
        row->departures.over_budget = row->departures.refused = 0;
    }
    assert_int_equal(ric_hunt_compare(h, atlas, &c), RIC_OK);
    assert_true(count(h, c, RIC_FOUND_UNEXPLAINED) > 0);
    ric_comparison_free(c);
    ric_hunt_free(h);
    ric_atlas_free(atlas);
}

/* Contacts of one side each, and a free mode. */
static void test_other_structures(void **state)
{
    static const struct {
        const char *text;
        double energy;
        int least;
    } cases[] = {
        {TWO_WALLS
         "explore: {energy: [0, 20], frequency: [0.3, 10], impacts: 8, multiply: 4, depth: 0}\n",
         3, 7},
        {LOOSE_MASS
         "explore: {energy: [0.01, 20], frequency: [0.3, 10], impacts: 6, multiply: 2, depth: 0}\n",
         3, 1},
    };
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        ric_atlas *atlas = explore_text(cases[i].text);
        ric_hunt *h = hunt(ric_atlas_model(atlas), cases[i].energy, 4, 2 * PI / 0.3, 20, 20000);
        ric_comparison *c = compare(h, atlas);
        print_message("structure %zu: %d of %d found again, %d found in all\n", i + 1, c->n_again,
                      c->n_atlas, h->n);
        assert_true(c->n_again >= 0.95 * c->n_atlas && h->n > 0);
        ric_comparison_free(c);
        ric_hunt_free(h);
        ric_atlas_free(atlas);
    }
}

/* Modes of 1 and 3 rad/s: A1[0] comes to a motion of both, beside which all touch, and cannot be
 * followed from there. It is followed from its other end. */
static void test_together(void **state)
{
    ric_atlas *atlas = explore_text(
        "model:\n  mass: [[1, 0], [0, 1]]\n  stiffness: [[1, 0], [0, 9]]\n"
        "  contacts:\n    - {normal: [0.6, 0.8], clearance: 1, sides: upper}\n"
        "explore: {energy: [0, 9], frequency: [0.3, 10], impacts: 2, multiply: 1, depth: 1}\n");
    ric_hunt *h = hunt(ric_atlas_model(atlas), 3, 1, 6, 12, 20000);
    ric_comparison *c = compare(h, atlas);
    (void)state;
    assert_true(h->n > 0);
    assert_int_equal(count(h, c, RIC_FOUND_ISOLATED), h->n);
    ric_comparison_free(c);
    ric_hunt_free(h);
    ric_atlas_free(atlas);
}

/* A stop on one side that nothing reaches takes no symmetry from an orbit, and its family is
 * followed with it: with the symmetries of the structure alone none of those that are missed is
 * explained. */
static void test_far_stop(void **state)
{
    static const char near_stop[] = TWO_MASSES
        "explore: {energy: [0, 12], frequency: [0.25, 10], impacts: 4, multiply: 1, depth: 1}\n";
    static const char far_stop[] =
        "model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n"
        "  contacts:\n    - {normal: [-1, 1], clearance: 1}\n"
        "    - {normal: [1, 0], clearance: 1000, sides: upper}\n"
        "explore: {energy: [0, 12], frequency: [0.25, 10], impacts: 4, multiply: 1, depth: 1}\n";
    ric_atlas *atlas[2] = {explore_text(near_stop), explore_text(far_stop)};
    ric_hunt *h[2];
    int symmetric = 0, mirrored = 0;
    (void)state;
    for (int i = 0; i < 2; i++)
        h[i] = hunt(ric_atlas_model(atlas[i]), 5, 4, 2 * PI / 0.25, 12, 20000);
    for (int i = 0; i < h[1]->n; i++) {
        const ric_prey *p = &h[1]->prey[i];
        int twin = ric_hunt_find(h[0], p->N, p->hits, 1e-6);
        assert_true(twin >= 0);
        assert_int_equal(p->symmetric, h[0]->prey[twin].symmetric);
        assert_int_equal(p->reversible, h[0]->prey[twin].reversible);
        symmetric += p->symmetric;
        mirrored += p->flip >= 0;
    }
    print_message("far stop: %d found, %d symmetric, %d mirrored\n", h[1]->n, symmetric, mirrored);
    assert_true(symmetric > 0 && mirrored > 0);
    for (int i = 0; i < 2; i++) {
        ric_comparison *c = compare(h[i], atlas[i]);
        assert_true(count(h[i], c, RIC_FOUND_BUDGET) > 0);
        assert_int_equal(c->n_again, c->n_atlas);
        ric_comparison_free(c);
        ric_hunt_free(h[i]);
        ric_atlas_free(atlas[i]);
    }
}

/* A frame whose two masses each have a stop outside: half a period of A2[01] takes a motion to its
 * image, left for right, and where that map has the multiplier i a period takes every deviation to
 * its negative. Two branches with mirror points leave there, images of each other, and one without,
 * which is followed from elsewhere and known for another one. */
static void test_frame(void **state)
{
    static const char frame[] =
        "model:\n  mass: [[1, 0], [0, 1]]\n  stiffness: [[2.73, -1.73], [-1.73, 2.73]]\n"
        "  contacts:\n    - {normal: [1, 0], clearance: 1, sides: upper}\n"
        "    - {normal: [0, -1], clearance: 1, sides: upper}\n"
        "explore: {start: [2], energy: [0, 9.5], frequency: [0.7, 12], impacts: 4, multiply: 2, "
        "depth: 2}\n";
    ric_atlas *atlas = explore_text(frame);
    ric_hunt *h = hunt(ric_atlas_model(atlas), 1.44337, 4, 8.3, 30, 20000);
    ric_comparison *c = compare(h, atlas);
    int with = 0, without = 0, together = 0;
    (void)state;
    for (int i = 0; i < h->n; i++) {
        const ric_prey *p = &h->prey[i];
        if (p->N != 4) continue;
        with += p->reversible && c->findings[i].state == RIC_FOUND_KNOWN;
        without += !p->reversible && c->findings[i].state == RIC_FOUND_BUDGET;
    }
    assert_int_equal(with, 2);
    assert_int_equal(without, 1);
    int doublings = 0;
    for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
        ric_junction j = junction_of(atlas, id);
        if (j.kind != RIC_KIND_MULTIPLICATION || fabs(j.energy - 1.3529769) > 1e-6) continue;
        doublings++;
        assert_int_equal(j.departures.taken, 2);
        assert_int_equal(j.departures.refused, 1);
    }
    assert_int_equal(doublings, 1);
    ric_comparison_free(c);
    ric_hunt_free(h);
    /* both stops at one instant, whatever the energy: no branch of an atlas, and it is said */
    h = hunt(ric_atlas_model(atlas), 9, 2, 4, 12, 20000);
    c = compare(h, atlas);
    for (int i = 0; i < h->n; i++)
        together += strstr(c->findings[i].why, "two stops at one instant") != NULL;
    assert_int_equal(together, 1);
    ric_comparison_free(c);
    ric_hunt_free(h);
    ric_atlas_free(atlas);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_map),          cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_closed_forms), cmocka_unit_test(test_answers),
        cmocka_unit_test(test_two_ways),     cmocka_unit_test(test_article),
        cmocka_unit_test(test_fault),        cmocka_unit_test(test_other_structures),
        cmocka_unit_test(test_steep),        cmocka_unit_test(test_words),
        cmocka_unit_test(test_stopped),      cmocka_unit_test(test_far_stop),
        cmocka_unit_test(test_frame),        cmocka_unit_test(test_together),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
