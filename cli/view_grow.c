/* The living atlas: further departures with larger budgets, in a thread of their own, saved into the atlas. */
#define _POSIX_C_SOURCE 200809L

#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../src/study.h"
#include "view.h"

#define SAME 1e-7 /* relative: ends of a branch in two runs, of which one met more junctions on the way */

struct view_grower {
    view_shelf *shelf;
    int workers;
    pthread_t thread;
    pthread_mutex_t lock;
    bool begun, running, stop; /* a thread was started and not joined; it works; it is asked to stop */
    bool restoring;
    double seconds;
    view_budgets budgets;
    ric_progress progress;
    char message[400];         /* how the last one ended, "" before the first */
    bool failed;
};

ric_status view_grower_create(view_shelf *shelf, int workers, view_grower **out)
{
    view_grower *g = calloc(1, sizeof *g);
    *out = g;
    if (!g)
        return RIC_E_NOMEM;
    g->shelf = shelf;
    g->workers = workers;
    pthread_mutex_init(&g->lock, NULL);
    return RIC_OK;
}

void view_grower_stop(view_grower *g)
{
    pthread_mutex_lock(&g->lock);
    g->stop = g->running;
    pthread_mutex_unlock(&g->lock);
}

void view_grower_free(view_grower *g)
{
    if (!g)
        return;
    view_grower_stop(g);
    if (g->begun)
        pthread_join(g->thread, NULL);
    pthread_mutex_destroy(&g->lock);
    free(g);
}

bool view_grower_busy(view_grower *g)
{
    pthread_mutex_lock(&g->lock);
    const bool running = g->running;
    pthread_mutex_unlock(&g->lock);
    return running;
}

/* ---------------------------------------------------------------------- run */

static bool report(const ric_progress *now, void *user)
{
    view_grower *g = user;
    pthread_mutex_lock(&g->lock);
    g->progress = *now;
    const bool stop = !g->restoring && (g->stop || (g->budgets.seconds > 0 && now->seconds > g->budgets.seconds));
    pthread_mutex_unlock(&g->lock);
    return stop;
}

/* The study that the atlas holds. */
static ric_status study_of(view_grower *g, const view_data *data, ric_study **out)
{
    return ric_study_parse(ric_study_text(ric_atlas_study(data->atlas)), view_shelf_path(g->shelf), ".", out);
}

static ric_status raise_budget(ric_study *study, const char *key, int value)
{
    char text[24];
    snprintf(text, sizeof text, "%d", value);
    return value ? ric_study_override(study, "explore", key, text, key) : RIC_OK;
}

static int wanted(int budget)
{
    return budget ? budget : RIC_REGION_SAME;
}

static ric_status raise_budgets(ric_study *study, const view_budgets *b)
{
    if (b->somewhere)
        return ric_study_add_region(study, &(ric_region){.energy = {b->energy[0], b->energy[1]},
                                                         .frequency = {b->frequency[0], b->frequency[1]},
                                                         .depth = wanted(b->depth), .impacts = wanted(b->impacts),
                                                         .multiply = wanted(b->multiply)});
    ric_status status = raise_budget(study, "depth", b->depth);
    if (!status)
        status = raise_budget(study, "impacts", b->impacts);
    return status ? status : raise_budget(study, "multiply", b->multiply);
}

static ric_status explore(view_grower *g, const ric_study *study)
{
    const ric_run_options options = {.workers = g->workers, .progress = report, .user = g};
    return ric_explore(study, view_shelf_path(g->shelf), &options);
}

static bool close_to(double a, double b)
{
    return fabs(a - b) <= SAME * (fabs(a) + fabs(b));
}

/* Whether two branches of different runs are the same curve. */
static bool same_branch(const ric_branch *a, const ric_branch *b)
{
    return a->letters == b->letters && a->symmetric == b->symmetric && a->mode == b->mode &&
           !memcmp(a->word, b->word, (size_t)a->letters * sizeof *a->word) && close_to(a->energy_min, b->energy_min) &&
           close_to(a->energy_max, b->energy_max) && close_to(a->frequency_min, b->frequency_min) &&
           close_to(a->frequency_max, b->frequency_max);
}

/* Whether every branch of `small` is in `large`. */
static bool contains(const ric_atlas *large, const ric_atlas *small)
{
    const int n = ric_atlas_n_branch(large);
    for (int id = 1; id <= ric_atlas_n_branch(small); id++) {
        ric_branch a, b;
        bool found = false;
        if (ric_atlas_branch(small, id, &a))
            return false;
        for (int k = 1; k <= n && !found; k++) /* numbers shift a little, so that it is mostly near */
            found = !ric_atlas_branch(large, 1 + (id - 1 + k - 1) % n, &b) && same_branch(&a, &b);
        if (!found)
            return false;
    }
    return true;
}

/* An extension that was stopped has written what it had, which may lack branches that were there, because larger
 * budgets shape them anew. Its finished work is kept in the file for the next time, but the tables then go back to the
 * study of before, which costs no tracing. */
static ric_status put_back(view_grower *g, const ric_study *before, const ric_atlas *old, bool *done)
{
    ric_atlas *atlas = NULL;
    ric_status status = ric_atlas_read(view_shelf_path(g->shelf), &atlas);
    *done = !status && !contains(atlas, old);
    ric_atlas_free(atlas);
    if (!*done)
        return status;
    pthread_mutex_lock(&g->lock);
    g->restoring = true;
    pthread_mutex_unlock(&g->lock);
    return explore(g, before);
}

static void finish(view_grower *g, ric_status status, int n_before, bool restored)
{
    char message[sizeof g->message];
    view_data *data = NULL;
    snprintf(message, sizeof message, "%s",
             status && status != RIC_E_INTERRUPTED ? (ric_detail()[0] ? ric_detail() : ric_status_text(status)) : "");
    if (!message[0] && (status = view_shelf_reload(g->shelf) ? RIC_E_IO : status) == RIC_E_IO)
        snprintf(message, sizeof message, "%s", ric_detail());
    const bool failed = message[0];
    if (!failed) {
        data = view_data_take(g->shelf);
        const int n = ric_atlas_n_branch(data->atlas) - n_before;
        if (restored)
            snprintf(message, sizeof message,
                     "stopped early: the atlas is as before, and the work that was finished is kept in it for the next "
                     "time");
        else
            snprintf(message, sizeof message, "%s%d new branch%s", status ? "stopped: " : "", n, n == 1 ? "" : "es");
        view_data_release(g->shelf, data);
    }
    pthread_mutex_lock(&g->lock);
    memcpy(g->message, message, sizeof message);
    g->failed = failed;
    g->running = false;
    pthread_mutex_unlock(&g->lock);
}

static void *work(void *user)
{
    view_grower *g = user;
    ric_study *before = NULL, *larger = NULL;
    bool restored = false;
    view_data *data = view_data_take(g->shelf);
    const int n_before = ric_atlas_n_branch(data->atlas);
    ric_status status = study_of(g, data, &before);
    if (!status)
        status = study_of(g, data, &larger);
    if (!status)
        status = raise_budgets(larger, &g->budgets);
    if (!status)
        status = explore(g, larger);
    if (status == RIC_E_INTERRUPTED) {
        const ric_status back = put_back(g, before, data->atlas, &restored);
        status = back ? back : status;
    }
    view_data_release(g->shelf, data);
    finish(g, status, n_before, restored);
    ric_study_free(before);
    ric_study_free(larger);
    return NULL;
}

/* ------------------------------------------------------------------ request */

static bool shrinks(int wanted, int present)
{
    return wanted && (wanted < present || wanted < 0);
}

static bool is_window(const double window[2])
{
    return window[0] >= 0 && window[0] < window[1] && window[1] <= 1e12; /* as a study has it; false for NaN */
}

/* Only larger ones: smaller budgets would take branches out of the atlas. In a region the larger of its own and the
 * study's holds. */
static ric_status check(view_grower *g, const view_budgets *b)
{
    if (b->somewhere)
        return is_window(b->energy) && is_window(b->frequency) && b->frequency[0] > 0 ? RIC_OK : RIC_E_INPUT;
    view_data *data = view_data_take(g->shelf);
    const ric_explore_options o = *ric_study_options(ric_atlas_study(data->atlas));
    view_data_release(g->shelf, data);
    const bool depth = b->depth && (o.depth == 0 || shrinks(b->depth, o.depth));
    return depth || shrinks(b->impacts, o.impacts) || shrinks(b->multiply, o.multiply) ? RIC_E_INPUT : RIC_OK;
}

ric_status view_grower_start(view_grower *g, const view_budgets *budgets)
{
    ric_status status = check(g, budgets);
    if (status)
        return status;
    pthread_mutex_lock(&g->lock);
    if (g->running) {
        pthread_mutex_unlock(&g->lock);
        return RIC_E_BUSY;
    }
    if (g->begun)
        pthread_join(g->thread, NULL);
    g->budgets = *budgets;
    g->stop = g->restoring = g->failed = false;
    g->progress = (ric_progress){0};
    g->message[0] = '\0';
    g->running = g->begun = !pthread_create(&g->thread, NULL, work, g);
    status = g->running ? RIC_OK : RIC_E_NOMEM;
    pthread_mutex_unlock(&g->lock);
    return status;
}

json_t *view_grower_status(view_grower *g)
{
    pthread_mutex_lock(&g->lock);
    const ric_progress *p = &g->progress;
    json_t *object = json_pack("{s:b,s:b,s:b,s:b,s:s,s:i,s:i,s:i,s:i,s:f}", "running", g->running, "stopping",
                               g->stop && g->running, "restoring", g->restoring && g->running, "failed", g->failed,
                               "message", g->message, "branches", p->branches, "junctions", p->junctions, "open",
                               p->open, "depth", p->depth, "seconds", p->seconds);
    pthread_mutex_unlock(&g->lock);
    return object;
}
