/* What a branch passes beside its own image does not depend on how far apart its points lie. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "close.h"
#include "explore/graph_parts.h"
#include "explored.h"
#include "steps.h"

/* Gaps of 1/1000 of each other: |w| is 131. */
static const char returning[] =
    "model:\n  mass: [[1.890625, 0.234375], [0.234375, 1.15625]]\n"
    "  stiffness: [[2.0149765091291507, 0.8971315879005736], [0.8971315879005736, "
    "4.623897066319733]]\n"
    "  contacts:\n"
    "    - {normal: [-1, 1], law: rigid, clearance: 0.000517, sides: both}\n"
    "    - {normal: [1, 0], law: rigid, clearance: 5.17e-07, sides: upper}\n"
    "explore: {energy: [0, 1.414], frequency: [0.1999, 5.999], impacts: 3, multiply: 2, depth: "
    "2}\n";

static int count_at(const ric_atlas *atlas, ric_kind kind, double energy, double tolerance)
{
    int count = 0;
    for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
        ric_junction j = junction_of(atlas, id);
        count += j.kind == kind && agrees(j.energy, energy, tolerance);
    }
    return count;
}

/* A3[222] comes to an orbit that is its own image backwards, and ends there. It is 17 away from an
 * orbit gone through three times, which long steps took for near: they went on over the image.
 * Extrema of the period are flat. */
static void ends_at_its_image(void **state)
{
    (void)state;
    ric_atlas *atlas = same_for_all_steps_to(1e-7, returning);
    assert_int_equal(count_at(atlas, RIC_KIND_BRANCH_POINT, 0.00490567344351, 1e-10), 1);
    ric_atlas_free(atlas);
}

/* One passage of a multiplication more, as where a branch goes back over its image. */
static void returning_is_said(void **state)
{
    (void)state;
    ric_study *study = NULL;
    assert_int_equal(ric_study_parse(returning, "test", ".", &study), RIC_OK);
    ric_graph *graph = explored_graph(study);
    int tried = 0;
    for (int i = 0; i < graph->n_edge; i++) {
        ric_edge *e = &graph->edges[i];
        const ric_continuation *tr = e->trace;
        ric_graph_edge_returning(graph, e);
        assert_int_equal(tr->unresolved, 0);
        if (e->n_inner == 0 || graph->nodes[e->inner[0].node]->kind == RIC_KIND_BRANCH_POINT)
            continue;
        const double again = (e->inner[0].at +
                              ric_continuation_row(tr, tr->n_point - 1)->arclength) /
                             2;
        if (tr->n_point < 9 || !(again > e->inner[e->n_inner - 1].at)) continue;
        assert_int_equal(ric_graph_edge_attach(e, e->inner[0].node, RIC_THROUGH, again), RIC_OK);
        ric_graph_edge_returning(graph, e);
        assert_true(tr->unresolved > 0 && tr->crowded_at[0] > 0);
        tried++;
    }
    print_message("# %d branches\n", tried);
    assert_true(tried > 0);
    ric_graph_free(graph);
    ric_study_free(study);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(ends_at_its_image),
                                       cmocka_unit_test(returning_is_said)};
    return cmocka_run_group_tests_name("steps_ends", tests, NULL, NULL);
}
