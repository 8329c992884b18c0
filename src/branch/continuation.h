/* Following one branch from one end to the other (docs/theory.md section 7): predict, correct, look
 * for events, adapt. */
#ifndef RIC_BRANCH_CONTINUATION_H
#define RIC_BRANCH_CONTINUATION_H

#include "user_point.h"
#include "orbit/room.h"
#include "resonance.h"

#define RIC_MEASURED 4 /* safety of an error that is measured by moving the unknowns */

/* Version of the numerics of following a branch. Stored branches are taken up only by a program of
 * the same version: it is raised with every change after which the same departure may lead to other
 * bits, else an atlas that is continued would mix branches of two programs. */
#define RIC_NUMERICS 55

/* Why a trace ended where it did, where ric_stop alone does not say it. */
typedef enum {
    RIC_WHY_NONE,
    RIC_WHY_ENERGY_MAX,
    RIC_WHY_ENERGY_MIN,
    RIC_WHY_FREQUENCY_MAX,
    RIC_WHY_FREQUENCY_MIN,
    RIC_WHY_CLOSED,
    RIC_WHY_POINTS,
    RIC_WHY_NO_STEP,
    RIC_WHY_NO_JUNCTION,
    RIC_WHY_NO_FIT,
    RIC_WHY_NO_WAY_BACK,
    RIC_WHY_TONGUE,
    RIC_WHY_TOUCHES,
    RIC_N_WHY
} ric_why;
/* The reason as a sentence, "" for RIC_WHY_NONE. */
const char *ric_continuation_why_text(ric_why why);

/* Test functions; an event is a zero of one of them. */
enum {
    RIC_TEST_REACH,    /* 1 - reach */
    RIC_TEST_APPROACH, /* smallest approach speed, and time between two switches of one spring */
    RIC_TEST_FLIGHT,   /* smallest flight time between different contacts; on a ghost, of all */
    RIC_TEST_DET,      /* bordered determinant */
    RIC_TEST_SLOPE,    /* dE/ds */
    RIC_TEST_A,        /* kernels that break a symmetry of the form (floquet.h) */
    RIC_TEST_B,
    RIC_TEST_D,
    RIC_TEST_PERIOD, /* dT/ds */
    RIC_TEST_E_MAX,
    RIC_TEST_E_MIN,
    RIC_TEST_F_MAX,
    RIC_TEST_F_MIN,
    RIC_N_TEST, /* and beyond it, one for every resonance of the trace, and then for all that is
                   asked for */
};
/* RIC_SINGULAR_START: with the tests to ignore: the start is a branch point, taken as it is; t0 is
 * the first step */
#define RIC_SINGULAR_START (1u << RIC_N_TEST)
/* RIC_LEAVING: first step from a branch point, of the size of the orbit: nearer by, dE/ds and
 * others are rounding */
#define RIC_LEAVING 1e-3

/* One solved point of a branch. */
typedef struct {
    double s;
    double *u, *t; /* [n_unknown] unknowns and unit tangent */
    double test[RIC_N_TEST];
    double factor[3]; /* the factors A, B, D of the map over what they are at most: smooth, but next
                         to nothing beside a grazing */
    double hidden[3]; /* below it the sign of their tests is lost in rounding */
    double *own;      /* [2 * n_pair] lambda + 1/lambda of the map in use, in ascending order */
    double *error;    /* [n_pair] of each of these */
    ric_point row;
    bool solved;   /* its residual is rounding: only such orbits are stored */
    bool doubtful; /* its stability in the row is that of the map alone (ric_continuation_judge)
                      until it is kept */
} ric_station;

/* Points of the step at work whose test functions are known, in order, the present one at `now`,
 * and before it some of the steps before (event_samples.c). */
enum { RIC_PAST_SAMPLES = 2, RIC_MOST_SAMPLES = 80 };
typedef struct {
    int n, now, n_past;
    bool open;                  /* what they tell of is not sure everywhere */
    double x[RIC_MOST_SAMPLES]; /* distance from the present point */
    double s[RIC_PAST_SAMPLES]; /* arclength of those before */
    double *values;             /* [RIC_MOST_SAMPLES * ric_continuation_watched()] */
} ric_event_samples;

/* Multipliers of all orbits that were looked at in the step at work: one resonance is passed
 * between those that the search for another has left. */
enum { RIC_MOST_KNOWN = 64 };
typedef struct {
    int n;
    double x[RIC_MOST_KNOWN];
    double *own; /* [RIC_MOST_KNOWN * 2 * n_pair] */
} ric_known_pairs;

/* Orbits that the step at work has solved for, the last of them: a place where a function vanishes
 * is asked for again with other things to look at (event_locate.c). */
enum { RIC_MOST_SOLVED = 64 };
typedef struct {
    int n;     /* of all of them: number i is at i % RIC_MOST_SOLVED */
    bool full; /* none is added, while orbits are solved for that may be forgotten */
    double x[RIC_MOST_SOLVED];
    double *u; /* [RIC_MOST_SOLVED * n_unknown] */
} ric_solved_orbits;

typedef struct {
    int test; /* which function vanished */
    double s;
    double *u, *t; /* owned */
} ric_event;

typedef struct {
    double energy[2]; /* window, internal units */
    double period[2]; /* smallest and largest period, internal units */
    double max_step;  /* relative to the size of the unknowns */
    int max_points;
    int multiply;        /* largest q of a q-tupling that is looked for; below 2 none */
    double tongue_width; /* relative, in frequency: narrower tongues are stepped over (leap.h); 0:
                            none is */
    int n_asked;         /* energies and frequencies whose passages are events */
    ric_user_point asked[RIC_USER_POINTS_MAX];
    bool ghost; /* go on past inadmissible points, as long as no flight time is negative */
    void (*stepped)(void *user); /* NULL, or told of every step */
    void *user;
} ric_limits;

/* Limits from the windows of a study or a picture: scaled energies, frequencies in rad/s (0: no
 * largest period). */
ric_limits ric_continuation_limits(const ric_model *model, const double energy[2],
                                   const double frequency[2], double max_step, int max_points);

/* What a step changes and the next one reads, beside stations and counts. One list, so that a step
 * that is undone, and a trace that is kept, have all of it:
 *   definite    last value of each test function that was not lost in rounding
 *   wanted      lengths of the present and (after) the next step that an event asks for, 0 = none
 *   longest     step that still keeps before an orbit of fewer periods that lies ahead
 *   lowest      energy below which a branch is not followed that starts above it
 *   blind       arclength on which multiplications are not looked for: multipliers are lost in
 *               rounding
 *   blind_at    least and largest energy of the steps with lost multipliers, and (crowded_at) with
 *               places that are unresolved; 0 while there are none
 *   unresolved  places where functions may vanish twice, and too near to tell
 *   approaches  attempts to place this step over a crossing
 *   avoided     another branch comes near ahead, and does not cross: the zero that the bordered
 *               determinant heads for is none
 *   steep       law power: somewhere more is lost in rounding than it ought to be
 *   leap_at     period of the border of a tongue, from where the next step leaps; 0: none
 *   refused     periods from where and to where a leap was refused: it is tried again from much
 *               nearer to the resonance only
 *   on_mode     the mode, from 1, along whose tongue the branch has climbed, with its turns in a
 *               period; 0: none
 *   ignore      tests that vanish at the very start, as bits; cleared after the first step */
#define RIC_CARRIED                                                                                \
    double definite[RIC_N_TEST], step, step_max, wanted, after, longest, lowest, blind,            \
        blind_at[2], crowded_at[2], leap_at, refused[2];                                           \
    int32_t unresolved, approaches, avoided, steep, has_past, on_mode, on_turns;                   \
    uint32_t ignore;
typedef struct {
    RIC_CARRIED
} ric_carried;

/* A tongue that was stepped over, between a point and the next one, with the widest resonance in it
 * and how many others there are. */
typedef struct {
    int32_t point, mode, turns, others; /* mode: of all, from 1 */
} ric_leap;

typedef struct {
    ric_shooting *chain; /* owned */
    const ric_limits *limits;
    union {
        ric_carried carried;
        struct {
            RIC_CARRIED /* the same members by their own names */
        };
    };
    ric_floquet floquet;
    int n_resonance;
    ric_resonance *resonances;
    double *passed; /* [n_resonance] last value of the test of each that was not lost in rounding */
    ric_station now, next, mid, past;
    ric_event_samples samples;
    ric_known_pairs known;
    ric_solved_orbits solved;
    bool may_gain; /* orbits of this word may have more symmetry than the form (symmetric_end.h) */
    double *du, *guess, *start_u, *start_t;
    double too_long; /* length of the shortest step from `now` that was refused */
    /* what was found */
    int n_point, point_capacity;
    size_t stride; /* doubles: ric_point, then u */
    double *points;
    int n_event, event_capacity;
    ric_event *events; /* interior ones, in order */
    int n_gap;
    ric_leap *gaps; /* in order */
    ric_event end;  /* what stopped the branch (end.test = -1: no event) */
    ric_stop stop;
    bool arrival; /* the end is a point where the branch meets its own mirror image */
    ric_why why;
    long evaluations;
} ric_continuation;

/* Point i; its unknowns follow it. */
static inline const ric_point *ric_continuation_row(const ric_continuation *trace, int i)
{
    return (const ric_point *)(trace->points + (size_t)i * trace->stride);
}
/* How many points lie up to an arclength. */
int ric_continuation_points_until(const ric_continuation *trace, double s);
/* The arclength at which the orbit u [n_unknown] ends a branch of which points are stored beyond
 * that of tr->end, as its place was read off cubics: those behind u, along the branch, are given
 * back, and the last that is left is as far from its end as from u. */
double ric_continuation_place_end(ric_continuation *trace, const double *u);

/* What is kept of a point of a step: tests, resonances, the factors A, B, D, smooth where their
 * tests jump, and pairs. */
static inline int ric_continuation_watched(const ric_continuation *trace)
{
    return RIC_N_TEST + trace->n_resonance +
           (int)(sizeof trace->now.factor / sizeof *trace->now.factor) + trace->chain->n;
}
/* Room for the stations of a trace that has its chain and its resonances. */
ric_status ric_continuation_equip(ric_continuation *trace);
/* Takes over `chain`. Starts at u0 (a solution, or close to one) in the direction t0 (oriented; it
 * is replaced by the kernel there, but for a singular start). */
ric_status ric_continuation_create(ric_shooting *chain, const double *u0, const double *t0,
                                   unsigned ignore, const ric_limits *limits,
                                   ric_continuation **out);
void ric_continuation_free(ric_continuation *trace);
/* A trace that has come to its end makes no more steps: what it has room for beside what it has
 * found goes, which is most of a short one. */
void ric_continuation_rest(ric_continuation *trace);

/* All that a step changes and the next one reads, but for the stations: those of the last two steps
 * are left alone until a step has succeeded (ric_continuation_advance). */
typedef struct {
    ric_carried carried;
    double scale;
    int32_t n_point, n_event, n_past, n_gap;
} ric_continuation_place;

ric_continuation_place ric_continuation_mark(const ric_continuation *trace);
/* Takes the energies a and b at both ends of a step into a range; first: the range is that of the
 * step. */
void ric_continuation_widen(bool first, double a, double b, double range[2]);
/* Undoes what a step has done that was broken off. */
void ric_continuation_return(ric_continuation *trace, const ric_continuation_place *place);

/* One step; *done when the branch has ended. Nothing is allocated unless an event is found or the
 * point array grows. */
ric_status ric_continuation_advance(ric_continuation *trace, bool *done);
/* Steps to the end; or to RIC_E_INTERRUPTED (halt.h), and then the trace stands where its last step
 * ended and can be run again, with the same outcome. */
ric_status ric_continuation_run(ric_continuation *trace);

/* The orbit at the unknowns u of the trace's chain, flown there; symmetries are those of the form.
 * NULL: no memory. */
ric_periodic *ric_continuation_cycle(const ric_continuation *trace, const double *u);
/* What a test beyond RIC_N_TEST stands for; NULL if it is no resonance. */
const ric_resonance *ric_continuation_resonance(const ric_continuation *trace, int test);
/* On which side of resonance k a station is: the sign; 0 and NAN as of ric_resonance_side. And what
 * later steps are to know of the sides. */
double ric_continuation_side(const ric_continuation *trace, int k, const ric_station *station);
void ric_continuation_remember(ric_continuation *trace, const ric_station *station);
/* The resonances that are watched on chains like this one; false: no memory. */
bool ric_continuation_resonances(ric_continuation *trace);

/* What a test beyond the resonances looks for; NULL for other tests. */
const ric_user_point *ric_continuation_user_point(const ric_continuation *trace, int test);

/* Everything that a stored point says of the orbit at station->u, and whether it is solved; the
 * chain is left evaluated there. Its test functions, and stability next to another branch, are the
 * caller's. */
ric_status ric_continuation_fill(ric_continuation *trace, double s, ric_station *station);
/* Stores a point of the branch. One that is not solved is none, nor is one that penetrates a stop
 * by more than rounding, as the orbit of a junction may by which several gaps close within its
 * tolerance, nor one that meets a face from behind. All points of a branch come by here, but for
 * the last one, which the orbit of its junction may replace. */
ric_status ric_continuation_keep(ric_continuation *trace, const ric_station *station);
/* Whether some face is met from behind, by more than rounding. */
bool ric_continuation_goes_wrong(const ric_continuation *trace, const ric_station *station);
/* The orbit at u becomes the end of the branch, stored if it is solved. */
ric_status ric_continuation_end_at(ric_continuation *trace, const double *u);

/* Newton from u onto the curve within the plane normal . (u - origin) = target; normal NULL: the
 * nearest point. True when converged. */
bool ric_continuation_correct(ric_shooting *chain, double *u, const double *origin,
                              const double *normal, double target, double *du, int *iterations);
#define RIC_MARGIN 1e-11 /* margins that count as rounding */

/* Least speed of approach of the impacts; `springs`: of the closings and openings too. */
double ric_continuation_approach(const ric_shooting *chain, bool springs);
/* What an orbit has to spare, scaled: the largest gap in flight over the clearance (reach.h), the
 * least speed of its impacts, and of springs too; its period and its energy. */
typedef struct {
    double reach, approach, closing, time, energy;
} ric_margins;
/* At u, where the chain has been flown. */
ric_margins ric_continuation_margins(const ric_shooting *chain, const double *u);
/* The orbit of the last flight as it is stored and shown. */
ric_point ric_continuation_point(const ric_shooting *chain, const ric_floquet *floquet,
                                 const ric_margins *margins, double arclength);
/* Stability, from multipliers just computed at u where the chain has been evaluated, with the error
 * of the orbit itself: undecided where that may count. */
ric_status ric_continuation_judge(ric_shooting *chain, const double *u, ric_floquet *floquet);
/* Whether that error may count, so that there is something to judge. */
bool ric_continuation_doubtful(const ric_shooting *chain, const ric_floquet *floquet);
/* A stop is met without speed. What it adds to the map is 0/0: where that has a limit, it depends
 * on how speeds vanish beside it, and orbits that are the same but for rounding, which have any
 * speed, or pass the stop by, may agree on any trace. */
bool ric_continuation_still(const ric_shooting *chain);
/* How far unknowns may be moved to say anything of an orbit: no bound but under a power law, where
 * what is farther may take seconds to fly. */
double ric_continuation_beside(const ric_shooting *chain);
/* Unknowns that are the same orbit as u but for rounding, from the last evaluation, there: each
 * within its own, and all of them by what the residual leaves open across the curve, where the
 * Jacobian is least, and as far along it: beside a branch point rounding exchanges the two. In
 * several ways, out [RIC_TRACE_WAYS * n_unknown]. False: nothing is known of how far that is. */
enum { RIC_TRACE_WAYS = 4 };
bool ric_continuation_move(const ric_shooting *chain, const double *u, double *out);
/* The multipliers of the orbit at u with the flag and the error of each, that of the orbit counted:
 * unknowns within their rounding, and what the residual leaves open. Measured, with a margin:
 * several flights. Pairs of which less than three digits are left are lost. */
ric_status ric_continuation_multipliers(ric_shooting *chain, const double *u, ric_floquet *floquet);
/* Newton from u onto the curve, to an orbit that is the same but for rounding. False: it does not
 * converge, or leads to another one. */
bool ric_continuation_correct_beside(ric_shooting *chain, double *u);
/* Whether an orbit counts as solved: nothing but rounding is left of the residual of the last
 * flight. */
bool ric_continuation_solved(const ric_shooting *chain);
/* What flights round to, relative to the size, and the residual that counts as that for a chain. */
double ric_continuation_rounding(const ric_shooting *chain);
double ric_continuation_tolerance(const ric_shooting *chain);
/* Error of dE/ds (relative to the scale) or dT/ds at the last evaluation: the kernel vector is
 * known to rounding over the smallest pivot. */
double ric_continuation_blur(const ric_shooting *chain, int test);
/* The slope along t at the last evaluation, relative to the scale; and its error there, u with the
 * kernel vector t, as far as it counts beside a slope: the orbits are flown that are the same but
 * for rounding. */
double ric_continuation_slope(const ric_shooting *chain, int test, const double *t);
double ric_continuation_slope_error(ric_shooting *chain, const double *u, const double *t, int test,
                                    double slope);
/* Unit kernel vector at the last evaluation, oriented along `along` (NULL: as it comes). Returns
 * its orientation sign. */
double ric_continuation_tangent(const ric_shooting *chain, const double *along, double *t);
/* Test functions and point data at a station whose chain has just been evaluated at station->u with
 * tangent station->t. What costs most is left out, NAN, unless it is looked at: the reach; the
 * multipliers; the factors of the map, of which tests are made; the slopes of energy and of period,
 * whose errors may have to be measured. RIC_LOOK_FOR: only for what is passed, so that multipliers
 * need not be known to rounding. */
enum {
    RIC_LOOK_REACH = 1,
    RIC_LOOK_PAIRS = 2,
    RIC_LOOK_FACTORS = 4,
    RIC_LOOK_ENERGY = 8,
    RIC_LOOK_PERIOD = 16,
    RIC_LOOK_ALL = 31,
    RIC_LOOK_FOR = 32
};
ric_status ric_continuation_look(ric_continuation *trace, ric_station *station, double orientation,
                                 unsigned at);

#endif
