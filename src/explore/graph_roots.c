/* Where an exploration begins: the grazings of the modes, the closed form of a loose mass, orbits
 * given from outside. */
#include <stdlib.h>
#include <string.h>

#include "graph_parts.h"
#include "loose.h"
#include "model/room.h"
#include "base/room.h"

/* ABOVE: part by which a start lies above the lower edge of the window, at least: where two modes
 * of nearly one frequency mix, energies of orbits are known to 1e-5 of themselves */
#define ABOVE 1e-3
#define UNMOVED 1e-9 /* share of a force that counts as none */
#define STILL 1e-9   /* scaled amplitude at which no power law with an exponent from 3 on is felt */
#define MIXED 0.01   /* of the amplitude of a mode: its orbit with more of others is a mixture */
#define LOWER 0.01   /* factor from one energy at which a mode is tried to the next, */
#define LEAST 1e-11  /* and down to this part of the first: at amplitudes of 4e-9 */

/* Whether contacts with this exponent drive mode `other` when mode `mode` alone moves: the average
 * of their force over a period, in units that all of them share. */
static bool drives(const ric_model *m, int exponent, int mode, int other)
{
    double sum = 0, size = 0;
    for (int f = 0; f < m->n_contact; f++) {
        double own = m->g[f * m->n + mode], its = m->g[f * m->n + other], push = 0;
        if (m->contact[f].exponent == exponent) push = m->spring[f] * pow(own, exponent);
        sum += push * its;
        size += fabs(push) * hypot(own, its);
    }
    return fabs(sum) > UNMOVED * size;
}

/* Where two modes have one frequency, every mixture of them is a motion of the linear structure.
 * Those have branches whose average of the springs' energy is stationary: a mode alone does only if
 * it does not drive the others. */
static int mixed_with(const ric_model *m, int mode)
{
    for (int i = 0; i < m->n; i++) {
        bool equal = i != mode && m->omega[i] == m->omega[mode] &&
                     m->omega_low[i] == m->omega_low[mode];
        for (int f = 0; f < m->n_contact && equal; f++)
            if (drives(m, m->contact[f].exponent, mode, i)) return i;
    }
    return -1;
}

static int nearest_mode(const ric_model *m, int mode)
{
    int nearest = -1;
    double least = HUGE_VAL;
    for (int i = 0; i < m->n; i++) {
        double apart = fabs(m->omega[i] - m->omega[mode]);
        if (i == mode || apart >= least) continue;
        nearest = i;
        least = apart;
    }
    return nearest;
}

static ric_status no_start(const ric_model *m, int mode)
{
    int other = mixed_with(m, mode);
    if (other < 0) other = nearest_mode(m, mode);
    if (m->n_part > 1 || other < 0)
        return ric_fail(RIC_E_NUMERIC, "the motion of mode %d at small energy does not converge",
                        m->mode[mode] + 1);
    return ric_fail(
        RIC_E_NUMERIC,
        "the motion of mode %d at small energy is not known: its frequency is that of mode "
        "%d up to %.1e, and the power laws decide which mixtures of the two have branches",
        m->mode[mode] + 1, m->mode[other] + 1, fabs(m->omega[other] / m->omega[mode] - 1));
}

/* A mode that no branch can be started from is a start all the same, at an energy at which its
 * linear motion is an orbit to rounding, whose departures are refused with the reason. */
static ric_status refused_start(const ric_model *m, int mode, ric_node **out)
{
    static const int face[] = {-1, -1};
    double u[m->n + 1];
    ric_shooting *chain;
    ric_status status = ric_shooting_create(m, RIC_MIRROR_CENTRE, RIC_MIRROR_REST, 1, 1, face,
                                            &chain);
    if (status) return status;
    memset(u, 0, sizeof u);
    u[mode] = STILL;
    u[m->n] = RIC_TWO_PI / (4 * m->omega[mode]);
    ric_shooting_fly(chain, u);
    ric_periodic *cycle = ric_periodic_from_chain(chain, u);
    status = cycle ? ric_node_start(m, cycle, out) : ric_no_memory("a start");
    ric_periodic_free(cycle);
    ric_shooting_free(chain);
    if (status) return status;
    no_start(m, mode);
    (*out)->mode = mode;
    for (int i = 0; i < (*out)->n_departure; i++) {
        (*out)->departures[i].state = RIC_DEPARTURE_REFUSED;
        (*out)->departures[i].why = ric_strdup(ric_detail());
    }
    return status;
}

/* The orbit of a mode alone at an energy, to a part MIXED of its amplitude: where a mode of nearly
 * the same frequency mixes with it, at a lower one. u [n + 1] and *energy, scaled; false: at none.
 */
static bool alone(const ric_model *m, ric_shooting *chain, int mode, double *u, double *energy)
{
    int n = m->n, iterations;
    double du[n + 1], lowest = LEAST * *energy;
    for (; *energy > lowest; *energy *= LOWER) {
        double amplitude = sqrt(2 * *energy), moved = 0;
        memset(u, 0, (size_t)n * sizeof *u);
        u[mode] = amplitude;
        u[n] = RIC_TWO_PI / (4 * m->omega[mode]);
        if (!ric_continuation_correct(chain, u, NULL, NULL, 0, du, &iterations)) continue;
        for (int i = 0; i < n; i++) moved = fmax(moved, fabs(u[i] - (i == mode ? amplitude : 0)));
        if (moved <= MIXED * amplitude) return true;
    }
    return false;
}

/* Follows the branch of an orbit below the window up to there; *lost: it does not come so far. At
 * small energies the equations are all but singular, and what tells kernels has no sign at the
 * start. The chain is taken. */
static ric_status follow_up(const ric_graph *g, ric_shooting *chain, int mode, const double *u,
                            bool *lost, ric_periodic **out)
{
    const unsigned kernels = 1u << RIC_TEST_DET | 1u << RIC_TEST_A | 1u << RIC_TEST_B |
                             1u << RIC_TEST_D;
    const double *window = g->limits.energy;
    int n = g->model->n;
    double t[n + 1];
    ric_continuation *way = NULL;
    ric_limits limits = {.energy = {0, fmin(window[0] * (1 + ABOVE), (window[0] + window[1]) / 2)},
                         .period = {0, HUGE_VAL},
                         .max_step = g->limits.max_step,
                         .max_points = g->limits.max_points};
    memset(t, 0, sizeof t);
    t[mode] = 1;
    ric_status status = ric_continuation_create(chain, u, t, kernels, &limits, &way);
    if (!status) status = ric_continuation_run(way);
    *lost = status == RIC_E_NUMERIC || (!status && way->end.test != RIC_TEST_E_MAX);
    if (!status && !*lost && !(*out = ric_continuation_cycle(way, way->end.u)))
        status = ric_no_memory("a start");
    ric_continuation_free(way);
    return *lost ? RIC_OK : status;
}

/* Under a power law the orbits of a mode at vanishing energy are those of the linear structure.
 * Where the window starts higher, the branch is followed up to there. *out = NULL: no vibration. */
static ric_status smooth_start(ric_graph *g, int mode, ric_node **out)
{
    static const int face[] = {-1, -1};
    const ric_model *m = g->model;
    ric_shooting *chain = NULL;
    ric_periodic *cycle = NULL;
    double u[m->n + 1], energy = 2 * m->linear_energy / m->energy_unit;
    *out = NULL;
    if (m->omega[mode] == 0) return RIC_OK;
    ric_status status = ric_shooting_create(m, RIC_MIRROR_CENTRE, RIC_MIRROR_REST, 1, 1, face,
                                            &chain);
    if (status) return status;
    bool lost = mixed_with(m, mode) >= 0 || !alone(m, chain, mode, u, &energy);
    if (!lost && energy > g->limits.energy[0]) cycle = ric_periodic_from_chain(chain, u);
    else if (!lost) {
        status = follow_up(g, chain, mode, u, &lost, &cycle);
        chain = NULL;
    }
    if (!status && lost) status = refused_start(m, mode, out);
    else if (cycle) status = ric_node_start(m, cycle, out);
    if (*out) (*out)->mode = mode;
    ric_periodic_free(cycle);
    ric_shooting_free(chain);
    return status;
}

static bool is_wanted(const ric_graph *g, int mode)
{
    bool wanted = g->options->n_start == 0;
    for (int j = 0; j < g->options->n_start; j++)
        wanted |= g->options->start[j] == g->model->mode[mode] + 1;
    return wanted;
}

/* What was left out of an eigenspace is said where its first mode touches. */
static void note_unsought(ric_graph *g, const ric_eigenspace *space)
{
    for (int i = 0; i < g->n_node && !ric_mixtures_all(space); i++) {
        ric_node *node = g->nodes[i];
        if (node->mode < space->first || node->mode >= space->first + space->size ||
            node->multiple > 1)
            continue;
        node->unsought = true;
        return;
    }
}

/* Branches leave the mixtures of modes of one frequency that their impacts would drive (mixture.h),
 * whichever vectors the eigenspace is described by; those of a wanted mode belong to it. */
static ric_status start_mixtures(ric_graph *g)
{
    const ric_mixtures *all = g->model->mixtures;
    for (int i = 0; i < all->n; i++) {
        const ric_eigenspace *space = &all->space[all->list[i].space];
        bool wanted = false;
        for (int mode = space->first; mode < space->first + space->size; mode++)
            wanted |= is_wanted(g, mode);
        if (!wanted || all->list[i].energy > g->limits.energy[1]) continue;
        ric_node *node = NULL;
        ric_status status = ric_node_mixture(g->model, i, &node);
        if (status) return status;
        if (ric_graph_add(g, node, 0) < 0) return ric_no_memory("a junction");
    }
    for (int i = 0; i < all->n_space && ric_model_detached(g->model) && g->model->n_part == 1; i++)
        note_unsought(g, &all->space[i]);
    return RIC_OK;
}

static ric_status start_modes(ric_graph *g)
{
    const ric_model *m = g->model;
    for (int i = 0; i < m->n; i++) {
        ric_node *node = NULL;
        if (!is_wanted(g, i)) continue;
        ric_status status = ric_model_detached(m) ? ric_node_linear(m, i, &node)
                                                  : smooth_start(g, i, &node);
        if (status) return status;
        if (!node) continue;
        if (node->energy > g->limits.energy[1]) {
            ric_node_free(node);
            continue;
        }
        /* at their energies all refused starts would be taken for one */
        bool refused = node->n_departure > 0 && node->departures[0].state == RIC_DEPARTURE_REFUSED;
        int index = refused ? ric_graph_append(g, node) : ric_graph_add(g, node, 0);
        if (index < 0) return ric_no_memory("a junction");
    }
    return RIC_OK;
}

/* An orbit of a loose mass, from which its branch is followed both ways (loose.h). */
static ric_status start_stretch(void *graph, ric_shooting *chain, const double *u)
{
    ric_graph *g = graph;
    ric_shooting_fly(chain, u);
    ric_periodic *cycle = ric_periodic_from_chain(chain, u);
    ric_node *node = NULL;
    if (!cycle) return ric_no_memory("a start");
    ric_status status = ric_node_start(g->model, cycle, &node);
    ric_periodic_free(cycle);
    if (status == RIC_E_NUMERIC) return RIC_OK;
    if (!status && ric_graph_add(g, node, 0) < 0) status = ric_no_memory("a start");
    return status;
}

/* Orbits given from outside, such as those that a hunt has found. One that is no orbit to this
 * version is left out. */
static ric_status start_given(ric_graph *g)
{
    ric_status status = RIC_OK;
    for (int i = 0; i < g->starts.n && !status; i++) {
        ric_periodic *cycle = NULL;
        ric_node *node = NULL;
        status = ric_start_solve(g->model, g->starts.cycle[i], &cycle);
        if (!status) status = ric_node_start(g->model, cycle, &node);
        ric_periodic_free(cycle);
        if (status == RIC_E_NUMERIC) status = RIC_OK;
        else if (!status &&
                 (node->energy < g->limits.energy[0] || node->energy > g->limits.energy[1]))
            ric_node_free(node);
        else if (!status && ric_graph_add(g, node, 0) < 0) status = ric_no_memory("a start");
    }
    return status;
}

ric_status ric_graph_start(ric_graph *g)
{
    ric_status status = g->only_given ? RIC_OK : start_modes(g);
    if (!status && !g->only_given) status = start_mixtures(g);
    if (status || g->model->n_part > 1) return status;
    if (!g->only_given) status = ric_loose_scan(g->model, &g->limits, start_stretch, g);
    return status ? status : start_given(g);
}
