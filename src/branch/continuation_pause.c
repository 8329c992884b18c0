#include "continuation_pause.h"

#include <stdlib.h>
#include <string.h>

#include "orbit/room.h"
#include "continuation_pack.h"
#include "base/room.h"

#define PAUSE_FORMAT 4 /* changes with the layout, which is private to one version on one type of machine */

/* -------------------------------------------------------------------- bytes */

typedef struct {
    int32_t format, parts, begun, n_unknown, n_pair, n_resonance;
} head;

/* The doubles of a station, and those of the start. */
static size_t station_size(int n_unknown, int n_pair)
{
    return 1 + 2 * (size_t)n_unknown + RIC_N_TEST + 6 + 2 * (size_t)n_pair + sizeof(ric_point) / sizeof(double);
}

typedef struct {
    char *at;
    bool reading;
} cursor;

static void pass(cursor *c, void *values, size_t size)
{
    if (c->reading) memcpy(values, c->at, size);
    else memcpy(c->at, values, size);
    c->at += size;
}

/* Out or in, so that both have one layout. */
static void pass_station(cursor *c, ric_station *p, int n_unknown, int n_pair)
{
    pass(c, &p->s, sizeof p->s);
    pass(c, p->u, (size_t)n_unknown * sizeof *p->u);
    pass(c, p->t, (size_t)n_unknown * sizeof *p->t);
    pass(c, p->test, sizeof p->test);
    pass(c, p->factor, sizeof p->factor);
    pass(c, p->hidden, sizeof p->hidden);
    pass(c, p->own, 2 * (size_t)n_pair * sizeof *p->own);
    pass(c, &p->row, sizeof p->row);
}

static void pass_stations(cursor *c, ric_continuation *tr, ric_continuation_place *place)
{
    int size = tr->chain->n_unknown, n_pair = tr->floquet.n_pair;
    pass(c, place, sizeof *place);
    pass_station(c, &tr->now, size, n_pair);
    pass_station(c, &tr->past, size, n_pair);
    pass(c, tr->start_u, (size_t)size * sizeof *tr->start_u);
    pass(c, tr->start_t, (size_t)size * sizeof *tr->start_t);
    pass(c, tr->samples.s, sizeof tr->samples.s);
    pass(c, tr->samples.values, RIC_PAST_SAMPLES * (size_t)(RIC_N_TEST + tr->n_resonance) * sizeof(double));
}

static size_t fixed_size(int n_unknown, int n_pair, int n_resonance)
{
    return sizeof(ric_continuation_place) + (2 * station_size(n_unknown, n_pair) + 2 * (size_t)n_unknown +
                                             RIC_PAST_SAMPLES * (1 + RIC_N_TEST + (size_t)n_resonance)) *
                                                sizeof(double);
}

ric_status ric_continuation_pause(const ric_continuation *trace, int parts, void **blob, size_t *size)
{
    head h = {PAUSE_FORMAT, parts, trace != NULL, 0, 0, 0};
    void *found = NULL;
    size_t n_found = 0, fixed = 0;
    ric_status status = RIC_OK;
    *blob = NULL;
    if (trace) {
        h.n_unknown = trace->chain->n_unknown;
        h.n_pair = trace->floquet.n_pair;
        h.n_resonance = trace->n_resonance;
        fixed = fixed_size(h.n_unknown, h.n_pair, h.n_resonance);
        if ((status = ric_continuation_pack(trace, &found, &n_found))) return status;
    }
    *size = sizeof h + fixed + n_found;
    cursor c = {.at = *blob = ric_malloc(*size)};
    if (!*blob) status = ric_no_memory("a branch that is kept");
    else pass(&c, &h, sizeof h);
    if (!status && trace) {
        ric_continuation_place here = ric_continuation_mark(trace);
        ric_continuation copy = *trace; /* what it points to is only read */
        pass_stations(&c, &copy, &here);
        memcpy(c.at, found, n_found);
    }
    free(found);
    return status;
}

/* A file may hold anything: a step that is no number would never end. */
static bool sane(const ric_continuation *tr, const ric_continuation_place *p)
{
    const ric_carried *c = &p->carried;
    double sum = c->step + c->step_max + c->wanted + c->after + c->blind + c->lowest + p->scale + tr->now.s +
                 (c->has_past ? tr->past.s : 0);
    for (int i = 0; i < tr->chain->n_unknown; i++) {
        sum += tr->now.u[i] + tr->now.t[i] + tr->start_u[i] + tr->start_t[i];
        if (c->has_past) sum += tr->past.u[i] + tr->past.t[i];
    }
    return isfinite(sum) && c->step > 0 && c->step_max > 0 && c->wanted >= 0 && c->after >= 0 && c->longest > 0 &&
           p->scale >= 1 && p->n_point == tr->n_point && p->n_event == tr->n_event && tr->n_point > 0 &&
           p->n_past >= 0 && p->n_past <= RIC_PAST_SAMPLES && (!c->has_past || tr->now.s > tr->past.s);
}

ric_status ric_continuation_resume(const ric_model *model, const ric_limits *limits, const void *blob, size_t size,
                                   int *parts, ric_continuation **out)
{
    const ric_status foreign = RIC_E_FORMAT;
    head h;
    ric_continuation *tr = NULL;
    *parts = 0;
    *out = NULL;
    if (size < sizeof h) return foreign;
    memcpy(&h, blob, sizeof h);
    if (h.format != PAUSE_FORMAT || h.parts < 0 || h.parts > RIC_PARTS_MOST || h.n_unknown < 0 || h.n_pair < 0 ||
        h.n_resonance < 0 || (size_t)h.n_resonance > size || (size_t)h.n_unknown > size || (size_t)h.n_pair > size)
        return foreign;
    if (h.begun) {
        size_t fixed = sizeof h + fixed_size(h.n_unknown, h.n_pair, h.n_resonance);
        if (size < fixed) return foreign;
        ric_status status = ric_continuation_unpack(model, limits, (const char *)blob + fixed, size - fixed, &tr);
        if (!status &&
            (tr->chain->n_unknown != h.n_unknown || tr->chain->n - 1 != h.n_pair || tr->n_resonance != h.n_resonance))
            status = foreign;
        if (!status) status = ric_continuation_equip(tr);
        if (!status) {
            ric_continuation_place place;
            cursor c = {(char *)(uintptr_t)blob + sizeof h, true};
            pass_stations(&c, tr, &place);
            if (sane(tr, &place)) ric_continuation_return(tr, &place);
            else status = foreign;
        }
        if (status) {
            ric_continuation_free(tr);
            return status == RIC_E_NOMEM ? status : foreign;
        }
    }
    *parts = h.parts;
    *out = tr;
    return RIC_OK;
}
