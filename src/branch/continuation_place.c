/* Where a trace stands between two steps, and back to there: what a step hands to the next. */
#include <math.h>
#include <stdlib.h>

#include "continuation.h"

ric_continuation_place ric_continuation_mark(const ric_continuation *tr)
{
    return (ric_continuation_place){.carried = tr->carried,
                                    .scale = tr->chain->scale,
                                    .n_point = tr->n_point,
                                    .n_event = tr->n_event,
                                    .n_past = tr->samples.n_past,
                                    .n_gap = tr->n_gap};
}

void ric_continuation_return(ric_continuation *tr, const ric_continuation_place *to)
{
    for (; tr->n_event > to->n_event; tr->n_event--) {
        free(tr->events[tr->n_event - 1].u);
        free(tr->events[tr->n_event - 1].t);
    }
    free(tr->end.u);
    free(tr->end.t);
    tr->end = (ric_event){.test = -1};
    tr->arrival = false;
    tr->stop = 0;
    tr->why = 0;
    tr->carried = to->carried;
    tr->chain->scale = to->scale;
    tr->n_point = to->n_point;
    tr->samples.n_past = to->n_past;
    tr->n_gap = to->n_gap;
}

void ric_continuation_widen(bool first, double a, double b, double range[2])
{
    const double least = fmin(a, b), largest = fmax(a, b);
    range[0] = first ? least : fmin(range[0], least);
    range[1] = first ? largest : fmax(range[1], largest);
}

int ric_continuation_points_until(const ric_continuation *tr, double s)
{
    int n = 0;
    while (n < tr->n_point && ric_continuation_row(tr, n)->arclength <= s) n++;
    return n;
}

double ric_continuation_place_end(ric_continuation *tr, const double *u)
{
    const int size = tr->chain->n_unknown;
    double apart = 0, along = -1;
    for (; tr->n_point > 1; tr->n_point--) {
        const double *last = (const double *)(ric_continuation_row(tr, tr->n_point - 1) + 1),
                     *before = (const double *)(ric_continuation_row(tr, tr->n_point - 2) + 1);
        apart = along = 0;
        for (int i = 0; i < size; i++) {
            apart += (u[i] - last[i]) * (u[i] - last[i]);
            along += (u[i] - last[i]) * (last[i] - before[i]);
        }
        if (along > 0) break;
    }
    return ric_continuation_row(tr, tr->n_point - 1)->arclength + (along > 0 ? sqrt(apart) : 0);
}
