#include "continuation_pause.h"

#include <stdlib.h>
#include <string.h>

#include "orbit/room.h"
#include "continuation_pack.h"
#include "base/room.h"

/* PAUSE_FORMAT: changes with the layout, which is private to one version on one type of machine */
#define PAUSE_FORMAT 7

/* -------------------------------------------------------------------- bytes */

typedef struct {
    int32_t format, parts, begun, n_unknown, n_pair, n_resonance;
    uint64_t n_trace; /* bytes of what is kept of a finished trace, too, which come first */
} head;

static void pass_station(ric_bytes *b, ric_station *p, int n_unknown, int n_pair)
{
    ric_bytes_pass(b, &p->s, sizeof p->s);
    ric_bytes_pass(b, p->u, (size_t)n_unknown * sizeof *p->u);
    ric_bytes_pass(b, p->t, (size_t)n_unknown * sizeof *p->t);
    ric_bytes_pass(b, p->test, sizeof p->test);
    ric_bytes_pass(b, p->factor, sizeof p->factor);
    ric_bytes_pass(b, p->hidden, sizeof p->hidden);
    ric_bytes_pass(b, p->own, 2 * (size_t)n_pair * sizeof *p->own);
    ric_bytes_pass(b, p->error, (size_t)n_pair * sizeof *p->error);
    ric_bytes_pass(b, &p->row, sizeof p->row);
}

static void pass_stations(ric_bytes *b, ric_continuation *tr, ric_continuation_place *place)
{
    int size = tr->chain->n_unknown, n_pair = tr->floquet.n_pair;
    ric_bytes_pass(b, place, sizeof *place);
    pass_station(b, &tr->now, size, n_pair);
    pass_station(b, &tr->past, size, n_pair);
    ric_bytes_pass(b, tr->start_u, (size_t)size * sizeof *tr->start_u);
    ric_bytes_pass(b, tr->start_t, (size_t)size * sizeof *tr->start_t);
    ric_bytes_pass(b, tr->passed, (size_t)tr->n_resonance * sizeof *tr->passed);
    ric_bytes_pass(b, tr->samples.s, sizeof tr->samples.s);
    ric_bytes_pass(b, tr->samples.values,
                   RIC_PAST_SAMPLES * (size_t)ric_continuation_watched(tr) * sizeof(double));
}

typedef struct {
    head head;
    void *packed;
    ric_continuation trace; /* what it points to is only read */
} paused;

static void pass_paused(ric_bytes *b, void *user)
{
    paused *p = user;
    ric_bytes_pass(b, &p->head, sizeof p->head);
    if (!p->head.begun) return;
    ric_continuation_place place = ric_continuation_mark(&p->trace);
    ric_bytes_pass(b, p->packed, p->head.n_trace);
    pass_stations(b, &p->trace, &place);
}

ric_status ric_continuation_pause(const ric_continuation *trace, int parts, void **blob,
                                  size_t *size)
{
    paused p = {.head = {.format = PAUSE_FORMAT, .parts = parts, .begun = trace != NULL}};
    size_t n_trace = 0;
    *blob = NULL;
    if (trace) {
        ric_status status = ric_continuation_pack(trace, &p.packed, &n_trace);
        if (status) return status;
        p.trace = *trace;
        p.head.n_unknown = trace->chain->n_unknown;
        p.head.n_pair = trace->floquet.n_pair;
        p.head.n_resonance = trace->n_resonance;
        p.head.n_trace = n_trace;
    }
    *blob = ric_bytes_make(pass_paused, &p, size);
    free(p.packed);
    return *blob ? RIC_OK : ric_no_memory("a branch that is kept");
}

/* A file may hold anything: a step that is no number would never end. */
static bool sane(const ric_continuation *tr, const ric_continuation_place *p)
{
    const ric_carried *c = &p->carried;
    double sum = c->step + c->step_max + c->wanted + c->after + c->blind + c->lowest + p->scale +
                 tr->now.s + (c->has_past ? tr->past.s : 0);
    for (int i = 0; i < tr->chain->n_unknown; i++) {
        sum += tr->now.u[i] + tr->now.t[i] + tr->start_u[i] + tr->start_t[i];
        if (c->has_past) sum += tr->past.u[i] + tr->past.t[i];
    }
    return isfinite(sum) && c->step > 0 && c->step_max > 0 && c->wanted >= 0 && c->after >= 0 &&
           c->longest > 0 && p->scale >= 1 && p->n_point == tr->n_point &&
           p->n_event == tr->n_event && tr->n_point > 0 && p->n_past >= 0 &&
           p->n_past <= RIC_PAST_SAMPLES && (!c->has_past || tr->now.s > tr->past.s);
}

/* A trace that had begun, and its place. */
static ric_status take_up(ric_bytes *b, const head *h, const ric_model *model,
                          const ric_limits *limits, ric_continuation **out)
{
    ric_continuation_place place;
    if (!ric_bytes_have(b, h->n_trace)) return RIC_E_FORMAT;
    ric_status status = ric_continuation_unpack(model, limits, b->at, h->n_trace, out);
    ric_continuation *tr = *out;
    if (!status && (tr->chain->n_unknown != h->n_unknown || tr->chain->n - 1 != h->n_pair ||
                    tr->n_resonance != h->n_resonance))
        return RIC_E_FORMAT;
    if (!status) status = ric_continuation_equip(tr);
    if (status) return status;
    ric_bytes rest = ric_bytes_of(b->at + h->n_trace, b->size - h->n_trace);
    pass_stations(&rest, tr, &place);
    if (rest.lost || !sane(tr, &place)) return RIC_E_FORMAT;
    ric_continuation_return(tr, &place);
    return RIC_OK;
}

ric_status ric_continuation_resume(const ric_model *model, const ric_limits *limits,
                                   const void *blob, size_t size, int *parts,
                                   ric_continuation **out)
{
    ric_bytes b = ric_bytes_of(blob, size);
    head h;
    *parts = 0;
    *out = NULL;
    ric_bytes_pass(&b, &h, sizeof h);
    if (b.lost || h.format != PAUSE_FORMAT || h.parts < 0 || h.parts > RIC_PARTS_MOST)
        return RIC_E_FORMAT;
    ric_status status = h.begun ? take_up(&b, &h, model, limits, out) : RIC_OK;
    if (status) {
        ric_continuation_free(*out);
        *out = NULL;
        return status == RIC_E_NOMEM ? status : RIC_E_FORMAT;
    }
    *parts = h.parts;
    return RIC_OK;
}
