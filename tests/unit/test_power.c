/* Structures with power-law contacts: published numbers, the symmetric path, duplicates, and orbits
 * confirmed by CVODE. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "close.h"
#include "explored.h"

#include "cvode_flow.h"
#include "sample.h"

/* The two masses of the article, eq. 51, and those of Peeters et al. 2009. */
static const char article[] =
    "{mass: [[2, 0], [0, 1]], stiffness: [[9, -1], [-1, 1]],"
    " contacts: [{normal: [-1, 1], law: power, exponent: %d, length: 1, reference: 1}]}";
static const char peeters[] =
    "{mass: [[1, 0], [0, 1]], stiffness: [[2, -1], [-1, 2]],"
    " contacts: [{normal: [1, 0], law: power, exponent: %d, stiffness: 0.5}]}";

static ric_atlas *explore(const char *model, int exponent, const char *options, double max_step)
{
    char text[1024], filled[512];
    const char *hole = strstr(model, "%d");
    snprintf(filled, sizeof filled, "%.*s%d%s", (int)(hole - model), model, exponent, hole + 2);
    snprintf(text, sizeof text, "title: power\nmodel: %s\nexplore: {%s}\n", filled, options);
    return explore_text_with(text, NULL, max_step);
}

/* Every `step`-th point of a branch from `first` on returns, as the atlas is verified. */
static void points_return(const ric_atlas *atlas, int id, int first, int step)
{
    for (int i = first; i < branch_of(atlas, id).n_point; i += step) point_passes(atlas, id, i);
}

/* ------------------------------------------------------------ published numbers */

static double frequency_at(const ric_atlas *atlas, int branch, double energy)
{
    int n;
    ric_orbit **orbits;
    ric_point point;
    if (ric_orbit_find(atlas, branch, RIC_AT_ENERGY, energy, &n, &orbits))
        fail_msg("%s", ric_detail());
    assert_int_equal(n, 1);
    ric_orbit_data(orbits[0], &point, NULL, NULL, NULL);
    assert_true(agrees(point.energy, energy, 1e-13));
    ric_orbits_free(n, orbits);
    return point.frequency;
}

static void published_frequencies(void **state)
{
    static const struct {
        const char *model;
        int mode;
        double energy, frequency;
    } rows[] = {
        {article, 1, 0.1, 0.9702075828},    {article, 1, 1, 1.1344581549},
        {article, 1, 10, 1.3645473094},     {article, 1, 100, 1.5174431415},
        {article, 2, 0.1, 2.158130071},     {article, 2, 1, 2.2045300075},
        {article, 2, 10, 2.8125826533},     {article, 2, 100, 4.7422508771},
        {peeters, 1, 0.1, 1.0089740489232}, {peeters, 1, 1, 1.0659067704481},
        {peeters, 1, 10, 1.2069054736664},  {peeters, 2, 0.1, 1.733868548993},
        {peeters, 2, 1, 1.7515011762514},   {peeters, 2, 10, 2.0295858271784},
    };
    (void)state;
    const char *options = "energy: [0, 105], frequency: [0.2, 10], multiply: 1, depth: 1";
    ric_atlas *atlases[2] = {explore(article, 3, options, 0), explore(peeters, 3, options, 0)};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        const ric_atlas *atlas = atlases[rows[i].model == peeters];
        ric_branch b = branch_of(atlas, rows[i].mode);
        assert_int_equal(b.mode, rows[i].mode);
        double frequency = frequency_at(atlas, b.id, rows[i].energy);
        if (!agrees(frequency, rows[i].frequency, 1e-9))
            fail_msg("mode %d at energy %g: %.12g, published %.12g", rows[i].mode, rows[i].energy,
                     frequency, rows[i].frequency);
    }
    ric_atlas_free(atlases[0]);
    ric_atlas_free(atlases[1]);
}

/* --------------------------------------------------------------- symmetric path */

/* Place of the first junction of a kind on a branch from place `from` on, -1: none. */
static int next_of(const ric_atlas *atlas, const ric_branch *b, int from, ric_kind kind,
                   int multiple)
{
    for (int i = from; i < b->n_junction; i++) {
        ric_junction j = junction_of(atlas, b->junctions[i]);
        if (j.kind == kind && j.multiple == multiple) return i;
    }
    return -1;
}

/* From the linear mode over C32 to C33 with an energy extremum beside it, and on to energy 1e3. */
static ric_branch goes_all_the_way(const ric_atlas *atlas, int exponent)
{
    ric_branch b = branch_of(atlas, 1);
    assert_int_equal(ric_atlas_n_branch(atlas), 1);
    assert_int_equal(b.stop, RIC_STOP_WINDOW);
    assert_true(b.symmetric && b.impacts == 0 && agrees(b.energy_max, 1000, 1e-9));
    int first = next_of(atlas, &b, 0, RIC_KIND_BRANCH_POINT, 1),
        tripling = next_of(atlas, &b, first, RIC_KIND_MULTIPLICATION, 3);
    int fold = next_of(atlas, &b, first, RIC_KIND_EXTREMUM, 1);
    assert_true(first >= 0 && tripling > first && fold > first);
    if (exponent == 3) { /* published */
        assert_true(agrees(junction_of(atlas, b.junctions[first]).frequency, 1.2411838299, 1e-9));
        assert_true(agrees(junction_of(atlas, b.junctions[first]).energy, 2.764187897, 1e-9));
    }
    return b;
}

/* The same for the steps of tools/steps.py, over a factor 100; the short form takes two of the
 * twenty, and the least and the greatest exponent. */
static void symmetric_path(void **state)
{
    static const int exponents[] = {3, 7, 21};
    (void)state;
    for (int e = 0; e < 3; e += every_of(2)) {
        ric_atlas *smallest = NULL;
        ric_branch path;
        for (int step = 0; step < 20; step += every_of(19)) {
            ric_atlas *atlas = explore(
                article, exponents[e],
                "start: [1], energy: [0, 1000], frequency: [0.2, 10], multiply: 1, depth: 1",
                0.01 * pow(100, step / 19.0));
            ric_branch b = goes_all_the_way(atlas, exponents[e]);
            if (!smallest) {
                smallest = atlas;
                path = b;
                continue;
            }
            assert_int_equal(b.n_junction, path.n_junction);
            for (int i = 0; i < b.n_junction; i++) {
                ric_junction j = junction_of(atlas, b.junctions[i]),
                             k = junction_of(smallest, path.junctions[i]);
                bool same = j.kind == k.kind && j.multiple == k.multiple && j.a == k.a &&
                            j.b == k.b;
                if (!same || !agrees(j.energy, k.energy, 1e-9) ||
                    !agrees(j.frequency, k.frequency, 1e-9))
                    fail_msg("n = %d: %s at E %.14g omega %.14g, with the smallest step %s at E "
                             "%.14g omega %.14g",
                             exponents[e], j.label, j.energy, j.frequency, k.label, k.energy,
                             k.frequency);
            }
            ric_atlas_free(atlas);
        }
        ric_atlas_free(smallest);
    }
}

/* x -> -x takes motions of these structures to motions; the marks in their cycles are no faces
 * (found by the address sanitizer). */
static void marks_are_no_faces(void **state)
{
    (void)state;
    ric_atlas *atlas =
        explore(article, 3,
                "start: [1], energy: [0, 1], frequency: [0.2, 10], multiply: 1, depth: 1", 0);
    ric_periodic *cycle = ric_periodic_create(2, 2);
    assert_non_null(cycle);
    cycle->face[0] = cycle->face[1] = -1;
    assert_true(ric_periodic_mirrors(ric_atlas_model(atlas), cycle));
    ric_periodic_free(cycle);
    ric_atlas_free(atlas);
}

/* Both modes with a cubic spring, and what leaves them: several tests read it. */
static int explore_cubic(void **state)
{
    *state = explore(article, 3, "energy: [0, 1000], frequency: [0.2, 10], multiply: 2, depth: 2",
                     0);
    return 0;
}

static int free_cubic(void **state)
{
    ric_atlas_free(*state);
    return 0;
}

/* The period of an orbit without impacts is one flight, whose time fraction is fixed: extrema and
 * doublings have a = 3 whether it is S or A, and those whose ranks are lost in rounding say the
 * same. */
static void extrema_have_three(void **state)
{
    const ric_atlas *atlas = *state;
    int measured[2] = {0, 0};
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        ric_branch b = branch_of(atlas, id);
        for (int i = 0; i < b.n_junction && !b.symmetric; i++) {
            ric_junction j = junction_of(atlas, b.junctions[i]);
            bool doubling = j.kind == RIC_KIND_MULTIPLICATION && j.multiple == 2;
            if (j.kind != RIC_KIND_EXTREMUM && !doubling) continue;
            assert_true(j.a == 3 && (!doubling ? j.b == 1 : j.b >= 2));
            measured[doubling] += j.decided;
        }
    }
    assert_true(measured[0] > 0 && measured[1] > 0);
}

/* Deep in a cascade ranks may come out smaller than the kind of a junction allows, C_11 for the
 * extremum at energy 719.975: that is rounding, and not decided. With a large step, too, both
 * doublings at 215.9 and 221.2 are found, between which a multiplier stays just below -1, the
 * doubling at 719.9098, and no extremum at 719.919, where two families come close. Steps of 0.27,
 * 0.08 and 0.03 find the same 86 junctions. The short form ends at energy 740, where the first
 * branches of the cascade do not come back yet. */
static void no_fewer_than_the_kind_has(void **state)
{
    (void)state;
    char options[128];
    snprintf(options, sizeof options,
             "start: [2], energy: [0, %d], frequency: [0.18, 6], multiply: 4, depth: 0, cascade: "
             "[3, 2, 4]",
             long_form() ? 880 : 740);
    ric_atlas *atlas = explore(article, 3, options, 0.27);
    int met = 0;
    for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
        ric_junction j = junction_of(atlas, id);
        if (j.kind != RIC_KIND_EXTREMUM && j.kind != RIC_KIND_BRANCH_POINT &&
            j.kind != RIC_KIND_MULTIPLICATION)
            continue;
        if (j.a < 2 || j.b < (j.kind == RIC_KIND_EXTREMUM ? 1 : 2))
            fail_msg("%s at E %.12g", j.label, j.energy);
        met += agrees(j.energy, 719.974716905, 1e-9) +
               10 * (agrees(j.energy, 215.896607776, 1e-9) || agrees(j.energy, 221.16272669, 1e-9));
        assert_false(agrees(j.energy, 719.91926876, 1e-9));
    }
    assert_int_equal(met, long_form() ? 21 : 0);
    assert_int_equal(ric_atlas_n_junction(atlas), long_form() ? 86 : 25);
    ric_atlas_free(atlas);
}

/* The eight-duplicate of the segment between the extremum near omega 1.609 and the branch point
 * near 1.584 carries exactly the multiplications p/8, p = 1..7. */
static void eight_duplicate(void **state)
{
    (void)state;
    ric_atlas *atlas =
        explore(article, 3,
                "start: [1], energy: [0, 1000], frequency: [0.1, 10], multiply: 8, depth: 1", 0);
    ric_branch b = branch_of(atlas, 1);
    int found[8] = {0}, total = 0, inside = 0, ends = 0;
    for (int i = 0; i < b.n_junction; i++) {
        ric_junction j = junction_of(atlas, b.junctions[i]);
        bool point = j.kind == RIC_KIND_BRANCH_POINT && agrees(j.frequency, 1.584, 3e-4);
        bool extremum = j.kind == RIC_KIND_EXTREMUM && agrees(j.frequency, 1.609, 3e-4);
        if (point || extremum) {
            inside = !inside;
            ends++;
        }
        if (!inside || j.kind != RIC_KIND_MULTIPLICATION || 8 % j.multiple) continue;
        found[j.rotation[0] * 8 / j.multiple]++;
        total++;
    }
    assert_int_equal(ends, 2);
    assert_int_equal(inside, 0);
    for (int p = 1; p < 8; p++)
        if (found[p] + found[8 - p] != 2)
            fail_msg("%d multiplications %d/8 or %d/8", found[p] + found[8 - p], p, 8 - p);
    assert_int_equal(total, 7);
    ric_atlas_free(atlas);
}

/* Amplitudes of sin(omega t) and sin(3 omega t) in x1 of an orbit with z(t+T/2) = -z(t) that starts
 * at a centre, integrated by CVODE, which has to find it in the opposite state after half a period.
 */
static void harmonics(const ric_atlas *atlas, const double *state, double period, double *first,
                      double *third)
{
    enum { SAMPLES = 48 };
    const ric_model *m = ric_atlas_model(atlas);
    ric_contact contact;
    double z[4], size = 0, off = 0;
    assert_int_equal(ric_model_contact(m, 0, &contact), RIC_OK);
    memcpy(z, state, sizeof z);
    *first = *third = 0;
    for (int i = 0; i < SAMPLES; i++) {
        *first += 2.0 / SAMPLES * z[0] * sin(i * M_PI / SAMPLES);
        *third += 2.0 / SAMPLES * z[0] * sin(i * 3 * M_PI / SAMPLES);
        cvode_fly(m, 2, ric_model_mass(m), ric_model_stiffness(m), 1, &contact,
                  period / 2 / SAMPLES, z, z + 2);
    }
    for (int k = 0; k < 4; k++) {
        size = fmax(size, fabs(state[k]));
        off = fmax(off, fabs(z[k] + state[k]));
    }
    if (!(off < 1e-8 * size))
        fail_msg("CVODE returns with %g after half a period of %g", off / size, period);
}

/* The loop of the 3:1 resonance (Peeters et al. 2009), which is one branch, S+. On the backbone x1
 * has little of the third harmonic. From an extremum of the energy on the branch leaves it, with
 * the first harmonic falling to 0: there it is the other mode gone through three times, and touches
 * its 3-duplicate. It comes back with the first harmonic in the opposite phase, over two more
 * extrema, and is the backbone again: that of x1 being drawn along by x2 as x1^3 ~ sin(omega t),
 * whose third harmonic is 1/5 of the first. */
static void tongue(void **state)
{
    (void)state;
    ric_atlas *atlas = explore(peeters, 3,
                               "energy: [0, 10000], frequency: [0.2, 20], multiply: 3, depth: 1",
                               0);
    ric_branch in = branch_of(atlas, 1), out = branch_of(atlas, 2);
    /* of the extrema, in order */
    static const double energies[] = {4680.546292756, 285.1589908027, 2105.466020769,
                                      1786.385084028};
    double at[4] = {0}, touch = -1, first = 0, third = 0;
    int extrema = 0, taken_over = 0;
    for (int i = 0; i < in.n_junction; i++) {
        ric_junction j = junction_of(atlas, in.junctions[i]);
        bool shared = false;
        for (int k = 0; k < out.n_junction; k++) shared |= in.junctions[i] == out.junctions[k];
        if (shared) {
            assert_true(touch < 0 && j.kind == RIC_KIND_MULTIPLICATION && j.multiple == 3);
            assert_true(agrees(3 * j.frequency, frequency_at(atlas, out.id, j.energy), 1e-9));
            assert_true(agrees(j.energy, 285.1593439288, 1e-9) &&
                        agrees(j.frequency, 1.407414986264, 1e-9));
            harmonics(atlas, j.state, 6.283185307179586 / j.frequency, &first, &third);
            assert_true(fabs(first) < 1e-8 * fabs(third));
            touch = in.junction_at[i];
        }
        if (j.kind != RIC_KIND_EXTREMUM) continue;
        assert_true(extrema < 4 && agrees(j.energy, energies[extrema], 1e-9));
        at[extrema++] = in.junction_at[i];
    }
    assert_int_equal(extrema, 4);
    assert_true(at[0] < touch && touch < at[2] &&
                fabs(at[1] - touch) < 0.1); /* one extremum lies next to the touch */
    bool mostly_third = false;
    for (int i = 0; i < in.n_point; i += i < in.n_point - 8 ? 8 : 1) {
        double z[4], period;
        ric_point p;
        assert_int_equal(ric_atlas_point(atlas, in.id, i, &p, z, &period), RIC_OK);
        if (p.energy < 1 || fabs(p.arclength - touch) < 1) continue;
        harmonics(atlas, z, period, &first, &third);
        assert_true((first * third < 0) == (p.arclength < touch));
        if ((fabs(third) > fabs(first)) == mostly_third) continue;
        mostly_third = !mostly_third;
        /* on the way out shortly before the greatest energy, on the way back between the last two
         * extrema */
        assert_true(++taken_over == 1
                        ? p.arclength < at[0] && p.energy > 2500
                        : taken_over == 2 && p.arclength > at[2] && p.arclength <= at[3]);
    }
    assert_int_equal(taken_over, 2);
    print_message("# at E %.6g the third harmonic is %.3f of the first\n", in.energy_max,
                  third / first);
    assert_true(agrees(third / first, 0.2, 0.1));
    assert_int_equal(in.stop, RIC_STOP_WINDOW);
    assert_true(agrees(in.energy_max, 10000, 1e-9));
    ric_atlas_free(atlas);
}

/* ------------------------------------------------------------- from outside */

static double largest_multiplier(const ric_atlas *atlas, int branch, int point)
{
    int n;
    ric_orbit **orbits;
    double multipliers[8], most = 1;
    if (ric_orbit_find(atlas, branch, RIC_AT_POINT, point, &n, &orbits))
        fail_msg("%s", ric_detail());
    assert_int_equal(n, 1);
    assert_int_equal(ric_orbit_multipliers(orbits[0], multipliers), RIC_OK);
    for (int i = 0; i < 2 * (ric_model_n_dof(ric_atlas_model(atlas)) - 1); i++)
        most = fmax(most, hypot(multipliers[2 * i], multipliers[2 * i + 1]));
    ric_orbits_free(n, orbits);
    return most;
}

/* Period and energy of stored orbits: the replay of the program, and CVODE on the raw matrices. */
static void orbits_return(void **state)
{
    static const int exponents[] = {3, 7, 21};
    (void)state;
    for (int e = 0; e < 3; e += every_of(2)) {
        ric_atlas *atlas = explore(article, exponents[e],
                                   "energy: [0, 40], frequency: [0.2, 10], multiply: 2, depth: 2",
                                   0);
        const ric_model *m = ric_atlas_model(atlas);
        ric_contact contact;
        int tried = 0;
        assert_int_equal(ric_model_contact(m, 0, &contact), RIC_OK);
        for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
            ric_branch b = branch_of(atlas, id);
            for (int i = 0; i < b.n_point; i += 1 + b.n_point / (long_form() ? 5 : 2), tried++) {
                ric_point p;
                double x[4], y[4], flight, off = 0, size = 0, E;
                point_passes(atlas, id, i);
                assert_int_equal(ric_atlas_point(atlas, id, i, &p, x, &flight), RIC_OK);
                memcpy(y, x, sizeof y);
                double own = cvode_fly(m, 2, ric_model_mass(m), ric_model_stiffness(m), 1, &contact,
                                       flight, y, y + 2);
                for (int k = 0; k < 4; k++) {
                    off = fmax(off, fabs(y[k] - x[k]));
                    size = fmax(size, fabs(x[k]));
                }
                E = ric_model_energy(m, y, y + 2);
                double allowed = 1e-9 * fmax(1, 1e-7 * largest_multiplier(atlas, id, i)) + 10 * own;
                if (!(off <= allowed * size && own < 1e-6 && agrees(E, p.energy, 1e-9 + 10 * own)))
                    fail_msg("n = %d: branch %d, point %d: CVODE returns with %g, sure of %g, "
                             "energy %.13g for %.13g",
                             exponents[e], id, i, off / size, own, E, p.energy);
            }
        }
        assert_true(tried > (long_form() ? 10 : 3));
        ric_atlas_free(atlas);
    }
}

/* Method 11: a power law tends to the rigid stop as log(m) / m. The time in which the spring stops
 * the mass is that to the turning point s^(m+1) = E (m+1) / k2, so the error of the frequency times
 * (m+1) / log(E (m+1) / k2) tends to a constant. */
static void tends_to_the_stop(void **state)
{
    static const int exponents[] = {21, 51, 99};
    static const char stop[] =
        "model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n"
        "  contacts: [{normal: [-1, 1], clearance: 1, law: rigid}]\n"
        "explore: {start: [1], energy: [0, 12], frequency: [0.2, 10], impacts: 2, multiply: 1, "
        "depth: 1}\n";
    (void)state;
    ric_atlas *rigid = explore_text(stop);
    double limit = 0, constant[3];
    for (int id = 1; id <= ric_atlas_n_branch(rigid); id++)
        if (branch_of(rigid, id).symmetric && branch_of(rigid, id).impacts == 2)
            limit = frequency_at(rigid, id, 10);
    assert_true(agrees(limit, 1.571293037, 1e-9));
    for (int i = 0; i < 3; i++) {
        int m = exponents[i];
        ric_atlas *atlas =
            explore(article, m,
                    "start: [1], energy: [0, 12], frequency: [0.2, 10], multiply: 1, depth: 1", 0);
        constant[i] = (limit - frequency_at(atlas, 1, 10)) * (m + 1) / log(10 * (m + 1));
        print_message("# m = %d: %.6f\n", m, constant[i]);
        ric_atlas_free(atlas);
    }
    ric_atlas_free(rigid);
    assert_true(fabs(constant[2] - constant[1]) < 0.5 * fabs(constant[1] - constant[0]));
    assert_true(agrees(constant[2], constant[1], 0.03));
}

/* The bridge of section 3.3 at n = 21: orbits with z(t+T/2) = -z(t) and without mirror points,
 * whose phase is free, on one branch from one branch point of the symmetric path to another. */
static void bridge(void **state)
{
    (void)state;
    ric_atlas *atlas =
        explore(article, 21,
                "start: [1], energy: [0, 200], frequency: [0.9, 10], multiply: 1, depth: 2", 0);
    int bridges = 0;
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        ric_branch b = branch_of(atlas, id);
        if (b.stop == RIC_STOP_FAILED) fail_msg("branch %d %s: %s", id, b.label, b.why);
        if (!b.symmetric || b.reversible) continue;
        bridges++;
        assert_true(b.from && b.to);
        double low = junction_of(atlas, b.from).energy, high = junction_of(atlas, b.to).energy;
        assert_true(agrees(fmin(low, high), 27.8224604684721, 1e-9) &&
                    agrees(fmax(low, high), 70.1256339201796, 1e-9));
        points_return(atlas, id, 0, 7);
    }
    assert_int_equal(bridges, 1);
    ric_atlas_free(atlas);
}

static bool counted(void *user)
{
    ++*(int *)user;
    return false;
}

/* At a branch point the unknowns are known to rounding over a pivot that is rounding, too: what is
 * moved by that is another orbit, whose flights through any energy take seconds, and it says
 * nothing of the multipliers. The work is counted by the questions whether to stop. */
static void ends_cost_no_more(void **state)
{
    const ric_atlas *atlas = *state;
    int asked = 0, ends = 0;
    ric_halt_ask(counted, &asked);
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        ric_branch b = branch_of(atlas, id);
        for (int end = 0; end < 2 && b.from && b.to; end++, ends++)
            largest_multiplier(atlas, id, end * (b.n_point - 1));
    }
    ric_halt_ask(NULL, NULL);
    print_message("# %d ends: %d questions\n", ends, asked);
    assert_true(ends >= 4 && asked < 100 * ends);
}

/* The second asymmetric branch of Fig. 26, from one branch point of the first to another. Near
 * energy 26.83 neighbours grow to 1600 times their distance between the middle and the end of a
 * period, and to 12 times over all of it: by the matrix of the period alone no step converges. */
static void grows_on_the_way(void **state)
{
    (void)state;
    for (int run = 0; run < 2; run += every_of(2)) {
        ric_atlas *atlas =
            explore(article, 21,
                    "start: [1], energy: [0, 100], frequency: [0.9, 10], multiply: 1, depth: 3",
                    run ? 0.05 : 0);
        int found = 0;
        for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
            ric_branch b = branch_of(atlas, id);
            if (b.stop == RIC_STOP_FAILED) fail_msg("branch %d %s: %s", id, b.label, b.why);
            if (b.symmetric || b.reversible) continue;
            found++;
            assert_true(b.from && b.to);
            double low = junction_of(atlas, b.from).energy, high = junction_of(atlas, b.to).energy;
            assert_true(agrees(fmin(low, high), 5.20922215932, 1e-9) &&
                        agrees(fmax(low, high), 30.2390126342, 1e-9));
            points_return(atlas, id, 0, 7 * every_of(2));
        }
        assert_int_equal(found, 1);
        ric_atlas_free(atlas);
    }
}

/* Multiplicities are measured, and not those of the kind: but for the turning and the tripling,
 * 1e-5 apart in energy. */
static void labels_are_measured(void **state)
{
    const ric_atlas *atlas = *state;
    int points = 0;
    for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
        ric_junction j = junction_of(atlas, id);
        bool point = j.kind == RIC_KIND_BRANCH_POINT || j.kind == RIC_KIND_MULTIPLICATION,
             extremum = j.kind == RIC_KIND_EXTREMUM;
        points += point;
        if ((point || (extremum && !agrees(j.energy, 109.858, 1e-4))) && !j.decided)
            fail_msg("%s at energy %.9g", j.label, j.energy);
        if ((point && (j.a != 3 || j.b < 2)) || (extremum && (j.a != 3 || j.b != 1)))
            fail_msg("%s at energy %.9g", j.label, j.energy);
    }
    assert_true(points > 10);
}

/* Branches without mirror points start and end where these are gained, at any phase of the orbit:
 * none runs on along its mirror image. The cubic spring has bridges of orbits with and without
 * z(t+T/2) = -z(t). */
static void arrivals_without_mirrors(void **state)
{
    (void)state;
    ric_atlas *atlas = explore(article, 3,
                               "energy: [0, 700], frequency: [0.3, 10], multiply: 3, depth: 4", 0);
    int found[2] = {0}, closed = 0;
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        ric_branch b = branch_of(atlas, id);
        if (b.stop == RIC_STOP_FAILED) fail_msg("branch %d %s: %s", id, b.label, b.why);
        bool loop = b.stop == RIC_STOP_CLOSED && b.symmetric;
        closed += loop;
        for (int i = 0; loop && i < b.n_junction; i++) /* once round */
            for (int k = 0; k < i; k++) assert_int_not_equal(b.junctions[i], b.junctions[k]);
        if (b.reversible) continue;
        found[b.symmetric]++;
        assert_true(b.from && b.to && b.from != b.to);
        assert_int_equal(junction_of(atlas, b.from).kind, RIC_KIND_BRANCH_POINT);
        assert_int_equal(junction_of(atlas, b.to).kind, RIC_KIND_BRANCH_POINT);
        points_return(atlas, id, 0, 5 * every_of(3));
    }
    assert_int_equal(found[true], 2);
    assert_int_equal(found[false], 1);
    assert_int_equal(closed, 1);
    ric_atlas_free(atlas);
}

/* A branch that begins at a multiplication which it passes ends there after one way round, and
 * belongs to that junction. */
static void closes_where_it_passes(void **state)
{
    (void)state;
    ric_atlas *atlas = explore(article, 21,
                               "energy: [0, 1], frequency: [0.2, 10], multiply: 3, depth: 2", 0);
    int closed = 0;
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        ric_branch b = branch_of(atlas, id);
        int met[2] = {0};
        if (b.stop != RIC_STOP_CLOSED) continue;
        closed++;
        for (int i = 0; i < b.n_junction; i++) {
            ric_junction j = junction_of(atlas, b.junctions[i]);
            met[0] += j.kind == RIC_KIND_MULTIPLICATION && agrees(j.energy, 0.44126693712, 1e-9);
            met[1] += j.kind == RIC_KIND_MULTIPLICATION && agrees(j.energy, 0.637389887786, 1e-9);
        }
        assert_true(b.symmetric && met[0] == 1 && met[1] == 1);
    }
    assert_int_equal(closed, 1);
    ric_atlas_free(atlas);
}

/* Contacts of power 99 take a hundredth of the shortest period, and neighbours grow by 1e7 on the
 * way. The branch without mirror points between two branch points is there once, no branch fails,
 * and the middle of each returns. */
static void power_99(void **state)
{
    (void)state;
    if (!long_form()) skip();
    ric_atlas *atlas = explore(article, 99,
                               "energy: [0, 6], frequency: [0.2, 10], multiply: 2, depth: 3", 0);
    int met = 0;
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        ric_branch b = branch_of(atlas, id);
        if (b.stop == RIC_STOP_FAILED) fail_msg("branch %d %s: %s", id, b.label, b.why);
        points_return(atlas, id, b.n_point / 2, b.n_point);
        if (b.reversible || b.from == 0 || b.to == 0) continue;
        met += agrees(junction_of(atlas, b.from).energy, 4.79941468408, 1e-9) &&
               agrees(junction_of(atlas, b.to).energy, 5.22578464693, 1e-9);
    }
    assert_int_equal(met, 1);
    ric_atlas_free(atlas);
}

/* Exponent 99 at energy 83: neighbours of the doubled orbits part so fast that Newton's method on
 * the start alone converges only within some 1e-6 of them. Without inner nodes the third branch of
 * the whole window has residuals of 3e-10 and its fourth, which is the second of the narrow one, is
 * not found. `from`: energies of the junctions that the branches begin at. */
static void check_inner_nodes(const char *window, int n_branch, const double *from)
{
    char options[128];
    snprintf(options, sizeof options, "energy: [%s], frequency: [0.8, 1.7], multiply: 2, depth: 2",
             window);
    ric_atlas *atlas = explore(article, 99, options, 0);
    assert_int_equal(ric_atlas_n_branch(atlas), n_branch);
    for (int id = 1; id <= n_branch; id++) {
        ric_branch b = branch_of(atlas, id);
        if (b.stop != RIC_STOP_WINDOW) fail_msg("branch %d %s: %s", id, b.label, b.why);
        if (id > 1) assert_true(agrees(junction_of(atlas, b.from).energy, from[id - 1], 1e-9));
        for (int i = 0; i < b.n_point; i++) {
            ric_point point;
            assert_int_equal(ric_atlas_point(atlas, id, i, &point, NULL, NULL), RIC_OK);
            assert_true(point.residual < 2e-11);
        }
        points_return(atlas, id, 3, 5);
    }
    ric_atlas_free(atlas);
}

static void inner_nodes(void **state)
{
    static const double whole[] = {0, 83.7172337166, 83.7172337166, 82.8669787131},
                        narrow[] = {0, 82.8669787131};
    (void)state;
    check_inner_nodes("82.84, 82.9", 2, narrow);
    if (long_form()) check_inner_nodes("82, 85", 4, whole); /* a quarter of a minute */
}

/* A backbone without junctions at its ends is found in its midst: it is followed to one end, and
 * from there over all of it. The other side is not followed for itself, which would cost two steps
 * for every point. */
static void backbones_are_followed_from_one_end(void **state)
{
    (void)state;
    ric_study *study = NULL;
    const char
        *text = "model: {mass: [[1, 0], [0, 1]], stiffness: [[2, -1], [-1, 2]],"
                " contacts: [{normal: [1, 0], law: power, exponent: 3, stiffness: 0.5}]}\n"
                "explore: {energy: [1e-6, 100], frequency: [0.2, 9], multiply: 1, depth: 1}\n";
    assert_int_equal(ric_study_parse(text, "test", ".", &study), RIC_OK);
    ric_graph *graph = explored_graph(study);
    int points = 0;
    assert_int_equal(graph->n_edge, 2);
    for (int i = 0; i < graph->n_edge; i++) points += graph->edges[i].trace->n_point;
    if (!(points > 100 && graph->fresh < 1.7 * points))
        fail_msg("%d steps for %d points", (int)graph->fresh, points);
    ric_graph_free(graph);
    ric_study_free(study);
}

/* A backbone that is found below a region of the plane comes to it on the way back from its lower
 * end: what multiplies in the region is looked for there, too. */
static void backbones_come_to_regions(void **state)
{
    (void)state;
    const char *plain = "energy: [1e-6, 1000], frequency: [0.2, 9], depth: 1, multiply: 4}\n#",
               *region = "energy: [1e-6, 1000], frequency: [0.2, 9], depth: 1, multiply: 1}\n"
                         "regions: [{energy: [5, 1000], frequency: [0.2, 9], multiply: 4}]\n#";
    ric_atlas *all = explore(peeters, 3, plain, 0), *some = explore(peeters, 3, region, 0);
    int count[2] = {0, 0};
    for (int i = 0; i < 2; i++)
        for (int id = 1; id <= ric_atlas_n_junction(i ? some : all); id++) {
            const ric_junction j = junction_of(i ? some : all, id);
            count[i] += j.kind == RIC_KIND_MULTIPLICATION && j.energy > 5;
        }
    assert_int_equal(count[0], 5);
    assert_int_equal(count[1], 5);
    ric_atlas_free(all);
    ric_atlas_free(some);
}

/* What is stored of an orbit, which takes no flight where the start tells it, is the start of the
 * orbit that is flown: at both mirror points, both ways, as it is and at x -> -x, with and without
 * mirror points. */
static void stored_starts(void **state)
{
    (void)state;
    ric_study *study = NULL;
    const char *text = "model: {mass: [[2, 0], [0, 1]], stiffness: [[9, -1], [-1, 1]],"
                       " contacts: [{normal: [-1, 1], law: power, exponent: 3, length: 1,"
                       " reference: 1}]}\n"
                       "explore: {energy: [0, 700], frequency: [0.3, 10], multiply: 3, depth: 4}\n";
    assert_int_equal(ric_study_parse(text, "test", ".", &study), RIC_OK);
    ric_graph *graph = explored_graph(study);
    const ric_model *m = graph->model;
    int seen[3] = {0}; /* chains of a quarter of a period, of a half, of all of it or a half */
    for (int e = 0; e < graph->n_edge; e++) {
        const ric_continuation *tr = graph->edges[e].trace;
        ric_shooting *c = tr->chain;
        seen[c->start == RIC_MIRROR_NONE ? 2 : c->multiple == 4 ? 0 : 1]++;
        for (int i = 0; i < tr->n_point; i += 7) {
            const double *u = tr->points + (size_t)i * tr->stride +
                              sizeof(ric_point) / sizeof(double),
                         *other = u + (i > 0 ? -1 : 1) * (ptrdiff_t)tr->stride;
            for (int k = 0; k < 8; k++) {
                const ric_turn turn = {.shift = k / 4, .reverse = k & 1, .mirror = k & 2};
                double x[2][2], v[2][2], flights;
                ric_shooting_fly(c, other); /* nothing is left of this orbit */
                assert_int_equal(ric_turn_write(m, c, u, &turn, x[0], v[0], &flights), RIC_OK);
                ric_periodic *cycle = ric_turn_cycle(m, c, u, &turn);
                assert_non_null(cycle);
                ric_model_to_state(m, cycle->w, x[1], v[1]);
                ric_periodic_free(cycle);
                assert_memory_equal(x[0], x[1], sizeof *x);
                assert_memory_equal(v[0], v[1], sizeof *v);
            }
        }
    }
    assert_true(seen[0] > 0 && seen[1] > 0 && seen[2] > 0);
    ric_graph_free(graph);
    ric_study_free(study);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(published_frequencies),
        cmocka_unit_test(symmetric_path),
        cmocka_unit_test(marks_are_no_faces),
        cmocka_unit_test(extrema_have_three),
        cmocka_unit_test(no_fewer_than_the_kind_has),
        cmocka_unit_test(eight_duplicate),
        cmocka_unit_test(tongue),
        cmocka_unit_test(orbits_return),
        cmocka_unit_test(tends_to_the_stop),
        cmocka_unit_test(bridge),
        cmocka_unit_test(ends_cost_no_more),
        cmocka_unit_test(grows_on_the_way),
        cmocka_unit_test(labels_are_measured),
        cmocka_unit_test(arrivals_without_mirrors),
        cmocka_unit_test(closes_where_it_passes),
        cmocka_unit_test(power_99),
        cmocka_unit_test(inner_nodes),
        cmocka_unit_test(backbones_are_followed_from_one_end),
        cmocka_unit_test(backbones_come_to_regions),
        cmocka_unit_test(stored_starts),
    };
    return cmocka_run_group_tests(tests, explore_cubic, free_cubic);
}
