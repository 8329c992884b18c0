#include "loose.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"

/* SLOWEST: scaled frequency at which the scan begins where the window has no lower end */
#define SLOWEST 1e-3
/* INSIDE: part by which it begins above that end, as a start on it may be outside; and by which a
 * contact may be longer than a bound that it reaches */
#define INSIDE 1e-6
#define SCAN 1.01 /* ratio of neighbouring frequencies at which orbits are looked for */
#define TURN 0.01 /* in rad, of the fastest free mode between orbits that are looked at */
#define JUMP 0.5  /* of an orbit between two of them, of its size */
/* How long springs are closed is not known: it is tried from LONG of the time that there is, or the
 * longest that may be, down to SHORT of that in which the fastest mode of the closed structure
 * turns by 1 rad, in ratios of ONE_SPRING, or of TWO_SPRINGS where two of them are closed in turn.
 */
#define SHORT 0.25
#define LONG 0.95
#define ONE_SPRING 1.1
#define TWO_SPRINGS 1.25
#define NO_PIVOT 1e-300 /* of equations without a solution */
/* TWO_EVERY: frequencies, between two springs: orbits in between come from neighbours; MOST_LOOKS:
 * from one frequency to the next: a long period has thousands of turns */
enum { TWO_EVERY = 2, MOST_LOOKS = 32 };
enum { MOST_GUESSES = 200 };
enum { MOST_FLIGHTS = 3 }; /* closed, open, closed */

/* What is looked for, and who takes it. */
typedef struct {
    const ric_limits *limits;
    ric_loose_take take;
    void *data;
} scan;

/* The orbits between two faces at one frequency, which the scan carries upwards. */
typedef struct {
    ric_shooting *chain, *plain; /* plain: equations that are linear in the state */
    int n_spring;                /* of both ends */
    int closed[2];               /* their flights */
    double longest[2];           /* of these, that may be admissible */
    int n, size;
    double *u; /* [size * n_unknown] */
    bool *inside;
    double *J, *r, *A, *first; /* work */
} family;

/* ------------------------------------------------------------------- pairs */

/* The chain from the mirror point of face f to that of face g; of its image f = -1 only from the
 * centre on. */
static ric_status make_chain(const ric_model *m, int f, int g, family *a)
{
    const bool soft[2] = {f >= 0 && m->face[f].spring > 0, m->face[g].spring > 0};
    int face[MOST_FLIGHTS + 1], n = 0;
    if (soft[0] || f < 0) face[n++] = -1;
    if (f >= 0) face[n++] = f;
    face[n++] = g;
    if (soft[1]) face[n++] = -1;
    a->n_spring = 0;
    if (soft[0]) a->closed[a->n_spring++] = 0;
    if (soft[1]) a->closed[a->n_spring++] = n - 2;
    const ric_mirror start = f < 0     ? RIC_MIRROR_CENTRE
                             : soft[0] ? RIC_MIRROR_REST
                                       : RIC_MIRROR_IMPACT;
    ric_status status = ric_shooting_create(m, start, soft[1] ? RIC_MIRROR_REST : RIC_MIRROR_IMPACT,
                                            1, n - 1, face, &a->chain);
    if (!status && soft[0]) ric_shooting_close(a->chain, (uint64_t)1 << f);
    return status;
}

static void release(family *a)
{
    ric_shooting_free(a->chain);
    ric_shooting_free(a->plain);
    free(a->u);
    free(a->inside);
    free(a->J);
    *a = (family){0};
}

/* How long a spring that a loose mass meets may be closed from the middle of the contact on. Where
 * all modes then have a frequency its force has no mean, and a sum of vibrations without mean keeps
 * its sign for no longer than half a period of each in turn: taken at all instants that shifts by
 * some of these halves lead to, it adds up to nothing. */
static ric_status bound(family *a)
{
    const ric_model *m = a->chain->model;
    for (int i = 0; i < a->n_spring; i++) {
        const ric_regime *phase;
        ric_status status = ric_regime_get(m, a->chain->closed[a->closed[i]], &phase);
        if (status) return status;
        double halves = 0;
        for (int k = 0; k < m->n; k++) halves += RIC_PI / 2 / phase->omega[k];
        a->longest[i] = (1 + INSIDE) * halves;
    }
    return RIC_OK;
}

static ric_status create(const ric_model *m, int f, int g, family *a)
{
    *a = (family){0};
    ric_status status = make_chain(m, f, g, a);
    if (status) return status;
    a->plain = ric_shooting_copy(a->chain);
    if (!a->plain) return ric_no_memory("orbits of a loose mass");
    a->plain->plain = true;
    const size_t rows = (size_t)ric_shooting_rows(a->plain), wide = (size_t)a->plain->n_unknown;
    a->J = ric_malloc((rows * wide + rows + wide * wide + 3 * wide) * sizeof *a->J);
    if (!a->J) return ric_no_memory("orbits of a loose mass");
    a->r = a->J + rows * wide;
    a->A = a->r + rows;
    a->first = a->A + wide * wide;
    return bound(a);
}

/* ------------------------------------------------------------------ orbits */

/* The state, before the times of u, that solves the equations best: they are linear in it, as many
 * more as springs are closed. */
static bool solve_state(family *a, double *u)
{
    const int n = a->plain->n_start, wide = a->plain->n_unknown;
    memset(u, 0, (size_t)n * sizeof *u);
    const int rows = ric_shooting_jacobian(a->plain, u, a->J);
    if (rows == 0) return false;
    ric_shooting_residuals(a->plain, u, a->r);
    memset(a->A, 0, (size_t)(n * n) * sizeof *a->A);
    for (int k = 0; k < rows; k++)
        for (int i = 0; i < n; i++) {
            const double x = a->J[k * wide + i];
            u[i] -= x * a->r[k];
            for (int j = 0; j < n; j++) a->A[i * n + j] += x * a->J[k * wide + j];
        }
    return ric_dense_solve(n, 1, a->A, u, NO_PIVOT);
}

static double time_of(const family *a, const double *u)
{
    double sum = 0;
    for (int k = 0; k < a->chain->n_flight; k++) sum += u[a->chain->n_start + k];
    return sum;
}

/* Newton's method from u to the orbit whose flights last `time` together. */
static bool correct(family *a, double *u, double time)
{
    const int n = a->chain->n_start, wide = a->chain->n_unknown;
    double *normal = a->first + wide, *du = normal + wide;
    int iterations;
    memset(normal, 0, (size_t)wide * sizeof *normal);
    for (int k = n; k < wide; k++) normal[k] = 1;
    memcpy(a->first, u, (size_t)wide * sizeof *u);
    if (!ric_continuation_correct(a->chain, u, a->first, normal, time - time_of(a, u), du,
                                  &iterations))
        return false;
    for (int k = n; k < wide; k++)
        if (!(u[k] > 0)) return false;
    for (int i = 0; i < a->n_spring; i++)
        if (u[n + a->closed[i]] > a->longest[i]) return false;
    return true;
}

static bool is_known(const family *a, int count, const double *u)
{
    const int wide = a->chain->n_unknown;
    for (int i = 0; i < count; i++) {
        double off = 0, size = 1;
        for (int j = 0; j < wide; j++) {
            off = fmax(off, fabs(u[j] - a->u[i * wide + j]));
            size = fmax(size, fabs(u[j]));
        }
        if (off < RIC_SAME_LOCATED * size) return true;
    }
    return false;
}

static ric_status keep(family *a, const double *u)
{
    const size_t wide = (size_t)a->chain->n_unknown;
    if (a->n == a->size) {
        const size_t size = 2 * (size_t)a->size + 4;
        double *more = ric_realloc(a->u, size * wide * sizeof *more);
        if (more) a->u = more;
        bool *inside = more ? ric_realloc(a->inside, size * sizeof *inside) : NULL;
        if (!inside) return ric_no_memory("orbits of a loose mass");
        a->inside = inside;
        a->size = (int)size;
    }
    memcpy(a->u + (size_t)a->n * wide, u, wide * sizeof *u);
    a->inside[a->n++] = false;
    return RIC_OK;
}

/* Whether what `correct` has found is far from where it came from: at energies beyond all bounds,
 * as where a mode resonates, an orbit goes over to another branch. */
static bool has_jumped(const family *a, const double *u)
{
    double off = 0, size = 0;
    for (int k = 0; k < a->chain->n_unknown; k++) {
        off = fmax(off, fabs(u[k] - a->first[k]));
        size = fmax(size, fabs(u[k]));
    }
    return off > JUMP * size;
}

/* Orbits `from` on, at this time; those that are lost, or come together, go. */
static void go_on(family *a, int from, double time)
{
    const int wide = a->chain->n_unknown;
    int count = from;
    for (int i = from; i < a->n; i++) {
        double *u = a->u + count * wide;
        memmove(u, a->u + i * wide, (size_t)wide * sizeof *u);
        a->inside[count] = a->inside[i];
        if (!correct(a, u, time) || is_known(a, count, u)) continue;
        a->inside[count++] &= !has_jumped(a, u);
    }
    a->n = count;
}

static ric_status attempt(family *a, double time, const double *closed, double *u)
{
    const int n = a->chain->n_start;
    double left = time;
    for (int i = 0; i < a->n_spring; i++) left -= closed[i];
    if (left < (1 - LONG) * time) return RIC_OK;
    for (int k = 0; k < a->chain->n_flight; k++) u[n + k] = left;
    for (int i = 0; i < a->n_spring; i++) u[n + a->closed[i]] = closed[i];
    if (!solve_state(a, u) || !correct(a, u, time) || is_known(a, a->n, u)) return RIC_OK;
    return keep(a, u);
}

/* How long spring i may be closed, of flights that last `time` together: quarter turns of the modes
 * that it makes, what a loose mass that strikes it alone takes, and lengths in equal ratios. */
static int guess(const family *a, int i, double time, double *out)
{
    const ric_model *m = a->chain->model;
    const double ratio = a->n_spring > 1 ? TWO_SPRINGS : ONE_SPRING;
    const double longest = fmin(a->longest[i], LONG * time);
    const ric_regime *phase;
    int count = 0;
    for (double t = longest; count < MOST_GUESSES && t > SHORT / a->chain->fastest; t /= ratio)
        out[count++] = t;
    if (ric_regime_get(m, a->chain->closed[a->closed[i]], &phase)) return count;
    for (int k = 0; k < m->n && count < MOST_GUESSES; k++)
        if (phase->omega[k] * longest > RIC_PI / 2) out[count++] = RIC_PI / 2 / phase->omega[k];
    return count;
}

/* Orbits whose flights last `time` together, from all guesses of how long springs are closed. */
static ric_status attempt_all(family *a, double time, double *u)
{
    double times[2][MOST_GUESSES] = {{0}}, closed[2] = {0};
    int count[2] = {1, 1};
    ric_status status = RIC_OK;
    for (int i = 0; i < a->n_spring; i++) count[i] = guess(a, i, time, times[i]);
    for (int i = 0; i < count[0]; i++)
        for (int j = 0; j < count[1] && !status; j++) {
            closed[0] = times[0][i];
            closed[1] = times[1][j];
            status = attempt(a, time, closed, u);
        }
    return status;
}

/* -------------------------------------------------------------------- scan */

/* What is quick to tell first: between a loose mass and stiff springs the reach of the long flights
 * takes a thousand times as long. */
static bool is_admissible(family *a, const ric_limits *limits, const double *u)
{
    const ric_shooting *c = a->chain;
    ric_shooting_fly(a->chain, u);
    const double energy = ric_shooting_energy(c);
    return energy > limits->energy[0] && energy < limits->energy[1] &&
           c->residual < RIC_SAME_SOLVED && ric_continuation_approach(c, false) > 0 &&
           ric_continuation_approach(c, true) > 0 && ric_reach(c, u, NULL) < 1;
}

/* From orbits `from` on, those that become admissible at this period are given to start from. */
static ric_status look(family *a, const scan *s, int from)
{
    const int wide = a->chain->n_unknown;
    ric_status status = RIC_OK;
    for (int k = from; !status && k < a->n; k++) {
        const bool good = is_admissible(a, s->limits, a->u + k * wide);
        if (good && !a->inside[k]) status = s->take(s->data, a->chain, a->u + k * wide);
        a->inside[k] = good;
    }
    return status;
}

/* Orbits `from` on, from one time to another one and looked at on the way, in steps in which the
 * fastest mode turns little: stretches are as short as its motion makes them. Where it turns often
 * in a period, shorter ones are not seen. */
static ric_status go_to(family *a, const scan *s, int from, const double time[2])
{
    const double turn = a->chain->model->omega[a->chain->model->n - 1] * fabs(time[1] - time[0]);
    const int steps = 1 + (int)fmin(turn / TURN, MOST_LOOKS - 1);
    ric_status status = RIC_OK;
    for (int i = 1; i <= steps && !status && a->n > from; i++) {
        go_on(a, from, i < steps ? time[0] + i * (time[1] - time[0]) / steps : time[1]);
        status = look(a, s, from);
    }
    return status;
}

/* New orbits at time[1], which may be admissible back to time[0] only, where they were not yet
 * looked for; they stay as they are at time[1]. */
static ric_status find_more(family *a, const scan *s, const double time[2], double *u)
{
    const int before = a->n, wide = a->chain->n_unknown;
    ric_status status = attempt_all(a, time[1], u);
    if (!status) status = look(a, s, before);
    const size_t found = (size_t)(a->n - before), size = found * (size_t)wide;
    if (status || found == 0) return status;
    double *kept = ric_malloc(size * sizeof *kept + found * sizeof *a->inside);
    if (!kept) return ric_no_memory("orbits of a loose mass");
    bool *inside = (bool *)(kept + size);
    memcpy(kept, a->u + before * wide, size * sizeof *kept);
    memcpy(inside, a->inside + before, found * sizeof *inside);
    status = go_to(a, s, before, (double[]){time[1], time[0]});
    memcpy(a->u + before * wide, kept, size * sizeof *kept);
    memcpy(a->inside + before, inside, found * sizeof *inside);
    a->n = before + (int)found;
    free(kept);
    return status;
}

static ric_status scan_family(family *a, const scan *s)
{
    const double *period = s->limits->period;
    const double low = isfinite(period[1]) ? RIC_TWO_PI / period[1] : SLOWEST;
    const int every = a->n_spring > 1 ? TWO_EVERY : 1;
    double omega = low * (1 + INSIDE), before = 0, last = 0;
    double *u = ric_malloc((size_t)a->chain->n_unknown * sizeof *u);
    ric_status status = u ? RIC_OK : ric_no_memory("an orbit of a loose mass");
    for (int i = 0; !status && omega < RIC_TWO_PI / period[0]; i++, omega *= SCAN) {
        const double time = RIC_TWO_PI / omega / a->chain->multiple;
        if (i > 0) status = go_to(a, s, 0, (double[]){last, time});
        last = time;
        if (status || i % every) continue;
        status = find_more(a, s, (double[]){i ? before : time, time}, u);
        before = time;
    }
    free(u);
    return status;
}

ric_status ric_loose_scan(const ric_model *m, const ric_limits *limits, ric_loose_take take,
                          void *data)
{
    ric_status status = RIC_OK;
    for (int f = 0; f < m->n_face; f++)
        for (int g = f + 1; g < m->n_face && !status; g++) {
            family a;
            if (!ric_model_opposite(m, f, g)) continue;
            status = create(m, m->face[f].mirror == g ? -1 : f, m->face[f].mirror == g ? f : g, &a);
            if (!status) status = scan_family(&a, &(scan){limits, take, data});
            release(&a);
        }
    return status;
}
