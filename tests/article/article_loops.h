/* What the article states about single-side sticking tongues, closed loops, duplicates of grazings
 * and cascades (3.1 from Fig. 14 on, 3.2). */
#ifndef ARTICLE_LOOPS_H
#define ARTICLE_LOOPS_H

#include "article_fractals.h"

/* ------------------------------------------------- 3.1 tongues, Figs. 14-16 */

static int tongue_start(int p, int q)
{
    int id = 0;
    for (int i = 1; i <= ric_atlas_n_junction(atlas_of(TONGUES)); i++) {
        ric_junction j = junction(TONGUES, i);
        if (j.kind != RIC_KIND_MULTIPLICATION || j.rotation[0] != p || j.rotation[1] != q ||
            j.impacts != 2)
            continue;
        if (id) return 0;
        id = i;
    }
    return id;
}

/* arg: "P Q J": A branches lead from the multiplication to the branch of S_2J[0^J 1^J]. */
static verdict tongue_connects(finding *f, const char *arg)
{
    int p, q, half, c = 0;
    char labels[512];
    assert_int_equal(sscanf(arg, "%d %d %d", &p, &q, &half), 3);
    int id = tongue_start(p, q), b = reversible_branch(TONGUES, sticking(half)), path_b, c3[3];
    if (!id || !b || !sticking_points(half, &path_b, c3)) return NEITHER;
    double energy = junction(PATH, c3[2]).energy;
    for (int i = 0; i < branch(TONGUES, b).n_junction; i++)
        if (near(junction(TONGUES, branch(TONGUES, b).junctions[i]).energy, energy))
            c = branch(TONGUES, b).junctions[i];
    int n = hops(TONGUES, c, id, false, true, 0, labels, sizeof labels);
    say(f, "from C_32 at E %.9g on %s: %s, to ", energy, sticking(half), labels);
    say_junction(f, TONGUES, id);
    return stated(n > 0 && (half != 2 || !strcmp(labels, "A4[0011], A6[001011], A8[01010101]")));
}

/* The members from the other A8 on, each joined to the one before at a grazing: A7[0010101], then
 * A_N[0^(N-2) 11], N = 5, 7, 9, 11. */
static int tongue_members(int member[6], int meet[6])
{
    static const char *const label[6] = {"A8[01010101]", "A7[0010101]",   "A5[00011]",
                                         "A7[0000011]",  "A9[000000011]", "A11[00000000011]"};
    int id = tongue_start(3, 4), first[4], n = families(TONGUES, id, first, 4), here = id;
    member[0] = 0;
    for (int i = 0; i < n; i++) {
        int end = far_end(TONGUES, first[i], id), last;
        if (leaving(TONGUES, end, label[1], &last) == 1 && branch(TONGUES, last).reversible)
            member[0] = first[i];
    }
    for (int i = 0; i < 6; i++) {
        if (i) {
            ric_junction j = junction(TONGUES, here);
            member[i] = 0;
            for (int k = 0; k < j.n_branch; k++) {
                ric_branch b = branch(TONGUES, j.branches[k]);
                if (ends_at(b, here) && b.reversible && !strcmp(b.label, label[i]))
                    member[i] = b.id;
            }
        }
        if (!member[i]) return i;
        meet[i] = here = far_end(TONGUES, member[i], here);
    }
    return 6;
}

static verdict tongue_grows(finding *f, const char *arg)
{
    int member[6], meet[6], n = tongue_members(member, meet);
    bool grazings = true;
    (void)arg;
    for (int i = 0; i < n; i++) {
        ric_junction j = junction(TONGUES, meet[i]);
        say(f, "%s%s to G_%d,%d (%.6g, %.6g)", i ? "; " : "", branch(TONGUES, member[i]).label,
            j.impacts, j.grazings, j.energy, j.frequency);
        grazings = grazings && j.kind == RIC_KIND_GRAZING;
    }
    return stated(n == 6 && grazings);
}

/* Runs of stable points, an undecided one between two unstable ones not counted. */
static int stable_runs(int which, int b)
{
    int runs = 0, last = RIC_STABLE_NO;
    for (int i = 0; i < branch(which, b).n_point; i++) {
        ric_point p = point(which, b, i);
        if (p.stable == RIC_STABLE_UNDECIDED) continue;
        runs += p.stable == RIC_STABLE_YES && last == RIC_STABLE_NO;
        last = p.stable;
    }
    return runs;
}

static verdict tongue_stability(finding *f, const char *arg)
{
    int member[6], meet[6], n = tongue_members(member, meet), two = 0, low = 0;
    (void)arg;
    for (int i = 2; i < n; i++) {
        int runs = stable_runs(TONGUES, member[i]);
        double slowest = INFINITY, stable = 0;
        for (int k = 0; k < branch(TONGUES, member[i]).n_point; k++) {
            ric_point p = point(TONGUES, member[i], k);
            slowest = fmin(slowest, p.frequency);
            if (p.stable == RIC_STABLE_YES && p.frequency < 1.64)
                stable = fmax(stable, p.frequency);
        }
        say(f, "%s%s: %d stable segments", i > 2 ? "; " : "", branch(TONGUES, member[i]).label,
            runs);
        if (stable > 0) say(f, ", at low frequency within %.2g of the least", stable - slowest);
        two += runs == 2, low += stable > 0 && stable - slowest < 0.01;
    }
    if (two == 4 && low == 4) return AS_STATED;
    return n == 6 && two == 3 && low == 4 && stable_runs(TONGUES, member[2]) == 3 ? OTHERWISE
                                                                                  : NEITHER;
}

static verdict tongue_bifurcations(finding *f, const char *arg)
{
    int member[6], meet[6], n = tongue_members(member, meet), ids[4], once = 0, first = 0;
    (void)arg;
    for (int i = 2; i < n; i++) {
        int found = inner(TONGUES, member[i], RIC_KIND_BRANCH_POINT, ids, 4);
        say(f, "%s%s:", i > 2 ? "; " : "", branch(TONGUES, member[i]).label);
        for (int k = 0; k < found && k < 4; k++) {
            ric_junction j = junction(TONGUES, ids[k]);
            say(f, " C_%d%d at %.7g", j.a, j.b, j.energy);
            if (j.a != 2 || j.b != 2) return NEITHER;
        }
        if (i == 2) first = found;
        once += found == 1;
    }
    return n == 6 && once == 4                 ? AS_STATED
           : n == 6 && once == 3 && first == 2 ? OTHERWISE
                                               : NEITHER;
}

static verdict tongue_words(finding *f, const char *arg)
{
    int member[6], meet[6], n = tongue_members(member, meet), right = 0;
    (void)arg;
    for (int i = 2; i < n; i++) {
        ric_branch b = branch(TONGUES, member[i]);
        int ones = 0;
        for (int k = 0; k < b.impacts; k++) ones += b.word[k];
        say(f, "%s%s", i > 2 ? ", " : "", b.label);
        right += ones == 2;
    }
    return stated(n == 6 && right == 4);
}

/* ------------------------------------------- 3.1 the closed loop, Figs. 17-19 */

static verdict loop_closes(finding *f, const char *arg)
{
    int c = at(LOOP, "C6_33"), g = at(LOOP, "G1_0,4"), list[4], right = 0;
    (void)arg;
    if (!c || !g || families(LOOP, c, list, 4) != 2) return NEITHER;
    for (int i = 0; i < 2; i++) {
        char labels[256];
        int end = far_end(LOOP, list[i], c),
            n = hops(LOOP, end, g, false, true, list[1 - i], labels, sizeof labels);
        ric_junction j = junction(LOOP, end);
        say(f, "%s%s to G_%d,%d (%.9g, %.9g), %s to G_0,4", i ? "; " : "",
            branch(LOOP, list[i]).label, j.impacts, j.grazings, j.energy, j.frequency, labels);
        right += n > 0 && (!strcmp(labels, "A2[01]") || !strcmp(labels, "A3[001], A1[0]"));
    }
    return stated(right == 2);
}

static verdict loop_is_asymmetric(finding *f, const char *arg)
{
    int symmetric = 0, asymmetric = 0;
    (void)arg;
    for (int id = 1; id <= ric_atlas_n_branch(atlas_of(LOOP)); id++) {
        ric_branch b = branch(LOOP, id);
        if (hops(LOOP, at(LOOP, "C6_33"), b.from ? b.from : b.to, false, true, 0, NULL, 0) < 0)
            continue;
        bool in_loop = false;
        in_loop = strcmp(b.label, "A2[01]") == 0 || strcmp(b.label, "A1[0]") == 0 ||
                  !strcmp(b.label, "A3[001]") || !strcmp(b.label, "A4[0101]");
        if (!in_loop) continue;
        symmetric += b.symmetric, asymmetric += !b.symmetric;
    }
    say(f,
        "A4[0101] twice, A3[001], A2[01], A1[0], the bridge A2[01] and the side branch A3[001]: %d "
        "asymmetric, %d "
        "symmetric",
        asymmetric, symmetric);
    return stated(asymmetric == 7 && symmetric == 0);
}

/* The points of Fig. 18 in their order round the loop. */
static verdict loop_points(finding *f, const char *arg)
{
    int c = at(LOOP, "C6_33"), a2 = between(LOOP, "A2[01]", at(LOOP, "G1_0,4"), -1),
        a1 = between(LOOP, "A1[0]", at(LOOP, "G1_0,4"), -1), c32[2], low[2], on1[2], a3 = 0, a4[4],
        g31 = 0;
    (void)arg;
    if (!a1 || !a2 || families(LOOP, c, a4, 4) != 2) return NEITHER;
    int g22 = far_end(LOOP, a2, at(LOOP, "G1_0,4")), g12 = far_end(LOOP, a1, at(LOOP, "G1_0,4"));
    if (inner(LOOP, a2, RIC_KIND_BRANCH_POINT, c32, 2) != 1 ||
        inner(LOOP, a2, RIC_KIND_EXTREMUM, low, 2) != 1)
        return NEITHER;
    if (inner(LOOP, a1, RIC_KIND_EXTREMUM, on1, 2) != 1 || leaving(LOOP, g12, "A3[001]", &a3) != 1)
        return NEITHER;
    g31 = far_end(LOOP, a3, g12);
    int list[6] = {g22, g31, c32[0], g12, low[0], on1[0]};
    for (int i = 0; i < 6; i++) {
        if (i) say(f, "; ");
        say_junction(f, LOOP, list[i]);
        say(f, i == 5 ? " on A1[0]" : "");
    }
    ric_junction x = junction(LOOP, g22), y = junction(LOOP, g31), z = junction(LOOP, c32[0]),
                 u = junction(LOOP, g12), v = junction(LOOP, low[0]);
    bool first = ends_at(branch(LOOP, a4[0]), g22) || ends_at(branch(LOOP, a4[1]), g22);
    bool second = ends_at(branch(LOOP, a4[0]), g31) || ends_at(branch(LOOP, a4[1]), g31);
    return stated(first && second && x.impacts == 2 && x.grazings == 2 && y.impacts == 3 &&
                  y.grazings == 1 && z.a == 3 && z.b == 2 && u.impacts == 1 && u.grazings == 2 &&
                  v.a == 2 && v.b == 1);
}

static verdict loop_bridge(finding *f, const char *arg)
{
    int a1 = between(LOOP, "A1[0]", at(LOOP, "G1_0,4"), -1),
        a2 = between(LOOP, "A2[01]", at(LOOP, "G1_0,4"), -1), c32[2];
    (void)arg;
    if (inner(LOOP, a2, RIC_KIND_BRANCH_POINT, c32, 2) != 1) return NEITHER;
    int b = between(LOOP, "A2[01]", c32[0], far_end(LOOP, a1, at(LOOP, "G1_0,4")));
    if (!b) return NEITHER;
    ric_branch row = branch(LOOP, b);
    say(f, "A2[01] from C_32 at E %.9g to G_1,2 at E %.9g, omega %.9g throughout", row.energy_min,
        row.energy_max, row.frequency_min);
    return stated(row.frequency_max - row.frequency_min < 1e-12);
}

/* ------------------------------------------------- 3.2.1 duplicates of grazings */

static verdict duplicate_grazing(finding *f, const char *arg)
{
    int twice = at(DUPLICATES, "G1_0,4"), once = at(DUPLICATES, "G2_0,2");
    (void)arg;
    if (!twice || !once) return NEITHER;
    ric_junction two = junction(DUPLICATES, twice), one = junction(DUPLICATES, once);
    say(f, "%s: omega %.9g, half of %.9g, at the same E %.9g; touches %d instead of %d", two.label,
        two.frequency, one.frequency, two.energy, two.grazings * two.multiple, one.grazings);
    return stated(two.multiple == 2 && near(2 * two.frequency, one.frequency) &&
                  two.grazings * two.multiple == 4);
}

/* Exactly these branches, S0 apart, with these flights: "+" the in-phase mode, "-" the other. */
static verdict linear_duplicates(finding *f, const char *arg)
{
    bool plus = arg[0] == '+', right = true;
    static const char *const expect[2][2] = {{"A1[0]", "A2[01]"}, {"A2[01]", "A3[001]"}};
    int id = at(DUPLICATES, plus ? "2 x G1_0,2" : "G1_0,4"), others = 0, b;
    if (!id) return NEITHER;
    ric_junction j = junction(DUPLICATES, id);
    for (int i = 0; i < j.n_branch; i++) others += branch(DUPLICATES, j.branches[i]).impacts > 0;
    for (int i = 0; i < 2; i++) {
        double flights[8];
        ric_point p;
        if (leaving(DUPLICATES, id, expect[plus][i], &b) != 1) return NEITHER;
        ric_branch row = branch(DUPLICATES, b);
        assert_int_equal(ric_atlas_point(atlas_of(DUPLICATES), b,
                                         row.from == id ? 0 : row.n_point - 1, &p, NULL, flights),
                         RIC_OK);
        say(f, "%s%s with flights", i ? "; " : "", row.label);
        for (int k = 0; k < row.impacts; k++) { /* in periods of the mode */
            double part = flights[k] * 2 * p.frequency / (2 * M_PI);
            say(f, " %.9gT", part);
            right = right && fabs(2 * part - nearbyint(2 * part)) < 1e-9;
        }
        double longest = fmax(flights[0], row.impacts > 1 ? flights[1] : 0) * 2 * p.frequency /
                         (2 * M_PI);
        if (row.impacts == 2) right = right && fabs(longest - 1.5) < 1e-9;
    }
    say(f, "; others: %d", others - 2);
    return stated(right && others == 2);
}

static verdict loop_ends_on_the_duplicate(finding *f, const char *arg)
{
    int g = at(LOOP, "G1_0,4"), original = at(LOOP, "G2_0,2");
    (void)arg;
    int here = leaving(LOOP, g, "A1[0]", NULL) + leaving(LOOP, g, "A2[01]", NULL);
    int there = leaving(LOOP, original, "A1[0]", NULL) + leaving(LOOP, original, "A2[01]", NULL);
    say(f, "A1[0] and A2[01] that leave G1_0,4: %d, that leave G2_0,2: %d", here, there);
    return stated(here == 2 && there == 0 && leaving(LOOP, original, "S2-[01]", NULL) == 1);
}

/* ------------------------------------------------------- 3.2.2 Figs. 20 to 23 */

static verdict sixfold_points(finding *f, const char *arg)
{
    bool right = true;
    (void)arg;
    for (int p = 5; p >= 1; p--) {
        int common = p % 2 == 0 ? 2 : p == 3 ? 3 : 1, id = 0;
        if (multiplications(CHATTER, s2_minus(), p / common, 6 / common, &id) != 1) return NEITHER;
        ric_junction j = junction(CHATTER, id);
        if (common == 1) say(f, "%sC_33^6%d: original", p < 5 ? "; " : "", 6 - p);
        else say(f, "; C_33^6%d: the %d-duplicate of %d/%d", 6 - p, common, p / common, 6 / common);
        say(f, " at E %.7g", j.energy);
        right = right && j.a == 3 && j.b == 3;
    }
    /* they are those of the article: 62 the one on S6, 63 that of the loop */
    int two_thirds = 0, half = 0;
    right = right && multiplications(CHATTER, s2_minus(), 2, 3, &two_thirds) == 1 &&
            multiplications(CHATTER, s2_minus(), 1, 2, &half) == 1;
    right = right && at(CHATTER, "C1_33") == two_thirds && at(CHATTER, "C6_33") == half;
    return stated(right);
}

static verdict tripling_loop(finding *f, const char *arg)
{
    int c = at(TRIPLE, "C7_33"), list[4], right = 0, g = 0;
    (void)arg;
    for (int id = 1; id <= ric_atlas_n_junction(atlas_of(TRIPLE)); id++) {
        ric_junction j = junction(TRIPLE, id);
        if (j.kind == RIC_KIND_GRAZING && j.multiple == 3 && j.impacts == 0) g = id;
    }
    if (!c || !g || families(TRIPLE, c, list, 4) != 2) return NEITHER;
    for (int i = 0; i < 2; i++) {
        char labels[256];
        int n = hops(TRIPLE, far_end(TRIPLE, list[i], c), g, false, true, list[1 - i], labels,
                     sizeof labels);
        say(f, "%s%s, %s to G_0,6", i ? "; " : "", branch(TRIPLE, list[i]).label, labels);
        right += n > 0;
    }
    ric_junction j = junction(TRIPLE, g);
    say(f, " at E %.9g, omega %.9g, whose 2-duplicate is the 3-duplicate of G1_0,4", j.energy,
        j.frequency);
    return stated(right == 2 && near(j.frequency / 2, place_named("G1_0,4")->omega / 3) &&
                  near(j.energy, place_named("G1_0,4")->energy));
}

/* The doubling of S6 and the closed loop that leaves it, on the 2-duplicate of S2^{3-}. */
static verdict doubling_of_s6(finding *f, const char *arg)
{
    int b = reversible_branch(LOCAL, "S6[010101]"), id = 0, list[4], g = 0, right = 0;
    (void)arg;
    if (!b || multiplications(LOCAL, b, 1, 2, &id) != 1 || families(LOCAL, id, list, 4) != 2)
        return NEITHER;
    for (int i = 1; i <= ric_atlas_n_junction(atlas_of(LOCAL)); i++) {
        ric_junction j = junction(LOCAL, i);
        if (j.kind == RIC_KIND_GRAZING && j.multiple == 2 &&
            near(j.energy, place_named("G1_2,4")->energy))
            g = i;
    }
    ric_junction j = junction(LOCAL, id);
    say(f, "doubling at E %.9g, omega %.9g = %.9g / 2; ", j.energy, j.frequency, 2 * j.frequency);
    for (int i = 0; i < 2; i++) {
        char labels[256];
        int n = hops(LOCAL, far_end(LOCAL, list[i], id), g, false, true, list[1 - i], labels,
                     sizeof labels);
        say(f, "%s, %s to G_4,8%s", branch(LOCAL, list[i]).label, labels, i ? "" : "; ");
        right += n > 0;
    }
    return stated(right == 2 && near(j.energy, 17.8169663303) &&
                  near(2 * j.frequency, 1.6753603654));
}

static verdict octuple(finding *f, const char *arg)
{
    int b = reversible_branch(CHATTER, "S6[010101]"), all = 0, inherited = 0, doubled = 0,
        stable = 0, c32[2], low[2];
    (void)arg;
    if (!b || inner(CHATTER, b, RIC_KIND_BRANCH_POINT, c32, 2) != 1 ||
        inner(CHATTER, b, RIC_KIND_EXTREMUM, low, 2) != 1)
        return NEITHER;
    double one = place_on(CHATTER, b, c32[0]), two = place_on(CHATTER, b, low[0]);
    for (int q = 2; q <= 8; q *= 2)
        for (int p = 1; p < q; p += 2) {
            int id = 0, hit = multiplications(CHATTER, b, p, q, &id);
            all += hit;
            if (q <= 4) inherited += hit;
            if (q == 2) doubled += hit;
            if (hit)
                stable += (place_on(CHATTER, b, id) - one) * (place_on(CHATTER, b, id) - two) < 0;
        }
    say(f,
        "%d, %d of them on its 4-duplicate, %d on its 2-duplicate, %d original; %d in the stable "
        "part",
        all, inherited, doubled, all - inherited, stable);
    return stated(all == 7 && inherited == 3 && doubled == 1 && stable == 7);
}

/* Tripling to S6, doubling to A12, quadrupling of that. */
static verdict cascade_goes_on(finding *f, const char *arg)
{
    int b = reversible_branch(CASCADE, "S6[010101]"), id = 0, list[4], four = 0;
    (void)arg;
    if (!b || multiplications(CASCADE, b, 1, 2, &id) != 1 || families(CASCADE, id, list, 4) != 2)
        return NEITHER;
    for (int i = 0; i < 2; i++)
        for (int p = 1; p < 4; p += 2) {
            int deeper = 0;
            if (multiplications(CASCADE, list[i], p, 4, &deeper) != 1) continue;
            ric_junction j = junction(CASCADE, deeper);
            say(f, "%s%d/4 on A12[010101010101] at E %.9g, omega %.9g, %d periods of S2-",
                four ? "; " : "", p, j.energy, j.frequency, 3 * 2 * 4);
            four++;
        }
    return stated(four >= 1);
}

/* The loop is complete: over A branches nothing is left to be taken at its grazings and branch
 * points, and no end of S2+ is among them. The path and the tongues hang on S2+. */
static verdict bases_apart(finding *f, const char *arg)
{
    int c = at(LOOP, "C6_33"), n = 0, left = 0;
    bool plus = false;
    (void)arg;
    for (int id = 1; id <= ric_atlas_n_junction(atlas_of(LOOP)); id++) {
        ric_junction j = junction(LOOP, id);
        if (j.kind == RIC_KIND_MULTIPLICATION || hops(LOOP, c, id, false, true, 0, NULL, 0) < 0)
            continue;
        n++;
        left += j.departures.over_budget + j.departures.refused;
        for (int i = 0; i < j.n_branch; i++)
            plus = plus || !strncmp(branch(LOOP, j.branches[i]).label, "S2", 2);
    }
    int s6 = hops(TONGUES, at(TONGUES, "G1_2,4"), at(TONGUES, "C1_33"), true, false, 0, NULL, 0),
        tongue = tongue_start(3, 4);
    say(f,
        "the loop has %d junctions, %d departures left to take, S2 %s them; S6 is %d branch from "
        "the end of S2+, the "
        "first tongue %s",
        n, left, plus ? "among" : "not at", s6, tongue ? "hangs on it" : "is missing");
    return stated(n > 5 && !left && !plus && s6 == 1 && tongue);
}

#endif
