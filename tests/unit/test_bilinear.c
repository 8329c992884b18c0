/* Phases of contacts of law bilinear against dense exponentials and energy, and the simulator
 * against phases flown one after the other: the simulator makes modes of its own and shares no code
 * with them. */
#include <float.h>

#include "simulated_models.h"

#include "explored.h"

#include "model/model.h"
#include "orbit/floquet.h"
#include "flow/flight.h"
#include "model/regime.h"
#include "branch/symmetry.h"
#include "check/simulator.h"
#include "sample.h"

/* A flight that starts with no closing. */
static void fly(const ric_regime *phase, double tau, const double *w, double *after)
{
    ric_regime_fly(phase, &(ric_regime_course){.tau = tau, .w = w}, after);
}

static double chord(const ric_regime *phase, int contact, double tau, const double *w, double *by_w,
                    double *by_tau)
{
    return ric_regime_chord(phase, &(ric_regime_course){.tau = tau, .w = w}, contact, by_w, by_tau);
}

enum { MAX_W = 12, MAX_A = (MAX_W + 1) * (MAX_W + 1) };

/* n masses, contacts of which `rigid` are stops; stiffness of the springs up to 1e6 times that of
 * the structure. */
static ric_model *make_soft(unsigned seed, int n, int n_contact, int rigid, double stiffest)
{
    double M[n * n], K[n * n], normals[n_contact * n];
    ric_contact contacts[MAX_CONTACT];
    seed_now = seed;
    random_definite(n, n, 0.5, M);
    random_definite(n, n, 0.3, K);
    for (int i = 0; i < n_contact; i++) {
        for (int j = 0; j < n; j++) normals[i * n + j] = uniform(-1, 1);
        normals[i * n + below(n)] += 1;
        bool soft = i >= rigid;
        contacts[i] = (ric_contact){.normal = normals + i * n,
                                    .clearance = uniform(0.5, 1.5),
                                    .sides = i % 3 == 2 ? RIC_SIDES_UPPER : RIC_SIDES_BOTH,
                                    .law = soft ? RIC_LAW_BILINEAR : RIC_LAW_RIGID,
                                    .stiffness = soft ? pow(10, uniform(0, stiffest)) : 0};
    }
    return make(n, M, K, n_contact, contacts, 1);
}

static void random_coordinates(int size, double *w)
{
    for (int i = 0; i < size; i++) w[i] = uniform(-2, 2);
}

/* The next set of closed faces that contacts allow; 0 at the end. */
static uint64_t next_set(const ric_model *m, uint64_t set)
{
    for (set++; set < (uint64_t)1 << m->n_face; set++)
        if (ric_regime_exists(m, set)) return set;
    return 0;
}

/* A <- exp(A tau) [size * size] by Taylor series over tau / 2^k, squared k times, in extended
 * precision. */
static void exponential(int size, long double tau, long double *A)
{
    long double norm = 0, sum[MAX_A], term[MAX_A], next[MAX_A];
    int k = 0;
    for (int i = 0; i < size * size; i++) norm = fmaxl(norm, fabsl(A[i] * tau) * size);
    for (; norm > 0.5; k++) norm /= 2;
    for (int i = 0; i < size * size; i++) {
        A[i] = ldexpl(A[i] * tau, -k);
        sum[i] = term[i] = i % (size + 1) == 0;
    }
    for (int j = 1; j < 24 + k; j++) {
        bool squares = j >= 24;
        for (int r = 0; r < size; r++)
            for (int c = 0; c < size; c++) {
                long double s = 0;
                for (int i = 0; i < size; i++)
                    s += squares ? sum[r * size + i] * sum[i * size + c]
                                 : A[r * size + i] * term[i * size + c] / j;
                next[r * size + c] = s;
            }
        for (int i = 0; i < size * size; i++) sum[i] = squares ? next[i] : sum[i] + next[i];
        memcpy(term, next, sizeof term);
    }
    memcpy(A, sum, (size_t)(size * size) * sizeof *A);
}

/* d/dt (a, p, 1) = A (a, p, 1). */
static void generator(const ric_model *m, uint64_t set, long double *A)
{
    int n = m->n, size = 2 * n + 1;
    memset(A, 0, (size_t)(size * size) * sizeof *A);
    for (int i = 0; i < n; i++) {
        A[i * size + n + i] = m->kappa[i];
        A[(n + i) * size + i] = -m->stiff[i];
        for (int f = 0; f < m->n_face; f++) {
            const ric_face *face = &m->face[f];
            if (!(set >> f & 1)) continue;
            for (int j = 0; j < n; j++)
                A[(n + i) * size + j] -= (long double)face->spring * face->c[i] * face->g[j];
            A[(n + i) * size + 2 * n] += (long double)face->spring * face->c[i] * face->gap;
        }
    }
}

static double norm_of(int size, const double *x)
{
    return sqrt(ric_dot(size, x, x));
}

/* Flight, its derivative, and coordinates of a phase against the matrix exponential. */
static void flights(void **state)
{
    (void)state;
    for (unsigned seed = 1; seed <= 40; seed += (unsigned)every()) {
        int n = 1 + (int)seed % 5;
        ric_model *m = make_soft(seed, n, 1 + (int)seed % 3, 0, 3);
        for (uint64_t set = 0, done = 0; !done; done = !(set = next_set(m, set))) {
            const ric_regime *phase;
            double w[MAX_W], after[MAX_W], z[MAX_W], back[MAX_W], D[MAX_W * MAX_W],
                tau = uniform(-1.5, 1.5);
            long double A[MAX_A];
            assert_int_equal(ric_regime_get(m, set, &phase), RIC_OK);
            random_coordinates(2 * m->n, w);
            ric_regime_enter(phase, w, z);
            ric_regime_leave(phase, z, back);
            fly(phase, tau, w, after);
            ric_regime_matrix(phase, tau, D);
            generator(m, set, A);
            exponential(2 * m->n + 1, tau, A);
            double fast = 1, size = 1 + norm_of(2 * m->n, w);
            for (int i = 0; i < m->n; i++) fast = fmax(fast, phase->omega[i]);
            for (int i = 0; i < 2 * m->n; i++) {
                long double exact = A[i * (2 * m->n + 1) + 2 * m->n];
                for (int j = 0; j < 2 * m->n; j++) exact += A[i * (2 * m->n + 1) + j] * w[j];
                assert_true(fabs(back[i] - w[i]) <= 1e-13 * size * fast);
                if (!(fabs(after[i] - (double)exact) <= 1e-13 * size * fast))
                    fail_msg("seed %u set %d: off by %g", seed, (int)set, after[i] - (double)exact);
                for (int j = 0; j < 2 * m->n; j++)
                    assert_true(fabs(D[i * 2 * m->n + j] - (double)A[i * (2 * m->n + 1) + j]) <=
                                1e-12 * fast);
            }
        }
        ric_model_free(m);
    }
}

/* Deviations go through the springs of the simulator as they are, however small beside the
 * equilibrium there: 1e-40 of one is 1e-40 of its image to the last digits. */
static void deviations(void **state)
{
    (void)state;
    for (unsigned seed = 1; seed <= 20; seed += (unsigned)every()) {
        int n = 2 + (int)seed % 3;
        ric_model *m = make_soft(seed, n, 1, 0, 6);
        ric_simulator *sim = NULL;
        assert_int_equal(ric_simulator_create(m, &sim), RIC_OK);
        bool closed[2] = {true, false};
        ric_real w[MAX_W], small[MAX_W], tau = uniform(0, 1), top = 0, scale = 1e-40L;
        for (int i = 0; i < 2 * n; i++) small[i] = (w[i] = uniform(-1, 1)) * scale;
        assert_int_equal(ric_simulator_fly(sim, closed, true, tau, w, w), RIC_OK);
        assert_int_equal(ric_simulator_fly(sim, closed, true, tau, small, small), RIC_OK);
        for (int i = 0; i < 2 * n; i++) top = fmaxl(top, fabsl(w[i]));
        for (int i = 0; i < 2 * n; i++) assert_true(fabsl(small[i] / scale - w[i]) <= 1e-15L * top);
        ric_simulator_free(sim);
        ric_model_free(m);
    }
}

/* Energy stays, its gradient is that of differences and perpendicular to the flow. */
static void energies(void **state)
{
    (void)state;
    for (unsigned seed = 1; seed <= 40; seed += (unsigned)every()) {
        ric_model *m = make_soft(100 + seed, 1 + (int)seed % 5, 1 + (int)seed % 3, 0, 6);
        for (uint64_t set = 0, done = 0; !done; done = !(set = next_set(m, set))) {
            const ric_regime *phase;
            int size = 2 * m->n;
            double w[MAX_W], after[MAX_W], g[MAX_W], f[MAX_W];
            assert_int_equal(ric_regime_get(m, set, &phase), RIC_OK);
            random_coordinates(size, w);
            fly(phase, uniform(-3, 3), w, after);
            check_close(ric_flight_energy(m, set, after), ric_flight_energy(m, set, w), 1e-11,
                        "energy of a flight");
            ric_flight_secant(m, set, w, w, g);
            ric_flight_rate(m, set, w, f);
            assert_true(fabs(ric_dot(size, g, f)) <= 1e-13 * norm_of(size, g) * norm_of(size, f));
            /* E(x) - E(y) = grad E((x + y) / 2) . (x - y) */
            double other[MAX_W], work = 0;
            random_coordinates(size, other);
            ric_flight_secant(m, set, other, w, g);
            for (int i = 0; i < size; i++) work += g[i] * (w[i] - other[i]) / 2;
            double E = ric_flight_energy(m, set, w), F = ric_flight_energy(m, set, other);
            assert_true(fabs(E - F - work) <= 1e-12 * (E + F));
            uint64_t mirror = m->symmetric ? ric_flight_mirror(m, set) : 0;
            for (int i = 0; m->symmetric && i < size; i++) other[i] = -w[i];
            if (m->symmetric)
                check_close(ric_flight_energy(m, mirror, other), E, 1e-13, "energy of the image");
        }
        ric_model_free(m);
    }
}

/* The divided difference: against the difference itself, its limit ds/dt, the series against the
 * formula, and derivatives. */
static void chords(void **state)
{
    (void)state;
    for (unsigned seed = 1; seed <= 40; seed += (unsigned)every()) {
        ric_model *m = make_soft(200 + seed, 2 + (int)seed % 4, 1 + (int)seed % 3, 0, 4);
        int size = 2 * m->n;
        for (uint64_t set = 0, done = 0; !done; done = !(set = next_set(m, set))) {
            const ric_regime *phase;
            double w[MAX_W], f[MAX_W], after[MAX_W], row[MAX_W], slope, fast = 1;
            assert_int_equal(ric_regime_get(m, set, &phase), RIC_OK);
            for (int i = 0; i < m->n; i++) fast = fmax(fast, phase->omega[i]);
            random_coordinates(size, w);
            ric_flight_rate(m, set, w, f);
            const ric_face *face = &m->face[m->n_face - 1];
            double largest = norm_of(m->n, face->g) * norm_of(size, w) * fast;
            assert_true(fabs(chord(phase, face->contact, 0, w, NULL, NULL) -
                             ric_gap(m->n, face, f)) <= 1e-13 * largest);
            for (int i = 0; i < 60; i++) {
                double tau = (i % 2 ? -1 : 1) * pow(10, -9 + i / 6.0) / fast,
                       value = chord(phase, face->contact, tau, w, row, &slope);
                fly(phase, tau, w, after);
                double plain = (ric_gap(m->n, face, after) - ric_gap(m->n, face, w)) / tau;
                if (fabs(tau) * fast > 0.01 && fabs(plain - value) > 1e-11 * largest)
                    fail_msg("seed %u tau %g: %g against %g", seed, tau, value, plain);
                double h = 1e-5 / fast, d = chord(phase, face->contact, tau + h, w, NULL, NULL) -
                                            chord(phase, face->contact, tau - h, w, NULL, NULL);
                assert_true(fabs(d / (2 * h) - slope) <= 1e-7 * largest * fast);
                for (int j = 0; j < size; j++) { /* affine in w */
                    double moved[MAX_W];
                    memcpy(moved, w, sizeof moved);
                    moved[j] += 0.5;
                    assert_true(fabs(chord(phase, face->contact, tau, moved, NULL, NULL) - value -
                                     row[j] / 2) <= 1e-12 * largest);
                }
            }
        }
        ric_model_free(m);
    }
}

static void sets(void **state)
{
    (void)state;
    ric_model *m = make_soft(7, 3, 3, 1, 2); /* faces 0 1 rigid, 2 3 soft, 4 soft with one side */
    assert_int_equal(m->n_face, 5);
    const ric_regime *phase;
    assert_true(ric_regime_exists(m, 0) && ric_regime_exists(m, 1 << 2 | 1 << 4) &&
                ric_regime_exists(m, 1 << 3));
    assert_false(ric_regime_exists(m, 1 << 2 | 1 << 3) || ric_regime_exists(m, 1) ||
                 ric_regime_exists(m, 1 << 5));
    assert_int_equal(ric_regime_get(m, 3 << 2, &phase), RIC_E_NUMERIC);
    assert_null(phase);
    ric_model_free(m);
}

/* ---------------------------------------------------------------- simulator */

/* Between events of the simulator the state flies in the phase that its openings and closings say;
 * at every event a face is met. Several faces are closed at once in some of the runs, and there are
 * stops among the contacts. */
static void replay(void **state)
{
    (void)state;
    int most = 0, switches = 0, impacts = 0;
    for (unsigned seed = 1; seed <= 60; seed += (unsigned)every()) {
        int n = 2 + (int)seed % 4;
        ric_model *m = make_soft(300 + seed, n, 2 + (int)seed % 3, (int)seed % 2, seed % 3 ? 4 : 2);
        assert_int_equal(m->n, n);
        ric_simulator *sim = simulator(m);
        double x[MAX_W] = {0}, v[MAX_W], w[MAX_W], seen[MAX_W], E, time = 0;
        random_coordinates(n, v);
        for (int i = 0; i < n; i++) v[i] *= 2;
        ric_model_from_state(m, x, v, w);
        E = ric_model_energy(m, x, v);
        start(sim, x, v);
        uint64_t set = 0;
        for (int event = 0; event < 60; event++) {
            const ric_regime *phase;
            ric_impact impact;
            bool hit = advance(sim, 1e3, &impact);
            assert_true(hit);
            const ric_face *face = &m->face[impact.face];
            assert_int_equal(ric_regime_get(m, set, &phase), RIC_OK);
            fly(phase, (impact.time - time) * m->omega_ref, w, w);
            if (fabs(ric_gap(n, face, w) - face->gap) > 1e-9)
                fail_msg("seed %u event %d: %g off the face", 300 + seed, event,
                         ric_gap(n, face, w) - face->gap);
            double speed = face->side * ric_dot(n, face->c, w + n) * m->omega_ref;
            assert_true(fabs(speed - impact.approach) <= 1e-8 * (1 + fabs(speed)));
            if (face->spring > 0) {
                assert_true((set >> impact.face & 1) == impact.opens &&
                            (impact.approach < 0) == impact.opens);
                set = ric_flight_toggle(m, set, impact.face);
                switches++;
            } else {
                ric_impact_reflect(n, face, w + n);
                impacts++;
            }
            int closed = 0;
            for (int f = 0; f < m->n_face; f++) closed += set >> f & 1;
            most = closed > most ? closed : most;
            ric_simulator_state(sim, &time, x, v);
            ric_model_from_state(m, x, v, seen);
            double off = 0;
            for (int i = 0; i < 2 * n; i++) off = fmax(off, fabs(seen[i] - w[i]));
            if (off > 1e-9)
                fail_msg("seed %u event %d: states differ by %g", 300 + seed, event, off);
            memcpy(w, seen,
                   sizeof w); /* errors grow along a chaotic motion: each flight by itself */
            check_close(ric_model_energy(m, x, v), E, 1e-12, "energy");
        }
        ric_simulator_free(sim);
        ric_model_free(m);
    }
    assert_true(every() > 1 || (most >= 3 && switches > 1000 && impacts > 200));
}

/* One mass that meets a spring slowly: the acceleration behind it, -cos(W tau) - W v sin(W tau) per
 * unit of clearance, W^2 = 1 + ks, is known to extended precision times the stiffness, although the
 * depth of the contact is within the last digits of the displacement. */
static void accelerations(void **state)
{
    (void)state;
    for (int i = 0; i <= 10; i++) {
        double one = 1, ks = pow(10, i), W = sqrt(1 + ks), v = 1e-8, pull, after[2];
        ric_contact contact = {.normal = &one,
                               .clearance = 1,
                               .law = RIC_LAW_BILINEAR,
                               .stiffness = ks};
        ric_model *m = make(1, &one, &one, 1, &contact, 1);
        const ric_regime *phase;
        assert_int_equal(ric_regime_get(m, 1, &phase), RIC_OK);
        double w[2] = {m->face[0].gap / m->face[0].g[0], v};
        for (double tau = 0; tau < 1.5 / W; tau += 0.1 / W) {
            ric_regime_map(phase, &(ric_regime_course){&m->face[0], tau, w}, NULL, after, &pull);
            double off = pull + cos(W * tau) + W * v * sin(W * tau);
            if (fabs(off) > 1e-14 + 2 * LDBL_EPSILON * ks)
                fail_msg("ks = 1e%d, phase %g: off by %g", i, W * tau, off);
        }
        ric_model_free(m);
    }
}

/* One mass on a spring between two others: contact time and impulse in closed form. */
static void one_mass(void **state)
{
    (void)state;
    for (int i = 0; i <= 20; i++) {
        double m = 0.7, k = 3.1, ks = pow(10, i * 0.4), x = 0, v0 = 4, normal = 1;
        ric_contact contact = {.normal = &normal,
                               .clearance = 1,
                               .law = RIC_LAW_BILINEAR,
                               .stiffness = ks};
        ric_model *model = make(1, &m, &k, 1, &contact, 1);
        ric_simulator *sim = simulator(model);
        double omega = sqrt(k / m), closed = sqrt((k + ks) / m), rest = ks / (k + ks),
               v = sqrt(v0 * v0 - omega * omega);
        double tau = asin(omega / v0) / omega,
               sigma = 2 * (PI / 2 - atan((1 - rest) * closed / v)) / closed;
        ric_impact impact;
        start(sim, &x, &v0);
        for (int j = 0; j < 40; j++) {
            assert_true(advance(sim, 1e9, &impact));
            check_close(impact.time, (1 + 2 * (j / 2)) * tau + (j + 1) / 2 * sigma, 1e-13, "time");
            check_close(impact.approach, j % 2 ? -v : v, 1e-12, "speed");
            assert_int_equal(impact.face, j / 2 % 2);
            assert_int_equal(impact.opens, j % 2);
            /* what the spring takes: all that changes the momentum but for the structure's own k x
             */
            if (impact.opens)
                check_close(impact.impulse,
                            2 * m * v - k * (rest * sigma +
                                             2 *
                                                 ((1 - rest) * sin(closed * sigma / 2) +
                                                  v / closed * (1 - cos(closed * sigma / 2))) /
                                                 closed * 0 +
                                             ((1 - rest) * sin(closed * sigma) +
                                              v / closed * (1 - cos(closed * sigma))) /
                                                 closed),
                            1e-11, "impulse");
        }
        ric_simulator_free(sim);
        ric_model_free(model);
    }
}

/* A start beyond the spring, and at rest on the face. */
static void starts(void **state)
{
    (void)state;
    double m = 1, k = 1, normal = 1, x = 1.5, v = 0;
    ric_contact contact = {.normal = &normal,
                           .clearance = 1,
                           .law = RIC_LAW_BILINEAR,
                           .stiffness = 3};
    ric_model *model = make(1, &m, &k, 1, &contact, 1);
    ric_simulator *sim = simulator(model);
    ric_impact impact;
    start(sim, &x, &v);
    assert_true(advance(sim, 100, &impact));
    assert_true(impact.opens && impact.face == 0);
    /* x = 3/4 + 3/4 cos 2t meets 1 */
    check_close(impact.time, acos(1.0 / 3) / 2, 1e-14, "opening");
    x = 1;
    start(sim, &x, &v); /* falls back: never closes */
    assert_false(advance(sim, 100, &impact));
    check_close(ric_simulator_reach(sim), 1, 1e-12, "reach");
    v = 1;
    start(sim, &x, &v);
    assert_true(advance(sim, 100, &impact));
    assert_true(impact.time == 0 && !impact.opens);
    assert_true(advance(sim, 100, &impact));
    assert_true(impact.time > 0 && impact.opens);
    ric_simulator_free(sim);
    ric_model_free(model);
}

/* Branches that arrive, in a structure whose contacts have one side: the orbits at their ends have
 * no images under x -> -x. */
static void one_sided(void **state)
{
    (void)state;
    ric_atlas *atlas = explore_text(
        "model:\n  mass: [[0.645, 0], [0, 1.305]]\n  stiffness: [[5.93, -4.0809], [-4.0809, "
        "5.4961]]\n  contacts:\n"
        "    - {normal: [0, 1], clearance: 1.235, sides: upper, law: rigid}\n"
        "    - {normal: [-1, 1], clearance: 1.582, sides: lower, law: bilinear, stiffness: "
        "305.372}\n"
        "explore: {energy: [0, 14.689], frequency: [0.2533, 10.3057], impacts: 10, multiply: 2, "
        "depth: 3}\n");
    int points = 0;
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++)
        for (int i = 0, n = branch_of(atlas, id).n_point; i < n; i++, points++)
            point_passes(atlas, id, i);
    assert_true(points > 300);
    ric_atlas_free(atlas);
}

/* What another gap reaches changes little with the length of a short contact, from none on. */
static void reach_goes_on(const char *text)
{
    ric_atlas *atlas = explore_text(text);
    int close = 0; /* points this near follow the start of a branch only */
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++)
        for (int i = 0, n = branch_of(atlas, id).n_point; i + 1 < n; i++) {
            ric_point p[2];
            for (int j = 0; j < 2; j++)
                assert_int_equal(ric_atlas_point(atlas, id, i + j, &p[j], NULL, NULL), RIC_OK);
            if (!(fabs(p[1].arclength - p[0].arclength) < 1e-4) || !(p[0].reach < 0.9)) continue;
            assert_true(fabs(p[1].reach - p[0].reach) < 1e-3);
            close++;
        }
    assert_true(close >= 2);
    ric_atlas_free(atlas);
}

/* Where two contacts become one the rest between them lasts no time. What another gap reaches there
 * is not lost. */
static void reach_of_a_short_rest(void **state)
{
    (void)state;
    reach_goes_on(
        "model:\n  mass: [[0.84375, -0.171875, 0.046875], [-0.171875, 0.90625, -0.21875], "
        "[0.046875, -0.21875, 1.453125]]\n"
        "  stiffness: [[9.125, 1.875, -5.875], [1.875, 7.125, 0.125], [-5.875, 0.125, 5.375]]\n  "
        "contacts:\n"
        "    - {normal: [0, 1, 0], clearance: 1.19, sides: both, law: rigid}\n"
        "    - {normal: [-1, 1, 0], clearance: 0.819, sides: lower, law: bilinear, stiffness: "
        "31.73}\n"
        "explore: {energy: [0, 8.876], frequency: [0.157, 11.89], impacts: 6, multiply: 1, depth: "
        "2}\n");
}

/* The structure rests while another spring is pressed in most, far from opening: that is no maximum
 * of its gap as it is looked at. */
static void reach_beside_a_closed_spring(void **state)
{
    (void)state;
    reach_goes_on(
        "model:\n  mass: [[0.5, 0, 0], [0, 1.25, 0], [0, 0, 1.25]]\n"
        "  stiffness: [[11.5, -6, 0], [-6, 10.75, -4.75], [0, -4.75, 8.25]]\n  contacts:\n"
        "    - {normal: [-1, 1, 0], clearance: 0.00107, sides: both, law: bilinear, stiffness: "
        "0.0244}\n"
        "    - {normal: [1, 0, 0], clearance: 0.00123, sides: both, law: bilinear, stiffness: "
        "6964000}\n"
        "    - {normal: [0, 0, 1], clearance: 0.00138, sides: both, law: rigid}\n"
        "explore: {energy: [0, 19.98], frequency: [0.3087, 15.41], impacts: 4, multiply: 1, depth: "
        "2}\n");
}

/* An orbit that is not reversible leaves a spring at another speed than it meets it with. Its
 * branch is that of the motion backwards, too, and the smaller of the two the approach of either.
 */
static void approach_of_one_way(void **state)
{
    (void)state;
    ric_atlas *atlas = explore_text(
        "model:\n  mass: [[1.25, 0, 0], [0, 0.5, 0], [0, 0, 2]]\n"
        "  stiffness: [[12.25, -5.5, 0], [-5.5, 11.75, -6.25], [0, -6.25, 11.75]]\n  contacts:\n"
        "    - {normal: [0, -1, 1], clearance: 10.8, sides: both, law: rigid}\n"
        "    - {normal: [0, 0, 1], clearance: 10.9, sides: lower, law: bilinear, stiffness: "
        "515.1}\n"
        "explore: {energy: [0, 37.25], frequency: [0.3446, 15.86], impacts: 6, multiply: 1, depth: "
        "2}\n");
    int asked = 0;
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++)
        for (int i = 0, n = branch_of(atlas, id).n_point; i < n && !branch_of(atlas, id).reversible;
             i++, asked++) {
            ric_claims claims;
            assert_int_equal(ric_verify_claims(atlas, id, i, &claims), RIC_OK);
            if (claims.numbers == RIC_AGREES_NO)
                fail_msg("branch %d, point %d: %s", id, i, claims.finding);
        }
    assert_true(asked > 10);
    ric_atlas_free(atlas);
}

/* lambda + 1/lambda nearest to that of the multiplication, whose place it is, minus it. */
static double off_root(const ric_model *m, const ric_node *node)
{
    ric_shooting *chain = NULL;
    ric_floquet floquet;
    double *u = NULL, off = HUGE_VAL;
    assert_int_equal(ric_periodic_to_chain(m, node->cycle, &chain, &u), RIC_OK);
    assert_int_equal(ric_floquet_create(chain->n, &floquet), RIC_OK);
    ric_shooting_fly(chain, u);
    assert_int_equal(ric_floquet_compute(chain, &floquet), RIC_OK);
    double rho = ric_symmetry_rho(ric_shooting_halves(chain), node->rotation[0], node->rotation[1]);
    for (int i = 0; i < floquet.n_pair; i++)
        off = fmin(off, hypot(floquet.own[2 * i] - rho, floquet.own[2 * i + 1]));
    ric_floquet_release(&floquet);
    ric_shooting_free(chain);
    free(u);
    return off;
}

/* A stiff spring that is hardly touched: its multipliers run through all they can while the contact
 * grows by 1e-6. */
static void doubling_of_a_touch(void **state)
{
    (void)state;
    ric_study *study = NULL;
    int count = 0;
    assert_int_equal(
        ric_study_parse(
            "model:\n  mass: [[1, 0], [0, 1]]\n  stiffness: [[2, 0], [0, 3]]\n  contacts:\n"
            "    - {normal: [-1, 1], clearance: 11.4, sides: upper, law: bilinear, stiffness: "
            "1487000}\n"
            "explore: {energy: [0, 4.236], frequency: [0.2828, 5.196], impacts: 5, multiply: 2, "
            "depth: 1}"
            "\n",
            "test", ".", &study),
        RIC_OK);
    ric_graph *graph = explored_graph(study);
    for (int i = 0; i < graph->n_node; i++)
        if (graph->nodes[i]->kind == RIC_KIND_MULTIPLICATION && graph->nodes[i]->multiple == 2) {
            assert_true(off_root(graph->model, graph->nodes[i]) < 1e-6);
            count++;
        }
    assert_true(count > 0);
    ric_graph_free(graph);
    ric_study_free(study);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(flights),
        cmocka_unit_test(deviations),
        cmocka_unit_test(energies),
        cmocka_unit_test(chords),
        cmocka_unit_test(sets),
        cmocka_unit_test(accelerations),
        cmocka_unit_test(one_mass),
        cmocka_unit_test(starts),
        cmocka_unit_test(replay),
        cmocka_unit_test(one_sided),
        cmocka_unit_test(reach_of_a_short_rest),
        cmocka_unit_test(reach_beside_a_closed_spring),
        cmocka_unit_test(approach_of_one_way),
        cmocka_unit_test(doubling_of_a_touch),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
