#define _POSIX_C_SOURCE 200809L

#include "matrix_market.h"

#include <ctype.h>
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "options.h"
#include "base/room.h"

enum { TOKEN_MAX = 64, FILE_MAX = 64 << 20, ENTRIES_MAX = FILE_MAX / 6 /* of "1 1 0\n" */ };

/* ------------------------------------------------------------------- files */

static ric_status read_all(int file, const char *path, size_t limit, char **text, size_t *size)
{
    size_t room = 1 << 16, used = 0;
    char *buffer = ric_malloc(room);
    if (!buffer) return ric_fail(RIC_E_NOMEM, "%s: no memory for the file", path);
    for (;;) {
        ssize_t got = read(file, buffer + used, room - used - 1);
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) {
            free(buffer);
            return ric_fail(RIC_E_IO, "%s: %s", path, strerror(errno));
        }
        used += (size_t)got;
        if (got == 0 || used > limit) break;
        if (room - used < 2) {
            char *larger = ric_realloc(buffer, room *= 2);
            if (!larger) {
                free(buffer);
                return ric_fail(RIC_E_NOMEM, "%s: no memory for the file", path);
            }
            buffer = larger;
        }
    }
    if (used > limit) {
        free(buffer);
        return ric_fail(RIC_E_INPUT, "%s: larger than %zu MB, the most that is read", path,
                        limit >> 20);
    }
    buffer[used] = '\0';
    *text = buffer;
    *size = used;
    return RIC_OK;
}

ric_status ric_file_read(const char *path, size_t limit, bool regular, char **text, size_t *size)
{
    struct stat about;
    ric_status status = RIC_OK;
    /* O_NONBLOCK: opening a pipe that nobody writes to must not hang where only plain files will
     * do. */
    int file = open(path, O_RDONLY | O_CLOEXEC | O_NOCTTY | (regular ? O_NONBLOCK : 0));
    if (file < 0)
        return ric_fail(errno == ENOENT ? RIC_E_MISSING : RIC_E_INPUT, "%s: %s", path,
                        strerror(errno));
    if (fstat(file, &about)) status = ric_fail(RIC_E_IO, "%s: %s", path, strerror(errno));
    else if (S_ISDIR(about.st_mode))
        status = ric_fail(RIC_E_INPUT, "%s: this is a folder; name a file in it", path);
    else if (regular && !S_ISREG(about.st_mode))
        status = ric_fail(RIC_E_INPUT, "%s: not a plain file", path);
    else status = read_all(file, path, limit, text, size);
    close(file);
    return status;
}

/* ------------------------------------------------------------------- words */

typedef struct {
    const char *at, *end, *label;
    int line;
} scanner;

typedef struct {
    bool coordinate, symmetric;
    int n;
    long entries; /* numbers or triples in the file */
} header;

static ric_status bad(const scanner *s, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

static ric_status bad(const scanner *s, const char *format, ...)
{
    char what[400];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(what, sizeof what, format, arguments);
    va_end(arguments);
    return ric_fail(RIC_E_INPUT, "%.300s:%d: %s", s->label, s->line, what);
}

/* Skips blanks and comments; a comment is a line that starts with %. */
static void skip(scanner *s)
{
    for (; s->at < s->end; s->at++) {
        if (*s->at == '\n') {
            s->line++;
            if (s->at + 1 < s->end && s->at[1] == '%')
                while (s->at + 1 < s->end && s->at[1] != '\n') s->at++;
        } else if (!isspace((unsigned char)*s->at)) return;
    }
}

/* Next word in printable form; "" at the end of the text. A longer one is cut, and then it is no
 * number any more: what is left of 2.000...0e1 says another one. */
static bool next(scanner *s, char out[TOKEN_MAX])
{
    int n = 0;
    bool whole = true;
    skip(s);
    for (; s->at < s->end && !isspace((unsigned char)*s->at); s->at++)
        if (n + 1 < TOKEN_MAX) out[n++] = isprint((unsigned char)*s->at) ? *s->at : '?';
        else whole = false;
    out[n] = '\0';
    return whole;
}

static ric_status too_long(const scanner *s, const char *word)
{
    return bad(s,
               "'%.20s...' has more than %d characters; write the number with fewer, 17 digits "
               "name every double",
               word, TOKEN_MAX - 1);
}

static ric_status next_integer(scanner *s, const char *what, long max, long *out)
{
    char word[TOKEN_MAX];
    if (!next(s, word)) return too_long(s, word);
    if (!word[0]) return bad(s, "the file ends where %s should be", what);
    if (!ric_option_text_integer(word, out) || *out < 1 || *out > max)
        return bad(s, "%s is '%s'; it must be a whole number from 1 to %ld", what, word, max);
    return RIC_OK;
}

static ric_status next_real(scanner *s, long row, long column, double *out)
{
    char word[TOKEN_MAX];
    if (!next(s, word)) return too_long(s, word);
    if (!word[0])
        return bad(s, "the file ends where the entry of row %ld, column %ld should be", row,
                   column);
    switch (ric_option_text_real(word, out)) {
    case RIC_TEXT_NUMBER: return RIC_OK;
    case RIC_TEXT_NOT_FINITE:
        return bad(s, "the entry of row %ld, column %ld is '%s'; entries must be finite", row,
                   column, word);
    case RIC_TEXT_NO_NUMBER: break;
    }
    return bad(s, "the entry of row %ld, column %ld is '%s', which is not a number", row, column,
               word);
}

/* ------------------------------------------------------------------ header */

static void lower(char *text)
{
    for (; *text; text++) *text = (char)tolower((unsigned char)*text);
}

static ric_status read_banner(scanner *s, header *out)
{
    char line[128], word[5][TOKEN_MAX] = {"", "", "", "", ""};
    size_t length = strcspn(s->at, "\r\n");
    if (!strncmp(s->at, "\x1f\x8b", 2))
        return bad(s, "compressed by gzip; gunzip it and name the file that comes out");
    if (length >= sizeof line)
        return bad(s, "not a Matrix Market file; its first line is '%%%%MatrixMarket matrix "
                      "coordinate real symmetric' "
                      "or similar");
    snprintf(line, sizeof line, "%.*s", (int)length, s->at);
    lower(line);
    scanner words = {line, line + strlen(line), s->label, 1};
    for (int i = 0; i < 5; i++) next(&words, word[i]);
    if (strcmp(word[0], "%%matrixmarket") || strcmp(word[1], "matrix"))
        return bad(s, "not a Matrix Market file; its first line is '%%%%MatrixMarket matrix "
                      "coordinate real symmetric' "
                      "or similar");
    out->coordinate = !strcmp(word[2], "coordinate");
    out->symmetric = !strcmp(word[4], "symmetric");
    if (!out->coordinate && strcmp(word[2], "array"))
        return bad(s, "format '%s'; it must be coordinate or array", word[2]);
    if (strcmp(word[3], "real") && strcmp(word[3], "integer"))
        return bad(s, "'%s' entries; mass and stiffness need real or integer ones", word[3]);
    if (!out->symmetric && strcmp(word[4], "general"))
        return bad(s, "'%s' matrix; it must be symmetric or general", word[4]);
    s->at += length;
    return RIC_OK;
}

static ric_status read_header(scanner *s, header *out)
{
    long rows = 0, columns = 0;
    ric_status status = read_banner(s, out);
    if (!status) status = next_integer(s, "the number of rows", RIC_MATRIX_MAX, &rows);
    if (!status) status = next_integer(s, "the number of columns", RIC_MATRIX_MAX, &columns);
    if (!status && rows != columns)
        status = bad(s, "%ld rows but %ld columns; mass and stiffness are square", rows, columns);
    if (status) return status;
    long full = out->symmetric ? rows * (rows + 1) / 2 : rows * rows;
    out->n = (int)rows;
    out->entries = full;
    if (out->coordinate)
        status = next_integer(s, "the number of entries", ENTRIES_MAX, &out->entries);
    return status;
}

/* ----------------------------------------------------------------- entries */

static ric_status read_array(scanner *s, const header *h, double *out)
{
    long n = h->n;
    for (long column = 0; column < n; column++)
        for (long row = h->symmetric ? column : 0; row < n; row++) {
            ric_status status = next_real(s, row + 1, column + 1, &out[row * n + column]);
            if (status) return status;
            if (h->symmetric) out[column * n + row] = out[row * n + column];
        }
    return RIC_OK;
}

/* `given` [n * n]: places of the file that have been read. */
static ric_status read_entry(scanner *s, const header *h, bool *given, double *out, long *repeated)
{
    long row = 0, column = 0, n = h->n;
    double value = 0;
    ric_status status = next_integer(s, "a row", n, &row);
    if (!status) status = next_integer(s, "a column", n, &column);
    if (status) return status;
    long at = (row - 1) * n + column - 1, across = (column - 1) * n + row - 1;
    if (h->symmetric && row != column && given[across])
        return bad(s,
                   "row %ld, column %ld, and row %ld, column %ld as well: whether that is one "
                   "entry or the sum of "
                   "two cannot be told; write one half of a symmetric matrix, or general in the "
                   "first line",
                   row, column, column, row);
    *repeated += given[at];
    given[at] = true;
    if ((status = next_real(s, row, column, &value))) return status;
    out[at] += value;
    if (h->symmetric) out[across] = out[at];
    return isfinite(out[at])
               ? RIC_OK
               : bad(s, "the entries of row %ld, column %ld have no finite sum", row, column);
}

static ric_status read_coordinate(scanner *s, const header *h, double *out, long *repeated)
{
    ric_status status = RIC_OK;
    bool *given = ric_calloc((size_t)h->n * (size_t)h->n, sizeof *given);
    if (!given) return ric_fail(RIC_E_NOMEM, "%s: no memory for the matrix", s->label);
    for (long i = 0; i < h->entries && !status; i++)
        status = read_entry(s, h, given, out, repeated);
    free(given);
    return status;
}

ric_status ric_matrix_market_parse(const char *text, size_t size, const char *label, int *n,
                                   double **out, long *repeated)
{
    scanner s = {text, text + size, label, 1};
    header h = {false, false, 0, 0};
    char word[TOKEN_MAX];
    double *matrix = NULL;
    ric_status status = read_header(&s, &h);
    if (status) goto out;
    matrix = ric_calloc((size_t)h.n * (size_t)h.n, sizeof *matrix);
    if (!matrix) {
        status = ric_fail(RIC_E_NOMEM, "%s: no memory for the matrix", label);
        goto out;
    }
    long twice = 0;
    status = h.coordinate ? read_coordinate(&s, &h, matrix, &twice) : read_array(&s, &h, matrix);
    if (status) goto out;
    next(&s, word);
    if (word[0]) {
        status = bad(&s, "'%s' follows after the last of %ld entries; check the size line", word,
                     h.entries);
        goto out;
    }
    *n = h.n;
    if (repeated) *repeated = twice;
    *out = matrix;
    matrix = NULL;
out:
    free(matrix);
    return status;
}

ric_status ric_matrix_market_read(const char *path, int *n, double **out, long *repeated)
{
    char *text = NULL;
    size_t size = 0;
    ric_status status = ric_file_read(path, FILE_MAX, true, &text, &size);
    if (!status) status = ric_matrix_market_parse(text, size, path, n, out, repeated);
    free(text);
    return status;
}
