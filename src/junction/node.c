#include "node.h"

#include <stdlib.h>
#include <string.h>

#include "corner.h"
#include "node_solve.h"
#include "model/room.h"
#include "branch/room.h"
#include "grazing_words.h"
#include "base/room.h"

/* Scaled: an impact below this speed at a located event is a touch that was kept. Newton's method leaves 1e-12 of it;
 * what is faster is an impact, and without it the motion is another one. Where all impacts end at once an orbit is
 * located to less, and what is slower than HARDLY is a touch there. */
#define NO_SPEED 1e-10
#define HARDLY 1e-7
#define BEYOND 1e-9  /* of the clearance: an orbit of a junction that goes through a stop by more is no motion */
#define NO_TIME 1e-7 /* scaled: a contact that lasts no longer is a touch of a spring, a flight is none at a corner */
/* ALONE: a multiplier nearer to one root of unity than this part of its distance to the next one means that one */
#define ALONE 0.25

void ric_node_free(ric_node *node)
{
    if (!node) return;
    ric_periodic_free(node->cycle);
    for (int i = 0; i < node->n_departure; i++) free(node->departures[i].why);
    free(node->departures);
    free(node);
}

ric_node *ric_node_copy(const ric_node *node)
{
    ric_node *copy = ric_malloc(sizeof *copy);
    if (!copy) return NULL;
    *copy = *node;
    copy->cycle = ric_periodic_copy(node->cycle);
    copy->departures = ric_malloc((size_t)(node->n_departure + 1) * sizeof *copy->departures);
    copy->n_departure = copy->departures ? node->n_departure : 0;
    for (int i = 0; i < copy->n_departure; i++)
        copy->departures[i] = (ric_departure){.choice = node->departures[i].choice, .state = node->departures[i].state};
    if (copy->cycle && copy->departures) return copy;
    ric_node_free(copy);
    return NULL;
}

const char *ric_budget_text(ric_budget budget)
{
    static const char *const texts[RIC_N_BUDGET] = {"frequency", "multiply", "impacts",
                                                    "symmetric", "touches",  "depth"};
    return budget >= 0 && budget < RIC_N_BUDGET ? texts[budget] : "";
}

const char *ric_node_refusal_text(ric_refusal refusal)
{
    switch (refusal) {
    case RIC_REFUSAL_TOUCHES: return "more touches at once than are enumerated";
    case RIC_REFUSAL_TOGETHER:
        return "two contacts with orthogonal normals close at one instant, and on the branches that go on they do so "
               "for good; such branches are not followed by this version";
    case RIC_REFUSAL_OBLIQUE:
        return "two contacts close at one instant and their normals are not orthogonal in the metric of M^-1: the "
               "impact law does not say what happens; the branch ends here";
    case RIC_REFUSAL_NONE: break;
    }
    return "";
}

static ric_node *node_create(const ric_model *m, ric_kind kind, ric_periodic *cycle)
{
    ric_node *node = cycle ? ric_calloc(1, sizeof *node) : NULL;
    if (!node) {
        ric_periodic_free(cycle);
        return NULL;
    }
    node->kind = kind;
    node->cycle = cycle;
    node->mirrors = m->symmetric;
    node->test = -1;
    node->multiple = 1;
    node->mode = node->mixture = -1;
    node->springs = ric_periodic_springs(m);
    node->energy = ric_periodic_energy(m, cycle);
    node->period = ric_periodic_period(cycle);
    return node;
}

/* ----------------------------------------------------------------- grazings */

static double impact_speed(const ric_model *m, const ric_periodic *c, const double *W, int i)
{
    const ric_face *f = &m->face[c->face[i]];
    return -f->side * ric_dot(c->n, f->c, W + 2 * c->n * i + c->n);
}

static bool list_touches(const ric_model *m, ric_node *node, double slow)
{
    const ric_periodic *c = node->cycle;
    node->n_touch = 0;
    node->refusal = RIC_REFUSAL_NONE;
    double *W = ric_calloc((size_t)c->N * 2 * (size_t)c->n, sizeof *W);
    bool fits = true;
    if (!W) return false;
    ric_periodic_states(m, c, W);
    for (int i = 0; i < c->N; i++) {
        bool spring = m->face[c->face[i]].spring > 0, pair = spring && c->face[(i + 1) % c->N] == c->face[i];
        if (spring ? !pair || fabs(c->tau[i]) > NO_TIME : fabs(impact_speed(m, c, W, i)) > slow) continue;
        if (node->n_touch < RIC_MAX_TOUCHES) node->touch[node->n_touch++] = i;
        else fits = false;
    }
    free(W);
    if (!fits || node->n_touch * node->multiple > RIC_MAX_TOUCHES) node->refusal = RIC_REFUSAL_TOUCHES;
    return true;
}

/* Whether a grazing orbit is without impacts. */
static bool is_bare(const ric_node *node)
{
    int events = 0;
    for (int i = 0; i < node->n_touch; i++) events += ric_node_soft(node, i) ? 2 : 1;
    return events == node->cycle->N;
}

/* The linear mode that such an orbit is, wherever it was met; -1 if it is none. */
static int linear_mode(const ric_node *node)
{
    const ric_periodic *c = node->cycle;
    int most = 0;
    double rest = 0;
    for (int i = 1; i < c->n; i++)
        if (hypot(c->w[i], c->w[c->n + i]) > hypot(c->w[most], c->w[c->n + most])) most = i;
    for (int i = 0; i < c->n; i++)
        if (i != most) rest = hypot(rest, hypot(c->w[i], c->w[c->n + i]));
    return rest < RIC_SAME_LOCATED * hypot(c->w[most], c->w[c->n + most]) ? most : -1;
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

/* Whether the orbit without its touches, which is what is stored, passes no stop. What does not become a chain is not
 * judged. */
static bool is_motion(const ric_model *m, const ric_node *node)
{
    if (is_bare(node) || node->refusal) return true;
    ric_periodic *left = ric_node_regular(m, node), *again = left ? ric_node_solve_again(m, left) : NULL;
    ric_shooting *chain = NULL;
    double *u = NULL;
    double reach = 0;
    if (left && !ric_periodic_to_chain(m, again ? again : left, &chain, &u)) {
        ric_shooting_fly(chain, u);
        reach = ric_reach(chain, u, NULL);
    }
    ric_periodic_free(left);
    ric_periodic_free(again);
    ric_shooting_free(chain);
    free(u);
    return reach <= 1 + BEYOND;
}

static ric_status finish_grazing(const ric_model *m, ric_periodic *full, int multiple, ric_node **out)
{
    ric_node *node = node_create(m, RIC_KIND_GRAZING, full);
    ric_status status = RIC_OK;
    if (!node) return ric_no_memory("a junction");
    node->multiple = multiple;
    /* no impact at all, else as few touches as can be, else more */
    static const double slow[] = {HARDLY, NO_SPEED, HARDLY};
    bool listed = true, motion = false;
    for (int i = 0; i < 3 && listed && !motion; i++) {
        listed = list_touches(m, node, slow[i]);
        motion = listed && (i == 0 ? is_bare(node) : is_motion(m, node));
    }
    if (!listed) status = ric_no_memory("a junction");
    else if (!motion) status = ric_fail(RIC_E_NUMERIC, "a grazing orbit of %d impacts passes a stop", full->N);
    if (status) {
        ric_node_free(node);
        return status;
    }
    if (is_bare(node)) {
        node->mode = linear_mode(node);
        node->mixture = mixture_of(m, node->cycle->w, RIC_SAME_LOCATED);
    }
    *out = node;
    return RIC_OK;
}

/* How often a motion of this frequency fits into the period of the cycle; 0 where it does not. */
static int times_through(const ric_periodic *cycle, double omega)
{
    double times = ric_periodic_period(cycle) / (RIC_TWO_PI / omega);
    return rint(times) >= 1 && fabs(times - rint(times)) <= RIC_SAME_READ_OFF ? (int)rint(times) : 0;
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

/* A branch that comes to a mixture of modes of one frequency comes to a family of motions that touch, and to the one
 * place on it where branches leave: what the trace has found of that place is replaced by it. *out = NULL: it comes to
 * none. */
static ric_status arrived_mixture(const ric_model *m, const ric_periodic *cycle, ric_node **out)
{
    ric_node *once = NULL;
    *out = NULL;
    int mixture = m->mixtures->n ? mixture_of(m, cycle->w, RIC_SAME_READ_OFF) : -1;
    if (mixture < 0) return RIC_OK;
    int times = times_through(cycle, m->omega[m->mixtures->space[m->mixtures->list[mixture].space].first]);
    ric_status status = times ? ric_node_mixture(m, mixture, &once) : RIC_OK;
    return status || !once ? status : gone_through(m, once, times, out);
}

/* A branch that comes to a linear mode is located there to the root of rounding only, as all its impacts end at once;
 * the mode itself is known, and replaces what was found of it. */
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

ric_status ric_node_grazing(const ric_model *m, const ric_periodic *cycle, ric_node **out)
{
    ric_status mixed = arrived_mixture(m, cycle, out);
    if (mixed || *out) return mixed;
    ric_periodic *full = ric_grazing_words_touches(m, cycle, NULL), *solved = NULL;
    *out = NULL;
    if (!full) return ric_no_memory("a junction");
    int q = ric_periodic_find_symmetries(m, full, RIC_SAME_LOCATED);
    if (q > 1) { /* a duplicate of a grazing of fewer impacts */
        ric_periodic *shorter = ric_periodic_shorten(full, q);
        ric_periodic_free(full);
        if (!(full = shorter)) return ric_no_memory("a junction");
        ric_periodic_find_symmetries(m, full, RIC_SAME_LOCATED);
    }
    solved = ric_node_solve(m, full, (ric_criterion){.test = RIC_TEST_APPROACH}, NULL);
    ric_periodic_free(full);
    if (!solved) return ric_fail(RIC_E_NUMERIC, "a grazing orbit of %d impacts does not converge", cycle->N);
    ric_status status = finish_grazing(m, solved, q, out);
    if (!status && (*out)->n_touch && !(*out)->refusal && (*out)->mixture < 0) status = arrived_mode(m, out);
    if (status || (*out)->n_touch || (*out)->refusal) return status;
    ric_node_free(*out); /* beside a family of two parameters the place of a touch is known to nothing */
    *out = NULL;
    return ric_fail(RIC_E_NUMERIC, "a grazing orbit of %d impacts touches nothing where it converges", cycle->N);
}

ric_status ric_node_duplicate(const ric_model *m, const ric_node *node, int multiple, ric_node **out)
{
    *out = NULL;
    return finish_grazing(m, ric_periodic_copy(node->cycle), multiple, out);
}

/* A touch of a face by a linear motion of one frequency, with the time after the start of its cycle. */
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

/* All touches of a linear motion of frequency omega that starts where it touches, in order: of s = Re(S e^(-i omega t))
 * where |S| is the clearance. What falls within rounding of the start of the period, or of its middle, is there. */
static int touches_of(const ric_model *m, double omega, const double *w, linear_touch *out)
{
    int n = m->n, count = 0;
    for (int f = 0; f < m->n_face; f++) {
        double gap = m->face[f].gap, x = ric_dot(n, m->face[f].g, w), y = ric_dot(n, m->face[f].g, w + n);
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

/* The grazing of a linear motion of one frequency from where it touches, w [2n]: all its contacts are touches, and the
 * cycle starts at the first. */
static ric_status linear_grazing(const ric_model *m, double omega, const double *w, ric_node **out)
{
    int n = m->n, N = 0;
    linear_touch touches[m->n_face];
    int count = touches_of(m, omega, w, touches);
    ric_periodic *c = ric_periodic_create(n, 2 * m->n_face);
    if (!c) return ric_no_memory("a junction");
    memcpy(c->w, w, 2 * (size_t)n * sizeof *w);
    for (int i = 0; i < count; i++) {
        if (m->face[touches[i].face].spring > 0) c->face[N++] = touches[i].face; /* it closes, and opens at once */
        c->tau[N] = (i + 1 < count ? touches[i + 1].time : RIC_TWO_PI / omega) - touches[i].time;
        c->face[N++] = touches[i].face;
    }
    c->N = N;
    c->closed = ric_flight_toggle(m, 0, c->face[0]);
    ric_periodic_find_symmetries(m, c, RIC_SAME_LOCATED);
    ric_periodic *canonical = ric_periodic_canonical(m, c);
    ric_periodic_free(c);
    if (!canonical) return ric_no_memory("a junction");
    return finish_grazing(m, canonical, 1, out);
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

bool ric_node_coincident(const ric_model *m, const ric_periodic *cycle)
{
    ric_periodic *full = ric_grazing_words_touches(m, cycle, NULL);
    bool found = false;
    for (int i = 0; full && i < full->N; i++)
        found |= full->tau[i] < RIC_COINCIDENT &&
                 m->face[full->face[i]].contact != m->face[full->face[(i + 1) % full->N]].contact;
    ric_periodic_free(full);
    return found;
}

/* With orthogonal normals the reflections commute: each pair of impacts at one instant may go on in either order, and
 * every choice of orders is a way out. */
static ric_status finish_corner(const ric_model *m, const ric_periodic *cycle, int n_pair, const int *pairs,
                                ric_node **out)
{
    ric_periodic *least = ric_corner_least(m, cycle, n_pair, pairs, RIC_SAME_LOCATED), *solved;
    if (!least) return ric_no_memory("a junction");
    solved = ric_node_solve(m, least, (ric_criterion){.test = RIC_TEST_FLIGHT}, NULL);
    ric_periodic_free(least);
    if (!solved) return ric_fail(RIC_E_NUMERIC, "a corner orbit of %d impacts does not converge", cycle->N);
    ric_node *node = node_create(m, RIC_KIND_CORNER, solved);
    if (!node) return ric_no_memory("a junction");
    node->n_touch = ric_corner_pairs(m, solved, NO_TIME, RIC_MAX_TOUCHES, node->touch);
    if (node->n_touch != n_pair) {
        ric_node_free(node);
        return ric_fail(RIC_E_NUMERIC, "a corner orbit of %d impacts does not converge", cycle->N);
    }
    *out = node;
    return RIC_OK;
}

ric_status ric_node_corner(const ric_model *m, const ric_periodic *cycle, ric_node **out)
{
    int pairs[RIC_MAX_TOUCHES], n_pair = RIC_CORNER_UNDEFINED;
    ric_periodic *full = ric_grazing_words_touches(m, cycle, NULL);
    *out = NULL;
    if (!full) return ric_no_memory("a junction");
    n_pair = ric_corner_pairs(m, full, NO_TIME, RIC_MAX_TOUCHES, pairs);
    if (n_pair > 0 && (full->N > cycle->N || ric_corner_fixed(m, full, n_pair, pairs, RIC_SAME_EXTRAPOLATED)))
        n_pair = RIC_CORNER_TOGETHER;
    ric_periodic_free(full);
    if (n_pair > 0) return finish_corner(m, cycle, n_pair, pairs, out);
    ric_node *node = node_create(m, RIC_KIND_CORNER, ric_periodic_canonical(m, cycle));
    if (!node) return ric_no_memory("a junction");
    node->refusal = n_pair == RIC_CORNER_TOGETHER ? RIC_REFUSAL_TOGETHER : RIC_REFUSAL_OBLIQUE;
    *out = node;
    return RIC_OK;
}

/* ------------------------------------------------------------- branch points */

/* The branch that passes, and up to two that leave. */
static bool add_departures(ric_node *node, int count)
{
    node->departures = ric_calloc((size_t)count, sizeof *node->departures);
    if (!node->departures) return false;
    for (int i = 0; i < count; i++) node->departures[i].choice = RIC_THROUGH + (unsigned)i;
    node->n_departure = count;
    return true;
}

ric_status ric_node_interior(const ric_model *m, const ric_periodic *cycle, int test, ric_node **out)
{
    ric_kind kind = test == RIC_TEST_SLOPE    ? RIC_KIND_EXTREMUM
                    : test == RIC_TEST_PERIOD ? RIC_KIND_PERIOD_EXTREMUM
                                              : RIC_KIND_BRANCH_POINT;
    *out = NULL;
    bool moved = false;
    ric_periodic *solved = ric_node_solve(m, cycle, (ric_criterion){.test = test}, &moved);
    /* on a branch of one energy, or of one period, an extremum that goes elsewhere, or is nowhere sharp, is rounding */
    if (!solved && kind != RIC_KIND_BRANCH_POINT && (moved || !ric_node_solve_sharp(m, cycle, test))) return RIC_OK;
    if (!solved) return ric_fail(RIC_E_NUMERIC, "a junction on a branch of %d impacts does not converge", cycle->N);
    if (kind != RIC_KIND_BRANCH_POINT && !ric_node_solve_sharp(m, solved, test)) {
        ric_periodic_free(solved);
        return RIC_OK;
    }
    ric_node *node = node_create(m, kind, solved);
    if (!node) return ric_no_memory("a junction");
    node->test = test;
    if (kind == RIC_KIND_BRANCH_POINT && !add_departures(node, 2)) {
        ric_node_free(node);
        return ric_no_memory("a junction");
    }
    *out = node;
    return RIC_OK;
}

ric_status ric_node_user(const ric_model *m, const ric_periodic *cycle, const ric_user_point *asked, ric_node **out)
{
    *out = NULL;
    ric_periodic *solved = ric_node_solve(m, cycle, (ric_criterion){.test = RIC_TEST_ASKED, .asked = asked}, NULL);
    if (!solved)
        return ric_fail(RIC_E_NUMERIC, "an orbit of %d impacts with what was asked for does not converge", cycle->N);
    ric_node *node = node_create(m, RIC_KIND_USER, solved);
    if (!node) return ric_no_memory("a junction");
    node->asked = *asked;
    *out = node;
    return RIC_OK;
}

ric_status ric_node_start(const ric_model *m, const ric_periodic *cycle, ric_node **out)
{
    ric_node *node = node_create(m, RIC_KIND_START, ric_periodic_canonical(m, cycle));
    *out = NULL;
    if (!node || !add_departures(node, 1)) {
        ric_node_free(node);
        return ric_no_memory("a junction");
    }
    *out = node;
    return RIC_OK;
}

/* p of a q-tupling from the multipliers of the original orbit; 0 if none fits. Where a branch arrives on a sharp turn
 * rho is off, by 0.2 within 1e-5 of the orbit: the nearest p counts if no other is near, and ric_node_solve tells
 * whether it is met. rho alone does not tell p from q - p unless it is that of half a period: then the smaller one. */
static int rotation_of(const ric_model *m, const ric_periodic *cycle, int q)
{
    ric_shooting *chain = NULL;
    ric_floquet floquet = {0};
    double *u = NULL, best = HUGE_VAL, other = HUGE_VAL;
    int p = 0, nearest = 0;
    if (!ric_periodic_to_chain(m, cycle, &chain, &u) && !ric_floquet_create(m->n, &floquet)) {
        bool half = ric_shooting_halves(chain);
        ric_shooting_evaluate(chain, u);
        if (!ric_floquet_compute(chain, &floquet)) {
            /* over half a period p and p + q would be taken for one; and the orbit run backwards, which is the same
             * one, has q - p */
            if (isfinite(floquet.rotation) && !half) p = (int)lrint(q * fmin(floquet.rotation, 1 - floquet.rotation));
            for (int k = 1; p == 0 && k <= (half ? q - 1 : q / 2); k++) {
                double off = HUGE_VAL;
                for (int i = 0; i < floquet.n_pair; i++)
                    off = fmin(off, hypot(floquet.own[2 * i] - ric_symmetry_rho(half, k, q), floquet.own[2 * i + 1]));
                other = fmin(other, fmax(off, best));
                if (off < best) {
                    best = off;
                    nearest = k;
                }
            }
            if (p == 0 && best < ALONE * other) p = nearest;
        }
    }
    ric_shooting_free(chain);
    ric_floquet_release(&floquet);
    free(u);
    return p;
}

/* On an S orbit with mirror points, at a multiplication of order 2 q, the families that keep points of rest or impact
 * are images of each other in half a period and x -> -x; a whole number of periods, which is all that a structure
 * without this symmetry has, takes each to itself. For even q they are two curves, for odd q the halves of one. */
static bool has_image(const ric_node *node)
{
    const ric_periodic *c = node->cycle;
    return !node->mirrors && c->half && c->pure >= 0 && node->rotation[0] % 2;
}

ric_status ric_node_multiplication(const ric_model *m, const ric_periodic *cycle, int p, int q, ric_node **out)
{
    ric_criterion what = {.test = RIC_TEST_ROTATION, .rotation = {p, q}};
    ric_symmetry problems[2];
    int count = ric_symmetry_multiplying(cycle, p, q, problems), order = ric_symmetry_order(cycle, p, q);
    *out = NULL;
    ric_periodic *solved = ric_node_solve(m, cycle, what, NULL);
    if (!solved) return ric_fail(RIC_E_NUMERIC, "the original orbit of a multiplication by %d does not converge", q);
    ric_node *node = node_create(m, RIC_KIND_MULTIPLICATION, solved);
    if (!node || !add_departures(node, 4)) {
        ric_node_free(node);
        return ric_no_memory("a junction");
    }
    int measured = rotation_of(m, solved, q); /* p or q - p: rho does not tell */
    if (measured == q - p) p = measured;
    node->multiple = q;
    node->rotation[0] = p;
    node->rotation[1] = q;
    if (order == 2) { /* the canonical orbit may start elsewhere: mirror points are counted anew */
        ric_symmetry_multiplying(solved, p, q, problems);
        node->departures[1].choice = RIC_SIDE + (unsigned)(count == 2 ? ric_symmetry_singular(m, solved, problems) : 0);
        node->n_departure = 2;
    } else node->n_departure = ric_symmetry_passes(solved, p, q) ? 2 : has_image(node) && q % 2 == 0 ? 4 : 3;
    *out = node;
    return RIC_OK;
}

/* Which test vanishes on the symmetric orbit `whole` where a branch with the symmetries of `part` arrives: what is lost
 * tells. */
static int broken_test(const ric_periodic *whole, const ric_periodic *part)
{
    if (!(whole->half && whole->pure >= 0)) return whole->pure >= 0 || whole->flip >= 0 ? RIC_TEST_B : RIC_TEST_A;
    return part->half ? RIC_TEST_B : part->flip >= 0 ? RIC_TEST_A : RIC_TEST_D;
}

ric_status ric_node_arrival(const ric_model *m, const ric_periodic *cycle, ric_node **out)
{
    ric_periodic *sym = ric_periodic_copy(cycle);
    *out = NULL;
    if (!sym) return ric_no_memory("a junction");
    int q = ric_periodic_find_symmetries(m, sym, RIC_SAME_EXTRAPOLATED);
    if (q > 1) {
        ric_periodic *shorter = ric_periodic_shorten(sym, q);
        ric_periodic_free(sym);
        if (!(sym = shorter)) return ric_no_memory("a junction");
        ric_periodic_find_symmetries(m, sym, RIC_SAME_EXTRAPOLATED);
        int p = rotation_of(m, sym, q);
        ric_status status = p > 0 ? ric_node_multiplication(m, sym, p, q, out)
                                  : ric_fail(RIC_E_NUMERIC,
                                             "an orbit gone through %d times has no multiplier of that order", q);
        ric_periodic_free(sym);
        return status;
    }
    ric_status status = ric_node_interior(m, sym, broken_test(sym, cycle), out);
    if (status == RIC_E_NUMERIC && sym->half && sym->pure >= 0) {
        /* two branch points so close that the orbit of one seems to have the symmetry of the other: one symmetry is
         * gained at a time */
        ric_periodic less = *sym;
        for (int i = 0; i < 3 && status == RIC_E_NUMERIC; i++) {
            less.half = i == 0;
            less.pure = i == 1 ? sym->pure : -1;
            less.flip = i == 2 ? sym->flip : -1;
            if (less.half == cycle->half && less.pure == cycle->pure && less.flip == cycle->flip) continue;
            status = ric_node_interior(m, &less, broken_test(&less, cycle), out);
        }
    }
    ric_periodic_free(sym);
    if (!status && *out && ric_periodic_repeats(m, (*out)->cycle, RIC_SAME_LOCATED)) {
        /* read off, the orbit was too far from the repeated one to be known for it; solved, it is */
        ric_node *repeated = *out;
        status = ric_node_arrival(m, repeated->cycle, out);
        ric_node_free(repeated);
    }
    return status;
}

/* ------------------------------------------------------------------ identity */

bool ric_node_soft(const ric_node *node, int touch)
{
    return node->kind == RIC_KIND_GRAZING && node->springs >> node->cycle->face[node->touch[touch]] & 1;
}

bool ric_node_chooses(const ric_node *node)
{
    return node->kind == RIC_KIND_GRAZING || node->kind == RIC_KIND_CORNER;
}

bool ric_node_same(const ric_model *m, const ric_node *a, const ric_node *b)
{
    if (a->kind != b->kind || a->multiple != b->multiple || a->rotation[0] != b->rotation[0] ||
        a->cycle->N != b->cycle->N)
        return false;
    if (a->asked.frequency != b->asked.frequency || a->asked.value != b->asked.value) return false;
    if (fabs(a->energy - b->energy) > ric_node_near(a->energy) ||
        fabs(a->period - b->period) > RIC_SAME_LOCATED * a->period)
        return false;
    return ric_periodic_same(m, a->cycle, b->cycle, RIC_SAME_EXTRAPOLATED);
}

unsigned ric_node_arrived(const ric_model *m, const ric_node *node, const ric_periodic *cycle)
{
    unsigned result = RIC_SIDE;
    int shift;
    bool reverse, mirror;
    ric_periodic *repeated = node->multiple > 1 && node->n_departure > 2
                                 ? ric_periodic_repeat(node->cycle, node->multiple)
                                 : NULL,
                 *home = NULL;
    if (!repeated) return node->n_departure > 1 ? node->departures[1].choice : RIC_SIDE;
    ric_periodic *here = ric_periodic_copy(cycle);
    bool found = here && ric_periodic_divide(m, here, repeated->N);
    found = found && ric_periodic_match(m, repeated, here, RIC_SAME_READ_OFF, &shift, &reverse, &mirror);
    if (here && !found && ric_periodic_half_mark(m, here)) /* one starts at a rest, the other at a centre */
        found = ric_periodic_match(m, repeated, here, RIC_SAME_READ_OFF, &shift, &reverse, &mirror);
    if (found) home = ric_periodic_transform(m, here, shift, reverse, mirror);
    ric_periodic_free(here);
    ric_symmetry other = ric_node_problem(node, RIC_OTHER_SIDE);
    /* on an S orbit the two differ by the reversal; else by the mirror points of it, of which those a period
     * (2N half positions) apart are the same, those half a period apart are not */
    int r = !home ? -1 : home->pure >= 0 ? home->pure : home->flip, other_r = other.pure >= 0 ? other.pure : other.flip;
    bool reversal = home && (home->flip >= 0) == (other.flip >= 0);
    if (reversal && (node->cycle->half || (r - other_r) % (2 * node->cycle->N) == 0)) result = RIC_OTHER_SIDE;
    if (home && result == RIC_SIDE && node->n_departure > 3 && (r - node->cycle->pure) / node->cycle->N % 2)
        result = RIC_IMAGE_SIDE;
    ric_periodic_free(repeated);
    ric_periodic_free(home);
    return result;
}

/* ------------------------------------------------------------- the ways out */

ric_periodic *ric_node_regular(const ric_model *m, const ric_node *node)
{
    return node->kind == RIC_KIND_GRAZING ? ric_grazing_words_cycle(m, node, 0) : ric_periodic_copy(node->cycle);
}

int ric_node_impacts(const ric_node *node, unsigned choice)
{
    int count = ric_periodic_impacts(node->springs, node->cycle), missing = 0;
    if (node->kind == RIC_KIND_MULTIPLICATION && choice != RIC_THROUGH) return count * node->multiple;
    if (node->kind != RIC_KIND_GRAZING) return count;
    for (int i = 0; i < node->n_touch * node->multiple; i++) missing += !(choice & 1u << i);
    return count * node->multiple - missing;
}

bool ric_node_half(const ric_model *m, const ric_node *node, unsigned choice)
{
    ric_periodic *c = ric_node_chooses(node) ? ric_grazing_words_cycle(m, node, choice)
                                             : ric_periodic_copy(node->cycle);
    bool half = c && c->half && !ric_node_leaves(node, choice);
    ric_periodic_free(c);
    return ric_node_leaves(node, choice) ? ric_node_problem(node, choice).half : half;
}

bool ric_node_leaves(const ric_node *node, unsigned choice)
{
    return !ric_node_chooses(node) && choice != RIC_THROUGH;
}

ric_symmetry ric_node_problem(const ric_node *node, unsigned choice)
{
    const ric_periodic *c = node->cycle;
    ric_symmetry problems[2] = {{.copies = 1, .half = c->half, .pure = c->pure, .flip = c->flip}};
    if (node->kind == RIC_KIND_MULTIPLICATION) {
        ric_symmetry_multiplying(c, node->rotation[0], node->rotation[1], problems);
        if (choice == RIC_IMAGE_SIDE) problems[0].pure = (c->pure + c->N) % (c->N * node->multiple);
        return problems[choice == RIC_OTHER_SIDE];
    }
    return node->test == RIC_TEST_DET ? problems[0] : ric_symmetry_breaking(c, node->test);
}

/* Whether the two halves of a side branch are mirror images in x -> -x and nothing else takes one to the other: in a
 * structure that lacks this symmetry they are different motions, and the branch is one curve through both. */
static bool splits(const ric_node *node)
{
    const ric_periodic *c = node->cycle;
    return !node->mirrors && (c->half || c->flip >= 0) &&
           (c->pure < 0 || ric_symmetry_breaking(c, node->test).pure >= 0);
}

bool ric_node_passes(const ric_node *node, unsigned choice)
{
    if (!ric_node_leaves(node, choice)) return !ric_node_chooses(node);
    if (node->kind == RIC_KIND_MULTIPLICATION)
        return ric_symmetry_passes(node->cycle, node->rotation[0], node->rotation[1]) ||
               (choice == RIC_SIDE && has_image(node) && node->multiple % 2);
    return node->test == RIC_TEST_DET || splits(node);
}
