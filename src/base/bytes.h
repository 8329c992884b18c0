/* Values one after the other as bytes of one machine. What writes them and what reads them is one
 * function, which passes each value once: so both know one layout, and how long it is. */
#ifndef RIC_BASE_BYTES_H
#define RIC_BASE_BYTES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct {
    char *at;     /* where the next value lies; NULL: they are only counted */
    size_t size;  /* counted or written so far; when reading, what is left */
    bool reading; /* what is at `at` is only read */
    bool lost; /* there are fewer bytes than were asked for, and what was read is 0; or something is
                  wrong with it */
} ric_bytes;

ric_bytes ric_bytes_of(const void *bytes, size_t size);
void ric_bytes_pass(ric_bytes *bytes, void *values, size_t size);
/* Whether as many bytes can still be read. */
bool ric_bytes_have(const ric_bytes *bytes, size_t size);
/* What `pass` passes, allocated; NULL: no memory. Nothing of `user` is changed. */
void *ric_bytes_make(void (*pass)(ric_bytes *bytes, void *user), void *user, size_t *size);

/* FNV-1a with 64 bits (Fowler, Noll, Vo), from RIC_BYTES_HASH on: one changed byte always changes
 * it. */
#define RIC_BYTES_HASH UINT64_C(0xcbf29ce484222325)
uint64_t ric_bytes_hash(uint64_t hash, const void *bytes, size_t n);

#endif
