/* Multipliers of a proved orbit, from the derivative of its return in balls (docs/theory.md section
 * 5). */
#ifndef RIC_PROVE_MONODROMY_H
#define RIC_PROVE_MONODROMY_H

#include "chain.h"

typedef struct {
    arb_t trace;          /* lambda + 1 / lambda, n = 2 */
    ric_stability stable; /* as proved */
} ric_monodromy;

void ric_monodromy_init(ric_monodromy *m);
void ric_monodromy_clear(ric_monodromy *m);
/* u: balls that hold the orbit, whose impacts approach. */
void ric_monodromy_enclose(ric_monodromy *m, const ric_chain *c, const ric_enclosure *e,
                           arb_srcptr u);
/* `stable` alone, of the wide balls of an arc: in doubles, where roundings are nothing beside them.
 */
void ric_monodromy_judge(ric_monodromy *m, const ric_chain *c, const ric_enclosure *e,
                         arb_srcptr u);

#endif
