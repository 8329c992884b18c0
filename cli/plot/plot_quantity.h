/* What can stand on an axis of a picture of branches: numbers that are stored with every point. */
#ifndef PLOT_QUANTITY_H
#define PLOT_QUANTITY_H

#include "plot.h"

typedef enum {
    PLOT_ARCLENGTH,
    PLOT_ENERGY,
    PLOT_FREQUENCY,
    PLOT_PERIOD,
    PLOT_TRACE,
    PLOT_ROTATION,
    PLOT_REACH,
    PLOT_APPROACH,
    PLOT_DISPLACEMENT,
    PLOT_SPEED,
    PLOT_FLIGHT
} plot_quantity_kind;

typedef struct {
    plot_quantity_kind kind;
    int index; /* of x, v, tau, from 0 */
    char title[80];
    double unit; /* of what is shown */
} plot_quantity;

/* The quantity of a name such as energy, x1 or tau2, given with the option `what`; false after a
 * message. */
bool plot_quantity_find(const char *name, const char *what, int n_dof, plot_quantity *out);

/* As the options have it; energies, frequencies and lengths only. */
void plot_quantity_set_unit(plot_quantity *q, const plot_options *common, const ric_atlas *atlas);

/* Whether it is a smooth function of the arclength: the largest gap and the least speed have
 * corners, a rotation number ends with the slope of a root. */
bool plot_quantity_smooth(const plot_quantity *q);

/* Points of a branch as (x, y), in the order of the atlas. */
ric_status plot_quantity_track(const ric_atlas *atlas, const ric_branch *branch,
                               const plot_quantity *x, const plot_quantity *y, plot_track *t);

#endif
