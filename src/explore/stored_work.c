/* Every row of stored work is read as the run will read it, and let go again: a run that comes upon
 * a damaged one only when it asks for it has by then changed the file. */
#include "stored_work.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "branch/room.h"
#include "model/room.h"

/* Largest factor of a multiplication in a study, and so in a key; room for the list of them is
 * taken by it. */
#define MULTIPLY_MOST 1000
/* Places of the words of a key of a trace, between spaces (graph_trace.c): the factor, and behind
 * the number of the word that of the energies and frequencies that are asked for. */
enum { WORD_OF_FACTOR = 12, WORD_OF_ASKED = 14 };

typedef struct {
    ric_store *store;
    const ric_model *model;
    ric_limits limits; /* of the study */
} judge;

/* Word `place` of a key, behind its spaces; "" where there are fewer. */
static const char *word_of(const char *key, int place)
{
    for (; place > 0 && key; place--) key = (key = strchr(key, ' ')) ? key + 1 : NULL;
    return key ? key : "";
}

/* The limits that a key stands for, as far as bytes depend on them. Energies and frequencies of
 * another study are not known here: how many they are is left open, and a run of this study does
 * not ask for these bytes. */
static bool limits_of(const judge *j, const char *key, ric_limits *limits)
{
    char own[20], *end;
    const char *factor = word_of(key, WORD_OF_FACTOR), *asked = word_of(key, WORD_OF_ASKED);
    const long multiply = strtol(factor, &end, 10);
    if (end == factor || (*end && *end != ' ') || multiply < 0 || multiply > MULTIPLY_MOST)
        return false;
    *limits = j->limits;
    limits->multiply = (int)multiply;
    const size_t n = strspn(asked, "0123456789abcdef");
    const bool is_asked = n == 16 && (!asked[n] || asked[n] == ' ');
    snprintf(own, sizeof own, "%016" PRIx64,
             ric_user_point_key(j->limits.n_asked, j->limits.asked));
    if (!is_asked) limits->n_asked = 0;
    else if (strncmp(asked, own, n)) limits->n_asked = RIC_USER_POINTS_MAX;
    return true;
}

static bool ends_with(const char *text, const char *ending)
{
    const size_t n = strlen(text), m = strlen(ending);
    return n >= m && !strcmp(text + n - m, ending);
}

/* What graph_trace.c keeps under a key. */
static ric_status check_trace(const judge *j, const char *key, const char *blob, size_t size)
{
    const size_t head = sizeof RIC_REFUSED - 1;
    ric_continuation *tr = NULL;
    ric_limits limits;
    int parts;
    if (!limits_of(j, key, &limits)) return RIC_E_FORMAT;
    const bool paused = ends_with(key, RIC_PAUSED);
    if (!paused &&
        (size == 0 || (size > head && !memcmp(blob, RIC_REFUSED, head)))) /* a reason is a text */
        return size == 0 || memchr(blob, 0, size) == blob + size - 1 ? RIC_OK : RIC_E_FORMAT;
    ric_status status = paused ? ric_continuation_resume(j->model, &limits, blob, size, &parts, &tr)
                               : ric_continuation_unpack(j->model, &limits, blob, size, &tr);
    ric_continuation_free(tr);
    return status;
}

/* What junction_row_labels.c keeps under a key. */
static ric_status check_label(const char *blob, size_t size)
{
    int32_t label[3];
    if (size != sizeof label) return RIC_E_FORMAT;
    memcpy(label, blob, sizeof label);
    return label[0] >= 1 && label[1] >= 1 && (label[2] == 0 || label[2] == 1) ? RIC_OK
                                                                              : RIC_E_FORMAT;
}

static ric_status check_one(void *user, const char *key)
{
    const judge *j = user;
    void *blob = NULL;
    size_t size;
    ric_status status = ric_store_trace_get(j->store, key, &blob, &size);
    if (!status)
        status = strncmp(key, RIC_LABEL, sizeof RIC_LABEL - 1) ? check_trace(j, key, blob, size)
                                                               : check_label(blob, size);
    free(blob);
    return status && status != RIC_E_NOMEM
               ? ric_store_refuse(j->store, "trace", key, "stored work that no run can have kept")
               : status;
}

ric_status ric_stored_work_check(ric_store *store, const ric_study *study)
{
    judge j = {.store = store, .model = ric_study_model(study)};
    bool same;
    ric_status status = ric_store_is_solver(store, ric_continuation_version(), &same);
    if (status || !same) return status;
    j.limits.n_asked = ric_user_point_list(ric_study_options(study), j.limits.asked);
    return ric_store_trace_keys(store, "", check_one, &j);
}
