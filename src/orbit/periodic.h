/* One period of an orbit as a closed list of events: impacts, and the closings and openings of
 * springs, and what maps it to itself. Chains (shooting.h) are made from it and turned back.
 *
 * Impact i is followed by flight i. The group that acts: time shifts (the first impact changes),
 * time reversal, and x -> -x where the structure allows it. On the circle of 2N half positions, 2i
 * is impact i and 2i + 1 the middle of flight i; a reversal that takes impact i to r - i has its
 * mirror points at positions r and r + N. */
#ifndef RIC_ORBIT_PERIODIC_H
#define RIC_ORBIT_PERIODIC_H

#include "shooting.h"

typedef struct {
    int n, N;
    int *face;        /* [N] */
    double *tau;      /* [N] */
    double *w;        /* [2n] state right after impact 0 */
    double *opposite; /* law power: [2n] half a period on, where the solved orbit tells: to fly
                         there may lose digits; else NULL */
    uint64_t closed;  /* springs that are closed after it (flight.h) */
    bool half;        /* z(t+T/2) = -z(t) */
    int pure;         /* reversal i -> pure - i keeps the orbit; -1: none */
    int flip;         /* the same joined with x -> -x; -1: none */
    int parts;        /* law power: of the period, between nodes at which chains let it start anew
                         (shooting_nodes.h), at least; 0: chains have none */
} ric_periodic;

ric_periodic *ric_periodic_create(int n, int N);
/* Room for N events, whose faces and times are to be set; the state stays. False: no memory. */
bool ric_periodic_room(ric_periodic *cycle, int N);
ric_periodic *ric_periodic_copy(const ric_periodic *cycle);
void ric_periodic_free(ric_periodic *cycle);

/* Whether orbits of the structure have events; else they are one flight, in which marks stand for
 * them (periodic_form.h). */
bool ric_periodic_has_events(const ric_model *model);

/* The orbit of a chain at u (evaluated or flown there); symmetries are those of the chain's form.
 * NULL: no memory. */
ric_periodic *ric_periodic_from_chain(const ric_shooting *chain, const double *u);
/* The event from which a chain of the general form starts. */
int ric_periodic_start(const ric_model *model, const ric_periodic *cycle);
/* The chain of the form that the cycle's symmetries allow, and its unknowns, *u allocated. */
ric_status ric_periodic_to_chain(const ric_model *model, const ric_periodic *cycle,
                                 ric_shooting **chain, double **u);
/* These unknowns alone, allocated. NULL: no memory, or no cycle. */
double *ric_periodic_unknowns(const ric_model *model, const ric_periodic *cycle);

/* Springs of a model: bits, one per face. */
uint64_t ric_periodic_springs(const ric_model *model);
/* Impacts of a cycle, a contact of a spring from closing to opening counted as one. */
int ric_periodic_impacts(uint64_t springs, const ric_periodic *cycle);
/* Its letters as they leave the library, [N], or none without impacts: n_face + face where a spring
 * opens. And back: faces, and the springs that are closed. */
void ric_periodic_word(const ric_model *model, const ric_periodic *cycle, int *word);
void ric_periodic_spell(const ric_model *model, ric_periodic *cycle, const int *word);
/* A cycle of a word [letters] and its flight times tau, both as they leave the library but for the
 * unit of time, at state zero; and what a stored branch says of its symmetries. NULL: no memory. */
typedef struct {
    bool symmetric, reversible, centre, rest, impact; /* which kinds of mirror points it has */
} ric_periodic_claim;
ric_periodic *ric_periodic_spelled(const ric_model *model, int letters, const int *word,
                                   const double *tau);
void ric_periodic_claimed(const ric_model *model, const ric_periodic_claim *claim,
                          ric_periodic *cycle);
/* Its flight times as they leave the library, in seconds: one per letter, or the period. */
void ric_periodic_flights(const ric_model *model, const ric_periodic *cycle, double *seconds);
/* The springs that are closed in flight i. */
uint64_t ric_periodic_closed(const ric_model *model, const ric_periodic *cycle, int i);

/* States after every impact [N * 2n]. */
void ric_periodic_states(const ric_model *model, const ric_periodic *cycle, double *W);
/* That after event i alone, w [2n]. */
void ric_periodic_state(const ric_model *model, const ric_periodic *cycle, int i, double *w);
/* State at time t after impact 0, taken modulo the period, w [2n]. */
void ric_periodic_at_time(const ric_model *model, const ric_periodic *cycle, double t, double *w);
double ric_periodic_period(const ric_periodic *cycle);
double ric_periodic_energy(const ric_model *model, const ric_periodic *cycle);

/* Operations that take every motion of the structure to one: below this number, bit 0 for time
 * reversal and bit 1 for x -> -x. A motion that only meets contacts with both sides may have a
 * mirror image, and be its own, in a structure where others have none. */
int ric_periodic_operations(const ric_model *model);
/* The same orbit started at impact `shift`, then run backwards (impact 0 stays first), then
 * mirrored. NULL: no memory, or a face that it meets has no opposite. */
ric_periodic *ric_periodic_transform(const ric_model *model, const ric_periodic *cycle, int shift,
                                     bool reverse, bool mirror);
/* Whether x -> -x takes every face of the orbit to a face. */
bool ric_periodic_mirrors(const ric_model *model, const ric_periodic *cycle);
/* Only the impacts with keep[i]; the others, of no speed, are flown through. At least one is kept.
 * Symmetries that the choice breaks go. */
ric_periodic *ric_periodic_keep(const ric_model *model, const ric_periodic *cycle,
                                const bool *keep);
/* The first N/q impacts of a cycle that repeats itself q times. */
ric_periodic *ric_periodic_shorten(const ric_periodic *cycle, int q);

/* The cycle gone through q times; no symmetries are set. */
ric_periodic *ric_periodic_repeat(const ric_periodic *cycle, int q);

/* Relative distance of two cycles as they stand (same faces needed, else infinity). */
double ric_periodic_distance(const ric_periodic *a, const ric_periodic *b);
/* Whether the word, or a flight time that differs by more than `most`, tells the image under a
 * shift and an operation (of ric_periodic_operations) from the cycle itself; no state is flown. */
bool ric_periodic_apart(const ric_model *model, const ric_periodic *cycle, int shift, int operation,
                        double most);
/* Whether some image of b has the same word as a: without that no operation takes the one to the
 * other. */
bool ric_periodic_alike(const ric_model *model, const ric_periodic *a, const ric_periodic *b);
/* An operation on a cycle, as ric_periodic_transform takes it. */
typedef struct {
    int shift;
    bool reverse, mirror;
} ric_turn;
/* The operation that takes b nearest to a, within `tolerance`: found or not. */
bool ric_periodic_match(const ric_model *model, const ric_periodic *a, const ric_periodic *b,
                        double tolerance, ric_turn *turn);
/* Whether there is one, however it reads. */
bool ric_periodic_same(const ric_model *model, const ric_periodic *a, const ric_periodic *b,
                       double tolerance);
/* Whether the cycle is one of fewer impacts gone through several times. */
bool ric_periodic_repeats(const ric_model *model, const ric_periodic *cycle, double tolerance);
/* The image of `near` under the group that is nearest to `orbit`. NULL: none within `limit`, or no
 * memory. */
ric_periodic *ric_periodic_nearest(const ric_model *model, const ric_periodic *orbit,
                                   const ric_periodic *near, double limit);
/* Symmetries that hold within `tolerance`, and the number q of repetitions (1 = none), found by
 * trying them all. */
int ric_periodic_find_symmetries(const ric_model *model, ric_periodic *cycle, double tolerance);
/* Gives a cycle the symmetries of another that starts at the same event. */
void ric_periodic_take_symmetries(ric_periodic *cycle, const ric_periodic *from);
/* Lexicographic: faces, then state with a tolerance, then flight times. */
int ric_periodic_compare(uint64_t springs, const ric_periodic *a, const ric_periodic *b);
/* Canonical start: smallest word over the whole group, then smallest state (components closer than
 * RIC_SAME_LOCATED count as equal). */
ric_periodic *ric_periodic_canonical(const ric_model *model, const ric_periodic *cycle);

/* Smooth structures (law power): a cycle of `marks` marks, which have no effect, equally far apart
 * in time; false: no memory. */
bool ric_periodic_mark(ric_periodic *cycle, int marks);
/* The same of any structure: events stay as they are. */
bool ric_periodic_divide(const ric_model *model, ric_periodic *cycle, int marks);
/* Sets the state half a period on, w [2n], or forgets it, NULL; false: no memory. */
bool ric_periodic_oppose(ric_periodic *cycle, const double *w);
/* Orbits without mirror points may start at any time. Moves the start of `near` to where it is
 * nearest to that of `orbit`, across the flow there; returns the time that takes. Or by a given
 * time, and across the flow from there. */
double ric_periodic_phase(const ric_model *model, const ric_periodic *orbit, ric_periodic *near);
void ric_periodic_shift(const ric_model *model, const ric_periodic *orbit, double time,
                        ric_periodic *near);
/* The same orbit started half a mark later; false: it has events, and starts at one. */
bool ric_periodic_half_mark(const ric_model *model, ric_periodic *cycle);
/* Moves the start of a neighbour across the flow at that of `orbit`; an event is where it is. */
void ric_periodic_align(const ric_model *model, const ric_periodic *orbit, ric_periodic *near);
/* How often a shorter orbit may be gone through. */
enum { RIC_COPIES = 24 };
/* Letters of its word: N, or none where there are only marks. */
int ric_periodic_letters(const ric_periodic *cycle);

#endif
