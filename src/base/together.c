#include "together.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>

#include "memory.h"

typedef struct {
    pthread_mutex_t lock;
    int next, count;
    ric_status (*each)(void *, int);
    void *user;
    ric_status status; /* the first failure, with its reason */
    char why[1024];
} loop;

static void *turn(void *argument)
{
    loop *l = argument;
    pthread_mutex_lock(&l->lock);
    while (l->next < l->count && !l->status) {
        int i = l->next++;
        pthread_mutex_unlock(&l->lock);
        ric_memory_clear();
        ric_status status = l->each(l->user, i);
        if (!status && ric_memory_failed()) status = RIC_E_NOMEM;
        pthread_mutex_lock(&l->lock);
        if (status && !l->status) {
            l->status = status;
            snprintf(l->why, sizeof l->why, "%s",
                     status == RIC_E_NOMEM ? ric_status_text(status) : ric_detail());
        }
    }
    pthread_mutex_unlock(&l->lock);
    return NULL;
}

/* The same on a thread that may be in the middle of something. */
static void run(loop *l)
{
    const bool lost = ric_memory_failed();
    turn(l);
    if (lost) ric_memory_lose();
}

static ric_status one_by_one(int count, ric_status (*each)(void *user, int i), void *user)
{
    ric_status status = RIC_OK;
    for (int i = 0; i < count && !status; i++) status = each(user, i);
    return !status && ric_memory_failed()
               ? ric_fail(RIC_E_NOMEM, "%s", ric_status_text(RIC_E_NOMEM))
               : status;
}

ric_status ric_together(int n, int count, ric_status (*each)(void *user, int i), void *user)
{
    if (n < 2 || count < 2) return one_by_one(count, each, user);
    loop l = {.count = count, .each = each, .user = user};
    const int wanted = (n < count ? n : count) - 1;
    pthread_t *threads = ric_calloc((size_t)wanted, sizeof *threads);
    int started = 0;
    pthread_mutex_init(&l.lock, NULL);
    /* fewer do as well */
    while (threads && started < wanted && !pthread_create(&threads[started], NULL, turn, &l))
        started++;
    run(&l);
    for (int i = 0; i < started; i++) pthread_join(threads[i], NULL);
    pthread_mutex_destroy(&l.lock);
    free(threads);
    return l.status ? ric_fail(l.status, "%s", l.why) : RIC_OK;
}

struct ric_together_call {
    loop loop;
    pthread_t thread;
    bool aside;
    ric_status (*call)(void *);
    void *user;
};

static ric_status call_once(void *user, int i)
{
    (void)i;
    const ric_together_call *c = user;
    return c->call(c->user);
}

ric_together_call *ric_together_begin(ric_status (*call)(void *user), void *user)
{
    ric_together_call *c = ric_calloc(1, sizeof *c);
    if (!c) return NULL;
    *c = (ric_together_call){.loop = {.count = 1, .each = call_once, .user = c},
                             .call = call,
                             .user = user};
    pthread_mutex_init(&c->loop.lock, NULL);
    c->aside = !pthread_create(&c->thread, NULL, turn, &c->loop);
    if (!c->aside) run(&c->loop);
    return c;
}

ric_status ric_together_end(ric_together_call *c)
{
    if (!c) return RIC_OK;
    if (c->aside) pthread_join(c->thread, NULL);
    ric_status status = c->loop.status ? ric_fail(c->loop.status, "%s", c->loop.why) : RIC_OK;
    pthread_mutex_destroy(&c->loop.lock);
    free(c);
    return status;
}
