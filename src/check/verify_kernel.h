/* What makes an orbit a junction, told by the derivatives of its equations (docs/theory.md section
 * 11): columns are the states at some instants of the period and its times, rows what closes it. */
#ifndef RIC_CHECK_VERIFY_KERNEL_H
#define RIC_CHECK_VERIFY_KERNEL_H

#include <complex.h>

#include "ricochet.h"

typedef double _Complex ric_number;
/* What is to be stationary, as one row more. */
typedef enum { RIC_STILL_NOTHING, RIC_STILL_ENERGY, RIC_STILL_PERIOD } ric_still;

typedef struct ric_equations ric_equations;
struct ric_equations {
    int size;       /* rows and columns; 0: nothing is told */
    double open;    /* what the stored digits leave of them, relative */
    const void *of; /* whose they are */
    /* J [(size + 1) * size], zeros before, by columns; `turn` times the start is where the period
     * ends */
    void (*fill)(const ric_equations *of, ric_number *J, ric_number turn, ric_still row);
};

/* Whether a kind of junctions is told so: an extremum of energy or period, a branch point, or a
 * multiplication. */
bool ric_verify_kernel_tells(ric_kind kind);
/* Whether an orbit is what makes its junction, of one of these kinds, one. */
ric_status ric_verify_kernel(const ric_equations *of, const ric_junction *j, ric_claims *out);

#endif
