/* Where a trace stands between two steps, and back to there: what a step hands to the next. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "continuation.h"

ric_continuation_place ric_continuation_mark(const ric_continuation *tr)
{
    ric_continuation_place here;
    memset(&here, 0, sizeof here); /* its bytes are stored */
    memcpy(here.definite, tr->definite, sizeof here.definite);
    here.step = tr->step;
    here.step_max = tr->step_max;
    here.wanted = tr->wanted;
    here.after = tr->after;
    here.longest = tr->longest;
    here.blind = tr->blind;
    here.lowest = tr->lowest;
    memcpy(here.blind_at, tr->blind_at, sizeof here.blind_at);
    memcpy(here.crowded_at, tr->crowded_at, sizeof here.crowded_at);
    here.scale = tr->chain->scale;
    here.n_point = tr->n_point;
    here.n_event = tr->n_event;
    here.n_past = tr->samples.n_past;
    here.unresolved = tr->unresolved;
    here.approaches = tr->approaches;
    here.avoided = tr->avoided;
    here.steep = tr->steep;
    here.has_past = tr->has_past;
    here.ignore = tr->ignore;
    return here;
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
    memcpy(tr->definite, to->definite, sizeof tr->definite);
    tr->step = to->step;
    tr->step_max = to->step_max;
    tr->wanted = to->wanted;
    tr->after = to->after;
    tr->longest = to->longest;
    tr->blind = to->blind;
    tr->lowest = to->lowest;
    memcpy(tr->blind_at, to->blind_at, sizeof tr->blind_at);
    memcpy(tr->crowded_at, to->crowded_at, sizeof tr->crowded_at);
    tr->chain->scale = to->scale;
    tr->n_point = to->n_point;
    tr->samples.n_past = to->n_past;
    tr->unresolved = to->unresolved;
    tr->approaches = to->approaches;
    tr->avoided = to->avoided;
    tr->steep = to->steep;
    tr->has_past = to->has_past;
    tr->ignore = to->ignore;
}

void ric_continuation_widen(const ric_continuation *tr, bool first, double range[2])
{
    double least = fmin(tr->now.row.energy, tr->next.row.energy),
           largest = fmax(tr->now.row.energy, tr->next.row.energy);
    range[0] = first ? least : fmin(range[0], least);
    range[1] = first ? largest : fmax(range[1], largest);
}
