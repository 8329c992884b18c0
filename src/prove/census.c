/* All periodic orbits of one energy with few impacts: words, boxes of their flight times, threads,
 * and the account. */
#include "census.h"

#include <limits.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "base/room.h"
#include "census_flight.h"
#include "prover.h"

enum {
    BITS = 128,
    TASKS = 256,     /* boxes that a word is divided into for the workers */
    TRIES_APART = 2, /* divisions between two attempts to prove a zero */
    DEEPEST = 400,   /* divisions */
};
#define NANOSECOND 1e-9
#define LONGEST_TIME 1e6 /* in units of the enclosure, of a flight or a period */
/* TRY_BELOW: sum of the widths of flights times the largest frequency, for an attempt */
#define TRY_BELOW 0.4
/* SMALLEST: of flights times the largest frequency: boxes are not divided further. Where solutions
 * lie on curves or surfaces, all boxes along them come to that: n times SOON boxes behind the first
 * one of a part of the search, the next ones need only be n^3 times as large, up to COARSE, so that
 * it ends. Two impacts at once on one face are none, whatever the speed: where linear motions come
 * back, boxes of 1e-4 all over such a surface are proved to hold no orbit, one after another, for
 * the sign of that speed, and there is no first one. There a part of the search counts as if it had
 * been box PATIENCE. */
#define SMALLEST 1e-9
#define COARSE 1e-2
#define SOON 10.0
enum { PATIENCE = 10000 };
/* RETURNED: turns: phases that differ by less are one to boxes along a curve */
#define RETURNED 1e-7
/* STATE_BEHIND: a state that is known that many times worse than flights say is divided first, */
#define STATE_BEHIND 20.0
/* STATE_FIRST: and one that is known no better than that, of |w|: flights follow from it */
#define STATE_FIRST 0.12

typedef struct {
    ric_census_word word;
    bool turned; /* flights 1 and N - 1 may be exchanged */
    ric_census_box box;
    int n, room;
    ric_census_find *found;
    long boxes, undecided, first; /* first: boxes until one was not divided further, or 0 */
    double measure;
} task;

struct ric_census {
    const ric_model *model;
    ric_census_options options;
    ric_enclosure e;
    ric_census_pair pair;
    ric_census_limits limits; /* in units of the enclosure */
    double flight;
    long patience;
    int n_word, n_task;
    task *tasks;
    int n, ghosts, n_open;
    ric_census_find *orbits, *open; /* borrowed from the tasks */
    atomic_int next, done, found;
    atomic_bool stop, lost;
    struct timespec start;
};

/* --------------------------------------------------------------------- search */

static double now_since(const struct timespec *start)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)(now.tv_sec - start->tv_sec) +
           NANOSECOND * (double)(now.tv_nsec - start->tv_nsec);
}

static double volume(const ric_census_box *b, int N)
{
    double v = 1;
    for (int k = 0; k < N; k++) v *= b->t[k].hi - b->t[k].lo;
    for (int i = 0; i < 4; i++) v *= b->w[i].hi - b->w[i].lo;
    return v;
}

static bool lies_within(const ric_census_box *inner, const ric_census_box *outer, int N)
{
    for (int k = 0; k < N; k++)
        if (!(inner->t[k].lo > outer->t[k].lo && inner->t[k].hi < outer->t[k].hi)) return false;
    for (int i = 0; i < 4; i++)
        if (!(inner->w[i].lo > outer->w[i].lo && inner->w[i].hi < outer->w[i].hi)) return false;
    return true;
}

/* Whether the only zero of the box is one that is known. */
static bool is_known(const ric_census *s, const task *t, const ric_census_box *b)
{
    for (int i = 0; i < t->n; i++) {
        ric_census_box region;
        ric_census_zero_box(&s->pair, &t->word, &t->found[i].zero, t->found[i].zero.unique,
                            &region);
        if (lies_within(b, &region, t->word.N)) return true;
    }
    return false;
}

static void try_zero(ric_census *s, task *t, const ric_census_box *b)
{
    ric_census_find find = {.word = t->word};
    if (!ric_census_zero_find(&s->pair, &t->word, b, &find.zero)) return;
    for (int i = 0; i < t->n; i++)
        if (ric_census_is_image(&find, &t->found[i], &s->pair, 0, false, false)) return;
    if (t->n == t->room) {
        ric_census_find *more = ric_realloc(t->found, (size_t)(2 * t->room + 4) * sizeof *more);
        if (!more) {
            s->lost = s->stop = true;
            return;
        }
        t->found = more;
        t->room = 2 * t->room + 4;
    }
    ric_census_judge(&find, &s->pair);
    s->found += find.verdict == RIC_CENSUS_ORBIT;
    t->found[t->n++] = find;
}

static void leave(task *t, const ric_census_box *b)
{
    t->undecided++;
    t->measure += volume(b, t->word.N);
}

/* The unknown to divide: a state of which it is not known where its flights lead; then the longest
 * flight, unless the state is much worse known than flights account for. */
static ric_range *widest(const ric_census *s, ric_census_box *b, int N, double *width)
{
    ric_range *flight = &b->t[0], *state = &b->w[0];
    for (int k = 1; k < N; k++)
        if (b->t[k].hi - b->t[k].lo > flight->hi - flight->lo) flight = &b->t[k];
    for (int i = 1; i < 4; i++)
        if (b->w[i].hi - b->w[i].lo > state->hi - state->lo) state = &b->w[i];
    const double times = (flight->hi - flight->lo) * s->pair.top,
                 size = (state->hi - state->lo) / s->pair.size;
    *width = fmax(times, size / STATE_BEHIND);
    return size > STATE_FIRST || size > STATE_BEHIND * times ? state : flight;
}

static double smallest(const ric_census *s, const task *t)
{
    const long first = t->first ? t->first : s->patience;
    const double n = fmax(0, (double)(t->boxes - first) / SOON);
    return fmin(COARSE, SMALLEST * (1 + n * n * n));
}

static void search(ric_census *s, task *t, ric_census_box *b, int tries, int depth)
{
    double width;
    const int N = t->word.N;
    if (s->stop) {
        leave(t, b);
        return;
    }
    t->boxes++;
    /* Run backwards, and mirrored where that takes the word to itself, an orbit is one with flights
     * 1 and N - 1 exchanged: the one with the longer flight 1 stands for both. */
    if (t->turned && b->t[1].hi < b->t[N - 1].lo) return;
    if (!ric_census_box_reduce(b, &s->pair, &t->word, &s->limits) || is_known(s, t, b)) return;
    double sum = 0;
    for (int k = 0; k < N; k++) sum += b->t[k].hi - b->t[k].lo;
    if (sum * s->pair.top < TRY_BELOW && (tries <= 0 || sum * s->pair.top < SMALLEST)) {
        tries = TRIES_APART;
        try_zero(s, t, b);
        if (is_known(s, t, b)) return;
    }
    ric_range *x = widest(s, b, N, &width);
    if (width < smallest(s, t) || depth > DEEPEST) {
        if (!t->first) t->first = t->boxes;
        leave(t, b);
        return;
    }
    const double middle = ric_census_box_middle(*x);
    const ptrdiff_t at = (char *)x - (char *)b;
    ric_census_box part = *b;
    ((ric_range *)(void *)((char *)&part + at))->hi = middle;
    search(s, t, &part, tries - 1, depth + 1);
    part = *b;
    ((ric_range *)(void *)((char *)&part + at))->lo = middle;
    search(s, t, &part, tries - 1, depth + 1);
}

/* -------------------------------------------------------------------- workers */

static bool asked_to_stop(ric_census *s)
{
    if (now_since(&s->start) > s->options.seconds) return true;
    return s->options.progress && s->options.progress(s->n_task ? (double)s->done / s->n_task : 1,
                                                      s->found, s->options.user);
}

static void work_through(ric_census *s, bool first)
{
    for (;;) {
        const int i = atomic_fetch_add(&s->next, 1);
        if (i >= s->n_task) return;
        ric_census_box box = s->tasks[i].box;
        search(s, &s->tasks[i], &box, 0, 0);
        atomic_fetch_add(&s->done, 1);
        if (first && asked_to_stop(s)) s->stop = true;
    }
}

static void *work(void *user)
{
    work_through(user, false);
    flint_cleanup();
    return NULL;
}

/* Waits for the threads, and says how far they are. */
static void attend(ric_census *s)
{
    const struct timespec nap = {0, 20000000};
    while (s->done < s->n_task) {
        if (!s->stop && asked_to_stop(s)) s->stop = true;
        nanosleep(&nap, NULL);
    }
}

static void work_all(ric_census *s)
{
    const int wanted = s->options.workers;
    int started = 0;
    s->stop = s->stop || asked_to_stop(s); /* no time is no time, however quick the threads are */
    pthread_t *threads = ric_calloc((size_t)wanted, sizeof *threads);
    while (threads && started < wanted && !pthread_create(&threads[started], NULL, work, s))
        started++;
    if (started) attend(s);
    else work_through(s, true);
    for (int i = 0; i < started; i++) pthread_join(threads[i], NULL);
    free(threads);
}

/* ---------------------------------------------------------------------- words */

/* Words of N faces that begin with their longest flight: of those that are images of one another,
 * run backwards or mirrored, the smallest one. */
static int compare(const ric_census_word *a, const ric_census_word *b)
{
    for (int i = 0; i < a->N; i++)
        if (a->face[i] != b->face[i]) return a->face[i] < b->face[i] ? -1 : 1;
    return 0;
}

/* Backwards the longest flight goes from impact 1 to impact 0. */
static ric_census_word image_of(const ric_census_word *w, const ric_census_pair *p, bool reverse,
                                bool mirror)
{
    ric_census_word out = {.N = w->N};
    for (int i = 0; i < w->N; i++) {
        const int face = w->face[reverse ? (1 - i + 2 * w->N) % w->N : i];
        out.face[i] = mirror ? p->face[face].mirror : face;
    }
    return out;
}

static bool is_smallest(const ric_census_word *w, const ric_census_pair *p)
{
    for (int image = 1; image < (p->mirrored ? 4 : 2); image++) {
        const ric_census_word other = image_of(w, p, image & 1, image & 2);
        if (compare(&other, w) < 0) return false;
    }
    return true;
}

/* Whether its own image, run backwards, is the word again. */
static bool is_turned(const ric_census_word *w, const ric_census_pair *p)
{
    for (int mirror = 0; mirror < (p->mirrored ? 2 : 1) && w->N > 2; mirror++) {
        const ric_census_word other = image_of(w, p, true, mirror);
        if (compare(&other, w) == 0) return true;
    }
    return false;
}

static bool next_word(ric_census_word *w, int n_face)
{
    for (int i = w->N - 1; i >= 0; i--) {
        if (++w->face[i] < n_face) return true;
        w->face[i] = 0;
    }
    return false;
}

/* Boxes of a word: states are halved, one number after the other. */
static bool divide(ric_census *s, const ric_census_word *word)
{
    const int first = s->n_task;
    task *more = ric_realloc(s->tasks, (size_t)(s->n_task + TASKS) * sizeof *more);
    if (!more) return false;
    s->tasks = more;
    task *t = &s->tasks[s->n_task++];
    *t = (task){.word = *word, .turned = is_turned(word, &s->pair)};
    for (int k = 0; k < word->N; k++) t->box.t[k] = (ric_range){0, s->limits.flight};
    for (int i = 0; i < 4; i++) t->box.w[i] = (ric_range){-s->pair.size, s->pair.size};
    for (int level = 0; s->n_task - first < TASKS; level++) {
        const int n = s->n_task;
        for (int i = first; i < n; i++) {
            ric_range *x = &s->tasks[i].box.w[level % 4];
            const double middle = ric_census_box_middle(*x);
            s->tasks[s->n_task] = s->tasks[i];
            x->hi = middle;
            s->tasks[s->n_task++].box.w[level % 4].lo = middle;
        }
    }
    return true;
}

static bool list_tasks(ric_census *s)
{
    if (!(s->limits.flight > 0)) return true;
    for (int N = 1; N <= s->options.impacts; N++) {
        ric_census_word w = {.N = N};
        do {
            if (!is_smallest(&w, &s->pair)) continue;
            s->n_word++;
            if (!divide(s, &w)) return false;
        } while (next_word(&w, s->pair.n_face));
    }
    return true;
}

/* --------------------------------------------------------------------- limits */

/* The mean force of the stops holds the mean displacement q: q.K q = -sum J_k s_k c_k.q / T with
 * impulses J_k >= 0. As s c.q is d at an impact and changes by no more than |c| |p| t, it is at
 * least d - |c| |w| T / 4 in the mean, and were that positive for all faces the right side would be
 * negative. So T >= 4 d / (|c| |w|) for one of them. */
static double shortest_period(const ric_census_pair *p)
{
    double least = HUGE_VAL;
    for (int f = 0; f < p->n_face; f++) {
        const ric_census_face *face = &p->face[f];
        least = fmin(least, ric_down(4 * (face->d.m - face->d.r) / ric_up(face->c_size * p->size)));
    }
    return ric_down(least);
}

static ric_status set_limits(ric_census *s)
{
    const double *asked = s->options.period,
                 unit = ldexp(1, (int)s->e.time); /* of the enclosure in a second */
    ric_census_limits *l = &s->limits;
    s->flight = ric_census_longest_flight(&s->pair);
    const double all = s->options.impacts * s->flight;
    l->period[0] = fmax(asked[0] * unit, shortest_period(&s->pair));
    l->period[1] = fmin(asked[1] * unit, ric_up(all));
    l->flight = fmin(s->flight, l->period[1]);
    if (l->period[1] < HUGE_VAL) return RIC_OK;
    return ric_fail(
        RIC_E_INPUT,
        "period: at energy %g no longest flight is proved, as a mode alone does not reach a stop; "
        "give a longest period",
        s->options.energy);
}

/* -------------------------------------------------------------------- account */

static bool is_wanted(const ric_census *s, const ric_census_find *z)
{
    const double unit = ldexp(1, -(int)s->e.time);
    return !z->repeats && z->period[1] >= s->limits.period[0] * unit &&
           z->period[0] <= s->limits.period[1] * unit;
}

static bool is_counted(const ric_census *s, const ric_census_find *z)
{
    for (int i = 0; i < s->n; i++)
        if (ric_census_same(z, &s->orbits[i], &s->pair)) return true;
    return false;
}

static int by_period(const void *x, const void *y)
{
    const ric_census_find *a = x, *b = y;
    if (a->word.N != b->word.N) return a->word.N - b->word.N;
    return a->period[0] < b->period[0] ? -1 : a->period[0] > b->period[0];
}

static bool gather(ric_census *s)
{
    int all = 0;
    for (int i = 0; i < s->n_task; i++) all += s->tasks[i].n;
    s->orbits = ric_calloc((size_t)all + 1, sizeof *s->orbits);
    s->open = ric_calloc((size_t)all + 1, sizeof *s->open);
    if (!s->orbits || !s->open) return false;
    for (int i = 0; i < s->n_task; i++)
        for (int j = 0; j < s->tasks[i].n; j++) {
            const ric_census_find *z = &s->tasks[i].found[j];
            s->ghosts += z->verdict == RIC_CENSUS_GHOST;
            if (z->verdict == RIC_CENSUS_OPEN) s->open[s->n_open++] = *z;
            if (z->verdict == RIC_CENSUS_ORBIT && !z->state) return false;
            if (z->verdict == RIC_CENSUS_ORBIT && is_wanted(s, z) && !is_counted(s, z))
                s->orbits[s->n++] = *z;
        }
    qsort(s->orbits, (size_t)s->n, sizeof *s->orbits, by_period);
    return true;
}

int ric_census_n_orbit(const ric_census *s)
{
    return s->n;
}

ric_status ric_census_orbit_at(const ric_census *s, int i, ric_census_orbit *out, int *word,
                               double *state, double *flights)
{
    if (i < 0 || i >= s->n)
        return ric_fail(RIC_E_RANGE,
                        "there is no orbit %d of the census; they are numbered from 0 to %d", i,
                        s->n - 1);
    const ric_census_find *z = &s->orbits[i];
    if (out)
        *out = (ric_census_orbit){.impacts = z->word.N,
                                  .period = {z->period[0], z->period[1]},
                                  .trace = {z->trace[0], z->trace[1]},
                                  .approach = z->approach,
                                  .stable = z->stable,
                                  .symmetric = z->symmetric,
                                  .reversible = z->reversible};
    if (word) memcpy(word, z->word.face, (size_t)z->word.N * sizeof *word);
    if (state) memcpy(state, z->state, 2 * (size_t)s->e.n_dof * sizeof *state);
    for (int k = 0; flights && k < z->word.N; k++)
        flights[k] = ldexp(z->zero.t[k], -(int)s->e.time);
    return RIC_OK;
}

ric_status ric_census_open_at(const ric_census *s, int i, int *impacts, int *word, double *flights)
{
    if (i < 0 || i >= s->n_open)
        return ric_fail(
            RIC_E_RANGE,
            "there is no open solution %d of the census; they are numbered from 0 to %d", i,
            s->n_open - 1);
    const ric_census_find *z = &s->open[i];
    *impacts = z->word.N;
    memcpy(word, z->word.face, (size_t)z->word.N * sizeof *word);
    for (int k = 0; k < z->word.N; k++) flights[k] = ldexp(z->zero.t[k], -(int)s->e.time);
    return RIC_OK;
}

void ric_census_account_of(const ric_census *s, ric_census_account *out)
{
    const double unit = ldexp(1, -(int)s->e.time);
    double all = 0;
    *out = (ric_census_account){.flight = s->flight * unit,
                                .period = {s->limits.period[0] * unit, s->limits.period[1] * unit},
                                .words = s->n_word,
                                .ghosts = s->ghosts,
                                .open = s->n_open,
                                .stopped = s->stop};
    out->all_periods = s->limits.period[1] >= s->options.impacts * s->flight &&
                       s->limits.period[0] <= shortest_period(&s->pair);
    for (int i = 0; i < s->n_task; i++) {
        all += volume(&s->tasks[i].box, s->tasks[i].word.N);
        out->boxes += s->tasks[i].boxes;
        out->undecided += s->tasks[i].undecided;
        out->measure += s->tasks[i].measure;
    }
    if (all > 0) out->measure /= all;
}

/* ------------------------------------------------------------------------ run */

void ric_census_options_init(ric_census_options *o)
{
    *o = (ric_census_options){.impacts = 3,
                              .period = {0, HUGE_VAL},
                              .workers = 1,
                              .seconds = HUGE_VAL};
}

static ric_status check_options(const ric_model *m, const ric_census_options *o)
{
    if (!(o->energy > 0 && o->energy < HUGE_VAL))
        return ric_fail(RIC_E_INPUT, "energy: %g is none to look at; give a number above 0",
                        o->energy);
    if (o->impacts < 1 || o->impacts > RIC_CENSUS_LONGEST)
        return ric_fail(RIC_E_INPUT, "impacts: %d; give 1 to %d", o->impacts, RIC_CENSUS_LONGEST);
    if (!(o->period[0] >= 0 && o->period[0] < o->period[1]))
        return ric_fail(
            RIC_E_INPUT,
            "period: from %g to %g s is no range; give two times, the smaller one first",
            o->period[0], o->period[1]);
    if (o->workers < 1 || !(o->seconds > 0))
        return ric_fail(RIC_E_INPUT, "workers %d, seconds %g: give numbers above 0", o->workers,
                        o->seconds);
    const char *left_out = ric_prover_springs(m) ? "bilinear springs"
                                                 : ric_prover_left_out_model(m);
    if (left_out)
        return ric_fail(RIC_E_INPUT, "a census leaves out structures like this: %s", left_out);
    return RIC_OK;
}

/* Whether all linear motions come back within the periods looked through, and some of them reach no
 * stop. */
static bool motions_return(const ric_census *s)
{
    const double low = fmin(s->pair.omega[0].m, s->pair.omega[1].m),
                 high = fmax(s->pair.omega[0].m, s->pair.omega[1].m),
                 most = s->limits.period[1] * low / RIC_TWO_PI;
    if (s->flight < HUGE_VAL) return false;
    for (int k = 1; k <= most; k++)
        if (fabs(k * high / low - round(k * high / low)) <= RETURNED) return true;
    return false;
}

/* The structure in the numbers of the search. The longest flight is not known before: what flights
 * leave open is asked for a long time, and the longest period has to be below that. */
static ric_status open_pair(ric_census *s)
{
    char why[160];
    if (!ric_enclosure_create(&s->e, s->model, BITS)) return ric_fail(RIC_E_INPUT, "%s", s->e.why);
    if (!ric_census_pair_create(&s->pair, &s->e, s->options.energy, LONGEST_TIME, why))
        return ric_fail(RIC_E_INPUT, "%s", why);
    ric_status status = set_limits(s);
    s->patience = motions_return(s) ? PATIENCE : LONG_MAX;
    if (!status && !ric_census_turns(&s->pair, s->limits.flight))
        status = ric_no_memory("a census");
    if (status || s->limits.period[1] <= s->pair.longest_period) return status;
    return ric_fail(RIC_E_INPUT, "period: %g s are too long for a census", s->limits.period[1]);
}

ric_status ric_census_run(const ric_model *m, const ric_census_options *o, ric_census **out)
{
    *out = NULL;
    ric_status status = check_options(m, o);
    if (status) return status;
    ric_census *s = ric_calloc(1, sizeof *s);
    if (!s) return ric_no_memory("a census");
    s->model = m;
    s->options = *o;
    clock_gettime(CLOCK_MONOTONIC, &s->start);
    status = open_pair(s);
    if (!status && !list_tasks(s)) status = ric_no_memory("a census");
    if (!status) work_all(s);
    if (!status && (s->lost || !gather(s))) status = ric_no_memory("a census");
    if (!status) *out = s;
    else ric_census_free(s);
    return status;
}

void ric_census_free(ric_census *s)
{
    if (!s) return;
    for (int i = 0; i < s->n_task; i++) {
        for (int j = 0; j < s->tasks[i].n; j++) free(s->tasks[i].found[j].state);
        free(s->tasks[i].found);
    }
    free(s->tasks);
    free(s->orbits);
    free(s->open);
    ric_census_pair_free(&s->pair);
    ric_enclosure_free(&s->e);
    free(s);
}
