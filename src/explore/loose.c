#include "loose.h"
#include "loose_zeros.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"

/* SLOWEST: scaled frequency at which the scan begins where the window has no lower end */
#define SLOWEST 1e-3
/* INSIDE: part by which it begins above that end, as a start on it may be outside; and by which a
 * contact may be longer than a bound that it reaches */
#define INSIDE 1e-6
/* START: of the size of an orbit, the first step along its curve; BEND: by what a step leaves the
 * cubic of the one before, one between both ends is off by a 64th of that; STRAIGHT: so many times
 * that by what it leaves a straight line; SHORTEST, LONGEST: steps, of the size */
#define START 0.01
#define BEND 3e-3
#define STRAIGHT 3
#define GROWTH 2.0
#define SHRINK 4.0
#define SHORTEST 1e-6
#define LONGEST 0.5
#define WIDEST 1.0      /* in rad, of the fastest free mode, a step */
#define TURN 0.01       /* the same between two looks */
#define NEAR 1e-5       /* step of Newton's method, of the size, that leaves rounding */
#define FALLING 0.5     /* of the step before, in Newton's method */
#define BEYOND 100      /* times the largest energy, from where a curve is not followed */
#define NO_PIVOT 1e-300 /* of equations without a solution */
/* LOOKS, MOST_LOOKS: in a step; MOST_STEPS: along a curve; SAMPLES: of a contact */
enum { LOOKS = 16, MOST_LOOKS = 100, MOST_STEPS = 20000, SAMPLES = 16 };
/* of neighbouring frequencies at which orbits are looked for, by the number of springs */
static const double scan_ratio[] = {1.001, 1.005, 1.02};
enum { MOST_FLIGHTS = 3 }; /* closed, open, closed */

/* What is looked for, and who takes it. */
typedef struct {
    const ric_limits *limits;
    ric_loose_take take;
    void *data;
} scan;

/* What an orbit has to spare, of which a start has all above 0: energy and period within the
 * window, speeds of impacts and of springs, how far springs are pressed, and gaps, NAN where
 * something else is not. */
enum { ABOVE, BELOW, LONGER, SHORTER, STRIKES, CLOSES, PUSHES, OPEN, N_MARGIN };

/* Orbits at one time, told apart by how long springs are closed. */
typedef struct {
    double time;
    int n, size;
    double (*closed)[2];
} level;

/* The orbits between two faces. */
typedef struct {
    ric_shooting *chain, *plain; /* plain: equations that are linear in the state */
    ric_loose_zeros *zeros;      /* NULL without springs */
    int n_spring;                /* of both ends */
    int closed[2];               /* their flights */
    double longest[2];           /* of these, that may be admissible */
    int n_level;
    level *levels;             /* from the longest time down */
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
    ric_loose_zeros_free(a->zeros);
    for (int i = 0; i < a->n_level; i++) free(a->levels[i].closed);
    free(a->levels);
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

/* Whether no flight goes backwards, and no contact lasts too long. */
static bool is_possible(const family *a, const double *u)
{
    const double *tau = u + a->chain->n_start;
    for (int k = 0; k < a->chain->n_flight; k++)
        if (!(tau[k] > 0)) return false;
    for (int i = 0; i < a->n_spring; i++)
        if (tau[a->closed[i]] > a->longest[i]) return false;
    return true;
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
    return is_possible(a, u);
}

/* The same, to NEAR of the size and in few steps, in the plane normal . u = target; behind u
 * [2 n_unknown] the direction of the curve, of which normal . that is 1. */
static bool settle(family *a, const double *normal, double target, double *u)
{
    const int wide = a->chain->n_unknown;
    double *du = a->first + wide, *slope = u + wide, last = HUGE_VAL;
    memcpy(a->first, u, (size_t)wide * sizeof *u);
    for (;;) {
        ric_shooting_evaluate(a->chain, u);
        if (a->chain->singular) return false;
        ric_shooting_steps(a->chain, du, slope);
        const double across = ric_dot(wide, normal, slope);
        const double off = ric_dot(wide, normal, u) + ric_dot(wide, normal, du) - target;
        double moved = 0, size = 0;
        if (!(fabs(across) > RIC_RANK)) return false;
        for (int k = 0; k < wide; k++) {
            slope[k] /= across;
            du[k] -= off * slope[k];
            u[k] += du[k];
            moved = fmax(moved, fabs(du[k]));
            if (k < a->chain->n_start) size = fmax(size, fabs(u[k]));
        }
        if (!(moved < FALLING * last)) return false;
        if (moved <= NEAR * size) return true;
        last = moved;
    }
}

static void closed_of(const family *a, const double *u, double out[2])
{
    for (int k = 0; k < 2; k++) out[k] = k < a->n_spring ? u[a->chain->n_start + a->closed[k]] : 0;
}

static bool is_known(const level *l, const double closed[2])
{
    for (int i = 0; i < l->n; i++) {
        bool same = true;
        for (int k = 0; k < 2; k++)
            same &= fabs(closed[k] - l->closed[i][k]) <= RIC_SAME_LOCATED * l->time;
        if (same) return true;
    }
    return false;
}

static ric_status note(level *l, const double closed[2])
{
    if (l->n == l->size) {
        double(*more)[2] = ric_realloc(l->closed, (size_t)(2 * l->size + 4) * sizeof *more);
        if (!more) return ric_no_memory("orbits of a loose mass");
        l->closed = more;
        l->size = 2 * l->size + 4;
    }
    memcpy(l->closed[l->n++], closed, sizeof *l->closed);
    return RIC_OK;
}

/* ------------------------------------------------------------------- looks */

/* The least that a spring is pressed at SAMPLES times of its contact, of the most, 1 without. */
static double pushes(const family *a)
{
    const ric_shooting *c = a->chain;
    const ric_model *m = c->model;
    const int n = c->n;
    double least = 1, z[2 * n];
    for (int i = 0; i < a->n_spring; i++) {
        const int k = a->closed[i], end = k > 0;
        const ric_face *face = &m->face[c->face[end ? k : k + 1]];
        const ric_regime *phase;
        double size = 0, low = HUGE_VAL;
        if (ric_regime_get(m, c->closed[k], &phase)) return -1;
        ric_regime_enter(phase, c->w + 2 * n * (k + end), z);
        for (int j = 1; j <= SAMPLES; j++) {
            double sum = phase->rest[face->contact] - face->gap;
            for (int l = 0; l < n; l++)
                sum += phase->G[face->contact * n + l] * z[l] *
                       cos(phase->omega[l] * c->tau[k] * (SAMPLES - j) / SAMPLES);
            low = fmin(low, face->side * sum);
            size = fmax(size, fabs(sum));
        }
        least = fmin(least, low / size);
    }
    return least;
}

/* What is quick to tell first: between a loose mass and stiff springs the reach of the long flights
 * takes a thousand times as long. */
static void measure(family *a, const scan *s, const double *u, double margin[N_MARGIN])
{
    const ric_shooting *c = a->chain;
    ric_shooting_fly(a->chain, u);
    const double energy = ric_shooting_energy(c), period = ric_shooting_time(c, u);
    margin[ABOVE] = energy - s->limits->energy[0];
    margin[BELOW] = s->limits->energy[1] - energy;
    margin[LONGER] = period - s->limits->period[0];
    margin[SHORTER] = fmin(s->limits->period[1], RIC_TWO_PI / SLOWEST) - period;
    margin[STRIKES] = ric_continuation_approach(c, false);
    margin[CLOSES] = ric_continuation_approach(c, true);
    margin[PUSHES] = NAN;
    bool good = true;
    for (int i = 0; i < PUSHES; i++) good &= margin[i] > 0;
    if (good) margin[PUSHES] = pushes(a);
    for (int i = 0; i < OPEN; i++) good &= margin[i] > 0;
    margin[OPEN] = good ? 1 - ric_reach(c, u, NULL) : NAN;
}

/* Whether an interval is nowhere admissible (-1) or throughout (1) by margins at its ends and in
 * its middle, from which they stay away by more than they change; 0: it is to be looked at. */
static int decide(double margin[3][N_MARGIN])
{
    int all = 1;
    for (int i = 0; i < N_MARGIN; i++) {
        const double x = margin[0][i], y = margin[1][i], z = margin[2][i];
        const double low = fmin(x, fmin(y, z)), high = fmax(x, fmax(y, z));
        if (isnan(x + y + z) || !(low > high - low)) all = 0;
        if (!isnan(x + y + z) && high < low - high) return -1;
    }
    return all;
}

/* The cubic through u and v [2 n], orbits with their slopes, at the part x of the way h from one to
 * the other. */
static void between(int n, const double *u, const double *v, double h, double x, double *out)
{
    const double y = 1 - x;
    for (int j = 0; j < n; j++)
        out[j] = y * y * ((1 + 2 * x) * u[j] + x * h * u[n + j]) +
                 x * x * ((1 + 2 * y) * v[j] - y * h * v[n + j]);
}

/* Gives an orbit to start from; *inside: it is admissible. */
static ric_status offer(family *a, const scan *s, const double *u, bool *inside)
{
    double margin[N_MARGIN];
    measure(a, s, u, margin);
    if (ric_halted()) return ric_trust(RIC_OK);
    *inside = margin[OPEN] > 0 && a->chain->residual < RIC_SAME_SOLVED && is_possible(a, u);
    return *inside ? s->take(s->data, a->chain, u) : RIC_OK;
}

/* The same of the orbit nearest to u. */
static ric_status offer_near(family *a, const scan *s, const double *u, bool *inside)
{
    const int wide = a->chain->n_unknown;
    double v[wide], du[wide];
    int iterations;
    memcpy(v, u, (size_t)wide * sizeof *v);
    *inside = false;
    if (!ric_continuation_correct(a->chain, v, NULL, NULL, 0, du, &iterations)) return RIC_OK;
    return offer(a, s, v, inside);
}

/* Whether the last orbit that was looked at is admissible, and, if it is the first one, that one:
 * the next one is farther from where the stretch begins, beside which a branch has no room. */
typedef struct {
    bool inside, waits;
    double step; /* from u to v */
    double *first;
} sight;

/* The next orbit. */
static ric_status see(family *a, const scan *s, const double *u, bool open, sight *at)
{
    const bool waits = at->waits;
    at->waits = open && !at->inside;
    if (at->waits) memcpy(at->first, u, (size_t)a->chain->n_unknown * sizeof *u);
    at->inside = open;
    return waits ? offer_near(a, s, open ? u : at->first, &at->inside) : RIC_OK;
}

/* One step of a curve, from u to v, both with slopes, and the margins at its ends. Where it becomes
 * admissible an orbit is given to start from. */
static ric_status look(family *a, const scan *s, const double *u, const double *v,
                       double margin[3][N_MARGIN], sight *at)
{
    const int wide = a->chain->n_unknown;
    double w[wide], here[N_MARGIN];
    ric_status status = RIC_OK;
    between(wide, u, v, at->step, 0.5, w);
    measure(a, s, w, margin[1]);
    const int decided = decide(margin);
    const double turn = a->chain->model->omega[a->chain->model->n - 1] *
                        fabs(time_of(a, v) - time_of(a, u));
    const int looks = decided < 0 || (decided > 0 && at->inside)
                          ? 1
                          : (int)fmax(LOOKS, fmin(turn / TURN, MOST_LOOKS));
    for (int i = 1; i < looks && !status; i++) {
        between(wide, u, v, at->step, (double)i / looks, w);
        measure(a, s, w, here);
        status = see(a, s, w, here[OPEN] > 0, at);
    }
    return status ? status : see(a, s, v, margin[2][OPEN] > 0, at);
}

/* ------------------------------------------------------------------ curves */

/* Where a curve passes the times at which orbits are looked for, from u to v. *been: it was there
 * before. */
static ric_status cross(family *a, const double *u, const double *v, double h, bool *been)
{
    const int wide = a->chain->n_unknown;
    const double from = time_of(a, u), to = time_of(a, v);
    double w[2 * wide], normal[wide], closed[2];
    ric_status status = RIC_OK;
    for (int j = 0; j < wide; j++) normal[j] = j >= a->chain->n_start;
    for (int i = 0; i < a->n_level && !status; i++) {
        level *l = &a->levels[i];
        if (!((from < l->time && to >= l->time) || (from > l->time && to <= l->time))) continue;
        ric_root root = ric_root_between(0, from - l->time, 1, to - l->time, NEAR);
        while (ric_root_next(&root)) {
            between(wide, u, v, h, root.x, w);
            root.f = time_of(a, w) - l->time;
        }
        between(wide, u, v, h, root.x, w);
        if (!settle(a, normal, l->time, w)) continue;
        closed_of(a, w, closed);
        *been |= is_known(l, closed);
        if (!*been) status = note(l, closed);
    }
    return status;
}

/* A place on a curve: unknowns u and direction of unit length, the same with the direction as the
 * step before has it, and that step: from, back, 0: none. */
typedef struct {
    double *u, *same, *from, back;
} place;

/* The next orbit v, after a step h; *off: how far it is from what was expected, of its size. */
static bool advance(family *a, const place *at, double h, double *v, double *off)
{
    const int wide = a->chain->n_unknown;
    const double *t = at->u + wide;
    double far = 0, size = 0;
    if (at->back > 0) {
        const double turned = ric_dot(wide, t, at->same + wide);
        between(wide, at->from, at->same, at->back, 1 + h / turned / at->back, v);
    } else
        for (int j = 0; j < wide; j++) v[j] = at->u[j] + h * t[j];
    double target = h + ric_dot(wide, t, at->u);
    if (!settle(a, t, target, v)) return false;
    for (int j = 0; j < wide; j++) {
        far = fmax(far, fabs(v[j] - a->first[j]));
        if (j < a->chain->n_start) size = fmax(size, fabs(v[j]));
    }
    *off = far / size;
    return true;
}

static void go_on(int wide, place *at, const double *v, double h)
{
    const size_t both = 2 * (size_t)wide * sizeof *v;
    const double length = sqrt(ric_dot(wide, v + wide, v + wide));
    memcpy(at->from, at->u, both);
    memcpy(at->same, v, both);
    memcpy(at->u, v, both);
    for (int j = 0; j < wide; j++) at->u[wide + j] /= length;
    at->back = h;
}

static double size_of(int wide, const double *u)
{
    return sqrt(ric_dot(wide, u, u));
}

/* Follows the curve from u one way, looks at its orbits and notes where it passes, until it leaves
 * the window, or comes to where it has been. */
static ric_status follow(family *a, const scan *s, const double *start, int way, bool inside)
{
    const int wide = a->chain->n_unknown;
    const size_t both = 2 * (size_t)wide;
    const double most = WIDEST / a->chain->model->omega[a->chain->model->n - 1];
    double room[5 * both], margin[3][N_MARGIN], off = 0, *v = room + 3 * both;
    place at = {room, room + both, room + 2 * both, 0};
    sight sees = {inside, false, 0, room + 4 * both};
    bool been = false;
    ric_status status = RIC_OK;
    memcpy(at.u, start, both * sizeof *room);
    for (int j = 0; j < wide; j++) at.u[wide + j] *= way;
    double h = START * size_of(wide, at.u);
    measure(a, s, at.u, margin[0]);
    for (int i = 0; i < MOST_STEPS && !status && !been; i++) {
        if (ric_halted()) return ric_trust(RIC_OK);
        const double size = size_of(wide, at.u), bend = at.back > 0 ? BEND : STRAIGHT * BEND;
        h = fmin(h, LONGEST * size);
        if (h < SHORTEST * size) break;
        const bool found = advance(a, &at, h, v, &off);
        const double turn = fabs(time_of(a, v) - time_of(a, at.u));
        if (!found || off > bend || turn > 2 * most) {
            h /= SHRINK;
            continue;
        }
        measure(a, s, v, margin[2]);
        sees.step = h;
        status = look(a, s, at.u, v, margin, &sees);
        if (!status) status = cross(a, at.u, v, h, &been);
        if (!is_possible(a, v) || margin[2][LONGER] < 0 || margin[2][SHORTER] < 0 ||
            margin[2][BELOW] < (1 - BEYOND) * s->limits->energy[1])
            break;
        go_on(wide, &at, v, h);
        memcpy(margin[0], margin[2], sizeof margin[0]);
        h *= fmin(GROWTH, fmin(sqrt(sqrt(bend / 2 / fmax(off, NO_PIVOT))), most / turn));
    }
    return status ? status : see(a, s, at.u, false, &sees);
}

/* -------------------------------------------------------------------- scan */

/* What boxes are tried with. */
typedef struct {
    family *a;
    const scan *s;
    level *at;
} trial;

/* With these times of contact the orbit nearest to them, and its curve, unless it is known. */
static ric_status attempt(const trial *t, const double *closed)
{
    family *a = t->a;
    const int n = a->chain->n_start, wide = a->chain->n_unknown;
    double u[2 * wide], left = t->at->time, own[2];
    bool inside;
    for (int i = 0; i < a->n_spring; i++) left -= closed[i];
    for (int k = 0; k < a->chain->n_flight; k++) u[n + k] = left;
    for (int i = 0; i < a->n_spring; i++) u[n + a->closed[i]] = closed[i];
    if (!solve_state(a, u) || !correct(a, u, t->at->time)) return RIC_OK;
    closed_of(a, u, own);
    if (is_known(t->at, own)) return RIC_OK;
    ric_status status = note(t->at, own);
    if (!status) status = offer(a, t->s, u, &inside);
    if (status) return status;
    ric_shooting_evaluate(a->chain, u);
    ric_shooting_step(a->chain, false, 1, u + wide);
    for (int way = -1; way <= 1 && !status; way += 2) status = follow(a, t->s, u, way, inside);
    return status;
}

static bool knows_within(const trial *t, const double low[2], const double high[2])
{
    for (int i = 0; i < t->at->n; i++) {
        const double *closed = t->at->closed[i];
        bool in = true;
        for (int k = 0; k < t->a->n_spring; k++) in &= closed[k] >= low[k] && closed[k] <= high[k];
        if (in) return true;
    }
    return false;
}

static ric_status try_box(void *data, const double low[2], const double high[2],
                          const double near[2], bool *found)
{
    const trial *t = data;
    *found = knows_within(t, low, high);
    if (*found) return RIC_OK;
    const ric_status status = attempt(t, near);
    *found = knows_within(t, low, high);
    return status;
}

static ric_status make_levels(family *a, const scan *s)
{
    const double *period = s->limits->period;
    const double low = isfinite(period[1]) ? RIC_TWO_PI / period[1] : SLOWEST;
    const double high = RIC_TWO_PI / period[0], ratio = scan_ratio[a->n_spring];
    int count = 0;
    for (double omega = low * (1 + INSIDE); omega < high; omega *= ratio) count++;
    a->levels = ric_calloc((size_t)count + 1, sizeof *a->levels);
    if (!a->levels) return ric_no_memory("orbits of a loose mass");
    for (double omega = low * (1 + INSIDE); omega < high; omega *= ratio)
        a->levels[a->n_level++].time = RIC_TWO_PI / omega / a->chain->multiple;
    return RIC_OK;
}

static ric_status scan_family(family *a, const scan *s, int f, int g)
{
    ric_status status = make_levels(a, s);
    double longest[2] = {0}; /* what is loose in a contact, too, sets no bound */
    for (int i = 0; i < a->n_spring && a->n_level > 0; i++)
        longest[i] = fmin(a->longest[i], a->levels[0].time);
    if (!status && a->n_spring > 0 && a->n_level > 0)
        status = ric_loose_zeros_create(a->chain->model, f, g, longest, &a->zeros);
    for (int i = 0; i < a->n_level && !status; i++) {
        trial t = {a, s, &a->levels[i]};
        if (a->n_spring > 0) status = ric_loose_zeros_find(a->zeros, t.at->time, try_box, &t);
        else if (t.at->n == 0) status = attempt(&t, NULL);
    }
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
            const bool image = m->face[f].mirror == g;
            status = create(m, image ? -1 : f, image ? f : g, &a);
            if (!status)
                status = scan_family(&a, &(scan){limits, take, data}, image ? -1 : f,
                                     image ? f : g);
            release(&a);
        }
    return status;
}
