#include "hunt.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"

/* SAME: impacts of one orbit found twice agree within this; other orbits are farther away or
 * counted as one */
#define SAME 1e-6
#define PERIODS 1e-7 /* the same of periods, relative */

void ric_hunt_options_init(ric_hunt_options *o)
{
    *o = (ric_hunt_options){.impacts = 6,
                            .period = {0, INFINITY},
                            .lines = 20000,
                            .rows = 60,
                            .row = 1000,
                            .random = 250000,
                            .starts = 60,
                            .seed = 1};
}

void ric_hunt_options_bound(ric_hunt_options *o, const ric_study *study)
{
    const ric_explore_options *window = ric_study_options(study);
    o->period[0] = RIC_TWO_PI / window->frequency[1];
    o->period[1] = RIC_TWO_PI / window->frequency[0];
}

static ric_status check_options(const ric_hunt_options *o)
{
    if (!(o->energy > 0 && o->energy < INFINITY))
        return ric_fail(RIC_E_INPUT, "energy: %g is none to look at; give a number above 0",
                        o->energy);
    if (o->impacts < 1 || o->impacts > RIC_HUNT_IMPACTS)
        return ric_fail(RIC_E_INPUT, "impacts: %d; give 1 to %d", o->impacts, RIC_HUNT_IMPACTS);
    if (!(o->period[0] >= 0 && o->period[0] < o->period[1]))
        return ric_fail(
            RIC_E_INPUT,
            "period: from %g to %g s is no range; give two times, the smaller one first",
            o->period[0], o->period[1]);
    if (o->lines < 2 || o->row < 2 || o->rows < 0 || o->random < 0 || o->starts < 0)
        return ric_fail(RIC_E_INPUT,
                        "lines %d, rows %d of %d, random %d, starts %d: lines and points of a row "
                        "are at least 2, "
                        "the others at least 0",
                        o->lines, o->rows, o->row, o->random, o->starts);
    return RIC_OK;
}

ric_status ric_hunt_create(const ric_model *m, const ric_hunt_options *o, ric_hunt **out)
{
    *out = NULL;
    if (check_options(o)) return RIC_E_INPUT;
    ric_hunt *h = ric_calloc(1, sizeof *h);
    if (!h) return ric_no_memory("the hunt");
    h->options = *o;
    ric_status status = ric_impact_map_create(m, o->energy, &h->section);
    if (status) {
        ric_hunt_free(h);
        return status;
    }
    *out = h;
    return RIC_OK;
}

void ric_hunt_free(ric_hunt *h)
{
    if (!h) return;
    for (int i = 0; i < h->n; i++) free(h->prey[i].hits);
    free(h->prey);
    ric_impact_map_free(h->section);
    free(h);
}

ric_status ric_hunt_report(ric_hunt *h, const char *what, double part)
{
    if (h->options.progress && h->options.progress(what, part, h->n, h->options.user))
        return ric_fail(RIC_E_INTERRUPTED, "stopped on request");
    return RIC_OK;
}

/* splitmix64 (Steele, Lea, Flood 2014). */
uint64_t ric_hunt_random(uint64_t *state)
{
    uint64_t z = *state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
}

double ric_hunt_uniform(uint64_t *state)
{
    return (double)(ric_hunt_random(state) >> 11) * 0x1p-53;
}

bool ric_hunt_coin(uint64_t *state)
{
    return ric_hunt_random(state) >> 63 == 0;
}

/* ------------------------------------------------------------------ images */

/* `shift` counts in the orbit as it is, which is then run backwards and mirrored. */
typedef struct {
    int shift;
    bool reverse, mirror;
} operation;

/* Impact i of the image. */
static ric_hit image(const ric_impact_map *s, int N, const ric_hit *hits, operation op, int i)
{
    int at = op.reverse ? ((op.shift - i) % N + N) % N : (op.shift + i) % N;
    ric_hit hit = hits[at];
    if (op.reverse) {
        hit = ric_impact_map_reversed(hit);
        hit.tau = hits[(at + N - 1) % N].tau;
    }
    return op.mirror ? ric_impact_map_mirrored(s, hit) : hit;
}

static bool same_hit(ric_hit a, ric_hit b, double tolerance)
{
    return a.face == b.face && fabs(a.y - b.y) < tolerance && fabs(a.angle - b.angle) < tolerance &&
           fabs(a.tau - b.tau) < tolerance * (1 + a.tau);
}

/* Whether the image of b is a. */
static bool matches(const ric_impact_map *s, int N, const ric_hit *a, const ric_hit *b,
                    operation op, double tolerance)
{
    for (int i = 0; i < N; i++)
        if (!same_hit(a[i], image(s, N, b, op, i), tolerance)) return false;
    return true;
}

static bool equivalent(const ric_impact_map *s, int N, const ric_hit *a, const ric_hit *b,
                       double tolerance)
{
    int mirrors = ric_model_symmetric(s->model) ? 2 : 1;
    for (int shift = 0; shift < N; shift++)
        for (int turn = 0; turn < 2 * mirrors; turn++)
            if (matches(s, N, a, b, (operation){shift, turn & 1, turn & 2}, tolerance)) return true;
    return false;
}

static int compare(int N, const ric_hit *a, const ric_hit *b)
{
    for (int i = 0; i < N; i++)
        if (a[i].face != b[i].face) return a[i].face < b[i].face ? -1 : 1;
    for (int i = 0; i < N; i++) {
        if (fabs(a[i].y - b[i].y) > SAME) return a[i].y < b[i].y ? -1 : 1;
        if (fabs(a[i].angle - b[i].angle) > SAME) return a[i].angle < b[i].angle ? -1 : 1;
    }
    return 0;
}

/* The smallest image takes the place of hits. */
static void make_canonical(const ric_impact_map *s, int N, ric_hit *hits, ric_hit *best,
                           ric_hit *trial)
{
    int mirrors = ric_model_symmetric(s->model) ? 2 : 1;
    memcpy(best, hits, (size_t)N * sizeof *best);
    for (int shift = 0; shift < N; shift++)
        for (int turn = 0; turn < 2 * mirrors; turn++) {
            for (int i = 0; i < N; i++)
                trial[i] = image(s, N, hits, (operation){shift, turn & 1, turn & 2}, i);
            if (compare(N, trial, best) < 0) memcpy(best, trial, (size_t)N * sizeof *best);
        }
    memcpy(hits, best, (size_t)N * sizeof *hits);
}

static bool repeats(const ric_impact_map *s, int N, const ric_hit *hits)
{
    for (int d = 1; d < N; d++)
        if (N % d == 0 && matches(s, N, hits, hits, (operation){.shift = d}, SAME)) return true;
    return false;
}

/* Those of the orbit, which may have x -> -x where the structure has a stop on one side only that
 * it does not meet. */
static void find_symmetries(const ric_impact_map *s, ric_prey *prey)
{
    int N = prey->N;
    bool mirrors = true;
    for (int i = 0; i < N; i++) mirrors = mirrors && s->face[prey->hits[i].face].mirror >= 0;
    prey->pure = prey->flip = -1;
    prey->symmetric = mirrors && N % 2 == 0 &&
                      matches(s, N, prey->hits, prey->hits, (operation){N / 2, false, true}, SAME);
    for (int shift = 0; shift < N; shift++)
        for (int mirror = 0; mirror <= mirrors; mirror++) {
            int *reversal = mirror ? &prey->flip : &prey->pure;
            if (*reversal < 0 &&
                matches(s, N, prey->hits, prey->hits, (operation){shift, true, mirror}, SAME))
                *reversal = shift;
        }
    prey->reversible = prey->pure >= 0 || prey->flip >= 0;
}

/* ------------------------------------------------------------------- prey */

static double period_of(int N, const ric_hit *hits)
{
    double sum = 0;
    for (int k = 0; k < N; k++) sum += hits[k].tau;
    return sum;
}

int ric_hunt_find(const ric_hunt *h, int N, const ric_hit *hits, double tolerance)
{
    double period = period_of(N, hits);
    for (int i = 0; i < h->n; i++)
        if (h->prey[i].N == N &&
            fabs(h->prey[i].period - period) < fmax(PERIODS, tolerance) * (1 + period) &&
            equivalent(h->section, N, h->prey[i].hits, hits, tolerance))
            return i;
    return -1;
}

static ric_status keep(ric_hunt *h, int N, const ric_hit *hits, double trace)
{
    if (h->n == h->capacity) {
        int capacity = h->capacity ? 2 * h->capacity : 64;
        ric_prey *grown = ric_realloc(h->prey, (size_t)capacity * sizeof *grown);
        if (!grown) return ric_no_memory("the hunt");
        h->prey = grown;
        h->capacity = capacity;
    }
    ric_hit *own = ric_malloc((size_t)(3 * N) * sizeof *own);
    if (!own) return ric_no_memory("the hunt");
    memcpy(own, hits, (size_t)N * sizeof *own);
    make_canonical(h->section, N, own, own + N, own + 2 * N);
    ric_prey *prey = &h->prey[h->n++];
    *prey = (ric_prey){.N = N, .hits = own, .period = period_of(N, own), .trace = trace};
    find_symmetries(h->section, prey);
    return RIC_OK;
}

/* The second half of an orbit with z(t + T/2) = -z(t). */
static void unfold(const ric_impact_map *s, int half, ric_hit *hits)
{
    for (int k = 0; k < half; k++) hits[half + k] = ric_impact_map_mirrored(s, hits[k]);
}

ric_status ric_hunt_try(ric_hunt *h, int N, bool half, const ric_hit *hits, ric_hunt_way way)
{
    int full = half ? 2 * N : N;
    ric_hit orbit[full];
    double *work = ric_malloc(ric_impact_map_work(N) * sizeof *work), D[4];
    if (!work) return ric_no_memory("the hunt");
    memcpy(orbit, hits, (size_t)N * sizeof *orbit);
    h->tries++;
    bool solved = ric_impact_map_polish(h->section, N, half, orbit, work);
    free(work);
    if (!solved) return RIC_OK;
    if (half) unfold(h->section, N, orbit);
    double period = period_of(full, orbit);
    if (period > h->options.period[1] || period < h->options.period[0] ||
        repeats(h->section, full, orbit))
        return RIC_OK;
    int known = ric_hunt_find(h, full, orbit, SAME);
    if (known < 0) {
        if (!ric_impact_map_admissible(h->section, full, orbit) ||
            !ric_impact_map_around(h->section, full, orbit, D)) {
            h->ghosts++;
            return RIC_OK;
        }
        ric_status status = keep(h, full, orbit, D[0] + D[3]);
        if (status) return status;
        known = h->n - 1;
    }
    h->prey[known].from[way]++;
    return RIC_OK;
}

static int prey_order(const void *x, const void *y)
{
    const ric_prey *a = x, *b = y;
    if (a->N != b->N) return a->N - b->N;
    for (int i = 0; i < a->N; i++)
        if (a->hits[i].face != b->hits[i].face) return a->hits[i].face - b->hits[i].face;
    if (fabs(a->period - b->period) > PERIODS * a->period) return a->period < b->period ? -1 : 1;
    return compare(a->N, a->hits, b->hits);
}

ric_status ric_hunt_run(ric_hunt *h)
{
    ric_status status = ric_hunt_mirrors(h);
    if (!status) status = ric_hunt_rows(h);
    if (!status) status = ric_hunt_words(h);
    if (h->n) qsort(h->prey, (size_t)h->n, sizeof *h->prey, prey_order);
    return status;
}

/* ----------------------------------------------------------------- answers */

int ric_hunt_n_found(const ric_hunt *h)
{
    return h->n;
}

/* The roots of lambda^2 - trace lambda + 1, without cancellation. */
static void write_multipliers(double trace, double *out)
{
    double half = trace / 2, root = sqrt(fabs(half - 1)) * sqrt(fabs(half + 1)),
           large = half + copysign(root, half);
    bool circle = fabs(half) < 1;
    out[0] = circle ? half : large;
    out[1] = circle ? root : 0;
    out[2] = circle ? half : 1 / large;
    out[3] = circle ? -root : 0;
}

ric_status ric_hunt_found(const ric_hunt *h, int i, ric_found *out, int *word, double *state,
                          double *flights)
{
    if (i < 0 || i >= h->n)
        return ric_fail(RIC_E_RANGE, "no orbit %d: the hunt has found %d, from 0 on", i, h->n);
    const ric_prey *p = &h->prey[i];
    if (out) {
        *out = (ric_found){.impacts = p->N,
                           .period = p->period,
                           .trace = p->trace,
                           .symmetric = p->symmetric,
                           .reversible = p->reversible};
        write_multipliers(p->trace, out->multipliers);
    }
    for (int k = 0; k < p->N; k++) {
        if (word) word[k] = p->hits[k].face;
        if (flights) flights[k] = p->hits[k].tau;
    }
    if (state) ric_impact_map_write(h->section, &p->hits[0], state, state + h->section->n_dof);
    return RIC_OK;
}
