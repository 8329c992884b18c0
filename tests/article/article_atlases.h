/* The atlases that the statements of the article are checked against, each explored once, and what
 * one asks them. */
#ifndef ARTICLE_ATLASES_H
#define ARTICLE_ATLASES_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "explored.h"

/* Windows and budgets are as narrow as a statement allows: frequencies below bring in duplicates of
 * grazings with many touches. */
enum {
    ELEMENTARY,
    DUPLICATES,
    LOOP,
    TRIPLE,
    CHATTER,
    BACKBONE,
    PATH,
    TONGUES,
    LOCAL,
    CASCADE,
    FAR,
    FAR_TONGUES,
    BASE_4,
    BASE_5,
    BASE_6,
    TRIPLED,
    N_EXPLORED
};
static struct {
    const char *name, *explore;
    ric_atlas *atlas;
} explored[N_EXPLORED] = {
    {"elementary",
     "{start: modes, energy: [0, 200], frequency: [0.2, 10], impacts: 24, multiply: 1, depth: 4}",
     NULL},
    {"duplicates",
     "{start: modes, energy: [0, 200], frequency: [0.2, 10], impacts: 8, multiply: 2, depth: 1}",
     NULL},
    {"loop",
     "{start: [2], energy: [0, 100], frequency: [1, 40], impacts: 8, multiply: 9, depth: 2}", NULL},
    {"triple",
     "{start: [2], energy: [0, 60], frequency: [0.715, 40], impacts: 8, multiply: 4, depth: 3}",
     NULL},
    {"chatter",
     "{start: [2], energy: [0, 1500], frequency: [1.5, 100], impacts: 24, multiply: 12, depth: 2}",
     NULL},
    {"backbone",
     "{start: [1], energy: [0, 200], frequency: [0.92, 10], impacts: 8, multiply: 9, depth: 1}",
     NULL},
    {"path",
     "{start: [1], energy: [0, 10000], frequency: [0.9, 80], impacts: 22, multiply: 1, depth: 0, "
     "symmetric: true}",
     NULL},
    {"tongues",
     "{start: [1], energy: [0, 2000], frequency: [0.9, 10], impacts: 16, multiply: 1, depth: 0}",
     NULL},
    {"local",
     "{start: [2], energy: [0, 100], frequency: [0.82, 10], impacts: 12, multiply: 3, depth: 5}",
     NULL},
    {"cascade",
     "{start: [2], energy: [0, 60], frequency: [0.83, 10], impacts: 12, multiply: 4, depth: 3}",
     NULL},
    {"far",
     "{start: [1], energy: [0, 100000], frequency: [0.9, 80], impacts: 34, multiply: 1, depth: 0, "
     "symmetric: true}",
     NULL},
    {"far tongues",
     "{start: [1], energy: [0, 10000], frequency: [0.9, 10], impacts: 20, multiply: 1, depth: 0}",
     NULL},
    {"base 4",
     "{start: [2], energy: [0, 20], frequency: [0.53, 40], impacts: 8, multiply: 4, base: 4, "
     "depth: 3}",
     NULL},
    {"base 5",
     "{start: [2], energy: [0, 20], frequency: [0.43, 40], impacts: 10, multiply: 5, base: 5, "
     "depth: 3}",
     NULL},
    {"base 6",
     "{start: [2], energy: [0, 20], frequency: [0.358, 40], impacts: 12, multiply: 6, base: 6, "
     "depth: 0}",
     NULL},
    {"tripled",
     "{start: [2], energy: [0, 12], frequency: [0.59, 10], impacts: 12, multiply: 3, depth: 5}",
     NULL},
};
/* Those in which nothing is multiplied beyond the second mode's duplicates: what they contain does
 * not grow with the kinds of families that the program can follow. */
static const int settled[] = {ELEMENTARY, DUPLICATES, PATH, TONGUES};
enum { N_SETTLED = sizeof settled / sizeof *settled };

static const ric_atlas *atlas_of(int which)
{
    char text[512];
    if (explored[which].atlas) return explored[which].atlas;
    snprintf(text, sizeof text,
             "title: %s\nmodel:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n"
             "  contacts: [{name: stop, normal: [-1, 1], clearance: 1, sides: both, law: "
             "rigid}]\nexplore: %s\n",
             explored[which].name, explored[which].explore);
    explored[which].atlas = explore_text(text);
    return explored[which].atlas;
}

static ric_junction junction(int which, int id)
{
    ric_junction out;
    assert_int_equal(ric_atlas_junction(atlas_of(which), id, &out), RIC_OK);
    return out;
}

static ric_branch branch(int which, int id)
{
    ric_branch out;
    assert_int_equal(ric_atlas_branch(atlas_of(which), id, &out), RIC_OK);
    return out;
}

static ric_point point(int which, int id, int i)
{
    ric_point out;
    assert_int_equal(ric_atlas_point(atlas_of(which), id, i, &out, NULL, NULL), RIC_OK);
    return out;
}

static bool near(double a, double b)
{
    return fabs(a - b) <= 1e-9 * fmax(fabs(a), fabs(b));
}

/* The article's points with the numbers of the independent prototypes (relative accuracy 1e-9).
 * Names in small letters are ours. */
typedef struct {
    const char *name;
    ric_kind kind;
    double omega, energy;
    int impacts, grazings, multiple, a, b;
} place;
static const place places[] = {
    {"G1_0,2", RIC_KIND_GRAZING, 0.92873106504645, 0.601588369489, 0, 2, 1, 0, 0},
    {"G2_0,2", RIC_KIND_GRAZING, 2.15347593643804, 2.960911630511, 0, 2, 1, 0, 0},
    {"C1_31", RIC_KIND_EXTREMUM, 0.9615592867033224, 0.5935887039620914, 2, 0, 1, 3, 1},
    {"C2_31", RIC_KIND_EXTREMUM, 2.7537248237692933, 1.8245662467804078, 2, 0, 1, 3, 1},
    {"C1_32", RIC_KIND_BRANCH_POINT, 1.3820239896966182, 1.901327637945699, 2, 0, 1, 3, 2},
    {"G1_2,2", RIC_KIND_GRAZING, 1.3820239896966182, 2.5197414093965973, 2, 2, 1, 0, 0},
    {"G1_2,4", RIC_KIND_GRAZING, 1.6667902994358654, 80.97406747026484, 2, 4, 1, 0, 0},
    {"G2_4,2", RIC_KIND_GRAZING, 1.680665446, 28.644438205, 4, 2, 1, 0, 0},
    {"G1_4,2", RIC_KIND_GRAZING, 1.6983835151921738, 18.968887538984884, 4, 2, 1, 0, 0},
    {"C3_32", RIC_KIND_BRANCH_POINT, 1.673922264624197, 22.98740319908438, 6, 0, 1, 3, 2},
    {"S6 minimum", RIC_KIND_EXTREMUM, 1.6862160212567914, 3.8486931745366952, 6, 0, 1, 3, 1},
    {"C1_33", RIC_KIND_MULTIPLICATION, 1.6862380961394556, 3.8487372168924985, 2, 0, 3, 3, 3},
    {"C2_32", RIC_KIND_BRANCH_POINT, 1.6667902994358654, 16.13227945265392, 4, 0, 1, 3, 2},
    {"C3_31", RIC_KIND_EXTREMUM, 1.5192560925039564, 9.158308399286632, 4, 0, 1, 3, 1},
    {"C4_32", RIC_KIND_BRANCH_POINT, 1.5319867157145204, 15.557457022590903, 4, 0, 1, 3, 2},
    {"A5 C21", RIC_KIND_EXTREMUM, 1.679212540627532, 28.55821023511334, 5, 0, 1, 2, 1},
    {"G1_0,4", RIC_KIND_GRAZING, 2.15347593643804 / 2, 2.960911630511, 0, 2, 2, 0, 0},
    {"2 x G1_0,2", RIC_KIND_GRAZING, 0.92873106504645 / 2, 0.601588369489, 0, 2, 2, 0, 0},
    {"C6_33", RIC_KIND_MULTIPLICATION, 3.6000626807 / 2, 2.2556893214, 2, 0, 2, 3, 3},
    {"C5_33", RIC_KIND_MULTIPLICATION, 6.6353971937 / 4, 6.3037444738, 2, 0, 4, 3, 3},
    {"C7_33", RIC_KIND_MULTIPLICATION, 3.0317165407 / 3, 1.8899969588, 2, 0, 3, 3, 3},
};

static const place *place_named(const char *name)
{
    for (size_t i = 0; i < sizeof places / sizeof *places; i++)
        if (!strcmp(places[i].name, name)) return &places[i];
    fail_msg("no place %s", name);
    return NULL;
}

/* Id of the junction of that name: there exactly once, or 0. */
static int at(int which, const char *name)
{
    const place *p = place_named(name);
    int found = 0;
    for (int id = 1; id <= ric_atlas_n_junction(atlas_of(which)); id++) {
        ric_junction j = junction(which, id);
        if (j.kind != p->kind || !near(j.energy, p->energy) || !near(j.frequency, p->omega))
            continue;
        if (found) return 0;
        found = id;
    }
    return found;
}

/* The q-tupling p/q on a branch: how many, and in *id the last. */
static int multiplications(int which, int b, int p, int q, int *id)
{
    int n = 0;
    ric_branch row = branch(which, b);
    for (int i = 0; i < row.n_junction; i++) {
        ric_junction j = junction(which, row.junctions[i]);
        if (j.kind != RIC_KIND_MULTIPLICATION || strlen(row.label) < 2 || j.impacts != row.impacts)
            continue;
        if (j.rotation[0] != p || j.rotation[1] != q) continue;
        n++;
        if (id) *id = j.id;
    }
    return n;
}

static bool ends_at(ric_branch b, int id)
{
    return b.from == id || b.to == id;
}

static bool passes(ric_branch b, int id)
{
    for (int i = 0; i < b.n_junction; i++)
        if (b.junctions[i] == id) return true;
    return false;
}

/* The branch of that label with these two ends in either order (0: none, -1: any): there exactly
 * once, or 0. */
static int between(int which, const char *label, int one, int two)
{
    int found = 0;
    for (int id = 1; id <= ric_atlas_n_branch(atlas_of(which)); id++) {
        ric_branch b = branch(which, id);
        bool fits = ((one < 0 || b.from == one) && (two < 0 || b.to == two)) ||
                    ((two < 0 || b.from == two) && (one < 0 || b.to == one));
        if (!fits || strcmp(b.label, label)) continue;
        if (found) return 0;
        found = id;
    }
    return found;
}

/* How many branches of that label have an end at a junction; *last is one of them. */
static int leaving(int which, int id, const char *label, int *last)
{
    int n = 0;
    ric_junction j = junction(which, id);
    for (int i = 0; i < j.n_branch; i++) {
        ric_branch b = branch(which, j.branches[i]);
        if (!ends_at(b, id) || strcmp(b.label, label)) continue;
        n++;
        if (last) *last = b.id;
    }
    return n;
}

static int far_end(int which, int b, int id)
{
    ric_branch row = branch(which, b);
    return row.from == id ? row.to : row.from;
}

/* Arclength of a junction on a branch; its ends too (0: the beginning of a branch without one). */
static double place_on(int which, int b, int id)
{
    ric_branch row = branch(which, b);
    for (int i = 0; i < row.n_junction; i++)
        if (row.junctions[i] == id) return row.junction_at[i];
    return point(which, b, row.from == id ? 0 : row.n_point - 1).arclength;
}

/* Stability of the points strictly between two places of a branch: yes, no, or -1 if there are both
 * or none. Undecided points, at the ends of a segment, do not count. */
static int stable_between(int which, int b, int one, int two)
{
    double low = place_on(which, b, one), high = place_on(which, b, two), swap = low;
    int n[2] = {0, 0};
    if (low > high) low = high, high = swap;
    for (int i = 0; i < branch(which, b).n_point; i++) {
        ric_point p = point(which, b, i);
        if (p.arclength > low && p.arclength < high && p.stable != RIC_STABLE_UNDECIDED)
            n[p.stable == RIC_STABLE_YES]++;
    }
    return n[0] && n[1] ? -1 : n[1] ? 1 : n[0] ? 0 : -1;
}

/* Number of junctions of a kind on a branch, its ends not counted; ids in ascending order of
 * arclength. */
static int inner(int which, int b, ric_kind kind, int *ids, int room)
{
    int n = 0;
    ric_branch row = branch(which, b);
    for (int i = 0; i < row.n_junction; i++) {
        ric_junction j = junction(which, row.junctions[i]);
        if (j.kind != kind) continue;
        if (n < room) ids[n] = j.id;
        n++;
    }
    return n;
}

/* The q-fold orbit's own end of a family: number of branches with an end at the multiplication or
 * passing it as q times its word. */
static int families(int which, int id, int *ids, int room)
{
    int n = 0;
    ric_junction j = junction(which, id);
    for (int i = 0; i < j.n_branch; i++) {
        if (branch(which, j.branches[i]).impacts != j.multiple * j.impacts) continue;
        if (n < room) ids[n] = j.branches[i];
        n++;
    }
    return n;
}

/* Number of branches on the shortest way from one junction to another, -1 if there is none; their
 * labels in order. S branches count only if `symmetric`, A branches only if `asymmetric`, and the
 * branch `barred` never. Ends and interior junctions join alike. */
static int hops(int which, int from, int to, bool symmetric, bool asymmetric, int barred,
                char *labels, size_t size)
{
    int n = ric_atlas_n_junction(atlas_of(which)), first = 0, last = 0, steps = 0, by[64];
    int *queue = calloc((size_t)n + 1, sizeof *queue),
        *before = calloc((size_t)n + 1, sizeof *before), *via = calloc((size_t)n + 1, sizeof *via);
    queue[last++] = from;
    before[from] = -1;
    while (first < last && queue[first] != to) {
        int id = queue[first++];
        ric_junction j = junction(which, id);
        for (int i = 0; i < j.n_branch; i++) {
            ric_branch b = branch(which, j.branches[i]);
            if (b.id == barred || (b.symmetric ? !symmetric : !asymmetric)) continue;
            for (int k = -2; k < b.n_junction; k++) {
                int next = k == -2 ? b.from : k == -1 ? b.to : b.junctions[k];
                if (next == 0 || before[next] != 0) continue;
                before[next] = id, via[next] = b.id;
                queue[last++] = next;
            }
        }
    }
    if (to && before[to] != 0)
        for (int id = to; before[id] != -1 && steps < 64; id = before[id]) by[steps++] = via[id];
    bool reached = to && before[to] != 0;
    if (size) labels[0] = 0;
    for (int i = steps; i-- > 0 && size;) {
        size_t used = strlen(labels);
        snprintf(labels + used, size - used, "%s%s", used ? ", " : "", branch(which, by[i]).label);
    }
    free(queue), free(before), free(via);
    return reached ? steps : -1;
}

static void forget_atlases(void)
{
    for (int i = 0; i < N_EXPLORED; i++) ric_atlas_free(explored[i].atlas);
}

#endif
