#include "chart.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "motion.h"
#include "multiplicity.h"
#include "status.h"
#include "stored.h"

#define TWO_PI 6.283185307179586477
#define LINEAR_POINTS 9

static ric_status no_memory(void)
{
    return ric_fail(RIC_E_NOMEM, "no memory for the atlas");
}

/* ------------------------------------------------------------------ branches */

typedef struct {
    ric_branch_record record;
    int from, to;      /* nodes */
    const ric_edge *edge;
    int user;          /* first of the marks on a linear mode, in the numbering of nodes */
    int ends[4];       /* ids of the junctions and ways out of them, which tell apart what is alike in all else */
} sheet;

/* The node number k that a branch passes. */
static int passed(const sheet *s, int k)
{
    return s->edge ? s->edge->inner[k].node : s->user + k;
}

/* The operation that takes an edge's chain to its canonical word; found once, away from the ends. */
static bool canonical_turn(const ric_model *m, const ric_edge *e, ric_turn *out)
{
    const ric_trace *tr = e->trace;
    const double *p = tr->points + (size_t)(tr->n_point / 2) * tr->stride + sizeof(ric_point) / sizeof(double);
    ric_chain_fly(tr->chain, p);
    ric_cycle *cycle = ric_cycle_from_chain(tr->chain, p), *canonical = cycle ? ric_cycle_canonical(m, cycle) : NULL;
    bool found = canonical && ric_cycle_match(m, canonical, cycle, 1e-9, &out->shift, &out->reverse, &out->mirror);
    ric_cycle_free(cycle);
    ric_cycle_free(canonical);
    return found;
}

static char *mirror_text(const ric_chain *c)
{
    static const char *const names[] = {"", "rest", "impact", "centre"};
    char text[32];
    if (c->start == RIC_MIRROR_NONE) return strdup("");
    const char *a = names[c->start], *b = names[c->end];
    bool swap = strcmp(a, b) > 0;
    snprintf(text, sizeof text, "%s-%s", swap ? b : a, swap ? a : b);
    return strdup(text);
}

/* S2+[01], A5[00101], S2(3)[01]; the mark of the mode only on backbones. */
static char *branch_label(const ric_model *m, const ric_branch *b)
{
    size_t size = 64 + 5 * (size_t)b->letters;
    char *text = malloc(size), mark[16] = "";
    if (!text) return NULL;
    if (b->mode > 0) {
        if (m->n_dof == 2 && m->n == 2) snprintf(mark, sizeof mark, "%s", b->mode == 1 ? "+" : "-");
        else snprintf(mark, sizeof mark, "(%d)", b->mode);
    }
    char count[16] = "";
    if (!m->smooth || ric_branch_linear(m, b)) snprintf(count, sizeof count, "%d", b->impacts);
    int used = snprintf(text, size, "%s%s%s", b->symmetric ? "S" : "A", count, mark);
    if (b->impacts > 0) {
        text[used++] = '[';
        ric_word_format(m, b->letters, b->word, size - (size_t)used - 2, text + used);
        strcat(text, "]");
    }
    return text;
}

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
        double step = p->arclength - q->arclength;
        length += step;
        stable += step * ((p->stable == RIC_STABLE_YES) + (q->stable == RIC_STABLE_YES)) / 2;
    }
    b->stable_fraction = length > 0 ? stable / length : 0;
}

static ric_status fill_points(const ric_model *m, const ric_edge *e, const ric_turn *t, ric_branch_record *r)
{
    const ric_trace *tr = e->trace;
    ric_status status = RIC_OK;
    for (int i = 0; i < tr->n_point && !status; i++) {
        const double *in = tr->points + (size_t)i * tr->stride;
        double *out = r->points + (size_t)i * r->stride, *x = out + sizeof(ric_point) / sizeof(double),
               *v = x + m->n_dof;
        memcpy(out, in, sizeof(ric_point));
        status = ric_turn_write(m, tr->chain, in + sizeof(ric_point) / sizeof(double), t, x, v, v + m->n_dof);
    }
    return status;
}

/* The backbone of a linear mode leaves where the mode itself grazes; what leaves there after several periods has the
 * same node mode. */
static int backbone_mode(const ric_graph *g, const ric_edge *e)
{
    const int ends[] = {e->from, e->to};
    if (g->model->smooth) return e->mode >= 0 ? g->model->mode[e->mode] + 1 : 0;
    for (int i = 0; i < 2; i++)
        if (e->mode >= 0 && ends[i] >= 0 && g->nodes[ends[i]]->mode == e->mode && g->nodes[ends[i]]->multiple == 1)
            return g->model->mode[e->mode] + 1;
    return 0;
}

/* Why a branch ends, and how many events on it make no junction. */
static char *branch_why(const char *why, int n_unplaced)
{
    size_t size = strlen(why) + 80;
    char *text = malloc(size);
    if (!text) return NULL;
    int used = snprintf(text, size, "%s", why);
    if (n_unplaced)
        snprintf(text + used, size - (size_t)used, "%s%d event%s on it do%s not converge to a junction",
                 *why ? "; " : "", n_unplaced, n_unplaced == 1 ? "" : "s", n_unplaced == 1 ? "es" : "");
    return text;
}

static ric_status make_sheet(const ric_graph *g, const ric_edge *e, sheet *out)
{
    const ric_model *m = g->model;
    const ric_trace *tr = e->trace;
    ric_branch_record *r = &out->record;
    ric_turn t;
    ric_chain_fly(tr->chain, tr->points + sizeof(ric_point) / sizeof(double));
    ric_cycle *cycle = ric_cycle_from_chain(tr->chain, tr->points + sizeof(ric_point) / sizeof(double)), *turned = NULL;
    if (!cycle) return no_memory();
    if (!canonical_turn(m, e, &t)) t = (ric_turn){0, false, false};
    turned = ric_cycle_transform(m, cycle, t.shift, t.reverse, t.mirror);
    int N = ric_cycle_letters(cycle);
    *r = (ric_branch_record){.stride = ric_point_stride(m->n_dof, N)};
    r->points = malloc((size_t)tr->n_point * r->stride * sizeof(double));
    r->word = turned ? malloc(((size_t)N + 1) * sizeof *r->word) : NULL;
    r->mirror = mirror_text(tr->chain);
    r->why = branch_why(tr->why ? tr->why : "", e->n_unplaced);
    if (turned && r->word) ric_cycle_word(m, turned, r->word);
    r->row = (ric_branch){.impacts = ric_cycle_impacts(ric_cycle_springs(m), cycle), .letters = N, .word = r->word,
                          .symmetric = cycle->half, .reversible = cycle->pure >= 0 || cycle->flip >= 0,
                          .mirror = r->mirror, .n_point = tr->n_point, .stop = tr->stop, .why = r->why,
                          .depth = e->depth, .mode = backbone_mode(g, e), .n_junction = e->n_inner};
    r->junctions = calloc((size_t)e->n_inner + 1, sizeof *r->junctions);
    r->junction_at = calloc((size_t)e->n_inner + 1, sizeof *r->junction_at);
    ric_cycle_free(cycle);
    ric_cycle_free(turned);
    if (!r->points || !r->word || !r->mirror || !r->why || !r->junctions || !r->junction_at) return no_memory();
    for (int k = 0; k < e->n_inner; k++) r->junction_at[k] = e->inner[k].at;
    r->row.junctions = r->junctions;
    r->row.junction_at = r->junction_at;
    if (!(r->label = branch_label(m, &r->row))) return no_memory();
    r->row.label = r->label;
    out->from = e->from;
    out->to = e->to;
    out->edge = e;
    ric_status status = fill_points(m, e, &t, r);
    if (!status) summarise(r);
    return status;
}

/* E = omega^2 q^2 / 2, lengths scaled */
static double linear_amplitude(double omega, double energy)
{
    return sqrt(2 * energy) / omega;
}

/* A linear mode from rest to where it touches (or to the end of the energy window): states at its mirror point. */
static ric_status make_linear(const ric_model *m, const ric_explore_options *o, int mode, int seen, int node,
                              double energy, sheet *out)
{
    ric_branch_record *r = &out->record;
    int n = m->n_dof;
    double omega = m->frequency[mode];
    double top = fmin(energy, o->energy[1]);
    *r = (ric_branch_record){.stride = ric_point_stride(n, 0)};
    r->points = calloc((size_t)LINEAR_POINTS * r->stride, sizeof(double));
    r->word = calloc(1, sizeof *r->word);
    r->junctions = calloc(RIC_ASKED_MAX, sizeof *r->junctions);
    r->junction_at = calloc(RIC_ASKED_MAX, sizeof *r->junction_at);
    r->mirror = strdup("centre-rest");
    r->why = strdup(node >= 0 ? "" : seen < 0 ? "no contact sees this mode" : "upper end of the energy window");
    if (!r->points || !r->word || !r->junctions || !r->junction_at || !r->mirror || !r->why) return no_memory();
    r->row = (ric_branch){.word = r->word, .symmetric = true, .reversible = true, .mirror = r->mirror,
                          .n_point = LINEAR_POINTS, .stop = node >= 0 ? RIC_STOP_JUNCTION : RIC_STOP_WINDOW,
                          .why = r->why, .mode = mode + 1, .junctions = r->junctions, .junction_at = r->junction_at};
    for (int i = 0; i < LINEAR_POINTS; i++) {
        double part = (double)i / (LINEAR_POINTS - 1), E = top * part * part,
               *x = r->points + (size_t)i * r->stride + sizeof(ric_point) / sizeof(double);
        ric_point *p = (ric_point *)(r->points + (size_t)i * r->stride);
        double q = linear_amplitude(omega, E);
        double rotation = NAN;
        for (int k = 0; m->n == 2 && k < 2; k++)
            if (m->mode[k] != mode) rotation = fmod(m->frequency[m->mode[k]] / omega, 1);
        *p = (ric_point){.arclength = q, .energy = E, .frequency = omega, .rotation = rotation,
                         .trace = m->n == 2 && seen >= 0 ? asinh(cos(TWO_PI * rotation)) : NAN,
                         .reach = isfinite(energy) ? sqrt(E / energy) : 0, .approach = NAN, .residual = 0,
                         .stable = RIC_STABLE_YES};
        for (int j = 0; j < n; j++) x[j] = m->Phi[j * n + mode] * q;
        x[2 * n] = TWO_PI / omega;
    }
    if (!(r->label = branch_label(m, &r->row))) return no_memory();
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

static int compare_numbers(double a, double b)
{
    if (fabs(a - b) <= 1e-9 * (fabs(a) + fabs(b))) return 0;
    return a < b ? -1 : 1;
}

static int sheet_order(const void *p, const void *q)
{
    const ric_branch *a = &((const sheet *)p)->record.row, *b = &((const sheet *)q)->record.row;
    int order;
    bool linear[2] = {((const sheet *)p)->edge == NULL, ((const sheet *)q)->edge == NULL};
    if (linear[0] && linear[1]) return a->mode - b->mode;
    if (linear[0] != linear[1]) return linear[0] ? -1 : 1;
    if (a->impacts == 0 && !a->mode != !b->mode) return a->mode ? -1 : 1;
    if (a->impacts == 0 && a->mode && a->mode != b->mode) return a->mode - b->mode;
    if (!a->impacts != !b->impacts) return a->impacts ? 1 : -1;
    if (a->depth != b->depth) return a->depth - b->depth;
    if ((order = compare_words(a, b))) return order;
    if ((order = compare_numbers(a->energy_min, b->energy_min))) return order;
    if ((order = compare_numbers(a->frequency_min, b->frequency_min))) return order;
    if ((order = compare_numbers(a->energy_max, b->energy_max))) return order;
    if ((order = strcmp(a->mirror, b->mirror))) return order;
    for (int i = 0; i < 4 && !order; i++) order = ((const sheet *)p)->ends[i] - ((const sheet *)q)->ends[i];
    return order;
}

/* ----------------------------------------------------------------- junctions */

typedef struct {
    ric_junction_record record;
    const ric_node *node;
    int index;
} mark;

static const char *letter(ric_kind kind)
{
    switch (kind) {
    case RIC_KIND_GRAZING: return "G";
    case RIC_KIND_CORNER: return "K";
    case RIC_KIND_PERIOD_EXTREMUM: return "P";
    case RIC_KIND_START: return "O";
    case RIC_KIND_USER: return "U";
    default: return "C";
    }
}

static void count_departures(const ric_node *node, ric_junction_record *r)
{
    ric_departures *d = &r->row.departures;
    for (int i = 0; i < node->n_departure; i++) switch (node->departures[i].state) {
        case RIC_DEPARTURE_TAKEN: d->taken++; break;
        case RIC_DEPARTURE_KNOWN: d->known++; break;
        case RIC_DEPARTURE_INADMISSIBLE: d->inadmissible++; break;
        case RIC_DEPARTURE_REFUSED: d->refused++; break;
        default:
            d->over_budget++;
            d->over[node->departures[i].budget % RIC_N_BUDGET]++;
        }
}

static char *refusals(const ric_node *node)
{
    const char *why = ric_refusal_text(node->refusal);
    for (int i = 0; i < node->n_departure; i++)
        if (node->departures[i].why && !*why) why = node->departures[i].why;
    return strdup(why);
}

/* The orbit of a junction without touches, over its own period also where the junction is a duplicate; *bare: no impact
 * is left. */
static ric_cycle *original_orbit(const ric_model *m, const ric_node *node, bool *bare)
{
    ric_cycle *regular = ric_node_regular(m, node), *once = NULL, *canonical = NULL;
    *bare = !regular;
    if (regular && node->kind == RIC_KIND_GRAZING && node->multiple > 1) {
        once = ric_cycle_shorten(regular, node->multiple);
        canonical = once ? ric_cycle_canonical(m, once) : NULL;
    } else if (regular) canonical = ric_cycle_canonical(m, regular);
    ric_cycle_free(regular);
    ric_cycle_free(once);
    return canonical;
}

static ric_status make_mark(const ric_model *m, const ric_node *node, int index, mark *out)
{
    ric_status status = RIC_OK;
    ric_junction_record *r = &out->record;
    int n = m->n_dof;
    bool bare;
    ric_cycle *cycle = original_orbit(m, node, &bare);
    int N = cycle ? ric_cycle_letters(cycle) : 0;
    *out = (mark){.node = node, .index = index};
    r->word = calloc((size_t)N + 1, sizeof *r->word);
    r->state = calloc(2 * (size_t)n, sizeof *r->state);
    r->flights = calloc((size_t)N + 1, sizeof *r->flights);
    r->refusal = refusals(node);
    if (!r->word || !r->state || !r->flights || !r->refusal || (!bare && !cycle)) {
        status = no_memory();
        goto out;
    }
    ric_model_to_state(m, cycle ? cycle->w : node->cycle->w, r->state, r->state + n);
    if (cycle) ric_cycle_word(m, cycle, r->word);
    for (int i = 0; i < N; i++) {
        r->flights[i] = cycle->tau[i] / m->omega_ref;
    }
    if (!N) r->flights[0] = node->period / m->omega_ref;
    r->row = (ric_junction){.kind = node->kind, .impacts = cycle ? ric_cycle_impacts(node->springs, cycle) : 0,
                            .letters = N, .word = r->word,
                            .grazings = node->kind == RIC_KIND_GRAZING ? node->n_touch : 0, .multiple = node->multiple,
                            .rotation = {node->rotation[0], node->rotation[1]}, .energy = node->energy * m->energy_unit,
                            .state = r->state, .flights = r->flights, .refusal = r->refusal};
    r->row.frequency = TWO_PI / node->period * m->omega_ref / r->row.multiple;
    count_departures(node, r);
out:
    ric_cycle_free(cycle);
    return status;
}

/* The linear motion of a mode at an energy that was asked for; its contacts may not see it, so that it is no node of
 * the graph. */
static ric_status mark_linear(const ric_model *m, int mode, double energy, int index, mark *out)
{
    ric_junction_record *r = &out->record;
    int n = m->n_dof;
    double omega = m->frequency[mode];
    *out = (mark){.index = index};
    r->word = calloc(1, sizeof *r->word);
    r->state = calloc(2 * (size_t)n, sizeof *r->state);
    r->flights = calloc(1, sizeof *r->flights);
    r->refusal = strdup("");
    if (!r->word || !r->state || !r->flights || !r->refusal) return no_memory();
    for (int i = 0; i < n; i++) r->state[i] = m->Phi[i * n + mode] * linear_amplitude(omega, energy);
    r->flights[0] = TWO_PI / omega;
    r->row = (ric_junction){.kind = RIC_KIND_USER, .word = r->word, .multiple = 1, .energy = energy, .frequency = omega,
                            .state = r->state, .flights = r->flights, .refusal = r->refusal};
    return RIC_OK;
}

/* What was asked for on a linear mode: energies; its frequency is one number and passes nothing. */
static ric_status mark_linear_energies(const ric_graph *g, int mode, sheet *s, mark *marks, int *n)
{
    ric_status status = RIC_OK;
    ric_branch_record *r = &s->record;
    s->user = g->n_node + *n;
    for (int i = 0; i < g->limits.n_asked && !status; i++) {
        const ric_asked *asked = &g->limits.asked[i];
        if (asked->frequency || asked->value >= r->row.energy_max) continue;
        r->junction_at[r->row.n_junction++] = linear_amplitude(g->model->frequency[mode], asked->value);
        status = mark_linear(g->model, mode, asked->value, g->n_node + *n, &marks[*n]);
        (*n)++;
    }
    return status;
}

static int mark_order(const void *p, const void *q)
{
    const ric_junction *a = &((const mark *)p)->record.row, *b = &((const mark *)q)->record.row;
    int order;
    if (a->impacts * a->multiple != b->impacts * b->multiple)
        return a->impacts * a->multiple - b->impacts * b->multiple;
    if ((order = compare_numbers(a->energy, b->energy))) return order;
    if ((order = compare_numbers(a->frequency, b->frequency))) return order;
    if (a->kind != b->kind) return a->kind < b->kind ? -1 : 1;
    const mark *k = p, *l = q;
    if (k->node && l->node && (order = ric_node_order(k->node, l->node))) return order;
    return k->index - l->index;
}

/* Junctions of one family share all of their label but its number. */
static int family_order(const void *p, const void *q)
{
    const mark *k = *(mark *const *)p, *l = *(mark *const *)q;
    const ric_junction *a = &k->record.row, *b = &l->record.row;
    int order = strcmp(letter(a->kind), letter(b->kind));
    if (order) return order;
    bool grazing = a->kind == RIC_KIND_GRAZING;
    const int mine[2] = {grazing ? a->impacts * a->multiple : a->a, grazing ? a->grazings * a->multiple : a->b};
    const int yours[2] = {grazing ? b->impacts * b->multiple : b->a, grazing ? b->grazings * b->multiple : b->b};
    return mine[0] != yours[0]   ? (mine[0] < yours[0] ? -1 : 1)
           : mine[1] != yours[1] ? (mine[1] < yours[1] ? -1 : 1)
                                 : 0;
}

static int label_order(const void *p, const void *q)
{
    int order = family_order(p, q), a = (*(mark *const *)p)->record.row.id, b = (*(mark *const *)q)->record.row.id;
    return order ? order : a - b;
}

static char *junction_label(const ric_junction *row, int number)
{
    char text[64];
    const char *l = letter(row->kind);
    if (row->kind == RIC_KIND_GRAZING)
        snprintf(text, sizeof text, "G%d_%d,%d", number, row->impacts * row->multiple, row->grazings * row->multiple);
    else if (*l == 'C') snprintf(text, sizeof text, "C%d_%d%d%s", number, row->a, row->b, row->decided ? "" : "?");
    else snprintf(text, sizeof text, "%s%d", l, number);
    return strdup(text);
}

/* Within a family junctions are numbered in the order of their ids. */
static ric_status label_marks(int n, mark *marks)
{
    mark **list = malloc((size_t)(n + 1) * sizeof *list);
    ric_status status = list ? RIC_OK : no_memory();
    for (int i = 0; i < n && list; i++) list[i] = &marks[i];
    if (list) qsort(list, (size_t)n, sizeof *list, label_order);
    for (int i = 0, number = 0; i < n && !status; i++) {
        ric_junction_record *r = &list[i]->record;
        number = i > 0 && family_order(&list[i - 1], &list[i]) == 0 ? number + 1 : 1;
        r->row.label = r->label = junction_label(&r->row, number);
        if (!r->label) status = no_memory();
    }
    free(list);
    return status;
}

/* The nearest junction of the right kind, within what the digits of a printed number leave open. */
static ric_status name_marks(const ric_study *study, int n, mark *marks)
{
    for (int k = 0; k < ric_study_n_name(study); k++) {
        ric_name name;
        int best = -1;
        double least = 2e-3;
        ric_status status = ric_study_name(study, k, &name);
        if (status) return status;
        for (int i = 0; i < n; i++) {
            const ric_junction *j = &marks[i].record.row;
            double off = fabs(j->energy / name.energy - 1) + fabs(j->frequency / name.frequency - 1);
            if (strcmp(ric_kind_text(j->kind), name.kind) || !(off < least)) continue;
            least = off;
            best = i;
        }
        if (best < 0) continue;
        free(marks[best].record.name);
        if (!(marks[best].record.name = strdup(name.name))) return no_memory();
    }
    for (int i = 0; i < n; i++) {
        if (!marks[i].record.name && !(marks[i].record.name = strdup(""))) return no_memory();
        marks[i].record.row.name = marks[i].record.name;
    }
    return RIC_OK;
}

/* --------------------------------------------------------------------- atlas */

/* Whether a run starts at a mode. */
static bool started(const ric_explore_options *o, int mode)
{
    bool wanted = o->n_start == 0;
    for (int j = 0; j < o->n_start; j++) wanted |= o->start[j] == mode + 1;
    return wanted;
}

/* Whether the linear mode that grazes at a node was reached from there. */
static bool departed(const ric_node *node)
{
    for (int i = 0; i < node->n_departure; i++)
        if (ric_node_impacts(node, node->departures[i].choice) == 0)
            return node->departures[i].state == RIC_DEPARTURE_KNOWN || node->departures[i].state == RIC_DEPARTURE_TAKEN;
    return false;
}

static ric_status linear_sheets(const ric_graph *g, sheet *sheets, int *n, mark *marks, int *n_mark)
{
    const ric_model *m = g->model;
    double *energy = calloc((size_t)m->n_dof, sizeof *energy);
    int *contact = calloc((size_t)m->n_dof, sizeof *contact);
    ric_status status = energy && contact ? ric_model_grazing_energies(m, energy, contact) : no_memory();
    for (int i = 0; i < m->n_dof && !status; i++) {
        int seen = -1, node = -1;
        for (int k = 0; k < m->n; k++)
            if (m->mode[k] == i) seen = k;
        if (m->smooth && seen >= 0) continue; /* its branch is traced */
        for (int k = 0; k < g->n_node; k++)
            if (seen >= 0 && g->nodes[k]->mode == seen && g->nodes[k]->multiple == 1) node = k;
        if (m->frequency[i] == 0 || !(started(g->options, i) || (node >= 0 && departed(g->nodes[node])))) continue;
        status = make_linear(m, g->options, i, seen, node, seen >= 0 ? energy[i] : HUGE_VAL, &sheets[*n]);
        if (!started(g->options, i)) sheets[*n].record.row.depth = g->nodes[node]->depth + 1;
        if (!status) status = mark_linear_energies(g, i, &sheets[*n], marks, n_mark);
        (*n)++;
    }
    free(energy);
    free(contact);
    return status;
}

/* The nodes that some branch meets, or that belong to a mode. */
static void mark_used(const ric_graph *g, bool *used)
{
    for (int i = 0; i < g->n_node; i++) used[i] = g->nodes[i]->mode >= 0;
    for (int i = 0; i < g->n_edge; i++) {
        const ric_edge *e = &g->edges[i];
        if (e->from >= 0) used[e->from] = true;
        if (e->to >= 0) used[e->to] = true;
        for (int k = 0; k < e->n_inner; k++) used[e->inner[k].node] = true;
    }
}

/* Branch `id` meets junction k; branches come in order. */
static ric_status list_branch(mark *k, int id)
{
    ric_junction_record *r = &k->record;
    if (r->row.n_branch > 0 && r->branches[r->row.n_branch - 1] == id) return RIC_OK;
    int *grown = realloc(r->branches, (size_t)(r->row.n_branch + 1) * sizeof *grown);
    if (!grown) return no_memory();
    r->row.branches = r->branches = grown;
    r->branches[r->row.n_branch++] = id;
    return RIC_OK;
}

/* For each junction the branches that meet there. `marks` lie in the order of ids. */
static ric_status list_branches(mark *marks, int n, const sheet *sheets, const int *id)
{
    ric_status status = RIC_OK;
    for (int i = 0; i < n && !status; i++) {
        const sheet *s = &sheets[i];
        if (s->from >= 0) status = list_branch(&marks[id[s->from] - 1], i + 1);
        if (s->to >= 0 && !status) status = list_branch(&marks[id[s->to] - 1], i + 1);
        for (int j = 0; j < s->record.row.n_junction && !status; j++)
            if (passed(s, j) >= 0) status = list_branch(&marks[id[passed(s, j)] - 1], i + 1);
    }
    return status;
}

static void note_ends(sheet *s, const int *id)
{
    const ric_edge *e = s->edge;
    if (!e) return;
    const int ends[4] = {e->from >= 0 ? id[e->from] : 0, (int)e->leave, e->to >= 0 ? id[e->to] : 0, (int)e->arrive};
    memcpy(s->ends, ends, sizeof ends);
}

static void link_sheets(int n, sheet *sheets, const int *id)
{
    for (int i = 0; i < n; i++) {
        ric_branch_record *r = &sheets[i].record;
        r->row.id = i + 1;
        r->row.from = sheets[i].from >= 0 ? id[sheets[i].from] : 0;
        r->row.to = sheets[i].to >= 0 ? id[sheets[i].to] : 0;
        for (int k = 0; k < r->row.n_junction; k++) r->junctions[k] = id[passed(&sheets[i], k)];
    }
}

/* Rows are made one by one from what is finished: by all workers. */
typedef struct {
    const ric_graph *graph;
    sheet *sheets;
    mark *marks;
    ric_atlas *atlas;
    ric_status (*beside)(void *user, const ric_atlas *atlas);
    void *user;
} workshop;

static ric_status sheet_in_shop(void *user, int i)
{
    const workshop *s = user;
    return make_sheet(s->graph, &s->graph->edges[i], &s->sheets[i]);
}

static ric_status mark_in_shop(void *user, int i)
{
    const workshop *s = user;
    int node = s->marks[i].index;
    return make_mark(s->graph->model, s->graph->nodes[node], node, &s->marks[i]);
}

/* What goes on beside comes first, because it takes longest; then C_ab of one junction after the other. */
static ric_status measure_in_shop(void *user, int i)
{
    const workshop *s = user;
    if (i == 0) return s->beside ? s->beside(s->user, s->atlas) : RIC_OK;
    const ric_node *node = s->marks[i - 1].node;
    ric_junction *row = &s->marks[i - 1].record.row;
    if (!node || (node->kind != RIC_KIND_EXTREMUM && node->kind != RIC_KIND_BRANCH_POINT &&
                  node->kind != RIC_KIND_MULTIPLICATION))
        return RIC_OK;
    return ric_multiplicity(s->graph->model, node, &row->a, &row->b, &row->decided);
}

/* Junctions are numbered, and branches in the order of what they meet. */
static ric_status put_in_order(int n_mark, mark *marks, int n_sheet, sheet *sheets, int *id)
{
    qsort(marks, (size_t)n_mark, sizeof *marks, mark_order);
    for (int i = 0; i < n_mark; i++) {
        marks[i].record.row.id = i + 1;
        id[marks[i].index] = i + 1;
    }
    for (int i = 0; i < n_sheet; i++) note_ends(&sheets[i], id);
    qsort(sheets, (size_t)n_sheet, sizeof *sheets, sheet_order);
    link_sheets(n_sheet, sheets, id);
    return list_branches(marks, n_sheet, sheets, id);
}

/* An atlas with room for junctions, and with the records of branches, which stay the sheets' own until all is done. */
static ric_status bind_branches(const ric_graph *g, const ric_study *study, int n, const sheet *sheets, int n_mark,
                                ric_atlas *atlas)
{
    ric_status status = ric_study_parse(ric_study_text(study), "study", ".", &atlas->study);
    if (status) return status;
    atlas->branches = calloc((size_t)n + 1, sizeof *atlas->branches);
    atlas->junctions = calloc((size_t)n_mark + 1, sizeof *atlas->junctions);
    if (!atlas->branches || !atlas->junctions) return no_memory();
    for (int i = 0; i < n; i++) atlas->branches[i] = sheets[i].record;
    for (int i = 0; i < g->n_edge; i++) atlas->n_unplaced += g->edges[i].n_unplaced;
    atlas->n_branch = n;
    return RIC_OK;
}

ric_status ric_chart_beside(const ric_graph *g, const ric_study *study, bool finished,
                            ric_status (*beside)(void *user, const ric_atlas *atlas), void *user, ric_atlas **out)
{
    ric_status status = RIC_OK;
    const ric_model *m = g->model;
    int n_sheet = 0, n_mark = 0;
    sheet *sheets = calloc((size_t)(g->n_edge + m->n_dof), sizeof *sheets);
    size_t most = (size_t)g->n_node + (size_t)m->n_dof * g->limits.n_asked + 1;
    mark *marks = calloc(most, sizeof *marks);
    int *id = calloc(most, sizeof *id);
    bool *used = calloc(most, sizeof *used);
    ric_atlas *atlas = calloc(1, sizeof *atlas);
    *out = NULL;
    if (!sheets || !marks || !id || !used || !atlas) {
        status = no_memory();
        goto out;
    }
    if ((status = linear_sheets(g, sheets, &n_sheet, marks, &n_mark))) goto out;
    workshop shop = {.graph = g, .sheets = sheets + n_sheet, .marks = marks + n_mark, .atlas = atlas, .beside = beside,
                     .user = user};
    n_sheet += g->n_edge;
    mark_used(g, used);
    for (int i = 0; i < g->n_node; i++)
        if (used[i]) marks[n_mark++].index = i;
    if ((status = ric_parallel(g->n_worker, g->n_edge, sheet_in_shop, &shop))) goto out;
    if ((status = ric_parallel(g->n_worker, (int)(marks + n_mark - shop.marks), mark_in_shop, &shop))) goto out;
    if ((status = put_in_order(n_mark, marks, n_sheet, sheets, id))) goto out;
    atlas->finished = finished;
    if ((status = bind_branches(g, study, n_sheet, sheets, n_mark, atlas))) goto out;
    shop.marks = marks;
    status = ric_parallel(g->n_worker, n_mark + 1, measure_in_shop, &shop);
    if (!status) status = label_marks(n_mark, marks);
    if (!status) status = name_marks(study, n_mark, marks);
    if (status) goto out;
    for (int i = 0; i < n_mark; i++) atlas->junctions[i] = marks[i].record;
    atlas->n_junction = n_mark;
    *out = atlas;
    atlas = NULL;
    n_sheet = n_mark = 0;
out:
    if (atlas) atlas->n_branch = 0; /* they belong to the sheets */
    for (int i = 0; sheets && i < n_sheet; i++) ric_branch_record_free(&sheets[i].record);
    for (int i = 0; marks && i < n_mark; i++) ric_junction_record_free(&marks[i].record);
    free(sheets);
    free(marks);
    free(id);
    free(used);
    ric_atlas_free(atlas);
    return status;
}

ric_status ric_chart(const ric_graph *g, const ric_study *study, bool finished, ric_atlas **out)
{
    return ric_chart_beside(g, study, finished, NULL, NULL, out);
}
