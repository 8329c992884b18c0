/* The verification of atlas points: what is right passes, what is a little wrong does not. */
#include "simulated_models.h"

#include "explored.h"
#include "sample.h"
#include "check/verify_pairs.h"

/* An atlas of one branch with the points given: `states` [n_point * 4], `flights` [n_point * max(impacts, 1)]. */
typedef struct {
    ric_atlas atlas;
    ric_branch_record record;
} one_branch;

static void make_atlas(one_branch *a, int impacts, const int *word, int n_point, const double *states,
                       const double *flights)
{
    static const char text[] = "model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  contacts:\n"
                               "    - {normal: [-1, 1], clearance: 1, sides: both, law: rigid}\n";
    size_t n_flight = impacts ? (size_t)impacts : 1, stride = ric_atlas_point_stride(2, impacts);
    memset(a, 0, sizeof *a);
    if (ric_study_parse(text, "text", ".", &a->atlas.study)) fail_msg("%s", ric_detail());
    a->record.stride = stride;
    a->record.word = malloc(n_flight * sizeof *word);
    a->record.points = calloc((size_t)n_point * stride, sizeof(double));
    if (impacts) memcpy(a->record.word, word, n_flight * sizeof *word);
    a->record.row = (ric_branch){.id = 1,
                                 .label = "",
                                 .impacts = impacts,
                                 .letters = impacts,
                                 .word = a->record.word,
                                 .n_point = n_point};
    for (int i = 0; i < n_point; i++) {
        double *at = a->record.points + (size_t)i * stride;
        const double *state = states + 4 * i;
        ric_point point = {.energy = ric_model_energy(ric_study_model(a->atlas.study), state, state + 2)};
        memcpy(at, &point, sizeof point);
        memcpy(at + sizeof point / sizeof *at, state, 4 * sizeof *at);
        memcpy(at + sizeof point / sizeof *at + 4, flights + (size_t)i * n_flight, n_flight * sizeof *at);
    }
    a->atlas.n_branch = 1;
    a->atlas.branches = &a->record;
}

static void free_atlas(one_branch *a)
{
    free(a->record.word);
    free(a->record.points);
    ric_study_free(a->atlas.study);
}

static ric_check verify(const one_branch *a, int i)
{
    ric_check check;
    if (ric_verify_point(&a->atlas, 1, i, &check)) fail_msg("%s", ric_detail());
    return check;
}

static void expect(const one_branch *a, int i, bool passed)
{
    ric_check c = verify(a, i);
    if (c.passed == passed) return;
    fail_msg("point %d: flight %.3g, return %.3g, condition %.3g, energy %.3g, faces %d", i, c.flight_error,
             c.return_error, c.condition, c.energy_error, c.faces_agree);
}

/* What is right passes; a state, a time, a face or an energy that is a little wrong does not. */
static void verify_s2(void **state)
{
    (void)state;
    enum { POINTS = 40 };
    double states[4 * POINTS], flights[2 * POINTS];
    ric_model *model = make_two();
    modal m = make_modal(model);
    int n_point = 0, word[] = {0, 1}, wrong[] = {0, 0};
    one_branch a;
    for (int i = 0; i < POINTS; i++) {
        double h = PI / (i < POINTS / 2 ? 0.95 + 0.035 * i : 2.2 + 0.3 * (i - 20));
        if (!s2_orbit(&m, h, states + 4 * n_point, states + 4 * n_point + 2)) continue;
        flights[2 * n_point] = flights[2 * n_point + 1] = h;
        n_point++;
    }
    assert_true(n_point > 30);
    make_atlas(&a, 2, word, n_point, states, flights);
    for (int i = 0; i < n_point; i++) {
        ric_check check = verify(&a, i);
        double *at = a.record.points + (size_t)i * a.record.stride, *x = at + sizeof(ric_point) / sizeof *at,
               *tau = x + 4, kept;
        expect(&a, i, true);
        assert_true(check.flight_error < 1e-12 && check.energy_error < 1e-13);
        kept = x[1], x[1] += 1e-9, expect(&a, i, false), x[1] = kept;
        kept = x[2], x[2] *= 1 + 1e-9, expect(&a, i, false), x[2] = kept;
        kept = tau[1], tau[1] *= 1 + 1e-10, expect(&a, i, false), tau[1] = kept;
        ((ric_point *)(void *)at)->energy *= 1 + 1e-10, expect(&a, i, false);
    }
    free_atlas(&a);
    make_atlas(&a, 2, wrong, n_point, states, flights);
    for (int i = 0; i < n_point; i++) expect(&a, i, false);
    free_atlas(&a);
    ric_model_free(model);
}

/* The orbit of a junction closes, has its energy, and is a motion: none that goes through a stop on its way. */
static void verify_junctions(void **state)
{
    (void)state;
    ric_model *model = make_two();
    modal m = make_modal(model);
    int word[] = {0, 1}, count[2] = {0, 0};
    for (int i = 0; i < 300; i++) {
        double x[4], h = PI / (0.3 + 0.0131 * i), flights[] = {h, h};
        ric_junction_record junction = {.state = x, .flights = flights, .word = word};
        one_branch a;
        ric_claims claims;
        bool through;
        if (!s2_motion(&m, h, x, x + 2, &through)) continue;
        make_atlas(&a, 2, word, 1, x, flights);
        junction.row = (ric_junction){.id = 1,
                                      .kind = RIC_KIND_USER,
                                      .word = word,
                                      .letters = 2,
                                      .impacts = 2,
                                      .multiple = 1,
                                      .energy = ric_model_energy(model, x, x + 2),
                                      .frequency = PI / h,
                                      .state = x,
                                      .flights = flights};
        a.atlas.n_junction = 1;
        a.atlas.junctions = &junction;
        assert_int_equal(ric_verify_junction(&a.atlas, 1, &claims), RIC_OK);
        if (through != (claims.numbers == RIC_AGREES_NO)) fail_msg("omega %.6g: %s", PI / h, claims.finding);
        if (through) assert_non_null(strstr(claims.finding, "the stored motion"));
        count[through]++;
        free_atlas(&a);
    }
    assert_true(count[0] > 10 && count[1] > 5);
    ric_model_free(model);
}

/* A stored orbit closes within its digits: what they leave is far less than what the replay of a flight may lose. */
static void verify_digits(void **state)
{
    (void)state;
    ric_model *model = make_two();
    modal m = make_modal(model);
    const double h = PI / 0.95;
    double x[4], flights[] = {h, h};
    int word[] = {0, 1};
    one_branch a;
    ric_claims claims;
    assert_true(s2_orbit(&m, h, x, x + 2));
    make_atlas(&a, 2, word, 1, x, flights);
    assert_int_equal(ric_verify_claims(&a.atlas, 1, 0, &claims), RIC_OK);
    assert_null(strstr(claims.finding, "is open"));
    assert_string_equal(claims.unchecked, "");
    for (int j = 0; j < 2; j++) {
        double *stored = a.record.points + sizeof(ric_point) / sizeof(double) + j, kept = *stored;
        *stored += 3e-13;
        expect(&a, 0, true);
        assert_int_equal(ric_verify_claims(&a.atlas, 1, 0, &claims), RIC_OK);
        assert_int_equal(claims.numbers, RIC_AGREES_NO);
        assert_non_null(strstr(claims.finding, "is open"));
        *stored = kept;
    }
    free_atlas(&a);
    ric_model_free(model);
}

/* Near the grazing all speeds are as small as what rounding leaves of them, and it is said which. */
static void verify_names_what_is_unchecked(void **state)
{
    (void)state;
    ric_atlas *atlas = explore_text("model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  contacts:\n"
                                    "    - {normal: [-1, 1], clearance: 1, sides: both, law: rigid}\n"
                                    "explore: {energy: [0, 20], frequency: [0.2, 10], impacts: 2, multiply: 1, depth: "
                                    "1}\n");
    int named = 0, whole = 0;
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        const ric_branch b = branch_of(atlas, id);
        for (int i = 0; i < b.n_point && b.impacts; i++) {
            ric_claims claims;
            double x[4], flights[2];
            ric_point p;
            assert_int_equal(ric_atlas_point(atlas, id, i, &p, x, flights), RIC_OK);
            assert_int_equal(ric_verify_claims(atlas, id, i, &claims), RIC_OK);
            assert_int_not_equal(claims.numbers, RIC_AGREES_NO);
            const double speed = fmax(fabs(x[2]), fabs(x[3])) / sqrt(2 * p.energy);
            if (speed < 1e-10) named += strstr(claims.unchecked, "v1, v2") && claims.numbers == RIC_AGREES_UNCHECKED;
            if (speed > 1e-4) assert_string_equal(claims.unchecked, "");
            whole += speed > 1e-4;
        }
    }
    assert_true(named > 0 && whole > 20);
    ric_atlas_free(atlas);
}

/* The multiplier against the growth of a small error from one period to the next, on unstable pieces of S2+. */
static void verify_condition(void **state)
{
    (void)state;
    double x[4], flights[2];
    ric_model *model = make_two();
    modal m = make_modal(model);
    int word[] = {0, 1};
    one_branch a;
    for (int i = 0; i < 2; i++) {
        double omega = i ? 0.95 : 1.5; /* before the extremum at 0.96156, behind the branch point at 1.382 */
        flights[0] = flights[1] = PI / omega;
        assert_true(s2_orbit(&m, PI / omega, x, x + 2));
        make_atlas(&a, 2, word, 1, x, flights);
        ric_check check = verify(&a, 0);
        ric_simulator *sim = simulator(model);
        double y[2][4], moved = 0, before = 0;
        x[2] *= 1 + 1e-10;
        x[3] *= 1 + 1e-10;
        start(sim, x, x + 2);
        memcpy(y[0], x, sizeof x);
        for (int k = 1; moved < 1e-5 && k < 40; k++) {
            assert_true(advance(sim, 1e9, NULL) && advance(sim, 1e9, NULL));
            ric_simulator_state(sim, NULL, y[k % 2], y[k % 2] + 2);
            before = moved;
            moved = distance(4, y[0], y[1]);
        }
        check_close(check.condition, moved / before, 1e-3, "multiplier");
        ric_simulator_free(sim);
        free_atlas(&a);
    }
    ric_model_free(model);
}

/* S0 up to the energy at which it touches, where either no impact or one without speed is right; beyond, it is
 * wrong. */
static void verify_linear(void **state)
{
    (void)state;
    double states[4 * 8], flights[8];
    ric_model *model = make_two();
    modal m = make_modal(model);
    one_branch a;
    for (int mode = 0; mode < 2; mode++) {
        for (int i = 0; i < 8; i++) {
            double A = (double[]){0, 1e-3, 0.5, 0.9, 0.999999, 1, 1, 1.0001}[i] / fabs(m.c[mode]), q[2] = {0},
                   p[2] = {0};
            q[mode] = i == 6 ? 0 : A;
            p[mode] = i == 6 ? A * m.omega[mode] : 0;
            to_space(&m, q, states + 4 * i);
            to_space(&m, p, states + 4 * i + 2);
            flights[i] = 2 * PI / m.omega[mode];
        }
        make_atlas(&a, 0, NULL, 8, states, flights);
        for (int i = 0; i < 8; i++) expect(&a, i, i < 7);
        free_atlas(&a);
    }
    ric_model_free(model);
}

/* S2+ ends at G1_2,4, where each flight touches both faces: with the touches left out, as impacts, and some of them. */
static void verify_touches(void **state)
{
    (void)state;
    double omega = 1.6667902994358654, h = PI / omega, x[4], q[2], p[2], touch_time[2], qt[2], pt[2];
    int n_touch = 0, face[2];
    ric_model *model = make_two();
    modal m = make_modal(model);
    double sum = 0;
    for (int i = 0; i < 2; i++) sum += m.c[i] * m.c[i] * tan(m.omega[i] * h / 2) / m.omega[i];
    for (int i = 0; i < 2; i++) {
        q[i] = m.c[i] * tan(m.omega[i] * h / 2) / (m.omega[i] * sum);
        p[i] = -m.c[i] / sum;
    }
    to_space(&m, q, x);
    to_space(&m, p, x + 2);
    for (double t = 1e-3; t < h - 1e-3; t += 1e-3) { /* stationary gaps of the flight */
        double lo = t, hi = t + 1e-3, ds[2];
        for (int i = 0; i < 60; i++) {
            double at[] = {lo, (lo + hi) / 2};
            for (int k = 0; k < 2; k++) {
                modal_flight(&m, at[k], q, p, qt, pt);
                ds[k] = m.c[0] * pt[0] + m.c[1] * pt[1];
            }
            if (i == 0) {
                double end = hi;
                modal_flight(&m, end, q, p, qt, pt);
                if (ds[0] * (m.c[0] * pt[0] + m.c[1] * pt[1]) > 0) break;
            }
            if (ds[0] * ds[1] > 0) lo = at[1];
            else hi = at[1];
        }
        if (hi - lo > 1e-9) continue;
        double s = modal_gap(&m, 0, lo, q, p);
        assert_true(fabs(fabs(s) - 1) < 1e-9);
        assert_true(n_touch < 2);
        face[n_touch] = s < 0;
        touch_time[n_touch++] = lo;
    }
    assert_int_equal(n_touch, 2);
    for (int kept = 0; kept < 16; kept++) { /* which of the four touches of a period are letters of the word */
        int word[8] = {0}, n = 0;
        double flights[8], last = 0;
        for (int half = 0; half < 2; half++) {
            word[n++] = half;
            for (int k = 0; k < 2; k++) {
                if (!(kept >> (2 * half + k) & 1)) continue;
                double t = half * h + touch_time[k];
                flights[n - 1] = t - last;
                last = t;
                word[n++] = half ? 1 - face[k] : face[k];
            }
            flights[n - 1] = (half + 1) * h - last;
            last = (half + 1) * h;
        }
        one_branch a;
        make_atlas(&a, n, word, 1, x, flights);
        expect(&a, 0, true);
        free_atlas(&a);
    }
    ric_model_free(model);
}

/* Where A9[001010101] and A10[0101010101] end, an impact has 1e-7 of the largest speed and the multipliers are 1e15 and
 * 1e25: the orbit cannot be polished, and the time of that impact is uncertain by the rounding of the gap over its
 * speed, 1e-9. */
static void verify_slowest_impact(void **state)
{
    (void)state;
    ric_atlas *atlas = explore_text("model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  contacts:\n"
                                    "    - {normal: [-1, 1], clearance: 1, sides: both, law: rigid}\n"
                                    "explore: {start: [2], energy: [1.8, 3], frequency: [0.35, 2.2], impacts: 10, "
                                    "multiply: 6, base: 6, depth: 2}\n");
    double slowest = 1, largest = 1;
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        ric_branch b = branch_of(atlas, id);
        for (int i = 0; i < b.n_point && b.impacts >= 9; i++) {
            ric_check c;
            ric_point p;
            assert_int_equal(ric_verify_point(atlas, id, i, &c), RIC_OK);
            assert_int_equal(ric_atlas_point(atlas, id, i, &p, NULL, NULL), RIC_OK);
            if (!c.passed)
                fail_msg("%s, point %d: flight %.3g, return %.3g, condition %.3g", b.label, i, c.flight_error,
                         c.return_error, c.condition);
            if (p.approach > 1e-9) slowest = fmin(slowest, p.approach);
            largest = fmax(largest, c.condition);
        }
    }
    assert_true(slowest < 1e-6 && largest > 1e20);
    ric_atlas_free(atlas);
}

/* Impacts as slow as 1e-7 of the largest speed, beside the grazing of S6[010101] and of A5[00101], are not checked less
 * for that. */
static void verify_slow_impacts(void **state)
{
    (void)state;
    ric_atlas *atlas = explore_text("model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  contacts:\n"
                                    "    - {normal: [-1, 1], clearance: 1, sides: both, law: rigid}\n"
                                    "explore: {energy: [0, 200], frequency: [0.2, 10], impacts: 6, multiply: 1, depth: "
                                    "2}\n");
    int checked = 0;
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        ric_branch b = branch_of(atlas, id);
        if (strcmp(b.label, "S6[010101]") && strcmp(b.label, "A5[00101]")) continue;
        for (int k = 0; k < 40; k++) {
            double below = b.energy_max * pow(10, -4 - 0.2 * k);
            ric_orbit **orbits = NULL;
            int n = 0;
            if (ric_orbit_find(atlas, id, RIC_AT_ENERGY, b.energy_max - below, &n, &orbits)) continue;
            for (int i = 0; i < n; i++) {
                ric_point point;
                double x[4], flights[8];
                int word[8];
                one_branch a;
                ric_orbit_data(orbits[i], &point, x, flights, word);
                if (!(point.approach > 1e-7 && point.approach < 1e-4)) continue;
                make_atlas(&a, b.impacts, word, 1, x, flights);
                expect(&a, 0, true);
                assert_true(verify(&a, 0).flight_error < 1e-12);
                free_atlas(&a);
                for (int j = 0; j < 4; j++) { /* a state that is off by 1e-9 is found out all the same */
                    double y[4];
                    memcpy(y, x, sizeof y);
                    y[j] += 1e-9 * (1 + fabs(y[j]));
                    make_atlas(&a, b.impacts, word, 1, y, flights);
                    expect(&a, 0, false);
                    free_atlas(&a);
                }
                checked++;
            }
            ric_orbits_free(n, orbits);
        }
    }
    assert_true(checked > 10);
    ric_atlas_free(atlas);
}

#define LEAST 500 /* points of an atlas below which its ends are not what is tried */

static void every_point_passes(const char *model, const char *options)
{
    char text[1024];
    snprintf(text, sizeof text, "title: ends\nmodel:\n%sexplore: {impacts: 6, multiply: 3, depth: 2, %s}\n", model,
             options);
    ric_atlas *atlas = explore_text(text);
    int checked = 0;
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        const ric_branch b = branch_of(atlas, id);
        for (int i = 0; i < b.n_point; i += i == 0 || i + 1 + every() >= b.n_point ? 1 : every()) {
            point_passes(atlas, id, i);
            checked++;
        }
    }
    if (every() == 1 && checked <= LEAST) fail_msg("only %d points were checked", checked);
    ric_atlas_free(atlas);
}

/* Branches along which the period all but stays, between grazings and corners: some orbits stand only as they are
 * stored, as polishing leads past the end, others only polished, as their last digits are lost within a period. */
static void verify_at_ends(void **state)
{
    (void)state;
    every_point_passes("  mass: [[1.22, 0, 0], [0, 2.41, 0], [0, 0, 2.9]]\n"
                       "  stiffness: [[6.87, -4.34, 0], [-4.34, 5.37, -1.03], [0, -1.03, 4.82]]\n"
                       "  contacts:\n"
                       "    - {normal: [0, -1, 0], clearance: 0.59, sides: both, law: rigid}\n"
                       "    - {normal: [-1, 1, 0], clearance: 0.74, sides: both, law: rigid}\n",
                       "energy: [0, 16.4], frequency: [0.2, 8]");
}

/* A6[112112] ends where it touches, with multipliers of 1e7 to 1e10: what rounding grows to within a period strikes
 * there with 1e-5 of the largest speed. */
static void verify_steep_grazing(void **state)
{
    (void)state;
    every_point_passes("  mass: [[2.36, 0, 0, 0], [0, 2.62, 0, 0], [0, 0, 2.17, 0], [0, 0, 0, 1.27]]\n"
                       "  stiffness: [[6.43, -3.3, 0, 0], [-3.3, 5.2, -1.9, 0], [0, -1.9, 6.61, -4.71],"
                       " [0, 0, -4.71, 4.71]]\n"
                       "  contacts:\n"
                       "    - {normal: [0, -1, 0, 0], clearance: 0.72, sides: upper, law: bilinear,"
                       " stiffness: 358.35}\n"
                       "    - {normal: [0, 0, 0, -1], clearance: 1.68, sides: both, law: rigid}\n",
                       "energy: [0, 50.5], frequency: [0.2, 8]");
}

static void all_of_it_passes(const char *text)
{
    ric_atlas *atlas = explore_text(text);
    int events = 0;
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        const ric_branch b = branch_of(atlas, id);
        for (int i = 0; i < b.n_point; i++) {
            ric_claims claims;
            point_passes(atlas, id, i);
            assert_int_equal(ric_verify_claims(atlas, id, i, &claims), RIC_OK);
            if (claims.numbers == RIC_AGREES_NO || claims.multipliers == RIC_AGREES_NO)
                fail_msg("branch %d, point %d: %s", id, i, claims.finding);
            events += b.letters;
        }
    }
    assert_true(events > 200);
    for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
        ric_claims claims;
        assert_int_equal(ric_verify_junction(atlas, id, &claims), RIC_OK);
        if (claims.numbers == RIC_AGREES_NO) fail_msg("junction %d: %s", id, claims.finding);
    }
    ric_atlas_free(atlas);
}

/* Whether a face is touched or struck is a question of how far the motion would go beyond it, not of the speed: of
 * 60 times the clearance an impact at 3e-7 of the largest speed may be made; a face that is passed by 3e-12 of the
 * clearance is struck with 4e-6 of it; and a contact of a stiff spring that is met with 2e-8 of it lies below the last
 * digit of the gap. */
static void verify_shallow_impacts(void **state)
{
    (void)state;
    all_of_it_passes("model:\n  mass: [[1.25, 0], [0, 1]]\n"
                     "  stiffness: [[2562500, -812500], [-812500, 2187500]]\n  contacts:\n"
                     "    - {normal: [-1, 1], law: rigid, clearance: 0.00116, sides: both}\n"
                     "explore: {energy: [0, 2.185e10], frequency: [235.7, 5063], impacts: 6, multiply: 1, depth: 2}\n");
    all_of_it_passes(
        "model:\n  mass: [[1.40625, -0.25], [-0.25, 2.25]]\n"
        "  stiffness: [[1.9763332017090633, 1.4548481392091854], [1.4548481392091854, 7.348365265689234]]\n"
        "  contacts:\n"
        "    - {normal: [-1, 1], law: bilinear, clearance: 0.00141, sides: upper, stiffness: 42.49}\n"
        "    - {normal: [1, 0], law: rigid, clearance: 0.000904, sides: lower}\n"
        "explore: {energy: [0, 9.87], frequency: [0.2, 6], impacts: 6, multiply: 2, depth: 2}\n");
    all_of_it_passes("model:\n  mass: [[2.140625, -0.09375], [-0.09375, 1.953125]]\n"
                     "  stiffness: [[1825327.74092266, 494201.8441353565], [494201.8441353565, 682608.8700128634]]\n"
                     "  contacts:\n"
                     "    - {normal: [0, 1], clearance: 0.756, sides: lower, law: bilinear, stiffness: 8.325e11}\n"
                     "explore: {energy: [0, 9621000], frequency: [98.87, 2974], impacts: 4, multiply: 1, depth: 2}\n");
}

/* Three modes at 1 : 2 : 3 to 1e-7: of the orbits where A3[001] ends one impact has 5e-10 of the largest speed, which
 * is no touch: without it the motion goes through the other side by 2e-5. */
static void verify_resonant(void **state)
{
    (void)state;
    all_of_it_passes("model:\n  mass: [[2.5625, 0, 0.03125], [0, 1.953125, -0.203125], [0.03125, -0.203125, 2.09375]]\n"
                     "  stiffness:\n    - [9.995628779361583, 3.8195457198769938, 1.0700935208889597]\n"
                     "    - [3.8195457198769938, 6.771393160704887, 5.74628751175851]\n"
                     "    - [1.0700935208889597, 5.74628751175851, 12.509612866202811]\n"
                     "  contacts:\n    - {normal: [1, 0, 0], law: rigid, clearance: 12.6, sides: both}\n"
                     "explore: {energy: [0, 517.5], frequency: [0.2, 9], impacts: 8, multiply: 3, depth: 1}\n");
}

/* The like, a grazing of the first mode: all impacts of a branch are slower than 1e-7 where three modes would move
 * together, whose frequencies fit to 1e-7: without any impact they do not come back. */
static void verify_no_common_period(void **state)
{
    (void)state;
    all_of_it_passes(
        "model:\n  mass: [[2.5625, -0.3125, 0.0625], [-0.3125, 1.203125, -0.109375], [0.0625, -0.109375, 2.328125]]\n"
        "  stiffness:\n    - [8.51320790390474, -4.91646225827111, -0.8439594397310752]\n"
        "    - [-4.91646225827111, 5.937499517059691, 4.306471640095689]\n"
        "    - [-0.8439594397310752, 4.306471640095689, 14.235352044252904]\n"
        "  contacts:\n    - {normal: [2, 1, -2], law: rigid, clearance: 16.9, sides: both}\n"
        "explore: {energy: [0, 43.85], frequency: [0.2, 9], impacts: 6, multiply: 1, depth: 2}\n");
}

/* A stiff spring is touched by an orbit at the end of its branch: what the last digit makes a contact of turns the
 * speed of that touch round, and is none. */
static void verify_touch_of_stiff_spring(void **state)
{
    (void)state;
    all_of_it_passes(
        "model:\n  mass:\n    - [2.09375, 0.046875, 0.140625, 0.609375, -0.265625]\n"
        "    - [0.046875, 1.46875, 0.109375, 0.21875, -0.171875]\n"
        "    - [0.140625, 0.109375, 2.421875, 0.3125, -0.3125]\n"
        "    - [0.609375, 0.21875, 0.3125, 1.796875, -0.453125]\n"
        "    - [-0.265625, -0.171875, -0.3125, -0.453125, 1.65625]\n"
        "  stiffness:\n    - [1781250, 265625, -125000, -281250, -1421875]\n"
        "    - [265625, 2906250, 515625, -1906250, -1171875]\n    - [-125000, 515625, 1375000, 62500, -671875]\n"
        "    - [-281250, -1906250, 62500, 2234375, 578125]\n    - [-1421875, -1171875, -671875, 578125, 3203125]\n"
        "  contacts:\n    - {normal: [0, -1, 1, 0, 0], law: bilinear, clearance: 0.525, sides: both, stiffness: "
        "4797000}\n"
        "    - {normal: [0, -1, 1, -2, -1], law: bilinear, clearance: 0.712, sides: upper, stiffness: 1.092e12}\n"
        "explore: {energy: [0, 860000], frequency: [101.6, 6326], impacts: 4, multiply: 1, depth: 1}\n");
}

/* Two modes at 1 : 2 to the last digit: a branch ends in five times the faster mode, where all its impacts end at once
 * and are located to 5e-8. Some of them kept, and the others not, it is an orbit that passes the stop by 1e-7. */
static void verify_all_impacts_at_once(void **state)
{
    (void)state;
    all_of_it_passes(
        "model:\n  mass: [[1.28125, 0.09375], [0.09375, 0.53125]]\n"
        "  stiffness: [[4.980030461093401, 0.8328584103509669], [0.8328584103509669, 0.6789422591101952]]\n"
        "  contacts:\n    - {normal: [1, -1], law: rigid, clearance: 5.57, sides: both}\n"
        "explore: {energy: [0, 22.72], frequency: [0.2, 6], impacts: 8, multiply: 3, depth: 2}\n");
}

/* The contact of a stiff spring at 1e-9 of the largest speed: an arc of 2e-13 of the clearance within it is its reach,
 * and a contact of 7e-7 s counts beside others of 1e-5 s. */
static void verify_stiff_contacts(void **state)
{
    (void)state;
    all_of_it_passes(
        "model:\n  mass: [[1.15625, -0.09375, 0.203125], [-0.09375, 0.671875, -0.203125],"
        " [0.203125, -0.203125, 1.453125]]\n"
        "  stiffness:\n    - [6.987624379755634, -0.1015896859693963, 5.533092387611552]\n"
        "    - [-0.1015896859693963, 2.127245000496372, -2.1871689663021616]\n"
        "    - [5.533092387611552, -2.1871689663021616, 9.010078854438762]\n"
        "  contacts:\n    - {normal: [1, 0, -1], law: bilinear, clearance: 1.03, sides: both, stiffness: 4796000}\n"
        "explore: {energy: [0, 6897], frequency: [0.2, 9], impacts: 4, multiply: 2, depth: 2}\n");
}

/* Two stops at 0.001 of the clearance of a spring are struck within its contact, at 1e-6 of the largest speed and less:
 * the gap that rounding leaves decides when, and a touch there is none of the spring, which is closed. */
static void verify_stop_in_contact(void **state)
{
    (void)state;
    all_of_it_passes("model:\n  mass: [[1, 0], [0, 1]]\n  stiffness: [[3, 0], [0, 2]]\n  contacts:\n"
                     "    - {normal: [-1, 1], law: bilinear, clearance: 1.95, sides: upper, stiffness: 0.00961}\n"
                     "    - {normal: [1, 0], law: rigid, clearance: 0.00195, sides: both}\n"
                     "explore: {energy: [0, 3.6], frequency: [0.2828, 5.196], impacts: 6, multiply: 2, depth: 2}\n");
    all_of_it_passes("model:\n  mass: [[1.65625, 0, 0.015625], [0, 1.75, 0.25], [0.015625, 0.25, 2.09375]]\n"
                     "  stiffness:\n    - [3.599822387610638, -1.8741535836856285, 1.6698304145949863]\n"
                     "    - [-1.8741535836856285, 12.515806897797164, 7.088524755302034]\n"
                     "    - [1.6698304145949863, 7.088524755302034, 11.44561937117028]\n"
                     "  contacts:\n"
                     "    - {normal: [0, 1, 0], law: bilinear, clearance: 0.888, sides: both, stiffness: 33400}\n"
                     "    - {normal: [1, 0, -1], law: rigid, clearance: 0.000888, sides: lower}\n"
                     "explore: {energy: [0, 16.57], frequency: [0.2001, 9], impacts: 4, multiply: 2, depth: 2}\n");
}

/* A stop that is struck while a spring of 1e5 times the stiffness is closed: brought back to it by the last digit, the
 * start of the next flight has the energy and the motion that the spring gives it. */
static void verify_stop_and_stiff_spring(void **state)
{
    (void)state;
    all_of_it_passes("model:\n  mass: [[1.75, 0.1875], [0.1875, 1.65625]]\n"
                     "  stiffness: [[578125, 453125], [453125, 1015625]]\n  contacts:\n"
                     "    - {normal: [-1, 1], law: bilinear, clearance: 0.00133, sides: both, stiffness: 8.342e10}\n"
                     "    - {normal: [1, 0], law: rigid, clearance: 0.00133, sides: both}\n"
                     "explore: {energy: [0, 638600], frequency: [86.85, 2523], impacts: 6, multiply: 1, depth: 2}\n");
}

/* A stop and a stiff spring, met one after the other: what the last digit of a gap would make the spring push that has
 * just closed is no part of the flow, along which nothing is multiplied. */
static void verify_flow_at_closing(void **state)
{
    (void)state;
    all_of_it_passes("model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9.5, -5.5], [-5.5, 8.5]]\n  contacts:\n"
                     "    - {normal: [1, 0], law: bilinear, clearance: 10, sides: upper, stiffness: 844100}\n"
                     "    - {normal: [1, -1], law: rigid, clearance: 6.06, sides: both}\n"
                     "explore: {energy: [0, 11.89], frequency: [0.3038, 9.924], impacts: 4, multiply: 2, depth: 2}\n");
    all_of_it_passes("model:\n  mass: [[0.640625, -0.046875], [-0.046875, 0.578125]]\n"
                     "  stiffness: [[5.75, -4.25], [-4.25, 5]]\n  contacts:\n"
                     "    - {normal: [-1, 1], law: rigid, clearance: 1.54, sides: lower}\n"
                     "    - {normal: [1, 0], law: bilinear, clearance: 1.542, sides: upper, stiffness: 4126000}\n"
                     "explore: {energy: [0, 54.87], frequency: [0.2814, 11.49], impacts: 4, multiply: 3, depth: 1}\n");
}

/* Of two masses on one spring, which is not stretched when the one strikes, the other comes to rest at that instant and
 * is not pushed: its largest displacement lies in neither flight. */
static void verify_reach_without_push(void **state)
{
    (void)state;
    all_of_it_passes("model:\n  mass: [[2, 0], [0, 1.5]]\n  stiffness: [[4.25, -4.25], [-4.25, 4.25]]\n  contacts:\n"
                     "    - {normal: [0, 1], law: rigid, clearance: 1.7, sides: both}\n"
                     "    - {normal: [1, 0], law: rigid, clearance: 1.12, sides: both}\n"
                     "explore: {energy: [0, 29.25], frequency: [0.4453, 6.68], impacts: 2, multiply: 3, depth: 2}\n");
}

/* A4[0101] ends in the double of an orbit that is its image backwards about any of its impacts: stored within 6e-11 of
 * it, the end keeps the mirror points of its branch, or its multipliers are those of another orbit. */
static void multipliers_at_ends(void **state)
{
    (void)state;
    ric_atlas *atlas = explore_text(
        "model:\n  mass: [[1.796875, -0.265625, -0.0625], [-0.265625, 1.015625, 0.0625], [-0.0625, 0.0625, 1.75]]\n"
        "  stiffness: [[5.5625, -0.1875, -3.8125], [-0.1875, 5.625, -2.1875], [-3.8125, -2.1875, 5.3125]]\n"
        "  contacts:\n    - {normal: [0, 1, 0], law: rigid, clearance: 0.715, sides: both}\n"
        "    - {normal: [-1, 1, 0], law: rigid, clearance: 0.715, sides: upper}\n"
        "explore: {energy: [0, 14.34], frequency: [0.1582, 8.301], impacts: 8, multiply: 2, depth: 2}\n");
    int ends = 0;
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        const ric_branch b = branch_of(atlas, id);
        for (int i = 0; i < b.n_point && b.impacts > 0; i += b.n_point > 1 ? b.n_point - 1 : 1, ends++) {
            ric_claims claims;
            assert_int_equal(ric_verify_claims(atlas, id, i, &claims), RIC_OK);
            if (claims.multipliers == RIC_AGREES_NO) fail_msg("branch %d, point %d: %s", id, i, claims.finding);
        }
    }
    assert_true(ends > 60);
    ric_atlas_free(atlas);
}

/* A3[111] starts where a contact opens and closes at once, for 2e-12 s: what rounding makes of the gap between is no
 * maximum of it. The branch has one reach from its first point on. */
static void reach_between_contacts(void **state)
{
    (void)state;
    ric_atlas *atlas = explore_text(
        "model:\n  mass: [[2, -0.3125, -0.375], [-0.3125, 1.015625, 0.15625], [-0.375, 0.15625, 1.9375]]\n"
        "  stiffness:\n    - [6.243641055741324, -0.20542101546692437, -7.8122056404079885]\n"
        "    - [-0.20542101546692437, 3.813242405880784, 1.0216259390567397]\n"
        "    - [-7.8122056404079885, 1.0216259390567397, 15.368349510211212]\n"
        "  contacts:\n    - {normal: [0, 1, 0], law: bilinear, clearance: 0.00106, sides: upper, stiffness: 24.31}\n"
        "    - {normal: [0, 0, 1], law: bilinear, clearance: 1.06e-6, sides: lower, stiffness: 0.009572}\n"
        "explore: {energy: [0, 0.0003816], frequency: [0.2, 9], impacts: 8, multiply: 3, depth: 2}\n");
    int found = 0;
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        ric_point first, second;
        if (branch_of(atlas, id).impacts != 3) continue;
        found++;
        assert_int_equal(ric_atlas_point(atlas, id, 0, &first, NULL, NULL), RIC_OK);
        assert_int_equal(ric_atlas_point(atlas, id, 1, &second, NULL, NULL), RIC_OK);
        if (fabs(first.reach - second.reach) > 1e-5)
            fail_msg("branch %d: %.9g, then %.9g", id, first.reach, second.reach);
    }
    assert_int_equal(found, 2);
    ric_atlas_free(atlas);
}

/* Ends where a stop and a spring are met at one instant: with orthogonal normals their order says nothing, with others
 * the spring may be missed behind the stop. */
static void verify_stop_and_spring(void **state)
{
    (void)state;
    every_point_passes("  mass: [[1.95, 0, 0], [0, 1.64, 0], [0, 0, 2.11]]\n"
                       "  stiffness: [[6.2, -3.1, 0], [-3.1, 4.46, -1.36], [0, -1.36, 1.36]]\n"
                       "  contacts:\n"
                       "    - {normal: [-1, 0, 0], clearance: 1.08, sides: both, law: bilinear, stiffness: 16.63}\n"
                       "    - {normal: [0, -1, 1], clearance: 1.69, sides: both, law: rigid}\n",
                       "energy: [0, 25.1], frequency: [0.2, 8]");
    every_point_passes("  mass: [[1.59, 0, 0], [0, 1.99, 0], [0, 0, 1.1]]\n"
                       "  stiffness: [[3.22, -3.22, 0], [-3.22, 4.08, -0.86], [0, -0.86, 1.52]]\n"
                       "  contacts:\n"
                       "    - {normal: [0, -1, 1], clearance: 1.74, sides: both, law: bilinear, stiffness: 71.71}\n"
                       "    - {normal: [-1, 1, 0], clearance: 1.67, sides: both, law: rigid}\n",
                       "energy: [0, 12.1], frequency: [0.2, 8]");
}

/* What runs with these pairs say of a stored rotation, where the trace agrees. */
static ric_claims judged(const double rho[RIC_PAIR_RUNS], double rotation)
{
    ric_pair own[RIC_PAIR_RUNS];
    ric_pairs pairs = {.n_pair = 1, .way = {-1, -1, -1, -1, -1}, .own = own};
    ric_claims claims = {.multipliers = RIC_AGREES_UNCHECKED};
    for (int run = 0; run < RIC_PAIR_RUNS; run++) own[run] = rho[run];
    ric_verify_pairs_judge(&pairs, 2,
                           &(ric_point){.trace = asinh(rho[0] / 2),
                                        .rotation = rotation,
                                        .stable = RIC_STABLE_UNDECIDED},
                           &claims);
    return claims;
}

/* A pair at 1 that rounding takes off the circle in one run still has the angle of the others; where the exact run is
 * off it, an angle as small as that is right, and a large one is wrong. */
static void verify_rotations(void **state)
{
    (void)state;
    const double one[] = {2 - 7e-11, 2 - 6e-11, 2 + 1e-11, 2 - 5e-11, 2 - 7e-11},
                 exact[] = {2 + 1e-12, 2 - 1e-12, 2 + 2e-12, 2 - 1e-12, 2},
                 off[] = {2 + 1e-11, 2 + 2e-11, 2 + 1e-11, 2 + 3e-11, 2 + 1e-11}, lost[] = {1, NAN, 1, 1, 1};
    double angle = 1 - sqrt(7e-11) / RIC_TWO_PI;
    assert_int_equal(judged(one, angle).multipliers, RIC_AGREES_YES);
    assert_int_equal(judged(one, 0.9).multipliers, RIC_AGREES_NO);
    assert_int_equal(judged(one, 0.5).multipliers, RIC_AGREES_NO);
    assert_int_equal(judged(exact, 0.9999999).multipliers, RIC_AGREES_YES);
    assert_int_equal(judged(exact, 0.9).multipliers, RIC_AGREES_NO);
    assert_int_equal(judged(off, sqrt(1e-10) / RIC_TWO_PI).multipliers, RIC_AGREES_YES);
    assert_int_equal(judged(off, 1e-3).multipliers, RIC_AGREES_NO);
    assert_int_equal(judged(lost, 5. / 6).multipliers, RIC_AGREES_UNCHECKED);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(verify_s2),
        cmocka_unit_test(verify_junctions),
        cmocka_unit_test(verify_digits),
        cmocka_unit_test(verify_names_what_is_unchecked),
        cmocka_unit_test(verify_condition),
        cmocka_unit_test(verify_linear),
        cmocka_unit_test(verify_touches),
        cmocka_unit_test(verify_slowest_impact),
        cmocka_unit_test(verify_slow_impacts),
        cmocka_unit_test(verify_at_ends),
        cmocka_unit_test(verify_steep_grazing),
        cmocka_unit_test(verify_shallow_impacts),
        cmocka_unit_test(verify_resonant),
        cmocka_unit_test(verify_no_common_period),
        cmocka_unit_test(verify_touch_of_stiff_spring),
        cmocka_unit_test(verify_all_impacts_at_once),
        cmocka_unit_test(verify_stiff_contacts),
        cmocka_unit_test(verify_stop_in_contact),
        cmocka_unit_test(verify_stop_and_stiff_spring),
        cmocka_unit_test(verify_reach_without_push),
        cmocka_unit_test(verify_flow_at_closing),
        cmocka_unit_test(reach_between_contacts),
        cmocka_unit_test(multipliers_at_ends),
        cmocka_unit_test(verify_stop_and_spring),
        cmocka_unit_test(verify_rotations),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
