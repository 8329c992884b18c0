/* Atlases computed in memory from the text of a study, and their rows. Needs cmocka.h before it. */
#ifndef EXPLORED_H
#define EXPLORED_H

#include <string.h>

#include "explore/rows.h"
#include "explore/graph.h"

/* `store`: traces of an earlier run, or NULL; `max_step` 0: that of the study. */
static inline ric_atlas *explore_text_with(const char *text, ric_store *store, double max_step)
{
    ric_study *study = NULL;
    ric_graph *graph = NULL;
    ric_atlas *atlas = NULL;
    if (ric_study_parse(text, "test", ".", &study)) fail_msg("%s\n%s", ric_detail(), text);
    assert_int_equal(ric_graph_create(study, store, &graph), RIC_OK);
    if (max_step > 0) graph->limits.max_step = max_step;
    if (ric_graph_explore(graph, NULL) || ric_rows_make(graph, study, true, &atlas))
        fail_msg("%s", ric_detail());
    ric_graph_free(graph);
    ric_study_free(study);
    return atlas;
}

/* The branches and junctions of a study as they are at work. */
static inline ric_graph *explored_graph(ric_study *study)
{
    ric_graph *graph = NULL;
    assert_int_equal(ric_graph_create(study, NULL, &graph), RIC_OK);
    if (ric_graph_explore(graph, NULL)) fail_msg("%s", ric_detail());
    return graph;
}

static inline ric_atlas *explore_text(const char *text)
{
    return explore_text_with(text, NULL, 0);
}

static inline ric_branch branch_of(const ric_atlas *atlas, int id)
{
    ric_branch out;
    assert_int_equal(ric_atlas_branch(atlas, id, &out), RIC_OK);
    return out;
}

/* The id of the first branch of a label. */
static inline int branch_named(const ric_atlas *atlas, const char *label)
{
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++)
        if (!strcmp(branch_of(atlas, id).label, label)) return id;
    fail_msg("no branch %s", label);
    return 0;
}

static inline ric_junction junction_of(const ric_atlas *atlas, int id)
{
    ric_junction out;
    assert_int_equal(ric_atlas_junction(atlas, id, &out), RIC_OK);
    return out;
}

static inline void point_passes(const ric_atlas *atlas, int id, int i)
{
    ric_check check;
    if (ric_verify_point(atlas, id, i, &check)) fail_msg("%s", ric_detail());
    if (!check.passed)
        fail_msg("branch %d %s, point %d: flights %.3g, return %.3g, condition %.3g, energy %.3g, "
                 "faces %d",
                 id, branch_of(atlas, id).label, i, check.flight_error, check.return_error,
                 check.condition, check.energy_error, check.faces_agree);
}

#endif
