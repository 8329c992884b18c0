#include "base/room.h"
#include "rows_parts.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Relative, energy and frequency together: a name of the study belongs to the nearest junction
 * within this distance, as places are read off printed figures. */
#define NAMED 2e-3

static void count_departures(const ric_node *node, ric_junction_record *r)
{
    ric_departures *d = &r->row.departures;
    for (int i = 0; i < node->n_departure; i++) switch (node->departures[i].state) {
        case RIC_DEPARTURE_TAKEN: d->taken++; break;
        case RIC_DEPARTURE_KNOWN: d->known++; break;
        case RIC_DEPARTURE_INADMISSIBLE: d->inadmissible++; break;
        case RIC_DEPARTURE_REFUSED: d->refused++; break;
        default: d->over_budget++; d->over[node->departures[i].budget % RIC_N_BUDGET]++;
        }
    d->refused += node->unsought;
}

static const char unsought[] = "modes of one frequency: of their mixtures those were looked for "
                               "that up to three contacts drive, more contacts "
                               "only at one instant or half a period apart, and contacts of "
                               "perpendicular normals at no other time";

/* Whether departure `place` is refused for a reason that none before it has. */
static bool new_reason(const ric_node *node, int place)
{
    const char *why = node->departures[place].why;
    if (!why || !*why) return false;
    for (int i = 0; i < place; i++)
        if (node->departures[i].why && !strcmp(node->departures[i].why, why)) return false;
    return true;
}

/* All reasons, each once: departures of one junction are refused for different ones. */
static char *refusals(const ric_node *node)
{
    const char *whole = ric_node_refusal_text(node->refusal);
    size_t size = strlen(whole) + 1 + (node->unsought ? sizeof unsought + 2 : 0);
    for (int i = 0; i < node->n_departure; i++)
        if (new_reason(node, i)) size += strlen(node->departures[i].why) + 2;
    char *text = ric_malloc(size);
    if (!text) return NULL;
    int used = snprintf(text, size, "%s", whole);
    for (int i = 0; i < node->n_departure; i++)
        if (new_reason(node, i))
            used += snprintf(text + used, size - (size_t)used, "%s%s", used ? "; " : "",
                             node->departures[i].why);
    if (node->unsought)
        snprintf(text + used, size - (size_t)used, "%s%s", used ? "; " : "", unsought);
    return text;
}

ric_status ric_junction_row_make(const ric_model *m, const ric_node *node, int index,
                                 ric_junction_row *out)
{
    ric_status status = RIC_OK;
    ric_junction_record *r = &out->record;
    int n = m->n_dof;
    bool bare;
    ric_periodic *cycle = ric_node_original(m, node, &bare);
    const bool own = cycle && node->kind == RIC_KIND_GRAZING;
    const double energy = own ? ric_periodic_energy(m, cycle) : node->energy,
                 period = own ? ric_periodic_period(cycle) : node->period;
    int N = cycle ? ric_periodic_letters(cycle) : 0;
    *out = (ric_junction_row){.node = node, .index = index};
    r->word = ric_calloc((size_t)N + 1, sizeof *r->word);
    r->state = ric_calloc(2 * (size_t)n, sizeof *r->state);
    r->flights = ric_calloc((size_t)N + 1, sizeof *r->flights);
    r->refusal = refusals(node);
    if (!r->word || !r->state || !r->flights || !r->refusal || (!bare && !cycle)) {
        status = ric_no_rows();
        goto out;
    }
    ric_model_to_state(m, cycle ? cycle->w : node->cycle->w, r->state, r->state + n);
    if (cycle) ric_periodic_word(m, cycle, r->word);
    for (int i = 0; i < N; i++) {
        r->flights[i] = cycle->tau[i] / m->omega_ref;
    }
    if (!N) r->flights[0] = node->period / m->omega_ref;
    r->row = (ric_junction){.kind = node->kind,
                            .impacts = cycle ? ric_periodic_impacts(node->springs, cycle) : 0,
                            .letters = N,
                            .word = r->word,
                            .grazings = node->kind == RIC_KIND_GRAZING ? node->n_touch : 0,
                            .multiple = node->multiple,
                            .rotation = {node->rotation[0], node->rotation[1]},
                            .energy = energy * m->energy_unit,
                            .state = r->state,
                            .flights = r->flights,
                            .refusal = r->refusal};
    r->row.frequency = RIC_TWO_PI / period * m->omega_ref / r->row.multiple;
    count_departures(node, r);
out:
    ric_periodic_free(cycle);
    return status;
}

/* The linear motion of a mode at an energy that was asked for; its contacts may not see it, so that
 * it is no node of the graph. */
static ric_status linear_row(const ric_model *m, int mode, double energy, int index,
                             ric_junction_row *out)
{
    ric_junction_record *r = &out->record;
    int n = m->n_dof;
    double omega = m->frequency[mode];
    *out = (ric_junction_row){.index = index};
    r->word = ric_calloc(1, sizeof *r->word);
    r->state = ric_calloc(2 * (size_t)n, sizeof *r->state);
    r->flights = ric_calloc(1, sizeof *r->flights);
    r->refusal = ric_strdup("");
    if (!r->word || !r->state || !r->flights || !r->refusal) return ric_no_rows();
    for (int i = 0; i < n; i++)
        r->state[i] = m->Phi[i * n + mode] * ric_linear_amplitude(omega, energy);
    r->flights[0] = RIC_TWO_PI / omega;
    r->row = (ric_junction){.kind = RIC_KIND_USER,
                            .word = r->word,
                            .multiple = 1,
                            .energy = energy,
                            .frequency = omega,
                            .state = r->state,
                            .flights = r->flights,
                            .refusal = r->refusal};
    return RIC_OK;
}

ric_status ric_junction_row_energies(const ric_graph *g, int mode, ric_branch_row *s,
                                     ric_junction_row *junctions, int *n)
{
    ric_status status = RIC_OK;
    ric_branch_record *r = &s->record;
    s->user = g->n_node + *n;
    for (int i = 0; i < g->limits.n_asked && !status; i++) {
        const ric_user_point *asked = &g->limits.asked[i];
        if (asked->frequency || asked->value >= r->row.energy_max) continue;
        r->junction_at[r->row.n_junction++] = ric_linear_amplitude(g->model->frequency[mode],
                                                                   asked->value);
        status = linear_row(g->model, mode, asked->value, g->n_node + *n, &junctions[*n]);
        (*n)++;
    }
    return status;
}

int ric_junction_row_order(const void *p, const void *q)
{
    const ric_junction *a = &((const ric_junction_row *)p)->record.row,
                       *b = &((const ric_junction_row *)q)->record.row;
    int order;
    if (a->impacts * a->multiple != b->impacts * b->multiple)
        return a->impacts * a->multiple - b->impacts * b->multiple;
    if ((order = ric_compare_numbers(a->energy, b->energy))) return order;
    if ((order = ric_compare_numbers(a->frequency, b->frequency))) return order;
    if (a->kind != b->kind) return a->kind < b->kind ? -1 : 1;
    const ric_junction_row *k = p, *l = q;
    if (k->node && l->node && (order = ric_graph_node_order(k->node, l->node))) return order;
    return k->index - l->index;
}

ric_status ric_junction_rows_name(const ric_study *study, int n, ric_junction_row *junctions)
{
    for (int k = 0; k < ric_study_n_name(study); k++) {
        ric_name name;
        int best = -1;
        double least = NAMED;
        ric_status status = ric_study_name(study, k, &name);
        if (status) return status;
        for (int i = 0; i < n; i++) {
            const ric_junction *j = &junctions[i].record.row;
            double off = fabs(j->energy / name.energy - 1) +
                         fabs(j->frequency / name.frequency - 1);
            if (strcmp(ric_kind_text(j->kind), name.kind) || !(off < least)) continue;
            least = off;
            best = i;
        }
        if (best < 0) continue;
        free(junctions[best].record.name);
        if (!(junctions[best].record.name = ric_strdup(name.name))) return ric_no_rows();
    }
    for (int i = 0; i < n; i++) {
        if (!junctions[i].record.name && !(junctions[i].record.name = ric_strdup("")))
            return ric_no_rows();
        junctions[i].record.row.name = junctions[i].record.name;
    }
    return RIC_OK;
}
