/* Exact forced orbits: against a simulation of the shaken structure by Runge and Kutta's method,
 * the closed form of one mass between stops, and the order with which the prediction approaches
 * them. */
#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/room.h"
#include "explored.h"
#include "force/force_medium.h"

enum { MOST = 10, LETTERS = 32 };

static const double two_pi = 6.283185307179586;

#define WINDOW                                                                                     \
    "explore: {energy: [0, 12], frequency: [0.5, 6], impacts: 2, multiply: 1, depth: 1}\n"
static const char *const two_masses =
    "title: t\nmodel:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  contacts:\n"
    "    - {normal: [-1, 1], clearance: 1, sides: both, law: rigid}\n" WINDOW;
#define THREE_MASS                                                                                 \
    "title: t\nmodel:\n  mass: [[1, 0, 0], [0, 1.3, 0], [0, 0, 0.7]]\n  stiffness: [[3, -1, 0], "  \
    "[-1, 3, -1], [0, -1, "                                                                        \
    "2]]\n  contacts:\n    - {normal: [0, 0, 1], "
static const char *const three_masses = THREE_MASS
    "clearance: 0.4, sides: upper, law: rigid}\n" WINDOW;
static const char *const three_spring = THREE_MASS
    "clearance: 0.4, sides: upper, law: bilinear, stiffness: 3}\n" WINDOW;
static const char *const three_cubic = THREE_MASS "law: power, exponent: 3, stiffness: 2}\n" WINDOW;
static const char
    *const one_mass = "title: t\nmodel:\n  mass: [[1]]\n  stiffness: [[1]]\n  contacts:\n"
                      "    - {normal: [1], clearance: 1, sides: both, law: rigid}\n" WINDOW;
static const char *const cubic =
    "title: t\nmodel:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  contacts:\n"
    "    - {normal: [-1, 1], law: power, exponent: 3, stiffness: 2}\n" WINDOW;
static const char *const spring =
    "title: t\nmodel:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  contacts:\n"
    "    - {normal: [-1, 1], clearance: 0.5, sides: both, law: bilinear, stiffness: 30}\n" WINDOW;

/* A chain of ten; each on a spring to the ground, too, where a cubic spring would be in resonance
 * with modes at odd multiples. */
#define TEN_MASS                                                                                   \
    "title: t\nmodel:\n  mass: [[1.0, 0, 0, 0, 0, 0, 0, 0, 0, 0], [0, 1.03, 0, 0, 0, 0, 0, 0, 0, " \
    "0], [0, "                                                                                     \
    "0, 1.06, 0, 0, 0, 0, 0, 0, 0], [0, 0, 0, 1.09, 0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 1.12, 0, 0, "  \
    "0, 0, "                                                                                       \
    "0], [0, 0, 0, 0, 0, 1.15, 0, 0, 0, 0], [0, 0, 0, 0, 0, 0, 1.18, 0, 0, 0], [0, 0, 0, 0, 0, "   \
    "0, 0, "                                                                                       \
    "1.21, 0, 0], [0, 0, 0, 0, 0, 0, 0, 0, 1.24, 0], [0, 0, 0, 0, 0, 0, 0, 0, 0, 1.27]]\n"
#define TEN_STIFFNESS(k, last)                                                                     \
    "  stiffness: [[" k ", -1, 0, 0, 0, 0, 0, 0, 0, 0], [-1, " k                                   \
    ", -1, 0, 0, 0, 0, 0, 0, 0], [0, -1, " k ", -1, 0, 0, 0, 0, 0, 0], [0, 0, -1, " k              \
    ", -1, 0, 0, 0, 0, 0], [0, 0, 0, -1, " k ", -1, 0, 0, 0, 0], [0, 0, 0, "                       \
    "0, -1, " k ", -1, 0, 0, 0], [0, 0, 0, 0, 0, -1, " k ", -1, 0, 0], [0, 0, 0, 0, 0, 0, -1, " k  \
    ", -1, 0], [0, 0, 0, 0, 0, 0, 0, -1, " k ", -1], [0, 0, 0, 0, 0, 0, 0, 0, -1, " last "]]\n"
#define TEN_CONTACT "  contacts:\n    - {normal: [0, 0, 0, 0, 0, 0, 0, 0, 0, 1], "
#define TEN_WINDOW                                                                                 \
    "explore: {start: [1], energy: [0, 2], frequency: [0.1, 6], impacts: 1, multiply: 1, depth: "  \
    "1}\n"
static const char *const ten_masses = TEN_MASS TEN_STIFFNESS("2", "1") TEN_CONTACT
    "clearance: 1, sides: upper, law: rigid}\n" TEN_WINDOW;
static const char *const ten_spring = TEN_MASS TEN_STIFFNESS("2", "1") TEN_CONTACT
    "clearance: 1, sides: upper, law: bilinear, stiffness: 2}\n" TEN_WINDOW;
static const char *const ten_cubic = TEN_MASS TEN_STIFFNESS("3", "2") TEN_CONTACT
    "law: power, exponent: 3, stiffness: 2}\nexplore: {start: [1], energy: [0, 0.5], frequency: "
    "[0.5, 2], multiply: 1, "
    "depth: 1}\n";

/* What is shaken, and one orbit of it. */
typedef struct {
    const ric_model *model;
    int n, id;
    double zeta, e, f[MOST], level,
        couple; /* couple: added to the damping matrix at the first displacement */
    ric_force *force;
    ric_orbit **orbits;
    ric_prediction p;
} subject;

typedef struct {
    ric_forced data;
    double state[2 * MOST], flights[LETTERS], multipliers[4 * MOST];
} forced;

/* C = M Phi diag(2 zeta omega) Phi' M, M diagonal, and what couples modes. */
static void damping_of(const ric_model *model, double zeta, double couple, double *C)
{
    const double *M = ric_model_mass(model);
    double omega[MOST], Phi[MOST * MOST];
    const int n = ric_model_n_dof(model);
    ric_model_frequencies(model, omega);
    ric_model_modes(model, Phi);
    for (int a = 0; a < n; a++)
        for (int b = 0; b < n; b++) {
            C[a * n + b] = a == 0 && b == 0 ? couple : 0;
            for (int i = 0; i < n; i++)
                C[a * n + b] += M[a * n + a] * Phi[a * n + i] * 2 * zeta * omega[i] *
                                Phi[b * n + i] * M[b * n + b];
        }
}

static subject coupled(const ric_atlas *atlas, const char *label, double energy, double zeta,
                       double couple, double e, double times)
{
    subject s = {.model = ric_atlas_model(atlas),
                 .zeta = zeta,
                 .e = e,
                 .f = {1, -0.3, 0.2},
                 .couple = couple};
    double C[MOST * MOST];
    int n = 0;
    s.n = ric_model_n_dof(s.model);
    if (!ric_model_n_face(s.model))
        s.f[1] = 1; /* the first force hardly works on the lower mode of the cubic spring */
    damping_of(s.model, zeta, couple, C);
    const ric_shaking shaking = {.n_force = s.n,
                                 .force = s.f,
                                 .n_ratio = !couple,
                                 .ratios = couple ? NULL : &zeta,
                                 .n_matrix = couple ? s.n : 0,
                                 .matrix = couple ? C : NULL,
                                 .restitution = e};
    if (ric_force_create(atlas, &shaking, &s.force)) fail_msg("%s", ric_detail());
    for (int id = 1; id <= ric_atlas_n_branch(atlas) && !n; id++) {
        s.id = id;
        if (strncmp(branch_of(atlas, id).label, label, strlen(label)) != 0) continue;
        assert_int_equal(ric_orbit_find(atlas, id, RIC_AT_ENERGY, energy, &n, &s.orbits), RIC_OK);
    }
    if (n != 1) fail_msg("%d orbits %s of energy %g", n, label, energy);
    assert_int_equal(ric_force_predict(s.force, s.id, s.orbits[0], 1, 0, &s.p), RIC_OK);
    s.level = times * s.p.threshold;
    assert_int_equal(ric_force_predict(s.force, s.id, s.orbits[0], 1, s.level, &s.p), RIC_OK);
    assert_int_equal(s.p.n_phase, 2);
    return s;
}

static subject subject_of(const ric_atlas *atlas, const char *label, double energy, double zeta,
                          double e, double times)
{
    return coupled(atlas, label, energy, zeta, 0, e, times);
}

static void release(subject *s)
{
    ric_orbits_free(1, s->orbits);
    ric_force_free(s->force);
}

static forced solved(const subject *s, int k)
{
    forced x;
    if (ric_force_solve(s->force, s->orbits[0], 1, s->level, s->p.phases[k], &x.data, x.state,
                        x.flights, x.multipliers))
        fail_msg("%s", ric_detail());
    if (*x.data.fault) fail_msg("%s", x.data.fault);
    assert_true(x.data.residual < 1e-13);
    return x;
}

/* ---------------------------------------------------------------- simulation */

typedef struct {
    const subject *s;
    double C[MOST * MOST], Omega, phase;
    int impacts;
    bool closed[MOST]; /* springs */
} shaker;

static shaker shaker_of(const subject *s, double phase)
{
    shaker out = {.s = s, .Omega = s->p.omega, .phase = phase};
    damping_of(s->model, s->zeta, s->couple, out.C);
    return out;
}

/* side * s, its speed, and the clearance, of a face. */
static double gap_of(const shaker *h, int face, const double *y, double *speed, ric_contact *c,
                     int *side)
{
    int contact;
    double s = 0;
    *speed = 0;
    ric_model_face(h->s->model, face, &contact, side, NULL);
    ric_model_contact(h->s->model, contact, c);
    for (int i = 0; i < h->s->n; i++) {
        s += *side * c->normal[i] * y[i];
        *speed += *side * c->normal[i] * y[h->s->n + i];
    }
    return s - c->clearance / ric_model_length(h->s->model);
}

/* What springs add to the accelerations. */
static void springs(const shaker *h, const double *y, double *dv)
{
    const double *M = ric_model_mass(h->s->model), d = ric_model_length(h->s->model);
    const int n = h->s->n;
    ric_contact c;
    for (int f = 0; f < ric_model_n_face(h->s->model); f++) {
        double speed;
        int side;
        if (!h->closed[f]) continue;
        const double beyond = gap_of(h, f, y, &speed, &c, &side);
        for (int i = 0; i < n; i++)
            dv[i] -= c.stiffness * side * beyond * c.normal[i] / M[i * n + i];
    }
    for (int k = 0; ric_model_n_face(h->s->model) == 0 && k < ric_model_n_contact(h->s->model);
         k++) {
        double s = 0;
        ric_model_contact(h->s->model, k, &c);
        for (int i = 0; i < n; i++) s += c.normal[i] * y[i] * d;
        for (int i = 0; i < n; i++)
            dv[i] -= c.stiffness * pow(s, c.exponent) / d * c.normal[i] / M[i * n + i];
    }
}

static void rate(const shaker *h, double t, const double *y, double *dy)
{
    const int n = h->s->n;
    const double *M = ric_model_mass(h->s->model), *K = ric_model_stiffness(h->s->model),
                 push = h->s->level / ric_model_length(h->s->model) * cos(h->Omega * t + h->phase);
    for (int a = 0; a < n; a++) {
        double sum = h->s->f[a] * push;
        for (int b = 0; b < n; b++) sum -= K[a * n + b] * y[b] + h->C[a * n + b] * y[n + b];
        dy[a] = y[n + a];
        dy[n + a] = sum / M[a * n + a];
    }
    springs(h, y, dy + n);
}

static void step(const shaker *h, double t, double dt, const double *y, double *out)
{
    const int n = 2 * h->s->n;
    double k[4][2 * MOST], z[2 * MOST];
    static const double at[] = {0, 0.5, 0.5, 1};
    for (int j = 0; j < 4; j++) {
        for (int i = 0; i < n; i++) z[i] = y[i] + (j ? at[j] * dt * k[j - 1][i] : 0);
        rate(h, t + at[j] * dt, z, k[j]);
    }
    for (int i = 0; i < n; i++)
        out[i] = y[i] + dt / 6 * (k[0][i] + 2 * k[1][i] + 2 * k[2][i] + k[3][i]);
}

/* How far a state is beyond an event of the face: into a stop, or a spring that is open; out of one
 * that is closed. */
static double beyond(const shaker *h, int face, const double *y)
{
    ric_contact c;
    int side;
    double speed;
    const double s = gap_of(h, face, y, &speed, &c, &side);
    if (h->closed[face]) return -s;
    return c.law == RIC_LAW_BILINEAR || speed > 0 ? s : -1;
}

static void hit(shaker *h, int face, double *y)
{
    int contact;
    ric_contact c;
    const int n = h->s->n;
    const double *M = ric_model_mass(h->s->model);
    double v = 0, cc = 0;
    ric_model_face(h->s->model, face, &contact, NULL, NULL);
    ric_model_contact(h->s->model, contact, &c);
    h->impacts++;
    if (c.law == RIC_LAW_BILINEAR) {
        h->closed[face] = !h->closed[face];
        return;
    }
    for (int i = 0; i < n; i++) {
        v += c.normal[i] * y[n + i];
        cc += c.normal[i] * c.normal[i] / M[i * n + i];
    }
    for (int i = 0; i < n; i++) y[n + i] -= (1 + h->s->e) * v / cc * c.normal[i] / M[i * n + i];
}

/* From t to the end, in steps of a thousandth or so; impacts by bisection of the step. */
static void simulate(shaker *h, double t, double end, double *y)
{
    double z[2 * MOST];
    while (t < end) {
        double dt = fmin(1e-3, end - t);
        int face = -1;
        step(h, t, dt, y, z);
        for (int f = 0; f < ric_model_n_face(h->s->model); f++)
            if (beyond(h, f, z) > 0) face = f;
        if (face >= 0) {
            double low = 0, high = dt;
            for (int k = 0; k < 60; k++) {
                dt = (low + high) / 2;
                step(h, t, dt, y, z);
                if (beyond(h, face, z) > 0) high = dt;
                else low = dt;
            }
            hit(h, face, z);
        }
        memcpy(y, z, sizeof z);
        t = end - t <= dt ? end : t + dt;
    }
}

/* The orbit returns, with its impacts; its multipliers are those of the differenced map from a
 * third of the first flight on, one period. */
static void is_motion(const subject *s, const forced *x)
{
    const int n = 2 * s->n;
    const double T = two_pi / s->p.omega, begin = x->flights[0] / 3;
    double y[2 * MOST], z[2 * MOST], X[4 * MOST * MOST], mu[4 * MOST], largest = 0;
    shaker h = shaker_of(s, x->data.phase);
    memcpy(y, x->state, sizeof y);
    if (ric_model_n_face(s->model)) { /* a word of springs starts where the first one closes */
        int word[LETTERS];
        ric_contact c;
        int contact;
        ric_orbit_data(s->orbits[0], NULL, NULL, NULL, word);
        ric_model_face(s->model, word[0], &contact, NULL, NULL);
        ric_model_contact(s->model, contact, &c);
        h.closed[word[0]] = c.law == RIC_LAW_BILINEAR;
    }
    simulate(&h, 0, begin, y);
    memcpy(z, y, sizeof z);
    h.impacts = 0;
    simulate(&h, begin, begin + T, z);
    assert_int_equal(h.impacts, ric_model_n_face(s->model) ? ric_orbit_letters(s->orbits[0]) : 0);
    for (int i = 0; i < n; i++)
        if (!(fabs(z[i] - y[i]) < 1e-9))
            fail_msg("coordinate %d returns off by %.3g", i, z[i] - y[i]);
    for (int j = 0; j < n; j++) {
        double side[2][2 * MOST];
        for (int k = 0; k < 2; k++) {
            memcpy(side[k], y, sizeof y);
            side[k][j] += k ? 1e-5 : -1e-5;
            simulate(&h, begin, begin + T, side[k]);
        }
        for (int i = 0; i < n; i++) X[i * n + j] = (side[1][i] - side[0][i]) / 2e-5;
    }
    assert_true(ric_eigen(n, X, mu));
    for (int i = 0; i < n; i++) {
        double nearest = INFINITY;
        for (int k = 0; k < n; k++)
            nearest = fmin(nearest, hypot(mu[2 * i] - x->multipliers[2 * k],
                                          mu[2 * i + 1] - x->multipliers[2 * k + 1]));
        if (!(nearest < 1e-5))
            fail_msg("multiplier %.8g %+.8gi is off by %.3g", mu[2 * i], mu[2 * i + 1], nearest);
        largest = fmax(largest, hypot(mu[2 * i], mu[2 * i + 1]));
    }
    assert_true(fabs(largest - x->data.largest) < 1e-5);
}

static void test_simulated(void **state)
{
    (void)state;
    static const struct {
        const char *study, *label;
        double energy, zeta, e, couple;
    } cases[] = {{two_masses, "S2+[01]", 1, 0.001, 1, 0},
                 {two_masses, "S2+[01]", 1, 0.001, 0.999, 0.003},
                 {spring, "S2+", 1.5, 0.001, 1, 0},
                 {spring, "S2-", 3.2, 0.0005, 1, 0.002},
                 {cubic, "S+", 1, 0.001, 1, 0},
                 {cubic, "S-", 2, 0.001, 1, 0.002},
                 {two_masses, "S2+[01]", 1, 0.0005, 0.999, 0},
                 {two_masses, "S2-[01]", 3.2, 0.002, 1, 0},
                 {three_masses, "A1(1)[0]", 2.2, 0.001, 0.998, 0},
                 {one_mass, "S2(1)[01]", 3, 0.01, 0.98, 0}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        ric_atlas *atlas = explore_text(cases[i].study);
        subject s = coupled(atlas, cases[i].label, cases[i].energy, cases[i].zeta, cases[i].couple,
                            cases[i].e, 1.3);
        for (int k = 0; k < 2; k++) {
            const forced x = solved(&s, k);
            is_motion(&s, &x);
            if (k == 1 && x.data.stable != RIC_STABLE_NO)
                fail_msg("case %zu: the saddle is stable", i);
            else if (k == 0 && s.p.trusted && s.p.stable == RIC_STABLE_YES &&
                     x.data.stable != RIC_STABLE_YES)
                fail_msg("case %zu: the largest multiplier is %.10g", i, x.data.largest);
        }
        release(&s);
        ric_atlas_free(atlas);
    }
}

/* ------------------------------------------------------------------- numbers */

static void test_two_masses(void **state)
{
    (void)state;
    ric_atlas *atlas = explore_text(two_masses);
    subject s = subject_of(atlas, "S2+[01]", 1, 0.001, 1, 1.3);
    ric_force_free(s.force);
    const double f[] = {1, 0};
    const ric_shaking shaking = {.n_force = 2,
                                 .force = f,
                                 .n_ratio = 1,
                                 .ratios = &s.zeta,
                                 .restitution = 1};
    assert_int_equal(ric_force_create(atlas, &shaking, &s.force), RIC_OK);
    assert_int_equal(ric_force_predict(s.force, s.id, s.orbits[0], 1, 0, &s.p), RIC_OK);
    s.level = 1.3 * s.p.threshold;
    assert_int_equal(ric_force_predict(s.force, s.id, s.orbits[0], 1, s.level, &s.p), RIC_OK);
    const forced centre = solved(&s, 0), saddle = solved(&s, 1);
    assert_true(fabs(centre.data.largest - 0.9935) < 5e-5 && centre.data.stable == RIC_STABLE_YES);
    assert_true(fabs(saddle.data.largest - 1.1293) < 5e-5 && saddle.data.stable == RIC_STABLE_NO);
    release(&s);
    ric_atlas_free(atlas);
}

/* q = 1, v = -u right after the upper stop; half a period h on q = -1, v = -u / e. With the steady
 * answer (a, b) there, and
 * -(a, b) half a period on: (a - 1, b - u / e) = R (1 - a, -u - b), linear in a, b and u, and a^2 +
 * (b / Omega)^2 = |A|^2: a quadratic equation for u. */
static void closed_form(const subject *s, double u[2])
{
    const double delta = s->zeta, root = sqrt(1 - delta * delta), Omega = s->p.omega,
                 h = two_pi / Omega / 2, decay = exp(-delta * h), c = decay * cos(root * h),
                 S = decay * sin(root * h) / root, r[4] = {c + delta * S, S, -S, c - delta * S};
    const double A = s->level / hypot(1 - Omega * Omega, 2 * delta * Omega);
    const double m[4] = {1 + r[0], r[1], r[2], 1 + r[3]}, det = m[0] * m[3] - m[1] * m[2];
    const double one[2] = {1 + r[0], r[2]}, by_u[2] = {-r[1], 1 / s->e - r[3]};
    const double a0 = (m[3] * one[0] - m[1] * one[1]) / det,
                 a1 = (m[3] * by_u[0] - m[1] * by_u[1]) / det,
                 b0 = (m[0] * one[1] - m[2] * one[0]) / det / Omega,
                 b1 = (m[0] * by_u[1] - m[2] * by_u[0]) / det / Omega;
    const double p = a1 * a1 + b1 * b1, q = a0 * a1 + b0 * b1, w = a0 * a0 + b0 * b0 - A * A,
                 R = sqrt(q * q - p * w);
    u[0] = (-q + R) / p;
    u[1] = (-q - R) / p;
}

static void test_one_mass(void **state)
{
    (void)state;
    ric_atlas *atlas = explore_text(one_mass);
    for (int i = 0; i < 3; i++) {
        subject s = subject_of(atlas, "S2(1)[01]", 1.5 + i, 0.002 * (i + 1), 0.99, 1.2);
        const double a = fabs(solved(&s, 0).state[1]), b = fabs(solved(&s, 1).state[1]);
        double u[2];
        closed_form(&s, u);
        const bool same = fabs(a - u[0]) < fabs(a - u[1]);
        if (!(fabs(a / u[!same] - 1) < 1e-12 && fabs(b / u[same] - 1) < 1e-12))
            fail_msg("%.16g %.16g, closed form %.16g %.16g", a, b, u[0], u[1]);
        release(&s);
    }
    ric_atlas_free(atlas);
}

/* Losses and force halved six times: the exact orbit comes nearer by a half each time. `from`:
 * halvings before; an orbit of the atlas that all but grazes has forced orbits beside it for small
 * losses only. */
static void test_order(void **state)
{
    (void)state;
    static const struct {
        const char *study, *label;
        double energy, loss;
        int from;
    } cases[] = {{two_masses, "S2+[01]", 1, 0.002, 0},
                 {two_masses, "S2-[01]", 3.2, 0.002, 0},
                 {three_masses, "A1(1)[0]", 2.2, 0.002, 0},
                 {three_spring, "A1(1)[0]", 4, 0, 0},
                 {three_cubic, "S(1)", 2, 0, 0},
                 {ten_masses, "A1(1)[0]", 0.065, 0.002, 0},
                 {ten_masses, "A1(1)[0]", 0.0673, 0.002, 1},
                 {ten_masses, "A1(1)[0]", 0.07, 0.002, 4},
                 {ten_spring, "A1(1)[0]", 0.065, 0, 0},
                 {ten_cubic, "S(1)", 0.2, 0, 0},
                 {spring, "S2+", 1.5, 0, 0},
                 {cubic, "S+", 1, 0, 0}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        ric_atlas *atlas = explore_text(cases[i].study);
        double last[2] = {NAN, NAN};
        for (int k = cases[i].from; k < cases[i].from + 7; k++) {
            const double e = 1 - ldexp(cases[i].loss, -k);
            subject s = subject_of(atlas, cases[i].label, cases[i].energy, ldexp(0.001, -k), e,
                                   1.3);
            for (int j = 0; j < 2; j++) {
                const forced x = solved(&s, j);
                const double slope = log2(last[j] / x.data.distance);
                last[j] = x.data.distance;
                const double off = k == cases[i].from + 6 ? 0.02 : 0.1;
                if (k > cases[i].from + 2 && !(fabs(slope - 1) < off))
                    fail_msg("case %zu, %s phase %d: slope %g", i, cases[i].label, j, slope);
            }
            release(&s);
        }
        ric_atlas_free(atlas);
    }
}

/* A state right after an impact may lie beyond its stop by rounding: it leaves, and is not struck
 * again. */
static void test_start_on_a_stop(void **state)
{
    (void)state;
    const double one = 1, x[] = {nextafter(1, 2), -nextafter(1, 2)}, v[] = {-2, 2};
    const ric_contact contact = {.normal = &one, .clearance = 1};
    const ric_shaking shaking = {.restitution = 0.9};
    ric_model *model = NULL;
    ric_shaken *s = NULL;
    assert_int_equal(ric_model_create(1, &one, &one, 1, &contact, 1, &model), RIC_OK);
    assert_int_equal(ric_shaken_create(model, &shaking, 1, 0, &s), RIC_OK);
    for (int k = 0; k < 2; k++) {
        ric_impact impact;
        bool hit = false;
        assert_int_equal(ric_shaken_start(s, &x[k], &v[k], 0), RIC_OK);
        assert_int_equal(ric_shaken_advance(s, 10, &hit, &impact), RIC_OK);
        /* from one stop to the other: tan(t / 2) = 1 / 2 */
        assert_true(hit && impact.face == 1 - k && fabs(impact.time - 2 * atan(0.5)) < 1e-14);
    }
    ric_shaken_free(s);
    ric_model_free(model);
}

/* ------------------------------------------------------------------ refusals */

static void refuses(const subject *s, const ric_force *force, double level, ric_status wanted,
                    const char *words)
{
    forced x;
    assert_int_equal(ric_force_solve(force, s->orbits[0], 1, level, 0, &x.data, x.state, x.flights,
                                     x.multipliers),
                     wanted);
    if (!strstr(ric_detail(), words)) fail_msg("no '%s' in: %s", words, ric_detail());
}

static void test_refused(void **state)
{
    (void)state;
    ric_atlas *atlas = explore_text(two_masses);
    subject s = subject_of(atlas, "S2+[01]", 1, 0.001, 1, 1.3),
            mode = subject_of(atlas, "S0+", 0.3, 0.001, 1, 1.3);
    refuses(&s, s.force, 0, RIC_E_INPUT, "level");
    refuses(&mode, mode.force, 1, RIC_E_INPUT, "linear mode");
    release(&s);
    release(&mode);
    ric_atlas_free(atlas);
}

/* A force at the frequency of a mode without damping, which an orbit of S2- below omega_2 passes
 * with its harmonic. */
static void test_resonance(void **state)
{
    (void)state;
    ric_atlas *atlas = explore_text(two_masses);
    const double f[] = {1, 0}, ratios[] = {0.001, 0};
    ric_force *force = NULL;
    ric_orbit **orbits;
    double omega[2];
    int n = 0, tried = 0;
    const ric_shaking shaking = {.n_force = 2,
                                 .force = f,
                                 .n_ratio = 2,
                                 .ratios = ratios,
                                 .restitution = 1};
    ric_model_frequencies(ric_atlas_model(atlas), omega);
    assert_int_equal(ric_force_create(atlas, &shaking, &force), RIC_OK);
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        if (strcmp(branch_of(atlas, id).label, "S2+[01]") != 0) continue;
        assert_int_equal(ric_orbit_find(atlas, id, RIC_AT_FREQUENCY, omega[1] / 2, &n, &orbits),
                         RIC_OK);
        for (int i = 0; i < n; i++) {
            forced x;
            assert_int_equal(ric_force_solve(force, orbits[i], 2, 0.01, 0, &x.data, x.state,
                                             x.flights, x.multipliers),
                             RIC_E_NUMERIC);
            assert_non_null(strstr(ric_detail(), "not damped"));
            tried++;
        }
        ric_orbits_free(n, orbits);
    }
    assert_true(tried > 0);
    ric_force_free(force);
    ric_atlas_free(atlas);
}

/* ------------------------------------------------------------ large damping */

/* A mode that starts at rest in its place with speed 1: e^{-delta t} sinh(r t)/r, r^2 = delta^2 -
 * omega^2, whose series knows no difference of exponentials. */
static void test_nearly_critical(void **state)
{
    (void)state;
    for (double beyond = 1e-14; beyond < 1e-3; beyond *= 3) {
        const double delta = 1 + beyond, t = 1.3, x = (delta - 1) * (delta + 1) * t * t;
        double c, got;
        ric_force_frame_decay(1, delta, t, &c, &got);
        const double s = exp(-delta * t) * t * (1 + x / 6 * (1 + x / 20 * (1 + x / 42)));
        if (!(fabs(got - s) <= 1e-15))
            fail_msg("%g beyond critical damping: off by %g", beyond, got - s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_simulated), cmocka_unit_test(test_two_masses),
        cmocka_unit_test(test_one_mass),  cmocka_unit_test(test_start_on_a_stop),
        cmocka_unit_test(test_order),     cmocka_unit_test(test_refused),
        cmocka_unit_test(test_resonance), cmocka_unit_test(test_nearly_critical),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
