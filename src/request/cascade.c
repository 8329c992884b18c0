/* Cascades of period multiplications, followed on request (docs/theory.md section 8). From an orbit
 * whose multipliers are roots of unity the family of q periods is traced to its next such orbit,
 * which is solved on its own equations, and so on. Everything costs O(impacts): the trace, the
 * junction and the departure. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "atlas/room.h"
#include "junction/room.h"
#include "model/room.h"
#include "base/room.h"
#include "stored.h"
#include "branch/room.h"

#define MAX_POINTS 20000
/* PART: first largest step on a family, of the length of the one before: doublings shrink by 4 from
 * one to the next */
#define PART 0.1
#define GROWTH 1.2      /* of that step from point to point, back to that of the study */
#define LEAST_STEP 1e-9 /* below this part of the orbit its digits do not tell neighbours apart */
/* LATER: of a mean flight: so much longer than the period the simulator runs, to meet the last
 * impact */
#define LATER 1e-7
#define TOUCH 1e-6 /* scaled speed below which the simulator's impact is a touch */

/* One multiplication, or the end. */
typedef struct {
    ric_node *node;          /* NULL at an end that is no junction */
    ric_periodic *orbit;     /* without touches */
    ric_continuation *trace; /* of the family followed to it; NULL for the first */
    int n_point;             /* of the trace, up to here */
    int multiple, p, grazings;
    ric_stop stop;
    double energy, frequency, residual, return_error, ratio;
    double *state, *flights;
    int *word;
} stage;

struct ric_cascade {
    const ric_model *model; /* borrowed from the atlas */
    ric_limits limits;
    const ric_cascade_options *options;
    double study_step;
    int n, room;
    stage *stages;   /* [room] */
    int deepest;     /* multiplications found on the best attempt */
    char where[160]; /* why it went no further */
};

static void stage_clear(stage *s)
{
    ric_node_free(s->node);
    ric_periodic_free(s->orbit);
    ric_continuation_free(s->trace);
    free(s->state);
    free(s->flights);
    free(s->word);
    *s = (stage){0};
}

void ric_cascade_free(ric_cascade *c)
{
    if (!c) return;
    for (int i = 0; i < c->n; i++) stage_clear(&c->stages[i]);
    free(c->stages);
    free(c);
}

/* ------------------------------------------------------------------ one orbit */

static double state_distance(int size, const double *a, const double *b)
{
    double sum = 0, norm = 0;
    for (int i = 0; i < size; i++) {
        sum += (a[i] - b[i]) * (a[i] - b[i]);
        norm += b[i] * b[i];
    }
    return sqrt(sum) / (1 + sqrt(norm));
}

/* Under a power law there are no impacts on the way. */
static ric_status integrate(const ric_model *m, const ric_periodic *orbit, const double *state,
                            double *error)
{
    ric_simulator *sim = NULL;
    ric_impact impact;
    bool hit;
    int n = m->n_dof;
    double back[2 * n];
    ric_status status = ric_simulator_create(m, &sim);
    if (!status) status = ric_simulator_start(sim, state, state + n);
    if (!status)
        status = ric_simulator_advance(sim, ric_periodic_period(orbit) / m->omega_ref, &hit,
                                       &impact);
    if (!status) {
        ric_simulator_state(sim, NULL, back, back + n);
        *error = state_distance(2 * n, back, state);
    }
    ric_simulator_free(sim);
    return status;
}

/* One period on the simulator, which knows nothing of the word: how far the state is from the
 * start; NaN where the faces differ. */
static ric_status simulate(const ric_model *m, const ric_periodic *orbit, const double *state,
                           double *error)
{
    ric_simulator *sim = NULL;
    ric_impact impact;
    int n = m->n_dof, found = 0;
    double back[2 * n], period = ric_periodic_period(orbit) / m->omega_ref,
                        margin = LATER * period / orbit->N;
    ric_status status = ric_simulator_create(m, &sim);
    bool hit = true, agree = true;
    if (!status) status = ric_simulator_start(sim, state, state + n);
    /* a little longer than the period: the last impact is the first one again */
    uint64_t closed = orbit->closed, springs = ric_periodic_springs(m);
    while (!status && hit && agree && found < orbit->N) {
        if ((status = ric_simulator_advance(sim, period + margin, &hit, &impact)) || !hit) break;
        /* the state lies on the face of event 0, which may be met again at once */
        if (fabs(impact.approach) < TOUCH || (found == 0 && impact.time < margin)) continue;
        found++;
        agree = impact.face == orbit->face[found % orbit->N] &&
                impact.opens == ric_face_in(closed, impact.face);
        if (ric_face_in(springs, impact.face)) closed ^= (uint64_t)1 << impact.face;
    }
    *error = NAN;
    if (!status && agree && found == orbit->N) {
        ric_simulator_state(sim, NULL, back, back + n);
        *error = state_distance(2 * n, back, state) + fabs(impact.time - period) / period;
    }
    ric_simulator_free(sim);
    return status;
}

static ric_status measure(const ric_model *m, stage *s)
{
    ric_shooting *chain = NULL;
    double *u = NULL;
    int N = s->orbit->N;
    s->state = ric_calloc(2 * (size_t)m->n_dof, sizeof *s->state);
    s->flights = ric_calloc((size_t)N + 1, sizeof *s->flights);
    s->word = ric_calloc((size_t)N + 1, sizeof *s->word);
    if (!s->state || !s->flights || !s->word) return ric_no_memory("a cascade");
    ric_periodic_word(m, s->orbit, s->word);
    ric_model_to_state(m, s->orbit->w, s->state, s->state + m->n_dof);
    ric_periodic_flights(m, s->orbit, s->flights);
    s->energy = ric_periodic_energy(m, s->orbit) * m->energy_unit;
    s->frequency = RIC_TWO_PI / ric_periodic_period(s->orbit) * m->omega_ref;
    ric_status status = ric_periodic_to_chain(m, s->orbit, &chain, &u);
    if (!status) {
        ric_shooting_fly(chain, u);
        s->residual = chain->residual;
        status = ric_periodic_has_events(m) ? simulate(m, s->orbit, s->state, &s->return_error)
                                            : integrate(m, s->orbit, s->state, &s->return_error);
    }
    ric_shooting_free(chain);
    free(u);
    return status;
}

/* ---------------------------------------------------------------- the family */

static bool stopped(const ric_cascade *c, const ric_continuation *tr)
{
    int impacts = tr->chain->n_flight * tr->chain->multiple;
    return c->options->progress &&
           c->options->progress(c->n, impacts, tr->n_point, c->options->user);
}

static bool wanted(const ric_cascade *c, int level, const ric_continuation *tr, int event)
{
    const ric_resonance *r = ric_continuation_resonance(tr, tr->events[event].test);
    if (level >= c->options->n || !r) return false;
    int q = c->options->multiple[level], p = c->options->rotation ? c->options->rotation[level] : 0;
    /* over half a period p and q - p differ, over a period they are one */
    return r->q == q && (p == 0 || r->p == p || (!ric_shooting_halves(tr->chain) && r->p == q - p));
}

/* Steps until an event of the next multiplicity (*event, from `first` on), or the end (*event =
 * -1). */
static ric_status advance(ric_cascade *c, ric_continuation *tr, int level, int first, bool *done,
                          int *event)
{
    ric_status status = RIC_OK;
    *event = -1;
    for (int looked = first;;) {
        for (; looked < tr->n_event && *event < 0; looked++)
            if (wanted(c, level, tr, looked)) *event = looked;
        if (*event >= 0 || *done) return RIC_OK;
        if (stopped(c, tr)) return ric_fail(RIC_E_INTERRUPTED, "stopped on request");
        if ((status = ric_continuation_advance(tr, done))) return status;
        c->limits.max_step = fmin(c->study_step, GROWTH * c->limits.max_step);
    }
}

/* The multiplication by q at an orbit, which is taken over, as the next stage; *found = false where
 * it does not converge. */
static ric_status add_multiplication(ric_cascade *c, ric_periodic *cycle, int p, int q, bool *found)
{
    ric_node *node = NULL;
    if (!cycle) return ric_no_memory("a cascade");
    ric_status status = ric_node_multiplication(c->model, cycle, p, q, &node);
    ric_periodic_free(cycle);
    *found = !status;
    if (status) return status == RIC_E_NUMERIC ? RIC_OK : status;
    stage *s = &c->stages[c->n++];
    *s = (stage){.node = node,
                 .orbit = ric_periodic_copy(node->cycle),
                 .multiple = q,
                 .p = node->rotation[0],
                 .ratio = NAN};
    return s->orbit ? measure(c->model, s) : ric_no_memory("a cascade");
}

static ric_status add_event(ric_cascade *c, const ric_continuation *tr, int event, bool *found)
{
    const ric_resonance *r = ric_continuation_resonance(tr, tr->events[event].test);
    return add_multiplication(c, ric_continuation_cycle(tr, tr->events[event].u), r->p, r->q,
                              found);
}

/* Where the last family ends. */
static ric_status add_end(ric_cascade *c, ric_continuation *tr)
{
    ric_periodic *cycle = NULL;
    ric_node *node = NULL;
    ric_status status = RIC_OK;
    stage *s = &c->stages[c->n];
    *s = (stage){.multiple = 1, .stop = tr->stop, .ratio = NAN};
    c->n++;
    if (!(cycle = ric_continuation_cycle(tr, tr->end.u ? tr->end.u : tr->now.u)))
        return ric_no_memory("a cascade");
    if (tr->stop == RIC_STOP_JUNCTION && tr->end.u && !tr->arrival &&
        tr->end.test != RIC_TEST_FLIGHT) {
        status = ric_node_grazing(c->model, cycle, &node);
        if (status == RIC_E_NUMERIC) status = RIC_OK;
    }
    s->node = node;
    s->grazings = node ? node->n_touch * node->multiple : 0;
    s->orbit = node ? ric_node_regular(c->model, node) : cycle;
    if (node) ric_periodic_free(cycle);
    return status ? status : s->orbit ? measure(c->model, s) : ric_no_memory("a cascade");
}

/* ------------------------------------------------------------------ the search */

static ric_status descend(ric_cascade *c, bool *found);

static void remember(ric_cascade *c, const ric_continuation *tr)
{
    if (c->n < c->deepest) return;
    c->deepest = c->n;
    snprintf(c->where, sizeof c->where,
             "the families that leave there were followed to their ends (the last: %s%s%s)",
             ric_stop_text(tr->stop), tr->why ? ", " : "", ric_continuation_why_text(tr->why));
}

/* Takes over `tr`, which goes to the stage that completes; every multiplication on the way is
 * tried. */
static ric_status search_along(ric_cascade *c, ric_continuation *tr, bool keep, bool *found)
{
    ric_status status = RIC_OK;
    int level = c->n, event = -1;
    bool done = false, last = level == c->options->n;
    while (!status && !*found) {
        if ((status = advance(c, tr, level, event + 1, &done, &event))) break;
        if (event < 0 && !last) break;
        bool good = true;
        status = last ? add_end(c, tr) : add_event(c, tr, event, &good);
        if (status || !good) continue;
        stage *s = &c->stages[level];
        s->n_point = last || !keep ? tr->n_point
                                   : ric_continuation_points_until(tr, tr->events[event].s);
        double step = c->limits.max_step;
        if (keep && !last)
            c->limits.max_step = fmax(LEAST_STEP, fmin(c->study_step, PART * tr->events[event].s /
                                                                          tr->chain->scale));
        if (last) *found = true;
        else status = descend(c, found);
        c->limits.max_step = step;
        if (*found && keep) {
            s->trace = tr;
            return status;
        }
        if (*found) s->n_point = 0;
        else if (c->n > level) stage_clear(&c->stages[--c->n]);
    }
    if (!*found) remember(c, tr);
    ric_continuation_free(tr);
    return status == RIC_E_NUMERIC ? RIC_OK : status;
}

/* The first step, along t, is no longer than any other. */
static void shorten(double max_step, ric_outset *from)
{
    const int size = from->chain->n_unknown;
    double norm = sqrt(ric_dot(size, from->t, from->t)), most = max_step * from->chain->scale;
    for (int i = 0; norm > most && i < size; i++) from->t[i] *= most / norm;
}

/* One family of the last multiplication, in one direction. */
static ric_status search_family(ric_cascade *c, unsigned choice, int side, bool *found)
{
    const ric_node *node = c->stages[c->n - 1].node;
    ric_outset from;
    ric_continuation *tr = NULL;
    ric_status status = ric_switching_depart(c->model, node, choice, side, &from);
    if (!status && from.chain) {
        if (!ric_multiplication_applies(node, choice)) shorten(c->limits.max_step, &from);
        status = ric_outset_trace(&from, &c->limits, &tr);
    }
    if (status && c->n >= c->deepest) {
        c->deepest = c->n;
        snprintf(c->where, sizeof c->where, "%.150s", ric_detail());
    }
    if (!status && tr) status = search_along(c, tr, true, found);
    return status == RIC_E_NUMERIC ? RIC_OK : status;
}

/* From the last multiplication found: done, or through every family that leaves it. */
static ric_status descend(ric_cascade *c, bool *found)
{
    const stage *here = &c->stages[c->n - 1];
    ric_status status = RIC_OK;
    int level = c->n;
    double step = c->limits.max_step;
    if (level == c->options->n && !c->options->to_end) {
        *found = true;
        return RIC_OK;
    }
    for (int i = 0; i < here->node->n_departure && !status && !*found; i++) {
        unsigned choice = here->node->departures[i].choice;
        if (!ric_node_leaves(here->node, choice)) continue;
        for (int side = 1;
             side >= (ric_node_passes(here->node, choice) ? -1 : 1) && !status && !*found;
             side -= 2) {
            c->limits.max_step = step;
            status = search_family(c, choice, side, found);
        }
    }
    return status;
}

/* The branch of the atlas, from the middle of its stored points both ways. */
static ric_status search_branch(ric_cascade *c, const ric_atlas *a, const ric_branch *b,
                                bool *found)
{
    ric_periodic *cycle = NULL;
    ric_point point;
    ric_status status = ric_stored_cycle(a, b, b->n_point / 2, &point, &cycle);
    if (!status) status = ric_stored_symmetries(a, b, b->n_point / 2, cycle);
    for (int side = 1; side >= -1 && !status && !*found; side -= 2) {
        ric_shooting *chain = NULL;
        ric_continuation *tr = NULL;
        double *u = NULL, *t = NULL;
        status = ric_stored_chain(c->model, b, b->n_point / 2, cycle, &chain, &u);
        if (!status && !(t = ric_calloc((size_t)chain->n_unknown, sizeof *t)))
            status = ric_no_memory("a cascade");
        if (!status) {
            ric_shooting_evaluate(chain, u);
            ric_continuation_tangent(chain, NULL, t);
            for (int i = 0; side < 0 && i < chain->n_unknown; i++) t[i] = -t[i];
            status = ric_continuation_create(chain, u, t, 0, &c->limits, &tr);
            chain = NULL;
        }
        if (!status) status = search_along(c, tr, false, found);
        ric_shooting_free(chain);
        free(u);
        free(t);
    }
    ric_periodic_free(cycle);
    return status;
}

/* The stored point next to an arclength. */
static int point_at(const ric_atlas *a, const ric_branch *b, double arclength)
{
    double least = INFINITY;
    int best = 0;
    ric_point p;
    for (int i = 0; i < b->n_point && !ric_atlas_point(a, b->id, i, &p, NULL, NULL); i++)
        if (fabs(p.arclength - arclength) < least) {
            least = fabs(p.arclength - arclength);
            best = i;
        }
    return best;
}

/* Steps from the middle may pass two multiplications that lie close together: from those that the
 * atlas has. */
static ric_status search_junctions(ric_cascade *c, const ric_atlas *a, const ric_branch *b,
                                   bool *found)
{
    const int q = c->options->multiple[0], p = c->options->rotation ? c->options->rotation[0] : 0;
    ric_status status = RIC_OK;
    for (int k = 0; k < b->n_junction && !status && !*found; k++) {
        const int i = point_at(a, b, b->junction_at[k]);
        ric_periodic *cycle = NULL;
        ric_junction j;
        ric_point point;
        bool good;
        if ((status = ric_atlas_junction(a, b->junctions[k], &j))) break;
        if (j.kind != RIC_KIND_MULTIPLICATION || j.multiple != q ||
            (p && p != j.rotation[0] && p != q - j.rotation[0]))
            continue;
        if (!(status = ric_stored_cycle(a, b, i, &point, &cycle)))
            status = ric_stored_symmetries(a, b, i, cycle);
        if (status) ric_periodic_free(cycle);
        else status = add_multiplication(c, cycle, j.rotation[0], q, &good);
        if (status || !good) continue;
        status = descend(c, found);
        if (!*found && c->n) stage_clear(&c->stages[--c->n]);
    }
    return status;
}

/* ------------------------------------------------------------------- the whole */

/* At a doubling of an orbit with z(t+T/2) = -z(t) a symmetry is lost with the period: it is not of
 * the same kind as the others. */
static void set_ratios(ric_cascade *c)
{
    for (int i = 2; i < c->n; i++) {
        bool doublings = true;
        for (int k = i - 2; k <= i; k++)
            doublings &= c->stages[k].multiple == 2 && !c->stages[k].orbit->half;
        double last = c->stages[i].energy - c->stages[i - 1].energy,
               before = c->stages[i - 1].energy - c->stages[i - 2].energy;
        if (doublings) c->stages[i].ratio = before / last;
    }
}

static ric_status check_request(const ric_model *m, const ric_branch *b,
                                const ric_cascade_options *o)
{
    if (ric_branch_linear(m, b))
        return ric_fail(RIC_E_RANGE,
                        "branch %d is a linear mode, which nothing multiplies; choose %s", b->id,
                        ric_model_detached(m) ? "a branch with impacts" : "another one");
    if (o->n < 1) return ric_fail(RIC_E_INPUT, "a cascade needs one multiplication at least");
    for (int i = 0; i < o->n; i++)
        if (o->multiple[i] < 2 || o->multiple[i] > 64)
            return ric_fail(RIC_E_INPUT, "multiplicity %d: it must be a whole number from 2 to 64",
                            o->multiple[i]);
    return RIC_OK;
}

ric_status ric_cascade_follow(const ric_atlas *a, int branch, const ric_cascade_options *o,
                              ric_cascade **out)
{
    const ric_explore_options *e = ric_study_options(ric_atlas_study(a));
    ric_branch b;
    bool found = false;
    int largest = 2;
    *out = NULL;
    ric_status status = ric_atlas_branch(a, branch, &b);
    if (status || (status = check_request(ric_atlas_model(a), &b, o))) return status;
    ric_cascade *c = ric_calloc(1, sizeof *c);
    if (!c || !(c->stages = ric_calloc((size_t)o->n + 1, sizeof *c->stages))) {
        ric_cascade_free(c);
        return ric_no_memory("a cascade");
    }
    for (int i = 0; i < o->n; i++) largest = o->multiple[i] > largest ? o->multiple[i] : largest;
    c->model = ric_atlas_model(a);
    c->options = o;
    c->study_step = e->max_step;
    c->limits = ric_continuation_limits(c->model, e->energy, (double[]){0, e->frequency[1]},
                                        e->max_step, MAX_POINTS);
    c->limits.multiply = largest;
    status = search_branch(c, a, &b, &found);
    if (!status && !found && !c->deepest) status = search_junctions(c, a, &b, &found);
    if (!status && !found)
        status = ric_fail(
            RIC_E_RANGE, "no such cascade from branch %d: %d of %d multiplications were found; %s",
            branch, c->deepest, o->n,
            c->deepest ? c->where
                       : "the branch has none by that number, or not where its orbits are motions");
    c->options = NULL;
    if (status) {
        ric_cascade_free(c);
        return status;
    }
    set_ratios(c);
    *out = c;
    return RIC_OK;
}

/* ------------------------------------------------------------------- interface */

int ric_cascade_length(const ric_cascade *c)
{
    return c->n;
}

static ric_status check_step(const ric_cascade *c, int step)
{
    if (step >= 0 && step < c->n) return RIC_OK;
    return ric_fail(RIC_E_RANGE, "no step %d: the cascade has steps 0 to %d", step, c->n - 1);
}

ric_status ric_cascade_step_at(const ric_cascade *c, int step, ric_cascade_step *out)
{
    ric_status status = check_step(c, step);
    if (status) return status;
    const stage *s = &c->stages[step];
    *out = (ric_cascade_step){.multiple = s->multiple,
                              .rotation = {s->p, s->p ? s->multiple : 0},
                              .impacts = ric_periodic_impacts(ric_periodic_springs(c->model),
                                                              s->orbit),
                              .letters = ric_periodic_letters(s->orbit),
                              .word = s->word,
                              .symmetric = s->orbit->half,
                              .grazings = s->grazings,
                              .stop = s->stop,
                              .energy = s->energy,
                              .frequency = s->frequency,
                              .residual = s->residual,
                              .return_error = s->return_error,
                              .ratio = s->ratio,
                              .state = s->state,
                              .flights = s->flights,
                              .n_point = s->n_point};
    return RIC_OK;
}

/* Periods of the branch in one of the family followed to a step. */
static int periods_to(const ric_cascade *c, int step)
{
    int product = 1;
    for (int i = 0; i < step; i++) product *= c->stages[i].multiple;
    return product;
}

int ric_cascade_impacts(const ric_cascade *c, int step)
{
    if (step < 0 || step >= c->n || !c->stages[step].trace) return 0;
    if (!ric_periodic_has_events(c->model)) return periods_to(c, step);
    ric_continuation *tr = c->stages[step].trace;
    ric_periodic *cycle = ric_continuation_cycle(tr,
                                                 (const double *)(ric_continuation_row(tr, 0) + 1));
    int N = cycle ? cycle->N : 0;
    ric_periodic_free(cycle);
    return N;
}

ric_status ric_cascade_point(const ric_cascade *c, int step, int i, ric_point *point, double *x)
{
    ric_status status = check_step(c, step);
    if (status) return status;
    const stage *s = &c->stages[step];
    if (i < 0 || i >= s->n_point)
        return ric_fail(RIC_E_RANGE, "no point %d: the family followed to step %d has %d points", i,
                        step, s->n_point);
    const ric_point *p = ric_continuation_row(s->trace, i);
    if (point) *point = *p;
    if (!x) return RIC_OK;
    int n = c->model->n_dof;
    ric_periodic *cycle = ric_continuation_cycle(s->trace, (const double *)(p + 1));
    if (cycle && !ric_periodic_divide(c->model, cycle, periods_to(c, step))) {
        ric_periodic_free(cycle);
        cycle = NULL;
    }
    double *W = cycle ? ric_calloc((size_t)cycle->N * 2 * (size_t)c->model->n, sizeof *W) : NULL,
           v[n];
    if (W) {
        ric_periodic_states(c->model, cycle, W);
        for (int k = 0; k < cycle->N; k++)
            ric_model_to_state(c->model, W + (size_t)k * 2 * (size_t)c->model->n,
                               x + (size_t)k * (size_t)n, v);
    } else status = ric_no_memory("a cascade");
    free(W);
    ric_periodic_free(cycle);
    return status;
}

void ric_cascade_at_time(const ric_cascade *c, int step, double t, double *x, double *v)
{
    const ric_model *m = c->model;
    double w[2 * m->n];
    ric_periodic_at_time(m, c->stages[step].orbit, t * m->omega_ref, w);
    ric_model_to_state(m, w, x, v);
}
