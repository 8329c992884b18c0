/* Force curves of contacts: what a rigid stop, a spring beyond a gap and a spring of a power do
 * along their normal. */
#define _POSIX_C_SOURCE 200809L

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/section.h"
#include "plot.h"

enum { MAX_CURVE = 6, SAMPLES = 1200, LAWS = 3 };
static const double type = 12;
/* Of the unit of length: how far the axis goes, and where the softest law reaches its top. */
static const double reach = 1.6, top_at = 1.4;

typedef struct {
    ric_contact contact;
    double unit; /* clearance, or length of a power law */
    char key[400];
} curve;

typedef struct {
    const plot_options *common;
    plot_atlases files; /* paths only */
    int n_open, n, n_panel;
    cli_section sources[MAX_CURVE];
    curve curves[MAX_CURVE];
    ric_law panels[LAWS];
    plot_page *page;
} picture;

/* The force with which a contact pushes back at gap s, in units of the study; infinite behind a
 * rigid stop. */
static double force(const curve *c, double s)
{
    const ric_contact *k = &c->contact;
    if (k->law == RIC_LAW_POWER) {
        const double part = k->length > 0 ? s / k->length : s;
        return (k->length > 0 ? k->reference * k->length : k->stiffness) * pow(part, k->exponent);
    }
    const bool upper = s > k->clearance && k->sides != RIC_SIDES_LOWER,
               lower = s < -k->clearance && k->sides != RIC_SIDES_UPPER;
    if (!upper && !lower) return 0;
    const double beyond = upper ? s - k->clearance : s + k->clearance;
    return k->law == RIC_LAW_RIGID ? copysign(INFINITY, beyond) : k->stiffness * beyond;
}

/* ------------------------------------------------------------------ sources */

static void name_curve(const picture *p, const plot_listed *keys, int n_key, int source,
                       int contact, curve *c)
{
    const cli_section *from = &p->sources[source];
    const ric_study *study = from->atlas ? ric_atlas_study(from->atlas) : from->study;
    const char *key = p->files.n > 1 ? ric_study_title(study) : "";
    char text[200] = "";
    for (int i = 0; i < n_key; i++)
        if ((keys[i].atlas > 0 ? keys[i].atlas : 0) == source) key = keys[i].text;
    if (c->contact.name && *c->contact.name) snprintf(text, sizeof text, "%.190s", c->contact.name);
    else snprintf(text, sizeof text, "contact %d", contact + 1);
    if (*key && ric_model_n_contact(from->model) == 1) *text = '\0';
    char whole[400];
    snprintf(whole, sizeof whole, "%.190s%s%s", key, *key && *text ? ", " : "", text);
    plot_text_escape(whole, sizeof c->key, c->key);
}

static int take_curves(picture *p, const plot_listed *keys, int n_key)
{
    for (int i = 0; i < p->files.n; i++) {
        const int code = cli_section_open(p->files.path[i], &p->sources[p->n_open++]);
        if (code != CLI_DONE) return code;
        const ric_model *model = p->sources[i].model;
        for (int k = 0; k < ric_model_n_contact(model); k++) {
            if (p->n == MAX_CURVE)
                return cli_wrong(
                    "plot law: more than %d contacts cannot be told apart in a picture; "
                    "give a study with those that matter",
                    MAX_CURVE);
            curve *c = &p->curves[p->n++];
            const ric_status status = ric_model_contact(model, k, &c->contact);
            if (status) return cli_report(status);
            c->unit = c->contact.law != RIC_LAW_POWER ? c->contact.clearance
                      : c->contact.length > 0         ? c->contact.length
                                                      : 1;
            name_curve(p, keys, n_key, i, k, c);
        }
    }
    if (p->n) return CLI_DONE;
    cli_say("ricochet: nothing to draw: the structure has no contact\n");
    return CLI_FAILED;
}

/* ------------------------------------------------------------------ drawing */

/* A panel for each kind of springs; rigid stops are in all, as their limit. */
static bool in_panel(const curve *c, ric_law law)
{
    return c->contact.law == law || c->contact.law == RIC_LAW_RIGID;
}

static void choose_panels(picture *p)
{
    bool has[LAWS] = {false};
    for (int i = 0; i < p->n; i++) has[p->curves[i].contact.law] = true;
    if (has[RIC_LAW_BILINEAR]) p->panels[p->n_panel++] = RIC_LAW_BILINEAR;
    if (has[RIC_LAW_POWER]) p->panels[p->n_panel++] = RIC_LAW_POWER;
    if (p->n_panel == 0) p->panels[p->n_panel++] = RIC_LAW_RIGID;
}

static plot_panel make_panel(const picture *p, ric_law law, plot_box box)
{
    double far = 0, high = INFINITY;
    for (int i = 0; i < p->n; i++) {
        const curve *c = &p->curves[i];
        if (!in_panel(c, law)) continue;
        far = fmax(far, reach * c->unit);
        const double f = fmax(force(c, top_at * c->unit), -force(c, -top_at * c->unit));
        if (isfinite(f)) high = fmin(high, f);
    }
    high = isfinite(high) ? high : 1;
    return (plot_panel){{.lo = -far, .hi = far, .from = box.left, .to = box.right},
                        {.lo = -high, .hi = high, .from = box.bottom, .to = box.top}};
}

static void draw_curve(picture *p, const plot_panel *panel, int i)
{
    const curve *c = &p->curves[i];
    plot_point line[SAMPLES + 1];
    double width = panel->x.hi - panel->x.lo;
    for (int k = 0; k <= SAMPLES; k++) {
        const double s = panel->x.lo + width * k / SAMPLES, f = force(c, s);
        line[k] = (plot_point){s, isfinite(f) ? f : copysign(2 * panel->y.hi, f)};
        if (!isfinite(f))
            line[k].x = copysign(c->contact.clearance, s); /* upright, at the stop itself */
    }
    plot_panel_curve(p->page, panel, PLOT_OVERLAY + (plot_stroke)i, SAMPLES + 1, line);
}

/* With the name that all studies give to the unit; what they call otherwise has none. */
static void unit_title(const picture *p, const char *what, bool force, size_t size, char *out)
{
    const char *name = "";
    for (int i = 0; i < p->n_open; i++) {
        const ric_units *units = ric_model_units(p->sources[i].model);
        const char *here = force ? units->force : units->length;
        if (i && strcmp(here, name)) name = "";
        else name = here;
        if (!*name) break;
    }
    snprintf(out, size, "%s", what);
    plot_append_unit(name, size, out);
}

static void draw_panel(picture *p, int i, plot_box box)
{
    const ric_law law = p->panels[i];
    const plot_panel panel = make_panel(p, law, box);
    char letter[8];
    plot_panel_curve(p->page, &panel, PLOT_GRID, 2,
                     (plot_point[]){{panel.x.lo, 0}, {panel.x.hi, 0}});
    for (int k = 0; k < p->n; k++)
        if (in_panel(&p->curves[k], law)) draw_curve(p, &panel, k);
    char across[80], up[80];
    unit_title(p, "gap coordinate s", false, sizeof across, across);
    unit_title(p, "force F(s) of the contact", true, sizeof up, up);
    plot_panel_frame(p->page, &panel, across, up);
    snprintf(letter, sizeof letter, "(%c)", 'a' + i);
    if (p->n_panel > 1)
        plot_page_text(p->page, (plot_point){box.left - 40, box.top + 15}, PLOT_LEFT, type + 1,
                       "#000000", false, letter);
}

static int draw(picture *p)
{
    const double width = plot_layout_width(p->common, PLOT_WIDTH),
                 height = plot_layout_height(p->common, p->n_panel > 1 ? 340 : 420),
                 head = plot_page_head(p->common, NULL) + (p->n_panel > 1 ? 18 : 0);
    plot_legend_entry entries[MAX_CURVE];
    for (int i = 0; i < p->n; i++)
        entries[i] = (plot_legend_entry){p->curves[i].key, PLOT_OVERLAY + i, -1};
    const double foot = plot_legend(NULL, p->n, entries, 12, width - 12, 0);
    p->page = plot_page_create(width, height);
    if (!p->page) return cli_report(RIC_E_NOMEM);
    for (int i = 0; i < p->n_panel; i++) {
        const double w = width / p->n_panel;
        draw_panel(p, i, (plot_box){w * i + 72, foot + 52, w * (i + 1) - 16, height - head});
    }
    plot_legend(p->page, p->n, entries, 12, width - 12, foot + 4);
    plot_page_title(p->page, p->common, NULL);
    return plot_page_write(p->page, p->common);
}

int plot_law(int argc, char **argv, const plot_options *common)
{
    picture p = {.common = common};
    plot_listed keys[MAX_CURVE];
    int n_key = 0, code = plot_take_listed(argc, argv, "--key", &p.files, MAX_CURVE, &n_key, keys);
    if (code == CLI_DONE && p.files.n > MAX_CURVE)
        code = cli_wrong("plot law: at most %d structures can be told apart", MAX_CURVE);
    if (code == CLI_DONE) code = take_curves(&p, keys, n_key);
    if (code == CLI_DONE) {
        choose_panels(&p);
        code = draw(&p);
    }
    plot_page_free(p.page);
    for (int i = 0; i < p.n_open; i++) cli_section_close(&p.sources[i]);
    return code;
}
