/* Sheets and stroboscopic diagrams: what many orbits along a part of a branch look like together.
 */
#define _POSIX_C_SOURCE 200809L

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "plot_sheet.h"

enum { SAMPLES = 500, MAX_STROBE = 240, MAX_START = 64 };
static const double type = 12, touch = 1e-9;

/* ------------------------------------------------------------------- orbits */

/* --segment [K:]SEGMENT */
static int take_parts(int argc, char **argv, sheet *s)
{
    plot_listed values[SHEET_PARTS];
    const int code = plot_take_listed(argc, argv, "--segment", &s->from, SHEET_PARTS, &s->n,
                                      values);
    for (int i = 0; i < s->n; i++)
        s->parts[i] = (sheet_part){.text = values[i].text,
                                   .atlas = values[i].atlas > 0 ? values[i].atlas : 0,
                                   .k = 1};
    if (code != CLI_DONE) return code;
    return s->n ? CLI_DONE
                : cli_wrong("--segment 'BRANCH|P1 P2' is missing; see ricochet plot --help");
}

static int keep(plot_motion *m, const ric_model *model, int letters, const int *word,
                const double *state, const double *flights)
{
    *m = (plot_motion){.model = model, .n = ric_model_n_dof(model), .tolerance = touch};
    if (!plot_motion_keep(m, letters, word, state, flights)) return cli_report(RIC_E_NOMEM);
    const ric_status status = plot_motion_make(m);
    return status == RIC_OK ? CLI_DONE : cli_report(status);
}

/* Energy at an arclength, between stored points. */
static double energy_at(const ric_atlas *atlas, const ric_branch *b, double s)
{
    ric_point p, q;
    for (int i = 1; i < b->n_point; i++) {
        if (ric_atlas_point(atlas, b->id, i - 1, &p, NULL, NULL) != RIC_OK ||
            ric_atlas_point(atlas, b->id, i, &q, NULL, NULL) != RIC_OK)
            break;
        if (q.arclength >= s && q.arclength > p.arclength)
            return p.energy +
                   (q.energy - p.energy) * fmax(0, s - p.arclength) / (q.arclength - p.arclength);
    }
    return b->n_point && ric_atlas_point(atlas, b->id, b->n_point - 1, &q, NULL, NULL) == RIC_OK
               ? q.energy
               : NAN;
}

/* The orbit next to arclength s: solved at the energy there; at a fold, where none may have it, a
 * stored one. */
static int orbit_near(const ric_atlas *atlas, const ric_branch *b, double s, plot_motion *out)
{
    const ric_model *model = ric_atlas_model(atlas);
    const size_t n = 2 * (size_t)ric_model_n_dof(model), letters = (size_t)b->letters + 1;
    double *state = calloc(n, sizeof *state), *flights = calloc(letters, sizeof *flights),
           best = INFINITY;
    int *word = calloc(letters, sizeof *word), found = 0, code = CLI_FAILED;
    ric_orbit **orbits = NULL;
    ric_point p;
    if (!state || !flights || !word) {
        code = cli_report(RIC_E_NOMEM);
        goto out;
    }
    if (ric_orbit_find(atlas, b->id, RIC_AT_ENERGY, energy_at(atlas, b, s), &found, &orbits) !=
        RIC_OK)
        found = 0;
    for (int i = 0; i < found; i++) {
        ric_orbit_data(orbits[i], &p, NULL, NULL, NULL);
        if (fabs(p.arclength - s) < best) {
            best = fabs(p.arclength - s);
            ric_orbit_data(orbits[i], NULL, state, flights, word);
        }
    }
    for (int i = 0; i < b->n_point; i++)
        if (ric_atlas_point(atlas, b->id, i, &p, NULL, NULL) == RIC_OK &&
            fabs(p.arclength - s) < best) {
            best = fabs(p.arclength - s);
            ric_atlas_point(atlas, b->id, i, NULL, state, flights);
            memcpy(word, b->word, (size_t)b->letters * sizeof *word);
        }
    code = keep(out, model, b->letters, word, state, flights);
out:
    ric_orbits_free(found, orbits);
    free(state);
    free(flights);
    free(word);
    return code;
}

static int load_part(const sheet *s, sheet_part *p)
{
    const ric_atlas *atlas = s->from.atlas[p->atlas];
    const char *named = strstr(p->text, ": "), *text = named ? named + 2 : p->text,
               *colon = strchr(text, ':');
    char first[16];
    long k = 1;
    ric_branch b;
    if (colon && (size_t)(colon - text) < sizeof first) {
        snprintf(first, sizeof first, "%.*s", (int)(colon - text), text);
        if (!cli_parse_integer(first, "--segment", 1, 1000, &k)) return CLI_WRONG;
    }
    p->k = (int)k;
    if (!plot_find_segment(atlas, colon ? colon + 1 : text, "--segment", &p->segment))
        return CLI_WRONG;
    const ric_status status = ric_atlas_branch(atlas, p->segment.branch, &b);
    if (status != RIC_OK) return cli_report(status);
    p->motions = calloc((size_t)s->orbits, sizeof *p->motions);
    p->energies = calloc((size_t)s->orbits, sizeof *p->energies);
    int code = p->motions && p->energies ? CLI_DONE : cli_report(RIC_E_NOMEM);
    for (int i = 0; code == CLI_DONE && i < s->orbits; i++) {
        const double way = (double)i / (double)(s->orbits - 1);
        const double at = p->segment.s[0] + way * (p->segment.s[1] - p->segment.s[0]);
        p->energies[p->n] = energy_at(atlas, &b, at);
        code = orbit_near(atlas, &b, at, &p->motions[p->n++]);
    }
    return code;
}

static int load(sheet *s)
{
    int code = plot_atlases_read(&s->from);
    for (int i = 0; code == CLI_DONE && i < s->n; i++) code = load_part(s, &s->parts[i]);
    return code;
}

static void release(sheet *s)
{
    for (int i = 0; i < s->n; i++) {
        for (int k = 0; k < s->parts[i].n; k++) plot_motion_free(&s->parts[i].motions[k]);
        free(s->parts[i].motions);
        free(s->parts[i].energies);
    }
    plot_atlases_free(&s->from);
    plot_page_free(s->page);
}

/* -------------------------------------------------------------------- sheet */

typedef struct {
    plot_box box;
    double depth_x, depth_y; /* shift of the rearmost curve, pixels */
    double lo, hi;           /* gap */
} slant;

static plot_point project(const slant *v, double time, double depth, double gap)
{
    return (plot_point){v->box.left + time * (v->box.right - v->box.left - v->depth_x) +
                            depth * v->depth_x,
                        v->box.bottom + depth * v->depth_y +
                            (gap - v->lo) / (v->hi - v->lo) *
                                (v->box.top - v->box.bottom - v->depth_y)};
}

/* One curve behind those drawn before: visible above and below what they cover (floating horizon).
 * high, low [width of the page] */
static void draw_hidden(plot_page *page, plot_stroke stroke, int n, const plot_point *curve,
                        double *high, double *low)
{
    const double width = plot_page_width(page), height = plot_page_height(page);
    const plot_panel pixels = {{.lo = 0, .hi = width, .from = 0, .to = width},
                               {.lo = 0, .hi = height, .from = 0, .to = height}};
    plot_point *seen = malloc((size_t)n * sizeof *seen);
    for (int i = 0; seen && i < n; i++) {
        const int column = (int)curve[i].x;
        seen[i] = curve[i].y >= high[column] || curve[i].y <= low[column] ? curve[i]
                                                                          : (plot_point){NAN, NAN};
    }
    if (seen) plot_panel_curve(page, &pixels, stroke, n, seen);
    free(seen);
    for (int i = 1; i < n; i++) /* every column between two samples is covered */
        for (int column = (int)curve[i - 1].x; column <= (int)curve[i].x; column++) {
            const double share = fmin(1, fmax(0, (column - curve[i - 1].x) /
                                                     fmax(1e-9, curve[i].x - curve[i - 1].x)));
            const double y = curve[i - 1].y + share * (curve[i].y - curve[i - 1].y);
            high[column] = fmax(high[column], y);
            low[column] = fmin(low[column], y);
        }
}

static void draw_box(plot_page *page, const slant *v, const plot_options *common, double lo,
                     double hi)
{
    const plot_point front = project(v, 0, 0, v->lo), right = project(v, 1, 0, v->lo),
                     back = project(v, 1, 1, v->lo), top = project(v, 0, 0, v->hi);
    char text[64];
    plot_page_line(page, PLOT_FRAME, 4, (plot_point[]){top, front, right, back});
    for (int i = 0; i <= 4; i++) {
        const plot_point at = project(v, i / 4., 0, v->lo);
        plot_page_line(page, PLOT_FRAME, 2, (plot_point[]){at, {at.x, at.y - 4}});
        snprintf(text, sizeof text, "%g", i / 4.);
        plot_page_text(page, (plot_point){at.x, at.y - 12}, PLOT_CENTRE, type, "#222222", false,
                       text);
    }
    double step = 1; /* clearances, so many that there are a few lines */
    for (int k = 0; (v->hi - v->lo) / step > 12 && step < DBL_MAX / 10; k++)
        step *= k % 3 == 1 ? 2.5 : 2; /* 1, 2, 5, 10, ... */
    for (double i = ceil(v->lo / step); i <= floor(v->hi / step); i++) {
        const plot_point at = project(v, 0, 0, i * step);
        plot_page_line(page, PLOT_FRAME, 2, (plot_point[]){at, {at.x - 4, at.y}});
        snprintf(text, sizeof text, "%s%.10g", i < 0 ? "\xe2\x88\x92" : "", fabs(i * step));
        plot_page_text(page, (plot_point){at.x - 8, at.y}, PLOT_RIGHT, type, "#222222", false,
                       text);
    }
    plot_page_text(page, (plot_point){(front.x + right.x) / 2, front.y - 29}, PLOT_CENTRE, type,
                   "#222222", false, "t / T");
    plot_page_text(page, (plot_point){front.x - 34, (front.y + top.y) / 2}, PLOT_CENTRE, type,
                   "#222222", true, "gap / clearance");
    snprintf(text, sizeof text, "%s = %.5g", common->hertz ? "f" : "ω", lo);
    plot_page_text(page, (plot_point){right.x + 8, right.y}, PLOT_LEFT, type, "#222222", false,
                   text);
    snprintf(text, sizeof text, "%s = %.5g", common->hertz ? "f" : "ω", hi);
    plot_page_text(page, (plot_point){back.x + 8, back.y}, PLOT_LEFT, type, "#222222", false, text);
}

void sheet_title(const sheet *s, int i, size_t size, char *out)
{
    const sheet_part *p = &s->parts[i];
    char name[200] = "";
    ric_branch b;
    const char *colon = strstr(p->text, ": ");
    if (colon) {
        char text[100];
        snprintf(text, sizeof text, "%.*s", (int)(colon - p->text < 99 ? colon - p->text : 99),
                 p->text);
        plot_text_label(text, sizeof name, name);
    } else if (ric_atlas_branch(s->from.atlas[p->atlas], p->segment.branch, &b) == RIC_OK) {
        plot_branch_title(&b, 1, sizeof name, name);
    }
    if (s->n > 1) snprintf(out, size, "(%c)  %s", 'a' + i % 26, name);
    else snprintf(out, size, "%s", name);
}

static int draw_sheet(sheet *s, const sheet_part *p, plot_box box, double *high, double *low)
{
    const int width = (int)plot_page_width(s->page);
    slant v = {box, 0.26 * (box.right - box.left), 0.42 * (box.top - box.bottom), -1, 1};
    plot_point *curve = malloc((SAMPLES + 1) * sizeof *curve);
    char title[400];
    if (!curve) return cli_report(RIC_E_NOMEM);
    for (int k = 0; k < p->n; k++)
        plot_motion_range(&p->motions[k], plot_read_gap, (int)s->contact - 1, &v.lo, &v.hi);
    for (int i = 0; i < width; i++) {
        high[i] = -INFINITY;
        low[i] = INFINITY;
    }
    for (int i = 0; i < p->n; i++) {
        const plot_motion *m = &p->motions[i];
        const double start = plot_motion_start(m, (int)s->contact - 1);
        for (int k = 0; k <= SAMPLES; k++)
            curve[k] = project(&v, (double)k / SAMPLES, p->n > 1 ? (double)i / (p->n - 1) : 0,
                               plot_motion_gap_at(m, (int)s->contact - 1,
                                                  start + m->period * k / SAMPLES));
        const bool edge = i == 0 || i == p->n - 1;
        draw_hidden(s->page, edge ? PLOT_SHEET + 1 : PLOT_SHEET, SAMPLES + 1, curve, high, low);
    }
    free(curve);
    const double turn = s->common->hertz ? 1 : 2 * CLI_PI;
    draw_box(s->page, &v, s->common, turn / p->motions[0].period,
             turn / p->motions[p->n - 1].period);
    sheet_title(s, (int)(p - s->parts), sizeof title, title);
    plot_page_text(s->page, (plot_point){(box.left + box.right) / 2, box.top + 12}, PLOT_CENTRE,
                   type, "#000000", false, title);
    return CLI_DONE;
}

static int draw_sheets(sheet *s)
{
    const int columns = s->n > 1 ? 2 : 1, rows = (s->n + columns - 1) / columns;
    const double width = plot_layout_width(s->common, PLOT_WIDTH),
                 height = plot_layout_height(s->common, 40 + 320 * rows);
    double *high = malloc((size_t)width * sizeof *high), *low = malloc((size_t)width * sizeof *low);
    int code = high && low && (s->page = plot_page_create(width, height)) ? CLI_DONE
                                                                          : cli_report(RIC_E_NOMEM);
    const double w = width / columns, h = (height - 40) / rows;
    for (int i = 0; code == CLI_DONE && i < s->n; i++) {
        const double left = w * (i % columns), top = height - 40 - h * (i / columns);
        code = draw_sheet(s, &s->parts[i],
                          (plot_box){left + 60, top - h + 56, left + w - 84, top - 30}, high, low);
    }
    free(high);
    free(low);
    if (code != CLI_DONE) return code;
    plot_page_title(s->page, s->common, NULL);
    return plot_page_write(s->page, s->common);
}

static bool common_contact(const sheet *s)
{
    for (int i = 0; i < s->from.n; i++)
        if (s->contact > ric_model_n_contact(ric_atlas_model(s->from.atlas[i]))) {
            cli_wrong("--contact %ld: the model has %d", s->contact,
                      ric_model_n_contact(ric_atlas_model(s->from.atlas[i])));
            return false;
        }
    return true;
}

int plot_sheet(int argc, char **argv, const plot_options *common)
{
    sheet s = {.common = common, .orbits = 25, .contact = 1};
    const char *orbits, *contact, *view;
    if (!cli_take_value(&argc, argv, "--orbits", &orbits) ||
        !cli_take_value(&argc, argv, "--contact", &contact) ||
        !cli_take_value(&argc, argv, "--space", &s.space) ||
        !cli_take_value(&argc, argv, "--view", &view) || !plot_parse_view(view, &s.view) ||
        (orbits && !cli_parse_integer(orbits, "--orbits", 2, 400, &s.orbits)) ||
        (contact && !cli_parse_integer(contact, "--contact", 1, 1000, &s.contact)))
        return CLI_WRONG;
    if (view && !s.space) return cli_wrong("--view %s: goes with --space", view);
    int code = take_parts(argc, argv, &s);
    if (code == CLI_DONE) code = load(&s);
    if (code == CLI_DONE && s.space) code = sheet_manifolds(&s);
    else if (code == CLI_DONE) code = common_contact(&s) ? draw_sheets(&s) : CLI_WRONG;
    release(&s);
    return code;
}

/* ------------------------------------------------------------------- strobe */

/* Instants at which a displacement passes 0, at most `room`; upwards and downwards, for the one may
 * become the other along a branch. */
static int crossings(const plot_motion *m, int dof, int room, double *out)
{
    int n = 0;
    double before = plot_motion_at(m, 0, dof);
    for (int i = 1; i <= 4 * SAMPLES && n < room; i++) {
        double a = m->period * (i - 1) / (4 * SAMPLES), b = m->period * i / (4 * SAMPLES);
        const double now = plot_motion_at(m, b, dof);
        const bool passed = (before <= 0) != (now <= 0);
        for (int k = 0; passed && k < 50; k++) {
            const double middle = (a + b) / 2;
            *((plot_motion_at(m, middle, dof) <= 0) == (now <= 0) ? &b : &a) = middle;
        }
        if (passed) out[n++] = b;
        before = now;
    }
    return n;
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void strobe_at(const sheet *s, const sheet_part *p, const plot_motion *m, double start,
                      double *x)
{
    for (int k = 0; k < s->samples; k++)
        x[k] = plot_motion_at(m, start + p->k * m->period * k / (double)s->samples,
                              (int)s->dof - 1);
}

typedef struct {
    double way, *x; /* x [samples] */
    int n_start;    /* crossings of zero: the samples may begin at any of them */
    double starts[MAX_START];
} column;

/* Sum of differences between two sets of samples, one by one or as sets. */
static double distance(const sheet *s, const double *a, const double *b, bool sets)
{
    const size_t count = (size_t)s->samples;
    double first[MAX_STROBE], second[MAX_STROBE], sum = 0;
    memcpy(first, a, count * sizeof *a);
    memcpy(second, b, count * sizeof *b);
    if (sets) {
        qsort(first, count, sizeof *first, ascending);
        qsort(second, count, sizeof *second, ascending);
    }
    for (size_t k = 0; k < count; k++) sum += fabs(first[k] - second[k]);
    return sum;
}

/* Samples of the orbits of a segment that begin at one crossing of the first orbit and go on with
 * the nearest in phase. Returns how far they go, the way from the segment before included: far
 * where the crossing vanishes. */
static double follow(const sheet *s, const sheet_part *p, column *columns, int first,
                     const double *last)
{
    double way = 0, phase = columns[0].starts[first] / p->motions[0].period;
    strobe_at(s, p, &p->motions[0], columns[0].starts[first], columns[0].x);
    if (last) way += distance(s, last, columns[0].x, true);
    for (int i = 1; i < p->n; i++) {
        int next = 0;
        for (int k = 1; k < columns[i].n_start; k++)
            if (fabs(remainder(columns[i].starts[k] / p->motions[i].period - phase, 1)) <
                fabs(remainder(columns[i].starts[next] / p->motions[i].period - phase, 1)))
                next = k;
        phase = columns[i].starts[next] / p->motions[i].period;
        strobe_at(s, p, &p->motions[i], columns[i].starts[next], columns[i].x);
        way += distance(s, columns[i - 1].x, columns[i].x, false);
    }
    return way;
}

/* Of several crossings of a multiplied orbit each gives other samples, and on the way crossings
 * vanish: the one is taken that goes least. */
static int fill_segment(const sheet *s, const sheet_part *p, column *columns, const double *last)
{
    int chosen = -1;
    double best = INFINITY;
    for (int i = 0; i < p->n; i++) {
        columns[i].n_start = crossings(&p->motions[i], (int)s->dof - 1, MAX_START,
                                       columns[i].starts);
        if (columns[i].n_start == 0)
            return cli_wrong("--dof %ld: this displacement does not pass 0 on %s", s->dof, p->text);
    }
    for (int k = 0; k < columns[0].n_start; k++) {
        const double way = follow(s, p, columns, k, last);
        if (way < best * (1 - 1e-9)) {
            best = way;
            chosen = k;
        }
    }
    follow(s, p, columns, chosen < 0 ? 0 : chosen, last);
    return CLI_DONE;
}

/* The frequency that a segment passes. */
static double passed(const sheet_part *p)
{
    double sum = 0;
    for (int k = 1; k < p->n; k++)
        sum += fabs(2 * CLI_PI / p->motions[k].period - 2 * CLI_PI / p->motions[k - 1].period);
    return sum / p->k;
}

static int make_columns(const sheet *s, column *columns)
{
    double way = 0;
    const double *last = NULL;
    for (int i = 0; i < s->n; columns += s->parts[i++].n) {
        const sheet_part *p = &s->parts[i];
        const int code = fill_segment(s, p, columns, last);
        if (code != CLI_DONE) return code;
        for (int k = 0; k < p->n; k++) {
            const double now = 2 * CLI_PI / p->motions[k].period,
                         before = k ? 2 * CLI_PI / p->motions[k - 1].period : now;
            way += fabs(now - before) / p->k / (s->stretch && passed(p) > 0 ? passed(p) : 1);
            columns[k].way = way;
        }
        last = columns[p->n - 1].x;
    }
    return CLI_DONE;
}

/* What stands above a segment: through how many periods it goes, and what it passes where the axis
 * does not say so. */
static void name_part(const sheet *s, const sheet_part *p, size_t size, char *out)
{
    const int used = snprintf(out, size, p->k > 1 ? "%d periods" : "%d period", p->k);
    const plot_units unit = plot_units_of(s->common, ric_atlas_model(s->from.atlas[0]));
    char way[64];
    plot_text_number(passed(p) * unit.frequency, 3, sizeof way, way);
    if (s->stretch && used > 0 && (size_t)used < size)
        snprintf(out + used, size - (size_t)used, ", %s %s", way,
                 s->common->hertz ? "Hz" : "rad/s");
}

static int draw_columns(sheet *s, int n, const column *columns)
{
    double lo = INFINITY, hi = -INFINITY;
    char text[64];
    plot_tag tags[SHEET_PARTS];
    plot_point *line = malloc(((size_t)s->orbits + 1) * sizeof *line);
    if (!line || !(s->page = plot_page_create(plot_layout_width(s->common, PLOT_WIDTH),
                                              plot_layout_height(s->common, 500)))) {
        free(line);
        return cli_report(RIC_E_NOMEM);
    }
    for (int i = 0; i < n; i++)
        for (int k = 0; k < s->samples; k++) {
            lo = fmin(lo, columns[i].x[k]);
            hi = fmax(hi, columns[i].x[k]);
        }
    plot_range_widen(false, 0.04, &lo, &hi);
    const double end = columns[n - 1].way > 0 ? 1.02 * columns[n - 1].way : 1;
    const plot_units unit = plot_units_of(s->common, ric_atlas_model(s->from.atlas[0]));
    plot_panel panel = {{.from = 82, .to = plot_page_width(s->page) - 24, .lo = 0, .hi = end},
                        {.from = 56,
                         .to = plot_page_height(s->page) - 26 - plot_page_head(s->common, NULL),
                         .lo = lo,
                         .hi = hi}};
    panel.x.unit = s->stretch ? 1 : unit.frequency;
    panel.y.unit = unit.length;
    for (int i = 0, at = 0; i < s->n; at += s->parts[i++].n) {
        const double x = plot_axis_at(&panel.x, columns[at].way);
        if (i > 0)
            plot_page_line(s->page, PLOT_NATURAL, 2,
                           (plot_point[]){{x, panel.y.from}, {x, panel.y.to}});
        for (int k = 0; k < s->samples; k++) {
            for (int j = 0; j < s->parts[i].n; j++)
                line[j] = (plot_point){columns[at + j].way, columns[at + j].x[k]};
            plot_panel_curve(s->page, &panel,
                             (i % 2 ? PLOT_ASYMMETRIC : PLOT_SYMMETRIC) + RIC_STABLE_NO,
                             s->parts[i].n, line);
        }
        plot_tag *tag = &tags[i];
        *tag = (plot_tag){.at = {x, panel.y.to + 12}, .weight = -i, .colour = "#000000"};
        name_part(s, &s->parts[i], sizeof tag->text, tag->text);
    }
    free(line);
    plot_place_tags(s->page,
                    (plot_box){panel.x.from - 30, panel.y.to + 4, panel.x.to, panel.y.to + 40},
                    s->n, tags, type);
    snprintf(text, sizeof text, "x_{%ld}(k T/%ld),  x_{%ld}(0) = 0", s->dof, s->samples, s->dof);
    if (s->common->physical)
        plot_append_unit(ric_model_units(ric_atlas_model(s->from.atlas[0]))->length, sizeof text,
                         text);
    plot_panel_frame(s->page, &panel,
                     s->stretch         ? "part of the frequency passed, for each segment"
                     : s->common->hertz ? "frequency passed on the way (Hz)"
                                        : "frequency passed on the way (rad/s)",
                     text);
    plot_page_title(s->page, s->common, NULL);
    return plot_page_write(s->page, s->common);
}

int plot_strobe(int argc, char **argv, const plot_options *common)
{
    sheet s = {.common = common, .orbits = 40, .samples = 24, .dof = 0};
    const char *orbits, *samples, *dof;
    s.stretch = cli_take_flag(&argc, argv, "--stretch");
    if (!cli_take_value(&argc, argv, "--orbits", &orbits) ||
        !cli_take_value(&argc, argv, "--samples", &samples) ||
        !cli_take_value(&argc, argv, "--dof", &dof) ||
        (orbits && !cli_parse_integer(orbits, "--orbits", 2, 400, &s.orbits)) ||
        (samples && !cli_parse_integer(samples, "--samples", 1, MAX_STROBE, &s.samples)) ||
        (dof && !cli_parse_integer(dof, "--dof", 1, 100000, &s.dof)))
        return CLI_WRONG;
    int code = take_parts(argc, argv, &s), n = 0;
    if (code == CLI_DONE && s.from.n != 1) code = cli_wrong("plot strobe: one atlas");
    if (code == CLI_DONE) code = load(&s);
    const int n_dof = code == CLI_DONE ? ric_model_n_dof(ric_atlas_model(s.from.atlas[0])) : 0;
    s.dof = s.dof ? s.dof : n_dof;
    if (code == CLI_DONE && s.dof > n_dof)
        code = cli_wrong("--dof %ld: there are displacements 1 to %d", s.dof, n_dof);
    for (int i = 0; i < s.n; i++) n += s.parts[i].n;
    column *columns = calloc((size_t)n + 1, sizeof *columns);
    double *x = calloc(((size_t)n + 1) * (size_t)s.samples, sizeof *x);
    for (int i = 0; columns && i < n; i++) columns[i].x = x + (size_t)i * (size_t)s.samples;
    if (code == CLI_DONE && (!columns || !x)) code = cli_report(RIC_E_NOMEM);
    if (code == CLI_DONE) code = make_columns(&s, columns);
    if (code == CLI_DONE) code = draw_columns(&s, n, columns);
    free(columns);
    free(x);
    release(&s);
    return code;
}
