/* Period multiplication of an orbit without mirror: branches that leave along roots on a small
 * circle
 * (docs/theory.md section 8).
 *
 * The problem over r periods of the map in use has, at a multiplier of order r >= 3, a kernel of
 * three dimensions: the tangent T of the repeated branch and a plane that the shift by one period
 * turns by 2 pi p / r. In coordinates z of the plane in which it does so, and with s along T, what
 * is left of the equations (Lyapunov-Schmidt) is the gradient of
 *
 *     H = nu s |z|^2 / 2 + a |z|^4 + ... + Re(c z^r)
 *
 * (K. R. Meyer, Generic bifurcation of periodic points, Trans. AMS 149 (1970)). On the circle |z| =
 * h its radial part fixes s and its angular part g ~ h^(r-1) sin(r theta + phase) has 2 r roots,
 * which the shift divides into two classes: two in every sector of 2 pi / r. For even r they are
 * two curves. For odd r opposite roots are of different classes, and one curve passes; but for r >
 * 3 no step crosses the flat part around the node, and the two halves count as two branches. */
#ifndef RIC_JUNCTION_MULTIPLICATION_H
#define RIC_JUNCTION_MULTIPLICATION_H

#include "node.h"
#include "outset.h"

/* Whether the branch that leaves is found that way. */
bool ric_multiplication_applies(const ric_node *node, unsigned choice);

/* The problem over r periods at the node, and the way from there to a solved orbit beside it. Of
 * two families SIDE is the elliptic one, of two alike the one of smaller energy at equal distance;
 * of one that passes, side = 1 leads that way. RIC_E_NUMERIC: refused, the reason in ric_detail().
 */
ric_status ric_multiplication_depart(const ric_model *model, const ric_node *node, unsigned choice,
                                     int side, ric_outset *out);

/* The choice (SIDE, OTHER_SIDE) and side (+1, -1) at which an orbit near the node, with its
 * symmetries, lies. */
ric_status ric_multiplication_class(const ric_model *model, const ric_node *node,
                                    const ric_periodic *near, unsigned *choice, int *side);

#endif
