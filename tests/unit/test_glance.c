/* Events are located by what one test needs: an orbit looked at without its reach, its multipliers,
 * its map, or its slopes, has the tests that it has when all of it is known. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "branch/room.h"
#include "explored.h"
#include "junction/switching.h"

/* Three masses, a stop and another one that is struck on one side. */
static const char study_text[] = "model:\n  mass: [[1, 0, 0], [0, 1.2, 0], [0, 0, 0.7]]\n  "
                                 "stiffness: [[3, -1, 0], [-1, 2.5, -1], [0, -1, 2]]\n"
                                 "  contacts:\n    - {normal: [0, 1, 0], clearance: 1}\n    - "
                                 "{normal: [1, 0, 0], clearance: 1.3, sides: SIDES}\n"
                                 "explore: {impacts: 4, multiply: 2, depth: 1}\n";

static const unsigned of_map = 1u << RIC_TEST_A | 1u << RIC_TEST_B | 1u << RIC_TEST_D;

static void check_pairs(const ric_continuation *tr, const ric_station *full,
                        const ric_station *seen, bool known)
{
    if (!known) assert_true(isnan(seen->row.trace) && seen->row.stable == RIC_STABLE_UNDECIDED);
    for (int i = 0; i < 2 * tr->floquet.n_pair; i++)
        assert_true(known ? !memcmp(&seen->own[i], &full->own[i], sizeof(double))
                          : isnan(seen->own[i]));
}

static void check_station(ric_continuation *tr, const double *u, int *checked)
{
    ric_station *full = &tr->mid, *seen = &tr->next;
    memcpy(full->u, u, (size_t)tr->chain->n_unknown * sizeof *u);
    memcpy(seen->u, u, (size_t)tr->chain->n_unknown * sizeof *u);
    memset(tr->definite, 0, sizeof tr->definite);
    ric_shooting_evaluate(tr->chain, u);
    const double sign = ric_continuation_tangent(tr->chain, NULL, full->t);
    memcpy(seen->t, full->t, (size_t)tr->chain->n_unknown * sizeof *u);
    if (ric_continuation_look(tr, full, sign, RIC_LOOK_ALL)) fail_msg("%s", ric_detail());
    for (unsigned at = 0; at < RIC_LOOK_ALL; at++) {
        ric_shooting_evaluate(tr->chain, u);
        if (ric_continuation_look(tr, seen, sign, at)) fail_msg("%s", ric_detail());
        for (int i = 0; i < RIC_N_TEST; i++) {
            const bool map = of_map >> i & 1;
            if ((map && !(at & RIC_LOOK_FACTORS)) ||
                (i == RIC_TEST_REACH && !(at & RIC_LOOK_REACH)) ||
                (i == RIC_TEST_SLOPE && !(at & RIC_LOOK_ENERGY)) ||
                (i == RIC_TEST_PERIOD && !(at & RIC_LOOK_PERIOD)))
                assert_true(isnan(seen->test[i]));
            /* what is below its error has no sign in the one, and the expected one in the other */
            else if (!(map && seen->test[i] == 0) && seen->test[i] != full->test[i])
                fail_msg("test %d is %.17g, and %.17g at a glance", i, full->test[i],
                         seen->test[i]);
        }
        assert_true(seen->row.energy == full->row.energy &&
                    seen->row.frequency == full->row.frequency);
        check_pairs(tr, full, seen, at & RIC_LOOK_PAIRS);
        assert_true(seen->solved == full->solved);
    }
    ++*checked;
}

/* Every third point of the branches that leave a node. */
static void check_departure(const ric_graph *g, const ric_node *node, unsigned choice, int *checked)
{
    ric_outset from;
    ric_continuation *tr = NULL;
    if (!ric_switching_depart(g->model, node, choice, 1, &from) && from.chain &&
        !ric_continuation_create(from.chain, from.u, from.t, from.ignore, &g->limits, &tr) &&
        !ric_continuation_run(tr))
        for (int i = 1; i < tr->n_point; i += 3)
            check_station(tr,
                          tr->points + (size_t)i * tr->stride + sizeof(ric_point) / sizeof(double),
                          checked);
    ric_continuation_free(tr);
    from.chain = NULL;
    ric_outset_clear(&from);
}

static void check_structure(const char *sides, int *checked)
{
    char text[1000] = "";
    ric_study *study = NULL;
    ric_graph *g = NULL;
    const char *place = strstr(study_text, "SIDES");
    snprintf(text, sizeof text, "%.*s%s%s", (int)(place - study_text), study_text, sides,
             place + 5);
    if (ric_study_parse(text, "three masses", ".", &study)) fail_msg("%s", ric_detail());
    if (ric_graph_create(study, NULL, &g) || ric_graph_explore(g, NULL))
        fail_msg("%s", ric_detail());
    for (int k = 0; k < g->n_node; k++)
        for (int i = 0; i < g->nodes[k]->n_departure && i < 2; i++)
            check_departure(g, g->nodes[k], g->nodes[k]->departures[i].choice, checked);
    ric_graph_free(g);
    ric_study_free(study);
}

static void same_tests(void **state)
{
    (void)state;
    int checked = 0;
    check_structure("both", &checked);
    check_structure("upper", &checked);
    if (checked < 100) fail_msg("%d orbits only", checked);
}

/* A place where something happens is asked for again with other things to look at; Newton's method
 * goes there once. */
static void places_are_solved_once(void **state)
{
    (void)state;
    long evaluations = 0, found = 0;
    ric_study *study = NULL;
    if (ric_study_parse(
            "model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n"
            "  contacts: [{normal: [-1, 1], clearance: 1}]\n"
            "explore: {start: [1], energy: [0, 200], impacts: 8, multiply: 6, depth: 1}\n",
            "many multiplications", ".", &study))
        fail_msg("%s", ric_detail());
    ric_graph *g = explored_graph(study);
    for (int i = 0; i < g->n_edge; i++) {
        evaluations += g->edges[i].trace->evaluations;
        found += g->edges[i].trace->n_point + g->edges[i].trace->n_event;
    }
    ric_graph_free(g);
    ric_study_free(study);
    /* 5.4 each; 9.3 when places are looked for within the noise of multipliers, from cubics alone
     */
    if (found < 600 || evaluations > 6 * found)
        fail_msg("%ld evaluations, %ld points", evaluations, found);
}

/* A branch that has come to its end holds what was found on it, and no room for steps. */
static void ended_branches_make_no_steps(void **state)
{
    (void)state;
    ric_study *study = NULL;
    if (ric_study_parse("model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n"
                        "  contacts: [{normal: [-1, 1], clearance: 1}]\n"
                        "explore: {energy: [0, 200], impacts: 2, multiply: 1}\n",
                        "two impacts", ".", &study))
        fail_msg("%s", ric_detail());
    ric_graph *g = explored_graph(study);
    assert_true(g->n_edge > 2);
    for (int i = 0; i < g->n_edge; i++) {
        const ric_continuation *tr = g->edges[i].trace;
        assert_true(tr->n_point > 2);
        assert_int_equal(tr->point_capacity, tr->n_point);
        assert_true(!tr->samples.values && !tr->solved.u && !tr->now.u && !tr->floquet.work);
    }
    ric_graph_free(g);
    ric_study_free(study);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(same_tests),
                                       cmocka_unit_test(places_are_solved_once),
                                       cmocka_unit_test(ended_branches_make_no_steps)};
    return cmocka_run_group_tests_name("glance", tests, NULL, NULL);
}
