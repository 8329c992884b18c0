/* The equations of a periodic orbit with a given word, for a census: linear in the state w behind
 * impact 0, and with the flight times as the only other unknowns. Event k is the impact on face k,
 * P_k the motion from event 0 to behind event k:
 *   row 0        g.a = d                     the motion begins on its face
 *   row k        g.a = d behind flight k - 1 the next impacts, k = 1..N-1
 *   four rows    P_N w - w = 0               the motion closes
 *   last row     |w|^2 - 2 E = 0
 * Where a flight comes back to the face that it left, (h(t) - h(0)) / t = 0 takes the place of h(t)
 * = d: a flight of no time would solve that by itself. Such a row stands for the last flight, too,
 * although the closing ones imply it.
 *
 * Rows are Taylor polynomials of the second order in the times around a centre, with the remainder
 * from the size of their derivatives: all motions are isometries, so that a derivative of order j
 * of a row is at most
 * size top^j |w|, size = 1, |g| or |c|. */
#ifndef RIC_PROVE_CENSUS_ROWS_H
#define RIC_PROVE_CENSUS_ROWS_H

#include "census_pair.h"

enum {
    RIC_CENSUS_IMPACTS = 6, /* the longest words */
    RIC_CENSUS_ROWS = RIC_CENSUS_IMPACTS + 6,
    RIC_CENSUS_PAIRS = RIC_CENSUS_IMPACTS * (RIC_CENSUS_IMPACTS + 1) / 2,
};

typedef struct {
    int N;
    int face[RIC_CENSUS_IMPACTS];
} ric_census_word;

/* One number of each row. */
typedef struct {
    double m[RIC_CENSUS_ROWS], r[RIC_CENSUS_ROWS];
} ric_census_column;

typedef struct {
    const ric_census_pair *pair;
    const ric_census_word *word;
    int n;       /* rows, that of the energy is the last one */
    int closing; /* the first of the four */
    double t[RIC_CENSUS_IMPACTS];
    double size[RIC_CENSUS_ROWS]; /* of the derivatives */
    ric_ball cosine[RIC_CENSUS_IMPACTS][2], sine[RIC_CENSUS_IMPACTS][2];
    ric_ball form[RIC_CENSUS_IMPACTS][3]
                 [4];           /* row of a flight: on w before it, and its derivatives by t */
    ric_census_column state[4]; /* d row / d w */
    ric_census_column turned[RIC_CENSUS_IMPACTS][4]; /* d^2 row / d t d w */
    /* at a centre of w */
    double w[4];
    ric_census_column residual, time[RIC_CENSUS_IMPACTS]; /* rows, d row / d t */
    ric_census_column
        bent[RIC_CENSUS_PAIRS]; /* d^2 row / d t_j d t_l at l (l + 1) / 2 + j, j <= l */
} ric_census_rows;

/* Whether row `k` of the word is of a flight that comes back to the face that it left. */
bool ric_census_returns(const ric_census_word *word, int flight);
/* Everything that does not depend on w, at exact times; then all that does, at an exact w. */
void ric_census_rows_place(ric_census_rows *s, const ric_census_pair *pair,
                           const ric_census_word *word, const double *t);
void ric_census_rows_centre(ric_census_rows *s, const double w[4]);

#endif
