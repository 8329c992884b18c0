/* That a zero of the equations is a motion: flights last, impacts approach, and no face is passed in between. */
#ifndef RIC_PROVE_PASSAGE_H
#define RIC_PROVE_PASSAGE_H

#include "chain.h"

typedef struct {
    bool done;
    char why[120];  /* where it is not */
    arb_t approach; /* a lower bound of the speed of every impact */
} ric_passage;

/* u: the blocks of a chain [m * size], balls that hold the orbit. */
void ric_passage_init(ric_passage *p);
void ric_passage_clear(ric_passage *p);
bool ric_passage_prove(ric_passage *p, const ric_chain *c, const ric_enclosure *e, arb_srcptr u);

#endif
