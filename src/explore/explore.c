#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "rows.h"
#include "graph.h"
#include "stored_work.h"
#include "branch/room.h"
#include "base/room.h"
#include "atlas/room.h"

#define HEAP_BLOCKS 6 /* of 31 MB: a run of 100,000 points has 110 MB */
#define STIFFEST 1e9
/* PHASE: largest phase of a mode in one flight: touches are searched in steps of a part of a turn,
 * so that one orbit takes seconds, and the phase itself loses its digits */
#define PHASE 1e7

/* A mode that turns ten million times while the slowest orbit of the window lasts has no place in
 * it. */
static ric_status check_phases(const ric_study *study)
{
    const ric_model *m = ric_study_model(study);
    int n = ric_model_n_dof(m), fastest = -1;
    double *omega = ric_calloc((size_t)n, sizeof *omega),
           longest = RIC_TWO_PI / ric_study_options(study)->frequency[0];
    bool *seen = ric_calloc((size_t)n, sizeof *seen);
    ric_status status = RIC_OK;
    if (!omega || !seen) status = ric_fail(RIC_E_NOMEM, "no memory for %d frequencies", n);
    if (!status && !(status = ric_model_frequencies(m, omega)) &&
        !(status = ric_model_seen(m, seen)))
        for (int i = 0; i < n; i++)
            if (seen[i]) fastest = i;
    if (!status && fastest >= 0 && omega[fastest] * longest > PHASE)
        status = ric_fail(
            RIC_E_INPUT,
            "explore.frequency: mode %d at %.6g rad/s turns %.3g times within the longest period "
            "of the "
            "window, 2 pi / %g s; raise the lower end to %.3g or more, or make a rigid link of the "
            "spring that is so stiff",
            fastest + 1, omega[fastest], omega[fastest] * longest / RIC_TWO_PI,
            ric_study_options(study)->frequency[0], RIC_TWO_PI * omega[fastest] / PHASE);
    free(omega);
    free(seen);
    return status;
}

/* How much stiffer a spring is than the structure at its contact: k c.c / omega^2 of the highest
 * mode that is seen, or of the window where nothing vibrates. */
static double stiffness_ratio(const ric_study *study, const ric_contact *contact,
                              const double *modes, const double *omega, const bool *seen)
{
    const ric_model *m = ric_study_model(study);
    int n = ric_model_n_dof(m);
    double cc = 0, highest = 0;
    for (int i = 0; i < n; i++) {
        double c = 0;
        for (int j = 0; j < n; j++) c += contact->normal[j] * modes[j * n + i];
        cc += c * c;
        if (seen[i]) highest = fmax(highest, omega[i]);
    }
    if (!(highest > 0)) highest = ric_study_options(study)->frequency[1];
    return contact->stiffness * cc / (highest * highest);
}

/* Beyond, displacements within a contact are so short that rounding spoils them, and what comes out
 * only looks like an orbit. */
static ric_status check_springs(const ric_study *study)
{
    const ric_model *m = ric_study_model(study);
    int n = ric_model_n_dof(m);
    double *omega = ric_calloc((size_t)n, sizeof *omega),
           *modes = ric_calloc((size_t)n * (size_t)n, sizeof *modes);
    bool *seen = ric_calloc((size_t)n, sizeof *seen);
    ric_status status = omega && modes && seen ? RIC_OK
                                               : ric_fail(RIC_E_NOMEM, "no memory for %d modes", n);
    if (!status && !(status = ric_model_frequencies(m, omega)) &&
        !(status = ric_model_seen(m, seen)))
        status = ric_model_modes(m, modes);
    for (int i = 0; i < ric_model_n_contact(m) && !status; i++) {
        ric_contact contact;
        if ((status = ric_model_contact(m, i, &contact)) || !ric_model_detached(m) ||
            m->spring[i] == 0)
            continue;
        double ratio = stiffness_ratio(study, &contact, modes, omega, seen);
        if (ratio > STIFFEST)
            status = ric_fail(RIC_E_INPUT,
                              "contact %d: its stiffness %g is %.2g times that of the structure "
                              "there, and in double "
                              "precision orbits are right up to %g times; take law: rigid, from "
                              "which they differ by "
                              "about one over the square root of that",
                              i + 1, contact.stiffness, ratio, STIFFEST);
    }
    free(omega);
    free(modes);
    free(seen);
    return status;
}

ric_status ric_explore_check(const ric_study *study)
{
    const double restitution = ric_model_restitution(ric_study_model(study));
    if (restitution != 1)
        return ric_fail(RIC_E_INPUT,
                        "model.restitution: %.10g loses energy, so that there are no families of "
                        "periodic orbits; an "
                        "atlas needs 1. For the atlas of the structure without losses write "
                        "`restitution: %.10g` at "
                        "the top of the study instead of in section model",
                        restitution, restitution);
    ric_status status = check_phases(study);
    return status ? status : check_springs(study);
}

static ric_status release(void *graph)
{
    ric_graph_free(graph);
    return RIC_OK;
}

/* What is left when the rows are made: the graph goes meanwhile, where there are threads. */
static ric_status write_atlas(ric_store *store, const ric_atlas *atlas, ric_graph **graph)
{
    const int workers = (*graph)->n_worker;
    ric_together_call *aside = workers > 1 ? ric_together_begin(release, *graph) : NULL;
    if (!aside) ric_graph_free(*graph);
    *graph = NULL;
    ric_status status = ric_store_write(store, atlas, workers);
    const ric_status released = ric_together_end(aside);
    return status ? status : released;
}

/* One run: what is in the file already is taken up, everything else is computed, the tables are
 * written at the end or on request to stop. */
ric_status ric_explore_with(const ric_study *study, const char *path, const ric_run_options *run,
                            const ric_explore_more *more, ric_atlas **out)
{
    ric_memory_spread(HEAP_BLOCKS);
    ric_store *store = NULL;
    ric_graph *graph = NULL;
    ric_atlas *atlas = NULL;
    char *starts = NULL, *labels = NULL;
    ric_status written = RIC_OK, status = RIC_OK;
    if (out) *out = NULL;
    if ((status = ric_explore_check(study))) return status;
    if ((status = ric_store_open(path, study, &store))) goto out;
    if ((status = ric_store_labels_get(store, &labels))) goto out;
    if ((status = ric_stored_work_check(store, study))) goto out;
    if ((status = ric_graph_create(study, store, &graph))) goto out;
    graph->crew = more->crew;
    graph->labels = labels;
    if ((status = ric_store_starts_get(store, &starts))) goto out;
    status = ric_starts_parse(ric_study_model(study), starts, &graph->starts);
    if (status == RIC_E_FORMAT) status = ric_store_refuse(store, "meta", "starts", ric_detail());
    if (status) goto out;
    /* the first that writes: all that the file holds has been read by now */
    if ((status = ric_store_set_solver(store, ric_continuation_version()))) goto out;
    status = ric_graph_explore(graph, run);
    if (status && status != RIC_E_INTERRUPTED) goto out;
    written = ric_rows_make(graph, study, status == RIC_OK, &atlas);
    if (!written && (atlas->finished || !more->worth || more->worth(more->user, atlas)))
        written = write_atlas(store, atlas, &graph);
    else ric_store_stage_drop(store);
    if (written) status = written;
    else if (!atlas->finished)
        status = ric_fail(RIC_E_INTERRUPTED,
                          "stopped on request; the same command goes on from here");
out:
    if (out && (!status || status == RIC_E_INTERRUPTED)) *out = atlas;
    else ric_atlas_free(atlas);
    ric_graph_free(graph);
    ric_store_close(store);
    free(starts);
    free(labels);
    return status;
}

/* An unfinished atlas that has not come as far as an earlier run of the same study does not take
 * its place. */
static bool has_come_as_far(void *user, const ric_atlas *unfinished)
{
    const ric_atlas *before = user;
    return !before || ric_atlas_contains(unfinished, before);
}

/* What the file has of the same study, or NULL. */
static ric_atlas *read_before(const ric_study *study, const char *path)
{
    ric_atlas *before = NULL;
    if (ric_atlas_read(path, &before)) return NULL; /* the run itself says what is wrong with it */
    if (!strcmp(ric_study_text(ric_atlas_study(before)), ric_study_text(study))) return before;
    ric_atlas_free(before);
    return NULL;
}

ric_status ric_explore(const ric_study *study, const char *path, const ric_run_options *run)
{
    ric_atlas *before = read_before(study, path);
    ric_status status = ric_explore_with(study, path, run,
                                         &(ric_explore_more){.worth = has_come_as_far,
                                                             .user = before},
                                         NULL);
    ric_atlas_free(before);
    return status;
}

/* --------------------------------------------------------- at the other end */

struct ric_explore_worker {
    ric_graph *graph;
};

ric_status ric_explore_worker_create(const ric_study *study, ric_explore_worker **out)
{
    ric_explore_worker *hand = ric_calloc(1, sizeof *hand);
    *out = NULL;
    if (!hand) return ric_no_memory("a worker");
    ric_status status = ric_graph_create(study, NULL, &hand->graph);
    if (!status) status = ric_cache_create(&hand->graph->recall.memo);
    if (status) ric_explore_worker_free(hand);
    else *out = hand;
    return status;
}

void ric_explore_worker_free(ric_explore_worker *hand)
{
    if (!hand) return;
    if (hand->graph) ric_cache_free(hand->graph->recall.memo);
    ric_graph_free(hand->graph);
    free(hand);
}

ric_cache *ric_explore_worker_prepare(ric_explore_worker *hand, ric_node *node, unsigned choice)
{
    ric_graph_prepare(hand->graph, node, choice);
    return hand->graph->recall.memo;
}

const ric_model *ric_explore_worker_model(const ric_explore_worker *hand)
{
    return hand->graph->model;
}
