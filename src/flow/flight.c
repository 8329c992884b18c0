#include "flight.h"

#include "flight_law.h"

void ric_flight_go(const ric_model *m, uint64_t closed, int event, double tau, const double *w,
                   double *after)
{
    ric_flight_law_of(m)->go(m, closed, event, tau, w, after);
}

void ric_flight_map(const ric_model *m, uint64_t closed, int event, double tau, const double *w,
                    double *matrix, double *after, double *rate)
{
    ric_flight_law_of(m)->map(m, closed, event, tau, w, matrix, after, rate);
}

void ric_flight_rate(const ric_model *m, uint64_t closed, const double *w, double *rate)
{
    ric_flow(m, m->n, w, rate);
    ric_flight_law_of(m)->push(m, closed, w, rate);
}

double ric_flight_energy(const ric_model *m, uint64_t closed, const double *w)
{
    int n = m->n;
    double sum = 0;
    for (int i = 0; i < n; i++) {
        if (m->stiff[i] != 0) sum += w[i] * w[i];
        sum += w[n + i] * w[n + i];
    }
    return (sum + ric_flight_law_of(m)->store(m, closed, w)) / 2;
}

void ric_flight_secant(const ric_model *m, uint64_t closed, const double *w0, const double *w1,
                       double *h)
{
    int n = m->n;
    for (int i = 0; i < n; i++) {
        h[i] = m->stiff[i] == 0 ? 0 : w1[i] + w0[i];
        h[n + i] = w1[n + i] + w0[n + i];
    }
    ric_flight_law_of(m)->secant(m, closed, w0, w1, h);
}
