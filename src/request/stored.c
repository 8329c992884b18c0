#include "stored.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"

/* NO_ORBIT: residual, relative to 1 + |state|, beyond which a stored point is no orbit. It is
 * stored with 1e-11 at most, and springs multiply the rounding of its digits by less than a
 * million, or no digit of a multiplier is known. */
#define NO_ORBIT 1e-5

ric_status ric_stored_cycle(const ric_atlas *a, const ric_branch *b, int i, ric_point *point,
                            ric_periodic **out)
{
    const ric_model *m = ric_atlas_model(a);
    int n = m->n_dof, N = b->letters;
    double *state = ric_calloc(2 * (size_t)n, sizeof *state),
           *flights = ric_calloc((size_t)N + 1, sizeof *flights);
    ric_status status = state && flights ? ric_atlas_point(a, b->id, i, point, state, flights)
                                         : ric_no_memory("a stored orbit");
    *out = NULL;
    for (int k = 0; !status && k < (N > 0 ? N : 1); k++) flights[k] *= m->omega_ref;
    if (!status && !(*out = ric_periodic_spelled(m, N, b->word, flights)))
        status = ric_no_memory("a stored orbit");
    if (!status) ric_model_from_state(m, state, state + n, (*out)->w);
    free(state);
    free(flights);
    return status;
}

ric_status ric_stored_chain(const ric_model *m, const ric_branch *b, int i, const ric_periodic *c,
                            ric_shooting **chain, double **u)
{
    ric_status status = ric_periodic_to_chain(m, c, chain, u);
    if (status) return status;
    ric_shooting_fly(*chain, *u);
    if ((*chain)->residual <= NO_ORBIT) return RIC_OK;
    return ric_fail(RIC_E_FORMAT,
                    "damaged atlas (table point, row %d, %d: what is stored is no orbit, it stays "
                    "open by %.2g); restore "
                    "it from a copy, or remove it and run the study again",
                    b->id, i, (*chain)->residual);
}

/* Those that hold for this cycle, of the kinds that its branch has. */
static void find_symmetries(const ric_model *m, const ric_branch *b, ric_periodic *c)
{
    ric_periodic_claim claim = {b->symmetric, b->reversible, strstr(b->mirror, "centre"),
                                strstr(b->mirror, "rest"), strstr(b->mirror, "impact")};
    ric_periodic_claimed(m, &claim, c);
}

static bool fits(const ric_model *m, const ric_branch *b, int i, const ric_periodic *c)
{
    ric_shooting *chain = NULL;
    double *u = NULL;
    const bool fit = ric_stored_chain(m, b, i, c, &chain, &u) == RIC_OK;
    ric_shooting_free(chain);
    free(u);
    return fit;
}

ric_status ric_stored_symmetries(const ric_atlas *a, const ric_branch *b, int i, ric_periodic *c)
{
    const ric_model *m = ric_atlas_model(a);
    const bool end = b->n_point > 2 && (i == 0 || i + 1 == b->n_point);
    ric_periodic *beside = NULL;
    ric_point point;
    ric_status status = end ? ric_stored_cycle(a, b, i ? i - 1 : 1, &point, &beside) : RIC_OK;
    if (status) return status;
    if (beside) {
        find_symmetries(m, b, beside);
        ric_periodic_take_symmetries(c, beside);
        ric_periodic_free(beside);
    }
    if (!end || !fits(m, b, i, c))
        find_symmetries(m, b, c); /* the two start at different impacts */
    return ric_trust(RIC_OK);
}

bool ric_stored_multipliers(const ric_model *m, const ric_point *point, double *out)
{
    const double rho[2] = {ric_point_trace(point), 0};
    if (m->n != 2 || point->stable == RIC_STABLE_UNDECIDED || !isfinite(rho[0] * rho[0]))
        return false;
    ric_floquet_pair(rho, out);
    return true;
}
