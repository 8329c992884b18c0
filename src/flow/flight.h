/* Flights of every law: between two events the structure is linear in the set of springs that are
 * closed, or smooth (law power).
 *
 * A flight with all springs open turns each mode in its plane (modal.h): `map` [3n] holds cos and
 * sin. Any other flight is *dense*: its state comes from a routine of the law, and `map` [4n^2] is
 * the matrix that carries small deviations through it (docs/theory.md section 10). Sets of closed
 * springs are bits, one per face. What differs from law to law is in the table of flight_law.h. */
#ifndef RIC_FLOW_FLIGHT_H
#define RIC_FLOW_FLIGHT_H

#include <string.h>

#include "model/room.h"

static inline bool ric_flight_dense(const ric_model *m, uint64_t closed)
{
    return closed || m->law == RIC_LAW_POWER;
}

/* Doubles that the map of one flight takes at most. */
static inline size_t ric_flight_stride(const ric_model *m)
{
    size_t n = (size_t)m->n;
    return m->law != RIC_LAW_RIGID && 4 * n * n > 3 * n ? 4 * n * n : 3 * n;
}

/* The closed springs after an event at `face`, which closes and opens them in turn; a rigid face
 * changes nothing. */
static inline uint64_t ric_flight_toggle(const ric_model *m, uint64_t closed, int face)
{
    return face >= 0 && m->face[face].spring > 0 ? closed ^ (uint64_t)1 << face : closed;
}

/* The same of the mirror image x -> -x, which has to exist: all of them have an opposite. */
uint64_t ric_flight_mirror(const ric_model *m, uint64_t closed);

/* What an event at a face does to the velocities p [n]: an impact turns them round, a spring leaves
 * them. */
static inline void ric_flight_strike(int n, const ric_face *face, double *restrict p)
{
    if (face->spring == 0) ric_impact_reflect(n, face, p);
}

/* State w [2n] after a time tau; may work in place. `event`: the face at the start of the flight,
 * -1 if none is; where it is a spring that has just closed the state is taken to be on it
 * (regime.h). */
void ric_flight_go(const ric_model *m, uint64_t closed, int event, double tau, const double *w,
                   double *after);
/* A dense flight with its matrix [2n * 2n] and dw/dt at its end; not in place. The matrix is that
 * of deviations in time, whatever the event at the start. */
void ric_flight_map(const ric_model *m, uint64_t closed, int event, double tau, const double *w,
                    double *matrix, double *after, double *rate);
/* The same under a power law; *lost is the rounding on the way (power_flow.h). `matrix` and `lost`
 * may be NULL; without a matrix in place. */
void ric_flight_smooth(const ric_model *m, double tau, const double *w, double *matrix,
                       double *lost, double *after);
/* The same in the digits of a double, whatever it loses; not in place. */
void ric_flight_roughly(const ric_model *m, double tau, const double *w, double *matrix,
                        double *lost, double *after);
/* Under a power law: the states w [count * 2n] behind the times tau [count], ascending, of one
 * flight (power_flow.h). */
void ric_flight_visit(const ric_model *m, int count, const double *tau, const double *from,
                      double *w);
/* Under a power law: time in which the motion from w changes its course (power_flow.h); 0 for want
 * of memory. */
double ric_flight_pace(const ric_model *m, const double *w);
/* V [2n * ld] <- matrix * V, the first `columns` of each row. */
static inline __attribute__((always_inline)) void ric_flight_carry(int n,
                                                                   const double *restrict matrix,
                                                                   int columns, int ld,
                                                                   double *restrict V)
{
    enum {
        BLOCK = 8
    }; /* columns at a time: the products of all would be the square of a large structure */
    int size = 2 * n;
    double sum[size * BLOCK];
    for (int first = 0; first < columns; first += BLOCK) {
        int count = columns - first < BLOCK ? columns - first : BLOCK;
        for (int i = 0; i < size; i++) {
            double *restrict row = sum + i * BLOCK;
            for (int j = 0; j < count; j++) row[j] = 0;
            for (int k = 0; k < size; k++)
                for (int j = 0; j < count; j++)
                    row[j] += matrix[i * size + k] * V[k * ld + first + j];
        }
        for (int i = 0; i < size; i++)
            memcpy(V + i * ld + first, sum + i * BLOCK, (size_t)count * sizeof *V);
    }
}

/* A state w [2n] and, unless NULL, deviations V [2n * ld] through a flight with closed springs in
 * extended precision, in place. False: there is no memory for their modes. */
bool ric_flight_fine(const ric_model *m, uint64_t closed, long double tau, long double *w, int ld,
                     long double *V);
/* (s(tau) - s(0)) / tau of the gap coordinate of a face along a flight from w, regular through tau
 * = 0, with its derivatives (regime.h). */
double ric_flight_chord(const ric_model *m, uint64_t closed, int event, int face, double tau,
                        const double *w, double *by_w, double *by_tau);
/* What a closing at the start of a flight makes of deviations X [2n * ld] of its state: they are
 * moved onto the face as the state is. */
void ric_flight_onto(const ric_model *m, uint64_t closed, int event, int ld, double *X);
/* Largest scaled frequency while springs are closed; 0 if none is. */
double ric_flight_fastest(const ric_model *m, uint64_t closed);

/* dw/dt. */
void ric_flight_rate(const ric_model *m, uint64_t closed, const double *w, double *rate);
/* Energy, springs included (without the a of zero modes). */
double ric_flight_energy(const ric_model *m, uint64_t closed, const double *w);
/* Twice the mean gradient of the energy between two states: (w1 - w0) . h = 2 (E(w1) - E(w0))
 * exactly, and h = 2 grad E where they agree. */
void ric_flight_secant(const ric_model *m, uint64_t closed, const double *w0, const double *w1,
                       double *h);

#endif
