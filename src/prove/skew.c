#include "skew.h"

#include <math.h>
#include <string.h>

#include "base/room.h"

enum { POWER = 4 }; /* steps that turn a vector into the longest direction of C */

void ric_skew_create(ric_skew *s, slong n)
{
    *s = (ric_skew){.n = n};
}

void ric_skew_free(ric_skew *s)
{
    for (int d = 0; d < s->count; d++) flint_free(s->r[d]);
    s->count = 0;
}

/* Without what the basis has already, and of largest number 1, which is x[at]. */
static bool normalise(const ric_skew *s, double *x, slong *at)
{
    double most = 0;
    for (int d = 0; d < s->count; d++) x[s->at[d]] = 0;
    for (slong i = 0; i < s->n; i++) {
        if (fabs(x[i]) > most) *at = i;
        most = fmax(most, fabs(x[i]));
    }
    if (!(most > 0) || !isfinite(most)) return false;
    const double largest = x[*at];
    for (slong i = 0; i < s->n; i++) x[i] /= largest;
    return isfinite(x[0]);
}

/* x <- C C' x */
static void multiply(const ric_contraction *k, double *x, double *spare)
{
    const slong n = k->n;
    memset(spare, 0, (size_t)n * sizeof *spare);
    for (slong j = 0; j < n; j++) {
        const double *column = k->C + j * n;
        double sum = 0;
        for (slong i = 0; i < n; i++) sum += column[i] * x[i];
        for (slong i = 0; i < n; i++) spare[i] += column[i] * sum;
    }
    memcpy(x, spare, (size_t)n * sizeof *x);
}

static void turn_inverse(ric_contraction *k, slong at, const double *r)
{
    const slong n = k->n;
    for (slong j = 0; j < n; j++) {
        double *column = k->C + j * n, x = column[at];
        for (slong i = 0; i < n; i++)
            if (i != at) column[i] -= r[i] * x;
    }
}

bool ric_skew_find(ric_skew *s, ric_contraction *k)
{
    const slong n = s->n;
    if (s->count == RIC_SKEW_MOST || k->wide) return false;
    double *x = flint_malloc((size_t)n * sizeof *x), *spare = flint_malloc((size_t)n * sizeof *x);
    slong at = 0;
    for (slong i = 0; i < n; i++) x[i] = (double)(2 + i % 3);
    bool found = normalise(s, x, &at);
    for (int step = 0; step < POWER && found; step++) {
        multiply(k, x, spare);
        found = normalise(s, x, &at);
    }
    flint_free(spare);
    if (found) {
        s->at[s->count] = at;
        s->r[s->count++] = x;
        turn_inverse(k, at, x);
    } else flint_free(x);
    return found;
}

void ric_skew_columns(const ric_skew *s, arb_mat_t A, slong prec)
{
    arb_t x;
    arb_init(x);
    for (int d = 0; d < s->count; d++)
        for (slong i = 0; i < arb_mat_nrows(A); i++) {
            arb_ptr row = arb_mat_entry(A, i, 0), to = row + s->at[d];
            for (slong j = 0; j < s->n; j++) {
                if (j == s->at[d] || arb_is_zero(row + j)) continue;
                arb_set_d(x, s->r[d][j]);
                arb_addmul(to, row + j, x, prec);
            }
        }
    arb_clear(x);
}

void ric_skew_turn(const ric_skew *s, double *x)
{
    for (int d = s->count - 1; d >= 0; d--)
        for (slong i = 0, at = s->at[d]; i < s->n; i++)
            if (i != at) x[i] += s->r[d][i] * x[at];
}

/* What the size along direction d adds to those of the other numbers. */
static void add_direction(const ric_skew *s, int d, mag_ptr out)
{
    mag_t x;
    mag_init(x);
    for (slong i = 0; i < s->n; i++) {
        if (i == s->at[d]) continue;
        mag_set_d(x, s->r[d][i]);
        mag_addmul(out + i, x, out + s->at[d]);
    }
    mag_clear(x);
}

void ric_skew_spread(const ric_skew *s, mag_srcptr b, mag_ptr out)
{
    for (slong i = 0; i < s->n; i++) mag_set(out + i, b + i);
    for (int d = s->count - 1; d >= 0; d--) add_direction(s, d, out);
}

void ric_skew_enter(const ric_skew *s, mag_srcptr u, mag_ptr out)
{
    for (slong i = 0; i < s->n; i++) mag_set(out + i, u + i);
    for (int d = 0; d < s->count; d++) add_direction(s, d, out);
}

void ric_skew_direction(const ric_skew *s, int d, arb_ptr out)
{
    for (slong i = 0; i < s->n; i++) arb_set_d(out + i, s->r[d][i]);
}
