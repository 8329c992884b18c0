/* The loops of the bases F_2^k of the article's two masses for large k. Two families of 2k impacts
 * leave the k-duplicate of S2- and end, by rounding, at orbits of the energy of G_0,2k with many
 * impacts of no speed that a double would hold. Which branches leave there is lost, and they are as
 * many as subsets of these impacts. From the other side two words say it: the touches of G_0,2k
 * without two or three neighbours. Here their branches are followed from G_0,2k on, and end where
 * the families do. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "explored.h"
#include "junction/grazing_words.h"
#include "sample.h"

enum { MOST = 20, IMPACTS = 2 * MOST };
/* SAME: of energies and periods: more than what impacts amplify at k = 6, less than what is beside
 * it */
#define SAME 1e-9
#define TIME 1e-9 /* of instants of impacts, of a period */

typedef struct {
    double energy, period, at[IMPACTS]; /* instants of the impacts, in periods */
    int n;
} ending;

static void parse(int k, double top, ric_study **study)
{
    char text[600];
    snprintf(text, sizeof text,
             "model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n"
             "  contacts: [{normal: [-1, 1], clearance: 1, sides: both, law: rigid}]\n"
             "explore: {start: [2], energy: [0, 3], frequency: [%.17g, %.17g], impacts: %d, "
             "multiply: %d, cascade: "
             "[%d], depth: 0}\n",
             2.15347593643804 / k * 0.9999, top, 2 * k, k, k);
    if (ric_study_parse(text, "test", ".", study)) fail_msg("%s\n%s", ric_detail(), text);
}

static ending ending_of(int n, const double *tau)
{
    ending e = {.n = n};
    for (int i = 0; i < n; i++) e.period += tau[i];
    for (int i = 1; i < n; i++) e.at[i] = e.at[i - 1] + tau[i - 1] / e.period;
    return e;
}

/* The families of 2k impacts at their ends of high energy. */
static void families(int k, ending out[2])
{
    ric_study *study;
    parse(k, 2.7538 + 3.5 / (k * k), &study);
    ric_graph *graph = explored_graph(study);
    ric_atlas *atlas = NULL;
    int n = 0;
    assert_int_equal(ric_rows_make(graph, study, true, &atlas), RIC_OK);
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        ric_branch b = branch_of(atlas, id);
        ric_point first, last;
        double tau[IMPACTS + 1];
        if (b.impacts != 2 * k || b.stop != RIC_STOP_JUNCTION) continue;
        assert_int_equal(ric_atlas_point(atlas, id, 0, &first, NULL, NULL), RIC_OK);
        assert_int_equal(ric_atlas_point(atlas, id, b.n_point - 1, &last, NULL, NULL), RIC_OK);
        const bool front = first.energy > last.energy;
        assert_int_equal(ric_atlas_point(atlas, id, front ? 0 : b.n_point - 1, &last, NULL, tau),
                         RIC_OK);
        if (n < 2) {
            out[n] = ending_of(2 * k, tau);
            out[n].energy = last.energy, out[n].period = 2 * M_PI / last.frequency;
        }
        n++;
    }
    assert_int_equal(n, 2);
    ric_atlas_free(atlas);
    ric_graph_free(graph);
    ric_study_free(study);
}

/* The touches of G_0,2k but for `less` neighbours, as impacts of no speed. */
static ric_periodic *word_of(const ric_model *m, int k, int less)
{
    ric_node *mode = NULL;
    bool keep[IMPACTS];
    assert_int_equal(ric_node_linear(m, 1, &mode), RIC_OK);
    assert_int_equal(mode->cycle->N, 2);
    ric_periodic *whole = ric_periodic_repeat(mode->cycle, k);
    whole->half = false;
    whole->pure = whole->flip = -1;
    for (int i = 0; i < 2 * k; i++) keep[i] = i < 2 * k - less;
    ric_periodic *out = ric_grazing_words_keep(m, whole, keep);
    ric_periodic_free(whole);
    ric_node_free(mode);
    return out;
}

/* Where the branch that leaves G_0,2k by the word ends; false on the side where there is none. */
static bool follow(const ric_graph *g, int k, int less, int side, ending *out)
{
    ric_shooting *chain = NULL;
    ric_continuation *tr = NULL;
    double *u = NULL;
    int steps;
    ric_periodic *cycle = word_of(g->model, k, less);
    assert_int_equal(ric_periodic_to_chain(g->model, cycle, &chain, &u), RIC_OK);
    double t[chain->n_unknown];
    assert_true(ric_continuation_correct(chain, u, NULL, NULL, 0, t, &steps));
    ric_continuation_tangent(chain, NULL, t);
    for (int i = 0; i < chain->n_unknown; i++) t[i] *= side;
    const unsigned ignore = 1u << RIC_TEST_A | 1u << RIC_TEST_B | 1u << RIC_TEST_D |
                            1u << RIC_TEST_REACH | 1u << RIC_TEST_APPROACH;
    bool good = !ric_continuation_create(chain, u, t, ignore, &g->limits, &tr) &&
                !ric_continuation_run(tr);
    if (good) {
        print_message("# k = %d, %d impacts: stops (%s) after %d points\n", k, cycle->N,
                      ric_stop_text(tr->stop), tr->n_point);
        assert_int_equal(tr->stop, RIC_STOP_JUNCTION);
        ric_periodic *end = ric_continuation_cycle(tr, tr->end.u);
        *out = ending_of(end->N, end->tau);
        out->energy = g->model->energy_unit * ric_periodic_energy(g->model, end);
        out->period /= g->model->omega_ref;
        assert_int_equal(end->N, 2 * k - less);
        ric_periodic_free(end);
    }
    ric_continuation_free(tr);
    ric_periodic_free(cycle);
    free(u);
    return good;
}

/* Every impact of one is at the instant of one of the other, from any on and either way round. */
static double apart(const ending *few, const ending *many)
{
    double best = 1;
    for (int first = 0; first < many->n; first++)
        for (int way = 1; way >= -1; way -= 2) {
            double worst = 0;
            for (int i = 0; i < few->n; i++) {
                double nearest = 1;
                for (int j = 0; j < many->n; j++) {
                    double d = few->at[i] - way * (many->at[j] - many->at[first]);
                    nearest = fmin(nearest, fabs(d - rint(d)));
                }
                worst = fmax(worst, nearest);
            }
            best = fmin(best, worst);
        }
    return best;
}

static void check_loop(int k)
{
    ending end[2], way[2];
    ric_study *study;
    ric_graph *graph = NULL;
    int met = 0;
    families(k, end);
    parse(k, 4, &study);
    assert_int_equal(ric_graph_create(study, NULL, &graph), RIC_OK);
    for (int i = 0; i < 2; i++)
        if (follow(graph, k, 2 + i, 1, &way[i]) == follow(graph, k, 2 + i, -1, &way[i]))
            fail_msg("k = %d: %d impacts leave on both sides, or on none", k, 2 * k - 2 - i);
    for (int i = 0; i < 2; i++)
        for (int j = 0; j < 2; j++) {
            const bool same = fabs(way[i].energy / end[j].energy - 1) < SAME &&
                              fabs(way[i].period / end[j].period - 1) < SAME;
            const double off = apart(&way[i], &end[j]);
            if (!same) continue;
            print_message("# k = %d: ends differ by %.1e in energy, %.1e in period, %.1e in time\n",
                          k, way[i].energy / end[j].energy - 1, way[i].period / end[j].period - 1,
                          off);
            assert_true(off < TIME);
            met++;
        }
    if (met != 2)
        fail_msg("k = %d: %d of 2 branches from G_0,%d come to an end of a family", k, met, 2 * k);
    ric_graph_free(graph);
    ric_study_free(study);
}

static void close_at_the_grazing(void **state)
{
    (void)state;
    for (int k = 6; k <= MOST; k++)
        if (long_form() || k == 7 || k == 12) check_loop(k);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(close_at_the_grazing)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
