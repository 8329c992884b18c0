/* Smaller symmetries of a periodic orbit: the boundary value problems in which branches leave it
 * (docs/theory.md section 8). */
#ifndef RIC_BRANCH_SYMMETRY_H
#define RIC_BRANCH_SYMMETRY_H

#include "orbit/room.h"

typedef struct {
    int copies; /* periods of the orbit in one of the problem */
    bool half;  /* symmetries kept, as in ric_periodic, of the repeated cycle */
    int pure, flip;
} ric_symmetry;

/* The problem in which a kernel of type `test` (RIC_TEST_A, _B, _D) leaves an orbit with the
 * symmetries of `cycle`. */
ric_symmetry ric_symmetry_breaking(const ric_periodic *cycle, int test);

/* The inequivalent problems in which orbits of q periods leave where the rotation number is p / q;
 * their number, 1 or 2. */
int ric_symmetry_multiplying(const ric_periodic *cycle, int p, int q, ric_symmetry out[2]);

/* Order of the multiplier of the map in use: of half a period on an S orbit, else of the period. */
int ric_symmetry_order(const ric_periodic *cycle, int p, int q);

/* Whether one curve of orbits passes through the multiplication, on both sides of it: where the
 * order is odd. Without mirror points the flat part around the junction cannot be crossed from
 * order 5 on, and two branches leave. */
bool ric_symmetry_passes(const ric_periodic *cycle, int p, int q);

/* lambda + 1/lambda of the map in use there. */
double ric_symmetry_rho(bool half, int p, int q);

/* The orbit in a problem: repeated, with the symmetries kept. NULL: no memory. */
ric_periodic *ric_symmetry_cycle(const ric_periodic *cycle, const ric_symmetry *problem);

/* Of the two problems of a doubling mostly only one has a kernel: which. *both, unless NULL:
 * whether the other has one, too; then one period takes every deviation to its negative. */
int ric_symmetry_singular(const ric_model *model, const ric_periodic *cycle,
                          const ric_symmetry problems[2], bool *both);

#endif
