/* Curves of the frequency-energy picture: branches or parts of them, duplicates, ghosts. */
#define _POSIX_C_SOURCE 200809L

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "plot_fep.h"

static const double TONGUE_WEIGHT =
    10; /* of the name of a resonance: below those of the branches near the start */

/* -------------------------------------------------------------------- parts */

static bool add_part(fep_source *s, fep_part part)
{
    if (s->n_part == s->room) {
        const int room = s->room ? 2 * s->room : 256;
        fep_part *parts = realloc(s->parts, (size_t)room * sizeof *parts);
        if (!parts) return false;
        s->parts = parts;
        s->room = room;
    }
    s->parts[s->n_part++] = part;
    return true;
}

static bool add_whole(fep_source *s, int branch, int k)
{
    return add_part(s, (fep_part){.branch = branch, .k = k, .lo = -INFINITY, .hi = INFINITY});
}

static bool add_segment(fep_source *s, const plot_segment *segment, int k)
{
    return add_part(s, (fep_part){.branch = segment->branch,
                                  .k = k,
                                  .lo = fmin(segment->s[0], segment->s[1]),
                                  .hi = fmax(segment->s[0], segment->s[1])});
}

/* --duplicate K:SEGMENT */
static int take_duplicate(fep_source *s, const char *text)
{
    char first[24];
    const char *colon = strchr(text, ':');
    long k;
    plot_segment segment;
    if (!colon || (size_t)(colon - text) >= sizeof first)
        return cli_wrong("--duplicate %s: a duplicate is K:BRANCH, for example '3:S2-[01]'", text);
    snprintf(first, sizeof first, "%.*s", (int)(colon - text), text);
    if (!cli_parse_integer(first, "--duplicate", 2, 1000, &k) ||
        !plot_find_segment(s->atlas, colon + 1, "--duplicate", &segment))
        return CLI_WRONG;
    return add_segment(s, &segment, (int)k) ? CLI_DONE : cli_report(RIC_E_NOMEM);
}

/* --base F6_2: what `ricochet bases` lists under this name. */
static int take_base(fep_source *s, const char *text)
{
    int j, mode, end = 0, code = CLI_FAILED;
    ric_bases *bases = NULL;
    if (sscanf(text, "F%9d_%9d%n", &j, &mode, &end) != 2 || text[end])
        return cli_wrong("--base %s: a base is Fj_i, for example F6_2; see ricochet bases", text);
    const ric_status status = ric_bases_find(s->atlas, 0, &bases);
    if (status != RIC_OK) return cli_report(status);
    for (int i = 0; i < ric_bases_n(bases); i++) {
        ric_base base;
        if (ric_bases_get(bases, i, &base) != RIC_OK || base.mode != mode || base.j != j) continue;
        bool good = true;
        for (int b = 0; b < base.n_branch; b++) good = good && add_whole(s, base.branches[b], 1);
        for (int d = 0; d < base.n_duplicate; d++)
            good = good && add_whole(s, base.duplicates[2 * d], base.duplicates[2 * d + 1]);
        code = good ? CLI_DONE : cli_report(RIC_E_NOMEM);
        goto out;
    }
    cli_say("ricochet: the atlas has no base %s; `ricochet bases` lists those it has\n", text);
out:
    ric_bases_free(bases);
    return code;
}

/* Branches and duplicates that the options name one by one. */
static int named_parts(fep *f, fep_source *s, bool *any)
{
    int code = CLI_DONE;
    for (int i = 0; code == CLI_DONE && i < f->options->n_asked; i++) {
        const fep_asked *a = &f->options->asked[i];
        plot_segment segment;
        if (a->atlas != s->index) continue;
        if (a->what == ASK_BRANCH)
            code = !plot_find_segment(s->atlas, a->text, "--branch", &segment) ? CLI_WRONG
                   : add_segment(s, &segment, 1)                               ? CLI_DONE
                                                 : cli_report(RIC_E_NOMEM);
        else if (a->what == ASK_DUPLICATE) code = take_duplicate(s, a->text);
        else if (a->what == ASK_BASE) code = take_base(s, a->text);
        *any |= a->what == ASK_BRANCH || a->what == ASK_BASE;
    }
    return code;
}

/* All branches, or those named; of these duplicates up to --duplicates, and the duplicates named.
 */
int fep_choose_parts(fep *f, fep_source *s)
{
    bool any = false, good = true;
    int code = named_parts(f, s, &any);
    if (code != CLI_DONE) return code;
    for (int id = 1; !any && good && id <= ric_atlas_n_branch(s->atlas); id++) {
        ric_branch branch;
        good = ric_atlas_branch(s->atlas, id, &branch) == RIC_OK &&
               ((f->options->symmetric && !branch.symmetric) || add_whole(s, id, 1));
    }
    const int originals = s->n_part;
    for (int i = 0; i < originals && good; i++)
        for (int k = 2; s->parts[i].k == 1 && k <= f->options->duplicates && good; k++) {
            const fep_part part = s->parts[i];
            good = add_part(s, (fep_part){.branch = part.branch,
                                          .k = k,
                                          .lo = part.lo,
                                          .hi = part.hi});
        }
    return good ? CLI_DONE : cli_report(RIC_E_NOMEM);
}

void fep_free_source(fep_source *s)
{
    for (int i = 0; s->ghosts && i < ric_atlas_n_branch(s->atlas); i++)
        ric_ghosts_free(s->ghosts[i].n, s->ghosts[i].list);
    free(s->ghosts);
    free(s->parts);
    ric_atlas_free(s->atlas);
}

/* ----------------------------------------------------------------- branches */

/* The part of piece i of a track that lies in the panel, in pixels; returns its length, 0 if there
 * is none. */
static double visible_piece(const plot_panel *panel, const plot_track *t, int i, plot_point *a,
                            plot_point *b)
{
    const plot_box box = plot_panel_box(panel);
    if (t->knots[i - 1].gap) return 0;
    *a = plot_panel_at(panel, t->knots[i - 1].at);
    *b = plot_panel_at(panel, t->knots[i].at);
    return isfinite(a->x + a->y + b->x + b->y) && plot_clip_segment(&box, a, b)
               ? hypot(b->x - a->x, b->y - a->y)
               : 0;
}

/* Whether the k-duplicate of a branch is labelled. */
static bool wants_label(fep *f, const fep_source *s, const ric_branch *branch, int k, double length)
{
    char name[400];
    const char *label = ric_duplicate_label(branch, k, sizeof name, name) == RIC_OK ? name : "";
    if (fep_label_asked(f, s, label, k == 1 ? branch->id : 0, 0))
        return length > 24; /* a corner of a panel says nothing */
    if (length < 45 || f->options->labels == LABELS_NONE || f->options->labels == LABELS_NAMED ||
        f->options->labels == LABELS_ASKED)
        return false;
    if (f->options->labels == LABELS_MAIN && branch->depth > 3) return false;
    return f->options->labels != LABELS_MAIN || k == 1 || (branch->mode && branch->depth);
}

/* Whether the step before knot i of a curve is drawn larger in another panel. */
static bool zoomed(const fep *f, const plot_track *t, int i)
{
    return fep_in_zoom(f, t->knots[i - 1].at) || fep_in_zoom(f, t->knots[i].at);
}

/* Whether a curve of the first panel is long enough in another one to have its label there. */
static bool named_larger(const fep *f, const plot_track *t)
{
    bool found = false;
    for (int k = 1; f->panel == f->panels && k < f->n_panel; k++) {
        plot_point a, b;
        double length = 0;
        for (int i = 1; i < t->n; i++) length += visible_piece(&f->panels[k], t, i, &a, &b);
        found |= length > 60;
    }
    return found;
}

/* Label of the k-duplicate of a branch: may stand at any of a few places along its visible part,
 * and is left out where there is no room beside the curve while another panel names it. */
static void tag_branch(fep *f, const fep_source *s, const ric_branch *branch, int k_duplicate,
                       const plot_track *t)
{
    enum { PLACES = 15 };
    plot_point a, b;
    double length = 0, done = 0, next = 0.5;
    for (int i = 1; i < t->n; i++) length += visible_piece(f->panel, t, i, &a, &b);
    if (!wants_label(f, s, branch, k_duplicate, length)) return;
    const bool asked = f->options->labels == LABELS_ASKED, spare = named_larger(f, t);
    const int group = ++f->n_group;
    const double weight = 20 + 90 * asked - 4 * (k_duplicate - 1) - 5 * branch->depth +
                          8 * branch->symmetric + fmin(length, 400) / 40 - 0.2 * branch->impacts;
    for (int i = 1, k = 0; i < t->n && k < PLACES; i++) {
        const double step = visible_piece(f->panel, t, i, &a, &b);
        for (; k < PLACES && step > 0 && done + step >= next / PLACES * length; next++, k++) {
            const double part = (next / PLACES * length - done) / step;
            if (zoomed(f, t, i)) continue;
            plot_tag tag = {.at = {a.x + part * (b.x - a.x), a.y + part * (b.y - a.y)},
                            .clear = 3,
                            .group = group};
            tag.weight = weight - 1e-3 * fabs(next - PLACES / 2.); /* the middle first */
            tag.stroke = f->n_source > 1 ? PLOT_ATLAS + 3 * (plot_stroke)s->tint
                                         : plot_branch_family(s->model, branch);
            tag.colour = plot_text_colour(tag.stroke);
            plot_branch_title(branch, k_duplicate, sizeof tag.text, tag.text);
            tag.spare = spare;
            tag.curve = true;
            for (int leader = 0; leader <= (asked && !spare);
                 leader++) { /* at a distance only where there is no room beside the curve */
                plot_tag *place = fep_new_tag(f);
                if (!place) return;
                *place = tag;
                place->leader = leader;
                place->weight -= 60 * leader;
            }
        }
        done += step;
    }
}

/* The internal resonances that a branch follows are named beside it. */
static ric_status tag_tongues(fep *f, const fep_source *s, const ric_branch *branch,
                              const fep_part *part)
{
    int n = 0;
    ric_tongue *tongues = NULL;
    const fep_labels wanted = f->options->labels;
    if (wanted == LABELS_NONE || wanted == LABELS_NAMED || wanted == LABELS_ASKED) return RIC_OK;
    ric_status status = ric_branch_tongues(s->atlas, branch->id, &n, &tongues);
    for (int i = 0; status == RIC_OK && i < n; i++) {
        ric_point p;
        const int middle = tongues[i].first + (tongues[i].last - tongues[i].first + 1) / 2;
        if ((status = ric_atlas_point(s->atlas, branch->id, middle, &p, NULL, NULL)) != RIC_OK)
            break;
        const plot_point at = {p.energy, p.frequency};
        if (tongues[i].crossed) continue;
        if (p.arclength < part->lo || p.arclength > part->hi || !plot_panel_inside(f->panel, at))
            continue;
        plot_tag *tag = fep_new_tag(f);
        if (!tag) break;
        *tag = (plot_tag){.at = plot_panel_at(f->panel, at),
                          .clear = 3,
                          .group = ++f->n_group,
                          .colour = "#6a6a6a"};
        tag->weight = TONGUE_WEIGHT - branch->depth;
        snprintf(tag->text, sizeof tag->text, "%d : %d, mode %d", tongues[i].turns, tongues[i].per,
                 tongues[i].mode);
    }
    ric_tongues_free(tongues);
    return status;
}

/* Interior junctions, so that the curve passes through their marks. A q-tupling lies on its
 * original branch at q times where it is drawn. */
static ric_status add_joints(const fep_source *s, const ric_branch *branch, const fep_part *part,
                             plot_track *t)
{
    for (int i = 0; i < branch->n_junction; i++) {
        ric_junction junction;
        const ric_status status = ric_atlas_junction(s->atlas, branch->junctions[i], &junction);
        if (status != RIC_OK) return status;
        if (branch->junction_at[i] < part->lo || branch->junction_at[i] > part->hi) continue;
        const double frequency = junction.frequency * ric_junction_level(&junction, branch);
        if (!plot_track_join(t, (plot_point){junction.energy, frequency / part->k},
                             branch->junction_at[i]))
            return RIC_E_NOMEM;
    }
    plot_track_sort(t);
    return RIC_OK;
}

/* A part with its joints. */
static ric_status make_track(const fep *f, const fep_source *s, const ric_branch *branch,
                             const fep_part *part, plot_track *t)
{
    for (int i = 0; i < branch->n_point; i++) {
        ric_point p;
        const ric_status status = ric_atlas_point(s->atlas, branch->id, i, &p, NULL, NULL);
        if (status != RIC_OK) return status;
        if (p.arclength < part->lo || p.arclength > part->hi) continue;
        if (!plot_track_add(t, (plot_point){p.energy, p.frequency / part->k}, p.arclength,
                            plot_point_stability(s->atlas, branch, i, &p)))
            return RIC_E_NOMEM;
        if (ric_branch_steps_over(s->atlas, branch->id, i)) plot_track_gap(t);
    }
    const ric_status status = add_joints(s, branch, part, t);
    return status == RIC_OK && !plot_track_smooth(f->panel, t) ? RIC_E_NOMEM : status;
}

/* A band under what no chain of junctions joins to a linear mode. */
static void shade_island(fep *f, const ric_branch *branch, const plot_track *t)
{
    plot_point *line = branch->linked ? NULL : malloc(((size_t)t->n + 1) * sizeof *line);
    int n = 0;
    for (int i = 0; line && i < t->n; i++) {
        line[n++] = t->knots[i].at;
        f->island |= plot_panel_inside(f->panel, t->knots[i].at);
        if (!t->knots[i].gap && i + 1 < t->n) continue;
        plot_panel_curve(f->page, f->panel, PLOT_ISLAND, n, line);
        n = 0;
    }
    free(line);
}

/* A ring at each point with a proof, and none on another. */
static ric_status mark_proofs(fep *f, const fep_source *s, const ric_branch *branch,
                              const fep_part *part)
{
    plot_point last = {-INFINITY, -INFINITY};
    ric_status status = RIC_OK;
    for (int i = 0; branch->n_proved && status == RIC_OK && i < branch->n_point; i++) {
        ric_proof proof;
        ric_point p;
        const char *certificate;
        status = ric_atlas_point(s->atlas, branch->id, i, &p, NULL, NULL);
        const plot_point data = {p.energy, p.frequency};
        if (status != RIC_OK || p.arclength < part->lo || p.arclength > part->hi ||
            !plot_panel_inside(f->panel, data) ||
            !ric_proof_kept(s->atlas, branch->id, i, &proof, &certificate) ||
            proof.state != RIC_PROOF_DONE)
            continue;
        const plot_point at = plot_panel_at(f->panel, data);
        if (hypot(at.x - last.x, at.y - last.y) < 7) continue;
        for (int ring = 0; ring < 2; ring++)
            plot_page_line(f->page, PLOT_PROOF + (plot_stroke)ring, 2,
                           (plot_point[]){at, {at.x + 0.02, at.y}});
        f->proved = true;
        last = at;
    }
    return status;
}

static ric_status draw_original(fep *f, fep_source *s, const ric_branch *branch,
                                const fep_part *part)
{
    plot_track t = {0};
    ric_status status = make_track(f, s, branch, part, &t);
    if (status == RIC_OK) {
        const plot_stroke family = plot_branch_family(s->model, branch);
        shade_island(f, branch, &t);
        const unsigned seen = plot_track_draw(f->page, f->panel,
                                              f->n_source > 1
                                                  ? PLOT_ATLAS + 3 * (plot_stroke)s->tint
                                                  : family,
                                              &t);
        f->family[(family - PLOT_LINEAR) / 3] |= seen != 0;
        s->stability |= seen;
        s->drawn |= seen != 0;
        tag_branch(f, s, branch, 1, &t);
        status = tag_tongues(f, s, branch, part);
        if (status == RIC_OK) status = mark_proofs(f, s, branch, part);
    }
    plot_track_free(&t);
    return status;
}

/* --------------------------------------------------------------- duplicates */

/* From the duplicate before that has this multiplication: j/k = p/q is first met by the
 * q-duplicate, then by each of its multiples. */
static void draw_arrow(fep *f, const fep_source *s, const fep_part *part,
                       const ric_duplicate_point *point)
{
    ric_junction junction;
    if (ric_atlas_junction(s->atlas, point->junction, &junction) != RIC_OK || junction.multiple < 2)
        return;
    const int before = part->k - junction.multiple;
    if (before < junction.multiple) return;
    plot_point a = plot_panel_at(f->panel,
                                 (plot_point){point->energy, point->frequency * part->k / before}),
               b = plot_panel_at(f->panel, (plot_point){point->energy, point->frequency});
    const plot_box box = plot_panel_box(f->panel);
    const double length = hypot(b.x - a.x, b.y - a.y), room = 5, head = 5;
    const bool whole = a.y < box.top + 0.5;
    if (!(length > 3 * room) || !plot_clip_segment(&box, &a, &b)) return;
    const double ux = (b.x - a.x) / hypot(b.x - a.x, b.y - a.y),
                 uy = (b.y - a.y) / hypot(b.x - a.x, b.y - a.y);
    const plot_point tip = {b.x - room * ux, b.y - room * uy},
                     foot = {tip.x - head * ux, tip.y - head * uy};
    if (whole) a = (plot_point){a.x + room * ux, a.y + room * uy};
    plot_page_line(f->page, PLOT_ARROW, 2, (plot_point[]){a, tip});
    plot_page_line(f->page, PLOT_ARROW, 3,
                   (plot_point[]){{foot.x - 0.5 * head * uy, foot.y + 0.5 * head * ux},
                                  tip,
                                  {foot.x + 0.5 * head * uy, foot.y - 0.5 * head * ux}});
    f->arrow = true;
}

/* Small marks where the k-duplicate has multiplications that a duplicate before it has, too; its
 * own are junctions as all others. */
static ric_status mark_inherited(fep *f, const fep_source *s, const ric_branch *branch,
                                 const fep_part *part)
{
    int n = 0;
    ric_duplicate_point *points = calloc((size_t)branch->n_junction + 2, sizeof *points);
    const ric_status status = points
                                  ? ric_duplicate_points(s->atlas, branch->id, part->k, &n, points)
                                  : RIC_E_NOMEM;
    for (int i = 0; status == RIC_OK && i < n; i++) {
        const plot_point at = {points[i].energy, points[i].frequency};
        const double arclength = plot_junction_at(s->atlas, branch, points[i].junction);
        if (points[i].origin != RIC_DUPLICATE_INHERITED || !plot_panel_inside(f->panel, at) ||
            arclength < part->lo || arclength > part->hi)
            continue;
        plot_page_mark(f->page, plot_junction_mark(RIC_KIND_MULTIPLICATION),
                       plot_panel_at(f->panel, at), 2.4);
        if (f->options->arrows) draw_arrow(f, s, part, &points[i]);
        f->kinds[RIC_KIND_MULTIPLICATION] = true;
    }
    free(points);
    return status;
}

static ric_status draw_duplicate(fep *f, fep_source *s, const ric_branch *branch,
                                 const fep_part *part)
{
    plot_track t = {0};
    ric_status status = make_track(f, s, branch, part, &t);
    if (status == RIC_OK) {
        const plot_stroke own = plot_branch_family(s->model, branch),
                          family = f->n_source > 1 ? PLOT_ATLAS + 3 * (plot_stroke)s->tint : own;
        shade_island(f, branch, &t);
        const unsigned seen = plot_track_draw(f->page, f->panel, family - PLOT_DASHED, &t);
        f->duplicate[(own - PLOT_LINEAR) / 3] |= seen != 0;
        s->dashed |= seen;
        s->drawn |= seen != 0;
        tag_branch(f, s, branch, part->k, &t);
    }
    plot_track_free(&t);
    return status != RIC_OK ? status : mark_inherited(f, s, branch, part);
}

ric_status fep_draw_branches(fep *f, fep_source *s)
{
    ric_status status = RIC_OK;
    for (int i = 0; status == RIC_OK && i < s->n_part; i++) {
        ric_branch branch;
        const fep_part *part = &s->parts[i];
        status = ric_atlas_branch(s->atlas, part->branch, &branch);
        if (status == RIC_OK)
            status = part->k == 1 ? draw_original(f, s, &branch, part)
                                  : draw_duplicate(f, s, &branch, part);
    }
    return status;
}

/* ------------------------------------------------------------------- ghosts */

static void widen(double range[2], double value)
{
    range[0] = fmin(range[0], value);
    range[1] = fmax(range[1], value);
}

/* The window in which the ghosts of a branch are followed: what the panels show and, since a ghost
 * may come in from outside, its start. */
static ric_status ghost_window(const fep *f, const fep_source *s, const ric_branch *branch,
                               bool *shown, ric_ghost_limits *limits)
{
    ric_status status = RIC_OK;
    *shown = false;
    ric_ghost_limits_init(s->atlas, limits);
    limits->energy[0] = f->panels[0].x.lo;
    limits->energy[1] = f->panels[0].x.hi;
    limits->frequency[0] = f->panels[0].y.lo;
    limits->frequency[1] = f->panels[0].y.hi;
    for (int k = 0; k < s->n_part; k++) {
        if (s->parts[k].branch != branch->id) continue;
        limits->multiply = (int)fmax(limits->multiply, s->parts[k].k);
        widen(limits->frequency, f->panels[0].y.hi * s->parts[k].k);
        for (int i = 0; status == RIC_OK && i < branch->n_point; i++) {
            ric_point p;
            status = ric_atlas_point(s->atlas, branch->id, i, &p, NULL, NULL);
            *shown |= status == RIC_OK &&
                      plot_panel_inside(&f->panels[0],
                                        (plot_point){p.energy, p.frequency / s->parts[k].k});
            if (status == RIC_OK && (i == 0 || i == branch->n_point - 1)) {
                widen(limits->energy, p.energy);
                widen(limits->frequency, p.frequency);
            }
        }
    }
    return status;
}

ric_status fep_find_ghosts(fep *f, fep_source *s)
{
    const int total = ric_atlas_n_branch(s->atlas);
    int failed = 0;
    ric_status status = (s->ghosts = calloc((size_t)total + 1, sizeof *s->ghosts)) ? RIC_OK
                                                                                   : RIC_E_NOMEM;
    for (int id = 1; status == RIC_OK && id <= total; id++) {
        ric_branch branch;
        ric_ghost_limits limits;
        bool shown;
        status = ric_atlas_branch(s->atlas, id, &branch);
        if (status != RIC_OK || (status = ghost_window(f, s, &branch, &shown, &limits)) != RIC_OK ||
            !shown)
            continue;
        status = ric_ghost_find(s->atlas, id, &limits, &s->ghosts[id - 1].n,
                                &s->ghosts[id - 1].list);
        if (status == RIC_E_NUMERIC) { /* one missing ghost is no reason to have no picture */
            failed++;
            status = RIC_OK;
        }
    }
    if (failed)
        cli_say("ricochet: the ghosts of %d branch%s could not be computed and are not drawn\n",
                failed, failed == 1 ? "" : "es");
    return status;
}

/* Multiplications p/q that the k-duplicate of a ghost shows, q | k. */
static void mark_ghost(fep *f, const ric_ghost *ghost, int k)
{
    for (int i = 0; i < ric_ghost_n_multiplication(ghost); i++) {
        ric_ghost_multiplication m;
        if (ric_ghost_multiplication_at(ghost, i, &m) != RIC_OK || m.admissible ||
            k % m.rotation[1])
            continue;
        const plot_point at = {m.energy, m.frequency / k};
        if (plot_panel_inside(f->panel, at))
            plot_page_mark(f->page, PLOT_STAR, plot_panel_at(f->panel, at),
                           k == m.rotation[1] ? 4.4 : 2.4);
    }
}

static ric_status draw_ghost(fep *f, const ric_ghost *ghost, int k)
{
    ric_ghost_data data;
    ric_status status = RIC_OK;
    ric_ghost_describe(ghost, &data);
    plot_point *curve = malloc(((size_t)data.n_point + 1) * sizeof *curve);
    if (!curve) return RIC_E_NOMEM;
    for (int i = 0; status == RIC_OK && i < data.n_point; i++) {
        ric_point p;
        status = ric_ghost_point(ghost, i, &p, NULL, NULL);
        if (status != RIC_OK) break;
        /* where it is a motion again it is no ghost */
        curve[i] = (plot_point){p.energy, ric_point_admissible(&p) ? NAN : p.frequency / k};
        f->ghost |= i > 0 && plot_panel_inside(f->panel, curve[i]);
    }
    if (status == RIC_OK)
        plot_panel_curve(f->page, f->panel, PLOT_GHOST + (k > 1), data.n_point, curve);
    if (status == RIC_OK && k > 1) mark_ghost(f, ghost, k);
    free(curve);
    return status;
}

ric_status fep_draw_ghosts(fep *f, fep_source *s)
{
    ric_status status = RIC_OK;
    for (int i = 0; s->ghosts && i < s->n_part; i++)
        for (int k = 0; status == RIC_OK && k < s->ghosts[s->parts[i].branch - 1].n; k++)
            status = draw_ghost(f, s->ghosts[s->parts[i].branch - 1].list[k], s->parts[i].k);
    return status;
}
