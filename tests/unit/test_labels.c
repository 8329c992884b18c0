/* Labels C_ab by bordered solves, against the dense matrix of eq. 29. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "junction/border.h"
#include "explored.h"
#include "junction/multiplicity.h"
#include "junction/one_period.h"
#include "random_models.h"

enum { LARGEST = 64, WANTED = 8 };

/* The orbit of a node as often as it is multiplied, in the general form and plain. */
static ric_shooting *chain_of(const ric_model *m, const ric_periodic *cycle, int multiple,
                              double **u)
{
    ric_shooting *chain = NULL;
    ric_periodic *whole = ric_periodic_repeat(cycle, multiple);
    assert_non_null(whole);
    whole->half = false;
    whole->pure = whole->flip = -1;
    whole->parts = 0;
    assert_int_equal(ric_periodic_to_chain(m, whole, &chain, u), RIC_OK);
    chain->plain = true;
    ric_shooting_fly(chain, *u);
    ric_periodic_free(whole);
    return chain;
}

/* J of eq. 29 [size * size], column by column; returns its size. */
static int dense(ric_shooting *chain, const double *u, double **out)
{
    int n = chain->n, N = chain->n_flight, unknowns = 2 * n + N, size = unknowns + 1;
    double *G = calloc((size_t)ric_shooting_rows(chain) * (size_t)unknowns, sizeof *G), T = 0;
    double *J = calloc((size_t)size * size, sizeof *J);
    assert_true(G && J);
    assert_int_equal(ric_shooting_jacobian(chain, u, G), unknowns);
    for (int k = 0; k < N; k++) T += u[2 * n + k];
    for (int r = 0; r < unknowns; r++) {
        const double *g = G + (size_t)(r < 2 * n ? N + r : r - 2 * n) *
                                  unknowns; /* G: conditions, then closure */
        double *row = J + (size_t)r * size;
        memcpy(row, g, 2 * (size_t)n * sizeof *row);
        for (int k = 2 * n; k < unknowns; k++) {
            row[k] = g[k] * T;
            row[unknowns] += g[k] * u[k] / T;
        }
    }
    for (int k = 2 * n; k < unknowns; k++) J[(size_t)unknowns * size + k] = 1;
    free(G);
    *out = J;
    return size;
}

static void to_hessenberg(int size, long double *A)
{
    for (int m = 1; m + 1 < size; m++) {
        int pivot = m;
        for (int i = m; i < size; i++)
            if (fabsl(A[i * size + m - 1]) > fabsl(A[pivot * size + m - 1])) pivot = i;
        if (A[pivot * size + m - 1] == 0) continue;
        for (int j = 0; j < size && pivot != m; j++) {
            long double swap = A[pivot * size + j];
            A[pivot * size + j] = A[m * size + j];
            A[m * size + j] = swap;
        }
        for (int j = 0; j < size && pivot != m; j++) {
            long double swap = A[j * size + pivot];
            A[j * size + pivot] = A[j * size + m];
            A[j * size + m] = swap;
        }
        for (int i = m + 1; i < size; i++) {
            long double f = A[i * size + m - 1] / A[m * size + m - 1];
            for (int j = 0; j < size; j++) A[i * size + j] -= f * A[m * size + j];
            for (int j = 0; j < size; j++) A[j * size + m] += f * A[j * size + i];
        }
    }
}

/* The first coefficients of det(A - x I), [WANTED + 1], by the recurrence of Hessenberg matrices
 * (La Budde). */
static void characteristic(int size, const double *J, long double *out)
{
    long double *A = calloc((size_t)size * size, sizeof *A);
    long double(*p)[WANTED + 1] = calloc((size_t)size + 1, sizeof *p);
    assert_true(A && p);
    for (int i = 0; i < size * size; i++) A[i] = J[i];
    to_hessenberg(size, A);
    p[0][0] = 1;
    for (int k = 0; k < size; k++) {
        long double product = 1;
        for (int d = 0; d <= WANTED; d++)
            p[k + 1][d] = A[k * size + k] * p[k][d] - (d > 0 ? p[k][d - 1] : 0);
        for (int back = 1; back <= k; back++) {
            int i = k - back;
            product *= -A[(i + 1) * size + i];
            for (int d = 0; d <= WANTED; d++) p[k + 1][d] += product * A[i * size + k] * p[i][d];
        }
    }
    memcpy(out, p[size], sizeof *p);
    free(A);
    free(p);
}

/* Logarithms of the moduli of the WANTED least roots, as the Newton polygon of the coefficients has
 * them. */
static void least_roots(const long double *p, double *log_root)
{
    double height[WANTED + 1];
    for (int i = 0; i <= WANTED; i++) height[i] = p[i] == 0 ? -300 : (double)log10l(fabsl(p[i]));
    for (int i = 0; i < WANTED;) {
        int next = i + 1;
        for (int j = i + 1; j <= WANTED; j++)
            if ((height[j] - height[i]) * (next - i) >= (height[next] - height[i]) * (j - i))
                next = j;
        for (int k = i; k < next; k++) log_root[k] = (height[i] - height[next]) / (next - i);
        i = next;
    }
}

/* As many roots as the label says lie near 0, and the next one at a hundred times their distance.
 * At less than that, but ten times, the dense matrix does not tell: false. */
static bool check_dense(const ric_model *m, const ric_node *node, int a, int b)
{
    double *u, *J, root[WANTED];
    long double p[WANTED + 1];
    ric_shooting *chain = chain_of(m, node->cycle, node->multiple, &u);
    int size = dense(chain, u, &J);
    characteristic(size, J, p);
    least_roots(p, root);
    if (!(root[a] - root[a - 1] > 1) || root[a - 1] > -2)
        fail_msg("%s at E %.15g, %d events, multiple %d: C_%d%d, but roots of 10^%.1f, %.1f, %.1f, "
                 "%.1f, %.1f",
                 ric_kind_text(node->kind), node->energy, node->cycle->N, node->multiple, a, b,
                 root[0], root[1], root[2], root[3], root[4]);
    free(J);
    free(u);
    ric_shooting_free(chain);
    return root[a] - root[a - 1] > 2;
}

static bool has_label(const ric_node *node)
{
    return node->kind == RIC_KIND_EXTREMUM || node->kind == RIC_KIND_BRANCH_POINT ||
           node->kind == RIC_KIND_MULTIPLICATION;
}

typedef struct {
    int all, decided, checked, kinds[5][5], doubled[5]; /* doubled: of period doublings, by a */
} tally;

static void measure_all(const char *text, tally *t)
{
    ric_study *study = NULL;
    if (ric_study_parse(text, "test", ".", &study)) fail_msg("%s\n%s", ric_detail(), text);
    ric_graph *graph = explored_graph(study);
    for (int i = 0; i < graph->n_node; i++) {
        const ric_node *node = graph->nodes[i];
        int a, b;
        bool decided;
        if (!has_label(node)) continue;
        assert_int_equal(ric_multiplicity(graph->model, node, &a, &b, &decided), RIC_OK);
        t->all++;
        t->decided += decided;
        if (!decided) continue;
        assert_true(a >= b && b >= 1 && a < 5);
        t->kinds[a][b]++;
        if (node->kind == RIC_KIND_MULTIPLICATION && node->multiple == 2) t->doubled[a]++;
        if (2 * graph->model->n + node->cycle->N * node->multiple > LARGEST) continue;
        t->checked += check_dense(graph->model, node, a, b);
    }
    ric_graph_free(graph);
    ric_study_free(study);
}

#define TWO_MASSES                                                                                 \
    "model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  contacts:\n"             \
    "    - {normal: [-1, 1], clearance: 1, sides: both, law: rigid}\n"

/* The article's structure: C_31, C_32 on S orbits, C_21, C_22 on A orbits, C_33 at multiplications,
 * C_22 at doublings of A orbits. Orbits of 14 impacts, whose eigenvalue 0 stands clear, but ranks
 * of powers of J do not tell. */
static void two_masses(void **state)
{
    (void)state;
    tally t = {0};
    measure_all(TWO_MASSES
                "explore: {energy: [0, 200], frequency: [0.2, 10], impacts: 14, depth: 4}\n",
                &t);
    printf("# %d labels, %d decided, %d checked\n", t.all, t.decided, t.checked);
    assert_int_equal(t.decided, t.all);
    assert_true(t.all >= 40 && t.kinds[3][1] > 0 && t.kinds[3][2] > 0 && t.kinds[2][1] > 0 &&
                t.kinds[2][2] > 0 && t.kinds[3][3] > 0);
    memset(&t, 0, sizeof t);
    measure_all(
        TWO_MASSES
        "explore: {energy: [0, 60], frequency: [0.2, 10], impacts: 6, depth: 2, multiply: 5}\n",
        &t);
    printf("# %d labels, %d decided, %d checked\n", t.all, t.decided, t.checked);
    assert_true(t.kinds[3][3] > 20 && t.kinds[2][2] > 5 && t.decided == t.all);
}

/* An orbit a little beside the junction, and another root of unity: nothing to be clear about. */
static void doubts(const ric_model *m, const ric_node *node)
{
    bool clear;
    ric_node *other = ric_node_copy(node);
    assert_non_null(other);
    other->rotation[0] = node->rotation[0] == 1 ? node->multiple - 1 : 1;
    if (2 * (node->rotation[0] % node->multiple) != node->multiple &&
        (node->rotation[0] + other->rotation[0]) % node->multiple != 0) {
        assert_int_equal(ric_one_period_tells(m, other, &clear), RIC_OK);
        assert_false(clear);
    }
    other->rotation[0] = node->rotation[0];
    for (int i = 0; i < 2 * m->n; i++) other->cycle->w[i] *= 1 + 1e-6;
    assert_int_equal(ric_one_period_tells(m, other, &clear), RIC_OK);
    assert_false(clear);
    ric_node_free(other);
}

/* A multiplication by three or more needs one period of its orbit, unless something is close by:
 * `share` percent are told. What is said then is what the dense matrix of all periods says. */
static void tell(const char *text, int share)
{
    ric_study *study = NULL;
    int all = 0, told = 0, checked = 0;
    assert_int_equal(ric_study_parse(text, "test", ".", &study), RIC_OK);
    ric_graph *graph = explored_graph(study);
    for (int i = 0; i < graph->n_node; i++) {
        const ric_node *node = graph->nodes[i];
        bool clear;
        assert_int_equal(ric_one_period_tells(graph->model, node, &clear), RIC_OK);
        if (node->kind != RIC_KIND_MULTIPLICATION || node->multiple < 3) assert_false(clear);
        else all++;
        told += clear;
        if (!clear) continue;
        doubts(graph->model, node);
        if (4 + node->cycle->N * node->multiple > LARGEST) continue;
        checked += check_dense(graph->model, node, 3, 3);
    }
    printf("# %d multiplications, %d of them told by one period, %d checked\n", all, told, checked);
    assert_true(told > 20 && 100 * told >= share * all && checked >= 20);
    ric_graph_free(graph);
    ric_study_free(study);
}

/* Of the longer ones some lie close to another; five within 1e-13 of E beside a fold, where more
 * than three roots are near. */
static void one_period(void **state)
{
    (void)state;
    tell(TWO_MASSES
         "explore: {energy: [0, 60], frequency: [0.2, 10], impacts: 6, depth: 2, multiply: 5}\n",
         98);
    tell(TWO_MASSES
         "explore: {energy: [0, 4], frequency: [0.2, 10], impacts: 11, depth: 3, multiply: 7}\n",
         93);
}

/* Bilinear and power law: the same structure with springs. */
static void springs(void **state)
{
    (void)state;
    tally t = {0};
    measure_all("model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  contacts:\n"
                "    - {normal: [-1, 1], clearance: 1, sides: both, law: bilinear, stiffness: 50}\n"
                "explore: {energy: [0, 20], frequency: [0.2, 10], impacts: 4, depth: 2}\n",
                &t);
    measure_all("model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  contacts:\n"
                "    - {normal: [-1, 1], law: power, stiffness: 1, exponent: 3}\n"
                "explore: {energy: [0, 100], frequency: [0.2, 10], depth: 2}\n",
                &t);
    printf("# %d labels, %d decided, %d checked\n", t.all, t.decided, t.checked);
    assert_true(t.checked >= 8 && t.all - t.decided <= 2);
}

/* A mast of four masses with a guide on one side of the third: doublings of its orbits are C_22 and
 * C_32. */
static void doublings(void **state)
{
    (void)state;
    tally t = {0};
    measure_all("model:\n"
                "  mass: [[0.04, 0, 0, 0], [0, 0.03, 0, 0], [0, 0, 0.02, 0], [0, 0, 0, 0.012]]\n"
                "  stiffness: [[900, -400, 0, 0], [-400, 700, -300, 0], [0, -300, 480, -180],\n"
                "              [0, 0, -180, 180]]\n"
                "  contacts:\n"
                "    - {normal: [0, 0, 1, 0], clearance: 2, sides: upper, law: rigid}\n"
                "explore: {impacts: 8, depth: 2}\n",
                &t);
    printf("# %d labels, %d decided, %d checked\n", t.all, t.decided, t.checked);
    assert_int_equal(t.decided, t.all);
    assert_true(t.checked == t.all && t.doubled[2] > 0 && t.doubled[3] > 0);
}

static char text[4096];

static void add(const char *format, ...) __attribute__((format(printf, 1, 2)));
static void add(const char *format, ...)
{
    va_list values;
    size_t length = strlen(text);
    va_start(values, format);
    vsnprintf(text + length, sizeof text - length, format, values);
    va_end(values);
}

static void add_matrix(const char *name, int n)
{
    double A[n * n];
    random_definite(n, n, 0.4, A);
    add("  %s: [", name);
    for (int i = 0; i < n * n; i++)
        add("%s%.17g%s", i % n ? ", " : i ? ", [" : "[", A[i], i % n == n - 1 ? "]" : "");
    add("]\n");
}

static void random_structures(void **state)
{
    (void)state;
    tally t = {0};
    for (int seed = 1; seed <= 12; seed++) {
        seed_now = (uint64_t)seed;
        int n = 1 + below(5);
        snprintf(text, sizeof text, "model:\n");
        add_matrix("mass", n);
        add_matrix("stiffness", n);
        add("  contacts:\n    - {normal: [");
        for (int i = 0; i < n; i++) add("%s%.3f", i ? ", " : "", uniform(0.2, 1));
        add("], clearance: 1, sides: %s, law: rigid}\n", seed % 3 ? "both" : "upper");
        add("explore: {start: [1], energy: [0, 30], frequency: [0.05, 20], impacts: 6, depth: 2, "
            "multiply: 2}\n");
        measure_all(text, &t);
    }
    printf("# seeds 1 to 12: %d labels, %d decided, %d checked\n", t.all, t.decided, t.checked);
    assert_true(t.checked > 100);
    assert_true(t.all - t.decided <= t.all / 20);
}

/* Some orbit with impacts of a small study. */
static ric_shooting *sample_chain(int multiple, ric_graph **graph, ric_study **study, double **u)
{
    assert_int_equal(ric_study_parse(TWO_MASSES
                                     "explore: {energy: [0, 20], frequency: [0.2, 10], impacts: 4, "
                                     "depth: 1}\n",
                                     "test", ".", study),
                     RIC_OK);
    assert_int_equal(ric_graph_create(*study, NULL, graph), RIC_OK);
    assert_int_equal(ric_graph_explore(*graph, NULL), RIC_OK);
    for (int i = 0; i < (*graph)->n_node; i++)
        if ((*graph)->nodes[i]->kind == RIC_KIND_BRANCH_POINT)
            return chain_of((*graph)->model, (*graph)->nodes[i]->cycle, multiple, u);
    fail();
    return NULL;
}

/* The bordered solve leaves nothing of the dense equations. */
static void solves(void **state)
{
    (void)state;
    ric_graph *graph;
    ric_study *study;
    double *u, *J, g[2], s[2] = {0.3, -0.7};
    ric_shooting *chain = sample_chain(3, &graph, &study, &u);
    int size = dense(chain, u, &J), m = 2 * chain->n;
    double r[size], x[size], largest = 0, kept;
    ric_border *border = ric_border_create(chain);
    assert_non_null(border);
    assert_true(ric_border_factor(border, 0, 0) && ric_border_set(border, border, 2));
    seed_now = 7;
    for (int i = 0; i < size; i++) r[i] = uniform(-1, 1);
    ric_border_solve(border, 1, r, s, x, g);
    for (int i = 0; i < size; i++) {
        double off = -r[i];
        for (int j = 0; j < size; j++) off += J[i * size + j] * x[j];
        for (int k = 0; k < 2 && i < m; k++) off += border->size * border->U[i * 2 + k] * g[k];
        largest = fmax(largest, fabs(off));
    }
    for (int k = 0; k < 2; k++) {
        kept = -s[k]; /* the border is one of (w_0 / size, tau) */
        for (int i = 0; i < m; i++) kept += border->V[i * 2 + k] * x[i] / border->size;
        for (int i = m; i + 1 < size; i++)
            kept += border->V[i * 2 + k] * (border->T * x[i] + u[i] / border->T * x[size - 1]);
        largest = fmax(largest, fabs(kept));
    }
    if (!(largest < 1e-11)) fail_msg("bordered solve leaves %.3g", largest);
    ric_border_free(border);
    ric_shooting_free(chain);
    free(u);
    free(J);
    ric_graph_free(graph);
    ric_study_free(study);
}

static long operations(int multiple)
{
    ric_graph *graph;
    ric_study *study;
    double *u, g[2], s[2] = {1, 0};
    ric_shooting *chain = sample_chain(multiple, &graph, &study, &u);
    ric_border *border = ric_border_create(chain);
    double *x = calloc(2 * (size_t)chain->n_unknown + 2, sizeof *x);
    assert_true(border && x);
    assert_true(ric_border_factor(border, 0, 0) && ric_border_set(border, border, 2));
    ric_border_solve(border, 1, x + chain->n_unknown + 1, s, x, g);
    long count = border->operations;
    ric_border_free(border);
    ric_shooting_free(chain);
    free(u);
    free(x);
    ric_graph_free(graph);
    ric_study_free(study);
    return count;
}

/* Cost of a label in the length of the orbit: slope 1 from 8 to 512 flights and beyond. */
static void cost(void **state)
{
    (void)state;
    double slope = log((double)operations(256) / (double)operations(4)) / log(64);
    printf("# slope %.4f\n", slope);
    assert_true(slope > 0.97 && slope < 1.03);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(solves),
                                       cmocka_unit_test(cost),
                                       cmocka_unit_test(two_masses),
                                       cmocka_unit_test(one_period),
                                       cmocka_unit_test(springs),
                                       cmocka_unit_test(doublings),
                                       cmocka_unit_test(random_structures)};
    return cmocka_run_group_tests_name("labels", tests, NULL, NULL);
}
