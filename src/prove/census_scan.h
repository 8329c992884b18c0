/* Motions of a box of states followed from impact to impact, forwards and backwards, while it is
 * known where they are: what that leaves of the flight times. */
#ifndef RIC_PROVE_CENSUS_SCAN_H
#define RIC_PROVE_CENSUS_SCAN_H

#include "census_box.h"

/* false: there is no orbit of the word in the box. Otherwise the box holds all that it held before.
 */
bool ric_census_scan(ric_census_box *b, const ric_census_pair *p, const ric_census_word *word);

#endif
