/* Whether the points at which the test functions of a step are known show every zero of them
 * (docs/theory.md section 7), and more points where they may not. Between two neighbours a function
 * is taken for the parabola through them and the nearest other point, with an error of twice what a
 * fourth point, the next nearest, adds to it. A zero is known where the signs differ and neither
 * curve has another one; none where they agree and zero is farther away than parabola and error
 * reach. Anything else is halved, down to FINEST, or until MOST points are known. Costs nothing but
 * arithmetic where no zero is near.
 *
 * Then what is seen has to be sure: to stay so with half and twice the bend of the parabola, and
 * twice the error. Four points that lie in a mirror tell of no error where there is a large one.
 * Where it is not, a point is solved for at the extremum of the curve that has another zero, and so
 * on. These points are forgotten again unless they show a zero.
 *
 * Two of several pairs lambda + 1/lambda that pass one resonance in the same interval leave the
 * sign of its function as it was, and so does one that passes it and comes back beside another: so
 * pairs are looked at by themselves, too, and whether two between which the resonance lies may
 * meet, by the square of their distance, which is smooth where they do. At +-2 the functions are
 * the bordered determinant and the factors of the map. */
#include <stdlib.h>
#include <string.h>

#include "event_parts.h"
#include "model/room.h"

#define SAFETY 2
/* SURELY: of the bend of a parabola and of its error, both ways: what they may be off by where no
 * point between tells */
#define SURELY 2
/* LEAPS: of the slopes on both sides: what changes by more between two points leaps there, as the
 * largest gap in flight does where that maximum vanishes */
#define LEAPS 16
#define ASIDE 0.125  /* of an interval: how far from its ends a point between is looked at */
#define FINEST 1e-8  /* of the size of the orbit: two zeros nearer than this are not looked for */
#define ROUNDED 1e-6 /* of a reach that is told by products: more than it is off by */
#define FALLS 3      /* between two points: a factor that changes by more is not read */
#define SEEN 8       /* points at which curves are looked at */
/* RATIO: of distances from an end at which functions may have poles: what happens there does so on
 * every scale */
#define RATIO 16
/* NEAR_PAIR: of lambda + 1/lambda: pairs farther out than this pass no resonance beside others that
 * do */
#define NEAR_PAIR 32
#define PROBES 40 /* points more, of one step, at which pairs beside +-2 are looked at */
/* LOST_WIDTH: relative: how well the place is known where multipliers get lost in rounding */
#define LOST_WIDTH 0.05
#define LOST_LEAST 1e-4 /* the same, of the size, away from an end */

double *ric_event_samples_values(const ric_continuation *tr, int i)
{
    return tr->samples.values + (size_t)i * (size_t)ric_continuation_watched(tr);
}

/* The column of the smooth factor of a test, -1 if it has none. */
static int smooth(const ric_continuation *tr, int test)
{
    int first = RIC_N_TEST + tr->n_resonance;
    return test == RIC_TEST_A   ? first
           : test == RIC_TEST_B ? first + 1
           : test == RIC_TEST_D ? first + 2
                                : -1;
}

/* The column of pair j, sorted: NAN where it is not real. */
static int pair_column(const ric_continuation *tr, int j)
{
    return RIC_N_TEST + tr->n_resonance + 3 + j;
}

/* Whether a pair has no side of resonance k at an end of the step. */
static bool is_blurred(const ric_continuation *tr, int k)
{
    return ric_continuation_side(tr, k, &tr->now) == 0 ||
           ric_continuation_side(tr, k, &tr->next) == 0;
}

/* On which side of it a point of the step is. Where both ends are known a pair is looked at as it
 * is in between: it may go beyond and come back by less than the bound of its error. */
static double side(const ric_continuation *tr, int k, const ric_station *p)
{
    const double known = ric_continuation_side(tr, k, p);
    return known == 0 && !is_blurred(tr, k) ? ric_event_value(tr, RIC_N_TEST + k, p) : known;
}

static void take(ric_continuation *tr, int i, double x, const ric_station *p)
{
    double *value = ric_event_samples_values(tr, i);
    tr->samples.x[i] = x;
    memcpy(value, p->test, sizeof p->test);
    for (int k = 0; k < tr->n_resonance; k++) value[RIC_N_TEST + k] = side(tr, k, p);
    for (int k = RIC_TEST_A; k <= RIC_TEST_D; k++)
        value[smooth(tr, k)] = value[k] == 0 ? 0 : p->factor[k - RIC_TEST_A];
    for (int j = 0; j < tr->floquet.n_pair; j++)
        value[pair_column(tr, j)] = p->own[2 * j + 1] == 0 ? p->own[2 * j] : NAN;
}

/* The number of a new point at x. */
static int make_room(ric_continuation *tr, double x)
{
    ric_event_samples *q = &tr->samples;
    int i = q->n++;
    for (; i > q->now && q->x[i - 1] > x; i--) {
        q->x[i] = q->x[i - 1];
        memcpy(ric_event_samples_values(tr, i), ric_event_samples_values(tr, i - 1),
               (size_t)ric_continuation_watched(tr) * sizeof(double));
    }
    q->x[i] = x;
    return i;
}

ric_status ric_event_samples_insert(ric_continuation *tr, double x, double h, bool *good)
{
    *good = false;
    if (tr->samples.n == RIC_MOST_SAMPLES) return RIC_OK;
    ric_status status = ric_event_solve(tr, x, h, RIC_LOOK_ALL | RIC_LOOK_FOR, &tr->mid, good);
    if (status || !*good) return status;
    take(tr, make_room(tr, x), x, &tr->mid);
    return RIC_OK;
}

void ric_event_samples_begin(ric_continuation *tr, double h)
{
    ric_event_samples *q = &tr->samples;
    double scale = h / (tr->next.s - tr->now.s);
    q->now = q->n_past;
    for (int i = 0; i < q->now; i++) q->x[i] = (q->s[i] - tr->now.s) * scale;
    take(tr, q->now, 0, &tr->now);
    for (int i = 0; i < RIC_N_TEST; i++) /* what vanishes at the start, or is without bound there */
        if (tr->ignore & 1u << i) {
            ric_event_samples_values(tr, q->now)[i] = NAN;
            if (smooth(tr, i) >= 0) ric_event_samples_values(tr, q->now)[smooth(tr, i)] = NAN;
        }
    take(tr, q->now + 1, h, &tr->next);
    q->n = q->now + 2;
    tr->known.n = 0;
    ric_event_know(tr, 0, &tr->now);
    ric_event_know(tr, h, &tr->next);
}

ric_status ric_event_samples_add(ric_continuation *tr, double x, double h)
{
    const ric_event_samples *q = &tr->samples;
    double near = FINEST * tr->chain->scale;
    bool good;
    for (int i = q->now; i < q->n; i++)
        if (fabs(q->x[i] - x) <= near) return RIC_OK;
    return ric_event_samples_insert(tr, x, h, &good);
}

int ric_event_samples_changes(const ric_continuation *tr, unsigned which, bool pairs)
{
    const ric_event_samples *q = &tr->samples;
    int count = 0;
    for (int test = 0; test < RIC_N_TEST + (pairs ? tr->n_resonance : 0); test++) {
        double last = 0;
        if (test < RIC_N_TEST && !(which >> test & 1)) continue;
        for (int i = q->now; i < q->n; i++) {
            double value = ric_event_samples_values(tr, i)[test];
            count += last * value < 0;
            if (value != 0) last = value;
        }
    }
    return count;
}

ric_status ric_event_samples_cut(ric_continuation *tr, double end, double h)
{
    ric_event_samples *q = &tr->samples;
    bool good;
    while (q->n > q->now + 1 && q->x[q->n - 1] >= end) q->n--;
    return ric_event_samples_insert(tr, end, h, &good);
}

void ric_event_samples_shift(ric_continuation *tr)
{
    ric_event_samples *q = &tr->samples;
    size_t count = (size_t)ric_continuation_watched(tr);
    int kept = q->n - 1 < RIC_PAST_SAMPLES ? q->n - 1 : RIC_PAST_SAMPLES, first = q->n - 1 - kept;
    double scale = (tr->next.s - tr->now.s) / q->x[q->n - 1];
    for (int i = 0; i < kept; i++) {
        q->s[i] = tr->now.s + q->x[first + i] * scale;
        memmove(ric_event_samples_values(tr, i), ric_event_samples_values(tr, first + i),
                count * sizeof(double));
    }
    q->n_past = kept;
}

/* ---------------------------------------------------------------- one interval */

typedef struct {
    double length, fa, fb, bend, error,
        at; /* bend, error: second divided difference, and SAFETY times the third one; at: the third
               point of the parabola */
} curve;

static double along(const curve *c, double y, double part)
{
    double rest = y * (y - c->length);
    return c->fa + (c->fb - c->fa) * y / c->length +
           rest * (c->bend + part * c->error * (y - c->at));
}

/* Curves with none and with all of the error, to both sides. */
static bool shows_more(const curve *c)
{
    bool differ = c->fa * c->fb < 0;
    for (int side = -1; side <= 1; side++) {
        int changes = 0;
        double before = c->fa;
        for (int i = 1; i <= SEEN; i++) {
            double value = i == SEEN ? c->fb : along(c, c->length * i / SEEN, side);
            changes += before * value < 0;
            before = value;
        }
        if (changes > differ) return true;
    }
    return false;
}

/* Where a curve is level between its ends, in order; their number. */
static int levels(const curve *c, double out[2])
{
    const double L = c->length, a = 3 * c->error, half = c->bend - c->error * (L + c->at),
                 rest = (c->fb - c->fa) / L - c->bend * L + c->error * L * c->at,
                 under = half * half - a * rest;
    int n = 0;
    if (!(under >= 0)) return 0;
    const double q = -(half + copysign(sqrt(under), half)), x[2] = {q / a, rest / q};
    for (int i = 0; i < 2; i++)
        if (x[i] > 0 && x[i] < L) out[n++] = x[i];
    if (n == 2 && out[0] > out[1]) {
        out[0] = out[1];
        out[1] = fmax(x[0], x[1]);
    }
    return n;
}

/* Curves whose bend and error are off by SURELY, to both sides: where one of them that has more
 * zeros than the signs at the ends show is level, or NAN. */
static double unsure_at(const curve *c)
{
    const bool differ = c->fa * c->fb < 0;
    for (int i = 0; i < 4; i++) {
        curve way = *c;
        way.bend *= i & 1 ? SURELY : 1.0 / SURELY;
        way.error *= i & 2 ? SURELY : -SURELY;
        double at[2], before = c->fa, found = NAN;
        const int n = levels(&way, at);
        int changes = 0;
        if (!n) continue; /* it has the zeros that its ends show */
        for (int j = 0; j <= n; j++) {
            const double value = j == n ? c->fb : along(&way, at[j], 1);
            const bool changed = before * value < 0;
            if (changed && isnan(found)) found = at[j < n ? j : n - 1];
            changes += changed;
            before = value;
        }
        if (changes > differ) return fmin(fmax(found, ASIDE * c->length), (1 - ASIDE) * c->length);
    }
    return NAN;
}

/* What is read of the points: a column, less a number; or the square of how far another one is from
 * it. */
typedef struct {
    int column, other; /* other: -1, none */
    double less, most; /* most: values of columns beyond it are not read */
    bool lost_at_zero; /* 0: its sign is lost in rounding, as that of a factor; else it is a zero,
                          beside which others may lie */
} reading;

static double read_at(const ric_continuation *tr, const reading *of, int i)
{
    const double *value = ric_event_samples_values(tr, i), f = value[of->column];
    if (fabs(f) > of->most) return NAN;
    if (of->other < 0) return f - of->less;
    const double apart = value[of->other] - f;
    return fabs(value[of->other]) > of->most ? NAN : apart * apart;
}

/* The nearest points of an interval, its own two first. */
typedef struct {
    int i, n, at[4];
    double x[4]; /* from the first of them */
    bool *open;  /* NULL, or set where something is nearer to zero than it surely stays away */
} stencil;

/* A function at those of them at which it is known; of NULL all are. */
static stencil stencil_of(const ric_continuation *tr, int i, const reading *of, double f[4])
{
    const ric_event_samples *q = &tr->samples;
    stencil st = {.i = i, .n = 2, .at = {i, i + 1}, .x = {0, q->x[i + 1] - q->x[i]}};
    for (int before = i - 1, after = i + 2; st.n < 4 && (before >= 0 || after < q->n);) {
        const bool first = after >= q->n ||
                           (before >= 0 && q->x[i] - q->x[before] <= q->x[after] - q->x[i + 1]);
        const int j = first ? before-- : after++;
        if (of && !isfinite(f[st.n] = read_at(tr, of, j))) continue;
        st.at[st.n] = j;
        st.x[st.n++] = q->x[j] - q->x[i];
    }
    return st;
}

/* Of the parabola through three points, and SAFETY times what the fourth one adds to it: divided
 * differences, and how far both reach from the line between the first two. */
typedef struct {
    double bend, error, far;
} bent;

static inline __attribute__((always_inline)) bent bend_of(int n, const double x[4], double f0,
                                                          double f1, double f2, double f3)
{
    const double slope = (f1 - f0) / x[1], second = ((f2 - f1) / (x[2] - x[1]) - slope) / x[2];
    const double other = n == 4 ? ((f3 - f1) / (x[3] - x[1]) - slope) / x[3] : 0;
    const double third = n == 4 ? (other - second) / (x[3] - x[2]) : second / (fabs(x[2]) + x[1]);
    const double error = SAFETY * fabs(third), reach = ric_larger(fabs(x[2]), fabs(x[2] - x[1]));
    return (bent){second, error, x[1] * x[1] / 4 * (fabs(second) + error * reach)};
}

/* Whether both ends of an interval lie on one side of zero, and farther than that. */
static bool is_clear(double a, double b, double far)
{
    return a * b > 0 && ric_smaller(fabs(a), fabs(b)) > far;
}

/* The same of what find_far tells, whatever that is rounded by. */
static bool is_surely_clear(double a, double b, double far)
{
    return is_clear(a, b, SURELY * (1 + ROUNDED) * far);
}

/* Whether a function leaps in an interval, and is flat on both sides. */
static bool leaps(const ric_continuation *tr, int i, const reading *of, double slope)
{
    const ric_event_samples *q = &tr->samples;
    if (i < 1 || i + 2 >= q->n) return false;
    const double f[4] = {read_at(tr, of, i - 1), read_at(tr, of, i), read_at(tr, of, i + 1),
                         read_at(tr, of, i + 2)},
                 before = fabs(f[1] - f[0]) / (q->x[i] - q->x[i - 1]),
                 after = fabs(f[3] - f[2]) / (q->x[i + 2] - q->x[i + 1]);
    return fabs(slope) > LEAPS * before && fabs(slope) > LEAPS * after;
}

/* `at` NULL: whether the interval may have zeros that do not show; else whether it surely has none,
 * and *at: where to look if it may. */
static bool is_resolved(const ric_continuation *tr, const stencil *all, const reading *of,
                        double *at)
{
    stencil st = *all;
    double f[4] = {0};
    for (int j = 0; j < st.n; j++) f[j] = read_at(tr, of, st.at[j]);
    if (!isfinite(f[0] + f[1]) || (of->lost_at_zero && f[0] * f[1] == 0)) return true;
    if (!isfinite(f[2] + f[3])) {
        if (at && of->column >= pair_column(tr, 0)) return true; /* as a root beside a meeting */
        st = stencil_of(tr, st.i, of, f);
        st.open = all->open;
    }
    if (st.n < 3) return true; /* the first step, as short as it is */
    const bent b = bend_of(st.n, st.x, f[0], f[1], f[2], f[3]);
    const curve between = {.length = st.x[1],
                           .fa = f[0],
                           .fb = f[1],
                           .bend = b.bend,
                           .error = b.error,
                           .at = st.x[2]};
    if (is_clear(f[0], f[1], SURELY * b.far)) return true;
    if (st.open) *st.open = true;
    if (!at) return is_clear(f[0], f[1], b.far) || !shows_more(&between);
    *at = unsure_at(&between);
    return isnan(*at) || leaps(tr, st.i, of, (f[1] - f[0]) / st.x[1]);
}

/* The reach of n columns side by side, by products, HUGE_VAL where four points are not known:
 * nearly all columns are clear of it, and is_resolved has nothing more to tell. */
static void find_far(const ric_continuation *tr, const stencil *st, int n, double *restrict far)
{
    const double *restrict v[4], *x = st->x;
    for (int j = 0; j < st->n; j++) v[j] = ric_event_samples_values(tr, st->at[j]);
    if (st->n < 4) {
        for (int k = 0; k < n; k++) far[k] = HUGE_VAL;
        return;
    }
    const double one = 1 / x[1], two = 1 / x[2], three = 1 / x[3], to2 = 1 / (x[2] - x[1]),
                 to3 = 1 / (x[3] - x[1]), last = 1 / (x[3] - x[2]), part = x[1] * x[1] / 4,
                 cubic = SAFETY * ric_larger(fabs(x[2]), fabs(x[2] - x[1]));
    for (int k = 0; k < n; k++) {
        const double slope = (v[1][k] - v[0][k]) * one,
                     second = ((v[2][k] - v[1][k]) * to2 - slope) * two,
                     other = ((v[3][k] - v[1][k]) * to3 - slope) * three;
        far[k] = part * (fabs(second) + cubic * fabs((other - second) * last));
    }
}

static bool resolved(const ric_continuation *tr, const stencil *st, int test, double *at)
{
    const int k = test - RIC_N_TEST;
    const double *a = ric_event_samples_values(tr, st->i),
                 *b = ric_event_samples_values(tr, st->i + 1);
    /* margins that are rounding, as where an impact loses its speed beside a gap that closes, show
     * nothing */
    if (at && test <= RIC_TEST_FLIGHT && ric_larger(fabs(a[test]), fabs(b[test])) < RIC_MARGIN)
        return true;
    const bool resonance = k >= 0 && k < tr->n_resonance;
    if (resonance && a[test] * b[test] == 0 && is_blurred(tr, k)) return true; /* nothing shows */
    /* the only pair is nearly straight where its test, over 1 + rho^2, is not */
    if (at && resonance && tr->floquet.n_pair == 1 &&
        is_resolved(tr, st,
                    &(reading){pair_column(tr, 0), -1, tr->resonances[k].rho, HUGE_VAL, false}, at))
        return true;
    const bool lost_at_zero = !resonance && !(at && test <= RIC_TEST_FLIGHT);
    return is_resolved(tr, st, &(reading){test, -1, 0, HUGE_VAL, lost_at_zero}, at);
}

/* Whether each pair by itself, of several, stays on its side of rho, and none comes from there to
 * meet another. */
static bool pairs_stay(const ric_continuation *tr, const stencil *st, double rho, double *at)
{
    const int i = st->i;
    const double *a = ric_event_samples_values(tr, i), *b = ric_event_samples_values(tr, i + 1);
    for (int j = 0; j < tr->floquet.n_pair; j++) {
        const int own = pair_column(tr, j);
        const bool below = a[own] < rho && b[own] < rho;
        const bool above = a[own] > rho && b[own] > rho;
        if ((below || above) &&
            !is_resolved(tr, st, &(reading){own, -1, rho, NEAR_PAIR, false}, at))
            return false;
        if (!below || j + 1 == tr->floquet.n_pair || !(a[own + 1] > rho && b[own + 1] > rho))
            continue;
        if (!is_resolved(tr, st, &(reading){own, own + 1, 0, NEAR_PAIR, false}, at)) return false;
    }
    return true;
}

/* Where one end of an interval has multipliers and the other has lost them. */
static bool half_lost(const ric_continuation *tr, int i, double from, double to)
{
    const ric_event_samples *q = &tr->samples;
    double length = q->x[i + 1] - q->x[i], near = HUGE_VAL;
    if (tr->n_resonance == 0) return false;
    if (from >= 0 && q->x[i] == from) return false; /* a pole */
    if (from >= 0) near = fmin(near, q->x[i + 1] - from);
    if (to >= 0) near = fmin(near, to - q->x[i]);
    bool known[2];
    for (int j = 0; j < 2; j++)
        known[j] = isfinite(ric_event_samples_values(tr, i + j)[RIC_N_TEST]);
    return known[0] != known[1] && length > fmin(LOST_LEAST * tr->chain->scale, LOST_WIDTH * near);
}

/* ------------------------------------------------------------------- the step */

/* The same of the factor of a test, which is smooth where the test jumps; beside a grazing it falls
 * by powers of ten, and tells nothing. */
static bool smoothly(const ric_continuation *tr, const stencil *st, int test, const double *far,
                     double *at)
{
    const int column = smooth(tr, test);
    if (column < 0) return true;
    const double a = ric_event_samples_values(tr, st->i)[column],
                 b = ric_event_samples_values(tr, st->i + 1)[column];
    if (is_surely_clear(a, b, far[column])) return true;
    return fmax(fabs(a), fabs(b)) > FALLS * fmin(fabs(a), fabs(b)) || resolved(tr, st, column, at);
}

/* As is_resolved. Of the factors of the map only their smooth form is surely known. */
static bool all_resolved(const ric_continuation *tr, int i, unsigned which, bool pairs, double *at,
                         bool *open)
{
    stencil st = stencil_of(tr, i, NULL, NULL);
    const double *a = ric_event_samples_values(tr, i), *b = ric_event_samples_values(tr, i + 1);
    const int n = RIC_N_TEST + (pairs ? tr->n_resonance : 0);
    double far[RIC_N_TEST + tr->n_resonance + 3]; /* smooth factors are the last three */
    find_far(tr, &st, RIC_N_TEST + tr->n_resonance + 3, far);
    st.open = open;
    for (int test = 0; test < n; test++) {
        const bool own = test < RIC_N_TEST;
        if (own && !(which >> test & 1)) continue;
        if (!is_surely_clear(a[test], b[test], far[test]) && !(at && smooth(tr, test) >= 0) &&
            !resolved(tr, &st, test, at))
            return false;
        if (own ? !smoothly(tr, &st, test, far, at)
                : tr->floquet.n_pair > 1 &&
                      !(a[test] * b[test] == 0 && is_blurred(tr, test - RIC_N_TEST)) &&
                      !pairs_stay(tr, &st, tr->resonances[test - RIC_N_TEST].rho, at))
            return false;
    }
    return true;
}

void ric_event_samples_unresolved(ric_continuation *tr)
{
    ric_continuation_widen(tr->unresolved++ == 0, tr->now.row.energy, tr->next.row.energy,
                           tr->crowded_at);
}

ric_status ric_event_samples_refine(ric_continuation *tr, unsigned which, bool pairs, double from,
                                    double to, double h)
{
    ric_event_samples *q = &tr->samples;
    double finest = FINEST * tr->chain->scale;
    q->open = false;
    for (int i = q->now; i + 1 < q->n;) {
        double a = q->x[i], b = q->x[i + 1];
        bool good = false, close = b - a <= finest || q->n == RIC_MOST_SAMPLES;
        bool fine = all_resolved(tr, i, which, pairs, NULL, &q->open);
        bool split = !fine || (pairs && half_lost(tr, i, from, to));
        if (split && !close) {
            ric_status status = ric_event_samples_insert(tr, (a + b) / 2, h, &good);
            if (status) return status;
            if (good && i > q->now) i--; /* what is new tells more of the neighbour, too */
        }
        if (!fine && !good) ric_event_samples_unresolved(tr);
        if (!good) i++;
    }
    return RIC_OK;
}

/* Whether the pairs stay on their sides of +-2, where factors of the map or its bordered
 * determinant vanish. Where the sign of one is lost in rounding, so is the side of a pair. Of a
 * whole period -2 is a resonance. */
static bool pairs_stay_at_two(const ric_continuation *tr, int i, unsigned which, double *at)
{
    const stencil st = stencil_of(tr, i, NULL, NULL);
    static const unsigned vanish[2] = {1u << RIC_TEST_DET | 1u << RIC_TEST_B,
                                       1u << RIC_TEST_A | 1u << RIC_TEST_D};
    for (int k = 0; k < (ric_shooting_halves(tr->chain) ? 2 : 1); k++) {
        bool known = which & vanish[k];
        for (int test = 0; test < RIC_N_TEST; test++)
            for (int j = i; vanish[k] >> test & 1 && j < i + 2; j++) {
                const double value = ric_event_samples_values(tr, j)[test];
                known &= isfinite(value) && value != 0;
            }
        if (known && !pairs_stay(tr, &st, k ? -2 : 2, at)) return false;
    }
    return true;
}

/* Where the interval after point i is to be looked into, or NAN. */
static double doubtful_at(const ric_continuation *tr, int i, unsigned which, bool pairs)
{
    double at = NAN;
    const bool sure = all_resolved(tr, i, which, pairs, &at, NULL) &&
                      (tr->floquet.n_pair < 2 || pairs_stay_at_two(tr, i, which, &at));
    return sure ? NAN : tr->samples.x[i] + at;
}

/* More points, as long as there is doubt; *left: some is left. */
static ric_status probe(ric_continuation *tr, unsigned which, bool pairs, double h, bool *left)
{
    ric_event_samples *q = &tr->samples;
    const double finest = FINEST * tr->chain->scale;
    const int most = q->n + PROBES < RIC_MOST_SAMPLES ? q->n + PROBES : RIC_MOST_SAMPLES;
    *left = false;
    for (int i = q->now; i + 1 < q->n;) {
        const double at = doubtful_at(tr, i, which, pairs);
        bool good = false;
        if (!isnan(at) && q->n < most && q->x[i + 1] - q->x[i] > finest) {
            ric_status status = ric_event_samples_insert(tr, at, h, &good);
            if (status) return status;
            if (good && i > q->now) i--;
        }
        if (good) continue;
        *left |= !isnan(at);
        i++;
    }
    return RIC_OK;
}

/* Whether a step has anything to probe. */
static bool has_doubt(const ric_continuation *tr, unsigned which, bool pairs)
{
    const ric_event_samples *q = &tr->samples;
    if (!q->open && tr->floquet.n_pair < 2) return false;
    for (int i = q->now; i + 1 < q->n; i++)
        if (!isnan(doubtful_at(tr, i, which, pairs))) return true;
    return false;
}

/* Whether a function that vanishes at `end` may do so before, too, as far as that zero tells. */
static bool has_doubt_before(ric_continuation *tr, const ric_event_root *end)
{
    ric_event_samples *q = &tr->samples;
    const size_t count = (size_t)ric_continuation_watched(tr);
    if (q->n == RIC_MOST_SAMPLES) return false;
    const int i = make_room(tr, end->x);
    double *value = ric_event_samples_values(tr, i);
    for (size_t k = 0; k < count; k++) value[k] = NAN;
    value[end->test] = 0;
    bool doubt = false;
    for (int j = q->now; j < i; j++) doubt |= !isnan(doubtful_at(tr, j, 1u << end->test, false));
    q->n--;
    memmove(q->x + i, q->x + i + 1, (size_t)(q->n - i) * sizeof *q->x);
    memmove(value, value + count, (size_t)(q->n - i) * count * sizeof *value);
    return doubt;
}

ric_status ric_event_samples_probe(ric_continuation *tr, unsigned which, bool pairs,
                                   const ric_event_root *end, double h)
{
    ric_event_samples *q = &tr->samples;
    if (!(end ? has_doubt_before(tr, end) : has_doubt(tr, which, pairs))) return RIC_OK;
    const int n = q->n, n_known = tr->known.n, before = ric_event_samples_changes(tr, which, pairs);
    const size_t count = (size_t)n * (size_t)ric_continuation_watched(tr);
    double x[n], values[count];
    memcpy(x, q->x, sizeof x);
    memcpy(values, q->values, sizeof values);
    const int32_t steep = tr->steep;
    const double scale = tr->chain->scale;
    bool left = false;
    tr->solved.full = true;
    ric_status status = end ? ric_event_samples_add(tr, end->x, h) : RIC_OK;
    if (!status) status = probe(tr, which, pairs, h, &left);
    tr->solved.full = false;
    if (status || ric_event_samples_changes(tr, which, pairs) != before) return status;
    if (left) ric_event_samples_unresolved(tr);
    memcpy(q->x, x, sizeof x);
    memcpy(q->values, values, sizeof values);
    q->n = n;
    tr->known.n = n_known;
    tr->steep = steep;
    tr->chain->scale = scale; /* steps are relative to it */
    return RIC_OK;
}

/* Points at distances from an end of the interval that fall by RATIO, to the least one: what lies
 * nearer to the end than all of them would be seen or not by how long the step is. */
ric_status ric_event_samples_approach(ric_continuation *tr, double end, double other, double least,
                                      double h)
{
    ric_event_samples *q = &tr->samples;
    for (double from = fabs(other - end), d; from > least && q->n < RIC_MOST_SAMPLES; from = d) {
        d = fmax(from / RATIO, least);
        ric_status status = ric_event_samples_add(tr, other > end ? end + d : end - d, h);
        if (status) return status;
    }
    return RIC_OK;
}

void ric_event_samples_tell(ric_continuation *tr, const ric_station *p, int i, double energy)
{
    const double *value = ric_event_samples_values(tr, i);
    bool passed = false;
    for (int k = 0; k < tr->n_resonance; k++)
        passed |= value[RIC_N_TEST + k] * ric_continuation_side(tr, k, p) < 0;
    if (passed && ric_flight_law_of(tr->chain->model)->closes)
        ric_continuation_widen(tr->unresolved++ == 0, tr->now.row.energy, energy, tr->crowded_at);
}
