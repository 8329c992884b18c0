/* Linear modes in closed form, those that no contact sees and those of one frequency too: in the
 * structure with all of its modes in balls. docs/proofs.md states the theorem. */
#ifndef RIC_PROVE_LINEAR_MODE_H
#define RIC_PROVE_LINEAR_MODE_H

#include "enclosure.h"

typedef struct {
    const ric_enclosure *e; /* of all modes */
    ric_enclosure own;      /* where contacts see fewer */
    bool good, exact;       /* it is enclosed; each group below has one frequency, exactly */
    int *group;             /* [e->n] of the modes that it does not tell apart, from 0 */
} ric_linear_modes;

/* `seen`: the structure with the modes that contacts see, borrowed; where these are all, it is
 * taken. To be released in any case. */
void ric_linear_modes_create(ric_linear_modes *modes, const ric_enclosure *seen);
void ric_linear_modes_free(ric_linear_modes *modes);

/* Whether a stored state x, v [2 n_dof], at rest, at the centre or between, is that of a motion in
 * one mode, which reaches no stop, and tells energy, period and stability of it; or why not. */
bool ric_linear_mode_prove(const ric_linear_modes *modes, double frequency, const double *state,
                           ric_proof *out);

#endif
