#include <stdlib.h>
#include <string.h>

#include "atlas/room.h"
#include "model/room.h"
#include "orbit/room.h"
#include "base/room.h"
#include "stored.h"
#include "branch/room.h"
#include "junction/room.h"

/* The ghost continuation of a branch (docs/theory.md section 6): the same chain, traced on from a
 * stored end past the grazing. The orbit problem is regular there, since no impact speed is divided
 * by; only the margins change sign. */

/* RESONATES: distance of lambda + 1/lambda from that of a root of unity at which an event is a
 * multiplication */
#define RESONATES 1e-6
#define MAX_POINTS 2000 /* of one ghost; a branch of the examples has at most a few hundred */
/* TOUCH: margin, scaled, below which it counts as zero; at a stored end it is 1e-10 at most */
#define TOUCH 1e-9
/* INSIDE: arclength from the end at which a stored point tells the direction of the branch */
#define INSIDE 1e-6

struct ric_ghost {
    const ric_model *model; /* borrowed from the atlas */
    ric_limits limits;
    ric_continuation *trace;
    ric_turn turn;
    double origin; /* arclength of the end */
    ric_ghost_data data;
};

static void ghost_free(ric_ghost *g)
{
    if (!g) return;
    ric_continuation_free(g->trace);
    free(g);
}

void ric_ghosts_free(int n, ric_ghost **ghosts)
{
    for (int i = 0; ghosts && i < n; i++) ghost_free(ghosts[i]);
    free(ghosts);
}

void ric_ghost_limits_init(const ric_atlas *a, ric_ghost_limits *limits)
{
    const ric_explore_options *o = ric_study_options(ric_atlas_study(a));
    *limits = (ric_ghost_limits){.energy = {o->energy[0], o->energy[1]},
                                 .frequency = {o->frequency[0], o->frequency[1]},
                                 .max_points = MAX_POINTS};
}

bool ric_point_admissible(const ric_point *p)
{
    return !(p->reach >= 1 - TOUCH) &&
           !(p->approach <= TOUCH); /* either may be NaN: nothing to violate */
}

/* ------------------------------------------------------------------- start */

/* Whether the branch stops there only because its orbits cease to be motions. */
static bool grazes(const ric_atlas *a, const ric_branch *b, ric_end end)
{
    ric_junction junction;
    int id = end == RIC_END_FROM ? b->from : b->to;
    if (b->impacts == 0 || b->n_point < 2 || id == 0 || ric_atlas_junction(a, id, &junction))
        return false;
    return junction.kind == RIC_KIND_GRAZING || junction.kind == RIC_KIND_CORNER;
}

static bool inside(const ric_ghost_limits *l, const ric_point *p)
{
    double slack = RIC_TIE; /* an end may lie on the border of the window */
    return p->energy >= l->energy[0] - slack * p->energy &&
           p->energy <= l->energy[1] * (1 + slack) &&
           p->frequency >= l->frequency[0] * (1 - slack) &&
           p->frequency <= l->frequency[1] * (1 + slack);
}

/* The stored point nearest to the end that is far enough from it to tell the direction. */
static ric_status find_neighbour(const ric_atlas *a, const ric_branch *b, ric_end end,
                                 int *neighbour)
{
    int tip = end == RIC_END_FROM ? 0 : b->n_point - 1, step = end == RIC_END_FROM ? 1 : -1,
        last = b->n_point - 1 - tip;
    ric_point p, q;
    ric_status status = ric_atlas_point(a, b->id, tip, &p, NULL, NULL);
    for (*neighbour = tip + step; !status && *neighbour != last; *neighbour += step) {
        status = ric_atlas_point(a, b->id, *neighbour, &q, NULL, NULL);
        if (!status && fabs(q.arclength - p.arclength) > INSIDE) break;
    }
    return status;
}

/* The end of the branch, and the direction that leads out. */
static ric_status start_at_end(const ric_atlas *a, const ric_branch *b, ric_end end, ric_ghost *g,
                               ric_outset *out)
{
    const ric_model *m = g->model;
    ric_periodic *tip = NULL, *near = NULL;
    ric_shooting *other = NULL;
    ric_point at, beside;
    int neighbour, last = end == RIC_END_FROM ? 0 : b->n_point - 1;
    ric_status status = find_neighbour(a, b, end, &neighbour);
    if (!status) status = ric_stored_cycle(a, b, last, &at, &tip);
    if (!status) status = ric_stored_cycle(a, b, neighbour, &beside, &near);
    /* looked for beside the end, where the orbit may have gained some */
    if (!status) status = ric_stored_symmetries(a, b, neighbour, near);
    if (status) goto out;
    ric_periodic_take_symmetries(tip, near);
    if ((status = ric_stored_chain(m, b, neighbour, near, &other, &out->t)) ||
        (status = ric_stored_chain(m, b, last, tip, &out->chain, &out->u)))
        goto out;
    if (!ric_turn_find(m, other, out->t, near, &g->turn))
        status = ric_fail(RIC_E_NUMERIC,
                          "a stored orbit of branch %d does not fit its own symmetries", b->id);
    for (int i = 0; i < out->chain->n_unknown; i++) out->t[i] = out->u[i] - out->t[i];
    g->origin = at.arclength;
out:
    ric_shooting_free(other);
    ric_periodic_free(tip);
    ric_periodic_free(near);
    return status;
}

/* ------------------------------------------------------------------ tracing */

static const ric_point *row(const ric_ghost *g, int i)
{
    return ric_continuation_row(g->trace, i);
}

/* What the tracer says of branches, said of a ghost. */
static void describe(ric_ghost *g, ric_end end)
{
    const ric_continuation *tr = g->trace;
    g->data = (ric_ghost_data){.end = end,
                               .n_point = tr->n_point,
                               .again = -1,
                               .stop = tr->stop,
                               .why = ric_continuation_why_text(tr->why)};
    if (tr->arrival) {
        g->data.why = "it meets its own mirror image";
        g->data.n_point--; /* the last one is read off beside a branch point, not solved; no
                              junction is solved there */
    } else if (tr->now.test[RIC_TEST_FLIGHT] <= 0 || tr->end.test == RIC_TEST_FLIGHT) {
        g->data.stop = RIC_STOP_CORNER;
        g->data.why = "two impacts come together; beyond, the time between them is negative";
    } else if (tr->stop == RIC_STOP_BUDGET) g->data.why = "largest number of points of a ghost";
    for (int i = 1; i < g->data.n_point && g->data.again < 0; i++)
        if (ric_point_admissible(row(g, i))) g->data.again = i;
}

static ric_status ghost_create(const ric_atlas *a, const ric_branch *b, ric_end end,
                               const ric_ghost_limits *limits, ric_ghost **out)
{
    /* what is zero at the very end, or has a pole there, is no event of the first step */
    const unsigned ignore = 1u << RIC_TEST_DET | 1u << RIC_TEST_SLOPE | 1u << RIC_TEST_PERIOD |
                            1u << RIC_TEST_A | 1u << RIC_TEST_B | 1u << RIC_TEST_D;
    ric_outset from = {.ignore = ignore};
    ric_ghost *g = ric_calloc(1, sizeof *g);
    *out = NULL;
    if (!g) return ric_no_memory("a ghost");
    g->model = ric_atlas_model(a);
    g->limits = ric_continuation_limits(g->model, limits->energy, limits->frequency,
                                        ric_study_options(ric_atlas_study(a))->max_step,
                                        limits->max_points);
    g->limits.ghost = true;
    g->limits.multiply = limits->multiply;
    ric_status status = start_at_end(a, b, end, g, &from);
    if (!status) status = ric_outset_trace(&from, &g->limits, &g->trace);
    /* at a corner the time between two impacts may be zero already */
    if (!status && g->trace->now.test[RIC_TEST_FLIGHT] > 0) status = ric_continuation_run(g->trace);
    if (!status) {
        describe(g, end);
        *out = g;
        g = NULL;
    }
    ric_outset_clear(&from);
    ghost_free(g);
    return status;
}

/* ---------------------------------------------------------------- interface */

ric_status ric_ghost_find(const ric_atlas *a, int branch, const ric_ghost_limits *limits, int *n,
                          ric_ghost ***out)
{
    if (!ric_flight_law_of(ric_atlas_model(a))->turns)
        return ric_fail(
            RIC_E_INPUT,
            "ghosts are traced on rigid contacts only: beyond a grazing a contact of law "
            "bilinear would last a negative time");
    ric_branch b;
    ric_status status = ric_atlas_branch(a, branch, &b);
    *n = 0;
    *out = NULL;
    if (status) return status;
    ric_ghost **list = ric_calloc(2, sizeof *list);
    if (!list) return ric_no_memory("a ghost");
    for (ric_end end = RIC_END_FROM; end <= RIC_END_TO && !status; end++) {
        ric_point tip;
        if (!grazes(a, &b, end)) continue;
        status = ric_atlas_point(a, branch, end == RIC_END_FROM ? 0 : b.n_point - 1, &tip, NULL,
                                 NULL);
        if (!status && inside(limits, &tip) &&
            !(status = ghost_create(a, &b, end, limits, &list[*n])))
            (*n)++;
    }
    if (status) {
        ric_ghosts_free(*n, list);
        *n = 0;
        return status;
    }
    *out = list;
    return RIC_OK;
}

void ric_ghost_describe(const ric_ghost *g, ric_ghost_data *out)
{
    *out = g->data;
}

static ric_status check_point(const ric_ghost *g, int i)
{
    if (i >= 0 && i < g->data.n_point) return RIC_OK;
    return ric_fail(RIC_E_RANGE, "no point %d: the ghost has points 0 to %d", i,
                    g->data.n_point - 1);
}

ric_status ric_ghost_point(const ric_ghost *g, int i, ric_point *point, double *state,
                           double *flights)
{
    ric_status status = check_point(g, i);
    if (status) return status;
    const ric_point *p = row(g, i);
    if (point) {
        *point = *p;
        point->arclength = g->origin + (g->data.end == RIC_END_FROM ? -1 : 1) * p->arclength;
    }
    if (!state && !flights) return RIC_OK;
    return ric_turn_write(g->model, g->trace->chain, (const double *)(p + 1), &g->turn, state,
                          state ? state + g->model->n_dof : NULL, flights);
}

/* Whether the multipliers are there at an event. On a ghost impact speeds pass through zero, and
 * lambda + 1/lambda through a pole. */
static bool resonates(const ric_ghost *g, const ric_event *event)
{
    const ric_resonance *resonance = ric_continuation_resonance(g->trace, event->test);
    ric_floquet *f = &g->trace->floquet;
    bool found = false;
    if (!resonance) return false;
    ric_shooting_evaluate(g->trace->chain, event->u);
    if (ric_floquet_compute(g->trace->chain, f)) return false;
    for (int i = 0; i < f->n_pair; i++)
        found |= hypot(f->own[2 * i] - resonance->rho, f->own[2 * i + 1]) < RESONATES;
    return found;
}

static const ric_event *resonance_event(const ric_ghost *g, int i)
{
    for (int k = 0; k < g->trace->n_event; k++)
        if (resonates(g, &g->trace->events[k]) && i-- == 0) return &g->trace->events[k];
    return NULL;
}

int ric_ghost_n_multiplication(const ric_ghost *g)
{
    int n = 0;
    while (resonance_event(g, n)) n++;
    return n;
}

ric_status ric_ghost_multiplication_at(const ric_ghost *g, int i, ric_ghost_multiplication *out)
{
    const ric_event *event = i < 0 ? NULL : resonance_event(g, i);
    ric_shooting *c = g->trace->chain;
    if (!event)
        return ric_fail(RIC_E_RANGE, "no multiplication %d on the ghost: there are %d", i,
                        ric_ghost_n_multiplication(g));
    const ric_resonance *resonance = ric_continuation_resonance(g->trace, event->test);
    ric_shooting_fly(c, event->u);
    const ric_margins margins = ric_continuation_margins(c, event->u);
    const ric_point p = {.reach = margins.reach, .approach = margins.approach};
    *out = (ric_ghost_multiplication){.rotation = {resonance->p, resonance->q},
                                      .arclength = g->origin +
                                                   (g->data.end == RIC_END_FROM ? -1 : 1) *
                                                       event->s,
                                      .energy = margins.energy * g->model->energy_unit,
                                      .frequency = RIC_TWO_PI / margins.time * g->model->omega_ref,
                                      .admissible = ric_point_admissible(&p)};
    return RIC_OK;
}

ric_status ric_ghost_multipliers(const ric_ghost *g, int i, double *out)
{
    ric_status status = check_point(g, i);
    if (status) return status;
    ric_shooting_evaluate(g->trace->chain, (const double *)(row(g, i) + 1));
    if (!(status = ric_floquet_compute(g->trace->chain, &g->trace->floquet)))
        ric_floquet_multipliers(&g->trace->floquet, out);
    return status;
}
