#include "node_cache.h"

#include <stdlib.h>
#include <string.h>

#include "orbit/room.h"
#include "base/room.h"

/* -------------------------------------------------------------------- bytes */

enum { HEAD = 7 };

static size_t cycle_size(const ric_periodic *c)
{
    size_t states = c->opposite ? 2 : 1;
    return HEAD * sizeof(int32_t) + sizeof c->closed + (size_t)c->N * (sizeof(int32_t) + sizeof(double)) +
           states * 2 * (size_t)c->n * sizeof(double);
}

static void put(char **to, const void *from, size_t size)
{
    if (size) memcpy(*to, from, size);
    *to += size;
}

static void put_cycle(char **to, const ric_periodic *c)
{
    int32_t head[HEAD] = {c->n, c->N, c->half, c->pure, c->flip, c->parts, c->opposite != NULL};
    put(to, head, sizeof head);
    put(to, &c->closed, sizeof c->closed);
    for (int i = 0; i < c->N; i++) {
        int32_t face = c->face[i];
        put(to, &face, sizeof face);
    }
    put(to, c->tau, (size_t)c->N * sizeof *c->tau);
    put(to, c->w, 2 * (size_t)c->n * sizeof *c->w);
    if (c->opposite) put(to, c->opposite, 2 * (size_t)c->n * sizeof *c->w);
}

typedef struct {
    const char *at;
    size_t left;
    bool short_of; /* more was asked for than there is */
} source;

static void get(source *s, void *to, size_t size)
{
    s->short_of |= size > s->left;
    if (s->short_of) return;
    if (size) memcpy(to, s->at, size);
    s->at += size;
    s->left -= size;
}

static ric_periodic *get_cycle(const ric_model *m, source *s)
{
    int32_t head[HEAD] = {0};
    get(s, head, sizeof head);
    if (s->short_of || head[0] != m->n || head[1] < 0 || (size_t)head[1] > s->left || head[5] < 0 ||
        head[5] > RIC_PARTS_MOST)
        return NULL;
    ric_periodic *c = ric_periodic_create(head[0], head[1]);
    if (!c) return NULL;
    c->half = head[2];
    c->pure = head[3];
    c->flip = head[4];
    c->parts = head[5];
    get(s, &c->closed, sizeof c->closed);
    for (int i = 0; i < c->N; i++) {
        int32_t face = -1;
        get(s, &face, sizeof face);
        c->face[i] = face;
        s->short_of |= face < -1 || face >= m->n_face;
    }
    get(s, c->tau, (size_t)c->N * sizeof *c->tau);
    get(s, c->w, 2 * (size_t)c->n * sizeof *c->w);
    if (head[6]) {
        double w[2 * c->n];
        get(s, w, sizeof w);
        if (s->short_of || ric_periodic_oppose(c, w)) return c;
        ric_periodic_free(c);
        return NULL;
    }
    return c;
}

typedef struct {
    int32_t kind, n_touch, touch[RIC_MAX_TOUCHES], test, multiple, rotation[2], a, b, refusal, mode, mirrors,
        n_departure, frequency;
    double energy, period, asked;
} node_head;

ric_status ric_node_pack(const ric_node *node, void **bytes, size_t *size)
{
    *size = cycle_size(node->cycle) + sizeof(node_head) + (size_t)node->n_departure * sizeof(unsigned);
    char *to = *bytes = ric_malloc(*size);
    if (!to) return ric_no_memory("a junction");
    node_head h;
    memset(&h, 0, sizeof h);
    h = (node_head){.kind = (int32_t)node->kind,
                    .n_touch = node->n_touch,
                    .test = node->test,
                    .multiple = node->multiple,
                    .rotation = {node->rotation[0], node->rotation[1]},
                    .a = node->a,
                    .b = node->b,
                    .refusal = (int32_t)node->refusal,
                    .mode = node->mode,
                    .mirrors = node->mirrors,
                    .n_departure = node->n_departure,
                    .frequency = node->asked.frequency,
                    .energy = node->energy,
                    .period = node->period,
                    .asked = node->asked.value};
    for (int i = 0; i < node->n_touch; i++) h.touch[i] = node->touch[i];
    put(&to, &h, sizeof h);
    put_cycle(&to, node->cycle);
    for (int i = 0; i < node->n_departure; i++) put(&to, &node->departures[i].choice, sizeof(unsigned));
    return RIC_OK;
}

ric_status ric_node_unpack(const ric_model *m, const void *bytes, size_t size, ric_node **out)
{
    source s = {bytes, size, false};
    node_head h;
    memset(&h, 0, sizeof h);
    get(&s, &h, sizeof h);
    ric_node *node = ric_calloc(1, sizeof *node);
    *out = NULL;
    if (!node) return ric_no_memory("a junction");
    s.short_of |= h.n_touch < 0 || h.n_touch > RIC_MAX_TOUCHES || h.n_departure < 0 || (size_t)h.n_departure > s.left;
    if (!s.short_of) node->cycle = get_cycle(m, &s);
    if (!s.short_of) node->departures = ric_calloc((size_t)h.n_departure + 1, sizeof *node->departures);
    if (s.short_of || !node->cycle || !node->departures) goto damaged;
    node->n_departure = h.n_departure;
    for (int i = 0; i < h.n_departure; i++) get(&s, &node->departures[i].choice, sizeof(unsigned));
    if (s.short_of) goto damaged;
    node->kind = (ric_kind)h.kind;
    node->n_touch = h.n_touch;
    for (int i = 0; i < h.n_touch; i++) node->touch[i] = h.touch[i];
    node->test = h.test;
    node->multiple = h.multiple;
    node->rotation[0] = h.rotation[0];
    node->rotation[1] = h.rotation[1];
    node->a = h.a;
    node->b = h.b;
    node->energy = h.energy;
    node->period = h.period;
    node->refusal = (ric_refusal)h.refusal;
    node->asked = (ric_user_point){h.frequency, h.asked};
    node->mode = h.mode;
    node->mirrors = h.mirrors;
    node->springs = ric_periodic_springs(m);
    *out = node;
    return RIC_OK;
damaged:
    ric_node_free(node);
    return ric_fail(RIC_E_FORMAT, "the bytes of a junction are damaged");
}

/* -------------------------------------------------------------------- solving */

static ric_status compute(const ric_model *m, const ric_defining *solve, const ric_periodic *cycle, ric_node **out)
{
    switch (solve->kind) {
    case RIC_DEFINING_ARRIVAL: return ric_node_arrival(m, cycle, out);
    case RIC_DEFINING_CORNER: return ric_node_corner(m, cycle, out);
    case RIC_DEFINING_GRAZING: return ric_node_grazing(m, cycle, out);
    case RIC_DEFINING_INTERIOR: return ric_node_interior(m, cycle, solve->test, out);
    case RIC_DEFINING_MULTIPLICATION: return ric_node_multiplication(m, cycle, solve->p, solve->q, out);
    case RIC_DEFINING_USER: return ric_node_user(m, cycle, &solve->asked, out);
    }
    return ric_fail(RIC_E_INPUT, "no such junction");
}

/* Everything that the junction depends on; NULL without memory. */
static char *make_key(const ric_defining *solve, const ric_periodic *cycle, size_t *size)
{
    int32_t head[] = {'N', (int32_t)solve->kind, solve->test, solve->p, solve->q, solve->asked.frequency};
    *size = sizeof head + sizeof solve->asked.value + cycle_size(cycle);
    char *key = ric_malloc(*size), *to = key;
    if (!key) return NULL;
    put(&to, head, sizeof head);
    put(&to, &solve->asked.value, sizeof solve->asked.value);
    put_cycle(&to, cycle);
    return key;
}

/* A junction that does not converge is kept as no bytes, one that is none as one. */
static void keep(ric_cache *memo, const char *key, size_t key_size, ric_status status, const ric_node *node)
{
    void *bytes = NULL;
    size_t size = 0;
    if (status == RIC_E_NUMERIC || (!status && !node)) ric_cache_put(memo, key, key_size, "", status ? 0 : 1);
    else if (!status && !ric_node_pack(node, &bytes, &size)) ric_cache_put(memo, key, key_size, bytes, size);
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
    if (bytes && size <= 1) status = size ? RIC_OK : ric_fail(RIC_E_NUMERIC, "a junction does not converge");
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
