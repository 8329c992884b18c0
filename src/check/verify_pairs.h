/* Multipliers of a replayed orbit from the matrix of its period (docs/theory.md section 11). */
#ifndef RIC_CHECK_VERIFY_PAIRS_H
#define RIC_CHECK_VERIFY_PAIRS_H

#include <complex.h>
#include <stdbool.h>

#include "ricochet.h"
#include "simulator.h"

typedef long double _Complex ric_pair; /* rho = lambda + 1 / lambda */

enum {
    RIC_PAIR_RUNS = 5, /* one as exact as can be, three with the rounding of doubles added, one
                          along the branch */
    RIC_PAIR_MOST      /* with that of the nearest orbit, where it was asked for */
};
#define RIC_PAIR_SAFETY 64 /* times the largest difference between the runs */

/* What the library gives of a point on request. */
typedef struct {
    bool given, joint; /* joint: the branch ends in another one, so that the flag is undecided */
    bool end;          /* of a branch: an impact may have no speed there, and the solver no flag */
    ric_stability stable;
    int n_pair;
    double error;        /* of the sum of a pair, as the library states it */
    double *multipliers; /* [4 * n_pair] as ric_orbit_multipliers gives them */
} ric_verify_asked;

/* Asks where more than what is stored is there; `point` NULL: in any case. To be closed in any
 * case. */
ric_status ric_verify_asked_open(const ric_atlas *atlas, int branch, int i, const ric_point *point,
                                 ric_verify_asked *out);
void ric_verify_asked_close(ric_verify_asked *asked);

/* What several runs make of the multipliers. */
typedef struct {
    int n_pair;             /* beside the trivial one */
    bool half;              /* own: of the map of half a period, joined with x -> -x */
    int runs;               /* RIC_PAIR_RUNS, or RIC_PAIR_MOST */
    int way[RIC_PAIR_MOST]; /* of a single pair: as ric_verify_pairs_find gives it */
    const ric_verify_asked *asked;
    ric_pair *own; /* [runs * n_pair] ascending by real part */
} ric_pairs;

/* rho [m / 2 - 1] of A [m * m], without the pair 1, 1 that the flow [m] and the gradient of the
 * energy [m] belong to; columns of A are images of unit vectors, J [m * m] is the symplectic form,
 * all are destroyed. *way, of a single pair: -1 where it turns as a free oscillator does, 1 against
 * it. False: eigenvalues were not found. */
bool ric_verify_pairs_find(int m, ric_real *A, ric_real *J, ric_real *flow, ric_real *gradient,
                           ric_pair *rho, int *way);

/* +-1 by a generator of fixed seed (Knuth, The Art of Computer Programming 2, table 3.3.4.1). */
ric_real ric_verify_pairs_noise(unsigned *bits);

/* Compares with what is stored: fills in the multipliers and the stable flag of `out`. */
void ric_verify_pairs_judge(const ric_pairs *pairs, int n_mode, const ric_point *stored,
                            ric_claims *out);

#endif
