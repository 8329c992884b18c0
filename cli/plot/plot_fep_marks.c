/* Marks of the frequency-energy picture: junctions, orbits that were asked for, reference lines. */
#define _POSIX_C_SOURCE 200809L

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "plot_fep.h"

static const double type = 12;

/* ---------------------------------------------------------------- junctions */

/* Whether a part that is shown passes a junction in one of two roles: as a branch that has it on
 * its way or leaves it, or as the k-duplicate of the branch that is multiplied at it. */
static bool part_meets(const fep_source *s, const fep_part *part, const ric_junction *junction,
                       bool multiplied, int k)
{
    bool listed = false;
    ric_branch branch;
    for (int i = 0; i < junction->n_branch; i++) listed |= junction->branches[i] == part->branch;
    if (!listed || part->k != k || ric_atlas_branch(s->atlas, part->branch, &branch) != RIC_OK ||
        (ric_junction_level(junction, &branch) > 1) != multiplied)
        return false;
    const double at = plot_junction_at(s->atlas, &branch, junction->id),
                 slack = 1e-9 * (1 + fabs(at));
    return at >= part->lo - slack && at <= part->hi + slack;
}

static bool shown(const fep_source *s, const ric_junction *junction, bool multiplied, int k)
{
    for (int i = 0; i < s->n_part; i++)
        if (part_meets(s, &s->parts[i], junction, multiplied, k)) return true;
    return false;
}

/* Where the mark stands; NaN if none of its branches is shown. A q-tupling belongs at omega / q,
 * among the branches that leave it or on the q-duplicate of the one that is multiplied; where
 * neither is drawn, nor any duplicate, it is shown on that one. */
static plot_point junction_place(const fep *f, const fep_source *s, const ric_junction *junction)
{
    double frequency = NAN;
    if (shown(s, junction, false, 1) ||
        (junction->multiple > 1 && shown(s, junction, true, junction->multiple)))
        frequency = junction->frequency;
    else if (junction->multiple > 1 && f->options->duplicates == 1 && !f->options->n_duplicate &&
             shown(s, junction, true, 1))
        frequency = junction->frequency * junction->multiple;
    return (plot_point){junction->energy, frequency};
}

/* What a reader looks for first: names of the study, then where branches part, near the start, of
 * few impacts. */
static double junction_weight(const fep_source *s, const ric_junction *junction)
{
    static const double of_kind[] = {
        [RIC_KIND_START] = -20,         [RIC_KIND_GRAZING] = 30,
        [RIC_KIND_CORNER] = 30,         [RIC_KIND_EXTREMUM] = 12,
        [RIC_KIND_BRANCH_POINT] = 36,   [RIC_KIND_MULTIPLICATION] = 30,
        [RIC_KIND_PERIOD_EXTREMUM] = 4, [RIC_KIND_USER] = 50,
    };
    int depth = 100, symmetric = 0;
    for (int i = 0; i < junction->n_branch; i++) {
        ric_branch branch;
        if (ric_atlas_branch(s->atlas, junction->branches[i], &branch) != RIC_OK) continue;
        depth = branch.depth < depth ? branch.depth : depth;
        symmetric |= branch.symmetric;
    }
    return of_kind[junction->kind] + 1000 * (junction->name && *junction->name) + 6 * symmetric -
           4 * fmin(depth, 10) + 8 * (junction->departures.taken > 0) - 0.4 * junction->impacts;
}

typedef struct {
    plot_point at; /* pixels */
    ric_kind kind;
    double weight;
    int id, n_branch;
    const int *branches;
    bool named, asked, drawn; /* the first two: however crowded its place is */
    bool elsewhere;           /* has its label in another panel */
} spot;

static int lighter(const void *a, const void *b)
{
    const spot *s = a, *t = b;
    return s->weight != t->weight ? (s->weight > t->weight) - (s->weight < t->weight)
                                  : t->id - s->id;
}

static bool labelled(fep *f, const spot *s, int rank)
{
    if (s->asked) return true;
    switch (f->options->labels) {
    case LABELS_NONE:
    case LABELS_ASKED: return false;
    case LABELS_NAMED: return s->named;
    case LABELS_ALL: return true;
    case LABELS_MAIN: break;
    }
    /* As many as a reader can take in: one for a square of 120 pixels. */
    const plot_box box = plot_panel_box(f->panel);
    return s->named ||
           (s->weight > 10 && rank < (box.right - box.left) * (box.top - box.bottom) / (120 * 120));
}

static bool share_branch(const spot *s, const spot *t)
{
    for (int i = 0; i < s->n_branch; i++)
        for (int k = 0; k < t->n_branch; k++)
            if (s->branches[i] == t->branches[k]) return true;
    return false;
}

/* Which marks are drawn: the heaviest first, and no more on any piece of a curve than leave it
 * visible. */
static int thin_spots(fep *f, int n, spot *spots)
{
    enum { NEAR = 24, MOST = 3 }; /* pixels along a curve to either side, marks there */
    int drawn = 0;
    for (int i = n - 1; i >= 0; i--) {
        int near = 0;
        bool fits = f->options->marks < MARKS_ASKED;
        for (int k = n - 1; k > i && fits && f->options->marks == MARKS_MAIN; k--)
            if (spots[k].drawn &&
                hypot(spots[i].at.x - spots[k].at.x, spots[i].at.y - spots[k].at.y) < NEAR &&
                share_branch(&spots[i], &spots[k]))
                fits = ++near < MOST;
        spots[i].drawn = fits || (spots[i].named && f->options->marks != MARKS_ASKED) ||
                         spots[i].asked;
        drawn += spots[i].drawn;
        if (f->panel == f->panels && f->options->marks == MARKS_MAIN)
            f->unmarked += !spots[i].drawn && !spots[i].elsewhere;
    }
    return drawn;
}

static void draw_spots(fep *f, const fep_source *s, int n, spot *spots)
{
    const int drawn = thin_spots(f, n, spots);
    const double large = 3.8, small = drawn > 150 ? 2 : 2.6;
    for (int i = 0, rank = drawn; i < n; i++) { /* the heaviest last, on top */
        ric_junction junction;
        if (!spots[i].drawn || ric_atlas_junction(s->atlas, spots[i].id, &junction) != RIC_OK)
            continue;
        rank--;
        plot_tag *tag = !spots[i].elsewhere && labelled(f, &spots[i], rank) ? fep_new_tag(f) : NULL;
        const double radius = drawn < 40 || rank < 60 ? large : small;
        plot_page_mark(f->page, plot_junction_mark(junction.kind), spots[i].at, radius);
        f->kinds[junction.kind] = true;
        if (!tag) continue;
        tag->at = spots[i].at;
        tag->clear = radius;
        tag->weight = 100 + spots[i].weight;
        tag->colour = f->n_source > 1 ? plot_text_colour(PLOT_ATLAS + 3 * (plot_stroke)s->tint)
                                      : "#000000";
        plot_text_label(junction.name && *junction.name ? junction.name : junction.label,
                        sizeof tag->text, tag->text);
    }
}

/* Extrema of the period are on every other picture of no interest: they are drawn where they were
 * asked for. */
static bool wanted(const fep *f, const spot *s)
{
    return s->kind != RIC_KIND_START && (s->kind != RIC_KIND_PERIOD_EXTREMUM || s->named ||
                                         s->asked || f->options->marks == MARKS_ALL);
}

ric_status fep_draw_junctions(fep *f, fep_source *s)
{
    const int total = ric_atlas_n_junction(s->atlas);
    spot *spots = malloc(((size_t)total + 1) * sizeof *spots);
    ric_status status = spots ? RIC_OK : RIC_E_NOMEM;
    int n = 0;
    for (int id = 1; status == RIC_OK && id <= total; id++) {
        ric_junction junction;
        status = ric_atlas_junction(s->atlas, id, &junction);
        if (status != RIC_OK) break;
        const plot_point place = junction_place(f, s, &junction);
        if (!plot_panel_inside(f->panel, place)) continue;
        spots[n] = (spot){plot_panel_at(f->panel, place),
                          junction.kind,
                          junction_weight(s, &junction),
                          id,
                          junction.n_branch,
                          junction.branches,
                          junction.name && *junction.name,
                          fep_label_asked(f, s, "", 0, id),
                          false,
                          fep_in_zoom(f, place)};
        n += wanted(f, &spots[n]);
    }
    if (status == RIC_OK) {
        qsort(spots, (size_t)n, sizeof *spots, lighter);
        draw_spots(f, s, n, spots);
    }
    free(spots);
    return status;
}

/* --------------------------------------------------------- reference lines */

typedef struct {
    double frequency, y; /* y: of the text, pixels */
    plot_stroke stroke;
    char text[40];
} reference;

static int lower(const void *a, const void *b)
{
    const reference *s = a, *t = b;
    return (s->frequency > t->frequency) - (s->frequency < t->frequency);
}

static void add_reference(const fep *f, int *n, reference *list, double frequency,
                          plot_stroke stroke, const char *text)
{
    for (int i = 0; i < *n; i++)
        if (fabs(list[i].frequency - frequency) <= 1e-9 * frequency) return;
    if (frequency > f->panel->y.lo && frequency < f->panel->y.hi &&
        !plot_axis_omits(&f->panel->y, frequency)) {
        list[*n] = (reference){.frequency = frequency, .stroke = stroke};
        snprintf(list[(*n)++].text, sizeof list->text, "%s", text);
    }
}

static ric_status gather_references(const fep *f, const fep_source *s, int *n, reference *list,
                                    double *work)
{
    const int n_dof = ric_model_n_dof(s->model), n_contact = ric_model_n_contact(s->model);
    const bool hertz = f->options->common->hertz;
    const char *locked = hertz ? "F" : "Ω";
    char text[40];
    ric_status status = ric_model_frequencies(s->model, work);
    for (int i = 0; status == RIC_OK && i < n_dof; i++) {
        snprintf(text, sizeof text, "%s_{%d}", hertz ? "f" : "ω", i + 1);
        add_reference(f, n, list, work[i], PLOT_NATURAL, text);
    }
    for (int contact = 0; status == RIC_OK && contact < n_contact && n_dof > 1; contact++) {
        status = ric_model_locked_frequencies(s->model, contact, work);
        for (int i = 0; status == RIC_OK && i < n_dof - 1; i++) {
            if (n_contact > 1)
                snprintf(text, sizeof text, "%s@^{%d}_{%d}", locked, contact + 1, i + 1);
            else if (n_dof > 2) snprintf(text, sizeof text, "%s_{%d}", locked, i + 1);
            else snprintf(text, sizeof text, "%s_0", hertz ? "f" : "ω");
            add_reference(f, n, list, work[i], PLOT_LOCKED, text);
        }
    }
    return status;
}

/* Moves the texts at the margin apart; those that still have no room are left out. Returns how
 * many. */
static int spread(const plot_box *box, int n, reference *list, double line)
{
    int missing = 0;
    for (int round = 0; round < 50; round++) {
        for (int i = 1; i < n; i++) {
            const double push = (line - (list[i].y - list[i - 1].y)) / 2;
            if (push > 0) {
                list[i].y += push;
                list[i - 1].y -= push;
            }
        }
        for (int i = 0; i < n; i++)
            list[i].y = fmax(box->bottom + 4, fmin(box->top - 4, list[i].y));
    }
    double last = -INFINITY;
    for (int i = 0; i < n; i++) {
        if (list[i].y - last < line - 1.5) {
            list[i].text[0] = '\0';
            missing++;
        } else {
            last = list[i].y;
        }
    }
    return missing;
}

/* Lines of so many contacts and modes that they would hide the branches are left out. Returns how
 * many references are left. */
static int thin_out(fep *f, int n, reference *list)
{
    enum { MOST_LOCKED = 16 };
    int locked = 0, left = 0;
    for (int i = 0; i < n; i++) locked += list[i].stroke == PLOT_LOCKED;
    if (locked <= MOST_LOCKED) return n;
    f->no_locked = locked;
    for (int i = 0; i < n; i++)
        if (list[i].stroke != PLOT_LOCKED) list[left++] = list[i];
    return left;
}

ric_status fep_draw_references(fep *f, const fep_source *s)
{
    const int n_dof = ric_model_n_dof(s->model), n_contact = ric_model_n_contact(s->model);
    const plot_box box = plot_panel_box(f->panel);
    reference *list = calloc((size_t)n_dof * (size_t)(n_contact + 1), sizeof *list);
    double *work = calloc((size_t)n_dof, sizeof *work);
    int n = 0;
    ric_status status = list && work ? gather_references(f, s, &n, list, work) : RIC_E_NOMEM;
    if (status != RIC_OK) goto out;
    n = thin_out(f, n, list);
    qsort(list, (size_t)n, sizeof *list, lower);
    for (int i = 0; i < n; i++) list[i].y = plot_axis_at(&f->panel->y, list[i].frequency);
    f->no_margin += spread(&box, n, list,
                           (n_contact > 1 ? 1.75 : 1.35) * type); /* Ω with two indices is higher */
    for (int i = 0; i < n; i++) {
        const double y = plot_axis_at(&f->panel->y, list[i].frequency);
        plot_page_line(f->page, list[i].stroke, 2, (plot_point[]){{box.left, y}, {box.right, y}});
        f->natural |= list[i].stroke == PLOT_NATURAL;
        f->locked |= list[i].stroke == PLOT_LOCKED;
        if (!list[i].text[0]) continue;
        plot_page_line(f->page, PLOT_LEADER, 2,
                       (plot_point[]){{box.right + 1, y}, {box.right + 9, list[i].y}});
        plot_page_text(f->page, (plot_point){box.right + 11, list[i].y}, PLOT_LEFT, type, "#444444",
                       false, list[i].text);
    }
out:
    free(list);
    free(work);
    return status;
}

/* -------------------------------------------------------------- --mark */

/* Dots with a name of their own: orbits that are neither junctions nor ends, or duplicates of
 * junctions. */
int fep_draw_marks(fep *f, fep_source *s)
{
    for (int i = 0; i < f->options->n_asked; i++) {
        fep_asked *asked = &f->options->asked[i];
        plot_choice choice;
        if (asked->what != ASK_MARK || asked->atlas != s->index) continue;
        const int code = plot_choose(s->atlas, asked->text, "--mark", &choice);
        plot_motion_free(&choice.motion);
        if (code != CLI_DONE) return code;
        const plot_point data = {choice.energy, choice.frequency / choice.periods};
        if (!plot_panel_inside(f->panel, data)) continue;
        asked->used = true;
        const plot_point at = plot_panel_at(f->panel, data);
        if (choice.kind < 0) plot_page_mark(f->page, PLOT_DOT, at, 3.8);
        else plot_page_mark(f->page, plot_junction_mark((ric_kind)choice.kind), at, 3.8);
        if (fep_in_zoom(f, data)) continue;
        plot_tag *tag = fep_new_tag(f);
        if (!tag) return cli_report(RIC_E_NOMEM);
        tag->at = at;
        tag->clear = 3.8;
        tag->weight = 2000 - i;
        tag->colour = f->n_source > 1 ? plot_text_colour(PLOT_ATLAS + 3 * (plot_stroke)s->tint)
                                      : "#000000";
        plot_text_label(choice.name, sizeof tag->text, tag->text);
    }
    return CLI_DONE;
}
