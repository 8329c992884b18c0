#include "continuation_pack.h"

#include <stdlib.h>
#include <string.h>

#include "orbit/room.h"
#include "base/room.h"

/* The layout is private to one version on one machine type: PACK_FORMAT changes with it, and what another version has
 * stored is dropped when a run begins (ric_continuation_version). */
#define PACK_FORMAT 7
#define TEXT_OF(value) #value
#define TEXT(macro) TEXT_OF(macro)
#define SANE 10000000

typedef struct {
    int32_t format, start, end, sigma, n_flight, parts, n_point, n_event, stop, why, arrival, end_test;
} header;

const char *ric_continuation_version(void)
{
    return TEXT(RIC_NUMERICS) "." TEXT(PACK_FORMAT);
}

static size_t packed_size(const ric_continuation *tr)
{
    size_t unknowns = (size_t)tr->chain->n_unknown, events = (size_t)tr->n_event + 1;
    return sizeof(header) + ((size_t)tr->chain->n_flight + 1) * sizeof(int32_t) +
           (size_t)tr->n_point * tr->stride * sizeof(double) +
           events * (sizeof(double) * (2 * unknowns + 1) + sizeof(int32_t)) + sizeof(uint64_t) + 5 * sizeof(double) +
           sizeof(int); /* closed springs, blind, unresolved, and where */
}

static void write(char **to, const void *from, size_t size)
{
    memcpy(*to, from, size);
    *to += size;
}

static void write_event(char **to, const ric_event *e, int size)
{
    int32_t test = e->u ? e->test : -1;
    write(to, &test, sizeof test);
    if (test < 0) return;
    write(to, &e->s, sizeof e->s);
    write(to, e->u, (size_t)size * sizeof *e->u);
    write(to, e->t, (size_t)size * sizeof *e->t);
}

ric_status ric_continuation_pack(const ric_continuation *tr, void **blob, size_t *size)
{
    const ric_shooting *c = tr->chain;
    char *start = ric_malloc(packed_size(tr)), *to = start;
    if (!start) return ric_no_memory("a branch that is kept");
    header h = {PACK_FORMAT, c->start,    c->end,   c->sigma,         c->n_flight, c->parts,
                tr->n_point, tr->n_event, tr->stop, (int32_t)tr->why, tr->arrival, tr->end.test};
    write(&to, &h, sizeof h);
    for (int i = 0; i <= c->n_flight; i++) {
        int32_t face = c->face[i];
        write(&to, &face, sizeof face);
    }
    if (!ric_flight_law_of(c->model)->turns) write(&to, c->closed, sizeof *c->closed);
    write(&to, &tr->blind, sizeof tr->blind);
    write(&to, &tr->unresolved, sizeof tr->unresolved);
    write(&to, tr->blind_at, sizeof tr->blind_at);
    write(&to, tr->crowded_at, sizeof tr->crowded_at);
    write(&to, tr->points, (size_t)tr->n_point * tr->stride * sizeof *tr->points);
    for (int i = 0; i < tr->n_event; i++) write_event(&to, &tr->events[i], c->n_unknown);
    write_event(&to, &tr->end, c->n_unknown);
    *blob = start;
    *size = (size_t)(to - start);
    return RIC_OK;
}

/* Reads `size` bytes or says that there are not as many. */
static bool take(const char **from, size_t *left, void *to, size_t size)
{
    if (*left < size) return false;
    memcpy(to, *from, size);
    *from += size;
    *left -= size;
    return true;
}

static bool read_event(const char **from, size_t *left, int size, int n_test, ric_event *e)
{
    int32_t test;
    size_t bytes = (size_t)size * sizeof(double);
    if (!take(from, left, &test, sizeof test)) return false;
    e->test = test;
    if (test < 0) return true;
    if (test >= n_test) return false;
    e->u = ric_malloc(bytes);
    e->t = ric_malloc(bytes);
    return e->u && e->t && take(from, left, &e->s, sizeof e->s) && take(from, left, e->u, bytes) &&
           take(from, left, e->t, bytes);
}

ric_status ric_continuation_unpack(const ric_model *m, const ric_limits *limits, const void *blob, size_t size,
                                   ric_continuation **out)
{
    const char *from = blob;
    header h;
    ric_status status = RIC_OK;
    ric_continuation *tr = ric_calloc(1, sizeof *tr);
    int *face = NULL;
    *out = NULL;
    if (!tr) return ric_no_memory("a branch");
    tr->end.test = -1;
    tr->limits = limits;
    if (!take(&from, &size, &h, sizeof h) || h.format != PACK_FORMAT || h.n_flight < 1 || h.n_flight > SANE ||
        h.parts < 1 || h.parts > RIC_PARTS_MOST || (h.parts > 1 && !ric_flight_law_of(m)->integrated) ||
        h.n_point < 0 || h.n_point > SANE || h.n_event < 0 || h.n_event > SANE || h.start < 0 ||
        h.start > RIC_MIRROR_CENTRE || h.end < 0 || h.end > RIC_MIRROR_CENTRE || h.stop < 0 ||
        h.stop > RIC_STOP_FAILED || h.why < 0 || h.why >= RIC_N_WHY || (size_t)h.n_flight * sizeof(int32_t) > size)
        goto damaged;
    if (!(face = ric_calloc((size_t)h.n_flight + 1, sizeof *face))) goto damaged;
    for (int i = 0; i <= h.n_flight; i++) {
        int32_t f;
        if (!take(&from, &size, &f, sizeof f) || f < -1 || f >= m->n_face) goto damaged;
        face[i] = f;
    }
    if ((status = ric_shooting_create(m, (ric_mirror)h.start, (ric_mirror)h.end, h.sigma < 0 ? -1 : 1, h.n_flight, face,
                                      &tr->chain)))
        goto out;
    uint64_t closed = 0;
    if (!ric_flight_law_of(m)->turns && !take(&from, &size, &closed, sizeof closed)) goto damaged;
    ric_shooting_close(tr->chain, closed);
    if (!take(&from, &size, &tr->blind, sizeof tr->blind)) goto damaged;
    if (!take(&from, &size, &tr->unresolved, sizeof tr->unresolved)) goto damaged;
    if (!take(&from, &size, tr->blind_at, sizeof tr->blind_at)) goto damaged;
    if (!take(&from, &size, tr->crowded_at, sizeof tr->crowded_at)) goto damaged;
    if (h.parts > 1 && (status = ric_shooting_nodes_divide(tr->chain, h.parts))) goto out;
    if (!ric_continuation_resonances(tr)) goto damaged;
    tr->stride = sizeof(ric_point) / sizeof(double) + (size_t)tr->chain->n_unknown;
    size_t bytes = (size_t)h.n_point * tr->stride * sizeof(double);
    if (bytes > size || !(tr->points = ric_malloc(bytes ? bytes : 1))) goto damaged;
    take(&from, &size, tr->points, bytes);
    tr->n_point = tr->point_capacity = h.n_point;
    int n_test = RIC_N_TEST + tr->n_resonance + limits->n_asked;
    if (!(tr->events = ric_calloc((size_t)h.n_event + 1, sizeof *tr->events))) goto damaged;
    tr->event_capacity = h.n_event + 1;
    for (int i = 0; i < h.n_event; i++) {
        tr->n_event = i + 1;
        if (!read_event(&from, &size, tr->chain->n_unknown, n_test, &tr->events[i])) goto damaged;
    }
    if (!read_event(&from, &size, tr->chain->n_unknown, n_test, &tr->end)) goto damaged;
    tr->stop = (ric_stop)h.stop;
    tr->arrival = h.arrival;
    tr->why = (ric_why)h.why;
    *out = tr;
    free(face);
    return RIC_OK;
damaged:
    status = ric_fail(RIC_E_FORMAT, "the atlas holds finished work that cannot be read: the file is "
                                    "damaged; move it away and run again");
out:
    free(face);
    ric_continuation_free(tr);
    return status;
}
