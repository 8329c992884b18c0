/* What the article predicts beyond what it shows, what it hopes, and what the program finds there.
 */
#ifndef ARTICLE_PREDICTIONS_H
#define ARTICLE_PREDICTIONS_H

#include "article_loops.h"
#include "article_map.h"

/* ------------------------------------------------------------ 1 to 2.4 */

/* Every branch hangs on a linear mode: each begins at a junction of another one. */
static verdict branches_begin_at_junctions(finding *f, const char *arg)
{
    int n = 0, wrong = 0, kinds[RIC_KIND_USER + 1] = {0};
    (void)arg;
    for (int k = 0; k < N_SETTLED; k++)
        for (int id = 1; id <= ric_atlas_n_branch(atlas_of(settled[k])); id++) {
            ric_branch b = branch(settled[k], id);
            if (!b.impacts) continue;
            int begin = b.from ? b.from : b.to;
            n++;
            wrong += !b.linked || !begin;
            if (begin) kinds[junction(settled[k], begin).kind]++;
        }
    int critical = kinds[RIC_KIND_BRANCH_POINT] + kinds[RIC_KIND_MULTIPLICATION] +
                   kinds[RIC_KIND_EXTREMUM];
    say(f, "%d branches: %d begin at grazings, %d at critical points, %d otherwise", n,
        kinds[RIC_KIND_GRAZING], critical, n - kinds[RIC_KIND_GRAZING] - critical);
    return stated(n > 100 && !wrong && kinds[RIC_KIND_GRAZING] + critical == n);
}

/* At a branch point all branches have one word, at a grazing they differ in N. */
static verdict critical_points_keep_the_form(finding *f, const char *arg)
{
    int critical = 0, grazing = 0, wrong = 0;
    (void)arg;
    for (int k = 0; k < N_SETTLED; k++)
        for (int id = 1; id <= ric_atlas_n_junction(atlas_of(settled[k])); id++) {
            ric_junction j = junction(settled[k], id);
            bool same = true;
            if ((j.kind != RIC_KIND_BRANCH_POINT && j.kind != RIC_KIND_GRAZING) || j.n_branch < 2)
                continue;
            ric_branch first = branch(settled[k], j.branches[0]);
            for (int i = 1; i < j.n_branch; i++) {
                ric_branch b = branch(settled[k], j.branches[i]);
                same = same && b.impacts == first.impacts &&
                       !memcmp(b.word, first.word, (size_t)b.impacts * sizeof *b.word);
            }
            if (j.kind == RIC_KIND_GRAZING) grazing++;
            else critical++;
            wrong += same != (j.kind == RIC_KIND_BRANCH_POINT);
        }
    say(f, "%d branch points and %d grazings, %d of them otherwise", critical, grazing, wrong);
    return stated(critical > 20 && grazing > 20 && !wrong);
}

/* The same atlas of scaled energies for a clearance of 1 and of 1/4. */
static verdict one_plot_for_all_clearances(finding *f, const char *arg)
{
    ric_atlas *at[2];
    double worst = 0;
    (void)arg;
    for (int i = 0; i < 2; i++) {
        char text[400];
        snprintf(
            text, sizeof text,
            "model: {mass: [[2, 0], [0, 1]], stiffness: [[9, -1], [-1, 1]], contacts: [{normal: "
            "[-1, 1], "
            "clearance: %s, sides: both, law: rigid}]}\n"
            "explore: {energy: [0, 4], frequency: [0.9, 5], impacts: 4, multiply: 1, depth: 2}\n",
            i ? "0.25" : "1");
        at[i] = explore_text(text);
    }
    int n = ric_atlas_n_junction(at[0]);
    bool same = n == ric_atlas_n_junction(at[1]) &&
                ric_atlas_n_branch(at[0]) == ric_atlas_n_branch(at[1]);
    for (int id = 1; same && id <= n; id++) {
        ric_junction a = junction_of(at[0], id), b = junction_of(at[1], id);
        worst = fmax(worst,
                     fmax(fabs(a.energy / b.energy - 1), fabs(a.frequency / b.frequency - 1)));
        same = !strcmp(a.label, b.label);
    }
    ric_atlas_free(at[0]), ric_atlas_free(at[1]);
    say(f,
        "clearances 1 and 1/4: %d junctions each, with scaled energies and frequencies the same to "
        "1e-12: %s",
        n, same && worst < 1e-12 ? "yes" : "no");
    return stated(same && n > 5 && worst < 1e-12);
}

/* -------------------------------------------------------------- 3.1 */

/* S_2k for k = 11, 13, 15, 17: one C_33 and one C_32 each, and which end has the higher frequency.
 */
static verdict chattering_beyond(finding *f, const char *arg)
{
    bool right = true;
    (void)arg;
    for (int k = 11; k <= 17; k += 2) {
        int b = reversible_branch(FAR, chattering(k)), n32 = 0, n33 = 0;
        if (!b) return NEITHER;
        ric_branch row = branch(FAR, b);
        ric_junction high = junction(FAR, upper_end(FAR, b)),
                     low = junction(FAR, row.from == high.id ? row.to : row.from);
        for (int i = 0; i < row.n_junction; i++) {
            ric_junction j = junction(FAR, row.junctions[i]);
            n32 += j.a == 3 && j.b == 2, n33 += j.a == 3 && j.b == 3;
        }
        say(f,
            "%sk = %d: %d C_33, %d C_32, from G_%d,%d (high) at E %.7g to G_%d,%d (low) at E %.7g",
            k > 11 ? "; " : "", k, n33, n32, high.impacts, high.grazings, high.energy, low.impacts,
            low.grazings, low.energy);
        right = right && n33 == 1 && n32 == 1 && high.impacts == 2 * k - 4 && high.grazings == 4 &&
                low.impacts == 2 * k - 2 && low.grazings == 2;
    }
    return stated(right);
}

/* S_2j for j = 6 to 11: as stated three points; otherwise a fourth one, a C_32, from j = 7 on. */
static verdict sticking_beyond(finding *f, const char *arg)
{
    bool three = true, fourth = true;
    (void)arg;
    for (int j = 6; j <= 11; j++) {
        int b = reversible_branch(FAR, sticking(j)), n31 = 0, n32 = 0;
        if (!b) return NEITHER;
        ric_branch row = branch(FAR, b);
        say(f, "%sj = %d:", j > 6 ? "; " : "", j);
        for (int i = 0; i < row.n_junction; i++) {
            ric_junction p = junction(FAR, row.junctions[i]);
            if (!p.a) continue;
            say(f, " C_%d%d at %.7g", p.a, p.b, p.energy);
            n31 += p.a == 3 && p.b == 1, n32 += p.a == 3 && p.b == 2;
        }
        three = three && n31 == 1 && n32 == 2;
        fourth = fourth && n31 == 1 && n32 == (j < 7 ? 2 : 3);
    }
    return three ? AS_STATED : fourth ? OTHERWISE : NEITHER;
}

/* Whether the share of the relative motion at the C_32 of a family falls from level to level;
 * *last: that of the last one, NAN where a branch is not there. */
static bool share_falls(finding *f, const char *(*word)(int), int from, int to, int step,
                        double *last)
{
    bool falls = true;
    *last = 1;
    for (int level = from; level <= to; level += step) {
        int b = reversible_branch(FAR, word(level));
        double share = b ? share_of_relative_motion(FAR, b, beside_branch_point(FAR, b)) : NAN;
        say(f, "%s%.2g", level > from ? ", " : "", share);
        falls = falls && share < *last;
        *last = share;
    }
    return falls;
}

/* At the C_32 of S_2k and the last one of S_2j the share of the relative motion falls from level to
 * level. */
static verdict becomes_one_mass(finding *f, const char *arg)
{
    double upper, lower;
    (void)arg;
    say(f, "S_2k, k = 3, 5 .. 17: ");
    const bool above = share_falls(f, chattering, 3, 17, 2, &upper);
    say(f, "; S_2j, j = 2, 3 .. 11: ");
    const bool below = share_falls(f, sticking, 2, 11, 1, &lower);
    if (isnan(upper) || isnan(lower)) return NEITHER;
    return stated(above && upper < 0.02 && below && lower < 0.01);
}

/* The path behind S2 lies between the maxima of S_2k and the minima of S_2j. */
static verdict path_is_clamped(finding *f, const char *arg)
{
    double high = 0, low = INFINITY, most = 0, least = INFINITY;
    int n = 0;
    (void)arg;
    for (int k = 3; k <= 9; k += 2)
        high = fmax(high, branch(PATH, reversible_branch(PATH, chattering(k))).frequency_max);
    for (int j = 2; j <= 5; j++)
        low = fmin(low, branch(PATH, reversible_branch(PATH, sticking(j))).frequency_min);
    for (int id = 1; id <= ric_atlas_n_branch(atlas_of(PATH)); id++) {
        ric_branch b = branch(PATH, id);
        if (!b.symmetric || b.impacts < 4) continue;
        n++;
        most = fmax(most, b.frequency_max), least = fmin(least, b.frequency_min);
    }
    say(f,
        "%d S branches with 4 impacts and more: omega %.7g to %.7g; least minimum of S_2j %.7g, "
        "largest maximum of "
        "S_2k %.7g",
        n, least, most, low, high);
    return stated(n > 10 && least >= low && most <= high);
}

/* arg: J. From the last C_32 of S_2J to the 2J-duplicate of S2-, over A branches. */
static verdict tongue_beyond(finding *f, const char *arg)
{
    int half = atoi(arg), start = 0, c = 0, path_b, c3[3];
    char labels[512];
    if (!sticking_points(half, &path_b, c3)) return NEITHER;
    double energy = junction(PATH, c3[2]).energy;
    for (int id = 1; id <= ric_atlas_n_junction(atlas_of(FAR_TONGUES)); id++) {
        ric_junction j = junction(FAR_TONGUES, id);
        if (j.kind == RIC_KIND_MULTIPLICATION && j.impacts == 2 && j.rotation[0] == 2 * half - 1 &&
            j.rotation[1] == 2 * half)
            start = id;
        if (j.kind == RIC_KIND_BRANCH_POINT && near(j.energy, energy)) c = id;
    }
    if (!start || !c) return NEITHER;
    int n = hops(FAR_TONGUES, c, start, false, true, 0, labels, sizeof labels);
    say(f, "from C_32 at E %.9g on %s: %s, to ", energy, sticking(half), labels);
    say_junction(f, FAR_TONGUES, start);
    return stated(n > 0);
}

/* -------------------------------------------------------------- 3.2 */

/* How many C_33 the k-duplicate of A1[0] has follows from the range of the rotation number, 0 to
 * its largest value. */
static verdict extra_points_follow_rotation(finding *f, const char *arg)
{
    int b = between(LOOP, "A1[0]", at(LOOP, "G1_0,4"), -1), right = 0;
    double most = 0;
    (void)arg;
    if (!b) return NEITHER;
    for (int i = 0; i < branch(LOOP, b).n_point; i++)
        if (point(LOOP, b, i).stable == RIC_STABLE_YES)
            most = fmax(most, point(LOOP, b, i).rotation);
    say(f, "on A1[0] the rotation number goes from 0 to %.6f; p / k below it for k = 2..9:", most);
    for (int k = 2; k <= 9; k++) {
        int count = 0, originals;
        for (int p = 1; p < k; p++) count += (double)p / k < most;
        say(f, " %d", count);
        right += count == on_duplicate('a', k, &originals);
    }
    say(f, ", of which %d are the numbers of C_33", right);
    return right == 8 ? OTHERWISE : NEITHER;
}

/* Atlas that has the base of the k-duplicate of S2-, and there the grazing G_0,2k and the point (k,
 * 1). */
static bool base_of(int k, int *which, int *grazing, int *c)
{
    static const int holds[] = {LOOP, TRIPLE, BASE_4, BASE_5, BASE_6};
    *which = holds[k - 2], *grazing = 0;
    for (int id = 1; id <= ric_atlas_n_junction(atlas_of(*which)); id++) {
        ric_junction j = junction(*which, id);
        if (j.kind == RIC_KIND_GRAZING && !j.impacts && j.multiple == k &&
            near(j.energy, 2.960911630511))
            *grazing = id;
    }
    return *grazing && multiplications(*which, between(*which, "S2-[01]", at(*which, "G2_0,2"), 0),
                                       1, k, c) == 1;
}

/* A loop from (k, 1) on the k-duplicate of S2- closes at G_0,2k: both families reach it, neither
 * over the other. */
static verdict loops_of_duplicates(finding *f, const char *arg)
{
    int closed = 0;
    (void)arg;
    for (int k = 2; k <= 6; k++) {
        int which, g, c, list[4], n = 0;
        if (!base_of(k, &which, &g, &c) || families(which, c, list, 4) != 2) return NEITHER;
        for (int i = 0; i < 2; i++)
            n += hops(which, far_end(which, list[i], c), g, false, true, list[1 - i], NULL, 0) >= 0;
        say(f, "%sk = %d: from E %.9g, %d of 2 families to G_0,%d at omega %.9g", k > 2 ? "; " : "",
            k, junction(which, c).energy, n, 2 * k, junction(which, g).frequency);
        closed += n == 2;
    }
    return stated(closed == 5);
}

/* Asymmetric branches only, as stated; otherwise S branches leave G_0,2k for k = 5 and for no other
 * k up to 6. */
static verdict bases_are_asymmetric(finding *f, const char *arg)
{
    int found[7] = {0};
    (void)arg;
    for (int k = 2; k <= 6; k++) {
        int which, g, c;
        if (!base_of(k, &which, &g, &c)) return NEITHER;
        ric_junction j = junction(which, g);
        say(f, "%sk = %d:", k > 2 ? "; " : "", k);
        for (int i = 0; i < j.n_branch; i++) {
            ric_branch b = branch(which, j.branches[i]);
            if (!b.symmetric || !ends_at(b, g) || !b.impacts) continue;
            say(f, " %s", b.label);
            found[k]++;
        }
        say(f, found[k] ? " leave G_0,%d" : " no S branch leaves G_0,%d", 2 * k);
    }
    if (!found[2] && !found[3] && !found[4] && !found[6]) return found[5] ? OTHERWISE : AS_STATED;
    return NEITHER;
}

/* The tripling of the loop's A4[0101] lies on one branch with 12 impacts, both ends of which lead
 * to the 3-duplicate of G2_2,2 without it. */
static verdict tripling_of_a4(finding *f, const char *arg)
{
    int c = at(TRIPLED, "C6_33"), list[4], m = families(TRIPLED, c, list, 4), n = 0, id = 0, g = 0,
        own[4], ways = 0;
    (void)arg;
    for (int i = 0; i < m && i < 4; i++)
        n += multiplications(TRIPLED, list[i], 2, 3, &id) +
             multiplications(TRIPLED, list[i], 1, 3, &id);
    if (n != 1) return NEITHER;
    for (int i = 1; i <= ric_atlas_n_junction(atlas_of(TRIPLED)); i++) {
        ric_junction j = junction(TRIPLED, i);
        if (j.kind == RIC_KIND_GRAZING && j.multiple == 3 && j.impacts == 2 && j.grazings == 2)
            g = i;
    }
    say_junction(f, TRIPLED, id);
    say(f, " on A4[0101]; ");
    int count = families(TRIPLED, id, own, 4);
    if (!g || count < 1 || count > 2) return NEITHER;
    for (int end = 0; end < 2; end++) {
        ric_branch b = branch(TRIPLED, own[count == 2 ? end : 0]);
        char labels[256];
        int from = count == 2 ? far_end(TRIPLED, b.id, id) : end ? b.to : b.from;
        int steps = hops(TRIPLED, from, g, false, true, count == 2 ? own[1 - end] : b.id, labels,
                         sizeof labels);
        say(f, "%s%s, %s", end ? " and " : "", b.label, labels);
        ways += steps >= 0;
    }
    say(f, " to ");
    say_junction(f, TRIPLED, g);
    return stated(ways == 2);
}

/* The stable part of A12, which leaves the doubling of S6 and has the multiplication 1/4: as stated
 * it begins where A12 does; otherwise A12 is unstable there, and stable from a fold, where the
 * multipliers are 1, to a doubling. */
static verdict multipliers_begin_again(finding *f, const char *arg)
{
    int b = reversible_branch(CASCADE, "S6[010101]"), id = 0, list[4], four = 0, doubling = 0,
        fold[2];
    (void)arg;
    if (!b || multiplications(CASCADE, b, 1, 2, &id) != 1 || families(CASCADE, id, list, 4) != 2)
        return NEITHER;
    for (int i = 0; i < 2; i++)
        if (multiplications(CASCADE, list[i], 1, 4, NULL) +
                multiplications(CASCADE, list[i], 3, 4, NULL) ==
            1)
            four = list[i];
    if (!four || multiplications(CASCADE, four, 1, 2, &doubling) != 1) return NEITHER;
    int n = inner(CASCADE, four, RIC_KIND_EXTREMUM, fold, 2), between = 0;
    for (int i = 0; i < n && i < 2; i++)
        if (stable_between(CASCADE, four, fold[i], doubling) == 1) between = fold[i];
    if (!between) return stable_between(CASCADE, four, id, doubling) == 1 ? AS_STATED : NEITHER;
    say(f, "A12 leaves S6 unstable and is stable between ");
    say_junction(f, CASCADE, between);
    say(f, " and ");
    say_junction(f, CASCADE, doubling);
    bool unstable = stable_between(CASCADE, four, id, between) == 0;
    return unstable && junction(CASCADE, between).b == 1 ? OTHERWISE : NEITHER;
}

/* ---------------------------------------------------- 1, 3.2.2, 4: islands */

/* Does every periodic motion hang on the linear modes? Orbits with up to 3 impacts at E = 5, by
 * brute force, and what the exploration of their surroundings says of them. */
static verdict everything_hangs_on_modes(finding *f, const char *arg)
{
    ric_hunt *hunt = NULL;
    ric_comparison *all = NULL;
    ric_hunt_options o;
    int apart = 0, lost = 0;
    (void)arg;
    ric_hunt_options_init(&o);
    o.energy = 5, o.impacts = 3, o.period[1] = 2 * M_PI / 0.9;
    o.lines = 4000, o.rows = 10, o.row = 200, o.random = 3000;
    if (ric_hunt_create(ric_atlas_model(atlas_of(ELEMENTARY)), &o, &hunt) || ric_hunt_run(hunt) ||
        ric_hunt_compare(hunt, atlas_of(ELEMENTARY), &all))
        fail_msg("%s", ric_detail());
    for (int i = 0; i < ric_hunt_n_found(hunt); i++) {
        ric_found orbit;
        ric_finding why;
        int word[RIC_HUNT_IMPACTS];
        assert_int_equal(ric_hunt_found(hunt, i, &orbit, word, NULL, NULL), RIC_OK);
        assert_int_equal(ric_comparison_finding(all, i, &why), RIC_OK);
        lost += why.state == RIC_FOUND_UNEXPLAINED;
        if (why.state != RIC_FOUND_ISOLATED) continue;
        say(f, "%sA%d[", apart ? "; " : "at E 5 ", orbit.impacts);
        for (int k = 0; k < orbit.impacts; k++) say(f, "%d", word[k]);
        say(f, "] with omega %.6f, trace %.4f: %s", 2 * M_PI / orbit.period, orbit.trace, why.why);
        apart++;
    }
    if (!apart) say(f, "nothing is isolated at E 5");
    ric_comparison_free(all);
    ric_hunt_free(hunt);
    return lost ? NEITHER : apart ? OTHERWISE : AS_STATED;
}

#endif
