/* docs/article.md: its parts between <!-- NAME --> and <!-- end of NAME --> are written by tests,
 * the rest by hand. */
#ifndef ARTICLE_PAGE_H
#define ARTICLE_PAGE_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define ARTICLE_PAGE "docs/article.md" /* tests run in the root of the source */
enum { PAGE_ROOM = 1 << 18 };

static char *page_read(const char *path)
{
    char *text = calloc(PAGE_ROOM, 1);
    FILE *file = fopen(path, "r");
    if (!file) fail_msg("%s is not there", path);
    assert_true(fread(text, 1, PAGE_ROOM - 1, file) < PAGE_ROOM - 1);
    fclose(file);
    return text;
}

/* The part of that name is `text`; with UPDATE in the environment it becomes so. */
static void page_part(const char *name, const char *text)
{
    char begin[64], end[64], *page = page_read(ARTICLE_PAGE);
    snprintf(begin, sizeof begin, "<!-- %s -->\n", name);
    snprintf(end, sizeof end, "<!-- end of %s -->\n", name);
    char *from = strstr(page, begin), *to = strstr(page, end);
    if (!from || !to || to < from) fail_msg("%s has no part '%s'", ARTICLE_PAGE, name);
    from += strlen(begin);
    if (getenv("UPDATE")) {
        FILE *file = fopen(ARTICLE_PAGE, "w");
        assert_non_null(file);
        fprintf(file, "%.*s%s%s", (int)(from - page), page, text, to);
        assert_int_equal(fclose(file), 0);
    } else {
        *to = '\0';
        assert_string_equal(from, text);
    }
    free(page);
}

#endif
