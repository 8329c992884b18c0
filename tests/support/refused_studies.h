/* A good study line by line, with which tests of the reader begin, and what a bad one has to be
 * told. Needs cmocka.h before it. */
#ifndef REFUSED_STUDIES_H
#define REFUSED_STUDIES_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ricochet.h"

/* Line by line, so that a test can replace one: line 1 is title, 7 the normal, 8 the clearance, ...
 */
static const char *const good[] = {
    "title: Two masses",                                                        /* 1 */
    "model:",                                                                   /* 2 */
    "  mass: [[2, 0], [0, 1]]",                                                 /* 3 */
    "  stiffness: [[9, -1], [-1, 1]]",                                          /* 4 */
    "  contacts:",                                                              /* 5 */
    "    - name: stop",                                                         /* 6 */
    "      normal: [-1, 1]",                                                    /* 7 */
    "      clearance: 1.5",                                                     /* 8 */
    "      sides: both",                                                        /* 9 */
    "      law: rigid",                                                         /* 10 */
    "explore:",                                                                 /* 11 */
    "  start: [2, 1]",                                                          /* 12 */
    "  energy: [0, 100]",                                                       /* 13 */
    "  frequency: [0.2, 10]",                                                   /* 14 */
    "  impacts: 12",                                                            /* 15 */
    "  step: 0.05",                                                             /* 16 */
    "  symmetric: true",                                                        /* 17 */
    "names:",                                                                   /* 18 */
    "  - {name: C1_32, kind: branch-point, energy: 1.9013, frequency: 1.3820}", /* 19 */
    "tolerance: 1e-11",                                                         /* 20 */
};
enum { N_LINE = sizeof good / sizeof *good };

/* The good study with line `at` replaced (0: none). */
static inline char *with_line(int at, const char *line)
{
    char *text = NULL;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    for (int i = 1; i <= N_LINE; i++) fprintf(out, "%s\n", i == at ? line : good[i - 1]);
    fclose(out);
    return text;
}

static inline void refused(const char *text, int line, const char *key, const char *const *says)
{
    char place[200];
    ric_study *study = NULL;
    ric_status status = ric_study_parse(text, "dir/s.yaml", NULL, &study);
    if (status != RIC_E_INPUT) print_error("accepted:\n%s\n", text);
    assert_int_equal(status, RIC_E_INPUT);
    assert_null(study);
    snprintf(place, sizeof place, "dir/s.yaml:%d: %s", line, key);
    if (strncmp(ric_detail(), place, strlen(place)))
        print_error("wanted '%s', got '%s'\n", place, ric_detail());
    assert_memory_equal(ric_detail(), place, strlen(place));
    assert_null(strchr(ric_detail(), '\n'));
    for (; *says; says++) {
        if (!strstr(ric_detail(), *says)) print_error("no '%s' in '%s'\n", *says, ric_detail());
        assert_non_null(strstr(ric_detail(), *says));
    }
}

#define SAYS(...) ((const char *const[]){__VA_ARGS__, NULL})

static inline void line_refused(int at, const char *line, const char *key, const char *const *says)
{
    char *text = with_line(at, line);
    refused(text, at, key, says);
    free(text);
}

#endif
