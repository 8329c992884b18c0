#include "contraction.h"

#include "base/room.h"

void ric_contraction_create(ric_contraction *k, slong n, slong prec)
{
    *k = (ric_contraction){.n = n, .prec = prec};
    arb_mat_init(k->C, n, n);
    k->Z = _mag_vec_init(n * n);
    k->y = _mag_vec_init(n);
    k->b = _mag_vec_init(n);
}

void ric_contraction_free(ric_contraction *k)
{
    if (!k->Z) return;
    arb_mat_clear(k->C);
    _mag_vec_clear(k->Z, k->n * k->n);
    _mag_vec_clear(k->y, k->n);
    _mag_vec_clear(k->b, k->n);
    k->Z = NULL;
}

bool ric_contraction_invert(ric_contraction *k, const arb_mat_t J)
{
    arb_mat_t mid;
    arb_mat_init(mid, k->n, k->n);
    arb_mat_get_mid(mid, J);
    const bool done = arb_mat_approx_inv(k->C, mid, k->prec);
    arb_mat_get_mid(k->C, k->C);
    arb_mat_clear(mid);
    return done;
}

void ric_contraction_apply(const ric_contraction *k, arb_srcptr x, arb_ptr out)
{
    for (slong i = 0; i < k->n; i++)
        arb_dot(out + i, NULL, 0, arb_mat_entry(k->C, i, 0), 1, x, 1, k->n, k->prec);
}

/* A column of J has few numbers that are not zero: those are gathered, as they are, without a copy
 * of their own. */
void ric_contraction_defect(ric_contraction *k, const arb_mat_t J)
{
    const slong n = k->n;
    arb_ptr column = flint_malloc((size_t)n * sizeof *column),
            row = flint_malloc((size_t)n * sizeof *row);
    slong *at = flint_malloc((size_t)n * sizeof *at);
    arb_t x;
    arb_init(x);
    for (slong j = 0; j < n; j++) {
        slong count = 0;
        for (slong i = 0; i < n; i++) {
            if (arb_is_zero(arb_mat_entry(J, i, j))) continue;
            column[count] = *arb_mat_entry(J, i, j);
            at[count++] = i;
        }
        for (slong i = 0; i < n; i++) {
            for (slong l = 0; l < count; l++) row[l] = *arb_mat_entry(k->C, i, at[l]);
            arb_dot(x, NULL, 0, row, 1, column, 1, count, k->prec);
            if (i == j) arb_sub_ui(x, x, 1, k->prec);
            arb_get_mag(k->Z + i * n + j, x);
        }
    }
    arb_clear(x);
    flint_free(column);
    flint_free(row);
    flint_free(at);
}

/* out = (Z x)_i */
static void defect_row(const ric_contraction *k, slong i, mag_srcptr x, mag_t out)
{
    mag_zero(out);
    for (slong j = 0; j < k->n; j++) mag_addmul(out, k->Z + i * k->n + j, x + j);
}

bool ric_contraction_holds(ric_contraction *k)
{
    mag_ptr next = _mag_vec_init(k->n);
    mag_t eighth;
    mag_init(eighth);
    bool holds = true;
    for (slong i = 0; i < k->n; i++) {
        defect_row(k, i, k->b, next + i);
        mag_add(next + i, next + i, k->y + i);
        holds = holds &&
                mag_cmp(next + i, k->b + i) < 0; /* what is no number is infinite, and not less */
    }
    for (slong i = 0; i < k->n && !holds; i++) {
        if (mag_cmp(next + i, k->b + i) < 0)
            continue; /* large enough; a number that never changes has a next of 0 */
        mag_mul_2exp_si(eighth, next + i, -3);
        mag_add(k->b + i, next + i, eighth);
    }
    _mag_vec_clear(next, k->n);
    mag_clear(eighth);
    return holds;
}
