/* What a run keeps of its work is written by a thread of its own, in the order in which it comes:
 * whoever finds the work goes on meanwhile, and need not wait to know what is not there. */
#include "store_parts.h"
#include "base/room.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Bytes that may wait: a disk that is slower than the run holds it up, and does not fill memory. */
#define WAITING_MOST ((size_t)64 << 20)
/* Bytes at which the thread is called: waking it for each piece of work costs as much as writing
 * that. Nothing is safe against a kill before a commit, for which it is called at once. */
#define WORTH_A_CALL ((size_t)256 << 10)

typedef struct waiting {
    struct waiting *next;
    ric_store_task task;
    char bytes[]; /* of the blob, then of the key */
} waiting;

struct ric_store_later {
    pthread_mutex_t lock;
    pthread_cond_t changed;
    pthread_t thread;
    ric_status (*apply)(void *user, const ric_store_task *task);
    void *user;
    waiting *first, **last;
    size_t size;       /* of all that waits or is in hand */
    bool called, stop; /* called: works until nothing waits */
    ric_status status; /* the first failure, with its reason; nothing is done any more */
    char why[1024];
};

static size_t size_of(const waiting *w)
{
    return sizeof *w + w->task.size + strlen(w->task.key) + 1;
}

/* With the lock held before and after but not meanwhile. */
static void work(ric_store_later *later)
{
    waiting *one = later->first;
    const bool skipped = later->status != RIC_OK;
    if (!(later->first = one->next)) later->last = &later->first;
    pthread_mutex_unlock(&later->lock);
    const ric_status status = skipped ? RIC_OK : later->apply(later->user, &one->task);
    const size_t size = size_of(one);
    free(one);
    pthread_mutex_lock(&later->lock);
    if (status && !later->status) {
        later->status = status;
        snprintf(later->why, sizeof later->why, "%s", ric_detail());
    }
    later->size -= size;
    pthread_cond_broadcast(&later->changed);
}

static void *serve(void *argument)
{
    ric_store_later *later = argument;
    ric_memory_spread(RIC_SPREAD_THREAD);
    pthread_mutex_lock(&later->lock);
    while (later->first || !later->stop)
        if (later->first && later->called) work(later);
        else {
            later->called = false;
            pthread_cond_wait(&later->changed, &later->lock);
        }
    pthread_mutex_unlock(&later->lock);
    return NULL;
}

ric_store_later *ric_store_later_begin(ric_status (*apply)(void *user, const ric_store_task *task),
                                       void *user)
{
    ric_store_later *later = ric_calloc(1, sizeof *later);
    if (!later) return NULL;
    later->apply = apply;
    later->user = user;
    later->last = &later->first;
    pthread_mutex_init(&later->lock, NULL);
    pthread_cond_init(&later->changed, NULL);
    if (!pthread_create(&later->thread, NULL, serve, later)) return later;
    pthread_cond_destroy(&later->changed);
    pthread_mutex_destroy(&later->lock);
    free(later);
    return NULL;
}

/* With the lock held. */
static void call(ric_store_later *later)
{
    if (later->called) return;
    later->called = true;
    pthread_cond_broadcast(&later->changed);
}

/* With the lock held: waits until no more than `most` bytes wait. */
static ric_status wait_for(ric_store_later *later, size_t most)
{
    if (later->size > most) call(later);
    while (later->size > most && !later->status) pthread_cond_wait(&later->changed, &later->lock);
    return later->status ? ric_fail(later->status, "%s", later->why) : RIC_OK;
}

ric_status ric_store_later_add(ric_store_later *later, const ric_store_task *task)
{
    const size_t key_size = strlen(task->key) + 1;
    waiting *one = ric_malloc(sizeof *one + task->size + key_size);
    if (!one) return ric_store_fail_memory();
    *one = (waiting){.task = *task};
    if (task->size) memcpy(one->bytes, task->blob, task->size);
    one->task.blob = one->bytes;
    one->task.key = memcpy(one->bytes + task->size, task->key, key_size);
    pthread_mutex_lock(&later->lock);
    const ric_status status = wait_for(later, WAITING_MOST);
    if (status) free(one);
    else {
        later->size += size_of(one);
        *later->last = one;
        later->last = &one->next;
        if (later->size >= WORTH_A_CALL || task->act == RIC_STORE_COMMIT) call(later);
    }
    pthread_mutex_unlock(&later->lock);
    return status;
}

ric_status ric_store_later_wait(ric_store_later *later)
{
    pthread_mutex_lock(&later->lock);
    const ric_status status = wait_for(later, 0);
    pthread_mutex_unlock(&later->lock);
    return status;
}

ric_status ric_store_later_end(ric_store_later *later)
{
    if (!later) return RIC_OK;
    pthread_mutex_lock(&later->lock);
    later->stop = true;
    call(later);
    pthread_mutex_unlock(&later->lock);
    pthread_join(later->thread, NULL);
    const ric_status status = wait_for(later, 0);
    pthread_cond_destroy(&later->changed);
    pthread_mutex_destroy(&later->lock);
    free(later);
    return status;
}

/* -------------------------------------------------------------------- names */

/* A hash of a key, never 0. */
static uint64_t hash_of(const char *key)
{
    return ric_bytes_hash(RIC_BYTES_HASH, key, strlen(key)) | 1;
}

/* The slot of a hash, or the free one where it would lie. */
static uint64_t *slot_of(const ric_store_names *names, uint64_t hash)
{
    size_t i = (size_t)(hash >> 20) & (names->n_slot - 1);
    while (names->slots[i] && names->slots[i] != hash) i = (i + 1) & (names->n_slot - 1);
    return &names->slots[i];
}

static bool grow(ric_store_names *names)
{
    ric_store_names more = {.n_slot = names->n_slot ? 2 * names->n_slot : 1024};
    if (!(more.slots = ric_calloc(more.n_slot, sizeof *more.slots))) return false;
    for (size_t i = 0; i < names->n_slot; i++)
        if (names->slots[i]) *slot_of(&more, names->slots[i]) = names->slots[i];
    free(names->slots);
    names->slots = more.slots;
    names->n_slot = more.n_slot;
    return true;
}

void ric_store_names_add(ric_store_names *names, const char *key)
{
    if (!names->whole) return;
    if (2 * (names->count + 1) > names->n_slot && !grow(names)) {
        names->whole = false;
        return;
    }
    uint64_t *slot = slot_of(names, hash_of(key));
    names->count += !*slot;
    *slot = hash_of(key);
}

bool ric_store_names_lack(const ric_store_names *names, const char *key)
{
    return names->whole && (!names->n_slot || !*slot_of(names, hash_of(key)));
}
