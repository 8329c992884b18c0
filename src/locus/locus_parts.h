/* What the files of the locus share: a junction under a parameter of the structure is a curve on
 * the surface of all orbits of one word, whose coordinates are the place along the branch and the
 * parameter (docs/loci.md). */
#ifndef RIC_LOCUS_LOCUS_PARTS_H
#define RIC_LOCUS_LOCUS_PARTS_H

#include "junction/room.h"

/* Beside the tests of a branch: the gap that touches (reach.h). */
enum { RIC_TEST_TOUCH = 200 };
/* What a locus may meet on its way, beside its own end. */
enum { RIC_LOCUS_MEETINGS = 5 };

/* One touch in flight, told again on a neighbouring orbit. */
typedef struct {
    int flight, face;
    double share; /* of the flight that has passed */
} ric_locus_touch;

/* What vanishes along the locus. */
typedef struct {
    const ric_model *base; /* of the atlas, borrowed */
    ric_vary vary;         /* parts borrowed */
    ric_kind kind;
    ric_criterion what; /* `test` may be RIC_TEST_TOUCH */
    int choice;         /* of a multiplication, which of its problems (criterion.h) */
    int place;          /* of a corner: the flight of the chain that vanishes; -1 */
    double sign;        /* of the bordered determinant at the start; 0: not known yet */
    int n_touch;        /* of a grazing: touches that symmetry brings about together */
} ric_locus_problem;

/* An orbit of the surface, with what is asked of it. */
typedef struct {
    double p;            /* value of the parameter */
    ric_model *model;    /* owned */
    ric_shooting *chain; /* owned, evaluated at u */
    double *u, *t;       /* [n_unknown] unknowns, and the unit tangent of the branch */
    double *along; /* orientation of the larger problem (criterion.h) [n_along], NULL: none yet */
    int n_along;
    double f;                         /* what vanishes */
    ric_locus_touch touch;            /* of a grazing: where the touch is now */
    double energy, frequency, length; /* scaled by d of the first contact there; rad/s; d */
    double spare[4]; /* that no other gap touches, no impact loses its speed, no flight vanishes,
                        and no other branch crosses this one */
    double meets[RIC_LOCUS_MEETINGS]; /* signs change where another junction is met; NAN where that
                                         is not known */
} ric_locus_orbit;

/* A chart of the surface about an orbit: along the branch by a, of the size of the orbit, and in
 * the parameter by b, of its range. */
typedef struct {
    const ric_locus_orbit *centre;
    double *drift;   /* [n_unknown] change of the unknowns for b = 1 at a = 0, owned */
    double slope[2]; /* df/da, df/db */
    double doubt[2]; /* by how much two measurements of them differ; 0: by next to nothing */
    double ahead[2]; /* unit direction of the locus in (a, b) */
    double stretch;  /* length of the step per unit of that direction, of unknowns and parameter
                        together */
} ric_locus_chart;

/* ------------------------------------------------------- locus_family.c */

double ric_locus_range(const ric_vary *vary);
/* The structure where the parameter has a value; its modes like those of `near`, which may be NULL
 * (model.h). */
ric_status ric_locus_model(const ric_model *model, const ric_vary *vary, double value,
                           const ric_model *near, ric_model **out);
/* An orbit, of the last flight of a chain at u, as a guess for the same chain of another structure:
 * the same displacements, velocities and times. Both are to be freed, also on failure. */
ric_status ric_locus_carry(const ric_shooting *chain, const double *u, const ric_model *to,
                           ric_shooting **out, double **v);

/* Two modes, from 0, of which one swings ratio[1] times while the other does ratio[0] times, and
 * where. */
typedef struct {
    int mode[2], ratio[2];
    double value;
    int swinging,
        swings; /* the one of the two that swings so many times in the period of an orbit */
    double off; /* from that number */
} ric_locus_commensurate;
/* Such a place beside the value p, of modes of which one swings a whole number of times in the
 * period of an orbit of this frequency: families of orbits of two parameters cross the surface
 * there, as of two modes without impacts. The smallest ratio is told. Others are commensurate by
 * chance, of many modes some pair always. */
bool ric_locus_commensurate_near(const ric_locus_problem *q, double p, double frequency,
                                 ric_locus_commensurate *out);

/* -------------------------------------------------------- locus_orbit.c */

/* Fills `out` from an orbit of the structure of the atlas, moved to the nearest point of its
 * branch; what the problem still lacks, the touch or the flight that vanishes, is read off it.
 * RIC_E_NUMERIC where it does not converge. out is to be freed also on failure. */
ric_status ric_locus_orbit_begin(ric_locus_problem *q, const ric_periodic *cycle,
                                 ric_locus_orbit *out);
void ric_locus_orbit_free(ric_locus_orbit *orbit);
/* The chart of an orbit: slopes by central differences; `ahead` turned to the side of `before` [2],
 * NULL: to rising b. */
ric_status ric_locus_chart_make(ric_locus_problem *q, const ric_locus_orbit *centre,
                                const double *before, ric_locus_chart *out);
void ric_locus_chart_free(ric_locus_chart *chart);
/* Solves f = 0 on the line through (a, b) in the direction `across`. */
ric_status ric_locus_orbit_solve(ric_locus_problem *q, const ric_locus_chart *chart,
                                 const double at[2], const double across[2], ric_locus_orbit *out);

/* -------------------------------------------------------- locus_start.c */

/* What vanishes at a junction of an atlas, and its orbit. RIC_E_INPUT for one of which there is no
 * locus, with the reason. */
ric_status ric_locus_start(const ric_atlas *atlas, int junction, ric_locus_problem *q,
                           ric_periodic **cycle);
/* The mode, from 0, of a junction at which a linear mode touches first; -1 for others. */
int ric_locus_start_mode(const ric_atlas *atlas, const ric_junction *junction);

/* ------------------------------------------------------- locus_follow.c */

/* A point as it will be shown. */
ric_status ric_locus_keep(ric_locus *locus, const ric_locus_orbit *orbit, ric_locus_mark mark,
                          const char *what);
/* Both ways from an orbit that solves the problem. */
ric_status ric_locus_follow_curve(ric_locus *locus, ric_locus_problem *q, const ric_periodic *cycle,
                                  const ric_locus_options *options);

/* --------------------------------------------------------- locus_mode.c */

/* The first touch of a linear mode, in closed form. */
ric_status ric_locus_follow_mode(ric_locus *locus, const ric_locus_problem *q, int mode,
                                 const ric_locus_options *options);

/* --------------------------------------------------------------- locus.c */

/* Appends a point; state x then v [2 n_dof], flights in seconds. */
ric_status ric_locus_append(ric_locus *locus, const ric_locus_point *point);
/* The last point becomes the end, with the reason. */
ric_status ric_locus_end(ric_locus *locus, const char *why);
/* The points so far in the opposite order, for the second way. */
void ric_locus_turn(ric_locus *locus);
/* Whether a stop was asked for. */
bool ric_locus_stopped(const ric_locus_options *options, int points, double value);

#endif
