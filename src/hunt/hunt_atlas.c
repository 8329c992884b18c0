#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "explore/room.h"
#include "hunt.h"
#include "base/room.h"
#include "atlas/room.h"

/* What was found against what an atlas has. Orbits that it lacks are followed: an exploration that
 * starts from them alone, within the budgets of the atlas, makes an atlas of their surroundings,
 * and its junctions are compared with those of the other. */

/* MATCH: an orbit of the atlas is one of the hunt if all impacts agree within this */
#define MATCH 1e-5
/* JUNCTION: relative, of energies, frequencies and states of one junction in two atlases */
#define JUNCTION 1e-6
/* AT_ONCE: of the period: stops that are met within this are met together */
#define AT_ONCE 1e-9

void ric_comparison_free(ric_comparison *c)
{
    if (!c) return;
    free(c->missed);
    free(c->findings);
    ric_atlas_free(c->side);
    free(c);
}

/* ------------------------------------------------------------------- orbits */

/* The impacts of an orbit of an atlas, by its own history. */
static ric_status read_orbit(const ric_hunt *h, const ric_orbit *o, ric_hit *hits)
{
    int n = h->section->n_dof, N = ric_orbit_impacts(o);
    double x[2 * n], t = 0, *flights = ric_calloc((size_t)N + 1, sizeof *flights);
    int *word = ric_calloc((size_t)N + 1, sizeof *word);
    if (flights && word) {
        ric_orbit_data(o, NULL, x, flights, word);
        for (int k = 0; k < N; k++) {
            if (k) ric_orbit_at_time(o, t, x, x + n);
            ric_impact_map_read(h->section, word[k], x, x + n, &hits[k]);
            hits[k].tau = flights[k];
            t += flights[k];
        }
    }
    ric_status status = flights && word ? RIC_OK : ric_no_memory("the comparison with an atlas");
    free(flights);
    free(word);
    return status;
}

typedef ric_status (*orbit_visitor)(void *user, const ric_branch *branch, const ric_orbit *orbit,
                                    int place);

/* Every orbit of an atlas within the bounds of the hunt, and its place among those found (-1:
 * none). */
static ric_status each_orbit(const ric_hunt *h, const ric_atlas *a, orbit_visitor visit, void *user)
{
    ric_status status = RIC_OK;
    for (int id = 1; id <= ric_atlas_n_branch(a) && !status; id++) {
        ric_branch b;
        ric_orbit **orbits = NULL;
        int n = 0;
        if ((status = ric_atlas_branch(a, id, &b)) || b.impacts == 0 ||
            b.impacts > h->options.impacts)
            continue;
        status = ric_orbit_find(a, id, RIC_AT_ENERGY, h->options.energy, &n, &orbits);
        if (status == RIC_E_NUMERIC)
            status = RIC_OK; /* none converges there: what the hunt has is then said to lack */
        for (int i = 0; i < n && !status; i++) {
            ric_point point;
            ric_hit hits[b.impacts];
            ric_orbit_data(orbits[i], &point, NULL, NULL, NULL);
            double period = RIC_TWO_PI / point.frequency;
            if (!ric_point_admissible(&point) || period > h->options.period[1] ||
                period < h->options.period[0])
                continue;
            if (!(status = read_orbit(h, orbits[i], hits)))
                status = visit(user, &b, orbits[i], ric_hunt_find(h, b.impacts, hits, MATCH));
        }
        ric_orbits_free(n, orbits);
    }
    return status;
}

typedef struct {
    ric_comparison *comparison;
    int capacity;
} tally;

static ric_status count(void *user, const ric_branch *b, const ric_orbit *o, int place)
{
    tally *t = user;
    ric_comparison *c = t->comparison;
    ric_point point;
    c->n_atlas++;
    if (place >= 0) {
        c->n_again++;
        c->findings[place] = (ric_finding){.state = RIC_FOUND_KNOWN, .branch = b->id};
        return RIC_OK;
    }
    if (c->n_missed == t->capacity) {
        t->capacity = t->capacity ? 2 * t->capacity : 16;
        ric_missed *grown = ric_realloc(c->missed, (size_t)t->capacity * sizeof *grown);
        if (!grown) return ric_no_memory("the comparison with an atlas");
        c->missed = grown;
    }
    ric_orbit_data(o, &point, NULL, NULL, NULL);
    c->missed[c->n_missed++] = (ric_missed){b->id, b->impacts, RIC_TWO_PI / point.frequency,
                                            2 * sinh(point.trace), point.approach};
    return RIC_OK;
}

static ric_status note_side(void *user, const ric_branch *b, const ric_orbit *o, int place)
{
    ric_comparison *c = user;
    (void)o;
    if (place >= 0 && c->findings[place].state != RIC_FOUND_KNOWN)
        c->findings[place].branch = b->id;
    return RIC_OK;
}

/* --------------------------------------------------------------- side atlas */

static char *start_line(const ric_hunt *h, const ric_prey *p)
{
    int n = h->section->n_dof, word[p->N];
    double x[n], v[n], flights[p->N];
    for (int k = 0; k < p->N; k++) {
        word[k] = p->hits[k].face;
        flights[k] = p->hits[k].tau;
    }
    ric_impact_map_write(h->section, &p->hits[0], x, v);
    return ric_start_line(n, p->N, p->symmetric, p->pure, p->flip, word, flights, x, v);
}

/* Lines of the orbits that `wanted` says, one after the other. NULL: no memory. */
static char *start_lines(const ric_hunt *h, const bool *wanted)
{
    char *all = ric_calloc(1, 1);
    size_t used = 0;
    for (int i = 0; i < h->n && all; i++) {
        if (!wanted[i]) continue;
        char *line = start_line(h, &h->prey[i]),
             *grown = line ? ric_realloc(all, used + strlen(line) + 1) : NULL;
        if (grown) {
            strcpy(grown + used, line);
            used += strlen(line);
        } else free(all);
        all = grown;
        free(line);
    }
    return all;
}

static bool keep_going(const ric_progress *now, void *user)
{
    return ric_hunt_report(user, "following what the atlas lacks",
                           now->open ? 1 - 1.0 / (1 + now->branches) : 1) != RIC_OK;
}

static ric_status explore_side(ric_hunt *h, const ric_atlas *a, const bool *wanted, ric_atlas **out)
{
    ric_graph *graph = NULL;
    ric_run_options run = {.workers = 1, .progress = keep_going, .user = h};
    char *lines = start_lines(h, wanted);
    ric_status status = lines ? ric_graph_create(ric_atlas_study(a), NULL, &graph)
                              : ric_no_memory("the comparison with an atlas");
    if (!status) {
        graph->only_given = true;
        graph->labels = a->labels;
        status = ric_starts_parse(ric_atlas_model(a), lines, &graph->starts);
    }
    if (!status) status = ric_graph_explore(graph, &run);
    if (!status) status = ric_rows_make(graph, ric_atlas_study(a), true, out);
    ric_graph_free(graph);
    free(lines);
    return status;
}

/* ----------------------------------------------------------------- families */

static bool near(double a, double b)
{
    return fabs(a - b) <= JUNCTION * (1 + fabs(a) + fabs(b));
}

/* One orbit, also where it is a junction gone through different numbers of times. Canonical states
 * are solved from rounded numbers and agree. */
static bool same_orbit(int n_dof, const ric_junction *a, const ric_junction *b)
{
    if (a->impacts != b->impacts || !near(a->energy, b->energy) ||
        !near(a->frequency * a->multiple, b->frequency * b->multiple))
        return false;
    for (int i = 0; i < a->impacts; i++)
        if (a->word[i] != b->word[i] || !near(a->flights[i], b->flights[i])) return false;
    for (int i = 0; i < 2 * n_dof; i++)
        if (!near(a->state[i], b->state[i])) return false;
    return true;
}

/* Junctions of a branch: *ids [n_junction + 2]. */
static int junctions_of(const ric_branch *b, int *ids)
{
    int n = 0;
    if (b->from) ids[n++] = b->from;
    if (b->to) ids[n++] = b->to;
    for (int i = 0; i < b->n_junction; i++) ids[n++] = b->junctions[i];
    return n;
}

/* Families of a side atlas: branches that share junctions; family [n_branch + 1], junction_family
 * [n_junction + 1], from 1. */
static void find_families(const ric_atlas *s, int *family, int *junction_family)
{
    int count = 0;
    for (int first = 1; first <= ric_atlas_n_branch(s); first++) {
        bool grown = !family[first];
        if (grown) family[first] = ++count;
        while (grown) {
            grown = false;
            for (int id = first; id <= ric_atlas_n_branch(s); id++) {
                ric_branch b;
                ric_atlas_branch(s, id, &b);
                int ids[b.n_junction + 2], n = junctions_of(&b, ids);
                for (int i = 0; i < n && !family[id]; i++)
                    if (junction_family[ids[i]] == count) family[id] = count;
                if (family[id] != count) continue;
                for (int i = 0; i < n; i++) {
                    grown |= !junction_family[ids[i]];
                    if (!junction_family[ids[i]]) junction_family[ids[i]] = count;
                }
            }
        }
    }
}

/* What a family meets: junctions of the atlas where something is left to take, or nothing; or one
 * that the atlas has, but gone through another number of times; or, of the side atlas, a
 * multiplication of more periods than the atlas looks for on a branch that it has. 0: none. */
typedef struct {
    int branches, junctions, over_budget, refused, window, failed;
    int open, settled, again, times, longer;
} surroundings;

static void meet(const ric_atlas *a, const ric_junction *j, surroundings *out)
{
    int again = 0, least = 0;
    for (int id = 1; id <= ric_atlas_n_junction(a); id++) {
        ric_junction other;
        ric_atlas_junction(a, id, &other);
        if (!same_orbit(ric_model_n_dof(ric_atlas_model(a)), j, &other)) continue;
        if (other.multiple == j->multiple) {
            if (other.departures.over_budget + other.departures.refused > 0 || other.refusal[0])
                out->open = id;
            else out->settled = id;
            return;
        }
        if (!again || other.multiple < least) {
            again = id;
            least = other.multiple;
        }
    }
    if (again && j->kind == RIC_KIND_GRAZING) {
        out->again = again;
        out->times = j->multiple;
    }
}

static bool has_junction(const ric_atlas *a, const ric_junction *j)
{
    for (int id = 1; id <= ric_atlas_n_junction(a); id++) {
        ric_junction other;
        ric_atlas_junction(a, id, &other);
        if (other.multiple == j->multiple &&
            same_orbit(ric_model_n_dof(ric_atlas_model(a)), j, &other))
            return true;
    }
    return false;
}

/* Whether a branch passes this junction of the side atlas that the atlas has, by another junction
 * on it. */
static bool on_known_branch(const ric_atlas *a, const ric_atlas *s, int junction)
{
    for (int id = 1; id <= ric_atlas_n_branch(s); id++) {
        ric_branch b;
        ric_atlas_branch(s, id, &b);
        int ids[b.n_junction + 2], n = junctions_of(&b, ids);
        bool passes = false, known = false;
        for (int i = 0; i < b.n_junction; i++) passes |= b.junctions[i] == junction;
        for (int i = 0; i < n && passes && !known; i++) {
            ric_junction j;
            ric_atlas_junction(s, ids[i], &j);
            known = has_junction(a, &j);
        }
        if (known) return true;
    }
    return false;
}

/* The multiplication of the least number of periods among those beyond explore.multiply. */
static void note_longer(const ric_atlas *a, const ric_atlas *s, const ric_junction *j,
                        surroundings *out)
{
    ric_junction best = {.multiple = INT_MAX};
    if (j->kind != RIC_KIND_MULTIPLICATION ||
        j->multiple <= ric_study_options(ric_atlas_study(a))->multiply)
        return;
    if (out->longer) ric_atlas_junction(s, out->longer, &best);
    if (j->multiple < best.multiple && on_known_branch(a, s, j->id)) out->longer = j->id;
}

static surroundings look_around(const ric_atlas *a, const ric_atlas *s, int wanted,
                                const int *family, const int *junction_family)
{
    surroundings out = {0};
    for (int id = 1; id <= ric_atlas_n_branch(s); id++) {
        ric_branch b;
        ric_atlas_branch(s, id, &b);
        if (family[id] != wanted) continue;
        out.branches++;
        out.window += b.stop == RIC_STOP_WINDOW;
        out.failed += b.stop == RIC_STOP_FAILED || b.stop == RIC_STOP_BUDGET;
    }
    for (int id = 1; id <= ric_atlas_n_junction(s); id++) {
        ric_junction j;
        ric_atlas_junction(s, id, &j);
        if (junction_family[id] != wanted || j.kind == RIC_KIND_START) continue;
        out.junctions++;
        out.over_budget += j.departures.over_budget;
        out.refused += j.departures.refused;
        meet(a, &j, &out);
        note_longer(a, s, &j, &out);
    }
    return out;
}

static void explain(const ric_atlas *a, const ric_atlas *s, const surroundings *f,
                    ric_finding *finding)
{
    ric_junction j;
    int id = f->open ? f->open : f->again ? f->again : f->settled;
    bool beyond = f->open || f->again || f->longer;
    finding->state = beyond       ? RIC_FOUND_BUDGET
                     : f->settled ? RIC_FOUND_UNEXPLAINED
                                  : RIC_FOUND_ISOLATED;
    if (id) ric_atlas_junction(a, id, &j);
    if (f->open && j.refusal[0])
        snprintf(finding->why, sizeof finding->why,
                 "its family joins the atlas at junction %d (%s), refused: %s", j.id, j.label,
                 j.refusal);
    else if (f->open)
        snprintf(
            finding->why, sizeof finding->why,
            "its family joins the atlas at junction %d (%s), where %d departures are over budget",
            j.id, j.label, j.departures.over_budget);
    else if (f->again)
        snprintf(finding->why, sizeof finding->why,
                 "its family joins the %d-duplicate of junction %d (%s), beyond explore.multiply "
                 "(%d) or "
                 "explore.impacts (%d)",
                 f->times, j.id, j.label, ric_study_options(ric_atlas_study(a))->multiply,
                 ric_study_options(ric_atlas_study(a))->impacts);
    else if (f->longer) {
        ric_atlas_junction(s, f->longer, &j);
        snprintf(finding->why, sizeof finding->why,
                 "its family joins the atlas at a multiplication by %d at E %.10g, beyond "
                 "explore.multiply (%d)",
                 j.multiple, j.energy, ric_study_options(ric_atlas_study(a))->multiply);
    } else if (f->settled)
        snprintf(finding->why, sizeof finding->why,
                 "its family joins the atlas at junction %d (%s), where no departure is left", j.id,
                 j.label);
    else
        snprintf(finding->why, sizeof finding->why,
                 "within the budgets its family (%d branches, %d junctions) meets no junction of "
                 "the atlas; beyond: %d "
                 "departures over budget, %d refused, %d ends at a window, %d failed",
                 f->branches, f->junctions, f->over_budget, f->refused, f->window, f->failed);
}

/* Of one that the side atlas lacks, too. */
static void explain_lost(const ric_prey *p, ric_finding *finding)
{
    bool together = false;
    for (int i = 0; i < p->N; i++) together |= p->hits[i].tau <= AT_ONCE * p->period;
    if (together) finding->state = RIC_FOUND_BUDGET;
    snprintf(finding->why, sizeof finding->why, "%s",
             together ? "it meets two stops at one instant, and so does its whole branch: such "
                        "branches are not followed by this version"
                      : "its branch could not be followed");
}

static ric_status explain_all(const ric_hunt *h, const ric_atlas *a, ric_comparison *c)
{
    const ric_atlas *s = c->side;
    int *family = ric_calloc((size_t)ric_atlas_n_branch(s) + 1, sizeof *family);
    int *junction_family = ric_calloc((size_t)ric_atlas_n_junction(s) + 1, sizeof *junction_family);
    ric_status status = family && junction_family ? each_orbit(h, s, note_side, c)
                                                  : ric_no_memory("the comparison with an atlas");
    if (!status) find_families(s, family, junction_family);
    for (int i = 0; i < h->n && !status; i++) {
        ric_finding *finding = &c->findings[i];
        if (finding->state == RIC_FOUND_KNOWN) continue;
        if (!finding->branch) {
            explain_lost(&h->prey[i], finding);
            continue;
        }
        finding->family = family[finding->branch];
        surroundings around = look_around(a, s, finding->family, family, junction_family);
        explain(a, s, &around, finding);
    }
    free(family);
    free(junction_family);
    return status;
}

/* ---------------------------------------------------------------- interface */

ric_status ric_hunt_compare(ric_hunt *h, const ric_atlas *a, ric_comparison **out)
{
    ric_comparison *c = ric_calloc(1, sizeof *c);
    bool *wanted = ric_calloc((size_t)h->n + 1, sizeof *wanted), any = false;
    tally t = {.comparison = c};
    *out = NULL;
    if (!c || !wanted || !(c->findings = ric_calloc((size_t)h->n + 1, sizeof *c->findings))) {
        free(wanted);
        ric_comparison_free(c);
        return ric_no_memory("the comparison with an atlas");
    }
    c->n = h->n;
    for (int i = 0; i < h->n; i++) c->findings[i].state = RIC_FOUND_UNEXPLAINED;
    ric_status status = each_orbit(h, a, count, &t);
    for (int i = 0; i < h->n; i++) any |= wanted[i] = c->findings[i].state != RIC_FOUND_KNOWN;
    if (!status && any) status = explore_side(h, a, wanted, &c->side);
    if (!status && any) status = explain_all(h, a, c);
    free(wanted);
    if (status) ric_comparison_free(c);
    else *out = c;
    return status;
}

ric_status ric_hunt_add(const ric_hunt *h, const ric_comparison *c, const ric_atlas *a,
                        const char *path, int *n)
{
    bool *wanted = ric_calloc((size_t)h->n + 1, sizeof *wanted);
    ric_store *store = NULL;
    char *lines = NULL;
    ric_status status = wanted ? RIC_OK : ric_no_memory("the comparison with an atlas");
    *n = 0;
    for (int i = 0; wanted && i < h->n; i++) {
        wanted[i] = c->findings[i].state == RIC_FOUND_ISOLATED;
        for (int k = 0; k < i; k++)
            if (wanted[k] && c->findings[k].branch == c->findings[i].branch) wanted[i] = false;
        *n += wanted[i];
    }
    if (*n) {
        if (!(lines = start_lines(h, wanted)))
            status = ric_no_memory("the comparison with an atlas");
        if (!status) status = ric_store_open(path, ric_atlas_study(a), &store);
        if (!status) status = ric_stored_work_check(store, ric_atlas_study(a));
        if (!status) status = ric_store_starts_add(store, lines);
        ric_store_close(store);
    }
    free(lines);
    free(wanted);
    return status;
}

void ric_comparison_count(const ric_comparison *c, int *n_atlas, int *n_again, int *n_missed)
{
    *n_atlas = c->n_atlas;
    *n_again = c->n_again;
    *n_missed = c->n_missed;
}

static ric_status check_place(const char *what, int i, int n)
{
    return i >= 0 && i < n ? RIC_OK
                           : ric_fail(RIC_E_RANGE, "no %s %d: there are %d, from 0 on", what, i, n);
}

ric_status ric_comparison_finding(const ric_comparison *c, int i, ric_finding *out)
{
    ric_status status = check_place("finding", i, c->n);
    if (!status) *out = c->findings[i];
    return status;
}

ric_status ric_comparison_missed(const ric_comparison *c, int i, ric_missed *out)
{
    ric_status status = check_place("orbit that was missed", i, c->n_missed);
    if (!status) *out = c->missed[i];
    return status;
}

const char *ric_found_text(ric_found_state state)
{
    switch (state) {
    case RIC_FOUND_KNOWN: return "known";
    case RIC_FOUND_BUDGET: return "budget";
    case RIC_FOUND_ISOLATED: return "isolated";
    case RIC_FOUND_UNEXPLAINED: return "unexplained";
    }
    return "unknown";
}
