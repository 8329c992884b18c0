/* The next time at which a face is met on a flight in closed form (docs/sections.md).
 *
 * A flight is linear in the modes of its phase (model/regime.h): with z = (A, P), A' = kappa P, P'
 * = -omega^2 / kappa A the gap coordinate of a contact is s = rest + G . A. It is searched in
 * panels of a fixed length h, over which z is turned by a rotation made once. On a part of a panel
 * the cubic Hermite interpolant H of s is off by at most
 *     |s - H| <= D4 h^4 / 384, |s' - H'| <= D4 h^3 sqrt(3) / 216, |s'' - H''| <= D4 h^2 / 12
 * (Birkhoff and Priver 1967), where D4 bounds the fourth derivative (from the
 * amplitudes of the modes, which a flight keeps), and its Bernstein coefficients
 * bound H, H', H''. So a part holds no impact, or is monotone, convex or concave, or is halved: no
 * impact is missed by more than rounding. Cost: O(n) per panel and contact, and some five
 * evaluations with sines where a face is met. */
#ifndef RIC_SECTION_SECTION_SEARCH_H
#define RIC_SECTION_SECTION_SEARCH_H

#include "model/room.h"

/* One phase: which springs are closed, and its modes. */
typedef struct {
    uint64_t closed;
    const ric_regime *regime; /* NULL: all springs are open */
    const double *omega, *G;  /* [n], [n_contact * n] */
    const double *rest;       /* [n_contact]; NULL: zeros */
    double panel;             /* scaled time; 0: no mode turns */
    double *turn; /* [3n] as ric_flight_trig has it over one, two and four panels, one by one */
    double *speed, *bend; /* [n_contact * n] s' = speed . P, s'' = -bend . A */
    double *low, *high;   /* [n_contact] s meets no face between them */
} ric_section_phase;

typedef struct {
    double time; /* scaled, from the start of the flight; infinite: none was found */
    int face;
    bool rests; /* the motion stays on the face that it starts on: there is no flight */
} ric_section_event;

ric_status ric_section_phase_create(const ric_model *m, uint64_t closed, ric_section_phase *out);
void ric_section_phase_release(ric_section_phase *phase);

/* The first event of the flight from z [2n] that leaves `face` (-1: starts in flight) within
 * `panels` panels. work [4n + 8 n_contact]. */
ric_section_event ric_section_search(const ric_model *m, const ric_section_phase *phase,
                                     const double *z, int face, long panels, double *work);

#endif
