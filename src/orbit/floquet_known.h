/* Maps in extended precision (floquet_fine.h) that were made before. Where a multiplication is
 * sought, and where a point is looked at and then stored and judged, the same orbits are asked for
 * again, to the last bit: one map in six. Of two modes, where a map is four numbers that take
 * microseconds. */
#ifndef RIC_ORBIT_FLOQUET_KNOWN_H
#define RIC_ORBIT_FLOQUET_KNOWN_H

#include "floquet_fine.h"

typedef struct ric_floquet_known ric_floquet_known;

/* NULL where there are not two modes; false: no memory. */
bool ric_floquet_known_create(int n, ric_floquet_known **out);
void ric_floquet_known_free(ric_floquet_known *known);

/* As ric_floquet_fine_map of the chain's own orbit, with the same bits. known may be NULL. */
bool ric_floquet_known_map(ric_floquet_known *known, const ric_shooting *chain, const double *start,
                           const double *end, ric_fine_real *store, double *size);

#endif
