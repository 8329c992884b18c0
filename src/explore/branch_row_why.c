/* What is said of a branch: why it ends, and what may be missing on it, of which kind and between
 * which energies. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "rows_parts.h"

/* A range is printed with some digits, and a hair wider than it is, so that what lies in it is in
 * what is read. */
#define WIDER 1e-6
#define FIXED 512 /* characters: all sentences without their lists */
#define EACH 96   /* and one event of a list */

static const char *name_of(int test)
{
    switch (test) {
    case RIC_TEST_SLOPE: return "extremum";
    case RIC_TEST_PERIOD: return "period extremum";
    case RIC_TEST_DET:
    case RIC_TEST_A:
    case RIC_TEST_B:
    case RIC_TEST_D: return "branch point";
    default: return test < RIC_N_TEST ? "event" : "asked-for value";
    }
}

static int list_unplaced(const ric_edge *e, const char *before, size_t size, char *text)
{
    int n = e->n_unplaced;
    int used = snprintf(text, size, "%s%d event%s on it do%s not converge to a junction (", before,
                        n, n == 1 ? "" : "s", n == 1 ? "es" : "");
    for (int i = 0; i < n; i++) {
        const ric_unplaced *u = &e->unplaced[i];
        char kind[48];
        if (u->q > 0) snprintf(kind, sizeof kind, "multiplication %d/%d", u->p, u->q);
        else snprintf(kind, sizeof kind, "%s", name_of(u->test));
        used += snprintf(text + used, size - (size_t)used, "%s%s at E %.9g omega %.9g",
                         i ? ", " : "", kind, u->energy, u->frequency);
    }
    return used + snprintf(text + used, size - (size_t)used, ")");
}

/* The range of a step reaches beyond the end of its branch: what is said is said of the branch. */
static int range_text(const ric_continuation *tr, const double range[2], size_t size, char *text)
{
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (int i = 0; i < tr->n_point; i++) {
        double energy = ric_continuation_row(tr, i)->energy;
        low = fmin(low, energy);
        high = fmax(high, energy);
    }
    low = fmin(fmax(low, range[0]), high);
    high = fmax(fmin(high, range[1]), low);
    return snprintf(text, size, " (E %.7g to %.7g)", low - WIDER * fabs(low),
                    high + WIDER * fabs(high));
}

/* The part that is blind is given to the next power of ten: the exact length depends on where
 * points lie. */
char *ric_branch_row_why(const ric_edge *e)
{
    const ric_continuation *tr = e->trace;
    const char *why = ric_continuation_why_text(tr->why);
    double length = ric_continuation_row(tr, tr->n_point - 1)->arclength;
    size_t size = strlen(why) + FIXED + EACH * (size_t)e->n_unplaced;
    char *text = ric_malloc(size);
    if (!text) return NULL;
    int used = snprintf(text, size, "%s", why);
    if (e->n_unplaced) used += list_unplaced(e, used ? "; " : "", size - (size_t)used, text + used);
    if (tr->blind > 0) {
        used += snprintf(text + used, size - (size_t)used,
                         "%son up to %g %% of it multipliers are lost in rounding and "
                         "multiplications not looked for",
                         used ? "; " : "", pow(10, ceil(log10(100 * fmin(1, tr->blind / length)))));
        used += range_text(tr, tr->blind_at, size - (size_t)used, text + used);
    }
    if (tr->unresolved > 0) {
        used += snprintf(text + used, size - (size_t)used,
                         "%sevents on it may lie closer together than can be told apart",
                         used ? "; " : "");
        range_text(tr, tr->crowded_at, size - (size_t)used, text + used);
    }
    return text;
}

static const char *earlier(const char *a, const char *b)
{
    return !a || (b && b < a) ? b : a;
}

/* The digit in front of " event" belongs to the sentence. */
static const char *clause(const char *why, const char *mark)
{
    const char *at = strstr(why, mark);
    while (at && at > why && at[-1] != ';') at--;
    while (at && *at == ' ') at++;
    return at;
}

const char *ric_branch_gaps(const ric_branch *branch)
{
    const char *why = branch->why;
    const char *first = earlier(clause(why, " on it do"),
                                clause(why, "of it multipliers are lost"));
    first = earlier(first, clause(why, "events on it may lie closer"));
    return first ? first : "";
}
