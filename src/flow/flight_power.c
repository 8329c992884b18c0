/* Flights under a power law: contacts act all the time, and the flow is integrated (power_flow.h).
 */
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "flight_law.h"
#include "power_flow.h"

/* The workspace is kept on the stack unless the structure is large. */
enum { SMALL = 1 << 15 };

typedef bool mapping(const ric_model *m, double tau, double *w, double *M, double *lost,
                     double *work);

/* The state `after`, in place. Where the flow cannot be followed it is infinite, and no orbit is
 * found there. `matrix` and `lost` may be NULL. */
static void fly(mapping *way, const ric_model *m, double tau, double *matrix, double *lost,
                double *after)
{
    size_t states = 2 * (size_t)m->n, size = ric_power_flow_work(m, matrix ? 2 * m->n : 0),
           small = size <= SMALL ? size : 1;
    _Alignas(16) double stack[small];
    double *work = size <= SMALL ? stack : ric_malloc(size * sizeof *work), unwanted;
    if (!work || !(matrix ? way(m, tau, after, matrix, lost ? lost : &unwanted, work)
                          : ric_power_flow_fly(m, tau, after, 0, NULL, work))) {
        for (size_t i = 0; i < states; i++) after[i] = HUGE_VAL;
        for (size_t i = 0; matrix && i < states * states; i++) matrix[i] = 0;
        if (lost) *lost = 0;
    }
    if (work != stack) free(work);
}

void ric_flight_smooth(const ric_model *m, double tau, const double *w, double *matrix,
                       double *lost, double *after)
{
    if (after != w) memcpy(after, w, 2 * (size_t)m->n * sizeof *w);
    fly(ric_power_flow_map_surely, m, tau, matrix, lost, after);
}

void ric_flight_roughly(const ric_model *m, double tau, const double *w, double *matrix,
                        double *lost, double *after)
{
    memcpy(after, w, 2 * (size_t)m->n * sizeof *w);
    fly(ric_power_flow_map, m, tau, matrix, lost, after);
}

void ric_flight_visit(const ric_model *m, int count, const double *tau, const double *from,
                      double *w)
{
    size_t size = ric_power_flow_work(m, 0), small = size <= SMALL ? size : 1;
    _Alignas(16) double stack[small];
    double *work = size <= SMALL ? stack : ric_malloc(size * sizeof *work);
    if (!work || !ric_power_flow_visit(m, count, tau, from, w, work))
        for (int i = 0; i < count * 2 * m->n; i++) w[i] = HUGE_VAL;
    if (work != stack) free(work);
}

double ric_flight_pace(const ric_model *m, const double *w)
{
    size_t size = ric_power_flow_work(m, 0), small = size <= SMALL ? size : 1;
    _Alignas(16) double stack[small];
    double *work = size <= SMALL ? stack : ric_malloc(size * sizeof *work),
           pace = work ? ric_power_flow_pace(m, w, work) : 0;
    if (work != stack) free(work);
    return pace;
}

static void go(const ric_model *m, uint64_t closed, int event, double tau, const double *w,
               double *after)
{
    (void)closed, (void)event;
    ric_flight_smooth(m, tau, w, NULL, NULL, after);
}

static void map(const ric_model *m, uint64_t closed, int event, double tau, const double *w,
                double *matrix, double *after, double *rate)
{
    (void)event;
    ric_flight_smooth(m, tau, w, matrix, NULL, after);
    ric_flight_rate(m, closed, after, rate);
}

static double power(double s, int exponent)
{
    double out = s, square = s * s;
    for (int i = 1; i < exponent; i += 2) out *= square;
    return out;
}

static void push(const ric_model *m, uint64_t closed, const double *w, double *rate)
{
    int n = m->n;
    (void)closed;
    for (int f = 0; f < m->n_contact; f++) {
        double force = m->spring[f] * power(ric_dot(n, m->g + f * n, w), m->contact[f].exponent);
        for (int i = 0; i < n; i++) rate[n + i] -= force * m->c[f * n + i];
    }
}

static double store(const ric_model *m, uint64_t closed, const double *w)
{
    double springs = 0;
    (void)closed;
    for (int f = 0; f < m->n_contact; f++) {
        double s = ric_dot(m->n, m->g + f * m->n, w);
        springs += m->spring[f] * s * power(s, m->contact[f].exponent) * 2 /
                   (m->contact[f].exponent + 1);
    }
    return springs;
}

/* (s1^(m+1) - s0^(m+1)) / (s1 - s0), without the cancellation. */
static double power_secant(double s0, double s1, int exponent)
{
    double sum = 0, lead = 1;
    for (int j = 0; j <= exponent; j++) {
        sum = sum * s0 + lead;
        lead *= s1;
    }
    return sum;
}

static void secant(const ric_model *m, uint64_t closed, const double *w0, const double *w1,
                   double *h)
{
    int n = m->n;
    (void)closed;
    for (int f = 0; f < m->n_contact; f++) {
        const double *g = m->g + f * n;
        int exponent = m->contact[f].exponent;
        double force = 2 * m->spring[f] / (exponent + 1) *
                       power_secant(ric_dot(n, g, w0), ric_dot(n, g, w1), exponent);
        for (int i = 0; i < n; i++) h[i] += force * g[i];
    }
}

const ric_flight_law ric_flight_power =
    {.integrated = true, .go = go, .map = map, .push = push, .store = store, .secant = secant};
