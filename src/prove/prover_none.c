/* The prover of a library that was built without FLINT: it says so. */
#include "base/room.h"

bool ric_prover_available(void)
{
    return false;
}

ric_status ric_prover_create(const ric_atlas *atlas, ric_prover **out)
{
    (void)atlas;
    *out = NULL;
    return ric_fail(RIC_E_INPUT,
                    "proofs are left out of this program: it was built without FLINT (Debian: libflint-dev, "
                    "and libflint-arb-dev where there is one)");
}

void ric_prover_free(ric_prover *prover)
{
    (void)prover;
}

ric_status ric_prover_point(ric_prover *prover, int branch, int i, ric_proof *out)
{
    (void)prover;
    (void)branch;
    (void)i;
    (void)out;
    return ric_fail(RIC_E_INPUT, "proofs are left out of this program: it was built without FLINT");
}

ric_status ric_prover_curve(ric_prover *prover, int branch, ric_curve_proof *out)
{
    (void)prover;
    (void)branch;
    (void)out;
    return ric_fail(RIC_E_INPUT, "proofs are left out of this program: it was built without FLINT");
}

const char *ric_prover_certificate(const ric_prover *prover)
{
    (void)prover;
    return "";
}

const char *ric_prover_model(const ric_prover *prover)
{
    (void)prover;
    return "";
}
