#include "response.h"

#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"

void ric_response_defaults(ric_response_options *out)
{
    static const int fundamental = 1;
    *out = (ric_response_options){.along = RIC_RESPONSE_OMEGA,
                                  .shaking = {.restitution = 1},
                                  .n_harmonic = 1,
                                  .harmonics = &fundamental,
                                  .impacts = 12,
                                  .periods = 4,
                                  .once_in = 1,
                                  .points = 2000,
                                  .curves = 200,
                                  .step = 0.05};
}

ric_response *ric_response_create(const ric_model *model)
{
    ric_response *r = ric_calloc(1, sizeof *r);
    if (r) r->model = model;
    return r;
}

void ric_response_free(ric_response *r)
{
    if (!r) return;
    for (int i = 0; i < r->n_curve; i++) {
        for (int k = 0; k < r->curves[i].data.n_point; k++) free(r->curves[i].points[k].numbers);
        free(r->curves[i].points);
        free(r->curves[i].word);
    }
    for (int i = 0; i < r->n_event; i++) free(r->events[i].row.numbers);
    for (int i = 0; i < r->n_task; i++) free(r->tasks[i]);
    free(r->curves);
    free(r->events);
    free(r->tasks);
    free(r->force);
    free(r->ratios);
    free(r->matrix);
    free(r->levels);
    free(r->harmonics);
    free(r->skipped);
    ric_study_free(r->study);
    free(r);
}

static bool copy(const void *from, size_t size, void **out)
{
    *out = NULL;
    if (!from || !size) return true;
    if (!(*out = ric_malloc(size))) return false;
    memcpy(*out, from, size);
    return true;
}

bool ric_response_take(ric_response *r, const ric_response_options *asked)
{
    const ric_shaking *s = &asked->shaking;
    const size_t each = sizeof(double);
    r->asked = *asked;
    if (!copy(s->force, (size_t)s->n_force * each, (void **)&r->force) ||
        !copy(s->ratios, (size_t)s->n_ratio * each, (void **)&r->ratios) ||
        !copy(s->matrix, (size_t)s->n_matrix * (size_t)s->n_matrix * each, (void **)&r->matrix) ||
        !copy(asked->levels, (size_t)asked->n_level * each, (void **)&r->levels) ||
        !copy(asked->harmonics, (size_t)asked->n_harmonic * sizeof(int), (void **)&r->harmonics))
        return false;
    r->asked.shaking.force = r->force;
    r->asked.shaking.ratios = r->ratios;
    r->asked.shaking.matrix = r->matrix;
    r->asked.levels = r->levels;
    r->asked.harmonics = r->harmonics;
    return true;
}

/* --------------------------------------------------------------------- rows */

static size_t flights_of(int letters)
{
    return letters > 0 ? (size_t)letters : 1;
}

size_t ric_response_numbers(int n, int letters)
{
    return 8 * (size_t)n + flights_of(letters);
}

void ric_response_row_arrange(ric_response_row *row, int n, int letters)
{
    double *at = row->numbers;
    row->data.state = at;
    row->data.flights = at + 2 * n;
    row->data.multipliers = row->data.flights + flights_of(letters);
    row->data.peak = row->data.multipliers + 4 * n;
    row->data.rms = row->data.peak + n;
}

static bool grow(void **array, int n, size_t each)
{
    if (n & (n - 1)) return true; /* room is a power of two */
    void *more = ric_realloc(*array, (n ? 2 * (size_t)n : 1) * each);
    if (more) *array = more;
    return more;
}

ric_response_line *ric_response_add_curve(ric_response *r, const ric_response_curve *data,
                                          int *word)
{
    if (!grow((void **)&r->curves, r->n_curve, sizeof *r->curves)) return NULL;
    ric_response_line *line = &r->curves[r->n_curve++];
    *line = (ric_response_line){.data = *data, .word = word};
    line->data.word = word;
    line->data.id = r->n_curve;
    line->data.n_point = 0;
    return line;
}

bool ric_response_add_point(ric_response_line *line, const ric_response_row *row)
{
    if (!grow((void **)&line->points, line->data.n_point, sizeof *line->points)) return false;
    line->points[line->data.n_point++] = *row;
    return true;
}

bool ric_response_add_event(ric_response *r, const ric_response_event *data,
                            const ric_response_row *row)
{
    if (!grow((void **)&r->events, r->n_event, sizeof *r->events)) return false;
    r->events[r->n_event] = (ric_response_mark){*data, *row};
    r->events[r->n_event].data.at = row->data;
    r->events[r->n_event].data.id = r->n_event + 1;
    r->n_event++;
    return true;
}

bool ric_response_add_task(ric_response *r, const char *key)
{
    char *own = ric_strdup(key);
    if (!own || !grow((void **)&r->tasks, r->n_task, sizeof *r->tasks)) {
        free(own);
        return false;
    }
    r->tasks[r->n_task++] = own;
    return true;
}

bool ric_response_did(const ric_response *r, const char *key)
{
    for (int i = 0; i < r->n_task; i++)
        if (strcmp(r->tasks[i], key) == 0) return true;
    return false;
}

/* ------------------------------------------------------------------- asking */

const ric_model *ric_response_model(const ric_response *r)
{
    return r->model;
}

const ric_response_options *ric_response_asked(const ric_response *r)
{
    return &r->asked;
}

bool ric_response_finished(const ric_response *r)
{
    return r->finished;
}

int ric_response_skipped(const ric_response *r, const char **why)
{
    *why = r->skipped ? r->skipped : "";
    return r->n_skipped;
}

int ric_response_n_curve(const ric_response *r)
{
    return r->n_curve;
}

int ric_response_n_event(const ric_response *r)
{
    return r->n_event;
}

ric_status ric_response_curve_at(const ric_response *r, int id, ric_response_curve *out)
{
    if (id < 1 || id > r->n_curve)
        return ric_fail(RIC_E_RANGE, "no curve %d; there are %d", id, r->n_curve);
    *out = r->curves[id - 1].data;
    return RIC_OK;
}

ric_status ric_response_point_at(const ric_response *r, int curve, int i, ric_response_point *out)
{
    if (curve < 1 || curve > r->n_curve)
        return ric_fail(RIC_E_RANGE, "no curve %d; there are %d", curve, r->n_curve);
    const ric_response_line *line = &r->curves[curve - 1];
    if (i < 0 || i >= line->data.n_point)
        return ric_fail(RIC_E_RANGE, "curve %d has no point %d; it has %d", curve, i,
                        line->data.n_point);
    *out = line->points[i].data;
    return RIC_OK;
}

ric_status ric_response_event_at(const ric_response *r, int id, ric_response_event *out)
{
    if (id < 1 || id > r->n_event)
        return ric_fail(RIC_E_RANGE, "no event %d; there are %d", id, r->n_event);
    *out = r->events[id - 1].data;
    return RIC_OK;
}

/* -------------------------------------------------------------------- texts */

const char *ric_response_kind_text(ric_response_kind kind)
{
    switch (kind) {
    case RIC_RESPONSE_FOLD: return "fold";
    case RIC_RESPONSE_BRANCH_POINT: return "branch-point";
    case RIC_RESPONSE_DOUBLING: return "doubling";
    case RIC_RESPONSE_NEIMARK_SACKER: return "neimark-sacker";
    case RIC_RESPONSE_GRAZING: return "grazing";
    }
    return "unknown";
}

const char *ric_response_stop_text(ric_response_stop stop)
{
    switch (stop) {
    case RIC_RESPONSE_GRAZES: return "grazing";
    case RIC_RESPONSE_WINDOW: return "window";
    case RIC_RESPONSE_BUDGET: return "budget";
    case RIC_RESPONSE_CLOSED: return "closed";
    case RIC_RESPONSE_JOINS: return "event";
    case RIC_RESPONSE_FAILED: return "failed";
    }
    return "unknown";
}

/* ------------------------------------------------------------------ columns */

static const struct {
    const char *name;
    size_t offset;
    int n_dof, flights; /* width: so many times n_dof, and the flights */
} columns[] = {
#define SCALAR(name)                                                                               \
    {                                                                                              \
#name, offsetof(ric_response_point, name), 0, 0                                            \
    }
#define NUMBERS_OF(name, n_dof, flights)                                                           \
    {                                                                                              \
#name, offsetof(ric_response_point, name), n_dof, flights                                  \
    }
    SCALAR(arclength),
    SCALAR(omega),
    SCALAR(level),
    SCALAR(restitution),
    SCALAR(period),
    SCALAR(phase),
    SCALAR(residual),
    SCALAR(largest),
    SCALAR(reach),
    SCALAR(approach),
    NUMBERS_OF(state, 2, 0),
    NUMBERS_OF(flights, 0, 1),
    NUMBERS_OF(multipliers, 4, 0),
    NUMBERS_OF(peak, 1, 0),
    NUMBERS_OF(rms, 1, 0),
};

enum { N_COLUMN = sizeof columns / sizeof *columns, STABLE = N_COLUMN };

static ric_status find_column(const char *name, int *out)
{
    char all[400] = "";
    for (int i = 0; i < N_COLUMN; i++) {
        if (!strcmp(name, columns[i].name)) return *out = i, RIC_OK;
        snprintf(all + strlen(all), sizeof all - strlen(all), "%s, ", columns[i].name);
    }
    if (!strcmp(name, "stable")) return *out = STABLE, RIC_OK;
    return ric_fail(RIC_E_RANGE, "no column '%s': a point of a response has %sstable", name, all);
}

ric_status ric_response_column(const ric_response *r, int curve, const char *name, int *width,
                               double *out)
{
    int c = 0;
    ric_response_curve line = {0};
    ric_status status = ric_response_curve_at(r, curve, &line);
    if (!status) status = find_column(name, &c);
    if (status) return status;
    const bool list = c != STABLE && (columns[c].n_dof || columns[c].flights);
    const size_t n = list ? (size_t)(columns[c].n_dof * ric_model_n_dof(r->model)) +
                                (columns[c].flights ? flights_of(line.letters) : 0)
                          : 1;
    *width = (int)n;
    for (int i = 0; out && i < line.n_point; i++) {
        const ric_response_point *p = &r->curves[curve - 1].points[i].data;
        const char *at = (const char *)p + (c == STABLE ? 0 : columns[c].offset);
        if (c == STABLE) out[i] = p->stable;
        else if (list)
            memcpy(out + (size_t)i * n, *(const double *const *)(const void *)at, n * sizeof *out);
        else out[i] = *(const double *)(const void *)at;
    }
    return RIC_OK;
}
