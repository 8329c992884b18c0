/* Junctions as regular zeros. Along a curve of orbits G(u) = 0, the equations of a chain (chain.h)
 * but for the plane, a junction is where something vanishes; that is added, and where the whole has
 * a regular derivative on a box the junction is there once, and is passed:
 *   ENERGY, PERIOD  the tangent a, G' a = 0, has E' a = 0 or T' a = 0: an extremum, which the curve
 *                   turns at
 *   BREAK           of a chain between mirror points: a motion beside the orbit, to first order,
 *                   that is turned into
 * its opposite at one of them or both (`broken`), and into itself at the other: a branch that lacks
 * these mirrors leaves there TURN            motions a and b beside it, a turned into itself at the
 *                                            first mirror point and b into its
 * opposite, such that at the last one cos(g) a + sin(g) b is turned into itself and cos(g) b -
 * sin(g) a into its
 *                   opposite, g = pi p / q: there are multipliers exp(+-2 i g) of the way there and
 *                   back;
 *                   of a general chain: a + i b returns as (1 + mu) exp(2 i g) (a + i b); as
 *                   exp(2 i g) / (1 + mu) is a multiplier, too, mu = 0 where no other one is near
 *   DOUBLE          of a general chain: a motion beside it that closes with the other sign
 *   SPEED           the speed of the impact that block `place` begins with, or that the chain ends
 *                   with (m), is zero
 *   TOUCH           in flight `place` the gap of `face`, or of its image, and its derivative are
 *                   zero at a time t
 *   GAP             the gap of `face`, or of its image, is zero at the event that block `place`
 *                   begins with, or that the chain ends with (m): a corner
 *   MEET            flight `place` has no length: a corner, too
 * Motions beside the orbit are held by one linear condition, l.a = 1, and as a time shift is turned
 * into its opposite by every mirror point, such a motion has one condition more there: at an impact
 * the time is that of the impact, in flight it is not along the motion. Werner and Spence, SIAM J.
 * Numer. Anal. 21 (1984) 388-399. */
#ifndef RIC_PROVE_AUGMENTED_H
#define RIC_PROVE_AUGMENTED_H

#include "contraction.h"
#include "equations.h"

typedef enum {
    RIC_AUGMENTED_ENERGY,
    RIC_AUGMENTED_PERIOD,
    RIC_AUGMENTED_BREAK,
    RIC_AUGMENTED_TURN,
    RIC_AUGMENTED_DOUBLE,
    RIC_AUGMENTED_SPEED,
    RIC_AUGMENTED_TOUCH,
    RIC_AUGMENTED_GAP,
    RIC_AUGMENTED_MEET,
} ric_augmented_kind;

typedef struct {
    ric_augmented_kind kind;
    bool broken[2];
    int p, q;
    int place, face;
    bool image;
    double time; /* t to begin with */
    double slow; /* what is stored may have impacts of that speed as touches */
} ric_augmented_question;

typedef struct {
    const ric_enclosure *e;
    ric_augmented_question ask;
    ric_chain c;             /* u: the centre; balls while equations are evaluated */
    slong n_orbit, n_motion; /* unknowns: of u, and of one motion beside it */
    slong n;                 /* all of them */
    int redundant; /* with both mirrors broken: the row at the end that follows from the energy; or
                      -1 */
    arb_ptr z;     /* [n] the zero: balls */
    arb_ptr l;     /* [n - n_orbit] */
    arb_mat_t gauge; /* [2 * 2n] along the motion at both ends */
    ric_contraction k;
    arb_t exists, unique;  /* radii in the largest number */
    signed char *together; /* [n_contact] TOUCH: sides of other contacts that touch at that instant,
                              too, or 0 */
    int times;             /* how often it lies in the period of the junction */
    const char *why;       /* why it is not proved, or NULL */
} ric_augmented;

/* Looks for the junction near the centre of `c`; to be released in any case. */
bool ric_augmented_prove(ric_augmented *x, const ric_chain *c, const ric_enclosure *e,
                         const ric_augmented_question *ask);
void ric_augmented_free(ric_augmented *x);

#endif
