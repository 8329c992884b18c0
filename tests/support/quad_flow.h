/* The smooth flow in quadruple precision, as the truth that others are measured by. */
#ifndef QUAD_FLOW_H
#define QUAD_FLOW_H

#include <stdlib.h>

#include "flow/power_flow.h"

#include "flow/taylor_quad.h"

/* w [2n] through the time tau, rounded at the end only. */
static bool quad_fly(const ric_model *m, double tau, double *w)
{
    int size = 2 * m->n;
    real *v = malloc(((size_t)size + series_work(m, 0)) * sizeof *v);
    if (!v) return false;
    for (int i = 0; i < size; i++) v[i] = w[i];
    bool flown = fly_series(m, m->n, m->n_contact, 0, tau, v, NULL, NULL, v + size);
    for (int i = 0; i < size; i++) w[i] = (double)v[i];
    free(v);
    return flown;
}

#endif
