/* Orbits that an atlas is explored from beside the linear modes: given from outside, kept in the
 * atlas as text (docs/atlas-format.md). */
#ifndef RIC_EXPLORE_START_H
#define RIC_EXPLORE_START_H

#include "orbit/room.h"

typedef struct {
    int n;
    ric_periodic **cycle; /* with the symmetries that they were given with; not yet solved */
} ric_starts;

/* One orbit per line: N, half (0 or 1), pure, flip (periodic.h), then N faces, N flights in
 * seconds, n_dof displacements and velocities, scaled, after impact 0. NULL: none. RIC_E_FORMAT if
 * it is not that. */
ric_status ric_starts_parse(const ric_model *model, const char *text, ric_starts *out);
void ric_starts_release(ric_starts *starts);

/* Such a line. `x`, `v` [n_dof], `flights` [N]; NULL: no memory. */
char *ric_start_line(int n_dof, int N, bool half, int pure, int flip, const int *word,
                     const double *flights, const double *x, const double *v);

/* The orbit next to a given one on its own equations. RIC_E_NUMERIC if there is none within `1e-6`
 * of it. */
ric_status ric_start_solve(const ric_model *model, const ric_periodic *given, ric_periodic **out);

#endif
