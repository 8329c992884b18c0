/* Products and traces of maps of the return, in lines. */
#include <math.h>
#include <string.h>

#include "base/room.h"
#include "monodromy_quick.h"

/* ------------------------------------------------------------------ products */

/* A matrix in rows of m, g, |m| + g, and g / 2 and r without signs. */
enum { MIDDLE, SLOPE, SIZE, HALF, RADIUS, PARTS };

static void split_row(int n, const ric_line *from, double *to)
{
    for (int j = 0; j < n; j++) {
        to[MIDDLE * n + j] = from[j].m;
        to[SLOPE * n + j] = from[j].g;
        to[SIZE * n + j] = ric_line_size(from[j]);
        to[HALF * n + j] = fabs(from[j].g) / 2;
        to[RADIUS * n + j] = from[j].r;
    }
}

/* Row i of A B as sums of what ric_line_mul has: middles, slopes, sizes and radii. */
static void multiply_row(int n, const ric_line *a, const double *B, double *restrict sum)
{
    double *slope = sum + n, *size = sum + 2 * n, *radius = sum + 3 * n;
    memset(sum, 0, 4 * (size_t)n * sizeof *sum);
    for (int k = 0; k < n; k++) {
        const double m = a[k].m, g = a[k].g, half = g / 2, most = ric_line_size(a[k]), r = a[k].r;
        const double *middle = B + PARTS * k * n, *along = middle + SLOPE * n,
                     *mean = middle + SIZE * n, *bend = middle + HALF * n,
                     *wide = middle + RADIUS * n;
        for (int j = 0; j < n; j++) {
            sum[j] += m * middle[j] + half * along[j];
            slope[j] += m * along[j] + g * middle[j];
            size[j] += most * mean[j];
            radius[j] += most * wide[j] + r * (mean[j] + wide[j]) + fabs(g) * bend[j];
        }
    }
}

bool ric_monodromy_product(int n, const ric_line *A, const ric_line *B, ric_line *out)
{
    const double more = (double)(4 * n + 8) * 2 * RIC_BALL_UNIT;
    double *b = flint_malloc((size_t)(PARTS * n * n + 4 * n) * sizeof *b), *sum = b + PARTS * n * n;
    bool finite = true;
    for (int k = 0; k < n; k++) split_row(n, B + k * n, b + PARTS * k * n);
    for (int i = 0; i < n; i++) {
        multiply_row(n, A + i * n, b, sum);
        for (int j = 0; j < n; j++) {
            const double r = ric_up((sum[3 * n + j] + sum[2 * n + j] * more) * (1 + more) +
                                    n * 0x1p-1000);
            finite = finite && isfinite(sum[j]) && isfinite(sum[n + j]) && isfinite(r);
            out[i * n + j] = (ric_line){sum[j], sum[n + j], r};
        }
    }
    flint_free(b);
    return finite;
}

/* ------------------------------------------------------------------- traces */

static ric_line trace(int n, const ric_line *P)
{
    ric_line sum = {0, 0, 0};
    for (int i = 0; i < n; i++) sum = ric_line_add(sum, P[i * n + i]);
    return sum;
}

/* Of P Q, which is not needed for that. */
static ric_line trace_product(int n, const ric_line *P, const ric_line *Q)
{
    ric_line sum = {0, 0, 0};
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            sum = ric_line_add(sum, ric_line_mul(P[i * n + j], Q[j * n + i]));
    return sum;
}

static ric_line less_two(ric_line x)
{
    return ric_line_sub(x, ric_line_exact(2));
}

bool ric_monodromy_leaves(int n, const ric_line *H, int squarings)
{
    const size_t size = (size_t)(n * n) * sizeof *H;
    ric_line *P = flint_malloc(size), *square = flint_malloc(size);
    bool outside = false, finite = true;
    memcpy(P, H, size);
    for (int k = 0; k <= squarings && finite && !outside; k++) {
        if (k > 1) {
            finite = ric_monodromy_product(n, P, P, square);
            memcpy(P, square, size);
        }
        const ric_ball x = ric_line_whole(less_two(k > 0 ? trace_product(n, P, P) : trace(n, P)));
        outside = finite && ric_down(fabs(x.m) - x.r) > ric_up(n - 2);
    }
    flint_free(P);
    flint_free(square);
    return outside;
}

void ric_monodromy_traces(int n, const ric_line *H, int d, ric_line *sum)
{
    const int powers = (d + 1) / 2, count = n * n;
    ric_line *P = flint_calloc((size_t)(powers * count), sizeof *P);
    memcpy(P, H, (size_t)count * sizeof *P);
    for (int k = 1; k < powers; k++) {
        const bool finite = ric_monodromy_product(n, H, P + (k - 1) * count, P + k * count);
        for (int i = 0; i < count && !finite; i++) P[k * count + i].r = HUGE_VAL;
    }
    for (int k = 1; k <= d; k++) {
        const ric_line *first = P + ((k + 1) / 2 - 1) * count, *second = P + (k / 2 - 1) * count;
        sum[k - 1] = less_two(k == 1 ? trace(n, P) : trace_product(n, first, second));
    }
    flint_free(P);
}
