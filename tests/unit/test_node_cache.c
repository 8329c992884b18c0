/* Junctions as bytes, as workers and other machines hand them on: they come back as they were, and
 * bytes that no program has written are refused. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "explored.h"
#include "junction/room.h"

/* Grazings, a corner, branch points and multiplications; touches of springs; orbits without events.
 */
static const char *const studies[] = {
    "model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n"
    "  contacts: [{normal: [-1, 1], clearance: 1}]\n"
    "explore: {energy: [0, 6], frequency: [0.3, 8], impacts: 6, multiply: 2, depth: 2}\n",
    "model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  contacts:\n"
    "    - {normal: [-1, 1], clearance: 1}\n"
    "    - {normal: [0, 1], clearance: 1.4, sides: upper, law: bilinear, stiffness: 3}\n"
    "explore: {energy: [0, 6], frequency: [0.3, 8], impacts: 4, multiply: 2, depth: 1}\n",
    "model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n"
    "  contacts: [{normal: [-1, 1], law: power, exponent: 3, stiffness: 2}]\n"
    "explore: {energy: [0, 6], frequency: [0.3, 8], multiply: 2, depth: 1}\n",
};

static void check_same(const ric_node *a, const ric_node *b)
{
    assert_int_equal(a->kind, b->kind);
    assert_true(a->energy == b->energy);
    assert_int_equal(a->n_touch, b->n_touch);
    assert_int_equal(a->n_departure, b->n_departure);
    for (int i = 0; i < a->n_departure; i++) {
        assert_int_equal(a->departures[i].choice, b->departures[i].choice);
        assert_int_equal(b->departures[i].state, RIC_DEPARTURE_OPEN);
    }
    assert_int_equal(a->cycle->N, b->cycle->N);
    assert_int_equal(!a->cycle->opposite, !b->cycle->opposite);
    assert_memory_equal(a->cycle->w, b->cycle->w, 2 * (size_t)a->cycle->n * sizeof *a->cycle->w);
}

/* A node comes back as it was, and has the same bytes then; what is cut off anywhere is refused. */
static void check_node(const ric_model *m, const ric_node *node)
{
    void *bytes, *again;
    size_t size, other;
    ric_node *back;
    assert_int_equal(ric_node_pack(node, &bytes, &size), RIC_OK);
    assert_int_equal(ric_node_unpack(m, bytes, size, &back), RIC_OK);
    check_same(node, back);
    assert_int_equal(ric_node_pack(back, &again, &other), RIC_OK);
    assert_int_equal(other, size);
    assert_memory_equal(again, bytes, size);
    ric_node_free(back);
    for (size_t length = 0; length < size; length += 1 + length / 16) {
        char *part = malloc(length + 1); /* so that a sanitizer sees what is read beyond */
        memcpy(part, bytes, length);
        assert_int_equal(ric_node_unpack(m, part, length, &back), RIC_E_FORMAT);
        assert_null(back);
        free(part);
    }
    free(again);
    free(bytes);
}

static void junctions_come_back(void **state)
{
    (void)state;
    unsigned kinds = 0;
    for (size_t k = 0; k < sizeof studies / sizeof *studies; k++) {
        ric_study *study = NULL;
        if (ric_study_parse(studies[k], "test", ".", &study)) fail_msg("%s", ric_detail());
        ric_graph *graph = explored_graph(study);
        for (int i = 0; i < graph->n_node; i++) {
            check_node(graph->model, graph->nodes[i]);
            kinds |= 1u << graph->nodes[i]->kind;
        }
        ric_graph_free(graph);
        ric_study_free(study);
    }
    const unsigned wanted = 1u << RIC_KIND_START | 1u << RIC_KIND_GRAZING |
                            1u << RIC_KIND_BRANCH_POINT | 1u << RIC_KIND_MULTIPLICATION;
    assert_int_equal(kinds & wanted, wanted);
}

/* Each single byte set to what it is not: no answer is a crash, and none is another structure's. */
static void damaged_bytes(void **state)
{
    (void)state;
    ric_study *study = NULL, *larger = NULL;
    assert_int_equal(ric_study_parse(studies[0], "test", ".", &study), RIC_OK);
    assert_int_equal(ric_study_parse("model:\n  mass: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\n"
                                     "  stiffness: [[2, -1, 0], [-1, 2, -1], [0, -1, 1]]\n"
                                     "  contacts: [{normal: [0, 0, 1], clearance: 1}]\n",
                                     "test", ".", &larger),
                     RIC_OK);
    ric_graph *graph = explored_graph(study);
    const ric_node *node = graph->nodes[graph->n_node - 1];
    unsigned char *bytes;
    size_t size;
    int refused = 0;
    assert_int_equal(ric_node_pack(node, (void **)&bytes, &size), RIC_OK);
    for (size_t i = 0; i < size; i++) {
        ric_node *back;
        bytes[i] = (unsigned char)~bytes[i];
        if (ric_node_unpack(graph->model, bytes, size, &back)) {
            refused++;
            assert_null(back);
        } else ric_node_free(back);
        bytes[i] = (unsigned char)~bytes[i];
    }
    assert_true(refused > 20);
    ric_node *back;
    assert_int_equal(ric_node_unpack(ric_study_model(larger), bytes, size, &back), RIC_E_FORMAT);
    assert_non_null(strstr(ric_detail(), "damaged"));
    free(bytes);
    ric_graph_free(graph);
    ric_study_free(study);
    ric_study_free(larger);
}

static void budgets_have_names(void **state)
{
    (void)state;
    for (int i = 0; i < RIC_N_BUDGET; i++) {
        assert_true(*ric_budget_text((ric_budget)i) != '\0');
        for (int k = 0; k < i; k++)
            assert_string_not_equal(ric_budget_text((ric_budget)i), ric_budget_text((ric_budget)k));
    }
    assert_string_equal(ric_budget_text(RIC_N_BUDGET), "");
}

/* Computed by a worker, taken out by the owner, and computed by the owner, for whom nothing is left
 * then. Returns how many touches the orbit has. */
static int check_touches(const ric_model *m, ric_cache *memo, const ric_periodic *cycle)
{
    bool *kept[3];
    ric_periodic *full[3];
    for (int way = 0; way < 3; way++)
        full[way] = ric_node_cache_touches(m, (ric_node_cache){memo, way == 0}, cycle, &kept[way]);
    for (int way = 1; way < 3; way++) {
        assert_int_equal(!full[0], !full[way]);
        if (!full[0]) continue;
        const size_t n = (size_t)full[0]->N;
        assert_int_equal(n, full[way]->N);
        assert_memory_equal(full[0]->tau, full[way]->tau, n * sizeof *full[0]->tau);
        assert_memory_equal(full[0]->face, full[way]->face, n * sizeof *full[0]->face);
        assert_memory_equal(kept[0], kept[way], n * sizeof **kept);
    }
    const int touches = full[0] ? full[0]->N - cycle->N : 0;
    for (int way = 0; way < 3; way++) {
        ric_periodic_free(full[way]);
        free(kept[way]);
    }
    return touches;
}

/* Of the orbits of grazings, without their touches. */
static void touches_come_back(void **state)
{
    (void)state;
    for (size_t k = 0; k < 2; k++) {
        ric_cache *memo;
        ric_study *study = NULL;
        int touches = 0;
        assert_int_equal(ric_study_parse(studies[k], "test", ".", &study), RIC_OK);
        ric_graph *graph = explored_graph(study);
        assert_int_equal(ric_cache_create(&memo), RIC_OK);
        for (int i = 0; i < graph->n_node; i++) {
            const ric_node *node = graph->nodes[i];
            if (node->kind != RIC_KIND_GRAZING) continue;
            ric_periodic *bare = ric_grazing_words_cycle(graph->model, node, 0);
            if (bare) touches += check_touches(graph->model, memo, bare);
            ric_periodic_free(bare);
        }
        assert_true(touches > 3);
        ric_cache_free(memo);
        ric_graph_free(graph);
        ric_study_free(study);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(junctions_come_back),
        cmocka_unit_test(touches_come_back),
        cmocka_unit_test(damaged_bytes),
        cmocka_unit_test(budgets_have_names),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
