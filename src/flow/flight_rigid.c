/* Flights that touch nothing: each mode turns in its plane (modal.h). */
#include <string.h>

#include "flight_law.h"

static void go(const ric_model *m, uint64_t closed, int event, double tau, const double *w,
               double *after)
{
    double trig[3 * m->n];
    (void)closed, (void)event;
    ric_flight_trig(m, m->n, tau, trig);
    ric_flight(m->n, trig, w, after);
}

static void map(const ric_model *m, uint64_t closed, int event, double tau, const double *w,
                double *matrix, double *after, double *rate)
{
    int n = m->n;
    double trig[3 * n];
    (void)closed, (void)event;
    ric_flight_trig(m, n, tau, trig);
    ric_flight(n, trig, w, after);
    ric_flow(m, n, after, rate);
    memset(matrix, 0, 4 * (size_t)n * (size_t)n * sizeof *matrix);
    for (int i = 0; i < n; i++) {
        matrix[i * 2 * n + i] = matrix[(n + i) * 2 * n + n + i] = trig[i];
        matrix[i * 2 * n + n + i] = trig[n + i];
        matrix[(n + i) * 2 * n + i] = -trig[2 * n + i];
    }
}

/* A rigid contact acts in no time and stores nothing. */
static void push(const ric_model *m, uint64_t closed, const double *w, double *rate)
{
    (void)m, (void)closed, (void)w, (void)rate;
}

static double store(const ric_model *m, uint64_t closed, const double *w)
{
    (void)m, (void)closed, (void)w;
    return 0;
}

static void secant(const ric_model *m, uint64_t closed, const double *w0, const double *w1,
                   double *h)
{
    (void)m, (void)closed, (void)w0, (void)w1, (void)h;
}

const ric_flight_law ric_flight_rigid =
    {.turns = true, .go = go, .map = map, .push = push, .store = store, .secant = secant};
