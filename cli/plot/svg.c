/* Makes gnuplot's SVG smaller: pictures are kept in repositories and pages. Coordinates keep two
 * decimals, so that curves stay smooth when they are magnified, runs of blanks become one, and
 * groups without content go. */
#define _POSIX_C_SOURCE 200809L

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "plot.h"

/* Numbers up to the closing quote, rounded; returns behind it. */
static const char *coordinates(const char *c, FILE *out)
{
    while (*c && *c != '\'') {
        char *end;
        const double value = *c == '-' || isdigit((unsigned char)*c) ? strtod(c, &end) : 0;
        if (*c == '-' || isdigit((unsigned char)*c)) {
            const double rounded = round(100 * value) / 100;
            fprintf(out, "%.9g", rounded == 0 ? 0 : rounded);
            c = end > c ? end : c + 1;
        } else if (isspace((unsigned char)*c)) {
            c += strspn(c, " \t\r\n");
            if (*c != '\'') fputc(' ', out);
        } else {
            fputc(*c++, out);
        }
    }
    return c;
}

/* Length of an empty group at c, 0 if there is none. */
static size_t empty_group(const char *c)
{
    static const char head[] = "<g fill=", tail[] = "</g>\n";
    const size_t line = strcspn(c, "\n");
    return !strncmp(c, head, sizeof head - 1) && c[line] &&
                   !strncmp(c + line + 1, tail, sizeof tail - 1)
               ? line + 1 + sizeof tail - 1
               : 0;
}

static void squeeze(const char *c, FILE *out)
{
    static const char *const opens[] = {" d='", "points = '"};
    while (*c) {
        const size_t skip = empty_group(c);
        if (skip) {
            c += skip;
            continue;
        }
        for (int i = 0; i < 2; i++)
            if (!strncmp(c, opens[i], strlen(opens[i]))) {
                fputs(opens[i], out);
                c = coordinates(c + strlen(opens[i]), out);
            }
        if (*c == '\t') c++;
        else if (*c) fputc(*c++, out);
    }
}

bool plot_svg_squeeze(FILE *from, FILE *to)
{
    char *text = NULL;
    size_t used = 0, room = 0;
    bool good = true;
    rewind(from);
    do {
        if (used + 65536 > room) {
            room = 2 * room + 131072;
            char *more = realloc(text, room);
            if (!more) {
                good = false;
                break;
            }
            text = more;
        }
        used += fread(text + used, 1, room - used - 1, from);
    } while (!feof(from) && !ferror(from));
    if (good && !ferror(from)) {
        text[used] = '\0';
        squeeze(text, to);
    }
    free(text);
    return good && !ferror(from) && fflush(to) == 0 && !ferror(to);
}
