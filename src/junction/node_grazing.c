/* Grazings: which impacts of a located orbit are touches, and the motion that is left without them;
 * arrivals at linear modes and at their mixtures (docs/theory.md sections 7 and 8). */
#include "node.h"

#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "branch/room.h"
#include "grazing_words.h"
#include "model/room.h"
#include "node_solve.h"

/* Scaled: an impact below this speed at a located event is a touch that was kept. Newton's method
 * leaves 1e-12 of it; what is faster is an impact, and without it the motion is another one. Where
 * all impacts end at once an orbit is located to less, and what is slower than HARDLY is a touch
 * there. */
#define NO_SPEED 1e-10
#define HARDLY 1e-7
#define NO_TIME 1e-7 /* scaled: a contact that lasts no longer is a touch of a spring */
#define BEYOND 1e-9  /* of its size: what is open by more does not come back */
/* KICK: of the speed of the impacts that are left out: what is open by as much is what they make up
 * for */
#define KICK 1e-2
#define AT_END 1e-10 /* of its energy: the end of a branch is located to less */
/* NEAR_END: the same where the gap opens slowly along it, if the equations with the touch as an
 * event are REGULAR, their least pivot: then they have the place */
#define NEAR_END 1e-8
#define REGULAR 1e-3

/* Of a stop: how fast it is met at event i. */
static double impact_speed(const ric_model *m, const ric_periodic *c, const double *W, int i)
{
    const ric_face *f = &m->face[c->face[i]];
    return -f->side * ric_dot(c->n, f->c, W + 2 * c->n * i + c->n);
}

/* The same [N] of all events, allocated; -1 at springs. NULL: no memory. */
static double *stop_speeds(const ric_model *m, const ric_periodic *c)
{
    double *W = ric_calloc((size_t)c->N * 2 * (size_t)c->n + 1, sizeof *W),
           *speed = W ? ric_calloc((size_t)c->N + 1, sizeof *speed) : NULL;
    if (speed) ric_periodic_states(m, c, W);
    for (int i = 0; i < c->N && speed; i++)
        speed[i] = m->face[c->face[i]].spring > 0 ? -1 : fabs(impact_speed(m, c, W, i));
    free(W);
    return speed;
}

static bool list_touches(const ric_model *m, ric_node *node, double slow)
{
    const ric_periodic *c = node->cycle;
    node->n_touch = 0;
    node->refusal = RIC_REFUSAL_NONE;
    double *speed = stop_speeds(m, c);
    bool fits = true;
    if (!speed) return false;
    for (int i = 0; i < c->N; i++) {
        const bool spring = speed[i] < 0, pair = c->face[(i + 1) % c->N] == c->face[i];
        if (spring ? !pair || fabs(c->tau[i]) > NO_TIME : speed[i] > slow) continue;
        if (node->n_touch < RIC_MAX_TOUCHES) node->touch[node->n_touch++] = i;
        else fits = false;
    }
    free(speed);
    if (!fits || node->n_touch * node->multiple > RIC_MAX_TOUCHES)
        node->refusal = RIC_REFUSAL_TOUCHES;
    return true;
}

/* The equations of an orbit, evaluated there. NULL: no memory. */
static ric_shooting *equations_of(const ric_model *m, const ric_periodic *c)
{
    ric_shooting *chain = NULL;
    double *u = NULL;
    const bool made = !ric_periodic_to_chain(m, c, &chain, &u);
    if (made) ric_shooting_evaluate(chain, u);
    else ric_shooting_free(chain);
    free(u);
    return made ? chain : NULL;
}

/* What rounding leaves of the speeds of an orbit: a regular one has them to the last digits. */
static double lost_speed(const ric_model *m, const ric_periodic *c)
{
    ric_shooting *q = equations_of(m, c);
    const double lost = q ? 4 * ric_continuation_tolerance(q) * q->scale * (1 + 1 / q->smallest)
                          : 0;
    ric_shooting_free(q);
    return lost;
}

/* The largest speed at a touch of a stop; *stops: whether all touches are. */
static double fastest_touch(const ric_model *m, const ric_node *node, bool *stops)
{
    double *speed = stop_speeds(m, node->cycle), most = 0;
    *stops = speed;
    for (int i = 0; i < node->n_touch && speed; i++) {
        most = fmax(most, speed[node->touch[i]]);
        *stops &= !(speed[node->touch[i]] < 0);
    }
    free(speed);
    return most;
}

/* Whether the orbit with one touch and others read off is that of a node of which touches have the
 * speed `most`. Where rounding leaves as much it is; of an orbit that is known better a slow impact
 * is an impact, unless the branch ends nearer to the other orbit, at the energy `end`: stops that
 * are images of each other but for 1e-9 are not touched at once, and one of two touches becomes
 * such an impact. */
static bool is_sharper(const ric_model *m, const ric_node *node, double most,
                       const ric_periodic *full, double end)
{
    const double off = fabs(ric_periodic_energy(m, full) - end),
                 other = fabs(ric_periodic_energy(m, node->cycle) - end);
    return most <= lost_speed(m, node->cycle) || (off <= NEAR_END * end && off < other / 2);
}

/* The events of the cycle without its touches but for the first and its images. Whether any is left
 * out. */
static bool keep_one_touch(const ric_node *node, bool *keep)
{
    const ric_periodic *c = node->cycle;
    const int N = c->N;
    int kept = 0;
    for (int i = 0; i < N; i++) keep[i] = true;
    for (int i = 1; i < node->n_touch; i++) keep[node->touch[i]] = false;
    for (bool more = true; more;) {
        more = false;
        for (int i = 0; i < N; i++) {
            const int image[] = {c->half ? (i + N / 2) % N : i,
                                 c->pure < 0 ? i : (c->pure - i + 2 * N) % N,
                                 c->flip < 0 ? i : (c->flip - i + 2 * N) % N};
            for (int k = 0; k < 3 && keep[i]; k++)
                if (!keep[image[k]]) more = keep[image[k]] = true;
        }
    }
    for (int i = 0; i < N; i++) kept += keep[i];
    return kept < N;
}

/* Newton's method for the instants of touches that were put into a cycle, as which its maxima are
 * known to the root of rounding: `kept` are the other events, the first among them. False: no
 * memory. */
static bool time_touches(const ric_model *m, const bool *kept, ric_periodic *c)
{
    enum { STEPS = 3 }; /* each squares what is left */
    const int n = c->n;
    double rate[2 * n], *W = ric_calloc((size_t)c->N * 2 * (size_t)n, sizeof *W);
    for (int step = 0; step < STEPS && W; step++) {
        uint64_t closed = c->closed;
        ric_periodic_states(m, c, W);
        for (int i = 1; i < c->N; i++) {
            const ric_face *f = &m->face[c->face[i]];
            closed = ric_flight_toggle(m, closed, c->face[i]);
            ric_flight_rate(m, closed, W + 2 * n * i, rate);
            const double by = -impact_speed(m, c, W, i) / (f->side * ric_dot(n, f->c, rate + n));
            if (kept[i] || !isfinite(by)) continue;
            c->tau[i - 1] += by;
            c->tau[i] -= by;
        }
    }
    const bool good = W;
    free(W);
    return good;
}

/* The cycle with all that it touches as events, read off its flights. NULL: no memory, or too many.
 */
static ric_periodic *read_off(const ric_model *m, const ric_periodic *cycle)
{
    bool *kept = NULL;
    ric_periodic *full = ric_grazing_words_touches(m, cycle, &kept);
    const bool timed = full && kept && time_touches(m, kept, full);
    free(kept);
    if (timed) return full;
    ric_periodic_free(full);
    return NULL;
}

/* One flight may touch several times with one amplitude, and these touches are no images of each
 * other. As impacts that all have to close they are known to the root of rounding only, and kick
 * the orbit by as much. It is solved with one of them and its images as impacts, and the others are
 * read off the flights. NULL: it does not touch there then. */
static ric_periodic *solve_one_touch(const ric_model *m, const ric_node *node)
{
    const ric_periodic *c = node->cycle;
    bool keep[c->N];
    if (!keep_one_touch(node, keep)) return NULL;
    ric_periodic *part = ric_periodic_keep(m, c, keep),
                 *solved = part ? ric_node_solve(m, part,
                                                 (ric_criterion){.test = RIC_TEST_APPROACH}, NULL)
                                : NULL,
                 *full = solved ? read_off(m, solved) : NULL;
    const bool same = full && full->N == c->N &&
                      ric_periodic_find_symmetries(m, full, RIC_SAME_LOCATED) == 1;
    ric_periodic_free(part);
    ric_periodic_free(solved);
    if (same) return full;
    ric_periodic_free(full);
    return NULL;
}

/* Whether a grazing orbit is without impacts. */
static bool is_bare(const ric_node *node)
{
    int events = 0;
    for (int i = 0; i < node->n_touch; i++) events += ric_node_soft(node, i) ? 2 : 1;
    return events == node->cycle->N;
}

/* The linear mode that a motion without impacts is, wherever it was met; -1 if it is none. */
static int linear_mode(const ric_periodic *c, double tolerance)
{
    int most = 0;
    double rest = 0;
    for (int i = 1; i < c->n; i++)
        if (hypot(c->w[i], c->w[c->n + i]) > hypot(c->w[most], c->w[c->n + most])) most = i;
    for (int i = 0; i < c->n; i++)
        if (i != most) rest = hypot(rest, hypot(c->w[i], c->w[c->n + i]));
    return rest < tolerance * hypot(c->w[most], c->w[c->n + most]) ? most : -1;
}

/* The mixture of modes of one frequency that a linear motion is; -1 if it is none. */
static int mixture_of(const ric_model *m, const double *w, double tolerance)
{
    for (int i = 0; i < m->mixtures->n; i++)
        if (ric_mixture_same(m, &m->mixtures->list[i], w, tolerance)) return i;
    return -1;
}

int ric_node_space(const ric_model *m, const ric_node *node)
{
    if (node->mixture >= 0) return m->mixtures->list[node->mixture].space;
    return node->mode >= 0 ? ric_mixture_space(m, node->mode) : -1;
}

/* Whether a motion without impacts comes back after its period: it is one of a single frequency, or
 * all of its frequencies fit. Impacts that are all slow may end at none, where frequencies fit to
 * 1e-7 only; or they are what keeps a motion periodic whose frequencies all but fit. */
static bool comes_back(const ric_model *m, const ric_node *node)
{
    const ric_periodic *c = node->cycle;
    const double period = ric_periodic_period(c);
    double open = 0, size = 0;
    bool stops;
    if (linear_mode(c, RIC_SAME_LOCATED) >= 0 || mixture_of(m, c->w, RIC_SAME_LOCATED) >= 0)
        return true;
    for (int i = 0; i < c->n; i++) {
        const double turns = m->omega[i] * period / RIC_TWO_PI,
                     own = hypot(c->w[i], c->w[c->n + i]);
        open = hypot(open, m->omega[i] > 0 ? RIC_TWO_PI * (turns - rint(turns)) * own
                                           : period * c->w[c->n + i]);
        size = hypot(size, own);
    }
    const double slow = fastest_touch(m, node, &stops);
    return open <= BEYOND * size && (slow <= NO_SPEED || open <= KICK * slow);
}

/* Whether a word says which springs of an orbit are closed. One that is closed without end has no
 * letter: where it opens for no time, the orbit without that touch is stored as another one. */
static bool is_spelt(const ric_model *m, const ric_periodic *c)
{
    uint64_t said = 0;
    for (int i = 0; i < ric_periodic_letters(c); i++)
        if (m->face[c->face[i]].spring > 0) said |= (uint64_t)1 << c->face[i];
    return !(c->closed & ~said);
}

/* Whether an orbit has speed at all its impacts: solved once more, some that had may be touches. */
static bool strikes(const ric_model *m, const ric_periodic *c)
{
    double *speed = stop_speeds(m, c);
    bool all = speed;
    for (int i = 0; i < c->N && all; i++) all = speed[i] < 0 || speed[i] > NO_SPEED;
    free(speed);
    return all;
}

/* Whether the orbit without its touches, which is what is stored, comes back, passes no stop,
 * strikes where it says, has a word, and touches: it is solved once more, and what was listed by
 * its speed alone may not. What does not become a chain is not judged. */
static bool is_motion(const ric_model *m, const ric_node *node)
{
    if (node->refusal) return true;
    if (is_bare(node)) return comes_back(m, node);
    bool bare;
    ric_periodic *left = ric_node_original(m, node, &bare);
    const bool motion = left && is_spelt(m, left) && strikes(m, left) &&
                        ric_node_solve_grazes(m, left);
    ric_periodic_free(left);
    return motion;
}

/* Puts the cycle in which touches are read off in the place of that of the node, where some of them
 * have more speed than Newton's method leaves, and are hardly known, and it has as many. `end`: of
 * the branch that comes to it, its energy. False: no memory. */
static bool sharpen(const ric_model *m, ric_node **node, int multiple, double end)
{
    if (!list_touches(m, *node, HARDLY)) return false;
    if ((*node)->refusal || is_bare(*node)) return !ric_memory_failed();
    bool stops;
    const double most = fastest_touch(m, *node, &stops);
    if (!stops || most <= NO_SPEED) return !ric_memory_failed();
    ric_periodic *full = solve_one_touch(m, *node);
    if (full && !is_sharper(m, *node, most, full, end)) {
        ric_periodic_free(full);
        return !ric_memory_failed();
    }
    ric_node *sharp = full ? ric_node_create(m, RIC_KIND_GRAZING, full) : NULL;
    if (!sharp) return !ric_memory_failed();
    sharp->multiple = multiple;
    const bool listed = list_touches(m, sharp, HARDLY),
               better = listed && sharp->n_touch == (*node)->n_touch;
    ric_node_free(better ? *node : sharp);
    if (better) *node = sharp;
    return listed;
}

/* `end`: the energy at which the branch ends that comes to it, or NAN. */
static ric_status finish_grazing(const ric_model *m, ric_periodic *full, int multiple, double end,
                                 ric_node **out)
{
    const int events = full ? full->N : 0; /* the node may get another cycle */
    ric_node *node = ric_node_create(m, RIC_KIND_GRAZING, full);
    ric_status status = RIC_OK;
    if (!node) return ric_no_memory("a junction");
    node->multiple = multiple;
    if (!sharpen(m, &node, multiple, end)) {
        ric_node_free(node);
        return ric_no_memory("a junction");
    }
    /* no impact at all, else as few touches as can be, else more, else none once more */
    static const struct {
        double slow;
        bool bare;
    } ways[] = {{HARDLY, true}, {NO_SPEED, false}, {HARDLY, false}, {RIC_SAME_EXTRAPOLATED, true}};
    bool listed = true, motion = false;
    for (int i = 0; i < 4 && listed && !motion; i++) {
        listed = list_touches(m, node, ways[i].slow);
        motion = listed && (!ways[i].bare || is_bare(node)) && is_motion(m, node);
    }
    if (!listed) status = ric_no_memory("a junction");
    else if (!motion)
        status = ric_fail(RIC_E_NUMERIC,
                          "a grazing orbit of %d impacts passes a stop, does not come back, "
                          "touches nothing, or keeps a spring closed without end, which no word "
                          "says",
                          events);
    if (status) {
        ric_node_free(node);
        return status;
    }
    if (is_bare(node)) {
        node->mode = linear_mode(node->cycle, RIC_SAME_LOCATED);
        node->mixture = mixture_of(m, node->cycle->w, RIC_SAME_LOCATED);
    }
    *out = node;
    return RIC_OK;
}

/* How often a motion of this frequency fits into the period of the cycle; 0 where it does not. */
static int times_through(const ric_periodic *cycle, double omega)
{
    double times = ric_periodic_period(cycle) / (RIC_TWO_PI / omega);
    return rint(times) >= 1 && fabs(times - rint(times)) <= RIC_SAME_READ_OFF ? (int)rint(times)
                                                                              : 0;
}

/* The node instead of which it stands, gone through that often; takes it over. */
static ric_status gone_through(const ric_model *m, ric_node *once, int times, ric_node **out)
{
    if (times == 1) {
        *out = once;
        return RIC_OK;
    }
    ric_status status = ric_node_duplicate(m, once, times, out);
    ric_node_free(once);
    return status;
}

/* A branch that comes to a mixture of modes of one frequency comes to a family of motions that
 * touch, and to the one place on it where branches leave: what the trace has found of that place is
 * replaced by it. *out = NULL: it comes to none. */
static ric_status arrived_mixture(const ric_model *m, const ric_periodic *cycle, ric_node **out)
{
    ric_node *once = NULL;
    *out = NULL;
    int mixture = m->mixtures->n ? mixture_of(m, cycle->w, RIC_SAME_READ_OFF) : -1;
    if (mixture < 0) return RIC_OK;
    int times = times_through(cycle,
                              m->omega[m->mixtures->space[m->mixtures->list[mixture].space].first]);
    ric_status status = times ? ric_node_mixture(m, mixture, &once) : RIC_OK;
    return status || !once ? status : gone_through(m, once, times, out);
}

/* A branch that comes to a linear mode is located there to the root of rounding only, as all its
 * impacts end at once; the mode itself is known, and replaces what was found of it. */
static ric_status arrived_mode(const ric_model *m, ric_node **node)
{
    ric_node *once = NULL;
    int mode = (*node)->mode, times = mode >= 0 ? times_through((*node)->cycle, m->omega[mode]) : 0;
    times *= (*node)->multiple;
    ric_status status = times ? ric_node_linear(m, mode, &once) : RIC_OK;
    if (status || !once) return status;
    ric_node_free(*node);
    *node = NULL;
    return gone_through(m, once, times, node);
}

ric_status ric_node_mode_together(const ric_model *m, const ric_periodic *cycle, ric_node **out)
{
    ric_node *once = NULL;
    const int mode = linear_mode(cycle, RIC_SAME_READ_OFF),
              times = mode < 0 ? 0 : times_through(cycle, m->omega[mode]);
    *out = NULL;
    ric_status status = times ? ric_node_linear(m, mode, &once) : RIC_OK;
    return status || !once ? status : gone_through(m, once, times, out);
}

/* The orbit at the end of a branch that comes to a touch, with all that it touches as events:
 * solved as the branch has it, and moved along it to the touch. NULL: it does not come there. */
static ric_periodic *solve_end(const ric_model *m, const ric_periodic *cycle)
{
    ric_periodic *end = ric_node_solve_again(m, cycle), *full = NULL, *out = NULL;
    if (end && ric_node_solve_touches(m, end)) full = read_off(m, end);
    if (full) {
        ric_periodic_find_symmetries(m, full, RIC_SAME_LOCATED);
        out = ric_periodic_canonical(m, full);
    }
    ric_periodic_free(end);
    ric_periodic_free(full);
    return out;
}

/* The least end pivot of the equations of an orbit; 0: no memory. */
static double least_pivot(const ric_model *m, const ric_periodic *cycle)
{
    ric_shooting *q = equations_of(m, cycle);
    const double least = q ? q->smallest : 0;
    ric_shooting_free(q);
    return least;
}

/* The orbit of a grazing with its touches as events: the solution of its equations where these are
 * as good as those of the branch. A touch may be the first that sees where a free structure is:
 * then the branch holds the place, by its symmetry or its start, and without that the orbits which
 * touch are a curve, each with its energy. And where frequencies nearly fit, they are one but for
 * little. There the orbit is that at the end of the branch. */
static ric_periodic *solve_grazing(const ric_model *m, const ric_periodic *cycle,
                                   const ric_periodic *full)
{
    ric_periodic *solved = ric_node_solve(m, full, (ric_criterion){.test = RIC_TEST_APPROACH},
                                          NULL);
    if (cycle->N == 0 || full->N == cycle->N) return solved; /* touches are impacts of the branch */
    const double end = ric_periodic_energy(m, cycle);
    const double off = solved ? fabs(ric_periodic_energy(m, solved) - end) / end : HUGE_VAL;
    if (off <= AT_END || (off <= NEAR_END && least_pivot(m, solved) > REGULAR)) return solved;
    ric_periodic *at_end = solve_end(m, cycle);
    if (!at_end) return solved;
    ric_periodic_free(solved);
    return at_end;
}

ric_status ric_node_grazing(const ric_model *m, const ric_periodic *cycle, ric_node **out)
{
    ric_status mixed = arrived_mixture(m, cycle, out);
    if (mixed || *out) return mixed;
    ric_periodic *full = ric_grazing_words_touches(m, cycle, NULL), *solved = NULL;
    *out = NULL;
    if (!full) return ric_grazing_words_lost(cycle);
    int q = ric_periodic_find_symmetries(m, full, RIC_SAME_LOCATED);
    if (q > 1) { /* a duplicate of a grazing of fewer impacts */
        ric_periodic *shorter = ric_periodic_shorten(full, q);
        ric_periodic_free(full);
        if (!(full = shorter)) return ric_no_memory("a junction");
        ric_periodic_find_symmetries(m, full, RIC_SAME_LOCATED);
    }
    solved = solve_grazing(m, cycle, full);
    ric_periodic_free(full);
    if (!solved)
        return ric_fail(RIC_E_NUMERIC, "a grazing orbit of %d impacts does not converge", cycle->N);
    ric_status status = finish_grazing(m, solved, q, ric_periodic_energy(m, cycle), out);
    if (!status && (*out)->n_touch && !(*out)->refusal && (*out)->mixture < 0)
        status = arrived_mode(m, out);
    if (status || (*out)->n_touch || (*out)->refusal) return status;
    ric_node_free(
        *out); /* beside a family of two parameters the place of a touch is known to nothing */
    *out = NULL;
    return ric_fail(RIC_E_NUMERIC,
                    "a grazing orbit of %d impacts touches nothing where it converges", cycle->N);
}

ric_status ric_node_duplicate(const ric_model *m, const ric_node *node, int multiple,
                              ric_node **out)
{
    *out = NULL;
    return finish_grazing(m, ric_periodic_copy(node->cycle), multiple, NAN, out);
}

/* A touch of a face by a linear motion of one frequency, with the time after the start of its
 * cycle. */
typedef struct {
    double time;
    int face;
} linear_touch;

static int earlier(const void *a, const void *b)
{
    const linear_touch *p = a, *q = b;
    if (p->time != q->time) return p->time < q->time ? -1 : 1;
    return p->face - q->face;
}

/* All touches of a linear motion of frequency omega that starts where it touches, in order: of s =
 * Re(S e^(-i omega t)) where |S| is the clearance. What falls within rounding of the start of the
 * period, or of its middle, is there. */
static int touches_of(const ric_model *m, double omega, const double *w, linear_touch *out)
{
    int n = m->n, count = 0;
    for (int f = 0; f < m->n_face; f++) {
        double gap = m->face[f].gap, x = ric_dot(n, m->face[f].g, w),
               y = ric_dot(n, m->face[f].g, w + n);
        if (fabs(hypot(x, y) / fabs(gap) - 1) > RIC_TIE) continue;
        double phase = atan2(gap < 0 ? -y : y, gap < 0 ? -x : x);
        if (phase < -RIC_TIE) phase += RIC_TWO_PI;
        if (fabs(phase) <= RIC_TIE) phase = 0;
        if (fabs(phase - RIC_PI) <= RIC_TIE) phase = RIC_PI;
        out[count++] = (linear_touch){phase / omega, f};
    }
    qsort(out, (size_t)count, sizeof *out, earlier);
    return count;
}

/* The grazing of a linear motion of one frequency from where it touches, w [2n]: all its contacts
 * are touches, and the cycle starts at the first. */
static ric_status linear_grazing(const ric_model *m, double omega, const double *w, ric_node **out)
{
    int n = m->n, N = 0;
    linear_touch touches[m->n_face];
    int count = touches_of(m, omega, w, touches);
    ric_periodic *c = ric_periodic_create(n, 2 * m->n_face);
    if (!c) return ric_no_memory("a junction");
    memcpy(c->w, w, 2 * (size_t)n * sizeof *w);
    for (int i = 0; i < count; i++) {
        if (m->face[touches[i].face].spring > 0)
            c->face[N++] = touches[i].face; /* it closes, and opens at once */
        c->tau[N] = (i + 1 < count ? touches[i + 1].time : RIC_TWO_PI / omega) - touches[i].time;
        c->face[N++] = touches[i].face;
    }
    c->N = N;
    c->closed = ric_flight_toggle(m, 0, c->face[0]);
    ric_periodic_find_symmetries(m, c, RIC_SAME_LOCATED);
    ric_periodic *canonical = ric_periodic_canonical(m, c);
    ric_periodic_free(c);
    if (!canonical) return ric_no_memory("a junction");
    return finish_grazing(m, canonical, 1, NAN, out);
}

/* A linear mode with the amplitude at which it touches. */
ric_status ric_node_linear(const ric_model *m, int mode, ric_node **out)
{
    int n = m->n, first = -1;
    double omega = m->omega[mode], amplitude = HUGE_VAL, w[2 * n];
    *out = NULL;
    if (omega == 0) return RIC_OK;
    for (int f = 0; f < m->n_face; f++) {
        double g = m->face[f].g[mode];
        if (g != 0 && fabs(m->face[f].gap / g) < amplitude * (1 - RIC_TIE)) {
            amplitude = fabs(m->face[f].gap / g);
            first = f;
        }
    }
    memset(w, 0, sizeof w);
    w[mode] = m->face[first].gap / m->face[first].g[mode] > 0 ? amplitude : -amplitude;
    return linear_grazing(m, omega, w, out);
}

ric_status ric_node_mixture(const ric_model *m, int mixture, ric_node **out)
{
    const ric_mixture *mixed = &m->mixtures->list[mixture];
    return linear_grazing(m, m->omega[m->mixtures->space[mixed->space].first], mixed->w, out);
}
