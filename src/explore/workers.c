#include "workers.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <time.h>

#include "base/room.h"

typedef enum { WAITING, IN_HAND, DONE } job_state;

struct ric_workers_node {
    atomic_int users; /* jobs that wait, and who offers them */
    ric_node *node;
};

typedef struct {
    job_state state;
    ric_workers_node *node; /* while it waits */
    unsigned choice;
} job;

struct ric_workers {
    pthread_mutex_t lock;
    pthread_cond_t offered, finished;
    ric_prepare *prepare;
    void *user;
    bool stop;
    int n_thread;
    pthread_t *threads;
    int n_job, capacity, first, waiting; /* no job before `first` waits */
    int urgent;                          /* number of the job that the owner needs next; 0: any */
    job *jobs;
};

/* The next job that waits, -1: none. */
static int next_job(ric_workers *w)
{
    if (w->urgent && w->jobs[w->urgent - 1].state == WAITING) return w->urgent - 1;
    while (w->first < w->n_job && w->jobs[w->first].state != WAITING) w->first++;
    return w->first < w->n_job ? w->first : -1;
}

ric_workers_node *ric_workers_share(const ric_node *node)
{
    ric_workers_node *shared = ric_calloc(1, sizeof *shared);
    if (shared) shared->node = ric_node_copy(node);
    if (shared && shared->node) {
        atomic_init(&shared->users, 1);
        return shared;
    }
    free(shared);
    return NULL;
}

void ric_workers_unshare(ric_workers_node *shared)
{
    if (!shared || atomic_fetch_sub(&shared->users, 1) > 1) return;
    ric_node_free(shared->node);
    free(shared);
}

/* The node for the caller alone, who gives up its share: the last one needs no copy. NULL without
 * memory. */
static ric_node *take_share(ric_workers_node *shared)
{
    ric_node *node = NULL;
    if (atomic_load(&shared->users) > 1) node = ric_node_copy(shared->node);
    else {
        node = shared->node;
        shared->node = NULL;
    }
    ric_workers_unshare(shared);
    return node;
}

/* Job i is in hand from now on; its share of the node is the caller's. With the lock held. */
static ric_workers_node *claim(ric_workers *w, int i)
{
    ric_workers_node *shared = w->jobs[i].node;
    w->jobs[i].state = IN_HAND;
    w->jobs[i].node = NULL;
    w->waiting--;
    return shared;
}

/* Job i is done. The owner is woken for the one that it waits for alone: what it is woken for in
 * vain keeps the lock from those who work. With the lock held. */
static void finish(ric_workers *w, int i)
{
    w->jobs[i].state = DONE;
    if (w->urgent == i + 1) pthread_cond_signal(&w->finished);
}

/* Does job i, with the lock held before and after but not meanwhile. */
static void work(ric_workers *w, int i)
{
    ric_workers_node *shared = claim(w, i);
    unsigned choice = w->jobs[i].choice;
    pthread_mutex_unlock(&w->lock);
    ric_node *node = take_share(shared);
    if (node) w->prepare(w->user, node, choice);
    pthread_mutex_lock(&w->lock);
    finish(w, i);
}

static void *serve(void *argument)
{
    ric_workers *w = argument;
    ric_memory_spread(RIC_SPREAD_THREAD);
    pthread_mutex_lock(&w->lock);
    while (!w->stop) {
        int i = next_job(w);
        if (i >= 0) work(w, i);
        else pthread_cond_wait(&w->offered, &w->lock);
    }
    pthread_mutex_unlock(&w->lock);
    return NULL;
}

ric_status ric_workers_create(int n, ric_prepare *prepare, void *user, ric_workers **out)
{
    ric_workers *w = ric_calloc(1, sizeof *w);
    *out = NULL;
    if (w) w->threads = ric_calloc((size_t)n + 1, sizeof *w->threads);
    if (!w || !w->threads) {
        free(w);
        return ric_fail(RIC_E_NOMEM, "no memory for %d workers", n);
    }
    w->prepare = prepare;
    w->user = user;
    pthread_mutex_init(&w->lock, NULL);
    pthread_cond_init(&w->offered, NULL);
    pthread_cond_init(&w->finished, NULL);
    for (; w->n_thread < n; w->n_thread++)
        if (pthread_create(&w->threads[w->n_thread], NULL, serve, w)) {
            ric_status status =
                ric_fail(RIC_E_NOMEM,
                         "the system gives no more than %d threads; run with fewer workers",
                         w->n_thread);
            ric_workers_free(w);
            return status;
        }
    *out = w;
    return RIC_OK;
}

void ric_workers_free(ric_workers *w)
{
    if (!w) return;
    pthread_mutex_lock(&w->lock);
    w->stop = true;
    pthread_cond_broadcast(&w->offered);
    pthread_mutex_unlock(&w->lock);
    for (int i = 0; i < w->n_thread; i++) pthread_join(w->threads[i], NULL);
    for (int i = 0; i < w->n_job; i++) ric_workers_unshare(w->jobs[i].node);
    pthread_cond_destroy(&w->finished);
    pthread_cond_destroy(&w->offered);
    pthread_mutex_destroy(&w->lock);
    free(w->jobs);
    free(w->threads);
    free(w);
}

int ric_workers_offer(ric_workers *w, ric_workers_node *node, unsigned choice)
{
    int number = 0;
    pthread_mutex_lock(&w->lock);
    if (w->n_job == w->capacity) {
        int capacity = w->capacity ? 2 * w->capacity : 256;
        job *grown = ric_realloc(w->jobs, (size_t)capacity * sizeof *grown);
        if (grown) {
            w->jobs = grown;
            w->capacity = capacity;
        }
    }
    if (w->n_job < w->capacity) {
        atomic_fetch_add(&node->users, 1);
        w->jobs[w->n_job++] = (job){.state = WAITING, .node = node, .choice = choice};
        w->waiting++;
        number = w->n_job;
        pthread_cond_signal(&w->offered);
    }
    pthread_mutex_unlock(&w->lock);
    return number;
}

/* With the lock held. */
static void withdraw(ric_workers *w, job *j)
{
    if (j->state != WAITING) return;
    ric_workers_unshare(j->node);
    j->node = NULL;
    j->state = DONE;
    w->waiting--;
}

void ric_workers_withdraw(ric_workers *w, int number)
{
    pthread_mutex_lock(&w->lock);
    withdraw(w, &w->jobs[number - 1]);
    pthread_mutex_unlock(&w->lock);
}

/* Waits for the end of the job that is needed next, a tenth of a second at most. */
static void doze(ric_workers *w)
{
    struct timespec until;
    clock_gettime(CLOCK_REALTIME, &until);
    until.tv_nsec += 100000000;
    until.tv_sec += until.tv_nsec / 1000000000;
    until.tv_nsec %= 1000000000;
    pthread_cond_timedwait(&w->finished, &w->lock, &until);
}

/* Without threads the owner works itself: on what is asked for, or on others while that is in hand
 * elsewhere. With the lock held. */
static void help(ric_workers *w, int number)
{
    withdraw(w, &w->jobs[number - 1]);
    if (w->jobs[number - 1].state == DONE) return;
    int i = next_job(w);
    if (i >= 0) work(w, i);
    else doze(w);
}

bool ric_workers_await(ric_workers *w, int number, bool (*stop)(void *user), void *user)
{
    bool stopped = false;
    pthread_mutex_lock(&w->lock);
    w->urgent = number;
    while (w->jobs[number - 1].state != DONE && !stopped) {
        if (w->n_thread == 0) help(w, number);
        else doze(w);
        stopped = stop && stop(user);
    }
    w->urgent = 0;
    pthread_mutex_unlock(&w->lock);
    return !stopped;
}

int ric_workers_claim(ric_workers *w, ric_node **node, unsigned *choice)
{
    ric_workers_node *shared = NULL;
    pthread_mutex_lock(&w->lock);
    int i = next_job(w);
    if (i >= 0) {
        shared = claim(w, i);
        *choice = w->jobs[i].choice;
    }
    pthread_mutex_unlock(&w->lock);
    if (i < 0) return 0;
    if ((*node = take_share(shared))) return i + 1;
    ric_workers_finish(w, i + 1); /* the owner does it */
    return 0;
}

void ric_workers_finish(ric_workers *w, int number)
{
    pthread_mutex_lock(&w->lock);
    finish(w, number - 1);
    pthread_mutex_unlock(&w->lock);
}

int ric_workers_waiting(ric_workers *w)
{
    pthread_mutex_lock(&w->lock);
    int waiting = w->waiting;
    pthread_mutex_unlock(&w->lock);
    return waiting;
}
