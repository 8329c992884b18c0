#include "power_flow.h"

#include <float.h>

/* With a radius of convergence r and the step h = r EPSILON^(1/ORDER) the cost of a time is ORDER^2
 * / h, least at ORDER = -ln(EPSILON) / 2 = 18 (Jorba and Zou 2005) if only the products counted;
 * what each step costs besides moves it up. */
enum { ORDER = 28 };
#define EPSILON DBL_EPSILON
typedef double real, pair __attribute__((vector_size(16)));
#define PAIR(x, y) ((pair){x, y})
#define BOTH(x) ((pair){x, x})
#define FIRST(x) ((x)[0])
#define LAST(x) ((x)[1])
#define AFTER(x) ((pair){0, x})
#define ACROSS(x, y) ((pair){(x)[1], (y)[0]})
#define PLUS(x, y) ((x) + (y))
#define TIMES(x, y) ((x) * (y))
#define LOAD ric_lane_load
#define STORE ric_lane_store
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

/* Those of the structures of the article, and of springs that are found most: what
 * ric_power_flow_products says of the exponent, where the compiler sees it. */
static const recipe of_3 = {1, {0, 0}, {0, 0}}, of_5 = {2, {0, 0, 1}, {0, 0, 1}},
                    of_7 = {3, {0, 0, 1, 1}, {0, 0, 1, 2}},
                    of_21 = {5, {0, 0, 1, 2, 3, 2}, {0, 0, 1, 2, 3, 4}};

/* The same code with sizes known to the compiler: three quarters of the time of that without. */
static bool go(const ric_model *m, double tau, double *w, int columns, double *X, double *S,
               double *work)
{
    int exponent = m->n == 2 && m->n_contact == 1 ? m->contact[0].exponent : 0;
    recipe how[m->n_contact];
    if (columns == 4) switch (exponent) {
        case 3: return fly_series(m, 2, 1, &of_3, 4, tau, w, X, S, work);
        case 5: return fly_series(m, 2, 1, &of_5, 4, tau, w, X, S, work);
        case 7: return fly_series(m, 2, 1, &of_7, 4, tau, w, X, S, work);
        case 21: return fly_series(m, 2, 1, &of_21, 4, tau, w, X, S, work);
        }
    if (columns == 0) switch (exponent) {
        case 3: return fly_series(m, 2, 1, &of_3, 0, tau, w, X, S, work);
        case 5: return fly_series(m, 2, 1, &of_5, 0, tau, w, X, S, work);
        case 7: return fly_series(m, 2, 1, &of_7, 0, tau, w, X, S, work);
        case 21: return fly_series(m, 2, 1, &of_21, 0, tau, w, X, S, work);
        }
    plan(m, how);
    return fly_series(m, m->n, m->n_contact, how, columns, tau, w, X, S, work);
}

bool ric_power_flow_fly(const ric_model *m, double tau, double *w, int columns, double *X,
                        double *work)
{
    return go(m, tau, w, columns, X, NULL, work);
}

/* The series of the state in the workspace, behind those of the contacts. */
static pair *series_of(const ric_model *m, double *work)
{
    return (pair *)(void *)(work + (size_t)m->n_contact * powers_size());
}

/* One step's series from the state w [2n], whose size it says; returns how far it reaches. */
static double series_from(const ric_model *m, const recipe *how, const double *over,
                          const double *w, double *work, double *size)
{
    int n = m->n, contacts = m->n_contact;
    powers *p = (powers *)(void *)work;
    pair *W = series_of(m, work);
    reaches all = {{HUGE_VAL, HUGE_VAL}};
    state_start(m, n, w, W);
    for (int J = 0; J < ORDER; J += 2) state_orders(m, n, contacts, J, over, how, p, W);
    *size = state_reach(n, W, &all);
    return radius(&all);
}

bool ric_power_flow_visit(const ric_model *m, int count, const double *tau, const double *from,
                          double *w, double *work)
{
    int n = m->n, size = 2 * n;
    double over[ORDER + 2], now[size], time = 0;
    recipe how[m->n_contact];
    plan(m, how);
    list_inverses(over);
    memcpy(now, from, sizeof now);
    if (!isfinite(tau[count - 1])) return false;
    for (int k = 0, step = 0; k < count; step++) {
        double largest, left = tau[count - 1] - time;
        if (step == RIC_SMOOTH_STEPS || ric_halt(ORDER * ORDER * (1.0 + m->n_contact)))
            return false;
        double reach = series_from(m, how, over, now, work, &largest),
               h = advance(m, n, m->n_contact, (const powers *)(const void *)work, largest,
                           fmin(reach, left), 1, series_of(m, work), now);
        if (!(h > 0 || left == 0)) return false;
        for (; k < count && tau[k] - time <= h; k++)
            state_sum(n, tau[k] - time, series_of(m, work), w + k * size);
        time += h;
        for (int i = 0; i < size; i++)
            if (!isfinite(now[i])) return false;
    }
    return true;
}

double ric_power_flow_pace(const ric_model *m, const double *w, double *work)
{
    double over[ORDER + 2], after[2 * m->n], size;
    recipe how[m->n_contact];
    plan(m, how);
    list_inverses(over);
    double reach = series_from(m, how, over, w, work, &size);
    return advance(m, m->n, m->n_contact, (const powers *)(const void *)work, size, reach, 1,
                   series_of(m, work), after);
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

static double largest(int count, const double *x)
{
    double top = 0;
    for (int i = 0; i < count; i++) top = larger(top, fabs(x[i]));
    return top;
}

static bool map(const ric_model *m, double tau, double *w, double *M, double *S, double *lost,
                double *work)
{
    int size = 2 * m->n;
    double start = largest(size, w);
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
    double *S = losses(m, work), w0[size], start = largest(size, w);
    memcpy(w0, w, sizeof w0);
    if (!map(m, tau, w, M, S, lost, work)) return false;
    if (*lost <= RIC_SMOOTH_LOSES * (1 + sqrt(ric_dot(size, w0, w0)))) return true;
    double unit = ric_power_flow_again(m, tau, w0, w, M, S);
    if (unit < 1) *lost = loss(size, start, unit, M, S);
    return true;
}
