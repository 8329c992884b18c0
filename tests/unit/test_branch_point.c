/* Branch points where two branches of one symmetry cross: both are found, and which is which does
 * not depend on where one comes from. A structure that is its own image under the exchange of left
 * and right, of which the program knows nothing, has many: one branch is its own image, the other
 * one breaks the symmetry. With one mass a little larger the branches do not cross, they pass each
 * other, and no step may lead from one to the other. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "junction/branch_point.h"
#include "branch/branch_point_gap.h"
#include "junction/switching.h"
#include "explored.h"

static const double PI = 3.14159265358979323846;

/* Two equal masses on equal springs, joined by a third; each has a wall on its outer side. */
static const char study_text[] = "model:\n  mass: [[HEAVY, 0], [0, MASS]]\n  stiffness: [[STIFF, "
                                 "-JOIN], [-JOIN, STIFF]]\n  contacts:\n"
                                 "    - {normal: [1, 0], clearance: 1, sides: upper, law: rigid}\n "
                                 "   - {normal: [0, -1], clearance: 1, sides: "
                                 "upper, law: rigid}\n"
                                 "explore: {start: modes, energy: [0, 60], frequency: [0.1, 8], "
                                 "impacts: 9, multiply: 1, depth: 4}\n";

/* Left and right exchanged: x1 -> -x2, x2 -> -x1, and the walls. */
static ric_periodic *exchanged(const ric_model *m, const ric_periodic *cycle)
{
    double x[2], v[2], y[2], z[2];
    ric_periodic *out = ric_periodic_copy(cycle);
    ric_model_to_state(m, cycle->w, x, v);
    for (int i = 0; i < 2; i++) {
        y[i] = -x[1 - i];
        z[i] = -v[1 - i];
    }
    ric_model_from_state(m, y, z, out->w);
    for (int i = 0; i < cycle->N; i++) out->face[i] = 1 - cycle->face[i];
    return out;
}

static bool own_image(const ric_model *m, const ric_periodic *cycle)
{
    ric_turn turn;
    ric_periodic *image = exchanged(m, cycle);
    bool same = ric_periodic_match(m, cycle, image, 1e-7, &turn);
    ric_periodic_free(image);
    return same;
}

/* Point `at` of the branch that leaves by `choice` on `side`; its class seen from the node, and the
 * energy there. */
static ric_periodic *leave(const ric_graph *g, const ric_node *node, unsigned choice, int side,
                           int at, double *energy)
{
    ric_outset from;
    unsigned seen;
    ric_continuation *tr = NULL;
    ric_limits limits = g->limits;
    limits.max_points = at + 1;
    if (ric_switching_depart(g->model, node, choice, side, &from) ||
        ric_continuation_create(from.chain, from.u, from.t, from.ignore, &limits, &tr) ||
        ric_continuation_run(tr))
        fail_msg("choice %u, side %d at E %.9g: %s", choice, side, node->energy, ric_detail());
    from.chain = NULL;
    assert_true(tr->n_point > at);
    const double *point = tr->points + (size_t)at * tr->stride,
                 *u = point + sizeof(ric_point) / sizeof(double);
    ric_shooting_fly(tr->chain, u);
    assert_true(tr->chain->residual <= ric_continuation_tolerance(tr->chain));
    *energy = ((const ric_point *)point)->energy;
    ric_periodic *cycle = ric_periodic_from_chain(tr->chain, u),
                 *turned = ric_periodic_canonical(g->model, cycle);
    if (ric_branch_point_choice(g->model, node, turned, &seen)) fail_msg("%s", ric_detail());
    if (seen != choice) fail_msg("choice %u at E %.9g is taken for %u", choice, node->energy, seen);
    ric_periodic_free(turned);
    ric_continuation_free(tr);
    ric_outset_clear(&from);
    return cycle;
}

/* The one branch keeps the symmetry, the other one breaks it: both sides of the node are images, of
 * one energy but for the square of the step, 1e-3, as the exchange is no isometry of the unknowns.
 */
static bool check_node(const ric_graph *g, const ric_node *node)
{
    double energy[2];
    int kept = 0, broken = 0;
    if (!own_image(g->model, node->cycle)) return false;
    for (unsigned choice = RIC_THROUGH; choice <= RIC_SIDE; choice++) {
        bool image = true;
        for (int i = 0; i < 2; i++) {
            ric_periodic *cycle = leave(g, node, choice, i ? -1 : 1, 1, &energy[i]);
            image = own_image(g->model, cycle) && image;
            ric_periodic_free(cycle);
        }
        if (image != (choice == RIC_THROUGH))
            fail_msg("THROUGH is not the branch along which the energy changes at E %.9g",
                     node->energy);
        kept += image;
        broken += !image;
        if (!image && fabs(energy[0] - energy[1]) > 1e-6 * energy[0])
            fail_msg("energies %.12g and %.12g on both sides", energy[0], energy[1]);
    }
    if (kept != 1 || broken != 1)
        fail_msg("%d branches that keep the symmetry and %d that break it at E %.9g", kept, broken,
                 node->energy);
    return true;
}

static const double numbers[][3] = {{1.641, 4.983, 3.79},
                                    {0.586, 5.021, 3.802},
                                    {1.862, 5.238, 3.244},
                                    {1.648, 5.866, 2.957}};

/* Structure i, with the left mass 1 + more times the right one. */
static void write_study(int i, double more, char *out)
{
    static const char *const names[] = {"HEAVY", "MASS", "STIFF", "JOIN"};
    double values[] = {numbers[i][0] * (1 + more), numbers[i][0], numbers[i][1], numbers[i][2]};
    for (const char *p = study_text; *p;) {
        int k = 0;
        while (k < 4 && strncmp(p, names[k], strlen(names[k]))) k++;
        if (k == 4) *out++ = *p++;
        else {
            out += sprintf(out, "%.17g", values[k]);
            p += strlen(names[k]);
        }
    }
    *out = 0;
}

static ric_graph *explore(int i, double more, ric_study **study)
{
    char text[2048];
    ric_graph *g = NULL;
    write_study(i, more, text);
    if (ric_study_parse(text, "left and right", ".", study)) fail_msg("%s", ric_detail());
    if (ric_graph_create(*study, NULL, &g) || ric_graph_explore(g, NULL))
        fail_msg("%s", ric_detail());
    return g;
}

/* Whether no other crossing lies so near that the kernels of both are hardly told apart: what
 * departs from such a one may be refused. */
static bool alone(const ric_graph *g, const ric_node *node)
{
    for (int k = 0; k < g->n_node; k++)
        if (g->nodes[k] != node && g->nodes[k]->kind == RIC_KIND_BRANCH_POINT &&
            g->nodes[k]->test == RIC_TEST_DET && g->nodes[k]->cycle->N == node->cycle->N &&
            fabs(g->nodes[k]->energy / node->energy - 1) < 1e-5)
            return false;
    return true;
}

static void left_and_right(void **state)
{
    (void)state;
    int checked = 0;
    for (int i = 0; i < (int)(sizeof numbers / sizeof *numbers); i++) {
        ric_study *study = NULL;
        ric_graph *g = explore(i, 0, &study);
        for (int k = 0; k < g->n_node; k++)
            if (g->nodes[k]->kind == RIC_KIND_BRANCH_POINT && g->nodes[k]->test == RIC_TEST_DET &&
                alone(g, g->nodes[k]))
                checked += check_node(g, g->nodes[k]);
        ric_graph_free(g);
        ric_study_free(study);
    }
    if (checked < 5) fail_msg("%d crossings only", checked);
}

/* The orbit at a crossing, carried over to another structure of the same words. */
static double gap_in(const ric_model *m, const ric_periodic *cycle, const ric_model *other)
{
    double x[2], v[2], *u = NULL;
    ric_shooting *chain = NULL;
    ric_periodic *moved = ric_periodic_copy(cycle);
    ric_model_to_state(m, cycle->w, x, v);
    ric_model_from_state(other, x, v, moved->w);
    for (int i = 0; i < moved->N; i++) moved->tau[i] *= other->omega_ref / m->omega_ref;
    assert_int_equal(ric_periodic_to_chain(other, moved, &chain, &u), RIC_OK);
    ric_shooting_evaluate(chain, u);
    double gap = ric_branch_point_gap(chain, u);
    ric_shooting_free(chain);
    ric_periodic_free(moved);
    free(u);
    return gap;
}

/* Nothing keeps branches apart that cross; with masses that differ it is proportional to the
 * difference. */
static void gaps(void **state)
{
    (void)state;
    int checked = 0;
    for (int i = 0; i < (int)(sizeof numbers / sizeof *numbers); i++) {
        ric_study *study[3] = {NULL};
        ric_graph *g = explore(i, 0, &study[0]);
        const ric_model *m[3] = {g->model};
        for (int k = 1; k < 3; k++) {
            char text[2048];
            write_study(i, k == 1 ? 1e-5 : 1e-6, text);
            if (ric_study_parse(text, "left and right", ".", &study[k]))
                fail_msg("%s", ric_detail());
            m[k] = ric_study_model(study[k]);
        }
        for (int k = 0; k < g->n_node; k++) {
            const ric_node *node = g->nodes[k];
            if (node->kind != RIC_KIND_BRANCH_POINT || node->test != RIC_TEST_DET ||
                !own_image(m[0], node->cycle))
                continue;
            double none = gap_in(m[0], node->cycle, m[0]), first = gap_in(m[0], node->cycle, m[1]),
                   second = gap_in(m[0], node->cycle, m[2]);
            if (!(none < 1e-13))
                fail_msg("%g between two branches that cross at E %.9g", none, node->energy);
            if (!(first > 1e-8 && fabs(first / second / 10 - 1) < 0.01))
                fail_msg("%g and %g at E %.9g", first, second, node->energy);
            checked++;
        }
        ric_graph_free(g);
        for (int k = 0; k < 3; k++) ric_study_free(study[k]);
    }
    if (checked < 5) fail_msg("%d crossings only", checked);
}

/* Whatever the step, no trace changes from one branch to another that comes near. */
static void nearly_left_and_right(void **state)
{
    (void)state;
    static const double more[] = {1e-6, 1e-7, 1e-8}, steps[] = {0.01, 0.1, 1};
    for (int i = 0; i < (int)(sizeof more / sizeof *more); i++) {
        char text[2048];
        write_study(0, more[i], text);
        ric_atlas *atlas[3];
        for (int k = 0; k < 3; k++) {
            atlas[k] = explore_text_with(text, NULL, steps[k]);
            for (int id = 1; id <= ric_atlas_n_branch(atlas[k]); id++)
                assert_true(branch_of(atlas[k], id).stop != RIC_STOP_FAILED);
            /* what leaves where both stops are met at once, but for `more` */
            assert_true(branch_named(atlas[k], "A4[0011]") > 0);
            if (ric_atlas_n_branch(atlas[0]) != ric_atlas_n_branch(atlas[k]) ||
                ric_atlas_n_junction(atlas[0]) != ric_atlas_n_junction(atlas[k]))
                fail_msg("%g: %d branches and %d junctions with step %g, not %d and %d", more[i],
                         ric_atlas_n_branch(atlas[k]), ric_atlas_n_junction(atlas[k]), steps[k],
                         ric_atlas_n_branch(atlas[0]), ric_atlas_n_junction(atlas[0]));
            for (int id = 1; id <= ric_atlas_n_junction(atlas[k]); id++) {
                ric_junction a = junction_of(atlas[0], id), b = junction_of(atlas[k], id);
                if (a.kind != b.kind || fabs(a.energy - b.energy) > 1e-9 * a.energy ||
                    a.n_branch != b.n_branch)
                    fail_msg("%g: %s at E %.12g becomes %s at E %.12g with step %g", more[i],
                             a.label, a.energy, b.label, b.energy, steps[k]);
            }
        }
        for (int k = 0; k < 3; k++) ric_atlas_free(atlas[k]);
    }
}

/* ------------------------------------------------------------- faint modes */

/* Energy of S2[01] (theory section 11), internal units. */
static double s2_energy(const ric_model *m, double omega)
{
    double up = 0, down = 0, quarter = PI / (2 * omega);
    for (int i = 0; i < m->n; i++) {
        up += pow(m->c[i] / cos(m->omega[i] * quarter), 2);
        down += m->c[i] * m->c[i] * tan(m->omega[i] * quarter) / m->omega[i];
    }
    return up / (2 * down * down);
}

/* The first frequency above that of a mode of which a mode is an odd multiple. */
static double resonance_above(const ric_model *m, int mode)
{
    double first = HUGE_VAL;
    for (int i = 0; i < m->n; i++)
        for (double odd = 1; m->omega[i] / odd > m->omega[mode]; odd += 2)
            if (m->omega[i] / (odd + 2) <= m->omega[mode]) first = fmin(first, m->omega[i] / odd);
    return first;
}

/* S2[01] of the second mode of a beam turns at the first resonance of a mode with a modal normal
 * of 3.5e-5, within 1e-7 of its frequency: its energy rises there to 5e13. With longer steps the
 * branch seems to go on through it and through others. */
static void faint_modes(void **state)
{
    (void)state;
    static const char text[] =
        "model:\n  mass: {file: examples/beam-lumped/M.mtx}\n"
        "  stiffness: {file: examples/beam-lumped/K.mtx}\n  contacts:\n"
        "    - {normal: [0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,1], clearance: 1, sides: both, "
        "law: rigid}\n"
        "explore: {start: [2], energy: [0, 100], frequency: [0.2, 20], impacts: 2, multiply: 1, "
        "depth: 1}\n";
    static const double steps[] = {0.01, 0.0207, 0.0886, 0.3, 1};
    ric_study *study = NULL;
    if (ric_study_parse(text, "beam", ".", &study)) fail_msg("%s", ric_detail());
    const ric_model *m = ric_study_model(study);
    double end = resonance_above(m, 1), l = m->omega[1] + 0.1 * (end - m->omega[1]),
           r = end * (1 - 1e-9), ratio = 0.6180339887498949;
    for (int i = 0; i < 100; i++) {
        double x = r - ratio * (r - l), y = l + ratio * (r - l);
        if (s2_energy(m, x) > s2_energy(m, y)) l = x;
        else r = y;
    }
    double least = s2_energy(m, l) * m->energy_unit;
    assert_int_equal(ric_resonance_faint(m, 1, 2 * PI / (end * (1 + 1e-9)),
                                         2 * PI / (end * (1 - 1e-9))),
                     1);
    assert_int_equal(ric_resonance_faint(m, 1, 2 * PI / (end * (1 - 1e-9)),
                                         2 * PI / (end * (1 - 2e-9))),
                     0);
    assert_int_equal(ric_resonance_faint(m, 1, 2 * PI / (end * 1.1), 2 * PI / end), 2);
    /* one that is not faint */
    assert_int_equal(ric_resonance_faint(m, 1, 2 * PI / m->omega[0] * (1 - 1e-9),
                                         2 * PI / m->omega[0] * (1 + 1e-9)),
                     0);
    for (int k = 0; k < (int)(sizeof steps / sizeof *steps); k++) {
        ric_atlas *atlas = explore_text_with(text, NULL, steps[k]);
        int extrema = 0;
        for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
            ric_branch b = branch_of(atlas, id);
            if (b.impacts == 0) continue;
            if (b.stop != RIC_STOP_WINDOW ||
                fabs(b.frequency_max - end * m->omega_ref) > 1e-7 * b.frequency_max)
                fail_msg("step %g: the branch goes to omega %.12g, not %.12g", steps[k],
                         b.frequency_max, end * m->omega_ref);
        }
        for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
            ric_junction j = junction_of(atlas, id);
            if (j.kind == RIC_KIND_GRAZING) continue;
            if (j.kind != RIC_KIND_EXTREMUM || fabs(j.energy - least) > 1e-11 * least)
                fail_msg("step %g: %s at E %.14g, not %.14g", steps[k], j.label, j.energy, least);
            extrema++;
        }
        assert_int_equal(extrema, 1);
        ric_atlas_free(atlas);
    }
    ric_study_free(study);
}

/* Four faint modes whose resonances lie within one step, and change the sign of each factor of the
 * map four times: every one is a branch point. */
static void faint_modes_together(void **state)
{
    (void)state;
    /* 40 times that is a frequency */
    static const double steps[] = {0.01, 0.03, 0.1, 0.3, 1}, at[] = {1.02, 1.0204, 1.0208, 1.0212};
    char text[2048], mass[512] = "", stiffness[512] = "";
    for (int i = 0; i < 6; i++)
        for (int j = 0; j < 6; j++) {
            double k = i != j ? 0 : i == 0 ? 1 : i == 1 ? 4.6 : pow(40 * at[i - 2], 2);
            sprintf(mass + strlen(mass), "%s%d%s", j ? ", " : "[", i == j,
                    j < 5   ? ""
                    : i < 5 ? "], "
                            : "]");
            sprintf(stiffness + strlen(stiffness), "%s%.17g%s", j ? ", " : "[", k,
                    j < 5   ? ""
                    : i < 5 ? "], "
                            : "]");
        }
    snprintf(text, sizeof text,
             "model:\n  mass: [%s]\n  stiffness: [%s]\n  contacts:\n"
             "    - {normal: [1, 0.7, 0.003, 0.003, 0.003, 0.003], clearance: 1, sides: both, law: "
             "rigid}\n"
             "explore: {start: [1], energy: [0, 50], frequency: [0.2, 20], impacts: 2, multiply: "
             "1, depth: 1}\n",
             mass, stiffness);
    for (int k = 0; k < (int)(sizeof steps / sizeof *steps); k++) {
        ric_atlas *atlas = explore_text_with(text, NULL, steps[k]);
        int found = 0;
        for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
            ric_junction j = junction_of(atlas, id);
            if (j.kind != RIC_KIND_BRANCH_POINT) continue;
            if (found == 4 || fabs(j.frequency - at[found]) > 1e-8)
                fail_msg("step %g: %s at omega %.12g", steps[k], j.label, j.frequency);
            found++;
        }
        if (found != 4) fail_msg("step %g: %d branch points", steps[k], found);
        ric_atlas_free(atlas);
    }
}

/* A5[00101] of this structure arrives at a branch point just before the point from which the step
 * over it begins: no point lies behind the end, and what is stable of a branch is a share of it. */
static void an_end_before_the_last_point(void **state)
{
    (void)state;
    ric_atlas *atlas = explore_text(
        "model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[8.494920630164673, -0.4949206301646726], "
        "[-0.4949206301646726, 0.4949206301646726]]\n  contacts: [{normal: [-1, 1], clearance: "
        "1}]\n"
        "explore: {energy: [0, 0.4], frequency: [0.2, 1], impacts: 5, multiply: 3, depth: 2}\n");
    int found = 0;
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        const ric_branch b = branch_of(atlas, id);
        double at[b.n_point];
        int width;
        assert_int_equal(ric_atlas_column(atlas, id, "arclength", &width, at), RIC_OK);
        for (int i = 1; i < b.n_point; i++)
            if (!(at[i] >= at[i - 1]))
                fail_msg("%s: point %d of %d lies before the last one", b.label, i, b.n_point);
        if (!(b.stable_fraction >= 0 && b.stable_fraction <= 1))
            fail_msg("%s: %g of it is stable", b.label, b.stable_fraction);
        found += !strcmp(b.label, "A5[00101]");
    }
    assert_true(found > 0);
    ric_atlas_free(atlas);
}

/* Stops of which one is a thousand times as near as the other. */
static const char near_and_far[] =
    "model:\n  mass: [[1.546875, 0.125, 0.09375], [0.125, 2.5, 0.25], [0.09375, 0.25, 1.46875]]\n"
    "  stiffness: [[6.556460538945877, 0.8052842587296554, -3.2765633504430096],\n"
    "    [0.8052842587296554, 10.029813326778692, -5.0258280215230435],\n"
    "    [-3.2765633504430096, -5.0258280215230435, 6.861486905051336]]\n"
    "  contacts: [{normal: [0, 1, 0], clearance: 0.963}, {normal: [1, 0, 0], clearance: "
    "0.000963}]\n"
    "explore: {start: modes, energy: [0, 1.144e-4], frequency: [0.2001, 8.998], impacts: 4, "
    "multiply: 2, depth: 2}\n";

/* The most that slopes of orbits differ by which are the same but for rounding, at distance d along
 * t0 from u0; and the least of them that counts as one. */
static void spread(ric_shooting *c, const double *u0, const double *t0, double d, double *out,
                   double *counts)
{
    enum { STARTS = 12 };
    const int size = c->n_unknown;
    double v[size], du[size], t[size], least[2] = {HUGE_VAL, HUGE_VAL},
                                       most[2] = {-HUGE_VAL, -HUGE_VAL};
    counts[0] = counts[1] = HUGE_VAL;
    for (unsigned way = 1; way <= STARTS; way++) {
        unsigned bits = way * 2654435769u;
        int iterations;
        for (int i = 0; i < size; i++) v[i] = u0[i] + d * t0[i] + ric_moved(&bits, 1e-11);
        if (!ric_continuation_correct(c, v, u0, t0, d, du, &iterations)) continue;
        ric_continuation_tangent(c, t0, t);
        for (int k = 0; k < 2; k++) {
            const int test = k ? RIC_TEST_PERIOD : RIC_TEST_SLOPE;
            const double slope = ric_continuation_slope(c, test, t);
            if (fabs(slope) > ric_continuation_slope_error(c, v, t, test, slope))
                counts[k] = fmin(counts[k], fabs(slope));
            least[k] = fmin(least[k], slope);
            most[k] = fmax(most[k], slope);
        }
    }
    for (int k = 0; k < 2; k++) out[k] = fmax(most[k] - least[k], 0);
}

/* Beside a branch point orbits that are the same but for rounding have slopes that differ: what is
 * taken for one is more than that. */
static void slopes_beside(void **state)
{
    (void)state;
    ric_study *study = NULL;
    int checked = 0;
    if (ric_study_parse(near_and_far, "near and far", ".", &study)) fail_msg("%s", ric_detail());
    ric_graph *g = explored_graph(study);
    for (int k = 0; k < g->n_node; k++) {
        const ric_node *node = g->nodes[k];
        ric_outset from;
        double by[2], counts[2];
        if (node->kind != RIC_KIND_MULTIPLICATION || node->n_departure < 2) continue;
        if (ric_switching_depart(g->model, node, node->departures[1].choice, 1, &from)) continue;
        ric_shooting *c = from.chain;
        const double step = sqrt(ric_dot(c->n_unknown, from.t, from.t));
        for (int i = 0; i < c->n_unknown; i++) from.t[i] /= step;
        if (from.ignore & RIC_SINGULAR_START)
            for (double d = 1e-4; d > 2e-8; d /= 1.3, checked++)
                for (int side = -1; side <= 1; side += 2) {
                    spread(c, from.u, from.t, side * d * c->scale, by, counts);
                    for (int test = 0; test < 2; test++)
                        if (by[test] / 2 > counts[test])
                            fail_msg("E %.9g: at %g slopes differ by %g, and %g counts as one",
                                     node->energy, side * d, by[test], counts[test]);
                }
        ric_outset_clear(&from);
    }
    assert_true(checked > 20);
    ric_graph_free(g);
    ric_study_free(study);
}

/* There the slope of the branch that arrives is rounding, and its sign makes no extremum. */
static void no_extremum_of_rounding(void **state)
{
    (void)state;
    ric_atlas *atlas = explore_text(near_and_far);
    int doublings = 0;
    for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
        const ric_junction j = junction_of(atlas, id);
        const bool here = fabs(j.energy / 3.14654161e-6 - 1) < 1e-8;
        doublings += here && j.kind == RIC_KIND_MULTIPLICATION;
        if (here && j.kind == RIC_KIND_EXTREMUM) fail_msg("%s at E %.12g", j.label, j.energy);
    }
    assert_int_equal(doublings, 1);
    ric_atlas_free(atlas);
}

/* Five masses with two frequencies 4e-8 apart: the equations are nearly singular all along
 * A1(2)[1].
 */
static const double near_mass[5][5] = {{1.734375, -0.1875, 0.484375, 0.140625, -0.109375},
                                       {-0.1875, 1.9375, -0.5, -0.25, 0.09375},
                                       {0.484375, -0.5, 2.78125, 0.1875, -0.3125},
                                       {0.140625, -0.25, 0.1875, 1.90625, 0.09375},
                                       {-0.109375, 0.09375, -0.3125, 0.09375, 1.671875}},
                    near_stiffness[5][5] =
                        {{2164511.6328147063, -1867693.1169234856, 1195083.5693259488,
                          2497092.6964169564, -36743.220125902015},
                         {-1867693.1169234856, 5366947.632095278, -3333958.0770433266,
                          -2582784.464122732, 1172906.8854422104},
                         {1195083.5693259488, -3333958.0770433266, 4562145.287692939,
                          1554945.265796546, -2395479.742759571},
                         {2497092.6964169564, -2582784.464122732, 1554945.265796546,
                          3980368.240235615, 11414.518819623105},
                         {-36743.220125902015, 1172906.8854422104, -2395479.742759571,
                          11414.518819623105, 2168635.305253825}},
                    near_normal[3][5] = {{0, -1, 1, 0, 0}, {0, 0, 0, 0, 1}, {-1, 1, 0, 0, 0}};

/* A list of numbers, in another order of the coordinates if `turned`. */
static char *put_list(char *at, const char *before, const double *list, bool turned)
{
    at += sprintf(at, "%s[", before);
    for (int i = 0; i < 5; i++)
        at += sprintf(at, "%s%.17g", i ? ", " : "", list[turned ? 4 - i : i]);
    return at + sprintf(at, "]");
}

static char *put_matrix(char *at, const char *before, const double (*matrix)[5], bool turned)
{
    at += sprintf(at, "%s", before);
    for (int i = 0; i < 5; i++)
        at = put_list(at, i ? ", " : "[", matrix[turned ? 4 - i : i], turned);
    return at + sprintf(at, "]");
}

static ric_atlas *explore_near_frequencies(bool turned, double max_step)
{
    static const char *const contact[] = {"law: rigid, clearance: 1.44, sides: upper",
                                          "law: bilinear, clearance: 0.00144, sides: lower, "
                                          "stiffness: 732900",
                                          "law: rigid, clearance: 1.43, sides: both"};
    char text[4000], *at = put_matrix(text, "model:\n  mass: ", near_mass, turned);
    at = put_matrix(at, "\n  stiffness: ", near_stiffness, turned);
    at += sprintf(at, "\n  contacts:");
    for (int i = 0; i < 3; i++) {
        at = put_list(at, "\n    - {normal: ", near_normal[i], turned);
        at += sprintf(at, ", %s}", contact[i]);
    }
    sprintf(at, "\nexplore: {start: modes, energy: [0, 3.753], frequency: [100, 6000], impacts: 5, "
                "multiply: 3, depth: 1}\n");
    return explore_text_with(text, NULL, max_step);
}

/* Its energy has a least and a largest value, with slopes that are clear of what rounding makes of
 * the direction. */
static void extrema_of_near_frequencies(void **state)
{
    static const double steps[] = {0.009, 0.03, 0.09}, at[] = {0.434345930029, 1.35263417224};
    (void)state;
    for (int run = 0; run < 6; run++) {
        ric_atlas *atlas = explore_near_frequencies(run % 2, steps[run / 2]);
        int found = 0;
        for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
            const ric_junction j = junction_of(atlas, id);
            if (j.kind != RIC_KIND_EXTREMUM) continue;
            print_message("# step %g: %s at E %.15g\n", steps[run / 2], j.label, j.energy);
            assert_true(found < 2 && fabs(j.energy / at[found] - 1) < 1e-10);
            found++;
        }
        assert_int_equal(found, 2);
        ric_atlas_free(atlas);
    }
}

/* Beside a crossing orbits are known to the root of rounding: its energy was 6e-7 off. That of 40
 * digits is where lambda + 1/lambda of the orbit with two equal flights, flown by itself, is 2. */
static void exact_crossing(void **state)
{
    static const double steps[] = {0, 0.009, 0.09}, energy = 92.169730685627584;
    (void)state;
    for (int i = 0; i < 3; i++) {
        ric_atlas *atlas = explore_text_with(
            "model:\n  mass: [[0.662, 0], [0, 0.662]]\n  stiffness: [[2.674, -0.484], [-0.484, "
            "2.674]]\n  contacts:\n    - {normal: [1, 0], clearance: 1, sides: lower}\n"
            "    - {normal: [0, 1], clearance: 1, sides: upper}\n"
            "explore: {start: [1], energy: [0, 131.4], frequency: [0.45, 11], impacts: 4, "
            "multiply: "
            "1, depth: 2}\n",
            NULL, steps[i]);
        int found = 0;
        for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
            const ric_junction j = junction_of(atlas, id);
            if (j.kind != RIC_KIND_BRANCH_POINT) continue;
            found++;
            assert_true(fabs(j.energy - energy) <= 1e-13 * energy);
            assert_true(fabs(j.flights[0] - j.flights[1]) <= 1e-13 * j.flights[0]);
            assert_true(j.decided && j.a == 3 && j.b == 2);
        }
        assert_int_equal(found, 1);
        ric_atlas_free(atlas);
    }
}

/* Two equal oscillators x'' + 2 x + x^3 = 0, against each other: x = a cn, and the motion that
 * makes one swing more than the other obeys the equation of Lame for n = 2, whose edge cn dn is met
 * at k^2 = 1/8, a^2 = 2/3, E = 14/9, w = pi sqrt(8/3) / (2 K). */
static void exact_localization(void **state)
{
    static const double steps[] = {0, 0.009, 0.09};
    (void)state;
    for (int i = 0; i < 3; i++) {
        ric_atlas *atlas = explore_text_with(
            "model:\n  mass: [[1, 0], [0, 1]]\n  stiffness: [[1.5, -0.5], [-0.5, 1.5]]\n"
            "  contacts:\n    - {normal: [1, 0], law: power, exponent: 3, stiffness: 1}\n"
            "    - {normal: [0, 1], law: power, exponent: 3, stiffness: 1}\n"
            "explore: {start: [2], energy: [0, 10], frequency: [0.4, 12], multiply: 1, depth: "
            "1}\n",
            NULL, steps[i]);
        double mean = 1, other = sqrt(7.0 / 8); /* K = pi / (2 agm(1, sqrt(1 - k^2))) */
        for (int k = 0; k < 6; k++) {
            const double next = (mean + other) / 2;
            other = sqrt(mean * other);
            mean = next;
        }
        int found = 0;
        for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
            const ric_junction j = junction_of(atlas, id);
            if (j.kind != RIC_KIND_BRANCH_POINT) continue;
            found++;
            assert_true(fabs(j.energy - 14.0 / 9) <= 1e-13);
            assert_true(fabs(j.frequency - sqrt(8.0 / 3) * mean) <= 1e-13);
        }
        assert_int_equal(found, 1);
        ric_atlas_free(atlas);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(left_and_right),
                                       cmocka_unit_test(exact_crossing),
                                       cmocka_unit_test(exact_localization),
                                       cmocka_unit_test(gaps),
                                       cmocka_unit_test(nearly_left_and_right),
                                       cmocka_unit_test(faint_modes),
                                       cmocka_unit_test(faint_modes_together),
                                       cmocka_unit_test(an_end_before_the_last_point),
                                       cmocka_unit_test(slopes_beside),
                                       cmocka_unit_test(no_extremum_of_rounding),
                                       cmocka_unit_test(extrema_of_near_frequencies)};
    return cmocka_run_group_tests_name("crossing", tests, NULL, NULL);
}
