#include "census_box.h"

#include <string.h>

#include "base/room.h"
#include "census_scan.h"

/* Times the largest frequency: the sum of the halves of the flights from which on Taylor's
 * polynomials are tried. */
#define WIDEST 1.5
/* The same of the flights from which on motions are followed from impact to impact. */
#define BROAD 0.5
/* A pass that leaves more than this of the flights ends the passes; there are at most that many. */
#define PASS_LEAVES 0.7
/* STATES_LEAVE: of the states: a contraction that leaves more is not repeated */
#define STATES_LEAVE 0.95
enum { PASSES = 4, UNKNOWNS = 4 + RIC_CENSUS_IMPACTS };
/* A row without an error weighs as much as if it had this share of what it adds up. */
#define LEAST_ERROR 1e-4

double ric_census_box_middle(ric_range x)
{
    const double m = x.lo + (x.hi - x.lo) / 2;
    return m < x.lo ? x.lo : m > x.hi ? x.hi : m;
}

double ric_census_box_radius(ric_range x)
{
    const double m = ric_census_box_middle(x);
    return ric_up(fmax(x.hi - m, m - x.lo));
}

/* The range becomes what it shares with a ball; false if that is nothing. */
static bool meet(ric_range *x, ric_ball b)
{
    const double lo = b.m - b.r, hi = b.m + b.r;
    const double low = lo - ric_up(fabs(lo) * 2 * RIC_BALL_UNIT),
                 high = hi + ric_up(fabs(hi) * 2 * RIC_BALL_UNIT);
    if (low > x->lo) x->lo = low;
    if (high < x->hi) x->hi = high;
    return !(x->lo > x->hi);
}

/* ----------------------------------------------------------- Taylor's polynomial */

static int pair_of(int j, int l)
{
    return l * (l + 1) / 2 + j;
}

static double sum_of_times(const ric_census_frame *f)
{
    double sum = 0;
    for (int k = 0; k < f->rows.word->N; k++) sum += f->radius[4 + k];
    return ric_up(sum);
}

/* |w - centre| from the box, and from |w| <= size. */
static double reach_of_state(const ric_census_frame *f, double size)
{
    double sum = 0, centre = 0;
    for (int i = 0; i < 4; i++) {
        sum = ric_up(sum + f->radius[i] * f->radius[i]);
        centre = ric_up(centre + f->rows.w[i] * f->rows.w[i]);
    }
    return fmin(ric_up(sqrt(sum)), ric_up(size + ric_up(sqrt(centre))));
}

/* |v . (w - centre)| of four balls. */
static double on_state(const ric_census_frame *f, const ric_ball v[4])
{
    double sum = 0, square = 0;
    for (int i = 0; i < 4; i++) {
        const double most = ric_ball_most(v[i]);
        sum = ric_up(sum + most * f->radius[i]);
        square = ric_up(square + most * most);
    }
    return fmin(sum, ric_up(ric_up(sqrt(square)) * f->reach));
}

double ric_census_frame_linear(const ric_census_frame *f, const ric_ball *linear)
{
    double sum = on_state(f, linear);
    for (int k = 0; k < f->rows.word->N; k++)
        sum = ric_up(sum + ric_ball_most(linear[4 + k]) * f->radius[4 + k]);
    return sum;
}

/* Of the derivatives of order j that are at most size top^j |w|: those of the second order meet the
 * distance from the centre of w, of which the polynomial has none, and the third ones w. */
void ric_census_frame_bound(ric_census_frame *f, double size)
{
    const ric_census_rows *s = &f->rows;
    const double turn = ric_up(sum_of_times(f) * s->pair->top);
    f->reach = reach_of_state(f, size);
    const double rest = ric_up(ric_up(turn * turn) * (f->reach / 2 + ric_up(turn * size / 6)));
    for (int q = 0; q < s->n; q++)
        f->rest[q] = ric_up(s->size[q] * rest +
                            RIC_CENSUS_SLACK * (1 + s->size[q]) * (1 + size) * (1 + size));
}

/* What is not linear in a row, about. */
static double error_of_row(const ric_census_frame *f, int q)
{
    const ric_census_rows *s = &f->rows;
    const double *time = f->radius + 4;
    double sum = f->rest[q];
    for (int l = 0; l < s->word->N; l++) {
        for (int i = 0; i < 4; i++) sum += time[l] * f->radius[i] * fabs(s->turned[l][i].m[q]);
        for (int j = 0; j <= l; j++)
            sum += (j < l ? 1 : 0.5) * time[j] * time[l] * fabs(s->bent[pair_of(j, l)].m[q]);
    }
    return q == s->n - 1 ? sum + f->reach * f->reach : sum;
}

static ric_ball dot(const ric_census_frame *f, const double *y, const ric_census_column *c)
{
    return ric_ball_dot(f->rows.n, y, c->m, c->r);
}

/* Squares of the unknowns lie between 0 and their largest value: `shifted`, its half is added to
 * the value. */
static void add_square(ric_census_sum *out, ric_ball factor, double most, bool shifted)
{
    const double half = most / 2;
    if (shifted)
        out->value = ric_ball_add(out->value,
                                  ric_ball_mul(factor, (ric_ball){half, ric_up(half) - half}));
    out->error = ric_up(out->error + ric_ball_most(factor) * (shifted ? ric_up(half) : most));
}

void ric_census_frame_sum(const ric_census_frame *f, const double *y, bool shifted,
                          ric_census_sum *out)
{
    const ric_census_rows *s = &f->rows;
    const int N = s->word->N;
    const double *time = f->radius + 4;
    ric_ball turned[4];
    out->value = dot(f, y, &s->residual);
    out->error = 0;
    for (int i = 0; i < 4; i++) out->linear[i] = dot(f, y, &s->state[i]);
    for (int q = 0; q < s->n; q++) out->error = ric_up(out->error + fabs(y[q]) * f->rest[q]);
    for (int l = 0; l < N; l++) {
        out->linear[4 + l] = dot(f, y, &s->time[l]);
        for (int i = 0; i < 4; i++) turned[i] = dot(f, y, &s->turned[l][i]);
        out->error = ric_up(out->error + time[l] * on_state(f, turned));
        for (int j = 0; j < l; j++)
            out->error = ric_up(out->error + time[j] * time[l] *
                                                 ric_ball_most(dot(f, y, &s->bent[pair_of(j, l)])));
        const ric_ball bent = dot(f, y, &s->bent[pair_of(l, l)]);
        add_square(out, (ric_ball){bent.m / 2, bent.r / 2}, ric_up(time[l] * time[l]), shifted);
    }
    add_square(out, ric_ball_exact(y[s->n - 1]), ric_up(f->reach * f->reach), shifted);
}

/* ------------------------------------------------------------------- functionals */

/* The functionals that tell most of each unknown: with rows divided by their errors and unknowns by
 * their radii, M z = -r +- 1 and |z| <= 1 have the solution (M'M + 1)^-1 M' in the mean. What is
 * computed here is only a choice. */
typedef struct {
    int n, rows;
    double M[RIC_CENSUS_ROWS][UNKNOWNS], weight[RIC_CENSUS_ROWS], right[RIC_CENSUS_ROWS];
    double L[UNKNOWNS][UNKNOWNS]; /* M'M + 1 = L L' */
} fit;

static void fit_rows(fit *z, const ric_census_frame *f)
{
    const ric_census_rows *s = &f->rows;
    z->n = 4 + s->word->N;
    z->rows = s->n;
    for (int q = 0; q < s->n; q++) {
        double size = DBL_MIN;
        for (int i = 0; i < z->n; i++) {
            z->M[q][i] = f->radius[i] * (i < 4 ? s->state[i].m[q] : s->time[i - 4].m[q]);
            size += fabs(z->M[q][i]);
        }
        z->weight[q] = 1 / fmax(error_of_row(f, q), LEAST_ERROR * size);
        z->right[q] = -z->weight[q] * s->residual.m[q];
        for (int i = 0; i < z->n; i++) z->M[q][i] *= z->weight[q];
    }
}

static void fit_factor(fit *z)
{
    for (int i = 0; i < z->n; i++)
        for (int j = 0; j <= i; j++) {
            double sum = i == j;
            for (int q = 0; q < z->rows; q++) sum += z->M[q][i] * z->M[q][j];
            for (int k = 0; k < j; k++) sum -= z->L[i][k] * z->L[j][k];
            z->L[i][j] = i == j ? sqrt(sum) : sum / z->L[j][j];
        }
}

static void fit_solve(const fit *z, double *x)
{
    for (int i = 0; i < z->n; i++) {
        for (int k = 0; k < i; k++) x[i] -= z->L[i][k] * x[k];
        x[i] /= z->L[i][i];
    }
    for (int i = z->n - 1; i >= 0; i--) {
        for (int k = i + 1; k < z->n; k++) x[i] -= z->L[k][i] * x[k];
        x[i] /= z->L[i][i];
    }
}

/* y for unknown i, in its own units. */
static void functional_of(const fit *z, const ric_census_frame *f, int i, double *y)
{
    double x[UNKNOWNS] = {0};
    x[i] = 1;
    fit_solve(z, x);
    for (int q = 0; q < z->rows; q++) {
        y[q] = 0;
        for (int j = 0; j < z->n; j++) y[q] += z->M[q][j] * x[j];
        y[q] *= z->weight[q] * f->radius[i];
    }
}

/* What is left of the rows by the best unknowns: no combination of rows is farther from zero, for
 * its errors. */
static void functional_of_rest(const fit *z, double *y)
{
    double x[UNKNOWNS] = {0};
    for (int i = 0; i < z->n; i++)
        for (int q = 0; q < z->rows; q++) x[i] += z->M[q][i] * z->right[q];
    fit_solve(z, x);
    for (int q = 0; q < z->rows; q++) {
        y[q] = z->right[q];
        for (int j = 0; j < z->n; j++) y[q] -= z->M[q][j] * x[j];
        y[q] *= z->weight[q];
    }
}

/* ---------------------------------------------------------------------- a pass */

static ric_range *unknown(ric_census_box *b, int i)
{
    return i < 4 ? &b->w[i] : &b->t[i - 4];
}

/* 0 = y.F is possible. */
static bool may_vanish(const ric_census_frame *f, const double *y)
{
    ric_census_sum sum;
    ric_census_frame_sum(f, y, true, &sum);
    const double most = ric_up(sum.error + ric_census_frame_linear(f, sum.linear));
    return !(ric_down(fabs(sum.value.m) - sum.value.r) > most);
}

/* z_i in -value - (y.F' - e_i).z +- error. */
static bool narrow(ric_census_box *b, const ric_census_frame *f, const double *y, int i,
                   double centre)
{
    ric_census_sum sum;
    ric_census_frame_sum(f, y, true, &sum);
    sum.linear[i] = ric_ball_sub(sum.linear[i], ric_ball_exact(1));
    const double error = ric_up(sum.error + sum.value.r + ric_census_frame_linear(f, sum.linear));
    return meet(unknown(b, i),
                ric_ball_add(ric_ball_exact(centre), (ric_ball){-sum.value.m, error}));
}

/* The rows are placed; the box is around their times. */
static bool contract(ric_census_box *b, ric_census_frame *f)
{
    const ric_census_pair *p = f->rows.pair;
    double w[4], y[RIC_CENSUS_ROWS];
    fit z;
    for (int i = 0; i < 4; i++) {
        w[i] = ric_census_box_middle(b->w[i]);
        f->radius[i] = ric_census_box_radius(b->w[i]);
    }
    for (int k = 0; k < f->rows.word->N; k++)
        f->radius[4 + k] = ric_up(fmax(b->t[k].hi - f->rows.t[k], f->rows.t[k] - b->t[k].lo));
    ric_census_rows_centre(&f->rows, w);
    ric_census_frame_bound(f, p->size);
    fit_rows(&z, f);
    fit_factor(&z);
    functional_of_rest(&z, y);
    if (!may_vanish(f, y)) return false;
    for (int i = 0; i < z.n; i++) {
        functional_of(&z, f, i, y);
        if (!narrow(b, f, y, i, i < 4 ? w[i] : f->rows.t[i - 4])) return false;
    }
    return true;
}

/* -------------------------------------------------------------------- limits */

static bool keep_limits(ric_census_box *b, int N, const ric_census_limits *limits)
{
    double least = 0, most = 0;
    for (int k = 0; k < N; k++) {
        if (limits->flight < b->t[k].hi) b->t[k].hi = limits->flight;
        if (b->t[k].hi > b->t[0].hi) b->t[k].hi = b->t[0].hi;
        if (b->t[k].lo > b->t[0].lo) b->t[0].lo = b->t[k].lo;
    }
    for (int k = 0; k < N; k++) {
        if (b->t[k].lo > b->t[k].hi) return false;
        least += b->t[k].lo;
        most += b->t[k].hi;
    }
    if (ric_down(least) > limits->period[1] || ric_up(most) < limits->period[0]) return false;
    for (int k = 0; k < N; k++) {
        const double high = ric_up(limits->period[1] - ric_down(ric_down(least) - b->t[k].lo)) +
                            DBL_EPSILON * most;
        const double low = limits->period[0] - ric_up(ric_up(most) - b->t[k].hi) -
                           4 * DBL_EPSILON * most;
        if (high < b->t[k].hi) b->t[k].hi = high;
        if (low > b->t[k].lo) b->t[k].lo = low;
        if (b->t[k].lo > b->t[k].hi) return false;
    }
    return true;
}

/* ------------------------------------------------------------- admissibility */

enum { SAMPLES_MOST = 512, GOLDEN = 40 };
#define SAMPLE 0.15 /* radians of the faster mode between two looks at a gap */

/* The place of face f after time t, of a state whose numbers are known to `error` in the Euclidean
 * norm. */
static bool is_beyond(const ric_census_pair *p, const ric_census_face *f, const ric_ball w[4],
                      double t, double error)
{
    ric_ball cosine[2], sine[2], flown[4];
    memcpy(flown, w, sizeof flown);
    ric_census_turn(p, t, cosine, sine);
    ric_census_fly(cosine, sine, flown);
    const ric_ball h = ric_ball_sub(ric_census_place(f, flown), f->d);
    return ric_down(h.m - h.r) > ric_up(f->g_size * error + RIC_CENSUS_SLACK);
}

static double place_after(const ric_census_pair *p, const ric_census_face *f, const ric_ball w[4],
                          double t)
{
    double h = 0;
    for (int i = 0; i < 2; i++)
        h += f->g[i].m * (w[i].m * cos(p->omega[i].m * t) + w[2 + i].m * sin(p->omega[i].m * t));
    return h;
}

/* A larger one between two looks around `at`, by golden sections. */
static double climb(const ric_census_pair *p, const ric_census_face *f, const ric_ball w[4],
                    double lo, double hi)
{
    const double share = 0.6180339887498949;
    double a = hi - share * (hi - lo), b = lo + share * (hi - lo);
    double at_a = place_after(p, f, w, a), at_b = place_after(p, f, w, b);
    for (int i = 0; i < GOLDEN; i++) {
        if (at_a > at_b) {
            hi = b, b = a, at_b = at_a;
            a = hi - share * (hi - lo), at_a = place_after(p, f, w, a);
        } else {
            lo = a, a = b, at_a = at_b;
            b = lo + share * (hi - lo), at_b = place_after(p, f, w, b);
        }
    }
    return (lo + hi) / 2;
}

/* Whether g.a is surely larger than d at a time between two looks at it, of which one in the middle
 * is larger. */
static bool passes_near(const ric_census_pair *p, const ric_census_face *f, const ric_ball w[4],
                        ric_range around, double error)
{
    const double at = climb(p, f, w, around.lo, around.hi);
    if (!(place_after(p, f, w, at) > f->d.m + f->g_size * error)) return false;
    return at >= around.lo && at <= around.hi && is_beyond(p, f, w, at, error);
}

/* Whether g.a is surely larger than d at a time that every flight of the box has: the times are
 * looked for at which it is largest, and its gap proved. A motion that begins on the face has one
 * of them there. */
static bool passes(const ric_census_pair *p, const ric_census_face *f, const ric_ball w[4],
                   double least, double error)
{
    const int samples = (int)fmin(SAMPLES_MOST, ceil(least * p->top / SAMPLE));
    double turn[2][2], now[4] = {w[0].m, w[1].m, w[2].m, w[3].m},
                       h[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    if (samples < 1) return false;
    const double step = least / samples, needed = f->d.m + f->g_size * error;
    const double between = f->g_size * p->size * (step * p->top) * (step * p->top) / 8;
    for (int i = 0; i < 2; i++) {
        turn[i][0] = cos(p->omega[i].m * step);
        turn[i][1] = sin(p->omega[i].m * step);
    }
    for (int k = 0; k <= samples + 1; k++) {
        h[0] = h[1];
        h[1] = h[2];
        h[2] = k > samples ? -HUGE_VAL : f->g[0].m * now[0] + f->g[1].m * now[1];
        const ric_range around = {fmax(0, (k - 2) * step), fmin(least, k * step)};
        if (h[1] >= h[0] && h[1] >= h[2] && h[1] + between > needed &&
            passes_near(p, f, w, around, error))
            return true;
        for (int i = 0; i < 2; i++) {
            const double a = now[i], v = now[2 + i];
            now[i] = turn[i][0] * a + turn[i][1] * v;
            now[2 + i] = turn[i][0] * v - turn[i][1] * a;
        }
    }
    return false;
}

/* Whether every motion of the box leaves face f outwards. */
static bool leaves_outwards(const ric_census_face *f, const ric_ball w[4], double error)
{
    const ric_ball v = ric_census_speed(f, w);
    return ric_down(v.m - v.r) > ric_up(f->c_size * error + RIC_CENSUS_SLACK);
}

/* The state behind event k is off from that of the centre by at most its own error at the beginning
 * and top |w| times the errors of the times. */
bool ric_census_box_moves(const ric_census_box *b, const ric_census_pair *p,
                          const ric_census_word *word)
{
    ric_ball w[4];
    double square = 0;
    for (int i = 0; i < 4; i++) {
        const double radius = ric_census_box_radius(b->w[i]);
        w[i] = ric_ball_exact(ric_census_box_middle(b->w[i]));
        square = ric_up(square + radius * radius);
    }
    double error = ric_up(sqrt(square));
    for (int k = 0; k < word->N; k++) {
        ric_ball cosine[2], sine[2];
        if (leaves_outwards(&p->face[word->face[k]], w, error)) return false;
        for (int f = 0; f < p->n_face; f++)
            if (passes(p, &p->face[f], w, b->t[k].lo, error)) return false;
        ric_census_turn(p, ric_census_box_middle(b->t[k]), cosine, sine);
        ric_census_fly(cosine, sine, w);
        ric_census_reflect(&p->face[word->face[(k + 1) % word->N]], w);
        error = ric_up(error + ric_up(ric_census_box_radius(b->t[k]) * p->top) * p->size);
    }
    return true;
}

/* ------------------------------------------------------------------- reducing */

static double sum_of_widths(const ric_census_box *b, int N)
{
    double sum = 0;
    for (int k = 0; k < N; k++) sum += b->t[k].hi - b->t[k].lo;
    return sum;
}

static double sum_of_states(const ric_census_box *b)
{
    double sum = 0;
    for (int i = 0; i < 4; i++) sum += b->w[i].hi - b->w[i].lo;
    return sum;
}

bool ric_census_box_reduce(ric_census_box *b, const ric_census_pair *p, const ric_census_word *word,
                           const ric_census_limits *limits)
{
    const int N = word->N;
    ric_census_frame f;
    double t[RIC_CENSUS_IMPACTS], width = 0;
    if (!keep_limits(b, N, limits)) return false;
    if (sum_of_widths(b, N) * p->top > BROAD &&
        !(ric_census_scan(b, p, word) && keep_limits(b, N, limits)))
        return false;
    for (int pass = 0; pass < PASSES; pass++) {
        const double before = sum_of_widths(b, N);
        if (before * p->top > 2 * WIDEST || (pass && before > PASS_LEAVES * width)) break;
        width = before;
        for (int k = 0; k < N; k++) t[k] = ric_census_box_middle(b->t[k]);
        ric_census_rows_place(&f.rows, p, word, t);
        double state = sum_of_states(b), last;
        do {
            last = state;
            if (!contract(b, &f)) return false;
            state = sum_of_states(b);
        } while (state < STATES_LEAVE * last);
        if (!keep_limits(b, N, limits)) return false;
    }
    return ric_census_box_moves(b, p, word);
}
