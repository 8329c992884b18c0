#include "power_flow.h"

#include <float.h>

/* With a radius of convergence r and the step h = r EPSILON^(1/ORDER) the cost of a time is ORDER^2
 * / h, least at ORDER = -ln(EPSILON) / 2 = 18 (Jorba and Zou 2005) if only the products counted;
 * what each step costs besides moves it up. */
enum { ORDER = 28, PAD = 4, LANES = 2 };
#define EPSILON DBL_EPSILON
typedef double real, lane __attribute__((vector_size(16)));
static inline double sum_of(lane x)
{
    return x[0] + x[1];
}
#include "taylor_plain.h"

#include "taylor.h"

int ric_power_flow_products(int exponent, int *left, int *right)
{
    int count = 0, product = -1;
    for (int rest = (exponent - 1) / 2, square = 0; rest > 0; rest /= 2) {
        left[++count] = square;
        right[count] = square;
        square = count;
        if (rest % 2 == 0) continue;
        if (product >= 0) {
            left[++count] = product;
            right[count] = square;
            product = count;
        } else product = square;
    }
    return count;
}

size_t ric_power_flow_work(const ric_model *m, int columns)
{
    return series_work(m, columns) + (size_t)columns * (size_t)columns;
}

/* The same code with sizes known to the compiler for the structures of the article. */
static bool go(const ric_model *m, double tau, double *w, int columns, double *X, double *S,
               double *work)
{
    if (m->n == 2 && m->n_contact == 1 && columns == 4)
        return fly_series(m, 2, 1, 4, tau, w, X, S, work);
    if (m->n == 2 && m->n_contact == 1 && columns == 0)
        return fly_series(m, 2, 1, 0, tau, w, X, S, work);
    return fly_series(m, m->n, m->n_contact, columns, tau, w, X, S, work);
}

bool ric_power_flow_fly(const ric_model *m, double tau, double *w, int columns, double *X,
                        double *work)
{
    return go(m, tau, w, columns, X, NULL, work);
}

double ric_power_flow_pace(const ric_model *m, const double *w, double *work)
{
    int n = m->n, contacts = m->n_contact;
    powers *p = (powers *)work;
    double *W = work + (size_t)contacts * powers_size(), after[2 * n];
    for (int f = 0; f < contacts; f++) plan(m->contact[f].exponent, &p[f]);
    memcpy(W, w, sizeof after);
    for (int j = 0; j < ORDER; j++) state_order(m, n, contacts, j, p, W);
    return advance(m, n, contacts, p, radius(2 * n, W), 1, W, after);
}

/* Of all steps, S [2n * 2n] in units of `unit` epsilon, and of the start as it is given, carried by
 * M to the end. */
static double loss(int size, double start, double unit, const double *M, const double *S)
{
    double largest = 0;
    for (int i = 0; i < size; i++) {
        const double *row = M + i * size;
        double sum = 0, own = start * start * ric_dot(size, row, row);
        for (int j = 0; j < size; j++) sum += row[j] * ric_dot(size, S + j * size, row);
        /* where S is lost in rounding, too, the start is left */
        largest = larger(largest, own + unit * unit * larger(sum, 0));
    }
    return sqrt(largest);
}

static bool map(const ric_model *m, double tau, double *w, double *M, double *S, double *lost,
                double *work)
{
    int size = 2 * m->n;
    double start = top_of(size, w);
    for (int i = 0; i < size * size; i++) M[i] = i % (size + 1) == 0;
    memset(S, 0, (size_t)size * (size_t)size * sizeof *S);
    if (!go(m, tau, w, size, M, S, work)) return false;
    *lost = loss(size, start, 1, M, S);
    return true;
}

/* Behind the workspace of the series: what the steps lose, [2n * 2n]. */
static double *losses(const ric_model *m, double *work)
{
    return work + series_work(m, 2 * m->n);
}

bool ric_power_flow_map(const ric_model *m, double tau, double *w, double *M, double *lost,
                        double *work)
{
    return map(m, tau, w, M, losses(m, work), lost, work);
}

bool ric_power_flow_map_surely(const ric_model *m, double tau, double *w, double *M, double *lost,
                               double *work)
{
    int size = 2 * m->n;
    double *S = losses(m, work), w0[size], start = top_of(size, w);
    memcpy(w0, w, sizeof w0);
    if (!map(m, tau, w, M, S, lost, work)) return false;
    if (*lost <= RIC_SMOOTH_LOSES * (1 + sqrt(ric_dot(size, w0, w0)))) return true;
    double unit = ric_power_flow_again(m, tau, w0, w, M, S);
    if (unit < 1) *lost = loss(size, start, unit, M, S);
    return true;
}
