#include "census_rows.h"

#include <string.h>

#include "base/room.h"

bool ric_census_returns(const ric_census_word *word, int flight)
{
    return word->face[flight] == word->face[(flight + 1) % word->N];
}

/* -------------------------------------------------------- rows of the flights */

/* BRIEF: a flight that is longer costs four digits at most where it is divided by three times */
#define BRIEF 0.0625

/* u(t) = (cos(omega t) - 1) / t and v(t) = sin(omega t) / t with their first two derivatives: t f =
 * r is differentiated, t f' + f = r' and t f'' + 2 f' = r''. */
static void divided_turn(const ric_ball omega, ric_ball cosine, ric_ball sine, double t,
                         ric_ball u[3], ric_ball v[3])
{
    const ric_ball zero = ric_ball_exact(0), square = ric_ball_mul(omega, omega);
    const ric_ball right[2][3] = {
        {ric_ball_sub(cosine, ric_ball_exact(1)), ric_ball_sub(zero, ric_ball_mul(omega, sine)),
         ric_ball_sub(zero, ric_ball_mul(square, cosine))},
        {sine, ric_ball_mul(omega, cosine), ric_ball_sub(zero, ric_ball_mul(square, sine))},
    };
    for (int part = 0; part < 2; part++) {
        ric_ball *out = part ? v : u;
        out[0] = ric_ball_over(right[part][0], t);
        out[1] = ric_ball_over(ric_ball_sub(right[part][1], out[0]), t);
        out[2] = ric_ball_over(ric_ball_sub(right[part][2],
                                            ric_ball_mul(ric_ball_exact(2), out[1])),
                               t);
    }
}

/* The same for a short time, by which they are divided three times: with so many bits more. */
static void divided_turn_by_arb(const ric_census_pair *p, int mode, double time, ric_ball u[3],
                                ric_ball v[3])
{
    const slong bits = 96 + 3 * (slong)fmax(0, -ilogb(time));
    arb_t t, s, c, omega, last, x;
    arb_ptr const all[6] = {t, s, c, omega, last, x};
    for (int i = 0; i < 6; i++) arb_init(all[i]);
    arb_set_d(t, time);
    arb_set(omega, p->e->omega + mode);
    arb_mul(x, t, omega, bits);
    arb_sin_cos(s, c, x, bits);
    for (int part = 0; part < 2; part++) {
        ric_ball *out = part ? v : u;
        /* the right sides of t f = r, t f' + f = r', t f'' + 2 f' = r'' */
        arb_sub_ui(x, c, 1, bits);
        arb_div(last, part ? s : x, t, bits);
        out[0] = ric_ball_of(last);
        arb_mul(x, omega, part ? c : s, bits);
        if (!part) arb_neg(x, x);
        arb_sub(x, x, last, bits);
        arb_div(last, x, t, bits);
        out[1] = ric_ball_of(last);
        arb_mul(x, omega, omega, bits);
        arb_mul(x, x, part ? s : c, bits);
        arb_neg(x, x);
        arb_submul_ui(x, last, 2, bits);
        arb_div(last, x, t, bits);
        out[2] = ric_ball_of(last);
    }
    for (int i = 0; i < 6; i++) arb_clear(all[i]);
}

/* g.a of the end of a flight, with its derivatives: g_i omega_i = c_i. */
static void plain_form(ric_census_rows *s, int flight, const ric_census_face *f)
{
    ric_ball(*form)[4] = s->form[flight];
    for (int i = 0; i < 2; i++) {
        const ric_ball omega = s->pair->omega[i];
        const ric_ball cosine = s->cosine[flight][i], sine = s->sine[flight][i],
                       turn = ric_ball_mul(f->c[i], omega);
        form[0][i] = ric_ball_mul(f->g[i], cosine);
        form[0][2 + i] = ric_ball_mul(f->g[i], sine);
        form[1][i] = ric_ball_sub(ric_ball_exact(0), ric_ball_mul(f->c[i], sine));
        form[1][2 + i] = ric_ball_mul(f->c[i], cosine);
        form[2][i] = ric_ball_sub(ric_ball_exact(0), ric_ball_mul(turn, cosine));
        form[2][2 + i] = ric_ball_sub(ric_ball_exact(0), ric_ball_mul(turn, sine));
    }
}

static void divided_form(ric_census_rows *s, int flight, const ric_census_face *f)
{
    for (int i = 0; i < 2; i++) {
        ric_ball u[3], v[3];
        const double t = s->t[flight];
        if (t > BRIEF)
            divided_turn(s->pair->omega[i], s->cosine[flight][i], s->sine[flight][i], t, u, v);
        else divided_turn_by_arb(s->pair, i, t, u, v);
        for (int order = 0; order < 3; order++) {
            s->form[flight][order][i] = ric_ball_mul(f->g[i], u[order]);
            s->form[flight][order][2 + i] = ric_ball_mul(f->g[i], v[order]);
        }
    }
}

/* ------------------------------------------------------------------- motions */

typedef struct {
    int order;
    ric_ball w[4], first[RIC_CENSUS_IMPACTS][4], second[RIC_CENSUS_PAIRS][4];
} jet;

static int pair_of(int j, int l)
{
    return l * (l + 1) / 2 + j;
}

static void set(ric_census_column *c, int row, ric_ball x)
{
    c->m[row] = x.m;
    c->r[row] = x.r;
}

static ric_ball apply(const ric_ball form[4], const ric_ball w[4])
{
    ric_ball sum = ric_ball_mul(form[0], w[0]);
    for (int i = 1; i < 4; i++) sum = ric_ball_add(sum, ric_ball_mul(form[i], w[i]));
    return sum;
}

/* d/dt of a flight, of what has flown. */
static void differentiate(const ric_census_pair *p, const ric_ball w[4], ric_ball out[4])
{
    for (int i = 0; i < 2; i++) {
        const ric_ball omega = p->omega[i], a = w[i];
        out[i] = ric_ball_mul(omega, w[2 + i]);
        out[2 + i] = ric_ball_sub(ric_ball_exact(0), ric_ball_mul(omega, a));
    }
}

/* Where the rows of a walk go: NULL for what is not asked. */
typedef struct {
    ric_census_column *value, *first, *second;
    int stride; /* between the columns of two times in `first` */
} target;

static void write_flight(const ric_census_rows *s, const jet *z, int k, int row, const target *to)
{
    const ric_ball(*form)[4] = s->form[k];
    set(to->value, row, apply(form[0], z->w));
    for (int j = 0; j < k; j++) set(to->first + j * to->stride, row, apply(form[0], z->first[j]));
    set(to->first + k * to->stride, row, apply(form[1], z->w));
    if (z->order < 2) return;
    for (int l = 0; l < k; l++)
        for (int j = 0; j <= l; j++)
            set(to->second + pair_of(j, l), row, apply(form[0], z->second[pair_of(j, l)]));
    for (int j = 0; j < k; j++) set(to->second + pair_of(j, k), row, apply(form[1], z->first[j]));
    set(to->second + pair_of(k, k), row, apply(form[2], z->w));
}

static void advance_one(const ric_census_rows *s, int k, ric_ball w[4])
{
    ric_census_fly(s->cosine[k], s->sine[k], w);
}

/* Flight k and the impact behind it. */
static void advance(const ric_census_rows *s, jet *z, int k)
{
    const ric_census_face *face = &s->pair->face[s->word->face[(k + 1) % s->word->N]];
    advance_one(s, k, z->w);
    for (int j = 0; j < k; j++) advance_one(s, k, z->first[j]);
    differentiate(s->pair, z->w, z->first[k]);
    if (z->order == 2) {
        for (int i = 0; i < pair_of(0, k); i++) advance_one(s, k, z->second[i]);
        for (int j = 0; j <= k; j++) differentiate(s->pair, z->first[j], z->second[pair_of(j, k)]);
        for (int i = 0; i <= pair_of(k, k); i++) ric_census_reflect(face, z->second[i]);
    }
    ric_census_reflect(face, z->w);
    for (int j = 0; j <= k; j++) ric_census_reflect(face, z->first[j]);
}

static void walk(const ric_census_rows *s, const ric_ball start[4], int order, const target *to)
{
    const int N = s->word->N;
    jet z = {.order = order};
    memcpy(z.w, start, sizeof z.w);
    set(to->value, 0, ric_census_place(&s->pair->face[s->word->face[0]], start));
    for (int k = 0; k < N; k++) {
        if (k + 1 < s->closing) write_flight(s, &z, k, k + 1, to);
        advance(s, &z, k);
    }
    for (int i = 0; i < 4; i++) {
        const int row = s->closing + i;
        set(to->value, row, ric_ball_sub(z.w[i], start[i]));
        for (int k = 0; k < N; k++) set(to->first + k * to->stride, row, z.first[k][i]);
        for (int j = 0; order == 2 && j < N * (N + 1) / 2; j++)
            set(to->second + j, row, z.second[j][i]);
    }
}

/* ---------------------------------------------------------------------- rows */

static void row_sizes(ric_census_rows *s)
{
    memset(s->size, 0, sizeof s->size);
    for (int row = 1; row < s->closing; row++) {
        const ric_census_face *f = &s->pair->face[s->word->face[row % s->word->N]];
        s->size[row] = ric_census_returns(s->word, row - 1) ? f->c_size : f->g_size;
    }
    for (int i = 0; i < 4; i++) s->size[s->closing + i] = 1;
}

void ric_census_rows_place(ric_census_rows *s, const ric_census_pair *pair,
                           const ric_census_word *word, const double *t)
{
    const int N = word->N;
    memset(s, 0, sizeof *s);
    s->pair = pair;
    s->word = word;
    s->closing = N + ric_census_returns(word, N - 1);
    s->n = s->closing + 5;
    for (int k = 0; k < N; k++) {
        const ric_census_face *f = &pair->face[word->face[(k + 1) % N]];
        s->t[k] = t[k];
        ric_census_turn(pair, t[k], s->cosine[k], s->sine[k]);
        if (ric_census_returns(word, k)) divided_form(s, k, f);
        else plain_form(s, k, f);
    }
    row_sizes(s);
    for (int i = 0; i < 4; i++) {
        ric_ball unit[4] = {{0, 0}, {0, 0}, {0, 0}, {0, 0}};
        unit[i].m = 1;
        walk(s, unit, 1, &(target){s->state + i, s->turned[0] + i, NULL, 4});
    }
}

void ric_census_rows_centre(ric_census_rows *s, const double w[4])
{
    const int N = s->word->N, energy = s->n - 1;
    ric_ball start[4], square = ric_ball_mul(ric_ball_exact(-2), s->pair->energy);
    for (int i = 0; i < 4; i++) {
        s->w[i] = w[i];
        start[i] = ric_ball_exact(w[i]);
        square = ric_ball_add(square, ric_ball_mul(start[i], start[i]));
        set(&s->state[i], energy, ric_ball_exact(2 * w[i]));
    }
    walk(s, start, 2, &(target){&s->residual, s->time, s->bent, 1});
    set(&s->residual, energy, square);
    for (int row = 0; row < s->closing; row++) {
        if (row && ric_census_returns(s->word, row - 1)) continue;
        const ric_ball d = s->pair->face[s->word->face[row % N]].d;
        set(&s->residual, row, ric_ball_sub((ric_ball){s->residual.m[row], s->residual.r[row]}, d));
    }
}
