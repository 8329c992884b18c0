/* Forced orbits per second, against a shooting code on a time integrator with root finding (CVODE),
 * on the same orbits.
 *
 *     ricochet-bench-forced [-o FILE]
 *
 * Two masses between stops (the article's), damping 0.01, force 0.2 on the first mass: ORBITS
 * orbits of the curve with two impacts, a small step of the frequency apart, each from the one
 * before by Newton's method, with its multipliers and with the check that no other stop is met. The
 * shooting code has the state at phase 0 for its unknowns, integrates one period from impact to
 * impact, takes its derivatives from differences, and stops at a residual of 1e-9, a thousand times
 * the tolerance of the integrator. Processor time; printed and written to FILE
 * (build/bench-forced.txt).
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include <lapacke.h>

#include "base/room.h"
#include "force/room.h"
#include "response/response_trace.h"

enum { ORBITS = 60, SIZE = 4 };
#define ENOUGH 0.5 /* s of processor time */

static const double two_pi = 6.283185307179586477, level = 0.2, zeta = 0.01, first = 1.0,
                    step = 0.002;

static const char *const study =
    "title: t\nmodel:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n"
    "  contacts:\n    - {normal: [-1, 1], clearance: 1, sides: both, law: rigid}\n"
    "explore: {energy: [0, 12], frequency: [0.5, 3], impacts: 2, multiply: 1, depth: 1}\n";

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void stop(const char *what)
{
    fprintf(stderr, "ricochet-bench-forced: %s: %s\n", what, ric_detail());
    exit(1);
}

/* ----------------------------------------------------------------- shooting */

typedef struct {
    double omega, C[SIZE];
    N_Vector y;
    void *cvode;
    long steps;
} shooter;

static int rate(sunrealtype t, N_Vector y, N_Vector dy, void *user)
{
    const shooter *s = user;
    const double *x = NV_DATA_S(y), *v = x + 2;
    double *dx = NV_DATA_S(dy);
    dx[0] = v[0];
    dx[1] = v[1];
    dx[2] = (level * cos(s->omega * t) - 9 * x[0] + x[1] - s->C[0] * v[0] - s->C[1] * v[1]) / 2;
    dx[3] = x[0] - x[1] - s->C[2] * v[0] - s->C[3] * v[1];
    return 0;
}

static int gaps(sunrealtype t, N_Vector y, sunrealtype *out, void *user)
{
    const double *x = NV_DATA_S(y);
    (void)t;
    (void)user;
    out[0] = 1 - (x[1] - x[0]);
    out[1] = 1 + (x[1] - x[0]);
    return 0;
}

/* One period of the force; M = diag(2, 1). */
static void shoot(shooter *s, const double *from, double *to)
{
    const double end = two_pi / s->omega;
    double t = 0, *y = NV_DATA_S(s->y);
    memcpy(y, from, SIZE * sizeof *y);
    CVodeReInit(s->cvode, 0, s->y);
    CVodeSetStopTime(s->cvode, end);
    while (t < end) {
        const int flag = CVode(s->cvode, end, s->y, &t, CV_NORMAL);
        long n = 0;
        if (flag < 0) stop("CVODE");
        if (flag != CV_ROOT_RETURN) continue;
        CVodeGetNumSteps(s->cvode, &n);
        s->steps += n;
        const double kick = 2 * (y[3] - y[2]) / 1.5;
        y[2] += kick / 2;
        y[3] -= kick;
        CVodeReInit(s->cvode, t, s->y);
        CVodeSetStopTime(s->cvode, end);
    }
    memcpy(to, y, SIZE * sizeof *to);
}

/* Newton's method from y; the monodromy matrix is its Jacobian. */
static bool solve(shooter *s, double *y, double *monodromy)
{
    for (int k = 0; k < 12; k++) {
        double z[SIZE], J[SIZE * SIZE], R[SIZE], off = 0;
        lapack_int pivot[SIZE];
        shoot(s, y, z);
        for (int i = 0; i < SIZE; i++) off = fmax(off, fabs(R[i] = y[i] - z[i]));
        for (int j = 0; j < SIZE; j++) {
            double moved[SIZE], w[SIZE];
            memcpy(moved, y, sizeof moved);
            moved[j] += 1e-6;
            shoot(s, moved, w);
            for (int i = 0; i < SIZE; i++) monodromy[i * SIZE + j] = (w[i] - z[i]) / 1e-6;
        }
        if (off < 1e-9) return true;
        for (int i = 0; i < SIZE * SIZE; i++) J[i] = (i % (SIZE + 1) == 0) - monodromy[i];
        if (LAPACKE_dgesv(LAPACK_ROW_MAJOR, SIZE, 1, J, SIZE, pivot, R, 1)) return false;
        for (int i = 0; i < SIZE; i++) y[i] -= R[i];
    }
    return false;
}

/* C = sum 2 zeta omega_i (M phi_i)(M phi_i)', M^-1 taken. */
static void damp(const ric_model *model, double *C)
{
    double omega[2], Phi[4];
    const double M[] = {2, 1};
    ric_model_frequencies(model, omega);
    ric_model_modes(model, Phi);
    memset(C, 0, SIZE * sizeof *C);
    for (int a = 0; a < 2; a++)
        for (int b = 0; b < 2; b++)
            for (int i = 0; i < 2; i++)
                C[a * 2 + b] += M[a] * Phi[a * 2 + i] * 2 * zeta * omega[i] * Phi[b * 2 + i] * M[b];
}

/* ---------------------------------------------------------------------- ours */

static ric_force_orbit *start_of(ric_force_medium *m, const ric_atlas *atlas,
                                 const ric_force *force)
{
    for (int id = 1; id <= ric_atlas_n_branch(atlas); id++) {
        ric_branch b;
        ric_orbit **orbits;
        ric_prediction p;
        ric_force_orbit *o = NULL;
        int n = 0;
        if (ric_atlas_branch(atlas, id, &b) || strcmp(b.label, "S2+[01]") != 0) continue;
        if (ric_orbit_find(atlas, id, RIC_AT_FREQUENCY, first + ORBITS * step, &n, &orbits) ||
            n == 0)
            stop("start");
        ric_force_predict(force, id, orbits[0], 1, level, &p);
        if (!p.n_phase || ric_force_start_from(m, orbits[0], 1, level, p.phases[0], &o) ||
            !ric_force_start_settle(o))
            stop("start");
        return o;
    }
    stop("no branch S2+");
    return NULL;
}

/* The next orbit, checked, with its multipliers. */
static bool next(ric_force_orbit *o, double omega)
{
    double margin, mu[2 * SIZE], rounding;
    o->drive.omega = omega;
    return ric_force_orbit_solve(o, RIC_ALONG_LEVEL, 1, NULL, 0, NULL) &&
           !ric_response_trace_margin(o, &margin) && margin > 0 &&
           !ric_force_motion_multipliers(o, mu, &rounding, NULL);
}

int main(int argc, char **argv)
{
    const char *path = argc == 3 && !strcmp(argv[1], "-o") ? argv[2] : "build/bench-forced.txt";
    const double f[] = {1, 0};
    const ric_shaking shaking = {.n_force = 2,
                                 .force = f,
                                 .n_ratio = 1,
                                 .ratios = &zeta,
                                 .restitution = 1};
    ric_study *read = NULL;
    ric_atlas *atlas = NULL;
    ric_force *force = NULL;
    ric_force_medium *m = NULL;
    char name[] = "/tmp/ricochet-bench-XXXXXX";
    const int made = mkstemp(name);
    const ric_run_options run = {0};
    if (made < 0 || remove(name) || ric_study_parse(study, "bench", NULL, &read) ||
        ric_explore(read, name, &run) || ric_atlas_read(name, &atlas) ||
        ric_force_create(atlas, &shaking, &force) || ric_force_medium_create(force, &m))
        stop("set-up");
    remove(name);
    ric_force_orbit *o = start_of(m, atlas, force), *kept = ric_force_orbit_copy(o);
    double states[ORBITS][SIZE], omegas[ORBITS], z[SIZE], public[SIZE];
    double begin = now(), took;
    int rounds = 0;
    do {                                /* a processor's clock may tick a hundred times a second */
        if (rounds == 1) begin = now(); /* the first round warms up */
        ric_force_orbit_take(o, kept);
        for (int i = 0; i < ORBITS; i++) {
            omegas[i] = first + (ORBITS - 1 - i) * step;
            if (!next(o, omegas[i] / m->time)) stop("an orbit");
            if (rounds) continue;
            ric_force_motion_strobe(o, 0, z);
            ric_force_motion_leave(m, z, public);
            memcpy(states[i], public, sizeof public);
        }
        took = now() - begin;
        rounds++;
    } while (rounds < 3 || took < ENOUGH);
    const double best = took / (rounds - 1);
    SUNContext context;
    shooter s = {0};
    if (SUNContext_Create(NULL, &context)) stop("CVODE");
    s.y = N_VNew_Serial(SIZE, context);
    s.cvode = CVodeCreate(CV_ADAMS, context);
    SUNNonlinearSolver solver = SUNNonlinSol_FixedPoint(s.y, 0, context);
    damp(ric_atlas_model(atlas), s.C);
    CVodeInit(s.cvode, rate, 0, s.y);
    CVodeSStolerances(s.cvode, 1e-12, 1e-12);
    CVodeSetNonlinearSolver(s.cvode, solver);
    CVodeSetUserData(s.cvode, &s);
    CVodeSetMaxNumSteps(s.cvode, 1000000);
    CVodeRootInit(s.cvode, 2, gaps);
    CVodeSetRootDirection(s.cvode, (int[]){-1, -1});
    double y[SIZE], J[SIZE * SIZE], apart = 0;
    memcpy(y, states[0], sizeof y);
    begin = now();
    for (int i = 0; i < ORBITS; i++) {
        s.omega = omegas[i];
        if (!solve(&s, y, J)) stop("the shooting code does not converge");
        for (int j = 0; j < SIZE; j++) apart = fmax(apart, fabs(y[j] - states[i][j]));
    }
    const double other = now() - begin;
    FILE *files[] = {stdout, fopen(path, "w")};
    for (int i = 0; i < 2; i++) {
        if (!files[i]) continue;
        fprintf(files[i],
                "forced orbits per second of processor time, two masses, two impacts\n"
                "  ricochet                       %10.0f\n"
                "  shooting with CVODE, tol 1e-12 %10.1f\n"
                "  ratio                          %10.0f   (orbits agree to %.1g)\n",
                ORBITS / best, ORBITS / other, other / best, apart);
    }
    if (files[1]) fclose(files[1]);
    return 0;
}
