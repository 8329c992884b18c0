#include "floquet_again.h"

#include <stdlib.h>
#include <string.h>

#include "base/room.h"
#include "floquet_sharp.h"

enum { KEPT = 4, FLIGHTS = 64 }; /* the last KEPT are kept, of so many flights at most */

/* What an answer follows from: all of it is compared, bit by bit. */
typedef struct {
    const ric_model *model;
    uint64_t closed;
    double enough, sharp, tau[FLIGHTS];
    int form[5], face[FLIGHTS + 1];
} origin;

typedef struct {
    origin from;
    ric_floquet said;
    double *state, *rho, *own, *own_error, *each;
} answer;

struct ric_floquet_again {
    int n, n_pair; /* n: made so far; number i is at i % KEPT */
    answer answers[KEPT];
    double numbers[];
};

bool ric_floquet_again_create(int n, ric_floquet_again **out)
{
    const size_t k = (size_t)n - 1, each = 2 * (size_t)n + 6 * k;
    *out = NULL;
    if (n < 3) return true;
    ric_floquet_again *again = ric_calloc(1, sizeof *again + KEPT * each * sizeof(double));
    if (!again) return false;
    again->n_pair = n - 1;
    for (size_t i = 0; i < KEPT; i++) {
        answer *a = &again->answers[i];
        a->state = again->numbers + i * each;
        a->rho = a->state + 2 * (size_t)n;
        a->own = a->rho + 2 * k;
        a->own_error = a->own + 2 * k;
        a->each = a->own_error + k;
    }
    *out = again;
    return true;
}

void ric_floquet_again_free(ric_floquet_again *again)
{
    free(again);
}

static void take(const ric_shooting *c, const ric_floquet *f, origin *out)
{
    const size_t flights = (size_t)c->n_flight;
    memset(out, 0, sizeof *out);
    out->model = c->model;
    out->closed = c->closed[0];
    out->enough = f->enough;
    out->sharp = ric_floquet_sharpens(f->n_pair) ? f->sharp : 0; /* elsewhere it says nothing */
    memcpy(out->tau, c->tau, flights * sizeof *out->tau);
    memcpy(out->form, (int[]){c->n_flight, (int)c->start, (int)c->end, c->sigma, c->multiple},
           sizeof out->form);
    memcpy(out->face, c->face, (flights + 1) * sizeof *out->face);
}

static bool is_kept(const ric_floquet_again *again, const ric_shooting *c, const ric_floquet *f)
{
    return again && c->n_flight <= FLIGHTS && !f->orbit && !f->coarse;
}

bool ric_floquet_again_find(const ric_floquet_again *again, const ric_shooting *c, ric_floquet *f)
{
    origin from;
    if (!is_kept(again, c, f)) return false;
    const size_t k = (size_t)again->n_pair, state = 2 * (k + 1) * sizeof(double);
    take(c, f, &from);
    for (int i = again->n - 1; i >= 0 && i >= again->n - KEPT; i--) {
        const answer *a = &again->answers[i % KEPT];
        if (memcmp(&a->from, &from, sizeof from) != 0 || memcmp(a->state, c->w, state) != 0)
            continue;
        const double sharp = f->sharp;
        *f = a->said;
        f->sharp = sharp;
        memcpy(f->rho, a->rho, 2 * k * sizeof *f->rho);
        memcpy(f->own, a->own, 2 * k * sizeof *f->own);
        memcpy(f->own_error, a->own_error, k * sizeof *f->own_error);
        memcpy(f->each, a->each, k * sizeof *f->each);
        return true;
    }
    return false;
}

void ric_floquet_again_keep(ric_floquet_again *again, const ric_shooting *c, const ric_floquet *f)
{
    if (!is_kept(again, c, f)) return;
    const size_t k = (size_t)again->n_pair;
    answer *a = &again->answers[again->n++ % KEPT];
    take(c, f, &a->from);
    a->said = *f;
    memcpy(a->state, c->w, 2 * (k + 1) * sizeof *a->state);
    memcpy(a->rho, f->rho, 2 * k * sizeof *a->rho);
    memcpy(a->own, f->own, 2 * k * sizeof *a->own);
    memcpy(a->own_error, f->own_error, k * sizeof *a->own_error);
    memcpy(a->each, f->each, k * sizeof *a->each);
}
