#include "windows.h"

#include <math.h>

#include "model/room.h"
#include "options.h"
#include "base/room.h"

/* The energy window ends at so many times the first onset, at seventeen times its amplitudes: there
 * gaps are crossed in a short part of a turn, and a spring of a power law is as stiff as the
 * structure a hundred times or more. */
#define MANY_ONSETS 300.0
#define LOWEST                                                                                     \
    4.0 /* and at this many times that of the lowest mode, which is looked for first:              \
         */
/* FAR: unless its onset is so much higher than that of another, as near a node of the mode */
#define FAR 1e4
/* LOOSE: the window of a loose mass, which moves at any energy, begins at so many times the onset,
 * at a fifth of its speeds: below, families of long periods lie densely and cost most of a run */
#define LOOSE 0.04
/* OVERTONE: the frequency window ends at so many times the highest mode that is met in it */
#define OVERTONE 5.0
/* LEAST_PART: of the slowest mode, longer periods than that are not looked for by themselves */
#define LEAST_PART (1.0 / 64)
#define PHASE 1e7 /* a mode turns less within the longest period: the limit of a run */
/* FREE_LOW: gaps that a body without any spring crosses in a second, for want of another time */
#define FREE_LOW 0.1
#define FREE_HIGH 10.0
enum { FEW = 5, MANY = 10 }; /* seen modes that are kept anyway, and of more at most so many */
/* FREE_PART: of the top of an energy window that is given, where frequencies begin if that begins
 * at 0 */
#define FREE_PART 1e-4

/* ----------------------------------------------------------------- rounding */

/* Two digits, so that rounding of the modes does not change the window and the numbers are easily
 * read. */
static double rounded(double x, double (*toward)(double))
{
    if (!(x > 0) || !isfinite(x)) return x;
    int exponent = (int)floor(log10(x)) - 1;
    if (exponent < -300 || exponent > 300) return x;
    return exponent >= 0 ? toward(x / pow(10, exponent)) * pow(10, exponent)
                         : toward(x * pow(10, -exponent)) / pow(10, -exponent);
}

/* ------------------------------------------------------------------- modes */

/* What the window is made for: modes that the exploration starts from, and their onsets. */
typedef struct {
    double first, lowest; /* smallest onset, and that of the lowest mode; +inf: none */
    double slow, fast;    /* frequencies of the modes that are met up to `top` */
    double top;
    bool loose; /* a seen mode has no frequency */
    double cc;  /* c.c of the loose modes at the first contact */
} range;

static bool is_started(const ric_explore_options *o, int mode)
{
    for (int i = 0; i < o->n_start; i++)
        if (o->start[i] == mode + 1) return true;
    return o->n_start == 0;
}

static void find_onsets(const ric_model *m, const ric_explore_options *o, const double *onset,
                        range *r)
{
    for (int i = 0; i < m->n_dof; i++) {
        if (m->seen[i] && m->frequency[i] == 0) {
            r->loose = true;
            r->cc += m->normal[i] * m->normal[i];
        }
        if (!is_started(o, i) || !isfinite(onset[i])) continue;
        if (!isfinite(r->lowest)) r->lowest = onset[i];
        r->first = fmin(r->first, onset[i]);
    }
}

/* Modes that are not met up to the top of the energy window stay straight lines there. */
static void find_frequencies(const ric_model *m, const ric_explore_options *o, const double *onset,
                             range *r)
{
    const double top = ric_option_is_auto(o->energy) ? r->top : fmax(o->energy[1], r->first);
    for (int i = 0; i < m->n_dof; i++)
        if (is_started(o, i) && onset[i] <= top) {
            r->slow = fmin(r->slow, m->frequency[i]);
            r->fast = fmax(r->fast, m->frequency[i]);
        }
}

static range find_range(const ric_model *m, const ric_explore_options *o)
{
    double onset[m->n_dof];
    range r = {.first = HUGE_VAL, .lowest = HUGE_VAL, .slow = HUGE_VAL};
    ric_model_onsets(m, onset);
    find_onsets(m, o, onset, &r);
    r.top = MANY_ONSETS * r.first;
    if (r.lowest < FAR * r.first) r.top = fmax(r.top, LOWEST * r.lowest);
    find_frequencies(m, o, onset, &r);
    return r;
}

/* ------------------------------------------------------------------ choice */

/* Orbits of N impacts are in the end N / 2 turns of the slowest mode. In powers of two, so that a
 * few impacts more do not change the window, and with it all that was computed in it. */
static double slowest(const ric_explore_options *o)
{
    double part = 1;
    while (part * o->impacts > 2 && part > LEAST_PART) part /= 2;
    return fmin(part, 0.5);
}

static void choose_energy(const ric_model *m, const range *r, double out[2])
{
    const bool body = !isfinite(r->first);
    const double unit = body ? 0.5 / r->cc
                             : r->first; /* that of a body that crosses the gap once a second */
    out[0] = body                                ? FREE_LOW * FREE_LOW * unit
             : r->loose && ric_model_detached(m) ? LOOSE * unit
                                                 : 0;
    out[1] = rounded(body ? FREE_HIGH * FREE_HIGH * unit : r->top, ceil);
    out[0] = rounded(out[0], floor);
}

/* Frequency of a loose mass at an energy: it crosses four gaps a period, at a speed, in gaps, of
 * sqrt(2 E c.c). */
static double loose_frequency(const range *r, double energy)
{
    return RIC_TWO_PI / 4 * sqrt(2 * energy * r->cc);
}

static void choose_frequency(const ric_model *m, const ric_explore_options *o, const range *r,
                             double out[2])
{
    double fastest = 0;
    const bool given = !ric_option_is_auto(o->energy),
               below = given && r->loose && o->energy[1] < r->first;
    if (!isfinite(r->first) || below) { /* what moves in the window are loose masses */
        const double unit = 0.5 / r->cc, top = given ? o->energy[1] : FREE_HIGH * FREE_HIGH * unit,
                     low = given ? fmax(o->energy[0], FREE_PART * top) : FREE_LOW * FREE_LOW * unit;
        out[0] = rounded(loose_frequency(r, low), floor);
        out[1] = rounded(2 * loose_frequency(r, top), ceil);
        return;
    }
    for (int i = 0; i < m->n_dof; i++)
        if (m->seen[i]) fastest = fmax(fastest, m->frequency[i]);
    const double low = rounded(r->slow * slowest(o), floor),
                 least = rounded(RIC_TWO_PI * fastest / PHASE, ceil);
    out[0] = least > low && least < r->slow ? least : low;
    out[1] = rounded(OVERTONE * r->fast, ceil);
}

static ric_status check_option(const char *key, const double window[2])
{
    const ric_option *option = ric_option_find("explore", key);
    if (window[0] < window[1] &&
        (option->above ? window[0] > option->min : window[0] >= option->min) &&
        window[1] <= option->max)
        return RIC_OK;
    return ric_fail(
        RIC_E_INPUT,
        "the model asks for the %s window [%.3g, %.3g], and numbers up to %g are taken; choose "
        "other units for mass, stiffness and lengths",
        key, window[0], window[1], option->max);
}

ric_status ric_windows_choose(const ric_model *m, ric_explore_options *o)
{
    const bool energy = ric_option_is_auto(o->energy), frequency = ric_option_is_auto(o->frequency);
    if (!energy && !frequency) return RIC_OK;
    const range r = find_range(m, o);
    if (!isfinite(r.first) && !r.loose)
        return ric_fail(
            RIC_E_INPUT,
            "explore.start: no contact sees any of the modes named, and there is nothing to "
            "explore from them; leave out start, or name others");
    if (frequency) choose_frequency(m, o, &r, o->frequency);
    if (energy) choose_energy(m, &r, o->energy);
    ric_status status = check_option("energy", o->energy);
    return status ? status : check_option("frequency", o->frequency);
}

/* ------------------------------------------------------------- fewer modes */

bool ric_windows_few(const ric_model *m)
{
    return m->n <= FEW;
}

int ric_windows_worth(int n, const double *frequency, double highest)
{
    int out = 0;
    while (out < n && frequency[out] <= RIC_WINDOWS_FAR * highest) out++;
    return out;
}

ric_status ric_windows_modes(const ric_model *m, const ric_explore_options *options, int *out)
{
    ric_explore_options open = *options, *o = &open;
    int seen = 0, n = 0, least = 1;
    *out = m->n_dof;
    open.energy[0] = open.energy[1] = 0;
    if (ric_windows_few(m)) return RIC_OK;
    const range r = find_range(m, o);
    if (!isfinite(r.first)) return RIC_OK;
    for (int i = 0; i < o->n_start; i++) least = o->start[i] > least ? o->start[i] : least;
    const int worth = ric_windows_worth(m->n_dof, m->frequency, r.fast);
    for (; n < m->n_dof; n++) {
        const bool many = seen + m->seen[n] > MANY;
        if (n >= least && (n >= worth || many)) break;
        seen += m->seen[n];
    }
    while (n < m->n_dof && ric_truncate_check(m, n)) n++; /* modes of one frequency stay together */
    *out = n;
    return RIC_OK;
}

/* Points that take some four seconds on one core of 2022. More modes are more work for each, less
 * so where the closing and opening of springs is most of it; what is integrated, under a power law,
 * grows with their cube. */
#define RIGID_POINTS 20000.0
#define RIGID_TWICE 2.5 /* with so many modes more it is once more the work */
#define SPRING_POINTS 1500.0
#define SPRING_TWICE 10.0
#define POWER_POINTS 8000.0
#define LEAST_POINTS 200.0

int ric_windows_points(const ric_model *m)
{
    const double n = m->n;
    bool springs = false;
    for (int f = 0; f < m->n_contact; f++) springs |= m->contact[f].law == RIC_LAW_BILINEAR;
    const double points = m->law == RIC_LAW_POWER ? POWER_POINTS / (n * n * n)
                          : springs               ? SPRING_POINTS / (1 + n / SPRING_TWICE)
                                                  : RIGID_POINTS / (1 + n / RIGID_TWICE);
    return (int)rounded(fmax(points, LEAST_POINTS), floor);
}
