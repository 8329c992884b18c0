/* The prover of a library that was built without FLINT: it says so. */
#include <math.h>

#include "base/room.h"

bool ric_prover_available(void)
{
    return false;
}

const char *ric_prover_version(void)
{
    return "";
}

ric_status ric_prover_create(const ric_atlas *atlas, ric_prover **out)
{
    (void)atlas;
    *out = NULL;
    return ric_fail(
        RIC_E_INPUT,
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

ric_status ric_prover_curve_from(ric_prover *prover, int branch, const ric_curve_work *work,
                                 ric_curve_proof *out)
{
    (void)work;
    return ric_prover_curve(prover, branch, out);
}

ric_status ric_prover_junction(ric_prover *prover, int id, ric_junction_proof *out)
{
    (void)prover;
    (void)id;
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

void ric_census_options_init(ric_census_options *o)
{
    *o = (ric_census_options){.impacts = 3,
                              .period = {0, HUGE_VAL},
                              .workers = 1,
                              .seconds = HUGE_VAL};
}

ric_status ric_census_run(const ric_model *model, const ric_census_options *options,
                          ric_census **out)
{
    (void)model;
    (void)options;
    *out = NULL;
    return ric_fail(RIC_E_INPUT, "proofs are left out of this program: it was built without FLINT");
}

void ric_census_free(ric_census *census)
{
    (void)census;
}

int ric_census_n_orbit(const ric_census *census)
{
    (void)census;
    return 0;
}

ric_status ric_census_orbit_at(const ric_census *census, int i, ric_census_orbit *out, int *word,
                               double *state, double *flights)
{
    (void)census;
    (void)out;
    (void)word;
    (void)state;
    (void)flights;
    return ric_fail(RIC_E_RANGE, "there is no orbit %d of the census", i);
}

ric_status ric_census_open_at(const ric_census *census, int i, int *impacts, int *word,
                              double *flights)
{
    (void)census;
    (void)impacts;
    (void)word;
    (void)flights;
    return ric_fail(RIC_E_RANGE, "there is no open solution %d of the census", i);
}

void ric_census_account_of(const ric_census *census, ric_census_account *out)
{
    (void)census;
    *out = (ric_census_account){.stopped = true};
}
