/* Stability (docs/theory.md section 5): the monodromy between sections, from saltation matrices in
 * modal coordinates. */
#ifndef RIC_ORBIT_FLOQUET_H
#define RIC_ORBIT_FLOQUET_H

#include "shooting.h"

/* Reversible chain: P = [[a, b], [c, d]] maps (symmetric, antisymmetric) coordinates of the start
 * section to those of the end section, n - 1 each. (M + M^-1) / 2 = 1 + 2 b'c on symmetric vectors,
 * so rho = lambda + 1/lambda = 2 + 4 eig(b'c), rho + 2 = 4 eig(d'a). The chain's own map M is over
 * half a period, or over a quarter joined with x -> -x twice: then M is the half-period map. */
typedef struct {
    int n_pair;  /* n - 1 */
    double *rho; /* [2 * n_pair] re, im of lambda + 1/lambda over the full period */
    double *own; /* [2 * n_pair] the same of the chain's own map, of which the full period may be
                    the square */
    double *own_error;  /* [n_pair] of each of these */
    double error;       /* of rho, absolute, from rounding */
    double *each;       /* [n_pair] of each rho, over the full period */
    double rough;       /* the same of the map in double, which another one may have replaced
                           (floquet_fine.h) */
    double trace_asinh; /* asinh(tau2 / 2), n = 2 only, else NaN */
    double rotation;    /* gamma, n = 2 on the unit circle, else NaN */
    ric_stability stable;
    /* signed determinants, scaled to finite numbers, whose zeros are branch points with a symmetry
     * broken:
     * det_b  the reversor (or, general form, unused: 1); det_a, det_d  one kind of mirror point is
     *        kept and the period
     * of M doubles, which for a quarter chain, and for sigma = -1 (det_a), breaks z(t+T/2) = -z(t).
     */
    double det_a, det_b, det_d;
    double error_a, error_b, error_d; /* rounding in them */
    double size_a, size_b,
        size_d; /* what they are at most: smooth along a branch, so that their quotients are, too */
    double enough; /* error of rho, over 1 + |rho|, that is good enough; 0: rounding, which may take
                      another map */
    double sharp;  /* the same, to which each pair is to be known, at a cost of its own; 0: what
                      comes by itself */
    bool coarse;   /* of several pairs only `own` and which of them are known are asked for */
    double *work;
    long double *fine;
    const long double *orbit; /* of more digits than the chain has (floquet_fine.h), or NULL */
    struct ric_floquet_known *known; /* maps made before (floquet_known.h), or NULL */
    struct ric_floquet_again *again; /* answers given before (floquet_again.h), or NULL */
    size_t n_work;
} ric_floquet;

ric_status ric_floquet_create(int n, ric_floquet *out);
void ric_floquet_release(ric_floquet *floquet);
/* From the states of the chain's last evaluation. */
ric_status ric_floquet_compute(const ric_shooting *chain, ric_floquet *out);
/* The determinants alone, with their errors and sizes; nothing is said of multipliers, which cost
 * most where there are many modes. */
void ric_floquet_factors(const ric_shooting *chain, ric_floquet *out);
/* Adds more [n_pair] to the error of each rho; those of which less than three digits are left are
 * lost, NaN, and with the only one trace and rotation. */
void ric_floquet_widen(ric_floquet *floquet, const double *more);
/* The multipliers of what was computed: 2 n_pair complex numbers as re, im pairs; NaN those of
 * which less than three digits are known, near +-1 those whose rho has less than six. */
void ric_floquet_multipliers(const ric_floquet *floquet, double *out);
/* One pair, lambda and 1 / lambda as re, im, from its rho [2]: re, im. */
void ric_floquet_pair(const double *rho, double *out);

#endif
