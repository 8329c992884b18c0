/* Orbits with events: impacts, and springs that close and open. */
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "periodic_form.h"

static int modulo(int i, int N)
{
    i %= N;
    return i < 0 ? i + N : i;
}

/* ------------------------------------------------------------- from chain */

/* Appends one flight that ends on `face` (-1: in flight) to a cycle under construction; `open` is
 * flight time not yet closed. */
static void append(ric_periodic *c, double *open, double tau, int face)
{
    *open += tau;
    if (face < 0) return;
    if (c->N > 0) c->tau[c->N - 1] = *open;
    else c->tau[0] = 0; /* the time before the first impact comes round at the end */
    if (c->N == 0) c->w[0] = *open;
    c->face[c->N++] = face;
    *open = 0;
}

static int mirrored(const ric_model *m, int face, bool mirror)
{
    return face < 0 || !mirror ? face : m->face[face].mirror;
}

/* One way from the start to the end mirror and back; the way back shows the mirror image if the end
 * is a centre. */
static void walk(ric_periodic *c, const ric_shooting *chain, const double *tau, bool mirror,
                 double *open)
{
    const ric_model *m = chain->model;
    int last = chain->n_flight;
    bool back = mirror != (chain->end == RIC_MIRROR_CENTRE);
    for (int k = 0; k < last; k++) append(c, open, tau[k], mirrored(m, chain->face[k + 1], mirror));
    for (int k = last - 1; k >= 0; k--) append(c, open, tau[k], mirrored(m, chain->face[k], back));
}

static ric_periodic *from_general(const ric_shooting *chain, const double *u)
{
    int n = chain->n, N = chain->n_flight, copies = chain->sigma < 0 ? 2 : 1;
    ric_periodic *c = ric_periodic_create(n, copies * N);
    if (!c) return NULL;
    for (int i = 0; i < copies * N; i++) {
        c->face[i] = mirrored(chain->model, chain->face[i % N], i >= N);
        c->tau[i] = u[chain->n_start + i % N];
    }
    memcpy(c->w, chain->w, 2 * (size_t)n * sizeof *c->w);
    c->closed = chain->closed[0];
    c->half = chain->sigma < 0;
    return c;
}

static ric_periodic *from_chain(const ric_shooting *chain, const double *u)
{
    const ric_model *m = chain->model;
    int n = chain->n, nf = chain->n_flight;
    if (chain->start == RIC_MIRROR_NONE) return from_general(chain, u);
    ric_periodic *c = ric_periodic_create(n, 4 * nf + 2);
    double open = 0, before_first = 0;
    const double *tau = u + chain->n_start;
    bool quarter = chain->multiple == 4, on_impact = chain->start == RIC_MIRROR_IMPACT;
    if (!c) return NULL;
    c->N = 0;
    if (on_impact) append(c, &open, 0, chain->face[0]);
    walk(c, chain, tau, false, &open);
    if (quarter) walk(c, chain, tau, true, &open);
    before_first = c->w[0];
    if (on_impact)
        c->N--; /* the walk has come back to the first impact; its flight is closed already */
    else c->tau[c->N - 1] = open + before_first;
    const double *first = chain->w + (on_impact ? 0 : 2 * n);
    memcpy(c->w, first, 2 * (size_t)n * sizeof *c->w);
    c->closed = chain->closed[!on_impact];
    /* the end mirror is the first impact */
    if (!on_impact && nf == 1) ric_flight_strike(n, &m->face[c->face[0]], c->w + n);
    int N = c->N, passed = nf - 1 + on_impact;
    int a = on_impact ? 0 : -1, b = chain->end == RIC_MIRROR_IMPACT ? 2 * passed : 2 * passed - 1;
    c->half = quarter;
    if (chain->start == RIC_MIRROR_CENTRE) c->flip = modulo(a, N);
    else c->pure = modulo(a, N);
    if (chain->end == RIC_MIRROR_CENTRE) c->flip = modulo(b, N);
    else c->pure = modulo(b, N);
    return c;
}

/* --------------------------------------------------------------- to chain */

/* Where a chain of the general form may start: the condition there stands for itself, so not behind
 * a flight between two switches of one spring, if there is another event. */
int ric_periodic_start(const ric_model *m, const ric_periodic *c)
{
    uint64_t closed = c->closed;
    int closing = -1;
    for (int i = 0; i < c->N; i++) {
        const ric_face *face = &m->face[c->face[i]];
        if (i > 0) closed = ric_flight_toggle(m, closed, c->face[i]);
        if (face->spring == 0 || c->face[modulo(i - 1, c->N)] != c->face[i]) return i;
        if (closing < 0 && ric_face_in(closed, c->face[i])) closing = i;
    }
    return closing < 0 ? 0 : closing;
}

static ric_status to_general(const ric_model *m, const ric_periodic *cycle, ric_shooting **chain,
                             double **u);

static ric_status from_event(const ric_model *m, const ric_periodic *c, int first,
                             ric_shooting **chain, double **u)
{
    ric_periodic *turned = ric_periodic_transform(m, c, first, false, false);
    if (!turned) return ric_fail(RIC_E_NOMEM, "no memory for an orbit of %d impacts", c->N);
    ric_status status = to_general(m, turned, chain, u);
    ric_periodic_free(turned);
    return status;
}

static ric_status to_general(const ric_model *m, const ric_periodic *c, ric_shooting **chain,
                             double **u)
{
    int first = ric_periodic_start(m, c);
    if (first > 0) return from_event(m, c, first, chain, u);
    int n = c->n, nf = c->half ? c->N / 2 : c->N, face[nf + 1];
    for (int i = 0; i < nf; i++) face[i] = c->face[i];
    face[nf] = c->half ? m->face[c->face[0]].mirror : c->face[0];
    ric_status status = ric_shooting_create(m, RIC_MIRROR_NONE, RIC_MIRROR_NONE, c->half ? -1 : 1,
                                            nf, face, chain);
    if (status) return status;
    ric_shooting_close(*chain, c->closed);
    if (!(*u = ric_calloc((size_t)(*chain)->n_unknown, sizeof **u))) {
        ric_shooting_free(*chain);
        *chain = NULL;
        return ric_fail(RIC_E_NOMEM, "no memory for an orbit of %d impacts", c->N);
    }
    memcpy(*u, c->w, 2 * (size_t)n * sizeof **u);
    memcpy(*u + 2 * n, c->tau, (size_t)nf * sizeof **u);
    return RIC_OK;
}

/* Times of the flights from x0 to x1, and the faces that they end on from face[1] on; their number.
 */
static int flights_between(const ric_periodic *c, int x0, int x1, int *face, double *tau)
{
    int nf = 0;
    for (int x = x0; x < x1;) {
        int i = x >= 0 ? x / 2 : 0, end = 2 * i + 2;
        double t = c->tau[modulo(i, c->N)];
        if (x % 2) t /= 2;
        if (end > x1) {
            t /= 2;
            end = x1;
        }
        tau[nf++] = t;
        face[nf] = end % 2 ? -1 : c->face[modulo(end / 2, c->N)];
        x = end;
    }
    return nf;
}

/* Chain from half position x0 to x1. */
static ric_status between(const ric_model *m, const ric_periodic *c, int x0, int x1,
                          ric_mirror in_flight0, ric_mirror in_flight1, ric_shooting **chain,
                          double **out)
{
    ric_status status = RIC_OK;
    int n = c->n, N = c->N;
    bool hit0 = x0 % 2 == 0, hit1 = x1 % 2 == 0;
    int *face = ric_calloc((size_t)(x1 - x0) + 3, sizeof *face);
    double *tau = ric_calloc((size_t)(x1 - x0) + 3, sizeof *tau), *u = NULL, w[2 * n];
    *chain = NULL;
    *out = NULL;
    if (!face || !tau) {
        status = ric_fail(RIC_E_NOMEM, "no memory for an orbit of %d impacts", N);
        goto out;
    }
    int first = x0 / 2; /* impact at or before the start */
    face[0] = hit0 ? c->face[modulo(first, N)] : -1;
    int nf = flights_between(c, x0, x1, face, tau);
    ric_mirror start = hit0 ? RIC_MIRROR_IMPACT : in_flight0,
               end = hit1 ? RIC_MIRROR_IMPACT : in_flight1;
    if ((status = ric_shooting_create(m, start, end, 1, nf, face, chain))) goto out;
    ric_shooting_close(*chain, ric_periodic_closed(m, c, modulo(first, N)));
    if (!(u = ric_calloc((size_t)(*chain)->n_unknown, sizeof *u))) {
        status = ric_fail(RIC_E_NOMEM, "no memory for an orbit of %d impacts", N);
        goto out;
    }
    ric_periodic_state(m, c, modulo(first, N), w);
    if (!hit0)
        ric_flight_go(m, (*chain)->closed[0], c->face[modulo(first, N)],
                      c->tau[modulo(first, N)] / 2, w, w);
    if (start == RIC_MIRROR_CENTRE) memcpy(u, w + n, (size_t)n * sizeof *u);
    else memcpy(u, w, (size_t)n * sizeof *u);
    if (start == RIC_MIRROR_IMPACT) {
        const ric_face *f = &m->face[face[0]];
        u[n] = -f->side * ric_dot(n, f->c, w + n) / sqrt(f->cc);
    }
    memcpy(u + (*chain)->n_start, tau, (size_t)nf * sizeof *u);
    *out = u;
    u = NULL;
out:
    if (status) {
        ric_shooting_free(*chain);
        *chain = NULL;
    }
    free(u);
    free(face);
    free(tau);
    return status;
}

static ric_status to_chain(const ric_model *m, const ric_periodic *c, ric_shooting **chain,
                           double **u)
{
    int N = c->N;
    if (c->half && c->pure >= 0) {
        int x0 =
            modulo(c->pure + N / 2,
                   N); /* a centre lies N / 2 half positions from every rest or impact mirror */
        return between(m, c, x0, x0 + N / 2, RIC_MIRROR_CENTRE, RIC_MIRROR_REST, chain, u);
    }
    if (c->pure >= 0)
        return between(m, c, c->pure, c->pure + N, RIC_MIRROR_REST, RIC_MIRROR_REST, chain, u);
    if (c->flip >= 0)
        return between(m, c, c->flip, c->flip + N, RIC_MIRROR_CENTRE, RIC_MIRROR_CENTRE, chain, u);
    return to_general(m, c, chain, u);
}

/* ------------------------------------------------------------- comparison */

static bool same(const ric_model *m, const ric_periodic *a, const ric_periodic *b, double tolerance)
{
    ric_turn turn;
    return ric_periodic_match(m, a, b, tolerance, &turn);
}

static bool repeats(const ric_model *m, const ric_periodic *c, double tolerance)
{
    return ric_periodic_shifts(m, c, tolerance) < c->N;
}

static int find_symmetries(const ric_model *m, ric_periodic *c, double tolerance)
{
    return ric_periodic_try_symmetries(m, c, 1, tolerance, NULL);
}

static ric_periodic *spell(const ric_model *m, int letters, const int *word, const double *tau)
{
    ric_periodic *c = ric_periodic_create(m->n, letters);
    if (!c) return NULL;
    ric_periodic_spell(m, c, word);
    memcpy(c->tau, tau, (size_t)letters * sizeof *tau);
    return c;
}

/* Impacts tell where the mirror points are. */
static void claim(const ric_model *m, const ric_periodic_claim *said, ric_periodic *c)
{
    ric_periodic_try_symmetries(m, c, 1, RIC_SAME_LOCATED, said);
    if (!said->symmetric) c->half = false;
    if (!said->reversible || !(said->rest || said->impact)) c->pure = -1;
    if (!said->reversible || !said->centre) c->flip = -1;
}

static void flights(const ric_periodic *c, double *tau)
{
    memcpy(tau, c->tau, (size_t)c->N * sizeof *tau);
}

static bool divide(ric_periodic *c, int marks)
{
    (void)c, (void)marks;
    return true;
}

static bool half_mark(const ric_model *m, ric_periodic *c)
{
    (void)m, (void)c;
    return false;
}

static void align(const ric_model *m, const ric_periodic *orbit, ric_periodic *near)
{
    (void)m, (void)orbit, (void)near;
}

const ric_periodic_form ric_periodic_events = {
    .events = true,
    .from_chain = from_chain,
    .to_chain = to_chain,
    .spell = spell,
    .claim = claim,
    .same = same,
    .repeats = repeats,
    .nearest = ric_periodic_nearest_event,
    .find_symmetries = find_symmetries,
    .flights = flights,
    .divide = divide,
    .half_mark = half_mark,
    .align = align,
};
