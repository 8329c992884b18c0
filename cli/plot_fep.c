/* The frequency-energy plot. */
#define _POSIX_C_SOURCE 200809L

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "plot.h"

static const double type = 12;

/* ------------------------------------------------------------------ options */

typedef enum { LABELS_MAIN, LABELS_ALL, LABELS_NAMED, LABELS_NONE } label_choice;

typedef struct {
    const plot_options *common;
    bool linear, has_energy, has_frequency, has_break, ghosts;
    double energy[2], frequency[2], knee;
    long duplicates; /* drawn up to this k; 1: none */
    label_choice labels;
} fep_options;

typedef struct {
    const fep_options *options;
    ric_atlas *atlas;
    const ric_model *model;
    plot_page *page;
    plot_panel panel;
    bool family[3], kinds[RIC_KIND_USER + 1], natural, locked; /* drawn, for the legend */
    unsigned stability;
    struct { int n; ric_ghost **list; } *ghosts; /* [n_branch], or NULL: not asked for */
    bool ghost, duplicate[3]; /* one was drawn */
    plot_tag *tags;
    int n_tag, room, n_group;
    int no_margin; /* reference labels without a place */
} fep;

static int parse_options(int *argc, char **argv, fep_options *o)
{
    const char *energy = NULL, *frequency = NULL, *knee = NULL, *labels = NULL, *duplicates = NULL;
    o->linear = cli_take_flag(argc, argv, "--linear");
    o->ghosts = cli_take_flag(argc, argv, "--ghosts");
    if (!cli_take_value(argc, argv, "--energy", &energy) || !cli_take_value(argc, argv, "--frequency", &frequency)
        || !cli_take_value(argc, argv, "--break", &knee) || !cli_take_value(argc, argv, "--labels", &labels)
        || !cli_take_value(argc, argv, "--duplicates", &duplicates))
        return CLI_WRONG;
    o->duplicates = 1;
    if ((energy && !plot_parse_range(energy, "--energy", o->energy)) || (frequency && !plot_parse_range(frequency, "--frequency", o->frequency))
        || (knee && !cli_parse_number(knee, "--break", &o->knee))
        || (duplicates && !cli_parse_integer(duplicates, "--duplicates", 1, 100, &o->duplicates)))
        return CLI_WRONG;
    o->has_energy = energy;
    o->has_frequency = frequency;
    o->has_break = knee;
    if (energy && !o->linear && o->energy[0] <= 0)
        return cli_wrong("--energy %s: a logarithmic axis starts above 0; give a positive start or --linear", energy);
    if (knee && !(o->knee > 0))
        return cli_wrong("--break %s: the frequency of the break must be positive", knee);
    static const char *const choices[] = {"", "all", "named", "none"};
    for (int i = LABELS_ALL; labels && i <= LABELS_NONE; i++)
        if (!strcmp(labels, choices[i]))
            o->labels = (label_choice)i;
    if (labels && o->labels == LABELS_MAIN)
        return cli_wrong("--labels %s: there are all, named and none", labels);
    return cli_operands(&cli_plot, *argc, argv, 1) ? CLI_DONE : CLI_WRONG;
}

/* ------------------------------------------------------------------- window */

typedef struct { double lo, hi; } span;

static void span_add(span *s, double value)
{
    s->lo = fmin(s->lo, value);
    s->hi = fmax(s->hi, value);
}

/* Whether a value lies in a window that the user gave. */
static bool wanted(bool given, const double range[2], double value)
{
    return !given || (value >= range[0] && value <= range[1]);
}

/* The frequencies of a point and of its duplicates, as far as they are wanted; false if none is. */
static bool add_frequencies(const fep_options *o, double frequency, span *out)
{
    bool any = false;
    for (long k = 1; k <= o->duplicates; k++)
        if (wanted(o->has_frequency, o->frequency, frequency / (double)k)) {
            span_add(out, frequency / (double)k);
            any = true;
        }
    return any;
}

/* What the axes must hold. The linear modes reach down to energy 0; only their upper end counts. */
static ric_status find_window(const fep *f, span *energy, span *frequency)
{
    const fep_options *o = f->options;
    *energy = *frequency = (span){INFINITY, -INFINITY};
    for (int id = 1; id <= ric_atlas_n_branch(f->atlas); id++) {
        ric_branch branch;
        ric_status status = ric_atlas_branch(f->atlas, id, &branch);
        for (int i = 0; status == RIC_OK && i < branch.n_point; i++) {
            ric_point p;
            status = ric_atlas_point(f->atlas, id, i, &p, NULL, NULL);
            if (status != RIC_OK || !wanted(o->has_energy, o->energy, p.energy) || !add_frequencies(o, p.frequency, frequency))
                continue;
            if (p.energy > 0 && (branch.impacts > 0 || branch.depth > 0 || o->has_energy))
                span_add(energy, p.energy);
            else if (p.energy > 0 && p.energy >= branch.energy_max) { /* and enough of the line to be seen */
                span_add(energy, p.energy);
                span_add(energy, 0.6 * p.energy);
            }
        }
        if (status != RIC_OK)
            return status;
    }
    return RIC_OK;
}

static void set_axes(fep *f, span energy, span frequency)
{
    const fep_options *o = f->options;
    plot_axis *x = &f->panel.x, *y = &f->panel.y;
    x->scale = o->linear ? PLOT_SCALE_LINEAR : PLOT_SCALE_LOG;
    if (!o->has_energy) {
        plot_range_widen(!o->linear, 0.06, &energy.lo, &energy.hi);
        energy.lo = o->linear ? 0 : energy.lo;
    }
    x->lo = o->has_energy ? o->energy[0] : energy.lo;
    x->hi = o->has_energy ? o->energy[1] : energy.hi;
    span wide = frequency;
    plot_range_widen(false, 0.06, &wide.lo, &wide.hi);
    if (o->has_break) /* the margin below goes with the linear part only */
        wide.lo = frequency.lo - fmin(frequency.lo - wide.lo, 0.08 * fmax(0, o->knee - frequency.lo));
    y->lo = o->has_frequency ? o->frequency[0] : fmax(0, wide.lo);
    y->hi = o->has_frequency ? o->frequency[1] : wide.hi;
    if (o->has_break) {
        y->scale = PLOT_SCALE_BROKEN;
        y->knee = o->knee;
    }
}

/* ----------------------------------------------------------------- branches */

static plot_tag *new_tag(fep *f)
{
    if (f->n_tag == f->room) {
        const int room = f->room ? 2 * f->room : 128;
        plot_tag *tags = realloc(f->tags, (size_t)room * sizeof *tags);
        if (!tags)
            return NULL;
        f->tags = tags;
        f->room = room;
    }
    f->tags[f->n_tag] = (plot_tag){.leader = true};
    return &f->tags[f->n_tag++];
}

/* The part of piece i of a track that lies in the panel, in pixels; returns its length, 0 if there is none. */
static double visible_piece(const fep *f, const plot_track *t, int i, plot_point *a, plot_point *b)
{
    const plot_box box = plot_panel_box(&f->panel);
    *a = plot_panel_at(&f->panel, t->knots[i - 1].at);
    *b = plot_panel_at(&f->panel, t->knots[i].at);
    return isfinite(a->x + a->y + b->x + b->y) && plot_clip_segment(&box, a, b) ? hypot(b->x - a->x, b->y - a->y) : 0;
}

/* Label of the k-duplicate of a branch: may stand at any of a few places along its visible part. */
static void tag_branch(fep *f, const ric_branch *branch, int k_duplicate, const plot_track *t)
{
    enum { PLACES = 15 };
    plot_point a, b;
    double length = 0, done = 0, next = 0.5;
    for (int i = 1; i < t->n; i++)
        length += visible_piece(f, t, i, &a, &b);
    if (length < 45 || f->options->labels == LABELS_NONE || f->options->labels == LABELS_NAMED
        || (f->options->labels == LABELS_MAIN && branch->depth > 3))
        return;
    if (f->options->labels == LABELS_MAIN && k_duplicate > 1 && !(branch->mode && branch->depth))
        return;
    const int group = ++f->n_group;
    const double weight = 20 - 4 * (k_duplicate - 1) - 5 * branch->depth + 8 * branch->symmetric + fmin(length, 400) / 40 - 0.2 * branch->impacts;
    for (int i = 1, k = 0; i < t->n && k < PLACES; i++) {
        const double step = visible_piece(f, t, i, &a, &b);
        for (; k < PLACES && step > 0 && done + step >= next / PLACES * length; next++, k++) {
            plot_tag *tag = new_tag(f);
            if (!tag)
                return;
            const double part = (next / PLACES * length - done) / step;
            tag->at = (plot_point){a.x + part * (b.x - a.x), a.y + part * (b.y - a.y)};
            tag->clear = 3;
            tag->weight = weight - 1e-3 * fabs(next - PLACES / 2.); /* the middle first */
            tag->group = group;
            tag->colour = plot_branch_family(branch) == PLOT_LINEAR ? "#6a6a6a" : plot_stroke_colour(plot_branch_family(branch));
            tag->leader = false;
            plot_branch_title(branch, k_duplicate, sizeof tag->text, tag->text);
        }
        done += step;
    }
}

/* Interior junctions, so that the curve passes through their marks. A q-tupling lies on its original branch at q times where it is drawn. */
static ric_status add_joints(const fep *f, const ric_branch *branch, int k_duplicate, plot_track *t)
{
    for (int k = 0; k < branch->n_junction; k++) {
        ric_junction junction;
        const ric_status status = ric_atlas_junction(f->atlas, branch->junctions[k], &junction);
        if (status != RIC_OK)
            return status;
        const double frequency = junction.frequency * ric_junction_level(&junction, branch);
        if (!plot_track_add(t, (plot_point){junction.energy, frequency / k_duplicate}, branch->junction_at[k], PLOT_JOINT))
            return RIC_E_NOMEM;
    }
    plot_track_sort(t);
    return RIC_OK;
}

/* The k-duplicate of a branch with its joints. */
static ric_status make_track(const fep *f, const ric_branch *branch, int k, plot_track *t)
{
    for (int i = 0; i < branch->n_point; i++) {
        ric_point p;
        const ric_status status = ric_atlas_point(f->atlas, branch->id, i, &p, NULL, NULL);
        if (status != RIC_OK)
            return status;
        if (!plot_track_add(t, (plot_point){p.energy, p.frequency / k}, p.arclength, p.stable >= 0 && p.stable <= 2 ? p.stable : RIC_STABLE_UNDECIDED))
            return RIC_E_NOMEM;
    }
    return add_joints(f, branch, k, t);
}

static ric_status draw_branch(fep *f, int id)
{
    ric_branch branch;
    plot_track t = {0};
    ric_status status = ric_atlas_branch(f->atlas, id, &branch);
    if (status == RIC_OK)
        status = make_track(f, &branch, 1, &t);
    if (status == RIC_OK) {
        const plot_stroke family = plot_branch_family(&branch);
        const unsigned seen = plot_track_draw(f->page, &f->panel, family, &t);
        f->family[(family - PLOT_LINEAR) / 3] |= seen != 0;
        f->stability |= seen;
        tag_branch(f, &branch, 1, &t);
    }
    plot_track_free(&t);
    return status;
}

/* --------------------------------------------------------------- duplicates */

/* Small marks where the k-duplicate has multiplications that a duplicate before it has, too; its own are junctions as all others. */
static ric_status mark_inherited(fep *f, const ric_branch *branch, int k)
{
    int n = 0;
    ric_duplicate_point *points = calloc((size_t)branch->n_junction + 2, sizeof *points);
    const ric_status status = points ? ric_duplicate_points(f->atlas, branch->id, k, &n, points) : RIC_E_NOMEM;
    for (int i = 0; status == RIC_OK && i < n; i++) {
        const plot_point at = {points[i].energy, points[i].frequency};
        if (points[i].origin != RIC_DUPLICATE_INHERITED || !plot_panel_inside(&f->panel, at))
            continue;
        plot_page_mark(f->page, plot_junction_mark(RIC_KIND_MULTIPLICATION), plot_panel_at(&f->panel, at), 2.4);
        f->kinds[RIC_KIND_MULTIPLICATION] = true;
    }
    free(points);
    return status;
}

static ric_status draw_duplicate(fep *f, const ric_branch *branch, int k)
{
    const int family = (plot_branch_family(branch) - PLOT_LINEAR) / 3;
    plot_track t = {0};
    ric_status status = make_track(f, branch, k, &t);
    plot_point *curve = malloc(((size_t)t.n + 1) * sizeof *curve);
    for (int i = 0; curve && i < t.n; i++) {
        curve[i] = t.knots[i].at;
        f->duplicate[family] |= plot_panel_inside(&f->panel, curve[i]);
    }
    if (status == RIC_OK && curve) {
        plot_panel_curve(f->page, &f->panel, PLOT_DUPLICATE + (plot_stroke)family, t.n, curve);
        tag_branch(f, branch, k, &t);
    }
    free(curve);
    plot_track_free(&t);
    return status != RIC_OK ? status : curve ? mark_inherited(f, branch, k) : RIC_E_NOMEM;
}

static ric_status draw_duplicates(fep *f)
{
    ric_status status = RIC_OK;
    for (int id = 1; status == RIC_OK && f->options->duplicates > 1 && id <= ric_atlas_n_branch(f->atlas); id++) {
        ric_branch branch;
        status = ric_atlas_branch(f->atlas, id, &branch);
        for (int k = 2; status == RIC_OK && k <= f->options->duplicates; k++)
            status = draw_duplicate(f, &branch, k);
    }
    return status;
}

/* ------------------------------------------------------------------- ghosts */

/* The window in which the ghosts of a branch are followed: what the panel shows and, since a ghost may come in from outside, its start. */
static ric_status ghost_window(const fep *f, const ric_branch *branch, bool *shown, ric_ghost_limits *limits)
{
    span energy = {f->panel.x.lo, f->panel.x.hi}, frequency = {f->panel.y.lo, f->panel.y.hi};
    ric_status status = RIC_OK;
    *shown = false;
    ric_ghost_limits_init(f->atlas, limits);
    for (int i = 0; status == RIC_OK && i < branch->n_point; i++) {
        ric_point p;
        status = ric_atlas_point(f->atlas, branch->id, i, &p, NULL, NULL);
        *shown |= status == RIC_OK && plot_panel_inside(&f->panel, (plot_point){p.energy, p.frequency});
        if (status == RIC_OK && (i == 0 || i == branch->n_point - 1)) {
            span_add(&energy, p.energy);
            span_add(&frequency, p.frequency);
        }
    }
    limits->energy[0] = energy.lo;
    limits->energy[1] = energy.hi;
    limits->frequency[0] = frequency.lo;
    limits->frequency[1] = frequency.hi;
    return status;
}

/* Ghosts of the branches that the panel shows. */
static ric_status find_ghosts(fep *f)
{
    const int total = ric_atlas_n_branch(f->atlas);
    int failed = 0;
    ric_status status = (f->ghosts = calloc((size_t)total + 1, sizeof *f->ghosts)) ? RIC_OK : RIC_E_NOMEM;
    for (int id = 1; status == RIC_OK && id <= total; id++) {
        ric_branch branch;
        ric_ghost_limits limits;
        bool shown;
        status = ric_atlas_branch(f->atlas, id, &branch);
        if (status != RIC_OK || (status = ghost_window(f, &branch, &shown, &limits)) != RIC_OK || !shown)
            continue;
        status = ric_ghost_find(f->atlas, id, &limits, &f->ghosts[id - 1].n, &f->ghosts[id - 1].list);
        if (status == RIC_E_NUMERIC) { /* one missing ghost is no reason to have no picture */
            failed++;
            status = RIC_OK;
        }
    }
    if (failed)
        fprintf(stderr, "ricochet: the ghosts of %d branch%s could not be computed and are not drawn\n", failed, failed == 1 ? "" : "es");
    return status;
}

static void free_ghosts(fep *f)
{
    for (int i = 0; f->ghosts && i < ric_atlas_n_branch(f->atlas); i++)
        ric_ghosts_free(f->ghosts[i].n, f->ghosts[i].list);
    free(f->ghosts);
}

static ric_status draw_ghost(fep *f, const ric_ghost *ghost)
{
    ric_ghost_data data;
    ric_status status = RIC_OK;
    ric_ghost_describe(ghost, &data);
    plot_point *curve = malloc(((size_t)data.n_point + 1) * sizeof *curve);
    if (!curve)
        return RIC_E_NOMEM;
    for (int i = 0; status == RIC_OK && i < data.n_point; i++) {
        ric_point p;
        status = ric_ghost_point(ghost, i, &p, NULL, NULL);
        if (status != RIC_OK)
            break;
        curve[i] = (plot_point){p.energy, ric_point_admissible(&p) ? NAN : p.frequency}; /* where it is a motion again it is no ghost */
        f->ghost |= i > 0 && plot_panel_inside(&f->panel, curve[i]);
    }
    if (status == RIC_OK)
        plot_panel_curve(f->page, &f->panel, PLOT_GHOST, data.n_point, curve);
    free(curve);
    return status;
}

static ric_status draw_ghosts(fep *f)
{
    ric_status status = RIC_OK;
    for (int i = 0; f->ghosts && i < ric_atlas_n_branch(f->atlas); i++)
        for (int k = 0; status == RIC_OK && k < f->ghosts[i].n; k++)
            status = draw_ghost(f, f->ghosts[i].list[k]);
    return status;
}

/* ---------------------------------------------------------------- junctions */

/* Where the mark stands. A q-tupling belongs at omega / q, among the branches that leave it, or on a duplicate; where there is neither
 * it is shown on the branch that it lies on, for at omega / q there would be nothing to see it on, and with duplicates up to K not at all. */
static plot_point junction_place(const fep *f, const ric_junction *junction)
{
    double frequency = junction->frequency;
    if (junction->multiple > f->options->duplicates) {
        bool departed = false;
        for (int i = 0; i < junction->n_branch; i++) {
            ric_branch branch;
            if (ric_atlas_branch(f->atlas, junction->branches[i], &branch) == RIC_OK)
                departed |= junction->impacts ? branch.impacts > junction->impacts : ric_junction_level(junction, &branch) == 1;
        }
        if (!departed)
            frequency = f->options->duplicates > 1 ? NAN : frequency * junction->multiple;
    }
    return (plot_point){junction->energy, frequency};
}

/* What a reader looks for first: names of the study, then where branches part, near the start, of few impacts. */
static double junction_weight(const fep *f, const ric_junction *junction)
{
    static const double of_kind[] = {
        [RIC_KIND_START] = -20, [RIC_KIND_GRAZING] = 30, [RIC_KIND_CORNER] = 30, [RIC_KIND_EXTREMUM] = 12, [RIC_KIND_BRANCH_POINT] = 36,
        [RIC_KIND_MULTIPLICATION] = 30, [RIC_KIND_PERIOD_EXTREMUM] = 4, [RIC_KIND_USER] = 50,
    };
    int depth = 100, symmetric = 0;
    for (int i = 0; i < junction->n_branch; i++) {
        ric_branch branch;
        if (ric_atlas_branch(f->atlas, junction->branches[i], &branch) != RIC_OK)
            continue;
        depth = branch.depth < depth ? branch.depth : depth;
        symmetric |= branch.symmetric;
    }
    return of_kind[junction->kind] + 1000 * (junction->name && *junction->name) + 6 * symmetric - 4 * fmin(depth, 10)
        + 8 * (junction->departures.taken > 0) - 0.4 * junction->impacts;
}

typedef struct {
    plot_point at; /* pixels */
    ric_kind kind;
    double weight;
    int id;
} spot;

static int lighter(const void *a, const void *b)
{
    const spot *s = a, *t = b;
    return s->weight != t->weight ? (s->weight > t->weight) - (s->weight < t->weight) : t->id - s->id;
}

static bool labelled(const fep *f, const ric_junction *junction, const spot *s, int rank)
{
    const bool named = junction->name && *junction->name;
    switch (f->options->labels) {
    case LABELS_NONE: return false;
    case LABELS_NAMED: return named;
    case LABELS_ALL: return true;
    case LABELS_MAIN: break;
    }
    /* As many as a reader can take in: one for a square of 120 pixels. */
    const plot_box box = plot_panel_box(&f->panel);
    return named || (s->weight > 10 && rank < (box.right - box.left) * (box.top - box.bottom) / (120 * 120));
}

static void draw_spots(fep *f, int n, const spot *spots)
{
    const double large = 4.4, small = n > 150 ? 2 : 2.8;
    for (int i = 0; i < n; i++) { /* the heaviest last, on top */
        ric_junction junction;
        if (ric_atlas_junction(f->atlas, spots[i].id, &junction) != RIC_OK)
            continue;
        plot_tag *tag = labelled(f, &junction, &spots[i], n - 1 - i) ? new_tag(f) : NULL;
        const double radius = n < 40 || n - 1 - i < 60 ? large : small;
        plot_page_mark(f->page, plot_junction_mark(junction.kind), spots[i].at, radius);
        f->kinds[junction.kind] = true;
        if (!tag)
            continue;
        tag->at = spots[i].at;
        tag->clear = radius;
        tag->weight = 100 + spots[i].weight;
        tag->colour = "#000000";
        plot_text_label(junction.name && *junction.name ? junction.name : junction.label, sizeof tag->text, tag->text);
    }
}

static ric_status draw_junctions(fep *f)
{
    const int total = ric_atlas_n_junction(f->atlas);
    spot *spots = malloc(((size_t)total + 1) * sizeof *spots);
    ric_status status = spots ? RIC_OK : RIC_E_NOMEM;
    int n = 0;
    for (int id = 1; status == RIC_OK && id <= total; id++) {
        ric_junction junction;
        status = ric_atlas_junction(f->atlas, id, &junction);
        if (status != RIC_OK)
            break;
        const plot_point place = junction_place(f, &junction);
        if (junction.kind != RIC_KIND_START && plot_panel_inside(&f->panel, place))
            spots[n++] = (spot){plot_panel_at(&f->panel, place), junction.kind, junction_weight(f, &junction), id};
    }
    if (status == RIC_OK) {
        qsort(spots, (size_t)n, sizeof *spots, lighter);
        draw_spots(f, n, spots);
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

static void add_reference(const fep *f, int *n, reference *list, double frequency, plot_stroke stroke, const char *text)
{
    for (int i = 0; i < *n; i++)
        if (fabs(list[i].frequency - frequency) <= 1e-9 * frequency)
            return;
    if (frequency > f->panel.y.lo && frequency < f->panel.y.hi) {
        list[*n] = (reference){.frequency = frequency, .stroke = stroke};
        snprintf(list[(*n)++].text, sizeof list->text, "%s", text);
    }
}

static ric_status gather_references(const fep *f, int *n, reference *list, double *work)
{
    const int n_dof = ric_model_n_dof(f->model), n_contact = ric_model_n_contact(f->model);
    char text[40];
    ric_status status = ric_model_frequencies(f->model, work);
    for (int i = 0; status == RIC_OK && i < n_dof; i++) {
        snprintf(text, sizeof text, "ω_{%d}", i + 1);
        add_reference(f, n, list, work[i], PLOT_NATURAL, text);
    }
    for (int contact = 0; status == RIC_OK && contact < n_contact && n_dof > 1; contact++) {
        status = ric_model_locked_frequencies(f->model, contact, work);
        for (int i = 0; status == RIC_OK && i < n_dof - 1; i++) {
            if (n_contact > 1)
                snprintf(text, sizeof text, "Ω@^{%d}_{%d}", contact + 1, i + 1);
            else if (n_dof > 2)
                snprintf(text, sizeof text, "Ω_{%d}", i + 1);
            else
                snprintf(text, sizeof text, "ω_0");
            add_reference(f, n, list, work[i], PLOT_LOCKED, text);
        }
    }
    return status;
}

/* Moves the texts at the margin apart; those that still have no room are left out. Returns how many. */
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

static ric_status draw_references(fep *f)
{
    const int n_dof = ric_model_n_dof(f->model), n_contact = ric_model_n_contact(f->model);
    const plot_box box = plot_panel_box(&f->panel);
    reference *list = calloc((size_t)n_dof * (size_t)(n_contact + 1), sizeof *list);
    double *work = calloc((size_t)n_dof, sizeof *work);
    int n = 0;
    ric_status status = list && work ? gather_references(f, &n, list, work) : RIC_E_NOMEM;
    if (status != RIC_OK)
        goto out;
    qsort(list, (size_t)n, sizeof *list, lower);
    for (int i = 0; i < n; i++)
        list[i].y = plot_axis_at(&f->panel.y, list[i].frequency);
    f->no_margin = spread(&box, n, list, (n_contact > 1 ? 1.75 : 1.35) * type); /* Ω with two indices is higher */
    for (int i = 0; i < n; i++) {
        const double y = plot_axis_at(&f->panel.y, list[i].frequency);
        plot_page_line(f->page, list[i].stroke, 2, (plot_point[]){{box.left, y}, {box.right, y}});
        f->natural |= list[i].stroke == PLOT_NATURAL;
        f->locked |= list[i].stroke == PLOT_LOCKED;
        if (!list[i].text[0])
            continue;
        plot_page_line(f->page, PLOT_LEADER, 2, (plot_point[]){{box.right + 1, y}, {box.right + 9, list[i].y}});
        plot_page_text(f->page, (plot_point){box.right + 11, list[i].y}, PLOT_LEFT, type, "#444444", false, list[i].text);
    }
out:
    free(list);
    free(work);
    return status;
}

/* ----------------------------------------------------------------- the page */

static int legend_entries(const fep *f, plot_legend_entry *out)
{
    int n = plot_legend_entries(f->family, f->stability, NULL, out);
    if (f->ghost)
        out[n++] = (plot_legend_entry){"ghost: no motion", PLOT_GHOST, -1};
    static const char *const texts[] = {"duplicate of a linear mode", "duplicate, asymmetric", "duplicate, symmetric"};
    for (int i = 0; i < 3; i++)
        if (f->duplicate[i])
            out[n++] = (plot_legend_entry){texts[i], PLOT_DUPLICATE + i, -1};
    if (f->natural)
        out[n++] = (plot_legend_entry){"natural frequency", PLOT_NATURAL, -1};
    if (f->locked)
        out[n++] = (plot_legend_entry){"contact locked", PLOT_LOCKED, -1};
    return n + plot_legend_entries(NULL, 0, f->kinds, out + n);
}

/* Lines and marks, with `legend` pixels left free at the foot. */
static ric_status draw_data(fep *f, double legend)
{
    const plot_options *common = f->options->common;
    const double width = common->width > 0 ? common->width : 1000, height = common->height > 0 ? common->height : 700;
    plot_page_free(f->page);
    f->page = plot_page_create(width, height);
    if (!f->page)
        return RIC_E_NOMEM;
    f->n_tag = f->n_group = 0;
    f->panel.x.from = 64;
    f->panel.x.to = width - 44;
    f->panel.y.from = 50 + legend;
    f->panel.y.to = height - 34;
    ric_status status = draw_references(f);
    for (int id = 1; status == RIC_OK && id <= ric_atlas_n_branch(f->atlas); id++)
        status = draw_branch(f, id);
    if (status == RIC_OK)
        status = draw_duplicates(f);
    if (status == RIC_OK)
        status = draw_ghosts(f);
    return status == RIC_OK ? draw_junctions(f) : status;
}

static ric_status draw(fep *f)
{
    const plot_options *common = f->options->common;
    char title[400], frequency[80] = "frequency ω (rad/s)";
    plot_legend_entry entries[PLOT_MAX_LEGEND];
    int n_entry = 0;
    double legend = 0;
    ric_status status = RIC_OK;
    for (int round = 0; round < 2 && status == RIC_OK; round++) { /* what the legend needs is known once the data are drawn */
        status = draw_data(f, legend);
        n_entry = legend_entries(f, entries);
        legend = plot_legend(NULL, n_entry, entries, 12, plot_page_width(f->page) - 12, 0);
    }
    if (status != RIC_OK)
        return status;
    if (f->options->has_break && f->panel.y.to - f->panel.y.from > 300)
        snprintf(frequency, sizeof frequency, "frequency ω (rad/s), logarithmic above %g", f->options->knee);
    plot_panel_frame(f->page, &f->panel, "scaled energy E", frequency);
    const int missing = plot_place_tags(f->page, plot_panel_box(&f->panel), f->n_tag, f->tags, type) + f->no_margin;
    if (missing > 0)
        fprintf(stderr, "ricochet: %d label%s left out for want of room; --energy, --frequency or --size make more\n", missing,
                missing == 1 ? "" : "s");
    plot_text_escape(common->title ? common->title : ric_study_title(ric_atlas_study(f->atlas)), sizeof title, title);
    plot_page_text(f->page, (plot_point){(f->panel.x.from + f->panel.x.to) / 2, f->panel.y.to + 17}, PLOT_CENTRE, type + 2, "#000000", false, title);
    plot_legend(f->page, n_entry, entries, 12, plot_page_width(f->page) - 12, f->panel.y.from - 46);
    return RIC_OK;
}

static int draw_page(fep *f)
{
    const plot_options *common = f->options->common;
    span energy, frequency;
    ric_status status = find_window(f, &energy, &frequency);
    if (status != RIC_OK)
        return cli_report(status);
    if (!(energy.hi > 0) || !(frequency.hi > 0)) {
        fprintf(stderr, "ricochet: nothing to draw: %s\n",
                ric_atlas_n_branch(f->atlas) ? "no branch of the atlas enters this window" : "the atlas has no branches yet");
        return CLI_FAILED;
    }
    set_axes(f, energy, frequency);
    if (f->options->has_break && !(f->options->knee > f->panel.y.lo && f->options->knee < f->panel.y.hi))
        return cli_wrong("--break %g: must lie inside the frequencies shown, %g to %g", f->options->knee, f->panel.y.lo, f->panel.y.hi);
    if (f->options->ghosts)
        status = find_ghosts(f);
    if (status == RIC_OK)
        status = draw(f);
    return status == RIC_OK ? plot_page_write(f->page, common->out) : cli_report(status);
}

int plot_fep(int argc, char **argv, const plot_options *common)
{
    fep_options options = {.common = common};
    fep f = {.options = &options};
    int code = parse_options(&argc, argv, &options);
    if (code != CLI_DONE)
        return code;
    const ric_status status = ric_atlas_read(argv[1], &f.atlas);
    if (status != RIC_OK)
        return cli_report(status);
    f.model = ric_atlas_model(f.atlas);
    code = draw_page(&f);
    plot_page_free(f.page);
    free_ghosts(&f);
    ric_atlas_free(f.atlas);
    free(f.tags);
    return code;
}
