/* The linear modes of a structure, and which of them its contacts see (docs/theory.md section 1).
 */
#ifndef RIC_MODEL_MODES_H
#define RIC_MODEL_MODES_H

#include "model.h"

/* A modal normal below this fraction of |c_f| is rounding: the mode is not seen by the contact. */
#define RIC_UNSEEN 1e-12

/* K phi = lambda M phi: frequencies (rigid-body modes have exactly 0) with what rounding took from
 * them, and shapes of a model with its raw data. Modes whose frequencies rounding of the matrices
 * alone tells apart have one, to the last bit, and the basis in which most are unseen; every shape
 * has its largest component positive. O(n_dof^3). */
ric_status ric_modes_find(ric_model *model);

/* The same for a model with the mass and stiffness of another one, whose modes it takes: of one
 * frequency none are, as their basis depends on the contacts. False: they are not alike, and
 * nothing is done. */
bool ric_modes_take(ric_model *model, const ric_model *same);

/* Of a model with its modes: modal normals, seen modes and their number n, and n_part. A contact
 * whose c.c is beyond what doubles can square is refused. */
ric_status ric_modes_see(ric_model *model);
/* Whether no two modes have one frequency. */
bool ric_modes_distinct(const ric_model *model);

/* Turns the shapes of a model to those of another one that it differs little from: model.h,
 * ric_model_create_near. */
ric_status ric_modes_orient(ric_model *model, const ric_model *near);

/* Whether two squared frequencies, the lower one first, are so near that motions with impacts mix
 * their modes at once: the mixtures that they leave from (mixture.h) are orbits to that. */
bool ric_modes_near(double lower, double upper);

#endif
