/* A motion of one energy from one place of the section to the next (docs/sections.md).
 *
 * The section of a structure with stops is every impact, right after it; of one with bilinear
 * springs every closing of a spring; under a power law every passage of a spring through s = 0.
 * Faces are those of the structure; under a power law 2 f where the gap coordinate of contact f
 * rises, 2 f + 1 where it falls.
 *
 * A flight in closed form turns every mode in its plane, and an impact is a reflection: the energy
 * stays to rounding. What rounding leaves is taken out at every place of the section, along the
 * gradient of the energy, and the state is put onto its face, so that neither error adds up. The
 * search (section_search.h) misses no impact. */
#ifndef RIC_SECTION_SECTION_MOTION_H
#define RIC_SECTION_SECTION_MOTION_H

#include "section_measure.h"
#include "section_search.h"

typedef struct ric_section_motion ric_section_motion;

struct ric_section_motion {
    const ric_model *m;
    int n;
    bool closes, smooth; /* contacts of law bilinear, of law power */
    double energy;       /* of the scaled frame */
    int n_phase;
    ric_section_phase *phases; /* those that have been met */
    uint64_t closed;           /* springs */
    int face;                  /* on which the present flight starts, -1: none */
    double *w, *u, *rate;      /* [2n] state, deviation and dw/dt */
    double *next, *matrix, *work;
    double *store;
    double time, low; /* scaled; with what rounding dropped from it */
    ric_section_measure measure;
    char why[160]; /* why the motion came to an end, "" */
};

ric_status ric_section_motion_create(const ric_model *m, double energy, ric_section_motion **out);
void ric_section_motion_free(ric_section_motion *motion);

/* On a face, right after the impact (closed: the springs that are, that of the face among them), or
 * in flight with -1; and the measures anew. */
void ric_section_motion_start(ric_section_motion *motion, uint64_t closed, int face,
                              const double *w);
/* To the next place on the section; motion->why is set where there is none. */
ric_status ric_section_motion_next(ric_section_motion *motion, int *face);
/* The same under a power law (section_power.c). */
ric_status ric_section_power_next(ric_section_motion *motion, int *face);

/* Shared by both: time passes; the state gets its energy back; displacements are moved onto a
 * hyperplane g . a = gap. */
void ric_section_motion_pass(ric_section_motion *motion, double tau);
void ric_section_motion_level(ric_section_motion *motion);
void ric_section_motion_onto(int n, const double *g, double gap, double *w);

#endif
