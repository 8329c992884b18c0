#include "base/room.h"
#include "rows_parts.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "model/room.h"
#include "orbit/room.h"

#define LINEAR_POINTS 9
/* BORDER: of a trace: nearer to 2 or -2 it may be that of a place where branches meet */
#define BORDER 1e-5

/* The operation that takes an edge's chain to its canonical word; found once, away from the ends.
 */
static bool canonical_turn(const ric_model *m, const ric_edge *e, ric_turn *out)
{
    const ric_continuation *tr = e->trace;
    const double *p = tr->points + (size_t)(tr->n_point / 2) * tr->stride +
                      sizeof(ric_point) / sizeof(double);
    ric_shooting_fly(tr->chain, p);
    ric_periodic *cycle = ric_periodic_from_chain(tr->chain, p),
                 *canonical = cycle ? ric_periodic_canonical(m, cycle) : NULL;
    bool found = canonical && ric_periodic_match(m, canonical, cycle, RIC_SAME_SOLVED, out);
    ric_periodic_free(cycle);
    ric_periodic_free(canonical);
    return found;
}

static char *mirror_text(const ric_shooting *c)
{
    static const char *const names[] = {"", "rest", "impact", "centre"};
    char text[32];
    if (c->start == RIC_MIRROR_NONE) return ric_strdup("");
    const char *a = names[c->start], *b = names[c->end];
    bool swap = strcmp(a, b) > 0;
    snprintf(text, sizeof text, "%s-%s", swap ? b : a, swap ? a : b);
    return ric_strdup(text);
}

/* S2+[01], A5[00101], S2(3)[01]; the mark of the mode only on backbones. */
static char *branch_label(const ric_model *m, const ric_branch *b)
{
    size_t size = 64 + 5 * (size_t)b->letters;
    char *text = ric_malloc(size), mark[16] = "";
    if (!text) return NULL;
    if (b->mode > 0) {
        if (m->n_dof == 2 && m->n == 2) snprintf(mark, sizeof mark, "%s", b->mode == 1 ? "+" : "-");
        else snprintf(mark, sizeof mark, "(%d)", b->mode);
    }
    char count[16] = "";
    if (ric_model_detached(m) || ric_branch_linear(m, b))
        snprintf(count, sizeof count, "%d", b->impacts);
    int used = snprintf(text, size, "%s%s%s", b->symmetric ? "S" : "A", count, mark);
    if (b->impacts > 0) {
        text[used++] = '[';
        ric_word_format(m, b->letters, b->word, size - (size_t)used - 2, text + used);
        strcat(text, "]");
    }
    return text;
}

/* The part of the way from a to b on which a line between them lies below a limit. */
static double part_below(double a, double b, double limit)
{
    if (a <= limit && b <= limit) return 1;
    if (a > limit && b > limit) return 0;
    double part = (limit - a) / (b - a);
    return a <= limit ? part : 1 - part;
}

/* The arclength between two points on which the branch is stable. For two modes the trace passes 2
 * or -2 at the border, wherever the points lie; else stability changes at the first junction
 * between them, or half way. A point that is undecided lies on the border and says nothing of its
 * neighbours. */
static double stable_between(const ric_branch *b, const ric_point *q, const ric_point *p)
{
    double length = p->arclength - q->arclength, edge = asinh(1),
           change = q->arclength + length / 2;
    if (isfinite(q->trace) && isfinite(p->trace))
        return length *
               (part_below(q->trace, p->trace, edge) - part_below(q->trace, p->trace, -edge));
    if (p->stable == RIC_STABLE_UNDECIDED) change = p->arclength;
    else if (q->stable == RIC_STABLE_UNDECIDED) change = q->arclength;
    else
        for (int k = b->n_junction - 1; k >= 0; k--)
            if (b->junction_at[k] >= q->arclength && b->junction_at[k] <= p->arclength)
                change = b->junction_at[k];
    return (q->stable == RIC_STABLE_YES) * (change - q->arclength) +
           (p->stable == RIC_STABLE_YES) * (p->arclength - change);
}

/* Ranges over the stored points, and the share of the arclength that is stable, of what is decided:
 * where a trace is +-2 all along, or lost, rounding would say something. */
static void summarise(ric_branch_record *r)
{
    ric_branch *b = &r->row;
    double stable = 0, length = 0;
    b->energy_min = b->frequency_min = HUGE_VAL;
    b->energy_max = b->frequency_max = -HUGE_VAL;
    for (int i = 0; i < b->n_point; i++) {
        const ric_point *p = (const ric_point *)(r->points + (size_t)i * r->stride);
        b->energy_min = fmin(b->energy_min, p->energy);
        b->energy_max = fmax(b->energy_max, p->energy);
        b->frequency_min = fmin(b->frequency_min, p->frequency);
        b->frequency_max = fmax(b->frequency_max, p->frequency);
        if (!i) continue;
        const ric_point *q = (const ric_point *)(r->points + (size_t)(i - 1) * r->stride);
        if (q->stable == RIC_STABLE_UNDECIDED && p->stable == RIC_STABLE_UNDECIDED) continue;
        length += p->arclength - q->arclength;
        stable += stable_between(b, q, p);
    }
    b->stable_fraction = length > 0 ? stable / length : NAN;
}

/* Extrema of energy and of period are junctions, or so close to a multiplication that they cannot
 * be told from it: with the junctions the ranges are those of the branch, and not of the points
 * that its steps happen to store. A branch that passes an orbit of fewer letters goes through it
 * several times. */
static void extend_ranges(const ric_graph *g, const ric_edge *e, ric_branch *b)
{
    for (int k = 0; k < e->n_inner; k++) {
        const ric_node *node = g->nodes[e->inner[k].node];
        int letters = ric_periodic_letters(node->cycle),
            times = letters > 0 ? b->letters / letters : 1;
        double energy = node->energy * g->model->energy_unit,
               frequency = RIC_TWO_PI / (node->period * times) * g->model->omega_ref;
        b->energy_min = fmin(b->energy_min, energy);
        b->energy_max = fmax(b->energy_max, energy);
        if (!ric_model_detached(g->model) || times < 1) continue;
        b->frequency_min = fmin(b->frequency_min, frequency);
        b->frequency_max = fmax(b->frequency_max, frequency);
    }
}

/* The flag of an orbit as its multipliers tell that are computed from where it starts, over the
 * period or half of it. */
static ric_status flag_of(const ric_model *m, const ric_periodic *cycle, int32_t *stable)
{
    ric_floquet floquet = {0};
    ric_shooting *c = NULL;
    double *u = NULL;
    ric_status status = ric_periodic_to_chain(m, cycle, &c, &u);
    if (!status) status = ric_floquet_create(c->n, &floquet);
    if (!status) status = ric_continuation_multipliers(c, u, &floquet);
    if (!status) *stable = (int32_t)floquet.stable;
    ric_floquet_release(&floquet);
    ric_shooting_free(c);
    free(u);
    return status;
}

/* What was left undecided, once more as the stored orbit is read: a map that begins at a slow
 * impact may have lost what another one knows. It stays undecided where that one knows no more. */
static ric_status decide(const ric_model *m, ric_shooting *traced, const double *u,
                         const ric_turn *t, int32_t *stable)
{
    ric_periodic *cycle = ric_turn_cycle(m, traced, u, t);
    ric_status status = cycle ? flag_of(m, cycle, stable) : ric_no_rows();
    if (!status && *stable == RIC_STABLE_UNDECIDED && cycle->half) {
        cycle->half = false;
        status = flag_of(m, cycle, stable);
    }
    ric_periodic_free(cycle);
    return status;
}

/* Whether a trace of two modes is clear of where branches meet, and flags are undecided by
 * definition. */
static bool off_border(const ric_model *m, const ric_point *p)
{
    return m->n == 2 && fabs(fabs(ric_point_trace(p)) - 2) > BORDER;
}

static ric_status fill_points(const ric_model *m, const ric_edge *e, const ric_turn *t,
                              ric_branch_record *r)
{
    const ric_continuation *tr = e->trace;
    ric_status status = RIC_OK;
    for (int i = 0; i < tr->n_point && !status; i++) {
        const double *in = tr->points + (size_t)i * tr->stride;
        double *out = r->points + (size_t)i * r->stride,
               *x = out + sizeof(ric_point) / sizeof(double), *v = x + m->n_dof;
        const double *u = in + sizeof(ric_point) / sizeof(double);
        ric_point *point = (ric_point *)out;
        memcpy(out, in, sizeof(ric_point));
        status = ric_turn_write(m, tr->chain, u, t, x, v, v + m->n_dof);
        const bool asked = tr->chain->start == RIC_MIRROR_NONE || off_border(m, point);
        if (!status && point->stable == RIC_STABLE_UNDECIDED && asked)
            status = decide(m, tr->chain, u, t, &point->stable);
    }
    return status;
}

/* The backbone of a linear mode leaves where the mode itself grazes; what leaves there after
 * several periods has the same node mode. */
static int backbone_mode(const ric_graph *g, const ric_edge *e)
{
    const int ends[] = {e->from, e->to};
    if (!ric_model_detached(g->model)) return e->mode >= 0 ? g->model->mode[e->mode] + 1 : 0;
    for (int i = 0; i < 2; i++)
        if (e->mode >= 0 && ends[i] >= 0 && g->nodes[ends[i]]->mode == e->mode &&
            g->nodes[ends[i]]->multiple == 1)
            return g->model->mode[e->mode] + 1;
    return 0;
}

static ric_status note_gaps(const ric_continuation *tr, ric_branch_record *r)
{
    r->gaps = ric_calloc((size_t)tr->n_gap + 1, sizeof *r->gaps);
    if (!r->gaps) return ric_no_rows();
    r->n_gap = tr->n_gap;
    for (int i = 0; i < tr->n_gap; i++)
        r->gaps[i] = (ric_atlas_gap){.point = tr->gaps[i].point,
                                     .mode = tr->gaps[i].mode,
                                     .turns = tr->gaps[i].turns,
                                     .others = tr->gaps[i].others};
    return RIC_OK;
}

ric_status ric_branch_row_make(const ric_graph *g, const ric_edge *e, ric_branch_row *out)
{
    const ric_model *m = g->model;
    const ric_continuation *tr = e->trace;
    ric_branch_record *r = &out->record;
    ric_turn t;
    ric_shooting_fly(tr->chain, tr->points + sizeof(ric_point) / sizeof(double));
    ric_periodic *cycle = ric_periodic_from_chain(tr->chain,
                                                  tr->points + sizeof(ric_point) / sizeof(double)),
                 *turned = NULL;
    if (!cycle) return ric_no_rows();
    if (!canonical_turn(m, e, &t)) t = (ric_turn){0, false, false};
    turned = ric_periodic_transform(m, cycle, t.shift, t.reverse, t.mirror);
    int N = ric_periodic_letters(cycle);
    *r = (ric_branch_record){.stride = ric_atlas_point_stride(m->n_dof, N)};
    r->points = ric_malloc((size_t)tr->n_point * r->stride * sizeof(double));
    r->word = turned ? ric_malloc(((size_t)N + 1) * sizeof *r->word) : NULL;
    r->mirror = mirror_text(tr->chain);
    r->why = ric_branch_row_why(e);
    if (turned && r->word) ric_periodic_word(m, turned, r->word);
    r->row = (ric_branch){.impacts = ric_periodic_impacts(ric_periodic_springs(m), cycle),
                          .letters = N,
                          .word = r->word,
                          .symmetric = cycle->half,
                          .reversible = cycle->pure >= 0 || cycle->flip >= 0,
                          .mirror = r->mirror,
                          .n_point = tr->n_point,
                          .stop = tr->stop,
                          .why = r->why,
                          .depth = e->depth,
                          .mode = backbone_mode(g, e),
                          .n_junction = e->n_inner};
    r->junctions = ric_calloc((size_t)e->n_inner + 1, sizeof *r->junctions);
    r->junction_at = ric_calloc((size_t)e->n_inner + 1, sizeof *r->junction_at);
    ric_periodic_free(cycle);
    ric_periodic_free(turned);
    if (!r->points || !r->word || !r->mirror || !r->why || !r->junctions || !r->junction_at)
        return ric_no_rows();
    for (int k = 0; k < e->n_inner; k++) r->junction_at[k] = e->inner[k].at;
    r->row.junctions = r->junctions;
    r->row.junction_at = r->junction_at;
    if (!(r->label = branch_label(m, &r->row))) return ric_no_rows();
    r->row.label = r->label;
    out->from = e->from;
    out->to = e->to;
    out->edge = e;
    ric_status status = fill_points(m, e, &t, r);
    if (!status) status = note_gaps(tr, r);
    if (status) return status;
    summarise(r);
    extend_ranges(g, e, &r->row);
    return RIC_OK;
}

ric_status ric_branch_row_linear(const ric_model *m, const ric_explore_options *o, int mode,
                                 int seen, int node, double energy, ric_branch_row *out)
{
    ric_branch_record *r = &out->record;
    int n = m->n_dof;
    double omega = m->frequency[mode];
    double top = fmin(energy, o->energy[1]);
    *r = (ric_branch_record){.stride = ric_atlas_point_stride(n, 0)};
    r->points = ric_calloc((size_t)LINEAR_POINTS * r->stride, sizeof(double));
    r->word = ric_calloc(1, sizeof *r->word);
    r->junctions = ric_calloc(RIC_USER_POINTS_MAX, sizeof *r->junctions);
    r->junction_at = ric_calloc(RIC_USER_POINTS_MAX, sizeof *r->junction_at);
    r->mirror = ric_strdup("centre-rest");
    r->why = ric_strdup(node >= 0  ? ""
                        : seen < 0 ? "no contact sees this mode"
                                   : "upper end of the energy window");
    if (!r->points || !r->word || !r->junctions || !r->junction_at || !r->mirror || !r->why)
        return ric_no_rows();
    r->row = (ric_branch){.word = r->word,
                          .symmetric = true,
                          .reversible = true,
                          .mirror = r->mirror,
                          .n_point = LINEAR_POINTS,
                          .stop = node >= 0 ? RIC_STOP_JUNCTION : RIC_STOP_WINDOW,
                          .why = r->why,
                          .mode = mode + 1,
                          .junctions = r->junctions,
                          .junction_at = r->junction_at};
    for (int i = 0; i < LINEAR_POINTS; i++) {
        double part = (double)i / (LINEAR_POINTS - 1), E = top * part * part,
               *x = r->points + (size_t)i * r->stride + sizeof(ric_point) / sizeof(double);
        ric_point *p = (ric_point *)(r->points + (size_t)i * r->stride);
        double q = ric_linear_amplitude(omega, E);
        double rotation = NAN;
        for (int k = 0; m->n == 2 && k < 2; k++)
            if (m->mode[k] != mode) rotation = fmod(m->frequency[m->mode[k]] / omega, 1);
        *p = (ric_point){.arclength = q,
                         .energy = E,
                         .frequency = omega,
                         .rotation = rotation,
                         .trace = m->n == 2 && seen >= 0 ? asinh(cos(RIC_TWO_PI * rotation)) : NAN,
                         .reach = isfinite(energy) ? sqrt(E / energy) : 0,
                         .approach = NAN,
                         .residual = 0,
                         .stable = RIC_STABLE_YES};
        for (int j = 0; j < n; j++) x[j] = m->Phi[j * n + mode] * q;
        x[2 * n] = RIC_TWO_PI / omega;
    }
    if (!(r->label = branch_label(m, &r->row))) return ric_no_rows();
    r->row.label = r->label;
    out->from = -1;
    out->to = node;
    summarise(r);
    r->row.stable_fraction = 1;
    return RIC_OK;
}

static int compare_words(const ric_branch *a, const ric_branch *b)
{
    if (a->impacts != b->impacts) return a->impacts - b->impacts;
    if (a->letters != b->letters) return a->letters - b->letters;
    for (int i = 0; i < a->letters; i++)
        if (a->word[i] != b->word[i]) return a->word[i] - b->word[i];
    return 0;
}

int ric_branch_row_order(const void *p, const void *q)
{
    const ric_branch *a = &((const ric_branch_row *)p)->record.row,
                     *b = &((const ric_branch_row *)q)->record.row;
    int order;
    bool linear[2] = {((const ric_branch_row *)p)->edge == NULL,
                      ((const ric_branch_row *)q)->edge == NULL};
    if (linear[0] && linear[1]) return a->mode - b->mode;
    if (linear[0] != linear[1]) return linear[0] ? -1 : 1;
    if (a->impacts == 0 && !a->mode != !b->mode) return a->mode ? -1 : 1;
    if (a->impacts == 0 && a->mode && a->mode != b->mode) return a->mode - b->mode;
    if (!a->impacts != !b->impacts) return a->impacts ? 1 : -1;
    if (a->depth != b->depth) return a->depth - b->depth;
    if ((order = compare_words(a, b))) return order;
    if ((order = ric_compare_numbers(a->energy_min, b->energy_min))) return order;
    if ((order = ric_compare_numbers(a->frequency_min, b->frequency_min))) return order;
    if ((order = ric_compare_numbers(a->energy_max, b->energy_max))) return order;
    if ((order = strcmp(a->mirror, b->mirror))) return order;
    for (int i = 0; i < 4 && !order; i++)
        order = ((const ric_branch_row *)p)->ends[i] - ((const ric_branch_row *)q)->ends[i];
    return order;
}
