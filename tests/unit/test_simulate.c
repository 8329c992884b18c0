/* The simulator against closed forms, invariants, brute force and its own reversal. What it is
 * compared with is computed here or from ric_model_modes, which it does not use. */
#include "sample.h"
#include "simulated_models.h"

/* ------------------------------------------------------------- closed forms */

/* x = cos between two stops, and against one: tau = 2 asin(1/A) / omega, or the period less 2
 * acos(1/A) / omega. */
static void one_mass(void **state)
{
    (void)state;
    for (int sides = 0; sides < 2; sides++)
        for (int i = 0; i <= 40; i++) {
            double m = 0.7, k = 3.1, omega = sqrt(k / m), v0 = pow(10, -3 + i * 0.2),
                   A = hypot(1, v0 / omega);
            ric_model *model = make_one(m, k, sides ? RIC_SIDES_UPPER : RIC_SIDES_BOTH, 1);
            ric_simulator *sim = simulator(model);
            double x = 1, v = -v0,
                   tau = sides ? 2 * (PI - atan(v0 / omega)) / omega : 2 * asin(1 / A) / omega;
            ric_impact impact;
            start(sim, &x, &v);
            for (int k_impact = 1; k_impact <= 100; k_impact++) {
                assert_true(advance(sim, 1e9, &impact));
                check_close(impact.time, k_impact * tau, 1e-11, "time of impact");
                double rounding = 1e-12 +
                                  1e-13 * k / (m * v0 * v0); /* the energy's, of which a slow mass
                                                                on the stop has little in motion */
                check_close(impact.approach, v0, rounding, "approach");
                check_close(impact.impulse, 2 * v0 * m, rounding, "impulse");
                assert_int_equal(impact.face, sides ? 0 : k_impact % 2);
            }
            assert_true(ric_simulator_reach(sim) < 1);
            ric_simulator_free(sim);
            ric_model_free(model);
        }
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
                double q[MAX_N] = {0}, p[MAX_N] = {0}, x[MAX_N], v[MAX_N], A = 1 / fabs(m.c[i]),
                       T = 2 * PI / m.omega[i];
                if (A > 5)
                    continue; /* the modes are not known well enough for such a state to touch */
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

/* A loose mass in a gap flies straight; a floating pair strikes its inner stop, its centre of mass
 * moves on. */
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

    double M[] = {1, 0, 0, 3}, K[] = {2, -2, -2, 2}, normal[] = {-1, 1}, x2[] = {5, 5},
           v2[] = {1, 4}, t, x3[2], v3[2];
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
    for (int n = 1; n <= 12; n += every_of(2)) {
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

/* One flight, velocities turned round: the impact is undone at once, then the flight is flown back.
 */
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
            assert_true(fabs(before - after -
                             (1 - eps * eps) * impact.approach * impact.approach /
                                 (2 * cc[n - 1])) <= 1e-12 * before);
        }
        ric_simulator_free(sim);
        ric_model_free(model);
    }
}

/* ------------------------------------------------------------- brute force */

/* First impact by steps far below the shortest period, then bisection. */
static double brute_force(const modal *m, const double *q, const double *p, double step, double end,
                          int *contact)
{
    double before[MAX_CONTACT], after[MAX_CONTACT];
    for (int f = 0; f < m->n_contact; f++) before[f] = modal_gap(m, f, step * 1e-3, q, p);
    for (double t = step; t < end; t += step)
        for (int f = 0; f < m->n_contact; f++) {
            after[f] = modal_gap(m, f, t, q, p);
            bool up = m->sides[f] != RIC_SIDES_LOWER && after[f] > m->d[f] && before[f] <= m->d[f];
            bool down = m->sides[f] != RIC_SIDES_UPPER && after[f] < -m->d[f] &&
                        before[f] >= -m->d[f];
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
        /* the steps may miss a slow impact, never the simulator */
        if (impact.time - t0 < expected - step && impact.approach < 0.05) continue;
        assert_int_equal(hit_contact, contact);
        assert_true(fabs(impact.time - t0 - expected) <=
                    1e-11 * fmax(1, expected) / fmin(1, impact.approach));
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
    ric_contact contacts[] = {{.normal = normal, .clearance = 0.3},
                              {.normal = normal + N, .clearance = 0.4, .sides = RIC_SIDES_LOWER}};
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

/* Slow flights close to the stops, where sampling is easily fooled: no sample may lie beyond a stop
 * before the impact found, and the reach is the largest of the samples to their own accuracy. */
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
            for (int k = 0; k < n; k++)
                second += fabs(m.c[f * n + k]) * m.omega[k] * hypot(m.omega[k] * q[k], p[k]) /
                          m.d[f];
            for (int k = 0; k < SAMPLES; k++) {
                double s = modal_gap(&m, f, end * k / SAMPLES, q, p) / m.d[f];
                assert_true(s <= 1 + 1e-12);
                if (m.sides[f] == RIC_SIDES_BOTH) assert_true(s >= -1 - 1e-12);
                double before = modal_gap(&m, f, end * (k - 1) / SAMPLES, q, p) / m.d[f];
                double after = modal_gap(&m, f, end * (k + 1) / SAMPLES, q, p) / m.d[f];
                double size = m.sides[f] == RIC_SIDES_UPPER ? s : fabs(s);
                if (k && k < SAMPLES - 1 && (s - before) * (after - s) <= 0 &&
                    (s - before) * s >= 0)
                    most = fmax(most, size);
            }
        }
        double h = end / SAMPLES, reach = ric_simulator_reach(sim);
        assert_true(reach >= most - 1e-12);
        if (!hit && most > 0.5)
            assert_true(reach <= fmax(1, most + second * h * h) + 1e-9 || reach <= 1);
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

/* A light mass in front of a heavy one that presses it against its stop: it returns after 2u/a, and
 * piles up its impacts if eps < 1. */
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
        while (impacts < 2000 && hit && !(status = ric_simulator_advance(sim, 100, &hit, &impact)))
            impacts += hit;
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
    double M[] = {1, 0, 0, 1}, K[] = {0, 0, 0, 0}, normal[] = {1, 0, 1, 1}, across[] = {1, 0, 0, 1},
           x[] = {0, 0}, v[] = {1, 0};
    ric_contact joined[] = {{.normal = normal, .clearance = 1},
                            {.normal = normal + 2, .clearance = 1}};
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

    ric_contact apart[] = {{.normal = across, .clearance = 1},
                           {.normal = across + 2, .clearance = 1}};
    ric_impact impact;
    v[1] = -1;
    model = make(2, M, K, 2, apart,
                 1); /* a corner of a room: both impacts happen, in either order */
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
    double M[] = {1, 0, 0, 1}, K[] = {0, 0, 0, 0}, normal[] = {1, 0, 1, 0.5}, x[] = {0, 0},
           v[] = {1, 0};
    ric_contact contacts[] = {{.normal = normal, .clearance = 1},
                              {.normal = normal + 2, .clearance = 1.25}};
    ric_model *model = make(2, M, K, 2, contacts, 1);
    ric_simulator *sim = simulator(model);
    start(sim, x, v);
    assert_true(advance(sim, 1.5, NULL));
    assert_true(ric_simulator_reach(sim) == 0.8);
    x[0] =
        -0.9; /* a start that is a largest value, and one that has just left its face and is none */
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_mass),    cmocka_unit_test(backbone),
        cmocka_unit_test(touch),       cmocka_unit_test(free_modes),
        cmocka_unit_test(energy),      cmocka_unit_test(reversal),
        cmocka_unit_test(restitution), cmocka_unit_test(chain_of_fifty),
        cmocka_unit_test(tangle),      cmocka_unit_test(guarantee),
        cmocka_unit_test(sampled),     cmocka_unit_test(quick_return),
        cmocka_unit_test(chatter),     cmocka_unit_test(plastic),
        cmocka_unit_test(together),    cmocka_unit_test(kink),
        cmocka_unit_test(wrong_calls),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
