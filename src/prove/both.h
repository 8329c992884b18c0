/* Motions that two impacts at one instant turn round together: p is along both normals, which are
 * orthogonal, so that the reflections commute and Q_f Q_g p = -p. Where a branch ends at them, with
 * a flight of no length, its own equations are singular; those of a chain that begins behind both
 * impacts are not, and the branch leaves by a motion beside the orbit that parts the two, to first
 * order (augmented.h, BREAK). */
#ifndef RIC_PROVE_BOTH_H
#define RIC_PROVE_BOTH_H

#include "chain.h"

enum { RIC_BOTH_WAYS = 4 };

/* The chain from behind the flight of no length `flight` of a general one, closed, to the next
 * mirror point, and which mirrors the branch lacks; to be freed in any case. There are several
 * ways: it has the period of the motions that keep both together, or twice that with the other
 * mirror point, or half of it with x -> -x. False: the contacts are springs, or not orthogonal, or
 * there is no such mirror point. */
bool ric_both_create(ric_chain *c, const ric_chain *general, const ric_enclosure *e, int flight,
                     int way, bool broken[2]);
/* Rows of B [.. * 2n] from `row` on: n - 2 that are zero on what is along both normals, of q, or of
 * p. */
void ric_both_across(const ric_enclosure *e, const ric_chain *c, bool speed, slong row,
                     arb_mat_t B);
/* The n conditions at the beginning, as rows on (q, p): the first one equals `gap`, others zero. */
void ric_both_mirror(const ric_enclosure *e, const ric_chain *c, arb_mat_t B, arb_t gap);

#endif
