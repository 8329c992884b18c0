/* Rows of branches and junctions: what they say of their points and orbits, computed anew from
 * these. */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>

#include "simulator_power.h"
#include "base/room.h"
#include "verify_parts.h"
#include "verify_reach.h"
#include "verify_smooth.h"

#define SAME 1e-12 /* relative: numbers that are stored twice */
/* STILL: of the clearance: a gap goes with the square of its speed, and where that vanishes is
 * known to the root of rounding */
#define STILL 1e-7
/* SOLVED: of clearance and norm: what a located orbit may leave open, and an image may be off */
#define SOLVED 1e-9
/* BETWEEN: relative: how far a junction between points may extend the frequencies of a branch */
#define BETWEEN 1e-2
#define SHARE 1e-11  /* of a branch: rounding of a sum of lengths over its points */
#define ENERGY 1e-10 /* relative, of a located orbit whose numbers are stored together */
/* TOLD: of a clearance: a touch is told from none to this, or it is said that it is not */
#define TOLD 1e-6
#define IMAGE 1e-6 /* an orbit that is farther from its image than this is not symmetric */

/* EXACT: an orbit that is nearer to its image than this, solved to the last digit, is symmetric */
#define EXACT 1e-10
/* LONG: of the state: a branch whose orbits differ by less may be beside a symmetric one as a whole
 */
#define LONG 1e-4

enum {
    FEW = 4,
    SAMPLE = 8
}; /* orbits between the ends of a branch that tell its symmetry, at least and at most */

static void compare(ric_claims *out, const char *name, double stored, double found, double limit)
{
    if (!(fabs(stored - found) <= limit * fmax(fabs(found), DBL_MIN)))
        ric_verify_disagree(out, name, stored, found);
}

/* ---------------------------------------------------------------- branches */

/* With the junctions that the branch passes: of frequency, whose multiple is not said, only that it
 * is about so. */
static ric_status check_ranges(const ric_atlas *atlas, const ric_branch *b, ric_claims *out)
{
    double energy[2] = {HUGE_VAL, -HUGE_VAL}, frequency[2] = {HUGE_VAL, -HUGE_VAL};
    ric_status status = RIC_OK;
    for (int i = 0; i < b->n_point + b->n_junction && !status; i++) {
        ric_point p = {0};
        ric_junction j;
        bool point = i < b->n_point;
        status = point ? ric_atlas_point(atlas, b->id, i, &p, NULL, NULL)
                       : ric_atlas_junction(atlas, b->junctions[i - b->n_point], &j);
        if (status) break;
        energy[0] = fmin(energy[0], point ? p.energy : j.energy);
        energy[1] = fmax(energy[1], point ? p.energy : j.energy);
        if (!point) continue;
        frequency[0] = fmin(frequency[0], p.frequency);
        frequency[1] = fmax(frequency[1], p.frequency);
    }
    double between = b->n_junction ? BETWEEN : SAME;
    compare(out, "energy_min", b->energy_min, energy[0], SAME);
    compare(out, "energy_max", b->energy_max, energy[1], SAME);
    compare(out, "frequency_min", b->frequency_min, frequency[0],
            b->frequency_min < frequency[0] ? between : SAME);
    compare(out, "frequency_max", b->frequency_max, frequency[1],
            b->frequency_max > frequency[1] ? between : SAME);
    return status;
}

/* Of the arclength between two orbits one of which is decided all is stable where both are, none
 * where both are unstable on one side, and elsewhere what the border says. */
static ric_status check_share(const ric_atlas *atlas, const ric_branch *b, ric_claims *out)
{
    double all = 0, least = 0, open = 0;
    ric_point p, q = {0};
    for (int i = 0; i < b->n_point; i++, q = p) {
        const ric_status status = ric_atlas_point(atlas, b->id, i, &p, NULL, NULL);
        if (status) return status;
        if (!i || (p.stable == RIC_STABLE_UNDECIDED && q.stable == RIC_STABLE_UNDECIDED)) continue;
        const double piece = p.arclength - q.arclength;
        const bool alike = p.stable == q.stable && !(p.trace * q.trace < 0);
        all += piece;
        if (p.stable == RIC_STABLE_YES && q.stable == RIC_STABLE_YES) least += piece;
        else if (!alike) open += piece;
    }
    const double share = b->stable_fraction;
    if (all > 0 ? !(share * all >= least - SHARE * all && share * all <= least + open + SHARE * all)
                : !isnan(share))
        ric_verify_disagree(out, "stable_fraction", share, least / all);
    return RIC_OK;
}

/* A contact of a spring closes and opens, and counts once. */
static void check_impacts(const ric_branch *b, int n_face, ric_claims *out)
{
    int impacts = 0;
    for (int k = 0; k < b->letters; k++) impacts += b->word[k] < n_face;
    if (impacts != b->impacts) ric_verify_disagree(out, "impacts", b->impacts, impacts);
}

/* States behind all events against those of the motion with x -> -x (sign -1), or backwards
 * (reverse): what is left between the two where they fit best. */
static real best_fit(const replay *r, bool reverse, real sign)
{
    int N = r->n_event, n = r->n;
    size_t step = 2 * (size_t)n;
    real best = INFINITY, image[2 * n];
    for (int shift = 0; shift < N; shift++) {
        real worst = 0;
        for (int k = 0; k < N && worst < best; k++) {
            int at = ((reverse ? shift - k : shift + k) % N + N) % N;
            const face_t *face = &r->face[r->event[at]];
            memcpy(image, r->chain + (size_t)at * step, sizeof image);
            if (reverse) ric_replay_reflect(r, face, image); /* before the impact, then backwards */
            for (int i = 0; i < 2 * n; i++) image[i] *= sign * (reverse && i >= n ? -1 : 1);
            worst = fmax(worst, ric_replay_distance(r, image, r->chain + (size_t)k * step));
        }
        best = fmin(best, worst);
    }
    return best / r->norm;
}

/* How far the orbit of point i is off its image: in x -> -x half a period on, and backwards.
 * `known`: what its stored digits make of any two of its states, over its size, as is `w` [2
 * n_dof], its state. */
static ric_status fit_images(const ric_atlas *atlas, int branch, int i, real fit[2], real *known,
                             real *w)
{
    replay r = {0};
    ric_check check = {.branch = branch, .point = i};
    ric_digits digits = {0};
    *known = 0;
    if (ric_model_n_face(ric_atlas_model(atlas)) == 0)
        return ric_verify_smooth_images(atlas, branch, i, fit, w);
    ric_status status = ric_verify_replay_open(&r, atlas, branch, i, true);
    r.check = &check;
    if (!status) status = ric_verify_digits_open(&r, &digits);
    if (!status) {
        fit[0] = r.n_event % 2 ? INFINITY : best_fit(&r, false, -1);
        fit[1] = fmin(best_fit(&r, true, 1), best_fit(&r, true, -1));
        for (int k = 0; k < 2 * r.n; k++) w[k] = r.chain[k] / r.norm;
        *known = 2 * digits.state / r.norm;
    }
    ric_verify_digits_close(&digits);
    ric_verify_replay_close(&r);
    return status;
}

/* Whether it is right that a branch, some orbit of which is its own image, is not said to have that
 * symmetry. One orbit does not give it to its branch, which may pass it; nor do the orbits of a
 * branch that is so short that all are beside one. Several between the ends of a longer branch do.
 */
static ric_status ask_others(const ric_atlas *atlas, const ric_branch *b, ric_agreement said[2])
{
    int n = ric_model_n_dof(ric_atlas_model(atlas)), inner = b->n_point - 2,
        count = inner < SAMPLE ? inner : SAMPLE;
    bool all[2] = {count >= FEW, count >= FEW};
    ric_status status = RIC_OK;
    real w[2][2 * n], apart = 0, known, fit[2];
    for (int k = 0; k < count && !status; k++) {
        if ((status = fit_images(atlas, b->id, 1 + (int)((long)k * inner / count), fit, &known,
                                 w[k > 0])))
            break;
        for (int i = 0; i < 2; i++) {
            all[i] &= fit[i] < EXACT + known && known < IMAGE;
            if (fit[i] > IMAGE + known) said[i] = RIC_AGREES_YES;
        }
        for (int j = 0; j < 2 * n && k > 0; j++) apart = fmax(apart, fabs(w[1][j] - w[0][j]));
    }
    for (int i = 0; i < 2; i++)
        if (all[i] && apart > LONG) said[i] = RIC_AGREES_NO;
    return status;
}

static ric_status check_symmetries(const ric_atlas *atlas, const ric_branch *b, ric_claims *out)
{
    static const char *const names[2] = {"symmetric", "reversible"};
    bool stored[2] = {b->symmetric, b->reversible}, open[2];
    ric_agreement said[2] = {RIC_AGREES_UNCHECKED, RIC_AGREES_UNCHECKED};
    real fit[2], known, w[2 * ric_model_n_dof(ric_atlas_model(atlas))];
    ric_status status = fit_images(atlas, b->id, b->n_point / 2, fit, &known, w);
    for (int i = 0; i < 2 && !status; i++) {
        open[i] = !stored[i] && fit[i] < IMAGE;
        if (stored[i] && fit[i] > IMAGE + known) ric_verify_disagree(out, names[i], 1, 0);
    }
    if (!status && (open[0] || open[1])) status = ask_others(atlas, b, said);
    for (int i = 0; i < 2 && !status; i++)
        if (open[i] && said[i] == RIC_AGREES_NO) ric_verify_disagree(out, names[i], 0, 1);
        else if (open[i] && said[i] == RIC_AGREES_UNCHECKED && out->numbers == RIC_AGREES_YES)
            out->numbers = RIC_AGREES_UNCHECKED;
    return status;
}

ric_status ric_verify_branch(const ric_atlas *atlas, int branch, ric_claims *out)
{
    ric_branch b;
    *out = (ric_claims){.branch = branch,
                        .point = -1,
                        .multiplier_error = NAN,
                        .multiplier_bound = NAN,
                        .multipliers = RIC_AGREES_UNCHECKED,
                        .stable = RIC_AGREES_UNCHECKED,
                        .numbers = RIC_AGREES_YES};
    ric_status status = ric_atlas_branch(atlas, branch, &b);
    if (status || b.n_point == 0 || (status = check_ranges(atlas, &b, out)) ||
        (status = check_share(atlas, &b, out)))
        return status;
    check_impacts(&b, ric_model_n_face(ric_atlas_model(atlas)), out);
    return ric_branch_linear(ric_atlas_model(atlas), &b)
               ? RIC_OK
               : ric_trust(check_symmetries(atlas, &b, out));
}

/* --------------------------------------------------------------- junctions */

static real period_of(const ric_junction *j)
{
    real sum = 0;
    for (int k = 0; k < (j->letters ? j->letters : 1); k++) sum += j->flights[k];
    return sum;
}

/* What an error of the size of the orbit makes of the gap of a face, of its clearance. */
static real lever(const replay *r, const face_t *face)
{
    return ric_replay_lever(r, face) * r->norm / face->limit;
}

/* What the flights of the word leave open at its faces and at the end, relative, beyond what
 * rounding grows to: RIC_VERIFY_DIGIT for each flight, as of a stored point. */
static real left_open(const replay *r)
{
    const size_t step = 2 * (size_t)r->n;
    const real end = ric_replay_distance(r, r->chain + (size_t)r->n_flight * step, r->chain) /
                     r->norm;
    real open = 0;
    for (int pass = 0; pass < 2; pass++) {
        const real digits = pass ? RIC_VERIFY_DIGIT * r->n_flight *
                                       ric_replay_growth(r, 0, r->n_event)
                                 : 0;
        open = end - digits;
        for (int k = 0; k < r->n_event; k++) {
            const face_t *face = ric_replay_end_face(r, k);
            const real gap = fabs(ric_replay_gap(r, face, r->chain + (size_t)(k + 1) * step)) /
                             face->limit;
            open = fmax(open, gap - digits * fmax(1, lever(r, face)));
        }
        if (open <= SOLVED) break; /* the growth is asked for only where something is open */
    }
    return open;
}

/* Whether another face than that of event k is met there without speed. */
static bool meets_another(const replay *r, int k)
{
    const real *w = r->chain + (size_t)(k + 1) * 2 * (size_t)r->n;
    for (int f = 0; f < r->n_face; f++) {
        const face_t *face = &r->face[f];
        if (face == ric_replay_end_face(r, k) || ric_replay_closed(r, k, f)) continue;
        if (fabs(ric_replay_gap(r, face, w)) <= STILL * face->limit &&
            fabs(ric_replay_dot(r->n, face->c, w + r->n)) <= BLUNT * ric_replay_fastest(r, face))
            return true;
    }
    return false;
}

/* Whether two contacts are met at one instant, both without speed, or one of them without: to its
 * digits a motion meets them in any order, or passes them by. */
static bool has_still_corner(const replay *r)
{
    for (int k = 0; k < r->n_event; k++)
        if (meets_another(r, k)) return true;
    for (int k = 0; k < r->n_flight; k++)
        if (fabs(r->tau[k]) <= NO_LENGTH * r->period && ric_replay_is_touch(r, k) &&
            ric_replay_is_touch(r, (k > 0 ? k : r->n_flight) - 1))
            return true;
    return false;
}

/* Whether the motion meets the faces of its word when it is said to, and no other, as the simulator
 * flies it. */
static ric_status check_faces(replay *r, ric_claims *out)
{
    ric_check check = {.condition = 1, .faces_agree = true};
    r->check = &check;
    ric_status status = ric_verify_replay_run(r);
    if (status || *out->finding) return status;
    if (!check.faces_agree && has_still_corner(r)) {
        ric_verify_digits_doubt(out, "word");
        return RIC_OK;
    }
    if (!check.faces_agree || !(check.flight_error <= SOLVED)) out->numbers = RIC_AGREES_NO;
    if (!check.faces_agree)
        snprintf(out->finding, sizeof out->finding,
                 "the stored motion meets other faces than those of its word");
    else if (!(check.flight_error <= SOLVED))
        snprintf(out->finding, sizeof out->finding,
                 "the stored motion is another one: off by %.3g at the end of a flight",
                 check.flight_error);
    return RIC_OK;
}

/* A grazing touches: a gap is largest at its face, or is met there without speed. What a located
 * orbit leaves open, and its digits make of a gap, may be missing. */
static ric_status check_touch(replay *r, ric_claims *out)
{
    const double near = SOLVED + ric_verify_reach_slack(r, r->digits->state / r->norm);
    ric_reached reach = {.stored = 1, .near = near};
    for (int k = 0; k < r->n_event; k++)
        if (ric_replay_is_touch(r, k)) return RIC_OK;
    ric_status status = ric_verify_reach_find(r, &reach);
    if (status) return status;
    const bool touches = fabs(reach.nearest - 1) <= near;
    if (touches ? near > TOLD : reach.skipped) ric_verify_digits_doubt(out, "touch");
    else if (!touches && !*out->finding) {
        out->numbers = RIC_AGREES_NO;
        snprintf(out->finding, sizeof out->finding,
                 "a grazing that touches nothing: the gap that is nearest to its face reaches "
                 "%.17g of the clearance",
                 reach.nearest);
    }
    return RIC_OK;
}

/* The orbit, which closes, as a motion. */
static ric_status check_motion(replay *r, bool grazes, ric_claims *out)
{
    ric_digits digits = {0};
    /* of a junction it is not stored: the digits allow for the most that any orbit has */
    r->point.residual = (float)SOLVED;
    r->depth = SOLVED;
    ric_status status = ric_verify_digits_open(r, &digits);
    r->digits = &digits;
    if (!status) status = check_faces(r, out);
    if (!status && grazes) status = check_touch(r, out);
    ric_verify_digits_close(&digits);
    r->digits = NULL;
    return status;
}

static ric_status check_replayed(const ric_model *m, const ric_junction *j, ric_claims *out)
{
    replay r = {0};
    ric_branch like = {.letters = j->letters, .word = j->word, .impacts = j->impacts};
    ric_status status = ric_verify_replay_open_orbit(&r, m, &like, j->state, j->flights);
    if (!status) {
        const real open = left_open(&r);
        if (!(open <= SOLVED)) ric_verify_disagree(out, "orbit is left open by 0", 0, (double)open);
        else status = check_motion(&r, j->kind == RIC_KIND_GRAZING, out);
        if (!status) status = ric_verify_kind(&r, j, out);
    }
    ric_verify_replay_close(&r);
    return status;
}

/* Integrated over its period. */
static ric_status check_smooth(const ric_model *m, const ric_junction *j, ric_claims *out)
{
    int d = ric_model_n_dof(m), n = 2 * d;
    real y[n], size[2] = {0, 0}, period = period_of(j), turn = period / RIC_TWO_PI_LONG, open = 0,
               growth = 1;
    double *Y = ric_calloc((size_t)(n * n), sizeof *Y);
    ric_simulator_power *springs = NULL;
    if (!Y) return ric_fail(RIC_E_NOMEM, "no memory to replay an orbit");
    for (int i = 0; i < n; i++) {
        y[i] = j->state[i];
        size[i >= d] = fmax(size[i >= d], fabs(y[i]));
    }
    size[0] = fmax(size[0], size[1] * turn);
    size[1] = fmax(size[1], size[0] / turn);
    for (int i = 0; i < n; i++) Y[i * n + i] = (double)size[i >= d];
    ric_status status = ric_simulator_power_create(m, &springs);
    if (!status) status = ric_simulator_power_go(springs, period, y, Y);
    for (int i = 0; i < n && !status; i++) {
        open = fmax(open, fabs(y[i] - j->state[i]) / size[i >= d]);
        for (int k = 0; k < n; k++) growth = fmax(growth, fabs(Y[i * n + k]) / size[i >= d]);
    }
    if (!status && !(open <= SOLVED + RIC_VERIFY_DIGIT * growth))
        ric_verify_disagree(out, "orbit is left open by 0", 0, (double)open);
    else if (!status) status = ric_verify_kind_smooth(m, springs, j, period, out);
    ric_simulator_power_free(springs);
    free(Y);
    return status;
}

ric_status ric_verify_junction(const ric_atlas *atlas, int id, ric_claims *out)
{
    ric_junction j;
    const ric_model *m = ric_atlas_model(atlas);
    *out = (ric_claims){.branch = -1,
                        .point = id,
                        .multiplier_error = NAN,
                        .multiplier_bound = NAN,
                        .multipliers = RIC_AGREES_UNCHECKED,
                        .stable = RIC_AGREES_UNCHECKED,
                        .numbers = RIC_AGREES_YES};
    ric_status status = ric_atlas_junction(atlas, id, &j);
    if (status) return status;
    double period = (double)period_of(&j),
           energy = ric_model_energy(m, j.state, j.state + ric_model_n_dof(m));
    compare(out, "energy", j.energy, energy, ENERGY);
    compare(out, "frequency", j.frequency, RIC_TWO_PI / period / j.multiple, ENERGY);
    if (!(energy > 0)) return RIC_OK;
    return ric_trust(ric_model_n_face(m) ? check_replayed(m, &j, out) : check_smooth(m, &j, out));
}
