/* Results of pure computations, kept by all that they depend on: workers put them in, the owner of
 * an atlas takes them out. A result that is missing is computed by whoever needs it, so that an
 * atlas never depends on who was faster (docs/theory.md section 9). */
#ifndef RIC_BASE_CACHE_H
#define RIC_BASE_CACHE_H

#include "status.h"

typedef struct ric_cache ric_cache;

ric_status ric_cache_create(ric_cache **out);
void ric_cache_free(ric_cache *memo);

/* Keeps a copy of the value; without memory it is dropped. Any thread. */
void ric_cache_put(ric_cache *memo, const void *key, size_t key_size, const void *value,
                   size_t size);
/* The value, which leaves the memo; the caller frees it. NULL: none. Any thread. */
void *ric_cache_take(ric_cache *memo, const void *key, size_t key_size, size_t *size);
/* Calls `each` for every entry, and empties the memo. */
void ric_cache_drain(ric_cache *memo,
                     void (*each)(const void *key, size_t key_size, const void *value, size_t size,
                                  void *user),
                     void *user);

#endif
