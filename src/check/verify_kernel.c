/* What makes an orbit a junction, told by the singular values of the derivatives of its equations
 * (docs/theory.md section 11). */
#include <complex.h>
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>

#define lapack_complex_double double _Complex
#define lapack_complex_float float _Complex
#include <lapacke.h>

#include "base/room.h"
#include "verify_kernel.h"
#include "verify_parts.h"

/* ROUNDING: of a matrix relative to its norm, and of the orbit over what holds it. Measured, not
 * derived: of 3,600 junctions of 180 random structures none needs more; a 16th is not enough */
#define ROUNDING (256 * DBL_EPSILON)
/* SURE: a second kernel vector that is not told from none to this proves nothing; VAGUE: what is
 * zero to more tells nothing */
#define SURE 1e-9
#define VAGUE 1e-6
/* CLEAR: times less than what holds an orbit; what rounding does to one held by less is not linear
 */
#define CLEAR 16
/* BESIDE: turns: a rotation that is not told from one so far off is not checked; PLACED: of that,
 * so far a located one may be off */
#define BESIDE 0.01
#define PLACED 1e-4

enum { LONGEST = 600 }; /* of the matrix: its singular values take seconds */

typedef struct {
    const ric_equations *of;
    int size;
    ric_number *J;      /* [(size + 1) * size] by columns */
    double *sv, *super; /* [size] singular values, ascending; and workspace */
} kernel;

/* Singular values of the equations, with the row of what is to be stationary. */
static ric_status find_values(kernel *q, double turns, ric_still row)
{
    const int m = q->size, ld = m + 1;
    const double angle = RIC_TWO_PI * turns;
    memset(q->J, 0, (size_t)ld * (size_t)m * sizeof *q->J);
    q->of->fill(q->of, q->J, cos(angle) + I * sin(angle), row);
    if (ric_lapack(LAPACKE_zgesvd(LAPACK_COL_MAJOR, 'N', 'N', row ? m + 1 : m, m, q->J, ld, q->sv,
                                  NULL, 1, NULL, 1, q->super)))
        return ric_fail(RIC_E_NUMERIC, "singular values of a junction could not be computed");
    for (int i = 0; i < m / 2; i++) {
        const double x = q->sv[i];
        q->sv[i] = q->sv[m - 1 - i];
        q->sv[m - 1 - i] = x;
    }
    return RIC_OK;
}

/* What is zero of these values where the orbit is held by the i-th: rounding moves it by that over
 * this value, and no value by more than the matrix (Weyl). */
static double zero(const kernel *q, int i)
{
    return (ROUNDING + q->of->open) * q->sv[q->size - 1] + (i < q->size ? ROUNDING / q->sv[i] : 0);
}

static int count_zeros(const kernel *q, double bound)
{
    int count = 0;
    while (count < q->size && q->sv[count] <= bound) count++;
    return count;
}

/* Dimension of the kernel of a period, at least 1: a family; *bound: what is zero, infinite where
 * that is not told from what holds the orbit. */
static ric_status find_kernel(kernel *q, int *dimension, double *bound)
{
    const ric_status status = find_values(q, 0, RIC_STILL_NOTHING);
    *dimension = 1;
    while (!status && *dimension < q->size && q->sv[*dimension] <= zero(q, *dimension + 1))
        ++*dimension;
    *bound = zero(q, *dimension);
    const double hold = *dimension < q->size ? q->sv[*dimension] : INFINITY;
    if (*bound > fmin(VAGUE, hold / CLEAR)) *bound = INFINITY;
    return status;
}

static void find_fault(ric_claims *out, const char *what, double value, double bound)
{
    out->numbers = RIC_AGREES_NO;
    if (!*out->finding)
        snprintf(out->finding, sizeof out->finding, "%s: singular value %.2g, bound %.2g", what,
                 value, bound);
}

/* At an extremum no direction in which the orbit has neighbours changes the number. */
static ric_status check_extremum(kernel *q, ric_still what, ric_claims *out)
{
    int dimension;
    double bound;
    ric_status status = find_kernel(q, &dimension, &bound);
    if (status || (status = find_values(q, 0, what))) return status;
    const int still = count_zeros(q, bound);
    if (isinf(bound)) ric_verify_digits_doubt(out, "kind");
    else if (!still)
        find_fault(out,
                   what == RIC_STILL_ENERGY ? "no extremum of energy" : "no extremum of period",
                   q->sv[0], bound);
    else if (still < dimension && bound <= SURE)
        find_fault(out, "an extremum where branches meet", q->sv[still], bound);
    else if (still < dimension) ric_verify_digits_doubt(out, "kind");
    return RIC_OK;
}

/* A second direction in which the orbit has neighbours; where no direction changes the energy it
 * may be an extremum of a family of two parameters. */
static ric_status check_branch_point(kernel *q, ric_claims *out)
{
    int dimension;
    double bound;
    ric_status status = find_kernel(q, &dimension, &bound);
    const double next = q->size > 1 ? q->sv[1] : INFINITY, nothing = zero(q, 2);
    if (status || (status = find_values(q, 0, RIC_STILL_ENERGY))) return status;
    if (isinf(bound)) ric_verify_digits_doubt(out, "kind");
    else if (dimension < 2) find_fault(out, "no branch point", next, nothing);
    else if (count_zeros(q, bound) >= dimension) ric_verify_digits_doubt(out, "kind");
    return RIC_OK;
}

static ric_status check_rotation(kernel *q, const int rotation[2], ric_claims *out)
{
    int dimension;
    double bound;
    char what[64];
    const double turns = (double)rotation[0] / rotation[1];
    ric_status status = find_kernel(q, &dimension, &bound);
    if (!status) status = find_values(q, turns, RIC_STILL_NOTHING);
    if (status) return status;
    const double least = q->sv[0];
    if ((status = find_values(q, turns + BESIDE, RIC_STILL_NOTHING))) return status;
    bound = fmax(bound, PLACED * q->sv[0]);
    if (!(bound < q->sv[0])) {
        ric_verify_digits_doubt(out, "multipliers");
        return RIC_OK;
    }
    snprintf(what, sizeof what, "no multipliers exp(+-2 pi i %d/%d)", rotation[0], rotation[1]);
    if (least > bound) find_fault(out, what, least, bound);
    return RIC_OK;
}

static ric_status check_kind(kernel *q, const ric_junction *j, ric_claims *out)
{
    switch (j->kind) {
    case RIC_KIND_EXTREMUM: return check_extremum(q, RIC_STILL_ENERGY, out);
    case RIC_KIND_PERIOD_EXTREMUM: return check_extremum(q, RIC_STILL_PERIOD, out);
    case RIC_KIND_BRANCH_POINT: return check_branch_point(q, out);
    case RIC_KIND_MULTIPLICATION: return check_rotation(q, j->rotation, out);
    default: return RIC_OK;
    }
}

bool ric_verify_kernel_tells(ric_kind kind)
{
    return kind == RIC_KIND_EXTREMUM || kind == RIC_KIND_PERIOD_EXTREMUM ||
           kind == RIC_KIND_BRANCH_POINT || kind == RIC_KIND_MULTIPLICATION;
}

ric_status ric_verify_kernel(const ric_equations *of, const ric_junction *j, ric_claims *out)
{
    const size_t m = (size_t)of->size;
    kernel q = {.of = of, .size = of->size};
    if (of->size == 0 || of->size > LONGEST) {
        ric_verify_digits_doubt(out, j->kind == RIC_KIND_MULTIPLICATION ? "multipliers" : "kind");
        return RIC_OK;
    }
    q.J = ric_malloc((m + 1) * m * sizeof *q.J);
    q.sv = ric_malloc(2 * m * sizeof *q.sv);
    ric_status status = RIC_OK;
    if (!q.J || !q.sv) status = ric_no_memory("what makes an orbit a junction");
    else {
        q.super = q.sv + m;
        status = check_kind(&q, j, out);
    }
    free(q.J);
    free(q.sv);
    return status;
}
