#include "dense.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stddef.h>

#include "lane.h"

enum {
    TILE = 4,   /* rows and columns of A in registers */
    BLOCK = 32, /* columns that are eliminated before the others take them up */
};

/* L [rows * depth] and what its rows and columns are apart; U [depth * columns], A [rows * columns]
 * and what their rows are apart. */
typedef struct {
    int depth;
    const double *L;
    size_t row, column;
    const double *U;
    double *A;
    size_t u_row, a_row;
    bool add;
} update;

static inline __attribute__((always_inline)) void tile(const update *q, size_t i, size_t j,
                                                       bool add)
{
    ric_lane a[TILE][TILE / 2];
    for (int r = 0; r < TILE; r++)
        for (int s = 0; s < TILE / 2; s++)
            a[r][s] = ric_lane_load(q->A + (i + (size_t)r) * q->a_row + j + 2 * (size_t)s);
    const double *l = q->L + i * q->row, *u = q->U + j;
    for (int d = 0; d < q->depth; d++, l += q->column, u += q->u_row) {
        const ric_lane first = ric_lane_load(u), second = ric_lane_load(u + 2);
        for (size_t r = 0; r < TILE; r++) {
            const double one = l[r * q->row];
            const ric_lane both = {one, one};
            a[r][0] = add ? a[r][0] + both * first : a[r][0] - both * first;
            a[r][1] = add ? a[r][1] + both * second : a[r][1] - both * second;
        }
    }
    for (int r = 0; r < TILE; r++)
        for (int s = 0; s < TILE / 2; s++)
            ric_lane_store(q->A + (i + (size_t)r) * q->a_row + j + 2 * (size_t)s, a[r][s]);
}

static void single(const update *q, size_t i, size_t j)
{
    double a = q->A[i * q->a_row + j];
    const double *l = q->L + i * q->row, *u = q->U + j;
    for (int d = 0; d < q->depth; d++, l += q->column, u += q->u_row)
        a = q->add ? a + *l * *u : a - *l * *u;
    q->A[i * q->a_row + j] = a;
}

/* A = A -+ L U. */
static void take_up(const update *q, size_t rows, size_t columns)
{
    const size_t whole_rows = rows - rows % TILE, whole_columns = columns - columns % TILE;
    for (size_t i = 0; i < whole_rows; i += TILE)
        for (size_t j = 0; j < whole_columns; j += TILE)
            if (q->add) tile(q, i, j, true);
            else tile(q, i, j, false);
    for (size_t i = 0; i < rows; i++)
        for (size_t j = i < whole_rows ? whole_columns : 0; j < columns; j++) single(q, i, j);
}

void ric_dense_add_transposed(int m, const double *B, const double *C, double *A)
{
    const size_t k = (size_t)m;
    take_up(&(update){m, B, 1, k, C, A, k, k, true}, k, k);
}

static int exchange(size_t m, size_t i, size_t j, double *A)
{
    if (i == j) return 1;
    for (size_t c = 0; c < m; c++) {
        const double swap = A[i * m + c];
        A[i * m + c] = A[j * m + c];
        A[j * m + c] = swap;
    }
    return -1;
}

/* Columns first .. end - 1, which have taken up all before them. Returns the sign of the exchange.
 */
static int eliminate(size_t m, size_t first, size_t end, double *A)
{
    int sign = 1;
    for (size_t c = first; c < end; c++) {
        size_t best = c;
        for (size_t i = c + 1; i < m; i++)
            if (fabs(A[i * m + c]) > fabs(A[best * m + c])) best = i;
        sign *= exchange(m, c, best, A);
        const double pivot = A[c * m + c], inverse = 1 / pivot;
        for (size_t i = c + 1; i < m && pivot != 0; i++) {
            double *row = A + i * m;
            row[c] = fabs(pivot) >= DBL_MIN ? row[c] * inverse : row[c] / pivot;
            for (size_t j = c + 1; j < end; j++) row[j] -= row[c] * A[c * m + j];
        }
    }
    return sign;
}

int ric_dense_factor(int m, double *A)
{
    const size_t k = (size_t)m;
    int sign = 1;
    for (size_t first = 0; first < k; first += BLOCK) {
        const size_t end = first + BLOCK < k ? first + BLOCK : k;
        sign *= eliminate(k, first, end, A);
        for (size_t i = first + 1; i < end; i++)
            for (size_t l = first; l < i; l++)
                for (size_t j = end; j < k; j++) A[i * k + j] -= A[i * k + l] * A[l * k + j];
        if (end < k)
            take_up(&(update){(int)(end - first), A + end * k + first, k, 1, A + first * k + end,
                              A + end * k + end, k, k, false},
                    k - end, k - end);
    }
    return sign;
}

static void swap_rows(int m, double *a, double *b)
{
    for (int k = 0; k < m; k++) {
        double t = a[k];
        a[k] = b[k];
        b[k] = t;
    }
}

bool ric_dense_solve(int n, int m, double *A, double *B, double least)
{
    for (int j = 0; j < n; j++) {
        int best = j;
        for (int i = j + 1; i < n; i++)
            if (fabs(A[i * n + j]) > fabs(A[best * n + j])) best = i;
        if (!(fabs(A[best * n + j]) > least)) return false;
        if (best != j) {
            swap_rows(n - j, A + j * n + j, A + best * n + j);
            swap_rows(m, B + j * m, B + best * m);
        }
        for (int i = j + 1; i < n; i++) {
            double factor = A[i * n + j] / A[j * n + j];
            if (factor == 0) continue;
            for (int k = j + 1; k < n; k++) A[i * n + k] -= factor * A[j * n + k];
            for (int k = 0; k < m; k++) B[i * m + k] -= factor * B[j * m + k];
        }
    }
    for (int i = n - 1; i >= 0; i--)
        for (int c = 0; c < m; c++) {
            for (int k = i + 1; k < n; k++) B[i * m + c] -= A[i * n + k] * B[k * m + c];
            B[i * m + c] /= A[i * n + i];
        }
    return true;
}
