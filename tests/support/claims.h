/* What is verified of stored claims. Needs cmocka.h before it. */
#ifndef CLAIMS_H
#define CLAIMS_H

#include "ricochet.h"

/* Of point i of a branch; i < 0: of a junction. */
static inline ric_claims claims_of(const ric_atlas *atlas, int id, int i)
{
    ric_claims out;
    if (i < 0 ? ric_verify_junction(atlas, id, &out) : ric_verify_claims(atlas, id, i, &out))
        fail_msg("%s", ric_detail());
    return out;
}

#endif
