#include <float.h>
#include <stdlib.h>

#include "base/room.h"
#include "power_flow.h"

/* As in power_flow.c: of 64 bits, one by one. */
enum { ORDER = 34 };
#define EPSILON ((double)LDBL_EPSILON)
typedef long double real;
#include "taylor_plain.h"

#include "taylor.h"

double ric_power_flow_again(const ric_model *m, double tau, const double *w0, double *w, double *M,
                            double *S)
{
    int size = 2 * m->n;
    size_t count = (size_t)size * (size_t)size;
    double unit = EPSILON / DBL_EPSILON;
    real *v = unit < 1 ? ric_malloc(((size_t)size + count + series_work(m, size)) * sizeof *v)
                       : NULL,
         *X = v ? v + size : NULL;
    if (!v) return 1;
    for (int i = 0; i < size; i++) v[i] = w0[i];
    for (size_t i = 0; i < count; i++) {
        X[i] = i % ((size_t)size + 1) == 0;
        S[i] = 0;
    }
    recipe how[m->n_contact];
    plan(m, how);
    if (!fly_series(m, m->n, m->n_contact, how, size, tau, v, X, S, X + count)) unit = 1;
    for (int i = 0; i < size && unit < 1; i++) w[i] = (double)v[i];
    for (size_t i = 0; i < count && unit < 1; i++) M[i] = (double)X[i];
    free(v);
    return unit;
}
