/* The ladder of tolerances that more than one file climbs, from the last digit upwards. Each is
 * relative to the size of what it compares, 1 + |state| for orbits, in the scaled frame (model.h),
 * where that is of order one.
 *
 * rounding      An orbit is solved to a few DBL_EPSILON times its conditioning
 *               (ric_continuation_tolerance), 1e-13 to 1e-11; what is derived from two solved
 *               orbits agrees to a thousand times that.
 * located       An event is a zero of a function along a branch: the orbit there is rounded to
 *               2^-32 and solved again (docs/theory.md section 6), so that two ways to it differ by
 *               far less than 1e-6, and two events that are not one by far more, but for families
 *               that all but meet.
 * extrapolated  The orbit is near a singular point, where it is known to the root of its rounding.
 * read off      The orbit lies on the cubic between two points; at steps of 0.08 rad that is off by
 *               1e-5 to 1e-4.
 *
 * A tolerance that only one file needs stands there, with its own reason. */
#ifndef RIC_BASE_TOLERANCES_H
#define RIC_BASE_TOLERANCES_H

/* An iteration whose step is this part of its interval has come to the last digit; smaller ones
 * never end. */
#define RIC_LAST_DIGIT 1e-15

/* Of what Newton's method left before: from RIC_FALLING on what is left is rounding, as a step that
 * converges leaves its square; from RIC_STALLING on no further step is worth its price. */
#define RIC_FALLING 0.1
#define RIC_STALLING 0.5

/* Numbers that rounding alone may tell apart, as they come out of long sums: the first of them
 * counts, so that the choice does not depend on it. Entries of a kernel vector are known to less:
 * rounding over the gap RIC_RANK. */
#define RIC_TIE 1e-9
#define RIC_TIE_IN_KERNEL 1e-6

/* "Is this the same orbit?", by what is known of the two. Too small: one orbit is stored twice. Too
 * large: two branches that pass close by are taken for one. */
#define RIC_SAME_SOLVED 1e-9
#define RIC_SAME_LOCATED 1e-6
#define RIC_SAME_EXTRAPOLATED 1e-5
#define RIC_SAME_READ_OFF 1e-3

/* Singular values below RIC_RANK of the largest, and below RIC_RANK_GAP of the next one, belong to
 * a kernel: at a located point they are zero to 1e-10 or so, and a gap tells them from those of a
 * branch that passes close by. */
#define RIC_RANK 1e-8
#define RIC_RANK_GAP 1e-3

/* Half step of central differences, relative to the orbit: the cube root of rounding, where the
 * error of the difference and that of rounding are alike. */
#define RIC_DIFFERENCE 1e-5

/* Length of a step over a branch point, of the size of the orbit: nearer to it the equations lose
 * their digits. */
#define RIC_CROSSING 1e-3

/* Unknowns from which on a dense singular value decomposition costs more than all else that is done
 * at a place. */
#define RIC_DENSE_MOST 300

#endif
