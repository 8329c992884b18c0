/* Multipliers of a proved orbit, from the derivative of its return in balls (docs/theory.md section
 * 5). */
#ifndef RIC_PROVE_MONODROMY_H
#define RIC_PROVE_MONODROMY_H

#include "monodromy_quick.h"

typedef struct {
    arb_t trace;          /* lambda + 1 / lambda, n = 2 */
    ric_stability stable; /* as proved */
    ric_line along;       /* trace of the map of the return, less 2, along a line, of n = 2: NAN */
} ric_monodromy;

void ric_monodromy_init(ric_monodromy *m);
void ric_monodromy_clear(ric_monodromy *m);
/* H [2n * 2n], the map of the return, over half of the period and turned round for a symmetric
 * orbit. */
void ric_monodromy_map(const ric_chain *c, const ric_enclosure *e, arb_srcptr u, arb_mat_t H);
/* u: balls that hold the orbit, whose impacts approach. */
void ric_monodromy_enclose(ric_monodromy *m, const ric_chain *c, const ric_enclosure *e,
                           arb_srcptr u);
/* `stable` alone, of all orbits along a line: in doubles, where roundings are nothing beside it. */
void ric_monodromy_judge(ric_monodromy *m, const ric_chain *c, const ric_enclosure *e,
                         const ric_monodromy_line *u);

#endif
