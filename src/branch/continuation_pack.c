#include "continuation_pack.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "orbit/room.h"
#include "base/room.h"

/* The layout is private to one version on one machine type: PACK_FORMAT changes with it, and what
 * another version has stored is dropped when a run begins (ric_continuation_version). */
#define PACK_FORMAT 11
#define TEXT_OF(value) #value
#define TEXT(macro) TEXT_OF(macro)
#define SANE 10000000

typedef struct {
    int32_t format, start, end, sigma, n_flight, parts, n_point, n_event, stop, why, arrival,
        end_test, n_gap;
} header;

const char *ric_continuation_version(void)
{
    return TEXT(RIC_NUMERICS) "." TEXT(PACK_FORMAT);
}

static void pass_event(ric_bytes *b, ric_event *e, int size, int n_test)
{
    const size_t bytes = (size_t)size * sizeof(double);
    int32_t test = e->u ? e->test : -1;
    ric_bytes_pass(b, &test, sizeof test);
    e->test = test;
    if (test < 0) return;
    b->lost |= test >= n_test;
    if (b->lost) return;
    if (b->reading) {
        e->u = ric_malloc(bytes);
        e->t = ric_malloc(bytes);
    }
    b->lost |= !e->u || !e->t;
    if (b->lost) return;
    ric_bytes_pass(b, &e->s, sizeof e->s);
    ric_bytes_pass(b, e->u, bytes);
    ric_bytes_pass(b, e->t, bytes);
}

/* What is known of a trace beside its form, its points and its events. */
static void pass_findings(ric_bytes *b, ric_continuation *tr, uint64_t *closed)
{
    if (!ric_flight_law_of(tr->chain->model)->turns) ric_bytes_pass(b, closed, sizeof *closed);
    ric_bytes_pass(b, &tr->blind, sizeof tr->blind);
    ric_bytes_pass(b, &tr->unresolved, sizeof tr->unresolved);
    ric_bytes_pass(b, tr->blind_at, sizeof tr->blind_at);
    ric_bytes_pass(b, tr->crowded_at, sizeof tr->crowded_at);
}

static void pass_found(ric_bytes *b, ric_continuation *tr)
{
    const int n_test = RIC_N_TEST + tr->n_resonance + tr->limits->n_asked;
    ric_bytes_pass(b, tr->points, (size_t)tr->n_point * tr->stride * sizeof *tr->points);
    for (int i = 0; i < tr->n_event && !b->lost; i++)
        pass_event(b, &tr->events[i], tr->chain->n_unknown, n_test);
    pass_event(b, &tr->end, tr->chain->n_unknown, n_test);
    ric_bytes_pass(b, tr->gaps, (size_t)tr->n_gap * sizeof *tr->gaps);
}

static void pack(ric_bytes *b, void *user)
{
    ric_continuation *tr = user;
    const ric_shooting *c = tr->chain;
    header h = {PACK_FORMAT,       (int32_t)c->start, (int32_t)c->end, c->sigma,
                c->n_flight,       c->parts,          tr->n_point,     tr->n_event,
                (int32_t)tr->stop, (int32_t)tr->why,  tr->arrival,     tr->end.test,
                tr->n_gap};
    ric_bytes_pass(b, &h, sizeof h);
    ric_bytes_pass(b, c->face, ((size_t)c->n_flight + 1) * sizeof *c->face);
    pass_findings(b, tr, c->closed);
    pass_found(b, tr);
}

ric_status ric_continuation_pack(const ric_continuation *tr, void **blob, size_t *size)
{
    ric_continuation copy = *tr; /* what it points to is only read */
    *blob = ric_bytes_make(pack, &copy, size);
    return *blob ? RIC_OK : ric_no_memory("a branch that is kept");
}

static bool sane(const header *h, const ric_model *m)
{
    return h->format == PACK_FORMAT && h->n_flight >= 1 && h->n_flight <= SANE && h->parts >= 1 &&
           h->parts <= RIC_PARTS_MOST && (h->parts == 1 || ric_flight_law_of(m)->integrated) &&
           h->n_point >= 1 && h->n_point <= SANE && h->n_event >= 0 && h->n_event <= SANE &&
           h->n_gap >= 0 && h->n_gap <= h->n_point && h->start >= 0 &&
           h->start <= RIC_MIRROR_CENTRE && h->end >= 0 && h->end <= RIC_MIRROR_CENTRE &&
           h->stop >= 0 && h->stop <= RIC_STOP_FAILED && h->why >= 0 && h->why < RIC_N_WHY;
}

static bool is_finite(int n, const double *values)
{
    for (int i = 0; i < n; i++)
        if (!isfinite(values[i])) return false;
    return true;
}

static bool sane_event(const ric_event *e, int size)
{
    return e->test < 0 || (isfinite(e->s) && is_finite(size, e->u) && is_finite(size, e->t));
}

/* Whether what was found is made of numbers: rows are made of it, and an atlas with others is
 * refused. */
static bool sane_found(const ric_continuation *tr)
{
    const int size = tr->chain->n_unknown;
    double last = 0;
    for (int i = 0; i < tr->n_point; i++) {
        const double *at = tr->points + (size_t)i * tr->stride;
        const ric_point *p = (const ric_point *)at;
        if (!(p->arclength >= last && isfinite(p->arclength) && isfinite(p->energy) &&
              p->frequency > 0 && isfinite(p->frequency) && p->stable >= RIC_STABLE_NO &&
              p->stable <= RIC_STABLE_UNDECIDED &&
              is_finite(size, at + sizeof(ric_point) / sizeof(double))))
            return false;
        last = p->arclength;
    }
    for (int i = 0; i < tr->n_event; i++)
        if (!sane_event(&tr->events[i], size)) return false;
    return sane_event(&tr->end, size);
}

/* The form of the orbits; RIC_E_FORMAT where it can be none. */
static ric_status unpack_chain(ric_bytes *b, const ric_model *m, const header *h,
                               ric_shooting **out)
{
    const size_t n = (size_t)h->n_flight + 1, bytes = n * sizeof(int);
    int *face = ric_bytes_have(b, bytes) ? ric_malloc(bytes) : NULL;
    if (!face) return RIC_E_FORMAT;
    ric_bytes_pass(b, face, bytes);
    for (size_t i = 0; i < n; i++) b->lost |= face[i] < -1 || face[i] >= m->n_face;
    ric_status status = b->lost
                            ? RIC_E_FORMAT
                            : ric_shooting_create(m, (ric_mirror)h->start, (ric_mirror)h->end,
                                                  h->sigma < 0 ? -1 : 1, h->n_flight, face, out);
    free(face);
    return status;
}

/* Room for the points and events that follow; false: there are not as many, or there is no memory.
 */
static bool make_room(const ric_bytes *b, const header *h, ric_continuation *tr)
{
    tr->stride = sizeof(ric_point) / sizeof(double) + (size_t)tr->chain->n_unknown;
    const size_t bytes = (size_t)h->n_point * tr->stride * sizeof(double);
    if (!ric_bytes_have(b, bytes + (size_t)h->n_event)) return false;
    tr->points = ric_malloc(bytes ? bytes : 1);
    tr->events = ric_calloc((size_t)h->n_event + 1, sizeof *tr->events);
    tr->gaps = ric_calloc((size_t)h->n_gap + 1, sizeof *tr->gaps);
    if (!tr->points || !tr->events || !tr->gaps) return false;
    tr->n_gap = h->n_gap;
    tr->n_point = tr->point_capacity = h->n_point;
    tr->n_event = h->n_event;
    tr->event_capacity = h->n_event + 1;
    return true;
}

ric_status ric_continuation_unpack(const ric_model *m, const ric_limits *limits, const void *blob,
                                   size_t size, ric_continuation **out)
{
    ric_bytes b = ric_bytes_of(blob, size);
    header h;
    uint64_t closed = 0;
    ric_continuation *tr = ric_calloc(1, sizeof *tr);
    *out = NULL;
    if (!tr) return ric_no_memory("a branch");
    tr->end.test = -1;
    tr->limits = limits;
    ric_bytes_pass(&b, &h, sizeof h);
    ric_status status = !b.lost && sane(&h, m) ? unpack_chain(&b, m, &h, &tr->chain) : RIC_E_FORMAT;
    if (status) goto out;
    pass_findings(&b, tr, &closed);
    ric_shooting_close(tr->chain, closed);
    if (!b.lost && h.parts > 1 && (status = ric_shooting_nodes_divide(tr->chain, h.parts)))
        goto out;
    status = RIC_E_FORMAT;
    if (b.lost || !ric_continuation_resonances(tr) || !make_room(&b, &h, tr)) goto out;
    pass_found(&b, tr);
    for (int i = 0; i < tr->n_gap; i++)
        b.lost |= tr->gaps[i].point < 0 || tr->gaps[i].point + 1 >= tr->n_point ||
                  tr->gaps[i].mode < 1 || tr->gaps[i].mode > m->n_dof;
    if (b.lost || !sane_found(tr)) goto out;
    tr->stop = (ric_stop)h.stop;
    tr->arrival = h.arrival;
    tr->why = (ric_why)h.why;
    *out = tr;
    return RIC_OK;
out:
    ric_continuation_free(tr);
    if (status == RIC_E_FORMAT && ric_memory_failed()) return ric_no_memory("a branch");
    return status == RIC_E_FORMAT
               ? ric_fail(status, "the atlas holds finished work that cannot be read: the file is "
                                  "damaged; move it away and run again")
               : status;
}
