/* That a zero of the equations is a motion: flights last, impacts approach, and no face is passed
 * in between. */
#ifndef RIC_PROVE_PASSAGE_H
#define RIC_PROVE_PASSAGE_H

#include "chain.h"

typedef struct {
    bool done;
    char why[120];  /* where it is not */
    arb_t approach; /* a lower bound of the speed of every impact */
} ric_passage;

/* What holds an orbit, or all of an arc: the blocks of a chain [m * size]. Of an arc also the line
 * along it, from `middle` - `half` to `middle` + `half`, with the distance of orbits from it in the
 * balls of the middle: how a gap changes from one orbit to the next is then told from how far they
 * are apart. */
typedef struct {
    arb_srcptr hull;
    arb_srcptr middle, half;           /* NULL, NULL: one orbit */
    const struct ric_touch *touch;     /* of a grazing orbit, or NULL */
    const struct ric_arrival *arrival; /* of an arc that ends with one, or NULL */
    const struct ric_corner
        *corner; /* of an orbit at which several contacts close at one instant, or NULL */
} ric_family;

/* A gap that is exactly closed at the beginning of a flight, or at its end. */
typedef struct {
    int flight;
    bool end;
    int contact, side;
    bool still; /* it has exactly no speed there */
} ric_closure;

/* Where an orbit closes a second contact at the instant of an event: in which flights that is seen,
 * and the flight that has no length (-1: none). Gaps have to open behind it, and to close before
 * it, with a speed, or where they have exactly none to bend away. */
typedef struct ric_corner {
    int n, empty;
    ric_closure at[4];
} ric_corner;

/* The end of an arc, of which it is known that its gaps are not negative and its impacts no
 * departures: what falls along all of the arc towards the end was positive before it. */
typedef struct ric_arrival {
    arb_srcptr slope; /* [m * size] the derivative along the arc, towards the end */
    arb_srcptr last;  /* [m * size] the end */
} ric_arrival;

/* Where an orbit is known to touch: an impact of exactly no speed, or a time in flight at which a
 * gap is exactly zero and goes no farther. It is closed there alone if h'' > 0 around it. */
typedef struct ric_touch {
    int impact;       /* block that begins with it, m: the end of the chain; -1: it is in flight */
    int flight, face; /* of one in flight */
    bool image;
    arb_srcptr time;
    const signed char
        *together; /* [n_contact] sides of other contacts that touch then, too, or 0; or NULL */
} ric_touch;

void ric_passage_init(ric_passage *p);
void ric_passage_clear(ric_passage *p);
bool ric_passage_prove(ric_passage *p, const ric_chain *c, const ric_enclosure *e,
                       const ric_family *u);

#endif
