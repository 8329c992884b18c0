/* Sections: the map against the simulator, closed forms and stored orbits. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "explored.h"
#include "simulated_models.h"
#include "sample.h"
#include "studies.h"
#include "close.h"

#define SPRING                                                                                     \
    "title: spring\nmodel:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n"           \
    "  contacts:\n    - {normal: [-1, 1], clearance: 1.0, sides: both, law: bilinear, stiffness: " \
    "40}\n"
#define STOP_AND_SPRING                                                                            \
    "title: both\nmodel:\n  mass: [[1, 0], [0, 1.3]]\n  stiffness: [[3, -1], [-1, 2.2]]\n  "       \
    "contacts:\n"                                                                                  \
    "    - {normal: [1, 0], clearance: 1.0, sides: upper, law: rigid}\n"                           \
    "    - {normal: [0, 1], clearance: 0.8, sides: both, law: bilinear, stiffness: 15}\n"
#define CUBIC                                                                                      \
    "title: cubic\nmodel:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n"            \
    "  contacts:\n    - {normal: [-1, 1], law: power, exponent: 3, stiffness: 1.5}\n"
/* Two walls that know nothing of each other: two periodic motions beside each other, and no
 * exponent. */
#define DECOUPLED                                                                                  \
    "title: decoupled\nmodel:\n  mass: [[1, 0], [0, 1]]\n  stiffness: [[1, 0], [0, 2.3]]\n  "      \
    "contacts:\n"                                                                                  \
    "    - {normal: [1, 0], clearance: 1.0, sides: both, law: rigid}\n"                            \
    "    - {normal: [0, 1], clearance: 0.9, sides: both, law: rigid}\n"
#define ONE_MASS                                                                                   \
    "title: one\nmodel:\n  mass: [[1]]\n  stiffness: [[1]]\n  contacts:\n"                         \
    "    - {normal: [1], clearance: 1.0, sides: both, law: rigid}\n"

static ric_study *parse(const char *text)
{
    ric_study *study = NULL;
    if (ric_study_parse(text, "test", ".", &study)) fail_msg("%s", ric_detail());
    return study;
}

static ric_section_options options_of(double energy, int starts, long impacts)
{
    ric_section_options options;
    ric_section_options_init(&options);
    options.energy = energy;
    options.starts = starts;
    options.impacts = impacts;
    return options;
}

static ric_section *followed(const ric_model *model, const ric_section_options *options)
{
    ric_section *section = NULL;
    if (ric_section_create(model, options, &section) || ric_section_run(section))
        fail_msg("%s", ric_detail());
    return section;
}

static ric_section_track track_of(const ric_section *section, int start)
{
    ric_section_track track;
    assert_int_equal(ric_section_track_at(section, start, &track), RIC_OK);
    return track;
}

/* ------------------------------------------------------------------ energy */

static void energy_stays(void **state)
{
    (void)state;
    static const char *const texts[] = {TWO_MASSES, LOOSE_MASS, SPRING};
    for (int i = 0; i < 3; i++) {
        const long impacts = (i < 2 ? 1000000 : 200000) / (long_form() ? 1 : 5);
        ric_study *study = parse(texts[i]);
        const ric_model *model = ric_study_model(study);
        ric_section_options options = options_of(5, 1, impacts);
        ric_section *section = followed(model, &options);
        double x[2], v[2], worst = 0;
        assert_true(track_of(section, 0).impacts == impacts);
        for (long k = 0; k < impacts; k++) {
            assert_int_equal(ric_section_impact(section, 0, k, NULL, NULL, x, v), RIC_OK);
            worst = fmax(worst, fabs(ric_model_energy(model, x, v) / 5 - 1));
        }
        if (!(worst < 1e-12))
            fail_msg("%s: the energy is off by %.3g", ric_study_title(study), worst);
        assert_true(track_of(section, 0).energy_error <= worst &&
                    track_of(section, 0).energy_error > 0);
        ric_section_free(section);
        ric_study_free(study);
    }
}

/* --------------------------------------------------------------- simulator */

/* From impact k the simulator comes to impact k + 1. Closings of a spring from which the motion
 * starts, and openings, are no places on the section. */
static void next_is_the_simulators(const ric_section *section, ric_simulator *sim, int n, int start,
                                   long k)
{
    double x[n], v[n], x1[n], v1[n], t0, t1;
    int f0, f1;
    bool hit;
    ric_impact impact;
    assert_int_equal(ric_section_impact(section, start, k, &t0, &f0, x, v), RIC_OK);
    assert_int_equal(ric_section_impact(section, start, k + 1, &t1, &f1, x1, v1), RIC_OK);
    if (ric_simulator_start(sim, x, v)) fail_msg("%s", ric_detail());
    do {
        if (ric_simulator_advance(sim, 1.5 * (t1 - t0) + 1, &hit, &impact))
            fail_msg("%s", ric_detail());
    } while (hit && (impact.opens || (impact.time < 1e-12 && impact.impulse == 0)));
    if (!hit || impact.face != f1)
        fail_msg("start %d, impact %ld: face %d, not %d", start, k, f1, impact.face);
    ric_simulator_state(sim, NULL, x, v);
    double slow = fmax(1e-3, impact.approach);
    if (!(fabs(impact.time - (t1 - t0)) < 1e-12 * (1 + t1) + 1e-13 / slow))
        fail_msg("start %d, impact %ld: time %.17g, not %.17g; approach %g", start, k, t1 - t0,
                 impact.time, impact.approach);
    for (int i = 0; i < n; i++) {
        assert_close(x1[i], x[i], 1e-11 / slow);
        assert_close(v1[i], v[i], 1e-11 / slow);
    }
}

static void motions_are_the_simulators(const ric_model *model, double energy, int starts,
                                       long impacts)
{
    ric_section_options options = options_of(energy, starts, impacts);
    ric_section *section = followed(model, &options);
    ric_simulator *sim = NULL;
    assert_int_equal(ric_simulator_create(model, &sim), RIC_OK);
    long compared = 0;
    for (int i = 0; i < ric_section_n_start(section); i++)
        for (long k = 0; k + 1 < track_of(section, i).impacts; k++, compared++)
            next_is_the_simulators(section, sim, ric_model_n_dof(model), i, k);
    assert_true(compared > starts * impacts / 2);
    ric_simulator_free(sim);
    ric_section_free(section);
}

static void every_impact_is_the_simulators(void **state)
{
    (void)state;
    static const char *const texts[] = {TWO_MASSES, LOOSE_MASS,      TWO_WALLS,
                                        SPRING,     STOP_AND_SPRING, DECOUPLED};
    static const double energies[] = {0.75, 1.4, 6, 150};
    for (int i = 0; i < 6; i++)
        for (int e = 1; e < 4; e++) {
            ric_study *study = parse(texts[i]);
            motions_are_the_simulators(ric_study_model(study), energies[e], 5, 300);
            ric_study_free(study);
        }
}

static void random_structures_too(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 12; seed++) {
        int n = 2 + (int)(seed % 4), contacts = 1 + (int)(seed % 3);
        ric_model *model = make_random(seed, n, contacts, 1);
        double grazing[MAX_N], least = INFINITY;
        int contact[MAX_N];
        ric_model_grazing_energies(model, grazing, contact);
        for (int i = 0; i < n; i++) least = fmin(least, grazing[i]);
        motions_are_the_simulators(model, 3 * least, 4, 200);
        ric_model_free(model);
    }
}

/* -------------------------------------------------------------- known orbits */

/* The number of places on the section in a period: the impact at that time, -1 if there is none. */
static long impact_at(const ric_section *section, double time, double *x, double *v)
{
    double t = 0;
    for (long k = 1; k < track_of(section, 0).impacts; k++) {
        ric_section_impact(section, 0, k, &t, NULL, x, v);
        if (fabs(t - time) < 1e-6 * time) return k;
    }
    return -1;
}

/* ln of the largest multiplier with which an orbit comes back to more than its first digits. */
#define MOST 10

typedef struct {
    int returned, elliptic, hyperbolic;
} count;

/* ln of the growth from T to 2 T, against the multiplier; the way round against the rotation of the
 * multipliers. */
static void measures_are_the_multipliers(const ric_model *model, ric_section_options options,
                                         const ric_point *point, long N, count *c)
{
    double T = 6.283185307179586 / point->frequency;
    ric_section_track track[2];
    options.rows = false;
    for (int i = 0; i < 2; i++) {
        options.impacts = (point->stable == RIC_STABLE_YES ? 200 : 2 + 2 * i) * N + 1;
        ric_section *section = followed(model, &options);
        track[i] = track_of(section, 0);
        ric_section_free(section);
    }
    double trace = fabs(2 * sinh(point->trace));
    if (point->stable == RIC_STABLE_YES && trace < 1.9) {
        double gamma = point->rotation, turns = (double)N * track[0].rotation, bound = 2.0 / 200;
        assert_false(isnan(turns));
        if (fabs(remainder(turns - gamma, 1)) > bound && fabs(remainder(turns + gamma, 1)) > bound)
            fail_msg("%g turns of neighbours in a period of %ld impacts, not %g; exponent %g +- %g",
                     turns, N, gamma, track[0].lyapunov, track[0].lyapunov_error);
        c->elliptic++;
    } else if (point->stable == RIC_STABLE_NO && trace > 10 && trace < 300) {
        double grown = track[1].lyapunov * track[1].time - track[0].lyapunov * track[0].time,
               multiplier = acosh(trace / 2);
        assert_close(grown / (2 * multiplier), 1, 0.05);
        assert_close(track[1].time, 4 * T, 1e-3 * T);
        c->hyperbolic++;
    }
}

static void branch_returns(const ric_atlas *atlas, const ric_branch *branch, count *c)
{
    const ric_model *model = ric_atlas_model(atlas);
    int n = ric_model_n_dof(model);
    double state[2 * n], x[n], v[n];
    for (int i = branch->n_point / 3; i < branch->n_point - 1; i += 1 + branch->n_point / 3) {
        ric_point point;
        assert_int_equal(ric_atlas_point(atlas, branch->id, i, &point, state, NULL), RIC_OK);
        ric_section_options options = options_of(point.energy, 1, 200);
        options.n_given = 1;
        options.given = state;
        if (point.stable == RIC_STABLE_UNDECIDED || fabs(point.trace) > MOST) continue;
        ric_section *section = followed(model, &options);
        double first[2 * n], size = 0, T = 6.283185307179586 / point.frequency;
        ric_section_impact(section, 0, 0, NULL, NULL, first, first + n);
        long N = impact_at(section, T, x, v);
        if (N < 0) fail_msg("%s, point %d: no impact after the period", branch->label, i);
        for (int j = 0; j < n; j++)
            size = fmax(size, fmax(fabs(x[j] - first[j]), fabs(v[j] - first[n + j])));
        if (size > 1e-10 * fmax(1, exp(fabs(point.trace))))
            fail_msg("%s, point %d: back after %ld impacts, but %.3g off", branch->label, i, N,
                     size);
        c->returned++;
        ric_section_free(section);
        measures_are_the_multipliers(model, options, &point, N, c);
    }
}

static count orbits_return(const char *study, const char *explore)
{
    char text[2000];
    count c = {0};
    snprintf(text, sizeof text, "%sexplore: %s\n", study, explore);
    ric_atlas *atlas = explore_text(text);
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        ric_branch branch = branch_of(atlas, id);
        if (branch.impacts > 0 || ric_model_n_face(ric_atlas_model(atlas)) == 0)
            branch_returns(atlas, &branch, &c);
    }
    ric_atlas_free(atlas);
    return c;
}

static void stored_orbits_return(void **state)
{
    (void)state;
    count c = orbits_return(TWO_MASSES, "{energy: [0, 40], impacts: 6, multiply: 3, depth: 2}");
    assert_true(c.returned > 40 && c.elliptic > 5 && c.hyperbolic > 5);
    c = orbits_return(LOOSE_MASS, "{energy: [0, 10], impacts: 4, multiply: 2, depth: 2}");
    assert_true(c.returned > 3 && c.elliptic > 1);
    c = orbits_return(SPRING, "{energy: [0, 30], impacts: 4, multiply: 2, depth: 2}");
    assert_true(c.returned > 10 && c.elliptic > 3);
    c = orbits_return(STOP_AND_SPRING, "{energy: [0, 12], impacts: 4, multiply: 2, depth: 2}");
    assert_true(c.returned > 10 && c.elliptic > 3);
    c = orbits_return(CUBIC, "{energy: [0, 300], multiply: 2, depth: 2}");
    assert_true(c.returned > 3 && c.elliptic > 2);
}

/* --------------------------------------------------------------- exponents */

/* The deviation of a motion without exponent grows like t: the exponent is at most (ln t + a
 * constant) / t. */
static void no_exponent(const char *text, double energy)
{
    ric_study *study = parse(text);
    double before[8] = {0};
    for (long impacts = 1000; impacts <= 100000; impacts *= 10) {
        ric_section_options options = options_of(energy, 8, impacts);
        options.rows = false;
        ric_section *section = followed(ric_study_model(study), &options);
        for (int i = 0; i < ric_section_n_start(section); i++) {
            ric_section_track t = track_of(section, i);
            double scaled = t.lyapunov * t.time;
            if (!(fabs(scaled) < log((double)impacts) + 3))
                fail_msg("%s: growth by exp(%g)", ric_study_title(study), scaled);
            if (before[i] > 1) assert_close((scaled - before[i]) / log(10), 1, 0.3);
            assert_true(fabs(t.lyapunov) <= 2 * t.lyapunov_error);
            before[i] = scaled;
        }
        ric_section_free(section);
    }
    ric_study_free(study);
}

static void integrable_motions_have_no_exponent(void **state)
{
    (void)state;
    no_exponent(DECOUPLED, 4);
    no_exponent(ONE_MASS, 4);
}

/* Errors cover the difference to a run ten times as long. */
static void errors_cover(void **state)
{
    (void)state;
    ric_study *study = parse(TWO_MASSES);
    int chaotic = 0;
    ric_section_options options = options_of(5, 12, 2000);
    ric_section *brief = followed(ric_study_model(study), &options);
    options.impacts = 20000;
    ric_section *thorough = followed(ric_study_model(study), &options);
    for (int i = 0; i < 12; i++) {
        ric_section_track a = track_of(brief, i), b = track_of(thorough, i);
        assert_true(fabs(a.lyapunov - b.lyapunov) < 3 * (a.lyapunov_error + b.lyapunov_error));
        assert_true(b.lyapunov_error < a.lyapunov_error);
        chaotic += b.lyapunov > 10 * b.lyapunov_error;
        assert_true(isnan(b.rotation) == (b.lyapunov > 2 * b.lyapunov_error));
        if (isnan(a.rotation) || isnan(b.rotation)) continue;
        assert_true(fabs(remainder(a.rotation - b.rotation, 1)) <
                    a.rotation_error + b.rotation_error);
    }
    assert_true(chaotic >= 3 && chaotic <= 9);
    ric_section_free(brief);
    ric_section_free(thorough);
    ric_study_free(study);
}

/* ------------------------------------------------------------------ starts */

/* The starts fill the ball evenly: each of its sectors holds its part. */
static void starts_fill_the_section(void **state)
{
    (void)state;
    enum { STARTS = 800, SECTORS = 8, RINGS = 4 };
    ric_study *study = parse(TWO_MASSES);
    ric_section_options options = options_of(5, STARTS, 1);
    ric_section *section = followed(ric_study_model(study), &options);
    int held[RINGS][SECTORS] = {{0}};
    for (int i = 0; i < STARTS; i++) {
        double x[2], v[2], b[2];
        int face;
        assert_int_equal(ric_section_impact(section, i, 0, NULL, &face, x, v), RIC_OK);
        assert_int_equal(face, 0);
        assert_int_equal(ric_section_place(section, face, x, v, b), RIC_OK);
        double again[4], there[2];
        assert_int_equal(ric_section_state(section, face, b, again, again + 2), RIC_OK);
        assert_int_equal(ric_section_place(section, face, again, again + 2, there), RIC_OK);
        for (int k = 0; k < 2; k++) {
            assert_true(fabs(again[k] - x[k]) < 1e-12 && fabs(again[2 + k] - v[k]) < 1e-12);
            assert_true(fabs(there[k] - b[k]) < 1e-12);
        }
        double square = b[0] * b[0] + b[1] * b[1];
        assert_true(square < 1);
        held[(int)(square * RINGS)]
            [(int)((atan2(b[1], b[0]) / (2 * PI) + 0.5) * SECTORS) % SECTORS]++;
    }
    for (int r = 0; r < RINGS; r++)
        for (int s = 0; s < SECTORS; s++) assert_in_range(held[r][s], 15, 35);
    const double outside[2] = {0.8, 0.7};
    double nowhere[4];
    assert_int_equal(ric_section_state(section, 0, outside, nowhere, nowhere + 2), RIC_E_RANGE);
    assert_int_equal(ric_section_state(section, 99, outside, nowhere, nowhere + 2), RIC_E_RANGE);
    ric_section_free(section);
    ric_study_free(study);
}

static bool stop_early(double part, void *user)
{
    assert_true(part >= 0 && part <= 1);
    return ++*(int *)user == 3;
}

/* The same bits whatever the number of workers; a stop keeps what was done, and says so. */
static void workers_change_nothing(void **state)
{
    (void)state;
    static const char *const texts[] = {TWO_MASSES, STOP_AND_SPRING, CUBIC};
    for (int i = 0; i < 3; i++) {
        ric_study *study = parse(texts[i]);
        ric_section_options options = options_of(5, 9, 300);
        ric_section *alone = followed(ric_study_model(study), &options);
        options.workers = 4;
        ric_section *many = followed(ric_study_model(study), &options);
        for (int k = 0; k < 9; k++) {
            ric_section_track a = track_of(alone, k), b = track_of(many, k);
            assert_memory_equal(&a.lyapunov, &b.lyapunov, sizeof a.lyapunov);
            assert_memory_equal(&a.rotation, &b.rotation, sizeof a.rotation);
            double x[4], y[4];
            ric_section_impact(alone, k, 299, NULL, NULL, x, x + 2);
            ric_section_impact(many, k, 299, NULL, NULL, y, y + 2);
            assert_memory_equal(x, y, sizeof x);
        }
        ric_section_free(alone);
        ric_section_free(many);
        ric_study_free(study);
    }
}

static void a_stop_keeps_what_was_done(void **state)
{
    (void)state;
    int asked = 0;
    ric_study *study = parse(TWO_MASSES);
    ric_section_options options = options_of(5, 2, 20000);
    ric_section *section = NULL;
    options.progress = stop_early;
    options.user = &asked;
    assert_int_equal(ric_section_create(ric_study_model(study), &options, &section), RIC_OK);
    assert_int_equal(ric_section_run(section), RIC_E_INTERRUPTED);
    ric_section_track t = track_of(section, 0);
    assert_true(t.impacts > 4096 && t.impacts < 20000 && t.lyapunov_error > 0);
    assert_non_null(strstr(t.why, "stopped"));
    ric_section_free(section);
    ric_study_free(study);
}

/* ----------------------------------------------------------------- nonsense */

static void refused(const char *text, const ric_section_options *options, const char *what)
{
    ric_study *study = parse(text);
    ric_section *section = NULL;
    assert_int_equal(ric_section_create(ric_study_model(study), options, &section), RIC_E_INPUT);
    if (!strstr(ric_detail(), what)) fail_msg("'%s' does not say '%s'", ric_detail(), what);
    ric_study_free(study);
}

static void nonsense_is_refused(void **state)
{
    (void)state;
    static const double beyond[] = {0, 2, 0, 1}, other[] = {0, 0, 1, 1};
    ric_section_options options = options_of(0.1, 4, 10);
    refused(TWO_MASSES, &options, "the least energy that does is 0.5");
    options.energy = 1e30; /* impacts were lost in rounding, and the answer looked like any other */
    refused(TWO_MASSES, &options, "rounding hides their impacts");
    options.energy = -1;
    refused(TWO_MASSES, &options, "above 0");
    options.energy = NAN;
    refused(TWO_MASSES, &options, "above 0");
    options = options_of(5, 0, 10);
    refused(TWO_MASSES, &options, "a start and an impact");
    options = options_of(5, 4000000, 1000000);
    refused(TWO_MASSES, &options, "exponents only");
    options = options_of(5, 1, 10);
    options.radius = 2;
    refused(TWO_MASSES, &options, "from 0 to 1");
    options = options_of(5, 1, 10);
    options.n_given = 1;
    options.given = other;
    refused(TWO_MASSES, &options, "state 1 has the scaled energy 1.");
    options.given = beyond;
    refused(TWO_MASSES, &options, "beyond a stop");
    options = options_of(5, 1, 10);
    refused("model: {mass: [[1]], stiffness: [[1]], restitution: 0.9, contacts: [{normal: [1], "
            "clearance: 1}]}",
            &options, "restitution");
    refused("model: {mass: [[1, 0], [0, 1]], stiffness: [[0, 0], [0, 0]], contacts: [{normal: [1, "
            "0], clearance: 1}, "
            "{normal: [0, 1], clearance: 1}]}",
            &options, "2 modes are free");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(energy_stays),
        cmocka_unit_test(every_impact_is_the_simulators),
        cmocka_unit_test(random_structures_too),
        cmocka_unit_test(stored_orbits_return),
        cmocka_unit_test(integrable_motions_have_no_exponent),
        cmocka_unit_test(errors_cover),
        cmocka_unit_test(starts_fill_the_section),
        cmocka_unit_test(workers_change_nothing),
        cmocka_unit_test(a_stop_keeps_what_was_done),
        cmocka_unit_test(nonsense_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
