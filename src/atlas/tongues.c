/* Internal resonances along a branch (docs/theory.md section 12): where its orbits follow a mode
 * that turns m times while the motion goes round n times, and where an exploration has stepped over
 * such a tongue. What is followed is read off the stored orbits: the share of the energy that a
 * mode has, and how near it is to whole turns in a period. */
#include "atlas.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "model/room.h"
#include "orbit/room.h"

/* Share of the energy from which on a mode counts as part of a motion, and that it comes to on a
 * tongue. */
#define TAKES_PART 0.1
#define RULES 0.5
/* How much of its largest share a mode has at the foot of a tongue, at most: a family of the mode
 * itself has no foot. */
#define FOOT 0.7
/* TURNS: distance from whole turns: springs that are closed for a while move a resonance by about
 * that, and a tongue keeps its distance to many more digits. */
#define TURNS 0.05
/* A tongue is steep: its frequency stays while its energy grows. Logarithms. */
#define GROWS 0.1
#define STAYS 0.02
enum {
    MOST_TURNS = 1000000000
}; /* of a file that may say any number: the phase is lost long before */
enum {
    PIECES = 16
}; /* of a flight that is no plain rotation, and for every turn of the mode as many again */

typedef struct {
    const ric_atlas *atlas;
    const ric_model *model;
    ric_branch branch;
    double *share; /* [n_point * n] of the energy in flight, of every mode */
    double *turns; /* [n_point] of a mode of frequency omega_ref in a period */
    double *energy, *frequency;
} survey;

static void survey_free(survey *s)
{
    free(s->share);
    free(s->turns);
    free(s->energy);
    free(s->frequency);
}

static ric_status survey_make(const ric_atlas *atlas, const ric_branch *b, survey *s)
{
    const ric_model *m = ric_atlas_model(atlas);
    const size_t n = (size_t)b->n_point + 1, n_mode = (size_t)m->n;
    *s = (survey){.atlas = atlas, .model = m, .branch = *b};
    s->share = ric_calloc(n * n_mode, sizeof *s->share);
    s->turns = ric_calloc(n, sizeof *s->turns);
    s->energy = ric_calloc(n, sizeof *s->energy);
    s->frequency = ric_calloc(n, sizeof *s->frequency);
    if (!s->share || !s->turns || !s->energy || !s->frequency)
        return ric_no_memory("resonances along a branch");
    for (int i = 0; i < b->n_point; i++) {
        const ric_point_row row = ric_atlas_point_row(atlas, b->id, i);
        double w[2 * m->n], sum = DBL_MIN, *share = s->share + (size_t)i * n_mode;
        ric_model_from_state(m, row.state, row.state + m->n_dof, w);
        for (int k = 0; k < m->n; k++) {
            share[k] = m->omega[k] > 0 ? w[k] * w[k] + w[m->n + k] * w[m->n + k]
                                       : w[m->n + k] * w[m->n + k];
            sum += share[k];
        }
        for (int k = 0; k < m->n; k++) share[k] /= sum;
        s->energy[i] = row.point.energy;
        s->frequency[i] = row.point.frequency;
        s->turns[i] = m->omega_ref / row.point.frequency;
    }
    return RIC_OK;
}

/* ------------------------------------------------------------------ winding */

/* The angle by which (a, p) of a mode turns from one state to another, the short way, in the
 * direction of flight. */
static double turned(const ric_model *m, int mode, const double *from, const double *to)
{
    const double a0 = from[mode], p0 = from[m->n + mode], a1 = to[mode], p1 = to[m->n + mode];
    return atan2(p0 * a1 - a0 * p1, a0 * a1 + p0 * p1);
}

/* The same over a flight; w [2n] becomes its end. */
static double turned_in_flight(const ric_model *m, uint64_t closed, int event, double tau, int mode,
                               double *w)
{
    const double turn = m->omega[mode] * tau;
    const int pieces = ric_flight_dense(m, closed)
                           ? PIECES * (1 + (int)fmin(turn / RIC_TWO_PI, 1000))
                           : 1;
    double from[2 * m->n], next[2 * m->n], sum = 0;
    memcpy(from, w, sizeof from);
    for (int i = 1; i <= pieces; i++) {
        ric_flight_go(m, closed, event, tau * i / pieces, from, next);
        sum += turned(m, mode, w, next);
        memcpy(w, next, sizeof next);
    }
    return ric_flight_dense(m, closed) ? sum : turn;
}

/* How often a mode goes round in a period, impacts taken the short way. */
static ric_status winding(const survey *s, int point, int mode, int *out)
{
    const ric_model *m = s->model;
    const ric_point_row row = ric_atlas_point_row(s->atlas, s->branch.id, point);
    const int letters = s->branch.letters, n = letters > 0 ? letters : 1;
    const size_t size = 2 * (size_t)m->n;
    double sum = 0, *tau = ric_calloc((size_t)n, sizeof *tau);
    for (int k = 0; tau && k < n; k++) tau[k] = row.flights[k] * m->omega_ref;
    ric_periodic *c = tau ? ric_periodic_spelled(m, letters, s->branch.word, tau) : NULL;
    double *W = c ? ric_calloc((size_t)c->N * size, sizeof *W) : NULL;
    if (W) {
        ric_model_from_state(m, row.state, row.state + m->n_dof, c->w);
        ric_periodic_states(m, c, W);
        for (int k = 0; k < c->N; k++) {
            double w[2 * m->n];
            memcpy(w, W + (size_t)k * size, sizeof w);
            sum += turned_in_flight(m, ric_periodic_closed(m, c, k), c->face[k], c->tau[k], mode,
                                    w);
            sum += turned(m, mode, w, W + (size_t)((k + 1) % c->N) * size);
        }
    }
    const ric_status status = W ? RIC_OK : ric_no_memory("resonances along a branch");
    *out = (int)fmax(1, round(fabs(sum) / RIC_TWO_PI));
    ric_periodic_free(c);
    free(tau);
    free(W);
    return status;
}

/* How often the motion goes round but for one mode: as the mode does that has most of the rest. */
static ric_status motion(const survey *s, int point, int but, int *out)
{
    const double *share = s->share + (size_t)point * (size_t)s->model->n;
    int main = -1;
    for (int k = 0; k < s->model->n; k++)
        if (k != but && s->model->omega[k] > 0 && (main < 0 || share[k] > share[main])) main = k;
    *out = 1;
    return main < 0 ? RIC_OK : winding(s, point, main, out);
}

/* ------------------------------------------------------------------- tongues */

static void set_place(const survey *s, int first, int last, ric_tongue *t)
{
    t->first = first;
    t->last = last;
    for (int i = 0; i < 2; i++) {
        t->energy[i] = s->energy[i ? last : first];
        t->frequency[i] = s->frequency[i ? last : first];
    }
}

/* Whether points first to last climb along mode k, which has more of the energy the more there is;
 * `low`: the point where it has least. The mode that rules at the foot loses as much, and is not
 * the one that is followed. */
static bool climbs(const survey *s, int k, int first, int last, int *low)
{
    const size_t n = (size_t)s->model->n;
    int high = first;
    double most = 0, least = 1, energy[2] = {HUGE_VAL, 0}, frequency[2] = {HUGE_VAL, 0};
    for (int i = first; i <= last; i++) {
        const double share = s->share[(size_t)i * n + (size_t)k];
        if (share < least) *low = i;
        if (share > most) high = i;
        least = fmin(least, share);
        most = fmax(most, share);
        energy[0] = fmin(energy[0], s->energy[i]);
        energy[1] = fmax(energy[1], s->energy[i]);
        frequency[0] = fmin(frequency[0], s->frequency[i]);
        frequency[1] = fmax(frequency[1], s->frequency[i]);
    }
    const double growth = log(energy[1] / energy[0]);
    return most >= RULES && least <= FOOT * most && growth >= GROWS &&
           s->energy[high] > s->energy[*low] && log(frequency[1] / frequency[0]) <= STAYS * growth;
}

/* Whether a mode takes part at a point, next to whole turns; how many. */
static bool resonates(const survey *s, int k, int i, double *turns)
{
    const double now = s->turns[i] * s->model->omega[k];
    *turns = round(now);
    return s->share[(size_t)i * (size_t)s->model->n + (size_t)k] >= TAKES_PART &&
           fabs(now - *turns) <= TURNS && *turns >= 1 && *turns < MOST_TURNS;
}

static ric_status follow(const survey *s, int k, int *n, ric_tongue *out)
{
    ric_status status = RIC_OK;
    for (int i = 0; i < s->branch.n_point && !status; i++) {
        double turns, next;
        int last = i, low = i, per;
        if (!resonates(s, k, i, &turns)) continue;
        while (last + 1 < s->branch.n_point && resonates(s, k, last + 1, &next) && next == turns)
            last++;
        if (climbs(s, k, i, last, &low) && !(status = motion(s, low, k, &per)) &&
            per != (int)turns) {
            ric_tongue *t = &out[(*n)++];
            *t = (ric_tongue){.mode = s->model->mode[k] + 1, .turns = (int)turns, .per = per};
            set_place(s, i, last, t);
        }
        i = last;
    }
    return status;
}

static ric_status crossed(const survey *s, int *n, ric_tongue *out)
{
    const ric_branch_record *r = &s->atlas->branches[s->branch.id - 1];
    ric_status status = RIC_OK;
    for (int i = 0; i < r->n_gap && !status; i++) {
        const ric_atlas_gap *gap = &r->gaps[i];
        int mode = 0, per = 1;
        while (mode + 1 < s->model->n && s->model->mode[mode] != gap->mode - 1) mode++;
        status = motion(s, gap->point, mode, &per);
        out[*n] = (ric_tongue){.mode = gap->mode,
                               .turns = gap->turns,
                               .per = per,
                               .crossed = true,
                               .others = gap->others};
        set_place(s, gap->point, gap->point + 1, &out[(*n)++]);
    }
    return status;
}

static int by_place(const void *a, const void *b)
{
    const ric_tongue *s = a, *t = b;
    return s->first != t->first ? s->first - t->first : s->mode - t->mode;
}

ric_status ric_branch_tongues(const ric_atlas *atlas, int id, int *n, ric_tongue **out)
{
    ric_branch b;
    survey s = {0};
    *n = 0;
    *out = NULL;
    ric_status status = ric_atlas_branch(atlas, id, &b);
    if (status || ric_branch_linear(ric_atlas_model(atlas), &b) || b.n_point == 0) return status;
    status = survey_make(atlas, &b, &s);
    /* where a mode rules it has half of the energy, which two modes can, and a gap lies behind a
     * point */
    *out = status ? NULL : ric_calloc(3 * (size_t)b.n_point + 1, sizeof **out);
    if (!status && !*out) status = ric_no_memory("resonances along a branch");
    for (int k = 0; k < ric_model_n_mode(ric_atlas_model(atlas)) && !status; k++)
        if (s.model->omega[k] > 0) status = follow(&s, k, n, *out);
    if (!status) status = crossed(&s, n, *out);
    if (!status) qsort(*out, (size_t)*n, sizeof **out, by_place);
    survey_free(&s);
    if (status) {
        free(*out);
        *out = NULL;
        *n = 0;
    }
    return status;
}

bool ric_branch_steps_over(const ric_atlas *atlas, int branch, int point)
{
    if (branch < 1 || branch > atlas->n_branch) return false;
    const ric_branch_record *r = &atlas->branches[branch - 1];
    int low = 0, high = r->n_gap; /* in order */
    while (low < high) {
        const int middle = low + (high - low) / 2;
        if (r->gaps[middle].point < point) low = middle + 1;
        else high = middle;
    }
    return low < r->n_gap && r->gaps[low].point == point;
}

void ric_tongues_free(ric_tongue *tongues)
{
    free(tongues);
}

ric_status ric_tongue_text(const ric_tongue *t, double unit, size_t size, char *out)
{
    const double from = unit * t->energy[0], to = unit * t->energy[1];
    int used = snprintf(out, size, "%s %d : %d with mode %d", t->crossed ? "steps over" : "follows",
                        t->turns, t->per, t->mode);
    if (used >= 0 && (size_t)used < size && t->others)
        used += snprintf(out + used, size - (size_t)used, " and %d more", t->others);
    if (used >= 0 && (size_t)used < size)
        used += snprintf(out + used, size - (size_t)used, " from E %.6g to E %.6g", from, to);
    if (used >= 0 && (size_t)used < size && t->crossed)
        used += snprintf(out + used, size - (size_t)used, ", omega %.8g to %.8g", t->frequency[0],
                         t->frequency[1]);
    if (used < 0 || (size_t)used >= size)
        return ric_fail(RIC_E_RANGE, "a text of %d characters does not fit in %zu", used, size);
    return RIC_OK;
}
