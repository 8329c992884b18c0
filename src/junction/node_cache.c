#include "node_cache.h"

#include <stdlib.h>
#include <string.h>

#include "grazing_words.h"
#include "orbit/room.h"
#include "base/room.h"

/* -------------------------------------------------------------------- bytes */

enum { HEAD = 7 };

/* One that is read is made of its head. */
static void pass_cycle(ric_bytes *b, const ric_model *m, ric_periodic **cycle)
{
    ric_periodic *c = *cycle;
    int head[HEAD] = {0};
    if (c)
        memcpy(head,
               (int[HEAD]){c->n, c->N, c->half, c->pure, c->flip, c->parts, c->opposite != NULL},
               sizeof head);
    ric_bytes_pass(b, head, sizeof head);
    if (b->reading) {
        b->lost |= head[0] != m->n || head[1] < 0 || !ric_bytes_have(b, (size_t)head[1]) ||
                   head[5] < 0 || head[5] > RIC_PARTS_MOST;
        c = *cycle = b->lost ? NULL : ric_periodic_create(head[0], head[1]);
        b->lost |= !c;
        if (!c) return;
        c->half = head[2];
        c->pure = head[3];
        c->flip = head[4];
        c->parts = head[5];
    }
    ric_bytes_pass(b, &c->closed, sizeof c->closed);
    ric_bytes_pass(b, c->face, (size_t)c->N * sizeof *c->face);
    for (int i = 0; b->reading && i < c->N; i++)
        b->lost |= c->face[i] < -1 || c->face[i] >= m->n_face;
    ric_bytes_pass(b, c->tau, (size_t)c->N * sizeof *c->tau);
    ric_bytes_pass(b, c->w, 2 * (size_t)c->n * sizeof *c->w);
    if (!head[6]) return;
    double w[2 * c->n];
    if (c->opposite) memcpy(w, c->opposite, sizeof w);
    ric_bytes_pass(b, w, sizeof w);
    if (b->reading && !b->lost) b->lost = !ric_periodic_oppose(c, w);
}

typedef struct {
    const ric_model *model;
    ric_node *node;
} parcel;

/* As it is when it has just been made: without its depth, and what became of its departures. */
static void pass_node(ric_bytes *b, void *user)
{
    const parcel *p = user;
    ric_node *n = p->node, flat = *n;
    flat.cycle = NULL;
    flat.departures = NULL;
    flat.depth = 0;
    flat.expanded = false;
    ric_bytes_pass(b, &flat, sizeof flat);
    b->lost |= flat.n_touch < 0 || flat.n_touch > RIC_MAX_TOUCHES || flat.n_departure < 0 ||
               (b->reading && !ric_bytes_have(b, (size_t)flat.n_departure));
    if (b->lost) return;
    if (b->reading) {
        flat.cycle = NULL; /* whatever the bytes have there */
        flat.departures = NULL;
        *n = flat;
    }
    pass_cycle(b, p->model, &n->cycle);
    if (b->reading && !b->lost)
        n->departures = ric_calloc((size_t)n->n_departure + 1, sizeof *n->departures);
    b->lost |= !n->departures && n->n_departure > 0;
    for (int i = 0; i < n->n_departure && !b->lost; i++)
        ric_bytes_pass(b, &n->departures[i].choice, sizeof n->departures[i].choice);
}

ric_status ric_node_pack(const ric_node *node, void **bytes, size_t *size)
{
    ric_node copy = *node; /* what it points to is only read */
    *bytes = ric_bytes_make(pass_node, &(parcel){.node = &copy}, size);
    return *bytes ? RIC_OK : ric_no_memory("a junction");
}

ric_status ric_node_unpack(const ric_model *m, const void *bytes, size_t size, ric_node **out)
{
    ric_bytes b = ric_bytes_of(bytes, size);
    ric_node *node = ric_calloc(1, sizeof *node);
    *out = NULL;
    if (!node) return ric_no_memory("a junction");
    pass_node(&b, &(parcel){m, node});
    if (!b.lost) {
        node->springs = ric_periodic_springs(m);
        *out = node;
        return RIC_OK;
    }
    if (!node->departures) node->n_departure = 0;
    ric_node_free(node);
    return ric_fail(RIC_E_FORMAT, "the bytes of a junction are damaged");
}

/* -------------------------------------------------------------------- solving */

static ric_status compute(const ric_model *m, const ric_defining *solve, const ric_periodic *cycle,
                          ric_node **out)
{
    switch (solve->kind) {
    case RIC_DEFINING_ARRIVAL: return ric_node_arrival(m, cycle, out);
    case RIC_DEFINING_CORNER: return ric_node_corner(m, cycle, out);
    case RIC_DEFINING_GRAZING: return ric_node_grazing(m, cycle, out);
    case RIC_DEFINING_INTERIOR: return ric_node_interior(m, cycle, solve->test, out);
    case RIC_DEFINING_MULTIPLICATION:
        return ric_node_multiplication(m, cycle, solve->p, solve->q, out);
    case RIC_DEFINING_USER: return ric_node_user(m, cycle, &solve->asked, out);
    }
    return ric_fail(RIC_E_INPUT, "no such junction");
}

/* Everything that a junction depends on. */
typedef struct {
    const ric_defining *solve;
    ric_periodic *cycle;
} question;

static void pass_key(ric_bytes *b, void *user)
{
    const question *q = user;
    ric_periodic *cycle = q->cycle;
    int head[] = {'N',         (int)q->solve->kind, q->solve->test,
                  q->solve->p, q->solve->q,         q->solve->asked.frequency};
    double value = q->solve->asked.value;
    ric_bytes_pass(b, head, sizeof head);
    ric_bytes_pass(b, &value, sizeof value);
    pass_cycle(b, NULL, &cycle);
}

/* NULL without memory. */
static char *make_key(const ric_defining *solve, const ric_periodic *cycle, size_t *size)
{
    ric_periodic copy = *cycle; /* what it points to is only read */
    return ric_bytes_make(pass_key, &(question){solve, &copy}, size);
}

/* A junction that does not converge is kept as no bytes, one that is none as one. */
static void keep(ric_cache *memo, const char *key, size_t key_size, ric_status status,
                 const ric_node *node)
{
    void *bytes = NULL;
    size_t size = 0;
    if (status == RIC_E_NUMERIC || (!status && !node))
        ric_cache_put(memo, key, key_size, "", status ? 0 : 1);
    else if (!status && !ric_node_pack(node, &bytes, &size))
        ric_cache_put(memo, key, key_size, bytes, size);
    free(bytes);
}

ric_status ric_node_cache_solve(const ric_model *m, ric_node_cache recall, ric_defining solve,
                                const ric_periodic *cycle, ric_node **out)
{
    size_t key_size = 0, size = 0;
    char *key = recall.memo ? make_key(&solve, cycle, &key_size) : NULL;
    void *bytes = key && !recall.worker ? ric_cache_take(recall.memo, key, key_size, &size) : NULL;
    ric_status status;
    *out = NULL;
    if (bytes && size <= 1)
        status = size ? RIC_OK : ric_fail(RIC_E_NUMERIC, "a junction does not converge");
    else if (bytes) status = ric_node_unpack(m, bytes, size, out);
    else status = compute(m, &solve, cycle, out);
    const ric_status whole = ric_trust(RIC_OK);
    if (whole) { /* whatever was found, or was not */
        ric_node_free(*out);
        *out = NULL;
        status = whole;
    } else if (key && recall.worker) keep(recall.memo, key, key_size, status, *out);
    free(bytes);
    free(key);
    return status;
}

/* ------------------------------------------------------------------- touches */

/* An orbit with its touches, and which events were impacts; one that is read has none yet. */
typedef struct {
    const ric_model *model;
    ric_periodic *cycle;
    bool *kept;
} touched;

static void pass_touched(ric_bytes *b, void *user)
{
    touched *t = user;
    pass_cycle(b, t->model, &t->cycle);
    if (b->lost) return;
    const size_t n = (size_t)t->cycle->N;
    if (b->reading) b->lost |= !(t->kept = ric_calloc(n + 1, sizeof *t->kept));
    if (!b->lost) ric_bytes_pass(b, t->kept, n * sizeof *t->kept);
}

static void pass_touches_key(ric_bytes *b, void *user)
{
    const touched *t = user;
    ric_periodic *cycle = t->cycle;
    char head = 'T';
    ric_bytes_pass(b, &head, sizeof head);
    pass_cycle(b, NULL, &cycle);
}

/* None where there are more touches than are enumerated. */
static ric_periodic *read_touched(const ric_model *m, const void *bytes, size_t size, bool **kept)
{
    ric_bytes b = ric_bytes_of(bytes, size);
    touched t = {.model = m};
    if (size) pass_touched(&b, &t);
    if (b.lost) {
        ric_periodic_free(t.cycle);
        free(t.kept);
        t = (touched){0};
    }
    *kept = t.kept;
    return t.cycle;
}

static void keep_touched(ric_cache *memo, const char *key, size_t key_size, ric_periodic *cycle,
                         bool *kept)
{
    size_t size = 0;
    touched t = {.cycle = cycle, .kept = kept};
    void *bytes = cycle ? ric_bytes_make(pass_touched, &t, &size) : NULL;
    if (bytes || !cycle) ric_cache_put(memo, key, key_size, bytes ? bytes : "", size);
    free(bytes);
}

ric_periodic *ric_node_cache_touches(const ric_model *m, ric_node_cache recall,
                                     const ric_periodic *cycle, bool **kept)
{
    size_t key_size = 0, size = 0;
    ric_periodic copy = *cycle; /* what it points to is only read */
    char *key = recall.memo
                    ? ric_bytes_make(pass_touches_key, &(touched){.cycle = &copy}, &key_size)
                    : NULL;
    void *bytes = key && !recall.worker ? ric_cache_take(recall.memo, key, key_size, &size) : NULL;
    *kept = NULL;
    ric_periodic *full = bytes ? read_touched(m, bytes, size, kept)
                               : ric_grazing_words_touches(m, cycle, kept);
    if (key && recall.worker && !ric_trust(RIC_OK))
        keep_touched(recall.memo, key, key_size, full, *kept);
    free(bytes);
    free(key);
    return full;
}
