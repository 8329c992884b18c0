/* C_ab of the junctions of an atlas: taken from what an earlier run has measured, or measured and
 * kept. */
#include <inttypes.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/room.h"
#include "rows_parts.h"
#include "stored_work.h"
#include "junction/room.h"

#define SAVE_EVERY 1 /* seconds between commits of labels, at least */

typedef struct {
    ric_graph *graph;
    const ric_junction_row *junctions;
    ric_atlas *atlas;
    const ric_rows_task *first;
    pthread_mutex_t lock; /* of the store, of whom to ask, and of the numbers */
    int left, unmeasured;
    time_t saved;
} measuring;

static bool has_label(const ric_junction_row *junction)
{
    return junction->node && (junction->node->kind == RIC_KIND_EXTREMUM ||
                              junction->node->kind == RIC_KIND_BRANCH_POINT ||
                              junction->node->kind == RIC_KIND_MULTIPLICATION);
}

/* ------------------------------------------------------------------- keeping */

/* All that a label depends on, as the key of a trace is all that shapes a trace (graph_trace.c).
 */
static ric_status label_key(const ric_node *node, char *key, size_t size)
{
    const ric_periodic *c = node->cycle;
    uint64_t hash = RIC_BYTES_HASH;
    hash = ric_bytes_hash(hash, &c->closed, sizeof c->closed);
    hash = ric_bytes_hash(hash, c->face, (size_t)c->N * sizeof *c->face);
    hash = ric_bytes_hash(hash, c->tau, (size_t)c->N * sizeof *c->tau);
    hash = ric_bytes_hash(hash, c->w, 2 * (size_t)c->n * sizeof *c->w);
    ric_c_print(key, size, RIC_LABEL "%d %d %d %d %d %d %a %a %016" PRIx64, (int)node->kind, c->N,
                c->parts, c->half, c->pure, node->multiple, node->energy, node->period, hash);
    return ric_memory_failed() ? ric_no_memory("the name of a label") : RIC_OK;
}

/* Whether the label has been measured before. */
static bool recall(measuring *s, const char *key, ric_junction *row)
{
    void *blob = NULL;
    size_t size = 0;
    int32_t label[3] = {0};
    if (!s->graph->store) return false;
    pthread_mutex_lock(&s->lock);
    ric_status status = ric_store_trace_get(s->graph->store, key, &blob, &size);
    pthread_mutex_unlock(&s->lock);
    bool found = !status && blob && size == sizeof label;
    if (found) memcpy(label, blob, sizeof label);
    free(blob);
    found = found && label[0] >= 1 && label[1] >= 1;
    if (!found) return false;
    row->a = label[0];
    row->b = label[1];
    row->decided = label[2];
    return true;
}

static ric_status keep(measuring *s, const char *key, const ric_junction *row)
{
    const int32_t label[3] = {row->a, row->b, row->decided};
    ric_status status = RIC_OK;
    pthread_mutex_lock(&s->lock);
    s->graph->fresh++;
    if (s->graph->store) status = ric_store_trace_put(s->graph->store, key, label, sizeof label);
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    if (!status && s->graph->store && now.tv_sec - s->saved > SAVE_EVERY) {
        status = ric_store_commit(s->graph->store);
        s->saved = now.tv_sec;
    }
    pthread_mutex_unlock(&s->lock);
    return status;
}

/* ----------------------------------------------------------------- measuring */

/* One thread at a time shows how far all are; the others go by what it was told. */
static bool stopped(void *user)
{
    measuring *s = user;
    if (s->graph->stopping || pthread_mutex_trylock(&s->lock)) return s->graph->stopping;
    s->graph->progress.labels = s->left;
    s->graph->progress.open = 0;
    const bool stop = ric_graph_stopped(s->graph);
    pthread_mutex_unlock(&s->lock);
    return stop;
}

static void count(measuring *s, bool measured)
{
    pthread_mutex_lock(&s->lock);
    s->left--;
    s->unmeasured += !measured;
    pthread_mutex_unlock(&s->lock);
}

static ric_status measure_row(measuring *s, int i)
{
    const ric_node *node = s->junctions[i].node;
    ric_junction *row = &s->atlas->junctions[i].row;
    char key[300];
    ric_status status = RIC_OK;
    if (!has_label(&s->junctions[i])) return RIC_OK;
    if ((status = label_key(node, key, sizeof key))) {
        count(s, false);
        return status;
    }
    bool measured = recall(s, key, row);
    if (!measured && !stopped(s)) {
        ric_halt_ask(stopped, s);
        status = ric_trust(
            ric_multiplicity(s->graph->model, node, &row->a, &row->b, &row->decided));
        ric_halt_ask(NULL, NULL);
        measured = !status;
        if (measured) status = keep(s, key, row);
        else if (status == RIC_E_INTERRUPTED) status = RIC_OK;
    }
    if (!measured) row->a = row->b = 0;
    count(s, measured);
    return status;
}

static ric_status do_part(void *user, int i)
{
    measuring *s = user;
    const ric_rows_task *first = s->first;
    return i < first->n ? first->each(first->user, i) : measure_row(s, i - first->n);
}

ric_status ric_junction_rows_measure(ric_graph *g, const ric_junction_row *junctions,
                                     ric_atlas *atlas, const ric_rows_task *first)
{
    measuring work = {.graph = g, .junctions = junctions, .atlas = atlas, .first = first};
    for (int i = 0; i < atlas->n_junction; i++) work.left += has_label(&junctions[i]);
    pthread_mutex_init(&work.lock, NULL);
    ric_status status = ric_together(g->n_worker, first->n + atlas->n_junction, do_part, &work);
    pthread_mutex_destroy(&work.lock);
    atlas->finished = atlas->finished && !work.unmeasured;
    return status;
}
