#ifndef RIC_PROVE_MONODROMY_QUICK_H
#define RIC_PROVE_MONODROMY_QUICK_H

#include "chain.h"

/* P [2n * 2n] along a chain without springs, from behind its first impact to before its last, as in
 * monodromy.h; returns what roundings come to, about. */
double ric_monodromy_quick(const ric_chain *c, const ric_enclosure *e, arb_srcptr u, arb_mat_t P);

/* 2 (c.q'') / ((c.c) (c.p-)) of an impact with the state w behind it (monodromy.c). */
void ric_monodromy_kick(const ric_enclosure *e, const ric_phase *phase, int face, arb_srcptr w,
                        arb_t out);
/* out = A B of square matrices, out neither of them; false where doubles do not hold it. */
bool ric_monodromy_product(arb_mat_t out, const arb_mat_t A, const arb_mat_t B);

#endif
