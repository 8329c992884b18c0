#include "likeness.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"

#define TOUCH 1e-6 /* speed of an impact over 1 + that of the motion: a junction is solved to much more */

typedef struct {
    int face;
    double time;
    double *w; /* [2n] behind the impact */
} moment;

typedef struct {
    const ric_enclosure *e;
    int n, count;
    moment *at;
    double *states;
    double period;
} story;

static double middle(const arb_t x)
{
    return arf_get_d(arb_midref(x), ARF_RND_NEAR);
}

static double along(const ric_enclosure *e, int face, const double *x)
{
    double sum = 0;
    arb_srcptr c = ric_enclosure_c(e, e->wall[face].contact);
    for (int i = 0; i < e->n; i++) sum += middle(c + i) * x[i];
    return sum;
}

/* The motion run backwards, behind the same impact: (q, -Q p). */
static void turn(const ric_enclosure *e, int face, double *w)
{
    arb_srcptr c = ric_enclosure_c(e, e->wall[face].contact);
    const double push = 2 * along(e, face, w + e->n) / middle(e->cc + e->wall[face].contact);
    for (int i = 0; i < e->n; i++) w[e->n + i] = push * middle(c + i) - w[e->n + i];
}

static void add(story *s, int face, double time, const double *w)
{
    moment *m = &s->at[s->count];
    *m = (moment){face, time, s->states + (size_t)s->count * 2 * s->n};
    memcpy(m->w, w, (size_t)(2 * s->n) * sizeof *w);
    s->count++;
}

/* Impacts `first`.. `last` once more as their image, a time later. */
static void add_image(story *s, int last, double later)
{
    for (int i = 0; i < last; i++) {
        const moment from = s->at[i];
        add(s, s->e->wall[from.face].mirror, from.time + later, from.w);
        for (int j = 0; j < 2 * s->n; j++) s->at[s->count - 1].w[j] = -from.w[j];
    }
}

/* The way back from the mirror point at time `end`. */
static void add_back(story *s, double end, bool centre)
{
    for (int i = s->count - 1; i >= 0; i--) {
        const moment from = s->at[i];
        if (from.time <= 0 || from.time >= end) continue;
        add(s, centre ? s->e->wall[from.face].mirror : from.face, 2 * end - from.time, from.w);
        turn(s->e, from.face, s->at[s->count - 1].w);
        for (int j = 0; j < 2 * s->n && centre; j++) s->at[s->count - 1].w[j] = -s->at[s->count - 1].w[j];
    }
}

static void tell_chain(story *s, const ric_chain *c)
{
    double *w = ric_calloc((size_t)(2 * s->n), sizeof *w), time = 0;
    arb_ptr flown = _arb_vec_init(2 * s->n);
    for (int k = 0; k < c->m && w; k++) {
        arb_srcptr block = ric_chain_block(c, k);
        for (int i = 0; i < 2 * s->n; i++) w[i] = middle(block + i);
        if (c->face[k] >= 0) add(s, c->face[k], time, w);
        time += middle(block + 2 * s->n);
    }
    const double end = time;
    if (c->end == RIC_CHAIN_IMPACT && w) {
        arb_srcptr block = ric_chain_block(c, c->m - 1);
        ric_chain_fly(s->e, block, block + 2 * s->n, flown);
        ric_chain_reflect(s->e, c->face[c->m], flown + s->n);
        for (int i = 0; i < 2 * s->n; i++) w[i] = middle(flown + i);
        add(s, c->face[c->m], end, w);
    }
    s->period = end * ric_chain_copies(c);
    if (!ric_chain_general(c)) add_back(s, end, c->end == RIC_CHAIN_CENTRE);
    if (ric_chain_symmetric(c)) add_image(s, s->count, s->period / 2);
    _arb_vec_clear(flown, 2 * s->n);
    free(w);
}

/* Without impacts of no speed, unless there is no other. */
static void drop_touches(story *s)
{
    int kept = 0;
    for (int i = 0; i < s->count; i++) {
        double speed = 0;
        for (int j = s->n; j < 2 * s->n; j++) speed = fmax(speed, fabs(s->at[i].w[j]));
        if (fabs(along(s->e, s->at[i].face, s->at[i].w + s->n)) > TOUCH * (1 + speed)) s->at[kept++] = s->at[i];
    }
    if (kept) s->count = kept;
}

/* As the motion runs backwards, from its last impact on. */
static void reverse(story *s)
{
    for (int i = 0; i < s->count; i++) {
        s->at[i].time = s->period - s->at[i].time;
        turn(s->e, s->at[i].face, s->at[i].w);
    }
    for (int i = 0; i < s->count / 2; i++) {
        const moment swap = s->at[i];
        s->at[i] = s->at[s->count - 1 - i];
        s->at[s->count - 1 - i] = swap;
    }
}

static void take_image(story *s)
{
    for (int i = 0; i < s->count; i++) {
        s->at[i].face = s->e->wall[s->at[i].face].mirror;
        for (int j = 0; j < 2 * s->n; j++) s->at[i].w[j] = -s->at[i].w[j];
    }
}

/* The story begun at impact `first`, against what is stored. */
static double compare(const story *s, int first, int letters, const int *word, const double *w, const double *flights)
{
    double worst = 0, size = 1;
    for (int j = 0; j < 2 * s->n; j++) {
        worst = fmax(worst, fabs(w[j] - s->at[first].w[j]));
        size = fmax(size, 1 + fabs(w[j]));
    }
    for (int k = 0; k < letters; k++) {
        const moment *a = &s->at[(first + k) % s->count], *b = &s->at[(first + k + 1) % s->count];
        const double flight = b->time - a->time + (b <= a ? s->period : 0);
        if (a->face != word[k]) return HUGE_VAL;
        worst = fmax(worst, fabs(flight - ldexp(flights[k], s->e->time)));
    }
    if (letters == 0) worst = fmax(worst, fabs(s->period - ldexp(flights[0], s->e->time)));
    return worst / size;
}

static void read_state(const ric_enclosure *e, const double *state, double *w)
{
    arb_mat_t x, q;
    arb_mat_init(x, e->n_dof, 1);
    arb_mat_init(q, e->n, 1);
    for (int part = 0; part < 2; part++) {
        for (slong i = 0; i < e->n_dof; i++) {
            arb_set_d(arb_mat_entry(x, i, 0), state[part * e->n_dof + i]);
            arb_mul_2exp_si(arb_mat_entry(x, i, 0), arb_mat_entry(x, i, 0), part ? -e->time : 0);
        }
        arb_mat_mul(q, e->back, x, e->prec);
        for (slong i = 0; i < e->n; i++) w[part * e->n + i] = middle(arb_mat_entry(q, i, 0));
    }
    arb_mat_clear(x);
    arb_mat_clear(q);
}

/* Whether every face has an image. */
static bool has_images(const ric_enclosure *e)
{
    for (int f = 0; f < e->n_face; f++)
        if (e->wall[f].mirror < 0 || e->wall[f].mirror >= e->n_face) return false;
    return true;
}

double ric_likeness_distance(const ric_chain *c, const ric_enclosure *e, int letters, const int *word,
                             const double *state, const double *flights)
{
    const int most = 4 * (c->m + 1);
    story s = {.e = e, .n = e->n};
    double least = HUGE_VAL, *w = ric_calloc((size_t)(2 * e->n), sizeof *w);
    s.at = ric_calloc((size_t)most, sizeof *s.at);
    s.states = ric_calloc((size_t)(most * 2 * e->n), sizeof *s.states);
    if (w && s.at && s.states) {
        read_state(e, state, w);
        tell_chain(&s, c);
        drop_touches(&s);
        const int images = has_images(e) ? 2 : 1;
        for (int back = 0; back < 2; back++) {
            for (int image = 0; image < images && (letters == s.count || letters == 0); image++) {
                for (int i = 0; i < s.count; i++) least = fmin(least, compare(&s, i, letters, word, w, flights));
                if (images == 2) take_image(&s);
            }
            reverse(&s);
        }
    }
    free(w);
    free(s.at);
    free(s.states);
    return least;
}
