/* What proves the orbits and the curves of one atlas: the structure in balls, with as many bits as
 * it takes. */
#ifndef RIC_PROVE_PROVER_H
#define RIC_PROVE_PROVER_H

#include "enclosure.h"
#include "linear_mode.h"

/* What is stored is near the orbit that is proved: the distance of the states and times over 1 +
 * the largest state, and relative differences of energy and period. Rounding leaves 1e-12, and up
 * to 5e-9 where a branch begins flat; a state that is off by 1e-6 is another one. */
#define RIC_PROVER_NEAR 1e-8
/* Whether both ends of what was proved are as near as that to the stored number. */
bool ric_prover_near(const double x[2], double stored);
/* Whether energy and period of what was proved are near the stored ones; else `why`. */
bool ric_prover_agrees(const ric_point *stored, ric_proof *out);

enum { PRECISIONS = 3 };

struct ric_prover {
    const ric_atlas *atlas;
    const char *left_out; /* why no orbit is proved, or NULL */
    struct {
        bool made, good, modes_made;
        ric_enclosure e;
        ric_linear_modes modes;
    } at[PRECISIONS];
    bool contradicted; /* what was proved last is not what is stored */
    char *model, *certificate;
};

/* The structure at a level of precision; `good` of it says whether it is enclosed. */
const ric_enclosure *ric_prover_enclosure(ric_prover *p, int level);
/* Why the structure is left out by name, or NULL; and the branch. */
const char *ric_prover_left_out_model(const ric_model *model);
/* Whether it has springs: a census is of stops alone. */
bool ric_prover_springs(const ric_model *model);
const char *ric_prover_left_out(const ric_prover *p, const ric_branch *branch);

#endif
