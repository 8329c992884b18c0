/* ricochet plot response: amplitudes of exact forced motions over what varies. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "plot.h"

typedef struct {
    const plot_options *common;
    ric_response *response;
    int dof;  /* from 0 */
    bool rms; /* instead of the peak */
    bool logarithmic, has_window;
    double window[4], level; /* level: only these; 0: all */
    plot_units unit;
    plot_page *page;
    plot_panel panel;
    unsigned stability;
    bool kinds[RIC_RESPONSE_GRAZING + 1], with,
        without; /* seen: events; curves with impacts, and without */
} picture;

static double across(const picture *p, const ric_response_point *at)
{
    switch (ric_response_asked(p->response)->along) {
    case RIC_RESPONSE_OMEGA: return at->omega;
    case RIC_RESPONSE_LEVEL: return at->level;
    default: return at->restitution;
    }
}

static plot_point place(const picture *p, const ric_response_point *at)
{
    const double *values = p->rms ? at->rms : at->peak;
    return (plot_point){across(p, at), values[p->dof]};
}

static bool wanted(const picture *p, const ric_response_curve *c)
{
    return !(p->level > 0) || !(fabs(c->level / p->level - 1) > 1e-9);
}

static bool find_range(const picture *p, double x[2], double y[2])
{
    ric_response_curve c;
    ric_response_point at;
    plot_range_empty(x, y);
    for (int id = 1;
         id <= ric_response_n_curve(p->response) && !ric_response_curve_at(p->response, id, &c);
         id++)
        for (int i = 0;
             wanted(p, &c) && i < c.n_point && !ric_response_point_at(p->response, id, i, &at);
             i++) {
            const plot_point q = place(p, &at);
            if (p->logarithmic && !(q.y > 0)) continue;
            plot_range_take(q, x, y);
        }
    if (!(x[1] >= x[0])) return false;
    plot_range_widen(false, 0.02, &x[0], &x[1]);
    plot_range_widen(p->logarithmic, 0.04, &y[0], &y[1]);
    if (p->has_window) plot_range_window(p->window, x, y);
    return true;
}

/* A curve that begins at an event of another one is drawn from there. */
static ric_status add_end(const picture *p, int event, plot_track *track, double arclength)
{
    ric_response_event e;
    if (!event) return RIC_OK;
    ric_status status = ric_response_event_at(p->response, event, &e);
    if (!status && !plot_track_join(track, place(p, &e.at), arclength)) status = RIC_E_NOMEM;
    return status;
}

/* Events inside a curve: there the stability changes, not somewhere between two points. */
static ric_status add_events(const picture *p, int curve, plot_track *track)
{
    ric_response_event e;
    ric_status status = RIC_OK;
    for (int id = 1; id <= ric_response_n_event(p->response) && !status; id++) {
        status = ric_response_event_at(p->response, id, &e);
        if (status || e.curve != curve || e.kind == RIC_RESPONSE_GRAZING) continue;
        if (!plot_track_join(track, place(p, &e.at), e.at.arclength)) status = RIC_E_NOMEM;
    }
    plot_track_sort(track);
    return status;
}

static ric_status draw_curve(picture *p, const ric_response_curve *c)
{
    plot_track track = {0};
    ric_response_point at = {0};
    ric_status status = ric_response_point_at(p->response, c->id, 0, &at);
    if (!status) status = add_end(p, c->from, &track, at.arclength - 1);
    for (int i = 0; i < c->n_point && !status; i++) {
        status = ric_response_point_at(p->response, c->id, i, &at);
        if (!status && !plot_track_add(&track, place(p, &at), at.arclength, (int)at.stable))
            status = RIC_E_NOMEM;
    }
    if (!status) status = add_end(p, c->to, &track, at.arclength + 1);
    const double end = at.arclength + 1;
    if (!status && c->end == RIC_RESPONSE_CLOSED) {
        status = ric_response_point_at(p->response, c->id, 0, &at);
        if (!status && !plot_track_join(&track, place(p, &at), end)) status = RIC_E_NOMEM;
    }
    if (!status) status = add_events(p, c->id, &track);
    if (!status && !plot_track_smooth(&p->panel, &track)) status = RIC_E_NOMEM;
    if (!status)
        p->stability |= plot_track_draw(p->page, &p->panel,
                                        c->letters ? PLOT_SYMMETRIC : PLOT_LINEAR, &track);
    p->with = p->with || c->letters;
    p->without = p->without || !c->letters;
    plot_track_free(&track);
    return status;
}

static plot_mark mark_of(ric_response_kind kind)
{
    static const plot_mark marks[] = {PLOT_DOT, PLOT_DIAMOND, PLOT_SQUARE, PLOT_STAR, PLOT_CIRCLE};
    return marks[kind];
}

static ric_status draw_events(picture *p)
{
    ric_response_event e;
    ric_response_curve c;
    ric_status status = RIC_OK;
    for (int id = 1; id <= ric_response_n_event(p->response) && !status; id++) {
        status = ric_response_event_at(p->response, id, &e);
        if (!status) status = ric_response_curve_at(p->response, e.curve, &c);
        if (status || !wanted(p, &c) || e.kind == RIC_RESPONSE_FOLD ||
            !plot_panel_inside(&p->panel, place(p, &e.at)))
            continue;
        plot_page_mark(p->page, mark_of(e.kind), plot_panel_at(&p->panel, place(p, &e.at)), 3.6);
        p->kinds[e.kind] = true;
    }
    return status;
}

static int legend(const picture *p, plot_legend_entry *out)
{
    static const char *const names[] = {"fold", "branch point", "doubling", "Neimark–Sacker",
                                        "grazing"};
    static const char *const stabilities[] = {[RIC_STABLE_YES] = "with impacts, stable",
                                              [RIC_STABLE_NO] = "with impacts, unstable",
                                              [RIC_STABLE_UNDECIDED] = "undecided"};
    int n = 0;
    if (p->without) out[n++] = (plot_legend_entry){"no impacts", PLOT_LINEAR + RIC_STABLE_YES, -1};
    for (int s = 0; s < 3; s++)
        if (p->with && p->stability >> s & 1)
            out[n++] = (plot_legend_entry){stabilities[s], PLOT_SYMMETRIC + s, -1};
    for (int k = 0; k <= RIC_RESPONSE_GRAZING; k++)
        if (p->kinds[k])
            out[n++] = (plot_legend_entry){names[k], -1, (int)mark_of((ric_response_kind)k)};
    return n;
}

static int draw(picture *p)
{
    const double width = plot_layout_width(p->common, PLOT_WIDTH),
                 height = plot_layout_height(p->common, 500);
    static const char *const titles[] = {"frequency of the force", "level of the force",
                                         "restitution"};
    const ric_response_along along = ric_response_asked(p->response)->along;
    double x[2], y[2];
    char across_title[80], up[80];
    ric_status status = RIC_OK;
    if (!find_range(p, x, y)) {
        cli_say("ricochet: nothing to draw: the response has no curve of this level\n");
        return CLI_FAILED;
    }
    if (!(p->page = plot_page_create(width, height))) return cli_report(RIC_E_NOMEM);
    const double unit = along == RIC_RESPONSE_OMEGA ? p->unit.frequency : 1;
    p->panel = (plot_panel){{.scale = PLOT_SCALE_LINEAR,
                             .lo = x[0],
                             .hi = x[1],
                             .from = 78,
                             .to = width - 34,
                             .unit = unit},
                            {.scale = p->logarithmic ? PLOT_SCALE_LOG : PLOT_SCALE_LINEAR,
                             .lo = y[0],
                             .hi = y[1],
                             .from = 92,
                             .to = height - plot_page_head(p->common, NULL),
                             .unit = p->unit.length}};
    ric_response_curve c;
    for (int id = 1; id <= ric_response_n_curve(p->response) && !status; id++) {
        status = ric_response_curve_at(p->response, id, &c);
        if (!status && wanted(p, &c) && c.n_point) status = draw_curve(p, &c);
    }
    if (!status) status = draw_events(p);
    if (status) return cli_report(status);
    snprintf(across_title, sizeof across_title, "%s%s", titles[along],
             along == RIC_RESPONSE_OMEGA ? (p->common->hertz ? " (Hz)" : " Ω (rad/s)") : "");
    const ric_units *units = ric_model_units(ric_response_model(p->response));
    if (along == RIC_RESPONSE_LEVEL)
        plot_append_unit(units->force, sizeof across_title, across_title);
    snprintf(up, sizeof up, p->rms ? "rms of x_{%d}" : "max |x_{%d}|", p->dof + 1);
    if (p->common->physical) plot_append_unit(units->length, sizeof up, up);
    plot_panel_frame(p->page, &p->panel, across_title, up);
    plot_page_title(p->page, p->common, NULL);
    plot_legend_entry entries[PLOT_MAX_LEGEND];
    const int n = legend(p, entries);
    plot_legend(p->page, n, entries, 12, width - 12, p->panel.y.from - 46);
    return plot_page_write(p->page, p->common);
}

int plot_response(int argc, char **argv, const plot_options *common)
{
    picture p = {.common = common};
    const char *output, *window, *level;
    int code = CLI_WRONG;
    p.rms = cli_take_flag(&argc, argv, "--rms");
    p.logarithmic = cli_take_flag(&argc, argv, "--log");
    if (!cli_take_value(&argc, argv, "--output", &output) ||
        !cli_take_value(&argc, argv, "--window", &window) ||
        !cli_take_value(&argc, argv, "--level", &level) ||
        !cli_operands(&cli_plot, argc, argv, 1) ||
        (window && !plot_parse_window(window, "--window", p.window)) ||
        (level && !cli_parse_number(level, "--level", &p.level)))
        return code;
    p.has_window = window;
    ric_status status = ric_response_read(argv[1], &p.response);
    if (status) return cli_report(status);
    p.unit = plot_units_of(common, ric_response_model(p.response));
    const int n = ric_model_n_dof(ric_response_model(p.response));
    p.dof = n - 1;
    if (plot_parse_output(output, n, &p.dof)) code = draw(&p);
    plot_page_free(p.page);
    ric_response_free(p.response);
    return code;
}
