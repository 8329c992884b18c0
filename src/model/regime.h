/* The linear phases of a model with bilinear contacts (docs/theory.md section 10): which faces are
 * closed, and the modes that the structure has while their springs are engaged.
 *
 * In the scaled modal frame q'' = -(Omega^2 + sum k_f c_f c_f') q + sum k_f c_f gap_f over the
 * closed faces f. With the orthogonal U of K_phase = U diag(omega^2) U', flight is one plane
 * rotation per mode of the phase in its own energy coordinates
 *     A = kappa (U'q - rest),  P = U'p,   kappa = omega, or 1 where omega = 0.
 * States that go in and out are the energy coordinates w = (a, p) of the open structure; sets of
 * closed faces are bits (RIC_FACES_MAX of model.h). */
#ifndef RIC_MODEL_REGIME_H
#define RIC_MODEL_REGIME_H

#include "modal.h"

#define RIC_REGIME_CONTACTS 10 /* bilinear contacts of a model: 3^10 sets */

typedef struct {
    int n;
    double *omega, *omega_low; /* [n] scaled frequencies, and what rounding took from them */
    double *kappa;             /* [n] */
    double *into;              /* [n * n] A = into a - shift */
    double *shift;             /* [n] */
    long double *exact; /* [(3 n + 1) * n] into, from, U and shift with the digits that a stiff
                           spring takes from a double */
    double *from;       /* [n * n] a = from (A + shift) */
    double *U;          /* [n * n] q = U r, P = U' p */
    double *G;          /* [n_contact * n] s = rest + G . A */
    double *rest;       /* [n_contact] gap coordinates in equilibrium */
} ric_regime;

/* Makes room for the phases of a model; none is computed before it is asked for. RIC_E_INPUT: too
 * many bilinear contacts. */
ric_status ric_regimes_create(ric_model *model);
void ric_regimes_free(ric_model *model);

/* Whether the faces can be closed together: they are springs, and no two of one contact. */
bool ric_regime_exists(const ric_model *model, uint64_t closed);

/* Borrowed from the model; computed when it is first asked for, by any thread. */
ric_status ric_regime_get(const ric_model *model, uint64_t closed, const ric_regime **out);

/* z [2n] = (A, P) of a state w, and back. O(n^2). */
void ric_regime_enter(const ric_regime *phase, const double *w, double *z);
void ric_regime_leave(const ric_regime *phase, const double *z, double *w);
/* A flight of the time tau, of either sign, from w, and the face whose closing starts it, NULL if
 * none: there s = gap by definition, and the state is first moved onto it, a <- a - (g.a - gap) g /
 * (g.g). On an orbit that changes nothing; off it the flight no longer depends on how far the state
 * is off the face, and rounding of its displacements is not multiplied by the stiffness of the
 * spring. */
typedef struct {
    const ric_face *closing;
    double tau;
    const double *w;
} ric_regime_course;

/* The state after it; may be where w is. O(n^2). */
void ric_regime_fly(const ric_regime *phase, const ric_regime_course *course, double *after);
/* Its derivative by w, D [2n * 2n] by rows, of a flight that does not start with a closing. O(n^3).
 */
void ric_regime_matrix(const ric_regime *phase, double tau, double *D);
/* Both; D may be NULL. pull [n], unless NULL: the acceleration at the end, from the distance to
 * equilibrium; formed of the state, whose displacements are rounded, it would be off by the
 * stiffness times as much. */
void ric_regime_map(const ric_regime *phase, const ric_regime_course *course, double *D,
                    double *after, double *pull);

/* by [3n]: of each mode the cosine of a flight in extended precision and its two sines. */
void ric_regime_turn_fine(const ric_regime *phase, long double tau, long double *by);
/* The flight by them, that starts with no closing: columns W [2n * ld] in place, of states, or of
 * deviations, which no equilibrium shifts. O(ld n^2). */
void ric_regime_fly_fine(const ric_regime *phase, const long double *by, int ld, bool states,
                         long double *W);

/* Deviations X [2n * ld] at a closing moved onto the face, like the state. */
void ric_regime_onto(int n, const ric_face *closing, int ld, double *X);

/* (s(tau) - s(0)) / tau of the gap coordinate of a contact along a flight from w, regular through
 * tau = 0, where it is ds/dt, and for either sign of tau; by_w [2n] and *by_tau, its derivatives,
 * may be NULL; by_w is that of a flight that does not start with a closing. O(n^2). */
double ric_regime_chord(const ric_regime *phase, const ric_regime_course *course, int contact,
                        double *by_w, double *by_tau);

#endif
