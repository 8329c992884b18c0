/* Which zeros of a census are motions, and which of them are one orbit. */
#include <string.h>

#include "base/room.h"
#include "census.h"
#include "monodromy.h"
#include "passage.h"

/* ---------------------------------------------------------------------- motion */

/* The states behind all impacts, each number with a radius that holds it for the zero. */
static void states(const ric_census_find *z, const ric_census_pair *p, ric_ball w[][4])
{
    const double radius = ric_up(z->zero.exists * p->size);
    double error = ric_up(2 * radius);
    ric_ball now[4];
    for (int i = 0; i < 4; i++) now[i] = ric_ball_exact(z->zero.w[i]);
    for (int k = 0; k < z->word.N; k++) {
        ric_ball cosine[2], sine[2];
        memcpy(w[k], now, sizeof now);
        for (int i = 0; i < 4; i++) w[k][i].r = ric_up(now[i].r + error + RIC_CENSUS_SLACK);
        ric_census_turn(p, z->zero.t[k], cosine, sine);
        ric_census_fly(cosine, sine, now);
        ric_census_reflect(&p->face[z->word.face[(k + 1) % z->word.N]], now);
        error = ric_up(error + ric_up(z->zero.exists * (1 + 0x1p-40)) * p->size);
    }
}

/* The ball of Arb of one of doubles. */
static void set_ball(arb_t out, ric_ball x)
{
    arb_t radius;
    arb_init(radius);
    arb_set_d(out, x.m);
    arb_set_d(radius, x.r);
    arb_add_error(out, radius);
    arb_clear(radius);
}

/* The zero as a chain (chain.h): q_i = a_i / omega_i. */
static void make_chain(ric_chain *c, int *face, const ric_phase **phase, const ric_census_find *z,
                       const ric_census_pair *p, ric_ball w[][4])
{
    const int N = z->word.N;
    *c = (ric_chain){.n = 2,
                     .m = N,
                     .size = 5,
                     .sign = 1,
                     .face = face,
                     .phase = phase,
                     .at = -1,
                     .number = -1};
    c->u = _arb_vec_init((slong)N * c->size + 1);
    for (int k = 0; k < N; k++) {
        arb_ptr block = ric_chain_block(c, k);
        for (int i = 0; i < 4; i++) set_ball(block + i, w[k][i]);
        for (int i = 0; i < 2; i++) arb_div(block + i, block + i, p->e->omega + i, p->e->prec);
        set_ball(block + 4, (ric_ball){z->zero.t[k], ric_up(z->zero.exists / p->top)});
    }
    for (int k = 0; k <= N; k++) face[k] = z->word.face[k % N];
}

static void measure(ric_census_find *z, const ric_chain *c, const ric_census_pair *p,
                    const ric_passage *passage)
{
    const ric_enclosure *e = p->e;
    double both[2];
    arb_t x;
    ric_monodromy m;
    arb_init(x);
    ric_monodromy_init(&m);
    ric_monodromy_enclose(&m, c, e, c->u);
    ric_arb_interval(m.trace, z->trace);
    z->stable = m.stable;
    for (int k = 0; k < c->m; k++) arb_add(x, x, ric_chain_block(c, k) + 4, e->prec);
    arb_mul_2exp_si(x, x, -e->time);
    ric_arb_interval(x, z->period);
    ric_arb_interval(passage->approach, both);
    z->approach = ldexp(both[0], (int)e->time);
    ric_monodromy_clear(&m);
    arb_clear(x);
}

/* Scaled x and v behind impact 0. */
static void write_state(ric_census_find *z, const ric_chain *c, const ric_enclosure *e)
{
    z->state = ric_calloc(2 * (size_t)e->n_dof, sizeof *z->state);
    if (!z->state) return;
    arb_t x;
    arb_init(x);
    for (int i = 0; i < 2 * e->n_dof; i++) {
        ric_chain_number(e, c->u, i, x);
        if (i >= e->n_dof) arb_mul_2exp_si(x, x, e->time);
        z->state[i] = arf_get_d(arb_midref(x), ARF_RND_NEAR);
    }
    arb_clear(x);
}

/* Where the last flight comes back to its face, the equations that are solved say t (h(t) - h(0)) /
 * t = 0 of it: of a zero whose last factor is none t is. */
static bool ends_at_once(const ric_census_find *z, const ric_census_pair *p)
{
    const int row = z->word.N;
    ric_census_rows s;
    if (!ric_census_returns(&z->word, row - 1)) return false;
    ric_census_rows_place(&s, p, &z->word, z->zero.t);
    ric_census_rows_centre(&s, z->zero.w);
    const double error = ric_up(s.size[row] * ric_up((2 + row) * z->zero.exists * p->size) +
                                RIC_CENSUS_SLACK);
    return ric_down(fabs(s.residual.m[row]) - s.residual.r[row]) > error;
}

/* Whether some flight surely lasts no time, or the box of the zero has no motion. */
static bool is_ghost(const ric_census_find *z, const ric_census_pair *p)
{
    ric_census_box b;
    if (ends_at_once(z, p)) return true;
    for (int k = 0; k < z->word.N; k++) {
        const double radius = ric_up(z->zero.exists / p->top + fabs(z->zero.t[k]) * DBL_EPSILON);
        b.t[k] = (ric_range){z->zero.t[k] - radius, z->zero.t[k] + radius};
        if (b.t[k].hi < 0) return true;
        if (b.t[k].lo < 0) return false;
    }
    for (int i = 0; i < 4; i++) {
        const double radius = ric_up(z->zero.exists * p->size + fabs(z->zero.w[i]) * DBL_EPSILON);
        b.w[i] = (ric_range){z->zero.w[i] - radius, z->zero.w[i] + radius};
    }
    return !ric_census_box_moves(&b, p, &z->word);
}

/* ----------------------------------------------------------------------- images */

static bool within(double centre, double radius, ric_ball x)
{
    return ric_up(fabs(x.m - centre) + x.r) < ric_down(radius * (1 - 0x1p-20));
}

bool ric_census_is_image(const ric_census_find *a, const ric_census_find *b,
                         const ric_census_pair *p, int shift, bool reverse, bool mirror)
{
    const int N = a->word.N;
    ric_ball w[RIC_CENSUS_IMPACTS][4], *start = w[shift];
    if (N != b->word.N) return false;
    for (int i = 0; i < N; i++) {
        const int at = ((reverse ? shift - i : shift + i) + 2 * N) % N,
                  flight = reverse ? (at + N - 1) % N : at;
        const int face = a->word.face[at];
        if ((mirror ? p->face[face].mirror : face) != b->word.face[i]) return false;
        const ric_ball t = {a->zero.t[flight], ric_up(a->zero.exists / p->top)};
        if (!within(b->zero.t[i], b->zero.unique / p->top, t)) return false;
    }
    states(a, p, w);
    /* backwards: what is before the impact, with its velocity turned, is behind it */
    if (reverse) ric_census_reflect(&p->face[a->word.face[shift]], start);
    for (int i = 0; i < 4; i++) {
        if (mirror != (reverse && i > 1)) start[i].m = -start[i].m;
        if (!within(b->zero.w[i], b->zero.unique * p->size, start[i])) return false;
    }
    return true;
}

bool ric_census_same(const ric_census_find *a, const ric_census_find *b, const ric_census_pair *p)
{
    for (int shift = 0; shift < a->word.N; shift++)
        for (int image = 0; image < (p->mirrored ? 4 : 2); image++)
            if (ric_census_is_image(a, b, p, shift, image & 1, image & 2)) return true;
    return false;
}

/* What a zero is to itself: whether it repeats, is symmetric, is reversible. A face without a
 * mirror image has none that it could be met at, whatever the other faces of the structure have. */
static void find_symmetries(ric_census_find *z, const ric_census_pair *p)
{
    for (int shift = 0; shift < z->word.N; shift++) {
        if (shift) z->repeats = z->repeats || ric_census_is_image(z, z, p, shift, false, false);
        z->reversible = z->reversible || ric_census_is_image(z, z, p, shift, true, false);
        z->symmetric = z->symmetric || ric_census_is_image(z, z, p, shift, false, true);
        z->reversible = z->reversible || ric_census_is_image(z, z, p, shift, true, true);
    }
}

/* ---------------------------------------------------------------------- verdict */

void ric_census_judge(ric_census_find *z, const ric_census_pair *p)
{
    ric_ball w[RIC_CENSUS_IMPACTS][4];
    int face[RIC_CENSUS_IMPACTS + 1];
    const ric_phase *phase[RIC_CENSUS_IMPACTS] = {NULL};
    ric_chain c;
    ric_passage passage;
    z->verdict = RIC_CENSUS_GHOST;
    if (is_ghost(z, p)) return;
    states(z, p, w);
    make_chain(&c, face, phase, z, p, w);
    ric_passage_init(&passage);
    const ric_family family = {.hull = c.u};
    z->verdict = ric_passage_prove(&passage, &c, p->e, &family) ? RIC_CENSUS_ORBIT
                                                                : RIC_CENSUS_OPEN;
    if (z->verdict == RIC_CENSUS_ORBIT) {
        measure(z, &c, p, &passage);
        write_state(z, &c, p->e);
        find_symmetries(z, p);
    }
    ric_passage_clear(&passage);
    _arb_vec_clear(c.u, (slong)c.m * c.size + 1);
}
