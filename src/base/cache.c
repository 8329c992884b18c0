#include "cache.h"
#include "bytes.h"
#include "memory.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

typedef struct entry {
    struct entry *next;
    uint64_t hash;
    size_t key_size, size;
    char *value;
    char key[];
} entry;

struct ric_cache {
    pthread_mutex_t lock;
    size_t n_entry, n_slot; /* a power of two */
    entry **slots;
};

ric_status ric_cache_create(ric_cache **out)
{
    ric_cache *memo = ric_calloc(1, sizeof *memo);
    *out = NULL;
    if (memo) memo->slots = ric_calloc(memo->n_slot = 256, sizeof *memo->slots);
    if (!memo || !memo->slots) {
        free(memo);
        return ric_no_memory("the results of workers");
    }
    pthread_mutex_init(&memo->lock, NULL);
    *out = memo;
    return RIC_OK;
}

static void release(entry *e)
{
    free(e->value);
    free(e);
}

void ric_cache_drain(ric_cache *memo,
                     void (*each)(const void *, size_t, const void *, size_t, void *), void *user)
{
    pthread_mutex_lock(&memo->lock);
    for (size_t i = 0; i < memo->n_slot; i++)
        while (memo->slots[i]) {
            entry *e = memo->slots[i];
            memo->slots[i] = e->next;
            if (each) each(e->key, e->key_size, e->value, e->size, user);
            release(e);
        }
    memo->n_entry = 0;
    pthread_mutex_unlock(&memo->lock);
}

void ric_cache_free(ric_cache *memo)
{
    if (!memo) return;
    ric_cache_drain(memo, NULL, NULL);
    pthread_mutex_destroy(&memo->lock);
    free(memo->slots);
    free(memo);
}

static uint64_t hash_of(const void *key, size_t size)
{
    const uint64_t hash = ric_bytes_hash(RIC_BYTES_HASH, key, size);
    return hash ^ hash >> 32;
}

/* The link that leads to the entry of a key, or to the end of its chain. */
static entry **find(ric_cache *memo, uint64_t hash, const void *key, size_t key_size)
{
    entry **link = &memo->slots[hash & (memo->n_slot - 1)];
    while (*link && !((*link)->hash == hash && (*link)->key_size == key_size &&
                      !memcmp((*link)->key, key, key_size)))
        link = &(*link)->next;
    return link;
}

static void grow(ric_cache *memo)
{
    size_t n_slot = 2 * memo->n_slot;
    entry **slots = ric_calloc(n_slot, sizeof *slots);
    if (!slots) return; /* longer chains do no harm */
    for (size_t i = 0; i < memo->n_slot; i++)
        while (memo->slots[i]) {
            entry *e = memo->slots[i];
            memo->slots[i] = e->next;
            e->next = slots[e->hash & (n_slot - 1)];
            slots[e->hash & (n_slot - 1)] = e;
        }
    free(memo->slots);
    memo->slots = slots;
    memo->n_slot = n_slot;
}

void ric_cache_put(ric_cache *memo, const void *key, size_t key_size, const void *value,
                   size_t size)
{
    uint64_t hash = hash_of(key, key_size);
    entry *e = ric_malloc(sizeof *e + key_size);
    char *copy = ric_malloc(size ? size : 1);
    if (!e || !copy) {
        free(e);
        free(copy);
        return;
    }
    *e = (entry){.hash = hash, .key_size = key_size, .size = size, .value = copy};
    memcpy(e->key, key, key_size);
    memcpy(copy, value, size);
    pthread_mutex_lock(&memo->lock);
    entry **link = find(memo, hash, key, key_size);
    if (*link) {
        release(e); /* pure: the same value */
    } else {
        *link = e;
        if (++memo->n_entry > memo->n_slot) grow(memo);
    }
    pthread_mutex_unlock(&memo->lock);
}

void *ric_cache_take(ric_cache *memo, const void *key, size_t key_size, size_t *size)
{
    void *value = NULL;
    pthread_mutex_lock(&memo->lock);
    entry **link = find(memo, hash_of(key, key_size), key, key_size), *e = *link;
    if (e) {
        *link = e->next;
        memo->n_entry--;
        value = e->value;
        *size = e->size;
        free(e);
    }
    pthread_mutex_unlock(&memo->lock);
    return value;
}
