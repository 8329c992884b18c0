#include "chart.h"
#include "graph.h"
#include "status.h"
#include "store.h"

/* One run: what is in the file already is taken up, everything else is computed, the tables are written at the end or on request to stop. */
ric_status ric_explore(const ric_study *study, const char *path, const ric_run_options *run)
{
    ric_store *store = NULL;
    ric_graph *graph = NULL;
    ric_atlas *atlas = NULL;
    ric_status written = RIC_OK, status = RIC_OK;
    for (int i = 0; i < ric_model_n_contact(ric_study_model(study)); i++) {
        ric_contact contact;
        ric_model_contact(ric_study_model(study), i, &contact);
        if (contact.law != RIC_LAW_RIGID) return ric_fail(RIC_E_INPUT, "only rigid contacts are explored by this version");
    }
    if (ric_model_restitution(ric_study_model(study)) != 1)
        return ric_fail(RIC_E_INPUT, "an atlas needs restitution 1: with losses there are no families of periodic orbits; `ricochet simulate` takes any");
    if ((status = ric_store_open(path, study, &store))) goto out;
    if ((status = ric_graph_create(study, store, &graph))) goto out;
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
    return status;
}
