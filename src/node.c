#include "node.h"

#include <stdlib.h>
#include <string.h>

#include <lapacke.h>

#include "corner.h"
#include "motion.h"
#include "status.h"

#define TOUCH 1e-9      /* reach within this of 1 at a located event is a touch */
#define NO_SPEED 1e-7   /* approach speed below this (scaled) at a located event is a touch that was kept */
#define SAME 1e-6       /* two located orbits closer than this (relative) are one */
#define FIXED 1e-5      /* distance of an orbit from its image at which a corner counts as its own */
#define FAR 1e-3        /* a located orbit that moves farther when it is solved on its own equations is another one */
#define TRIAL 1e-4      /* first trial step of a departure, relative to the size of the orbit; its tenth must agree */
#define SECANT 1e-4      /* distance, relative, of the point that gives the direction of a side branch */
#define TEST_ROTATION 100 /* criterion: lambda + 1/lambda of some pair reaches a given value */
#define GRAIN 0x1p-32   /* canonical orbits are re-solved from unknowns rounded to this, so that they do not remember where they came from */

void ric_node_free(ric_node *node)
{
    if (!node) return;
    ric_cycle_free(node->cycle);
    for (int i = 0; i < node->n_departure; i++) free(node->departures[i].why);
    free(node->departures);
    free(node);
}

static ric_node *node_create(const ric_model *m, ric_kind kind, ric_cycle *cycle)
{
    ric_node *node = cycle ? calloc(1, sizeof *node) : NULL;
    if (!node) {
        ric_cycle_free(cycle);
        return NULL;
    }
    node->kind = kind;
    node->cycle = cycle;
    node->test = -1;
    node->multiple = 1;
    node->mode = -1;
    node->energy = ric_cycle_energy(m, cycle);
    node->period = ric_cycle_period(cycle);
    return node;
}

static ric_status no_memory(void)
{
    return ric_fail(RIC_E_NOMEM, "no memory for a junction");
}

/* ------------------------------------------------------- located on a chain */

/* What vanishes at a junction, as a function of the point on the curve. */
typedef struct {
    ric_chain *chain;
    ric_floquet floquet;
    int test;
    int place;     /* in the chain, of the impact or flight in question */
    const double *u;
    double target; /* lambda + 1/lambda, for a q-tupling */
    double *along; /* direction of the curve in the unknowns of the problem without the symmetry that breaks; owned */
} criterion;

/* Takes from a cycle the symmetries that a kernel of the given type breaks; `form` is its chain with all of them. */
static void drop_symmetry(ric_cycle *c, int test, const ric_chain *form)
{
    if (form->multiple == 4) {
        /* a quarter starts at a centre: kernels of type a keep it, of type d keep the other mirror, of type b only z(t+T/2) = -z(t) */
        if (test == RIC_TEST_A) c->pure = -1, c->half = false;
        else if (test == RIC_TEST_D) c->flip = -1, c->half = false;
        else c->pure = c->flip = -1;
    } else {
        c->pure = c->flip = -1;
        c->half = false;
    }
}

/* Bordered determinant of the problem without the symmetry that breaks, at the symmetric orbit u: it vanishes where the factors of section 5
 * do, but does not divide by impact speeds and keeps its digits however unstable the orbit is. */
static double broken_determinant(criterion *q, const double *u)
{
    ric_chain *large = NULL;
    double *v = NULL, value = NAN;
    ric_cycle *cycle = ric_cycle_from_chain(q->chain, u);
    if (!cycle) return NAN;
    drop_symmetry(cycle, q->test, q->chain);
    if (!ric_cycle_to_chain(q->chain->model, cycle, &large, &v)) {
        double t[large->n_unknown];
        ric_chain_evaluate(large, v);
        double sign = ric_trace_tangent(large, q->along, t);
        value = sign * large->end_det;
        if (!q->along && (q->along = malloc(sizeof t))) memcpy(q->along, t, sizeof t);
    }
    ric_chain_free(large);
    ric_cycle_free(cycle);
    free(v);
    return value;
}

static double evaluate(criterion *q, const double *u, const double *t, double orientation)
{
    const ric_chain *c = q->chain;
    switch (q->test) {
    case RIC_TEST_APPROACH: return c->approach[q->place];
    case RIC_TEST_SLOPE: return ric_chain_energy_slope(c, t) / c->scale;
    case RIC_TEST_DET: return orientation * c->end_det;
    case RIC_TEST_FLIGHT: return q->u[c->n_start + q->place];
    case RIC_TEST_PERIOD: {
        double sum = 0;
        for (int k = c->n_start; k < c->n_unknown; k++) sum += t[k];
        return sum;
    }
    case TEST_ROTATION: {
        if (ric_floquet_compute(c, &q->floquet)) return NAN;
        double nearest = HUGE_VAL;
        for (int i = 0; i < q->floquet.n_pair; i++)
            if (fabs(q->floquet.rho[2 * i] - q->target) < fabs(nearest)) nearest = q->floquet.rho[2 * i] - q->target;
        return nearest;
    }
    default: return broken_determinant(q, u);
    }
}

/* Secant iteration along the curve from u to the zero of the criterion. u is moved there. */
static bool solve_criterion(criterion *q, double *u)
{
    ric_chain *c = q->chain;
    int size = c->n_unknown, iterations;
    double du[size], origin[size], normal[size], t[size], best[size];
    double x0 = 0, x1 = 0, f0 = 0, f1, least = HUGE_VAL;
    q->u = u;
    if (!ric_trace_correct(c, u, NULL, NULL, 0, du, &iterations)) return false;
    memcpy(origin, u, sizeof origin);
    ric_trace_tangent(c, NULL, normal);
    f1 = evaluate(q, u, normal, 1);
    for (int i = 0; i < 30; i++) {
        if (fabs(f1) < least) {
            least = fabs(f1);
            memcpy(best, u, sizeof best);
        } else if (i > 4) break;
        if (f1 == 0) break;
        double x2 = i == 0 ? x1 + 1e-6 * c->scale : x1 - f1 * (x1 - x0) / (f1 - f0);
        if (!isfinite(x2) || fabs(x2) > 1e-2 * c->scale) break;
        x0 = x1;
        f0 = f1;
        x1 = x2;
        for (int j = 0; j < size; j++) u[j] = origin[j] + x1 * normal[j];
        if (!ric_trace_correct(c, u, origin, normal, x1, du, &iterations)) return false;
        double sign = ric_trace_tangent(c, normal, t);
        f1 = evaluate(q, u, t, sign);
        if (x1 == x0) break;
    }
    memcpy(u, best, sizeof best);
    ric_chain_evaluate(c, u);
    return true;
}

/* Impact of the chain (index into approach) whose speed is smallest. */
static int slowest(const ric_chain *c)
{
    int best = -1;
    for (int k = c->start == RIC_MIRROR_IMPACT ? 0 : 1; k <= c->n_flight; k++)
        if (c->face[k] >= 0 && (best < 0 || fabs(c->approach[k]) < fabs(c->approach[best]))) best = k;
    return best;
}

/* Flight of the chain between different contacts that is shortest. */
static int shortest(const ric_chain *c, const double *u)
{
    const ric_model *m = c->model;
    int best = -1;
    for (int k = 0; k < c->n_flight; k++) {
        int f = c->face[k], g = c->face[k + 1];
        if (f < 0 || g < 0 || m->face[f].contact == m->face[g].contact) continue;
        if (best < 0 || u[c->n_start + k] < u[c->n_start + best]) best = k;
    }
    return best;
}

/* Re-solves `cycle` (with its symmetries) on the defining equation of `test`: canonical start, unknowns rounded, solved again.
 * Returns the new cycle or NULL. */
static ric_cycle *resolve(const ric_model *m, const ric_cycle *cycle, int test, double target)
{
    ric_cycle *canonical = NULL, *out = NULL;
    for (int pass = 0; pass < 2; pass++) {
        criterion q = {.test = test, .target = target};
        double *u = NULL;
        ric_cycle *source = pass ? canonical : ric_cycle_copy(cycle);
        bool good = source && !ric_cycle_to_chain(m, source, &q.chain, &u) && !ric_floquet_create(m->n, &q.floquet);
        if (good) {
            ric_chain_evaluate(q.chain, u);
            if (test == RIC_TEST_APPROACH) q.place = slowest(q.chain);
            if (test == RIC_TEST_FLIGHT) q.place = shortest(q.chain, u);
            if (pass)
                for (int i = 0; i < q.chain->n_unknown; i++) u[i] = rint(u[i] / GRAIN) * GRAIN;
            good = solve_criterion(&q, u);
            out = good ? ric_cycle_from_chain(q.chain, u) : NULL;
        }
        ric_cycle_free(source);
        ric_chain_free(q.chain);
        ric_floquet_release(&q.floquet);
        free(q.along);
        free(u);
        canonical = NULL;
        if (!out) return NULL;
        if (pass == 0) {
            canonical = ric_cycle_canonical(m, out);
            ric_cycle_free(out);
            out = NULL;
            if (!canonical) return NULL;
        }
    }
    /* a chain may start at another impact than the canonical one; and what was found must be what was looked for */
    int shift;
    bool reverse, mirror, near = ric_cycle_match(m, cycle, out, FAR, &shift, &reverse, &mirror);
    canonical = near ? ric_cycle_canonical(m, out) : NULL;
    ric_cycle_free(out);
    return canonical;
}

/* ----------------------------------------------------------------- grazings */

static double impact_speed(const ric_model *m, const ric_cycle *c, const double *W, int i)
{
    const ric_face *f = &m->face[c->face[i]];
    return -f->side * ric_dot(c->n, f->c, W + 2 * c->n * i + c->n);
}

/* All gaps that touch in flight become impacts of no speed; kept [allocated, may be NULL] marks those that were impacts before. */
static ric_cycle *with_touches(const ric_model *m, const ric_cycle *cycle, bool **kept)
{
    ric_cycle *plain = ric_cycle_copy(cycle), *out = NULL;
    ric_chain *chain = NULL;
    ric_touch touches[4 * RIC_MAX_TOUCHES];
    double *u = NULL;
    int n = cycle->n, count, k = 0;
    if (!plain) return NULL;
    plain->half = false;
    plain->pure = plain->flip = -1;
    if (ric_cycle_to_chain(m, plain, &chain, &u)) goto out;
    ric_chain_fly(chain, u);
    count = ric_reach_all(chain, u, 1 - TOUCH, 4 * RIC_MAX_TOUCHES, touches);
    if (count > 4 * RIC_MAX_TOUCHES || !(out = ric_cycle_create(n, cycle->N + count))) goto out;
    memcpy(out->w, cycle->w, 2 * (size_t)n * sizeof *out->w);
    if (kept && !(*kept = calloc((size_t)out->N, sizeof **kept))) goto out;
    for (int i = 0, j = 0; i < cycle->N; i++) {
        double left = cycle->tau[i], past = 0;
        if (kept) (*kept)[k] = true;
        out->face[k] = cycle->face[i];
        for (; j < count && touches[j].flight == i; j++) {
            out->tau[k++] = touches[j].time - past;
            left = cycle->tau[i] - touches[j].time;
            past = touches[j].time;
            out->face[k] = touches[j].face;
        }
        out->tau[k++] = left;
    }
out:
    ric_chain_free(chain);
    ric_cycle_free(plain);
    free(u);
    return out;
}

static bool list_touches(const ric_model *m, ric_node *node)
{
    const ric_cycle *c = node->cycle;
    double *W = calloc((size_t)c->N * 2 * c->n, sizeof *W);
    bool fits = true;
    if (!W) return false;
    ric_cycle_states(m, c, W);
    for (int i = 0; i < c->N; i++) {
        if (fabs(impact_speed(m, c, W, i)) > NO_SPEED) continue;
        if (node->n_touch < RIC_MAX_TOUCHES) node->touch[node->n_touch++] = i;
        else fits = false;
    }
    free(W);
    if (!fits) node->refusal = "more touches at once than are enumerated";
    return true;
}

/* Image of impact i under element e of the orbit's own group (0 identity, 1 half period, 2 reversal, 3 both). */
static int image(const ric_cycle *c, int element, int i)
{
    int N = c->N, r;
    switch (element) {
    case 1: return c->half ? (i + N / 2) % N : -1;
    case 2: r = c->pure; break;
    case 3: r = c->flip; break;
    default: return i;
    }
    return r < 0 ? -1 : ((r - i) % N + N) % N;
}

unsigned ric_node_class(const ric_node *node, unsigned choice)
{
    unsigned best = choice;
    /* at a corner a bit stands for an impact and the next one, which a reversal exchanges */
    int next = node->kind == RIC_KIND_CORNER;
    for (int e = 1; e < 4; e++) {
        unsigned mapped = 0;
        if (image(node->cycle, e, 0) < 0) continue;
        for (int i = 0; i < node->n_touch; i++) {
            if (!(choice & 1u << i)) continue;
            int place = image(node->cycle, e, node->touch[i] + (e > 1 ? next : 0));
            for (int j = 0; j < node->n_touch; j++)
                if (node->touch[j] == place) mapped |= 1u << j;
        }
        if (mapped < best) best = mapped;
    }
    return best;
}

static bool list_choices(ric_node *node)
{
    unsigned all = 1u << node->n_touch;
    int count = 0;
    for (unsigned choice = 0; choice < all; choice++) count += ric_node_class(node, choice) == choice;
    node->departures = calloc((size_t)count, sizeof *node->departures);
    if (!node->departures) return false;
    for (unsigned choice = 0; choice < all; choice++)
        if (ric_node_class(node, choice) == choice) node->departures[node->n_departure++].choice = choice;
    return true;
}

static ric_status finish_grazing(const ric_model *m, ric_cycle *full, ric_node **out)
{
    ric_node *node = node_create(m, RIC_KIND_GRAZING, full);
    if (!node) return no_memory();
    if (!list_touches(m, node) || !list_choices(node)) {
        ric_node_free(node);
        return no_memory();
    }
    *out = node;
    return RIC_OK;
}

ric_status ric_node_grazing(const ric_model *m, const ric_cycle *cycle, ric_node **out)
{
    ric_cycle *full = with_touches(m, cycle, NULL), *solved = NULL;
    *out = NULL;
    if (!full) return no_memory();
    int q = ric_cycle_find_symmetries(m, full, SAME);
    if (q > 1) { /* a duplicate of a grazing of fewer impacts */
        ric_cycle *shorter = ric_cycle_shorten(full, q);
        ric_cycle_free(full);
        if (!(full = shorter)) return no_memory();
        ric_cycle_find_symmetries(m, full, SAME);
    }
    solved = resolve(m, full, RIC_TEST_APPROACH, 0);
    ric_cycle_free(full);
    if (!solved) return ric_fail(RIC_E_NUMERIC, "a grazing orbit of %d impacts does not converge", cycle->N);
    ric_status status = finish_grazing(m, solved, out);
    if (!status && q > 1) {
        /* a duplicate of a grazing of fewer impacts: the ways out through some of its q touches are many and not tried here */
        (*out)->multiple = q;
        (*out)->n_departure = 1;
        (*out)->departures[0] = (ric_departure){.choice = 0, .state = RIC_DEPARTURE_OVER_BUDGET};
    }
    return status;
}

/* A linear mode with the amplitude at which it touches: all its contacts are touches, the cycle starts at the first. */
ric_status ric_node_linear(const ric_model *m, int mode, ric_node **out)
{
    int n = m->n, first = -1, count = 0;
    double omega = m->omega[mode], amplitude = HUGE_VAL;
    *out = NULL;
    if (omega == 0) return RIC_OK;
    for (int f = 0; f < m->n_face; f++) {
        double g = m->face[f].g[mode];
        if (g != 0 && fabs(m->face[f].gap / g) < amplitude * (1 - 1e-9)) {
            amplitude = fabs(m->face[f].gap / g);
            first = f;
        }
    }
    double sign = m->face[first].gap / m->face[first].g[mode] > 0 ? 1 : -1;
    ric_cycle *c = ric_cycle_create(n, m->n_face);
    if (!c) return no_memory();
    c->w[mode] = sign * amplitude;
    double last = 0;
    for (int phase = 0; phase < 2; phase++)
        for (int f = 0; f < m->n_face; f++) {
            double g = m->face[f].g[mode], value = (phase ? -1 : 1) * c->w[mode] * g;
            if (g == 0 || fabs(value / m->face[f].gap - 1) > 1e-9) continue;
            double t = phase * 3.14159265358979323846 / omega;
            if (count) c->tau[count - 1] = t - last;
            last = t;
            c->face[count++] = f;
        }
    c->N = count;
    c->tau[count - 1] = 2 * 3.14159265358979323846 / omega - last;
    ric_cycle_find_symmetries(m, c, SAME);
    ric_cycle *canonical = ric_cycle_canonical(m, c);
    ric_cycle_free(c);
    if (!canonical) return no_memory();
    ric_status status = finish_grazing(m, canonical, out);
    if (!status) (*out)->mode = mode;
    return status;
}

bool ric_node_coincident(const ric_model *m, const ric_cycle *cycle)
{
    ric_cycle *full = with_touches(m, cycle, NULL);
    bool found = false;
    for (int i = 0; full && i < full->N; i++)
        found |= full->tau[i] < RIC_COINCIDENT && m->face[full->face[i]].contact != m->face[full->face[(i + 1) % full->N]].contact;
    ric_cycle_free(full);
    return found;
}

/* With orthogonal normals the reflections commute: each pair of impacts at one instant may go on in either order, and every choice of
 * orders is a way out. */
static ric_status finish_corner(const ric_model *m, const ric_cycle *cycle, int n_pair, const int *pairs, ric_node **out)
{
    ric_cycle *least = ric_corner_least(m, cycle, n_pair, pairs, SAME), *solved;
    if (!least) return no_memory();
    solved = resolve(m, least, RIC_TEST_FLIGHT, 0);
    ric_cycle_free(least);
    if (!solved) return ric_fail(RIC_E_NUMERIC, "a corner orbit of %d impacts does not converge", cycle->N);
    ric_node *node = node_create(m, RIC_KIND_CORNER, solved);
    if (!node) return no_memory();
    node->n_touch = ric_corner_pairs(m, solved, NO_SPEED, RIC_MAX_TOUCHES, node->touch);
    if (node->n_touch != n_pair || !list_choices(node)) {
        bool moved = node->n_touch != n_pair;
        ric_node_free(node);
        return moved ? ric_fail(RIC_E_NUMERIC, "a corner orbit of %d impacts does not converge", cycle->N) : no_memory();
    }
    *out = node;
    return RIC_OK;
}

ric_status ric_node_corner(const ric_model *m, const ric_cycle *cycle, ric_node **out)
{
    int pairs[RIC_MAX_TOUCHES], n_pair = RIC_CORNER_UNDEFINED;
    ric_cycle *full = with_touches(m, cycle, NULL);
    *out = NULL;
    if (!full) return no_memory();
    n_pair = ric_corner_pairs(m, full, NO_SPEED, RIC_MAX_TOUCHES, pairs);
    if (n_pair > 0 && (full->N > cycle->N || ric_corner_fixed(m, full, n_pair, pairs, FIXED))) n_pair = RIC_CORNER_TOGETHER;
    ric_cycle_free(full);
    if (n_pair > 0) return finish_corner(m, cycle, n_pair, pairs, out);
    ric_node *node = node_create(m, RIC_KIND_CORNER, ric_cycle_canonical(m, cycle));
    if (!node) return no_memory();
    node->refusal = n_pair == RIC_CORNER_TOGETHER
                        ? "two contacts with orthogonal normals close at one instant, and on the branches that go on they do so for good; such "
                          "branches are not followed by this version"
                        : "two contacts close at one instant and their normals are not orthogonal in the metric of M^-1: the impact law does "
                          "not say what happens; the branch ends here";
    *out = node;
    return RIC_OK;
}

/* ------------------------------------------------------------- branch points */

static bool add_two(ric_node *node)
{
    node->departures = calloc(2, sizeof *node->departures);
    if (!node->departures) return false;
    node->departures[0].choice = RIC_THROUGH;
    node->departures[1].choice = RIC_SIDE;
    node->n_departure = 2;
    return true;
}

ric_status ric_node_interior(const ric_model *m, const ric_cycle *cycle, int test, ric_node **out)
{
    ric_kind kind = test == RIC_TEST_SLOPE ? RIC_KIND_EXTREMUM : test == RIC_TEST_PERIOD ? RIC_KIND_PERIOD_EXTREMUM : RIC_KIND_BRANCH_POINT;
    *out = NULL;
    ric_cycle *solved = resolve(m, cycle, test, 0);
    if (!solved) return ric_fail(RIC_E_NUMERIC, "a junction on a branch of %d impacts does not converge", cycle->N);
    ric_node *node = node_create(m, kind, solved);
    if (!node) return no_memory();
    node->test = test;
    if (kind == RIC_KIND_BRANCH_POINT && !add_two(node)) {
        ric_node_free(node);
        return no_memory();
    }
    *out = node;
    return RIC_OK;
}

ric_status ric_node_start(const ric_model *m, const ric_cycle *cycle, ric_node **out)
{
    ric_node *node = node_create(m, RIC_KIND_START, ric_cycle_canonical(m, cycle));
    *out = NULL;
    if (!node || !add_two(node)) {
        ric_node_free(node);
        return no_memory();
    }
    node->n_departure = 1; /* only the branch that passes */
    *out = node;
    return RIC_OK;
}

/* p of a q-tupling from the rotation number of the original orbit; 0 if it is not on the unit circle. */
static int rotation_of(const ric_model *m, const ric_cycle *cycle, int q)
{
    ric_chain *chain = NULL;
    ric_floquet floquet = {0};
    double *u = NULL;
    int p = 0;
    if (!ric_cycle_to_chain(m, cycle, &chain, &u) && !ric_floquet_create(m->n, &floquet)) {
        ric_chain_evaluate(chain, u);
        if (!ric_floquet_compute(chain, &floquet)) {
            if (isfinite(floquet.rotation)) p = (int)lrint(q * floquet.rotation);
            double best = 1e-3;
            for (int i = 0; p == 0 && m->n > 2 && i < floquet.n_pair; i++)
                for (int k = 1; k < q; k++) {
                    double off = fabs(floquet.rho[2 * i] - 2 * cos(6.283185307179586477 * k / q)) + fabs(floquet.rho[2 * i + 1]);
                    if (off < best) {
                        best = off;
                        p = k;
                    }
                }
        }
    }
    ric_chain_free(chain);
    ric_floquet_release(&floquet);
    free(u);
    return p;
}

/* Which test vanishes on the symmetric orbit `whole` where a branch with the symmetries of `part` arrives: what is lost tells. */
static int broken_test(const ric_cycle *whole, const ric_cycle *part)
{
    if (!(whole->half && whole->pure >= 0)) return whole->pure >= 0 || whole->flip >= 0 ? RIC_TEST_B : RIC_TEST_A;
    return part->half ? RIC_TEST_B : part->flip >= 0 ? RIC_TEST_A : RIC_TEST_D;
}

ric_status ric_node_arrival(const ric_model *m, const ric_cycle *cycle, ric_node **out)
{
    ric_cycle *sym = ric_cycle_copy(cycle);
    *out = NULL;
    if (!sym) return no_memory();
    int q = ric_cycle_find_symmetries(m, sym, 1e-5);
    if (q > 1) {
        ric_cycle *shorter = ric_cycle_shorten(sym, q);
        ric_cycle_free(sym);
        if (!(sym = shorter)) return no_memory();
        ric_cycle_find_symmetries(m, sym, 1e-5);
        ric_cycle *solved = NULL;
        int p = rotation_of(m, sym, q);
        if (p > 0) solved = resolve(m, sym, TEST_ROTATION, 2 * cos(6.283185307179586477 * p / q));
        ric_cycle_free(sym);
        if (!(sym = solved)) return ric_fail(RIC_E_NUMERIC, "the original orbit of a multiplication does not converge");
        ric_node *node = node_create(m, RIC_KIND_MULTIPLICATION, sym);
        if (!node || !add_two(node)) {
            ric_node_free(node);
            return no_memory();
        }
        node->multiple = q;
        node->rotation[0] = p;
        node->rotation[1] = q;
        *out = node;
        return RIC_OK;
    }
    int test = broken_test(sym, cycle);
    ric_status status = ric_node_interior(m, sym, test, out);
    ric_cycle_free(sym);
    return status;
}

/* ------------------------------------------------------------------ identity */

bool ric_node_chooses(const ric_node *node)
{
    return node->kind == RIC_KIND_GRAZING || node->kind == RIC_KIND_CORNER;
}

bool ric_node_same(const ric_model *m, const ric_node *a, const ric_node *b)
{
    int shift;
    bool reverse, mirror;
    if (a->kind != b->kind || a->multiple != b->multiple || a->cycle->N != b->cycle->N) return false;
    if (fabs(a->energy - b->energy) > 1e-6 * (1e-3 + fabs(a->energy)) || fabs(a->period - b->period) > 1e-6 * a->period) return false;
    return ric_cycle_match(m, a->cycle, b->cycle, 10 * SAME, &shift, &reverse, &mirror);
}

/* The order of pairs at a corner that is the word of `cycle`. */
static int corner_choice(const ric_model *m, const ric_node *node, const ric_cycle *cycle)
{
    int result = -1, shift;
    bool reverse, mirror;
    for (int i = 0; i < node->n_departure && result < 0; i++) {
        unsigned choice = node->departures[i].choice;
        ric_cycle *swapped = ric_corner_swap(m, node->cycle, node->n_touch, node->touch, choice, SAME);
        if (swapped && ric_cycle_match(m, swapped, cycle, 1e-4, &shift, &reverse, &mirror)) result = (int)choice;
        ric_cycle_free(swapped);
    }
    return result;
}

int ric_node_choice(const ric_model *m, const ric_node *node, const ric_cycle *cycle)
{
    if (node->kind == RIC_KIND_CORNER) return corner_choice(m, node, cycle);
    int result = -1, shift;
    bool reverse, mirror;
    bool *kept = NULL;
    ric_cycle *full = with_touches(m, cycle, &kept);
    int N = full ? full->N : 0;
    if (!full || !kept) goto out;
    if (N == node->cycle->N && ric_cycle_match(m, node->cycle, full, 1e-4, &shift, &reverse, &mirror)) {
        unsigned choice = 0;
        for (int t = 0; t < node->n_touch; t++) {
            int i = node->touch[t], j = reverse ? ((shift - i) % N + N) % N : (shift + i) % N;
            if (kept[j]) choice |= 1u << t;
        }
        result = (int)ric_node_class(node, choice);
    }
out:
    free(kept);
    ric_cycle_free(full);
    return result;
}

/* ---------------------------------------------------------------- departures */

static ric_cycle *chosen(const ric_model *m, const ric_node *node, unsigned choice)
{
    int N = node->cycle->N;
    bool keep[N];
    int kept = 0;
    if (node->kind == RIC_KIND_CORNER) return ric_corner_swap(m, node->cycle, node->n_touch, node->touch, choice, SAME);
    for (int i = 0; i < N; i++) keep[i] = true;
    for (int i = 0; i < node->n_touch; i++) keep[node->touch[i]] = choice & 1u << i;
    for (int i = 0; i < N; i++) kept += keep[i];
    return kept ? ric_cycle_keep(m, node->cycle, keep) : NULL;
}

ric_cycle *ric_node_regular(const ric_model *m, const ric_node *node)
{
    return node->kind == RIC_KIND_GRAZING ? chosen(m, node, 0) : ric_cycle_copy(node->cycle);
}

int ric_node_impacts(const ric_node *node, unsigned choice)
{
    int count = node->cycle->N;
    if (node->kind != RIC_KIND_GRAZING) return count;
    for (int i = 0; i < node->n_touch; i++) count -= !(choice & 1u << i);
    return count;
}

bool ric_node_half(const ric_model *m, const ric_node *node, unsigned choice)
{
    bool subsets = ric_node_chooses(node);
    ric_cycle *c = subsets ? chosen(m, node, choice) : ric_cycle_copy(node->cycle);
    bool half = c && c->half && !(!subsets && choice == RIC_SIDE && node->test != RIC_TEST_B);
    ric_cycle_free(c);
    return half;
}

/* Two contacts of a kept word that close at one instant. */
static const char *together(const ric_model *m, const ric_cycle *c)
{
    for (int i = 0; i < c->N; i++) {
        int f = m->face[c->face[i]].contact, g = m->face[c->face[(i + 1) % c->N]].contact;
        if (f == g || c->tau[i] > RIC_COINCIDENT) continue;
        return ric_model_orthogonal(m, f, g) ? "two contacts close together for a whole branch; such branches are not followed by this version"
                                             : "two contacts close together and their normals are not orthogonal in the metric of M^-1: "
                                               "the impact law does not say what happens";
    }
    return NULL;
}

/* Admissible at distance h along t from u0? Strictly: every margin has its sign. */
static int admissible(ric_chain *c, const double *u0, const double *t, double h)
{
    int size = c->n_unknown, iterations;
    double u[size], du[size];
    for (int i = 0; i < size; i++) u[i] = u0[i] + h * t[i];
    if (!ric_trace_correct(c, u, u0, t, h, du, &iterations)) return -1;
    for (int k = c->start == RIC_MIRROR_IMPACT ? 0 : 1; k <= c->n_flight; k++)
        if (c->face[k] >= 0 && !(c->approach[k] > 0)) return 0;
    for (int k = 0; k < c->n_flight; k++)
        if (!(u[c->n_start + k] > 0)) return 0;
    return ric_reach(c, u, NULL) < 1;
}

/* The side of the kernel vector on which the branch exists: *found +-1, 0 for neither; t0 [n_unknown] points there. */
static ric_status find_side(ric_chain *c, double *u0, double *t0, int *found)
{
    double t[c->n_unknown];
    int iterations;
    *found = 0;
    if (!ric_trace_correct(c, u0, NULL, NULL, 0, t, &iterations))
        return ric_fail(RIC_E_NUMERIC, "the orbit at the grazing does not converge (residual %g)", c->residual);
    if (c->smallest < 1e-9) return ric_fail(RIC_E_NUMERIC, "the kernel at the grazing has more than one dimension: modes of commensurate frequencies move "
                                      "together there and no single branch leaves");
    ric_trace_tangent(c, NULL, t);
    for (int side = 1; side >= -1; side -= 2) {
        double h = side * TRIAL * c->scale;
        int first = 0, second = 1;
        for (int i = 0; i < 6 && first != second; i++, h /= 10) {
            first = admissible(c, u0, t, h);
            second = admissible(c, u0, t, h / 10);
        }
        if (first != second || first < 0) return ric_fail(RIC_E_NUMERIC, "whether the departure is admissible is lost in rounding");
        if (first != 1) continue;
        if (*found) return ric_fail(RIC_E_NUMERIC, "the departure is admissible both ways: the touch does not end it");
        *found = side;
        for (int i = 0; i < c->n_unknown; i++) t0[i] = side * t[i];
    }
    return RIC_OK;
}

static void drop(ric_chain **chain, double **u0, double **t0)
{
    ric_chain_free(*chain);
    free(*u0);
    free(*t0);
    *chain = NULL;
    *u0 = *t0 = NULL;
}

/* From a grazing or a corner. */
static ric_status depart_subset(const ric_model *m, const ric_node *node, unsigned choice, ric_chain **chain, double **u0, double **t0)
{
    ric_cycle *cycle = chosen(m, node, choice);
    int found = 0;
    if (!cycle) return no_memory();
    const char *refused = node->kind == RIC_KIND_GRAZING ? together(m, cycle) : NULL;
    ric_status status = refused ? ric_fail(RIC_E_NUMERIC, "%s", refused) : ric_cycle_to_chain(m, cycle, chain, u0);
    ric_cycle_free(cycle);
    if (status) return status;
    *t0 = calloc((size_t)(*chain)->n_unknown, sizeof **t0);
    status = *t0 ? find_side(*chain, *u0, *t0, &found) : no_memory();
    if (status || !found) drop(chain, u0, t0);
    return status;
}

/* Kernel [2 rows of `size`] of the dense Jacobian; false if it has not two dimensions. */
static bool plane(ric_chain *c, const double *u, double *kernel)
{
    int size = c->n_unknown, rows = c->n_flight + 2 * c->n + 2, k = rows < size ? rows : size;
    double *J = calloc((size_t)rows * size, sizeof *J), *s = calloc((size_t)k, sizeof *s), *super = calloc((size_t)k, sizeof *super);
    double *V = calloc((size_t)size * size, sizeof *V);
    bool found = false;
    if (J && s && super && V) {
        int equations = ric_chain_jacobian(c, u, J);
        if (!LAPACKE_dgesvd(LAPACK_ROW_MAJOR, 'N', 'A', equations, size, J, size, s, NULL, 1, V, size, super)) {
            int rank = 0, least = equations < size ? equations : size;
            for (int i = 0; i < least; i++) rank += s[i] > 1e-6 * s[0];
            found = size - rank == 2;
            memcpy(kernel, V + (size_t)(size - 2) * size, 2 * (size_t)size * sizeof *V);
        }
    }
    free(J);
    free(s);
    free(super);
    free(V);
    return found;
}

/* A neighbour of the node on its symmetric branch, at distance h, as unknowns of the problem that `like` (less symmetric) poses. */
static ric_status neighbour(const ric_model *m, const ric_node *node, ric_chain *form, const double *v, const double *t, double h,
                            const ric_cycle *like, double **u)
{
    double point[form->n_unknown];
    int shift;
    bool reverse, mirror;
    ric_chain *chain = NULL;
    ric_cycle *home = NULL;
    ric_status status;
    for (int i = 0; i < form->n_unknown; i++) point[i] = v[i] + h * t[i];
    ric_chain_fly(form, point);
    ric_cycle *near = ric_cycle_from_chain(form, point);
    /* the cycle of a chain may start elsewhere than the canonical one */
    if (near && ric_cycle_match(m, node->cycle, near, 1e-2, &shift, &reverse, &mirror))
        home = ric_cycle_transform(m, near, shift, reverse, mirror);
    ric_cycle_free(near);
    if (!home) return ric_fail(RIC_E_NUMERIC, "the symmetric branch could not be followed at its branch point");
    home->half = like->half;
    home->pure = like->pure;
    home->flip = like->flip;
    status = ric_cycle_to_chain(m, home, &chain, u);
    ric_chain_free(chain);
    ric_cycle_free(home);
    return status;
}

/* In the kernel of the larger problem, perpendicular to the symmetric branch, largest component positive. */
static ric_status side_direction(ric_chain *c, const double *u0, const double *before, const double *after, double *t0)
{
    int size = c->n_unknown, largest = 0;
    double kernel[2 * size], p = 0, q = 0;
    ric_chain_fly(c, u0);
    if (!plane(c, u0, kernel)) return ric_fail(RIC_E_NUMERIC, "the kernel at the branch point has not two dimensions");
    for (int i = 0; i < size; i++) {
        p += kernel[i] * (after[i] - before[i]);
        q += kernel[size + i] * (after[i] - before[i]);
    }
    for (int i = 0; i < size; i++) t0[i] = (q * kernel[i] - p * kernel[size + i]) / hypot(p, q);
    for (int i = 1; i < size; i++)
        if (fabs(t0[i]) > fabs(t0[largest]) * (1 + 1e-6)) largest = i;
    if (t0[largest] < 0)
        for (int i = 0; i < size; i++) t0[i] = -t0[i];
    return RIC_OK;
}

/* The kernel vector is perpendicular to the symmetric branch, the branch that leaves need not be: its direction is that of a point on it.
 * The symmetric branch has no point in the plane that is solved in. */
static bool secant_direction(ric_chain *c, const double *u0, double *t0)
{
    int size = c->n_unknown, iterations;
    double u[size], du[size], h = SECANT * c->scale;
    for (int pass = 0; pass < 2; pass++) {
        double norm = 0;
        for (int i = 0; i < size; i++) u[i] = u0[i] + h * t0[i];
        if (!ric_trace_correct(c, u, u0, t0, h, du, &iterations)) return false;
        for (int i = 0; i < size; i++) norm += (u[i] - u0[i]) * (u[i] - u0[i]);
        for (int i = 0; i < size; i++) t0[i] = (u[i] - u0[i]) / sqrt(norm);
    }
    return true;
}

static ric_status depart_side(const ric_model *m, const ric_node *node, ric_chain **chain, double **u0, double **t0)
{
    ric_chain *form = NULL;
    double *v = NULL, *before = NULL, *after = NULL, *t = NULL;
    ric_cycle *cycle = ric_cycle_copy(node->cycle);
    ric_status status = cycle ? ric_cycle_to_chain(m, node->cycle, &form, &v) : no_memory();
    if (status) goto out;
    drop_symmetry(cycle, node->test, form);
    if ((status = ric_cycle_to_chain(m, cycle, chain, u0))) goto out;
    *t0 = calloc((size_t)(*chain)->n_unknown, sizeof **t0);
    t = calloc((size_t)form->n_unknown, sizeof *t);
    if (!*t0 || !t) {
        status = no_memory();
        goto out;
    }
    ric_chain_evaluate(form, v);
    ric_trace_tangent(form, NULL, t);
    if ((status = neighbour(m, node, form, v, t, -1e-5 * form->scale, cycle, &before))) goto out;
    if ((status = neighbour(m, node, form, v, t, 1e-5 * form->scale, cycle, &after))) goto out;
    if ((status = side_direction(*chain, *u0, before, after, *t0))) goto out;
    if (!secant_direction(*chain, *u0, *t0)) status = ric_fail(RIC_E_NUMERIC, "no orbit was found beside the branch point");
out:
    if (status) drop(chain, u0, t0);
    ric_chain_free(form);
    ric_cycle_free(cycle);
    free(v);
    free(before);
    free(after);
    free(t);
    return status;
}

static ric_status depart_through(const ric_model *m, const ric_node *node, ric_chain **chain, double **u0, double **t0)
{
    ric_status status = ric_cycle_to_chain(m, node->cycle, chain, u0);
    if (status) return status;
    if (!(*t0 = calloc((size_t)(*chain)->n_unknown, sizeof **t0))) return no_memory();
    ric_chain_evaluate(*chain, *u0);
    ric_trace_tangent(*chain, NULL, *t0);
    return RIC_OK;
}

ric_status ric_node_depart(const ric_model *m, const ric_node *node, unsigned choice, ric_chain **chain, double **u0, double **t0,
                           unsigned *ignore)
{
    const unsigned breaks = 1u << RIC_TEST_A | 1u << RIC_TEST_B | 1u << RIC_TEST_D;
    *chain = NULL;
    *u0 = *t0 = NULL;
    if (node->kind == RIC_KIND_GRAZING) {
        *ignore = breaks | 1u << RIC_TEST_REACH | 1u << RIC_TEST_APPROACH;
        return depart_subset(m, node, choice, chain, u0, t0);
    }
    if (node->kind == RIC_KIND_CORNER) {
        *ignore = 1u << RIC_TEST_FLIGHT;
        return depart_subset(m, node, choice, chain, u0, t0);
    }
    *ignore = breaks | 1u << RIC_TEST_DET;
    if (choice == RIC_THROUGH) return depart_through(m, node, chain, u0, t0);
    if (node->kind == RIC_KIND_MULTIPLICATION)
        return ric_fail(RIC_E_NUMERIC, "branches that leave at a multiplication are not followed by this version");
    if (node->test == RIC_TEST_DET)
        return ric_fail(RIC_E_NUMERIC, "branches cross here without a symmetry that tells them apart; the other one is not followed");
    *ignore |= 1u << RIC_TEST_SLOPE | 1u << RIC_TEST_PERIOD;
    return depart_side(m, node, chain, u0, t0);
}
