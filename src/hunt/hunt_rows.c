#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "hunt_line.h"
#include "base/room.h"

/* All orbits, reversible or not: rows of starts, and starts at random, on the section of every face
 * (docs/theory.md section 11).
 *
 * Every start z is flown N impacts. Whenever it is on its first face again, P the map so far and D
 * its matrix, Newton's step d = (I - D)^-1 (P(z) - z) tells how far the orbit would be if P were
 * linear; where that is not far, the motion is the first guess for Newton's method on all impacts
 * at once. What counts is |d| and not how near to itself the motion comes: near an orbit with
 * multiplier lambda P(z) - z is |lambda| times larger. Half orbits, P(z) = -z on the face opposite,
 * are looked for in the same manner.
 *
 * The motions that have the word of an orbit with multiplier lambda fill a strip as narrow as
 * 1/lambda, but as long as the face. Rows cross it, and as they are refined where neighbours part
 * they do not step over it; starts at random find it if it is not too narrow. */

#define FAR 0.15 /* largest |d|, in the size of the face */
#define APART 0.25
#define SHORTEST 1e-13
#define CELLS 256  /* the places z + d that count as one guess for one word, per radius */
#define ATTEMPTS 3 /* at one of them */

typedef struct {
    ric_hunt *hunt;
    int face;
    uint8_t *tried; /* attempts by guess, hashed: two guesses in one place at worst share their
                       attempts */
    size_t mask;
    uint64_t random;
    double p; /* of the present row: P sin(angle) over its largest value */
} search;

/* One more attempt at a guess, unless it has had its share. */
static bool admit(search *g, int N, bool half, const ric_hit *hits, double y, double angle)
{
    uint64_t key = (uint64_t)(2 * N + half);
    for (int k = 0; k < N; k++) key = (key ^ (uint64_t)hits[k].face) * 0x100000001b3u;
    key = (key ^ (uint64_t)(int64_t)floor(y * CELLS)) * 0x9e3779b97f4a7c15u;
    key = (key ^ (uint64_t)(int64_t)floor(angle * CELLS)) * 0x9e3779b97f4a7c15u;
    uint8_t *count = &g->tried[ric_hunt_random(&key) & g->mask];
    if (*count >= ATTEMPTS) return false;
    ++*count;
    return true;
}

/* The motion hits[0..k], at home again at hit k, as a guess; D its matrix. */
static ric_status consider(search *g, int k, bool half, ric_hit *hits, const double *D)
{
    const ric_impact_map_face *face = &g->hunt->section->face[g->face];
    double sign = half ? -1 : 1, a = 1 - sign * D[0], b = -sign * D[1], c = -sign * D[2],
           d = 1 - sign * D[3], det = a * d - b * c;
    double ry = sign * hits[k].y - hits[0].y, ra = sign * hits[k].angle - hits[0].angle;
    double dy = (d * ry - b * ra) / det / face->radius[0], da = (a * ra - c * ry) / det;
    if (!(hypot(dy, da) < FAR)) return RIC_OK;
    double y = (hits[0].y - face->middle) / face->radius[0] + dy, angle = hits[0].angle + da;
    if (fabs(y) > 1 || !admit(g, k, half, hits, y, angle)) return RIC_OK;
    return ric_hunt_try(g->hunt, k, half, hits, RIC_WAY_ROWS);
}

static void chain_rule(const double *step, double *D)
{
    double a = D[0], b = D[1], c = D[2], d = D[3];
    D[0] = step[0] * a + step[1] * c;
    D[1] = step[0] * b + step[1] * d;
    D[2] = step[2] * a + step[3] * c;
    D[3] = step[2] * b + step[3] * d;
}

/* A motion that has been flown. */
static ric_status visit(const ric_line *l, const ric_strand *a)
{
    search *g = l->user;
    const ric_impact_map *s = l->hunt->section;
    const ric_impact_map_face *face = &s->face[g->face];
    double D[4] = {1, 0, 0, 1}, step[4];
    ric_status status = RIC_OK;
    for (int k = 1; k < a->n && !status; k++) {
        if (!ric_impact_map_slope(s, &a->hit[k - 1], &a->hit[k], step)) break;
        chain_rule(step, D);
        if (a->hit[k].face == g->face) status = consider(g, k, false, a->hit, D);
        else if (a->hit[k].face == face->mirror && 2 * k <= l->hunt->options.impacts &&
                 2 * a->time[k] < l->hunt->options.period[1] && ric_model_symmetric(s->model))
            status = consider(g, k, true, a->hit, D);
    }
    return status;
}

/* (y, p) in units of the radii. */
static bool place(const ric_line *l, double y, double p, ric_hit *hit, double *w)
{
    const search *g = l->user;
    const ric_impact_map *s = l->hunt->section;
    const ric_impact_map_face *face = &s->face[g->face];
    *hit = (ric_hit){g->face, face->middle + y * face->radius[0], 0, 0};
    double P = ric_impact_map_speed(s, g->face, hit->y);
    if (!(fabs(p) * face->radius[1] < P)) return false;
    hit->angle = asin(p * face->radius[1] / P);
    return ric_impact_map_state(s, hit, w) && ric_impact_map_inside(s, w, g->face);
}

static bool start_row(const ric_line *l, double y, ric_hit *hit, double *w)
{
    return place(l, y, ((const search *)l->user)->p, hit, w);
}

static bool start_random(const ric_line *l, double unused, ric_hit *hit, double *w)
{
    search *g = l->user;
    double r = sqrt(ric_hunt_uniform(&g->random)), turn = RIC_TWO_PI * ric_hunt_uniform(&g->random);
    (void)unused;
    return place(l, r * cos(turn), r * sin(turn), hit, w);
}

static ric_status search_face(search *g)
{
    ric_hunt *h = g->hunt;
    ric_line line = {.hunt = h,
                     .face = g->face,
                     .K = h->options.impacts + 1,
                     .times = 1,
                     .apart = APART,
                     .shortest = SHORTEST,
                     .start = start_row,
                     .visit = visit,
                     .user = g};
    ric_status status = RIC_OK;
    for (int i = 0; i < h->options.rows && !status; i++) {
        if ((status = ric_hunt_report(h, "rows", (double)i / h->options.rows))) break;
        g->p = 2 * (i + 0.5) / h->options.rows - 1;
        line.high = sqrt(1 - g->p * g->p);
        line.low = -line.high;
        status = ric_hunt_line_scan(&line, h->options.row);
    }
    line.start = start_random;
    RIC_STRAND(a, line.K);
    for (int i = 0; i < h->options.random && !status; i++) {
        if (i % 4096 == 0)
            status = ric_hunt_report(h, "random starts", (double)i / h->options.random);
        ric_hunt_line_fly(&line, 0, &a);
        if (!status) status = visit(&line, &a);
    }
    return status;
}

ric_status ric_hunt_rows(ric_hunt *h)
{
    const ric_impact_map *s = h->section;
    search g = {.hunt = h, .mask = ((size_t)1 << 24) - 1, .random = h->options.seed};
    ric_status status = RIC_OK;
    if (!(g.tried = ric_calloc(g.mask + 1, 1))) return ric_no_memory("the hunt");
    for (int f = 0; f < s->n_face && !status; f++) {
        g.face = f;
        if (s->face[f].radius[0] == 0 || (ric_model_symmetric(s->model) && s->face[f].side < 0))
            continue;
        status = search_face(&g);
    }
    free(g.tried);
    return status;
}
