/* Pieces of work that several threads take one after another, while the first one looks at the
 * clock, at signals and at the terminal. */
#ifndef WORKERS_H
#define WORKERS_H

#include <pthread.h>
#include <stdatomic.h>
#include <time.h>

#include "common/cli.h"

enum { CLI_WORKERS_MOST = 256 };

typedef struct {
    int n;              /* pieces */
    const char *pieces; /* what they are called on a terminal: points */
    const char *parts;  /* what pieces are made of, NULL: nothing that is counted */
    int n_part;
    void (*work)(void *user); /* of a thread: takes pieces until there are none */
    void *user;
    double seconds; /* after which no piece is begun; HUGE_VAL: none is left out */
    atomic_int next, finished, gone;
    atomic_int part;  /* that are finished */
    atomic_bool stop; /* no further piece is taken */
    pthread_mutex_t mutex;
    struct timespec start;
    ric_status status; /* the first failure, */
    char detail[1024]; /* and what was said of it */
} cli_workers;

/* With `count` threads, or none: in this one. The first failure. */
ric_status cli_workers_run(cli_workers *workers, int count);
/* The next piece, from 0; -1: there is none, or no further one is to be taken. */
int cli_workers_take(cli_workers *workers);
void cli_workers_finish(cli_workers *workers);
/* Keeps the first failure, with what this thread was told of it, and has the others stop. */
void cli_workers_fail(cli_workers *workers, ric_status status);
/* Whether to stop: for ric_halt_ask, within a piece that takes long. `user`: the workers. */
bool cli_workers_over(void *user);

#endif
