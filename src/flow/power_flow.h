/* The smooth flow of a structure with power-law contacts: state and neighbours by Taylor series
 * (docs/theory.md section 10).
 *
 * da_i/dt = kappa_i p_i, dp_i/dt = -stiff_i a_i - sum_f c_fi spring_f s_f^m_f, s_f = g_f . a, in
 * the scaled frame of model.h. */
#ifndef RIC_FLOW_POWER_FLOW_H
#define RIC_FLOW_POWER_FLOW_H

#include "base/room.h"
#include "model/room.h"

/* The products that make s^(exponent - 1), the last, of s, number 0: squares s^2, s^4, ..., and
 * products of those that exponent - 1 is made of. left and right [RIC_SMOOTH_PRODUCTS + 1] from
 * place 1 on; returns their number. A square per binary digit and a product per digit that is not
 * 0; exponents are at most 99. */
enum { RIC_SMOOTH_PRODUCTS = 12 };
int ric_power_flow_products(int exponent, int *left, int *right);

/* Doubles of workspace for `columns` neighbours; it starts at a multiple of 16 bytes. */
size_t ric_power_flow_work(const ric_model *model, int columns);

/* Takes the state w [2n] through the time tau, of either sign, and with it the columns of X [2n *
 * columns], derivatives of the state, row by row, an even number of them; X may be NULL with
 * columns = 0. Truncation stays below rounding in every step. False, with w and X undefined: the
 * state overflows or the flight takes more than RIC_SMOOTH_STEPS steps. Cost O(columns order^2) per
 * contact and step, no allocation. */
enum { RIC_SMOOTH_STEPS = 20000 };
bool ric_power_flow_fly(const ric_model *model, double tau, double *w, int columns, double *X,
                        double *work);

/* The states w [count * 2n] behind the times tau [count], ascending and not negative, of a flight
 * from `from` [2n]: all read off one series of steps, as if each were flown by itself but for the
 * last digits. Workspace as without neighbours; false as above. */
bool ric_power_flow_visit(const ric_model *model, int count, const double *tau, const double *from,
                          double *w, double *work);

/* Length of the first step of a flight from w [2n]: a part of the radius of convergence, the time
 * in which the motion changes its course. */
double ric_power_flow_pace(const ric_model *model, const double *w, double *work);

/* The same with M [2n * 2n], the matrix of small deviations. Every step leaves a rounding of the
 * size of the state, and what follows multiplies it: for a step that ends at t by M(T) / M(t),
 * which may be much more than M(T). *lost is the root of the sum of the squares, over epsilon, of
 * the coordinate that loses most. */
bool ric_power_flow_map(const ric_model *model, double tau, double *w, double *M, double *lost,
                        double *work);

/* The same, and once more in more digits than a double has where the flight loses more than
 * RIC_SMOOTH_LOSES (1 + |w|): then *lost is, beside what is left of that, what the rounding of w
 * itself becomes. */
enum { RIC_SMOOTH_LOSES = 10000 };
bool ric_power_flow_map_surely(const ric_model *model, double tau, double *w, double *M,
                               double *lost, double *work);

/* The flight from w0 through tau in more digits: w [2n] and M [2n * 2n], rounded, and S [2n * 2n],
 * the rounding of the steps as taylor.h gathers it. Returns the epsilon of these digits over that
 * of a double; 1, with w and M as they were: there are none, or no memory. Eight times as long as
 * in double precision (power_flow_long.c). */
double ric_power_flow_again(const ric_model *model, double tau, const double *w0, double *w,
                            double *M, double *S);

/* ric_power_flow_fly with twice the digits, some ten times as long; numbers of workspace. */
size_t ric_power_flow_twice_work(const ric_model *model, int columns);
bool ric_power_flow_twice(const ric_model *model, ric_twice tau, ric_twice *w, int columns,
                          ric_twice *X, ric_twice *work);

#endif
