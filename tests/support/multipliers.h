/* Multipliers of an orbit as they come from its chain. */
#ifndef MULTIPLIERS_H
#define MULTIPLIERS_H

#include <cmocka.h>

#include "orbit/floquet.h"

static inline ric_floquet multipliers(ric_shooting *chain, const double *u)
{
    ric_floquet out;
    assert_int_equal(ric_floquet_create(chain->n, &out), RIC_OK);
    ric_shooting_evaluate(chain, u);
    if (ric_floquet_compute(chain, &out)) fail_msg("%s", ric_detail());
    return out;
}

#endif
