/* What the library gives of a stored point on request, `points` and `orbit` show it, for the judge
 * to compare: it is not stored, and nothing of it enters into what the judge finds. */
#include <math.h>
#include <stdlib.h>

#include "base/room.h"
#include "verify_pairs.h"

#define AT_JUNCTION 1e-9 /* of the arclength: a point that near to a junction is the junction */
/* GIVEN: error of a multiplier over 1 + its size up to which the library gives it */
#define GIVEN 1e-3

static bool two_meet(const ric_atlas *atlas, int id)
{
    ric_junction j;
    return id > 0 && !ric_atlas_junction(atlas, id, &j) &&
           (j.kind == RIC_KIND_BRANCH_POINT || j.kind == RIC_KIND_MULTIPLICATION);
}

/* Where branches meet a multiplier is 1, and the flag undecided by definition; other
 * multiplications that a branch passes are decided. */
static bool is_joint(const ric_atlas *atlas, const ric_branch *b, int i, double arclength)
{
    ric_junction j;
    bool joint = (i == 0 && two_meet(atlas, b->from)) ||
                 (i == b->n_point - 1 && two_meet(atlas, b->to));
    for (int k = 0; k < b->n_junction && !joint; k++)
        joint = fabs(b->junction_at[k] - arclength) <= AT_JUNCTION * (1 + arclength) &&
                two_meet(atlas, b->junctions[k]) &&
                !ric_atlas_junction(atlas, b->junctions[k], &j) && j.multiple <= 2;
    return joint;
}

/* What the library says its multipliers may be off by. Where that is more than it gives them for it
 * knows nothing of them: they are those of the stored trace then, and the digits of the replay
 * alone say what is known. */
static double stated(const ric_orbit *orbit, int n_pair, const double *multipliers)
{
    const double error = ric_orbit_multiplier_error(orbit);
    double largest = 0;
    for (int i = 0; i < 2 * n_pair; i++)
        largest = fmax(largest, hypot(multipliers[2 * i], multipliers[2 * i + 1]));
    return error <= GIVEN * (1 + largest) ? error : 0;
}

ric_status ric_verify_asked_open(const ric_atlas *atlas, int branch, int i, const ric_point *point,
                                 ric_verify_asked *out)
{
    ric_branch b;
    ric_orbit **orbits = NULL;
    int n = 0, n_mode = ric_model_n_mode(ric_atlas_model(atlas));
    *out = (ric_verify_asked){0};
    if (n_mode < 3 && point && point->stable != RIC_STABLE_UNDECIDED)
        return RIC_OK; /* all there is is stored */
    ric_status status = ric_atlas_branch(atlas, branch, &b);
    if (status) return status;
    if (!(out->multipliers = ric_calloc(4 * (size_t)n_mode, sizeof *out->multipliers)))
        return RIC_E_NOMEM;
    out->end = i == 0 || i == b.n_point - 1;
    out->joint = point && is_joint(atlas, &b, i, point->arclength);
    /* an orbit that the library does not give cannot be compared */
    out->given = !ric_orbit_find(atlas, branch, RIC_AT_POINT, i, &n, &orbits) && n > 0 &&
                 !ric_orbit_multipliers(orbits[0], out->multipliers);
    if (out->given) {
        out->stable = ric_orbit_stability(orbits[0]);
        out->error = stated(orbits[0], n_mode - 1, out->multipliers);
    }
    out->n_pair = n_mode - 1;
    ric_orbits_free(n, orbits);
    return RIC_OK;
}

void ric_verify_asked_close(ric_verify_asked *asked)
{
    free(asked->multipliers);
}
