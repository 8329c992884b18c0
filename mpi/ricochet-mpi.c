/* ricochet-mpi: the program with hands on other machines (docs/cluster.md). Rank 0 is the program
 * itself and owns the atlas; its departures go to the other ranks, which answer with all that they
 * found on the way. One thread of rank 0 does the talking. */
#include <mpi.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "common/cli.h"
#include "explore/remote.h"
#include "junction/node_cache.h"

enum { TAG_JOB = 1, TAG_RESULT, TAG_STOP };
#define AHEAD 2     /* departures given to a rank at a time, so that none waits for the post */
#define PAUSE 50000 /* nanoseconds between two looks at the mailbox when nothing happens */

/* ----------------------------------------------------------------- messages */

typedef struct {
    char *data;
    size_t size, capacity;
} message;

static void need(bool held, const char *what)
{
    if (held) return;
    fprintf(stderr, "ricochet-mpi: %s\n", what);
    MPI_Abort(MPI_COMM_WORLD, CLI_FAILED);
}

static void append(message *m, const void *bytes, size_t size)
{
    if (m->size + size > m->capacity) {
        m->capacity = 2 * (m->size + size);
        need((m->data = realloc(m->data, m->capacity)) != NULL, "no memory for a message");
    }
    if (size) memcpy(m->data + m->size, bytes, size);
    m->size += size;
}

static void append_entry(const void *key, size_t key_size, const void *value, size_t size,
                         void *user)
{
    uint64_t sizes[2] = {key_size, size};
    append(user, sizes, sizeof sizes);
    append(user, key, key_size);
    append(user, value, size);
}

static void post(const message *m, int rank, int tag)
{
    need(m->size <= INT32_MAX, "a message is longer than two gigabytes");
    MPI_Send(m->data, (int)m->size, MPI_BYTE, rank, tag, MPI_COMM_WORLD);
}

static void receive(MPI_Status *envelope, message *m)
{
    int size;
    MPI_Get_count(envelope, MPI_BYTE, &size);
    m->size = 0;
    append(m, NULL, 0);
    if ((size_t)size > m->capacity) {
        m->capacity = 2 * (size_t)size;
        need((m->data = realloc(m->data, m->capacity)) != NULL, "no memory for a message");
    }
    MPI_Recv(m->data, size, MPI_BYTE, envelope->MPI_SOURCE, envelope->MPI_TAG, MPI_COMM_WORLD,
             MPI_STATUS_IGNORE);
    m->size = (size_t)size;
}

typedef struct {
    int32_t number;
    uint32_t choice;
} job_head;

/* Before the results of a departure: what it took, and how long the rank had waited for it. */
typedef struct {
    int32_t number;
    double work, waited; /* s: processor time, which does not grow on a busy machine; elapsed */
} answer_head;

static double clock_of(clockid_t clock)
{
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* -------------------------------------------------------------- rank 0: crew */

/* A job on its way. Nothing is posted that waits for its receiver: that one may be waiting to post
 * an answer. */
typedef struct {
    MPI_Request request;
    message job;
} letter;

typedef struct {
    int n_rank, *busy; /* departures in hand, per rank */
    letter *letters;   /* [AHEAD * n_rank] */
    bool joined;
    atomic_bool stop;
    pthread_t thread;
    ric_workers *workers;
    ric_cache *memo;
    FILE *counts;            /* NULL, or where times go (open_counts) */
    double begin, own_begin; /* s, when the crew joined: elapsed, and of the thread that owns the
                                graph */
    double served;           /* s of the other thread for answers */
} crew;

/* One line for every departure that a rank has followed, and one of rank 0; tools/feed reads them
 * (docs/cluster.md). Times are no part of what a run says, so that they have a file of their own.
 */
static void open_counts(crew *c)
{
    const char *path = getenv("RICOCHET_MPI_COUNTS");
    if (!path || !*path) return;
    need((c->counts = fopen(path, "w")) != NULL, "the file of RICOCHET_MPI_COUNTS is not writable");
    fprintf(c->counts, "ranks %d\n", c->n_rank);
}

/* In the thread that owns the graph. */
static void close_counts(crew *c)
{
    if (!c->counts) return;
    fprintf(c->counts, "owner %.6f %.6f %.6f\n", clock_of(CLOCK_MONOTONIC) - c->begin,
            clock_of(CLOCK_THREAD_CPUTIME_ID) - c->own_begin, c->served);
    need(!fclose(c->counts), "the file of RICOCHET_MPI_COUNTS cannot be written");
    c->counts = NULL;
}

static letter *free_letter(crew *c, int rank)
{
    for (letter *l = c->letters + AHEAD * rank; l < c->letters + AHEAD * (rank + 1); l++) {
        int arrived = 1;
        if (l->request != MPI_REQUEST_NULL) MPI_Test(&l->request, &arrived, MPI_STATUS_IGNORE);
        if (!arrived) continue;
        l->job.size = 0;
        return l;
    }
    return NULL;
}

static bool send_job(crew *c, int rank)
{
    ric_node *node;
    job_head head;
    void *bytes;
    size_t size;
    letter *l = free_letter(c, rank);
    if (!l) return false;
    int number = ric_workers_claim(c->workers, &node, &head.choice);
    if (!number) return false;
    head.number = number;
    need(!ric_node_pack(node, &bytes, &size), ric_detail());
    ric_node_free(node);
    append(&l->job, &head, sizeof head);
    append(&l->job, bytes, size);
    MPI_Isend(l->job.data, (int)l->job.size, MPI_BYTE, rank, TAG_JOB, MPI_COMM_WORLD, &l->request);
    c->busy[rank]++;
    free(bytes);
    return true;
}

static void take_result(crew *c, MPI_Status *envelope)
{
    message m = {0};
    answer_head head;
    double begin = clock_of(CLOCK_THREAD_CPUTIME_ID);
    receive(envelope, &m);
    size_t at = sizeof head;
    need(m.size >= at, "an empty answer");
    memcpy(&head, m.data, sizeof head);
    while (at < m.size) {
        uint64_t sizes[2];
        need(m.size - at >= sizeof sizes, "a damaged answer");
        memcpy(sizes, m.data + at, sizeof sizes);
        at += sizeof sizes;
        need(m.size - at >= sizes[0] && m.size - at - sizes[0] >= sizes[1], "a damaged answer");
        ric_cache_put(c->memo, m.data + at, sizes[0], m.data + at + sizes[0], sizes[1]);
        at += sizes[0] + sizes[1];
    }
    ric_workers_finish(c->workers, head.number);
    c->busy[envelope->MPI_SOURCE]--;
    c->served += clock_of(CLOCK_THREAD_CPUTIME_ID) - begin;
    if (c->counts)
        fprintf(c->counts, "departure %d %d %.6f %.6f %zu\n", head.number, envelope->MPI_SOURCE,
                head.work, head.waited, m.size);
    free(m.data);
}

static bool some_busy(const crew *c)
{
    for (int r = 1; r < c->n_rank; r++)
        if (c->busy[r]) return true;
    return false;
}

/* The only thread that talks. First every rank gets one departure, then a second. */
static void *talk(void *argument)
{
    crew *c = argument;
    while (!c->stop || some_busy(c)) {
        bool idle = true;
        for (int load = 0; load < AHEAD && !c->stop; load++)
            for (int r = 1; r < c->n_rank; r++)
                if (c->busy[r] <= load && send_job(c, r)) idle = false;
        for (;;) {
            MPI_Status envelope;
            int there;
            MPI_Iprobe(MPI_ANY_SOURCE, TAG_RESULT, MPI_COMM_WORLD, &there, &envelope);
            if (!there) break;
            take_result(c, &envelope);
            idle = false;
        }
        if (idle) nanosleep(&(struct timespec){.tv_nsec = PAUSE}, NULL);
    }
    return NULL;
}

/* An empty text sends everybody home. */
static void send_study(const char *text)
{
    long length = (long)strlen(text);
    MPI_Bcast(&length, 1, MPI_LONG, 0, MPI_COMM_WORLD);
    if (length) MPI_Bcast((void *)(uintptr_t)text, (int)length, MPI_BYTE, 0, MPI_COMM_WORLD);
}

static ric_status join(void *user, const ric_study *study, ric_workers *workers, ric_cache *memo)
{
    crew *c = user;
    c->workers = workers;
    c->memo = memo;
    c->joined = true;
    c->begin = clock_of(CLOCK_MONOTONIC);
    c->own_begin = clock_of(CLOCK_THREAD_CPUTIME_ID);
    send_study(ric_study_text(study));
    need(!pthread_create(&c->thread, NULL, talk, c), "the system gives no thread");
    return RIC_OK;
}

static void leave(void *user)
{
    crew *c = user;
    c->stop = true;
    pthread_join(c->thread, NULL);
    close_counts(c);
    for (int r = 1; r < c->n_rank; r++) MPI_Send(NULL, 0, MPI_BYTE, r, TAG_STOP, MPI_COMM_WORLD);
}

static int own(int argc, char **argv, int n_rank)
{
    crew c = {.n_rank = n_rank,
              .busy = calloc((size_t)n_rank, sizeof *c.busy),
              .letters = calloc((size_t)n_rank * AHEAD, sizeof *c.letters)};
    ric_remote hands = {join, leave, &c};
    need(c.busy && c.letters, "no memory");
    for (int i = 0; i < AHEAD * n_rank; i++) c.letters[i].request = MPI_REQUEST_NULL;
    if (n_rank > 1) {
        open_counts(&c);
        cli_run_remote = &hands;
    }
    int code = cli_main(argc, argv);
    if (!c.joined) send_study("");
    for (int i = 0; i < AHEAD * n_rank; i++) {
        if (c.letters[i].request != MPI_REQUEST_NULL)
            MPI_Wait(&c.letters[i].request, MPI_STATUS_IGNORE);
        free(c.letters[i].job.data);
    }
    free(c.letters);
    free(c.busy);
    return code;
}

/* ----------------------------------------------------------- the other ranks */

/* `waited`: how long no departure was there. */
static void prepare(ric_explore_worker *hand, const message *job, double waited)
{
    job_head head;
    answer_head before = {0};
    ric_node *node;
    message answer = {0};
    double begin = clock_of(CLOCK_THREAD_CPUTIME_ID);
    need(job->size >= sizeof head, "an empty job");
    memcpy(&head, job->data, sizeof head);
    need(!ric_node_unpack(ric_explore_worker_model(hand), job->data + sizeof head,
                          job->size - sizeof head, &node),
         "a damaged job");
    before.number = head.number;
    before.waited = waited;
    append(&answer, &before, sizeof before);
    ric_cache_drain(ric_explore_worker_prepare(hand, node, head.choice), append_entry, &answer);
    before.work = clock_of(CLOCK_THREAD_CPUTIME_ID) - begin;
    memcpy(answer.data, &before, sizeof before);
    post(&answer, 0, TAG_RESULT);
    free(answer.data);
}

static int serve(void)
{
    long length = 0;
    ric_study *study = NULL;
    ric_explore_worker *hand = NULL;
    message m = {0};
    signal(SIGINT, SIG_IGN); /* rank 0 stops, and stops everybody */
    MPI_Bcast(&length, 1, MPI_LONG, 0, MPI_COMM_WORLD);
    if (!length) return CLI_DONE;
    char *text = calloc((size_t)length + 1, 1);
    need(text != NULL, "no memory for the study");
    MPI_Bcast(text, (int)length, MPI_BYTE, 0, MPI_COMM_WORLD);
    need(!ric_study_parse(text, "study", ".", &study) && !ric_explore_worker_create(study, &hand),
         ric_detail());
    for (;;) {
        MPI_Status envelope;
        double begin = clock_of(CLOCK_MONOTONIC);
        MPI_Probe(0, MPI_ANY_TAG, MPI_COMM_WORLD, &envelope);
        receive(&envelope, &m);
        if (envelope.MPI_TAG == TAG_STOP) break;
        prepare(hand, &m, clock_of(CLOCK_MONOTONIC) - begin);
    }
    free(m.data);
    free(text);
    ric_explore_worker_free(hand);
    ric_study_free(study);
    return CLI_DONE;
}

int main(int argc, char **argv)
{
    int level, rank, n_rank;
    MPI_Init_thread(&argc, &argv, MPI_THREAD_SERIALIZED, &level);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &n_rank);
    need(level >= MPI_THREAD_SERIALIZED,
         "this MPI library does not let one thread of several talk; use another build of it");
    int code = rank == 0 ? own(argc, argv, n_rank) : serve();
    MPI_Finalize();
    return code;
}
