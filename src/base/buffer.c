#include "buffer.h"
#include "memory.h"

#include <stdlib.h>
#include <string.h>
#include <sys/types.h>

/* For fopencookie: 0 is an error. */
static ssize_t append(void *buffer, const char *bytes, size_t n)
{
    ric_buffer *b = buffer;
    if (b->capacity - b->size <= n && !b->lost) {
        size_t capacity = 2 * (b->size + n + 1);
        char *grown = ric_realloc(b->text, capacity);
        b->lost = !grown;
        if (grown) {
            b->text = grown;
            b->capacity = capacity;
        }
    }
    if (b->lost) return 0;
    memcpy(b->text + b->size, bytes, n);
    b->size += n;
    b->text[b->size] = '\0';
    return (ssize_t)n;
}

/* A stream that is written by `append`, of BSD and macOS or of the GNU library. */
#ifdef RIC_BASE_ELSEWHERE_H
static int append_or_fail(void *buffer, const char *bytes, int n)
{
    return append(buffer, bytes, (size_t)n) == n ? n : -1;
}

static FILE *stream_into(ric_buffer *b)
{
    return funopen(b, NULL, append_or_fail, NULL, NULL);
}
#else
static FILE *stream_into(ric_buffer *b)
{
    return fopencookie(b, "w", (cookie_io_functions_t){.write = append});
}
#endif

bool ric_buffer_open(ric_buffer *out)
{
    enum { FIRST = 256 };
    *out = (ric_buffer){.text = ric_malloc(FIRST), .capacity = FIRST};
    if (out->text) {
        out->text[0] = '\0';
        out->file = stream_into(out);
    }
    if (!out->file) ric_buffer_free(out);
    return out->file;
}

bool ric_buffer_sync(ric_buffer *b)
{
    b->lost |= fflush(b->file) || ferror(b->file);
    return !b->lost;
}

char *ric_buffer_take(ric_buffer *b)
{
    char *text = ric_buffer_sync(b) ? b->text : NULL;
    if (text) b->text = NULL;
    ric_buffer_free(b);
    return text;
}

void ric_buffer_free(ric_buffer *b)
{
    if (b->file) fclose(b->file);
    free(b->text);
    *b = (ric_buffer){0};
}
