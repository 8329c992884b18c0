/* How long a flight between two impacts can last at one energy: a census of all periods needs no
 * other bound. */
#ifndef RIC_PROVE_CENSUS_FLIGHT_H
#define RIC_PROVE_CENSUS_FLIGHT_H

#include "census_pair.h"

/* An upper bound, 0 where no motion leaves a stop, or infinity where none is proved: where a mode
 * alone does not reach a stop, flights may last for ever. */
double ric_census_longest_flight(const ric_census_pair *p);

#endif
