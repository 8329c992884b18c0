/* What is measured along a motion on a section: the growth of a small deviation, and how neighbours
 * turn round it (docs/sections.md).
 *
 * Growth. A deviation u [2n] of the state, in the energy surface, goes through flights and impacts
 * with the motion; (1/t) ln |u(t)| / |u(0)| is the finite-time Lyapunov exponent. |u| is the energy
 * norm.
 *
 * Turning, n = 2. With z_i = s_i q_i + i p_i / s_i, s_i = sqrt(omega_i), and G = grad H in these
 * coordinates, the number c(u) = G_1 u_2 - G_2 u_1 belongs to u without its part along the flow,
 * and in flight it only turns, by -(omega_1 + omega_2) t. On a face u is (y, r), displacement and
 * momentum along the face, which an impact leaves alone; c of the direction (1, 0) has an imaginary
 * part of the sign of the normal speed, never zero, so that its angle is known without a doubt, and
 * the angles of u in both planes lie in the same half turn. So every turn is counted, none is
 * guessed: the number of turns per impact is known to one turn over the number of impacts. On an
 * orbit of N impacts with multipliers exp(+-2 pi i gamma) it is +-gamma / N mod 1 / N (the rotation
 * number of the tangent map, Ruelle 1985). */
#ifndef RIC_SECTION_SECTION_MEASURE_H
#define RIC_SECTION_SECTION_MEASURE_H

#include "flow/room.h"

enum { RIC_SECTION_BATCHES = 16 };
/* Squared length of a deviation beyond which it is scaled back: far from overflow, and seldom. */
#define RIC_SECTION_LONG 1e120
#define RIC_SECTION_SHORT 1e-120

typedef struct {
    const ric_model *m;
    double scale; /* ln of what has been taken out of u */
    double begin; /* ln |u| at the start */
    int n_batch;  /* parts of the motion that are over, of equal numbers of impacts */
    double growth[RIC_SECTION_BATCHES],
        time[RIC_SECTION_BATCHES]; /* ln |u| and the time at their ends */
    /* turning, n = 2 */
    bool turning, started;
    double angle;  /* lifted, of c(u) */
    double origin; /* of the direction of u on the face, lifted, at the start */
    double now;    /* and after the last impact */
    double turns;  /* whole ones at the last arrival */
    double y, r;   /* u on the face */
} ric_section_measure;

/* rate [2n] here and below: dw/dt. */
void ric_section_measure_begin(const ric_model *m, const double *w, const double *rate, double *u,
                               ric_section_measure *out);
/* ln |u|; u is made of ordinary size again where it has left it. */
double ric_section_measure_growth(ric_section_measure *s, double *u);
/* c(u), re and im, n = 2. */
void ric_section_measure_number(const ric_model *m, const double *w, const double *rate,
                                const double *u, double *c);
/* The motion is on a face, before the impact; and after it, or where it starts. */
void ric_section_measure_arrive(ric_section_measure *s, const ric_face *face, const double *w,
                                const double *rate, const double *u);
void ric_section_measure_leave(ric_section_measure *s, const ric_face *face, const double *w,
                               const double *rate, const double *u);
/* Turns per impact, in [0, 1). */
double ric_section_measure_rotation(const ric_section_measure *s, long impacts);
/* The exponent per scaled time and its error: that of the mean of the batches, and ln N / t, which
 * a motion without an exponent shows. */
void ric_section_measure_exponent(const ric_section_measure *s, long impacts, double *exponent,
                                  double *error);

#endif
