#include "census_pair.h"

#include <stdio.h>

#include "base/room.h"

/* Numbers of face f: c = side C of its contact, g = c / omega, d. */
static void place_face(ric_census_pair *p, int f)
{
    const ric_enclosure *e = p->e;
    const ric_wall *wall = &e->wall[f];
    ric_census_face *out = &p->face[f];
    arb_t x, c_square, g_square;
    arb_init(x);
    arb_init(c_square);
    arb_init(g_square);
    out->mirror = wall->mirror;
    for (int i = 0; i < 2; i++) {
        arb_mul_si(x, ric_enclosure_c(e, wall->contact) + i, wall->side, e->prec);
        out->c[i] = ric_ball_of(x);
        arb_addmul(c_square, x, x, e->prec);
        arb_div(x, x, e->omega + i, e->prec);
        out->g[i] = ric_ball_of(x);
        arb_addmul(g_square, x, x, e->prec);
    }
    arb_mul_si(x, wall->gap, wall->side, e->prec);
    out->d = ric_ball_of(x);
    arb_inv(x, c_square, e->prec);
    arb_mul_2exp_si(x, x, 1);
    out->turn = ric_ball_of(x);
    arb_sqrt(x, c_square, e->prec);
    out->c_size = ric_ball_most(ric_ball_of(x));
    arb_sqrt(x, g_square, e->prec);
    out->g_size = ric_ball_most(ric_ball_of(x));
    arb_clear(x);
    arb_clear(c_square);
    arb_clear(g_square);
}

/* 1/2 |w|^2 and |w|. */
static void place_energy(ric_census_pair *p, double energy)
{
    arb_t x;
    arb_init(x);
    arb_set_d(x, energy);
    arb_mul_2exp_si(x, x, p->e->mass - 2 * p->e->time);
    p->energy = ric_ball_of(x);
    arb_mul_2exp_si(x, x, 1);
    arb_sqrt(x, x, p->e->prec);
    p->size = ric_up(ric_ball_most(ric_ball_of(x)) * (1 + RIC_CENSUS_SLACK));
    arb_clear(x);
}

/* Whether what flights of at most that length leave open is far below RIC_CENSUS_SLACK: in a_i =
 * omega_i q_i it is multiplied by at most the ratio of the frequencies, by one of them or divided
 * by it, for each of three derivatives. */
static bool slack_is_small(const ric_census_pair *p, double period)
{
    const ric_enclosure *e = p->e;
    arb_t t, slack, factor;
    arb_init(t);
    arb_init(slack);
    arb_init(factor);
    arb_set_d(t, period);
    ric_enclosure_slack(e, t, slack);
    arb_set(factor, e->top);
    for (int i = 0; i < 2; i++) {
        arb_t inverse;
        arb_init(inverse);
        arb_inv(inverse, e->omega + i, e->prec);
        arb_add_ui(inverse, inverse, 1, e->prec);
        arb_mul(factor, factor, inverse, e->prec);
        arb_clear(inverse);
    }
    arb_pow_ui(factor, factor, 3, e->prec);
    arb_mul(slack, slack, factor, e->prec);
    arb_set_d(factor, RIC_CENSUS_SLACK * 0x1p-20);
    const bool small = arb_lt(slack, factor);
    arb_clear(t);
    arb_clear(slack);
    arb_clear(factor);
    return small;
}

bool ric_census_pair_create(ric_census_pair *p, const ric_enclosure *e, double energy,
                            double period, char why[160])
{
    *p = (ric_census_pair){.e = e, .n_face = e->n_face, .mirrored = true, .longest_period = period};
    snprintf(why, 160,
             "a census is of structures of which the stops see two modes; here they see %d", e->n);
    if (e->n != 2) return false;
    snprintf(why, 160, "a census is of up to %d faces; here are %d", RIC_CENSUS_FACES, e->n_face);
    if (e->n_face > RIC_CENSUS_FACES) return false;
    snprintf(why, 160, "a census needs modes with a frequency above zero");
    if (!arb_is_positive(e->omega) || !arb_is_positive(e->omega + 1)) return false;
    for (int f = 0; f < e->n_face; f++) {
        place_face(p, f);
        p->mirrored = p->mirrored && p->face[f].mirror >= 0;
    }
    place_energy(p, energy);
    for (int i = 0; i < 2; i++) {
        p->omega[i] = ric_ball_of(e->omega + i);
        p->top = fmax(p->top, ric_ball_most(p->omega[i]));
    }
    snprintf(why, 160, "the modes are not enclosed closely enough for periods of that length");
    return slack_is_small(p, period);
}

void ric_census_pair_free(ric_census_pair *p)
{
    free(p->turns);
    p->turns = NULL;
}

/* ------------------------------------------------------------------- motion */

void ric_census_fly(const ric_ball cosine[2], const ric_ball sine[2], ric_ball w[4])
{
    for (int i = 0; i < 2; i++) {
        const ric_ball a = w[i], p = w[2 + i];
        w[i] = ric_ball_add(ric_ball_mul(cosine[i], a), ric_ball_mul(sine[i], p));
        w[2 + i] = ric_ball_sub(ric_ball_mul(cosine[i], p), ric_ball_mul(sine[i], a));
    }
}

ric_ball ric_census_place(const ric_census_face *f, const ric_ball w[4])
{
    return ric_ball_add(ric_ball_mul(f->g[0], w[0]), ric_ball_mul(f->g[1], w[1]));
}

ric_ball ric_census_speed(const ric_census_face *f, const ric_ball w[4])
{
    return ric_ball_add(ric_ball_mul(f->c[0], w[2]), ric_ball_mul(f->c[1], w[3]));
}

void ric_census_reflect(const ric_census_face *f, ric_ball w[4])
{
    const ric_ball turned = ric_ball_mul(f->turn, ric_census_speed(f, w));
    for (int i = 0; i < 2; i++) w[2 + i] = ric_ball_sub(w[2 + i], ric_ball_mul(turned, f->c[i]));
}
