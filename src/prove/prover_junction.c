/* Junctions as theorems: docs/proofs.md states them. */
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "atlas/room.h"
#include "augmented.h"
#include "both.h"
#include "base/room.h"
#include "certificate.h"
#include "passage.h"
#include "prover_junction.h"
#include "story.h"
#include "twin_chain.h"

enum { MOST_QUESTIONS = 4, PARTS = 64, NEARER = 24 };

#define CLOSE 1e-6 /* a gap, in the first clearance, that is looked at as one that touches */
/* SLOW: speed of an impact, in d and 2^-time s, that is looked at as a touch; the equations decide
 */
#define SLOW 1e-5

/* ----------------------------------------------------------------- questions */

/* What may be at a point of a branch between its ends. A turn by 2 pi p / q in a period is one by
 * half of it, or by that and pi, in half a period of a symmetric orbit. */
static int ask_inside(const ric_junction *row, const ric_chain *c, ric_augmented_question *ask)
{
    int n = 0;
    const bool general = ric_chain_general(c);
    const int p = row->rotation[0], q = row->rotation[1];
    switch (row->kind) {
    case RIC_KIND_EXTREMUM:
        ask[n++] = (ric_augmented_question){.kind = RIC_AUGMENTED_ENERGY};
        break;
    case RIC_KIND_PERIOD_EXTREMUM:
        ask[n++] = (ric_augmented_question){.kind = RIC_AUGMENTED_PERIOD};
        break;
    case RIC_KIND_BRANCH_POINT:
        if (general && c->sign < 0)
            ask[n++] = (ric_augmented_question){.kind = RIC_AUGMENTED_DOUBLE};
        for (int k = 1; k < 4 && !general; k++)
            ask[n++] = (ric_augmented_question){.kind = RIC_AUGMENTED_BREAK,
                                                .broken = {k & 1, k >> 1}};
        break;
    case RIC_KIND_MULTIPLICATION:
        if (q == 2 && general && c->sign > 0)
            ask[n++] = (ric_augmented_question){.kind = RIC_AUGMENTED_DOUBLE};
        else if (q == 2 && !general && !ric_chain_symmetric(c))
            for (int k = 1; k < 3; k++)
                ask[n++] = (ric_augmented_question){.kind = RIC_AUGMENTED_BREAK,
                                                    .broken = {k & 1, k >> 1}};
        else if (q > 1 && ric_chain_symmetric(c))
            for (int k = 0; k < 2; k++)
                ask[n++] = (ric_augmented_question){.kind = RIC_AUGMENTED_TURN,
                                                    .p = p + k * q,
                                                    .q = 2 * q};
        else if (q > 2)
            ask[n++] = (ric_augmented_question){.kind = RIC_AUGMENTED_TURN, .p = p, .q = q};
        break;
    default: break;
    }
    return n;
}

static double speed_at(const ric_enclosure *e, int face, arb_srcptr p)
{
    arb_t x;
    arb_init(x);
    ric_chain_along(e, face, p, x);
    const double speed = fabs(ric_arb_middle(x));
    arb_clear(x);
    return speed;
}

/* The slowest impact of a chain, if it is all but a touch. */
static bool ask_slowest(const ric_chain *c, const ric_enclosure *e, ric_augmented_question *ask)
{
    double least = SLOW;
    arb_ptr flown = _arb_vec_init(2 * e->n);
    for (int k = 0; k <= c->m; k++) {
        if (c->face[k] < 0 || e->wall[c->face[k]].closes || (k == c->m && ric_chain_general(c)))
            continue;
        arb_srcptr block = ric_chain_block(c, k < c->m ? k : c->m - 1);
        if (k == c->m) ric_chain_fly(e, c->phase[k - 1], block, block + 2 * e->n, flown);
        const double speed = speed_at(e, c->face[k], (k < c->m ? block : flown) + e->n);
        if (!(speed < least)) continue;
        least = speed;
        *ask = (ric_augmented_question){.kind = RIC_AUGMENTED_SPEED, .place = k};
    }
    _arb_vec_clear(flown, 2 * e->n);
    return least < SLOW;
}

/* h = gap - s of a face, or its image, at a time of a flight, and h'. */
static void gap_at(const ric_enclosure *e, const ric_chain *c, const ric_augmented_question *ask,
                   double t, double h[2])
{
    const ric_wall *wall = &e->wall[ask->face];
    const ric_phase *phase = c->phase[ask->place];
    const int side = ask->image ? -wall->side : wall->side;
    const bool closed = ric_phase_closed(phase, ask->image ? wall->mirror : ask->face);
    arb_ptr flown = _arb_vec_init(2 * e->n);
    arb_t time, x;
    arb_init(time);
    arb_init(x);
    arb_set_d(time, t);
    ric_chain_fly(e, phase, ric_chain_block(c, ask->place), time, flown);
    for (int k = 0; k < 2; k++) {
        arb_dot(x, NULL, 0, ric_enclosure_c(e, wall->contact), 1, flown + k * e->n, 1, e->n,
                e->prec);
        h[k] = -side * ric_arb_middle(x);
    }
    h[0] += wall->side * ric_arb_middle(wall->gap);
    for (int k = 0; k < 2 && closed; k++) h[k] = -h[k];
    arb_clear(time);
    arb_clear(x);
    _arb_vec_clear(flown, 2 * e->n);
}

/* Instants from .. to of a flight, which has PARTS equal parts: these, or what divides the first
 * part, or the last one, towards the event there in steps that shrink by sqrt(2). */
typedef struct instants {
    enum { ALL, BEHIND_EVENT, BEFORE_EVENT } where;
    int from, to;
} instants;

static double instant(const instants *all, int i, double tau)
{
    if (all->where == ALL) return i * tau / PARTS;
    return all->where == BEHIND_EVENT ? tau / PARTS * pow(2, i / 2.)
                                      : tau - tau / PARTS * pow(2, -i / 2.);
}

/* The least gap of a face in a flight where it is a minimum, if less than *least: `ask` then says
 * when. */
static void look_at(const ric_chain *c, const ric_enclosure *e, const instants *all,
                    ric_augmented_question here, double *least, ric_augmented_question *ask)
{
    enum { HALVINGS = 60 };
    const double tau = ric_arb_middle(ric_chain_block(c, here.place) + 2 * e->n);
    double h[2], before[2];
    gap_at(e, c, &here, instant(all, all->from, tau), before);
    for (int i = all->from + 1; i <= all->to; i++) {
        double from = instant(all, i - 1, tau), to = instant(all, i, tau);
        gap_at(e, c, &here, to, h);
        const bool minimum = before[1] < 0 && h[1] >= 0;
        memcpy(before, h, sizeof h);
        for (int l = 0; l < HALVINGS && minimum; l++) {
            gap_at(e, c, &here, (from + to) / 2, h);
            if (h[1] < 0) from = (from + to) / 2;
            else to = (from + to) / 2;
        }
        if (!minimum || !(fabs(h[0]) < *least)) continue;
        *least = fabs(h[0]);
        here.time = (from + to) / 2;
        *ask = here;
    }
}

/* The same of all faces and their images. */
static void look_at_all(const ric_chain *c, const ric_enclosure *e, int flight, instants all,
                        double *least, ric_augmented_question *ask)
{
    for (int f = 0; f < e->n_face; f++)
        for (int image = 0; image <= ric_chain_imaged(c); image++)
            look_at(c, e, &all,
                    (ric_augmented_question){.kind = RIC_AUGMENTED_TOUCH,
                                             .place = flight,
                                             .face = f,
                                             .image = image},
                    least, ask);
}

/* The flight, face and time at which a gap is least away from the events of its own face; a mirror
 * point may be where it touches. What touches nowhere else may do so right behind an event, or
 * before one: G1_6,4 of beam-lumped in the first 1/145 of a flight. */
static bool ask_nearest(const ric_chain *c, const ric_enclosure *e, ric_augmented_question *ask)
{
    double least = CLOSE;
    for (int k = 0; k < c->m; k++) {
        const bool mirrored = k == 0 && c->face[0] < 0, mirrors = c->face[k + 1] < 0;
        look_at_all(c, e, k, (instants){ALL, mirrored ? -1 : 1, PARTS + mirrors}, &least, ask);
    }
    for (int k = 0; k < c->m && !(least < CLOSE); k++) {
        look_at_all(c, e, k, (instants){BEHIND_EVENT, -NEARER, 0}, &least, ask);
        look_at_all(c, e, k, (instants){BEFORE_EVENT, 0, NEARER}, &least, ask);
    }
    return least < CLOSE;
}

/* The gap of a face, or of its image, at the event that block k begins with, or the chain ends
 * with. */
static double gap_at_event(const ric_enclosure *e, const ric_chain *c, int k, int face, bool image)
{
    const int flight = k < c->m ? k : k - 1;
    const double time = k < c->m ? 0 : ric_arb_middle(ric_chain_block(c, flight) + 2 * e->n);
    double h[2];
    gap_at(e, c, &(ric_augmented_question){.place = flight, .face = face, .image = image}, time, h);
    return h[0];
}

/* The flight of no length, or the contact that is closed at an event of another one. */
static bool ask_corner(const ric_chain *c, const ric_enclosure *e, ric_augmented_question *ask)
{
    double least = CLOSE;
    for (int k = 0; k <= c->m - ric_chain_general(c); k++) {
        if (c->face[k] < 0) continue;
        const int own = e->wall[c->face[k]].contact;
        const double tau = k < c->m ? fabs(ric_arb_middle(ric_chain_block(c, k) + 2 * e->n))
                                    : HUGE_VAL;
        if (tau < CLOSE && c->face[k + 1] >= 0 && e->wall[c->face[k + 1]].contact != own) {
            *ask = (ric_augmented_question){.kind = RIC_AUGMENTED_MEET, .place = k};
            return true;
        }
        for (int f = 0; f < e->n_face; f++)
            for (int image = 0; image <= ric_chain_imaged(c) && e->wall[f].contact != own;
                 image++) {
                const double h = fabs(gap_at_event(e, c, k, f, image));
                if (!(h < least)) continue;
                least = h;
                *ask = (ric_augmented_question){.kind = RIC_AUGMENTED_GAP,
                                                .place = k,
                                                .face = f,
                                                .image = image};
            }
    }
    return least < CLOSE;
}

/* ------------------------------------------------------------------- proofs */

static void measure(const ric_augmented *x, ric_junction_proof *out)
{
    const ric_enclosure *e = x->e;
    double both[2];
    arb_t y;
    arb_init(y);
    ric_chain_energy(e, x->c.phase[0], x->z, y);
    arb_mul_2exp_si(y, y, 2 * e->time - e->mass);
    ric_arb_interval(y, out->energy);
    arb_zero(y);
    for (int k = 0; k < x->c.m; k++) arb_add(y, y, x->z + (slong)k * x->c.size + 2 * e->n, e->prec);
    arb_mul_ui(y, y, (ulong)(x->times * ric_chain_copies(&x->c)), e->prec);
    arb_mul_2exp_si(y, y, -e->time);
    ric_arb_interval(y, out->period);
    arb_clear(y);
    ric_arb_interval(x->exists, both);
    out->exists = both[1];
    ric_arb_interval(x->unique, both);
    out->unique = both[0];
    out->bits = (int)e->prec;
}

static void describe(const ric_augmented *x, ric_junction_proof *out)
{
    static const char *const kinds[] = {"the energy turns", "the period turns"};
    const ric_augmented_question *a = &x->ask;
    if (x->c.start == RIC_CHAIN_BOTH) {
        snprintf(out->how, sizeof out->how, "%s two impacts at one instant",
                 a->kind == RIC_AUGMENTED_BREAK ? "a motion parts" : "a gap touches beside");
        return;
    }
    switch (a->kind) {
    case RIC_AUGMENTED_ENERGY:
    case RIC_AUGMENTED_PERIOD: snprintf(out->how, sizeof out->how, "%s", kinds[a->kind]); break;
    case RIC_AUGMENTED_BREAK:
        snprintf(out->how, sizeof out->how, "a motion breaks %s",
                 a->broken[0] && a->broken[1] ? "both mirrors"
                 : a->broken[0]               ? "the first mirror"
                                              : "the last mirror");
        break;
    case RIC_AUGMENTED_TURN:
        snprintf(out->how, sizeof out->how, "multipliers turn by %d/%d", a->p, a->q);
        break;
    case RIC_AUGMENTED_DOUBLE:
        snprintf(out->how, sizeof out->how, "a motion closes with the other sign");
        break;
    case RIC_AUGMENTED_SPEED: snprintf(out->how, sizeof out->how, "an impact has no speed"); break;
    case RIC_AUGMENTED_TOUCH:
        snprintf(out->how, sizeof out->how, "a gap touches in flight %d", a->place + 1);
        break;
    case RIC_AUGMENTED_GAP:
        snprintf(out->how, sizeof out->how, "a gap closes at an impact on another contact");
        break;
    case RIC_AUGMENTED_MEET:
        snprintf(out->how, sizeof out->how, "flight %d has no length", a->place + 1);
        break;
    }
}

/* Contacts that touch at the same instant as that of the question, as they are images of it: of a
 * linear mode, which the chain from rest to a centre is where its equations are regular, and if no
 * mode is unseen. */
static void find_together(ric_augmented *x)
{
    const ric_enclosure *e = x->e;
    const bool mode = x->c.m == 1 && x->c.face[0] < 0 && x->c.face[1] < 0 &&
                      x->c.start == RIC_CHAIN_REST && x->c.end == RIC_CHAIN_CENTRE &&
                      !x->c.phase[0] && e->n == e->n_dof;
    const int own = e->wall[x->ask.face].contact;
    arb_t s;
    if (x->ask.kind != RIC_AUGMENTED_TOUCH || !mode || !arb_contains_zero(x->z + x->n_orbit))
        return;
    arb_init(s);
    for (int k = 0; k < e->n_contact; k++) {
        if (k == own || !ric_twins_are(e->model, own, k)) continue;
        arb_dot(s, NULL, 0, ric_enclosure_c(e, k), 1, x->z, 1, e->n, e->prec);
        x->together[k] = arb_is_positive(s) ? 1 : arb_is_negative(s) ? -1 : 0;
    }
    arb_clear(s);
}

static void add_closure(ric_corner *corner, int flight, bool end, const ric_wall *wall, bool turned)
{
    corner->at[corner->n++] = (ric_closure){flight, end, wall->contact,
                                            turned ? -wall->side : wall->side, false};
}

/* At a mirror point that is an impact all velocities are along what it kicks: a contact whose
 * normal is orthogonal to that has no speed. */
static bool is_still(const ric_augmented *x)
{
    const ric_chain *c = &x->c;
    const int k = x->ask.place;
    const bool mirror = k == 0 ? c->start == RIC_CHAIN_IMPACT
                               : k == c->m && c->end == RIC_CHAIN_IMPACT;
    return mirror && ric_enclosure_orthogonal(x->e->model, x->e->wall[c->face[k]].contact,
                                              x->e->wall[x->ask.face].contact);
}

/* Where the flights of the chain see a corner; event m of a general chain is event 0, or its image.
 */
static void find_corner(const ric_augmented *x, ric_corner *corner)
{
    const ric_chain *c = &x->c;
    const ric_wall *wall = x->e->wall;
    const int k = x->ask.place;
    const bool around = ric_chain_general(c), turned = around && c->sign < 0;
    *corner = (ric_corner){.empty = -1};
    if (c->start == RIC_CHAIN_BOTH) {
        add_closure(corner, 0, false, &wall[c->also], false);
        return;
    }
    if (x->ask.kind == RIC_AUGMENTED_GAP) {
        if (k < c->m) add_closure(corner, k, false, &wall[x->ask.face], x->ask.image);
        if (k > 0) add_closure(corner, k - 1, true, &wall[x->ask.face], x->ask.image);
        else if (around)
            add_closure(corner, c->m - 1, true, &wall[x->ask.face], x->ask.image != turned);
        for (int i = 0; i < corner->n; i++) corner->at[i].still = is_still(x);
        return;
    }
    corner->empty = k;
    if (k > 0) add_closure(corner, k - 1, true, &wall[c->face[k + 1]], false);
    else if (around) add_closure(corner, c->m - 1, true, &wall[c->face[k + 1]], turned);
    if (k + 1 < c->m) add_closure(corner, k + 1, false, &wall[c->face[k]], false);
    else if (around) add_closure(corner, 0, false, &wall[c->face[k]], turned);
}

static bool stands(const ric_augmented *x, ric_junction_proof *out)
{
    const ric_augmented_question *a = &x->ask;
    const bool touches = a->kind == RIC_AUGMENTED_SPEED || a->kind == RIC_AUGMENTED_TOUCH;
    const bool meets = a->kind == RIC_AUGMENTED_GAP || a->kind == RIC_AUGMENTED_MEET ||
                       x->c.start == RIC_CHAIN_BOTH;
    ric_corner corner;
    if (meets) find_corner(x, &corner);
    const ric_touch touch = {.impact = a->kind == RIC_AUGMENTED_SPEED ? a->place : -1,
                             .flight = a->place,
                             .face = a->face,
                             .image = a->image,
                             .time = x->z + x->n_orbit,
                             .together = x->together};
    ric_passage passage;
    ric_passage_init(&passage);
    const bool done = ric_passage_prove(&passage, &x->c, x->e,
                                        &(ric_family){.hull = x->z,
                                                      .touch = touches ? &touch : NULL,
                                                      .corner = meets ? &corner : NULL});
    snprintf(out->why, sizeof out->why, "%s", passage.why);
    ric_passage_clear(&passage);
    return done;
}

static void tell_once(const ric_augmented *x, ric_story *out)
{
    const ric_augmented_question *a = &x->ask;
    const ric_wall *wall = &x->e->wall[a->face];
    const int face = a->image ? wall->mirror : a->face;
    const bool told = a->kind == RIC_AUGMENTED_TOUCH && face >= 0;
    const ric_story_touch touch = {.impact = a->kind == RIC_AUGMENTED_SPEED ? a->place : -1,
                                   .flight = told ? a->place : -1,
                                   .face = face,
                                   .opens = told && ric_phase_closed(x->c.phase[a->place], face),
                                   .time = x->z + x->n_orbit,
                                   .together = x->together};
    ric_story_tell(out, &x->c, x->z, &touch, x->e);
}

void ric_prover_junction_tell(const ric_augmented *x, ric_story *out)
{
    tell_once(x, out);
    ric_story_repeat(out, x->times);
}

/* What is stored is the orbit that was proved. */
static bool agrees(const ric_augmented *x, const ric_junction *row, ric_junction_proof *out)
{
    const ric_augmented_question *a = &x->ask;
    const double turn = 8 * atan(1), multiple = row->multiple;
    const double period[2] = {turn / out->period[1] / multiple, turn / out->period[0] / multiple};
    ric_story story;
    ric_prover_junction_tell(x, &story);
    out->distance = row->kind == RIC_KIND_CORNER
                        ? ric_story_corner(&story, x->c.start == RIC_CHAIN_BOTH ? 1 : INT_MAX,
                                           a->slow, row)
                        : ric_story_distance(&story, a->slow, row->letters, row->word, row->state,
                                             row->flights);
    ric_story_free(&story);
    const bool near = ric_prover_near(out->energy, row->energy) &&
                      ric_prover_near(period, row->frequency);
    if (!near)
        snprintf(out->why, sizeof out->why,
                 "the stored energy or frequency is not that of the junction");
    else if (!(out->distance <= RIC_PROVER_NEAR))
        snprintf(out->why, sizeof out->why,
                 "the stored orbit is not that of the junction, %.1e away", out->distance);
    return near && out->distance <= RIC_PROVER_NEAR;
}

/* Asks one question near the centre of a chain, and compares with what is stored; `x` is to be
 * freed in any case. */
static bool prove_at(const ric_junction *row, const ric_chain *c, const ric_enclosure *e,
                     const ric_augmented_question *ask, ric_augmented *x, ric_junction_proof *out)
{
    bool done = ric_augmented_prove(x, c, e, ask);
    if (!done) snprintf(out->why, sizeof out->why, "%s", x->why);
    if (done) find_together(x);
    /* what keeps both together, and its other mirror, is gone through twice by the branch */
    if (c->start == RIC_CHAIN_BOTH && !ask->broken[1] && !ric_chain_halved(c)) x->times = 2;
    if (done) measure(x, out);
    done = done && stands(x, out) && agrees(x, row, out);
    if (done) describe(x, out);
    if (done) *out->why = 0;
    return done;
}

/* --------------------------------------------------------------- on a branch */

ric_status ric_prover_junction_inside(ric_walk *w, const ric_junction *row, double at,
                                      ric_augmented *x, ric_chain *chord, ric_junction_proof *out)
{
    ric_augmented_question ask[MOST_QUESTIONS];
    bool made;
    const ric_status status = ric_walk_between(w, at, chord, &made);
    const int n = made ? ask_inside(row, chord, ask) : 0;
    if (!n)
        snprintf(out->why, sizeof out->why,
                 "there are no equations for this kind in the class of its branch");
    for (int i = 0; i < n; i++) {
        ric_augmented_free(x);
        if (!prove_at(row, chord, w->e, &ask[i], x, out)) continue;
        out->state = RIC_PROOF_DONE;
        break;
    }
    return status;
}

/* Where the equations of the branch are singular, as the two impacts at one instant turn the motion
 * round: the branch leaves those that keep them together, or that one of these which touches. */
static void part(const ric_walk *w, const ric_junction *row, ric_augmented *x,
                 ric_junction_proof *out)
{
    ric_augmented_question ask;
    ric_chain general;
    ric_branch plain = w->branch;
    plain.reversible = plain.symmetric = false;
    bool made = !ric_chain_create(&general, w->e, &plain, w->state, w->state + 2 * w->e->n_dof) &&
                ask_corner(&general, w->e, &ask) && ask.kind == RIC_AUGMENTED_MEET;
    const int flight = made ? ask.place : 0;
    for (int way = 0; way < RIC_BOTH_WAYS && made && out->state != RIC_PROOF_DONE; way++) {
        ric_chain c;
        bool broken[2];
        if (ric_both_create(&c, &general, w->e, flight, way, broken)) {
            if (!ask_slowest(&c, w->e, &ask) && !ask_nearest(&c, w->e, &ask))
                ask = (ric_augmented_question){.kind = RIC_AUGMENTED_BREAK};
            memcpy(ask.broken, broken, sizeof broken);
            ask.slow = w->slow;
            ric_augmented_free(x);
            if (prove_at(row, &c, w->e, &ask, x, out)) out->state = RIC_PROOF_DONE;
        }
        ric_chain_free(&c);
    }
    ric_chain_free(&general);
}

ric_status ric_prover_junction_end(ric_walk *w, const ric_junction *row, bool last,
                                   ric_augmented *x, ric_junction_proof *out)
{
    ric_augmented_question ask;
    ric_chain c = {0};
    bool made;
    ric_status status = ric_walk_chain(w, last ? w->branch.n_point - 1 : 0, &c, &made);
    ric_chain shorter = {0};
    const bool corner = row->kind == RIC_KIND_CORNER;
    if (made && !corner &&
        ric_chain_shorten(&shorter, w->e, &w->branch, w->state, w->state + 2 * w->e->n_dof)) {
        ric_chain_free(&c);
        c = shorter;
    }
    if (made && (corner ? ask_corner(&c, w->e, &ask)
                        : ask_slowest(&c, w->e, &ask) || ask_nearest(&c, w->e, &ask))) {
        ric_augmented_free(x);
        ask.slow = w->slow;
        if (prove_at(row, &c, w->e, &ask, x, out)) out->state = RIC_PROOF_DONE;
        else if (corner) part(w, row, x, out);
    } else if (corner)
        snprintf(out->why, sizeof out->why, "no two contacts close at all but one instant");
    else snprintf(out->why, sizeof out->why, "no impact and no gap is all but a touch");
    ric_chain_free(&c);
    return status;
}

/* Where a linear mode touches. */
static void on_linear(const ric_enclosure *e, const double *state, double period,
                      const ric_junction *row, ric_augmented *x, ric_junction_proof *out)
{
    ric_augmented_question ask;
    ric_chain c;
    bool touches = ric_chain_mode(&c, e, state, period) && ask_nearest(&c, e, &ask);
    if (touches && ask.image) { /* from the other place at rest on */
        _arb_vec_neg(c.u, c.u, c.n);
        ask.image = false;
    }
    if (!touches) snprintf(out->why, sizeof out->why, "no gap is all but a touch");
    else {
        ric_augmented_free(x);
        if (prove_at(row, &c, e, &ask, x, out)) out->state = RIC_PROOF_DONE;
    }
    ric_chain_free(&c);
}

/* At the end of its branch: a spring; a stop is touched by the branch that hits it. */
static ric_status on_mode(ric_walk *w, const ric_junction *row, ric_augmented *x,
                          ric_junction_proof *out)
{
    ric_point stored;
    const ric_status status = ric_walk_point(w, w->branch.to == row->id ? w->branch.n_point - 1 : 0,
                                             &stored);
    if (!status) on_linear(w->e, w->state, w->state[2 * w->e->n_dof], row, x, out);
    return status;
}

/* What is asked of a chain of the junction itself, n questions. */
static int ask_itself(const ric_junction *row, const ric_chain *c, const ric_enclosure *e,
                      ric_augmented_question *ask)
{
    return row->kind == RIC_KIND_GRAZING ? ask_nearest(c, e, ask) : ask_inside(row, c, ask);
}

/* A grazing that touches stops at different times, of which a permutation of the structure and the
 * way back make one touch. */
static void on_twins(const ric_enclosure *e, const ric_junction *row, const ric_chain *general,
                     ric_augmented *x, ric_junction_proof *out)
{
    const ric_twin *twin;
    for (int i = 0; out->state != RIC_PROOF_DONE && (twin = ric_twins_get(e->twins, e->model, i));
         i++) {
        ric_augmented_question ask;
        ric_chain c;
        if (ric_twin_chain_create(&c, general, e, twin) && ask_nearest(&c, e, &ask)) {
            ric_augmented_free(x);
            if (prove_at(row, &c, e, &ask, x, out)) out->state = RIC_PROOF_DONE;
        }
        ric_chain_free(&c);
    }
}

/* By what is stored of the junction itself. Of a grazing that is its orbit without touches: in a
 * class with more mirrors than those of the branches that end there, or gone through once where
 * they go through it several times, several touches are one. Of all others it is that of a branch
 * that the atlas need not have. */
static void on_itself(const ric_enclosure *e, const ric_junction *row, ric_augmented *x,
                      ric_junction_proof *out)
{
    ric_augmented_question ask[MOST_QUESTIONS];
    ric_branch branch = {.letters = row->letters, .word = row->word};
    if (row->letters == 0 && row->kind == RIC_KIND_GRAZING)
        on_linear(e, row->state, row->flights[0], row, x, out);
    for (int kind = 3; kind >= 0 && row->letters > 0 && out->state != RIC_PROOF_DONE; kind--) {
        ric_chain c;
        branch.reversible = kind & 2;
        branch.symmetric = kind & 1;
        const bool made = !ric_chain_create(&c, e, &branch, row->state, row->flights);
        const int n = made ? ask_itself(row, &c, e, ask) : 0;
        for (int i = 0; i < n && out->state != RIC_PROOF_DONE; i++) {
            ric_augmented_free(x);
            if (prove_at(row, &c, e, &ask[i], x, out)) out->state = RIC_PROOF_DONE;
        }
        if (made && !kind && row->kind == RIC_KIND_GRAZING) on_twins(e, row, &c, x, out);
        ric_chain_free(&c);
    }
    out->branch = row->n_branch > 0 ? row->branches[0] : 0;
    if (out->state == RIC_PROOF_DONE && row->kind == RIC_KIND_GRAZING) x->times = row->multiple;
}

/* On one of its branches. */
static ric_status on_branch(ric_prover *p, const ric_junction *row, int id, int level,
                            ric_augmented *x, ric_junction_proof *out)
{
    ric_walk w;
    ric_status status = ric_walk_open(&w, p, id, level);
    const bool end = row->kind == RIC_KIND_GRAZING || row->kind == RIC_KIND_CORNER;
    if (!status && w.branch.letters == 0 && end) status = on_mode(&w, row, x, out);
    if (!status && w.branch.letters > 0 && !(status = ric_walk_class(&w)) && w.like.u) {
        if (end && w.branch.from == row->id)
            status = ric_prover_junction_end(&w, row, false, x, out);
        if (!status && end && out->state && w.branch.to == row->id)
            status = ric_prover_junction_end(&w, row, true, x, out);
        for (int i = 0; i < w.branch.n_junction && !status && out->state && !end; i++) {
            ric_chain chord = {0};
            if (w.branch.junctions[i] == row->id)
                status = ric_prover_junction_inside(&w, row, w.branch.junction_at[i], x, &chord,
                                                    out);
            ric_chain_free(&chord);
        }
        out->branch = id;
    }
    ric_walk_close(&w);
    return status;
}

bool ric_prover_junction_asked(const ric_junction *row, const ric_branch *branch)
{
    return row->kind != RIC_KIND_MULTIPLICATION || ric_junction_level(row, branch) == row->multiple;
}

ric_status ric_prover_junction_find(ric_prover *p, const ric_junction *row, int level,
                                    ric_augmented *x, ric_junction_proof *out)
{
    ric_status status = RIC_OK;
    int longest = 0;
    ric_branch branch;
    for (int k = 0; k < row->n_branch; k++)
        if (!ric_atlas_branch(p->atlas, row->branches[k], &branch) && branch.letters > longest)
            longest = branch.letters;
    for (int letters = longest; letters >= 0; letters--)
        for (int k = 0; k < row->n_branch && !status && out->state != RIC_PROOF_DONE; k++)
            if (!ric_atlas_branch(p->atlas, row->branches[k], &branch) &&
                branch.letters == letters && ric_prover_junction_asked(row, &branch))
                status = on_branch(p, row, row->branches[k], level, x, out);
    if (!status && row->kind != RIC_KIND_CORNER && out->state != RIC_PROOF_DONE) {
        ric_junction_proof own = *out;
        on_itself(ric_prover_enclosure(p, level), row, x, &own);
        if (own.state == RIC_PROOF_DONE) *out = own;
    }
    return status;
}

static const char *left_out(const ric_prover *p, const ric_junction *row)
{
    if (p->left_out) return p->left_out;
    switch (row->kind) {
    case RIC_KIND_START:
    case RIC_KIND_USER: return "an ordinary orbit";
    default: return NULL;
    }
}

ric_status ric_prover_junction(ric_prover *p, int id, ric_junction_proof *out)
{
    ric_junction row;
    ric_status status = ric_atlas_junction(p->atlas, id, &row);
    *out = (ric_junction_proof){.junction = id, .state = RIC_PROOF_NONE, .distance = HUGE_VAL};
    snprintf(out->prover, sizeof out->prover, "%s", ric_prover_version());
    *p->certificate = 0;
    if (status) return status;
    const char *why = left_out(p, &row);
    if (why) {
        out->state = RIC_PROOF_LEFT_OUT;
        snprintf(out->why, sizeof out->why, "%s", why);
        return RIC_OK;
    }
    snprintf(out->why, sizeof out->why, "no branch with impacts passes it or ends there");
    for (int level = 0; level < 2 && !status && out->state != RIC_PROOF_DONE; level++) {
        const ric_enclosure *e = ric_prover_enclosure(p, level);
        ric_augmented x = {0};
        if (p->at[level].good) status = ric_prover_junction_find(p, &row, level, &x, out);
        else snprintf(out->why, sizeof out->why, "%s", e->why);
        if (!status && out->state == RIC_PROOF_DONE) {
            free(p->certificate);
            p->certificate = ric_certificate_junction(&x, out);
            if (!p->certificate) status = ric_no_memory("a certificate");
        }
        ric_augmented_free(&x);
    }
    return status;
}
