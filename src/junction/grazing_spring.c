#include "grazing_spring.h"

#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "orbit/room.h"
#include "grazing_words.h"

/* The force of a spring is continuous, so that a family of orbits goes on smoothly through a
 * grazing: with x along the family that does not know of the touches, gap i passes its face by
 * alpha_i x, and the spring, closed for sqrt(8 alpha_i x / |s''|), gives back an impulse of order
 * x^(3/2) only. So beyond the grazing exactly those springs are met for which alpha_i x > 0: one
 * way out on either side, whatever is found at some distance. For stiff springs that distance is
 * short, and a trial step would land on orbits that do not join this one. */

#define STEP 1e-6     /* of the size of the orbit: difference that gives the slopes alpha */
#define NO_SLOPE 1e-5 /* of the size of the normal: a slope below it has no certain sign */
#define SIMPLE 1e-6   /* smallest pivot of a kernel of one dimension */
#define ALONG 0.99    /* cosine of that kernel with the direction expected */
#define NO_TIME 1e-7  /* scaled time that counts as none */

typedef struct {
    double alpha, bend; /* of one touch: slope along the family, |s''| */
    const double *w;    /* [2n] state there */
    int face;
} touch;

bool ric_grazing_spring_applies(const ric_node *node)
{
    for (int i = 0; i < node->n_touch; i++)
        if (ric_node_soft(node, i)) return true;
    return false;
}

/* Time of event `place` of the node's cycle after the event `first`. */
static double time_between(const ric_periodic *c, int first, int place)
{
    double sum = 0;
    for (int i = first; i != place; i = (i + 1) % c->N) sum += c->tau[i];
    return sum;
}

/* The slopes along the family without the touches, whose orbit is `regular` and starts at event
 * `first` of the node's cycle. */
static ric_status slopes_of(const ric_model *m, const ric_node *node, const ric_periodic *regular,
                            int first, touch *touches, ric_outset *family)
{
    int n = m->n;
    double w[2][2 * n];
    ric_turn turn;
    ric_status status = ric_outset_open(m, regular, family);
    if (status) return status;
    ric_shooting *c = family->chain;
    const double h = STEP * c->scale;
    double *moved = ric_calloc((size_t)c->n_unknown, sizeof *moved);
    ric_periodic *side[2] = {NULL, NULL};
    if (!moved) return ric_no_memory("a departure");
    ric_shooting_evaluate(c, family->u);
    if (!(c->smallest > SIMPLE)) {
        status = ric_fail(RIC_E_NUMERIC, "the orbit at the grazing is a branch point of the family "
                                         "without the touch; such grazings are not left by "
                                         "this version");
        goto out;
    }
    ric_continuation_tangent(c, NULL, family->t);
    if (!ric_turn_find(m, c, family->u, regular, &turn)) {
        status = ric_fail(RIC_E_NUMERIC,
                          "the family without the touches could not be followed at its grazing");
        goto out;
    }
    for (int k = 0; k < 2; k++) {
        for (int j = 0; j < c->n_unknown; j++)
            moved[j] = family->u[j] + (k ? h : -h) * family->t[j];
        if (!(side[k] = ric_turn_cycle(m, c, moved, &turn))) status = ric_no_memory("a departure");
    }
    for (int i = 0; i < node->n_touch && !status; i++) {
        const ric_face *face = &m->face[touches[i].face];
        double time = time_between(node->cycle, first, node->touch[i]);
        for (int k = 0; k < 2; k++) ric_periodic_at_time(m, side[k], time, w[k]);
        touches[i].alpha *= face->side * (ric_gap(n, face, w[1]) - ric_gap(n, face, w[0])) /
                            (2 * h);
    }
out:
    ric_periodic_free(side[0]);
    ric_periodic_free(side[1]);
    free(moved);
    return status;
}

/* States [n_touch * 2n] and what belongs to every touch; alpha = +-1 tells on which side of the
 * face the gap is. */
static bool find_touches(const ric_model *m, const ric_node *node, double *W, touch *touches)
{
    const ric_periodic *c = node->cycle;
    int n = m->n;
    double *all = ric_calloc((size_t)c->N * 2 * (size_t)n, sizeof *all);
    if (!all) return false;
    ric_periodic_states(m, c, all);
    for (int i = 0; i < node->n_touch; i++) {
        int place = node->touch[i];
        double rate[2 * n];
        uint64_t closed = ric_periodic_closed(m, c, place);
        const ric_face *face = &m->face[c->face[place]];
        memcpy(W + 2 * n * i, all + 2 * n * place, 2 * (size_t)n * sizeof *W);
        ric_flight_rate(m, closed, all + 2 * n * place, rate);
        bool closes = closed >> c->face[place] &
                      1; /* the first event of the pair does: the gap is open around it */
        touches[i] = (touch){.alpha = closes ? 1 : -1,
                             .bend = fabs(ric_dot(n, face->c, rate + n)),
                             .w = W + 2 * n * i,
                             .face = c->face[place]};
    }
    free(all);
    return true;
}

/* The side of the family, +-1, on which the touches that are passed are those of `choice`; 0 if
 * there is none. */
static int side_of(const ric_node *node, const touch *touches, unsigned choice)
{
    for (int side = 1; side >= -1; side -= 2) {
        bool fits = true;
        for (int bit = 0; bit < node->n_touch * node->multiple; bit++)
            fits = fits &&
                   (side * touches[bit % node->n_touch].alpha > 0) == ric_node_strikes(choice, bit);
        if (fits) return side;
    }
    return 0;
}

/* Whether w is the state of a touch, or of its image run backwards or mirrored. */
static bool is_touch(const ric_model *m, const touch *t, int face, const double *w)
{
    for (int op = 0; op < ric_periodic_operations(m); op++) {
        double sign = op & 2 ? -1 : 1, back = op & 1 ? -1 : 1, off = 0, size = 1;
        if (face != (op & 2 ? m->face[t->face].mirror : t->face)) continue;
        for (int i = 0; i < m->n; i++) {
            off = fmax(off, fmax(fabs(w[i] - sign * t->w[i]),
                                 fabs(w[m->n + i] - sign * back * t->w[m->n + i])));
            size = fmax(size, fmax(fabs(w[i]), fabs(w[m->n + i])));
        }
        if (off <= RIC_SAME_EXTRAPOLATED * size) return true;
    }
    return false;
}

/* To first order only the times of the touches change: a contact grows by sqrt(alpha / |s''|), at
 * the cost of the flights beside it. */
static bool grow(const ric_model *m, const ric_node *node, const touch *touches, ric_outset *out)
{
    const ric_shooting *c = out->chain;
    const double *u = out->u;
    double *t0 = out->t;
    int found = 0;
    for (int k = 0; k < c->n_flight; k++) {
        if (!ric_shooting_touches(c, k) || fabs(u[c->n_start + k]) > NO_TIME) continue;
        bool from_rest = c->face[k] < 0, to_rest = c->face[k + 1] < 0;
        int face = from_rest ? c->face[k + 1] : c->face[k], i = 0;
        while (i < node->n_touch && !is_touch(m, &touches[i], face, c->w + 2 * m->n * k)) i++;
        if (i == node->n_touch) return false;
        double half = sqrt(fabs(touches[i].alpha) / touches[i].bend);
        t0[c->n_start + k] += from_rest || to_rest ? half : 2 * half;
        if (!from_rest) t0[c->n_start + k - 1] -= half;
        if (!to_rest) t0[c->n_start + k + 1] -= half;
        found++;
    }
    return found > 0;
}

static ric_status direction(const ric_model *m, const ric_node *node, const touch *touches,
                            ric_outset *out, bool *singular)
{
    ric_shooting *c = out->chain;
    int size = c->n_unknown;
    double kernel[size], *t0 = out->t;
    ric_shooting_evaluate(c, out->u);
    if (!grow(m, node, touches, out))
        return ric_fail(RIC_E_NUMERIC,
                        "a touch of a spring is not found in the problem of the departure");
    double norm = sqrt(ric_dot(size, t0, t0));
    *singular = !(c->smallest > SIMPLE);
    for (int i = 0; i < size; i++) t0[i] *= (*singular ? RIC_LEAVING * c->scale : 1) / norm;
    if (*singular) return RIC_OK;
    ric_continuation_tangent(c, t0, kernel);
    if (ric_dot(size, t0, kernel) < ALONG)
        return ric_fail(RIC_E_NUMERIC, "the departure does not lead into the contact that is kept");
    memcpy(t0, kernel, sizeof kernel);
    return RIC_OK;
}

static ric_status leave(const ric_model *m, const ric_node *node, unsigned choice,
                        const touch *touches, ric_outset *out, bool *singular)
{
    ric_periodic *cycle = ric_grazing_words_cycle(m, node, choice);
    ric_status status = ric_outset_open(m, cycle, out);
    ric_periodic_free(cycle);
    return status ? status : direction(m, node, touches, out, singular);
}

ric_status ric_grazing_spring_depart(const ric_model *m, const ric_node *node, unsigned choice,
                                     ric_outset *out, bool *singular)
{
    ric_status status = RIC_OK;
    int n = m->n, first = 0, N = node->cycle->N;
    touch touches[RIC_MAX_TOUCHES];
    double W[RIC_MAX_TOUCHES * 2 * n];
    bool keep[N];
    ric_outset family = {0};
    ric_periodic *regular = NULL;
    *singular = false;
    for (int i = 0; i < node->n_touch; i++)
        if (!ric_node_soft(node, i))
            return ric_fail(RIC_E_NUMERIC, "a stop and a spring are touched by one orbit; such "
                                           "grazings are not left by this version");
    if (!find_touches(m, node, W, touches)) return ric_no_memory("a departure");
    for (int i = 0; i < N; i++) keep[i] = true;
    for (int i = 0; i < node->n_touch; i++)
        keep[node->touch[i]] = keep[(node->touch[i] + 1) % N] = false;
    while (first < N && !keep[first]) first++;
    if (first < N) { /* else a linear mode, whose amplitude grows */
        regular = ric_grazing_words_keep(m, node->cycle, keep);
        status = regular ? slopes_of(m, node, regular, first, touches, &family)
                         : ric_no_memory("a departure");
    }
    for (int i = 0; i < node->n_touch && !status; i++)
        if (fabs(touches[i].alpha) < NO_SLOPE * sqrt(m->face[touches[i].face].cc))
            status = ric_fail(RIC_E_NUMERIC, "the gap of a touch does not change along the family: "
                                             "whether the spring is met is lost in rounding");
    int side = status ? 0 : side_of(node, touches, choice);
    if (side && choice) status = leave(m, node, choice, touches, out, singular);
    else if (side && family.chain) {
        for (int i = 0; i < family.chain->n_unknown; i++) family.t[i] *= side;
        *out = family;
        family = (ric_outset){0};
    }
    ric_periodic_free(regular);
    ric_outset_clear(&family);
    return status;
}
