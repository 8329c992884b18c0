/* What the files of the replay share: verify_orbit.c (the stored orbit), verify.c (flights, return,
 * verdict), replay_motion.c (the expected chain), replay_growth.c (multipliers, and what rounding
 * on the way grows to). No other file needs it. */
#ifndef RIC_CHECK_VERIFY_PARTS_H
#define RIC_CHECK_VERIFY_PARTS_H

#include "simulator.h"

/* Approach speeds over sqrt(2 E c.c), the largest speed that the energy allows: */
/* RIC_VERIFY_WORK: multiplications of a flight that is replayed, over the square of the modes */
#define RIC_VERIFY_WORK 1e4
/* RIC_VERIFY_ORTHOGONAL: cosine between two normals below which their impacts commute */
#define RIC_VERIFY_ORTHOGONAL 1e-12
/* RIC_VERIFY_DIGIT: of a stored number, relative to the largest of its kind: roundings in double
 * for every flight that the solver closes with it. Measured, not derived: the worst of some 10,000
 * orbits between stops had 11, of as many on stiff springs 41 (random structures with springs up to
 * 1e6 times as stiff as they are). */
#define RIC_VERIFY_DIGIT (64 * DBL_EPSILON)
#define SLOW 1e-3      /* below, the time of the impact is weighed */
#define BLUNT 1e-9     /* no impact amplifies more than one of this speed */
#define NO_LENGTH 1e-7 /* of the period: a contact of a spring that short is a touch */
/* DEPTH: of the clearance: a motion that would go no farther beyond its face touches it, as what a
 * stored point may be left open decides whether it is met at all */
#define DEPTH 1e-11

typedef ric_real real;

typedef struct {
    int contact, side;
    real limit, cc, spring;
    const real *c;
} face_t;

/* What the rounding of the stored digits leaves open, first order, times fixed as they are stored.
 */
typedef struct {
    real *gap, *speed; /* [n_flight] at the end of each flight, of the gap and of the speed into its
                          face */
    real *close;       /* [2n] of w_N - w_0, (kappa q, p) */
    real state;        /* of any state of the chain, in the energy norm */
    double *moves; /* [2n * (n_flight + 2n)] what a unit of each stored number moves: gaps, then w_N
                      - w_0 */
    double unit[2]; /* largest displacement and velocity */
} ric_digits;

typedef struct {
    const ric_model *model;
    ric_simulator *sim;
    const ric_digits *digits; /* NULL: not asked for */
    ric_branch branch;
    ric_point point;
    int n, n_flight, n_face; /* n_flight: letters, or 1 */
    int n_event, *event;     /* faces of the events of the word, in order */
    bool *closed;            /* [n_flight * n_face] springs in each flight */
    bool lost;               /* a frame could not be made */
    face_t *face;
    double *state, *flights; /* [2n] x, v and [n_flight] as stored */
    const real *omega;       /* [n] the simulator's */
    double *frequency;       /* [n] as said: those that are one are so to the last bit */
    real *kappa;             /* [n] omega, or 2 pi / period for a free mode */
    real *tau;               /* [n_flight] flight times */
    real *chain; /* [(n_flight + 1) * 2n] q, p behind each impact; last: behind the last flight */
    real *speed; /* [n_flight + 1] approach speed at the end of each flight, [0] unused */
    real *trig;  /* [n_flight * 2n] cos and sin of omega tau */
    real *w;     /* [2n] q, p of the replay */
    real *moved; /* [2n] column by which the start of a flight was brought back to its stop */
    double *x;   /* [2n] scratch: x, v */
    real depth;  /* as DEPTH: of a junction, which is located, it is more */
    real period, norm,
        offset;           /* offset: time at which the simulator was started anew behind a touch */
    double energy, reach; /* energy: of the state that is replayed */
    real amplification;   /* logarithm: what the end of the period makes of rounding on the way */
    bool corner, touched, grazes; /* grazes: a face is touched in some flight, or all but */
    ric_check *check;
    real *store;
    double *stored;
} replay;

/* The stored orbit of a point and its chain, from r = {0} on; to be closed in any case. `touches`:
 * contacts of no length stay in the word. */
ric_status ric_verify_replay_open(replay *r, const ric_atlas *atlas, int branch, int point,
                                  bool touches);
/* Any other orbit: letters and word of `like`. */
ric_status ric_verify_replay_open_orbit(replay *r, const ric_model *model, const ric_branch *like,
                                        const double *state, const double *flights);
/* Flies every flight of the word and the whole period with the simulator: what it finds goes into
 * r->check, which the caller starts with faces_agree. */
ric_status ric_verify_replay_run(replay *r);
void ric_verify_replay_close(replay *r);
real ric_replay_dot(int n, const real *x, const real *y);
/* |a - b| in the energy norm; b NULL stands for zero. */
real ric_replay_distance(const replay *r, const real *a, const real *b);
/* dp/dt [n] in the flight k. */
void ric_replay_accelerations(const replay *r, int k, const real *w, real *out);
/* |dw/dt| in the same norm, in the flight k. */
real ric_replay_rate(const replay *r, int k, const real *w);
/* In the flight k, with its springs. */
void ric_replay_fly(const replay *r, int k, real t, const real *w, real *after);
/* p <- R p; returns the speed into the face before. */
real ric_replay_reflect(const replay *r, const face_t *face, real *w);
real ric_replay_gap(const replay *r, const face_t *face, const real *w);
/* How far a state of size one, in the norm of the energy, moves a gap at most. */
real ric_replay_lever(const replay *r, const face_t *face);
/* Largest speed of the gap coordinate that the energy allows. */
real ric_replay_fastest(const replay *r, const face_t *face);
/* The face where flight k ends is that of event k + 1; none without impacts. */
const face_t *ric_replay_end_face(const replay *r, int k);
/* Whether face f has a spring that is closed in the flight k. */
bool ric_replay_closed(const replay *r, int k, int f);
/* Whether the event at the end of flight k is the opening of a spring. */
bool ric_replay_opens(const replay *r, int k);
/* How strongly a gap is drawn back from its face at the state w of flight k; negative: towards it.
 */
real ric_replay_pull(const replay *r, int k, const face_t *face, const real *w);
/* Whether a face that is met at w in flight k at that speed is only touched: the motion goes on by
 * speed^2 / 2 pull. */
bool ric_replay_touches(const replay *r, int k, const face_t *face, const real *w, real speed);
/* Whether the event at the end of flight k is a touch. */
bool ric_replay_is_touch(const replay *r, int k);
/* Expected states behind every impact, from chain[0] and tau. */
void ric_replay_make_chain(replay *r);
double ric_replay_part(real error, real of);
void ric_replay_worsen(double *worst, double error);

/* One column (kappa dq, dp) [2n] through flight k and the reflection at its end; `stretch` != 0
 * lets the impact follow the gap. Returns the gap's derivative before the reflection. */
real ric_replay_fly_column(const replay *r, int k, bool stretch, real *column);
/* The transposed of that, stretched: what a row [2n] behind flight k and its reflection is before.
 */
void ric_replay_fly_row(const replay *r, int k, real *row);
/* What the state w, before the event at the end of flight k, becomes for every unit of time that it
 * comes later: a column [2n] behind the event. */
void ric_replay_delay_column(const replay *r, int k, const real *w, real *column);

/* Of w_N - w_0, in the energy norm. */
real ric_verify_digits_closing(const replay *r, const ric_digits *digits);
/* To be closed in any case. */
ric_status ric_verify_digits_open(const replay *r, ric_digits *out);
void ric_verify_digits_close(ric_digits *digits);
/* Whether the stored orbit closes within its digits; what does not is said in `out`, and which of
 * its numbers could be off by a part in a million of the largest of its kind without being found.
 */
void ric_verify_digits_judge(const replay *r, const ric_digits *digits, ric_claims *out);
/* Whether the stored digits leave the speed at the end of flight k, or of one before it, open by
 * half of it, or the gap as far as the motion goes beyond the face: which one is met, and when,
 * cannot be told from there on. */
bool ric_verify_digits_hide(const replay *r, const ric_digits *digits, int k);
/* Moves the replay to the nearest orbit, by Newton's method of least norm; *found: there is one
 * nearer than any fault that is looked for. */
ric_status ric_verify_nearest(replay *r, bool *found);
/* One more number that could not be checked. */
void ric_verify_digits_doubt(ric_claims *out, const char *name);
/* A number is not what is found; the first one is told. */
void ric_verify_disagree(ric_claims *out, const char *name, double stored, double found);

/* Directions in the space of the modes that some contact sees, orthonormal, of modes of one
 * frequency each: of several with equal ones, which are any basis of theirs, as many as there are
 * independent shares. What is not seen has multipliers of its own, which no impact changes. share
 * [(n + 1) * n], seen [n]. */
int ric_verify_seen(const replay *r, int *seen, real *share);
/* Whether the replayed orbit is what makes its junction one: an extremum of energy or period, a
 * branch point, or a multiplication. */
ric_status ric_verify_kind(const replay *r, const ric_junction *j, ric_claims *out);

/* What an error of the state behind event `from`, or later, becomes until the end of flight `to` -
 * 1 at most, with the times as they are stored: 1 but for springs, which multiply it as they close.
 */
real ric_replay_growth(const replay *r, int from, int to);
/* The second half of the chain anew, from the state behind the last event backwards, which is that
 * behind the first: what springs make of rounding is then what they do in half a period.
 * ric_replay_make_chain undoes it. */
void ric_replay_fold(replay *r);
/* Largest modulus of a multiplier of the replayed orbit. */
ric_status ric_replay_condition(replay *r);

#endif
