/* The parts of a census (docs/proofs.md): zeros of the equations of each word, and which of them
 * are motions. */
#ifndef RIC_PROVE_CENSUS_H
#define RIC_PROVE_CENSUS_H

#include "census_zero.h"
#include "ricochet.h"

typedef enum { RIC_CENSUS_ORBIT, RIC_CENSUS_GHOST, RIC_CENSUS_OPEN } ric_census_verdict;

/* A zero, and what is known of it. */
typedef struct {
    ric_census_word word;
    ric_census_zero zero;
    ric_census_verdict verdict;
    bool repeats, symmetric, reversible;  /* proved */
    double period[2], trace[2], approach; /* seconds; bounds */
    ric_stability stable;
    double *state; /* [2 n_dof] scaled, behind impact 0; NULL unless it is an orbit */
} ric_census_find;

/* Whether the zero is a motion; of one its numbers. */
void ric_census_judge(ric_census_find *z, const ric_census_pair *p);
/* Whether the image of a that begins at its impact `shift`, run backwards and mirrored or not, is
 * the zero b. */
bool ric_census_is_image(const ric_census_find *a, const ric_census_find *b,
                         const ric_census_pair *p, int shift, bool reverse, bool mirror);
/* Whether any image of a is b. */
bool ric_census_same(const ric_census_find *a, const ric_census_find *b, const ric_census_pair *p);

#endif
