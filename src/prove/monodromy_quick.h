#ifndef RIC_PROVE_MONODROMY_QUICK_H
#define RIC_PROVE_MONODROMY_QUICK_H

#include "chain.h"
#include "line.h"

/* Orbits along a line: those within the balls of `middle` + s `half`, -1 <= s <= 1, `half` exact or
 * nearly so; [m * size + 1] each. */
typedef struct {
    arb_srcptr middle, half;
} ric_monodromy_line;

/* H [2n * 2n], the map of the return of a chain as in monodromy.h; returns what roundings come to,
 * about, and HUGE_VAL where doubles do not hold it. */
double ric_monodromy_quick(const ric_chain *c, const ric_enclosure *e, const ric_monodromy_line *u,
                           ric_line *H);
/* Whether a multiplier of H [n * n] is off the unit circle, as its traces tell, or those of powers
 * up to 2^squarings. */
bool ric_monodromy_leaves(int n, const ric_line *H, int squarings);
/* sum [d]: what the traces of H [n * n], H^2, .. H^d have without the two multipliers that are 1.
 */
void ric_monodromy_traces(int n, const ric_line *H, int d, ric_line *sum);
/* out = A B, [n * n], out neither of them; false where doubles do not hold it. */
bool ric_monodromy_product(int n, const ric_line *A, const ric_line *B, ric_line *out);

#endif
