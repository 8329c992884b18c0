/* The locus of the first touch of a linear mode: E = omega^2 d^2 / (2 c^2) at every value of the
 * parameter, in closed form (docs/theory.md section 8). */
#include <math.h>
#include <stdlib.h>

#include "base/room.h"
#include "locus_parts.h"
#include "model/room.h"

enum { INTERVALS = 64 };

/* State of the mode at its largest displacement, where it touches `contact`. */
static ric_status touch_of(const ric_model *m, int mode, double energy, ric_locus_point *point,
                           double *state)
{
    const int n = m->n_dof;
    double shape[n * n], frequency[n];
    ric_status status = ric_model_modes(m, shape);
    if (!status) status = ric_model_frequencies(m, frequency);
    if (status) return status;
    const double amplitude = sqrt(2 * energy) / frequency[mode];
    for (int i = 0; i < n; i++) {
        state[i] = amplitude * shape[i * n + mode];
        state[n + i] = 0;
    }
    point->energy = energy;
    point->frequency = frequency[mode];
    return RIC_OK;
}

/* The way of a mode: its structure at the last value, whose modes those at the next one are like,
 * and what it touches. */
typedef struct {
    ric_locus *locus;
    const ric_locus_problem *q;
    int mode, contact; /* contact: -1 before the first value */
    ric_model *near;   /* owned */
} way;

static ric_status add_value(way *w, double p, ric_locus_mark mark, const char *what)
{
    ric_model *m = NULL;
    const ric_locus_problem *q = w->q;
    ric_status status = ric_locus_model(q->base, &q->vary, p, w->near ? w->near : q->base, &m);
    if (status) return status;
    const int n = m->n_dof, mode = w->mode;
    double energy[n], state[2 * n], period;
    int contacts[n];
    ric_locus_point point = {.value = p,
                             .length = ric_model_length(m),
                             .mark = mark,
                             .what = what,
                             .state = state};
    status = ric_model_grazing_energies(m, energy, contacts);
    if (!status && !isfinite(energy[mode]))
        status = ric_fail(RIC_E_NUMERIC, "the mode touches no contact");
    if (!status && w->contact >= 0 && contacts[mode] != w->contact && mark == RIC_LOCUS_PLAIN) {
        point.mark = RIC_LOCUS_MEETS;
        point.what = "another contact is touched first from here on";
    }
    if (!status) status = touch_of(m, mode, energy[mode], &point, state);
    period = RIC_TWO_PI / point.frequency;
    point.flights = &period;
    if (!status) status = ric_locus_append(w->locus, &point);
    if (!status) w->contact = contacts[mode];
    ric_model_free(w->near);
    w->near = m;
    return status;
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

/* One way from the structure of the atlas: at equal distances and at what is asked for. */
static ric_status go(ric_locus *locus, const ric_locus_problem *q, int mode, double end,
                     const ric_locus_options *options)
{
    const double at = q->vary.at;
    const int most = INTERVALS + options->n_value, sign = end < at ? -1 : 1;
    double *values = ric_malloc((size_t)most * sizeof *values);
    way w = {.locus = locus, .q = q, .mode = mode, .contact = -1};
    int n = 0;
    if (!values) return ric_no_memory("a locus");
    for (int i = 1; i <= INTERVALS; i++) values[n++] = sign * (at + (end - at) * i / INTERVALS);
    for (int i = 0; i < options->n_value; i++)
        if ((options->values[i] - at) * (end - options->values[i]) > 0)
            values[n++] = sign * options->values[i];
    qsort(values, (size_t)n, sizeof *values, ascending);
    ric_status status = RIC_OK;
    for (int i = 0; i < n && !status; i++) {
        const double p = sign * values[i];
        bool asked = false;
        for (int k = 0; k < options->n_value; k++) asked |= options->values[k] == p;
        const bool last = i + 1 == n;
        const ric_locus_mark mark = last    ? RIC_LOCUS_END
                                    : asked ? RIC_LOCUS_ASKED
                                            : RIC_LOCUS_PLAIN;
        status = add_value(&w, p, mark,
                           last    ? "border of the range of the parameter"
                           : asked ? "asked for"
                                   : "");
        if (status == RIC_E_NUMERIC) {
            char why[300];
            snprintf(why, sizeof why, "it is not followed further: %s", ric_detail());
            status = ric_locus_end(locus, why);
            break;
        }
    }
    ric_model_free(w.near);
    free(values);
    return status;
}

ric_status ric_locus_follow_mode(ric_locus *locus, const ric_locus_problem *q, int mode,
                                 const ric_locus_options *options)
{
    way w = {.locus = locus, .q = q, .mode = mode, .contact = -1};
    ric_status status = q->vary.from < q->vary.at ? go(locus, q, mode, q->vary.from, options)
                                                  : RIC_OK;
    if (status) return status;
    ric_locus_turn(locus);
    status = add_value(&w, q->vary.at, RIC_LOCUS_START, "the structure of the atlas");
    ric_model_free(w.near);
    return status || !(q->vary.at < q->vary.to) ? status : go(locus, q, mode, q->vary.to, options);
}
