/* Places on the section of one energy: coordinates on it, and a fixed sequence of starts that fills
 * it.
 *
 * On a face a motion of energy E is known by n - 1 displacements y and n - 1 momenta r along the
 * face; the momentum across it follows from E. With y in the energy coordinates of model.h the
 * motions that reach the face are those with |y|^2 + |r|^2 < R^2, a ball, and its volume is the
 * measure that the map from impact to impact preserves. Other contacts cut parts of it away. */
#ifndef RIC_SECTION_SECTION_START_H
#define RIC_SECTION_SECTION_START_H

#include "section_motion.h"

typedef struct {
    const double *c, *g; /* [n] of its contact */
    double gap, cc;
    int side;    /* of the momentum across it where a motion starts: the sign of c . p */
    bool spring; /* closes where a motion starts */
    double *middle, *along,
        *across;   /* a = middle + along' y [n], [(n-1) * n]; p = across' r + .. c, [(n-1) * n] */
    double radius; /* R; 0: no motion reaches it */
    int image;     /* the face that x -> -x makes of it, -1: none, or it counts for both */
} ric_section_face;

typedef struct {
    const ric_model *m;
    double energy;
    bool smooth;
    int n_face;
    ric_section_face *face;
    double *store;
} ric_section_surface;

/* RIC_E_INPUT: no motion of this energy meets a contact, or the surface has no bound. */
ric_status ric_section_surface_create(const ric_model *m, double energy, ric_section_surface **out);
void ric_section_surface_free(ric_section_surface *surface);

/* State w [2n] right after the impact at the place b [2 (n - 1)] of the unit ball, and the springs
 * that are closed; false if no motion is there. */
bool ric_section_surface_at(const ric_section_surface *surface, int face, const double *b,
                            double *w, uint64_t *closed);
/* The place of a state on a face. */
void ric_section_surface_place(const ric_section_surface *surface, int face, const double *w,
                               double *b);
/* Point k, from 1, of a sequence that fills the unit ball of `size` = 2 (n - 1) dimensions evenly,
 * b [size]. */
void ric_section_surface_sequence(int size, long k, double *b);
/* Which springs a state of the structure is beyond; those of `face` (-1: none) are left out.
 * *outside: it is beyond a stop. */
uint64_t ric_section_surface_closed(const ric_model *m, const double *w, int face, bool *outside);

#endif
