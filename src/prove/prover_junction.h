/* A junction on one of its branches: between its ends, or at one of them. */
#ifndef RIC_PROVE_PROVER_JUNCTION_H
#define RIC_PROVE_PROVER_JUNCTION_H

#include "atlas/room.h"
#include "augmented.h"
#include "story.h"
#include "walk.h"

/* Speed, over 1 + that of the motion, of impacts beside a touch that may be stored as touches: each
 * may be as slow as the square of the next one. */
#define RIC_PROVER_SLOW 1e-6

/* At an arclength of a branch, and at one of its ends where it grazes. Where out->state is
 * RIC_PROOF_DONE then `x` is the proof; it is 0 or another one before, and to be freed in any case.
 * So is `chord`, the orbit there on the chord of two stored points, from which the proof began. */
ric_status ric_prover_junction_inside(ric_walk *w, const ric_junction *row, double at,
                                      ric_augmented *x, ric_chain *chord, ric_junction_proof *out);
ric_status ric_prover_junction_end(ric_walk *w, const ric_junction *row, bool last,
                                   ric_augmented *x, ric_junction_proof *out);

/* On one of its branches, those with the longest words first: there all touches are impacts. */
ric_status ric_prover_junction_find(ric_prover *p, const ric_junction *row, int level,
                                    ric_augmented *x, ric_junction_proof *out);
/* Whether equations for it are asked on a branch: those of a multiplication on the one that is
 * multiplied. */
bool ric_prover_junction_asked(const ric_junction *row, const ric_branch *branch);
/* A whole period of what was proved, as the junction has it: that of a grazing that is gone through
 * several times holds it as often. To be freed. */
void ric_prover_junction_tell(const ric_augmented *x, ric_story *out);

#endif
