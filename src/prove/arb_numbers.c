#include "arb_numbers.h"

#include <math.h>

/* The first 64 bits, of which the last one stands for all that follow: a double has 53. A power of
 * two takes no bits away where the result is not subnormal. */
double ric_arb_nearest(const arf_t x)
{
    enum { NORMAL = 1000 };
    if (arf_is_special(x) || arf_cmpabs_2exp_si(x, NORMAL) >= 0 ||
        arf_cmpabs_2exp_si(x, -NORMAL) < 0)
        return arf_get_d(x, ARF_RND_NEAR);
    mp_srcptr limb;
    mp_size_t n;
    ARF_GET_MPN_READONLY(limb, n, x);
    mp_limb_t top = limb[n - 1];
    for (mp_size_t i = 0; i < n - 1; i++) top |= limb[i] != 0;
    const double size = ldexp((double)top, (int)(ARF_EXP(x) - FLINT_BITS));
    return ARF_SGNBIT(x) ? -size : size;
}

void ric_arb_clean(arb_mat_t A)
{
    for (slong i = 0; i < arb_mat_nrows(A); i++)
        for (slong j = 0; j < arb_mat_ncols(A); j++)
            if (!arb_is_zero(arb_mat_entry(A, i, j))) arb_zero(arb_mat_entry(A, i, j));
}

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
