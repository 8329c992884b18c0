/* The orbit problem: a chain of flights from a start condition to an end condition (docs/theory.md
 * sections 3 and 4).
 *
 * general      state after impact 0 -> sigma times itself (sigma = -1: half a period of an orbit
 *              with z(t+T/2) = -z(t))
 * reversible   mirror point -> mirror point: half a period, or a quarter when one is a centre and
 *              the other is not
 *
 * Unknowns u [n_unknown]: the start block, every flight time, and under a power law the states at
 * inner nodes (shooting_nodes.h), none unless asked for. One more unknown than equations: solutions
 * form curves.
 * The Jacobian is never stored. Its columns travel with the flights; each impact condition is
 * removed at once by one Householder reflection from the right, so that at most 2 n columns are
 * alive: an LQ factorisation that costs O(n^2) an impact, is backward stable whatever the
 * multipliers are, and never divides by an impact speed (docs/decisions/0002-structured-lq.md). */
#ifndef RIC_ORBIT_SHOOTING_H
#define RIC_ORBIT_SHOOTING_H

#include "flow/room.h"

typedef enum { RIC_MIRROR_NONE, RIC_MIRROR_REST, RIC_MIRROR_IMPACT, RIC_MIRROR_CENTRE } ric_mirror;

typedef struct {
    const ric_model *model;
    int n;                 /* seen modes */
    ric_mirror start, end; /* both NONE in the general form */
    int sigma;             /* general form: +1 or -1 */
    int multiple;          /* period = multiple * sum of the flight times */
    int n_flight;
    int *face; /* [n_flight + 1]: face at the start, then at the end of each flight; -1 where there
                  is no impact */
    double fastest;   /* largest frequency while springs are closed, 0 if none ever is */
    uint64_t *closed; /* [n_flight + 1] springs that are closed in each flight, and after the end
                         (flight.h) */
    bool plain; /* no divided differences, and no state moved onto a face: the equations as they are
                   written down */
    int n_start;   /* unknowns of the start block: w (general), a (rest), p (centre), a and speed
                      (impact) */
    int parts;     /* law power: of the flight, equally long, between inner nodes; 1: it has none */
    int n_unknown; /* n_start + n_flight + 2n (parts - 1) */

    /* set by ric_shooting_evaluate */
    double *w;   /* [(n_flight + 1) * 2n] start state, then the state after each flight (after the
                    impact, if there is one, but before it at an impact that is the end mirror) */
    double *tau; /* [n_flight] */
    double *before;   /* [n_flight * n] velocities at the end of each flight, before the impact */
    double *rate;     /* [n_flight * 2n] dw/dt at the end of each dense flight */
    size_t stride;    /* doubles in the map of a flight */
    double *map;      /* [n_flight * stride]: 3n of cos, kappa sin / omega, omega sin / kappa, or a
                         matrix (flight.h) */
    double *chord;    /* [n_flight * (2n + 1)] of flights between two switches of one spring: by its
                         start and its time, the divided difference that is its condition */
    double *approach; /* [n_flight + 1] speed of the gap coordinate into the face; [0] only for a
                         start on an impact mirror */
    double residual;  /* largest residual relative to 1 + |w| */
    double scale;     /* 1 + |w|; 1 before the first flight */
    double share; /* of scale that flights round to: |w| under a power law if that is below 1, since
                     its orbits become linear, whatever their size, towards nothing; otherwise 1 */
    double stiff; /* what closed springs make of an error of the displacements, relative to scale: a
                     velocity so much larger */
    double grain; /* how far the state moves within the last digit of the longest flight time,
                     relative to scale, over epsilon */
    double end_det;  /* product of the end pivots, signed: with the tangent's orientation, the sign
                        of the bordered determinant */
    double smallest; /* smallest end pivot in modulus: 0 where the kernel has more than one
                        dimension */
    bool singular;   /* a pivot vanished */

    /* factorisation */
    int n_end;  /* end conditions */
    double *hv; /* Householder vectors, ld per row: start constraint, one per flight, n_end */
    double *beta, *zeta; /* per Householder vector */
    double *X;           /* live columns */
    double *flown; /* law power: [2n + 1 + 2n (parts - 1)] start, time and nodes that `w`, `map` and
                      `lost` belong to */
    double *kept;  /* law power: the last flights of a chain of one part, NULL or room for
                      most_kept of them (shooting_nodes.c) */
    int n_kept, next_kept, most_kept;
    bool rough;   /* law power: what is evaluated is left by a Newton step, and may lose digits */
    double lost;  /* law power: rounding along the flight, of the part that loses most, over epsilon
                     (power_flow.h) */
    double *part; /* with inner nodes [parts * (4n^2 + 4n)]: of each part its map, its end, and
                     dw/dt there */
    int ld;
} ric_shooting;

/* Rows that a dense Jacobian takes at most. */
static inline int ric_shooting_rows(const ric_shooting *c)
{
    return c->n_flight + 2 * c->n * c->parts + 2;
}

/* Whether the chain's own map is that of half a period, joined with x -> -x. */
static inline bool ric_shooting_halves(const ric_shooting *chain)
{
    return chain->multiple == 4 || chain->sigma < 0;
}

/* Whether flight k lies between two switches of one spring: it closes at its start and opens at its
 * end, or the other way round. Where such a flight vanishes its two conditions become one, and that
 * at its end is replaced by their divided difference (docs/theory.md section 10). */
static inline bool ric_shooting_between(const ric_shooting *c, int k)
{
    return c->face[k + 1] >= 0 && c->face[k] == c->face[k + 1] &&
           c->model->face[c->face[k]].spring > 0;
}

/* The event at the start of flight k as a flight takes it. */
static inline int ric_shooting_event(const ric_shooting *c, int k)
{
    return c->plain ? -1 : c->face[k];
}

/* Whether flight k is one, or half of one that has its mirror point of rest in the middle. */
static inline bool ric_shooting_touches(const ric_shooting *c, int k)
{
    int f = c->face[k], g = c->face[k + 1];
    if (f >= 0 && g >= 0) return ric_shooting_between(c, k);
    return (k == 0 && f < 0 && c->start == RIC_MIRROR_REST && g >= 0 &&
            c->model->face[g].spring > 0) ||
           (k + 1 == c->n_flight && g < 0 && c->end == RIC_MIRROR_REST && f >= 0 &&
            c->model->face[f].spring > 0);
}

/* A chain over `face` [n_flight + 1]; sigma counts only in the general form. */
ric_status ric_shooting_create(const ric_model *model, ric_mirror start, ric_mirror end, int sigma,
                               int n_flight, const int *face, ric_shooting **out);
/* The springs that are closed in the first flight; those in the others follow from the faces. None
 * at creation. */
void ric_shooting_close(ric_shooting *chain, uint64_t closed);
ric_shooting *ric_shooting_copy(const ric_shooting *chain);
void ric_shooting_free(ric_shooting *chain);

/* Flies the chain at u, sets everything above and factorises the Jacobian. Cost O(n_flight n^2), no
 * allocation. */
void ric_shooting_evaluate(ric_shooting *chain, const double *u);
/* The same where what the equations leave open is known to more digits than the chain has it
 * (floquet_fine.h): left [1 + n_flight + 2n] of the start, each flight and the end. It goes into
 * the steps and into `residual`, which is that of the chain no more. Not under a power law. */
void ric_shooting_evaluate_left(ric_shooting *chain, const double *u, const double *left);
/* Residuals only: states, approach, residual, trig; O(n_flight n). */
void ric_shooting_fly(ric_shooting *chain, const double *u);

/* From the last evaluation: the minimum-norm Newton step plus alpha times the kernel vector (newton
 * = true), or the kernel vector times alpha (newton = false); du [n_unknown]. The kernel vector has
 * unit norm. */
void ric_shooting_step(const ric_shooting *chain, bool newton, double alpha, double *du);
/* Both in the time of one: the Newton step du, alpha = 0, and the kernel vector, alpha = 1. */
void ric_shooting_steps(const ric_shooting *chain, double *du, double *kernel);

/* From the last evaluation: a lower bound of what ric_shooting_plane calls *second, off by rounding
 * alone, and above that over the root of n_end; NAN where a pivot is 0. */
double ric_shooting_least(const ric_shooting *chain);
/* From the last evaluation: the two directions that the Jacobian carries to the least, orthonormal,
 * kernel [2 * n_unknown]: the second spans the kernel, the first joins it where its singular value
 * *second is 0. Cost O(n_flight n). False: LAPACK failed. */
bool ric_shooting_plane(const ric_shooting *chain, double *kernel, double *second);

/* Period and energy (scaled frame) of the last evaluation, and the derivative of the energy along
 * du. */
double ric_shooting_time(const ric_shooting *chain, const double *u);
double ric_shooting_energy(const ric_shooting *chain);
double ric_shooting_energy_slope(const ric_shooting *chain, const double *du);

/* General form, after a flight: the mean gradient of the energy between both ends of the closure, h
 * [2n]. E(w_N) = E(w_0) holds for any unknowns, so that the closure is perpendicular to it. */
void ric_shooting_mean_gradient(const ric_shooting *chain, double *h);

/* Dense Jacobian of all residuals [equations * n_unknown] by propagating one unknown at a time:
 * for tests and junctions only. In the general form the 2n closure rows are unprojected. Returns
 * the number of equations. */
int ric_shooting_jacobian(ric_shooting *chain, const double *u, double *J);
/* The residuals in the same order. */
int ric_shooting_residuals(ric_shooting *chain, const double *u, double *r);

#endif
