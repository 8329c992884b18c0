#include "arb_numbers.h"

#include <math.h>

void ric_arb_interval(const arb_t x, double out[2])
{
    arf_t bound;
    arf_init(bound);
    arb_get_lbound_arf(bound, x, 64);
    out[0] = arf_get_d(bound, ARF_RND_FLOOR);
    arb_get_ubound_arf(bound, x, 64);
    out[1] = arf_get_d(bound, ARF_RND_CEIL);
    arf_clear(bound);
}

bool ric_arb_normalise(arb_mat_t x, slong prec)
{
    double sum = 0;
    arb_t factor;
    for (slong i = 0; i < arb_mat_nrows(x); i++)
        sum += pow(ric_arb_middle(arb_mat_entry(x, i, 0)), 2);
    if (!(sum > 0) || !isfinite(sum)) return false;
    arb_init(factor);
    arb_set_d(factor, 1 / sqrt(sum));
    arb_mat_scalar_mul_arb(x, x, factor, prec);
    arb_mat_get_mid(x, x);
    arb_clear(factor);
    return true;
}
