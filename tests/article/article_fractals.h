/* What the article states about the symmetric path, tongues, loops and duplicates: the end of
 * section 3.1 and section 3.2. */
#ifndef ARTICLE_FRACTALS_H
#define ARTICLE_FRACTALS_H

#include "article_elementary.h"

/* -------------------------------------------- 3.1 the path of S branches */

static const char *chattering(int k) /* S_2k[01]^k */
{
    static char text[4][64];
    static int turn;
    char *out = text[turn++ % 4];
    int n = snprintf(out, 64, "S%d[", 2 * k);
    for (int i = 0; i < k; i++) n += snprintf(out + n, 64 - (size_t)n, "01");
    snprintf(out + n, 64 - (size_t)n, "]");
    return out;
}

static const char *sticking(int j) /* S_2j[0^j 1^j] */
{
    static char text[4][64];
    static int turn;
    char *out = text[turn++ % 4];
    snprintf(out, 64, "S%d[%.*s%.*s]", 2 * j, j, "00000000000", j, "11111111111");
    return out;
}

/* The long, reversible branch of that label; the bridges that share it are not reversible. */
static int reversible_branch(int which, const char *label)
{
    int found = 0;
    for (int id = 1; id <= ric_atlas_n_branch(atlas_of(which)); id++) {
        ric_branch b = branch(which, id);
        if (strcmp(b.label, label) || !b.reversible) continue;
        if (found) return 0;
        found = id;
    }
    return found;
}

/* Which end of a branch has the higher frequency. */
static int upper_end(int which, int b)
{
    ric_branch row = branch(which, b);
    return point(which, b, 0).frequency > point(which, b, row.n_point - 1).frequency ? row.from
                                                                                     : row.to;
}

/* Otherwise: the same ends, but that of G_2k-4,4 has the higher frequency from k = 9 on. */
static verdict chattering_ends(finding *f, const char *arg)
{
    bool ends = true, order[4];
    (void)arg;
    for (int k = 3; k <= 9; k += 2) {
        int b = reversible_branch(CHATTER, chattering(k));
        if (!b || branch(CHATTER, b).stop != RIC_STOP_JUNCTION) return NEITHER;
        ric_junction one = junction(CHATTER, branch(CHATTER, b).from),
                     two = junction(CHATTER, branch(CHATTER, b).to), swap = one;
        if (one.grazings > two.grazings) one = two, two = swap;
        say(f, "%s%s: G_%d,%d (%.6g, %.7g), G_%d,%d (%.6g, %.7g)", k > 3 ? "; " : "", chattering(k),
            one.impacts, one.grazings, one.energy, one.frequency, two.impacts, two.grazings,
            two.energy, two.frequency);
        ends = ends && one.impacts == 2 * k - 2 && one.grazings == 2 && two.impacts == 2 * k - 4 &&
               two.grazings == 4;
        order[(k - 3) / 2] = one.frequency > two.frequency;
    }
    if (!ends || !order[0] || !order[1] || !order[2]) return NEITHER;
    return order[3] ? AS_STATED : OTHERWISE;
}

/* Energy at the vertex of the parabola through the three lowest points of a branch. */
static double lowest(int which, int b)
{
    int n = branch(which, b).n_point, least = 1;
    for (int i = 1; i < n - 1; i++)
        if (point(which, b, i).energy < point(which, b, least).energy) least = i;
    ric_point q = point(which, b, least), p = q, r = q;
    /* junctions may have points closely beside */
    for (int i = least; i >= 0 && q.arclength - p.arclength < 1e-4; i--) p = point(which, b, i);
    for (int i = least; i < n && r.arclength - q.arclength < 1e-4; i++) r = point(which, b, i);
    double h = q.arclength - p.arclength, k = r.arclength - q.arclength,
           left = (q.energy - p.energy) / h, right = (r.energy - q.energy) / k;
    double curvature = (right - left) / (h + k),
           slope = (left * k + right * h) / (h + k); /* at the middle point */
    return q.energy - slope * slope / (4 * curvature);
}

/* The C_33 of S_2k and the end of its stable part there: the minimum beside it for k = 3, else the
 * C_33 itself. */
static bool chattering_point(int k, int *b, int *c33, int *end)
{
    int low[2];
    *b = reversible_branch(CHATTER, chattering(k));
    if (!*b || multiplications(CHATTER, s2_minus(), k - 1, k, c33) != 1 ||
        !passes(branch(CHATTER, *b), *c33))
        return false;
    int n = inner(CHATTER, *b, RIC_KIND_EXTREMUM, low, 2);
    *end = n ? low[0] : *c33;
    return n <= 1;
}

/* Otherwise: beside the C_33 for k = 3; at it for k = 5, 7, 9. */
static verdict chattering_minimum(finding *f, const char *arg)
{
    bool same[4];
    (void)arg;
    for (int k = 3; k <= 9; k += 2) {
        int b, c33, end;
        if (!chattering_point(k, &b, &c33, &end)) return NEITHER;
        double energy = junction(CHATTER, c33).energy,
               gap = energy - (end == c33 ? lowest(CHATTER, b) : junction(CHATTER, end).energy);
        same[(k - 3) / 2] = end == c33 && fabs(gap) < 1e-8 * energy;
        say(f, "%sk = %d: C_33 at E %.9g, ", k > 3 ? "; " : "", k, energy);
        if (same[(k - 3) / 2]) say(f, "the minimum");
        else say(f, "%.2g above the minimum", gap);
    }
    if (!same[1] || !same[2] || !same[3]) return NEITHER;
    return same[0] ? AS_STATED : OTHERWISE;
}

static verdict chattering_stable(finding *f, const char *arg)
{
    bool right = true;
    (void)arg;
    for (int k = 3; k <= 9; k += 2) {
        int b, c33, end, c32[2];
        if (!chattering_point(k, &b, &c33, &end) ||
            inner(CHATTER, b, RIC_KIND_BRANCH_POINT, c32, 2) != 1)
            return NEITHER;
        ric_branch row = branch(CHATTER, b);
        bool first = place_on(CHATTER, b, c32[0]) < place_on(CHATTER, b, end);
        say(f, "%sk = %d: from E %.9g to %.9g", k > 3 ? "; " : "stable for ", k,
            junction(CHATTER, c32[0]).energy, junction(CHATTER, end).energy);
        right = right && stable_between(CHATTER, b, c32[0], end) == 1 &&
                stable_between(CHATTER, b, first ? row.from : row.to, c32[0]) == 0 &&
                stable_between(CHATTER, b, end, first ? row.to : row.from) == 0;
    }
    return stated(right);
}

static verdict chattering_above(finding *f, const char *arg)
{
    double locked, last = INFINITY;
    bool right = true;
    (void)arg;
    assert_int_equal(ric_model_locked_frequencies(ric_atlas_model(atlas_of(CHATTER)), 0, &locked),
                     RIC_OK);
    say(f, "above omega_0 by");
    for (int k = 3; k <= 9; k += 2) {
        ric_branch b = branch(CHATTER, reversible_branch(CHATTER, chattering(k)));
        say(f, " %.5f to %.5f%s", b.frequency_min - locked, b.frequency_max - locked,
            k < 9 ? "," : "");
        right = right && b.frequency_min > locked && b.frequency_max < last;
        last = b.frequency_max;
    }
    return stated(right);
}

/* The interior C of a sticking branch from its end of higher frequency on: C_32, C_31, C_32. */
static bool sticking_points(int j, int *b, int point_id[3])
{
    int n = 0;
    *b = reversible_branch(PATH, sticking(j));
    if (!*b) return false;
    ric_branch row = branch(PATH, *b);
    bool down = upper_end(PATH, *b) == row.from;
    for (int i = 0; i < row.n_junction; i++) {
        ric_junction p = junction(PATH, row.junctions[down ? i : row.n_junction - 1 - i]);
        if (!p.a) continue;
        if (n < 3) point_id[n] = p.id;
        n++;
    }
    return n == 3;
}

static verdict sticking_critical(finding *f, const char *arg)
{
    bool right = true;
    (void)arg;
    for (int j = 2; j <= 5; j++) {
        int b, c[3];
        if (!sticking_points(j, &b, c)) return NEITHER;
        say(f, "%s%s:", j > 2 ? "; " : "", sticking(j));
        for (int i = 0; i < 3; i++) {
            ric_junction p = junction(PATH, c[i]);
            say(f, " C_%d%d at %.7g", p.a, p.b, p.energy);
            right = right && p.a == 3 && p.b == (i == 1 ? 1 : 2);
        }
        right = right && stable_between(PATH, b, c[1], c[2]) == 1 &&
                stable_between(PATH, b, c[0], c[1]) == 0;
    }
    return stated(right);
}

static verdict sticking_bridges(finding *f, const char *arg)
{
    bool right = true;
    (void)arg;
    for (int j = 2; j <= 5; j++) {
        int b, c[3], bridge = 0,
                     before = j == 2 ? between(PATH, "S2+[01]", -1, -1)
                                     : reversible_branch(PATH, sticking(j - 1));
        if (!sticking_points(j, &b, c) || !before || leaving(PATH, c[0], sticking(j), &bridge) != 1)
            return NEITHER;
        ric_junction end = junction(PATH, far_end(PATH, bridge, c[0]));
        say(f, "%sj = %d: to G_%d,%d at E %.7g, an end of %s", j > 2 ? "; " : "", j, end.impacts,
            end.grazings, end.energy, branch(PATH, before).label);
        right = right && branch(PATH, bridge).symmetric && ends_at(branch(PATH, before), end.id);
    }
    return stated(right);
}

static verdict sticking_third_point(finding *f, const char *arg)
{
    static const char *const side[] = {"A4[0011]", "A6[000111]", "A8[00001111]"};
    bool right = true;
    (void)arg;
    for (int j = 2; j <= 4; j++) {
        int b, c[3], last = 0;
        if (!sticking_points(j, &b, c)) return NEITHER;
        ric_junction p = junction(PATH, c[2]);
        int n = 0;
        for (int id = 1; id <= ric_atlas_n_junction(atlas_of(TONGUES));
             id++) { /* the path has no A branches */
            ric_junction t = junction(TONGUES, id);
            if (t.kind == RIC_KIND_BRANCH_POINT && near(t.energy, p.energy) &&
                near(t.frequency, p.frequency))
                n += leaving(TONGUES, id, side[j - 2], &last);
        }
        say(f, "%s%s at E %.7g", j > 2 ? "; " : "", side[j - 2], p.energy);
        right = right && n == 1 && !branch(TONGUES, last).symmetric;
    }
    return stated(right);
}

static verdict sticking_below(finding *f, const char *arg)
{
    double locked, last = 0;
    bool right = true;
    (void)arg;
    assert_int_equal(ric_model_locked_frequencies(ric_atlas_model(atlas_of(PATH)), 0, &locked),
                     RIC_OK);
    say(f, "least frequencies");
    for (int j = 2; j <= 5; j++) {
        ric_branch b = branch(PATH, reversible_branch(PATH, sticking(j)));
        say(f, "%s %.7g", j > 2 ? "," : "", b.frequency_min);
        right = right && b.frequency_min < locked && b.frequency_min > last;
        last = b.frequency_min;
    }
    return stated(right);
}

/* From each branch of the series to the next over S branches, without going back through S2. */
static verdict path_order(finding *f, const char *arg)
{
    const char *order[7] = {chattering(3), "S4[0011]",     chattering(5), "S6[000111]",
                            chattering(7), "S8[00001111]", chattering(9)};
    bool right = true;
    (void)arg;
    for (int i = 0; i < 6; i++) {
        int a = reversible_branch(PATH, order[i]), b = reversible_branch(PATH, order[i + 1]),
            least = 99;
        char best[256] = "", labels[256];
        if (!a || !b) return NEITHER;
        ric_branch one = branch(PATH, a), two = branch(PATH, b);
        for (int k = 0; k < 4; k++) {
            int n = hops(PATH, k & 1 ? one.to : one.from, k & 2 ? two.to : two.from, true, false, 0,
                         labels, sizeof labels);
            if (n < 0 || n >= least) continue;
            least = n;
            snprintf(best, sizeof best, "%s", labels);
        }
        say(f, "%s%s -> %s: %s", i ? "; " : "", order[i], order[i + 1], least ? best : "they meet");
        right = right && least <= 2;
    }
    return stated(right);
}

static verdict path_converges(finding *f, const char *arg)
{
    double locked, energy = 0, away = INFINITY;
    bool right = true;
    (void)arg;
    assert_int_equal(ric_model_locked_frequencies(ric_atlas_model(atlas_of(PATH)), 0, &locked),
                     RIC_OK);
    for (int j = 1; j <= 5; j++) { /* the ends of highest energy */
        ric_branch b = branch(PATH, j == 1 ? between(PATH, "S2+[01]", -1, -1)
                                           : reversible_branch(PATH, sticking(j)));
        ric_junction end = junction(PATH, b.to);
        say(f, "%sE %.6g: %.5f",
            j > 1 ? ", " : "omega - omega_0 where S2+, S4, S6, S8, S10 end: ", end.energy,
            end.frequency - locked);
        right = right && end.energy > energy && fabs(end.frequency - locked) < away;
        energy = end.energy, away = fabs(end.frequency - locked);
    }
    return stated(right);
}

/* ---------------------------------------------- multiplications of S2- */

static verdict even_is_asymmetric(finding *f, const char *arg)
{
    int n = 0, wrong = 0, list[4];
    (void)arg;
    for (int q = 2; q <= 12; q++) {
        int id = 0;
        if (multiplications(CHATTER, s2_minus(), q - 1, q, &id) != 1) return NEITHER;
        int count = families(CHATTER, id, list, 4);
        for (int i = 0; i < count && i < 4; i++) {
            n++;
            wrong += branch(CHATTER, list[i]).symmetric != (q % 2 == 1);
        }
        wrong += count != (q % 2 ? 1 : 2);
    }
    static const int more[] = {LOOP, TRIPLE, BASE_4,
                               BASE_5}; /* down to lower frequencies, for all p */
    int others = 0, left = 0;
    for (int k = 0; k < 4; k++)
        for (int q = 2; q <= 5; q++)
            for (int p = 1; p < q; p++) {
                int id = 0, b = between(more[k], "S2-[01]", at(more[k], "G2_0,2"), 0);
                if (multiplications(more[k], b, p, q, &id) != 1) continue;
                int count = families(more[k], id, list, 4);
                left += count > 0;
                for (int i = 0; i < count && i < 4; i++)
                    others += branch(more[k], list[i]).symmetric != (q % 2 == 1 && p % 2 == 0);
            }
    say(f,
        "(q, p) = (2, 1), (3, 2) .. (12, 11): one S family each for odd q, two A families each for "
        "even q, %d in all, "
        "%d otherwise; for all p up to q = 5, at %d points in 4 atlases, S only for odd q and even "
        "p, %d otherwise",
        n, wrong, left, others);
    return stated(n == 17 && !wrong && left > 5 && !others);
}

/* On which sides in energy a branch lies next to a junction on it: bit 0 above, bit 1 below. */
static int energy_sides(int which, int b, int id)
{
    double s = place_on(which, b, id), energy = junction(which, id).energy,
           nearest[2] = {INFINITY, INFINITY};
    int side[2] = {0, 0};
    for (int i = 0; i < branch(which, b).n_point; i++) {
        ric_point p = point(which, b, i);
        double away = fabs(p.arclength - s);
        if (away < 1e-3 || away > nearest[p.arclength > s]) continue;
        nearest[p.arclength > s] = away;
        side[p.arclength > s] = p.energy > energy ? 1 : 2;
    }
    return side[0] | side[1];
}

/* The stored points verify, and the first of them have the period claimed: q times that of S2-, p /
 * q turns of its multipliers. */
static bool member_is_right(int which, int b, int id)
{
    double nearest = INFINITY;
    ric_branch row = branch(which, b);
    for (int k = 0; k < 3; k++) {
        ric_check check;
        if (ric_verify_point(atlas_of(which), b, 1 + k * (row.n_point - 3) / 2, &check))
            fail_msg("%s", ric_detail());
        if (!check.passed) return false;
    }
    for (int k = 0; k < row.n_point; k++)
        nearest = fmin(nearest,
                       fabs(point(which, b, k).frequency / junction(which, id).frequency - 1));
    return row.reversible && nearest < 1e-4;
}

/* arg: "ATLAS q p families". Two families have mirror points of their own and lie on one side in
 * energy; a single one passes. That of q = 3 is on both sides; for q >= 5 it is on one side: its
 * halves are the elliptic and the hyperbolic family. */
static verdict leave_s2_minus(finding *f, const char *arg)
{
    int q, p, want, list[8], id = 0;
    char from;
    assert_int_equal(sscanf(arg, "%c %d %d %d", &from, &q, &p, &want), 4);
    int which = from == 'T' ? TRIPLE : CHATTER;
    if (multiplications(which, between(which, "S2-[01]", at(which, "G2_0,2"), 0), p, q, &id) != 1)
        return NEITHER;
    int n = families(which, id, list, 8), sides = 0;
    ric_junction j = junction(which, id);
    bool right = n == 2 || n == 1, both_passes = n == 1;
    say(f, "E %.9g, omega %.9g = %.9g / %d:", j.energy, j.frequency, q * j.frequency, q);
    for (int i = 0; i < n && i < 8; i++) {
        ric_branch row = branch(which, list[i]);
        sides |= energy_sides(which, list[i], id);
        say(f, "%s %s%s (%s)", i ? "," : "", row.label, passes(row, id) ? " passing" : "",
            row.mirror);
        right = right && member_is_right(which, list[i], id) && passes(row, id) == both_passes;
        for (int k = 0; k < i; k++)
            right = right && strcmp(row.mirror, branch(which, list[k]).mirror);
    }
    say(f, sides == 3   ? ", on both sides in energy"
           : sides == 1 ? ", at higher energies"
                        : ", at lower energies");
    right = right && (q == 3 && n == 1 ? sides == 3 : sides == 1);
    return !right ? NEITHER : n == want ? AS_STATED : OTHERWISE;
}

static verdict all_duplicates_meet(finding *f, const char *arg)
{
    double omega[2], locked;
    bool right = true, c32 = true;
    (void)arg;
    assert_int_equal(ric_model_frequencies(ric_atlas_model(atlas_of(CHATTER)), omega), RIC_OK);
    assert_int_equal(ric_model_locked_frequencies(ric_atlas_model(atlas_of(CHATTER)), 0, &locked),
                     RIC_OK);
    say(f, "omega");
    for (int q = 2; q <= 12; q++) {
        int id = 0;
        if (multiplications(CHATTER, s2_minus(), q - 1, q, &id) != 1) return NEITHER;
        ric_junction j = junction(CHATTER, id);
        say(f, "%s %.6g", q > 2 ? "," : "", j.frequency);
        right = right && j.frequency > locked && j.frequency < omega[1] &&
                j.departures.taken + j.departures.known > 1 && j.a == 3;
        c32 = c32 && j.b == 2;
    }
    say(f, " for k = 2..12, a = 3, b = %d", c32 ? 2 : 3);
    return !right ? NEITHER : c32 ? AS_STATED : OTHERWISE;
}

/* arg: '-', '+' or 'a': how many p/q, q dividing k, lie on S2-, S2+, A1[0], for k = 2..9. */
static int on_duplicate(char whose, int k, int *originals)
{
    int which = whose == '-' ? CHATTER : whose == '+' ? BACKBONE : LOOP, n = 0;
    int b = whose == '-'   ? s2_minus()
            : whose == '+' ? between(BACKBONE, "S2+[01]", -1, -1)
                           : between(LOOP, "A1[0]", at(LOOP, "G1_0,4"), -1);
    *originals = 0;
    for (int q = 2; q <= k; q++)
        for (int p = 1; p < q && k % q == 0; p++) {
            int hit = multiplications(which, b, p, q, NULL);
            n += hit;
            if (q == k) *originals += hit;
        }
    return n;
}

static verdict k_minus_one(finding *f, const char *arg)
{
    bool right = true;
    for (int k = 2; k <= 9; k++) {
        int originals, n = on_duplicate(arg[0], k, &originals);
        say(f, "%sk = %d: %d, %d original", k > 2 ? "; " : "", k, n, originals);
        right = right && n == k - 1;
    }
    return stated(right);
}

static verdict first_on_a1(finding *f, const char *arg)
{
    int first = 0, originals;
    (void)arg;
    for (int k = 2; k <= 9; k++) {
        int n = on_duplicate('a', k, &originals);
        if (n && !first) first = k;
        say(f, "%sk = %d: %d", k > 2 ? "; " : "", k, n);
    }
    return stated(first == 4);
}

/* The rotation number passes 1/3 only beyond the grazing. */
static verdict ghosts_of_a1(finding *f, const char *arg)
{
    int b = between(LOOP, "A1[0]", at(LOOP, "G1_0,4"), -1), n = 0, passed[2] = {0, 0};
    double most = 0;
    ric_ghost **ghosts = NULL;
    ric_ghost_limits limits;
    (void)arg;
    for (int i = 0; i < branch(LOOP, b).n_point; i++)
        if (point(LOOP, b, i).stable == RIC_STABLE_YES)
            most = fmax(most, point(LOOP, b, i).rotation);
    ric_ghost_limits_init(atlas_of(LOOP), &limits);
    if (ric_ghost_find(atlas_of(LOOP), b, &limits, &n, &ghosts)) fail_msg("%s", ric_detail());
    for (int g = 0; g < n; g++) {
        ric_ghost_data data;
        ric_point p, q;
        ric_ghost_describe(ghosts[g], &data);
        for (int i = 1; i < data.n_point; i++) {
            assert_int_equal(ric_ghost_point(ghosts[g], i - 1, &p, NULL, NULL), RIC_OK);
            assert_int_equal(ric_ghost_point(ghosts[g], i, &q, NULL, NULL), RIC_OK);
            passed[0] += sinh(p.trace) > -0.5 && sinh(q.trace) <= -0.5; /* trace -1: 1/3 */
            passed[1] += sinh(p.trace) > -1 && sinh(q.trace) <= -1;     /* trace -2: 1/2 */
        }
    }
    ric_ghosts_free(n, ghosts);
    say(f,
        "rotation number up to %.6f on the branch; beyond its grazing it passes 1/3 %s and 1/2 %s",
        most, passed[0] ? "as a ghost" : "never", passed[1] ? "as a ghost" : "never");
    return stated(most < 1.0 / 3 && passed[0] > 0 && passed[1] > 0);
}

static verdict only_on_stable_parts(finding *f, const char *arg)
{
    static const int which[4] = {CHATTER, BACKBONE, LOOP, DUPLICATES};
    int n = 0, wrong = 0;
    (void)arg;
    for (int k = 0; k < 4; k++)
        for (int id = 1; id <= ric_atlas_n_branch(atlas_of(which[k])); id++) {
            ric_branch b = branch(which[k], id);
            for (int i = 0; i < b.n_junction; i++) {
                ric_junction j = junction(which[k], b.junctions[i]);
                if (j.kind != RIC_KIND_MULTIPLICATION || j.impacts != b.impacts) continue;
                bool beside = false;
                for (int m = 1; m < b.n_point; m++) {
                    ric_point one = point(which[k], id, m - 1), two = point(which[k], id, m);
                    if (one.arclength > b.junction_at[i] || two.arclength < b.junction_at[i])
                        continue;
                    beside = beside || one.stable != RIC_STABLE_NO || two.stable != RIC_STABLE_NO;
                }
                n++;
                wrong += !beside;
            }
        }
    say(f, "%d multiplications on branches with impacts, %d of them not in or beside a stable part",
        n, wrong);
    return stated(n > 100 && !wrong);
}

#endif
