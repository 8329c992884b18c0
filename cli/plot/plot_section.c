/* ricochet plot section: motions of one energy on the section of a face, and the orbits of an atlas
 * there. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/section.h"
#include "plot.h"

static const double type = 13;

/* Between the lines that make up the bar of shades, pixels: less than their width, so that none
 * shows through. */
#define BAR_STEP 0.7

enum {
    SHADES = 15,
    MOST_PLACES =
        4000, /* in a period of an orbit, under a power law; between contacts the word tells */
};

typedef struct {
    const plot_options *common;
    cli_section_request request;
    cli_section from;
    cli_section_orbits orbits;    /* of the atlas at this energy */
    int face, image, n_dof, size; /* size: coordinates on the section */
    bool by_rotation, has_window;
    double window[4], range[2]; /* range: of what is shaded */
    plot_page *page;
    plot_panel panel;
    bool marked[3]; /* kinds of orbits, ric_stability */
} picture;

/* ------------------------------------------------------------------ places */

/* The place of an impact on the face that is drawn, or of its mirror image there: displacement and
 * momentum along it. */
static bool place_of(const picture *p, const ric_section *section, int start, long k, double *time,
                     plot_point *out)
{
    double state[2 * p->n_dof], place[p->size];
    int face;
    if (ric_section_impact(section, start, k, time, &face, state, state + p->n_dof)) return false;
    if (face != p->face && face != p->image) return false;
    for (int i = 0; i < 2 * p->n_dof && face != p->face; i++) state[i] = -state[i];
    if (ric_section_place(section, p->face, state, state + p->n_dof, place)) return false;
    *out = (plot_point){place[0], place[p->size / 2]};
    return true;
}

/* ------------------------------------------------------------------- dots */

static double shaded(const picture *p, const ric_section_track *track)
{
    return p->by_rotation ? track->rotation : fmax(0, track->lyapunov);
}

static bool find_range(picture *p)
{
    const ric_section *section = p->from.section;
    p->range[0] = p->by_rotation ? INFINITY : 0;
    p->range[1] = p->by_rotation ? -INFINITY : 0;
    for (int i = 0; i < ric_section_n_start(section); i++) {
        ric_section_track track;
        if (ric_section_track_at(section, i, &track) || isnan(shaded(p, &track))) continue;
        p->range[0] = fmin(p->range[0], shaded(p, &track));
        p->range[1] = fmax(p->range[1], shaded(p, &track));
    }
    return p->range[1] > p->range[0];
}

static plot_stroke shade_of(const picture *p, double value)
{
    if (isnan(value)) return PLOT_SHADE;
    const double part = p->range[1] > p->range[0]
                            ? (value - p->range[0]) / (p->range[1] - p->range[0])
                            : 0;
    return (plot_stroke)(PLOT_SHADE + 1 + (int)fmin(SHADES - 1, floor(part * SHADES)));
}

static long draw_dots(picture *p)
{
    const ric_section *section = p->from.section;
    long drawn = 0;
    for (int i = 0; i < ric_section_n_start(section); i++) {
        ric_section_track track;
        plot_point place;
        if (ric_section_track_at(section, i, &track)) continue;
        for (long k = 0; k < track.impacts; k++) {
            if (!place_of(p, section, i, k, NULL, &place) || !plot_panel_inside(&p->panel, place))
                continue;
            const plot_point at =
                plot_panel_at(&p->panel, place); /* a line without length has two round ends */
            plot_page_line(p->page, shade_of(p, shaded(p, &track)), 2,
                           (plot_point[]){at, {at.x + 0.02, at.y}});
            drawn++;
        }
    }
    return drawn;
}

/* ------------------------------------------------------------------ orbits */

static plot_mark mark_of(ric_stability stable)
{
    return stable == RIC_STABLE_YES  ? PLOT_CIRCLE
           : stable == RIC_STABLE_NO ? PLOT_CROSS
                                     : PLOT_DIAMOND;
}

static void mark_place(picture *p, plot_point place, ric_stability stable)
{
    if (!plot_panel_inside(&p->panel, place)) return;
    plot_page_mark(p->page, mark_of(stable), plot_panel_at(&p->panel, place), 3.6);
    p->marked[stable] = true;
}

/* One period of each orbit; its reversal in time, an orbit too, has the momenta turned round. */
static void mark_orbits(picture *p, const ric_section *section)
{
    for (int i = 0; i < p->orbits.n; i++) {
        const cli_section_orbit *orbit = &p->orbits.orbits[i];
        ric_section_track track;
        double time = 0;
        if (ric_section_track_at(section, i, &track)) continue;
        for (long k = 0; k < track.impacts; k++) {
            plot_point place;
            ric_section_impact(section, i, k, &time, NULL, NULL, NULL);
            if (time > orbit->period * (1 - 1e-6)) break;
            if (!place_of(p, section, i, k, NULL, &place)) continue;
            mark_place(p, place, orbit->stable);
            if (fabs(place.y) > 1e-6) mark_place(p, (plot_point){place.x, -place.y}, orbit->stable);
        }
    }
}

static ric_status draw_orbits(picture *p)
{
    ric_section *section = NULL;
    ric_section_options options = p->request.options;
    long most = 1;
    ric_status status = cli_section_find(p->from.atlas, 0, options.energy, &p->orbits);
    if (status || p->orbits.n == 0) return status;
    for (int i = 0; i < p->orbits.n; i++)
        if (p->orbits.orbits[i].impacts >= most) most = p->orbits.orbits[i].impacts + 1;
    options.impacts = ric_model_n_face(p->from.model) == 0 ? MOST_PLACES : most;
    options.n_given = p->orbits.n;
    options.given = p->orbits.states;
    options.radius = 0;
    options.rows = true;
    status = ric_section_create(p->from.model, &options, &section);
    if (!status) status = ric_section_run(section);
    if (!status) mark_orbits(p, section);
    ric_section_free(section);
    return status;
}

/* -------------------------------------------------------------------- page */

/* What the shades mean: a bar on the right, with its ends. */
static void draw_bar(picture *p)
{
    const double left = p->panel.x.to + 18, bottom = p->panel.y.from + 30, top = p->panel.y.to - 30;
    char text[40];
    for (double y = bottom; y <= top; y += BAR_STEP) {
        const double value = p->range[0] +
                             (p->range[1] - p->range[0]) * (y - bottom) / (top - bottom);
        plot_page_line(p->page, shade_of(p, value), 2, (plot_point[]){{left, y}, {left + 12, y}});
    }
    for (int i = 0; i <= 4; i++) {
        const double y = bottom + (top - bottom) * i / 4;
        snprintf(text, sizeof text, "%.3g", p->range[0] + (p->range[1] - p->range[0]) * i / 4);
        plot_page_text(p->page, (plot_point){left + 20, y}, PLOT_LEFT, type - 2, "#222222", false,
                       text);
    }
    plot_page_text(p->page, (plot_point){left + 66, (bottom + top) / 2}, PLOT_CENTRE, type - 1,
                   "#222222", true,
                   p->by_rotation ? "rotation, turns per impact" : "Lyapunov exponent (1/s)");
}

static void draw_legend(picture *p)
{
    static const char *const texts[] = {"hyperbolic orbit", "elliptic orbit",
                                        "orbit, stability undecided"};
    plot_legend_entry entries[3];
    int n = 0;
    for (int i = 0; i < 3; i++)
        if (p->marked[i])
            entries[n++] = (plot_legend_entry){texts[i], -1, (int)mark_of((ric_stability)i)};
    if (n) plot_legend(p->page, n, entries, p->panel.x.from, p->panel.x.to, p->panel.y.from - 46);
}

static void draw_title(picture *p)
{
    char text[40];
    snprintf(text, sizeof text, "%s = %.9g", plot_energy_letter(p->from.model), p->request.energy);
    plot_page_title(p->page, p->common, text);
}

static int draw(picture *p)
{
    const double width = plot_layout_width(p->common, PLOT_WIDTH),
                 height = plot_layout_height(p->common, 660);
    const double whole[4] = {-1.04, 1.04, -1.04, 1.04}, *w = p->has_window ? p->window : whole;
    p->page = plot_page_create(width, height);
    if (!p->page) return cli_report(RIC_E_NOMEM);
    p->panel = (plot_panel){{.lo = w[0], .hi = w[1], .from = 78, .to = width - 110},
                            {.lo = w[2], .hi = w[3], .from = 80, .to = height - 34}};
    const bool told = find_range(p);
    const long drawn = draw_dots(p);
    if (drawn == 0) {
        cli_say("ricochet: nothing to draw: no impact on face %d lies inside the picture\n",
                p->face);
        return CLI_FAILED;
    }
    const ric_status status = p->from.atlas ? draw_orbits(p) : RIC_OK;
    if (status) return cli_report(status);
    plot_panel_frame(p->page, &p->panel, "displacement along the face, of the largest",
                     "momentum along the face, of the largest");
    if (told) draw_bar(p);
    draw_legend(p);
    draw_title(p);
    return plot_page_write(p->page, p->common);
}

static bool take_request(int *argc, char **argv, picture *p)
{
    const char *face, *colour, *window;
    long number = 0;
    if (!cli_section_take(argc, argv, "plot section", CLI_SECTION_DRAWN, &p->request) ||
        !cli_take_value(argc, argv, "--face", &face) ||
        !cli_take_value(argc, argv, "--colour", &colour) ||
        !cli_take_value(argc, argv, "--window", &window) ||
        !cli_operands(&cli_plot, *argc, argv, 1) ||
        (face && !cli_parse_integer(face, "--face", 0, 100000, &number)) ||
        (window && !plot_parse_window(window, "--window", p->window)))
        return false;
    p->face = (int)number;
    p->has_window = window;
    p->by_rotation = colour && !strcmp(colour, "rotation");
    if (!colour || p->by_rotation || !strcmp(colour, "lyapunov")) return true;
    cli_wrong("--colour %s: there are lyapunov and rotation", colour);
    return false;
}

int plot_section(int argc, char **argv, const plot_options *common)
{
    picture p = {.common = common};
    if (!take_request(&argc, argv, &p)) return CLI_WRONG;
    int code = cli_section_open(argv[1], &p.from);
    if (!code && ric_model_n_mode(p.from.model) < 2) {
        cli_wrong(
            "plot section: a single mode has one motion of each energy: its section is a point");
        code = CLI_FAILED;
    }
    if (!code)
        code = cli_section_follow(&p.request, plot_units_of(common, p.from.model).length, &p.from);
    const bool cut = code == CLI_LIMIT || code == CLI_INTERRUPTED;
    if (code == CLI_DONE || code == CLI_LIMIT) {
        p.n_dof = ric_model_n_dof(p.from.model);
        p.size = 2 * (ric_model_n_mode(p.from.model) - 1);
        p.image = ric_section_image(p.from.section, p.face);
        const int drawn = draw(&p);
        code = drawn ? drawn : code;
    }
    if (cut) cli_say("ricochet: stopped before all impacts were reached\n");
    plot_page_free(p.page);
    cli_section_release(&p.orbits);
    cli_section_close(&p.from);
    return code;
}
