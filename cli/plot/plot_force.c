/* ricochet plot force: which parts of an atlas a harmonic force of given amplitudes keeps up, to
 * first order. */
#define _POSIX_C_SOURCE 200809L

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/shaking.h"
#include "plot.h"

static const double type = 11;
static const double wide = 30; /* energies so far apart, as a ratio, need a logarithmic axis */

enum { MOST_LEVELS = 4, MOST_TURNS = 200 };

/* A branch: its stored points, and the threshold at each. */
typedef struct {
    ric_branch branch;
    int n;
    plot_point *at;                /* as they are drawn */
    double *arclength, *threshold; /* infinite where the force does no work */
    int *stable;
    bool *trusted;
} line;

typedef struct {
    plot_point at;
    double level;
    bool birth;
} turn;

typedef struct {
    const plot_options *common;
    cli_shaking shaking;
    const char *study;
    double levels[MOST_LEVELS]; /* falling */
    int n_level, dof;           /* dof: from 0, of the amplitude; -1: frequency over energy */
    bool logarithmic, has_window;
    double window[4];
    ric_atlas *atlas;
    ric_force *force;
    int n_line, n_turn;
    line *lines;
    turn turns[MOST_TURNS];
    plot_units unit;
    plot_page *page;
    plot_panel panel;
    bool family[3], lit[2 * MOST_LEVELS], births, joins;
    unsigned stability;
} picture;

/* --------------------------------------------------------------------- data */

static ric_status place_of(const picture *p, const ric_orbit *orbit, double energy,
                           double frequency, plot_point *out)
{
    double amplitudes[ric_model_n_dof(ric_atlas_model(p->atlas))];
    *out = (plot_point){energy, frequency};
    if (p->dof < 0) return RIC_OK;
    const ric_status status = ric_orbit_amplitudes(orbit, amplitudes);
    *out = (plot_point){p->shaking.harmonics[0] * frequency, status ? NAN : amplitudes[p->dof]};
    return status;
}

static ric_status add_point(const picture *p, line *l, int i)
{
    ric_point point;
    ric_prediction at;
    ric_orbit **orbits = NULL;
    int n = 0;
    ric_status status = ric_atlas_point(p->atlas, l->branch.id, i, &point, NULL, NULL);
    if (status || !(point.energy > 0)) return status;
    status = ric_orbit_find(p->atlas, l->branch.id, RIC_AT_POINT, i, &n, &orbits);
    if (!status && n)
        status = ric_force_predict(p->force, l->branch.id, orbits[0], p->shaking.harmonics[0], 0,
                                   &at);
    if (!status && n) status = place_of(p, orbits[0], point.energy, point.frequency, &l->at[l->n]);
    if (!status && n) {
        l->arclength[l->n] = point.arclength;
        l->threshold[l->n] = at.threshold;
        l->stable[l->n] = plot_point_stability(p->atlas, &l->branch, i, &point);
        l->trusted[l->n++] = at.trusted;
    }
    ric_orbits_free(n, orbits);
    return status;
}

static ric_status add_line(picture *p, int id)
{
    line *l = &p->lines[p->n_line++];
    ric_status status = ric_atlas_branch(p->atlas, id, &l->branch);
    const size_t n = status ? 1 : (size_t)l->branch.n_point + 1;
    l->at = calloc(n, sizeof *l->at);
    l->arclength = calloc(n, sizeof *l->arclength);
    l->threshold = calloc(n, sizeof *l->threshold);
    l->stable = calloc(n, sizeof *l->stable);
    l->trusted = calloc(n, sizeof *l->trusted);
    if (!l->at || !l->arclength || !l->threshold || !l->stable || !l->trusted) return RIC_E_NOMEM;
    for (int i = 0; i < l->branch.n_point && !status; i++) status = add_point(p, l, i);
    return status;
}

/* The stored point that ends the piece with this arclength, and which part of the piece lies before
 * it. */
static int piece_at(const line *l, double s, double *part)
{
    int i = 1;
    while (i < l->n - 1 && l->arclength[i] < s) i++;
    *part = (s - l->arclength[i - 1]) / (l->arclength[i] - l->arclength[i - 1]);
    return i;
}

/* Where a branch has this arclength: between two stored points on the chord of what is drawn. */
static plot_point at_arclength(const line *l, double s)
{
    double f;
    const int i = piece_at(l, s, &f);
    return (plot_point){l->at[i - 1].x + f * (l->at[i].x - l->at[i - 1].x),
                        l->at[i - 1].y + f * (l->at[i].y - l->at[i - 1].y)};
}

static ric_status add_turns(picture *p, const line *l)
{
    ric_force_extreme *list = NULL;
    int n = 0;
    if (l->n < 3) return RIC_OK;
    const ric_status status = ric_force_extremes(p->force, l->branch.id, p->shaking.harmonics[0],
                                                 &n, &list);
    for (int i = 0; i < n && p->n_turn < MOST_TURNS; i++) {
        const plot_point at = p->dof < 0 ? (plot_point){list[i].at.energy, list[i].at.frequency}
                                         : at_arclength(l, list[i].arclength);
        p->turns[p->n_turn++] = (turn){at, list[i].at.threshold, list[i].birth};
    }
    ric_force_extremes_free(list);
    return status;
}

static ric_status gather(picture *p)
{
    const ric_shaking shaking = cli_shaking_of(&p->shaking);
    const int n = ric_atlas_n_branch(p->atlas);
    ric_status status = ric_force_create(p->atlas, &shaking, &p->force);
    if (!status && !(p->lines = calloc((size_t)n + 1, sizeof *p->lines))) status = RIC_E_NOMEM;
    for (int id = 1; id <= n && !status; id++) status = add_line(p, id);
    for (int i = 0; i < p->n_line && !status; i++) status = add_turns(p, &p->lines[i]);
    return status;
}

static void release(picture *p)
{
    for (int i = 0; i < p->n_line; i++) {
        free(p->lines[i].at);
        free(p->lines[i].arclength);
        free(p->lines[i].threshold);
        free(p->lines[i].stable);
        free(p->lines[i].trusted);
    }
    free(p->lines);
    plot_page_free(p->page);
    ric_force_free(p->force);
    ric_atlas_free(p->atlas);
    cli_shaking_free(&p->shaking);
}

/* ------------------------------------------------------------------ drawing */

/* The threshold between stored points: its logarithm on a chord; *trusted as both of them are. */
static double threshold_at(const line *l, double s, bool *trusted)
{
    double f;
    const int i = piece_at(l, s, &f);
    const double a = l->threshold[i - 1], b = l->threshold[i];
    *trusted = l->trusted[i - 1] && l->trusted[i];
    if (isinf(a) || isinf(b)) return INFINITY;
    return exp((1 - f) * log(a) + f * log(b));
}

static plot_point between(plot_point a, plot_point b, double f)
{
    return (plot_point){a.x + f * (b.x - a.x), a.y + f * (b.y - a.y)};
}

/* The piece of a curve between two knots in which the threshold is below a level: the part from
 * f[0] to f[1]. */
static bool lit_part(double level, double a, double b, double f[2])
{
    if (!(a <= level) && !(b <= level)) return false;
    f[0] = 0;
    f[1] = 1;
    if (isinf(a) || isinf(b)) return false;
    const double cross = a == b ? 0 : log(level / a) / log(b / a);
    if (!(a <= level)) f[0] = cross;
    if (!(b <= level)) f[1] = cross;
    return true;
}

/* Bands under what a level keeps up, in dashes where that is not trusted. */
static void light(picture *p, const line *l, const plot_track *track, int k)
{
    for (int i = 0; i + 1 < track->n; i++) {
        const plot_knot *a = &track->knots[i], *b = a + 1;
        const double middle = (a->arclength + b->arclength) / 2;
        bool trusted, unused;
        double f[2];
        threshold_at(l, middle, &trusted);
        if (!lit_part(p->levels[k], threshold_at(l, a->arclength, &unused),
                      threshold_at(l, b->arclength, &unused), f))
            continue;
        const int stroke = k + (trusted ? 0 : MOST_LEVELS);
        const plot_point ends[2] = {between(a->at, b->at, f[0]), between(a->at, b->at, f[1])};
        plot_panel_curve(p->page, &p->panel, (plot_stroke)(PLOT_LIT + stroke), 2, ends);
        p->lit[stroke] |= plot_panel_inside(&p->panel, ends[0]) ||
                          plot_panel_inside(&p->panel, ends[1]);
    }
}

static ric_status draw_line(picture *p, const line *l)
{
    const plot_stroke family = plot_branch_family(ric_atlas_model(p->atlas), &l->branch);
    plot_track track = {0};
    ric_status status = RIC_OK;
    if (l->n < 2) return RIC_OK;
    for (int i = 0; i < l->n && !status; i++)
        if (!plot_track_add(&track, l->at[i], l->arclength[i], l->stable[i])) status = RIC_E_NOMEM;
    if (!status && !plot_track_smooth(&p->panel, &track)) status = RIC_E_NOMEM;
    for (int k = 0; k < p->n_level && !status; k++) light(p, l, &track, k);
    if (!status) p->stability |= plot_track_draw(p->page, &p->panel, family, &track);
    p->family[(family - PLOT_LINEAR) / 3] = true;
    plot_track_free(&track);
    return status;
}

static void draw_turns(picture *p)
{
    plot_tag tags[MOST_TURNS];
    int n = 0;
    for (int i = 0; i < p->n_turn; i++) {
        const turn *t = &p->turns[i];
        if (!plot_panel_inside(&p->panel, t->at)) continue;
        const plot_point at = plot_panel_at(&p->panel, t->at);
        plot_page_mark(p->page, t->birth ? PLOT_TRIANGLE : PLOT_TRIANGLE_DOWN, at, 4);
        p->births = p->births || t->birth;
        p->joins = p->joins || !t->birth;
        tags[n] = (plot_tag){.at = at,
                             .clear = 7,
                             .weight = 1 / (1 + t->level),
                             .colour = "#222222",
                             .leader = true};
        snprintf(tags[n++].text, sizeof tags[0].text, "%.4g", t->level);
    }
    plot_place_tags(p->page, plot_panel_box(&p->panel), n, tags, type);
}

static int legend(const picture *p, char texts[2 * MOST_LEVELS][80], plot_legend_entry *out)
{
    int n = plot_legend_entries(p->family, p->stability, NULL, out);
    for (int k = 0; k < 2 * MOST_LEVELS; k++) {
        if (!p->lit[k]) continue;
        snprintf(texts[k], sizeof texts[k], "kept up at %.6g%s", p->levels[k % MOST_LEVELS],
                 k < MOST_LEVELS ? "" : ", not to be trusted");
        out[n++] = (plot_legend_entry){texts[k], PLOT_LIT + k, -1};
    }
    if (p->births)
        out[n++] = (plot_legend_entry){"least threshold: an isola is born", -1, PLOT_TRIANGLE};
    if (p->joins) out[n++] = (plot_legend_entry){"largest: two join", -1, PLOT_TRIANGLE_DOWN};
    return n;
}

/* What the axes hold: branches with impacts, and the upper ends of linear modes. */
static bool find_range(const picture *p, double x[2], double y[2])
{
    plot_range_empty(x, y);
    for (int i = 0; i < p->n_line; i++) {
        const line *l = &p->lines[i];
        const bool linear = ric_branch_linear(ric_atlas_model(p->atlas), &l->branch);
        for (int j = linear && l->n > 1 ? l->n - 1 : 0; j < l->n; j++) {
            x[0] = fmin(x[0], l->at[j].x * (linear && p->dof < 0 ? 0.7 : 1));
            x[1] = fmax(x[1], l->at[j].x);
            y[0] = fmin(y[0], l->at[j].y);
            y[1] = fmax(y[1], l->at[j].y);
        }
    }
    for (int i = 0; i < 2 && p->has_window; i++) {
        x[i] = p->window[i] / (p->dof < 0 ? p->unit.energy : p->unit.frequency);
        y[i] = p->window[2 + i] / (p->dof < 0 ? p->unit.frequency : p->unit.length);
    }
    return x[1] >= x[0] && y[1] >= y[0];
}

static plot_scale scale_of(const picture *p, const double range[2])
{
    return range[0] > 0 && (p->logarithmic || range[1] > wide * range[0]) ? PLOT_SCALE_LOG
                                                                          : PLOT_SCALE_LINEAR;
}

static void set_axes(picture *p, const double x[2], const double y[2])
{
    const bool fep = p->dof < 0;
    p->panel = (plot_panel){{.scale = fep ? scale_of(p, x) : PLOT_SCALE_LINEAR,
                             .lo = x[0],
                             .hi = x[1],
                             .unit = fep ? p->unit.energy : p->unit.frequency},
                            {.scale = fep ? PLOT_SCALE_LINEAR : scale_of(p, y),
                             .lo = y[0],
                             .hi = y[1],
                             .unit = fep ? p->unit.frequency : p->unit.length}};
    if (!p->has_window) {
        plot_range_widen(p->panel.x.scale == PLOT_SCALE_LOG, 0.04, &p->panel.x.lo, &p->panel.x.hi);
        plot_range_widen(p->panel.y.scale == PLOT_SCALE_LOG, 0.05, &p->panel.y.lo, &p->panel.y.hi);
    }
}

static void frame(const picture *p)
{
    const ric_model *model = ric_atlas_model(p->atlas);
    const int m = p->shaking.harmonics[0];
    char across[120], up[120];
    if (p->dof < 0) {
        plot_energy_title(p->common, 1, &model, sizeof across, across);
        snprintf(up, sizeof up, "%s", plot_frequency_title(p->common));
        if (m > 1)
            snprintf(up + strlen(up), sizeof up - strlen(up), ", of the force %d times it", m);
    } else {
        snprintf(across, sizeof across, "frequency of the force%s",
                 p->common->hertz ? " (Hz)" : " Ω (rad/s)");
        snprintf(up, sizeof up, "max |x_{%d}|", p->dof + 1);
        if (p->common->physical) plot_append_unit(ric_model_units(model)->length, sizeof up, up);
    }
    plot_panel_frame(p->page, &p->panel, across, up);
}

static ric_status draw_all(picture *p, double foot)
{
    const double width = plot_layout_width(p->common, PLOT_WIDTH),
                 height = plot_layout_height(p->common, 500);
    ric_status status = RIC_OK;
    plot_page_free(p->page);
    if (!(p->page = plot_page_create(width, height))) return RIC_E_NOMEM;
    p->panel.x.from = 78;
    p->panel.x.to = width - 18;
    p->panel.y.from = 50 + foot;
    p->panel.y.to = height - plot_page_head(p->common, NULL);
    for (int i = 0; i < p->n_line && !status; i++) status = draw_line(p, &p->lines[i]);
    return status;
}

static int draw(picture *p)
{
    char texts[2 * MOST_LEVELS][80];
    plot_legend_entry entries[PLOT_MAX_LEGEND];
    double x[2], y[2];
    if (!find_range(p, x, y)) {
        cli_say("ricochet: nothing to draw: the atlas has no branches yet\n");
        return CLI_FAILED;
    }
    set_axes(p, x, y);
    ric_status status = draw_all(p, 0);
    if (!status) draw_turns(p);
    if (status) return cli_report(status);
    const int n = legend(p, texts, entries); /* what it needs is known once all is drawn */
    const double foot = plot_legend(NULL, n, entries, 12, plot_page_width(p->page) - 12, 0);
    if ((status = draw_all(p, foot))) return cli_report(status);
    frame(p);
    draw_turns(p);
    plot_page_title(p->page, p->common, NULL);
    plot_legend(p->page, n, entries, 12, plot_page_width(p->page) - 12, foot + 4);
    bool any = false;
    for (int k = 0; k < 2 * MOST_LEVELS; k++) any = any || p->lit[k];
    if (!any)
        cli_say("ricochet: no part of a branch in the picture is kept up at %.6g\n", p->levels[0]);
    return plot_page_write(p->page, p->common);
}

/* ------------------------------------------------------------------ options */

static int falling(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x < y) - (x > y);
}

static bool parse_levels(const char *text, picture *p)
{
    if (text && !cli_parse_list(text, "--level", MOST_LEVELS, &p->n_level, p->levels)) return false;
    for (int i = 0; i < p->n_level; i++)
        if (!(p->levels[i] > 0)) {
            cli_wrong("--level %s: a level is an amplitude of the force, above 0", text);
            return false;
        }
    return true;
}

/* What is not said by options, from the study. */
static int complete(picture *p)
{
    const int code = cli_shaking_read(&p->shaking, "plot force", p->study,
                                      ric_atlas_study(p->atlas));
    if (code) return code;
    for (int i = 0; !p->n_level && i < p->shaking.amplitude.n && i < MOST_LEVELS; i++)
        p->levels[i] = p->shaking.amplitude.value[i];
    if (!p->n_level)
        p->n_level = p->shaking.amplitude.n < MOST_LEVELS ? p->shaking.amplitude.n : MOST_LEVELS;
    if (!p->shaking.n_force)
        return cli_wrong("plot force: --force is missing; give the vector f of the force, one "
                         "number per displacement, "
                         "for example --force 1,0, or section forcing of the study");
    if (!p->n_level)
        return cli_wrong("plot force: --level L is missing, the amplitude of the force, or up to "
                         "%d of them, L1,L2",
                         MOST_LEVELS);
    if (p->shaking.n_harmonic > 1)
        return cli_wrong(
            "plot force: one picture shows one harmonic; give --harmonic M, one of the %d",
            p->shaking.n_harmonic);
    qsort(p->levels, (size_t)p->n_level, sizeof *p->levels, falling);
    return CLI_DONE;
}

int plot_force(int argc, char **argv, const plot_options *common)
{
    picture *p = calloc(1, sizeof *p);
    const char *output, *window, *level;
    int code = CLI_WRONG;
    if (!p) return cli_report(RIC_E_NOMEM);
    p->common = common;
    p->logarithmic = cli_take_flag(&argc, argv, "--log");
    if (cli_take_shaking(&argc, argv, &p->shaking, &code) &&
        cli_take_value(&argc, argv, "--study", &p->study) &&
        cli_take_value(&argc, argv, "--output", &output) &&
        cli_take_value(&argc, argv, "--window", &window) &&
        cli_take_value(&argc, argv, "--level", &level) && cli_operands(&cli_plot, argc, argv, 1) &&
        parse_levels(level, p) && (!window || plot_parse_window(window, "--window", p->window))) {
        p->has_window = window;
        p->dof = -1;
        ric_status status = ric_atlas_read(argv[1], &p->atlas);
        code = status ? cli_report(status)
               : plot_parse_output(output, ric_model_n_dof(ric_atlas_model(p->atlas)), &p->dof)
                   ? complete(p)
                   : CLI_WRONG;
        if (!code) p->unit = plot_units_of(common, ric_atlas_model(p->atlas));
        if (!code && (status = gather(p))) code = cli_report(status);
        if (!code) code = draw(p);
    }
    release(p);
    free(p);
    return code;
}
