#ifndef RIC_PROVE_MONODROMY_QUICK_H
#define RIC_PROVE_MONODROMY_QUICK_H

#include "ball.h"
#include "chain.h"

/* H [2n * 2n], the map of the return of a chain without springs as in monodromy.h; returns what
 * roundings come to, about, and HUGE_VAL where doubles do not hold it. */
double ric_monodromy_quick(const ric_chain *c, const ric_enclosure *e, arb_srcptr u, ric_ball *H);
/* Whether a multiplier of H [n * n] is off the unit circle, as its traces tell, or those of powers
 * up to 2^squarings. */
bool ric_monodromy_leaves(int n, const ric_ball *H, int squarings);
/* out = A B, [n * n], out neither of them; false where doubles do not hold it. */
bool ric_monodromy_product(int n, const ric_ball *A, const ric_ball *B, ric_ball *out);

/* 2 (c.q'') / ((c.c) (c.p-)) of an impact with the state w behind it (monodromy.c). */
void ric_monodromy_kick(const ric_enclosure *e, const ric_phase *phase, int face, arb_srcptr w,
                        arb_t out);
/* The state behind the last impact of a reversible chain (monodromy.c). */
void ric_monodromy_end(const ric_chain *c, const ric_enclosure *e, arb_srcptr u, arb_ptr out);

#endif
