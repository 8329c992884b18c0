/* A text that grows in memory as it is printed. open_memstream would do, but that of glibc drops
 * what it finds no memory for without a word: neither ferror nor fclose tells. */
#ifndef RIC_BASE_BUFFER_H
#define RIC_BASE_BUFFER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

typedef struct {
    FILE *file; /* to print to; it knows where the buffer lies, which must stay there */
    char *text; /* ends with a 0; as of the last sync */
    size_t size, capacity;
    bool lost; /* something found no memory */
} ric_buffer;

/* False, and nothing to free: no memory. */
bool ric_buffer_open(ric_buffer *out);
/* Brings what was printed into `text`; false: not all of it, for want of memory. */
bool ric_buffer_sync(ric_buffer *b);
/* Closes the buffer and hands its text to the caller, who frees it; NULL: no memory. */
char *ric_buffer_take(ric_buffer *b);
void ric_buffer_free(ric_buffer *b);

#endif
