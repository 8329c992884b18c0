/* What sections 2.3, 2.4 and 3.1 of the article state, as far as it can be looked up in an atlas
 * (table in test_article.c). */
#ifndef ARTICLE_ELEMENTARY_H
#define ARTICLE_ELEMENTARY_H

#include "article_atlases.h"

/* A check computes what there is, says it with digits, and compares: as the article states,
 * otherwise in exactly the manner that the table describes, or neither, which is a failure. Nothing
 * but the computed atlas decides. */
typedef enum { AS_STATED, OTHERWISE, NEITHER } verdict;
typedef struct {
    char text[2048];
    size_t used;
} finding;

__attribute__((format(printf, 2, 3))) static void say(finding *f, const char *format, ...)
{
    va_list list;
    va_start(list, format);
    int n = vsnprintf(f->text + f->used, sizeof f->text - f->used, format, list);
    va_end(list);
    assert_true(n >= 0 && f->used + (size_t)n < sizeof f->text);
    f->used += (size_t)n;
}

static verdict stated(bool yes)
{
    return yes ? AS_STATED : NEITHER;
}

static void say_junction(finding *f, int which, int id)
{
    ric_junction j = junction(which, id);
    say(f, "%s at E %.9g, omega %.9g", ric_kind_text(j.kind), j.energy, j.frequency);
    if (j.kind == RIC_KIND_GRAZING)
        say(f, " (N %d, p %d)", j.impacts * j.multiple, j.grazings * j.multiple);
    if (j.kind == RIC_KIND_MULTIPLICATION) say(f, " (%d/%d)", j.rotation[0], j.rotation[1]);
    if (j.a) say(f, " (C_%d%d)", j.a, j.b);
}

/* --------------------------------------------------------------- 2.3 forms */

static verdict symmetric_words(finding *f, const char *arg)
{
    int n = 0, wrong = 0;
    (void)arg;
    for (int k = 0; k < N_SETTLED; k++)
        for (int id = 1; id <= ric_atlas_n_branch(atlas_of(settled[k])); id++) {
            ric_branch b = branch(settled[k], id);
            if (!b.symmetric || !b.impacts) continue;
            n++;
            wrong += b.impacts % 2 != 0;
            for (int i = 0; i < b.impacts / 2; i++) wrong += b.word[i] == b.word[i + b.impacts / 2];
        }
    say(f, "%d S branches with impacts in %d atlases, %d of them with another word", n, N_SETTLED,
        wrong);
    return stated(n > 50 && !wrong);
}

static verdict three_impacts(finding *f, const char *arg)
{
    uint64_t n;
    int classes[2] = {0, 0};
    (void)arg;
    assert_int_equal(ric_word_count(NULL, 3, false, &n), RIC_OK);
    for (int i = 0; i < 8; i++) {
        int word[3] = {i >> 2 & 1, i >> 1 & 1, i & 1}, least[3];
        assert_int_equal(ric_word_canonical(NULL, 3, word, false, least), RIC_OK);
        classes[least[2]]++;
    }
    say(f, "%d independent words: 001 stands for %d of the 8, 000 for %d", (int)n, classes[1],
        classes[0]);
    return stated(n == 2 && classes[1] == 6 && classes[0] == 2);
}

static int totient(int n)
{
    int count = 0;
    for (int i = 1; i <= n; i++) {
        int a = n, b = i;
        while (b) {
            int r = a % b;
            a = b, b = r;
        }
        count += a == 1;
    }
    return count;
}

/* Twice eq. 38. */
static double twice_eq38(int n)
{
    double sum = 0;
    int divisors = 0;
    for (int j = 1; j <= n; j++)
        if (n % j == 0) sum += totient(j) * pow(2, (double)n / j);
    for (int j = 1; n % 2 == 0 && j <= n / 2; j++) divisors += n / 2 % j == 0;
    return sum / n + divisors;
}

static verdict words_counted(finding *f, const char *arg)
{
    bool odd = !strcmp(arg, "odd"), right = true, below = false;
    for (int n = odd ? 1 : 2; n <= 12; n += 2) {
        uint64_t count;
        assert_int_equal(ric_word_count(NULL, n, false, &count), RIC_OK);
        double bound = twice_eq38(n) / 2;
        say(f, "%sN %d: %d, eq. 38 %g", n < 3 ? "" : "; ", n, (int)count, bound);
        right = right && (odd ? bound == (double)count : bound <= (double)count);
        below = below || bound < (double)count;
    }
    return stated(right && below == !odd);
}

static verdict time_reversal_merges(finding *f, const char *arg)
{
    int first = 0;
    (void)arg;
    for (int n = 1; n <= 9; n++) {
        uint64_t with, without;
        assert_int_equal(ric_word_count(NULL, n, true, &with), RIC_OK);
        assert_int_equal(ric_word_count(NULL, n, false, &without), RIC_OK);
        if (with != without && !first) first = n;
        if (n >= 6)
            say(f, "%sN %d: %d without reversal, %d with it", n == 6 ? "" : "; ", n, (int)without,
                (int)with);
    }
    return first == 7 ? OTHERWISE : first == 0 ? AS_STATED : NEITHER;
}

static verdict duplicate_is_a_solution(finding *f, const char *arg)
{
    int b = between(ELEMENTARY, "S2-[01]", at(ELEMENTARY, "G2_0,2"), 0), n, fits = 0;
    ric_junction j = junction(ELEMENTARY, at(ELEMENTARY, "C1_33"));
    ric_orbit **orbits;
    (void)arg;
    assert_int_equal(ric_orbit_find(atlas_of(ELEMENTARY), b, RIC_AT_ENERGY, j.energy, &n, &orbits),
                     RIC_OK);
    for (int i = 0; i < n; i++) {
        ric_point p;
        ric_orbit_data(orbits[i], &p, NULL, NULL, NULL);
        if (!near(p.frequency, 3 * j.frequency)) continue;
        say(f, "S2- at E %.9g has omega %.9g, drawn as a 3-duplicate at %.9g", p.energy,
            p.frequency, j.frequency);
        fits++;
    }
    ric_orbits_free(n, orbits);
    return stated(fits == 1 && j.multiple == 3 && j.impacts == 2);
}

/* ---------------------------------------------------------- 2.4.1 grazings */

/* With all departures taken: N regular impacts and N + p on two branches that end there. */
static verdict grazing_joins_n_and_n_plus_p(finding *f, const char *arg)
{
    int n = 0, wrong = 0, which[2] = {ELEMENTARY, TONGUES};
    (void)arg;
    for (int k = 0; k < 2; k++)
        for (int id = 1; id <= ric_atlas_n_junction(atlas_of(which[k])); id++) {
            ric_junction j = junction(which[k], id);
            bool few = false, many = false;
            if (j.kind != RIC_KIND_GRAZING || j.departures.over_budget || j.departures.refused)
                continue;
            if (k && !j.impacts) continue; /* only one of the modes is started from */
            for (int i = 0; i < j.n_branch; i++) {
                ric_branch b = branch(which[k], j.branches[i]);
                few = few || (ends_at(b, id) && b.impacts == j.impacts);
                many = many || (ends_at(b, id) && b.impacts == j.impacts + j.grazings);
            }
            n++;
            wrong += !few || !many;
            if (!few || !many) say(f, "not at %s; ", j.label);
        }
    say(f, "%d of %d grazings left in all directions", n - wrong, n);
    return stated(n >= 10 && !wrong);
}

static verdict grazing_bound(finding *f, const char *arg)
{
    int n = 0, wrong = 0, most = 0;
    (void)arg;
    for (int k = 0; k < N_SETTLED; k++)
        for (int id = 1; id <= ric_atlas_n_junction(atlas_of(settled[k])); id++) {
            ric_junction j = junction(settled[k], id);
            if (j.kind != RIC_KIND_GRAZING) continue;
            n++;
            wrong += j.n_branch > 1 << (j.grazings * j.multiple);
            if (j.n_branch > most) most = j.n_branch;
        }
    say(f, "%d grazings, at most %d branches at one, %d with more than 2^p", n, most, wrong);
    return stated(n > 50 && !wrong && most > 2);
}

/* -------------------------------------------------------- 2.4.2 stability */

static verdict stable_is_marginal(finding *f, const char *arg)
{
    int n = 0;
    double worst = 0;
    (void)arg;
    for (int id = 1; id <= ric_atlas_n_branch(atlas_of(ELEMENTARY)); id++)
        for (int i = 0; i < branch(ELEMENTARY, id).n_point; i += 5) {
            ric_orbit **orbit;
            int found;
            double pair[4];
            if (point(ELEMENTARY, id, i).stable != RIC_STABLE_YES) continue;
            assert_int_equal(ric_orbit_find(atlas_of(ELEMENTARY), id, RIC_AT_POINT, i, &found,
                                            &orbit),
                             RIC_OK);
            if (ric_orbit_multipliers(orbit[0], pair)) fail_msg("%s", ric_detail());
            worst = fmax(worst, fmax(fabs(hypot(pair[0], pair[1]) - 1),
                                     fabs(hypot(pair[2], pair[3]) - 1)));
            ric_orbits_free(found, orbit);
            n++;
        }
    say(f, "stable orbits of all branches: multipliers on the unit circle: %s",
        worst < 1e-9 ? "yes, to 1e-9" : "no");
    return stated(n > 20 && worst < 1e-9);
}

/* ------------------------------------------------- 2.4.3 critical points */

static verdict extrema_do_not_branch(finding *f, const char *arg)
{
    int n = 0, wrong = 0, turning = 0, open = 0, which[2] = {ELEMENTARY, TONGUES};
    (void)arg;
    for (int k = 0; k < 2; k++)
        for (int id = 1; id <= ric_atlas_n_junction(atlas_of(which[k])); id++) {
            ric_junction j = junction(which[k], id);
            if (j.kind != RIC_KIND_EXTREMUM) continue;
            n++;
            open += !j.a || !j.decided;
            wrong += j.b != 1 || (j.a != 2 && j.a != 3) || j.n_branch != 1;
            ric_branch b = branch(which[k], j.branches[0]);
            double s = place_on(which[k], b.id, id), before = 0, after = 0;
            for (int i = 0; i < b.n_point; i++) {
                ric_point p = point(which[k], b.id, i);
                double over = p.trace - asinh(1); /* its own point, and those that are undecided,
                                                     are within 1e-9 of it */
                if (fabs(over) < 1e-9) continue;
                if (p.arclength < s) before = over;
                else if (after == 0) after = over;
            }
            turning += before * after < 0;
        }
    say(f,
        "%d extrema, a and b measured at all but %d; b = 1 and one branch at all but %d; the trace "
        "passes 2 at %d",
        n, open, wrong, turning);
    return stated(n > 10 && !open && !wrong && turning == n);
}

static verdict branch_points_have_two(finding *f, const char *arg)
{
    int n = 0, wrong = 0, open = 0, which[2] = {ELEMENTARY, TONGUES};
    (void)arg;
    for (int k = 0; k < 2; k++)
        for (int id = 1; id <= ric_atlas_n_junction(atlas_of(which[k])); id++) {
            ric_junction j = junction(which[k], id);
            if (j.kind != RIC_KIND_BRANCH_POINT || j.departures.over_budget) continue;
            n++;
            open += !j.a || !j.decided;
            wrong += j.b != 2 || (j.a != 2 && j.a != 3) || j.n_branch != 2;
        }
    say(f, "%d branch points, a and b measured at all but %d; b = 2 and two branches at all but %d",
        n, open, wrong);
    return stated(n > 10 && !open && !wrong);
}

/* Four curves in the unknowns (z0, beta, T): the duplicate and, as a family leaves with q = 3, the
 * same S6 begun at impact 0, 2 or 4. */
static verdict four_curves_at_c33(finding *f, const char *arg)
{
    int id = at(ELEMENTARY, "C1_33"),
        b = between(ELEMENTARY, "S6[010101]", at(ELEMENTARY, "G1_4,2"), at(ELEMENTARY, "G1_2,4")),
        starts = 1;
    ric_junction j = junction(ELEMENTARY, id);
    double flights[6], state[4];
    ric_point p;
    (void)arg;
    assert_int_equal(ric_atlas_point(atlas_of(ELEMENTARY), b, 20, &p, state, flights), RIC_OK);
    for (int shift = 2; shift < 6; shift += 2) {
        double apart = 0;
        for (int i = 0; i < 6; i++)
            apart = fmax(apart, fabs(flights[i] - flights[(i + shift) % 6]));
        starts += apart > 1e-3;
    }
    say(f,
        "a = %d, b = %d; one family S6[010101] that passes, in %d ways of choosing the first "
        "impact, and the duplicate",
        j.a, j.b, starts);
    return stated(j.a == 3 && j.b == 3 && starts == 3 && j.n_branch == 2 &&
                  passes(branch(ELEMENTARY, b), id));
}

/* ------------------------------------------------------------- 3.1 Fig. 3 */

static verdict frequencies(finding *f, const char *arg)
{
    double omega[2], locked;
    const ric_model *m = ric_atlas_model(atlas_of(ELEMENTARY));
    (void)arg;
    assert_int_equal(ric_model_frequencies(m, omega), RIC_OK);
    assert_int_equal(ric_model_locked_frequencies(m, 0, &locked), RIC_OK);
    say(f, "omega_1 %.9g, omega_2 %.9g, omega_0 %.9g", omega[0], omega[1], locked);
    return stated(fabs(omega[0] - 0.9287) < 5e-5 && fabs(omega[1] - 2.1535) < 5e-5 &&
                  fabs(locked - 1.6330) < 5e-5);
}

static verdict parameters_as_printed(finding *f, const char *arg)
{
    double mass[4] = {2, 0, 0, 2}, stiffness[4] = {9, -1, -1, 1}, normal[2] = {-1, 1}, omega[2],
           right[2];
    ric_contact c = {.normal = normal,
                     .clearance = 1,
                     .sides = RIC_SIDES_BOTH,
                     .law = RIC_LAW_RIGID};
    ric_model *m = NULL;
    (void)arg;
    assert_int_equal(ric_model_create(2, mass, stiffness, 1, &c, 1, &m), RIC_OK);
    assert_int_equal(ric_model_frequencies(m, omega), RIC_OK);
    ric_model_free(m);
    assert_int_equal(ric_model_frequencies(ric_atlas_model(atlas_of(ELEMENTARY)), right), RIC_OK);
    say(f, "m_2 = 2 gives omega_1 %.5g, omega_2 %.5g; m_2 = 1 gives %.5g and %.5g", omega[0],
        omega[1], right[0], right[1]);
    if (fabs(omega[0] - 0.9287) < 5e-5 && fabs(omega[1] - 2.1535) < 5e-5) return AS_STATED;
    return fabs(right[0] - 0.9287) < 5e-5 && fabs(right[1] - 2.1535) < 5e-5 ? OTHERWISE : NEITHER;
}

/* No motion reaches a stop below 1/2 k_2 d^2; the least energy of any impacting orbit found is
 * above it. */
static verdict only_modes_at_low_energy(finding *f, const char *arg)
{
    double least = INFINITY;
    char label[64] = "";
    (void)arg;
    for (int which = 0; which < N_EXPLORED; which++)
        for (int id = 1; id <= ric_atlas_n_branch(atlas_of(which)); id++) {
            ric_branch b = branch(which, id);
            if (!b.impacts || b.energy_min >= least) continue;
            least = b.energy_min;
            snprintf(label, sizeof label, "%s", b.label);
        }
    bool from_zero = branch(ELEMENTARY, between(ELEMENTARY, "S0+", -1, -1)).energy_min == 0 &&
                     branch(ELEMENTARY, between(ELEMENTARY, "S0-", -1, -1)).energy_min == 0;
    say(f,
        "both modes start at E 0; least energy with impacts: %.9g on %s; no stop is reached below "
        "0.5",
        least, label);
    return stated(from_zero && least > 0.5);
}

/* arg: the mode and the grazing where it ends. */
static verdict mode_ends(finding *f, const char *arg)
{
    bool plus = arg[0] == '+';
    int id = at(ELEMENTARY, plus ? "G1_0,2" : "G2_0,2"),
        b = between(ELEMENTARY, plus ? "S0+" : "S0-", 0, id);
    if (!id || !b) return NEITHER;
    say_junction(f, ELEMENTARY, id);
    say(f, ", stable on %.3g of its length", branch(ELEMENTARY, b).stable_fraction);
    return stated(branch(ELEMENTARY, b).stable_fraction == 1 &&
                  junction(ELEMENTARY, id).grazings == 2);
}

static verdict two_candidates_one_admissible(finding *f, const char *arg)
{
    bool right = true;
    (void)arg;
    for (int i = 0; i < 2; i++) {
        int id = at(ELEMENTARY, i ? "G2_0,2" : "G1_0,2");
        ric_junction j = junction(ELEMENTARY, id);
        int s2 = leaving(ELEMENTARY, id, i ? "S2-[01]" : "S2+[01]", NULL),
            a1 = leaving(ELEMENTARY, id, "A1[0]", NULL);
        say(f, "%s%s: S0, %d S2[01], %d A1[0], %d candidate inadmissible", i ? "; " : "",
            i ? "G2_0,2" : "G1_0,2", s2, a1, j.departures.inadmissible);
        right = right && j.n_branch == 2 && s2 == 1 && a1 == 0 && j.departures.inadmissible == 1;
    }
    return stated(right);
}

static verdict half_periods(finding *f, const char *arg)
{
    bool right = true;
    (void)arg;
    for (int i = 0; i < 2; i++) {
        int id = at(ELEMENTARY, i ? "G2_0,2" : "G1_0,2"), b = 0;
        double flights[2];
        ric_point p;
        if (leaving(ELEMENTARY, id, i ? "S2-[01]" : "S2+[01]", &b) != 1) return NEITHER;
        ric_branch row = branch(ELEMENTARY, b);
        assert_int_equal(ric_atlas_point(atlas_of(ELEMENTARY), b,
                                         row.from == id ? 0 : row.n_point - 1, &p, NULL, flights),
                         RIC_OK);
        say(f, "%s%s: flights %.9g and %.9g of T", i ? "; " : "", row.label,
            flights[0] * p.frequency / (2 * M_PI), flights[1] * p.frequency / (2 * M_PI));
        right = right && row.symmetric && near(flights[0], flights[1]) &&
                near(2 * flights[0] * p.frequency, 2 * M_PI);
    }
    return stated(right);
}

static double s2_trace(double frequency); /* article_map.h */

static int s2_minus(void)
{
    return between(CHATTER, "S2-[01]", at(CHATTER, "G2_0,2"), 0);
}

static verdict s2_minus_begins(finding *f, const char *arg)
{
    int b = s2_minus(), c = at(CHATTER, "C2_31"), g = at(CHATTER, "G2_0,2"), n = 0, falls = 0;
    (void)arg;
    double end = place_on(CHATTER, b, c);
    for (int i = 1; i < branch(CHATTER, b).n_point && point(CHATTER, b, i).arclength < end;
         i++, n++)
        falls += point(CHATTER, b, i).energy < point(CHATTER, b, i - 1).energy;
    say(f, "energy falls all the way: %s; stable: %s; to ", falls == n ? "yes" : "no",
        stable_between(CHATTER, b, g, c) ? "in part" : "no");
    say_junction(f, CHATTER, c);
    return stated(n > 3 && falls == n && stable_between(CHATTER, b, g, c) == 0);
}

static verdict s2_minus_goes_on(finding *f, const char *arg)
{
    int b = s2_minus(), c = at(CHATTER, "C2_31"), others = 0, unstable = 0;
    (void)arg;
    ric_branch row = branch(CHATTER, b);
    double s = place_on(CHATTER, b, c);
    for (int i = 0; i < row.n_junction; i++)
        others += junction(CHATTER, row.junctions[i]).multiple == 1 && row.junctions[i] != c;
    for (int i = 0; i < row.n_point; i++) {
        ric_point p = point(CHATTER, b, i);
        unstable += p.arclength > s && p.stable == RIC_STABLE_NO;
    }
    /* beyond the window: lambda + 1 / lambda of the closed form tends to 2 - (omega_0 T)^2, from
     * below 2, without coming near 2 or -2 */
    double locked, last = 0, first = junction(CHATTER, c).frequency;
    assert_int_equal(ric_model_locked_frequencies(ric_atlas_model(atlas_of(CHATTER)), 0, &locked),
                     RIC_OK);
    for (double w = 1.0001 * first; w < 1e4; w *= 1.001) {
        double turned = (2 - s2_trace(w)) / pow(locked * 2 * M_PI / w, 2);
        unstable += !(s2_trace(w) > -2 && turned > 0);
        last = turned;
    }
    say(f,
        "stable up to E %.6g, omega %.6g, the end of the window; junctions of the original on the "
        "way: %d; by the "
        "closed form stable up to omega 1e4, where 2 - trace is %.6f (omega_0 T)^2",
        row.energy_max, row.frequency_max, others, last);
    return stated(row.stop == RIC_STOP_WINDOW && !others && !unstable && fabs(last - 1) < 1e-5 &&
                  near(row.energy_min, junction(CHATTER, c).energy));
}

/* arg: "LABEL|END|END|A|B|yes": the branch with these ends (- : the window) is stable, or not,
 * between A and B. */
static verdict segment_stable(finding *f, const char *arg)
{
    char label[32], end[2][32], mark[2][32], want[8];
    int id[2], b;
    assert_int_equal(sscanf(arg, "%31[^|]|%31[^|]|%31[^|]|%31[^|]|%31[^|]|%7s", label, end[0],
                            end[1], mark[0], mark[1], want),
                     6);
    for (int i = 0; i < 2; i++) id[i] = end[i][0] == '-' ? 0 : at(ELEMENTARY, end[i]);
    b = between(ELEMENTARY, label, id[0], id[1]);
    if (!b) return NEITHER;
    int stable = stable_between(ELEMENTARY, b, at(ELEMENTARY, mark[0]), at(ELEMENTARY, mark[1]));
    say(f, "%s between %s and %s: %s, E %.9g to %.9g", label, mark[0], mark[1],
        stable == 1   ? "stable"
        : stable == 0 ? "unstable"
                      : "both",
        junction(ELEMENTARY, at(ELEMENTARY, mark[0])).energy,
        junction(ELEMENTARY, at(ELEMENTARY, mark[1])).energy);
    return stated(stable == (want[0] == 'y'));
}

/* arg: "LABEL|END|END": there is exactly one such branch. */
static verdict edge(finding *f, const char *arg)
{
    char label[32], end[2][32];
    int id[2];
    assert_int_equal(sscanf(arg, "%31[^|]|%31[^|]|%31[^|]", label, end[0], end[1]), 3);
    for (int i = 0; i < 2; i++) id[i] = at(ELEMENTARY, end[i]);
    int b = between(ELEMENTARY, label, id[0], id[1]);
    if (!id[0] || !id[1] || !b) return NEITHER;
    say(f, "%s from ", label);
    say_junction(f, ELEMENTARY, id[0]);
    say(f, " to ");
    say_junction(f, ELEMENTARY, id[1]);
    for (int i = 0; i < 2; i++) { /* N, p, a and b as the name says */
        ric_junction j = junction(ELEMENTARY, id[i]);
        const place *p = place_named(end[i]);
        if (j.impacts != p->impacts || j.grazings != p->grazings || j.a != p->a || j.b != p->b)
            return NEITHER;
    }
    return AS_STATED;
}

static verdict horizontal(finding *f, const char *arg)
{
    char label[32], end[2][32];
    assert_int_equal(sscanf(arg, "%31[^|]|%31[^|]|%31[^|]", label, end[0], end[1]), 3);
    int b = between(ELEMENTARY, label, at(ELEMENTARY, end[0]), at(ELEMENTARY, end[1]));
    if (!b) return NEITHER;
    ric_branch row = branch(ELEMENTARY, b);
    say(f, "%s from E %.9g to %.9g: omega %.9g, constant to %s", label, row.energy_min,
        row.energy_max, row.frequency_min,
        row.frequency_max - row.frequency_min < 1e-12 ? "1e-12" : "less than 1e-12");
    return stated(row.frequency_max - row.frequency_min < 1e-12);
}

static verdict a2_restores_stability(finding *f, const char *arg)
{
    int b = between(ELEMENTARY, "A2[01]", at(ELEMENTARY, "C1_32"), at(ELEMENTARY, "G1_2,2"));
    (void)arg;
    if (!b) return NEITHER;
    int stable = stable_between(ELEMENTARY, b, at(ELEMENTARY, "C1_32"), at(ELEMENTARY, "G1_2,2"));
    say(f, "A2[01], symmetric: %s, stable: %s", branch(ELEMENTARY, b).symmetric ? "yes" : "no",
        stable == 1 ? "from end to end" : "not everywhere");
    return stated(!branch(ELEMENTARY, b).symmetric && stable == 1);
}

/* --------------------------------------------------------- 3.1 Figs. 6 - 9 */

static verdict seven_forms(finding *f, const char *arg)
{
    static const char *const form[7] = {"S2+[01]",  "S6[010101]", "A5[00101]", "A3[001]",
                                        "A4[0101]", "S4[0011]",   "A4[0001]"};
    int id = at(ELEMENTARY, "G1_2,4"), once = 0;
    ric_junction j = junction(ELEMENTARY, id);
    ric_departures d = j.departures;
    (void)arg;
    for (int i = 0; i < 7; i++) once += leaving(ELEMENTARY, id, form[i], NULL) == 1;
    say(f,
        "%d candidates up to symmetry of 2^%d subsets, %d inadmissible; %d of the 7 forms leave "
        "once",
        d.taken + d.known + d.inadmissible, j.grazings, d.inadmissible, once);
    return stated(d.taken + d.known == 7 && !d.inadmissible && once == 7 && j.n_branch == 7 &&
                  j.grazings == 4);
}

static verdict edges_pair(finding *f, const char *arg)
{
    char one[64], two[64];
    assert_int_equal(sscanf(arg, "%63[^&]&%63s", one, two), 2);
    verdict first = edge(f, one);
    say(f, "; ");
    return first == AS_STATED ? edge(f, two) : NEITHER;
}

/* The stable part of S6 begins at C3_32; it ends at the energy minimum, which is not C1_33. */
static verdict s6_stable_part(finding *f, const char *arg)
{
    int b = between(ELEMENTARY, "S6[010101]", at(ELEMENTARY, "G1_4,2"), at(ELEMENTARY, "G1_2,4"));
    int c32 = at(ELEMENTARY, "C3_32"), low = at(ELEMENTARY, "S6 minimum"),
        c33 = at(ELEMENTARY, "C1_33");
    (void)arg;
    if (!b) return NEITHER;
    int inside = stable_between(ELEMENTARY, b, c32, low),
        beyond = stable_between(ELEMENTARY, b, low, c33);
    double most = 0;
    for (int i = 0; i < branch(ELEMENTARY, b).n_point; i++) {
        ric_point p = point(ELEMENTARY, b, i);
        if (p.arclength > place_on(ELEMENTARY, b, c33) &&
            p.arclength < place_on(ELEMENTARY, b, low))
            most = fmax(most, 2 * sinh(p.trace) - 2);
    }
    say(f, "stable from E %.10g down to the minimum %.10g: %s; from there to C1_33 at %.10g: %s",
        junction(ELEMENTARY, c32).energy, junction(ELEMENTARY, low).energy,
        inside == 1 ? "yes" : "no", junction(ELEMENTARY, c33).energy,
        beyond == 1   ? "stable"
        : beyond == 0 ? "unstable"
                      : "not decided");
    if (inside == 1 && beyond == 1) return AS_STATED;
    return inside == 1 && beyond == 0 && most > 0 && most < 4e-9 &&
                   stable_between(ELEMENTARY, b, at(ELEMENTARY, "G1_2,4"), c32) == 0 &&
                   stable_between(ELEMENTARY, b, c33, at(ELEMENTARY, "G1_4,2")) == 0
               ? OTHERWISE
               : NEITHER;
}

static verdict s4_changes_at_c2_32(finding *f, const char *arg)
{
    int b = between(ELEMENTARY, "S4[0011]", at(ELEMENTARY, "G1_4,2"), 0),
        c = at(ELEMENTARY, "C2_32");
    (void)arg;
    if (!b) return NEITHER;
    int before = stable_between(ELEMENTARY, b, at(ELEMENTARY, "G1_4,2"), c),
        after = stable_between(ELEMENTARY, b, c, at(ELEMENTARY, "C3_31"));
    say(f, "%s from G1_4,2 to C2_32 at E %.9g, %s from there to C3_31 at E %.9g",
        before == 1   ? "stable"
        : before == 0 ? "unstable"
                      : "both",
        junction(ELEMENTARY, c).energy,
        after == 1   ? "stable"
        : after == 0 ? "unstable"
                     : "both",
        junction(ELEMENTARY, at(ELEMENTARY, "C3_31")).energy);
    return stated(before >= 0 && after == 1 - before);
}

static verdict extra_point_on_the_duplicate(finding *f, const char *arg)
{
    int b = s2_minus(), own = 0, id = 0;
    (void)arg;
    ric_branch row = branch(CHATTER, b);
    for (int i = 0; i < row.n_junction; i++) {
        ric_junction j = junction(CHATTER, row.junctions[i]);
        own += j.kind == RIC_KIND_BRANCH_POINT ||
               (j.kind == RIC_KIND_MULTIPLICATION && j.multiple == 1);
    }
    int n = multiplications(CHATTER, b, 2, 3, &id);
    say(f, "branch points of the original S2-: %d; on its 3-duplicate ", own);
    say_junction(f, CHATTER, id);
    return stated(own == 0 && n == 1 && near(junction(CHATTER, id).frequency, 1.6862380961394556));
}

#endif
