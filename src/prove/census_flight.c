#include "census_flight.h"

#include "base/room.h"

/* Every motion that leaves a face is, after one of these times, beyond a face: it has hit one
 * before. */
enum { TIMES = 400, BOXES_MOST = 400000 };
#define SPACING 0.15      /* radians of the faster mode */
#define NARROWEST 0x1p-11 /* of |w|: boxes are not divided further */

typedef struct {
    const ric_census_pair *p;
    double m[RIC_CENSUS_FACES][TIMES][4],
        r[RIC_CENSUS_FACES][TIMES][4]; /* g.a of a face after a time, on w */
    int longest, boxes;
} flights;

static void place_times(flights *z)
{
    for (int k = 0; k < TIMES; k++) {
        ric_ball cosine[2], sine[2];
        ric_census_turn(z->p, (k + 1) * SPACING / z->p->top, cosine, sine);
        for (int f = 0; f < z->p->n_face; f++)
            for (int i = 0; i < 2; i++) {
                const ric_ball a = ric_ball_mul(z->p->face[f].g[i], cosine[i]);
                const ric_ball v = ric_ball_mul(z->p->face[f].g[i], sine[i]);
                z->m[f][k][i] = a.m, z->r[f][k][i] = a.r;
                z->m[f][k][2 + i] = v.m, z->r[f][k][2 + i] = v.r;
            }
    }
}

/* sum of a row on the box of states around w. */
static ric_ball on_box(const double *m, const double *r, const double w[4], double radius)
{
    double error = 0;
    ric_ball x = ric_ball_dot(4, w, m, r);
    for (int i = 0; i < 4; i++) error = ric_up(error + (fabs(m[i]) + r[i]) * radius);
    x.r = ric_up(x.r + error);
    return x;
}

/* A state of the box may have the energy, lie on face f and move away from it. */
static bool may_leave(const ric_census_pair *p, int f, const double w[4], double radius)
{
    const ric_census_face *face = &p->face[f];
    double m[4] = {face->g[0].m, face->g[1].m, 0, 0}, r[4] = {face->g[0].r, face->g[1].r, 0, 0},
           least = 0, most = 0;
    ric_ball place = on_box(m, r, w, radius);
    place = ric_ball_sub(place, face->d);
    if (ric_down(fabs(place.m) - place.r) > RIC_CENSUS_SLACK) return false;
    const double mv[4] = {0, 0, face->c[0].m, face->c[1].m},
                 rv[4] = {0, 0, face->c[0].r, face->c[1].r};
    const ric_ball speed = on_box(mv, rv, w, radius);
    if (ric_down(speed.m - speed.r) > RIC_CENSUS_SLACK) return false;
    for (int i = 0; i < 4; i++) {
        const double near = fmax(0, ric_down(fabs(w[i]) - radius)),
                     far = ric_up(fabs(w[i]) + radius);
        least = ric_down(least + ric_down(near * near));
        most = ric_up(most + ric_up(far * far));
    }
    const double low = ric_down(2 * (p->energy.m - p->energy.r)) - RIC_CENSUS_SLACK;
    return !(least > ric_up(p->size * p->size)) && !(most < low);
}

/* The first of the times after which all motions of the box are beyond a face; TIMES: none. */
static int time_of_hit(const flights *z, const double w[4], double radius)
{
    for (int k = 0; k < TIMES; k++)
        for (int f = 0; f < z->p->n_face; f++) {
            ric_ball h = ric_ball_sub(on_box(z->m[f][k], z->r[f][k], w, radius), z->p->face[f].d);
            if (ric_down(h.m - h.r) > RIC_CENSUS_SLACK) return k;
        }
    return TIMES;
}

/* The box of states |x_i - w_i| <= radius that leave face f. */
static bool bounded(flights *z, int f, const double w[4], double radius)
{
    if (!may_leave(z->p, f, w, radius)) return true;
    const int k = time_of_hit(z, w, radius);
    if (k < TIMES) {
        if (k > z->longest) z->longest = k;
        return true;
    }
    if (radius < NARROWEST * z->p->size || ++z->boxes > BOXES_MOST) return false;
    for (int corner = 0; corner < 16; corner++) {
        double part[4];
        const double half = ric_up(radius / 2);
        for (int i = 0; i < 4; i++) part[i] = w[i] + (corner >> i & 1 ? half : -half);
        if (!bounded(z, f, part, ric_up(half + z->p->size * 0x1p-48))) return false;
    }
    return true;
}

double ric_census_longest_flight(const ric_census_pair *p)
{
    const double start[4] = {0};
    flights *z = ric_calloc(1, sizeof *z);
    bool all = z != NULL;
    if (!z) return HUGE_VAL;
    z->p = p;
    z->longest = -1;
    place_times(z);
    for (int f = 0; f < p->n_face && all; f++) all = bounded(z, f, start, ric_up(p->size));
    const double longest = all ? z->longest < 0 ? 0 : ric_up((z->longest + 1) * SPACING / p->top)
                               : HUGE_VAL;
    free(z);
    return longest;
}
