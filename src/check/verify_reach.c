/* How far the gaps open in the flights of a replayed orbit (docs/theory.md section 11). */
#include <math.h>
#include <string.h>
#include <tgmath.h>

#include "verify_reach.h"

/* FLAT: part of the largest speed: a gap that changes no faster may be at a maximum */
#define FLAT 1e-7
#define BRIEF 1e-7 /* of the period: a flight of that length begins and ends at once */
/* SHORT: of the period: within a flight of that length a gap is its largest to (2 pi SHORT)^2 / 8
 */
#define SHORT 3e-6
/* AT_FACE: of a flight: a largest gap that near to an impact on the same contact is that impact */
#define AT_FACE 1e-7

/* Gap over clearance of the face at w, on the scale on which 1 is a touch: of a closed spring what
 * is left until it opens, from the other side. */
static real gap_over(const replay *r, const face_t *face, bool image, bool closed, const real *w)
{
    real s = (image ? -1 : 1) * face->side * ric_replay_dot(r->n, face->c, w) / face->limit;
    return closed ? 2 - s : s;
}

/* The face's contact has a spring that is closed in flight k; *this: its own. */
static bool is_closed(const replay *r, int k, const face_t *face, bool *this)
{
    bool any = *this = false;
    for (int f = 0; f < r->n_face; f++)
        if (r->face[f].contact == face->contact && ric_replay_closed(r, k, f)) {
            any = true;
            *this |= &r->face[f] == face;
        }
    return any;
}

static void count(ric_reached *r, bool sure, double value)
{
    if (fabs(value - r->stored) < fabs(r->nearest - r->stored)) r->nearest = value;
    if (fabs(value - 1) <= RIC_REACHED) return;
    r->also = fmax(r->also, value);
    if (sure) r->sure = fmax(r->sure, value);
}

/* Whether a gap at w, where it does not change, has a minimum: it is pushed towards the face, by
 * more than rounding leaves of the largest push that the modes can give. `turned`: what counts is
 * the gap from the other side. */
static bool is_lowest(const replay *r, int k, const face_t *face, bool turned, const real *w)
{
    real size = 0, pull = (turned ? -1 : 1) * ric_replay_pull(r, k, face, w);
    for (int i = 0; i < r->n; i++) size += fabs(face->c[i]) * r->omega[i] * r->norm;
    return pull < -FLAT * size;
}

/* Of one face, or of its image, in flight k. */
static ric_status reach_in_flight(replay *r, int k, int f, bool image, ric_reached *reach)
{
    const face_t *face = &r->face[f], *end = ric_replay_end_face(r, k),
                 *start = ric_replay_end_face(r, (k + r->n_flight - 1) % r->n_flight);
    bool own, closed = is_closed(r, k, face, &own);
    if (closed && (!own || image)) return RIC_OK;
    real t = r->tau[k], edge = AT_FACE * t;
    bool leaves = start && start->contact == face->contact,
         meets = end && end->contact == face->contact;
    double top = ric_simulator_highest(r->sim, f, image, (double)edge, (double)(t - edge), 0),
           whole = ric_simulator_highest(r->sim, f, image, (double)(leaves ? edge : 0),
                                         (double)(meets ? t - edge : t), top);
    bool brief = r->n_event && t <= BRIEF * r->period;
    count(reach, !brief, top);
    count(reach, false, whole);
    if (reach->levels) {
        const double part[2] = {(double)edge, (double)(t - edge)},
                     slow = reach->near * (double)ric_replay_fastest(r, face),
                     value = ric_simulator_level(r->sim, f, image, part, slow, reach->stored);
        if (isfinite(value)) count(reach, false, value);
    }
    const real *w = r->chain + (size_t)(k + 1) * 2 * (size_t)r->n;
    bool smooth = !end || end->spring > 0 ||
                  fabs(ric_replay_dot(r->n, end->c, face->c)) <=
                      RIC_VERIFY_ORTHOGONAL * sqrt(end->cc * face->cc),
         flat = fabs(ric_replay_dot(r->n, face->c, w + r->n)) <=
                    FLAT * ric_replay_fastest(r, face) ||
                (r->n_event && t <= SHORT * r->period);
    double value = (double)gap_over(r, face, image, closed, w);
    bool turns = t <= SHORT * r->period || !is_lowest(r, k, face, image != closed, w);
    if (!meets && (!smooth || (flat && turns))) count(reach, !smooth && !brief, value);
    return RIC_OK;
}

ric_status ric_verify_reach_find(replay *r, ric_reached *reach)
{
    real w[2 * r->n];
    reach->sure = reach->also = reach->nearest = 0;
    reach->skipped = false;
    for (int k = 0; k < r->n_flight; k++) {
        const bool *closed = r->closed ? r->closed + (size_t)k * (size_t)r->n_face : NULL;
        memcpy(w, r->chain + (size_t)k * 2 * (size_t)r->n, sizeof w);
        if (r->n_event == 0)
            ric_replay_fly(r, 0, r->period / 8, w, w); /* no largest gap at the very start */
        ric_status status = ric_simulator_start_modal(r->sim, closed, w);
        if (status == RIC_E_INPUT) { /* beyond a stop: the replay says so */
            reach->skipped = true;
            continue;
        }
        for (int f = 0; f < r->n_face && !status; f++)
            for (int image = 0; image <= (r->branch.symmetric ? 1 : 0) && !status; image++)
                status = reach_in_flight(r, k, f, image, reach);
        if (status) return status;
    }
    return RIC_OK;
}

double ric_verify_reach_slack(const replay *r, real slack)
{
    real most = 0, slowest = INFINITY;
    for (int i = 0; i < r->n; i++) slowest = fmin(slowest, r->kappa[i]);
    for (int f = 0; f < r->n_face; f++)
        most = fmax(most, sqrt(r->face[f].cc) * r->norm / (slowest * r->face[f].limit));
    return (double)(most * slack);
}
