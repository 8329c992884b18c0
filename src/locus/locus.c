/* Loci of junctions: what a caller holds. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "locus_parts.h"

#define MOST_POINTS 2000

struct ric_locus {
    int n_dof, letters;
    int n, capacity;
    ric_locus_point *points; /* what, state and flights owned */
};

void ric_locus_options_init(ric_locus_options *options)
{
    *options = (ric_locus_options){.max_points = MOST_POINTS};
}

bool ric_locus_stopped(const ric_locus_options *o, int points, double value)
{
    return ric_halted() || (o->progress && o->progress(points, value, o->user));
}

static void release(ric_locus_point *p)
{
    free(ric_own(p->what));
    free(ric_own(p->state));
    free(ric_own(p->flights));
}

void ric_locus_free(ric_locus *locus)
{
    if (!locus) return;
    for (int i = 0; i < locus->n; i++) release(&locus->points[i]);
    free(locus->points);
    free(locus);
}

static double *copy(size_t n, const double *from)
{
    double *out = ric_malloc(n * sizeof *out);
    if (out) memcpy(out, from, n * sizeof *out);
    return out;
}

ric_status ric_locus_append(ric_locus *locus, const ric_locus_point *point)
{
    if (locus->n == locus->capacity) {
        const int room = 2 * locus->capacity + 16;
        ric_locus_point *more = ric_realloc(locus->points, (size_t)room * sizeof *more);
        if (!more) return ric_no_memory("a locus");
        locus->points = more;
        locus->capacity = room;
    }
    ric_locus_point p = *point;
    p.what = ric_strdup(point->what);
    p.state = copy(2 * (size_t)locus->n_dof, point->state);
    p.flights = copy(locus->letters > 0 ? (size_t)locus->letters : 1, point->flights);
    if (!p.what || !p.state || !p.flights) {
        release(&p);
        return ric_no_memory("a locus");
    }
    locus->points[locus->n++] = p;
    return RIC_OK;
}

ric_status ric_locus_end(ric_locus *locus, const char *why)
{
    if (!locus->n) return RIC_OK;
    ric_locus_point *last = &locus->points[locus->n - 1];
    char *text = ric_strdup(why);
    if (!text) return ric_no_memory("a locus");
    free(ric_own(last->what));
    last->what = text;
    last->mark = RIC_LOCUS_END;
    return RIC_OK;
}

ric_status ric_locus_keep(ric_locus *locus, const ric_locus_orbit *o, ric_locus_mark mark,
                          const char *what)
{
    const ric_model *m = o->model;
    const int n = m->n_dof;
    double state[2 * n];
    ric_periodic *cycle = ric_periodic_from_chain(o->chain, o->u), *first = NULL;
    if (cycle) first = ric_periodic_canonical(m, cycle);
    double *flights = first ? ric_calloc((size_t)first->N + 1, sizeof *flights) : NULL;
    ric_status status = flights ? RIC_OK : ric_no_memory("a locus");
    if (!status) {
        ric_model_to_state(m, first->w, state, state + n);
        ric_periodic_flights(m, first, flights);
        const ric_locus_point point = {.value = o->p,
                                       .energy = o->energy,
                                       .frequency = o->frequency,
                                       .length = o->length,
                                       .residual = o->chain->residual,
                                       .mark = mark,
                                       .what = what,
                                       .state = state,
                                       .flights = flights};
        status = ric_locus_append(locus, &point);
    }
    free(flights);
    ric_periodic_free(cycle);
    ric_periodic_free(first);
    return status;
}

void ric_locus_turn(ric_locus *locus)
{
    for (int i = 0, j = locus->n - 1; i < j; i++, j--) {
        const ric_locus_point p = locus->points[i];
        locus->points[i] = locus->points[j];
        locus->points[j] = p;
    }
}

/* Values outside the range would never be met, and say that something else was meant. */
static ric_status check_values(const ric_vary *v, const ric_locus_options *o)
{
    for (int i = 0; i < o->n_value; i++)
        if (!(o->values[i] >= v->from && o->values[i] <= v->to))
            return ric_fail(RIC_E_INPUT, "%.10g is outside the range of %s, %.10g to %.10g",
                            o->values[i], v->name, v->from, v->to);
    return o->max_points > 0 && o->max_step >= 0
               ? RIC_OK
               : ric_fail(
                     RIC_E_INPUT,
                     "a locus needs a positive number of points and a step that is not negative");
}

ric_status ric_locus_follow(const ric_atlas *atlas, const ric_vary *vary, int junction,
                            const ric_locus_options *options, ric_locus **out)
{
    ric_locus_options plain;
    ric_junction j;
    ric_locus_problem q = {.vary = *vary};
    ric_periodic *cycle = NULL;
    ric_locus_options_init(&plain);
    if (!options) options = &plain;
    *out = NULL;
    ric_status status = ric_atlas_junction(atlas, junction, &j);
    if (!status) status = check_values(vary, options);
    if (status) return status;
    ric_locus *locus = ric_calloc(1, sizeof *locus);
    if (!locus) return ric_no_memory("a locus");
    locus->n_dof = ric_model_n_dof(ric_atlas_model(atlas));
    locus->letters = j.letters;
    const int mode = ric_locus_start_mode(atlas, &j);
    q.base = ric_atlas_model(atlas);
    if (mode >= 0) status = ric_locus_follow_mode(locus, &q, mode, options);
    else if (!(status = ric_locus_start(atlas, junction, &q, &cycle)))
        status = ric_locus_follow_curve(locus, &q, cycle, options);
    ric_periodic_free(cycle);
    if (status == RIC_OK || (status == RIC_E_INTERRUPTED && locus->n)) *out = locus;
    else ric_locus_free(locus);
    return status;
}

int ric_locus_n_point(const ric_locus *locus)
{
    return locus->n;
}

ric_status ric_locus_point_at(const ric_locus *locus, int i, ric_locus_point *out)
{
    if (i < 0 || i >= locus->n)
        return ric_fail(RIC_E_RANGE, "no point %d; there are %d, from 0", i, locus->n);
    *out = locus->points[i];
    return RIC_OK;
}

const char *ric_locus_mark_text(ric_locus_mark mark)
{
    static const char *const texts[] = {"", "start", "asked", "fold", "meets", "end"};
    return mark >= RIC_LOCUS_PLAIN && mark <= RIC_LOCUS_END ? texts[mark] : "";
}
