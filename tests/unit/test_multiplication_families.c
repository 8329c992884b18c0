/* What leaves where multipliers are roots of unity, counted family by family: every rotation number
 * of S2- of the article's two masses for several q, and both pairs of multipliers of a structure
 * with three modes. Periods, mirror points and symmetry of the members are those that the simulator
 * sees, which shares no code with the solver. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "branch/resonance.h"
#include "explored.h"
#include "sample.h"

#define TWO_PI 6.283185307179586477
/* RETURNS: of a simulated member after its period, relative: multipliers near a multiplication are
 * small */
#define RETURNS 1e-8
/* NEAR: arclength, relative, from the junction at which a member is looked at: nearer by it is the
 * original */
#define NEAR 1e-4

enum { MAX_DOF = 3, MAX_IMPACTS = 32, MAX_LEGS = 4, MAX_Q = 16 };

static int divisor(int a, int b)
{
    return b ? divisor(b, a % b) : a;
}

/* --------------------------------------------------------- what is simulated */

typedef struct {
    int n, N;
    double after[MAX_IMPACTS + 1][2 * MAX_DOF]; /* x, v behind each impact, and behind the first one
                                                   of the next period */
    double middle[MAX_IMPACTS][2 * MAX_DOF];    /* in the middle of each flight */
    double size;
} motion;

static double difference(int n, const double *a, const double *b, double sign)
{
    double most = 0;
    for (int i = 0; i < n; i++) most = fmax(most, fabs(a[i] - sign * b[i]));
    return most;
}

static double largest(int n, const double *a)
{
    double most = 0;
    for (int i = 0; i < n; i++) most = fmax(most, fabs(a[i]));
    return most;
}

/* Runs the simulator twice, from impact to impact and to the middles between. */
static void simulate(const ric_model *m, int N, const double *state, const double *flights,
                     motion *out)
{
    ric_simulator *sim = NULL;
    int n = ric_model_n_dof(m);
    double period = 0;
    assert_true(n <= MAX_DOF && N <= MAX_IMPACTS);
    *out = (motion){.n = n, .N = N, .size = largest(2 * n, state)};
    for (int k = 0; k < N; k++) period += flights[k];
    assert_int_equal(ric_simulator_create(m, &sim), RIC_OK);
    memcpy(out->after[0], state, 2 * (size_t)n * sizeof *state);
    for (int k = 0; k < N; k++) {
        double *x = out->after[k], time;
        bool hit;
        if (ric_simulator_start(sim, x, x + n)) fail_msg("%s", ric_detail());
        assert_int_equal(ric_simulator_advance(sim, 1.01 * period, &hit, NULL), RIC_OK);
        assert_true(hit);
        ric_simulator_state(sim, &time, out->after[k + 1], out->after[k + 1] + n);
        if (ric_simulator_start(sim, x, x + n)) fail_msg("%s", ric_detail());
        assert_int_equal(ric_simulator_advance(sim, time / 2, &hit, NULL), RIC_OK);
        assert_false(hit);
        ric_simulator_state(sim, NULL, out->middle[k], out->middle[k] + n);
    }
    ric_simulator_free(sim);
}

/* Impacts that turn the motion round: the velocity is along M^-1 b, that is, M v along b. */
static int impact_mirrors(const ric_model *m, const motion *z, double tolerance)
{
    const double *M = ric_model_mass(m);
    ric_contact contact;
    int n = z->n, count = 0;
    assert_int_equal(ric_model_contact(m, 0, &contact), RIC_OK);
    for (int k = 0; k < z->N; k++) {
        double momentum[MAX_DOF] = {0}, along = 0, square = 0, across = 0;
        for (int i = 0; i < n; i++) {
            for (int j = 0; j < n; j++) momentum[i] += M[i * n + j] * z->after[k][n + j];
            along += momentum[i] * contact.normal[i];
            square += contact.normal[i] * contact.normal[i];
        }
        for (int i = 0; i < n; i++)
            across = fmax(across, fabs(momentum[i] - along / square * contact.normal[i]));
        count += across < tolerance * z->size;
    }
    return count;
}

static int centres(const motion *z, double tolerance)
{
    int count = 0;
    for (int k = 0; k < z->N; k++) count += largest(z->n, z->middle[k]) < tolerance * z->size;
    return count;
}

/* Least distance of the motion from itself `step` impacts on, up to the sign. */
static double repeats(const motion *z, int step, double sign)
{
    return difference(2 * z->n, z->after[step], z->after[0], sign) / z->size;
}

/* ---------------------------------------------------------------- the families */

/* One way out of a multiplication: the side of a branch that ends there, or one of both of a branch
 * that passes. */
typedef struct {
    ric_branch branch;
    int first, step; /* the point next to the junction, and which way the others are */
    int near;        /* the first one far enough to be told from the original */
    double distance;
    ric_stability type; /* of the first one that is decided */
    double rise;        /* energy there minus that of the junction, relative */
} leg;

static ric_point point_of(const ric_atlas *atlas, int branch, int i)
{
    ric_point out;
    assert_int_equal(ric_atlas_point(atlas, branch, i, &out, NULL, NULL), RIC_OK);
    return out;
}

static void measure(const ric_atlas *atlas, const ric_junction *j, double at, leg *out)
{
    int last = out->step > 0 ? out->branch.n_point - 1 : 0;
    out->type = RIC_STABLE_UNDECIDED;
    out->near = -1;
    for (int i = out->first; i != last + out->step; i += out->step) {
        ric_point p = point_of(atlas, out->branch.id, i);
        if (out->near < 0 && fabs(p.arclength - at) > NEAR) {
            out->near = i;
            out->distance = fabs(p.arclength - at);
            out->rise = p.energy / j->energy - 1;
        }
        if (out->near < 0 || p.stable == RIC_STABLE_UNDECIDED) continue;
        out->type = (ric_stability)p.stable;
        break;
    }
    assert_true(out->near >= 0);
}

/* Legs of the branches that leave a multiplication of branch `original`; *curves: of how many
 * branches they are. */
static int list_legs(const ric_atlas *atlas, const ric_junction *j, int original, leg *out,
                     int *curves)
{
    int n = 0;
    *curves = 0;
    for (int k = 0; k < j->n_branch; k++) {
        ric_branch b = branch_of(atlas, j->branches[k]);
        if (b.id == original) continue;
        assert_true(n + 2 <= MAX_LEGS);
        (*curves)++;
        double length = point_of(atlas, b.id, b.n_point - 1).arclength;
        if (b.from == j->id)
            measure(atlas, j, 0, (out[n] = (leg){.branch = b, .first = 0, .step = 1}, &out[n])),
                n++;
        if (b.to == j->id)
            measure(atlas, j, length,
                    (out[n] = (leg){.branch = b, .first = b.n_point - 1, .step = -1}, &out[n])),
                n++;
        for (int i = 0; i < b.n_junction; i++) {
            int after = 0;
            if (b.junctions[i] != j->id) continue;
            while (after < b.n_point && point_of(atlas, b.id, after).arclength <= b.junction_at[i])
                after++;
            for (int side = 1; side >= -1; side -= 2, n++) {
                out[n] = (leg){.branch = b, .first = side > 0 ? after : after - 1, .step = side};
                measure(atlas, j, b.junction_at[i], &out[n]);
            }
        }
    }
    return n;
}

/* A member beside the junction is an orbit of exactly q periods with the symmetry and the mirror
 * points that its branch claims; all stored points of the branch agree with the simulator. */
static void check_members(const ric_atlas *atlas, const ric_junction *j, const leg *l,
                          const char *where)
{
    const ric_model *m = ric_atlas_model(atlas);
    const ric_branch *b = &l->branch;
    int n = ric_model_n_dof(m), step = j->impacts;
    double state[2 * MAX_DOF], flights[MAX_IMPACTS];
    ric_point p;
    motion z;
    assert_true(b->impacts <= MAX_IMPACTS);
    if (b->impacts != j->impacts * j->multiple) fail_msg("%s: %d impacts", where, b->impacts);
    assert_int_equal(ric_atlas_point(atlas, b->id, l->near, &p, state, flights), RIC_OK);
    if (fabs(p.frequency / j->frequency - 1) > l->distance)
        fail_msg("%s: frequency %.12g, not near %.12g", where, p.frequency, j->frequency);
    simulate(m, b->impacts, state, flights, &z);
    if (!(repeats(&z, b->impacts, 1) < RETURNS))
        fail_msg("%s: returns to %.3g", where, repeats(&z, b->impacts, 1));
    for (int k = step; k < b->impacts; k += step)
        if (!(repeats(&z, k, 1) > 1e-2 * l->distance))
            fail_msg("%s: repeats itself to %.3g after %d impacts", where, repeats(&z, k, 1), k);
    bool half = b->impacts % 2 == 0 && repeats(&z, b->impacts / 2, -1) < RETURNS;
    if (half != b->symmetric)
        fail_msg("%s: symmetric %d, but z(t + T/2) + z(t) is %.3g", where, b->symmetric,
                 repeats(&z, b->impacts / 2, -1));
    int struck = impact_mirrors(m, &z, RETURNS), centre = centres(&z, RETURNS);
    const char *seen = struck == 2 && !centre       ? "impact-impact"
                       : centre == 2 && !struck     ? "centre-centre"
                       : struck == 2 && centre == 2 ? "centre-impact"
                                                    : "";
    if (strcmp(seen, b->mirror))
        fail_msg("%s: mirror points %s, but %d impacts turn it round and %d flights pass x = 0",
                 where, b->mirror, struck, centre);
    for (int i = 0; i < b->n_point; i++) {
        ric_check check;
        assert_int_equal(ric_verify_point(atlas, b->id, i, &check), RIC_OK);
        if (!check.passed)
            fail_msg("%s: point %d, flight %.3g, return %.3g", where, i, check.flight_error,
                     check.return_error);
    }
    assert_int_equal(n, z.n);
}

/* At order 3 the energy minimum of the branch may lie between the junction and the first point on
 * one side (section 7). */
static bool turns_before(const ric_atlas *atlas, const ric_junction *j, const leg *l)
{
    const ric_branch *b = &l->branch;
    double near = point_of(atlas, b->id, l->near).arclength, at = NAN;
    for (int i = 0; i < b->n_junction; i++)
        if (b->junctions[i] == j->id) at = b->junction_at[i];
    for (int i = 0; i < b->n_junction; i++)
        if ((b->junction_at[i] - at) * (b->junction_at[i] - near) < 0 &&
            junction_of(atlas, b->junctions[i]).kind == RIC_KIND_EXTREMUM)
            return true;
    return false;
}

/* The rule of docs/theory.md section 8 for a reversible S orbit. Even order: two branches end,
 * which differ in their mirror points and have lost z(t + T/2) = -z(t). Odd order: one branch
 * passes and has all symmetries. Order 3: unstable on both sides and on both sides in energy; above
 * (and at 1/2 of S2-, of order 4), one leg is stable, the other is not, and both lie on one side.
 * Stability is that of all pairs: it tells for two modes only, `plane`. */
static void check_families(const ric_atlas *atlas, const ric_junction *j, int original, bool plane,
                           const char *where)
{
    int p = j->rotation[0], q = j->rotation[1], order = p % 2 ? 2 * q : q, curves;
    leg legs[MAX_LEGS];
    int n = list_legs(atlas, j, original, legs, &curves);
    if (n != 2 || curves != (order % 2 ? 1 : 2))
        fail_msg("%s: %d legs of %d branches at order %d", where, n, curves, order);
    for (int i = 0; i < 2; i++) {
        if (legs[i].branch.symmetric != (order % 2 == 1))
            fail_msg("%s: symmetric %d at order %d", where, legs[i].branch.symmetric, order);
        check_members(atlas, j, &legs[i], where);
    }
    const char *a = legs[0].branch.mirror, *b = legs[1].branch.mirror;
    if (order % 2 ? strcmp(a, "centre-impact") != 0 : !strcmp(a, b))
        fail_msg("%s: mirror points %s and %s", where, a, b);
    int stable = (legs[0].type == RIC_STABLE_YES) + (legs[1].type == RIC_STABLE_YES);
    int unstable = (legs[0].type == RIC_STABLE_NO) + (legs[1].type == RIC_STABLE_NO);
    if (plane && (stable != (order > 3) || unstable != 2 - (order > 3)))
        fail_msg("%s: %d stable, %d unstable at order %d", where, stable, unstable, order);
    bool turned = turns_before(atlas, j, &legs[0]) || turns_before(atlas, j, &legs[1]);
    if (!turned && (legs[0].rise * legs[1].rise > 0) != (order > 3))
        fail_msg("%s: energies off by %.3g and %.3g at order %d", where, legs[0].rise, legs[1].rise,
                 order);
}

/* ------------------------------------------------------------------ two masses */

/* Closed form of S2 (docs/theory.md section 11), omega of the orbit. */
static double closed_form(const ric_model *m, double omega)
{
    double f[2], c[4], top = 0, bottom = 0, half = TWO_PI / omega / 4; /* tau / 2 */
    assert_int_equal(ric_model_frequencies(m, f), RIC_OK);
    assert_int_equal(ric_model_modal_normals(m, c), RIC_OK);
    for (int i = 0; i < 2; i++) {
        top += pow(c[i] / cos(f[i] * half), 2);
        bottom += c[i] * c[i] * tan(f[i] * half) / f[i];
    }
    return top / (2 * bottom * bottom);
}

static int find_labelled(const ric_atlas *atlas, const char *label)
{
    int found = 0;
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++)
        if (!strcmp(branch_of(atlas, id).label, label)) {
            assert_int_equal(found, 0);
            found = id;
        }
    assert_int_not_equal(found, 0);
    return found;
}

/* C_ab, measured or not, is what the kind of the junction allows (docs/theory.md section 7). For
 * two masses with one contact; high on the families that leave, points lie so close together that
 * ranks of a fixed threshold gave C_44 to C_1413. */
static void check_labels(const ric_atlas *atlas)
{
    for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
        ric_junction j = junction_of(atlas, id);
        bool half = false;
        if (j.kind != RIC_KIND_EXTREMUM && j.kind != RIC_KIND_BRANCH_POINT &&
            j.kind != RIC_KIND_MULTIPLICATION) {
            assert_true(j.a == 0 && j.b == 0 && !j.decided && !strchr(j.label, '?'));
            continue;
        }
        for (int k = 0; k < j.n_branch; k++)
            half |= branch_of(atlas, j.branches[k]).symmetric &&
                    branch_of(atlas, j.branches[k]).impacts == j.impacts;
        int b = j.kind == RIC_KIND_EXTREMUM ? 1 : 2, a = half ? 3 : 2;
        if (j.kind == RIC_KIND_MULTIPLICATION) a = b = j.multiple == 2 && !half ? 2 : 3;
        /* A1, and where A2 of constant frequency leaves */
        bool flat = j.decided && !half && j.a == 3 && j.b == b && j.multiple == 1 && j.impacts <= 2;
        if ((j.a != a || j.b != b) && !flat)
            fail_msg("%s %s at E %.12g, %d impacts, multiple %d", ric_kind_text(j.kind), j.label,
                     j.energy, j.impacts, j.multiple);
        assert_true(j.decided != (strchr(j.label, '?') != NULL));
    }
}

/* All rotation numbers p/q of S2-, in the order of the branch. */
static void check_backbone(int q)
{
    char text[512], where[64];
    snprintf(text, sizeof text,
             "model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  contacts:\n"
             "    - {normal: [-1, 1], clearance: 1, sides: both, law: rigid}\n"
             "explore: {start: [2], energy: [0, 2000], frequency: [0.1, 60], impacts: %d, depth: "
             "2, cascade: [%d]}\n",
             2 * q, q);
    ric_atlas *atlas = explore_text(text);
    const ric_model *m = ric_atlas_model(atlas);
    const ric_branch backbone = branch_of(atlas, find_labelled(atlas, "S2-[01]"));
    int last = 0, count = 0;
    for (int i = 0; i < backbone.n_junction; i++) {
        const ric_junction j = junction_of(atlas, backbone.junctions[i]);
        if (j.kind != RIC_KIND_MULTIPLICATION || j.rotation[1] != q) continue;
        snprintf(where, sizeof where, "%d/%d at E %.9g", j.rotation[0], q, j.energy);
        /* the rotation number rises along the branch, so that each p comes once and in its turn */
        if (j.rotation[0] <= last || divisor(j.rotation[0], q) != 1)
            fail_msg("%s: after %d/%d", where, last, q);
        last = j.rotation[0];
        count++;
        if (fabs(j.energy / closed_form(m, q * j.frequency) - 1) > 1e-11)
            fail_msg("%s: not on the branch, E %.15g", where, closed_form(m, q * j.frequency));
        check_families(atlas, &j, backbone.id, true, where);
    }
    for (int p = 1; p < q; p++) count -= divisor(p, q) == 1;
    if (count) fail_msg("q = %d: %d rotation numbers too many", q, count);
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++)
        if (branch_of(atlas, id).stop == RIC_STOP_FAILED)
            fail_msg("q = %d: branch %d: %s", q, id, branch_of(atlas, id).why);
    check_labels(atlas);
    ric_atlas_free(atlas);
}

static void small_orders(void **state)
{
    (void)state;
    for (int q = 2; q <= 4; q++) check_backbone(q);
}

static void larger_orders(void **state)
{
    static const int list[] = {5, 7, 8, 12};
    (void)state;
    for (size_t i = 0; i < sizeof list / sizeof *list; i++) check_backbone(list[i]);
}

/* ---------------------------------------------------------------- three masses */

/* lambda + 1/lambda of half a period of the orbit of a junction, ascending: both real here, and as
 * the two never meet along the branch that is looked at, their order tells which pair is which. */
static void pairs_of(const ric_model *m, const ric_junction *j, double rho[2])
{
    ric_periodic *orbit = ric_periodic_create(m->n, j->impacts);
    ric_shooting *chain = NULL;
    ric_floquet f;
    double *u = NULL;
    memcpy(orbit->face, j->word, (size_t)j->impacts * sizeof *j->word);
    for (int k = 0; k < j->impacts; k++) orbit->tau[k] = j->flights[k] * m->omega_ref;
    ric_model_from_state(m, j->state, j->state + m->n_dof, orbit->w);
    assert_int_equal(ric_periodic_find_symmetries(m, orbit, 1e-8), 1);
    assert_int_equal(ric_periodic_to_chain(m, orbit, &chain, &u), RIC_OK);
    assert_true(ric_shooting_halves(chain));
    ric_shooting_evaluate(chain, u);
    assert_int_equal(ric_floquet_create(m->n, &f), RIC_OK);
    assert_int_equal(ric_floquet_compute(chain, &f), RIC_OK);
    assert_int_equal(f.n_pair, 2);
    assert_true(f.own[1] == 0 && f.own[3] == 0);
    rho[0] = fmin(f.own[0], f.own[2]);
    rho[1] = fmax(f.own[0], f.own[2]);
    ric_floquet_release(&f);
    ric_shooting_free(chain);
    ric_periodic_free(orbit);
    free(u);
}

/* A member goes round the original in the plane of the pair that is at exp(2 pi i p/q), and of no
 * other: its states after k periods of the original are off by d_k with d_{k+1} + d_{k-1} = 2 cos(2
 * pi p/q) d_k, up to the square of the distance. */
static void check_plane(const ric_atlas *atlas, const ric_junction *j, const leg *l,
                        const char *where)
{
    double state[2 * MAX_DOF], flights[MAX_IMPACTS], d[MAX_Q][2 * MAX_DOF], size = 0, off = 0;
    int n = ric_model_n_dof(ric_atlas_model(atlas)), q = j->multiple, step = j->impacts;
    motion z;
    assert_int_equal(ric_atlas_point(atlas, l->branch.id, l->near, NULL, state, flights), RIC_OK);
    simulate(ric_atlas_model(atlas), l->branch.impacts, state, flights, &z);
    for (int i = 0; i < 2 * n; i++) {
        double mean = 0;
        for (int k = 0; k < q; k++) mean += z.after[k * step][i] / q;
        for (int k = 0; k < q; k++) size = fmax(size, fabs(d[k][i] = z.after[k * step][i] - mean));
    }
    for (int k = 0; k < q; k++)
        for (int i = 0; i < 2 * n; i++)
            off = fmax(off, fabs(d[(k + 1) % q][i] + d[(k + q - 1) % q][i] -
                                 2 * cos(TWO_PI * j->rotation[0] / q) * d[k][i]));
    if (!(off < 0.05 * size))
        fail_msg("%s: not in the plane of its multiplier, %.3g of %.3g", where, off, size);
}

/* The branch of the third mode: both pairs are on the unit circle from E 3.15 on, and each passes
 * 2/3 and 3/4, one 1/4, 1/3 and 1/2 as well. */
static void both_pairs_of_three_modes(void **state)
{
    (void)state;
    static const char
        *const text = "model:\n  mass: [[1, 0, 0], [0, 1.3, 0], [0, 0, 0.7]]\n  stiffness: [[6, "
                      "-2, 0], [-2, 5, -3], [0, -3, 7]]\n"
                      "  contacts:\n"
                      "    - {normal: [-1, 1, 0], clearance: 1, sides: both, law: rigid}\n"
                      "explore: {start: [3], energy: [0, 50], frequency: [0.5, 30], impacts: 8, "
                      "multiply: 4, depth: 2}\n";
    ric_atlas *atlas = explore_text(text);
    const ric_branch backbone = branch_of(atlas, find_labelled(atlas, "S2(3)[01]"));
    int seen[2][5][5] = {{{0}}};
    for (int i = 0; i < backbone.n_junction; i++) {
        const ric_junction j = junction_of(atlas, backbone.junctions[i]);
        if (j.kind != RIC_KIND_MULTIPLICATION) continue;
        int p = j.rotation[0], q = j.rotation[1], curves;
        double rho[2], target = 2 * cos(TWO_PI / 2 * p / q);
        char where[64];
        leg legs[MAX_LEGS];
        snprintf(where, sizeof where, "%d/%d at E %.9g", p, q, j.energy);
        pairs_of(ric_atlas_model(atlas), &j, rho);
        int pair = fabs(rho[1] - target) < fabs(rho[0] - target);
        if (!(fabs(rho[pair] - target) < 1e-9) || !(fabs(rho[!pair] - target) > 0.1) ||
            !(fabs(rho[!pair]) < 2))
            fail_msg("%s: pairs %.12g and %.12g", where, rho[0], rho[1]);
        seen[pair][p][q]++;
        check_families(atlas, &j, backbone.id, false, where);
        int n = list_legs(atlas, &j, backbone.id, legs, &curves);
        for (int k = 0; k < n; k++) check_plane(atlas, &j, &legs[k], where);
    }
    for (int pair = 0; pair < 2; pair++)
        for (int q = 2; q <= 4; q++)
            for (int p = 1; p < q; p++) {
                int wanted = divisor(p, q) == 1 && (pair == 1 || p > q - p);
                if (seen[pair][p][q] != wanted)
                    fail_msg("pair %d passes %d/%d %d times", pair, p, q, seen[pair][p][q]);
            }
    ric_atlas_free(atlas);
}

/* Far up the symmetric path, and two doublings on all that leaves in between. */
static void labels_far_up(void **state)
{
    static const char *const options[] = {
        ("energy: [0, 1.0e+5], frequency: [0.2, 10], impacts: 40, multiply: 1, depth: 0, "
         "symmetric: true"),
        "energy: [0, 200], frequency: [0.2, 10], impacts: 24, multiply: 2, depth: 3",
        "energy: [0, 60], frequency: [0.2, 10], impacts: 12, multiply: 4, depth: 2",
    };
    (void)state;
    for (size_t i = 0; i < sizeof options / sizeof *options; i++) {
        char text[512];
        snprintf(text, sizeof text,
                 "model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  contacts:\n"
                 "    - {normal: [-1, 1], clearance: 1, sides: both, law: rigid}\nexplore: {%s}\n",
                 options[i]);
        ric_atlas *atlas = explore_text(text);
        check_labels(atlas);
        ric_atlas_free(atlas);
    }
}

/* Two modes at 2 : 3 under springs of the 11th and 21st power, which small motions do not feel:
 * lambda + 1 / lambda is -2 over a whole interval of energies, to rounding, and passes it nowhere
 * there. */
static void sides_of_a_resonance(void **state)
{
    static const double pairs[4] = {-1, 0, 0.5, 0}, lost[4] = {NAN, NAN, 0.5, 0};
    static const double fine[2] = {1e-14, 1e-14}, loose[2] = {1e-4, 1e-4};
    (void)state;
    assert_true(ric_resonance_side(pairs, fine, 2, 0) < 0);
    assert_true(ric_resonance_side(pairs, fine, 2, 0.5 - 1e-13) < 0);
    assert_true(ric_resonance_side(pairs, fine, 2, 0.5 + 1e-13) > 0);
    assert_true(ric_resonance_side(pairs, fine, 2, 0.5 + 1e-15) == 0);
    assert_true(ric_resonance_side(pairs, loose, 2, 0.5 + 1e-11) > 0); /* two may be that close */
    assert_true(ric_resonance_side(pairs, loose, 2, 0.5 + 1e-12) == 0);
    assert_true(isnan(ric_resonance_side(lost, fine, 2, 0)));
}

static void no_doubling_in_rounding(void **state)
{
    (void)state;
    ric_atlas *atlas = explore_text(
        "model:\n  mass: [[2, 0], [0, 2]]\n  stiffness: [[3.25, -1.25], [-1.25, 3.25]]\n  "
        "contacts:\n"
        "    - {normal: [1, 0], law: power, exponent: 11, length: 1.28, reference: 0.7869}\n"
        "    - {normal: [0, 1], law: power, exponent: 21, length: 1.28, reference: 3.729}\n"
        "explore: {start: [1], energy: [0, 9.163], frequency: [0.2, 4.5], multiply: 2, depth: "
        "1}\n");
    int doublings = 0;
    for (int id = 1; id <= ric_atlas_n_junction(atlas); id++) {
        ric_junction j;
        assert_int_equal(ric_atlas_junction(atlas, id, &j), RIC_OK);
        if (j.kind != RIC_KIND_MULTIPLICATION) continue;
        doublings++;
        assert_true(fabs(j.energy - 6.84086675) < 1e-6);
    }
    assert_int_equal(doublings, 1);
    ric_branch branch;
    assert_int_equal(ric_atlas_branch(atlas, 1, &branch), RIC_OK);
    assert_true(branch.n_point < 200); /* nor are they looked for in the smallest of steps */
    ric_atlas_free(atlas);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(small_orders),
                                       cmocka_unit_test(larger_orders),
                                       cmocka_unit_test(both_pairs_of_three_modes),
                                       cmocka_unit_test(labels_far_up),
                                       cmocka_unit_test(sides_of_a_resonance),
                                       cmocka_unit_test(no_doubling_in_rounding)};
    return cmocka_run_group_tests_name("multiplication", tests, NULL, NULL);
}
