/* The section drawing: where the nodes of a structure are, and which displacements move them. It is
 * for pictures alone; the model does not know it. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "options.h"
#include "study_parts.h"

enum { AXES = 3, NODES_MAX = 100000, LINES_MAX = 1000000 };

void ric_study_drawing_free(ric_drawing *d)
{
    free(d->nodes);
    free(d->lines);
    *d = (ric_drawing){.n_node = 0};
}

/* A list of one to three numbers; how many. */
static ric_status read_axes(const ric_yaml *r, const ric_yaml_node *value, const char *key,
                            double out[AXES], int *n)
{
    if (!ric_yaml_is_list(value) || ric_yaml_length(value) < 1 || ric_yaml_length(value) > AXES)
        return ric_yaml_wrong(r, value, key,
                              "expected a list of one to three numbers, one for each direction");
    *n = ric_yaml_length(value);
    for (int i = 0; i < *n; i++) {
        ric_status status = ric_yaml_real(r, ric_yaml_item(r, value, i), key, &out[i]);
        if (status) return status;
    }
    return RIC_OK;
}

static ric_status read_node(const ric_yaml *r, const ric_yaml_node *map, const char *path,
                            int n_dof, ric_drawing_node *out)
{
    static const char *const keys[] = {"at", "moves"};
    ric_yaml_slot slots[2];
    char key[RIC_KEY_MAX];
    double moves[AXES] = {0};
    int n = 0, n_move = 0;
    ric_status status = ric_yaml_map(r, map, path, 2, keys, slots);
    if (status) return status;
    ric_yaml_join(key, path, "at");
    if (!slots[0].key)
        return ric_yaml_wrong(r, map, key, "missing; a node is {at: [0.5, 0], moves: [0, 3]}");
    if ((status = read_axes(r, slots[0].value, key, out->at, &n))) return status;
    ric_yaml_join(key, path, "moves");
    if (slots[1].key && (status = read_axes(r, slots[1].value, key, moves, &n_move))) return status;
    if (n_move > n)
        return ric_yaml_wrong(r, slots[1].value, key, "%d directions, but the node lies in %d",
                              n_move, n);
    for (int i = 0; i < n_move; i++) {
        if (moves[i] != floor(moves[i]) || moves[i] < 0 || moves[i] > n_dof)
            return ric_yaml_wrong(r, slots[1].value, key,
                                  "%.10g is no displacement; give the number of one, 1 to %d, or 0 "
                                  "for a direction in "
                                  "which the node does not move",
                                  moves[i], n_dof);
        out->moves[i] = (int)moves[i];
    }
    return RIC_OK;
}

static ric_status read_nodes(const ric_yaml *r, const ric_yaml_node *list, int n_dof,
                             ric_drawing *out)
{
    char key[RIC_KEY_MAX];
    const int n = ric_yaml_is_list(list) ? ric_yaml_length(list) : 0;
    if (n < 1 || n > NODES_MAX)
        return ric_yaml_wrong(
            r, list, "drawing.nodes",
            "expected a list of 1 to %d nodes, such as [{at: [0.5, 0], moves: [0, 3]}]", NODES_MAX);
    out->nodes = ric_calloc((size_t)n, sizeof *out->nodes);
    if (!out->nodes) return ric_yaml_no_memory(r);
    out->n_node = n;
    for (int i = 0; i < n; i++) {
        snprintf(key, sizeof key, "drawing.nodes[%d]", i + 1);
        ric_status status = read_node(r, ric_yaml_item(r, list, i), key, n_dof, &out->nodes[i]);
        if (status) return status;
    }
    return RIC_OK;
}

static ric_status read_lines(const ric_yaml *r, const ric_yaml_node *list, ric_drawing *out)
{
    char key[RIC_KEY_MAX];
    const int n = ric_yaml_is_list(list) ? ric_yaml_length(list) : 0;
    if (n < 1 || n > LINES_MAX)
        return ric_yaml_wrong(r, list, "drawing.lines",
                              "expected a list of 1 to %d pairs of nodes, such as [[1, 2]]",
                              LINES_MAX);
    out->lines = ric_calloc((size_t)n, sizeof *out->lines);
    if (!out->lines) return ric_yaml_no_memory(r);
    for (int i = 0; i < n; i++) {
        const ric_yaml_node *pair = ric_yaml_item(r, list, i);
        double ends[AXES];
        int count = 0;
        snprintf(key, sizeof key, "drawing.lines[%d]", i + 1);
        ric_status status = read_axes(r, pair, key, ends, &count);
        if (status) return status;
        for (int k = 0; k < count; k++)
            if (ends[k] != floor(ends[k]) || ends[k] < 1 || ends[k] > out->n_node) count = 0;
        if (count != 2)
            return ric_yaml_wrong(r, pair, key, "a line joins two nodes by their numbers, 1 to %d",
                                  out->n_node);
        for (int k = 0; k < 2; k++) out->lines[i].ends[k] = (int)ends[k];
        out->n_line = i + 1;
    }
    return RIC_OK;
}

ric_status ric_study_drawing_read(const ric_yaml *r, const ric_yaml_slot *from, int n_dof,
                                  ric_drawing *out)
{
    static const char *const keys[] = {"nodes", "lines"};
    ric_yaml_slot slots[2];
    if (!from->key) return RIC_OK;
    ric_status status = ric_yaml_map(r, from->value, "drawing", 2, keys, slots);
    if (status) return status;
    if (!slots[0].key)
        return ric_yaml_wrong(
            r, from->value, "drawing.nodes",
            "missing; give a list such as [{at: [0, 0]}, {at: [0.5, 0], moves: [0, 3]}]");
    status = read_nodes(r, slots[0].value, n_dof, out);
    return status || !slots[1].key ? status : read_lines(r, slots[1].value, out);
}

void ric_study_drawing_write(const ric_drawing *d, FILE *out)
{
    if (!d->n_node) return;
    fputs("drawing:\n  nodes:\n", out);
    for (int i = 0; i < d->n_node; i++) {
        const ric_drawing_node *node = &d->nodes[i];
        fputs("    - {at: [", out);
        for (int k = 0; k < AXES; k++) {
            if (k) fputs(", ", out);
            ric_option_text_write(node->at[k], out);
        }
        fprintf(out, "], moves: [%d, %d, %d]}\n", node->moves[0], node->moves[1], node->moves[2]);
    }
    if (d->n_line) fputs("  lines:\n", out);
    for (int i = 0; i < d->n_line; i++)
        fprintf(out, "    - [%d, %d]\n", d->lines[i].ends[0], d->lines[i].ends[1]);
}
