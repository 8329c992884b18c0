#include "census_scan.h"

#include <string.h>

#include "base/room.h"

/* More than what some tens of roundings and the ends of the tables make of a number of size 1. */
#define ROUNDED 0x1p-40
/* A motion that is not known better than that, of |w|, tells nothing. */
#define LOST 0.7
/* Entries of the table of turns between two looks at a gap, and how many times as far where no hit
 * is looked for. */
enum { STRIDE = 2, FAR = 4 };

/* Motions within `error`, in the Euclidean norm, of the one with the state w. */
typedef struct {
    const ric_census_pair *p;
    double w[4], error;
} bundle;

static double slack(const bundle *z)
{
    return ROUNDED * z->p->size;
}

/* The place of a face beyond its clearance, and its speed outwards, of the motion in the middle at
 * entry k of the table. */
static void look(const bundle *z, const ric_census_face *f, int k, double h[2])
{
    const ric_ball *turn = z->p->turns + 4 * (ptrdiff_t)k;
    h[0] = -f->d.m;
    h[1] = 0;
    for (int i = 0; i < 2; i++) {
        const double c = turn[i].m, s = turn[2 + i].m, a = z->w[i], v = z->w[2 + i];
        h[0] += f->g[i].m * (c * a + s * v);
        h[1] += f->c[i].m * (c * v - s * a);
    }
}

/* |w'| of the middle, which its flight keeps. */
static double speed_of(const bundle *z)
{
    double sum = 0;
    for (int i = 0; i < 2; i++)
        sum += z->p->omega[i].m * z->p->omega[i].m *
               (z->w[i] * z->w[i] + z->w[2 + i] * z->w[2 + i]);
    return sqrt(sum) * (1 + ROUNDED) + z->p->top * slack(z);
}

/* Whether all motions of the bundle have passed some face at entry k: no flight is longer. */
static bool passes(const bundle *z, int k)
{
    double h[2];
    for (int f = 0; f < z->p->n_face; f++) {
        const ric_census_face *face = &z->p->face[f];
        look(z, face, k, h);
        if (h[0] > face->g_size * (z->error + slack(z)) + slack(z)) return true;
    }
    return false;
}

/* Whether no motion of the bundle comes to face f at a time within `half` of entry k, or all move
 * away from it. */
static bool misses(const bundle *z, const ric_census_face *f, int k, double half, double turning)
{
    double h[2];
    look(z, f, k, h);
    const double away = z->error + slack(z), bend = f->c_size * turning * half;
    const double place = f->g_size * away + (fabs(h[1]) + bend / 2) * half + slack(z);
    return fabs(h[0]) > place * (1 + ROUNDED) ||
           -h[1] > (f->c_size * away + bend + slack(z)) * (1 + ROUNDED);
}

/* What is left of the time of a flight to face f; false: nothing. */
static bool narrow(const bundle *z, const ric_census_face *f, ric_range *t)
{
    const double spacing = z->p->spacing, half = STRIDE * spacing / 2, turning = speed_of(z);
    double first = HUGE_VAL, last = -HUGE_VAL;
    int k = 0;
    for (; k * spacing + 2 * half * FAR < t->lo && k < z->p->n_turn; k += STRIDE * FAR)
        if (k && passes(z, k)) return false;
    for (; k * spacing - half <= t->hi; k += STRIDE) {
        if (k >= z->p->n_turn) return true;
        if (k && passes(z, k)) {
            if (k * spacing < t->hi) t->hi = k * spacing;
            if (!misses(z, f, k, half, turning)) last = k * spacing; /* up to there */
            if (last == k * spacing) first = fmin(first, k * spacing - half);
            break;
        }
        if (k * spacing + half < t->lo || misses(z, f, k, half, turning)) continue;
        first = fmin(first, k * spacing - half);
        last = k * spacing + half;
    }
    if (first > last) return false;
    if (first > t->lo) t->lo = first;
    if (last < t->hi) t->hi = last;
    return !(t->lo > t->hi);
}

static void reflect(bundle *z, const ric_census_face *f)
{
    const double along = f->turn.m * (f->c[0].m * z->w[2] + f->c[1].m * z->w[3]);
    for (int i = 0; i < 2; i++) z->w[2 + i] -= along * f->c[i].m;
    z->error = ric_up(z->error + slack(z));
}

static void turn_round(bundle *z)
{
    z->w[2] = -z->w[2];
    z->w[3] = -z->w[3];
}

/* The flight of a time that is known to be in a range. */
static void fly(bundle *z, ric_range t)
{
    ric_ball c[2], s[2];
    z->error = ric_up(z->error + ric_census_box_radius(t) * speed_of(z) * (1 + ROUNDED) + slack(z));
    ric_census_turn(z->p, ric_census_box_middle(t), c, s);
    for (int i = 0; i < 2; i++) {
        const double a = z->w[i], v = z->w[2 + i];
        z->w[i] = c[i].m * a + s[i].m * v;
        z->w[2 + i] = c[i].m * v - s[i].m * a;
    }
}

static bool is_lost(const bundle *z)
{
    return !(z->error < LOST * z->p->size);
}

static bool are_apart(const bundle *x, const bundle *y)
{
    double square = 0;
    for (int i = 0; i < 4; i++) square += (x->w[i] - y->w[i]) * (x->w[i] - y->w[i]);
    return sqrt(square) * (1 - ROUNDED) > ric_up(x->error + y->error + 2 * slack(x));
}

/* Whether a state of the box may have the energy, lie on the face of event 0, and leave it. */
static bool may_leave(const ric_census_box *b, const ric_census_pair *p, const ric_census_face *f)
{
    double place = -f->d.m, speed = 0, place_off = 0, speed_off = 0, least = 0, most = 0;
    for (int i = 0; i < 4; i++) {
        const double m = ric_census_box_middle(b->w[i]), r = ric_census_box_radius(b->w[i]);
        const double near = fmax(0, fabs(m) - r), far = fabs(m) + r;
        if (i < 2) place += f->g[i].m * m, place_off += fabs(f->g[i].m) * r;
        else speed += f->c[i - 2].m * m, speed_off += fabs(f->c[i - 2].m) * r;
        least += near * near;
        most += far * far;
    }
    const double rest = ROUNDED * p->size, whole = 2 * p->energy.m;
    if (fabs(place) > place_off * (1 + ROUNDED) + rest || speed > speed_off * (1 + ROUNDED) + rest)
        return false;
    return !(least > whole * (1 + ROUNDED)) && !(most < whole * (1 - ROUNDED));
}

bool ric_census_scan(ric_census_box *b, const ric_census_pair *p, const ric_census_word *word)
{
    const int N = word->N;
    bundle z = {.p = p}, ahead[RIC_CENSUS_IMPACTS];
    double square = 0;
    int known = 0; /* behind the events before that */
    if (!may_leave(b, p, &p->face[word->face[0]])) return false;
    if (!p->n_turn) return true;
    for (int i = 0; i < 4; i++) {
        const double radius = ric_census_box_radius(b->w[i]);
        z.w[i] = ric_census_box_middle(b->w[i]);
        square = ric_up(square + radius * radius);
    }
    z.error = ric_up(sqrt(square));
    const bundle start = z;
    for (; known < N && !is_lost(&z); known++) {
        const ric_census_face *next = &p->face[word->face[(known + 1) % N]];
        ahead[known] = z;
        if (!narrow(&z, next, &b->t[known])) return false;
        fly(&z, b->t[known]);
        reflect(&z, next);
    }
    if (known == N && are_apart(&z, &start)) return false;
    z = start;
    reflect(&z, &p->face[word->face[0]]);
    turn_round(&z);
    for (int k = N - 1; k >= 0 && !is_lost(&z); k--) {
        const ric_census_face *before = &p->face[word->face[k]];
        if (!narrow(&z, before, &b->t[k])) return false;
        fly(&z, b->t[k]);
        bundle there = z;
        turn_round(&there);
        if (k < known && are_apart(&there, &ahead[k])) return false;
        reflect(&z, before);
    }
    return true;
}
