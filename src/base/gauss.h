/* The rule of Gauss with eight nodes (Abramowitz and Stegun 25.4.30), in panels of equal length. */
#ifndef RIC_BASE_GAUSS_H
#define RIC_BASE_GAUSS_H

/* Node i of 8 * panels on [0, length], from the first to the last; *weight: that of a value there.
 */
double ric_gauss_node(double length, int panels, int i, double *weight);

#endif
