/* What a stored point says beside its orbit: frequency, reach, approach, multipliers and stability,
 * recomputed on the replay (docs/theory.md section 11). Nothing here is solved: the stored state is
 * flown for the stored times.
 *
 * Multipliers: columns of the variational equations are flown in closed form. At an impact, with dt
 * = -(c.dq) / (c.p), a the acceleration of the flight that ends there, closed springs included, and
 * R = I - 2 c c' / (c.c),
 *     dq <- R dq,   dp <- R dp - dt 2 (c.a) / (c.c) c        (saltation: Aizerman and Gantmakher
 *                   1958);
 * a spring that closes or opens changes nothing. Where z(t + T/2) = -z(t) half a period does, as M
 * = H^2. */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>

#include "base/room.h"
#include "verify_pairs.h"
#include "verify_parts.h"
#include "verify_reach.h"
#include "verify_smooth.h"

/* NOISE: of a flight and an impact in double, relative to the norm: as many roundings */
#define NOISE (8 * DBL_EPSILON)
/* NUMBER: largest relative error of a frequency, and of a speed over the largest */
#define NUMBER 1e-11
#define MOST_OPEN 1e-11 /* no orbit that is more than this open passes */
#define UNSEEN 1e-12    /* part of a normal below which a mode is not seen */
/* BACK: an orbit that repeats itself is after part of the period where it began, to this part */
#define BACK 1e-6
/* TOLD: of its size: from here on two states of an orbit that is solved once more are two */
#define TOLD 1e-9
#define IMAGE 1e-9 /* half a period later a symmetric orbit is its image to this part */
/* FAULT: relative, and LEAST: a reach or an approach that is off by this is found, or it is said */
#define FAULT 1e-6
#define LEAST 1e-8
#define NO_SPEED 1e-60 /* relative: no impact is slower */

/* ------------------------------------------------------------- multipliers */

typedef struct {
    replay *r;
    real level; /* of noise */
    real growth;
    unsigned bits;
    int n_seen, *seen; /* of each direction that is seen a mode of its frequency */
    real *share;       /* [n_seen * n] and what it is made of */
} motion;

static void add_noise(motion *m, int size, real norm, real *w)
{
    if (!(m->level > 0)) return;
    for (int i = 0; i < size; i++) w[i] += m->level * norm * ric_verify_pairs_noise(&m->bits);
}

static bool is_alike(const replay *r, int i, int j)
{
    return r->frequency[i] == r->frequency[j];
}

/* Adds what face f has of the modes as frequent as mode i, perpendicular to the directions from
 * `first` on, as one more direction; where that is none, nothing. */
static int add_share(const replay *r, int i, int f, int first, int count, real *share)
{
    int n = r->n;
    const face_t *face = &r->face[f];
    real *b = share + count * n;
    for (int j = 0; j < n; j++) b[j] = j >= i && is_alike(r, i, j) ? face->c[j] : 0;
    for (int twice = 0; twice < 2; twice++)
        for (int k = first; k < count; k++) {
            real along = ric_replay_dot(n, b, share + k * n);
            for (int j = 0; j < n; j++) b[j] -= along * share[k * n + j];
        }
    real size = sqrt(ric_replay_dot(n, b, b));
    if (!(size > UNSEEN * sqrt(face->cc))) return count;
    size = copysign(size, b[i]); /* a mode alone is itself */
    for (int j = 0; j < n; j++) b[j] /= size;
    return count + 1;
}

int ric_verify_seen(const replay *r, int *seen, real *share)
{
    int count = 0;
    for (int i = 0; i < r->n; i++) {
        bool before = false;
        int first = count;
        for (int j = 0; j < i; j++) before |= is_alike(r, j, i);
        for (int f = 0; f < r->n_face && !before; f++)
            count = add_share(r, i, f, first, count, share);
        for (int k = first; k < count; k++) seen[k] = i;
    }
    return count;
}

/* Of a vector over the modes what lies along direction k. */
static real along(const motion *m, int k, const real *x)
{
    return ric_replay_dot(m->r->n, m->share + k * m->r->n, x);
}

/* A column (kappa dq, dp) [2n] through flight k of length t, without its end; trig [2n]: cos and
 * sin of omega t. */
static void fly_column(const replay *r, int k, real t, const real *trig, real *column)
{
    int n = r->n;
    if (r->closed) {
        for (int i = 0; i < n; i++) column[i] /= r->kappa[i];
        if (ric_simulator_fly(r->sim, r->closed + (size_t)k * (size_t)r->n_face, true, t, column,
                              column))
            column[0] = NAN;
        for (int i = 0; i < n; i++) column[i] *= r->kappa[i];
        return;
    }
    for (int i = 0; i < n; i++) {
        real a = column[i], p = column[n + i], cosine = trig[i], sine = trig[n + i];
        if (!(r->omega[i] > 0)) {
            column[i] = a + r->kappa[i] * t * p;
            continue;
        }
        column[i] = a * cosine + p * sine;
        column[n + i] = p * cosine - a * sine;
    }
}

/* Saltation of a column at an impact that is met at w, before it. */
static void strike_column(const replay *r, const face_t *face, const real *w, const real *pull,
                          real *column)
{
    int n = r->n;
    real gap = 0, push = 0, speed = ric_replay_dot(n, face->c, w + n),
         least = NO_SPEED * ric_replay_fastest(r, face);
    if (fabs(speed) < least) speed = copysign(least, speed);
    for (int i = 0; i < n; i++) {
        gap += face->c[i] * column[i] / r->kappa[i];
        push += face->c[i] * column[n + i];
    }
    real kick = -gap / speed * ric_replay_dot(n, face->c, pull);
    for (int i = 0; i < n; i++) {
        column[i] -= r->kappa[i] * 2 * gap / face->cc * face->c[i];
        column[n + i] -= 2 * (push + kick) / face->cc * face->c[i];
    }
}

static real size_of(int n, const real *x)
{
    return sqrt(ric_replay_dot(n, x, x));
}

/* Columns [columns * 2n] through flight k and its end. */
static void carry(motion *m, int k, int columns, real *A)
{
    replay *r = m->r;
    int n = r->n;
    const face_t *face = ric_replay_end_face(r, k);
    real w[2 * n], pull[n], trig[2 * n],
        t = r->tau[k] * (1 + m->level * ric_verify_pairs_noise(&m->bits));
    memcpy(w, r->chain + (size_t)k * 2 * (size_t)n, sizeof w);
    for (int i = 0; i < n; i++) w[i] *= r->kappa[i];
    add_noise(m, 2 * n, r->norm, w);
    for (int i = 0; i < n; i++) w[i] /= r->kappa[i];
    ric_replay_fly(r, k, t, w, w);
    ric_replay_accelerations(r, k, w, pull);
    for (int i = 0; i < n; i++) sincosl(r->omega[i] * t, trig + n + i, trig + i);
    for (int j = 0; j < columns; j++) {
        real *column = A + (size_t)j * 2 * (size_t)n;
        fly_column(r, k, t, trig, column);
        if (!(face->spring > 0)) strike_column(r, face, w, pull, column);
        real size = size_of(2 * n, column);
        m->growth = fmax(m->growth, size);
        add_noise(m, 2 * n, m->growth,
                  column); /* entries are known to the rounding of the largest on the way */
    }
}

/* Whether the second half of the orbit is the image of the first, in which every face is met on its
 * other side. */
static bool is_image(const replay *r)
{
    int N = r->n_event, half = N / 2;
    if (!r->branch.symmetric || N % 2 || N == 0) return false;
    for (int k = 0; k < half; k++) {
        const face_t *a = &r->face[r->event[k]], *b = &r->face[r->event[k + half]];
        if (a->contact != b->contact || a->side == b->side) return false;
    }
    real image[2 * r->n];
    const real *w = r->chain + (size_t)half * 2 * (size_t)r->n;
    for (int i = 0; i < 2 * r->n; i++) image[i] = -w[i];
    return ric_replay_distance(r, image, r->chain) <= IMAGE * r->norm;
}

/* A flight with the springs that push at the start of the orbit: one that has just closed does not
 * yet, whatever it makes of the last digit of its gap. */
static int first_pushed(const replay *r)
{
    const int last = r->n_flight - 1;
    const face_t *face = ric_replay_end_face(r, last);
    return face && face->spring > 0 && !ric_replay_opens(r, last) ? last : 0;
}

/* rho of one run. */
static bool run_once(motion *m, bool half, ric_pair *rho, int *way)
{
    replay *r = m->r;
    int n = r->n, s = m->n_seen, size = 2 * s, flights = half ? r->n_event / 2 : r->n_event;
    size_t square = (size_t)size * (size_t)size;
    real *A = ric_calloc((size_t)size * 2 * (size_t)n + 2 * square, sizeof *A), force[n],
         flow[size], gradient[size];
    if (!A) return false;
    real *M = A + (size_t)size * 2 * (size_t)n, *J = M + square;
    for (int j = 0; j < size; j++)
        memcpy(A + (size_t)j * 2 * (size_t)n + (j < s ? 0 : n), m->share + j % s * n,
               (size_t)n * sizeof *A);
    for (int k = 0; k < flights; k++) carry(m, k, size, A);
    for (int i = 0; i < size; i++)
        for (int j = 0; j < size; j++)
            M[i * size + j] = (half ? -1 : 1) *
                              along(m, i % s, A + (size_t)j * 2 * (size_t)n + (i < s ? 0 : n));
    ric_replay_accelerations(r, first_pushed(r), r->chain, force);
    for (int i = 0; i < s; i++) {
        int k = m->seen[i];
        real speed = along(m, i, r->chain + n), push = along(m, i, force);
        flow[i] = r->kappa[k] * speed;
        flow[s + i] = push;
        gradient[i] = -push / r->kappa[k];
        gradient[s + i] = speed;
        J[i * size + s + i] = 1 / r->kappa[k];
        J[(s + i) * size + i] = -1 / r->kappa[k];
    }
    bool found = ric_verify_pairs_find(size, M, J, flow, gradient, rho, way);
    free(A);
    return found;
}

/* What the rounding of a displacement becomes through a stiff spring: frequencies with it over the
 * lowest without. */
static real stiffness(const replay *r)
{
    real low = INFINITY, high = 0, spring = 0;
    for (int i = 0; i < r->n; i++) {
        high = fmax(high, r->omega[i]);
        if (r->omega[i] > 0) low = fmin(low, r->omega[i]);
    }
    for (int f = 0; f < r->n_face; f++) spring = fmax(spring, r->face[f].spring * r->face[f].cc);
    return r->closed && isfinite(low) ? sqrt(high * high + spring) / low : 1;
}

/* What the stored digits leave open, relative: the gaps where the orbit meets faces, and its end.
 */
static real left_open(const replay *r)
{
    size_t step = 2 * (size_t)r->n;
    real open = ric_replay_distance(r, r->chain + (size_t)r->n_flight * step, r->chain) / r->norm;
    for (int k = 0; k < r->n_flight; k++) {
        const face_t *face = ric_replay_end_face(r, k);
        open = fmax(open,
                    fabs(ric_replay_gap(r, face, r->chain + (size_t)(k + 1) * step)) / face->limit);
    }
    return fmin(open, MOST_OPEN);
}

/* The orbit a little along the branch, towards the next stored point, by as much as the stored
 * digits leave any state open over RIC_PAIR_SAFETY: rounding moves an orbit along its family, too,
 * and multipliers may change there by far more than their own rounding. Where there is no other
 * point nothing is moved. */
static ric_status move_along(replay *r, const ric_atlas *atlas, int i, const ric_digits *d)
{
    const int n = r->n, N = r->n_event;
    double *state = ric_calloc(2 * (size_t)n + (size_t)N + 1, sizeof *state),
           *flights = state ? state + 2 * n : NULL;
    ric_point point;
    real w[2 * n];
    if (!state) return ric_no_memory("a neighbour of an orbit");
    const int beside = i + 1 < r->branch.n_point ? i + 1 : i - 1;
    ric_status status = beside < 0
                            ? RIC_OK
                            : ric_atlas_point(atlas, r->branch.id, beside, &point, state, flights);
    if (!status && beside >= 0) {
        ric_simulator_modal(r->sim, state, state + n, w);
        const real apart = ric_replay_distance(r, w, r->chain),
                   part = apart > 0 ? fmin(d->state / RIC_PAIR_SAFETY / apart, (real)0.5) : 0;
        for (int j = 0; j < 2 * n; j++) r->chain[j] += part * (w[j] - r->chain[j]);
        for (int k = 0; k < N; k++) r->tau[k] += part * (flights[k] - r->tau[k]);
        ric_replay_make_chain(r);
    }
    free(state);
    return status;
}

/* Judges again; what is no longer a finding then is not checked, as the replay of the stored state
 * does not confirm it. */
static void judge_again(const ric_pairs *p, int n_mode, const ric_point *stored, ric_claims *out)
{
    ric_claims again = *out;
    *again.finding = '\0';
    ric_verify_pairs_judge(p, n_mode, stored, &again);
    if (again.multipliers == RIC_AGREES_NO || again.stable == RIC_AGREES_NO) return;
    if (out->multipliers == RIC_AGREES_NO) again.multipliers = RIC_AGREES_UNCHECKED;
    if (out->stable == RIC_AGREES_NO) again.stable = RIC_AGREES_UNCHECKED;
    *out = again;
}

static bool is_found(const ric_claims *out)
{
    return out->multipliers == RIC_AGREES_NO || out->stable == RIC_AGREES_NO;
}

/* A trace is stored without its error: by so much as the library states when it is asked it may be
 * off. Where the orbit was polished that is more than the stored digits, replayed, leave open, and
 * is not checked by them. */
static ric_status judge_stated(ric_pairs *p, const ric_atlas *atlas, const ric_point *stored,
                               ric_verify_asked *asked, ric_claims *out)
{
    ric_status status = ric_verify_asked_open(atlas, out->branch, out->point, NULL, asked);
    if (!status && asked->given) {
        p->asked = asked;
        judge_again(p, 2, stored, out);
    }
    return status;
}

/* What is known of an orbit that its conditions hardly hold may lie rounding over that hold beside
 * the stored state: by as much as the nearest orbit has other multipliers they may be off, and are
 * not checked by the replay of that state. */
static ric_status judge_nearest(motion *m, ric_pairs *p, const ric_atlas *atlas, ric_claims *out)
{
    const int last = p->runs;
    replay r = {0};
    bool found = false;
    ric_status status = ric_verify_replay_open(&r, atlas, out->branch, out->point, true);
    if (!status) status = ric_verify_nearest(&r, &found);
    m->r = &r;
    m->level = 0;
    m->growth = 1;
    if (found && run_once(m, p->half, p->own + last * p->n_pair, &p->way[last])) {
        p->runs = RIC_PAIR_MOST;
        judge_again(p, m->n_seen, &r.point, out);
    }
    ric_verify_replay_close(&r);
    return status;
}

/* Room for the modes that contacts see, and for what each run makes of their pairs; to be closed in
 * any case. */
static ric_status open_pairs(motion *m, ric_pairs *pairs)
{
    const size_t n = (size_t)m->r->n;
    m->bits = 20011;
    if (!(m->share = ric_malloc((n + 1) * n * sizeof *m->share)))
        return ric_no_memory("the modes that contacts see");
    m->n_seen = ric_verify_seen(m->r, m->seen, m->share);
    pairs->n_pair = m->n_seen > 1 ? m->n_seen - 1 : 0;
    pairs->own = ric_calloc((size_t)pairs->n_pair * RIC_PAIR_MOST + 1, sizeof *pairs->own);
    return pairs->own ? RIC_OK
                      : ric_fail(RIC_E_NOMEM, "no memory for %d multipliers", 2 * pairs->n_pair);
}

static void close_pairs(motion *m, ric_pairs *pairs)
{
    free(pairs->own);
    free(m->share);
}

static ric_status check_multipliers(replay *r, const ric_atlas *atlas,
                                    const ric_verify_asked *asked, const ric_digits *d,
                                    ric_claims *out)
{
    int seen[r->n];
    motion m = {.r = r, .seen = seen};
    ric_verify_asked stated = {0};
    ric_pairs pairs = {.runs = RIC_PAIR_RUNS, .half = is_image(r), .asked = asked};
    ric_status status = open_pairs(&m, &pairs);
    bool found = true;
    const real level = fmax(NOISE * stiffness(r), left_open(r));
    for (int run = 0; run < pairs.runs && found && pairs.n_pair && !status; run++) {
        const bool along = run == pairs.runs - 1; /* the last thing that is asked of the replay */
        if (along) status = move_along(r, atlas, out->point, d);
        m.level = run && !along ? level : 0;
        m.growth = 1;
        found = run_once(&m, pairs.half, pairs.own + run * pairs.n_pair, &pairs.way[run]);
    }
    const bool right = !*out->finding;
    if (found && !status) ric_verify_pairs_judge(&pairs, m.n_seen, &r->point, out);
    if (right && !status && m.n_seen == 2 && !asked->given && out->multipliers == RIC_AGREES_NO)
        status = judge_stated(&pairs, atlas, &r->point, &stated, out);
    if (right && !status && is_found(out)) status = judge_nearest(&m, &pairs, atlas, out);
    ric_verify_asked_close(&stated);
    close_pairs(&m, &pairs);
    return status;
}

/* A linear mode: its multipliers are exp(+-i omega_j T) of the other modes, and gamma = omega_j T /
 * 2 pi, modulo 1. */
static void check_linear(replay *r, ric_claims *out)
{
    int seen[r->n], other = -1;
    real part = 0, share[(r->n + 1) * r->n];
    motion m = {.r = r, .seen = seen, .share = share};
    int count = m.n_seen = ric_verify_seen(r, seen, share);
    for (int k = 0; k < count; k++)
        part += pow(r->kappa[seen[k]] * along(&m, k, r->chain), 2) +
                pow(along(&m, k, r->chain + r->n), 2);
    bool alone = part > r->norm * r->norm / 2; /* else no contact sees the mode itself */
    for (int k = 0; k < count; k++) {
        real turns = r->omega[seen[k]] * r->period / RIC_TWO_PI_LONG;
        if (fabs(turns - 1) > NUMBER && other < 0) other = seen[k];
        else alone &= fabs(turns - 1) <= NUMBER;
    }
    out->stable = r->point.stable == RIC_STABLE_YES ? RIC_AGREES_YES : RIC_AGREES_NO;
    if (out->stable == RIC_AGREES_NO)
        snprintf(out->finding, sizeof out->finding, "a linear mode is stable");
    if (count != 2 || !alone || other < 0) return;
    ric_pair own[RIC_PAIR_RUNS];
    ric_pairs pairs = {.n_pair = 1, .runs = RIC_PAIR_RUNS, .own = own};
    for (int run = 0; run < RIC_PAIR_RUNS; run++) {
        real angle = r->omega[other] * r->period * (1 + (run - 1) * (run > 0) * NOISE);
        own[run] = 2 * cos(angle);
        pairs.way[run] = sin(angle) < 0 ? -1 : 1;
    }
    ric_claims trace = *out;
    ric_point point = r->point;
    ric_verify_pairs_judge(&pairs, 2, &point, &trace);
    trace.stable = out->stable;
    *out = trace;
}

/* ------------------------------------------------------------ other numbers */

void ric_verify_disagree(ric_claims *out, const char *name, double stored, double found)
{
    out->numbers = RIC_AGREES_NO;
    if (!*out->finding)
        snprintf(out->finding, sizeof out->finding, "%s %.17g stored, %.17g found", name, stored,
                 found);
}

/* Smallest speed into a face, or out of a spring, so that the motion backwards has the same; and
 * what the digits leave of it: [0] at least, [1] at most. The solver may have begun anywhere on the
 * orbit: how far it closes counts as well. */
static void smallest_approach(const replay *r, const ric_digits *d, double approach[2])
{
    approach[0] = approach[1] = HUGE_VAL;
    for (int k = 0; k < r->n_flight; k++) {
        const face_t *face = ric_replay_end_face(r, k);
        const real *w = r->chain + (size_t)(k + 1) * 2 * (size_t)r->n;
        if (!face) continue;
        int way = face->spring > 0 && ric_replay_opens(r, k) ? -face->side : face->side;
        real speed = face->spring > 0 ? way * ric_replay_dot(r->n, face->c, w + r->n)
                                      : r->speed[k + 1];
        real left = d->speed[k];
        for (int i = 0; i < r->n; i++) left += fabs(face->c[i]) * d->close[r->n + i];
        approach[0] = fmin(approach[0], (double)(speed - left));
        approach[1] = fmin(approach[1], (double)(speed + left));
    }
}

/* How far the motion is, some events on, from where it began, of its size. */
static real off_start(const replay *r, int events)
{
    return ric_replay_distance(r, r->chain + (size_t)events * 2 * (size_t)r->n, r->chain) / r->norm;
}

/* The events after which the orbit repeats itself, by word, flights and states; all: it does not.
 */
static int events_of_shorter(const replay *r)
{
    const int N = r->n_event;
    for (int part = 1; part <= N / 2; part++) {
        bool same = N % part == 0 && off_start(r, part) <= BACK;
        for (int k = 0; same && k < N; k++)
            same = r->branch.word[k] == r->branch.word[(k + part) % N] &&
                   fabs(r->tau[k] - r->tau[(k + part) % N]) <= NUMBER * r->period;
        if (same) return part;
    }
    return N;
}

/* A branch meets orbits that repeat themselves at its ends; one between them has a period that is
 * none, and a frequency. A whole branch may lie as near to a shorter orbit as BACK: then the orbit
 * nearest to the stored one tells whether that is off its start as the stored one is. */
static ric_status check_period(const replay *r, const ric_atlas *atlas, ric_claims *out)
{
    const bool inner = out->point > 0 && out->point + 1 < r->branch.n_point;
    const int part = inner ? events_of_shorter(r) : r->n_event;
    if (part == r->n_event) return RIC_OK;
    replay q = {0};
    bool found = false;
    ric_status status = ric_verify_replay_open(&q, atlas, out->branch, out->point, true);
    if (!status) status = ric_verify_nearest(&q, &found);
    const bool apart = found && off_start(&q, part) > fmax(off_start(r, part) / 2, TOLD);
    if (!status && !apart) ric_verify_disagree(out, "repetitions", 1, r->n_event / part);
    ric_verify_replay_close(&q);
    return status;
}

static bool approach_agrees(const replay *r, const double approach[2])
{
    double stored = r->point.approach;
    if (isinf(approach[0])) return isnan(stored);
    return stored >= approach[0] && stored <= approach[1];
}

static bool reach_agrees(const ric_reached *reach)
{
    return fabs(reach->stored - reach->nearest) <= reach->near &&
           reach->stored >= reach->sure - reach->near;
}

/* A number that is off by this is found, or said not to be checked. */
static double fault(double number)
{
    return fmax(FAULT * fabs(number), LEAST);
}

static ric_status check_margins(replay *r, const ric_digits *d, ric_claims *out)
{
    double approach[2],
        near = RIC_REACHED + (r->norm > 0 ? ric_verify_reach_slack(r, d->state / r->norm) : 0);
    ric_reached reach = {.stored = isnan(r->point.reach) ? 0 : r->point.reach, .near = near};
    smallest_approach(r, d, approach);
    ric_status status = ric_verify_reach_find(r, &reach);
    if (status) return status;
    if (r->n_event && !reach_agrees(&reach)) {
        /* what is lost in rounding at the end of the period is not so before it */
        ric_replay_fold(r);
        status = ric_verify_reach_find(r, &reach);
        ric_replay_make_chain(r);
    }
    if (!status && r->n_event && !reach_agrees(&reach)) {
        reach.levels = true;
        status = ric_verify_reach_find(r, &reach);
    }
    if (!status && !reach_agrees(&reach))
        ric_verify_disagree(out, "reach", r->point.reach,
                            reach.stored < reach.sure ? reach.sure : reach.nearest);
    const double behind = NUMBER * (double)(r->norm > 0 ? r->norm : 1);
    if (approach[1] < -behind)
        ric_verify_disagree(out, "approach from behind a face", r->point.approach, approach[1]);
    if (!approach_agrees(r, approach))
        ric_verify_disagree(out, "approach", r->point.approach,
                            isinf(approach[0]) ? NAN : (approach[0] + approach[1]) / 2);
    bool more = reach.also >
                fmax(reach.sure, reach.stored) + fault(reach.stored); /* which may count or not */
    if ((more || !(2 * near < fault(r->point.reach))) && !isnan(r->point.reach))
        ric_verify_digits_doubt(out, "reach");
    if (!isinf(approach[0]) && !(approach[1] - approach[0] < fault(r->point.approach)))
        ric_verify_digits_doubt(out, "approach");
    return status;
}

static ric_status check_numbers(replay *r, const ric_digits *d, ric_claims *out)
{
    const ric_point *p = &r->point;
    double turn = RIC_TWO_PI, omega = (double)(turn / r->period);
    if (!(fabs(p->frequency - omega) <= NUMBER * omega))
        ric_verify_disagree(out, "frequency", p->frequency, omega);
    if (!(ric_replay_part(fabs(p->energy - r->energy), r->energy) <= NUMBER))
        ric_verify_disagree(out, "energy", p->energy, r->energy);
    return check_margins(r, d, out);
}

ric_status ric_verify_claims(const ric_atlas *atlas, int branch, int i, ric_claims *out)
{
    replay r = {0};
    *out = (ric_claims){.branch = branch,
                        .point = i,
                        .multiplier_error = NAN,
                        .multiplier_bound = NAN,
                        .multipliers = RIC_AGREES_UNCHECKED,
                        .stable = RIC_AGREES_UNCHECKED,
                        .numbers = RIC_AGREES_UNCHECKED};
    ric_check check;
    ric_verify_asked asked = {0};
    if (ric_model_n_face(ric_atlas_model(atlas)) == 0)
        return ric_trust(ric_verify_smooth(atlas, branch, i, &check, out));
    ric_status status = ric_verify_replay_open(&r, atlas, branch, i, true);
    ric_digits digits = {0};
    if (!status) status = ric_verify_digits_open(&r, &digits);
    if (!status) {
        out->numbers = RIC_AGREES_YES;
        ric_verify_digits_judge(&r, &digits, out);
        status = check_numbers(&r, &digits, out);
    }
    if (!status) status = check_period(&r, atlas, out);
    if (!status && r.n_event == 0) check_linear(&r, out);
    else if (!status && !(status = ric_verify_asked_open(atlas, branch, i, &r.point, &asked)))
        status = check_multipliers(&r, atlas, &asked, &digits, out);
    ric_verify_asked_close(&asked);
    ric_verify_digits_close(&digits);
    ric_verify_replay_close(&r);
    return ric_trust(status);
}
