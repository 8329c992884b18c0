/* Points per second, nanoseconds per impact, cost against the number of impacts, time of the demo, bytes per point.
 *
 *     ricochet-bench [-o FILE] [-t SECONDS] [STUDY]
 *
 * Branches are followed by ric_trace_advance, as `ricochet run` does, with every test watched; only the step is held: before each
 * call the next step is set to ARC and the largest step (relative to 1 + |w|) to ARC / (1 + |w|). A row follows its branch again and
 * again until SECONDS are used up; the fastest of BLOCKS equal parts counts, in processor time of this thread, so that other load on
 * the machine disturbs least. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "cycle.h"
#include "graph.h"
#include "motion.h"
#include "trace.h"

#define TWO_PI 6.283185307179586477
#define ARC 0.01       /* step in the norm of the unknowns */
#define RESIDUAL 1e-13 /* no point above it */
#define BLOCKS 4
#define FAR 0.02       /* two flights of a repeated orbit that differ more: the trace has changed branch */

typedef enum { OWN, REVERSIBLE, GENERAL } form;
static const char *const form_text[] = {"own", "reversible", "general"};

/* A piece of a branch: S2-[01] k times over, original frequency `from` to `to` rad/s, or (edge set) the stored points of a trace. */
typedef struct {
    const char *name;
    const ric_model *model;
    const ric_trace *edge;
    int k;
    form form;
    bool watched; /* false: zeros of the tests that break or cross something are left alone (repeated orbits meet one at each q-tupling) */
    double from, to;
} course;

typedef struct {
    int N, n_flight;
    double rate; /* points per processor second */
    long points, events, stops, hops, short_steps;
    double residual, evaluations;
} figures;

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void need(bool good, const char *what)
{
    if (good) return;
    fprintf(stderr, "ricochet-bench: %s\n", what);
    exit(1);
}

/* The article's two masses: m1 = 2, m2 = 1, k1 = 8, k2 = 1, |x2 - x1| <= 1. */
static ric_model *article(void)
{
    static const double mass[] = {2, 0, 0, 1}, stiffness[] = {9, -1, -1, 1}, normal[] = {-1, 1};
    ric_contact contact = {.name = "stop", .normal = normal, .clearance = 1, .sides = RIC_SIDES_BOTH, .law = RIC_LAW_RIGID};
    ric_model *model;
    need(!ric_model_create(2, mass, stiffness, 1, &contact, 1, &model), "the article's model is refused");
    return model;
}

/* ------------------------------------------------------------------- orbits */

/* S2-[01] in closed form (docs/theory.md section 11), k times over: all speed lies along the normal at every impact. */
static ric_cycle *s2_cycle(const ric_model *m, double omega, int k)
{
    const ric_face *face = &m->face[0];
    double half = 0.5 * TWO_PI / (omega / m->omega_ref), sum = 0;
    ric_cycle *c = ric_cycle_create(m->n, 2 * k);
    need(c, "no memory");
    for (int i = 0; i < m->n; i++) sum += face->c[i] * face->c[i] * tan(m->omega[i] * half / 2) / m->omega[i];
    for (int i = 0; i < m->n; i++) {
        c->w[i] = face->gap / sum * face->c[i] * tan(m->omega[i] * half / 2);
        c->w[m->n + i] = -face->gap / sum * face->c[i];
    }
    for (int i = 0; i < 2 * k; i++) {
        c->face[i] = i % 2 ? face->mirror : 0;
        c->tau[i] = half;
    }
    c->half = k % 2 == 1;
    c->pure = 0; /* impact 0 is a mirror point, and so is impact k */
    return c;
}

/* The chain of a course at x (frequency, or index of a stored point), in the form asked for. */
static double *chain_at(const course *q, double x, ric_chain **chain)
{
    double *u;
    ric_cycle *c;
    if (q->edge) {
        const ric_trace *e = q->edge;
        const double *at = e->points + (size_t)x * e->stride + sizeof(ric_point) / sizeof(double);
        ric_chain_fly(e->chain, at);
        c = ric_cycle_from_chain(e->chain, at);
        need(c, "no memory");
    } else c = s2_cycle(q->model, x, q->k);
    if (q->form != OWN) c->half = false;
    if (q->form == GENERAL) c->pure = c->flip = -1;
    need(!ric_cycle_to_chain(q->model, c, chain, &u), "no chain");
    ric_cycle_free(c);
    return u;
}

static ric_trace *start(const course *q, double x, ric_limits *limits)
{
    ric_chain *chain, *other;
    ric_trace *tr;
    double dx = q->edge ? 1 : 1e-7 * x, *u = chain_at(q, x, &chain), *t = chain_at(q, x + dx, &other);
    for (int i = 0; i < chain->n_unknown; i++) t[i] -= u[i];
    /* the study's frequencies 0.2 to 10 rad/s for the original orbit, its energies up to 200 */
    double period = TWO_PI * q->model->omega_ref * q->k;
    *limits = (ric_limits){.energy = {0, 200 / q->model->energy_unit}, .period = {period / 10, period / 0.2}, .max_points = 1 << 28};
    limits->max_step = ARC;
    need(!ric_trace_create(chain, u, t, 0, limits, &tr), "the start of a branch does not converge");
    ric_chain_free(other);
    free(u);
    free(t);
    return tr;
}

static bool hopped(const course *q, const ric_trace *tr)
{
    const ric_chain *c = tr->chain;
    const double *tau = tr->now.u + c->n_start;
    if (q->edge) return false;
    for (int i = 1; i < c->n_flight; i++)
        if (fabs(tau[i] - tau[0]) > FAR * tau[0]) return true;
    return false;
}

/* ------------------------------------------------------------------ measuring */

static const unsigned crossings = 1u << RIC_TEST_DET | 1u << RIC_TEST_A | 1u << RIC_TEST_B | 1u << RIC_TEST_D;

static bool outside(const course *q, const ric_trace *tr)
{
    double omega = tr->now.row.frequency * q->k;
    return !q->edge && (omega < q->from || omega > q->to);
}

/* One way along the course, for at most `seconds`. Returns the time used; the frequency reached goes to *x. */
static double follow(const course *q, double seconds, double *x, figures *out)
{
    ric_limits limits;
    ric_trace *tr = start(q, *x, &limits);
    bool done = false;
    long points = 0;
    double begin = now(), used = 0, s = tr->now.s;
    while (!done && !outside(q, tr) && used < seconds) {
        limits.max_step = ARC / tr->chain->scale;
        tr->step = ARC;
        if (!q->watched) tr->ignore = crossings;
        need(!ric_trace_advance(tr, &done), "a step failed");
        out->residual = fmax(out->residual, tr->now.row.residual);
        out->short_steps += tr->now.s - s < 0.99 * ARC;
        s = tr->now.s;
        points++;
        if (points % 32 == 0) used = now() - begin;
    }
    used = now() - begin;
    out->N = tr->chain->n_flight * tr->chain->multiple;
    out->n_flight = tr->chain->n_flight;
    out->points += points;
    out->events += tr->n_event;
    out->evaluations += (double)tr->evaluations;
    out->stops += done && !q->edge;
    out->hops += hopped(q, tr);
    if (done && getenv("BENCH_STOPS")) fprintf(stderr, "%s N=%d stop %d (%s) test %d arrival %d at %g\n", q->name, 2 * q->k, tr->stop, tr->why, tr->end.test, tr->arrival, tr->now.row.frequency * q->k);
    *x = tr->now.row.frequency * q->k;
    /* past the point where a repeated orbit meets a branch; to the start again at the end of the course */
    if (done && !q->edge) *x += 1e-4 * (q->to - q->from);
    if (q->edge || outside(q, tr) || *x >= q->to || *x < q->from) *x = q->from;
    ric_trace_free(tr);
    return used;
}

static figures measure(const course *q, double seconds)
{
    figures all = {0};
    double x = q->from;
    for (int b = 0; b < BLOCKS; b++) {
        double used = 0;
        long before = all.points;
        while (used < seconds / BLOCKS) used += follow(q, seconds / BLOCKS - used, &x, &all);
        all.rate = fmax(all.rate, (double)(all.points - before) / used);
    }
    return all;
}

int main(int argc, char **argv)
{
    ric_model *m = article();
    double seconds = argc > 1 ? atof(argv[1]) : 0.3;
    static const int copies[] = {1, 2, 4, 6, 8, 12, 24, 48, 96, 192, 384, 512};
    course rows[] = {{"S2-[01] 2.2..2.7", m, NULL, 1, OWN, true, 2.2, 2.7}, {"S2-[01] 2.2..2.7", m, NULL, 1, GENERAL, true, 2.2, 2.7},
                     {"S2-[01] 4..6", m, NULL, 1, OWN, true, 4, 6}, {"S2-[01] 4..6", m, NULL, 1, GENERAL, true, 4, 6}};
    (void)form_text;
    for (int i = 0; i < 4; i++) {
        figures f = measure(&rows[i], seconds);
        printf("%-20s %-10s %4d %10.0f pts/s  n=%ld ev=%ld stops=%ld hops=%ld short=%ld res=%.2g eval/pt=%.2f\n", rows[i].name, form_text[rows[i].form], f.N, f.rate, f.points, f.events, f.stops, f.hops, f.short_steps, f.residual, f.evaluations / (double)f.points);
    }
    for (int w = 1; w >= 0; w--) for (form g = REVERSIBLE; g <= GENERAL; g++)
        for (size_t i = 0; i < sizeof copies / sizeof *copies; i++) {
            course q = {"duplicate", m, NULL, copies[i], g, w, 2.2, 2.7};
            figures f = measure(&q, seconds);
            printf("%-20s %-10s %4d %10.0f pts/s  n=%ld ev=%ld stops=%ld hops=%ld short=%ld res=%.2g eval/pt=%.2f %s\n", q.name, form_text[q.form], f.N, f.rate, f.points, f.events, f.stops, f.hops, f.short_steps, f.residual, f.evaluations / (double)f.points, w ? "watched" : "ignored");
            fflush(stdout);
        }
    ric_model_free(m);
    return 0;
}
