/* What vanishes at a junction, as a function of the orbit on its branch (docs/theory.md sections 7
 * and 8). */
#ifndef RIC_JUNCTION_CRITERION_H
#define RIC_JUNCTION_CRITERION_H

#include "branch/room.h"
#include "orbit/room.h"

enum {
    RIC_TEST_ROTATION = 100, /* lambda + 1/lambda of some pair reaches a given value */
    RIC_TEST_ASKED = 101,    /* energy or frequency is what was asked for */
};

typedef struct {
    int test;        /* of continuation.h, or one of these */
    int rotation[2]; /* p / q of a multiplication */
    const ric_user_point *asked;
} ric_criterion;

/* A criterion at work on one chain. */
typedef struct {
    ric_shooting *chain;
    ric_floquet floquet;
    int test;
    int place; /* in the chain, of the impact or flight in question */
    bool soft; /* at a grazing: a flight between two switches of a spring, and no impact */
    const double *u;
    int rotation[2], choice; /* of a multiplication p / q, and of its problems the one that is used,
                                or UNDECIDED */
    const ric_user_point *asked;
    bool last;     /* from a canonical orbit: what is found is kept */
    double noise;  /* rounding in the determinant of the larger problem, beside its zero */
    double aside;  /* imaginary part of the pair nearest to that of a multiplication */
    double *along; /* [n_along] direction of the curve in the unknowns of the problem without the
                      symmetry that breaks, at the last value; owned */
    int n_along;
} ric_criterion_work;

/* A criterion on a chain that has been flown or not, borrowed; its multipliers want
 * ric_floquet_create(n, &q.floquet). */
ric_criterion_work ric_criterion_begin(ric_criterion what, ric_shooting *chain);
void ric_criterion_release(ric_criterion_work *q);
/* Its value at the orbit u, where the chain has been evaluated with the unit tangent t,
 * `orientation` times the kernel vector (ric_continuation_tangent). */
double ric_criterion_value(ric_criterion_work *q, const double *u, const double *t,
                           double orientation);
/* Of a multiplication: distance of the nearest pair from lambda + 1/lambda of the multiplier
 * sought, and in q->aside its imaginary part. */
double ric_criterion_off_rotation(ric_criterion_work *q);
/* Whether the determinant of the larger problem tells a multiplication. */
bool ric_criterion_by_larger(const ric_criterion_work *q);
/* Flight of the chain between different contacts that is shortest; -1. */
int ric_criterion_shortest(const ric_shooting *chain, const double *u);
/* Whether the test is that of a kernel that breaks a symmetry of the form. */
bool ric_criterion_breaks_symmetry(int test);

#endif
