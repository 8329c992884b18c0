/* Whether what is stored of a junction is the orbit that was proved: the impacts of a whole period, told again from a
 * chain, begun at any of them, run forwards or backwards, or as its image under x -> -x. Impacts of no speed count only
 * where there is no other. A comparison of doubles: it says what is meant, and proves nothing. */
#ifndef RIC_PROVE_LIKENESS_H
#define RIC_PROVE_LIKENESS_H

#include "chain.h"

/* The largest difference of a state behind an impact and of flight times, over 1 + the size of the state; not finite
 * where no beginning fits. word [letters], state [2 n_dof], flights [max(letters, 1)] as they are stored. */
double ric_likeness_distance(const ric_chain *c, const ric_enclosure *e, int letters, const int *word,
                             const double *state, const double *flights);

#endif
