#include "floquet_known.h"

#include <stdlib.h>
#include <string.h>

#include "base/room.h"

enum { MODES = 2, MAPS = 8, FLIGHTS = 64 }; /* the last MAPS are kept, of so many flights at most */

/* What a map follows from: all of it is compared, bit by bit. */
typedef struct {
    const ric_model *model;
    uint64_t closed;
    double state[2 * MODES], start[MODES], end[MODES], tau[FLIGHTS];
    int form[3], face[FLIGHTS + 1];
} origin;

typedef struct {
    origin from;
    ric_fine_real P[4];
    double size;
} map;

struct ric_floquet_known {
    int n; /* made so far: number i is at i % MAPS */
    map maps[MAPS];
};

bool ric_floquet_known_create(int n, ric_floquet_known **out)
{
    *out = n == MODES ? ric_malloc(sizeof **out) : NULL;
    if (*out) (*out)->n = 0;
    return *out || n != MODES;
}

void ric_floquet_known_free(ric_floquet_known *known)
{
    free(known);
}

static void take(const ric_shooting *c, const double *start, const double *end, origin *out)
{
    const size_t flights = (size_t)c->n_flight;
    memset(out, 0, sizeof *out);
    out->model = c->model;
    out->closed = c->closed[0];
    memcpy(out->form, (int[]){c->n_flight, (int)c->start, (int)c->end}, sizeof out->form);
    memcpy(out->state, c->w, sizeof out->state);
    if (start) memcpy(out->start, start, sizeof out->start);
    if (end) memcpy(out->end, end, sizeof out->end);
    memcpy(out->tau, c->tau, flights * sizeof *out->tau);
    memcpy(out->face, c->face, (flights + 1) * sizeof *out->face);
}

bool ric_floquet_known_map(ric_floquet_known *known, const ric_shooting *c, const double *start,
                           const double *end, ric_fine_real *store, double *size)
{
    origin from;
    if (!known || c->n_flight > FLIGHTS)
        return ric_floquet_fine_map(c, NULL, start, end, store, size);
    take(c, start, end, &from);
    for (int i = known->n - 1; i >= 0 && i >= known->n - MAPS; i--) {
        const map *old = &known->maps[i % MAPS];
        if (memcmp(&old->from, &from, sizeof from) != 0) continue;
        memcpy(store, old->P, sizeof old->P);
        *size = old->size;
        return true;
    }
    if (!ric_floquet_fine_map(c, NULL, start, end, store, size)) return false;
    map *made = &known->maps[known->n++ % MAPS];
    made->from = from;
    memcpy(made->P, store, sizeof made->P);
    made->size = *size;
    return true;
}
