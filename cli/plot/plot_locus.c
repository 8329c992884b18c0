/* ricochet plot locus: what becomes of junctions as a parameter of the structure varies. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/locus.h"
#include "plot.h"

static const double type = 12;

enum { MOST_LOCI = 8 };

typedef struct {
    const plot_options *common;
    bool frequency, has_window; /* frequency: upwards instead of the energy */
    double window[4];
    int n;
    cli_locus loci[MOST_LOCI];
    int junctions[MOST_LOCI];
    bool marked[RIC_LOCUS_END + 1];
    plot_units unit;
    plot_page *page;
    plot_panel panel;
} picture;

/* Scaled by the clearance that the first contact has at this value; a picture in physical units by
 * the one of the atlas, so that the energy of every point goes back to that first. */
static plot_point place(const picture *p, const cli_locus *x, const ric_locus_point *at)
{
    const double d = at->length / ric_model_length(ric_atlas_model(x->atlas));
    const double energy = p->common->physical ? cli_unit_of_energies(d) * at->energy : at->energy;
    return (plot_point){at->value, p->frequency ? at->frequency : energy};
}

static bool find_range(const picture *p, double x[2], double y[2])
{
    ric_locus_point at;
    plot_range_empty(x, y);
    for (int l = 0; l < p->n; l++)
        for (int i = 0; i < ric_locus_n_point(p->loci[l].locus); i++) {
            if (ric_locus_point_at(p->loci[l].locus, i, &at)) continue;
            const plot_point q = place(p, &p->loci[l], &at);
            plot_range_take(q, x, y);
        }
    plot_range_widen(false, 0.02, &x[0], &x[1]);
    plot_range_widen(false, 0.04, &y[0], &y[1]);
    if (p->has_window) plot_range_window(p->window, x, y);
    return x[1] > x[0];
}

static plot_mark mark_of(ric_locus_mark mark)
{
    static const plot_mark marks[] = {PLOT_DOT,     PLOT_CIRCLE,   PLOT_DOT,
                                      PLOT_DIAMOND, PLOT_TRIANGLE, PLOT_SQUARE};
    return marks[mark];
}

static ric_status draw_locus(picture *p, int l)
{
    const ric_locus *locus = p->loci[l].locus;
    plot_track track = {0};
    plot_point last = {0};
    ric_locus_point at;
    double s = 0;
    ric_status status = RIC_OK;
    for (int i = 0; i < ric_locus_n_point(locus) && !status; i++) {
        status = ric_locus_point_at(locus, i, &at);
        const plot_point q = place(p, &p->loci[l], &at), now = plot_panel_at(&p->panel, q);
        if (i > 0) s += hypot(now.x - last.x, now.y - last.y);
        last = now;
        if (!status && !plot_track_add(&track, q, s, RIC_STABLE_YES)) status = RIC_E_NOMEM;
    }
    if (!status && !plot_track_smooth(&p->panel, &track)) status = RIC_E_NOMEM;
    plot_point *curve = status ? NULL : malloc((size_t)track.n * sizeof *curve);
    for (int i = 0; curve && i < track.n; i++) curve[i] = track.knots[i].at;
    if (curve)
        plot_panel_curve(p->page, &p->panel, (plot_stroke)(PLOT_SERIES + l % 4), track.n, curve);
    else if (!status) status = RIC_E_NOMEM;
    free(curve);
    plot_track_free(&track);
    return status;
}

static void mark_locus(picture *p, int l)
{
    ric_locus_point at;
    for (int i = 0; i < ric_locus_n_point(p->loci[l].locus); i++) {
        if (ric_locus_point_at(p->loci[l].locus, i, &at) || at.mark == RIC_LOCUS_PLAIN ||
            at.mark == RIC_LOCUS_ASKED)
            continue;
        const plot_point q = place(p, &p->loci[l], &at);
        if (!plot_panel_inside(&p->panel, q)) continue;
        plot_page_mark(p->page, mark_of(at.mark), plot_panel_at(&p->panel, q), 3.6);
        p->marked[at.mark] = true;
    }
}

static void label_loci(picture *p)
{
    plot_tag tags[MOST_LOCI];
    ric_locus_point at;
    ric_junction j;
    int n = 0;
    for (int l = 0; l < p->n; l++) {
        const ric_locus *locus = p->loci[l].locus;
        if (ric_atlas_junction(p->loci[l].atlas, p->junctions[l], &j)) continue;
        for (int i = 0; i < ric_locus_n_point(locus); i++) {
            if (ric_locus_point_at(locus, i, &at) || at.mark != RIC_LOCUS_START) continue;
            const plot_point q = place(p, &p->loci[l], &at);
            if (!plot_panel_inside(&p->panel, q)) break;
            tags[n] = (plot_tag){.at = plot_panel_at(&p->panel, q),
                                 .clear = 6,
                                 .weight = 1,
                                 .colour = "#000000"};
            plot_text_label(j.name[0] ? j.name : j.label, sizeof tags[n].text, tags[n].text);
            n++;
            break;
        }
    }
    plot_place_tags(p->page, plot_panel_box(&p->panel), n, tags, type);
}

static int draw(picture *p)
{
    static const char *const names[] = {[RIC_LOCUS_START] = "in the atlas",
                                        [RIC_LOCUS_FOLD] = "fold",
                                        [RIC_LOCUS_MEETS] = "another kind, too",
                                        [RIC_LOCUS_END] = "end"};
    const double width = plot_layout_width(p->common, PLOT_WIDTH),
                 height = plot_layout_height(p->common, 440);
    plot_legend_entry entries[PLOT_MAX_LEGEND];
    double x[2], y[2];
    char title[200], up[200];
    int n = 0;
    ric_status status = RIC_OK;
    if (!find_range(p, x, y)) {
        cli_say("ricochet: nothing to draw: the locus is a point\n");
        return CLI_FAILED;
    }
    if (!(p->page = plot_page_create(width, height))) return cli_report(RIC_E_NOMEM);
    p->panel = (plot_panel){{.lo = x[0], .hi = x[1], .from = 78, .to = width - 18},
                            {.lo = y[0],
                             .hi = y[1],
                             .from = 92,
                             .to = height - plot_page_head(p->common, NULL),
                             .unit = p->frequency ? p->unit.frequency : p->unit.energy}};
    for (int l = 0; l < p->n && !status; l++) status = draw_locus(p, l);
    if (status) return cli_report(status);
    for (int l = 0; l < p->n; l++) mark_locus(p, l);
    label_loci(p);
    plot_text_escape(p->loci[0].vary.name, sizeof title, title);
    if (p->frequency) snprintf(up, sizeof up, "%s", plot_frequency_title(p->common));
    else
        plot_energy_title(p->common, 1,
                          (const ric_model *const[]){ric_atlas_model(p->loci[0].atlas)}, sizeof up,
                          up);
    plot_panel_frame(p->page, &p->panel, title, up);
    plot_page_title(p->page, p->common, NULL);
    for (int k = RIC_LOCUS_START; k <= RIC_LOCUS_END; k++)
        if (p->marked[k])
            entries[n++] = (plot_legend_entry){names[k], -1, (int)mark_of((ric_locus_mark)k)};
    plot_legend(p->page, n, entries, 12, width - 12, p->panel.y.from - 46);
    return plot_page_write(p->page, p->common);
}

/* One locus for each --junction; the other options hold for all. */
static int follow(int argc, char **argv, picture *p)
{
    const char *more[MOST_LOCI] = {NULL};
    cli_locus_request request;
    int n = 0, code = CLI_DONE;
    if (!cli_locus_take(&argc, argv, "plot locus", &request)) return CLI_WRONG;
    p->junctions[0] = request.junction;
    for (const char *text = ""; text && n + 1 < MOST_LOCI; n += text != NULL) {
        long id = 0;
        if (!cli_take_value(&argc, argv, "--junction", &text)) return CLI_WRONG;
        if ((more[n] = text) && !cli_parse_integer(text, "--junction", 1, 1000000000, &id))
            return CLI_WRONG;
        if (text) p->junctions[n + 1] = (int)id;
    }
    if (!cli_operands(&cli_plot, argc, argv, 1)) return CLI_WRONG;
    for (int l = 0; l <= n && code == CLI_DONE; l++) {
        request.junction = p->junctions[l];
        code = cli_locus_open(argv[1], &request, &p->loci[p->n++]);
    }
    return code;
}

int plot_locus(int argc, char **argv, const plot_options *common)
{
    picture *p = calloc(1, sizeof *p);
    const char *window, *upwards;
    if (!p) return cli_report(RIC_E_NOMEM);
    p->common = common;
    int code = CLI_WRONG;
    if (cli_take_value(&argc, argv, "--window", &window) &&
        cli_take_value(&argc, argv, "--y", &upwards) &&
        (!window || plot_parse_window(window, "--window", p->window))) {
        p->has_window = window;
        p->frequency = upwards && !strcmp(upwards, "frequency");
        code = !upwards || p->frequency || !strcmp(upwards, "energy")
                   ? follow(argc, argv, p)
                   : cli_wrong("plot locus: --y %s: write energy or frequency", upwards);
    }
    if (code == CLI_DONE) {
        p->unit = plot_units_of(common, ric_atlas_model(p->loci[0].atlas));
        code = draw(p);
    }
    plot_page_free(p->page);
    for (int l = 0; l < p->n; l++) cli_locus_close(&p->loci[l]);
    free(p);
    return code;
}
