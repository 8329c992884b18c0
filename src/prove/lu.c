#include "lu.h"

#include <math.h>
#include <string.h>

#include "base/room.h"

void ric_lu_create(ric_lu *f, slong n)
{
    *f = (ric_lu){.n = n,
                  .a = flint_malloc((size_t)(n * n) * sizeof *f->a),
                  .order = flint_malloc((size_t)n * sizeof *f->order)};
}

void ric_lu_free(ric_lu *f)
{
    flint_free(f->a);
    flint_free(f->order);
}

/* x [n] -= y z. */
static void take(slong n, double *x, double y, const double *z)
{
    for (slong i = 0; i < n; i++) x[i] -= y * z[i];
}

static void swap_rows(ric_lu *f, slong i, slong j)
{
    const slong n = f->n, row = f->order[i];
    double *x = f->a + i * n, *y = f->a + j * n;
    f->order[i] = f->order[j];
    f->order[j] = row;
    for (slong l = 0; l < n; l++) {
        const double z = x[l];
        x[l] = y[l];
        y[l] = z;
    }
}

bool ric_lu_make(ric_lu *f, const arb_mat_t J)
{
    const slong n = f->n;
    double *a = f->a;
    for (slong i = 0; i < n; i++)
        for (slong j = 0; j < n; j++) {
            const bool zero = arb_is_zero(arb_mat_entry(J, i, j));
            a[i * n + j] = zero ? 0 : ric_arb_middle(arb_mat_entry(J, i, j));
        }
    for (slong i = 0; i < n; i++) f->order[i] = i;
    for (slong p = 0; p < n; p++) {
        slong best = p;
        for (slong i = p + 1; i < n; i++)
            if (fabs(a[i * n + p]) > fabs(a[best * n + p])) best = i;
        if (!(fabs(a[best * n + p]) > 0)) return false;
        if (best != p) swap_rows(f, p, best);
        for (slong i = p + 1; i < n; i++) {
            if (a[i * n + p] == 0) continue;
            const double share = a[i * n + p] /= a[p * n + p];
            take(n - p - 1, a + i * n + p + 1, share, a + p * n + p + 1);
        }
    }
    return true;
}

/* b [n * width] <- the inverse times it; above row `first` it is zero. */
static void solve_rows(const ric_lu *f, slong first, slong width, double *b)
{
    const slong n = f->n;
    for (slong i = first + 1; i < n; i++) {
        const double *row = f->a + i * n;
        for (slong p = first; p < i; p++)
            if (row[p] != 0) take(width, b + i * width, row[p], b + p * width);
    }
    for (slong i = n - 1; i >= 0; i--) {
        const double *row = f->a + i * n;
        for (slong p = n - 1; p > i; p--)
            if (row[p] != 0) take(width, b + i * width, row[p], b + p * width);
        for (slong j = 0; j < width; j++) b[i * width + j] /= row[i];
    }
}

void ric_lu_invert(const ric_lu *f, double *C)
{
    enum { WIDTH = 64 }; /* columns at a time, which stay in the cache while the factors pass by */
    const slong n = f->n;
    double *b = flint_malloc((size_t)(n * WIDTH) * sizeof *b);
    for (slong from = 0; from < n; from += WIDTH) {
        const slong width = n - from < WIDTH ? n - from : WIDTH;
        slong first = n;
        memset(b, 0, (size_t)(n * width) * sizeof *b);
        for (slong i = n - 1; i >= 0; i--) {
            if (f->order[i] < from || f->order[i] >= from + width) continue;
            b[i * width + f->order[i] - from] = 1;
            first = i;
        }
        solve_rows(f, first, width, b);
        for (slong i = 0; i < n; i++)
            for (slong j = 0; j < width; j++) C[(from + j) * n + i] = b[i * width + j];
    }
    flint_free(b);
}

void ric_lu_solve(const ric_lu *f, const double *x, double *out)
{
    for (slong i = 0; i < f->n; i++) out[i] = x[f->order[i]];
    solve_rows(f, 0, 1, out);
}
