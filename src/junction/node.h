/* Junctions at work: where branches meet, solved on their own equations from a canonical orbit
 * (docs/theory.md sections 7 to 9). */
#ifndef RIC_JUNCTION_NODE_H
#define RIC_JUNCTION_NODE_H

#include "orbit/room.h"
#include "branch/room.h"
#include "base/room.h"

#define RIC_MAX_TOUCHES 16

typedef enum {
    RIC_DEPARTURE_OPEN,
    RIC_DEPARTURE_TAKEN,
    RIC_DEPARTURE_KNOWN,
    RIC_DEPARTURE_INADMISSIBLE,
    RIC_DEPARTURE_OVER_BUDGET,
    RIC_DEPARTURE_REFUSED
} ric_departure_state;

/* One way out: at a grazing the touches that stay as impacts (bit i: touch i), at a corner the
 * pairs of impacts whose order is exchanged (bit i: pair i), at a branch point the branch that
 * passes (THROUGH) or the one that leaves (SIDE; at a multiplication of even order there are two,
 * with other mirror points: SIDE and OTHER_SIDE; and the image in x -> -x of the first, IMAGE_SIDE,
 * where the structure lacks that symmetry of the orbit and nothing else takes the one to the
 * other; at a doubling with both, what keeps no mirror point). */
enum { RIC_THROUGH = 0, RIC_SIDE = 1, RIC_OTHER_SIDE = 2, RIC_IMAGE_SIDE = 3 };
typedef struct {
    unsigned choice;
    ric_departure_state state;
    char *why;         /* for refused, owned */
    ric_budget budget; /* the one that it exceeds */
    int job;           /* number under which workers prepare it; 0: they do not */
} ric_departure;

/* Whether a choice of a grazing strikes touch `bit`. Where there are more than RIC_MAX_TOUCHES
 * nothing departs, and the only choice strikes none. */
static inline bool ric_node_strikes(unsigned choice, int bit)
{
    return bit < RIC_MAX_TOUCHES && choice >> bit & 1;
}

/* Why no branch leaves a junction at all. */
typedef enum {
    RIC_REFUSAL_NONE,
    RIC_REFUSAL_TOUCHES,
    RIC_REFUSAL_TOGETHER,
    RIC_REFUSAL_OBLIQUE
} ric_refusal;
const char *ric_node_refusal_text(ric_refusal refusal);

typedef struct {
    ric_kind kind;
    ric_periodic *cycle; /* canonical; at a grazing the touches are impacts of no speed, or pairs of
                            switches of a spring with no time between */
    uint64_t springs;    /* faces that are springs */
    int n_touch;
    int touch[RIC_MAX_TOUCHES]; /* their places in the cycle; of a pair, and at a corner, of the
                                   first impact of each pair */
    int test;                   /* which test function vanishes on the branch that passes; -1 */
    int multiple, rotation[2];
    int a, b;
    double energy, period; /* internal units, of the original orbit */
    int n_departure; /* of a grazing or a corner only when ric_grazing_words_list has listed them */
    ric_departure *departures;
    ric_refusal refusal;
    ric_user_point asked; /* of kind user */
    int mode;             /* linear mode that grazes here, from 0; -1 */
    int mixture;          /* or mixture of modes of one frequency, place in the model's list; -1 */
    bool unsought;        /* mixtures of its mode with those of its frequency were left out
                             (ric_mixtures_all) */
    int depth;
    bool expanded; /* its duplicates are listed */
    bool mirrors;  /* x -> -x takes motions of the structure to motions: images of its ways out are
                      no others */
} ric_node;

/* A junction at an orbit, which it takes over, without touches or departures. NULL: no memory. */
ric_node *ric_node_create(const ric_model *model, ric_kind kind, ric_periodic *cycle);
void ric_node_free(ric_node *node);
/* Without the reasons for which departures were refused. NULL: no memory. */
ric_node *ric_node_copy(const ric_node *node);

/* The grazing of linear mode `mode` (index among seen modes). *out = NULL if it has none (zero
 * frequency). */
ric_status ric_node_linear(const ric_model *model, int mode, ric_node **out);
/* That of a mixture of modes of one frequency (mixture.h), by its place in the model's list. */
ric_status ric_node_mixture(const ric_model *model, int mixture, ric_node **out);
/* The eigenspace of a node that is a linear motion, with nothing but touches, of modes of one
 * frequency, or -1: beside it lie other motions that touch, and its problems have a kernel of all
 * of them (switching.c). */
int ric_node_space(const ric_model *model, const ric_node *node);
/* The same grazing gone through `multiple` times. */
ric_status ric_node_duplicate(const ric_model *model, const ric_node *node, int multiple,
                              ric_node **out);
/* The end of a trace that stopped at a grazing, corner or arrival; or an interior event of it.
 * *choice: the departure there that the branch itself is, in terms of the node returned. *out =
 * NULL for events that are no junction. */
ric_status ric_node_grazing(const ric_model *model, const ric_periodic *cycle, ric_node **out);
/* The linear mode that a branch comes to, all its impacts slower and slower; *out = NULL: none. */
ric_status ric_node_mode_together(const ric_model *model, const ric_periodic *cycle,
                                  ric_node **out);
/* Whether a gap of another contact touches at the instant of an impact of a grazing orbit; gaps
 * that touch together in flight are touches like others. */
bool ric_node_coincident(const ric_model *model, const ric_periodic *cycle);
ric_status ric_node_corner(const ric_model *model, const ric_periodic *cycle, ric_node **out);
/* A point of a branch where `test` vanishes; `cycle` with the symmetries of the branch. */
ric_status ric_node_interior(const ric_model *model, const ric_periodic *cycle, int test,
                             ric_node **out);
/* A point of a branch where an energy or a frequency is what was asked for. */
ric_status ric_node_user(const ric_model *model, const ric_periodic *cycle,
                         const ric_user_point *asked, ric_node **out);
/* A regular orbit to start from. */
ric_status ric_node_start(const ric_model *model, const ric_periodic *cycle, ric_node **out);
/* The symmetric orbit that a branch arrives at. */
ric_status ric_node_arrival(const ric_model *model, const ric_periodic *cycle, ric_node **out);

/* Whether a touch is that of a spring, two switches in the cycle. */
bool ric_node_soft(const ric_node *node, int touch);
/* Whether the ways out are subsets: of touches, or of pairs of impacts. */
bool ric_node_chooses(const ric_node *node);
/* Where the rotation number of the orbit passes p / q. */
ric_status ric_node_multiplication(const ric_model *model, const ric_periodic *cycle, int p, int q,
                                   ric_node **out);

/* Whether the way out leads away from the branch that passes; the problem it is solved in; and
 * whether it goes on on the other side. */
bool ric_node_leaves(const ric_node *node, unsigned choice);
/* Whether it is what keeps no mirror point of an orbit that has them, at a doubling where branches
 * that keep one leave in two directions: it is not followed from there. */
bool ric_node_unmirrored(const ric_node *node, unsigned choice);
ric_symmetry ric_node_problem(const ric_node *node, unsigned choice);
bool ric_node_passes(const ric_node *node, unsigned choice);

/* Nodes whose energies are farther apart are not the same: relative, and beside zero as if it were
 * a thousandth. */
static inline double ric_node_near(double energy)
{
    const double low = 1e-3;
    return RIC_SAME_LOCATED * (low + fabs(energy));
}
/* Same orbit (and, unless kinds are both branch points of some sort, the same kind). */
bool ric_node_same(const ric_model *model, const ric_node *a, const ric_node *b);
/* Which way out of a branch point or multiplication a branch is that arrives with `cycle`. */
unsigned ric_node_arrived(const ric_model *model, const ric_node *node, const ric_periodic *cycle);
/* Impacts of the branch that leaves by `choice`. */
int ric_node_impacts(const ric_node *node, unsigned choice);
/* Whether that branch has z(t+T/2) = -z(t). */
bool ric_node_half(const ric_model *model, const ric_node *node, unsigned choice);
/* Regular orbit of a node: a grazing without its touches (NULL with no impact left). */
ric_periodic *ric_node_regular(const ric_model *model, const ric_node *node);
/* The orbit that is stored for a junction: a grazing's is solved without its touches, and gone
 * through once where the junction is a duplicate. *bare: no impact is left, and NULL; NULL
 * otherwise: no memory. */
ric_periodic *ric_node_original(const ric_model *model, const ric_node *node, bool *bare);

#endif
