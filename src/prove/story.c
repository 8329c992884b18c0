#include "story.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "twin_chain.h"

/* ------------------------------------------------------------------ telling */

/* A moment of what `like` says, at another time and in another state. */
static ric_moment *add(ric_story *s, const ric_moment *like, const arb_t time, arb_srcptr w)
{
    ric_moment *m = &s->at[s->count++];
    m->face = like->face;
    m->opens = like->opens;
    m->touch = like->touch;
    m->mirror = like->mirror;
    arb_set(m->time, time);
    _arb_vec_set(m->w, w, 2 * s->n);
    return m;
}

/* The motion run backwards, behind the same impact: (q, -Q p); in flight, and where a spring
 * switches, (q, -p). */
static void turn(const ric_story *s, ric_moment *m)
{
    if (m->face >= 0 && s->e->wall[m->face].closes) m->opens = !m->opens;
    if (m->face >= 0) ric_chain_reflect(s->e, m->face, m->w + s->n);
    _arb_vec_neg(m->w + s->n, m->w + s->n, s->n);
}

static void negate(const ric_story *s, ric_moment *m)
{
    if (m->face >= 0) m->face = s->e->wall[m->face].mirror;
    _arb_vec_neg(m->w, m->w, 2 * s->n);
}

/* Under x -> -x, or the permutation of the chain. */
static void imagine(const ric_story *s, const ric_chain *c, ric_moment *m)
{
    if (!c->twin) {
        negate(s, m);
        return;
    }
    if (m->face >= 0) m->face = c->twin->face[m->face];
    ric_twin_chain_image(s->e, c->twin, m->w);
}

/* All that was told once more as its image, half a period later. */
static void add_image(ric_story *s, const ric_chain *c)
{
    arb_t time;
    arb_init(time);
    for (int i = 0, last = s->count; i < last; i++) {
        arb_mul_2exp_si(time, s->period, -1);
        arb_add(time, time, s->at[i].time, s->e->prec);
        imagine(s, c, add(s, &s->at[i], time, s->at[i].w));
    }
    arb_clear(time);
}

/* The way back from the mirror point at the end, without that itself and the beginning. */
static void add_back(ric_story *s, const ric_chain *c, int first, const arb_t end)
{
    arb_t time;
    arb_init(time);
    for (int i = s->count - 2; i > first; i--) {
        arb_mul_2exp_si(time, end, 1);
        arb_sub(time, time, s->at[i].time, s->e->prec);
        ric_moment *m = add(s, &s->at[i], time, s->at[i].w);
        turn(s, m);
        if (ric_chain_turned(c->end)) imagine(s, c, m);
    }
    arb_clear(time);
}

/* Room for so many moments. */
static void widen_story(ric_story *s, int most)
{
    if (most <= s->most) return;
    s->at = flint_realloc(s->at, (size_t)most * sizeof *s->at);
    for (; s->most < most; s->most++) {
        s->at[s->most] = (ric_moment){.face = -1, .w = _arb_vec_init(2 * s->n)};
        arb_init(s->at[s->most].time);
    }
}

static void open_story(ric_story *s, const ric_chain *c, const ric_enclosure *e)
{
    *s = (ric_story){.e = e, .n = e->n};
    widen_story(s, 8 * (c->m + 4 + e->n_contact));
    s->period = _arb_vec_init(1);
}

void ric_story_free(ric_story *s)
{
    if (!s->at) return;
    for (int i = 0; i < s->most; i++) {
        arb_clear(s->at[i].time);
        _arb_vec_clear(s->at[i].w, 2 * s->n);
    }
    flint_free(s->at);
    _arb_vec_clear(s->period, 1);
    s->at = NULL;
}

/* Along flight k, with what is left open of it. */
static void fly(const ric_enclosure *e, const ric_chain *c, int k, arb_srcptr block,
                const arb_t time, arb_ptr flown)
{
    arb_t slack;
    arb_init(slack);
    ric_chain_fly(e, c->phase[k], block, time, flown);
    ric_chain_slack(e, c->phase[k], block, time, slack);
    for (slong i = 0; i < 2 * e->n; i++) arb_add_error(flown + i, slack);
    arb_clear(slack);
}

/* The mirror point that a chain ends with; `before`: the state in front of it, or NULL. */
static void add_end(ric_story *s, const ric_chain *c, arb_srcptr block, arb_srcptr before,
                    const arb_t time, bool touch)
{
    const ric_enclosure *e = s->e;
    arb_ptr flown = _arb_vec_init(2 * s->n);
    if (before) _arb_vec_set(flown, before, 2 * s->n);
    else fly(e, c, c->m - 1, block, block + 2 * s->n, flown);
    if (c->face[c->m] >= 0) ric_chain_reflect(e, c->face[c->m], flown + s->n);
    const bool mirror = c->end != RIC_CHAIN_TWIN;
    add(s, &(ric_moment){.face = c->face[c->m], .touch = touch, .mirror = mirror}, time, flown);
    _arb_vec_clear(flown, 2 * s->n);
}

/* Whether it touches at the mirror point at which the chain begins, or ends. */
static bool touches_first(const ric_chain *c, const ric_story_touch *touch)
{
    return touch->flight == 0 && c->face[0] < 0 && arb_contains_zero(touch->time);
}

static bool touches_last(const ric_chain *c, const ric_story_touch *touch, arb_srcptr block)
{
    return touch->flight == c->m - 1 && c->face[c->m] < 0 &&
           arb_overlaps(touch->time, block + 2 * c->n);
}

/* A mirror point in flight at which a stop is touched is an impact of no speed. */
static void make_impact(ric_moment *m, int face)
{
    m->face = face;
    m->touch = true;
}

/* The other stops that are touched at the mirror point with which the chain begins; how many. */
static int add_together(ric_story *s, const ric_story_touch *touch, arb_srcptr block)
{
    arb_t start;
    int count = 0;
    arb_init(start);
    for (int f = 0; f < s->e->n_face && touch->together; f++) {
        if (touch->together[s->e->wall[f].contact] != s->e->wall[f].side) continue;
        add(s, &(ric_moment){.face = f, .touch = true, .mirror = true}, start, block);
        count++;
    }
    arb_clear(start);
    return count;
}

/* The first of two impacts that turn the motion round together, with which the chain begins. */
static void add_first(ric_story *s, const ric_chain *c, arb_srcptr block, const arb_t time)
{
    arb_ptr between = _arb_vec_init(2 * s->n);
    _arb_vec_set(between, block, 2 * s->n);
    ric_chain_reflect(s->e, c->face[0], between + s->n);
    add(s, &(ric_moment){.face = c->also}, time, between);
    _arb_vec_clear(between, 2 * s->n);
}

/* A spring that is touched in flight closes and opens at once, or the other way round; at a mirror
 * point one of the two is on its far side. A stop is an impact of no speed, and at a mirror point
 * that itself. */
static void add_touch(ric_story *s, const ric_chain *c, const ric_story_touch *touch,
                      arb_srcptr block, const arb_t time)
{
    const bool first = touches_first(c, touch), last = touches_last(c, touch, block);
    const bool spring = s->e->wall[touch->face].closes;
    if (first && !spring) make_impact(&s->at[0], touch->face);
    if ((first || last) && !spring) return;
    arb_ptr flown = _arb_vec_init(2 * s->n);
    arb_t at;
    arb_init(at);
    fly(s->e, c, touch->flight, block, touch->time, flown);
    arb_add(at, time, first ? at : last ? block + 2 * s->n : touch->time, s->e->prec);
    for (int k = first; k < (spring ? 2 - last : 1); k++)
        add(s,
            &(ric_moment){.face = touch->face, .opens = spring && touch->opens != k, .touch = true},
            at, flown);
    arb_clear(at);
    _arb_vec_clear(flown, 2 * s->n);
}

static void tell(ric_story *s, const ric_chain *c, arb_srcptr u, arb_srcptr before,
                 const ric_story_touch *touch, const ric_enclosure *e)
{
    const bool general = ric_chain_general(c), both = c->start == RIC_CHAIN_BOTH;
    int together = both;
    arb_t time;
    open_story(s, c, e);
    arb_init(time);
    if (both) add_first(s, c, u, time);
    for (int k = 0; k < c->m; k++) {
        arb_srcptr block = u + (slong)k * c->size;
        const ric_moment here = {.face = c->face[k],
                                 .opens = ric_chain_opens(c, e, k),
                                 .touch = touch && k == touch->impact,
                                 .mirror = !general && k == 0 && c->start != RIC_CHAIN_TWIN &&
                                           !both};
        add(s, &here, time, block);
        if (touch && touch->flight == k) add_touch(s, c, touch, block, time);
        if (touch && touch->flight == k && touches_first(c, touch))
            together = add_together(s, touch, block);
        arb_add(time, time, block + 2 * s->n, e->prec);
    }
    arb_mul_ui(s->period, time, (ulong)ric_chain_copies(c), e->prec);
    if (!general) {
        add_end(s, c, u + (slong)(c->m - 1) * c->size, before, time,
                touch && touch->impact == c->m);
        const arb_srcptr block = u + (slong)(c->m - 1) * c->size;
        const bool last = touch && touch->flight >= 0 && touches_last(c, touch, block);
        if (last && !e->wall[touch->face].closes) make_impact(&s->at[s->count - 1], touch->face);
        add_back(s, c, together, time);
    }
    s->symmetric = ric_chain_symmetric(c);
    if (ric_chain_halved(c)) add_image(s, c);
    arb_clear(time);
}

void ric_story_tell(ric_story *s, const ric_chain *c, arb_srcptr u, const ric_story_touch *touch,
                    const ric_enclosure *e)
{
    tell(s, c, u, NULL, touch, e);
}

void ric_story_tell_parts(ric_story *s, const ric_chain *c, arb_srcptr u, arb_srcptr before,
                          const ric_enclosure *e)
{
    tell(s, c, u, before, NULL, e);
}

void ric_story_repeat(ric_story *s, int times)
{
    const int count = s->count;
    arb_t time;
    arb_init(time);
    widen_story(s, times * count);
    for (int k = 1; k < times; k++)
        for (int i = 0; i < count; i++) {
            arb_mul_ui(time, s->period, (ulong)k, s->e->prec);
            arb_add(time, time, s->at[i].time, s->e->prec);
            add(s, &s->at[i], time, s->at[i].w);
        }
    arb_mul_ui(s->period, s->period, (ulong)times, s->e->prec);
    s->symmetric = s->symmetric && times % 2;
    arb_clear(time);
}

/* Whether moment j, that after i, is an impact of another contact at the same instant. */
static bool meets(const ric_story *s, int i, int j)
{
    const ric_moment *a = &s->at[i], *b = &s->at[j];
    if (a->face < 0 || b->face < 0 || a->touch || b->touch) return false;
    if (s->e->wall[a->face].contact == s->e->wall[b->face].contact) return false;
    arb_t time;
    arb_init(time);
    arb_sub(time, b->time, a->time, s->e->prec);
    if (j < i) arb_add(time, time, s->period, s->e->prec);
    const bool meets = arb_contains_zero(time);
    arb_clear(time);
    return meets;
}

void ric_story_exchange(ric_story *s, int most)
{
    for (int i = 0; i < s->count && s->count > 2 && most > 0; i++) {
        const int j = (i + 1) % s->count;
        if (!meets(s, i, j)) continue;
        most--;
        ric_moment *a = &s->at[i], *b = &s->at[j];
        _arb_vec_set(b->w, a->w, 2 * s->n);
        ric_chain_reflect(s->e, a->face, b->w + s->n); /* before both */
        ric_chain_reflect(s->e, b->face, b->w + s->n);
        _arb_vec_set(a->w, b->w, 2 * s->n);
        ric_chain_reflect(s->e, a->face, b->w + s->n);
        const int face = a->face;
        const bool opens = a->opens;
        a->face = b->face;
        a->opens = b->opens;
        b->face = face;
        b->opens = opens;
        i++;
    }
}

/* As the motion runs backwards, from its last moment on. */
static void reverse(ric_story *s)
{
    for (int i = 0; i < s->count; i++) {
        arb_sub(s->at[i].time, s->period, s->at[i].time, s->e->prec);
        turn(s, &s->at[i]);
    }
    for (int i = 0; i < s->count / 2; i++) {
        const ric_moment swap = s->at[i];
        s->at[i] = s->at[s->count - 1 - i];
        s->at[s->count - 1 - i] = swap;
    }
}

static void take_image(ric_story *s)
{
    for (int i = 0; i < s->count; i++) negate(s, &s->at[i]);
}

/* Whether every face has an image. */
static int count_images(const ric_enclosure *e)
{
    for (int f = 0; f < e->n_face; f++)
        if (e->wall[f].mirror < 0 || e->wall[f].mirror >= e->n_face) return 1;
    return 2;
}

/* --------------------------------------------------------------- comparing */

/* Impacts, or touches: those of exactly no speed, or all that are that slow. */
static bool is_counted(const ric_story *s, int i, bool touches)
{
    const ric_moment *m = &s->at[i];
    double speed = 0;
    arb_t x;
    if (m->face < 0) return false;
    if (m->touch || s->slow == 0) return m->touch == touches;
    for (int j = s->n; j < 2 * s->n; j++) speed = fmax(speed, fabs(ric_arb_middle(m->w + j)));
    arb_init(x);
    ric_chain_along(s->e, m->face, m->w + s->n, x);
    const bool slow = fabs(ric_arb_middle(x)) <= s->slow * (1 + speed);
    arb_clear(x);
    return slow == touches;
}

/* The next moment that counts behind moment i, which may be that itself. */
static int next_counted(const ric_story *s, int i, bool touches)
{
    for (int k = 1; k <= s->count; k++)
        if (is_counted(s, (i + k) % s->count, touches)) return (i + k) % s->count;
    return i;
}

static double size_of(const ric_story *s, arb_srcptr w)
{
    double size = 1;
    for (int j = 0; j < 2 * s->n; j++) size = fmax(size, 1 + fabs(ric_arb_middle(w + j)));
    return size;
}

/* How far moment i is from a stored state, of its size. */
static double differs(const ric_story *s, int i, arb_srcptr w)
{
    double worst = 0;
    for (int j = 0; j < 2 * s->n; j++)
        worst = fmax(worst, fabs(ric_arb_middle(w + j) - ric_arb_middle(s->at[i].w + j)));
    return worst / size_of(s, w);
}

/* The story begun at moment `first`, against what is stored. */
static double compare(const ric_story *s, int first, int letters, const int *word, arb_srcptr w,
                      const double *flights)
{
    const double size = size_of(s, w);
    double worst = differs(s, first, w);
    int a = first;
    for (int k = 0; k < letters; k++) {
        const int b = next_counted(s, a, false);
        const double flight = ric_arb_middle(s->at[b].time) - ric_arb_middle(s->at[a].time) +
                              (b <= a ? ric_arb_middle(s->period) : 0);
        if (s->at[a].face + (s->at[a].opens ? s->e->n_face : 0) != word[k]) return HUGE_VAL;
        worst = fmax(worst, fabs(flight - ldexp(flights[k], s->e->time)) / size);
        a = b;
    }
    if (letters == 0)
        worst = fmax(worst, fabs(ric_arb_middle(s->period) - ldexp(flights[0], s->e->time)) / size);
    return worst;
}

static double compare_all(ric_story *s, int letters, const int *word, arb_srcptr w,
                          const double *flights)
{
    double least = HUGE_VAL;
    int count = 0;
    const int images = count_images(s->e);
    for (int i = 0; i < s->count; i++) count += is_counted(s, i, false);
    for (int back = 0; back < 2; back++) {
        for (int image = 0; image < images; image++) {
            for (int i = 0; i < s->count && letters == count; i++)
                if (is_counted(s, i, letters == 0))
                    least = fmin(least, compare(s, i, letters, word, w, flights));
            if (images == 2) take_image(s);
        }
        reverse(s);
    }
    return least;
}

double ric_story_distance(ric_story *s, double slow, int letters, const int *word,
                          const double *state, const double *flights)
{
    arb_ptr w = _arb_vec_init(2 * s->n);
    ric_chain_state(s->e, state, w);
    s->slow = slow;
    const double least = compare_all(s, letters, word, w, flights);
    _arb_vec_clear(w, 2 * s->n);
    return least;
}

double ric_story_corner(ric_story *s, int pairs, double slow, const ric_junction *row)
{
    enum { MOST = 6 };
    int touch[MOST], n = 0;
    double least = HUGE_VAL;
    for (int i = 0; i < s->count && n < MOST; i++)
        if (s->at[i].touch && s->at[i].face >= 0) touch[n++] = i;
    for (int order = 0; order < 2; order++) {
        for (unsigned choice = 0; choice < 1u << n; choice++) {
            for (int k = 0; k < n; k++) s->at[touch[k]].touch = !(choice >> k & 1);
            least = fmin(least, ric_story_distance(s, n ? 0 : slow, row->letters, row->word,
                                                   row->state, row->flights));
        }
        for (int k = 0; k < n; k++) s->at[touch[k]].touch = true;
        ric_story_exchange(s, pairs);
    }
    return least;
}

/* ----------------------------------------------------------------- cutting */

/* Whether a moment may stand at the end of a chain, or between its blocks, where that has the face:
 * a mirror point that is an impact of no speed is one at rest in flight, too. */
static bool has_face(const ric_moment *m, int face, bool opens)
{
    return (m->face == face && m->opens == opens) || (face < 0 && m->touch && m->mirror);
}

/* The moment that is `later` than moment `first`, with that face, or -1: a chain may go through the
 * motion several times. */
static int find_moment(const ric_story *s, int first, double later, int face, bool opens,
                       double *place)
{
    const double period = ric_arb_middle(s->period);
    int best = -1;
    for (int i = 0; i < s->count; i++) {
        const double gone = fmod(ric_arb_middle(s->at[i].time) - ric_arb_middle(s->at[first].time) +
                                     2 * period,
                                 period);
        const double far = fabs(gone - fmod(later, period)),
                     off = fmin(far, fabs(far - period)) / (1 + period);
        if (!has_face(&s->at[i], face, opens) || !(off < *place)) continue;
        *place = off;
        best = i;
    }
    return best;
}

/* Whether all that lies between two moments is no impact. */
static bool is_flight(const ric_story *s, int from, int to)
{
    for (int k = 1; k <= s->count; k++) {
        const int i = (from + k) % s->count;
        if (i == to) return true;
        if (s->at[i].face >= 0 && !s->at[i].touch) return false;
    }
    return false;
}

/* From moment `first` on: how far it is from the centre of the chain, not finite where it is none
 * of that class. */
static double cut_from(const ric_story *s, int first, const ric_chain *like, double place,
                       int *moment)
{
    const bool general = ric_chain_general(like);
    double time = 0, worst = differs(s, first, like->u);
    if (!has_face(&s->at[first], like->face[0], ric_chain_opens(like, s->e, 0)) ||
        !(general ? like->sign > 0 || s->symmetric : s->at[first].mirror))
        return HUGE_VAL;
    moment[0] = first;
    for (int k = 0; k < like->m && worst < place; k++) {
        double off = place;
        time += ric_arb_middle(ric_chain_block(like, k) + 2 * s->n);
        const int next = moment[k + 1] = find_moment(s, first, time, like->face[k + 1],
                                                     ric_chain_opens(like, s->e, k + 1), &off);
        if (next < 0 || !is_flight(s, moment[k], next)) return HUGE_VAL;
        if (k + 1 == like->m && !general && !s->at[next].mirror) return HUGE_VAL;
        if (k + 1 == like->m && general &&
            (next - first + s->count) % s->count != (like->sign > 0 ? 0 : s->count / 2))
            return HUGE_VAL;
        worst = fmax(worst, off);
        if (k + 1 < like->m) worst = fmax(worst, differs(s, next, ric_chain_block(like, k + 1)));
    }
    return worst;
}

bool ric_story_find(ric_story *s, const ric_chain *like, double place, ric_story_way *out)
{
    const int images = count_images(s->e), count = like->m + 1;
    int *moment = flint_calloc((size_t)count, sizeof *moment);
    double least = place;
    out->moment = flint_calloc((size_t)count, sizeof *moment);
    for (int back = 0; back < 2; back++) {
        for (int image = 0; image < images; image++) {
            for (int i = 0; i < s->count; i++) {
                const double off = cut_from(s, i, like, least, moment);
                if (!(off < least)) continue;
                least = off;
                out->back = back;
                out->image = image;
                memcpy(out->moment, moment, (size_t)count * sizeof *moment);
            }
            if (images == 2) take_image(s);
        }
        reverse(s);
    }
    flint_free(moment);
    return least < place;
}

void ric_story_follow(ric_story *s, const ric_chain *like, const ric_story_way *way, arb_ptr u)
{
    if (way->back) reverse(s);
    if (way->image) take_image(s);
    for (int k = 0; k < like->m; k++) {
        const int here = way->moment[k], next = way->moment[k + 1];
        arb_ptr block = u + (slong)k * like->size, tau = block + 2 * s->n;
        _arb_vec_set(block, s->at[here].w, 2 * s->n);
        arb_sub(tau, s->at[next].time, s->at[here].time, s->e->prec);
        if (next <= here) arb_add(tau, tau, s->period, s->e->prec);
    }
    if (way->image) take_image(s);
    if (way->back) reverse(s);
}

void ric_story_way_free(ric_story_way *way)
{
    flint_free(way->moment);
    way->moment = NULL;
}

bool ric_story_cut(ric_story *s, const ric_chain *like, double place, arb_ptr u)
{
    ric_story_way way;
    const bool found = ric_story_find(s, like, place, &way);
    if (found) ric_story_follow(s, like, &way, u);
    ric_story_way_free(&way);
    return found;
}
