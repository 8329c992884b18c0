/* Ghosts: the continuation of branches beyond their grazings, against closed forms of the
 * backbones, the equations themselves and, where they become motions again, the simulator. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "explored.h"

enum { MAX_N = 3, MAX_IMPACT = 16 };

/* ------------------------------------------------------------------ helpers */

static const char *const article =
    "title: t\nmodel:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  contacts:\n"
    "    - {normal: [-1, 1], clearance: 1, sides: both, law: rigid}\n"
    "explore: {energy: [0, 200], frequency: [0.2, 10], impacts: 8, multiply: 1, depth: 3}\n";

static const char *const one_sided =
    "title: t\nmodel:\n  mass: [[2, 0, 0], [0, 1, 0], [0, 0, 0.6]]\n  stiffness: [[9, -1, 0], [-1, "
    "3, -1], [0, -1, "
    "2]]\n  contacts:\n"
    "    - {normal: [-1, 1, 0], clearance: 2.5, sides: upper, law: rigid}\n"
    "explore: {energy: [0, 60], frequency: [0.2, 10], impacts: 2, multiply: 1, depth: 1}\n";

/* The ghost of A4[0011] is a motion again between E 9.04 and 47. */
static const char *const island =
    "title: t\nmodel:\n  mass: [[1.46, 0], [0, 0.64]]\n  stiffness: [[6.92, -6.59], [-6.59, "
    "13.81]]\n  contacts:\n"
    "    - {normal: [0, 1], clearance: 1, sides: both, law: rigid}\n"
    "explore: {energy: [0, 300], frequency: [0.2, 10], impacts: 6, multiply: 1, depth: 2}\n";

static int find_branch(const ric_atlas *atlas, const char *label, int nth)
{
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++)
        if (!strcmp(branch_of(atlas, id).label, label) && nth-- == 0) return id;
    fail_msg("no branch %s", label);
    return 0;
}

static int ghosts_of(const ric_atlas *atlas, int id, ric_ghost ***ghosts)
{
    ric_ghost_limits limits;
    int n;
    ric_ghost_limits_init(atlas, &limits);
    if (ric_ghost_find(atlas, id, &limits, &n, ghosts)) fail_msg("branch %d: %s", id, ric_detail());
    return n;
}

static ric_ghost_data data_of(const ric_ghost *ghost)
{
    ric_ghost_data data;
    ric_ghost_describe(ghost, &data);
    return data;
}

static ric_point point_of(const ric_ghost *ghost, int i, double *state, double *flights)
{
    ric_point p;
    if (ric_ghost_point(ghost, i, &p, state, flights)) fail_msg("%s", ric_detail());
    return p;
}

/* ------------------------------------------------------------- closed forms */

/* docs/theory.md section 11, S2[01] or A1[0]. */
static double backbone_energy(const ric_model *model, const ric_point *p, bool two)
{
    int n = ric_model_n_dof(model);
    double omega[MAX_N], c[2 * MAX_N], above = 0, below = 0;
    assert_int_equal(ric_model_frequencies(model, omega), RIC_OK);
    assert_int_equal(ric_model_modal_normals(model, c), RIC_OK);
    for (int i = 0; i < n; i++) {
        double angle = omega[i] * 3.141592653589793238 / p->frequency / (two ? 2 : 1),
               c2 = c[i] * c[i];
        double tangent = two ? tan(angle) : 1 / tan(angle),
               square = two ? 1 / (cos(angle) * cos(angle)) : 1 / (sin(angle) * sin(angle));
        above += c2 * square;
        below += c2 * tangent / omega[i];
    }
    return above / (2 * below * below);
}

/* Every ghost point of the branch lies on its closed form; returns the number of ghosts. */
static int check_backbone(const ric_atlas *atlas, int id, bool two)
{
    ric_ghost **ghosts;
    int n = ghosts_of(atlas, id, &ghosts);
    for (int k = 0; k < n; k++) {
        ric_ghost_data data = data_of(ghosts[k]);
        assert_true(data.n_point > 20);
        for (int i = 1; i < data.n_point; i++) {
            ric_point p = point_of(ghosts[k], i, NULL, NULL);
            double energy = backbone_energy(ric_atlas_model(atlas), &p, two);
            if (fabs(p.energy / energy - 1) > 1e-10)
                fail_msg("branch %d, ghost %d, point %d: E %.15g, closed form %.15g at omega %.15g",
                         id, k, i, p.energy, energy, p.frequency);
        }
    }
    ric_ghosts_free(n, ghosts);
    return n;
}

static void backbones_of_two_impacts_go_on(void **state)
{
    (void)state;
    ric_atlas *atlas = explore_text(article);
    assert_int_equal(check_backbone(atlas, find_branch(atlas, "S2+[01]", 0), true),
                     2); /* grazing at both ends */
    assert_int_equal(check_backbone(atlas, find_branch(atlas, "S2-[01]", 0), true),
                     1); /* ends at the window */
    ric_atlas_free(atlas);
}

static void backbones_of_one_impact_go_on(void **state)
{
    (void)state;
    ric_atlas *atlas = explore_text(one_sided);
    int found = 0;
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++)
        if (branch_of(atlas, id).impacts == 1) found += check_backbone(atlas, id, false);
    assert_int_equal(found, 2); /* the second mode touches above the window */
    ric_atlas_free(atlas);
}

/* -------------------------------------------------------------- every ghost */

/* The stored end is where the ghost starts, and the arclength goes on outwards. */
static void check_start(const ric_atlas *atlas, const ric_branch *b, const ric_ghost *ghost)
{
    ric_ghost_data data = data_of(ghost);
    double x[2 * MAX_N], y[2 * MAX_N], tau[MAX_IMPACT], sigma[MAX_IMPACT];
    ric_point end, p = point_of(ghost, 0, x, tau);
    int n = ric_model_n_dof(ric_atlas_model(atlas)), sign = data.end == RIC_END_FROM ? -1 : 1;
    assert_int_equal(ric_atlas_point(atlas, b->id, data.end == RIC_END_FROM ? 0 : b->n_point - 1,
                                     &end, y, sigma),
                     RIC_OK);
    for (int i = 0; i < 2 * n; i++) assert_true(fabs(x[i] - y[i]) < 1e-9 * (1 + fabs(y[i])));
    for (int i = 0; i < b->impacts; i++) assert_true(fabs(tau[i] - sigma[i]) < 1e-9);
    assert_true(p.arclength == end.arclength);
    for (int i = 1; i < data.n_point; i++) {
        ric_point q = point_of(ghost, i, NULL, NULL);
        if (!(sign * (q.arclength - p.arclength) > 0))
            fail_msg("branch %d, point %d: arclength %g after %g", b->id, i, q.arclength,
                     p.arclength);
        p = q;
    }
}

/* Energy, period and gap of the state that leaves the library, from the raw matrices; the residual;
 * the flights. */
static void check_point(const ric_atlas *atlas, const ric_branch *b, const ric_ghost *ghost, int i)
{
    const ric_model *m = ric_atlas_model(atlas);
    double x[2 * MAX_N], tau[MAX_IMPACT], period = 0, gap = 0;
    ric_point p = point_of(ghost, i, x, tau);
    ric_contact contact;
    int n = ric_model_n_dof(m), c, side;
    assert_int_equal(ric_model_face(m, b->word[0], &c, &side, NULL), RIC_OK);
    assert_int_equal(ric_model_contact(m, c, &contact), RIC_OK);
    for (int j = 0; j < n; j++) gap += side * contact.normal[j] * x[j];
    for (int k = 0; k < b->impacts; k++) {
        assert_true(tau[k] > 0);
        period += tau[k];
    }
    if (p.residual > 1e-13)
        fail_msg("branch %d, point %d: residual %g", b->id, i, (double)p.residual);
    assert_true(fabs(gap * ric_model_length(m) / contact.clearance - 1) < 1e-12);
    assert_true(fabs(period * p.frequency / 6.283185307179586477 - 1) < 1e-12);
    assert_true(fabs(ric_model_energy(m, x, x + n) / p.energy - 1) < 1e-12);
}

/* Ends of impacting branches at junctions where only the margins change sign. */
static int grazing_ends(const ric_atlas *atlas)
{
    int count = 0;
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        ric_branch b = branch_of(atlas, id);
        for (int k = 0; b.impacts > 0 && k < 2; k++) {
            ric_junction j;
            int end = k ? b.to : b.from;
            if (end) assert_int_equal(ric_atlas_junction(atlas, end, &j), RIC_OK);
            count += end && (j.kind == RIC_KIND_GRAZING || j.kind == RIC_KIND_CORNER);
        }
    }
    return count;
}

static void ghosts_solve_the_equations_and_are_no_motions(void **state)
{
    (void)state;
    ric_atlas *atlas = explore_text(article);
    int total = 0;
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        ric_branch b = branch_of(atlas, id);
        ric_ghost **ghosts;
        int n = ghosts_of(atlas, id, &ghosts);
        for (int k = 0; k < n; k++) {
            ric_ghost_data data = data_of(ghosts[k]);
            check_start(atlas, &b, ghosts[k]);
            for (int i = 1; i < data.n_point; i++) {
                check_point(atlas, &b, ghosts[k], i);
                ric_point p = point_of(ghosts[k], i, NULL, NULL);
                /* there they have no speed left */
                bool two_in_one = data.stop == RIC_STOP_CORNER && i == data.n_point - 1;
                if (ric_point_admissible(&p))
                    fail_msg("%s, point %d: reach %.12g, approach %g", b.label, i, p.reach,
                             p.approach);
                if (!two_in_one && !(p.reach > 1 || p.approach < 0))
                    fail_msg("%s, point %d: margins not negative", b.label, i);
            }
            assert_int_equal(data.again, -1);
            assert_true(data.stop == RIC_STOP_WINDOW || data.stop == RIC_STOP_CORNER);
            total++;
        }
        ric_ghosts_free(n, ghosts);
    }
    assert_int_equal(total, grazing_ends(atlas));
    assert_true(total > 12);
    ric_atlas_free(atlas);
}

/* A3[001] beyond its grazing on S2: two impacts on one face come together, and no flight time
 * becomes negative. */
static void a_ghost_ends_where_two_impacts_come_together(void **state)
{
    (void)state;
    ric_atlas *atlas = explore_text(article);
    ric_ghost **ghosts;
    int n = ghosts_of(atlas, find_branch(atlas, "A3[001]", 0), &ghosts), found = 0;
    for (int k = 0; k < n; k++) {
        ric_ghost_data data = data_of(ghosts[k]);
        double tau[MAX_IMPACT];
        if (data.stop != RIC_STOP_CORNER) continue;
        point_of(ghosts[k], data.n_point - 1, NULL, tau);
        double least = fmin(tau[0], fmin(tau[1], tau[2]));
        if (!(least > 0 && least < 2e-5)) fail_msg("shortest flight %g", least);
        found++;
    }
    assert_int_equal(found, 1);
    ric_ghosts_free(n, ghosts);
    ric_atlas_free(atlas);
}

/* -------------------------------------------------------------- motions again */

/* The simulator, started at a point where all margins are positive again, comes back to it over the
 * impacts of the word. */
static void check_replay(const ric_atlas *atlas, const ric_branch *b, const ric_ghost *ghost, int i)
{
    int n = ric_model_n_dof(ric_atlas_model(atlas)), hits = 0;
    double x[2 * MAX_N], y[2 * MAX_N], tau[MAX_IMPACT], time = 0;
    ric_simulator *sim = NULL;
    point_of(ghost, i, x, tau);
    assert_int_equal(ric_simulator_create(ric_atlas_model(atlas), &sim), RIC_OK);
    assert_int_equal(ric_simulator_start(sim, x, x + n), RIC_OK);
    for (int k = 0; k < b->impacts; k++) {
        ric_impact impact;
        bool hit = false;
        time += tau[k];
        assert_int_equal(ric_simulator_advance(sim, time + 1e-6, &hit, &impact), RIC_OK);
        if (!hit || impact.face != b->word[(k + 1) % b->impacts] || fabs(impact.time - time) > 1e-8)
            fail_msg("point %d, impact %d: %s on face %d at %.12g, not %.12g", i, k,
                     hit ? "hit" : "none", impact.face, impact.time, time);
        hits++;
    }
    ric_simulator_state(sim, NULL, y, y + n);
    assert_int_equal(hits, b->impacts);
    for (int j = 0; j < 2 * n; j++) assert_true(fabs(x[j] - y[j]) < 1e-7);
    ric_simulator_free(sim);
}

static void a_ghost_that_becomes_a_motion_says_so(void **state)
{
    (void)state;
    ric_atlas *atlas = explore_text(island);
    int found = 0, motions = 0;
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        ric_branch b = branch_of(atlas, id);
        ric_ghost **ghosts;
        int n = ghosts_of(atlas, id, &ghosts);
        for (int k = 0; k < n; k++) {
            ric_ghost_data data = data_of(ghosts[k]);
            if (data.again < 0) continue;
            found++;
            for (int i = 1; i < data.n_point; i++) {
                ric_point p = point_of(ghosts[k], i, NULL, NULL);
                if (!ric_point_admissible(&p)) continue;
                assert_true(i >= data.again && !(p.reach >= 1) && p.approach > 0);
                check_replay(atlas, &b, ghosts[k], i);
                motions++;
            }
        }
        ric_ghosts_free(n, ghosts);
    }
    assert_int_equal(found, 1);
    assert_true(motions > 20);
    ric_atlas_free(atlas);
}

/* ---------------------------------------------------------------- the window */

static void ghosts_stay_in_the_window(void **state)
{
    (void)state;
    ric_atlas *atlas = explore_text(article);
    int id = find_branch(atlas, "S2+[01]", 0), n;
    ric_ghost **ghosts;
    ric_ghost_limits limits;
    ric_ghost_limits_init(atlas, &limits);
    limits.energy[1] = 3; /* leaves out the far end, at 81 */
    assert_int_equal(ric_ghost_find(atlas, id, &limits, &n, &ghosts), RIC_OK);
    assert_int_equal(n, 1);
    ric_ghost_data data = data_of(ghosts[0]);
    assert_int_equal(data.end, RIC_END_FROM);
    assert_int_equal(data.stop, RIC_STOP_WINDOW);
    for (int i = 0; i < data.n_point; i++)
        assert_true(point_of(ghosts[0], i, NULL, NULL).energy <= 3 * (1 + 1e-12));
    assert_true(fabs(point_of(ghosts[0], data.n_point - 1, NULL, NULL).energy - 3) < 1e-9);
    assert_int_equal(ric_ghost_point(ghosts[0], data.n_point, NULL, NULL, NULL), RIC_E_RANGE);
    ric_ghosts_free(n, ghosts);
    limits.max_points = 5;
    assert_int_equal(ric_ghost_find(atlas, id, &limits, &n, &ghosts), RIC_OK);
    assert_int_equal(data_of(ghosts[0]).n_point, 5);
    assert_int_equal(data_of(ghosts[0]).stop, RIC_STOP_BUDGET);
    ric_ghosts_free(n, ghosts);
    ric_atlas_free(atlas);
}

static void linear_modes_have_none(void **state)
{
    (void)state;
    ric_atlas *atlas = explore_text(article);
    ric_ghost **ghosts;
    assert_int_equal(ghosts_of(atlas, find_branch(atlas, "S0+", 0), &ghosts), 0);
    ric_ghosts_free(0, ghosts);
    ric_ghost_limits limits;
    int n;
    ric_ghost_limits_init(atlas, &limits);
    assert_int_equal(ric_ghost_find(atlas, 9999, &limits, &n, &ghosts), RIC_E_RANGE);
    ric_atlas_free(atlas);
}

/* The same multipliers as the stored points have: beside the end they join, and their product is 1.
 */
static void multipliers_of_ghosts(void **state)
{
    (void)state;
    ric_atlas *atlas = explore_text(one_sided);
    int checked = 0;
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        ric_ghost **ghosts;
        int n = ghosts_of(atlas, id, &ghosts);
        for (int k = 0; k < n; k++) {
            double z[8];
            int last = data_of(ghosts[k]).n_point - 1;
            ric_point p = point_of(ghosts[k], last, NULL, NULL);
            assert_int_equal(ric_ghost_multipliers(ghosts[k], last, z), RIC_OK);
            bool circle = true;
            for (int j = 0; j < 2; j++) {
                const double *a = z + 4 * j, *b = a + 2;
                assert_true(fabs(a[0] * b[0] - a[1] * b[1] - 1) < 1e-9 &&
                            fabs(a[0] * b[1] + a[1] * b[0]) < 1e-9);
                circle = circle && fabs(hypot(a[0], a[1]) - 1) < 1e-6;
            }
            if (p.stable != RIC_STABLE_UNDECIDED)
                assert_int_equal(circle, p.stable == RIC_STABLE_YES);
            checked++;
        }
        ric_ghosts_free(n, ghosts);
    }
    assert_int_equal(checked, 2);
    ric_atlas_free(atlas);
}

/* Fig. 20c of the article: on the k-duplicates of A1[0] the multiplications are partly on the
 * branch (black), partly on its ghosts (red). The rotation number passes every value up to 1/2
 * once, so that each p/q with q <= 9 is on one of them; on the ghosts it lies on the closed form,
 * between points whose rotation numbers are on either side of it. */
static void multiplications_beyond_the_grazing(void **state)
{
    (void)state;
    enum { MOST = 9 };
    ric_atlas *atlas = explore_text(
        "model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  contacts:\n"
        "    - {normal: [-1, 1], clearance: 1, sides: both, law: rigid}\n"
        "explore: {energy: [0, 200], frequency: [0.2, 30], impacts: 2, multiply: 9, depth: "
        "1}\n");
    const ric_branch b = branch_of(atlas, find_branch(atlas, "A1[0]", 0));
    int seen[MOST + 1][MOST + 1] = {{0}}, red = 0, black = 0;
    for (int i = 0; i < b.n_junction; i++) {
        const ric_junction j = junction_of(atlas, b.junctions[i]);
        if (j.kind != RIC_KIND_MULTIPLICATION) continue;
        seen[j.rotation[0]][j.rotation[1]]++;
        black++;
    }
    ric_ghost_limits limits;
    ric_ghost **ghosts;
    int n;
    ric_ghost_limits_init(atlas, &limits);
    limits.multiply = MOST;
    assert_int_equal(ric_ghost_find(atlas, b.id, &limits, &n, &ghosts), RIC_OK);
    for (int k = 0; k < n; k++) {
        const int count = ric_ghost_n_multiplication(ghosts[k]),
                  last = data_of(ghosts[k]).n_point - 1;
        ric_ghost_multiplication m;
        assert_int_equal(ric_ghost_multiplication_at(ghosts[k], count, &m), RIC_E_RANGE);
        for (int i = 0; i < count; i++) {
            assert_int_equal(ric_ghost_multiplication_at(ghosts[k], i, &m), RIC_OK);
            const ric_point at = {.frequency = m.frequency};
            const double energy = backbone_energy(ric_atlas_model(atlas), &at, false),
                         gamma = (double)m.rotation[0] / m.rotation[1];
            if (fabs(m.energy / energy - 1) > 1e-10)
                fail_msg("%d/%d: E %.15g, closed form %.15g", m.rotation[0], m.rotation[1],
                         m.energy, energy);
            assert_false(m.admissible);
            int between = 0; /* a multiplication is a stored point: between its neighbours, gamma =
                                1/2 at the edge of stability */
            for (int p = 1; p <= last - 1; p++) {
                const ric_point before = point_of(ghosts[k], p - 1, NULL, NULL),
                                after = point_of(ghosts[k], p + 1, NULL, NULL);
                if ((before.arclength - m.arclength) * (after.arclength - m.arclength) >= 0)
                    continue;
                const double low = isnan(before.rotation) ? 0.5 : before.rotation,
                             high = isnan(after.rotation) ? 0.5 : after.rotation;
                between += gamma >= fmin(low, high) && gamma <= fmax(low, high);
            }
            assert_true(between > 0);
            seen[m.rotation[0]][m.rotation[1]]++;
            red++;
        }
    }
    for (int q = 2; q <= MOST; q++)
        for (int p = 1; p < q; p++) {
            int a = p, c = q;
            for (int rest; c; a = c, c = rest) rest = a % c;
            if (seen[p][q] != (a == 1 && 2 * p <= q)) fail_msg("%d/%d: %d times", p, q, seen[p][q]);
        }
    assert_int_equal(black, 8); /* 1/4 is the first */
    assert_int_equal(red, 6);
    ric_ghosts_free(n, ghosts);
    ric_atlas_free(atlas);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(backbones_of_two_impacts_go_on),
        cmocka_unit_test(backbones_of_one_impact_go_on),
        cmocka_unit_test(ghosts_solve_the_equations_and_are_no_motions),
        cmocka_unit_test(a_ghost_ends_where_two_impacts_come_together),
        cmocka_unit_test(a_ghost_that_becomes_a_motion_says_so),
        cmocka_unit_test(ghosts_stay_in_the_window),
        cmocka_unit_test(linear_modes_have_none),
        cmocka_unit_test(multipliers_of_ghosts),
        cmocka_unit_test(multiplications_beyond_the_grazing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
