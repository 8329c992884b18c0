/* A chain told as a whole period of its motion: impacts, those of no speed as well, and mirror
 * points in flight. What chains of other classes or words are of the same motion is read from it,
 * and whether a stored orbit is it. */
#ifndef RIC_PROVE_STORY_H
#define RIC_PROVE_STORY_H

#include "chain.h"

typedef struct {
    int face;           /* -1: a mirror point in flight */
    bool opens;         /* a spring that opens there; otherwise it closes, or is a stop */
    bool touch, mirror; /* an impact of exactly no speed; exactly a mirror point */
    arb_t time;
    arb_ptr w; /* [2n] behind the event */
} ric_moment;

typedef struct {
    const ric_enclosure *e;
    int n, count, most;
    ric_moment *at;
    bool symmetric; /* exactly z(t + T/2) = -z(t) */
    double slow;    /* while it is compared: speed, over 1 + that of the motion, of a touch */
    arb_ptr period;
} ric_story;

/* What exactly touches: an impact of no speed, or, in flight, a stop, or a spring that closes and
 * opens at once, or the other way round. */
typedef struct {
    int impact;       /* block that begins with it, m for the end; -1: none */
    int flight, face; /* of one in flight; flight -1: none */
    bool opens;       /* first, of a spring */
    arb_srcptr time;
    const signed char *together; /* [n_contact] sides of stops that touch then, too, or 0: at a
                                    mirror point that the chain begins with; or NULL */
} ric_story_touch;

/* u [m * size]: balls, in place of the centre of the chain; what is told holds the motion in them.
 * touch: NULL: none. */
void ric_story_tell(ric_story *s, const ric_chain *c, arb_srcptr u, const ric_story_touch *touch,
                    const ric_enclosure *e);
/* The same of any numbers, with the state `before` the mirror point that the chain ends with, [2n]:
 * moments and times are linear in all of them. */
void ric_story_tell_parts(ric_story *s, const ric_chain *c, arb_srcptr u, arb_srcptr before,
                          const ric_enclosure *e);
/* Impacts of two contacts at one instant in the other order, the first `most` pairs of them; of
 * reflections that commute it is the same motion. */
void ric_story_exchange(ric_story *s, int most);
/* As a motion that many times as long. */
void ric_story_repeat(ric_story *s, int times);
void ric_story_free(ric_story *s);

/* The largest difference from a stored orbit, over 1 + the size of its state: states behind impacts
 * and flight times, begun at any impact, forwards or backwards, or as the image under x -> -x;
 * impacts of no speed count only where there is no other, nor do those of `slow` over 1 + the speed
 * of the motion. Not finite where no beginning fits. A comparison of doubles: it says what is
 * meant, and proves nothing. word [letters] (openings n_face more), state [2 n_dof], flights
 * [max(letters, 1)] as they are stored. */
double ric_story_distance(ric_story *s, double slow, int letters, const int *word,
                          const double *state, const double *flights);

/* The same of a corner, stored in either order of impacts at one instant, the first `pairs` of
 * them, and with some of its touches as impacts, as a branch may have them. */
double ric_story_corner(ric_story *s, int pairs, double slow, const ric_junction *row);

/* The same motion in the class and with the word of another chain, near its centre: u [m * size +
 * 1] balls; impacts of exactly no speed that its word lacks are passed over, and no others. What is
 * exact of its class, mirror points and x -> -x, has to be so of what was told. false if it has no
 * such place. */
bool ric_story_cut(ric_story *s, const ric_chain *like, double place, arb_ptr u);

/* The moments at which it is cut, in the story run backwards and as its image where that is so. */
typedef struct {
    bool back, image;
    int *moment; /* [m + 1] */
} ric_story_way;

/* The first half of that; to be freed in any case. And the second one, of any story of the same
 * chain. */
bool ric_story_find(ric_story *s, const ric_chain *like, double place, ric_story_way *out);
void ric_story_follow(ric_story *s, const ric_chain *like, const ric_story_way *way, arb_ptr u);
void ric_story_way_free(ric_story_way *way);

#endif
