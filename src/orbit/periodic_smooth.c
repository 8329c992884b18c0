/* Cycles of smooth structures (law power): no impacts, but two *marks* half a period apart, of face
 * -1 and without effect, to which the operations of periodic.h refer. An orbit with mirror points
 * starts at one of them; one without at the instant of largest |s| of the first contact, which
 * every symmetry respects (docs/theory.md section 10). */
#include <stdlib.h>
#include <string.h>

#include "periodic_form.h"
#include "flow/room.h"
#include "shooting_nodes.h"
#include "base/room.h"

#define SAMPLES 48 /* of an orbit per turn of the fastest mode, at least */
#define PIECES 3   /* and of every step of a flight */
/* SHORTEST: a piece shorter than this part of the longest is none: the flow cannot be followed */
#define SHORTEST 1e-6
#define NEWTON_STEPS 8

bool ric_periodic_mark(ric_periodic *c, int marks)
{
    double period = ric_periodic_period(c);
    if (!ric_periodic_room(c, marks)) return false;
    for (int i = 0; i < marks; i++) {
        c->face[i] = -1;
        c->tau[i] = period / marks;
    }
    return true;
}

bool ric_periodic_oppose(ric_periodic *c, const double *w)
{
    size_t bytes = 2 * (size_t)c->n * sizeof *w;
    if (!w) {
        free(c->opposite);
        c->opposite = NULL;
        return true;
    }
    if (!c->opposite && !(c->opposite = ric_malloc(bytes))) return false;
    memcpy(c->opposite, w, bytes);
    return true;
}

/* Moves the start by a time along the orbit. */
static void move(const ric_model *m, ric_periodic *c, double time)
{
    ric_flight_go(m, 0, -1, time, c->w, c->w);
    ric_periodic_oppose(c, NULL);
}

static bool half_mark(const ric_model *m, ric_periodic *c)
{
    move(m, c, ric_periodic_period(c) / (2 * c->N));
    if (c->pure >= 0) c->pure = (c->pure + c->N - 1) % c->N;
    if (c->flip >= 0) c->flip = (c->flip + c->N - 1) % c->N;
    return true;
}

static double gap_of(const ric_model *m, const double *w)
{
    return ric_dot(m->n, m->g, w);
}

static double longest_piece(const ric_model *m, double period)
{
    return period / (SAMPLES * (1 + period * m->omega[m->n - 1] / RIC_TWO_PI));
}

/* A piece of an orbit at w, short enough for a walk to see all: some to every turn of the fastest
 * mode, and to every time in which the motion changes its course, which within a contact of high
 * power may be a hundredth of that. */
static double piece(const ric_model *m, double period, const double *w)
{
    double longest = longest_piece(m, period), pace = ric_flight_pace(m, w) / PIECES;
    return pace > SHORTEST * longest ? fmin(longest, pace) : longest;
}

typedef struct {
    const ric_model *m;
    double period, step, time;
    int taken;
    double *w; /* [2n] where it has come to */
} walk;

static void walk_on(walk *q)
{
    if (q->taken++ % PIECES == 0) q->step = piece(q->m, q->period, q->w);
    ric_flight_go(q->m, 0, -1, q->step, q->w, q->w);
    q->time += q->step;
}

/* Moves w to where |s| of the first contact is largest within the period: sampled, then Newton on
 * ds/dt = 0. */
static void to_summit(const ric_model *m, double period, double *w)
{
    int n = m->n;
    double best[2 * n], now[2 * n], rate[2 * n], last = 0, around = 0;
    memcpy(now, w, sizeof now);
    memcpy(best, w, sizeof best);
    for (walk q = {.m = m, .period = period, .w = now}; q.time < period; walk_on(&q)) {
        double s = fabs(gap_of(m, now));
        if (s <= last) continue;
        last = s;
        around = q.step;
        memcpy(best, now, sizeof best);
    }
    around = fmax(around, piece(m, period, best));
    for (int i = 0; i < NEWTON_STEPS; i++) {
        double slope = 0, bend = 0;
        ric_flight_rate(m, 0, best, rate);
        for (int k = 0; k < n; k++) {
            slope += m->g[k] * rate[k];
            bend += m->g[k] * m->kappa[k] * rate[n + k];
        }
        double t = -slope / bend;
        if (!isfinite(t) || fabs(t) > around) break;
        ric_flight_go(m, 0, -1, t, best, best);
        if (fabs(t) < RIC_LAST_DIGIT * period) break;
    }
    memcpy(w, best, sizeof best);
}

static double distance(int size, const double *a, const double *b)
{
    double sum = 0;
    for (int i = 0; i < size; i++) sum += (a[i] - b[i]) * (a[i] - b[i]);
    return sqrt(sum);
}

/* Newton's method on the time at which the orbit through w passes the plane across the flow at
 * `to`; false if it is farther away than `most`. */
static bool onto_plane(const ric_model *m, const double *to, double most, double *w, double *time)
{
    int size = 2 * m->n;
    double across[size], rate[size], from = *time;
    ric_flight_rate(m, 0, to, across);
    for (int i = 0; i < NEWTON_STEPS; i++) {
        double off = 0;
        ric_flight_rate(m, 0, w, rate);
        for (int k = 0; k < size; k++) off += across[k] * (w[k] - to[k]);
        double t = -off / ric_dot(size, across, rate);
        if (!(fabs(*time + t - from) <= most)) return false;
        ric_flight_go(m, 0, -1, t, w, w);
        *time += t;
        if (fabs(t) < RIC_LAST_DIGIT * (most + fabs(*time))) break;
    }
    return true;
}

/* Moves w along its orbit to where that is nearest to `to`: sampled, every local minimum refined.
 * Returns the time that takes. */
static double to_neighbour(const ric_model *m, double period, const double *to, double *w)
{
    int size = 2 * m->n, beyond = 0;
    double now[size], best[size], off[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, least = HUGE_VAL,
                                  result = 0, last = 0;
    memcpy(now, w, sizeof now);
    memcpy(best, w, sizeof best);
    for (walk q = {.m = m, .period = period, .w = now};; walk_on(&q)) {
        memmove(off, off + 1, 2 * sizeof *off);
        off[2] = distance(size, now, to);
        if (q.taken > 1 && off[1] <= off[0] && off[1] <= off[2]) {
            double near[size], time = q.time - q.step;
            ric_flight_go(m, 0, -1, -q.step, now, near);
            if (onto_plane(m, to, fmax(last, q.step), near, &time) &&
                distance(size, near, to) < least) {
                least = distance(size, near, to);
                memcpy(best, near, sizeof best);
                result = time;
            }
        }
        if (q.time >= period && ++beyond == 2) break;
        last = q.step;
    }
    memcpy(w, best, sizeof best);
    return result;
}

double ric_periodic_phase(const ric_model *m, const ric_periodic *orbit, ric_periodic *near)
{
    ric_periodic_oppose(near, NULL);
    return ric_periodic_mark(near, orbit->N)
               ? to_neighbour(m, ric_periodic_period(near), orbit->w, near->w)
               : 0;
}

void ric_periodic_shift(const ric_model *m, const ric_periodic *orbit, double time,
                        ric_periodic *near)
{
    move(m, near, time);
    onto_plane(m, orbit->w, piece(m, ric_periodic_period(near), orbit->w), near->w, &(double){0});
}

/* ric_periodic_nearest of orbits that may start at any time. */
static ric_periodic *nearest_phase(const ric_model *m, const ric_periodic *orbit,
                                   const ric_periodic *near, double limit)
{
    ric_periodic *best = NULL;
    double least = limit;
    for (int op = 0; op < ric_periodic_operations(m); op++) {
        ric_periodic *image = ric_periodic_transform(m, near, 0, op & 1, op & 2);
        if (!image) continue;
        ric_periodic_phase(m, orbit, image);
        double off = ric_periodic_distance(orbit, image);
        if (off < least) {
            ric_periodic *last = best;
            best = image;
            image = last;
            least = off;
        }
        ric_periodic_free(image);
    }
    return best;
}

/* A reversal R takes the orbit to itself with a shift, R w = w(-t): its mirror points are half of
 * that behind w, and half a period on. */
static bool find_mirrors(const ric_model *m, ric_periodic *c, int copies, double tolerance)
{
    double period = ric_periodic_period(c) / copies;
    for (int flip = 0; flip < ric_periodic_operations(m) / 2; flip++) {
        ric_periodic *image = ric_periodic_transform(m, c, 0, true, flip),
                     *once = image ? ric_periodic_copy(c) : NULL;
        bool found = once && ric_periodic_mark(image, 2) && ric_periodic_mark(once, 2);
        for (int i = 0; found && i < 2; i++) once->tau[i] = image->tau[i] = period / 2;
        double time = found ? ric_periodic_phase(m, once, image) : 0;
        found = found && ric_periodic_distance(once, image) <= tolerance;
        ric_periodic_free(image);
        ric_periodic_free(once);
        if (!found) continue;
        move(m, c, -time / 2);
        *(flip ? &c->flip : &c->pure) = 0;
        return true;
    }
    return false;
}

static ric_periodic *from_chain(const ric_shooting *chain, const double *u)
{
    ric_periodic *c = ric_periodic_create(chain->n, 2);
    if (!c) return NULL;
    double period = ric_shooting_time(chain, u);
    c->face[0] = c->face[1] = -1;
    c->tau[0] = c->tau[1] = period / 2;
    c->parts = chain->parts > 1 ? chain->parts * chain->multiple : 0;
    memcpy(c->w, chain->w, 2 * (size_t)chain->n * sizeof *c->w);
    if (chain->start == RIC_MIRROR_NONE) {
        c->half = chain->sigma < 0;
        to_summit(chain->model, period, c->w);
        return c;
    }
    /* half positions: the mirror at the start and, half a period on, 2; a quarter on, 1 */
    c->half = chain->multiple == 4;
    if (chain->start == RIC_MIRROR_CENTRE) c->flip = 0;
    else c->pure = 0;
    if (c->half && chain->end == RIC_MIRROR_CENTRE) c->flip = 1;
    else if (c->half) c->pure = 1;
    /* at the other mirror point, with the zeros that it has there, or the image of the start */
    double far[2 * chain->n];
    const double *end = chain->w + 2 * chain->n;
    bool rest = chain->end == RIC_MIRROR_REST;
    for (int i = 0; i < 2 * chain->n; i++)
        far[i] = c->half ? -c->w[i] : (i < chain->n) == rest ? end[i] : 0;
    if (ric_periodic_oppose(c, far)) return c;
    ric_periodic_free(c);
    return NULL;
}

static ric_status to_chain(const ric_model *m, const ric_periodic *c, ric_shooting **chain,
                           double **u)
{
    static const int face[] = {-1, -1};
    int n = c->n, N = c->N, from = 0;
    ric_mirror start = RIC_MIRROR_NONE, end = RIC_MIRROR_NONE;
    double period = ric_periodic_period(c), w[2 * n];
    if (c->pure >= 0) {
        start = c->half ? RIC_MIRROR_CENTRE : RIC_MIRROR_REST;
        end = RIC_MIRROR_REST;
        from = (c->pure + (c->half ? N / 2 : 0)) %
               N; /* a centre lies N / 2 half positions from every rest */
    } else if (c->flip >= 0) {
        start = end = RIC_MIRROR_CENTRE;
        from = c->flip;
    }
    ric_status status = ric_shooting_create(m, start, end,
                                            start == RIC_MIRROR_NONE && c->half ? -1 : 1, 1, face,
                                            chain);
    *u = NULL;
    if (status) return status;
    int parts = (c->parts + (*chain)->multiple - 1) / (*chain)->multiple;
    if (parts > RIC_PARTS_MOST) parts = RIC_PARTS_MOST;
    if (parts > 1 && (status = ric_shooting_nodes_divide(*chain, parts))) {
        ric_shooting_free(*chain);
        *chain = NULL;
        return status;
    }
    if (!(*u = ric_calloc((size_t)(*chain)->n_unknown, sizeof **u))) {
        ric_shooting_free(*chain);
        *chain = NULL;
        return ric_no_memory("an orbit");
    }
    memcpy(w, c->w, sizeof w);
    if (from) ric_flight_go(m, 0, -1, from * period / (2 * N), w, w);
    memcpy(*u, start == RIC_MIRROR_CENTRE ? w + n : w, (size_t)(*chain)->n_start * sizeof **u);
    (*u)[(*chain)->n_start] = period / (*chain)->multiple;
    ric_shooting_nodes_spread(*chain, *u);
    return RIC_OK;
}

/* How often a shorter orbit is gone through, up to RIC_COPIES times. */
static int copies_of(const ric_model *m, const ric_periodic *c, double tolerance)
{
    int n = c->n;
    double w[2 * n], period = ric_periodic_period(c), size = 1 + sqrt(ric_dot(2 * n, c->w, c->w));
    for (int q = RIC_COPIES; q > 1; q--) {
        double off = 0;
        ric_flight_go(m, 0, -1, period / q, c->w, w);
        for (int i = 0; i < 2 * n; i++) off = fmax(off, fabs(w[i] - c->w[i]));
        if (off <= tolerance * size) return q;
    }
    return 1;
}

/* ------------------------------------------------------------------- form */

static bool phase_free(const ric_periodic *c)
{
    return c->pure < 0 && c->flip < 0;
}

static ric_periodic *spell(const ric_model *m, int letters, const int *word, const double *tau)
{
    ric_periodic *c = ric_periodic_create(m->n, 2);
    (void)letters, (void)word;
    if (!c) return NULL;
    c->tau[0] = tau[0];
    if (ric_periodic_mark(c, 2)) return c;
    ric_periodic_free(c);
    return NULL;
}

/* Stored orbits start at the mirror point that the chain starts at. */
static void claim(const ric_model *m, const ric_periodic_claim *said, ric_periodic *c)
{
    (void)m;
    c->half = said->symmetric;
    c->flip = said->reversible && said->centre ? 0 : -1;
    c->pure = !said->reversible || !said->rest ? -1 : said->centre;
}

static bool same(const ric_model *m, const ric_periodic *a, const ric_periodic *b, double tolerance)
{
    ric_turn turn;
    if (ric_periodic_match(m, a, b, tolerance, &turn)) return true;
    if (a->N != b->N || !phase_free(a)) return false;
    ric_periodic *image = nearest_phase(m, a, b, tolerance);
    bool found = image;
    ric_periodic_free(image);
    return found;
}

static bool repeats(const ric_model *m, const ric_periodic *c, double tolerance)
{
    return copies_of(m, c, tolerance) > 1;
}

static ric_periodic *nearest(const ric_model *m, const ric_periodic *orbit,
                             const ric_periodic *near, double limit)
{
    return phase_free(orbit) ? nearest_phase(m, orbit, near, limit)
                             : ric_periodic_nearest_event(m, orbit, near, limit);
}

static int find_symmetries(const ric_model *m, ric_periodic *c, double tolerance)
{
    c->half = false;
    c->pure = c->flip = -1;
    int q = copies_of(m, c, tolerance);
    if (!ric_periodic_mark(c, 2 * q)) return 1;
    q = ric_periodic_try_symmetries(m, c, q, tolerance, NULL);
    /* the other reversal a quarter on */
    if (phase_free(c) && find_mirrors(m, c, q, tolerance) && c->half)
        *(c->pure < 0 ? &c->pure : &c->flip) = 1;
    /* orbits with all symmetries start at a centre */
    if (c->half && c->pure == 0) half_mark(m, c);
    return q;
}

static void flights(const ric_periodic *c, double *tau)
{
    tau[0] = ric_periodic_period(c);
}

static void align(const ric_model *m, const ric_periodic *orbit, ric_periodic *near)
{
    ric_periodic_shift(m, orbit, 0, near);
}

const ric_periodic_form ric_periodic_smooth = {
    .from_chain = from_chain,
    .to_chain = to_chain,
    .spell = spell,
    .claim = claim,
    .same = same,
    .repeats = repeats,
    .nearest = nearest,
    .find_symmetries = find_symmetries,
    .flights = flights,
    .divide = ric_periodic_mark,
    .half_mark = half_mark,
    .align = align,
};
