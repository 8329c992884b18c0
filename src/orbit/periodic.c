#include "periodic_form.h"

#include <stdlib.h>
#include <string.h>

#include "base/room.h"

/* APART: scaled time: flights that differ by more are told apart before any state is computed */
#define APART 1e-2

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
    c->pure = c->flip = -1;
    if (ric_periodic_room(c, N)) return c;
    ric_periodic_free(c);
    return NULL;
}

bool ric_periodic_room(ric_periodic *c, int N)
{
    const size_t times = (size_t)N + 1, states = 2 * (size_t)c->n;
    double *room = ric_calloc(1, (times + states) * sizeof *room + times * sizeof *c->face);
    if (!room) return false;
    if (c->tau) memcpy(room + times, c->w, states * sizeof *room);
    free(c->tau);
    c->N = N;
    c->tau = room;
    c->w = room + times;
    c->face = (int *)(void *)(c->w + states);
    return true;
}

void ric_periodic_free(ric_periodic *c)
{
    if (!c) return;
    free(c->tau); /* and what lies behind it */
    free(c->opposite);
    free(c);
}

void ric_periodic_take_symmetries(ric_periodic *c, const ric_periodic *from)
{
    c->half = from->half;
    c->pure = from->pure;
    c->flip = from->flip;
}

ric_periodic *ric_periodic_copy(const ric_periodic *c)
{
    ric_periodic *copy = ric_periodic_create(c->n, c->N);
    if (!copy) return NULL;
    memcpy(copy->face, c->face, (size_t)c->N * sizeof *c->face);
    memcpy(copy->tau, c->tau, (size_t)c->N * sizeof *c->tau);
    memcpy(copy->w, c->w, 2 * (size_t)c->n * sizeof *c->w);
    copy->closed = c->closed;
    ric_periodic_take_symmetries(copy, c);
    copy->parts = c->parts;
    if (!c->opposite || ric_periodic_oppose(copy, c->opposite)) return copy;
    ric_periodic_free(copy);
    return NULL;
}

/* ----------------------------------------------------------------- motion */

/* Flight i of the cycle, with `closed` during it, and the event at its end: w from right after
 * event i to right after the next. */
static void advance(const ric_model *m, const ric_periodic *c, int i, uint64_t *closed,
                    const double *w, double *after)
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
    for (int i = 1; i < c->N; i++)
        advance(m, c, i - 1, &closed, W + 2 * n * (i - 1), W + 2 * n * i);
}

void ric_periodic_state(const ric_model *m, const ric_periodic *c, int i, double *w)
{
    uint64_t closed = c->closed;
    memcpy(w, c->w, 2 * (size_t)c->n * sizeof *w);
    for (int k = 0; k < i; k++) advance(m, c, k, &closed, w, w);
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
    for (int i = 0; springs && i < c->N; i++) switches += (int)ric_face_in(springs, c->face[i]);
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

/* ------------------------------------------------------------- operations */

static int mirrored(const ric_model *m, int face, bool mirror)
{
    return face < 0 || !mirror ? face : m->face[face].mirror;
}

static bool rotate(const ric_model *m, const ric_periodic *c, int shift, ric_periodic *out)
{
    int n = c->n, N = c->N;
    bool over = c->opposite && 2 * shift == N, known = c->opposite && (over || shift == 0);
    memcpy(out->w, over ? c->opposite : c->w, 2 * (size_t)n * sizeof *c->w);
    if (known && !ric_periodic_oppose(out, over ? c->w : c->opposite)) return false;
    out->closed = c->closed;
    for (int i = 0; i < shift && !over; i++) advance(m, c, i, &out->closed, out->w, out->w);
    for (int i = 0, from = shift; i < N; i++, from = from + 1 < N ? from + 1 : 0) {
        out->face[i] = c->face[from];
        out->tau[i] = c->tau[from];
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

ric_periodic *ric_periodic_transform(const ric_model *m, const ric_periodic *c, int shift,
                                     bool reverse, bool mirror)
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
        if (ric_face_in(c->closed, f) && m->face[f].mirror < 0) return false;
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
    double *W = ric_calloc((size_t)N * 2 * (size_t)n, sizeof *W);
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
    for (int i = 0; i < out->N; i += c->N) {
        memcpy(out->face + i, c->face, (size_t)c->N * sizeof *c->face);
        memcpy(out->tau + i, c->tau, (size_t)c->N * sizeof *c->tau);
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
    if (a->N != b->N || a->closed != b->closed ||
        memcmp(a->face, b->face, (size_t)a->N * sizeof *a->face))
        return HUGE_VAL;
    for (int i = 0; i < 2 * a->n; i++) sum = fmax(sum, fabs(a->w[i] - b->w[i]) / size);
    for (int i = 0; i < a->N; i++) sum = fmax(sum, fabs(a->tau[i] - b->tau[i]));
    return sum;
}

/* The next event round the circle, or the one before. */
static int following(int N, int i, bool reverse)
{
    return reverse ? (i > 0 ? i : N) - 1 : i + 1 < N ? i + 1 : 0;
}

static bool same_word(const ric_model *m, const ric_periodic *a, const ric_periodic *b, int shift,
                      bool reverse, bool mirror)
{
    for (int i = 0, j = shift; i < a->N; i++, j = following(b->N, j, reverse)) {
        int f = b->face[j];
        if (f >= 0 && mirror && (f = m->face[f].mirror) < 0) return false;
        if (f != a->face[i]) return false;
    }
    return true;
}

/* Images of one orbit under the group: its states after every event [N * 2n] are flown once, when
 * the first of them is asked for. */
typedef struct {
    const ric_model *m;
    const ric_periodic *c;
    double *W;
} images;

static bool fly_states(images *q)
{
    if (!q->W && (q->W = ric_malloc((size_t)q->c->N * 2 * (size_t)q->c->n * sizeof *q->W)))
        ric_periodic_states(q->m, q->c, q->W);
    return q->W;
}

/* What an operation makes of the springs that are closed after event 0. */
static uint64_t image_closed(const ric_model *m, const ric_periodic *c, int shift, bool reverse,
                             bool mirror)
{
    if (!ric_flight_law_of(m)->closes) return c->closed;
    uint64_t closed = ric_periodic_closed(m, c, shift);
    if (reverse) closed = ric_flight_toggle(m, closed, c->face[shift]);
    return mirror ? ric_flight_mirror(m, closed) : closed;
}

/* The state w [2n] after event 0 of an image. */
static void image_state(const images *q, int shift, bool reverse, bool mirror, double *w)
{
    const ric_periodic *c = q->c;
    const int n = c->n;
    const bool over = c->opposite && 2 * shift == c->N;
    memcpy(w, over ? c->opposite : q->W + 2 * n * shift, 2 * (size_t)n * sizeof *w);
    if (reverse && c->face[shift] >= 0) ric_flight_strike(n, &q->m->face[c->face[shift]], w + n);
    for (int i = 0; i < n; i++) {
        if (mirror) w[i] = -w[i];
        if (reverse != mirror) w[n + i] = -w[n + i];
    }
}

/* The flight of a cycle that is flight 0 of an image of it. */
static int first_flight(int N, int shift, bool reverse)
{
    return reverse ? following(N, shift, true) : shift;
}

/* Distance of an image from a; infinity when the words differ, or where a flight time alone is
 * farther away than `most`: times and words cost nothing, states are flown. */
static double image_distance(images *q, const ric_periodic *a, int shift, bool reverse, bool mirror,
                             double most)
{
    const ric_periodic *b = q->c;
    const int first = first_flight(b->N, shift, reverse);
    double w[2 * a->n], sum = 0, size = size_of(a);
    if (!same_word(q->m, a, b, shift, reverse, mirror) ||
        (mirror && !ric_periodic_mirrors(q->m, b)))
        return HUGE_VAL;
    for (int i = 0, j = first; i < a->N; i++, j = following(b->N, j, reverse))
        if (fabs(a->tau[i] - b->tau[j]) > most) return HUGE_VAL;
    if (a->closed != image_closed(q->m, b, shift, reverse, mirror) || !fly_states(q))
        return HUGE_VAL;
    image_state(q, shift, reverse, mirror, w);
    for (int i = 0; i < 2 * a->n; i++) sum = fmax(sum, fabs(a->w[i] - w[i]) / size);
    for (int i = 0, j = first; i < a->N; i++, j = following(b->N, j, reverse))
        sum = fmax(sum, fabs(a->tau[i] - b->tau[j]));
    return sum;
}

bool ric_periodic_apart(const ric_model *m, const ric_periodic *c, int shift, int operation,
                        double most)
{
    const bool reverse = operation & 1, mirror = operation & 2;
    const int first = first_flight(c->N, shift, reverse);
    if (!same_word(m, c, c, shift, reverse, mirror)) return true;
    for (int i = 0, j = first; i < c->N; i++, j = following(c->N, j, reverse))
        if (fabs(c->tau[i] - c->tau[j]) > most) return true;
    return false;
}

bool ric_periodic_alike(const ric_model *m, const ric_periodic *a, const ric_periodic *b)
{
    bool found = false;
    for (int op = 0; a->N == b->N && op < ric_periodic_operations(m); op++)
        for (int s = 0; s < a->N && !found; s++) found = same_word(m, a, b, s, op & 1, op & 2);
    return found;
}

bool ric_periodic_match(const ric_model *m, const ric_periodic *a, const ric_periodic *b,
                        double tolerance, ric_turn *turn)
{
    images q = {.m = m, .c = b};
    double nearest = HUGE_VAL;
    bool sure = false;
    /* by the fewest flights first: an orbit with mirror points comes to its other half by reversal
     * as well, where flying through one would multiply what rounding leaves of its start */
    for (int s = 0; a->N == b->N && s < a->N && !sure; s++)
        for (int op = 0; op < ric_periodic_operations(m) && !sure; op++) {
            double distance = image_distance(&q, a, s, op & 1, op & 2, fmin(tolerance, APART));
            if (distance > tolerance || distance >= nearest) continue;
            nearest = distance;
            *turn = (ric_turn){s, op & 1, op & 2};
            /* the images of an orbit with symmetries differ by rounding: the first one */
            sure = distance <= RIC_SAME_SOLVED;
        }
    free(q.W);
    return nearest < HUGE_VAL;
}

static int shifts(images *q, double tolerance)
{
    const ric_periodic *c = q->c;
    for (int s = 1; s < c->N; s++)
        if (c->N % s == 0 &&
            image_distance(q, c, s, false, false, fmin(tolerance, APART)) <= tolerance)
            return s;
    return c->N;
}

/* The least shift that takes the cycle to itself; N: none does. */
int ric_periodic_shifts(const ric_model *m, const ric_periodic *c, double tolerance)
{
    images q = {.m = m, .c = c};
    int s = shifts(&q, tolerance);
    free(q.W);
    return s;
}

ric_periodic *ric_periodic_nearest_event(const ric_model *m, const ric_periodic *orbit,
                                         const ric_periodic *near, double limit)
{
    images q = {.m = m, .c = near};
    double least = limit;
    int best = -1, shift = 0;
    for (int op = 0; orbit->N == near->N && op < ric_periodic_operations(m); op++)
        for (int s = 0; s < near->N; s++) {
            double distance = image_distance(&q, orbit, s, op & 1, op & 2, least);
            if (!(distance < least)) continue;
            least = distance;
            best = op;
            shift = s;
        }
    free(q.W);
    return best < 0 ? NULL : ric_periodic_transform(m, near, shift, best & 1, best & 2);
}

/* Whether both mirror points of the reversal s are of a kind that is said: an even half position is
 * an impact. */
static bool mirrors_fit(const ric_periodic_claim *said, int s, int N)
{
    bool impact = s % 2 == 0 || (s + N) % 2 == 0, rest = s % 2 != 0 || (s + N) % 2 != 0;
    return !said || ((!impact || said->impact) && (!rest || said->rest));
}

/* Of the reversals, with x -> -x or not, that hold: the first, or of a stored orbit, whose branch
 * `said` speaks of, the one that holds best; -1 if none does. The image under (shift s, reverse)
 * has impact i = old impact s - i. */
static int reversal(images *q, int period, bool mirror, double tolerance,
                    const ric_periodic_claim *said)
{
    const ric_periodic *c = q->c;
    double least = tolerance;
    int best = -1;
    for (int s = 0; s < period && (said || best < 0); s++) {
        if (!mirror && !mirrors_fit(said, s, c->N)) continue;
        double distance = image_distance(q, c, s, true, mirror, fmin(least, APART));
        if (!(distance <= least) || (best >= 0 && distance == least)) continue;
        least = distance;
        best = s;
    }
    return best;
}

int ric_periodic_try_symmetries(const ric_model *m, ric_periodic *c, int copies, double tolerance,
                                const ric_periodic_claim *said)
{
    images of = {.m = m, .c = c};
    int shift = said ? c->N : shifts(&of, tolerance), q = shift < c->N ? c->N / shift : copies,
        period = c->N / q;
    double most = fmin(tolerance, APART);
    c->half = period % 2 == 0 && image_distance(&of, c, period / 2, false, true, most) <= tolerance;
    c->pure = reversal(&of, period, false, tolerance, said);
    c->flip = reversal(&of, period, true, tolerance, said);
    free(of.W);
    return q;
}

void ric_periodic_word(const ric_model *m, const ric_periodic *c, int *word)
{
    uint64_t closed = c->closed;
    for (int i = 0; i < ric_periodic_letters(c); i++) {
        if (i > 0) closed = ric_flight_toggle(m, closed, c->face[i]);
        word[i] = m->face[c->face[i]].spring > 0 && !ric_face_in(closed, c->face[i])
                      ? m->n_face + c->face[i]
                      : c->face[i];
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
        if (m->face[f].spring > 0 && !ric_face_in(met, f) && opens == (i > 0))
            c->closed |= (uint64_t)1 << f;
        if (m->face[f].spring > 0) met |= (uint64_t)1 << f;
    }
}

static uint64_t bit_of(int face)
{
    return face < 0 ? 0 : (uint64_t)1 << (face % RIC_FACES_MAX);
}

/* A cycle as an operation reads it, which takes no time: its events from `shift` on, forwards or
 * back, each on its own face or on the opposite one; `closed`: springs after the first. */
typedef struct {
    const ric_model *m; /* NULL: nothing is mirrored */
    const ric_periodic *c;
    int shift;
    bool reverse, mirror;
    uint64_t closed;
} reading;

static int face_at(const reading *r, int place)
{
    return mirrored(r->m, r->c->face[place], r->mirror);
}

/* By the events, and the springs that are closed after the first. */
static int compare_words(uint64_t springs, const reading *a, const reading *b)
{
    uint64_t x = a->closed, y = b->closed;
    const int N = a->c->N;
    for (int i = 0, j = a->shift, k = b->shift; i < N; i++) {
        const int own = face_at(a, j), theirs = face_at(b, k);
        uint64_t f = bit_of(own) & springs, g = bit_of(theirs) & springs;
        if (i > 0) x ^= f;
        if (i > 0) y ^= g;
        bool opens = f && !(x & f), other = g && !(y & g);
        if (opens != other)
            return opens ? 1 : -1; /* closings first: the smallest word starts with one */
        if (own != theirs) return own < theirs ? -1 : 1;
        j = following(N, j, a->reverse);
        k = following(N, k, b->reverse);
    }
    if (a->closed != b->closed) return a->closed < b->closed ? -1 : 1;
    return 0;
}

/* By the states v and w [2n] after the first event, then flight times. */
static int compare_states(const reading *a, const double *v, const reading *b, const double *w)
{
    const int n = a->c->n, N = a->c->N;
    const double size = 1 + sqrt(ric_dot(2 * n, v, v));
    for (int i = 0; i < 2 * n; i++)
        if (fabs(v[i] - w[i]) > RIC_SAME_LOCATED * size) return v[i] < w[i] ? -1 : 1;
    int j = first_flight(N, a->shift, a->reverse), k = first_flight(N, b->shift, b->reverse);
    for (int i = 0; i < N; i++) {
        const double own = a->c->tau[j], theirs = b->c->tau[k];
        if (fabs(own - theirs) > RIC_SAME_LOCATED) return own < theirs ? -1 : 1;
        j = following(N, j, a->reverse);
        k = following(N, k, b->reverse);
    }
    return 0;
}

int ric_periodic_compare(uint64_t springs, const ric_periodic *a, const ric_periodic *b)
{
    const reading own = {.c = a, .closed = a->closed}, other = {.c = b, .closed = b->closed};
    const int order = compare_words(springs, &own, &other);
    return order ? order : compare_states(&own, a->w, &other, b->w);
}

/* Words tell most images from each other: only of those with the smallest are states flown, all at
 * once. */
ric_periodic *ric_periodic_canonical(const ric_model *m, const ric_periodic *c)
{
    const uint64_t springs = ric_periodic_springs(m);
    const bool mirrors = ric_periodic_mirrors(m, c);
    reading best = {.m = m, .c = c, .closed = c->closed};
    double v[2 * c->n], w[2 * c->n];
    images q = {.m = m, .c = c};
    bool flown = false;
    for (int op = 0; op < ric_periodic_operations(m); op++)
        for (int s = 0; s < c->N && (mirrors || !(op & 2)); s++) {
            reading next = {m, c, s, op & 1, op & 2, image_closed(m, c, s, op & 1, op & 2)};
            int order = compare_words(springs, &next, &best);
            if (order == 0 && (op || s)) {
                if (!fly_states(&q)) return NULL;
                if (!flown) image_state(&q, best.shift, best.reverse, best.mirror, v);
                flown = true;
                image_state(&q, s, op & 1, op & 2, w);
                order = compare_states(&next, w, &best, v);
                if (order < 0) memcpy(v, w, sizeof v);
            } else if (order < 0) flown = false;
            if (order < 0) best = next;
        }
    free(q.W);
    if (best.shift == 0 && !best.reverse && !best.mirror) return ric_periodic_copy(c);
    return ric_periodic_transform(m, c, best.shift, best.reverse, best.mirror);
}
