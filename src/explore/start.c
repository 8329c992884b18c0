#include "start.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "branch/room.h"

#define LONGEST 4096 /* impacts: explore.impacts goes no further */

void ric_starts_release(ric_starts *s)
{
    for (int i = 0; i < s->n; i++) ric_periodic_free(s->cycle[i]);
    free(s->cycle);
    *s = (ric_starts){0};
}

/* ------------------------------------------------------------------- text */

static bool take_integer(const char **text, long min, long max, int *out)
{
    char *end;
    long value = strtol(*text, &end, 10);
    if (end == *text || value < min || value > max) return false;
    *text = end;
    *out = (int)value;
    return true;
}

static bool take_number(const char **text, double *out)
{
    char *end;
    *out = ric_c_strtod(*text, &end);
    if (end == *text || !isfinite(*out)) return false;
    *text = end;
    return true;
}

static bool take_cycle(const ric_model *m, const char **text, int half, ric_periodic *c)
{
    int n = m->n_dof;
    double state[2 * n];
    c->half = half;
    for (int i = 0; i < c->N; i++)
        if (!take_integer(text, 0, m->n_face - 1, &c->face[i])) return false;
    for (int i = 0; i < c->N; i++) {
        if (!take_number(text, &c->tau[i]) || !(c->tau[i] > 0)) return false;
        c->tau[i] *= m->omega_ref;
    }
    for (int i = 0; i < 2 * n; i++)
        if (!take_number(text, &state[i])) return false;
    ric_model_from_state(m, state, state + n, c->w);
    *text += strspn(*text, " ");
    if (**text == '\n') ++*text;
    else if (**text) return false;
    return true;
}

static ric_status take_line(const ric_model *m, const char **text, ric_periodic **out)
{
    int N, half, pure, flip;
    *out = NULL;
    if (!take_integer(text, 1, LONGEST, &N) || !take_integer(text, 0, 1, &half) ||
        !take_integer(text, -1, N - 1, &pure) || !take_integer(text, -1, N - 1, &flip))
        return ric_fail(RIC_E_FORMAT, "a given start is not readable");
    if (!(*out = ric_periodic_create(m->n, N))) return ric_no_memory("a start");
    if (!take_cycle(m, text, half, *out) ||
        ((half || flip >= 0) && !ric_periodic_mirrors(m, *out))) {
        ric_periodic_free(*out);
        *out = NULL;
        return ric_fail(RIC_E_FORMAT, "a given start of %d impacts is not readable", N);
    }
    (*out)->pure = pure;
    (*out)->flip = flip;
    return RIC_OK;
}

ric_status ric_starts_parse(const ric_model *m, const char *text, ric_starts *out)
{
    ric_status status = RIC_OK;
    int capacity = 0;
    *out = (ric_starts){0};
    while (text && *text && !status) {
        if (out->n == capacity) {
            capacity = capacity ? 2 * capacity : 16;
            ric_periodic **grown = ric_realloc(out->cycle, (size_t)capacity * sizeof *grown);
            if (!grown) status = ric_no_memory("starts");
            else out->cycle = grown;
        }
        if (!status && !(status = take_line(m, &text, &out->cycle[out->n]))) out->n++;
    }
    if (status) ric_starts_release(out);
    return status;
}

char *ric_start_line(int n_dof, int N, bool half, int pure, int flip, const int *word,
                     const double *flights, const double *x, const double *v)
{
    ric_buffer line;
    if (!ric_buffer_open(&line)) return NULL;
    FILE *out = line.file;
    locale_t before = ric_c_locale_enter();
    fprintf(out, "%d %d %d %d", N, half, pure, flip);
    for (int i = 0; i < N; i++) fprintf(out, " %d", word[i]);
    for (int i = 0; i < N; i++) fprintf(out, " %a", flights[i]);
    for (int i = 0; i < n_dof; i++) fprintf(out, " %a", x[i]);
    for (int i = 0; i < n_dof; i++) fprintf(out, " %a", v[i]);
    fprintf(out, "\n");
    ric_c_locale_leave(before);
    return ric_buffer_take(&line);
}

/* ------------------------------------------------------------------- solve */

ric_status ric_start_solve(const ric_model *m, const ric_periodic *given, ric_periodic **out)
{
    ric_shooting *chain = NULL;
    double *u = NULL, *work = NULL;
    int iterations;
    *out = NULL;
    ric_status status = ric_periodic_to_chain(m, given, &chain, &u);
    if (status) goto out;
    int size = chain->n_unknown;
    if (!(work = ric_malloc(2 * (size_t)size * sizeof *work))) {
        status = ric_no_memory("a start");
        goto out;
    }
    memcpy(work, u, (size_t)size * sizeof *work);
    bool solved = ric_continuation_correct(chain, u, NULL, NULL, 0, work + size, &iterations);
    double moved = 0;
    for (int i = 0; i < size; i++) moved = fmax(moved, fabs(u[i] - work[i]));
    if (!solved || !(moved < RIC_SAME_LOCATED * chain->scale))
        status =
            ric_fail(RIC_E_NUMERIC,
                     "a given start of %d impacts is no orbit: it moves by %.3g when it is solved",
                     given->N, moved);
    else if (!(*out = ric_periodic_from_chain(chain, u))) status = ric_no_memory("a start");
out:
    ric_shooting_free(chain);
    free(u);
    free(work);
    return status;
}
