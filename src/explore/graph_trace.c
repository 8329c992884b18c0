/* From a departure to a trace of its branch: what an earlier run or a worker has kept of it, or the
 * trace itself, which is kept. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "junction/room.h"
#include "graph_parts.h"
#include "branch/room.h"

#define PARTS 16     /* of a period, between inner nodes, the first time that they are needed */
#define MORE_PARTS 4 /* and each time that they do not suffice */
#define MOST_PARTS 64
/* NO_BRANCH: of the size: what is lost nearer to its start than this is rounding beside a family of
 * more parameters, and no branch */
#define NO_BRANCH 1e-6

/* What is traced: departure `choice` of a node (side -1: the other way, at a branch that passes);
 * or the way back from the end of a trace of that departure, `along`, to its other end. */
typedef struct {
    const ric_limits *limits; /* outlive the trace */
    const ric_node *node;
    unsigned choice;
    int side;
    const ric_continuation *along;
} course;

/* The orbit of a junction, and what of it is left open there. Mirror images in a structure that is
 * none have energy, period and word in common, and so do orbits of several kernels: the state tells
 * them from each other. */
static uint64_t node_hash(const ric_node *node)
{
    const ric_periodic *c = node->cycle;
    const int form[] = {c->half, c->pure, c->flip, c->parts, node->test, node->n_touch};
    uint64_t hash = ric_bytes_hash(RIC_BYTES_HASH, form, sizeof form);
    hash = ric_bytes_hash(hash, &c->closed, sizeof c->closed);
    hash = ric_bytes_hash(hash, node->touch, (size_t)node->n_touch * sizeof *node->touch);
    hash = ric_bytes_hash(hash, c->face, (size_t)c->N * sizeof *c->face);
    hash = ric_bytes_hash(hash, c->tau, (size_t)c->N * sizeof *c->tau);
    return ric_bytes_hash(hash, c->w, 2 * (size_t)c->n * sizeof *c->w);
}

/* The text that names a trace for later runs: junction, departure, and everything that shapes the
 * outcome. */
static ric_status trace_key(const course *way, char *key, size_t size)
{
    const ric_limits *l = way->limits;
    const ric_node *node = way->node;
    uint64_t hash = node_hash(node);
    size_t used = ric_c_print(key, size, "%d %d %d/%d %a %a %u %d %a %a %a %a %a %d %016" PRIx64,
                              (int)node->kind, node->cycle->N, node->rotation[0], node->multiple,
                              node->energy, node->period, way->choice, way->side, l->energy[0],
                              l->energy[1], l->period[0], l->period[1], l->max_step, l->multiply,
                              hash);
    if (l->n_asked)
        used += ric_c_print(key + used, size - used, " %016" PRIx64,
                            ric_user_point_key(l->n_asked, l->asked));
    if (l->tongue_width > 0)
        used += ric_c_print(key + used, size - used, " leap %a", l->tongue_width);
    if (way->along) ric_c_print(key + used, size - used, " back");
    return ric_memory_failed() ? ric_no_memory("the name of a branch") : RIC_OK;
}

/* A trace that was broken off is kept beside those that are finished, with the attempt that it
 * belongs to. */
static const char *paused_key(const char *key, char *out, size_t size)
{
    snprintf(out, size, "%s" RIC_PAUSED, key);
    return out;
}

/* For later runs, or for the owner of the graph. */
static ric_status keep_trace(ric_graph *g, const char *key, const void *blob, size_t size)
{
    const ric_status whole = ric_trust(RIC_OK);
    if (whole) return whole;
    (g->owner ? g->owner : g)->fresh++;
    if (g->recall.worker) ric_cache_put(g->recall.memo, key, strlen(key), blob ? blob : "", size);
    if (!g->store) return RIC_OK;
    char name[1040];
    ric_status status = ric_store_trace_put(g->store, key, blob ? blob : "", size);
    return status ? status : ric_store_trace_drop(g->store, paused_key(key, name, sizeof name));
}

static ric_status keep_paused(ric_graph *g, const char *key, int parts, const ric_continuation *tr)
{
    char name[1040];
    void *blob = NULL;
    size_t size;
    ric_status status = ric_continuation_pause(tr, parts, &blob, &size);
    paused_key(key, name, sizeof name);
    if (!status && g->store) status = ric_store_trace_put(g->store, name, blob, size);
    else if (!status && g->recall.worker)
        ric_cache_put(g->recall.memo, name, strlen(name), blob, size);
    free(blob);
    return status;
}

/* *out stays NULL where there is none; what cannot be read is traced from its start. */
static ric_status take_paused(ric_graph *g, const ric_limits *limits, const char *key, int *parts,
                              ric_continuation **out)
{
    char name[1040];
    void *blob = NULL;
    size_t size = 0;
    ric_status status = RIC_OK;
    paused_key(key, name, sizeof name);
    *parts = 0;
    *out = NULL;
    if (g->store) status = ric_store_trace_get(g->store, name, &blob, &size);
    else if (g->recall.worker) {
        char lent[1100];
        int n = snprintf(lent, sizeof lent, "%s%s", RIC_LENT, name);
        blob = ric_cache_take(g->recall.memo, lent, (size_t)n, &size);
    }
    if (blob && ric_continuation_resume(g->model, limits, blob, size, parts, out) == RIC_E_NOMEM)
        status = RIC_E_NOMEM;
    free(blob);
    return status;
}

/* The start of a trace that goes from the end of `tr` back along it. */
static ric_status turn_back(const ric_continuation *tr, const ric_limits *limits,
                            ric_continuation **out)
{
    const unsigned ignore = 1u << RIC_TEST_E_MAX | 1u << RIC_TEST_E_MIN | 1u << RIC_TEST_F_MAX |
                            1u << RIC_TEST_F_MIN | 1u << RIC_TEST_REACH | 1u << RIC_TEST_APPROACH |
                            1u << RIC_TEST_FLIGHT | 1u << RIC_TEST_A | 1u << RIC_TEST_B |
                            1u << RIC_TEST_D | 1u << RIC_TEST_DET;
    ric_shooting *chain = ric_shooting_copy(tr->chain);
    double *back = chain ? ric_calloc((size_t)chain->n_unknown, sizeof *back) : NULL;
    if (!back) {
        ric_shooting_free(chain);
        return ric_no_memory("a branch");
    }
    for (int i = 0; i < chain->n_unknown; i++) back[i] = -tr->end.t[i];
    ric_status status = ric_continuation_create(chain, tr->end.u, back, ignore, limits, out);
    free(back);
    return status;
}

/* *out stays NULL where nothing admissible departs. */
static ric_status set_out(const ric_model *m, const course *way, const ric_node *node,
                          ric_continuation **out)
{
    ric_outset from;
    if (way->along) return turn_back(way->along, way->limits, out);
    ric_status status = ric_switching_depart(m, node, way->choice, way->side, &from);
    return status || !from.chain ? status : ric_outset_trace(&from, way->limits, out);
}

ric_status ric_graph_has_left(const ric_continuation *tr)
{
    const ric_point *last = ric_continuation_row(tr, tr->n_point - 1);
    double length = last->arclength, least = NO_BRANCH * tr->chain->scale;
    if (tr->stop != RIC_STOP_FAILED || length > least) return RIC_OK;
    return ric_fail(RIC_E_NUMERIC,
                    "the branch is lost %.1e from its start (%s), and not told apart from it",
                    length, ric_continuation_why_text(tr->why));
}

/* *out that is not NULL before is a trace that was broken off, and goes on; as it does after
 * RIC_E_INTERRUPTED. */
static ric_status trace_once(const ric_model *m, const course *way, const ric_node *node,
                             ric_continuation **out)
{
    ric_status status = *out ? RIC_OK : ric_trust(set_out(m, way, node, out));
    bool begun = !status;
    if (begun && *out) status = ric_continuation_run(*out);
    if (begun && !status && *out) ric_continuation_rest(*out);
    if (begun && !status && *out) status = ric_graph_has_left(*out);
    if (status && !(begun && status == RIC_E_INTERRUPTED)) {
        ric_continuation_free(*out);
        *out = NULL;
    }
    return status;
}

/* The next number of parts between inner nodes that is worth an attempt, 0: none. */
static int more_parts(const ric_model *m, const course *way, int parts)
{
    if (!ric_flight_law_of(m)->integrated || way->along) return 0;
    do parts = parts ? MORE_PARTS * parts : PARTS;
    while (parts <= way->node->cycle->parts);
    return parts <= MOST_PARTS ? parts : 0;
}

/* Under a power law a branch that is not found, or lost on the way, or whose residual is nothing
 * but rounding, is sought once more with inner nodes, and with more of them (shooting_nodes.h).
 * What the last attempt finds counts. *parts: the attempt, 0 the first; with *out it is one that
 * was broken off. */
static ric_status trace_in_parts(const ric_model *m, const course *way, int *parts,
                                 ric_continuation **out)
{
    for (;;) {
        ric_periodic cycle = *way->node->cycle;
        ric_node divided = *way->node; /* what it owns is only read */
        divided.cycle = &cycle;
        if (*parts) cycle.parts = *parts;
        ric_status status = trace_once(m, way, &divided, out);
        bool lost = *out && ((*out)->stop == RIC_STOP_FAILED || (*out)->steep);
        int more = status == RIC_E_NUMERIC || (!status && lost) ? more_parts(m, way, *parts) : 0;
        if (!more) return status;
        *parts = more;
        ric_continuation_free(*out);
        *out = NULL;
    }
}

static ric_status pack_outcome(ric_status status, const ric_continuation *tr, void **blob,
                               size_t *size)
{
    *size = 0;
    if (!status) return tr ? ric_continuation_pack(tr, blob, size) : RIC_OK;
    const char *why = ric_detail();
    *size = sizeof RIC_REFUSED + strlen(why);
    if (!(*blob = ric_malloc(*size))) return ric_fail(RIC_E_NOMEM, "no memory to keep a branch");
    snprintf(*blob, *size, "%s%s", RIC_REFUSED, why);
    return RIC_OK;
}

static ric_status unpack_outcome(const ric_model *m, const ric_limits *limits, const char *blob,
                                 size_t size, ric_continuation **out)
{
    size_t head = sizeof RIC_REFUSED - 1;
    if (size == 0) return RIC_OK;
    if (size > head && !memcmp(blob, RIC_REFUSED, head) && !blob[size - 1])
        return ric_fail(RIC_E_NUMERIC, "%s", blob + head);
    return ric_continuation_unpack(m, limits, blob, size, out);
}

static ric_status trace_course(ric_graph *g, const course *way, ric_continuation **out)
{
    char key[1024];
    void *blob = NULL;
    size_t size;
    int parts;
    ric_status status = RIC_OK;
    *out = NULL;
    if ((status = trace_key(way, key, sizeof key))) return status;
    if (g->store && (status = ric_store_trace_get(g->store, key, &blob, &size))) return status;
    bool stored = blob != NULL;
    if (!blob && g->recall.memo && !g->recall.worker)
        blob = ric_cache_take(g->recall.memo, key, strlen(key), &size);
    if (blob) {
        if (!stored) status = keep_trace(g, key, blob, size);
        if (!status) status = unpack_outcome(g->model, way->limits, blob, size, out);
        free(blob);
        return status;
    }
    if ((status = take_paused(g, way->limits, key, &parts, out))) return status;
    status = trace_in_parts(g->model, way, &parts, out);
    const ric_status whole = ric_trust(RIC_OK);
    if (whole) status = whole;
    if (status == RIC_E_INTERRUPTED && (*out || parts) && keep_paused(g, key, parts, *out))
        status = RIC_E_NOMEM;
    if ((!status || status == RIC_E_NUMERIC) && (g->store || g->recall.worker)) {
        ric_status kept = pack_outcome(status, *out, &blob, &size);
        if (!kept) kept = keep_trace(g, key, blob, size);
        if (kept) status = kept;
        else if (status)
            status = ric_fail(RIC_E_NUMERIC, "%s", (const char *)blob + sizeof RIC_REFUSED - 1);
    }
    if (status) {
        ric_continuation_free(*out);
        *out = NULL;
    }
    free(blob);
    return status;
}

/* A branch that comes to a region with multiplications of higher order is traced again, with an eye
 * on them. */
static ric_status trace_in_regions(ric_graph *g, course *way, ric_continuation **out)
{
    ric_status status = trace_course(g, way, out);
    if (status || !*out || way->limits == &g->deep ||
        !ric_region_multiplies(g->options, (*out)->n_point, (*out)->stride, (*out)->points))
        return status;
    ric_continuation_free(*out);
    way->limits = &g->deep;
    return trace_course(g, way, out);
}

ric_status ric_graph_trace(ric_graph *g, const ric_node *node, unsigned choice, int side,
                           ric_continuation **out)
{
    return trace_in_regions(g, &(course){&g->limits, node, choice, side, NULL}, out);
}

ric_status ric_graph_trace_back(ric_graph *g, const ric_node *node, unsigned choice, int side,
                                const ric_continuation *along, ric_continuation **out)
{
    return trace_in_regions(g, &(course){along->limits, node, choice, side, along}, out);
}

bool ric_graph_followed_before(ric_graph *g, const ric_node *node, unsigned choice)
{
    char key[1024];
    void *blob = NULL;
    size_t size;
    if (!g->store) return false;
    bool found = !trace_key(&(course){&g->limits, node, choice, 1, NULL}, key, sizeof key) &&
                 !ric_store_trace_get(g->store, key, &blob, &size) && blob;
    free(blob);
    return found;
}
