/* The smooth flow in quadruple precision, as the truth that others are measured by. */
#ifndef QUAD_FLOW_H
#define QUAD_FLOW_H

#include <stdlib.h>

#include "flow/power_flow.h"

/* 113 bits: of the compiler on x86, long double elsewhere. */
#ifdef __SIZEOF_FLOAT128__
__extension__ typedef __float128 real;
#define QUAD_FLOW_HAS_113_BITS 1
#else
typedef long double real;
#define QUAD_FLOW_HAS_113_BITS 0
#endif
enum { ORDER = 44 }; /* as in power_flow.c */
#define EPSILON 1e-33
#include "flow/taylor_plain.h"

#include "flow/taylor.h"

/* w [2n] through the time tau, all digits. */
static bool quad_fly_all(const ric_model *m, double tau, real *w)
{
    real *work = malloc(series_work(m, 0) * sizeof *work);
    recipe how[m->n_contact];
    plan(m, how);
    const bool flown = work && fly_series(m, m->n, m->n_contact, how, 0, tau, w, NULL, NULL, work);
    free(work);
    return flown;
}

/* The same, rounded at the end only. */
static bool quad_fly(const ric_model *m, double tau, double *w)
{
    const int size = 2 * m->n;
    real v[size];
    for (int i = 0; i < size; i++) v[i] = w[i];
    const bool flown = quad_fly_all(m, tau, v);
    for (int i = 0; i < size; i++) w[i] = (double)v[i];
    return flown;
}

#endif
