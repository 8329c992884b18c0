/* Square matrices from Matrix Market files: array or coordinate, real or integer, general or
 * symmetric. */
#ifndef RIC_STUDY_MATRIX_MARKET_H
#define RIC_STUDY_MATRIX_MARKET_H

#include "ricochet.h"

enum { RIC_MATRIX_MAX = 1000 }; /* rows of a dense matrix: 8 MB */

/* Reads `path` into *out [*n * *n], allocated, row-major. Entries that stand there more than once
 * are summed, as an assembly writes them: *repeated is how many, may be NULL. A symmetric file may
 * hold either half. On failure the detail is "PATH:LINE: what is wrong; what would be right". */
ric_status ric_matrix_market_read(const char *path, int *n, double **out, long *repeated);
/* The same from `size` bytes at `text`; text[size] must be 0. `label` stands for the file in
 * messages. */
ric_status ric_matrix_market_parse(const char *text, size_t size, const char *label, int *n,
                                   double **out, long *repeated);

/* Whole file into *text, with a 0 after its *size bytes; refuses folders and files of more than
 * `limit` bytes. `regular`: nothing but a plain file, so that no pipe can make the reader wait.
 * Detail: "PATH: what is wrong". */
ric_status ric_file_read(const char *path, size_t limit, bool regular, char **text, size_t *size);

#endif
