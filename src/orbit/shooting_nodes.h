/* Inner nodes of a flight under a power law (docs/theory.md section 10).
 *
 * Where neighbours part fast, the last digit of the start is not the last digit of the end, and
 * Newton's method converges only next to the orbit: multiple shooting (H. B. Keller, Numerical
 * Methods for Two-Point Boundary-Value Problems, 1968, section 2.4) lets the flight start anew at
 * nodes, whose states become unknowns; what it leaves there are equations. The unknowns of a chain
 * are then
 *
 *     u = start block | time of the flight | z_1 | ... | z_(parts - 1)
 *     z_j sqrt(parts): state [2n] at the time j / parts of the flight
 *
 * The factor makes all nodes together count about as much as the start does in lengths along a
 * branch. Where neighbours grow by G along the whole flight they grow by G^(1/parts) along a part
 * of it, if they do so evenly. */
#ifndef RIC_ORBIT_SHOOTING_NODES_H
#define RIC_ORBIT_SHOOTING_NODES_H

#include "shooting.h"

enum { RIC_PARTS_MOST = 256 };
/* Divides the one flight of a chain into `parts`, at most RIC_PARTS_MOST; the chain has not been
 * flown yet. Without memory it can only be freed. */
ric_status ric_shooting_nodes_divide(ric_shooting *chain, int parts);
/* The chain looks up no flights any more, and gives back their room: it is done, and only its
 * points are flown once more. */
void ric_shooting_nodes_drop(ric_shooting *chain);
/* Room for several arrays, in one piece that is that of the first: chains are made by the thousand.
 * False: no memory, and all are NULL. */
bool ric_shooting_nodes_room(int count, const size_t *sizes, double **const *arrays);
/* Node j of u, from 1: the state w [2n]. */
void ric_shooting_nodes_put(const ric_shooting *chain, int j, const double *w, double *u);
/* Fills in the nodes of u: those of one flight from its start. */
void ric_shooting_nodes_spread(const ric_shooting *chain, double *u);
/* The same of a direction du, along the flight evaluated last. */
void ric_shooting_nodes_along(const ric_shooting *chain, double *du);
/* Largest difference between a node of u and the end of the part before it, at the last flight. */
double ric_shooting_nodes_gap(const ric_shooting *chain, const double *u);

/* Flies all parts of flight k, the only one where there is more than one part, and sets its end,
 * rate and map, and `lost`. False: they have just been flown. `u` from the time of the flight on.
 */
bool ric_shooting_nodes_fly(ric_shooting *chain, int k, const double *u);
/* Takes the live columns, `free_columns` of them, through all parts, and eliminates the nodes; the
 * time of the flight is the last live column afterwards. Returns the sign of the pivots. */
double ric_shooting_nodes_eliminate(ric_shooting *chain, const double *u, int free_columns,
                                    int rows);
/* Undoes that on z, of *m coordinates: the steps of the nodes go into du. */
void ric_shooting_nodes_unwind(const ric_shooting *chain, bool newton, int m, double *z,
                               double *du);
/* The rows of the nodes in the dense form: residuals, and the product of the derivative with du for
 * a neighbour dw [2n], taken to the end of the flight. Both return their number. */
int ric_shooting_nodes_residuals(const ric_shooting *chain, const double *u, double *r);
int ric_shooting_nodes_push(const ric_shooting *chain, const double *du, double *dw,
                            double *column);

#endif
