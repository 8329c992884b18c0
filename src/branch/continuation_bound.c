/* How far slopes and multipliers of an orbit may be off: the orbit itself is known to rounding, and
 * its map moves with it. */
#include "continuation.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "base/room.h"
#include "flow/room.h"

#define NEAR_BORDER                                                                                \
    100 /* of the error of rho: nearer to the border of stability it is measured                   \
         */
/* NEARLY_LOST: error of rho of the map in use, over 1 + |rho|, from which on it is measured */
#define NEARLY_LOST 1e-5
/* SHARP: the same, to which each pair is brought where multipliers are asked for */
#define SHARP 1e-10
/* OFF_BORDER: of the distance from there: multipliers that are known to that tell the side. CLEAR:
 * the same, by which orbits that are the same but for rounding move them, from which on the first
 * two ways to move them tell (of 70,000 orbits between springs the others moved them by 350 times
 * as much, at most); and where it is also CLEAR of the largest multiplier, these tell before
 * Newton's method brings them back to the branch (of 55,000 that then moved them by up to 50 times
 * as much, and never by 2e-6 of either) */
#define OFF_BORDER 0.01
#define CLEAR 1e-6
/* BESIDE: of the size, under a power law: what is farther from an orbit is another one of another
 * energy, which says nothing of this one, and whose flight may take seconds */
#define BESIDE 0.1
/* UNKNOWN: of the size: error of an unknown, in the frame of the modes or as it is stored */
#define UNKNOWN (4 * DBL_EPSILON)
/* REFINED: error of a trace, over 1 + its size, from which on its orbit is polished, and others
 * about it in WAYS_ABOUT ways, and KNOWN up to which that says something; PLACED is the rounding,
 * of the size, of their place on the branch, LAST that of the trace itself */
#define REFINED 1e-6
#define PLACED (32 * DBL_EPSILON)
#define KNOWN 1e-3
#define LAST (16 * DBL_EPSILON)
/* SETTLED: of what they may move it by: where only that counts, and the first two ways move the
 * trace by less, they tell (of 5,700 orbits between springs the others moved it by 75 times as
 * much, at most) */
#define SETTLED 1e-3

/* UNCLEAR: times its bound by the smallest pivot, and PLAIN times that by the second singular
 * value, from which on a slope is clear of its error */
#define UNCLEAR 1e6
#define PLAIN 100
/* DIM, BLIND: bounds by the smallest pivot, in radians, between which slopes that are less are
 * looked at, too: smaller ones leave an extremum its place, and where they are larger branches are
 * hardly told apart */
#define DIM 1e-6
#define BLIND 1
/* TURNED: radians by which rounding turns the kernel vector, from which on no slope is known */
#define TURNED 0.01
/* SURELY: of a lower bound of the second singular value: nothing that rounding makes of it is less
 */
#define SURELY 0.5
/* LEFT: of the tolerance without what springs make of displacements, which are met better than they
 * may be: what a flight has been seen to round to; its constants are three times that */
#define LEFT (1 / 3.0)

enum { WAYS_ABOUT = 6 };

double ric_continuation_approach(const ric_shooting *c, bool springs)
{
    const ric_model *m = c->model;
    double least = HUGE_VAL;
    if (c->start == RIC_MIRROR_IMPACT) least = c->approach[0];
    for (int k = 1; k <= c->n_flight; k++) {
        if (c->face[k] < 0) continue;
        bool spring = m->face[c->face[k]].spring > 0,
             closes = spring && ric_face_in(c->closed[k], c->face[k]);
        if (!spring || springs)
            least = fmin(least, !spring || closes ? c->approach[k] : -c->approach[k]);
    }
    return least;
}

/* Of the size: error of each unknown. Where springs close, velocities are as wrong as the
 * displacement at which they did makes them, and touches that are short pass all stabilities within
 * that. A part of the tolerance, whose own safety RIC_MEASURED gives back. */
static double of_unknown(const ric_shooting *c)
{
    return ric_flight_law_of(c->model)->closes
               ? fmax(UNKNOWN, ric_continuation_tolerance(c) / RIC_MEASURED)
               : UNKNOWN;
}

double ric_continuation_beside(const ric_shooting *c)
{
    return ric_flight_law_of(c->model)->integrated ? BESIDE * c->scale : DBL_MAX;
}

bool ric_continuation_move(const ric_shooting *c, const double *u, double *out)
{
    int size = c->n_unknown;
    double plane[2 * size], second;
    if (!ric_shooting_plane(c, plane, &second)) return false;
    /* beside another branch the two directions are exchanged by as little as is known of the orbit;
     * elsewhere the one along the branch counts for nothing */
    const double far = ric_continuation_tolerance(c) * c->scale / second,
                 each = of_unknown(c) * c->scale;
    for (int way = 1; way <= RIC_TRACE_WAYS; way++, out += size) {
        unsigned bits = (unsigned)way * 2654435769u;
        const double across = way & 1 ? far : -far, along = way & 2 ? far : -far;
        for (int i = 0; i < size; i++)
            out[i] = u[i] + ric_moved(&bits, each) + across * plane[i] + along * plane[size + i];
    }
    return far <= ric_continuation_beside(c);
}

/* How a slope changes between u and orbits that are the same but for rounding, at off along v to
 * either side, and how far the kernel vector t turns to there, in radians. */
typedef struct {
    double change, turn;
} beside;

static beside measure_beside(ric_shooting *c, const double *u, const double *t, int test,
                             double off, const double *v)
{
    const int size = c->n_unknown;
    const double here = ric_continuation_slope(c, test, t);
    double w[size], other[size];
    beside most = {0};
    for (int side = -1; side <= 1; side += 2) {
        for (int i = 0; i < size; i++) w[i] = u[i] + side * off * v[i];
        ric_shooting_evaluate(c, w);
        ric_continuation_tangent(c, t, other);
        const double change = fabs(ric_continuation_slope(c, test, other) - here),
                     along = ric_dot(size, t, other);
        for (int i = 0; i < size; i++) other[i] -= along * t[i];
        const double turn = atan2(sqrt(ric_dot(size, other, other)), along);
        most.change = fmax(most.change, isfinite(change) ? change : HUGE_VAL);
        most.turn = fmax(most.turn, isfinite(turn) ? turn : HUGE_VAL);
    }
    ric_shooting_evaluate(c, u);
    return most;
}

/* Beside a branch point the kernel vector t mixes with the direction v of the second smallest
 * singular value: by rounding / sigma, and by the distance rounding / sigma, towards the other
 * branch, at which the orbit is, over that from the branch point, of which sigma is a measure. The
 * slope is off by that times the slope along v. The smallest pivot may be 10^4 times sigma, and the
 * slope along v changes within that distance: where the bound by the pivot is not clear of the
 * slope, what it is off by is measured. Where frequencies are nearly equal sigma is small all along
 * a branch, and no measure of a distance: whether t turns is measured, too. */
double ric_continuation_slope_error(ric_shooting *c, const double *u, const double *t, int test,
                                    double slope)
{
    const double pivot = ric_continuation_blur(c, test), slant = fabs(slope);
    const bool clear = slant > pivot;
    double plane[2 * c->n_unknown], second;
    if (!(clear ? slant < UNCLEAR * pivot : pivot > DIM && pivot < BLIND)) return pivot;
    const double left = fmax(c->residual, LEFT * ric_continuation_tolerance(c) / (1 + c->stiff)),
                 least = SURELY * ric_shooting_least(c),
                 plain = PLAIN * left / least * (1 + 1 / least);
    if (slant > plain) return plain;
    if (!ric_shooting_plane(c, plane, &second)) return HUGE_VAL;
    const double mixed = left / second, most = mixed * (1 + 1 / second);
    if (slant > PLAIN * most) return PLAIN * most;
    if (!(mixed <= TURNED)) return HUGE_VAL;
    const beside seen = measure_beside(c, u, t, test, mixed * c->scale, plane);
    if (clear && most <= TURNED) return seen.change;
    return RIC_MEASURED * seen.turn <= TURNED ? RIC_MEASURED * (seen.change + mixed) : HUGE_VAL;
}

/* How far the nearest of the pairs `rho` [2 count] is from one. */
static double off_pair(int count, const double *rho, const double *one)
{
    double off = HUGE_VAL;
    for (int i = 0; i < count; i++)
        off = fmin(off, hypot(rho[2 * i] - one[0], rho[2 * i + 1] - one[1]));
    return off;
}

/* How far inside the stable region all rho of the map in use are, or, negative, how far outside the
 * farthest is, x, as 2 x / (2 + x): beside a grazing rho runs through infinity, and is outside on
 * both sides of it. *pair, unless NULL: the one that is nearest to the border, or farthest beyond
 * it. */
static double stable_margin(const ric_floquet *f, int *pair)
{
    double least = HUGE_VAL;
    for (int i = 0; i < f->n_pair; i++) {
        double inside = 2 - fabs(f->own[2 * i]), aside = -fabs(f->own[2 * i + 1]);
        double margin = aside < 0 ? fmin(inside, aside) : inside;
        if (pair && margin < least) *pair = i;
        least = fmin(least, margin);
    }
    return least < 0 ? (isinf(least) ? -2 : 2 * least / (2 - least)) : least;
}

/* What an error of rho is in the margin. */
static double steepness(double margin)
{
    return margin < 0 ? (2 + margin) / 2 * ((2 + margin) / 2) : 1;
}

/* Error of rho, over 1 + |rho|, that leaves the side of the border. */
static double tells_side(const ric_floquet *f)
{
    const double margin = stable_margin(f, NULL);
    double most = 0;
    for (int i = 0; i < f->n_pair; i++) most = fmax(most, hypot(f->own[2 * i], f->own[2 * i + 1]));
    return OFF_BORDER * fabs(margin) / (steepness(margin) * (1 + most));
}

/* What is asked of orbits that are the same but for rounding: their multipliers to `enough`, and no
 * more of them once the first pair is known to no better than `lost` and the flag is lost, or
 * plays no part. */
typedef struct {
    double enough, lost;
    bool no_flag;
} question;

/* The flag and, in seen [n_pair] unless NULL, the error of each pair, by orbits that are the same
 * but for rounding: f is again that of u afterwards, undecided where one of them, with a margin,
 * may be on the other side of the border. */
static ric_status measure(ric_shooting *c, const double *u, ric_floquet *f, question ask,
                          double *seen)
{
    enum { WAYS = RIC_TRACE_WAYS };
    static const int order[WAYS] = {0, 2, 1, 3}; /* the first two to either side of both ways */
    int k = f->n_pair, size = c->n_unknown, worst = 0;
    double rho[2 * k], own[2 * k], each[k], moved[WAYS * size], margin = stable_margin(f, &worst),
                                                                off = 0;
    ric_floquet kept = *f;
    /* one pair outside is enough: the others may be known less */
    double error = (margin < 0 ? f->each[worst] : f->error) * steepness(margin);
    ric_status status = RIC_OK;
    const bool known = ric_continuation_move(c, u, moved);
    memcpy(rho, f->rho, sizeof rho);
    memcpy(own, f->own, sizeof own);
    memcpy(each, f->each, sizeof each);
    if (seen) memset(seen, 0, (size_t)k * sizeof *seen);
    f->enough = ask.enough;
    f->coarse = !seen && !(f->sharp > 0);
    for (int sample = 0; sample < 2 * WAYS && known && !status; sample++) {
        /* each as it is moved, and when Newton's method has brought it back to the branch; of the
         * flag alone the first two are asked as they are moved before that */
        const bool both = !seen && sample < 4, back = both ? sample / 2 : sample % 2;
        double *v = moved + order[both ? sample % 2 : sample / 2] * size;
        if (!seen && ((sample == 2 && error + off < CLEAR * fmin(fabs(margin), 2 + margin)) ||
                      (sample == 4 && error + off < CLEAR * fabs(margin))))
            break;
        /* where several impacts are slow at once the equations leave more directions open than the
         * two that ric_continuation_move knows, and the orbit at which Newton's method ends lies
         * along all of them */
        if (back && !ric_continuation_correct_beside(c, v)) continue;
        ric_shooting_fly(c, v);
        if ((status = ric_floquet_compute(c, f))) break;
        off = fmax(off, RIC_MEASURED * fabs(stable_margin(f, NULL) - margin));
        for (int i = 0; i < k && seen; i++)
            seen[i] = fmax(seen[i], RIC_MEASURED * off_pair(k, f->rho, rho + 2 * i));
        if ((ask.no_flag || !(fabs(margin) > error + off)) &&
            (!seen || each[0] + seen[0] > ask.lost))
            break;
    }
    ric_shooting_fly(c, u);
    memcpy(f->rho, rho, sizeof rho);
    memcpy(f->own, own, sizeof own);
    memcpy(f->each, each, sizeof each);
    *f = kept;
    for (int i = 0; i < k && !known && seen; i++) seen[i] = HUGE_VAL;
    if (!known || !(fabs(margin) > error + off)) f->stable = RIC_STABLE_UNDECIDED;
    return status;
}

/* The trace of the orbit that is nearest to v, in extended precision: rho and own of f. *moved: how
 * far v is off. */
static bool polish(ric_shooting *c, const double *v, ric_floquet *f, double *moved)
{
    long double orbit[2 * c->n + c->n_flight];
    if (!ric_floquet_fine_orbit(c, v, orbit, moved)) return false;
    f->orbit = orbit;
    const bool found = !ric_floquet_compute(c, f) && isfinite(f->rho[0]) && isfinite(f->own[0]);
    f->orbit = NULL;
    return found;
}

/* The flag of a trace of two modes that is known to `error` on the chain's own map. */
static ric_stability side_of(const ric_floquet *f, double error)
{
    const double margin = 2 - fabs(f->own[0]);
    if (!(fabs(margin) > error)) return RIC_STABLE_UNDECIDED;
    return margin > 0 ? RIC_STABLE_YES : RIC_STABLE_NO;
}

bool ric_continuation_still(const ric_shooting *c)
{
    const double none = ric_continuation_rounding(c) * c->scale;
    for (int k = c->start == RIC_MIRROR_IMPACT ? 0 : 1; k <= c->n_flight; k++)
        if (c->face[k] >= 0 && !(c->model->face[c->face[k]].spring > 0) &&
            fabs(c->approach[k]) < none)
            return true;
    return false;
}

/* What was seen of each pair counts. Where a stop is met without speed a trace is lost, and the
 * side of the border, too, unless rho runs through infinity (stable_margin). */
static void widen(const ric_shooting *c, ric_floquet *f, double *seen)
{
    if (f->n_pair == 1 && ric_continuation_still(c)) {
        if (f->each[0] + seen[0] <= KNOWN * (1 + fabs(f->rho[0]))) f->stable = RIC_STABLE_UNDECIDED;
        seen[0] = HUGE_VAL;
    }
    ric_floquet_widen(f, seen);
}

/* Two modes, of whose trace more than a part REFINED is uncertain, `known`. The orbit is brought to
 * rounding of extended precision, and so are others that are the same but for rounding of u: what
 * their traces differ by is both what is not known of the place on the branch and what is rounded
 * on the way. The bound of the rounding is larger by up to ten powers of ten where the map has
 * large entries, and so are the traces of orbits that are not solved as well. Which orbit is the
 * nearest depends on what is measured: at a closing, not a mirror point, it was another by
 * 90 epsilon of the size at most, and RIC_MEASURED times PLACED is told. False: f is as before;
 * also where the polished orbit is farther from u than its equations are met, beside a branch
 * point: then the trace is not that of what is stored; and where a stop is met without speed.
 * *short_of: whether that is so only because what is `known` is no more; NULL: f's error is asked
 * for, too. */
static bool refine(ric_shooting *c, const double *u, ric_floquet *f, double known, bool *short_of)
{
    const int size = c->n_unknown;
    double v[size], moved = 0, off = 0, own_off = 0;
    if (short_of) *short_of = false;
    if (f->n_pair != 1 || known <= REFINED * (1 + fabs(f->rho[0])) || !ric_floquet_fine_fits(c) ||
        ric_continuation_still(c))
        return false;
    const ric_floquet before = *f;
    const double rho = f->rho[0], own = f->own[0], bound = f->each[0];
    bool found = polish(c, u, f, &moved);
    const ric_floquet at = *f;
    const double trace = f->rho[0], at_own = f->own[0];
    found = found && moved <= ric_continuation_tolerance(c) * c->scale;
    const double near = PLACED * c->scale + moved, worst = KNOWN * (1 + fabs(trace)),
                 most = fmin(known, worst);
    for (int way = 1; way <= WAYS_ABOUT && found && off < most; way++) {
        unsigned bits = (unsigned)way * 2654435769u;
        for (int i = 0; i < size; i++) v[i] = u[i] + ric_moved(&bits, near);
        found = polish(c, v, f, &moved);
        off = fmax(off, RIC_MEASURED * fabs(f->rho[0] - trace));
        own_off = fmax(own_off, RIC_MEASURED * fabs(f->own[0] - at_own));
        if (short_of && way == 2 && off < SETTLED * most &&
            own_off < SETTLED * fabs(2 - fabs(at_own)))
            break;
    }
    ric_shooting_evaluate(c, u);
    /* what is lost all the same has its flag from how rho runs through infinity (stable_margin) */
    if (short_of) *short_of = found && !(off < known) && off < worst;
    found = found && off < most;
    *f = found ? at : before;
    f->rho[0] = found ? trace : rho;
    f->own[0] = found ? at_own : own;
    f->each[0] = found ? LAST * (1 + fabs(trace)) : bound;
    if (!found) return false;
    f->stable = side_of(f, own_off + LAST * (1 + fabs(at_own)));
    ric_floquet_widen(f, &off);
    return true;
}

/* The bounds of floquet.c are those of the map at the orbit as it is written down. The orbit itself
 * is known to rounding / pivot, and its map moves with it, by 1 / speed as much where an impact is
 * slow or a spring is hardly closed. What is so near to the border that this may count is measured,
 * and a trace of which it may leave less than three digits, as at a grazing, is lost if it does:
 * where the map is known, too, the speed of an impact may be known to no more than that. Where
 * branches meet at no slow impact it stays: there it is 2 or -2. */
typedef struct {
    bool flag, trace; /* what may be wrong */
} doubt;

static doubt doubt_of(const ric_shooting *c, const ric_floquet *f)
{
    double approach = fmax(fabs(ric_continuation_approach(c, true)), DBL_MIN),
           margin = stable_margin(f, NULL);
    const double error = f->rough * (1 + (1 + 1 / approach) * c->scale / c->smallest),
                 slow = f->rough / approach, stiff = f->rough * (1 + c->stiff);
    const bool far = !ric_flight_law_of(c->model)->closes &&
                     !(fabs(margin) <= NEAR_BORDER * error * steepness(margin)),
               touched = !(UNKNOWN * c->scale <= NEARLY_LOST * approach);
    return (doubt){.flag = f->stable != RIC_STABLE_UNDECIDED && !far,
                   .trace = f->n_pair == 1 && (touched || !(fmax(slow, stiff) <=
                                                            NEARLY_LOST * (1 + fabs(f->own[0]))))};
}

bool ric_continuation_doubtful(const ric_shooting *c, const ric_floquet *f)
{
    const doubt d = doubt_of(c, f);
    return f->n_pair > 0 &&
           (d.flag || d.trace || (f->n_pair > 1 && f->stable == RIC_STABLE_UNDECIDED));
}

/* The flag of multipliers each of which is found again by itself, and of orbits that are known as
 * well: where several are near the border, or near each other, what is known of all may not say on
 * which side one is. */
static ric_status judge_sharply(ric_shooting *c, const double *u, ric_floquet *f)
{
    ric_shooting_evaluate(c, u);
    f->sharp = SHARP;
    ric_status status = ric_floquet_compute(c, f);
    if (!status && f->stable != RIC_STABLE_UNDECIDED)
        status = measure(c, u, f, (question){.lost = HUGE_VAL}, NULL);
    f->sharp = 0;
    return status;
}

/* Trace and flag of two modes, of which nothing else is asked. What the first orbits leave less of
 * than REFINED is polished; how uncertain it is otherwise matters where that says nothing, and only
 * up to where the trace is lost, unless it is what the polished one has to be better than. */
static ric_status judge_trace(ric_shooting *c, const double *u, ric_floquet *f)
{
    const double size = 1 + fabs(f->rho[0]);
    const ric_stability stable = f->stable;
    question ask = {.lost = REFINED * size, .no_flag = true};
    bool again = true;
    double seen = 0;
    ric_status status = measure(c, u, f, ask, &seen);
    if (status || refine(c, u, f, f->each[0] + seen, &again)) return status;
    if (f->each[0] + seen > ask.lost) {
        ric_shooting_evaluate(c, u);
        f->stable = stable;
        ask = (question){.lost = KNOWN * size};
        do {
            status = measure(c, u, f, ask, &seen);
            if (status || refine(c, u, f, f->each[0] + seen, &again)) return status;
            again = again && ask.lost < HUGE_VAL;
            ask.lost = HUGE_VAL;
        } while (again);
    }
    widen(c, f, &seen);
    return RIC_OK;
}

/* The only pair of an orbit of which just the flag is in doubt: that of the polished orbit, which
 * is the answer where multipliers are asked for. The first orbits that lose the flag tell whether
 * there is a need. */
static ric_status judge_polished(ric_shooting *c, const double *u, ric_floquet *f)
{
    double seen;
    bool short_of;
    ric_status status = measure(c, u, f, (question){0}, &seen);
    if (status || f->each[0] + seen <= REFINED * (1 + fabs(f->rho[0]))) return status;
    status = measure(c, u, f, (question){.lost = HUGE_VAL}, &seen);
    if (!status) refine(c, u, f, f->each[0] + seen, &short_of);
    return status;
}

ric_status ric_continuation_judge(ric_shooting *c, const double *u, ric_floquet *f)
{
    ric_status status = RIC_OK;
    if (!ric_continuation_doubtful(c, f)) return RIC_OK;
    if (doubt_of(c, f).trace) return judge_trace(c, u, f);
    if (f->stable != RIC_STABLE_UNDECIDED)
        status = measure(c, u, f, (question){tells_side(f), HUGE_VAL, false}, NULL);
    if (!status && f->stable == RIC_STABLE_UNDECIDED) status = judge_sharply(c, u, f);
    if (status || f->stable != RIC_STABLE_UNDECIDED || f->n_pair != 1) return status;
    return judge_polished(c, u, f);
}

ric_status ric_continuation_multipliers(ric_shooting *c, const double *u, ric_floquet *f)
{
    double seen[f->n_pair + 1];
    ric_shooting_evaluate(c, u);
    f->sharp = SHARP;
    ric_status status = ric_floquet_compute(c, f);
    if (status || f->n_pair < 1) return status;
    status = measure(c, u, f, (question){.lost = HUGE_VAL}, seen);
    if (!status && !refine(c, u, f, f->each[0] + seen[0], NULL)) widen(c, f, seen);
    return status;
}
