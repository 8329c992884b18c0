/* What sections 2.2 and 3.3 of the article state about the two masses with power-law springs,
 * looked up in atlases for n = 3, 7 and 21; a part of docs/article.md. Each entry computes what
 * there is, says it with digits, and compares. */
#define _GNU_SOURCE
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "explored.h"
#include "article_page.h"

/* SIDES: n = 21 with its side branches, those of them too */
enum { CUBIC, SEVENTH, HIGH, SIDES, N_ATLAS };
enum { N_EXPONENT = HIGH + 1 };
static const int exponent_of[] = {3, 7, 21, 21};
static const char *const window_of[] =
    {"energy: [0, 3000], frequency: [0.1, 10], multiply: 8, depth: 1",
     "energy: [0, 1000], frequency: [0.1, 10], multiply: 2, depth: 1",
     "energy: [0, 1000], frequency: [0.1, 10], multiply: 2, depth: 1",
     "energy: [0, 100], frequency: [0.9, 10], multiply: 1, depth: 3"};
static ric_atlas *atlases[N_ATLAS];

static int explore_all(void **state)
{
    (void)state;
    for (int i = 0; i < N_ATLAS; i++) {
        char text[700];
        snprintf(text, sizeof text,
                 "title: section 3.3\nmodel: {mass: [[2, 0], [0, 1]], stiffness: [[9, -1], [-1, "
                 "1]], contacts: "
                 "[{normal: [-1, 1], law: power, exponent: %d, length: 1, reference: 1}]}\n"
                 "explore: {%s}\n",
                 exponent_of[i], window_of[i]);
        atlases[i] = explore_text(text);
    }
    return 0;
}

static int free_all(void **state)
{
    (void)state;
    for (int i = 0; i < N_ATLAS; i++) ric_atlas_free(atlases[i]);
    return 0;
}

/* ------------------------------------------------------------------ looking up */

static ric_branch backbone(int which, int mode)
{
    for (int id = 1; id <= ric_atlas_n_branch(atlases[which]); id++) {
        ric_branch b = branch_of(atlases[which], id);
        if (b.mode == mode && b.depth == 1) return b;
    }
    fail_msg("no backbone of mode %d", mode);
    return (ric_branch){0};
}

static ric_junction junction_at(int which, const ric_branch *b, int place)
{
    return junction_of(atlases[which], b->junctions[place]);
}

/* Place on the in-phase path of the first junction of a kind behind place `from`; -1: none. */
static int find(int which, const ric_branch *b, int from, ric_kind kind)
{
    for (int i = from + 1; i < b->n_junction; i++) {
        ric_junction j = junction_at(which, b, i);
        /* one that the path goes through */
        bool wanted = kind != RIC_KIND_MULTIPLICATION ||
                      (j.multiple == 3 && ric_junction_level(&j, b) == 1);
        if (j.kind == kind && wanted) return i;
    }
    return -1;
}

/* The places that the article names: C1_32, C1_33, C3_31 (the least energy behind the turning at
 * C1_33), C4_32. */
typedef struct {
    ric_branch b;
    int c32, c33, fold, c31, last;
} path;

static path path_of(int which)
{
    path p = {.b = backbone(which, 1)};
    p.c32 = find(which, &p.b, -1, RIC_KIND_BRANCH_POINT);
    p.c33 = find(which, &p.b, p.c32, RIC_KIND_MULTIPLICATION);
    for (int i = p.c33 - 1; i <= p.c33 + 1;
         i++) /* the turning lies close by, on one side or the other */
        if (junction_at(which, &p.b, i).kind == RIC_KIND_EXTREMUM &&
            fabs(junction_at(which, &p.b, i).energy / junction_at(which, &p.b, p.c33).energy - 1) <
                1e-4)
            p.fold = i;
    int top = find(which, &p.b, p.fold > p.c33 ? p.fold : p.c33, RIC_KIND_EXTREMUM);
    p.c31 = top < 0 ? -1 : find(which, &p.b, top, RIC_KIND_EXTREMUM);
    p.last = p.c31 < 0 ? -1 : find(which, &p.b, p.c31, RIC_KIND_BRANCH_POINT);
    return p;
}

/* Stability of the points of a branch strictly between two arclengths: 1 all stable, 0 all
 * unstable, -1 mixed or none. */
static int stable_between(int which, const ric_branch *b, double from, double to)
{
    int yes = 0, no = 0;
    for (int i = 0; i < b->n_point; i++) {
        ric_point p;
        assert_int_equal(ric_atlas_point(atlases[which], b->id, i, &p, NULL, NULL), RIC_OK);
        if (p.arclength <= from + 1e-9 || p.arclength >= to - 1e-9 ||
            p.stable == RIC_STABLE_UNDECIDED)
            continue;
        yes += p.stable == RIC_STABLE_YES;
        no += p.stable == RIC_STABLE_NO;
    }
    return yes && !no ? 1 : no && !yes ? 0 : -1;
}

/* ------------------------------------------------------------------- statements */

typedef struct {
    const char *where, *statement;
    bool (*check)(int which, char *found, size_t size);
    int which;
    const char *
        instead; /* NULL: the check looks for what is stated; else for this, which contradicts it */
} entry;

static bool labelled(int which, int place, int a, int b, char *found, size_t size)
{
    if (place < 0) {
        snprintf(found, size, "there is none");
        return false;
    }
    path p = path_of(which);
    ric_junction j = junction_at(which, &p.b, place);
    snprintf(found, size, "%s C_%d%d at E %.9g, omega %.9g", ric_kind_text(j.kind), j.a, j.b,
             j.energy, j.frequency);
    return j.a == a && j.b == b;
}

static bool c32_inherited(int which, char *found, size_t size)
{
    return labelled(which, path_of(which).c32, 3, 2, found, size);
}
static bool c33_inherited(int which, char *found, size_t size)
{
    return labelled(which, path_of(which).c33, 3, 3, found, size);
}
static bool c31_inherited(int which, char *found, size_t size)
{
    return labelled(which, path_of(which).c31, 3, 1, found, size);
}
static bool last_inherited(int which, char *found, size_t size)
{
    return labelled(which, path_of(which).last, 3, 2, found, size);
}

/* The turning at C33 divides the path: the part next to it that is stable. */
static void beside_turning(int which, int *before, int *after, double *lower_before)
{
    path p = path_of(which);
    int first = p.fold < p.c33 ? p.fold : p.c33, second = first == p.fold ? p.c33 : p.fold;
    double from = p.b.junction_at[first], to = p.b.junction_at[second];
    *before = stable_between(which, &p.b, p.b.junction_at[first - 1], from);
    *after = stable_between(which, &p.b, to, p.b.junction_at[second + 1]);
    *lower_before = junction_at(which, &p.b, first).frequency <
                    junction_at(which, &p.b, second).frequency;
}

static bool stable_is(int which, bool first, char *found, size_t size)
{
    int before, after;
    double lower;
    beside_turning(which, &before, &after, &lower);
    snprintf(found, size, "before: %s, after: %s", before == 1 ? "stable" : "unstable",
             after == 1 ? "stable" : "unstable");
    return before == (first ? 1 : 0) && after == (first ? 0 : 1);
}

static bool stable_after(int which, char *found, size_t size)
{
    return stable_is(which, false, found, size);
}

static bool stable_before(int which, char *found, size_t size)
{
    return stable_is(which, true, found, size);
}

static bool stable_at_lower_frequency(int which, char *found, size_t size)
{
    int before, after;
    double lower_before;
    beside_turning(which, &before, &after, &lower_before);
    snprintf(found, size, "the part %s the turning is at the lower frequency and %s",
             lower_before ? "before" : "behind",
             (lower_before ? before : after) == 1 ? "stable" : "unstable");
    return (lower_before ? before : after) == 1 && (lower_before ? after : before) == 0;
}

/* Energies of C33 fall and frequencies rise from n = 3 over 7 and 21 to the stops. */
static bool more_energy_less_frequency(int which, char *found, size_t size)
{
    double energy[N_EXPONENT] = {0}, frequency[N_EXPONENT] = {0};
    (void)which;
    for (int i = CUBIC; i <= HIGH; i++) {
        path p = path_of(i);
        ric_junction j = junction_at(i, &p.b, p.c33);
        energy[i] = j.energy;
        frequency[i] = j.frequency;
    }
    snprintf(found, size, "C33 at E %.6g, %.6g, %.6g and omega %.6g, %.6g, %.6g", energy[0],
             energy[1], energy[2], frequency[0], frequency[1], frequency[2]);
    return energy[0] > energy[1] && energy[1] > energy[2] && energy[2] > 3.8487 &&
           frequency[0] < frequency[1] && frequency[1] < frequency[2];
}

/* The first branch point goes towards that of the stops, E 1.9013, omega 1.3820. */
static bool smooth_transformation(int which, char *found, size_t size)
{
    double off[3], at[3];
    (void)which;
    for (int i = CUBIC; i <= HIGH; i++) {
        path p = path_of(i);
        ric_junction j = junction_at(i, &p.b, p.c32);
        at[i] = j.energy;
        off[i] = hypot(j.energy - 1.9013, j.frequency - 1.3820);
    }
    snprintf(found, size, "C32 at E %.6g, %.6g, %.6g, for stops 1.9013", at[0], at[1], at[2]);
    return off[0] > off[1] && off[1] > off[2];
}

/* C33 lies on the 3-duplicate of the out-of-phase mode. */
static bool on_triple_of_other_mode(int which, char *found, size_t size)
{
    path p = path_of(which);
    ric_branch other = backbone(which, 2);
    ric_junction j = junction_at(which, &p.b, p.c33);
    bool shared = false;
    for (int i = 0; i < other.n_junction; i++) shared |= other.junctions[i] == j.id;
    snprintf(found, size, "rotation %d/%d of branch %s", j.rotation[0], j.rotation[1], other.label);
    return shared && j.multiple == 3;
}

static int extrema_on(int which, const ric_branch *b)
{
    int count = 0;
    for (int i = 0; i < b->n_junction; i++)
        count += junction_at(which, b, i).kind == RIC_KIND_EXTREMUM;
    return count;
}

static bool twisting_corner(int which, char *found, size_t size)
{
    ric_branch b = backbone(which, 2);
    int count = extrema_on(which, &b), unstable = 0, c31 = 0;
    for (int i = 0; i < b.n_point; i++) {
        ric_point p;
        assert_int_equal(ric_atlas_point(atlases[which], b.id, i, &p, NULL, NULL), RIC_OK);
        unstable += p.stable == RIC_STABLE_NO;
    }
    for (int i = 0; i < b.n_junction; i++) {
        ric_junction j = junction_at(which, &b, i);
        c31 += j.kind == RIC_KIND_EXTREMUM && j.a == 3 && j.b == 1;
    }
    snprintf(found, size, "%d extrema, %d of them C_31, %d of %d points unstable", count, c31,
             unstable, b.n_point);
    return c31 > 0 && unstable > 0 && b.stable_fraction > 0.5;
}

static bool no_twist(int which, char *found, size_t size)
{
    ric_branch b = backbone(which, 2);
    int count = extrema_on(which, &b);
    snprintf(found, size, "%d extrema, stable fraction %.3g", count, b.stable_fraction);
    return count == 0 && b.stable_fraction > 0.999;
}

/* Branches without mirror points that join the two families of the loop, for n = 7, 9, 11 and 21.
 */
static bool bridges_cease(int which, char *found, size_t size)
{
    static const int exponents[] = {7, 9, 11, 21}, expected[] = {0, 2, 1, 1};
    bool right = true;
    size_t used = 0;
    (void)which;
    for (int i = 0; i < 4; i++) {
        char text[500];
        int bridges = 0, reversible = 0;
        snprintf(text, sizeof text,
                 "model: {mass: [[2, 0], [0, 1]], stiffness: [[9, -1], [-1, 1]], contacts: "
                 "[{normal: [-1, 1], law: "
                 "power, exponent: %d, length: 1, reference: 1}]}\nexplore: {start: [2], energy: "
                 "[0, 16], frequency: "
                 "[1, 4], multiply: 2, depth: 3}\n",
                 exponents[i]);
        ric_atlas *atlas = explore_text(text);
        for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
            ric_branch b = branch_of(atlas, id);
            reversible += b.reversible && b.mode == 0;
            bridges += !b.reversible && b.from && b.to && junction_of(atlas, b.from).b == 2 &&
                       junction_of(atlas, b.to).b == 2;
        }
        ric_atlas_free(atlas);
        right = right && bridges == expected[i] && reversible == 2;
        used += (size_t)snprintf(found + used, size - used, "%sn = %d: %d", i ? ", " : "",
                                 exponents[i], bridges);
    }
    return right;
}

/* Multiplications p/8, reduced, between two junctions of the cubic path. */
static int eighths(const ric_branch *b, int from, int to)
{
    int count = 0;
    for (int i = from + 1; i < to; i++) {
        ric_junction j = junction_at(CUBIC, b, i);
        count += j.kind == RIC_KIND_MULTIPLICATION && 8 % j.multiple == 0;
    }
    return count;
}

static bool seven_on_segment(int which, char *found, size_t size)
{
    path p = path_of(which);
    int point = find(which, &p.b, p.c32, RIC_KIND_BRANCH_POINT),
        extremum = find(which, &p.b, point, RIC_KIND_EXTREMUM);
    int n = point < 0 || extremum < 0 ? -1 : eighths(&p.b, point, extremum);
    snprintf(found, size, "%d between omega %.5g and %.5g", n,
             junction_at(which, &p.b, point).frequency,
             junction_at(which, &p.b, extremum).frequency);
    return n == 7;
}

static bool none_behind_c33(int which, char *found, size_t size)
{
    path p = path_of(which);
    int extremum = find(which, &p.b, p.fold, RIC_KIND_EXTREMUM),
        n = eighths(&p.b, p.fold, extremum);
    snprintf(found, size, "%d between omega %.5g and %.5g", n,
             junction_at(which, &p.b, p.fold).frequency,
             junction_at(which, &p.b, extremum).frequency);
    return n == 0;
}

/* No grazing at finite n. */
static bool nothing_grazes(int which, char *found, size_t size)
{
    int count = 0;
    for (int id = 1; id <= ric_atlas_n_junction(atlases[which]); id++)
        count += junction_of(atlases[which], id).kind == RIC_KIND_GRAZING;
    snprintf(found, size, "%d grazings, with stops there are some", count);
    return count == 0;
}

/* Critical points at n = 21 near the place of G1_2,4 of the stops, which is one point there. */
static bool scattered(int which, char *found, size_t size)
{
    path p = path_of(which);
    int count = 0;
    for (int i = 0; i < p.c33; i++) {
        ric_junction j = junction_at(which, &p.b, i);
        count += i > p.c32 && (j.kind == RIC_KIND_BRANCH_POINT || j.kind == RIC_KIND_EXTREMUM) &&
                 j.energy > 50;
    }
    snprintf(found, size, "%d critical points of the path between C32 and C33 far above both",
             count);
    return count >= 3;
}

/* -------------------------------------------------- side branches at n = 21 */

/* The branch of n = 21 that leaves the in-phase path at the counterpart of C1_32. */
static bool first_side_branch(ric_branch *out)
{
    path p = path_of(SIDES);
    ric_junction c = junction_at(SIDES, &p.b, p.c32);
    for (int i = 0; i < c.n_branch; i++) {
        *out = branch_of(atlases[SIDES], c.branches[i]);
        if (out->id != p.b.id) return true;
    }
    return false;
}

static bool on(const ric_branch *b, int id)
{
    bool there = b->from == id || b->to == id;
    for (int i = 0; i < b->n_junction; i++) there = there || b->junctions[i] == id;
    return there;
}

/* The one symmetric branch without mirror points, both ends of it on the path. */
static bool bridge_on_the_backbone(int which, char *found, size_t size)
{
    path p = path_of(which);
    int count = 0;
    for (int id = 1; id <= ric_atlas_n_branch(atlases[which]); id++) {
        ric_branch b = branch_of(atlases[which], id);
        if (!b.symmetric || b.reversible || !b.from || !b.to) continue;
        ric_junction one = junction_of(atlases[which], b.from),
                     two = junction_of(atlases[which], b.to);
        count += on(&p.b, one.id) && on(&p.b, two.id) && one.b == 2 && two.b == 2;
        snprintf(
            found, size,
            "S from C_%d%d at E %.7g to C_%d%d at E %.7g, omega %.6g to %.6g, both on the path",
            one.a, one.b, one.energy, two.a, two.b, two.energy, b.frequency_min, b.frequency_max);
    }
    return count == 1;
}

static bool second_branch(int which, ric_branch *first, ric_branch *second)
{
    if (!first_side_branch(first)) return false;
    for (int id = 1; id <= ric_atlas_n_branch(atlases[which]); id++) {
        *second = branch_of(atlases[which], id);
        if (id != first->id && second->from && second->to && on(first, second->from) &&
            on(first, second->to))
            return true;
    }
    return false;
}

/* Both ends of the second branch are inside the first one, and it shares no junction with the path.
 */
static bool second_branch_leaves_the_first(int which, char *found, size_t size)
{
    path p = path_of(which);
    ric_branch first, second;
    if (!second_branch(which, &first, &second)) return false;
    bool apart = !on(&p.b, second.from) && !on(&p.b, second.to);
    for (int i = 0; i < second.n_junction; i++) apart = apart && !on(&p.b, second.junctions[i]);
    snprintf(found, size,
             "the first one from E %.7g to %.7g on the path; the second one from E %.7g to %.7g on "
             "the first one, on the "
             "path %s",
             junction_of(atlases[which], first.from).energy,
             junction_of(atlases[which], first.to).energy,
             junction_of(atlases[which], second.from).energy,
             junction_of(atlases[which], second.to).energy, apart ? "nowhere" : "too");
    return apart && on(&p.b, first.from) && on(&p.b, first.to) && !first.symmetric &&
           !second.symmetric;
}

static bool three_counterparts(int which, char *found, size_t size)
{
    ric_branch first, second;
    char bridge[200];
    int count = bridge_on_the_backbone(which, bridge, sizeof bridge) + first_side_branch(&first) +
                second_branch(which, &first, &second);
    snprintf(found, size, "%d: the bridge and the two asymmetric branches", count);
    return count == 3;
}

/* ------------------------------------------------------------- 2.2 stretching */

/* Junctions of two springs of one exponent, energies of the second times `factor`: the same, in
 * number, kind, order and frequency. */
static bool stretched(int exponent, const char *one, const char *two, double factor, double top,
                      char *found, size_t size)
{
    ric_atlas *at[2];
    double worst = 0;
    for (int i = 0; i < 2; i++) {
        char text[500];
        snprintf(text, sizeof text,
                 "model: {mass: [[2, 0], [0, 1]], stiffness: [[9, -1], [-1, 1]], contacts: "
                 "[{normal: [-1, 1], law: "
                 "power, exponent: %d, %s}]}\nexplore: {energy: [0, %.17g], frequency: [0.5, 5], "
                 "multiply: 3, depth: "
                 "1}\n",
                 exponent, i ? two : one, i ? top / factor : top);
        at[i] = explore_text(text);
    }
    int n = ric_atlas_n_junction(at[0]);
    bool same = n == ric_atlas_n_junction(at[1]) &&
                ric_atlas_n_branch(at[0]) == ric_atlas_n_branch(at[1]);
    for (int id = 1; same && id <= n; id++) {
        ric_junction a = junction_of(at[0], id), b = junction_of(at[1], id);
        if (a.kind == RIC_KIND_START) continue;
        same = a.kind == b.kind;
        worst = fmax(worst, fmax(fabs(b.energy * factor / a.energy - 1),
                                 fabs(b.frequency / a.frequency - 1)));
    }
    ric_atlas_free(at[0]), ric_atlas_free(at[1]);
    snprintf(found, size,
             "{%s} and {%s}: %d junctions each, energies stretched by %.6g, to 1e-7: %s", one, two,
             n, factor, same && worst < 1e-7 ? "yes" : "no");
    return same && n > 5 && worst < 1e-7;
}

static bool stretched_cubic(int which, char *found, size_t size)
{
    return stretched(exponent_of[which], "stiffness: 1", "stiffness: 4", 4, 120, found, size);
}

static bool stretched_seventh(int which, char *found, size_t size)
{
    return stretched(exponent_of[which], "length: 1, reference: 1", "length: 1, reference: 5",
                     pow(5, 2. / 6), 12, found, size);
}

static bool stretched_by_length(int which, char *found, size_t size)
{
    return stretched(exponent_of[which], "length: 1, reference: 1", "length: 0.5, reference: 1", 1,
                     120, found, size);
}

static const entry table[] = {
    {"2.2, eq. 13",
     "k_c alone stretches energies by (k_2 / k_c)^(2 / (n - 1)), the topology is that of n: n = 3.",
     stretched_cubic, CUBIC, NULL},
    {"2.2, footnote",
     "Any stiffness in the place of k_2 does the same for n = 7; the factor tends to 1 with n.",
     stretched_seventh, SEVENTH, NULL},
    {"2.2, eq. 12", "H_p = d^2 H_s: scaled energies are those for any d, n = 3.",
     stretched_by_length, CUBIC, NULL},
    {"3.3, Fig. 24", "C1_32 is inherited with its multiplicities at n = 3.", c32_inherited, CUBIC,
     NULL},
    {"3.3, Fig. 24", "C1_32 is inherited with its multiplicities at n = 7.", c32_inherited, SEVENTH,
     NULL},
    {"3.3, Fig. 24", "C1_32 is inherited with its multiplicities at n = 21.", c32_inherited, HIGH,
     NULL},
    {"3.3, Fig. 24", "C1_33 is inherited with its multiplicities at n = 3.", c33_inherited, CUBIC,
     NULL},
    {"3.3, Fig. 24", "C1_33 is inherited with its multiplicities at n = 7.", c33_inherited, SEVENTH,
     NULL},
    {"3.3, Fig. 24", "C1_33 is inherited with its multiplicities at n = 21.", c33_inherited, HIGH,
     NULL},
    {"3.3, Fig. 24", "C3_31 is inherited with its multiplicities at n = 3.", c31_inherited, CUBIC,
     NULL},
    {"3.3, Fig. 24", "C3_31 is inherited with its multiplicities at n = 7.", c31_inherited, SEVENTH,
     NULL},
    {"3.3, Fig. 24", "C3_31 is inherited with its multiplicities at n = 21.", c31_inherited, HIGH,
     NULL},
    {"3.3, Fig. 24", "C4_32 is inherited with its multiplicities at n = 3.", last_inherited, CUBIC,
     NULL},
    {"3.3, Fig. 24", "C4_32 is inherited with its multiplicities at n = 7.", last_inherited,
     SEVENTH, NULL},
    {"3.3, Fig. 24", "C4_32 is inherited with its multiplicities at n = 21.", last_inherited, HIGH,
     NULL},
    {"3.3, Fig. 24", "The branch with n = 3 is stable after the turning at C1_33.", stable_after,
     CUBIC, NULL},
    {"3.3, Fig. 24", "The branch with n = 7 is stable after the turning at C1_33.", stable_after,
     SEVENTH, NULL},
    {"3.3, Fig. 24", "The branch with n = 21 is stable before it.", stable_before, HIGH, NULL},
    {"3.3, Fig. 24", "The stable part is that at lower frequency, n = 3.",
     stable_at_lower_frequency, CUBIC, NULL},
    {"3.3, Fig. 24", "The stable part is that at lower frequency, n = 7.",
     stable_at_lower_frequency, SEVENTH, NULL},
    {"3.3, Fig. 24", "The stable part is that at lower frequency, n = 21.",
     stable_at_lower_frequency, HIGH, NULL},
    {"3.3, Fig. 24", "The path spans more energy and less frequency as n decreases.",
     more_energy_less_frequency, CUBIC, NULL},
    {"3.3, Fig. 24", "A smooth transformation towards the stops.", smooth_transformation, CUBIC,
     NULL},
    {"3.3, Fig. 24", "C1_33 of the cubic system is a tripling of the out-of-phase mode.",
     on_triple_of_other_mode, CUBIC, NULL},
    {"3.3, Fig. 25",
     "With n = 21 appears the twisting corner of G2_0,2: a short unstable section and a C_31 "
     "point.",
     twisting_corner, HIGH, NULL},
    {"3.3, Fig. 25", "There are fewer twists for lower n: none at n = 7.", no_twist, SEVENTH, NULL},
    {"3.3, Fig. 25", "There are fewer twists for lower n: none at n = 3.", no_twist, CUBIC, NULL},
    {"3.3", "Grazing occurs only with stops, n = 3.", nothing_grazes, CUBIC, NULL},
    {"3.3", "Grazing occurs only with stops, n = 21.", nothing_grazes, HIGH, NULL},
    {"3.3, Fig. 26", "G1_2,4 is scattered into a series of critical points at n = 21.", scattered,
     HIGH, NULL},
    {"3.3, Fig. 29",
     "Exactly 8 - 1 = 7 C_33 points on the 8-duplicate of the segment C31b C32a, n = 3.",
     seven_on_segment, CUBIC, NULL},
    {"3.3, Fig. 29", "There is none on the segment C33a C31a.", none_behind_c33, CUBIC, NULL},
    {"3.3, Fig. 26", "C^b_32 is the end of the horizontal bridge S4[0011] that came from G1_2,4.",
     bridge_on_the_backbone, SIDES, NULL},
    {"3.3, Fig. 26",
     "Two asymmetric branches meet C^f_32 on the backbone; their other ends are C^d_32 and C^e_32.",
     second_branch_leaves_the_first, SIDES,
     "The second one leaves the first one and returns to it. It never meets the backbone."},
    {"3.3", "Of five side branches that cross G1_2,4 three have counterparts at n = 21.",
     three_counterparts, SIDES, NULL},
    {"3.3, Fig. 25", "Some of the bridges of the loop cease to exist as n decreases.",
     bridges_cease, HIGH, NULL},
};

static void statements(void **state)
{
    int failed = 0, count = (int)(sizeof table / sizeof *table);
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    (void)state;
    assert_non_null(out);
    fputs(
        "| no. | place | the article says | the program finds | verdict |\n|---|---|---|---|---|\n",
        out);
    for (int i = 0; i < count; i++) {
        char found[300] = "";
        const entry *e = &table[i];
        bool good = e->check(e->which, found, sizeof found);
        print_message("# %s: %s: %s\n",
                      good ? e->instead ? "found instead" : "as stated" : "OTHERWISE", e->statement,
                      found);
        fprintf(out, "| P%d | %s | %s | %s | %s%s |\n", i + 1, e->where, e->statement, found,
                e->instead ? "found instead: " : "holds", e->instead ? e->instead : "");
        failed += !good;
    }
    assert_int_equal(fclose(out), 0);
    if (failed) fail_msg("%d of %d statements are not found as they are stated", failed, count);
    page_part("springs", text);
    free(text);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(statements)};
    return cmocka_run_group_tests(tests, explore_all, free_all);
}
