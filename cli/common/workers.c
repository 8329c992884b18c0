#define _POSIX_C_SOURCE 200809L

#include "common/workers.h"

#include <stdio.h>

static const struct timespec nap = {0, 5000000};

int cli_workers_take(cli_workers *w)
{
    const int i = w->stop ? w->n : atomic_fetch_add(&w->next, 1);
    return i < w->n ? i : -1;
}

void cli_workers_finish(cli_workers *w)
{
    atomic_fetch_add(&w->finished, 1);
}

void cli_workers_fail(cli_workers *w, ric_status status)
{
    pthread_mutex_lock(&w->mutex);
    if (!w->status) {
        w->status = status;
        snprintf(w->detail, sizeof w->detail, "%s", ric_detail());
    }
    pthread_mutex_unlock(&w->mutex);
    w->stop = true;
}

bool cli_workers_over(void *user)
{
    const cli_workers *w = user;
    return w->stop || cli_stopped() || cli_seconds_since(&w->start) > w->seconds;
}

static void *enter(void *user)
{
    cli_workers *w = user;
    w->work(w->user);
    atomic_fetch_add(&w->gone, 1);
    return NULL;
}

static void tell(const cli_workers *w)
{
    fprintf(stderr, "%d of %d %s, ", (int)w->finished, w->n, w->pieces);
    if (w->parts) fprintf(stderr, "%d of %d %s, ", (int)w->part, w->n_part, w->parts);
    fprintf(stderr, "%.0f s", cli_seconds_since(&w->start));
}

/* Until all are gone, the time is over or a signal comes; shows on a terminal how far they are. */
static void attend(cli_workers *w, int started)
{
    cli_progress line = cli_progress_begin();
    while (!w->stop && w->gone < started) {
        nanosleep(&nap, NULL);
        if (cli_workers_over(w)) w->stop = true;
        if (cli_progress_due(&line)) tell(w);
    }
    cli_progress_end(&line);
}

ric_status cli_workers_run(cli_workers *w, int count)
{
    pthread_t threads[CLI_WORKERS_MOST];
    int started = 0;
    clock_gettime(CLOCK_MONOTONIC, &w->start);
    cli_catch_signals();
    while (started < count && !pthread_create(&threads[started], NULL, enter, w)) started++;
    if (started == 0) enter(w);
    attend(w, started);
    for (int i = 0; i < started; i++) pthread_join(threads[i], NULL);
    return w->status;
}
