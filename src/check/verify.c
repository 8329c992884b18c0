/* Replays a stored orbit with the simulator (docs/theory.md section 11).
 *
 * Expected chain: the stored state, flown in closed form for the stored flight times and reflected
 * at the faces of the word, in the simulator's modal frame. Both steps are isometries of the energy
 * norm |w|^2 = sum p_i^2 + omega_i^2 q_i^2, so that the chain stays exact however unstable the
 * orbit is. Flight by flight the simulator starts from the chain and has to find the next face, its
 * time and the state behind it; then it runs over a whole period without help.
 *
 * What the return may lose is measured by the largest multiplier, from variational columns that are
 * flown here: at an impact, with dt = -(c.dq) / (c.p) and R = I - 2 c c' / (c.c),
 *     dq <- R dq,   dp <- R dp + dt 2 (c.omega^2 q) / (c.c) c        (saltation: Aizerman and
 *                   Gantmakher 1958).
 * The last digit of the stored doubles may be multiplied beyond what the check allows. Nothing is
 * solved to take that away: what every stored digit can move is carried through the flights
 * (verify_digits.c), and where a flight meets its face, and the period its beginning, only what
 * lies beyond that bound is an error. A bound that hides a fault of a part in a million is said
 * with the numbers that it hides.
 *
 * A spring that is met closes and opens: the flight in between is flown with the simulator's own
 * modes of the stiffened structure, state and accelerations are continuous at both ends, and
 * variational columns go on unchanged. A contact of no length, as the end of a branch has it, is a
 * touch and left out.
 *
 * A touch is no impact: where the orbit grazes, the rounding of the state may make it strike with a
 * speed of sqrt(rounding). The replay then goes on as if the face had not been there. Only there,
 * and where impacts are nearly as slow, times are weighed by the speed. */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>

#include "base/room.h"
#include "verify_parts.h"
#include "verify_smooth.h"

#define FLIGHT 1e-11 /* largest relative error of a flight, and of the energy */
#define RETURN 1e-9  /* of the state after a period, times max(1, AMPLIFIED * multiplier) */
#define MISS 8       /* safety of the speed below which an impact may be missed */
#define AMPLIFIED 1e-7
#define LOST 1e-4    /* where rounding returns larger than this, no more is asked of the return */
#define GRAZED 1e-12 /* an error of the state beyond which a face that is touched may be struck */
#define REACH 1e-10  /* a touch shows as reach 1 -+ this */
/* CLOSED: faces that close within this part of the clearance of each other make a corner */
#define CLOSED 1e-9
/* RESTS: of the clearance: what moves by less in a period rests on a stop: places at which speeds
 * vanish are known to the root of rounding */
#define RESTS 1e-8
enum { MOST_TOUCHES = 10000 }; /* on the way to one impact */
/* LATE: an impact later than this part of a mean flight behind its time is missing */
#define LATE 1e-2

/* ------------------------------------------------------------------- replay */

static ric_status start_at(replay *r, int k, const real *w, real time)
{
    ric_status status = ric_simulator_start_modal(r->sim,
                                                  r->closed
                                                      ? r->closed + (size_t)(k % r->n_flight) *
                                                                        (size_t)r->n_face
                                                      : NULL,
                                                  w);
    r->offset = time;
    if (status != RIC_E_INPUT) return status;
    r->check->faces_agree = false; /* beyond a stop: a finding, not a mistake of the caller */
    return RIC_OK;
}

typedef struct {
    bool hit, refused; /* refused: the simulator would not go on */
    bool opens;
    int face;
    real time;
    int touches;
} event;

/* Whether the motion goes beyond the face by no more than the stored digits leave its gap open in
 * flight k, or than a touch does: it may then be met or not. */
static bool is_shallow(const replay *r, int k, const face_t *face, real speed)
{
    if (ric_replay_touches(r, k, face, r->w, speed)) return true;
    return r->digits && r->n_event &&
           speed * speed <= 2 * fabs(ric_replay_pull(r, k, face, r->w)) * r->digits->gap[k];
}

/* Where a loose mass rests on a stop nothing draws the gap apart again. What it moves by in a
 * period is rounding then, whose sign would decide whether the simulator meets the stop: it is
 * taken away. Whether it was. */
static bool came_to_rest(replay *r, const face_t *face, real speed, real fall)
{
    const real step = fabs(speed) + fabs(fall) * r->period;
    if (step * r->period > RESTS * face->limit) return false;
    for (int i = 0; i < r->n; i++) r->w[r->n + i] -= face->side * speed / face->cc * face->c[i];
    return true;
}

/* Whether every face that closes at r->w, of those that are open, is only touched; how long until
 * all are open again. `far`: so far open that the simulator can tell them apart. */
static bool only_touched(replay *r, int k, bool far, real *wait)
{
    bool rests = false;
    *wait = 0;
    for (int f = 0; f < r->n_face; f++) {
        const face_t *face = &r->face[f];
        real speed = face->side * ric_replay_dot(r->n, face->c, r->w + r->n);
        if (ric_replay_closed(r, k, f) || ric_replay_gap(r, face, r->w) < -CLOSED * face->limit)
            continue;
        bool slow = is_shallow(r, k, face, speed);
        if (speed < 0 && !slow) continue;
        real fall = ric_replay_pull(r, k, face, r->w);
        if (slow && came_to_rest(r, face, speed, fall)) {
            rests = true;
            continue;
        }
        if (!slow || fall <= 0) return false;
        *wait = fmax(*wait,
                     fmax(3 * fabs(speed) / fall, far ? sqrt(2 * CLOSED * face->limit / fall) : 0));
    }
    return rests || *wait > 0;
}

/* Flies on from a touch in closed form until the gap is open again. The simulator cannot do so
 * where two faces are touched together: it sees impacts that disturb each other, however slow. */
static void pass_touch(const replay *r, int k, real wait, event *e)
{
    ric_replay_fly(r, k, wait, r->w, r->w);
    e->time += wait;
}

/* Whether a hit at r->w is an impact of the orbit: the word has one of that speed at the end of
 * flight k, due at time `due`, or it goes deeper than a touch. */
static bool is_impact(const replay *r, const ric_impact *impact, real time, int k, real due)
{
    const face_t *face = &r->face[impact->face];
    return !is_shallow(r, k, face, impact->approach) ||
           (face == ric_replay_end_face(r, k) &&
            fabs(time - due) <= LATE * r->period / r->n_flight &&
            fabs(fabs(impact->approach) - r->speed[k + 1]) <= r->speed[k + 1] / 2);
}

/* Runs to the next impact, at most to time `end`, and passes touches; flight k ends at time `due`.
 * r->w is the state there. */
static ric_status run_to_impact(replay *r, int k, real due, real end, event *e)
{
    *e = (event){.time = r->offset};
    while (!e->refused) {
        ric_impact impact;
        double before;
        ric_simulator_state(r->sim, &before, NULL, NULL);
        ric_status status = ric_simulator_advance(r->sim, fmax(before, (double)(end - r->offset)),
                                                  &e->hit, &impact);
        e->refused = status == RIC_E_NUMERIC;
        if (status && !e->refused) return status;
        ric_simulator_state_modal(r->sim, &e->time, r->w);
        e->time += r->offset;
        r->reach = fmax(r->reach, ric_simulator_reach(r->sim));
        if (!e->hit && !e->refused) break;
        e->face = e->hit ? impact.face : -1;
        e->opens = e->hit && impact.opens;
        if (e->hit && is_impact(r, &impact, e->time, k, due)) break;
        const face_t *struck = e->hit ? &r->face[e->face] : NULL;
        real wait;
        if (struck) ric_replay_reflect(r, struck, r->w); /* undoes its impulse */
        const bool passes = only_touched(r, k, !struck, &wait),
                   contact = struck && struck->spring > 0;
        e->refused = !passes && !contact;
        if (e->refused) break;
        r->touched = true;
        e->hit = false;
        /* where a spring is touched at rest time does not go on */
        e->refused = ++e->touches > MOST_TOUCHES;
        if (e->refused) break;
        /* What digits make of the touch of a spring that is open is no contact, as a stiff one
         * would turn its speed round. Any other the simulator passes by itself. */
        if (contact && (e->opens || !passes)) continue;
        /* an impact that falls on the same instant is not flown over */
        const real until = e->time < due ? fmin(due, end) : end;
        pass_touch(r, k, fmin(wait, until - e->time), e);
        if (e->time >= end) break;
        if ((status = start_at(r, k, r->w, e->time))) return status;
        if (!r->check->faces_agree) break;
    }
    return RIC_OK;
}

/* Energy of the simulator's own state, from the raw matrices. */
static double simulated_energy(replay *r)
{
    ric_simulator_state(r->sim, NULL, r->x, r->x + r->n);
    return ric_model_energy(r->model, r->x, r->x + r->n);
}

/* `left` may have been gained or lost. */
static void check_energy(replay *r, real left)
{
    const real error = fmax(0, fabs(simulated_energy(r) - r->energy) - left);
    ric_replay_worsen(&r->check->energy_error, ric_replay_part(error, r->energy));
}

/* What the stored digits leave open of the gap of the face where flight k ends. */
static real gap_by_digits(const replay *r, int k)
{
    return r->digits && r->n_event ? r->digits->gap[k] : 0;
}

/* Energy that the chain may gain or lose at the end of flight k by the stored digits: a spring that
 * is met off its face by a gap has the energy of that gap at once. */
static real energy_by_digits(const replay *r, int k)
{
    const face_t *face = ric_replay_end_face(r, k);
    const real gap = gap_by_digits(r, k);
    return face ? face->spring * gap * gap / 2 : 0;
}

/* ------------------------------------------------------------------ flights */

static bool orthogonal(const replay *r, const face_t *f, const face_t *g)
{
    return fabs(ric_replay_dot(r->n, f->c, g->c)) <= RIC_VERIFY_ORTHOGONAL * sqrt(f->cc * g->cc);
}

/* Whether another face is met at state w together with `face` and the order matters: of two stops
 * whose impacts do not commute the simulator is right to refuse, and of a stop and a spring it may
 * meet either first. */
static bool at_corner(const replay *r, const face_t *face, const real *w)
{
    for (int f = 0; f < r->n_face; f++) {
        const face_t *other = &r->face[f];
        if (other->contact == face->contact ||
            fabs(ric_replay_gap(r, other, w)) > CLOSED * other->limit)
            continue;
        if (other->spring > 0 && face->spring > 0) continue;
        if (!orthogonal(r, face, other)) return true;
    }
    return false;
}

static bool meets_corner(const replay *r)
{
    for (int k = 0; k < r->n_flight; k++) {
        const face_t *face = ric_replay_end_face(r, k);
        if (face && at_corner(r, face, r->chain + (size_t)(k + 1) * 2 * (size_t)r->n)) return true;
    }
    return false;
}

/* At a corner that is passed two impacts with orthogonal normals fall on one instant and their
 * order says nothing. Where the simulator has struck the other face first, r->w becomes the state
 * behind the expected one. */
static void accept_order(const replay *r, int k, event *e)
{
    const face_t *expected = ric_replay_end_face(r, k), *struck = e->hit ? &r->face[e->face] : NULL;
    if (!struck || !expected || struck == expected) return;
    if (!(struck->spring > 0 && expected->spring > 0) && !orthogonal(r, struck, expected)) return;
    bool closing = (ric_replay_opens(r, k) ? -1 : 1) * expected->side *
                       ric_replay_dot(r->n, expected->c, r->w + r->n) >
                   0;
    const real open = CLOSED * expected->limit + gap_by_digits(r, k);
    if (!closing || fabs(ric_replay_gap(r, expected, r->w)) > open) return;
    ric_replay_reflect(r, struck, r->w);
    ric_replay_reflect(r, expected, r->w);
    e->opens = ric_replay_opens(r, k);
    e->face = (int)(expected - r->face);
}

/* The same where the word has a touch: an impact of another face, orthogonal to it, falls on the
 * instant of the touch and is undone. Whether it was. */
static bool accept_impact(const replay *r, int k, event *e)
{
    const face_t *touched = ric_replay_end_face(r, k), *struck = e->hit ? &r->face[e->face] : NULL;
    if (!struck || struck == touched || !orthogonal(r, struck, touched)) return false;
    if (fabs(ric_replay_gap(r, touched, r->w)) > CLOSED * touched->limit) return false;
    ric_replay_reflect(r, struck, r->w);
    return true;
}

/* How much later flight k may meet its face, at that speed or faster, by the stored digits alone:
 * as the gap is drawn back from the face, up to twice as much as its speed alone says. A spring
 * opens where the simulator saw it close, and closes where it saw it open if that is how the flight
 * began: which the chain may be off by as well. */
static real late_by_digits(const replay *r, int k, real speed)
{
    if (!r->digits || !r->n_event || !(speed > 0)) return 0;
    const bool level = k > 0 && (ric_replay_opens(r, k) ||
                                 ric_replay_end_face(r, k - 1) == ric_replay_end_face(r, k));
    const real gap = r->digits->gap[k] + (level ? r->digits->gap[k - 1] : 0),
               own = fabs(r->speed[k + 1]), *w = r->chain + (size_t)(k + 1) * 2 * (size_t)r->n,
               bent = 2 * gap * fabs(ric_replay_pull(r, k, ric_replay_end_face(r, k), w));
    return gap / speed * (own > 0 ? 2 * own / (own + sqrt(fmax(0, own * own - bent))) : 1);
}

/* What the state behind flight k changes by for every unit of time that its event comes later. */
static real change_rate(const replay *r, int k)
{
    real w[2 * r->n], column[2 * r->n];
    if (r->n_event == 0) return 0;
    memcpy(w, r->chain + (size_t)(k + 1) * 2 * (size_t)r->n, sizeof w);
    ric_replay_reflect(r, ric_replay_end_face(r, k), w);
    ric_replay_delay_column(r, k, w, column);
    return sqrt(ric_replay_dot(2 * r->n, column, column));
}

/* What the way by which the start of flight k was brought back to its stop changes at its end: the
 * state by as much as is returned, the time of its event by *late. */
static real change_by_start(const replay *r, int k, real speed, real *late)
{
    real column[2 * r->n];
    memcpy(column, r->moved, sizeof column);
    *late = 0;
    if (!r->n_event || !(ric_replay_dot(r->n, column, column) > 0)) return 0;
    const real gap = ric_replay_fly_column(r, k, true, column);
    if (speed > 0) *late = fabs(gap) / speed;
    return sqrt(ric_replay_dot(2 * r->n, column, column));
}

/* State and time at the end of flight k against the chain, states at the same time. What a slow
 * impact leaves uncertain is its time, and with it the pull that it turns round; a touch in the
 * word turns a speed round that is none. Struck at the speed v, it is early or late by the rounding
 * of the gap over v, like any slow impact: the stored doubles alone leave 1e-9 at 1e-7. */
static void compare_end(replay *r, int k, real time)
{
    const real *expected = r->chain + (size_t)(k + 1) * 2 * (size_t)r->n;
    const face_t *face = ric_replay_end_face(r, k);
    real late = fabs(time - r->tau[k]), error;
    real speed = fabs(r->speed[k + 1]), slow = face ? SLOW * ric_replay_fastest(r, face) : 0;
    real known = late_by_digits(r, k, fmax(speed, slow)), moved_late;
    const real moved = change_by_start(r, k, fmax(speed, slow), &moved_late);
    known += moved_late;
    ric_replay_fly(r, k + 1, r->tau[k] - time, r->w, r->w);
    error = ric_replay_distance(r, r->w, expected);
    if (face && !(face->spring > 0) && ric_replay_is_touch(r, k)) {
        error = fmax(0, error - 2 * speed / sqrt(face->cc));
        late *= speed / slow;
    } else if (speed < slow) {
        error = fmax(0, error - 3 * late * ric_replay_rate(r, k + 1, expected));
        late *= speed / slow;
    }
    late = fmax(0, late - known);
    error = fmax(0, error - known * change_rate(r, k) - moved);
    ric_replay_worsen(&r->check->flight_error,
                      fmax(ric_replay_part(late, fmax(r->tau[k], r->period / r->n_flight)),
                           ric_replay_part(error, r->norm)));
}

/* Whether r->w lies on a face, as far as the digits of its gap tell. While a spring is closed, and
 * where a loose mass rests on a stop, nothing is said of how near it came. */
static bool is_at(const replay *r, const face_t *face, real digits)
{
    return fabs(ric_replay_gap(r, face, r->w)) <= (REACH + digits) * face->limit;
}

/* Whether two gaps touch at the one instant at which flight k ends: there is nothing to compare.
 * The simulator refuses, or meets the spring of the corner, which opens or closes then, before the
 * stop. */
static bool touches_corner(const replay *r, int k, const event *e)
{
    const face_t *face = ric_replay_end_face(r, k);
    const real *w = r->chain + (size_t)(k + 1) * 2 * (size_t)r->n;
    if (!at_corner(r, face, w)) return false;
    if (e->refused || !e->hit) return e->refused;
    const face_t *struck = &r->face[e->face];
    return struck->contact != face->contact && struck->spring > 0 && !orthogonal(r, struck, face) &&
           fabs(ric_replay_gap(r, struck, w)) <= CLOSED * struck->limit &&
           fabs(e->time - r->tau[k]) <= CLOSED * r->period;
}

/* A flight that ends in a touch: the face is reached, as far as the stored digits tell, and not
 * passed, or struck as slowly as the chain does. A contact of a spring that is as shallow as that
 * may be met or not, and the state is continuous. */
static ric_status check_touch(replay *r, int k)
{
    event e;
    const face_t *face = ric_replay_end_face(r, k);
    ric_status status = run_to_impact(r, k, r->tau[k], r->tau[k], &e);
    if (status) return status;
    if (touches_corner(r, k, &e)) {
        r->corner = true;
        return RIC_OK;
    }
    const bool undone = accept_impact(r, k, &e);
    if (e.refused || (e.hit && !undone && &r->face[e.face] != face)) r->check->faces_agree = false;
    const real digits = gap_by_digits(r, k) / face->limit;
    const bool met = e.hit || e.touches || fabs(r->reach - 1) <= REACH + digits;
    if (!met && !is_at(r, face, digits)) r->check->faces_agree = false;
    compare_end(r, k, e.hit ? e.time : r->tau[k]);
    return RIC_OK;
}

static ric_status check_impact(replay *r, int k)
{
    event e;
    const face_t *face = ric_replay_end_face(r, k);
    ric_status status = run_to_impact(r, k, r->tau[k], r->tau[k] + LATE * r->period / r->n_flight,
                                      &e);
    if (status) return status;
    accept_order(r, k, &e);
    bool another = !e.hit || &r->face[e.face] != face || e.opens != ric_replay_opens(r, k),
         corner = another && at_corner(r, face, r->chain + (size_t)(k + 1) * 2 * (size_t)r->n);
    r->corner |= corner;
    if (corner && !e.refused) return RIC_OK; /* another order: there is nothing to compare */
    if (corner) ric_replay_reflect(r, face, r->w);
    else if (another) r->check->faces_agree = false;
    compare_end(r, k, e.time);
    return RIC_OK;
}

/* Linear motion for a period: nothing may be struck. */
static ric_status check_linear(replay *r)
{
    event e;
    ric_status status = run_to_impact(r, 0, r->period, r->period, &e);
    if (status) return status;
    if (e.hit || e.refused || r->reach > 1 + REACH) r->check->faces_agree = false;
    compare_end(r, 0, e.time);
    return RIC_OK;
}

/* Whether more than two switches of springs fall on one instant around flight k, as the end of a
 * branch may have it: their order says nothing, and a contact of no length among them may be met or
 * not. */
static bool gathered(const replay *r, int k)
{
    int N = r->n_flight, zeros = 0;
    if (!r->closed || N < 4) return false;
    for (int i = k + 1; zeros < N && r->tau[i % N] <= NO_LENGTH * r->period; i++) zeros++;
    for (int i = k + N; zeros < N && r->tau[i % N] <= NO_LENGTH * r->period; i--) zeros++;
    return zeros > 1;
}

/* The simulator at the beginning of flight k. Where the stored digits leave the state beyond the
 * stop that it has just struck, it is brought back to it: r->moved is that displacement as a
 * column. Returns the energy that this adds or takes, of the structure with the springs that are
 * closed: the work of the mean force. */
static real bring_back(replay *r, int k, real *w)
{
    const face_t *face = k > 0 ? ric_replay_end_face(r, k - 1) : NULL;
    real force[r->n], work = 0;
    memset(r->moved, 0, 2 * (size_t)r->n * sizeof *r->moved);
    if (!face || face->spring > 0 || !r->digits) return 0;
    const real gap = ric_replay_gap(r, face, w);
    if (!(gap > 0 && gap <= r->digits->gap[k - 1])) return 0;
    for (int i = 0; i < r->n; i++) {
        r->moved[i] = -face->side * gap / face->cc * face->c[i];
        w[i] += r->moved[i] / 2;
    }
    ric_replay_accelerations(r, k, w, force);
    for (int i = 0; i < r->n; i++) {
        w[i] += r->moved[i] / 2;
        work -= force[i] * r->moved[i];
        r->moved[i] *= r->kappa[i];
    }
    return work;
}

static ric_status start_flight(replay *r, int k, real *work)
{
    real w[2 * r->n];
    memcpy(w, r->chain + (size_t)k * 2 * (size_t)r->n, sizeof w);
    *work = bring_back(r, k, w);
    return start_at(r, k, w, 0);
}

static ric_status check_flights(replay *r)
{
    ric_status status = RIC_OK;
    real left = 0;
    for (int k = 0; k < r->n_flight && !status && r->check->faces_agree; k++) {
        real work = 0;
        left += energy_by_digits(r, k);
        if (ric_halt(RIC_VERIFY_WORK * r->n * r->n))
            return ric_fail(RIC_E_INTERRUPTED, "stopped on request");
        if (gathered(r, k) || (r->digits && ric_verify_digits_hide(r, r->digits, k))) {
            r->corner = true;
            continue;
        }
        r->reach = 0;
        status = start_flight(r, k, &work);
        if (status || !r->check->faces_agree) break;
        status = !ric_replay_end_face(r, k)  ? check_linear(r)
                 : ric_replay_is_touch(r, k) ? check_touch(r, k)
                                             : check_impact(r, k);
        r->grazes |= r->touched || r->reach > 1 - REACH;
        check_energy(r, left + fabs(work));
    }
    return status;
}

/* ------------------------------------------------------------------- return */

/* Whether an impact, or the contact of a spring, is so slow that an error of the state, relative to
 * its norm, decides if it takes place: at speed v the gap goes v^2 / 2 pull beyond its face. Then
 * the return is no linear function of the error. */
static bool may_miss(const replay *r, real error)
{
    int n = r->n;
    for (int k = 0; k < r->n_flight; k++) {
        const face_t *face = ric_replay_end_face(r, k);
        const real *w = r->chain + (size_t)(k + 1) * 2 * (size_t)n;
        real pull = 0, speed = r->speed[k + 1];
        /* a touch may be struck or not */
        if (!face || speed <= BLUNT * ric_replay_fastest(r, face)) continue;
        if (face->spring > 0) pull = ric_replay_pull(r, k, face, w);
        for (int i = 0; i < n && !(face->spring > 0); i++)
            pull += face->c[i] * r->omega[i] * r->omega[i] * w[i];
        if (speed * speed < MISS * 2 * fabs(pull) * error * r->norm) return true;
    }
    return false;
}

/* How far the orbit is open, relative, by the stored digits alone: at its end, and at the faces,
 * which are met that much earlier or later, by the gap over the speed: 1e-16 of it is 1e-10 of the
 * time at an impact of 1e-6. What is only touched turns nothing round. */
static real left_by_digits(const replay *r)
{
    const real *last = r->chain + (size_t)r->n_flight * 2 * (size_t)r->n;
    real open = ric_replay_distance(r, last, r->chain);
    if (open > ric_verify_digits_closing(r, r->digits)) open = 0; /* an error, and not excused */
    for (int k = 0; k < r->n_event; k++) {
        const face_t *face = ric_replay_end_face(r, k);
        const real gap = fabs(
            ric_replay_gap(r, face, r->chain + (size_t)(k + 1) * 2 * (size_t)r->n));
        if (gap <= r->digits->gap[k] && !ric_replay_is_touch(r, k))
            open += gap / fabs(r->speed[k + 1]) * change_rate(r, k);
    }
    return open / r->norm;
}

/* What the simulator's own rounding grows to over a period: the phase omega tau of a flight is
 * known to its last digit, which moves the state by that part of the way |dw/dt| tau; several slow
 * impacts in a row can amplify it far more than the multiplier says. What the stored digits leave
 * open grows likewise. */
static real rounding_returned(const replay *r)
{
    real way = 1;
    for (int k = 0; k < r->n_flight; k++)
        way = fmax(way, ric_replay_rate(r, k, r->chain + (size_t)k * 2 * (size_t)r->n) * r->tau[k] /
                            r->norm);
    const real error = 32 * LDBL_EPSILON * way + left_by_digits(r),
               grown = error * exp(fmin(700, r->amplification));
    /* what is only touched is struck with the root of that as speed, and then taken for an impact
     */
    bool may_strike = r->grazes && grown > GRAZED;
    return may_strike || may_miss(r, grown) ? HUGE_VAL : grown;
}

static double allowed(const ric_check *check)
{
    return RETURN * fmax(1, AMPLIFIED * check->condition);
}

/* Where the multiplier alone asks more than the simulator's rounding can give, that amplification
 * is what the return is divided by; where even this leaves nothing to compare, there is no return
 * error. */
static void allow_rounding(replay *r)
{
    ric_check *check = r->check;
    real rounding = rounding_returned(r);
    if (!(check->return_error > allowed(check))) return;
    if (isfinite(rounding))
        check->condition = fmax(check->condition, (double)(rounding / (RETURN * AMPLIFIED)));
    if (check->return_error > allowed(check) && rounding > LOST) check->return_error = NAN;
}

/* Whether the impact at the end of flight k, due at `due`, fell on the instant of the touch before
 * it and was met with that. */
static bool struck_with_touch(const replay *r, int k, const event *e, real due)
{
    return e->hit && &r->face[e->face] == ric_replay_end_face(r, k) &&
           ric_replay_is_touch(r, k - 1) && fabs(due - e->time) <= NO_LENGTH * r->period;
}

/* The whole period from one start. A touch of the word may be struck or not. */
static ric_status check_return(replay *r)
{
    event e = {0}, before = {0};
    for (int k = 0; k < r->n_flight; k++)
        if (gathered(r, k) || (r->digits && ric_verify_digits_hide(r, r->digits, k))) {
            r->check->return_error = NAN;
            return RIC_OK;
        }
    if (rounding_returned(r) >
        LOST) { /* nothing is left to compare, nor need the same faces be met */
        r->check->return_error = NAN;
        return RIC_OK;
    }
    real due = 0, mean = r->period / r->n_flight;
    ric_status status = start_at(r, 0, r->chain, 0);
    for (int k = 0; k < r->n_flight && !status && r->check->faces_agree; k++) {
        bool linear = r->n_event == 0, touch = linear || ric_replay_is_touch(r, k);
        real late = linear  ? 0
                    : touch ? fmin(LATE * mean, r->tau[(k + 1) % r->n_flight] / 2)
                            : LATE * mean;
        due += r->tau[k];
        if (k > 0 && !touch && struck_with_touch(r, k, &e, due)) continue;
        before = e;
        status = run_to_impact(r, k, due, due + late, &e);
        if (!e.hit && !touch) break;
    }
    if (status || !r->check->faces_agree) return status;
    const face_t *last = ric_replay_end_face(r, r->n_flight - 1);
    bool both = before.hit && last == &r->face[before.face] &&
                e.time - before.time <= NO_LENGTH * r->period;
    if (!both)
        accept_order(r, r->n_flight - 1, &e); /* else the last two were met, in the other order */
    /* a touch at the end: the state of that time */
    if (!e.hit) ric_replay_fly(r, r->n_flight - 1, r->period - e.time, r->w, r->w);
    /* so too at a spring, and where a loose mass comes to rest: met slowly, its time is uncertain
     */
    else if (last && (last->spring > 0 || ric_replay_is_touch(r, r->n_flight - 1)))
        ric_replay_fly(r, r->n_flight, due - e.time, r->w, r->w);
    r->check->return_error = e.refused && r->corner
                                 ? NAN
                                 : ric_replay_part(ric_replay_distance(r, r->w, r->chain), r->norm);
    if (r->check->return_error > allowed(r->check) && meets_corner(r)) r->check->return_error = NAN;
    allow_rounding(r);
    check_energy(r, 0);
    return RIC_OK;
}

static bool passes(const ric_check *check)
{
    return check->faces_agree && check->flight_error <= FLIGHT && check->energy_error <= FLIGHT &&
           (isnan(check->return_error) || check->return_error <= allowed(check));
}

ric_status ric_verify_replay_run(replay *r)
{
    ric_status status = RIC_OK;
    if (r->n_event && (status = ric_replay_condition(r))) return status;
    if ((status = start_at(r, 0, r->chain, 0))) return status;
    if (r->check->faces_agree) r->energy = simulated_energy(r);
    if ((status = check_flights(r)) || !r->check->faces_agree) return status;
    /* the chain closes: nothing is lost between the last flight and the first */
    const real open = ric_replay_distance(r, r->chain + (size_t)r->n_flight * 2 * (size_t)r->n,
                                          r->chain);
    ric_replay_worsen(&r->check->flight_error,
                      ric_replay_part(fmax(0, open - ric_verify_digits_closing(r, r->digits)),
                                      r->norm));
    if (r->touched) r->check->condition = fmax(r->check->condition, 1 / BLUNT);
    return check_return(r);
}

static ric_status replay_orbit(const ric_atlas *atlas, int branch, int i, ric_check *out)
{
    ric_digits digits = {0};
    replay r = {.check = out};
    *out = (ric_check){.branch = branch, .point = i, .condition = 1, .faces_agree = true};
    ric_status status = ric_verify_replay_open(&r, atlas, branch, i, false);
    if (status) goto out;
    out->energy_error = ric_replay_part(fabs(r.point.energy - r.energy), r.energy);
    if ((status = ric_verify_digits_open(&r, &digits))) goto out;
    r.digits = &digits;
    if ((status = ric_verify_replay_run(&r))) goto out;
    if (!out->faces_agree) ric_replay_worsen(&out->return_error, 1);
    out->passed = passes(out);
out:
    ric_verify_digits_close(&digits);
    ric_verify_replay_close(&r);
    return status;
}

ric_status ric_verify_point(const ric_atlas *atlas, int branch, int i, ric_check *out)
{
    if (ric_model_n_face(ric_atlas_model(atlas)) == 0)
        return ric_trust(ric_verify_smooth(atlas, branch, i, out, NULL));
    return ric_trust(replay_orbit(atlas, branch, i, out));
}
