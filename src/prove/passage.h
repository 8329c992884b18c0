/* That a zero of the equations is a motion: flights last, impacts approach, and no face is passed in between. */
#ifndef RIC_PROVE_PASSAGE_H
#define RIC_PROVE_PASSAGE_H

#include "chain.h"

typedef struct {
    bool done;
    char why[120];  /* where it is not */
    arb_t approach; /* a lower bound of the speed of every impact */
} ric_passage;

/* What holds an orbit, or all of an arc: the blocks of a chain [m * size]. Of an arc also the line along it, from
 * `middle` - `half` to `middle` + `half`, with the distance of orbits from it in the balls of the middle: how a gap
 * changes from one orbit to the next is then told from how far they are apart. */
typedef struct {
    arb_srcptr hull;
    arb_srcptr middle, half; /* NULL, NULL: one orbit */
} ric_family;

void ric_passage_init(ric_passage *p);
void ric_passage_clear(ric_passage *p);
bool ric_passage_prove(ric_passage *p, const ric_chain *c, const ric_enclosure *e, const ric_family *u);

#endif
