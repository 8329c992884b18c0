/* Floquet multipliers: two forms of one orbit, differences of the simulator's motion, determinants,
 * growth near a grazing. */
#include <complex.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "explored.h"
#include "model/modal.h"
#include "multipliers.h"
#include "random_orbits.h"
#include "sample.h"

enum { MAX_N = 5, MAX_CONTACT = 2, MAX_FLIGHT = 4, MAX_SIZE = 2 * MAX_N + MAX_FLIGHT + 1 };

static const double PI = 3.14159265358979323846;

/* ------------------------------------------------------------ two forms agree */

static double slowest(const ric_shooting *c)
{
    double least = HUGE_VAL;
    for (int k = c->start == RIC_MIRROR_IMPACT ? 0 : 1; k <= c->n_flight; k++)
        if (c->face[k] >= 0)
            least = fmin(least, fabs(c->approach[k])); /* ghosts have negative ones */
    return least;
}

/* Coefficients e_1..e_k of prod (x - rho_i), which a near-double root does not disturb; they must
 * be real. */
static void coefficients(const ric_floquet *f, double *e)
{
    double complex p[MAX_N] = {1};
    int k = f->n_pair;
    for (int i = 0; i < k; i++)
        for (int j = i + 1; j > 0; j--) p[j] += p[j - 1] * (f->rho[2 * i] + I * f->rho[2 * i + 1]);
    for (int j = 1; j <= k; j++) {
        e[j - 1] = creal(p[j]);
        if (fabs(cimag(p[j])) > 1e-9 * (1 + cabs(p[j])))
            fail_msg("rho are not pairs of conjugates: e_%d has %.3g i", j, cimag(p[j]));
    }
}

/* The same orbit over the whole or half a period without use of reversibility. */
static ric_shooting *general_form(const ric_model *m, const ric_periodic *cycle, bool half,
                                  double **u)
{
    ric_periodic *copy = ric_periodic_copy(cycle);
    ric_shooting *chain = NULL;
    assert_non_null(copy);
    copy->half = half;
    copy->pure = copy->flip = -1;
    assert_int_equal(ric_periodic_to_chain(m, copy, &chain, u), RIC_OK);
    ric_periodic_free(copy);
    return chain;
}

static double size_of(const ric_floquet *f)
{
    double size = 1;
    for (int i = 0; i < f->n_pair; i++) size = fmax(size, hypot(f->rho[2 * i], f->rho[2 * i + 1]));
    return size;
}

/* Whether rho are worth comparing: finite, and known to a part of their size. */
static bool comparable(const ric_floquet *f)
{
    for (int i = 0; i < 2 * f->n_pair; i++)
        if (!isfinite(f->rho[i])) return false;
    return f->error < 1e-4 * size_of(f);
}

static int compared;

static void compare(const ric_floquet *a, const ric_floquet *b, const char *where)
{
    double x[MAX_N], y[MAX_N];
    if (!comparable(a) || !comparable(b)) return;
    compared++;
    coefficients(a, x);
    coefficients(b, y);
    /* and the orbits' own rounding */
    double size = fmax(size_of(a), size_of(b)),
           tolerance = 4 * (a->error + b->error) + 1e-10 * size;
    for (int i = 0; i < a->n_pair; i++, tolerance *= 2 * size)
        if (!(fabs(x[i] - y[i]) <= tolerance))
            fail_msg("%s: coefficient %d of rho: %.15g and %.15g, error %.3g allowed", where, i + 1,
                     x[i], y[i], tolerance);
    if (a->stable != RIC_STABLE_UNDECIDED && b->stable != RIC_STABLE_UNDECIDED &&
        a->stable != b->stable)
        fail_msg("%s: stable %d and %d, rho %.15g %.15g and %.15g %.15g", where, a->stable,
                 b->stable, a->rho[0], a->rho[1], b->rho[0], b->rho[1]);
    if (a->n_pair != 1) {
        assert_true(isnan(a->trace_asinh) && isnan(a->rotation) && isnan(b->trace_asinh) &&
                    isnan(b->rotation));
        return;
    }
    assert_true(fabs(sinh(a->trace_asinh) * 2 - a->rho[0]) <=
                1e-12 * (1 + fabs(a->rho[0])) * (1 + fabs(a->trace_asinh)));
    if (fabs(a->rho[0]) < 2 - 2 * a->error && fabs(b->rho[0]) < 2 - 2 * b->error) {
        double off = fabs(a->rotation - b->rotation),
               slope = 2 * PI * sqrt(4 - a->rho[0] * a->rho[0]);
        if (!(fmin(off, 1 - off) <= 4 * (a->error + b->error) / slope + 1e-12))
            fail_msg("%s: rotation %.12g and %.12g", where, a->rotation, b->rotation);
        assert_true(fabs(2 * cos(2 * PI * a->rotation) - a->rho[0]) <= 4 * a->error + 1e-12);
    }
}

/* The determinants of the struct against rho: only a symplectic map joins them like this. */
static void check_determinants(const ric_shooting *chain, const ric_floquet *f, const char *where)
{
    int k = f->n_pair;
    bool reversible = chain->start != RIC_MIRROR_NONE;
    double complex product = 1;
    double full, product_error = fabs(f->det_a) * f->error_d + fabs(f->det_d) * f->error_a, off;
    if (reversible && chain->multiple == 2) { /* prod (rho + 2) = det (4 d'a) */
        full = pow(4, k) * f->det_a * f->det_d;
        off = pow(4, k) * product_error;
    } else if (k == 1 &&
               (reversible || chain->sigma < 0)) { /* r of the half-period map, rho + 2 = r^2 */
        double r = (reversible ? 4 * f->det_a * f->det_d : f->det_a) - 2;
        full = r * r;
        off = 2 * fabs(r) * (reversible ? 4 * product_error : f->error_a);
    } else return;
    for (int i = 0; i < k; i++) product *= f->rho[2 * i] + I * f->rho[2 * i + 1] + 2;
    double tolerance = 8 * off + 8 * k * f->error * pow(size_of(f) + 2, k - 1) +
                       1e-12 * cabs(product);
    if (!(fabs(full - creal(product)) <= tolerance))
        fail_msg("%s: prod (rho + 2) = %.15g, from determinants %.15g, error %.3g allowed", where,
                 creal(product), full, tolerance);
}

static void forms_agree(void **state)
{
    (void)state;
    double u[MAX_SIZE], *v, *w;
    int stable = 0;
    char where[96];
    compared = 0;
    for (int n = 2; n <= MAX_N; n++)
        for (int form = 1; form < N_FORM; form++)
            for (int trial = 0; trial < 16; trial += every()) {
                uint64_t seed = 10000u * (uint64_t)n + 100u * (uint64_t)form + (uint64_t)trial;
                ric_model *m = random_structure_of(seed, n, 1 + trial % 2, trial % 8 == 7, false);
                /* at least one impact in every form */
                ric_shooting *chain = random_orbit(m, form, 2 + below(MAX_FLIGHT - 1), u);
                ric_periodic *cycle = chain ? ric_periodic_from_chain(chain, u) : NULL;
                if (cycle && slowest(chain) > 1e-3 && primitive(m, cycle)) {
                    snprintf(where, sizeof where, "seed %llu, n = %d, form %d, %d flights",
                             (unsigned long long)seed, n, form, chain->n_flight);
                    ric_shooting *general = general_form(m, cycle, false, &v);
                    ric_floquet a = multipliers(chain, u), b = multipliers(general, v);
                    compare(&a, &b, where);
                    if (size_of(&a) < 1e5) check_determinants(chain, &a, where);
                    stable += a.stable == RIC_STABLE_YES;
                    if (cycle->half && form > 1) {
                        ric_shooting *half = general_form(m, cycle, true, &w);
                        ric_floquet c = multipliers(half, w);
                        compare(&a, &c, where);
                        if (size_of(&c) < 1e5) check_determinants(half, &c, where);
                        ric_floquet_release(&c);
                        ric_shooting_free(half);
                        free(w);
                    }
                    ric_floquet_release(&a);
                    ric_floquet_release(&b);
                    ric_shooting_free(general);
                    free(v);
                }
                ric_periodic_free(cycle);
                ric_shooting_free(chain);
                ric_model_free(m);
            }
    print_message("# %d comparisons, %d stable orbits\n", compared, stable);
    assert_true(compared > 200 && stable > 10);
}

/* --------------------------------------------------- the simulator's motion */

static const char *const studies[] = {
    "model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  contacts: [{normal: [-1, "
    "1], clearance: 1}]\n"
    "explore: {energy: [0, 90], frequency: [0.2, 10], impacts: 6, multiply: 1, depth: 3}\n",
    "model:\n  mass: [[2, 0, 0], [0, 1, 0], [0, 0, 1.5]]\n  stiffness: [[9, -1, 0], [-1, 2.3, "
    "-1.3], [0, -1.3, 1.3]]\n"
    "  contacts: [{normal: [-1, 1, 0], clearance: 1}]\nexplore: {energy: [0, 60], frequency: [0.2, "
    "10], impacts: 4, "
    "multiply: 1, depth: 2}\n",
    "model:\n  mass: [[1, 0, 0, 0], [0, 1.2, 0, 0], [0, 0, 0.8, 0], [0, 0, 0, 1]]\n"
    "  stiffness: [[3, -1, 0, 0], [-1, 2.4, -1.4, 0], [0, -1.4, 2.1, -0.7], [0, 0, -0.7, 0.9]]\n"
    "  contacts: [{normal: [0, 0, 0, 1], clearance: 1}]\nexplore: {energy: [0, 40], frequency: "
    "[0.1, 10], impacts: 4, "
    "multiply: 1, depth: 2}\n",
};

/* Motion from (x, v) for `time` seconds, in place. */
static void simulate(ric_simulator *sim, int n, double time, double *x, double *v)
{
    bool hit = true;
    (void)n;
    if (ric_simulator_start(sim, x, v)) fail_msg("%s", ric_detail());
    while (hit)
        if (ric_simulator_advance(sim, time, &hit, NULL)) fail_msg("%s", ric_detail());
    ric_simulator_state(sim, NULL, x, v);
}

/* Derivative of the state (x, v) after one period with respect to the state in the middle of the
 * longest flight: differences of fourth order in h. M [2n * 2n]. */
static void differenced_monodromy(const ric_model *m, const ric_periodic *cycle, double h,
                                  double *M)
{
    static const double weight[4] = {1.0 / 12, -2.0 / 3, 2.0 / 3, -1.0 / 12},
                        offset[4] = {-2, -1, 1, 2};
    int n = m->n_dof, longest = 0;
    double w[2 * MAX_N], z[2 * MAX_N], y[2 * MAX_N];
    ric_simulator *sim = NULL;
    for (int i = 1; i < cycle->N; i++)
        if (cycle->tau[i] > cycle->tau[longest]) longest = i;
    ric_periodic *moved = ric_periodic_transform(m, cycle, longest, false, false);
    ric_flight_go(m, moved->closed, moved->face[0], moved->tau[0] / 2, moved->w, w);
    ric_model_to_state(m, w, z, z + n);
    assert_int_equal(ric_simulator_create(m, &sim), RIC_OK);
    memset(M, 0, 4 * (size_t)(n * n) * sizeof *M);
    for (int j = 0; j < 2 * n; j++)
        for (int k = 0; k < 4; k++) {
            memcpy(y, z, sizeof z);
            y[j] += offset[k] * h;
            simulate(sim, n, ric_periodic_period(cycle) / m->omega_ref, y, y + n);
            for (int i = 0; i < 2 * n; i++) M[i * 2 * n + j] += weight[k] * y[i] / h;
        }
    ric_simulator_free(sim);
    ric_periodic_free(moved);
}

static void multiply(int n, const double *A, const double *B, double *C)
{
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            double sum = 0;
            for (int k = 0; k < n; k++) sum += A[i * n + k] * B[k * n + j];
            C[i * n + j] = sum;
        }
}

/* M' S M = S with S = [[0, mass], [-mass, 0]]: what the differences are worth. */
static double symplectic_error(const ric_model *m, const double *M)
{
    int n = m->n_dof;
    double S[4 * MAX_N * MAX_N] = {0}, T[4 * MAX_N * MAX_N], P[4 * MAX_N * MAX_N],
                         R[4 * MAX_N * MAX_N], worst = 0;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            S[i * 2 * n + n + j] = m->M[i * n + j];
            S[(n + i) * 2 * n + j] = -m->M[i * n + j];
        }
    for (int i = 0; i < 2 * n; i++)
        for (int j = 0; j < 2 * n; j++) T[i * 2 * n + j] = M[j * 2 * n + i];
    multiply(2 * n, T, S, P);
    multiply(2 * n, P, M, R);
    for (int i = 0; i < 4 * n * n; i++) worst = fmax(worst, fabs(R[i] - S[i]));
    return worst;
}

/* Traces of M, M^2, M^3: two trivial multipliers 1, and rho, rho^2 - 2, rho^3 - 3 rho for each
 * pair. */
static bool check_monodromy(const ric_model *m, const ric_periodic *cycle, const ric_floquet *f,
                            const char *where)
{
    int n = m->n_dof;
    double M[4 * MAX_N * MAX_N], P[4 * MAX_N * MAX_N], Q[4 * MAX_N * MAX_N], top = 1, off = 0;
    differenced_monodromy(m, cycle, 6e-5, Q);
    differenced_monodromy(m, cycle, 3e-5, M);
    for (int i = 0; i < 4 * n * n; i++) {
        top = fmax(top, fabs(M[i]));
        off = fmax(off, fabs(M[i] - Q[i]));
    }
    double error = symplectic_error(m, M);
    if (error > 1e-5 * top * top)
        return false; /* an impact was lost or won within the differences */
    memcpy(P, M, sizeof M);
    for (int power = 1; power <= 3; power++) {
        double trace = -2, sum = 0;
        for (int i = 0; i < 2 * n; i++) trace += P[i * 2 * n + i];
        for (int i = 0; i < f->n_pair; i++) {
            double complex rho = f->rho[2 * i] + I * f->rho[2 * i + 1];
            sum += creal(power == 1 ? rho : power == 2 ? rho * rho - 2 : rho * rho * rho - 3 * rho);
        }
        if (!(fabs(trace - sum) <= (1e-5 * top + off) * pow(2 * n * top, power - 1)))
            fail_msg("%s: trace of M^%d is %.10g + 2 by differences, %.10g + 2 from rho; largest "
                     "entry %.3g",
                     where, power, trace, sum, top);
        multiply(2 * n, M, P, Q);
        memcpy(P, Q, sizeof Q);
    }
    return true;
}

typedef struct {
    int done, skipped, stable, inner; /* `inner`: impacts within a chain: saltation counts */
    int closed;                       /* those that meet a stop while a spring is closed */
} tally;

static void count_impacts(const ric_shooting *c, tally *t)
{
    for (int k = 1; k < c->n_flight; k++) {
        bool stop = c->face[k] >= 0 && c->model->face[c->face[k]].spring == 0;
        t->inner += stop;
        t->closed += stop && c->closed[k];
    }
}

static void check_point(const ric_continuation *trace, const double *u, const char *where, tally *t)
{
    const ric_model *m = trace->chain->model;
    ric_floquet f = multipliers(trace->chain, u);
    if (f.stable == RIC_STABLE_YES || (comparable(&f) && size_of(&f) < 1000)) {
        ric_periodic *cycle = ric_periodic_from_chain(trace->chain, u);
        if (check_monodromy(m, cycle, &f, where)) {
            t->done++;
            t->stable += f.stable == RIC_STABLE_YES;
            count_impacts(trace->chain, t);
        } else t->skipped++;
        ric_periodic_free(cycle);
    }
    ric_floquet_release(&f);
}

/* Every third point of all branches of a study. */
static void check_study(const char *text, const char *name, tally *t)
{
    ric_study *study = NULL;
    if (ric_study_parse(text, "study", ".", &study)) fail_msg("%s", ric_detail());
    ric_graph *graph = explored_graph(study);
    const ric_model *m = graph->model;
    assert_int_equal(m->n, m->n_dof);
    for (int e = 0; e < graph->n_edge; e++) {
        const ric_continuation *trace = graph->edges[e].trace;
        for (int i = 0; trace && i < trace->n_point; i += 3) {
            const double *at = trace->points + (size_t)i * trace->stride;
            const ric_point *row = (const ric_point *)at;
            char where[160];
            if (row->approach < 0.1 || row->reach > 0.97) continue;
            snprintf(where, sizeof where, "%s, n = %d, branch %d, point %d, E %.6g", name, m->n, e,
                     i, row->energy);
            check_point(trace, at + sizeof(ric_point) / sizeof(double), where, t);
        }
    }
    ric_graph_free(graph);
    ric_study_free(study);
}

static void simulator_agrees(void **state)
{
    (void)state;
    for (int s = 0; s < 3; s++) {
        tally t = {0};
        check_study(studies[s], "rigid", &t);
        print_message("# study %d: %d orbits, %d stable, %d inner impacts, %d left out\n", s,
                      t.done, t.stable, t.inner, t.skipped);
        assert_true(t.done >= 10 && t.stable >= 3 && t.inner >= 3 && t.skipped <= t.done / 4);
    }
}

static void print_matrix(int n, const double *A, FILE *out)
{
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            fprintf(out, "%s%.6f%s",
                    j   ? ", "
                    : i ? ", ["
                        : "[[",
                    A[i * n + j],
                    j + 1 < n   ? ""
                    : i + 1 < n ? "]"
                                : "]]");
}

/* A stop and one or two springs that close before it is met; walls on one side and on both. */
static char *mixed_study(uint64_t seed, int n)
{
    static const char *const sides[] = {"both", "upper", "both", "lower"};
    double M[MAX_N * MAX_N], K[MAX_N * MAX_N];
    char *text = NULL;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    seed_now = seed;
    random_definite(n, n, 0.5, M);
    random_definite(n, n, 0.3, K);
    fprintf(out, "model:\n  mass: ");
    print_matrix(n, M, out);
    fprintf(out, "\n  stiffness: ");
    print_matrix(n, K, out);
    fprintf(out, "\n  contacts:\n");
    for (int f = 0, springs = 1 + below(2); f <= springs; f++) {
        fprintf(out, "    - {normal: [");
        for (int i = 0; i < n; i++) fprintf(out, "%s%.4f", i ? ", " : "", uniform(-1, 1));
        fprintf(out, "], clearance: %.4f, sides: %s", f ? uniform(0.1, 0.5) : 1, sides[below(4)]);
        if (f) fprintf(out, ", law: bilinear, stiffness: %.3f", uniform(0.3, 4));
        fprintf(out, "}\n");
    }
    fprintf(
        out,
        "explore: {energy: [0, 60], frequency: [0.1, 10], impacts: 10, multiply: 2, depth: %d}\n",
        n == 2 ? 3 : 2);
    fclose(out);
    return text;
}

/* The force of a closed spring counts where a stop is met. */
static void closed_springs_count(void **state)
{
    (void)state;
    tally t = {0};
    const int few = every_of(4);
    for (int n = 2; n <= MAX_N; n++)
        for (uint64_t trial = 0; trial < (n == 2 ? 16 : 2); trial += (uint64_t)few) {
            uint64_t seed = 700 + 20 * (uint64_t)n + trial;
            char *text = mixed_study(seed, n), name[32];
            snprintf(name, sizeof name, "mixed, seed %llu", (unsigned long long)seed);
            check_study(text, name, &t);
            free(text);
        }
    print_message("# mixed: %d orbits, %d stable, %d inner impacts on stops, %d of them with a "
                  "closed spring, %d left "
                  "out\n",
                  t.done, t.stable, t.inner, t.closed, t.skipped);
    assert_true(t.closed >= (few > 1 ? 10 : 60) && t.stable >= 10 && t.skipped <= t.done / 4);
}

/* -------------------------------------------------------------- near a grazing */

static int count_bits(unsigned x)
{
    int bits = 0;
    for (; x; x &= x - 1) bits++;
    return bits;
}

/* From the stored end of a branch inwards: tau2 grows like one over the speed to the power of the
 * touches kept as impacts. */
static bool check_growth(const ric_continuation *trace, bool far, int power, const char *where)
{
    ric_shooting *c = ric_shooting_copy(trace->chain);
    int size = c->n_unknown, last = trace->n_point - 1, steps;
    const double *end = trace->points + (size_t)(far ? last : 0) * trace->stride +
                        sizeof(ric_point) / sizeof(double);
    const double *next = trace->points + (size_t)(far ? last - 1 : 1) * trace->stride +
                         sizeof(ric_point) / sizeof(double);
    double t[size], u[size], du[size], before[2] = {0, 0};
    for (int i = 0; i < size; i++) t[i] = next[i] - end[i];
    ric_shooting_evaluate(c, end);
    memcpy(u, t, sizeof u);
    ric_continuation_tangent(c, u, t);
    ric_floquet at = multipliers(c, end); /* the very end: speeds at rounding level */
    if (isnan(at.trace_asinh))
        fail_msg("%s: the trace is NaN at the grazing itself, speed %.3g, form %d-%d", where,
                 slowest(c), c->start, c->end);
    if (!(fabs(slowest(c)) < 1e-7))
        fail_msg("%s: slowest impact at the grazing %.3g", where, slowest(c));
    ric_floquet_release(&at);
    for (int k = 3; k <= 7; k++) {
        double s = pow(10, -k);
        for (int i = 0; i < size; i++) u[i] = end[i] + s * t[i];
        if (!ric_continuation_correct(c, u, end, t, s, du, &steps))
            fail_msg("%s: no orbit at distance %.1g", where, s);
        double v = log(slowest(c));
        ric_floquet f = multipliers(c, u);
        double slope = (fabs(f.trace_asinh) - before[1]) / (v - before[0]);
        if (!isfinite(f.trace_asinh)) fail_msg("%s: trace overflows", where);
        if (k > 4 && !(slope > -1.05 * power && slope < -0.95 * power))
            fail_msg("%s: tau2 grows as v^%.3f, not v^-%d, at distance %.1g", where, slope, power,
                     s);
        if (k > 4) assert_int_equal(f.stable, RIC_STABLE_NO);
        before[0] = v;
        before[1] = fabs(f.trace_asinh);
        ric_floquet_release(&f);
    }
    ric_shooting_free(c);
    return true;
}

static void growth_near_grazing(void **state)
{
    (void)state;
    ric_study *study = NULL;
    int seen[5] = {0};
    assert_int_equal(ric_study_read("examples/elementary/study.yaml", &study), RIC_OK);
    ric_graph *graph = explored_graph(study);
    for (int e = 0; e < graph->n_edge; e++) {
        const ric_edge *edge = &graph->edges[e];
        if (!edge->trace) continue;
        for (int far = 0; far < 2; far++) {
            int node = far ? edge->to : edge->from;
            unsigned choice = far ? edge->arrive : edge->leave;
            if (node < 0 || graph->nodes[node]->kind != RIC_KIND_GRAZING ||
                graph->nodes[node]->mode >= 0)
                continue;
            int power = count_bits(choice);
            if (power == 0) continue;
            char where[64];
            snprintf(where, sizeof where, "branch %d at E %.6g, %d touches", e,
                     graph->nodes[node]->energy * graph->model->energy_unit, power);
            if (check_growth(edge->trace, far, power, where)) seen[power]++;
        }
    }
    print_message("# ends with 1, 2, 3, 4 touches: %d %d %d %d\n", seen[1], seen[2], seen[3],
                  seen[4]);
    assert_true(seen[1] && seen[2] && seen[3] && seen[4]);
    ric_graph_free(graph);
    ric_study_free(study);
}

/* A free train of wagons, of which two impacts are loose to both sides: beside a grazing one pair
 * of multipliers has 14 digits more than the other. Two branches that are images of each other, and
 * multipliers from 60-digit arithmetic. */
static const char wagons[] =
    "title: wagons\nmodel:\n"
    "  mass: [[3, 0, 0, 0], [0, 1.2, 0, 0], [0, 0, 2, 0], [0, 0, 0, 0.7]]\n"
    "  stiffness: [[4, -4, 0, 0], [-4, 9, -5, 0], [0, -5, 8, -3], [0, 0, -3, 3]]\n"
    "  contacts:\n"
    "    - {normal: [-1, 1, 0, 0], clearance: 0.004, sides: both, law: rigid}\n"
    "    - {normal: [0, 0, -1, 1], clearance: 0.006, sides: upper, law: rigid}\n"
    "explore: {start: modes, energy: [0, 30], frequency: [0.3, 8], impacts: 6, multiply: 2,"
    " depth: 2}\n";

static void small_beside_large(void **state)
{
    (void)state;
    static const double exact[][3] = {{6.965465, 232151067027125.0, -66.4621436619562},
                                      {6.97, 1789962664685.59, -67.1765567981331},
                                      {7.09, 105078655983410.0, -86.708045551144}};
    ric_atlas *atlas = explore_text(wagons);
    int images = 0;
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        ric_branch b = branch_of(atlas, id);
        if (strcmp(b.label, "A4[0011]")) continue;
        images++;
        assert_int_equal(b.n_junction, 0);
        assert_null(strstr(b.why, "converge"));
        for (size_t i = 0; i < sizeof exact / sizeof *exact; i++) {
            ric_orbit **orbits;
            int n;
            double p[8];
            assert_int_equal(ric_orbit_find(atlas, id, RIC_AT_ENERGY, exact[i][0], &n, &orbits),
                             RIC_OK);
            assert_int_equal(n, 1);
            ric_orbit_multipliers(orbits[0], p);
            int large = fabs(p[0]) < fabs(p[4]) ? 4 : 0, small = 4 - large;
            if (!(fabs(p[large] / exact[i][1] - 1) < 1e-7) ||
                !(fabs(p[small] / exact[i][2] - 1) < 1e-6))
                fail_msg("branch %d, E %g: multipliers %.15g and %.15g", id, exact[i][0], p[large],
                         p[small]);
            ric_orbits_free(n, orbits);
        }
    }
    assert_int_equal(images, 2);
    assert_int_equal(ric_atlas_n_unplaced(atlas), 0);
    ric_atlas_free(atlas);
}

/* The general form has the whole period in one matrix and loses the small pair: it says so, or is
 * right. */
static void lost_or_right(void **state)
{
    (void)state;
    ric_study *study = NULL;
    int lost = 0, right = 0;
    assert_int_equal(ric_study_parse(wagons, "test", ".", &study), RIC_OK);
    ric_graph *graph = explored_graph(study);
    for (int e = 0; e < graph->n_edge; e++) {
        const ric_continuation *trace = graph->edges[e].trace;
        for (int i = 1; trace->chain->start != RIC_MIRROR_NONE && i + 1 < trace->n_point;
             i += every()) {
            const double *u = trace->points + (size_t)i * trace->stride +
                              sizeof(ric_point) / sizeof(double);
            double *v = NULL;
            ric_periodic *cycle = ric_continuation_cycle(trace, u);
            ric_shooting *whole = general_form(graph->model, cycle, false, &v);
            ric_floquet own = multipliers(trace->chain, u), other = multipliers(whole, v);
            for (int k = 0; k < 2; k++) {
                double best = HUGE_VAL, *r = other.rho + 2 * k, size = 1 + hypot(r[0], r[1]);
                for (int l = 0; l < 2; l++)
                    best = fmin(best, hypot(r[0] - own.rho[2 * l], r[1] - own.rho[2 * l + 1]));
                lost += isnan(r[0]);
                right += best < 1e-3 * size;
                if (!isnan(r[0]) && isfinite(own.rho[0] + own.rho[2]) && !(best < 1e-3 * size))
                    fail_msg("edge %d, point %d: rho %.9g + %.3g i by the whole period, %.9g and "
                             "%.9g by half of it",
                             e, i, r[0], r[1], own.rho[0], own.rho[2]);
            }
            ric_floquet_release(&own);
            ric_floquet_release(&other);
            ric_shooting_free(whole);
            ric_periodic_free(cycle);
            free(v);
        }
    }
    print_message("# general form: %d pairs right, %d lost\n", right, lost);
    assert_true(right > 100 && lost > 2 && lost < 20);
    ric_graph_free(graph);
    ric_study_free(study);
}

/* k times around an unstable orbit: the multiplier to the power of k, far beyond the range of a
 * double. */
static void no_overflow(void **state)
{
    (void)state;
    double u[MAX_SIZE], *v, *w;
    int done = 0;
    for (uint64_t seed = 1; seed <= 40; seed += (uint64_t)every()) {
        ric_model *m = random_structure_of(seed, 2, 1, false, false);
        ric_shooting *chain = random_orbit(m, 0, 3, u);
        ric_periodic *cycle = chain ? ric_periodic_from_chain(chain, u) : NULL;
        if (cycle) {
            ric_shooting *one = general_form(m, cycle, false, &v);
            ric_floquet a = multipliers(one, v);
            if (comparable(&a) && fabs(a.rho[0]) > 5) {
                int k = 3001;
                ric_periodic *longer = ric_periodic_create(m->n, k * cycle->N);
                assert_non_null(longer);
                for (int i = 0; i < k * cycle->N; i++) {
                    longer->face[i] = cycle->face[i % cycle->N];
                    longer->tau[i] = cycle->tau[i % cycle->N];
                }
                memcpy(longer->w, cycle->w, 2 * (size_t)m->n * sizeof *cycle->w);
                ric_shooting *many = general_form(m, longer, false, &w);
                ric_floquet b = multipliers(many, w);
                double expected = k * acosh(fabs(a.rho[0]) / 2),
                       relative = a.error / fabs(a.rho[0]) + 1e-9;
                if (!(fabs(fabs(b.trace_asinh) - expected) <= 1e-6 * expected + 4 * k * relative) ||
                    (b.trace_asinh > 0) != (a.rho[0] > 0))
                    fail_msg("seed %llu: %d times around: log of tau2 %.12g, expected %.12g (sign "
                             "of tau2 once: %g)",
                             (unsigned long long)seed, k, b.trace_asinh, expected,
                             copysign(1, a.rho[0]));
                assert_int_equal(b.stable, RIC_STABLE_NO);
                done++;
                ric_floquet_release(&b);
                ric_shooting_free(many);
                ric_periodic_free(longer);
                free(w);
            }
            ric_floquet_release(&a);
            ric_shooting_free(one);
            free(v);
        }
        ric_periodic_free(cycle);
        ric_shooting_free(chain);
        ric_model_free(m);
    }
    print_message("# %d orbits taken 3001 times around\n", done);
    assert_true(done >= 5);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(forms_agree),          cmocka_unit_test(simulator_agrees),
        cmocka_unit_test(closed_springs_count), cmocka_unit_test(growth_near_grazing),
        cmocka_unit_test(small_beside_large),   cmocka_unit_test(lost_or_right),
        cmocka_unit_test(no_overflow),
    };
    return cmocka_run_group_tests_name("floquet", tests, NULL, NULL);
}
