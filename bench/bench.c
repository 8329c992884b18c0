/* Points per second, nanoseconds per impact, impacts per second on sections, cost against the
 * numbers of impacts and of modes, time of the demo, bytes per point.
 *
 *     ricochet-bench [-o FILE] [-t SECONDS] [STUDY]
 *
 * Branches are followed by ric_continuation_advance, as `ricochet run` does, with every test
 * watched; only the step is held: before each call the next step is set to ARC, and the largest
 * step, which is relative to 1 + |w|, to ARC / (1 + |w|). A step that the trace itself makes
 * shorter (an event, a refusal) stays short and is counted. A row follows its piece of branch again
 * and again until SECONDS are used up; the fastest of BLOCKS equal parts counts, in processor time,
 * so that other load on the machine disturbs least. Starting a trace is not timed. Shown on the
 * terminal and written to FILE (build/bench.txt). */
#include <malloc.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "orbit/periodic.h"
#include "explore/graph.h"
#include "model/modal.h"
#include "branch/continuation.h"

#define TWO_PI 6.283185307179586477
#define ARC 0.01       /* step in the norm of the unknowns */
#define RESIDUAL 1e-13 /* no point above it */
#define BLOCKS 8
#define ENERGY 200 /* window of the traces, as in the demo study */
#define LOWEST 0.2 /* rad/s, of the original orbit */
#define HIGHEST 10.0

typedef enum { OWN, REVERSIBLE, GENERAL } form; /* own: the form that the symmetries allow */
static const char *const form_text[] = {"own", "reversible", "general"};

/* A piece of a branch: S2-[01] k times over, original frequency `from` to `to` rad/s; or, with
 * `edge`, a trace from its second stored point to its end. */
typedef struct {
    const char *name;
    const ric_model *model;
    int k;
    form form;
    double from, to;
    const ric_continuation *edge;
} course;

typedef struct {
    int N, n_flight;
    double rate; /* points per second of processor time */
    long points, evaluations, short_steps;
    double residual;
    size_t bytes; /* of a stored point */
} figures;

static FILE *file;

/* To the terminal and to the file. */
__attribute__((format(printf, 1, 2))) static void say(const char *format, ...)
{
    va_list list;
    va_start(list, format);
    vprintf(format, list);
    va_end(list);
    fflush(stdout);
    if (!file) return;
    va_start(list, format);
    vfprintf(file, format, list);
    va_end(list);
}

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

/* A structure with a stop on both sides of normal . x. */
static ric_model *between_stops(int n, const double *mass, const double *stiffness,
                                const double *normal)
{
    ric_contact contact = {.name = "stop",
                           .normal = normal,
                           .clearance = 1,
                           .sides = RIC_SIDES_BOTH,
                           .law = RIC_LAW_RIGID};
    ric_model *model;
    need(!ric_model_create(n, mass, stiffness, 1, &contact, 1, &model), ric_detail());
    return model;
}

/* The article's two masses: m1 = 2, m2 = 1, k1 = 8, k2 = 1, |x2 - x1| <= 1. */
static ric_model *article(void)
{
    static const double mass[] = {2, 0, 0, 1}, stiffness[] = {9, -1, -1, 1}, normal[] = {-1, 1};
    return between_stops(2, mass, stiffness, normal);
}

/* ------------------------------------------------------------------- orbits */

/* S2-[01] in closed form (docs/theory.md section 11), k times over: at every impact all speed lies
 * along the normal. */
static ric_periodic *s2_cycle(const ric_model *m, double omega, int k)
{
    int n = m->n;
    const ric_face *face = &m->face[0];
    double tau = 0.5 * TWO_PI / omega * m->omega_ref, sum = 0;
    ric_periodic *c = ric_periodic_create(n, 2 * k);
    need(c, "no memory");
    for (int i = 0; i < n; i++)
        sum += face->c[i] * face->c[i] * tan(m->omega[i] * tau / 2) / m->omega[i];
    for (int i = 0; i < n; i++) {
        c->w[i] = face->gap / sum * face->c[i] * tan(m->omega[i] * tau / 2);
        c->w[n + i] = -face->gap / sum * face->c[i];
    }
    for (int i = 0; i < 2 * k; i++) {
        c->face[i] = i % 2 ? face->mirror : 0;
        c->tau[i] = tau;
    }
    c->half = k % 2 == 1;
    c->pure = 0; /* impacts 0 and k are mirror points */
    return c;
}

/* The chain of a course at x (frequency, or index of a stored point) in the form asked for, and its
 * unknowns. */
static double *chain_at(const course *q, double x, ric_shooting **chain)
{
    const ric_continuation *e = q->edge;
    double *u;
    ric_periodic *c;
    if (e) {
        const double *at = e->points + (size_t)x * e->stride + sizeof(ric_point) / sizeof(double);
        ric_shooting_fly(e->chain, at);
        c = ric_periodic_from_chain(e->chain, at);
        need(c, "no memory");
    } else c = s2_cycle(q->model, x, q->k);
    if (q->form != OWN) c->half = false;
    if (q->form == GENERAL) c->pure = c->flip = -1;
    need(!ric_periodic_to_chain(q->model, c, chain, &u), "no memory");
    ric_periodic_free(c);
    return u;
}

static ric_continuation *start(const course *q, double x, ric_limits *limits)
{
    ric_shooting *chain, *other;
    ric_continuation *tr;
    double dx = q->edge ? 1 : 1e-7 * x, *u = chain_at(q, x, &chain),
           *t = chain_at(q, x + dx, &other);
    double period = TWO_PI * q->model->omega_ref * q->k;
    for (int i = 0; i < chain->n_unknown; i++) t[i] -= u[i];
    *limits = (ric_limits){.energy = {0, ENERGY / q->model->energy_unit},
                           .period = {period / HIGHEST, period / LOWEST},
                           .max_step = ARC,
                           .max_points = 1 << 28};
    need(!ric_continuation_create(chain, u, t, 0, limits, &tr),
         "the start of a branch does not converge");
    tr->may_gain = false; /* more symmetries than those of the form are what is meant here */
    ric_shooting_free(other);
    free(u);
    free(t);
    return tr;
}

/* A trace that left for another branch: the impacts of a repeated S2 are equally spaced. */
static bool hopped(const course *q, const ric_continuation *tr)
{
    const ric_shooting *c = tr->chain;
    const double *tau = tr->now.u + c->n_start;
    for (int i = 1; !q->edge && i < c->n_flight; i++)
        if (fabs(tau[i] - tau[0]) > 1e-9 * tau[0]) return true;
    return false;
}

/* ------------------------------------------------------------------ measuring */

/* Along the course from *x to its end, or for `seconds`; *x is then where to go on. Returns the
 * time used. */
static double follow(const course *q, double seconds, double *x, figures *out)
{
    ric_limits limits;
    ric_continuation *tr = start(q, *x, &limits);
    bool done = false;
    double used = 0, begin = now();
    while (!done && (q->edge || *x <= q->to) && used < seconds) {
        double s = tr->now.s;
        limits.max_step = ARC / tr->chain->scale;
        tr->step = ARC;
        need(!ric_continuation_advance(tr, &done), ric_detail());
        out->points++;
        out->residual = fmax(out->residual, tr->now.row.residual);
        out->short_steps += tr->now.s - s < 0.99 * ARC;
        *x = tr->now.row.frequency * q->k;
        if (out->points % 32 == 0 || q->model->n > 3) used = now() - begin;
    }
    used = now() - begin;
    need(q->edge || (!done && !hopped(q, tr)), "a repeated orbit was not followed to the end");
    if (q->edge || *x > q->to) *x = q->from;
    out->n_flight = tr->chain->n_flight;
    out->evaluations += tr->evaluations;
    out->bytes = tr->stride * sizeof(double);
    ric_periodic *c = ric_periodic_from_chain(tr->chain, tr->now.u);
    need(c, "no memory");
    out->N = c->N;
    ric_periodic_free(c);
    ric_continuation_free(tr);
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

static double aim(int N)
{
    return N == 2 ? 350000 : N == 12 ? 50000 : N == 48 ? 10000 : 0;
}

static void show(const course *q, const figures *f)
{
    char goal[32] = "", text[96];
    if (q->edge) snprintf(text, sizeof text, "%s", q->name);
    else snprintf(text, sizeof text, "%s on %g..%g", q->name, q->from, q->to);
    if (aim(f->N) > 0 && ric_model_detached(q->model))
        snprintf(goal, sizeof goal, "%.0f", aim(f->N));
    say("%-22s %-10s %5d %10.0f %8s %8.2f %8.2f %8.2f%% %9.1e%s\n", text, form_text[q->form], f->N,
        f->rate, goal, 1e6 / f->rate, (double)f->evaluations / (double)f->points,
        100 * (double)f->short_steps / (double)f->points, f->residual,
        f->residual <= RESIDUAL ? "" : " ABOVE THE LIMIT");
}

static void show_head(void)
{
    say("%-22s %-10s %5s %10s %8s %8s %8s %9s %9s\n", "branch", "form", "N", "points/s", "aim",
        "us/point", "eval/pt", "shortened", "residual");
}

/* Slope of log time against log N from `first` on. */
static double exponent(int n, const int *k, const double *rate, int first)
{
    double sx = 0, sy = 0, sxx = 0, sxy = 0, count = 0;
    for (int i = 0; i < n; i++) {
        double x = log(2 * k[i]), y = -log(rate[i]);
        if (2 * k[i] < first) continue;
        sx += x;
        sy += y;
        sxx += x * x;
        sxy += x * y;
        count++;
    }
    return (count * sxy - sx * sy) / (count * sxx - sx * sx);
}

static void repeated(const ric_model *m, double seconds)
{
    static const int k[] = {1, 2, 4, 6, 8, 12, 24, 48, 96, 192, 384, 512};
    enum { COUNT = sizeof k / sizeof *k };
    double rate[COUNT], slope[2];
    say("\nS2-[01] k times over, N = 2k impacts solved as they stand\n");
    show_head();
    for (form g = GENERAL; g >= REVERSIBLE; g--) {
        for (int i = 0; i < COUNT; i++) {
            course q = {"k S2-[01]", m, k[i], g, 2.2, 2.7, NULL};
            figures f = measure(&q, seconds);
            show(&q, &f);
            rate[i] = f.rate;
        }
        slope[g == GENERAL] = exponent(COUNT, k, rate, 48);
    }
    say("exponent of the time per point in N, fitted on 48..1024: general %.3f, reversible %.3f "
        "(aim at most 1.1)\n",
        slope[1], slope[0]);
}

/* -------------------------------------------------------------- nanoseconds */

static volatile double sink;

enum { ROTATION, FLIGHT, EVALUATION, ITERATION };

/* Seconds for `times` rotations of all modes, flights or evaluations of a chain, or Newton
 * iterations as the corrector does them. */
static double run(int what, int times, ric_shooting *c, const double *u, double *du)
{
    const ric_model *m = c->model;
    int n = m->n, flights = c->n_flight;
    double trig[3 * n], w[2 * n], begin = now();
    memcpy(w, c->w, sizeof w);
    for (int i = 0; i < times; i++) {
        if (what == ROTATION) {
            ric_flight_trig(m, n, u[c->n_start + i % flights], trig);
            ric_flight(n, trig, w, w);
        } else if (what == FLIGHT) ric_shooting_fly(c, u);
        else ric_shooting_evaluate(c, u);
        if (what != ITERATION) continue;
        ric_shooting_step(c, true, 0, du);
        ric_shooting_step(c, false, 1, du);
    }
    sink = w[0];
    return now() - begin;
}

static double fastest(int what, int times, ric_shooting *c, const double *u, double *du)
{
    double least = HUGE_VAL;
    for (int b = 0; b < (c->model->n < 100 ? 10 : 3); b++)
        least = fmin(least, run(what, times, c, u, du));
    return least / times;
}

static void nanoseconds(const ric_model *m)
{
    const int k = 24;
    double rotation = 0;
    say("\nnanoseconds per impact, N = %d\n%-12s %12s %20s %20s\n", 2 * k, "form", "evaluation",
        "Newton iteration", "of a rotation");
    for (form g = GENERAL; g >= REVERSIBLE; g--) {
        course q = {"", m, k, g, 2.2, 2.7, NULL};
        ric_shooting *c;
        double *u = chain_at(&q, 2.4, &c), *du = calloc((size_t)c->n_unknown, sizeof *du);
        need(du, "no memory");
        ric_shooting_evaluate(c, u);
        if (rotation == 0) rotation = fastest(ROTATION, 100000, c, u, du);
        double evaluation = fastest(EVALUATION, 1000, c, u, du) / c->n_flight,
               iteration = fastest(ITERATION, 1000, c, u, du) / c->n_flight;
        say("%-12s %12.1f %20.1f %12.2f, %6.2f\n", form_text[g], 1e9 * evaluation, 1e9 * iteration,
            evaluation / rotation, iteration / rotation);
        ric_shooting_free(c);
        free(u);
        free(du);
    }
    say("one modal rotation (%d sincos and the products): %.1f ns\n", m->n, 1e9 * rotation);
}

/* --------------------------------------------------------------- many modes */

/* n masses of 1 in a row between walls on springs of 1, the last one between two stops. */
static ric_model *row_of_masses(int n)
{
    double *mass = calloc((size_t)(n * n), sizeof *mass),
           *stiffness = calloc((size_t)(n * n), sizeof *stiffness),
           *normal = calloc((size_t)n, sizeof *normal);
    need(mass && stiffness && normal, "no memory");
    for (int i = 0; i < n; i++) {
        mass[i * n + i] = 1;
        stiffness[i * n + i] = 2;
        if (i > 0) stiffness[i * n + i - 1] = stiffness[(i - 1) * n + i] = -1;
    }
    normal[n - 1] = 1;
    ric_model *model = between_stops(n, mass, stiffness, normal);
    free(mass);
    free(stiffness);
    free(normal);
    return model;
}

/* Seconds for one flight of the general form, from orbits of 4 and 20 impacts, and for what comes
 * once a point. */
static void per_flight(const ric_model *m, int what, double *flight, double *rest)
{
    static const int k[] = {2, 10};
    double time[2];
    const int times = 1 + 20000 / (m->n * m->n);
    for (int i = 0; i < 2; i++) {
        course q = {"", m, k[i], GENERAL, 2.2, 2.7, NULL};
        ric_shooting *c;
        double *u = chain_at(&q, 2.4, &c);
        time[i] = fastest(what, times, c, u, NULL);
        ric_shooting_free(c);
        free(u);
    }
    *flight = (time[1] - time[0]) / (2 * (k[1] - k[0]));
    *rest = time[0] - 2 * k[0] * *flight;
}

/* Slope of log y against log n. */
static double steepness(const int *n, const double *y, int from, int to)
{
    return log(y[to] / y[from]) / log((double)n[to] / n[from]);
}

static void many_modes(double seconds)
{
    static const int n[] = {2, 10, 30, 100, 300};
    enum { COUNT = sizeof n / sizeof *n };
    double state[COUNT], whole[COUNT], rest;
    say("\nn masses in a row, S2-[01] from 2.2 rad/s on (all modes lie below 2)\n%5s %12s %12s "
        "%16s %16s %14s\n",
        "n", "points/s", "us/point", "us, a flight", "with factors", "once a point");
    for (int i = 0; i < COUNT; i++) {
        ric_model *m = row_of_masses(n[i]);
        course q = {"", m, 1, OWN, 2.2, 2.7, NULL};
        figures f = {0};
        double x = q.from, used = follow(&q, seconds, &x, &f);
        per_flight(m, FLIGHT, &state[i], &rest);
        per_flight(m, EVALUATION, &whole[i], &rest);
        say("%5d %12.4g %12.4g %16.4g %16.4g %14.4g\n", n[i], (double)f.points / used,
            1e6 * used / (double)f.points, 1e6 * state[i], 1e6 * whole[i], 1e6 * rest);
        ric_model_free(m);
    }
    say("exponent of a flight in n, 30..300: state %.2f (linear: 1), with factors %.2f (aim 2)\n",
        steepness(n, state, 2, 4), steepness(n, whole, 2, 4));
}

/* ------------------------------------------------------------- the demo study */

static const ric_continuation *find_s6(const ric_graph *g)
{
    for (int i = 0; i < g->n_edge; i++) {
        const ric_continuation *tr = g->edges[i].trace;
        if (tr->n_point < 10 || tr->chain->multiple != 4) continue;
        const double *u = tr->points + sizeof(ric_point) / sizeof(double);
        ric_shooting_fly(tr->chain, u);
        ric_periodic *c = ric_periodic_from_chain(tr->chain, u);
        bool found = c && c->N == 6;
        for (int k = 0; found && k < 6; k++)
            found = c->face[k] == c->face[k % 2] && c->face[0] != c->face[1];
        ric_periodic_free(c);
        if (found) return tr;
    }
    return NULL;
}

/* The S2 orbits with the most points: from the centre to an impact, or through the closing of a
 * spring to rest. */
static const ric_continuation *find_backbone(const ric_graph *g, int n_flight)
{
    const ric_continuation *best = NULL;
    for (int i = 0; i < g->n_edge; i++) {
        const ric_continuation *tr = g->edges[i].trace;
        if (tr->chain->multiple == 4 && tr->chain->n_flight == n_flight &&
            (!best || tr->n_point > best->n_point))
            best = tr;
    }
    return best;
}

/* Bytes in use on the heap; 0 where the C library does not say. */
static size_t heap(void)
{
#ifdef __GLIBC__
    return mallinfo2().uordblks;
#else
    return 0;
#endif
}

static void explore(ric_study *study, ric_graph **graph, double *seconds)
{
    double begin = now();
    need(!ric_graph_create(study, NULL, graph), ric_detail());
    need(!ric_graph_explore(*graph, NULL), ric_detail());
    *seconds = now() - begin;
}

static void show_demo(const ric_graph *g, const char *path, double seconds, size_t bytes)
{
    long points = 0, evaluations = 0;
    size_t stored = 0;
    for (int i = 0; i < g->n_edge; i++) {
        const ric_continuation *tr = g->edges[i].trace;
        points += tr->n_point;
        evaluations += tr->evaluations;
        stored += (size_t)tr->n_point * tr->stride * sizeof(double);
    }
    say("\n%s: %d branches, %d junctions, %ld points, %ld evaluations in %.3f s (aim 2 s)\n", path,
        g->n_edge, g->n_node, points, evaluations, seconds);
    if (!bytes) return;
    say("its memory, junctions and all: %zu bytes, %.0f a point; without the points %.0f for each "
        "branch or junction\n",
        bytes, (double)bytes / (double)points,
        ((double)bytes - (double)stored) / (g->n_edge + g->n_node));
}

/* ---------------------------------------------------------- power-law contacts */

/* The in-phase path of the article's two masses with springs of power n, from energy 0.1 on. */
static void smooth_paths(double seconds)
{
    static const struct {
        int exponent;
        double aim;
    } rows[] = {{3, 30000}, {7, 15000}, {21, 6000}};
    say("\npower-law contacts, in-phase path from energy 0.1 on\n");
    show_head();
    for (int i = 0; i < 3; i++) {
        char text[400], name[40];
        ric_study *study;
        ric_graph *graph;
        double spent;
        snprintf(
            text, sizeof text,
            "title: power\nmodel: {mass: [[2, 0], [0, 1]], stiffness: [[9, -1], [-1, 1]],\n"
            "  contacts: [{normal: [-1, 1], law: power, exponent: %d, length: 1, reference: 1}]}\n"
            "explore: {start: [1], energy: [0, %d], frequency: [0.2, 10], multiply: 1, depth: 1}\n",
            rows[i].exponent, ENERGY);
        need(!ric_study_parse(text, "bench", ".", &study), ric_detail());
        explore(study, &graph, &spent);
        const ric_continuation *path = graph->edges[0].trace;
        int from = 1;
        while (from + 2 < path->n_point &&
               ((const ric_point *)(path->points + (size_t)from * path->stride))->energy < 0.1)
            from++;
        snprintf(name, sizeof name, "S+, n = %d (aim %.0f)", rows[i].exponent, rows[i].aim);
        for (int g = OWN; g <= GENERAL; g += GENERAL - OWN) {
            course q = {name, graph->model, 1, (form)g, from, 0, path};
            figures f = measure(&q, seconds);
            show(&q, &f);
        }
        ric_graph_free(graph);
        ric_study_free(study);
    }
}

/* ------------------------------------------------------------------- sections */

/* Motions of one energy from impact to impact, with exponent and rotation. */
static void sections(const ric_model *m, double seconds)
{
    static const double energies[] = {0.7, 5, 40};
    say("\nsections: impacts per second (aim 1e+06)\n");
    for (int i = 0; i < 3; i++) {
        ric_section_options options;
        long impacts = 0;
        double begin = now();
        ric_section_options_init(&options);
        options.energy = energies[i];
        options.starts = 4;
        options.impacts = 20000;
        options.rows = false;
        do {
            ric_section *section;
            need(!ric_section_create(m, &options, &section) && !ric_section_run(section),
                 ric_detail());
            impacts += options.starts * options.impacts;
            ric_section_free(section);
        } while (now() - begin < seconds);
        say("E = %-4g %10.4g\n", energies[i], (double)impacts / (now() - begin));
    }
}

/* ----------------------------------------------------------------------- main */

static void show_machine(void)
{
    char line[256], day[32];
    time_t t = time(NULL);
    strftime(day, sizeof day, "%Y-%m-%d", localtime(&t));
    say("ricochet %s, %s, ", ric_version(), day);
    FILE *info = fopen("/proc/cpuinfo", "r");
    bool found = false;
    while (info && !found && fgets(line, sizeof line, info))
        found = !strncmp(line, "model name", 10);
    if (info) fclose(info);
    say("%s", found && strchr(line, ':') ? strchr(line, ':') + 2 : "processor unknown\n");
    say("one core, step %g in the norm of the unknowns, residual at most %.0e, all events "
        "watched\n\n",
        ARC, RESIDUAL);
}

static void show_memory(int n, const figures *own, const figures *general)
{
    say("\nbytes of a stored point, N = %d: %zu (own form), %zu (general form); aim at most %d\n",
        own->N, own->bytes, general->bytes, 8 * (2 * n + own->N) + 64);
}

int main(int argc, char **argv)
{
    const char *out = "build/bench.txt", *path = "examples/elementary/study.yaml";
    double seconds = 0.4, demo;
    for (int option; (option = getopt(argc, argv, "o:t:")) != -1;) {
        if (option == 'o') out = optarg;
        else if (option == 't') seconds = atof(optarg);
        else {
            fprintf(stderr, "usage: ricochet-bench [-o FILE] [-t SECONDS] [STUDY]\n");
            return 2;
        }
    }
    if (optind < argc) path = argv[optind];
    ric_study *study;
    ric_graph *graph;
    need(!ric_study_read(path, &study), ric_detail());
    file = fopen(out, "w");
    need(file, "the output file cannot be written");
    show_machine();
    ric_model *m = article();
    size_t bytes = heap();
    explore(study, &graph, &demo);
    bytes = heap() - bytes;
    const ric_continuation *s6 = find_s6(graph);
    course rows[] = {{"S2-[01]", m, 1, OWN, 2.2, 2.7, NULL},
                     {"S2-[01]", m, 1, GENERAL, 2.2, 2.7, NULL},
                     {"S2-[01]", m, 1, OWN, 4, 6, NULL},
                     {"S2-[01]", m, 1, GENERAL, 4, 6, NULL},
                     {"S6-[010101]", graph->model, 1, OWN, 1, 0, s6},
                     {"S6-[010101]", graph->model, 1, GENERAL, 1, 0, s6}};
    figures f[6];
    show_head();
    for (int i = 0; i < (s6 ? 6 : 4); i++) {
        f[i] = measure(&rows[i], seconds);
        show(&rows[i], &f[i]);
    }
    ric_study *spring_study;
    ric_graph *springs;
    double unused;
    need(!ric_study_read("examples/bilinear/study.yaml", &spring_study), ric_detail());
    explore(spring_study, &springs, &unused);
    const ric_continuation *soft = find_backbone(springs, 2), *rigid = find_backbone(graph, 1);
    course pair[] = {{"S2[01], stop", graph->model, 1, OWN, 1, 0, rigid},
                     {"S2[01], spring", springs->model, 1, OWN, 1, 0, soft},
                     {"S2[01], stop", graph->model, 1, GENERAL, 1, 0, rigid},
                     {"S2[01], spring", springs->model, 1, GENERAL, 1, 0, soft}};
    for (int i = 0; rigid && soft && i < 4; i++) {
        figures g = measure(&pair[i], seconds);
        show(&pair[i], &g);
    }
    ric_graph_free(springs);
    ric_study_free(spring_study);
    repeated(m, seconds);
    nanoseconds(m);
    smooth_paths(seconds);
    sections(m, seconds);
    many_modes(seconds);
    show_demo(graph, path, demo, bytes);
    show_memory(m->n, &f[0], &f[1]);
    if (s6) show_memory(m->n, &f[4], &f[5]);
    ric_graph_free(graph);
    ric_study_free(study);
    ric_model_free(m);
    need(!fclose(file), "the output file cannot be written");
    return 0;
}
