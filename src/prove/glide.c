#include "glide.h"

#include <math.h>

#include "equations.h"

void ric_glide_create(ric_glide *g, int n)
{
    const size_t count = (size_t)n;
    *g = (ric_glide){.n = n};
    g->line = flint_calloc(6 * count, sizeof *g->line);
    g->c = g->line + 4 * count;
    g->square = g->c + count;
    g->omega = flint_calloc(3 * count, sizeof *g->omega);
    g->size = g->omega + count;
    g->swing = g->size + count;
    g->time = _arb_vec_init(RIC_GLIDE_READINGS + 1);
    g->at = flint_calloc((RIC_GLIDE_READINGS + 1) * 6 * count, sizeof *g->at);
}

void ric_glide_free(ric_glide *g)
{
    flint_free(g->line);
    flint_free(g->omega);
    flint_free(g->at);
    _arb_vec_clear(g->time, RIC_GLIDE_READINGS + 1);
}

static double most_of(const arb_t x)
{
    return ric_ball_most(ric_ball_of(x));
}

void ric_glide_board(ric_glide *g, const ric_enclosure *e, arb_srcptr hull, arb_srcptr middle,
                     arb_srcptr half)
{
    const int n = g->n;
    g->e = e;
    g->count = 0;
    for (int i = 0; i < 2 * n; i++) {
        g->line[i] = ric_ball_of(middle + i);
        g->line[2 * n + i] = ric_ball_of(half + i);
    }
    for (int i = 0; i < n; i++) {
        const bool still = arb_is_zero(e->omega + i);
        const double omega = most_of(e->omega + i), q = ric_up(omega * most_of(hull + i)),
                     p = most_of(hull + n + i), size = ric_up(sqrt(ric_up(q * q + p * p)));
        g->square[i] = ric_ball_of(e->square + i);
        g->omega[i] = omega;
        g->swing[i] = ric_up(omega * size);
        g->size[i] = still ? HUGE_VAL : ric_up(size / ric_down(omega * (1 - 0x1p-40)));
    }
}

void ric_glide_place(ric_glide *g, arb_srcptr c, int side, const arb_t d, const arb_t slack)
{
    for (int i = 0; i < g->n; i++) g->c[i] = ric_ball_of(c + i);
    g->side = side;
    g->d = ric_ball_of(d);
    g->slack = most_of(slack);
}

/* Both states turned by the time, and L q of them. */
static const ric_ball *read_at(ric_glide *g, const arb_t time)
{
    const int n = g->n;
    for (int i = 0; i < g->count; i++)
        if (arb_equal(g->time + i, time)) return g->at + (size_t)(6 * n * i);
    ric_enclosure coarse = ric_enclosure_coarse(g->e);
    ric_ball *at = g->at + (size_t)(6 * n * g->count);
    arb_ptr x = _arb_vec_init(3);
    arb_set(g->time + g->count, time);
    for (int i = 0; i < n; i++) {
        ric_equation_turn(&coarse, i, time, x, x + 1, x + 2);
        const ric_ball c = ric_ball_of(x), s = ric_ball_of(x + 1), back = ric_ball_of(x + 2);
        for (int line = 0; line < 2; line++) {
            const ric_ball q = g->line[2 * n * line + i], p = g->line[2 * n * line + n + i];
            ric_ball *to = at + 3 * n * line + i;
            to[0] = ric_ball_add(ric_ball_mul(c, q), ric_ball_mul(s, p));
            to[n] = ric_ball_add(ric_ball_mul(back, q), ric_ball_mul(c, p));
            to[2 * n] = ric_ball_mul(g->square[i], to[0]);
        }
    }
    g->count += g->count < RIC_GLIDE_READINGS;
    _arb_vec_clear(x, 3);
    return at;
}

/* side c.x of the middle, within the size of that of the half. */
static ric_ball along(const ric_glide *g, const ric_ball *x)
{
    const int n = g->n;
    ric_ball sum = {0, 0}, half = {0, 0};
    for (int i = 0; i < n; i++) {
        sum = ric_ball_add(sum, ric_ball_mul(g->c[i], x[i]));
        half = ric_ball_add(half, ric_ball_mul(g->c[i], x[3 * n + i]));
    }
    return (ric_ball){g->side < 0 ? -sum.m : sum.m, ric_up(sum.r + ric_ball_most(half))};
}

/* The smaller one of a and b, which may be no number. */
static double lesser(double a, double b)
{
    return b < a ? b : a;
}

/* What h, h' and h'' change by on a part, of which `slow` and `half` are c.p of the middle and half
 * of the modes that h changes by w h'. */
typedef struct {
    ric_ball slow, half;
    double way, turn, jerk;
} change;

static void add_mode(const ric_glide *g, const ric_ball *at, int i, double w, change *all)
{
    const int n = g->n;
    const double c = ric_ball_most(g->c[i]), swing = g->swing[i], omega = g->omega[i],
                 here = ric_up(ric_ball_most(at[i]) + ric_ball_most(at[3 * n + i])),
                 most = ric_up(g->size[i] + here), bent = ric_up(ric_up(swing * w) * w) / 2,
                 fastest = ric_up(2 * omega * g->size[i]);
    const bool fast = most < bent + fabs(at[n + i].m) * w;
    if (!fast) {
        all->slow = ric_ball_add(all->slow, ric_ball_mul(g->c[i], at[n + i]));
        all->half = ric_ball_add(all->half, ric_ball_mul(g->c[i], at[4 * n + i]));
    }
    all->way = ric_up(all->way + ric_up(c * (fast ? most : bent)));
    all->turn = ric_up(all->turn + ric_up(c * lesser(ric_up(swing * w), fastest)));
    all->jerk = ric_up(all->jerk + ric_up(c * lesser(ric_up(swing * omega * w), 2 * swing)));
}

/* All of the modes as they turn by themselves; the slack is added to what that makes. */
ric_glide_part ric_glide_look(ric_glide *g, const arb_t mid, const arb_t r)
{
    const ric_ball *at = read_at(g, mid), h = ric_ball_sub(g->d, along(g, at)),
                   p = along(g, at + g->n), a = along(g, at + 2 * g->n);
    const double w = most_of(r);
    change all = {.way = 0};
    for (int i = 0; i < g->n; i++) add_mode(g, at, i, w, &all);
    const double rate = ric_up(ric_ball_most(all.slow) + ric_ball_most(all.half));
    return (ric_glide_part){.least = h.m -
                                     ric_up(ric_up(h.r + all.way) + ric_up(rate * w) + g->slack),
                            .rate = {-p.m, ric_up(p.r + all.turn + g->slack)},
                            .bend = {a.m, ric_up(a.r + all.jerk + g->slack)}};
}
