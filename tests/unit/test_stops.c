/* Runs that are stopped again and again, in the midst of whatever they do: each comes a step
 * further, what it leaves is an atlas with no less than there was before, and the last one ends
 * with the bits of a run that nobody has disturbed. */
#include "stored_atlases.h"

#include "junction/switching.h"
#include "explored.h"
#include "branch/continuation_pause.h"
#include "base/halt.h"
#include "sample.h"

/* Asked by the kernels about every millisecond of work: from the `after`-th question on which
 * something new has been kept, the answer is yes. */
typedef struct {
    int asked, after;
} impatience;

static bool impatient(const ric_progress *now, void *user)
{
    impatience *i = user;
    return ++i->asked > i->after && now->fresh > 0;
}

static ric_atlas *read_back(const char *path)
{
    ric_atlas *atlas = NULL;
    if (ric_atlas_read(path, &atlas)) fail_msg("%s: %s", path, ric_detail());
    return atlas;
}

/* What a stopped run leaves: no junction without a label may look as if it had one. */
static int count_unmeasured(const ric_atlas *atlas)
{
    int n = 0;
    for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
        ric_junction j;
        assert_int_equal(ric_atlas_junction(atlas, id, &j), RIC_OK);
        if (j.label[0] != 'C') continue;
        assert_int_equal(j.b == 0, strstr(j.label, "??") != NULL);
        n += j.b == 0;
    }
    return n;
}

/* The number of stops until the run has come to its end; *unmeasured: of them with labels left. */
static int run_in_pieces(const ric_study *study, const char *path, int workers, int *unmeasured)
{
    int stops = 0, most = 0;
    for (ric_status status = RIC_E_INTERRUPTED; status; stops++) {
        impatience i = {.after = stops % 7 * stops % 5};
        const ric_run_options options = {.workers = workers, .progress = impatient, .user = &i};
        status = ric_explore(study, path, &options);
        if (status && status != RIC_E_INTERRUPTED) fail_msg("%s", ric_detail());
        ric_atlas *atlas = read_back(path);
        assert_int_equal(ric_atlas_finished(atlas), status == RIC_OK);
        *unmeasured += count_unmeasured(atlas) > 0;
        if (status && ric_atlas_n_branch(atlas) < most)
            fail_msg("%d branches after %d stops, where there have been %d",
                     ric_atlas_n_branch(atlas), stops, most);
        most = ric_atlas_n_branch(atlas);
        ric_atlas_free(atlas);
        if (stops > 3000) fail_msg("stopped %d times, and no end", stops);
    }
    return stops - 1;
}

static void stop_and_compare(const char *text, int least)
{
    char home[] = "/tmp/ricochet-stops-XXXXXX", whole[64], pieces[64];
    ric_study *study = study_of(text);
    assert_non_null(mkdtemp(home));
    snprintf(whole, sizeof whole, "%s/whole", home);
    assert_int_equal(ric_explore(study, whole, NULL), RIC_OK);
    ric_atlas *undisturbed = read_back(whole);
    for (int workers = 1; workers <= 2; workers++) {
        int unmeasured = 0;
        snprintf(pieces, sizeof pieces, "%s/pieces-%d", home, workers);
        int stops = run_in_pieces(study, pieces, workers, &unmeasured);
        ric_atlas *atlas = read_back(pieces);
        assert_true(same_atlas(atlas, undisturbed));
        print_message("%d branches: %d stops, %d of them with labels left\n",
                      ric_atlas_n_branch(atlas), stops, unmeasured);
        if (workers == 1) assert_true(stops >= least);
        ric_atlas_free(atlas);
        unlink(pieces);
    }
    ric_atlas_free(undisturbed);
    unlink(whole);
    rmdir(home);
    ric_study_free(study);
}

#define PAIR                                                                                       \
    "title: A pair\nmodel:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  "         \
    "contacts:\n"

static void stops_and_branches(void **state)
{
    (void)state;
    stop_and_compare(
        PAIR
        "    - {normal: [-1, 1], clearance: 1, law: rigid}\n"
        "explore: {energy: [0, 60], frequency: [0.2, 10], impacts: 6, multiply: 2, depth: 2}\n",
        20);
}

static void springs(void **state)
{
    (void)state;
    stop_and_compare(
        PAIR
        "    - {normal: [-1, 1], clearance: 1, law: bilinear, stiffness: 20}\n"
        "explore: {energy: [0, 20], frequency: [0.2, 10], impacts: 4, multiply: 2, depth: 1}\n",
        5);
}

/* Single branches take longer than a run is given. */
static void power_law(void **state)
{
    (void)state;
    stop_and_compare(PAIR
                     "    - {normal: [-1, 1], law: power, exponent: 9, length: 1, reference: 1}\n"
                     "explore: {energy: [0, 20], frequency: [0.2, 10], multiply: 2, depth: 1}\n",
                     20);
}

/* A branch of which there is no more than its first points has room for all that follow when it
 * goes on. */
static void after_the_first_points(void **state)
{
    (void)state;
    ric_study *study = study_of(
        PAIR "    - {normal: [-1, 1], clearance: 1, law: rigid}\n"
             "explore: {energy: [0, 60], frequency: [0.2, 10], impacts: 2, depth: 0}\n");
    ric_graph *g = explored_graph(study);
    ric_outset from;
    ric_continuation *whole = NULL, *piece = NULL;
    const ric_node *node = NULL;
    unsigned choice = 0;
    for (int i = 0; i < g->n_node && !node; i++)
        for (int k = 0; k < g->nodes[i]->n_departure && !node; k++) {
            if (g->nodes[i]->departures[k].state != RIC_DEPARTURE_TAKEN) continue;
            node = g->nodes[i];
            choice = node->departures[k].choice;
        }
    assert_non_null(node);
    if (ric_switching_depart(g->model, node, choice, 1, &from) ||
        ric_continuation_create(from.chain, from.u, from.t, from.ignore, &g->limits, &whole))
        fail_msg("%s", ric_detail());
    from.chain = NULL;
    for (bool done = false; !done && whole->n_point <= 4;) {
        void *blob = NULL;
        size_t size;
        int parts;
        assert_int_equal(ric_continuation_pause(whole, 0, &blob, &size), RIC_OK);
        assert_int_equal(ric_continuation_resume(g->model, &g->limits, blob, size, &parts, &piece),
                         RIC_OK);
        assert_int_equal(ric_continuation_run(piece), RIC_OK);
        assert_true(piece->n_point > 20 && piece->n_point <= piece->point_capacity);
        ric_continuation_free(piece);
        free(blob);
        assert_int_equal(ric_continuation_advance(whole, &done), RIC_OK);
    }
    ric_continuation_free(whole);
    ric_outset_clear(&from);
    ric_graph_free(g);
    ric_study_free(study);
}

/* By chance, every second time: a step that takes several questions comes to its end now and then.
 */
static bool now_and_then(void *user)
{
    unsigned *bits = user;
    *bits = *bits * 1664525u + 1013904223u;
    return *bits >> 31 == 0;
}

/* After each step: the next question, which is put after a million multiplications, comes somewhere
 * in the step ahead. */
static void ahead(void *user)
{
    unsigned *bits = user;
    *bits = *bits * 1664525u + 1013904223u;
    ric_halt(1e6 - 2e4 * (*bits >> 8) / (1 << 24));
}

/* Wherever in a step a stop comes, also while the flag of a point beside the border of stability is
 * measured, which is most of the work there: the branch goes on with the same points. */
static void in_the_midst_of_a_step(void **state)
{
    (void)state;
    ric_study *study = study_of(
        PAIR "    - {normal: [-1, 1], clearance: 1, law: rigid}\n"
             "explore: {energy: [0, 1000], frequency: [0.2, 10], impacts: 6, depth: 0}\n");
    ric_graph *g = explored_graph(study);
    unsigned bits = 1;
    int stops = 0, branches = 0;
    g->limits.max_step = 0.003;
    g->limits.stepped = ahead;
    g->limits.user = &bits;
    for (int i = 0; i < g->n_node; i++)
        for (int k = 0; k < g->nodes[i]->n_departure && branches < 10; k++) {
            const ric_departure *d = &g->nodes[i]->departures[k];
            ric_continuation *tr[2] = {NULL, NULL};
            for (int piece = 0; piece < 2 && d->state == RIC_DEPARTURE_TAKEN; piece++) {
                ric_outset from;
                if (!ric_switching_depart(g->model, g->nodes[i], d->choice, 1, &from) && from.chain)
                    assert_int_equal(ric_continuation_create(from.chain, from.u, from.t,
                                                             from.ignore, &g->limits, &tr[piece]),
                                     RIC_OK);
                from.chain = NULL;
                ric_status status = RIC_E_INTERRUPTED;
                while (tr[piece] && status == RIC_E_INTERRUPTED) {
                    if (piece) ric_halt_ask(now_and_then, &bits);
                    status = ric_continuation_run(tr[piece]);
                    ric_halt_ask(NULL, NULL);
                    stops += status == RIC_E_INTERRUPTED;
                }
                ric_outset_clear(&from);
            }
            if (tr[0] && tr[1]) {
                branches++;
                assert_int_equal(tr[1]->n_point, tr[0]->n_point);
                assert_int_equal(tr[1]->stride, tr[0]->stride);
                assert_memory_equal(tr[1]->points, tr[0]->points,
                                    (size_t)tr[0]->n_point * tr[0]->stride * sizeof(double));
            }
            ric_continuation_free(tr[0]);
            ric_continuation_free(tr[1]);
        }
    print_message("# %d branches, %d stops\n", branches, stops);
    assert_true(branches > 3 && stops > 20);
    ric_graph_free(g);
    ric_study_free(study);
}

static bool yes(void *user)
{
    (void)user;
    return true;
}

/* A stop that comes when the solver of a junction has not flown once: it comes to an end, and
 * nothing is found. */
static void before_the_first_flight(void **state)
{
    (void)state;
    static const int tests[] = {RIC_TEST_REACH,  RIC_TEST_DET,      RIC_TEST_SLOPE,
                                RIC_TEST_A,      RIC_TEST_B,        RIC_TEST_D,
                                RIC_TEST_PERIOD, RIC_TEST_APPROACH, RIC_TEST_FLIGHT};
    ric_study *study = study_of(
        PAIR "    - {normal: [-1, 1], law: power, exponent: 3, length: 1, reference: 1}\n"
             "explore: {energy: [0, 2], frequency: [0.2, 10], multiply: 1, depth: 0}\n");
    ric_graph *g = explored_graph(study);
    assert_true(g->n_node > 0);
    alarm(20); /* it has gone round for ever */
    ric_halt_ask(yes, NULL);
    assert_true(ric_halt(HUGE_VAL));
    for (size_t i = 0; i < sizeof tests / sizeof *tests; i++) {
        ric_node *out = NULL;
        ric_node_interior(g->model, g->nodes[0]->cycle, tests[i], &out);
        assert_null(out);
    }
    ric_halt_ask(NULL, NULL);
    alarm(0);
    ric_graph_free(g);
    ric_study_free(study);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(before_the_first_flight),
        cmocka_unit_test(after_the_first_points),
        cmocka_unit_test(in_the_midst_of_a_step),
        cmocka_unit_test(stops_and_branches),
        cmocka_unit_test(springs),
        cmocka_unit_test(power_law),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
