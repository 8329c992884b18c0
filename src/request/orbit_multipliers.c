/* Multipliers of many stored points of a branch, by several threads: those of the orbits that
 * ric_orbit_find gives, to the bit, without what else it finds out about an orbit. Those of two
 * modes follow from the stored trace: a million points take a quarter of a second, where an orbit
 * that is flown takes 30 microseconds. */
#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>

#include "atlas/room.h"
#include "base/room.h"
#include "branch/room.h"
#include "model/room.h"
#include "stored.h"

typedef struct {
    const ric_atlas *atlas;
    ric_branch branch;
    int first, n;
    int part;     /* points that a thread takes at a time */
    size_t width; /* numbers of a point */
    double *out;
    atomic_int next, wrong; /* next points to be taken; the least one that failed, n: none */
} row;

enum {
    AT_A_TIME = 64
}; /* of two modes, where most points take less than it takes threads to tell each other */

static ric_status of_linear(const row *r, int i, double *out)
{
    int n;
    ric_orbit **found = NULL;
    ric_status status = ric_orbit_find(r->atlas, r->branch.id, RIC_AT_POINT, i, &n, &found);
    if (!status) status = ric_orbit_multipliers(found[0], out);
    ric_orbits_free(n, found);
    return status;
}

static ric_status of_point(const row *r, int i, double *out)
{
    const ric_model *m = ric_atlas_model(r->atlas);
    const ric_branch *b = &r->branch;
    ric_periodic *cycle = NULL;
    ric_shooting *chain = NULL;
    ric_floquet floquet = {0};
    ric_point point;
    ric_turn turn;
    double *u = NULL;
    ric_status status = ric_stored_cycle(r->atlas, b, i, &point, &cycle);
    if (!status) status = ric_stored_symmetries(r->atlas, b, i, cycle);
    if (!status) status = ric_stored_chain(m, b, i, cycle, &chain, &u);
    if (!status && !ric_turn_find(m, chain, u, cycle, &turn))
        status = ric_fail(RIC_E_NUMERIC,
                          "a stored orbit of branch %d does not fit its own symmetries", b->id);
    if (!status) status = ric_floquet_create(m->n, &floquet);
    if (!status) status = ric_continuation_multipliers(chain, u, &floquet);
    if (!status) ric_floquet_multipliers(&floquet, out);
    status = ric_trust(status);
    ric_floquet_release(&floquet);
    ric_shooting_free(chain);
    ric_periodic_free(cycle);
    free(u);
    return status;
}

/* Where none can be computed there are none; anything else is an error. */
static ric_status fill(const row *r, int i)
{
    double *out = r->out + (size_t)i * r->width;
    const ric_model *m = ric_atlas_model(r->atlas);
    ric_point point;
    const bool linear = ric_branch_linear(m, &r->branch);
    ric_status status = ric_atlas_point(r->atlas, r->branch.id, r->first + i, &point, NULL, NULL);
    if (status || (!linear && ric_stored_multipliers(m, &point, out))) return status;
    status = linear ? of_linear(r, r->first + i, out) : of_point(r, r->first + i, out);
    for (size_t k = 0; status && k < r->width; k++) out[k] = NAN;
    return status == RIC_E_NUMERIC ? RIC_OK : status;
}

static void *work(void *user)
{
    row *r = user;
    for (int i = atomic_fetch_add(&r->next, r->part); i < r->n;
         i = atomic_fetch_add(&r->next, r->part))
        for (int j = i; j < r->n && j < i + r->part; j++) {
            if (!fill(r, j)) continue;
            int least = atomic_load(&r->wrong);
            while (j < least && !atomic_compare_exchange_weak(&r->wrong, &least, j)) {
            }
            atomic_store(&r->next, r->n);
            return NULL;
        }
    return NULL;
}

ric_status ric_atlas_multipliers(const ric_atlas *a, int branch, int first, int n, int workers,
                                 double *out)
{
    row r = {.atlas = a, .first = first, .n = n, .out = out};
    ric_status status = ric_atlas_branch(a, branch, &r.branch);
    if (status) return status;
    if (first < 0 || n < 0 || n > r.branch.n_point - first)
        return ric_fail(RIC_E_RANGE, "branch %d has no points %d to %d; they run from 0 to %d",
                        branch, first, first + n - 1, r.branch.n_point - 1);
    const int modes = ric_model_n_mode(ric_atlas_model(a));
    if (modes < 2) return RIC_OK;
    r.part = modes == 2 ? AT_A_TIME : 1;
    const int parts = n / r.part + 1, wanted = workers < parts ? workers : parts;
    r.width = 4 * (size_t)(modes - 1);
    atomic_init(&r.next, 0);
    atomic_init(&r.wrong, n);
    int started = 0;
    pthread_t *threads = wanted > 1 ? ric_calloc((size_t)wanted, sizeof *threads) : NULL;
    while (threads && started < wanted - 1 && !pthread_create(&threads[started], NULL, work, &r))
        started++;
    work(&r);
    for (int i = 0; i < started; i++) pthread_join(threads[i], NULL);
    free(threads);
    /* what is wrong is said by this thread, which meets it once more */
    return atomic_load(&r.wrong) < n ? fill(&r, atomic_load(&r.wrong)) : RIC_OK;
}
