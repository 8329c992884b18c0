/* The simulator against closed forms, invariants, brute force and its own reversal. What it is compared with is computed here or from
 * ric_model_modes, which it does not use. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "atlas.h"

enum { MAX_N = 50, MAX_CONTACT = 4 };

static const double PI = 3.14159265358979323846;

/* ------------------------------------------------------------------ helpers */

static uint64_t seed_now;

static double uniform(double lo, double hi) /* splitmix64 (Steele, Lea, Flood 2014) */
{
    uint64_t z = seed_now += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return lo + (hi - lo) * (double)((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

static void check_close(double a, double b, double tolerance, const char *what)
{
    double error = fabs(a - b) / fmax(1e-300, fmax(fabs(a), fabs(b)));
    if (!(error <= tolerance)) fail_msg("%s: %.17g against %.17g, relative difference %.3g > %.3g", what, a, b, error, tolerance);
}

static ric_model *make(int n, const double *M, const double *K, int n_contact, const ric_contact *contacts, double restitution)
{
    ric_model *model = NULL;
    if (ric_model_create(n, M, K, n_contact, contacts, restitution, &model)) fail_msg("%s", ric_detail());
    return model;
}

static ric_model *make_one(double m, double k, ric_sides sides, double restitution)
{
    double normal = 1;
    ric_contact contact = {.normal = &normal, .clearance = 1, .sides = sides};
    return make(1, &m, &k, 1, &contact, restitution);
}

static ric_model *make_two(void) /* the article's model */
{
    double M[] = {2, 0, 0, 1}, K[] = {9, -1, -1, 1}, normal[] = {-1, 1};
    ric_contact contact = {.normal = normal, .clearance = 1};
    return make(2, M, K, 1, &contact, 1);
}

/* A = G G' / n + shift. */
static void random_definite(int n, double shift, double *A)
{
    static double G[MAX_N * MAX_N];
    for (int i = 0; i < n * n; i++) G[i] = uniform(-1, 1);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            A[i * n + j] = i == j ? shift : 0;
            for (int k = 0; k < n; k++) A[i * n + j] += G[i * n + k] * G[j * n + k] / n;
        }
}

static ric_model *make_random(uint64_t seed, int n, int n_contact, double restitution)
{
    double M[MAX_N * MAX_N], K[MAX_N * MAX_N], normal[MAX_CONTACT * MAX_N];
    ric_contact contacts[MAX_CONTACT] = {{0}};
    seed_now = seed;
    random_definite(n, 0.5, M);
    random_definite(n, 0.1, K);
    for (int f = 0; f < n_contact; f++) {
        for (int i = 0; i < n; i++) normal[f * n + i] = uniform(-1, 1);
        contacts[f] = (ric_contact){.normal = normal + f * n, .clearance = uniform(0.5, 2), .sides = f % 3 == 2 ? RIC_SIDES_UPPER : RIC_SIDES_BOTH};
    }
    return make(n, M, K, n_contact, contacts, restitution);
}

static ric_simulator *simulator(const ric_model *model)
{
    ric_simulator *sim = NULL;
    if (ric_simulator_create(model, &sim)) fail_msg("%s", ric_detail());
    return sim;
}

static void start(ric_simulator *sim, const double *x, const double *v)
{
    if (ric_simulator_start(sim, x, v)) fail_msg("%s", ric_detail());
}

static bool advance(ric_simulator *sim, double t, ric_impact *impact)
{
    bool hit;
    if (ric_simulator_advance(sim, t, &hit, impact)) fail_msg("%s", ric_detail());
    return hit;
}

/* A state well inside every stop. */
static void random_state(const ric_model *model, double speed, double *x, double *v)
{
    int n = ric_model_n_dof(model);
    for (int i = 0; i < n; i++) {
        x[i] = uniform(-0.2, 0.2) / n;
        v[i] = uniform(-speed, speed);
    }
}

/* Modal closed forms from the model's own modes. */
typedef struct {
    int n, n_contact;
    double omega[MAX_N], phi[MAX_N * MAX_N], c[MAX_CONTACT * MAX_N], d[MAX_CONTACT];
    ric_sides sides[MAX_CONTACT];
    const double *M;
} modal;

static modal make_modal(const ric_model *model)
{
    modal m = {.n = ric_model_n_dof(model), .n_contact = ric_model_n_contact(model), .M = ric_model_mass(model)};
    ric_model_frequencies(model, m.omega);
    ric_model_modes(model, m.phi);
    for (int f = 0; f < m.n_contact; f++) {
        ric_contact contact;
        assert_int_equal(ric_model_contact(model, f, &contact), RIC_OK);
        m.d[f] = contact.clearance / ric_model_length(model);
        m.sides[f] = contact.sides;
        for (int i = 0; i < m.n; i++) {
            double c = 0;
            for (int j = 0; j < m.n; j++) c += contact.normal[j] * m.phi[j * m.n + i];
            m.c[f * m.n + i] = c;
        }
    }
    return m;
}

static void to_modal(const modal *m, const double *x, double *q)
{
    for (int i = 0; i < m->n; i++) {
        q[i] = 0;
        for (int j = 0; j < m->n; j++)
            for (int k = 0; k < m->n; k++) q[i] += m->phi[j * m->n + i] * m->M[j * m->n + k] * x[k];
    }
}

static void to_space(const modal *m, const double *q, double *x)
{
    for (int j = 0; j < m->n; j++) {
        x[j] = 0;
        for (int i = 0; i < m->n; i++) x[j] += m->phi[j * m->n + i] * q[i];
    }
}

static void modal_flight(const modal *m, double t, const double *q, const double *p, double *qt, double *pt)
{
    for (int i = 0; i < m->n; i++) {
        double w = m->omega[i], s = sin(w * t), c = cos(w * t), qi = q[i], pi = p[i];
        qt[i] = w > 0 ? qi * c + pi / w * s : qi + pi * t;
        pt[i] = w > 0 ? pi * c - w * qi * s : pi;
    }
}

static double modal_gap(const modal *m, int contact, double t, const double *q, const double *p)
{
    double qt[MAX_N], pt[MAX_N], s = 0;
    modal_flight(m, t, q, p, qt, pt);
    for (int i = 0; i < m->n; i++) s += m->c[contact * m->n + i] * qt[i];
    return s;
}

static double distance(int n, const double *x, const double *y)
{
    double sum = 0;
    for (int i = 0; i < n; i++) sum += (x[i] - y[i]) * (x[i] - y[i]);
    return sqrt(sum);
}

static double length(int n, const double *x)
{
    double sum = 0;
    for (int i = 0; i < n; i++) sum += x[i] * x[i];
    return sqrt(sum);
}

/* ------------------------------------------------------------- closed forms */

/* x = cos between two stops, and against one: tau = 2 asin(1/A) / omega, or the period less 2 acos(1/A) / omega. */
static void one_mass(void **state)
{
    (void)state;
    for (int sides = 0; sides < 2; sides++)
        for (int i = 0; i <= 40; i++) {
            double m = 0.7, k = 3.1, omega = sqrt(k / m), v0 = pow(10, -3 + i * 0.2), A = hypot(1, v0 / omega);
            ric_model *model = make_one(m, k, sides ? RIC_SIDES_UPPER : RIC_SIDES_BOTH, 1);
            ric_simulator *sim = simulator(model);
            double x = 1, v = -v0, tau = sides ? 2 * (PI - atan(v0 / omega)) / omega : 2 * asin(1 / A) / omega;
            ric_impact impact;
            start(sim, &x, &v);
            for (int k_impact = 1; k_impact <= 100; k_impact++) {
                assert_true(advance(sim, 1e9, &impact));
                check_close(impact.time, k_impact * tau, 1e-11, "time of impact");
                double rounding = 1e-12 + 1e-13 * k / (m * v0 * v0); /* the energy's, of which a slow mass on the stop has little in motion */
                check_close(impact.approach, v0, rounding, "approach");
                check_close(impact.impulse, 2 * v0 * m, rounding, "impulse");
                assert_int_equal(impact.face, sides ? 0 : k_impact % 2);
            }
            assert_true(ric_simulator_reach(sim) < 1);
            ric_simulator_free(sim);
            ric_model_free(model);
        }
}

/* S2[01]: q_i = -J c_i sin(omega_i (t - h/2)) / (omega_i cos(omega_i h/2)), J sum c_i^2 tan(omega_i h/2) / omega_i = d, h = pi / omega. */
static bool s2_orbit(const modal *m, double h, double *x, double *v)
{
    double q[MAX_N], p[MAX_N], sum = 0;
    for (int i = 0; i < m->n; i++) sum += m->c[i] * m->c[i] * tan(m->omega[i] * h / 2) / m->omega[i];
    if (sum <= 0) return false;
    for (int i = 0; i < m->n; i++) {
        q[i] = m->c[i] * tan(m->omega[i] * h / 2) / (m->omega[i] * sum);
        p[i] = -m->c[i] / sum;
    }
    for (int i = 1; i < 4000; i++)
        if (fabs(modal_gap(m, 0, h * i / 4000, q, p)) > 1) return false; /* not admissible */
    to_space(m, q, x);
    to_space(m, p, v);
    return true;
}

static void check_s2(const ric_model *model, double h)
{
    int n = ric_model_n_dof(model);
    double x[MAX_N], v[MAX_N], x1[MAX_N], v1[MAX_N];
    modal m = make_modal(model);
    ric_simulator *sim = simulator(model);
    ric_impact impact;
    if (s2_orbit(&m, h, x, v)) {
        start(sim, x, v);
        assert_true(advance(sim, 2 * h, &impact));
        check_close(impact.time, h, 1e-11, "flight of S2");
        assert_int_equal(impact.face, 1);
        ric_simulator_state(sim, NULL, x1, v1);
        for (int i = 0; i < n; i++) {
            x1[i] = -x1[i];
            v1[i] = -v1[i];
        }
        assert_true(distance(n, x, x1) <= 1e-11 * length(n, x));
        assert_true(distance(n, v, v1) <= 1e-11 * length(n, v));
    }
    ric_simulator_free(sim);
}

static void backbone(void **state)
{
    (void)state;
    ric_model *model = make_two();
    for (int i = 0; i < 60; i++) check_s2(model, PI / (0.95 + 0.012 * i));
    for (int i = 0; i < 60; i++) check_s2(model, PI / (2.2 + 0.2 * i));
    ric_model_free(model);
    for (int n = 1; n <= 12; n++)
        for (int i = 0; i < 10; i++) {
            model = make_random(1000 + 10u * (unsigned)n + (unsigned)i, n, 1, 1);
            modal m = make_modal(model);
            for (int k = 1; k < 12; k++) check_s2(model, PI / (m.omega[n - 1] * (1 + 0.2 * k)));
            ric_model_free(model);
        }
}

/* The linear mode at E = omega^2 / (2 c^2) touches and never strikes, wherever it starts. */
static void touch(void **state)
{
    (void)state;
    for (int n = 1; n <= 12; n++) {
        ric_model *model = make_random(77u + (unsigned)n, n, 1, 1);
        modal m = make_modal(model);
        ric_simulator *sim = simulator(model);
        for (int i = 0; i < n; i++)
            for (int k = 0; k < 7; k++) {
                double q[MAX_N] = {0}, p[MAX_N] = {0}, x[MAX_N], v[MAX_N], A = 1 / fabs(m.c[i]), T = 2 * PI / m.omega[i];
                if (A > 5) continue; /* the modes are not known well enough for such a state to touch */
                q[i] = A * cos(k * 0.9);
                p[i] = A * m.omega[i] * sin(k * 0.9);
                to_space(&m, q, x);
                to_space(&m, p, v);
                start(sim, x, v);
                assert_false(advance(sim, 10 * T, NULL));
                assert_true(fabs(ric_simulator_reach(sim) - 1) <= 1e-13 * fmax(1, A));
                double more = 1 + 1e-12 * fmax(1, A); /* and this is no touch any more */
                for (int j = 0; j < n; j++) {
                    x[j] *= more;
                    v[j] *= more;
                }
                if (k) {
                    start(sim, x, v);
                    assert_true(advance(sim, 10 * T, NULL));
                }
            }
        ric_simulator_free(sim);
        ric_model_free(model);
    }
}

/* A loose mass in a gap flies straight; a floating pair strikes its inner stop, its centre of mass moves on. */
static void free_modes(void **state)
{
    (void)state;
    ric_model *model = make_one(2, 0, RIC_SIDES_BOTH, 1);
    ric_simulator *sim = simulator(model);
    double x = 0.25, v = 0.5;
    ric_impact impact;
    start(sim, &x, &v);
    for (int i = 0; i < 1000; i++) {
        assert_true(advance(sim, 1e6, &impact));
        check_close(impact.time, 1.5 + 4 * i, 1e-14, "loose mass");
        check_close(impact.approach, 0.5, 1e-12, "its speed");
        assert_int_equal(impact.face, i % 2);
    }
    ric_simulator_free(sim);
    ric_model_free(model);

    double M[] = {1, 0, 0, 3}, K[] = {2, -2, -2, 2}, normal[] = {-1, 1}, x2[] = {5, 5}, v2[] = {1, 4}, t, x3[2], v3[2];
    ric_contact contact = {.normal = normal, .clearance = 1};
    model = make(2, M, K, 1, &contact, 1);
    sim = simulator(model);
    start(sim, x2, v2);
    for (int i = 0; i < 1000; i++) assert_true(advance(sim, 1e6, NULL));
    ric_simulator_state(sim, &t, x3, v3);
    check_close((x3[0] + 3 * x3[1]) / 4, 5 + 3.25 * t, 1e-12, "centre of mass");
    check_close((v3[0] + 3 * v3[1]) / 4, 3.25, 1e-12, "its velocity");
    ric_simulator_free(sim);
    ric_model_free(model);
}

/* -------------------------------------------------------------- invariants */

static void energy(void **state)
{
    (void)state;
    for (int n = 1; n <= 12; n++) {
        double x[MAX_N], v[MAX_N];
        uint64_t seed = 500u + (unsigned)n;
        print_message("energy: n = %d, seed %llu\n", n, (unsigned long long)seed);
        ric_model *model = make_random(seed, n, 1 + (n > 1) + (n > 3), 1);
        ric_simulator *sim = simulator(model);
        random_state(model, 3, x, v);
        v[0] += 8;
        double before = ric_model_energy(model, x, v);
        start(sim, x, v);
        for (int i = 0; i < 10000; i++) assert_true(advance(sim, 1e9, NULL));
        ric_simulator_state(sim, NULL, x, v);
        check_close(ric_model_energy(model, x, v), before, 1e-11, "energy after 10000 impacts");
        ric_simulator_free(sim);
        ric_model_free(model);
    }
}

/* One flight, velocities turned round: the impact is undone at once, then the flight is flown back. */
static void reversal(void **state)
{
    (void)state;
    for (int n = 1; n <= 12; n++) {
        double x[MAX_N], v[MAX_N], x1[MAX_N], v1[MAX_N], x2[MAX_N], v2[MAX_N], t0 = 0, t1;
        ric_model *model = make_random(900u + (unsigned)n, n, 1 + (n > 2), 1);
        ric_simulator *sim = simulator(model), *back = simulator(model);
        ric_impact impact, undone;
        random_state(model, 3, x, v);
        start(sim, x, v);
        assert_true(advance(sim, 1e9, &impact));
        for (int i = 0; i < 200; i++) {
            ric_simulator_state(sim, &t0, x, v);
            assert_true(advance(sim, 1e9, &impact));
            ric_simulator_state(sim, &t1, x1, v1);
            for (int j = 0; j < n; j++) v1[j] = -v1[j];
            start(back, x1, v1);
            assert_true(advance(back, 1e9, &undone));
            assert_true(undone.face == impact.face);
            if (impact.approach < 1e-3) continue;
            assert_true(undone.time <= 1e-11);
            assert_true(advance(back, 1e9, NULL));
            ric_simulator_state(back, NULL, x2, v2);
            double slow = fmin(1, impact.approach); /* a slow impact leaves its time uncertain */
            assert_true(distance(n, x, x2) <= 1e-11 / slow * (1 + length(n, v)));
            ric_simulator_state(back, &t1, NULL, NULL);
        }
        ric_simulator_free(sim);
        ric_simulator_free(back);
        ric_model_free(model);
    }
}

static void restitution(void **state)
{
    (void)state;
    double x0 = 0, v0 = 1, eps = 0.8, t = 1, v = 1;
    ric_model *model = make_one(1, 0, RIC_SIDES_BOTH, eps);
    ric_simulator *sim = simulator(model);
    ric_impact impact;
    start(sim, &x0, &v0);
    for (int i = 0; i < 60; i++) {
        assert_true(advance(sim, 1e9, &impact));
        check_close(impact.approach, v, 1e-13, "speed after bounces");
        check_close(impact.time, t, 1e-13, "time of bounces");
        check_close(impact.impulse, (1 + eps) * v, 1e-13, "impulse");
        v *= eps;
        t += 2 / v;
    }
    ric_simulator_free(sim);
    ric_model_free(model);
    for (int n = 2; n <= 10; n++) { /* every impact takes (1 - eps^2) approach^2 / (2 c.c) */
        double x[MAX_N], u[MAX_N], cc[MAX_N], before, after;
        model = make_random(300u + (unsigned)n, n, 1, eps);
        sim = simulator(model);
        assert_int_equal(ric_model_compliance(model, 0, cc), RIC_OK);
        random_state(model, 3, x, u);
        start(sim, x, u);
        for (int i = 0; i < 20 && advance(sim, 1e3, &impact); i++) {
            before = ric_model_energy(model, x, u);
            ric_simulator_state(sim, NULL, x, u);
            after = ric_model_energy(model, x, u);
            assert_true(fabs(before - after - (1 - eps * eps) * impact.approach * impact.approach / (2 * cc[n - 1])) <= 1e-12 * before);
        }
        ric_simulator_free(sim);
        ric_model_free(model);
    }
}

/* ------------------------------------------------------------- brute force */

/* First impact by steps far below the shortest period, then bisection. */
static double brute_force(const modal *m, const double *q, const double *p, double step, double end, int *contact)
{
    double before[MAX_CONTACT], after[MAX_CONTACT];
    for (int f = 0; f < m->n_contact; f++) before[f] = modal_gap(m, f, step * 1e-3, q, p);
    for (double t = step; t < end; t += step)
        for (int f = 0; f < m->n_contact; f++) {
            after[f] = modal_gap(m, f, t, q, p);
            bool up = m->sides[f] != RIC_SIDES_LOWER && after[f] > m->d[f] && before[f] <= m->d[f];
            bool down = m->sides[f] != RIC_SIDES_UPPER && after[f] < -m->d[f] && before[f] >= -m->d[f];
            before[f] = after[f];
            if (!up && !down) continue;
            double lo = t - step, hi = t;
            while (hi - lo > 4e-16 * t) {
                double middle = (lo + hi) / 2;
                if (middle <= lo || middle >= hi) break;
                if (fabs(modal_gap(m, f, middle, q, p)) > m->d[f]) hi = middle;
                else lo = middle;
            }
            *contact = f;
            return hi;
        }
    return INFINITY;
}

static void compare_brute_force(const ric_model *model, int flights, double step, double end)
{
    int n = ric_model_n_dof(model);
    double x[MAX_N], v[MAX_N], q[MAX_N], p[MAX_N], t0 = 0;
    modal m = make_modal(model);
    ric_simulator *sim = simulator(model);
    ric_impact impact;
    random_state(model, 2, x, v);
    start(sim, x, v);
    for (int i = 0; i < flights; i++) {
        int contact = -1, hit_contact = -1;
        ric_simulator_state(sim, &t0, x, v);
        to_modal(&m, x, q);
        to_modal(&m, v, p);
        double expected = brute_force(&m, q, p, step, end, &contact);
        bool hit = advance(sim, t0 + end, &impact);
        if (!hit && expected == INFINITY) break;
        assert_true(hit);
        ric_model_face(model, impact.face, &hit_contact, NULL, NULL);
        if (impact.time - t0 < expected - step && impact.approach < 0.05) continue; /* the steps may miss a slow impact, never the simulator */
        assert_int_equal(hit_contact, contact);
        assert_true(fabs(impact.time - t0 - expected) <= 1e-11 * fmax(1, expected) / fmin(1, impact.approach));
    }
    assert_true(n > 0);
    ric_simulator_free(sim);
}

static void chain_of_fifty(void **state)
{
    (void)state;
    enum { N = 50 };
    static double M[N * N], K[N * N];
    double normal[2 * N] = {0};
    for (int i = 0; i < N; i++) {
        M[i * N + i] = 0.02;
        K[i * N + i] = 2 * 50;
        if (i) K[i * N + i - 1] = K[(i - 1) * N + i] = -50;
    }
    normal[N - 1] = 1;
    normal[N + 20] = 1;
    ric_contact contacts[] = {{.normal = normal, .clearance = 0.3}, {.normal = normal + N, .clearance = 0.4, .sides = RIC_SIDES_LOWER}};
    ric_model *model = make(N, M, K, 2, contacts, 1);
    seed_now = 50;
    compare_brute_force(model, 40, 2e-4, 3);
    ric_model_free(model);
}

static void tangle(void **state)
{
    (void)state;
    for (int n = 2; n <= 12; n++) {
        uint64_t seed = 7000u + (unsigned)n;
        print_message("tangle: n = %d, seed %llu\n", n, (unsigned long long)seed);
        ric_model *model = make_random(seed, n, n < 4 ? 2 : 4, 1);
        compare_brute_force(model, 60, 1e-3, 20);
        ric_model_free(model);
    }
}

/* Slow flights close to the stops, where sampling is easily fooled: no sample may lie beyond a stop before the impact found, and the
 * reach is the largest of the samples to their own accuracy. */
static void guarantee(void **state)
{
    (void)state;
    enum { SAMPLES = 4000 };
    for (int i = 0; i < 300; i++) {
        int n = 2 + i % 6;
        double x[MAX_N], v[MAX_N], q[MAX_N], p[MAX_N], most = 0, end = 30, second = 0;
        ric_model *model = make_random(20000u + (unsigned)i, n, 1 + i % 2, 1);
        modal m = make_modal(model);
        ric_simulator *sim = simulator(model);
        ric_impact impact = {0};
        random_state(model, 1.2, x, v);
        start(sim, x, v);
        bool hit = advance(sim, end, &impact);
        if (hit) end = impact.time;
        to_modal(&m, x, q);
        to_modal(&m, v, p);
        for (int f = 0; f < m.n_contact; f++) {
            for (int k = 0; k < n; k++) second += fabs(m.c[f * n + k]) * m.omega[k] * hypot(m.omega[k] * q[k], p[k]) / m.d[f];
            for (int k = 0; k < SAMPLES; k++) {
                double s = modal_gap(&m, f, end * k / SAMPLES, q, p) / m.d[f];
                assert_true(s <= 1 + 1e-12);
                if (m.sides[f] == RIC_SIDES_BOTH) assert_true(s >= -1 - 1e-12);
                double before = modal_gap(&m, f, end * (k - 1) / SAMPLES, q, p) / m.d[f];
                double after = modal_gap(&m, f, end * (k + 1) / SAMPLES, q, p) / m.d[f];
                double size = m.sides[f] == RIC_SIDES_UPPER ? s : fabs(s);
                if (k && k < SAMPLES - 1 && (s - before) * (after - s) <= 0 && (s - before) * s >= 0) most = fmax(most, size);
            }
        }
        double h = end / SAMPLES, reach = ric_simulator_reach(sim);
        assert_true(reach >= most - 1e-12);
        if (!hit && most > 0.5) assert_true(reach <= fmax(1, most + second * h * h) + 1e-9 || reach <= 1);
        ric_simulator_free(sim);
        ric_model_free(model);
    }
}

/* Stopping in between changes nothing: samples do not disturb the impacts. */
static void sampled(void **state)
{
    (void)state;
    ric_model *model = make_random(4242, 5, 2, 1);
    ric_simulator *sim = simulator(model), *other = simulator(model);
    double x[MAX_N], v[MAX_N], t = 0;
    ric_impact a, b;
    random_state(model, 3, x, v);
    start(sim, x, v);
    start(other, x, v);
    for (int i = 0; i < 200; i++) {
        assert_true(advance(sim, 1e9, &a));
        while (!advance(other, t, &b)) t += 0.0137;
        assert_memory_equal(&a.time, &b.time, sizeof a.time);
        assert_memory_equal(&a.approach, &b.approach, sizeof a.approach);
        assert_int_equal(a.face, b.face);
    }
    check_close(ric_simulator_reach(sim), ric_simulator_reach(other), 1e-12, "reach");
    ric_simulator_free(sim);
    ric_simulator_free(other);
    ric_model_free(model);
}

/* ---------------------------------------------------------- special events */

/* A light mass in front of a heavy one that presses it against its stop: it returns after 2u/a, and piles up its impacts if eps < 1. */
static ric_model *make_pressed(double restitution)
{
    double M[] = {1000, 0, 0, 1}, K[] = {2, -1, -1, 1}, normal[] = {0, 1};
    ric_contact contact = {.normal = normal, .clearance = 1};
    return make(2, M, K, 1, &contact, restitution);
}

static void quick_return(void **state)
{
    (void)state;
    ric_model *model = make_pressed(1);
    ric_simulator *sim = simulator(model);
    for (double u = 1; u > 1e-9; u /= 10) {
        double x[] = {5, 1}, v[] = {0, -u};
        ric_impact impact;
        start(sim, x, v);
        assert_true(advance(sim, 10, &impact));
        assert_int_equal(impact.face, 0);
        if (u < 1e-3) check_close(impact.time, 2 * u / 4, 1e-2 * u + 1e-6, "quick return");
        check_close(impact.approach, u, 1e-2 * u + 1e-6, "speed of the quick return");
    }
    ric_simulator_free(sim);
    ric_model_free(model);
}

static void chatter(void **state)
{
    (void)state;
    double x[] = {5, 0}, v[] = {0, 0}, x1[2], v1[2];
    for (int i = 0; i < 4; i++) {
        double eps = (double[]){0, 0.3, 0.8, 0.95}[i];
        ric_model *model = make_pressed(eps);
        ric_simulator *sim = simulator(model);
        ric_impact impact;
        ric_status status = RIC_OK;
        bool hit = true;
        int impacts = 0;
        start(sim, x, v);
        while (impacts < 2000 && hit && !(status = ric_simulator_advance(sim, 100, &hit, &impact))) impacts += hit;
        assert_int_equal(status, RIC_E_NUMERIC);
        assert_non_null(strstr(ric_detail(), eps > 0 ? "chatter" : "lasting contact"));
        assert_true(impacts >= 1 && impacts < 400);
        ric_simulator_state(sim, NULL, x1, v1);
        assert_true(fabs(fabs(x1[1]) - 1) < 1e-9 && fabs(v1[1]) < 1e-4);
        assert_int_equal(ric_simulator_advance(sim, 100, &hit, &impact), RIC_E_NUMERIC);
        ric_simulator_free(sim);
        ric_model_free(model);
    }
    ric_model *model = make_pressed(1); /* pressed at rest from the start */
    ric_simulator *sim = simulator(model);
    double rest[] = {5, 1};
    bool hit;
    start(sim, rest, v);
    assert_int_equal(ric_simulator_advance(sim, 1, &hit, NULL), RIC_E_NUMERIC);
    ric_simulator_free(sim);
    ric_model_free(model);
}

/* A perfectly plastic impact under an acceleration away from the stop leaves it again. */
static void plastic(void **state)
{
    (void)state;
    ric_model *model = make_one(1, 1, RIC_SIDES_BOTH, 0);
    ric_simulator *sim = simulator(model);
    double x = 0, v = 2;
    ric_impact impact;
    start(sim, &x, &v);
    assert_true(advance(sim, 100, &impact));
    check_close(impact.time, asin(0.5), 1e-14, "plastic impact");
    assert_false(advance(sim, 100, &impact));
    ric_simulator_state(sim, NULL, &x, &v);
    assert_true(fabs(x - cos(100 - asin(0.5))) < 1e-12);
    assert_true(fabs(ric_simulator_reach(sim) - 1) < 1e-14);
    ric_simulator_free(sim);
    ric_model_free(model);
}

static void together(void **state)
{
    (void)state;
    double M[] = {1, 0, 0, 1}, K[] = {0, 0, 0, 0}, normal[] = {1, 0, 1, 1}, across[] = {1, 0, 0, 1}, x[] = {0, 0}, v[] = {1, 0};
    ric_contact joined[] = {{.normal = normal, .clearance = 1}, {.normal = normal + 2, .clearance = 1}};
    ric_model *model = make(2, M, K, 2, joined, 1);
    ric_simulator *sim = simulator(model);
    bool hit = true;
    start(sim, x, v);
    for (int i = 0; i < 2; i++) {
        assert_int_equal(ric_simulator_advance(sim, 5, &hit, NULL), RIC_E_NUMERIC);
        assert_false(hit);
        assert_non_null(strstr(ric_detail(), "together"));
    }
    ric_simulator_free(sim);
    ric_model_free(model);

    ric_contact apart[] = {{.normal = across, .clearance = 1}, {.normal = across + 2, .clearance = 1}};
    ric_impact impact;
    v[1] = -1;
    model = make(2, M, K, 2, apart, 1); /* a corner of a room: both impacts happen, in either order */
    sim = simulator(model);
    start(sim, x, v);
    int faces = 0;
    for (int i = 0; i < 2; i++) {
        assert_true(advance(sim, 5, &impact));
        assert_true(fabs(impact.time - 1) < 1e-14);
        faces += impact.face;
    }
    assert_int_equal(faces, 0 + 3);
    ric_simulator_state(sim, NULL, x, v);
    assert_true(fabs(v[0] + 1) < 1e-14 && fabs(v[1] - 1) < 1e-14);
    ric_simulator_free(sim);
    ric_model_free(model);
}

/* An impact turns back the gap coordinate of another contact: that kink counts for the reach. */
static void kink(void **state)
{
    (void)state;
    double M[] = {1, 0, 0, 1}, K[] = {0, 0, 0, 0}, normal[] = {1, 0, 1, 0.5}, x[] = {0, 0}, v[] = {1, 0};
    ric_contact contacts[] = {{.normal = normal, .clearance = 1}, {.normal = normal + 2, .clearance = 1.25}};
    ric_model *model = make(2, M, K, 2, contacts, 1);
    ric_simulator *sim = simulator(model);
    start(sim, x, v);
    assert_true(advance(sim, 1.5, NULL));
    assert_true(ric_simulator_reach(sim) == 0.8);
    x[0] = -0.9; /* a start that is a largest value, and one that has just left its face and is none */
    v[0] = 0.5;
    start(sim, x, v);
    assert_false(advance(sim, 1, NULL));
    assert_true(ric_simulator_reach(sim) == 0.9);
    x[0] = -1;
    start(sim, x, v);
    assert_false(advance(sim, 1, NULL));
    assert_true(ric_simulator_reach(sim) == 0.8);
    ric_simulator_free(sim);
    ric_model_free(model);
}

static void wrong_calls(void **state)
{
    (void)state;
    ric_model *model = make_one(1, 1, RIC_SIDES_UPPER, 1);
    ric_simulator *sim = simulator(model);
    double x = 1.001, v = 0, inside = -7, nan = NAN;
    bool hit;
    assert_int_equal(ric_simulator_advance(sim, 1, &hit, NULL), RIC_E_INPUT);
    assert_int_equal(ric_simulator_start(sim, &x, &v), RIC_E_INPUT);
    assert_int_equal(ric_simulator_start(sim, &nan, &v), RIC_E_INPUT);
    assert_int_equal(ric_simulator_start(sim, &inside, &v), RIC_OK);
    assert_false(advance(sim, 1, NULL));
    assert_int_equal(ric_simulator_advance(sim, 0.5, &hit, NULL), RIC_E_INPUT);
    assert_int_equal(ric_simulator_advance(sim, NAN, &hit, NULL), RIC_E_INPUT);
    assert_int_equal(ric_simulator_advance(sim, INFINITY, &hit, NULL), RIC_E_INPUT);
    assert_true(advance(sim, 2, NULL));
    ric_simulator_free(sim);
    ric_simulator_free(NULL);
    ric_model_free(model);
}

/* ------------------------------------------------------------------ verify */

/* An atlas of one branch with the points given: `states` [n_point * 4], `flights` [n_point * max(impacts, 1)]. */
typedef struct {
    ric_atlas atlas;
    ric_branch_record record;
} one_branch;

static void make_atlas(one_branch *a, int impacts, const int *word, int n_point, const double *states, const double *flights)
{
    static const char text[] = "model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  contacts:\n"
                               "    - {normal: [-1, 1], clearance: 1, sides: both, law: rigid}\n";
    size_t n_flight = impacts ? (size_t)impacts : 1, stride = ric_point_stride(2, impacts);
    memset(a, 0, sizeof *a);
    if (ric_study_parse(text, "text", ".", &a->atlas.study)) fail_msg("%s", ric_detail());
    a->record.stride = stride;
    a->record.word = malloc(n_flight * sizeof *word);
    a->record.points = calloc((size_t)n_point * stride, sizeof(double));
    if (impacts) memcpy(a->record.word, word, n_flight * sizeof *word);
    a->record.row = (ric_branch){.id = 1, .label = "", .impacts = impacts, .word = a->record.word, .n_point = n_point};
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
    fail_msg("point %d: flight %.3g, return %.3g, condition %.3g, energy %.3g, faces %d", i, c.flight_error, c.return_error, c.condition,
             c.energy_error, c.faces_agree);
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
        double *at = a.record.points + (size_t)i * a.record.stride, *x = at + sizeof(ric_point) / sizeof *at, *tau = x + 4, kept;
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

/* S0 up to the energy at which it touches, where either no impact or one without speed is right; beyond, it is wrong. */
static void verify_linear(void **state)
{
    (void)state;
    double states[4 * 8], flights[8];
    ric_model *model = make_two();
    modal m = make_modal(model);
    one_branch a;
    for (int mode = 0; mode < 2; mode++) {
        for (int i = 0; i < 8; i++) {
            double A = (double[]){0, 1e-3, 0.5, 0.9, 0.999999, 1, 1, 1.0001}[i] / fabs(m.c[mode]), q[2] = {0}, p[2] = {0};
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_mass),     cmocka_unit_test(backbone),       cmocka_unit_test(touch),     cmocka_unit_test(free_modes),
        cmocka_unit_test(energy),       cmocka_unit_test(reversal),       cmocka_unit_test(restitution),
        cmocka_unit_test(chain_of_fifty), cmocka_unit_test(tangle),       cmocka_unit_test(guarantee), cmocka_unit_test(sampled),
        cmocka_unit_test(quick_return), cmocka_unit_test(chatter),        cmocka_unit_test(plastic),   cmocka_unit_test(together),
        cmocka_unit_test(kink),         cmocka_unit_test(wrong_calls),    cmocka_unit_test(verify_s2),
        cmocka_unit_test(verify_condition), cmocka_unit_test(verify_linear), cmocka_unit_test(verify_touches),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
