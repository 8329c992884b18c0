/* The living atlas: further departures with larger budgets, in a thread of their own, saved into
 * the atlas. */
#define _POSIX_C_SOURCE 200809L

#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "atlas/atlas.h"
#include "explore/remote.h"
#include "base/status.h"
#include "study/study.h"
#include "view.h"

/* SHARE: an extension lasts at least so many times as long as it takes to come to something new */
#define SHARE 1.25

enum { UNDO_MOST = 16 };

/* The texts of the study before and after an extension. */
typedef struct {
    char *before, *after;
} step;

struct view_grower {
    view_shelf *shelf;
    int workers;
    pthread_t thread;
    pthread_mutex_t lock;
    bool begun, running,
        stop;             /* a thread was started and not joined; it works; it is asked to stop */
    bool leaving;         /* the server ends */
    bool undoing;         /* the running thread goes back */
    step undo[UNDO_MOST]; /* the extensions that can be taken back, the last one at the end */
    int n_undo;
    const ric_atlas
        *before; /* of the running thread: what is extended, and whether it was left as it is */
    bool kept;
    double news; /* seconds until the extension came to something that was not done before; 0: not
                    yet */
    double seconds;
    view_budgets budgets;
    ric_progress progress;
    char message[400]; /* how the last one ended, "" before the first */
    bool failed;
};

ric_status view_grower_create(view_shelf *shelf, int workers, view_grower **out)
{
    view_grower *g = calloc(1, sizeof *g);
    *out = g;
    if (!g) return RIC_E_NOMEM;
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

void view_grower_leave(view_grower *g)
{
    pthread_mutex_lock(&g->lock);
    g->stop = g->running;
    g->leaving = true;
    pthread_mutex_unlock(&g->lock);
}

static void drop_step(view_grower *g, int i)
{
    free(g->undo[i].before);
    free(g->undo[i].after);
    memmove(g->undo + i, g->undo + i + 1, (size_t)(--g->n_undo - i) * sizeof *g->undo);
}

void view_grower_free(view_grower *g)
{
    if (!g) return;
    view_grower_leave(g);
    if (g->begun) pthread_join(g->thread, NULL);
    while (g->n_undo > 0) drop_step(g, 0);
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
    if (now->fresh && g->news == 0) g->news = now->seconds;
    /* as `ricochet run --seconds`: whoever is stopped on the way to where he was never comes
     * further */
    const bool over = g->budgets.seconds > 0 && now->fresh &&
                      now->seconds > fmax(g->budgets.seconds, SHARE * g->news);
    const bool stop = g->stop || over;
    pthread_mutex_unlock(&g->lock);
    return stop;
}

/* The study that the atlas holds; to go back, the one that it held before. */
static ric_status study_of(view_grower *g, const view_data *data, ric_study **out)
{
    const char *text = g->undoing ? g->undo[g->n_undo - 1].before
                                  : ric_study_text(ric_atlas_study(data->atlas));
    return ric_study_parse(text, view_shelf_path(g->shelf), ".", out);
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
        return ric_study_add_region(study,
                                    &(ric_region){.energy = {b->energy[0], b->energy[1]},
                                                  .frequency = {b->frequency[0], b->frequency[1]},
                                                  .depth = wanted(b->depth),
                                                  .impacts = wanted(b->impacts),
                                                  .multiply = wanted(b->multiply)});
    ric_status status = raise_budget(study, "depth", b->depth);
    if (!status) status = raise_budget(study, "impacts", b->impacts);
    return status ? status : raise_budget(study, "multiply", b->multiply);
}

/* What an extension has found until it is stopped may lack branches that were there, because larger
 * budgets shape them anew: then the atlas stays as it was, and the finished work is kept in the
 * file for the next time. So it does when the server ends, which shall not take the time to write.
 */
static bool worth(void *user, const ric_atlas *unfinished)
{
    view_grower *g = user;
    pthread_mutex_lock(&g->lock);
    const bool leaving = g->leaving;
    pthread_mutex_unlock(&g->lock);
    g->kept = leaving || g->undoing || !ric_atlas_contains(unfinished, g->before);
    return !g->kept;
}

static ric_status explore(view_grower *g, const ric_study *study)
{
    const ric_run_options options = {.workers = g->workers, .progress = report, .user = g};
    const ric_explore_more more = {.worth = worth, .user = g};
    return ric_explore_with(study, view_shelf_path(g->shelf), &options, &more, NULL);
}

static const char *text_of(const view_data *data)
{
    return ric_study_text(ric_atlas_study(data->atlas));
}

/* Remembers the study that the atlas had; when an extension is undone, forgets it. */
static void remember(view_grower *g, const char *before)
{
    view_data *data = view_data_take(g->shelf);
    step now = {strdup(before), strdup(text_of(data))};
    view_data_release(g->shelf, data);
    pthread_mutex_lock(&g->lock);
    if (g->undoing && g->n_undo > 0) drop_step(g, g->n_undo - 1);
    if (g->undoing || !now.before || !now.after || !strcmp(now.before, now.after)) {
        free(now.before);
        free(now.after);
    } else {
        if (g->n_undo == UNDO_MOST) drop_step(g, 0);
        g->undo[g->n_undo++] = now;
    }
    pthread_mutex_unlock(&g->lock);
}

/* The last of a thread is the lock under which it says that it runs no more: the next one waits for
 * its end in there. */
static void finish(view_grower *g, ric_status status, const view_data *before)
{
    char message[sizeof g->message];
    view_data *data = NULL;
    snprintf(message, sizeof message, "%s",
             status && status != RIC_E_INTERRUPTED
                 ? (ric_detail()[0] ? ric_detail() : ric_status_text(status))
                 : "");
    if (!message[0] && (status = view_shelf_reload(g->shelf) ? RIC_E_IO : status) == RIC_E_IO)
        snprintf(message, sizeof message, "%s", ric_detail());
    const bool failed = message[0];
    if (!failed) {
        data = view_data_take(g->shelf);
        const int n = ric_atlas_n_branch(data->atlas) - ric_atlas_n_branch(before->atlas);
        if (g->kept)
            snprintf(message, sizeof message,
                     "stopped early: the atlas is as before, and the work that was finished is "
                     "kept in it for the next "
                     "time");
        else if (g->undoing) snprintf(message, sizeof message, "undone: %d branches less", -n);
        else
            snprintf(message, sizeof message, "%s%d new branch%s", status ? "stopped: " : "", n,
                     n == 1 ? "" : "es");
        view_data_release(g->shelf, data);
        if (!g->kept) remember(g, text_of(before));
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
    ric_study *larger = NULL;
    view_data *data = view_data_take(g->shelf);
    g->before = data->atlas;
    g->kept = false;
    /* a run would begin a new one */
    ric_status status = access(view_shelf_path(g->shelf), F_OK)
                            ? ric_fail(RIC_E_IO,
                                       "%s: the file is gone, and there is nothing to extend",
                                       view_shelf_path(g->shelf))
                            : study_of(g, data, &larger);
    if (!status && !g->undoing) status = raise_budgets(larger, &g->budgets);
    if (!status) status = explore(g, larger);
    finish(g, status, data);
    view_data_release(g->shelf, data);
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
    return window[0] >= 0 && window[0] < window[1] &&
           window[1] <= 1e12; /* as a study has it; false for NaN */
}

/* Only larger ones: smaller budgets would take branches out of the atlas. In a region the larger of
 * its own and the study's holds. */
static ric_status check(view_grower *g, const view_budgets *b)
{
    if (b->somewhere)
        return is_window(b->energy) && is_window(b->frequency) && b->frequency[0] > 0 ? RIC_OK
                                                                                      : RIC_E_INPUT;
    view_data *data = view_data_take(g->shelf);
    const ric_explore_options o = *ric_study_options(ric_atlas_study(data->atlas));
    view_data_release(g->shelf, data);
    const bool depth = b->depth && (o.depth == 0 || shrinks(b->depth, o.depth));
    return depth || shrinks(b->impacts, o.impacts) || shrinks(b->multiply, o.multiply) ? RIC_E_INPUT
                                                                                       : RIC_OK;
}

static ric_status begin(view_grower *g, const view_budgets *budgets, bool undoing)
{
    ric_status status = RIC_E_BUSY;
    pthread_mutex_lock(&g->lock);
    if (!g->running && !g->leaving) {
        if (g->begun) pthread_join(g->thread, NULL);
        g->budgets = *budgets;
        g->undoing = undoing;
        g->stop = g->failed = false;
        g->news = 0;
        g->progress = (ric_progress){0};
        g->message[0] = '\0';
        g->running = g->begun = !pthread_create(&g->thread, NULL, work, g);
        status = g->running ? RIC_OK : RIC_E_NOMEM;
    }
    pthread_mutex_unlock(&g->lock);
    return status;
}

ric_status view_grower_start(view_grower *g, const view_budgets *budgets)
{
    const ric_status status = check(g, budgets);
    return status ? status : begin(g, budgets, false);
}

ric_status view_grower_undo(view_grower *g)
{
    const view_budgets none = {0};
    view_data *data = view_data_take(g->shelf);
    pthread_mutex_lock(&g->lock);
    const bool busy = g->running || g->leaving;
    while (!busy && g->n_undo > 0 && strcmp(g->undo[g->n_undo - 1].after, text_of(data)) != 0)
        drop_step(g, g->n_undo - 1); /* somebody else has gone on from there */
    const bool possible = g->n_undo > 0;
    pthread_mutex_unlock(&g->lock);
    view_data_release(g->shelf, data);
    return busy ? RIC_E_BUSY : possible ? begin(g, &none, true) : RIC_E_MISSING;
}

json_t *view_grower_status(view_grower *g)
{
    pthread_mutex_lock(&g->lock);
    const ric_progress *p = &g->progress;
    json_t *object = json_pack("{s:b,s:i,s:b,s:b,s:s,s:i,s:i,s:i,s:i,s:i,s:f}", "running",
                               g->running, "undo", g->n_undo, "stopping", g->stop && g->running,
                               "failed", g->failed, "message", g->message, "branches", p->branches,
                               "junctions", p->junctions, "open", p->open, "labels", p->labels,
                               "depth", p->depth, "seconds", p->seconds);
    pthread_mutex_unlock(&g->lock);
    return object;
}
