/* What was said of orbits of several pairs of multipliers before. A point is looked at, and judged
 * again where its flag is in doubt: the same orbit to the last bit, whose pairs take more time than
 * all else where there are many modes. */
#ifndef RIC_ORBIT_FLOQUET_AGAIN_H
#define RIC_ORBIT_FLOQUET_AGAIN_H

#include "floquet.h"

typedef struct ric_floquet_again ric_floquet_again;

/* NULL where there are less than two pairs; false: no memory. */
bool ric_floquet_again_create(int n, ric_floquet_again **out);
void ric_floquet_again_free(ric_floquet_again *again);

/* All that ric_floquet_compute says of a chain, if it was asked the same of the same orbit and is
 * remembered. `again` is that of f, or NULL. */
bool ric_floquet_again_find(const ric_floquet_again *again, const ric_shooting *chain,
                            ric_floquet *f);
void ric_floquet_again_keep(ric_floquet_again *again, const ric_shooting *chain,
                            const ric_floquet *f);

#endif
