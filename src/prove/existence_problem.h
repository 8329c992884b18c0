/* Inside of a proof of existence: the problem that `existence` solves and bounds, in each of the
 * ways in which `existence_ways` tries it. */
#ifndef RIC_PROVE_EXISTENCE_PROBLEM_H
#define RIC_PROVE_EXISTENCE_PROBLEM_H

#include "contraction.h"
#include "equations.h"
#include "existence.h"
#include "factor.h"
#include "quick.h"

/* Multiplications of a step for each unknown, about. */
enum { RIC_EXISTENCE_WORK = 1000 };

/* In which numbers D is looked at: D'D in doubles, an inverse in doubles, which bears more and is
 * for what is not large, and D'D in balls. */
typedef enum { RIC_EXISTENCE_QUICK, RIC_EXISTENCE_INVERSE, RIC_EXISTENCE_BALLS } ric_existence_way;

typedef struct {
    ric_chain *c;
    const ric_enclosure *e;
    ric_equations q;
    ric_existence_way way;
    slong n;           /* unknowns */
    ric_quick d;       /* of the first way */
    ric_contraction k; /* of the second, and of a box */
    arb_mat_t J;       /* [n * n], of the same */
    arb_ptr F, z;      /* [n] */
    double *y;         /* [n] a vector of doubles */
    ric_factor f;      /* of the third */
    arb_mat_t *x;      /* [m] a vector, block by block, of balls */
    arb_t zero;
} ric_existence_problem;

/* Room for a whole matrix. */
void ric_existence_open_dense(ric_existence_problem *p);
/* The plane across the curve, from one that need not be a good one; false where D is singular. */
bool ric_existence_find_plane(ric_existence_problem *p);
/* Newton's method; `shift` and `moved` of ric_existence. */
bool ric_existence_refine(ric_existence_problem *p, double *shift, double *moved);
/* D at the centre, taken apart. */
bool ric_existence_factorise(ric_existence_problem *p);
void ric_existence_keep_tangent(ric_existence_problem *p, ric_existence *x);
/* A lower bound of the least singular value of D, with nothing taken off for the slack of flights.
 */
bool ric_existence_bound_inverse(ric_existence_problem *p, arb_t least);
/* The test of Newton and Kantorovich, with that. */
bool ric_existence_conclude(const ric_existence_problem *p, ric_existence *x, const arb_t least);
/* The Euclidean norm of middles, about. */
double ric_existence_size(arb_srcptr x, slong n);

#endif
