/* Contacts that are images of one another. A permutation of the coordinates, some of them with the
 * other sign, that takes mass and stiffness to themselves takes each mode of a frequency of its own
 * to itself or to its opposite; where it takes the normal of one contact to that of another, or to
 * its opposite, both gaps change alike in such a mode. */
#ifndef RIC_PROVE_TWINS_H
#define RIC_PROVE_TWINS_H

#include "model/room.h"

/* A permutation that takes all of the structure to itself, each stop to one of the same clearance,
 * and undoes itself. */
typedef struct {
    int *to, *sign; /* [n_dof] coordinate i goes to to[i], times sign[i] */
    int *face;      /* [n_face] where each face goes */
} ric_twin;

struct ric_twin_list;

/* Whether contact a is taken to contact b, of the same clearance, both stops: compared as the
 * decimals that the model holds. False also where too many permutations would have to be tried. */
bool ric_twins_are(const ric_model *m, int a, int b);

/* Those of a structure of stops alone, x -> x and x -> -x left out: the one of that number, or
 * NULL; no more are looked for than the first few. They are found when they are first asked for. */
const ric_twin *ric_twins_get(struct ric_twin_list *list, const ric_model *m, int number);
struct ric_twin_list *ric_twins_create(void);
void ric_twins_free(struct ric_twin_list *list);

#endif
