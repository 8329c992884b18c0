/* What the files of the simulator share: simulator.c (events and interface), simulator_modes.c (the
 * modes of each set of closed springs), simulator_search.c (flights, and where a face is met). No
 * other file needs it. */
#ifndef RIC_CHECK_SIMULATOR_PARTS_H
#define RIC_CHECK_SIMULATOR_PARTS_H

#include <float.h>
#include <math.h>
#include <stdbool.h>

#include "simulator.h"
#include "simulator_power.h"
#include "base/room.h"

/* Extended where the machine has it, so that the replay of an unstable orbit loses less than its
 * check allows. */
typedef ric_real real;

/* Asked of a double: compilers ask t <= LDBL_MAX instead, which is infinite for valgrind, whose
 * long double has 64 bits. */
static inline bool is_finite(real t)
{
    return (double)t < INFINITY;
}

/* Gaps that differ by less than this part of the sum of the moduli of their modes are equal to a
 * caller, who has doubles. */
#define ROUNDING (32 * DBL_EPSILON)
/* A start may be beyond a stop by this part of the clearance: twelve digits of a state typed by
 * hand leave that much. */
#define BEYOND 1e-10

typedef struct {
    int contact, side;
    real limit;  /* scaled clearance: the face is at side * s = limit */
    real spring; /* stiffness of law bilinear, 0: rigid */
    real cc;
    real noise;   /* what the rounding of the given state leaves uncertain in s */
    bool closed;  /* the spring is engaged */
    real impulse; /* exchanged since the face closed */
    /* of the present flight */
    const real *c; /* [n] modal normal in its frame */
    int sign;      /* side, or -side while closed: an event is sign * s rising beyond edge */
    real edge;     /* limit, or -limit while closed */
    real start;    /* sign * s - level at its start; exactly 0 on the face */
    real level;    /* edge, or a little more if the flight starts beyond it by rounding */
    real D[5];     /* D[k] bounds the k-th derivative of s; D[0] = infinity if a free mode drifts */
    real rest;     /* s in equilibrium */
    real band;     /* rounding of s */
} face_t;

/* The structure with some faces closed, in modes of its own. */
typedef struct frame {
    struct frame *next;
    bool *closed;     /* [n_face] */
    real *omega;      /* [n] rad/s, 0 for a free mode */
    real *phi, *mphi; /* [n * n] row i is mode i: phi_i and M phi_i */
    real *c;          /* [n_contact * n] */
    real *rest;       /* [n] equilibrium */
    real *turn;       /* [n * n] to the modes with every spring open: row i is mode i in these */
} frame;

struct ric_simulator {
    ric_shelved shelved;
    ric_simulator_power *springs; /* under a power law all motion is theirs: y [2n] = x, v at the
                                     time now, and nothing else here is used */
    real *y;
    int n, n_face, n_contact;
    real restitution;
    bool started;
    frame *open;         /* the frame with every spring open; the others follow as they are met */
    const frame *frame;  /* of the present flight */
    const real *omega;   /* [n] of that */
    const double *M, *K; /* raw matrices, copied */
    face_t *face;        /* [n_face] */
    real *b;             /* [n_contact * n] raw normals */
    real *q, *p; /* [n] modal state at the start of the flight, from the equilibrium of the frame */
    real *x;     /* [2n] scratch: displacement, velocity */
    double *rough;           /* [3n + n_contact n] omega, q, p, c in double, for the search */
    real origin, origin_low; /* time of that, with what rounding dropped from it */
    real now;                /* present time, from the origin */
    real known;              /* no impact before this time, from the origin */
    real scanned;            /* reach is known up to here */
    real next;               /* time of the next impact, infinite if it is not found yet */
    int next_face;
    bool examined; /* the start of the flight has been looked at */
    real reach;
    real *store; /* what the arrays above lie in */
};

/* ------------------------------------------------------------------- modes */

void ric_simulator_frame_free(frame *f);
ric_status ric_simulator_frame_create(ric_simulator *sim, const bool *closed, frame **out);
void ric_simulator_frame_enter(ric_simulator *sim, const frame *f);
/* The frame with these faces closed, made when it is first met. */
ric_status ric_simulator_frame_find(ric_simulator *sim, const bool *closed, const frame **out);
/* Displacement and velocity [2n] of a modal state of the present frame, and back. */
void ric_simulator_frame_to_space(const ric_simulator *sim, const real *q, const real *p, real *x);
/* `linear`: of a deviation, which has no equilibrium taken off. */
void ric_simulator_frame_to_modal(const ric_simulator *sim, const frame *f, bool linear,
                                  const real *x, real *w);
/* From the modal state in q, p of the present frame to that of another one. */
void ric_simulator_frame_change(ric_simulator *sim, const frame *f);

/* ------------------------------------------------------------------ search */

/* A face's gap g = sign * s - level, in double, for the search. */
ric_sample ric_simulator_search_look(const ric_simulator *sim, const face_t *face, double t);
/* g, g', g'' in full precision. */
void ric_simulator_search_look_closely(const ric_simulator *sim, const face_t *face, real t,
                                       real *g);
/* Modal state at time t of the flight; may work in place. */
void ric_simulator_search_fly_mode(const ric_simulator *sim, int i, real t, real *q, real *p);
/* From the modal state in sim->q, sim->p at the present origin on. */
void ric_simulator_search_begin(ric_simulator *sim);
double ric_simulator_search_time(const ric_simulator *sim, real t);
/* Moves the origin to time t of the flight; compensated, so that long runs lose no time (Kahan
 * 1965). */
void ric_simulator_search_move_origin(ric_simulator *sim, real t);
/* A first length for which the interpolant is within a few percent of the clearance. */
double ric_simulator_search_panel(const face_t *face);
real ric_simulator_search_face(const ric_simulator *sim, const face_t *face, double from,
                               double to);
/* g <-> reach, the gap coordinate over the clearance, of open faces. */
double ric_simulator_search_to_reach(const face_t *face, double g);
void ric_simulator_search_scan_reach(ric_simulator *sim, double to);
/* The start itself is a largest value where the gap coordinate falls from there on, unless the face
 * has just been left. */
void ric_simulator_search_start_reach(ric_simulator *sim);

#endif
