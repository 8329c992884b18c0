/* Orbits of explored atlases against the impulse form, a second formulation that shares only the
 * modes, which are computed here.
 *
 * An orbit of period T with momenta J_k exchanged along the normals b_k at times t_k is q_i(t) =
 * sum_k J_k c_ki
 * G_i(t - t_k), G_i(s) = cos(omega_i (s - T/2)) / (2 omega_i sin(omega_i T/2)) for 0 <= s < T. With
 * K_fg = sum_i c_fi c_gi G_i:   sum_k J_k K(t_j - t_k) = +-d_j               every impact is on its
 *                               face
 *   sum_{k != j} J_k K'(t_j - t_k) = 0           the speed turns round
 * For z(t+T/2) = -z(t) the same over half a period h = T/2 with G_i(s) = sin(omega_i (s - h/2)) /
 * (2 omega_i cos(omega_i h/2)). */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <lapacke.h>

#include "explore/rows.h"
#include "random_models.h"
#include "sample.h"

enum { MAX_N = 6, MAX_CONTACT = 2, MAX_IMPACT = 32 };

/* ------------------------------------------------------------------ helpers */

/* Modes from the raw matrices; lengths in units of the first clearance, as in the atlas. */
typedef struct {
    const ric_model *model;
    int n;
    double omega[MAX_N], Phi[MAX_N * MAX_N], c[MAX_CONTACT * MAX_N], cc[MAX_CONTACT];
} modes;

static modes modes_of(const ric_model *model)
{
    modes m = {.model = model, .n = ric_model_n_dof(model)};
    int n = m.n;
    double mass[MAX_N * MAX_N], square[MAX_N];
    memcpy(m.Phi, ric_model_stiffness(model), (size_t)(n * n) * sizeof *mass);
    memcpy(mass, ric_model_mass(model), (size_t)(n * n) * sizeof *mass);
    assert_int_equal(LAPACKE_dsygv(LAPACK_ROW_MAJOR, 1, 'V', 'U', n, m.Phi, n, mass, n, square), 0);
    for (int i = 0; i < n; i++) m.omega[i] = sqrt(square[i]);
    for (int f = 0; f < ric_model_n_contact(model); f++) {
        ric_contact contact;
        assert_int_equal(ric_model_contact(model, f, &contact), RIC_OK);
        for (int i = 0; i < n; i++) {
            double sum = 0;
            for (int j = 0; j < n; j++) sum += m.Phi[j * n + i] * contact.normal[j];
            m.c[f * n + i] = sum;
            m.cc[f] += sum * sum;
        }
    }
    return m;
}

typedef struct {
    int N, contact[MAX_IMPACT];
    double T, t[MAX_IMPACT], J[MAX_IMPACT], r[MAX_IMPACT];
} impulses;

/* Times and impulses along an orbit, flown in modal coordinates from the state after impact 0 with
 * the flight times given. */
static impulses collect(const modes *m, int N, const int *word, const double *state,
                        const double *flights)
{
    impulses out = {.N = N};
    int n = m->n;
    double q[MAX_N], p[MAX_N], time = 0;
    const double *mass = ric_model_mass(m->model);
    assert_true(N <= MAX_IMPACT);
    for (int i = 0; i < n; i++) {
        q[i] = p[i] = 0;
        for (int j = 0; j < n; j++)
            for (int k = 0; k < n; k++) {
                q[i] += m->Phi[j * n + i] * mass[j * n + k] * state[k];
                p[i] += m->Phi[j * n + i] * mass[j * n + k] * state[n + k];
            }
    }
    for (int k = 0; k < N; k++) {
        int next = (k + 1) % N, side, mirror, f;
        ric_contact contact;
        assert_int_equal(ric_model_face(m->model, word[next], &f, &side, &mirror), RIC_OK);
        assert_int_equal(ric_model_contact(m->model, f, &contact), RIC_OK);
        double speed = 0;
        for (int i = 0; i < n; i++) {
            double co = cos(m->omega[i] * flights[k]), si = sin(m->omega[i] * flights[k]), a = q[i],
                   b = p[i] / m->omega[i];
            q[i] = a * co + b * si;
            p[i] = m->omega[i] * (b * co - a * si);
            speed += m->c[f * n + i] * p[i];
        }
        time += flights[k];
        out.t[next] = next ? time : 0;
        out.contact[next] = f;
        out.J[next] = -2 * speed / m->cc[f];
        out.r[next] = side * contact.clearance / ric_model_length(m->model);
        for (int i = 0; i < n; i++) p[i] += out.J[next] * m->c[f * n + i];
    }
    out.T = time;
    return out;
}

/* The two equations of impact j with kernels of period T (sign 1), or of half a period h = T that
 * changes sign (sign -1). *scale, *slope_scale: what a relative error of 1 in the flight times and
 * impulses would make of each sum. */
static void equations(const modes *m, const impulses *o, int N, double T, int sign, int j,
                      double *gap, double *scale, double *slope, double *slope_scale)
{
    *gap = *scale = *slope = *slope_scale = 0;
    for (int k = 0; k < N; k++) {
        double s = o->t[j] - o->t[k], turn = 1;
        if (s < 0) {
            s += T;
            turn = sign;
        }
        for (int i = 0; i < m->n; i++) {
            double w = m->omega[i], x = w * (s - T / 2),
                   denominator = sign > 0 ? sin(w * T / 2) : cos(w * T / 2);
            double factor = turn * o->J[k] * m->c[o->contact[j] * m->n + i] *
                            m->c[o->contact[k] * m->n + i] / (2 * denominator);
            double G = sign > 0 ? cos(x) : sin(x), D = sign > 0 ? -sin(x) : cos(x),
                   spread = 1 + w * T * (1 + 1 / fabs(denominator));
            *gap += factor * G / w;
            *scale += fabs(factor) / w * spread;
            *slope_scale += fabs(factor) * spread;
            if (k != j) *slope += factor * D;
        }
    }
}

static int checked;
static double worst;

static void check_orbit(const modes *m, const impulses *o, bool symmetric, const char *where)
{
    for (int form = 0; form < (symmetric ? 2 : 1); form++) {
        int N = form ? o->N / 2 : o->N;
        double T = form ? o->T / 2 : o->T;
        for (int j = 0; j < N; j++) {
            double gap, scale, slope, slope_scale;
            equations(m, o, N, T, form ? -1 : 1, j, &gap, &scale, &slope, &slope_scale);
            if (!(scale < 1e9)) return; /* next to a linear grazing: 0/0 */
            if (!(fabs(gap - o->r[j]) <= 1e-11 * (1 + scale)))
                fail_msg("%s, form %d: impact %d: gap %.15g, not %.15g, condition %.3g", where,
                         form, j, gap, o->r[j], scale);
            if (!(fabs(slope) <= 1e-11 * (1 + slope_scale)))
                fail_msg("%s, form %d: impact %d: sum of J K' = %.3g, condition %.3g", where, form,
                         j, slope, slope_scale);
            worst = fmax(worst,
                         fmax(fabs(gap - o->r[j]) / (1 + scale), fabs(slope) / (1 + slope_scale)));
        }
    }
    checked++;
}

/* Impulses that the simulator reports over one period of a stable orbit. */
static int check_simulator(const ric_model *model, const impulses *o, const int *word,
                           const double *state, const char *where)
{
    ric_simulator *sim = NULL;
    int n = ric_model_n_dof(model), seen = 0;
    bool hit = true;
    ric_impact impact;
    assert_int_equal(ric_simulator_create(model, &sim), RIC_OK);
    if (ric_simulator_start(sim, state, state + n)) fail_msg("%s: %s", where, ric_detail());
    while (hit) {
        if (ric_simulator_advance(sim, o->T * (1 + 1e-9), &hit, &impact))
            fail_msg("%s: %s", where, ric_detail());
        if (!hit || impact.approach < 1e-9) continue;
        int k = ++seen % o->N;
        if (impact.face != word[k] || fabs(impact.time - (k ? o->t[k] : o->T)) > 1e-8 * o->T ||
            fabs(fabs(impact.impulse) - fabs(o->J[k])) > 1e-7 * (1 + fabs(o->J[k])))
            fail_msg("%s: impact %d: face %d at %.12g, impulse %.12g, not face %d at %.12g, %.12g",
                     where, seen, impact.face, impact.time, impact.impulse, word[k], o->t[k],
                     o->J[k]);
    }
    ric_simulator_free(sim);
    if (seen != o->N) fail_msg("%s: %d impacts in a period, not %d", where, seen, o->N);
    return 1;
}

static void check_atlas(const ric_study *study, const char *name, int at_least)
{
    ric_graph *graph = NULL;
    ric_atlas *atlas = NULL;
    int simulated = 0, branches = 0;
    assert_int_equal(ric_graph_create(study, NULL, &graph), RIC_OK);
    if (ric_graph_explore(graph, NULL)) fail_msg("%s: %s", name, ric_detail());
    if (ric_rows_make(graph, study, true, &atlas)) fail_msg("%s: %s", name, ric_detail());
    modes m = modes_of(ric_study_model(study));
    checked = 0;
    worst = 0;
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        ric_branch b;
        assert_int_equal(ric_atlas_branch(atlas, id, &b), RIC_OK);
        if (b.impacts == 0) continue;
        branches++;
        for (int i = 0; i < b.n_point; i++) {
            ric_point p;
            double state[2 * MAX_N], flights[MAX_IMPACT];
            char where[96];
            assert_int_equal(ric_atlas_point(atlas, id, i, &p, state, flights), RIC_OK);
            snprintf(where, sizeof where, "%s, branch %d %s, point %d, E %.6g", name, id, b.label,
                     i, p.energy);
            impulses o = collect(&m, b.impacts, b.word, state, flights);
            assert_true(fabs(o.T * p.frequency / 6.283185307179586 - 1) <= 1e-13 * b.impacts);
            check_orbit(&m, &o, b.symmetric, where);
            if (p.stable == RIC_STABLE_YES && p.approach > 1e-2 && !(p.reach > 0.999))
                simulated += check_simulator(ric_study_model(study), &o, b.word, state, where);
        }
        /* one orbit solved on request, between stored points */
        ric_orbit **orbits = NULL;
        int count = 0;
        ric_point p;
        double state[2 * MAX_N], flights[MAX_IMPACT];
        int word[MAX_IMPACT];
        if (ric_orbit_find(atlas, id, RIC_AT_ENERGY, 0.37 * b.energy_min + 0.63 * b.energy_max,
                           &count, &orbits))
            fail_msg("%s: branch %d: %s", name, id, ric_detail());
        for (int k = 0; k < count; k++) {
            char where[96];
            snprintf(where, sizeof where, "%s, branch %d %s, orbit on request", name, id, b.label);
            ric_orbit_data(orbits[k], &p, state, flights, word);
            impulses o = collect(&m, b.impacts, word, state, flights);
            check_orbit(&m, &o, b.symmetric, where);
        }
        if (b.energy_max > b.energy_min * (1 + 1e-6)) assert_true(count > 0);
        ric_orbits_free(count, orbits);
    }
    print_message(
        "# %s: %d branches, %d orbits, %d of them simulated, worst %.2g of the condition\n", name,
        branches, checked, simulated, worst);
    assert_true(checked >= at_least);
    ric_atlas_free(atlas);
    ric_graph_free(graph);
}

/* -------------------------------------------------------------------- tests */

static void two_masses(void **state)
{
    (void)state;
    ric_study *study = NULL;
    if (ric_study_read("examples/elementary/study.yaml", &study)) fail_msg("%s", ric_detail());
    check_atlas(study, "elementary", 300);
    ric_study_free(study);
}

/* Chains of masses between springs, one or two contacts with clearances of their own. */
static void random_models(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 8; seed += (uint64_t)every()) {
        char text[4096], name[32];
        int n = 2 + (int)(seed % 4), two = n > 2 && seed % 2 == 0, used;
        double mass[MAX_N], spring[MAX_N + 1];
        ric_study *study = NULL;
        size_t size = sizeof text;
        seed_now = seed;
        for (int i = 0; i <= n; i++) spring[i] = uniform(0.7, 4);
        used = snprintf(text, size, "model:\n  mass: [");
        for (int i = 0; i < n; i++) {
            mass[i] = uniform(0.6, 2);
            used += snprintf(text + used, size - (size_t)used, "%s[", i ? ", " : "");
            for (int j = 0; j < n; j++)
                used += snprintf(text + used, size - (size_t)used, "%s%.17g", j ? ", " : "",
                                 i == j ? mass[i] : 0.0);
            used += snprintf(text + used, size - (size_t)used, "]");
        }
        used += snprintf(text + used, size - (size_t)used, "]\n  stiffness: [");
        for (int i = 0; i < n; i++) {
            used += snprintf(text + used, size - (size_t)used, "%s[", i ? ", " : "");
            for (int j = 0; j < n; j++)
                used += snprintf(text + used, size - (size_t)used, "%s%.17g", j ? ", " : "",
                                 i == j            ? spring[i] + spring[i + 1]
                                 : abs(i - j) == 1 ? -spring[i > j ? i : j]
                                                   : 0.0);
            used += snprintf(text + used, size - (size_t)used, "]");
        }
        used += snprintf(text + used, size - (size_t)used, "]\n  contacts:\n");
        for (int f = 0; f < 1 + two; f++) {
            used += snprintf(text + used, size - (size_t)used,
                             "    - {clearance: %.17g, sides: %s, normal: [", uniform(0.5, 2),
                             seed % 3 == 0 && f == 0 ? "upper" : "both");
            for (int j = 0; j < n; j++)
                used += snprintf(text + used, size - (size_t)used, "%s%d", j ? ", " : "",
                                 f == 0 ? (j == 1) - (j == 0) : j == n - 1);
            used += snprintf(text + used, size - (size_t)used, "]}\n");
        }
        snprintf(text + used, size - (size_t)used,
                 "explore: {energy: [0, 60], frequency: [0.1, 12], impacts: 5, depth: 2}\n");
        snprintf(name, sizeof name, "seed %llu, n = %d", (unsigned long long)seed, n);
        if (ric_study_parse(text, "study", ".", &study)) fail_msg("%s\n%s", ric_detail(), text);
        check_atlas(study, name, 20);
        ric_study_free(study);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(two_masses),
                                       cmocka_unit_test(random_models)};
    return cmocka_run_group_tests_name("impulse", tests, NULL, NULL);
}
