#include "border.h"

#include <stdlib.h>
#include <string.h>

#include <lapacke.h>

#include "base/room.h"

ric_border *ric_border_create(const ric_shooting *chain)
{
    ric_border *q = ric_calloc(1, sizeof *q);
    if (!q) return NULL;
    q->chain = chain;
    q->n = chain->n;
    q->N = chain->n_flight;
    q->unknowns = 2 * q->n + q->N;
    size_t N = (size_t)q->N, states = 2 * (size_t)q->n, unknowns = (size_t)q->unknowns;
    q->map = ric_calloc(N * chain->stride + 1, sizeof *q->map);
    q->rate = ric_calloc(N * states, sizeof *q->rate);
    q->v = ric_calloc(N * states, sizeof *q->v);
    q->beta = ric_calloc(N, sizeof *q->beta);
    q->pivot = ric_calloc(N, sizeof *q->pivot);
    q->row = ric_calloc(N * states, sizeof *q->row);
    q->pinned = ric_calloc(N * states, sizeof *q->pinned);
    q->X = ric_calloc(states * states, sizeof *q->X);
    q->K = ric_calloc(unknowns * states, sizeof *q->K);
    q->S = ric_calloc(states * states, sizeof *q->S);
    q->left = ric_calloc(states * states, sizeof *q->left);
    q->right = ric_calloc(states * states, sizeof *q->right);
    q->sigma = ric_calloc(states, sizeof *q->sigma);
    q->small = ric_calloc(4 * states * states, sizeof *q->small);
    q->swap = ric_calloc(2 * states, sizeof *q->swap);
    q->U = ric_calloc(states * states, sizeof *q->U);
    q->V = ric_calloc(unknowns * states, sizeof *q->V);
    if (q->map && q->rate && q->v && q->beta && q->pivot && q->row && q->pinned && q->X && q->K &&
        q->S && q->left && q->right && q->sigma && q->small && q->swap && q->U && q->V)
        return q;
    ric_border_free(q);
    return NULL;
}

void ric_border_free(ric_border *q)
{
    if (!q) return;
    free(q->map);
    free(q->rate);
    free(q->v);
    free(q->beta);
    free(q->pivot);
    free(q->row);
    free(q->pinned);
    free(q->X);
    free(q->K);
    free(q->S);
    free(q->left);
    free(q->right);
    free(q->sigma);
    free(q->small);
    free(q->swap);
    free(q->U);
    free(q->V);
    free(q);
}

/* The code of one flight is written once and used twice, with its sizes known to the compiler for
 * two modes. */
#define INLINE static inline __attribute__((always_inline))

/* ------------------------------------------------------------------ flights */

/* Moves the n * n entries of a block of a matrix [2n * 2n] by the rounding of its largest. */
static void move_block(int n, double rounding, unsigned *bits, double *block)
{
    double largest = 0;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) largest = fmax(largest, fabs(block[i * 2 * n + j]));
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) block[i * 2 * n + j] += ric_moved(bits, rounding * largest);
}

/* Displacements and velocities differ by the frequency of a spring: each block of a matrix has its
 * own rounding. */
static void move_flight(ric_border *q, int k, double rounding, unsigned *bits)
{
    const ric_shooting *c = q->chain;
    int n = q->n;
    double *map = q->map + c->stride * (size_t)k, *rate = q->rate + 2 * n * k;
    if (ric_flight_dense(c->model, c->closed[k]))
        for (int block = 0; block < 4; block++)
            move_block(n, rounding, bits, map + (block / 2) * n * 2 * n + (block % 2) * n);
    else
        for (int i = 0; i < 3 * n; i++) map[i] += ric_moved(bits, rounding * fmax(1, fabs(map[i])));
    for (int i = 0; i < 2 * n; i++) rate[i] += ric_moved(bits, rounding * fabs(rate[i]));
}

static void take_flights(ric_border *q, double rounding, unsigned bits)
{
    const ric_shooting *c = q->chain;
    int n = q->n;
    double end[2 * n];
    q->size = sqrt(ric_dot(2 * n, c->w, c->w));
    q->T = 0;
    for (int k = 0; k < q->N; k++) {
        double *rate = q->rate + 2 * n * k;
        q->T += c->tau[k];
        memcpy(end, c->w + 2 * n * (k + 1), sizeof end);
        memcpy(end + n, c->before + n * k, (size_t)n * sizeof *end); /* the impact comes after */
        if (ric_flight_dense(c->model, c->closed[k])) memcpy(rate, c->rate + 2 * n * k, sizeof end);
        else ric_flow(c->model, n, end, rate);
        for (int i = 0; i < 2 * n; i++) rate[i] /= q->size;
    }
    memcpy(q->map, c->map, (size_t)q->N * c->stride * sizeof *q->map);
    for (int k = 0; k < q->N && rounding > 0; k++) move_flight(q, k, rounding, &bits);
}

/* Columns of X [2n * ld], the first `columns`, through flight k, up to the event. */
INLINE void fly_columns(ric_border *q, int n, int k, int columns, int ld, double *X)
{
    const ric_shooting *c = q->chain;
    const double *map = q->map + c->stride * (size_t)k;
    bool dense = ric_flight_dense(c->model, c->closed[k]);
    q->operations += (dense ? 4 * n * n : 4 * n) * (long)columns;
    if (dense) {
        ric_flight_carry(n, map, columns, ld, X);
        return;
    }
    for (int i = 0; i < n; i++)
        for (int j = 0; j < columns; j++) {
            double a = X[i * ld + j], p = X[(n + i) * ld + j];
            X[i * ld + j] = map[i] * a + map[n + i] * p;
            X[(n + i) * ld + j] = map[i] * p - map[2 * n + i] * a;
        }
}

/* What the event at the end of flight k does to columns. */
INLINE void strike_columns(ric_border *q, int n, int k, int columns, int ld, double *X)
{
    const ric_shooting *c = q->chain;
    const ric_face *face = c->face[k + 1] >= 0 ? &c->model->face[c->face[k + 1]] : NULL;
    if (!face || face->spring > 0) return;
    q->operations += 2 * n * (long)columns;
    for (int j = 0; j < columns; j++) {
        double sum = 0;
        for (int i = 0; i < n; i++) sum += face->c[i] * X[(n + i) * ld + j];
        for (int i = 0; i < n; i++) X[(n + i) * ld + j] -= 2 / face->cc * sum * face->c[i];
    }
}

/* The row of condition k on the state there, h [2n]: a gap, or the phase. */
static void condition(const ric_border *q, int k, double *h)
{
    const ric_shooting *c = q->chain;
    int n = q->n;
    if (c->face[k] >= 0) {
        memcpy(h, c->model->face[c->face[k]].g, (size_t)n * sizeof *h);
        memset(h + n, 0, (size_t)n * sizeof *h);
        return;
    }
    ric_flight_rate(c->model, c->closed[k], c->w + 2 * n * k, h);
    double norm = sqrt(ric_dot(2 * n, h, h));
    for (int i = 0; i < 2 * n; i++) h[i] /= norm;
}

/* ------------------------------------------------------------ factorisation */

INLINE double dot(int m, const double *x, const double *y)
{
    double sum = 0;
    for (int i = 0; i < m; i++) sum += x[i] * y[i];
    return sum;
}

/* One reflection makes the row of condition k (0, .., 0, pivot): the last of the 2n columns is
 * pinned, and kept. */
INLINE bool pin(ric_border *q, int m, int k)
{
    double row[m], *v = q->v + (size_t)k * (size_t)m, *h = q->row + (size_t)k * (size_t)m,
                   *X = q->X, sum = 0;
    condition(q, k, h);
    for (int j = 0; j < m; j++) {
        row[j] = 0;
        for (int i = 0; i < m; i++) row[j] += h[i] * X[i * m + j];
        sum += row[j] * row[j];
    }
    double norm = sqrt(sum), last = row[m - 1], pivot = last > 0 ? -norm : norm;
    if (!(norm > 0 && norm < HUGE_VAL)) return false;
    memcpy(v, row, sizeof row);
    v[m - 1] -= pivot;
    q->beta[k] = 1 / (norm * (norm + fabs(last)));
    q->pivot[k] = pivot;
    for (int i = 0; i < m; i++) {
        double s = q->beta[k] * dot(m, X + i * m, v);
        for (int j = 0; j < m; j++) X[i * m + j] -= s * v[j];
        q->pinned[(size_t)k * (size_t)m + (size_t)i] = X[i * m + m - 1];
    }
    q->operations += 3L * m * m;
    return true;
}

/* From the combinations z [2n * count] that are left (NULL: 0), and the values of the pinned ones
 * (NULL: 0), back to the unknowns y [unknowns * count] = (w_0 / size, tau). Columns go side by
 * side: each of them waits for one product after the other. */
INLINE void lift_to(ric_border *q, int m, int count, const double *last, const double *pinned,
                    double *y)
{
    double z[m * count], s[count];
    for (int i = 0; i < m * count; i++) z[i] = last ? last[i] : 0;
    for (int k = q->N - 1; k >= 0; k--) {
        const double *v = q->v + (size_t)k * (size_t)m;
        for (int c = 0; c < count; c++) {
            y[(m + k) * count + c] = z[(m - 1) * count + c];
            z[(m - 1) * count + c] = pinned ? pinned[k * count + c] : 0;
            s[c] = 0;
        }
        for (int j = 0; j < m; j++)
            for (int c = 0; c < count; c++) s[c] += v[j] * z[j * count + c];
        for (int c = 0; c < count; c++) s[c] *= q->beta[k];
        for (int j = 0; j < m; j++)
            for (int c = 0; c < count; c++) z[j * count + c] -= s[c] * v[j];
    }
    memcpy(y, z, sizeof z);
    q->operations += 2L * m * q->N * count;
}

static void lift(ric_border *q, int count, const double *last, const double *pinned, double *y)
{
    const int m = 2 * q->n;
    switch (m == 4 ? count : 0) {
    case 1: lift_to(q, 4, 1, last, pinned, y); break;
    case 2: lift_to(q, 4, 2, last, pinned, y); break;
    case 3: lift_to(q, 4, 3, last, pinned, y); break;
    case 4: lift_to(q, 4, 4, last, pinned, y); break;
    default: lift_to(q, m, count, last, pinned, y);
    }
}

static void lift_all(ric_border *q)
{
    const int m = 2 * q->n;
    double unit[m * m];
    for (int i = 0; i < m * m; i++) unit[i] = i % (m + 1) == 0;
    lift(q, m, unit, NULL, q->K);
}

INLINE bool eliminate(ric_border *q, int m)
{
    memset(q->X, 0, (size_t)m * (size_t)m * sizeof *q->X);
    for (int i = 0; i < m; i++) q->X[i * m + i] = 1;
    for (int k = 0; k < q->N; k++) {
        if (!pin(q, m, k)) return false;
        fly_columns(q, m / 2, k, m - 1, m, q->X);
        for (int i = 0; i < m; i++)
            q->X[i * m + m - 1] = q->rate[(size_t)k * (size_t)m + (size_t)i];
        strike_columns(q, m / 2, k, m, m, q->X);
    }
    return true;
}

bool ric_border_factor(ric_border *q, double rounding, unsigned bits)
{
    int m = 2 * q->n;
    take_flights(q, rounding, bits);
    if (!(m == 4 ? eliminate(q, 4) : eliminate(q, m))) return false;
    lift_all(q);
    for (int i = 0; i < m * m; i++) {
        q->S[i] = q->X[i] - q->K[i]; /* the first rows of K are those of w_0 */
        if (!isfinite(q->S[i])) return false;
    }
    return true;
}

static bool decompose(ric_border *q, char vectors)
{
    int m = 2 * q->n;
    double super[m];
    memcpy(q->X, q->S, (size_t)m * (size_t)m * sizeof *q->X);
    return !ric_lapack(LAPACKE_dgesvd(LAPACK_ROW_MAJOR, vectors, vectors, m, m, q->X, m, q->sigma,
                                      q->left, m, q->right, m, super));
}

bool ric_border_values(ric_border *q)
{
    return decompose(q, 'N');
}

void ric_border_kernel(const ric_border *q, int i, double *du)
{
    int m = 2 * q->n;
    const double *z = q->right + (m - 1 - i) * m;
    for (int j = 0; j < q->unknowns; j++)
        du[j] = ric_dot(m, q->K + (size_t)j * (size_t)m, z) * (j < m ? q->size : 1);
}

/* ------------------------------------------------------------------- borders */

static bool own_border(ric_border *q, int b)
{
    int m = 2 * q->n;
    if (!decompose(q, 'A')) return false;
    for (int i = 0; i < b; i++) {
        const double *z = q->right + (m - 1 - i) * m;
        for (int r = 0; r < m; r++) q->U[r * b + i] = q->left[r * m + m - 1 - i];
        for (int j = 0; j < q->unknowns; j++)
            q->V[(size_t)j * (size_t)b + (size_t)i] = ric_dot(m, q->K + (size_t)j * (size_t)m, z);
    }
    return true;
}

/* A [size * size], of some rows, becomes its factors, rows exchanged as `swap` says. False: it is
 * singular. */
static bool factor_small(int size, double *A, int *swap)
{
    for (int k = 0; k < size; k++) {
        int best = k;
        for (int i = k + 1; i < size; i++)
            if (fabs(A[i * size + k]) > fabs(A[best * size + k])) best = i;
        swap[k] = best;
        if (!(fabs(A[best * size + k]) > 0)) return false;
        for (int j = 0; j < size && best != k; j++) {
            double kept = A[k * size + j];
            A[k * size + j] = A[best * size + j];
            A[best * size + j] = kept;
        }
        for (int i = k + 1; i < size; i++) {
            double by = A[i * size + k] /= A[k * size + k];
            for (int j = k + 1; j < size; j++) A[i * size + j] -= by * A[k * size + j];
        }
    }
    return true;
}

/* x [size * count]. */
static void solve_small(int size, int count, const double *A, const int *swap, double *x)
{
    for (int c = 0; c < count; c++, x++) {
        for (int k = 0; k < size; k++) {
            double kept = x[k * count];
            x[k * count] = x[swap[k] * count];
            x[swap[k] * count] = kept;
        }
        for (int i = 1; i < size; i++)
            for (int j = 0; j < i; j++) x[i * count] -= A[i * size + j] * x[j * count];
        for (int i = size - 1; i >= 0; i--) {
            for (int j = i + 1; j < size; j++) x[i * count] -= A[i * size + j] * x[j * count];
            x[i * count] /= A[i * size + i];
        }
    }
}

bool ric_border_set(ric_border *q, const ric_border *frame, int b)
{
    int m = 2 * q->n, size = m + b;
    q->b = b;
    if (frame == q) {
        if (!own_border(q, b)) return false;
    } else {
        memcpy(q->U, frame->U, (size_t)(m * b) * sizeof *q->U);
        memcpy(q->V, frame->V, (size_t)q->unknowns * (size_t)b * sizeof *q->V);
    }
    memset(q->small, 0, (size_t)size * (size_t)size * sizeof *q->small);
    for (int r = 0; r < m; r++) {
        memcpy(q->small + r * size, q->S + r * m, (size_t)m * sizeof *q->S);
        for (int i = 0; i < b; i++) q->small[r * size + m + i] = q->U[r * b + i];
    }
    for (int j = 0; j < q->unknowns; j++)
        for (int i = 0; i < b; i++)
            for (int l = 0; l < m; l++)
                q->small[(m + i) * size + l] += q->V[(size_t)j * (size_t)b + (size_t)i] *
                                                q->K[(size_t)j * (size_t)m + (size_t)l];
    return factor_small(size, q->small, q->swap);
}

/* The values of the pinned combinations, and what they make of the state at the end, out [2n *
 * count]. */
INLINE void forward_to(ric_border *q, int m, int count, const double *conditions, double *pinned,
                       double *out)
{
    memset(out, 0, (size_t)(m * count) * sizeof *out);
    for (int k = 0; k < q->N; k++) {
        const double *along = q->pinned + (size_t)k * (size_t)m,
                     *row = q->row + (size_t)k * (size_t)m;
        double *to = pinned + k * count, sum[count];
        for (int c = 0; c < count; c++) sum[c] = 0;
        for (int i = 0; i < m; i++)
            for (int c = 0; c < count; c++) sum[c] += row[i] * out[i * count + c];
        for (int c = 0; c < count; c++)
            to[c] = (conditions[k * count + c] / q->size - sum[c]) / q->pivot[k];
        for (int i = 0; i < m; i++)
            for (int c = 0; c < count; c++) out[i * count + c] += along[i] * to[c];
        fly_columns(q, m / 2, k, count, count, out);
        strike_columns(q, m / 2, k, count, count, out);
        q->operations += 2L * m * count;
    }
}

static void forward(ric_border *q, int count, const double *conditions, double *pinned, double *out)
{
    const int m = 2 * q->n;
    switch (m == 4 ? count : 0) {
    case 1: forward_to(q, 4, 1, conditions, pinned, out); break;
    case 2: forward_to(q, 4, 2, conditions, pinned, out); break;
    case 3: forward_to(q, 4, 3, conditions, pinned, out); break;
    default: forward_to(q, m, count, conditions, pinned, out);
    }
}

static bool all_zero(int n, const double *x)
{
    for (int i = 0; i < n; i++)
        if (x[i] != 0) return false;
    return true;
}

/* From (w_0 / size, tau) [unknowns * count] to the unknowns of J. */
static void to_fractions(const ric_border *q, int count, const double *r, double *x)
{
    const int m = 2 * q->n, N = q->N;
    for (int c = 0; c < count; c++) {
        double total = 0;
        for (int k = 0; k < N; k++) total += x[(m + k) * count + c];
        const double dT = total - q->T * r[q->unknowns * count + c];
        x[q->unknowns * count + c] = dT;
        for (int k = 0; k < N; k++) {
            double *tau = &x[(m + k) * count + c];
            *tau = (*tau - q->chain->tau[k] / q->T * dT) / q->T;
        }
        for (int i = 0; i < m; i++) x[i * count + c] *= q->size;
    }
}

void ric_border_solve(ric_border *q, int count, const double *r, const double *s, double *x,
                      double *g)
{
    const int m = 2 * q->n, N = q->N, b = q->b, size = m + b;
    double pinned[N * count], end[m * count], rhs[size * count], y[q->unknowns * count];
    if (all_zero(N * count, r + m * count)) { /* the first of a series of solves */
        memset(end, 0, sizeof end);
        memset(y, 0, sizeof y);
    } else {
        forward(q, count, r + m * count, pinned, end);
        lift(q, count, NULL, pinned, y);
    }
    for (int i = 0; i < m * count; i++) rhs[i] = r[i] / q->size - end[i] + y[i];
    memcpy(rhs + m * count, s, (size_t)(b * count) * sizeof *rhs);
    for (int j = 0; j < q->unknowns; j++)
        for (int i = 0; i < b; i++)
            for (int c = 0; c < count; c++)
                rhs[(m + i) * count + c] -= q->V[(size_t)j * (size_t)b + (size_t)i] *
                                            y[j * count + c];
    solve_small(size, count, q->small, q->swap, rhs);
    memcpy(g, rhs + m * count, (size_t)(b * count) * sizeof *g);
    if (!x) return;
    memcpy(x, y, sizeof y);
    for (int j = 0; j < q->unknowns; j++)
        for (int l = 0; l < m; l++)
            for (int c = 0; c < count; c++)
                x[j * count + c] += q->K[(size_t)j * (size_t)m + (size_t)l] * rhs[l * count + c];
    to_fractions(q, count, r, x);
}

void ric_border_conditions(ric_border *q, int count, const double *r, double *start, double *end)
{
    const int m = 2 * q->n;
    double pinned[q->N * count], y[q->unknowns * count];
    forward(q, count, r, pinned, end);
    lift(q, count, NULL, pinned, y);
    memcpy(start, y, (size_t)(m * count) * sizeof *start);
}
