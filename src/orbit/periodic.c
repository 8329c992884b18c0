#include "periodic.h"

#include <stdlib.h>
#include <string.h>

#include "base/room.h"

#define EXACT 1e-9 /* distance of images that are one orbit, and not of one beside an orbit with more symmetry */

static int modulo(int i, int N)
{
    i %= N;
    return i < 0 ? i + N : i;
}

ric_periodic *ric_periodic_create(int n, int N)
{
    ric_periodic *c = ric_calloc(1, sizeof *c);
    if (!c) return NULL;
    c->n = n;
    c->N = N;
    c->pure = c->flip = -1;
    c->face = ric_calloc((size_t)N + 1, sizeof *c->face);
    c->tau = ric_calloc((size_t)N + 1, sizeof *c->tau);
    c->w = ric_calloc(2 * (size_t)n, sizeof *c->w);
    if (c->face && c->tau && c->w) return c;
    ric_periodic_free(c);
    return NULL;
}

void ric_periodic_free(ric_periodic *c)
{
    if (!c) return;
    free(c->face);
    free(c->tau);
    free(c->w);
    free(c->opposite);
    free(c);
}

ric_periodic *ric_periodic_copy(const ric_periodic *c)
{
    ric_periodic *copy = ric_periodic_create(c->n, c->N);
    if (!copy) return NULL;
    memcpy(copy->face, c->face, (size_t)c->N * sizeof *c->face);
    memcpy(copy->tau, c->tau, (size_t)c->N * sizeof *c->tau);
    memcpy(copy->w, c->w, 2 * (size_t)c->n * sizeof *c->w);
    copy->closed = c->closed;
    copy->half = c->half;
    copy->pure = c->pure;
    copy->flip = c->flip;
    copy->parts = c->parts;
    if (!c->opposite || ric_periodic_oppose(copy, c->opposite)) return copy;
    ric_periodic_free(copy);
    return NULL;
}

/* ------------------------------------------------------------- from chain */

/* Appends one flight that ends on `face` (-1: in flight) to a cycle under construction; `open` is flight time not yet
 * closed. */
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

/* One way from the start to the end mirror and back; the way back shows the mirror image if the end is a centre. */
static void walk(ric_periodic *c, const ric_shooting *chain, const double *tau, bool mirror, double *open)
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

ric_periodic *ric_periodic_from_chain(const ric_shooting *chain, const double *u)
{
    const ric_model *m = chain->model;
    int n = chain->n, nf = chain->n_flight;
    if (m->smooth) return ric_periodic_from_smooth(chain, u);
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
    if (on_impact) c->N--; /* the walk has come back to the first impact; its flight is closed already */
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

/* Flight i of the cycle, with `closed` during it, and the event at its end: w from right after event i to right after
 * the next. */
static void advance(const ric_model *m, const ric_periodic *c, int i, uint64_t *closed, const double *w, double *after)
{
    int face = c->face[(i + 1) % c->N];
    ric_flight_go(m, *closed, c->face[i], c->tau[i], w, after);
    if (face < 0) return; /* a mark */
    ric_flight_strike(c->n, &m->face[face], after + c->n);
    *closed = ric_flight_toggle(m, *closed, face);
}

void ric_periodic_states(const ric_model *m, const ric_periodic *c, double *W)
{
    int n = c->n;
    uint64_t closed = c->closed;
    memcpy(W, c->w, 2 * (size_t)n * sizeof *W);
    for (int i = 1; i < c->N; i++) advance(m, c, i - 1, &closed, W + 2 * n * (i - 1), W + 2 * n * i);
}

uint64_t ric_periodic_springs(const ric_model *m)
{
    uint64_t springs = 0;
    for (int f = 0; f < m->n_face && f < RIC_FACES_MAX; f++)
        if (m->face[f].spring > 0) springs |= (uint64_t)1 << f;
    return springs;
}

int ric_periodic_impacts(uint64_t springs, const ric_periodic *c)
{
    int switches = 0;
    if (ric_periodic_letters(c) == 0) return 0;
    for (int i = 0; springs && i < c->N; i++) switches += springs >> c->face[i] & 1;
    return c->N - switches / 2;
}

uint64_t ric_periodic_closed(const ric_model *m, const ric_periodic *c, int i)
{
    uint64_t closed = c->closed;
    for (int k = 1; k <= i; k++) closed = ric_flight_toggle(m, closed, c->face[k]);
    return closed;
}

void ric_periodic_at_time(const ric_model *m, const ric_periodic *c, double t, double *w)
{
    int n = c->n, k = 0;
    uint64_t closed = c->closed;
    double period = ric_periodic_period(c);
    memcpy(w, c->w, 2 * (size_t)n * sizeof *w);
    t = fmod(t, period);
    if (t < 0) t += period;
    for (; k + 1 < c->N && t >= c->tau[k]; k++) {
        t -= c->tau[k];
        advance(m, c, k, &closed, w, w);
    }
    ric_flight_go(m, closed, c->face[k], t, w, w);
}

double ric_periodic_period(const ric_periodic *c)
{
    double sum = 0;
    for (int i = 0; i < c->N; i++) sum += c->tau[i];
    return sum;
}

double ric_periodic_energy(const ric_model *m, const ric_periodic *c)
{
    return ric_flight_energy(m, c->closed, c->w);
}

/* Where a chain of the general form may start: the condition there stands for itself, so not behind a flight between
 * two switches of one spring, if there is another event. */
int ric_periodic_start(const ric_model *m, const ric_periodic *c)
{
    if (!m->springs) return 0;
    uint64_t closed = c->closed;
    int closing = -1;
    for (int i = 0; i < c->N; i++) {
        const ric_face *face = &m->face[c->face[i]];
        if (i > 0) closed = ric_flight_toggle(m, closed, c->face[i]);
        if (face->spring == 0 || c->face[modulo(i - 1, c->N)] != c->face[i]) return i;
        if (closing < 0 && closed >> c->face[i] & 1) closing = i;
    }
    return closing < 0 ? 0 : closing;
}

static ric_status to_general(const ric_model *m, const ric_periodic *cycle, ric_shooting **chain, double **u);

static ric_status from_event(const ric_model *m, const ric_periodic *c, int first, ric_shooting **chain, double **u)
{
    ric_periodic *turned = ric_periodic_transform(m, c, first, false, false);
    if (!turned) return ric_fail(RIC_E_NOMEM, "no memory for an orbit of %d impacts", c->N);
    ric_status status = to_general(m, turned, chain, u);
    ric_periodic_free(turned);
    return status;
}

static ric_status to_general(const ric_model *m, const ric_periodic *c, ric_shooting **chain, double **u)
{
    int first = ric_periodic_start(m, c);
    if (first > 0) return from_event(m, c, first, chain, u);
    int n = c->n, nf = c->half ? c->N / 2 : c->N, face[nf + 1];
    for (int i = 0; i < nf; i++) face[i] = c->face[i];
    face[nf] = c->half ? m->face[c->face[0]].mirror : c->face[0];
    ric_status status = ric_shooting_create(m, RIC_MIRROR_NONE, RIC_MIRROR_NONE, c->half ? -1 : 1, nf, face, chain);
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

/* Chain from half position x0 to x1. */
static ric_status between(const ric_model *m, const ric_periodic *c, int x0, int x1, ric_mirror in_flight0,
                          ric_mirror in_flight1, ric_shooting **chain, double **out)
{
    ric_status status = RIC_OK;
    int n = c->n, N = c->N, nf = 0;
    bool hit0 = x0 % 2 == 0, hit1 = x1 % 2 == 0;
    int *face = ric_calloc((size_t)(x1 - x0) + 3, sizeof *face);
    double *tau = ric_calloc((size_t)(x1 - x0) + 3, sizeof *tau), *W = ric_calloc((size_t)N * 2 * n, sizeof *W),
           *u = NULL;
    double w[2 * n];
    *chain = NULL;
    *out = NULL;
    if (!face || !tau || !W) {
        status = ric_fail(RIC_E_NOMEM, "no memory for an orbit of %d impacts", N);
        goto out;
    }
    ric_periodic_states(m, c, W);
    int first = x0 / 2; /* impact at or before the start */
    face[0] = hit0 ? c->face[modulo(first, N)] : -1;
    for (int x = x0; x < x1;) {
        int i = x >= 0 ? x / 2 : 0, end = 2 * i + 2;
        double t = c->tau[modulo(i, N)];
        if (x % 2) t /= 2;
        if (end > x1) {
            t /= 2;
            end = x1;
        }
        tau[nf++] = t;
        face[nf] = end % 2 ? -1 : c->face[modulo(end / 2, N)];
        x = end;
    }
    ric_mirror start = hit0 ? RIC_MIRROR_IMPACT : in_flight0, end = hit1 ? RIC_MIRROR_IMPACT : in_flight1;
    if ((status = ric_shooting_create(m, start, end, 1, nf, face, chain))) goto out;
    ric_shooting_close(*chain, ric_periodic_closed(m, c, modulo(first, N)));
    if (!(u = ric_calloc((size_t)(*chain)->n_unknown, sizeof *u))) {
        status = ric_fail(RIC_E_NOMEM, "no memory for an orbit of %d impacts", N);
        goto out;
    }
    memcpy(w, W + 2 * n * modulo(first, N), sizeof w);
    if (!hit0) ric_flight_go(m, (*chain)->closed[0], c->face[modulo(first, N)], c->tau[modulo(first, N)] / 2, w, w);
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
    free(W);
    return status;
}

ric_status ric_periodic_to_chain(const ric_model *m, const ric_periodic *c, ric_shooting **chain, double **u)
{
    int N = c->N;
    if (m->smooth) return ric_periodic_to_smooth(m, c, chain, u);
    if (c->half && c->pure >= 0) {
        int x0 = modulo(c->pure + N / 2, N); /* a centre lies N / 2 half positions from every rest or impact mirror */
        return between(m, c, x0, x0 + N / 2, RIC_MIRROR_CENTRE, RIC_MIRROR_REST, chain, u);
    }
    if (c->pure >= 0) return between(m, c, c->pure, c->pure + N, RIC_MIRROR_REST, RIC_MIRROR_REST, chain, u);
    if (c->flip >= 0) return between(m, c, c->flip, c->flip + N, RIC_MIRROR_CENTRE, RIC_MIRROR_CENTRE, chain, u);
    return to_general(m, c, chain, u);
}

/* ------------------------------------------------------------- operations */

static bool rotate(const ric_model *m, const ric_periodic *c, int shift, ric_periodic *out)
{
    int n = c->n, N = c->N;
    bool over = c->opposite && 2 * shift == N, known = c->opposite && (over || shift == 0);
    memcpy(out->w, over ? c->opposite : c->w, 2 * (size_t)n * sizeof *c->w);
    if (known && !ric_periodic_oppose(out, over ? c->w : c->opposite)) return false;
    out->closed = c->closed;
    for (int i = 0; i < shift && !over; i++) advance(m, c, i, &out->closed, out->w, out->w);
    for (int i = 0; i < N; i++) {
        out->face[i] = c->face[(i + shift) % N];
        out->tau[i] = c->tau[(i + shift) % N];
    }
    out->pure = c->pure < 0 ? -1 : modulo(c->pure - 2 * shift, N);
    out->flip = c->flip < 0 ? -1 : modulo(c->flip - 2 * shift, N);
    out->half = c->half;
    out->parts = c->parts;
    return true;
}

static void reverse_time(const ric_model *m, ric_periodic *c)
{
    int n = c->n, N = c->N;
    if (c->face[0] >= 0) ric_flight_strike(n, &m->face[c->face[0]], c->w + n);
    c->closed = ric_flight_toggle(m, c->closed, c->face[0]);
    for (int i = 0; i < n; i++) c->w[n + i] = -c->w[n + i];
    for (int i = 0; i < n && c->opposite; i++) c->opposite[n + i] = -c->opposite[n + i];
    for (int i = 1, j = N - 1; i < j; i++, j--) {
        int face = c->face[i];
        c->face[i] = c->face[j];
        c->face[j] = face;
    }
    for (int i = 0, j = N - 1; i < j; i++, j--) {
        double tau = c->tau[i];
        c->tau[i] = c->tau[j];
        c->tau[j] = tau;
    }
    if (c->pure >= 0) c->pure = modulo(-c->pure, N);
    if (c->flip >= 0) c->flip = modulo(-c->flip, N);
}

ric_periodic *ric_periodic_transform(const ric_model *m, const ric_periodic *c, int shift, bool reverse, bool mirror)
{
    if (mirror && !ric_periodic_mirrors(m, c)) return NULL;
    ric_periodic *out = ric_periodic_create(c->n, c->N);
    if (!out || !rotate(m, c, modulo(shift, c->N), out)) {
        ric_periodic_free(out);
        return NULL;
    }
    if (reverse) reverse_time(m, out);
    if (mirror) {
        for (int i = 0; i < c->N; i++) out->face[i] = mirrored(m, out->face[i], true);
        for (int i = 0; i < 2 * c->n; i++) out->w[i] = -out->w[i];
        for (int i = 0; i < 2 * c->n && out->opposite; i++) out->opposite[i] = -out->opposite[i];
        out->closed = ric_flight_mirror(m, out->closed);
    }
    return out;
}

bool ric_periodic_mirrors(const ric_model *m, const ric_periodic *c)
{
    for (int i = 0; i < c->N; i++)
        if (c->face[i] >= 0 && m->face[c->face[i]].mirror < 0) return false;
    for (int f = 0; c->closed >> f && f < m->n_face; f++) /* also what never opens */
        if (c->closed >> f & 1 && m->face[f].mirror < 0) return false;
    return true;
}

int ric_periodic_operations(const ric_model *m)
{
    return m->symmetric ? 4 : 2;
}

/* Index of impact i among the kept ones. */
static int rank_of(const bool *keep, int i)
{
    int rank = 0;
    for (int j = 0; j < i; j++) rank += keep[j];
    return rank;
}

static int kept_reversal(const bool *keep, int N, int r, int kept)
{
    if (r < 0) return -1;
    for (int i = 0; i < N; i++)
        if (keep[i] != keep[modulo(r - i, N)]) return -1;
    for (int i = 0; i < N; i++)
        if (keep[i]) return modulo(rank_of(keep, i) + rank_of(keep, modulo(r - i, N)), kept);
    return -1;
}

ric_periodic *ric_periodic_keep(const ric_model *m, const ric_periodic *c, const bool *keep)
{
    int n = c->n, N = c->N, kept = 0, first = 0;
    for (int i = 0; i < N; i++) kept += keep[i];
    while (first < N && !keep[first]) first++;
    ric_periodic *out = ric_periodic_create(n, kept);
    double *W = ric_calloc((size_t)N * 2 * n, sizeof *W);
    if (!out || !W) {
        ric_periodic_free(out);
        free(W);
        return NULL;
    }
    ric_periodic_states(m, c, W);
    memcpy(out->w, W + 2 * n * first, 2 * (size_t)n * sizeof *W);
    out->closed = ric_periodic_closed(m, c, first);
    for (int i = first, j = -1; i < first + N; i++) {
        if (keep[i % N]) out->face[++j] = c->face[i % N];
        out->tau[j] += c->tau[i % N];
    }
    out->half = c->half && kept % 2 == 0;
    for (int i = 0; out->half && i < N; i++) out->half = keep[i] == keep[(i + N / 2) % N];
    out->pure = kept_reversal(keep, N, c->pure, kept);
    out->flip = kept_reversal(keep, N, c->flip, kept);
    free(W);
    return out;
}

ric_periodic *ric_periodic_shorten(const ric_periodic *c, int q)
{
    int N = c->N / q;
    ric_periodic *out = ric_periodic_copy(c);
    if (!out) return NULL;
    out->N = N;
    for (int i = 0; i < N; i++) {
        out->tau[i] = 0;
        for (int k = 0; k < q; k++) out->tau[i] += c->tau[i + k * N] / q;
    }
    if (out->pure >= 0) out->pure = modulo(out->pure, N);
    if (out->flip >= 0) out->flip = modulo(out->flip, N);
    out->half = false;
    ric_periodic_oppose(out, NULL);
    out->parts = (c->parts + q - 1) / q;
    return out;
}

int ric_periodic_letters(const ric_periodic *c)
{
    return c->N && c->face[0] < 0 ? 0 : c->N;
}

ric_periodic *ric_periodic_repeat(const ric_periodic *c, int q)
{
    ric_periodic *out = ric_periodic_create(c->n, c->N * q);
    if (!out) return NULL;
    memcpy(out->w, c->w, 2 * (size_t)c->n * sizeof *c->w);
    out->closed = c->closed;
    out->parts = c->parts * q;
    for (int i = 0; i < out->N; i++) {
        out->face[i] = c->face[i % c->N];
        out->tau[i] = c->tau[i % c->N];
    }
    return out;
}

/* ------------------------------------------------------------- comparison */

static double size_of(const ric_periodic *c)
{
    return 1 + sqrt(ric_dot(2 * c->n, c->w, c->w));
}

double ric_periodic_distance(const ric_periodic *a, const ric_periodic *b)
{
    double sum = 0, size = size_of(a);
    if (a->N != b->N || a->closed != b->closed || memcmp(a->face, b->face, (size_t)a->N * sizeof *a->face))
        return HUGE_VAL;
    for (int i = 0; i < 2 * a->n; i++) sum = fmax(sum, fabs(a->w[i] - b->w[i]) / size);
    for (int i = 0; i < a->N; i++) sum = fmax(sum, fabs(a->tau[i] - b->tau[i]));
    return sum;
}

static bool same_word(const ric_model *m, const ric_periodic *a, const ric_periodic *b, int shift, bool reverse,
                      bool mirror)
{
    int N = a->N;
    for (int i = 0; i < N; i++) {
        int f = b->face[modulo(shift + (reverse ? -i : i), N)];
        if (f >= 0 && mirror && (f = m->face[f].mirror) < 0) return false;
        if (f != a->face[i]) return false;
    }
    return true;
}

/* Distance of the image of b under an operation from a; infinity when the words differ. */
static double image_distance(const ric_model *m, const ric_periodic *a, const ric_periodic *b, int shift, bool reverse,
                             bool mirror)
{
    if (!same_word(m, a, b, shift, reverse, mirror)) return HUGE_VAL;
    /* flight times first: they cost nothing */
    for (int i = 0; i < a->N; i++) {
        int j = reverse ? modulo(shift - i - 1, a->N) : modulo(shift + i, a->N);
        if (fabs(a->tau[i] - b->tau[j]) > 1e-2) return HUGE_VAL;
    }
    ric_periodic *image = ric_periodic_transform(m, b, shift, reverse, mirror);
    double distance = image ? ric_periodic_distance(a, image) : HUGE_VAL;
    ric_periodic_free(image);
    return distance;
}

bool ric_periodic_alike(const ric_model *m, const ric_periodic *a, const ric_periodic *b)
{
    bool found = false;
    for (int op = 0; a->N == b->N && op < ric_periodic_operations(m); op++)
        for (int s = 0; s < a->N && !found; s++) found = same_word(m, a, b, s, op & 1, op & 2);
    return found;
}

bool ric_periodic_match(const ric_model *m, const ric_periodic *a, const ric_periodic *b, double tolerance, int *shift,
                        bool *reverse, bool *mirror)
{
    double nearest = HUGE_VAL;
    if (a->N != b->N) return false;
    for (int op = 0; op < ric_periodic_operations(m); op++)
        for (int s = 0; s < a->N; s++) {
            double distance = image_distance(m, a, b, s, op & 1, op & 2);
            if (distance > tolerance || distance >= nearest) continue;
            nearest = distance;
            *shift = s;
            *reverse = op & 1;
            *mirror = op & 2;
            if (distance <= EXACT)
                return true; /* the images of an orbit with symmetries differ by rounding: the first
                              * one */
        }
    return nearest < HUGE_VAL;
}

bool ric_periodic_same(const ric_model *m, const ric_periodic *a, const ric_periodic *b, double tolerance)
{
    int shift;
    bool reverse, mirror;
    if (ric_periodic_match(m, a, b, tolerance, &shift, &reverse, &mirror)) return true;
    if (!m->smooth || a->N != b->N || a->pure >= 0 || a->flip >= 0) return false;
    ric_periodic *image = ric_periodic_nearest_phase(m, a, b, tolerance);
    bool found = image;
    ric_periodic_free(image);
    return found;
}

bool ric_periodic_repeats(const ric_model *m, const ric_periodic *c, double tolerance)
{
    if (m->smooth) return ric_periodic_copies(m, c, tolerance) > 1;
    for (int s = 1; s < c->N; s++)
        if (c->N % s == 0 && image_distance(m, c, c, s, false, false) <= tolerance) return true;
    return false;
}

ric_periodic *ric_periodic_nearest(const ric_model *m, const ric_periodic *orbit, const ric_periodic *near,
                                   double limit)
{
    ric_periodic *best = NULL;
    double least = limit;
    if (m->smooth && orbit->pure < 0 && orbit->flip < 0) return ric_periodic_nearest_phase(m, orbit, near, limit);
    for (int op = 0; op < ric_periodic_operations(m); op++)
        for (int k = 0; k < near->N; k++) {
            ric_periodic *image = ric_periodic_transform(m, near, k, op & 1, op & 2);
            double distance = image ? ric_periodic_distance(orbit, image) : HUGE_VAL;
            if (distance < least) {
                ric_periodic *last = best;
                best = image;
                image = last;
                least = distance;
            }
            ric_periodic_free(image);
        }
    return best;
}

int ric_periodic_find_symmetries(const ric_model *m, ric_periodic *c, double tolerance)
{
    int N = c->N, q = 1;
    c->half = false;
    c->pure = c->flip = -1;
    if (m->smooth) {
        q = ric_periodic_copies(m, c, tolerance);
        if (!ric_periodic_mark(c, N = 2 * q)) return 1;
    }
    for (int s = 1; s < N; s++)
        if (N % s == 0 && image_distance(m, c, c, s, false, false) <= tolerance) {
            q = N / s;
            break;
        }
    int period = N / q;
    if (period % 2 == 0) c->half = image_distance(m, c, c, period / 2, false, true) <= tolerance;
    for (int s = 0; s < period; s++) {
        /* the image under (shift s, reverse) has impact i = old impact s - i */
        if (c->pure < 0 && image_distance(m, c, c, s, true, false) <= tolerance) c->pure = s;
        if (c->flip < 0 && image_distance(m, c, c, s, true, true) <= tolerance) c->flip = s;
    }
    /* the other reversal a quarter on */
    if (m->smooth && c->pure < 0 && c->flip < 0 && ric_periodic_find_mirrors(m, c, q, tolerance) && c->half)
        *(c->pure < 0 ? &c->pure : &c->flip) = 1;
    /* smooth orbits with all symmetries start at a centre */
    if (m->smooth && c->half && c->pure == 0) ric_periodic_half_mark(m, c);
    return q;
}

void ric_periodic_word(const ric_model *m, const ric_periodic *c, int *word)
{
    uint64_t closed = c->closed;
    for (int i = 0; i < ric_periodic_letters(c); i++) {
        if (i > 0) closed = ric_flight_toggle(m, closed, c->face[i]);
        word[i] = m->face[c->face[i]].spring > 0 && !(closed >> c->face[i] & 1) ? m->n_face + c->face[i] : c->face[i];
    }
}

void ric_periodic_spell(const ric_model *m, ric_periodic *c, const int *word)
{
    uint64_t met = 0;
    c->closed = 0;
    for (int i = 0; i < c->N; i++) {
        bool opens = word[i] >= m->n_face;
        int f = c->face[i] = opens ? word[i] - m->n_face : word[i];
        /* what it is after event 0: what that made of it, or the other of what comes first */
        if (m->face[f].spring > 0 && !(met >> f & 1) && opens == (i > 0)) c->closed |= (uint64_t)1 << f;
        if (m->face[f].spring > 0) met |= (uint64_t)1 << f;
    }
}

static uint64_t bit_of(int face)
{
    return face < 0 ? 0 : (uint64_t)1 << (face % RIC_FACES_MAX);
}

int ric_periodic_compare(uint64_t springs, const ric_periodic *a, const ric_periodic *b)
{
    uint64_t x = a->closed, y = b->closed;
    double size = size_of(a);
    for (int i = 0; i < a->N; i++) {
        uint64_t f = bit_of(a->face[i]) & springs, g = bit_of(b->face[i]) & springs;
        if (i > 0) x ^= f;
        if (i > 0) y ^= g;
        bool opens = f && !(x & f), other = g && !(y & g);
        if (opens != other) return opens ? 1 : -1; /* closings first: the smallest word starts with one */
        if (a->face[i] != b->face[i]) return a->face[i] < b->face[i] ? -1 : 1;
    }
    if (a->closed != b->closed) return a->closed < b->closed ? -1 : 1;
    for (int i = 0; i < 2 * a->n; i++)
        if (fabs(a->w[i] - b->w[i]) > 1e-7 * size) return a->w[i] < b->w[i] ? -1 : 1;
    for (int i = 0; i < a->N; i++)
        if (fabs(a->tau[i] - b->tau[i]) > 1e-7) return a->tau[i] < b->tau[i] ? -1 : 1;
    return 0;
}

ric_periodic *ric_periodic_canonical(const ric_model *m, const ric_periodic *c)
{
    ric_periodic *best = ric_periodic_copy(c);
    for (int op = 0; best && op < ric_periodic_operations(m); op++)
        for (int s = 0; s < c->N; s++) {
            ric_periodic *image = ric_periodic_transform(m, c, s, op & 1, op & 2);
            if (image && ric_periodic_compare(ric_periodic_springs(m), image, best) < 0) {
                ric_periodic *swap = best;
                best = image;
                image = swap;
            }
            ric_periodic_free(image);
        }
    return best;
}
