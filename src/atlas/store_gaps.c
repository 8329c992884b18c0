/* Tongues that branches have stepped over, as lines of one text of the file: a reader that does not
 * know of them finds the same tables as ever, and an atlas without them has no such text. */
#include <ctype.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "model/room.h"
#include "store_parts.h"

enum { NUMBERS = 5 }; /* of a line: branch, point, mode, turns, others */
/* OFF: turns by which the frequency of a linear mode may be off, of rounding and, once more, of
 * each contact during which a spring is closed for a while. */
#define OFF 1

ric_status ric_store_put_gaps(ric_database file, const ric_atlas *atlas)
{
    ric_buffer out;
    ric_status status = ric_store_sqlite_run(file, "DELETE FROM meta WHERE key = 'gaps'");
    if (status) return status;
    if (!ric_buffer_open(&out)) return ric_store_fail_memory();
    for (int k = 0; k < atlas->n_branch; k++)
        for (int i = 0; i < atlas->branches[k].n_gap; i++) {
            const ric_atlas_gap *gap = &atlas->branches[k].gaps[i];
            fprintf(out.file, "%d %d %d %d %d\n", k + 1, gap->point, gap->mode, gap->turns,
                    gap->others);
        }
    char *text = ric_buffer_take(&out);
    if (!text) return ric_store_fail_memory();
    if (*text) status = ric_store_put_meta(file, "gaps", text);
    free(text);
    return status;
}

/* The whole numbers of a line, which ends behind them; NULL: they are none. */
static const char *take_line(const char *at, int out[NUMBERS])
{
    for (int i = 0; i < NUMBERS; i++) {
        long value = 0;
        if (!isdigit((unsigned char)*at)) return NULL;
        for (; isdigit((unsigned char)*at) && value <= INT_MAX; at++)
            value = 10 * value + (*at - '0');
        if (value > INT_MAX || *at++ != (i + 1 < NUMBERS ? ' ' : '\n')) return NULL;
        out[i] = (int)value;
    }
    return at;
}

/* Whether the mode passes its turns between the two points, and the gap lies behind those before
 * it. */
static bool fits(const ric_atlas *atlas, int branch, const ric_atlas_gap *gap)
{
    const ric_model *m = ric_atlas_model(atlas);
    if (branch < 1 || branch > atlas->n_branch || gap->mode < 1 || gap->mode > m->n_dof ||
        gap->turns < 1)
        return false;
    const ric_branch_record *r = &atlas->branches[branch - 1];
    if (gap->point < 0 || gap->point > r->row.n_point - 2) return false;
    if (r->n_gap && gap->point <= r->gaps[r->n_gap - 1].point) return false;
    double turns[2];
    for (int i = 0; i < 2; i++)
        turns[i] = m->frequency[gap->mode - 1] /
                   ric_atlas_point_row(atlas, branch, gap->point + i).point.frequency;
    const double off = OFF * (1.0 + r->row.impacts);
    return fmin(turns[0], turns[1]) - off <= gap->turns &&
           gap->turns <= fmax(turns[0], turns[1]) + off;
}

ric_status ric_store_read_gaps(ric_database file, ric_atlas *atlas)
{
    char *text = NULL;
    int line[NUMBERS], last = 0;
    ric_status status = ric_store_get_meta(file, "gaps", &text);
    for (const char *at = text; !status && at && *at;) {
        at = take_line(at, line);
        const ric_atlas_gap gap = {.point = line[1],
                                   .mode = line[2],
                                   .turns = line[3],
                                   .others = line[4]};
        if (!at || line[0] < last || !fits(atlas, line[0], &gap)) {
            status = ric_store_fail_damaged(file.path, "table meta, row gaps: no gap of a branch");
            break;
        }
        last = line[0];
        ric_branch_record *r = &atlas->branches[last - 1];
        ric_atlas_gap *gaps = ric_realloc(r->gaps, ((size_t)r->n_gap + 1) * sizeof *gaps);
        if (!gaps) status = ric_store_fail_memory();
        else {
            r->gaps = gaps;
            gaps[r->n_gap++] = gap;
        }
    }
    free(text);
    return status;
}
