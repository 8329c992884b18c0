#include "bytes.h"
#include "memory.h"

#include <stdint.h>
#include <string.h>

ric_bytes ric_bytes_of(const void *bytes, size_t size)
{
    return (ric_bytes){.at = (char *)(uintptr_t)bytes, .size = size, .reading = true};
}

bool ric_bytes_have(const ric_bytes *b, size_t size)
{
    return !b->lost && size <= b->size;
}

void ric_bytes_pass(ric_bytes *b, void *values, size_t size)
{
    if (b->reading) {
        b->lost = !ric_bytes_have(b, size);
        if (b->lost) memset(values, 0, size);
        else if (size) memcpy(values, b->at, size);
        if (b->lost) return;
    } else if (b->at && size) memcpy(b->at, values, size);
    if (b->at) b->at += size;
    b->size = b->reading ? b->size - size : b->size + size;
}

void *ric_bytes_make(void (*pass)(ric_bytes *, void *), void *user, size_t *size)
{
    ric_bytes count = {0};
    pass(&count, user);
    char *out = ric_malloc(count.size + 1);
    ric_bytes written = {.at = out};
    *size = count.size;
    if (out) pass(&written, user);
    return out;
}

uint64_t ric_bytes_hash(uint64_t hash, const void *bytes, size_t n)
{
    const unsigned char *byte = bytes;
    for (size_t i = 0; i < n; i++) hash = (hash ^ byte[i]) * UINT64_C(0x100000001b3);
    return hash;
}
