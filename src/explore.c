#include <stdlib.h>

#include "chart.h"
#include "graph.h"
#include "status.h"
#include "store.h"

/* One run: what is in the file already is taken up, everything else is computed, the tables are written at the end or on request to stop. */
ric_status ric_explore_with(const ric_study *study, const char *path, const ric_run_options *run, const ric_crew *crew)
{
    ric_store *store = NULL;
    ric_graph *graph = NULL;
    ric_atlas *atlas = NULL;
    char *starts = NULL;
    ric_status written = RIC_OK, status = RIC_OK;
    for (int i = 0; i < ric_model_n_contact(ric_study_model(study)); i++) {
        ric_contact contact;
        ric_model_contact(ric_study_model(study), i, &contact);
    }
    if (ric_model_restitution(ric_study_model(study)) != 1)
        return ric_fail(RIC_E_INPUT, "an atlas needs restitution 1: with losses there are no families of periodic orbits; `ricochet simulate` takes any");
    if ((status = ric_store_open(path, study, &store))) goto out;
    if ((status = ric_graph_create(study, store, &graph))) goto out;
    graph->crew = crew;
    if ((status = ric_store_starts_get(store, &starts))) goto out;
    if ((status = ric_starts_parse(ric_study_model(study), starts, &graph->starts))) goto out;
    status = ric_graph_explore(graph, run);
    if (status && status != RIC_E_INTERRUPTED) goto out;
    written = ric_chart(graph, study, status == RIC_OK, &atlas);
    if (!written) written = ric_store_write(store, atlas);
    if (written) status = written;
    else if (status) status = ric_fail(RIC_E_INTERRUPTED, "stopped on request; the same command goes on from here");
out:
    ric_atlas_free(atlas);
    ric_graph_free(graph);
    ric_store_close(store);
    free(starts);
    return status;
}

ric_status ric_explore(const ric_study *study, const char *path, const ric_run_options *run)
{
    return ric_explore_with(study, path, run, NULL);
}

/* --------------------------------------------------------- at the other end */

struct ric_hand {
    ric_graph *graph;
};

ric_status ric_hand_create(const ric_study *study, ric_hand **out)
{
    ric_hand *hand = calloc(1, sizeof *hand);
    *out = NULL;
    if (!hand) return ric_fail(RIC_E_NOMEM, "no memory for a worker");
    ric_status status = ric_graph_create(study, NULL, &hand->graph);
    if (!status) status = ric_memo_create(&hand->graph->recall.memo);
    if (status) ric_hand_free(hand);
    else *out = hand;
    return status;
}

void ric_hand_free(ric_hand *hand)
{
    if (!hand) return;
    if (hand->graph) ric_memo_free(hand->graph->recall.memo);
    ric_graph_free(hand->graph);
    free(hand);
}

ric_memo *ric_hand_prepare(ric_hand *hand, ric_node *node, unsigned choice)
{
    ric_graph_prepare(hand->graph, node, choice);
    return hand->graph->recall.memo;
}

const ric_model *ric_hand_model(const ric_hand *hand)
{
    return hand->graph->model;
}
