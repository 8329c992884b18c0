/* Curves that begin at an event of another one: of other words at a grazing, of twice the period at
 * a doubling, beside the curve at a branch point. */
#include <math.h>
#include <stdlib.h>

#include "base/room.h"
#include "response_keep.h"

enum {
    SETS_MOST = 4 /* touches of a grazing of which all sets are tried */
};

static bool mute(const ric_response_driver *d, int curve, int event)
{
    const ric_response_curve *c = &d->r->curves[curve].data;
    return c->from == event || c->to == event;
}

/* Whether a is b from letter `turn` on, or, mirrored, with all faces exchanged for those on the
 * other side. */
static bool same_word(const ric_model *m, int letters, const int *a, const int *b, int turn,
                      bool mirrored)
{
    for (int i = 0; i < letters; i++) {
        const int letter = b[(i + turn) % letters], f = letter % m->n_face,
                  image = mirrored ? m->face[f].mirror : f;
        if (image < 0 || a[i] != image + (letter - f)) return false;
    }
    return true;
}

/* Whether a curve with this word leaves the event already, whatever letter it begins with, or its
 * mirror image does. */
static bool has_left(const ric_response_driver *d, const ric_force_orbit *o, int event)
{
    int *word = ric_response_keep_word(o);
    const int letters = o->events ? o->N : 0;
    bool found = false;
    for (int c = 0; word && c < d->r->n_curve && !found; c++) {
        const ric_response_curve *other = &d->r->curves[c].data;
        if (!mute(d, c, event) || other->letters != letters || other->harmonic != o->harmonic)
            continue;
        found = letters == 0;
        for (int turn = 0; turn < letters && !found; turn++)
            for (int image = 0; image <= d->own_image && !found; image++)
                found = same_word(d->medium->model, letters, word, d->r->curves[c].word, turn,
                                  image);
    }
    free(word);
    return found;
}

/* Takes o. */
static ric_status depart(ric_response_driver *d, ric_force_orbit *o, const double *direction,
                         int branch, int event)
{
    if (!o) return RIC_OK;
    if (ric_response_keep_impacts(o) > d->r->asked.impacts || has_left(d, o, event) ||
        ric_response_keep_repeats(o) || ric_response_keep_known(d, o)) {
        ric_force_orbit_free(o);
        return RIC_OK;
    }
    return ric_response_keep_follow(d, o, direction, branch, event);
}

static ric_status leave_grazing(ric_response_driver *d, ric_force_orbit *o, int branch, int event)
{
    ric_response_touch touches[RIC_TOUCHES_MOST];
    int n;
    double direction[o->m + 1];
    ric_status status = ric_response_word_touches(o, touches, &n);
    for (unsigned set = 0; n > 0 && n <= SETS_MOST && set < 1u << n && !status; set++) {
        ric_force_orbit *x = ric_response_word_change(o, &d->trace, n, touches, set, direction);
        status = ric_response_keep_forgive(d, depart(d, x, direction, branch, event));
    }
    return status;
}

/* Motions of several periods of the one that grazes, with the impact in one of them only: near a
 * grazing these begin, too, and beside a resonance of the force with the free motion they are the
 * ones that are stable (Nordmark, Nonlinearity 14 (2001); Ghosh and Simpson, arXiv 2510.16218). */
static ric_status leave_grazing_once(ric_response_driver *d, const ric_force_orbit *o, int branch,
                                     int event)
{
    ric_response_touch touches[RIC_TOUCHES_MOST];
    int n = 0;
    double direction[o->m + 1];
    ric_status status = RIC_OK;
    for (int copies = 2;
         copies <= d->r->asked.once_in && copies * o->harmonic <= d->r->asked.periods && !status;
         copies++) {
        ric_force_orbit *longer = ric_response_word_repeat(o, copies);
        status = longer ? ric_response_word_touches(longer, touches, &n)
                        : ric_no_memory("a response");
        for (int i = 0; i < n / copies && !status; i++) {
            ric_force_orbit *x = ric_response_word_change(longer, &d->trace, n, touches, 1u << i,
                                                          direction);
            status = ric_response_keep_forgive(d, depart(d, x, direction, branch, event));
        }
        ric_force_orbit_free(longer);
    }
    return status;
}

/* Direction [m + 1] of the curve at an event of it: from the row before to the one behind. At the
 * event itself the equations have two. */
static bool secant(ric_response_driver *d, const ric_response_mark *e, double *out)
{
    const ric_response_line *line = &d->r->curves[e->data.curve - 1];
    int i = 0;
    while (i + 2 < line->data.n_point && line->points[i + 1].data.arclength < e->data.at.arclength)
        i++;
    if (line->data.n_point < 2) return false;
    ric_force_orbit *x = ric_response_keep_orbit(d, line, &line->points[i]),
                    *y = ric_response_keep_orbit(d, line, &line->points[i + 1]);
    const bool found = x && y;
    double length = 0;
    const int m = found ? x->m : 0;
    for (int k = 0; k < m; k++) {
        const double off = y->u[k] - x->u[k];
        out[k] = k == 2 * x->n ? remainder(off, RIC_TWO_PI) : off;
    }
    out[m] = (ric_response_keep_value(d, &line->points[i + 1].data) -
              ric_response_keep_value(d, &line->points[i].data)) /
             d->trace.scale;
    for (int k = 0; k <= m; k++) length += out[k] * out[k];
    for (int k = 0; k <= m; k++) out[k] /= sqrt(length);
    ric_force_orbit_free(x);
    ric_force_orbit_free(y);
    return found && length > 0;
}

/* Whether a curve that left another event, or began beside an orbit of the atlas, has come to this
 * one. */
static bool reached(ric_response_driver *d, const ric_response_mark *event)
{
    bool found = false;
    for (int i = 0; i < d->r->n_curve && !found; i++) {
        const ric_response_line *line = &d->r->curves[i];
        for (int end = 0; end < 2 && !found && line->data.n_point > 0; end++) {
            const bool joins = end ? line->data.end == RIC_RESPONSE_JOINS
                                   : line->data.begin == RIC_RESPONSE_JOINS && !line->data.from;
            ric_force_orbit *x =
                joins ? ric_response_keep_orbit(d, line,
                                                &line->points[end ? line->data.n_point - 1 : 0])
                      : NULL;
            found = (end ? line->data.to : line->data.from) == event->data.id ||
                    (x && ric_response_keep_at_event(d, x, event));
            ric_force_orbit_free(x);
        }
    }
    return found;
}

static ric_status leave_aside(ric_response_driver *d, ric_force_orbit *o, int branch, int event,
                              ric_response_kind kind)
{
    const int m = o->m, copies = kind == RIC_RESPONSE_DOUBLING ? 2 : 1,
              sides = copies == 2 || ric_model_symmetric(d->medium->model) ? 1 : 2;
    double row[m + 1], direction[m + 1];
    ric_status status = RIC_OK;
    if (o->harmonic * copies > d->r->asked.periods ||
        ric_response_keep_impacts(o) * copies > d->r->asked.impacts ||
        reached(d, &d->r->events[event - 1]) || !secant(d, &d->r->events[event - 1], row))
        return RIC_OK;
    for (int side = 0; side < sides && !status; side++) {
        ric_force_orbit *x = ric_response_word_aside(o, &d->trace, row, copies, side ? -1 : 1,
                                                     direction);
        if (x && !ric_response_keep_known(d, x))
            status = ric_response_keep_forgive(d, ric_response_keep_follow(d, x, direction, branch,
                                                                           event));
        else ric_force_orbit_free(x);
    }
    return status;
}

static bool own_image(const ric_response_driver *d, const ric_force_orbit *o)
{
    const int size = 2 * o->n;
    double z[size], x[size], most = 0, length = 1;
    if (!ric_model_symmetric(d->medium->model)) return false;
    if (ric_force_motion_strobe(o, 0, z) || ric_force_motion_strobe(o, RIC_PI, x)) return false;
    for (int j = 0; j < size; j++) {
        most = fmax(most, fabs(z[j] + x[j]));
        length = fmax(length, 1 + fabs(z[j]));
    }
    return most < RIC_RESPONSE_SAME * length;
}

ric_status ric_response_leave(ric_response_driver *d, int event)
{
    const ric_response_mark *e = &d->r->events[event - 1];
    const ric_response_kind kind = e->data.kind;
    const int branch = d->r->curves[e->data.curve - 1].data.branch;
    ric_force_orbit *o = ric_response_keep_orbit(d, &d->r->curves[e->data.curve - 1], &e->row);
    ric_status status = RIC_OK;
    if (!o) return ric_trust(RIC_OK);
    d->own_image = own_image(d, o);
    if (kind == RIC_RESPONSE_GRAZING) status = leave_grazing(d, o, branch, event);
    if (kind == RIC_RESPONSE_GRAZING && !status) status = leave_grazing_once(d, o, branch, event);
    if (kind == RIC_RESPONSE_BRANCH_POINT || kind == RIC_RESPONSE_DOUBLING)
        status = leave_aside(d, o, branch, event, kind);
    ric_force_orbit_free(o);
    return status;
}
