/* Turns of a census: from a table of Arb's and the Taylor series of what is left of the angle. */
#include "base/room.h"
#include "census_pair.h"

/* Angle of the faster mode between two entries: half of it is at most 2^-5. */
#define STEP 0x1p-4
enum { MOST = 1 << 16 };
/* Of x <= 2^-5: x^9 / 9! and x^10 / 10! are less. */
#define SINE_LEFT 0x1p-63
#define COSINE_LEFT 0x1p-71

static void turn_by_arb(const ric_census_pair *p, double t, ric_ball cosine[2], ric_ball sine[2])
{
    enum { BITS = 64 };
    arb_t x, s, c;
    arb_init(x);
    arb_init(s);
    arb_init(c);
    for (int i = 0; i < 2; i++) {
        arb_set_d(x, t);
        arb_mul(x, x, p->e->omega + i, BITS + 16);
        arb_sin_cos(s, c, x, BITS);
        cosine[i] = ric_ball_of(c);
        sine[i] = ric_ball_of(s);
    }
    arb_clear(x);
    arb_clear(s);
    arb_clear(c);
}

/* k spacing is exact, and so is what it leaves of a time: spacing is a power of two, and no digit
 * of the difference is beyond the last one of the time. */
bool ric_census_turns(ric_census_pair *p, double longest)
{
    const double spacing = ldexp(1, ilogb(STEP / p->top)), entries = longest / spacing + 2;
    if (!(entries < MOST)) return true;
    p->turns = ric_calloc(4 * (size_t)entries, sizeof *p->turns);
    if (!p->turns) return false;
    for (int k = 0; k < (int)entries; k++)
        turn_by_arb(p, k * spacing, p->turns + 4 * k, p->turns + 4 * k + 2);
    p->spacing = spacing;
    p->n_turn = (int)entries;
    return true;
}

/* 1 - x^2 / 2! + .. + x^8 / 8!, or x - x^3 / 3! + .. - x^7 / 7!, by Horner's rule. */
static ric_ball series(ric_ball x, int highest, double left)
{
    const ric_ball square = ric_ball_mul(x, x), one = ric_ball_exact(1);
    ric_ball sum = one;
    for (int j = highest; j > 1; j -= 2)
        sum = ric_ball_sub(one, ric_ball_over(ric_ball_mul(square, sum), j * (j - 1)));
    if (highest % 2) sum = ric_ball_mul(x, sum);
    sum.r = ric_up(sum.r + left);
    return sum;
}

void ric_census_turn(const ric_census_pair *p, double t, ric_ball cosine[2], ric_ball sine[2])
{
    const double at = p->n_turn ? floor(t / p->spacing + 0.5) : -1;
    if (!(at >= 0 && at < p->n_turn)) {
        turn_by_arb(p, t, cosine, sine);
        return;
    }
    const ric_ball *entry = p->turns + 4 * (int)at;
    const ric_ball rest = ric_ball_exact(t - at * p->spacing);
    for (int i = 0; i < 2; i++) {
        const ric_ball x = ric_ball_mul(p->omega[i], rest), c = series(x, 8, COSINE_LEFT),
                       s = series(x, 7, SINE_LEFT);
        cosine[i] = ric_ball_sub(ric_ball_mul(entry[i], c), ric_ball_mul(entry[2 + i], s));
        sine[i] = ric_ball_add(ric_ball_mul(entry[2 + i], c), ric_ball_mul(entry[i], s));
    }
}
