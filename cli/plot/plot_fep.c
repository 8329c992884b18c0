/* The frequency-energy plot: windows, panels, legend. */
#define _POSIX_C_SOURCE 200809L

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "plot_fep.h"

static const double type = 12;

/* ------------------------------------------------------------------- labels */

plot_tag *fep_new_tag(fep *f)
{
    if (f->n_tag == f->room) {
        const int room = f->room ? 2 * f->room : 128;
        plot_tag *tags = realloc(f->tags, (size_t)room * sizeof *tags);
        if (!tags) return NULL;
        f->tags = tags;
        f->room = room;
    }
    f->tags[f->n_tag] = (plot_tag){.leader = true};
    return &f->tags[f->n_tag++];
}

bool fep_in_zoom(const fep *f, plot_point data)
{
    bool inside = false;
    for (int i = 1; f->panel == f->panels && i < f->n_panel; i++)
        inside = inside || plot_panel_inside(&f->panels[i], data);
    return inside;
}

bool fep_label_asked(fep *f, const fep_source *s, const char *name, int branch, int junction)
{
    bool found = false;
    for (int i = 0; i < f->options->n_asked; i++) {
        fep_asked *a = &f->options->asked[i];
        if (a->what != ASK_LABEL || a->atlas != s->index) continue;
        if (junction    ? a->junction == junction
            : a->branch ? a->branch == branch
                        : !a->junction && !strcmp(a->text, name))
            a->used = found = true;
    }
    return found;
}

/* A label asks for a junction, or for one branch among several of the same name: LABEL|P1 P2; else
 * for what bears it. */
static int resolve_labels(fep *f)
{
    for (int i = 0; i < f->options->n_asked; i++) {
        fep_asked *a = &f->options->asked[i];
        const ric_atlas *atlas = f->sources[a->atlas].atlas;
        plot_segment segment;
        if (a->what != ASK_LABEL) continue;
        if (!strpbrk(a->text, "|[") && !plot_is_branch(atlas, a->text)) {
            if (!plot_find_junction(atlas, a->text, "--label", &a->junction)) return CLI_WRONG;
        } else if (strchr(a->text, '|')) {
            if (!plot_find_segment(atlas, a->text, "--label", &segment)) return CLI_WRONG;
            a->branch = segment.branch;
        }
    }
    return CLI_DONE;
}

static void report_unused(const fep *f)
{
    for (int i = 0; i < f->options->n_asked; i++) {
        const fep_asked *a = &f->options->asked[i];
        if ((a->what == ASK_LABEL || a->what == ASK_MARK) && !a->used)
            cli_say("ricochet: %s %s: nothing of this name is in the picture\n",
                    fep_questions[a->what], a->text);
    }
}

/* --data: energies and frequencies of one's own, in the units of the picture. */
static int read_data(fep *f)
{
    static const char *const names[] = {"energy", "frequency"};
    const plot_units unit = plot_units_of(f->options->common, f->sources[0].model);
    if (!f->options->data) return CLI_DONE;
    const int code = plot_table_read(f->options->data, 2, names, 2, &f->data);
    for (int i = 0; code == CLI_DONE && i < f->data.n; i++) {
        double *p = f->data.values + 2 * i;
        if (p[0] < 0 || p[1] <= 0)
            return cli_wrong(
                "%s:%d: an energy from 0 on and a frequency above 0 are needed, as numbers",
                f->options->data, f->data.lines[i]);
        p[0] /= unit.energy;
        p[1] /= unit.frequency;
    }
    return code;
}

static plot_point data_at(const fep *f, int i)
{
    return (plot_point){plot_table_at(&f->data, i, 0), plot_table_at(&f->data, i, 1)};
}

/* ------------------------------------------------------------------- window */

/* A linear mode on which nothing happens is shown up to so many times beyond the frequencies at
 * which something does. */
#define NEIGHBOUR 1.5

typedef struct {
    double lo, hi;
} span;

static void span_add(span *s, double value)
{
    s->lo = fmin(s->lo, value);
    s->hi = fmax(s->hi, value);
}

static void span_join(span *s, span other)
{
    s->lo = fmin(s->lo, other.lo);
    s->hi = fmax(s->hi, other.hi);
}

/* Whether a value lies in a window that the user gave. */
static bool wanted(bool given, const double range[2], double value)
{
    return !given || (value >= range[0] && value <= range[1]);
}

/* What the axes must hold. Modes without impacts reach down to energy 0; only their upper end
 * counts. */
static ric_status add_part(const fep *f, const fep_source *s, const fep_part *part, span *energy,
                           span *frequency)
{
    const fep_options *o = f->options;
    ric_branch branch;
    ric_status status = ric_atlas_branch(s->atlas, part->branch, &branch);
    for (int i = 0; status == RIC_OK && i < branch.n_point; i++) {
        ric_point p;
        status = ric_atlas_point(s->atlas, part->branch, i, &p, NULL, NULL);
        if (status != RIC_OK || p.arclength < part->lo || p.arclength > part->hi ||
            !wanted(o->has_energy, o->energy, p.energy) ||
            !wanted(o->has_frequency, o->frequency, p.frequency / part->k))
            continue;
        span_add(frequency, p.frequency / part->k);
        if (p.energy > 0 &&
            (!ric_branch_linear(s->model, &branch) || o->has_energy || isfinite(part->lo)))
            span_add(energy, p.energy);
        else if (p.energy > 0 &&
                 p.energy >= branch.energy_max) { /* and enough of the line to be seen */
            span_add(energy, p.energy);
            span_add(energy, 0.6 * p.energy);
        }
    }
    return status;
}

static bool is_idle(const fep_source *s, const fep_part *part)
{
    ric_branch branch;
    return !ric_atlas_branch(s->atlas, part->branch, &branch) &&
           ric_branch_linear(s->model, &branch) && !branch.from && !branch.to &&
           branch.n_junction == 0;
}

static bool near_span(const span *s, double value)
{
    return value >= s->lo / NEIGHBOUR && value <= s->hi * NEIGHBOUR;
}

void fep_leave_out(fep *f, double lowest, double highest)
{
    f->n_idle++;
    f->idle[0] = f->n_idle == 1 ? lowest : fmin(f->idle[0], lowest);
    f->idle[1] = f->n_idle == 1 ? highest : fmax(f->idle[1], highest);
}

/* Of a structure of many modes most are idle, and would press what happens to the foot of the
 * picture: those far from it are left out where no window was given. */
static ric_status find_window(fep *f, span *energy, span *frequency)
{
    ric_status status = RIC_OK;
    *energy = *frequency = (span){INFINITY, -INFINITY};
    for (int idle = 0; idle < 2; idle++) {
        const span lively = *frequency;
        for (int k = 0; k < f->n_source; k++)
            for (int i = 0; status == RIC_OK && i < f->sources[k].n_part; i++) {
                fep_source *s = &f->sources[k];
                span e = {INFINITY, -INFINITY}, w = e;
                if (!idle) s->parts[i].idle = is_idle(s, &s->parts[i]);
                if (s->parts[i].idle != idle) continue;
                status = add_part(f, s, &s->parts[i], &e, &w);
                if (status != RIC_OK || !(w.hi >= w.lo)) continue;
                if (idle && lively.hi >= lively.lo &&
                    !(near_span(&lively, w.lo) && near_span(&lively, w.hi))) {
                    fep_leave_out(f, w.lo, w.hi);
                    continue;
                }
                span_join(energy, e);
                span_join(frequency, w);
            }
    }
    for (int i = 0; i < f->data.n; i++) {
        const plot_point p = data_at(f, i);
        if (!wanted(f->options->has_energy, f->options->energy, p.x) ||
            !wanted(f->options->has_frequency, f->options->frequency, p.y))
            continue;
        if (p.x > 0) span_add(energy, p.x);
        span_add(frequency, p.y);
    }
    return status;
}

static plot_units units_of(const fep *f)
{
    return plot_units_of(f->options->common, f->sources[0].model);
}

/* Windows are given in the units of the picture. */
static void scale_windows(fep *f)
{
    fep_options *o = f->options;
    const plot_units unit = units_of(f);
    for (int i = 0; i < 2; i++) {
        o->energy[i] /= unit.energy;
        o->frequency[i] /= unit.frequency;
        for (int k = 0; k < o->n_frame; k++) {
            o->frame[k][i] /= unit.energy;
            o->frame[k][2 + i] /= unit.frequency;
        }
        for (int k = 0; k < o->n_zoom; k++) {
            o->zoom[k][i] /= unit.energy;
            o->zoom[k][2 + i] /= unit.frequency;
        }
    }
    o->knee /= unit.frequency;
}

/* Zooms have the scale of the frequencies that was asked for, or are linear. */
static void set_zooms(fep *f)
{
    const fep_options *o = f->options;
    f->n_panel = 1 + o->n_zoom;
    for (int i = 1; i < f->n_panel; i++) {
        const double *zoom = o->zoom[i - 1];
        const bool log = fep_log_window(o, zoom[0], zoom[1]);
        f->panels[i].x = (plot_axis){.scale = log ? PLOT_SCALE_LOG : PLOT_SCALE_LINEAR,
                                     .lo = zoom[0],
                                     .hi = zoom[1],
                                     .unit = f->panels[0].x.unit};
        f->panels[i].y = (plot_axis){.scale = o->log_frequency ? PLOT_SCALE_LOG : PLOT_SCALE_LINEAR,
                                     .lo = zoom[2],
                                     .hi = zoom[3],
                                     .unit = f->panels[0].y.unit};
    }
}

/* A margin around what was found, where no window was given. */
static void widen_axes(const fep *f, plot_axis *x, plot_axis *y)
{
    const fep_options *o = f->options;
    const double lowest = y->lo;
    if (!o->has_energy) {
        plot_range_widen(x->scale == PLOT_SCALE_LOG, 0.06, &x->lo, &x->hi);
        if (x->scale == PLOT_SCALE_LINEAR) x->lo = o->linear ? 0 : fmax(0, x->lo);
    }
    if (o->has_frequency) return;
    if (y->scale == PLOT_SCALE_CUT) { /* by the pieces at its ends */
        y->lo = fmax(0, y->lo - 0.08 * (y->cut[0].lo - y->lo));
        y->hi += 0.08 * (y->hi - y->cut[y->n_cut - 1].hi);
        return;
    }
    plot_range_widen(y->scale == PLOT_SCALE_LOG, 0.06, &y->lo, &y->hi);
    if (y->scale == PLOT_SCALE_BROKEN) /* the margin below goes with the linear part only */
        y->lo = lowest - fmin(lowest - y->lo, 0.08 * fmax(0, y->knee - lowest));
    if (y->scale != PLOT_SCALE_LOG) y->lo = fmax(0, y->lo);
}

static ric_status set_axes(fep *f, span energy, span frequency)
{
    const fep_options *o = f->options;
    plot_axis *x = &f->panels[0].x, *y = &f->panels[0].y;
    x->lo = o->has_energy ? o->energy[0] : energy.lo;
    x->hi = o->has_energy ? o->energy[1] : energy.hi;
    y->lo = o->has_frequency ? o->frequency[0] : frequency.lo;
    y->hi = o->has_frequency ? o->frequency[1] : frequency.hi;
    y->scale = o->has_break       ? PLOT_SCALE_BROKEN
               : o->log_frequency ? PLOT_SCALE_LOG
                                  : PLOT_SCALE_LINEAR;
    y->knee = o->knee;
    const plot_units unit = units_of(f);
    x->unit = unit.energy;
    y->unit = unit.frequency;
    const ric_status status = fep_choose_scales(f);
    widen_axes(f, x, y);
    set_zooms(f);
    return status;
}

/* ----------------------------------------------------------------- the page */

static void count_unmarked(fep *f)
{
    snprintf(f->remark, sizeof f->remark, "%d more junction%s not marked", f->unmarked,
             f->unmarked == 1 ? "" : "s");
}

/* What dashes say: of several atlases in the colour of the first, else of each kind of branches. */
static int dashed_entries(const fep *f, unsigned dashed, plot_legend_entry *out)
{
    static const char *const texts[] = {"duplicate of a linear mode", "duplicate, asymmetric",
                                        "duplicate, symmetric"};
    const int thick = dashed & 1u << RIC_STABLE_YES ? RIC_STABLE_YES : RIC_STABLE_NO;
    int n = 0;
    if (!dashed) return 0;
    if (f->n_source > 1) {
        out[n++] = (plot_legend_entry){"dashed: duplicate", PLOT_ATLAS - PLOT_DASHED + thick, -1};
        return n;
    }
    for (int i = 2; i >= 0; i--)
        if (f->duplicate[i])
            out[n++] = (plot_legend_entry){texts[i], PLOT_DUPLICATE + 3 * i + thick, -1};
    return n;
}

/* Whether something is drawn in the colour of source i, which is the first to have it. */
static bool drawn_in(const fep *f, int i)
{
    bool drawn = false;
    for (int k = i; k < f->n_source; k++) drawn |= f->sources[k].tint == i && f->sources[k].drawn;
    return drawn;
}

/* "proved", of one atlas with how much of it. */
static const char *count_proofs(fep *f)
{
    cli_proofs p;
    if (f->n_source > 1 || !cli_count_proofs(f->sources[0].atlas, &p)) return "proved";
    const int n = snprintf(f->proofs, sizeof f->proofs, "proved: ");
    cli_write_proofs(&p, f->proofs + n, sizeof f->proofs - (size_t)n);
    return f->proofs;
}

static int legend_entries(fep *f, plot_legend_entry *out)
{
    unsigned stability = 0, dashed = 0;
    int n = 0;
    for (int i = 0; i < f->n_source; i++) {
        stability |= f->sources[i].stability;
        dashed |= f->sources[i].dashed;
    }
    if (f->n_source > 1) {
        for (int i = 0; i < f->n_source; i++)
            if (drawn_in(f, i))
                out[n++] = (plot_legend_entry){f->sources[i].key,
                                               PLOT_ATLAS + 3 * i + RIC_STABLE_YES, -1};
        if ((stability | dashed) & 1u << RIC_STABLE_NO)
            out[n++] = (plot_legend_entry){"thin: unstable", PLOT_ATLAS + RIC_STABLE_NO, -1};
        if (stability & 1u << RIC_STABLE_UNDECIDED)
            out[n++] = (plot_legend_entry){"dotted: undecided", PLOT_ATLAS + RIC_STABLE_UNDECIDED,
                                           -1};
    } else {
        n = plot_legend_entries(f->family, stability ? stability : dashed, NULL, out);
    }
    n += dashed_entries(f, dashed, out + n);
    if (f->ghost) out[n++] = (plot_legend_entry){"ghost: no motion", PLOT_GHOST, -1};
    if (f->island)
        out[n++] = (plot_legend_entry){"island: linked to no linear mode", PLOT_ISLAND, -1};
    if (f->arrow) out[n++] = (plot_legend_entry){"inherited", PLOT_ARROW, -1};
    if (f->proved) out[n++] = (plot_legend_entry){count_proofs(f), PLOT_PROOF, -1};
    if (f->natural) out[n++] = (plot_legend_entry){"natural frequency", PLOT_NATURAL, -1};
    if (f->locked) out[n++] = (plot_legend_entry){"contact locked", PLOT_LOCKED, -1};
    if (f->data.n) out[n++] = (plot_legend_entry){f->data.name, PLOT_DATA, -1};
    n += plot_legend_entries(NULL, 0, f->kinds, out + n);
    count_unmarked(f);
    if (f->unmarked) out[n++] = (plot_legend_entry){f->remark, -1, -1};
    return n;
}

/* How many panels stand side by side: two, but one above the other on a page that is higher than
 * wide. */
static int columns_of(const fep *f)
{
    return f->n_panel == 1 ||
                   (f->n_panel == 2 && plot_page_height(f->page) > plot_page_width(f->page))
               ? 1
               : 2;
}

/* What numbers and title beside the frequencies need. */
static double left_margin(fep *f)
{
    double widest = 0;
    for (int i = 0; i < f->n_panel; i++) {
        f->panels[i].y.from = 0;
        f->panels[i].y.to = 250;
        widest = fmax(widest, plot_axis_widest(&f->panels[i].y));
    }
    return fmax(68, widest + 34);
}

/* Frames of the panels: an odd one comes first and is as wide as the page. */
static void lay_out(fep *f, double legend)
{
    const int n = f->n_panel, columns = columns_of(f), wide = columns == 2 && n % 2;
    const double width = plot_page_width(f->page), left = left_margin(f), right = 44, foot = 50,
                 head = plot_page_head(f->options->common, NULL) + (n > 1 ? 20 : 0);
    const int rows = (n + wide + columns - 1) / columns;
    const double w = width / columns, h = (plot_page_height(f->page) - head - legend) / rows;
    for (int i = 0; i < n; i++) {
        const int place = i ? i + wide : 0, column = place % columns, row = place / columns;
        f->panels[i].x.from = column * w + left;
        f->panels[i].x.to = (wide && i == 0 ? width : (column + 1) * w) - right;
        f->panels[i].y.from = legend + (rows - 1 - row) * h + foot;
        f->panels[i].y.to = legend + (rows - row) * h - (row ? 26 : 0);
    }
}

/* Of a page that nobody gave a height: each row of panels has as much as a reader needs. */
static double usual_height(int n)
{
    static const double of_panels[FEP_MAX_PANEL] = {500, 380, 760, 720, 1040, 1040};
    return of_panels[n - 1];
}

/* What panel i is called: its letter in brackets, or nothing if --letters has none for it. */
static void panel_letter(const fep *f, int i, size_t size, char *out)
{
    const char *text = f->options->letters;
    out[0] = '\0';
    if (!text) {
        snprintf(out, size, "(%c)", 'a' + i);
        return;
    }
    for (; i > 0 && *text; text++) i -= *text == ',';
    const int length = (int)strcspn(text, ",");
    if (i == 0 && length > 0) snprintf(out, size, "(%.*s)", length, text);
}

/* pixels */
#define FRAME_LEAST 15
/* Room around lines in a frame: narrower windows are framed as if they had it, as a frame would
 * hide what it shows. */
static void widen(double *from, double *to)
{
    const double missing = fmax(0, FRAME_LEAST - (*to - *from)) / 2;
    *from -= missing;
    *to += missing;
}

/* A window in a panel, with what it is called. */
static void draw_window(fep *f, const double window[4], const char *name)
{
    const plot_box box = plot_panel_box(f->panel);
    plot_point a = plot_panel_at(f->panel, (plot_point){window[0], window[2]}),
               b = plot_panel_at(f->panel, (plot_point){window[1], window[3]});
    widen(&a.x, &b.x);
    widen(&a.y, &b.y);
    a = (plot_point){fmax(a.x, box.left), fmax(a.y, box.bottom)};
    b = (plot_point){fmin(b.x, box.right), fmin(b.y, box.top)};
    if (a.x >= b.x || a.y >= b.y) return;
    plot_page_line(f->page, PLOT_ZOOM, 5,
                   (plot_point[]){{a.x, a.y}, {b.x, a.y}, {b.x, b.y}, {a.x, b.y}, {a.x, a.y}});
    const plot_point corners[] = {b, {a.x, b.y}, {b.x, a.y}, a};
    const int group = ++f->n_group;
    for (int i = 0; *name && i < 4; i++) {
        plot_tag *tag = fep_new_tag(f);
        if (!tag) return;
        tag->at = corners[i];
        tag->clear = 1;
        tag->group = group;
        tag->weight = 3000 - i;
        tag->colour = plot_stroke_colour(PLOT_ZOOM);
        plot_text_escape(name, sizeof tag->text, tag->text);
    }
}

/* Those of the other panels, and those that were asked for. */
static void draw_windows(fep *f)
{
    const fep_options *o = f->options;
    for (int k = 1; k < f->n_panel; k++) {
        const plot_panel *zoom = &f->panels[k];
        const double window[4] = {zoom->x.lo, zoom->x.hi, zoom->y.lo, zoom->y.hi};
        char letter[24];
        panel_letter(f, k, sizeof letter, letter);
        draw_window(f, window, letter);
    }
    for (int k = 0; k < o->n_frame; k++) {
        char name[64] = "";
        const char *text = o->frame_name[k];
        if (text) snprintf(name, sizeof name, "%.*s", (int)(strstr(text, ": ") - text), text);
        draw_window(f, o->frame[k], name);
    }
}

static int draw_panel(fep *f, int i)
{
    f->panel = &f->panels[i];
    ric_status status = fep_draw_references(f, &f->sources[0]);
    for (int k = 0; status == RIC_OK && k < f->n_source; k++)
        status = fep_draw_branches(f, &f->sources[k]);
    for (int k = 0; status == RIC_OK && k < f->n_source; k++)
        status = fep_draw_ghosts(f, &f->sources[k]);
    for (int k = 0; status == RIC_OK && k < f->n_source; k++)
        status = fep_draw_junctions(f, &f->sources[k]);
    if (i == 0) draw_windows(f);
    for (int k = 0; k < f->data.n; k++) plot_panel_dot(f->page, f->panel, PLOT_DATA, data_at(f, k));
    int code = status == RIC_OK ? CLI_DONE : cli_report(status);
    for (int k = 0; code == CLI_DONE && k < f->n_source; k++)
        code = fep_draw_marks(f, &f->sources[k]);
    return code;
}

/* Frame and titles of a panel; a scale that the program chose is named. */
static void frame(const fep *f)
{
    const fep_options *o = f->options;
    const plot_axis *x = &f->panel->x, *y = &f->panel->y;
    const bool room = y->to - y->from > 300;
    char energy[80], letters[60], frequency[80], knee[40] = "";
    const ric_model *models[FEP_MAX_ATLAS];
    for (int i = 0; i < f->n_source; i++) models[i] = f->sources[i].model;
    plot_energy_title(o->common, f->n_source, models, sizeof letters, letters);
    if (y->scale == PLOT_SCALE_BROKEN && room)
        snprintf(knee, sizeof knee, ", logarithmic above %.4g", y->knee * y->unit);
    snprintf(energy, sizeof energy, "%s%s", letters,
             x->scale == PLOT_SCALE_LOG && !o->log_energy ? ", logarithmic" : "");
    snprintf(frequency, sizeof frequency, "%s%s%s", plot_frequency_title(o->common), knee,
             y->scale == PLOT_SCALE_LOG && !o->log_frequency ? ", logarithmic" : "");
    plot_panel_frame(f->page, f->panel, energy, frequency);
}

/* All panels, with `legend` pixels left free at the foot; labels only where `final`. Adds to
 * *missing the labels without a place. */
static int draw_panels(fep *f, double legend, bool final, int *missing)
{
    const plot_options *common = f->options->common;
    const double width = plot_layout_width(common, PLOT_WIDTH),
                 height = plot_layout_height(common, usual_height(f->n_panel));
    int code = CLI_DONE;
    plot_page_free(f->page);
    f->page = plot_page_create(width, height);
    if (!f->page) return cli_report(RIC_E_NOMEM);
    lay_out(f, legend);
    f->no_margin = f->unmarked = 0;
    for (int i = 0; i < f->n_panel && code == CLI_DONE; i++) {
        char letter[24], name[48];
        f->n_tag = f->n_group = 0;
        code = draw_panel(f, i);
        if (code != CLI_DONE || !final) continue;
        panel_letter(f, i, sizeof letter, letter);
        plot_text_escape(letter, sizeof name, name);
        frame(f);
        if (f->n_panel > 1 && *letter)
            plot_page_text(f->page, (plot_point){f->panel->x.from - 50, f->panel->y.to + 17},
                           PLOT_LEFT, type + 1, "#000000", false, name);
        *missing += plot_place_tags(f->page, plot_panel_box(f->panel), f->n_tag, f->tags, type);
    }
    return code;
}

/* Linear modes that are not shown. */
static void report_idle(const fep *f)
{
    const double unit = f->panels[0].y.unit;
    const double low = f->idle[0] * unit, high = f->idle[1] * unit;
    const bool one = f->n_idle == 1;
    char where[64];
    if (f->n_idle == 0 || f->options->has_frequency) return;
    if (one) snprintf(where, sizeof where, "%g", low);
    else snprintf(where, sizeof where, "%g to %g", low, high);
    cli_say("ricochet: %d linear mode%s no contact in the windows and %s not shown, at %s %s; "
            "--frequency shows %s\n",
            f->n_idle, one ? " touches" : "s touch", one ? "is" : "are", where,
            f->options->common->hertz ? "Hz" : "rad/s", one ? "it" : "them");
}

static int draw(fep *f)
{
    const plot_options *common = f->options->common;
    plot_legend_entry entries[PLOT_MAX_LEGEND];
    int missing = 0,
        code = draw_panels(f, 0, false,
                           &missing); /* what the legend needs is known once the data are drawn */
    if (code != CLI_DONE) return code;
    const int n_entry = legend_entries(f, entries);
    const double legend = plot_legend(NULL, n_entry, entries, 12, plot_page_width(f->page) - 12, 0);
    code = draw_panels(f, legend, true, &missing);
    if (code != CLI_DONE) return code;
    missing += f->no_margin;
    count_unmarked(f); /* again: the legend has made the panels lower */
    if (missing > 0)
        cli_say("ricochet: %d label%s left out for want of room; --energy, --frequency or --size "
                "make more\n",
                missing, missing == 1 ? "" : "s");
    if (f->unmarked > 0)
        cli_say("ricochet: %d junction%s not marked, which would hide the curve; --marks "
                "all draws %s, "
                "--zoom and --energy make room\n",
                f->unmarked, f->unmarked == 1 ? " is" : "s are", f->unmarked == 1 ? "it" : "them");
    if (f->no_locked > 0)
        cli_say(
            "ricochet: %d frequencies with a contact locked are not drawn, which would hide the "
            "branches; `ricochet check` lists them\n",
            f->no_locked);
    report_idle(f);
    report_unused(f);
    plot_page_title(f->page, common, NULL);
    plot_legend(f->page, n_entry, entries, 12, plot_page_width(f->page) - 12, legend + 4);
    return plot_page_write(f->page, common);
}

static int draw_page(fep *f)
{
    span energy, frequency;
    int total = 0;
    const double unit = plot_units_of(f->options->common, f->sources[0].model).energy;
    if (isnan(unit))
        return cli_wrong("plot fep: --physical: no double holds the square of the clearance, by "
                         "which energies go; leave it out");
    ric_status status = find_window(f, &energy, &frequency);
    if (status != RIC_OK) return cli_report(status);
    for (int i = 0; i < f->n_source; i++) total += ric_atlas_n_branch(f->sources[i].atlas);
    if (!(energy.hi > 0) || !(frequency.hi > 0)) {
        cli_say("ricochet: nothing to draw: %s\n", total
                                                       ? "no branch of the atlas enters this window"
                                                       : "the atlas has no branches yet");
        return CLI_FAILED;
    }
    if ((status = set_axes(f, energy, frequency)) != RIC_OK) return cli_report(status);
    const plot_axis *y = &f->panels[0].y;
    if (f->options->has_break && !(f->options->knee > y->lo && f->options->knee < y->hi))
        return cli_wrong("--break %g: must lie inside the frequencies shown, %g to %g",
                         f->options->knee * y->unit, y->lo * y->unit, y->hi * y->unit);
    for (int i = 0; i < f->n_source && status == RIC_OK && f->options->ghosts; i++)
        status = fep_find_ghosts(f, &f->sources[i]);
    return status == RIC_OK ? draw(f) : cli_report(status);
}

/* What --key calls an atlas, NULL if nothing does. */
static const char *key_of(const fep *f, int source)
{
    const char *key = NULL;
    for (int i = 0; i < f->options->n_asked; i++)
        if (f->options->asked[i].what == ASK_KEY && f->options->asked[i].atlas == source)
            key = f->options->asked[i].text;
    return key;
}

/* Its key, else the title of its study; and its colour, which those share that were given the same
 * key. */
static void set_key(const fep *f, fep_source *s)
{
    const char *key = key_of(f, s->index);
    plot_text_escape(key ? key : ric_study_title(ric_atlas_study(s->atlas)), sizeof s->key, s->key);
    for (s->tint = 0; s->tint < s->index; s->tint++) {
        const char *other = key_of(f, s->tint);
        if (key && other && !strcmp(key, other)) return;
    }
}

static int open_sources(fep *f)
{
    int code = CLI_DONE;
    for (int i = 0; code == CLI_DONE && i < f->options->n_atlas; i++) {
        fep_source *s = &f->sources[f->n_source++];
        s->index = i;
        const ric_status status = ric_atlas_read(f->options->paths[i], &s->atlas);
        if (status != RIC_OK) return cli_report(status);
        s->model = ric_atlas_model(s->atlas);
        set_key(f, s);
        code = fep_choose_parts(f, s);
    }
    return code;
}

int plot_fep(int argc, char **argv, const plot_options *common)
{
    fep_options options = {.common = common};
    fep f = {.options = &options};
    int code = fep_parse_options(&argc, argv, &options);
    if (code != CLI_DONE) return code;
    code = open_sources(&f);
    ric_atlas *atlases[FEP_MAX_ATLAS] = {NULL};
    for (int i = 0; i < f.n_source; i++) atlases[i] = f.sources[i].atlas;
    if (code == CLI_DONE && !plot_same_length(common, f.n_source, atlases)) code = CLI_WRONG;
    if (code == CLI_DONE) scale_windows(&f);
    if (code == CLI_DONE) code = read_data(&f);
    if (code == CLI_DONE) code = resolve_labels(&f);
    if (code == CLI_DONE) code = draw_page(&f);
    plot_page_free(f.page);
    for (int i = 0; i < f.n_source; i++) fep_free_source(&f.sources[i]);
    free(f.tags);
    plot_table_free(&f.data);
    return code;
}
