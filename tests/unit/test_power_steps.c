/* What a step along a branch costs under a power law, where a flight is nearly all of it. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "explored.h"
#include "orbit/shooting_nodes.h"

static ric_graph *explored(ric_study **study)
{
    *study = NULL;
    if (ric_study_parse(
            "model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n"
            "  contacts: [{normal: [-1, 1], law: power, exponent: 7, length: 1, reference: 1}]\n"
            "explore: {start: modes, energy: [0, 1000], frequency: [0.2, 10], multiply: 2, depth: "
            "2}\n",
            "power 7", ".", study))
        fail_msg("%s", ric_detail());
    return explored_graph(*study);
}

/* Both backbones and what leaves them: 3.2 evaluations for a point or an event. 4.8 with
 * predictions from two points, flights that only tell that what is left is rounding, and steps over
 * a crossing that are asked for again although they were too long. */
static void few_flights_make_a_point(void **state)
{
    (void)state;
    long evaluations = 0, found = 0;
    ric_study *study;
    ric_graph *g = explored(&study);
    for (int i = 0; i < g->n_edge; i++) {
        evaluations += g->edges[i].trace->evaluations;
        found += g->edges[i].trace->n_point + g->edges[i].trace->n_event;
    }
    assert_int_equal(g->n_edge, 10);
    ric_graph_free(g);
    ric_study_free(study);
    if (found < 1500 || 10 * evaluations > 36 * found)
        fail_msg("%ld evaluations, %ld points and events", evaluations, found);
}

/* A flight that loses digits where a Newton step is to come is flown again where none is. */
static void rough_flights_are_not_kept(void **state)
{
    (void)state;
    int rough = 0;
    ric_study *study;
    ric_graph *g = explored(&study);
    for (int i = 0; i < g->n_edge; i++) {
        ric_continuation *tr = g->edges[i].trace;
        ric_shooting *c = tr->chain;
        if (c->parts > 1) continue;
        assert_int_equal(ric_shooting_nodes_divide(c, 1), RIC_OK); /* with room for flights */
        for (int k = 0; k < tr->n_event; k++) {
            double u[c->n_unknown];
            memcpy(u, tr->events[k].u, sizeof u);
            u[c->n_start] *= 20; /* no orbit, but a long flight */
            c->rough = true;
            ric_shooting_evaluate(c, u);
            const double lost = c->lost;
            c->rough = false;
            ric_shooting_evaluate(c, u);
            const double sure = c->lost;
            if (!(sure < lost)) continue;
            rough++;
            u[0] *= 2;
            ric_shooting_evaluate(c, u); /* what was flown last is another one */
            u[0] /= 2;
            c->rough = true;
            ric_shooting_evaluate(c, u);
            assert_true(c->lost == sure); /* what is known better is taken */
            c->rough = false;
        }
    }
    ric_graph_free(g);
    ric_study_free(study);
    if (rough < 3) fail_msg("%d flights lose digits", rough);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(few_flights_make_a_point),
                                       cmocka_unit_test(rough_flights_are_not_kept)};
    return cmocka_run_group_tests_name("power_steps", tests, NULL, NULL);
}
