/* Modes of one frequency: the mixtures of them that impacts would drive, and the families that
 * leave there. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <cmocka.h>

#include "explored.h"

static const char ring[] =
    "title: ring of three\nmodel: {mass: [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "
    "stiffness: [[3, -1, -1], [-1, 3, -1], [-1, -1, 3]], contacts: [{normal: [1, 0, 0], law: "
    "rigid, clearance: 1}, "
    "{normal: [0, 1, 0], law: rigid, clearance: 1}, {normal: [0, 0, 1], law: rigid, clearance: "
    "1}]}\n"
    "explore: {energy: [0, 10], frequency: [0.5, 4], depth: 1, impacts: 6}\n";
/* Stops across each other, and one that no motion of the first family reaches. */
static const char cross[] =
    "title: cross\nmodel: {mass: [[1, 0], [0, 1]], stiffness: [[2, 0], [0, 2]], "
    "contacts: [{normal: [1, 0], law: rigid, clearance: 1}, {normal: [0, 1], law: rigid, "
    "clearance: 1.3}, "
    "{normal: [1, 1], law: rigid, clearance: 1.9}]}\n"
    "explore: {energy: [0, 10], frequency: [0.5, 6], depth: 1, impacts: 2}\n";
/* Two structures with modes of one frequency and stops that are not across each other. */
static const char near[] =
    "title: near\nmodel: {mass: [[1, 0, 0], [0, 1, 0], [0, 0, 1]], stiffness: [[2, 0, 0], [0, 2, "
    "0], [0, 0, 2]], "
    "contacts: [{normal: [0, -1, 1], law: rigid, clearance: 0.00108, sides: both}, "
    "{normal: [0, 1, 0], law: rigid, clearance: 0.00108, sides: upper}]}\n"
    "explore: {energy: [0, 4.312], frequency: [0.2828, 4.243], impacts: 8, multiply: 2, depth: "
    "2}\n";
static const char apart[] =
    "title: apart\nmodel: {mass: [[1, 0], [0, 1]], stiffness: [[2, 0], [0, 2]], "
    "contacts: [{normal: [1, -2], law: rigid, clearance: 17.2, sides: both}, "
    "{normal: [1, 0], law: rigid, clearance: 12.3, sides: lower}]}\n"
    "explore: {energy: [0, 3.591], frequency: [0.2828, 4.243], impacts: 4, multiply: 2, depth: "
    "1}\n";

static ric_study *study_of(const char *text)
{
    ric_study *study = NULL;
    if (ric_study_parse(text, "test", ".", &study)) fail_msg("%s", ric_detail());
    return study;
}

/* One contact: Z along its normal, |Z|^2 = 3/2; two against each other: 2; all three a third of a
 * period apart, the motion that goes round: 3. With the normals' parts at 120 degrees, sum gamma
 * gamma^T = 1. */
static void ring_has_seven(void **state)
{
    (void)state;
    ric_study *study = study_of(ring);
    const ric_mixtures *all = ric_study_model(study)->mixtures;
    int of[4] = {0}, straight = 0;
    assert_int_equal(all->n_space, 1);
    assert_true(ric_mixtures_all(&all->space[0]));
    assert_int_equal(all->n, 7);
    double least = HUGE_VAL;
    for (int i = 0; i < all->n; i++) least = fmin(least, all->list[i].energy);
    for (int i = 0; i < all->n; i++) {
        const ric_mixture *mixed = &all->list[i];
        const double expected[] = {0, 1, 4.0 / 3, 2};
        assert_in_range(mixed->n_contact, 1, 3);
        of[mixed->n_contact]++;
        straight += mixed->straight;
        assert_true(fabs(mixed->energy / least - expected[mixed->n_contact]) < 1e-12);
    }
    assert_int_equal(of[1], 3);
    assert_int_equal(of[2], 3);
    assert_int_equal(of[3], 1);
    assert_int_equal(straight, 6);
    ric_study_free(study);
}

/* A mixture is the same motion at another time and run backwards, and not another one of its
 * energy. */
static void one_motion_has_many_states(void **state)
{
    (void)state;
    ric_study *study = study_of(ring);
    const ric_model *m = ric_study_model(study);
    int n = m->n;
    for (int i = 0; i < m->mixtures->n; i++)
        for (int j = 0; j < m->mixtures->n; j++)
            for (int back = -1; back <= 1; back += 2) {
                double w[2 * n], phase = 0.7;
                const double *z = m->mixtures->list[j].w;
                for (int k = 0; k < n; k++) {
                    w[k] = z[k] * cos(phase) + z[n + k] * sin(phase);
                    w[n + k] = back * (z[n + k] * cos(phase) - z[k] * sin(phase));
                }
                assert_int_equal(ric_mixture_same(m, &m->mixtures->list[i], w, 1e-9), i == j);
            }
    ric_study_free(study);
}

/* Between touches of contacts across each other any time may pass: those are not all tried, and
 * that is said. */
static void what_was_left_out_is_said(void **state)
{
    (void)state;
    ric_atlas *atlas = explore_text(cross);
    int said = 0;
    for (int j = 1; j <= ric_atlas_n_junction(atlas); j++) {
        const ric_junction junction = junction_of(atlas, j);
        said += junction.departures.refused > 0 &&
                strstr(junction.refusal, "perpendicular normals") != NULL;
    }
    assert_int_equal(said, 1);
    ric_atlas_free(atlas);
}

/* Whether a branch begins at this energy and frequency with so many letters; its orbits pass the
 * simulator, and where its impacts have no speed no trace is made up. */
static void begins(const ric_atlas *atlas, const char *word, double energy, double frequency)
{
    int found = 0;
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        const ric_branch branch = branch_of(atlas, id);
        bool same = branch.letters == (int)strlen(word);
        for (int k = 0; same && k < branch.letters; k++) same = branch.word[k] == word[k] - '0';
        if (!same || fabs(branch.energy_min - energy) > 1e-6 * energy) continue;
        assert_true(fabs(branch.frequency_min - frequency) < 1e-6 * frequency);
        found++;
        for (int k = 0; k < branch.n_point; k++) {
            ric_point point;
            point_passes(atlas, id, k);
            assert_int_equal(ric_atlas_point(atlas, id, k, &point, NULL, NULL), RIC_OK);
            if (fabs(point.energy - energy) < 1e-9 * energy) assert_true(isnan(point.trace));
        }
    }
    if (found != 1) fail_msg("%d branches of word %s begin at energy %g", found, word, energy);
}

static void families_begin_at_mixtures(void **state)
{
    (void)state;
    const double omega = sqrt(2);
    const struct {
        const char *study, *word;
        double energy, frequency;
    } family[] = {
        {near, "01", 0.5, omega},   {apart, "2", 0.511391292591, omega},
        {apart, "01", 0.2, omega},  {apart, "02", 0.531680976203, omega},
        {ring, "034125", 6, 2},     {cross, "01", 1, omega},
        {cross, "23", 1.69, omega}, {cross, "45", 1.805, omega},
    };
    ric_atlas *atlas = NULL;
    for (size_t i = 0; i < sizeof family / sizeof *family; i++) {
        if (i == 0 || family[i].study != family[i - 1].study) {
            ric_atlas_free(atlas);
            atlas = explore_text(family[i].study);
        }
        begins(atlas, family[i].word, family[i].energy, family[i].frequency);
    }
    ric_atlas_free(atlas);
}

/* A contact across the motion has a gap of cancelling terms, none of whose maxima can be told from
 * rounding: the search for them took 20 s. */
static void a_gap_without_motion_is_left(void **state)
{
    (void)state;
    clock_t start = clock();
    ric_atlas_free(explore_text(cross));
    assert_true(clock() - start < 4 * CLOCKS_PER_SEC);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ring_has_seven),
        cmocka_unit_test(one_motion_has_many_states),
        cmocka_unit_test(what_was_left_out_is_said),
        cmocka_unit_test(families_begin_at_mixtures),
        cmocka_unit_test(a_gap_without_motion_is_left),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
