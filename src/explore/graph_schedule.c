/* The order of work: which departures lie within the budgets, in what order they are taken, and
 * what is handed to workers ahead of that. */
#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "graph_parts.h"
#include "base/room.h"

#define SAVE_EVERY 1.0  /* seconds between commits of finished traces */
#define NANOSECONDS 1e9 /* in a second */

static double seconds_since(const struct timespec *start)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)(now.tv_sec - start->tv_sec) +
           (double)(now.tv_nsec - start->tv_nsec) / NANOSECONDS;
}

/* Shows how far the owner has come and asks whether to stop. */
static bool stopped(void *user)
{
    ric_graph *g = user;
    if (!g->run || !g->run->progress) return false;
    g->progress.branches = g->n_edge;
    g->progress.junctions = g->n_node;
    g->progress.fresh = g->fresh;
    g->progress.seconds = seconds_since(&g->start);
    if (g->run->progress(&g->progress, g->run->user)) g->stopping = true;
    return g->stopping;
}

bool ric_graph_stopped(ric_graph *g)
{
    return stopped(g);
}

/* The same for a worker, who follows the owner. */
static bool owner_stopped(void *user)
{
    return ((ric_graph *)user)->stopping;
}

/* A step of a trace is kept, even if the trace itself is not finished (continuation_pause.h). */
static void count_step(void *user)
{
    ((ric_graph *)user)->fresh++;
}

/* `multiple`: of the node, or that of a duplicate of it. */
static ric_budgets budgets_at(const ric_graph *g, const ric_node *node, int multiple)
{
    return ric_region_budgets(g->options, node->energy * g->model->energy_unit,
                              RIC_TWO_PI / node->period * g->model->omega_ref, multiple);
}

/* Whether a multiplication is larger than asked for; or, on a cascade, a departure is none of its
 * steps. What starts from a mode, and what goes on beyond a corner, belongs to any. */
static bool astray(const ric_graph *g, const ric_node *node, unsigned choice, int multiply)
{
    const ric_explore_options *o = g->options;
    if (o->n_cascade == 0)
        return choice != RIC_THROUGH && (node->multiple > multiply || o->base % node->multiple);
    if (node->depth == 0 || node->kind == RIC_KIND_CORNER) return false;
    return node->depth > o->n_cascade || !ric_node_leaves(node, choice) ||
           node->multiple != o->cascade[node->depth - 1];
}

static bool over_budget(const ric_graph *g, const ric_node *node, unsigned choice,
                        ric_budget *which)
{
    /* the original of a duplicate may lie outside the frequency window */
    double period = node->period *
                    (choice != RIC_THROUGH || node->kind == RIC_KIND_GRAZING ? node->multiple : 1);
    const ric_budgets here = budgets_at(g, node, node->multiple);
    const bool outside = !here.inside &&
                         node->depth > 0; /* modes start wherever branches are followed */
    *which = period < g->limits.period[0] || period > g->limits.period[1] || outside
                 ? RIC_BUDGET_WINDOW
             : astray(g, node, choice, here.multiply)        ? RIC_BUDGET_MULTIPLY
             : ric_node_impacts(node, choice) > here.impacts ? RIC_BUDGET_IMPACTS
             : g->options->symmetric_only && !ric_node_half(g->model, node, choice)
                 ? RIC_BUDGET_SYMMETRIC
                 : RIC_N_BUDGET;
    return *which != RIC_N_BUDGET;
}

static bool is_linear(const ric_node *node, unsigned choice)
{
    return node->kind == RIC_KIND_GRAZING && ric_node_impacts(node, choice) == 0;
}

static ric_status take(ric_graph *g, int index, int place, int depth)
{
    ric_node *node = g->nodes[index];
    ric_departure *d = &node->departures[place];
    unsigned choice = d->choice;
    ric_status status = RIC_OK;
    if (is_linear(node, choice)) {
        d->state = RIC_DEPARTURE_KNOWN; /* the linear mode itself */
        return RIC_OK;
    }
    if (over_budget(g, node, choice, &d->budget)) {
        d->state = RIC_DEPARTURE_OVER_BUDGET;
        return RIC_OK;
    }
    if (d->job && !ric_workers_await(g->workers, d->job, stopped, g))
        return ric_fail(RIC_E_INTERRUPTED, "stopped on request");
    if (node->kind == RIC_KIND_CORNER)
        depth--; /* the same branch goes on with two letters exchanged */
    if (ric_node_passes(node, choice)) {
        /* where two branches of one symmetry cross, the edges that pass have said which they are */
        bool crossing = node->kind == RIC_KIND_BRANCH_POINT && node->test == RIC_TEST_DET;
        for (int i = 0; choice == RIC_THROUGH && !crossing && i < g->n_edge; i++) {
            double where;
            /* a branch that ends here has left, it does not pass */
            if (g->edges[i].from == index || g->edges[i].to == index ||
                !ric_graph_edge_contains(g->model, &g->edges[i], node, &where))
                continue;
            d->state = RIC_DEPARTURE_KNOWN;
            return node->kind == RIC_KIND_START
                       ? RIC_OK
                       : ric_graph_edge_attach(&g->edges[i], index, choice, where);
        }
        status = ric_graph_follow_through(g, index, choice, depth);
        node->departures[place].state = RIC_DEPARTURE_TAKEN;
    } else {
        bool taken = false;
        d->state = RIC_DEPARTURE_TAKEN;
        status = ric_graph_follow(g, index, choice, depth, &taken);
        if (!status && !taken) node->departures[place].state = RIC_DEPARTURE_INADMISSIBLE;
    }
    const ric_status whole = ric_trust(RIC_OK);
    if (whole) status = whole;
    if (status == RIC_E_INTERRUPTED || status == RIC_E_NOMEM)
        node->departures[place].state = RIC_DEPARTURE_OPEN;
    if (status == RIC_E_NUMERIC) {
        node->departures[place].state = RIC_DEPARTURE_REFUSED;
        node->departures[place].why = ric_strdup(ric_detail());
        status = RIC_OK;
    }
    return status;
}

typedef struct {
    int index, place;
    const ric_node *node;
} open_departure;

static int departure_order(const void *a, const void *b)
{
    const open_departure *p = a, *q = b;
    int order = p->index == q->index ? 0 : ric_graph_node_order(p->node, q->node);
    if (order) return order;
    return p->index != q->index ? p->index - q->index : p->place - q->place;
}

/* Any order will do: Fisher and Yates' shuffle with the generator xorshift64. */
static void shuffle(uint64_t seed, int n, open_departure *list)
{
    for (int i = n - 1; i > 0; i--) {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        int j = (int)(seed % (uint64_t)(i + 1));
        open_departure moved = list[i];
        list[i] = list[j];
        list[j] = moved;
    }
}

/* Whether nothing more is departed to, but from linear modes. What regions ask for has budgets of
 * its own. */
static bool spent(const ric_graph *g)
{
    return g->options->points > 0 && g->counted >= g->options->points;
}

/* After every departure in the order of the owner, so that it does not matter who else works: the
 * new branches. */
static void count_points(ric_graph *g, const ric_node *node, int first)
{
    if (budgets_at(g, node, node->multiple).raised) return;
    for (int i = first; i < g->n_edge; i++)
        g->counted += g->edges[i].trace ? g->edges[i].trace->n_point : 0;
}

/* At the last depth of the budget only corners are left: what goes on there is the same branch.
 * Likewise where there are as many points as may be; regions that are asked for have budgets of
 * their own. */
static bool reached(const ric_graph *g, const ric_node *node)
{
    const ric_budgets here = budgets_at(g, node, node->multiple);
    int limit = spent(g) && node->depth > 0 && !here.raised ? node->depth : here.depth;
    return node->depth < limit || (node->depth == limit && node->kind == RIC_KIND_CORNER);
}

/* Open departures at `depth` of node `first` and those after it, sorted; NULL with *n = 0 when
 * there is none. */
static open_departure *open_at(ric_graph *g, int first, int depth, int *n)
{
    int count = 0;
    for (int pass = 0;; pass++) {
        open_departure *list = pass ? ric_malloc((size_t)(count ? count : 1) * sizeof *list) : NULL;
        int k = 0;
        for (int i = first; i < g->n_node; i++)
            for (int j = 0; j < g->nodes[i]->n_departure; j++) {
                if (g->nodes[i]->depth != depth ||
                    g->nodes[i]->departures[j].state != RIC_DEPARTURE_OPEN)
                    continue;
                if (!reached(g, g->nodes[i])) continue;
                if (list) list[k] = (open_departure){i, j, g->nodes[i]};
                k++;
            }
        count = k;
        if (!pass) continue;
        *n = list ? count : 0;
        if (list) qsort(list, (size_t)count, sizeof *list, departure_order);
        return list;
    }
}

/* Grazings at `depth` gone through several times are junctions, too: those from which some branch
 * can leave within the budgets. */
static ric_status list_duplicates(ric_graph *g, int depth)
{
    for (int i = 0; i < g->n_node; i++) {
        ric_node *node = g->nodes[i];
        if (node->kind != RIC_KIND_GRAZING || node->multiple > 1 || node->depth != depth ||
            node->expanded || node->refusal)
            continue;
        node->expanded = true;
        int flown = ric_periodic_impacts(node->springs, node->cycle) - node->n_touch;
        for (int k = 2; k <= g->largest.multiply && k * node->period <= g->limits.period[1]; k++) {
            ric_node *duplicate = NULL;
            const ric_budgets here = budgets_at(g, node, k);
            if (g->options->base % k || k > here.multiply || k * flown >= here.impacts ||
                depth >= here.depth)
                continue;
            ric_status status = ric_node_duplicate(g->model, node, k, &duplicate);
            if (status) return status;
            if (ric_graph_add(g, duplicate, depth) < 0) return ric_no_memory("a junction");
            node = g->nodes[i];
        }
    }
    return RIC_OK;
}

/* Now and then what was traced is made safe against a kill. */
static ric_status save_now_and_then(ric_graph *g, double *saved)
{
    double now = seconds_since(&g->start);
    if (!g->store || now - *saved < SAVE_EVERY) return RIC_OK;
    *saved = now;
    return ric_store_commit(g->store);
}

static void refuse_all(ric_graph *g, const char *why)
{
    for (int i = 0; i < g->n_node; i++)
        for (int j = 0; j < g->nodes[i]->n_departure; j++) {
            bool linear = ric_model_detached(g->model) &&
                          ric_node_impacts(g->nodes[i], g->nodes[i]->departures[j].choice) == 0;
            free(g->nodes[i]->departures[j].why);
            g->nodes[i]->departures[j].state = linear ? RIC_DEPARTURE_KNOWN : RIC_DEPARTURE_REFUSED;
            g->nodes[i]->departures[j].why = linear ? NULL : ric_strdup(why);
        }
}

void ric_graph_prepare(void *graph, ric_node *node, unsigned choice)
{
    ric_memory_clear();
    ric_graph *g = graph;
    ric_graph *alone = ric_calloc(1, sizeof *alone);
    if (!alone) {
        ric_node_free(node);
        return;
    }
    *alone = (ric_graph){.model = g->model,
                         .options = g->options,
                         .limits = g->limits,
                         .deep = g->deep,
                         .largest = g->largest,
                         .recall = {g->recall.memo, true},
                         .owner = g};
    alone->limits.stepped = alone->deep.stepped = count_step;
    alone->limits.user = alone->deep.user = g;
    ric_halt_ask(owner_stopped, g);
    for (int i = 0; i < node->n_departure; i++) node->departures[i].job = 0;
    if (ric_graph_append(alone, node) == 0)
        for (int i = 0; i < node->n_departure; i++)
            if (node->departures[i].choice == choice)
                take(alone, 0, i, 1); /* an error is met again by the owner */
    ric_halt_ask(NULL, NULL);
    ric_graph_free(alone);
}

/* Of a branch that passes, the owner may come to know an edge that it is part of: of ten that are
 * open still one. */
static bool is_worth(ric_graph *g, const ric_node *node, ric_departure *d)
{
    return d->state == RIC_DEPARTURE_OPEN && !d->job && !is_linear(node, d->choice) &&
           !over_budget(g, node, d->choice, &d->budget) &&
           !ric_graph_followed_before(g, node, d->choice);
}

/* n ways out of one node. */
static void offer_node(ric_graph *g, int n, const open_departure *list)
{
    const ric_node *node = list->node;
    ric_workers_node *shared = NULL;
    for (int i = 0; i < n; i++) {
        ric_departure *d = &node->departures[list[i].place];
        if (!is_worth(g, node, d) || (!shared && !(shared = ric_workers_share(node)))) continue;
        d->job = ric_workers_offer(g->workers, shared, d->choice);
    }
    ric_workers_unshare(shared);
}

/* Of the ways out of one node those with most impacts first: they take longest, and one that is
 * begun last keeps everybody waiting. Across nodes in the order of the owner, who otherwise finds
 * out too late that two of them are the ends of one branch. */
static int offer_order(const void *a, const void *b)
{
    const open_departure *p = a, *q = b;
    int less = p->index != q->index
                   ? 0
                   : ric_node_impacts(q->node, q->node->departures[q->place].choice) -
                         ric_node_impacts(p->node, p->node->departures[p->place].choice);
    return less ? less : departure_order(a, b);
}

/* What the owner comes to next. */
static void offer(ric_graph *g, int n, const open_departure *list)
{
    /* without memory nothing is prepared */
    open_departure *order = g->workers && n ? ric_malloc((size_t)n * sizeof *order) : NULL;
    if (!order) return;
    memcpy(order, list, (size_t)n * sizeof *order);
    qsort(order, (size_t)n, sizeof *order, offer_order);
    for (int i = 0, k; i < n; i = k) {
        for (k = i + 1; k < n && order[k].index == order[i].index;) k++;
        offer_node(g, k - i, order + i);
    }
    free(order);
}

/* Departures of the next depth as far as they are known, so that no worker is idle while the last
 * ones of this depth are followed. Each node is looked at once. */
static void offer_ahead(ric_graph *g, int depth, int limit, int *seen)
{
    int n;
    if (!g->workers || depth + 1 > limit || ric_workers_waiting(g->workers) > 0) return;
    open_departure *list = open_at(g, *seen, depth + 1, &n);
    *seen = g->n_node;
    offer(g, n, list);
    free(list);
}

static ric_status take_counted(ric_graph *g, int index, int place, int depth)
{
    const int before = g->n_edge;
    ric_status status = take(g, index, place, depth);
    count_points(g, g->nodes[index], before);
    return status;
}

static ric_status explore(ric_graph *g, const ric_run_options *run)
{
    clock_gettime(CLOCK_MONOTONIC, &g->start);
    g->run = run;
    g->stopping = false;
    ric_memory_clear();
    g->limits.stepped = g->deep.stepped = count_step;
    g->limits.user = g->deep.user = g;
    ric_halt_ask(stopped, g);
    ric_status status = ric_graph_start(g);
    if (status) return status;
    if (g->model->n_part > 1) {
        refuse_all(g, "the structure falls into parts that no contact joins: their energies are "
                      "conserved one by one; "
                      "study each part alone");
        return RIC_OK;
    }
    double saved = 0;
    g->counted = 0;
    int limit = g->largest.depth;
    for (int depth = 0; depth <= limit && !status; depth++) {
        int n = 0, seen = 0;
        bool deeper = false;
        do {
            /* edges found at this depth may add nodes of the same depth (a branch met from its
             * side): repeat until none is open */
            if (depth < limit && !(spent(g) && depth > 0) && !g->options->n_cascade &&
                (status = list_duplicates(g, depth)))
                break;
            open_departure *list = open_at(g, 0, depth, &n);
            if (g->shuffle) shuffle(g->shuffle, n, list);
            offer(g, n, list);
            for (int i = 0; i < n && !status; i++) {
                if (g->nodes[list[i].index]->departures[list[i].place].state != RIC_DEPARTURE_OPEN)
                    continue;
                if (!reached(g, g->nodes[list[i].index])) continue;
                g->progress.open = n - i;
                g->progress.depth = depth;
                if (stopped(g)) status = ric_fail(RIC_E_INTERRUPTED, "stopped on request");
                else status = take_counted(g, list[i].index, list[i].place, depth + 1);
                if (!status) status = save_now_and_then(g, &saved);
                offer_ahead(g, depth, limit, &seen);
            }
            free(list);
        } while (n && !status);
        for (int i = 0; i < g->n_node; i++) deeper |= g->nodes[i]->depth > depth;
        if (!deeper) break;
    }
    status = ric_trust(status);
    return status ? status : ric_graph_settle(g);
}

/* What workers have left and nobody has asked for: finished traces, and traces that were broken
 * off. Their keys are texts that begin with a digit (graph_trace.c), those of junctions do not
 * (node_cache.c). */
static void save_left(const void *key, size_t key_size, const void *value, size_t size, void *user)
{
    ric_store *store = user;
    char text[1024];
    if (key_size >= sizeof text || !isdigit(*(const unsigned char *)key)) return;
    memcpy(text, key, key_size);
    text[key_size] = 0;
    ric_store_trace_put(store, text, value, size); /* what cannot be kept is computed again */
    if (!strstr(text, RIC_PAUSED) && key_size + sizeof RIC_PAUSED <= sizeof text)
        ric_store_trace_drop(store, strcat(text, RIC_PAUSED));
}

/* Workers go on with what was broken off, too, and have no store. */
static ric_status lend(void *user, const char *key)
{
    ric_graph *g = user;
    void *blob = NULL;
    size_t size = 0;
    ric_status status = ric_store_trace_get(g->store, key, &blob, &size);
    char name[1100];
    int n = snprintf(name, sizeof name, "%s%s", RIC_LENT, key);
    if (!status && blob && n < (int)sizeof name)
        ric_cache_put(g->recall.memo, name, (size_t)n, blob, size);
    free(blob);
    return status;
}

ric_status ric_graph_explore(ric_graph *g, const ric_run_options *run)
{
    ric_status status = RIC_OK;
    g->n_worker = run && run->workers > 1 ? run->workers : 1;
    if (g->n_worker > 1 || g->crew) {
        if ((status = ric_cache_create(&g->recall.memo))) goto out;
        if (g->store && (status = ric_store_trace_keys(g->store, RIC_PAUSED, lend, g))) goto out;
        if ((status = ric_workers_create(g->n_worker > 1 ? g->n_worker : 0, ric_graph_prepare, g,
                                         &g->workers)))
            goto out;
    }
    if (g->workers && g->store) ric_store_aside(g->store);
    if (g->crew && (status = g->crew->join(g->crew->user, g->study, g->workers, g->recall.memo)))
        goto out;
    status = explore(g, run);
    if (g->crew) g->crew->leave(g->crew->user);
out:
    ric_halt_ask(NULL, NULL);
    ric_workers_free(g->workers);
    if (status == RIC_E_INTERRUPTED && g->store && g->recall.memo)
        ric_cache_drain(g->recall.memo, save_left, g->store);
    const ric_status kept = g->store ? ric_store_rejoin(g->store) : RIC_OK;
    if (kept && (!status || status == RIC_E_INTERRUPTED)) status = kept;
    ric_cache_free(g->recall.memo);
    g->workers = NULL;
    g->recall.memo = NULL;
    return status;
}
